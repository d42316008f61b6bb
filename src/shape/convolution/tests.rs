//! Closed forms against quadrature, and the laws.

use super::*;
use crate::num::Number;
use crate::shape::Shape;
use crate::shape::laws::{anywhere, check, seeded};
use rand::{RngExt, rngs::StdRng};
use std::f64::consts::PI;

/// Places and weights of composite quadrature on [0, 1]: Gauss's three points in each of `n` parts.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let off = 0.6_f64.sqrt();
    let own = [(0.0, 8.0 / 18.0), (-off, 5.0 / 18.0), (off, 5.0 / 18.0)];
    let part = |i: usize| own.map(|(x, w)| ((i as f64 + 0.5 + 0.5 * x) / n as f64, w / n as f64));
    (0..n).flat_map(part).collect()
}

/// The integral of the kernel of unit slope at the width, by quadrature.
fn quadrature(p: &Primitive, density: Density, x: DVec3) -> f64 {
    let kernel = |u: DVec3| {
        let square = (x - u).length_squared();
        match density {
            Density::Cauchy(w) => {
                let k = 1.0 / (1.0 + (libm::cbrt(4.0) - 1.0) * square / (w * w));
                k * k
            }
            Density::Compact(w) => {
                let k = (1.0 - square * (1.0 - libm::pow(0.5, 0.4)) / (w * w)).max(0.0);
                k * k
            }
        }
    };
    let along = |at: &dyn Fn(f64) -> DVec3| gauss(1000).iter().map(|(t, w)| w * kernel(at(*t))).sum::<f64>();
    // Along an endless line through the point.
    let line = match density {
        Density::Cauchy(w) => PI * w / (2.0 * (libm::cbrt(4.0) - 1.0).sqrt()),
        Density::Compact(w) => 16.0 / 15.0 * w / (1.0 - libm::pow(0.5, 0.4)).sqrt(),
    };
    match p {
        Primitive::Point(a) => kernel(*a),
        Primitive::Segment([a, b]) => along(&|t| a.lerp(*b, t)) * (b - a).length() / line,
        Primitive::Arc(arc) => along(&|t| arc.at(t)) * arc.length() / line,
        Primitive::Triangle([a, b, c]) => {
            let grid = gauss(60);
            let row = |u: &(f64, f64)| {
                let place = |v: f64| a + (b - a) * (u.0 * (1.0 - v)) + (c - a) * (u.0 * v);
                u.1 * u.0 * grid.iter().map(|(v, w)| w * kernel(place(*v))).sum::<f64>()
            };
            // The plane's integral is pi / s^2, that of the line pi / (2 s).
            grid.iter().map(row).sum::<f64>() * (b - a).cross(c - a).length() * PI / (4.0 * line * line)
        }
    }
}

fn any(rng: &mut StdRng, density: Density) -> Primitive {
    let p: [DVec3; 3] = std::array::from_fn(|_| anywhere(rng));
    let kinds = if matches!(density, Density::Compact(_)) { 2 } else { 4 };
    match rng.random_range(0..kinds) {
        0 => Primitive::Point(p[0]),
        1 => Primitive::Segment([p[0], p[1]]),
        2 => Primitive::Triangle(p),
        _ => Arc::through(p[0], p[1], p[2]).map_or(Primitive::Point(p[0]), Primitive::Arc),
    }
}

fn density(rng: &mut StdRng) -> Density {
    let width = rng.random_range(0.2..1.0);
    if rng.random_bool(0.7) { Density::Cauchy(width) } else { Density::Compact(width) }
}

/// The sum of densities, without threshold and scale.
fn dense(c: &Convolution, x: DVec3) -> f64 {
    c.threshold - c.jet(Order::Value, x).value / c.scale
}

#[test]
fn closed_forms_are_integrals() {
    let mut rng = seeded(1);
    for _ in 0..100 {
        let density = density(&mut rng);
        let primitive = any(&mut rng, density);
        let c = Convolution::new(&[(primitive, 1.0)], density, 0.5).unwrap();
        // On corners, edges and the inside of the primitive itself, too.
        let own = match primitive {
            Primitive::Point(p) => vec![p],
            Primitive::Segment([a, b]) => vec![a, a.lerp(b, 0.3), a.lerp(b, 1.5)],
            Primitive::Triangle([a, b, c]) => vec![a, a.lerp(b, 0.4), (a + b + c) / 3.0, a.lerp(b, 1.7)],
            Primitive::Arc(arc) => vec![arc.at(0.0), arc.at(0.6)],
        };
        for x in own.into_iter().chain((0..4).map(|_| 1.5 * anywhere(&mut rng))) {
            let (found, wanted) = (dense(&c, x), quadrature(&primitive, density, x));
            assert!((found - wanted).abs() < 1e-6, "{found} is not {wanted}: {primitive:?} at {x}");
        }
    }
}

#[test]
fn arcs_are_smooth_across_their_axis_and_whatever_their_length() {
    // Three quarters of a circle about the y axis, and points on the axis.
    let at = |turns: f64| {
        let (sin, cos) = libm::sincos(turns * 2.0 * PI);
        DVec3::new(cos, 0.2, sin)
    };
    let density = Density::Cauchy(0.3);
    let three = Arc::through(at(0.0), at(0.375), at(0.75)).map(Primitive::Arc).unwrap();
    let one = Arc::through(at(0.75), at(0.875), at(1.0)).map(Primitive::Arc).unwrap();
    let [long, whole] = [vec![(three, 1.0)], vec![(three, 1.0), (one, 1.0)]]
        .map(|parts| Convolution::new(&parts, density, 0.5).unwrap());
    for y in [-0.7, 0.2, 0.9] {
        let axis = DVec3::new(0.0, y, 0.0);
        assert!((dense(&long, axis) - quadrature(&three, density, axis)).abs() < 1e-8);
        // A full circle is the same all around, and level at its axis.
        let jet = whole.jet(Order::Hessian, axis);
        assert!(jet.grad[0].abs() < 1e-13 && jet.grad[2].abs() < 1e-13);
        assert!((jet.hess[0] - jet.hess[2]).abs() < 1e-12 && jet.hess[4].abs() < 1e-12);
    }
    assert!(Arc::through(DVec3::ZERO, DVec3::X, DVec3::X * 3.0).is_none());
    assert!(Arc::through(DVec3::X, DVec3::X, DVec3::Y).is_none());
}

#[test]
fn halves_are_the_whole() {
    let mut rng = seeded(2);
    for density in [Density::Cauchy(0.3), Density::Compact(0.3)] {
        let (a, b) = (anywhere(&mut rng), anywhere(&mut rng));
        let m = a.lerp(b, 0.37);
        let whole = Convolution::new(&[(Primitive::Segment([a, b]), 1.0)], density, 0.5).unwrap();
        let halves = [[a, m], [m, b]].map(|s| (Primitive::Segment(s), 1.0));
        let halves = Convolution::new(&halves, density, 0.5).unwrap();
        for _ in 0..50 {
            let x = anywhere(&mut rng);
            assert!((dense(&whole, x) - dense(&halves, x)).abs() < 1e-13);
        }
    }
}

#[test]
fn a_long_thread_is_as_wide_as_said() {
    for density in [Density::Cauchy(0.02), Density::Compact(0.02)] {
        let thread = [(Primitive::Segment([-100.0 * DVec3::X, 100.0 * DVec3::X]), 1.0)];
        let thread = Convolution::new(&thread, density, 0.5).unwrap();
        let jet = thread.jet(Order::Gradient, DVec3::new(0.1, 0.02, 0.0));
        assert!(jet.value.abs() < 1e-9 && (jet.grad[1] - 1.0).abs() < 1e-6, "{jet:?}");
    }
}

#[test]
fn skeletons_keep_the_laws() {
    let mut rng = seeded(3);
    for count in [1, 2, 40] {
        for density in [Density::Cauchy(0.15), Density::Compact(0.15)] {
            let parts: Vec<_> =
                (0..count).map(|_| (any(&mut rng, density), rng.random_range(-0.5..1.0))).collect();
            let c = Convolution::new(&parts, density, 0.5).unwrap();
            check(&c, &mut rng, 25, |rng| 1.5 * anywhere(rng));
        }
    }
}

#[test]
fn bounds_fade_with_the_distance() {
    let mut rng = seeded(4);
    let parts: Vec<_> = (0..200)
        .map(|_| {
            let a = anywhere(&mut rng);
            (Primitive::Segment([a, a + 0.2 * anywhere(&mut rng)]), 1.0)
        })
        .collect();
    let c = Convolution::new(&parts, Density::Cauchy(0.05), 0.5).unwrap();
    let far = c.local(Order::Gradient, [5.0, 0.0, 0.0], 0.5).bounds;
    assert!(far.third < 1e-4 * c.bounds().third && far.lipschitz < 0.1, "{far:?}");
    let compact = Convolution::new(&parts, Density::Compact(0.05), 0.5).unwrap();
    assert_eq!(compact.local(Order::Gradient, [5.0, 0.0, 0.0], 0.5).bounds.lipschitz, 0.0);
}

/// However far a box reaches, and however flat it is, nothing is there.
#[test]
fn far_boxes_are_empty() {
    let parts = [(Primitive::Segment([DVec3::NEG_X, DVec3::X]), 1.0), (Primitive::Point(DVec3::Y), 0.5)];
    for density in [Density::Cauchy(0.2), Density::Compact(0.2)] {
        let c = Convolution::new(&parts, density, 0.5).unwrap();
        let far = [Interval { lo: 1e9, hi: 16e9 }, Interval::radius(16e9), Interval::radius(16e9)];
        for x in [far, [Interval { lo: 4.0, hi: 12.0 }, Interval::radius(12.0), Interval::radius(12.0)]] {
            assert!(Interval::kernel(&c, x.each_ref()).lo > 0.0, "{density:?} {x:?}");
        }
    }
}

#[test]
fn what_is_no_skeleton_says_so() {
    let flaw = |parts: &[(Primitive, f64)], density| Convolution::new(parts, density, 0.5).err();
    let sheet = Primitive::Triangle([DVec3::X, DVec3::Y, DVec3::Z]);
    assert_eq!(flaw(&[], Density::Cauchy(0.1)), Some(Flaw::Count(0)));
    assert_eq!(flaw(&[(Primitive::Point(DVec3::NAN), 1.0)], Density::Cauchy(0.1)), Some(Flaw::Lost(0)));
    assert_eq!(flaw(&[(sheet, f64::INFINITY)], Density::Cauchy(0.1)), Some(Flaw::Lost(0)));
    assert_eq!(flaw(&[(sheet, 1.0)], Density::Compact(0.1)), Some(Flaw::Kernel(0)));
    // What has no length or area is nothing.
    let nothing = [
        (Primitive::Segment([DVec3::X; 2]), 1.0),
        (Primitive::Triangle([DVec3::X, DVec3::Y, DVec3::X]), 1.0),
    ];
    let c = Convolution::new(&nothing, Density::Cauchy(0.1), 0.5).unwrap();
    assert_eq!(dense(&c, DVec3::X), 0.0);
    check(&c, &mut seeded(5), 5, anywhere);
}

/// Four segments have as many numbers as seven points.
#[test]
fn the_same_numbers_in_another_order_are_another_shape() {
    let density = Density::Compact(0.2);
    let segments: Vec<(Primitive, f64)> = (0..4)
        .map(|i| {
            let [a, b] = [0.1, 0.2].map(|x| DVec3::new(x, 0.3 * f64::from(i), 0.5));
            (Primitive::Segment([a, b]), 1.0)
        })
        .collect();
    let segments = Convolution::new(&segments, density, 0.5).unwrap();
    let numbers: Vec<f64> = segments
        .parts
        .iter()
        .flat_map(|(p, weight)| match p {
            Primitive::Segment([a, b]) => [&[*weight][..], &a.to_array(), &b.to_array()].concat(),
            _ => Vec::new(),
        })
        .collect();
    let points: Vec<(Primitive, f64)> =
        numbers.chunks(4).map(|n| (Primitive::Point(DVec3::new(n[1], n[2], n[3])), n[0])).collect();
    let points = Convolution::new(&points, density, 0.5).unwrap();
    assert_eq!((numbers.len(), points.parts.len()), (28, 7));
    assert_ne!(Shape::new(segments), Shape::new(points));
}
