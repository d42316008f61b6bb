//! Everything that can be done, and can go wrong, before the first ray.

use super::light::Surroundings;
use super::rays::piece;
use super::reflect::Reflecting;
use super::sample::{Purpose, Sample};
use super::view::{View, tolerance};
use super::water::Water;
use super::{Atmosphere, Painter, Probe, RenderError, Settings};
use crate::cast::{Ray, Tolerance};
use crate::diag::Diagnostic;
use crate::expr::{Graph, NodeId};
use crate::field::Field;
use crate::scene::{Light, Scene, Sea, Sky, Sun, Surface};
use crate::tape::{Cells, Tape};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

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
    /// How the solid reflects; matt without it.
    pub reflecting: Option<Reflecting>,
    /// Whether it gives off light.
    pub is_shining: bool,
    /// Code of what varies of the material from place to place.
    pub looks: Option<Arc<Tape>>,
    /// Code of the height that is added to the solid for the sake of its normals.
    pub bump: Option<Arc<Tape>>,
    /// Changes the colours of what is met, if anybody does.
    pub painter: Option<Box<dyn Painter>>,
    /// How far a hit may lie in front of the surface.
    pub tolerance: Tolerance,
    /// The camera.
    pub view: View,
    /// The lights, the main one first.
    pub lights: Vec<Light>,
    /// Directions of suns and their irradiances, in the same order.
    pub suns: Vec<(DVec3, DVec3)>,
    /// Light from everywhere else.
    pub sky: Sky,
    /// Water that the solid stands in.
    pub sea: Option<Sea>,
    /// The sky's air, made ready.
    pub air: Option<Atmosphere>,
    /// What samples of the field say.
    pub probe: Probe,
    /// What is odd about the scene, though it can be rendered.
    pub warnings: Vec<Diagnostic>,
}

/// Makes a scene ready to be rendered: its ground, as its field has it. What is to be left out of that
/// ([`Surface::keep`](crate::scene::Surface)), the surface of a sea and that of a moon need casters of their own, which
/// [`session::render`](crate::session::render()) makes: it is what pictures of whole scenes come from.
///
/// # Errors
/// [`RenderError`] for settings, cameras and fields of which no picture can be made; [`RenderError::Stopped`] if `cancel`
/// was set in time.
pub fn prepare(scene: &Scene, settings: &Settings, cancel: &AtomicBool) -> Result<Prepared, RenderError> {
    settings.check()?;
    let view = View::new(&scene.camera, settings.width, settings.height).map_err(RenderError::Camera)?;
    let Surface { material, .. } = &scene.surface;
    let mut roots = scene.surface.roots();
    let colors = roots.len();
    roots.extend(material.iter().flat_map(|m| m.looks()));
    let looks = roots.len();
    roots.extend(material.iter().filter_map(|m| m.bump));
    let (graph, roots) = view.spacing(settings.samples).limit(&scene.graph, &roots)?;
    let code = |roots: &[NodeId]| (!roots.is_empty()).then(|| Arc::new(Tape::new(&graph, roots)));
    let tape = Arc::new(Tape::new(&graph, &roots[..1]));
    let probe = Probe::new(&tape, &settings.bounds, &view, cancel).ok_or(RenderError::Stopped)?;
    let mut warnings = probe.judge(scene.place())?;
    warnings.extend(stretched(&view));
    let lights: Vec<Light> = [Light::Sun(scene.sun)].iter().chain(&scene.lights).map(upright).collect();
    let suns = lights.iter().filter_map(|light| match light {
        Light::Sun(sun) => Some((sun.direction, sun.irradiance)),
        Light::Lamp(_) => None,
    });
    let air = scene.sky.air.as_ref().and_then(|air| Atmosphere::new(air, cancel));
    let reflecting = material.as_ref().map(Reflecting::new);
    if cancel.load(Ordering::Relaxed) {
        return Err(RenderError::Stopped);
    }
    let tolerance = settings.tolerance.map_or_else(|| tolerance(&view, settings), Tolerance::fixed);
    Ok(Prepared {
        settings: *settings,
        field: roots[0],
        cells: Arc::new(Cells::of_sides(tape.clone(), &settings.bounds.intervals())),
        tape,
        color: code(&roots[1..colors]),
        reflecting,
        is_shining: material.is_some_and(|m| m.emission.is_some()),
        looks: code(&roots[colors..looks]),
        bump: code(&roots[looks..]),
        painter: None,
        tolerance,
        view,
        suns: suns.collect(),
        lights,
        sky: scene.sky,
        sea: scene.sea,
        air,
        probe,
        warnings,
        graph,
    })
}

/// The field that the picture shows, alone: to find out where there is anything of it, before a scene is prepared.
///
/// # Errors
/// As for [`prepare`], as far as it is about settings, cameras and the size of the expression.
pub fn shown(scene: &Scene, settings: &Settings) -> Result<Field, RenderError> {
    settings.check()?;
    let view = View::new(&scene.camera, settings.width, settings.height).map_err(RenderError::Camera)?;
    let (graph, roots) = view.spacing(settings.samples).limit(&scene.graph, &[scene.surface.field])?;
    Ok(Field::new(&graph, roots[0]))
}

/// A light with a direction, whatever it was given.
fn upright(light: &Light) -> Light {
    match *light {
        Light::Sun(sun) => {
            Light::Sun(Sun { direction: sun.direction.try_normalize().unwrap_or(DVec3::Y), ..sun })
        }
        Light::Lamp(lamp) => Light::Lamp(lamp),
    }
}

/// A warning where pixels are not square though they could be.
fn stretched(view: &View) -> Option<Diagnostic> {
    let shape = view.wanted_shape()?;
    let warning =
        Diagnostic::warning("the picture is stretched: it does not have the shape of what the camera sees");
    Some(warning.hint(format!("make it {shape} times as wide as high")))
}

impl Prepared {
    /// What is beyond everything, and gives light.
    pub(super) fn around(&self) -> Surroundings<'_> {
        Surroundings { sky: &self.sky, air: self.air.as_ref(), suns: &self.suns }
    }

    /// Light that comes back from all around to an eye below the surface of a sea; `None` above it.
    pub(super) fn glow_below(&self, surface: &Prepared) -> Option<DVec3> {
        let water = self.sea.as_ref().map(Water::new).filter(|_| surface.probe.camera_inside)?;
        Some(water.glow(PI * self.around().overhead(self.view.eye)))
    }

    /// Bundles of neighbouring lines of sight all over the picture, for choosing a caster; that in its middle comes first.
    pub fn typical_rays(&self) -> Vec<Vec<Ray>> {
        /// Bundles across the picture, their order row by row, and rays across a bundle.
        const ACROSS: u32 = 3;
        const MIDDLE_FIRST: [u32; (ACROSS * ACROSS) as usize] = [4, 0, 5, 1, 6, 2, 7, 3, 8];
        const WITHIN: u32 = 8;
        let Settings { width, height, bounds, .. } = self.settings;
        let corner = |i: u32, size: u32| (f64::from(i) + 0.5) / f64::from(ACROSS) * f64::from(size);
        let bundle = |i: u32| {
            let (x, y) = (corner(i % ACROSS, width), corner(i / ACROSS, height));
            let through = |j: u32| {
                let lens = Sample::new([i, i], j, self.settings.seed, 0).pair(Purpose::Lens);
                self.view.ray(x + f64::from(j % WITHIN), y + f64::from(j / WITHIN), lens)
            };
            (0..WITHIN * WITHIN).filter_map(|j| piece(through(j), &bounds, self.tolerance)).collect()
        };
        MIDDLE_FIRST.map(bundle).to_vec()
    }
}
