//! Where a solid is: the box that its scene gives, or one that is found around it.

use crate::diag::Diagnostic;
use crate::field::{self, Extent, FAR, Field, Halt};
use crate::render::RenderError;
use crate::scene::{Aabb, Scene};
use glam::DVec3;

/// Where a solid is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whereabouts {
    /// The box.
    pub region: Aabb,
    /// Whether it is proven that nothing of the solid is anywhere else.
    pub is_whole: bool,
}

/// Half sides of the cubes in which a solid is looked for, one after the other.
const REACHES: [f64; 7] = [2.0, 16.0, 256.0, LARGE, 16.0 * LARGE, 256.0 * LARGE, FARTHEST];

/// Half side of the first of them that solids are seldom in, and only looked for if they seem to end there.
const LARGE: f64 = 4096.0;

/// Half side of the last of them.
const FARTHEST: f64 = 4096.0 * LARGE;

/// That the box which a scene gives, if it does, is one: scripts see to that, but scenes are also made otherwise.
///
/// # Errors
/// A diagnostic that it is none.
pub(super) fn check(scene: &Scene) -> Result<(), Box<Diagnostic>> {
    match scene.bounds {
        Some(bounds) if !bounds.is_proper() => Err(Box::new(RenderError::Bounds.diagnostic())),
        _ => Ok(()),
    }
}

/// The box that a scene gives, or else finds for a field of its.
pub(super) fn region(scene: &Scene, field: &Field) -> Aabb {
    scene.bounds.unwrap_or_else(|| bounds(scene, field))
}

/// The same, and whether there is anything of the field's solid outside.
pub fn locate(scene: &Scene, field: &Field) -> Whereabouts {
    let found = find(scene, field, &|| false).whereabouts(field);
    let region = scene.bounds.unwrap_or(found.region);
    let is_whole = found.is_whole && region.holds(&found.region) || is_clear(field, &region);
    Whereabouts { region, is_whole }
}

/// A box that holds all of a field's solid wherever the scene has its bounds, if it is proven that one does.
pub(super) fn whole(scene: &Scene, field: &Field) -> Option<Aabb> {
    let found = find(scene, field, &|| false).whereabouts(field);
    found.is_whole.then_some(found.region)
}

/// Whether it is proven that nothing of a field's solid is outside of a box.
fn is_clear(field: &Field, region: &Aabb) -> bool {
    field::around(field, region, FAR, &|| false).clear >= FAR
}

/// A box for a scene that gives none: around the solid if it ends, else around what the camera can
/// be meant to show.
pub fn bounds(scene: &Scene, field: &Field) -> Aabb {
    bounds_until(scene, field, &|| false)
}

/// The same, but no closer bounds are looked for when `halt` says so.
pub(super) fn bounds_until(scene: &Scene, field: &Field, halt: Halt<'_>) -> Aabb {
    find(scene, field, halt).region
}

/// A box that was found.
struct Found {
    region: Aabb,
    /// A cube in which there is nothing else, if that is as large as anything is looked for in.
    cube: Option<Aabb>,
}

impl Found {
    fn whereabouts(&self, field: &Field) -> Whereabouts {
        Whereabouts { region: self.region, is_whole: self.cube.is_some_and(|cube| is_clear(field, &cube)) }
    }
}

fn find(scene: &Scene, field: &Field, halt: Halt<'_>) -> Found {
    let sight = sight(scene);
    let mut near = None;
    let mut values = field.clone();
    for half in REACHES.into_iter().filter(|half| *half <= LARGE || seems_to_end(&mut values, *half)) {
        // Inside the smallest cube that holds it, the search finds a box that fits closely.
        let cube = Aabb::cube(half);
        let Extent::Within(region) = field::extent_until(field, &cube, halt) else { continue };
        let around = field::around(field, &cube, FARTHEST, halt);
        if around.clear >= FARTHEST {
            return Found { region, cube: Some(Aabb::cube(around.clear)) };
        }
        // Where it takes too long to prove that there is nothing else, and nothing was met, there is likely nothing.
        if around.clear >= sight || around.met.is_none() {
            near.get_or_insert(region);
        }
    }
    Found { region: near.unwrap_or_else(|| seen(scene, field, halt)), cube: None }
}

/// Whether samples on the faces of a cube are all outside of the solid.
fn seems_to_end(field: &mut Field, half: f64) -> bool {
    const ACROSS: usize = 8;
    // Not where the symmetries of solids are.
    let place = |i: usize| half * (2.0 * (i as f64 + 0.53) / ACROSS as f64 - 1.0);
    let points = (0..ACROSS * ACROSS).map(|i| [place(i % ACROSS), place(i / ACROSS)]);
    let on_faces = points.flat_map(|[u, v]| {
        [-half, half]
            .into_iter()
            .flat_map(move |w| [DVec3::new(w, u, v), DVec3::new(u, w, v), DVec3::new(u, v, w)])
    });
    on_faces.into_iter().all(|p| field.value(p) > 0.0)
}

/// A cube that holds the camera and what it looks at, with room behind.
pub(super) fn in_sight(scene: &Scene) -> Aabb {
    Aabb::cube(sight(scene))
}

/// The same, or what of it a solid is in whose field has no value in some of it: rays cannot tell where that ends.
fn seen(scene: &Scene, field: &Field, halt: Halt<'_>) -> Aabb {
    let all = in_sight(scene);
    let is_whole = field.tape().is_defined(&all.intervals());
    let part = if is_whole { None } else { field::part_within(field, &all, halt) };
    part.filter(|part| part.min.cmplt(part.max).all()).unwrap_or(all)
}

/// Half its side.
fn sight(scene: &Scene) -> f64 {
    let reach = scene.camera.reach();
    if reach.is_finite() { (1.5 * reach).max(2.0) } else { 16.0 }
}
