//! Everything that can be done, and can go wrong, before the first ray.

use super::view::{View, tolerance};
use super::{Atmosphere, Painter, Probe, RenderError, Settings};
use crate::cast::{Ray, Tolerance};
use crate::diag::Diagnostic;
use crate::expr::{Graph, NodeId};
use crate::scene::{Scene, Sky, Spacing, Sun};
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
    /// Changes the colours of what is met, if anybody does.
    pub painter: Option<Box<dyn Painter>>,
    /// How far a hit may lie in front of the surface.
    pub tolerance: Tolerance,
    /// The camera.
    pub view: View,
    /// The main light.
    pub sun: Sun,
    /// Light from everywhere else.
    pub sky: Sky,
    /// The sky's air, made ready.
    pub air: Option<Atmosphere>,
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
    // Samples are as far apart as pixels, over the root of how many there are in each.
    let angle = view.pixel() / f64::from(settings.samples).sqrt();
    let spacing = Spacing::Angle { from: view.eye, angle };
    let (graph, roots) = spacing.limit(&scene.graph, &scene.surface.roots())?;
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
        painter: None,
        tolerance,
        view,
        sun,
        sky: scene.sky,
        air: scene.sky.air.as_ref().and_then(Atmosphere::new),
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
