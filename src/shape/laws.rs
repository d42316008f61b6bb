//! What every shape is held to: enclosures hold what they enclose, bounds bound, derivatives are
//! derivatives, and batches give the bits of single points.

use crate::num::{Affine, Interval, Jet, Jets, Kernel, Many, Number, Order, PAIRS, Point, Reduced, Slope};
use glam::DVec3;
use rand::{RngExt, SeedableRng, rngs::StdRng};

/// A generator of a fixed seed.
pub(super) fn seeded(seed: u64) -> StdRng {
    StdRng::seed_from_u64(seed)
}

/// A point of the cube from -1 to 1.
pub(super) fn anywhere(rng: &mut StdRng) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
}

/// Runs all laws at some of the points.
pub(super) fn check(
    k: &dyn Kernel,
    rng: &mut StdRng,
    count: usize,
    mut at: impl FnMut(&mut StdRng) -> DVec3,
) {
    for _ in 0..count {
        let x = at(rng);
        batches(k, x);
        differences(k, x);
        slab(k, rng, x);
        for radius in [0.0, 1e-7, 1e-3, 0.05, 0.6] {
            ball(k, rng, x, radius);
            boxes(k, rng, x, radius);
        }
    }
    hostile(k);
}

fn jet(k: &dyn Kernel, order: Order, x: DVec3) -> Point {
    k.jet(order, x.into())
}

fn batches(k: &dyn Kernel, x: DVec3) {
    let points: [DVec3; 5] = std::array::from_fn(|i| x * (1.0 + 0.3 * i as f64));
    let axis = |a: usize| points.map(|p| p[a]);
    let (xs, ys, zs) = (axis(0), axis(1), axis(2));
    let (mut value, mut grad, mut hess) = ([0.0; 5], [[0.0; 5]; 3], [[0.0; 5]; 6]);
    let out = Jets {
        value: &mut value,
        grad: Some(grad.each_mut().map(|g| &mut g[..])),
        hess: Some(hess.each_mut().map(|h| &mut h[..])),
    };
    k.jets([&xs, &ys, &zs], out);
    for (lane, p) in points.into_iter().enumerate() {
        let own = jet(k, Order::Hessian, p);
        assert_eq!(own.value.to_bits(), value[lane].to_bits());
        (0..3).for_each(|i| assert_eq!(own.grad[i].to_bits(), grad[i][lane].to_bits()));
        (0..6).for_each(|i| assert_eq!(own.hess[i].to_bits(), hess[i][lane].to_bits()));
        let [value, steep] = [Order::Value, Order::Gradient].map(|order| jet(k, order, p));
        assert_eq!(value.value.to_bits(), own.value.to_bits());
        assert_eq!(steep.grad, own.grad);
    }
}

/// Differences match derivatives unless a crease is near, where the gradients on both sides differ much.
fn differences(k: &dyn Kernel, x: DVec3) {
    let here = jet(k, Order::Hessian, x);
    let h = 1e-5;
    for axis in 0..3 {
        let mut step = DVec3::ZERO;
        step[axis] = h;
        let [lo, hi] = [x - step, x + step].map(|x| jet(k, Order::Gradient, x));
        let quotient = |i: usize| (hi.grad[i] - lo.grad[i]) / (2.0 * h);
        let bend = (0..3).map(|i| quotient(i).abs()).fold(0.0, f64::max);
        let hess = |i: usize| {
            PAIRS.iter().position(|p| *p == (axis.min(i), axis.max(i))).map_or(0.0, |p| here.hess[p])
        };
        let size = (0..3).map(|i| hess(i).abs()).fold(bend, f64::max);
        if size > 300.0 {
            continue;
        }
        let slope = (hi.value - lo.value) / (2.0 * h);
        assert!((slope - here.grad[axis]).abs() < 1e-4 * (1.0 + size), "{slope} {here:?} at {x}");
        let wrong = (0..3).any(|i| (quotient(i) - hess(i)).abs() > 0.05 * (1.0 + size));
        // A crease within the step is the only excuse: then one side is not the other's continuation.
        let kink = |i: usize| (hi.grad[i] + lo.grad[i] - 2.0 * here.grad[i]).abs() > 1e-3 * h * (1.0 + size);
        assert!(!wrong || (0..3).any(kink), "{here:?} differs at {x} by {axis}: {lo:?} {hi:?}");
    }
}

fn ball(k: &dyn Kernel, rng: &mut StdRng, x: DVec3, radius: f64) {
    let l = k.local(Order::Gradient, x.into(), radius);
    let here = jet(k, Order::Gradient, x);
    assert_eq!((l.jet.value, l.jet.grad), (here.value, here.grad));
    let error = k.error(x.abs().max_element() + radius);
    let lean = k.lean(x.into(), radius);
    for _ in 0..10 {
        let h = anywhere(rng).normalize_or_zero() * radius * rng.random_range(0.0..1.0);
        let there = jet(k, Order::Gradient, x + h);
        if let Some(lean) = lean {
            let along = DVec3::from(there.grad).dot(lean.axis.into());
            assert!(along >= lean.least - 2.0 * error[1], "{along} {lean:?} at {x} by {h}");
        }
        let slack = 2.0 * error[0] + 2.0 * error[1] * h.length();
        let bow = there.value - here.value - DVec3::from(here.grad).dot(h);
        assert!(l.bow.lo - slack <= bow && bow <= l.bow.hi + slack, "{bow} {l:?} at {x} by {h}");
        let rise = (there.value - here.value).abs();
        assert!(rise <= l.bounds.lipschitz * h.length() + slack, "{rise} {l:?} at {x} by {h}");
        assert!(there.value.abs() <= l.bounds.range + slack);
        if l.bounds.hessian.is_finite() {
            let bend = 0.5 * l.bounds.hessian * h.length_squared();
            assert!(bow.abs() <= bend + slack, "{bow} {l:?} at {x} by {h}");
            let turn = (DVec3::from(there.grad) - DVec3::from(here.grad)).length();
            assert!(turn <= l.bounds.hessian * h.length() + 4.0 * error[1], "{turn} {l:?} at {x} by {h}");
        }
    }
}

/// What is known of boxes of any shape holds in them.
fn slab(k: &dyn Kernel, rng: &mut StdRng, x: DVec3) {
    let halves = [1e-3, 0.1, 1.0, 30.0, 1e4];
    let sides: [Interval; 3] =
        std::array::from_fn(|i| Interval::around(3.0 * x[i], halves[rng.random_range(0..halves.len())]));
    let known = [Interval::kernel(k, sides.each_ref()), k.over(&sides).unwrap_or(Interval::ENTIRE)];
    for _ in 0..20 {
        // Half of the samples on the faces, where the nearest places are.
        let t: [f64; 3] = std::array::from_fn(|_| rng.random_range(-0.5..1.5_f64).clamp(0.0, 1.0));
        let p: [f64; 3] =
            std::array::from_fn(|i| (sides[i].lo + t[i] * sides[i].width()).clamp(sides[i].lo, sides[i].hi));
        let there =
            Interval::around(k.jet(Order::Value, p).value, k.error(DVec3::from(p).abs().max_element())[0]);
        assert!(
            known.iter().all(|all| all.lo <= there.hi && there.lo <= all.hi),
            "{known:?} misses {there:?} at {p:?} of {sides:?}"
        );
    }
}

fn boxes(k: &dyn Kernel, rng: &mut StdRng, x: DVec3, radius: f64) {
    let sides: [Interval; 3] =
        std::array::from_fn(|i| Interval::around(x[i], radius * rng.random_range(0.0..0.577)));
    let range = Interval::kernel(k, sides.each_ref());
    let slopes: [Slope; 3] = std::array::from_fn(|i| Slope::coordinate(sides[i], i));
    let slope = Slope::kernel(k, slopes.each_ref());
    let jets: [Jet<Interval>; 3] = std::array::from_fn(|i| Jet::coordinate(sides[i], i));
    let second = Jet::<Interval>::kernel(k, jets.each_ref());
    let affine = Affine::kernel(k, sides.map(Affine::over).each_ref()).range;
    let cell: [Reduced<3>; 3] = std::array::from_fn(|i| {
        let mut spread = [0.0; 3];
        spread[i] = sides[i].rad();
        Reduced::new(sides[i].mid(), spread)
    });
    let reduced = Reduced::kernel(k, cell.each_ref());
    let batch = Many::<Interval, 4>::kernel(k, sides.map(|s| Many([s; 4])).each_ref());
    assert_eq!(format!("{:?}", batch.0[2]), format!("{range:?}"));
    for _ in 0..6 {
        let p: [f64; 3] = std::array::from_fn(|i| {
            let t: f64 = rng.random();
            (sides[i].lo + t * sides[i].width()).clamp(sides[i].lo, sides[i].hi)
        });
        let there = k.jet(Order::Gradient, p);
        let e = k.error(p.iter().fold(0.0, |m: f64, x| m.max(x.abs())));
        for (what, all) in [
            ("range", range),
            ("slope", slope.value),
            ("jet", second.value),
            ("affine", affine),
            ("reduced", reduced.range),
        ] {
            let near = Interval::around(there.value, e[0]);
            assert!(
                all.lo <= near.hi && near.lo <= all.hi,
                "{what} {all:?} misses {near:?} at {p:?} of {sides:?}"
            );
        }
        let form: f64 = (0..3)
            .map(|i| {
                if sides[i].rad() > 0.0 {
                    reduced.slope[i] * (p[i] - sides[i].mid()) / sides[i].rad()
                } else {
                    0.0
                }
            })
            .sum();
        let off = (there.value - reduced.mid - form).abs();
        assert!(off <= reduced.rest + e[0] + 1e-12, "{off} {reduced:?} at {p:?} of {sides:?}");
        for i in 0..3 {
            for all in [slope.grad[i], second.grad[i]] {
                let g = there.grad[i];
                assert!(
                    all.lo - e[1] - 1e-12 <= g && g <= all.hi + e[1] + 1e-12,
                    "{all:?} misses {g} at {p:?}"
                );
            }
        }
    }
}

/// Points that are none, or beyond all measure, do no harm, and what has no value is not given one.
fn hostile(k: &dyn Kernel) {
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e150, 1e-320, 0.0];
    for x in odd {
        for y in odd {
            let p = jet(k, Order::Hessian, DVec3::new(x, y, 0.25));
            assert!(p.value.is_nan() || !x.is_nan() && !y.is_nan(), "{p:?} at {x} {y}");
            for radius in [0.0, 1.0, 1e200, f64::INFINITY] {
                let l = k.local(Order::Gradient, [x, y, 0.25], radius);
                assert!(!l.bow.lo.is_nan() && !l.bow.hi.is_nan() && l.bow.lo <= l.bow.hi, "{l:?} at {x} {y}");
            }
        }
    }
}
