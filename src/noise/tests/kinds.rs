//! What kinds of noise owe, over the whole list with every choice and flag.

use super::fractals::recipe;
use super::octave::{Octave, Placement};
use super::*;

/// Every kind of noise as it is unless told otherwise, and with each of its choices and flags.
pub(super) fn kinds() -> Vec<(String, Kind)> {
    let mut all = Vec::new();
    for listing in Kind::ALL {
        all.push((listing.name.to_string(), listing.plain()));
        for parameter in listing.parameters {
            let others: Vec<Setting> = match parameter.allowed {
                Allowed::Choice(names) => names[1..].iter().map(|name| Setting::Name(name)).collect(),
                Allowed::Flag { default } => vec![Setting::Flag(!default)],
                _ => Vec::new(),
            };
            for other in others {
                let mut settings = Settings::new(listing.parameters);
                settings.set(parameter.name, other).unwrap();
                all.push((format!("{} {other:?}", listing.name), (listing.build)(&settings)));
            }
        }
    }
    all
}

#[test]
fn balls_together_are_as_balls_alone() {
    let mut random = Random::new(53);
    for (name, kind) in kinds() {
        for noise in lattices(kind, 6) {
            let noise = Noise { frequency: 1.7, ..noise };
            let turned = Octave { noise, placement: Some(Placement::random(5)) };
            let slope = Octave { noise: Noise { part: Part::Slope(1), ..noise }, ..turned };
            let points: [Vec<f64>; 3] = {
                // Alone, or next to others.
                let mut points: Vec<[f64; 3]> = (0..75).map(|_| random.point(40.0)).collect();
                for i in (0..75).filter(|i| i % 20 != 0) {
                    let (from, aside) = (points[i / 20 * 20], random.point(0.3));
                    if i / 20 < 3 {
                        points[i] = [0, 1, 2].map(|axis| from[axis] + aside[axis]);
                    }
                }
                [0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).collect())
            };
            let radius: Vec<f64> = (0..75).map(|i| [1e-9, 1e-4, 0.01, 0.05, 0.2, 1.0][i % 6]).collect();
            let at = points.each_ref().map(|x| &x[..]);
            let kernels: [&dyn Kernel; 3] = [&noise, &turned, &slope];
            for kernel in kernels.iter().take(if kind.class() >= Class::C1 { 3 } else { 2 }) {
                let mut together = vec![Local::UNKNOWN; 75];
                kernel.locals(Order::Gradient, at, &radius, &mut together);
                for (i, (own, error)) in together.iter().enumerate() {
                    let at = at.map(|x| x[i]);
                    let alone = kernel.local(Order::Gradient, at, radius[i]);
                    assert_eq!(format!("{own:?}"), format!("{alone:?}"), "{name} {at:?} {}", radius[i]);
                    assert_eq!(*error, kernel.error(largest(at)), "{name}");
                }
            }
        }
    }
}

/// Periods that a kind can have, and none.
fn periods(kind: Kind) -> Vec<[u32; 3]> {
    let all = [[0; 3], [1, 2, 3], [4, 4, 4], [6, 0, 3], [1 << 24, 12, 0]];
    all.into_iter().filter(|&p| kind.tiles(p).is_ok()).collect()
}

fn lattices(kind: Kind, seed: u64) -> impl Iterator<Item = Noise> {
    periods(kind)
        .into_iter()
        .map(move |period| Noise { lattice: Lattice { seed, period }, ..Noise::new(kind, 0) })
}

#[test]
fn derivatives_match_differences() {
    for (name, kind) in kinds().into_iter().filter(|(_, kind)| kind.class() >= Class::C1) {
        let (b, mut random) = (kind.bounds(), Random::new(1));
        for noise in lattices(kind, 20) {
            for _ in 0..1000 {
                let p = random.point(9.0);
                let jet = noise.jet(Order::Hessian, p);
                let h = 1e-5;
                // Of a central difference; a Hessian that jumps is no better than a slope.
                let smooth = kind.class() >= Class::C2;
                let error = noise.error(9.0);
                let within = [
                    if smooth { h * h * b.third } else { 2.0 * h * b.hessian } + error[0] / h,
                    if smooth { h * b.third } else { f64::INFINITY } + error[1] / h,
                ];
                for axis in 0..3 {
                    let side = |h: f64| {
                        let mut q = p;
                        q[axis] += h;
                        noise.jet(Order::Gradient, q)
                    };
                    let (low, high) = (side(-h), side(h));
                    let slope = (high.value - low.value) / (2.0 * h);
                    assert!((slope - jet.grad[axis]).abs() <= within[0], "{name} {p:?} {axis}");
                    for other in 0..3 {
                        let pair = [[0, 3, 4], [3, 1, 5], [4, 5, 2]][axis][other];
                        let slope = (high.grad[other] - low.grad[other]) / (2.0 * h);
                        assert!((slope - jet.hess[pair]).abs() <= within[1], "{name} {p:?} {axis} {other}");
                    }
                }
            }
        }
    }
}

#[test]
fn cells_meet_with_equal_jets() {
    for (name, kind) in kinds() {
        let (b, class, mut random) = (kind.bounds(), kind.class(), Random::new(2));
        for noise in lattices(kind, 21) {
            let error = noise.error(30.0);
            for i in 0..3000 {
                // On a plane of the lattice, or half way between two.
                let mut p = random.point(30.0);
                p[i % 3] = (2.0 * p[i % 3]).floor() / 2.0;
                let mut q = p;
                q[i % 3] -= 1e-13;
                let (a, b_) = (noise.jet(Order::Hessian, p), noise.jet(Order::Hessian, q));
                let jump = |order: usize, next: f64| 2.0 * error[order] + 2e-13 * next;
                if class >= Class::C0 {
                    assert!((a.value - b_.value).abs() <= jump(0, b.lipschitz), "{name} {p:?}");
                }
                if class >= Class::C1 {
                    let within = jump(1, b.hessian);
                    assert!((0..3).all(|k| (a.grad[k] - b_.grad[k]).abs() <= within), "{name} {p:?}");
                }
                if class >= Class::C2 {
                    let within = jump(2, b.third);
                    assert!((0..6).all(|k| (a.hess[k] - b_.hess[k]).abs() <= within), "{name} {p:?}");
                }
            }
        }
    }
}

/// Jets by bulk evaluation.
pub(in crate::noise) fn jets_of(noise: &Noise, order: Order, points: &[[f64; 3]]) -> Vec<Point> {
    let at = [0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).collect::<Vec<_>>());
    let mut to: [Vec<f64>; 10] = std::array::from_fn(|_| vec![0.0; points.len()]);
    let [v, x, y, z, xx, yy, zz, xy, xz, yz] = &mut to;
    let out = Jets {
        value: v,
        grad: (order >= Order::Gradient).then_some([&mut x[..], y, z]),
        hess: (order >= Order::Hessian).then_some([&mut xx[..], yy, zz, xy, xz, yz]),
    };
    noise.jets([&at[0], &at[1], &at[2]], out);
    (0..points.len())
        .map(|i| Point {
            value: to[0][i],
            grad: std::array::from_fn(|k| to[1 + k][i]),
            hess: std::array::from_fn(|k| to[4 + k][i]),
        })
        .collect()
}

#[test]
fn every_level_and_grouping_gives_the_same_bits() {
    let mut random = Random::new(4);
    let points: Vec<[f64; 3]> = (0..203)
        .map(|i| random.point([1.0, 1e3, 1e9, 1e17, 1e-9][i % 5]))
        .chain([[0.0, -0.0, -1e-300], [f64::NAN, 1.0, 2.0], [f64::INFINITY, 0.5, 0.5]])
        .collect();
    let bits = |p: &Point| {
        let all = std::iter::once(&p.value).chain(&p.grad).chain(&p.hess);
        // NaNs carry no promise about their payload.
        all.map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect::<Vec<_>>()
    };
    let all: Vec<(String, Noise)> = kinds()
        .into_iter()
        .flat_map(|(name, kind)| lattices(kind, 22).map(move |noise| (name.clone(), noise)))
        .collect();
    for order in [Order::Value, Order::Gradient, Order::Hessian] {
        for (name, noise) in &all {
            limit_simd(Level::Baseline);
            let single: Vec<_> = points.iter().map(|&p| bits(&noise.jet(order, p))).collect();
            // No other test may mind the level, which changes no bits.
            for level in [Level::Baseline, Level::Avx2, Level::Avx512] {
                limit_simd(level);
                for group in [1, 3, 16, 37, points.len()] {
                    let jets = points.chunks(group).flat_map(|part| jets_of(noise, order, part));
                    for ((jet, single), p) in jets.zip(&single).zip(&points) {
                        assert_eq!(&bits(&jet), single, "{name} {level:?} {group} {p:?}");
                    }
                }
                for (p, single) in points.iter().zip(&single) {
                    assert_eq!(&bits(&noise.jet(order, *p)), single, "{name} {level:?} {p:?}");
                }
            }
        }
    }
}

#[test]
fn enclosures_of_noises_contain_samples() {
    for (_, kind) in kinds() {
        let mut random = Random::new(8);
        for noise in lattices(kind, 23) {
            let noise = noise.at_frequency(1.5);
            let plain = Fractal::new(Recipe { noise, octaves: 1, ..recipe(Model::FBM, false) }).unwrap();
            for _ in 0..1000 {
                check_box(&plain, [false; 2], &mut random);
            }
        }
    }
}

/// Variances over space and seeds; all means are zero.
const VARIANCES: &[(&str, f64)] = &[
    ("gradient", 0.07292),
    ("gradient Name(\"sphere\")", 0.07292),
    ("value", 0.16036),
    ("value_gradient", 0.23328),
    ("value_gradient Name(\"sphere\")", 0.23328),
    ("simplex", 0.15401),
    ("simplex Name(\"sphere\")", 0.15098),
    ("cellular", 0.040534),
    ("waves", 1.0),
    ("weierstrass", 1.0),
];

#[test]
fn statistics_and_bounds_hold_over_a_million_samples() {
    for (name, kind) in kinds() {
        let mut random = Random::new(5);
        let (mut sum, mut squares) = (0.0, 0.0);
        let count = 1_000_000;
        let b = kind.bounds();
        for i in 0..count / 1000 {
            let size = [10.0, 1e4, 1e7][i % 3];
            let points: Vec<_> = (0..1000).map(|_| random.point(size)).collect();
            for jet in jets_of(&Noise::new(kind, i as u64), Order::Hessian, &points) {
                sum += jet.value;
                squares += jet.value * jet.value;
                assert!(jet.value.abs() <= b.range, "{name}");
                assert!(
                    jet.grad.iter().map(|g| g * g).sum::<f64>() <= b.lipschitz * b.lipschitz,
                    "{name}: {:?}",
                    jet.grad
                );
                // Diagonal entries are u^T H u on an axis; off-diagonal ones follow from polarisation.
                assert!(jet.hess.iter().all(|h| h.abs() <= b.hessian), "{name}: {:?}", jet.hess);
            }
        }
        let n = count as f64;
        if let Some((_, variance)) = VARIANCES.iter().find(|(n, _)| *n == name) {
            assert!((sum / n).abs() < 6.0 * (variance / n).sqrt(), "{name}: mean {}", sum / n);
            let found = squares / n;
            assert!((found / variance - 1.0).abs() < 0.01, "{name}: variance {found}, not {variance}");
        }
    }
}

/// Correlation of two samples.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (a, b) = pairs.iter().fold((0.0, 0.0), |(a, b), p| (a + p.0 / n, b + p.1 / n));
    let [aa, bb, ab] = pairs.iter().fold([0.0; 3], |[aa, bb, ab], p| {
        let (x, y) = (p.0 - a, p.1 - b);
        [aa + x * x, bb + y * y, ab + x * y]
    });
    ab / (aa * bb).sqrt()
}

/// Whether a kind has the same few waves for all seeds: such sums agree at any distance, and a whole
/// lacunarity makes them repeat without being told to, up to the rounding of their phases.
fn is_nearly_periodic(kind: Kind) -> bool {
    matches!(kind, Kind::Weierstrass(_))
}

#[test]
fn distant_places_and_different_seeds_are_uncorrelated() {
    let n = 20_000;
    // Five deviations of the correlation of independent samples.
    let chance = 5.0 / (n as f64).sqrt();
    for (name, kind) in kinds().into_iter().filter(|(_, kind)| !is_nearly_periodic(*kind)) {
        let mut random = Random::new(9);
        let at = |seed: u64, p: [f64; 3]| Noise::new(kind, seed).jet(Order::Value, p).value;
        let steps = [
            [3.0, 0.0, 0.0],
            [0.0, 3.0, 0.0],
            [0.0, 0.0, 3.0],
            [3.0, -4.0, 5.0],
            [256.0, 0.0, 0.0],
            [0.5, 64.5, 0.5],
        ];
        for step in steps {
            let pairs: Vec<_> = (0..n)
                .map(|i| {
                    let p = random.point(1e4);
                    (at(i, p), at(i, [0, 1, 2].map(|k| p[k] + step[k])))
                })
                .collect();
            assert!(correlation(&pairs).abs() < chance, "{name} {step:?}");
        }
        for (a, b) in [(0, 1), (1, 2), (7, 7 << 32), (0, u64::MAX), (5, !5)] {
            let pairs: Vec<_> = (0..n)
                .map(|_| {
                    let p = random.point(1e4);
                    (at(a, p), at(b, p))
                })
                .collect();
            assert!(correlation(&pairs).abs() < chance, "{name} seeds {a} {b}");
        }
    }
}

#[test]
fn noises_repeat_after_their_period() {
    for (name, kind) in kinds() {
        let (b, mut random) = (kind.bounds(), Random::new(10));
        for noise in lattices(kind, 24).filter(|n| n.lattice.period != [0; 3]) {
            let period = noise.lattice.period.map(f64::from);
            for i in 0..2000 {
                let times = random.point(5.0).map(f64::round);
                let p = random.point(50.0);
                // Short coordinates, for which the sum is exact, and any.
                let p = if i % 2 == 0 { p.map(|x| (x * 1024.0).round() / 1024.0) } else { p };
                let q = [0, 1, 2].map(|k| p[k] + times[k] * period[k]);
                let (at, image) = (noise.jet(Order::Hessian, p), noise.jet(Order::Hessian, q));
                let exact = (0..3).all(|k| q[k] - times[k] * period[k] == p[k]) && i % 2 == 0;
                let exact = exact && !is_nearly_periodic(kind);
                let near = 1e-15 * q.iter().fold(100.0, |m: f64, x| m.max(x.abs()));
                if exact {
                    assert_eq!(at, image, "{name} {period:?} {p:?} {q:?}");
                } else if kind.class() >= Class::C0 {
                    let within = 2.0 * noise.error(0.0)[0] + 2.0 * near * b.lipschitz;
                    assert!((at.value - image.value).abs() <= within, "{name} {period:?} {p:?} {q:?}");
                }
            }
            // And not sooner.
            let later = (0..100).filter(|_| {
                let p = random.point(50.0);
                let differs = |axis: usize| {
                    let mut q = p;
                    q[axis] += if period[axis] == 0.0 { 4096.0 } else { (period[axis] - 1.0).max(1.0) };
                    period[axis] == 1.0
                        || (noise.jet(Order::Value, q).value - noise.jet(Order::Value, p).value).abs() > 1e-9
                };
                (0..3).all(differs)
            });
            assert!(is_nearly_periodic(kind) || later.count() > 80, "{name} {period:?}");
        }
    }
}

#[test]
fn total_for_any_coordinate() {
    for (name, kind) in kinds() {
        let b = kind.bounds();
        for noise in lattices(kind, 25) {
            for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                for axis in 0..3 {
                    let mut p = [0.3, 0.1, 0.4];
                    p[axis] = x;
                    assert!(noise.jet(Order::Value, p).value.is_nan(), "{name} {p:?}");
                }
            }
            let mut random = Random::new(6);
            for _ in 0..3000 {
                let p = random.point(1.0).map(|x| x * 10_f64.powi((random.unit() * 300.0) as i32));
                assert!(noise.jet(Order::Value, p).value.abs() <= b.range, "{name} {p:?}");
            }
            let far = [2e9 + 0.25, -2e9 + 0.5, 1e7 + 0.75];
            if kind.class() >= Class::C1 {
                let jet = noise.jet(Order::Gradient, far);
                let next = noise.jet(Order::Value, [far[0] + 1e-3, far[1], far[2]]);
                let slope = (next.value - jet.value) / 1e-3;
                assert!((slope - jet.grad[0]).abs() < 1e-3 * b.hessian, "{name}");
            }
        }
    }
}

#[test]
fn slopes_are_derivatives_with_bounds() {
    let mut random = Random::new(15);
    for (_, kind) in kinds().into_iter().filter(|(_, k)| k.class() >= Class::C1) {
        let noise = Noise::new(kind, 21).at_frequency(2.5);
        for axis in 0..3 {
            let slope = noise.slope(axis);
            let bounds = slope.bounds();
            assert!(slope.class() < noise.class());
            for _ in 0..300 {
                let p = random.point(20.0);
                let (of, own) = (noise.jet(Order::Hessian, p), slope.jet(Order::Hessian, p));
                assert_eq!(own.value, of.grad[usize::from(axis)]);
                assert!(own.value.abs() <= bounds.range);
                assert!(own.grad.iter().map(|g| g * g).sum::<f64>().sqrt() <= bounds.lipschitz);
                assert!(own.hess.iter().all(|h| h.abs() <= bounds.hessian * 1.01));
            }
        }
    }
    // The slopes of a sum of turned octaves make up its gradient.
    let fbm = recipe(Model::FBM, true);
    let slopes =
        [0, 1, 2].map(|axis| Fractal::new(Recipe { noise: fbm.noise.slope(axis), ..fbm.clone() }).unwrap());
    let f = Fractal::new(fbm).unwrap();
    for _ in 0..200 {
        let p = random.point(4.0);
        let d = [0, 1, 2].map(|i| Dual::coordinate(p[i], i));
        let gradient = f.eval([&d[0], &d[1], &d[2]], None).grad;
        for (slope, g) in slopes.iter().zip(gradient) {
            assert!((slope.eval([&p[0], &p[1], &p[2]], None) - g).abs() < 1e-10);
        }
    }
}
