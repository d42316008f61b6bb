//! Where a line first comes into a solid: for the few lines that somebody stands on. Rays of pictures have casters.
//!
//! The march tries the piece ahead of what is known to be free, twice as long as the last free one, and halves one
//! that an enclosure does not prove free.

use super::Field;
use crate::num::{ROUNDOFF, Reduced};
use crate::tape::Evaluator;
use glam::DVec3;

/// Pieces after which a line is given up.
const PIECES: u32 = 50_000;

/// Neither a way in nor its absence could be proven; all before `free` is outside.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("no more is known than that the line is free up to {free}")]
pub struct Unknown {
    /// As `t` along the line.
    pub free: f64,
}

/// The first `t` from `near` to `far` at which `origin + t direction` is inside, to within `tolerance` or what double
/// precision can tell: everything before is proven to be outside, but for places thinner than that. `near`
/// itself if the line begins inside, and `None` if it stays outside. `direction` is a unit vector.
///
/// # Errors
/// [`Unknown`] where too much of the line cannot be told from the surface, and when `halt` says so.
pub fn first_inside(
    field: &mut Field,
    (origin, direction): (DVec3, DVec3),
    [near, far]: [f64; 2],
    tolerance: f64,
    halt: &dyn Fn() -> bool,
) -> Result<Option<f64>, Unknown> {
    let mut pieces = Evaluator::<Reduced<1>>::new(field.tape().clone());
    let is_inside = |field: &mut Field, t: f64| field.value(origin + t * direction) <= 0.0;
    if is_inside(field, near) {
        return Ok(Some(near));
    }
    let (mut free, mut length) = (near, 0.25 * (far - near));
    for _ in 0..PIECES {
        if free >= far {
            return Ok(None);
        }
        if halt() {
            break;
        }
        // Never nothing: a piece too short to move on would be tried for ever.
        let end = (free + length).max(free.next_up()).min(far);
        if pieces.eval(&piece(origin, direction, [free, end])).range.lo > 0.0 {
            (length, free) = (2.0 * (end - free), end);
            continue;
        }
        let rounding = 16.0 * ROUNDOFF * (origin.abs().max_element() + free.abs());
        if end - free > tolerance.max(rounding) {
            length = 0.5 * (end - free);
        } else if is_inside(field, end) {
            return Ok(Some(free));
        } else {
            free = end;
        }
    }
    Err(Unknown { free })
}

/// The coordinates of a piece of a line: a product and a sum are rounded, for its middle and for half its
/// length.
fn piece(origin: DVec3, direction: DVec3, [a, b]: [f64; 2]) -> [Reduced<1>; 3] {
    let middle = origin + 0.5 * (a + b) * direction;
    let half = (0.5 * (b - a)).next_up() * direction;
    let rounding = 8.0 * ROUNDOFF * (origin.abs().max_element() + a.abs().max(b.abs()));
    [0, 1, 2].map(|axis| Reduced::within(middle[axis], [half[axis]], rounding))
}
