//! From a scene to samples of its field on a lattice of cubes.

use super::topology::Sieve;
use super::{stage, whereabouts};
use crate::diag::Diagnostic;
use crate::field::Field;
use crate::field::Watch;
use crate::grid::{Edge, Frame, Samples};
use crate::num::Many;
use crate::scene::{Aabb, Scene, Spacing, Surface};
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Points evaluated together.
const LANES: usize = 32;

/// Where a field is to be sampled, and the field with its detail limited to that.
#[derive(Clone, Debug)]
pub struct Lattice {
    frame: Frame,
    tape: Arc<Tape>,
    scene: Scene,
    /// The scene with its detail limited likewise, and bounds that hold the lattice.
    limited: Scene,
}

/// Samples of what a scene keeps of its solid.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// The values of the field, negative inside. Inside of what is not kept they have the other sign.
    pub samples: Samples,
    /// How many of them that are.
    pub left_out: u64,
    /// What is not proven about what is kept.
    pub warnings: Vec<Diagnostic>,
}

/// Shares of the work at which it is known how to tell what is kept, and at which there are samples, about.
const CORRECTION: [f64; 2] = [0.6, 0.8];

impl Lattice {
    /// A lattice over the box that the scene gives, or that is found around its solid, with `size` points along
    /// the longest edge.
    ///
    /// # Errors
    /// A diagnostic if there would be too many samples, or the box or the expression is not fit for it.
    pub fn over(scene: &Scene, size: u32) -> Result<Lattice, Box<Diagnostic>> {
        let root = scene.surface.field;
        let Aabb { min, max } = whereabouts::region(scene, &Field::new(&scene.graph, root));
        let step = (max - min).max_element() / f64::from(size.max(2) - 1);
        // The last sample along the longest edge is its end, whatever rounding says.
        let count = ((max - min) / step - 1e-9).ceil().to_array().map(|n| n as usize + 1);
        let frame = Frame { size: count, origin: min.to_array(), spacing: [step; 3], edge: Edge::Clamp };
        let frame = frame
            .checked()
            .map_err(|e| Diagnostic::error(e.to_string()).hint("choose a smaller --size, or other bounds"))?;
        // Octaves that are finer than the lattice can show fade out.
        let (graph, roots) =
            Spacing::Even(step).limit(&scene.graph, &[root]).map_err(|e| Diagnostic::error(e.to_string()))?;
        let tape = Arc::new(Tape::new(&graph, &roots));
        let surface = Surface { field: roots[0], ..scene.surface.clone() };
        // Samples may lie beyond the box by up to a step.
        let end = min + step * DVec3::from_array(count.map(|n| n as f64));
        let bounds = Some(Aabb { min: min - step, max: end });
        let limited = Scene { graph, surface, bounds, ..scene.clone() };
        Ok(Lattice { frame, tape, scene: scene.clone(), limited })
    }

    /// Where the samples lie.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Samples of what the scene keeps of its solid. What that is, is decided of the solid with its detail limited.
    ///
    /// # Errors
    /// A diagnostic if the job was stopped, or it is not known what is kept.
    pub fn sample(&self, watch: &Watch<'_>) -> Result<Sampled, Box<Diagnostic>> {
        let [begun, done] = if self.scene.surface.keep.is_some() { CORRECTION } else { [0.0, 1.0] };
        let sieve = watch.part(0.0, begun, |watch| Sieve::of(&self.limited, &self.scene, watch))?;
        let mut samples = watch.part(begun, done, |watch| self.values(watch))?;
        let (mut left_out, mut warnings) = (0, Vec::new());
        if let Some(sieve) = sieve {
            let inside: Vec<usize> = (0..samples.values.len()).filter(|&i| samples.values[i] < 0.0).collect();
            let points: Vec<DVec3> = inside.iter().map(|&i| self.frame.place(i).into()).collect();
            let rulings = watch.part(done, 1.0, |watch| sieve.rule(&points, watch))?;
            let unproven = rulings.iter().filter(|ruling| !ruling.proven).count();
            for (i, _) in inside.into_iter().zip(rulings).filter(|(_, ruling)| !ruling.kept) {
                samples.values[i] = -samples.values[i];
                left_out += 1;
            }
            warnings = sieve.warnings();
            if unproven > 0 {
                let of = points.len();
                let message = format!("of {unproven} of {of} samples it is not proven whether they are kept");
                warnings.push(Diagnostic::warning(message));
            }
        }
        Ok(Sampled { samples, left_out, warnings })
    }

    /// The values of the field.
    fn values(&self, watch: &Watch<'_>) -> Result<Samples, Box<Diagnostic>> {
        let frame = self.frame;
        let [width, rows] = [frame.size[0], frame.count() / frame.size[0]];
        let along: Vec<f64> = (0..width).map(|i| frame.place(i)[0]).collect();
        let mut values = vec![0.0; frame.count()];
        let done = AtomicUsize::new(0);
        let evaluator = || Evaluator::<Many<f64, LANES>>::new(self.tape.clone());
        values.par_chunks_mut(width).enumerate().try_for_each_init(evaluator, |field, (row, values)| {
            if watch.cancel.load(Ordering::Relaxed) {
                return Err(stage::stopped());
            }
            let [_, y, z] = frame.place(row * width);
            field.eval_all([&along, &vec![y; width], &vec![z; width]], values);
            (watch.progress)((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / rows as f64);
            Ok(())
        })?;
        Ok(Samples { frame, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::{Request, compile};
    use std::sync::atomic::AtomicBool;

    fn scene(text: &str) -> Arc<Scene> {
        Arc::new(compile(&Request::text(text)).scene.unwrap())
    }

    #[test]
    fn samples_are_the_values_of_the_field() {
        let scene = scene("sphere(1.0) + 0.2 * gradient(7).scaled(3.0)");
        let told = AtomicUsize::new(0);
        let watch = Watch {
            cancel: &AtomicBool::new(false),
            progress: &|share| {
                assert!(share > 0.0 && share <= 1.0);
                told.fetch_add(1, Ordering::Relaxed);
            },
        };
        let lattice = Lattice::over(&scene, 21).unwrap();
        let samples = lattice.sample(&watch).unwrap().samples;
        let mut field = Field::new(&scene.graph, scene.surface.field);
        for (i, value) in samples.values.iter().enumerate() {
            assert_eq!(*value, field.value(samples.frame.place(i).into()));
        }
        assert_eq!(samples.frame.size.iter().max(), Some(&21));
        assert_eq!(told.load(Ordering::Relaxed), samples.values.len() / samples.frame.size[0]);
        assert!(lattice.sample(&Watch { cancel: &AtomicBool::new(true), ..watch }).is_err());
    }

    /// Inside of what is not kept, values have the other sign; all others are as they were.
    #[test]
    fn what_is_not_kept_is_outside() {
        let two = "min(sphere(1.0), sphere(0.3).translated([1.6, 0, 0]))";
        let sampled = |text: &str| {
            let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
            Lattice::over(&scene(text), 40).unwrap().sample(&watch).unwrap()
        };
        let whole = sampled(two);
        assert_eq!((whole.left_out, whole.warnings.len()), (0, 0));
        for (keep, sign) in [("largest_component(f)", 1.0), ("component_of(f, [1.6, 0, 0])", -1.0)] {
            let kept = sampled(&format!("let f = {two}; {keep}"));
            let mut count = 0;
            for (i, value) in whole.samples.values.iter().enumerate() {
                let is_lost = *value < 0.0 && (1.15 - kept.samples.frame.place(i)[0]) * sign < 0.0;
                count += u64::from(is_lost);
                assert_eq!(kept.samples.values[i], if is_lost { -value } else { *value }, "{keep}");
            }
            assert_eq!(kept.left_out, count);
            assert!(count > 0, "{keep}");
        }
    }

    #[test]
    fn detail_finer_than_the_lattice_fades() {
        let text = |octaves: u32| {
            format!(
                "import \"std/fractal\" as fractal;
                 scene(#{{
                     surface: fractal::fbm(gradient(3), #{{ octaves: {octaves}, lacunarity: 2.0 }}) + 0.0 * x,
                     bounds: 1.0,
                 }})"
            )
        };
        let values = |octaves: u32| {
            let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
            Lattice::over(&scene(&text(octaves)), 17).unwrap().sample(&watch).unwrap().samples.values
        };
        assert_eq!(values(9), values(12));
        assert_ne!(values(1), values(9));
    }
}
