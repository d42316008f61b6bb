//! Which components are kept.
//!
//! That is decided by intervals: of volumes, or of numbers of minima, which are exact. Where they overlap a choice is
//! made, and its ruling is no proof.

use super::{Analysis, Part};
use crate::cast::Ruling;
use crate::diag::Diagnostic;
use crate::num::Interval;
use crate::scene::{Aabb, Keep, Measure, Scene};
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use std::sync::Arc;

/// That it is not proven which components are kept.
pub fn unproven(analysis: &Analysis, kept: &[Ruling]) -> Option<Diagnostic> {
    let sure = kept.iter().filter(|ruling| ruling.proven).count();
    let warning = if !analysis.is_certified() {
        "it is not proven what the solid is connected with, and so not what of it is kept"
    } else if analysis.parts.iter().any(|part| part.cut) && sure < kept.len() {
        "the solid may go on beyond the bounds, where what is left out may be joined with what is kept"
    } else if !analysis.is_whole && sure < kept.len() {
        "it is not proven that nothing of the solid is beyond the bounds, which may be larger than what is kept"
    } else if sure < kept.len() {
        "what is known of the sizes of components does not prove which are to be kept"
    } else {
        return None;
    };
    let warning = Diagnostic::warning(warning).at(analysis.place.clone());
    Some(
        warning
            .hint("orogen topology says what is not decided; rays that it matters to count as uncertified"),
    )
}

/// Which components are kept, and whether that is proven.
///
/// # Errors
/// Where no component holds the point that one should.
pub fn kept(analysis: &Analysis, keep: &Keep) -> Result<Vec<Ruling>, Box<Diagnostic>> {
    match *keep {
        // Of a solid that is known as a whole, features of whatever size are.
        Keep::Holding(core) | Keep::Near { core, .. } => holding(analysis, core),
        Keep::Most(measure) => Ok(most(analysis, measure)),
        Keep::Share(share) => Ok(large(analysis, share)),
    }
}

/// Another component is worth a warning from this share of the largest on.
const RIVAL: f64 = 0.5;

/// Whether a part is a component of its own, of which all is in sight.
fn is_whole(part: &Part) -> bool {
    part.certified && !part.cut
}

/// Keeps the component that holds a point.
fn holding(analysis: &Analysis, core: DVec3) -> Result<Vec<Ruling>, Box<Diagnostic>> {
    let holder = holder(analysis, core)?;
    let ruling = |(i, part): (usize, &Part)| {
        let kept = i == holder;
        Ruling { kept, proven: kept || is_whole(part) }
    };
    Ok(analysis.parts.iter().enumerate().map(ruling).collect())
}

/// Keeps the largest component: of those that are as large, the one of largest volume.
fn most(analysis: &Analysis, measure: Measure) -> Vec<Ruling> {
    let (sizes, parts) = (sizes(analysis, measure), &analysis.parts);
    let main = largest(&sizes, parts);
    let least = main.map_or(0.0, |main| sizes[main].lo);
    let is_less = |i: usize| {
        let is_tied = sizes[i].lo == least && sizes[i].hi == least;
        if is_tied {
            main.is_some_and(|main| parts[i].volume.hi <= parts[main].volume.lo)
        } else {
            sizes[i].hi <= least
        }
    };
    let is_most = unlisted(analysis) <= least && (0..parts.len()).all(|i| Some(i) == main || is_less(i));
    let ruling = |(i, part): (usize, &Part)| {
        let kept = Some(i) == main;
        Ruling { kept, proven: is_whole(part) && if kept { is_most } else { is_less(i) } }
    };
    parts.iter().enumerate().map(ruling).collect()
}

/// That another component is nearly as large as the one that is kept, so that another one may have been meant.
pub fn rivalled(analysis: &Analysis, keep: &Keep) -> Option<Diagnostic> {
    let Keep::Most(measure) = *keep else { return None };
    let sizes = sizes(analysis, measure);
    let main = largest(&sizes, &analysis.parts)?;
    let others = sizes.iter().enumerate().filter(|(i, _)| *i != main).map(|(_, size)| size.lo);
    let next = others.fold(0.0, f64::max);
    let share = next / sizes[main].hi;
    let what = if measure == Measure::Minima { "minima" } else { "volume" };
    (share > RIVAL).then(|| {
        let percent = libm::floor(100.0 * share);
        let warning = format!("by {what}, another component is {percent} % as large as the one that is kept, or more");
        let hint = "component_of(f, p) keeps the one that holds a point, largest_component(f, \"volume\") the one of \
                    largest volume";
        Diagnostic::warning(warning).at(analysis.place.clone()).hint(hint)
    })
}

/// Keeps the components that are at least such a share of the largest.
fn large(analysis: &Analysis, share: f64) -> Vec<Ruling> {
    let sizes = sizes(analysis, Measure::Minima);
    let least = largest(&sizes, &analysis.parts).map_or(0.0, |main| sizes[main].lo);
    let most = sizes.iter().map(|size| size.hi).fold(unlisted(analysis), f64::max);
    let ruling = |(size, part): (&Interval, &Part)| {
        let kept = size.lo >= share * least;
        let proven = if kept { size.lo >= share * most } else { size.hi < share * least };
        Ruling { kept, proven: is_whole(part) && proven }
    };
    sizes.iter().zip(&analysis.parts).map(ruling).collect()
}

/// How large what is in no list may be: all that is not decided, and whatever is beyond the bounds. Parts that end there
/// may be one beyond them, which would be larger than any of them.
fn unlisted(analysis: &Analysis) -> f64 {
    if !analysis.is_whole || analysis.parts.iter().any(|part| part.cut) {
        f64::INFINITY
    } else if analysis.is_certified() {
        0.0
    } else {
        analysis.flood.undecided_volume
    }
}

/// The sizes of components.
fn sizes(analysis: &Analysis, measure: Measure) -> Vec<Interval> {
    let by_minima = measure == Measure::Minima;
    let size = |part: &Part| match &part.critical {
        Some(component) if by_minima => Interval::point(component.counts[0] as f64),
        _ => part.volume,
    };
    analysis.parts.iter().map(size).collect()
}

/// Which size is greatest as far as is certain: by its lower bound. Of equal ones, that of the part of largest volume; of
/// such, the first, which is that of the deepest.
fn largest(sizes: &[Interval], parts: &[Part]) -> Option<usize> {
    let key = |i: usize| (sizes[i].lo, parts[i].volume.lo);
    (0..sizes.len()).reduce(|most, i| if key(i) > key(most) { i } else { most })
}

/// Whether the point that what a scene keeps is to hold is certain to be inside of its solid: that is soon known, and what
/// the solid is connected with takes long. It is said of the point that was `asked` for, wherever it was before a flow.
///
/// # Errors
/// Where it is not.
pub fn check_point(scene: &Scene, keep: &Keep, asked: &Keep) -> Result<(), Box<Diagnostic>> {
    let (Keep::Holding(p), Keep::Holding(asked)) = (*keep, *asked) else { return Ok(()) };
    let root = scene.surface.field;
    is_inside(&Tape::new(&scene.graph, &[root]).into(), p)
        .map_err(|value| Box::new(outside(asked, value).at(scene.graph.place(root).cloned())))
}

/// Whether a point is certain to be inside; else what the field is there.
fn is_inside(tape: &Arc<Tape>, p: DVec3) -> Result<(), Interval> {
    let at = p.to_array().map(Interval::point);
    let value = *Evaluator::<Interval>::new(tape.clone()).eval(&at);
    let is_inside = value.hi < 0.0 && value.lo <= value.hi && tape.is_defined(&at);
    if is_inside { Ok(()) } else { Err(value) }
}

/// The component that holds a point.
fn holder(analysis: &Analysis, p: DVec3) -> Result<usize, Box<Diagnostic>> {
    is_inside(&analysis.tape, p).map_err(|value| Box::new(outside(p, value).at(analysis.place.clone())))?;
    analysis.labels.clone().components(&[p])[0].ok_or_else(|| {
        let is_beyond = !analysis.region.holds(&Aabb { min: p, max: p });
        let (error, hint) = if is_beyond {
            ("is inside of the solid, but beyond the bounds", "give the scene bounds that hold it")
        } else {
            (
                "is inside of the solid, but it is not known which component it belongs to",
                "choose a point farther from the surface; orogen topology says what is not decided",
            )
        };
        Box::new(Diagnostic::error(format!("{} {error}", point(p))).at(analysis.place.clone()).hint(hint))
    })
}

/// Why there is no component that holds a point where the field has this value.
pub(super) fn outside(p: DVec3, value: Interval) -> Diagnostic {
    let about = if value.mid().is_nan() { "undefined".to_owned() } else { format!("{:.6}", value.mid()) };
    let error = format!("{}, the point of component_of, is not certain to be inside of the solid", point(p));
    Diagnostic::error(error).hint(format!("the field must be negative there; f.at(p) is {about}"))
}

/// A point as scripts have it.
fn point(p: DVec3) -> String {
    format!("[{}, {}, {}]", p.x, p.y, p.z)
}
