//! What a scene's solid is connected with, and pictures and files without what floats beside it.

mod carried;
mod judge;
mod labels;
mod local;
mod parts;
mod picture;
mod rulings;
mod sieve;
mod store;
mod voids;

pub use carried::Origin;
pub use judge::{Correction, correction, labels};
pub use labels::Labels;
pub use local::{doubts, local};
pub use parts::Part;
pub use picture::{ARCS, COLORS, Show, local_picture, picture};
pub use rulings::{check_point, kept, rivalled, unproven};
pub use sieve::{LeftOut, Sieve};
use store::Key;
pub use voids::{Void, Voids};

use super::stage;
use super::whereabouts::{self, Whereabouts};
use crate::diag::{Diagnostic, Place};
use crate::field::{self, Field, Stopped, Watch};
use crate::scene::{Aabb, Scene};
use crate::tape::Tape;
use crate::topology::flood::{self, Limits};
use crate::topology::{Complex, Search, search};
use std::sync::Arc;

/// A solid with its components.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The solid, in full detail.
    pub tape: Arc<Tape>,
    /// Where it was analysed.
    pub region: Aabb,
    /// Whether it is proven that nothing of it is anywhere else.
    pub is_whole: bool,
    /// Its components.
    pub parts: Vec<Part>,
    /// Critical points and what they join, of a field with continuous second derivatives.
    pub complex: Option<Arc<Complex>>,
    /// What an octree says of the places that belong to components.
    pub flood: Arc<flood::Components>,
    /// Which of its components points belong to; to be cloned by each who asks.
    pub labels: Labels,
    /// Its voids, if they were asked for.
    pub voids: Option<Voids>,
    /// Why there is no complex, if there is none.
    pub rough: Option<Box<Diagnostic>>,
    /// Where in the script the solid is.
    place: Option<Place>,
    /// Whether all of it was found on disk.
    pub remembered: bool,
}

/// What an analysis is for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Purpose {
    /// All is to be found anew, even if it is on disk.
    pub fresh: bool,
    /// Volumes are of interest.
    pub volumes: bool,
    /// Voids are, and the handles that follow.
    pub voids: bool,
}

impl Analysis {
    /// Critical points and what they join, if all of that is proven: then the parts are its components.
    pub fn proven(&self) -> Option<&Complex> {
        self.complex.as_deref().filter(|complex| complex.is_certified())
    }

    /// Whether it is proven that the parts are the components of the solid within the region.
    pub fn is_certified(&self) -> bool {
        self.proven().is_some() || self.flood.is_certified()
    }
}

/// Share of the work that the search for critical points is, about.
const SEARCH: f64 = 0.7;

/// Share of the work that the solid is where voids are found as well, about: around it is more to look through.
const SOLID: f64 = 0.3;

/// Cells of the octree beside a complex of which all is proven: it is there for speed alone.
const BESIDE: Limits = Limits { cells: 1 << 17, depth: 8, least: 5, fine: 0 };

/// Where it is to find the components, or to say how large they are.
const INSTEAD: Limits = Limits { cells: 1 << 21, depth: 24, least: 5, fine: 8 };

/// Analyses the solid of a scene in full detail, within the region that the scene gives or that is found around
/// it; or finds that part of it was done before.
///
/// # Errors
/// A diagnostic if the job was stopped.
pub fn analyse(scene: &Scene, purpose: Purpose, watch: &Watch<'_>) -> Result<Analysis, Box<Diagnostic>> {
    if !purpose.voids {
        return parted(scene, purpose, watch);
    }
    let mut analysis = watch.part(0.0, SOLID, |watch| parted(scene, purpose, watch))?;
    let start = if analysis.remembered { 0.0 } else { SOLID };
    let find = || watch.part(start, 1.0, |watch| voids::voids(scene, &analysis, watch));
    let key = Key::new(&scene.graph, scene.surface.field, &analysis.region).of("voids");
    let (voids, known) = store::remembered(key, purpose.fresh, find)?;
    analysis.remembered &= known;
    if let Some(counts) = voids::counts(&voids, analysis.parts.len()) {
        for (part, &voids) in analysis.parts.iter_mut().zip(&counts) {
            part.critical = part.critical.take().map(|component| component.with_voids(voids));
        }
        // Where all is proven of the complex its components are the parts.
        if let Some(complex) = analysis.complex.as_mut().filter(|complex| complex.is_certified()) {
            for (component, voids) in Arc::make_mut(complex).components.iter_mut().zip(counts) {
                *component = component.clone().with_voids(voids);
            }
        }
    }
    analysis.voids = Some(voids);
    Ok(analysis)
}

/// Finds the parts of a solid.
fn parted(scene: &Scene, purpose: Purpose, watch: &Watch<'_>) -> Result<Analysis, Box<Diagnostic>> {
    let (graph, root) = (&scene.graph, scene.surface.field);
    whereabouts::check(scene)?;
    let Whereabouts { region, is_whole } = whereabouts::locate(scene, &Field::new(graph, root));
    let tape = Arc::new(Tape::new(graph, &[root]));
    let rough = field::smooth(graph, root).err();
    let key = Key::new(graph, root, &region);
    let (complex, remembered) = match rough {
        None => {
            let find = || complex(&tape, region, watch);
            let (mut complex, known) = store::remembered(key, purpose.fresh, find)?;
            // A solid of which nothing is elsewhere may touch the faces of its box, but does not go on beyond them.
            complex.cut &= !is_whole;
            (Some(Arc::new(complex)), known)
        }
        Some(_) => (None, true),
    };
    let proven = complex.as_ref().filter(|complex| complex.is_certified());
    let limits = if proven.is_some() && !purpose.volumes { BESIDE } else { INSTEAD };
    let searched = if complex.is_some() && !remembered { SEARCH } else { 0.0 };
    let find = || watch.part(searched, 1.0, |watch| flood::components(&tape, &region, limits, watch));
    let flooded = store::remembered(key.of(limits), purpose.fresh, find);
    let (flood, known) = flooded.map_err(|_: Stopped| stage::stopped())?;
    let (parts, names) = match proven {
        Some(complex) => parts::of_complex(&tape, complex, &flood),
        None => parts::of_flood(&flood, is_whole),
    };
    let place = graph.place(root).cloned();
    let flood = Arc::new(flood);
    let labels = Labels::new(&tape, proven.map(|complex| &**complex), &flood, names);
    Ok(Analysis {
        tape,
        region,
        is_whole,
        parts,
        complex,
        flood,
        labels,
        voids: None,
        rough,
        place,
        remembered: remembered && known,
    })
}

/// Critical points and what they join.
fn complex(tape: &Arc<Tape>, region: Aabb, watch: &Watch<'_>) -> Result<Complex, Box<Diagnostic>> {
    let what = Search { region, solid: true };
    let found = watch.part(0.0, 0.9 * SEARCH, |watch| search(tape, &what, watch));
    let joined =
        |critical| watch.part(0.9 * SEARCH, SEARCH, |watch| Complex::new(tape, &what, critical, watch));
    found.and_then(joined).ok_or_else(stage::stopped)
}
