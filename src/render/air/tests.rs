//! The air against direct integration, and what it must look like.

use super::*;
use crate::scene::{Absorber, Haze};
use std::f64::consts::PI;

/// The atmosphere of some air, whatever time it takes.
fn made(air: &Air) -> Option<Atmosphere> {
    Atmosphere::new(air, &AtomicBool::new(false))
}

/// Metres in a planet of radius 1.
const EARTH: f64 = 6371e3;

fn haze(scattering: f64, height: f64) -> Haze {
    let (scattering, asymmetry) = (DVec3::splat(scattering), DVec3::splat(0.8));
    Haze { scattering, absorption: 0.11 * scattering, height, asymmetry }
}

/// Gas as of the Earth, with a radius of 1.
fn clear() -> Air {
    Air::clear(1.0, 8e3 / EARTH, DVec3::new(5.8, 13.5, 33.1) * 1e-6 * EARTH)
}

/// All there is over the Earth.
fn earth() -> Air {
    Air {
        haze: Some(haze(4e-6 * EARTH, 1200.0 / EARTH)),
        absorber: Some(Absorber {
            absorption: DVec3::new(0.650, 1.881, 0.085) * 1e-6 * EARTH,
            center: 25e3 / EARTH,
            width: 15e3 / EARTH,
        }),
        multiple: true,
        ..clear()
    }
}

/// With a low and thick fog besides.
fn foggy() -> Air {
    Air { fog: Some(haze(2e-3 * EARTH, 40.0 / EARTH)), ..earth() }
}

/// A small world in thick air, more than it has room for.
fn thick() -> Air {
    let layer = Haze { asymmetry: DVec3::splat(0.6), ..haze(30.0, 0.03) };
    Air { haze: Some(layer), multiple: true, ..Air::clear(1.0, 0.01, DVec3::new(3.0, 8.0, 20.0)) }
}

/// Density of each kind, written down anew.
fn density(air: &Air, h: f64) -> [f64; 4] {
    let layer = |haze: Option<Haze>| haze.map_or(0.0, |l| (-h.max(0.0) / l.height).exp());
    let tent = air.absorber.map_or(0.0, |a| (1.0 - (h - a.center).abs() / a.width).max(0.0));
    [(-h / air.height).exp(), layer(air.haze), layer(air.fog), tent]
}

fn coefficients(air: &Air, h: f64) -> (DVec3, DVec3) {
    let [gas, haze, fog, ozone] = density(air, h);
    let layer = |l: Option<Haze>| l.map_or([DVec3::ZERO; 2], |l| [l.scattering, l.scattering + l.absorption]);
    let ([hs, he], [fs, fe]) = (layer(air.haze), layer(air.fog));
    let scattering = gas * air.scattering + haze * hs + fog * fs;
    let extinction = gas * air.scattering + haze * he + fog * fe;
    (scattering, extinction + ozone * air.absorber.map_or(DVec3::ZERO, |a| a.absorption))
}

/// Points in the middle of many pieces of a line, and their lengths: finer where they are low.
fn pieces(from: DVec3, direction: DVec3, length: f64, n: usize) -> impl Iterator<Item = (DVec3, f64)> {
    let low = (-from.dot(direction)).clamp(0.0, length);
    let at = move |i: usize| {
        let u = 2.0 * i as f64 / n as f64 - 1.0;
        if u < 0.0 { low - low * u.abs().powi(3) } else { low + (length - low) * u.powi(3) }
    };
    (0..n).map(move |i| (from + 0.5 * (at(i) + at(i + 1)) * direction, at(i + 1) - at(i)))
}

/// Transmittance of a line, integrated directly.
fn direct_transmittance(air: &Air, from: DVec3, direction: DVec3, length: f64) -> DVec3 {
    let depth: DVec3 = pieces(from, direction, length, 20_000)
        .map(|(p, ds)| coefficients(air, p.length() - air.radius).1 * ds)
        .sum();
    (-depth).exp()
}

/// Numbers in [0, 1) by a hash.
fn random(i: u64) -> f64 {
    crate::num::uniform(crate::num::mix(i))
}

fn at_angle(cosine: f64) -> DVec3 {
    DVec3::new((1.0 - cosine * cosine).sqrt(), cosine, 0.0)
}

fn one_sun(elevation: f64) -> [(DVec3, DVec3); 1] {
    [(at_angle(elevation.to_radians().sin()), DVec3::ONE)]
}

/// How far off light may be: below six degrees under the horizon there is but a thousandth of the light of day.
fn within(elevation: f64) -> f64 {
    if elevation >= -6.0 { 0.02 } else { 0.03 }
}

fn close(a: DVec3, b: DVec3, relative: f64, absolute: f64) -> bool {
    (a - b).abs().cmple(relative * b.abs() + absolute).all()
}

#[test]
fn zenith_and_horizon() {
    let atmosphere = made(&clear()).unwrap();
    let zenith = atmosphere.sunlight(DVec3::Y, DVec3::Y);
    assert!(close(zenith, (-DVec3::new(0.0464, 0.108, 0.2648)).exp(), 1e-3, 0.0), "{zenith}");
    let mass = |mu: f64| -atmosphere.along(DVec3::Y, at_angle(mu), 1e9, &[], 0.5, &[]).transmittance.x.ln();
    // Air mass at the horizon of an atmosphere that does not bend light.
    assert!((mass(0.0) / mass(1.0) - 35.4).abs() < 0.4, "{}", mass(0.0) / mass(1.0));
}

#[test]
fn sunlight_agrees_with_direct_integration() {
    for (which, air) in [clear(), earth(), foggy(), thick()].iter().enumerate() {
        let atmosphere = made(air).unwrap();
        let top = atmosphere.medium.shell.top;
        for i in 0..150 {
            // Half of the points are near the ground; a few are below it.
            let r = 1.0 + (top - 1.0) * (random(3 * i).powi(6) - 0.002);
            let horizon = -(1.0 - (1.0 / r).min(1.0).powi(2)).sqrt() + 0.006;
            let mu = horizon + (1.0 - horizon) * random(3 * i + 1).powi(3);
            let sun = at_angle(mu);
            let length = -r * mu + (top * top - r * r * (1.0 - mu * mu)).sqrt();
            let direct = direct_transmittance(air, r * DVec3::Y, sun, length);
            let found = atmosphere.sunlight(r * DVec3::Y, sun);
            assert!(close(found, direct, 0.01, 1e-4), "{which}: {found} for {direct} at {r}, {mu}");
        }
    }
}

/// Radiance that the air sends along a line of sight, integrated directly from the sunlight and the light that is scattered
/// more than once at its points, and the share of light that gets through.
fn direct_light(
    atmosphere: &Atmosphere,
    air: &Air,
    eye: DVec3,
    direction: DVec3,
    length: f64,
    sun: DVec3,
    n: usize,
) -> (DVec3, DVec3) {
    let phases = Phases::new(&atmosphere.medium, direction.dot(sun));
    let (mut depth, mut light) = (DVec3::ZERO, DVec3::ZERO);
    for (p, ds) in pieces(eye, direction, length, n) {
        let h = p.length() - air.radius;
        let [gas, haze, fog, _] = density(air, h);
        let by = |l: Option<Haze>| l.map_or(DVec3::ZERO, |l| l.scattering);
        let yields = [gas * air.scattering, haze * by(air.haze), fog * by(air.fog)];
        let half = 0.5 * ds * coefficients(air, h).1;
        depth += half;
        let psi = atmosphere.tables.multiple.as_ref().map_or(DVec3::ZERO, |psi| psi.to(p, sun));
        light += ds * (-depth).exp() * phases.scattered(&yields, atmosphere.sunlight(p, sun), psi);
        depth += half;
    }
    (light, (-depth).exp())
}

/// Points of the steps along lines of sight that are tried.
const JITTERS: u32 = 16;

#[test]
fn lines_of_sight_agree_with_direct_integration() {
    for (which, air) in [clear(), earth(), foggy(), thick()].iter().enumerate() {
        let air = Air { multiple: false, ..*air };
        let atmosphere = made(&air).unwrap();
        for i in 0..40 {
            let r = 1.0 + 0.01 * random(7 * i).powi(6);
            let direction = at_angle(0.02 + 0.9 * random(7 * i + 1).powi(2));
            let length = if i % 2 == 0 { 1.0 } else { 0.001 + 0.05 * random(7 * i + 2) };
            let eye = r * DVec3::Y;
            let around = 2.0 * PI * random(7 * i + 3);
            let high = -0.05 + 1.05 * random(7 * i + 4).powi(2);
            let low = (1.0 - high * high).sqrt();
            let sun = DVec3::new(low * around.cos(), high, low * around.sin());
            let (light, through) = direct_light(&atmosphere, &air, eye, direction, length, sun, 4000);
            // On average over the points of the steps.
            let seen = (0..JITTERS).map(|j| (f64::from(j) + 0.5) / f64::from(JITTERS));
            let seen = seen.map(|jitter| {
                let seen = atmosphere.along(eye, direction, length, &[(sun, DVec3::ONE)], jitter, &[]);
                assert!(
                    close(seen.transmittance, through, 0.0, 2e-3),
                    "{which}, {i}: {seen:?} for {through}"
                );
                seen.scattered
            });
            let seen = seen.sum::<DVec3>() / f64::from(JITTERS);
            assert!(
                close(seen, light, 0.02, 1e-5),
                "{which}, {i}, {high}: {seen} for {light}: {}",
                seen / light
            );
        }
    }
}

#[test]
fn the_sky_that_paths_escape_to_agrees_with_direct_integration() {
    let by_day = [(1e-6, 40.0), (1e-4, 10.0), (1e-3, 2.0), (1e-6, 0.0)];
    for (air, twilight) in [(earth(), &[(1e-6, -3.0), (1e-4, -6.0)][..]), (foggy(), &[])] {
        let atmosphere = made(&air).unwrap();
        for &(h, elevation) in by_day.iter().chain(twilight) {
            let (p, suns) = ((1.0 + h) * DVec3::Y, one_sun(elevation));
            // Weighted as by level ground.
            let (mut found, mut direct, n) = (DVec3::ZERO, DVec3::ZERO, 24);
            for i in 0..n * n {
                let [up, around] = [i / n, i % n].map(|i| (i as f64 + 0.5) / n as f64);
                let (up, weight) = (up * up, 4.0 * up.powi(3) / (n * n) as f64);
                let (flat, around) = ((1.0 - up * up).sqrt(), PI * around);
                let direction = DVec3::new(flat * around.cos(), up, flat * around.sin());
                found += weight * atmosphere.sky(p, direction, &suns);
                direct += weight * direct_light(&atmosphere, &air, p, direction, 0.8, suns[0].0, 600).0;
            }
            assert!(
                close(found, direct, 0.02, 0.0),
                "{h} {elevation}: {found} for {direct}: {}",
                found / direct
            );
        }
    }
}

#[test]
fn several_turns_agree_with_direct_integration() {
    let air = earth();
    let atmosphere = made(&air).unwrap();
    let psi = atmosphere.tables.multiple.as_ref().unwrap();
    let by_day = [(1e-6, 60.0_f64), (4e-4, 20.0), (1e-3, 5.0), (4e-3, 35.0)];
    let twilight = [(1e-6, 0.3), (1e-6, -1.0), (1e-4, -3.0), (1e-6, -4.8), (1e-3, -6.0), (4e-3, -8.0)];
    for (h, elevation) in by_day.into_iter().chain(twilight) {
        let (r, sun): (f64, DVec3) = (1.0 + h, one_sun(elevation)[0].0);
        let (mut back, mut second, n) = (DVec3::ZERO, DVec3::ZERO, 60);
        let horizon = -(1.0 - (1.0 / r).powi(2)).sqrt();
        for i in 0..2 * n * n {
            // Above and below in turn, and dense towards the horizon.
            let (t, around) = (((i / 2 / n) as f64 + 0.5) / n as f64, ((i / 2 % n) as f64 + 0.5) / n as f64);
            let span = [1.0 - horizon, -1.0 - horizon][i % 2];
            let (mu, share) = (horizon + span * (t * t), span.abs() * t / (n * n) as f64);
            let flat = (1.0 - mu * mu).sqrt();
            let direction = DVec3::new(flat * (PI * around).cos(), mu, flat * (PI * around).sin());
            let ground = to_ground(1.0, r * DVec3::Y, direction);
            let mut depth = DVec3::ZERO;
            for (p, ds) in pieces(r * DVec3::Y, direction, ground.min(0.8), 300) {
                let (scattering, extinction) = coefficients(&air, p.length() - 1.0);
                let weight = share * ds * scattering * (-(depth + 0.5 * ds * extinction)).exp();
                back += weight;
                second += weight * atmosphere.sunlight(p, sun) / (4.0 * PI);
                depth += ds * extinction;
            }
            if ground.is_finite() {
                let p = r * DVec3::Y + ground * direction;
                let falls = p.dot(sun).max(0.0) * atmosphere.sunlight(p, sun);
                second += share * (-depth).exp() * air.ground / PI * falls;
            }
        }
        let (direct, found) = (second / (1.0 - back), psi.at(r, sun.y));
        assert!(close(found, direct, within(elevation), 0.0), "{h} {elevation}: {found} for {direct}");
    }
}

/// Radiance of matt ground in sunlight and the light of the sky.
fn ground_light(atmosphere: &Atmosphere, air: &Air, up: DVec3, suns: &[(DVec3, DVec3)]) -> DVec3 {
    let (towards, irradiance) = suns[0];
    let direct = up.dot(towards).max(0.0) / PI * atmosphere.sunlight(up, towards);
    air.ground * (irradiance * direct + atmosphere.ambient(up, up, suns)[0])
}

#[test]
fn ambient_light_is_the_mean_of_the_sky() {
    let air = Air { ground: DVec3::new(0.5, 0.3, 0.1), ..earth() };
    let atmosphere = made(&air).unwrap();
    let by_day =
        [(1e-6, 70.0), (1e-6, 25.0), (1e-6, 3.0), (1e-6, 0.5), (1e-5, 30.0), (1e-4, 30.0), (5e-4, 40.0)];
    let high_up = [(1e-3, 5.0), (2e-3, 10.0), (4e-3, 50.0), (8e-3, 20.0)];
    let twilight = [
        (1e-6, 0.0),
        (1e-6, -1.0),
        (1e-6, -3.0),
        (1e-3, -3.0),
        (1e-6, -4.4),
        (1e-4, -5.0),
        (1e-6, -6.0),
        (1e-6, -8.0),
    ];
    for (h, elevation) in by_day.into_iter().chain(high_up).chain(twilight) {
        let (p, suns) = ((1.0 + h) * DVec3::Y, one_sun(elevation));
        let (mut above, mut below, n) = (DVec3::ZERO, DVec3::ZERO, 60);
        for i in 0..n * n {
            let [up, around] = [i / n, i % n].map(|i| (i as f64 + 0.5) / n as f64);
            // Squared towards the horizon, where the light changes most.
            let (up, weight) = (up * up, 2.0 * up);
            let (flat, around) = ((1.0 - up * up).sqrt(), PI * around);
            let light = |up: f64| {
                let direction = DVec3::new(flat * around.cos(), up, flat * around.sin());
                let distance = to_ground(1.0, p, direction);
                let length = distance.min(0.8);
                let (light, through) = direct_light(&atmosphere, &air, p, direction, length, suns[0].0, 300);
                if distance == f64::INFINITY {
                    return light;
                }
                let foot = (p + distance * direction).normalize();
                through * ground_light(&atmosphere, &air, foot, &suns) + light
            };
            let weight = 2.0 * up * weight / (n * n) as f64;
            above += weight * light(up);
            below += weight * light(-up);
        }
        let found = atmosphere.ambient(p, DVec3::Y, &suns);
        for (found, light) in found.into_iter().zip([above, below]) {
            assert!(close(found, light, within(elevation), 0.0), "{h} {elevation}: {found} for {light}");
        }
    }
}

#[test]
fn the_sky_ends_on_the_ground() {
    let air = Air { ground: DVec3::new(0.5, 0.3, 0.1), ..earth() };
    let (atmosphere, black) = (made(&air).unwrap(), made(&Air { ground: DVec3::ZERO, ..air }).unwrap());
    let (p, suns) = (1.001 * DVec3::Y, one_sun(40.0));
    let through = direct_transmittance(&air, p, DVec3::NEG_Y, 0.001);
    let light = atmosphere.sky(p, DVec3::NEG_Y, &suns) - black.sky(p, DVec3::NEG_Y, &suns);
    // What black ground does not send up again is missing in the air, too.
    assert!(close(light, through * ground_light(&atmosphere, &air, DVec3::Y, &suns), 0.08, 0.0));
    assert_eq!(black.sky(DVec3::Y, DVec3::NEG_Y, &suns), DVec3::ZERO);
}

#[test]
fn there_is_next_to_no_light_above_a_low_layer() {
    let fog = haze(2e-3 * EARTH, 40.0 / EARTH);
    let atmosphere =
        made(&Air { scattering: DVec3::ZERO, fog: Some(fog), ground: DVec3::ZERO, ..clear() }).unwrap();
    for heights in [5.0, 10.0, 20.0, 40.0] {
        let p = (1.0 + heights * fog.height) * DVec3::Y;
        let [above, below] = atmosphere.ambient(p, DVec3::Y, &one_sun(40.0));
        let scattering = fog.scattering.x * fog.height * f64::exp(-heights);
        assert!(above.min_element() >= 0.0 && above.max_element() < scattering, "{heights}: {above}");
        // Slantwise, twice an optical depth of 0.08 by a phase function of about 0.007.
        assert!(below.min_element() > 0.0008 && below.max_element() < 0.002, "{heights}: {below}");
    }
}

#[test]
fn no_air_gives_back_more_than_it_takes() {
    // What leaves the whole planet in all directions, of what falls on the disc of its air.
    for (which, air) in [earth(), thick()].iter().enumerate() {
        let white =
            Air { haze: air.haze.map(|l| Haze { absorption: DVec3::ZERO, ..l }), absorber: None, ..*air };
        let atmosphere = made(&white).unwrap();
        let top = atmosphere.medium.shell.top;
        let (mut leaves, n) = (DVec3::ZERO, 24);
        for i in 0..n {
            // Directions to the eye, about the sun.
            let towards = at_angle(2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
            let side = DVec3::Z.cross(towards);
            for j in 0..n * n {
                let radius = top * ((f64::from(j / n) + 0.5) / f64::from(n)).sqrt();
                let angle = 2.0 * PI * (f64::from(j % n) + 0.5) / f64::from(n);
                let eye = 10.0 * towards + radius * (angle.cos() * side + angle.sin() * DVec3::Z);
                let ground = to_ground(1.0, eye, -towards);
                let sun = [(DVec3::Y, DVec3::ONE)];
                leaves += atmosphere.along(eye, -towards, ground, &sun, 0.5, &[]).scattered;
            }
        }
        let share = leaves * 4.0 * PI / f64::from(n * n * n);
        assert!(share.max_element() < 1.0 && share.min_element() > 0.01, "{which}: {share}");
    }
}

#[test]
fn single_scattering_is_darker_by_a_third_at_noon() {
    let suns = one_sun(70.0);
    let light = |multiple: bool| {
        let atmosphere = made(&Air { multiple, ..earth() }).unwrap();
        atmosphere.ambient(DVec3::Y, DVec3::Y, &suns)[0]
    };
    let luminance = |c: DVec3| c.dot(DVec3::new(0.2126, 0.7152, 0.0722));
    let share = luminance(light(false)) / luminance(light(true));
    assert!((0.6..0.8).contains(&share), "{share}");
}

#[test]
fn halves_of_a_ray_compose() {
    for air in [earth(), foggy()] {
        let atmosphere = made(&air).unwrap();
        let (eye, direction, suns) = (DVec3::new(-3.0, 1.002, 0.0), DVec3::X, one_sun(30.0));
        let look = |eye: DVec3, d: f64| atmosphere.along(eye, direction, d, &suns, 0.5, &[]);
        let (whole, near) = (look(eye, f64::INFINITY), look(eye, 2.98));
        let far = look(eye + 2.98 * direction, f64::INFINITY);
        assert!(close(near.transmittance * far.transmittance, whole.transmittance, 0.0, 1e-3));
        let both = near.scattered + near.transmittance * far.scattered;
        assert!(close(both, whole.scattered, 0.02, 0.0), "{both} {whole:?}");
    }
}

#[test]
fn the_sky_has_its_colours() {
    let atmosphere = made(&earth()).unwrap();
    let eye = DVec3::Y * 1.000_001;
    let look = |mu: f64, elevation: f64| {
        let away = at_angle(mu) * DVec3::new(-1.0, 1.0, 1.0);
        atmosphere.along(eye, away, f64::INFINITY, &one_sun(elevation), 0.5, &[]).scattered
    };
    let (zenith, horizon) = (look(1.0, 40.0), look(0.01, 40.0));
    assert!(zenith.z > 2.0 * zenith.y && zenith.y > 1.5 * zenith.x, "blue above: {zenith}");
    assert!(horizon.z < 1.5 * horizon.x && horizon.min_element() > 2.0 * zenith.z, "white below: {horizon}");
    let sunlight = atmosphere.sunlight(eye, one_sun(0.5)[0].0);
    assert!(sunlight.x > 3.0 * sunlight.y && sunlight.y > 10.0 * sunlight.z, "red low sun: {sunlight}");
    // Ozone keeps the zenith blue at dusk; without it grazing sunlight would turn it grey.
    let (dusk, night) = (look(1.0, -4.0), look(1.0, -30.0));
    assert!(dusk.z > 1.3 * dusk.y && dusk.z < 0.1 * zenith.z && dusk.z > 0.0, "{dusk}");
    assert!(night.max_element() < 1e-9, "{night}");
}

#[test]
fn a_planet_has_a_rim_and_a_terminator() {
    let atmosphere = made(&earth()).unwrap();
    let sun = [(DVec3::X, DVec3::ONE)];
    let rim = |side: f64, h: f64| {
        let eye = DVec3::new(side * (1.0 + h), 0.0, 5.0);
        atmosphere.along(eye, DVec3::NEG_Z, f64::INFINITY, &sun, 0.5, &[])
    };
    let day = rim(1.0, 0.003).scattered;
    assert!(day.z > 1.5 * day.x && day.x > 0.0, "{day}");
    assert!(rim(-1.0, 0.003).scattered.max_element() < 1e-6);
    assert_eq!(rim(1.0, 0.05), Seen { transmittance: DVec3::ONE, scattered: DVec3::ZERO });
    // The edge of the shadow on the ground is as wide as the sun.
    let lit = |degrees: f64| atmosphere.sunlight(DVec3::Y, one_sun(degrees)[0].0).x;
    assert!(lit(0.3) > lit(0.1) && lit(0.1) > lit(-0.1) && lit(-0.1) > 0.0);
    assert_eq!(lit(-0.3), 0.0);
    // Beyond the air there is an umbra, too.
    let (behind, beside) = (DVec3::new(-3.0, 0.5, 0.0), DVec3::new(-3.0, 1.5, 0.0));
    assert_eq!(atmosphere.sunlight(behind, DVec3::X), DVec3::ZERO);
    assert_eq!(atmosphere.sunlight(beside, DVec3::X), DVec3::ONE);
}

#[test]
fn the_way_into_the_air_is_smooth() {
    let atmosphere = made(&foggy()).unwrap();
    let suns = one_sun(30.0);
    let look = |r: f64, mu: f64| {
        let ground = to_ground(1.0, r * DVec3::Y, at_angle(mu));
        atmosphere.along(r * DVec3::Y, at_angle(mu), ground, &suns, 0.5, &[]).scattered
    };
    let top = atmosphere.medium.shell.top;
    for r in [1.0, 1.001, top] {
        for mu in [-0.5, 0.3] {
            let (a, b) = (look(r - 1e-9, mu), look(r + 1e-9, mu));
            assert!(close(a, b, 1e-3, 2e-6), "{r} {mu}: {a} {b}");
        }
    }
}

#[test]
fn there_are_no_bands_at_eye_level() {
    let atmosphere = made(&earth()).unwrap();
    let (eye, suns) = (DVec3::Y * (1.0 + 2.0 / EARTH), one_sun(20.0));
    let look = |degrees: f64| {
        let direction = at_angle(degrees.to_radians().sin());
        atmosphere.along(eye, direction, f64::INFINITY, &suns, 0.5, &[]).scattered
    };
    // Across a picture of a thousand lines, the light changes less from line to line than eight bits tell
    // apart, or else it changes evenly.
    let lines: Vec<DVec3> = (0..1000).map(|i| look(0.02 + 0.02 * f64::from(i))).collect();
    for w in lines.windows(3) {
        let bend = (w[0] - 2.0 * w[1] + w[2]).abs() / w[1];
        assert!(bend.max_element() < 2e-3, "{w:?}");
    }
}

#[test]
fn terrain_hides_the_sun_but_not_the_sky() {
    for multiple in [false, true] {
        let atmosphere = made(&Air { multiple, ..earth() }).unwrap();
        let (eye, direction, suns) = (DVec3::Y * 1.0001, at_angle(0.1), one_sun(20.0));
        let mut nodes = Vec::new();
        atmosphere.nodes(eye, direction, 0.01, 0.3, &mut nodes);
        let far = |p: &DVec3| (*p - eye).dot(direction);
        assert!(nodes.len() == 16 && nodes.windows(2).all(|w| far(&w[0]) < far(&w[1])));
        assert!(far(&nodes[0]) > 0.0 && far(&nodes[15]) < 0.01);
        let look = |visible: &[f64]| atmosphere.along(eye, direction, 0.01, &suns, 0.3, visible).scattered;
        let (lit, dark) = (look(&[]), look(&[0.0; 16]));
        assert_eq!(look(&[1.0; 16]), lit);
        assert_eq!(dark.max_element() > 0.0, multiple);
        assert!(dark.cmplt(0.7 * lit).all());
        let mut shaft = [1.0; 16];
        shaft[3] = 0.0;
        assert!(look(&shaft).cmplt(lit).all() && look(&shaft).cmpgt(dark).all());
        // A second sun is not hidden by what hides the first.
        let two = [suns[0], (DVec3::Y, DVec3::ONE)];
        let both = atmosphere.along(eye, direction, 0.01, &two, 0.3, &[0.0; 16]).scattered;
        let second = atmosphere.along(eye, direction, 0.01, &two[1..], 0.3, &[]).scattered;
        assert!(close(both, dark + second, 1e-12, 0.0));
    }
}

#[test]
fn nothing_is_lit_outside_of_the_air() {
    let atmosphere = made(&earth()).unwrap();
    let mut nodes = Vec::new();
    atmosphere.nodes(2.0 * DVec3::Y, DVec3::Y, f64::INFINITY, 0.5, &mut nodes);
    atmosphere.nodes(2.0 * DVec3::Y, DVec3::NEG_Y, 0.5, 0.5, &mut nodes);
    assert!(nodes.is_empty());
    // From beyond, all of them are within.
    atmosphere.nodes(2.0 * DVec3::Y, DVec3::NEG_Y, 0.999, 0.5, &mut nodes);
    assert!(nodes.len() == 16 && nodes.iter().all(|p| p.y < atmosphere.medium.shell.top && p.y > 1.001));
}

#[test]
fn odd_air_is_no_air() {
    let (air, grain) = (earth(), haze(1.0, 0.01));
    assert!(made(&Air { height: 0.0, ..air }).is_none());
    assert!(made(&Air { height: f64::NAN, ..air }).is_none());
    assert!(made(&Air { radius: f64::INFINITY, ..air }).is_none());
    assert!(made(&Air { scattering: DVec3::new(1.0, -1.0, 1.0), ..air }).is_none());
    assert!(made(&Air { fog: Some(Haze { height: -1.0, ..grain }), ..air }).is_none());
    assert!(made(&Air { fog: Some(Haze { asymmetry: DVec3::ONE, ..grain }), ..air }).is_none());
    assert!(made(&Air { scattering: DVec3::ZERO, ..clear() }).is_none());
}

#[test]
fn what_only_absorbs_is_black() {
    let atmosphere = made(&Air { scattering: DVec3::ZERO, haze: None, ..earth() }).unwrap();
    let seen = atmosphere.along(DVec3::Y, DVec3::Y, f64::INFINITY, &one_sun(50.0), 0.5, &[]);
    assert_eq!(seen.scattered, DVec3::ZERO);
    // 15 km of the middle's density.
    assert!((-seen.transmittance.y.ln() / (15e3 * 1.881e-6) - 1.0).abs() < 0.02, "{seen:?}");
}
