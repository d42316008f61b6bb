//! Height maps as Fidget makes them.

use crate::View;
use fidget_core::Context;
use fidget_core::context::Tree;
use fidget_core::shape::{BoundShape, Shape};
use fidget_jit::JitFunction;
use fidget_mesh::Octree;
use fidget_raster::voxel::{EvalConfig, RenderConfig, render};
use nalgebra::{Rotation3, Scale3, Vector3};
use std::path::Path;

pub struct Model(Shape<JitFunction>);

impl Model {
    /// The model of a file, or else a planet.
    pub fn read(path: Option<&Path>) -> Result<Model, String> {
        let (context, node) = match path {
            Some(path) => {
                let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
                Context::from_text(file).map_err(|e| e.to_string())?
            }
            None => {
                let mut context = Context::new();
                let node = context.import(&planet());
                (context, node)
            }
        };
        Shape::new(&context, node).map(Model).map_err(|e| e.to_string())
    }

    /// Which pixels the model covers, row by row from the top; normals are found as well.
    pub fn depths(&self, view: &View) -> Vec<bool> {
        let [x, z] = view.turns.map(f64::to_radians);
        let turned = Rotation3::from_axis_angle(&Vector3::x_axis(), x as f32).to_homogeneous()
            * Rotation3::from_axis_angle(&Vector3::z_axis(), z as f32).to_homogeneous();
        let half = view.half as f32;
        let config = RenderConfig {
            world_to_model: turned * Scale3::new(half, half, half).to_homogeneous(),
            image_size: (view.size as u32).into(),
        };
        let single = EvalConfig { threads: None, ..EvalConfig::default() };
        let shape = BoundShape::try_from(self.0.clone()).expect("a shape of x, y and z alone");
        let picture = render(shape, &config, &single).expect("a picture that nobody cancels");
        picture.iter().map(|pixel| pixel.depth > 0).collect()
    }

    /// How many triangles a mesh has, with so many halvings of the cube.
    pub fn triangles(&self, depth: u8) -> usize {
        let shape = BoundShape::try_from(self.0.clone()).expect("a shape of x, y and z alone");
        let octree = Octree::build(&shape, &fidget_mesh::Settings { depth, ..Default::default() });
        octree.expect("a mesh that nobody cancels").walk_dual().triangles.len()
    }
}

/// Six octaves of gradient noise on a ball, in Fidget's operations: at each corner of a lattice three random
/// numbers are a slope, and a quintic fade goes from corner to corner.
fn planet() -> Tree {
    let [x, y, z] = [Tree::x(), Tree::y(), Tree::z()];
    let corner = |corner: [f32; 3]| {
        let at = [(&x, corner[0]), (&y, corner[1]), (&z, corner[2])].map(|(x, c)| x.floor() + c);
        let [dx, dy, dz] = [(&x, &at[0]), (&y, &at[1]), (&z, &at[2])].map(|(x, at)| x.clone() - at.clone());
        let hash = at[0].mix(at[1].clone()).mix(at[2].clone());
        let slope = |k: f32| if k == 0.0 { hash.rand() } else { hash.mix(k).rand() } * 2f32 - 1f32;
        dx * slope(0.0) + dy * slope(1.0) + dz * slope(2.0)
    };
    let fade = |x: &Tree| {
        let t = x.clone() - x.floor();
        t.clone() * t.clone() * t.clone() * (t.clone() * (t * 6f32 - 15f32) + 10f32)
    };
    let between = |a: Tree, b: Tree, t: &Tree| a.clone() + t.clone() * (b - a);
    let (u, v, w) = (fade(&x), fade(&y), fade(&z));
    let row = |y: f32, z: f32| between(corner([0.0, y, z]), corner([1.0, y, z]), &u);
    let face = |z: f32| between(row(0.0, z), row(1.0, z), &v);
    let noise = between(face(0.0), face(1.0), &w).min(1f32).max(-1f32);
    let mut ball = (x.square() + y.square() + z.square()).sqrt() - 0.75f32;
    for octave in 0..6 {
        let (scale, shift) = (4.0 * (1 << octave) as f32, octave as f32);
        let at = |x: &Tree, offset: f32| x.clone() * scale + offset * shift;
        ball = ball - noise.remap_xyz(at(&x, 17.3), at(&y, 9.1), at(&z, 5.7)) * (0.6 / scale);
    }
    ball
}
