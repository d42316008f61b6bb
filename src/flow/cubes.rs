//! A cube in pieces, of which those are cut further where a bound on something is largest.

use crate::num::Interval;
use std::collections::BinaryHeap;

/// A cube, and a bound on something in it.
pub(super) struct Cube {
    bound: f64,
    pub middle: [f64; 3],
    half: f64,
}

/// By the bound, where there is none first; smaller ones first among equals.
impl Ord for Cube {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.bound.total_cmp(&other.bound).then(other.half.total_cmp(&self.half))
    }
}

impl PartialOrd for Cube {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cube {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cube {}

/// The pieces, and the bound.
pub(super) struct Cubes<B> {
    bound: B,
    waiting: BinaryHeap<Cube>,
}

impl<B: FnMut([Interval; 3]) -> f64> Cubes<B> {
    /// A cube around the origin, not cut yet.
    pub fn new(half: f64, bound: B) -> Self {
        let mut cubes = Cubes { bound, waiting: BinaryHeap::new() };
        cubes.add([0.0; 3], half);
        cubes
    }

    /// Adds a piece, unless there is nothing in it.
    fn add(&mut self, middle: [f64; 3], half: f64) {
        let bound = (self.bound)(middle.map(|c| Interval::around(c, half))).abs();
        if bound != 0.0 {
            self.waiting.push(Cube { bound, middle, half });
        }
    }

    /// Cuts the piece with the largest bound into eight, and returns it.
    pub fn cut(&mut self) -> Option<Cube> {
        let cube = self.waiting.pop()?;
        let half = 0.5 * cube.half;
        for corner in 0..8 {
            let side = |axis: usize| if corner >> axis & 1 == 0 { -half } else { half };
            self.add(std::array::from_fn(|axis| cube.middle[axis] + side(axis)), half);
        }
        Some(cube)
    }

    /// Whether the bound is below a number everywhere, as so many cuts tell.
    pub fn are_all_below(mut self, most: f64, cuts: usize) -> bool {
        let is_below = |cubes: &Self| cubes.waiting.peek().is_none_or(|cube| cube.bound < most);
        for _ in 0..cuts {
            if is_below(&self) {
                return true;
            }
            self.cut();
        }
        is_below(&self)
    }
}
