//! Which edges of a cell belong together.
//!
//! The surface crosses those edges of a cell whose ends lie on different sides. On each face of the cell,
//! crossings are joined by arcs; the arcs of all faces make closed loops, and each loop bounds one *patch*
//! of the surface: a disc, which dual contouring turns into one vertex (Nielson 2004). A cell through which
//! two sheets pass so has two vertices, and the mesh is a manifold where the surface is.
//!
//! On a face with four crossings there are two ways to join them: either the two inner corners are joined
//! through the middle of the face, or the two outer ones. The cells on both sides of the face must choose
//! the same. The choice is that of the bilinear function through the four corners, whose saddle decides
//! (Nielson and Hamann 1991).

use super::lattice::{corner, edge_start};

/// Not an edge that the surface crosses.
pub(super) const NONE: u8 = u8::MAX;

/// The patches of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Patches {
    /// The patch that crosses each edge, or [`NONE`].
    pub of_edge: [u8; 12],
    /// How many patches there are, at most four.
    pub count: u8,
}

/// The corners of a face in turn, as seen against its axis, and the edges between each and the next.
pub(super) struct Face {
    pub corners: [usize; 4],
    pub edges: [usize; 4],
}

/// A face of a cell.
pub(super) const fn face(number: usize) -> Face {
    let (axis, side) = (number / 2, number % 2);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let base = side << axis;
    let corners = [base, base | 1 << u, base | 1 << u | 1 << v, base | 1 << v];
    // Along u the edges' offsets are (v, axis), along v they are (axis, u).
    let along_u = [4 * u + 2 * side, 4 * u + 1 + 2 * side];
    let along_v = [4 * v + side, 4 * v + side + 2];
    Face { corners, edges: [along_u[0], along_v[1], along_u[1], along_v[0]] }
}

const FACES: [Face; 6] = [face(0), face(1), face(2), face(3), face(4), face(5)];

/// Whether opposite corners of a face, and only those, lie on the same side.
pub(super) fn is_ambiguous(inside: u8, number: usize) -> bool {
    let [a, b, c, d] = FACES[number].corners.map(|i| inside >> i & 1);
    a == c && b == d && a != b
}

/// Whether the inner corners of an ambiguous face are joined in the bilinear function of its corners.
pub(super) fn joins_inside(values: [f64; 4]) -> bool {
    let [a, b, c, d] = values;
    let (inner, outer) = if a < 0.0 { (a * c, b * d) } else { (b * d, a * c) };
    inner > outer
}

impl Patches {
    /// The patches of a cell whose corners `inside` are, with the inner corners `joined` on the ambiguous ones
    /// among its faces; both are bits by number.
    pub fn of(inside: u8, joined: u8) -> Patches {
        // A label for each crossing, which arcs make equal.
        let mut label: [u8; 12] = std::array::from_fn(|e| {
            let from = corner(edge_start(e));
            let to = from | 1 << (e / 4);
            if (inside >> from & 1) == (inside >> to & 1) { NONE } else { e as u8 }
        });
        let mut join = |a: usize, b: usize| {
            let (keep, drop) = (label[a].min(label[b]), label[a].max(label[b]));
            label.iter_mut().filter(|l| **l == drop).for_each(|l| *l = keep);
        };
        for number in 0..6 {
            arcs(inside, joined, number).into_iter().flatten().for_each(|[a, b]| join(a, b));
        }
        let mut patches = Patches { of_edge: [NONE; 12], count: 0 };
        let mut number = [NONE; 12];
        for e in (0..12).filter(|&e| label[e] != NONE) {
            let number = &mut number[label[e] as usize];
            if *number == NONE {
                *number = patches.count;
                patches.count += 1;
            }
            patches.of_edge[e] = *number;
        }
        patches
    }

    /// Whether both arcs of an ambiguous face belong to the same patch.
    pub fn meets_itself(&self, inside: u8, number: usize) -> bool {
        let [a, _, c, _] = FACES[number].edges;
        is_ambiguous(inside, number) && self.of_edge[a] == self.of_edge[c]
    }
}

/// The arcs on a face, as pairs of edges.
fn arcs(inside: u8, joined: u8, number: usize) -> [Option<[usize; 2]>; 2] {
    let Face { corners, edges } = &FACES[number];
    let bit = |i: usize| inside >> corners[i] & 1 == 1;
    if is_ambiguous(inside, number) {
        // Corners that are cut off lie between the edges before and after them.
        let joined = joined >> number & 1 == 1;
        let first = usize::from(bit(0) == joined);
        let cut = |i: usize| Some([edges[(i + 3) % 4], edges[i]]);
        return [cut(first), cut(first + 2)];
    }
    let mut crossed = (0..4).filter(|&i| bit(i) != bit((i + 1) % 4)).map(|i| edges[i]);
    [crossed.next().zip(crossed.next()).map(|(a, b)| [a, b]), None]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_know_their_edges() {
        for number in 0..6 {
            let Face { corners, edges } = face(number);
            for i in 0..4 {
                let from = corner(edge_start(edges[i]));
                let mut ends = [from, from | 1 << (edges[i] / 4)];
                let mut wanted = [corners[i], corners[(i + 1) % 4]];
                ends.sort_unstable();
                wanted.sort_unstable();
                assert_eq!(ends, wanted, "edge {i} of face {number}");
            }
        }
    }

    #[test]
    fn every_crossing_has_one_patch_whose_arcs_close() {
        for inside in 0..=255_u8 {
            let ambiguous: Vec<usize> = (0..6).filter(|&f| is_ambiguous(inside, f)).collect();
            for choice in 0..1_u32 << ambiguous.len() {
                let joined = ambiguous.iter().enumerate().map(|(k, f)| ((choice >> k & 1) << f) as u8).sum();
                let patches = Patches::of(inside, joined);
                assert!(patches.count <= 4);
                let mut arcs_of = [0; 12];
                (0..6)
                    .flat_map(|f| arcs(inside, joined, f))
                    .flatten()
                    .flatten()
                    .for_each(|e| arcs_of[e] += 1);
                for e in 0..12 {
                    // Each crossing ends one arc on either of the two faces that its edge lies between.
                    assert_eq!(arcs_of[e], if patches.of_edge[e] == NONE { 0 } else { 2 });
                }
                // The other choice parts what was one on that face.
                for &f in ambiguous.iter().filter(|f| patches.meets_itself(inside, **f)) {
                    let other = Patches::of(inside, joined ^ 1 << f);
                    assert!(!other.meets_itself(inside, f) && other.count == patches.count + 1);
                }
            }
        }
    }

    #[test]
    fn the_saddle_decides() {
        // On the diagonal a - c the inner values are large, so that the middle is inside.
        assert!(joins_inside([-3.0, 1.0, -3.0, 1.0]) && !joins_inside([-1.0, 3.0, -1.0, 3.0]));
        assert!(joins_inside([1.0, -3.0, 1.0, -3.0]) && !joins_inside([3.0, -1.0, 3.0, -1.0]));
    }
}
