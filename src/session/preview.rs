//! Quick, coarse pictures: something right on the screen while the full picture is being made.

use super::{Order, stage};
use crate::diag::Diagnostic;
use crate::render::{Job, Part, Picture, Rect};
use crate::scene::Scene;

/// Sides of the full picture over those of quick ones, in the order in which they are worth making.
pub const COARSENESS: [u32; 2] = [16, 4];

/// Samples of a full picture that is quick enough by itself.
const QUICK: u64 = 20_000;

/// The whole picture with one ray for a square of `coarseness` pixels' side, enlarged to full size; `None` if the full one is as quick.
///
/// # Errors
/// As for [`render`](super::render).
pub fn preview(
    scene: &Scene,
    order: &Order,
    coarseness: u32,
    job: &Job<'_>,
) -> Result<Option<Picture>, Box<Diagnostic>> {
    let coarseness = coarseness.max(1);
    let (width, height) = order.size.unwrap_or((scene.film.width, scene.film.height));
    let samples = order.samples.unwrap_or(scene.film.samples);
    if u64::from(width) * u64::from(height) * u64::from(samples) <= QUICK {
        return Ok(None);
    }
    let size = Some((width.div_ceil(coarseness), height.div_ceil(coarseness)));
    let small = stage::render(scene, &Order { size, samples: Some(1), part: Part::Whole, ..*order }, job)?;
    Ok(Some(enlarged(&small, coarseness, width, height)))
}

/// A picture with every pixel repeated, cut to a size.
fn enlarged(small: &Picture, coarseness: u32, width: u32, height: u32) -> Picture {
    let pixel = |x: u32, y: u32| *small.pixel(x / coarseness, y / coarseness);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect();
    let window = Rect::whole(width, height);
    let warnings = small.warnings.clone();
    Picture { width, height, window, pixels, denoised: None, components: None, warnings, ..*small }
}
