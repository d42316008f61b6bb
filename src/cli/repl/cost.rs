//! `:cost`: what an evaluation is made of, counted, and how fast it goes, measured.

use super::Shell;
use crate::cli::report::{Outcome, count, out};
use crate::field::Field;
use crate::num::{Interval, Many, mix, uniform};
use crate::scene::{Aabb, Scene};
use crate::session;
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How long each speed is measured.
const TIME: Duration = Duration::from_millis(150);
/// Places at which it is measured, the same every time.
const PLACES: usize = 4096;
/// Points evaluated together, as most of the program does it.
const LANES: usize = 32;

/// Counts and measures.
pub fn run(shell: &Shell, argument: Option<&str>) -> Outcome {
    let scene = shell.solid(argument)?;
    let root = scene.surface.field;
    let tape = Arc::new(Tape::new(&scene.graph, &[root]));
    let census = tape.census();
    let nodes = scene.graph.reachable(&[root]).len() as u64;
    out(row("nodes of the expression", nodes, ""));
    out(row("instructions", tape.len() as u64, "each run once for a point"));
    for (name, n) in [
        ("  sums, products with a number", census.sums),
        ("  functions", census.functions),
        ("  octaves of noise, grids, shapes", census.octaves),
        ("  of what flows carry", census.carried),
    ] {
        if n > 0 {
            out(row(name, n, ""));
        }
    }
    out(row("work", tape.work(), "in about as many sums"));
    let flag = shell.interrupt.flag();
    for (name, speed) in speeds(&scene, &tape, &flag) {
        // What was stopped was not measured.
        if !flag.load(Ordering::Relaxed) {
            out(row(name, speed as u64, "a second, measured on one thread"));
        }
    }
    Ok(())
}

fn row(name: &str, n: u64, unit: &str) -> String {
    format!("{name:<34} {:>15}  {unit}", count(n)).trim_end().to_owned()
}

/// Evaluations a second, of each kind.
fn speeds(scene: &Scene, tape: &Arc<Tape>, flag: &AtomicBool) -> [(&'static str, f64); 4] {
    let mut field = Field::of_tape(tape);
    let Aabb { min, max } = scene.bounds.unwrap_or_else(|| session::bounds(scene, &field));
    let points: Vec<DVec3> = (0..PLACES as u64)
        .map(|i| {
            let share = DVec3::from_array([0, 1, 2].map(|axis| uniform(mix(3 * i + axis))));
            min + (max - min) * share
        })
        .collect();
    let axes: [Vec<f64>; 3] = [0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).collect());
    let (mut batches, mut values) = (Evaluator::<Many<f64, LANES>>::new(tape.clone()), vec![0.0; PLACES]);
    let half = (max - min) / 64.0;
    let boxes: Vec<[Interval; 3]> = points
        .iter()
        .map(|p| std::array::from_fn(|axis| Interval::new(p[axis] - half[axis], p[axis] + half[axis])))
        .collect();
    let mut sum = 0.0;
    let speeds = [
        (
            "values, many at once",
            rate(flag, PLACES, |_| batches.eval_all(axes.each_ref().map(Vec::as_slice), &mut values)),
        ),
        ("values, one by one", rate(flag, 1, |i| sum += field.value(points[i % PLACES]))),
        ("gradients", rate(flag, 1, |i| sum += field.gradient(points[i % PLACES]).0)),
        ("enclosures over small boxes", rate(flag, 1, |i| sum += field.range(&boxes[i % PLACES]).lo)),
    ];
    // What nobody asks for need not be computed.
    std::hint::black_box((sum, values));
    speeds
}

/// How often something is done in a second, if `step` does it so many times.
fn rate(flag: &AtomicBool, count: usize, mut step: impl FnMut(usize)) -> f64 {
    // Machine code is made when a tape has been evaluated for a while.
    (0..64).take_while(|_| !flag.load(Ordering::Relaxed)).for_each(&mut step);
    let (start, mut steps) = (Instant::now(), 0);
    while start.elapsed() < TIME && !flag.load(Ordering::Relaxed) {
        for _ in 0..16 {
            step(steps);
            steps += 1;
        }
    }
    (steps * count) as f64 / start.elapsed().as_secs_f64().max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::{Request, compile};

    #[test]
    fn speeds_are_measured_unless_stopped() {
        let scene = compile(&Request::text("sphere(1.0)")).scene.unwrap();
        let tape = Arc::new(Tape::new(&scene.graph, &[scene.surface.field]));
        let still = AtomicBool::new(false);
        assert!(speeds(&scene, &tape, &still).iter().all(|(_, speed)| *speed > 1000.0));
        let start = Instant::now();
        speeds(&scene, &tape, &AtomicBool::new(true));
        assert!(start.elapsed() < TIME);
    }

    #[test]
    fn counts_stand_in_columns() {
        assert_eq!(
            row("work", 1234, "in about as many sums").find("1 234"),
            row("nodes", 5678, "").find("5 678")
        );
    }
}
