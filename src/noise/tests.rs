//! What every noise and fractal owes: enclosures that enclose, batches that equal their lanes.

use super::*;
use crate::num::{Affine, Centred, Dual, Interval, Jet, Many, Number, Reduced, Slope, Symbol, mix};

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
        noise: Noise::new(Kind::Gradient(Gradient), 3).at_frequency(1.5),
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
pub(super) fn check_box(f: &Fractal, footprint: bool, random: &mut Random) {
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
fn enclosures_of_the_noise_contain_samples() {
    let mut random = Random::new(8);
    let plain = Fractal::new(Recipe { octaves: 1, ..recipe(Model::Fbm, false) }).unwrap();
    for _ in 0..4000 {
        check_box(&plain, false, &mut random);
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
    let a = Noise::new(Kind::Gradient(Gradient), 1).at_frequency(2.0);
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
