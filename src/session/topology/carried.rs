//! Components of flowed solids.
//!
//! A flow keeps what is connected, so the components are those of the solid before it flowed, where critical points are
//! fewer and better known; a point of the flowed solid belongs to what the point belongs to from where the flow brought
//! it. Numbers of minima are the same before and after; volumes are those before. All of it needs a flow that brings no two
//! points to one place, and a point to every place of the solid; where that is not proven of its steps, nothing that follows
//! from it is.
//!
//! A flowed solid may be moved, turned and scaled, and be made of values that one flow carries, as `f.flow(v) - 0.1` is:
//! moves are taken back like flows, one after the other.

use super::super::whereabouts::{self, Whereabouts};
use crate::cast::{Judge, Ruling};
use crate::diag::{Diagnostic, Place};
use crate::expr::{Graph, Node, NodeId};
use crate::field::Field;
use crate::num::Interval;
use crate::scene::{Aabb, Keep, Measure, Scene, Surface};
use crate::tape::{Evaluator, Flowed, Tape};
use glam::{DMat3, DVec3};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A solid before it flowed, or before a flowed one was moved.
pub struct Before {
    /// Its scene, without bounds unless it is known that points of these were not carried far.
    pub scene: Scene,
    /// What of it is kept.
    pub keep: Keep,
    /// What became of it.
    pub way: Way,
}

/// What became of a solid.
#[derive(Clone)]
pub enum Way {
    /// It flowed.
    Flow(Proven),
    /// It was moved, by a linear map that leads back to where its points were.
    Move(Arc<Tape>),
}

impl Way {
    /// Where points were before.
    fn back(&self, points: &[DVec3]) -> Vec<DVec3> {
        match self {
            Way::Flow(Proven { flowed, .. }) => {
                let axis = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<f64>>();
                let (before, _) = flowed.trace([&axis(0), &axis(1), &axis(2)]);
                before.into_iter().map(DVec3::from_array).collect()
            }
            Way::Move(back) => {
                let mut map = Evaluator::<f64>::new(back.clone());
                let mut before = |p: &DVec3| {
                    map.eval(&p.to_array());
                    DVec3::from_array([0, 1, 2].map(|axis| *map.output(axis)))
                };
                points.iter().map(&mut before).collect()
            }
        }
    }

    /// Whether it is proven that it keeps what is connected.
    fn is_proven(&self) -> bool {
        match self {
            Way::Flow(flow) => flow.one_to_one,
            Way::Move(_) => true,
        }
    }
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
        if !scene.graph.is_carried(scene.surface.field) {
            return None;
        }
        let mut scene = scene.clone();
        if !matches!(scene.graph.node(scene.surface.field), Node::Flow(..)) {
            let mut graph = Graph::clone(&scene.graph);
            scene.surface.field = graph.carried(scene.surface.field).ok()??;
            scene.graph = Arc::new(graph);
        }
        match field(&scene).tape().flowed() {
            Some(flowed) => Before::flowed(&scene, flowed.clone(), keep),
            None => Before::moved(&scene, keep),
        }
    }

    /// Before the flow that is the last of what became of it.
    fn flowed(scene: &Scene, flowed: Arc<Flowed>, keep: &Keep) -> Option<Before> {
        let Node::Flow(flow, _) = scene.graph.node(scene.surface.field) else { return None };
        let mut before = scene.clone();
        before.surface.field = flow.field;
        before.bounds = match *keep {
            Keep::Near { .. } => begun(&flowed, &whereabouts::region(scene, &field(scene))),
            _ => None,
        };
        let one_to_one = is_one_to_one(&flowed, [scene, &before]);
        let place = scene.graph.place(scene.surface.field).cloned();
        let way = Way::Flow(Proven { flowed, one_to_one, place });
        Some(Before::new(before, kept_before(keep, &way, 1.0), way))
    }

    /// Before a move that leaves nothing flat. Of a solid that goes on beyond what is in sight, or beyond the bounds, it is not
    /// known where to look for it.
    fn moved(scene: &Scene, keep: &Keep) -> Option<Before> {
        let Node::Flow(flow, p) = scene.graph.node(scene.surface.field).clone() else { return None };
        let stretch = stretch(&scene.graph, p)?;
        let is_near = matches!(keep, Keep::Near { .. });
        let Whereabouts { region, is_whole } = whereabouts::locate(scene, &field(scene));
        if !(is_near || is_whole) {
            return None;
        }
        let back = Arc::new(Tape::new(&scene.graph, &p));
        let mut graph = Graph::clone(&scene.graph);
        let point = graph.point().ok()?;
        let before = graph.flow(flow, point).ok()?;
        if let Some(place) = graph.place(scene.surface.field).cloned() {
            graph.set_place(before, &place);
        }
        let mut before = Scene {
            graph: Arc::new(graph),
            surface: Surface { field: before, ..scene.surface.clone() },
            ..scene.clone()
        };
        before.bounds = is_near.then(|| image(&back, &region));
        let way = Way::Move(back);
        Some(Before::new(before, kept_before(keep, &way, stretch), way))
    }

    fn new(mut scene: Scene, keep: Keep, way: Way) -> Before {
        scene.surface.keep = scene.surface.keep.map(|_| keep);
        Before { scene, keep, way }
    }

    /// That what the flow keeps is not proven.
    pub fn doubt(&self) -> Option<Diagnostic> {
        let Way::Flow(flow) = &self.way else { return None };
        let warning = "it is not proven that the steps of the flow keep what the solid is connected with";
        let hint = "more steps, as in f.flow(v, #{ steps: 64 }), may prove it";
        (!flow.one_to_one).then(|| Diagnostic::warning(warning).at(flow.place.clone()).hint(hint))
    }
}

fn field(scene: &Scene) -> Field {
    Field::new(&scene.graph, scene.surface.field)
}

/// What is kept of a solid before, which was so much larger.
fn kept_before(keep: &Keep, way: &Way, stretch: f64) -> Keep {
    let back = |p: DVec3| way.back(&[p])[0];
    match *keep {
        Keep::Holding(p) => Keep::Holding(back(p)),
        Keep::Near { core, feature } => Keep::Near { core: back(core), feature: stretch * feature },
        Keep::Most(_) | Keep::Share(_) => *keep,
    }
}

/// How much longer ways are after a linear map of the point, on the mean of the directions; none for other maps, and for those
/// that make space flat, or nearly so.
fn stretch(graph: &Graph, p: [NodeId; 3]) -> Option<f64> {
    let [Some(x), Some(y), Some(z)] = p.map(|row| graph.linear(row)) else { return None };
    let volume = DMat3::from_cols(x, y, z).determinant().abs();
    let most = x.length() * y.length() * z.length();
    (volume > FLAT * most && most.is_finite()).then(|| libm::cbrt(volume))
}

/// The volume of what a unit cube is mapped to, as a share of the most that it could be with sides of the same lengths: maps with
/// less are not told from flat ones.
const FLAT: f64 = 1e-6;

/// A box around where points of a box are mapped to.
fn image(map: &Arc<Tape>, region: &Aabb) -> Aabb {
    let mut sides = Evaluator::<Interval>::new(map.clone());
    sides.eval(&region.intervals());
    let side = |axis: usize| *sides.output(axis);
    Aabb {
        min: DVec3::from_array([0, 1, 2].map(|axis| side(axis).lo)),
        max: DVec3::from_array([0, 1, 2].map(|axis| side(axis).hi)),
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
    /// Whether it was moved as well.
    is_moved: bool,
}

impl Origin {
    /// Of what does flow.
    pub fn of(scene: &Scene) -> Option<Origin> {
        let mut found: Option<Origin> = None;
        loop {
            let scene = found.as_ref().map_or(scene, |found| &found.scene);
            let keep = scene.surface.keep.unwrap_or(Keep::Most(Measure::Minima));
            let Some(before) = Before::of(scene, &keep) else { break };
            let doubt = before.doubt().or_else(|| cut(scene));
            let is_moved = matches!(before.way, Way::Move(_)) || found.as_ref().is_some_and(|f| f.is_moved);
            let doubts = found.take().into_iter().flat_map(|found| found.doubts).chain(doubt).collect();
            found = Some(Origin { scene: before.scene, doubts, is_moved });
        }
        found
    }

    /// What is to be said of a report about it.
    pub fn note(&self) -> &'static str {
        match (self.is_moved, self.doubts.is_empty()) {
            (false, true) => "this is of the solid before it flowed, which has the same components",
            (false, false) => "this is of the solid before it flowed, which may have other components",
            (true, true) => {
                "this is of the solid before it flowed and was moved, which has the same components, in other places"
            }
            (true, false) => {
                "this is of the solid before it flowed and was moved, which may have other components"
            }
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

/// Judges points by where they were before.
pub struct Carried {
    /// Says so of the solid before.
    pub judge: Box<dyn Judge>,
    /// What became of it.
    pub way: Way,
}

impl Judge for Carried {
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], cancel: &AtomicBool) {
        self.judge.judge(&self.way.back(points), rulings, cancel);
        rulings.iter_mut().for_each(|ruling| ruling.proven &= self.way.is_proven());
    }

    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(Carried { judge: self.judge.clone_box(), way: self.way.clone() })
    }
}
