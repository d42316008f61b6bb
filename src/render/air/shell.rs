//! Tables over the height of a point and the height of the sun.

use super::grid::{Grid, share};
use glam::DVec3;
use std::ops::{Add, Mul};
use std::sync::atomic::AtomicBool;

/// The room that the air takes, as a coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shell {
    /// Radius of the ground.
    pub radius: f64,
    /// Radius above which there is nothing.
    pub top: f64,
}

impl Shell {
    /// From 0 at the ground to 1 at the top: how far one sees, `sqrt(r^2 - R^2)`, which is what light near
    /// the ground depends on.
    pub fn level(&self, r: f64) -> f64 {
        let Shell { radius, top } = *self;
        let r = r.clamp(radius, top);
        ((r - radius) * (r + radius) / ((top - radius) * (top + radius))).sqrt()
    }

    /// Radius at a level.
    pub fn radius_at(&self, level: f64) -> f64 {
        let Shell { radius, top } = *self;
        (radius * radius + level * level * (top - radius) * (top + radius)).sqrt().clamp(radius, top)
    }
}

/// Values at levels of the air, for suns at all heights.
#[derive(Clone, Debug)]
pub(super) struct SunTable<T> {
    shell: Shell,
    grid: Grid<T>,
}

impl<T: Copy + Send + Add<Output = T> + Mul<f64, Output = T>> SunTable<T> {
    /// Makes a table of some heights of the sun by some levels: `at(r)` prepares for a radius and gives
    /// the values for cosines of the sun to the vertical. `None` if that was cancelled.
    pub fn new<F: Fn(f64) -> T>(
        shell: Shell,
        [suns, levels]: [usize; 2],
        cancel: &AtomicBool,
        at: impl Fn(f64) -> F + Sync,
    ) -> Option<SunTable<T>> {
        let grid = Grid::new([suns, levels], cancel, |level| {
            let value = at(shell.radius_at(level));
            (0..suns).map(move |i| value(cosine_at(share(i, suns))))
        });
        Some(SunTable { shell, grid: grid? })
    }

    /// The value at a point, with the direction towards the sun.
    pub fn to(&self, p: DVec3, sun: DVec3) -> T {
        let r = p.length();
        self.at(r, p.dot(sun) / r.max(f64::MIN_POSITIVE))
    }

    /// The value at a radius for a sun at the cosine `mu` to the vertical.
    pub fn at(&self, r: f64, mu: f64) -> T {
        self.grid.at(0.5 + 0.5 * mu.signum() * mu.abs().sqrt(), self.shell.level(r))
    }
}

/// Cosine of the sun at a coordinate in [0, 1]: nodes are dense about the horizon, where twilight is.
fn cosine_at(u: f64) -> f64 {
    let x = 2.0 * u - 1.0;
    x * x.abs()
}
