//! The laws that every reflectance obeys, over random directions with fixed seeds.

use super::*;
use crate::num::sequence::point;
use crate::num::{mix, uniform};
use frame::around_z;
use std::f64::consts::TAU;

/// Steps of a quadrature along each axis.
const STEPS: u32 = 320;

/// Azimuth of the eye in all quadratures, in turns.
const AZIMUTH: f64 = 0.137;

/// Films of an index of refraction.
pub(super) fn film(ior: f64) -> Film {
    Film::new(ior)
}

/// A direction whose cosine to z is given.
pub(super) fn tilted(cos: f64) -> DVec3 {
    around_z(cos, AZIMUTH)
}

/// Directions over the hemisphere around z with the solid angle that belongs to each: closer to one
/// another around z, at grazing angles and opposite of the eye, where highlights are small.
pub(super) fn hemisphere(steps: u32) -> impl Iterator<Item = (DVec3, f64)> {
    let middle = move |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
    let level = move |i: u32| {
        let t = middle(i);
        [t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t)]
    };
    let turn = move |j: u32| {
        let t = middle(j);
        [AZIMUTH + 0.5 + t - libm::sin(TAU * t) / TAU, 1.0 - libm::cos(TAU * t)]
    };
    (0..steps).flat_map(move |i| {
        let [cos, high] = level(i);
        (0..steps).map(move |j| {
            let [azimuth, wide] = turn(j);
            (around_z(cos, azimuth), TAU * high * wide / f64::from(steps * steps))
        })
    })
}

/// The directional albedo `int f cos`, by quadrature.
pub(super) fn albedo(model: &impl Reflectance, normal: DVec3, to_eye: DVec3) -> DVec3 {
    let frame = Frame::around(normal);
    let light =
        |(local, area): (DVec3, f64)| model.value(normal, to_eye, frame.to_world(local)) * (local.z * area);
    hemisphere(STEPS).map(light).sum()
}

fn random(seed: u64) -> DVec3 {
    let u = [mix(2 * seed), mix(2 * seed + 1)].map(uniform);
    around_z(2.0 * u[0] - 1.0, u[1])
}

/// What does not depend on a quadrature.
fn pointwise(name: &str, model: &impl Reflectance) {
    for i in 0..2000 {
        let [normal, eye, light] = [random(3 * i), random(3 * i + 1), random(3 * i + 2)];
        let [there, back] = [model.value(normal, eye, light), model.value(normal, light, eye)];
        let above = normal.dot(eye) > 0.0 && normal.dot(light) > 0.0;
        assert!((there - back).length() <= 1e-11 * there.length(), "{name}: {there} {back}");
        assert!(there.min_element() >= 0.0 && there.is_finite(), "{name}: {there}");
        assert!(above || (there == DVec3::ZERO && model.pdf(normal, eye, light) == 0.0), "{name}");
        if normal.dot(eye) > 0.0 {
            sampled(name, model, normal, eye, [mix(i), mix(i + 9000)].map(uniform));
        }
    }
    for eye in [1e-9, 1e-3, 1.0].map(tilted) {
        for u in [[0.0, 0.0], [0.0, 0.999], [1.0 - f64::EPSILON / 2.0, 0.5], [0.5, 0.25]] {
            sampled(name, model, DVec3::Z, eye, u);
        }
        for light in [1e-9, 1e-3, 1.0].map(tilted) {
            assert!(model.value(DVec3::Z, eye, light).is_finite(), "{name}");
        }
    }
}

/// A sample is above the surface and has the weight that value and density say.
fn sampled(name: &str, model: &impl Reflectance, normal: DVec3, eye: DVec3, u: [f64; 2]) {
    let Some(Bounce { direction, weight, .. }) = model.sample(u, normal, eye) else { return };
    assert!((direction.length() - 1.0).abs() < 1e-12 && direction.dot(normal) > 0.0, "{name}");
    assert!(weight.min_element() >= 0.0 && weight.max_element() < 50.0, "{name}: {weight} for {u:?}");
    let pdf = model.pdf(normal, eye, direction);
    let expected = model.value(normal, eye, direction) * (direction.dot(normal) / pdf);
    // Highlights are so small that the last bits of a direction matter.
    assert!((weight - expected).length() <= 1e-7 * weight.length(), "{name}: {weight} {expected}");
}

/// What integrals say: energy, and samples against a quadrature.
fn integrals(name: &str, model: &impl Reflectance) {
    for (i, mu) in [0.05, 0.2, 0.5, 0.8, 1.0].into_iter().enumerate() {
        let normal = random(i as u64);
        let frame = Frame::around(normal);
        let eye = frame.to_world(tilted(mu));
        let known = albedo(model, normal, eye);
        assert!(known.max_element() <= 1.0 + 3e-3, "{name} {mu}: {known}");
        let count = 1 << 13;
        let bounces: Vec<_> = (0..count).map(|k| model.sample(point(mix(77), k, 0), normal, eye)).collect();
        let mean = bounces.iter().flatten().map(|b| b.weight).sum::<DVec3>() / f64::from(count);
        assert!((mean - known).abs().max_element() < 4e-3, "{name} {mu}: {mean}, but {known}");
        let lost = bounces.iter().filter(|b| b.is_none()).count() as f64 / f64::from(count);
        let density: f64 =
            hemisphere(STEPS).map(|(l, area)| model.pdf(normal, eye, frame.to_world(l)) * area).sum();
        assert!((density + lost - 1.0).abs() < 4e-3, "{name} {mu}: {density} + {lost}");
        // Where the light comes from, too: samples give the integral of f cos g for another g.
        let g = |l: DVec3| l.dot(frame.to_world(DVec3::X)) + 0.3 * l.dot(normal);
        let known: f64 = hemisphere(STEPS)
            .map(|(l, area)| (frame.to_world(l), l.z * area))
            .map(|(l, area)| model.value(normal, eye, l).y * area * g(l))
            .sum();
        let mean =
            bounces.iter().flatten().map(|b| b.weight.y * g(b.direction)).sum::<f64>() / f64::from(count);
        assert!((mean - known).abs() < 4e-3, "{name} {mu}: {mean}, but {known}");
    }
}

fn laws(name: &str, model: &impl Reflectance) {
    pointwise(name, model);
    integrals(name, model);
}

#[test]
fn lambert() {
    let matt = Lambert { albedo: DVec3::new(0.2, 0.7, 1.0) };
    laws("Lambert", &matt);
    let furnace = albedo(&matt, DVec3::Z, tilted(0.3));
    assert!((furnace - matt.albedo).length() < 1e-5, "{furnace}");
}

#[test]
fn oren_nayar() {
    for roughness in [0.0, 0.1, 0.5, 1.0] {
        for albedo in [DVec3::ONE, DVec3::new(0.0, 0.3, 0.8)] {
            laws("Oren-Nayar", &OrenNayar { albedo, roughness });
        }
    }
}

#[test]
fn dust() {
    let surges = [Surge::NONE, Surge { strength: 1.0, width: 0.05 }];
    let peaks = [-0.6, -0.3, 0.4].map(|g| Phase::HenyeyGreenstein { g });
    for phase in [Phase::Constant, Phase::Ball].into_iter().chain(peaks) {
        for surge in surges {
            laws("dust", &Dust { albedo: DVec3::new(0.1, 0.3, 1.0), phase, surge });
        }
    }
}

#[test]
fn gloss() {
    let metal = Fresnel::Metal { facing: DVec3::new(1.0, 0.8, 0.3) };
    for fresnel in [metal, Fresnel::Dielectric { ior: 1.31 }] {
        for roughness in [0.35, 0.6, 1.0] {
            laws("gloss", &Gloss::new(roughness, fresnel));
        }
        pointwise("smooth gloss", &Gloss::new(0.05, fresnel));
    }
}

#[test]
fn coat() {
    for ior in [1.333, 1.5] {
        let film = film(ior);
        for roughness in [0.35, 0.6, 1.0] {
            laws("coat", &film.on(DVec3::new(0.05, 0.4, 1.0), roughness));
        }
        pointwise("smooth coat", &film.on(DVec3::splat(0.3), 0.0));
    }
}

#[test]
fn metal() {
    let metals = Metals::default();
    for facing in [DVec3::ONE, DVec3::new(1.0, 0.78, 0.34), DVec3::ZERO] {
        for roughness in [0.35, 0.6, 1.0] {
            laws("metal", &metals.of(facing, roughness));
        }
        pointwise("smooth metal", &metals.of(facing, 0.0));
    }
}

#[test]
fn no_sample_of_metal_weighs_much() {
    let metals = Metals::default();
    for roughness in [0.0, 0.035, 0.05, 0.1, 0.2, 0.5, 1.0] {
        let white = metals.of(DVec3::ONE, roughness);
        for mu in [0.005, 0.015, 0.05, 0.5] {
            for i in 0..4000 {
                let bounce = white.sample(point(mix(5), i, 0), DVec3::Z, tilted(mu));
                let weight = bounce.map_or(0.0, |bounce| bounce.weight.x);
                assert!(weight < 1.5, "{roughness} {mu}: {weight}");
            }
        }
    }
}
