//! What is odd about a solid before anything is made of it: that there is none, or that its field has no value.

use super::stage;
use crate::diag::{Diagnostic, Severity};
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
/// A diagnostic if it is proven that its field has no value there at all.
pub fn doubts(scene: &Scene, field: &Field, region: &Aabb) -> Result<Doubts, Box<Diagnostic>> {
    let halt: Halt<'_> = &|| false;
    let (glance, gaps) = look(scene, field, region, halt)?;
    let mut warnings = Vec::from_iter(gaps);
    let is_empty = glance.inside == 0
        && match scene.bounds {
            Some(bounds) => field::extent(field, &bounds) == Extent::Empty,
            None => is_nothing(field, halt),
        };
    if is_empty {
        let missing = missing(scene, field, scene.bounds.is_none());
        warnings.push(Diagnostic { severity: Severity::Warning, ..missing });
    }
    Ok(Doubts { is_empty, warnings })
}

/// A warning if the field of a scene's solid has no value in some of a region.
///
/// # Errors
/// A diagnostic if it is proven that it has none at all, or `halt` said so.
pub(super) fn gaps(
    scene: &Scene,
    field: &Field,
    region: &Aabb,
    halt: Halt<'_>,
) -> Result<Option<Diagnostic>, Box<Diagnostic>> {
    Ok(look(scene, field, region, halt)?.1)
}

fn look(
    scene: &Scene,
    field: &Field,
    region: &Aabb,
    halt: Halt<'_>,
) -> Result<(Glance, Option<Diagnostic>), Box<Diagnostic>> {
    let glance = Glance::new(field.tape(), region, halt, |_| ()).ok_or_else(stage::stopped)?;
    let place = scene.place();
    if !glance.is_undefined() {
        return Ok((glance, glance.gaps(place)));
    }
    let undefined = RenderError::Undefined { place }.diagnostic();
    // Samples alone may have missed where it has one.
    match field::extent_until(field, region, halt) {
        Extent::Empty => Err(Box::new(undefined)),
        Extent::Within(_) | Extent::Open(_) => {
            Ok((glance, Some(Diagnostic { severity: Severity::Warning, ..undefined })))
        }
    }
}

/// That there is no solid where one is looked for, as an error.
pub(super) fn none(scene: &Scene, field: &Field, halt: Halt<'_>) -> Diagnostic {
    missing(scene, field, scene.bounds.is_none() && is_nothing(field, halt))
}

/// The same, once it is known whether there is none `everywhere`.
fn missing(scene: &Scene, field: &Field, everywhere: bool) -> Diagnostic {
    let (message, hint) = match (everywhere, field.tape().is_partial()) {
        (true, false) => ("there is no solid: the field is positive everywhere", SIGN),
        (true, true) => ("there is no solid: the field is positive wherever it has a value", SIGN),
        (false, _) => (
            "there is no solid within the bounds: the field is positive there",
            "negative is inside; check the sign of the field, or give other `bounds` of the scene",
        ),
    };
    Diagnostic::error(message).at(scene.place()).hint(hint)
}

/// What to do where it is positive.
const SIGN: &str = "negative is inside; check the sign of the field";

/// Whether it is proven that there is nothing of a solid anywhere.
fn is_nothing(field: &Field, halt: Halt<'_>) -> bool {
    let near = Aabb::cube(NEAR);
    field::extent_until(field, &near, halt) == Extent::Empty
        && field::around(field, &near, FAR, halt).clear >= FAR
}
