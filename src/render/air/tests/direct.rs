//! The air against direct integration.

use super::*;

/// How far off light may be.
const OFF: f64 = 0.02;

/// Fog in which light from above is scattered twice on the way to the ground.
fn dense() -> Air {
    Air { fog: Some(haze(4000.0, 5e-4)), multiple: true, ..clear() }
}

/// Air of every kind.
fn all() -> [Air; 7] {
    [clear(), earth(), foggy(), dense(), thick(), preset("mars_air"), preset("titan_air")]
}

/// Of what is brightest of a colour, what its faintest may be off: on Titan there is a hundredth as much blue as red.
const FAINT: f64 = 1e-3;

#[test]
fn sunlight_agrees_with_direct_integration() {
    for (which, air) in all().iter().enumerate() {
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
    for (which, air) in all().iter().enumerate() {
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
    let twilight = [(1e-6, -3.0), (1e-4, -6.0)];
    for air in [earth(), foggy()] {
        let atmosphere = made(&air).unwrap();
        for (h, elevation) in by_day.into_iter().chain(twilight) {
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
                close(found, direct, OFF, 0.0),
                "{h} {elevation}: {found} for {direct}: {}",
                found / direct
            );
        }
    }
}

#[test]
fn several_turns_agree_with_direct_integration() {
    let by_day = [(1e-6, 60.0_f64), (4e-4, 20.0), (1e-3, 5.0), (4e-3, 35.0)];
    let twilight = [(1e-6, 0.3), (1e-6, -1.0), (1e-4, -3.0), (1e-6, -4.8), (1e-3, -6.0), (4e-3, -8.0)];
    several_turns_agree(&earth(), by_day.into_iter().chain(twilight));
    // Low, and between the heights at which light is kept.
    let low = [(1.3e-5, 10.0), (5e-5, 60.0), (1.4e-4, 30.0), (3.2e-4, 10.0), (5.4e-4, -3.0)];
    for air in [foggy(), thick(), preset("mars_air"), preset("titan_air")] {
        several_turns_agree(&air, by_day.into_iter().chain(low).chain(twilight));
    }
    several_turns_agree(&dense(), by_day.into_iter().chain(low));
}

fn several_turns_agree(air: &Air, places: impl IntoIterator<Item = (f64, f64)>) {
    let atmosphere = made(air).unwrap();
    let psi = atmosphere.tables.multiple.as_ref().unwrap();
    for (h, elevation) in places {
        let (r, sun): (f64, DVec3) = (1.0 + h, one_sun(elevation)[0].0);
        let (mut back, mut second, n) = (DVec3::ZERO, DVec3::ZERO, 40);
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
            for (p, ds) in pieces(r * DVec3::Y, direction, ground.min(0.8), 200) {
                let (scattering, extinction) = coefficients(air, p.length() - 1.0);
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
        let faint = 0.1 * FAINT * direct.max_element();
        assert!(close(found, direct, OFF, faint), "{h} {elevation}: {found} for {direct}");
    }
}

#[test]
fn ambient_light_is_the_mean_of_the_sky() {
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
    let earth = Air { ground: DVec3::new(0.5, 0.3, 0.1), ..earth() };
    ambient_light_is_the_mean(&earth, by_day.into_iter().chain(high_up).chain(twilight));
    for air in [dense(), preset("mars_air"), preset("titan_air")] {
        ambient_light_is_the_mean(&air, by_day.into_iter().chain(twilight));
    }
    ambient_light_is_the_mean(&foggy(), by_day);
}

fn ambient_light_is_the_mean(air: &Air, places: impl IntoIterator<Item = (f64, f64)>) {
    let atmosphere = made(air).unwrap();
    for (h, elevation) in places {
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
                let (light, through) = direct_light(&atmosphere, air, p, direction, length, suns[0].0, 300);
                if distance == f64::INFINITY {
                    return light;
                }
                let foot = (p + distance * direction).normalize();
                through * ground_light(&atmosphere, air, foot, &suns) + light
            };
            let weight = 2.0 * up * weight / (n * n) as f64;
            above += weight * light(up);
            below += weight * light(-up);
        }
        let found = atmosphere.ambient(p, DVec3::Y, &suns);
        for (found, light) in found.into_iter().zip([above, below]) {
            let faint = FAINT * light.max_element();
            assert!(close(found, light, OFF, faint), "{h} {elevation}: {found} for {light}");
        }
    }
}
