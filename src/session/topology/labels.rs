//! Which component a point belongs to.
//!
//! Most points that rays come to lie in cells of which a flood ([`flood`]) has proven what they belong to, which
//! takes no evaluation to know. Of others a path downhill tells, where all is proven of the critical points.

use crate::render::{Picture, Pixel};
use crate::tape::Tape;
use crate::topology::flood::{self, Label};
use crate::topology::{Complex, Locator};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Pixels that are asked about at once.
const AT_ONCE: usize = 4096;

/// How far behind the surface a place is asked about, in pixels: a few tolerances of hits.
const DEEPER: f64 = 0.02;

/// More than the rounding of a coordinate to single precision, relative to the largest.
const SINGLE: f64 = 2.5e-7;

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

    /// The components that the pixels of a picture show.
    ///
    /// A hit lies in front of the surface, and its pixel holds it in single precision: what is asked about is a place
    /// behind it by a little more than either. Where pixels are smaller than that precision, as on planets seen from the
    /// ground, that place may belong to what is behind.
    pub fn seen(&self, picture: &Picture) -> Vec<Option<u32>> {
        let behind = |pixel: &Pixel| {
            let [at, normal] = [pixel.position, pixel.normal].map(|v| Vec3::from_array(v).as_dvec3());
            at - normal * (DEEPER * f64::from(pixel.footprint) + SINGLE * at.abs().max_element())
        };
        let part = |labels: &mut Labels, pixels: &[Pixel]| {
            let is_met = |pixel: &&Pixel| pixel.depth.is_finite();
            let points: Vec<DVec3> = pixels.iter().filter(is_met).map(behind).collect();
            let mut found = labels.components(&points).into_iter();
            let component = |pixel| if is_met(&pixel) { found.next().flatten() } else { None };
            pixels.iter().map(component).map(|c| c.and_then(|c| u32::try_from(c).ok())).collect::<Vec<_>>()
        };
        let parts = picture.pixels.par_chunks(AT_ONCE);
        parts.map_init(|| self.clone(), part).flatten_iter().collect()
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
