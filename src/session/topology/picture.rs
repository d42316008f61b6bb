//! Pictures of what a solid is connected with.

use super::judge::Components;
use super::{Analysis, Labels, Parts, kept};
use crate::diag::Diagnostic;
use crate::render::{Job, Overlay, Painter, Picture};
use crate::scene::{Keep, Scene};
use crate::session::stage::{Order, Touch, render_touched};
use crate::topology::{CriticalPoint, Kind, separatrices};
use glam::DVec3;
use std::sync::Arc;

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

/// Red, as the thesis has it.
const RED: DVec3 = DVec3::new(0.8, 0.03, 0.02);

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
    let labels = Labels::new(analysis);
    let kept: Arc<[bool]> = kept(analysis, keep)?.into();
    let painted = |by: fn(usize, &[bool]) -> Option<DVec3>| -> Option<Box<dyn Painter>> {
        Some(Box::new(Paint { labels: labels.again(), kept: kept.clone(), by }))
    };
    let shown = |touch: Touch| render_touched(scene, order, touch, job);
    let judged = || {
        Ok::<_, Box<Diagnostic>>(Touch {
            judge: Some(Box::new(Components::new(analysis, keep)?)),
            painter: None,
        })
    };
    Ok(match show {
        Show::Components => shown(Touch { painter: painted(tint), judge: None })?.0,
        Show::Specks => shown(Touch { painter: painted(alarm), judge: None })?.0,
        Show::Kept => shown(judged()?)?.0,
        Show::Network => {
            let (mut picture, view) = shown(Touch { painter: painted(tint), judge: None })?;
            network(analysis).draw(&mut picture, &view);
            picture
        }
        Show::Triptych => {
            let plain = shown(Touch::default())?.0;
            let specks = shown(Touch { painter: painted(alarm), judge: None })?.0;
            beside(&[plain, specks, shown(judged()?)?.0])
        }
    })
}

/// The colour of a component, if it is not that of the scene: evenly spread hues.
fn tint(component: usize, _: &[bool]) -> Option<DVec3> {
    let hue = std::f64::consts::TAU * (0.618_034 * component as f64);
    let channel = |shift: f64| 0.3 + 0.27 * libm::cos(hue - shift * std::f64::consts::TAU / 3.0);
    (component > 0).then(|| DVec3::new(channel(0.0), channel(1.0), channel(2.0)))
}

/// Red for what is not kept.
fn alarm(component: usize, kept: &[bool]) -> Option<DVec3> {
    (!kept[component]).then_some(RED)
}

/// Paints by component.
#[derive(Debug)]
struct Paint {
    labels: Labels,
    kept: Arc<[bool]>,
    by: fn(usize, &[bool]) -> Option<DVec3>,
}

impl Painter for Paint {
    fn paint(&mut self, points: &[DVec3], colors: &mut [DVec3]) {
        for (color, component) in colors.iter_mut().zip(self.labels.components(points)) {
            let painted = component.and_then(|component| (self.by)(component, &self.kept));
            *color = painted.unwrap_or(*color);
        }
    }

    fn clone_box(&self) -> Box<dyn Painter> {
        Box::new(Paint { labels: self.labels.again(), kept: self.kept.clone(), by: self.by })
    }
}

/// Minima and saddles with the lines between them; nothing of a field that has none.
fn network(analysis: &Analysis) -> Overlay {
    let Parts::Complex(complex) = &analysis.parts else { return Overlay::default() };
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
    Picture {
        width: width * pictures.len() as u32,
        pixels: (0..height).flat_map(row).collect(),
        finished: pictures.iter().all(|p| p.finished),
        warnings: first.warnings.clone(),
        stats,
        ..*first
    }
}
