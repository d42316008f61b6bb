//! Bulk evaluation of noises that are written in lanes.
//!
//! A noise states its jet for a block of points as loops over lanes without branches, which the
//! compiler vectorises for the widest instruction set of the machine; a single point is a block of
//! one. Nothing is fused or reordered, so all instruction sets, and all groupings of points into
//! batches, give the same bits.

use crate::num::{Jets, Order, Point, widest};

/// Lanes a block: two vectors of the widest instruction set.
const BLOCK: usize = 16;

/// Lanes of half a block: one of its vectors.
const HALF: usize = BLOCK / 2;

/// The orders as constant parameters.
pub(super) const VALUE: u8 = 0;
pub(super) const GRADIENT: u8 = 1;
pub(super) const HESSIAN: u8 = 2;

/// A noise written in lanes, with what it needs to write on: nothing passes from block to block.
pub(super) trait Lanes {
    /// Whether Hessians are better computed half a block at a time. So are those of straight-line
    /// code too long to be unrolled: without a loop, all ten parts stay in registers until they are
    /// stored.
    const HALVES: bool = false;

    /// Jets at a block of points. `to` has room for the value; from order [`GRADIENT`] for three
    /// first derivatives; from order [`HESSIAN`] for six second derivatives.
    fn block<const ORDER: u8, const PARTS: usize, const B: usize>(
        &mut self,
        from: &[[f64; B]; 3],
        to: &mut [[f64; B]; PARTS],
    );
}

/// Jets at a batch of points; what is computed follows from what `out` has. The noise is made where it
/// runs: then the compiler sees that nobody else knows what it writes on.
pub(super) fn jets<L: Lanes>(make: impl FnOnce() -> L, at: [&[f64]; 3], out: Jets<'_>) {
    match out {
        Jets { value, grad: None, .. } => run::<VALUE, 1, BLOCK, L>(make, at, [value]),
        Jets { value, grad: Some([x, y, z]), hess: None } => {
            run::<GRADIENT, 4, BLOCK, L>(make, at, [value, x, y, z]);
        }
        Jets { value, grad: Some([x, y, z]), hess: Some([xx, yy, zz, xy, xz, yz]) } => {
            let out = [value, x, y, z, xx, yy, zz, xy, xz, yz];
            if L::HALVES {
                run::<HESSIAN, 10, HALF, L>(make, at, out);
            } else {
                run::<HESSIAN, 10, BLOCK, L>(make, at, out);
            }
        }
    }
}

/// The jet at one point.
pub(super) fn jet<L: Lanes>(mut noise: L, order: Order, at: [f64; 3]) -> Point {
    let from = at.map(|x| [x]);
    widest(
        #[inline(always)]
        || {
            let mut p = [[0.0]; 10];
            match order {
                Order::Value => noise.block::<VALUE, 10, 1>(&from, &mut p),
                Order::Gradient => noise.block::<GRADIENT, 10, 1>(&from, &mut p),
                Order::Hessian => noise.block::<HESSIAN, 10, 1>(&from, &mut p),
            }
            let [v, x, y, z, xx, yy, zz, xy, xz, yz] = p.map(|[x]| x);
            Point { value: v, grad: [x, y, z], hess: [xx, yy, zz, xy, xz, yz] }
        },
    )
}

/// Fills the `PARTS` slices, `B` lanes at a time.
#[inline(always)]
fn run<const ORDER: u8, const PARTS: usize, const B: usize, L: Lanes>(
    make: impl FnOnce() -> L,
    at: [&[f64]; 3],
    mut out: [&mut [f64]; PARTS],
) {
    widest(
        #[inline(always)]
        || {
            let mut noise = make();
            let length = at[0].len();
            let whole = length - length % B;
            for start in (0..whole).step_by(B) {
                part::<ORDER, PARTS, B, L>(&mut noise, at, start, B, &mut out);
            }
            if whole < length {
                part::<ORDER, PARTS, B, L>(&mut noise, at, whole, length - whole, &mut out);
            }
        },
    );
}

/// One block, or the last few lanes of a batch, padded, which lanes cannot notice. Blocks pass
/// through arrays of their own, so that the compiler knows that nothing overlaps.
#[inline(always)]
fn part<const ORDER: u8, const PARTS: usize, const B: usize, L: Lanes>(
    noise: &mut L,
    at: [&[f64]; 3],
    start: usize,
    count: usize,
    out: &mut [&mut [f64]; PARTS],
) {
    let mut from = [[0.0; B]; 3];
    for (own, at) in from.iter_mut().zip(at) {
        own[..count].copy_from_slice(&at[start..start + count]);
    }
    let mut to = [[0.0; B]; PARTS];
    noise.block::<ORDER, PARTS, B>(&from, &mut to);
    for (slice, part) in out.iter_mut().zip(&to) {
        slice[start..start + count].copy_from_slice(&part[..count]);
    }
}
