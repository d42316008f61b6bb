//! Which way gradients point in a ball, where the surface near it faces one way.
//!
//! All that is nearest to a place in the ball of radius `r` about `c` is within `R = d(c) + 2 r` of `c`. Let the normals
//! of all triangles within `R / m` have `n . a >= m > 0`. On the way along any `v` with `n . v >= 0` for all of them the
//! winding number can but fall, and such are all `v` within the angle `asin m` of the axis `a`; so are the ways from
//! `c - a R / m` to all places within `R`, and from those to `c + a R / m`. If the winding number is 1 at the former and 0 at
//! the latter, no place within `R` has another: all of the surface there is where the inside ends.
//!
//! With every place `p` the inside holds `p - t v` for small `t`. Where a ball of the outside touches it at `p`, from the
//! direction `u`, then `u . v >= 0` for all such `v`, so `u` is a sum of positive multiples of normals of triangles at `p`
//! (Farkas), and since its length is 1, the multiples add up to 1 or more and `u . a >= m`. It is the same from within. So
//! for all gradients in the ball, those at creases included, `g . a >= m`.

use super::Distance;
use super::nearest::{is_thin, square};
use super::search::slack;
use super::tree::{BLOCK, IS_BLOCK, NOTHING, WIDE, in_frame};
use super::winding::Surface;
use crate::num::{Lean, shortest};
use glam::DVec3;

/// Triangles that are looked at; a ball that has more is large.
const MOST: usize = 2000;

/// How far normals may be off: those of triangles that are not [thin](is_thin) by 7 roundoffs over 1e-6.
const BLUR: f64 = 1e-8;

impl Distance {
    /// What all gradients in a ball have in common, from the distance of its middle from the surface.
    pub(super) fn lean_around(&self, centre: DVec3, radius: f64, distance: f64) -> Option<Lean> {
        let slack = slack(self.size + centre.abs().max_element() + radius);
        let reach = distance + 2.0 * radius + 4.0 * slack + 2.0 * self.gap;
        // How far away triangles are looked at; all that must be depends on what is found.
        let mut looked = 1.1 * reach;
        for _ in 0..3 {
            let normals = self.normals_within(centre, looked)?;
            let axis = shortest(&normals).try_normalize()?;
            let least = normals.iter().fold(1.0, |m: f64, n| m.min(n.dot(axis))) - BLUR;
            if least <= 0.0 {
                return None;
            }
            let wanted = reach / least * (1.0 + BLUR);
            if wanted <= looked {
                let ends = [-wanted, wanted].map(|far| self.winding(centre + far * axis));
                let is_end = ends == [Some(1), Some(0)];
                return is_end.then_some(Lean { axis: axis.to_array(), least });
            }
            looked = 1.02 * wanted;
        }
        None
    }

    /// The winding number at a point, if it can be told.
    fn winding(&self, x: DVec3) -> Option<i32> {
        self.witnesses.number(Surface { tree: &self.tree, size: self.size }, x, &mut Vec::new())
    }

    /// The normals of all triangles that are within a distance; none if those are too many, or one is too thin.
    fn normals_within(&self, centre: DVec3, reach: f64) -> Option<Vec<DVec3>> {
        let mut normals = Vec::new();
        let mut stack = vec![0];
        while let Some(child) = stack.pop() {
            if child & IS_BLOCK == 0 {
                let node = self.tree.nodes.get(child as usize)?;
                let at = in_frame(centre, node.origin, &node.axes).to_array();
                for i in (0..WIDE).filter(|&i| node.child[i] != NOTHING) {
                    let off = |k: usize| {
                        let (lo, hi) = (f64::from(node.lo[k][i]), f64::from(node.hi[k][i]));
                        (lo - at[k]).max(at[k] - hi).max(0.0)
                    };
                    if DVec3::new(off(0), off(1), off(2)).length() <= reach {
                        stack.push(node.child[i]);
                    }
                }
                continue;
            }
            let block = &self.tree.blocks[(child & !IS_BLOCK) as usize];
            let triangles = (0..BLOCK).map(|lane| block.triangle(lane));
            // Corners that are not there are not numbers.
            for t in triangles.filter(|t| !t[0].x.is_nan()) {
                if square(t, centre).sqrt() > reach {
                    continue;
                }
                if is_thin(&t) || normals.len() == MOST {
                    return None;
                }
                normals.push((t[1] - t[0]).cross(t[2] - t[0]).try_normalize()?);
            }
        }
        Some(normals)
    }
}
