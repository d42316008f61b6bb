//! From a scene to samples of its field on a lattice of cubes.

use super::stage;
use crate::diag::Diagnostic;
use crate::field::Field;
use crate::field::Watch;
use crate::grid::{Edge, Frame, Samples};
use crate::num::Many;
use crate::scene::{Aabb, Scene, Spacing};
use crate::tape::{Evaluator, Tape};
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
}

impl Lattice {
    /// A lattice over the box that the scene gives, or that is found around its solid, with `size` points along
    /// the longest edge.
    ///
    /// # Errors
    /// A diagnostic if there would be too many samples, or the box or the expression is not fit for it.
    pub fn over(scene: &Scene, size: u32) -> Result<Lattice, Box<Diagnostic>> {
        let root = scene.surface.field;
        let Aabb { min, max } = stage::region(scene, &mut Field::new(&scene.graph, root));
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
        Ok(Lattice { frame, tape: Arc::new(Tape::new(&graph, &roots)) })
    }

    /// Where the samples lie.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The values of the field.
    ///
    /// # Errors
    /// A diagnostic if the job was stopped.
    pub fn sample(&self, watch: &Watch<'_>) -> Result<Samples, Box<Diagnostic>> {
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
        let samples = lattice.sample(&watch).unwrap();
        let mut field = Field::new(&scene.graph, scene.surface.field);
        for (i, value) in samples.values.iter().enumerate() {
            assert_eq!(*value, field.value(samples.frame.place(i).into()));
        }
        assert_eq!(samples.frame.size.iter().max(), Some(&21));
        assert_eq!(told.load(Ordering::Relaxed), samples.values.len() / samples.frame.size[0]);
        assert!(lattice.sample(&Watch { cancel: &AtomicBool::new(true), ..watch }).is_err());
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
            Lattice::over(&scene(&text(octaves)), 17).unwrap().sample(&watch).unwrap().values
        };
        assert_eq!(values(9), values(12));
        assert_ne!(values(1), values(9));
    }
}
