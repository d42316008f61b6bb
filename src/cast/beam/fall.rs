//! Rays that end where the field is known to fall.
//!
//! Where a beam ends because it is too wide for what is ahead, its surface is near. If the field falls along all of its
//! rays in the stretch from the beam's frontier to a little behind the root that is expected, each ray has one root there at
//! most, and values at points find it: with slopes between `-most` and `-least`, the value `f` at a place leaves of the stretch
//!
//! ```text
//! root >= t + f / most,    root <= t + f / least        for f > 0, and the other way round below
//! ```
//!
//! so that a secant closes in on it in three or four values. They are intervals, which hold what is rounded. That the field
//! falls is known from one expansion over a ball around the stretch ([`Taylor`]), which all rays of the beam share.
//!
//! Rays to lights, turned around, end on the surface. Where the field falls all the way from the frontier to their ends, and
//! is above zero there, they are free: that takes one value.

use super::Beam;
use super::bundle::{Bundle, State};
use super::frame::Line;
use super::march::Piece;
use super::thin::{Thin, Want};
use crate::cast::{CastStats, Hit, Ray};
use crate::num::{Interval, Many, Number, Taylor, Taylors};
use crate::tape::{Cells, Evaluator};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Balls that are asked about together, and points.
const BALLS: usize = 8;
const LANES: usize = 32;

/// The gradient may turn by so much of its part along a ray.
const STEADY: f64 = 0.9;

/// Values after which a ray is left to march.
const PATIENCE: u32 = 12;

/// Evaluators for what falls, of a field that is the same expression everywhere.
pub(super) struct Falls {
    cells: Arc<Cells>,
    balls: Evaluator<Taylors<BALLS>>,
    points: Evaluator<Many<Interval, LANES>>,
    roots: Vec<Root>,
}

/// Rays, as they are, and as they look from the frames of their beams.
type Rays<'a> = (&'a [Ray], &'a [Line]);

impl Falls {
    pub(super) fn new(cells: Arc<Cells>) -> Falls {
        let tape = cells.tape();
        let (balls, points) = (Evaluator::new(tape.clone()), Evaluator::new(tape.clone()));
        Falls { balls, points, cells, roots: Vec::new() }
    }

    /// Ends those beams of a list along all of whose rays the field falls. Rays that it says too little of go on alone.
    pub(super) fn end(
        &mut self,
        want: Want,
        beams: &mut Vec<Beam>,
        (rays, lines): Rays<'_>,
        (thin, out, insides, costs): (&mut Vec<Thin>, &mut [Hit], &mut [f64], &mut [f64]),
        stats: &mut CastStats,
        cancel: &AtomicBool,
    ) {
        let fall = self.fall(want, beams, (rays, lines), costs, stats, cancel);
        self.find(rays, costs, stats, cancel);
        for root in &self.roots {
            let ray = &rays[root.ray];
            let hit = match root.known {
                Known::Found => {
                    insides[root.ray] = root.inside(ray);
                    Hit { t: root.between[0].clamp(ray.near, ray.far), certified: true }
                }
                Known::Free => Hit::MISS,
                Known::Asking | Known::Left => {
                    match root.onward(&beams[root.beam], (ray, &lines[root.ray])) {
                        Some(ray) => {
                            thin.push(ray);
                            continue;
                        }
                        None => Hit::MISS,
                    }
                }
            };
            stats.hits += u64::from(hit.is_hit());
            out[root.ray] = hit;
        }
        let mut fall = fall.into_iter();
        beams.retain(|_| fall.next() != Some(true));
    }

    /// Along which beams the field falls; their rays' roots are to be found.
    fn fall(
        &mut self,
        want: Want,
        beams: &[Beam],
        rays: Rays<'_>,
        costs: &mut [f64],
        stats: &mut CastStats,
        cancel: &AtomicBool,
    ) -> Vec<bool> {
        let Falls { cells, balls, roots, .. } = self;
        roots.clear();
        let mut fall = vec![false; beams.len()];
        let stretches: Vec<Stretch> =
            beams.iter().enumerate().filter_map(|(i, beam)| beam.stretch_ahead(i, want, cells)).collect();
        for batch in stretches.chunks(BALLS).take_while(|_| !cancel.load(Ordering::Relaxed)) {
            let mut p = [Taylors::<BALLS>::constant(0.0); 3];
            for lane in 0..BALLS {
                let Stretch { middle, radius, .. } = batch[lane.min(batch.len() - 1)];
                Taylors::set_ball(&mut p, lane, middle, radius);
            }
            let f = *balls.eval(&p);
            stats.evaluations += batch.len() as u64;
            stats.shared += batch.len() as u64;
            stats.steps += batch.len() as u64;
            stats.work += balls.tape().work() * BALLS as u64;
            for (lane, stretch) in batch.iter().enumerate() {
                beams[stretch.beam].charge(rays.1, costs);
                let before = roots.len();
                fall[stretch.beam] = beams[stretch.beam].add_roots(&f.lane(lane), stretch, want, rays, roots);
                if !fall[stretch.beam] {
                    roots.truncate(before);
                }
            }
        }
        fall
    }

    /// Finds roots from values.
    fn find(&mut self, rays: &[Ray], costs: &mut [f64], stats: &mut CastStats, cancel: &AtomicBool) {
        let Falls { points, roots, .. } = self;
        let mut open: Vec<usize> = (0..roots.len()).collect();
        loop {
            open.retain(|&i| roots[i].known == Known::Asking);
            if open.is_empty() || cancel.load(Ordering::Relaxed) {
                return;
            }
            for batch in open.chunks(LANES) {
                let place = |lane: usize| {
                    let Root { ray, at, .. } = roots[batch[lane.min(batch.len() - 1)]];
                    (rays[ray].at(at), rays[ray].rounding(at.abs()))
                };
                let places: [(DVec3, f64); LANES] = std::array::from_fn(place);
                let p = |axis: usize| Many(places.map(|(p, blur)| Interval::around(p[axis], blur)));
                let values = points.eval(&std::array::from_fn(p)).0;
                stats.evaluations += batch.len() as u64;
                stats.steps += batch.len() as u64;
                stats.work += points.tape().work() * LANES as u64;
                for (&i, value) in batch.iter().zip(values) {
                    let root = &mut roots[i];
                    costs[root.ray] += 1.0;
                    root.tell(value, rays[root.ray].tolerance.at(root.between[0]));
                }
            }
        }
    }
}

/// The root of a ray within a stretch along which the field falls.
#[derive(Clone, Copy)]
struct Root {
    /// Its ray's number in the group, and its beam's in the list.
    ray: usize,
    beam: usize,
    want: Want,
    /// Not before, and not behind if there is one at all.
    between: [f64; 2],
    /// Whether there is one.
    is_there: bool,
    /// End of the stretch.
    end: f64,
    /// How steeply the field falls at least, and at most.
    steepness: [f64; 2],
    /// Where its value is asked for.
    at: f64,
    /// Where it was asked for before, and what it was there.
    last: Option<(f64, f64)>,
    asked: u32,
    known: Known,
}

#[derive(Clone, Copy, PartialEq)]
enum Known {
    Asking,
    /// Its root is known to the tolerance.
    Found,
    /// There is none.
    Free,
    /// It goes on by itself.
    Left,
}

impl Root {
    /// Takes the value where it was asked for.
    fn tell(&mut self, f: Interval, tolerance: f64) {
        let ([least, most], at) = (self.steepness, self.at);
        self.asked += 1;
        if self.want == Want::Any {
            self.known = if f.lo > 0.0 { Known::Free } else { Known::Left };
            return;
        }
        self.between[0] = self.between[0].max(at + f.lo / if f.lo > 0.0 { most } else { least });
        let behind = at + f.hi / if f.hi > 0.0 { least } else { most };
        self.is_there |= behind <= self.end;
        self.between[1] = self.between[1].min(behind);
        let [from, to] = self.between;
        if self.is_there && to - from <= 0.5 * tolerance {
            self.known = Known::Found;
            return;
        }
        let value = f.mid();
        let secant = self.last.map_or(f64::NAN, |(t, v)| (value - v) / (t - at));
        let secant = if secant.is_nan() { 0.5 * (least + most) } else { secant.clamp(least, most) };
        let next = (at + value / secant).max(from).min(to);
        if next == at || f.contains(0.0) || from > to || self.asked > PATIENCE {
            self.known = Known::Left;
            return;
        }
        (self.last, self.at) = (Some((at, value)), next);
    }

    /// Where a ray is inside whose root is found: the field falls on behind it.
    fn inside(&self, ray: &Ray) -> f64 {
        let behind = self.between[1] + 0.25 * ray.tolerance.at(self.between[0]);
        if self.between[1].max(self.between[0]) < behind && behind <= self.end {
            behind
        } else {
            f64::INFINITY
        }
    }

    /// The ray, to go on alone from where it is known to be free.
    fn onward(&self, beam: &Beam, (ray, line): (&Ray, &Line)) -> Option<Thin> {
        let mut thin = beam.onward(self.ray, (ray, line), self.want)?;
        let near = self.between[0].min(self.end);
        if near > thin.march.free {
            thin.march.skip(near);
            return (near < ray.far).then_some(thin);
        }
        Some(thin)
    }
}

/// How far behind the last root that is expected the stretch ends, as a share of how far they are apart, and of the beam's
/// radius.
const BEHIND: f64 = 0.25;
const ASIDE: f64 = 0.25;

/// Rays of a beam that is cut no more: larger ones may close yet when they are cut, which takes no value of any ray.
const LAST: usize = 4;

/// Half the longest stretch that is looked at, in radii of the beam.
const LONG: f64 = 4.0;

/// What is ahead of a beam, with the ball around it.
struct Stretch {
    beam: usize,
    piece: Piece,
    middle: [f64; 3],
    radius: f64,
}

impl Beam {
    /// The stretch from the frontier of a beam that has ended, with this number in a list, to a little behind where its rays
    /// are expected to meet the surface, or to their ends; if that is not long beside its width, and the field has a value
    /// all over it.
    fn stretch_ahead(&self, number: usize, want: Want, cells: &Cells) -> Option<Stretch> {
        let Bundle { frame, section, march, state, .. } = &self.bundle;
        if *state != State::Ended || self.bundle.closed().is_some() {
            return None;
        }
        let (free, radius) = (march.free, section.radius(march.free));
        let end = match want {
            Want::First if self.bundle.rays() > LAST => return None,
            Want::First => {
                let [first, last] = self.bundle.expected()?;
                (last + BEHIND * (last - first) + ASIDE * radius).min(march.far)
            }
            Want::Any => march.far,
        };
        let half = 0.5 * (end - free);
        let piece = (half > 0.0 && half <= LONG * radius).then(|| Piece::new(free + half, half))?;
        let (middle, radius) = section.around_piece(frame, piece);
        cells.is_defined_around(middle, radius).then_some(Stretch { beam: number, piece, middle, radius })
    }

    /// Adds the roots of its rays, and says whether the field falls along all of them in the stretch.
    fn add_roots(
        &self,
        f: &Taylor,
        &Stretch { beam, piece, radius, .. }: &Stretch,
        want: Want,
        (rays, lines): Rays<'_>,
        roots: &mut Vec<Root>,
    ) -> bool {
        // Derivatives of expansions are in units of the ball.
        let (grad, turn) = (DVec3::from_array(f.grad) / radius, f.turn[0] / radius);
        if !f.range.is_finite() {
            return false;
        }
        let (frame, free) = (&self.bundle.frame, self.bundle.march.free);
        // What is rounded of slopes.
        let hair = 1e-12 * (grad.length() + turn);
        for i in self.left(lines) {
            let (ray, line) = (&rays[i], &lines[i]);
            let fall = -grad.dot(ray.direction);
            let is_steady = turn < STEADY * fall;
            if !is_steady {
                return false;
            }
            let from = line.distance(free - frame.hair(free)).max(ray.near);
            let end = line.distance(piece.mid + piece.half).min(ray.far).max(from);
            let expected = self.bundle.root(&line.place).filter(|_| want == Want::First);
            roots.push(Root {
                ray: i,
                beam,
                want,
                between: [from, end],
                is_there: false,
                end,
                steepness: [fall - turn - hair, fall + turn + hair],
                at: expected.map_or(end, |depth| line.distance(depth).clamp(from, end)),
                last: None,
                asked: 0,
                known: if from < end { Known::Asking } else { Known::Left },
            });
        }
        true
    }
}
