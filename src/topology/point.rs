//! Critical points of a field.

use super::matrix::eigen;
use crate::num::Taylor;
use glam::DVec3;

/// What a critical point is, by the signs of the eigenvalues of the Hessian there; how many are negative is its
/// Morse index.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Index 0: as the level rises past it, a component is born.
    Minimum,
    /// Index 1: two components meet, or one of them closes to a ring.
    #[serde(rename = "1-saddle")]
    Saddle1,
    /// Index 2: a tunnel is filled, or a void is closed off.
    #[serde(rename = "2-saddle")]
    Saddle2,
    /// Index 3: a void is filled.
    Maximum,
}

impl Kind {
    /// All kinds, by index.
    pub const ALL: [Kind; 4] = [Kind::Minimum, Kind::Saddle1, Kind::Saddle2, Kind::Maximum];

    /// Name.
    pub fn name(self) -> &'static str {
        ["minimum", "1-saddle", "2-saddle", "maximum"][self as usize]
    }
}

/// A point where the gradient vanishes: there is exactly one within `error` of `position`, if it is smooth.
#[derive(Clone, Copy, PartialEq, Debug, serde::Serialize, serde::Deserialize)]
pub struct CriticalPoint {
    /// Where.
    pub position: DVec3,
    /// How far off that may be.
    pub error: f64,
    /// The value of the field there.
    pub value: f64,
    /// How far off that may be.
    pub value_error: f64,
    /// What it is; this is proven, too.
    pub kind: Kind,
    /// Eigenvalues of the Hessian, in increasing order.
    pub eigenvalues: [f64; 3],
    /// Unit eigenvector of the first of them: the directions in which paths lead down from a 1-saddle.
    pub down: DVec3,
    /// Radius of a ball in which it is the only critical point.
    pub alone: f64,
    /// Whether it is what its Hessian says. If not it stands for all that is critical within `error`, which is
    /// surrounded by a sphere on which the field rises, or falls, outwards ([`isolated`](super::isolated)).
    pub smooth: bool,
}

impl CriticalPoint {
    /// From what is known of a ball of that radius that holds it, if that decides the kind.
    pub(super) fn new(position: DVec3, error: f64, alone: f64, radius: f64, f: &Taylor) -> Option<Self> {
        let (eigenvalues, vectors) = eigen(f.hess);
        // An eigenvalue moves by no more than the matrix, in norm; rotations round it by far less than 1e-13.
        let size = eigenvalues.into_iter().fold(0.0, |m: f64, l| m.max(l.abs()));
        let sure = eigenvalues.iter().all(|l| l.abs() > f.twist + 1e-13 * size);
        let kind = Kind::ALL[eigenvalues.iter().filter(|l| **l < 0.0).count()];
        let range = f.range;
        sure.then(|| CriticalPoint {
            position,
            error,
            value: f.value,
            value_error: (range.hi - f.value).max(f.value - range.lo),
            kind,
            eigenvalues: eigenvalues.map(|l| l / (radius * radius)),
            down: vectors[0],
            alone,
            smooth: true,
        })
    }

    /// Whether the value is certain to be negative, or positive.
    pub fn is_inside(&self) -> Option<bool> {
        if self.value + self.value_error < 0.0 {
            Some(true)
        } else if self.value - self.value_error > 0.0 {
            Some(false)
        } else {
            None
        }
    }
}
