//! Rays as pictures have them, a tile of 256 at a time in Morton's order, and rays as nothing has them.

use super::surfaces::Surface;
use super::truth::Oracle;
use glam::DVec3;
use orogen::cast::{Ray, Tolerance};
use rand::{RngExt, SeedableRng, rngs::StdRng};

/// Rays of a tile.
pub const TILE: usize = 256;

/// A unit vector.
pub fn unit(rng: &mut StdRng) -> DVec3 {
    loop {
        let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        if v.length() > 0.1 && v.length() < 1.0 {
            return v.normalize();
        }
    }
}

/// The tile with a number: of four, two are seen by an eye, one is parallel light on what an eye sees,
/// and one is of rays that have nothing in common.
pub fn tile(surface: &Surface, oracle: &mut Oracle, number: usize) -> Vec<Ray> {
    let seed =
        surface.name.bytes().fold(number as u64, |hash, byte| hash.wrapping_mul(131) + u64::from(byte));
    let mut rng = StdRng::seed_from_u64(seed);
    match number % 4 {
        1 => light(surface, oracle, &mut rng),
        3 => strangers(surface, &mut rng),
        _ => seen(surface, &mut rng),
    }
}

fn ray(surface: &Surface, origin: DVec3, direction: DVec3) -> Option<Ray> {
    let (near, far) = surface.region.clip(origin, direction)?;
    let near = near.max(surface.tolerance.least);
    (near < far).then_some(Ray { origin, direction, near, far, tolerance: surface.tolerance })
}

/// Places in a square from -1 to 1, neighbours one after the other.
fn places() -> impl Iterator<Item = [f64; 2]> {
    let every_other = |i: usize| (0..4).fold(0, |x, bit| x | (i >> (2 * bit) & 1) << bit);
    let place = |k: usize| (k as f64 + 0.5) / 8.0 - 1.0;
    (0..TILE).map(move |i| [place(every_other(i)), place(every_other(i >> 1))])
}

/// Through the pixels of a tile, which may be wide or very narrow.
fn seen(surface: &Surface, rng: &mut StdRng) -> Vec<Ray> {
    let [eye, target] = (surface.aim)(rng);
    let forward = (target - eye).normalize();
    let right = forward.any_orthonormal_vector();
    let half = libm::exp10(rng.random_range(-4.0..-0.7));
    let through = |[x, y]: [f64; 2]| (forward + half * (x * right + y * forward.cross(right))).normalize();
    places().filter_map(|place| ray(surface, eye, through(place))).collect()
}

/// From the surface towards the sun, as shadow rays go; parallel rays from outside where an eye sees
/// too little of the surface.
fn light(surface: &Surface, oracle: &mut Oracle, rng: &mut StdRng) -> Vec<Ray> {
    let sun = unit(rng);
    let mut rays = Vec::new();
    for ray in seen(surface, rng) {
        let Some(t) = oracle.ask(&ray).first else { continue };
        let tolerance = ray.tolerance.at(t);
        let p = ray.at(t);
        let Some(normal) = oracle.normal(p) else { continue };
        let origin = p + 4.0 * tolerance * normal;
        if normal.dot(sun) > 0.0
            && let Some((near, far)) = surface.region.clip(origin, sun)
            && near.max(0.0) < far
        {
            let tolerance = Tolerance::fixed(tolerance);
            rays.push(Ray { origin, direction: sun, near: near.max(0.0), far, tolerance });
        }
    }
    if rays.len() > 16 {
        return rays;
    }
    let [eye, target] = (surface.aim)(rng);
    let forward = (target - eye).normalize();
    let right = forward.any_orthonormal_vector();
    let half = eye.distance(target) * libm::exp10(rng.random_range(-4.0..-0.7));
    let from = |[x, y]: [f64; 2]| eye + half * (x * right + y * forward.cross(right));
    places().filter_map(|place| ray(surface, from(place), forward)).collect()
}

fn strangers(surface: &Surface, rng: &mut StdRng) -> Vec<Ray> {
    let aimed = (0..TILE).map(|_| (surface.aim)(rng));
    aimed.filter_map(|[eye, target]| ray(surface, eye, (target - eye).normalize())).collect()
}
