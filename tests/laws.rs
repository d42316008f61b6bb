//! The laws of DESIGN, run over every operation: samples lie inside every enclosure, smaller boxes
//! never widen a range, derivatives match differences, batches equal single numbers bit for bit.
//!
//! Every law takes the tour of the operation list, so an operation that is added is tested by being
//! there. Seeds are fixed.

#![allow(clippy::disallowed_methods)] // boxes of random size need not be the same on every platform

use orogen::expr::{Graph, NodeId};
use orogen::num::{
    Affine, Class, Dual, Function, Half, Interval, Jet, Many, Number, Parabola, Parabolas, Reduced, Sign,
    Slope,
};
use orogen::op::{Abs, Add, Corner, Max, Melt, Min, Mul, Neg, Op, Ramp, Square, Sub, Visitor};
use orogen::tape::{Evaluator, Signer, Tape};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::sync::Arc;

/// Boxes tried per operation.
const BOXES: usize = 400;
/// Points tried per box.
const POINTS: usize = 40;

fn seeded(name: &str) -> StdRng {
    let seed =
        name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3));
    StdRng::seed_from_u64(seed)
}

/// A coordinate that is often special: an integer, a half, zero.
fn coordinate(rng: &mut StdRng) -> f64 {
    match rng.random_range(0..6) {
        0 => f64::from(rng.random_range(-3..=3)),
        1 => f64::from(rng.random_range(-6..=6)) * 0.5,
        2 => rng.random_range(-40.0..40.0),
        3 => rng.random_range(-1e-3..1e-3),
        _ => rng.random_range(-3.0..3.0),
    }
}

/// A radius of any size, zero included.
fn radius(rng: &mut StdRng) -> f64 {
    match rng.random_range(0..8) {
        0 => 0.0,
        _ => 10f64.powf(rng.random_range(-9.0..0.6)),
    }
}

fn any_box<const N: usize>(rng: &mut StdRng) -> [Interval; N] {
    std::array::from_fn(|_| {
        let (c, r) = (coordinate(rng), radius(rng));
        // Corners on special values, too.
        if rng.random_bool(0.3) { Interval::new(c, c + r) } else { Interval::new(c - r, c + r) }
    })
}

fn inside(rng: &mut StdRng, x: Interval) -> f64 {
    match rng.random_range(0..5) {
        0 => x.lo,
        1 => x.hi,
        _ => (x.lo + rng.random::<f64>() * (x.hi - x.lo)).clamp(x.lo, x.hi),
    }
}

/// Shows a law every operation.
struct Tour<L>(L);

trait Law {
    fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng);
}

impl<L: Law> Visitor for Tour<L> {
    fn visit<F: Function<N>, const N: usize>(&mut self, name: &str, doc: &str, f: &F) {
        assert!(doc.ends_with('.'), "{name} lacks a sentence of documentation");
        self.0.check(name, f, &mut seeded(name));
    }
}

/// Runs a law over every operation, and over every kind of rounded corner.
fn run(law: impl Law) {
    let mut tour = Tour(law);
    Op::visit_all(&mut tour);
    for (name, ramp) in Ramp::ALL {
        tour.visit(&format!("ramp, {name}"), "A corner.", &ramp);
        tour.visit(&format!("melt, {name}"), "A corner.", &Melt::new(ramp, 0.3));
    }
}

#[test]
fn plain_numbers_are_off_by_no_more_roundoffs_than_stated() {
    struct Near;
    impl Law for Near {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            let near =
                |x: f64, all: Interval, off: f64| !x.is_finite() || (x - off <= all.hi && x + off >= all.lo);
            for _ in 0..BOXES * POINTS {
                let x: [f64; N] = std::array::from_fn(|_| coordinate(rng) * radius(rng));
                let of_size = f.roundoffs().map(|roundoffs| roundoffs * 0.5 * f64::EPSILON);
                let of_seam = f.seam(&x, Interval::ENTIRE).map(|seam| seam.blur);
                let off = |order: usize, x: f64| match (of_size, of_seam) {
                    (Some(share), _) => Some(share * x.abs()),
                    (None, blur) => blur.map(|blur| blur[order]),
                };
                let Some(blur) = off(0, f.value(x)) else { return };
                let at = x.map(Interval::point);
                assert!(
                    near(f.value(x), f.range(at), blur),
                    "{name} at {x:?}: {} in {:?}",
                    f.value(x),
                    f.range(at)
                );
                let (plain, wide) = (f.grad(x), f.grad(at));
                for i in 0..N {
                    // Where a derivative jumps, either one is right.
                    let all = if wide[i].is_finite() { wide[i] } else { Interval::ENTIRE };
                    let off = off(1, plain[i]).unwrap_or(0.0);
                    assert!(near(plain[i], all, off), "{name}, slope {i} at {x:?}: {} in {all:?}", plain[i]);
                }
            }
        }
    }
    run(Near);
}

/// A value that is a number, or as large as none, lies in the range over a box that holds the point.
fn value_lies_in_range<F: Function<N>, const N: usize>(name: &str, f: &F, x: [f64; N], sides: [Interval; N]) {
    let (value, range) = (f.value(x), f.range(sides));
    let holds = value.is_nan() || (range.lo <= value && value <= range.hi);
    assert!(holds, "{name} of {x:?}: {value} in {range:?} of {sides:?}");
}

/// Numbers of very different sizes, next to which others vanish.
#[test]
fn what_is_rounded_away_lies_inside_ranges() {
    struct Round;
    impl Law for Round {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..BOXES * POINTS {
                let x: [f64; N] = std::array::from_fn(|_| {
                    let size = 10f64.powf(rng.random_range(-12.0..18.0));
                    [size, -size, 1.0, 0.0][rng.random_range(0..4)]
                });
                value_lies_in_range(name, f, x, x.map(Interval::point));
            }
        }
    }
    run(Round);
}

/// Zeros of either sign, at the ends of boxes: what is as large as no number lies in ranges too.
#[test]
fn what_is_zero_lies_inside_ranges() {
    struct Zero;
    impl Law for Zero {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..BOXES * POINTS {
                let x: [f64; N] = std::array::from_fn(|_| {
                    let size = rng.random_range(0.1..3.0);
                    [size, -size, 0.0, -0.0][rng.random_range(0..4)]
                });
                let sides = x.map(|x| {
                    let [less, more] =
                        [0, 1].map(|_| [0.0, rng.random_range(0.1..3.0)][rng.random_range(0..2)]);
                    Interval::new(x - less, x + more)
                });
                value_lies_in_range(name, f, x, sides);
            }
        }
    }
    run(Zero);
}

/// Signs of arguments make no difference where it is said so, each of them.
#[test]
fn signs_do_not_matter_to_what_is_even() {
    struct Signs;
    impl Law for Signs {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..if f.is_even() { BOXES * POINTS } else { 0 } {
                let x: [f64; N] = std::array::from_fn(|_| coordinate(rng));
                let turned = x.map(|x| if rng.random_bool(0.5) { -x } else { x });
                assert_eq!(f.value(x), f.value(turned), "{name} of {x:?} and {turned:?}");
            }
        }
    }
    run(Signs);
}

#[test]
fn chords_of_what_bows_are_between_those_to_its_ends() {
    struct Bow;
    impl Law for Bow {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..BOXES {
                let wide = radius(rng);
                let all = Interval::around(coordinate(rng), wide);
                let Some(x) = f.bows(all) else { continue };
                assert_eq!(N, 1, "{name}");
                let value = |x: f64| f.range([Interval::point(x); N]);
                for p in (0..POINTS).map(|_| inside(rng, all)) {
                    assert!(f.value([p; N]).is_nan() || x.contains(p), "{name} at {p} outside {x:?}");
                }
                let from = x.mid();
                let slope =
                    |to: f64| (value(to) - value(from)) / (Interval::point(to) - Interval::point(from));
                let ends = slope(x.lo).hull(slope(x.hi));
                for to in (0..POINTS).map(|_| inside(rng, x)).filter(|to| *to != from) {
                    assert!(
                        ends.lo <= slope(to).hi && slope(to).lo <= ends.hi,
                        "{name} from {from} to {to} in {x:?}"
                    );
                }
            }
        }
    }
    run(Bow);
}

/// What is far from a corner hardly knows of it: the larger of two that change places near the end of a piece.
#[test]
fn corners_near_the_end_of_a_piece_blur_its_middle_little() {
    let line = |mid, slope| Parabola::<0>::coordinate(mid, slope, [], 0.0, 0.0);
    for (is_least, sign) in [(false, 1.0), (true, -1.0)] {
        // They meet at nine tenths.
        let x = [line(sign, -sign), line(sign * 0.1, 0.0)].map(Parabolas::<8, 0>::all);
        let z =
            if is_least { Parabolas::lift(&Min, x.each_ref()) } else { Parabolas::lift(&Max, x.each_ref()) };
        let rest = z.lane(0).rest;
        assert!(rest[1] + rest[2] < 0.06 && rest[0] < 1e-9, "{rest:?}");
        let x = [Parabolas::<8, 0>::all(line(sign * 0.9, -sign))];
        let rest = Parabolas::lift(&Abs, x.each_ref()).lane(0).rest;
        assert!(rest[1] + rest[2] < 0.11 && rest[0] < 1e-9, "{rest:?}");
    }
}

/// A solid of planes, balls and products that are put together at random.
fn put_together(graph: &mut Graph, rng: &mut StdRng, depth: u32) -> NodeId {
    if depth == 0 || rng.random_bool(0.15) {
        let p = graph.point().unwrap();
        let c: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let size = graph.constant(rng.random_range(-0.5..1.0)).unwrap();
        let leaf = match rng.random_range(0..4) {
            0 => graph.op(Op::Mul(Mul), &[p[0], p[2]]),
            1 => {
                let squares = [0, 1, 2].map(|i| {
                    let off = graph.constant(c[i]).unwrap();
                    let off = graph.op(Op::Sub(Sub), &[p[i], off]).unwrap();
                    graph.op(Op::Square(Square), &[off]).unwrap()
                });
                let sum = graph.op(Op::Add(Add), &squares[..2]).unwrap();
                graph.op(Op::Add(Add), &[sum, squares[2]])
            }
            _ => {
                let parts = [0, 1, 2].map(|i| {
                    let c = graph.constant(c[i]).unwrap();
                    graph.op(Op::Mul(Mul), &[p[i], c]).unwrap()
                });
                let sum = graph.op(Op::Add(Add), &parts[..2]).unwrap();
                graph.op(Op::Add(Add), &[sum, parts[2]])
            }
        };
        return graph.op(Op::Sub(Sub), &[leaf.unwrap(), size]).unwrap();
    }
    let a = put_together(graph, rng, depth - 1);
    match rng.random_range(0..10) {
        0 => graph.op(Op::Neg(Neg), &[a]).unwrap(),
        // Something that others read as well, or a number.
        1 => {
            let c = graph.constant(rng.random_range(-0.3..0.3)).unwrap();
            let b = if rng.random_bool(0.5) { graph.op(Op::Neg(Neg), &[a]).unwrap() } else { c };
            graph.op(Op::Max(Max), &[a, b]).unwrap()
        }
        2 => {
            let c = graph.constant(rng.random_range(-0.5..0.5)).unwrap();
            graph.op(Op::Add(Add), &[a, c]).unwrap()
        }
        3 => {
            let k = graph.constant(rng.random_range(-2.0..2.0)).unwrap();
            graph.op(Op::Mul(Mul), &[a, k]).unwrap()
        }
        kind => {
            let b = put_together(graph, rng, depth - 1);
            let op = if kind % 2 == 0 { Op::Min(Min) } else { Op::Max(Max) };
            graph.op(op, &[a, b]).unwrap()
        }
    }
}

/// What is certain of the signs of solids that are put together holds along every ray of a beam, and is more than their
/// forms say.
#[test]
fn signs_of_what_is_put_together_hold_along_lines() {
    let mut rng = seeded("signs");
    let (mut positive, mut by_signs, mut by_forms, mut alone) = (0, 0, 0, 0);
    for solid in 0..600 {
        let mut graph = Graph::default();
        let root = put_together(&mut graph, &mut rng, 5);
        let other = put_together(&mut graph, &mut rng, 2);
        let roots = if solid % 3 == 0 { vec![root, other] } else { vec![root] };
        let tape = Arc::new(Tape::new(&graph, &roots));
        let (mut signer, mut single) = (Signer::<4, 2>::default(), Signer::<1, 2>::default());
        let mut forms = Evaluator::<Parabolas<4, 2>>::new(tape.clone());
        let mut values = Evaluator::<f64>::new(tape.clone());
        let width = if solid % 2 == 0 { 0.0 } else { 0.05 };
        let mut some =
            |size: f64| -> [f64; 3] { std::array::from_fn(|_| size * rng.random_range(-1.0..1.0)) };
        let pieces: [[[f64; 3]; 4]; 4] =
            std::array::from_fn(|_| [some(1.5), some(0.8), some(width), some(width)]);
        let p = [0, 1, 2].map(|axis| {
            let mut all = Parabolas::all(Parabola::coordinate(0.0, 0.0, [0.0; 2], 0.0, 0.0));
            for (lane, [mid, slope, u, v]) in pieces.iter().enumerate() {
                all.set(lane, &Parabola::coordinate(mid[axis], slope[axis], [u[axis], v[axis]], 0.0, 0.0));
            }
            all
        });
        let signs = signer.eval(&tape, &p);
        let halves = forms.eval(&p).halves();
        for (lane, [mid, slope, u, v]) in pieces.iter().enumerate() {
            let sign = signs.lane(lane);
            let own = single.eval(&tape, &[0, 1, 2].map(|axis| Parabolas::all(p[axis].lane(lane))));
            let told = |sign: Sign, form: Parabola<2>| format!("{sign:?} {form:?}");
            let both = [told(sign, signs.form(lane)), told(own.lane(0), own.form(0))];
            assert_eq!(both[0], both[1], "a lane depends on its neighbours");
            alone += i32::from(sign.is_alone);
            let form = signs.form(lane);
            let mut value = |e: f64, [x, y]: [f64; 2]| {
                let at = [0, 1, 2].map(|k| mid[k] + e * slope[k] + x * u[k] + y * v[k]);
                let f = *values.eval(&at);
                let leaf = form.at([x, y], [0.0; 2]);
                let [c, b, a] = leaf.mid;
                let (leaf, rest) = (c + e * (b + e * a), leaf.rest.iter().sum::<f64>() + 1e-12);
                let is_known = sign.is_alone && f.abs() > 1e-12 && leaf.abs() > rest;
                assert!(!is_known || (f > 0.0) == (leaf > 0.0), "{f} {leaf}: {sign:?}");
                assert!(f > 0.0 || sign.range.lo <= 0.0, "{f}: {sign:?}");
                assert!(f < 0.0 || sign.range.hi >= 0.0, "{f}: {sign:?}");
                f
            };
            for k in 0..60 {
                let aside = [0; 2].map(|_| rng.random_range(-1.0..=1.0));
                let (side, e) = (k % 2, rng.random_range(0.0..=1.0));
                let back = if side == 0 { -1.0 } else { 1.0 };
                let f = value(back * e, aside);
                let holds = |half: Half| (half.above[0]..=half.above[1]).contains(&e) && half.above[0] < 1.0;
                let [own, form] = [sign.halves[side], halves[lane][side]];
                assert!(!holds(own) || f > 0.0, "{f} at {e}: {own:?}");
                if own.below[0] < 1.0 {
                    let [from, to] = own.below;
                    let below = value(back * (from + (to - from) * e), aside);
                    assert!(below < 0.0, "{below}: {own:?}");
                }
                positive += i32::from(f > 0.0);
                by_signs += i32::from(holds(own));
                by_forms += i32::from(holds(form));
            }
        }
    }
    assert!(alone > 500 && alone < 2300, "{alone}");
    assert!(f64::from(by_signs) > 0.9 * f64::from(positive), "{by_signs} {positive}");
    assert!(by_signs > by_forms, "{by_signs} {by_forms}");
}

/// Points of meshes lie exactly on edges.
#[test]
fn corners_have_a_slope_on_their_edge() {
    for x in [[0.0, 0.0], [-0.0, 0.0]] {
        let [a, b] = Corner.grad(x);
        assert!((a * a + b * b - 1.0).abs() < 1e-15, "{a} {b}");
        let all = Corner.grad(x.map(|x| Interval::new(x - 1e-3, x + 1e-3)));
        assert!([a, b].iter().zip(all).all(|(g, all)| all.lo <= *g && *g <= all.hi), "{all:?}");
        assert_eq!(Corner.hess(x).as_flattened().iter().filter(|h| h.abs() > 1e3).count(), 0);
    }
}

#[test]
fn what_selects_does_so_among_two() {
    struct Select;
    impl Law for Select {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, _: &mut StdRng) {
            assert!(!f.selects() || (N == 2 && f.class() == Class::C0), "{name}");
        }
    }
    run(Select);
}

#[test]
fn seams_bend_along_a_difference_and_end() {
    struct Bend;
    impl Law for Bend {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            let Some(seam) = f.seam(&[0.0; N], Interval::ENTIRE) else { return };
            assert_eq!(N, 2, "{name}");
            for _ in 0..BOXES {
                let mut x: [f64; N] = std::array::from_fn(|_| rng.random_range(-3.0..3.0));
                let (apart, wide) = (x[0] - x[1], rng.random_range(0.0..1.0));
                let range = Interval::new(apart - wide, apart + wide);
                for _ in 0..POINTS {
                    x[0] = x[1] + inside(rng, range);
                    let difference = Interval::point(x[0]) - Interval::point(x[1]);
                    let bend = f.seam(&x, range.hull(difference)).expect("a seam").bend;
                    let h = f.hess(x.map(Interval::point));
                    assert!(
                        bend.lo <= h[0][0].hi && h[0][0].lo <= bend.hi,
                        "{name} at {x:?}: {h:?} in {bend:?}"
                    );
                    let all = [h[0][0], -h[0][1], -h[1][0], h[1][1]];
                    assert_eq!(all, [h[0][0]; 4], "{name} at {x:?}");
                }
                let low = x[rng.random_range(0..N)];
                let far = low + seam.reach * (1.0 + wide);
                let [below, above] = [[low, far], [far, low]].map(|x| f.value(std::array::from_fn(|i| x[i])));
                assert_eq!([below, above], [low; 2], "{name} of {low} and {far}");
            }
        }
    }
    run(Bend);
}

#[test]
fn second_derivatives_said_to_be_constant_are() {
    struct Constant;
    impl Law for Constant {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            let first = f.hess([0.5; N]);
            let same = (0..BOXES).all(|_| {
                let x: [f64; N] = std::array::from_fn(|_| rng.random_range(-3.0..3.0));
                f.hess(x) == first
            });
            assert!(same || !f.is_quadratic(), "{name} bends here more than there");
        }
    }
    run(Constant);
}

#[test]
fn samples_lie_inside_ranges_and_forms() {
    struct Contain;
    impl Law for Contain {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..BOXES {
                let x: [Interval; N] = any_box(rng);
                let range = Interval::lift(f, x.each_ref());
                let affine_in = x.map(Affine::over);
                let affine = Affine::lift(f, affine_in.each_ref());
                for _ in 0..POINTS {
                    let p = x.map(|x| inside(rng, x));
                    let v = f.value(p);
                    if v.is_nan() {
                        assert!(
                            !f.is_defined(&x),
                            "{name} has no value at {p:?}, in a box where it is defined"
                        );
                        continue;
                    }
                    // The true value, of which `v` is a rounding.
                    let v = f.value(p.map(Interval::point));
                    let holds = |e: Interval| e.lo <= v.hi && v.lo <= e.hi;
                    assert!(holds(range), "{name}({p:?}) = {v:?} outside {range:?} of {x:?}");
                    // A point of the box in terms of the form's own symbols.
                    let mut band = Interval::point(affine.mid);
                    let mut private = 0.0;
                    for (symbol, c) in &affine.terms {
                        match affine_in.iter().position(|a| a.terms[0].0 == *symbol) {
                            Some(i) if affine_in[i].terms[0].1 > 0.0 => {
                                let e = (p[i] - affine_in[i].mid) / affine_in[i].terms[0].1;
                                band = band + Interval::around(e, 1e-15) * Interval::point(*c);
                            }
                            Some(_) => {}
                            None => private += c.abs(),
                        }
                    }
                    let band = band + Interval::radius(private);
                    assert!(holds(band), "{name}({p:?}) = {v:?} outside affine band {band:?} of {x:?}");
                    assert!(holds(affine.range));
                }
            }
        }
    }
    run(Contain);
}

/// Where a parabola allows its quantity to be at `e` along the line and `u` across it.
fn band<const K: usize>(x: &Parabola<K>, e: f64, u: [f64; K]) -> Interval {
    let terms = [Interval::point(1.0), Interval::point(e), Interval::point(e) * Interval::point(e)];
    let mid = (0..3).map(|j| Interval::point(x.mid[j]) * terms[j]);
    let rest = (0..3).map(|j| Interval::radius(x.rest[j]) * terms[j]);
    let side = (0..K).map(|k| Interval::point(x.side[k]) * Interval::point(u[k]));
    mid.chain(rest).chain(side).fold(Interval::point(0.0), |sum, term| sum + term)
}

/// A piece of a line for each of `N` coordinates, seen across two directions.
fn any_piece<const N: usize>(rng: &mut StdRng) -> [Parabola<2>; N] {
    let (along, across) = (radius(rng), if rng.random() { 0.0 } else { radius(rng) });
    std::array::from_fn(|_| {
        let side = std::array::from_fn(|_| across * rng.random_range(-1.0..1.0));
        let [spread, blur] = if rng.random() { [0.0; 2] } else { [1e-3 * along, 1e-9] };
        Parabola::coordinate(coordinate(rng), along * rng.random_range(-1.0..1.0), side, spread, blur)
    })
}

/// A quantity of which a range is known that leaves out some of what the form allows, perhaps its middle.
fn clipped(x: Parabola<2>, rng: &mut StdRng) -> Parabola<2> {
    let range = Interval::new(inside(rng, x.range), inside(rng, x.range));
    Parabola { range, ..x }
}

/// The values that a coordinate may have at a place, apart from its spread and blur.
fn at_place(x: &Parabola<2>, e: f64, u: [f64; 2]) -> f64 {
    x.mid[0] + x.mid[1] * e + x.side[0] * u[0] + x.side[1] * u[1]
}

#[test]
fn samples_lie_inside_parabolas() {
    struct Contain;
    impl Law for Contain {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..BOXES {
                let x: [Parabola<2>; N] = any_piece(rng);
                let x = if rng.random() { x } else { x.map(|x| clipped(x, rng)) };
                let lanes = x.map(Parabolas::<8, 2>::all);
                let z = Parabolas::lift(f, lanes.each_ref()).lane(3);
                for _ in 0..POINTS {
                    let e = inside(rng, Interval::new(-1.0, 1.0));
                    let u = std::array::from_fn(|_| inside(rng, Interval::new(-1.0, 1.0)));
                    let p = x.each_ref().map(|x| at_place(x, e, u));
                    if (0..N).any(|i| !x[i].range.contains(p[i])) {
                        continue;
                    }
                    // The arguments are rounded: allow what the function makes of that.
                    let near = f.range(std::array::from_fn(|i| {
                        Interval::around(p[i], 8.0 * f64::EPSILON * x[i].range.mag())
                    }));
                    if f.value(p).is_nan() || !near.is_finite() {
                        continue;
                    }
                    for e in [band(&z, e, u), z.range] {
                        assert!(
                            !(e.lo > near.hi || near.lo > e.hi),
                            "{name}{p:?} is {near:?}, outside {e:?} of {x:?}"
                        );
                    }
                }
            }
        }
    }
    run(Contain);
}

#[test]
fn samples_lie_inside_reduced_forms() {
    struct Contain;
    impl Law for Contain {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..BOXES {
                // Arguments that depend on three shared positions.
                let args: [Reduced<3>; N] = std::array::from_fn(|_| {
                    let r = radius(rng);
                    Reduced::new(coordinate(rng), std::array::from_fn(|_| r * rng.random_range(-1.0..1.0)))
                });
                let z = Reduced::lift(f, args.each_ref());
                let line = args.map(|a| Reduced::new(a.mid, [a.slope[0]]));
                let z1 = Reduced::<1>::lift(f, line.each_ref());
                for _ in 0..POINTS {
                    let e: [f64; 3] = std::array::from_fn(|_| inside(rng, Interval::new(-1.0, 1.0)));
                    let at =
                        |a: &Reduced<3>| a.mid + a.slope[0] * e[0] + a.slope[1] * e[1] + a.slope[2] * e[2];
                    let v = f.value(args.each_ref().map(at));
                    // The argument itself is rounded: allow what the derivative makes of that.
                    let x =
                        args.each_ref().map(|a| Interval::around(at(a), 4.0 * f64::EPSILON * a.range.mag()));
                    let near = f.range(x);
                    if v.is_nan() || !near.is_finite() {
                        continue;
                    }
                    let slack = near.width();
                    let mid = z.mid + z.slope[0] * e[0] + z.slope[1] * e[1] + z.slope[2] * e[2];
                    assert!(
                        (v - mid).abs() <= z.rest + slack + 4.0 * f64::EPSILON * mid.abs(),
                        "{name} of {args:?} at {e:?}: {v:e} is not within {:e} of {mid:e}",
                        z.rest
                    );
                    assert!(z.range.lo - slack <= v && v <= z.range.hi + slack, "{name}");
                    let v1 = f.value(line.each_ref().map(|a| a.mid + a.slope[0] * e[0]));
                    let near1 = f.range(line.each_ref().map(|a| {
                        Interval::around(a.mid + a.slope[0] * e[0], 4.0 * f64::EPSILON * a.range.mag())
                    }));
                    if v1.is_nan() || !near1.is_finite() {
                        continue;
                    }
                    let mid = z1.mid + z1.slope[0] * e[0];
                    assert!(
                        (v1 - mid).abs() <= z1.rest + near1.width() + 4.0 * f64::EPSILON * mid.abs(),
                        "{name} of {line:?} at {e:?}: {v1:e} is not within {:e} of {mid:e}",
                        z1.rest
                    );
                }
            }
        }
    }
    run(Contain);
}

#[test]
fn smaller_boxes_never_widen_a_range() {
    struct Isotone;
    impl Law for Isotone {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..BOXES {
                let x: [Interval; N] = any_box(rng);
                let part = x.map(|x| {
                    let (a, b) = (inside(rng, x), inside(rng, x));
                    Interval::new(a, b)
                });
                let (whole, some) = (f.range(x), f.range(part));
                // A part that lies wholly outside the domain has no range to speak of.
                if !f.value(part.map(|p| p.mid())).is_finite() {
                    continue;
                }
                assert!(
                    whole.encloses(some),
                    "{name}: {some:?} of {part:?} is not within {whole:?} of {x:?}"
                );
            }
        }
    }
    run(Isotone);
}

#[test]
fn derivatives_match_differences() {
    struct Differ;
    impl Law for Differ {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            let mut checked = 0;
            for _ in 0..BOXES * 4 {
                let p: [f64; N] = std::array::from_fn(|_| coordinate(rng));
                for i in 0..N {
                    let h = 1e-5 * (1.0 + p[i].abs());
                    let moved =
                        |d: f64| std::array::from_fn::<f64, N, _>(|j| if i == j { p[j] + d } else { p[j] });
                    // The mean value theorem puts a difference quotient into the derivative's range.
                    let x = std::array::from_fn(|j| {
                        if i == j { Interval::new(p[j] - h, p[j] + h) } else { Interval::point(p[j]) }
                    });
                    let (lo, hi) = (f.value(moved(-h)), f.value(moved(h)));
                    let run = moved(h)[i] - moved(-h)[i];
                    let quotient = (hi - lo) / run;
                    let grad = f.grad(x)[i];
                    let size = p.iter().map(|p| p.abs()).fold(1.0, f64::max);
                    let rounding = 16.0 * f64::EPSILON * (hi.abs() + lo.abs() + size) / h;
                    // Across a pole, or outside the domain, the theorem has nothing to say.
                    if quotient.is_nan() || !f.range(x).is_finite() {
                        continue;
                    }
                    assert!(
                        grad.lo - rounding <= quotient && quotient <= grad.hi + rounding,
                        "{name} d{i} at {p:?}: {quotient:e} not in {grad:?}"
                    );
                    let (glo, ghi) = (f.grad(moved(-h)), f.grad(moved(h)));
                    let here = f.grad(p)[i];
                    assert!(
                        here.is_nan() || grad.lo - rounding <= here && here <= grad.hi + rounding,
                        "{name} d{i} at {p:?}"
                    );
                    // A range that is narrow makes the test sharp.
                    checked += usize::from(grad.width() < 0.1 * (1.0 + grad.mag()));
                    for j in 0..N {
                        let quotient = (ghi[j] - glo[j]) / run;
                        let hess = f.hess(x)[i][j];
                        let rounding = 64.0 * f64::EPSILON * (ghi[j].abs() + glo[j].abs() + size) / h;
                        if quotient.is_finite() {
                            assert!(
                                hess.lo - rounding <= quotient && quotient <= hess.hi + rounding,
                                "{name} d{i}d{j} at {p:?}: {quotient:e} not in {hess:?}"
                            );
                        }
                    }
                }
            }
            assert!(checked > BOXES / 4, "{name}: only {checked} sharp comparisons");
        }
    }
    run(Differ);
}

#[test]
fn lipschitz_and_hessian_bounds_bound() {
    struct Bounded;
    impl Law for Bounded {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            for _ in 0..BOXES {
                // Arguments that are linear in x, y, z.
                let w: [[f64; 3]; N] =
                    std::array::from_fn(|_| std::array::from_fn(|_| rng.random_range(-1.5..1.5)));
                let c: [f64; N] = std::array::from_fn(|_| coordinate(rng));
                let space: [Interval; 3] = std::array::from_fn(|_| Interval::around(0.0, radius(rng)));
                let slope = compose(f, &w, &c, std::array::from_fn(|i| Slope::coordinate(space[i], i)));
                let jet = compose(f, &w, &c, std::array::from_fn(|i| Jet::coordinate(space[i], i)));
                for _ in 0..POINTS / 2 {
                    let p = space.map(|x| inside(rng, x));
                    let at: Jet = compose(f, &w, &c, std::array::from_fn(|i| Jet::coordinate(p[i], i)));
                    if !at.grad.iter().chain(&at.hess).all(|d| d.is_finite()) || at.value.is_nan() {
                        continue;
                    }
                    let tiny = |d: f64| 1e-9 * (1.0 + d.abs());
                    let norm = at.grad.iter().map(|g| g * g).sum::<f64>().sqrt();
                    assert!(
                        norm <= slope.norm + tiny(norm),
                        "{name}: |grad| {norm:e} above {:e}",
                        slope.norm
                    );
                    for i in 0..3 {
                        let g = at.grad[i];
                        assert!(slope.grad[i].lo - tiny(g) <= g && g <= slope.grad[i].hi + tiny(g), "{name}");
                        assert!(jet.grad[i].lo - tiny(g) <= g && g <= jet.grad[i].hi + tiny(g), "{name}");
                    }
                    for i in 0..6 {
                        let h = at.hess[i];
                        assert!(
                            jet.hess[i].lo - tiny(h) <= h && h <= jet.hess[i].hi + tiny(h),
                            "{name}: {h:e} not in {:?}",
                            jet.hess[i]
                        );
                    }
                }
            }
        }
    }
    run(Bounded);
}

/// `f` of `N` linear functions `w . (x, y, z) + c`.
fn compose<T: Number, F: Function<N>, const N: usize>(
    f: &F,
    w: &[[f64; 3]; N],
    c: &[f64; N],
    [x, y, z]: [T; 3],
) -> T {
    let args: [T; N] =
        std::array::from_fn(|i| x.scale(w[i][0]).add(&y.scale(w[i][1])).add(&z.scale(w[i][2])).shift(c[i]));
    f.apply(args.each_ref())
}

#[test]
fn batches_equal_single_numbers() {
    struct Equal;
    impl Law for Equal {
        fn check<F: Function<N>, const N: usize>(&self, name: &str, f: &F, rng: &mut StdRng) {
            const B: usize = 8;
            for _ in 0..BOXES {
                let p: [[f64; B]; N] = std::array::from_fn(|_| std::array::from_fn(|_| coordinate(rng)));
                let values = f.apply(p.map(Many).each_ref());
                let duals: [Many<Dual, B>; N] =
                    p.map(|x| Many(x.map(|x| Dual { value: x, grad: [1.0, x, 2.0] })));
                let grads = f.apply(duals.each_ref());
                let forms: [Many<Reduced<1>, B>; N] = p.map(|x| Many(x.map(|x| Reduced::new(x, [0.25]))));
                let reduced = f.apply(forms.each_ref());
                for lane in 0..B {
                    let one = f.apply(p.each_ref().map(|x| &x[lane]));
                    assert_eq!(values.0[lane].to_bits(), one.to_bits(), "{name}");
                    let dual = f.apply(duals.each_ref().map(|x| &x.0[lane]));
                    assert_eq!(format!("{:?}", grads.0[lane]), format!("{dual:?}"), "{name}");
                    let form = f.apply(forms.each_ref().map(|x| &x.0[lane]));
                    assert_eq!(format!("{:?}", reduced.0[lane]), format!("{form:?}"), "{name}");
                }
            }
        }
    }
    run(Equal);
}

/// Random composites: expressions of operations, noises, fractals, grids and shapes.
mod composites {
    use super::{any_piece, at_place, band, coordinate, inside, radius, seeded};
    use glam::DVec3;
    use orogen::expr::{Graph, Input, NodeId};
    use orogen::field::Field;
    use orogen::grid::{Edge, Frame, Grid, Samples};
    use orogen::noise::{
        Allowed, Fractal, Kind as NoiseKind, Model, Noise, Recipe, Setting, Settings, Signal,
    };
    use orogen::num::{Affine, Dual, Interval, Jet, Many, Number, Parabola, Parabolas, Reduced, Taylors};
    use orogen::op::Op;
    use orogen::shape::convolution::{Convolution, Density, Primitive};
    use orogen::shape::curve::{Curve, Degree, Kind};
    use orogen::shape::outline::{Outline, Pen};
    use orogen::shape::tetrahedra::Tetrahedra;
    use orogen::shape::{Distance, Mesh, Shape};
    use orogen::tape::{Evaluator, Tape};
    use rand::{RngExt, rngs::StdRng};
    use std::sync::Arc;

    /// Any noise, now and then told to be other than it is by itself.
    fn any_noise(rng: &mut StdRng) -> NoiseKind {
        let listing = &NoiseKind::ALL[rng.random_range(0..NoiseKind::ALL.len())];
        let mut settings = Settings::new(listing.parameters);
        for parameter in listing.parameters {
            let setting = match parameter.allowed {
                Allowed::Choice(names) => Setting::Name(names[rng.random_range(0..names.len())]),
                Allowed::Flag { .. } => Setting::Flag(rng.random()),
                _ => continue,
            };
            settings.set(parameter.name, setting).expect("a value from the table");
        }
        (listing.build)(&settings)
    }

    /// A random expression over the coordinates.
    fn grow(g: &mut Graph, rng: &mut StdRng, depth: u32) -> NodeId {
        let axes = [Input::X, Input::Y, Input::Z];
        if depth == 0 || rng.random_bool(0.1) {
            return match rng.random_range(0..4) {
                0 => g.constant((rng.random_range(-20..20) as f64) * 0.125).expect("room"),
                _ => g.input(axes[rng.random_range(0..3)]).expect("room"),
            };
        }
        let arg = |g: &mut Graph, rng: &mut StdRng| grow(g, rng, depth - 1);
        match rng.random_range(0..10) {
            3 => {
                let p = std::array::from_fn(|_| arg(g, rng));
                let shape = if rng.random() { measured(rng) } else { Arc::new(shaped(rng)) };
                g.shape(shape, p).expect("room")
            }
            2 => {
                let p = std::array::from_fn(|_| arg(g, rng));
                g.grid(sampled(rng), p).expect("room")
            }
            0 => {
                let p = std::array::from_fn(|_| arg(g, rng));
                let frequency = rng.random_range(0.2..6.0);
                let noise = Noise::new(any_noise(rng), rng.random_range(0..9)).at_frequency(frequency);
                g.noise(noise, p).expect("room")
            }
            1 => {
                let p = std::array::from_fn(|_| arg(g, rng));
                let noise = Noise::new(any_noise(rng), 3).at_frequency(rng.random_range(0.3..3.0));
                let model = Model::NAMED[rng.random_range(0..Model::NAMED.len())];
                let octaves = rng.random_range(1..6);
                let signal = Signal::ALL[rng.random_range(0..Signal::ALL.len())];
                let model = if rng.random() { model } else { model.of(signal) };
                let recipe = Recipe {
                    octaves,
                    first: rng.random_range(-1..=1),
                    offset: 0.7,
                    rotate: rng.random(),
                    ..Recipe::new(noise, model)
                };
                let fractal = Arc::new(Fractal::new(recipe).expect("a valid recipe"));
                let footprint = g.constant(if rng.random() { 0.0 } else { 0.05 }).expect("room");
                if rng.random_bool(0.7) {
                    g.fractal(fractal, p, footprint).expect("room")
                } else {
                    let hurst = arg(g, rng);
                    g.rough_fractal(fractal, p, footprint, hurst).expect("room")
                }
            }
            _ => {
                let op = Op::ALL[rng.random_range(0..Op::ALL.len())];
                let args: Vec<NodeId> = (0..op.arity()).map(|_| arg(g, rng)).collect();
                g.op(op, &args).expect("room")
            }
        }
    }

    /// A shape of random data.
    fn shaped(rng: &mut StdRng) -> Shape {
        let points: Vec<DVec3> =
            (0..6).map(|_| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-2.0..2.0)))).collect();
        match rng.random_range(0..4) {
            0 => {
                let kind =
                    [Kind::Polyline, Kind::CatmullRom, Kind::Bspline(Degree::Two)][rng.random_range(0..3)];
                Shape::new(Curve::new(&points, &[0.1, 0.4, 0.2], kind, rng.random()).expect("a valid curve"))
            }
            1 => {
                let mut pen = Pen::default();
                pen.jump(points[0].truncate());
                pen.line(points[1].truncate());
                pen.quadratic(points[2].truncate(), points[3].truncate());
                pen.cubic(points[4].truncate(), points[5].truncate(), points[1].truncate());
                Shape::new(Outline::new(pen).expect("a valid outline"))
            }
            2 => {
                let parts = [
                    (Primitive::Segment([points[0], points[1]]), 1.0),
                    (Primitive::Triangle([points[2], points[3], points[4]]), -0.4),
                    (Primitive::Point(points[5]), 0.7),
                ];
                let skeleton = Convolution::new(&parts, Density::Cauchy(0.4), 0.5);
                Shape::new(skeleton.expect("a valid skeleton"))
            }
            _ => {
                let corners = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 1.5, DVec3::Z];
                let coefficients = (0..10).map(|_| rng.random_range(-1.0..1.0)).collect();
                let cell = Tetrahedra::new(&corners, &[[0, 1, 2, 3]], 2, &[coefficients]);
                Shape::new(cell.expect("a valid cell"))
            }
        }
    }

    /// A grid of random numbers.
    fn sampled(rng: &mut StdRng) -> Arc<Grid> {
        let edge = if rng.random() { Edge::Repeat } else { Edge::Clamp };
        let size = if rng.random() { [7, 1, 9] } else { [5, 6, 4] };
        let frame = Frame::over(size, [-1.0, 0.0, -2.0], [2.0, 1.5, 1.0], edge).expect("a valid frame");
        let values = (0..frame.count()).map(|_| rng.random_range(-1.0..2.0)).collect();
        Arc::new(Grid::through(&Samples { frame, values }).expect("finite samples"))
    }

    /// The distance from a lump of triangles, from two that pass through one another, from a lump with
    /// holes.
    fn measured(rng: &mut StdRng) -> Arc<Shape> {
        let mut mesh = Mesh::default();
        let lumps = rng.random_range(1..3);
        for _ in 0..lumps {
            let start = mesh.points.len() as u32;
            let middle = DVec3::new(rng.random(), rng.random(), rng.random());
            for p in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
                mesh.points.push(middle + p * rng.random_range(0.2..1.5));
            }
            for [a, b, c] in [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]] {
                mesh.triangles.extend([[a, b, c], [b, a, 5]].map(|t| t.map(|i| i + start)));
            }
        }
        if rng.random_bool(0.3) {
            mesh.triangles.swap_remove(rng.random_range(0..mesh.triangles.len()));
        }
        Arc::new(Shape::new(Distance::new(&mesh).expect("a mesh")))
    }

    fn each(name: &str, mut law: impl FnMut(&Graph, NodeId, &mut StdRng)) {
        let mut rng = seeded(name);
        for _ in 0..300 {
            let mut g = Graph::default();
            let depth = rng.random_range(1..5);
            let root = grow(&mut g, &mut rng, depth);
            law(&g, root, &mut rng);
        }
    }

    fn region(rng: &mut StdRng) -> [Interval; 3] {
        std::array::from_fn(|_| {
            let (c, r) = (coordinate(rng), radius(rng));
            if rng.random_bool(0.3) { Interval::new(c, c + r) } else { Interval::new(c - r, c + r) }
        })
    }

    #[test]
    fn every_enclosure_contains_samples() {
        let mut sharp = 0;
        each("composites", |g, root, rng| {
            let mut field = Field::new(g, root);
            let tape = field.tape().clone();
            for _ in 0..8 {
                let x = region(rng);
                let range = field.range(&x);
                let slope = field.slope(&x);
                let jet = field.jet_range(&x);
                let affine = Evaluator::<Affine>::new(tape.clone()).eval(&x.map(Affine::over)).range;
                let cell = std::array::from_fn(|axis| {
                    let mut spread = [0.0; 3];
                    spread[axis] = x[axis].rad();
                    Reduced::<3>::new(x[axis].mid(), spread)
                });
                let reduced = Evaluator::<Reduced<3>>::new(tape.clone()).eval(&cell).range;
                sharp += usize::from(range.is_finite() && range.width() < 1e3);
                for _ in 0..20 {
                    let p = x.map(|x| inside(rng, x));
                    let at: Jet = field.jet(p.into());
                    if at.value.is_nan() {
                        continue;
                    }
                    // The value itself is rounded: its own enclosure at the point says by how much.
                    let v = field.range(&p.map(Interval::point));
                    for (what, e) in [
                        ("range", range),
                        ("slope", slope.value),
                        ("jet", jet.value),
                        ("affine", affine),
                        ("reduced", reduced),
                    ] {
                        assert!(e.lo <= v.hi && v.lo <= e.hi, "{what} {e:?} misses {v:?} at {p:?} of {x:?}");
                    }
                    if at.grad.iter().chain(&at.hess).all(|d| d.is_finite()) {
                        let exact = field.slope(&p.map(Interval::point));
                        for i in 0..3 {
                            let (e, d) = (slope.grad[i], exact.grad[i]);
                            assert!(e.lo <= d.hi && d.lo <= e.hi, "gradient {e:?} misses {d:?}");
                        }
                        let norm = at.grad.iter().map(|g| g * g).sum::<f64>().sqrt();
                        assert!(
                            norm <= slope.norm * (1.0 + 1e-9) + 1e-9 || exact.norm > 1.0001 * norm,
                            "{norm} {slope:?}"
                        );
                    }
                }
            }
        });
        assert!(sharp > 600, "only {sharp} enclosures say anything");
    }

    #[test]
    fn every_parabola_contains_samples_and_knows_its_signs() {
        const LANES: usize = 8;
        let (mut above, mut below, mut inside_lines) = (0, 0, 0);
        each("parabolas", |g, root, rng| {
            let mut field = Field::new(g, root);
            let tape = field.tape().clone();
            let mut batch = Evaluator::<Parabolas<LANES, 2>>::new(tape.clone());
            let mut single = Evaluator::<Parabolas<1, 2>>::new(tape);
            let pieces: [[Parabola<2>; 3]; LANES] = std::array::from_fn(|_| any_piece(rng));
            let mut p = pieces[0].map(Parabolas::all);
            for (lane, piece) in pieces.iter().enumerate() {
                (0..3).for_each(|axis| p[axis].set(lane, &piece[axis]));
            }
            let answers = *batch.eval(&p);
            for (lane, piece) in pieces.iter().enumerate() {
                let z = answers.lane(lane);
                let alone = single.eval(&piece.map(Parabolas::all)).lane(0);
                assert_eq!(format!("{z:?}"), format!("{alone:?}"), "a lane depends on its neighbours");
                let halves = z.halves();
                // Places at random, and those said to be negative.
                let ends = [halves[0].below.map(|e| -e), halves[1].below];
                let said = ends.into_iter().flatten().filter(|e| e.abs() < 1.0);
                let anywhere: Vec<f64> = (0..20).map(|_| inside(rng, Interval::new(-1.0, 1.0))).collect();
                for e in anywhere.into_iter().chain(said) {
                    let u = std::array::from_fn(|_| inside(rng, Interval::new(-1.0, 1.0)));
                    let at = piece.each_ref().map(|x| at_place(x, e, u));
                    if field.value(at.into()).is_nan() {
                        continue;
                    }
                    // A point as rounded as the piece's own coordinates are.
                    let cell = std::array::from_fn(|axis| {
                        Interval::around(at[axis], 8.0 * f64::EPSILON * piece[axis].range.mag())
                    });
                    let v = field.range(&cell);
                    // What is left of the form on the line through the place.
                    let line = z.at(u, [0.0; 2]);
                    for allowed in [band(&z, e, u), band(&line, e, []), z.range] {
                        assert!(
                            !(allowed.lo > v.hi || v.lo > allowed.hi),
                            "{v:?} is outside {allowed:?} at {e}, {u:?} of {piece:?}"
                        );
                    }
                    let holds = |[from, to]: [f64; 2]| from <= e.abs() && e.abs() <= to && from < to;
                    let side = usize::from(e > 0.0);
                    if holds(line.halves()[side].below) {
                        inside_lines += 1;
                        assert!(v.lo < 0.0, "{v:?} at {e}, said to be negative by {line:?}");
                    }
                    let half = &halves[side];
                    if holds(half.above) {
                        above += 1;
                        assert!(v.hi > 0.0, "{v:?} at {e}, said to be positive by {z:?}");
                    }
                    if holds(half.below) {
                        below += 1;
                        assert!(v.lo < 0.0, "{v:?} at {e}, said to be negative by {z:?}");
                    }
                }
            }
        });
        assert!(
            above > 5000 && below > 50 && inside_lines > 1000,
            "only {above}, {below} and {inside_lines} certain signs"
        );
    }

    #[test]
    fn batches_and_pruned_tapes_give_the_same_bits() {
        let mut shorter = 0;
        // One that evaluates whatever it is given, after all that it was given before.
        let mut reused: Option<Evaluator<f64>> = None;
        each("tapes", |g, root, rng| {
            let tape = Arc::new(Tape::new(g, &[root]));
            let x = region(rng);
            let pruned = Arc::new(tape.prune(&x));
            shorter += usize::from(pruned.len() < tape.len());
            let mut full = Evaluator::<f64>::new(tape.clone());
            let reused = reused.get_or_insert_with(|| full.clone());
            let mut less = full.clone();
            less.load(pruned);
            reused.load(tape.clone());
            let mut batch = Evaluator::<Many<f64, 8>>::new(tape.clone());
            let mut duals = Evaluator::<Dual>::new(tape.clone());
            let mut dual_batch = Evaluator::<Many<Dual, 8>>::new(tape);
            let points: [[f64; 3]; 8] = std::array::from_fn(|_| x.map(|x| inside(rng, x)));
            let lanes = std::array::from_fn(|axis| Many(points.map(|p| p[axis])));
            let values = batch.eval(&lanes).0;
            let dual_lanes =
                std::array::from_fn(|axis| Many(points.map(|p| Dual::coordinate(p[axis], axis))));
            let slopes = dual_batch.eval(&dual_lanes).0;
            for (lane, p) in points.iter().enumerate() {
                let value = *full.eval(p);
                // The sign of a NaN is nobody's promise.
                let same =
                    value.to_bits() == values[lane].to_bits() || (value.is_nan() && values[lane].is_nan());
                assert!(same, "{value} {}: a batch differs at {p:?}", values[lane]);
                let short = *less.eval(p);
                assert!(
                    value.to_bits() == short.to_bits() || value.is_nan(),
                    "{value} {short}: pruning changed {p:?}"
                );
                let again = *reused.eval(p);
                assert!(
                    value.to_bits() == again.to_bits() || value.is_nan(),
                    "{value} {again}: memory leaked"
                );
                let dual = *duals.eval(&std::array::from_fn(|axis| Dual::coordinate(p[axis], axis)));
                assert_eq!(format!("{dual:?}"), format!("{:?}", slopes[lane]), "a batch of duals differs");
            }
        });
        assert!(shorter > 5, "pruning never shortened a tape");
    }

    #[test]
    fn balls_say_the_same_whatever_their_neighbours() {
        each("balls", |g, root, rng| {
            let mut batch = Evaluator::<Taylors<4>>::new(Arc::new(Tape::new(g, &[root])));
            let balls: [([f64; 3], f64); 4] =
                std::array::from_fn(|_| (std::array::from_fn(|_| coordinate(rng)), radius(rng)));
            let mut ask = |of: [usize; 4]| {
                let mut at: [Taylors<4>; 3] = std::array::from_fn(|_| Number::constant(0.0));
                for (lane, i) in of.into_iter().enumerate() {
                    Taylors::set_ball(&mut at, lane, balls[i].0, balls[i].1);
                }
                let out = batch.eval(&at);
                [0, 1, 2, 3].map(|lane| format!("{:?}", out.lane(lane)))
            };
            let together = ask([0, 1, 2, 3]);
            for (i, together) in together.iter().enumerate() {
                assert_eq!(ask([i; 4])[0], *together, "{:?}\n{g:?}", balls[i]);
            }
        });
    }

    #[test]
    fn equal_expressions_are_one_node() {
        let mut g = Graph::default();
        let (x, y) = (g.input(Input::X).expect("room"), g.input(Input::Y).expect("room"));
        let add = Op::ALL.iter().find(|op| op.name() == "+").copied().expect("a sum");
        let (a, b) = (g.op(add, &[x, y]).expect("room"), g.op(add, &[y, x]).expect("room"));
        assert_eq!(a, b);
        let zero = g.constant(0.0).expect("room");
        assert_eq!(g.op(add, &[a, zero]).expect("room"), a);
    }
}

#[test]
fn high_powers_contain_their_roundings() {
    use orogen::num::Real;
    let mut rng = seeded("powers");
    for n in [3, 60, 65, 257, 1000, 20_000] {
        for _ in 0..500 {
            // Not far from 1, or the power leaves the range of numbers.
            let x = 1.0 + rng.random_range(-1.0..1.0) / f64::from(n);
            let power = Real::powi(Interval::point(x), n);
            let fine = libm::pow(x, f64::from(n));
            assert!(power.contains(fine), "{x}^{n} = {fine:e} outside {power:?}");
        }
    }
}

#[test]
fn lengths_past_the_origin_keep_what_lies_across() {
    use orogen::op::Length;
    for offset in [1e-12, 1e-10, 3e-9, 1e-8, 1e-7, 1e-4] {
        for near in [1e-3 * offset, 0.1 * offset, offset] {
            let x = [
                Reduced::new(0.5 + 0.5 * near, [0.5 - 0.5 * near]),
                Reduced::new(offset, [0.0]),
                Reduced::new(0.0, [0.0]),
            ];
            let z = Reduced::<1>::lift(&Length, x.each_ref());
            for i in 0..=1000 {
                let e = -1.0 + 2e-3 * f64::from(i);
                let v = Length.value([x[0].mid + x[0].slope[0] * e, offset, 0.0]);
                let band = z.mid + z.slope[0] * e;
                assert!(
                    (v - band).abs() <= z.rest + 1e-15,
                    "{v:e} is not within {:e} of {band:e} at {offset:e}",
                    z.rest
                );
            }
        }
    }
}

#[test]
fn what_has_no_value_is_not_swallowed() {
    let undefined = f64::NAN;
    for op in Op::ALL {
        for i in 0..op.arity() {
            let args: Vec<f64> = (0..op.arity()).map(|k| if k == i { undefined } else { 0.5 }).collect();
            let value: f64 = op.apply(|k| &args[k]);
            assert!(value.is_nan(), "{} of {args:?} is {value}", op.name());
        }
    }
}
