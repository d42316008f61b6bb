//! Casting that passes by what a judge rejects: floating crumbs of a solid, and their shadows.
//!
//! A ray goes through a solid from side to side, and somebody else knows which parts of it count:
//!
//! ```text
//!   outside          inside                outside          inside
//! ----------> hit t, judged at q ... exit e, on from r ----------> hit, judged: kept
//!                  rejected
//! ```
//!
//! 1. The solid's own caster finds where the ray enters. A hit lies in front of the surface, so the judge is
//!    asked about a place `q` behind it that is inside, which the caster knows or values tell (`passage.rs`). All
//!    rays of a group are judged together.
//! 2. If it is rejected, a cast of the complement, whose field is `-f`, from `q` finds where the ray leaves
//!    it. Nothing is asked there: up to the exit all is one part of the solid. The ray goes on from a place
//!    `r` behind the exit that is outside.
//! 3. And so on, until something is kept or the ray ends. In what was rejected rays begin next to the
//!    surface, too close to have anything in common: there each marches alone, whichever caster it came by, and so does
//!    one behind it until it is clear of that (`beam/onward.rs`).
//!
//! Where any hit will do, a place inside that the caster knows of is judged first. If that is kept for sure, it does not
//! matter what is before it.
//!
//! A ray that only grazes the solid may find no place inside. Then the closest place within the tolerance is
//! judged: what a caster calls a hit is one as long as it is not rejected. Likewise a gap may be too thin to be
//! outside anywhere: then what is behind it is judged as if the ray had entered it there.
//!
//! *What is certain.* Casters prove that there is nothing on the way to a hit, and nothing but solid on the
//! way to an exit. What is left are the pieces `[t, q]` and `[e, r]`, a few tolerances long, of which
//! `passage.rs` proves that the ray crosses the surface in them once. Then all that the ray met was judged,
//! or is joined along the ray to what was. So a certified hit is the first of what is kept, at most four
//! tolerances in front of it, as far as the judge is right. Where that cannot be proven, the ray goes on, so
//! that nothing is lost that the casters see, but its answer is not certified. A ray of which nothing is
//! rejected has the very hit that the caster without a judge would give it.
//!
//! A ruling without a proof is followed like any other, but nothing that follows from it is certified.

use super::beam::{Beams, Onward};
use super::going::{Going, How, Met, Place, Sifting};
use super::passage::{Ahead, Looks, Part, Passage, Side};
use super::{CastStats, Caster, Hit, Ray};
use crate::scene::Aabb;
use crate::tape::{Cells, Wanted};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What a judge says of a point.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Ruling {
    /// Whether what it belongs to is kept.
    pub kept: bool,
    /// Whether that is proven; else it is as the judge sees fit, but always alike.
    pub proven: bool,
}

/// Says which parts of a solid count.
pub trait Judge: Send {
    /// Rules for each point whether what it belongs to is kept. Points are inside the solid, those of first hits
    /// at most four tolerances behind its surface; where a ray only grazes the solid, they may be outside by less
    /// than the tolerance. There are as many rulings as there are points; what they are once the job is cancelled is of
    /// no interest.
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], cancel: &AtomicBool);

    /// The same judge with memory of its own, for another thread.
    fn clone_box(&self) -> Box<dyn Judge>;
}

/// Parts that a ray may pass by before it is given up.
const PARTS: u32 = 1000;

/// A caster that passes by what a judge rejects; see the module text.
pub struct Sifted {
    solid: Box<dyn Caster>,
    /// The same solid, for rays that have come out of something.
    onward: Onward,
    complement: Beams,
    passage: Passage,
    judge: Box<dyn Judge>,
    costs: Vec<f64>,
}

impl Sifted {
    /// Passes by what `judge` rejects of the solid that `solid` casts within a region, of which the cells
    /// are at hand.
    pub fn new(solid: Box<dyn Caster>, cells: &Arc<Cells>, region: &Aabb, judge: Box<dyn Judge>) -> Sifted {
        // Which parts of the region are free of the complement is another question than which are free of
        // the solid, so it has cells of its own.
        let negated = Arc::new(cells.tape().negated());
        let complement = Arc::new(cells.again(negated, &region.intervals(), Wanted::Sides));
        Sifted {
            solid,
            onward: Onward::new(cells.clone()),
            complement: Beams::alone(complement),
            passage: Passage::new(cells.clone()),
            judge,
            costs: Vec::new(),
        }
    }
}

impl Sifted {
    /// Sends all rays on until they have their answers.
    fn sift(&mut self, work: &mut Sifting<'_>) {
        let mut going = std::mem::take(&mut work.going);
        for part in 0..PARTS {
            going = self.enter(going, part == 0, work);
            if going.is_empty() || work.is_cancelled() {
                return;
            }
            going = self.judge(going, work);
            if work.is_cancelled() {
                return;
            }
            going = self.leave(going, work);
            if going.is_empty() || work.is_cancelled() {
                return;
            }
        }
        for ray in going {
            work.settle(ray.at(ray.place, false), Hit { t: ray.place.t(), certified: false });
        }
    }

    /// Casts free rays to what they meet, by the caster of the solid if nothing was met before, and finds the places to be
    /// judged by. Nothing that was cast counts once the job is cancelled: some hits are not hits.
    fn enter(&mut self, going: Vec<Going>, is_first: bool, work: &mut Sifting<'_>) -> Vec<Going> {
        let (free, mut next): (Vec<Going>, Vec<Going>) =
            going.into_iter().partition(|g| matches!(g.place, Place::Free(_)));
        let caster = if is_first { &mut *self.solid } else { &mut self.onward as &mut dyn Caster };
        let (free, hits) = cast(caster, free, work, &mut self.costs);
        if work.is_cancelled() {
            return Vec::new();
        }
        let mut met = Vec::new();
        for (ray, (hit, inside)) in free.into_iter().zip(hits) {
            let ray = Going { certified: ray.certified && hit.certified, ..ray };
            let (own, t) = (work.ray(&ray), hit.t);
            if !hit.is_hit() {
                work.settle(ray, hit);
            } else if Passage::is_next_to(own, t, inside) && self.passage.is_surely_defined(own, (t, inside))
            {
                next.push(Going { place: Place::Met(Met { t, at: inside, how: How::Known }), ..ray });
            } else {
                met.push((ray, t));
            }
        }
        let places: Vec<(usize, f64)> = met.iter().map(|(ray, t)| (ray.ray, *t)).collect();
        let mut looks = Looks { rays: work.rays, costs: &mut self.costs, stats: &mut work.stats };
        let ahead = self.passage.look(Side::Inside, &places, &mut looks);
        next.extend(met.iter().zip(ahead).map(|(&(ray, t), ahead)| {
            let (at, how) = match ahead {
                Ahead::Crossed(at) => (at, How::Entered),
                Ahead::Along { closest, end } => (closest, How::Grazed { end }),
            };
            Going { place: Place::Met(Met { t, at, how }), ..ray }
        }));
        next
    }

    /// Judges what rays have met; those that have met what is rejected go on.
    fn judge(&mut self, going: Vec<Going>, work: &mut Sifting<'_>) -> Vec<Going> {
        let place = |ray: &Going| {
            let at = if let Place::Met(met) = ray.place { met.at } else { ray.place.t() };
            work.ray(ray).at(at)
        };
        let points: Vec<DVec3> = going.iter().map(place).collect();
        let mut rulings = vec![Ruling { kept: true, proven: false }; points.len()];
        self.judge.judge(&points, &mut rulings, work.cancel);
        if work.is_cancelled() {
            return Vec::new();
        }
        work.stats.judged += points.len() as u64;
        let mut rejected = Vec::new();
        for (ray, ruling) in going.into_iter().zip(rulings) {
            let Place::Met(met) = ray.place else { continue };
            let ray = ray.at(ray.place, ruling.proven);
            if ruling.kept {
                work.settle(ray, Hit { t: met.t, certified: true });
                continue;
            }
            rejected.push((ray, met));
        }
        work.stats.rejected += rejected.len() as u64;
        self.pass_by(rejected, work)
    }

    /// Sends rays on from what they have met that is rejected.
    fn pass_by(&mut self, mut rejected: Vec<(Going, Met)>, work: &mut Sifting<'_>) -> Vec<Going> {
        let rays = work.rays;
        let mut looks = Looks { rays, costs: &mut self.costs, stats: &mut work.stats };
        let is_known = |i: &usize| matches!(rejected[*i].1.how, How::Known);
        let known: Vec<usize> = (0..rejected.len()).filter(is_known).collect();
        let places: Vec<(usize, f64)> = known.iter().map(|&i| (rejected[i].0.ray, rejected[i].1.t)).collect();
        let ahead = self.passage.look(Side::Inside, &places, &mut looks);
        let mut moved = vec![false; rejected.len()];
        for (i, ahead) in known.into_iter().zip(ahead) {
            if let Ahead::Crossed(at) = ahead {
                moved[i] = at > rejected[i].1.at;
                rejected[i].1.at = rejected[i].1.at.max(at);
            }
        }
        let is_entry = |how: How| matches!(how, How::Entered | How::Known);
        let entries: Vec<Part> = rejected
            .iter()
            .filter(|(_, met)| is_entry(met.how))
            .map(|(ray, met)| (ray.ray, (met.t, met.at)))
            .collect();
        let mut once = self.passage.cross_once(Side::Inside, &entries, &mut looks).into_iter();
        let mut next = Vec::new();
        for ((ray, Met { t, at, how }), moved) in rejected.into_iter().zip(moved) {
            let (place, proven) = match how {
                // Behind something that is thinner than the tolerance there may be something else.
                How::Known if moved => match once.next() {
                    Some(true) => (Place::Rejected(at), true),
                    _ => (Place::Met(Met { t, at, how: How::Entered }), false),
                },
                How::Entered | How::Known => (Place::Rejected(at), once.next() == Some(true)),
                How::Grazed { end } => {
                    let stays_off = self.passage.stays_off(Side::Inside, (ray.ray, (t, end)), &mut looks);
                    (Place::Free(end), stays_off)
                }
                How::Stayed => {
                    let stays_in = self.passage.stays_off(Side::Outside, (ray.ray, (t, at)), &mut looks);
                    (Place::Rejected(at), stays_in)
                }
            };
            next.push(ray.at(place, proven));
        }
        next.retain(|ray| {
            let is_over = matches!(ray.place, Place::Free(end) if end >= rays[ray.ray].far);
            if is_over {
                work.settle(*ray, Hit::MISS);
            }
            !is_over
        });
        next
    }

    /// Where the rays that the caster was asked for any hits of are inside of something that is kept for sure, as far as is
    /// known.
    fn kept(&mut self, hits: &[Hit], work: &mut Sifting<'_>) -> Vec<Option<f64>> {
        let mut kept = vec![None; hits.len()];
        let known = self.solid.insides().iter().copied().enumerate();
        let mut met: Vec<(usize, f64)> = known.filter(|(i, t)| t.is_finite() && hits[*i].is_hit()).collect();
        // By enclosures they are inside, wherever the field has a value.
        let is_defined: Vec<bool> =
            met.iter().map(|&(i, t)| self.passage.is_surely_defined(&work.rays[i], (t, t))).collect();
        let open = met.iter().zip(&is_defined).filter(|(_, is_defined)| !**is_defined);
        let places: Vec<[f64; 3]> = open.map(|(&(i, t), _)| work.rays[i].at(t).to_array()).collect();
        let mut values = self.passage.values(&places, &mut work.stats).into_iter();
        let mut is_defined = is_defined.into_iter();
        met.retain(|(i, _)| {
            let is_known = is_defined.next() == Some(true);
            self.costs[*i] += f64::from(u8::from(!is_known));
            is_known || values.next().is_some_and(|value| value < 0.0)
        });
        let points: Vec<DVec3> = met.iter().map(|&(i, t)| work.rays[i].at(t)).collect();
        let mut rulings = vec![Ruling { kept: false, proven: false }; points.len()];
        self.judge.judge(&points, &mut rulings, work.cancel);
        if work.is_cancelled() {
            return kept;
        }
        work.stats.judged += points.len() as u64;
        work.stats.rejected += rulings.iter().filter(|ruling| !ruling.kept).count() as u64;
        for ((i, t), ruling) in met.into_iter().zip(rulings) {
            kept[i] = (ruling.kept && ruling.proven).then_some(t);
        }
        kept
    }

    /// Takes rays out of what was rejected.
    fn leave(&mut self, going: Vec<Going>, work: &mut Sifting<'_>) -> Vec<Going> {
        let (within, mut next): (Vec<Going>, Vec<Going>) =
            going.into_iter().partition(|g| matches!(g.place, Place::Rejected(_)));
        let (within, exits) = cast(&mut self.complement, within, work, &mut self.costs);
        if work.is_cancelled() {
            return Vec::new();
        }
        let mut left = Vec::new();
        for (ray, (exit, _)) in within.into_iter().zip(exits) {
            let Place::Rejected(from) = ray.place else { continue };
            let own = work.ray(&ray);
            // What is undefined is empty: of neither the solid nor, for its caster, the complement.
            let is_whole = self.passage.is_defined(own, (from, exit.t.min(own.far)));
            let ray = Going { certified: ray.certified && exit.certified && is_whole, ..ray };
            if exit.is_hit() {
                left.push((ray, exit.t));
            } else {
                work.settle(ray, Hit::MISS);
            }
        }
        let rays = work.rays;
        let mut looks = Looks { rays, costs: &mut self.costs, stats: &mut work.stats };
        let places: Vec<(usize, f64)> = left.iter().map(|(ray, t)| (ray.ray, *t)).collect();
        let ahead = self.passage.look(Side::Outside, &places, &mut looks);
        let crossed = |((ray, t), ahead): (&(Going, f64), &Ahead)| match *ahead {
            Ahead::Crossed(to) => Some((ray.ray, (*t, to))),
            Ahead::Along { .. } => None,
        };
        let exits: Vec<Part> = left.iter().zip(&ahead).filter_map(crossed).collect();
        let mut once = self.passage.cross_once(Side::Outside, &exits, &mut looks).into_iter();
        for ((ray, t), ahead) in left.into_iter().zip(ahead) {
            match ahead {
                Ahead::Crossed(to) => {
                    let ray = ray.at(Place::Free(to), once.next() == Some(true));
                    if to >= rays[ray.ray].far {
                        work.settle(ray, Hit::MISS);
                    } else {
                        next.push(ray);
                    }
                }
                Ahead::Along { end, .. } => {
                    next.push(Going { place: Place::Met(Met { t, at: end, how: How::Stayed }), ..ray });
                }
            }
        }
        next
    }
}

/// Casts rays from where they are; returns them with their hits, and where they are inside, as far as the caster says.
fn cast(
    caster: &mut dyn Caster,
    going: Vec<Going>,
    work: &mut Sifting<'_>,
    costs: &mut [f64],
) -> (Vec<Going>, Vec<(Hit, f64)>) {
    if going.is_empty() {
        return (going, Vec::new());
    }
    // Rays keep their places in the group, by which casters know which ones are next to one another.
    let mut rays: Vec<Ray> =
        work.rays.iter().map(|ray| Ray { near: f64::INFINITY, far: f64::NEG_INFINITY, ..*ray }).collect();
    for ray in &going {
        rays[ray.ray] = Ray { near: ray.place.t(), ..*work.ray(ray) };
    }
    let mut hits = vec![Hit::MISS; rays.len()];
    caster.first_hits(&rays, &mut hits, &mut work.stats, work.cancel);
    costs.iter_mut().zip(caster.costs()).for_each(|(all, cost)| *all += cost);
    let insides = caster.insides();
    let found = |ray: &Going| (hits[ray.ray], insides.get(ray.ray).copied().unwrap_or(f64::INFINITY));
    let hits = going.iter().map(found).collect();
    (going, hits)
}

impl Sifted {
    /// Sifts rays, and counts each once.
    fn run(&mut self, mut work: Sifting<'_>, stats: &mut CastStats) {
        self.sift(&mut work);
        // A ray may be given up more than once.
        work.total.given_up = (work.given_up + work.stats.given_up).min(work.total.uncertified);
        *stats += CastStats { rays: 0, hits: 0, uncertified: 0, given_up: 0, ..work.stats };
        *stats += work.total;
    }
}

impl Caster for Sifted {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.costs.clear();
        self.costs.resize(rays.len(), 0.0);
        let mut work = Sifting::new(rays, out, CastStats::default(), cancel);
        work.going = rays.iter().enumerate().map(|(i, ray)| Going::new(i, ray.near, true)).collect();
        self.run(work, stats);
    }

    /// Rays that meet nothing at all are settled by the solid's caster alone, in whichever way is quickest
    /// for it, and those that it finds inside of something that is kept for sure by that. Of the others a first
    /// hit that is kept is needed.
    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut own = CastStats::default();
        self.solid.any_hits(rays, &mut hits, &mut own, cancel);
        self.costs.clear();
        self.costs.extend_from_slice(self.solid.costs());
        own.uncertified = 0;
        let mut work = Sifting::new(rays, out, own, cancel);
        let kept = self.kept(&hits, &mut work);
        if !work.is_cancelled() {
            for ((i, &hit), inside) in hits.iter().enumerate().zip(kept) {
                // All before it is free.
                let ray = Going::new(i, hit.t, hit.certified);
                match inside {
                    Some(t) => work.settle(ray, Hit { t, ..hit }),
                    None if hit.is_hit() => work.going.push(ray),
                    None => work.settle(ray, hit),
                }
            }
        }
        self.run(work, stats);
    }

    fn lipschitz(&self) -> Option<f64> {
        self.solid.lipschitz()
    }

    fn values(&self) -> Option<Arc<Cells>> {
        self.solid.values()
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Sifted {
            solid: self.solid.clone_box(),
            onward: self.onward.again(),
            complement: self.complement.again(),
            passage: self.passage.again(),
            judge: self.judge.clone_box(),
            costs: Vec::new(),
        })
    }
}
