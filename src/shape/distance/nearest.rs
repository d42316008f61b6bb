//! The nearest place of a triangle.
//!
//! It is in its plane, if the foot of the perpendicular is within its edges, else on the nearest of its
//! edges. With `q` the vector to the nearest place of the edges, `n` the triangle's normal and `u` the
//! roundoff,
//!
//! ```text
//! distance to the edges  |q|                       off by a few u times the distance of the corners
//! distance to the plane  |n . q| / |n|             off by |dn| |w|  +  |dn|^2 |q| / 2
//! ```
//!
//! where `dn` is the error of the unit normal, `|dn| <= 7 u / sin A` for the angle `A` between the edges
//! that are multiplied, and `w` leads from the foot to the nearest edge. The largest angle is chosen
//! for `A`, opposite the longest edge, and `|w|` is less than half the height on that edge, which is at
//! most `|ab| sin A`. So the first term is a few `u |ab|`: it is the plane *through the nearest place of
//! the edges* that keeps thin triangles exact. The second term is below `u |q|` as long as
//! `sin A > 1e-7`; of a triangle that is thinner only the edges count, which is off by half its height,
//! and the height is known ([`gap`]).

use super::closed::Corners;
use crate::num::ROUNDOFF;
use glam::DVec3;

/// Below this sine of its largest angle only the edges of a triangle count.
const THIN: f64 = 1e-7;
/// Below this sine a triangle has no area that numbers could tell.
const FLAT: f64 = 16.0 * ROUNDOFF;

/// A triangle turned so that its longest edge is opposite its first corner; none if it has no area.
pub(super) fn turned([a, b, c]: Corners) -> Option<Corners> {
    let [ab, bc, ca] = [b - a, c - b, a - c].map(DVec3::length_squared);
    let t = if bc >= ab && bc >= ca {
        [a, b, c]
    } else if ca >= ab {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let least = if ab < bc { ab } else { bc };
    let least = if ca < least { ca } else { least };
    (least > 0.0 && sine_squared(&t) > FLAT * FLAT).then_some(t)
}

/// The square of the sine of the angle at the first corner.
fn sine_squared([a, b, c]: &Corners) -> f64 {
    let (ab, ac) = (b - a, c - a);
    ab.cross(ac).length_squared() / (ab.length_squared() * ac.length_squared())
}

/// Whether a triangle is too thin for its normal to be known to nine digits or so.
pub(super) fn is_thin(t: &Corners) -> bool {
    sine_squared(t) < 1e-12
}

/// How far a place of the triangle is from what counts of it, at most: zero unless it is thin.
pub(super) fn gap(t: &Corners) -> f64 {
    if sine_squared(t) > 1.01 * THIN * THIN {
        return 0.0;
    }
    let ([a, b, c], up) = (t, 1.0 + 1e-6);
    let (ab, ac, bc) = (b - a, c - a, c - b);
    // The height, of which the sine may be off by as much as makes triangles flat.
    ab.length() * ac.length() / bc.length() * (sine_squared(t).sqrt() + FLAT) * up
}

/// What part of a triangle is nearest.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Feature {
    /// The inside.
    Face,
    /// An edge, which has this direction.
    Edge(DVec3),
    /// A corner.
    Corner,
}

/// The nearest place of a segment, as seen from the origin: where it is, how far along, how far away.
#[derive(Clone, Copy)]
struct Side {
    to: DVec3,
    along: f64,
    square: f64,
}

#[inline(always)]
pub(super) fn choose<T>(yes: bool, a: T, b: T) -> T {
    if yes { a } else { b }
}

#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    choose(a > b, a, b)
}

#[inline(always)]
fn pick(yes: bool, a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(choose(yes, a.x, b.x), choose(yes, a.y, b.y), choose(yes, a.z, b.z))
}

#[inline(always)]
fn side(start: DVec3, edge: DVec3) -> Side {
    let along = -start.dot(edge) / edge.dot(edge);
    let along = choose(along > 0.0, choose(along < 1.0, along, 1.0), 0.0);
    let to = start + edge * along;
    Side { to, along, square: to.dot(to) }
}

/// A triangle as seen from a point.
struct Seen {
    sides: [Side; 3],
    edges: [DVec3; 3],
    /// Which side is nearest.
    nearest: usize,
    /// Not of unit length.
    normal: DVec3,
    /// Height of the nearest side above the point, along the normal; not of unit length.
    height: f64,
    /// Whether the foot of the perpendicular is inside.
    is_face: bool,
    square: f64,
}

#[inline(always)]
fn see([a, b, c]: Corners, x: DVec3) -> Seen {
    let edges = [b - a, c - b, a - c];
    let [ab, bc, ca] = edges;
    let (from_a, from_b, from_c) = (a - x, b - x, c - x);
    let sides = [side(from_a, ab), side(from_b, bc), side(from_c, ca)];
    let second = sides[1].square < sides[0].square;
    let least = choose(second, sides[1].square, sides[0].square);
    let third = sides[2].square < least;
    let least = choose(third, sides[2].square, least);
    let to = pick(third, sides[2].to, pick(second, sides[1].to, sides[0].to));

    let normal = ca.cross(ab);
    let area = normal.dot(normal);
    // The foot's shares of the corners b and c, times the area: each is on the inner side of an edge.
    let (by_b, by_c) = (normal.dot(from_a.cross(ca)), normal.dot(from_a.cross(ab)));
    let inner = (by_b >= 0.0) & (by_c >= 0.0) & (by_b + by_c <= area);
    let is_face = inner & (area > THIN * THIN * (ab.dot(ab) * ca.dot(ca)));
    let height = normal.dot(to);
    let above = height * (height / area);
    Seen {
        sides,
        edges,
        nearest: choose(third, 2, choose(second, 1, 0)),
        normal,
        height,
        is_face,
        square: choose(is_face, above, least),
    }
}

impl Seen {
    /// Unit vector from the nearest place to the point, if they are apart; for a face along its normal.
    #[inline(always)]
    fn away(&self) -> DVec3 {
        let [a, b, c] = self.sides.map(|side| side.to);
        let to = pick(self.nearest == 2, c, pick(self.nearest == 1, b, a));
        let normal = pick(self.height <= 0.0, self.normal, -self.normal);
        let away = pick(self.is_face, normal, -to);
        away / away.length()
    }
}

/// The nearest place of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Unit vector from the place to the point, if they are apart; for a face along its normal.
    pub away: DVec3,
    /// Unit normal of the triangle.
    pub normal: DVec3,
    /// What is nearest.
    pub feature: Feature,
}

/// The nearest place of a triangle to `x`.
pub(super) fn place(t: Corners, x: DVec3) -> Place {
    let seen = see(t, x);
    let Side { along, .. } = seen.sides[seen.nearest];
    let edge = seen.edges[seen.nearest];
    let feature = if seen.is_face {
        Feature::Face
    } else if along > 0.0 && along < 1.0 {
        Feature::Edge(edge / edge.length())
    } else {
        Feature::Corner
    };
    Place { away: seen.away(), normal: seen.normal / seen.normal.length(), feature }
}

/// The square of the distance from `x` to a triangle.
#[inline(always)]
pub(super) fn square(t: Corners, x: DVec3) -> f64 {
    see(t, x).square
}

/// The same, and the unit vector from the nearest place to `x`.
#[inline(always)]
pub(super) fn square_and_away(t: Corners, x: DVec3) -> (f64, DVec3) {
    let seen = see(t, x);
    (seen.square, seen.away())
}
