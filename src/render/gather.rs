//! What pixels gather from their samples, and when they have enough of them.

use super::Pixel;
use super::surface::Patch;
use super::tone;
use crate::scene::Tone;
use glam::DVec3;

/// Samples after which a pixel is asked for the first time whether it has enough: too few agree by chance.
pub(super) const PILOT: u32 = 8;

/// Light of one sample, by what it did last before it came towards the eye.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    /// Given off by the solid, or reflected by it straight from a light.
    pub direct: DVec3,
    /// Reflected from the sky and from elsewhere on the solid.
    pub indirect: DVec3,
    /// From the air, and from what is behind everything.
    pub sky: DVec3,
}

impl Light {
    /// All of it.
    pub fn total(&self) -> DVec3 {
        self.direct + self.indirect + self.sky
    }

    /// A share of it, by channel.
    pub fn times(self, share: DVec3) -> Light {
        Light { direct: self.direct * share, indirect: self.indirect * share, sky: self.sky * share }
    }
}

/// What a sample met first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub patch: Patch,
    /// From the eye.
    pub distance: f64,
    /// Distance between neighbouring pixels there.
    pub footprint: f64,
}

/// What comes of a sample.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    light: Light,
    /// What it met, if anything.
    met: Option<Met>,
    /// Share of light from beyond everything that gets through.
    through: DVec3,
    /// Share of the background that is covered by a moon.
    moon: f64,
    /// Evaluations of the field.
    pub evaluations: f64,
}

impl Outcome {
    /// What it met first, if anything, and the share of light that gets through to there.
    pub fn see(&mut self, met: Option<Met>, through: DVec3) {
        self.met = met;
        self.through = if met.is_some() { DVec3::ZERO } else { through };
    }

    /// Adds light that the path has brought at some step.
    pub fn add(&mut self, light: Light, step: u32) {
        match step {
            0 => self.light = light,
            _ => self.light.indirect += light.total(),
        }
    }

    /// All the light that it has brought.
    pub fn total(&self) -> DVec3 {
        self.light.total()
    }

    /// Whether there is anything behind the air.
    pub fn is_open(&self) -> bool {
        self.met.is_none()
    }

    /// Puts what another sample saw behind it, as a moon.
    pub fn put_behind(&mut self, other: &Outcome) {
        self.light.sky += self.through * other.light.total();
        self.moon = other.alpha();
        self.evaluations += other.evaluations;
    }

    /// Puts light from beyond everything behind it.
    pub fn put_beyond(&mut self, radiance: DVec3) {
        self.light.sky += self.through * radiance * (1.0 - self.moon);
    }

    /// Share of the background that is covered.
    fn alpha(&self) -> f64 {
        1.0 - self.through.element_sum() / 3.0 * (1.0 - self.moon)
    }
}

/// What a pixel has gathered so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    light: Light,
    alpha: f64,
    albedo: DVec3,
    nearest: f64,
    position: DVec3,
    normal: DVec3,
    footprint: f64,
    evaluations: f64,
    count: u32,
    /// Luminances of its light.
    luminance: Tally,
    /// The same with the background that is not covered.
    shown: Tally,
}

/// What numbers have come to: their sum, that of their squares, the two least, and the two greatest.
#[derive(Clone, Copy, Debug)]
struct Tally {
    sum: f64,
    squares: f64,
    least: [f64; 2],
    most: [f64; 2],
}

impl Tally {
    const NONE: Tally =
        Tally { sum: 0.0, squares: 0.0, least: [f64::INFINITY; 2], most: [f64::NEG_INFINITY; 2] };

    fn add(&mut self, x: f64) {
        self.sum += x;
        self.squares += x * x;
        let [first, second] = self.least;
        self.least = [first.min(x), first.max(x).min(second)];
        let [first, second] = self.most;
        self.most = [first.max(x), first.min(x).max(second)];
    }

    /// The mean, of so many.
    fn mean(&self, count: u32) -> f64 {
        self.sum / f64::from(count.max(1))
    }

    /// Square of the standard error of the mean, of more than one.
    fn variance(&self, count: u32) -> f64 {
        let (n, mean) = (f64::from(count), self.mean(count));
        (self.squares / n - mean * mean).max(0.0) / (n - 1.0)
    }

    /// How far the one that is farthest from all others is from them, of more than one.
    fn lone(&self) -> f64 {
        (self.most[0] - self.most[1]).max(self.least[1] - self.least[0])
    }
}

/// Light that all tone curves show as white, or nearly so.
const WHITE: f64 = 4.0;

/// Weights of red, green and blue in luminance (Rec. 709).
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

impl Sum {
    /// Nothing yet.
    pub const NONE: Sum = Sum {
        light: Light { direct: DVec3::ZERO, indirect: DVec3::ZERO, sky: DVec3::ZERO },
        alpha: 0.0,
        albedo: DVec3::ZERO,
        nearest: f64::INFINITY,
        position: DVec3::ZERO,
        normal: DVec3::ZERO,
        footprint: 0.0,
        evaluations: 0.0,
        count: 0,
        luminance: Tally::NONE,
        shown: Tally::NONE,
    };

    /// Adds a sample, in front of a background.
    pub fn add(&mut self, outcome: &Outcome, background: DVec3) {
        let Outcome { light, met, evaluations, .. } = outcome;
        let Light { direct, indirect, sky } = &mut self.light;
        *direct += light.direct;
        *indirect += light.indirect;
        *sky += light.sky;
        if let Some(Met { patch, distance, footprint }) = met {
            self.albedo += patch.albedo;
            if *distance < self.nearest {
                (self.nearest, self.position, self.normal) = (*distance, patch.position, patch.normal);
                self.footprint = *footprint;
            }
        }
        self.alpha += outcome.alpha();
        self.evaluations += evaluations;
        self.count += 1;
        let luminance = light.total().dot(LUMINANCE);
        self.luminance.add(luminance);
        self.shown.add(luminance + (1.0 - outcome.alpha()) * background.dot(LUMINANCE));
    }

    /// Whether the standard error of the mean, and what may have been [missed](Sum::missed) in pixels like this one, are below a
    /// share of white, as a screen shows them.
    pub fn is_enough(&self, noise: f64, (gain, tone): (f64, Tone), missed: f64) -> bool {
        if self.count < PILOT {
            return false;
        }
        let (mean, error) = (self.shown.mean(self.count), self.shown.variance(self.count).sqrt() + missed);
        let shown = |luminance: f64| tone::brightness(gain * luminance.max(0.0), tone);
        shown(mean + error) - shown(mean - error) < 2.0 * noise
    }

    /// How far the mean would be off if a sample that is unlike all others of its pixel had not been taken, as far as a screen
    /// shows it with a gain. For what all samples of a pixel have missed they cannot tell; but in the mean over pixels it is as
    /// much as what was met once (Good 1953).
    pub fn missed(&self, gain: f64) -> f64 {
        if self.count > 1 { (self.shown.lone() / f64::from(self.count)).min(WHITE / gain) } else { 0.0 }
    }

    /// Square of the standard error of the mean luminance of light. One sample says nothing of it: then it is taken to be as
    /// wrong as it is bright.
    fn variance(&self) -> f64 {
        let mean = self.luminance.mean(self.count);
        if self.count > 1 { self.luminance.variance(self.count) } else { mean * mean }
    }

    /// The pixel.
    pub fn resolve(&self) -> Pixel {
        let share = 1.0 / f64::from(self.count.max(1));
        let Light { direct, indirect, sky } = self.light;
        let channels = |sum: DVec3| (sum * share).as_vec3().to_array();
        Pixel {
            color: channels(self.light.total()),
            direct: channels(direct),
            indirect: channels(indirect),
            sky: channels(sky),
            albedo: channels(self.albedo),
            alpha: (self.alpha * share) as f32,
            depth: self.nearest as f32,
            position: self.position.as_vec3().to_array(),
            normal: self.normal.as_vec3().to_array(),
            footprint: self.footprint as f32,
            samples: self.count as f32,
            variance: self.variance() as f32,
            evaluations: self.evaluations as f32,
        }
    }
}
