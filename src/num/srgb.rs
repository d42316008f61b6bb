//! Light and the numbers that stand for it in pictures and files: the transfer function of sRGB
//! (IEC 61966-2-1).

/// What stands for a linear value; made for values from 0 to 1, it goes on beyond them.
pub fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// The linear value that a number stands for.
pub fn decode(shown: f64) -> f64 {
    if shown <= 0.04045 { shown / 12.92 } else { libm::pow((shown + 0.055) / 1.055, 2.4) }
}
