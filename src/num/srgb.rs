//! Light and the numbers that stand for it in pictures and files: the transfer function of sRGB
//! (IEC 61966-2-1).

/// What stands for a linear value; made for values from 0 to 1, it goes on beyond them.
pub fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        return 12.92 * linear;
    }
    // The exponent is 1 / 2.4 = 1/3 + 1/12; roots take a fraction of the time of a power.
    let root = libm::cbrt(linear);
    1.055 * root * root.sqrt().sqrt() - 0.055
}

/// The linear value that a number stands for.
pub fn decode(shown: f64) -> f64 {
    if shown <= 0.04045 { shown / 12.92 } else { libm::pow((shown + 0.055) / 1.055, 2.4) }
}

/// The bytes of a colour as on the web, `#rrggbb` or `#rgb`.
pub fn from_hex(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#')?.chars().map(|c| c.to_digit(16).map(|d| d as u8));
    match digits.collect::<Option<Vec<u8>>>()?[..] {
        [r, g, b] => Some([17 * r, 17 * g, 17 * b]),
        [a, b, c, d, e, f] => Some([16 * a + b, 16 * c + d, 16 * e + f]),
        _ => None,
    }
}

/// A colour as on the web.
pub fn to_hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
