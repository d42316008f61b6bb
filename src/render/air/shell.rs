//! Tables over the height of a point and the height of the sun.

use super::exp::exp;
use super::grid::{Grid, Rows, share};
use super::medium::{Medium, TOP};
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

    /// From 0 for a sun that lights nothing which could be seen to 1 for one in the zenith, at the cosine `mu` to the
    /// vertical: dense about the horizon, where twilight is.
    fn height_of_sun(&self, mu: f64) -> f64 {
        let x = if mu < 0.0 { -(mu / self.night()).abs().sqrt() } else { mu.sqrt() };
        0.5 + 0.5 * x
    }

    /// Cosine of the sun at such a height in [0, 1].
    fn cosine_at(&self, height: f64) -> f64 {
        let x = 2.0 * height - 1.0;
        if x < 0.0 { self.night() * x * x } else { x * x }
    }

    /// Cosine of a sun below which it is night: no air that is seen is lit.
    fn night(&self) -> f64 {
        // The horizon of a point at the top is acos(R / R_t) away, as an angle about the centre; so is the place beyond where
        // one sees the top again; so far, too, the sun grazes the ground there and is below that place's own horizon. The
        // sine of three times an angle is at most three times its sine.
        let ratio = self.radius / self.top;
        -(3.0 * ((1.0 - ratio) * (1.0 + ratio)).sqrt()).min(1.0)
    }
}

/// Heights for light that changes within the thinnest layer. They grow as `sinh^2(k u)` for `u` from 0 at the ground to 1 at
/// the top: at first as `u^2`, then by equal factors, as nodes along lines of sight do.
#[derive(Clone, Copy, Debug)]
struct Heights {
    shell: Shell,
    /// The height for which the sine is 1.
    unit: f64,
    k: f64,
}

impl Heights {
    fn of(medium: &Medium) -> Heights {
        let (shell, unit) = (medium.shell, TOP * medium.finest);
        Heights { shell, unit, k: libm::asinh(((shell.top - shell.radius) / unit).sqrt()) }
    }

    fn at(&self, r: f64) -> f64 {
        let Shell { radius, top } = self.shell;
        libm::asinh(((r.clamp(radius, top) - radius) / self.unit).sqrt()) / self.k
    }

    fn radius(&self, u: f64) -> f64 {
        let Shell { radius, top } = self.shell;
        let sine = libm::sinh(self.k * u);
        (radius + self.unit * (sine * sine)).min(top)
    }

    /// Logarithms of the light for suns at so many heights.
    fn logarithms<T: Light>(&self, suns: usize, light: impl Fn(f64) -> T) -> impl Iterator<Item = T> {
        let (shell, logarithm) =
            (self.shell, |light: DVec3| (light + LEAST).to_array().map(libm::log).into());
        (0..suns).map(move |i| light(shell.cosine_at(share(i, suns))).map(logarithm))
    }
}

/// Light by channel, of one or several kinds.
pub(super) trait Light: Copy + Send + Add<Output = Self> + Mul<f64, Output = Self> {
    /// What a function makes of each kind.
    fn map(self, f: impl Fn(DVec3) -> DVec3) -> Self;
}

impl Light for DVec3 {
    fn map(self, f: impl Fn(DVec3) -> DVec3) -> DVec3 {
        f(self)
    }
}

/// Light at heights in the air, for suns at all heights.
///
/// At dusk light fades by a factor or two from one degree to the next, over many powers of ten, so what is kept, and
/// what is cubic between the nodes, is its logarithm: few heights of the sun do. In thick air it also changes with the height,
/// within the way that light goes there.
#[derive(Clone, Debug)]
pub(super) struct SunTable<T> {
    heights: Heights,
    logarithms: Grid<T>,
}

/// Added to light that may be none, so that it has a logarithm.
const LEAST: f64 = 1e-30;

impl<T: Light> SunTable<T> {
    /// Makes a table of some heights of the sun by some of places in the air of a medium: `at(r)` prepares for a radius and gives
    /// the light for cosines of the sun to the vertical. `None` if that was cancelled.
    pub fn new<F: Fn(f64) -> T>(
        medium: &Medium,
        [suns, places]: [usize; 2],
        cancel: &AtomicBool,
        at: impl Fn(f64) -> F + Sync,
    ) -> Option<SunTable<T>> {
        let heights = Heights::of(medium);
        let logarithms =
            Grid::new([suns, places], cancel, |u| heights.logarithms(suns, at(heights.radius(u))));
        Some(SunTable { heights, logarithms: logarithms? })
    }

    /// The light at a point, with the direction towards the sun.
    pub fn to(&self, p: DVec3, sun: DVec3) -> T {
        let r = p.length();
        self.at(r, p.dot(sun) / r.max(f64::MIN_POSITIVE))
    }

    /// The light at a radius for a sun at the cosine `mu` to the vertical.
    pub fn at(&self, r: f64, mu: f64) -> T {
        light(self.logarithms.cubic(self.heights.shell.height_of_sun(mu), self.heights.at(r)))
    }
}

/// Such a table of which only those heights of places are made that are asked for.
#[derive(Debug)]
pub(super) struct SunRows<T> {
    heights: Heights,
    suns: usize,
    logarithms: Rows<T>,
}

impl<T: Light> SunRows<T> {
    /// A table of some heights of the sun by some of places in the air of a medium, with nothing in it yet.
    pub fn new(medium: &Medium, size: [usize; 2]) -> SunRows<T> {
        SunRows { heights: Heights::of(medium), suns: size[0], logarithms: Rows::new(size) }
    }

    /// The light at a radius for a sun at the cosine `mu` to the vertical; `at` as for [`SunTable::new`], always the same.
    pub fn at<F: Fn(f64) -> T>(&self, r: f64, mu: f64, at: impl Fn(f64) -> F) -> T {
        let SunRows { heights, suns, logarithms } = self;
        let row = |u| heights.logarithms(*suns, at(heights.radius(u)));
        light(logarithms.cubic(heights.shell.height_of_sun(mu), heights.at(r), row))
    }
}

/// What has these logarithms.
fn light<T: Light>(logarithms: T) -> T {
    logarithms.map(|x| (DVec3::from_array(exp(x.to_array())) - LEAST).max(DVec3::ZERO))
}
