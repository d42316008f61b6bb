//! What a scene keeps of its solid, for what is no picture: meshes, volumes and maps of heights.
//!
//! A mesh and a volume show the solid with its detail limited to what they can hold, and there what is connected is decided
//! of that solid: what they show is what was asked about. In pictures, of which each pixel has a limit of its own, and in maps
//! it is decided in full detail.

use super::judge::{Correction, correction};
use crate::cast::{Judge, Ruling};
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::mesh::Meshed;
use crate::num::Many;
use crate::scene::{Keep, Scene};
use crate::session::stage;
use crate::shape::Parts;
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Rules which points of a solid are kept.
pub struct Sieve {
    correction: Correction,
    /// Whether that is one component.
    is_one: bool,
}

/// Points that one thread asks about at once.
const AT_ONCE: usize = 256;

/// How far behind the points of a mesh a place is looked for that is inside, in cells.
const DEPTHS: [f64; 5] = [0.0625, 0.125, 0.25, 0.5, 1.0];

/// What was left out of a mesh, and what of it is in doubt.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct LeftOut {
    /// Parts that the mesh would have had.
    pub parts: usize,
    /// Of these, such as may be joined with what is kept: that they are not was not proven.
    pub unproven: usize,
    /// Parts of the mesh of which it is not proven that they are kept.
    pub unknown: usize,
    /// Parts of it that hold something that should not be there, joined with what should.
    pub joined: usize,
    /// Parts of it that belong to one component with another part: what joins them is too thin for the mesh.
    pub parted: usize,
}

/// How many witnesses of a part of a mesh are ruled how.
#[derive(Clone, Copy, Default)]
struct Witnesses {
    kept: usize,
    /// Kept, but that may be for want of knowing better.
    unknown: usize,
    rejected: usize,
    /// Of these, those of which that is proven.
    proven: usize,
}

impl Witnesses {
    fn add(&mut self, ruling: Ruling) {
        self.kept += usize::from(ruling.kept && ruling.proven);
        self.unknown += usize::from(ruling.kept && !ruling.proven);
        self.rejected += usize::from(!ruling.kept);
        self.proven += usize::from(!ruling.kept && ruling.proven);
    }

    /// Whether the part does not belong to what is kept: most say so, and none is known to.
    fn are_against(&self) -> bool {
        self.kept == 0 && self.rejected > self.unknown
    }
}

impl Sieve {
    /// What a scene keeps; none where that is all of it. Where the scene has less detail than the one of the script, `whole`,
    /// errors say so.
    ///
    /// # Errors
    /// As for [`correction`].
    pub fn of(scene: &Scene, whole: &Scene, watch: &Watch<'_>) -> Result<Option<Sieve>, Box<Diagnostic>> {
        let Some(keep) = &scene.surface.keep else { return Ok(None) };
        let is_one = !matches!(keep, Keep::Share(_));
        let found = correction(scene, keep, None, watch);
        let is_limited = !Arc::ptr_eq(&scene.graph, &whole.graph) && !watch.cancel.load(Ordering::Relaxed);
        let explained =
            |error: Box<Diagnostic>| match is_limited {
                true => Box::new(error.hint(
                    "the solid is looked at with as much detail as the file can show; a finer one may do",
                )),
                false => error,
            };
        Ok(Some(Sieve { correction: found.map_err(explained)?, is_one }))
    }

    /// What is not proven about what it said so far.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        self.correction.warnings()
    }

    /// The judge that it asks.
    pub fn judge(&self) -> Box<dyn Judge> {
        self.correction.judge.clone_box()
    }

    /// Rules of points that are inside, in parallel.
    ///
    /// # Errors
    /// If the job was stopped.
    pub fn rule(&self, points: &[DVec3], watch: &Watch<'_>) -> Result<Vec<Ruling>, Box<Diagnostic>> {
        let judge = Mutex::new(self.judge());
        let own = || judge.lock().unwrap_or_else(PoisonError::into_inner).clone_box();
        let done = AtomicUsize::new(0);
        let rulings = points.par_chunks(AT_ONCE).map_init(own, |judge, some| {
            let mut rulings = vec![Ruling { kept: true, proven: false }; some.len()];
            if !watch.cancel.load(Ordering::Relaxed) {
                judge.judge(some, &mut rulings, watch.cancel);
            }
            let done = done.fetch_add(some.len(), Ordering::Relaxed) + some.len();
            (watch.progress)(done as f64 / points.len() as f64);
            rulings
        });
        let rulings = rulings.flatten_iter().collect();
        watch.check().map_err(|_| stage::stopped())?;
        Ok(rulings)
    }

    /// Leaves parts out of a mesh of the solid whose field is the tape. The witnesses of a part are places behind all of its
    /// points; a part that has none is kept.
    ///
    /// # Errors
    /// If the job was stopped.
    pub fn leave_out(
        &self,
        meshed: &mut Meshed,
        tape: &Arc<Tape>,
        watch: &Watch<'_>,
    ) -> Result<LeftOut, Box<Diagnostic>> {
        let parts = Parts::of(&meshed.mesh);
        let (places, owners): (Vec<DVec3>, Vec<usize>) = witnesses(meshed, &parts, tape).into_iter().unzip();
        let mut said = vec![Witnesses::default(); parts.count()];
        for (ruling, part) in self.rule(&places, watch)?.into_iter().zip(owners) {
            said[part].add(ruling);
        }
        let is_left_out: Vec<bool> = said.iter().map(Witnesses::are_against).collect();
        let bodies = parts.volumes(&meshed.mesh).into_iter().zip(&said);
        let bodies = bodies.filter(|(volume, said)| *volume > 0.0 && said.kept > 0).count();
        meshed.mesh = parts.without(&meshed.mesh, &is_left_out);
        let count = |is_such: &dyn Fn(&Witnesses) -> bool| said.iter().filter(|said| is_such(said)).count();
        Ok(LeftOut {
            parts: count(&|said| said.are_against()),
            unproven: count(&|said| said.are_against() && said.proven == 0),
            unknown: count(&|said| !said.are_against() && said.kept == 0),
            joined: count(&|said| said.kept > 0 && said.rejected > 0),
            parted: if self.is_one { bodies.saturating_sub(1) } else { 0 },
        })
    }
}

/// Places inside of the solid next to the points of a mesh, each with the part it is of.
fn witnesses(meshed: &Meshed, parts: &Parts, tape: &Arc<Tape>) -> Vec<(DVec3, usize)> {
    let mesh = &meshed.mesh;
    let of_part = |(part, points): (usize, &Vec<u32>)| {
        let at = |i: &u32| mesh.points[*i as usize];
        let middle = points.iter().map(at).sum::<DVec3>() / points.len() as f64;
        let found = points.par_iter().map_init(
            || Evaluator::new(tape.clone()),
            |field, point| {
                let inward = -mesh.normals[*point as usize] * meshed.cell;
                // A part of a few cells is mostly about its middle.
                let aside = (middle - at(point)).clamp_length_max(2.0 * meshed.cell);
                [inward, aside].into_iter().find_map(|way| behind(field, at(point), way))
            },
        );
        found.flatten().map(|place| (place, part)).collect::<Vec<_>>()
    };
    parts.points().iter().enumerate().flat_map(of_part).collect()
}

/// A place inside of the solid, on the way from a point of its surface inwards.
fn behind(field: &mut Evaluator<Many<f64, 8>>, p: DVec3, inward: DVec3) -> Option<DVec3> {
    let at = |lane: usize| p + inward * DEPTHS[lane.min(DEPTHS.len() - 1)];
    let axis = |axis: usize| Many(std::array::from_fn(|lane| at(lane)[axis]));
    let values = field.eval(&[axis(0), axis(1), axis(2)]);
    (0..DEPTHS.len()).find(|&lane| values.0[lane] < 0.0).map(at)
}
