//! glTF 2.0 (ISO/IEC 12113): a JSON text about a scene, and bytes.
//!
//! ```text
//! .glb:  "glTF", u32 2, u32 length of the file,
//!        u32 length, "JSON", text padded with spaces to a multiple of 4,
//!        u32 length, "BIN\0", bytes padded with zeros
//! .gltf: the text alone, with bytes in base64 where other files are not wanted
//! ```
//!
//! What is read are the triangles of the scene that is to be shown, in their places. Skins, shapes to
//! morph into, animations and materials are left out. Libraries for glTF are about all that is in it; the
//! part that is about triangles is small, so that here [`serde`] reads the text, and every number in it is
//! checked where it is used, by the path at which a message can name it.

mod data;
mod json;
mod network;
mod scene;
mod write;

pub use network::{Network, write_network};
pub use write::write;

use crate::exchange::fault::{Fault, Place};
use crate::shape::Mesh;
use data::Data;
use json::Gltf;
use scene::Joined;

/// Chunks of a binary file.
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Beginnings of the names of extensions that do not change where triangles are, or that are known.
const HARMLESS: &[&str] =
    &["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_punctual", "KHR_mesh_quantization"];

/// Reads a file of either form.
///
/// # Errors
/// When it is damaged, or needs another file or an extension.
pub fn read(bytes: &[u8]) -> Result<Mesh, Fault> {
    let (text, binary) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    let gltf: Gltf<'_> = serde_json::from_slice(text).map_err(|e| at("its JSON text", e.to_string()))?;
    if !gltf.asset.version.starts_with("2.") {
        return Err(at("asset.version", format!("this is glTF {:?}", gltf.asset.version))
            .remedy("convert it to glTF 2.0"));
    }
    let harmless = |name: &&String| !HARMLESS.iter().any(|start| name.starts_with(start));
    if let Some(name) = gltf.extensions_required.iter().find(harmless) {
        return Err(at("extensionsRequired", format!("the file needs {name:?}, which is not known here"))
            .remedy("write it again without this extension: without compression, if it is that"));
    }
    let data = Data::of(&gltf, binary)?;
    Joined::scene(&gltf, &data, bytes.len())
}

/// A fault at a value of the JSON text.
fn at(path: impl Into<String>, what: impl Into<String>) -> Fault {
    Fault::new(Place::Value(path.into()), what)
}

/// The text of a binary file, and its bytes if it has some.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let ended = || Fault::new(Place::Byte(bytes.len()), "the file ends in its header");
    let (version, length) = (word(4).ok_or_else(ended)?, word(8).ok_or_else(ended)?);
    if version != 2 {
        let fault = Fault::new(Place::Byte(4), format!("this is version {version} of binary glTF"));
        return Err(fault.remedy("convert it to glTF 2.0"));
    }
    if length as usize != bytes.len() {
        let what = format!("the file has {} bytes, and says that it has {length}", bytes.len());
        return Err(Fault::new(Place::Byte(8), what));
    }
    let chunk = |start: usize, kind: u32| {
        let size = word(start).ok_or_else(ended)? as usize;
        if word(start + 4) != Some(kind) {
            return Ok(None);
        }
        let found = bytes.get(start + 8..).and_then(|rest| rest.get(..size));
        found.map(Some).ok_or_else(|| Fault::new(Place::Byte(start), "a part of the file leaves the file"))
    };
    let text = chunk(12, JSON)?;
    let text =
        text.ok_or_else(|| Fault::new(Place::Byte(16), "the file does not begin with its JSON text"))?;
    let second = 20 + text.len();
    let binary = if second < bytes.len() { chunk(second, BIN)? } else { None };
    Ok((text, binary))
}
