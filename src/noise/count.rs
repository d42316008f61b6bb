//! How many noises were evaluated: what a picture costs, counted where it happens.
//!
//! A tape knows how many octaves it has, but not how many it evaluates: sums of octaves end early,
//! fade out with distance and skip what is blind. So noises count themselves, in a number of the
//! thread's own, once a batch.

use std::cell::Cell;

thread_local! {
    static EVALUATED: Cell<u64> = const { Cell::new(0) };
}

/// Counts a noise at so many points.
#[inline(always)]
pub(super) fn count(points: usize) {
    EVALUATED.set(EVALUATED.get().wrapping_add(points as u64));
}

/// Noises that this thread has evaluated since it began: one for each octave at each point, or at the
/// centre of each region. All lanes of a batch count, also those that wait for others and repeat a
/// point; an octave that is skipped for the whole batch does not. A slope that is taken by differences
/// counts as what it evaluates.
///
/// Differences say what a piece of work evaluated, if all of it was done by one thread.
pub fn evaluated() -> u64 {
    EVALUATED.get()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Fractal, Gradient, Kind, Model, Noise, Recipe};
    use crate::num::{Interval, Jet, Many, Number};

    fn sum(octaves: u32) -> Fractal {
        let noise = Noise::new(Kind::Gradient(Gradient::default()), 7);
        Fractal::new(Recipe { octaves, ..Recipe::new(noise, Model::default()) }).unwrap()
    }

    /// Noises that a sum of 9 octaves evaluates at a number.
    fn cost<T: Number>(x: T) -> u64 {
        let fractal = sum(9);
        let before = evaluated();
        fractal.eval([&x, &x, &x], None);
        evaluated() - before
    }

    #[test]
    fn every_octave_of_every_lane_counts() {
        assert_eq!(cost(0.3), 9);
        assert_eq!(cost(Many([0.3; 32])), 9 * 32);
        assert_eq!(cost(Jet::<f64>::constant(0.3)), 9);
    }

    #[test]
    fn octaves_that_a_wide_box_makes_blind_do_not() {
        assert_eq!(cost(Interval::new(0.0, 100.0)), 0);
        let some = cost(Interval::new(0.3, 0.35));
        assert!(0 < some && some < 9, "{some}");
    }
}
