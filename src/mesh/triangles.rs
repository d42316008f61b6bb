//! From quadrangles to triangles, and how far these are from the surface.

use super::contour::Vertex;
use super::lattice::Lattice;
use super::merge::{Forest, Merged};
use super::weave::Quad;
use super::{Deviation, survey};
use crate::field::{Stopped, Watch};
use crate::shape::{Census, Mesh};
use crate::tape::Cells;
use glam::DVec3;

/// Times that what was merged too far is parted.
const ROUNDS: u32 = 12;

/// Distances of diagonals from the surface that differ by less are the same, as a share of a cell.
const EVEN: f64 = 1e-4;

/// Makes meshes of quadrangles.
pub(super) struct Weaver<'a> {
    pub lattice: &'a Lattice,
    pub cells: &'a Cells,
    pub vertices: &'a [Vertex],
    pub quads: &'a [Quad],
    pub watch: &'a Watch<'a>,
}

/// A mesh, and the vertices that each triangle was woven from.
pub(super) struct Woven {
    pub mesh: Mesh,
    /// The quadrangle of each triangle.
    quads: Vec<u32>,
}

impl Weaver<'_> {
    /// All quadrangles as they are.
    pub fn plain(&self) -> Woven {
        self.weave(&Merged {
            of: (0..self.vertices.len() as u32).collect(),
            places: self.vertices.iter().map(|v| v.place).collect(),
            normals: self.vertices.iter().map(|v| v.normal).collect(),
        })
    }

    /// Quadrangles between vertices that were merged as far as a tolerance, the shape of the mesh and the colours of the
    /// vertices, where there are any, allow.
    ///
    /// # Errors
    /// When stopped.
    pub fn merged(&self, tolerance: f64, colors: &[[f32; 3]]) -> Result<Woven, Stopped> {
        // Planes may be nearer than the surface between them; what is too far off is parted again.
        let mut forest = Forest::new(self.vertices, self.quads, 0.5 * tolerance / self.lattice.step, colors);
        for _ in 0..ROUNDS {
            self.watch.check()?;
            let woven = self.weave(&forest.merged(self.vertices));
            let wrong = self.wrong(&woven, tolerance);
            let parted = forest.part(wrong.iter().flat_map(|quad| self.quads[*quad as usize].vertices));
            if !parted {
                return Ok(woven);
            }
        }
        Ok(self.plain())
    }

    /// The quadrangles of triangles that are too far from the surface, or turned over, or at flaws of the mesh.
    fn wrong(&self, woven: &Woven, tolerance: f64) -> Vec<u32> {
        let farthest = farthest(self.lattice, tolerance);
        let near = |points: Vec<DVec3>| survey::reaches(self.cells, &points, farthest, self.watch);
        let [far_points, far_samples] = woven
            .samples()
            .map(|points| near(points).into_iter().map(|d| d.is_nan() || d > tolerance).collect::<Vec<_>>());
        let flawed = Census::of(&woven.mesh).flaws;
        let is_wrong = |t: usize| {
            let mut corners = woven.mesh.triangles[t].into_iter().map(|i| i as usize);
            far_samples[SAMPLES * t..][..SAMPLES].contains(&true)
                || self.is_turned(woven, t)
                || corners.any(|i| flawed[i] || far_points[i])
        };
        (0..woven.mesh.triangles.len()).filter(|&t| is_wrong(t)).map(|t| woven.quads[t]).collect()
    }

    /// Whether a triangle shows the inside of the solid, by the field's gradient at the vertices that it was made of.
    fn is_turned(&self, woven: &Woven, triangle: usize) -> bool {
        let [a, b, c] = woven.mesh.corners(triangle);
        let quad = &self.quads[woven.quads[triangle] as usize];
        let outwards: DVec3 = quad.vertices.map(|v| self.vertices[v as usize].normal).into_iter().sum();
        (b - a).cross(c - a).dot(outwards) < 0.0
    }

    /// Triangles between what the vertices have become.
    fn weave(&self, merged: &Merged) -> Woven {
        let points: Vec<DVec3> = merged.places.iter().map(|p| self.lattice.point(*p)).collect();
        let corners = |quad: &Quad| {
            let [a, b, c, d] = quad.vertices.map(|v| merged.of[v as usize]);
            if quad.starts_inside { [a, b, c, d] } else { [d, c, b, a] }
        };
        let middle = |a: u32, b: u32| 0.5 * (points[a as usize] + points[b as usize]);
        let diagonals: Vec<DVec3> =
            self.quads.iter().map(corners).flat_map(|[a, b, c, d]| [middle(a, c), middle(b, d)]).collect();
        let far = survey::distances(self.cells, &diagonals, self.watch);
        let mut woven =
            Woven { mesh: Mesh { normals: merged.normals.clone(), ..Mesh::default() }, quads: Vec::new() };
        for (i, (quad, far)) in self.quads.iter().zip(far.chunks_exact(2)).enumerate() {
            let [a, b, c, d] = corners(quad);
            let both = [[[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]];
            let shares = both.map(|halves| lesser_share(halves, &points));
            // On a flat piece neither is nearer but by rounding. A half that is a line has three corners along an edge of the
            // solid: then the quadrangle is flat, and the other halves show just the same.
            let is_even = (far[0] - far[1]).abs() <= EVEN * self.lattice.step;
            let has_line = shares.iter().any(|share| share.abs() < LINE);
            let is_first = if is_even || has_line { shares[0] >= shares[1] } else { far[0] <= far[1] };
            let halves = if is_first { both[0] } else { both[1] };
            // Where opposite corners are one the halves are one another's reverse.
            let is_folded = a == c || b == d;
            for half in halves.into_iter().filter(|[a, b, c]| !is_folded && a != b && b != c && c != a) {
                woven.mesh.triangles.push(half);
                woven.quads.push(i as u32);
            }
        }
        woven.mesh.points = points;
        woven
    }
}

impl Woven {
    /// The points, and the samples of each triangle.
    fn samples(&self) -> [Vec<DVec3>; 2] {
        let samples = (0..self.mesh.triangles.len()).flat_map(|t| samples(self.mesh.corners(t))).collect();
        [self.mesh.points.clone(), samples]
    }

    /// How far it is from the surface, if that is no farther than `farthest`.
    pub fn deviation(&self, cells: &Cells, farthest: f64, watch: &Watch<'_>) -> Deviation {
        let all = self.samples().map(|points| survey::reaches(cells, &points, farthest, watch)).concat();
        let mut far: Vec<f64> = all.iter().copied().filter(|d| d.is_finite()).collect();
        let (samples, unknown) = (all.len(), all.len() - far.len());
        let Some(last) = far.len().checked_sub(1) else {
            return Deviation { samples, unknown, ..Deviation::default() };
        };
        let (_, usual, _) = far.select_nth_unstable_by(last - last / 1000, f64::total_cmp);
        let usual = *usual;
        Deviation { most: far.into_iter().fold(0.0, f64::max), usual, samples, unknown }
    }
}

/// How far from the surface triangles are looked at: vertices are in cells that it passes, and merged by a tolerance.
pub fn farthest(lattice: &Lattice, tolerance: f64) -> f64 {
    2.0 * lattice.step.max(tolerance)
}

/// The share of a quadrangle's area that the smaller half of it has, below zero where one is turned over.
fn lesser_share(halves: [[u32; 3]; 2], points: &[DVec3]) -> f64 {
    let areas = halves.map(|half| {
        let [a, b, c] = half.map(|i| points[i as usize]);
        (b - a).cross(c - a)
    });
    let whole = areas[0] + areas[1];
    areas[0].dot(whole).min(areas[1].dot(whole)) / whole.length_squared()
}

/// A half with less of the area is a line.
const LINE: f64 = 1e-6;

/// Places in a triangle whose distance from the surface is looked at, besides its corners.
const SAMPLES: usize = 4;

/// The middle, and the middles of the edges.
fn samples([a, b, c]: [DVec3; 3]) -> [DVec3; SAMPLES] {
    [(a + b + c) / 3.0, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]
}
