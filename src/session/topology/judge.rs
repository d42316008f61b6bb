//! The judge of a caster that passes by what is not kept.

use super::carried::{Before, Carried};
use super::local::{Joined, doubts, local};
use super::store::Key;
use super::{Analysis, Labels, Purpose, analyse, check_point, kept, rivalled, unproven};
use crate::cast::{Judge, Ruling};
use crate::diag::Diagnostic;
use crate::field::{Field, Watch};
use crate::scene::{Keep, Measure, Scene};
use crate::session::{stage, whereabouts};
use crate::topology::local::{Local, Seeker};
use glam::DVec3;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

/// Keeps points of some components.
#[derive(Debug)]
pub(super) struct Components {
    labels: Labels,
    kept: Arc<[Ruling]>,
}

impl Components {
    pub fn new(analysis: &Analysis, kept: Arc<[Ruling]>) -> Components {
        Components { labels: analysis.labels.clone(), kept }
    }
}

impl Judge for Components {
    /// A point of which it is not known what it belongs to is kept: better a crumb too many than a hole.
    fn judge(&mut self, points: &[DVec3], rulings: &mut [Ruling], _: &AtomicBool) {
        for (ruling, component) in rulings.iter_mut().zip(self.labels.components(points)) {
            *ruling = component.map_or(Ruling { kept: true, proven: false }, |c| self.kept[c]);
        }
    }

    fn clone_box(&self) -> Box<dyn Judge> {
        Box::new(Components { labels: self.labels.clone(), kept: self.kept.clone() })
    }
}

/// What pictures and files need to show what a scene keeps of its solid.
pub struct Correction {
    /// Says what that is.
    pub judge: Box<dyn Judge>,
    /// What is not proven about it.
    warnings: Vec<Diagnostic>,
    /// What is found out as rays ask, about which more is known afterwards.
    local: Option<Arc<Local>>,
}

impl Correction {
    /// What is not proven about what was made with it.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let found = self.local.as_ref().map(|local| doubts(&local.stats()));
        self.warnings.iter().cloned().chain(found.into_iter().flatten()).collect()
    }
}

/// A correction that keeps what a scene says, from an analysis of its solid.
///
/// # Errors
/// As for [`analyse`], and where no component holds the point that one should.
pub fn correction(
    scene: &Scene,
    keep: &Keep,
    threads: Option<NonZeroUsize>,
    watch: &Watch<'_>,
) -> Result<Correction, Box<Diagnostic>> {
    correction_for(scene, [keep, keep], threads, watch)
}

/// The same, of which a script asked for the last.
fn correction_for(
    scene: &Scene,
    [keep, asked]: [&Keep; 2],
    threads: Option<NonZeroUsize>,
    watch: &Watch<'_>,
) -> Result<Correction, Box<Diagnostic>> {
    if let Some(before) = Before::of(scene, keep) {
        let Correction { judge, mut warnings, local } =
            correction_for(&before.scene, [&before.keep, asked], threads, watch)?;
        warnings.extend(before.doubt());
        return Ok(Correction { judge: Box::new(Carried { judge, way: before.way }), warnings, local });
    }
    check_point(scene, keep, asked)?;
    if let Keep::Near { core, feature } = *keep {
        let local = local(scene, core, feature)?;
        let judge = Box::new(Joined(Seeker::new(local.clone())));
        return Ok(Correction { judge, warnings: Vec::new(), local: Some(local) });
    }
    let purpose = Purpose { volumes: *keep == Keep::Most(Measure::Volume), ..Purpose::default() };
    let analysis = stage::on_threads(threads, || known(scene, purpose, watch))??;
    let kept = kept(&analysis, keep)?;
    let warnings = unproven(&analysis, &kept).or_else(|| rivalled(&analysis, keep)).into_iter().collect();
    let judge = Box::new(Components::new(&analysis, kept.into()));
    Ok(Correction { judge, warnings, local: None })
}

/// Says which component of a scene's solid points belong to.
///
/// # Errors
/// If the job is cancelled.
pub fn labels(
    scene: &Scene,
    threads: Option<NonZeroUsize>,
    watch: &Watch<'_>,
) -> Result<Labels, Box<Diagnostic>> {
    let purpose =
        Purpose { volumes: scene.surface.keep == Some(Keep::Most(Measure::Volume)), ..Purpose::default() };
    Ok(stage::on_threads(threads, || known(scene, purpose, watch))??.labels.clone())
}

/// The analysis that was made last, and what of.
static LAST: Mutex<Option<(Key, bool, Analysis)>> = Mutex::new(None);

/// An analysis, remembered from picture to picture: quick ones and the full one share it.
fn known(scene: &Scene, purpose: Purpose, watch: &Watch<'_>) -> Result<Analysis, Box<Diagnostic>> {
    let (graph, root) = (&scene.graph, scene.surface.field);
    let key = Key::new(graph, root, &whereabouts::region(scene, &Field::new(graph, root)));
    let last = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((of, volumes, analysis)) = &*last()
        && *of == key
        && *volumes >= purpose.volumes
    {
        return Ok(Analysis { place: graph.place(root).cloned(), ..analysis.clone() });
    }
    let analysis = analyse(scene, purpose, watch)?;
    *last() = Some((key, purpose.volumes, analysis.clone()));
    Ok(analysis)
}
