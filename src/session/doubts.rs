//! What is odd about a solid before anything is made of it: that there is none, or that its field has no value.

use super::stage;
use crate::diag::{Diagnostic, Place, Severity};
use crate::field::{self, Extent, FAR, Field, Glance, Halt};
use crate::render::RenderError;
use crate::scene::{Aabb, Scene};

/// Half side of the cube that the proof of nothing begins with.
const NEAR: f64 = 2.0;

/// What is odd about a solid.
#[derive(Clone, Debug)]
pub struct Doubts {
    /// Whether it is proven that there is none where it is looked for.
    pub is_empty: bool,
    /// What to say of it.
    pub warnings: Vec<Diagnostic>,
}

/// What is odd about a solid that is looked for in a region.
///
/// # Errors
/// A diagnostic if its field has no value there at all.
pub fn doubts(scene: &Scene, field: &Field, region: &Aabb) -> Result<Doubts, Box<Diagnostic>> {
    let halt: Halt<'_> = &|| false;
    let mut warnings = Vec::from_iter(gaps(scene, field, region, halt)?);
    let is_empty = match scene.bounds {
        Some(bounds) => field::extent(field, &bounds) == Extent::Empty,
        None => is_nowhere(field, halt),
    };
    if is_empty {
        warnings.push(Diagnostic { severity: Severity::Warning, ..missing(scene, field, halt) });
    }
    Ok(Doubts { is_empty, warnings })
}

/// A warning if the field of a scene's solid has no value in some of a region.
///
/// # Errors
/// A diagnostic if it has none at all, or `halt` said so.
pub(super) fn gaps(
    scene: &Scene,
    field: &Field,
    region: &Aabb,
    halt: Halt<'_>,
) -> Result<Option<Diagnostic>, Box<Diagnostic>> {
    let glance = Glance::new(field.tape(), region, halt, |_| ()).ok_or_else(stage::stopped)?;
    let place = place(scene);
    if glance.is_undefined() {
        return Err(Box::new(RenderError::Undefined { place }.diagnostic()));
    }
    Ok(glance.gaps(place))
}

/// That there is no solid where one is looked for, as an error.
pub(super) fn missing(scene: &Scene, field: &Field, halt: Halt<'_>) -> Diagnostic {
    let (message, hint) = if scene.bounds.is_none() && is_nowhere(field, halt) {
        (
            "there is no solid: the field is positive everywhere",
            "negative is inside; check the sign of the field",
        )
    } else {
        (
            "there is no solid within the bounds: the field is positive there",
            "negative is inside; check the sign of the field, or give other `bounds` of the scene",
        )
    };
    Diagnostic::error(message).at(place(scene)).hint(hint)
}

/// Whether it is proven that there is nothing of a solid anywhere.
fn is_nowhere(field: &Field, halt: Halt<'_>) -> bool {
    let near = Aabb::cube(NEAR);
    field::extent_until(field, &near, halt) == Extent::Empty
        && field::around(field, &near, FAR, halt).clear >= FAR
}

/// Where the solid was written. A place in the library says nothing about what the user has written.
fn place(scene: &Scene) -> Option<Place> {
    scene.graph.place(scene.surface.field).filter(|place| !place.is_embedded()).cloned()
}
