//! Stars behind everything: as many, as bright and of such colours as the naked eye sees from the Earth, in
//! places of their own.
//!
//! The sphere is cut into rings of equal height in angle, and these into cells that are about square, so
//! that a cell's stars depend on nothing but its number. A direction looks into the cells around it.
//! Magnitudes follow the counts of star catalogues, `N(m) ~ 10^(0.51 m)` stars brighter than `m`, of which
//! 9000 are above magnitude 6.5 all around (Allen's Astrophysical Quantities, 4th edition, section 19.2).
//!
//! A star is a point, which no picture shows. It is drawn as a smooth dot of the irradiance that it has:
//! a few arc minutes wide, as in an eye or a lens, or as wide as a few pixels where those are wider. So it
//! lands in some sample of every picture, and is as bright in a small one as in a large one.

use crate::num::{mix, uniform};
use glam::DVec3;
use std::f64::consts::PI;

/// Rings from pole to pole.
const RINGS: usize = 128;

/// Stars that are brighter than [`FAINTEST`], all around.
const COUNT: f64 = 9000.0;

/// The magnitude at which stars end.
const FAINTEST: f64 = 6.5;

/// How fast counts grow: the logarithm to base ten, by magnitude.
const GROWTH: f64 = 0.51;

/// Radius of a star's dot: 2 arc minutes.
const RADIUS: f64 = 2.0 / 60.0 * PI / 180.0;

/// Radius of a star's dot in pixels, where that is more.
const PIXELS: f64 = 1.5;

/// Radiance in the middle of a star of magnitude 0 with the smallest dot, at brightness 1.
const BRIGHTEST: f64 = 10.0;

/// Radiance of the stars in the direction of a unit vector, seen in a pixel that is `pixel` radians wide.
///
/// At brightness 1 a star of magnitude 0 has the radiance 10 in the middle: pictures of the night as people
/// take them. Beside a sun of irradiance 3, true stars have a brightness of about 2e-5.
pub fn radiance(direction: DVec3, pixel: f64, brightness: f64) -> DVec3 {
    // No wider than a ring, for only neighbouring cells are looked into.
    let radius = RADIUS.max(PIXELS * pixel).min(PI / RINGS as f64);
    let angle = libm::acos(direction.y.clamp(-1.0, 1.0));
    let ring = ((angle / PI * RINGS as f64) as usize).min(RINGS - 1);
    let around = 0.5 + libm::atan2(direction.z, direction.x) / (2.0 * PI);
    let mut sum = DVec3::ZERO;
    for ring in ring.saturating_sub(1)..=(ring + 1).min(RINGS - 1) {
        let cells = cells(ring);
        let cell = (around * cells as f64) as usize + cells;
        // Near a pole a ring has three cells, which are all of them.
        for cell in [cell - 1, cell, cell + 1] {
            if let Some(star) = Star::of(ring, cell % cells) {
                let q = (star.direction - direction).length_squared() / (radius * radius);
                let smooth = (1.0 - q).max(0.0);
                sum += star.light * (smooth * smooth * smooth);
            }
        }
    }
    let share = RADIUS / radius;
    sum * (brightness * BRIGHTEST * share * share)
}

/// A star, if its cell has one.
struct Star {
    direction: DVec3,
    /// Relative to magnitude 0.
    light: DVec3,
}

impl Star {
    /// The star in a cell of a ring.
    fn of(ring: usize, cell: usize) -> Option<Star> {
        let cells = cells(ring) as f64;
        let edge = |ring: usize| libm::cos(PI * ring as f64 / RINGS as f64);
        let (top, bottom) = (edge(ring), edge(ring + 1));
        // Of as many stars as cells have on average, a cell shows one; a second would be next to it.
        let expected = COUNT / 2.0 * (top - bottom) / cells;
        let random = |what: u64| uniform(mix(mix((ring as u64) << 32 | cell as u64) ^ what));
        if random(0) >= expected {
            return None;
        }
        let y = top + (bottom - top) * random(1);
        let around = 2.0 * PI * ((cell as f64 + random(2)) / cells - 0.5);
        let flat = ((1.0 - y) * (1.0 + y)).sqrt();
        let direction = DVec3::new(flat * libm::cos(around), y, flat * libm::sin(around));
        // The magnitude below which a random share of the stars lies.
        let magnitude = FAINTEST + libm::log10(random(3).max(1e-9)) / GROWTH;
        // As many hot stars as cool ones, by the inverse of the temperature: 3500 to 15000 kelvins.
        let temperature = 1.0 / (1.0 / 15_000.0 + random(4) * (1.0 / 3500.0 - 1.0 / 15_000.0));
        Some(Star { direction, light: color(temperature) * libm::exp10(-0.4 * magnitude) })
    }
}

/// Cells of a ring.
fn cells(ring: usize) -> usize {
    let middle = PI * (ring as f64 + 0.5) / RINGS as f64;
    ((2.0 * RINGS as f64 * libm::sin(middle)) as usize).max(3)
}

/// Colour of a black body of a temperature in kelvins, of luminance 1: Planck's law at the wavelengths of
/// the primaries, in relation to daylight's 6500 kelvins, which is white.
fn color(temperature: f64) -> DVec3 {
    /// Planck's second radiation constant over the wavelengths 611, 549 and 464 nm.
    const SCALE: [f64; 3] = [23_547.0, 26_207.0, 31_008.0];
    let planck = |i: usize, t: f64| 1.0 / libm::expm1(SCALE[i] / t);
    let rgb = DVec3::from_array(std::array::from_fn(|i| planck(i, temperature) / planck(i, 6500.0)));
    rgb / rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Star> {
        (0..RINGS).flat_map(|ring| (0..cells(ring)).filter_map(move |cell| Star::of(ring, cell))).collect()
    }

    #[test]
    fn there_are_as_many_as_expected_everywhere() {
        let stars = all();
        let within = |low: f64, high: f64| {
            stars.iter().filter(|s| (low..high).contains(&s.direction.y)).count() as f64
        };
        assert!((stars.len() as f64 / COUNT - 1.0).abs() < 0.05, "{}", stars.len());
        for i in 0..10 {
            let low = f64::from(i) / 5.0 - 1.0;
            assert!((within(low, low + 0.2) / (0.1 * COUNT) - 1.0).abs() < 0.12);
        }
        // About twenty of the first magnitude.
        let luminance = |s: &Star| s.light.dot(DVec3::new(0.2126, 0.7152, 0.0722));
        let bright = stars.iter().filter(|s| luminance(s) > libm::exp10(-0.6)).count();
        assert!((10..50).contains(&bright), "{bright}");
    }

    #[test]
    fn pixels_do_not_change_the_light_of_a_star() {
        let stars = all();
        let star = stars.iter().max_by(|a, b| a.light.y.total_cmp(&b.light.y)).unwrap();
        let across = star.direction.any_orthonormal_pair();
        let flux = |pixel: f64| {
            let (n, half) = (100, 3.0 * pixel + 1e-3);
            let step = 2.0 * half / f64::from(n);
            let at = |i: i32| step * (f64::from(i) + 0.5) - half;
            let places = (0..n * n).map(|i| star.direction + at(i / n) * across.0 + at(i % n) * across.1);
            places.map(|p| radiance(p.normalize(), pixel, 1.0).y * step * step).sum::<f64>()
        };
        let (fine, coarse) = (flux(1e-4), flux(2e-3));
        assert!((coarse / fine - 1.0).abs() < 0.1, "{fine} {coarse}");
    }

    #[test]
    fn there_is_no_seam() {
        // All neighbours are found: the light of a star does not depend on the side from which it is seen.
        for star in all().iter().step_by(7) {
            let across = star.direction.any_orthonormal_pair();
            for side in [across.0, -across.0, across.1, -across.1] {
                let near = (star.direction + 0.9 * RADIUS * side).normalize();
                let least = star.light * BRIGHTEST * 0.19f64.powi(3) * 0.99;
                assert!(radiance(near, 0.0, 1.0).cmpge(least).all());
            }
        }
    }

    #[test]
    fn hot_stars_are_blue() {
        let (cool, white, hot) = (color(3500.0), color(6500.0), color(15_000.0));
        assert!((white - DVec3::ONE).abs().max_element() < 1e-12);
        assert!(cool.x > 1.3 * cool.y && cool.y > 1.3 * cool.z && hot.z > 1.3 * hot.x);
    }
}
