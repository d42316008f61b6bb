//! The constants of noises made of scattered spots: a search from below, a proof from above.
//!
//! **What is maximised.** With one node of unit weight and free sign in each of the 27 cells around a
//! point `x`, the largest `k`-th derivative along a unit vector `v` is
//!
//! ```text
//! F_k(x, v) = sum over cells of max over n in the cell of g_k(x - n, v)
//! ```
//!
//! where `g_k` is the size of the derivative of one spot. A round spot's derivatives depend on the
//! distance `r` and on the cosine `c` of the angle between `d` and `v`:
//!
//! ```text
//! h_0 = h      h_1 = h' c      h_2 = b + (h'' - b) c^2      h_3 = h''' c^3 + 3 g (c - c^3)
//! b = h'/r                                                  g = (h''/r - h'/r^2)
//! ```
//!
//! and for waves under the spot, of free direction and phase, `g_k` is the largest modulus of
//! `sum_j binom(k, j) (i s)^(k-j) h_j` for `|s| <= 2 pi F`. For `k` up to 2 its square is a convex
//! function of `s^2`, and largest at an end; for 3 it is a cubic, whose peak inside is looked at too.
//!
//! **Directions.** Let `M_k` be the supremum, taken at `x` and `v`. On the great circle through `v`
//! the `k`-th derivative of that very noise is a trigonometric polynomial of degree `k`, bounded by
//! `M_k` everywhere and equal to it at `v`; at an angle `t <= pi / k` from there it is at least
//! `M_k cos(k t)` (M. Riesz 1914). So it is enough that `F_k(x, v) <= T cos(k delta)` for a net of
//! directions with mesh `delta` and all `x`. The symmetries of the cube leave directions with falling
//! non-negative components.
//!
//! **Places.** For each direction of the net the ball of offsets is cut into voxels, and `g_k` bounded
//! on each from what it does by distance along the direction and aside ([`Profile`]). For `x` in a voxel
//! of the cell and a cell of nodes, the offsets fill a box of voxels; its maximum comes from sliding
//! maxima along the three axes ([`Windows`]), and the sums over 27 cells bound `F_k` for all `x` at once.
//! Finer voxels are used where coarse ones do not suffice.
//!
//! Sums of few terms are off by less than a part in 1e9, and tables are rounded up to `f32` with a
//! millionth to spare.

mod hunt;
mod profile;
mod spots;
#[cfg(test)]
mod tests;
mod windows;

use super::{Claim, Subject, unit};
use crate::noise::{gabor, scatter, sparse};
use crate::num::Bounds;
use hunt::hunt;
use profile::Profile;
use rayon::prelude::*;
use spots::Spots;
use windows::Windows;

const PLAIN: Spots = Spots { name: "sparse", lewis: false, margin: false, frequency: 0.0 };

/// All kernels and placements, and Gabor noise at the frequencies of its net.
static SPOTS: [Spots; 30] = [
    PLAIN,
    Spots { name: "sparse, disc", margin: true, ..PLAIN },
    Spots { name: "sparse, lewis", lewis: true, ..PLAIN },
    Spots { name: "sparse, lewis, disc", lewis: true, margin: true, ..PLAIN },
    Spots { name: "gabor", frequency: 2.0, ..PLAIN },
    Spots { name: "gabor, frequency 0.5", frequency: 0.5, ..PLAIN },
    Spots { name: "gabor, frequency 0.63", frequency: 0.63, ..PLAIN },
    Spots { name: "gabor, frequency 0.8", frequency: 0.8, ..PLAIN },
    Spots { name: "gabor, frequency 1", frequency: 1.0, ..PLAIN },
    Spots { name: "gabor, frequency 1.25", frequency: 1.25, ..PLAIN },
    Spots { name: "gabor, frequency 1.6", frequency: 1.6, ..PLAIN },
    Spots { name: "gabor, frequency 2.5", frequency: 2.5, ..PLAIN },
    Spots { name: "gabor, frequency 3.15", frequency: 3.15, ..PLAIN },
    Spots { name: "gabor, frequency 4", frequency: 4.0, ..PLAIN },
    Spots { name: "gabor, frequency 5", frequency: 5.0, ..PLAIN },
    Spots { name: "gabor, frequency 6.3", frequency: 6.3, ..PLAIN },
    Spots { name: "gabor, frequency 8", frequency: 8.0, ..PLAIN },
    Spots { name: "gabor, disc", margin: true, frequency: 2.0, ..PLAIN },
    Spots { name: "gabor, disc, frequency 0.5", margin: true, frequency: 0.5, ..PLAIN },
    Spots { name: "gabor, disc, frequency 0.63", margin: true, frequency: 0.63, ..PLAIN },
    Spots { name: "gabor, disc, frequency 0.8", margin: true, frequency: 0.8, ..PLAIN },
    Spots { name: "gabor, disc, frequency 1", margin: true, frequency: 1.0, ..PLAIN },
    Spots { name: "gabor, disc, frequency 1.25", margin: true, frequency: 1.25, ..PLAIN },
    Spots { name: "gabor, disc, frequency 1.6", margin: true, frequency: 1.6, ..PLAIN },
    Spots { name: "gabor, disc, frequency 2.5", margin: true, frequency: 2.5, ..PLAIN },
    Spots { name: "gabor, disc, frequency 3.15", margin: true, frequency: 3.15, ..PLAIN },
    Spots { name: "gabor, disc, frequency 4", margin: true, frequency: 4.0, ..PLAIN },
    Spots { name: "gabor, disc, frequency 5", margin: true, frequency: 5.0, ..PLAIN },
    Spots { name: "gabor, disc, frequency 6.3", margin: true, frequency: 6.3, ..PLAIN },
    Spots { name: "gabor, disc, frequency 8", margin: true, frequency: 8.0, ..PLAIN },
];

/// The same as subjects.
pub(super) const ALL: &[&dyn Subject] = &{
    let mut all: [&dyn Subject; SPOTS.len()] = [&SPOTS[0]; SPOTS.len()];
    let mut i = 0;
    while i < all.len() {
        all[i] = &SPOTS[i];
        i += 1;
    }
    all
};

impl Spots {
    /// Upper bound of `F_k(x, v)` over all `x`, with `n` voxels to a cell along each axis.
    fn upper(&self, profile: &Profile, v: [f64; 3], n: usize) -> f64 {
        let (e, side) = (1.0 / n as f64, 2 * n);
        let low = |i: usize| [i / side / side, i / side % side, i % side].map(|a| (a as f64 - n as f64) * e);
        let table = (0..side * side * side).map(|i| profile.voxel(v, low(i), e)).collect();
        let margin = if self.margin { (scatter::MARGIN * n as f64).round() as usize } else { 0 };
        Windows::new(table, n, margin).sums().fold(0.0, f64::max)
    }

    fn bounds(&self) -> Bounds {
        if self.frequency > 0.0 {
            gabor::unit(self.margin, self.frequency)
        } else {
            sparse::UNIT[usize::from(self.lewis)][usize::from(self.margin)]
        }
    }
}

/// Tiles along an edge of a face of the cube of directions, by order: `k` times the mesh is about
/// 0.16, whose cosine costs little more than a hundredth.
const TILES: [usize; 4] = [1, 5, 9, 13];

/// Voxels to a cell, from coarse to fine; multiples of 10, so that margins are whole.
const FINENESS: [usize; 5] = [20, 40, 60, 80, 100];

impl Subject for Spots {
    fn name(&self) -> &'static str {
        self.name
    }

    fn claims(&self) -> Vec<Claim> {
        let b = self.bounds();
        let all = [("A", b.range), ("L", b.lipschitz), ("M2", b.hessian), ("M3", b.third)];
        let claims = all.into_iter().enumerate().map(|(order, (name, bound))| Claim { order, name, bound });
        // Values are those of the envelope at all frequencies: proven once, at the default.
        let is_new = |c: &Claim| c.order > 0 || [0.0, 2.0].contains(&self.frequency);
        claims.filter(|c| c.bound.is_finite() && is_new(c)).collect()
    }

    fn search(&self, order: usize, starts: u64) -> f64 {
        hunt(self, order, starts)
    }

    fn prove(&self, claim: &Claim, budget: u64) -> Option<u64> {
        let k = claim.order;
        let tiles = TILES[k];
        let mesh = k as f64 * 0.5 * 2.0_f64.sqrt() / tiles as f64;
        let room = claim.bound * libm::cos(mesh) * (1.0 - 1e-9);
        let middle = |i: usize| (i as f64 + 0.5) / tiles as f64;
        let net: Vec<[f64; 3]> = (0..tiles * tiles)
            .filter(|i| i / tiles >= i % tiles)
            .map(|i| unit([1.0, middle(i / tiles), middle(i % tiles)]))
            .collect();
        let profile = Profile::new(self, k);
        let settle = |v: &[f64; 3]| {
            let mut voxels = 0;
            for n in FINENESS {
                voxels += (n * n * n) as u64;
                if voxels > budget {
                    return None;
                }
                if self.upper(&profile, *v, n) <= room {
                    return Some(voxels);
                }
            }
            None
        };
        net.par_iter().map(settle).try_reduce(|| 0, |a, b| Some(a + b))
    }
}
