//! From a scene to a mesh of it: finds the region, limits detail to the mesh's, and clips what goes on for ever.

use super::topology::{LeftOut, Sieve};
use super::{doubts, stage, whereabouts};
use crate::diag::Diagnostic;
use crate::expr::{Graph, NodeId, TooLarge};
use crate::field::Watch;
use crate::field::{self, Extent, Field, Stopped};
use crate::mesh::{self, Fineness, Meshed, Solid};
use crate::op::{Abs, Max, Op, Sub};
use crate::scene::{Aabb, Scene, Spacing, Surface};
use crate::tape::Tape;
use std::sync::Arc;

/// A mesh of what a scene keeps of its solid.
#[derive(Clone, Debug)]
pub struct Solidified {
    /// The mesh, and how far it is to be trusted.
    pub meshed: Meshed,
    /// Whether it is proven that nothing of the solid is out of sight of the mesh.
    pub is_whole: bool,
    /// What the scene does not keep.
    pub left_out: LeftOut,
    /// What is not proven about what it keeps.
    pub warnings: Vec<Diagnostic>,
}

/// Shares of the work at which it is known how to tell what is kept, and at which there is a mesh, about.
const CORRECTION: [f64; 2] = [0.4, 0.8];

/// A mesh of a scene's solid, or why there is none. What is kept of the solid is decided of it as the mesh shows it, with
/// its detail limited.
///
/// # Errors
/// A diagnostic if there is no solid, its expression is too large, it is not known what of it is kept, or the job was
/// stopped.
pub fn polygonise(
    scene: &Scene,
    fineness: &Fineness,
    watch: &Watch<'_>,
) -> Result<Solidified, Box<Diagnostic>> {
    let Found { limited, solid, is_whole, odd } = find(scene, fineness, watch)?;
    let [begun, done] = if scene.surface.keep.is_some() { CORRECTION } else { [0.0, 1.0] };
    let sieve = watch.part(0.0, begun, |watch| Sieve::of(&limited, scene, watch))?;
    let made = watch.part(begun, done, |watch| mesh::polygonise(&solid, fineness, watch));
    let (mut left_out, mut warnings) = (LeftOut::default(), Vec::from_iter(odd));
    let mut meshed = made.map_err(|_: Stopped| stage::stopped())?;
    if let Some(sieve) = sieve {
        left_out = watch.part(done, 1.0, |watch| sieve.leave_out(&mut meshed, &solid.tape, watch))?;
        warnings.extend(sieve.warnings());
    }
    Ok(Solidified { meshed, is_whole, left_out, warnings })
}

/// What meshes are made of.
struct Found {
    /// The scene, with as much detail as meshes show.
    limited: Scene,
    /// Its solid, in the box that the scene gives or that is found around it.
    solid: Solid,
    /// Whether it is proven that nothing of the solid is out of the box.
    is_whole: bool,
    /// Where its field has no value.
    odd: Option<Diagnostic>,
}

/// The solid of a scene.
fn find(scene: &Scene, fineness: &Fineness, watch: &Watch<'_>) -> Result<Found, Box<Diagnostic>> {
    let too_large = |e: TooLarge| Box::new(Diagnostic::error(e.to_string()));
    let whole = scene.surface.field;
    whereabouts::check(scene)?;
    let found = whereabouts::region(scene, &Field::new(&scene.graph, whole));
    // Octaves that are finer than the mesh can show fade out.
    let size = (found.max - found.min).max_element();
    let spacing = fineness.tolerance.unwrap_or(size / f64::from(fineness.resolution.unwrap_or(mesh::ENOUGH)));
    let (mut graph, roots) =
        Spacing::Even(spacing).limit(&scene.graph, &scene.surface.roots()).map_err(too_large)?;
    let mut field = roots[0];
    let limited =
        Scene { graph: graph.clone(), surface: Surface { field, ..scene.surface.clone() }, ..scene.clone() };
    let grown = Aabb { min: found.min - 0.01 * size, max: found.max + 0.01 * size };
    let shown = Field::new(&graph, field);
    let odd = doubts::gaps(&limited, &shown, &found, &|| watch.check().is_err())?;
    // With less detail it may reach farther, or have parts elsewhere.
    let all = whereabouts::locate(&limited, &shown);
    let (region, is_whole) = match field::extent(&shown, &grown) {
        Extent::Within(region) if grown.holds(&all.region) => (region, all.is_whole),
        Extent::Within(_) | Extent::Open(_) if all.is_whole && scene.bounds.is_none() => (all.region, true),
        Extent::Within(region) => (region, false),
        Extent::Open(_) => {
            field = clipped(Arc::make_mut(&mut graph), field, &found).map_err(too_large)?;
            (found, false)
        }
        Extent::Empty => return Err(Box::new(doubts::none(&limited, &shown, &|| watch.check().is_err()))),
    };
    let tape = Arc::new(Tape::new(&graph, &[field]));
    let color = (roots.len() > 1).then(|| Arc::new(Tape::new(&graph, &roots[1..])));
    Ok(Found { limited, solid: Solid { tape, color, region }, is_whole, odd })
}

/// What of a solid is in a box.
fn clipped(graph: &mut Graph, field: NodeId, region: &Aabb) -> Result<NodeId, TooLarge> {
    let (middle, half) = (0.5 * (region.min + region.max), 0.5 * (region.max - region.min));
    let point = graph.point()?;
    let mut clipped = field;
    for axis in 0..3 {
        let (middle, half) = (graph.constant(middle[axis])?, graph.constant(half[axis])?);
        let off = graph.op(Op::Sub(Sub), &[point[axis], middle])?;
        let off = graph.op(Op::Abs(Abs), &[off])?;
        let beyond = graph.op(Op::Sub(Sub), &[off, half])?;
        clipped = graph.op(Op::Max(Max), &[clipped, beyond])?;
    }
    Ok(clipped)
}
