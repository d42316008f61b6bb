//! Distances against all triangles one by one, signs against solid angles.

use super::closed::{Corners, closed};
use super::search::GROUP;
use super::*;
use crate::num::Interval;
use rand::{RngExt, SeedableRng, rngs::StdRng};

/// A sphere of triangles, with radii as given.
fn ball(finer: u32, mut radius: impl FnMut() -> f64) -> Mesh {
    let mut points = vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut triangles = Vec::new();
    for [x, y, z] in [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]] {
        triangles.extend([[x, y, z], [y, x, 5]]);
    }
    for _ in 0..finer {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                (points.len() - 1) as u32
            })
        };
        let mut parts = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            parts.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = parts;
    }
    points.iter_mut().for_each(|p| *p *= radius());
    Mesh { points, triangles, ..Mesh::default() }
}

fn cube(at: DVec3) -> Mesh {
    let points =
        (0..8).map(|i| at + DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Mesh { points, triangles, ..Mesh::default() }
}

fn both(a: Mesh, b: Mesh) -> Mesh {
    let start = a.points.len() as u32;
    let triangles = a.triangles.into_iter().chain(b.triangles.into_iter().map(|t| t.map(|i| i + start)));
    Mesh { triangles: triangles.collect(), points: [a.points, b.points].concat(), ..Mesh::default() }
}

fn turned_about(mut m: Mesh) -> Mesh {
    let turn = glam::DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7);
    m.points.iter_mut().for_each(|p| *p = turn * *p);
    m
}

/// Meshes of every kind, with names.
fn all() -> Vec<(&'static str, Mesh)> {
    let mut rng = StdRng::seed_from_u64(5);
    let mut rough = ball(3, || rng.random_range(0.6..1.2));
    let mut rng = StdRng::seed_from_u64(6);
    let open = {
        let mut m = ball(3, || 1.0);
        m.triangles.retain(|_| rng.random_range(0.0..1.0) > 0.2);
        m
    };
    let soup = Mesh {
        points: (0..60).map(|_| DVec3::new(rng.random(), rng.random(), rng.random())).collect(),
        triangles: (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    let lonely =
        Mesh { points: vec![DVec3::ZERO, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]], ..Mesh::default() };
    let mut inward = ball(1, || 1.0);
    inward.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let hollow = both(ball(2, || 1.0), {
        let mut m = ball(2, || 0.5);
        m.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        m
    });
    // Thin triangles: a cube's edge is split next to its end.
    let mut thin = cube(DVec3::ZERO);
    thin.points.push(DVec3::new(0.5, 0.0, 1e-9));
    thin.triangles[0] = [0, 2, 8];
    thin.triangles.extend([[2, 3, 8], [3, 1, 8], [0, 8, 1]]);
    thin.triangles[1] = [0, 0, 1];
    rough.normals.clear();
    vec![
        ("rough", rough),
        ("open", open),
        ("soup", soup),
        ("lonely", lonely),
        ("inward", inward),
        ("hollow", hollow),
        ("cube", cube(DVec3::ZERO)),
        ("turned cube", turned_about(cube(DVec3::ZERO))),
        ("overlapping", both(cube(DVec3::ZERO), cube(DVec3::splat(0.5)))),
        ("twice", both(cube(DVec3::ZERO), cube(DVec3::ZERO))),
        ("edge to edge", both(cube(DVec3::ZERO), cube(DVec3::new(1.0, 1.0, 0.0)))),
        ("corner to corner", both(cube(DVec3::ZERO), cube(DVec3::splat(1.0)))),
        ("thin", thin),
    ]
}

/// The distance to a triangle, from its parts one by one.
fn apart([a, b, c]: Corners, x: DVec3) -> f64 {
    let to_edge = |p: DVec3, q: DVec3| {
        let t = ((x - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
        (x - p - (q - p) * t).length()
    };
    let n = (b - a).cross(c - a);
    let inner = |p: DVec3, q: DVec3| n.dot((q - p).cross(x - p)) >= 0.0;
    let plane = if inner(a, b) && inner(b, c) && inner(c, a) {
        (x - a).dot(n.normalize()).abs()
    } else {
        f64::INFINITY
    };
    plane.min(to_edge(a, b)).min(to_edge(b, c)).min(to_edge(c, a))
}

/// How often triangles wind around a point: the sum of their solid angles.
fn winding(triangles: &[Corners], x: DVec3) -> f64 {
    let angle = |t: &Corners| {
        let [a, b, c] = t.map(|p| p - x);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// A point around a mesh: anywhere, near it, on a lattice.
fn anywhere(mesh: &Mesh, rng: &mut StdRng) -> DVec3 {
    let (lo, hi) = mesh.bounds().expect("points");
    let at = DVec3::new(rng.random(), rng.random(), rng.random());
    let wide = lo - 0.3 * (hi - lo) + 1.6 * (hi - lo) * at;
    match rng.random_range(0..4) {
        0 => (wide * 8.0).round() / 8.0,
        1 => {
            let t = mesh.corners(rng.random_range(0..mesh.triangles.len()));
            let near = t[0] + (t[1] - t[0]) * at.x * (1.0 - at.y) + (t[2] - t[0]) * at.y;
            near + (at - 0.5) * 10f64.powf(rng.random_range(-9.0..-1.0))
        }
        _ => wide,
    }
}

#[test]
fn distances_and_signs_are_those_of_all_triangles() {
    for (name, mesh) in all() {
        let (field, triangles) = (Distance::new(&mesh).expect(name), closed(&mesh).0);
        let mut rng = StdRng::seed_from_u64(1);
        let mut inside = 0;
        for _ in 0..3000 {
            let x = anywhere(&mesh, &mut rng);
            let value = field.jet(Order::Value, x.to_array()).value;
            let with_area = triangles.iter().filter(|[a, b, c]| (b - a).cross(c - a).length() > 0.0);
            let all = with_area.map(|t| apart(*t, x)).fold(f64::INFINITY, f64::min);
            let off = field.error(x.abs().max_element())[0];
            assert!((value.abs() - all).abs() <= off, "{name}: {value} is not {all} at {x}, within {off}");
            if all > 1e-9 {
                let turns = winding(&triangles, x);
                // Solid angles lose their digits near the surface, but not all of them.
                assert!((turns - turns.round()).abs() < 1e-6 || all < 1e-4, "{name} is open: {turns} at {x}");
                assert_eq!(value < 0.0, turns > 0.5, "{name} at {x}: {value}, {turns} turns");
                inside += usize::from(value < 0.0);
            }
        }
        assert!((inside > 100) != ["soup", "lonely"].contains(&name) || name == "soup", "{name}: {inside}");
    }
}

/// Whichever way some triangles and some parts are turned, inside is where it was.
#[test]
fn what_is_turned_the_wrong_way_is_turned_back() {
    let mut rng = StdRng::seed_from_u64(12);
    for (name, mesh) in all() {
        if ["open", "soup", "lonely", "twice", "thin"].contains(&name) {
            continue;
        }
        let right = Distance::new(&mesh).unwrap();
        for share in [0.3, 1.0] {
            let mut wrong = mesh.clone();
            // Of a ball with a void both surfaces, since one of them alone would be something else.
            let first = mesh.triangles.len() / if name == "hollow" { 1 } else { 2 };
            for t in &mut wrong.triangles[..first] {
                if rng.random_bool(share) {
                    t.swap(1, 2);
                }
            }
            let wrong = Distance::new(&wrong).unwrap();
            for _ in 0..200 {
                let x = anywhere(&mesh, &mut rng).to_array();
                let [a, b] = [&right, &wrong].map(|d| d.jet(Order::Value, x).value);
                assert!((a - b).abs() < 1e-12, "{name} at {x:?}, {share} turned: {a} and {b}");
            }
        }
    }
}

#[test]
fn gradients_and_second_derivatives_match_differences() {
    let mut compared = 0;
    for (name, mesh) in all() {
        let field = Distance::new(&mesh).expect(name);
        let mut rng = StdRng::seed_from_u64(2);
        for _ in 0..500 {
            let x = anywhere(&mesh, &mut rng);
            let jet = field.jet(Order::Hessian, x.to_array());
            let length = DVec3::from(jet.grad).length();
            assert!((length - 1.0).abs() < 1e-14, "{name}: a gradient of length {length}");
            let h = 1e-4;
            if jet.value.abs() < 0.05 {
                continue;
            }
            for axis in 0..3 {
                let [low, high] = [-h, h].map(|h| {
                    let mut at = x.to_array();
                    at[axis] += h;
                    field.jet(Order::Hessian, at)
                });
                // Not across a crease.
                let turn = (DVec3::from(low.grad) - DVec3::from(high.grad)).length();
                if turn > 3.0 * h / jet.value.abs() {
                    continue;
                }
                compared += 1;
                let slope = (high.value - low.value) / (2.0 * h);
                assert!(
                    (slope - jet.grad[axis]).abs() < 2.0 * h / jet.value.abs(),
                    "{name}: {slope} {}",
                    jet.grad[axis]
                );
                let bend = (high.grad[axis] - low.grad[axis]) / (2.0 * h);
                // Not where another part becomes the nearest.
                let same = |other: &Point| (other.hess[axis] - jet.hess[axis]).abs() < 0.1 + 0.1 * bend.abs();
                if same(&low) && same(&high) {
                    let near = (bend - jet.hess[axis]).abs() < 0.2 + 0.2 * bend.abs();
                    assert!(near, "{name}: {bend} {}", jet.hess[axis]);
                }
            }
        }
    }
    assert!(compared > 5000, "only {compared} comparisons");
}

#[test]
fn batches_give_the_same_bits_in_any_order() {
    for (name, mesh) in all() {
        let field = Distance::new(&mesh).expect(name);
        let mut rng = StdRng::seed_from_u64(3);
        let mut points: Vec<DVec3> = (0..200).map(|_| anywhere(&mesh, &mut rng)).collect();
        // As many as are searched for at the same time, close together as seen from the surface.
        for _ in 0..50 {
            let middle = anywhere(&mesh, &mut rng);
            let distance = field.jet(Order::Value, middle.to_array()).value.abs();
            let reach = distance * rng.random_range(1e-3..0.3);
            let off =
                |rng: &mut StdRng| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            points.extend((0..GROUP).map(|_| middle + reach * off(&mut rng)));
        }
        let at = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<f64>>();
        let (x, y, z) = (at(0), at(1), at(2));
        let mut all = vec![vec![0.0; points.len()]; 4];
        let [v, gx, gy, gz] = &mut all[..] else { return };
        field.jets([&x, &y, &z], Jets { value: v, grad: Some([gx, gy, gz]), hess: None });
        for (i, p) in points.iter().enumerate() {
            let alone = field.jet(Order::Gradient, p.to_array());
            let [gx, gy, gz] = alone.grad;
            for (k, own) in [alone.value, gx, gy, gz].into_iter().enumerate() {
                assert_eq!(own.to_bits(), all[k][i].to_bits(), "{name}: entry {k} at {p}");
            }
        }
    }
}

#[test]
fn more_points_than_are_put_in_order_at_once_give_the_same_bits() {
    let mesh = turned_about(cube(DVec3::ZERO));
    let field = Distance::new(&mesh).expect("a cube");
    let mut rng = StdRng::seed_from_u64(9);
    let mut points: Vec<DVec3> = (0..PIECE + 7).map(|_| anywhere(&mesh, &mut rng)).collect();
    points[3] = DVec3::NAN;
    points[MANY] = DVec3::new(f64::INFINITY, 0.0, 0.0);
    points[PIECE] = DVec3::splat(-1e200);
    let [x, y, z] = [0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).collect::<Vec<f64>>());
    let ask = |lanes: Range<usize>| {
        let mut all = vec![vec![0.0; lanes.len()]; 4];
        let [value, gx, gy, gz] = &mut all[..] else { return all };
        let at = [&x, &y, &z].map(|at| &at[lanes.clone()]);
        field.jets(at, Jets { value, grad: Some([gx, gy, gz]), hess: None });
        all
    };
    let at_once = ask(0..points.len());
    for start in (0..points.len()).step_by(BATCH) {
        let lanes = start..points.len().min(start + BATCH);
        for (few, many) in ask(lanes.clone()).iter().zip(&at_once) {
            let same = few.iter().zip(&many[lanes.clone()]).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "from point {start} on");
        }
    }
}

#[test]
fn threads_make_no_difference() {
    let mut rng = StdRng::seed_from_u64(4);
    let mesh = ball(6, || rng.random_range(0.9..1.1));
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let field = pool.install(|| Distance::new(&mesh)).expect("a mesh");
        format!("{field:?}")
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn balls_hold_what_is_said_of_them() {
    let (mut sharp, mut leaning) = (0, 0);
    for (name, mesh) in all() {
        let field = Distance::new(&mesh).expect(name);
        let mut rng = StdRng::seed_from_u64(7);
        for _ in 0..300 {
            let c = anywhere(&mesh, &mut rng);
            let r = 10f64.powf(rng.random_range(-6.0..0.3));
            let local = field.local(Order::Gradient, c.to_array(), r);
            sharp += usize::from(local.bow.width() < r);
            let lean = field.lean(c.to_array(), r);
            leaning += usize::from(lean.is_some());
            let off = field.error(c.abs().max_element() + r);
            for _ in 0..30 {
                let h = DVec3::new(
                    rng.random_range(-1.0..1.0),
                    rng.random_range(-1.0..1.0),
                    rng.random_range(-1.0..1.0),
                );
                let h = r * if rng.random() { h.normalize() } else { h / 2.0 };
                let there = field.jet(Order::Gradient, (c + h).to_array());
                if let Some(lean) = lean {
                    let along = DVec3::from(there.grad).dot(lean.axis.into());
                    assert!(along >= lean.least - 2.0 * off[1], "{name}: {along} {lean:?} at {h} from {c}");
                }
                let value = there.value;
                let bow = value - local.jet.value - DVec3::from(local.jet.grad).dot(h);
                let known = local.bow + Interval::radius(2.0 * off[0] + 2.0 * off[1] * r);
                assert!(known.contains(bow), "{name}: {bow:e} is not in {known:?} at {h} from {c}");
                assert!(
                    (value - local.jet.value).abs() <= r * (1.0 + 1e-12) + 2.0 * off[0],
                    "{name}: too steep"
                );
            }
        }
    }
    assert!(sharp > 1500, "only {sharp} bows say anything");
    assert!(leaning > 1000, "only {leaning} balls have gradients of one way");
}

#[test]
fn lids_make_no_steps() {
    for (name, mesh) in all() {
        let field = Distance::new(&mesh).expect(name);
        let mut rng = StdRng::seed_from_u64(8);
        for _ in 0..50 {
            let (a, b) = (anywhere(&mesh, &mut rng), anywhere(&mesh, &mut rng));
            let at = |i: i32| a + (b - a) * (f64::from(i) / 500.0);
            let values: Vec<f64> =
                (0..=500).map(|i| field.jet(Order::Value, at(i).to_array()).value).collect();
            for (i, pair) in values.windows(2).enumerate() {
                let step = (b - a).length() / 500.0;
                assert!(
                    (pair[0] - pair[1]).abs() <= step * (1.0 + 1e-9) + 1e-14,
                    "{name}: a step near {}",
                    at(i as i32)
                );
            }
        }
    }
}

#[test]
fn flawed_meshes_are_refused() {
    let mesh = |points: Vec<DVec3>, triangles| Mesh { points, triangles, ..Mesh::default() };
    let none = |m: &Mesh| Distance::new(m).map(|_| ()).expect_err("a flawed mesh");
    assert_eq!(none(&Mesh::default()), Unfit::Empty);
    let line = vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
    assert_eq!(none(&mesh(line.clone(), vec![[0, 1, 2], [0, 0, 1]])), Unfit::Empty);
    assert_eq!(none(&mesh(line, vec![[0, 1, 3]])), Unfit::Flaw(Flaw::Index { triangle: 0, count: 3 }));
    let far = vec![DVec3::NAN, DVec3::X, DVec3::Y];
    assert_eq!(none(&mesh(far, vec![[0, 1, 2]])), Unfit::Flaw(Flaw::Point(0)));
    let large = vec![DVec3::ZERO, DVec3::X * 1e61, DVec3::Y];
    assert_eq!(none(&mesh(large, vec![[0, 1, 2]])), Unfit::Size);
    let small = vec![DVec3::ZERO, DVec3::X * 1e-120, DVec3::Y * 1e-120];
    assert_eq!(none(&mesh(small, vec![[0, 1, 2]])), Unfit::Empty);
}

#[test]
fn any_size_of_mesh_is_measured() {
    for scale in [1e-45, 1e-12, 1.0, 1e12, 1e45] {
        let mut m = ball(2, || scale);
        let field = Distance::new(&m).expect("a ball");
        let value = |x: f64| field.jet(Order::Gradient, [x * scale, 0.0, 0.0]).value / scale;
        assert!(
            (value(3.0) - 2.0).abs() < 1e-12 && value(0.0) < -0.8,
            "{scale}: {} {}",
            value(3.0),
            value(0.0)
        );
        let mut square = cube(DVec3::splat(-0.5));
        square.points.iter_mut().for_each(|p| *p *= scale);
        let field = Distance::new(&square).expect("a cube");
        assert!(field.jet(Order::Value, [0.1 * scale; 3]).value < 0.0, "{scale}");
        // Another one, as far off as it is small.
        let start = m.points.len() as u32;
        m.points.extend_from_within(..);
        m.points[start as usize..].iter_mut().for_each(|p| *p += DVec3::splat(1e12 * scale));
        m.triangles.extend(m.triangles.clone().into_iter().map(|t| t.map(|i| i + start)));
        let field = Distance::new(&m).expect("two balls");
        let value = field.jet(Order::Gradient, [0.0; 3]).value / scale;
        assert!(value.abs() > 0.8 && value.abs() < 1.0, "{scale}: {value}");
    }
}

#[test]
fn points_that_are_nowhere_or_far_away_have_values() {
    let field = Distance::new(&cube(DVec3::ZERO)).expect("a cube");
    let value = |x: [f64; 3]| field.jet(Order::Hessian, x).value;
    assert!(value([f64::NAN, 0.0, 0.0]).is_nan());
    assert!(!value([f64::INFINITY, 0.0, 0.0]).is_finite());
    assert_eq!(value([-1e300, 0.0, 0.0]), 1e300);
    assert_eq!(value([-1e110, 0.0, 0.0]), 1e110);
    assert_eq!(value([0.0, 0.0, -1e9]), 1e9);
}

#[test]
fn a_hundred_thousand_triangles_in_one_place_are_measured() {
    let one = cube(DVec3::ZERO);
    let mut m = one.clone();
    for _ in 0..8000 {
        m = Mesh { triangles: [&m.triangles[..], &one.triangles].concat(), ..m };
    }
    let field = Distance::new(&m).expect("a heap of cubes");
    assert!((field.jet(Order::Value, [0.5, 0.5, 0.25]).value + 0.25).abs() < 1e-15);
    assert!((field.jet(Order::Value, [0.5, 0.5, -0.25]).value - 0.25).abs() < 1e-15);
}
