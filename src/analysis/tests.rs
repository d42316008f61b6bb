//! Noises against what is known of them exactly. A noise is one line of [`KNOWN`].

use super::*;
use crate::expr::Graph;
use crate::noise::{Fractal, Hurst, Kind, Model, Noise, Recipe};
use crate::scene::{Ensemble, Member};
use std::sync::Arc;

/// A noise with what must come out.
struct Known {
    noise: &'static str,
    /// Variance over space.
    variance: f64,
    stationary: bool,
    /// Whether it is isotropic all through its band.
    isotropic: bool,
    low_pass: bool,
    /// Radial power of the plane z = 0 in dB.
    power: &'static [(f64, f64)],
}

/// Exact curves of the plane z = 0, in which these noises are their own two-dimensional kin: the
/// transform of the kernel squared, averaged over the directions of a wavenumber.
const KNOWN: &[Known] = &[
    Known {
        noise: "gradient",
        variance: 0.07292,
        stationary: false,
        isotropic: false,
        low_pass: false,
        power: &[(0.25, -17.4), (0.5, -14.7), (0.75, -17.2), (1.0, -24.6), (1.5, -39.4)],
    },
    Known {
        noise: "value",
        variance: 0.1604,
        stationary: false,
        isotropic: false,
        low_pass: true,
        power: &[(0.25, -6.1), (0.5, -10.2), (0.75, -18.0), (1.5, -39.8)],
    },
    Known {
        // Two independent noises: variances and powers add up.
        noise: "value_gradient",
        variance: 0.2333,
        stationary: false,
        isotropic: false,
        low_pass: true,
        power: &[(0.25, -5.8), (0.5, -8.9), (0.75, -14.6), (1.5, -36.6)],
    },
    Known {
        // The distance to the nearest node of a Poisson process has a Gamma law; its spectrum has no
        // closed form.
        noise: "cellular",
        variance: 0.04053,
        stationary: true,
        isotropic: true,
        low_pass: true,
        power: &[],
    },
    Known {
        // Its spectrum in space is the kernel's transform squared; that of a plane, its integral
        // across the plane.
        noise: "sparse",
        variance: 0.37313,
        stationary: true,
        isotropic: true,
        low_pass: true,
        power: &[(0.25, -4.07), (0.5, -7.38), (0.75, -13.52), (1.0, -24.33), (1.5, -36.55)],
    },
    Known {
        // Independent nodes, one in the plane and two half a unit beside it to every unit of area, each
        // with the kernel C (1/2 - r^2)^4 (g . d) and E[g g^T] = 2/3 I: the transform of the kernel
        // squared, by quadrature. The variance is 4/3 C^2 int 4 pi r^4 (1/2 - r^2)^8 dr. It is zero at
        // all nodes, and so not stationary.
        noise: "simplex",
        variance: 0.15401,
        stationary: false,
        isotropic: true,
        low_pass: false,
        power: &[(0.25, -21.76), (0.5, -17.25), (0.75, -15.78), (1.0, -16.19), (1.5, -21.84)],
    },
];

fn noise(name: &str) -> Noise {
    let listing = Kind::ALL.iter().find(|k| k.name == name).unwrap();
    Noise::new(listing.plain(), 1)
}

fn measure(ensemble: &Ensemble, plan: Plan) -> Analysis {
    analyse(ensemble, &plan, &Watch::unwatched(&AtomicBool::new(false))).unwrap()
}

/// Large enough for the first zeros, small enough for a test.
const PLAN: Plan = Plan { side: 16, samples: 8, solid: false };

#[test]
fn noises_are_what_is_known_of_them() {
    for known in KNOWN {
        let found = measure(&Ensemble::of_noise(noise(known.noise), 100, 16.0).unwrap(), PLAN);
        let name = known.noise;
        assert!(found.periodic, "{name}");
        assert!(found.moments.mean.abs() < 4.0 * found.mean_error, "{name}: mean {}", found.moments.mean);
        let ratio = found.moments.variance / known.variance;
        assert!((ratio - 1.0).abs() < 0.02, "{name}: variance {}", found.moments.variance);
        let (v, c) = (&found.verdict, &found.covariance);
        assert_eq!(v.stationary, Some(known.stationary), "{name}: score {} of {}", c.score, c.floor);
        assert_eq!(v.isotropic, Some(known.isotropic), "{name}: to {:?}", v.isotropic_to);
        assert_eq!(v.band.half_low.is_none(), known.low_pass, "{name}: {:?}", v.band);
        for &(k, wanted) in known.power {
            let got = found.radial.level(k);
            assert!((got - wanted).abs() < 1.0, "{name}: {got:.2} dB at {k}, not {wanted}");
        }
        assert!(!v.aliased && v.slope.is_none(), "{name}");
    }
}

#[test]
fn the_covariance_of_gradient_noise_is_exact() {
    let plan = Plan { side: 32, samples: 2, solid: false };
    let found = measure(&Ensemble::of_noise(noise("gradient"), 400, 32.0).unwrap(), plan);
    let c = &found.covariance;
    let near = |got: f64, wanted: f64| assert!((got - wanted).abs() < 0.006, "{got} is not {wanted}");
    for (place, wanted) in [(0, 0.0), (2, 0.0102), (4, 0.0375), (8, 0.0833)] {
        (0..covariance::SPAN).for_each(|cell| near(c.at(16 * cell + place, 16 * cell + place), wanted));
    }
    for (distance, wanted) in [(4, 0.0503), (8, 0.0), (12, -0.0374), (16, -0.0417)] {
        near(c.at(40, 40 + distance), wanted);
    }
}

/// The autocorrelation of the quintic kernel on a ball, by quadrature.
fn quintic_ball(distance: f64) -> f64 {
    const STEPS: usize = 200;
    let h = |t: f64| if t < 1.0 { 1.0 - t * t * t * (10.0 - t * (15.0 - 6.0 * t)) } else { 0.0 };
    let place = |i: usize| (i as f64 + 0.5) / STEPS as f64;
    let ring = |r: f64, cosine: f64| h((r * r + distance * distance + 2.0 * r * distance * cosine).sqrt());
    let shell = |r: f64| (0..STEPS).map(|j| ring(r, 2.0 * place(j) - 1.0)).sum::<f64>() * 2.0 / STEPS as f64;
    let ball = (0..STEPS).map(place).map(|r| r * r * h(r) * shell(r)).sum::<f64>();
    std::f64::consts::TAU * ball / STEPS as f64
}

/// What a wave of this wavenumber in a random direction keeps over a distance, on average.
fn wave(wavenumber: f64, distance: f64) -> f64 {
    let phase = std::f64::consts::TAU * wavenumber * distance;
    if phase == 0.0 { 1.0 } else { phase.sin() / phase }
}

fn assert_covariance(name: &str, exact: impl Fn(f64) -> f64) {
    let plan = Plan { side: 32, samples: 2, solid: false };
    let found = measure(&Ensemble::of_noise(noise(name), 400, 32.0).unwrap(), plan);
    for i in 0..=3 * covariance::SAMPLES / 2 {
        let (got, wanted) = (found.covariance.by_distance[i], exact(i as f64 * found.covariance.step));
        assert!((got - wanted).abs() < 0.02 * exact(0.0), "{name} at {i}: {got} is not {wanted}");
    }
}

/// One node of variance 1 a cell; a Gabor kernel's wave has two to a cell, a random phase, and so
/// half the variance.
#[test]
fn noises_on_random_nodes_have_the_covariance_of_their_kernels() {
    assert_covariance("sparse", quintic_ball);
    assert_covariance("gabor", |d| 0.5 * quintic_ball(d) * wave(2.0, d));
}

/// Waves have all their power on the unit sphere of wavenumbers, on which zones of the same height are
/// equal (Archimedes). In the plane, `1 - sqrt(1 - k^2)` of it lies within `k`, and all within 1.
#[test]
fn waves_have_their_power_on_a_sphere() {
    assert_covariance("waves", |d| wave(1.0, d));
    let found = measure(&Ensemble::of_noise(noise("waves"), 100, 16.0).unwrap(), PLAN);
    let within = |k: f64| {
        let spectrum = &found.spectrum;
        let at = |i: usize| spectrum.wavenumber(i);
        let length = |i: usize| at(i % spectrum.edge).hypot(at(i / spectrum.edge));
        let inside = (0..spectrum.density.len()).filter(|&i| length(i) <= k);
        inside.map(|i| spectrum.density[i]).sum::<f64>() * spectrum.step * spectrum.step
    };
    let total = within(f64::INFINITY);
    assert!((total - 1.0).abs() < 0.05, "{total}");
    for k in [0.5, 0.75, 0.9_f64] {
        let (got, wanted) = (within(k), 1.0 - (1.0 - k * k).sqrt());
        assert!((got - wanted).abs() < 0.04, "{got} within {k}, not {wanted}");
    }
    // What the window smears reaches two steps of the spectrum.
    assert!(total - within(1.0 + 2.0 / 16.0) < 1e-3 * total);
}

/// What is left of white noise on the half-integers when its projection on coarser splines is taken
/// off has, with the splines' refinement `p` and Gram symbol `G`, a spectrum in closed form; that of the
/// plane `k_z = 0` in space is that of the noise in two dimensions, since the projection keeps what is
/// the same all along z.
#[test]
fn wavelet_noise_is_what_coarser_splines_cannot_say() {
    let plan = Plan { side: 16, samples: 4, solid: true };
    let found = measure(&Ensemble::of_noise(noise("wavelet"), 40, 16.0).unwrap(), plan);
    assert!((found.moments.variance / 0.098 - 1.0).abs() < 0.03, "{}", found.moments.variance);
    // In space, with coefficients half a unit apart; the closed form averaged over rings.
    for (k, wanted) in [(0.66, -14.36), (0.75, -15.33), (1.0, -20.51), (1.25, -27.79)] {
        let got = found.radial.level(k);
        assert!((got - wanted).abs() < 1.0, "{got:.2} dB at {k}, not {wanted}");
    }
    let power = |from: f64, to: f64| {
        let rings = found.radial.rings.iter().filter(|r| (from..to).contains(&r.k));
        rings.map(|r| r.power_about_mean * r.count as f64).sum::<f64>()
    };
    assert!(power(0.0, 0.35) < 2e-3 * power(0.0, 9.0), "coarser splines should be blind to it");
}

#[test]
fn samples_that_tell_nothing_leave_verdicts_open() {
    let doubt = |noise: Noise, count| {
        let plan = Plan { side: 8, samples: 4, solid: false };
        let found = measure(&Ensemble::of_noise(noise, count, 8.0).unwrap(), plan);
        let v = found.verdict;
        assert_eq!(v.stationary.is_none(), v.doubt.is_some());
        assert_eq!(v.isotropic.is_none(), v.doubt.is_some());
        v.doubt
    };
    let gradient = noise("gradient");
    let fine = |frequency| Noise { frequency, ..gradient };
    assert_eq!(doubt(gradient, 20), None);
    assert_eq!(doubt(gradient, 19), Some(Doubt::Few));
    assert_eq!(doubt(fine(1e9), 20), Some(Doubt::Aliased));
    assert_eq!(doubt(fine(12345.6789), 20), Some(Doubt::Aliased));
}

#[test]
fn a_sphere_is_drawn_the_same_on_any_number_of_threads() {
    let ensemble = Ensemble::of_noise(noise("gradient"), 2, 8.0).unwrap();
    let found = measure(&ensemble, Plan { side: 8, samples: 4, solid: false });
    let draw = |amplitude| {
        let (noise, moments) = (&ensemble.plain, &found.moments);
        let sphere = Sphere { noise, moments, cell: 1.0, amplitude, size: 64 };
        sphere.draw(&Watch::unwatched(&AtomicBool::new(false))).unwrap().rgb
    };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| draw(None))
    };
    assert_eq!(on(1), on(2));
    // A smooth ball of radius 1 in a square of side 2.5, seen from nearby; pixels on its edge count.
    let smooth = draw(Some(1e-9));
    let seen = smooth.iter().step_by(3).filter(|&&b| b > 40).count() as f64 / (64.0 * 64.0);
    let wanted = std::f64::consts::PI * 49.0 / 48.0 / 6.25;
    assert!((0.0..0.03).contains(&(seen - wanted)), "{seen} of the picture, not {wanted}");
}

/// Sums of octaves of gradient noise with other seeds.
fn sums(model: Model, hurst: f64, count: u64) -> Ensemble {
    let (octaves, lacunarity) = (6, 2.0);
    let mut graph = Graph::default();
    let p = graph.point().unwrap();
    let sharp = graph.constant(0.0).unwrap();
    let mut root = |seed: u64| {
        let noise = noise("gradient").seeded(seed);
        let hurst = Hurst::uniform(hurst);
        let recipe = Recipe { octaves, lacunarity, hurst, rotate: true, ..Recipe::new(noise, model) };
        let fractal = Fractal::new(recipe).unwrap();
        graph.fractal(Arc::new(fractal), p, sharp).unwrap()
    };
    let roots: Vec<_> = (0..count).map(&mut root).collect();
    let graph = Arc::new(graph);
    let member = |root| Member { graph: graph.clone(), root };
    let members: Vec<_> = roots.into_iter().map(member).collect();
    let plain = members[0].clone();
    Ensemble { members, plain, period: None, cell: 1.0, octaves: (1.0, 32.0) }
}

/// A field in space with `G ~ k^-(2H + 3)` has planes with `G ~ k^-(2H + 2)`, the integral across.
#[test]
fn sums_of_octaves_follow_their_power_law() {
    for hurst in [0.3, 0.8] {
        let found = measure(&sums(Model::FBM, hurst, 24), Plan { side: 4, samples: 64, solid: false });
        let slope = found.verdict.slope.unwrap();
        let wanted = 2.0 * hurst + 2.0;
        assert!((slope.beta / wanted - 1.0).abs() < 0.05, "{slope:?}, not {wanted}");
        assert!(!found.periodic && found.verdict.stationary == Some(true), "{:?}", found.verdict);
    }
}

#[test]
fn the_spectrum_in_space_falls_one_power_faster() {
    let hurst = 0.8;
    let found = measure(&sums(Model::FBM, hurst, 4), Plan { side: 2, samples: 32, solid: true });
    let (beta, _) = found.radial.slope(1.5, 8.0).unwrap();
    let wanted = 2.0 * hurst + 3.0;
    assert!((beta / wanted - 1.0).abs() < 0.05, "{beta}, not {wanted}");
}

/// Parseval: the density adds up to the variance of the plane, which for gradient noise is
/// `4/3 I_0 I_2` with the integrals `I_0 = 0.78355` of the fade squared and `I_2 = 0.05939` of the fade
/// squared times `t^2`.
#[test]
fn power_adds_up_to_the_variance() {
    let found = measure(&Ensemble::of_noise(noise("gradient"), 40, 16.0).unwrap(), PLAN);
    let cell = found.spectrum.step * found.spectrum.step;
    let power = found.spectrum.density.iter().sum::<f64>() * cell;
    assert!((power / 0.06204 - 1.0).abs() < 0.02, "{power}");
}

#[test]
fn threads_change_nothing() {
    let ensemble = Ensemble::of_noise(noise("gradient"), 7, 8.0).unwrap();
    let plan = Plan { side: 8, samples: 4, solid: false };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| serde_json::to_string(&measure(&ensemble, plan)).unwrap())
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn what_cannot_be_analysed_is_refused() {
    let flag = AtomicBool::new(false);
    let ensemble = |count| Ensemble::of_noise(noise("gradient"), count, 8.0).unwrap();
    let try_plan = |count, side, samples, solid| {
        analyse(&ensemble(count), &Plan { side, samples, solid }, &Watch::unwatched(&flag)).map(drop)
    };
    assert_eq!(try_plan(4, 12, 16, false), Err(Refusal::Power { what: "cells", value: 12 }));
    assert_eq!(try_plan(4, 32, 1, false), Err(Refusal::Power { what: "samples", value: 1 }));
    assert_eq!(try_plan(4, 4096, 4096, false), Err(Refusal::Large { edge: 1 << 24, layers: 2 }));
    assert_eq!(try_plan(1, 8, 4, false), Err(Refusal::Few));
    flag.store(true, std::sync::atomic::Ordering::Relaxed);
    assert_eq!(try_plan(4, 8, 4, false), Err(Refusal::Cancelled));
}
