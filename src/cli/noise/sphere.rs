//! The solid sample: a sphere made rough by the noise and shaded by its value.
//!
//! `f = |x| - 1 + a N(s x)`, where `s` makes 32 cells of the noise fill the cube that is seen.

use super::super::progress::Progress;
use super::super::report::{Failure, Terminal};
use crate::analysis::plot::Figure;
use crate::diag::Diagnostic;
use crate::expr::{Graph, Input, NodeId, TooLarge};
use crate::field::Moments;
use crate::op::{self, Op};
use crate::render::{self, Job};
use crate::scene::{Aabb, Camera, Film, Member, Scene, Sky, Sun, Surface};
use crate::session::{self, Order};
use crate::world::atomic;
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Cells of the noise across the cube that is seen.
const CELLS: f64 = 32.0;
/// Half its side, for a sphere of radius 1.
const HALF: f64 = 1.25;
/// Distance of the camera.
const DISTANCE: f64 = 7.0;
/// How far the surface moves by default, as a root mean square in cells.
const ROUGHNESS: f64 = 0.2;

/// The sphere to render.
pub struct Sphere<'a> {
    /// The noise.
    pub noise: &'a Member,
    /// What it is like on average.
    pub moments: &'a Moments,
    /// Length of its cells.
    pub cell: f64,
    /// How far it moves the surface for each unit of its value.
    pub amplitude: Option<f64>,
    /// Side of the picture.
    pub size: u32,
}

impl Sphere<'_> {
    /// Renders the sphere and writes it.
    pub fn write(
        &self,
        path: &Path,
        cancel: &AtomicBool,
        progress: &Progress,
        terminal: &Terminal,
    ) -> Result<(), Failure> {
        let scene = self.scene().map_err(|e| Diagnostic::error(e.to_string()))?;
        let step = |p: render::Progress| progress.set(p.done as f64 / p.total.max(1) as f64);
        let job = Job { progress: &step, ..Job::unwatched(cancel) };
        let picture = session::render(&scene, &Order::default(), &job).map_err(Failure::Error)?;
        if !picture.finished {
            return Err(Failure::error(
                "stopped before the sphere was done",
                "the other figures are written",
            ));
        }
        for warning in &picture.warnings {
            progress.aside(|| terminal.diagnostic(warning, &Default::default()));
        }
        // Light and stone are grey, so one byte a pixel says it all.
        let greys = (0..picture.height).flat_map(|y| picture.row_bytes(y).into_iter().step_by(3));
        let figure = Figure::grey(picture.width, picture.height, greys);
        atomic::write(path, |f| figure.write_png(f)).map_err(|e| Diagnostic::error(e.to_string()).into())
    }

    fn scene(&self) -> Result<Scene, TooLarge> {
        let mut graph = Graph::clone(&self.noise.graph);
        let scale = CELLS * self.cell / (2.0 * HALF);
        let noise = scaled(&mut graph, self.noise.root, scale)?;
        let rms = libm::sqrt(self.moments.variance).max(1e-9);
        let amplitude = self.amplitude.unwrap_or(ROUGHNESS * self.cell / (scale * rms));
        let p = graph.point()?;
        let radius = graph.op(Op::Length(op::Length), &p)?;
        let bump = times(&mut graph, noise, amplitude)?;
        let sum = graph.op(Op::Add(op::Add), &[radius, bump])?;
        let one = graph.constant(1.0)?;
        let field = graph.op(Op::Sub(op::Sub), &[sum, one])?;
        let shade = self.shade(&mut graph, noise)?;
        let fov = 2.0 * libm::atan(HALF / DISTANCE).to_degrees();
        Ok(Scene {
            graph: Arc::new(graph),
            surface: Surface { field, color: Some([shade; 3]) },
            camera: Camera::orbit(DVec3::ZERO, DISTANCE, 30.0, 20.0, fov),
            sun: Sun::default(),
            sky: Sky {
                zenith: DVec3::splat(0.24),
                nadir: DVec3::splat(0.06),
                background: DVec3::splat(0.014),
                ..Sky::default()
            },
            film: Film { width: self.size, height: self.size, samples: 9, exposure: 0.0 },
            bounds: Some(Aabb::cube(HALF)),
            params: Vec::new(),
        })
    }

    /// From dark grey where the noise is low to light grey where it is high.
    fn shade(&self, graph: &mut Graph, noise: NodeId) -> Result<NodeId, TooLarge> {
        let [_, low, _, _, _, high, _] = self.moments.quantiles;
        let zero = graph.constant(low)?;
        let above = graph.op(Op::Sub(op::Sub), &[noise, zero])?;
        let share = times(graph, above, 1.0 / (high - low).max(1e-9))?;
        let smooth = graph.op(Op::Smoothstep(op::Smoothstep), &[share])?;
        let ends = [graph.constant(0.25)?, graph.constant(0.75)?];
        graph.op(Op::Mix(op::Mix), &[ends[0], ends[1], smooth])
    }
}

/// The expression at `s p`, with the size of a pixel there.
fn scaled(graph: &mut Graph, root: NodeId, s: f64) -> Result<NodeId, TooLarge> {
    let mut with = Vec::new();
    for input in [Input::X, Input::Y, Input::Z, Input::Footprint] {
        let node = graph.input(input)?;
        with.push((input, times(graph, node, s)?));
    }
    graph.substitute(root, &with)
}

fn times(graph: &mut Graph, node: NodeId, by: f64) -> Result<NodeId, TooLarge> {
    let by = graph.constant(by)?;
    graph.op(Op::Mul(op::Mul), &[node, by])
}
