//! What a scene's solid is connected with, and pictures without what floats beside it.

mod judge;
mod local;
mod picture;
mod store;

pub use judge::{Labels, judge, kept};
pub use local::local;
pub use picture::{ARCS, COLORS, Show, local_picture, picture};

use super::stage;
use crate::diag::Diagnostic;
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
    /// Its components.
    pub parts: Parts,
    /// What an octree says of the places that belong to them.
    pub flood: Arc<flood::Components>,
    /// Why there is no complex, if there is none.
    pub rough: Option<Box<Diagnostic>>,
    /// Whether the complex was found on disk.
    pub remembered: bool,
}

/// Components, as far as a field has them.
#[derive(Clone, Debug)]
pub enum Parts {
    /// Of a field with continuous second derivatives: its critical points, and what joins them.
    Complex(Arc<Complex>),
    /// Of any other: those of the flood.
    Flood,
}

/// How large a component is.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// A box that holds what cells show of it; none if it is smaller than these.
    pub bounds: Option<Aabb>,
    /// The volume of that, about.
    pub volume: f64,
}

impl Analysis {
    /// Critical points and what they join, if the field is smooth.
    pub fn complex(&self) -> Option<&Complex> {
        match &self.parts {
            Parts::Complex(complex) => Some(complex),
            Parts::Flood => None,
        }
    }

    /// How large each component is, from the cells of the flood that belong to it.
    pub fn sizes(&self) -> Vec<Size> {
        let count = self.complex().map_or(self.flood.list.len(), |c| c.components.len());
        let mut sizes = vec![Size { bounds: None, volume: 0.0 }; count];
        for (part, name) in self.flood.list.iter().zip(&*Labels::new(self).names) {
            let Some(size) = name.and_then(|name| sizes.get_mut(name)) else { continue };
            let own = size.bounds.unwrap_or(part.bounds);
            size.bounds = Some(Aabb { min: own.min.min(part.bounds.min), max: own.max.max(part.bounds.max) });
            size.volume += part.shown;
        }
        sizes
    }
}

/// Cells of the octree beside a complex: it is there for speed alone.
const BESIDE: Limits = Limits { cells: 1 << 17, depth: 8, least: 5 };

/// and instead of one.
const INSTEAD: Limits = Limits { cells: 1 << 21, depth: 24, least: 5 };

/// Analyses the solid of a scene in full detail, within the region that the scene gives or that is found around
/// it; or finds that it was done before, unless it is to be done afresh.
///
/// # Errors
/// A diagnostic if the job was stopped.
pub fn analyse(scene: &Scene, fresh: bool, watch: &Watch<'_>) -> Result<Analysis, Box<Diagnostic>> {
    let (graph, root) = (&scene.graph, scene.surface.field);
    let region: Aabb = stage::region(scene, &mut Field::new(graph, root));
    let tape = Arc::new(Tape::new(graph, &[root]));
    let stopped = |_: Stopped| stage::stopped();
    let flooded = |limits| flood::components(&tape, &region, limits, watch).map(Arc::new).map_err(stopped);
    if let Err(rough) = field::smooth(graph, root) {
        let flood = flooded(INSTEAD)?;
        return Ok(Analysis { tape, parts: Parts::Flood, flood, rough: Some(rough), remembered: false });
    }
    let key = store::Key::new(graph, root, &region);
    let known = if fresh { None } else { store::load(key) };
    let remembered = known.is_some();
    let complex = match known {
        Some(complex) => complex,
        None => {
            let what = Search { region, solid: true };
            let found = search(&tape, &what, watch);
            let found = found.and_then(|critical| Complex::new(&tape, &what, critical, watch));
            let complex = found.ok_or_else(stage::stopped)?;
            store::save(key, &complex);
            complex
        }
    };
    let flood = flooded(BESIDE)?;
    Ok(Analysis { tape, parts: Parts::Complex(Arc::new(complex)), flood, rough: None, remembered })
}
