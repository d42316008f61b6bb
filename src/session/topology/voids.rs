//! The voids of a solid, and which of its components they are in.

use super::{Analysis, INSTEAD, Part};
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::num::Interval;
use crate::op::{Neg, Op};
use crate::scene::{Aabb, Scene};
use crate::session::stage;
use crate::tape::Tape;
use crate::topology::{self, Complex, Kind, is_closed, voids_by_flood, voids_by_points};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A void.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Void {
    /// A box that holds it.
    pub bounds: Aabb,
    /// Encloses its volume.
    pub volume: Interval,
    /// The part that it is in, if that is known.
    pub part: Option<usize>,
}

/// All of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Voids {
    /// The largest first.
    pub list: Vec<Void>,
    /// Whether it is proven that these are all, and each is one.
    pub certified: bool,
}

/// How much larger than the box of its critical points a box may be that holds the solid.
const MARGINS: [f64; 3] = [0.05, 0.1, 0.2];

/// Finds the voids of a solid that was analysed.
pub(super) fn voids(scene: &Scene, analysis: &Analysis, watch: &Watch<'_>) -> Result<Voids, Box<Diagnostic>> {
    let Analysis { tape, region, parts, .. } = analysis;
    // Without 2-saddles nothing is closed off.
    let can_have = |part: &Part| part.critical.as_ref().is_none_or(|c| c.counts[Kind::Saddle2 as usize] > 0);
    let hollow: Vec<usize> = (0..parts.len()).filter(|&i| can_have(&parts[i])).collect();
    if hollow.is_empty() && analysis.proven().is_some() {
        return Ok(Voids { list: Vec::new(), certified: analysis.is_whole });
    }
    // From a place that is not solid the way leads outward of what all of a star is in sight of, and meets nothing.
    if analysis.flood.star.is_some() {
        return Ok(Voids { list: Vec::new(), certified: analysis.is_whole });
    }
    // Where there is no value there is nothing of the solid, and nothing of what is not solid.
    let is_defined = tape.is_defined(&region.intervals());
    let is_closed = analysis.proven().is_some() || is_closed(tape, region, watch.cancel);
    let mut graph = (*scene.graph).clone();
    let nothing = graph.op(Op::Neg(Neg), &[scene.surface.field]);
    let nothing = nothing.map_err(|e| Box::new(Diagnostic::error(e.to_string())))?;
    let nothing = Arc::new(Tape::new(&graph, &[nothing]));
    let found = match analysis.proven() {
        Some(complex) => voids_by_points(&nothing, &narrowed(tape, complex, watch.cancel), watch),
        None => voids_by_flood(&nothing, region, INSTEAD, watch),
    };
    let topology::Voids { list, certified } = found.map_err(|_| stage::stopped())?;
    let mut labels = analysis.labels.clone();
    let mut part = |around: Option<DVec3>| match hollow[..] {
        [only] if is_closed && analysis.is_certified() => Some(only),
        _ => around.and_then(|around| labels.components(&[around])[0]),
    };
    let list = list.into_iter().map(|topology::Void { bounds, volume, around }| Void {
        bounds,
        volume,
        part: part(around),
    });
    Ok(Voids { list: list.collect(), certified: certified && is_defined && is_closed && analysis.is_whole })
}

/// A box that holds all of a solid, not much larger than it if possible: one that holds all of its critical points and
/// whose faces are free of it.
fn narrowed(tape: &Arc<Tape>, complex: &Complex, cancel: &AtomicBool) -> Aabb {
    let points = complex.points.iter().map(|p| Aabb { min: p.position, max: p.position });
    let Some(own) = points.reduce(|a, b| a.hull(&b)) else { return complex.region };
    let wider = |margin: f64| {
        let margin = margin * own.diagonal();
        Aabb {
            min: (own.min - margin).max(complex.region.min),
            max: (own.max + margin).min(complex.region.max),
        }
    };
    let mut boxes = MARGINS.into_iter().map(wider);
    boxes.find(|narrow| is_closed(tape, narrow, cancel)).unwrap_or(complex.region)
}

/// How many voids each of so many parts has, if that is proven.
pub(super) fn counts(voids: &Voids, parts: usize) -> Option<Vec<usize>> {
    let mut counts = vec![0; parts];
    for void in &voids.list {
        *counts.get_mut(void.part?)? += 1;
    }
    voids.certified.then_some(counts)
}
