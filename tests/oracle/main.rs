//! A dense-sampling oracle against every caster: no first hit is missed or late by more than the
//! tolerance, hits in front of the surface are where the field is as small as the tolerance allows, and
//! what is not certified is accounted for. The surfaces have thin sheets, creases, unbounded gradients,
//! tangencies, multiple roots, a thousand parts, and planets with detail down to centimetres.
//!
//! The casters that pictures are made with, `auto` and `beam`, get most of the rays. The ordinary test
//! casts a share of them; all of the million:
//!
//! ```text
//! cargo test --release --test oracle -- --ignored --nocapture
//! ```

#[path = "../common/mod.rs"]
mod common;
mod rays;
mod surfaces;
mod truth;

use common::Build;
use orogen::cast::{CastStats, Caster, Hit, Kind, Ray, Root, Roots, all_hits, caster};
use orogen::field::{Field, lipschitz_outside};
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;
use surfaces::Surface;
use truth::{Oracle, Truth};

/// What a caster made of rays.
#[derive(Default)]
struct Tally {
    stats: CastStats,
    /// Rays that meet the surface by the oracle.
    met: usize,
    /// Hits in front of the oracle's.
    early: usize,
    /// Rays for which the first hit and any hit differ.
    differ: usize,
    /// What should not be.
    faults: Vec<String>,
}

impl Tally {
    fn add(mut self, other: Tally) -> Tally {
        self.stats += other.stats;
        self.met += other.met;
        self.early += other.early;
        self.differ += other.differ;
        self.faults.extend(other.faults);
        self
    }
}

/// Casts a tile, and compares it with what the oracle says of it.
fn judge(
    caster: &mut dyn Caster,
    surface: &Surface,
    oracle: &mut Oracle,
    rays: &[Ray],
    truth: &[Truth],
) -> Tally {
    let never = AtomicBool::new(false);
    let mut tally = Tally::default();
    let [mut first, mut any] = [(); 2].map(|()| vec![Hit::MISS; rays.len()]);
    let mut any_stats = CastStats::default();
    caster.first_hits(rays, &mut first, &mut tally.stats, &never);
    let costs: f64 = caster.costs().iter().sum();
    assert!((costs - tally.stats.evaluations as f64).abs() < 1e-6, "costs add up");
    caster.any_hits(rays, &mut any, &mut any_stats, &never);
    for (((ray, truth), first), any) in rays.iter().zip(truth).zip(&first).zip(&any) {
        tally.met += usize::from(truth.first.is_some());
        let early = first.is_hit()
            && first.t < truth.first.unwrap_or(f64::INFINITY) - 2.0 * ray.tolerance.at(first.t);
        tally.early += usize::from(early && first.certified);
        tally.differ += usize::from(first.is_hit() != any.is_hit());
        let fault =
            fault(oracle, surface, ray, truth, first, early).or(fault_of_any(oracle, ray, truth, first, any));
        tally
            .faults
            .extend(fault.map(|what| format!("{what}\n    {ray:?}\n    {truth:?} {first:?} any {any:?}")));
    }
    for stats in [&tally.stats, &any_stats] {
        if !surface.undefined && stats.uncertified != stats.given_up {
            tally.faults.push(format!("{} uncertified, {} given up", stats.uncertified, stats.given_up));
        }
    }
    tally
}

/// What is wrong with a first hit.
fn fault(
    oracle: &mut Oracle,
    surface: &Surface,
    ray: &Ray,
    truth: &Truth,
    hit: &Hit,
    early: bool,
) -> Option<&'static str> {
    if !hit.certified {
        let excused = !surface.undefined || oracle.meets_the_undefined(ray);
        return (!excused).then_some("uncertified where all is defined");
    }
    if let Some(t) = truth.first
        && hit.t > t + ray.tolerance.at(t)
    {
        return Some(if hit.is_hit() { "late" } else { "missed" });
    }
    if !hit.is_hit() {
        return None;
    }
    // Closer and closer to the hit, from a tenth of the way.
    let tolerance = ray.tolerance.at(hit.t);
    let mut before = 0.1 * (hit.t - ray.near);
    while before > 1.01 * tolerance {
        if oracle.value(ray, hit.t - before) <= 0.0 {
            return Some("late, seen from close by");
        }
        before *= 0.7;
    }
    (early && !oracle.grazes(ray, hit.t)).then_some("early where the field is not small")
}

/// What is wrong with any hit.
fn fault_of_any(
    oracle: &mut Oracle,
    ray: &Ray,
    truth: &Truth,
    first: &Hit,
    any: &Hit,
) -> Option<&'static str> {
    if !any.certified || !first.certified {
        return None;
    }
    if !any.is_hit() && truth.first.is_some() {
        return Some("any hit missed");
    }
    if any.t > first.t + ray.tolerance.at(any.t) && any.is_hit() {
        return Some("any hit behind the first");
    }
    let graze = match (first.is_hit(), any.is_hit()) {
        (true, false) => first.t,
        (false, true) => truth.closest,
        _ => return None,
    };
    (!oracle.grazes(ray, graze)).then_some("first hit and any hit differ and do not graze")
}

/// Casters, each with how many rays there are to one that it takes.
type Casters = Vec<(Kind, usize, Box<dyn Caster>)>;

/// Tiles with numbers below a count, by a caster that takes only every so manieth ray.
fn check(surface: &Surface, field: &Field, kinds: &[(Kind, usize)], tiles: usize) -> Vec<(Kind, Tally)> {
    let oracle = || Oracle::new(field, surface.spacing);
    let typical: Vec<Vec<Ray>> =
        [0, 2].map(|number| rays::tile(surface, &mut oracle(), number)[..64].to_vec()).into();
    let bounded = lipschitz_outside(field, &surface.region).is_finite();
    let spheres = [Kind::Sphere, Kind::Speculative];
    let casters: Casters = kinds
        .iter()
        .filter(|(kind, _)| bounded || !spheres.contains(kind))
        .map(|&(kind, every)| {
            let made = caster(kind, field, &surface.region, &typical).expect("a caster");
            (kind, every, made)
        })
        .collect();
    let work: Vec<_> = (0..tiles)
        .map(|n| (n, casters.iter().map(|(k, e, c)| (*k, *e, c.clone_box())).collect::<Casters>()))
        .collect();
    let tile = |(number, casters): (usize, Casters)| {
        let mut oracle = oracle();
        let rays = rays::tile(surface, &mut oracle, number);
        let truth: Vec<Truth> = rays.iter().map(|ray| oracle.ask(ray)).collect();
        let judged = casters.into_iter().map(|(kind, every, mut caster)| {
            let some = |i: &usize| i.is_multiple_of(every);
            let rays: Vec<Ray> = (0..rays.len()).filter(some).map(|i| rays[i]).collect();
            let truth: Vec<Truth> = (0..truth.len()).filter(some).map(|i| truth[i]).collect();
            (kind, judge(&mut *caster, surface, &mut oracle, &rays, &truth))
        });
        judged.collect::<Vec<_>>()
    };
    let tallies: Vec<Vec<(Kind, Tally)>> = work.into_par_iter().map(tile).collect();
    let add = |sum: Vec<(Kind, Tally)>, tallies: Vec<(Kind, Tally)>| {
        sum.into_iter().zip(tallies).map(|((kind, sum), (_, tally))| (kind, sum.add(tally))).collect()
    };
    tallies.into_iter().reduce(add).unwrap_or_default()
}

/// Checks so many tiles of all surfaces, and of costly ones, prints a table, and fails if anything at all
/// is wrong.
fn check_all(kinds: &[(Kind, usize)], [tiles, costly]: [usize; 2]) {
    let mut faults = Vec::new();
    let mut rays = 0;
    println!(
        "{:34} {:12} {:>6} {:>6} early differ given up uncertified evaluations/ray",
        "", "", "rays", "met"
    );
    for surface in &surfaces::all() {
        let mut b = Build::default();
        let root = (surface.build)(&mut b);
        for (kind, tally) in
            check(surface, &b.field(root), kinds, if surface.costly { costly } else { tiles })
        {
            let Tally { stats, met, early, differ, faults: mut found } = tally;
            rays += stats.rays;
            let CastStats { given_up, uncertified, .. } = stats;
            let per_ray = stats.evaluations as f64 / stats.rays as f64;
            println!(
                "{:34} {:12} {:6} {met:6} {early:5} {differ:6} {given_up:8} {uncertified:11} {per_ray:15.1}",
                surface.name,
                format!("{kind:?}"),
                stats.rays
            );
            let makes_pictures = [Kind::Auto, Kind::Beam, Kind::Octree].contains(&kind);
            if makes_pictures && !surface.undefined && 200 * given_up > stats.rays {
                found.push(format!("{given_up} of {} rays given up", stats.rays));
            }
            let count = found.len();
            let named = |fault| format!("{}, {kind:?}, {count} faults: {fault}", surface.name);
            faults.extend(found.into_iter().take(3).map(named));
        }
    }
    println!("{rays} rays");
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn no_hit_is_missed_or_late() {
    check_all(&[(Kind::Auto, 1), (Kind::Beam, 1)], [8, 4]);
}

/// Samples of a ray between two of its roots are all inside the solid or all outside; where it is said to cross the surface, one
/// end is inside and one outside; and where the field has values, nearly all lists of roots are said to be complete.
#[test]
fn no_root_of_all_is_missed() {
    // Of slabs thinner than the tolerance both sides are in one piece.
    let mut of_all = [0, 0];
    for surface in surfaces::all().iter().filter(|surface| !surface.undefined) {
        let mut b = Build::default();
        let root = (surface.build)(&mut b);
        let field = b.field(root);
        let mut oracle = Oracle::new(&field, surface.spacing);
        let rays: Vec<Ray> =
            (0..4).flat_map(|n| rays::tile(surface, &mut oracle, n).into_iter().step_by(11)).collect();
        let mut stats = CastStats::default();
        let found = all_hits(&field, &rays, &mut stats);
        let (mut certified, mut met, mut all, mut crossed) = (0, 0, 0, 0);
        for (ray, Roots { roots, .. }) in rays.iter().zip(&found).filter(|(_, found)| found.certified) {
            certified += 1;
            all += roots.len();
            if let Some(first) = oracle.ask(ray).first.filter(|first| *first > ray.near) {
                let near = ray.tolerance.at(first);
                let has = |root: &Root| root.from - near <= first && first <= root.to + near;
                assert!(roots.iter().any(has), "{}, {ray:?}: the root at {first} is missing", surface.name);
                met += 1;
            }
            let samples = oracle.samples(ray);
            let mut after = ray.near;
            for (from, to) in roots.iter().map(|root| (root.from, root.to)).chain([(ray.far, ray.far)]) {
                assert!(after <= from, "{}, {ray:?}: out of order at {from}", surface.name);
                let between = samples.iter().filter(|(t, _)| *t > after && *t < from);
                let sides: Vec<bool> = between.map(|(_, value)| *value > 0.0).collect();
                let is_one = sides.windows(2).all(|pair| pair[0] == pair[1]);
                assert!(is_one, "{}, {ray:?}: a root between {after} and {from} is missing", surface.name);
                after = to;
            }
            for root in roots.iter().filter(|root| root.crosses) {
                crossed += 1;
                let sides = [root.from, root.to].map(|t| oracle.value(ray, t) > 0.0);
                assert!(sides[0] != sides[1], "{}, {ray:?}: {root:?}", surface.name);
            }
        }
        println!(
            "{:34} {certified} of {} certified, {met} meet it, {all} roots, {crossed} crossed",
            surface.name,
            rays.len()
        );
        of_all = [of_all[0] + crossed, of_all[1] + all];
        assert!(10 * certified >= 9 * rays.len(), "{}: {certified} certified", surface.name);
    }
    assert!(10 * of_all[0] > 9 * of_all[1], "{of_all:?} roots are crossed");
}

/// Marches by steps of a fiftieth, from the first of which that is inside it takes its answer.
struct Strides(Field, Vec<f64>);

impl Caster for Strides {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, _: &AtomicBool) {
        self.1 = vec![0.0; rays.len()];
        stats.rays += rays.len() as u64;
        for (ray, out) in rays.iter().zip(out) {
            let along = |i: u32| ray.near + 0.02 * f64::from(i);
            let inside =
                (0..).map(along).take_while(|&t| t < ray.far).find(|&t| self.0.value(ray.at(t)) <= 0.0);
            *out = Hit { t: inside.unwrap_or(f64::INFINITY), certified: true };
        }
    }

    fn costs(&self) -> &[f64] {
        &self.1
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Strides(self.0.clone(), Vec::new()))
    }
}

#[test]
fn a_caster_that_strides_on_is_found_out() {
    for surface in surfaces::all().iter().filter(|s| ["nested shells", "three octaves"].contains(&s.name)) {
        let mut b = Build::default();
        let root = (surface.build)(&mut b);
        let field = b.field(root);
        let mut oracle = Oracle::new(&field, surface.spacing);
        let rays = rays::tile(surface, &mut oracle, 0);
        let truth: Vec<Truth> = rays.iter().map(|ray| oracle.ask(ray)).collect();
        let tally = judge(&mut Strides(field, Vec::new()), surface, &mut oracle, &rays, &truth);
        let found = |what: &str| tally.faults.iter().any(|fault| fault.starts_with(what));
        assert!(found("late") && tally.faults.len() > 100, "{}: {} faults", surface.name, tally.faults.len());
        assert_eq!(found("missed"), surface.name == "nested shells");
    }
}

#[test]
fn nor_by_any_other_caster() {
    let others = [
        Kind::Octree,
        Kind::Sphere,
        Kind::Speculative,
        Kind::Segment,
        Kind::Interval,
        Kind::Reduced,
        Kind::Affine,
    ];
    let mut kinds: Vec<(Kind, usize)> = others.map(|kind| (kind, 2)).into();
    // An arithmetic that works on one question at a time is slow.
    kinds.push((Kind::Standard, 64));
    check_all(&kinds, [8, 2]);
}

#[test]
#[ignore = "takes minutes"]
fn a_million_rays() {
    check_all(&[(Kind::Auto, 1), (Kind::Beam, 1)], [88, 88]);
}
