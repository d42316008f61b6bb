//! Machine code gives the bits of the interpreter: every operation, random composites, any width of
//! vectors and batches, and numbers of every kind. The reference is one number at a time, which is always
//! interpreted. Seeds are fixed.

mod common;

use common::Build;
use orogen::expr::NodeId;
use orogen::noise::{Gradient, Kind, Noise};
use orogen::num::{Level, Many, limit_simd};
use orogen::op::{self, Op};
use orogen::tape::{Evaluator, Tape};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::sync::{Arc, Mutex, PoisonError};

/// Runs a test with vectors of every width that this machine has. One at a time: the width is that of the
/// whole process.
fn at_every_level(test: impl Fn(Level)) {
    static ALONE: Mutex<()> = Mutex::new(());
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    for level in [Level::Baseline, Level::Avx2, Level::Avx512] {
        if limit_simd(level) == level {
            test(level);
        }
    }
    limit_simd(Level::Avx512);
}

/// A tape, translated where machines can be.
fn tape(b: &Build, roots: &[NodeId], level: Level) -> Arc<Tape> {
    let tape = Tape::new(&b.0, roots);
    let is_all_given = tape.code().iter().all(|i| matches!(i, orogen::tape::Instr::Const(_)));
    assert_eq!(tape.translate(), level > Level::Baseline && !is_all_given, "at {level:?}");
    Arc::new(tape)
}

/// Numbers of which some are of the kinds that arithmetic treats in its own way.
#[derive(Clone, Copy, Debug)]
enum Sort {
    Tame,
    Extreme,
    Undefined,
}

const SORTS: [Sort; 3] = [Sort::Tame, Sort::Extreme, Sort::Undefined];

fn number(rng: &mut StdRng, sort: Sort) -> f64 {
    const EXTREME: [f64; 10] =
        [0.0, -0.0, 1.0, -1.0, 0.5, f64::MIN_POSITIVE, -5e-324, 1e300, f64::INFINITY, f64::NEG_INFINITY];
    match (sort, rng.random_range(0..8)) {
        (Sort::Undefined, 0) => f64::NAN,
        (Sort::Extreme | Sort::Undefined, 0..5) => EXTREME[rng.random_range(0..EXTREME.len())],
        (Sort::Tame, 0) => f64::from(rng.random_range(-3..=3)),
        _ => rng.random_range(-3.0..3.0),
    }
}

fn is_same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// Checks a tape on batches of one width.
fn check<const B: usize>(tape: &Arc<Tape>, rng: &mut StdRng) {
    let mut one = Evaluator::<f64>::new(tape.clone());
    for sort in SORTS {
        let p: [Many<f64, B>; 3] = std::array::from_fn(|_| Many(std::array::from_fn(|_| number(rng, sort))));
        // Each anew: where there was a NaN, an evaluator leaves machine code alone for a while.
        let mut many = Evaluator::<Many<f64, B>>::new(tape.clone());
        many.eval(&p);
        for lane in 0..B {
            let at = p.map(|p| p.0[lane]);
            one.eval(&at);
            for k in 0..tape.outputs() {
                let (a, b) = (one.output(k), many.output(k).0[lane]);
                let code = tape.code();
                assert!(is_same(*a, b), "output {k} at {at:?} of {B}, {sort:?}: {a:e} and {b:e}\n{code:#?}");
            }
        }
    }
}

/// The same for widths that vectors fit into, and for some that they do not.
fn check_all(tape: &Arc<Tape>, rng: &mut StdRng) {
    check::<3>(tape, rng);
    check::<4>(tape, rng);
    check::<8>(tape, rng);
    check::<64>(tape, rng);
    check::<256>(tape, rng);
}

#[test]
fn every_operation_alone() {
    at_every_level(|level| {
        let mut rng = StdRng::seed_from_u64(1);
        let powers = (-5..=9).map(|n| Op::Powi(op::Powi { n }));
        for op in Op::ALL.iter().copied().chain(powers) {
            let is_plain = !matches!(
                op.name(),
                "pow" | "exp" | "ln" | "sin" | "cos" | "tan" | "asin" | "acos" | "atan" | "atan2"
            );
            for round in 0..4 {
                let mut b = Build::default();
                let [x, y, z] = b.p();
                let half = b.num(0.5);
                let pool = [x, y, z, half, y, x];
                // Arguments in any order, some the same, some known.
                let args: Vec<NodeId> = (0..op.arity()).map(|i| pool[(i + round) % pool.len()]).collect();
                let root = b.op(op, &args);
                let tape = Tape::new(&b.0, &[root]);
                if is_plain {
                    assert!(tape.translate() || level == Level::Baseline || tape.len() == 1, "{}", op.name());
                }
                check_all(&Arc::new(tape), &mut rng);
            }
        }
    });
}

/// An expression of random operations on what is there already, early or late.
fn composite(rng: &mut StdRng, steps: usize) -> (Build, Vec<NodeId>) {
    let mut b = Build::default();
    let mut pool = b.p().to_vec();
    pool.extend([-1.5, 0.0, 2.0].map(|c| b.num(c)));
    for _ in 0..steps {
        let any = |rng: &mut StdRng| {
            let recent = rng.random_bool(0.5) as usize * pool.len().saturating_sub(6);
            pool[rng.random_range(recent..pool.len())]
        };
        let node = match rng.random_range(0..24) {
            0 => {
                let p = std::array::from_fn(|_| any(rng));
                let noise = Noise::new(Kind::Gradient(Gradient::EDGES), 7);
                b.0.noise(noise, p).expect("a small graph")
            }
            1..6 => {
                let (k, a) = (rng.random_range(-2.0..2.0), any(rng));
                if rng.random_bool(0.5) { b.scaled(k, a) } else { b.shifted(a, k) }
            }
            _ => {
                let op = Op::ALL[rng.random_range(0..Op::ALL.len())];
                let args: Vec<NodeId> = (0..op.arity()).map(|_| any(rng)).collect();
                b.op(op, &args)
            }
        };
        pool.push(node);
    }
    let mut roots = vec![pool[pool.len() - 1]];
    roots.extend((0..rng.random_range(0..4)).map(|_| pool[rng.random_range(0..pool.len())]));
    (b, roots)
}

#[test]
fn random_composites() {
    at_every_level(|_| {
        let mut rng = StdRng::seed_from_u64(2);
        for round in 0..300 {
            let (b, roots) = composite(&mut rng, 1 + round % 60);
            let tape = Arc::new(Tape::new(&b.0, &roots));
            tape.translate();
            check::<8>(&tape, &mut rng);
            check::<64>(&tape, &mut rng);
        }
    });
}

#[test]
fn more_values_at_a_time_than_registers() {
    at_every_level(|level| {
        let mut rng = StdRng::seed_from_u64(3);
        for count in [10, 14, 17, 30, 33, 100] {
            let mut b = Build::default();
            let [x, y, z] = b.p();
            let products = [(x, y), (y, z), (z, x)].map(|(u, v)| b.op(Op::Mul(op::Mul), &[u, v]));
            let all: Vec<NodeId> = (0..count)
                .map(|i| {
                    let scaled = b.scaled(f64::from(i) + 0.25, products[i as usize % 3]);
                    b.add(scaled, [x, y, z][i as usize / 3 % 3])
                })
                .collect();
            // All are needed in their order, and again in the other.
            let there = all[1..].iter().fold(all[0], |sum, v| b.sub(sum, *v));
            let back = all.iter().rev().fold(there, |least, v| b.min(least, *v));
            // One by one others take their places.
            let others: Vec<NodeId> = all.iter().rev().map(|v| b.sub(there, *v)).collect();
            let most = others.iter().fold(back, |most, v| b.max(*v, most));
            let root = others.iter().rev().fold(most, |sum, v| b.add(*v, sum));
            check_all(&tape(&b, &[root, back, all[0]], level), &mut rng);
        }
    });
}

#[test]
fn runs_between_other_instructions() {
    at_every_level(|level| {
        let mut rng = StdRng::seed_from_u64(4);
        let mut b = Build::default();
        let [x, y, z] = b.p();
        let before: Vec<NodeId> = (0..12).map(|i| b.scaled(f64::from(i) - 5.5, x)).collect();
        let sine = b.op(Op::Sin(op::Sin), &[before[3]]);
        let noise = b.noise(7, 2.0);
        let mixed = b.op(Op::Mix(op::Mix), &[sine, noise, y]);
        let root = before.iter().fold(mixed, |f, v| b.max(f, *v));
        let length = b.op(Op::Length(op::Length), &[root, y, z]);
        check_all(&tape(&b, &[length, mixed, sine, before[3], root], level), &mut rng);
    });
}

#[test]
fn outputs_that_are_given() {
    at_every_level(|level| {
        let mut rng = StdRng::seed_from_u64(5);
        let mut b = Build::default();
        let [x, y, z] = b.p();
        let seven = b.num(7.0);
        let sum = b.add(x, y);
        check_all(&tape(&b, &[seven, z, sum, z, seven], level), &mut rng);
        check_all(&tape(&b, &[y], level), &mut rng);
        check_all(&tape(&b, &[seven], level), &mut rng);
    });
}

#[test]
fn slices_of_any_length() {
    at_every_level(|level| {
        let mut rng = StdRng::seed_from_u64(6);
        let mut b = Build::default();
        let ball = b.sphere([0.1, 0.2, 0.3], 1.0);
        let noise = b.noise(7, 2.0);
        let [x, y, _] = b.p();
        let (bumpy, cut) = (b.add(ball, noise), b.max(ball, x));
        // Constants and more values than registers, read there and back.
        let half = b.num(0.5);
        let many: Vec<NodeId> = (0..40).map(|i| b.scaled(f64::from(i) + 0.5, x)).collect();
        let many: Vec<NodeId> = many.into_iter().map(|v| b.op(Op::Div(op::Div), &[half, v])).collect();
        let there = many[1..].iter().fold(many[0], |sum, v| b.sub(sum, *v));
        let crowd = many.iter().rev().fold(there, |least, v| b.min(least, *v));
        for root in [ball, bumpy, cut, y, crowd] {
            let tape = tape(&b, &[root], level);
            for (count, sort) in [0, 1, 7, 64, 1000, 1024, 1032, 5000].into_iter().zip(SORTS.iter().cycle()) {
                let at: [Vec<f64>; 3] =
                    std::array::from_fn(|_| (0..count + 3).map(|_| number(&mut rng, *sort)).collect());
                let mut out = vec![0.5; count];
                let mut many = Evaluator::<Many<f64, 64>>::new(tape.clone());
                // Not where vectors begin.
                many.eval_all(at.each_ref().map(|at| &at[3..]), &mut out);
                let mut one = Evaluator::<f64>::new(tape.clone());
                for (i, out) in out.iter().enumerate() {
                    let expected = *one.eval(&at.each_ref().map(|at| at[3 + i]));
                    assert!(is_same(*out, expected), "{i} of {count}: {out:e} and {expected:e}");
                }
                // What no coordinates are given for stays as it was.
                let mut beyond = vec![0.5; count + 9];
                many.eval_all(at.each_ref().map(|at| &at[3..]), &mut beyond);
                assert!(beyond.iter().zip(&out).all(|(a, b)| is_same(*a, *b)));
                assert!(beyond[count..].iter().all(|v| *v == 0.5));
            }
        }
    });
}

#[test]
fn values_stay_the_same_while_a_tape_becomes_machine_code() {
    at_every_level(|_| {
        let mut b = Build::default();
        let root = common::three_octaves(&mut b);
        let cut = b.sphere([0.5, 0.5, 0.0], 0.7);
        let root = b.max(root, cut);
        let mut many = Evaluator::<Many<f64, 64>>::new(Arc::new(Tape::new(&b.0, &[root])));
        let p = [0.01, 0.02, 0.03].map(|k| Many(std::array::from_fn(|i| k * i as f64)));
        let first = many.eval(&p).0.map(f64::to_bits);
        for _ in 0..1000 {
            assert_eq!(many.eval(&p).0.map(f64::to_bits), first);
        }
    });
}
