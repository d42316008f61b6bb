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
//! and a phase that is free reaches `|Z_k|`. A direction that is free takes `s` anywhere up to `2 pi F`
//! in size, and a sign does not matter since `Z_k(-s)` is the conjugate of `Z_k(s)`. So let `M_k(S)` be
//! the supremum of the sum over one node in each of 27 cells, each at its worst place and with its worst
//! `|s| <= S`: it bounds the noise for `S = 2 pi F`, and it grows with `S` because more is allowed.
//! [`certify`](super::certify) bounds it at the frequencies of a net.
//!
//! *Between two of them*, `S_0` and `S_1`, take any place and nodes. Let `a` and `b` be the largest
//! `|Z_k|` of one of the nodes for `|s|` up to `S_0` and `S_1`, so `a <= b`. Up to `S_0` the node reaches `a`
//! at most. Beyond, look at `Z_k` as a curve over `t = s^k`, over which its greatest term is straight. At
//! a share `m` of the way from `S_0^k` to `S_1^k` it is off its chord by at most
//! `m (1 - m) / 2 (S_1^k - S_0^k)^2` times its largest second derivative, which is at most
//!
//! ```text
//! sum_j binom(k, j) (1 - j/k) (j/k) |h_j| s^-(k + j)  <=  c = (1 - 1/k) sum_(0 < j < k) |h_j| S_0^-(k + j)
//! ```
//!
//! for `k` up to 3. So for all `m` up to the share `l` of `S^k`
//!
//! ```text
//! |Z_k| <= (1 - m) a + m b + m (1 - m) / 2 (S_1^k - S_0^k)^2 c
//!       <= (1 - l) a + l b + q(l) / 2 (S_1^k - S_0^k)^2 c
//! ```
//!
//! where `q(l)`, the largest of `m (1 - m)`, is `l (1 - l)` and from the middle on 1/4; and `|Z_k| <= b`.
//! The sums over nodes of `a` and `b` are at most `M_k(S_0)` and `M_k(S_1)`, and those of `|h_j|` the bounds
//! `E_j` of sparse convolution noise, hence
//!
//! ```text
//! M_k(S) <= min(M_k(S_1), (1 - l) M_k(S_0) + l M_k(S_1) + q(l) / 2 (S_1^k - S_0^k)^2 C)
//! C = (1 - 1/k) sum_(0 < j < k) E_j S_0^-(k + j)
//! ```
//!
//! At the frequencies of the net, of which the default is one, the bounds are within a tenth of what a
//! search finds; between them they are a hundredth or two farther.

use super::basis::Basis;
use super::bulk::{GRADIENT, HESSIAN};
use super::lattice::Lattice;
use super::parameter::{Allowed, Exact, Parameter, Settings};
use super::scatter::{self, NODES, Node, PLACEMENT, Placement, Scatter, Spot, WEIGHTS};
use super::scatter::{next, uniform};
use super::sparse::{Quintic, UNIT, outer};
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
pub(super) const NET: [(f64, [[f64; 3]; 2]); 13] = [
    (0.5, [[32.84, 180.1, 1308.0], [15.3, 81.38, 619.2]]),
    (0.63, [[38.58, 233.6, 1733.0], [18.09, 108.3, 791.5]]),
    (0.8, [[46.44, 315.9, 2547.0], [21.96, 152.4, 1142.0]]),
    (1.0, [[56.03, 441.3, 3968.0], [26.69, 212.3, 1814.0]]),
    (1.25, [[68.51, 629.5, 6391.0], [32.73, 303.6, 3004.0]]),
    (1.6, [[86.33, 965.9, 11_410.0], [41.33, 463.2, 5503.0]]),
    (2.0, [[106.0, 1438.0, 20_280.0], [51.1, 681.5, 9840.0]]),
    (2.5, [[133.2, 2210.0, 37_210.0], [63.74, 1049.0, 17_860.0]]),
    (3.15, [[167.3, 3423.0, 71_290.0], [79.76, 1630.0, 34_020.0]]),
    (4.0, [[212.5, 5362.0, 140_100.0], [100.5, 2597.0, 67_370.0]]),
    (5.0, [[263.3, 8435.0, 270_900.0], [126.1, 4013.0, 129_000.0]]),
    (6.3, [[331.3, 13_320.0, 534_900.0], [158.7, 6334.0, 254_400.0]]),
    (8.0, [[424.0, 21_350.0, 1_080_000.0], [200.0, 10_150.0, 516_900.0]]),
];

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

/// Bound of order `k` at the second of three frequencies from those at the others, and from those of
/// orders 1 and 2 of the envelope; see the module text.
pub(super) fn between(k: usize, [low, at, high]: [f64; 3], [a, b]: [f64; 2], envelope: [f64; 2]) -> f64 {
    let power = |frequency: f64, n: usize| (0..n).fold(1.0, |p, _| p * TAU * frequency);
    let apart = power(high, k) - power(low, k);
    let share = (power(at, k) - power(low, k)) / apart;
    let bend: f64 = (1..k).map(|j| envelope[j - 1] / power(low, k + j)).sum();
    let l = share.min(0.5);
    let sag = 0.5 * l * (1.0 - l) * apart * apart * (1.0 - 1.0 / k as f64) * bend;
    ((1.0 - share) * a + share * b + sag).min(b)
}

/// Bounds with one node of unit weight in every cell. What they round off is less than what proofs
/// spare.
pub(super) fn unit(margin: bool, frequency: f64) -> Bounds {
    let placed = usize::from(margin);
    let i = NET[1..NET.len() - 1].partition_point(|(at, _)| *at < frequency);
    let ((low, a), (high, b)) = (NET[i], NET[i + 1]);
    let envelope = UNIT[0][placed];
    let of = |k: usize| {
        let ends = [a[placed][k - 1], b[placed][k - 1]];
        between(k, [low, frequency, high], ends, [envelope.lipschitz, envelope.hessian])
    };
    Bounds { range: envelope.range, lipschitz: of(1), hessian: of(2), third: of(3) }
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

    fn locals(&self, lattice: &Lattice, order: Order, at: [&[f64]; 3], radius: &[f64], out: &mut [Local]) {
        let (balls, limits) = ((order, at, radius), (self.bounds(), self.rounding()));
        scatter::locals(&self.scatter, &self.wave(), lattice, balls, limits, out);
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
    use crate::noise::tests::Random;

    #[test]
    fn bounds_grow_with_the_frequency_and_meet_the_net() {
        for margin in [false, true] {
            let all = |frequency: f64| {
                let b = unit(margin, frequency);
                [b.lipschitz, b.hessian, b.third]
            };
            let mut last = all(0.5);
            for i in 1..=15_000 {
                let next = all(0.5 + f64::from(i) * 0.0005);
                // What holds at a frequency has to hold at all smaller ones.
                assert!((0..3).all(|k| next[k] >= last[k]));
                last = next;
            }
            for (frequency, proven) in NET {
                assert_eq!(all(frequency), proven[usize::from(margin)]);
            }
        }
    }

    #[test]
    fn between_two_frequencies_every_node_is_bounded_by_its_own_share() {
        let mut random = Random::new(3);
        for _ in 0..300 {
            // Derivatives of an envelope along a line through a node, of any size.
            let h = [1.0, 4.0, 30.0, 200.0].map(|size| size * (2.0 * random.unit() - 1.0));
            let size = |k: usize, s: f64| {
                let (re, im) = match k {
                    1 => (h[1], s * h[0]),
                    2 => (h[2] - s * s * h[0], 2.0 * s * h[1]),
                    _ => (h[3] - 3.0 * s * s * h[1], s * (3.0 * h[2] - s * s * h[0])),
                };
                (re * re + im * im).sqrt()
            };
            for (k, ends) in (1..=3).flat_map(|k| NET.windows(2).map(move |ends| (k, ends))) {
                let (low, high) = (ends[0].0, ends[1].0);
                let reach = |frequency: f64| {
                    (0..=400).map(|i| size(k, TAU * frequency * f64::from(i) / 400.0)).fold(0.0, f64::max)
                };
                let at = low + (high - low) * random.unit();
                let most = between(k, [low, at, high], [reach(low), reach(high)], [h[1].abs(), h[2].abs()]);
                assert!(reach(at) <= most * (1.0 + 1e-4), "{k} {at} {h:?}");
            }
        }
    }
}
