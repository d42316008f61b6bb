//! Picking: what is at a pixel of a picture, for whoever points at it.
//!
//! A [`Picker`] holds all that is known of a scene before the first ray: the field that its picture shows, pruned code
//! for parts of space, a caster. It casts one ray for each question and evaluates the code of one place, so it is asked
//! again and again, as a pointer moves.
//!
//! **The dominant term.** The slope of the field at a point is shared out among the [terms](crate::field::Terms) that it
//! comes from, by the chain rule. The terms of a line together have its share, and the line with the largest is named:
//! it is the one that shapes the surface there most. Where the field is at rest, as in the middle of a ball, or has no
//! slope, no line is.

use super::ledger::{Ledger, Line};
use super::stage::Taken;
use super::topology::Labels;
use super::{Loaded, Order};
use crate::cast::{CastStats, Hit};
use crate::diag::Diagnostic;
use crate::field::{Field, Terms, Watch};
use crate::num::Interval;
use crate::scene::Scene;
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What is known of a field at a point.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Reading {
    /// The point.
    pub point: DVec3,
    /// Value of the field as the picture shows it; `None` where it has none.
    pub value: Option<f64>,
    /// Its gradient; `None` where it has none.
    pub gradient: Option<DVec3>,
    /// Distance from the eye.
    pub distance: f64,
    /// Size of a pixel there.
    pub footprint: f64,
    /// Linear red, green and blue that the script gives the solid there; `None` if it gives none.
    pub color: Option<[f64; 3]>,
    /// The component of the solid, by number in the report of its topology, if the picker was given that.
    pub component: Option<usize>,
    /// The line that most of the slope comes from,
    pub dominant: Option<Dominant>,
}

/// A line that most of the slope at a point comes from.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Dominant {
    /// The line.
    #[serde(flatten)]
    pub line: Line,
    /// Its share of the slope.
    pub share: f64,
}

/// What is at a pixel.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Picked {
    /// What is known of the point of the solid that is seen there; `None` where there is only sky.
    pub hit: Option<Reading>,
    /// Whether that is proven.
    pub certified: bool,
}

/// Says what is at a pixel, or at a point. Has memory of its own: one for each thread.
pub struct Picker {
    taken: Taken,
    color: Option<Evaluator<f64>>,
    labels: Option<Labels>,
    ledger: Arc<Ledger>,
}

impl Picker {
    /// Makes ready for a scene of a script and its picture.
    ///
    /// # Errors
    /// A diagnostic if no picture can be made of the scene.
    pub fn new(
        loaded: &Loaded,
        scene: &Scene,
        order: &Order,
        watch: &Watch<'_>,
    ) -> Result<Picker, Box<Diagnostic>> {
        let (taken, _) = Taken::corrected(scene, &order.at_once(), watch)?;
        let shown = &taken.scene;
        let ledger = Arc::new(Ledger::new(&shown.graph, &[shown.field], &loaded.sources));
        Ok(Picker { color: shown.color.clone().map(Evaluator::new), labels: None, ledger, taken })
    }

    /// Says of points, too, which component they belong to.
    pub fn with_labels(mut self, labels: Labels) -> Picker {
        self.labels = Some(labels);
        self
    }

    /// What is at a place in the picture, in pixels from its top left corner; the middle of the first one is at 0.5, 0.5.
    pub fn pick(&mut self, x: f64, y: f64) -> Picked {
        let Some(ray) = self.taken.scene.sight(x, y) else { return Picked { hit: None, certified: true } };
        let (mut hits, mut stats) = ([Hit::MISS], CastStats::default());
        self.taken.caster.first_hits(&[ray], &mut hits, &mut stats, &AtomicBool::new(false));
        let [hit] = hits;
        let reading = hit.is_hit().then(|| {
            let distance = hit.t;
            let mut reading = self.read_at(ray.at(distance), distance);
            // A hit is in front of the surface, and what belongs to a component is behind it.
            reading.component = self.component(ray.at(distance + 4.0 * ray.tolerance.at(distance)));
            reading
        });
        Picked { hit: reading, certified: hit.certified }
    }

    /// What is known of a point, whatever is in front of it.
    pub fn read(&mut self, point: DVec3) -> Reading {
        let reading = self.read_at(point, point.distance(self.taken.scene.view.eye));
        Reading { component: self.component(point), ..reading }
    }

    fn component(&mut self, point: DVec3) -> Option<usize> {
        self.labels.as_mut()?.components(&[point]).first().copied().flatten()
    }

    fn read_at(&mut self, point: DVec3, distance: f64) -> Reading {
        let shown = &self.taken.scene;
        let tape = Arc::new(shown.tape.prune(&point.to_array().map(Interval::point)));
        let (value, gradient) = Field::of_tape(&tape).gradient(point);
        let color = self.color.as_mut().map(|color| {
            color.eval(&point.to_array());
            [0, 1, 2].map(|channel| *color.output(channel))
        });
        Reading {
            point,
            value: Some(value).filter(|value| value.is_finite()),
            gradient: Some(gradient).filter(|gradient| gradient.is_finite()),
            distance,
            footprint: shown.view.footprint(distance),
            color: color.filter(|color| color.iter().all(|channel| channel.is_finite())),
            component: None,
            dominant: dominant(&tape, point, &self.ledger),
        }
    }
}

/// The line that most of the slope at a point comes from.
fn dominant(tape: &Arc<Tape>, point: DVec3, ledger: &Ledger) -> Option<Dominant> {
    let terms = Terms::new(tape.clone());
    let found = terms.steepness(&point.to_array().map(Interval::point));
    if found.bound == 0.0 || !found.bound.is_finite() {
        return None;
    }
    let mut lines: BTreeMap<Line, f64> = BTreeMap::new();
    for (slot, share) in found.shares {
        *lines.entry(ledger.line(terms.node(slot))).or_default() += share;
    }
    let (line, share) = lines.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(Dominant { line, share })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::Session;
    use crate::world::Memory;

    fn picker(text: &str, size: (u32, u32)) -> Picker {
        let world = Memory([("a.rhai".into(), text.to_owned())].into());
        let loaded = Session::new("a.rhai", Arc::new(world)).load(&Arc::default());
        let order = Order { size: Some(size), ..Order::default() };
        let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
        Picker::new(&loaded, loaded.scene.as_ref().unwrap(), &order, &watch).unwrap()
    }

    const TWO: &str = "let ball = length(p) - 1.0;
        let bumps = 0.02 * sin(60.0 * y);
        scene(#{
            surface: (ball + bumps).colored([1.0, 0.5, 0.25]),
            camera: look_at(#{ eye: [0, 0, 5], target: [0, 0, 0] }),
        })";

    #[test]
    fn the_pixel_in_the_middle_shows_the_pole() {
        let mut picker = picker(TWO, (100, 80));
        let picked = picker.pick(50.0, 40.0);
        let hit = picked.hit.unwrap();
        assert!(picked.certified);
        assert!((hit.distance - 4.0).abs() < 1e-3 && (hit.point - DVec3::Z).length() < 1e-3, "{hit:?}");
        assert!(hit.value.unwrap().abs() < 1e-4);
        assert!((hit.gradient.unwrap() - DVec3::new(0.0, 1.2, 1.0)).length() < 1e-2, "{hit:?}");
        assert_eq!(hit.color, Some([1.0, 0.5, 0.25]));
        let apart = picker.taken.scene.view.footprint(hit.distance);
        assert!(hit.footprint == apart && hit.footprint > 0.01 && hit.footprint < 0.1);
    }

    /// Also where tapes of cells have no more than the side of the surface: within what the bounds cut, and away from it.
    #[test]
    fn readings_have_the_values_of_the_field() {
        let mut picker = picker(
            "let all = [y + 1.0];
            for i in 0..60 { all.push(sphere(0.2).translated([i % 8 - 4.0, -0.5, (i / 8) - 4.0])); }
            scene(#{ surface: union(all), bounds: [[-5, -5, -5], [5, 5, 5]],
                camera: look_at(#{ eye: [0, -3, 20], target: [0, -3, 0] }) })",
            (100, 80),
        );
        let hit = picker.pick(50.0, 40.0).hit.unwrap();
        assert!((hit.point - DVec3::new(0.0, -3.0, 5.0)).length() < 0.1, "{hit:?}");
        for reading in [hit, picker.read(DVec3::new(0.3, 4.0, 0.2)), picker.read(DVec3::new(3.3, -4.0, 0.2))]
        {
            let value = reading.value.unwrap();
            assert!((value - (reading.point.y + 1.0)).abs() < 1e-9 || value > 4.0, "{reading:?}");
            assert!((reading.gradient.unwrap().length() - 1.0).abs() < 1e-9, "{reading:?}");
            assert!(reading.dominant.is_some());
        }
    }

    #[test]
    fn the_dominant_line_is_the_steeper_one() {
        let mut picker = picker(TWO, (100, 80));
        // The bumps are steepest at the equator, 60 x 0.02 = 1.2, and level a quarter of a wave above.
        let at_equator = picker.read(DVec3::Z).dominant.unwrap();
        assert_eq!(at_equator.line.line, 2);
        assert!((at_equator.share - 1.2 / 2.2).abs() < 1e-6, "{at_equator:?}");
        let y = std::f64::consts::PI / 120.0;
        assert_eq!(picker.read(DVec3::new(0.0, y, 1.0)).dominant.unwrap().line.line, 1);
    }

    #[test]
    fn another_thread_may_ask() {
        let mut picker = picker(TWO, (100, 80));
        let here = picker.pick(50.0, 40.0);
        let there = std::thread::spawn(move || picker.pick(50.0, 40.0)).join().unwrap();
        assert_eq!(here, there);
    }

    #[test]
    fn sky_is_nothing_for_certain() {
        let mut picker = picker(TWO, (100, 80));
        assert_eq!(picker.pick(0.5, 0.5), Picked { hit: None, certified: true });
    }

    #[test]
    fn what_has_no_value_is_said_to_have_none() {
        let mut picker = picker("sphere(1.0) + 0.0001 * sqrt(x + 1.0)", (50, 50));
        let beyond = picker.read(DVec3::new(-1.5, 0.0, 0.0));
        assert_eq!((beyond.value, beyond.gradient), (None, None));
        assert!(serde_json::to_string(&beyond).unwrap().contains("\"value\":null"));
    }
}
