//! Polygons to triangles.
//!
//! A convex polygon is a fan around its first corner. Others lose one *ear* after another: a corner
//! that turns the right way and whose triangle holds no other corner. A simple polygon always has one
//! (Meisters, "Polygons have ears", 1975). Whether a corner is an ear changes only when a neighbour is
//! cut, so that `n` corners take time `n^2`.

use crate::exchange::fault::{Fault, Place};
use crate::shape::Mesh;
use glam::{DVec2, DVec3};

/// Corners that a polygon may have if it is not convex: the time for more could be felt.
const MOST_CONCAVE: usize = 512;

/// Adds a face to a mesh, given by numbers of its points; each must be one.
///
/// # Errors
/// When it has too few corners, or is not convex and has too many. The place is left to be filled in.
pub fn add(face: &[u32], mesh: &mut Mesh) -> Result<(), Fault> {
    let n = face.len();
    if n < 3 {
        return Err(Fault::new(Place::Whole, format!("a face needs three corners or more, not {n}")));
    }
    if !split(face, &mesh.points, &mut mesh.triangles) {
        let what = format!("a face that is not convex has {n} corners");
        return Err(Fault::new(Place::Whole, what).remedy(format!(
            "cut it into triangles in the program that made it: {MOST_CONCAVE} corners are possible here"
        )));
    }
    Ok(())
}

/// Appends the triangles of a polygon, given by numbers of points, and says whether it could: concave
/// ones have limits. Those that cross themselves or have no area become fans.
///
/// Each number must be that of a point, and there must be three or more.
fn split(polygon: &[u32], points: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> bool {
    let fan = |corners: &[u32], out: &mut Vec<[u32; 3]>| {
        if let [first, rest @ ..] = corners {
            out.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        }
    };
    if polygon.len() == 3 {
        fan(polygon, triangles);
        return true;
    }
    let flat = flatten(polygon, points);
    let n = flat.len();
    if (0..n).all(|i| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0) {
        fan(polygon, triangles);
        return true;
    }
    if n > MOST_CONCAVE {
        return false;
    }
    let rest = cut_ears(&flat, |corners| triangles.push(corners.map(|i| polygon[i])));
    let rest: Vec<u32> = rest.into_iter().map(|i| polygon[i]).collect();
    fan(&rest, triangles);
    true
}

/// The polygon in the plane of coordinates that it is nearest to, counter-clockwise.
fn flatten(polygon: &[u32], points: &[DVec3]) -> Vec<DVec2> {
    let at = |i: u32| points[i as usize];
    let first = at(polygon[0]);
    // Twice the vector area, as seen from a corner: it loses least to rounding.
    let area: DVec3 = polygon.windows(2).map(|pair| (at(pair[0]) - first).cross(at(pair[1]) - first)).sum();
    let size = area.abs();
    let (u, v, along) = if size.x >= size.y && size.x >= size.z {
        (1, 2, area.x)
    } else if size.y >= size.z {
        (2, 0, area.y)
    } else {
        (0, 1, area.z)
    };
    let (u, v) = if along < 0.0 { (v, u) } else { (u, v) };
    polygon.iter().map(|i| at(*i) - first).map(|p| DVec2::new(p[u], p[v])).collect()
}

/// Positive for a turn to the left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - b)
}

/// Cuts ears while there are any; what is left is one triangle, unless the polygon was not simple.
fn cut_ears(at: &[DVec2], mut cut: impl FnMut([usize; 3])) -> Vec<usize> {
    let mut left: Vec<usize> = (0..at.len()).collect();
    let mut ears: Vec<bool> = (0..left.len()).map(|k| is_ear(at, &left, k)).collect();
    let mut from = 0;
    while left.len() > 3 {
        let n = left.len();
        // On from the last one, so that ears are cut all around and triangles stay stout.
        let Some(k) = (0..n).map(|step| (from + step) % n).find(|k| ears[*k]) else { break };
        cut([left[(k + n - 1) % n], left[k], left[(k + 1) % n]]);
        left.remove(k);
        ears.remove(k);
        let n = n - 1;
        for neighbour in [(k + n - 1) % n, k % n] {
            ears[neighbour] = is_ear(at, &left, neighbour);
        }
        from = (k + 1) % n;
    }
    left
}

/// Whether corner `k` of what is left can be cut.
fn is_ear(at: &[DVec2], left: &[usize], k: usize) -> bool {
    let n = left.len();
    let [a, b, c] = [(k + n - 1) % n, k, (k + 1) % n].map(|k| at[left[k]]);
    let holds = |p: DVec2| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    // A corner may be at the place of another, where an outline leads to a hole and back.
    let others = left.iter().map(|i| at[*i]).filter(|p| ![a, b, c].contains(p));
    turn(a, b, c) > 0.0 && !others.into_iter().any(holds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{mix, uniform};

    /// Twice the areas of the triangles, in the plane `z = 0`.
    fn areas(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| points[i as usize]);
            (b - a).cross(c - a).z
        };
        triangles.iter().map(area).collect()
    }

    fn triangulated(points: &[DVec3]) -> Vec<[u32; 3]> {
        let polygon: Vec<u32> = (0..points.len() as u32).collect();
        let mut triangles = Vec::new();
        assert!(split(&polygon, points, &mut triangles));
        assert_eq!(triangles.len(), points.len() - 2);
        triangles
    }

    #[test]
    fn triangles_of_simple_polygons_cover_them_once() {
        for seed in 0..200_u64 {
            let random = |i: u64| uniform(mix(mix(seed) ^ i));
            let n = 4 + (60.0 * random(0)) as u64;
            // Star-shaped about the origin, so simple.
            let corner = |i: u64| {
                let (sin, cos) =
                    libm::sincos(std::f64::consts::TAU * (i as f64 + 0.9 * random(2 * i + 1)) / n as f64);
                (0.1 + random(2 * i + 2)) * DVec3::new(cos, sin, 0.0)
            };
            let points: Vec<DVec3> = (0..n).map(corner).collect();
            let whole: f64 = (0..n as usize).map(|i| points[i].cross(points[(i + 1) % n as usize]).z).sum();
            let areas = areas(&points, &triangulated(&points));
            assert!(areas.iter().all(|a| *a > 0.0), "{seed}: {areas:?}");
            assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-12 * whole, "{seed}");
        }
    }

    #[test]
    fn polygons_turn_as_they_did() {
        // An L that lies across each axis in turn, both ways round.
        let flat = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        for axis in 0..3 {
            for back in [false, true] {
                let mut points: Vec<DVec3> = flat
                    .iter()
                    .map(|[a, b]| {
                        let mut p = DVec3::splat(0.5);
                        p[(axis + 1) % 3] = *a;
                        p[(axis + 2) % 3] = *b;
                        p
                    })
                    .collect();
                if back {
                    points.reverse();
                }
                let sign = if back { -1.0 } else { 1.0 };
                let area = |t: [u32; 3]| {
                    let [a, b, c] = t.map(|i| points[i as usize]);
                    sign * (b - a).cross(c - a)[axis]
                };
                let areas: Vec<f64> = triangulated(&points).into_iter().map(area).collect();
                assert!(areas.iter().all(|a| *a > 0.0) && areas.iter().sum::<f64>() == 6.0, "{areas:?}");
            }
        }
    }

    #[test]
    fn what_is_not_simple_ends_all_the_same() {
        let bow = [[0., 0.], [1., 1.], [1., 0.], [0., 1.]].map(|[x, y]| DVec3::new(x, y, 0.0));
        triangulated(&bow);
        triangulated(&[DVec3::ONE; 7]);
        triangulated(&[DVec3::splat(1e300), DVec3::X, -DVec3::splat(1e300), DVec3::Y, DVec3::Z]);
        let comb: Vec<DVec3> =
            (0..=MOST_CONCAVE).map(|i| DVec3::new(i as f64, (i % 2) as f64, 0.0)).collect();
        let all: Vec<u32> = (0..comb.len() as u32).collect();
        assert!(!split(&all, &comb, &mut Vec::new()));
    }
}
