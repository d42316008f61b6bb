//! What lies within a few tolerances of a hit: on which side of the surface, and whether that is all.
//!
//! A hit is in front of the surface by less than the tolerance, and so is where a ray leaves a solid.
//! Whoever goes on from there needs a place that *is* on the other side, so the field is looked at a few
//! places ahead. To know that the piece of the ray up to that place was not the way through something
//! thinner still, it is cut into parts of which each is proven to be one of these:
//!
//! | over the whole part | then at its end |
//! |---|---|
//! | `f > 0` | the ray is outside; it must not have been inside before |
//! | `f < 0` | it is inside |
//! | the ray's derivative of `f` is below zero | it is inside if it was; it may have got there |
//! | the derivative is above zero | it is outside if it was; else nothing is known |
//!
//! A piece that can be cut so has the surface in it once at most: the ray came from outside, and is inside
//! from there on. So whatever is inside belongs to the place at its end. Of the complement the same is true
//! with all signs turned.
//!
//! Where the field is smooth most pieces need no cut, so that those of all rays are looked at side by side first, each in a
//! ball around it.

use super::group::LANES;
use super::{CastStats, Ray};
use crate::num::{Class, Interval, Many, ROUNDOFF, Slope, Taylor, Taylors};
use crate::tape::{Cells, Evaluator};
use glam::DVec3;
use std::sync::Arc;

/// Places that are looked at, in tolerances behind a hit. The hit itself is not the first: it may be so
/// close to the surface that a ray that goes on from there would not get away from it.
const RUNGS: [f64; 5] = [0.5, 1.0, 0.0, 2.0, 4.0];

/// Pieces that are looked at side by side, and so many at least: fewer are as soon looked at one by one.
const PIECES: usize = 16;
const SOME: usize = 4;

/// Times that a piece is halved for the sake of a proof.
const CUTS: u32 = 5;

/// A side of the surface.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Side {
    Inside,
    Outside,
}

impl Side {
    /// Turns values so that this side is where they are below zero.
    fn sign(self) -> f64 {
        match self {
            Side::Inside => 1.0,
            Side::Outside => -1.0,
        }
    }
}

/// A place ahead on a ray.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ahead {
    /// One on the other side of the surface.
    Crossed(f64),
    /// None of the places up to `end` is. At `closest`, within the tolerance, the field is closest to it.
    Along { closest: f64, end: f64 },
}

/// What is known of a ray at some place on it, for a surface that it is to cross once.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Known {
    /// It has not crossed it.
    Before,
    /// The field has been falling ever since it had not, or from the beginning.
    Falling,
    /// It has.
    Behind,
}

/// Looks at the field close to hits.
pub(super) struct Passage {
    cells: Arc<Cells>,
    points: Evaluator<Many<f64, LANES>>,
    slopes: Evaluator<Slope>,
    balls: Evaluator<Taylors<PIECES>>,
}

/// A piece of a ray of a group, by the number of the ray.
pub(super) type Part = (usize, (f64, f64));

impl Passage {
    pub(super) fn new(cells: Arc<Cells>) -> Passage {
        let tape = || cells.tape().clone();
        let (points, slopes) = (Evaluator::new(tape()), Evaluator::new(tape()));
        Passage { points, slopes, balls: Evaluator::new(tape()), cells }
    }

    /// The same with memory of its own.
    pub(super) fn again(&self) -> Passage {
        Passage::new(self.cells.clone())
    }

    /// For each hit, given as the number of a ray and `t`, a place on a side at or behind it.
    pub(super) fn look(&mut self, side: Side, hits: &[(usize, f64)], looks: &mut Looks<'_>) -> Vec<Ahead> {
        let rays = looks.rays;
        let along =
            |&(ray, t): &(usize, f64)| Ahead::Along { closest: t, end: rung(&rays[ray], t, RUNGS.len() - 1) };
        let mut found: Vec<Ahead> = hits.iter().map(along).collect();
        let mut least = vec![f64::INFINITY; hits.len()];
        let mut open: Vec<usize> = (0..hits.len()).collect();
        for k in 0..RUNGS.len() {
            let ahead = |i: usize| rung(&rays[hits[i].0], hits[i].1, k);
            let places: Vec<[f64; 3]> =
                open.iter().map(|&i| rays[hits[i].0].at(ahead(i)).to_array()).collect();
            let values = self.values(&places, looks.stats);
            for (&i, value) in open.iter().zip(values) {
                looks.costs[hits[i].0] += 1.0;
                let (at, value) = (ahead(i), side.sign() * value);
                // Where a field has no value there is nothing, which is outside.
                if value < 0.0 || (side == Side::Outside && (value == 0.0 || value.is_nan())) {
                    found[i] = Ahead::Crossed(at);
                } else if value < least[i] && RUNGS[k] <= 1.0 {
                    least[i] = value;
                    if let Ahead::Along { closest, .. } = &mut found[i] {
                        *closest = at;
                    }
                }
            }
            open.retain(|&i| matches!(found[i], Ahead::Along { .. }));
        }
        found
    }

    /// Whether a place is so close behind a hit as those that are looked at.
    pub(super) fn is_next_to(ray: &Ray, t: f64, at: f64) -> bool {
        (t..=rung(ray, t, RUNGS.len() - 1)).contains(&at)
    }

    /// The field at points.
    pub(super) fn values(&mut self, places: &[[f64; 3]], stats: &mut CastStats) -> Vec<f64> {
        let mut values = vec![f64::NAN; places.len()];
        let order = self.cells.tapes_around(places.iter().enumerate().map(|(i, &at)| (i, at, 0.0)));
        for batch in order.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)).flat_map(|same| same.chunks(LANES)) {
            let at = |lane: usize| places[batch[lane.min(batch.len() - 1)].1];
            let p = std::array::from_fn(|axis| Many(std::array::from_fn(|lane| at(lane)[axis])));
            let answers = self.points.turn_to(batch[0].0).eval(&p);
            for (lane, &(_, i)) in batch.iter().enumerate() {
                values[i] = answers.0[lane];
            }
            stats.evaluations += batch.len() as u64;
            stats.work += batch[0].0.work() * LANES as u64;
        }
        values
    }

    /// Which rays are proven to get to a side once and for all on pieces at whose ends they are on that side.
    pub(super) fn cross_once(&mut self, side: Side, pieces: &[Part], looks: &mut Looks<'_>) -> Vec<bool> {
        let mut once: Vec<bool> = pieces.iter().map(|&(_, (from, to))| from == to).collect();
        if self.cells.tape().class() == Class::C2 {
            self.cross_at_once(side, pieces, &mut once, looks);
        }
        for (once, piece) in once.iter_mut().zip(pieces).filter(|(once, _)| !**once) {
            *once = self.follow(side, *piece, CUTS, Known::Falling, looks).is_some();
        }
        once
    }

    /// The same for pieces as a whole: adds those for which one ball is proof enough.
    fn cross_at_once(&mut self, side: Side, pieces: &[Part], once: &mut [bool], looks: &mut Looks<'_>) {
        let rays = looks.rays;
        let ball = |&(ray, (from, to)): &Part| {
            let half = 0.5 * (to - from);
            let middle = rays[ray].at(from + half).to_array();
            (middle, half * (1.0 + 1e-9) + 4.0 * rays[ray].rounding(to))
        };
        let open = pieces.iter().enumerate().filter(|(i, _)| !once[*i]);
        let balls: Vec<(usize, [f64; 3], f64)> = open
            .map(|(i, piece)| {
                let (middle, radius) = ball(piece);
                (i, middle, radius)
            })
            .collect();
        let order = self.cells.tapes_around(balls.iter().enumerate().map(|(k, ball)| (k, ball.1, ball.2)));
        let batches = order.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)).flat_map(|same| same.chunks(PIECES));
        for batch in batches.filter(|batch| batch.len() >= SOME) {
            let (tape, own) = (batch[0].0, |lane: usize| &balls[batch[lane.min(batch.len() - 1)].1]);
            let radii = std::array::from_fn(|lane| own(lane).2);
            let middles: [[f64; PIECES]; 3] =
                [0, 1, 2].map(|axis| std::array::from_fn(|lane| own(lane).1[axis]));
            let values = self.balls.turn_to(tape).eval_by(|axis, coordinate: &mut Taylors<PIECES>| {
                coordinate.set_coordinate(axis, &middles[axis], &radii);
            });
            for (lane, &(_, k)) in batch.iter().enumerate() {
                let (i, middle, radius) = balls[k];
                let (ray, sign) = (pieces[i].0, side.sign());
                let value = values.lane(lane);
                let along = slope_along(&value, rays[ray].direction) * sign;
                let part = middle.map(|x| Interval::around(x, radius));
                let is_defined = self.cells.is_defined_in(&part) || tape.is_defined(&part);
                once[i] = is_defined && Known::Falling.after(value.range * sign, along).is_some();
                looks.costs[ray] += 1.0;
            }
            looks.stats.evaluations += batch.len() as u64;
            looks.stats.work += tape.work() * PIECES as u64;
        }
    }

    /// Whether a ray is proven not to get to a side between `from`, where it is not on it, and `to`.
    pub(super) fn stays_off(&mut self, side: Side, piece: Part, looks: &mut Looks<'_>) -> bool {
        self.follow(side, piece, CUTS, Known::Before, looks) == Some(Known::Before)
    }

    /// What is known at the end of a piece of a ray, given what is at its beginning, unless it may be more
    /// than a crossing.
    fn follow(
        &mut self,
        side: Side,
        (ray, (from, to)): Part,
        cuts: u32,
        known: Known,
        looks: &mut Looks<'_>,
    ) -> Option<Known> {
        let next = self.enclose(side, (ray, (from, to)), looks).and_then(|(f, along)| known.after(f, along));
        if next.is_some() || cuts == 0 {
            return next;
        }
        let mid = from + 0.5 * (to - from);
        let known = self.follow(side, (ray, (from, mid)), cuts - 1, known, looks)?;
        self.follow(side, (ray, (mid, to)), cuts - 1, known, looks)
    }

    /// The field and its derivative along a piece of a ray, turned so that a side is below zero; nothing
    /// where it may have no value.
    fn enclose(
        &mut self,
        side: Side,
        (number, (from, to)): Part,
        Looks { rays, costs, stats }: &mut Looks<'_>,
    ) -> Option<(Interval, Interval)> {
        let ray = &rays[number];
        let region = bounds(ray, (from, to));
        let reach = region.iter().map(|x| x.rad()).fold(0.0, f64::max);
        let tape = self.cells.tape_around(region.map(Interval::mid), reach);
        stats.evaluations += 1;
        stats.work += tape.work();
        costs[number] += 1.0;
        if !self.cells.is_defined_in(&region) && !tape.is_defined(&region) {
            return None;
        }
        // Coordinates of which the first runs along the ray.
        let zero = Interval::point(0.0);
        let p = std::array::from_fn(|axis| Slope {
            value: region[axis],
            grad: [Interval::point(ray.direction[axis]), zero, zero],
            norm: f64::INFINITY,
        });
        let slope = self.slopes.turn_to(tape).eval(&p);
        Some((slope.value * side.sign(), slope.grad[0] * side.sign()))
    }

    /// Whether the field is known, without another evaluation, to have a value everywhere along a piece of a ray.
    pub(super) fn is_surely_defined(&self, ray: &Ray, piece: (f64, f64)) -> bool {
        self.cells.is_defined_in(&bounds(ray, piece))
    }

    /// Whether it has.
    pub(super) fn is_defined(&self, ray: &Ray, piece: (f64, f64)) -> bool {
        let bounds = bounds(ray, piece);
        self.cells.is_defined_in(&bounds) || self.cells.tape().is_defined(&bounds)
    }
}

/// A box that holds a piece of a ray.
fn bounds(ray: &Ray, (from, to): (f64, f64)) -> [Interval; 3] {
    let (a, b, blur) = (ray.at(from), ray.at(to), ray.rounding(to));
    std::array::from_fn(|axis| Interval::new(a[axis], b[axis]) + Interval::radius(blur))
}

/// The slopes in a direction in a ball, in units of it.
fn slope_along(f: &Taylor, direction: DVec3) -> Interval {
    let bent = matrix_by(f.hess, direction).length() + f.turn[1];
    let off = if bent < f.turn[0] { bent } else { f.turn[0] };
    let rounding = 1e-12 * (f.steepness() + f.curvature());
    Interval::around(DVec3::from_array(f.grad).dot(direction), off * (1.0 + 1e-9) + rounding)
}

/// A symmetric matrix, by xx, yy, zz, xy, xz, yz, times a vector.
fn matrix_by([xx, yy, zz, xy, xz, yz]: [f64; 6], v: DVec3) -> DVec3 {
    DVec3::new(DVec3::new(xx, xy, xz).dot(v), DVec3::new(xy, yy, yz).dot(v), DVec3::new(xz, yz, zz).dot(v))
}

/// Rays of a group that are looked at, and where what that costs is added.
pub(super) struct Looks<'a> {
    pub rays: &'a [Ray],
    /// Evaluations for each ray.
    pub costs: &'a mut [f64],
    pub stats: &'a mut CastStats,
}

impl Known {
    /// What is known behind a part over which the field and its derivative are these.
    fn after(self, f: Interval, along: Interval) -> Option<Known> {
        match self {
            Known::Before | Known::Falling if f.lo > 0.0 => Some(Known::Before),
            // The way back.
            Known::Behind if f.lo > 0.0 => None,
            _ if f.hi < 0.0 => Some(Known::Behind),
            _ if along.hi < 0.0 => Some(if self == Known::Behind { self } else { Known::Falling }),
            Known::Before if along.lo > 0.0 => Some(self),
            _ => None,
        }
    }
}

/// A place ahead; no less than the numbers can tell apart, and not beyond the ray.
fn rung(ray: &Ray, t: f64, k: usize) -> f64 {
    let step = ray.tolerance.at(t).max(ROUNDOFF * 16.0 * (ray.origin.abs().max_element() + t.abs()));
    (t + RUNGS[k] * step).min(ray.far).max(t)
}

#[cfg(test)]
mod tests {
    use super::super::Tolerance;
    use super::*;
    use crate::expr::Graph;
    use crate::op::{Mul, Op, Sin};
    use crate::tape::Tape;

    #[test]
    fn a_ray_that_is_proven_to_cross_once_does() {
        // sin(4 x) sin(3 y) sin(5 z)
        let mut graph = Graph::default();
        let mut waves = Vec::new();
        for (input, times) in graph.point().unwrap().into_iter().zip([4.0, 3.0, 5.0]) {
            let times = graph.constant(times).unwrap();
            let fast = graph.op(Op::Mul(Mul), &[input, times]).unwrap();
            waves.push(graph.op(Op::Sin(Sin), &[fast]).unwrap());
        }
        let pair = graph.op(Op::Mul(Mul), &[waves[0], waves[1]]).unwrap();
        let field = graph.op(Op::Mul(Mul), &[pair, waves[2]]).unwrap();
        let cells = Cells::of_sides(Arc::new(Tape::new(&graph, &[field])), &[Interval::new(-9.0, 9.0); 3]);
        let mut passage = Passage::new(Arc::new(cells));
        let tolerance = Tolerance::fixed(1e-6);
        let place =
            |i: f64, far: f64| far * DVec3::new(libm::sin(1.1 * i), libm::cos(1.7 * i), libm::sin(0.7 * i));
        let rays: Vec<Ray> = (0..4000)
            .map(f64::from)
            .map(|i| {
                let direction = place(3.3 * i + 1.0, 1.0).normalize();
                Ray { origin: place(i, 2.0), direction, near: 0.0, far: 4.0, tolerance }
            })
            .collect();
        let pieces: Vec<Part> =
            (0..rays.len()).map(|i| (i, (1.0, 1.0 + 1e-3 * (1 + i % 400) as f64))).collect();
        for side in [Side::Inside, Side::Outside] {
            let mut value = |p: DVec3| passage.values(&[p.to_array()], &mut CastStats::default())[0];
            let kept = |(i, (_, to)): &Part| side.sign() * value(rays[*i].at(*to)) < 0.0;
            let own: Vec<Part> = pieces.iter().copied().filter(kept).collect();
            let (mut costs, mut stats) = (vec![0.0; rays.len()], CastStats::default());
            let mut looks = Looks { rays: &rays, costs: &mut costs, stats: &mut stats };
            let proven = passage.cross_once(side, &own, &mut looks);
            assert_eq!(costs.iter().sum::<f64>(), stats.evaluations as f64);
            let mut found = [0; 2];
            for ((i, (from, to)), proven) in own.into_iter().zip(proven) {
                let at = |k: i32| rays[i].at(from + (to - from) * f64::from(k) / 200.0).to_array();
                let places: Vec<[f64; 3]> = (0..=200).map(at).collect();
                let values = passage.values(&places, &mut CastStats::default());
                let has_left = values
                    .windows(2)
                    .any(|pair| side.sign() * pair[0] < -1e-9 && side.sign() * pair[1] > 1e-9);
                assert!(!(proven && has_left), "{i} {from} {to}");
                found[usize::from(proven)] += usize::from(proven || has_left);
            }
            assert!(found[0] > 30 && found[1] > 1000, "{found:?}");
        }
    }
}
