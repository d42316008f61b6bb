//! The JSON text of a glTF file: as much of it as says where triangles are.

use serde::Deserialize;
use serde::de::IgnoredAny;
use std::borrow::Cow;

/// Everything. Things refer to each other by their numbers in these lists.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Gltf<'a> {
    /// About the file.
    pub asset: Asset,
    /// Which scene is to be shown.
    pub scene: Option<usize>,
    /// Sets of trees of nodes.
    #[serde(default)]
    pub scenes: Vec<Scene>,
    /// Things in places.
    #[serde(default)]
    pub nodes: Vec<Node>,
    /// Meshes.
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    /// Typed views of bytes.
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    /// Parts of buffers.
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    /// Bytes.
    #[serde(default, borrow)]
    pub buffers: Vec<Buffer<'a>>,
    /// What a reader must know beyond the standard.
    #[serde(default)]
    pub extensions_required: Vec<String>,
}

/// About the file.
#[derive(Deserialize)]
pub struct Asset {
    /// Of the standard.
    pub version: String,
}

/// Trees of nodes.
#[derive(Deserialize)]
pub struct Scene {
    /// Their roots.
    #[serde(default)]
    pub nodes: Vec<usize>,
}

/// A thing in a place. Boxes, since most have none of these.
#[derive(Deserialize)]
pub struct Node {
    /// Nodes that move with it.
    #[serde(default)]
    pub children: Vec<usize>,
    /// What it is.
    pub mesh: Option<usize>,
    /// Where it is, column by column.
    pub matrix: Option<Box<[f64; 16]>>,
    /// In place of the matrix, applied last.
    pub translation: Option<Box<[f64; 3]>>,
    /// In place of the matrix, a quaternion.
    pub rotation: Option<Box<[f64; 4]>>,
    /// In place of the matrix, applied first.
    pub scale: Option<Box<[f64; 3]>>,
}

/// What is drawn at once.
#[derive(Deserialize)]
pub struct Mesh {
    /// Its parts.
    pub primitives: Vec<Primitive>,
}

/// Points, lines or triangles.
#[derive(Deserialize)]
pub struct Primitive {
    /// Accessors of what there is for each point.
    pub attributes: Attributes,
    /// Accessor of the numbers of points; all in turn without.
    pub indices: Option<usize>,
    /// What the points are corners of: 4 for triangles, 5 for a strip and 6 for a fan of them.
    pub mode: Option<u32>,
}

/// Accessors by what they hold: a key to what is read for points.
#[derive(Deserialize, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Attributes {
    /// Points.
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
    /// Normals.
    #[serde(rename = "NORMAL")]
    pub normal: Option<usize>,
    /// Colours.
    #[serde(rename = "COLOR_0")]
    pub color: Option<usize>,
}

/// A typed view of bytes.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    /// Of which part of a buffer.
    pub buffer_view: Option<usize>,
    /// Where in it the first item is.
    #[serde(default)]
    pub byte_offset: usize,
    /// The kind of number, by its code in OpenGL.
    pub component_type: u32,
    /// Whether whole numbers stand for those from 0 or -1 to 1.
    #[serde(default)]
    pub normalized: bool,
    /// How many items.
    pub count: usize,
    /// How many numbers an item has.
    #[serde(rename = "type")]
    pub shape: String,
    /// Other values for some items.
    pub sparse: Option<IgnoredAny>,
}

/// A part of a buffer.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    /// Of which.
    pub buffer: usize,
    /// Its first byte.
    #[serde(default)]
    pub byte_offset: usize,
    /// How many bytes.
    pub byte_length: usize,
    /// From one item to the next; as many as an item has without.
    pub byte_stride: Option<usize>,
}

/// Bytes.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer<'a> {
    /// Where they are; in the binary part of the file without.
    #[serde(borrow)]
    pub uri: Option<Cow<'a, str>>,
    /// How many.
    pub byte_length: usize,
}
