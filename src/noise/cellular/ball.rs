//! What is known of cellular noise in a ball, creases and all.
//!
//! Every distance `d_i(x)` to a node is convex, so its tangent plane at the centre `c` lies below it,
//! and it gets above that plane by no more than its norm's *excess*. Let `g` be any vector, and
//!
//! ```text
//! e_i(h) = d_i(c + h) - g . h        in [lo_i, hi_i] for |h| <= r
//! lo_i = d_i - |u_i - g| r           hi_i = d_i + |u_i - g| r + excess_i         u_i = grad d_i(c)
//! ```
//!
//! Subtracting the same `g . h` from all distances does not change their order. So
//! `F_l(c + h) - g . h` is the `l`-th smallest of the `e_i`, which lies between the `l`-th smallest of
//! the `lo_i` and the `l`-th smallest of the `hi_i`. With `g = grad F_l(c)` these differ by the
//! curvature of one distance alone, quadratic in `r`, unless a crease passes nearby; then the planes
//! of the rival nodes count, and the enclosure is as wide as the crease is sharp. The cap is a node
//! whose distance is constant, and a squared distance is convex like the distance itself.
//!
//! Only nodes within `F_K + 2 s r` of the centre can be among the `K` nearest of any point of the ball, where `s` is the
//! steepest slope of a distance.
//!
//! Where nothing but `F_1` counts, two nodes do: `g` is the slope of the nearest one's distance, and all others are at
//! least as far away as the second, so that their `e_i` are at least `max(F_2 - s r, 0) - |g| r`.

use super::metric::Metric;
use super::scout::Ground;
use super::search::{Found, Search};
use super::{Ball, Cellular};
use crate::noise::basis::Basis;
use crate::noise::creased;
use crate::num::{Bounds, Interval, Local, Point, ROUNDOFF, widest};

/// A distance as a function of the offset from the centre of the ball.
#[derive(Clone, Copy)]
struct Distance {
    /// At the centre.
    value: f64,
    /// Gradient at the centre.
    slope: [f64; 3],
    /// How far it gets above its tangent plane.
    excess: f64,
    /// How far it can move either way.
    reach: f64,
    /// Largest second directional derivative in the ball.
    curvature: f64,
}

/// Covers the rounding of the distances, none of which is above 9, and of what is done with them.
const SLACK: f64 = 1024.0 * ROUNDOFF;

fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

impl Distance {
    fn new<M: Metric>(metric: M, squared: bool, d: [f64; 3], size: f64, r: f64) -> Distance {
        let (slope, reach) = (metric.slope(d, size), metric.steepness() * r);
        if squared {
            Distance {
                value: size * size,
                slope: slope.map(|g| 2.0 * size * g),
                excess: metric.square_excess(d, size, r),
                reach: reach * (2.0 * size + reach),
                curvature: metric.square_curvature(d, size, r),
            }
        } else {
            Distance {
                value: size,
                slope,
                excess: metric.excess(d, size, r),
                reach,
                curvature: metric.curvature(d, size, r),
            }
        }
    }

    fn constant(value: f64) -> Distance {
        Distance { value, slope: [0.0; 3], excess: 0.0, reach: 0.0, curvature: 0.0 }
    }

    /// `[lo, hi]` around what is left after taking off a plane with slope `g`.
    fn rest(&self, g: [f64; 3], r: f64) -> Interval {
        let turn = norm([0, 1, 2].map(|i| self.slope[i] - g[i])) * r;
        let plane = norm(g) * r;
        // Where the excess is unknown or large, how fast the distance changes, and that it is not
        // negative, say more.
        let lo = self.value - turn;
        let floor = f64::max(self.value - self.reach, 0.0) - plane;
        let hi = self.value + turn + self.excess;
        let ceiling = self.value + self.reach + plane;
        let slack = SLACK * (1.0 + r);
        Interval {
            lo: if floor > lo { floor } else { lo } - slack,
            hi: if hi < ceiling { hi } else { ceiling } + slack,
        }
    }
}

/// The `K` smallest of some numbers, in order.
struct Least<const K: usize>([f64; K]);

impl<const K: usize> Least<K> {
    fn insert(&mut self, mut x: f64) {
        for own in &mut self.0 {
            if x < *own {
                (x, *own) = (*own, x);
            }
        }
    }
}

/// What is known of the ball.
pub(super) fn local<M: Metric, const K: usize>(ball: &Ball<'_>, search: Search<'_, M>) -> Local {
    let (noise, metric) = (ball.noise, search.metric);
    // Offsets of nodes are rounded, which is as if the centre lay a little elsewhere.
    let r = ball.radius + 16.0 * ROUNDOFF;
    let found: Found<K, 1> = search.nearest(ball.at);
    let jet = noise.point(metric, ball.order, &found);
    let limit = metric.distance(found.measure[K - 1][0]) + 2.0 * metric.steepness() * r + SLACK;
    // Beyond the cap there are cells that the search does not know.
    let known = limit < search.cap;
    if !known {
        return Local::uniform(jet, noise.bounds());
    }
    let mut distances = Vec::with_capacity(24);
    search.within(ball.at, limit, |d| {
        let size = metric.distance(metric.measure(d, f64::INFINITY));
        if size <= limit {
            distances.push(Distance::new(metric, noise.squared, d, size, r));
        }
    });
    distances.sort_by(|a, b| a.value.total_cmp(&b.value));
    let enclosure = Enclosure::<K> { noise, r, distances: &distances, cap: search.cap };
    let local = enclosure.local(jet, &found, metric);
    Local { bounds: creased(local.bounds, &noise.bounds(), ball.radius, r), ..local }
}

/// What is known of a ball where the distance to the nearest node is all that matters.
pub(super) fn nearest_alone<M: Metric>(ball: &Ball<'_>, search: Search<'_, M>) -> Local {
    among_two(ball, search.metric, search.cap, &search.nearest(ball.at), 0)
}

/// Balls whose nearest nodes are looked for together.
const GROUP: usize = 16;

/// [`nearest_alone`] for many balls, with the same answers bit for bit.
pub(super) fn nearest_alone_of_all<'a, M: Metric>(
    ball: &impl Fn(usize) -> Ball<'a>,
    search: Search<'_, M>,
    out: &mut [Local],
) {
    let mut ground = Ground::<GROUP>::new(search.lattice);
    let mut found = Found::<2, GROUP>::new(0.0, [0.0; GROUP]);
    for (group, out) in out.chunks_mut(GROUP).enumerate() {
        let last = out.len() - 1;
        let own = |i: usize| ball(group * GROUP + i.min(last));
        let at = std::array::from_fn(|axis| std::array::from_fn(|i| own(i).at[axis]));
        widest(
            #[inline(always)]
            || search.nearest_of_group(&mut ground, &at, &mut found),
        );
        for (i, out) in out.iter_mut().enumerate() {
            *out = among_two(&own(i), search.metric, search.cap, &found, i);
        }
    }
}

/// What is known of ball `i` by its two nearest nodes. (With the planes of all nodes near the ball, which take longer to
/// find, casting needs as many steps to half a per cent.)
fn among_two<M: Metric, const B: usize>(
    ball: &Ball<'_>,
    metric: M,
    cap: f64,
    found: &Found<2, B>,
    i: usize,
) -> Local {
    let (noise, r) = (ball.noise, ball.radius + 16.0 * ROUNDOFF);
    let [size, second] = [0, 1].map(|l| metric.distance(found.measure[l][i]));
    let offset = found.offset[0].map(|axis| axis[i]);
    let (measure, offsets) = ([[found.measure[0][i]]], [offset.map(|x| [x])]);
    let alone = Found { measure, offset: offsets, nowhere: [found.nowhere[i]] };
    let jet = noise.point::<M, 1>(metric, ball.order, &alone);
    let reach = metric.steepness() * r;
    // Beyond the cap there are nodes that the search does not know.
    let is_known = size + 2.0 * reach + SLACK < cap;
    if !is_known {
        return Local::uniform(jet, noise.bounds());
    }
    let nearest = Distance::new(metric, false, offset, size, r);
    let own = nearest.rest(nearest.slope, r);
    let others = f64::max(second - reach, 0.0) - norm(nearest.slope) * r - SLACK * (1.0 + r);
    let a = noise.weights[0].0;
    let curvature = match others > own.hi {
        true => a.abs() * nearest.curvature,
        false if a == 0.0 => 0.0,
        false => f64::INFINITY,
    };
    let bow = Interval { lo: own.lo.min(others) - nearest.value, hi: own.hi - nearest.value } * a;
    let local = bounded(noise, jet, r, Interval::point(0.0) + bow, curvature);
    Local { bounds: creased(local.bounds, &noise.bounds(), ball.radius, r), ..local }
}

/// What is known of the noise in a ball where its second derivatives are bounded so.
fn bounded(noise: &Cellular, jet: Point, r: f64, bow: Interval, curvature: f64) -> Local {
    let up = 1.0 + 64.0 * ROUNDOFF;
    let steepness = norm(jet.grad) + curvature * r + SLACK * noise.lipschitz.0;
    let global = noise.bounds();
    let bounds = Bounds {
        // A slope that is not known is no better than the global one.
        lipschitz: if steepness * up < global.lipschitz { steepness * up } else { global.lipschitz },
        hessian: curvature * up,
        ..global
    };
    Local { jet, bounds, bow, sag: f64::INFINITY, turn: f64::INFINITY }
}

/// The distances that matter, nearest first.
struct Enclosure<'a, const K: usize> {
    noise: &'a Cellular,
    r: f64,
    distances: &'a [Distance],
    cap: f64,
}

impl<const K: usize> Enclosure<'_, K> {
    fn local<M: Metric>(&self, jet: Point, found: &Found<K, 1>, metric: M) -> Local {
        let Enclosure { noise, r, .. } = *self;
        let mut bow = Interval::point(0.0);
        let mut curvature = 0.0;
        for l in (0..K).filter(|l| noise.weights[*l].0 != 0.0) {
            let a = noise.weights[l].0;
            let size = metric.distance(found.measure[l][0]);
            let own = [0, 1, 2].map(|axis| found.offset[l][axis][0]);
            let own = Distance::new(metric, noise.squared, own, size, r);
            let range = self.order_statistic(l, own.slope);
            bow = bow + Interval { lo: range.lo - own.value, hi: range.hi - own.value } * a;
            let level = self.distances.get(l).map_or(f64::INFINITY, |d| d.curvature);
            curvature += a.abs() * if self.settled(l, own.slope) { level } else { f64::INFINITY };
        }
        bounded(noise, jet, r, bow, curvature)
    }

    /// Encloses the `l`-th smallest (from 0) distance less the plane with slope `g`.
    fn order_statistic(&self, l: usize, g: [f64; 3]) -> Interval {
        let cap = Distance::constant(if self.noise.squared { self.cap * self.cap } else { self.cap });
        let cap = cap.rest(g, self.r);
        let (mut lo, mut hi) = (Least([cap.lo; K]), Least([cap.hi; K]));
        for d in self.distances {
            let rest = d.rest(g, self.r);
            lo.insert(rest.lo);
            hi.insert(rest.hi);
        }
        Interval { lo: lo.0[l], hi: hi.0[l] }
    }

    /// Whether the `l`-th distance (from 0) is that of the same node throughout the ball, as far as
    /// the noise can tell: nodes of equal weight may change places.
    fn settled(&self, l: usize, g: [f64; 3]) -> bool {
        let weight = |l: usize| self.noise.weights.get(l).map_or(0.0, |a| a.0);
        let apart = |l: usize| {
            // Between the first l distances and the others.
            let (first, others) = self.distances.split_at(l.min(self.distances.len()));
            let hi = first.iter().map(|d| d.rest(g, self.r).hi).fold(f64::NEG_INFINITY, f64::max);
            others.iter().all(|d| d.rest(g, self.r).lo > hi)
        };
        let same = |l: usize, m: usize| weight(l).to_bits() == weight(m).to_bits();
        (l == 0 || same(l - 1, l) || apart(l)) && (same(l, l + 1) || apart(l + 1))
    }
}
