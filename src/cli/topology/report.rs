//! What a solid is connected with, for people and for programs.

use crate::cli::report::{count, out, plural};
use crate::diag::Diagnostic;
use crate::scene::Aabb;
use crate::session::topology::{Analysis, Parts, Size};
use crate::topology::{Complex, Component, Kind, SearchStats};
use glam::DVec3;
use serde::Serialize;

/// What the report says.
#[derive(Serialize)]
pub struct Report<'a> {
    /// Whether all of it is proven.
    certified: bool,
    /// Of smooth fields.
    critical_points: Option<Counts>,
    components: Vec<Line<'a>>,
    undecided: Undecided,
    search: Option<SearchStats>,
    cells: usize,
    /// Whether critical points were found on disk.
    remembered: bool,
    seconds: f64,
}

#[derive(Serialize)]
struct Counts {
    minima: usize,
    saddles1: usize,
    saddles2: usize,
    maxima: usize,
    euler: i64,
}

#[derive(Serialize)]
struct Line<'a> {
    kept: bool,
    /// A box that holds it, as far as cells tell.
    bounds: Option<Aabb>,
    /// Its volume, about.
    volume: f64,
    #[serde(flatten)]
    component: Option<&'a Component>,
}

/// What is not proven, by reason.
#[derive(Default, Serialize)]
struct Undecided {
    /// Where critical points, or what joins cells, were not decided.
    places: Vec<Aabb>,
    /// Critical points that may be inside or not.
    level: usize,
    /// Paths that found no minimum.
    lost: usize,
    /// Paths that left the region.
    beyond: usize,
    /// Components that may go on beyond the region.
    cut: usize,
}

impl<'a> Report<'a> {
    pub fn new(analysis: &'a Analysis, sizes: &[Size], kept: &[bool], seconds: f64) -> Report<'a> {
        let complex = analysis.complex();
        let line = |(i, (size, &kept)): (usize, (&Size, &bool))| Line {
            kept,
            bounds: size.bounds,
            volume: size.volume,
            component: complex.map(|c| &c.components[i]),
        };
        Report {
            certified: complex.map_or_else(|| analysis.flood.is_certified(), Complex::is_certified),
            critical_points: complex.map(Counts::new),
            components: sizes.iter().zip(kept).enumerate().map(line).collect(),
            undecided: Undecided::new(analysis),
            search: complex.map(|c| c.stats),
            cells: analysis.flood.cells,
            remembered: analysis.remembered,
            seconds,
        }
    }

    /// The table, with so many components.
    pub fn print(&self, top: usize) {
        let certified = if self.certified { "certified" } else { "not certified" };
        let components = plural(self.components.len() as u64, "component");
        match &self.critical_points {
            Some(counts) => {
                out(counts);
                out(format!("Euler characteristic {}, {components}, {certified}", counts.euler));
            }
            None => out(format!("{components}, {certified}")),
        }
        if top == 0 || self.components.is_empty() {
            return;
        }
        let smooth = self.critical_points.is_some();
        let details =
            if smooth { "  minima  1-saddles  2-saddles  maxima  Euler  genus     lowest" } else { "" };
        out(format!("\ncomponent      volume{details}  kept"));
        self.components.iter().enumerate().take(top).for_each(|(i, line)| line.print(i));
        match self.components.len().saturating_sub(top) {
            0 => {}
            n => out(format!("and {} more; --top {} shows all", count(n as u64), self.components.len())),
        }
    }

    /// Cells that were looked at.
    pub fn cells(&self) -> u64 {
        self.cells as u64 + self.search.map_or(0, |s| s.cells)
    }

    /// What is not proven, and what to do about it.
    pub fn doubts(&self) -> Vec<Diagnostic> {
        let Undecided { places, level, lost, beyond, cut } = &self.undecided;
        let mut doubts = Vec::new();
        let mut doubt = |n: usize, noun: &str, what: &str, hint: &str| {
            if n > 0 {
                doubts.push(Diagnostic::warning(format!("{} {what}", plural(n as u64, noun))).hint(hint));
            }
        };
        let first = places.first().map_or(DVec3::ZERO, |b| 0.5 * (b.min + b.max));
        let what = format!("could not be decided; the first is at {first:.6}");
        let degenerate = "a slightly other parameter, or a little noise, parts critical points that coincide";
        let thin = "parts that only just touch, or very thin ones, cannot be told apart; try a smooth field";
        let hint = if self.critical_points.is_some() { degenerate } else { thin };
        doubt(places.len(), "place", &what, hint);
        let hint = "shift the field by a small constant";
        doubt(*level, "critical point", "may be inside or not", hint);
        let hint = "what they would have joined may be apart in the report";
        doubt(*lost, "path", "found no minimum", hint);
        let hint = "widen the bounds of the scene";
        doubt(*beyond, "path", "left the region: the solid reaches beyond the bounds", hint);
        doubt(*cut, "component", "may go on beyond the bounds", hint);
        doubts
    }
}

impl Counts {
    fn new(complex: &Complex) -> Counts {
        let [minima, saddles1, saddles2, maxima] = complex.counts();
        Counts { minima, saddles1, saddles2, maxima, euler: complex.euler() }
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let several = |n: usize, kind: Kind, plural: &str| {
            format!("{} {}", count(n as u64), if n == 1 { kind.name() } else { plural })
        };
        let minima = several(self.minima, Kind::Minimum, "minima");
        let saddles1 = several(self.saddles1, Kind::Saddle1, "1-saddles");
        let saddles2 = several(self.saddles2, Kind::Saddle2, "2-saddles");
        write!(f, "{minima}, {saddles1}, {saddles2}, {}", several(self.maxima, Kind::Maximum, "maxima"))
    }
}

impl Line<'_> {
    fn print(&self, i: usize) {
        let volume = self.volume;
        let details = self.component.map_or(String::new(), |c| {
            let (Component { euler, lowest, .. }, [a, b, c2, d]) = (c, c.counts);
            let genus = c.genus.map_or("?".to_owned(), |g| g.to_string());
            format!(" {a:7} {b:10} {c2:10} {d:7} {euler:6} {genus:>6} {lowest:10.4}")
        });
        out(format!("{i:9} {volume:11.5}{details}  {}", if self.kept { "yes" } else { "no" }));
    }
}

impl Undecided {
    fn new(analysis: &Analysis) -> Undecided {
        match &analysis.parts {
            Parts::Complex(complex) => Undecided {
                places: complex.open.clone(),
                level: complex.level.len(),
                lost: complex.lost,
                beyond: complex.beyond,
                cut: 0,
            },
            Parts::Flood => Undecided {
                places: analysis.flood.undecided.clone(),
                cut: analysis.flood.list.iter().filter(|c| c.cut).count(),
                ..Undecided::default()
            },
        }
    }
}
