//! `orogen topology` of a solid of which no more is found out than a picture needs: the picture, and what it took.

use super::{Args, What, save};
use crate::cli::interrupt::Flag;
use crate::cli::progress::Progress;
use crate::cli::report::{Failure, count, out};
use crate::diag::Diagnostic;
use crate::scene::Scene;
use crate::session::topology::{local, local_picture};
use crate::topology::local::LocalStats;
use glam::DVec3;

/// That nothing is asked for but a picture.
pub(super) fn check(args: &Args) -> Result<(), Failure> {
    let shows_all = matches!(args.show, Some(What::Components | What::Network));
    if args.picture.output.is_none() || args.complex.is_some() || args.voids || shows_all {
        let message = "component_of with `feature` finds out no more than a picture needs";
        let hint = "ask for one: -o planet.png --show specks, kept or triptych; or leave out `feature` to find everything";
        return Err(Failure::usage(message, hint));
    }
    if args.fresh || args.top.is_some() {
        let message = "component_of with `feature` keeps nothing on disk and has no table of components";
        return Err(Failure::usage(message, "leave out --fresh and --top"));
    }
    Ok(())
}

/// Makes the picture; returns what it took.
///
/// # Errors
/// A diagnostic where there is no picture, or where it would need the whole solid.
pub(super) fn show(
    args: &Args,
    scene: &Scene,
    (core, feature): (DVec3, f64),
    watch: (&Progress, &Flag),
) -> Result<LocalStats, Box<Diagnostic>> {
    let local = local(scene, core, feature)?;
    let shown = args.show.unwrap_or(What::Specks);
    save(args, watch, |order, job| local_picture(scene, order, &local, shown.show(), job))?;
    Ok(local.stats())
}

/// The statistics of table 8.5.
pub(super) fn print(stats: &LocalStats) {
    let share = |part: u64, all: u64| format!("{:.2} %", 100.0 * part as f64 / all.max(1) as f64);
    let seconds = |nanos: u64| format!("{:.2} s", nanos as f64 * 1e-9);
    for (name, value) in [
        ("points asked about", count(stats.asked)),
        ("  undecided", count(stats.unknown)),
        ("searches given up", count(stats.impatient)),
        ("places looked at", count(stats.looked)),
        ("  seen from the core", share(stats.quick, stats.looked)),
        ("voxels searched", count(stats.voxels)),
        ("  minima", count(stats.minima)),
        ("  1-saddles", count(stats.saddles)),
        ("crumbs with a moat", count(stats.moats)),
        ("statuses remembered", count(stats.cached)),
        ("  hit rate", share(stats.statuses_known, stats.statuses)),
        ("paths downhill", count(stats.paths)),
        ("time with straight lines", seconds(stats.nanos_lines)),
        ("  with paths", seconds(stats.nanos_paths)),
        ("  with voxels, moats", seconds(stats.nanos_voxels)),
    ] {
        out(format!("{name:26} {value:>14}"));
    }
}
