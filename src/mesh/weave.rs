//! From vertices to quadrangles: each edge of the lattice that crosses the surface is surrounded by four cells,
//! whose vertices are the corners of a quadrangle.
//!
//! A mesh made so is closed, since each arc on a face joins two crossings. It is a manifold but for one case:
//! both arcs of a face may belong to the same patch on either side of it, so that four quadrangles share the
//! edge between the two vertices. Joining the crossings of that face the other way parts the patches on both
//! sides (Wenger 2013); done one by one, this comes to an end, since there are ever more patches.

use super::contour::{Cell, Contour, Flip, Vertex, crosses, starts_inside};
use super::lattice::{Place, block_of};
use rayon::prelude::*;
use std::collections::HashMap;

/// The four vertices around a crossing, counter-clockwise about the positive axis of its edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quad {
    pub vertices: [u32; 4],
    /// Lower end of the edge.
    pub at: Place,
    /// Axis of the edge.
    pub axis: u8,
    /// Whether the lower end is inside.
    pub starts_inside: bool,
}

/// Contours that know their neighbours.
pub(super) struct Web<'a> {
    contours: &'a [Contour],
    /// Number of the first vertex of each contour.
    first: Vec<u32>,
    index: HashMap<Place, u32>,
}

impl<'a> Web<'a> {
    pub fn new(contours: &'a [Contour]) -> Web<'a> {
        let mut count = 0;
        let first = contours.iter().map(|c| {
            count += c.vertices.len() as u32;
            count - c.vertices.len() as u32
        });
        let first = first.collect();
        let index = contours.iter().enumerate().map(|(i, c)| (c.at, i as u32)).collect();
        Web { contours, first, index }
    }

    /// All vertices, in the order of their numbers.
    pub fn vertices(&self) -> Vec<Vertex> {
        self.contours.iter().flat_map(|c| c.vertices.iter().copied()).collect()
    }

    /// The contour that has a cell: `near`, most often.
    fn around(&self, at: Place, near: usize) -> Option<usize> {
        let block = block_of(at);
        if self.contours[near].at == block {
            return Some(near);
        }
        self.index.get(&block).map(|i| *i as usize)
    }

    /// A cell that the surface passes, and the number of the contour that has it: `near`, most often.
    pub fn cell(&self, at: Place, near: usize) -> Option<(usize, &'a Cell)> {
        let block = self.around(at, near)?;
        Some((block, self.contours[block].cell(at)?))
    }

    /// The vertex of the patch that crosses an edge of a cell.
    fn vertex(&self, cell: Place, edge: usize, near: usize) -> Option<u32> {
        let (block, cell) = self.cell(cell, near)?;
        Some(self.first[block] + cell.first + u32::from(cell.patches.of_edge[edge]))
    }

    /// All quadrangles, in the order of the contours.
    pub fn quads(&self) -> Vec<Quad> {
        (0..self.contours.len()).into_par_iter().flat_map_iter(|i| self.quads_of(i)).collect()
    }

    /// Those around the edges that start at the first corners of a contour's cells.
    fn quads_of(&self, block: usize) -> impl Iterator<Item = Quad> + '_ {
        let cells = self.contours[block].cells.iter();
        let edges = cells.flat_map(|cell| (0..3).map(move |axis| (cell, axis)));
        edges.filter(|(cell, axis)| crosses(cell, *axis)).filter_map(move |(cell, axis)| {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            // The surface never reaches the first cells of the lattice, so there are cells before these.
            let around = |du: u32, dv: u32| {
                let mut at = cell.at;
                at[u] = at[u].checked_sub(du)?;
                at[v] = at[v].checked_sub(dv)?;
                self.vertex(at, 4 * axis + (du + 2 * dv) as usize, block)
            };
            let vertices = [around(0, 0)?, around(1, 0)?, around(1, 1)?, around(0, 1)?];
            Some(Quad { vertices, at: cell.at, axis: axis as u8, starts_inside: starts_inside(cell) })
        })
    }

    /// The faces on which the choice must be reversed, each as seen from either side.
    pub fn pinched(&self) -> Vec<[Flip; 2]> {
        let found = (0..self.contours.len()).into_par_iter().flat_map_iter(|i| {
            let cells = self.contours[i].cells.iter();
            cells.flat_map(move |cell| {
                (0..3).filter_map(move |axis| {
                    let mut beyond = cell.at;
                    beyond[axis] += 1;
                    let (here, there) = (2 * axis + 1, 2 * axis);
                    let meets = cell.patches.meets_itself(cell.inside, here);
                    let other = if meets {
                        self.contours[self.around(beyond, i)?].cell(beyond)?
                    } else {
                        return None;
                    };
                    other
                        .patches
                        .meets_itself(other.inside, there)
                        .then_some([(cell.at, here), (beyond, there)])
                })
            })
        });
        found.collect()
    }
}
