//! The judge of a caster that passes by what is not kept.
//!
//! Most points that rays come to lie in cells of which a flood ([`flood`]) has proven what they belong to, which
//! takes no evaluation to know. Of others a path downhill tells, where all is proven of the critical points.
//!
//! Which components are kept is decided by intervals: of volumes, or of numbers of minima, which are exact. Where they
//! overlap the judge chooses, and its ruling is no proof.

use super::carried::{self, Carried};
use super::local::{Joined, doubts, local};
use super::store::Key;
use super::{Analysis, Part, Purpose, analyse};
use crate::cast::{Judge, Ruling};
use crate::diag::Diagnostic;
use crate::field::{Field, Watch};
use crate::num::Interval;
use crate::scene::{Keep, Measure, Scene};
use crate::session::stage;
use crate::tape::Evaluator;
use crate::topology::Locator;
use crate::topology::flood::{self, Label};
use crate::topology::local::{Local, Seeker};
use glam::DVec3;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

/// Says which component a point of a solid belongs to, by number in the report.
#[derive(Debug)]
pub struct Labels {
    flood: Arc<flood::Components>,
    /// What the flood's components are in the report.
    names: Arc<[Option<usize>]>,
    /// Without it the flood's components are those of the report.
    locator: Option<Locator>,
}

impl Labels {
    /// For the components of an analysis.
    pub fn new(analysis: &Analysis) -> Labels {
        Labels {
            flood: analysis.flood.clone(),
            names: analysis.names.clone(),
            locator: analysis.proven().map(|complex| Locator::new(&analysis.tape, complex)),
        }
    }

    /// The same with memory of its own, for another thread.
    pub fn again(&self) -> Labels {
        let locator = self.locator.as_ref().map(Locator::again);
        Labels { flood: self.flood.clone(), names: self.names.clone(), locator }
    }

    /// The components of points; none where that is not known.
    pub fn components(&mut self, points: &[DVec3]) -> Vec<Option<usize>> {
        let Labels { flood, names, locator } = self;
        let known = |p: DVec3| match flood.label(p) {
            Label::Component(c) => names[c],
            Label::Outside | Label::Undecided => None,
        };
        match locator {
            Some(locator) => locator.components(points, known),
            None => points.iter().map(|p| known(*p)).collect(),
        }
    }
}

/// Keeps points of some components.
#[derive(Debug)]
pub(super) struct Components {
    labels: Labels,
    kept: Arc<[Ruling]>,
}

impl Components {
    pub fn new(analysis: &Analysis, kept: Arc<[Ruling]>) -> Components {
        Components { labels: Labels::new(analysis), kept }
    }
}

impl Judge for Components {
    /// A point of which it is not known what it belongs to is kept: better a crumb too many than a hole.
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], _: &AtomicBool) {
        for (ruling, component) in rulings.iter_mut().zip(self.labels.components(points)) {
            *ruling = component.map_or(Ruling { kept: true, proven: false }, |c| self.kept[c]);
        }
    }

    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(Components { labels: self.labels.again(), kept: self.kept.clone() })
    }
}

/// What a picture needs to show what a scene keeps of its solid.
pub struct Correction {
    /// Says what that is.
    pub judge: Box<dyn Judge>,
    /// What is not proven about it.
    warnings: Vec<Diagnostic>,
    /// What is found out as rays ask, about which more is known afterwards.
    local: Option<Arc<Local>>,
}

impl Correction {
    /// What is not proven about the pictures that were made with it.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let found = self.local.as_ref().map(|local| doubts(&local.stats()));
        self.warnings.iter().cloned().chain(found.into_iter().flatten()).collect()
    }
}

/// A correction that keeps what a scene says, from an analysis of its solid.
///
/// # Errors
/// As for [`analyse`], and where no component holds the point that one should.
pub fn correction(
    scene: &Scene,
    keep: &Keep,
    threads: Option<NonZeroUsize>,
    watch: &Watch<'_>,
) -> Result<Correction, Box<Diagnostic>> {
    if let Some((rest, keep, flowed)) = carried::before(scene, keep) {
        let Correction { judge, warnings, local } = correction(&rest, &keep, threads, watch)?;
        return Ok(Correction { judge: Box::new(Carried { judge, flowed }), warnings, local });
    }
    if let Keep::Near { core, feature } = *keep {
        let local = local(scene, core, feature)?;
        let judge = Box::new(Joined(Seeker::new(local.clone())));
        return Ok(Correction { judge, warnings: Vec::new(), local: Some(local) });
    }
    let purpose = Purpose { fresh: false, volumes: *keep == Keep::Most(Measure::Volume) };
    let analysis = stage::on_threads(threads, || known(scene, purpose, watch))??;
    let kept = kept(&analysis, keep)?;
    let warnings = unproven(&analysis, &kept).into_iter().collect();
    let judge = Box::new(Components::new(&analysis, kept.into()));
    Ok(Correction { judge, warnings, local: None })
}

/// The analysis that was made last, and what of.
static LAST: Mutex<Option<(Key, bool, Analysis)>> = Mutex::new(None);

/// An analysis, remembered from picture to picture: quick ones and the full one share it.
fn known(scene: &Scene, purpose: Purpose, watch: &Watch<'_>) -> Result<Analysis, Box<Diagnostic>> {
    let (graph, root) = (&scene.graph, scene.surface.field);
    let key = Key::new(graph, root, &stage::region(scene, &mut Field::new(graph, root)));
    let last = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((of, volumes, analysis)) = &*last()
        && *of == key
        && *volumes >= purpose.volumes
    {
        return Ok(Analysis { place: graph.place(root).cloned(), ..analysis.clone() });
    }
    let analysis = analyse(scene, purpose, watch)?;
    *last() = Some((key, purpose.volumes, analysis.clone()));
    Ok(analysis)
}

/// That it is not proven which components are kept.
pub fn unproven(analysis: &Analysis, kept: &[Ruling]) -> Option<Diagnostic> {
    let sure = kept.iter().filter(|ruling| ruling.proven).count();
    let warning = if !analysis.is_certified() {
        "it is not proven what the solid is connected with, and so not what of it is kept"
    } else if analysis.parts.iter().any(|part| part.cut) && sure < kept.len() {
        "the solid may go on beyond the bounds, where what is left out may be joined with what is kept"
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
    let sizes = sizes(analysis, keep);
    let main = largest(&sizes);
    let unlisted = unlisted(analysis);
    let most = sizes.iter().map(|size| size.hi).fold(unlisted, f64::max);
    let least = main.map_or(0.0, |main| sizes[main].lo);
    let holder = match *keep {
        Keep::Holding(core) | Keep::Near { core, .. } => Some(holder(analysis, core)?),
        Keep::Most(_) | Keep::Share(_) => None,
    };
    let ruling = |(i, size): (usize, &Interval)| {
        // A component of its own, of which all is in sight.
        let whole = analysis.parts[i].certified && !analysis.parts[i].cut;
        match *keep {
            Keep::Most(_) if Some(i) == main => {
                let others = sizes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other.hi);
                Ruling { kept: true, proven: whole && others.fold(unlisted, f64::max) <= size.lo }
            }
            Keep::Most(_) => Ruling { kept: false, proven: whole && size.hi <= least },
            Keep::Share(share) => {
                let kept = size.lo >= share * least;
                let proven = if kept { size.lo >= share * most } else { size.hi < share * least };
                Ruling { kept, proven: whole && proven }
            }
            Keep::Holding(_) | Keep::Near { .. } => {
                let kept = Some(i) == holder;
                Ruling { kept, proven: kept || whole }
            }
        }
    };
    Ok(sizes.iter().enumerate().map(ruling).collect())
}

/// How large what is in no list may be: all that is not decided. Parts that end at the bounds may be one beyond them,
/// which would be larger than any of them.
fn unlisted(analysis: &Analysis) -> f64 {
    if analysis.parts.iter().any(|part| part.cut) {
        f64::INFINITY
    } else if analysis.is_certified() {
        0.0
    } else {
        analysis.flood.undecided_volume
    }
}

/// The sizes of components.
fn sizes(analysis: &Analysis, keep: &Keep) -> Vec<Interval> {
    let by_minima = *keep != Keep::Most(Measure::Volume);
    let size = |part: &Part| match &part.critical {
        Some(component) if by_minima => Interval::point(component.counts[0] as f64),
        _ => part.volume,
    };
    analysis.parts.iter().map(size).collect()
}

/// Which size is certain to be largest; of equal ones the first, which is that of the deepest.
fn largest(sizes: &[Interval]) -> Option<usize> {
    let most = sizes.iter().map(|size| size.lo).fold(0.0, f64::max);
    sizes.iter().position(|size| size.lo == most)
}

/// The component that holds a point.
fn holder(analysis: &Analysis, p: DVec3) -> Result<usize, Box<Diagnostic>> {
    let at = p.to_array().map(Interval::point);
    let value = *Evaluator::<Interval>::new(analysis.tape.clone()).eval(&at);
    if !(value.hi < 0.0 && value.lo <= value.hi && analysis.tape.is_defined(&at)) {
        return Err(Box::new(outside(p, value).at(analysis.place.clone())));
    }
    Labels::new(analysis).components(&[p])[0].ok_or_else(|| {
        let error =
            format!("{} is inside of the solid, but it is not known which component it belongs to", point(p));
        let hint = "choose a point farther from the surface; orogen topology says what is not decided";
        Box::new(Diagnostic::error(error).at(analysis.place.clone()).hint(hint))
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
