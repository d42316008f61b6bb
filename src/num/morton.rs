//! Morton's curve: places whose numbers are close to one another are close themselves, mostly (Morton 1966).
//!
//! The number of a place has the bits of its coordinates in turns.

/// The number of a place in the plane.
#[inline]
pub fn morton2([x, y]: [u32; 2]) -> u64 {
    let spread = |t: u32| {
        let t = u64::from(t);
        let t = (t | t << 16) & 0x0000_FFFF_0000_FFFF;
        let t = (t | t << 8) & 0x00FF_00FF_00FF_00FF;
        let t = (t | t << 4) & 0x0F0F_0F0F_0F0F_0F0F;
        let t = (t | t << 2) & 0x3333_3333_3333_3333;
        (t | t << 1) & 0x5555_5555_5555_5555
    };
    spread(x) | spread(y) << 1
}

/// The number of a place in space, of which the ten lowest bits of each coordinate count.
#[inline]
pub fn morton3([x, y, z]: [u32; 3]) -> u32 {
    let spread = |t: u32| {
        let t = t & 0x3FF;
        let t = (t | t << 16) & 0x0300_00FF;
        let t = (t | t << 8) & 0x0300_F00F;
        let t = (t | t << 4) & 0x030C_30C3;
        (t | t << 2) & 0x0924_9249
    };
    spread(x) | spread(y) << 1 | spread(z) << 2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every so many bits of a number.
    fn every(n: u32, of: u64, from: u32) -> u32 {
        (0..32).filter(|i| n * i + from < 64).map(|i| ((of >> (n * i + from) & 1) as u32) << i).sum()
    }

    #[test]
    fn bits_come_in_turns() {
        for i in 0..2000_u32 {
            let [x, y, z] = [0x9E37_79B9, 0x85EB_CA6B, 0xC2B2_AE35].map(|k: u32| k.wrapping_mul(i));
            assert_eq!([0, 1].map(|k| every(2, morton2([x, y]), k)), [x, y]);
            let at = u64::from(morton3([x, y, z]));
            assert_eq!([0, 1, 2].map(|k| every(3, at, k)), [x, y, z].map(|t| t & 0x3FF));
        }
    }
}
