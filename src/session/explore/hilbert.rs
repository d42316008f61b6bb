//! A line through all colours on which neighbours differ by one step of one channel: Hilbert's curve through the cube
//! of red, green and blue bytes. What is near on it is alike, so that places on it can be sampled and moved about like
//! those of a number.
//!
//! The turns and mirrors of the curve follow Skilling (2004, *Programming the Hilbert curve*): each bit of a coordinate
//! says whether the lower bits of the first one are flipped, or change places with its own.

/// Bits of a channel.
const BITS: u32 = 8;

/// How many colours there are.
pub const COLORS: u32 = 1 << (3 * BITS);

/// The colour at a place, from 0 to `COLORS - 1`.
pub fn color(place: u32) -> [u8; 3] {
    let mut x = [0u8; 3];
    for bit in 0..3 * BITS {
        // The highest bit is of the first channel, the next of the second.
        x[2 - (bit % 3) as usize] |= ((place >> bit & 1) as u8) << (bit / 3);
    }
    let carry = x[2] >> 1;
    x = [x[0] ^ carry, x[1] ^ x[0], x[2] ^ x[1]];
    for bit in 1..BITS {
        for axis in [2, 1, 0] {
            turn(&mut x, axis, bit);
        }
    }
    x
}

/// The place of a colour.
pub fn place(color: [u8; 3]) -> u32 {
    let mut x = color;
    for bit in (1..BITS).rev() {
        for axis in 0..3 {
            turn(&mut x, axis, bit);
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let flips = (1..BITS).filter(|bit| x[2] >> bit & 1 == 1).fold(0, |all, bit| all ^ lower(bit));
    x = x.map(|channel| channel ^ flips);
    let bit = |bit: u32| u32::from(x[2 - (bit % 3) as usize] >> (bit / 3) & 1) << bit;
    (0..3 * BITS).map(bit).sum()
}

/// The bits below one.
fn lower(bit: u32) -> u8 {
    (1 << bit) - 1
}

/// Does what a bit of a channel says; twice is not at all.
fn turn(x: &mut [u8; 3], axis: usize, bit: u32) {
    if x[axis] >> bit & 1 == 1 {
        x[0] ^= lower(bit);
    } else {
        let swapped = (x[0] ^ x[axis]) & lower(bit);
        x[0] ^= swapped;
        x[axis] ^= swapped;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_place_has_a_color_of_its_own(at in 0..COLORS) {
            prop_assert_eq!(place(color(at)), at);
        }

        #[test]
        fn every_color_has_a_place(bytes in any::<[u8; 3]>()) {
            prop_assert_eq!(color(place(bytes)), bytes);
        }

        #[test]
        fn neighbours_differ_by_one_step(at in 1..COLORS) {
            let [a, b] = [color(at - 1), color(at)];
            prop_assert_eq!(a.into_iter().zip(b).map(|(a, b)| a.abs_diff(b)).sum::<u8>(), 1);
        }
    }

    #[test]
    fn the_ends_are_at_corners() {
        assert_eq!(color(0), [0; 3]);
        assert!(color(COLORS - 1).iter().all(|channel| matches!(channel, 0 | 255)));
    }
}
