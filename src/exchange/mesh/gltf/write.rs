//! Meshes as binary glTF.

use super::{BIN, JSON};
use crate::exchange::mesh::{Gloss, fits_single, unfit, units};
use crate::shape::Mesh;
use serde_json::{Value, json};
use std::io::{self, Write};

/// Codes of OpenGL: kinds of number, and what bytes are for.
const U16: u32 = 5123;
pub(super) const U32: u32 = 5125;
pub(super) const F32: u32 = 5126;
pub(super) const POINTS: u32 = 34962;
pub(super) const CORNERS: u32 = 34963;

/// What goes into the file, and how much room it takes: points, normals, colours, then corners.
#[derive(Default)]
pub(super) struct Layout {
    pub accessors: Vec<Value>,
    pub views: Vec<Value>,
    pub bytes: u64,
}

impl Layout {
    /// Adds some items of `size` bytes, and gives the number of their accessor.
    pub fn add(&mut self, mut accessor: Value, count: usize, size: u64, target: u32) -> usize {
        let length = count as u64 * size;
        let view = json!({ "buffer": 0, "byteOffset": self.bytes, "byteLength": length, "target": target });
        accessor["bufferView"] = self.views.len().into();
        accessor["count"] = count.into();
        self.views.push(view);
        self.accessors.push(accessor);
        self.bytes += length.next_multiple_of(4);
        self.accessors.len() - 1
    }
}

/// Writes a mesh as the only one of a scene. Coordinates are rounded to 32 bits and colours clamped to
/// 0 to 1, as the standard wants them; normals are left out if one has no direction.
///
/// # Errors
/// When `out` fails, when a coordinate is beyond 32 bits, or for more than 4 GiB.
pub fn write(mesh: &Mesh, gloss: &Gloss, out: &mut dyn Write) -> io::Result<()> {
    fits_single(mesh, "glTF")?;
    let normals = units(mesh.normals.clone());
    // The largest index of a width means no point.
    let narrow = mesh.points.len() <= usize::from(u16::MAX);
    let (text, bytes) = text(mesh, gloss, !normals.is_empty(), narrow);
    begin(&text, bytes, out)?;
    if bytes == 0 {
        return Ok(());
    }
    let mut three = |three: [f32; 3]| {
        let [x, y, z] = three.map(f32::to_le_bytes);
        out.write_all([x, y, z].as_flattened())
    };
    mesh.points.iter().try_for_each(|p| three(p.as_vec3().to_array()))?;
    normals.iter().try_for_each(|n| three(n.as_vec3().to_array()))?;
    mesh.colors.iter().try_for_each(|c| three(c.map(|c| c.clamp(0.0, 1.0))))?;
    for triangle in &mesh.triangles {
        match narrow {
            true => out.write_all(triangle.map(|i| (i as u16).to_le_bytes()).as_flattened())?,
            false => out.write_all(triangle.map(u32::to_le_bytes).as_flattened())?,
        }
    }
    let odd = narrow && mesh.triangles.len() % 2 == 1;
    out.write_all(if odd { &[0; 2] } else { &[] })
}

/// Writes a file up to its bytes.
pub(super) fn begin(text: &Value, bytes: u64, out: &mut dyn Write) -> io::Result<()> {
    let text = text.to_string();
    let padding = text.len().next_multiple_of(4) - text.len();
    let text_length = (text.len() + padding) as u64;
    let length = 20 + text_length + if bytes == 0 { 0 } else { 8 + bytes };
    let small = |x: u64| u32::try_from(x).map_err(|_| unfit("glTF files have 4 GiB at most; write .ply"));
    let mut words = |words: &[u32]| words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()));
    words(&[u32::from_le_bytes(*b"glTF"), 2, small(length)?, small(text_length)?, JSON])?;
    out.write_all(text.as_bytes())?;
    out.write_all(&b"   "[..padding])?;
    if bytes > 0 {
        for word in [small(bytes)?, BIN] {
            out.write_all(&word.to_le_bytes())?;
        }
    }
    Ok(())
}

/// The JSON text, and how many bytes follow.
fn text(mesh: &Mesh, gloss: &Gloss, normals: bool, narrow: bool) -> (Value, u64) {
    let asset = json!({ "version": "2.0", "generator": "orogen" });
    let Some((least, most)) = mesh.bounds().filter(|_| !mesh.triangles.is_empty()) else {
        // Nothing may be empty but the file as a whole.
        return (json!({ "asset": asset }), 0);
    };
    let (mut layout, mut attributes) = (Layout::default(), json!({}));
    let count = mesh.points.len();
    // Rounding does not change which is smaller, so that the bounds are those of what is written.
    let [least, most] = [least, most].map(|p| p.as_vec3().as_dvec3().to_array());
    let vectors = || json!({ "componentType": F32, "type": "VEC3" });
    let mut points = vectors();
    points["min"] = json!(least);
    points["max"] = json!(most);
    attributes["POSITION"] = layout.add(points, count, 12, POINTS).into();
    if normals {
        attributes["NORMAL"] = layout.add(vectors(), count, 12, POINTS).into();
    }
    if !mesh.colors.is_empty() {
        attributes["COLOR_0"] = layout.add(vectors(), count, 12, POINTS).into();
    }
    let (kind, size) = if narrow { (U16, 2) } else { (U32, 4) };
    let corners = json!({ "componentType": kind, "type": "SCALAR" });
    let corners = layout.add(corners, 3 * mesh.triangles.len(), size, CORNERS);
    let (material, extensions) = material(gloss);
    let mut text = json!({
        "asset": asset,
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": corners, "material": 0 }] }],
        "materials": [material],
        "accessors": layout.accessors,
        "bufferViews": layout.views,
        "buffers": [{ "byteLength": layout.bytes }],
    });
    // A list may not be empty.
    if !extensions.is_empty() {
        text["extensionsUsed"] = json!(extensions);
    }
    (text, layout.bytes)
}

/// The material, and the names of the extensions that it needs. What has no material is of metal, and what is matt below a coat is
/// as rough as can be.
fn material(gloss: &Gloss) -> (Value, Vec<&'static str>) {
    let roughness = if gloss.metal > 0.0 { gloss.roughness } else { 1.0 };
    let mut material =
        json!({ "pbrMetallicRoughness": { "metallicFactor": gloss.metal, "roughnessFactor": roughness } });
    let (mut extensions, mut names) = (json!({}), Vec::new());
    if gloss.coat > 0.0 {
        names.push("KHR_materials_clearcoat");
        extensions["KHR_materials_clearcoat"] =
            json!({ "clearcoatFactor": gloss.coat, "clearcoatRoughnessFactor": gloss.roughness });
    }
    let most = gloss.light.into_iter().fold(0.0, f64::max);
    if most > 0.0 {
        // Factors go to 1.
        let strength = most.max(1.0);
        material["emissiveFactor"] = json!(gloss.light.map(|part| part / strength));
        if strength > 1.0 {
            names.push("KHR_materials_emissive_strength");
            extensions["KHR_materials_emissive_strength"] = json!({ "emissiveStrength": strength });
        }
    }
    if !names.is_empty() {
        material["extensions"] = extensions;
    }
    (material, names)
}
