//! What fractals owe, over all models, signals and exponents.

use super::kinds::kinds;
use super::*;

const NOISE: Noise = Noise::new(Kind::Gradient(Gradient::EDGES), 3);

pub(super) fn recipe(model: Model, rotate: bool) -> Recipe {
    Recipe {
        octaves: 6,
        lacunarity: 2.07,
        hurst: Hurst::uniform(0.8),
        offset: 0.6,
        rotate,
        ..Recipe::new(NOISE.at_frequency(1.5), model)
    }
}

/// Every model over gradient noise, and every kind of noise in every signal.
fn fractals() -> impl Iterator<Item = Fractal> {
    let both = [false, true];
    let models = Model::all().flat_map(move |m| both.map(|rotate| recipe(m, rotate)));
    let others = Kind::ALL.iter().skip(1).map(Listing::plain).flat_map(|kind| {
        let noise = Noise::new(kind, 5).at_frequency(1.5);
        [Model::FBM, Model::RIDGED, Model::ALTITUDE2.of(Signal::Turbulent)].map(|model| Recipe {
            noise,
            octaves: 3,
            ..recipe(model, true)
        })
    });
    let coarse =
        Recipe { first: -2, hurst: Hurst::octaves(&[0.4, 1.1, -0.3, 0.9]), ..recipe(Model::FBM, true) };
    let slope = Recipe { noise: NOISE.slope(1), octaves: 3, ..recipe(Model::FBM, true) };
    let rough = Recipe { octaves: 8, hurst: Hurst::uniform(0.2), ..slope };
    models.chain(others).chain([coarse, slope, rough]).map(|r| Fractal::new(r).unwrap())
}

/// Checks all enclosures of `f` over a box against samples, with a footprint and an exponent that
/// vary, or without.
pub(in crate::noise) fn check_box(f: &Fractal, [footprint, hurst]: [bool; 2], random: &mut Random) {
    let (c, r) = random_box(random);
    // A footprint that varies over the box and meets all parts of the fade.
    let (base, rate) = (10_f64.powf(random.unit() * 3.0 - 3.0), if random.unit() < 0.5 { 0.0 } else { 0.05 });
    type Further = [Option<(f64, f64)>; 2];
    fn eval<T: Number>(f: &Fractal, p: [&T; 3], further: Further) -> T {
        let along = |k: usize| further[k].map(|(base, rate)| p[k].scale(rate).shift(base));
        let (footprint, hurst) = (along(0), along(1));
        f.eval_given(&Given { point: p, footprint: footprint.as_ref(), hurst: hurst.as_ref() })
    }
    let print = [footprint.then_some((base, rate)), hurst.then_some((0.7, 0.05))];
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
        let slack = 1e-12 * f.range().mag().max(1.0);
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
        // Differences that stand for third derivatives are good to some digits only.
        let loose = if f.recipe().noise.part == Part::Value { 1e-6 } else { f64::INFINITY };
        for k in 0..3 {
            assert!(within(slope.grad[k], exact.grad[k], 1e-9), "slope {:?} {c:?} {r:?}", f.recipe());
            assert!(within(jet.grad[k], exact.grad[k], 1e-9), "jet {:?} {c:?} {r:?}", f.recipe());
        }
        for k in 0..6 {
            assert!(within(jet.hess[k], exact.hess[k], loose), "hessian {:?} {c:?} {r:?}", f.recipe());
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
        for _ in 0..120 {
            for further in [[false; 2], [true, false], [false, true], [true; 2]] {
                check_box(&f, further, &mut random);
            }
        }
    }
}

#[test]
fn enclosures_converge_with_second_order() {
    let f = Fractal::new(recipe(Model::FBM, true)).unwrap();
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
        for (footprint, hurst) in [(None, None), (Some(&s), None), (None, Some(&y)), (Some(&s), Some(&y))] {
            let all = f.eval_given(&Given { point: [&x, &y, &z], footprint, hurst });
            for (i, [x, y, z, s]) in lanes.iter().enumerate() {
                let (footprint, hurst) = (footprint.map(|_| s), hurst.map(|_| y));
                let one = f.eval_given(&Given { point: [x, y, z], footprint, hurst });
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
        check_lanes::<Jet>(&f, |r| {
            let p = r.point(5.0);
            let [x, y, z] = [0, 1, 2].map(|i| Jet::coordinate(p[i], i));
            [x.add(&y), y, z, x.scale(0.01).shift(print(r))]
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
        // A footprint and an exponent that vary along x and y, and none.
        let varying = Surroundings { footprint: 0.02, hurst: Some((Interval::new(0.2, 1.2), 0.05)) };
        for around in [Surroundings::default(), varying] {
            let (bounds, range) = (f.bounds_given(&around), f.range_given(&around));
            for _ in 0..1500 {
                let p = random.point(10.0);
                let d = [0, 1, 2].map(|i| Jet::coordinate(p[i], i));
                let (s, h) = (d[0].scale(0.02).shift(0.1), d[1].scale(0.05).shift(0.7));
                let varies = around.hurst.is_some();
                let given = Given {
                    point: [&d[0], &d[1], &d[2]],
                    footprint: varies.then_some(&s),
                    hurst: varies.then_some(&h),
                };
                let jet = f.eval_given(&given);
                assert!(range.contains(jet.value), "{:?} {} {range:?}", f.recipe(), jet.value);
                let slope = jet.grad.iter().map(|g| g * g).sum::<f64>().sqrt();
                assert!(slope <= bounds.lipschitz, "{:?} {slope} {bounds:?}", f.recipe());
                assert!(jet.hess.iter().all(|h| h.abs() <= bounds.hessian));
            }
        }
    }
}

/// Differences of values and of gradients, beside what the jet says, away from creases.
#[test]
fn derivatives_of_fractals_match_differences() {
    let mut random = Random::new(12);
    let step = 1e-6;
    for f in fractals() {
        for further in 0..4 {
            let eval = |p: [f64; 3]| {
                let d = [0, 1, 2].map(|i| Jet::coordinate(p[i], i));
                let (s, h) = (
                    d[0].scale(0.01).shift(0.06),
                    Jet::lift(&shape::Modulate::PRODUCT, [&d[1], &d[1]]).scale(0.02).shift(0.7),
                );
                f.eval_given(&Given {
                    point: [&d[0], &d[1], &d[2]],
                    footprint: (further & 1 != 0).then_some(&s),
                    hurst: (further & 2 != 0).then_some(&h),
                })
            };
            let mut off = [0, 0];
            for _ in 0..60 {
                let (p, axis) = (random.point(3.0), (random.unit() * 3.0) as usize % 3);
                let jet = eval(p);
                let [low, high] = [-step, step].map(|h| {
                    let mut q = p;
                    q[axis] += h;
                    eval(q)
                });
                let size = f.bounds().lipschitz.max(1.0);
                let slope = (high.value - low.value) / (2.0 * step);
                off[0] += usize::from((slope - jet.grad[axis]).abs() > 1e-5 * size);
                let bend = (high.grad[axis] - low.grad[axis]) / (2.0 * step);
                // Slopes have kinks in their second derivatives where cells meet.
                off[1] += usize::from((bend - jet.hess[axis]).abs() > 1e-4 * size * size);
            }
            // Points beside a crease are rare.
            assert!(off.iter().all(|n| *n <= 4), "{:?} {further} {off:?}", f.recipe());
        }
    }
}

/// Values of each kind of number over a point, or a box around it, as their ranges and slopes.
fn enclosed(f: &Fractal, c: [f64; 3], r: f64, s: f64) -> Vec<f64> {
    let ends = |i: Interval| [i.lo, i.hi];
    let boxes = c.map(|c| Interval::around(c, r));
    let d = [0, 1, 2].map(|i| Dual::coordinate(c[i], i));
    let dual = f.eval([&d[0], &d[1], &d[2]], Some(&Dual::constant(s)));
    let interval = f.eval([&boxes[0], &boxes[1], &boxes[2]], Some(&Interval::point(s)));
    let l = [0, 1, 2].map(|i| Slope::coordinate(boxes[i], i));
    let slope = f.eval([&l[0], &l[1], &l[2]], Some(&Slope::constant(s)));
    let m = c.map(|c| Reduced::<1>::new(c, [r]));
    let line = f.eval([&m[0], &m[1], &m[2]], Some(&Reduced::constant(s)));
    let mut out = vec![dual.value, dual.grad[0], dual.grad[1], dual.grad[2]];
    out.extend(ends(interval).into_iter().chain(ends(slope.value)).chain(ends(line.range)));
    out
}

/// The level of detail never jumps: not where an octave begins to fade, not where it is gone, and
/// not in between, for points and for enclosures, narrow and wide.
#[test]
fn the_level_of_detail_is_continuous() {
    let c = [0.31, -1.27, 2.4];
    for f in fractals() {
        for term in f.terms.iter() {
            for edge in [term.fade.gone, 0.5 * term.fade.gone] {
                for r in [1e-3, 0.05, 0.5, 20.0] {
                    // Beyond the rounding of the edge itself; weights there are 3e-18 or so.
                    let [below, above] = [1.0 - 1e-9, 1.0 + 1e-9].map(|k| enclosed(&f, c, r, edge * k));
                    for (k, (a, b)) in below.iter().zip(&above).enumerate() {
                        assert!(a == b || (a - b).abs() < 1e-9, "{:?} {r} {k}: {a} to {b}", f.recipe());
                    }
                }
            }
        }
    }
}

#[test]
fn fading_is_smooth_and_ends_at_the_mean() {
    let p = [0.31, -1.27, 2.4];
    for f in fractals() {
        let at = |s: f64| f.eval([&p[0], &p[1], &p[2]], Some(&s));
        let whole = f.eval([&p[0], &p[1], &p[2]], None);
        assert_eq!(at(0.0), whole);
        assert_eq!(at(-1.0), whole);
        assert_eq!(at(1e-9), whole);
        // C1: the derivative by the footprint goes to zero at both ends of every fade.
        let slope = |s: f64| {
            let d = p.map(Dual::constant);
            let s = Dual { value: s, grad: [1.0, 0.0, 0.0] };
            f.eval([&d[0], &d[1], &d[2]], Some(&s)).grad[0]
        };
        for term in f.terms.iter() {
            for edge in [term.fade.gone, 0.5 * term.fade.gone] {
                let (a, b) = (slope(edge * (1.0 - 1e-7)), slope(edge * (1.0 + 1e-7)));
                let scale = f.bounds().range.max(1.0) / edge;
                assert!((a - b).abs() < 1e-4 * scale, "{:?} {a} {b}", f.recipe());
            }
        }
        let mut last = at(1e-4);
        let size = f.bounds().range.max(1.0);
        for i in 1..=20_000 {
            let next = at(1e-4 * 1e4_f64.powf(f64::from(i) / 20_000.0));
            assert!((next - last).abs() < 4e-3 * size, "{:?} {i}: {last} to {next}", f.recipe());
            last = next;
        }
        assert_eq!(at(1e8), at(1e9));
    }
    // A distant ridged fractal is flat at its mean height.
    let ridged = Fractal::new(recipe(Model::RIDGED, false)).unwrap();
    let amplitudes: f64 = (0..6).map(|i| 2.07_f64.powf(-0.8 * f64::from(i))).sum();
    let far = ridged.eval([&p[0], &p[1], &p[2]], Some(&1e9));
    assert!((far - ridged.mean * amplitudes).abs() < 1e-12);
    assert!((ridged.mean - 0.633).abs() < 0.01);
}

#[test]
fn means_are_those_of_the_signals() {
    let mut random = Random::new(11);
    for (name, kind) in kinds() {
        for &signal in Signal::ALL {
            let model = Model::FBM.of(signal);
            let sum = |seed| {
                let recipe = Recipe { octaves: 1, ..Recipe::new(Noise::new(kind, seed), model) };
                Fractal::new(recipe).unwrap()
            };
            let (seeds, points) = (200, 100);
            let mut mean = 0.0;
            for f in (1000..1000 + seeds).map(sum) {
                for _ in 0..points {
                    let [x, y, z] = random.point(1e3);
                    mean += f.eval([&x, &y, &z], None) / (seeds * points) as f64;
                }
            }
            let found = sum(1).mean;
            assert!((mean - found).abs() < 0.02 + 0.1 * mean.abs(), "{name} {signal:?}: {mean}, {found}");
        }
    }
    let f = Fractal::new(recipe(Model::FBM, false)).unwrap();
    assert_eq!(f.mean, 0.0);
}

#[test]
fn ridges_reach_one_and_weights_stay_within() {
    // Gradient noise is zero at the nodes of its lattice, where ridges are highest.
    let ridge = Fractal::new(Recipe { octaves: 1, ..Recipe::new(NOISE, Model::RIDGED) }).unwrap();
    assert_eq!(ridge.eval([&1.0, &2.0, &3.0], None), 1.0);
    let mut random = Random::new(13);
    for &signal in Signal::ALL {
        // Weights are the differences of sums that are one octave apart.
        let sum =
            |octaves| Fractal::new(Recipe { octaves, ..recipe(Model::ALTITUDE2.of(signal), true) }).unwrap();
        let sums: Vec<Fractal> = (1..=6).map(sum).collect();
        for _ in 0..2000 {
            let [x, y, z] = random.point(10.0);
            let mut last = 0.0;
            for f in &sums {
                let next = f.eval([&x, &y, &z], None);
                assert!((-1e-15..=1.0 + 1e-15).contains(&(next - last)));
                last = next;
            }
            assert!(ridge.eval([&x, &y, &z], None) <= 1.0);
        }
    }
}

#[test]
fn a_field_of_one_exponent_is_that_exponent() {
    let mut random = Random::new(14);
    for f in fractals().filter(|f| f.recipe().hurst.exponents().len() == 1) {
        for _ in 0..50 {
            let [x, y, z] = random.point(5.0);
            let hurst = f.recipe().hurst.exponents()[0];
            let given = Given { point: [&x, &y, &z], footprint: Some(&0.05), hurst: Some(&hurst) };
            let (a, b) = (f.eval_given(&given), f.eval([&x, &y, &z], Some(&0.05)));
            assert!((a - b).abs() < 1e-12, "{:?} {a} {b}", f.recipe());
        }
    }
}

#[test]
fn exponents_of_octaves_multiply() {
    let all = |h: &[f64], first| Hurst::octaves(h).amplitudes(2.0, first, 4);
    assert_eq!(all(&[1.0], 0), [1.0, 0.5, 0.25, 0.125]);
    assert_eq!(all(&[1.0, 1.0, 1.0], -1), [2.0, 1.0, 0.5, 0.25]);
    assert_eq!(all(&[0.0, 1.0, 2.0], 0), [1.0, 0.5, 0.125, 0.03125]);
    // Octaves keep their seeds and places, wherever the sum begins.
    let sum = |first, octaves| Fractal::new(Recipe { first, octaves, ..recipe(Model::FBM, true) }).unwrap();
    let (coarse, all, fine) = (sum(-2, 2), sum(-2, 5), sum(0, 3));
    let p = [0.3, 0.7, -0.2];
    let at = |f: &Fractal| f.eval([&p[0], &p[1], &p[2]], None);
    assert!((at(&coarse) + at(&fine) - at(&all)).abs() < 1e-14);
}

#[test]
fn octaves_of_a_tiled_noise_repeat_together() {
    let tiled = |period, first| {
        let noise = Noise { lattice: Lattice { period, ..NOISE.lattice }, ..NOISE };
        Recipe { lacunarity: 3.0, first, octaves: 4, ..Recipe::new(noise, Model::FBM) }
    };
    let f = Fractal::new(tiled([9, 18, 0], -2)).unwrap();
    let periods: Vec<_> = f.terms.iter().map(|t| t.octave.noise.lattice.period).collect();
    assert_eq!(periods, [[1, 2, 0], [3, 6, 0], [9, 18, 0], [27, 54, 0]]);
    assert_eq!(tiled([8, 9, 9], -1).validate().unwrap_err().field, "first");
    assert_eq!(Recipe { rotate: true, ..tiled([9; 3], 0) }.validate().unwrap_err().field, "rotate");
    assert_eq!(Recipe { lacunarity: 2.1, ..tiled([9; 3], 0) }.validate().unwrap_err().field, "lacunarity");
    // Where the cells would be too many to count, octaves repeat after fewer.
    let f = Fractal::new(Recipe { octaves: 32, lacunarity: 2.0, ..tiled([3; 3], 0) }).unwrap();
    assert!(f.terms.iter().all(|t| t.octave.noise.lattice.period[0] <= 1 << 24));
    assert_eq!(f.terms[31].octave.noise.lattice.period[0], 3 << 22);
}

#[test]
fn invalid_recipes_name_the_parameter() {
    let good = recipe(Model::FBM, false);
    let cases = [
        (Recipe { octaves: 0, ..good.clone() }, "octaves"),
        (Recipe { octaves: 33, ..good.clone() }, "octaves"),
        (Recipe { first: 17, ..good.clone() }, "first"),
        (Recipe { lacunarity: 1.0, ..good.clone() }, "lacunarity"),
        (Recipe { lacunarity: f64::NAN, ..good.clone() }, "lacunarity"),
        (Recipe { hurst: Hurst::uniform(-2.1), ..good.clone() }, "hurst"),
        (Recipe { hurst: Hurst::octaves(&[]), ..good.clone() }, "hurst"),
        (Recipe { hurst: Hurst::octaves(&[0.5, f64::NAN]), ..good.clone() }, "hurst"),
        (Recipe { offset: f64::INFINITY, ..good.clone() }, "offset"),
        (Recipe { noise: NOISE.at_frequency(0.0), ..good.clone() }, "frequency"),
        (Recipe { noise: NOISE.slope(0), model: Model::RIDGED, ..good.clone() }, "noise"),
    ];
    for (recipe, field) in cases {
        let error = Fractal::new(recipe).unwrap_err();
        assert_eq!(error.field, field);
        assert!(error.to_string().contains("must be"), "{error}");
    }
    assert!(
        Fractal::new(Recipe { octaves: 32, lacunarity: 16.0, hurst: Hurst::uniform(0.0), ..good })
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
    let f = Fractal::new(recipe(Model::FBM, true)).unwrap();
    assert_eq!(f, f.clone());
    assert_ne!(f, Fractal::new(recipe(Model::FBM, false)).unwrap());
}

#[test]
fn one_octave_is_the_noise_itself() {
    let recipe = Recipe { octaves: 1, ..recipe(Model::FBM, false) };
    let noise = recipe.noise;
    let f = Fractal::new(recipe).unwrap();
    let p = [0.3, 0.7, -0.2];
    assert_eq!(f.eval([&p[0], &p[1], &p[2]], None), noise.jet(Order::Value, p).value);
}
