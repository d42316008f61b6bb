//! Curves against dense sampling, and the laws.

use super::*;
use crate::num::{Kernel, Order};
use crate::shape::curve::{Curve, Degree, Flaw, Kind};
use crate::shape::laws::{anywhere, check, seeded};
use rand::{RngExt, rngs::StdRng};

const KINDS: [Kind; 6] = [
    Kind::Polyline,
    Kind::Bezier(Degree::Two),
    Kind::Bezier(Degree::Three),
    Kind::Bspline(Degree::Two),
    Kind::Bspline(Degree::Three),
    Kind::CatmullRom,
];

fn any(rng: &mut StdRng, kind: Kind) -> Curve {
    let closed: bool = rng.random();
    let count =
        if matches!(kind, Kind::Bezier(_)) { 12 + usize::from(!closed) } else { rng.random_range(3..8) };
    let points: Vec<DVec3> = (0..count).map(|_| anywhere(rng)).collect();
    let radii: Vec<f64> = (0..rng.random_range(1..6)).map(|_| rng.random_range(0.0..0.3)).collect();
    Curve::new(&points, &radii, kind, closed).unwrap()
}

fn value(curve: &Curve, x: DVec3) -> f64 {
    curve.jet(Order::Value, x.into()).value
}

#[test]
fn no_nearest_place_is_missed() {
    let mut rng = seeded(1);
    for kind in KINDS.iter().cycle().take(60) {
        let curve = any(&mut rng, *kind);
        for _ in 0..40 {
            let x = anywhere(&mut rng) * if rng.random() { 1.0 } else { 4.0 };
            let found = value(&curve, x);
            let places = curve
                .strand()
                .pieces()
                .iter()
                .flat_map(|p| (0..=400).map(|i| p.read(x, f64::from(i) / 400.0)));
            let dense = places.fold(f64::INFINITY, |least: f64, r| least.min(r.value));
            assert!(found <= dense + 1e-11, "{found} is not the least: {dense}, {kind:?}");
            assert!(found >= dense - 1e-3, "{found} is below all: {dense}, {kind:?}");
        }
    }
}

#[test]
fn curves_keep_the_laws() {
    let mut rng = seeded(2);
    for kind in KINDS {
        let curve = any(&mut rng, kind);
        check(&curve, &mut rng, 60, |rng| 1.5 * anywhere(rng));
    }
}

#[test]
fn bows_are_quadratic_where_the_curve_is_smooth() {
    let points: Vec<DVec3> =
        (0..8).map(|i| DVec3::new(f64::from(i) * 0.5, libm::sin(f64::from(i)) * 0.3, 0.0)).collect();
    let curve = Curve::new(&points, &[0.1, 0.2], Kind::CatmullRom, false).unwrap();
    for radius in [1e-4, 1e-3, 1e-2] {
        let local = curve.local(Order::Gradient, [1.3, 0.5, 0.1], radius);
        assert!(local.bow.width() < 10.0 * radius * radius, "{local:?}");
    }
}

#[test]
fn round_cones_have_the_exact_distance() {
    // The tangent cone of two balls, seen from the side: its slope is that of the radii.
    let ends = [DVec3::ZERO, DVec3::X * 2.0];
    let cone = Curve::new(&ends, &[1.0, 0.4], Kind::Polyline, false).unwrap();
    let k: f64 = 0.3;
    let normal = DVec3::new(k, (1.0 - k * k).sqrt(), 0.0);
    for along in [0.2, 0.9, 1.7] {
        let surface = DVec3::X * along + normal * (1.0 - k * along);
        for away in [-0.05, 0.0, 0.7, 3.0] {
            assert!((value(&cone, surface + normal * away) - away).abs() < 1e-12);
        }
    }
    // One ball within the other is that other, whichever comes first.
    for radii in [[1.0, 3.5], [3.5, 1.0]] {
        let ball = Curve::new(&ends, &radii, Kind::Polyline, false).unwrap();
        let centre = if radii[1] > radii[0] { ends[1] } else { ends[0] };
        let x = DVec3::new(0.3, 5.0, -2.0);
        assert!((value(&ball, x) - ((x - centre).length() - 3.5)).abs() < 1e-12);
    }
}

#[test]
fn curves_of_every_kind_go_where_they_should() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::new(2.0, 1.0, 0.0), DVec3::new(2.0, 2.0, 1.0)];
    let passes = |curve: &Curve, p: DVec3| assert!(value(curve, p).abs() < 1e-11, "{p} is not on the curve");
    let make = |kind, closed| Curve::new(&points, &[0.0], kind, closed).unwrap();
    for closed in [false, true] {
        points.iter().for_each(|p| passes(&make(Kind::CatmullRom, closed), *p));
        points.iter().for_each(|p| passes(&make(Kind::Polyline, closed), *p));
    }
    for degree in [Degree::One, Degree::Two, Degree::Three] {
        let open = make(Kind::Bspline(degree), false);
        passes(&open, points[0]);
        passes(&open, points[3]);
    }
    let closed = make(Kind::Bspline(Degree::Three), true);
    passes(&closed, (points[3] + 4.0 * points[0] + points[1]) / 6.0);
    let bezier = make(Kind::Bezier(Degree::Three), false);
    passes(&bezier, (points[0] + 3.0 * points[1] + 3.0 * points[2] + points[3]) / 8.0);
}

#[test]
fn what_is_no_curve_says_so() {
    let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let flaw = |points: &[DVec3], radii: &[f64], kind| Curve::new(points, radii, kind, false).err();
    assert!(matches!(flaw(&[], &[0.1], Kind::Polyline), Some(Flaw::Count { .. })));
    assert!(matches!(flaw(&p[..1], &[0.1], Kind::Polyline), Some(Flaw::Count { .. })));
    assert!(matches!(flaw(&p, &[-0.1], Kind::Polyline), Some(Flaw::Radius { at: 0, .. })));
    assert!(matches!(flaw(&p, &[0.1, f64::NAN], Kind::Polyline), Some(Flaw::Radius { at: 1, .. })));
    assert!(matches!(flaw(&p, &[], Kind::Polyline), Some(Flaw::NoRadius)));
    assert!(matches!(flaw(&[DVec3::X, DVec3::NAN], &[0.1], Kind::CatmullRom), Some(Flaw::Point(1))));
    assert!(matches!(flaw(&p, &[0.1], Kind::Bezier(Degree::Two)), Some(Flaw::Rest { .. })));
}

#[test]
fn curves_without_length_and_of_many_points_work() {
    let mut rng = seeded(3);
    for kind in [Kind::Polyline, Kind::CatmullRom, Kind::Bspline(Degree::Three)] {
        // A point thrice, and then there and back.
        let still = Curve::new(&[DVec3::X; 3], &[0.2], kind, false).unwrap();
        assert!((value(&still, DVec3::ZERO) - 0.8).abs() < 1e-11);
        check(&still, &mut rng, 10, anywhere);
        let back = Curve::new(&[DVec3::X, DVec3::Y, DVec3::X, DVec3::X], &[0.1], kind, true).unwrap();
        check(&back, &mut rng, 10, anywhere);
        let many: Vec<DVec3> = (0..100_000)
            .map(|i| {
                let (sin, cos) = libm::sincos(f64::from(i) * 1e-3);
                DVec3::new(cos, sin, f64::from(i) * 1e-5)
            })
            .collect();
        let spiral = Curve::new(&many, &[0.01], kind, false).unwrap();
        assert!((value(&spiral, many[777]) + 0.01).abs() < 1e-4);
    }
}

/// The bits of what is known to be straight are others.
#[test]
fn what_is_known_to_be_straight_is_another_strand() {
    let piece = Piece::straight(DVec4::ZERO, DVec4::new(1.0, 0.0, 0.0, 0.2));
    let digest = |plain: bool| {
        let mut digest = Digest::default();
        Strand::new([(piece, plain)]).digest(&mut digest);
        digest
    };
    assert_eq!(digest(true), digest(true));
    assert_ne!(digest(true), digest(false));
}
