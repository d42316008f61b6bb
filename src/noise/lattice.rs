//! The integer lattice on which a noise puts its randomness: a hash of the node and the seed.
//!
//! A lattice may repeat after a number of cells, which makes the noise tile. Cells are numbered
//! modulo 2^32, so a noise that does not tile repeats after 2^32 cells.

use crate::num::mix;

/// A seed, and after how many cells the lattice repeats.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Lattice {
    /// Names the random field; different seeds give unrelated fields.
    pub seed: u64,
    /// Cells after which the lattice repeats along each axis; 0 for never. At most 2^24.
    pub period: [u32; 3],
}

impl Lattice {
    /// A lattice that does not repeat.
    pub fn new(seed: u64) -> Lattice {
        Lattice { seed, period: [0; 3] }
    }

    /// The seed as two words, each of which depends on all its bits.
    #[inline(always)]
    pub(super) fn key(&self) -> [u32; 2] {
        let mixed = mix(self.seed);
        [mixed as u32, (mixed >> 32) as u32]
    }

    /// Whether the lattice repeats along some axis.
    #[inline(always)]
    pub(super) fn tiles(&self) -> bool {
        self.period != [0; 3]
    }

    /// The cell that stands for a cell: its number within the period.
    #[inline(always)]
    pub(super) fn wrap(&self, axis: usize, cell: u32) -> u32 {
        match self.period[axis] {
            0 => cell,
            period => (cell as i32).rem_euclid(period as i32) as u32,
        }
    }
}

/// Cell number (modulo 2^32) and fraction of a coordinate.
///
/// Adding 3/2 2^52 rounds to an integer and leaves it in the low bits; unlike `floor` this is a
/// vector instruction everywhere. Beyond 2^51 there are no fractions worth the name, and the noise
/// is that of a node; infinities and NaN give NaN.
#[inline(always)]
pub(super) fn split(x: f64) -> (u32, f64) {
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let shifted = x + MAGIC;
    let nearest = shifted - MAGIC;
    let above = nearest > x;
    let floor = if above { nearest - 1.0 } else { nearest };
    let cell = (shifted.to_bits() as u32).wrapping_sub(u32::from(above));
    let fraction = if x.abs() < 2_251_799_813_685_248.0 { x - floor } else { x * 0.0 };
    (cell, fraction)
}

/// Odd constants near the golden ratio and the like (xxHash's), so that equal steps along
/// different axes change different bits. The word of a node is the xor of its three products.
pub(super) const STEP: [u32; 3] = [0x9e37_79b1, 0x85eb_ca77, 0xc2b2_ae3d];

/// Two rounds of xor-shift and multiply with the constants of lowbias32 (Wellons 2018); the high
/// bits, which are the ones taken, depend on all of `word`.
#[inline(always)]
pub(super) fn hash(word: u32, key: [u32; 2]) -> u32 {
    let h = word ^ key[0];
    let h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d).wrapping_add(key[1]);
    (h ^ (h >> 15)).wrapping_mul(0x846c_a68b)
}
