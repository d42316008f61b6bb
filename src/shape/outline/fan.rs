//! Fans of directions in the plane.

use crate::num::{Lean, ROUNDOFF};
use glam::DVec2;

/// All directions from one to another, counter-clockwise, by less than half a turn. Both are unit vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fan {
    right: DVec2,
    left: DVec2,
}

impl Fan {
    /// A single direction.
    pub fn of(direction: DVec2) -> Fan {
        Fan { right: direction, left: direction }
    }

    /// The least fan that holds one more direction too; false if that would be half a turn or more.
    pub fn widen(&mut self, to: DVec2) -> bool {
        let (from_right, from_left) = (self.right.perp_dot(to) >= 0.0, to.perp_dot(self.left) >= 0.0);
        match (from_right, from_left) {
            (true, true) => return to.dot(self.right + self.left) > 0.0,
            (true, false) => self.left = to,
            (false, true) => self.right = to,
            (false, false) => return false,
        }
        true
    }

    /// The direction in its middle, and what all others have along it if each may be off by a length.
    pub fn lean(&self, off: f64) -> Option<Lean> {
        let axis = (self.right + self.left).normalize_or_zero();
        let least = axis.dot(self.right).min(axis.dot(self.left)) - off - 32.0 * ROUNDOFF;
        (least > 0.0).then_some(Lean { axis: axis.extend(0.0).to_array(), least })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(degrees: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        DVec2::new(cos, sin)
    }

    fn fan(degrees: &[f64]) -> Option<Lean> {
        let mut fan = Fan::of(at(degrees[0]));
        degrees.iter().all(|d| fan.widen(at(*d))).then(|| fan.lean(0.0)).flatten()
    }

    #[test]
    fn fans_hold_what_they_were_widened_to_in_any_order() {
        for turn in (0..360).step_by(7).map(f64::from) {
            for list in [[-60.0, 0.0, 80.0, 20.0], [80.0, -60.0, 20.0, 0.0], [0.0, 80.0, -60.0, 20.0]] {
                let lean = fan(&list.map(|d| d + turn)).unwrap();
                let middle = at(10.0 + turn);
                assert!(middle.dot(DVec2::new(lean.axis[0], lean.axis[1])) > 1.0 - 1e-12, "{lean:?}");
                assert!((lean.least - libm::cos(70.0_f64.to_radians())).abs() < 1e-12, "{lean:?}");
            }
            assert_eq!(fan(&[turn, 180.0 + turn]).filter(|lean| lean.least > 1e-12), None);
            assert_eq!(fan(&[turn, 100.0 + turn, 200.0 + turn]), None);
            assert_eq!(fan(&[turn, 120.0 + turn, 240.0 + turn]), None);
        }
    }
}
