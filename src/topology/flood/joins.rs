//! What is joined to what, as far as the labels of cells prove it.
//!
//! What is proven stays proven when other cells are cut, so only what is open is looked at again.

use super::super::sets::Sets;
use super::tree::{Pair, State, Tree};
use super::ways::Ways;
use rayon::prelude::*;

/// Where the solid in a cell belongs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Home {
    Unknown,
    /// There is none.
    Nothing,
    /// All of it to the set of this full cell.
    One(u32),
    /// Each part of it to that of some full cell, but to which is not known.
    Several,
}

impl Home {
    /// Where it belongs if each part of it belongs to one or to the other.
    fn or(self, other: Home, sets: &mut Sets) -> Home {
        match (self, other) {
            (Home::Nothing, home) | (home, Home::Nothing) => home,
            (Home::One(a), Home::One(b)) if sets.of(a) == sets.of(b) => self,
            (Home::Unknown, _) | (_, Home::Unknown) => Home::Unknown,
            _ => Home::Several,
        }
    }

    fn is_open(self) -> bool {
        matches!(self, Home::Unknown | Home::Several)
    }
}

/// What is joined to what.
#[derive(Default)]
pub(super) struct Joins {
    /// Full cells that are certainly of one component.
    pub sets: Sets,
    /// Of all nodes of the tree; those that were cut have none.
    pub homes: Vec<Home>,
    /// Cells without one home.
    pub open: Vec<u32>,
    /// Leaves that touch, of which it is not known that their solid is of one component.
    pub pairs: Vec<Pair>,
    /// Others that touch, but for those that are both full and those of which one has nothing. There is nothing to be
    /// learnt from them until one is cut.
    settled: Vec<Pair>,
}

impl Joins {
    /// Learns from the children of cells that were cut; of none, from the root.
    pub fn learn(&mut self, tree: &mut Tree, cut: &[u32], fresh: &[u32]) {
        self.sets.grow(tree.nodes.len());
        self.homes.resize(tree.nodes.len(), Home::Unknown);
        self.find_pairs(tree, cut);
        let inherited = self.take_in(tree, cut, fresh);
        self.follow(tree);
        // A child has the home of its parent, unless it has nothing.
        for (n, home) in inherited {
            if self.homes[n as usize] != Home::Nothing {
                self.homes[n as usize] = home;
            }
        }
        self.follow(tree);
        let Joins { sets, homes, open, pairs, settled } = self;
        for &n in open.iter().filter(|&&n| homes[n as usize] == Home::Nothing) {
            // Nobody need look at it again.
            tree.nodes[n as usize].known.state = State::Out;
        }
        open.retain(|&n| homes[n as usize].is_open());
        pairs.retain(|pair| {
            // Two full cells are joined, and what is empty is not touched.
            let (one, other) = (&tree.nodes[pair.a as usize].known, &tree.nodes[pair.b as usize].known);
            let is_empty = one.state == State::Out || other.state == State::Out;
            let is_full = one.state == State::In && other.state == State::In;
            if is_full {
                sets.join(pair.a, pair.b);
            }
            !is_empty && !is_full
        });
        settled.extend(pairs.extract_if(.., |pair| !differ(homes, sets, pair)));
    }

    /// Takes it that all of the solid is one component. Returns whether there is a full cell, to know it by.
    pub fn are_one(&mut self, tree: &Tree) -> bool {
        let is_full = |&n: &u32| tree.nodes[n as usize].known.state == State::In;
        let Some(first) = tree.leaves().find(is_full) else { return false };
        for n in tree.leaves().filter(is_full) {
            self.sets.join(first, n);
        }
        let home = self.sets.of(first);
        for n in self.open.drain(..) {
            self.homes[n as usize] = Home::One(home);
        }
        true
    }

    /// Replaces the pairs of cells that were cut by those of their children.
    fn find_pairs(&mut self, tree: &Tree, cut: &[u32]) {
        let mut is_cut = vec![false; tree.nodes.len()];
        cut.iter().for_each(|&n| is_cut[n as usize] = true);
        let changes = |pair: &mut Pair| is_cut[pair.a as usize] || is_cut[pair.b as usize];
        let Joins { pairs, settled, .. } = self;
        let changed: Vec<Pair> =
            pairs.extract_if(.., changes).chain(settled.extract_if(.., changes)).collect();
        pairs.extend(gathered(&changed, |pair, found| {
            tree.touch(pair.a, pair.b, &mut |pair| found.push(pair))
        }));
        pairs.extend(gathered(cut, |&n, found| tree.touch_within(n, &mut |pair| found.push(pair))));
    }

    /// Takes new cells in. Returns the homes that they have from their parents.
    fn take_in(&mut self, tree: &Tree, cut: &[u32], fresh: &[u32]) -> Vec<(u32, Home)> {
        let mut inherited = Vec::new();
        for (i, &n) in fresh.iter().enumerate() {
            let home = cut.get(i / 8).map_or(Home::Unknown, |&parent| self.homes[parent as usize]);
            self.homes[n as usize] = match tree.nodes[n as usize].known.state {
                State::Out => Home::Nothing,
                State::In => {
                    if let Home::One(home) = home {
                        self.sets.join(n, home);
                    }
                    Home::One(n)
                }
                State::Mixed => {
                    self.open.push(n);
                    if !home.is_open() {
                        inherited.push((n, home));
                    }
                    Home::Unknown
                }
            };
        }
        cut.iter().for_each(|&n| self.homes[n as usize] = Home::Unknown);
        self.open.retain(|&n| tree.nodes[n as usize].is_leaf());
        inherited
    }

    /// Follows the solid of open cells downhill, and joins what that shows to be joined, until there is no more
    /// to be learnt.
    fn follow(&mut self, tree: &Tree) {
        let Joins { sets, homes, open, pairs, .. } = self;
        loop {
            Descent::new(tree, open, homes, pairs, sets).follow(homes, sets);
            let mut more = false;
            for pair in pairs.iter() {
                let full = |n: u32| tree.nodes[n as usize].known.state == State::In;
                if let (Home::One(a), Home::One(b)) = (homes[pair.a as usize], homes[pair.b as usize])
                    && (full(pair.a) || full(pair.b))
                {
                    // Where they touch is solid, and in both.
                    more |= sets.join(a, b);
                }
            }
            if !more {
                break;
            }
        }
    }
}

/// Cells or pairs of them that one thread looks at before it takes others.
const SHARE: usize = 4096;

/// The pairs that are found at each of some places, in their order.
fn gathered<T: Sync>(places: &[T], find: impl Fn(&T, &mut Vec<Pair>) + Sync) -> Vec<Pair> {
    let share = |places: &[T]| {
        let mut found = Vec::new();
        places.iter().for_each(|place| find(place, &mut found));
        found
    };
    places.par_chunks(SHARE).flat_map_iter(share).collect()
}

/// Whether the solid of two cells is not known to be of one component, and there may be some in both.
fn differ(homes: &[Home], sets: &mut Sets, pair: &Pair) -> bool {
    match (homes[pair.a as usize], homes[pair.b as usize]) {
        (Home::Nothing, _) | (_, Home::Nothing) => false,
        (Home::One(a), Home::One(b)) => sets.of(a) != sets.of(b),
        _ => true,
    }
}

/// A wait of a way out of an open cell for another cell.
#[derive(Clone, Copy)]
struct Wait {
    on: u32,
    cell: u32,
    /// The axes along which it goes.
    set: usize,
}

/// How far a way out of a cell is known.
#[derive(Clone, Copy)]
struct Way {
    /// Neighbours whose homes are not known yet; `None` where there is no such way.
    waiting: Option<u32>,
    /// Where those that are known lead.
    home: Home,
}

/// Following the solid of open cells downhill from cell to cell.
struct Descent<'a> {
    /// In increasing order.
    open: Vec<u32>,
    /// Of the open cells.
    ways: Vec<[Way; Ways::SETS]>,
    /// Sorted by the cells that are waited for.
    waits: Vec<Wait>,
    tree: &'a Tree,
}

impl<'a> Descent<'a> {
    fn new(tree: &'a Tree, open: &[u32], homes: &mut [Home], pairs: &[Pair], sets: &mut Sets) -> Descent<'a> {
        let mut open = open.to_vec();
        open.sort_unstable();
        open.retain(|&n| homes[n as usize].is_open());
        open.iter().for_each(|&n| homes[n as usize] = Home::Unknown);
        let way = |n: u32, set: usize| {
            let waiting = tree.nodes[n as usize].way(set).map(|_| 0);
            Way { waiting, home: Home::Nothing }
        };
        let ways = open.iter().map(|&n| std::array::from_fn(|set| way(n, set))).collect();
        let mut descent = Descent { open, ways, waits: Vec::new(), tree };
        for pair in pairs {
            let mut faces = (0..3).filter(|&axis| pair.towards[axis] != 0);
            let (Some(axis), None) = (faces.next(), faces.next()) else { continue };
            descent.ask(pair.a, pair.b, (axis, pair.towards[axis]), homes, sets);
            descent.ask(pair.b, pair.a, (axis, -pair.towards[axis]), homes, sets);
        }
        descent.waits.sort_by_key(|wait| wait.on);
        descent
    }

    /// Asks a neighbour across a face where the ways of a cell lead that leave it there.
    fn ask(&mut self, cell: u32, on: u32, (axis, sign): (usize, i8), homes: &[Home], sets: &mut Sets) {
        if homes[cell as usize] != Home::Unknown {
            return;
        }
        let Ok(place) = self.open.binary_search(&cell) else { return };
        let node = &self.tree.nodes[cell as usize];
        for (set, way) in self.ways[place].iter_mut().enumerate() {
            let Way { waiting: Some(waiting), home } = way else { continue };
            if node.known.ways.of(set).is_none_or(|direction| direction[axis] != sign) {
                continue;
            }
            if homes[on as usize] == Home::Unknown {
                *waiting += 1;
                self.waits.push(Wait { on, cell, set });
            } else {
                *home = home.or(homes[on as usize], sets);
            }
        }
    }

    /// Finds the homes of all cells from which every way down ends in cells whose homes are known. A way that leads
    /// to several homes is taken where there is no other.
    fn follow(mut self, homes: &mut [Home], sets: &mut Sets) {
        let (mut clear, mut unclear) = (Vec::new(), Vec::new());
        for place in 0..self.open.len() {
            (0..Ways::SETS).for_each(|set| self.note(place, set, &mut clear, &mut unclear));
        }
        while let Some((place, set)) = clear.pop().or_else(|| unclear.pop()) {
            let cell = self.open[place];
            if homes[cell as usize] != Home::Unknown {
                continue;
            }
            let home = self.ways[place][set].home;
            homes[cell as usize] = home;
            let from = self.waits.partition_point(|wait| wait.on < cell);
            let to = from + self.waits[from..].partition_point(|wait| wait.on == cell);
            for i in from..to {
                let Wait { cell, set, .. } = self.waits[i];
                let Ok(place) = self.open.binary_search(&cell) else { continue };
                if let Way { waiting: Some(waiting), home: so_far } = &mut self.ways[place][set] {
                    *so_far = so_far.or(home, sets);
                    *waiting -= 1;
                }
                self.note(place, set, &mut clear, &mut unclear);
            }
        }
    }

    /// Notes a way if it is known where it leads.
    fn note(
        &self,
        place: usize,
        set: usize,
        clear: &mut Vec<(usize, usize)>,
        unclear: &mut Vec<(usize, usize)>,
    ) {
        let Way { waiting, home } = self.ways[place][set];
        if waiting == Some(0) {
            let list = if home == Home::Several { unclear } else { clear };
            list.push((place, set));
        }
    }
}
