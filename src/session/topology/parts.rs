//! The components of a solid, from both ways of finding them.
//!
//! Where all is proven of the critical points, the components are those of the complex, and the flood says how large they
//! are. Else they are those of the flood, which proves what it says of creases and of critical points that are not
//! isolated alike; critical points are counted all the same.
//!
//! Components of the flood and of the complex have different numbers. A point of each of the former is followed down to
//! learn which of the latter it is; or one of the latter's minima is found in it.
//!
//! A component of the solid lies in cells of one component of the flood, or of one cluster of cells that are not
//! understood. So its volume is at most that of all of the cluster, and at least that of the cells that are full and known
//! to belong to it.

use crate::num::Interval;
use crate::scene::Aabb;
use crate::tape::Tape;
use crate::topology::flood::{self, Label};
use crate::topology::{Complex, Component, Locator};
use std::sync::Arc;

/// A component.
#[derive(Clone, Debug)]
pub struct Part {
    /// A box that holds what cells show of it; none if it is smaller than these.
    pub bounds: Option<Aabb>,
    /// Encloses its volume within the region.
    pub volume: Interval,
    /// An estimate of that, unless it is smaller than what cells show.
    pub about: Option<f64>,
    /// What its critical points say, if they are known to be all.
    pub critical: Option<Component>,
    /// Whether it is proven to be one component, all of it, and joined to no other within the region.
    pub certified: bool,
    /// Whether it may go on beyond the region.
    pub cut: bool,
}

/// All of them, and which of them the flood's components are.
pub(super) type Parts = (Vec<Part>, Arc<[Option<usize>]>);

/// The components of the flood; `is_whole` where there is nothing of the solid beyond the region.
pub(super) fn of_flood(flood: &flood::Components, is_whole: bool) -> Parts {
    let part = |c: &flood::Component| Part {
        bounds: Some(c.bounds),
        volume: c.volume,
        about: Some(c.about),
        critical: None,
        certified: c.certified,
        cut: c.cut && !is_whole,
    };
    (flood.list.iter().map(part).collect(), (0..flood.list.len()).map(Some).collect())
}

/// The components of a complex of which all is proven.
pub(super) fn of_complex(tape: &Arc<Tape>, complex: &Complex, flood: &flood::Components) -> Parts {
    let names = names(tape, complex, flood);
    let mut parts: Vec<Part> = complex.components.iter().map(|c| unmeasured(complex, c, flood)).collect();
    for (found, name) in flood.list.iter().zip(&names) {
        let Some(part) = name.and_then(|name| parts.get_mut(name)) else { continue };
        let own = part.bounds.unwrap_or(found.bounds);
        part.bounds = Some(own.hull(&found.bounds));
        let Interval { lo, hi } = part.volume;
        let least = (Interval::point(lo) + Interval::point(found.volume.lo)).lo;
        let most = hi.min(found.volume.hi);
        debug_assert!(least <= most, "cells that are counted twice");
        part.volume = Interval::new(least, most);
        part.about = Some(part.about.unwrap_or(0.0) + found.about);
    }
    (parts, names.into())
}

/// Which components of a complex those of the flood are.
fn names(tape: &Arc<Tape>, complex: &Complex, flood: &flood::Components) -> Vec<Option<usize>> {
    let inside: Vec<_> = flood.list.iter().map(|c| c.inside).collect();
    let mut names = Locator::new(tape, complex).components(&inside, |_| None);
    for (point, name) in complex.points.iter().zip(&complex.component) {
        if let Label::Component(c) = flood.label(point.position) {
            names[c] = names[c].or(*name);
        }
    }
    names
}

/// A component of which nothing is known but its critical points and where its deepest minimum is.
fn unmeasured(complex: &Complex, component: &Component, flood: &flood::Components) -> Part {
    let most = flood.most_about(complex.points[component.deepest].position);
    Part {
        bounds: None,
        volume: Interval::new(0.0, most),
        about: None,
        critical: Some(component.clone()),
        certified: true,
        cut: false,
    }
}
