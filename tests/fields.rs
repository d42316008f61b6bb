//! What fields say about whole regions, against closed forms and dense samples.

mod common;

use common::Build;
use glam::DVec3;
use orogen::expr::NodeId;
use orogen::field::{Extent, FAR, Field, around, extent, lipschitz_outside};
use orogen::num::Interval;
use orogen::op::{self, Op};
use orogen::scene::{Aabb, Spacing};
use orogen::script::{Request, compile};
use orogen::tape::{Cells, Evaluator, Instr, Tape};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::sync::Arc;

#[test]
fn the_extent_of_a_ball_is_its_box() {
    let mut b = Build::default();
    let f = b.sphere([1.0, 2.0, 3.0], 0.5);
    let Extent::Within(found) = extent(&b.field(f), &Aabb::cube(64.0)) else { panic!("a bounded ball") };
    assert!(
        found.min.cmple(DVec3::new(0.5, 1.5, 2.5)).all() && found.max.cmpge(DVec3::new(1.5, 2.5, 3.5)).all()
    );
    assert!(found.diagonal() < 1.2 * 3f64.sqrt(), "{found:?}");
}

#[test]
fn unbounded_and_absent_solids_are_told_apart() {
    let mut b = Build::default();
    let hills = common::hills(&mut b);
    assert!(matches!(extent(&b.field(hills), &Aabb::cube(8.0)), Extent::Open(_)));
    let ball = b.sphere([0.0; 3], 1.0);
    let nothing = b.shifted(ball, 2.0);
    assert_eq!(extent(&b.field(nothing), &Aabb::cube(8.0)), Extent::Empty);
}

#[test]
fn the_lipschitz_bound_outside_a_ball_is_one() {
    let mut b = Build::default();
    let f = b.sphere([0.0; 3], 1.0);
    let bound = lipschitz_outside(&b.field(f), &Aabb::cube(1.5));
    assert!((1.0..1.1).contains(&bound), "{bound}");
}

#[test]
fn the_lipschitz_bound_of_three_octaves_is_as_derived() {
    let mut b = Build::default();
    let f = common::three_octaves(&mut b);
    let mut field = b.field(f);
    let bound = lipschitz_outside(&field, &Aabb::cube(1.55));
    // 1 + 3.2 L with L = 3.75, and a little for rounding up and for the corners of cells.
    assert!((8.0..1.05 * (1.0 + 3.2 * 3.76)).contains(&bound), "{bound}");
    let mut rng = StdRng::seed_from_u64(1);
    for _ in 0..20_000 {
        let p = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.55..1.55)));
        let (value, gradient) = field.gradient(p);
        assert!(value < 0.0 || gradient.length() <= bound);
    }
}

#[test]
fn a_cusp_has_no_lipschitz_bound() {
    let mut b = Build::default();
    let f = common::square_root_ridges(&mut b);
    assert_eq!(lipschitz_outside(&b.field(f), &Aabb::cube(1.5)), f64::INFINITY);
}

#[test]
fn enclosures_converge_with_the_square_of_the_box() {
    let mut b = Build::default();
    let f = common::three_octaves(&mut b);
    let mut field = b.field(f);
    let excess = |field: &mut Field, r: f64| {
        let x = [1.0, 0.3, -0.2].map(|c| Interval::around(c, r));
        let range = field.range(&x);
        let mut rng = StdRng::seed_from_u64(9);
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..4000 {
            let v = field.value(DVec3::from_array(x.map(|x| rng.random_range(x.lo..x.hi))));
            (lo, hi) = (lo.min(v), hi.max(v));
        }
        assert!(range.lo <= lo && hi <= range.hi);
        range.width() - (hi - lo)
    };
    let (coarse, fine) = (excess(&mut field, 1e-3), excess(&mut field, 1e-4));
    assert!(fine < 0.2 * coarse, "{coarse} {fine}");
}

#[test]
fn cells_have_the_whole_tape_as_far_as_they_reach() {
    let mut rng = StdRng::seed_from_u64(12);
    let mut b = Build::default();
    let mut solid = b.sphere([0.0; 3], 0.3);
    for i in 0..200 {
        let at = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let ball = b.sphere(at, rng.random_range(0.02..0.3));
        let hollow = b.neg(ball);
        solid = if i % 3 == 0 { b.max(solid, hollow) } else { b.min(solid, ball) };
    }
    let tape = b.field(solid).tape().clone();
    let cells = Cells::new(tape.clone(), &Aabb::cube(1.0).intervals());
    let (mut full, mut less) = (Evaluator::<f64>::new(tape.clone()), Evaluator::<f64>::new(tape.clone()));
    let mut short = Vec::new();
    let mut free = 0;
    for _ in 0..20_000 {
        // Now and then beyond the region.
        let at: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.1..1.1));
        let reach = 0.5 * libm::exp2(-rng.random_range(0.0..10.0));
        // Asked for first, so that free cells get their tapes later.
        let work = cells.occupied_around(at, reach).map(|(_, work)| work);
        let part = cells.tape_around(at, reach);
        assert!(work.is_none_or(|work| work == part.work()), "{work:?} and {} at {at:?}", part.work());
        if reach < 0.02 && at.iter().all(|c| c.abs() < 1.0) {
            short.push(part.len());
        }
        let is_free = work.is_none();
        free += u32::from(is_free);
        less.turn_to(part);
        for _ in 0..4 {
            let p = at.map(|c| c + reach * rng.random_range(-1.0..1.0));
            let (whole, pruned) = (*full.eval(&p), *less.eval(&p));
            assert!(whole > 0.0 || !is_free, "{whole} at {p:?}, within {reach} of {at:?}");
            assert!(
                whole.to_bits() == pruned.to_bits(),
                "{whole} {pruned} at {p:?}, within {reach} of {at:?}"
            );
        }
    }
    let mean = short.iter().sum::<usize>() / short.len();
    assert!(mean < tape.len() / 10, "{mean} of {} instructions are left", tape.len());
    assert!(cells.prunings().tapes > 0);
    assert!(free > 2_000, "only {free} of 20000 places are known to be free");
}

/// However wide the region is, for something far away.
#[test]
fn cells_tell_apart_what_is_small_beside_the_region() {
    for wide in [1.0, 40.0, 3000.0] {
        let mut rng = StdRng::seed_from_u64(5);
        let mut b = Build::default();
        let mut solid = b.sphere([0.0, 0.0, -0.9 * wide], 0.05);
        for _ in 0..100 {
            let at = std::array::from_fn(|_| rng.random_range(-0.5..0.5));
            let ball = b.sphere(at, rng.random_range(0.02..0.1));
            solid = b.min(solid, ball);
        }
        let tape = b.field(solid).tape().clone();
        let cells = Cells::new(tape.clone(), &Aabb::cube(wide).intervals());
        let (mut full, mut less) = (Evaluator::<f64>::new(tape.clone()), Evaluator::<f64>::new(tape.clone()));
        let mut kept = 0;
        for _ in 0..1000 {
            let at: [f64; 3] = std::array::from_fn(|_| rng.random_range(-0.5..0.5));
            let part = cells.tape_around(at, 0.01);
            kept += part.len();
            let p = at.map(|c| c + 0.01 * rng.random_range(-1.0..1.0));
            assert_eq!(full.eval(&p).to_bits(), less.turn_to(part).eval(&p).to_bits());
        }
        assert!(kept / 1000 < tape.len() / 5, "{} of {} instructions within {wide}", kept / 1000, tape.len());
    }
}

/// A ball with noises where a mask lets them through: none below x = 0.2, some up to 0.4, all above; and
/// where y is above 0.1, others.
fn masked(b: &mut Build) -> NodeId {
    let mut ball = b.sphere([0.0; 3], 1.0);
    let [x, y, _] = b.p();
    let along = b.scaled(5.0, x);
    let along = b.shifted(along, -1.0);
    let mask = b.op(Op::Smoothstep(op::Smoothstep), &[along]);
    let edge = b.num(0.1);
    let step = b.op(Op::Step(op::Step), &[edge, y]);
    for seed in 0..NOISES {
        let rough = b.noise(seed, 4.0);
        let rough = b.op(Op::Mul(op::Mul), &[mask, rough]);
        let (low, high) = (b.scaled(0.1, y), b.noise(100 + seed, 2.0));
        let level = b.op(Op::Mix(op::Mix), &[low, high, step]);
        let both = b.add(rough, level);
        ball = b.add(ball, both);
    }
    ball
}

/// On either side.
const NOISES: u64 = 4;

#[test]
fn what_a_mask_hides_is_pruned() {
    let mut b = Build::default();
    let root = masked(&mut b);
    let tape = b.field(root).tape().clone();
    let noises = |tape: &Tape| tape.code().iter().filter(|i| matches!(i, Instr::Noise(..))).count() as u64;
    let left = |x: [f64; 2], y: [f64; 2]| {
        let region = [Interval::new(x[0], x[1]), Interval::new(y[0], y[1]), Interval::radius(0.5)];
        noises(&tape.prune(&region))
    };
    assert_eq!(noises(&tape), 2 * NOISES);
    assert_eq!(left([-1.0, 0.1], [-1.0, 0.0]), 0);
    assert_eq!(left([0.5, 1.0], [-1.0, 0.0]), NOISES);
    assert_eq!(left([-1.0, 0.1], [0.2, 1.0]), NOISES);
    assert_eq!(left([-1.0, 0.5], [-1.0, 1.0]), 2 * NOISES);
    // Behind the mask's end the products are gone, and the noises themselves are what is added.
    let behind = tape.prune(&[Interval::new(0.5, 1.0), Interval::new(-1.0, 0.0), Interval::radius(0.5)]);
    let masks = |i: &&Instr| matches!(i, Instr::Op(Op::Mul(_) | Op::Smoothstep(_) | Op::Mix(_), _));
    assert_eq!(behind.code().iter().filter(masks).count(), 0);
}

/// How often the tape of a small place is shorter, of 20,000; the values there are those of the whole tape.
fn shorter_places(root: NodeId, b: &Build) -> u32 {
    let tape = b.field(root).tape().clone();
    let cells = Cells::new(tape.clone(), &Aabb::cube(1.0).intervals());
    let (mut full, mut less) = (Evaluator::<f64>::new(tape.clone()), Evaluator::<f64>::new(tape.clone()));
    let mut rng = StdRng::seed_from_u64(21);
    let mut shorter = 0;
    for _ in 0..20_000 {
        let at: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let part = cells.tape_around(at, 0.02);
        shorter += u32::from(part.len() < tape.len());
        less.turn_to(part);
        let p = at.map(|c| c + 0.02 * rng.random_range(-1.0..1.0));
        let (whole, pruned) = (*full.eval(&p), *less.eval(&p));
        assert!(whole.to_bits() == pruned.to_bits(), "{whole} {pruned} at {p:?}");
    }
    shorter
}

#[test]
fn masked_cells_have_the_whole_values() {
    let mut b = Build::default();
    let root = masked(&mut b);
    let shorter = shorter_places(root, &b);
    assert!(shorter > 15_000, "only {shorter} of 20000 places have less than everything");
}

#[test]
fn bumps_are_left_out_where_they_have_ended() {
    let mut rng = StdRng::seed_from_u64(31);
    let mut b = Build::default();
    let mut sum = b.num(0.3);
    for i in 0..60 {
        let ball = b.sphere(std::array::from_fn(|_| rng.random_range(-1.0..1.0)), 0.25);
        // Some end as powers, some as rounded ramps.
        let deep = b.scaled(-4.0, ball);
        let bump = match i % 3 {
            0 => b.op(Op::Plus(op::Plus { n: 3 }), &[deep]),
            1 => b.op(Op::Ramp(op::Ramp::Cubic), &[deep]),
            _ => b.op(Op::Ramp(op::Ramp::Quadratic), &[deep]),
        };
        sum = b.sub(sum, bump);
    }
    assert!(shorter_places(sum, &b) > 19_000);
    let tape = b.field(sum).tape().clone();
    let corner = tape.prune(&[Interval::new(0.9, 1.0), Interval::new(0.9, 1.0), Interval::new(0.9, 1.0)]);
    assert!(corner.len() * 4 < tape.len(), "{} of {}", corner.len(), tape.len());
}

#[test]
fn what_melts_is_pruned_where_it_is_far_apart() {
    let mut rng = StdRng::seed_from_u64(32);
    let mut b = Build::default();
    let mut solid = b.sphere([0.0; 3], 0.2);
    for _ in 0..40 {
        let ball = b.sphere(std::array::from_fn(|_| rng.random_range(-1.0..1.0)), 0.1);
        solid = b.op(Op::Melt(op::Melt::new(op::Ramp::Cubic, 0.1)), &[solid, ball]);
    }
    assert!(shorter_places(solid, &b) > 15_000);
    let tape = b.field(solid).tape().clone();
    let corner = tape.prune(&[Interval::new(0.9, 1.0), Interval::new(0.9, 1.0), Interval::new(0.9, 1.0)]);
    assert!(corner.len() * 4 < tape.len(), "{} of {}", corner.len(), tape.len());
}

#[test]
fn sides_of_corners_and_of_absolute_values_are_chosen() {
    let mut b = Build::default();
    let [x, y, _] = b.p();
    let size = b.op(Op::Abs(op::Abs), &[x]);
    let left = b.shifted(size, -0.5);
    let both = b.op(Op::Corner(op::Corner), &[left, y]);
    let tape = b.field(both).tape().clone();
    // Inside of the corner and nearer to one side.
    let region = [Interval::new(0.1, 0.2), Interval::new(-0.9, -0.8), Interval::radius(0.1)];
    let pruned = tape.prune(&region);
    let folded = |i: &&Instr| matches!(i, Instr::Op(Op::Corner(_) | Op::Abs(_), _));
    assert_eq!(pruned.code().iter().filter(folded).count(), 0);
    shorter_places(both, &b);
}

/// A fractal has the detail that its samples can show, wherever it is asked.
#[test]
fn detail_is_limited_where_maps_come_to() {
    let octaves = "import \"std/fractal\" as fractal; let f = fractal::fbm(gradient(7), #{ octaves: 8 }); ";
    let limited = |text: &str, spacing: f64| {
        let compiled = compile(&Request::text(format!("{octaves}{text}")));
        let scene = compiled.scene.unwrap_or_else(|| panic!("{text}: {:?}", compiled.diagnostics));
        let root = [scene.surface.field];
        let (graph, roots) = Spacing::Even(spacing).limit(&scene.graph, &root).unwrap();
        Evaluator::<f64>::new(Arc::new(Tape::new(&graph, &roots)))
    };
    // A field, another one that is the same, and by how much larger space is for the second.
    let pairs = [
        ("f.scaled(4.0)", "f.at(4.0 * p)", 1.0),
        ("f.scaled(4.0)", "(f + 0.0 * x).at(4.0 * p + 0.0 * sin(x))", 1.0),
        ("f", "f.at(0.01 * p)", 100.0),
        ("f.scaled(3.0).on_sphere()", "f.scaled(3.0).on_sphere()", 250.0),
        ("(f + 0.0 * x).at(3.0 * p).on_sphere()", "f.scaled(3.0).on_sphere()", 0.01),
        ("f", "f.at(vec3(0.6*x - 0.8*y, 0.8*x + 0.6*y, z)).at(vec3(0.6*x + 0.8*y, 0.6*y - 0.8*x, z))", 1.0),
        ("f.on_plane()", "f.on_plane().at(vec3(x, 100.0 * y, z))", 1.0),
        ("f.at(vec3(length(vec3(x, 0, z)), y, 0))", "f.at(0.01 * vec3(length(vec3(x, 0, z)), y, 0))", 100.0),
        ("f.at(4.0 * normalize(p))", "f.scaled(4.0).at(normalize(p))", 1.0),
    ];
    let mut rng = StdRng::seed_from_u64(17);
    for (a, b, larger) in pairs {
        let mut seen = 0.0_f64;
        for spacing in [0.001, 0.01, 0.03, 0.1] {
            let (mut f, mut g) = (limited(a, spacing), limited(b, larger * spacing));
            let mut whole = limited(a, 0.0);
            for _ in 0..50 {
                let p: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
                let (u, v) = (*f.eval(&p), *g.eval(&p.map(|x| larger * x)));
                assert!((u - v).abs() < 1e-9, "{a}, {b} at {p:?}: {u} {v}");
                seen = seen.max((u - whole.eval(&p)).abs());
            }
        }
        assert!(seen > 0.02, "{a}: some octaves have faded ({seen})");
    }
}

/// A minimum under all that grows with it, and where it is read twice, or by what falls with it.
#[test]
fn a_minimum_is_the_least_of_its_operands() {
    let mut rng = StdRng::seed_from_u64(41);
    let mut b = Build::default();
    let ball = |b: &mut Build, rng: &mut StdRng| {
        b.sphere(std::array::from_fn(|_| rng.random_range(-1.0..1.0)), rng.random_range(0.05..0.4))
    };
    let mut most = 0;
    for round in 0..60 {
        let mut rest: Vec<NodeId> = (0..40).map(|_| ball(&mut b, &mut rng)).collect();
        while rest.len() > 1 {
            let [left, right] = [0, 1].map(|_| rest.swap_remove(rng.random_range(0..rest.len())));
            let either = b.min(left, right);
            let noise = b.noise(round, 3.0);
            rest.push(match rng.random_range(0..40) {
                0 => b.shifted(either, 0.01),
                1 => b.scaled(1.1, either),
                2 => b.add(noise, either),
                3 => b.sub(either, noise),
                4 => b.max(noise, either),
                5 => b.scaled(-1.0, either),
                6 => b.sub(noise, either),
                // Two that are read twice.
                7 => b.op(Op::Mul(op::Mul), &[either, either]),
                8 => {
                    let other = b.neg(either);
                    b.max(either, other)
                }
                _ => either,
            });
        }
        let tape = b.field(rest[0]).tape().clone();
        let operands = tape.operands();
        most = most.max(operands.len());
        assert!(operands.iter().map(|o| o.work()).sum::<u64>() <= 2 * tape.work());
        let mut whole = Evaluator::<f64>::new(tape.clone());
        let mut parts: Vec<_> = operands.into_iter().map(Evaluator::<f64>::new).collect();
        for _ in 0..100 {
            let p: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.5..1.5));
            let least = parts.iter_mut().map(|part| *part.eval(&p)).fold(f64::INFINITY, f64::min);
            assert_eq!(*whole.eval(&p), least, "{round}");
        }
    }
    assert!(most > 30, "{most}");
}

#[test]
fn what_operands_have_in_common_is_not_evaluated_for_each() {
    let mut b = Build::default();
    let shared = common::three_octaves(&mut b);
    let balls: Vec<NodeId> = (0..64).map(|i| b.sphere([0.1 * f64::from(i), 0.0, 0.0], 0.3)).collect();
    let union = balls.into_iter().reduce(|a, c| b.min(a, c)).unwrap();
    let rough = b.add(union, shared);
    let tape = b.field(rough).tape().clone();
    let operands = tape.operands();
    assert!((2..64).contains(&operands.len()), "{}", operands.len());
    assert!(operands.iter().map(|o| o.work()).sum::<u64>() <= 2 * tape.work());
}

/// Where the place goes evenly; elsewhere the bound of a slope is better of the whole product.
#[test]
fn products_of_the_place_with_numbers_are_sums() {
    let mut rng = StdRng::seed_from_u64(42);
    let mut b = Build::default();
    let dots = |tape: &Tape| tape.code().iter().filter(|i| matches!(i, Instr::Op(Op::Dot(_), _))).count();
    for round in 0..200 {
        let weights: [f64; 3] = std::array::from_fn(|_| match rng.random_range(0..4) {
            0 => 0.0,
            1 => 1.0,
            _ => rng.random_range(-2.0..2.0),
        });
        let [x, y, z] = b.p();
        let turned = b.sub(x, z);
        let place = [b.scaled(0.8, turned), y, b.shifted(z, 0.3)];
        let numbers = weights.map(|weight| b.num(weight));
        let [left, right] = if round % 2 == 0 { [place, numbers] } else { [numbers, place] };
        let dot = b.op(Op::Dot(op::Dot), &[left, right].concat());
        let tape = b.field(dot).tape().clone();
        assert_eq!(dots(&tape), 0);
        let mut field = Field::of_tape(&tape);
        for _ in 0..20 {
            let p: [f64; 3] = std::array::from_fn(|_| rng.random_range(-9.0..9.0));
            let [a, c, d] = [(p[0] - p[2]) * 0.8, p[1], p[2] + 0.3];
            let want = a * weights[0] + c * weights[1] + d * weights[2];
            assert_eq!(field.value(DVec3::from_array(p)), want, "{weights:?} at {p:?}");
        }
    }
    let [x, y, z] = b.p();
    let length = b.op(Op::Length(op::Length), &[x, y, z]);
    let numbers = [0.1, 0.2, 0.3].map(|weight| b.num(weight));
    let bent = b.op(Op::Dot(op::Dot), &[&[length, y, z][..], &numbers].concat());
    assert_eq!(dots(b.field(bent).tape()), 1);
}

/// Of many small parts, which are loosely enclosed in large cells, the box is found, and that there are no more.
#[test]
fn the_box_of_many_parts_fits() {
    let script = "let parts = [sphere(1.0)];
        for i in 0..300 {
            let y = 1.0 - 2.0 * (i + 0.5) / 300.0;
            parts.push(pyramid(4, 0.05, 0.05).translated([0, 1.02, 0]).rotated([1, 0, 0], degrees(acos(y)))
                .rotated([0, 1, 0], 137.50776 * i));
        }
        union(parts)";
    let compiled = compile(&Request::text(script.to_owned()));
    let scene = compiled.scene.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    let mut field = Field::new(&scene.graph, scene.surface.field);
    let Extent::Within(found) = extent(&field, &Aabb::cube(2.0)) else { panic!("a bounded solid") };
    let mut rng = StdRng::seed_from_u64(43);
    for _ in 0..20_000 {
        let p = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.2..1.2)));
        assert!(
            field.value(p) > 0.0 || p.cmpge(found.min).all() && p.cmple(found.max).all(),
            "{p} {found:?}"
        );
    }
    // The tips are 1.045 from the centre.
    assert!(Aabb::cube(1.065).holds(&found), "{found:?}");
    assert_eq!(around(&field, &Aabb::cube(2.0), FAR, &|| false).clear, FAR);
}

/// The search ends at what it knows to be solid, and that is not taken for more: something small far out is in the box.
#[test]
fn what_sticks_out_is_in_the_box() {
    let mut rng = StdRng::seed_from_u64(44);
    let mut loose = 0;
    for _ in 0..100 {
        let mut b = Build::default();
        let balls: Vec<([f64; 3], f64)> = (0..rng.random_range(1..30))
            .map(|_| {
                (std::array::from_fn(|_| rng.random_range(-1.5..1.5)), 0.4 * rng.random_range(0.1..1.0_f64))
            })
            .collect();
        let fields: Vec<NodeId> = balls.iter().map(|(c, r)| b.sphere(*c, *r)).collect();
        let union = fields.into_iter().reduce(|a, c| b.min(a, c)).unwrap();
        let all = balls.iter().map(|(c, r)| Aabb { min: DVec3::from(*c) - *r, max: DVec3::from(*c) + *r });
        let all = all.reduce(|a, c| a.hull(&c)).unwrap();
        let Extent::Within(found) = extent(&b.field(union), &Aabb::cube(2.0)) else {
            panic!("a bounded solid")
        };
        assert!(found.holds(&all), "{found:?} {all:?}");
        let excess = (all.min - found.min).max(found.max - all.max).max_element();
        loose += u32::from(excess > 0.01 * all.diagonal());
    }
    assert!(loose == 0, "{loose}");
}
