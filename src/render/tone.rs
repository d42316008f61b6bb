//! From light to eight bits: exposure, tone curve, sRGB, dither.
//!
//! The curve acts on the brightest channel and scales the other two with it, so that hue is kept
//! exactly; curves that act on every channel alone turn blue skies violet and lava yellow. Up to
//! [`SHOULDER`] it is the identity, and colours come out as the script says them. Above, it rolls
//! off like film does and never clips; what is much too bright bleaches towards white, as people
//! expect of very bright things. (The bleaching is that of the Khronos neutral tone mapper; its toe
//! is left out, since it darkens what scripts say.)
//!
//! Two other curves are there for those who ask: one with the toe and the contrast of film, and none.

use super::sample::dither;
use crate::num::srgb;
use crate::scene::Tone;

/// Where the curve begins to bend.
const SHOULDER: f64 = 0.6;

/// How fast what is too bright bleaches.
const BLEACH: f64 = 0.15;

/// The tone curve of the brightest channel.
fn curve(x: f64, tone: Tone) -> f64 {
    match tone {
        Tone::Neutral => neutral(x),
        Tone::Filmic => filmic(x),
        Tone::Linear => x.min(1.0),
    }
}

/// Film: dark parts get darker, mid greys brighter, bright parts roll off to 1 (Narkowicz 2016, a fit to the
/// reference curve of the ACES system).
fn filmic(x: f64) -> f64 {
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
}

/// The identity, continued by a hyperbola with the same slope that tends to 1.
fn neutral(x: f64) -> f64 {
    if x <= SHOULDER {
        return x;
    }
    let over = (x - SHOULDER) / (1.0 - SHOULDER);
    SHOULDER + (1.0 - SHOULDER) * over / (1.0 + over)
}

/// What a screen shows of light, both linear and in Rec. 709 primaries; results lie in [0, 1].
pub fn tone_map(light: [f64; 3], tone: Tone) -> [f64; 3] {
    let light = light.map(|c| if c > 0.0 { c.min(1e30) } else { 0.0 });
    let peak = light[0].max(light[1]).max(light[2]);
    if tone == Tone::Linear || peak == 0.0 {
        return light.map(|c| c.min(1.0));
    }
    let shown = curve(peak, tone);
    let bleach = 1.0 - 1.0 / (1.0 + BLEACH * (peak - shown).max(0.0));
    light.map(|c| {
        let c = c * (shown / peak);
        (c + (shown - c) * bleach).min(1.0)
    })
}

/// Brightness that a screen shows of a grey, from 0 to 1 in equal steps to the eye.
pub(super) fn brightness(light: f64, tone: Tone) -> f64 {
    srgb::encode(curve(light, tone))
}

/// The bytes of a pixel. Rounding goes up or down as a hash of the pixel says, with odds that keep
/// the mean right, so that slow gradients show no bands. The noise stays below half a step: black
/// stays black and white white.
pub(super) fn bytes(light: [f64; 3], (gain, tone): (f64, Tone), pixel: u64) -> [u8; 3] {
    let shown = tone_map(light.map(|c| c * gain), tone);
    std::array::from_fn(|channel| {
        let noise = 0.98 * (dither(pixel, channel as u64) - 0.5);
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
            let [r, g, b] = tone_map([x; 3], Tone::Neutral);
            assert!(r > last && r <= 1.0 && r == g && g == b);
            last = r;
        }
        assert!(tone_map([1e9; 3], Tone::Neutral)[0] > 0.999);
    }

    #[test]
    fn colours_up_to_the_shoulder_are_kept() {
        assert_eq!(tone_map([0.1, 0.6, 0.0], Tone::Neutral), [0.1, 0.6, 0.0]);
        assert_eq!(tone_map([0.1, 0.9, 0.0], Tone::Linear), [0.1, 0.9, 0.0]);
        assert_eq!(tone_map([3.0; 3], Tone::Linear), [1.0; 3]);
    }

    #[test]
    fn film_has_a_toe_and_a_shoulder() {
        let shown = |x: f64| tone_map([x; 3], Tone::Filmic)[0];
        assert!(shown(0.01) < 0.01 && shown(0.18) > 0.18 && shown(1.0) < 1.0 && shown(100.0) <= 1.0);
        let steps: Vec<f64> = (0..400).map(|i| shown(0.01 * f64::from(i))).collect();
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn hue_is_kept_when_bright() {
        for k in [1.0, 3.0, 20.0] {
            for tone in [Tone::Neutral, Tone::Filmic] {
                let [r, g, b] = tone_map([0.2 * k, 0.5 * k, 0.9 * k], tone);
                // Hue: where the middle channel lies between the others.
                assert!(((g - r) / (b - r) - (0.5 - 0.2) / (0.9 - 0.2)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn nonsense_is_shown_as_something() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
            for (tone, _) in Tone::ALL {
                assert!(tone_map([bad, 0.5, bad], tone).iter().all(|c| (0.0..=1.0).contains(c)));
            }
        }
    }

    #[test]
    fn dither_keeps_the_mean_and_the_ends() {
        let level = 0.2;
        let mean = |x: f64| {
            (0..20_000).map(|p| f64::from(bytes([x; 3], (1.0, Tone::Neutral), p)[0])).sum::<f64>() / 20_000.0
        };
        assert!((mean(level) - 255.0 * srgb::encode(level)).abs() < 0.02);
        assert_eq!(mean(0.0), 0.0);
        assert_eq!(mean(1e12), 255.0);
    }
}
