//! A field on a plane across an axis, and a function along a line: numbers for figures.

use super::{stage, whereabouts};
use crate::diag::Diagnostic;
use crate::field::{Field, Watch};
use crate::num::Many;
use crate::scene::{Aabb, Scene, Spacing};
use crate::tape::{Evaluator, Tape};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Points evaluated together.
const LANES: usize = 32;

/// The axes.
const NAMES: [&str; 3] = ["x", "y", "z"];

/// Room around a solid, as a share of its size.
const ROOM: f64 = 0.12;

/// Sides of a plane are no more different than that.
const LONGEST: f64 = 3.0;

/// A rectangle across an axis.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Plane {
    /// The axis that it is across: 0, 1 or 2.
    pub axis: usize,
    /// Where it crosses that axis.
    pub offset: f64,
    /// Its ends to the right and upwards.
    pub ends: [(f64, f64); 2],
}

impl Plane {
    /// A rectangle around the solid of a scene.
    pub fn around(scene: &Scene, axis: usize, offset: f64) -> Plane {
        let Aabb { min, max } = whereabouts::region(scene, &Field::new(&scene.graph, scene.surface.field));
        let mut plane = Plane { axis, offset, ends: [(0.0, 0.0); 2] };
        let sides = plane.axes();
        let longest = sides.map(|side| max[side] - min[side]).into_iter().fold(0.0, f64::max);
        let longest = if longest > 0.0 && longest.is_finite() { longest } else { 2.0 };
        plane.ends = sides.map(|side| {
            let middle = 0.5 * (min[side] + max[side]);
            let half = 0.5 * (max[side] - min[side]).max(longest / LONGEST) + 0.5 * ROOM * longest;
            (middle - half, middle + half)
        });
        plane
    }

    /// The axes to the right and upwards.
    fn axes(&self) -> [usize; 2] {
        [[2, 1], [0, 2], [0, 1]][self.axis.min(2)]
    }

    /// Their names.
    pub fn labels(&self) -> [&'static str; 2] {
        self.axes().map(|axis| NAMES[axis])
    }

    /// The name of the axis that it is across.
    pub fn name(&self) -> &'static str {
        NAMES[self.axis.min(2)]
    }

    /// How many rows there are to a column.
    pub fn aspect(&self) -> f64 {
        let [x, y] = self.ends.map(|(low, high)| high - low);
        y / x
    }

    /// The field of a scene at the middles of so many columns and rows, row by row from the top. Detail that is
    /// finer than these fades out.
    ///
    /// # Errors
    /// A diagnostic if the job was stopped, or the expression has no room.
    pub fn sample(
        &self,
        scene: &Scene,
        (columns, rows): (u32, u32),
        watch: &Watch<'_>,
    ) -> Result<Vec<f64>, Box<Diagnostic>> {
        if columns == 0 || rows == 0 {
            return Ok(Vec::new());
        }
        let [across, up] = self.ends;
        let middle =
            |(low, high): (f64, f64), i: usize, n: u32| low + (high - low) * (i as f64 + 0.5) / f64::from(n);
        let step = (across.1 - across.0) / f64::from(columns);
        let (graph, roots) = Spacing::Even(step)
            .limit(&scene.graph, &[scene.surface.field])
            .map_err(|e| Diagnostic::error(e.to_string()))?;
        let tape = Arc::new(Tape::new(&graph, &roots));
        let width = columns as usize;
        let xs: Vec<f64> = (0..width).map(|i| middle(across, i, columns)).collect();
        let offset = vec![self.offset; width];
        let mut values = vec![0.0; width * rows as usize];
        let done = AtomicUsize::new(0);
        let evaluator = || Evaluator::<Many<f64, LANES>>::new(tape.clone());
        values.par_chunks_mut(width).enumerate().try_for_each_init(evaluator, |field, (row, values)| {
            watch.check().map_err(|_| stage::stopped())?;
            let height = vec![middle(up, rows as usize - 1 - row, rows); width];
            let mut at = [&offset[..]; 3];
            let [right, upwards] = self.axes();
            (at[right], at[upwards]) = (&xs, &height);
            field.eval_all(at, values);
            (watch.progress)((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / f64::from(rows));
            Ok::<(), Box<Diagnostic>>(())
        })?;
        Ok(values)
    }
}

/// A function of the first coordinate at so many places, the ends among them, each with its value.
///
/// # Errors
/// A diagnostic if the job was stopped.
pub fn along(
    tape: &Arc<Tape>,
    (from, to): (f64, f64),
    count: usize,
    watch: &Watch<'_>,
) -> Result<Vec<(f64, f64)>, Box<Diagnostic>> {
    let last = count.max(2) - 1;
    let places: Vec<f64> = (0..=last).map(|i| from + (to - from) * (i as f64 / last as f64)).collect();
    let mut values = vec![0.0; places.len()];
    let (mut field, zeros) = (Evaluator::<Many<f64, LANES>>::new(tape.clone()), [0.0; LANES]);
    for (places, values) in places.chunks(LANES).zip(values.chunks_mut(LANES)) {
        watch.check().map_err(|_| stage::stopped())?;
        field.eval_all([places, &zeros, &zeros], values);
    }
    Ok(places.into_iter().zip(values).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::{Request, compile};
    use std::sync::atomic::AtomicBool;

    fn watch(cancel: &AtomicBool) -> Watch<'_> {
        Watch { cancel, progress: &|_| () }
    }

    #[test]
    fn planes_lie_around_the_solid_and_are_the_right_way_up() {
        let scene = compile(&Request::text("box([1.0, 2.0, 0.5]).translated([0, 1, 0])")).scene.unwrap();
        let still = AtomicBool::new(false);
        for axis in 0..3 {
            let plane = Plane::around(&scene, axis, 0.25);
            assert!((0.3..=3.1).contains(&plane.aspect()), "{plane:?}");
            let values = plane.sample(&scene, (20, 30), &watch(&still)).unwrap();
            let [across, up] = plane.ends;
            let mut field = Field::new(&scene.graph, scene.surface.field);
            for (row, column) in [(0, 0), (29, 19), (7, 13)] {
                let mut p = glam::DVec3::splat(0.25);
                let [right, upwards] = plane.axes();
                p[right] = across.0 + (across.1 - across.0) * (column as f64 + 0.5) / 20.0;
                p[upwards] = up.1 - (up.1 - up.0) * (row as f64 + 0.5) / 30.0;
                assert!((values[row * 20 + column] - field.value(p)).abs() < 1e-12, "{axis} {row} {column}");
            }
        }
    }

    #[test]
    fn lines_have_both_ends_and_stop_when_told() {
        let scene = compile(&Request::text("x ** 2 - 1.0")).scene.unwrap();
        let tape = Arc::new(Tape::new(&scene.graph, &[scene.surface.field]));
        let points = along(&tape, (-2.0, 2.0), 101, &watch(&AtomicBool::new(false))).unwrap();
        assert_eq!((points.len(), points[0], points[100]), (101, (-2.0, 3.0), (2.0, 3.0)));
        assert!(points.iter().all(|(x, y)| *y == x * x - 1.0));
        let stopped = AtomicBool::new(true);
        assert!(along(&tape, (0.0, 1.0), 9, &watch(&stopped)).is_err());
        let plane = Plane::around(&scene, 2, 0.0);
        assert!(plane.sample(&scene, (9, 9), &watch(&stopped)).is_err());
    }
}
