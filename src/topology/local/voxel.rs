//! What is found in a voxel: critical points, what they are joined with, and ways out.
//!
//! Every component of the solid that goes on into a neighbour crosses a face; the field on what of the face
//! belongs to it has a minimum below zero, which lies inside of the face, on an edge or at a corner (Gamito 2009,
//! 8.5). So the minima of the field on faces, on edges and at corners are *doors*: a path downhill from each says
//! which component goes through. Critical points of the field on a face are found like all others, with the
//! coordinates held that do not vary there ([`Taylor::on`](crate::num::Taylor::on)).

use super::super::complex::sides;
use super::super::descent::{End, Place, Settled, Start, descend};
use super::super::point::{CriticalPoint, Kind};
use super::super::search::{Balls, LANES, Search, isolate, search_cells};
use super::blocks::Blocks;
use super::counters::Count;
use super::grid::Voxel;
use super::{Answer, Local, SMALL};
use crate::scene::Aabb;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A minimum: the voxel that it was found in, and its number there. One on a border is named after the first voxel.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Minimum {
    pub voxel: Voxel,
    number: u32,
}

/// What a path downhill comes to.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    Core,
    /// In a moat.
    Parted,
    Minimum(Minimum),
}

/// What is known of where a path is, if that is enough.
#[derive(Clone, Copy)]
enum Arrived {
    Node(Node),
    /// Here, well below where it began.
    Below(DVec3),
    /// In a ball around a minimum.
    Settled(Settled),
}

/// Voxels that a path comes down until it is seen whether there is a straight way to the core.
const FALL: f64 = 8.0;

/// How near to a minimum a path comes, in voxels, before it is asked what is around it: so near that all paths to it ask
/// about one place. (From a distance to the next, Newton's steps square it.)
const NEAR: f64 = 1e-4;

/// The same where what is rounded does not let it come nearer.
const NEAR_ENOUGH: f64 = 1e-2;

/// How far a path sees in the tip of a cone, in voxels, before the tip is looked for. (Where the field is merely rough, paths
/// see a thousandth of a voxel now and then, and a search of the voxel finds nothing.)
const SHORT: f64 = 1e-5;

/// The critical points of a voxel that are inside.
#[derive(Debug, Default)]
pub struct Points {
    minima: Vec<CriticalPoint>,
    saddles: Vec<CriticalPoint>,
    /// Whether something was not decided.
    doubt: bool,
}

/// What its minima, and those that paths from here come to, are joined with.
#[derive(Debug, Default)]
pub struct Links {
    /// By 1-saddles of the voxel.
    pub bridges: Vec<[Node; 2]>,
    /// By its border: what goes through it where.
    pub doors: Vec<(Node, DVec3)>,
    /// Whether something was not decided: there may be more.
    pub doubt: bool,
}

/// Memory of a thread that looks into voxels.
#[derive(Clone, Debug)]
pub struct Looker {
    pub local: Arc<Local>,
    cells: Balls,
    pub(super) paths: Balls,
    /// Small cells, those of one size after those of another.
    pub(super) small: Vec<Blocks>,
}

/// Cells of a voxel, or of its border, that a search looks at. One as large as features are takes a few hundred, or tens
/// of thousands where enclosures are wide, as those of exponentials are. What is left then is in doubt.
const CELLS: u64 = 1 << 17;

impl Looker {
    pub fn new(local: Arc<Local>) -> Looker {
        let (field, grid) = (local.field.clone(), local.grid);
        let small = SMALL.iter().map(|level| Blocks::new(&grid, *level)).collect();
        Looker { local, cells: field.clone(), paths: field, small }
    }

    /// Where a minimum is; none if it was not found again.
    pub fn position(&mut self, minimum: Minimum, cancel: &AtomicBool) -> Option<DVec3> {
        let points = points(&self.local, &mut self.cells, minimum.voxel, cancel);
        points.minima.get(minimum.number as usize).map(|p| p.position)
    }

    /// What paths downhill from places inside come to. Those that come to a place from which the core is seen are
    /// done, before it takes the search of a voxel to know the minimum there by name. One that has come down by some
    /// voxels may be in sight of it, too: on planets there are places without any minimum far down.
    pub fn descend(&mut self, starts: &[Start], cancel: &AtomicBool) -> Vec<Option<Node>> {
        let mut ends = vec![None; starts.len()];
        let mut waiting: Vec<(usize, Start)> = starts.iter().copied().enumerate().collect();
        while !(waiting.is_empty() || cancel.load(Ordering::Relaxed)) {
            let from: Vec<Start> = waiting.iter().map(|(_, start)| *start).collect();
            let mut stopped = Vec::new();
            for ((i, _), end) in waiting.drain(..).zip(self.paths_from(&from, cancel)) {
                match end {
                    End::At(Arrived::Node(node)) => ends[i] = Some(node),
                    End::At(Arrived::Settled(at)) => match self.proven(&at, cancel) {
                        Some(minimum) => ends[i] = Some(Node::Minimum(minimum)),
                        None => stopped.push((i, at.centre, Some(at))),
                    },
                    End::At(Arrived::Below(at)) => stopped.push((i, at, None)),
                    End::Beyond | End::Lost => {}
                }
            }
            let places: Vec<DVec3> = stopped.iter().map(|(_, at, _)| *at).collect();
            let seen = self.see(&places);
            for ((i, at, settled), seen) in stopped.into_iter().zip(seen) {
                match settled {
                    _ if seen => ends[i] = Some(Node::Core),
                    Some(settled) => {
                        ends[i] = match self.around(at, cancel) {
                            Answer::Joined => Some(Node::Core),
                            Answer::Parted => Some(Node::Parted),
                            _ => self.minimum(&settled, cancel).map(Node::Minimum),
                        }
                    }
                    None => waiting.push((i, Start { at, ..starts[i] })),
                }
            }
        }
        ends
    }

    /// The only minimum of a ball that is known to hold one.
    fn minimum(&mut self, settled: &Settled, cancel: &AtomicBool) -> Option<Minimum> {
        let Looker { local, cells, .. } = self;
        let mut around: Vec<Voxel> = local.grid.around(settled.centre, settled.within).collect();
        around.sort_unstable();
        around.into_iter().find_map(|voxel| {
            let points = points(local, cells, voxel, cancel);
            let here = |p: &CriticalPoint| {
                let rounding = 16.0 * f64::EPSILON * p.position.abs().max_element();
                p.position.distance(settled.centre) <= settled.within + p.error + rounding
            };
            let number = points.minima.iter().position(here)? as u32;
            Some(Minimum { voxel, number })
        })
    }

    /// The same, if no voxel has to be searched for it and what it is joined with is proven.
    fn proven(&mut self, settled: &Settled, cancel: &AtomicBool) -> Option<Minimum> {
        let local = &self.local;
        let mut around = local.grid.around(settled.centre, settled.within);
        let is_known = around.all(|voxel| local.points.get(&voxel).is_some());
        let minimum = is_known.then(|| self.minimum(settled, cancel)).flatten()?;
        let status = self.local.statuses.get(&minimum);
        status.is_some_and(Answer::is_proven).then_some(minimum)
    }

    /// Which points are seen from the core.
    pub fn see(&mut self, points: &[DVec3]) -> Vec<bool> {
        let start = Instant::now();
        let Looker { local, paths, .. } = self;
        let seen = local.core.seen_from(paths, points, local.grid.size());
        local.counters.add_time(Count::Lines, start);
        seen
    }

    fn paths_from(&mut self, starts: &[Start], cancel: &AtomicBool) -> Vec<End<Arrived>> {
        let start = Instant::now();
        let (cells, local) = (&mut self.cells, &*self.local);
        let (core, size) = (local.core, local.grid.size());
        let mut last: Vec<Option<Settled>> = vec![None; starts.len()];
        let arrival = |index: usize, place: &Place| {
            let Place { at, radius, settled } = *place;
            // Beyond the region there is nothing of the solid.
            if !cells.is_within(at, 0.0) {
                return None;
            }
            if core.holds(at) {
                return Some(Arrived::Node(Node::Core));
            }
            if let Some(settled) = settled.filter(|settled| settled.within < NEAR_ENOUGH * size) {
                if settled.within < NEAR * size {
                    return Some(Arrived::Settled(settled));
                }
                last[index] = Some(settled);
            }
            // A path ends in the tip of a cone in ever smaller steps.
            if settled.is_none()
                && radius < SHORT * size
                && let Some(tip) = tip(local, cells, at, cancel)
            {
                return Some(Arrived::Node(Node::Minimum(tip)));
            }
            let fall = starts[index].at.distance(core.centre) - at.distance(core.centre);
            (fall > FALL * size).then_some(Arrived::Below(at))
        };
        let mut ends = descend(&mut self.paths, arrival, &local.region, starts);
        for (end, settled) in ends.iter_mut().zip(last) {
            if let (End::Lost, Some(settled)) = (&end, settled) {
                *end = End::At(Arrived::Settled(settled));
            }
        }
        let counters = &local.counters;
        counters.add(Count::Paths, starts.len());
        counters.add_time(Count::Streaming, start);
        ends
    }

    /// The links of a voxel.
    pub fn links(&mut self, voxel: Voxel, cancel: &AtomicBool) -> Arc<Links> {
        if let Some(links) = self.local.links.get(&voxel) {
            return links;
        }
        let links = Arc::new(self.find_links(voxel, cancel));
        // What was broken off is not to be remembered.
        if !cancel.load(Ordering::Relaxed) {
            self.local.links.insert(voxel, links.clone());
        }
        links
    }

    fn find_links(&mut self, voxel: Voxel, cancel: &AtomicBool) -> Links {
        let local = self.local.clone();
        let points = points(&local, &mut self.cells, voxel, cancel);
        let start = Instant::now();
        let (doors, unclear) = doors(&local, &mut self.cells, voxel, cancel);
        local.counters.add_time(Count::Locating, start);
        let half = 0.5 * local.grid.size();
        let starts = points.saddles.iter().flat_map(|saddle| sides(&mut self.paths, saddle, half));
        let mut starts: Vec<Start> = starts.collect();
        starts.extend(doors.iter().map(|&at| Start { at, radius: 0.25 * half }));
        let ends = self.descend(&starts, cancel);
        let (bridges, outward) = ends.split_at(2 * points.saddles.len());
        let bridge = |pair: &[Option<Node>]| Some([pair[0]?, pair[1]?]);
        Links {
            bridges: bridges.chunks_exact(2).filter_map(bridge).collect(),
            doors: outward.iter().zip(doors).filter_map(|(end, at)| Some(((*end)?, at))).collect(),
            doubt: points.doubt || unclear || ends.contains(&None),
        }
    }
}

/// The critical points of a voxel.
fn points(local: &Local, cells: &mut Balls, voxel: Voxel, cancel: &AtomicBool) -> Arc<Points> {
    if let Some(points) = local.points.get(&voxel) {
        return points;
    }
    let start = Instant::now();
    let cell = local.grid.cell(voxel);
    let mut found = search_cells(cells, vec![cell], &solid(cell.centre, cell.half), (CELLS, cancel));
    isolate(cells, &mut found, true);
    let mut out = Points { doubt: !found.open.is_empty(), ..Points::default() };
    for point in found.points {
        match (point.is_inside(), point.kind) {
            // Whether it joins is not known.
            (None, Kind::Minimum | Kind::Saddle1) => out.doubt = true,
            // Nor is it of those beyond the region, or next to its walls.
            _ if !cells.is_within(point.position, point.error) => out.doubt = true,
            (Some(true), Kind::Minimum) => out.minima.push(point),
            (Some(true), Kind::Saddle1) => out.saddles.push(point),
            _ => {}
        }
    }
    let counters = &local.counters;
    counters.add(Count::Crowded, usize::from(found.crowds > 0));
    counters.add(Count::Voxels, 1);
    counters.add(Count::Minima, out.minima.len());
    counters.add(Count::Saddles, out.saddles.len());
    counters.add_time(Count::Locating, start);
    let out = Arc::new(out);
    if !cancel.load(Ordering::Relaxed) {
        local.points.insert(voxel, out.clone());
    }
    out
}

/// Where components of the solid cross a voxel's border, and whether there may be more.
fn doors(local: &Local, cells: &mut Balls, voxel: Voxel, cancel: &AtomicBool) -> (Vec<DVec3>, bool) {
    let (corners, borders): (Vec<_>, Vec<_>) =
        local.grid.borders(voxel).partition(|border| border.half == DVec3::ZERO);
    let middle = local.grid.cell(voxel);
    let found = search_cells(cells, borders, &solid(middle.centre, middle.half), (CELLS, cancel));
    let minima = found.points.iter().filter(|point| point.kind == Kind::Minimum);
    let mut unclear = !found.open.is_empty() || minima.clone().any(|point| point.is_inside().is_none());
    let mut doors: Vec<DVec3> =
        minima.filter(|point| point.is_inside() == Some(true)).map(|point| point.position).collect();
    for corners in corners.chunks(LANES) {
        let values = cells.eval(corners.iter().map(|corner| (corner.centre, 0.0)));
        for (i, corner) in corners.iter().enumerate() {
            let range = values.lane(i).range;
            if range.hi < 0.0 {
                doors.push(corner.centre);
            } else {
                unclear |= range.lo <= 0.0;
            }
        }
    }
    (doors, unclear)
}

fn solid(centre: DVec3, half: DVec3) -> Search {
    Search { region: Aabb { min: centre - half, max: centre + half }, solid: true }
}

/// The minimum that is no smooth one and holds a place.
fn tip(local: &Local, cells: &mut Balls, at: DVec3, cancel: &AtomicBool) -> Option<Minimum> {
    let voxel = local.grid.voxel(at);
    let points = points(local, cells, voxel, cancel);
    let here = |p: &CriticalPoint| !p.smooth && p.position.distance(at) <= p.error;
    let number = points.minima.iter().position(here)? as u32;
    Some(Minimum { voxel, number })
}
