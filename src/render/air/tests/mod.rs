//! What the air must look like; and [`direct`], that it is what it should be.

mod direct;

use super::*;
use crate::scene::{Absorber, Haze};
use crate::script::{Request, compile};
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

/// The air that a function of the module of planets makes, over a planet of radius 1.
fn preset(name: &str) -> Air {
    let text =
        format!("import \"std/planet\" as planet; scene(#{{ surface: sphere(1.0), sky: planet::{name}() }})");
    compile(&Request::text(&text)).scene.unwrap().sky.air.unwrap()
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

/// Radiance of matt ground in sunlight and the light of the sky.
fn ground_light(atmosphere: &Atmosphere, air: &Air, up: DVec3, suns: &[(DVec3, DVec3)]) -> DVec3 {
    let (towards, irradiance) = suns[0];
    let direct = up.dot(towards).max(0.0) / PI * atmosphere.sunlight(up, towards);
    air.ground * (irradiance * direct + atmosphere.ambient(up, up, suns)[0])
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
