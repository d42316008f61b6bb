//! What every noise and fractal owes: enclosures that enclose, batches that equal their lanes.

use super::*;
use crate::num::{
    Affine, Centred, Dual, Interval, Jet, Level, Many, Number, Reduced, Slope, Symbol, limit_simd, mix,
};

/// A small generator with a fixed start, so that every run tests the same.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Random(seed)
    }

    pub(super) fn unit(&mut self) -> f64 {
        self.0 += 1;
        (mix(self.0.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn point(&mut self, size: f64) -> [f64; 3] {
        [0, 1, 2].map(|_| (2.0 * self.unit() - 1.0) * size)
    }
}

fn recipe(model: Model, rotate: bool) -> Recipe {
    Recipe {
        noise: Noise::new(Kind::Gradient(Gradient::EDGES), 3).at_frequency(1.5),
        model,
        octaves: 6,
        lacunarity: 2.07,
        hurst: 0.8,
        offset: 0.6,
        rotate,
    }
}

fn fractals() -> impl Iterator<Item = Fractal> {
    let both = [false, true];
    Model::ALL.iter().flat_map(move |&m| both.map(|rotate| Fractal::new(recipe(m, rotate)).unwrap()))
}

/// A random box: any size, often with corners on lattice planes. Returned as centre and radii.
fn random_box(random: &mut Random) -> ([f64; 3], [f64; 3]) {
    let size = 10_f64.powf(random.unit() * 7.0 - 6.0);
    let mut centre = random.point(4.0);
    let radius = random.point(size).map(f64::abs);
    let kind = random.unit();
    if kind < 0.2 {
        centre = centre.map(f64::round);
    } else if kind < 0.4 {
        centre = [0, 1, 2].map(|axis| centre[axis].round() / 1.5 + radius[axis]);
    }
    (centre, radius)
}

fn within(i: Interval, x: f64, slack: f64) -> bool {
    i.lo - slack <= x && x <= i.hi + slack
}

/// Checks all enclosures of `f` over a box against samples.
fn check_box(f: &Fractal, footprint: bool, random: &mut Random) {
    let (c, r) = random_box(random);
    // A footprint that varies over the box and meets all parts of the fade.
    let (base, rate) = (10_f64.powf(random.unit() * 3.0 - 3.0), if random.unit() < 0.5 { 0.0 } else { 0.05 });
    fn eval<T: Number>(f: &Fractal, p: [&T; 3], print: Option<(f64, f64)>) -> T {
        let s = print.map(|(base, rate)| p[0].scale(rate).shift(base));
        f.eval(p, s.as_ref())
    }
    let print = footprint.then_some((base, rate));
    let boxes = [0, 1, 2].map(|i| Interval::around(c[i], r[i]));
    let [x, y, z] = boxes;
    let interval = eval(f, [&x, &y, &z], print);
    let s = [0, 1, 2].map(|i| Slope::coordinate(boxes[i], i));
    let slope = eval(f, [&s[0], &s[1], &s[2]], print);
    let j = [0, 1, 2].map(|i| Jet::coordinate(boxes[i], i));
    let jet = eval(f, [&j[0], &j[1], &j[2]], print);
    let a = [0, 1, 2].map(|i| Affine::new(c[i], r[i], Symbol::fresh()));
    let affine = eval(f, [&a[0], &a[1], &a[2]], print);
    let m = [0, 1, 2].map(|i| {
        let mut slope = [0.0; 3];
        slope[i] = r[i];
        Reduced::<3>::new(c[i], slope)
    });
    let cell = eval(f, [&m[0], &m[1], &m[2]], print);
    let l = [0, 1, 2].map(|i| Reduced::<1>::new(c[i], [r[i]]));
    let line = eval(f, [&l[0], &l[1], &l[2]], print);

    for n in 0..24 {
        // Corners and diagonals as well as the inside.
        let e = match n {
            0..8 => [n & 1, n >> 1 & 1, n >> 2].map(|b| if b == 0 { -1.0 } else { 1.0 }),
            8 => [0.0; 3],
            _ => random.point(1.0),
        };
        let p = [0, 1, 2].map(|i| c[i] + e[i] * r[i]);
        let d = [0, 1, 2].map(|i| Jet::coordinate(p[i], i));
        let exact: Jet = eval(f, [&d[0], &d[1], &d[2]], print);
        let v = exact.value;
        // The reference itself is rounded, and `p` may leave the box by a roundoff.
        let slack = 1e-12;
        let names = ["interval", "slope", "jet", "affine", "cell"];
        for (name, range) in
            names.into_iter().zip([interval, slope.value, jet.value, affine.range, cell.range])
        {
            assert!(within(range, v, slack), "{name} {:?} {c:?} {r:?} {p:?}: {v} in {range:?}", f.recipe());
        }
        let form = cell.mid + (0..3).map(|k| cell.slope[k] * e[k]).sum::<f64>();
        assert!((v - form).abs() <= cell.rest + slack, "cell form {:?} {c:?} {r:?}", f.recipe());
        let size = exact.grad.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!(size <= slope.norm * (1.0 + 1e-9) + 1e-9, "norm {:?} {c:?} {r:?}", f.recipe());
        for k in 0..3 {
            assert!(within(slope.grad[k], exact.grad[k], 1e-9), "slope {:?} {c:?} {r:?}", f.recipe());
            assert!(within(jet.grad[k], exact.grad[k], 1e-9), "jet {:?} {c:?} {r:?}", f.recipe());
        }
        for k in 0..6 {
            assert!(within(jet.hess[k], exact.hess[k], 1e-6), "hessian {:?} {c:?} {r:?}", f.recipe());
        }
        let t = e[0];
        let q = c.iter().zip(r).map(|(c, r)| c + t * r).collect::<Vec<_>>();
        let v: f64 = eval(f, [&q[0], &q[1], &q[2]], print);
        assert!(within(line.range, v, slack), "line {:?} {c:?} {r:?}", f.recipe());
        let form = line.mid + line.slope[0] * t;
        assert!((v - form).abs() <= line.rest + slack, "line form {:?} {c:?} {r:?}", f.recipe());
    }
}

#[test]
fn enclosures_of_fractals_contain_samples() {
    let mut random = Random::new(7);
    for f in fractals() {
        for _ in 0..400 {
            check_box(&f, false, &mut random);
            check_box(&f, true, &mut random);
        }
    }
}

#[test]
fn enclosures_converge_with_second_order() {
    let f = Fractal::new(recipe(Model::Fbm, true)).unwrap();
    let excess = |r: f64| {
        let p = [0.3, 0.4, 0.5].map(|c| Reduced::<1>::new(c, [r]));
        f.eval([&p[0], &p[1], &p[2]], None).rest
    };
    let ratio = excess(1e-4) / excess(0.5e-4);
    assert!((3.5..4.5).contains(&ratio), "{ratio}");
}

/// Bits of any number through its debug text, which prints floats exactly.
fn text<T: std::fmt::Debug>(x: &T) -> String {
    format!("{x:?}")
}

fn check_lanes<T: Centred + Copy + std::fmt::Debug>(f: &Fractal, lane: impl Fn(&mut Random) -> [T; 4]) {
    const B: usize = 21;
    let mut random = Random::new(9);
    for _ in 0..6 {
        let lanes: [[T; 4]; B] = std::array::from_fn(|_| lane(&mut random));
        let [x, y, z, s] = [0, 1, 2, 3].map(|k| Many::<T, B>(std::array::from_fn(|i| lanes[i][k])));
        for footprint in [None, Some(&s)] {
            let all = f.eval([&x, &y, &z], footprint);
            for (i, [x, y, z, s]) in lanes.iter().enumerate() {
                let one = f.eval([x, y, z], footprint.map(|_| s));
                assert_eq!(text(&all.0[i]), text(&one), "{:?} lane {i}", f.recipe());
            }
        }
    }
}

#[test]
fn batches_equal_their_lanes() {
    // Footprints from "sees everything" to "sees nothing", so that lanes decide differently.
    fn print(random: &mut Random) -> f64 {
        10_f64.powf(random.unit() * 4.0 - 3.5)
    }
    for f in fractals() {
        check_lanes::<f64>(&f, |r| {
            let [x, y, z] = r.point(5.0);
            [x, y, z, print(r)]
        });
        check_lanes::<Dual>(&f, |r| {
            let p = r.point(5.0);
            let [x, y, z] = [0, 1, 2].map(|i| Dual::coordinate(p[i], i));
            [x, y, z, Dual { value: print(r), grad: [0.1, 0.0, 0.2] }]
        });
        check_lanes::<Interval>(&f, |r| {
            let (c, d) = random_box(r);
            let [x, y, z] = [0, 1, 2].map(|i| Interval::around(c[i], d[i]));
            [x, y, z, Interval::around(print(r), d[0] * 0.01)]
        });
        check_lanes::<Slope>(&f, |r| {
            let (c, d) = random_box(r);
            let [x, y, z] = [0, 1, 2].map(|i| Slope::coordinate(Interval::around(c[i], d[i]), i));
            [x, y, z, x.scale(0.0).shift(print(r))]
        });
        check_lanes::<Reduced<1>>(&f, |r| {
            let (c, d) = random_box(r);
            let [x, y, z] = [0, 1, 2].map(|i| Reduced::new(c[i], [d[i]]));
            [x, y, z, Reduced::new(print(r), [d[0] * 0.01])]
        });
    }
}

#[test]
fn samples_respect_the_bounds_of_fractals() {
    let mut random = Random::new(10);
    for f in fractals() {
        let (bounds, range) = (f.bounds(), f.range());
        for _ in 0..20_000 {
            let p = random.point(20.0);
            let d = [0, 1, 2].map(|i| Jet::coordinate(p[i], i));
            let jet = f.eval([&d[0], &d[1], &d[2]], None);
            assert!(range.contains(jet.value), "{:?}", f.recipe());
            assert!(jet.grad.iter().map(|g| g * g).sum::<f64>().sqrt() <= bounds.lipschitz);
            assert!(jet.hess.iter().all(|h| h.abs() <= bounds.hessian));
        }
    }
}

#[test]
fn fading_is_continuous_and_ends_at_the_mean() {
    let p = [0.31, -1.27, 2.4];
    for f in fractals() {
        let at = |s: f64| f.eval([&p[0], &p[1], &p[2]], Some(&s));
        let whole = f.eval([&p[0], &p[1], &p[2]], None);
        assert_eq!(at(0.0), whole);
        assert_eq!(at(-1.0), whole);
        assert_eq!(at(1e-9), whole);
        let mut last = at(1e-4);
        for i in 1..=40_000 {
            let next = at(1e-4 * 1e4_f64.powf(f64::from(i) / 40_000.0));
            assert!((next - last).abs() < 2e-3, "{:?} {i}: {last} to {next}", f.recipe());
            last = next;
        }
        assert_eq!(last, at(1e9));
    }
    // A distant ridged fractal is flat at its mean height.
    let ridged = Fractal::new(recipe(Model::Ridged, false)).unwrap();
    let amplitudes: f64 = (0..6).map(|i| 2.07_f64.powf(-0.8 * f64::from(i))).sum();
    let far = ridged.eval([&p[0], &p[1], &p[2]], Some(&1e9));
    assert!((far - 0.633 * amplitudes).abs() < 1e-12);
}

#[test]
fn the_ridge_mean_is_right() {
    let ridged = Fractal::new(Recipe { octaves: 1, ..recipe(Model::Ridged, false) }).unwrap();
    let mut random = Random::new(11);
    let n = 200_000;
    let mean = (0..n)
        .map(|_| {
            let [x, y, z] = random.point(1e3);
            ridged.eval([&x, &y, &z], None)
        })
        .sum::<f64>()
        / f64::from(n);
    assert!((mean - shape::Ridge::MEAN).abs() < 3e-3, "{mean}");
}

#[test]
fn invalid_recipes_name_the_parameter() {
    let good = recipe(Model::Fbm, false);
    let cases = [
        (Recipe { octaves: 0, ..good }, "octaves"),
        (Recipe { octaves: 33, ..good }, "octaves"),
        (Recipe { lacunarity: 1.0, ..good }, "lacunarity"),
        (Recipe { lacunarity: f64::NAN, ..good }, "lacunarity"),
        (Recipe { hurst: -0.1, ..good }, "hurst"),
        (Recipe { offset: f64::INFINITY, ..good }, "offset"),
        (Recipe { noise: Noise { frequency: 0.0, ..good.noise }, ..good }, "frequency"),
    ];
    for (recipe, field) in cases {
        let error = Fractal::new(recipe).unwrap_err();
        assert_eq!(error.field, field);
        assert!(error.to_string().contains("must be"), "{error}");
    }
    assert!(
        Fractal::new(Recipe { octaves: 32, lacunarity: 16.0, hurst: 0.0, ..good })
            .unwrap()
            .bounds()
            .third
            .is_finite()
    );
}

#[test]
fn equality_is_bitwise() {
    let a = Noise::new(Kind::Gradient(Gradient::EDGES), 1).at_frequency(2.0);
    assert_eq!(a, Noise { frequency: 2.0, ..a });
    assert_ne!(a, Noise { frequency: 2.0 + f64::EPSILON * 2.0, ..a });
    assert_ne!(a, a.seeded(2));
    let f = Fractal::new(recipe(Model::Fbm, true)).unwrap();
    assert_eq!(f, f.clone());
    assert_ne!(f, Fractal::new(recipe(Model::Fbm, false)).unwrap());
}

#[test]
fn one_octave_is_the_noise_itself() {
    let recipe = Recipe { octaves: 1, ..recipe(Model::Fbm, false) };
    let f = Fractal::new(recipe).unwrap();
    let p = [0.3, 0.7, -0.2];
    assert_eq!(f.eval([&p[0], &p[1], &p[2]], None), recipe.noise.jet(Order::Value, p).value);
}

/// Every kind of noise as it is unless told otherwise, and with each of its choices and flags.
fn kinds() -> Vec<(String, Kind)> {
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
fn jets_of(noise: &Noise, order: Order, points: &[[f64; 3]]) -> Vec<Point> {
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
            let plain = Fractal::new(Recipe { noise, octaves: 1, ..recipe(Model::Fbm, false) }).unwrap();
            for _ in 0..1000 {
                check_box(&plain, false, &mut random);
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

#[test]
fn distant_places_and_different_seeds_are_uncorrelated() {
    let n = 20_000;
    // Five deviations of the correlation of independent samples.
    let chance = 5.0 / (n as f64).sqrt();
    for (name, kind) in kinds() {
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
                let near = 1e-15 * q.iter().fold(100.0, |m: f64, x| m.max(x.abs()));
                if exact {
                    assert_eq!(at, image, "{name} {period:?} {p:?} {q:?}");
                } else if kind.class() >= Class::C0 {
                    let within = 2.0 * noise.error(0.0)[0] + 2.0 * near * b.lipschitz;
                    assert!((at.value - image.value).abs() <= within, "{name} {period:?} {p:?} {q:?}");
                }
            }
            // And not sooner.
            let sooner = (0..100).filter(|_| {
                let p = random.point(50.0);
                let differs = |axis: usize| {
                    let mut q = p;
                    q[axis] += if period[axis] == 0.0 { 4096.0 } else { (period[axis] - 1.0).max(1.0) };
                    period[axis] == 1.0
                        || (noise.jet(Order::Value, q).value - noise.jet(Order::Value, p).value).abs() > 1e-9
                };
                (0..3).all(differs)
            });
            assert!(sooner.count() > 80, "{name} {period:?}");
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

/// A number in twice the precision: the sum of two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Two(pub f64, pub f64);

impl Two {
    /// The exact sum of two numbers (Knuth).
    pub(super) fn sum(a: f64, b: f64) -> Two {
        let s = a + b;
        let t = s - a;
        Two(s, (a - (s - t)) + (b - t))
    }
}

impl std::ops::Add for Two {
    type Output = Two;
    fn add(self, b: Two) -> Two {
        let s = Two::sum(self.0, b.0);
        Two::sum(s.0, s.1 + self.1 + b.1)
    }
}

impl std::ops::Mul for Two {
    type Output = Two;
    fn mul(self, b: Two) -> Two {
        let p = self.0 * b.0;
        Two::sum(p, self.0.mul_add(b.0, -p) + self.0 * b.1 + self.1 * b.0)
    }
}

/// Checks a jet and its stated rounding against one in twice the precision.
pub(super) fn compare(noise: &Noise, p: [f64; 3], exact: [Two; 10]) {
    let jet = noise.jet(Order::Hessian, p);
    let all = std::iter::once(&jet.value).chain(&jet.grad).chain(&jet.hess);
    for (k, (x, exact)) in all.zip(exact).enumerate() {
        let within = noise.kind.rounding()[[0, 1, 1, 1, 2, 2, 2, 2, 2, 2][k]];
        let error = ((x - exact.0) - exact.1).abs();
        assert!(error <= within, "{:?} {k} {p:?}: {error:e} above {within:e}", noise.kind);
    }
}
