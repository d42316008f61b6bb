//! Creases that make rays slow, and whether rounding them would help.
//!
//! Where a field bends sharply nothing is certain of its second derivatives, so that enclosures along a ray get narrow
//! more slowly. But that a rounded crease is faster does not follow: a smooth union has both its parts computed
//! everywhere, where the code of a minimum is pruned to one of them; and a narrow rounding is as good as sharp to a ray,
//! and costs a root besides. Of the siblings in the reference some save a third of the time, and others take ten times as
//! long. So nothing is said on trust. What bends near the surface is put to a *trial*: the same scene, with that one crease
//! rounded, is looked at by the same rays, and there is a hint where they need fewer evaluations and less
//! [work](crate::tape::Tape::work). Work is counted, not timed: what else the machine does must not decide what is said.

use super::bound::REACH;
use super::hints::{DEAR, Found, Hint, percent};
use super::sight::{self, Look, Sight};
use crate::diag::Diagnostic;
use crate::expr::{Graph, Node, NodeId, TooLarge};
use crate::field::Watch;
use crate::noise::{Combination, Fractal, Model, Recipe, Signal};
use crate::num::Interval;
use crate::op::{self, Op};
use crate::scene::{Scene, Surface};
use crate::session::Order;
use crate::session::stage::{Taken, stopped};
use crate::tape::{Evaluator, Instr};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Share of the boxes around the surface in which a crease must not be decided.
const CROSSED: f64 = 0.1;

/// Shares of evaluations and of work that a trial must save.
const FEWER: f64 = 0.1;
const LESS: f64 = 0.15;

/// Most trials, and after how long no other one is begun.
const TRIALS: usize = 4;
const PATIENCE: Duration = Duration::from_millis(3000);

/// A crease is rounded over this share of how far apart its sides are on average: so far that it matters, and not so far
/// that nothing is left of it.
const ROUNDED: f64 = 0.5;

/// Octaves that are left folded: in finer ones a crease is hardly seen.
const FOLDED: u32 = 2;

/// What a trial is of.
#[derive(Clone, Copy)]
pub(super) struct Trials<'a> {
    pub scene: &'a Scene,
    pub order: &'a Order,
    pub watch: &'a Watch<'a>,
}

/// Something that bends, and what is known of that.
struct Crease {
    node: NodeId,
    /// Share of the boxes in which it may bend.
    crossed: f64,
}

/// What can take the place of a crease.
struct Sibling {
    node: NodeId,
    remedy: String,
}

/// Creases without which trials are less work.
pub(super) fn of(found: &Found<'_>, trials: &Trials<'_>) -> Result<Vec<Hint>, Box<Diagnostic>> {
    let (start, mut hints) = (Instant::now(), Vec::new());
    // Which components a scene keeps would have to be found out for each trial.
    let creases = if trials.scene.surface.keep.is_some() { Vec::new() } else { creases(found) };
    for (i, crease) in creases.iter().take(TRIALS).enumerate() {
        if start.elapsed() > PATIENCE {
            break;
        }
        trials.watch.check().map_err(|_| stopped())?;
        hints.extend(attempt(found, crease, trials)?);
        (trials.watch.progress)((i + 1) as f64 / creases.len().min(TRIALS) as f64);
    }
    Ok(hints)
}

/// What bends near the surface, the most often crossed first.
fn creases(found: &Found<'_>) -> Vec<Crease> {
    let (mut counts, mut places) = (BTreeMap::<NodeId, usize>::new(), 0);
    for sight in found.places() {
        places += 1;
        let tape = found.cells.tape_around(sight.p.to_array(), REACH * sight.footprint);
        let mut ranges = Evaluator::<Interval>::keeping_all(tape.clone());
        ranges.eval(&sight.region(REACH));
        for (instr, node) in tape.code().iter().zip(tape.origins()) {
            let bends = match instr {
                Instr::Op(op, args) => may_bend(op, |k| *ranges.value(args[k])),
                // Among octaves there is always one near its fold.
                Instr::Fractal(fractal, ..) => fractal.recipe().model.signal != Signal::Plain,
                _ => false,
            };
            *counts.entry(*node).or_default() += usize::from(bends);
        }
    }
    let of = |(node, count): (NodeId, usize)| Crease { node, crossed: count as f64 / places as f64 };
    let mut creases: Vec<Crease> = counts.into_iter().map(of).filter(|c| c.crossed >= CROSSED).collect();
    creases.sort_by(|a, b| b.crossed.total_cmp(&a.crossed));
    creases
}

/// Whether an operation is not known to be smooth where its arguments are in these ranges.
fn may_bend(op: &Op, arg: impl Fn(usize) -> Interval) -> bool {
    match op {
        Op::Abs(_) => arg(0).contains(0.0),
        Op::Min(_) | Op::Max(_) => arg(0).hi >= arg(1).lo && arg(1).hi >= arg(0).lo,
        Op::Zigzag(_) => arg(0).lo.floor() != arg(0).hi.floor(),
        _ => false,
    }
}

/// A hint if the scene is less work without a crease.
fn attempt(
    found: &Found<'_>,
    crease: &Crease,
    &Trials { scene, order, watch }: &Trials<'_>,
) -> Result<Option<Hint>, Box<Diagnostic>> {
    let mut graph = Graph::clone(&found.shown.graph);
    let rounded = sibling(found, &mut graph, crease.node).and_then(|sibling| {
        let Some(sibling) = sibling else { return Ok(None) };
        Ok(Some((graph.exchange(found.shown.field, crease.node, sibling.node)?, sibling.remedy)))
    });
    // Where there is no room for it, there is none for whoever would write it.
    let Ok(Some((field, remedy))) = rounded else { return Ok(None) };
    let surface = Surface { field, color: None, material: None, keep: None };
    let bounds = Some(found.shown.settings.bounds);
    let scene = Scene { graph: Arc::new(graph), surface, bounds, moon: None, sea: None, ..scene.clone() };
    let (mut taken, _) = Taken::corrected(&scene, &order.at_once(), watch)?;
    let quiet = Watch { progress: &|_| (), ..*watch };
    let look = sight::look(&mut taken, &quiet).map_err(|_| stopped())?;
    if look.seen.is_empty() {
        return Ok(None);
    }
    let each = |all: u64, look: &Look| all as f64 / look.stats.rays.max(1) as f64;
    let [before, after] = [found.look, &look].map(|look| each(look.stats.evaluations, look));
    let saved = 1.0 - each(look.stats.work, &look) / each(found.look.stats.work, found.look);
    if after > (1.0 - FEWER) * before || saved.is_nan() || saved < LESS {
        return Ok(None);
    }
    let finding = format!(
        "`{}` may bend sharply in {} of the boxes around the surface that were looked at; in a trial of the following a ray took {} less work, and {after:.1} evaluations instead of {before:.1}",
        found.name(crease.node),
        percent(crease.crossed),
        percent(saved),
    );
    Ok(Some(found.hint(crease.node, finding, remedy)))
}

/// What is like a node of a graph, and smooth.
fn sibling(found: &Found<'_>, graph: &mut Graph, node: NodeId) -> Result<Option<Sibling>, TooLarge> {
    let (node, remedy) = match graph.node(node).clone() {
        Node::Op(Op::Abs(_), args) => {
            let width = width(found, args[0], None);
            let square = graph.op(Op::Square(op::Square), &args)?;
            let (room, text) = (graph.constant(width * width)?, short(width * width));
            let sum = graph.op(Op::Add(op::Add), &[square, room])?;
            let root = graph.op(Op::Sqrt(op::Sqrt), &[sum])?;
            (root, format!("`sqrt(square(x) + {text})` in place of `abs(x)` has no crease"))
        }
        Node::Op(op @ (Op::Min(_) | Op::Max(_)), args) => {
            let radius = width(found, args[0], Some(args[1]));
            let is_union = matches!(op, Op::Min(_));
            let name = if is_union { "smooth_union" } else { "smooth_intersection" };
            let remedy = format!("`{name}(a, b, {})` in its place is rounded", short(radius));
            (blended(graph, [args[0], args[1]], is_union, radius)?, remedy)
        }
        Node::Op(Op::Zigzag(_), args) => {
            let half = graph.constant(0.5)?;
            let pi = graph.constant(std::f64::consts::PI)?;
            let angle = graph.op(Op::Mul(op::Mul), &[args[0], pi])?;
            let wave = graph.op(Op::Cos(op::Cos), &[angle])?;
            let wave = graph.op(Op::Mul(op::Mul), &[wave, half])?;
            let wave = graph.op(Op::Sub(op::Sub), &[half, wave])?;
            (wave, "`0.5 - 0.5 * cos(PI * x)` in place of `zigzag(x)` is a wave without creases".to_owned())
        }
        Node::Fractal(fractal, p, footprint, hurst) if found.times.share(node) >= DEAR => {
            let Some([coarse, fine]) = unfolded(fractal.recipe()) else { return Ok(None) };
            let remedy = format!(
                "fold the {FOLDED} coarsest octaves, with `octaves: {FOLDED}`, and add the others as they are: `fractal::fbm(noise, #{{ first: {}, octaves: {} }})` and what other options there are",
                fine.recipe().first,
                fine.recipe().octaves
            );
            let mut sum = |part: Fractal| match hurst {
                None => graph.fractal(Arc::new(part), p, footprint),
                Some(hurst) => graph.rough_fractal(Arc::new(part), p, footprint, hurst),
            };
            let parts = [sum(coarse)?, sum(fine)?];
            (graph.op(Op::Add(op::Add), &parts)?, remedy)
        }
        _ => return Ok(None),
    };
    Ok(Some(Sibling { node, remedy }))
}

/// Folded octaves as a sum of few that are, and the others unfolded; `None` if they are no sum, or few.
fn unfolded(recipe: &Recipe) -> Option<[Fractal; 2]> {
    let Recipe { model: Model { combination: Combination::Sum, .. }, .. } = recipe else { return None };
    let fine = recipe.octaves.checked_sub(FOLDED).filter(|octaves| *octaves > 0)?;
    let coarse = Recipe { octaves: FOLDED, ..recipe.clone() };
    let fine =
        Recipe { model: Model::FBM, first: recipe.first + FOLDED as i32, octaves: fine, ..recipe.clone() };
    Some([Fractal::new(coarse).ok()?, Fractal::new(fine).ok()?])
}

/// The width of a seam of radius 1, as in `stdlib/csg.rhai`: 3 / 16 of it are 1 - sqrt(1 / 2).
const SEAM: f64 = 1.562097167;

/// The smooth union of two fields, or what both share; see `stdlib/csg.rhai`.
fn blended(graph: &mut Graph, [a, b]: [NodeId; 2], is_union: bool, radius: f64) -> Result<NodeId, TooLarge> {
    let melt = Op::Melt(op::Melt::new(op::Ramp::Quartic, SEAM * radius));
    if is_union {
        return graph.op(melt, &[a, b]);
    }
    let [a, b] = [graph.op(Op::Neg(op::Neg), &[a])?, graph.op(Op::Neg(op::Neg), &[b])?];
    let both = graph.op(melt, &[a, b])?;
    graph.op(Op::Neg(op::Neg), &[both])
}

/// Over how much a crease is rounded, to one digit: by how far apart its sides are where the picture looks.
fn width(found: &Found<'_>, a: NodeId, b: Option<NodeId>) -> f64 {
    let tape = &found.shown.tape;
    // Numbers are part of other instructions.
    let number = |node: NodeId| found.shown.graph.as_const(node).unwrap_or(0.0);
    let slot = |node: NodeId| tape.origins().iter().rposition(|origin| *origin == node).map(|i| i as u32);
    let sides = [Some(a), b].map(|side| side.map_or((None, 0.0), |node| (slot(node), number(node))));
    let mut values = Evaluator::<f64>::keeping_all(tape.clone());
    let size = |sight: &Sight| {
        values.eval(&sight.p.to_array());
        let [a, b] = sides.map(|(slot, number)| slot.map_or(number, |slot| *values.value(slot)));
        (a - b).abs()
    };
    let sizes: Vec<f64> = found.places().map(size).collect();
    let finite: Vec<f64> = sizes.into_iter().filter(|size| size.is_finite()).collect();
    let mean = finite.iter().sum::<f64>() / finite.len().max(1) as f64;
    let digit = libm::pow(10.0, libm::floor(libm::log10((ROUNDED * mean).max(1e-9))));
    (ROUNDED * mean / digit).round().max(1.0) * digit
}

/// A number with as few digits as say it.
fn short(number: f64) -> String {
    let digits = (1.0 - libm::floor(libm::log10(number))).clamp(0.0, 12.0) as usize;
    let text = format!("{number:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
