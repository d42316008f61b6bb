//! Kernels at parabolas.
//!
//! With the jet of a kernel `N` at the middles `c` of the coordinates, and a place that is `w + d |e|`
//! away at most, there are three bounds:
//!
//! ```text
//! Taylor      N(c) + grad N(c) . (x - c)  +-  M2 (w + d |e|)^2 / 2
//! Lipschitz   N(c)  +-  L (w + d |e|)
//! range       [-A, A]
//! ```
//!
//! The tightest at the ends of the piece becomes the form, or the first where it is not much wider there, since it is so in
//! the middle; the range is in all of them.

use super::batch::Parabolas;
use super::{CHARGE, Parabola, ROUND_UP, TINY, VAGUE, choose, pick};
use crate::num::number::{Growing, Jets};
use crate::num::simd::widest;
use crate::num::{Interval, Kernel, Local, Order, Point};

/// As a share of what a sag comes to at the ends, a bow that says more. Measured on flows along slopes (figure 9.9 of the
/// thesis, 160x160): with 0.75 its rays take 1.78 million evaluations, with 1, or without any sag, 2.16 million.
const OWN: f64 = 0.75;

/// How far a point reaches from the middle, as lengths of vectors.
#[derive(Clone, Copy)]
struct Reach {
    /// Along the line, at its ends.
    along: f64,
    /// Across it, and by not being known.
    beside: f64,
}

impl Reach {
    #[inline(always)]
    fn new<const K: usize>(p: &[Parabola<K>; 3]) -> Reach {
        let (mut along, mut beside) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let p = &p[axis];
            along[axis] = p.mid[1].abs() + p.bent();
            beside[axis] = p.off_middle();
        }
        Reach { along: norm(along), beside: norm(beside) }
    }

    #[inline(always)]
    fn whole(self) -> f64 {
        (self.along + self.beside) * ROUND_UP
    }
}

#[inline(always)]
fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt() * ROUND_UP
}

/// Largest coordinate.
#[inline(always)]
fn size([x, y, z]: [f64; 3]) -> f64 {
    let larger = |a: f64, b: f64| choose(a > b, a, b);
    larger(larger(x.abs(), y.abs()), z.abs())
}

impl<const B: usize, const K: usize> Parabolas<B, K> {
    /// A lane of three coordinates.
    #[inline(always)]
    fn place(p: &[&Self; 3], i: usize) -> [Parabola<K>; 3] {
        [p[0].lane(i), p[1].lane(i), p[2].lane(i)]
    }

    /// Writes the image of a point under a kernel to `out`.
    pub(super) fn image<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3], out: &mut Self) {
        let bounds = k.bounds();
        let mut reaches = [Reach { along: 0.0, beside: 0.0 }; B];
        let (mut along, mut beside) = ([0.0; B], [0.0; B]);
        widest(
            #[inline(always)]
            || {
                for i in 0..B {
                    let own = Reach::new(&Self::place(&p, i));
                    (along[i], beside[i]) = (own.along, own.beside);
                }
            },
        );
        for i in 0..B {
            reaches[i] = Reach { along: along[i], beside: beside[i] };
        }
        // Decided lane by lane, so that no lane depends on its neighbours.
        let mut blind = [false; B];
        for i in 0..B {
            blind[i] = bounds.drown(reaches[i].whole());
        }
        let nothing = Parabola::constant(Interval::radius(bounds.range));
        if blind != [true; B] {
            if k.is_uniform() {
                out.uniform(k, p, &reaches);
            } else {
                out.local(k, p, &reaches, &blind);
            }
        }
        for i in 0..B {
            if blind[i] {
                out.set(i, &nothing);
            }
        }
    }

    /// The image under a kernel that knows more about a small ball than about all of space; of lanes that are blind, anything.
    fn local<K2: Kernel + ?Sized>(&mut self, k: &K2, p: [&Self; 3], reach: &[Reach; B], blind: &[bool; B]) {
        // The balls that lanes are about, side by side; lanes to spare are about the same one as the first.
        let (mut about, mut count) = ([0; B], 0);
        let (mut at, mut radius) = ([[0.0; B]; 3], [0.0; B]);
        for i in (0..B).filter(|&i| !blind[i]) {
            let (c, r) = ([p[0].mid[0][i], p[1].mid[0][i], p[2].mid[0][i]], reach[i].whole());
            let is_first = count > 0 && [at[0][0], at[1][0], at[2][0]] == c && radius[0] == r;
            if !is_first {
                about[i] = count;
                (at[0][count], at[1][count], at[2][count], radius[count]) = (c[0], c[1], c[2], r);
                count += 1;
            }
        }
        let mut known = [Local::UNKNOWN; B];
        k.locals(
            Order::Gradient,
            at.each_ref().map(|at| &at[..count]),
            &radius[..count],
            &mut known[..count],
        );
        self.fill_widest(
            #[inline(always)]
            |i| {
                let (local, error) = &known[about[i]];
                Parabola::expand(local, *error, reach[i], &Self::place(&p, i))
            },
        );
    }

    /// The image under a kernel of which the jets and the bounds are all there is to say.
    fn uniform<K2: Kernel + ?Sized>(&mut self, k: &K2, p: [&Self; 3], reach: &[Reach; B]) {
        let bounds = k.bounds();
        let (mut value, mut grad) = ([0.0; B], [[0.0; B]; 3]);
        let [gx, gy, gz] = &mut grad;
        let at = [&p[0].mid[0][..], &p[1].mid[0][..], &p[2].mid[0][..]];
        k.jets(at, Jets { value: &mut value, grad: Some([gx, gy, gz]), hess: None });
        let error = Growing::new(k);
        self.fill_widest(
            #[inline(always)]
            |i| {
                let at = [p[0].mid[0][i], p[1].mid[0][i], p[2].mid[0][i]];
                let grad = [grad[0][i], grad[1][i], grad[2][i]];
                let jet = Point { value: value[i], grad, hess: [0.0; 6] };
                let local = Local::uniform(jet, bounds);
                Parabola::expand(&local, error.at(size(at)), reach[i], &Self::place(&p, i))
            },
        );
    }
}

impl<const K: usize> Parabola<K> {
    /// What is known of a kernel at a point that reaches this far.
    #[inline(always)]
    fn expand(local: &Local, error: [f64; 3], reach: Reach, p: &[Self; 3]) -> Self {
        let Local { jet, bounds: b, bow, sag, .. } = *local;
        let (d, w, r) = (reach.along, reach.beside, reach.whole());
        // Only the Taylor form reads the gradient, which some kernels cannot vouch for.
        let (still, tilted) = (error[0], error[0] + 2.0 * error[1] * r);
        let cone = b.lipschitz * r * ROUND_UP;
        let hessian = choose(sag < b.hessian, sag, b.hessian);
        let bent = 0.5 * hessian * r * r;
        // What grows with the distance from the middle says more there than a bow that is not much less.
        let own_bow = bow.mag() < choose(sag < f64::INFINITY, OWN, 1.0) * bent;
        let is_value = jet.value.is_finite();
        let is_jet = is_value & tilted.is_finite() & (jet.grad[0] + jet.grad[1] + jet.grad[2]).is_finite();
        let others = VAGUE * choose(cone < b.range, cone, b.range);
        let taylor = is_jet & (choose(own_bow, bow.mag(), bent) <= others);
        let lipschitz = is_value & !taylor & (cone <= b.range) & (cone < f64::INFINITY);

        let all = Interval::radius(b.range);
        let known = pick(is_value, Interval::around(jet.value, (cone + still) * ROUND_UP).meet(all), all);
        // The three terms of `M2 (w + d |e|)^2 / 2`, or the kernel's own bound on them.
        let bow = pick(own_bow, bow, Interval { lo: 0.0, hi: 0.0 });
        let curved = choose(own_bow, 0.0, hessian);
        let mut form = Parabola {
            mid: [jet.value + bow.mid(), 0.0, 0.0],
            rest: [tilted + bow.rad() + 0.5 * curved * w * w, curved * d * w, 0.5 * curved * d * d],
            side: [0.0; K],
            range: known,
        };
        form.rest[0] += CHARGE * form.mid[0].abs();
        for axis in 0..3 {
            let (g, x) = (jet.grad[axis], &p[axis]);
            form.rest[0] += g.abs() * x.rest[0];
            for j in 1..3 {
                form.mid[j] += g * x.mid[j];
                form.rest[j] += g.abs() * (x.rest[j] + CHARGE * x.mid[j].abs());
            }
            for k in 0..K {
                form.side[k] += g * x.side[k];
                form.rest[0] += g.abs() * (CHARGE * x.side[k].abs());
            }
        }
        let flat = Self::constant(known);
        let cone = [still + b.lipschitz * w, b.lipschitz * d, 0.0];
        for j in 0..3 {
            let middle = choose(lipschitz & (j == 0), jet.value, flat.mid[j]);
            form.mid[j] = choose(taylor, form.mid[j], middle);
            form.rest[j] = choose(taylor, form.rest[j], choose(lipschitz, cone[j], flat.rest[j])) * ROUND_UP;
        }
        for k in 0..K {
            form.side[k] = choose(taylor, form.side[k], 0.0);
        }
        form.rest[0] += TINY;
        form.narrowed(known)
    }
}
