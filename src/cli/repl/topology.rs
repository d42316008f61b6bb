//! `:topology`: what a solid is connected with, in short.

use super::Shell;
use crate::cli::report::{Outcome, err, plural, seconds};
use crate::cli::topology::report::Report;
use crate::diag::{Diagnostic, Severity};
use crate::scene::{Keep, Measure};
use crate::session::topology::{Origin, Purpose, analyse, kept};
use std::time::Instant;

/// Components in the table.
const TOP: usize = 5;

/// Analyses a solid, and says what is proven of it.
pub fn run(shell: &Shell, argument: Option<&str>) -> Outcome {
    let start = Instant::now();
    let mut scene = shell.solid(argument)?;
    let origin = Origin::of(&scene);
    if let Some(origin) = &origin {
        err(origin.note());
        origin.doubts.iter().for_each(|d| drop(shell.say(d)));
        scene = origin.scene.clone();
    }
    let purpose = Purpose { volumes: true, ..Purpose::default() };
    let analysis =
        shell.watched("topology", |watch| analyse(&scene, purpose, watch)).map_err(|e| shell.say(&e))?;
    let keep = match scene.surface.keep {
        // That is of a part of the solid only, and this is about all of it.
        None | Some(Keep::Near { .. }) => Keep::Most(Measure::Minima),
        Some(keep) => keep,
    };
    let kept = kept(&analysis, &keep).map_err(|e| shell.say(&e))?;
    let report = Report::new(&analysis, &kept, origin.as_ref(), start.elapsed().as_secs_f64());
    report.print(TOP, "`orogen topology` of a script");
    err(format_args!("{}, {}", seconds(start.elapsed().as_secs_f64()), plural(report.cells(), "cell")));
    if let Some(rough) = &analysis.rough {
        shell.say(&Diagnostic { severity: Severity::Warning, ..(**rough).clone() });
    }
    report.doubts().iter().for_each(|d| drop(shell.say(d)));
    Ok(())
}
