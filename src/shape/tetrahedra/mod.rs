//! Piecewise algebraic surfaces: polynomials in Bernstein form over the tetrahedra that fill a convex
//! region (`cell.rs`).
//!
//! Polynomials must agree where tetrahedra meet, and may agree in their slopes and curvatures (C1, C2),
//! which is found out from the coefficients: with `V` the far corner of the neighbour and `p` its
//! barycentric coordinates here, `r` derivatives agree across the face if for all `|m| <= d` on it
//!
//! ```text
//! b'(m, r times V) = the polar form of f at the corners m and r times at p
//! ```
//!
//! **Outside**, with `q` the nearest point of the region, the field is `f(q) + |x - q|`: it goes on from the
//! boundary's values, and grows. Nearest points of convex regions are unique and do not jump; that is why
//! the region must be convex. What moves `q` and what moves away from it are at right angles, so with
//! `L` the Lipschitz constant within, that outside is `sqrt(L^2 + 1)`. A surface is closed if the field
//! is positive on the boundary, where there is a crease: as a whole the field is C0.

mod cell;
#[cfg(test)]
mod tests;

pub use cell::{Cell, HIGHEST, count, place, powers};

use super::boxes::{Boxes, Extent};
use super::{Body, Digest, lanes};
use crate::num::{Bounds, Class, Jets, Kernel, Local, Order, PAIRS, Point, ROUNDOFF};
use glam::DVec3;
use std::collections::BTreeMap;

/// Tetrahedra that there may be.
pub const MOST_CELLS: usize = 100_000;

/// By how much of their size coefficients may differ and still agree.
const AGREE: f64 = 1e-9;

/// Why some tetrahedra are no region.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Flaw {
    /// None, or too many.
    #[error("there are from 1 to {MOST_CELLS} cells, not {0}")]
    Count(usize),
    /// A degree that is not supported.
    #[error("the degree is from 1 to {HIGHEST}, not {0}")]
    Degree(usize),
    /// A corner is none of the points.
    #[error("cell {0} has a corner that is none of the points")]
    Corner(usize),
    /// A point is nowhere.
    #[error("point {0} is not finite, or beyond 1e15")]
    Point(usize),
    /// No volume.
    #[error("cell {0} is flat")]
    Flat(usize),
    /// Not as many coefficients as the degree has.
    #[error("cell {cell} has {given} coefficients; a polynomial of this degree has {wanted}")]
    Coefficients {
        /// Which.
        cell: usize,
        /// How many it has.
        given: usize,
        /// How many it should have.
        wanted: usize,
    },
    /// A coefficient is not finite.
    #[error("coefficient {at} of cell {cell} is not finite, or beyond 1e100")]
    Lost {
        /// Which cell.
        cell: usize,
        /// Which of its coefficients.
        at: usize,
    },
    /// Cells that lie on one another.
    #[error("cells {0} and {1} overlap")]
    Overlap(usize, usize),
    /// The field would jump.
    #[error("cells {0} and {1} disagree on the face that they share")]
    Jump(usize, usize),
    /// A region with dents.
    #[error(
        "the cells do not fill a convex region: point {point} is beyond a face of cell {cell} that no other cell shares"
    )]
    Dent {
        /// The point.
        point: usize,
        /// The cell.
        cell: usize,
    },
}

/// Tetrahedra with polynomials.
#[derive(Debug)]
pub struct Tetrahedra {
    cells: Vec<Cell>,
    bounds: Vec<[f64; 2]>,
    boxes: Boxes,
    /// Faces of the region, counter-clockwise as seen from outside, and the cell of each.
    faces: Vec<([DVec3; 3], usize)>,
    hull: Boxes,
    inner: Class,
    size: f64,
    /// Largest coefficient, and the worst steepness of a cell.
    most: f64,
    steepness: f64,
}

/// The place on the boundary that is nearest to a point outside.
struct Shore {
    cell: usize,
    at: DVec3,
    distance: f64,
    /// Directions that it moves in: two on a face, one on an edge, none at a corner.
    free: [DVec3; 2],
}

impl Tetrahedra {
    /// The field of polynomials of a degree over cells, whose corners are numbers of points.
    ///
    /// # Errors
    /// When the cells do not fill a convex region without overlaps, or the field would jump.
    pub fn new(
        points: &[DVec3],
        cells: &[[usize; 4]],
        degree: usize,
        coefficients: &[Vec<f64>],
    ) -> Result<Tetrahedra, Flaw> {
        if !(1..=MOST_CELLS).contains(&cells.len()) || coefficients.len() != cells.len() {
            return Err(Flaw::Count(cells.len().min(coefficients.len())));
        }
        if !(1..=HIGHEST).contains(&degree) {
            return Err(Flaw::Degree(degree));
        }
        if let Some(at) = points.iter().position(|p| !p.is_finite() || p.abs().max_element() > 1e15) {
            return Err(Flaw::Point(at));
        }
        let mut made = Vec::with_capacity(cells.len());
        for (cell, (corners, own)) in cells.iter().zip(coefficients).enumerate() {
            if corners.iter().any(|i| *i >= points.len()) {
                return Err(Flaw::Corner(cell));
            }
            if own.len() != count(degree) {
                return Err(Flaw::Coefficients { cell, given: own.len(), wanted: count(degree) });
            }
            if let Some(at) = own.iter().position(|b| !b.is_finite() || b.abs() > 1e100) {
                return Err(Flaw::Lost { cell, at });
            }
            let corners = corners.map(|i| points[i]);
            made.push(Cell::new(corners, own.clone(), degree).ok_or(Flaw::Flat(cell))?);
        }
        let (inner, outer) = join(&made, cells, degree)?;
        let used: BTreeMap<usize, ()> = cells.iter().flatten().map(|i| (*i, ())).collect();
        let mut faces = Vec::with_capacity(outer.len());
        for (cell, across) in outer {
            let own = &made[cell];
            // The far corner's coordinate falls across the face.
            let (normal, height) = (-own.slopes[across].normalize(), 1.0 / own.slopes[across].length());
            let corners = [1, 2, 3].map(|k| own.corners[(across + k) % 4]);
            let beyond = |i: &&usize| normal.dot(points[**i] - corners[0]) > 1e-9 * height.max(1.0);
            if let Some(point) = used.keys().find(beyond) {
                return Err(Flaw::Dent { point: *point, cell });
            }
            faces.push((corners, cell));
        }
        let extents: Vec<Extent> = made.iter().map(|c| Extent::of(c.corners, 0.0)).collect();
        let sides: Vec<Extent> = faces.iter().map(|(f, _)| Extent::of(*f, 0.0)).collect();
        let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, f64::max);
        Ok(Tetrahedra {
            bounds: made.iter().map(Cell::bounds).collect(),
            boxes: Boxes::new(&extents),
            hull: Boxes::new(&sides),
            faces,
            inner,
            size: largest(&mut extents.iter().map(|e| e.lo.abs().max(e.hi.abs()).max_element())),
            most: largest(&mut coefficients.iter().flatten().map(|b| b.abs())),
            steepness: largest(&mut made.iter().map(Cell::steepness)),
            cells: made,
        })
    }

    /// How smooth the field is within the region.
    pub fn inner_class(&self) -> Class {
        self.inner
    }

    /// The first cell that holds a point.
    fn cell(&self, x: DVec3) -> Option<usize> {
        let mut first = None;
        let holds = |e: &Extent| e.lo.cmple(x).all() && x.cmple(e.hi).all();
        self.boxes.each(holds, |i| {
            let within = self.cells[i].barycentric(x).iter().all(|b| *b >= -1e-12);
            if within && first.is_none_or(|first| i < first) {
                first = Some(i);
            }
        });
        first
    }

    /// The nearest place of the boundary.
    fn shore(&self, x: DVec3) -> Option<Shore> {
        let mut best: Option<Shore> = None;
        self.hull.below(x, f64::INFINITY, |i| {
            let (face, cell) = &self.faces[i];
            let found = nearest(face, *cell, x);
            if best.as_ref().is_none_or(|best| found.distance < best.distance) {
                best = Some(found);
            }
            best.as_ref().map_or(f64::INFINITY, |best| best.distance)
        });
        best
    }

    fn jet(&self, order: Order, x: DVec3) -> Point {
        let nothing = Point { value: f64::NAN, ..Point::default() };
        if x.is_nan() {
            return nothing;
        }
        if let Some(cell) = self.cell(x) {
            return self.cells[cell].jet(order, x);
        }
        let Some(shore) = self.shore(x) else { return nothing };
        let at = self.cells[shore.cell].jet(order, shore.at);
        let away = if shore.distance > 0.0 { (x - shore.at) / shore.distance } else { DVec3::ZERO };
        let along = |v: DVec3| shore.free.iter().fold(DVec3::ZERO, |sum, e| sum + e.dot(v) * e);
        let mut out = Point { value: at.value + shore.distance, ..Point::default() };
        out.grad = (along(at.grad.into()) + away).into();
        if order == Order::Hessian && shore.distance > 0.0 {
            let [xx, yy, zz, xy, xz, yz] = at.hess;
            let inner = [DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz)];
            // P H P, and the distance's own curvature across what the place moves in; there is none of that
            // above a face.
            let rows = inner.map(along);
            let curved = if shore.free[1] == DVec3::ZERO { 1.0 / shore.distance } else { 0.0 };
            for (pair, (r, c)) in PAIRS.into_iter().enumerate() {
                let column = DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
                let moved: f64 = shore.free.iter().map(|e| e[r] * e[c]).sum();
                let unit = if r == c { 1.0 } else { 0.0 };
                out.hess[pair] = along(column)[r] + (unit - moved - away[r] * away[c]) * curved;
            }
        }
        out
    }
}

/// The place of a triangle that is nearest to a point.
fn nearest(face: &[DVec3; 3], cell: usize, x: DVec3) -> Shore {
    let [a, b, c] = *face;
    let (e, normal) = ((b - a).normalize_or_zero(), (b - a).cross(c - a).normalize_or_zero());
    let over = x - normal.dot(x - a) * normal;
    let turns = [(a, b), (b, c), (c, a)].map(|(p, q)| (q - p).cross(over - p).dot(normal));
    if turns.iter().all(|t| *t >= 0.0) {
        return Shore { cell, at: over, distance: (x - over).length(), free: [e, normal.cross(e)] };
    }
    let edge = |(p, q): (DVec3, DVec3)| {
        let step = q - p;
        let t = (step.dot(x - p) / step.length_squared()).clamp(0.0, 1.0);
        let within = t > 0.0 && t < 1.0;
        let free = if within { step.normalize_or_zero() } else { DVec3::ZERO };
        let at = p + t * step;
        Shore { cell, at, distance: (x - at).length(), free: [free, DVec3::ZERO] }
    };
    let [first, second, third] = [(a, b), (b, c), (c, a)].map(edge);
    let nearer = |a: Shore, b: Shore| if b.distance < a.distance { b } else { a };
    nearer(nearer(first, second), third)
}

/// How smoothly the cells go on into one another, and the faces that only one has: the cell, and which of
/// its corners is across.
type Joined = (Class, Vec<(usize, usize)>);

fn join(cells: &[Cell], corners: &[[usize; 4]], degree: usize) -> Result<Joined, Flaw> {
    let mut faces: BTreeMap<[usize; 3], Vec<(usize, usize)>> = BTreeMap::new();
    for (cell, own) in corners.iter().enumerate() {
        for across in 0..4 {
            let mut face = [1, 2, 3].map(|k| own[(across + k) % 4]);
            face.sort_unstable();
            faces.entry(face).or_default().push((cell, across));
        }
    }
    let (mut class, mut outer) = (Class::C2, Vec::new());
    for sides in faces.values() {
        match sides[..] {
            [alone] => outer.push(alone),
            [a, b] => {
                // The other's far corner lies beyond the face, where our own coordinate is negative.
                let far = cells[a.0].barycentric(cells[b.0].corners[b.1]);
                if far[a.1] >= 0.0 {
                    return Err(Flaw::Overlap(a.0, b.0));
                }
                class = class.min(agreement(cells, corners, (a, b), far, degree)?);
            }
            [a, b, ..] => return Err(Flaw::Overlap(a.0, b.0)),
            [] => {}
        }
    }
    Ok((class, outer))
}

/// How many derivatives of two cells agree across their common face.
fn agreement(
    cells: &[Cell],
    corners: &[[usize; 4]],
    ((a, own), (b, other)): ((usize, usize), (usize, usize)),
    far: [f64; 4],
    degree: usize,
) -> Result<Class, Flaw> {
    let size = |c: &Cell| c.coefficients.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
    let reach = far.iter().map(|t| t.abs()).sum::<f64>().max(1.0);
    let mut slack = AGREE * size(&cells[a]).max(size(&cells[b]));
    for (r, less) in [(0, None), (1, Some(Class::C0)), (2, Some(Class::C1))] {
        let agree = r > degree
            || powers(degree - r).filter(|power| power[own] == 0).all(|power| {
                // The same corners, as the neighbour counts them.
                let mut theirs = [0; 4];
                for m in (0..4).filter(|m| *m != own) {
                    if let Some(n) = corners[b].iter().position(|i| *i == corners[a][m]) {
                        theirs[n] = power[m];
                    }
                }
                theirs[other] = r;
                (cells[a].polar(power, r, far) - cells[b].coefficients[place(theirs)]).abs() <= slack
            });
        match (agree, less) {
            (true, _) => slack *= reach,
            (false, None) => return Err(Flaw::Jump(a, b)),
            (false, Some(class)) => return Ok(class),
        }
    }
    Ok(Class::C2)
}

impl Kernel for Tetrahedra {
    fn class(&self) -> Class {
        Class::C0
    }

    fn bounds(&self) -> Bounds {
        let steep = self.bounds.iter().map(|b| b[0]).fold(0.0, f64::max);
        Bounds {
            range: f64::INFINITY,
            lipschitz: (steep * steep + 1.0).sqrt() * (1.0 + 1e-9),
            hessian: f64::INFINITY,
            third: f64::INFINITY,
        }
    }

    fn jets(&self, at: [&[f64]; 3], out: Jets<'_>) {
        lanes::fill(at, out, |order, x| self.jet(order, x));
    }

    fn is_uniform(&self) -> bool {
        false
    }

    /// Within the region, the coefficients of the cells that a ball touches bound the field and its
    /// derivatives; second ones where the cells go on smoothly, or there is only one.
    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let (x, all) = (DVec3::from(at), self.bounds());
        let jet = self.jet(order, x);
        let afloat = self.shore(x).is_none_or(|s| s.distance * (1.0 - 1e-9) <= radius);
        if afloat || self.cell(x).is_none() {
            return Local::uniform(jet, all);
        }
        let mut touched = 0;
        let mut bounds = Bounds { range: 0.0, lipschitz: 0.0, hessian: 0.0, third: f64::INFINITY };
        self.boxes.each(
            |e| e.floor(x) <= radius,
            |i| {
                let cell = &self.cells[i];
                // Beyond a face by more than the radius.
                let away =
                    |m: usize| -cell.barycentric(x)[m] / cell.slopes[m].length() > radius * (1.0 + 1e-9);
                if !(0..4).any(away) {
                    touched += 1;
                    let most = cell.coefficients.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
                    bounds.range = bounds.range.max(most);
                    bounds.lipschitz = bounds.lipschitz.max(self.bounds[i][0]);
                    bounds.hessian = bounds.hessian.max(self.bounds[i][1]);
                }
            },
        );
        bounds.range += self.error(x.abs().max_element())[0];
        if touched > 1 && self.inner < Class::C1 {
            bounds.hessian = f64::INFINITY;
        }
        Local::uniform(jet, bounds)
    }

    /// Barycentric coordinates are off by the steepness of the cell, once from the slopes and once from the
    /// product; each of the steps adds a few roundoffs.
    fn error(&self, size: f64) -> [f64; 3] {
        let spread = 64.0 * ROUNDOFF * self.steepness * self.steepness * self.most * HIGHEST as f64;
        let lipschitz = self.bounds().lipschitz;
        let shift = 64.0 * ROUNDOFF * (size + self.size);
        let slope = self.bounds.iter().map(|b| b[1]).fold(0.0, f64::max);
        let value = spread + lipschitz * shift;
        [value, 64.0 * ROUNDOFF * self.steepness * lipschitz * HIGHEST as f64 + slope * shift, f64::INFINITY]
    }
}

impl Body for Tetrahedra {
    fn name(&self) -> &'static str {
        "tetrahedra"
    }

    fn digest(&self, digest: &mut Digest) {
        for cell in &self.cells {
            digest.numbers(cell.corners.iter().flat_map(|p| p.to_array()));
            digest.whole(cell.coefficients.len() as u64);
            digest.numbers(cell.coefficients.iter().copied());
        }
    }
}
