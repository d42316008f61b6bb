//! Which rays of a group march together.

use super::frame::Frame;
use crate::cast::Ray;
use std::ops::Range;

/// Parts that a range is cut into.
const PARTS: usize = 4;

/// Rays that go too far apart for a beam are looked at in fewer and fewer, down to so many.
const FEWEST: usize = 8;

/// Finds the rays of a group that go the same way, no more than `widest` together; `found` is told of them, and of their
/// frame unless each goes alone. Rays from different places of a surface have nothing in common where they begin, which
/// matters unless they are marched from their other ends.
pub(in crate::cast) fn gather(
    rays: &[Ray],
    widest: usize,
    is_from_behind: bool,
    mut found: impl FnMut(Range<usize>, Option<Frame>),
) {
    let mut open: Vec<Range<usize>> = Vec::new();
    open.extend((0..rays.len()).step_by(widest).map(|start| start..(start + widest).min(rays.len())));
    while let Some(own) = open.pop() {
        let Some(range) = trimmed(own, |i| is_real(&rays[i])) else { continue };
        let are_off = || rays[range.clone()].iter().all(|ray| !is_from_surface(ray));
        let goes_together = |frame: &Frame| is_from_behind || frame.is_strict() || are_off();
        match Frame::new(&rays[range.clone()]).filter(goes_together) {
            None if range.len() > FEWEST => open.extend(quarters(range)),
            frame => found(range, frame),
        }
    }
}

/// Whether there is anything of a ray.
pub(in crate::cast) fn is_real(ray: &Ray) -> bool {
    ray.near <= ray.far
}

/// Whether a ray begins on a surface, as far as it says.
pub(in crate::cast) fn is_from_surface(ray: &Ray) -> bool {
    ray.near <= 0.0
}

/// The same line the other way.
pub(in crate::cast) fn turned(&Ray { origin, direction, near, far, tolerance }: &Ray) -> Ray {
    Ray { origin, direction: -direction, near: -far, far: -near, tolerance }
}

/// The parts that a range of rays is cut into.
pub(in crate::cast) fn quarters(range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let size = (range.len().next_power_of_two() / PARTS).max(1);
    let end = range.end;
    range.step_by(size).map(move |start| start..(start + size).min(end))
}

/// The range from the first ray of which there is anything to the last.
pub(in crate::cast) fn trimmed(range: Range<usize>, is_real: impl Fn(usize) -> bool) -> Option<Range<usize>> {
    let first = range.clone().find(|&i| is_real(i))?;
    let last = range.rev().find(|&i| is_real(i))?;
    Some(first..last + 1)
}
