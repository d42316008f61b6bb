//! The triangles of a glTF scene: its nodes in their places, and what they are made of.

use super::at;
use super::data::{Data, Items};
use super::json::{Attributes, Gltf, Node, Primitive};
use crate::exchange::fault::Fault;
use crate::exchange::mesh::units;
use crate::shape::Mesh;
use glam::{DMat3, DMat4, DQuat, DVec3};
use std::collections::HashMap;

/// Points and corners that a file may have by saying the same again: so many for each byte, and so
/// many at least and at most. What is said once takes a byte or more each.
const REPEATED: usize = 64;
const ALWAYS: usize = 1 << 16;
const MOST: usize = 1 << 26;

/// What has been joined.
pub struct Joined<'a> {
    gltf: &'a Gltf<'a>,
    data: &'a Data<'a>,
    mesh: Mesh,
    /// Whether all points so far have normals.
    all_normals: bool,
    /// Points and corners that there may yet be.
    room: usize,
}

impl<'a> Joined<'a> {
    /// Joins the triangles of the scene that is to be shown; of all nodes if there are no scenes.
    ///
    /// # Errors
    /// When something refers to what is not there, nodes are no trees, or there is too much of it all
    /// for a file of `length` bytes.
    pub fn scene(gltf: &'a Gltf<'a>, data: &'a Data<'a>, length: usize) -> Result<Mesh, Fault> {
        let room = length.saturating_add(length.saturating_mul(REPEATED).clamp(ALWAYS, MOST));
        let mut joined = Joined { gltf, data, mesh: Mesh::default(), all_normals: true, room };
        joined.walk(&roots(gltf)?)?;
        let mut mesh = joined.mesh;
        mesh.normals = if joined.all_normals { units(mesh.normals) } else { Vec::new() };
        if !mesh.colors.is_empty() {
            mesh.colors.resize(mesh.points.len(), WHITE);
        }
        Ok(mesh)
    }

    /// Visits trees of nodes, parents first.
    fn walk(&mut self, roots: &[usize]) -> Result<(), Fault> {
        let nodes = &self.gltf.nodes;
        let mut seen = vec![false; nodes.len()];
        let mut open = Vec::new();
        // Backwards onto the stack, so that the first comes off it first.
        let mut visit = |open: &mut Vec<(usize, DMat4)>, them: &[usize], place: DMat4| {
            for i in them.iter().rev() {
                match seen.get_mut(*i) {
                    Some(seen) if !*seen => *seen = true,
                    Some(_) => {
                        let what = "the node is in the scene twice, or within itself";
                        return Err(at(format!("nodes[{i}]"), what));
                    }
                    None => return Err(at(format!("nodes[{i}]"), "there is no such node")),
                }
                open.push((*i, place));
            }
            Ok(())
        };
        visit(&mut open, roots, DMat4::IDENTITY)?;
        while let Some((i, place)) = open.pop() {
            let Some(node) = nodes.get(i) else { continue };
            let place = place * transform(node);
            if let Some(mesh) = node.mesh {
                self.mesh(mesh, place)?;
            }
            visit(&mut open, &node.children, place)?;
        }
        Ok(())
    }

    /// Joins a mesh in a place.
    fn mesh(&mut self, number: usize, place: DMat4) -> Result<(), Fault> {
        let Some(mesh) = self.gltf.meshes.get(number) else {
            return Err(at(format!("meshes[{number}]"), "there is no such mesh"));
        };
        // Parts that share their points do so here too.
        let mut known = HashMap::new();
        for (i, part) in mesh.primitives.iter().enumerate() {
            // Points and lines have no surface.
            if !matches!(part.mode, None | Some(4..=6)) {
                continue;
            }
            let path = || format!("meshes[{number}].primitives[{i}]");
            let (first, count) = match known.get(&part.attributes) {
                Some(known) => *known,
                None => {
                    let points = self.points(&part.attributes, place, path)?;
                    known.insert(part.attributes, points);
                    points
                }
            };
            self.triangles(part, first, count, place.determinant() < 0.0, path)?;
        }
        Ok(())
    }

    /// Takes from the room for points and corners.
    fn take(&mut self, count: usize, path: impl Fn() -> String) -> Result<(), Fault> {
        self.room = self.room.checked_sub(count).ok_or_else(|| {
            at(path(), "the scene repeats its meshes so often that it has too many points for its file")
                .remedy("write a part of the scene, or write it as .ply, which repeats nothing")
        })?;
        Ok(())
    }

    /// Joins points, and says the number of the first and how many there are.
    fn points(
        &mut self,
        attributes: &Attributes,
        place: DMat4,
        path: impl Fn() -> String,
    ) -> Result<(usize, usize), Fault> {
        let position = attributes.position.ok_or_else(|| at(path(), "the part has no POSITION"))?;
        let positions = self.data.items(position, &["VEC3"])?;
        let (first, count) = (self.mesh.points.len(), positions.count);
        self.take(count, &path)?;
        if first + count > u32::MAX as usize {
            return Err(at(path(), "there are more than 4294967295 points"));
        }
        for i in 0..count {
            let p = DVec3::from(positions.three(i));
            let p = if place == DMat4::IDENTITY { p } else { place.transform_point3(p) };
            if !p.is_finite() {
                return Err(at(
                    format!("accessors[{position}]"),
                    format!("point {i} is not finite in its place"),
                ));
            }
            self.mesh.points.push(p);
        }
        match attributes.normal {
            Some(accessor) => self.normals(accessor, count, place)?,
            None => self.all_normals = false,
        }
        if let Some(accessor) = attributes.color {
            self.colors(accessor, first, count)?;
        }
        Ok((first, count))
    }

    /// What an accessor says of each of some points.
    fn of_points(&self, accessor: usize, count: usize, shapes: &[&str]) -> Result<Items<'a>, Fault> {
        let items = self.data.items(accessor, shapes)?;
        if items.count != count {
            let what = format!("there are {} items for {count} points", items.count);
            return Err(at(format!("accessors[{accessor}]"), what));
        }
        Ok(items)
    }

    /// Joins normals of the last points.
    fn normals(&mut self, accessor: usize, count: usize, place: DMat4) -> Result<(), Fault> {
        let normals = self.of_points(accessor, count, &["VEC3"])?;
        let turn = turned(DMat3::from_mat4(place));
        self.mesh.normals.extend((0..count).map(|i| match place == DMat4::IDENTITY {
            true => normals.three(i).into(),
            false => (turn * DVec3::from(normals.three(i))).normalize_or_zero(),
        }));
        Ok(())
    }

    /// Joins colours of the last points; those before without any are white.
    fn colors(&mut self, accessor: usize, first: usize, count: usize) -> Result<(), Fault> {
        let colors = self.of_points(accessor, count, &["VEC3", "VEC4"])?;
        self.mesh.colors.resize(first, WHITE);
        self.mesh.colors.extend((0..count).map(|i| colors.three(i).map(|c| c as f32)));
        match self.mesh.colors[first..].as_flattened().iter().all(|c| c.is_finite()) {
            true => Ok(()),
            false => Err(at(format!("accessors[{accessor}]"), "a colour is not finite")),
        }
    }

    /// Joins the triangles of a part whose points are there.
    fn triangles(
        &mut self,
        part: &Primitive,
        first: usize,
        count: usize,
        mirrored: bool,
        path: impl Fn() -> String,
    ) -> Result<(), Fault> {
        let indices = part.indices.map(|accessor| self.data.items(accessor, &["SCALAR"])).transpose()?;
        let corners = indices.as_ref().map_or(count, |items| items.count);
        self.take(corners, &path)?;
        let corner = |i: usize| {
            let point = match &indices {
                None => i,
                Some(items) => match items.index(i) {
                    Some(index) if (index as usize) < count => index as usize,
                    _ => {
                        let what = format!("corner {i} is none of the {count} points");
                        return Err(at(format!("{}.indices", path()), what));
                    }
                },
            };
            Ok((first + point) as u32)
        };
        let numbers: &mut dyn Iterator<Item = [usize; 3]> = match part.mode {
            Some(5) => &mut (0..corners.saturating_sub(2)).map(|i| [i, i + 1 + i % 2, i + 2 - i % 2]),
            Some(6) => &mut (0..corners.saturating_sub(2)).map(|i| [i + 1, i + 2, 0]),
            _ => &mut (0..corners / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]),
        };
        for [a, b, c] in numbers {
            let [a, b, c] = [corner(a)?, corner(b)?, corner(c)?];
            self.mesh.triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
        }
        Ok(())
    }
}

const WHITE: [f32; 3] = [1.0; 3];

/// The roots of what is to be shown.
fn roots(gltf: &Gltf<'_>) -> Result<Vec<usize>, Fault> {
    let shown = gltf.scene.unwrap_or_default();
    match gltf.scenes.get(shown) {
        Some(scene) => Ok(scene.nodes.clone()),
        None if gltf.scene.is_some() => Err(at("scene", format!("there is no scene {shown}"))),
        None => {
            let mut root = vec![true; gltf.nodes.len()];
            for child in gltf.nodes.iter().flat_map(|node| &node.children) {
                if let Some(root) = root.get_mut(*child) {
                    *root = false;
                }
            }
            Ok((0..root.len()).filter(|i| root[*i]).collect())
        }
    }
}

/// From a node to its parent.
fn transform(node: &Node) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return DMat4::from_cols_array(matrix);
    }
    let three = |v: &Option<Box<[f64; 3]>>, usual| v.as_ref().map_or(usual, |v| DVec3::from(**v));
    let rotation = node.rotation.as_ref().map_or(DQuat::IDENTITY, |q| DQuat::from_array(**q).normalize());
    DMat4::from_scale_rotation_translation(
        three(&node.scale, DVec3::ONE),
        rotation,
        three(&node.translation, DVec3::ZERO),
    )
}

/// What turns normals where `m` turns points: the inverse transposed, but for a factor above zero.
fn turned(m: DMat3) -> DMat3 {
    let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis];
    DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b)) * m.determinant().signum()
}
