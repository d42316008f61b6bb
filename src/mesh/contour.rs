//! The vertices of the surface in a block.
//!
//! The field is evaluated at all corners of the block's cells. Where the ends of an edge lie on different
//! sides, the crossing is found by the Illinois method and the normal by the gradient; each patch of a cell
//! then puts its vertex where the tangent planes at its crossings meet. Neighbouring blocks compute what they
//! share twice, from the same places with the same bits, and so agree without asking each other.
//!
//! Fields may have no gradient just on the surface, such as `length(max(f, 0)) + min(f, 0)`, whose two terms both
//! begin there: where a crossing is exact, the normal is that of a place a little inside, or else outside.

use super::blocks::Block;
use super::lattice::{Lattice, Place, SIDE, corner, edge_start};
use super::patches::{self, NONE, Patches};
use super::quadric::Quadric;
use crate::num::{Dual, Many};
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Points evaluated together.
const LANES: usize = 16;

/// Corners along the edge of a block.
const CORNERS: usize = SIDE as usize + 1;

/// Cells of a block.
const CELLS: usize = (SIDE * SIDE * SIDE) as usize;

/// Steps towards a crossing. The Illinois method triples the digits in three of them.
const STEPS: usize = 6;

/// How far beside a crossing a normal is looked for, as a share of the way to the end of its edge.
const BESIDE: f64 = 1.0 / 1024.0;

/// A crossing or a cell that is not there.
const NOWHERE: u16 = u16::MAX;

/// A face of a cell on which the bilinear choice is reversed.
pub(super) type Flip = (Place, usize);

/// What the surface is said to be where the values alone would say otherwise.
#[derive(Default)]
pub(super) struct Choices {
    /// Faces with the bilinear choice reversed.
    pub flips: BTreeSet<Flip>,
    /// Corners that count as outside.
    pub cut: BTreeSet<Place>,
}

/// A cell that the surface passes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Its first corner.
    pub at: Place,
    /// Which corners lie inside, by number.
    pub inside: u8,
    /// The patches of the surface in it.
    pub patches: Patches,
    /// Number of the vertex of its first patch, among those of the block.
    pub first: u32,
}

/// A vertex of the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// The cell that it lies in.
    pub cell: Place,
    /// In steps from the lattice's origin.
    pub place: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Its planes, in steps from the lattice's origin.
    pub quadric: Quadric,
}

/// What the surface is in a block.
pub(super) struct Contour {
    pub at: Place,
    pub cells: Vec<Cell>,
    pub vertices: Vec<Vertex>,
    /// The number of the cell at each place of the block.
    lookup: Box<[u16; CELLS]>,
}

impl Contour {
    /// The cell there, which must be one of the block's.
    pub fn cell(&self, at: Place) -> Option<&Cell> {
        let offset: Place = std::array::from_fn(|axis| at[axis] - self.at[axis]);
        self.cells.get(self.lookup[cell_number(offset)] as usize)
    }
}

fn cell_number([x, y, z]: Place) -> usize {
    (x + SIDE * (y + SIDE * z)) as usize
}

fn corner_number([x, y, z]: Place) -> usize {
    x as usize + CORNERS * (y as usize + CORNERS * z as usize)
}

fn plus(a: Place, b: Place) -> Place {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

/// Where an edge crosses the surface.
#[derive(Clone, Copy)]
struct Crossing {
    /// The edge's lower end, from the block's first corner.
    start: Place,
    axis: usize,
    /// Where along the edge, from 0 to 1.
    along: f64,
    normal: DVec3,
}

/// Finds contours; one per thread.
pub(super) struct Tracer {
    lattice: Lattice,
    values: Evaluator<Many<f64, LANES>>,
    slopes: Evaluator<Many<Dual, LANES>>,
    /// Values at the corners of the current block.
    corners: Vec<f64>,
    /// Numbers of the crossings by axis and corner.
    numbers: Vec<[u16; 3]>,
    crossings: Vec<Crossing>,
}

impl Tracer {
    pub fn new(tape: &Arc<Tape>, lattice: &Lattice) -> Tracer {
        let count = CORNERS * CORNERS * CORNERS;
        Tracer {
            lattice: *lattice,
            values: Evaluator::new(tape.clone()),
            slopes: Evaluator::new(tape.clone()),
            corners: vec![0.0; count],
            numbers: vec![[NOWHERE; 3]; count],
            crossings: Vec::new(),
        }
    }

    /// The contour of a block.
    pub fn contour(&mut self, block: &Block, choices: &Choices) -> Contour {
        self.values.turn_to(&block.tape);
        self.slopes.turn_to(&block.tape);
        self.sample(block.at, &choices.cut);
        let mut contour = Contour {
            at: block.at,
            cells: Vec::new(),
            vertices: Vec::new(),
            lookup: Box::new([NOWHERE; CELLS]),
        };
        self.find_cells(&mut contour, &choices.flips);
        self.locate(block.at);
        self.place_vertices(&mut contour);
        contour
    }

    /// Evaluates the field at all corners, of which some are cut off.
    fn sample(&mut self, at: Place, cut: &BTreeSet<Place>) {
        let mut p: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(self.corners.len()));
        let along: [[f64; CORNERS]; 3] = std::array::from_fn(|axis| {
            std::array::from_fn(|i| self.lattice.along(axis, at[axis] + i as u32))
        });
        for z in along[2] {
            for y in along[1] {
                p[0].extend(along[0]);
                p[1].extend([y; CORNERS]);
                p[2].extend([z; CORNERS]);
            }
        }
        self.values.eval_all(p.each_ref().map(Vec::as_slice), &mut self.corners);
        self.look_aside(p);
        for corner in cut {
            let offset: Place = std::array::from_fn(|axis| corner[axis].wrapping_sub(at[axis]));
            if offset.iter().all(|i| *i <= SIDE) {
                let value = &mut self.corners[corner_number(offset)];
                *value = value.abs();
            }
        }
    }

    /// Takes corners at which the field has no value for what is next to them: the centre of a planet, where directions have
    /// none, is no void.
    fn look_aside(&mut self, mut p: [Vec<f64>; 3]) {
        let lost: Vec<usize> = (0..self.corners.len()).filter(|&i| self.corners[i].is_nan()).collect();
        if lost.is_empty() {
            return;
        }
        for (axis, p) in p.iter_mut().enumerate() {
            *p = lost.iter().map(|&i| self.lattice.aside(axis, p[i])).collect();
        }
        let mut aside = vec![0.0; lost.len()];
        self.values.eval_all(p.each_ref().map(Vec::as_slice), &mut aside);
        for (i, value) in lost.into_iter().zip(aside) {
            self.corners[i] = value;
        }
    }

    /// Finds the cells that the surface passes, and numbers the crossings.
    fn find_cells(&mut self, contour: &mut Contour, flips: &BTreeSet<Flip>) {
        self.crossings.clear();
        self.numbers.fill([NOWHERE; 3]);
        let mut first = 0;
        for i in 0..CELLS as u32 {
            let offset = [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)];
            let value = |c: usize| {
                let c = c as u32;
                self.corners[corner_number(plus(offset, [c & 1, c >> 1 & 1, c >> 2]))]
            };
            let inside = (0..8).fold(0, |bits, c| bits | u8::from(value(c) < 0.0) << c);
            if inside == 0 || inside == 255 {
                continue;
            }
            let at = plus(contour.at, offset);
            let mut joined = 0;
            for face in (0..6).filter(|&face| patches::is_ambiguous(inside, face)) {
                let joins = patches::joins_inside(patches::face(face).corners.map(value));
                joined |= u8::from(joins ^ flips.contains(&(at, face))) << face;
            }
            let patches = Patches::of(inside, joined);
            contour.lookup[i as usize] = contour.cells.len() as u16;
            contour.cells.push(Cell { at, inside, patches, first });
            first += u32::from(patches.count);
            for edge in (0..12).filter(|&edge| patches.of_edge[edge] != NONE) {
                let (start, axis) = (plus(offset, edge_start(edge)), edge / 4);
                let number = &mut self.numbers[corner_number(start)][axis];
                if *number == NOWHERE {
                    *number = self.crossings.len() as u16;
                    self.crossings.push(Crossing { start, axis, along: 0.0, normal: DVec3::ZERO });
                }
            }
        }
    }

    /// Where a crossing is.
    fn position(&self, at: Place, crossing: &Crossing, along: f64) -> DVec3 {
        let mut p = self.lattice.corner(plus(at, crossing.start));
        p[crossing.axis] += along * self.lattice.step;
        p
    }

    /// Finds the crossings, and the normals there.
    fn locate(&mut self, at: Place) {
        let mut searches: Vec<Search> = self.crossings.iter().map(|c| self.search(c)).collect();
        let mut p: [Vec<f64>; 3] = Default::default();
        let mut values = vec![0.0; searches.len()];
        for _ in 0..STEPS {
            p.iter_mut().for_each(Vec::clear);
            for (crossing, search) in self.crossings.iter().zip(&searches) {
                let q = self.position(at, crossing, search.guess());
                (0..3).for_each(|axis| p[axis].push(q[axis]));
            }
            self.values.eval_all(p.each_ref().map(Vec::as_slice), &mut values);
            searches.iter_mut().zip(&values).for_each(|(search, value)| search.learn(*value));
        }
        for (i, search) in searches.iter().enumerate() {
            self.crossings[i].along = search.guess();
        }
        self.find_normals(at);
    }

    fn search(&self, crossing: &Crossing) -> Search {
        let mut end = crossing.start;
        end[crossing.axis] += 1;
        let [a, b] = [crossing.start, end].map(|corner| self.corners[corner_number(corner)]);
        Search { ends: [0.0, 1.0], values: [a, b], last: None }
    }

    /// Finds the normals at the crossings, or beside those where there is none; the rest leave along their edges.
    fn find_normals(&mut self, at: Place) {
        let mut left: Vec<usize> = (0..self.crossings.len()).collect();
        for outward in [0.0, -BESIDE, BESIDE] {
            left = self.find_normals_beside(at, &left, outward);
        }
        for i in left {
            let (axis, sign) = self.way_out(&self.crossings[i]);
            self.crossings[i].normal = DVec3::AXES[axis] * sign;
        }
    }

    /// Finds the normals of some crossings a share of the way to the outer end of their edges, or if that is negative to
    /// the inner one. Returns those that have none there.
    fn find_normals_beside(&mut self, at: Place, some: &[usize], outward: f64) -> Vec<usize> {
        let mut without = Vec::new();
        for batch in some.chunks(LANES) {
            let place = |lane: usize| {
                let crossing = &self.crossings[batch[lane.min(batch.len() - 1)]];
                let end = if self.way_out(crossing).1 * outward > 0.0 { 1.0 } else { 0.0 };
                self.position(at, crossing, crossing.along + outward.abs() * (end - crossing.along))
            };
            let places: [DVec3; LANES] = std::array::from_fn(place);
            let duals = |axis: usize| Many(places.map(|p| Dual::coordinate(p[axis], axis)));
            let slopes = *self.slopes.eval(&std::array::from_fn(duals));
            for (i, slope) in batch.iter().zip(slopes.0) {
                match DVec3::from_array(slope.grad).try_normalize() {
                    Some(normal) => self.crossings[*i].normal = normal,
                    None => without.push(*i),
                }
            }
        }
        without
    }

    /// The axis along which an edge leaves the solid, and the sign of that direction.
    fn way_out(&self, crossing: &Crossing) -> (usize, f64) {
        let starts_inside = self.corners[corner_number(crossing.start)] < 0.0;
        (crossing.axis, if starts_inside { 1.0 } else { -1.0 })
    }

    fn place_vertices(&self, contour: &mut Contour) {
        for cell in &contour.cells {
            let offset: Place = std::array::from_fn(|axis| cell.at[axis] - contour.at[axis]);
            let mut quadrics = [Quadric::default(); 4];
            let mut normals = [DVec3::ZERO; 4];
            for edge in (0..12).filter(|&edge| cell.patches.of_edge[edge] != NONE) {
                let start = plus(offset, edge_start(edge));
                let number = self.numbers[corner_number(start)][edge / 4];
                let Crossing { axis, along, normal, .. } = self.crossings[number as usize];
                let mut place = steps(plus(cell.at, edge_start(edge)));
                place[axis] += along;
                let patch = cell.patches.of_edge[edge] as usize;
                quadrics[patch].add(place, normal);
                normals[patch] += normal;
            }
            let lo = steps(cell.at);
            for patch in 0..cell.patches.count as usize {
                contour.vertices.push(Vertex {
                    cell: cell.at,
                    place: quadrics[patch].least_within(lo, lo + 1.0),
                    normal: normals[patch].normalize_or(DVec3::Y),
                    quadric: quadrics[patch],
                });
            }
        }
    }
}

fn steps(at: Place) -> DVec3 {
    DVec3::from_array(at.map(f64::from))
}

/// The bits of a cell that lie inside along an edge that starts at its first corner.
pub(super) fn starts_inside(cell: &Cell) -> bool {
    cell.inside & 1 == 1
}

/// Whether an edge from a cell's first corner along an axis crosses the surface.
pub(super) fn crosses(cell: &Cell, axis: usize) -> bool {
    let mut end = [0; 3];
    end[axis] = 1;
    (cell.inside >> corner(end) & 1) != (cell.inside & 1)
}

/// The search for a change of sign between two places: regula falsi, in which a value that stays twice is halved
/// (Dowell and Jarratt 1971), and bisection where there is no number.
struct Search {
    ends: [f64; 2],
    values: [f64; 2],
    /// The end that was moved last.
    last: Option<usize>,
}

impl Search {
    fn guess(&self) -> f64 {
        let ([a, b], [fa, fb]) = (self.ends, self.values);
        let guess = (a * fb - b * fa) / (fb - fa);
        // Rounding must not lead away from an end that is the crossing itself.
        if guess.is_nan() { 0.5 * (a + b) } else { guess.clamp(a, b) }
    }

    fn learn(&mut self, value: f64) {
        let end = usize::from((value < 0.0) != (self.values[0] < 0.0));
        self.ends[end] = self.guess();
        self.values[end] = value;
        if self.last == Some(end) {
            self.values[1 - end] *= 0.5;
        }
        self.last = Some(end);
    }
}
