//! From light to eight bits: exposure, tone curve, sRGB, dither.
//!
//! The curve acts on the brightest channel and scales the other two with it, so that hue is kept
//! exactly; curves that act on every channel alone turn blue skies violet and lava yellow. Up to
//! [`SHOULDER`] it is the identity, and colours come out as the script says them. Above, it rolls
//! off like film does and never clips; what is much too bright bleaches towards white, as people
//! expect of very bright things. (The bleaching is that of the Khronos neutral tone mapper; its toe
//! is left out, since it darkens what scripts say.)

use super::sample::{Purpose, uniform};
use crate::num::srgb;

/// Where the curve begins to bend.
const SHOULDER: f64 = 0.6;

/// How fast what is too bright bleaches.
const BLEACH: f64 = 0.15;

/// The tone curve of the brightest channel: the identity, continued by a hyperbola with the same
/// slope that tends to 1.
fn curve(x: f64) -> f64 {
    if x <= SHOULDER {
        return x;
    }
    let over = (x - SHOULDER) / (1.0 - SHOULDER);
    SHOULDER + (1.0 - SHOULDER) * over / (1.0 + over)
}

/// What a screen shows of light, both linear and in Rec. 709 primaries; results lie in [0, 1].
pub fn tone_map(light: [f64; 3]) -> [f64; 3] {
    let light = light.map(|c| if c > 0.0 { c.min(1e30) } else { 0.0 });
    let peak = light[0].max(light[1]).max(light[2]);
    if peak <= SHOULDER {
        return light;
    }
    let shown = curve(peak);
    let bleach = 1.0 - 1.0 / (1.0 + BLEACH * (peak - shown));
    light.map(|c| {
        let c = c * (shown / peak);
        (c + (shown - c) * bleach).min(1.0)
    })
}

/// The bytes of a pixel. Rounding goes up or down as a hash of the pixel says, with odds that keep
/// the mean right, so that slow gradients show no bands. The noise stays below half a step: black
/// stays black and white white.
pub(super) fn bytes(light: [f64; 3], gain: f64, pixel: u64) -> [u8; 3] {
    let shown = tone_map(light.map(|c| c * gain));
    std::array::from_fn(|channel| {
        let noise = 0.98 * (uniform(pixel, 0, Purpose::Dither(channel as u8), 0) - 0.5);
        (255.0 * srgb::encode(shown[channel]) + noise).round().clamp(0.0, 255.0) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_grow_monotonically_and_stay_grey() {
        let mut last = -1.0;
        for i in 0..20_000 {
            let x = 1e-3 * f64::from(i);
            let [r, g, b] = tone_map([x; 3]);
            assert!(r > last && r <= 1.0 && r == g && g == b);
            last = r;
        }
        assert!(tone_map([1e9; 3])[0] > 0.999);
    }

    #[test]
    fn colours_up_to_the_shoulder_are_kept() {
        assert_eq!(tone_map([0.1, 0.6, 0.0]), [0.1, 0.6, 0.0]);
    }

    #[test]
    fn hue_is_kept_when_bright() {
        for k in [1.0, 3.0, 20.0] {
            let [r, g, b] = tone_map([0.2 * k, 0.5 * k, 0.9 * k]);
            // Hue: where the middle channel lies between the others.
            assert!(((g - r) / (b - r) - (0.5 - 0.2) / (0.9 - 0.2)).abs() < 1e-12);
        }
    }

    #[test]
    fn nonsense_is_shown_as_something() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
            assert!(tone_map([bad, 0.5, bad]).iter().all(|c| (0.0..=1.0).contains(c)));
        }
    }

    #[test]
    fn dither_keeps_the_mean_and_the_ends() {
        let level = 0.2;
        let mean = |x: f64| (0..20_000).map(|p| f64::from(bytes([x; 3], 1.0, p)[0])).sum::<f64>() / 20_000.0;
        assert!((mean(level) - 255.0 * srgb::encode(level)).abs() < 0.02);
        assert_eq!(mean(0.0), 0.0);
        assert_eq!(mean(1e12), 255.0);
    }
}
