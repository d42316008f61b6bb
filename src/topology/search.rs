//! The search for critical points: cells are cut up until each is free of them or holds one that is proven.
//!
//! Cells are looked at [`LANES`] at a time, with one evaluation each ([`verdict`](super::verdict)). One that
//! can hold no more than one critical point is handed to Newton's method ([`polish`](super::polish)), which
//! finds it, proves that there is one, or sends the cell back to be cut. Cells are closed: a point on a face
//! is found from both sides, and reports whose error balls meet are one (it is proven that they are).
//!
//! The search ends where 0 is a regular value of the gradient, which is to say for Morse functions. Cells that
//! are tiny and still undecided are gathered and reported with where they are.

use super::cell::Cell;
use super::isolated::isolated;
use super::point::CriticalPoint;
use super::polish::polish;
use super::verdict::{Verdict, Verdicts, Zeros, free_parts, judge};
use crate::field::Watch;
use crate::num::{Interval, Number, Taylor, Taylors};
use crate::scene::Aabb;
use crate::tape::{Defined, Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::AddAssign;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Cells looked at together.
pub(super) const LANES: usize = 16;

/// Where critical points are looked for.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// The box, which must be a [proper](Aabb::is_proper) one.
    pub region: Aabb,
    /// Whether only those where the field is not positive are wanted.
    pub solid: bool,
}

/// What a search did.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct SearchStats {
    /// Cells looked at.
    pub cells: u64,
    /// Of these, proven to be outside of the solid.
    pub outside: u64,
    /// Proven to have no critical point.
    pub regular: u64,
    /// Proven to have no more than one, and handed to Newton's method.
    pub single: u64,
    /// Evaluations of Newton's method.
    pub newton: u64,
}

impl AddAssign for SearchStats {
    fn add_assign(&mut self, o: Self) {
        self.cells += o.cells;
        self.outside += o.outside;
        self.regular += o.regular;
        self.single += o.single;
        self.newton += o.newton;
    }
}

/// What a search found.
#[derive(Clone, Debug, Default)]
pub struct Critical {
    /// Critical points in increasing order of their values. All of them, if nothing is `open`.
    pub points: Vec<CriticalPoint>,
    /// Boxes in which nothing was decided: degenerate critical points, or where the field is not smooth.
    pub open: Vec<Aabb>,
    /// How many of them, the last ones, hold so many undecided cells that critical points may not be isolated.
    pub crowds: usize,
    /// What it took.
    pub stats: SearchStats,
}

/// Parts into which the region is cut for threads, at least.
const PARTS: usize = 512;

/// Cells are given up when they are so small, as a share of the region
const SMALLEST: f64 = 1e-10;

/// or of the coordinates: there rounding is all that they differ by;
const BLUR: f64 = 1024.0 * f64::EPSILON;

/// and what is left of a part of the region when it has so many cells that are nearly so small.
const CROWD: u64 = 20_000;

/// Crowds that are looked at more closely. Few are one degenerate minimum each; where there are more, there is something
/// else.
const CROWDS: usize = 16;

/// Share of the region below which cells count towards a crowd. Few cells are that small about an isolated
/// critical point, since every level has but those around it.
const SMALL: f64 = 1e-5;

/// Finds the critical points of a tape's first output; nothing if it was cancelled.
pub fn search(tape: &Arc<Tape>, search: &Search, watch: &Watch<'_>) -> Option<Critical> {
    // In what is no box there is nothing.
    let mut parts = if search.region.is_proper() { Cell::of(&search.region) } else { Vec::new() };
    while (1..PARTS).contains(&parts.len()) {
        parts = parts.iter().flat_map(Cell::parts).collect();
    }
    let (done, total) = (AtomicUsize::new(0), parts.len());
    let found: Vec<Part> = parts
        .par_iter()
        .map_init(
            || Balls::new(tape),
            |field, cell| {
                let part = Part::search(field, vec![*cell], search, (u64::MAX, watch.cancel));
                (watch.progress)((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / total as f64);
                part
            },
        )
        .collect();
    if watch.cancel.load(Ordering::Relaxed) {
        return None;
    }
    let mut out = gathered(found);
    isolate(&mut Balls::new(tape), &mut out, search.solid);
    Some(out)
}

/// Takes open places that are minima or maxima all the same for such.
pub(super) fn isolate(field: &mut Balls, found: &mut Critical, solid: bool) {
    let places = std::mem::take(&mut found.open);
    let few = places.len() - std::mem::take(&mut found.crowds);
    let is_crowd = |i: usize| i >= few;
    let crowds_too = places.len() - few <= CROWDS;
    for (i, place) in places.into_iter().enumerate() {
        match (crowds_too || !is_crowd(i)).then(|| isolated(field, &place)).flatten() {
            Some(point) => {
                found.points.retain(|p| p.position.distance(point.position) > point.error);
                if !solid || point.is_inside() != Some(false) {
                    found.points.push(point);
                }
            }
            None => {
                found.open.push(place);
                found.crowds += usize::from(is_crowd(i));
            }
        }
    }
    found.points.sort_by(by_value);
}

/// Finds the critical points in a few cells, some of which may be flat; what is not smooth is left open, and what is left
/// when it has looked at so many cells.
pub(super) fn search_cells(
    field: &mut Balls,
    cells: Vec<Cell>,
    search: &Search,
    limits: (u64, &AtomicBool),
) -> Critical {
    gathered(vec![Part::search(field, cells, search, limits)])
}

/// All that the parts found, each point once.
fn gathered(parts: Vec<Part>) -> Critical {
    let mut out = Critical::default();
    let (mut points, mut open) = (Vec::new(), Vec::new());
    for part in parts {
        out.stats += part.stats;
        points.extend(part.points);
        open.extend(part.open);
    }
    let (points, twins) = merged(points);
    open.extend(twins.into_iter().map(|bounds| Place { bounds, crowded: false }));
    out.points = points;
    let places = clusters(open);
    out.crowds = places.iter().filter(|place| place.crowded).count();
    out.open = places.into_iter().map(|place| place.bounds).collect();
    out.points.sort_by(by_value);
    out
}

/// A box in which nothing was decided.
#[derive(Clone, Copy)]
struct Place {
    bounds: Aabb,
    /// Whether that was given up since there is so much of it.
    crowded: bool,
}

/// What one part of the region comes to.
#[derive(Default)]
struct Part {
    points: Vec<CriticalPoint>,
    open: Vec<Place>,
    stats: SearchStats,
}

impl Part {
    /// Searches until it is cancelled, or has looked at so many cells.
    fn search(
        field: &mut Balls,
        roots: Vec<Cell>,
        search: &Search,
        (most, cancel): (u64, &AtomicBool),
    ) -> Part {
        let mut part = Part::default();
        let diagonal = search.region.diagonal();
        let Aabb { min, max } = search.region;
        let blur = BLUR * min.abs().max(max.abs()).max_element();
        let smallest = blur.max(SMALLEST * diagonal);
        let (mut stack, mut small, mut crowded) = (roots, 0, false);
        let mut single: Vec<Cell> = Vec::new();
        while !(cancel.load(Ordering::Relaxed) || stack.is_empty() && single.is_empty()) {
            if single.len() >= LANES || stack.is_empty() {
                let batch: Vec<Cell> = single.drain(single.len().saturating_sub(LANES)..).collect();
                part.polish(field, &batch, (search, smallest), &mut stack);
                continue;
            }
            if part.stats.cells >= most {
                part.open.extend(stack.drain(..).map(|cell| Place { bounds: bounds(&cell), crowded: true }));
                continue;
            }
            let from = stack.len().saturating_sub(LANES);
            let batch: Vec<Cell> = stack.drain(from..).collect();
            let verdicts = field.judged(&batch, search.solid);
            part.stats.cells += batch.len() as u64;
            for (i, cell) in batch.iter().enumerate() {
                match verdicts.of(i) {
                    Verdict::Critical => part.open.push(Place { bounds: bounds(cell), crowded }),
                    Verdict::Outside => part.stats.outside += 1,
                    Verdict::Regular => part.stats.regular += 1,
                    Verdict::Single => {
                        part.stats.single += 1;
                        single.push(*cell);
                    }
                    Verdict::Open(zeros) => {
                        let size = cell.radius();
                        small += u64::from(size < SMALL * diagonal);
                        crowded |= small > CROWD;
                        if size < smallest || crowded {
                            part.open.push(Place { bounds: bounds(cell), crowded });
                        } else {
                            cut(cell, (&field.known(i, cell), &zeros), search.solid, &mut stack);
                        }
                    }
                }
            }
        }
        part
    }

    /// Runs Newton's method in cells with at most one critical point; those where it fails are cut.
    fn polish(
        &mut self,
        field: &mut Balls,
        cells: &[Cell],
        (search, smallest): (&Search, f64),
        stack: &mut Vec<Cell>,
    ) {
        for (cell, outcome) in cells.iter().zip(polish(field, cells, &mut self.stats.newton)) {
            match outcome {
                None if cell.radius() < smallest => {
                    self.open.push(Place { bounds: bounds(cell), crowded: false });
                }
                None => stack.extend(cell.parts()),
                Some(point) => {
                    let wanted = !search.solid || point.is_inside() != Some(false);
                    if wanted && cell.holds(point.position, point.error) {
                        self.points.push(point);
                    }
                }
            }
        }
    }
}

/// The parts of a cell that may hold critical points, by what is known of it.
fn cut(cell: &Cell, (f, zeros): (&Taylor, &Zeros), solid: bool, stack: &mut Vec<Cell>) {
    let (unit, octants) = (cell.unit(), cell.octants());
    let (share, off) = ((octants.half * unit).to_array(), (octants.off * unit).to_array());
    let free = free_parts(f, zeros, (share, off), solid);
    for i in 0..8 {
        if octants.has(i) && !free[i] {
            stack.push(octants.part(i));
        }
    }
}

/// How far beyond a region a field is asked whether it has a value, in halves of the region.
const BEYOND: f64 = 1.2;

/// What is next to the middle of a ball, as a share of its radius.
const BESIDE: f64 = 1e-6;

/// A field to be evaluated over balls, with the memory for a batch of them.
#[derive(Clone, Debug)]
pub struct Balls {
    field: Evaluator<Taylors<LANES>>,
    at: [Taylors<LANES>; 3],
    /// Where the field is known to have a value, so that nobody need ask.
    defined: Option<Defined>,
    /// Where the solid ends, whatever the field says.
    region: Aabb,
}

impl Balls {
    pub fn new(tape: &Arc<Tape>) -> Self {
        let field = Evaluator::new(tape.clone());
        let region = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
        Balls { field, at: std::array::from_fn(|_| Taylors::constant(0.0)), defined: None, region }
    }

    /// The same of a solid that ends with a region, which knows where in it and a little beyond the field has a value.
    pub fn within(tape: &Arc<Tape>, region: &Aabb) -> Self {
        let around = region.intervals().map(|x| Interval::around(x.mid(), BEYOND * x.rad()));
        Balls { defined: Defined::within(tape, &around), region: *region, ..Balls::new(tape) }
    }

    /// The field over as many balls as there are lanes, at most, by their centres and radii. What idle lanes hold
    /// is of no interest.
    pub fn eval(&mut self, balls: impl Iterator<Item = (DVec3, f64)>) -> &Taylors<LANES> {
        let (mut centres, mut radii) = ([[0.0; LANES]; 3], [0.0; LANES]);
        for (lane, (centre, radius)) in balls.take(LANES).enumerate() {
            // Idle lanes are like the first one.
            let lanes = if lane == 0 { 0..LANES } else { lane..lane + 1 };
            for lane in lanes {
                (0..3).for_each(|axis| centres[axis][lane] = centre[axis]);
                radii[lane] = radius;
            }
        }
        self.field.eval_by(|axis, coordinate| coordinate.set_coordinate(axis, &centres[axis], &radii))
    }

    /// What is certain of a few cells, as many as there are lanes at most; see [`known`](Self::known).
    fn judged(&mut self, cells: &[Cell], solid: bool) -> Verdicts<LANES> {
        let mut shares = [[0.0; LANES]; 3];
        for (lane, cell) in cells.iter().enumerate() {
            let share = cell.share();
            (0..3).for_each(|axis| shares[axis][lane] = share[axis]);
        }
        let values = self.eval(cells.iter().map(|cell| (cell.centre, cell.radius())));
        if !cells.iter().any(Cell::is_flat) {
            judge(values, &shares, solid)
        } else {
            let mut flat = *values;
            cells.iter().enumerate().for_each(|(lane, cell)| flat.hold(lane, cell.free_axes()));
            judge(&flat, &shares, solid)
        }
    }

    /// What is known of a cell that was just judged.
    fn known(&self, lane: usize, cell: &Cell) -> Taylor {
        let f = self.field.output(0).lane(lane);
        if cell.is_flat() { f.on(cell.free_axes()) } else { f }
    }

    /// Goes on with another tape of the same field: one that holds wherever it is asked from now on.
    pub fn turn_to(&mut self, tape: &Arc<Tape>) {
        self.field.turn_to(tape);
    }

    /// Whether the field is known to have a value everywhere in a box.
    pub fn is_defined(&self, region: &Aabb) -> bool {
        let region = region.intervals();
        self.defined.is_some_and(|defined| defined.holds(&region)) || self.field.tape().is_defined(&region)
    }

    /// The same of a ball. Ranges are of the values that there are: they do not tell.
    pub fn is_defined_around(&self, centre: DVec3, radius: f64) -> bool {
        let reach = radius + 16.0 * f64::EPSILON * centre.abs().max_element();
        self.is_defined(&Aabb { min: centre - reach, max: centre + reach })
    }

    /// Whether a ball is in the region.
    pub fn is_within(&self, centre: DVec3, radius: f64) -> bool {
        (centre - radius).cmpge(self.region.min).all() && (centre + radius).cmple(self.region.max).all()
    }

    /// Whether a ball with such values is all inside of the solid.
    pub fn is_full(&self, centre: DVec3, radius: f64, range: Interval) -> bool {
        range.hi < 0.0 && self.is_within(centre, radius) && self.is_defined_around(centre, radius)
    }

    /// Whether it is known to have a value everywhere in a ball but next to the middle.
    pub fn is_defined_beside(&self, centre: DVec3, radius: f64) -> bool {
        if self.is_defined_around(centre, radius) {
            return true;
        }
        let all = std::array::from_fn(|axis| Interval::around(centre[axis], radius));
        // What has no value elsewhere has none beside the middle.
        let is_elsewhere = |hollow: &[Interval; 3]| (0..3).any(|axis| !hollow[axis].contains(centre[axis]));
        let known = self.defined.filter(|defined| defined.is_about(&all));
        if known.is_some_and(|defined| defined.hollow().is_some_and(is_elsewhere)) {
            return false;
        }
        let next = |axis: usize| Interval::around(centre[axis], BESIDE * radius);
        let is_next = |hollow: &[Interval; 3]| (0..3).all(|axis| next(axis).encloses(hollow[axis]));
        let found = Defined::within(self.field.tape(), &all);
        found.is_some_and(|defined| defined.hollow().is_none_or(is_next))
    }

    /// The field along as many straight lines, by their middles and by halves of them.
    pub fn along(&mut self, lines: impl Iterator<Item = (DVec3, DVec3)>) -> &Taylors<LANES> {
        for (lane, (middle, half)) in lines.take(LANES).enumerate() {
            Taylors::set_line(&mut self.at, lane, middle.to_array(), half.to_array());
        }
        self.field.eval(&self.at)
    }
}

fn bounds(cell: &Cell) -> Aabb {
    Aabb { min: cell.centre - cell.half, max: cell.centre + cell.half }
}

/// Each critical point once, and boxes around those of which it is not proven
/// that they are one or two.
fn merged(mut points: Vec<CriticalPoint>) -> (Vec<CriticalPoint>, Vec<Aabb>) {
    points.sort_by(|a, b| order(a.position, b.position));
    let widest = points.iter().map(|p| p.error).fold(0.0, f64::max);
    let mut kept: Vec<CriticalPoint> = Vec::with_capacity(points.len());
    let mut twins = Vec::new();
    for point in points {
        let near = kept.iter().rev().take_while(|k| point.position.x - k.position.x <= 2.0 * widest);
        let twin = near.copied().find(|k| k.position.distance(point.position) <= k.error + point.error);
        match twin {
            Some(k)
                if k.position.distance(point.position) + k.error + point.error < k.alone.max(point.alone) => {
            }
            Some(k) => twins.push(Aabb {
                min: k.position.min(point.position) - k.error - point.error,
                max: k.position.max(point.position) + k.error + point.error,
            }),
            None => kept.push(point),
        }
    }
    (kept, twins)
}

fn by_value(a: &CriticalPoint, b: &CriticalPoint) -> std::cmp::Ordering {
    a.value.total_cmp(&b.value).then(order(a.position, b.position))
}

fn order(a: DVec3, b: DVec3) -> std::cmp::Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}

/// Boxes around boxes that meet, crowds last.
fn clusters(mut places: Vec<Place>) -> Vec<Place> {
    places.sort_by(|a, b| order(a.bounds.min, b.bounds.min));
    let mut out: Vec<Place> = Vec::new();
    for mut whole in places {
        // A box that grows may meet others.
        while let Some(i) = out.iter().position(|o| meet(&o.bounds, &whole.bounds)) {
            let o = out.swap_remove(i);
            whole = Place { bounds: whole.bounds.hull(&o.bounds), crowded: whole.crowded || o.crowded };
        }
        out.push(whole);
    }
    out.sort_by(|a, b| a.crowded.cmp(&b.crowded).then(order(a.bounds.min, b.bounds.min)));
    out
}

fn meet(a: &Aabb, b: &Aabb) -> bool {
    let margin = 0.5 * (a.diagonal().min(b.diagonal()));
    (a.min - margin).cmple(b.max).all() && (b.min - margin).cmple(a.max).all()
}
