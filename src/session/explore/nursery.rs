//! Where changed expressions are tried: what does not run, what cannot be seen, and what looks the same is thrown away.

use super::breed::Breeding;
use super::mutate::{Change, Pair};
use super::subject::{Genome, Subject};
use crate::diag::Diagnostic;
use crate::expr::NodeId;
use crate::field::Field;
use crate::num::Digest;
use crate::render::View;
use crate::scene::{Param, Scene};
use crate::script::genes::{Genes, Kin};
use std::cell::OnceCell;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// How many changes are tried for one child, before it has the expressions of its parent.
const ATTEMPTS: u64 = 10;

/// Rays of a glance, and points on each.
const GLANCE: (u32, u32, u32) = (12, 9, 48);

/// Raises children whose expressions may differ from those of their parents.
pub trait Raise: Sync {
    /// The text of a child with some values, and what is new about it; `None` where nothing is.
    fn raise(&self, breeding: &Breeding, child: u64, genomes: [&Genome; 2]) -> Option<(Arc<str>, Change)>;

    /// Whether nobody waits for children any longer.
    fn is_over(&self) -> bool;
}

/// Leaves expressions as they are.
impl Raise for () {
    fn raise(&self, _: &Breeding, _: u64, _: [&Genome; 2]) -> Option<(Arc<str>, Change)> {
        None
    }

    fn is_over(&self) -> bool {
        false
    }
}

/// What is known about the texts of a script.
#[derive(Default)]
pub struct Nursery {
    kin: OnceLock<Kin>,
    genes: Mutex<HashMap<Option<Arc<str>>, Arc<Genes>>>,
}

/// A nursery at work, until it is told to stop.
pub struct Nurse<'a> {
    /// The script.
    pub subject: &'a Subject,
    /// What is known of it.
    pub nursery: &'a Nursery,
    /// Raised when nobody waits any longer.
    pub cancel: &'a Arc<AtomicBool>,
}

impl Raise for Nurse<'_> {
    fn raise(&self, breeding: &Breeding, child: u64, genomes: [&Genome; 2]) -> Option<(Arc<str>, Change)> {
        let [own, other] = genomes;
        let kin = self.nursery.kin.get_or_init(|| Kin::new(&crate::script::reference()));
        let [mine, others] = [own, other].map(|genome| self.genes(genome));
        let length = self.subject.text(&Genome::default()).map_or(0, str::len);
        let pair = Pair { own: &mine, other: &others, kin, length };
        let before = OnceCell::new();
        (0..ATTEMPTS).take_while(|_| !self.is_over()).find_map(|attempt| {
            let (text, change) = breeding.mutate(&pair, child, attempt)?;
            let text: Arc<str> = text.into();
            let after = self.look(&Genome { values: own.values.clone(), text: Some(text.clone()) })?;
            let before = before.get_or_init(|| self.look(own));
            let was_seen = before.as_ref().is_none_or(|b| b.seen > 0);
            // What is too thin for a glance has to be taken on trust.
            let is_fine = (after.seen > 0 || !was_seen) && Some(&after) != before.as_ref();
            is_fine.then_some((text, change))
        })
    }

    fn is_over(&self) -> bool {
        self.cancel.load(Ordering::SeqCst)
    }
}

impl Nurse<'_> {
    /// The genes of a text.
    fn genes(&self, genome: &Genome) -> Arc<Genes> {
        let all = || self.nursery.genes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = all().get(&genome.text) {
            return known.clone();
        }
        let genes = Arc::new(Genes::read(&self.subject.request(genome.text.as_ref(), self.cancel)));
        // What was given up may lack something.
        if !self.is_over() {
            all().insert(genome.text.clone(), genes.clone());
        }
        genes
    }

    /// What a script looks like, if it runs and has the parameters that it should have.
    fn look(&self, genome: &Genome) -> Option<Glance> {
        let loaded = self.subject.session(genome).load(self.cancel);
        let scene = loaded.scene.as_ref()?;
        let same =
            |a: &Param, b: &Param| (&a.name, &a.default, &a.domain) == (&b.name, &b.default, &b.domain);
        let params = self.subject.params();
        let has_all =
            scene.params.len() == params.len() && scene.params.iter().zip(params).all(|(a, b)| same(a, b));
        if has_all { self.glance(scene).ok() } else { None }
    }

    /// Looks along a few rays.
    fn glance(&self, scene: &Scene) -> Result<Glance, Box<Diagnostic>> {
        let (width, height, steps) = GLANCE;
        let view = View::new(&scene.camera, width, height)
            .map_err(|e| Box::new(Diagnostic::error(e.to_string())))?;
        let of = |node: NodeId| Field::new(&scene.graph, node);
        let mut field = of(scene.surface.field);
        let mut looks = Vec::new();
        looks.extend(scene.surface.color.into_iter().flatten().map(of));
        if let Some(material) = &scene.surface.material {
            // Only to see all of its fields.
            let _ = material.changed(|node| {
                looks.push(of(node));
                Ok::<_, ()>(node)
            });
        }
        let mut glance = Glance::default();
        let rest = (scene.camera, scene.sun, &scene.lights, scene.sky, &scene.film, &scene.surface.keep);
        glance.digest.text(&format!("{rest:?}"));
        let far = 1.5 * scene.camera.reach();
        for i in 0..width * height {
            if self.is_over() {
                return Err(crate::session::stopped());
            }
            let (x, y) = (f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
            let (origin, direction) = view.ray(x, y, [0.5; 2]);
            let clip = scene.bounds.map_or(Some((0.0, far)), |b| b.clip(origin, direction));
            let Some((near, far)) = clip.filter(|(_, far)| *far > 0.0) else { continue };
            let near = near.max(0.0);
            let mut is_out = false;
            for step in 0..=steps {
                // Points are closer to each other where the eye is near.
                let share = f64::from(step) / f64::from(steps);
                let p = origin + (near + (far - near) * share * share) * direction;
                let value = field.value(p);
                glance.note(value);
                if value < 0.0 && is_out {
                    glance.seen += 1;
                    looks.iter_mut().for_each(|f| glance.note(f.value(p)));
                    break;
                }
                is_out |= value > 0.0;
            }
        }
        Ok(glance)
    }
}

/// What there is to see of a scene, as far as a few rays tell.
#[derive(Clone, Debug, Default, PartialEq)]
struct Glance {
    /// Rays that come from outside to the inside.
    seen: u32,
    /// Everything that they met.
    digest: Digest,
}

impl Glance {
    /// Notes a number; what only rounding tells apart is the same.
    fn note(&mut self, value: f64) {
        self.digest.whole(u64::from((value as f32).to_bits()));
    }
}
