//! Components of flowed solids.
//!
//! A flow keeps what is connected, so the components are those of the solid before it flowed, where critical points are
//! fewer and better known; a point of the flowed solid belongs to what the point belongs to from where the flow brought
//! it. Numbers of minima are the same before and after; volumes are those before. All of it needs a flow that brings no two
//! points to one place, and a point to every place of the solid; where that is not proven of its steps, nothing that follows
//! from it is.

use super::super::whereabouts;
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

/// A flow, and whether it is proven that it is one to one, and of all that matters.
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
        let field = Field::new(&scene.graph, scene.surface.field);
        let flowed = field.tape().flowed()?.clone();
        let mut before = scene.clone();
        before.surface.field = flow.field;
        before.bounds = match *keep {
            Keep::Near { .. } => begun(&flowed, &whereabouts::region(scene, &field)),
            _ => None,
        };
        let carried = |p: DVec3| DVec3::from_array(flowed.trace([&[p.x], &[p.y], &[p.z]]).0[0]);
        let keep = match *keep {
            Keep::Holding(p) => Keep::Holding(carried(p)),
            Keep::Near { core, feature } => Keep::Near { core: carried(core), feature },
            Keep::Most(_) | Keep::Share(_) => *keep,
        };
        let one_to_one = is_one_to_one(&flowed, [scene, &before]);
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

/// Where what is in a box came from, as far as is known.
fn begun(flowed: &Flowed, region: &Aabb) -> Option<Aabb> {
    let reach = flowed.reach(half(region))?;
    Some(Aabb { min: region.min - reach, max: region.max + reach })
}

/// Half edge of the smallest cube around the origin that holds a box.
fn half(region: &Aabb) -> f64 {
    region.min.abs().max(region.max.abs()).max_element()
}

/// Cubes in which a flow may be one to one, in units of the cube that holds the solid before.
const ROOM: [f64; 3] = [1.25, 2.0, 8.0];

/// Whether it is proven that a flow is one to one between the solids after and before.
///
/// If it is not so everywhere, then in a cube that holds both. It must be so large that points which come to its faces do
/// not come from inside of the smaller cube around the solid before: then a point comes from every place of that one.
fn is_one_to_one(flowed: &Flowed, scenes: [&Scene; 2]) -> bool {
    if flowed.is_one_to_one() {
        return true;
    }
    let size = |scene: &Scene| {
        whereabouts::whole(scene, &Field::new(&scene.graph, scene.surface.field)).map(|region| half(&region))
    };
    let [Some(after), Some(before)] = scenes.map(size) else { return false };
    let holds = |half: &f64| flowed.reach(*half).is_some_and(|reach| before + reach <= *half);
    let cube = ROOM.map(|room| after.max(room * before)).into_iter().find(holds);
    cube.is_some_and(|half| flowed.is_one_to_one_within(half))
}

/// The solid that all flows of a scene's solid begin with.
pub struct Origin {
    /// Its scene.
    pub scene: Scene,
    /// What is not proven of the flows.
    pub doubts: Vec<Diagnostic>,
}

impl Origin {
    /// Of what does flow.
    pub fn of(scene: &Scene) -> Option<Origin> {
        let mut found: Option<Origin> = None;
        loop {
            let scene = found.as_ref().map_or(scene, |found| &found.scene);
            let keep = scene.surface.keep;
            let Some(before) = Before::of(scene, &keep.unwrap_or(Keep::Most(Measure::Minima))) else { break };
            let doubt = before.doubt().or_else(|| cut(scene));
            let kept = keep.map(|_| before.keep);
            let surface = Surface { keep: kept, ..before.scene.surface.clone() };
            let doubts = found.take().into_iter().flat_map(|found| found.doubts).chain(doubt).collect();
            found = Some(Origin { scene: Scene { surface, ..before.scene }, doubts });
        }
        found
    }

    /// What is to be said of a report about it.
    pub fn note(&self) -> &'static str {
        if self.doubts.is_empty() {
            "this is of the solid before it flowed, which has the same components"
        } else {
            "this is of the solid before it flowed, which may have other components"
        }
    }
}

/// That bounds may leave out something of a flowed solid.
fn cut(scene: &Scene) -> Option<Diagnostic> {
    scene.bounds?;
    let field = Field::new(&scene.graph, scene.surface.field);
    let warning = "it is not proven that all of the flowed solid is within the bounds of the scene";
    let hint = "widen the bounds, or leave them out";
    let doubt =
        || Diagnostic::warning(warning).at(scene.graph.place(scene.surface.field).cloned()).hint(hint);
    (!whereabouts::locate(scene, &field).is_whole).then(doubt)
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
