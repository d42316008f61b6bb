//! Points and balls, batch by batch: with room for a few on the stack, and each moved to where a noise sees it.

use crate::num::{Jets, widest};

/// Points whose scaled coordinates are held at a time.
pub(super) const BATCH: usize = 64;

/// Of so few points a whole batch is mostly room, which it takes time to clear.
pub(super) const SMALL: usize = 8;
pub(super) const MEDIUM: usize = 16;

/// Multiplies all of a slice.
#[inline(always)]
pub(super) fn times(all: &mut [f64], k: f64) {
    for i in 0..all.len() {
        all[i] *= k;
    }
}

/// Copies one batch of coordinates through `map`, which sees a point at a time.
#[inline(always)]
pub(super) fn gather<const B: usize>(
    at: [&[f64]; 3],
    start: usize,
    map: impl Fn([f64; 3]) -> [f64; 3],
) -> [[f64; B]; 3] {
    widest(
        #[inline(always)]
        || {
            let count = (at[0].len() - start).min(B);
            let [x, y, z] = at.map(|at| &at[start..start + count]);
            let mut placed = [[0.0; B]; 3];
            let [u, v, w] = &mut placed;
            for i in 0..count {
                [u[i], v[i], w[i]] = map([x[i], y[i], z[i]]);
            }
            placed
        },
    )
}

/// The part of `out` from `start`, at most `B` points. (Arrays are written out: what maps of arrays return is stored in
/// pieces and loaded as a whole, for which the processor waits.)
#[inline(always)]
pub(super) fn batch<'a, const B: usize>(out: &'a mut Jets<'_>, start: usize) -> Jets<'a> {
    let end = (start + B).min(out.value.len());
    let grad = match &mut out.grad {
        Some([x, y, z]) => Some([&mut x[start..end], &mut y[start..end], &mut z[start..end]]),
        None => None,
    };
    let hess = match &mut out.hess {
        Some([a, b, c, d, e, f]) => Some([
            &mut a[start..end],
            &mut b[start..end],
            &mut c[start..end],
            &mut d[start..end],
            &mut e[start..end],
            &mut f[start..end],
        ]),
        None => None,
    };
    Jets { value: &mut out.value[start..end], grad, hess }
}

/// Balls that a kernel is asked about at once.
pub(super) const BALLS: usize = 16;

/// Asks about balls batch by batch, by where `place` puts their centres and by their radii there; `ask` is also told the
/// number of the first one.
pub(super) fn balls(
    at: [&[f64]; 3],
    radius: &[f64],
    place: impl Fn([f64; 3], f64) -> ([f64; 3], f64),
    mut ask: impl FnMut(usize, [&[f64]; 3], &[f64]),
) {
    for first in (0..radius.len()).step_by(BALLS) {
        let (mut centres, mut reach) = ([[0.0; BALLS]; 3], [0.0; BALLS]);
        let many = BALLS.min(radius.len() - first);
        for i in 0..many {
            let (centre, own) = place(at.map(|at| at[first + i]), radius[first + i]);
            (0..3).for_each(|axis| centres[axis][i] = centre[axis]);
            reach[i] = own;
        }
        ask(first, centres.each_ref().map(|x| &x[..many]), &reach[..many]);
    }
}
