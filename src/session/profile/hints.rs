//! What to do about what a script costs. Each hint is made of something that was measured, and says what.

use super::Profile;
use super::bound::{REACH, Slopes};
use super::cost::{Times, name, pieces};
use super::sight::{Look, Sight};
use crate::expr::{Graph, Node, NodeId};
use crate::field::Terms;
use crate::noise::{Fractal, Kind, Noise, Recipe};
use crate::render::Prepared;
use crate::session::ledger::{Ledger, Line};
use crate::tape::{self, Cells, Instr, Tape};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Something that could be better.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Hint {
    /// The line that it is about.
    #[serde(flatten)]
    pub line: Line,
    /// What was found.
    pub finding: String,
    /// What to do about it.
    pub remedy: String,
}

/// What hints follow from.
#[derive(Clone, Copy)]
pub(super) struct Found<'a> {
    pub shown: &'a Prepared,
    /// Those that keep values.
    pub cells: &'a Cells,
    pub look: &'a Look,
    pub ledger: &'a Ledger,
    pub times: &'a Times,
    pub slopes: &'a Slopes,
    /// All but the hints.
    pub profile: &'a Profile,
}

/// Share of the time from which on something is worth a hint.
pub(super) const DEAR: f64 = 0.1;

/// Share of the time that is worth saving.
pub(super) const WORTH: f64 = 0.02;

/// Share of the bound, and how loose it must be.
const STEEP: f64 = 0.25;
const LOOSE: f64 = 4.0;

/// How many times as long as gradient noise a noise must take.
const SLOW: f64 = 2.0;

/// Places where footprints and definedness are looked at.
const PLACES: usize = 240;

/// Hints that follow from what is known, in the order of how much they matter.
pub(super) fn of(found: &Found<'_>) -> Vec<Hint> {
    let mut hints = undefined(found);
    hints.extend(boundless(found));
    hints.extend(fine_octaves(found));
    hints.extend(dear_colors(found));
    hints.extend(slow_noises(found));
    hints.extend(octaves(found));
    hints.extend(loose(found));
    hints
}

impl<'a> Found<'a> {
    pub(super) fn hint(&self, node: NodeId, finding: String, remedy: String) -> Hint {
        Hint { line: self.ledger.line(node), finding, remedy }
    }

    pub(super) fn name(&self, node: NodeId) -> String {
        name(self.shown.graph.node(node))
    }

    /// Whether what an expression does is carry something along.
    fn is_flow(&self, node: NodeId) -> bool {
        matches!(self.shown.graph.node(node), Node::Flow(..))
    }

    pub(super) fn places(&self) -> impl Iterator<Item = &Sight> {
        self.look.seen.iter().step_by(self.look.seen.len().div_ceil(PLACES).max(1))
    }

    /// Seconds for a batch of a noise, or of octaves of one, at the point itself.
    fn seconds(&self, make: impl FnOnce(&mut Graph, [NodeId; 3]) -> Option<NodeId>) -> Option<f64> {
        let mut graph = Graph::default();
        let p = graph.point().ok()?;
        let root = make(&mut graph, p)?;
        let tape = Arc::new(Tape::new(&graph, &[root]));
        let taken = tape::seconds(&tape, &pieces(&self.look.seen));
        taken.get(tape.output(0) as usize).copied()
    }

    /// The same of so many octaves.
    fn seconds_of(&self, recipe: &Recipe, octaves: u32) -> Option<f64> {
        let fractal = Fractal::new(Recipe { octaves, ..recipe.clone() }).ok()?;
        self.seconds(|graph, p| {
            let none = graph.constant(0.0).ok()?;
            graph.fractal(Arc::new(fractal), p, none).ok()
        })
    }

    /// The sums of octaves in the field, each with whether pixels limit it, and how many octaves are coarser than pixels
    /// wherever the picture looks at it.
    fn fractals(&self) -> Vec<(NodeId, &'a Fractal, bool, u32)> {
        let tape: &'a Tape = &self.shown.tape;
        let terms = Terms::new(self.shown.tape.clone());
        let slopes: Vec<(f64, Vec<f64>)> =
            self.places().map(|sight| (sight.footprint, terms.slopes_at(sight.p.to_array()))).collect();
        let of = |(slot, instr): (usize, &'a Instr)| match instr {
            Instr::Fractal(fractal, p, [footprint, None]) => {
                let seen = slopes.iter().map(|(footprint, slopes): &(f64, Vec<f64>)| {
                    let stretch = p.iter().map(|a| slopes[*a as usize]).fold(0.0, f64::max);
                    fractal.octaves_within(footprint * stretch)
                });
                let node: NodeId = terms.node(slot as u32);
                Some((node, &**fractal, footprint.is_some(), seen.max().unwrap_or(0)))
            }
            _ => None,
        };
        tape.code().iter().enumerate().filter_map(of).collect()
    }
}

/// Octaves that no pixel can show.
fn fine_octaves(found: &Found<'_>) -> Vec<Hint> {
    let of = |(node, fractal, limited, seen): (NodeId, &Fractal, bool, u32)| {
        let (recipe, share) = (fractal.recipe(), found.times.share(node));
        if limited || seen >= recipe.octaves || share == 0.0 {
            return None;
        }
        let left = if seen == 0 { 0.0 } else { found.seconds_of(recipe, seen)? };
        let saved = percent(share * (1.0 - left / found.seconds_of(recipe, recipe.octaves)?).max(0.0));
        let finding = format!(
            "of {} octaves {seen} are coarser than a pixel anywhere in this picture; the others, {saved} of an evaluation, are noise that pixels cannot show",
            recipe.octaves
        );
        let remedy = "leave `detail: false` out, and octaves fade as they get finer than pixels".to_owned();
        Some(found.hint(node, finding, remedy))
    };
    found.fractals().into_iter().filter_map(of).collect()
}

/// What an octave costs.
fn octaves(found: &Found<'_>) -> Vec<Hint> {
    let of = |(node, fractal, limited, seen): (NodeId, &Fractal, bool, u32)| {
        let (recipe, share) = (fractal.recipe(), found.times.share(node));
        let shown = if limited { seen.min(recipe.octaves) } else { recipe.octaves };
        if share < DEAR || shown < 4 {
            return None;
        }
        let saved = share * (1.0 - found.seconds_of(recipe, shown - 1)? / found.seconds_of(recipe, shown)?);
        if saved < WORTH {
            return None;
        }
        let finding = format!(
            "the finest of the {shown} octaves that show takes about {} of an evaluation",
            percent(saved)
        );
        let remedy = format!("`octaves: {}` would do without it", shown - 1);
        Some(found.hint(node, finding, remedy))
    };
    found.fractals().into_iter().filter_map(of).collect()
}

/// Colours that take longer than it takes to find the surface that has them.
fn dear_colors(found: &Found<'_>) -> Option<Hint> {
    let Profile { rays, hits, evaluations, solid, shading, .. } = found.profile;
    let shading = shading.as_ref()?;
    let finding = *rays as f64 * evaluations * solid.nanoseconds;
    let coloring = *hits as f64 * shading.nanoseconds;
    if coloring < finding {
        return None;
    }
    let finding = format!(
        "colours and material take {:.1} times as long as the rays to the eye do to find the surface; this line has the largest share of that, {}",
        coloring / finding,
        percent(shading.lines.first()?.share)
    );
    let remedy = "the code of colours is the same everywhere: color few large parts rather than many small ones, or by place, altitude or noise";
    Some(Hint { line: shading.lines.first()?.line.clone(), finding, remedy: remedy.to_owned() })
}

/// Noises that take much longer than gradient noise.
fn slow_noises(found: &Found<'_>) -> Vec<Hint> {
    let (graph, gradient) = (&found.shown.graph, Kind::ALL[0].plain());
    let like = |noise: &Noise| Noise { kind: gradient, ..*noise };
    let of = |node: &NodeId| {
        let share = found.times.share(*node);
        let (own, other) = match graph.node(*node) {
            _ if share < DEAR => return None,
            Node::Noise(noise, _) => (
                found.seconds(|graph, p| graph.noise(*noise, p).ok())?,
                found.seconds(|graph, p| graph.noise(like(noise), p).ok())?,
            ),
            Node::Fractal(fractal, _, _, None) => {
                let recipe = fractal.recipe();
                let other = Recipe { noise: like(&recipe.noise), ..recipe.clone() };
                (found.seconds_of(recipe, recipe.octaves)?, found.seconds_of(&other, recipe.octaves)?)
            }
            _ => return None,
        };
        if own < SLOW * other {
            return None;
        }
        let finding = format!(
            "{} takes {} of an evaluation, {:.1} times what gradient noise would take here",
            found.name(*node),
            percent(share),
            own / other
        );
        Some(found.hint(*node, finding, "try gradient noise in its place, or fewer octaves".to_owned()))
    };
    graph.reachable(&[found.shown.field]).iter().filter_map(of).collect()
}

/// Parts that may have no value.
fn undefined(found: &Found<'_>) -> Vec<Hint> {
    let (mut nodes, mut places) = (BTreeMap::<NodeId, usize>::new(), 0);
    for sight in found.places() {
        places += 1;
        let tape = found.cells.tape_around(sight.p.to_array(), REACH * sight.footprint);
        if let Some(slot) = tape.first_undefined(&sight.region(REACH)) {
            *nodes.entry(tape.origins()[slot as usize]).or_default() += 1;
        }
    }
    let of = |(node, count): (NodeId, usize)| {
        let finding = format!(
            "`{}` is not known to have a value everywhere in {} of the boxes around the surface that were looked at; of {} rays {} are not certified",
            found.name(node),
            percent(count as f64 / places as f64),
            found.look.stats.rays,
            found.look.stats.uncertified
        );
        let remedy = if found.is_flow(node) {
            "weaker flows, or several one after the other, are known to have one; `--caster bent` finds what they show without proof"
        } else {
            "keep its argument where it has a value, as `sqrt(max(x, 0.0))` and `a / max(b, 0.01)` do"
        };
        found.hint(node, finding, remedy.to_owned())
    };
    nodes.into_iter().map(of).collect()
}

/// Parts whose slope has no bound.
fn boundless(found: &Found<'_>) -> Vec<Hint> {
    let terms = found.slopes.terms.iter().filter(|(_, term)| term.boundless > 0);
    let of = |(node, term): (&NodeId, &super::bound::TermSlopes)| {
        let finding = format!(
            "the slope of `{}` has no bound in {} of the boxes around the surface that were looked at, so that casters that step by slopes make no certain step over them",
            found.name(*node),
            percent(term.boundless as f64 / found.slopes.boxes as f64)
        );
        let remedy = if found.is_flow(*node) {
            "weaker flows have a bound; `--caster bent` finds what these show without proof"
        } else {
            "keep its argument away from where it is vertical or jumps, as `sqrt(x + 1e-4)` and `smoothstep` do"
        };
        found.hint(*node, finding, remedy.to_owned())
    };
    terms.map(of).collect()
}

/// Lines whose bound is far above the slopes that there are.
fn loose(found: &Found<'_>) -> Vec<Hint> {
    let lines =
        found.profile.bound.lines.iter().filter(|line| line.share >= STEEP && line.looseness >= LOOSE);
    let of = |line: &super::LineBound| Hint {
        line: line.line.clone(),
        finding: format!(
            "its bound is {:.1} times its steepest sample, and {} of the bound of the field: steps that are certain are that much shorter than they need be",
            line.looseness,
            percent(line.share)
        ),
        remedy: "a smaller amplitude or less detail lowers it".to_owned(),
    };
    lines.map(of).collect()
}

pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 0.95 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}
