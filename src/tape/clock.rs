//! What the instructions of a tape cost, by the clock.
//!
//! An instruction takes some tens of nanoseconds, which is less than asking for the time. So each is executed over and
//! over, on the values that an evaluation left, and the shortest of a few such runs counts: whatever else the machine
//! does meanwhile only ever makes a run longer.

use super::{Evaluator, Instr, Tape};
use crate::num::Number;
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Runs of which the shortest counts,
const RUNS: u32 = 5;

/// each of as many executions as take so long, and no longer: the shorter a run, the likelier it is left alone.
const LONG: Duration = Duration::from_micros(2);

/// Seconds that each instruction takes at a point, or batch of points; constants take none.
pub fn seconds<T: Number>(tape: &Arc<Tape>, at: &[T; 3]) -> Vec<f64> {
    let mut evaluator = Evaluator::keeping_all(tape.clone());
    evaluator.eval(at);
    let of = |(i, instr): (usize, &Instr)| match instr {
        Instr::Const(_) | Instr::Coordinate(_) => 0.0,
        _ => time(|| evaluator.again(i, black_box(at))),
    };
    tape.code().iter().enumerate().map(of).collect()
}

/// Seconds that a whole evaluation takes, by machine code if there is any: less than its instructions one by one.
pub fn duration<T: Number>(tape: &Arc<Tape>, at: &[T; 3]) -> f64 {
    tape.translate();
    let mut evaluator = Evaluator::new(tape.clone());
    time(|| {
        evaluator.eval(black_box(at));
    })
}

/// Seconds that something takes.
fn time(mut once: impl FnMut()) -> f64 {
    let mut count = 1;
    let mut run = |count: u32| {
        let start = Instant::now();
        (0..count).for_each(|_| once());
        start.elapsed()
    };
    let mut shortest = run(count);
    while shortest < LONG {
        count *= 2;
        shortest = run(count);
    }
    for _ in 1..RUNS {
        shortest = shortest.min(run(count));
    }
    shortest.as_secs_f64() / f64::from(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Graph;
    use crate::noise::{Fractal, Kind, Model, Noise, Recipe};
    use crate::num::Many;
    use crate::op::{self, Op};

    #[test]
    fn what_is_computed_takes_time_and_coordinates_take_none() {
        let mut graph = Graph::default();
        let p = graph.point().unwrap();
        let recipe = Recipe { octaves: 8, ..Recipe::new(Noise::new(Kind::ALL[0].plain(), 7), Model::FBM) };
        let none = graph.constant(0.0).unwrap();
        let noise = graph.fractal(Arc::new(Fractal::new(recipe).unwrap()), p, none).unwrap();
        let root = graph.op(Op::Add(op::Add), &[noise, p[1]]).unwrap();
        let tape = Arc::new(Tape::new(&graph, &[root]));
        let taken = seconds(&tape, &[Many([0.3; 16]), Many([0.7; 16]), Many([0.1; 16])]);
        let of = |node| taken[tape.origins().iter().position(|id| *id == node).unwrap()];
        assert!(of(noise) > 0.0 && of(root) > 0.0 && taken.iter().all(|t| t.is_finite()), "{taken:?}");
        assert_eq!(of(p[0]), 0.0);
    }
}
