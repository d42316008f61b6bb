//! Children: each parameter from one of two parents, and some of them changed a little; expressions likewise.

use super::space::Axis;
use crate::num::{mix, uniform};
use crate::scene::Value;

/// Share of parameters that mutate.
const RATE: f64 = 0.5;

/// How parameter sets come from others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breeding {
    /// How far a parameter may go, as a share of its range; at 0 none changes.
    pub reach: f64,
    /// What decides about everything that is left to chance.
    pub seed: u64,
}

impl Breeding {
    /// Which two of a number of parents a child has; the same twice if there is only one.
    pub fn parents(&self, among: usize, child: u64) -> [usize; 2] {
        let many = among.max(1);
        let first = (self.chance(child, 0, 0) * many as f64) as usize;
        let others = many.saturating_sub(1).max(1);
        let step = 1 + (self.chance(child, 0, 1) * others as f64) as usize;
        [first, (first + step) % many]
    }

    /// The value of a child, given those of its parents.
    pub fn inherit(&self, axis: &Axis, number: usize, parents: [&Value; 2], child: u64) -> Value {
        let chance = |what: u64| self.chance(child, 1 + number as u64, what);
        let value = parents[usize::from(chance(0) < 0.5)];
        if self.reach == 0.0 || chance(1) >= RATE {
            return value.clone();
        }
        // A whole number or a name is meant as any place in its share: else it would stay for ever where the reach is
        // less than that.
        let place = axis.place(value, chance(2));
        // The sum of two is more often small than large.
        let step = self.reach * (chance(3) + chance(4) - 1.0);
        axis.value(reflected(place + step))
    }

    /// A number in `[0, 1)` for a purpose.
    pub(super) fn chance(&self, child: u64, number: u64, what: u64) -> f64 {
        uniform(mix(mix(mix(self.seed ^ mix(child)) ^ number) ^ what))
    }
}

/// A place that went over an end of the unit interval, as far within.
fn reflected(place: f64) -> f64 {
    let folded = place.rem_euclid(2.0);
    if folded > 1.0 { 2.0 - folded } else { folded }
}
