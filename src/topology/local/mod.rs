//! What of a solid is joined with its core, found out as it is asked: for planets, on which all critical points
//! are too many.
//!
//! ```text
//! point --cells that lead on--> where their chain ends
//!   straight line inside?--> the core                                                        joined
//!   | no
//!   path downhill --> minimum --status known?-->                                             joined, apart
//!                        | no
//!                        small cells inside, then a straight line?-->                        joined
//!                        | no
//!                        empty cells all around?-->                                          parted
//!                        | no
//!                        minima that it is joined with by 1-saddles, voxel by voxel,
//!                        and through doors in the voxels' borders into others,
//!                        those next to the core first -- until one is joined with the core   joined
//!                                                     -- or there are no more                apart
//! ```
//!
//! This is the local algorithm of Gamito (2009, 8.5) with proofs in place of tolerances, and with less to
//! remember: what a voxel holds does not depend on who asks, so links and doors are found once for all, and a search
//! comes to each voxel once. What cannot be decided is said to be so.
//!
//! A *joined* is proven by a chain of paths inside of the solid to the core, a ball that is all inside, and a *parted* by
//! a moat (`moat.rs`). An *apart* says that no minimum and no door is left to go on from, where all that a voxel holds was
//! found, with proofs; but it is no proof itself. A door counts for the minimum that a path from it comes to. Where a
//! component crosses a face, and all paths from there come to minima that only saddles in voxels not looked into would
//! join with it, it would be missed. The way to a proof are paths that do not leave the voxel: at its border they go on
//! along the face, so that doors, minima and saddles of one voxel say what its pieces are without regard to what is
//! beside it.
//!
//! What is remembered of a minimum is what a search from it, or through it, has come to for good: *joined* holds for all
//! that the search was joined with on its way, and so does *apart* after a search that looked at all voxels that the
//! component reaches into. *Unknown* is remembered of the minimum alone that the search began with, and stops no other
//! search. A search that comes upon a minimum of an earlier one takes over what is proven, and nothing else: an *apart* is
//! for it to find anew, lest answers depend on who asked first. So a search never ends sooner for what was
//! asked before, but in a proof: it may only come to know more, where an earlier one has come upon the core by another
//! way.

mod blocks;
mod bricks;
mod cache;
mod core;
mod counters;
mod grid;
mod moat;
mod patch;
mod proofs;
mod voxel;
mod way;

use self::core::Core;
use super::descent::Start;
use super::search::Balls;
use crate::scene::Aabb;
use crate::tape::Tape;
use ahash::{HashMap, HashSet};
use blocks::Parts;
use cache::Cache;
use counters::{Count, Counters};
use glam::DVec3;
use grid::{Grid, Voxel};
use patch::Patches;
use proofs::{Known, Proof};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use voxel::{Links, Looker, Minimum, Node, Points};

/// What is known of a point.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Answer {
    /// It is joined with the core; this is proven.
    Joined,
    /// There is nothing of the solid all around what it is joined with; this is proven.
    Parted,
    /// All that it was found to be joined with was looked through, and the core was not there.
    Apart,
    /// One of these.
    Unknown,
}

impl Answer {
    /// Whether it is not joined with the core, as far as is known.
    pub fn is_apart(self) -> bool {
        matches!(self, Answer::Parted | Answer::Apart)
    }

    /// Whether it is proven.
    pub fn is_proven(self) -> bool {
        matches!(self, Answer::Joined | Answer::Parted)
    }

    /// What to remember: this, or what was known before if that is proven.
    fn unless_proven(self, before: Option<&Answer>) -> Answer {
        before.copied().filter(|before| before.is_proven()).unwrap_or(self)
    }
}

/// Voxels that one search may look into.
const PATIENCE: usize = 4096;

/// Voxels that are remembered, minima, small cells, and ends of chains.
const REMEMBERED: usize = 1 << 19;

/// Cells to a voxel along each axis, as powers of two, in which moats and ways are looked for: those after the first where
/// gaps or necks are too narrow for its parts.
const SMALL: [u32; 2] = [3, 4];

/// Cells of voxels that are remembered.
const CELLS_REMEMBERED: usize = 1 << 21;

/// What many threads know of a solid.
#[derive(Debug)]
pub struct Local {
    region: Aabb,
    /// To be cloned by each thread.
    field: Balls,
    core: Core,
    grid: Grid,
    points: Cache<Voxel, Arc<Points>>,
    links: Cache<Voxel, Arc<Links>>,
    statuses: Cache<Minimum, Answer>,
    /// What moats and ways say of small cells.
    around: Cache<Voxel, Answer>,
    /// What moats and ways have proven of cells.
    known: Known,
    patches: Patches,
    counters: Counters,
}

/// What the work was.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Serialize)]
pub struct LocalStats {
    /// Points that were asked about.
    pub asked: u64,
    /// Ends of chains, of which that was not known.
    pub looked: u64,
    /// Of these, seen from the core in a straight line.
    pub quick: u64,
    /// Paths downhill.
    pub paths: u64,
    /// Voxels that were searched.
    pub voxels: u64,
    /// Minima and 1-saddles found in them.
    pub minima: u64,
    pub saddles: u64,
    /// Moats found around crumbs.
    pub moats: u64,
    /// Minima whose status is remembered.
    pub cached: u64,
    /// Times that the status of a minimum was asked for.
    pub statuses: u64,
    /// Times that it was known.
    pub statuses_known: u64,
    /// Points that remained undecided.
    pub unknown: u64,
    /// Voxels that hold too much to be searched.
    pub crowded: u64,
    /// Searches that were given up after too many voxels.
    pub impatient: u64,
    /// Nanoseconds of all threads with straight lines,
    pub nanos_lines: u64,
    /// with paths downhill,
    pub nanos_paths: u64,
    /// and with voxels, and cells for moats and ways.
    pub nanos_voxels: u64,
}

impl Local {
    /// For the solid of a tape's first output within a region: its core is about `core`, and its smallest features
    /// are as large as `feature`. None if `core` is not certain to be inside.
    pub fn new(tape: &Arc<Tape>, region: &Aabb, core: DVec3, feature: f64) -> Option<Local> {
        let mut field = Balls::within(tape, region);
        let core = Core::around(&mut field, core, region.diagonal())?;
        Some(Local {
            region: *region,
            field,
            core,
            grid: Grid::new(feature),
            points: Cache::new(REMEMBERED),
            links: Cache::new(REMEMBERED),
            statuses: Cache::new(REMEMBERED),
            around: Cache::new(REMEMBERED),
            known: Known::new(CELLS_REMEMBERED),
            patches: Patches::new(Grid::new(feature), REMEMBERED),
            counters: Counters::default(),
        })
    }

    /// Another picture begins: what was not used for a while is forgotten, and counting begins anew.
    pub fn turn(&self) {
        self.points.turn();
        self.links.turn();
        self.statuses.turn();
        self.around.turn();
        self.known.turn();
        self.patches.turn();
        self.counters.clear();
    }

    /// What moats and ways to other places have proven of a point: if it is inside, a *parted*; a *joined* in any case.
    fn proven(&self, p: DVec3) -> Option<Answer> {
        SMALL.into_iter().find_map(|level| {
            let grid = self.grid.halved(level);
            let voxel = grid.voxel(p);
            let (part, known) = (Parts::of(&grid, voxel, p), self.known.get(level, voxel)?);
            let says = [(Proof::Joined, Answer::Joined), (Proof::Parted, Answer::Parted)];
            let is_of = |what: Proof| part.and(known.get(what, voxel)).any();
            says.into_iter().find(|(what, _)| is_of(*what)).map(|(_, answer)| answer)
        })
    }

    /// What the work was since the picture began.
    pub fn stats(&self) -> LocalStats {
        let count = |what: Count| self.counters.get(what);
        let [statuses, statuses_known] = self.statuses.hits();
        LocalStats {
            asked: count(Count::Asked),
            looked: count(Count::Looked),
            quick: count(Count::Quick),
            paths: count(Count::Paths),
            voxels: count(Count::Voxels),
            minima: count(Count::Minima),
            saddles: count(Count::Saddles),
            moats: count(Count::Moats),
            cached: self.statuses.len() as u64,
            statuses,
            statuses_known,
            unknown: count(Count::Unknown),
            crowded: count(Count::Crowded),
            impatient: count(Count::Impatient),
            nanos_lines: count(Count::Lines),
            nanos_paths: count(Count::Streaming),
            nanos_voxels: count(Count::Locating),
        }
    }
}

/// A thread that asks.
#[derive(Clone, Debug)]
pub struct Seeker {
    looker: Looker,
    cells: Balls,
}

impl Seeker {
    /// With memory of its own.
    pub fn new(local: Arc<Local>) -> Seeker {
        let cells = local.field.clone();
        Seeker { looker: Looker::new(local), cells }
    }

    /// Whether points inside are joined with the core. Once it is cancelled, what is not known yet stays so.
    pub fn answers(&mut self, points: &[DVec3], cancel: &AtomicBool) -> Vec<Answer> {
        let Seeker { looker, cells } = self;
        let local = looker.local.clone();
        let exact = |ends: &[DVec3]| {
            let answers = one_by_one(looker, ends, cancel);
            // What was broken off is not to be remembered.
            (!cancel.load(Ordering::Relaxed)).then_some(answers)
        };
        let answers = local.patches.answers((cells, &local.core), points, cancel, exact);
        let unknown = answers.iter().filter(|answer| **answer == Answer::Unknown).count();
        local.counters.add(Count::Asked, points.len());
        local.counters.add(Count::Unknown, unknown);
        answers
    }
}

/// Whether points inside are joined with the core, by lines and paths from each.
fn one_by_one(looker: &mut Looker, points: &[DVec3], cancel: &AtomicBool) -> Vec<Answer> {
    let mut answers: Vec<Answer> =
        points.iter().map(|p| looker.local.proven(*p).unwrap_or(Answer::Unknown)).collect();
    let unknown = |answers: &[Answer]| -> Vec<usize> {
        (0..points.len()).filter(|&i| answers[i] == Answer::Unknown).collect()
    };
    let open = unknown(&answers);
    let places: Vec<DVec3> = open.iter().map(|&i| points[i]).collect();
    for (i, seen) in open.iter().zip(looker.see(&places)) {
        if seen {
            answers[*i] = Answer::Joined;
        }
    }
    let hidden = unknown(&answers);
    let radius = 0.1 * looker.local.grid.size();
    let starts: Vec<Start> = hidden.iter().map(|&i| Start { at: points[i], radius }).collect();
    for (&i, end) in hidden.iter().zip(looker.descend(&starts, cancel)) {
        answers[i] = match end {
            Some(node) => status(looker, node, cancel),
            None => looker.moat_or_way(points[i], cancel),
        };
    }
    let counters = &looker.local.counters;
    counters.add(Count::Looked, points.len());
    counters.add(Count::Quick, open.len() - hidden.len());
    answers
}

/// What is known of a minimum, from now on at least.
fn status(looker: &mut Looker, node: Node, cancel: &AtomicBool) -> Answer {
    let minimum = match node {
        Node::Core => return Answer::Joined,
        Node::Parted => return Answer::Parted,
        Node::Minimum(minimum) => minimum,
    };
    if let Some(answer) = looker.local.statuses.get(&minimum) {
        return answer;
    }
    let mut search = Exhaustion::default();
    let answer = search.run(looker, minimum, cancel);
    if cancel.load(Ordering::Relaxed) {
        return Answer::Unknown;
    }
    let holds_for = match answer {
        Answer::Unknown | Answer::Parted => HashSet::from_iter([minimum]),
        Answer::Joined | Answer::Apart => search.active,
    };
    let statuses = &looker.local.statuses;
    let answers = holds_for.into_iter().map(|m| (m, statuses.update(m, |old| answer.unless_proven(old))));
    // Another thread may have proven it meanwhile.
    answers.fold(answer, |answer, (m, known)| if m == minimum { known } else { answer })
}

/// A search for the core among all that a minimum is joined with.
#[derive(Default)]
struct Exhaustion {
    /// Minima that it is joined with.
    active: HashSet<Minimum>,
    /// Voxels that it reaches into, next to be looked into, by their distance from the core, and those that were.
    waiting: BTreeSet<(u64, Voxel)>,
    opened: HashSet<Voxel>,
    /// What minima are joined with in the voxels that were opened, and where components go on from there.
    bridges: HashMap<Node, Vec<Node>>,
    doors: HashMap<Node, Vec<Voxel>>,
    doubt: bool,
}

impl Exhaustion {
    fn run(&mut self, looker: &mut Looker, first: Minimum, cancel: &AtomicBool) -> Answer {
        if let Some(answer) = self.activate(looker, vec![Node::Minimum(first)], cancel) {
            return answer;
        }
        while let Some((_, voxel)) = self.waiting.pop_first() {
            if !self.opened.insert(voxel) {
                continue;
            }
            if cancel.load(Ordering::Relaxed) {
                return Answer::Unknown;
            }
            if self.opened.len() > PATIENCE {
                looker.local.counters.add(Count::Impatient, 1);
                return Answer::Unknown;
            }
            let found = self.open(looker, voxel, cancel);
            if let Some(answer) = self.activate(looker, found, cancel) {
                return answer;
            }
        }
        if self.doubt { Answer::Unknown } else { Answer::Apart }
    }

    /// Takes in what a voxel holds; returns what is joined with active minima by it.
    fn open(&mut self, looker: &mut Looker, voxel: Voxel, cancel: &AtomicBool) -> Vec<Node> {
        let local = looker.local.clone();
        let links = looker.links(voxel, cancel);
        self.doubt |= links.doubt;
        let mut joined = Vec::new();
        for &[a, b] in &links.bridges {
            for (from, to) in [(a, b), (b, a)] {
                self.bridges.entry(from).or_default().push(to);
                if self.is_active(from) {
                    joined.push(to);
                }
            }
        }
        for &(node, at) in &links.doors {
            let beyond: Vec<Voxel> = local.grid.across(voxel, at).collect();
            if self.is_active(node) {
                beyond.iter().for_each(|&voxel| self.reach(&local, voxel));
            }
            self.doors.entry(node).or_default().extend(beyond);
        }
        joined
    }

    fn is_active(&self, node: Node) -> bool {
        if let Node::Minimum(minimum) = node { self.active.contains(&minimum) } else { false }
    }

    /// The component reaches into a voxel.
    fn reach(&mut self, local: &Local, voxel: Voxel) {
        if !self.opened.contains(&voxel) {
            let distance = local.grid.middle(voxel).distance(local.core.centre);
            self.waiting.insert((distance.to_bits(), voxel));
        }
    }

    /// These are joined with the minimum, and so is all that is joined with them. The answer, if it is known by that.
    fn activate(
        &mut self,
        looker: &mut Looker,
        mut joined: Vec<Node>,
        cancel: &AtomicBool,
    ) -> Option<Answer> {
        while !joined.is_empty() {
            let mut fresh: Vec<Minimum> = Vec::new();
            for node in joined.drain(..) {
                let minimum = match node {
                    Node::Core => return Some(Answer::Joined),
                    Node::Parted => return Some(Answer::Parted),
                    Node::Minimum(minimum) => minimum,
                };
                if self.active.insert(minimum) {
                    fresh.push(minimum);
                }
            }
            let statuses = &looker.local.statuses;
            // That nothing came of an earlier search says nothing about this one.
            let mut known = fresh.iter().filter_map(|minimum| statuses.get(minimum));
            if let Some(proven) = known.find(|answer| answer.is_proven()) {
                return Some(proven);
            }
            let positions: Vec<DVec3> =
                fresh.iter().filter_map(|minimum| looker.position(*minimum, cancel)).collect();
            if looker.see(&positions).contains(&true) {
                return Some(Answer::Joined);
            }
            let known =
                positions.iter().map(|at| looker.around(*at, cancel)).find(|answer| answer.is_proven());
            if known.is_some() {
                return known;
            }
            let local = looker.local.clone();
            for minimum in fresh {
                self.reach(&local, minimum.voxel);
                let node = Node::Minimum(minimum);
                joined.extend(self.bridges.get(&node).into_iter().flatten());
                let beyond = self.doors.get(&node).cloned().unwrap_or_default();
                beyond.into_iter().for_each(|voxel| self.reach(&local, voxel));
            }
        }
        None
    }
}
