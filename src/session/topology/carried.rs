//! Components of flowed solids.
//!
//! A flow keeps what is connected, so the components are those of the solid before it flowed, where critical points are
//! fewer and better known; a point of the flowed solid belongs to what the point belongs to from where the flow brought
//! it. Numbers of minima are the same before and after; volumes are those before.

use crate::cast::{Judge, Ruling};
use crate::expr::Node;
use crate::scene::{Keep, Scene};
use crate::tape::{Flowed, Tape};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The scene of a solid before it flowed, and the flow; none where the solid is no flowed one as a whole.
pub fn before(scene: &Scene, keep: &Keep) -> Option<(Scene, Keep, Arc<Flowed>)> {
    let Node::Flow(flow, _) = scene.graph.node(scene.surface.field) else { return None };
    let flowed = Tape::new(&scene.graph, &[scene.surface.field]).flowed()?.clone();
    let carried = |p: DVec3| DVec3::from_array(flowed.trace([&[p.x], &[p.y], &[p.z]]).0[0]);
    let mut rest = scene.clone();
    rest.surface.field = flow.field;
    let keep = match *keep {
        Keep::Holding(p) => Keep::Holding(carried(p)),
        // A planet does not go far; where it ends, the scene says.
        Keep::Near { core, feature } => {
            return Some((rest, Keep::Near { core: carried(core), feature }, flowed));
        }
        Keep::Most(_) | Keep::Share(_) => *keep,
    };
    rest.bounds = None;
    Some((rest, keep, flowed))
}

/// Judges points by where they were before a flow.
pub struct Carried {
    /// Says so of the solid before.
    pub judge: Box<dyn Judge>,
    /// The flow.
    pub flowed: Arc<Flowed>,
}

impl Judge for Carried {
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], cancel: &AtomicBool) {
        let axis = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<f64>>();
        let (before, _) = self.flowed.trace([&axis(0), &axis(1), &axis(2)]);
        let before: Vec<DVec3> = before.into_iter().map(DVec3::from_array).collect();
        self.judge.judge(&before, rulings, cancel);
    }

    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(Carried { judge: self.judge.clone_box(), flowed: self.flowed.clone() })
    }
}
