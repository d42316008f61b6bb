//! Laws of the spline: it passes through its samples, its derivatives are derivatives, its bounds
//! bound, and every enclosure holds what it encloses.

use super::*;
use crate::num::{Affine, Bounds, Interval, Jet, Jets, Kernel, Many, Number, Reduced, Slope, mix, uniform};

fn random(i: u64) -> f64 {
    2.0 * uniform(mix(i)) - 1.0
}

fn frames() -> Vec<Frame> {
    let mut frames = Vec::new();
    for edge in [Edge::Repeat, Edge::Clamp] {
        for size in [[17, 1, 12], [9, 11, 8], [1, 1, 5], [2, 3, 4], [24, 20, 17]] {
            let max = [1.5, 1.0, 2.5];
            frames.push(Frame::over(size, [-0.5, -0.25, -1.0], max, edge).unwrap());
        }
    }
    frames
}

fn grids() -> Vec<Grid> {
    let rough = |frame: Frame| {
        let values = (0..frame.count() as u64).map(|i| 3.0 + random(i * 7 + 1)).collect();
        Grid::through(&Samples { frame, values }).unwrap()
    };
    // Steep in one place only.
    let peak = |frame: Frame| {
        let f = |[x, y, z]: [f64; 3]| libm::exp(-20.0 * (x * x + y * y + z * z));
        Grid::through(&Samples::of(frame, f, &never).unwrap()).unwrap()
    };
    frames().into_iter().map(rough).chain(frames().into_iter().map(peak)).collect()
}

fn point(seed: u64) -> [f64; 3] {
    [0, 1, 2].map(|axis| 4.0 * random(seed * 3 + axis))
}

#[test]
fn the_spline_passes_through_its_samples() {
    for frame in frames() {
        let values: Vec<f64> = (0..frame.count() as u64).map(random).collect();
        let samples = Samples { frame, values };
        let grid = Grid::through(&samples).unwrap();
        for (i, v) in samples.values.iter().enumerate() {
            assert!((grid.value(frame.place(i)) - v).abs() < 1e-12, "{frame:?} {i}");
        }
        for (a, b) in grid.samples().values.iter().zip(&samples.values) {
            assert!((a - b).abs() < 1e-13);
        }
    }
}

#[test]
fn grids_repeat_or_come_to_rest() {
    for grid in grids() {
        let Frame { size, origin, spacing, edge } = grid.frame;
        let extent = grid.frame.extent();
        for seed in 0..50 {
            let p = point(seed);
            match edge {
                Edge::Repeat => {
                    let q: [f64; 3] = std::array::from_fn(|a| p[a] - 3.0 * extent[a]);
                    assert!((grid.value(p) - grid.value(q)).abs() < 1e-10);
                }
                Edge::Clamp => {
                    let beyond = |p: [f64; 3], far: f64| -> [f64; 3] {
                        let end = origin[0] + (size[0] as f64 + 1.0 + far) * spacing[0];
                        [end, p[1], p[2]]
                    };
                    assert_eq!(grid.value(beyond(p, 0.0)), grid.value(beyond(p, 1e6)));
                    if size[0] > 1 {
                        let jet = grid.jet(Order::Hessian, beyond(p, 0.5));
                        assert!(jet.grad[0].abs() < 1e-12 && jet.hess[0].abs() < 1e-10);
                    }
                }
            }
        }
    }
}

#[test]
fn derivatives_match_differences_and_are_continuous_across_cells() {
    for grid in grids() {
        let b = grid.bounds();
        for seed in 0..60 {
            let mut p = point(seed);
            if seed % 2 == 0 {
                // On the faces between cells.
                for axis in 0..3 {
                    let Frame { origin, spacing, .. } = grid.frame;
                    p[axis] =
                        origin[axis] + ((p[axis] - origin[axis]) / spacing[axis]).round() * spacing[axis];
                }
            }
            let here = grid.jet(Order::Hessian, p);
            let h = 1e-5;
            for axis in 0..3 {
                let moved = |d: f64| {
                    let mut q = p;
                    q[axis] += d;
                    grid.jet(Order::Hessian, q)
                };
                let (a, c) = (moved(-h), moved(h));
                let quotient = (c.value - a.value) / (2.0 * h);
                assert!((quotient - here.grad[axis]).abs() < 1e-6 + b.third * h * h);
                let column = [[0, 3, 4], [3, 1, 5], [4, 5, 2]][axis];
                for k in 0..3 {
                    let quotient = (c.grad[k] - a.grad[k]) / (2.0 * h);
                    assert!(
                        (quotient - here.hess[column[k]]).abs() < 1e-5 + b.third * h,
                        "{quotient} {here:?}"
                    );
                }
                // The Hessian is Lipschitz, so it does not jump anywhere.
                for k in 0..6 {
                    assert!((c.hess[k] - a.hess[k]).abs() <= 2.0 * h * b.third * (1.0 + 1e-9) + 1e-9);
                }
            }
        }
    }
}

/// Largest value, slope and curvature of some jets.
fn seen(jets: &[crate::num::Point]) -> Bounds {
    let mut most = Bounds { range: 0.0, lipschitz: 0.0, hessian: 0.0, third: 0.0 };
    for jet in jets {
        most.range = most.range.max(jet.value.abs());
        most.lipschitz = most.lipschitz.max(jet.grad.iter().map(|g| g * g).sum::<f64>().sqrt());
        let [xx, yy, zz, xy, xz, yz] = jet.hess;
        for seed in 0..20 {
            let u = point(seed);
            let norm = u.iter().map(|u| u * u).sum::<f64>();
            let form = xx * u[0] * u[0]
                + yy * u[1] * u[1]
                + zz * u[2] * u[2]
                + 2.0 * (xy * u[0] * u[1] + xz * u[0] * u[2] + yz * u[1] * u[2]);
            most.hessian = most.hessian.max((form / norm).abs());
        }
    }
    most
}

#[test]
fn bounds_bound_everywhere_and_in_every_ball() {
    for (number, grid) in grids().iter().enumerate() {
        let all = grid.bounds();
        let Frame { origin, .. } = grid.frame;
        let extent = grid.frame.extent();
        let place = |i: u64| std::array::from_fn(|a| origin[a] + extent[a] * uniform(mix(3 * i + a as u64)));
        let jets: Vec<_> = (0..3000).map(|i| grid.jet(Order::Hessian, place(i))).collect();
        let most = seen(&jets);
        let within = |a: Bounds, b: Bounds| {
            let slack = 1.0 + 1e-12;
            let tiny = 1e-12;
            assert!(a.range <= b.range * slack + tiny, "{a:?} {b:?}");
            assert!(a.lipschitz <= b.lipschitz * slack + tiny, "{a:?} {b:?}");
            assert!(a.hessian <= b.hessian * slack + tiny, "{a:?} {b:?}");
        };
        within(most, all);
        // Honest, and not wildly so.
        if number >= 10 && grid.frame.count() > 1000 {
            assert!(
                all.lipschitz < 5.0 * most.lipschitz && all.hessian < 12.0 * most.hessian,
                "{most:?} {all:?}"
            );
        }
        let mut tighter = 0;
        for seed in 0..200 {
            let centre = point(seed + 1000);
            let radius = 10f64.powf(1.5 * random(seed) - 1.0);
            let local = grid.local(Order::Hessian, centre, radius);
            tighter += usize::from(local.bounds.hessian < 0.5 * all.hessian);
            let inside: Vec<_> = (0..60)
                .map(|i| {
                    let d = point(seed * 60 + i);
                    let far = d.iter().map(|d| d * d).sum::<f64>().sqrt();
                    let r = radius * uniform(mix(i ^ 99));
                    grid.jet(Order::Hessian, std::array::from_fn(|a| centre[a] + d[a] / far * r))
                })
                .collect();
            within(seen(&inside), local.bounds);
            for jet in &inside {
                let distance =
                    jet.hess.iter().zip(&local.jet.hess).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(distance <= local.bounds.third * radius * (1.0 + 1e-9) + 1e-9);
            }
        }
        if number >= 10 && grid.frame.count() > 1000 {
            assert!(tighter > 50, "{:?} {tighter}", grid.frame);
        }
    }
}

fn enclosures(grid: &Grid, x: &[Interval; 3]) -> (Vec<Interval>, Slope, Jet<Interval>) {
    let interval = Interval::kernel(grid, x.each_ref());
    let affine = x.map(Affine::over);
    let affine = Affine::kernel(grid, affine.each_ref()).range;
    let reduced: [Reduced<3>; 3] = std::array::from_fn(|axis| {
        let mut spread = [0.0; 3];
        spread[axis] = x[axis].rad();
        Reduced::new(x[axis].mid(), spread)
    });
    let reduced = Reduced::kernel(grid, reduced.each_ref()).range;
    let slope: [Slope; 3] = std::array::from_fn(|a| Slope::coordinate(x[a], a));
    let slope = Slope::kernel(grid, slope.each_ref());
    let jet: [Jet<Interval>; 3] = std::array::from_fn(|a| Jet::coordinate(x[a], a));
    let jet = Jet::kernel(grid, jet.each_ref());
    (vec![interval, affine, reduced, slope.value, jet.value], slope, jet)
}

#[test]
fn every_enclosure_contains_samples() {
    for grid in grids() {
        for seed in 0..120 {
            let c = point(seed);
            // From a thousandth of a cell to many cells.
            let r = 10f64.powf(2.0 * random(seed + 5) - 1.7);
            let x: [Interval; 3] =
                std::array::from_fn(|a| Interval::around(c[a], r * uniform(mix(seed ^ a as u64))));
            let (values, slope, jet) = enclosures(&grid, &x);
            for i in 0..40 {
                let p: [f64; 3] = std::array::from_fn(|a| {
                    let t = uniform(mix(i * 3 + a as u64 + seed));
                    (x[a].lo + t * x[a].width()).clamp(x[a].lo, x[a].hi)
                });
                // The exact value, of which the computed one is a rounding.
                let (exact, _, exact_jet) = enclosures(&grid, &p.map(Interval::point));
                let meets = |a: Interval, b: Interval| a.lo <= b.hi && b.lo <= a.hi;
                assert!(values.iter().all(|e| meets(*e, exact[0])), "{values:?} {exact:?}");
                for a in 0..3 {
                    assert!(meets(slope.grad[a], exact_jet.grad[a]) && meets(jet.grad[a], exact_jet.grad[a]));
                }
                for k in 0..6 {
                    assert!(meets(jet.hess[k], exact_jet.hess[k]));
                }
            }
        }
    }
}

/// A clamped grid is what its outermost samples are, however far a box reaches.
#[test]
fn far_boxes_are_as_the_rim() {
    let frame = Frame::over([9; 3], [-1.0; 3], [1.0; 3], Edge::Clamp).unwrap();
    let ball = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z).sqrt() - 0.6;
    let grid = Grid::through(&Samples::of(frame, ball, &never).unwrap()).unwrap();
    let far = [Interval { lo: 1e9, hi: 16e9 }, Interval::radius(16e9), Interval::radius(16e9)];
    assert!(Interval::kernel(&grid, far.each_ref()).lo > 0.3);
    let across = [Interval::radius(0.1), Interval::radius(16e9), Interval::radius(0.1)];
    let range = Interval::kernel(&grid, across.each_ref());
    assert!(range.lo < -0.55 && range.hi > 0.39, "{range:?}");
}

#[test]
fn batches_equal_their_lanes() {
    for grid in grids() {
        let points: Vec<[f64; 3]> = (0..64).map(point).collect();
        let at: [Vec<f64>; 3] = std::array::from_fn(|axis| points.iter().map(|p| p[axis]).collect());
        let mut value = vec![0.0; 64];
        let mut grad = [vec![0.0; 64], vec![0.0; 64], vec![0.0; 64]];
        let mut hess: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; 64]);
        let out = Jets {
            value: &mut value,
            grad: Some(grad.each_mut().map(|g| &mut g[..])),
            hess: Some(hess.each_mut().map(|h| &mut h[..])),
        };
        grid.jets(at.each_ref().map(|a| &a[..]), out);
        let lanes: [Many<f64, 64>; 3] =
            std::array::from_fn(|axis| Many(std::array::from_fn(|i| points[i][axis])));
        let many = Many::kernel(&grid, lanes.each_ref());
        for (i, p) in points.iter().enumerate() {
            let one = grid.jet(Order::Hessian, *p);
            assert_eq!(one.value.to_bits(), value[i].to_bits());
            assert_eq!(one.value.to_bits(), many.0[i].to_bits());
            assert_eq!(one.value.to_bits(), grid.jet(Order::Value, *p).value.to_bits());
            assert_eq!(one.grad, grid.jet(Order::Gradient, *p).grad);
            assert!((0..3).all(|k| one.grad[k].to_bits() == grad[k][i].to_bits()));
            assert!((0..6).all(|k| one.hess[k].to_bits() == hess[k][i].to_bits()));
        }
    }
}

#[test]
fn strange_places_are_survived() {
    for grid in grids() {
        for v in
            [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, -1e300, 9e15, 1e17, 4.5e15, f64::MIN_POSITIVE]
        {
            for axis in 0..3 {
                let mut p = [0.25; 3];
                p[axis] = v;
                let value = grid.jet(Order::Hessian, p).value;
                assert!(value.abs() <= grid.bounds().range * (1.0 + 1e-9) || !v.is_finite());
                grid.local(Order::Hessian, p, 0.5);
                grid.local(Order::Hessian, [0.25; 3], v.abs());
            }
        }
    }
}

#[test]
fn equal_means_equal_data_in_equal_places() {
    let frame = frames()[0];
    let values: Vec<f64> = (0..frame.count() as u64).map(random).collect();
    let grid =
        |frame: Frame, values: &[f64]| Grid::through(&Samples { frame, values: values.to_vec() }).unwrap();
    assert_eq!(grid(frame, &values), grid(frame, &values));
    let mut other = values.clone();
    other[3] += 1e-9;
    assert_ne!(grid(frame, &values), grid(frame, &other));
    let moved = Frame { origin: [0.0; 3], ..frame };
    assert_ne!(grid(frame, &values), grid(moved, &values));
    let hash = |g: &Grid| {
        let mut h = std::collections::hash_map::DefaultHasher::new();
        g.hash(&mut h);
        h.finish()
    };
    assert_eq!(hash(&grid(frame, &values)), hash(&grid(frame, &values)));
}

#[test]
fn impossible_grids_are_refused() {
    let over = |size| Frame::over(size, [0.0; 3], [1.0; 3], Edge::Repeat);
    assert_eq!(over([0, 1, 1]), Err(Failure::Size([0, 1, 1])));
    assert_eq!(over([1 << 40, 1 << 40, 1]), Err(Failure::Size([1 << 40, 1 << 40, 1])));
    assert!(matches!(Frame::over([4; 3], [0.0; 3], [0.0; 3], Edge::Clamp), Err(Failure::Spacing(_))));
    assert!(matches!(Frame::over([4; 3], [f64::NAN; 3], [0.0; 3], Edge::Clamp), Err(Failure::Spacing(_))));
    let frame = over([4, 1, 4]).unwrap();
    let with = |v: f64| Grid::through(&Samples { frame, values: vec![v; 16] });
    assert!(matches!(with(f64::NAN), Err(Failure::Value { index: 0, .. })));
    assert!(matches!(with(1e200), Err(Failure::Value { .. })));
    let few = Grid::through(&Samples { frame, values: vec![1.0; 3] });
    assert_eq!(few, Err(Failure::Count { given: 3, wanted: 16 }));
}
