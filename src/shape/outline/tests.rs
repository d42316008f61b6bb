//! Outlines against dense polygons, and the laws.

use super::*;
use crate::shape::laws::{anywhere, check, seeded};
use rand::{RngExt, rngs::StdRng};
use std::f64::consts::TAU;

fn value(o: &Outline, x: f64, y: f64) -> f64 {
    o.jet(Order::Value, DVec3::new(x, y, 0.3)).value
}

fn polygon(loops: &[&[[f64; 2]]]) -> Outline {
    let mut pen = Pen::default();
    for points in loops {
        pen.jump(points[0].into());
        points[1..].iter().for_each(|p| pen.line((*p).into()));
    }
    Outline::new(pen).unwrap()
}

/// A random drawing, and the same as dense polygons.
fn drawing(rng: &mut StdRng) -> (Outline, Vec<Vec<DVec2>>) {
    let (mut pen, mut loops) = (Pen::default(), Vec::new());
    for _ in 0..rng.random_range(1..4) {
        let mut p = || anywhere(rng).truncate();
        let mut here = p();
        pen.jump(here);
        let mut dense = vec![here];
        for side in 0..4 {
            let (a, b, to) = (p(), p(), p());
            let curve = |t: f64| {
                let s = 1.0 - t;
                match side {
                    0 => s * s * here + 2.0 * s * t * a + t * t * to,
                    1 => s * s * s * here + 3.0 * s * s * t * a + 3.0 * s * t * t * b + t * t * t * to,
                    _ => s * here + t * to,
                }
            };
            dense.extend((1..=1000).map(|i| curve(f64::from(i) / 1000.0)));
            match side {
                0 => pen.quadratic(a, to),
                1 => pen.cubic(a, b, to),
                _ => pen.line(to),
            }
            here = to;
        }
        let (last, first) = (here, dense[0]);
        dense.extend((1..1000).map(|i| last.lerp(first, f64::from(i) / 1000.0)));
        loops.push(dense);
    }
    (Outline::new(pen).unwrap(), loops)
}

#[test]
fn signs_are_those_of_the_winding_number() {
    let mut rng = seeded(1);
    for _ in 0..30 {
        let (outline, loops) = drawing(&mut rng);
        for _ in 0..60 {
            let p = anywhere(&mut rng).truncate();
            let (mut turns, mut near) = (0.0, f64::INFINITY);
            for dense in &loops {
                for k in 0..dense.len() {
                    let (a, b) = (dense[k] - p, dense[(k + 1) % dense.len()] - p);
                    turns += libm::atan2(a.perp_dot(b), a.dot(b)) / TAU;
                    near = near.min(a.length());
                }
            }
            let found = value(&outline, p.x, p.y);
            if near > 1e-3 {
                assert_eq!(found < 0.0, turns.round() != 0.0, "{p} {turns}");
                // What is drawn within does not count, so that the distance is at least that to all.
                assert!(found.abs() > near - 3e-3, "{found} {near} at {p}");
            }
        }
    }
}

#[test]
fn outlines_keep_the_laws() {
    let mut rng = seeded(2);
    for _ in 0..4 {
        let (outline, _) = drawing(&mut rng);
        check(&outline, &mut rng, 40, |rng| {
            let x = 1.3 * anywhere(rng);
            let p = outline.jet(Order::Gradient, x);
            // Close to the outline as often as not.
            let back = if rng.random() { 0.0 } else { p.value * rng.random_range(0.9..1.1) };
            x - back * DVec3::from(p.grad)
        });
    }
}

#[test]
fn bows_are_small_at_the_outline_itself() {
    let square = polygon(&[&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]]);
    let on_edge = square.local(Order::Gradient, [0.5, 1.0, 0.0], 0.1);
    assert_eq!(on_edge.jet.grad, [0.0, 1.0, 0.0]);
    assert!(on_edge.bow.mag() < 1e-10, "{on_edge:?}");
    let circle = Outline::new(drawn("M 1 0 A 1 1 0 1 0 -1 0 A 1 1 0 1 0 1 0").unwrap()).unwrap();
    for radius in [1e-4, 1e-3, 1e-2] {
        let local = circle.local(Order::Gradient, [0.6, 0.8 + 1e-9, 0.0], radius);
        assert!(local.bow.mag() < 4.0 * radius * radius + 1e-10, "{local:?}");
    }
}

#[test]
fn loops_that_cross_or_touch_have_one_outline() {
    // The pentagram is whole under the nonzero rule.
    let star: Vec<[f64; 2]> = (0..5)
        .map(|k| {
            let (sin, cos) = libm::sincos(f64::from(2 * k) / 5.0 * TAU);
            [-sin, cos]
        })
        .collect();
    assert!((value(&polygon(&[&star]), 0.0, 0.0) + 0.381_966).abs() < 1e-5);
    let square = |x: f64| [[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 2.0], [x, 2.0]];
    // Edges partly on one another, and a common edge of two neighbours.
    assert_eq!(value(&polygon(&[&square(0.0), &square(1.0)]), 1.5, 1.0), -1.0);
    assert_eq!(value(&polygon(&[&square(0.0), &square(2.0)]), 2.0, 1.0), -1.0);
    // A loop the other way round is a hole.
    let mut hole = square(0.0).map(|[x, y]| [0.5 * x + 0.5, 0.5 * y + 0.5]);
    hole.reverse();
    let frame = polygon(&[&square(0.0), &hole]);
    assert_eq!((value(&frame, 1.0, 1.0), value(&frame, 0.25, 1.0)), (0.5, -0.25));
}

#[test]
fn paths_are_read_as_svg_has_them() {
    let circles = [
        "M 1 0 A 1 1 0 1 0 -1 0 A 1 1 0 1 0 1 0 Z",
        "M1 0A1 1 0 0 1-1 0a1 1 90 012 0z",
        "M 1,0 A 1 1 0 0 1 0 1 A 1,1,0,1,1,1 0",
    ];
    for path in circles {
        let circle = Outline::new(drawn(path).unwrap()).unwrap();
        for [x, y] in [[0.3, 0.2], [2.0, 1.0], [-0.5, 0.1], [0.0, -1.5], [-3.0, -2.0]] {
            assert!((value(&circle, x, y) - ((x * x + y * y).sqrt() - 1.0)).abs() < 1e-9, "{path}");
        }
    }
    let ellipse = Outline::new(drawn("M 0 2 A 2 1 90 0 0 0 -2 A 2 1 90 0 0 0 2").unwrap()).unwrap();
    assert!((value(&ellipse, 1.5, 0.0) - 0.5).abs() < 1e-9);
    // Smooth curves go on from their mirrored pulls, and y goes down in the text.
    for [a, b] in [
        ["m0 0l1 0v1h-1z", "M 0 0 L 1 0 L 1 1 L 0 1"],
        ["M0 0Q.5-1 1 0T2 0Z", "M 0 0 Q 0.5 -1 1 0 Q 1.5 1 2 0 Z"],
        ["M0 0C0 1 1 1 1 0S2-1 2 0L2 2Z", "M0 0C0 1 1 1 1 0C1-1 2-1 2 0L2 2Z"],
    ] {
        let [a, b] = [a, b].map(|path| Outline::new(drawn(path).unwrap()).unwrap());
        for [x, y] in [[0.5, -0.5], [1.4, 0.3], [0.2, 0.1], [-1.0, -1.0]] {
            assert!((value(&a, x, y) - value(&b, x, y)).abs() < 1e-12);
        }
    }
    assert!(value(&polygon(&[&[[0.0, 0.0], [1.0, 0.0], [0.0, -1.0]]]), 0.2, -0.2) < 0.0);
    for (path, at) in [
        ("", 1),
        ("L 1 0", 1),
        ("M 0 0 L 1", 10),
        ("M 0 0 X", 7),
        ("M 0 0 A 1 1 0 3 0 1 1", 15),
        ("M 0 0 L 1 1 é", 13),
        ("5 5", 1),
    ] {
        assert_eq!(drawn(path).unwrap_err().at, at, "{path}");
    }
}

#[test]
fn letters_are_where_they_should_be() {
    let font = Font::new(dejavu::sans::regular()).unwrap();
    let set = |text: &str, align| {
        Outline::new(font.write(text, &Layout { size: 1.0, align, leading: 1.5 })).unwrap()
    };
    let letter = set("o", Align::Left);
    // The ring of an o, its hole, and what is beside it.
    assert!(
        value(&letter, 0.3, 0.27) > 0.0
            && value(&letter, 0.09, 0.27) < 0.0
            && value(&letter, -0.1, 0.27) > 0.0
    );
    let centred = set("oo\no", Align::Center);
    for (x, y) in [(0.2, 0.1), (0.5, 0.4), (0.1, -1.2)] {
        assert!((value(&centred, x, y) - value(&centred, -x, y)).abs() < 0.01);
    }
    let apart = |text: &str| {
        (0..200)
            .map(|i| value(&set(text, Align::Left), 0.01 * f64::from(i), 0.3))
            .filter(|v| *v < 0.0)
            .count()
    };
    assert!(apart("A V") > 0);
    assert!(matches!(
        Outline::new(font.write("  \n ", &Layout { size: 1.0, align: Align::Left, leading: 1.0 })),
        Err(Flaw::Empty)
    ));
    assert!(Font::new(b"no font").is_none());
}

#[test]
fn drawings_that_enclose_nothing_say_so() {
    let mut line = Pen::default();
    line.jump(DVec2::ZERO);
    line.line(DVec2::X);
    assert!(matches!(Outline::new(line), Err(Flaw::Empty)));
    assert!(matches!(Outline::new(Pen::default()), Err(Flaw::Empty)));
    let mut lost = Pen::default();
    lost.jump(DVec2::ZERO);
    lost.quadratic(DVec2::NAN, DVec2::X);
    assert!(matches!(Outline::new(lost), Err(Flaw::Lost)));
    let many: Vec<[f64; 2]> = (0..100_000)
        .map(|k| {
            let (sin, cos) = libm::sincos(f64::from(k) / 1e5 * TAU);
            [cos, sin]
        })
        .collect();
    assert!((value(&polygon(&[&many]), 0.5, 0.0) + 0.5).abs() < 1e-6);
}

/// What is left of the distance to an edge is rounding: it says nothing of the side that is outside.
#[test]
fn edges_face_outwards_however_close() {
    let corners = [[-0.7, -0.5], [0.7, -0.5], [0.1, 0.8]];
    let outline = polygon(&[&corners]);
    let mut rng = seeded(12);
    for _ in 0..3000 {
        let i = rng.random_range(0..3);
        let [from, to] = [corners[i], corners[(i + 1) % 3]].map(DVec2::from);
        let outwards = -(to - from).perp().normalize();
        let place = from.lerp(to, rng.random_range(0.01..0.99)) + rng.random_range(-1e-15..1e-15) * outwards;
        let gradient = DVec3::from(outline.jet(Order::Gradient, place.extend(0.0)).grad).xy();
        assert!(gradient.distance(outwards) < 1e-9, "{place}: {gradient} for {outwards}");
    }
}

#[test]
fn signs_are_right_far_away_and_across_slits_too_narrow_to_be_told() {
    let square = polygon(&[&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]]);
    for far in [1e3, 1e9, 1e12, 1e15] {
        assert!(value(&square, 0.5, far) > 0.0 && value(&square, -far, 0.5) > 0.0, "{far}");
    }
    let w = 4e-9;
    let blocks = polygon(&[
        &[[-1.0, -1.0], [0.0, -1.0], [0.0, 1.0], [-1.0, 1.0]],
        &[[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [w, 1.0], [0.75 * w, 0.5], [0.5 * w, 0.0], [0.25 * w, -0.5]],
    ]);
    for y in [-0.515, -0.49, 0.2] {
        assert!(value(&blocks, 0.3, y) < 0.0 && value(&blocks, -0.3, y) < 0.0, "{y}");
    }
}
