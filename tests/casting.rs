//! What casters promise beside finding first hits (which `tests/oracle` checks): hits do not depend on
//! how rays are grouped, lists of roots are complete, any hit agrees with the first, and rays end.

mod common;

use common::Build;
use glam::DVec3;
use orogen::cast::{CastStats, Hit, Kind, Ray, Roots, Tolerance, all_hits, caster};
use orogen::expr::NodeId;
use orogen::field::Field;
use orogen::op::{self, Op};
use orogen::scene::Aabb;
use orogen::script::{Request, compile};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::sync::atomic::AtomicBool;

const TOLERANCE: f64 = 1e-4;
const RAYS: usize = 17_000;
const REGION: f64 = 1.6;

/// Rays from all around; one in four grazes the unit sphere, one in four runs along the ground.
fn rays(seed: u64) -> Vec<Ray> {
    let mut rng = StdRng::seed_from_u64(seed);
    let region = Aabb::cube(REGION);
    let mut out = Vec::with_capacity(RAYS);
    while out.len() < RAYS {
        let mut unit = || loop {
            let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        };
        let (origin, aim) = match out.len() % 4 {
            0 => {
                let o = 4.0 * unit();
                // Past the edge of a ball of radius near 1.
                let side = o.cross(unit()).normalize();
                (o, side * (1.0 + 0.05 * unit().x))
            }
            1 => {
                let u = unit();
                (DVec3::new(4.0 * u.x, 0.03 + 0.02 * u.y, 4.0 * u.z), 0.02 * unit())
            }
            _ => (4.0 * unit(), unit()),
        };
        let direction = (aim - origin).normalize();
        if let Some((near, far)) = region.clip(origin, direction) {
            out.push(Ray {
                origin,
                direction,
                near: near.max(0.0),
                far,
                tolerance: Tolerance::fixed(TOLERANCE),
            });
        }
    }
    out
}

const ALL: [Kind; 10] = [
    Kind::Sphere,
    Kind::Speculative,
    Kind::Segment,
    Kind::Interval,
    Kind::Standard,
    Kind::Reduced,
    Kind::Affine,
    Kind::Beam,
    Kind::Octree,
    Kind::Auto,
];

/// The casters that need no Lipschitz bound.
fn boundless() -> Vec<Kind> {
    ALL.into_iter().filter(|k| ![Kind::Sphere, Kind::Speculative].contains(k)).collect()
}

#[test]
fn ridges_without_a_lipschitz_bound() {
    let mut b = Build::default();
    let root = common::square_root_ridges(&mut b);
    for kind in [Kind::Sphere, Kind::Speculative] {
        let refused = caster(kind, &b.field(root), &Aabb::cube(REGION), &[]);
        assert!(refused.is_err(), "{kind:?} has no bound to stand on");
    }
}

#[test]
fn all_roots_in_order() {
    let mut b = Build::default();
    let root = common::three_octaves(&mut b);
    let mut field = b.field(root);
    let rays = &rays(3)[..2000];
    let mut stats = CastStats::default();
    let found = all_hits(&field, rays, &mut stats);
    let mut many = 0;
    let mut crossed = [0; 2];
    for (ray, Roots { roots, certified }) in rays.iter().zip(&found) {
        assert!(certified);
        assert!(roots.windows(2).all(|w| w[0].to < w[1].from), "{roots:?} out of order");
        // Between roots the sign never changes; across most of them it does.
        let mut from = ray.near;
        for end in roots.iter().map(|r| r.from).chain([ray.far]) {
            let sign = field.value(ray.at(0.5 * (from + end))) > 0.0;
            for i in 1..200 {
                let t = from + (end - from) * f64::from(i) / 200.0;
                assert_eq!(field.value(ray.at(t)) > 0.0, sign, "{ray:?}: a root before {end} is missing");
            }
            from = roots.iter().find(|r| r.from == end).map_or(ray.far, |r| r.to);
        }
        many += usize::from(roots.len() > 2);
        for root in roots {
            let [a, b] = [root.from, root.to].map(|t| field.value(ray.at(t)) > 0.0);
            assert!(!root.crosses || a != b, "{ray:?}: {root:?}");
            crossed[usize::from(root.crosses)] += 1;
        }
    }
    assert!(crossed[1] > 20 * crossed[0], "{crossed:?} roots");
    assert!(many > 20, "only {many} rays with more than two roots");
}

/// Rays that run towards one point, as a map of heights has them, are a beam like those from one point.
#[test]
fn rays_towards_a_point_are_cast_as_beams() {
    let mut b = Build::default();
    let root = common::three_octaves(&mut b);
    let region = Aabb::cube(REGION);
    let ray = |i: usize| {
        let (x, y) = ((i % 8) as f64 + (i / 512 * 8) as f64, (i / 8 % 64) as f64);
        let direction = -orogen::scene::direction(0.05 * x, 0.05 * y);
        let near = region.clip(DVec3::ZERO, direction).map_or(0.0, |(near, _)| near);
        Ray { origin: DVec3::ZERO, direction, near, far: 0.0, tolerance: Tolerance::fixed(1e-10) }
    };
    let rays: Vec<Ray> = (0..4096).map(ray).collect();
    let cast = |kind: Kind| {
        let mut made = caster(kind, &b.field(root), &region, &[]).expect("a caster");
        let (mut hits, mut stats) = (vec![Hit::MISS; rays.len()], CastStats::default());
        made.first_hits(&rays, &mut hits, &mut stats, &AtomicBool::new(false));
        (hits, stats)
    };
    let ((beams, cost), (affine, _)) = (cast(Kind::Beam), cast(Kind::Affine));
    for (ray, (beam, affine)) in rays.iter().zip(beams.iter().zip(&affine)) {
        assert!(beam.certified && affine.certified && beam.is_hit(), "{ray:?}");
        assert!((beam.t - affine.t).abs() < 1e-9, "{ray:?}: {beam:?} {affine:?}");
    }
    assert!(cost.shared > 100 && cost.evaluations < 6 * rays.len() as u64, "{cost:?}");
}

/// Where a beam's answer closes in on all of its roots, no ray asks for itself; what it says of each is as good.
#[test]
fn beams_close_where_a_solid_is_flat() {
    let mut b = Build::default();
    // A wedge of two planes with a ball in front of it.
    let [x, _, z] = b.p();
    let mut plane = |across: f64, along: f64| {
        let (across, along) = (b.scaled(across, x), b.scaled(along, z));
        b.add(across, along)
    };
    let slopes = [plane(0.6, 0.8), plane(-0.28, 0.96)];
    let (wedge, ball) = (b.max(slopes[0], slopes[1]), b.sphere([0.0, 0.0, 0.0], 0.7));
    let root = b.min(wedge, ball);
    let field = b.field(root);
    let ray = |i: usize| {
        let place = |k: usize| 2.4 * (k as f64 + 0.5) / 128.0 - 1.2;
        // Z-order, as pictures have it.
        let every_other = |i: usize| (0..7).fold(0, |out, bit| out | (i >> (2 * bit) & 1) << bit);
        let origin = DVec3::new(place(every_other(i)), place(every_other(i >> 1)), 4.0);
        Ray { origin, direction: DVec3::NEG_Z, near: 1.0, far: 7.0, tolerance: Tolerance::fixed(1e-3) }
    };
    let rays: Vec<Ray> = (0..128 * 128).map(ray).collect();
    let region = Aabb::cube(3.0);
    let cast = |kind: Kind| {
        let mut made = caster(kind, &field, &region, &[]).expect("a caster");
        let (mut hits, mut stats) = (vec![Hit::MISS; rays.len()], CastStats::default());
        made.first_hits(&rays, &mut hits, &mut stats, &AtomicBool::new(false));
        (hits, stats)
    };
    let ((beams, cost), (affine, _)) = (cast(Kind::Beam), cast(Kind::Affine));
    for (ray, (beam, affine)) in rays.iter().zip(beams.iter().zip(&affine)) {
        assert!(beam.certified && affine.certified, "{ray:?}");
        assert!(beam.is_hit() == affine.is_hit(), "{ray:?}: {beam:?} {affine:?}");
        assert!(!beam.is_hit() || (beam.t - affine.t).abs() <= 2e-3, "{ray:?}: {beam:?} {affine:?}");
    }
    assert_eq!(cost.hits, beams.iter().filter(|hit| hit.is_hit()).count() as u64);
    assert!(2 * (cost.evaluations - cost.shared) < rays.len() as u64, "{cost:?}");
}

/// Where a field falls along all rays of a beam, values at points end them: at the root, or as free, whatever part of the line
/// each has.
#[test]
fn rays_along_which_a_ball_comes_near_end_where_they_meet_it() {
    let mut b = Build::default();
    let ball = b.sphere([0.0; 3], 1.0);
    let mut made = caster(Kind::Beam, &b.field(ball), &Aabb::cube(REGION), &[]).expect("a caster");
    let never = AtomicBool::new(false);
    // Where a line enters and leaves the ball.
    let chord = |ray: &Ray| {
        let (along, far) = (ray.origin.dot(ray.direction), ray.origin.length_squared() - 1.0);
        let root = (along * along - far).sqrt();
        [-along - root, -along + root]
    };
    let mut rng = StdRng::seed_from_u64(23);
    let mut rays = picture(DVec3::new(1.0, 2.0, -3.0), 0.25);
    for ray in rays.iter_mut().step_by(5) {
        let [enters, _] = chord(ray);
        let near = enters + rng.random_range(-0.3..0.1);
        (ray.near, ray.far) = match rng.random_range(0..4) {
            0 => (near, near),
            1 => (near, ray.far),
            2 => (ray.near, near),
            _ => (enters - 0.5 * TOLERANCE, ray.far),
        };
    }
    let mut hits = [Hit::MISS, Hit::MISS].map(|hit| vec![hit; rays.len()]);
    let mut cost = CastStats::default();
    made.first_hits(&rays, &mut hits[0], &mut cost, &never);
    assert_eq!(cost.hits, hits[0].iter().filter(|hit| hit.is_hit()).count() as u64);
    assert!(cost.evaluations < 6 * rays.len() as u64, "{cost:?}");
    made.any_hits(&rays, &mut hits[1], &mut cost, &never);
    let mut met = 0;
    for (i, ray) in rays.iter().enumerate() {
        let [enters, leaves] = chord(ray);
        let begins = ray.near.max(enters);
        let is_met = enters.is_finite() && begins <= ray.far.min(leaves);
        let [first, any] = [&hits[0][i], &hits[1][i]];
        assert!(first.certified && any.certified, "{ray:?}: {first:?} {any:?}");
        assert!(first.is_hit() == is_met && any.is_hit() == is_met, "{ray:?}: {first:?} {any:?}");
        // Where a bracket as narrow as the tolerance has been closed, the root is taken that is expected in it.
        let ahead = begins - first.t;
        assert!(!is_met || (-1e-3 * TOLERANCE..=TOLERANCE).contains(&ahead), "{ray:?}: {first:?} {ahead}");
        met += u32::from(is_met);
    }
    assert!(met > 2000 && (met as usize) < rays.len() - 300, "{met}");
    // To a light: nothing is in the way from places on its side; from those below the surface there is.
    let light = DVec3::new(0.3, 0.9, -0.3).normalize();
    let region = Aabb::cube(REGION);
    let to_light = |(i, (ray, hit)): (usize, (&Ray, &Hit))| {
        let at = ray.at(hit.t).normalize() * if i % 7 == 0 { 1.0 - 1e-3 } else { 1.0 + TOLERANCE };
        let (_, far) = region.clip(at, light)?;
        let is_lit = hit.is_hit() && at.dot(light) > 0.02;
        is_lit.then_some(Ray { origin: at, direction: light, near: 0.0, far, tolerance: ray.tolerance })
    };
    let onward: Vec<Ray> = rays.iter().zip(&hits[0]).enumerate().filter_map(to_light).collect();
    let mut shadows = vec![Hit::MISS; onward.len()];
    let mut cost = CastStats::default();
    made.any_hits(&onward, &mut shadows, &mut cost, &never);
    assert!(cost.evaluations < 3 * onward.len() as u64, "{cost:?}");
    for (ray, shadow) in onward.iter().zip(&shadows) {
        let is_below = ray.origin.length() < 1.0;
        assert!(shadow.certified && shadow.is_hit() == is_below, "{ray:?}: {shadow:?}");
    }
    assert!(onward.len() > 1000);
}

/// Rays that begin in front of a surface by less than depths are rounded are not inside of what is behind them.
#[test]
fn what_is_just_behind_where_rays_begin_is_not_hit() {
    let mut b = Build::default();
    // A cavity from x = -1 to 1.
    let [x, ..] = b.p();
    let square = b.op(Op::Mul(op::Mul), &[x, x]);
    let fallen = b.neg(square);
    let root = b.shifted(fallen, 1.0);
    let field = b.field(root);
    let mut made = caster(Kind::Beam, &field, &Aabb::cube(200.0), &[]).expect("a caster");
    for after in [5e-13, 1e-12, 2e-12, 4e-12, 1e-11] {
        let ray = |i: usize| Ray {
            origin: DVec3::new(-3.0, 100.0 + 1e-3 * (i % 8) as f64, 1e-3 * (i / 8) as f64),
            direction: DVec3::X,
            near: 2.0 + after,
            far: 10.8,
            tolerance: Tolerance::fixed(1e-3),
        };
        let rays: Vec<Ray> = (0..64).map(ray).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        made.first_hits(&rays, &mut hits, &mut CastStats::default(), &AtomicBool::new(false));
        for hit in hits {
            assert!(hit.certified && (hit.t - 4.0).abs() <= 1e-3, "{after:e}: {hit:?}");
        }
    }
}

/// However steep a field is elsewhere, rays do not begin inside for that.
#[test]
fn an_enormous_bound_makes_no_hits() {
    let mut b = Build::default();
    let ball = b.sphere([0.0; 3], 1.0);
    let [x, ..] = b.p();
    let wall = b.shifted(x, 1.4);
    let wall = b.neg(wall);
    let wall = b.scaled(1e40, wall);
    let root = b.max(ball, wall);
    let mut field = b.field(root);
    let rays = &rays(6)[..500];
    for kind in [Kind::Sphere, Kind::Speculative] {
        let mut made = caster(kind, &field, &Aabb::cube(REGION), &[]).expect("a caster");
        let mut hits = vec![Hit::MISS; rays.len()];
        made.first_hits(rays, &mut hits, &mut CastStats::default(), &AtomicBool::new(false));
        for (ray, hit) in rays.iter().zip(&hits) {
            let value = field.value(ray.at(hit.t));
            let begins_inside = hit.t == ray.near && value <= 0.0;
            let is_right = !hit.is_hit() || begins_inside || value.abs() < 2.0 * TOLERANCE;
            assert!(is_right, "{kind:?}, {ray:?}: {hit:?}, where f = {value}");
        }
        let met = hits.iter().filter(|hit| hit.is_hit()).count();
        assert!((50..rays.len()).contains(&met), "{met}");
    }
}

#[test]
fn any_grouping_gives_the_same_hits() {
    let mut b = Build::default();
    let root = common::three_octaves(&mut b);
    // Rays of a beam share what they find, so that their hits agree to within the tolerance only.
    // Bent ones are for flowed solids.
    for (kind, _) in Kind::ALL.into_iter().filter(|k| ![Kind::Beam, Kind::Bent].contains(&k.0)) {
        let fresh = || {
            caster(kind, &b.field(root), &Aabb::cube(REGION), &[rays(4)[..100].to_vec()]).expect("a caster")
        };
        let rays = &rays(4)[..700];
        let mut whole = vec![Hit::MISS; rays.len()];
        fresh().first_hits(rays, &mut whole, &mut CastStats::default(), &AtomicBool::new(false));
        for size in [1, 7, 64] {
            let mut made = fresh();
            let mut parts = vec![Hit::MISS; rays.len()];
            for (rays, out) in rays.chunks(size).zip(parts.chunks_mut(size)) {
                made.first_hits(rays, out, &mut CastStats::default(), &AtomicBool::new(false));
            }
            assert_eq!(whole, parts, "{kind:?} in groups of {size}");
        }
    }
}

#[test]
fn any_hits_are_those_rays_that_have_a_first_hit() {
    type Scene = fn(&mut Build) -> NodeId;
    let scenes: [Scene; 3] = [common::three_octaves, common::thin_shell, common::square_root_ridges];
    let never = AtomicBool::new(false);
    for (n, build) in scenes.into_iter().enumerate() {
        let mut b = Build::default();
        let root = build(&mut b);
        let mut field = b.field(root);
        let rays = &rays(5)[..2000];
        let kinds = if n == 2 { boundless() } else { ALL.to_vec() };
        for kind in kinds {
            let mut made =
                caster(kind, &field, &Aabb::cube(REGION), &[rays[..100].to_vec()]).expect("a caster");
            let mut found = [vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]];
            let [mut first_cost, mut any_cost] = [CastStats::default(); 2];
            made.first_hits(rays, &mut found[0], &mut first_cost, &never);
            made.any_hits(rays, &mut found[1], &mut any_cost, &never);
            let mut grazing = 0;
            for ((ray, first), any) in rays.iter().zip(&found[0]).zip(&found[1]) {
                assert!(any.certified, "scene {n}, {kind:?}: {ray:?}");
                if any.is_hit() == first.is_hit() {
                    assert!(any.t <= first.t + TOLERANCE, "scene {n}, {kind:?}: {any:?} behind {first:?}");
                } else {
                    // Where a ray comes within the tolerance without meeting anything, either is right.
                    let value = field.value(ray.at(any.t.min(first.t)));
                    assert!(value < 0.1, "scene {n}, {kind:?}: {any:?} but {first:?}, where f = {value}");
                    grazing += 1;
                }
            }
            assert!(grazing * 200 < rays.len(), "scene {n}, {kind:?}: {grazing} answers differ");
            assert_eq!(any_cost.rays, first_cost.rays);
            let (any, first) = (any_cost.evaluations, first_cost.evaluations);
            println!("scene {n}, {kind:?}: {any} evaluations instead of {first}");
            // Beams look from the far ends of rays instead, which is no better for rays that begin in free
            // space; `auto` may have chosen them.
            if ![Kind::Beam, Kind::Auto].contains(&kind) {
                assert!(any <= first, "scene {n}, {kind:?}: {any} evaluations instead of {first}");
            }
            if [Kind::Speculative, Kind::Affine].contains(&kind) {
                assert!(any < first, "scene {n}, {kind:?}: nothing saved");
            }
        }
    }
}

/// Twice as many parts that nobody sees, here balls buried under as many on the ground, are a tenth more work for rays at most.
#[test]
fn what_nobody_sees_costs_rays_little() {
    let rays = pixels(DVec3::new(0.4, 4.0, 1.5), 0.3, 7);
    let work = |buried: u32| {
        let mut b = Build::default();
        let [_, y, _] = b.p();
        let mut balls = vec![y];
        for i in 0..900 {
            let place = |k: u32| 0.1 * (f64::from(k) - 14.5);
            balls.push(b.sphere([place(i % 30), 0.02, place(i / 30)], 0.04));
        }
        for i in 0..buried {
            let [x, y, z] = [7, 11, 13].map(|k| f64::from(i * k % 2003) / 2003.0);
            balls.push(b.sphere([3.0 * x - 1.5, -1.5 + 0.4 * y, 3.0 * z - 1.5], 0.02));
        }
        let field =
            balls.into_iter().reduce(|all, ball| b.min(all, ball)).map(|all| b.field(all)).expect("balls");
        let mut beams = caster(Kind::Auto, &field, &Aabb::cube(REGION), &[]).expect("a caster");
        let (mut hits, mut stats) = (vec![Hit::MISS; rays.len()], CastStats::default());
        beams.first_hits(&rays, &mut hits, &mut stats, &AtomicBool::new(false));
        println!("{buried} buried: {} evaluations, work {}", stats.evaluations, stats.work);
        stats.work as f64
    };
    let taken = [900, 1800].map(work);
    assert!(taken[1] < 1.1 * taken[0], "{taken:?}");
}

/// Rays through the pixels of a small picture, in Morton's order.
fn picture(eye: DVec3, half: f64) -> Vec<Ray> {
    pixels(eye, half, 6)
}

/// The same of a picture with `2^bits` pixels along each side.
fn pixels(eye: DVec3, half: f64, bits: usize) -> Vec<Ray> {
    let side = 1 << bits;
    let region = Aabb::cube(REGION);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::new(0.3, 1.0, 0.2)).normalize();
    let every_other = |i: usize| (0..bits).fold(0, |x, bit| x | (i >> (2 * bit) & 1) << bit);
    (0..side * side)
        .map(|i| {
            let place = |k: usize| half * ((k as f64 + 0.5) / (0.5 * side as f64) - 1.0);
            let (x, y) = (place(every_other(i)), place(every_other(i >> 1)));
            let direction = (forward + x * right + y * right.cross(forward)).normalize();
            let (near, far) = region.clip(eye, direction).unwrap_or((0.0, -1.0));
            Ray { origin: eye, direction, near: near.max(0.0), far, tolerance: Tolerance::fixed(TOLERANCE) }
        })
        .collect()
}

#[test]
fn beams_find_what_lone_rays_find() {
    type Scene = fn(&mut Build) -> NodeId;
    let scenes: [(Scene, DVec3, f64); 6] = [
        (common::slopes_of_wavelets, DVec3::new(1.0, 2.0, -3.0), 0.4),
        (common::three_octaves, DVec3::new(0.4, 0.9, -4.0), 0.4),
        (common::thin_shell, DVec3::new(3.0, 1.0, -2.0), 0.4),
        (common::thin_rings, DVec3::new(1.0, 3.0, -2.0), 0.15),
        (common::balls, DVec3::new(-2.0, 2.0, 3.0), 0.4),
        (common::square_root_ridges, DVec3::new(0.0, 1.0, -4.0), 0.4),
    ];
    for (n, (build, eye, half)) in scenes.into_iter().enumerate() {
        let mut b = Build::default();
        let root = build(&mut b);
        let rays = picture(eye, half);
        let mut found = [Vec::new(), Vec::new(), Vec::new()];
        for (out, (kind, size)) in
            found.iter_mut().zip([(Kind::Affine, 4096), (Kind::Beam, 4096), (Kind::Beam, 1)])
        {
            let mut made =
                caster(kind, &b.field(root), &Aabb::cube(REGION), &[rays[..200].to_vec()]).expect("a caster");
            out.resize(rays.len(), Hit::MISS);
            for (rays, out) in rays.chunks(size).zip(out.chunks_mut(size)) {
                made.first_hits(rays, out, &mut CastStats::default(), &AtomicBool::new(false));
            }
        }
        let hits = found[0].iter().filter(|h| h.is_hit()).count();
        assert!(hits > 300, "scene {n}: only {hits} hits");
        let mut field = b.field(root);
        let mut grazing = 0;
        for (i, a) in found[0].iter().enumerate() {
            for b in [&found[1][i], &found[2][i]] {
                assert!(b.certified, "scene {n}: {:?}", rays[i]);
                // One may stop where the surface is within the tolerance though not along the ray.
                let first = rays[i].at(a.t.min(b.t));
                let differ = (a.t - b.t).abs() > 2.0 * TOLERANCE || a.is_hit() != b.is_hit();
                if differ && field.value(first).abs() > 2.0 * TOLERANCE {
                    grazing += 1;
                }
            }
        }
        // Where a ray comes within the tolerance without meeting anything, either answer is right.
        assert!(grazing * 200 < rays.len(), "scene {n}: {grazing} hits differ");
    }
}

/// Rays that go on from where those of a picture ended, a few tolerances above the surface, along directions that differ
/// by so much.
fn onward(field: &mut Field, seen: &[Ray], hits: &[Hit], spread: f64) -> Vec<Ray> {
    let mut rng = StdRng::seed_from_u64(12);
    let mut rays = Vec::new();
    for (ray, hit) in seen.iter().zip(hits).filter(|(_, hit)| hit.is_hit()) {
        let at = ray.at(hit.t);
        let normal = field.gradient(at).1.normalize();
        let origin = at + 4.0 * TOLERANCE * normal;
        let aside = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let direction = (DVec3::new(0.5, 0.8, -0.4) + spread * aside).normalize();
        if normal.dot(direction) > 0.0
            && let Some((_, far)) = Aabb::cube(REGION).clip(origin, direction)
        {
            rays.push(Ray { origin, direction, near: 0.0, far, tolerance: Tolerance::fixed(TOLERANCE) });
        }
    }
    rays
}

/// The same rays through a lens: what is as far off as the origin is sharp.
fn through_a_lens(rays: &[Ray]) -> Vec<Ray> {
    let mut rng = StdRng::seed_from_u64(13);
    let blurred = rays.iter().map(|ray| {
        let focus = ray.at(ray.origin.length());
        let aside = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-0.02..0.02)));
        let origin = ray.origin + aside;
        let direction = (focus - origin).normalize();
        let (near, far) = Aabb::cube(REGION).clip(origin, direction).unwrap_or((1.0, 0.0));
        Ray { origin, direction, near, far, ..*ray }
    });
    blurred.collect()
}

#[test]
fn rays_alongside_one_another_find_what_lone_rays_find() {
    type Scene = fn(&mut Build) -> NodeId;
    let scenes: [(Scene, DVec3, f64); 4] = [
        (common::three_octaves, DVec3::new(0.4, 0.9, -4.0), 0.4),
        (common::thin_rings, DVec3::new(1.0, 3.0, -2.0), 0.15),
        (common::balls, DVec3::new(-2.0, 2.0, 3.0), 0.4),
        (common::square_root_ridges, DVec3::new(0.0, 1.0, -4.0), 0.4),
    ];
    let never = AtomicBool::new(false);
    for (n, (build, eye, half)) in scenes.into_iter().enumerate() {
        let mut b = Build::default();
        let root = build(&mut b);
        let mut field = b.field(root);
        let make = |kind| caster(kind, &b.field(root), &Aabb::cube(REGION), &[]).expect("a caster");
        let (mut lone, mut beams) = (make(Kind::Affine), make(Kind::Beam));
        let seen = picture(eye, half);
        let mut hits = vec![Hit::MISS; seen.len()];
        lone.first_hits(&seen, &mut hits, &mut CastStats::default(), &never);
        let mut groups = vec![through_a_lens(&seen)];
        groups.extend([1e-3, 0.02, 0.2, 3.0].map(|spread| onward(&mut field, &seen, &hits, spread)));
        // Some of which begin elsewhere.
        let mut mixed = groups[2].clone();
        mixed.iter_mut().step_by(7).for_each(|ray| ray.near = 0.25 * ray.far);
        groups.push(mixed);
        for (g, rays) in groups.iter().enumerate() {
            let mut found = [[(); 2]; 2].map(|two| two.map(|()| vec![Hit::MISS; rays.len()]));
            let mut cost = CastStats::default();
            for (made, [first, any]) in [&mut lone, &mut beams].into_iter().zip(&mut found) {
                made.first_hits(rays, first, &mut cost, &never);
                made.any_hits(rays, any, &mut cost, &never);
            }
            assert_eq!(cost.rays, 4 * rays.len() as u64);
            let [[by_lone, any_by_lone], [by_beams, any_by_beams]] = &found;
            assert!(rays.len() > 100, "scene {n}, group {g}: only {} rays", rays.len());
            let mut differ = 0;
            for (i, ray) in rays.iter().enumerate() {
                let (a, b) = (by_lone[i], by_beams[i]);
                assert!(b.certified && any_by_beams[i].certified, "scene {n}, group {g}: {ray:?}");
                let is_other = (a.t - b.t).abs() > 2.0 * TOLERANCE || a.is_hit() != b.is_hit();
                let is_close = field.value(ray.at(a.t.min(b.t))).abs() <= 2.0 * TOLERANCE;
                differ += usize::from(is_other && !is_close);
                // Where a ray comes within the tolerance without meeting anything, either answer is right.
                differ += usize::from(any_by_beams[i].is_hit() != any_by_lone[i].is_hit());
            }
            assert!(differ * 100 < rays.len(), "scene {n}, group {g}: {differ} of {} differ", rays.len());
        }
        // What is cancelled is left alone.
        let untouched = Hit { t: 0.5, certified: false };
        let mut hits = vec![untouched; groups[2].len()];
        let cancelled = AtomicBool::new(true);
        beams.first_hits(&groups[2], &mut hits, &mut CastStats::default(), &cancelled);
        beams.any_hits(&groups[2], &mut hits, &mut CastStats::default(), &cancelled);
        assert!(hits.iter().all(|hit| *hit == untouched), "scene {n}");
    }
}

#[test]
fn rays_that_start_a_hair_above_the_surface_come_to_an_end() {
    let mut b = Build::default();
    let [x, ..] = b.p();
    let field = b.field(x);
    let mut group = caster(Kind::Affine, &field, &Aabb::cube(1e6), &[]).expect("a caster");
    for i in 0..400 {
        let ray = Ray {
            origin: DVec3::new(f64::from(i) * 5e-15, 0.1, 0.2),
            direction: DVec3::X,
            near: 0.0,
            far: 4000.0,
            tolerance: Tolerance::fixed(1e-18),
        };
        group.first_hits(&[ray], &mut [Hit::MISS], &mut CastStats::default(), &AtomicBool::new(false));
        all_hits(&field, &[ray], &mut CastStats::default());
    }
}

#[test]
fn a_ray_of_one_point_hits_where_it_is_inside() {
    let mut b = Build::default();
    let ball = b.sphere([0.0; 3], 1.0);
    for kind in ALL {
        let mut made = caster(kind, &b.field(ball), &Aabb::cube(2.0), &[]).expect("a caster");
        for (t, inside) in [(0.5, false), (1.5, true)] {
            let tolerance = Tolerance::fixed(TOLERANCE);
            let ray = Ray { origin: -2.0 * DVec3::X, direction: DVec3::X, near: t, far: t, tolerance };
            let mut hit = [Hit::MISS];
            made.first_hits(&[ray], &mut hit, &mut CastStats::default(), &AtomicBool::new(false));
            assert_eq!(hit[0].is_hit(), inside, "{kind:?} at {t}: {hit:?}");
            made.any_hits(&[ray], &mut hit, &mut CastStats::default(), &AtomicBool::new(false));
            assert_eq!(hit[0].is_hit(), inside, "{kind:?} at {t}, anywhere: {hit:?}");
        }
    }
}

#[test]
fn where_the_field_has_no_value_there_is_nothing() {
    let mut b = Build::default();
    let ball = b.sphere([0.0; 3], 1.0);
    let y = b.p()[1];
    let root = b.op(Op::Sqrt(op::Sqrt), &[y]);
    let bump = b.scaled(0.3, root);
    let bowl = b.add(ball, bump);
    let mut field = b.field(bowl);
    let rays = &rays(11)[..3000];
    let mut made = caster(Kind::Beam, &field, &Aabb::cube(REGION), &[]).expect("a caster");
    let mut hits = vec![Hit::MISS; rays.len()];
    made.first_hits(rays, &mut hits, &mut CastStats::default(), &AtomicBool::new(false));
    const SAMPLES: u32 = 20_000;
    let mut from_below = 0;
    for (ray, hit) in rays.iter().zip(&hits) {
        let step = (ray.far - ray.near) / f64::from(SAMPLES);
        let samples = (0..=SAMPLES).map(|i| ray.near + step * f64::from(i));
        let inside: Vec<f64> = samples.filter(|t| field.value(ray.at(*t)) < 0.0).collect();
        if hit.is_hit() {
            let end = [0.0, 0.5, 1.0, 2.0].map(|k| field.value(ray.at(hit.t + k * TOLERANCE)));
            assert!(end.iter().any(|f| *f < 2e-2), "{ray:?}: {hit:?} where the field is {end:?}");
        }
        // What is shorter than this may be passed.
        if inside.len() > 20 {
            assert!(hit.t <= inside[0], "{ray:?}: {hit:?} behind {}", inside[0]);
            let start = inside[0] - step - 3.0 * TOLERANCE;
            assert!(hit.t >= start || inside[0] < ray.near + step, "{ray:?}: {hit:?} before {start}");
            from_below += usize::from(field.value(ray.at(ray.near)).is_nan());
        }
    }
    assert!(from_below > 300, "only {from_below} rays come from where there is no value");
}

/// A wall that is no thicker than rounding is met on the side that it is seen from.
#[test]
fn walls_of_no_thickness_are_met_from_their_front() {
    let mut b = Build::default();
    let weights = [0.31, 0.83, 0.47];
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let p = b.p()[axis];
        b.scaled(weights[axis], p)
    });
    let (low, high) = (b.add(x, y), b.add(y, z));
    let (front, back) = (b.add(low, z), b.add(x, high));
    let (front, back) = (b.shifted(front, -0.2), b.shifted(back, -0.2));
    let back = b.scaled(-1.0, back);
    let (wall, mut side) = (b.max(front, back), b.field(front));
    let wall = b.field(wall);
    let slope = |ray: &Ray| -DVec3::from_array(weights).dot(ray.direction);
    let rays: Vec<Ray> = rays(29)[..3000]
        .iter()
        .filter(|ray| side.value(ray.at(ray.near)) > 0.01 && side.value(ray.at(ray.far)) < -0.01)
        .copied()
        .collect();
    let mut made = caster(Kind::Beam, &wall, &Aabb::cube(REGION), &[]).expect("a caster");
    let mut hits = vec![Hit::MISS; rays.len()];
    made.first_hits(&rays, &mut hits, &mut CastStats::default(), &AtomicBool::new(false));
    let mut from_behind = 0;
    for (ray, hit) in rays.iter().zip(&hits) {
        let at = side.value(ray.at(hit.t));
        assert!(hit.is_hit() && hit.certified && at > 0.0 && at <= 2.0 * TOLERANCE, "{ray:?}: {hit:?}, {at}");
        let exact = ray.near + side.value(ray.at(ray.near)) / slope(ray);
        from_behind += usize::from(side.value(ray.at(exact)) <= 0.0);
    }
    assert!(rays.len() > 500 && from_behind > 100, "{} rays, {from_behind} of them by rounding", rays.len());
}

/// Where parts of a field jump and the field does not, there is no wall; where it does, there is one.
#[test]
fn there_are_walls_where_the_field_changes_sign_and_nowhere_else() {
    let repeated = "sphere(0.3).at(vec3(modulo(x + 0.5, 1.0) - 0.5, y, modulo(z + 0.5, 1.0) - 0.5))";
    let fields = [
        (repeated, true),
        ("sphere(1.0) - 0.05 * cos(3.0 * atan2(x, z))", true),
        ("y + 0.3 * cos(TAU * fract(x))", true),
        ("y + 0.6 * abs(fract(x) - 0.5)", true),
        ("y - 0.3 * floor(3.0 * x)", false),
        ("max(sphere(1.0), 0.4 - abs(floor(2.0 * z) + 0.5))", false),
    ];
    // Poles of what they are made of.
    let poles = [
        ("max(sphere(1.0), 0.3 * abs(atan(1.0 / x)) - 0.3 - y)", true),
        ("max(sphere(1.0), abs(atan(5.0 * tan(3.0 * x))) - 1.0)", true),
        ("max(sphere(1.0), min(abs(tan(3.0 * x)), 1.0) - 0.9)", true),
        ("0.3 * min(abs(1.0 / (x - z)), 2.0) - y", true),
        ("max(sphere(1.0), 1.0 / x)", false),
    ];
    // No value at all: only beams look for where that begins.
    let nothing = [("max(sphere(1.0), min(sqrt(x), 0.5) - 0.3)", false)];
    let rays = &rays(13)[..3000];
    for (text, continuous) in fields.into_iter().chain(poles).chain(nothing) {
        let compiled = compile(&Request::text(text));
        let scene = compiled.scene.expect(text);
        let mut field = Field::new(&scene.graph, scene.surface.field);
        for kind in boundless() {
            let mut made = caster(kind, &field, &Aabb::cube(REGION), &[]).expect("a caster");
            let (mut hits, mut stats) = (vec![Hit::MISS; rays.len()], CastStats::default());
            made.first_hits(rays, &mut hits, &mut stats, &AtomicBool::new(false));
            const SAMPLES: u32 = 2000;
            // Others may take a pole for a wall, and are not certain of it.
            let passes_poles = [Kind::Beam, Kind::Octree, Kind::Auto].contains(&kind);
            if !passes_poles && nothing.iter().any(|(none, _)| *none == text) {
                continue;
            }
            let is_pole = poles.iter().any(|(pole, _)| *pole == text);
            for (ray, hit) in rays.iter().zip(&hits) {
                if is_pole && !passes_poles && !hit.certified {
                    continue;
                }
                let about = format!("{text}, {kind:?}, {ray:?}: {hit:?}");
                let mut value = |t: f64| field.value(ray.at(t.clamp(ray.near, ray.far)));
                if hit.is_hit() {
                    let behind = (0..=20).map(|i| value(hit.t + 0.1 * f64::from(i) * TOLERANCE));
                    let least = behind.fold(f64::INFINITY, f64::min);
                    assert!(least < 10.0 * TOLERANCE, "{about} where the field is {least}");
                }
                let step = (ray.far - ray.near) / f64::from(SAMPLES);
                let samples = (0..=SAMPLES).map(|i| ray.near + step * f64::from(i));
                let free = samples.take_while(|t| *t < hit.t - TOLERANCE);
                // What is no deeper than this may be shorter than the tolerance.
                let deepest = free.map(value).fold(f64::INFINITY, f64::min);
                assert!(deepest > -10.0 * TOLERANCE, "{about} behind {deepest}");
            }
            let hit = hits.iter().filter(|hit| hit.is_hit()).count();
            assert!(hit > 100 && hit < rays.len(), "{text}, {kind:?}: {hit} hits");
            assert!(
                !continuous || stats.uncertified > 0,
                "{text}, {kind:?}: nothing proves what is at a jump"
            );
        }
    }
}

#[test]
fn no_hit_is_certified_where_no_value_is() {
    let mut b = Build::default();
    let [x, ..] = b.p();
    // sqrt(sin^2 + cos^2 - 2) - 5: over an interval nothing says that the root is of -1 everywhere.
    let squares = [Op::Sin(op::Sin), Op::Cos(op::Cos)].map(|f| {
        let wave = b.op(f, &[x]);
        b.op(Op::Square(op::Square), &[wave])
    });
    let sum = b.add(squares[0], squares[1]);
    let less = b.shifted(sum, -2.0);
    let root = b.op(Op::Sqrt(op::Sqrt), &[less]);
    let nothing = b.shifted(root, -5.0);
    let rays = &rays(12)[..300];
    for kind in boundless() {
        let mut made = caster(kind, &b.field(nothing), &Aabb::cube(REGION), &[]).expect("a caster");
        let mut hits = vec![Hit::MISS; rays.len()];
        made.first_hits(rays, &mut hits, &mut CastStats::default(), &AtomicBool::new(false));
        for (ray, hit) in rays.iter().zip(&hits) {
            assert!(!(hit.is_hit() && hit.certified), "{kind:?}, {ray:?}: {hit:?}");
        }
    }
}
