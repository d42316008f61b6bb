//! Arithmetics that enclose the field along a piece of a ray.
//!
//! | arithmetic | remembers of a quantity |
//! |---|---|
//! | [`Interval`] | its range: how the coordinates depend on one another is lost |
//! | [`Affine`] | which symbols it depends on, the place along the piece and every loss among them |
//! | [`Reduced`] | how it depends on the place along the piece, and the sum of all losses |
//!
//! All of them bound a noise by its jet at the middle of the piece (`noise`), not kernel by kernel as
//! the thesis does, so that one evaluation costs the same whether the piece is long or short.

use super::group::{Batch, LANES};
use crate::num::{Affine, Interval, Many, Number, Reduced, Symbol};

/// What an arithmetic knows of a quantity along a piece, which `e` runs along from -1 to 1:
/// `mid + slope e`, to within `rest`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    pub mid: f64,
    pub slope: f64,
    pub rest: f64,
}

/// An arithmetic that encloses quantities along a piece of a ray.
pub(super) trait Along: Number {
    /// How questions are answered together.
    type Batch: Batch<Lane = Self>;

    /// The points `middle + e half`, each coordinate known to within `rest`.
    fn line(middle: [f64; 3], half: [f64; 3], rest: f64) -> [Self; 3];

    /// The quantity as a band, for an arithmetic that can tell.
    fn band(&self) -> Option<Band> {
        None
    }
}

impl Along for Interval {
    type Batch = Many<Interval, LANES>;

    fn line(middle: [f64; 3], half: [f64; 3], rest: f64) -> [Self; 3] {
        std::array::from_fn(|axis| Interval::around(middle[axis], (half[axis].abs() + rest).next_up()))
    }
}

impl Along for Affine {
    // Its symbols are in memory of their own, of which vectors have nothing.
    type Batch = Affine;

    fn line(middle: [f64; 3], half: [f64; 3], rest: f64) -> [Self; 3] {
        let place = Symbol::fresh();
        std::array::from_fn(|axis| {
            Affine::new(middle[axis], half[axis], place).add(&Affine::over(Interval::radius(rest)))
        })
    }
}

impl Along for Reduced<1> {
    type Batch = Many<Reduced<1>, LANES>;

    fn line(middle: [f64; 3], half: [f64; 3], rest: f64) -> [Self; 3] {
        std::array::from_fn(|axis| Reduced::within(middle[axis], [half[axis]], rest))
    }

    fn band(&self) -> Option<Band> {
        Some(Band { mid: self.mid, slope: self.slope[0], rest: self.rest })
    }
}
