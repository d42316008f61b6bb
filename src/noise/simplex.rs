//! Simplex noise (Perlin 2001; Gustavson 2005), on the body-centred cubic lattice.
//!
//! Nodes with directions `g` as in gradient noise, but each reaches a ball of radius `sqrt(1/2)`, and
//! four balls at most reach a point:
//!
//! ```text
//! N(x) = C sum_n max(1/2 - |d|^2, 0)^4 (g . d)        d = x - n
//! ```
//!
//! **Lattice.** The textbook skews the integer lattice along the main diagonal. What comes out is, up
//! to a mirror, the lattice of the corners and centres of unit cubes, the body-centred cubic one:
//! the textbook's vectors between neighbours, `(5, -1, -1)/6` and the like, have the mirror images
//! `(1, -1, -1)/2` in the plane through the origin across the diagonal. Here the cubes stand upright.
//! With directions on the sphere that is the same noise seen from another side. With the twelve of the
//! edges it is another noise, since these do not follow the mirror: its bounds are the same but for
//! third derivatives, whose supremum is 467.2 here and 480.4 in the textbook's frame. Upright cubes
//! have three virtues: the noise tiles after any
//! whole number of cells; cells are found from coordinates as they are, without a sum that rounds; and
//! one forty-eighth of a cube stands for all of space when its bounds are proven.
//!
//! **Simplices.** The Delaunay tetrahedra of this lattice join an edge of a cube to an edge of its
//! dual (the lattice of centres). For a point with fractional coordinates `t`, let `d` be its offset
//! from the nearest corner. Its tetrahedron has that corner; the next corner along the axis where
//! `|d|` is largest; the centre of the cube; and the next centre across the face that is nearest the
//! centre's offset, which is along the axis where `|d|` is smallest. The radius is the distance from a
//! vertex to the opposite face (a plane such as `x + y = 1`), the largest for which a ball ends
//! before its node is let go, so every derivative up to the third is continuous: the noise is C3.
//! (The radius `sqrt(0.6)` that much code has makes it jump.) When rounding picks a neighbouring
//! tetrahedron, what it misses is a ball's rim, where the kernel and two derivatives are zero.
//!
//! Over space and all seeds it has mean 0; with two nodes to a unit of volume and `E[g g^T] = 2/3 I`, its
//! variance is `4/3 C^2` times the integral of `|d|^2 (1/2 - |d|^2)^8` over a ball: 0.15401 with the
//! twelve directions, 0.15098 with all.

use super::basis::Basis;
use super::bulk::{self, GRADIENT, HESSIAN, Lanes};
use super::lattice::{Cells, Lattice, hash};
use super::node::{self, Corner, Directions, Node, OnEdges, OnSphere};
use super::parameter::{Parameter, Settings};
use crate::num::{Bounds, Class, Jets, Order, Point, ROUNDOFF};
use std::marker::PhantomData;

/// Simplex noise at unit frequency: a cube of the lattice is one unit long and holds two nodes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Simplex {
    /// Directions of the nodes.
    pub directions: Directions,
}

impl Simplex {
    /// The factor `C`, which makes 1 the supremum of the noise.
    pub(super) const fn scale(self) -> f64 {
        match self.directions {
            Directions::Edges => 76.88,
            Directions::Sphere => 76.12,
        }
    }
}

impl Basis for Simplex {
    const PARAMETERS: &'static [Parameter] = &[Directions::PARAMETER];

    fn new(settings: &Settings) -> Self {
        Simplex { directions: Directions::of(settings) }
    }

    fn class(&self) -> Class {
        Class::C2
    }

    /// Proven by `examples/certify_noise.rs` (see [`certify`](super::certify)).
    #[inline]
    fn bounds(&self) -> Bounds {
        match self.directions {
            Directions::Edges => Bounds { range: 1.0, lipschitz: 6.98, hessian: 48.9, third: 485.0 },
            Directions::Sphere => Bounds { range: 1.0, lipschitz: 7.82, hessian: 54.8, third: 543.0 },
        }
    }

    /// The mean power spectrum is isotropic, as the kernel's weight is: the square of the slope of its
    /// Fourier transform. It peaks at 0.85 cycles a unit and is 20 dB down at 2.06 (1.98 in planes).
    fn band(&self) -> f64 {
        2.05
    }

    /// An offset is off by half a roundoff and so `1/2 - |d|^2` by 3; of its fourth power times `|d|`
    /// and `C sqrt(2)` that makes 28 roundoffs at most, and 10 of the value for the products, for each of
    /// four nodes: budgeted as 256. A gradient has `8 q^3 |d|^2` and a Hessian `48 q^2 |d|^3` in place of
    /// `q^4 |d|`, whose slopes in `q` are a few times their own bounds.
    #[inline(always)]
    fn rounding(&self) -> [f64; 3] {
        let b = self.bounds();
        [256.0 * ROUNDOFF * b.range, 256.0 * ROUNDOFF * b.lipschitz, 512.0 * ROUNDOFF * b.hessian]
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        match self.directions {
            Directions::Edges => bulk::jets(|| Simplices::<1, OnEdges>::new(*self, lattice), at, out),
            Directions::Sphere => bulk::jets(|| Simplices::<3, OnSphere>::new(*self, lattice), at, out),
        }
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        match self.directions {
            Directions::Edges => bulk::jet(Simplices::<1, OnEdges>::new(*self, lattice), order, at),
            Directions::Sphere => bulk::jet(Simplices::<3, OnSphere>::new(*self, lattice), order, at),
        }
    }
}

/// Sets the centre of a cube apart from its first corner.
const CENTRE: u32 = 0x2545_f491;

/// Simplex noise whose nodes are `N`.
#[derive(Clone, Copy)]
struct Simplices<const W: usize, N> {
    cells: Cells,
    scale: f64,
    node: PhantomData<N>,
}

impl<const W: usize, N: Node<W>> Simplices<W, N> {
    #[inline(always)]
    fn new(noise: Simplex, lattice: &Lattice) -> Self {
        Simplices { cells: Cells::new(lattice), scale: noise.scale(), node: PhantomData }
    }
}

/// The simplex of a point within its cube: which half of the cube along each axis, and the axes of
/// the tetrahedron's two long edges.
#[derive(Clone, Copy)]
struct Place {
    upper: [bool; 3],
    corners: [bool; 3],
    centres: [bool; 3],
}

impl Place {
    #[inline(always)]
    fn of(t: [f64; 3]) -> Place {
        let upper = [t[0] >= 0.5, t[1] >= 0.5, t[2] >= 0.5];
        let [x, y, z] = three(|i| if upper[i] { 1.0 - t[i] } else { t[i] });
        // The first of the largest and the last of the smallest: never the same axis.
        let (long_x, short_z) = ((x >= y) & (x >= z), (z <= x) & (z <= y));
        let (long_y, short_y) = (!long_x & (y >= z), !short_z & (y <= x));
        Place {
            upper,
            corners: [long_x, long_y, !long_x & !long_y],
            centres: [!short_z & !short_y, short_y, short_z],
        }
    }

    /// Offsets from the four nodes along an axis: corners, then centres.
    #[inline(always)]
    fn offsets(&self, i: usize, t: f64) -> [f64; 4] {
        let (near, far) = if self.upper[i] { (t - 1.0, t) } else { (t, t - 1.0) };
        let centre = t - 0.5;
        let across = if self.upper[i] { centre - 1.0 } else { centre + 1.0 };
        [
            near,
            if self.corners[i] { far } else { near },
            centre,
            if self.centres[i] { across } else { centre },
        ]
    }

    /// Words of the four nodes along an axis.
    #[inline(always)]
    fn words(&self, i: usize, [before, here, after]: [u32; 3]) -> [u32; 4] {
        let (near, far) = if self.upper[i] { (after, here) } else { (here, after) };
        let across = if self.upper[i] { after } else { before };
        [near, if self.corners[i] { far } else { near }, here, if self.centres[i] { across } else { here }]
    }
}

impl<const W: usize, N: Node<W>> Lanes for Simplices<W, N> {
    const HALVES: bool = true;

    #[inline(always)]
    fn block<const ORDER: u8, const PARTS: usize, const B: usize>(
        &mut self,
        from: &[[f64; B]; 3],
        to: &mut [[f64; B]; PARTS],
    ) {
        let rows = self.cells.rows(from);
        let mut hashes = [[0; B]; 4];
        for i in 0..B {
            let place = Place::of([rows[0].t[i], rows[1].t[i], rows[2].t[i]]);
            let [x, y, z] = three(|a| place.words(a, [rows[a].before[i], rows[a].here[i], rows[a].after[i]]));
            let h = each(|c| {
                let word = x[c] ^ y[c] ^ z[c];
                hash(if c < 2 { word } else { word ^ CENTRE }, self.cells.key)
            });
            for c in 0..4 {
                hashes[c][i] = h[c];
            }
        }
        let words = each(|c| node::words::<W, N, B>(&hashes[c]));
        for i in 0..B {
            let nodes = each(|c| {
                let mut node = [0; W];
                for (own, word) in node.iter_mut().zip(&words[c]) {
                    *own = word[i];
                }
                node
            });
            let p = jet::<ORDER, W, N>(nodes, [rows[0].t[i], rows[1].t[i], rows[2].t[i]]);
            to[0][i] = self.scale * p.value;
            if ORDER >= GRADIENT {
                for k in 0..3 {
                    to[1 + k][i] = self.scale * p.grad[k];
                }
            }
            if ORDER >= HESSIAN {
                for k in 0..6 {
                    to[4 + k][i] = self.scale * p.hess[k];
                }
            }
        }
    }
}

/// The jet but for the scale. With `q = 1/2 - |d|^2` and `p = g . d`, a node contributes
///
/// ```text
/// value     q^4 p
/// gradient  q^4 g - 8 q^3 p d
/// Hessian   48 q^2 p d d^T - 8 q^3 (g d^T + d g^T + p I)
/// ```
#[inline(always)]
fn jet<const ORDER: u8, const W: usize, N: Node<W>>(nodes: [[u32; W]; 4], t: [f64; 3]) -> Point {
    let place = Place::of(t);
    let [x, y, z] = [place.offsets(0, t[0]), place.offsets(1, t[1]), place.offsets(2, t[2])];
    let [a, b, c, d] = each(|c| part::<ORDER, W, N>(nodes[c], [x[c], y[c], z[c]]));
    let sum = |a: f64, b: f64, c: f64, d: f64| (a + b) + (c + d);
    let mut out = Point { value: sum(a.value, b.value, c.value, d.value), ..Point::default() };
    if ORDER >= GRADIENT {
        out.grad = three(|k| sum(a.grad[k], b.grad[k], c.grad[k], d.grad[k]));
    }
    if ORDER >= HESSIAN {
        for k in 0..6 {
            out.hess[k] = sum(a.hess[k], b.hess[k], c.hess[k], d.hess[k]);
        }
    }
    out
}

/// What one node contributes.
#[inline(always)]
fn part<const ORDER: u8, const W: usize, N: Node<W>>(node: [u32; W], d: [f64; 3]) -> Point {
    let Corner { p, g } = N::corner(node, d);
    let rest = 0.5 - ((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]);
    // A comparison that lets a NaN pass.
    let q = if rest < 0.0 { 0.0 } else { rest };
    let q2 = q * q;
    let q4 = q2 * q2;
    let mut out = Point { value: q4 * p, ..Point::default() };
    if ORDER >= GRADIENT {
        let q3 = 8.0 * (q2 * q);
        let along = q3 * p;
        out.grad = three(|k| q4 * g[k] - along * d[k]);
        if ORDER >= HESSIAN {
            let bend = 48.0 * (q2 * p);
            let (u, v) = (three(|k| bend * d[k]), three(|k| q3 * d[k]));
            let same = |i: usize| (u[i] * d[i] - 2.0 * (v[i] * g[i])) - along;
            let cross = |i: usize, j: usize| u[i] * d[j] - (v[i] * g[j] + v[j] * g[i]);
            out.hess = [same(0), same(1), same(2), cross(0, 1), cross(0, 2), cross(1, 2)];
        }
    }
    out
}

/// A plain array: `array::map` is not always inlined, and what is not inlined is not vectorised.
#[inline(always)]
fn three<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// An array over nodes, spelled out as in [`blend`](super::blend).
#[inline(always)]
fn each<T>(f: impl Fn(usize) -> T) -> [T; 4] {
    [f(0), f(1), f(2), f(3)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::lattice::STEP;
    use crate::noise::tests::{Random, Two, compare};
    use crate::noise::{Kind, Noise};

    /// The sum over all nodes near, in twice the precision.
    fn reference<const W: usize, N: Node<W>>(noise: Simplex, seed: u64, at: [f64; 3]) -> [Two; 10] {
        let cells = Cells::new(&Lattice::new(seed));
        let floor = at.map(f64::floor);
        let mut out = [Two(0.0, 0.0); 10];
        for n in 0..128_i32 {
            let centre = n >= 64;
            let step = [n & 3, n >> 2 & 3, n >> 4 & 3].map(|n| n - 1);
            let row = |a: usize| ((floor[a] as i64 + i64::from(step[a])) as u32).wrapping_mul(STEP[a]);
            let word = row(0) ^ row(1) ^ row(2) ^ if centre { CENTRE } else { 0 };
            let g = N::corner(N::words(hash(word, cells.key)), [0.0; 3]).g;
            let middle = if centre { 0.5 } else { 0.0 };
            let d = [0, 1, 2].map(|a| Two::sum(at[a] - floor[a], -(f64::from(step[a]) + middle)));
            let q = Two(0.5, 0.0) + (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * Two(-1.0, 0.0);
            if q.0 <= 0.0 {
                continue;
            }
            let c = |x: f64| Two(noise.scale() * x, 0.0);
            let g = g.map(|g| Two(g, 0.0));
            let p = g[0] * d[0] + g[1] * d[1] + g[2] * d[2];
            let (q2, q3, q4) = (q * q, q * q * q, q * q * q * q);
            out[0] = out[0] + c(1.0) * q4 * p;
            for i in 0..3 {
                out[1 + i] = out[1 + i] + c(1.0) * q4 * g[i] + c(-8.0) * q3 * p * d[i];
            }
            for (k, [i, j]) in [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
                let h = c(48.0) * q2 * p * d[i] * d[j] + c(-8.0) * q3 * (g[i] * d[j] + g[j] * d[i]);
                let h = if i == j { h + c(-8.0) * q3 * p } else { h };
                out[4 + k] = out[4 + k] + h;
            }
        }
        out
    }

    #[test]
    fn rounding_is_bounded_and_no_node_is_missed() {
        let mut random = Random::new(1);
        for noise in [Directions::Edges, Directions::Sphere].map(|directions| Simplex { directions }) {
            for i in 0..4000 {
                // Now and then on the planes where tetrahedra meet.
                let mut p = random.point(20.0).map(|x| (x * 1e9).round() / 1_073_741_824.0);
                if i % 4 == 0 {
                    p[1] = p[0] + f64::from(i % 3) * 0.5;
                }
                let exact = match noise.directions {
                    Directions::Edges => reference::<1, OnEdges>(noise, 5, p),
                    Directions::Sphere => reference::<3, OnSphere>(noise, 5, p),
                };
                compare(&Noise::new(Kind::Simplex(noise), 5), p, exact);
            }
        }
    }
}
