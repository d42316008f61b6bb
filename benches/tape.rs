//! Bulk evaluation of tapes against plain Rust: `cargo bench --bench tape` prints a markdown table of
//! nanoseconds a point on one core, and of how much of the hand-written speed a tape reaches.
//!
//! Both evaluate the same formula over the same arrays of coordinates, and must give the same bits; tapes
//! have become machine code after the first rounds, where the vectors are AVX2 or AVX-512. The
//! Rust is a loop over slices that the compiler vectorises, for the instruction set that tapes use too.
//! They take turns, and the least time of many repeats counts. The planets differ in the last bits, since
//! a fractal adds up how far its octaves are from their means.

#[path = "../tests/common/mod.rs"]
mod common;

use common::Build;
use orogen::expr::NodeId;
use orogen::noise::{Fractal, Gradient, Hurst, Kind, Model, Noise, Recipe};
use orogen::num::{Jets, Kernel, Level, Many, limit_simd, mix, simd_level, widest};
use orogen::op::{self, Op};
use orogen::tape::{Evaluator, Tape};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const POINTS: usize = 4096;
const REPEATS: usize = 100;
/// Where in memory the arrays lie matters to either side, by up to a factor of two for a short formula, and
/// is another with every run; so the least time is of several places.
const PLACES: usize = 8;
const LANES: usize = 256;

type Points = [Vec<f64>; 3];

fn points() -> Points {
    let mut next = random();
    std::array::from_fn(|_| (0..POINTS).map(|_| 4.0 * next() - 2.0).collect())
}

/// Numbers from 0 to 1.
fn random() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A loop over slices.
fn each(at: &Points, out: &mut [f64], f: impl Fn(f64, f64, f64) -> f64) {
    widest(
        #[inline(always)]
        || {
            let [x, y, z] = at.each_ref().map(|a| &a[..out.len()]);
            for i in 0..out.len() {
                out[i] = f(x[i], y[i], z[i]);
            }
        },
    );
}

/// `((x^4 - 5 x^2) + (y^4 - 5 y^2)) + (z^4 - 5 z^2) + 10`, joined with a slab and cut by another.
fn algebraic(b: &mut Build) -> NodeId {
    let [x, y, z] = b.p();
    let quartic = [x, y, z].map(|x| {
        let square = b.op(Op::Square(op::Square), &[x]);
        let fourth = b.op(Op::Square(op::Square), &[square]);
        let five = b.scaled(5.0, square);
        b.sub(fourth, five)
    });
    let sum = b.add(quartic[0], quartic[1]);
    let sum = b.add(sum, quartic[2]);
    let tangle = b.shifted(sum, 10.0);
    let xy = b.op(Op::Mul(op::Mul), &[x, y]);
    let slab = b.shifted(xy, -0.25);
    let joined = b.min(tangle, slab);
    let below = b.shifted(y, -1.5);
    b.max(joined, below)
}

fn algebraic_by_hand(at: &Points, out: &mut [f64]) {
    each(
        at,
        out,
        #[inline(always)]
        |x, y, z| {
            let quartic = |x: f64| (x * x) * (x * x) - (x * x) * 5.0;
            let tangle = quartic(x) + quartic(y) + quartic(z) + 10.0;
            let slab = x * y - 0.25;
            let joined = if tangle < slab { tangle } else { slab };
            let below = y - 1.5;
            if joined > below { joined } else { below }
        },
    );
}

const RELIEF: f64 = 0.05;
const LACUNARITY: f64 = 2.1;
const HURST: f64 = 0.9;
const OCTAVES: i32 = 9;
const BASE: f64 = 4.0;

fn noise() -> Noise {
    Noise::new(Kind::Gradient(Gradient::EDGES), 7).at_frequency(BASE)
}

/// A unit sphere less nine octaves of ridges on it.
fn planet(b: &mut Build) -> NodeId {
    let p = b.p();
    let length = b.op(Op::Length(op::Length), &p);
    let on_sphere = p.map(|x| b.op(Op::Div(op::Div), &[x, length]));
    let recipe = Recipe {
        octaves: OCTAVES as u32,
        lacunarity: LACUNARITY,
        hurst: Hurst::uniform(HURST),
        ..Recipe::new(noise(), Model::RIDGED)
    };
    let fractal = Arc::new(Fractal::new(recipe).expect("a valid recipe"));
    let zero = b.num(0.0);
    let ridges = b.0.fractal(fractal, on_sphere, zero).expect("a small graph");
    let relief = b.scaled(RELIEF, ridges);
    let ball = b.shifted(length, -1.0);
    b.sub(ball, relief)
}

fn planet_by_hand(at: &Points, out: &mut [f64]) {
    let octaves: Vec<(Noise, f64)> = (0..OCTAVES)
        .map(|i| {
            let mut noise = noise();
            if i > 0 {
                noise.lattice.seed = mix(noise.lattice.seed ^ mix(i as u64));
            }
            let scale = libm::pow(LACUNARITY, f64::from(i));
            noise.frequency *= scale;
            (noise, libm::pow(scale, -HURST))
        })
        .collect();
    for start in (0..out.len()).step_by(LANES) {
        let [x, y, z] = at.each_ref().map(|a| &a[start..start + LANES]);
        let (mut length, mut p, mut value) = ([0.0; LANES], [[0.0; LANES]; 3], [0.0; LANES]);
        let mut sum = [0.0; LANES];
        widest(
            #[inline(always)]
            || {
                for i in 0..LANES {
                    length[i] = (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt();
                    p[0][i] = x[i] / length[i];
                    p[1][i] = y[i] / length[i];
                    p[2][i] = z[i] / length[i];
                }
            },
        );
        for (noise, amplitude) in &octaves {
            let to = Jets { value: &mut value, grad: None, hess: None };
            noise.jets([&p[0], &p[1], &p[2]], to);
            widest(
                #[inline(always)]
                || {
                    for i in 0..LANES {
                        let ridge = 1.0 - value[i].abs();
                        let ridge = if ridge > 0.0 { ridge } else { 0.0 };
                        sum[i] += amplitude * (ridge * ridge);
                    }
                },
            );
        }
        let out = &mut out[start..start + LANES];
        widest(
            #[inline(always)]
            || {
                for i in 0..LANES {
                    out[i] = (length[i] - 1.0) - RELIEF * sum[i];
                }
            },
        );
    }
}

/// A ball or a box.
#[derive(Clone, Copy)]
enum Part {
    Ball([f64; 3], f64),
    Block([f64; 3], [f64; 3]),
}

/// A hundred balls and as many boxes, in turns.
fn parts() -> Vec<Part> {
    let mut next = random();
    (0..200)
        .map(|i| {
            let c = std::array::from_fn(|_| 4.0 * next() - 2.0);
            let mut size = || 0.1 + 0.2 * next();
            if i % 2 == 0 { Part::Ball(c, size()) } else { Part::Block(c, [size(), size(), size()]) }
        })
        .collect()
}

fn union(b: &mut Build) -> NodeId {
    let p = b.p();
    let part = |b: &mut Build, part: Part| match part {
        Part::Ball(c, r) => b.sphere(c, r),
        Part::Block(c, half) => {
            let [x, y, z] = std::array::from_fn(|i| {
                let from = b.shifted(p[i], -c[i]);
                let size = b.op(Op::Abs(op::Abs), &[from]);
                b.shifted(size, -half[i])
            });
            let xy = b.max(x, y);
            b.max(xy, z)
        }
    };
    let all: Vec<NodeId> = parts().into_iter().map(|p| part(b, p)).collect();
    all[1..].iter().fold(all[0], |union, part| b.min(union, *part))
}

/// Part by part over a batch of points at a time, which the compiler vectorises.
fn union_by_hand(parts: &[Part], at: &Points, out: &mut [f64]) {
    let max = |a: f64, b: f64| if a > b { a } else { b };
    widest(
        #[inline(always)]
        || {
            for start in (0..out.len()).step_by(LANES) {
                let [x, y, z] = at.each_ref().map(|a| &a[start..start + LANES]);
                let mut least = [f64::INFINITY; LANES];
                for part in parts {
                    match *part {
                        Part::Ball([a, b, c], r) => {
                            for i in 0..LANES {
                                let (u, v, w) = (x[i] - a, y[i] - b, z[i] - c);
                                let d = (u * u + v * v + w * w).sqrt() - r;
                                least[i] = if least[i] < d { least[i] } else { d };
                            }
                        }
                        Part::Block([a, b, c], [j, k, l]) => {
                            for i in 0..LANES {
                                let (u, v, w) =
                                    ((x[i] - a).abs() - j, (y[i] - b).abs() - k, (z[i] - c).abs() - l);
                                let d = max(max(u, v), w);
                                least[i] = if least[i] < d { least[i] } else { d };
                            }
                        }
                    }
                }
                out[start..start + LANES].copy_from_slice(&least);
            }
        },
    );
}

/// Least times of two jobs that take turns, in nanoseconds a point.
fn race(mut first: impl FnMut(), mut second: impl FnMut()) -> [f64; 2] {
    let mut best = [f64::INFINITY; 2];
    let mut clock = |lane: usize, job: &mut dyn FnMut()| {
        let start = Instant::now();
        job();
        best[lane] = best[lane].min(start.elapsed().as_secs_f64());
    };
    for _ in 0..REPEATS {
        clock(0, &mut first);
        clock(1, &mut second);
    }
    best.map(|t| t * 1e9 / POINTS as f64)
}

fn row(name: &str, root: impl Fn(&mut Build) -> NodeId, by_hand: impl Fn(&Points, &mut [f64])) {
    let mut b = Build::default();
    let root = root(&mut b);
    let tape = Arc::new(Tape::new(&b.0, &[root]));
    let count = tape.len();
    let mut evaluator = Evaluator::<Many<f64, LANES>>::new(tape);
    let (mut ours, mut theirs) = (vec![0.0; POINTS], vec![0.0; POINTS]);
    let (mut all, mut best) = (Vec::new(), [f64::INFINITY; 2]);
    for _ in 0..PLACES {
        let at = points();
        let times = race(
            || evaluator.eval_all(black_box(&at).each_ref().map(|at| &at[..]), &mut ours),
            || by_hand(black_box(&at), &mut theirs),
        );
        best = std::array::from_fn(|k| best[k].min(times[k]));
        all.push((at, ours.clone(), theirs.clone())); // the next are elsewhere
        (ours, theirs) = (vec![0.0; POINTS], vec![0.0; POINTS]);
    }
    let [tape, hand] = best;
    let Some((_, ours, theirs)) = all.last() else { return };
    let differ = ours.iter().zip(theirs).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    let off = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!(
        "| {name} | {count} | {tape:.2} | {hand:.2} | {:.0} % | {differ}, {off:.0e} |",
        100.0 * hand / tape
    );
}

fn main() {
    let machine = simd_level();
    for level in [Level::Avx512, Level::Avx2, Level::Baseline].into_iter().filter(|&l| l <= machine) {
        limit_simd(level);
        println!(
            "| {level:?}, ns a point | instructions | tape | by hand | reached | points that differ, by |"
        );
        println!("|---|---|---|---|---|---|");
        row("algebraic", algebraic, algebraic_by_hand);
        row("planet, 9 octaves", planet, planet_by_hand);
        let parts = parts();
        row("200 balls and boxes", union, |at, out| union_by_hand(&parts, at, out));
        println!();
    }
}
