//! Rays all around a point, for the tables of light that comes from everywhere.
//!
//! Where nothing but shells is in the way, a ray is known by its radius and its cosine to the vertical,
//! and what it meets does not depend on the sun. So each ray is followed once, and then lit by suns at
//! all heights and on all sides.

use super::line::{Count, Line};
use super::march::{Step, march_evenly};
use super::medium::Medium;
use glam::DVec3;
use std::f64::consts::PI;

/// A ray from a point on the y axis, in the plane of x and y.
pub(super) struct Ray {
    /// Its direction.
    pub direction: DVec3,
    /// Share of the sphere of directions that it stands for: a ring around the vertical.
    pub share: f64,
    /// What it goes through.
    pub steps: Vec<Step>,
    /// Where it meets the ground, and the share of light that comes back from there.
    pub ground: Option<(DVec3, DVec3)>,
}

/// Rays from the radius `r` in so many directions above the horizon, and so many below, each in so many steps.
pub(super) fn rays(medium: &Medium, r: f64, [above, below]: [usize; 2], steps: Count) -> Vec<Ray> {
    let sine = (medium.shell.radius / r).min(1.0);
    let horizon = -((1.0 - sine) * (1.0 + sine)).sqrt();
    let mut rays = Vec::with_capacity(above + below);
    for (count, pole) in [(above, 1.0), (below, -1.0)] {
        for (x, weight) in gauss(count) {
            // Squared towards the horizon, where the light changes most.
            let span = pole - horizon;
            rays.push(ray(medium, r, horizon + span * (x * x), span.abs() * x * weight, steps));
        }
    }
    rays
}

fn ray(medium: &Medium, r: f64, mu: f64, share: f64, steps: Count) -> Ray {
    let direction = DVec3::new(((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt(), mu, 0.0);
    let eye = r * DVec3::Y;
    let distance = to_ground(medium.shell.radius, eye, direction);
    let line = Line::new(medium, eye, direction, distance);
    let steps = line.map_or(Vec::new(), |line| march_evenly(medium, &line, steps));
    let through = steps.last().map_or(DVec3::ONE, |step| step.through);
    let ground = distance.is_finite().then_some((eye + distance * direction, through));
    Ray { direction, share, steps, ground }
}

/// Distance from a point to the sphere of the ground, infinite for a ray that misses it. A point below
/// the ground is on ground of its own.
pub(super) fn to_ground(radius: f64, eye: DVec3, direction: DVec3) -> f64 {
    let r = eye.length();
    let falling = -eye.dot(direction);
    let (least, off) = (radius.min(r), (eye + falling * direction).length());
    if falling <= 0.0 || off >= least {
        return f64::INFINITY;
    }
    // The nearer root of a quadratic equation, without cancellation.
    (r - least) * (r + least) / (falling + ((least - off) * (least + off)).sqrt())
}

/// Unit vectors towards suns at the cosine `mu` to the vertical, with weights whose sum is 1: on `count` sides, half of the way
/// round from the plane of the rays, for the other half mirrors it, and more of them where rays go towards the sun, for haze is
/// bright there.
pub(super) fn suns(mu: f64, count: usize) -> impl Iterator<Item = (DVec3, f64)> {
    let sine = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
    (0..count).map(move |i| {
        let u = (i as f64 + 0.5) / count as f64;
        let angle = PI * u * u;
        (DVec3::new(sine * libm::cos(angle), mu, sine * libm::sin(angle)), 2.0 * u / count as f64)
    })
}

/// Nodes and weights of Gauss's rule on [0, 1]: the roots of Legendre's polynomial, by Newton's method.
fn gauss(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    (0..count)
        .map(|i| {
            let mut x = libm::cos(PI * (i as f64 + 0.75) / (n + 0.5));
            let mut slope = 1.0;
            // Five times, for each doubles the digits.
            for _ in 0..5 {
                let (mut p, mut before) = (x, 1.0);
                for k in 2..=count {
                    let k = k as f64;
                    (p, before) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k, p);
                }
                slope = n * (x * p - before) / (x * x - 1.0);
                x -= p / slope;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        for n in 1..12 {
            let sum: f64 = gauss(n).iter().map(|(x, w)| w * x.powi(2 * n as i32 - 1)).sum();
            assert!((sum * 2.0 * n as f64 - 1.0).abs() < 1e-12, "{n}");
        }
    }

    #[test]
    fn the_ground_is_where_it_is() {
        let eye = DVec3::new(0.0, 3.0, 0.0);
        assert_eq!(to_ground(1.0, eye, DVec3::NEG_Y), 2.0);
        assert_eq!(to_ground(1.0, eye, DVec3::Y), f64::INFINITY);
        assert_eq!(to_ground(1.0, eye, DVec3::X), f64::INFINITY);
        assert_eq!(to_ground(1.0, 0.9 * DVec3::Y, DVec3::NEG_Y), 0.0);
        let low = DVec3::Y * (1.0 + 1e-12);
        assert!((to_ground(1.0, low, DVec3::NEG_Y) / 1e-12 - 1.0).abs() < 1e-3);
    }
}
