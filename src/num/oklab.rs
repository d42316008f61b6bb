//! The perceptual space Oklab (Ottosson 2020): equal steps in it look about equally large.

use super::srgb;
use std::f64::consts::PI;

/// Linear red, green and blue of a lightness from 0 to 1, a chroma, and a hue in degrees. Screens cannot show all
/// of them: components below 0 or above 1 tell.
pub fn linear(lightness: f64, chroma: f64, hue: f64) -> [f64; 3] {
    let hue = hue * (PI / 180.0);
    let (a, b) = (chroma * libm::cos(hue), chroma * libm::sin(hue));
    let l = lightness + 0.3963377774 * a + 0.2158037573 * b;
    let m = lightness - 0.1055613458 * a - 0.0638541728 * b;
    let s = lightness - 0.0894841775 * a - 1.2914855480 * b;
    let [l, m, s] = [l, m, s].map(|c| c * c * c);
    [
        4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
        -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s,
    ]
}

/// The bytes that a screen shows of a linear colour, as well as it can.
pub fn bytes(linear: [f64; 3]) -> [u8; 3] {
    linear.map(|c| (255.0 * srgb::encode(c.clamp(0.0, 1.0))).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_are_grey_and_primaries_are_where_they_are() {
        for lightness in [0.0, 0.3, 1.0] {
            let [r, g, b] = linear(lightness, 0.0, 77.0);
            assert!((r - g).abs() < 1e-6 && (g - b).abs() < 1e-6 && (r - lightness.powi(3)).abs() < 1e-6);
        }
        // Red of sRGB, by the coordinates that its author gives.
        assert_eq!(bytes(linear(0.62796, 0.25768, 29.234)), [255, 0, 0]);
    }
}
