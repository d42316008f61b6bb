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

/// Rounds to the nearest integer below 2^51 and leaves it in the low bits; unlike `floor` this is a
/// vector instruction everywhere.
const MAGIC: f64 = 6_755_399_441_055_744.0;

/// Cell number (modulo 2^32) and fraction of a coordinate.
///
/// Beyond 2^51 there are no fractions worth the name, and the noise is that of a node; infinities
/// and NaN give NaN.
#[inline(always)]
pub(super) fn split(x: f64) -> (u32, f64) {
    let (cell, _, fraction) = parts(x);
    (cell, fraction)
}

/// Cell number, floor and fraction.
#[inline(always)]
fn parts(x: f64) -> (u32, f64, f64) {
    let shifted = x + MAGIC;
    let nearest = shifted - MAGIC;
    let above = nearest > x;
    let floor = if above { nearest - 1.0 } else { nearest };
    let cell = (shifted.to_bits() as u32).wrapping_sub(u32::from(above));
    let fraction = if x.abs() < 2_251_799_813_685_248.0 { x - floor } else { x * 0.0 };
    (cell, floor, fraction)
}

/// A lattice as bulk evaluation sees it: along each axis the words of the cell of a coordinate, of
/// the one before and of the one after. The word of a node is the xor of one word for each axis.
#[derive(Clone, Copy)]
pub(super) struct Cells {
    pub key: [u32; 2],
    period: [u32; 3],
    tiles: bool,
}

/// The words of three neighbouring cells along an axis and the place in the middle one, in lanes.
pub(super) struct Row<const B: usize> {
    pub before: [u32; B],
    pub here: [u32; B],
    pub after: [u32; B],
    pub t: [f64; B],
}

impl Cells {
    #[inline(always)]
    pub(super) fn new(lattice: &Lattice) -> Cells {
        Cells { key: lattice.key(), period: lattice.period, tiles: lattice.tiles() }
    }

    /// The cells of a block of coordinates. What a caller does not read is not computed.
    #[inline(always)]
    pub(super) fn rows<const B: usize>(&self, at: &[[f64; B]; 3]) -> [Row<B>; 3] {
        let mut rows = [0, 1, 2].map(|_| Row { before: [0; B], here: [0; B], after: [0; B], t: [0.0; B] });
        for (axis, row) in rows.iter_mut().enumerate() {
            if self.tiles {
                let period = self.period[axis];
                for i in 0..B {
                    let ([before, here, after], t) = wrapped(at[axis][i], period);
                    row.t[i] = t;
                    row.before[i] = before.wrapping_mul(STEP[axis]);
                    row.here[i] = here.wrapping_mul(STEP[axis]);
                    row.after[i] = after.wrapping_mul(STEP[axis]);
                }
            } else {
                for i in 0..B {
                    let (cell, t) = split(at[axis][i]);
                    let word = cell.wrapping_mul(STEP[axis]);
                    row.before[i] = word.wrapping_sub(STEP[axis]);
                    row.here[i] = word;
                    row.after[i] = word.wrapping_add(STEP[axis]);
                    row.t[i] = t;
                }
            }
        }
        rows
    }
}

/// Numbers within the period of the cells before, at and after a coordinate, and its fraction;
/// period 0 is 2^32.
///
/// Integer division is no vector instruction. Instead the whole number of periods is found in
/// floating point. Below 2^51 the quotient is off by less than a quarter before it is rounded
/// (exact for a period of 1; below 2^50, and right to two roundoffs, for longer ones), so what is
/// left after taking that many periods away, which is exact, lies within three quarters of a period
/// of zero, and one correction suffices.
#[inline(always)]
fn wrapped(x: f64, period: u32) -> ([u32; 3], f64) {
    let (cell, floor, fraction) = parts(x);
    let length = f64::from(period);
    let periods = (floor * (1.0 / length) + MAGIC) - MAGIC;
    let left = floor - periods * length;
    let left = if left < 0.0 { left + length } else { left };
    let folded = (left + MAGIC).to_bits() as u32;
    let here = if period == 0 { cell } else { folded };
    let after = here.wrapping_add(1);
    let after = if after == period { 0 } else { after };
    let before = if here == 0 { period } else { here };
    ([before.wrapping_sub(1), here, after], fraction)
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
