//! What a judge rejects, rays pass by: nothing that is kept is missed, and nothing that is rejected is met.

mod common;

use common::Build;
use glam::DVec3;
use orogen::cast::{CastStats, Caster, Hit, Judge, Kind, Ray, Ruling, Sifted, Tolerance, caster, caster_in};
use orogen::expr::NodeId;
use orogen::op::{self, Op};
use orogen::scene::Aabb;
use orogen::tape::Cells;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const TOLERANCE: f64 = 1e-4;
const REGION: f64 = 1.6;
const KINDS: [Kind; 4] = [Kind::Beam, Kind::Sphere, Kind::Affine, Kind::Auto];

/// Judges each point by itself.
#[derive(Clone)]
struct By<F>(F);

impl<F: Fn(DVec3) -> bool + Clone + Send + 'static> Judge for By<F> {
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], _: &AtomicBool) {
        for (point, ruling) in points.iter().zip(rulings) {
            *ruling = Ruling { kept: (self.0)(*point), proven: true };
        }
    }
    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(self.clone())
    }
}

/// A solid of which some is kept.
struct Sieve {
    name: &'static str,
    build: Build,
    whole: NodeId,
    /// What is kept, alone.
    main: NodeId,
    keeps: fn(DVec3) -> bool,
}

impl Sieve {
    fn sifted(&self, kind: Kind, judge: impl Judge + 'static) -> Box<dyn Caster> {
        let region = Aabb::cube(REGION);
        let field = self.build.field(self.whole);
        let cells = Arc::new(Cells::of_sides(field.tape().clone(), &region.intervals()));
        let solid =
            caster_in(kind, &field, &region, &cells, &[rays(1)[..200].to_vec()], &AtomicBool::new(false))
                .expect("a caster");
        Box::new(Sifted::new(solid, &cells, &region, Box::new(judge)))
    }

    /// A caster of what is kept alone.
    fn alone(&self) -> Box<dyn Caster> {
        caster(Kind::Affine, &self.build.field(self.main), &Aabb::cube(REGION), &[]).expect("a caster")
    }
}

/// The part of space between two spheres.
fn shell(b: &mut Build, inner: f64, outer: f64) -> NodeId {
    let (outer, inner) = (b.sphere([0.0; 3], outer), b.sphere([0.0; 3], inner));
    let beyond = b.neg(inner);
    b.max(outer, beyond)
}

/// A ball with crumbs around it, in front and behind, touching nothing.
fn ball_and_crumbs() -> Sieve {
    let mut b = Build::default();
    let main = b.sphere([0.0; 3], 0.8);
    let mut whole = main;
    for k in 0..60 {
        let t = f64::from(k);
        let height = (2.0 * t + 1.0) / 60.0 - 1.0;
        let ring = (1.0 - height * height).sqrt();
        let centre = [ring * libm::cos(2.4 * t), height, ring * libm::sin(2.4 * t)].map(|c| 1.1 * c);
        let crumb = b.sphere(centre, 0.03 + 0.0015 * t);
        whole = b.min(whole, crumb);
    }
    Sieve { name: "ball and crumbs", build: b, whole, main, keeps: |p| p.length() < 0.9 }
}

/// A hollow ball, a crumb in it, and one outside.
fn hollow() -> Sieve {
    let mut b = Build::default();
    let main = shell(&mut b, 0.6, 1.0);
    let within = b.sphere([0.1, 0.1, 0.0], 0.3);
    let outside = b.sphere([1.2, 0.3, 0.0], 0.2);
    let (whole, keeps): (_, fn(DVec3) -> bool) =
        (b.min(main, within), |p| (0.55..1.02).contains(&p.length()));
    let whole = b.min(whole, outside);
    Sieve { name: "hollow", build: b, whole, main, keeps }
}

/// Shells in shells, every other one kept, some of them thin.
fn shells() -> Sieve {
    let mut b = Build::default();
    let all = [(1.39, 1.4), (1.199, 1.2), (0.9, 1.0), (0.8, 0.801), (0.4, 0.6), (0.0, 0.3)]
        .map(|(inner, outer)| shell(&mut b, inner, outer));
    let whole = all.into_iter().reduce(|f, s| b.min(f, s)).expect("shells");
    let main = b.min(all[1], all[3]);
    let main = b.min(main, all[5]);
    let keeps = |p: DVec3| {
        [(1.15, 1.25), (0.75, 0.85), (0.0, 0.35)].iter().any(|&(a, b)| (a..b).contains(&p.length()))
    };
    Sieve { name: "shells", build: b, whole, main, keeps }
}

/// A noisy solid that is cut into two.
fn noisy() -> Sieve {
    let mut b = Build::default();
    let f = common::three_octaves(&mut b);
    let [x, ..] = b.p();
    let off = b.op(Op::Abs(op::Abs), &[x]);
    let (gap, beyond) = (b.neg(off), b.neg(x));
    let (gap, beyond) = (b.shifted(gap, 0.02), b.shifted(beyond, 0.02));
    let (whole, main) = (b.max(f, gap), b.max(f, beyond));
    Sieve { name: "noisy", build: b, whole, main, keeps: |p| p.x > 0.0 }
}

/// A gap that is thinner than the tolerance, and in it a sheet that is thinner still; the ball is kept.
fn thin_gap() -> Sieve {
    let mut b = Build::default();
    let main = b.sphere([0.0; 3], 0.8);
    let around = shell(&mut b, 0.8 + 4e-5, 0.9);
    let sheet = shell(&mut b, 0.8 + 1e-5, 0.8 + 2e-5);
    let whole = b.min(main, around);
    let whole = b.min(whole, sheet);
    Sieve { name: "thin gap", build: b, whole, main, keeps: |p| p.length() < 0.8 + 5e-6 }
}

fn sieves() -> [Sieve; 5] {
    [ball_and_crumbs(), hollow(), shells(), noisy(), thin_gap()]
}

fn unit(rng: &mut StdRng) -> DVec3 {
    loop {
        let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        if v.length() > 0.1 && v.length() < 1.0 {
            return v.normalize();
        }
    }
}

/// Rays from all around, some past the edges of balls; bundles from one eye; and rays that begin anywhere.
fn rays(seed: u64) -> Vec<Ray> {
    let mut rng = StdRng::seed_from_u64(seed);
    let region = Aabb::cube(REGION);
    let mut out = Vec::new();
    while out.len() < 6000 {
        let n = out.len();
        let (origin, aim, near) = match n % 4 {
            0 => {
                let origin = 4.0 * unit(&mut rng);
                let side = origin.cross(unit(&mut rng)).normalize();
                let radius = [0.3, 0.6, 0.8, 0.9, 1.0, 1.2][n / 4 % 6];
                (origin, side * radius * (1.0 + 1e-3 * unit(&mut rng).x), f64::NEG_INFINITY)
            }
            1 => (1.4 * unit(&mut rng) * rng.random_range(0.0..1.0), 2.0 * unit(&mut rng), 0.0),
            2 => (4.0 * unit(&mut rng), unit(&mut rng), f64::NEG_INFINITY),
            _ => (DVec3::new(1.0, 2.0, -3.0), 0.2 * unit(&mut rng), f64::NEG_INFINITY),
        };
        let direction = (aim - origin).normalize();
        let tolerance = Tolerance::fixed(TOLERANCE);
        if let Some((first, far)) = region.clip(origin, direction) {
            out.push(Ray { origin, direction, near: near.max(first), far, tolerance });
        }
    }
    out
}

fn first(caster: &mut dyn Caster, rays: &[Ray]) -> (Vec<Hit>, CastStats) {
    let (mut hits, mut stats) = (vec![Hit::MISS; rays.len()], CastStats::default());
    for (rays, hits) in rays.chunks(512).zip(hits.chunks_mut(512)) {
        let before = stats.evaluations;
        caster.first_hits(rays, hits, &mut stats, &AtomicBool::new(false));
        let costs: f64 = caster.costs().iter().sum();
        assert!((costs - (stats.evaluations - before) as f64).abs() < 1e-6, "costs add up");
    }
    check(&hits, &stats);
    (hits, stats)
}

fn any(caster: &mut dyn Caster, rays: &[Ray]) -> (Vec<Hit>, CastStats) {
    any_in_groups(caster, rays, rays.len())
}

/// In groups of so many rays.
fn any_in_groups(caster: &mut dyn Caster, rays: &[Ray], size: usize) -> (Vec<Hit>, CastStats) {
    let (mut hits, mut stats) = (vec![Hit::MISS; rays.len()], CastStats::default());
    for (rays, hits) in rays.chunks(size).zip(hits.chunks_mut(size)) {
        let before = stats.evaluations;
        caster.any_hits(rays, hits, &mut stats, &AtomicBool::new(false));
        let costs: f64 = caster.costs().iter().sum();
        assert!((costs - (stats.evaluations - before) as f64).abs() < 1e-6, "costs add up");
    }
    check(&hits, &stats);
    for (ray, hit) in rays.iter().zip(&hits) {
        let on_ray = (ray.near - TOLERANCE..=ray.far + TOLERANCE).contains(&hit.t);
        assert!(on_ray || !hit.is_hit(), "{ray:?}: {hit:?}");
    }
    (hits, stats)
}

/// Counts are those of the hits.
fn check(hits: &[Hit], stats: &CastStats) {
    let count = |what: fn(&Hit) -> bool| hits.iter().filter(|h| what(h)).count() as u64;
    assert_eq!(stats.rays, hits.len() as u64);
    assert_eq!(stats.hits, count(Hit::is_hit));
    assert_eq!(stats.uncertified, count(|h| !h.certified));
    assert_eq!(stats.given_up, stats.uncertified, "all is defined");
}

#[test]
fn hits_are_those_of_what_is_kept_alone() {
    for sieve in sieves() {
        let rays = rays(2);
        let (truth, _) = first(&mut *sieve.alone(), &rays);
        let mut main = sieve.build.field(sieve.main);
        for kind in KINDS {
            let mut caster = sieve.sifted(kind, By(sieve.keeps));
            let (hits, stats) = first(&mut *caster, &rays);
            let (shadows, _) = any(&mut *caster, &rays);
            // Rays from surfaces, each for itself: they share no beam that was turned around.
            let alone: Vec<Ray> = rays.iter().copied().filter(|ray| ray.near == 0.0).take(400).collect();
            let together = any(&mut *caster, &alone).0;
            let differ = any_in_groups(&mut *caster, &alone, 1)
                .0
                .iter()
                .zip(&together)
                .filter(|(a, b)| a.is_hit() != b.is_hit())
                .count();
            assert!(differ * 100 < alone.len(), "{}, {kind:?}: {differ} differ", sieve.name);
            let (mut grazing, mut unproven) = (0, 0);
            for ((ray, truth), (hit, shadow)) in rays.iter().zip(&truth).zip(hits.iter().zip(&shadows)) {
                let differs = |hit: &Hit| hit.is_hit() != truth.is_hit();
                let is_close = |t: f64| main.clone().value(ray.at(t)) < 2.0 * TOLERANCE;
                if differs(hit)
                    || differs(shadow)
                    || hit.is_hit() && (hit.t - truth.t).abs() > 5.0 * TOLERANCE
                {
                    // Nothing that is kept is missed unless that is said. What casters may call a hit or not
                    // is as close to the surface as the tolerance.
                    let missed = truth.is_hit() && hit.t > truth.t + 5.0 * TOLERANCE;
                    let at = if missed { truth.t } else { hit.t.min(shadow.t) };
                    assert!(
                        !hit.certified || is_close(at),
                        "{}, {kind:?}: {ray:?} {hit:?} {truth:?}",
                        sieve.name
                    );
                    grazing += 1;
                }
                unproven += usize::from(!hit.certified);
            }
            println!("{}, {kind:?}: {grazing} graze, {unproven} unproven, {stats:?}", sieve.name);
            assert!(grazing * 100 < rays.len(), "{}, {kind:?}: {grazing} differ", sieve.name);
            // In a gap thinner than the tolerance nothing but the sheet is certain.
            if sieve.name != "thin gap" {
                assert!(unproven * 100 < rays.len(), "{}, {kind:?}: {unproven} unproven", sieve.name);
            }
            assert!(stats.rejected > 100 && stats.judged > stats.rejected);
        }
        main.value(DVec3::ZERO);
    }
}

#[test]
fn who_keeps_all_changes_nothing() {
    let rays = rays(3);
    for sieve in sieves() {
        for kind in KINDS {
            let mut sifted = sieve.sifted(kind, By(|_| true));
            let field = sieve.build.field(sieve.whole);
            let mut plain = caster(kind, &field, &Aabb::cube(REGION), &[self::rays(1)[..200].to_vec()])
                .expect("a caster");
            let (expected, plainly) = first(&mut *plain, &rays);
            let (found, stats) = first(&mut *sifted, &rays);
            assert_eq!(found, expected, "{}, {kind:?}", sieve.name);
            assert_eq!((stats.judged, stats.rejected), (plainly.hits, 0));
            assert_eq!(first(&mut *sifted.clone_box(), &rays).0, found, "{}, {kind:?}", sieve.name);
        }
    }
}

#[test]
fn who_rejects_all_sees_nothing() {
    let rays = rays(4);
    for sieve in sieves() {
        for kind in KINDS {
            let mut sifted = sieve.sifted(kind, By(|_| false));
            for (hits, stats) in [first(&mut *sifted, &rays), any(&mut *sifted, &rays)] {
                assert_eq!(stats.hits, 0, "{}, {kind:?}", sieve.name);
                let unproven = hits.iter().filter(|h| !h.certified).count();
                let few = if sieve.name == "thin gap" { rays.len() } else { rays.len() / 100 };
                assert!(unproven < few, "{}, {kind:?}: {unproven} unproven", sieve.name);
            }
        }
    }
}

/// A judge never hears of places that are neither inside nor as close to the solid as the tolerance.
#[test]
fn judges_are_asked_about_places_inside() {
    for sieve in [ball_and_crumbs(), noisy(), thin_gap()] {
        let field = sieve.build.field(sieve.whole);
        let inside = Arc::new(std::sync::Mutex::new((field, [0_u32; 2])));
        let seen = inside.clone();
        let judge = move |p: DVec3| {
            let (field, [within, grazing]) = &mut *seen.lock().expect("one thread");
            let value = field.value(p);
            *(if value < 0.0 { within } else { grazing }) += 1;
            assert!(
                value < 5.0 * TOLERANCE && value > -80.0 * TOLERANCE || p.length() < 1.41,
                "{p}: {value}"
            );
            p.x > 0.0
        };
        first(&mut *sieve.sifted(Kind::Beam, By(judge)), &rays(5));
        let [within, grazing] = inside.lock().expect("one thread").1;
        assert!(within > 500 && grazing * 50 < within, "{}: {within} inside, {grazing} not", sieve.name);
    }
}

/// Keeps one half, and has a proof for the other alone, or for neither.
#[derive(Clone)]
struct Guess {
    is_sure_of_rejections: bool,
}

impl Judge for Guess {
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], _: &AtomicBool) {
        for (point, ruling) in points.iter().zip(rulings) {
            let kept = point.x > 0.0;
            *ruling = Ruling { kept, proven: !kept && self.is_sure_of_rejections };
        }
    }
    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(self.clone())
    }
}

/// What a judge only supposes is nothing that a ray's answer could be certified by.
#[test]
fn rulings_without_proof_certify_nothing() {
    let sieve = ball_and_crumbs();
    for is_sure_of_rejections in [true, false] {
        let mut caster = sieve.sifted(Kind::Auto, Guess { is_sure_of_rejections });
        let (all, rays) = (self::rays(7), sieve.sifted(Kind::Auto, By(|_| true)));
        let (mut plain, mut passed) = (rays, [0_u32; 2]);
        let mut whole = vec![Hit::MISS; all.len()];
        plain.first_hits(&all, &mut whole, &mut CastStats::default(), &AtomicBool::new(false));
        let (hits, _) = first(&mut *caster, &all);
        for (hit, whole) in hits.iter().zip(&whole) {
            // What met nothing needed no ruling; a hit is kept without a proof.
            assert!(!hit.is_hit() || !hit.certified, "{hit:?}");
            if whole.is_hit() && !hit.is_hit() {
                passed[usize::from(hit.certified)] += 1;
            }
        }
        let [guessed, certain] = passed;
        assert!(
            if is_sure_of_rejections { certain > 100 } else { guessed > 100 && certain == 0 },
            "{passed:?}"
        );
    }
}

#[test]
fn rays_that_begin_inside() {
    let sieve = ball_and_crumbs();
    let ray = |x: f64, far: f64| Ray {
        origin: DVec3::new(x, 0.0, 0.0),
        direction: DVec3::X,
        near: 0.0,
        far,
        tolerance: Tolerance::fixed(TOLERANCE),
    };
    let mut b = Build::default();
    let (crumb, main) = (b.sphere([-1.0, 0.0, 0.0], 0.25), b.sphere([0.0; 3], 0.5));
    let whole = b.min(crumb, main);
    let sieve = Sieve { build: b, whole, main, keeps: |p| p.x > -0.6, ..sieve };
    for kind in KINDS {
        let mut caster = sieve.sifted(kind, By(sieve.keeps));
        // In a crumb, in the main body, in a crumb to the very end, and single points.
        let rays =
            [ray(-1.1, 2.0), ray(0.1, 2.0), ray(-1.1, 0.2), ray(-1.1, 0.0), ray(0.0, 0.0), ray(-0.6, 0.0)];
        let (hits, stats) = first(&mut *caster, &rays);
        assert!(
            (hits[0].t - 0.6).abs() <= TOLERANCE && hits[1].t == 0.0 && hits[4].t == 0.0,
            "{kind:?}: {hits:?}"
        );
        assert!([2, 3, 5].iter().all(|&i| hits[i] == Hit::MISS), "{kind:?}: {hits:?}");
        assert_eq!((stats.judged, stats.rejected, stats.uncertified), (6, 3, 0), "{kind:?}");
    }
}

/// A ball that is cut by all faces of the region: nothing is known beyond these, where rays that are clipped to it begin by as
/// little as is rounded.
#[test]
fn rays_that_begin_where_the_region_cuts_a_solid() {
    const CUT: f64 = 0.4;
    let mut build = Build::default();
    let whole = build.sphere([0.0; 3], 0.5);
    let (field, region) = (build.field(whole), Aabb::cube(CUT));
    let mut rng = StdRng::seed_from_u64(14);
    let mut rays = Vec::new();
    while rays.len() < 400 {
        let (origin, at) = (2.0 * unit(&mut rng), 0.3 * unit(&mut rng));
        let direction = (at - origin).normalize();
        let Some((near, far)) = region.clip(origin, direction).filter(|ends| ends.0 <= ends.1) else {
            continue;
        };
        if (origin + near * direction).length() < 0.45 {
            rays.push(Ray { origin, direction, near, far, tolerance: Tolerance::fixed(TOLERANCE) });
        }
    }
    for kind in [Kind::Beam, Kind::Auto] {
        let cells = Arc::new(Cells::of_sides(field.tape().clone(), &region.intervals()));
        let solid =
            caster_in(kind, &field, &region, &cells, &[rays[..200].to_vec()], &AtomicBool::new(false))
                .expect("a caster");
        let judge = By(|p: DVec3| p.abs().max_element() <= CUT);
        let (hits, stats) = first(&mut Sifted::new(solid, &cells, &region, Box::new(judge)), &rays);
        let begins = |(hit, ray): (&Hit, &Ray)| (hit.t - ray.near).abs() <= TOLERANCE;
        assert!(hits.iter().zip(&rays).all(begins), "{kind:?}");
        assert_eq!((stats.rejected, stats.uncertified), (0, 0), "{kind:?}");
    }
}

#[test]
fn what_is_cancelled_is_left_alone() {
    let sieve = hollow();
    let mut caster = sieve.sifted(Kind::Affine, By(sieve.keeps));
    let untouched = Hit { t: 0.5, certified: false };
    let rays = &rays(6)[..300];
    let mut hits = vec![untouched; rays.len()];
    let mut stats = CastStats::default();
    caster.first_hits(rays, &mut hits, &mut stats, &AtomicBool::new(true));
    caster.any_hits(rays, &mut hits, &mut stats, &AtomicBool::new(true));
    assert!(hits.iter().all(|h| *h == untouched) && stats.judged == 0);
}

/// Where the field has no value there is nothing, and rays that leave a crumb there are not certified.
#[test]
fn crumbs_that_end_where_nothing_is_defined() {
    let mut b = Build::default();
    let [_, y, _] = b.p();
    let root = b.op(Op::Sqrt(op::Sqrt), &[y]);
    let nothing = b.scaled(1e-3, root);
    let ball = b.sphere([0.0; 3], 0.5);
    let hemisphere = b.add(ball, nothing);
    let sieve = Sieve { name: "hemisphere", build: b, whole: hemisphere, main: hemisphere, keeps: |_| false };
    let down = Ray {
        origin: DVec3::new(0.1, 1.0, 0.1),
        direction: -DVec3::Y,
        near: 0.0,
        far: 2.0,
        tolerance: Tolerance::fixed(TOLERANCE),
    };
    let mut hits = [Hit::MISS];
    let mut stats = CastStats::default();
    let mut caster = sieve.sifted(Kind::Beam, By(sieve.keeps));
    caster.first_hits(&[down], &mut hits, &mut stats, &AtomicBool::new(false));
    assert!(!hits[0].is_hit() && !hits[0].certified && stats.rejected > 0, "{hits:?} {stats:?}");
}
