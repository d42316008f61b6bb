//! Height maps as Fidget makes them.

use crate::{SIZE, View};
use fidget_core::Context;
use fidget_core::context::{Node, Tree};
use fidget_core::shape::{BoundShape, Shape};
use fidget_jit::JitFunction;
use fidget_raster::voxel::{EvalConfig, RenderConfig, render};
use fidget_rhai::FromDynamic;
use nalgebra::{Rotation3, Scale3, Vector3};
use rhai::{Dynamic, EvalAltResult, NativeCallContext};
use std::path::Path;
use std::sync::{Arc, Mutex};

pub struct Model(Shape<JitFunction>);

impl Model {
    pub fn read(path: &Path) -> Result<Model, String> {
        let (context, node) = if path.extension().is_some_and(|e| e == "rhai") {
            script(path)?
        } else {
            let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
            Context::from_text(file).map_err(|e| e.to_string())?
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
            image_size: (SIZE as u32).into(),
        };
        let single = EvalConfig { threads: None, ..EvalConfig::default() };
        let shape = BoundShape::try_from(self.0.clone()).expect("a shape of x, y and z alone");
        let picture = render(shape, &config, &single).expect("a picture that nobody cancels");
        picture.iter().map(|pixel| pixel.depth > 0.0).collect()
    }
}

/// What a script of Fidget's draws.
fn script(path: &Path) -> Result<(Context, Node), String> {
    let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
    let drawn: Arc<Mutex<Option<Tree>>> = Arc::default();
    let target = drawn.clone();
    let mut engine = fidget_rhai::engine();
    let draw = move |context: NativeCallContext, shape: Dynamic| -> Result<(), Box<EvalAltResult>> {
        *target.lock().expect("one thread") = Some(Tree::from_dynamic(&context, shape, None)?);
        Ok(())
    };
    engine.register_fn("draw", draw);
    engine.run(&text).map_err(|e| e.to_string())?;
    let tree = drawn.lock().expect("one thread").take().ok_or("the script draws nothing")?;
    let mut context = Context::new();
    let node = context.import(&tree);
    Ok((context, node))
}
