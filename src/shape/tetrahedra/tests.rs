//! Polynomials told cell by cell, and the laws.

use super::*;
use crate::shape::laws::{anywhere, check, seeded};

/// A cube from -1 to 1 in six cells about its diagonal.
fn cube() -> (Vec<DVec3>, Vec<[usize; 4]>) {
    let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64) * 2.0 - 1.0;
    let cells = [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];
    ((0..8).map(corner).collect(), cells.to_vec())
}

/// The coefficients of a polynomial, from its polar form.
fn bernstein(degree: usize, polar: &dyn Fn(&[DVec3]) -> f64) -> Vec<Vec<f64>> {
    let (points, cells) = cube();
    let coefficients = |cell: &[usize; 4]| {
        let at = |power: [usize; 4]| {
            let places: Vec<DVec3> = (0..4).flat_map(|m| vec![points[cell[m]]; power[m]]).collect();
            polar(&places)
        };
        powers(degree).map(at).collect()
    };
    cells.iter().map(coefficients).collect()
}

/// Polar forms of a ball, and of a ball with `x y z` added.
fn ball(v: &[DVec3]) -> f64 {
    v[0].dot(v[1]) - 0.6
}

fn bumps(v: &[DVec3]) -> f64 {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let product: f64 = orders.iter().map(|[a, b, c]| v[*a].x * v[*b].y * v[*c].z).sum();
    product / 6.0 + (v[0].dot(v[1]) + v[1].dot(v[2]) + v[2].dot(v[0])) / 3.0 - 0.6
}

fn over(degree: usize, coefficients: &[Vec<f64>]) -> Result<Tetrahedra, Flaw> {
    let (points, cells) = cube();
    Tetrahedra::new(&points, &cells, degree, coefficients)
}

#[test]
fn the_field_is_the_polynomial_and_goes_on_outside() {
    let mut rng = seeded(1);
    for (degree, polar, k) in [(2, &ball as &dyn Fn(&[DVec3]) -> f64, 0.0), (3, &bumps, 1.0)] {
        let t = over(degree, &bernstein(degree, polar)).unwrap();
        assert_eq!(t.inner_class(), Class::C2);
        for _ in 0..300 {
            let x = 3.0 * anywhere(&mut rng);
            let q = x.clamp(DVec3::NEG_ONE, DVec3::ONE);
            let wanted = q.length_squared() - 0.6 + k * q.x * q.y * q.z + (x - q).length();
            let jet = t.jet(Order::Hessian, x);
            assert!((jet.value - wanted).abs() < 1e-12, "{jet:?} is not {wanted} at {x}");
            let inner = t.jet(Order::Hessian, x / 3.0);
            let [px, py, pz] = (x / 3.0).to_array();
            let slope = DVec3::new(2.0 * px + k * py * pz, 2.0 * py + k * px * pz, 2.0 * pz + k * px * py);
            assert!((DVec3::from(inner.grad) - slope).length() < 1e-12);
            let bend = [2.0, 2.0, 2.0, k * pz, k * py, k * px];
            assert!((0..6).all(|i| (inner.hess[i] - bend[i]).abs() < 1e-11));
        }
        check(&t, &mut rng, 60, |rng| 2.0 * anywhere(rng));
    }
}

#[test]
fn how_smoothly_cells_join_is_found_out() {
    let linear =
        |values: [f64; 8]| cube().1.iter().map(|c| c.map(|i| values[i]).to_vec()).collect::<Vec<_>>();
    let crooked = over(1, &linear([0.0, 1.0, 0.5, -1.0, 2.0, 0.3, 0.7, 0.1])).unwrap();
    assert_eq!(crooked.inner_class(), Class::C0);
    check(&crooked, &mut seeded(2), 40, |rng| 2.0 * anywhere(rng));
    let even = over(1, &linear([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])).unwrap();
    assert_eq!(even.inner_class(), Class::C2);
    // Two cells on both sides of x = 0, with x^2 on one and 0 on the other: C1.
    let points = [DVec3::X, -DVec3::X, DVec3::ZERO, DVec3::Y, DVec3::Z];
    let mut square = vec![0.0; 10];
    square[place([2, 0, 0, 0])] = 1.0;
    let half = Tetrahedra::new(&points, &[[0, 2, 3, 4], [1, 2, 3, 4]], 2, &[square, vec![0.0; 10]]).unwrap();
    assert_eq!(half.inner_class(), Class::C1);
    check(&half, &mut seeded(3), 40, anywhere);
}

#[test]
fn what_is_no_region_says_so() {
    let (points, cells) = cube();
    let zeros = |n: usize| vec![vec![0.0; 4]; n];
    let flaw = |cells: &[[usize; 4]]| Tetrahedra::new(&points, cells, 1, &zeros(cells.len())).err();
    assert_eq!(flaw(&[]), Some(Flaw::Count(0)));
    assert_eq!(flaw(&[[0, 1, 2, 2]]), Some(Flaw::Flat(0)));
    assert_eq!(flaw(&[[0, 1, 2, 3]]), Some(Flaw::Flat(0)));
    assert_eq!(flaw(&[[0, 1, 2, 9]]), Some(Flaw::Corner(0)));
    assert_eq!(flaw(&[[0, 1, 2, 4], [0, 1, 2, 6]]), Some(Flaw::Overlap(0, 1)));
    assert!(matches!(flaw(&cells[..5]), Some(Flaw::Dent { .. })));
    let mut jump = bernstein(2, &ball);
    jump[0][place([1, 0, 1, 0])] += 0.1;
    assert!(matches!(over(2, &jump), Err(Flaw::Jump(..))));
    jump[0].pop();
    assert_eq!(over(2, &jump).err(), Some(Flaw::Coefficients { cell: 0, given: 9, wanted: 10 }));
    jump[0].push(f64::NAN);
    assert_eq!(over(2, &jump).err(), Some(Flaw::Lost { cell: 0, at: 9 }));
    assert_eq!(over(7, &jump).err(), Some(Flaw::Degree(7)));
}
