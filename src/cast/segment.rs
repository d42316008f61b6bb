//! Segment tracing: steps by a Lipschitz bound of the segment ahead (Galin, Guérin, Paris and
//! Peytavie, 2020, *Segment Tracing Using Local Lipschitz Bounds*).
//!
//! Where `f > 0` at the beginning `t` of a segment of length `s` and `f` falls along it no faster than
//! `K`, nothing is met before `t + min(f / K, s)`. The bound is of one direction and of one segment, so
//! it is far below that of all space: a ray that runs past a flank is not held up by its steepness.
//! The next segment is twice as long as the last step.
//!
//! The authors derive `K` by hand for every primitive and operator. Here [`Slope`] encloses value and
//! gradient over a box around the segment, for any expression, and
//!
//! ```text
//! K = min(-min(grad f . d), max |grad f|).
//! ```
//!
//! The enclosure of the value is used as well: a segment over which it excludes zero is passed without
//! asking for the value at its beginning. Where there is no bound, as at a pole and at the tip of a square root,
//! the segment is halved. A ray whose steps get shorter than the tolerance looks one tolerance ahead, where
//! a change of sign is a hit, as in sphere tracing; one that creeps too long is handed over to affine
//! arithmetic. Values and bounds enclose their rounding, and so does the segment's box.

use super::group::{LANES, Strategy};
use super::handover::undecided;
use super::{CastStats, Hit, Ray};
use crate::num::{Interval, Many, Slope};

/// Steps below the tolerance after which a ray is handed over.
const CREEP: u32 = 16;
/// Questions after which any ray is handed over.
const QUESTIONS: u32 = 4096;
/// Length of the next segment, in steps.
const GROWTH: f64 = 2.0;

/// Steps by local Lipschitz bounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentTracing {
    /// Whether any place inside will do.
    pub any: bool,
    /// Whether the field may be torn: then affine arithmetic ends what it begins.
    pub torn: bool,
}

/// What is asked about.
#[derive(Clone, Copy, Debug)]
enum Question {
    /// The segment ahead.
    Segment,
    /// The beginning of the segment, along which the field falls no faster than this.
    Beginning { fall: f64 },
    /// The place one tolerance ahead; the frontier may go on to `t` if there is nothing.
    Ahead { t: f64 },
}

/// Progress of one ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct March {
    /// Everything before is free.
    t: f64,
    /// End of the segment.
    end: f64,
    question: Question,
    crept: u32,
    asked: u32,
}

impl SegmentTracing {
    /// The hit of a ray that is inside at `t`, or on the surface as far as one can tell.
    fn hit(&self, t: f64, certified: bool) -> Hit {
        if self.torn { undecided(t) } else { Hit { t, certified } }
    }

    /// Moves the frontier to `t` and tries a segment of this length next.
    fn advance(&self, ray: &Ray, march: &mut March, t: f64, length: f64) -> Option<Hit> {
        march.t = t;
        if t >= ray.far {
            return Some(Hit::MISS);
        }
        march.end = (t + length.max(ray.tolerance.at(t))).min(ray.far);
        march.question = Question::Segment;
        (march.end <= t).then_some(undecided(t))
    }

    /// The enclosure of the segment ahead.
    fn segment(&self, ray: &Ray, march: &mut March, f: &Slope) -> Option<Hit> {
        let length = march.end - march.t;
        if f.value.lo > 0.0 {
            return self.advance(ray, march, march.end, GROWTH * length);
        }
        if f.value.hi < 0.0 {
            return Some(self.hit(march.t, true));
        }
        let along = (0..3).fold(Interval::point(0.0), |sum, i| sum + f.grad[i] * ray.direction[i]);
        // The direction is a unit vector up to rounding.
        let fall = (-along.lo).min(f.norm * (1.0 + 1e-12)).max(0.0);
        // What rises without bounds may have come down in no time: at a pole.
        if fall.is_finite() && (along.hi.is_finite() || f.norm.is_finite()) {
            march.question = Question::Beginning { fall };
            return None;
        }
        // The bound of a segment that is short enough would say no more than the tolerance allows.
        if length <= ray.tolerance.at(march.t) {
            return Some(undecided(march.t));
        }
        march.end = march.t + 0.5 * length;
        (march.end <= march.t).then_some(undecided(march.t))
    }

    /// The value at the beginning of the segment.
    fn step(&self, ray: &Ray, march: &mut March, f: Interval, fall: f64) -> Option<Hit> {
        if f.lo <= 0.0 || f.hi.is_infinite() {
            // On the surface as far as one can tell, or undefined.
            return Some(self.hit(march.t, f.is_finite()));
        }
        let step = f.lo / fall * (1.0 - 1e-12);
        if step >= march.end - march.t {
            return self.advance(ray, march, march.end, GROWTH * (march.end - march.t));
        }
        let t = march.t + step;
        if step < ray.tolerance.at(march.t) {
            march.question = Question::Ahead { t };
            return None;
        }
        self.advance(ray, march, t, GROWTH * step)
    }
}

impl Strategy for SegmentTracing {
    type Batch = Many<Slope, LANES>;
    type March = March;

    fn any(&self) -> Self {
        SegmentTracing { any: true, ..*self }
    }

    fn start(&self, ray: &Ray) -> March {
        let end = ray.near + (ray.far - ray.near) * 0.25;
        March { t: ray.near, end, question: Question::Segment, crept: 0, asked: 0 }
    }

    fn ask(&self, ray: &Ray, march: &March) -> [Slope; 3] {
        let (a, b) = match march.question {
            Question::Segment => (march.t, march.end),
            Question::Beginning { .. } => (march.t, march.t),
            Question::Ahead { .. } => {
                let ahead = (march.t + ray.tolerance.at(march.t)).min(ray.far);
                (ahead, ahead)
            }
        };
        let (a, b, blur) = (ray.at(a), ray.at(b), ray.rounding(b));
        std::array::from_fn(|i| Slope::coordinate(Interval::new(a[i], b[i]) + Interval::radius(blur), i))
    }

    fn tell(&self, ray: &Ray, march: &mut March, f: &Slope, stats: &mut CastStats) -> Option<Hit> {
        stats.steps += u64::from(matches!(march.question, Question::Segment));
        march.asked += 1;
        if march.asked > QUESTIONS {
            return Some(undecided(march.t));
        }
        if self.any && f.value.hi < 0.0 {
            return Some(self.hit(march.t, true));
        }
        match march.question {
            Question::Segment => self.segment(ray, march, f),
            Question::Beginning { fall } => self.step(ray, march, f.value, fall),
            Question::Ahead { .. } if f.value.hi <= 0.0 => Some(self.hit(march.t, true)),
            Question::Ahead { t } => {
                march.crept += 1;
                if march.crept > CREEP {
                    return Some(undecided(march.t));
                }
                self.advance(ray, march, t, 0.0)
            }
        }
    }
}
