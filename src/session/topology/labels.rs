//! Which component a point belongs to.
//!
//! Most points that rays come to lie in cells of which a flood ([`flood`]) has proven what they belong to, which
//! takes no evaluation to know. Of others a path downhill tells, where all is proven of the critical points.

use crate::tape::Tape;
use crate::topology::flood::{self, Label};
use crate::topology::{Complex, Locator};
use glam::DVec3;
use std::sync::Arc;

/// Says which component a point of a solid belongs to, by number in the report.
#[derive(Clone, Debug)]
pub struct Labels {
    flood: Arc<flood::Components>,
    /// What the flood's components are in the report.
    names: Arc<[Option<usize>]>,
    /// Without it the flood's components are those of the report.
    locator: Option<Locator>,
}

impl Labels {
    /// Of a flood, whose components have these numbers in the report, and a complex if all of it is proven.
    pub(super) fn new(
        tape: &Arc<Tape>,
        complex: Option<&Complex>,
        flood: &Arc<flood::Components>,
        names: Arc<[Option<usize>]>,
    ) -> Labels {
        Labels { flood: flood.clone(), names, locator: complex.map(|complex| Locator::new(tape, complex)) }
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
