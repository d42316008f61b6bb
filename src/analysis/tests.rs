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
        assert_eq!(v.stationary, known.stationary, "{name}: score {} of {}", c.score, c.floor);
        assert_eq!(v.isotropic, known.isotropic, "{name}: to {:?}", v.isotropic_to);
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
        assert!(!found.periodic && found.verdict.stationary, "{:?}", found.verdict);
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
