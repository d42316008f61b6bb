//! Functions that are computed twice though they come to the same.
//!
//! What is written twice is one node of the graph, and computed once. But points that differ in a rounding error, or were
//! moved and moved back, are different points to the graph, so that a noise there is another node. Such are found by
//! what they come to: the same values wherever the picture looks, and around there.

use super::bound::{CORNERS, REACH};
use super::hints::{Found, Hint, WORTH, percent};
use crate::expr::{Node, NodeId};
use crate::session::ledger::Line;
use crate::tape::{Evaluator, Instr};
use glam::DVec3;

/// Values that differ by less, as a share of how much they vary, are the same to whoever looks.
const SAME: f64 = 1e-6;

/// Something dear, with its values at the same points as those of others.
struct Column {
    node: NodeId,
    values: Vec<f64>,
    /// How much they vary.
    spread: f64,
}

impl Column {
    fn is_like(&self, other: &Column) -> bool {
        let off = self.values.iter().zip(&other.values).map(|(a, b)| (a - b).abs());
        off.fold(0.0, f64::max) <= SAME * self.spread
    }
}

/// What has the same values as something before it.
pub(super) fn of(found: &Found<'_>) -> Vec<Hint> {
    let columns = columns(found);
    let like = |(i, column): (usize, &Column)| {
        let first = columns[..i].iter().find(|before| before.is_like(column))?;
        let (here, there) = (site(found, column.node), site(found, first.node));
        let finding = format!(
            "`{}` has the same values as that of line {} at all {} points that were looked at, and takes {} of an evaluation to be computed again",
            found.name(column.node),
            there.line,
            column.values.len(),
            percent(found.times.share(column.node)),
        );
        let remedy = "write it once, as `let n = ...`, and use `n` in both places: points that differ in a rounding error count as others";
        Some(Hint { line: here, finding, remedy: remedy.to_owned() })
    };
    columns.iter().enumerate().filter_map(like).collect()
}

/// The line that made the point at which a function is asked for, which is what tells two of them apart.
fn site(found: &Found<'_>, node: NodeId) -> Line {
    let graph = &found.shown.graph;
    let is_made = |arg: &NodeId| !matches!(graph.node(*arg), Node::Input(_) | Node::Const(_));
    let made = graph.node(node).args().into_iter().find(is_made).map(|arg| found.ledger.line(arg));
    made.filter(|line| line.line > 0).unwrap_or_else(|| found.ledger.line(node))
}

/// The values of what takes its time.
fn columns(found: &Found<'_>) -> Vec<Column> {
    let tape = &found.shown.tape;
    let is_dear = |(instr, node): (&Instr, &NodeId)| {
        let is_function = matches!(
            instr,
            Instr::Noise(..) | Instr::Fractal(..) | Instr::Grid(..) | Instr::Shape(..) | Instr::Flow(..)
        );
        is_function && found.times.share(*node) >= WORTH
    };
    let instructions = tape.code().iter().zip(tape.origins()).enumerate();
    let dear: Vec<(usize, NodeId)> =
        instructions.filter(|(_, both)| is_dear(*both)).map(|(slot, (_, node))| (slot, *node)).collect();
    if dear.len() < 2 {
        return Vec::new();
    }
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut evaluator = Evaluator::<f64>::keeping_all(tape.clone());
    for sight in found.places() {
        // Beside the surface, too: on one plane functions may agree that do not elsewhere.
        for corner in [[0.0; 3]].iter().chain(&CORNERS) {
            let p = sight.p + REACH * sight.footprint * DVec3::from_array(*corner);
            evaluator.eval(&p.to_array());
            rows.push(dear.iter().map(|(slot, _)| *evaluator.value(*slot as u32)).collect());
        }
    }
    let column = |(i, (_, node)): (usize, &(usize, NodeId))| {
        let values: Vec<f64> = rows.iter().map(|row| row[i]).collect();
        let (least, most) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
        Column { node: *node, values, spread: most - least }
    };
    let varies = |column: &Column| column.spread > 0.0 && column.spread.is_finite();
    dear.iter().enumerate().map(column).filter(varies).collect()
}
