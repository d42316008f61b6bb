//! Components of a solid, certified without derivatives of second order.
//!
//! Which parts of a solid `f < 0` are joined to one another? Critical points tell where `f` is smooth. Here
//! enclosures of value and gradient over boxes tell, of any field that has them: also where it has creases, as
//! ridged and cellular noises do, and the minimum and maximum of solids.
//!
//! # Proof
//!
//! A region is cut into the cells of an octree. A closed cell is *out* if `f > 0` is proven everywhere in it, *in*
//! if `f < 0` is, else *mixed*. Everything below is about the part of the solid in the region.
//!
//! 1. In cells that touch, if only in a point, are of one component, since that point is solid. A *set* is what
//!    is joined like this.
//! 2. Suppose that `f` is proven to fall along an axis everywhere in a mixed cell: the enclosure of the
//!    derivative excludes zero. (Of a field with creases it holds the slopes of both sides and all between, hence
//!    Clarke's gradient, so that this is true of every Lipschitz `f`.) A solid point of the cell can go down along
//!    the axis: `f` only gets smaller, so it stays solid, until it gets to the face of the cell, and so into one of
//!    the neighbours there. So the solid of the cell belongs where that of these neighbours belongs: an out
//!    neighbour cannot be come to, an in neighbour is of some set, and of a mixed one the same is asked. Where all
//!    these ways down end, a cell has a *home*: nothing, if all its neighbours there are out, so that it has no
//!    solid either; one set; or several, if some of its solid may belong to one and some to another. Cells whose
//!    ways go round in a circle have none. Directions across the axes do as well: then the point leaves by one of
//!    the up to three faces that they point to.
//! 3. An in cell that touches a cell with one home is of that home: the point where they touch is solid, and in both.
//! 4. A path in the solid never meets an out cell, nor one whose home is nothing. It goes from cell to cell that
//!    touch. So it never leaves the cells whose home is one set, if none of these touches a cell of another home or
//!    of none.
//!
//! In that case, by 4 no component reaches beyond these cells, and by 2 every solid point of them is joined to the set:
//! *the solid in them is one component*. It is certified. Otherwise the set and what it may be joined to are a
//! *cluster*, of which those cells are cut that keep it from being understood: the ones without a way down; if there are
//! none, the ones without a home; and if all have one, the ones of several homes and those that touch a cell of
//! another home. That comes to an end unless two parts only just touch, or a crease is where no direction leads
//! down; such cells are given back when the limits are reached, and only the sets in their cluster are uncertified.
//!
//! A solid that is a star (`topology::star`) is one component whatever becomes of its cells.
//!
//! What belongs to a set is certain in any case: [`Components::label`] is right wherever it gives a component,
//! except that two components of one uncertified cluster may turn out to be one.
//!
//! Labels depend on nothing but the field, the region and the limits; cells of a round are bounded in parallel,
//! and their results are used in their order.

mod bounds;
mod joins;
mod measure;
mod tree;
mod ways;

use super::border::is_closed;
use super::sets::Sets;
use super::star;
use crate::field::{Stopped, Watch};
use crate::num::Interval;
use crate::scene::Aabb;
use crate::tape::{Cells, Tape};
use glam::DVec3;
use joins::{Home, Joins};
use measure::{Measure, Volume};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use tree::{State, Tree};

/// How long to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Limits {
    /// Cells of the tree, at most.
    pub cells: usize,
    /// Times that the region is cut, at most 30.
    pub depth: u8,
    /// Times that it is cut along the surface in any case, for the sake of boxes.
    pub least: u8,
    /// Times that it is cut there to measure volumes; 0 where these are of no interest.
    pub fine: u8,
}

/// Times that it is cut around what cannot be decided: to a few thousandths of a region.
const ENOUGH: u8 = 10;

/// Of so many cells one is spent on each point that the solid may be in sight of, to learn whether it is.
const STARS: usize = 8;

/// Times that a region can be cut.
const DEEPEST: u8 = 30;

impl Default for Limits {
    fn default() -> Limits {
        Limits { cells: 1 << 23, depth: 24, least: 5, fine: 8 }
    }
}

/// A part of the solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// A point in it.
    pub inside: DVec3,
    /// A box that holds it.
    pub bounds: Aabb,
    /// Encloses its volume.
    pub volume: Interval,
    /// An estimate of it; of what is certainly a part of it, if more may be.
    pub about: f64,
    /// Whether it is proven to be one component, all of it, and joined to no other within the region.
    pub certified: bool,
    /// Whether it may go on beyond the region, where parts of it may be joined.
    pub cut: bool,
}

/// What a place belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Label {
    /// All that is solid there, or in the same cell, belongs to the component of this number.
    Component(usize),
    /// There is nothing.
    Outside,
    /// It is not known, or the place is not in the region.
    Undecided,
}

/// The components of a solid in a region.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Components {
    /// The largest first.
    pub list: Vec<Component>,
    /// Boxes around cells that touch and of which it is not known where their solid belongs, if they have any. They may
    /// hold components that are in no list.
    pub undecided: Vec<Aabb>,
    /// The middle of the smallest of these cells.
    pub doubtful: Option<DVec3>,
    /// A bound on the volume of all of these together.
    pub undecided_volume: f64,
    /// Cells that were looked at.
    pub cells: usize,
    /// Whether more of them would have been looked at, had the limits allowed it.
    pub ran_short: bool,
    /// Times that the region was cut where that was necessary.
    pub depth: u8,
    /// A point that all of the solid in the region is in sight of, if that is proven: then it is one ball.
    pub star: Option<DVec3>,
    tree: Tree,
    /// Of the nodes of the tree.
    labels: Vec<Label>,
    /// Bounds on the volumes of the clusters of cells without a label.
    clusters: BTreeMap<u32, f64>,
}

impl Components {
    /// What a point belongs to.
    pub fn label(&self, p: DVec3) -> Label {
        self.tree.leaf_at(p).map_or(Label::Undecided, |leaf| self.labels[leaf as usize])
    }

    /// A place that is not of a component, in what closes it in, if all of the component is known and a line along an
    /// axis finds one.
    pub fn around(&self, component: usize) -> Option<DVec3> {
        if !self.list[component].certified {
            return None;
        }
        (0..6).find_map(|i| self.behind(component, i / 2, i % 2 == 0))
    }

    /// Where a line up or down an axis leaves a component for the last time, in a cell that has nothing of the solid.
    /// Between a full cell and that one the line meets nothing else than the component and what is around it.
    fn behind(&self, component: usize, axis: usize, up: bool) -> Option<DVec3> {
        let mut at = self.list[component].inside;
        let (mut behind, mut within) = (None, false);
        while let Some(leaf) = self.tree.leaf_at(at) {
            let cell = self.tree.cell(leaf);
            if self.labels[leaf as usize] == Label::Component(component) {
                within |= self.tree.nodes[leaf as usize].known.state == State::In;
                behind = None;
            } else {
                at[axis] = 0.5 * (cell.min[axis] + cell.max[axis]);
                let is_empty = self.labels[leaf as usize] == Label::Outside;
                behind = behind.or((within && is_empty).then_some(at));
                within = false;
            }
            at[axis] = if up { cell.max[axis].next_up() } else { cell.min[axis].next_down() };
        }
        behind
    }

    /// Whether a component has cells at the faces of a box that are faces of the region as well.
    pub fn comes_to(&self, faces: &Aabb, component: usize) -> bool {
        let own = self.tree.leaves().filter(|&n| self.labels[n as usize] == Label::Component(component));
        let is_there = |cell: Aabb| cell.min.cmple(faces.min).any() || cell.max.cmpge(faces.max).any();
        own.map(|n| self.tree.cell(n)).any(is_there)
    }

    /// A bound on the volume, within the region, of the component that holds a point.
    pub fn most_about(&self, p: DVec3) -> f64 {
        let Some(leaf) = self.tree.leaf_at(p) else { return f64::INFINITY };
        match self.labels[leaf as usize] {
            Label::Component(c) => self.list[c].volume.hi,
            Label::Outside => 0.0,
            Label::Undecided => self.clusters.get(&leaf).copied().unwrap_or(f64::INFINITY),
        }
    }

    /// Whether everything is proven.
    pub fn is_certified(&self) -> bool {
        self.undecided.is_empty() && self.list.iter().all(|c| c.certified)
    }
}

/// Finds the components of a solid in a region; its field is the only output of the tape. What is undefined is
/// empty.
///
/// # Errors
/// When stopped.
pub fn components(
    tape: &Arc<Tape>,
    region: &Aabb,
    limits: Limits,
    watch: &Watch<'_>,
) -> Result<Components, Stopped> {
    let cells = Cells::new(tape.clone(), &region.intervals());
    let star = star(&cells, region, limits, watch)?;
    let (mut tree, mut joins) = (Tree::new(*region), Joins::default());
    let (mut cut, mut fresh) = (Vec::new(), vec![0]);
    let (mut is_close, mut ran_short) = (false, false);
    loop {
        let boxes: Vec<Aabb> = fresh.iter().map(|&n| tree.cell(n)).collect();
        for (&n, known) in fresh.iter().zip(bounds::bound(&cells, &boxes, is_close, watch.cancel)) {
            tree.nodes[n as usize].known = known;
        }
        watch.check()?;
        joins.learn(&mut tree, &cut, &fresh);
        let mut clusters = Clusters::new(&tree, &mut joins);
        (watch.progress)(clusters.settled(&tree));
        // Volumes are known as well as they can be if cells run short.
        cut = coarse(&tree, &fresh, limits);
        is_close = cut.is_empty();
        if is_close && star.is_some() && joins.are_one(&tree) {
            clusters = Clusters::default();
        }
        if is_close {
            cut = clusters.to_cut(&tree, limits);
        }
        cut.sort_unstable_by_key(|&n| (tree.nodes[n as usize].level, n));
        let room = limits.cells.saturating_sub(tree.nodes.len()) / 8;
        ran_short |= cut.len() > room;
        cut.truncate(room);
        if cut.is_empty() {
            let volumes = volumes(&cells, &tree, &joins.homes, limits, watch);
            watch.check()?;
            let mut found = clusters.finish(tree, joins, &volumes);
            found.ran_short = ran_short;
            found.star = star.filter(|_| found.list.len() == 1);
            if found.list.iter().any(|c| c.cut) && is_closed(tape, region, watch.cancel) {
                // Cells at the border are not understood in full, but nothing goes through it.
                found.list.iter_mut().for_each(|c| c.cut = false);
            }
            watch.check()?;
            return Ok(found);
        }
        let first = tree.nodes.len() as u32;
        cut.iter().for_each(|&n| tree.cut(n));
        fresh = (first..tree.nodes.len() as u32).collect();
    }
}

/// A point that all of the solid is in sight of, if there is one where one may be expected.
fn star(cells: &Cells, region: &Aabb, limits: Limits, watch: &Watch<'_>) -> Result<Option<DVec3>, Stopped> {
    for centre in star::centres(region) {
        if star::is_star(cells, region, centre, limits.cells / STARS, watch)? {
            return Ok(Some(centre));
        }
    }
    Ok(None)
}

/// The volumes of what is solid in the leaves of a tree, in the order of its nodes; nothing of others.
fn volumes(cells: &Cells, tree: &Tree, homes: &[Home], limits: Limits, watch: &Watch<'_>) -> Vec<Volume> {
    let leaves: Vec<u32> = tree.leaves().filter(|&n| homes[n as usize] != Home::Nothing).collect();
    let mut volumes = vec![Volume::NOTHING; tree.nodes.len()];
    let found = measure::volumes(cells, tree, &leaves, limits.fine, watch.cancel);
    leaves.into_iter().zip(found).for_each(|(n, volume)| volumes[n as usize] = volume);
    volumes
}

/// New cells that may hold surface and are larger than what boxes are to be measured by. Earlier ones were cut, unless cells
/// ran short.
fn coarse(tree: &Tree, fresh: &[u32], limits: Limits) -> Vec<u32> {
    let least = limits.least.min(limits.depth).min(DEEPEST);
    let is_coarse = |&n: &u32| {
        let node = &tree.nodes[n as usize];
        node.known.state == State::Mixed && node.level < least
    };
    fresh.iter().copied().filter(is_coarse).collect()
}

/// Sets that may be joined to one another, by cells that are not understood.
#[derive(Default)]
struct Cluster {
    sets: BTreeSet<u32>,
    /// Cells without a way down, others without a home, and others that keep sets apart from being joined
    /// or parted.
    blind: Vec<u32>,
    homeless: Vec<u32>,
    between: BTreeSet<u32>,
}

impl Cluster {
    /// The cells that are not understood.
    fn open(&self) -> impl Iterator<Item = u32> + '_ {
        self.blind.iter().chain(&self.homeless).chain(&self.between).copied()
    }
}

/// All clusters, by their first members. Sets that are in none are components.
#[derive(Default)]
struct Clusters(BTreeMap<u32, Cluster>);

impl Clusters {
    fn new(tree: &Tree, joins: &mut Joins) -> Clusters {
        let Joins { sets, homes, open, pairs, .. } = joins;
        // A cell with a home stands for its set.
        let mut member = |n: u32| if let Home::One(home) = homes[n as usize] { sets.of(home) } else { n };
        let mut near = Sets::default();
        near.grow(tree.nodes.len());
        for pair in pairs.iter() {
            near.join(member(pair.a), member(pair.b));
        }
        let mut clusters: BTreeMap<u32, Cluster> = BTreeMap::new();
        for pair in pairs.iter() {
            let cluster = clusters.entry(near.of(member(pair.a))).or_default();
            let known = [pair.a, pair.b].map(|n| homes[n as usize]);
            for (n, home) in [pair.a, pair.b].into_iter().zip(known) {
                if let Home::One(_) = home {
                    cluster.sets.insert(member(n));
                    let is_mixed = tree.nodes[n as usize].known.state == State::Mixed;
                    if is_mixed && known.iter().all(|home| *home != Home::Unknown) {
                        cluster.between.insert(n);
                    }
                }
            }
        }
        for &n in open.iter() {
            let cluster = clusters.entry(near.of(n)).or_default();
            match homes[n as usize] {
                Home::Unknown if tree.nodes[n as usize].has_way() => cluster.homeless.push(n),
                Home::Unknown => cluster.blind.push(n),
                _ => {
                    cluster.between.insert(n);
                }
            }
        }
        Clusters(clusters)
    }

    /// The cells that are worth cutting.
    fn to_cut(&self, tree: &Tree, limits: Limits) -> Vec<u32> {
        let can = |n: &u32| tree.nodes[*n as usize].level < limits.depth.min(DEEPEST);
        let mut cut = Vec::new();
        for Cluster { blind, homeless, between, .. } in self.0.values() {
            let before = cut.len();
            cut.extend(blind.iter().copied().filter(can));
            // What is blind to the last keeps the cluster apart, however finely the rest is cut: that only serves
            // to say where it is.
            let is_lost = !blind.is_empty() && cut.len() == before;
            let helps = |n: &u32| can(n) && !(is_lost && tree.nodes[*n as usize].level >= ENOUGH);
            if cut.len() == before {
                cut.extend(homeless.iter().copied().filter(helps));
            }
            if cut.len() == before {
                cut.extend(between.iter().copied().filter(helps));
            }
        }
        cut
    }

    /// The share of the region that is understood.
    fn settled(&self, tree: &Tree) -> f64 {
        let share = |n: u32| libm::ldexp(1.0, -3 * i32::from(tree.nodes[n as usize].level));
        1.0 - self.0.values().flat_map(Cluster::open).map(share).sum::<f64>().min(1.0)
    }

    /// The middle of the smallest cell that is not understood.
    fn finest(&self, tree: &Tree) -> Option<DVec3> {
        let open = self.0.values().flat_map(Cluster::open);
        let finest = open.max_by_key(|&n| (tree.nodes[n as usize].level, Reverse(n)))?;
        let Aabb { min, max } = tree.cell(finest);
        Some(0.5 * (min + max))
    }

    /// Boxes around cells that are not understood and touch.
    fn places(&self, tree: &Tree, joins: &Joins) -> Vec<Aabb> {
        let open: BTreeSet<u32> = self.0.values().flat_map(Cluster::open).collect();
        let mut near = Sets::default();
        near.grow(tree.nodes.len());
        for pair in &joins.pairs {
            if open.contains(&pair.a) && open.contains(&pair.b) {
                near.join(pair.a, pair.b);
            }
        }
        let mut places: BTreeMap<u32, Aabb> = BTreeMap::new();
        for n in open {
            let cell = tree.cell(n);
            let place = places.entry(near.of(n)).or_insert(cell);
            *place = place.hull(&cell);
        }
        places.into_values().collect()
    }

    /// What all that comes to.
    fn finish(self, tree: Tree, mut joins: Joins, volumes: &[Volume]) -> Components {
        let mut sets: BTreeMap<u32, Measure> = BTreeMap::new();
        for n in tree.leaves() {
            if let Home::One(home) = joins.homes[n as usize] {
                sets.entry(joins.sets.of(home)).or_default().add(&tree, n, volumes);
            }
        }
        let mut found: Vec<(u32, Component)> =
            sets.iter().map(|(&set, measure)| (set, measure.component(true))).collect();
        let mut clusters = BTreeMap::new();
        let mut unknown = Measure::default();
        for cluster in self.0.values() {
            // Any of it may be all of it.
            let mut all = Measure::default();
            cluster.sets.iter().filter_map(|set| sets.get(set)).for_each(|measure| all.include(measure));
            let unlabelled = |n: &u32| !matches!(joins.homes[*n as usize], Home::One(_));
            let open: Vec<u32> = cluster.open().filter(unlabelled).collect();
            open.iter().for_each(|&n| all.add(&tree, n, volumes));
            open.iter().for_each(|&n| unknown.add(&tree, n, volumes));
            clusters.extend(open.into_iter().map(|n| (n, all.volume.range.hi)));
            for (set, component) in found.iter_mut().filter(|(set, _)| cluster.sets.contains(set)) {
                let Volume { range, about } = sets.get(set).map_or(Volume::NOTHING, |own| own.volume);
                *component = Component { inside: component.inside, about, ..all.component(false) };
                component.volume = Interval::new(range.lo, component.volume.hi);
            }
        }
        found.sort_by(|a, b| b.1.volume.lo.total_cmp(&a.1.volume.lo).then(a.0.cmp(&b.0)));
        let numbers: BTreeMap<u32, usize> = found.iter().enumerate().map(|(i, &(set, _))| (set, i)).collect();
        let mut label = |home: &Home| match *home {
            Home::Nothing => Label::Outside,
            Home::One(home) => {
                numbers.get(&joins.sets.of(home)).map_or(Label::Undecided, |&i| Label::Component(i))
            }
            Home::Unknown | Home::Several => Label::Undecided,
        };
        Components {
            labels: joins.homes.iter().map(&mut label).collect(),
            list: found.into_iter().map(|(_, component)| component).collect(),
            undecided: self.places(&tree, &joins),
            doubtful: self.finest(&tree),
            undecided_volume: unknown.volume.range.hi,
            ran_short: false,
            star: None,
            clusters,
            cells: tree.nodes.len(),
            depth: tree.nodes.iter().map(|node| node.level).max().unwrap_or(0),
            tree,
        }
    }
}
