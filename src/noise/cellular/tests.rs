//! Cellular noise against plain searches, exact means, and samples of balls.

use super::*;
use crate::noise::tests::Random;
use crate::noise::{Kind, Noise, Setting};
use crate::num::{Affine, Interval, Jet, Kernel, Level, Number, Reduced, Slope, Symbol, limit_simd};

const NORMS: [(&str, f64); 6] = [
    ("euclidean", 0.0),
    ("manhattan", 0.0),
    ("chebyshev", 0.0),
    ("minkowski", 1.5),
    ("minkowski", 4.0),
    ("minkowski", 17.0),
];

fn cellular(weights: [f64; 4], (norm, power): (&'static str, f64), squared: bool, centred: bool) -> Cellular {
    let mut settings = Settings::new(Cellular::PARAMETERS);
    settings.set("weights", Setting::Numbers(weights)).unwrap();
    settings.set("norm", Setting::Name(norm)).unwrap();
    if power > 0.0 {
        settings.set("power", Setting::Number(power)).unwrap();
    }
    settings.set("squared", Setting::Flag(squared)).unwrap();
    settings.set("centred", Setting::Flag(centred)).unwrap();
    Cellular::new(&settings)
}

/// Every norm, plain and squared, with weights that leave out, take away and repeat orders, and without any.
fn variants() -> impl Iterator<Item = Cellular> {
    const WEIGHTS: [[f64; 4]; 6] = [
        [0.0; 4],
        [1.0, 0.0, 0.0, 0.0],
        [-1.0, 1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0],
        [0.5, -0.25, 0.0, 1.5],
        [0.0, 0.0, 1.0, 0.0],
    ];
    NORMS.into_iter().flat_map(|norm| {
        WEIGHTS.into_iter().flat_map(move |w| [false, true].map(|squared| cellular(w, norm, squared, true)))
    })
}

fn noise(cellular: Cellular) -> Noise {
    Noise::new(Kind::Cellular(cellular), 11)
}

fn length(g: [f64; 3]) -> f64 {
    g.iter().map(|g| g * g).sum::<f64>().sqrt()
}

/// Distances to all nodes around, found the slow way.
fn all_distances<M: Metric>(metric: M, lattice: &Lattice, at: [f64; 3]) -> Vec<f64> {
    let cells = cells(metric, 3.0);
    let search = Search { metric, cells: &cells, lattice, cap: 3.0 };
    let mut all = Vec::new();
    search.within(at, 3.0, |d| all.push(metric.distance(metric.measure(d, f64::INFINITY))));
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn every_order_is_exact() {
    let mut random = Random::new(1);
    for i in 0..3000 {
        let lattice = Lattice { seed: 5, period: if i % 2 == 0 { [0; 3] } else { [5, 0, 3] } };
        let p = random.point(20.0);
        let check = |norm: &str, all: Vec<f64>| {
            for l in 0..4 {
                let mut weights = [0.0; 4];
                weights[l] = 1.0;
                let norm = NORMS[NORMS.iter().position(|n| n.0 == norm).unwrap()];
                let f = cellular(weights, norm, false, false).jet(&lattice, Order::Value, p).value;
                assert_eq!(f, all[l], "{norm:?} {l} {p:?}");
            }
        };
        check("euclidean", all_distances(Euclidean, &lattice, p));
        check("manhattan", all_distances(Manhattan, &lattice, p));
        check("chebyshev", all_distances(Chebyshev, &lattice, p));
    }
}

#[test]
fn means_are_those_of_a_poisson_process() {
    // Exact means of the Euclidean norm: noise specification of the seed, and of F_1 squared.
    for (l, mean) in [0.55396, 0.73861, 0.86172, 0.95746].into_iter().enumerate() {
        assert!((Norm::Euclidean.mean(l + 1, false) - mean).abs() < 1e-5);
    }
    for (l, mean) in [0.81133, 1.08177, 1.26206, 1.40229].into_iter().enumerate() {
        assert!((Norm::Manhattan.mean(l + 1, false) - mean).abs() < 1e-5);
    }
    for (l, mean) in [0.44649, 0.59532, 0.69454, 0.77171].into_iter().enumerate() {
        assert!((Norm::Chebyshev.mean(l + 1, false) - mean).abs() < 1e-5);
    }
    let mut random = Random::new(2);
    for norm in NORMS {
        for (l, squared) in [(0, false), (1, false), (2, false), (3, false), (0, true), (3, true)] {
            let mut weights = [0.0; 4];
            weights[l] = 1.0;
            let (own, plain) =
                (noise(cellular(weights, norm, squared, true)), cellular(weights, norm, squared, false));
            // Enough that a hundredth is four deviations of the mean and more.
            let count = 100_000;
            let at = [0, 1, 2].map(|_| (0..count).map(|_| 1e4 * random.unit()).collect::<Vec<_>>());
            let mut value = vec![0.0; count];
            own.jets([&at[0], &at[1], &at[2]], Jets { value: &mut value, grad: None, hess: None });
            let (n, exact) = (count as f64, plain.norm.mean(l + 1, squared));
            let mean = value.iter().sum::<f64>() / n;
            let variance = value.iter().map(|v| v * v).sum::<f64>() / n - mean * mean;
            assert!(mean.abs() < 0.01 * exact, "{norm:?} {l} {squared}: {mean} against {exact}");
            if norm.0 == "euclidean" && !squared {
                let deviation = [0.20133, 0.18293, 0.17165, 0.16384][l];
                assert!((variance.sqrt() / deviation - 1.0).abs() < 0.01, "{l}: {}", variance.sqrt());
            }
        }
    }
}

#[test]
fn nodes_are_spread_evenly() {
    // Counts in unit cells: Poisson with mean and variance 1; places: uniform on each axis.
    let lattice = Lattice::new(3);
    let table = cells(Chebyshev, 2.0);
    let search = Search { metric: Chebyshev, cells: &table, lattice: &lattice, cap: 2.0 };
    let (mut counts, mut sums, mut squares) = ([0_u32; 16], [0.0; 3], [0.0; 3]);
    let cells = 40_000;
    for i in 0..cells {
        let centre = [i % 40 - 20, i / 40 % 40 - 20, i / 1600].map(|n| f64::from(n) + 0.5);
        let mut count = 0;
        search.within(centre, 0.5, |d| {
            if d.iter().all(|d| d.abs() < 0.5) {
                count += 1;
                (0..3).for_each(|k| sums[k] += d[k]);
                (0..3).for_each(|k| squares[k] += d[k] * d[k]);
            }
        });
        counts[count] += 1;
    }
    let n = f64::from(cells);
    for (k, share) in [0.367_879, 0.367_879, 0.183_940, 0.061_313, 0.015_328].into_iter().enumerate() {
        assert!((f64::from(counts[k]) / n - share).abs() < 4.0 * (share / n).sqrt(), "{k} {counts:?}");
    }
    for k in 0..3 {
        assert!((sums[k] / n).abs() < 4.0 * (1.0 / 12.0 / n).sqrt(), "{sums:?}");
        assert!((squares[k] / n - 1.0 / 12.0).abs() < 0.002, "{squares:?}");
    }
}

#[test]
fn derivatives_match_differences() {
    let mut random = Random::new(3);
    for variant in variants() {
        let noise = noise(variant);
        let (mut gradients, mut hessians) = (0, 0);
        for _ in 0..200 {
            let p = random.point(30.0);
            let jet = noise.jet(Order::Hessian, p);
            let h = 1e-5;
            // Away from creases and facets.
            let around = noise.local(Order::Gradient, p, 4.0 * h);
            if !around.bounds.hessian.is_finite() {
                continue;
            }
            gradients += 1;
            for axis in 0..3 {
                let side = |s: f64| {
                    let mut q = p;
                    q[axis] += s;
                    noise.jet(Order::Gradient, q)
                };
                let (low, high) = (side(-h), side(h));
                let slope = (high.value - low.value) / (2.0 * h);
                assert!(
                    (slope - jet.grad[axis]).abs() < 1e-6 * (1.0 + around.bounds.hessian),
                    "{variant:?} {p:?}"
                );
                if around.bounds.hessian > 100.0 {
                    continue;
                }
                hessians += 1;
                for other in 0..3 {
                    let pair = [[0, 3, 4], [3, 1, 5], [4, 5, 2]][axis][other];
                    let slope = (high.grad[other] - low.grad[other]) / (2.0 * h);
                    assert!(
                        (slope - jet.hess[pair]).abs() < 1e-3 * (1.0 + around.bounds.hessian),
                        "{variant:?} {p:?} {slope} {jet:?}"
                    );
                }
            }
        }
        assert!(gradients > 100 && hessians > 50, "{variant:?}: {gradients} {hessians}");
    }
}

#[test]
fn continuous_along_segments_within_the_lipschitz_bound() {
    let mut random = Random::new(4);
    for variant in variants() {
        let (noise, bound) = (noise(variant), variant.bounds().lipschitz);
        for _ in 0..4 {
            let (p, q) = (random.point(8.0), random.point(1.0));
            let unit = q.map(|x| x / length(q));
            let (mut last, step) = (noise.jet(Order::Value, p).value, 1e-4);
            for i in 1..2000 {
                let at = [0, 1, 2].map(|k| p[k] + f64::from(i) * step * unit[k]);
                let next = noise.jet(Order::Value, at).value;
                assert!((next - last).abs() <= bound * step + 1e-12, "{variant:?} {at:?}");
                last = next;
            }
        }
    }
}

#[test]
fn bounds_hold_over_a_million_samples() {
    let mut random = Random::new(5);
    for variant in variants() {
        let (noise, bounds) = (noise(variant), variant.bounds());
        let count = if matches!(variant.norm, Norm::Minkowski(_)) { 4_000 } else { 33_000 };
        let at = [0, 1, 2].map(|_| (0..count).map(|_| 1e5 * random.unit()).collect::<Vec<_>>());
        let mut to: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; count]);
        let [value, x, y, z] = &mut to;
        noise.jets([&at[0], &at[1], &at[2]], Jets { value, grad: Some([x, y, z]), hess: None });
        for i in 0..count {
            assert!(to[0][i].abs() <= bounds.range);
            assert!(length([to[1][i], to[2][i], to[3][i]]) <= bounds.lipschitz, "{variant:?}");
        }
    }
}

#[test]
fn batches_equal_single_points_at_every_level() {
    let mut random = Random::new(6);
    let points: Vec<[f64; 3]> = (0..101)
        .map(|i| random.point([1.0, 1e3, 1e9, 1e17, 1e-9][i % 5]))
        .chain([[0.0, -0.0, -1e-300], [0.5, 0.25, -0.5], [f64::NAN, 1.0, 2.0], [f64::INFINITY, 0.5, 0.5]])
        .collect();
    // No other test may mind the level, which changes no bits.
    let mut levels = [Level::Baseline, Level::Avx2, Level::Avx512].into_iter().cycle();
    for variant in variants() {
        for period in [[0; 3], [3, 1, 0]] {
            let lattice = Lattice { seed: 9, period };
            for group in [1, 7, 16, points.len()] {
                for part in points.chunks(group) {
                    limit_simd(levels.next().unwrap());
                    batches_are_like_points(&variant, &lattice, part);
                }
            }
        }
    }
}

/// That the jets of a batch are those of its points, bit for bit.
fn batches_are_like_points(noise: &Cellular, lattice: &Lattice, points: &[[f64; 3]]) {
    let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
    let at = [0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).collect::<Vec<_>>());
    let mut to: [Vec<f64>; 10] = std::array::from_fn(|_| vec![0.0; points.len()]);
    let [value, x, y, z, xx, yy, zz, xy, xz, yz] = &mut to;
    let out = Jets { value, grad: Some([x, y, z]), hess: Some([xx, yy, zz, xy, xz, yz]) };
    noise.jets(lattice, [&at[0], &at[1], &at[2]], out);
    for (i, p) in points.iter().enumerate() {
        let one = noise.jet(lattice, Order::Hessian, *p);
        let all = [one.value].into_iter().chain(one.grad).chain(one.hess);
        for (k, x) in all.enumerate() {
            assert_eq!(bits(x), bits(to[k][i]), "{noise:?} {p:?} {k}");
        }
        let value = noise.jet(lattice, Order::Value, *p).value;
        assert_eq!(bits(value), bits(one.value));
    }
}

/// As along trajectories: most points stay in their plot for a while, some leave it, some are nowhere; noises take turns, and
/// there are more of them than are remembered.
#[test]
fn points_that_stay_have_the_same_bits() {
    let mut random = Random::new(17);
    let noises = [false, true].map(|squared| cellular([1.0, 0.0, 0.0, 0.0], NORMS[0], squared, true));
    let lattices: Vec<Lattice> =
        (0..11).map(|seed| Lattice { seed, period: [[0; 3], [3, 0, 1]][seed as usize % 2] }).collect();
    for (round, level) in
        [Level::Baseline, Level::Avx2, Level::Avx512].into_iter().cycle().take(90).enumerate()
    {
        limit_simd(level);
        let count = [16, 64, 100, 23][round % 4];
        let mut points: Vec<[f64; 3]> = (0..count).map(|_| random.point(8.0)).collect();
        let alike = &lattices[..[1, 3, 11][round % 3]];
        for step in 0..12 {
            for point in &mut points {
                let pace = if random.unit() < 0.02 { 2.0 } else { 0.03 };
                let by = random.point(pace);
                (0..3).for_each(|axis| point[axis] += by[axis]);
            }
            // On the borders of plots, and beyond all that is.
            points[step] = [0.5, -1.0, points[step][2]];
            points[15 - step] = if step < 2 { [f64::NAN, 0.0, f64::INFINITY] } else { random.point(1e13) };
            for lattice in alike {
                batches_are_like_points(&noises[step % 2], lattice, &points);
            }
        }
    }
}

#[test]
fn tiles_after_any_period() {
    let mut random = Random::new(7);
    for variant in variants().step_by(7) {
        for period in [[1, 2, 3], [4, 0, 7], [0, 0, 1]] {
            let lattice = Lattice { seed: 1, period };
            for _ in 0..50 {
                // Multiples of a small power of 2, so that the shifted point is exact.
                let p = random.point(10.0).map(|x| (x * 4096.0).round() / 4096.0);
                let q = [0, 1, 2].map(|i| p[i] + f64::from(period[i]));
                let at = |p| variant.jet(&lattice, Order::Gradient, p);
                assert_eq!(at(p).value, at(q).value, "{variant:?} {period:?} {p:?}");
            }
        }
    }
}

#[test]
fn total_for_any_coordinate() {
    let noise = noise(cellular([1.0, 0.0, 0.0, 0.0], NORMS[0], false, true));
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(noise.jet(Order::Value, [0.3, x, 0.4]).value.is_nan());
    }
    let mut random = Random::new(8);
    for _ in 0..1000 {
        let p = random.point(1.0).map(|x| x * 10_f64.powi((random.unit() * 300.0) as i32));
        assert!(noise.jet(Order::Gradient, p).value.abs() <= noise.bounds().range, "{p:?}");
    }
}

/// A random box: any size, often with corners on lattice planes.
fn random_box(random: &mut Random) -> ([f64; 3], [f64; 3]) {
    let size = 10_f64.powf(random.unit() * 6.5 - 6.0);
    let mut centre = random.point(4.0);
    let radius = random.point(size).map(f64::abs);
    if random.unit() < 0.2 {
        centre = centre.map(f64::round);
    } else if random.unit() < 0.3 {
        centre = [0, 1, 2].map(|axis| centre[axis].round() / 1.5 + radius[axis]);
    }
    (centre, radius)
}

#[test]
fn enclosures_contain_samples() {
    let mut random = Random::new(9);
    for variant in variants() {
        let noise = Noise { frequency: 1.5, ..noise(variant) };
        for _ in 0..120 {
            let (c, r) = random_box(&mut random);
            let [x, y, z] = [0, 1, 2].map(|i| Interval::around(c[i], r[i]));
            let interval = Interval::kernel(&noise, [&x, &y, &z]);
            let [x, y, z] = [x, y, z].map(|x| x);
            let s = [0, 1, 2].map(|i| Slope::coordinate([x, y, z][i], i));
            let slope = Slope::kernel(&noise, [&s[0], &s[1], &s[2]]);
            let j = [0, 1, 2].map(|i| Jet::coordinate([x, y, z][i], i));
            let jet = Jet::<Interval>::kernel(&noise, [&j[0], &j[1], &j[2]]);
            let a = [0, 1, 2].map(|i| Affine::new(c[i], r[i], Symbol::fresh()));
            let affine = Affine::kernel(&noise, [&a[0], &a[1], &a[2]]);
            let m = [0, 1, 2].map(|i| {
                let mut slope = [0.0; 3];
                slope[i] = r[i];
                Reduced::<3>::new(c[i], slope)
            });
            let cell = Reduced::kernel(&noise, [&m[0], &m[1], &m[2]]);
            let l = [0, 1, 2].map(|i| Reduced::<1>::new(c[i], [r[i]]));
            let line = Reduced::kernel(&noise, [&l[0], &l[1], &l[2]]);
            for n in 0..20 {
                let e = match n {
                    0..8 => [n & 1, n >> 1 & 1, n >> 2].map(|b| if b == 0 { -1.0 } else { 1.0 }),
                    _ => random.point(1.0),
                };
                let p = [0, 1, 2].map(|i| c[i] + e[i] * r[i]);
                let exact = noise.jet(Order::Hessian, p);
                let slack = 1e-12;
                for (name, range) in
                    [interval, slope.value, jet.value, affine.range, cell.range].into_iter().enumerate()
                {
                    let fine = range.lo - slack <= exact.value && exact.value <= range.hi + slack;
                    assert!(fine, "{name} {variant:?} {c:?} {r:?} {p:?}: {} in {range:?}", exact.value);
                }
                let form = cell.mid + (0..3).map(|k| cell.slope[k] * e[k]).sum::<f64>();
                assert!((exact.value - form).abs() <= cell.rest + slack, "{variant:?} {c:?} {r:?}");
                assert!(length(exact.grad) <= slope.norm * (1.0 + 1e-9), "{variant:?} {c:?} {r:?}");
                for k in 0..3 {
                    let fine = |g: Interval| g.lo - 1e-9 <= exact.grad[k] && exact.grad[k] <= g.hi + 1e-9;
                    assert!(fine(slope.grad[k]) && fine(jet.grad[k]), "{variant:?} {c:?} {r:?}");
                }
                for k in 0..6 {
                    let h = jet.hess[k];
                    assert!(
                        h.lo - 1e-6 <= exact.hess[k] && exact.hess[k] <= h.hi + 1e-6,
                        "{variant:?} {c:?} {r:?}"
                    );
                }
                let t = e[0];
                let q = [0, 1, 2].map(|i| c[i] + t * r[i]);
                let value = noise.jet(Order::Value, q).value;
                assert!((value - line.mid - line.slope[0] * t).abs() <= line.rest + slack, "{variant:?}");
                assert!(line.range.lo - slack <= value && value <= line.range.hi + slack);
            }
        }
    }
}

#[test]
fn affine_forms_are_sharp_to_second_order_away_from_creases() {
    let mut random = Random::new(10);
    // Nodes of equal weight that change places leave no crease, but are bounded one by one.
    for variant in variants().filter(|v| v.weights[0] != v.weights[1]) {
        let noise = noise(variant);
        let rest = |p: [f64; 3], r: f64| {
            let p = p.map(|c| Reduced::<1>::new(c, [r]));
            Reduced::kernel(&noise, [&p[0], &p[1], &p[2]]).rest
        };
        let facets = matches!(variant.norm, Norm::Manhattan | Norm::Chebyshev) && !variant.squared;
        let mut seen = 0;
        for _ in 0..100 {
            let p = random.point(10.0);
            // Far enough from creases for curvature to vary little.
            let bounds = noise.local(Order::Gradient, p, 2e-2).bounds;
            if bounds.hessian > 200.0 {
                continue;
            }
            seen += 1;
            let (wide, narrow) = (rest(p, 2e-3), rest(p, 1e-3));
            if facets {
                assert!(wide < 1e-11, "{variant:?} {p:?} {wide}");
            } else {
                assert!(
                    wide < 200.0 * 6e-6 && (3.2..5.0).contains(&(wide / narrow)),
                    "{variant:?} {p:?} {wide} {narrow}"
                );
            }
        }
        assert!(seen > 10, "{variant:?} {seen}");
    }
}

#[test]
fn rounding_is_as_stated() {
    // A second way of computing the same distance, from offsets that are exact in integers: places
    // are multiples of 2^-11 and so are these points.
    let mut random = Random::new(12);
    let lattice = Lattice::new(8);
    let variant = cellular([1.0, 0.0, 0.0, 0.0], NORMS[0], false, false);
    let table = cells(Euclidean, 2.0);
    let search = Search { metric: Euclidean, cells: &table, lattice: &lattice, cap: 2.0 };
    for _ in 0..2000 {
        let p = random.point(100.0).map(|x| (x * 2048.0).round() / 2048.0);
        let mut least = u64::MAX;
        search.within(p, 2.0, |d| {
            let square: u64 = d.iter().map(|d| ((d * 2048.0) as i64).unsigned_abs().pow(2)).sum();
            least = least.min(square);
        });
        // The integer is below 2^53, and its root correctly rounded.
        let exact = (least as f64).sqrt() / 2048.0;
        let off = (variant.jet(&lattice, Order::Value, p).value - exact).abs();
        assert!(off <= variant.rounding()[0], "{off:e}");
    }
}

#[test]
fn near_nodes_gradients_turn_no_more_than_balls_say() {
    let mut random = Random::new(13);
    let variant = cellular([1.0, 0.0, 0.0, 0.0], NORMS[0], false, false);
    let noise = noise(variant);
    let table = cells(Euclidean, 2.0);
    let search = Search { metric: Euclidean, cells: &table, lattice: &noise.lattice, cap: 2.0 };
    let mut needed: f64 = 0.0;
    for _ in 0..3000 {
        // Below zero fractions are rounded.
        let p = random.point(1.0).map(|x| -x.abs());
        let found: Found<1, 1> = search.nearest(p);
        // Nodes are multiples of 2^-11, so that the difference is exact.
        let node = [0, 1, 2].map(|a| ((p[a] - found.offset[0][a][0]) * 2048.0).round() / 2048.0);
        let p = [0, 1, 2].map(|a| node[a] + 1e-6 * (random.unit() - 0.5));
        let d = [0, 1, 2].map(|a| p[a] - node[a]);
        for radius in [1e-18, 1e-16, 1e-14] {
            let local = noise.local(Order::Gradient, p, radius);
            let end = d.map(|d| d + 1.1 * radius * (random.unit() - 0.5));
            let turn = length([0, 1, 2].map(|a| local.jet.grad[a] - end[a] / length(end)));
            assert!(turn <= local.bounds.hessian * radius + variant.rounding()[1], "{p:?} {radius} {turn:e}");
            needed = needed.max(turn - radius / length(d) - variant.rounding()[1]);
        }
    }
    // Without the rounding of offsets in the radius, some would.
    assert!(needed > 1e-11, "{needed:e}");
}
