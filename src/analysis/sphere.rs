//! The solid sample: a sphere made rough by a noise and shaded by its value.
//!
//! The surface is `|x| + a N(s x) = 1`, where `s` makes 32 cells of the noise fill the cube that is
//! seen. It lies in a shell whose thickness the extremes of the noise tell, and is found by steps
//! through that shell, many rays at a time. Nothing is certified, unlike in a rendered scene: of some
//! noises so little is proven that certainty takes minutes, and what is to be seen here is what a noise
//! is like.

use super::plot::Figure;
use super::{Refusal, Watch};
use crate::field::Moments;
use crate::num::Many;
use crate::scene::Member;
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Cells of the noise across the cube that is seen.
const CELLS: f64 = 32.0;
/// Half its side, for a sphere of radius 1.
const HALF: f64 = 1.25;
/// Distance of the camera.
const DISTANCE: f64 = 7.0;
/// Where it stands: degrees from z towards x, and above the ground.
const VIEW: (f64, f64) = (30.0, 20.0);
/// Towards the light, as seen from the camera: from the upper left, behind it.
const LIGHT: DVec3 = DVec3::new(-0.5, 0.6, 0.62);
/// Light from below, what more comes from above, and that of the sun.
const STRENGTHS: [f64; 3] = [0.10, 0.10, 1.05];
/// Brightness around the sphere.
const BACKGROUND: f64 = 0.014;
/// How far the surface moves by default, as a root mean square in cells.
const ROUGHNESS: f64 = 0.2;
/// Rays to a pixel along an edge.
const RAYS: u32 = 2;
/// Points evaluated together.
const LANES: usize = 64;

/// The sphere to draw.
#[derive(Clone, Copy, Debug)]
pub struct Sphere<'a> {
    /// The noise.
    pub noise: &'a Member,
    /// What it is like on average.
    pub moments: &'a Moments,
    /// Length of its cells.
    pub cell: f64,
    /// How far it moves the surface for each unit of its value.
    pub amplitude: Option<f64>,
    /// Side of the picture in pixels.
    pub size: u32,
}

/// A ray on its way through the shell.
#[derive(Clone, Copy)]
struct Ray {
    /// Pixel of the row.
    pixel: usize,
    from: DVec3,
    along: DVec3,
    /// Where it leaves the shell.
    end: f64,
    /// The last place outside, with the field there.
    outside: (f64, f64),
    /// The place to look at next.
    next: f64,
}

impl Sphere<'_> {
    /// Draws it, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// [`Refusal::Cancelled`]
    pub fn draw(&self, watch: &Watch<'_>) -> Result<Figure, Refusal> {
        let scene = Scene::new(self);
        let done = AtomicUsize::new(0);
        let row = |y: u32| {
            if watch.cancel.load(Ordering::Relaxed) {
                return Err(Refusal::Cancelled);
            }
            let bytes = scene.row(y);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            (watch.progress)(done as f64 / f64::from(self.size));
            Ok(bytes)
        };
        let rows: Vec<Vec<u8>> = (0..self.size).into_par_iter().map(row).collect::<Result<_, _>>()?;
        Ok(Figure::grey(self.size, self.size, rows.into_iter().flatten()))
    }
}

/// The sphere with everything that follows from it.
struct Scene {
    tape: Arc<Tape>,
    size: u32,
    scale: f64,
    amplitude: f64,
    /// Half the thickness of the shell.
    depth: f64,
    /// Shortest step, and distance for differences.
    step: f64,
    /// Values of the darkest and the lightest stone.
    shades: (f64, f64),
    /// To the right, up and towards the viewer.
    frame: [DVec3; 3],
}

impl Scene {
    fn new(of: &Sphere<'_>) -> Scene {
        let scale = CELLS * of.cell / (2.0 * HALF);
        let cell = of.cell / scale;
        let m = of.moments;
        let rms = libm::sqrt(m.variance).max(1e-9);
        let amplitude = of.amplitude.unwrap_or(ROUGHNESS * cell / rms);
        // Extremes are those of a sample; what is beyond them is cut off, level.
        let most = 1.25 * f64::max(m.min.abs(), m.max.abs());
        let (azimuth, elevation) = (VIEW.0.to_radians(), VIEW.1.to_radians());
        let (sin, cos) = (libm::sin(azimuth), libm::cos(azimuth));
        let back = DVec3::new(sin * libm::cos(elevation), libm::sin(elevation), cos * libm::cos(elevation));
        let right = DVec3::new(cos, 0.0, -sin);
        Scene {
            tape: Arc::new(Tape::new(&of.noise.graph, &[of.noise.root])),
            size: of.size,
            scale,
            amplitude,
            depth: (amplitude.abs() * most).clamp(1e-6, 0.9),
            step: 0.1 * cell,
            shades: (m.quantiles[1], m.quantiles[5]),
            frame: [right, back.cross(right), back],
        }
    }

    /// The bytes of a row of pixels.
    fn row(&self, y: u32) -> Vec<u8> {
        let mut noise = Evaluator::<Many<f64, LANES>>::new(self.tape.clone());
        let mut rays: Vec<Ray> = (0..self.size * RAYS * RAYS)
            .filter_map(|i| self.ray(i / (RAYS * RAYS), y, i % (RAYS * RAYS)))
            .collect();
        let mut light = vec![0.0; self.size as usize];
        let mut missed = vec![RAYS * RAYS; self.size as usize];
        while !rays.is_empty() {
            let places: Vec<DVec3> = rays.iter().map(|r| r.from + r.along * r.next).collect();
            let values = self.values(&mut noise, &places);
            let (mut hits, mut left) = (Vec::new(), Vec::new());
            for (ray, (place, value)) in rays.iter().zip(places.iter().zip(values)) {
                let f = place.length() - 1.0 + self.amplitude * value;
                match ray.after(f, self.step) {
                    Some(Ok(next)) => left.push(next),
                    Some(Err(hit)) => hits.push((ray.pixel, hit)),
                    None => {}
                }
            }
            for (pixel, radiance) in self.shaded(&mut noise, &hits) {
                light[pixel] += radiance;
                missed[pixel] -= 1;
            }
            rays = left;
        }
        let total = f64::from(RAYS * RAYS);
        let mean = |(light, missed): (&f64, &u32)| (light + BACKGROUND * f64::from(*missed)) / total;
        light.iter().zip(&missed).map(mean).map(byte).collect()
    }

    /// A ray of a pixel from where it enters the shell; `None` if it never does.
    fn ray(&self, x: u32, y: u32, part: u32) -> Option<Ray> {
        let [right, up, back] = self.frame;
        let place = |pixel: u32, part: u32| {
            let at = (f64::from(pixel) + (f64::from(part) + 0.5) / f64::from(RAYS)) / f64::from(self.size);
            HALF * (2.0 * at - 1.0)
        };
        let (u, v) = (place(x, part % RAYS), -place(y, part / RAYS));
        let from = back * DISTANCE;
        let along = (right * u + up * v - from).normalize();
        let (middle, outer) = (-from.dot(along), 1.0 + self.depth);
        let half = outer * outer - (from.length_squared() - middle * middle);
        let half = libm::sqrt(if half > 0.0 { half } else { return None });
        let start = middle - half;
        Some(Ray {
            pixel: x as usize,
            from,
            along,
            end: middle + half,
            outside: (start, self.depth),
            next: start,
        })
    }

    /// The noise at points of the picture.
    fn values(&self, noise: &mut Evaluator<Many<f64, LANES>>, places: &[DVec3]) -> Vec<f64> {
        let mut out = Vec::with_capacity(places.len());
        for batch in places.chunks(LANES) {
            let at =
                |axis: usize| Many(std::array::from_fn(|i| self.scale * batch[i.min(batch.len() - 1)][axis]));
            let Many(values) = noise.eval(&[at(0), at(1), at(2)]);
            out.extend_from_slice(&values[..batch.len()]);
        }
        out
    }

    /// The light that comes from points of the surface.
    fn shaded(&self, noise: &mut Evaluator<Many<f64, LANES>>, hits: &[(usize, DVec3)]) -> Vec<(usize, f64)> {
        let side = 0.1 * self.step;
        let around = |p: DVec3| [p, p + DVec3::X * side, p + DVec3::Y * side, p + DVec3::Z * side];
        let places: Vec<DVec3> = hits.iter().flat_map(|(_, p)| around(*p)).collect();
        let values = self.values(noise, &places);
        let [right, up, back] = self.frame;
        let sun = (right * LIGHT.x + up * LIGHT.y + back * LIGHT.z).normalize();
        let (low, high) = self.shades;
        let radiance = |((pixel, p), v): (&(usize, DVec3), &[f64])| {
            let slope = DVec3::new(v[1] - v[0], v[2] - v[0], v[3] - v[0]) / side;
            let normal = (p.normalize() + self.amplitude * slope).normalize_or_zero();
            let share = ((v[0] - low) / (high - low).max(1e-9)).clamp(0.0, 1.0);
            let stone = 0.25 + 0.5 * share * share * (3.0 - 2.0 * share);
            let [below, above, direct] = STRENGTHS;
            let sky = below + above * 0.5 * (1.0 + normal.y);
            (*pixel, stone * (sky + direct * normal.dot(sun).max(0.0)))
        };
        hits.iter().zip(values.chunks_exact(4)).map(radiance).collect()
    }
}

impl Ray {
    /// Goes on from a place where the field is `f`: with the next place, or with the point of the
    /// surface; `None` once the ray has left the shell.
    fn after(&self, f: f64, step: f64) -> Option<Result<Ray, DVec3>> {
        if f < 0.0 {
            // Where a straight line between the last two values passes zero.
            let (t, above) = self.outside;
            let share = if above > 0.0 { above / (above - f) } else { 0.0 };
            return Some(Err(self.from + self.along * (t + share * (self.next - t))));
        }
        // Half the value is a careful guess where slopes are those of a rough sphere.
        let next = self.next + (0.5 * f).max(step);
        (next <= self.end).then_some(Ok(Ray { outside: (self.next, f), next, ..*self }))
    }
}

/// Radiance as a byte of sRGB.
fn byte(radiance: f64) -> u8 {
    let c = radiance.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * libm::pow(c, 1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}
