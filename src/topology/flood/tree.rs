//! An octree over a region, and which of its cells touch.

use super::ways::Ways;
use crate::scene::Aabb;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What is known of the field over a closed cell.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub(super) enum State {
    /// There is nothing of the solid in it.
    Out,
    /// All of it is solid.
    In,
    /// Neither is known.
    Mixed,
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub state: State,
    /// Directions in which the field falls everywhere in the cell.
    pub ways: Ways,
}

impl Known {
    /// Nothing.
    pub const NOTHING: Known = Known { state: State::Mixed, ways: Ways::NONE };
}

/// A cell of the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Its place among the cells of its level.
    pub at: [u32; 3],
    /// Times that the region was cut.
    pub level: u8,
    pub known: Known,
    /// The first of its eight children; 0 where it has none.
    children: u32,
}

impl Node {
    /// Whether it was not cut.
    pub fn is_leaf(&self) -> bool {
        self.children == 0
    }

    /// Where another node lies from here, if they share a point: -1 or 1 along axes on which it lies beside this
    /// one, 0 along those on which one spans the other.
    fn towards(&self, other: &Node) -> Option<[i8; 3]> {
        let finest = self.level.max(other.level);
        let ends = |node: &Node, axis: usize| {
            let (at, scale) = (u64::from(node.at[axis]), finest - node.level);
            (at << scale, (at + 1) << scale)
        };
        let mut towards = [0; 3];
        for (axis, towards) in towards.iter_mut().enumerate() {
            let ((a, b), (c, d)) = (ends(self, axis), ends(other, axis));
            if b < c || d < a {
                return None;
            }
            *towards = i8::from(b == c) - i8::from(d == a);
        }
        Some(towards)
    }

    /// The parts of it that may touch what lies beside it towards there, as of a [`Pair`]: itself, by its number, if it is a
    /// leaf, or else those of its children that are on that side.
    fn facing(&self, own: u32, towards: [i8; 3]) -> impl Iterator<Item = u32> + use<> {
        let is_leaf = self.is_leaf();
        let (first, count) = if is_leaf { (own, 1) } else { (self.children, 8) };
        let faces = move |child: &u32| {
            let is_high = |axis: usize| child >> axis & 1 == 1;
            is_leaf || (0..3).all(|axis| towards[axis] == 0 || is_high(axis) == (towards[axis] > 0))
        };
        (0..count).filter(faces).map(move |i| first + i)
    }

    /// The way down along a set of axes, if there is one that leads nowhere out of the region.
    pub fn way(&self, set: usize) -> Option<[i8; 3]> {
        let leads_out =
            |direction: &[i8; 3]| (0..3).any(|axis| direction[axis] != 0 && self.ends(axis, direction[axis]));
        self.known.ways.of(set).filter(|direction| !leads_out(direction))
    }

    /// Whether there is any such way.
    pub fn has_way(&self) -> bool {
        (0..Ways::SETS).any(|set| self.way(set).is_some())
    }

    /// Whether its face towards -1 or 1 along an axis is on that of the region.
    pub fn ends(&self, axis: usize, sign: i8) -> bool {
        if sign < 0 { self.at[axis] == 0 } else { self.at[axis] + 1 == 1 << self.level }
    }
}

/// Two nodes that share a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub a: u32,
    pub b: u32,
    /// Where the second lies from the first, -1 or 1; 0 along axes on which one spans the other.
    pub towards: [i8; 3],
}

/// How far off the middles cells are cut. Faces and edges of solids have round coordinates: one that lies in a
/// face of a cell has no cell around it, and then little can be proven of either side.
const BEND: [f64; 3] = [0.0173, 0.0211, 0.0197];

/// A region cut into cells. It is stored without the ways down, which only serve while it is cut.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(into = "Stored", try_from = "Stored")]
pub(super) struct Tree {
    pub region: Aabb,
    pub nodes: Vec<Node>,
}

impl Tree {
    pub fn new(region: Aabb) -> Tree {
        let root = Node { at: [0; 3], level: 0, known: Known::NOTHING, children: 0 };
        Tree { region, nodes: vec![root] }
    }

    /// Cuts a leaf; its children are the last eight nodes.
    pub fn cut(&mut self, node: u32) {
        let first = self.nodes.len() as u32;
        let Node { at, level, .. } = self.nodes[node as usize];
        self.nodes[node as usize].children = first;
        self.nodes.extend((0..8_u32).map(|i| Node {
            at: std::array::from_fn(|axis| 2 * at[axis] + (i >> axis & 1)),
            level: level + 1,
            known: Known::NOTHING,
            children: 0,
        }));
    }

    /// The closed box of a node. What neighbours share has the same bits, whatever their sizes.
    pub fn cell(&self, node: u32) -> Aabb {
        let Node { at, level, .. } = self.nodes[node as usize];
        let Aabb { min, max } = self.region;
        let place = |axis: usize, i: u32| {
            // A fraction is exact, so that the same place has the same one on all levels.
            let share = f64::from(i) / f64::from(1_u32 << level);
            let bent = share + BEND[axis] * share * (1.0 - share);
            if share == 1.0 { max[axis] } else { min[axis] + (max[axis] - min[axis]) * bent }
        };
        let corner = |add: u32| DVec3::from_array(std::array::from_fn(|axis| place(axis, at[axis] + add)));
        Aabb { min: corner(0), max: corner(1) }
    }

    /// The leaves, in the order in which they were made.
    pub fn leaves(&self) -> impl Iterator<Item = u32> + use<'_> {
        (0..self.nodes.len() as u32).filter(|&n| self.nodes[n as usize].children == 0)
    }

    /// The leaf that has a point of the region.
    pub fn leaf_at(&self, p: DVec3) -> Option<u32> {
        let Aabb { min, max } = self.region;
        if !(p.cmpge(min).all() && p.cmple(max).all()) {
            return None;
        }
        let mut node = 0;
        while self.nodes[node as usize].children != 0 {
            let children = self.nodes[node as usize].children;
            let middle = self.cell(children).max;
            node = children + (0..3).map(|axis| u32::from(p[axis] > middle[axis]) << axis).sum::<u32>();
        }
        Some(node)
    }

    /// The pairs of the leaves in a node that was cut; see [`touch`](Tree::touch).
    pub fn touch_within(&self, node: u32, found: &mut impl FnMut(Pair)) {
        let children = self.nodes[node as usize].children;
        for (i, j) in (0..8).flat_map(|j| (0..j).map(move |i| (i, j))) {
            self.touch(children + i, children + j, found);
        }
    }

    /// The pairs of leaves of two nodes that share a point and may have something of the solid, each once.
    pub fn touch(&self, a: u32, b: u32, found: &mut impl FnMut(Pair)) {
        let [one, other] = [a, b].map(|n| &self.nodes[n as usize]);
        let is_empty = |node: &Node| node.is_leaf() && node.known.state == State::Out;
        if is_empty(one) || is_empty(other) {
            return;
        }
        let Some(towards) = one.towards(other) else { return };
        if one.is_leaf() && other.is_leaf() {
            return found(Pair { a, b, towards });
        }
        let back = towards.map(|sign| -sign);
        for i in one.facing(a, towards) {
            other.facing(b, back).for_each(|j| self.touch(i, j, found));
        }
    }
}

/// A tree on disk: where it is, and of each node where its children are and what is known.
#[derive(Serialize, Deserialize)]
struct Stored(Aabb, Vec<(u32, State)>);

impl From<Tree> for Stored {
    fn from(tree: Tree) -> Stored {
        Stored(tree.region, tree.nodes.iter().map(|node| (node.children, node.known.state)).collect())
    }
}

impl TryFrom<Stored> for Tree {
    type Error = &'static str;

    /// Cuts it as it was cut.
    fn try_from(Stored(region, stored): Stored) -> Result<Tree, Self::Error> {
        let parents = (0..).zip(&stored).map(|(n, &(children, _))| (children, n));
        let mut parents: Vec<(u32, u32)> = parents.filter(|&(children, _)| children != 0).collect();
        parents.sort_unstable();
        let mut tree = Tree::new(region);
        for (children, n) in parents {
            if n >= children || children as usize != tree.nodes.len() {
                return Err("not a tree");
            }
            tree.cut(n);
        }
        if tree.nodes.len() != stored.len() {
            return Err("not all of a tree");
        }
        for (node, (_, state)) in tree.nodes.iter_mut().zip(stored) {
            node.known = Known { state, ..Known::NOTHING };
        }
        Ok(tree)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is stored comes back, and what is no tree does not.
    #[test]
    fn stored_trees_come_back() {
        let mut tree = Tree::new(Aabb::cube(1.0));
        for n in [0, 3, 12, 7, 20] {
            tree.cut(n);
            tree.nodes[n as usize + 1].known.state = State::In;
        }
        let stored = postcard::to_allocvec(&tree).unwrap();
        let back: Tree = postcard::from_bytes(&stored).unwrap();
        let about = |tree: &Tree| -> Vec<_> {
            let node = |n: u32| &tree.nodes[n as usize];
            (0..tree.nodes.len() as u32)
                .map(|n| (tree.cell(n), node(n).known.state, node(n).children))
                .collect()
        };
        assert_eq!(about(&tree), about(&back));
        let read = |list: Vec<(u32, State)>| Tree::try_from(Stored(Aabb::cube(1.0), list));
        assert!(read(vec![(0, State::In); 9]).is_err());
        assert!(read(vec![(1, State::Mixed)]).is_err());
        assert!(read(vec![(5, State::Mixed); 9]).is_err());
        assert!(read(Vec::new()).is_err());
        assert!(read(vec![(0, State::Out)]).is_ok());
    }

    /// Pairs that are kept while cells are cut are those that a search finds.
    #[test]
    fn pairs_of_cells_that_are_cut_are_those_of_a_search() {
        let mut tree = Tree::new(Aabb::cube(1.0));
        let mut pairs: Vec<Pair> = Vec::new();
        let mut random = 1_u32;
        for _ in 0..120 {
            let leaves: Vec<u32> = tree.leaves().collect();
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let cut = leaves[(random >> 8) as usize % leaves.len()];
            tree.cut(cut);
            let mut next = Vec::new();
            pairs.iter().for_each(|pair| tree.touch(pair.a, pair.b, &mut |pair| next.push(pair)));
            tree.touch_within(cut, &mut |pair| next.push(pair));
            pairs = next;
        }
        let mut kept: Vec<(u32, u32)> = pairs.iter().map(|p| (p.a.min(p.b), p.a.max(p.b))).collect();
        kept.sort_unstable();
        let leaves: Vec<u32> = tree.leaves().collect();
        let share_a_point = |a: u32, b: u32| {
            let (a, b) = (tree.cell(a), tree.cell(b));
            a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
        };
        let searched: Vec<(u32, u32)> = leaves
            .iter()
            .flat_map(|&a| leaves.iter().map(move |&b| (a, b)))
            .filter(|&(a, b)| a < b && share_a_point(a, b))
            .collect();
        assert_eq!(kept, searched);
        for Pair { a, b, towards } in pairs {
            let (one, other) = (tree.cell(a), tree.cell(b));
            for axis in 0..3 {
                let is_beside = [one.max[axis] == other.min[axis], one.min[axis] == other.max[axis]];
                assert_eq!(is_beside, [towards[axis] == 1, towards[axis] == -1]);
            }
        }
    }
}
