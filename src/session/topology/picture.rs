//! Pictures of what a solid is connected with.

use super::judge::Components;
use super::local::{Apart, Joined};
use super::{Analysis, Labels, kept};
use crate::cast::{Judge, Ruling};
use crate::diag::Diagnostic;
use crate::render::{Job, Overlay, Painter, Picture, Rect, View};
use crate::scene::{Keep, Scene};
use crate::session::stage::{Order, Touch, render_touched};
use crate::topology::local::{Local, Seeker};
use crate::topology::{CriticalPoint, Kind, separatrices};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What a picture shows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Show {
    /// Each component in a colour of its own, the main one in that of the scene.
    Components,
    /// What is not kept in red.
    Specks,
    /// Only what is kept.
    Kept,
    /// Critical points inside, and the separatrices that join them, over the solid.
    Network,
    /// The solid as it is, with what is not kept in red, and without it, side by side.
    Triptych,
}

/// Red, as the thesis has it, and green on planets.
const RED: DVec3 = DVec3::new(0.8, 0.03, 0.02);
const GREEN: DVec3 = DVec3::new(0.05, 0.6, 0.04);

/// Colours of minima, saddles of both kinds and maxima: linear.
pub const COLORS: [[f32; 3]; 4] =
    [[1.0, 0.75, 0.1], [0.1, 0.75, 0.95], [0.75, 0.25, 0.9], [0.95, 0.95, 0.95]];

/// Colours of separatrices: those that join, and those that close rings.
pub const ARCS: [[f32; 3]; 2] = [[1.0, 0.85, 0.4], [0.25, 0.55, 0.85]];

/// Makes such a picture of a scene, with what `keep` says counting.
///
/// # Errors
/// As for [`render`](crate::session::render), and where no component holds a point that one should.
pub fn picture(
    scene: &Scene,
    order: &Order,
    analysis: &Analysis,
    (show, keep): (Show, &Keep),
    job: &Job<'_>,
) -> Result<Picture, Box<Diagnostic>> {
    let labels = &analysis.labels;
    let kept: Arc<[Ruling]> = kept(analysis, keep)?.into();
    let painted = |by: fn(usize, &[Ruling]) -> Option<DVec3>| -> Box<dyn Painter> {
        Box::new(Paint { labels: labels.clone(), kept: kept.clone(), by })
    };
    let judge = Components::new(analysis, kept.clone());
    let means = Means { scene, order, judge: &judge, specks: &*painted(alarm), job };
    match show {
        Show::Specks => means.specks(),
        Show::Kept => means.kept(),
        Show::Triptych => means.triptych(),
        Show::Components => Ok(means.painted(painted(tint))?.0),
        Show::Network => {
            let (mut picture, view) = means.painted(painted(tint))?;
            network(analysis).draw(&mut picture, &view);
            Ok(picture)
        }
    }
}

/// Makes such a picture of a solid of which no more is found out than the picture needs.
///
/// # Errors
/// As for [`render`](crate::session::render), and where all of the solid would have to be known.
pub fn local_picture(
    scene: &Scene,
    order: &Order,
    local: &Arc<Local>,
    show: Show,
    job: &Job<'_>,
) -> Result<Picture, Box<Diagnostic>> {
    let seeker = Seeker::new(local.clone());
    let judge = Joined(seeker.clone());
    let means = Means { scene, order, judge: &judge, specks: &Apart { seeker, color: GREEN }, job };
    match show {
        Show::Specks => means.specks(),
        Show::Kept => means.kept(),
        Show::Triptych => means.triptych(),
        Show::Components | Show::Network => {
            let error = "what is found out as rays need it shows neither all components nor their network";
            let hint = "try --show specks, kept or triptych; or component_of(f, p) without `feature`";
            Err(Box::new(Diagnostic::error(error).hint(hint)))
        }
    }
}

/// What pictures with and without specks are made from.
struct Means<'a> {
    scene: &'a Scene,
    order: &'a Order,
    judge: &'a dyn Judge,
    specks: &'a dyn Painter,
    job: &'a Job<'a>,
}

impl Means<'_> {
    fn shown(&self, touch: Touch) -> Result<(Picture, View), Box<Diagnostic>> {
        render_touched(self.scene, self.order, touch, self.job)
    }

    fn painted(&self, painter: Box<dyn Painter>) -> Result<(Picture, View), Box<Diagnostic>> {
        self.shown(Touch { painter: Some(painter), judge: None })
    }

    fn specks(&self) -> Result<Picture, Box<Diagnostic>> {
        Ok(self.painted(self.specks.clone_box())?.0)
    }

    fn kept(&self) -> Result<Picture, Box<Diagnostic>> {
        Ok(self.shown(Touch { judge: Some(self.judge.clone_box()), painter: None })?.0)
    }

    fn triptych(&self) -> Result<Picture, Box<Diagnostic>> {
        let plain = self.shown(Touch::default())?.0;
        Ok(beside(&[plain, self.specks()?, self.kept()?]))
    }
}

/// The colour of a component, if it is not that of the scene: evenly spread hues.
fn tint(component: usize, _: &[Ruling]) -> Option<DVec3> {
    let hue = std::f64::consts::TAU * (0.618_034 * component as f64);
    let channel = |shift: f64| 0.3 + 0.27 * libm::cos(hue - shift * std::f64::consts::TAU / 3.0);
    (component > 0).then(|| DVec3::new(channel(0.0), channel(1.0), channel(2.0)))
}

/// Red for what is not kept.
fn alarm(component: usize, kept: &[Ruling]) -> Option<DVec3> {
    (!kept[component].kept).then_some(RED)
}

/// Paints by component.
#[derive(Debug)]
struct Paint {
    labels: Labels,
    kept: Arc<[Ruling]>,
    by: fn(usize, &[Ruling]) -> Option<DVec3>,
}

impl Painter for Paint {
    fn paint(&mut self, points: &[DVec3], colors: &mut [DVec3], _: &AtomicBool) {
        for (color, component) in colors.iter_mut().zip(self.labels.components(points)) {
            let painted = component.and_then(|component| (self.by)(component, &self.kept));
            *color = painted.unwrap_or(*color);
        }
    }

    fn clone_box(&self) -> Box<dyn Painter> {
        Box::new(Paint { labels: self.labels.clone(), kept: self.kept.clone(), by: self.by })
    }
}

/// Minima and saddles with the lines between them; nothing of a field that has none.
fn network(analysis: &Analysis) -> Overlay {
    let Some(complex) = &analysis.complex else { return Overlay::default() };
    let lines = separatrices(&analysis.tape, complex);
    let color = |joins: bool| ARCS[usize::from(!joins)];
    let lines = complex.arcs.iter().zip(lines).map(|(arc, line)| (line, color(arc.joins), 2.2)).collect();
    let shown = complex.points.iter().filter(|p| p.kind <= Kind::Saddle1);
    let dot = |p: &CriticalPoint| {
        (p.position, COLORS[p.kind as usize], if p.kind == Kind::Minimum { 10.0 } else { 6.0 })
    };
    Overlay { lines, dots: shown.map(dot).collect() }
}

/// Pictures of one size in a row.
fn beside(pictures: &[Picture]) -> Picture {
    let first = &pictures[0];
    let (width, height) = (first.width, first.height);
    let row = |y: u32| pictures.iter().flat_map(move |p| (0..width).map(move |x| *p.pixel(x, y)));
    let mut stats = first.stats;
    pictures[1..].iter().for_each(|p| stats += p.stats);
    let together = width * pictures.len() as u32;
    Picture {
        width: together,
        window: Rect::whole(together, height),
        pixels: (0..height).flat_map(row).collect(),
        finished: pictures.iter().all(|p| p.finished),
        warnings: first.warnings.clone(),
        stats,
        denoised: None,
        components: None,
        ..*first
    }
}
