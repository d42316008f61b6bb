//! Ray casting: where a ray first meets a surface.
//!
//! A caster takes rays in groups, because the work of a group is batched: one instruction of the
//! tape serves many rays.
//!
//! Most casters share one loop (`group.rs`), in which rays never influence one another:
//!
//! | kind | looks at | by | in |
//! |---|---|---|---|
//! | [`Kind::Sphere`], [`Kind::Speculative`] | balls | a Lipschitz bound of all space, which there must be | `sphere.rs` |
//! | [`Kind::Segment`] | segments | a Lipschitz bound of each | `segment.rs` |
//! | [`Kind::Interval`], [`Kind::Standard`], [`Kind::Reduced`] | pieces | an enclosure, halving | `pieces.rs`, `along.rs` |
//! | [`Kind::Affine`] | pieces | reduced affine arithmetic, trimming to where roots may be | likewise |
//!
//! Flowed solids ([`flow`](crate::flow)) are cast by any of them. [`Kind::Bent`] (`bent/`) is for these alone: the
//! heuristic of the thesis; what it finds depends on the group.
//!
//! [`Kind::Beam`] (`beam/`) has rays that go the same way share what is certain of all of them; their hits
//! depend on the group, within the tolerance. [`Kind::Octree`] (`octree/`) has all rays share what is certain of cubes that
//! they pass, where values take long and the field has creases: flows along cellular noise.
//!
//! What rays share can be asked for by itself ([`Reach`], `reach/`): how far all lines through a tile of a picture are
//! free.
//!
//! [`Sifted`] wraps any of them and passes by the parts of a solid that a [`Judge`] rejects.

mod all;
mod along;
mod beam;
mod bent;
mod going;
mod group;
mod handover;
mod later;
mod octree;
mod passage;
mod pieces;
mod reach;
mod segment;
mod sifted;
mod sphere;

pub use all::{Root, Roots, all_hits};
pub use beam::{Bundle, Frame};
pub use later::Later;
pub use reach::{Reach, reach};
pub use sifted::{Judge, Ruling, Sifted};

use crate::field::{Field, lipschitz_until};
use crate::num::{Affine, Interval, ROUNDOFF, Reduced};
use crate::scene::Aabb;
use crate::tape::{Cells, Census, Wanted};
use beam::Beams;
use bent::Bent;
use glam::DVec3;
use group::Group;
use handover::Handover;
use octree::Octree;
use pieces::Pieces;
use segment::SegmentTracing;
use sphere::SphereTracing;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A piece of a line: `origin + t direction` for `near <= t <= far`.
///
/// Casters know nothing of what is outside of the region they were made for, and answer only for rays within it, of
/// finite numbers: [`Aabb::clip`](crate::scene::Aabb::clip) says where a line enters and leaves it. What they say of others
/// means nothing, whether it is called certified or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is zero.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Smallest `t`; zero where the ray begins on a surface.
    pub near: f64,
    /// Largest `t`.
    pub far: f64,
    /// How precisely a hit is wanted.
    pub tolerance: Tolerance,
}

/// How far a hit may lie in front of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// At least this far.
    pub least: f64,
    /// As a share of the distance along the ray: what looks equally precise from the origin.
    pub growth: f64,
}

impl Tolerance {
    /// The same everywhere.
    pub fn fixed(least: f64) -> Self {
        Tolerance { least, growth: 0.0 }
    }

    /// At `t` along a ray.
    pub fn at(&self, t: f64) -> f64 {
        self.least.max(self.growth * t)
    }
}

impl Ray {
    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// How far, on any axis, the computed points up to `t` may lie from the line: a product and a sum
    /// are rounded, for the middle of a piece and for its half length.
    fn rounding(&self, t: f64) -> f64 {
        4.0 * ROUNDOFF * (self.origin.abs().max_element() + t.abs())
    }
}

/// Where a ray meets the surface, or that it does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray of a point within the tolerance of the surface; infinite for a miss.
    pub t: f64,
    /// Whether it is proven that nothing was missed before `t`, and that the field changes sign there or, being
    /// continuous, cannot be told from zero over a piece as short as the tolerance.
    pub certified: bool,
}

impl Hit {
    /// A proven miss.
    pub const MISS: Hit = Hit { t: f64::INFINITY, certified: true };

    /// Whether the surface was met.
    pub fn is_hit(&self) -> bool {
        self.t.is_finite()
    }
}

/// What casting cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct CastStats {
    /// Rays cast.
    pub rays: u64,
    /// Rays that met the surface.
    pub hits: u64,
    /// Evaluations of the field, at points or over pieces of rays.
    pub evaluations: u64,
    /// [Work](crate::tape::Tape::work) of the tapes that were evaluated, times the lanes of their batches,
    /// idle ones included; of cubes that rays share, as if each ray asked by itself.
    pub work: u64,
    /// Of the evaluations, the ones that served a whole beam of rays, or all that pass a cube; these count for each.
    pub shared: u64,
    /// Beams of which every ray was proven to miss at once.
    pub culled: u64,
    /// Steps taken forward, or pieces examined.
    pub steps: u64,
    /// Steps that had to be taken back.
    pub backtracks: u64,
    /// Rays whose answer is not proven.
    pub uncertified: u64,
    /// Of these, the ones that were given up after too many pieces, or for want of a proof of what they met; the
    /// others came by places where the field may jump or is not known to be finite.
    pub given_up: u64,
    /// Places that a [`Judge`] was asked about.
    pub judged: u64,
    /// Of these, the ones that it rejected, so that the rays went on.
    pub rejected: u64,
}

impl std::ops::AddAssign for CastStats {
    fn add_assign(&mut self, o: CastStats) {
        self.rays += o.rays;
        self.hits += o.hits;
        self.evaluations += o.evaluations;
        self.work += o.work;
        self.shared += o.shared;
        self.culled += o.culled;
        self.steps += o.steps;
        self.backtracks += o.backtracks;
        self.uncertified += o.uncertified;
        self.given_up += o.given_up;
        self.judged += o.judged;
        self.rejected += o.rejected;
    }
}

/// A way to find first hits. One value serves one thread; `clone_box` makes another.
pub trait Caster: Send {
    /// First hits of a group of rays, in their order. `out` has as many entries as `rays`. Once
    /// `cancel` is set, rays that are still under way are given up and their entries left alone.
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool);

    /// Whether each ray of a group meets the solid at all, as shadows want to know: like
    /// [`first_hits`](Caster::first_hits), but the solid may be met anywhere behind `t`. Cheaper for
    /// casters that know of a place inside before they have narrowed down the first.
    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.first_hits(rays, out, stats, cancel);
    }

    /// Evaluations of the field that each ray of the last group needed, in their order; one that served
    /// `n` rays of a beam at once is `1 / n` to each of them. Together they are what the group added to
    /// [`CastStats::evaluations`], but for rounding. They are always counted, since that costs nothing
    /// beside an evaluation.
    fn costs(&self) -> &[f64];

    /// Where each ray of the last group is inside wherever the field has a value, if that is known, else infinity; nothing from
    /// casters that do not say. Of rays with first hits most are next to these.
    fn insides(&self) -> &[f64] {
        &[]
    }

    /// The Lipschitz bound of the field by which it takes its steps, if that is how it does: whole tiles can go by the
    /// same, see [`reach`].
    fn lipschitz(&self) -> Option<f64> {
        None
    }

    /// The cells that it has values from, if it cannot do with sides.
    fn values(&self) -> Option<Arc<Cells>> {
        None
    }

    /// The same caster with memory of its own, for another thread.
    fn clone_box(&self) -> Box<dyn Caster>;
}

/// Which caster.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The one that suits the field.
    #[default]
    Auto,
    /// Sphere tracing.
    Sphere,
    /// Speculative sphere tracing.
    Speculative,
    /// Segment tracing.
    Segment,
    /// Interval arithmetic.
    Interval,
    /// Standard affine arithmetic.
    Standard,
    /// Reduced affine arithmetic.
    Reduced,
    /// Reduced affine arithmetic with interval optimisation.
    Affine,
    /// Beams of rays with certificates on both sides.
    Beam,
    /// Cubes that all rays share.
    Octree,
    /// Bent rays against the solid before it flowed: the thesis' heuristic, with samples that rays share; never certified.
    Bent,
}

impl Kind {
    /// All kinds, with the names that the command line uses.
    pub const ALL: [(Kind, &'static str); 11] = [
        (Kind::Beam, "beam"),
        (Kind::Auto, "auto"),
        (Kind::Sphere, "sphere"),
        (Kind::Speculative, "speculative"),
        (Kind::Segment, "segment"),
        (Kind::Interval, "interval"),
        (Kind::Standard, "standard"),
        (Kind::Reduced, "reduced"),
        (Kind::Affine, "affine"),
        (Kind::Octree, "octree"),
        (Kind::Bent, "bent"),
    ];
}

/// Why a caster cannot serve a field.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum CastError {
    /// Sphere tracing without a Lipschitz bound.
    #[error(
        "the field has no Lipschitz bound in the region, so sphere tracing cannot be certain of anything; use the beam caster"
    )]
    NoLipschitzBound,
    /// Bent rays without a flow.
    #[error("the surface is not a flowed solid, which is the only kind that the bent caster knows")]
    NoFlow,
    /// The job was cancelled.
    #[error("the job was cancelled")]
    Stopped,
}

/// A caster for rays within a region, outside of which nothing is known of the field; see [`caster_in`].
///
/// # Errors
/// [`CastError::NoLipschitzBound`] where sphere tracing was asked for and cannot be had.
pub fn caster(
    kind: Kind,
    field: &Field,
    region: &Aabb,
    typical: &[Vec<Ray>],
) -> Result<Box<dyn Caster>, CastError> {
    let cells = Arc::new(Cells::of_sides(field.tape().clone(), &region.intervals()));
    caster_in(kind, field, region, &cells, typical, &AtomicBool::new(false))
}

/// A caster for rays within a region, of which the cells are at hand, [of sides](Cells::of_sides) for most. `typical`
/// bundles of rays, neighbours each, help [`Kind::Auto`] to choose.
///
/// # Errors
/// [`CastError::NoLipschitzBound`] where sphere tracing was asked for and cannot be had; [`CastError::NoFlow`] where bent
/// rays cannot; [`CastError::Stopped`] if `cancel` was set before the caster was there.
pub fn caster_in(
    kind: Kind,
    field: &Field,
    region: &Aabb,
    cells: &Arc<Cells>,
    typical: &[Vec<Ray>],
    cancel: &AtomicBool,
) -> Result<Box<dyn Caster>, CastError> {
    let own = cells.clone();
    match kind {
        Kind::Auto => return Ok(auto(field, region, cells, typical, cancel)),
        Kind::Sphere | Kind::Speculative => {}
        Kind::Segment => {
            let own = own.of_values(&region.intervals());
            return Ok(Box::new(Handover::new(SegmentTracing { any: false, torn: own.is_torn() }, own)));
        }
        Kind::Interval => return Ok(Box::new(Group::new(Pieces::<Interval>::halving(&own), own))),
        Kind::Standard => return Ok(Box::new(Group::new(Pieces::<Affine>::halving(&own), own))),
        Kind::Reduced => return Ok(Box::new(Group::new(Pieces::<Reduced<1>>::halving(&own), own))),
        Kind::Affine => return Ok(Box::new(Group::new(Pieces::<Reduced<1>>::trimming(&own), own))),
        Kind::Beam => return Ok(Box::new(Beams::new(own))),
        Kind::Octree => return octree(field, region, cells, cancel).ok_or(CastError::Stopped),
        Kind::Bent => {
            let flowed = cells.tape().flowed().ok_or(CastError::NoFlow)?;
            // Bent rays go as far out of the region as the flow carries them.
            let reach = flowed.reach(region.min.abs().max(region.max.abs()).max_element()).unwrap_or(0.0);
            let around = Aabb { min: region.min - reach, max: region.max + reach };
            let lipschitz = bound(&Field::of_tape(flowed.field().tape()), &around, cancel)?;
            return Ok(Box::new(Bent::new(flowed.clone(), lipschitz)));
        }
    }
    let relaxation = if kind == Kind::Sphere { 1.0 } else { RELAXATION };
    Ok(spheres(bound(field, region, cancel)?, relaxation, &own.of_values(&region.intervals())))
}

/// Casts through cubes; beams do where the field may jump or have no value.
fn octree(field: &Field, region: &Aabb, cells: &Arc<Cells>, cancel: &AtomicBool) -> Option<Box<dyn Caster>> {
    if cells.is_torn() {
        return Some(Box::new(Beams::new(cells.clone())));
    }
    let cells = cells.of_values(&region.intervals());
    Octree::new(field, region, &cells, cancel).map(|octree| Box::new(octree) as Box<dyn Caster>)
}

/// The Lipschitz bound that sphere tracing needs.
fn bound(field: &Field, region: &Aabb, cancel: &AtomicBool) -> Result<f64, CastError> {
    let found =
        lipschitz_until(field, region, &|| cancel.load(Ordering::Relaxed)).ok_or(CastError::Stopped)?;
    if found.is_finite() && found > 0.0 { Ok(found) } else { Err(CastError::NoLipschitzBound) }
}

fn spheres(lipschitz: f64, relaxation: f64, cells: &Arc<Cells>) -> Box<dyn Caster> {
    Box::new(Handover::new(SphereTracing { lipschitz, relaxation, any: false }, cells.clone()))
}

/// The caster that suits a field, by trial unless it has many choices. Once `cancel` is set, any.
fn auto(
    field: &Field,
    region: &Aabb,
    cells: &Arc<Cells>,
    typical: &[Vec<Ray>],
    cancel: &AtomicBool,
) -> Box<dyn Caster> {
    let beams = || Box::new(Beams::new(cells.clone()));
    let tape = cells.tape();
    if tape.census().carried == 0 && tape.choices().count() > MANY_CHOICES {
        return beams();
    }
    let lipschitz = lipschitz_until(field, region, &|| cancel.load(Ordering::Relaxed));
    let Some(lipschitz) = lipschitz.filter(|&bound| bound > 0.0 && bound < STEEP) else { return beams() };
    let (at_points, along_pieces) = costs(tape.census());
    let taken = |own: &Cells, spent: f64, each: f64| {
        spent / tape.work() as f64 * each + PRUNING * own.prunings().instructions as f64
    };
    let mut most = Vec::new();
    // Each prunes for itself what it needs: small steps need many tapes.
    let whole = region.intervals();
    let own = Arc::new(cells.again(tape.clone(), &whole, Wanted::Sides));
    trial(&mut Beams::new(own.clone()), typical, cancel, |_, spent| {
        most.push(taken(&own, spent, along_pieces));
        most.last().is_some_and(|spent| *spent >= PATIENCE)
    });
    let Some(&all) = most.last() else { return beams() };
    let own = Arc::new(cells.again(tape.clone(), &whole, Wanted::Values));
    let is_lost = |i: usize, spent: f64| {
        let spent = taken(&own, spent, at_points);
        let is_hopeless = most[i] >= TELLING * all && spent > HOPELESS * most[i];
        is_hopeless || spent >= all
    };
    if trial(&mut *spheres(lipschitz, RELAXATION, &own), &typical[..most.len()], cancel, is_lost) {
        return beams();
    }
    let balls = spheres(lipschitz, RELAXATION, &cells.of_values(&whole));
    // Balls that take so long to find are worth sharing.
    let is_carried = cells.is_defined() && tape.census().carried > 0;
    let shared = if is_carried { octree(field, region, cells, cancel) } else { None };
    shared.filter(|cubes| cubes.lipschitz().is_some_and(|bound| bound < STEEP)).unwrap_or(balls)
}

/// What an evaluation at a point costs, and what one along a piece of a line: about as many
/// nanoseconds in batches with AVX-512 (`benches/casting.rs`, `benches/thesis.rs`). Their ratio decides,
/// times the work of each, not the clock, so that the choice, and with it the picture, is the same on every
/// machine.
fn costs(census: Census) -> (f64, f64) {
    let Census { sums, functions, octaves, scattered, .. } = census;
    let [sums, functions, octaves, scattered] = [sums, functions, octaves, scattered].map(|n| n as f64);
    let along = 80.0 + 2.0 * sums + 15.0 * functions + 35.0 * octaves + 2500.0 * scattered;
    (15.0 + 2.0 * (sums + functions) + 10.0 * octaves + 170.0 * scattered, along)
}

/// What it costs to prune a tape, for each instruction that is left; likewise, in scenes of some hundred parts.
const PRUNING: f64 = 100.0;

/// Choices in a tape above which nothing but beams is worth a trial: small steps need the tapes of many small cells.
/// (Measured: ten goblets of five choices each take beams 0.4 of the time, a hundred 0.13, fifty balls 0.3, two hundred 0.1.
/// A building of 330 takes beams 0.19 s at 320x240, and to find that out took 0.08 s.)
const MANY_CHOICES: usize = 64;

/// Lipschitz bound above which sphere tracing is not worth a trial.
const STEEP: f64 = 1e4;

/// Nanoseconds, as [`costs`] counts them, after which a trial takes no further bundle.
const PATIENCE: f64 = 1e10;

/// A trial is lost before its end once it has taken so many times the work that it may, and has had this share of what
/// it may in all.
const HOPELESS: f64 = 2.0;
const TELLING: f64 = 0.25;

/// Casts bundles until one of them is reason to stop, and returns whether one was; `stop` gets the number of each and
/// the work so far.
fn trial(
    caster: &mut dyn Caster,
    bundles: &[Vec<Ray>],
    cancel: &AtomicBool,
    mut stop: impl FnMut(usize, f64) -> bool,
) -> bool {
    let mut stats = CastStats::default();
    bundles.iter().enumerate().any(|(i, rays)| {
        caster.first_hits(rays, &mut vec![Hit::MISS; rays.len()], &mut stats, cancel);
        stop(i, stats.work as f64)
    })
}

/// Over-relaxation of speculative sphere tracing, as Worley and Hart recommend.
const RELAXATION: f64 = 1.46;
