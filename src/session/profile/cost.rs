//! What lines cost, by the clock.

use super::sight::Sight;
use crate::expr::{Graph, Node, NodeId};
use crate::field::{Stopped, Watch};
use crate::num::{Dual, Many, Number, Parabola, Parabolas};
use crate::render::Prepared;
use crate::session::ledger::{Ledger, Line};
use crate::tape::{self, Instr, Tape};
use glam::DVec3;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Points that are evaluated together, as the beam caster does.
const LANES: usize = 16;

/// After so long, the codes that are left are not timed any more, those that serve the fewest points.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Batches of points at which colours are timed.
const BATCHES: usize = 4;

/// What the lines of a script cost.
#[derive(Clone, Debug, Serialize)]
pub struct Cost {
    /// Nanoseconds for a point, on one thread.
    pub nanoseconds: f64,
    /// The lines, the most expensive first; their shares sum to one.
    pub lines: Vec<LineCost>,
}

/// What a line costs.
#[derive(Clone, Debug, Serialize)]
pub struct LineCost {
    /// The line.
    #[serde(flatten)]
    pub line: Line,
    /// Its share.
    pub share: f64,
    /// Nanoseconds for a point.
    pub nanoseconds: f64,
    /// What takes the time, the most expensive first.
    pub what: Vec<String>,
}

/// Seconds by node, for a number of points.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    seconds: HashMap<NodeId, f64>,
    points: f64,
}

impl Times {
    /// The share of a node.
    pub fn share(&self, node: NodeId) -> f64 {
        self.seconds.get(&node).map_or(0.0, |seconds| seconds / self.total())
    }

    /// In the order of the nodes, so that sums have the same bits each time.
    fn sorted(&self) -> BTreeMap<NodeId, f64> {
        self.seconds.iter().map(|(node, seconds)| (*node, *seconds)).collect()
    }

    fn total(&self) -> f64 {
        self.sorted().values().sum()
    }

    fn add(&mut self, node: NodeId, seconds: f64) {
        *self.seconds.entry(node).or_default() += seconds;
    }

    /// Adds what a code takes for a batch, so many times.
    fn charge<T: Number>(&mut self, tape: &Arc<Tape>, at: &[T; 3], times: f64) {
        let taken = tape::seconds(tape, at);
        for ((instr, node), seconds) in tape.code().iter().zip(tape.origins()).zip(taken) {
            match instr {
                Instr::Flow(flowed, _) => {
                    let mut inner = Times::default();
                    inner.charge(flowed.velocity().tape(), at, 4.0 * f64::from(flowed.steps()));
                    inner.charge(flowed.field().tape(), at, 1.0);
                    self.add_flow(*node, &inner, times * seconds);
                }
                _ if seconds > 0.0 => self.add(*node, times * seconds),
                _ => {}
            }
        }
    }

    /// Adds what a code takes for a batch by machine code, which is shared out as it would be without.
    fn charge_natively<T: Number>(&mut self, tape: &Arc<Tape>, at: &[T; 3]) {
        let mut one_by_one = Times::default();
        one_by_one.charge(tape, at, 1.0);
        self.add_all(&one_by_one, tape::duration(tape, at));
    }

    /// Shares out what a flow takes among what it carries.
    fn add_flow(&mut self, node: NodeId, inner: &Times, seconds: f64) {
        if inner.total() > 0.0 {
            self.add_all(inner, seconds);
        } else {
            self.add(node, seconds);
        }
    }

    /// Shares out seconds among what takes some.
    fn add_all(&mut self, parts: &Times, seconds: f64) {
        let total = parts.total();
        parts.sorted().into_iter().for_each(|(node, part)| self.add(node, seconds * part / total));
    }

    /// The times of lines.
    pub fn by_line(&self, ledger: &Ledger, graph: &Graph) -> Cost {
        let mut lines: BTreeMap<Line, BTreeMap<String, f64>> = BTreeMap::new();
        for (node, seconds) in self.sorted() {
            let of_line = lines.entry(ledger.line(node)).or_default();
            *of_line.entry(name(graph.node(node))).or_default() += seconds;
        }
        let (total, points) = (self.total(), self.points.max(1.0));
        let cost = |(line, parts): (Line, BTreeMap<String, f64>)| {
            let seconds: f64 = parts.values().sum();
            let mut parts: Vec<_> = parts.into_iter().collect();
            parts.sort_by(|a, b| b.1.total_cmp(&a.1));
            let share = if total > 0.0 { seconds / total } else { 0.0 };
            let what = parts.into_iter().map(|part| part.0).collect();
            LineCost { line, share, nanoseconds: 1e9 * seconds / points, what }
        };
        let mut lines: Vec<LineCost> = lines.into_iter().map(cost).collect();
        lines.sort_by(|a, b| b.share.total_cmp(&a.share));
        Cost { nanoseconds: 1e9 * total / points, lines }
    }
}

/// What people call a node.
pub(super) fn name(node: &Node) -> String {
    match node {
        Node::Const(_) => "a number".to_owned(),
        Node::Input(_) => "a coordinate".to_owned(),
        Node::Op(op, _) => op.name().to_owned(),
        Node::Noise(noise, _) => format!("{} noise", noise.kind.name()),
        Node::Fractal(fractal, ..) => {
            let recipe = fractal.recipe();
            format!(
                "{} of {} octaves of {} noise",
                recipe.model.name(),
                recipe.octaves,
                recipe.noise.kind.name()
            )
        }
        Node::Grid(..) => "grid".to_owned(),
        Node::Shape(shape, _) => shape.body().name().to_owned(),
        Node::Flow(..) => "flow".to_owned(),
    }
}

/// Seconds for the solid, by the code that is left where it is seen.
pub(super) fn of_solid(shown: &Prepared, seen: &[Sight], watch: &Watch<'_>) -> Result<Times, Stopped> {
    let places = seen.iter().enumerate().map(|(i, sight)| (i, sight.p.to_array(), sight.footprint));
    let list = shown.cells.tapes_around(places);
    let mut groups: Vec<_> = list.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)).collect();
    groups.sort_by_key(|group| (std::cmp::Reverse(group.len()), group[0].1));
    let (mut times, start) = (Times::default(), Instant::now());
    for (i, group) in groups.iter().enumerate() {
        watch.check()?;
        if start.elapsed() > PATIENCE {
            break;
        }
        let members: Vec<Sight> = group.iter().map(|(_, i)| seen[*i]).collect();
        times.charge(group[0].0, &pieces(&members), members.len() as f64 / LANES as f64);
        times.points += members.len() as f64;
        (watch.progress)((i + 1) as f64 / groups.len() as f64);
    }
    Ok(times)
}

/// Pieces of rays, a pixel long, at points that are spread evenly over a list.
pub(super) fn pieces(seen: &[Sight]) -> [Parabolas<LANES, 0>; 3] {
    std::array::from_fn(|axis| {
        let mut batch = Parabolas::all(Parabola::constant(crate::num::Interval::point(0.0)));
        for (lane, sight) in spread(seen).into_iter().enumerate() {
            let slope = 0.5 * sight.footprint * sight.direction[axis];
            batch.set(lane, &Parabola::coordinate(sight.p[axis], slope, [], 0.0, 0.0));
        }
        batch
    })
}

/// As many members of a list as a batch has lanes; a short list is repeated.
fn spread(seen: &[Sight]) -> [Sight; LANES] {
    let step = (seen.len() as f64 / LANES as f64).max(1.0);
    std::array::from_fn(|lane| seen[(lane as f64 * step) as usize % seen.len()])
}

/// Seconds for colours and material, if the scene says something of them.
pub(super) fn of_shading(shown: &Prepared, seen: &[Sight]) -> Option<Times> {
    let mut times = Times::default();
    let size = seen.len().div_ceil(BATCHES).max(1);
    for part in seen.chunks(size) {
        let points = spread(part).map(|sight| sight.p);
        let at = |axis: usize| Many(points.map(|p: DVec3| p[axis]));
        for tape in [&shown.color, &shown.looks].into_iter().flatten() {
            times.charge_natively(tape, &[at(0), at(1), at(2)]);
        }
        if let Some(bump) = &shown.bump {
            let at = |axis: usize| Many(points.map(|p: DVec3| Dual::coordinate(p[axis], axis)));
            times.charge_natively(bump, &[at(0), at(1), at(2)]);
        }
        times.points += LANES as f64;
    }
    (times.total() > 0.0).then_some(times)
}
