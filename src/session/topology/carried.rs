//! Components of flowed solids.
//!
//! A flow keeps what is connected, so the components are those of the solid before it flowed, where critical points are
//! fewer and better known; a point of the flowed solid belongs to what the point belongs to from where the flow brought
//! it. Numbers of minima are the same before and after; volumes are those before. All of it needs a flow that brings no two
//! points to one place; where that is not proven of its steps, nothing that follows from it is.

use super::super::stage;
use crate::cast::{Judge, Ruling};
use crate::diag::{Diagnostic, Place};
use crate::expr::Node;
use crate::field::Field;
use crate::scene::{Aabb, Keep, Measure, Scene, Surface};
use crate::tape::Flowed;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A solid before it flowed.
pub struct Before {
    /// Its scene, without bounds unless the flow is known not to carry points of these far.
    pub scene: Scene,
    /// What of it is kept.
    pub keep: Keep,
    /// What became of it.
    pub flow: Proven,
}

/// A flow, and whether it is proven that it is one to one where it matters.
#[derive(Clone)]
pub struct Proven {
    flowed: Arc<Flowed>,
    one_to_one: bool,
    place: Option<Place>,
}

impl Before {
    /// Of the solid of a scene; none where that is no flowed one as a whole.
    pub fn of(scene: &Scene, keep: &Keep) -> Option<Before> {
        let Node::Flow(flow, _) = scene.graph.node(scene.surface.field) else { return None };
        let mut field = Field::new(&scene.graph, scene.surface.field);
        let flowed = field.tape().flowed()?.clone();
        let region = stage::region(scene, &mut field);
        let half = region.min.abs().max(region.max.abs()).max_element();
        let mut before = scene.clone();
        before.surface.field = flow.field;
        before.bounds = match (*keep, flowed.reach(half)) {
            (Keep::Near { .. }, Some(reach)) => {
                Some(Aabb { min: region.min - reach, max: region.max + reach })
            }
            _ => None,
        };
        let carried = |p: DVec3| DVec3::from_array(flowed.trace([&[p.x], &[p.y], &[p.z]]).0[0]);
        let keep = match *keep {
            Keep::Holding(p) => Keep::Holding(carried(p)),
            Keep::Near { core, feature } => Keep::Near { core: carried(core), feature },
            Keep::Most(_) | Keep::Share(_) => *keep,
        };
        let one_to_one = flowed.is_one_to_one(half);
        let place = scene.graph.place(scene.surface.field).cloned();
        Some(Before { scene: before, keep, flow: Proven { flowed, one_to_one, place } })
    }

    /// That what the flow keeps is not proven.
    pub fn doubt(&self) -> Option<Diagnostic> {
        let warning = "it is not proven that the steps of the flow keep what the solid is connected with";
        let hint = "more steps, as in f.flow(v, #{ steps: 64 }), may prove it";
        (!self.flow.one_to_one).then(|| Diagnostic::warning(warning).at(self.flow.place.clone()).hint(hint))
    }
}

/// The scene of the solid that all flows of a scene's solid begin with, and what is not proven of these; none of what
/// does not flow.
pub fn origin(scene: &Scene) -> Option<(Scene, Vec<Diagnostic>)> {
    let (mut found, mut doubts): (Option<Scene>, Vec<Diagnostic>) = (None, Vec::new());
    loop {
        let scene = found.as_ref().unwrap_or(scene);
        let keep = scene.surface.keep;
        let Some(before) = Before::of(scene, &keep.unwrap_or(Keep::Most(Measure::Minima))) else { break };
        doubts.extend(before.doubt());
        let kept = keep.map(|_| before.keep);
        found =
            Some(Scene { surface: Surface { keep: kept, ..before.scene.surface.clone() }, ..before.scene });
    }
    found.map(|scene| (scene, doubts))
}

/// Judges points by where they were before a flow.
pub struct Carried {
    /// Says so of the solid before.
    pub judge: Box<dyn Judge>,
    /// The flow.
    pub flow: Proven,
}

impl Judge for Carried {
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], cancel: &AtomicBool) {
        let axis = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<f64>>();
        let (before, _) = self.flow.flowed.trace([&axis(0), &axis(1), &axis(2)]);
        let before: Vec<DVec3> = before.into_iter().map(DVec3::from_array).collect();
        self.judge.judge(&before, rulings, cancel);
        rulings.iter_mut().for_each(|ruling| ruling.proven &= self.flow.one_to_one);
    }

    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(Carried { judge: self.judge.clone_box(), flow: self.flow.clone() })
    }
}
