//! Lines and dots as binary glTF.

use super::write::{CORNERS, F32, Layout, POINTS, U32, begin};
use glam::{DVec3, Vec3};
use serde_json::json;
use std::io::{self, Write};

/// Modes of OpenGL: what points are joined to.
const DOTS: u32 = 0;
const LINES: u32 = 1;

/// Lines and dots, each with a linear colour.
#[derive(Clone, Debug, Default)]
pub struct Network {
    /// Lines through points.
    pub lines: Vec<(Vec<DVec3>, [f32; 3])>,
    /// Points.
    pub dots: Vec<(DVec3, [f32; 3])>,
}

/// Writes a network as the only thing of a scene: one mesh of lines and one of points. Coordinates are rounded to 32
/// bits.
///
/// # Errors
/// When `out` fails, or for more than 4 GiB.
pub fn write_network(network: &Network, out: &mut dyn Write) -> io::Result<()> {
    let on_lines = network.lines.iter().flat_map(|(points, color)| points.iter().map(|p| (*p, *color)));
    let points: Vec<(Vec3, [f32; 3])> =
        on_lines.chain(network.dots.iter().copied()).map(|(p, color)| (p.as_vec3(), color)).collect();
    let (mut pairs, mut first) = (Vec::new(), 0_u32);
    for (line, _) in &network.lines {
        let count = line.len() as u32;
        pairs.extend((1..count).map(|i| [first + i - 1, first + i]));
        first += count;
    }
    let dots: Vec<u32> = (first..points.len() as u32).collect();
    let (mut layout, mut primitives) = (Layout::default(), Vec::new());
    if !points.is_empty() {
        let bound =
            |pick: fn(Vec3, Vec3) -> Vec3| points.iter().map(|p| p.0).reduce(pick).map(|p| p.to_array());
        let position = json!({
            "componentType": F32, "type": "VEC3", "min": bound(Vec3::min), "max": bound(Vec3::max),
        });
        let position = layout.add(position, points.len(), 12, POINTS);
        let color = layout.add(json!({ "componentType": F32, "type": "VEC3" }), points.len(), 12, POINTS);
        let attributes = json!({ "POSITION": position, "COLOR_0": color });
        for (count, mode) in [(2 * pairs.len(), LINES), (dots.len(), DOTS)] {
            if count > 0 {
                let indices = json!({ "componentType": U32, "type": "SCALAR" });
                let indices = layout.add(indices, count, 4, CORNERS);
                primitives.push(json!({ "attributes": attributes, "indices": indices, "mode": mode }));
            }
        }
    }
    let asset = json!({ "version": "2.0", "generator": "orogen" });
    let text = if primitives.is_empty() {
        json!({ "asset": asset })
    } else {
        json!({
            "asset": asset,
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": primitives }],
            "accessors": layout.accessors,
            "bufferViews": layout.views,
            "buffers": [{ "byteLength": layout.bytes }],
        })
    };
    begin(&text, layout.bytes, out)?;
    let three = |three: [f32; 3]| three.map(f32::to_le_bytes);
    points.iter().try_for_each(|(p, _)| out.write_all(three(p.to_array()).as_flattened()))?;
    points.iter().try_for_each(|(_, color)| out.write_all(three(*color).as_flattened()))?;
    let indices = pairs.as_flattened().iter().chain(&dots);
    indices.into_iter().try_for_each(|i| out.write_all(&i.to_le_bytes()))
}
