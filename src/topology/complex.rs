//! The complex of minima and separatrices, and the components of the solid that follow from it.
//!
//! Every component of `f < 0` has a minimum, and two minima are in one component just if a chain of separatrices of
//! 1-saddles with `f < 0` leads from one to the other (Gamito 2009, 8.3). Along the eigenvector `v` of the negative
//! eigenvalue of a 1-saddle the field is concave in a ball where `v^T H v + twist < 0`, so it falls on both sides
//! of the saddle throughout, and paths downhill from the two ends stay below the saddle. Which minima these find
//! may not be those of the streamlines, but the two lobes that the saddle joins are the same, and so is what a
//! union-find comes to, at this and every lower level.
//!
//! The counts of critical points by index give the Euler characteristic of each component, since a component is
//! built from a cell for each: `minima - 1-saddles + 2-saddles - maxima`. It is `1 - handles + voids`; 2-saddles alone
//! can close off a void, so that one without them has as many handles as that says. The others have when their
//! [voids](super::voids) are known.

use super::basin::{Basin, Basins, widest};
use super::border::is_closed;
use super::descent::{End, Place, Start, descend};
use super::point::{CriticalPoint, Kind};
use super::search::{Balls, Critical, Search, SearchStats};
use super::sets::Sets;
use crate::field::Watch;
use crate::scene::Aabb;
use crate::tape::Tape;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A 1-saddle with the minima on both sides of it.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct Arc1 {
    /// Which of the complex's points is the saddle.
    pub saddle: usize,
    /// Which are the minima, where the paths found some.
    pub minima: [Option<usize>; 2],
    /// Whether it joins what nothing lower joins; else it closes a ring.
    pub joins: bool,
}

/// A component of the solid.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Component {
    /// Critical points by index.
    pub counts: [usize; 4],
    /// The lowest minimum, as a number of the complex's points.
    pub deepest: usize,
    /// The value there.
    pub lowest: f64,
    /// Euler characteristic.
    pub euler: i64,
    /// Number of voids, where it is known: where all of it is known to be in the region, and it has no 2-saddles, or
    /// voids were looked for.
    pub voids: Option<usize>,
    /// Number of handles, where that of voids is known.
    pub genus: Option<i64>,
    /// A box around its critical points.
    #[serde(rename = "critical_bounds")]
    pub bounds: Aabb,
}

/// Critical points, separatrices and components of a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Complex {
    /// Where it was looked for.
    pub region: Aabb,
    /// Critical points inside, in increasing order of their values.
    pub points: Vec<CriticalPoint>,
    /// Which component each of them belongs to.
    pub component: Vec<Option<usize>>,
    /// 1-saddles with their minima.
    pub arcs: Vec<Arc1>,
    /// Components, those with most minima first.
    pub components: Vec<Component>,
    /// Basins of the minima: their points, and radii.
    pub basins: Vec<(usize, f64)>,
    /// Boxes in which critical points were not decided.
    pub open: Vec<Aabb>,
    /// Points of which it is not certain whether they are inside.
    pub level: Vec<CriticalPoint>,
    /// Critical points from which a path found no minimum, and minima without a basin.
    pub lost: usize,
    /// Critical points from which a path left the region.
    pub beyond: usize,
    /// Whether the solid may go on beyond the region: then there may be components without a critical point in it.
    pub cut: bool,
    /// What the search took.
    pub stats: SearchStats,
}

/// Paths that a thread follows together.
const PATHS: usize = 128;

impl Complex {
    /// Joins the critical points of a tape's first output that a search has found; nothing if it was cancelled.
    pub fn new(tape: &Arc<Tape>, search: &Search, critical: Critical, watch: &Watch<'_>) -> Option<Complex> {
        let region = search.region;
        let (points, level): (Vec<_>, Vec<_>) = critical
            .points
            .into_iter()
            .filter(|p| p.is_inside() != Some(false))
            .partition(|p| p.is_inside() == Some(true));
        let minima: Vec<usize> = of_kind(&points, Kind::Minimum);
        let largest = 0.125 * region.diagonal();
        let around = |field: &mut Balls, &i: &usize| match points[i].smooth {
            true => Basin::around(field, &points[i], largest),
            false => Basin { centre: points[i].position, radius: points[i].alone },
        };
        let found: Vec<Basin> = minima.par_iter().map_init(|| Balls::new(tape), around).collect();
        let basins = Basins::new(found.clone());
        // Two paths from a 1-saddle; one from a point higher up, which is enough to know its component.
        let others: Vec<usize> = (0..points.len()).filter(|&i| points[i].kind != Kind::Minimum).collect();
        let followed = AtomicUsize::new(0);
        let ends: Vec<[End<usize>; 2]> = others
            .par_chunks(PATHS)
            .map_init(
                || Balls::new(tape),
                |field, some| {
                    let ends = both_ends(field, &points, some, &basins, &region);
                    let done = followed.fetch_add(some.len(), Ordering::Relaxed) + some.len();
                    (watch.progress)(done as f64 / others.len() as f64);
                    ends
                },
            )
            .flatten()
            .collect();
        let cut = !is_closed(tape, &region, watch.cancel);
        if watch.cancel.load(Ordering::Relaxed) {
            return None;
        }
        let count = |what: End<usize>| ends.iter().filter(|pair| pair.contains(&what)).count();
        let mut out = Complex {
            region,
            component: vec![None; points.len()],
            arcs: Vec::new(),
            components: Vec::new(),
            basins: minima.iter().zip(&found).map(|(&i, b)| (i, b.radius)).collect(),
            open: critical.open,
            level,
            lost: count(End::Lost) + found.iter().filter(|b| b.radius <= 0.0).count(),
            beyond: count(End::Beyond),
            cut,
            stats: critical.stats,
            points,
        };
        let ends = others.into_iter().zip(ends).map(|(i, ends)| (i, ends.map(|e| minimum(&minima, e))));
        out.join(&minima, &ends.collect::<Vec<_>>());
        Some(out)
    }

    /// Whether it is proven that the components are these.
    pub fn is_certified(&self) -> bool {
        self.open.is_empty() && self.level.is_empty() && self.lost == 0 && self.beyond == 0 && !self.cut
    }

    /// The basins by where they are; number `i` is that of the minimum `basins[i].0`.
    pub fn basins(&self) -> Basins {
        let basin = |&(i, radius): &(usize, f64)| Basin { centre: self.points[i].position, radius };
        Basins::new(self.basins.iter().map(basin).collect())
    }

    /// Critical points by index.
    pub fn counts(&self) -> [usize; 4] {
        Kind::ALL.map(|kind| self.points.iter().filter(|p| p.kind == kind).count())
    }

    /// Euler characteristic of the solid.
    pub fn euler(&self) -> i64 {
        euler(self.counts())
    }

    /// Union-find over the minima, in increasing order of the saddles' values.
    fn join(&mut self, minima: &[usize], ends: &[(usize, [Option<usize>; 2])]) {
        let mut sets = Sets::default();
        sets.grow(self.points.len());
        for &(saddle, ends) in ends {
            if self.points[saddle].kind != Kind::Saddle1 {
                continue;
            }
            let joins = match ends {
                [Some(a), Some(b)] => sets.join(a as u32, b as u32),
                _ => false,
            };
            self.arcs.push(Arc1 { saddle, minima: ends, joins });
        }
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for &i in minima {
            members.entry(sets.of(i as u32)).or_default().push(i);
        }
        for &(i, ends) in ends {
            if let Some(end) = ends.into_iter().flatten().next() {
                members.entry(sets.of(end as u32)).or_default().push(i);
            }
        }
        let mut members: Vec<Vec<usize>> = members.into_values().collect();
        let most = |m: &Vec<usize>| m.iter().filter(|&&i| self.points[i].kind == Kind::Minimum).count();
        members.sort_by_key(|m| (std::cmp::Reverse(most(m)), m[0]));
        for (number, members) in members.iter().enumerate() {
            members.iter().for_each(|&i| self.component[i] = Some(number));
            let component = self.describe(members);
            self.components.push(component);
        }
    }

    fn describe(&self, members: &[usize]) -> Component {
        let points = members.iter().map(|&i| &self.points[i]);
        let counts = Kind::ALL.map(|kind| points.clone().filter(|p| p.kind == kind).count());
        let deepest =
            members.iter().copied().min_by(|&a, &b| self.points[a].value.total_cmp(&self.points[b].value));
        let deepest = deepest.unwrap_or_default();
        let (mut min, mut max) = (self.points[deepest].position, self.points[deepest].position);
        for p in points {
            (min, max) = (min.min(p.position), max.max(p.position));
        }
        let euler = euler(counts);
        let (lowest, bounds) = (self.points[deepest].value, Aabb { min, max });
        let component = Component { counts, deepest, lowest, euler, voids: None, genus: None, bounds };
        if counts[2] == 0 && !self.cut { component.with_voids(0) } else { component }
    }
}

impl Component {
    /// The same, of which it is known how many voids it has.
    pub fn with_voids(self, voids: usize) -> Component {
        Component { voids: Some(voids), genus: Some(1 - self.euler + voids as i64), ..self }
    }
}

/// `minima - 1-saddles + 2-saddles - maxima`
fn euler(counts: [usize; 4]) -> i64 {
    let [a, b, c, d] = counts.map(|n| n as i64);
    a - b + c - d
}

fn of_kind(points: &[CriticalPoint], kind: Kind) -> Vec<usize> {
    (0..points.len()).filter(|&i| points[i].kind == kind).collect()
}

/// The minimum that a path has found.
fn minimum(minima: &[usize], end: End<usize>) -> Option<usize> {
    match end {
        End::At(i) => Some(minima[i]),
        End::Beyond | End::Lost => None,
    }
}

/// The ends of the paths down both sides of these points.
fn both_ends(
    field: &mut Balls,
    points: &[CriticalPoint],
    some: &[usize],
    basins: &Basins,
    region: &Aabb,
) -> Vec<[End<usize>; 2]> {
    let mut starts: Vec<Start> = Vec::with_capacity(2 * some.len());
    for &i in some {
        let [back, forth] = sides(field, &points[i], 0.125 * region.diagonal());
        starts.push(back);
        starts.extend((points[i].kind == Kind::Saddle1).then_some(forth));
    }
    let arrival = |_, place: &Place| basins.find(place.at);
    let mut ends = descend(field, arrival, region, &starts).into_iter();
    let mut next = || ends.next().unwrap_or(End::Lost);
    let mut pair = |&i: &usize| {
        let end = next();
        [end, if points[i].kind == Kind::Saddle1 { next() } else { end }]
    };
    let mut pairs: Vec<[End<usize>; 2]> = some.iter().map(&mut pair).collect();
    // Where one path is enough, others may serve as well.
    for (&i, ends) in some.iter().zip(&mut pairs) {
        if points[i].kind != Kind::Saddle1 && ends[0] == End::Lost {
            let mut others = aslant(points[i].down).into_iter().flat_map(|down| {
                let starts = sides(field, &CriticalPoint { down, ..points[i] }, 0.125 * region.diagonal());
                descend(field, arrival, region, &starts)
            });
            if let Some(end) = others.find(|end| matches!(end, End::At(_))) {
                *ends = [end; 2];
            }
        }
    }
    pairs
}

/// Directions at some angle to one, and that one. Fields that are sums of functions of one coordinate each fall from a
/// 2-saddle along an axis, and come to rest in a 1-saddle; aslant they do not.
fn aslant(v: DVec3) -> [DVec3; 5] {
    let across = v.any_orthonormal_vector();
    let aside = |a: f64, b: f64| (v + a * across + b * v.cross(across)).normalize();
    [v, aside(0.5, 0.2), aside(-0.2, 0.5), aside(-0.5, -0.2), aside(0.2, -0.5)]
}

/// Where paths down both sides of a point begin: as far from it as the field is proven to fall all the way.
pub(super) fn sides(field: &mut Balls, point: &CriticalPoint, largest: f64) -> [Start; 2] {
    let v = point.down;
    if !point.smooth {
        let radius = point.error;
        return [-1.0, 1.0].map(|side| Start { at: point.position + side * radius * v, radius });
    }
    let falls = |h: [f64; 6], twist: f64| {
        let bend = v.dot(super::matrix::matrix(h) * v);
        bend + (twist + 1e-13 * bend.abs()) * (1.0 + 1e-9) < 0.0
    };
    let radius = widest(field, point.position, largest, falls);
    [-1.0, 1.0].map(|side| Start { at: point.position + side * radius * v, radius })
}

/// What a point of the solid belongs to, by a path downhill. Clones have memory of their own, for other threads.
#[derive(Clone, Debug)]
pub struct Locator {
    field: Balls,
    basins: Arc<Basins>,
    /// The component of each basin.
    component: Arc<[Option<usize>]>,
    region: Aabb,
}

impl Locator {
    /// For the components of a complex of a tape's first output.
    pub fn new(tape: &Arc<Tape>, complex: &Complex) -> Locator {
        let component = complex.basins.iter().map(|&(i, _)| complex.component[i]).collect();
        Locator {
            field: Balls::new(tape),
            basins: Arc::new(complex.basins()),
            component,
            region: complex.region,
        }
    }

    /// The component of a point, if it is certain to be inside and a path leads down from it.
    pub fn component_inside(&mut self, p: DVec3) -> Option<usize> {
        let range = self.field.eval(std::iter::once((p, 0.0))).lane(0).range;
        (range.hi < 0.0).then(|| self.components(&[p], |_| None)[0]).flatten()
    }

    /// The components of points inside; none where a path found no minimum. `shortcut` may know the component of a
    /// place without any path.
    pub fn components(
        &mut self,
        points: &[DVec3],
        shortcut: impl Fn(DVec3) -> Option<usize>,
    ) -> Vec<Option<usize>> {
        let radius = 1e-3 * self.region.diagonal();
        let starts: Vec<Start> = points.iter().map(|&at| Start { at, radius }).collect();
        let arrival =
            |_, place: &Place| shortcut(place.at).or_else(|| self.component[self.basins.find(place.at)?]);
        let ends = descend(&mut self.field, arrival, &self.region, &starts);
        let component = |end: End<usize>| if let End::At(component) = end { Some(component) } else { None };
        ends.into_iter().map(component).collect()
    }
}
