//! What the lines of a script cost, and which of them make its field steep.
//!
//! ```text
//! Scene --sight--> points of the solid --cost--> time by line       --hints--> what to do about it
//!        (rays)    that the picture shows --bound--> slope by line
//! ```
//!
//! Everything is asked of the field that the *picture* shows, with its detail limited to pixels, and with the code that
//! is left of it where the picture looks: what is far away or too fine to be seen costs little in a picture, and
//! counts as little here.
//!
//! **Time** ([`Cost`]) is measured: each instruction of the pruned code is executed again and again in the arithmetic and
//! the batches of the beam caster, at pieces of rays that are a pixel long, and its time belongs to the line that wrote it
//! (`ledger.rs`). Times differ from run to run, so shares do by a few percent, too.
//!
//! **Slope** ([`Bound`]) is proven: casters step by what is certain of the field's slope, so a line whose bound is
//! steep makes steps short, whether the field is as steep or not. The bound over a box of some pixels is shared out
//! among the [terms](crate::field::Terms) that it comes from.
//!
//! **Hints** ([`Hint`]) follow from measurements, and say which. Where it is not sure that what they recommend is less work
//! (`creases.rs`), that was tried.

mod bound;
mod cost;
mod creases;
mod hints;
mod repeats;
mod sight;

pub use bound::{Bound, LineBound};
pub use cost::{Cost, LineCost};
pub use hints::Hint;

use super::ledger::Ledger;
use super::stage::{self, Taken};
use super::{Loaded, Order};
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::scene::Scene;
use creases::Trials;
use serde::Serialize;
use sight::Look;

/// What a script costs.
#[derive(Clone, Debug, Serialize)]
pub struct Profile {
    /// Rays that were cast to find out where the picture looks,
    pub rays: u64,
    /// how many of them met the solid,
    pub hits: u64,
    /// how many of their answers are not proven,
    pub uncertified: u64,
    /// and evaluations of the field that a ray needed on average.
    pub evaluations: f64,
    /// Time for the solid: of an evaluation along a piece of a ray.
    pub solid: Cost,
    /// Time for its colours and its material at a point, if the script says something of them.
    pub shading: Option<Cost>,
    /// How steep the field may be near the surface.
    pub bound: Bound,
    /// What to do about it.
    pub hints: Vec<Hint>,
}

/// Measures what a scene of a script costs.
///
/// # Errors
/// A diagnostic if no picture can be made of the scene, if nothing of the solid can be seen, or if the job was stopped.
pub fn profile(
    loaded: &Loaded,
    scene: &Scene,
    order: &Order,
    watch: &Watch<'_>,
) -> Result<Profile, Box<Diagnostic>> {
    let (mut taken, _) = watch.part(0.0, 0.3, |watch| Taken::corrected(scene, &order.at_once(), watch))?;
    let look = watch.part(0.3, 0.5, |watch| sight::look(&mut taken, watch)).map_err(|_| stage::stopped())?;
    if look.seen.is_empty() {
        let error = Diagnostic::error("no ray met the solid, so there is nothing that costs");
        return Err(Box::new(error.hint("check the camera, and the sign of the field (negative is inside)")));
    }
    measured(loaded, (scene, order), (&taken, &look), watch)
}

fn measured(
    loaded: &Loaded,
    (scene, order): (&Scene, &Order),
    (taken, look): (&Taken, &Look),
    watch: &Watch<'_>,
) -> Result<Profile, Box<Diagnostic>> {
    let stopped = |_| stage::stopped();
    let shown = &taken.scene;
    let shading = [&shown.color, &shown.looks, &shown.bump].into_iter().flatten();
    let roots: Vec<_> = shading.chain([&shown.tape]).flat_map(|tape| tape.roots()).collect();
    let ledger = Ledger::new(&shown.graph, &roots, &loaded.sources);
    let times = watch.part(0.5, 0.7, |watch| cost::of_solid(shown, &look.seen, watch)).map_err(stopped)?;
    let shading = cost::of_shading(shown, &look.seen);
    watch.check().map_err(stopped)?;
    let cells = shown.cells.of_values(&shown.settings.bounds.intervals());
    let bound = watch.part(0.7, 0.8, |watch| bound::of(&cells, &look.seen, &ledger, watch));
    let (bound, slopes) = bound.map_err(stopped)?;
    let stats = &look.stats;
    let solid = times.by_line(&ledger, &shown.graph);
    let shading = shading.map(|times| times.by_line(&ledger, &shown.graph));
    let mut profile = Profile {
        rays: stats.rays,
        hits: stats.hits,
        uncertified: stats.uncertified,
        evaluations: stats.evaluations as f64 / stats.rays.max(1) as f64,
        solid,
        shading,
        bound,
        hints: Vec::new(),
    };
    let found = hints::Found {
        shown,
        cells: &cells,
        look,
        ledger: &ledger,
        times: &times,
        slopes: &slopes,
        profile: &profile,
    };
    let mut hints = hints::of(&found);
    hints.extend(repeats::of(&found));
    let trials = |watch: &Watch<'_>| creases::of(&found, &Trials { scene, order, watch });
    hints.extend(watch.part(0.8, 1.0, trials)?);
    profile.hints = hints;
    Ok(profile)
}
