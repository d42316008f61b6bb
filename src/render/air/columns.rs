//! How much air is on the way to the top.
//!
//! Bruneton and Neyret (2008) keep a table of transmittance over the radius `r` and the cosine `mu` to
//! the vertical. Transmittance varies by many powers of ten, which a table can only follow with many
//! nodes. What is kept here instead is, for each layer, the *length* of air of the density at `r` that
//! holds as much matter as there is on the way: `m(r, mu) / rho(r)`. For an exponential layer this is
//! `H` straight up and `sqrt(pi r H / 2)` at the horizon (Chapman's function), nearly the same at all
//! heights, and in their coordinates nearly linear in between. So a small table is as good as an
//! integral, even for a fog of a few metres:
//!
//! ```text
//! u = (d - d_min) / (d_max - d_min)       d = distance to the top,
//! v = sqrt((r^2 - R^2) / (R_t^2 - R^2))   from R_t - r straight up to sqrt(R_t^2 - r^2) at mu = 0
//! ```
//!
//! The table needs only lines that rise. One that falls first rises from its perigee to both sides:
//! `m(r, mu) = 2 m(b, 0) - m(r, -mu)`, with `b = r sqrt(1 - mu^2)`.

use super::grid::{Grid, share};
use super::line::{Count, Steps};
use super::medium::Medium;
use super::shell::Shell;
use glam::DVec4;
use std::sync::atomic::AtomicBool;

/// Nodes across directions and heights.
const SIZE: (usize, usize) = (64, 128);

/// Steps of the integral at each node.
const STEPS: Count = Count { one_way: 32, each_half: 32 };

/// Amounts of matter on the way to the top, by kind.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    shell: Shell,
    /// Lengths by layer, and the amount of the absorber itself, for it may be there above a place
    /// that has none.
    lengths: Grid<DVec4>,
}

impl Columns {
    /// Of a medium; `None` if that was cancelled.
    pub fn new(medium: &Medium, cancel: &AtomicBool) -> Option<Columns> {
        let lengths = Grid::new([SIZE.0, SIZE.1], cancel, |level| {
            let r = medium.shell.radius_at(level);
            (0..SIZE.0).map(move |i| lengths(medium, r, share(i, SIZE.0)))
        });
        Some(Columns { shell: medium.shell, lengths: lengths? })
    }

    /// Amount of matter, by kind, on the way from the radius `r`, where the densities are `density`, to
    /// the top at the cosine `mu >= 0` to the vertical.
    pub fn rising(&self, r: f64, density: DVec4, mu: f64) -> DVec4 {
        let Shell { radius, top } = self.shell;
        let r = r.clamp(radius, top);
        let beneath = (top - r) * (top + r);
        let (least, most) = (top - r, beneath.sqrt());
        let distance = beneath / (r * mu + (r * r * mu * mu + beneath).sqrt());
        let u = if most > least { (distance - least) / (most - least) } else { 0.0 };
        self.lengths.linear(u, self.shell.level(r)) * density.truncate().extend(1.0)
    }
}

/// A node of the table.
fn lengths(medium: &Medium, r: f64, u: f64) -> DVec4 {
    let beneath = (medium.shell.top - r) * (medium.shell.top + r);
    let (least, most) = (medium.shell.top - r, beneath.sqrt());
    // The line that reaches the top after the distance d: (r mu + d)^2 + r^2 (1 - mu^2) = top^2.
    let d = least + u * (most - least);
    let mu = if d > 0.0 { ((beneath / d - d) / (2.0 * r)).clamp(0.0, 1.0) } else { 1.0 };
    let b = r * ((1.0 - mu) * (1.0 + mu)).sqrt();
    let start = r * mu;
    let amount = |m: DVec4, step| m + medium.amount(b, step);
    let amount = Steps::new(medium, b, [start, start + d], STEPS).iter().fold(DVec4::ZERO, amount);
    let density = medium.density(r);
    let length = |m: f64, rho: f64| if rho > 0.0 { m / rho } else { 0.0 };
    DVec4::new(
        length(amount.x, density.x),
        length(amount.y, density.y),
        length(amount.z, density.z),
        amount.w,
    )
}
