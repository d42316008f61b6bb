//! Gabor noise (Lagae et al. 2009, with the random phases of Lagae et al. 2011): waves under round
//! envelopes on random nodes, for noises of one frequency, and of one direction if that is asked
//! for.
//!
//! With the nodes `n_i` and weights `w_i` of [`scatter`](super::scatter), `d = x - n_i`, the quintic
//! envelope `h` of [`sparse`](super::sparse), a direction `o_i` and a phase `p_i` of each node,
//!
//! ```text
//! N = sum w_i h(|d|) cos 2 pi (F o_i.d + p_i)
//! ```
//!
//! The power spectrum is that of the envelope moved to the tips of the `F o_i`: a band around `F`
//! cycles a cell, in all directions or about one. Random phases make the process stationary with
//! variance half that of sparse convolution noise, 0.18657 times the number of nodes to a cell.
//!
//! **Why not a Gaussian envelope?** It never ends. Cut off where it is small it jumps there, however
//! little, and a noise that jumps has no Lipschitz bound; the quintic ends with two derivatives.
//!
//! **Derivatives** follow from those of the envelope by the product rule. With `u = 2 pi F o`, and
//! `C`, `S` the cosine and sine of the phase,
//!
//! ```text
//! value h C     gradient C grad h - h S u     Hessian C H - S (grad h u^T + u grad h^T) - h C u u^T
//! ```
//!
//! **Bounds.** Along a unit vector `v`, with `s = u.v` and `h_j` the derivatives of the envelope along
//! `v`, the `k`-th derivative is the real part of
//!
//! ```text
//! e^(i phase) Z_k(s)        Z_k(s) = sum_j binom(k, j) (i s)^(k-j) h_j
//! ```
//!
//! and a phase that is free reaches `|Z_k|`. Let `M_k(S)` be the supremum of its sum over one node in
//! each of 27 cells, each at its worst place and with its worst `|s| <= S`. [`certify`](super::certify)
//! bounds it at a few frequencies `S = 2 pi F`. In between, since `Z_k'' = -k (k - 1) Z_(k-2)`, a
//! chord of `Z_k` and what a curve can sag from its chord give, at a share `l` of the way,
//!
//! ```text
//! M_k(S) <= (1 - l) M_k(S_0) + l M_k(S_1) + l (1 - l) / 2 (S_1 - S_0)^2 k (k - 1) M_(k-2)(S_1)
//! ```
//!
//! which grows with `S`, as a bound for all `|s| <= S` has to; see the tests. At the frequencies of the
//! net, of which the default is one, the bounds are within a tenth of what
//! a search finds; between them the Lipschitz bound is as good, and the third derivative's may be
//! half too large.

use super::basis::Basis;
use super::bulk::{GRADIENT, HESSIAN};
use super::lattice::Lattice;
use super::parameter::{Allowed, Exact, Parameter, Settings};
use super::scatter::{self, NODES, Node, PLACEMENT, Placement, Scatter, Spot, WEIGHTS};
use super::scatter::{next, uniform};
use super::sparse::{Quintic, outer};
use crate::num::{Bounds, Class, Jets, Local, Order, Point, ROUNDOFF, cos_turns, sin_turns};
use std::f64::consts::TAU;

/// Gabor noise on a lattice of unit cells.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Gabor {
    scatter: Scatter,
    /// Cycles a cell.
    frequency: Exact,
    /// Unit vector about which waves go.
    axis: [Exact; 3],
    /// One less the cosine of the largest angle to it: 2 for all directions.
    cap: Exact,
}

const FREQUENCY: &str = "frequency";
const DIRECTION: &str = "direction";
const SPREAD: &str = "spread";

/// Frequencies at which bounds with one node of unit weight in every cell are proven, with those of
/// orders 1 to 3: for nodes anywhere in their cells, and for nodes that keep a margin.
const NET: [(f64, [[f64; 3]; 2]); 5] = [
    (0.5, [[33.4, 189.7, 1692.0], [15.8, 87.6, 711.0]]),
    (1.0, [[56.3, 445.5, 4210.0], [26.95, 218.4, 1935.0]]),
    (2.0, [[106.0, 1438.0, 20_700.0], [51.1, 681.5, 9840.0]]),
    (4.0, [[208.2, 5362.0, 140_100.0], [100.5, 2597.0, 68_000.0]]),
    (8.0, [[414.2, 21_000.0, 1_067_500.0], [200.0, 10_150.0, 516_900.0]]),
];

/// The bound of order 0, at all frequencies.
const RANGE: [f64; 2] = [8.13, 3.84];

impl Gabor {
    fn wave(&self) -> Wave {
        // An orthonormal frame without branches (Duff et al. 2017).
        let [x, y, z] = self.axis.map(|a| a.0);
        let sign = f64::copysign(1.0, z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        let frame = [[1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y], [x, y, z]];
        Wave { frequency: self.frequency.0, frame, cap: self.cap.0 }
    }
}

/// Bounds with one node of unit weight in every cell; see the module text.
pub(super) fn unit(margin: bool, frequency: f64) -> Bounds {
    let (range, placed) = (RANGE[usize::from(margin)], usize::from(margin));
    let last = NET.len() - 2;
    let i = NET.iter().skip(1).take(last).filter(|(at, _)| *at < frequency).count();
    let ((low, a), (high, b)) = (NET[i], NET[i + 1]);
    let share = (frequency - low) / (high - low);
    let sag = 0.5 * share * (1.0 - share) * (TAU * (high - low)) * (TAU * (high - low));
    let between = |k: usize, below: f64| {
        let chord = (1.0 - share) * a[placed][k - 1] + share * b[placed][k - 1];
        (chord + sag * (k * (k - 1)) as f64 * below) * (1.0 + 1e-12)
    };
    Bounds { range, lipschitz: between(1, 0.0), hessian: between(2, range), third: between(3, b[placed][0]) }
}

impl Basis for Gabor {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            name: FREQUENCY,
            doc: "waves to a cell",
            allowed: Allowed::Number { least: 0.5, most: 8.0, default: 2.0 },
        },
        Parameter {
            name: DIRECTION,
            doc: "direction in which waves go; every node has its own if there is none",
            allowed: Allowed::Direction,
        },
        Parameter {
            name: SPREAD,
            doc: "largest angle of a wave to that direction, in degrees",
            allowed: Allowed::Number { least: 0.0, most: 90.0, default: 0.0 },
        },
        NODES,
        PLACEMENT,
        WEIGHTS,
    ];

    fn new(settings: &Settings) -> Self {
        let (axis, cap) = match settings.direction(DIRECTION) {
            // Scaled first, so that no square overflows or vanishes.
            Some(v) => {
                let size = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                let v = v.map(|x| x / size);
                let norm = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
                let angle = settings.number(SPREAD) / 360.0;
                (v.map(|x| x / norm), 1.0 - cos_turns(angle))
            }
            None => ([0.0, 0.0, 1.0], 2.0),
        };
        Gabor {
            scatter: Scatter::new(settings),
            frequency: Exact(settings.number(FREQUENCY)),
            axis: axis.map(Exact),
            cap: Exact(cap),
        }
    }

    fn class(&self) -> Class {
        Class::C2
    }

    fn bounds(&self) -> Bounds {
        unit(self.scatter.placement == Placement::Disc, self.frequency.0).times(self.scatter.most_weight())
    }

    /// Waves of one direction have the spectrum of the envelope, whose edge is at 1, about their
    /// frequency; spread over all directions it ends a little earlier.
    fn band(&self) -> f64 {
        self.frequency.0 + 1.0
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        scatter::jets(&self.scatter, &self.wave(), lattice, at, out);
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        scatter::jet(&self.scatter, &self.wave(), lattice, order, at)
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, lattice: &Lattice, order: Order, at: [f64; 3], radius: f64) -> Local {
        let ball = (order, at, radius);
        scatter::local(&self.scatter, &self.wave(), lattice, ball, self.bounds(), self.rounding())
    }

    /// As for [`Sparse`](super::Sparse); a phase is off by the offset, which the next derivative
    /// bounds, and by its own four roundoffs of up to `F` turns, which are `8 pi F` roundoffs of the
    /// amplitude and less than 4 of the next derivative; a cosine by 4 roundoffs.
    fn rounding(&self) -> [f64; 3] {
        let (b, n) = (self.bounds(), self.scatter.roundoffs());
        [
            ROUNDOFF * (n * b.range + 32.0 * b.lipschitz),
            ROUNDOFF * (n * b.lipschitz + 32.0 * b.hessian),
            ROUNDOFF * (n * b.hessian + 32.0 * b.third),
        ]
    }
}

/// The spot: a wave under the quintic envelope.
#[derive(Clone, Copy)]
struct Wave {
    frequency: f64,
    /// Rows: two axes across the mean direction, and that direction.
    frame: [[f64; 3]; 3],
    cap: f64,
}

impl Wave {
    /// Unit vector uniform in the cap about the mean direction, and phase in turns.
    #[inline(always)]
    fn draw(&self, word: u32) -> ([f64; 3], f64) {
        let (second, third) = (next(word), next(next(word)));
        // The height of a uniform point of a cap is uniform (Archimedes).
        let drop = self.cap * uniform(word);
        let across = (drop * (2.0 - drop)).sqrt();
        let turn = uniform(second);
        let [a, b, c] = self.frame;
        let (p, q, r) = (across * cos_turns(turn), across * sin_turns(turn), 1.0 - drop);
        ([0, 1, 2].map(|i| p * a[i] + q * b[i] + r * c[i]), uniform(third))
    }
}

impl Spot for Wave {
    #[inline(always)]
    fn jet<const ORDER: u8>(&self, node: &Node) -> Point {
        let e = Quintic.jet::<ORDER>(node);
        let (o, phase) = self.draw(node.word);
        let d = node.d;
        let turns = self.frequency * (o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) + phase;
        let cos = cos_turns(turns);
        let mut out = Point { value: e.value * cos, ..Point::default() };
        if ORDER >= GRADIENT {
            let sin = sin_turns(turns);
            let u = o.map(|o| TAU * self.frequency * o);
            let hs = e.value * sin;
            out.grad = [0, 1, 2].map(|i| e.grad[i] * cos - hs * u[i]);
            if ORDER >= HESSIAN {
                let (g, uu) = (e.grad.map(|g| g * sin), outer(u, u));
                let (gu, ug) = (outer(g, u), outer(u, g));
                for k in 0..6 {
                    out.hess[k] = e.hess[k] * cos - (gu[k] + ug[k]) - out.value * uu[k];
                }
            }
        }
        out
    }

    /// Real and imaginary parts of the sum in the module text, the wave along the direction.
    #[inline(always)]
    fn sizes(&self, near: f64, far: f64) -> [f64; 4] {
        let [a, b, c, d] = Quintic.sizes(near, far);
        let s = TAU * self.frequency;
        let modulus = |re: f64, im: f64| (re * re + im * im).sqrt();
        [
            a,
            modulus(b, s * a),
            modulus(c + s * s * a, 2.0 * s * b),
            modulus(d + 3.0 * s * s * b, s * (3.0 * c + s * s * a)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_grow_with_the_frequency_and_meet_the_net() {
        for margin in [false, true] {
            let mut last = unit(margin, 0.5);
            for i in 1..=15_000 {
                let next = unit(margin, 0.5 + f64::from(i) * 0.0005);
                // What holds at a frequency has to hold at all smaller ones.
                assert!(
                    next.lipschitz > last.lipschitz && next.hessian > last.hessian && next.third > last.third
                );
                last = next;
            }
            for (frequency, all) in NET {
                let b = unit(margin, frequency);
                for (found, stated) in
                    [b.lipschitz, b.hessian, b.third].into_iter().zip(all[usize::from(margin)])
                {
                    assert!((found / stated - 1.0).abs() < 1e-11);
                }
            }
        }
    }
}
