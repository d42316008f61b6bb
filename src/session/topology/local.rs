//! What a planet's judge needs: the component of a point, found out as rays ask.
//!
//! What was found is remembered from picture to picture, for the solids that were shown last, so that frames of an
//! animation and pictures that are made again while their script is edited begin where the last one ended.

use super::store::Key;
use crate::cast::{Judge, Ruling};
use crate::diag::Diagnostic;
use crate::field::{self, Field};
use crate::num::Interval;
use crate::render::Painter;
use crate::scene::{Aabb, Scene};
use crate::session::whereabouts;
use crate::tape::{Evaluator, Tape};
use crate::topology::local::{Local, LocalStats, Seeker};
use glam::DVec3;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

/// Solids that are remembered.
const SOLIDS: usize = 4;

/// Which solid, which point of it, and the size of its features, by their bits.
type Which = (Key, [u64; 4]);

/// What was found so far, of the solid that was shown last first.
static REMEMBERED: Mutex<Vec<(Which, Arc<Local>)>> = Mutex::new(Vec::new());

/// What is known of the component of a scene's solid that holds a point. `feature` is the size of its smallest
/// features. A picture begins.
///
/// # Errors
/// If the field is not smooth, and if the point is not inside.
pub fn local(scene: &Scene, core: DVec3, feature: f64) -> Result<Arc<Local>, Box<Diagnostic>> {
    let (graph, root) = (&scene.graph, scene.surface.field);
    field::smooth(graph, root)?;
    let region: Aabb = whereabouts::region(scene, &Field::new(graph, root));
    let bits = [core.x, core.y, core.z, feature].map(f64::to_bits);
    let which = (Key::new(graph, root, &region), bits);
    let mut remembered = REMEMBERED.lock().unwrap_or_else(PoisonError::into_inner);
    let found = match remembered.iter().position(|(other, _)| *other == which) {
        Some(i) => remembered.remove(i).1,
        None => {
            let tape = Arc::new(Tape::new(graph, &[root]));
            Arc::new(Local::new(&tape, &region, core, feature).ok_or_else(|| outside(scene, &tape, core))?)
        }
    };
    found.turn();
    remembered.insert(0, (which, found.clone()));
    remembered.truncate(SOLIDS);
    Ok(found)
}

/// Why there is nothing that a point could be joined with.
fn outside(scene: &Scene, tape: &Arc<Tape>, core: DVec3) -> Box<Diagnostic> {
    let value = *Evaluator::<Interval>::new(tape.clone()).eval(&core.to_array().map(Interval::point));
    let place = scene.graph.place(scene.surface.field).cloned();
    Box::new(super::rulings::outside(core, value).at(place))
}

/// What was not found out for a picture, and what to do about it.
pub fn doubts(stats: &LocalStats) -> Vec<Diagnostic> {
    let LocalStats { asked, unknown, crowded, impatient, .. } = *stats;
    let mut doubts = Vec::new();
    if unknown > 0 {
        let message = format!(
            "of {unknown} of {asked} points it could not be decided what they belong to; they are kept"
        );
        doubts.push(Diagnostic::warning(message).hint("rays that met them count as uncertified"));
    }
    if crowded > 0 {
        let message = format!("{crowded} cubes of size `feature` hold too much to be searched");
        let hint =
            "`feature` is larger than the features of the field; of noise.scaled(s) they are of size 1 / s";
        doubts.push(Diagnostic::warning(message).hint(hint));
    }
    if impatient > 0 {
        let message =
            format!("{impatient} searches were given up, each after thousands of cubes of size `feature`");
        let hint = "`feature` may be too small; of noise.scaled(s) the smallest features are of size 1 / s";
        doubts.push(Diagnostic::warning(message).hint(hint));
    }
    doubts
}

/// Keeps what is joined with the core.
#[derive(Debug)]
pub(super) struct Joined(pub Seeker);

impl Judge for Joined {
    /// A point of which it is not known whether it is joined is kept: better a crumb too many than a hole.
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], cancel: &AtomicBool) {
        for (ruling, answer) in rulings.iter_mut().zip(self.0.answers(points, cancel)) {
            *ruling = Ruling { kept: !answer.is_apart(), proven: answer.is_proven() };
        }
    }

    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(Joined(self.0.clone()))
    }
}

/// Paints what is not joined with the core.
#[derive(Debug)]
pub(super) struct Apart {
    pub seeker: Seeker,
    pub color: DVec3,
}

impl Painter for Apart {
    fn paint(&mut self, points: &[DVec3], colors: &mut [DVec3], cancel: &AtomicBool) {
        for (color, answer) in colors.iter_mut().zip(self.seeker.answers(points, cancel)) {
            if answer.is_apart() {
                *color = self.color;
            }
        }
    }

    fn clone_box(&self) -> Box<dyn Painter> {
        Box::new(Apart { seeker: self.seeker.clone(), color: self.color })
    }
}
