//! The nearest place of a surface.
//!
//! **One triangle.** Its nearest place is in its plane, if the foot of the perpendicular is within its
//! edges, else on the nearest of its edges. With `q` the vector to the nearest place of the edges, `n`
//! the triangle's normal and `u` the roundoff,
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
//!
//! **All triangles.** A hierarchy of boxes is gone through depth first, the nearest box first. What is
//! farther than the nearest triangle so far *by more than both may be off* is left out; so every
//! triangle whose computed distance could be the least is looked at, wherever the search begins. The
//! least computed distance wins, of equal ones the triangle of the lowest number: the answer has the
//! same bits whatever the search begins with, and neighbouring points may begin with the triangle that
//! the one before ended with.

use super::closed::Corners;
use super::tree::{BLOCK, Block, IS_BLOCK, Node, PASSED, Tree, WIDE, in_frame};
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
fn choose<T>(yes: bool, a: T, b: T) -> T {
    if yes { a } else { b }
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
    let above = height * height / area;
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

/// The nearest place of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Square of the distance.
    pub square: f64,
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
    let normal = seen.normal / seen.normal.length();
    let Side { to, along, .. } = seen.sides[seen.nearest];
    let edge = seen.edges[seen.nearest];
    let (away, feature) = if seen.is_face {
        (choose(seen.height <= 0.0, normal, -normal), Feature::Face)
    } else if along > 0.0 && along < 1.0 {
        (-to / to.length(), Feature::Edge(edge / edge.length()))
    } else {
        (-to / to.length(), Feature::Corner)
    };
    Place { square: seen.square, away, normal, feature }
}

/// The number of no triangle.
pub(super) const NOWHERE: u32 = u32::MAX;

/// The nearest triangle so far.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Found {
    /// Square of its distance.
    pub square: f64,
    /// Its number.
    pub number: u32,
}

impl Found {
    /// None.
    pub(super) const NONE: Found = Found { square: f64::INFINITY, number: NOWHERE };

    #[inline(always)]
    fn is_before(self, other: Found) -> bool {
        self.square < other.square || self.square == other.square && self.number < other.number
    }
}

/// A search for the nearest triangle, in steps.
#[derive(Clone)]
struct Walk {
    x: DVec3,
    slack: f64,
    best: Found,
    /// Square of the distance from which on nothing can be nearer, as computed.
    most: f64,
    /// Boxes to be looked into, the nearest last: how far they are, and what they are.
    keys: [u64; STACK],
    children: [u32; STACK],
    left: usize,
}

/// No search has more boxes to look into.
const STACK: usize = PASSED + WIDE;

/// Searches that are under way at the same time.
pub(super) const GROUP: usize = 8;

/// Searches for the nearest triangles of points. Those of a group of points take turns: while what one
/// needs next is on its way from memory, the others go on.
pub(super) struct Search<'a> {
    tree: &'a Tree,
    /// Largest coordinate of a corner.
    size: f64,
    walks: Vec<Walk>,
}

/// How far a computed distance may be off, of a point and triangles that are no farther from the origin.
#[inline(always)]
pub(super) fn slack(size: f64) -> f64 {
    128.0 * ROUNDOFF * size
}

impl<'a> Search<'a> {
    /// Room for so many searches at the same time.
    pub(super) fn new(tree: &'a Tree, size: f64, count: usize) -> Self {
        let walk = Walk {
            x: DVec3::ZERO,
            slack: 0.0,
            best: Found::NONE,
            most: 0.0,
            keys: [0; STACK],
            children: [0; STACK],
            left: 0,
        };
        Search { tree, size, walks: vec![walk; count.min(GROUP)] }
    }

    /// The nearest triangles to as many points, no more than there is room for; `found` has the
    /// numbers of the triangles that the searches begin with, if there are such.
    #[inline(always)]
    pub(super) fn nearest(&mut self, points: &[DVec3], found: &mut [Found]) {
        let mut active = [0; GROUP];
        let mut count = 0;
        for (i, (walk, x)) in self.walks.iter_mut().zip(points).enumerate() {
            walk.begin(self.tree, *x, slack(self.size + x.abs().max_element()), found[i].number);
            active[i] = i;
            count = i + 1;
        }
        while count > 0 {
            let mut still = 0;
            for k in 0..count {
                let i = active[k];
                if self.walks[i].step(self.tree) {
                    active[still] = i;
                    still += 1;
                } else {
                    found[i] = self.walks[i].best;
                }
            }
            count = still;
        }
    }
}

impl Walk {
    #[inline(always)]
    fn begin(&mut self, tree: &Tree, x: DVec3, slack: f64, hint: u32) {
        (self.x, self.slack) = (x, slack);
        self.improve(match tree.triangle(hint) {
            Some(t) => Found { square: see(t, x).square, number: hint },
            None => Found::NONE,
        });
        (self.keys[0], self.children[0], self.left) = (u64::MAX, 0, 1);
    }

    #[inline(always)]
    fn improve(&mut self, best: Found) {
        let far = best.square.sqrt() + 2.0 * self.slack;
        let square = far * far * (1.0 + 8.0 * ROUNDOFF);
        // Boxes that are not there are infinitely far.
        (self.best, self.most) = (best, choose(square < f64::MAX, square, f64::MAX));
    }

    /// Looks into the nearest box that is left, and says whether there was one.
    #[inline(always)]
    fn step(&mut self, tree: &Tree) -> bool {
        loop {
            if self.left == 0 {
                return false;
            }
            self.left -= 1;
            if self.keys[self.left] >= !self.most.to_bits() {
                break;
            }
        }
        let left = self.left;
        let child = self.children[left];
        if child & IS_BLOCK != 0 {
            let found = nearest_of(tree, child & !IS_BLOCK, self.x);
            if found.is_before(self.best) {
                self.improve(found);
            }
        } else {
            let node = &tree.nodes[child as usize];
            // Through memory: else the compiler, which sees how the eight get mixed, does not
            // compute them side by side.
            let keys = sorted(std::hint::black_box(keys(&box_squares(node, self.x), self.most)));
            for i in 0..WIDE {
                self.keys[left + i] = keys[i];
                self.children[left + i] = node.child[(keys[i] & 7) as usize];
            }
            self.left += keys.iter().filter(|k| **k != FAR).count();
        }
        if self.left > 0 {
            tree.fetch(self.children[self.left - 1]);
        }
        true
    }
}

/// Of a box that is too far.
const FAR: u64 = u64::MAX;

/// Numbers that grow as the distances of boxes shrink, with the lane in the last bits. The
/// distance is a little less than it was, so that nothing gets too far.
#[inline(always)]
fn keys(squares: &[f64; WIDE], most: f64) -> [u64; WIDE] {
    let mut keys = [FAR; WIDE];
    for i in 0..WIDE {
        let key = !squares[i].to_bits().saturating_sub(16) & !15 | i as u64;
        keys[i] = choose(squares[i] <= most, key, FAR);
    }
    keys
}

/// Sorts by a network of 19 comparisons (Knuth, The Art of Computer Programming 3, 5.3.4), which are
/// written out: a loop over them is not unrolled.
#[inline(always)]
fn sorted(mut k: [u64; WIDE]) -> [u64; WIDE] {
    macro_rules! compare {
        ($(($i:literal $j:literal))*) => {
            $((k[$i], k[$j]) = (choose(k[$i] < k[$j], k[$i], k[$j]), choose(k[$i] < k[$j], k[$j], k[$i]));)*
        };
    }
    compare!((0 2) (1 3) (4 6) (5 7) (0 4) (1 5) (2 6) (3 7) (0 1) (2 3) (4 5) (6 7));
    compare!((2 4) (3 5) (1 4) (3 6) (1 2) (3 4) (5 6));
    k
}

/// The nearest triangle of a block.
#[inline(always)]
fn nearest_of(tree: &Tree, block: u32, x: DVec3) -> Found {
    let squares = squares(&tree.blocks[block as usize], x);
    let (mut square, mut at) = (squares[0], 0);
    for lane in 1..BLOCK {
        // Never one that is absent.
        let nearer = squares[lane] < square;
        square = choose(nearer, squares[lane], square);
        at = choose(nearer, lane as u32, at);
    }
    Found { square, number: block * BLOCK as u32 + at }
}

/// Squares of the distances to the boxes of a node.
#[inline(always)]
fn box_squares(node: &Node, x: DVec3) -> [f64; WIDE] {
    let t = in_frame(x, node.origin, &node.axes).to_array();
    let mut out = [0.0; WIDE];
    for axis in 0..3 {
        for i in 0..WIDE {
            let before = f64::from(node.lo[axis][i]) - t[axis];
            let after = t[axis] - f64::from(node.hi[axis][i]);
            let off = choose(before > after, before, after);
            let off = choose(off > 0.0, off, 0.0);
            out[i] += off * off;
        }
    }
    out
}

/// Squares of the distances to the triangles of a block.
#[inline(always)]
fn squares(block: &Block, x: DVec3) -> [f64; BLOCK] {
    let mut out = [0.0; BLOCK];
    for i in 0..BLOCK {
        out[i] = see(block.triangle(i), x).square;
    }
    out
}
