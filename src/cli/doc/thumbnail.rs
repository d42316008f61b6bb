//! Pictures of the reference: what the example of an entry comes to, if that is something to look at.
//!
//! A scene is shown as it is, a solid in a camera that frames it; what has no end is cut off by a box. Of
//! a noise or a camera a small scene says most. What comes to numbers, or to a field that is nowhere
//! negative, has no picture.

use crate::cli::report::Failure;
use crate::diag::Diagnostic;
use crate::field::{self, Extent, Field};
use crate::render::{self, Job, Metadata};
use crate::scene::{Aabb, Camera, Scene};
use crate::script::{self, Entry, Request, STD};
use crate::session::{self, Order};
use std::path::Path;

/// Width and height in pixels.
const SIDE: u32 = 240;

/// The picture of an entry.
pub(super) struct Thumbnail<'a> {
    /// What it shows.
    pub entry: &'a Entry,
    script: String,
    scene: Scene,
}

/// The pictures of those entries that have one.
pub(super) fn all<'a>(entries: impl Iterator<Item = &'a Entry>) -> Vec<Thumbnail<'a>> {
    entries.filter_map(Thumbnail::of).collect()
}

impl<'a> Thumbnail<'a> {
    fn of(entry: &'a Entry) -> Option<Self> {
        [false, true].into_iter().find_map(|is_cut| {
            let script = script(entry, is_cut);
            let mut scene = script::compile(&Request::text(script.clone())).scene?;
            if scene.camera == Camera::default() {
                scene.camera = Camera::framing(&found(&scene)?);
            }
            Some(Thumbnail { entry, script, scene })
        })
    }

    /// Functions of one name with more arguments have a picture of their own.
    pub(super) fn file_name(&self) -> String {
        let signature = &self.entry.signature;
        let arguments = signature.matches(',').count() + usize::from(!signature.contains("()"));
        let name: String = match self.entry.name.as_str() {
            name if name.contains(|c: char| c.is_alphanumeric()) => name.replace("::", "-"),
            // Operators by the codes of their letters, and of what is on either side.
            _ => signature.bytes().filter(|b| *b != b' ').map(|b| format!("{b:x}")).collect(),
        };
        format!("{name}-{arguments}.png")
    }

    /// Renders the picture to a file; `false` if it was cancelled.
    pub(super) fn draw(&self, path: &Path, job: &Job<'_>) -> Result<bool, Failure> {
        let order = Order { size: Some((SIDE, SIDE)), samples: Some(4), ..Order::default() };
        let picture = session::render(&self.scene, &order, job).map_err(Failure::Error)?;
        if picture.finished {
            let metadata = Metadata { script: self.script.clone(), ..Metadata::default() };
            render::save(path, &picture, &metadata).map_err(|e| Diagnostic::error(e.to_string()))?;
        }
        Ok(picture.finished)
    }
}

/// The box of a solid that has an end and is somewhere.
fn found(scene: &Scene) -> Option<Aabb> {
    let field = Field::new(&scene.graph, scene.surface.field);
    let within = |half| match field::extent(&field, &Aabb::cube(half)) {
        Extent::Within(found) => Some(found),
        Extent::Open(_) | Extent::Empty => None,
    };
    [2.0, 16.0].into_iter().find_map(within)
}

/// A script that shows an example.
fn script(entry: &Entry, is_cut: bool) -> String {
    let used = |module: &str| module == "color" || entry.example.contains(&format!("{module}::"));
    let imports: String = STD
        .iter()
        .filter(|(module, _)| used(module))
        .map(|(module, _)| format!("import \"std/{module}\" as {module};\n"))
        .collect();
    let example = entry.example.trim_end_matches(';');
    let solid = if is_cut { "intersection(it, box(2.4))" } else { "it" };
    let scaled = if example.contains(".scaled(") { "" } else { ".scaled(2.5)" };
    format!(
        "{imports}let ground = sphere(1.0);\nlet it = {example};\n{}",
        KINDS.replace("SOLID", solid).replace("SCALED", scaled)
    )
}

/// What to show of a value: noises in a ball with an octant cut away, which shows both what they do to a
/// surface and what they are inside; of what is not a solid, something that it belongs to.
const KINDS: &str = "
let sample = union(box(0.9), sphere(0.4).translated([0, 0.7, 0]));
switch type_of(it) {
    \"Noise\" => {
        let noise = itSCALED;
        let usual = noise.stats();
        let level = (noise - usual.mean) / sqrt(usual.variance);
        let cut = max(max(-x, -y), -z);
        let shades = [[-2.0, rgb(\"#12233f\")], [0.0, rgb(\"#7f8790\")], [2.0, rgb(\"#f6e6cc\")]];
        scene(#{
            surface: difference(sphere(1.0) - 0.025 * level, cut).colored(color::ramp(level, shades)),
            camera: orbit(#{ distance: 4.2, azimuth: 38.0, elevation: 26.0, fov: 32.0 }),
            sun: sun(#{ azimuth: 85.0, elevation: 48.0 }),
        })
    },
    \"Grid\" => {
        // Heights over their square, none of them towering.
        let half = 0.5 * it.extent.x;
        let flat = min(1.0, 0.5 * half / (it.high - it.low));
        scene(#{
            surface: y - flat * it,
            bounds: [vec3(-half, flat * it.low - 0.2 * half, -half), vec3(half, flat * it.high + 0.01 * half, half)],
            camera: orbit(#{ distance: 5.0 * half, azimuth: 35.0, elevation: 32.0, fov: 34.0 }),
            sun: sun(#{ azimuth: 110.0, elevation: 30.0, strength: 3.5 }),
        })
    },
    \"Mesh\" => it.field(),
    \"Camera\" => scene(#{ surface: sample, camera: it }),
    \"Sun\" => scene(#{ surface: sample, sun: it }),
    \"Sky\" => scene(#{ surface: sample, sky: it }),
    \"Air\" => scene(#{ surface: sphere(1.0), sky: sky(#{ up: \"outward\", air: it }) }),
    \"Field\" => SOLID,
    \"Scene\" => it,
    _ => (),
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn what_can_be_seen_has_a_picture_of_its_own() {
        let entries = script::reference();
        let thumbnails = all(entries.iter());
        let names: BTreeSet<String> = thumbnails.iter().map(Thumbnail::file_name).collect();
        assert_eq!(names.len(), thumbnails.len());
        let seen: BTreeSet<&str> = thumbnails.iter().map(|t| t.entry.name.as_str()).collect();
        let unseen: BTreeSet<&str> =
            entries.iter().map(|e| e.name.as_str()).filter(|name| !seen.contains(name)).collect();
        assert_eq!(unseen.into_iter().collect::<Vec<_>>().join(" "), UNSEEN);
    }

    /// Functions that come to numbers, settings or files, and those that leave out components of a solid.
    const UNSEEN: &str = ".. affine at bounds class_of color::blend color::ramp color_of component_of curl degrees \
        enclosure film fitted hessian interval is_colored is_even is_field is_nan is_number is_vector lamp \
        largest_component lipschitz load_expression load_grid load_heightfield load_mesh load_outline material \
        metres moon options::of param planet::extent preset radians range region rgb round show slope stats \
        terrain::alpine texture::flat texture::load texture::spherical texture::triplanar to_float \
        to_int vec3 vector_noise warp::fold_by_flow warp::fold_by_noise without_specks";
}
