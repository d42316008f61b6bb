//! Denoising: a preview of what more samples would give.
//!
//! Light that is noisy is smoothed over neighbouring pixels that show the same thing, as far as their normals, their depths and
//! their own noise tell. The colour of the surface is divided out before and put back after, so that textures stay
//! sharp. A few samples tell little of their own noise, and much where something small and bright is among them. Of light that
//! comes straight, that is a highlight or its rim: there a pixel is as noisy as the middle one of its neighbours, and
//! two are mixed as far as the less noisy of them allows. Of light that bounces it is a find that others have not made: there, as
//! far as a pixel's light is of that kind, its own noise counts. The mean over a wide surrounding is made of a few small
//! ones, with holes that double (the "à trous" wavelet of
//! Dammertz, Sewtz, Hanika and Lensch 2010, with the weights by variance of Schied et al. 2017).

use super::{Picture, Pixel};
use rayon::prelude::*;

/// Rounds; the last looks `2 * 2^(ROUNDS - 1)` pixels far.
const ROUNDS: u32 = 5;

/// Weights of the cubic B-spline at whole numbers.
const KERNEL: [f32; 3] = [0.375, 0.25, 0.0625];

/// How many standard errors apart light may be that belongs together.
const LIGHT: f32 = 6.0;

/// The cosine between normals counts as its power of two, so often.
const NORMAL: u32 = 6;

/// How far from each other's planes points may lie, in footprints and pixels of distance.
const DEPTH: f32 = 1.0;

/// Darkest colour that is divided out.
const DARK: f32 = 0.01;

/// Light of a pixel without the colour of its surface, and how uncertain it is.
#[derive(Clone, Copy)]
struct Light {
    color: [f32; 3],
    variance: f32,
}

/// The light of a picture with its noise smoothed: linear red, green, blue, as in [`Pixel::color`].
pub fn denoise(picture: &Picture) -> Vec<[f32; 3]> {
    let mut light: Vec<Light> = picture.pixels.iter().map(bare).collect();
    for round in 0..ROUNDS {
        let errors: Vec<f32> = (0..light.len()).into_par_iter().map(|i| error(picture, &light, i)).collect();
        let smoothed = |i| smoothed(picture, &light, &errors, i, 1 << round);
        light = (0..light.len()).into_par_iter().map(smoothed).collect();
    }
    let dressed = |(pixel, light): (&Pixel, &Light)| {
        std::array::from_fn(|c| light.color[c] * surface(pixel, c) + sky(pixel, c))
    };
    picture.pixels.iter().zip(&light).map(dressed).collect()
}

/// What light is multiplied by at a surface; the albedo, as far as it is not nearly black.
fn surface(pixel: &Pixel, channel: usize) -> f32 {
    pixel.albedo[channel].max(DARK)
}

/// What is added to it on the way: no noise worth smoothing.
fn sky(pixel: &Pixel, channel: usize) -> f32 {
    pixel.sky[channel]
}

fn bare(pixel: &Pixel) -> Light {
    let color = std::array::from_fn(|c| (pixel.color[c] - sky(pixel, c)) / surface(pixel, c));
    let mean_surface = (0..3).map(|c| surface(pixel, c)).sum::<f32>() / 3.0;
    Light { color, variance: pixel.variance / (mean_surface * mean_surface) }
}

/// Pixels at most `reach` steps away from pixel `i`, with these steps, by rows.
fn around(picture: &Picture, i: usize, reach: i64, step: i64) -> impl Iterator<Item = (i64, i64, usize)> {
    let (width, height) = (i64::from(picture.window.width), i64::from(picture.window.height));
    let (x, y) = (i as i64 % width, i as i64 / width);
    let steps = (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| (dx, dy)));
    steps.filter_map(move |(dx, dy)| {
        let (u, v) = (x + dx * step, y + dy * step);
        let is_there = (0..width).contains(&u) && (0..height).contains(&v);
        is_there.then(|| (dx, dy, (v * width + u) as usize))
    })
}

/// The standard error of a pixel: the middle one of those around it that show something.
fn error(picture: &Picture, light: &[Light], i: usize) -> f32 {
    let (mut near, mut count) = ([0.0; 9], 0);
    for (_, _, j) in around(picture, i, 1, 1).filter(|(_, _, j)| picture.pixels[*j].depth.is_finite()) {
        near[count] = light[j].variance;
        count += 1;
    }
    let near = &mut near[..count];
    near.sort_unstable_by(f32::total_cmp);
    near.get(count / 2).map_or(0.0, |middle| middle.sqrt())
}

/// How much of a pixel's light is reflected from elsewhere, from 0 to 1.
fn bounced(pixel: &Pixel) -> f32 {
    let [direct, indirect] = [pixel.direct, pixel.indirect].map(|light| light.iter().sum::<f32>());
    if indirect > 0.0 { indirect / (direct.max(0.0) + indirect) } else { 0.0 }
}

/// The light of pixel `i`, with that of others `step` and twice as many pixels away that belong to it.
fn smoothed(picture: &Picture, light: &[Light], errors: &[f32], i: usize, step: i64) -> Light {
    let (own, mine) = (&picture.pixels[i], light[i]);
    if own.depth.is_infinite() {
        return mine;
    }
    let (mut sum, mut variance, mut weights) = ([0.0f32; 3], 0.0, 0.0);
    for (dx, dy, j) in around(picture, i, 2, step) {
        let (other, theirs) = (&picture.pixels[j], light[j]);
        let found = |pixel: &Pixel, light: &Light| bounced(pixel) * light.variance.sqrt();
        let error = errors[i].min(errors[j]).max(found(own, &mine)).max(found(other, &theirs));
        let apart = apart([own, other], [&mine, &theirs]);
        let alike = if i == j { 1.0 } else { likeness(own, other) * agreement(apart, error) };
        let weight = KERNEL[dx.unsigned_abs() as usize] * KERNEL[dy.unsigned_abs() as usize] * alike;
        for c in 0..3 {
            sum[c] += weight * theirs.color[c];
        }
        variance += weight * weight * theirs.variance;
        weights += weight;
    }
    // Its own weight is never zero.
    Light { color: sum.map(|c| c / weights), variance: variance / (weights * weights) }
}

/// Whether two pixels show the same piece of a surface, from 0 to 1.
fn likeness(a: &Pixel, b: &Pixel) -> f32 {
    let dot = |u: [f32; 3], v: [f32; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    if b.depth.is_infinite() {
        return 0.0;
    }
    let apart: [f32; 3] = std::array::from_fn(|c| b.position[c] - a.position[c]);
    let (off, far) = (dot(apart, a.normal).abs(), dot(apart, apart).sqrt());
    let room = DEPTH * (a.footprint + 0.1 * far);
    let level = if room > 0.0 { (1.0 - off / room).max(0.0) } else { 1.0 };
    level * hues(a, b) * (0..NORMAL).fold(dot(a.normal, b.normal).max(0.0), |cosine, _| cosine * cosine)
}

/// How much the colours of two surfaces are of one hue, from 0 to 1. What a coat mirrors has none of the surface's colour: where
/// that is divided out all the same, it is of the complementary one, and no light for a surface of another.
fn hues(a: &Pixel, b: &Pixel) -> f32 {
    let ratios: [f32; 3] = std::array::from_fn(|c| surface(a, c) / surface(b, c));
    let [least, most] = [f32::min, f32::max].map(|pick| ratios.into_iter().reduce(pick).unwrap_or(1.0));
    let share = least / most;
    share * share
}

/// How far two lights are apart in what is seen of them at their surfaces: the noise of a channel that is nearly black there was
/// multiplied when the colour was divided out.
fn apart(pixels: [&Pixel; 2], [a, b]: [&Light; 2]) -> f32 {
    let shares: [f32; 3] = std::array::from_fn(|c| surface(pixels[0], c) + surface(pixels[1], c));
    let difference = (0..3).map(|c| shares[c] * (a.color[c] - b.color[c]).abs()).sum::<f32>();
    difference / shares.iter().sum::<f32>()
}

/// Whether two lights so far apart may be the same but for noise, from 0 to 1.
fn agreement(apart: f32, error: f32) -> f32 {
    let room = LIGHT * error + 1e-4;
    let share = apart / room;
    // A bump that ends, so that what differs enough has no say.
    let left = (1.0 - share * share).max(0.0);
    left * left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{mix, uniform};
    use crate::render::Settings;
    use crate::scene::{Aabb, Film};

    const SIDE: u32 = 48;

    /// A flat grey wall of two colours, whose right half faces elsewhere, with noise.
    fn noisy(noise: f32) -> Picture {
        let film = Film { width: SIDE, height: SIDE, ..Film::default() };
        let settings = Settings::of_film(&film, Aabb::cube(1.0));
        let mut picture = Picture::reserved(&settings, [0.0; 3]).unwrap();
        picture.fill();
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            let (x, y) = (i as u32 % SIDE, i as u32 / SIDE);
            let albedo = if y.is_multiple_of(8) { 0.2 } else { 0.8 };
            let own = uniform(mix(i as u64)) as f32 - 0.5;
            let bright = if x < SIDE / 2 { 0.5 } else { 1.0 };
            let color = albedo * (bright + noise * own);
            *pixel = Pixel {
                color: [color; 3],
                direct: [color; 3],
                albedo: [albedo; 3],
                alpha: 1.0,
                depth: 10.0,
                position: [x as f32, y as f32, 0.0],
                normal: if x < SIDE / 2 { [0.0, 0.0, 1.0] } else { [0.6, 0.0, 0.8] },
                footprint: 1.0,
                samples: 1.0,
                variance: albedo * albedo * noise * noise / 12.0,
                ..Pixel::EMPTY
            };
        }
        picture
    }

    /// Root mean square of the difference from the picture without noise.
    fn error(light: &[[f32; 3]]) -> f32 {
        let right = noisy(0.0);
        let squares = light.iter().zip(&right.pixels).map(|(a, b)| (a[0] - b.color[0]).powi(2));
        (squares.sum::<f32>() / light.len() as f32).sqrt()
    }

    #[test]
    fn noise_goes_and_edges_stay() {
        let picture = noisy(0.6);
        let before: Vec<[f32; 3]> = picture.pixels.iter().map(|p| p.color).collect();
        let after = denoise(&picture);
        assert!(error(&after) < 0.25 * error(&before), "{} {}", error(&after), error(&before));
        // Across the edge of the wall light is mixed no more than within a half.
        let row: Vec<f32> = (0..SIDE).map(|x| after[(4 * SIDE + x) as usize][0]).collect();
        let half = SIDE as usize / 2;
        assert!(row[half] - row[half - 1] > 0.3, "{row:?}");
    }

    /// A highlight is brighter than what is around it by more than its noise, which is large at its rim only.
    #[test]
    fn highlights_stay_as_large_as_they_are() {
        let mut picture = noisy(0.1);
        let is_bright = |i: usize| {
            let [x, y] = [i as u32 % SIDE, i as u32 / SIDE].map(|v| v.abs_diff(SIDE / 4));
            x * x + y * y < 20
        };
        for (i, pixel) in picture.pixels.iter_mut().enumerate().filter(|(i, _)| is_bright(*i)) {
            let spark = 20.0 + 10.0 * uniform(mix(7 + i as u64)) as f32;
            pixel.color = [spark * pixel.albedo[0]; 3];
            pixel.variance = 25.0;
        }
        let after = denoise(&picture);
        let sum = |light: &mut dyn Iterator<Item = f32>| light.sum::<f32>();
        let before = sum(&mut picture.pixels.iter().map(|p| p.color[0]));
        let there = sum(&mut after.iter().map(|c| c[0]));
        assert!((there / before - 1.0).abs() < 0.02, "{there} {before}");
        for (i, light) in after.iter().enumerate().filter(|(i, _)| !is_bright(*i)) {
            assert!(light[0] < 1.2, "{i}: {light:?}");
        }
    }

    /// Where few paths find any light, those that do speak for all.
    #[test]
    fn rare_finds_are_spread() {
        let mut picture = noisy(0.0);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            let found = if uniform(mix(3 + i as u64)) < 0.1 { 10.0 } else { 0.0 };
            pixel.color = pixel.color.map(|c| found * c);
            (pixel.direct, pixel.indirect) = ([0.0; 3], pixel.color);
            pixel.variance = pixel.color[0] * pixel.color[0];
        }
        let before: Vec<[f32; 3]> = picture.pixels.iter().map(|p| p.color).collect();
        let after = denoise(&picture);
        assert!(error(&after) < 0.3 * error(&before), "{} {}", error(&after), error(&before));
        let sum = |light: &[[f32; 3]]| light.iter().map(|c| c[0]).sum::<f32>();
        assert!((sum(&after) / sum(&before) - 1.0).abs() < 0.1, "{} {}", sum(&after), sum(&before));
    }

    /// What a coat mirrors is white on a surface of any colour.
    #[test]
    fn noise_of_what_is_mirrored_goes_from_surfaces_without_a_channel() {
        let mut picture = noisy(0.0);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            let mirrored = 0.2 * uniform(mix(11 + i as u64)) as f32;
            pixel.albedo = [0.6, 0.5, 0.01];
            pixel.color = std::array::from_fn(|c| pixel.albedo[c] + mirrored);
            pixel.direct = pixel.color;
            pixel.variance = 0.04 / 12.0;
        }
        let spread = |light: &[[f32; 3]]| {
            let mean = light.iter().map(|c| c[2]).sum::<f32>() / light.len() as f32;
            (light.iter().map(|c| (c[2] - mean).powi(2)).sum::<f32>() / light.len() as f32).sqrt()
        };
        let before: Vec<[f32; 3]> = picture.pixels.iter().map(|p| p.color).collect();
        let after = denoise(&picture);
        assert!(spread(&after) < 0.3 * spread(&before), "{} {}", spread(&after), spread(&before));
    }

    #[test]
    fn what_is_mirrored_by_one_surface_is_not_the_light_of_another() {
        let mut picture = noisy(0.0);
        let is_edge = |i: usize| i as u32 % SIDE == SIDE / 4;
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            // Half of a pixel on the edge shows the grey floor beside.
            pixel.normal = [0.0, 0.0, 1.0];
            pixel.albedo = if is_edge(i) { [0.3, 0.4, 0.3] } else { [0.02, 0.4, 0.02] };
            pixel.color = pixel.albedo.map(|albedo| albedo + if is_edge(i) { 0.0 } else { 0.2 });
            pixel.direct = pixel.color;
            pixel.variance = 0.01;
        }
        for (i, light) in denoise(&picture).iter().enumerate().filter(|(i, _)| is_edge(*i)) {
            assert!(light[0] < light[1] + 0.1, "{i}: {light:?}");
        }
    }

    #[test]
    fn what_has_no_noise_stays() {
        let picture = noisy(0.0);
        for (pixel, light) in picture.pixels.iter().zip(denoise(&picture)) {
            assert!((pixel.color[0] - light[0]).abs() < 1e-4);
        }
    }
}
