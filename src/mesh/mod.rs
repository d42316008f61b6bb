//! From a solid to a mesh of triangles.
//!
//! Dual contouring (Ju, Losasso, Schaefer and Warren 2002) on a lattice of cubes, with a vertex for each
//! patch of the surface in a cell (Nielson 2004; Schaefer, Ju and Warren 2007), so that the mesh is closed,
//! oriented and a manifold, and keeps sharp edges and corners:
//!
//! 1. enclosures drop what has no surface, with proof (`blocks`),
//! 2. crossings of the lattice's edges and the normals there give vertices (`contour`, `patches`, `quadric`), but not
//!    around tips that would float before the rest (`tips`),
//! 3. each crossing makes a quadrangle of the vertices around it (`weave`),
//! 4. where the surface is flat enough and of one colour, vertices are merged (`merge`),
//! 5. each quadrangle becomes two triangles, along the diagonal that is closer to the surface (`triangles`),
//! 6. points at the same place become one (`weld`),
//! 7. enclosures of the gradient tell whether anything may have been missed (`certificate`), and where it may,
//!    samples tell whether much is (`missed`).
//!
//! Whatever the number of threads, the mesh is the same, bit for bit.

mod blocks;
mod certificate;
mod contour;
mod lattice;
mod merge;
mod missed;
mod patches;
mod quadric;
mod survey;
mod tips;
mod triangles;
mod weave;
mod weld;

pub use weld::rounded;

use crate::field::{Stopped, Watch};
use crate::num::srgb;
use crate::scene::Aabb;
use crate::shape::Mesh;
use crate::tape::{Cells, Evaluator, Tape};
use blocks::Block;
use certificate::Prover;
use contour::{Choices, Contour, Tracer, Vertex};
use glam::DVec3;
use lattice::{Lattice, Place, block_of};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;
use triangles::Weaver;
use weave::{Quad, Web};

/// A solid to be meshed.
#[derive(Clone, Debug)]
pub struct Solid {
    /// The field as code, with the field as its only output: negative inside. Outside of the region it must be
    /// positive; what is undefined is empty.
    pub tape: Arc<Tape>,
    /// Code of three linear colour channels, if the solid has colours.
    pub color: Option<Arc<Tape>>,
    /// The box that holds the solid.
    pub region: Aabb,
}

/// How fine a mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Cells along the longest edge of the region, 2 to [`FINEST`]; as many as the tolerance needs, but no more than
    /// [`ENOUGH`], where it is `None`.
    pub resolution: Option<u32>,
    /// How far the mesh may be from the surface where vertices are merged, in the units of the coordinates; none are
    /// where it is `None`.
    pub tolerance: Option<f64>,
}

/// Most cells along an edge.
pub const FINEST: u32 = 1 << 16;

/// Most cells along an edge that a tolerance alone leads to.
pub const ENOUGH: u32 = 512;

/// Steps of the lattice within which of a place all questions about the mesh are asked of one tape: fewer, and cells would have
/// hardly a question each.
const NEAR: f64 = 1.0;

/// Cells along an edge where nothing is said, and where the search for enough of them begins.
const FIRST: u32 = 128;

/// A mesh and how far it is to be trusted.
#[derive(Clone, Debug)]
pub struct Meshed {
    /// Closed, oriented, and a manifold; no two points are equal.
    pub mesh: Mesh,
    /// Points that are black because the colour there is not a number.
    pub colorless: u64,
    /// Length of a cell's edge.
    pub cell: f64,
    /// Blocks of 8 cells along each edge that the surface may pass.
    pub blocks: u64,
    /// Those in which it may have parts that the mesh does not show; it has none if there are no such.
    pub doubtful: u64,
    /// A place in one of these.
    pub doubt: Option<DVec3>,
    /// Cells that have surface in the mesh,
    pub shown: u64,
    /// and cells of doubtful blocks that have none in it, though samples say that they do.
    pub hidden: u64,
    /// How far it is from the surface.
    pub deviation: Deviation,
}

/// Distances from the surface: of points of a mesh, and of middles of triangles and their edges.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Deviation {
    /// The largest, or more where the surface has edges and where the gradient is far from even.
    pub most: f64,
    /// The one that one in a thousand exceeds.
    pub usual: f64,
    /// How many there are.
    pub samples: usize,
    /// How many are not known: the field may jump there, or be flat.
    pub unknown: usize,
}

/// Makes a mesh of a solid.
///
/// # Errors
/// When stopped.
pub fn polygonise(solid: &Solid, fineness: &Fineness, watch: &Watch<'_>) -> Result<Meshed, Stopped> {
    let mut resolution = fineness.resolution.unwrap_or(FIRST).clamp(2, FINEST);
    loop {
        let sketch = Sketch::new(solid, resolution, watch)?;
        let cells =
            Cells::new(solid.tape.clone(), &solid.region.intervals()).no_smaller(NEAR * sketch.lattice.step);
        if let (None, Some(tolerance)) = (fineness.resolution, fineness.tolerance) {
            let farthest = triangles::farthest(&sketch.lattice, 0.0);
            let excess =
                sketch.weaver(&cells, watch).plain().deviation(&cells, farthest, watch).most / tolerance;
            if excess > 1.0 && resolution < ENOUGH {
                // The distance falls with the square of the cells' size where the surface is smooth.
                let times = libm::log2(excess.sqrt().clamp(1.0, 8.0)).ceil().max(1.0);
                resolution = (resolution << times as u32).min(ENOUGH);
                continue;
            }
        }
        return sketch.finish(solid, fineness.tolerance, &cells, watch);
    }
}

/// The surface as it is on a lattice.
struct Sketch {
    lattice: Lattice,
    blocks: Vec<Block>,
    contours: Vec<Contour>,
    vertices: Vec<Vertex>,
    quads: Vec<Quad>,
}

impl Sketch {
    fn new(solid: &Solid, resolution: u32, watch: &Watch<'_>) -> Result<Sketch, Stopped> {
        (watch.progress)(0.0);
        let size = (solid.region.max - solid.region.min).max_element();
        let lattice = Lattice::over(&solid.region, size / f64::from(resolution));
        let blocks = blocks::blocks(&solid.tape, &lattice, watch)?;
        (watch.progress)(0.1);
        let contours = contours(solid, &lattice, &blocks, watch)?;
        (watch.progress)(0.5);
        let web = Web::new(&contours);
        let (vertices, quads) = (web.vertices(), web.quads());
        watch.check()?;
        Ok(Sketch { lattice, blocks, contours, vertices, quads })
    }

    fn weaver<'a>(&'a self, cells: &'a Cells, watch: &'a Watch<'a>) -> Weaver<'a> {
        Weaver { lattice: &self.lattice, cells, vertices: &self.vertices, quads: &self.quads, watch }
    }

    fn finish(
        &self,
        solid: &Solid,
        tolerance: Option<f64>,
        cells: &Cells,
        watch: &Watch<'_>,
    ) -> Result<Meshed, Stopped> {
        let weaver = self.weaver(cells, watch);
        let woven = match tolerance {
            None => weaver.plain(),
            Some(tolerance) => weaver.merged(tolerance, &self.shown_colors(solid))?,
        };
        (watch.progress)(0.8);
        watch.check()?;
        let doubts = self.doubts(solid, watch);
        (watch.progress)(0.95);
        watch.check()?;
        let farthest = triangles::farthest(&self.lattice, tolerance.unwrap_or(0.0));
        let deviation = woven.deviation(cells, farthest, watch);
        watch.check()?;
        let mut mesh = weld::welded(woven.mesh, weld::SHORT * self.lattice.step);
        let mut colorless = 0;
        if let Some(color) = &solid.color {
            mesh.colors = survey::colors(color, &mesh.points);
            for color in mesh.colors.iter_mut().filter(|color| color.iter().any(|c| c.is_nan())) {
                *color = [0.0; 3];
                colorless += 1;
            }
        }
        (watch.progress)(1.0);
        let middle = |at: &Place| self.lattice.corner(*at) + 0.5 * self.lattice.step;
        Ok(Meshed {
            mesh,
            colorless,
            cell: self.lattice.step,
            blocks: self.blocks.len() as u64,
            doubtful: doubts.len() as u64,
            doubt: doubts.first().map(|(at, _)| middle(at)),
            shown: self.contours.iter().map(|contour| contour.cells.len() as u64).sum(),
            hidden: doubts.iter().map(|(_, hidden)| hidden).sum(),
            deviation,
        })
    }

    /// The colours of the vertices as screens show them; none of a solid without.
    fn shown_colors(&self, solid: &Solid) -> Vec<[f32; 3]> {
        let Some(color) = &solid.color else { return Vec::new() };
        let places: Vec<DVec3> = self.vertices.iter().map(|v| self.lattice.point(v.place)).collect();
        let shown = |c: f32| srgb::encode(f64::from(c)) as f32;
        survey::colors(color, &places).into_iter().map(|color| color.map(shown)).collect()
    }

    /// A cell of each block of which it is not proven that nothing is missed there, and in how many cells of the block
    /// samples say that something is; not all of them when stopped.
    fn doubts(&self, solid: &Solid, watch: &Watch<'_>) -> Vec<(Place, u64)> {
        let evaluators = || (Prover::new(&solid.tape), Evaluator::new(solid.tape.clone()));
        let doubts = |(prover, values): &mut (Prover, _), (block, contour): (&Block, &Contour)| {
            watch.check().ok()?;
            let at = certificate::doubt(block, contour, &self.lattice, prover)?;
            Some((at, missed::hidden(block, contour, &self.lattice, values)))
        };
        self.blocks.par_iter().zip(&self.contours).map_init(evaluators, doubts).flatten().collect()
    }
}

/// The contours of all blocks, agreed upon by neighbours.
fn contours(
    solid: &Solid,
    lattice: &Lattice,
    blocks: &[Block],
    watch: &Watch<'_>,
) -> Result<Vec<Contour>, Stopped> {
    let tracer = || Tracer::new(&solid.tape, lattice);
    let mut choices = Choices::default();
    let trace = |tracer: &mut Tracer, block: &Block| {
        watch.check()?;
        Ok(tracer.contour(block, &Choices::default()))
    };
    let mut contours =
        blocks.par_iter().map_init(tracer, trace).collect::<Result<Vec<Contour>, Stopped>>()?;
    loop {
        let pinched = Web::new(&contours).pinched();
        if pinched.is_empty() {
            break;
        }
        // One face of a cell at a time: to reverse one parts a patch, to reverse two at once may join it again.
        let mut busy = BTreeSet::new();
        for pair in pinched {
            if pair.iter().all(|(cell, _)| !busy.contains(cell)) {
                busy.extend(pair.map(|(cell, _)| cell));
                for flip in pair {
                    if !choices.flips.insert(flip) {
                        choices.flips.remove(&flip);
                    }
                }
            }
        }
        retrace(&mut contours, blocks, &mut tracer(), &choices, busy.into_iter().map(block_of).collect());
    }
    choices.cut = tips::tips(&solid.tape, lattice, blocks, &contours);
    let touched = choices.cut.iter().flat_map(|at| tips::blocks_with(*at)).collect();
    retrace(&mut contours, blocks, &mut tracer(), &choices, touched);
    Ok(contours)
}

/// Finds the contours of some blocks again, with other choices.
fn retrace(
    contours: &mut [Contour],
    blocks: &[Block],
    tracer: &mut Tracer,
    choices: &Choices,
    touched: BTreeSet<Place>,
) {
    let both = contours.iter_mut().zip(blocks);
    for (contour, block) in both.filter(|(_, block)| touched.contains(&block.at)) {
        *contour = tracer.contour(block, choices);
    }
}
