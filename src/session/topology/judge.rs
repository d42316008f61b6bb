//! The judge of a caster that passes by what is not kept.
//!
//! Most points that rays come to lie in cells of which a flood ([`flood`]) has proven what they belong to, which
//! takes no evaluation to know. Of others a path downhill tells, if the field is smooth. Components of the
//! flood and of the complex have different numbers: a point of each of the former is followed down to learn which of
//! the latter it is.

use super::local::{Joined, local};
use super::{Analysis, Parts, analyse};
use crate::cast::Judge;
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::scene::{Keep, Measure, Scene};
use crate::session::stage;
use crate::topology::flood::{self, Label};
use crate::topology::local::Seeker;
use crate::topology::{Complex, Locator};
use glam::DVec3;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// Says which component a point of a solid belongs to, by number in the report.
#[derive(Debug)]
pub struct Labels {
    flood: Arc<flood::Components>,
    /// What the flood's components are in the report.
    pub(super) names: Arc<[Option<usize>]>,
    /// Without it the flood's components are those of the report.
    locator: Option<Locator>,
}

impl Labels {
    /// For the components of an analysis.
    pub fn new(analysis: &Analysis) -> Labels {
        let flood = analysis.flood.clone();
        let mut locator = match &analysis.parts {
            Parts::Complex(complex) => Some(Locator::new(&analysis.tape, complex)),
            Parts::Flood => None,
        };
        let inside: Vec<DVec3> = flood.list.iter().map(|c| c.inside).collect();
        let names = match &mut locator {
            Some(locator) => locator.components(&inside, |_| None),
            None => (0..inside.len()).map(Some).collect(),
        };
        Labels { flood, names: names.into(), locator }
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
    kept: Arc<[bool]>,
}

impl Judge for Components {
    /// A point of which it is not known what it belongs to is kept: better a crumb too many than a hole.
    fn judge(&mut self, points: &[DVec3], kept: &mut [bool]) {
        for (kept, component) in kept.iter_mut().zip(self.labels.components(points)) {
            *kept = component.is_none_or(|c| self.kept[c]);
        }
    }

    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(Components { labels: self.labels.again(), kept: self.kept.clone() })
    }
}

/// A judge that keeps what a scene says, from an analysis of its solid.
///
/// # Errors
/// As for [`analyse`], and where no component holds the point that one should.
pub fn judge(
    scene: &Scene,
    keep: &Keep,
    threads: Option<NonZeroUsize>,
    watch: &Watch<'_>,
) -> Result<Box<dyn Judge>, Box<Diagnostic>> {
    if let Keep::Near { core, feature } = *keep {
        return Ok(Box::new(Joined(Seeker::new(local(scene, core, feature)?))));
    }
    let analysis = stage::on_threads(threads, || analyse(scene, false, watch))??;
    Ok(Box::new(Components::new(&analysis, keep)?))
}

impl Components {
    pub fn new(analysis: &Analysis, keep: &Keep) -> Result<Components, Box<Diagnostic>> {
        Ok(Components { labels: Labels::new(analysis), kept: kept(analysis, keep)?.into() })
    }
}

/// Which components are kept.
///
/// # Errors
/// Where no component holds the point that one should.
pub fn kept(analysis: &Analysis, keep: &Keep) -> Result<Vec<bool>, Box<Diagnostic>> {
    let measure = if let Keep::Most(measure) = keep { *measure } else { Measure::Minima };
    let sizes = measured(analysis, measure);
    let most = sizes.iter().copied().fold(0.0, f64::max);
    // Of equal ones the first, which is the deepest.
    let main = sizes.iter().position(|size| *size == most);
    let holder = match keep {
        Keep::Holding(core) | Keep::Near { core, .. } => Some(holder(analysis, *core)?),
        Keep::Most(_) | Keep::Share(_) => None,
    };
    let is_kept = |(i, size): (usize, &f64)| match keep {
        Keep::Most(_) => Some(i) == main,
        Keep::Share(share) => *size >= share * most,
        Keep::Holding(_) | Keep::Near { .. } => Some(i) == holder,
    };
    Ok(sizes.iter().enumerate().map(is_kept).collect())
}

/// The sizes of components.
fn measured(analysis: &Analysis, measure: Measure) -> Vec<f64> {
    match (&analysis.parts, measure) {
        (Parts::Complex(complex), Measure::Minima) => {
            complex.components.iter().map(|c| c.counts[0] as f64).collect()
        }
        _ => analysis.sizes().iter().map(|size| size.volume).collect(),
    }
}

/// The component that holds a point.
fn holder(analysis: &Analysis, p: DVec3) -> Result<usize, Box<Diagnostic>> {
    let found = match &analysis.parts {
        Parts::Complex(complex) => located(analysis, complex, p),
        Parts::Flood => match analysis.flood.label(p) {
            Label::Component(c) => Some(c),
            Label::Outside | Label::Undecided => None,
        },
    };
    found.ok_or_else(outside)
}

/// Why there is no component that holds a point.
pub(super) fn outside() -> Box<Diagnostic> {
    let error = Diagnostic::error("the point of component_of is not certain to be inside of the solid");
    Box::new(error.hint("the field must be negative there; see f.at(p)"))
}

fn located(analysis: &Analysis, complex: &Complex, p: DVec3) -> Option<usize> {
    Locator::new(&analysis.tape, complex).component_inside(p)
}
