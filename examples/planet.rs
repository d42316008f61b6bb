//! A planet described and rendered from Rust, without a script: `cargo run --release --example
//! planet -- planet.png`. The ending of the name picks the format (`.png` or `.exr`).

use glam::DVec3;
use orogen::cast::{Kind, caster};
use orogen::expr::{Graph, Input, NodeId, TooLarge};
use orogen::field::Field;
use orogen::noise::{Fractal, Gradient, Model, Noise, Recipe};
use orogen::op::{self, Op};
use orogen::render::{Job, Metadata, Settings, can_save, prepare, render, save};
use orogen::scene::{Aabb, Air, Camera, Film, Scene, Sky, Sun, Surface};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The unit sphere with ridges a little way up and down from it, and its colours.
fn planet(graph: &mut Graph) -> Result<Surface, Box<dyn Error>> {
    let p = graph.point()?;
    let footprint = graph.input(Input::Footprint)?;
    let noise = Noise::new(orogen::noise::Kind::Gradient(Gradient::EDGES), 7).at_frequency(3.0);
    let recipe = Recipe { octaves: 9, rotate: true, ..Recipe::new(noise, Model::RIDGED) };
    let ridges = graph.fractal(Arc::new(Fractal::new(recipe)?), p, footprint)?;
    let height = scaled(graph, ridges, 0.03)?;
    let radius = graph.op(Op::Length(op::Length), &p)?;
    let one = graph.constant(1.0)?;
    let sphere = graph.op(Op::Sub(op::Sub), &[radius, one])?;
    let field = graph.op(Op::Sub(op::Sub), &[sphere, height])?;
    // From dark rock in the valleys, at 1.02, to pale rock on the ridges, at 1.06.
    let valleys = graph.constant(0.02)?;
    let above = graph.op(Op::Sub(op::Sub), &[sphere, valleys])?;
    let steps = scaled(graph, above, 25.0)?;
    let pale = graph.op(Op::Smoothstep(op::Smoothstep), &[steps])?;
    let mut mix = |low: f64, high: f64| -> Result<NodeId, TooLarge> {
        let ends = [graph.constant(low)?, graph.constant(high)?];
        graph.op(Op::Mix(op::Mix), &[ends[0], ends[1], pale])
    };
    let color = [mix(0.20, 0.75)?, mix(0.13, 0.70)?, mix(0.09, 0.66)?];
    Ok(Surface { field, color: Some(color), material: None, keep: None })
}

fn scaled(graph: &mut Graph, node: NodeId, by: f64) -> Result<NodeId, TooLarge> {
    let by = graph.constant(by)?;
    graph.op(Op::Mul(op::Mul), &[node, by])
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "planet.png".to_owned());
    let path = Path::new(&path);
    can_save(path)?;

    let mut graph = Graph::default();
    let surface = planet(&mut graph)?;
    // The ridges lift the ground: most of it lies between 1.02 and 1.06.
    let air = Air::clear(1.02, 0.008, DVec3::new(5.8, 13.5, 33.1));
    let scene = Scene {
        graph: Arc::new(graph),
        surface,
        camera: Camera::orbit(DVec3::ZERO, 3.6, 20.0, 15.0).with_fov(38.0),
        sun: Sun {
            direction: orogen::scene::direction(85.0, 25.0),
            irradiance: DVec3::splat(3.4),
            ..Sun::default()
        },
        lights: Vec::new(),
        sky: Sky { up: None, background: DVec3::ZERO, air: Some(air), ..Sky::default() },
        moon: None,
        sea: None,
        film: Film { width: 480, height: 360, samples: 4, ..Film::default() },
        bounds: Some(Aabb::cube(1.1)),
        params: Vec::new(),
    };

    let cancel = AtomicBool::new(false);
    let prepared = prepare(&scene, &Settings::of(&scene, Aabb::cube(2.0)), &cancel)?;
    let field = Field::new(&prepared.graph, prepared.field);
    let caster = caster(Kind::Auto, &field, &prepared.settings.bounds, &prepared.typical_rays())?;
    let picture = render(&prepared, &*caster, &Job::unwatched(&cancel))?;
    for warning in &picture.warnings {
        eprintln!("{warning}");
    }
    println!("{}", serde_json::to_string_pretty(&picture.stats)?);
    Ok(save(path, &picture, &Metadata::default())?)
}
