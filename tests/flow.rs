//! Flows: what they must keep, against closed forms, differences, dense samples and meshes.

use glam::DVec3;
use orogen::cast::{CastStats, Caster, Hit, Kind, Ray, Tolerance, caster};
use orogen::field::{Field, Watch};
use orogen::mesh::Fineness;
use orogen::num::{Interval, Jet, Many, Parabola, Parabolas, Reduced, Slope, Taylors};
use orogen::scene::Aabb;
use orogen::script::{Request, compile};
use orogen::session::polygonise;
use orogen::shape::Census;
use orogen::tape::{Evaluator, Instr};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Velocities of all kinds, the last ones strong; and whether they are C1 at least.
const VELOCITIES: &[(&str, bool)] = &[
    ("vec3(y, 0, 0)", true),
    ("0.1 * vector_noise(gradient(7).scaled(4.0))", true),
    ("0.01 * slope(gradient(7).scaled(4.0))", true),
    ("0.05 * curl(vector_noise(gradient(3).scaled(3.0)))", true),
    ("flow::along_sphere(0.3 * vector_noise(gradient(2).scaled(2.0)))", true),
    ("flow::above(0.2 * vector_noise(sparse(2).scaled(3.0)), 0.7, 1.0)", true),
    ("flow::push([0, 0.9, 0], [0.5, 0.3, 0], 0.7) + flow::twist([0.7, 0, 0], [1, 0, 0], 200, 0.9)", true),
    ("slope(0.1 * gradient(7).scaled(3.0) * smoothstep(0.5, 1.5, length(p)))", false),
    ("0.1 * vector_noise(cellular(7).scaled(4.0))", false),
    ("0.3 * vector_noise(gradient(7).scaled(4.0))", true),
    ("0.01 * slope(fractal::fbm(gradient(7).scaled(2.0), #{ octaves: 3 }))", true),
    ("0.02 * slope(sparse(2).scaled(3.0))", true),
    ("0.01 * slope(gradient(7).scaled(4.0)) - slope(0.02 * gradient(3).scaled(3.0))", true),
    ("flow::push([0.5, 0.6, 0.6], [0.02, 0.01, 0], 0.03)", true),
];

fn with_modules(script: &str) -> String {
    format!("import \"std/flow\" as flow;\nimport \"std/fractal\" as fractal;\n{script}")
}

fn field(script: &str) -> Field {
    let compiled = compile(&Request::text(with_modules(script)));
    let scene = compiled.scene.unwrap_or_else(|| panic!("{script}: {:?}", compiled.diagnostics));
    Field::new(&scene.graph, scene.surface.field)
}

fn flowed(velocity: &str) -> Field {
    field(&format!("sphere(1.0).flow({velocity})"))
}

fn points(seed: u64, count: usize) -> Vec<DVec3> {
    let mut rng = StdRng::seed_from_u64(seed);
    (0..count).map(|_| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.3..1.3)))).collect()
}

#[test]
fn flows_that_have_closed_forms() {
    let mut still = field("sphere(1.0)");
    // Nothing; a shear; a turn, which a sphere does not notice; growth, by the exponential of its rate.
    let mut nothing = flowed("vec3(0, 0, 0) * x");
    let mut shear = flowed("vec3(2.0 * y, 0, 0)");
    let mut turn = flowed("cross(vec3(1, 2, 3), p)");
    let mut close_turn = field("sphere(1.0).flow(cross(vec3(1, 2, 3), p), #{ tolerance: 1e-5 })");
    let mut growth = flowed("0.7 * p");
    // The noise of a point is carried along too, and so is a vector.
    let mut along = field("gradient(7).flow(vec3(0.3, -0.2, 0.1))");
    let mut noise = field("gradient(7)");
    let mut vector = field("p.flow(vec3(0.3, -0.2, 0.1)).y");
    for p in points(1, 300) {
        let close = |a: f64, b: f64, within: f64| assert!((a - b).abs() <= within, "{p}: {a} is not {b}");
        close(nothing.value(p), still.value(p), 0.0);
        close(shear.value(p), still.value(p - 2.0 * p.y * DVec3::X), 1e-14);
        // A thousandth of how far it carries points, which is some 2.3 here on average; or less.
        close(turn.value(p), still.value(p), 2.3e-3);
        close(close_turn.value(p), still.value(p), 2.3e-5);
        close(growth.value(p), still.value(p * 0.496_585_303_791_409_5), 1e-4);
        close(along.value(p), noise.value(p - DVec3::new(0.3, -0.2, 0.1)), 1e-14);
        close(vector.value(p), p.y + 0.2, 1e-14);
        // d = exp(M) x has the derivative exp(M).
        let (_, g) = shear.gradient(p);
        let n = (p - 2.0 * p.y * DVec3::X).normalize();
        assert!((g - DVec3::new(n.x, n.y - 2.0 * n.x, n.z)).length() < 1e-13, "{p}: {g}");
    }
}

#[test]
fn what_flows_comes_back() {
    for (velocity, is_smooth) in VELOCITIES {
        let mut there = field(&format!("p.flow({velocity}).x"));
        let mut back = field(&format!("p.flow({velocity}).unflow({velocity}).x"));
        let far = points(2, 200).into_iter().map(|p| (there.value(p) - p.x).abs()).fold(0.0, f64::max);
        // Creases cost accuracy that the probes may not have met.
        let share = if *is_smooth { 2e-3 } else { 2e-2 };
        for p in points(3, 200) {
            let off = (back.value(p) - p.x).abs();
            assert!(off <= share * far, "{velocity} at {p}: off by {off}, and carries as far as {far}");
        }
    }
}

#[test]
fn derivatives_are_those_of_the_map() {
    const H: f64 = 1e-5;
    for (velocity, is_smooth) in VELOCITIES {
        if !is_smooth {
            continue;
        }
        let mut f = flowed(velocity);
        for p in points(4, 60) {
            let (value, g) = f.gradient(p);
            assert_eq!(value, f.value(p), "{velocity}");
            let jet = f.jet(p);
            assert_eq!((jet.value, DVec3::from_array(jet.grad)), (value, g), "{velocity}");
            for axis in 0..3 {
                let e = DVec3::from_array(std::array::from_fn(|k| if k == axis { H } else { 0.0 }));
                let slope = (f.value(p + e) - f.value(p - e)) / (2.0 * H);
                let size = 1.0 + g.length();
                assert!((slope - g[axis]).abs() < 1e-5 * size, "{velocity} at {p}: {slope} and {g}");
                let bend = (f.gradient(p + e).1 - f.gradient(p - e).1) / (2.0 * H);
                let bent = jet.hess[axis];
                // Slopes of noises have second derivatives from differences themselves.
                let within = 2e-2 * (1.0 + bend.length());
                assert!((bend[axis] - bent).abs() < within, "{velocity} at {p}: {} and {bent}", bend[axis]);
            }
        }
    }
}

#[test]
fn lanes_equal_points_bit_for_bit() {
    for (velocity, _) in VELOCITIES {
        let mut f = flowed(velocity);
        let mut lanes = Evaluator::<Many<f64, 16>>::new(f.tape().clone());
        for batch in points(5, 64).chunks(16) {
            let at = std::array::from_fn(|axis| Many(std::array::from_fn(|i| batch[i][axis])));
            let Many(values) = *lanes.eval(&at);
            for (p, value) in batch.iter().zip(values) {
                assert_eq!(f.value(*p).to_bits(), value.to_bits(), "{velocity} at {p}");
            }
        }
        let mut boxes = Evaluator::<Many<Slope, 8>>::new(f.tape().clone());
        for batch in points(6, 16).chunks(8) {
            let side = |i: usize, axis: usize| Interval::around(batch[i][axis], [0.01, 0.1, 0.5][i % 3]);
            let at = std::array::from_fn(|axis| {
                Many(std::array::from_fn(|i| Slope::coordinate(side(i, axis), axis)))
            });
            for (i, slope) in boxes.eval(&at).0.into_iter().enumerate() {
                let one = f.slope(&[0, 1, 2].map(|axis| side(i, axis)));
                assert_eq!(slope, one, "{velocity} around {}", batch[i]);
            }
        }
    }
}

#[test]
fn enclosures_contain() {
    let mut rng = StdRng::seed_from_u64(6);
    for (velocity, _) in VELOCITIES {
        let mut f = flowed(velocity);
        let mut forms = Evaluator::<Reduced<1>>::new(f.tape().clone());
        let mut balls = Evaluator::<Taylors<4>>::new(f.tape().clone());
        let mut pieces = Evaluator::<Parabolas<4, 0>>::new(f.tape().clone());
        for (i, c) in points(7, 24).into_iter().enumerate() {
            let half = [1e-12, 1e-4, 1e-2, 0.1, 0.4, 1.5][i % 6];
            let region = c.to_array().map(|c| Interval::around(c, half));
            let (range, slope) = (f.range(&region), f.slope(&region));
            let mut ball = [orogen::num::Number::constant(0.0); 3];
            Taylors::<4>::set_ball(&mut ball, 2, c.to_array(), half);
            let taylor = balls.eval(&ball).lane(2);
            // A piece of a line through the middle.
            let e = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-half..half)));
            let line = std::array::from_fn(|k| Reduced::<1>::new(c[k], [e[k]]));
            let form = *forms.eval(&line);
            let piece = |axis: usize| Parabola::coordinate(c[axis], e[axis], [], 0.0, 0.0);
            let parabola = pieces.eval(&[0, 1, 2].map(|axis| Parabolas::all(piece(axis)))).lane(1);
            let second = f.jet_range(&region);
            for _ in 0..12 {
                let o = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-half..half)));
                let Jet { value, grad, hess } = f.jet(c + o);
                assert!(range.contains(value), "{velocity}: {value} at {} is outside of {range:?}", c + o);
                assert!(slope.value.contains(value), "{velocity}: {value} outside of {slope:?}");
                let norm = DVec3::from_array(grad).length();
                assert!(norm <= slope.norm, "{velocity}: slope {norm} above {}", slope.norm);
                assert!(
                    (0..3).all(|k| slope.grad[k].contains(grad[k])),
                    "{velocity}: {grad:?} outside of {slope:?}"
                );
                if o.length() < half {
                    assert!(taylor.range.contains(value), "{velocity}: {value} outside of {taylor:?}");
                    let u = o / half;
                    let linear = taylor.value + DVec3::from_array(taylor.grad).dot(u);
                    assert!((value - linear).abs() <= taylor.bow[0], "{velocity}: {value} and {taylor:?}");
                    let turned = (half * DVec3::from_array(grad) - DVec3::from_array(taylor.grad)).length();
                    assert!(turned <= taylor.turn[0], "{velocity}: {grad:?} at {} and {taylor:?}", c + o);
                }
                // Slopes of noises have second derivatives from differences themselves.
                let is_known = |k: usize| {
                    let room = 2e-2 * (1.0 + hess[k].abs());
                    (second.hess[k].lo - room..=second.hess[k].hi + room).contains(&hess[k])
                };
                assert!((0..6).all(is_known), "{velocity}: {hess:?} outside of {:?}", second.hess);
                let t: f64 = rng.random_range(-1.0..1.0);
                let on_line = parabola.mid[0] + t * (parabola.mid[1] + t * parabola.mid[2]);
                let rest = parabola.rest[0] + t.abs() * (parabola.rest[1] + t.abs() * parabola.rest[2]);
                let value = f.value(c + t * e);
                assert!((value - on_line).abs() <= rest, "{velocity}: {value} and {parabola:?}");
                assert!(parabola.range.contains(value), "{velocity}: {value} and {parabola:?}");
                let off = (value - form.mid - t * form.slope[0]).abs();
                assert!(off <= form.rest && form.range.contains(value), "{velocity}: {value} and {form:?}");
            }
        }
        // A smaller ball is no wider.
        let at = DVec3::new(0.9, 0.3, -0.2).to_array();
        let width = |f: &mut Field, half: f64| f.range(&at.map(|c| Interval::around(c, half))).width();
        let widths = [1e-4, 1e-3, 1e-2].map(|half| width(&mut f, half));
        assert!(widths.windows(2).all(|w| w[0] <= w[1]), "{velocity}: {widths:?}");
        // A strong flow lets a larger one grow until it holds points where its velocity has no slope.
        let near: Slope = f.slope(&at.map(|c| Interval::around(c, 1e-4)));
        assert!(near.norm.is_finite(), "{velocity} has no bound");
    }
}

/// Rays in bundles of neighbours, as pictures have them.
fn bundles(count: usize, region: &Aabb) -> Vec<Vec<Ray>> {
    let mut rng = StdRng::seed_from_u64(8);
    let mut out = Vec::new();
    while out.len() < count {
        let mut unit = || DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0))).normalize();
        let (eye, target) = (4.0 * unit(), 0.9 * unit());
        let (side, pixel) = ((target - eye).cross(unit()).normalize(), 0.004);
        let up = side.cross(target - eye).normalize();
        let bundle: Vec<Ray> = (0..256)
            .filter_map(|i| {
                let aim = target + pixel * (f64::from(i % 16) * side + f64::from(i / 16) * up);
                let direction = (aim - eye).normalize();
                let (near, far) = region.clip(eye, direction)?;
                Some(Ray { origin: eye, direction, near, far, tolerance: Tolerance::fixed(1e-4) })
            })
            .collect();
        out.push(bundle);
    }
    out
}

/// Velocities of strong flows, along a slope and with creases.
const SLOPE: &str = "-0.04 * slope(gradient(7).scaled(4.0))";
const CREASED: &str = "-0.3 * vector_noise(cellular(7).scaled(4.0))";

/// No first hit of so many bundles of rays is missed, and nearly all are proven. Gives how many rays there were, how many
/// met the solid, and how many were not proven.
fn miss_nothing(kind: Kind, velocity: &str, many: usize) -> [usize; 3] {
    let region = Aabb::cube(1.4);
    let never = AtomicBool::new(false);
    // Hits of a bundle, and those that are not proven.
    let looked_at = |rays: Vec<Ray>| {
        let f = flowed(velocity);
        let cast = |kind: Kind| {
            let (mut out, mut stats) = (vec![Hit::MISS; rays.len()], CastStats::default());
            let mut caster = caster(kind, &f, &region, &[]).expect("a caster");
            caster.first_hits(&rays, &mut out, &mut stats, &never);
            out
        };
        // What is not proven is said to be so.
        assert!(cast(Kind::Bent).iter().all(|hit| !hit.certified));
        let certified = cast(kind);
        let mut lanes = Evaluator::<Many<f64, 16>>::new(f.tape().clone());
        for (ray, hit) in rays.iter().zip(&certified) {
            // Nothing lies before the hit, as far as 512 samples can tell.
            let end = hit.t.min(ray.far) - 2e-4;
            for batch in 0..32 {
                let at = |i: usize| ray.at(ray.near + (end - ray.near) * (16 * batch + i) as f64 / 512.0);
                let at: [_; 3] = std::array::from_fn(|axis| Many(std::array::from_fn(|i| at(i)[axis])));
                let least = lanes.eval(&at).0.into_iter().fold(f64::INFINITY, f64::min);
                assert!(least > 0.0, "{ray:?}: a root before {hit:?}");
            }
        }
        let count = |is: fn(&&Hit) -> bool| certified.iter().filter(is).count();
        [rays.len(), count(|hit| hit.is_hit()), count(|hit| !hit.certified)]
    };
    let counts: Vec<[usize; 3]> = bundles(many, &region).into_par_iter().map(looked_at).collect();
    let [all, hits, uncertified] = [0, 1, 2].map(|k| counts.iter().map(|count| count[k]).sum::<usize>());
    assert!(hits > all / 4, "{hits} of {all} rays meet the solid");
    assert!(1000 * uncertified < all, "{uncertified} of {all} rays are not certified");
    [all, hits, uncertified]
}

#[test]
fn no_hit_is_missed() {
    miss_nothing(Kind::Beam, SLOPE, 12);
    miss_nothing(Kind::Octree, CREASED, 12);
}

/// Bent rays meet what certified ones do, all but a few, where a flow is weak.
fn bent_rays_agree(f: &Field, region: &Aabb, bundles: &[Vec<Ray>]) {
    let never = AtomicBool::new(false);
    let (mut all, mut wrong, mut shared) = (0, 0, 0);
    for rays in bundles {
        let cast = |kind: Kind, is_any: bool, stats: &mut CastStats| {
            let mut out = vec![Hit::MISS; rays.len()];
            let mut caster = caster(kind, f, region, &[]).expect("a caster");
            let ask = if is_any { Caster::any_hits } else { Caster::first_hits };
            ask(&mut *caster, rays, &mut out, stats, &never);
            out
        };
        for is_any in [false, true] {
            let [mut of_beams, mut of_bent] = [CastStats::default(); 2];
            let right = cast(Kind::Beam, is_any, &mut of_beams);
            let found = cast(Kind::Bent, is_any, &mut of_bent);
            let differ = |(a, b): &(&Hit, &Hit)| {
                a.is_hit() != b.is_hit() || !is_any && a.is_hit() && (a.t - b.t).abs() > 2e-4
            };
            wrong += right.iter().zip(&found).filter(differ).count();
            assert_eq!(of_bent.rays, rays.len() as u64);
            assert_eq!(of_bent.hits, found.iter().filter(|hit| hit.is_hit()).count() as u64);
            (all, shared) = (all + rays.len(), shared + of_bent.shared);
        }
    }
    assert!(500 * wrong <= all, "{wrong} of {all} rays differ");
    assert!(shared > 0, "nothing was shared");
}

#[test]
fn bent_rays_meet_what_certified_ones_do() {
    let region = Aabb::cube(1.4);
    for velocity in ["-0.01 * slope(gradient(7).scaled(4.0))", "-0.1 * vector_noise(cellular(7).scaled(4.0))"]
    {
        bent_rays_agree(&flowed(velocity), &region, &bundles(8, &region));
    }
    // A solid that is cut off, so that rays begin in it.
    let cut = field("sphere(2.0).flow(0.05 * vector_noise(gradient(7).scaled(2.0)))");
    bent_rays_agree(&cut, &region, &bundles(4, &region));
}

/// Small things on a floor that is seen slantwise, which is straight all along.
#[test]
fn bent_rays_do_not_miss_what_is_small() {
    let things = "let f = y; for i in 0..40 { \
        f = min(f, sphere(0.02 + 0.0005 * i).translated([0.13 * (i % 8) - 0.45, 0.03, 0.2 * (i / 8) - 0.5])); } \
        f.flow(0.002 * vector_noise(gradient(7).scaled(2.0)))";
    let (f, region) = (field(things), Aabb::cube(1.4));
    let eye = DVec3::new(0.1, 0.6, 3.0);
    let ray = |x: u32, y: u32| {
        let aim = DVec3::new(0.01 * f64::from(x) - 0.8, 0.0, 0.02 * f64::from(y) - 1.2);
        let direction = (aim - eye).normalize();
        let (near, far) = region.clip(eye, direction)?;
        Some(Ray { origin: eye, direction, near, far, tolerance: Tolerance::fixed(1e-5) })
    };
    let tile =
        |n: u32| (0..256).filter_map(|i| ray(16 * (n % 10) + i % 16, 16 * (n / 10) + i / 16)).collect();
    bent_rays_agree(&f, &region, &(20..50).map(tile).collect::<Vec<_>>());
}

/// `cargo test --release --test flow -- --ignored --nocapture`
#[test]
#[ignore = "takes twenty minutes of a core"]
fn no_hit_of_a_hundred_thousand_rays_is_missed() {
    let [all, hits, uncertified] = miss_nothing(Kind::Beam, SLOPE, 400);
    println!("{all} rays, {hits} hits, {uncertified} not certified");
    assert!(all >= 100_000, "{all}");
}

#[test]
fn where_nothing_flows_the_field_is_left_alone() {
    // Velocities, each with the centres and the radius of balls outside of which it is zero.
    let noise = "vector_noise(cellular(7).scaled(9.0))";
    let local = format!("0.2 * {noise} * flow::within([0.5, 0.6, 0.6], 0.3)");
    let masked = format!("(1.0 - smoothstep(0.2, 0.3, length(p))) * (0.2 * {noise}) / 3.0");
    let two = "flow::push([0, 0.9, 0], [0.5, 0.3, 0], 0.3) + flow::twist([0.7, 0, 0], [1, 0, 0], 200, 0.3)";
    for (velocity, centres) in [
        (local.as_str(), vec![DVec3::new(0.5, 0.6, 0.6)]),
        (masked.as_str(), vec![DVec3::ZERO]),
        (two, vec![DVec3::new(0.0, 0.9, 0.0), DVec3::new(0.7, 0.0, 0.0)]),
    ] {
        let mut whole = flowed(velocity);
        for centre in points(6, 200).into_iter().chain(centres.clone()) {
            let region = centre.to_array().map(|c| Interval::around(c, 0.05));
            let pruned = whole.tape().prune(&region);
            let flows = pruned.code().iter().any(|instr| matches!(instr, Instr::Flow(..)));
            let away = centres.iter().map(|c| c.distance(centre)).fold(f64::INFINITY, f64::min);
            assert!(if flows { away < 0.4 } else { away > 0.2 }, "{velocity} at {centre}: {flows}");
            let mut left = Field::of_tape(&Arc::new(pruned));
            for off in points(7, 20) {
                let p = centre + 0.05 / 1.3 * off;
                assert_eq!(left.gradient(p), whole.gradient(p), "{velocity} at {p}");
            }
        }
    }
    // Where it is not known to have a value, nothing is left out: at the point, and along the velocity.
    let region = [Interval::new(0.0, 0.2), Interval::point(0.0), Interval::point(0.0)];
    for script in [
        "sphere(1.0).flow(vec3(flow::within([0.5, 0.6, 0.6], 0.3) * sqrt(x - 0.1), 0, 0))",
        "sphere(1.0).flow(flow::push([0, 0, 0], [0, 0.3, 0.1], 0.5)).at(vec3(sqrt(x - 0.1) + 3.0, y, z))",
    ] {
        let pruned = field(script).tape().prune(&region);
        assert!(pruned.code().iter().any(|instr| matches!(instr, Instr::Flow(..))), "{script}");
    }
}

fn meshed(script: &str, resolution: u32) -> orogen::mesh::Meshed {
    let scene = compile(&Request::text(with_modules(script))).scene.expect("a scene");
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    polygonise(&scene, &Fineness { resolution: Some(resolution), tolerance: None }, &watch)
        .expect("a mesh")
        .meshed
}

/// On meshes, so by flows that leave nothing thinner than their cells; of stronger ones `maps_do_not_fold` says as much.
#[test]
fn topology_is_kept() {
    for seed in 0..5 {
        for (velocity, solid, parts, euler) in [
            (format!("flow::by_noise(gradient({seed}).scaled(1.5), 0.3)"), "torus(1.0, 0.4)", 1, 0),
            (format!("flow::by_slope(gradient({seed}).scaled(3.0), 0.03)"), "sphere(1.0)", 1, 2),
            (format!("flow::by_curl(gradient({seed}).scaled(1.5), 0.05)"), "shell(sphere(1.0), 0.3)", 2, 4),
            (
                format!("flow::twist([0.5, 0.2, 0.1 * {seed}], [1, 0.3, 0.2], 90, 1.2)"),
                "torus(0.8, 0.3)",
                1,
                0,
            ),
        ] {
            let script = format!("{solid}.flow({velocity})");
            let census = Census::of(&meshed(&script, 48).mesh);
            assert!(census.is_closed_manifold(), "{script}");
            assert_eq!((census.parts, census.euler_characteristic()), (parts, euler), "{script}");
        }
    }
}

#[test]
fn maps_do_not_fold() {
    let strong = [
        ("flow::by_curl(gradient(0).scaled(1.5), 0.1)", true),
        ("flow::twist([0.5, 0.2, 0.1], [1, 0.3, 0.2], 200, 1.2)", true),
        ("0.04 * slope(gradient(7).scaled(4.0))", true),
    ];
    for (velocity, is_smooth) in VELOCITIES.iter().chain(&strong) {
        let mut parts = ["x", "y", "z"].map(|axis| field(&format!("p.flow({velocity}).{axis}")));
        // The brush is small, so some points are near it.
        let near = points(12, 100).into_iter().map(|p| DVec3::new(0.5, 0.6, 0.6) + 0.03 * p);
        for p in points(11, 300).into_iter().chain(near) {
            let [x, y, z] = parts.each_mut().map(|part| part.gradient(p).1);
            let growth = x.dot(y.cross(z));
            assert!(growth > 0.0, "{velocity} at {p}: volumes grow by {growth}");
            if velocity.starts_with("0.05 * curl") && *is_smooth {
                assert!((growth - 1.0).abs() < 1e-3, "{velocity} at {p}: volumes grow by {growth}");
            }
        }
    }
}

#[test]
fn what_moves_little_is_found() {
    // A brush that no point of a coarse lattice meets, and a thin shell, are carried as exactly as what moves everywhere.
    for velocity in [
        "flow::push([0.51, 0.62, 0.63], [0.02, 0.01, 0], 0.01)",
        "flow::above(0.1 * vector_noise(gradient(2).scaled(40.0)), 1.0, 1.0001) * (1.0 - smoothstep(1.0001, 1.0002, length(p)))",
    ] {
        let mut own = field(&format!("p.flow({velocity}).x"));
        let mut exact = field(&format!("p.flow({velocity}, #{{ steps: 512 }}).x"));
        let near = points(13, 200).into_iter().map(|p| DVec3::new(0.51, 0.62, 0.63) + 0.005 * p);
        let shell = points(14, 200).into_iter().map(|p| 1.00008 * p.normalize());
        let (mut off, mut far) = (0.0_f64, 0.0_f64);
        for p in near.chain(shell) {
            off = off.max((own.value(p) - exact.value(p)).abs());
            far = far.max((exact.value(p) - p.x).abs());
        }
        assert!(far > 1e-6 && off < 1e-2 * far, "{velocity}: off by {off} where it carries as far as {far}");
    }
}

#[test]
fn what_moves_in_one_place_alone_or_mostly_is_followed_as_closely() {
    for (velocity, centre, radius) in [
        // What hardly moves around it does not tell how steep it is.
        (
            "24 * exp(-20 * length_squared(p - vec3(0.5))) * cross(vec3(0, 1, 0), p - vec3(0.5))",
            [0.5, 0.5, 0.5],
            0.4,
        ),
        (
            "flow::twist([0.5, 0.5, 0.5], [1, 1, 1], 720.0, 0.5) + 0.001 * vector_noise(gradient(7).scaled(2.0))",
            [0.5, 0.5, 0.5],
            0.5,
        ),
        ("flow::twist([3.0, 0.21, 0], [0, 0, 1], 720.0, 0.5)", [3.0, 0.21, 0.0], 0.5),
        ("flow::twist([20, 0, 0], [0, 0, 1], 720.0, 3.0)", [20.0, 0.0, 0.0], 3.0),
        // This one moves everything, by 1e-150 near the origin.
        ("vec3(-y, x - 20, 0) * (30 * exp(-square(x - 20) - square(y) - square(z)))", [20.0, 0.0, 0.0], 1.5),
    ] {
        let mut own = field(&format!("p.flow({velocity}).x"));
        let mut exact = field(&format!("p.flow({velocity}, #{{ steps: 512 }}).x"));
        let (mut off, mut far) = (0.0, 0.0);
        for p in points(15, 200).into_iter().map(|p| DVec3::from(centre) + radius / 1.3 * p) {
            let (chosen, fine) = (own.value(p), exact.value(p));
            off += (chosen - fine) * (chosen - fine);
            far += (fine - p.x) * (fine - p.x);
        }
        assert!(off < 4e-6 * far, "{velocity}: off by {} of {}", off.sqrt(), far.sqrt());
    }
}

/// Directions have no slope in the middle; rays that meet a solid elsewhere are certified all the same. So are those through flows
/// one after the other, however far these turn.
#[test]
fn flows_that_are_steep_somewhere_or_turn_far_are_certified() {
    for solid in [
        "sphere(1.0).flow(flow::along_sphere(0.1 * vector_noise(gradient(7).scaled(2.0))))",
        "sphere(1.0).flow(flow::push([0, 0.9, 0], [0.5, 0.3, 0], 0.7)).flow(flow::twist([0, 0, 0], [0, 1, 0], 90, 1.5))",
    ] {
        let (f, region) = (field(solid), Aabb::cube(1.6));
        let mut beams = caster(Kind::Beam, &f, &region, &[]).expect("a caster");
        let (mut hits, mut stats) = (0, CastStats::default());
        for rays in bundles(4, &region) {
            let mut out = vec![Hit::MISS; rays.len()];
            beams.first_hits(&rays, &mut out, &mut stats, &AtomicBool::new(false));
            hits += out.iter().filter(|hit| hit.is_hit()).count();
        }
        let CastStats { rays, uncertified, .. } = stats;
        assert!(hits > 50 && 1000 * uncertified <= rays, "{solid}: {uncertified} of {rays}, {hits} hits");
    }
}

#[test]
fn a_ball_says_the_same_whatever_its_neighbours() {
    let f = flowed(
        "flow::push([0.5, 0.6, 0.6], [0.2, 0.1, 0], 0.3) + flow::push([-0.5, 0, 0], [0, 0.3, 0], 0.4)",
    );
    let mut balls = Evaluator::<Taylors<8>>::new(f.tape().clone());
    let mut ask = |batch: &[DVec3]| {
        let mut numbers = [orogen::num::Number::constant(0.0); 3];
        for lane in 0..8 {
            Taylors::<8>::set_ball(&mut numbers, lane, batch[lane % batch.len()].to_array(), 0.01);
        }
        let out = balls.eval(&numbers);
        std::array::from_fn::<_, 8, _>(|lane| out.lane(lane))
    };
    for batch in points(15, 80).chunks(8) {
        let together = ask(batch);
        for (p, own) in batch.iter().zip(together) {
            assert_eq!(ask(&[*p])[0], own, "{p}");
        }
    }
}

#[test]
fn curls_keep_volumes() {
    let volume = |script: &str| {
        let mesh = meshed(script, 80).mesh;
        let six = |t| {
            let [a, b, c] = mesh.corners(t);
            a.dot(b.cross(c))
        };
        (0..mesh.triangles.len()).map(six).sum::<f64>() / 6.0
    };
    let before = volume("sphere(1.0)");
    let stirred = volume("sphere(1.0).flow(flow::by_curl(gradient(3).scaled(1.5), 0.05))");
    assert!((stirred / before - 1.0).abs() < 1e-3, "{before} becomes {stirred}");
    // What does not stir does not keep them.
    let kneaded = volume("sphere(1.0).flow(flow::by_noise(gradient(3).scaled(1.5), 0.3))");
    assert!((kneaded / before - 1.0).abs() > 1e-3, "{before} becomes {kneaded}");
}

#[test]
fn expressions_have_gradients() {
    let scripts =
        ["gradient(7).scaled(4.0)", "sparse(2) * length(p)", "exp(x * y) + smoothstep(-1.0, 1.0, z)"];
    for script in scripts {
        let mut f = field(script);
        let mut parts = ["x", "y", "z"].map(|axis| field(&format!("slope({script}).{axis}")));
        for p in points(9, 50) {
            let (_, g) = f.gradient(p);
            for axis in 0..3 {
                let own = parts[axis].value(p);
                assert!((own - g[axis]).abs() < 1e-11 * (1.0 + g.length()), "{script} at {p}: {own} and {g}");
            }
        }
    }
    // A gradient has no curl, and a curl no divergence.
    let mut curl = field("length(curl(slope(exp(x * y) + sin(z * x) * y)))");
    let mut divergence = field("divergence(curl(vec3(x * y * z, exp(x + z), x * y ** 3)))");
    for p in points(10, 50) {
        assert!(curl.value(p) < 1e-12 && divergence.value(p).abs() < 1e-12, "{p}");
    }
}
