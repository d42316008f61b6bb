//! Everything that can be done, and can go wrong, before the first ray.

use super::view::{View, tolerance};
use super::{Probe, RenderError, Settings};
use crate::cast::{Ray, Tolerance};
use crate::diag::Diagnostic;
use crate::expr::{Graph, Input, Node, NodeId, TooLarge};
use crate::op::{Length, Op};
use crate::scene::{Scene, Sky, Sun};
use crate::tape::{Cells, Tape};
use glam::DVec3;
use std::sync::Arc;

/// A scene made ready for one camera and one size of picture.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// How it is rendered.
    pub settings: Settings,
    /// The graph that `field` is a node of.
    pub graph: Arc<Graph>,
    /// The field that the picture shows: the scene's, with its detail limited to pixels.
    pub field: NodeId,
    /// The same as code, with the field as its only output.
    pub tape: Arc<Tape>,
    /// The same pruned for parts of the bounds.
    pub cells: Arc<Cells>,
    /// Code of the three colour channels; the solid is grey without it.
    pub color: Option<Arc<Tape>>,
    /// How far a hit may lie in front of the surface.
    pub tolerance: Tolerance,
    /// The camera.
    pub view: View,
    /// The main light.
    pub sun: Sun,
    /// Light from everywhere else.
    pub sky: Sky,
    /// What samples of the field say.
    pub probe: Probe,
    /// What is odd about the scene, though it can be rendered.
    pub warnings: Vec<Diagnostic>,
}

/// Makes a scene ready to be rendered.
///
/// # Errors
/// [`RenderError`] for settings, cameras and fields of which no picture can be made.
pub fn prepare(scene: &Scene, settings: &Settings) -> Result<Prepared, RenderError> {
    settings.check()?;
    let view = View::new(&scene.camera, settings.width, settings.height).map_err(RenderError::Camera)?;
    let mut roots = vec![scene.surface.field];
    roots.extend(scene.surface.color.iter().flatten());
    let (graph, roots) = limit_detail(&scene.graph, &roots, &view, settings.samples)?;
    let tape = Arc::new(Tape::new(&graph, &roots[..1]));
    let color = (roots.len() > 1).then(|| Arc::new(Tape::new(&graph, &roots[1..])));
    let probe = Probe::new(&tape, &settings.bounds, view.eye);
    let place = graph.place(scene.surface.field).cloned();
    let warnings = probe.judge(place)?;
    let sun = Sun { direction: scene.sun.direction.try_normalize().unwrap_or(DVec3::Y), ..scene.sun };
    let tolerance = settings.tolerance.map_or_else(|| tolerance(&view, settings), Tolerance::fixed);
    Ok(Prepared {
        settings: *settings,
        field: roots[0],
        cells: Arc::new(Cells::new(tape.clone(), &settings.bounds.intervals())),
        tape,
        color,
        tolerance,
        view,
        sun,
        sky: scene.sky,
        probe,
        warnings,
        graph,
    })
}

impl Prepared {
    /// Bundles of neighbouring lines of sight all over the picture, for choosing a caster.
    pub fn typical_rays(&self) -> Vec<Vec<Ray>> {
        /// Bundles across the picture, and rays across a bundle.
        const ACROSS: u32 = 3;
        const WITHIN: u32 = 8;
        let Settings { width, height, bounds, .. } = self.settings;
        let corner = |i: u32, size: u32| (f64::from(i) + 0.5) / f64::from(ACROSS) * f64::from(size);
        let bundle = |i: u32| {
            let (x, y) = (corner(i % ACROSS, width), corner(i / ACROSS, height));
            let through = |j: u32| self.view.direction(x + f64::from(j % WITHIN), y + f64::from(j / WITHIN));
            (0..WITHIN * WITHIN).filter_map(|j| self.view.ray(through(j), &bounds, self.tolerance)).collect()
        };
        (0..ACROSS * ACROSS).map(bundle).collect()
    }
}

/// Replaces the footprint by the distance between neighbouring samples at a point: the size of a
/// pixel one unit away, times the distance from the eye, over the root of the samples per pixel.
/// Octaves finer than that fade out. As the footprint is now part of the expression, casting is as
/// exact as it is for any other field.
fn limit_detail(
    graph: &Arc<Graph>,
    roots: &[NodeId],
    view: &View,
    samples: u32,
) -> Result<(Arc<Graph>, Vec<NodeId>), TooLarge> {
    let footprint = Node::Input(Input::Footprint);
    if !graph.reachable(roots).iter().any(|&id| *graph.node(id) == footprint) {
        return Ok((graph.clone(), roots.to_vec()));
    }
    let mut graph = Graph::clone(graph);
    let mut offset = graph.point()?;
    for (axis, node) in offset.iter_mut().enumerate() {
        let eye = graph.constant(-view.eye[axis])?;
        *node = graph.op(Op::Add(crate::op::Add), &[*node, eye])?;
    }
    let distance = graph.op(Op::Length(Length), &offset)?;
    let spacing = graph.constant(view.pixel() / f64::from(samples).sqrt())?;
    let footprint = graph.op(Op::Mul(crate::op::Mul), &[distance, spacing])?;
    let limited = |root: &NodeId| graph.substitute(*root, &[(Input::Footprint, footprint)]);
    let roots = roots.iter().map(limited).collect::<Result<_, _>>()?;
    Ok((Arc::new(graph), roots))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Camera;
    use crate::tape::Evaluator;

    #[test]
    fn the_footprint_is_the_distance_between_samples() {
        let mut graph = Graph::default();
        let root = graph.input(Input::Footprint).unwrap();
        let camera = Camera { eye: DVec3::new(1.0, 2.0, 3.0), target: DVec3::ZERO, up: DVec3::Y, fov: 35.0 };
        let view = View::new(&camera, 40, 30).unwrap();
        let (graph, roots) = limit_detail(&Arc::new(graph), &[root], &view, 4).unwrap();
        let mut field = Evaluator::<f64>::new(Arc::new(Tape::new(&graph, &roots)));
        let p = view.eye + 5.0 * view.forward;
        assert!((field.eval(&p.to_array()) - 5.0 * view.pixel() / 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_field_without_footprint_keeps_its_graph() {
        let mut graph = Graph::default();
        let root = graph.input(Input::X).unwrap();
        let graph = Arc::new(graph);
        let view = View::new(&Camera::default(), 40, 30).unwrap();
        let (same, roots) = limit_detail(&graph, &[root], &view, 4).unwrap();
        assert!(Arc::ptr_eq(&graph, &same) && roots == [root]);
    }
}
