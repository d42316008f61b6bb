//! Voids of a solid: what is not solid, and closed off from outside.
//!
//! The field with the other sign is negative where there is nothing. Of its components in a region whose faces are free
//! of the solid, one holds all of these faces: that is outside. The others are voids, and each of them gives one of the
//! solid's components a surface to close it in, so that by the Euler characteristic `1 - handles + voids` the handles
//! follow where there are 2-saddles, too.
//!
//! They are found as components of solids are. Of a smooth field, by critical points: whatever a path downhill leaves the
//! region from is outside. But Morse theory in a box knows nothing of a part that comes to its faces between two
//! critical points. So a part that no path is known to leave is flooded in a box around it: a void is what is proven to
//! end there, which tells its volume as well. Of other fields, a flood of the whole region tells.

use super::complex::{Complex, Component, Locator};
use super::flood::{self, Label, Limits};
use super::search::{Search, search};
use crate::field::{Stopped, Watch};
use crate::num::Interval;
use crate::scene::Aabb;
use crate::tape::Tape;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A void.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Void {
    /// A box that holds it.
    pub bounds: Aabb,
    /// Encloses its volume.
    pub volume: Interval,
    /// A place in what closes it in, if one was found.
    pub around: Option<DVec3>,
}

/// The voids of a solid.
#[derive(Clone, PartialEq, Debug)]
pub struct Voids {
    /// In the order of their volumes, the largest first.
    pub list: Vec<Void>,
    /// Whether it is proven that these are all, and each is one.
    pub certified: bool,
}

/// Cells of the octree around a void.
const AROUND: Limits = Limits { cells: 1 << 21, depth: 24, least: 3, fine: 6 };

/// How much more there is around a void in the next larger box in which its end is looked for.
const WIDER: f64 = 1.5;

/// Share of the work that the search for critical points is, about.
const SEARCH: f64 = 0.7;

/// Share with which it is known what is joined.
const JOINED: f64 = 0.8;

/// The voids of a solid with a smooth field; the tape's first output is that field with the other sign. The faces of the
/// region are free of the solid.
///
/// # Errors
/// When stopped.
pub fn voids_by_points(nothing: &Arc<Tape>, region: &Aabb, watch: &Watch<'_>) -> Result<Voids, Stopped> {
    let what = Search { region: *region, solid: true };
    let found = watch.part(0.0, SEARCH, |watch| search(nothing, &what, watch)).ok_or(Stopped)?;
    let joined = |watch: &Watch<'_>| Complex::new(nothing, &what, found, watch);
    let complex = watch.part(SEARCH, JOINED, joined).ok_or(Stopped)?;
    let outside = outside(nothing, &complex);
    let parts = complex.components.iter().enumerate();
    let enclosed: Vec<&Component> = parts.filter(|(i, _)| !outside.contains(i)).map(|(_, c)| c).collect();
    let done = AtomicUsize::new(0);
    let found_out = |component: &&Component| {
        let found = found_out(nothing, &complex, component, watch.cancel);
        let done = 1 + done.fetch_add(1, Ordering::Relaxed);
        (watch.progress)(JOINED + (1.0 - JOINED) * done as f64 / enclosed.len() as f64);
        found
    };
    let found: Vec<Found> = enclosed.par_iter().map(found_out).collect();
    watch.check()?;
    let Complex { open, level, lost, .. } = &complex;
    let is_known = found.iter().all(|found| !matches!(found, Found::Unknown));
    let certified = is_known && open.is_empty() && level.is_empty() && *lost == 0;
    let void = |found| if let Found::Void(void) = found { Some(void) } else { None };
    Ok(Voids::new(found.into_iter().filter_map(void), certified))
}

/// The voids of any solid; the tape's only output is its field with the other sign. The faces of the region are free of
/// the solid.
///
/// # Errors
/// When stopped.
pub fn voids_by_flood(
    nothing: &Arc<Tape>,
    region: &Aabb,
    limits: Limits,
    watch: &Watch<'_>,
) -> Result<Voids, Stopped> {
    let found = flood::components(nothing, region, limits, watch)?;
    let enclosed = (0..found.list.len()).filter(|&i| !found.list[i].cut);
    Ok(Voids::new(enclosed.map(|i| Void::of(&found, i)), found.is_certified()))
}

impl Void {
    /// A component of a flood.
    fn of(found: &flood::Components, component: usize) -> Void {
        let flood::Component { bounds, volume, .. } = found.list[component];
        Void { bounds, volume, around: found.around(component) }
    }
}

impl Voids {
    fn new(list: impl Iterator<Item = Void>, certified: bool) -> Voids {
        let mut list: Vec<Void> = list.collect();
        list.sort_by(|a, b| b.volume.lo.total_cmp(&a.volume.lo));
        Voids { list, certified }
    }
}

/// The components that paths lead from out of the region, or into from its faces.
fn outside(nothing: &Arc<Tape>, complex: &Complex) -> BTreeSet<usize> {
    let leads_out = |ends: &[Option<usize>; 2]| ends.contains(&None);
    let arcs = complex.arcs.iter().map(|arc| arc.minima).filter(leads_out);
    let left: BTreeSet<usize> =
        arcs.flatten().flatten().filter_map(|minimum| complex.component[minimum]).collect();
    let others = complex.points.iter().zip(&complex.component);
    let others = others.filter(|(_, component)| component.is_some_and(|c| !left.contains(&c)));
    let border: Vec<DVec3> =
        others.flat_map(|(point, _)| projections(point.position, &complex.region)).collect();
    let entered = Locator::new(nothing, complex).components(&border, |_| None);
    left.into_iter().chain(entered.into_iter().flatten()).collect()
}

/// A point's projections on the faces of a box.
fn projections(p: DVec3, region: &Aabb) -> [DVec3; 6] {
    std::array::from_fn(|face| {
        let mut on_face = p;
        on_face[face / 2] = if face % 2 == 0 { region.min } else { region.max }[face / 2];
        on_face
    })
}

/// What a component turned out to be.
enum Found {
    Void(Void),
    Outside,
    Unknown,
}

/// Whether a component ends within a box around it, or comes to the faces of the region.
fn found_out(nothing: &Arc<Tape>, complex: &Complex, component: &Component, cancel: &AtomicBool) -> Found {
    let Aabb { min, max } = component.bounds;
    let deepest = complex.points[component.deepest].position;
    let basin = complex.basins.iter().find(|basin| basin.0 == component.deepest).map_or(0.0, |basin| basin.1);
    let (region, whole) = (&complex.region, complex.region.diagonal());
    let mut margin = (0.25 * (max - min).max_element()).max(basin).max(1e-6 * whole);
    let quiet = Watch { cancel, progress: &|_| () };
    let mut best = Found::Unknown;
    while margin < whole {
        let around = Aabb { min: (min - margin).max(region.min), max: (max + margin).min(region.max) };
        let Ok(found) = flood::components(nothing, &around, AROUND, &quiet) else { break };
        if let Label::Component(i) = found.label(deepest) {
            if !found.list[i].cut {
                let void = Void::of(&found, i);
                best = Found::Void(void);
                if void.around.is_some() {
                    break;
                }
            } else if found.comes_to(region, i) {
                // All that is at the faces of the region is joined there.
                return Found::Outside;
            }
        }
        // A larger box would be cut into larger cells.
        if found.cells > AROUND.cells / 2 {
            break;
        }
        margin *= WIDER;
    }
    best
}
