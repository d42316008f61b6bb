//! Randomness: a hash of what a number belongs to, never state.

/// splitmix64's finaliser (Steele, Lea, Flood 2014): every bit of the result depends on all of `x`.
#[inline(always)]
pub fn mix(x: u64) -> u64 {
    let z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The upper 53 bits of a hash as a number in `[0, 1)`.
#[inline(always)]
pub fn uniform(hash: u64) -> f64 {
    (hash >> 11) as f64 / (1_u64 << 53) as f64
}
