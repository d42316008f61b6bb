//! What a scene keeps of its solid, for what is no picture: meshes, volumes and maps of heights.
//!
//! A mesh and a volume show the solid with its detail limited to what they can hold. There what is connected is decided of
//! that solid, so that what is written is one piece if one piece was asked for; in pictures, of which each pixel has a limit of
//! its own, and in maps it is decided in full detail.

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
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};

/// Rules which points of a solid are kept.
pub struct Sieve {
    correction: Correction,
    /// Whether that is one component.
    is_one: bool,
}

/// Points that one thread asks about at once.
const AT_ONCE: usize = 4096;

/// Places of a part of a mesh that are asked about, at most,
const WITNESSES: usize = 64;

/// and how far behind its points these are, in cells: the first that is inside.
const DEPTHS: [f64; 5] = [0.0625, 0.125, 0.25, 0.5, 1.0];

/// What was left out of a mesh.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct LeftOut {
    /// Parts that the mesh would have had.
    pub parts: usize,
    /// Parts of it that hold something that should not be there, joined with what should.
    pub joined: usize,
    /// Parts of it that belong to one component with another part: what joins them is too thin for the mesh.
    pub parted: usize,
}

impl Sieve {
    /// What a scene keeps; none where that is all of it.
    ///
    /// # Errors
    /// As for [`correction`].
    pub fn of(scene: &Scene, watch: &Watch<'_>) -> Result<Option<Sieve>, Box<Diagnostic>> {
        let Some(keep) = &scene.surface.keep else { return Ok(None) };
        let is_one = !matches!(keep, Keep::Share(_));
        correction(scene, keep, None, watch).map(|correction| Some(Sieve { correction, is_one }))
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
        let rulings = points.par_chunks(AT_ONCE).map_init(own, |judge, points| {
            let mut rulings = vec![Ruling { kept: true, proven: false }; points.len()];
            if !watch.cancel.load(Ordering::Relaxed) {
                judge.judge(points, &mut rulings, watch.cancel);
            }
            rulings
        });
        let rulings = rulings.flatten_iter().collect();
        watch.check().map_err(|_| stage::stopped())?;
        Ok(rulings)
    }

    /// Leaves parts out of a mesh of the solid whose field is the tape. A part is left out if all of its witnesses are;
    /// of what has none it is not known what it belongs to, and it is kept.
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
        let mut field = Evaluator::new(tape.clone());
        let (mut witnesses, mut owners) = (Vec::new(), Vec::new());
        for (part, points) in parts.points().iter().enumerate() {
            let at = |i: &u32| meshed.mesh.points[*i as usize];
            let middle = points.iter().map(at).sum::<DVec3>() / points.len() as f64;
            let step = points.len().div_ceil(WITNESSES);
            let found = points.iter().step_by(step).filter_map(|point| {
                let inward = -meshed.mesh.normals[*point as usize] * meshed.cell;
                // A part of a few cells is mostly about its middle.
                let aside = if step == 1 { middle - at(point) } else { inward };
                behind(&mut field, at(point), inward).or_else(|| behind(&mut field, at(point), aside))
            });
            let before = witnesses.len();
            witnesses.extend(found);
            owners.resize(owners.len() + witnesses.len() - before, part);
        }
        // Rulings of each part: kept, and not.
        let mut counts = vec![[0_usize; 2]; parts.count()];
        for (ruling, part) in self.rule(&witnesses, watch)?.into_iter().zip(owners) {
            counts[part][usize::from(!ruling.kept)] += 1;
        }
        let is_left_out: Vec<bool> = counts.iter().map(|[kept, not]| *kept == 0 && *not > 0).collect();
        let volumes = parts.volumes(&meshed.mesh);
        let bodies =
            volumes.iter().zip(&is_left_out).filter(|(volume, out)| **volume > 0.0 && !**out).count();
        meshed.mesh = parts.without(&meshed.mesh, &is_left_out);
        Ok(LeftOut {
            parts: is_left_out.iter().filter(|out| **out).count(),
            joined: counts.iter().filter(|[kept, not]| *kept > 0 && *not > 0).count(),
            parted: if self.is_one { bodies.saturating_sub(1) } else { 0 },
        })
    }
}

/// A place inside of the solid, on the way from a point of its surface inwards.
fn behind(field: &mut Evaluator<Many<f64, 8>>, p: DVec3, inward: DVec3) -> Option<DVec3> {
    let at = |lane: usize| p + inward * DEPTHS[lane.min(DEPTHS.len() - 1)];
    let axis = |axis: usize| Many(std::array::from_fn(|lane| at(lane)[axis]));
    let values = field.eval(&[axis(0), axis(1), axis(2)]);
    (0..DEPTHS.len()).find(|&lane| values.0[lane] < 0.0).map(at)
}
