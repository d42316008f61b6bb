//! The view of the published tables, eye at (0, 0, -4), the sphere of radius 1.6 filling the width; and a
//! stopwatch.

use glam::DVec3;
use orogen::cast::{Ray, Tolerance};
use std::time::Instant;

/// How precisely hits are wanted, along the ray; the source does not say.
pub const TOLERANCE: f64 = 1e-4;

/// Rays through the pixels of a square picture, tile by tile, within the sphere of a radius around the
/// origin. Rays that pass it by keep their place in the tile: there is nothing on them.
pub fn rays(size: usize, radius: f64) -> Vec<Ray> {
    let half = 1.6 / (16.0f64 - 1.6 * 1.6).sqrt();
    let origin = DVec3::new(0.0, 0.0, -4.0);
    let tiles = size.div_ceil(16);
    let mut out = Vec::new();
    for tile in 0..tiles * tiles {
        for i in 0..256 {
            let (x, y) = (tile % tiles * 16 + every_other(i), tile / tiles * 16 + every_other(i >> 1));
            let u = |k: usize| half * (2.0 * (k as f64 + 0.5) / size as f64 - 1.0);
            let direction = DVec3::new(u(x), -u(y), 1.0).normalize();
            let (b, c) = (origin.dot(direction), origin.length_squared() - radius * radius);
            let q = b * b - c;
            let real = q > 0.0 && x < size && y < size;
            let (near, far) = if real { (-b - q.sqrt(), -b + q.sqrt()) } else { (0.0, -1.0) };
            out.push(Ray { origin, direction, near, far, tolerance: Tolerance::fixed(TOLERANCE) });
        }
    }
    out
}

/// Every other bit, from the lowest on: one axis of Morton's order.
fn every_other(i: usize) -> usize {
    (0..4).fold(0, |x, bit| x | (i >> (2 * bit) & 1) << bit)
}

/// Measures the time that this thread spends on a processor, so that what else runs counts less.
pub struct Stopwatch {
    start: Instant,
    /// Where the system tells.
    on_processor: Option<f64>,
}

impl Stopwatch {
    pub fn start() -> Stopwatch {
        Stopwatch { start: Instant::now(), on_processor: on_processor() }
    }

    /// Seconds since the start; those that went by, where the system does not tell more.
    pub fn seconds(&self) -> f64 {
        let spent = self.on_processor.zip(on_processor()).map(|(from, to)| to - from);
        spent.unwrap_or_else(|| self.start.elapsed().as_secs_f64())
    }
}

/// Seconds that this thread has spent on a processor, as Linux tells.
fn on_processor() -> Option<f64> {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    told.split(' ').next()?.parse::<f64>().ok().map(|nanoseconds| nanoseconds * 1e-9)
}
