//! What a solid is connected with, for people and for programs.

use crate::cast::Ruling;
use crate::cli::report::{count, out, plural};
use crate::diag::Diagnostic;
use crate::scene::Aabb;
use crate::session::topology::{Analysis, Origin, Part, Void, Voids};
use crate::topology::{Complex, Component, Kind, SearchStats};
use glam::DVec3;
use serde::Serialize;

/// What the report says.
#[derive(Serialize)]
pub struct Report<'a> {
    /// Whether it is proven of the whole solid that these are its components,
    certified: bool,
    /// or of what of it is within the region.
    certified_within_bounds: bool,
    /// Of a flowed solid, before it flowed: whether it is proven that what is proven of it is true after as well.
    kept_by_flow: Option<bool>,
    /// Where it was looked for.
    region: Aabb,
    /// Of smooth fields, as far as they were found.
    critical_points: Option<Counts>,
    /// Whether these are all, and the components theirs.
    complete: bool,
    /// A point that all of the solid is in sight of, if that is proven: then it is one ball.
    star: Option<DVec3>,
    #[serde(skip)]
    is_ball: bool,
    /// What of the field is not smooth, so that it has no critical points to analyse.
    rough: Option<Rough<'a>>,
    components: Vec<Line<'a>>,
    /// If they were asked for.
    voids: Option<Hollows>,
    undecided: Undecided,
    search: Option<SearchStats>,
    cells: usize,
    /// Whether all of it was found on disk.
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

/// The first thing in a field that is not smooth, and where in the script it is.
#[derive(Serialize)]
struct Rough<'a> {
    what: &'a str,
    file: Option<&'a str>,
    line: Option<u32>,
    column: Option<u32>,
}

#[derive(Serialize)]
struct Line<'a> {
    kept: bool,
    certified: bool,
    /// A box that holds it, as far as cells tell.
    bounds: Option<Aabb>,
    /// Ends of an interval that holds its volume.
    volume: [f64; 2],
    /// An estimate of it, if there is one.
    volume_estimate: Option<f64>,
    #[serde(flatten)]
    component: Option<&'a Component>,
    #[serde(flatten)]
    ball: Option<Ball>,
}

/// What is known of a ball without counting its critical points.
#[derive(Serialize)]
struct Ball {
    euler: i64,
    voids: usize,
    genus: i64,
}

/// What is said of voids.
#[derive(Serialize)]
struct Hollows {
    /// Whether it is proven that these are all.
    certified: bool,
    list: Vec<Hollow>,
}

#[derive(Serialize)]
struct Hollow {
    /// The component that it is in, if that is known.
    component: Option<usize>,
    bounds: Aabb,
    volume: [f64; 2],
}

/// What is not proven, by reason.
#[derive(Default, Serialize)]
struct Undecided {
    /// Where critical points, or what joins cells, were not decided: the first of them, and how many there are.
    places: Vec<Aabb>,
    places_total: usize,
    /// The middle of the smallest cell there.
    doubtful: Option<DVec3>,
    /// Whether there was more to look at there than is looked at in all.
    ran_short: bool,
    /// Where critical points were not decided, though components were: the first of them, and how many there are.
    critical_places: Vec<Aabb>,
    critical_places_total: usize,
    /// Critical points that may be inside or not.
    level: usize,
    /// Paths that found no minimum.
    lost: usize,
    /// Paths that left the region.
    beyond: usize,
    /// Components that may go on beyond the region.
    cut: usize,
    /// Whether there may be something beyond it.
    elsewhere: bool,
}

/// Undecided places in a report.
const PLACES: usize = 1000;

/// What to do where critical points are not isolated.
const DEGENERATE: &str = "a slightly other parameter, or a little noise, parts critical points that coincide";

impl<'a> Report<'a> {
    /// Of a flowed solid with its origin.
    pub fn new(analysis: &'a Analysis, kept: &[Ruling], origin: Option<&Origin>, seconds: f64) -> Report<'a> {
        let complex = analysis.complex.as_deref();
        let undecided = Undecided::new(analysis);
        let kept_by_flow = origin.map(|origin| origin.doubts.is_empty());
        // What a flow is not known to keep is not proven of what it leads to; and none keeps what is in sight.
        let is_kept = kept_by_flow != Some(false);
        let is_ball = is_kept && analysis.flood.star.is_some();
        let ball = |part: &Part| {
            (is_ball && part.critical.is_none()).then_some(Ball { euler: 1, voids: 0, genus: 0 })
        };
        let line = |(part, ruling): (&'a Part, &Ruling)| Line {
            kept: ruling.kept,
            certified: part.certified && is_kept,
            bounds: part.bounds,
            volume: [part.volume.lo, part.volume.hi],
            volume_estimate: part.about,
            component: part.critical.as_ref(),
            ball: ball(part),
        };
        let is_certified = analysis.is_certified() && is_kept;
        Report {
            certified: is_certified && analysis.is_whole && undecided.cut == 0,
            certified_within_bounds: is_certified,
            kept_by_flow,
            region: analysis.region,
            critical_points: complex.map(Counts::new),
            complete: analysis.proven().is_some(),
            star: analysis.flood.star.filter(|_| origin.is_none()),
            is_ball,
            rough: analysis.rough.as_deref().map(Rough::new),
            components: analysis.parts.iter().zip(kept).map(line).collect(),
            voids: analysis.voids.as_ref().map(|voids| Hollows::new(voids, is_kept)),
            undecided,
            search: complex.map(|c| c.stats),
            cells: analysis.flood.cells,
            remembered: analysis.remembered,
            seconds,
        }
    }

    /// The table, with so many components; `all` is what shows them all.
    pub fn print(&self, top: usize, all: &str) {
        let certified = match (self.certified, self.certified_within_bounds) {
            (true, _) => "certified",
            (false, true) => "certified within the bounds only",
            (false, false) => "not certified",
        };
        let components = plural(self.components.len() as u64, "component");
        let voids = self.voids.as_ref().map_or(String::new(), |voids| format!(", {voids}"));
        match &self.critical_points {
            Some(counts) if self.complete => {
                out(counts);
                out(format!("Euler characteristic {}, {components}{voids}, {certified}", counts.euler));
            }
            Some(counts) => {
                out(format!("{counts} found; there may be more"));
                out(format!("{components}{voids}, {certified}"));
            }
            None => out(format!("{components}{voids}, {certified}")),
        }
        if self.is_ball && !self.complete {
            let within = if self.certified { "" } else { " within the bounds" };
            let sight = |p: DVec3| format!(": all of it is in sight of [{}, {}, {}]", p.x, p.y, p.z);
            out(format!("a ball{within}{}", self.star.map_or_else(String::new, sight)));
        }
        if top == 0 || self.components.is_empty() {
            return;
        }
        let details = if self.complete {
            "  minima  1-saddles  2-saddles  maxima  Euler  voids  genus      lowest"
        } else {
            ""
        };
        // In this order they are numbered.
        let key = if self.complete { "by minima" } else { "by volume" };
        out(format!("\n{key} {:>21} {:>10}{details}  kept", "volume", "about"));
        self.components.iter().enumerate().take(top).for_each(|(i, line)| line.print(i));
        match self.components.len().saturating_sub(top) {
            0 => {}
            n => out(format!("and {} more; {all} shows all", count(n as u64))),
        }
    }

    /// Cells that were looked at.
    pub fn cells(&self) -> u64 {
        self.cells as u64 + self.search.map_or(0, |s| s.cells)
    }

    /// What is not proven, and what to do about it.
    pub fn doubts(&self) -> Vec<Diagnostic> {
        let Undecided { doubtful, places_total, ran_short, level, lost, beyond, cut, elsewhere, .. } =
            &self.undecided;
        let mut doubts = Vec::new();
        let what =
            doubtful.map_or_else(String::new, |p| format!("could not be decided; the smallest is at {p:.6}"));
        let thin = "parts that only just touch, or very thin ones, cannot be told apart; try a smooth field";
        if self.critical_points.is_some() && !self.complete && self.certified_within_bounds {
            let handles = if self.is_ball { "" } else { ", so that nothing is said of handles" };
            let all = format!("these are not proven to be all critical points{handles}");
            let first = self.undecided.critical_places.first();
            let place =
                first.map(|b| format!("; the first place in doubt is at {:.6}", 0.5 * (b.min + b.max)));
            let warning = format!("{all}{}", place.unwrap_or_default());
            doubts.push(Diagnostic::warning(warning).hint(DEGENERATE));
        }
        let mut doubt = |n: usize, noun: &str, what: &str, hint: &str| {
            if n > 0 {
                doubts.push(Diagnostic::warning(format!("{} {what}", plural(n as u64, noun))).hint(hint));
            }
        };
        let hint = match (ran_short, &self.critical_points) {
            (true, _) => {
                "no more cells are looked at in all: tighter `bounds`, or less of the solid at a time, leave more to each place"
            }
            (false, Some(_)) => DEGENERATE,
            (false, None) => thin,
        };
        doubt(*places_total, "place", &what, hint);
        let hint = "shift the field by a small constant";
        doubt(*level, "critical point", "may be inside or not", hint);
        let hint = "what they would have joined may be apart in the report";
        doubt(*lost, "path", "found no minimum", hint);
        let hint = "widen the bounds of the scene, or give it some";
        doubt(*beyond, "path", "left the region: the solid reaches beyond the bounds", hint);
        doubt(*cut, "component", "may go on beyond the bounds", hint);
        if *elsewhere && *cut == 0 {
            let warning = "it is not proven that nothing of the solid is beyond the bounds";
            doubts.push(Diagnostic::warning(warning).hint(hint));
        }
        if self.voids.as_ref().is_some_and(|voids| !voids.certified) && self.kept_by_flow != Some(false) {
            let hint = "walls that only just close, a field without a value somewhere, and bounds that cut the solid \
                        leave nothing to prove";
            doubts.push(Diagnostic::warning("it is not proven that these are all voids").hint(hint));
        }
        doubts
    }
}

impl<'a> Rough<'a> {
    fn new(rough: &'a Diagnostic) -> Rough<'a> {
        let place = rough.place.as_ref();
        Rough {
            what: &rough.message,
            file: place.map(|place| &*place.file),
            line: place.map(|place| place.line),
            column: place.map(|place| place.column),
        }
    }
}

impl Hollows {
    /// Of a solid, which a flow may be known to have kept as it was.
    fn new(voids: &Voids, is_kept: bool) -> Hollows {
        let hollow = |void: &Void| Hollow {
            component: void.part,
            bounds: void.bounds,
            volume: [void.volume.lo, void.volume.hi],
        };
        Hollows { certified: voids.certified && is_kept, list: voids.list.iter().map(hollow).collect() }
    }
}

impl std::fmt::Display for Hollows {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&plural(self.list.len() as u64, "void"))?;
        f.write_str(if self.certified { "" } else { " (not proven)" })
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
        let volume = enclosed(self.volume);
        let about = self.volume_estimate.map_or_else(|| "?".to_owned(), significant);
        let details = self.component.map_or(String::new(), |c| {
            let (Component { euler, lowest, .. }, [a, b, c2, d]) = (c, c.counts);
            let voids = c.voids.map_or("?".to_owned(), |n| n.to_string());
            let genus = c.genus.map_or("?".to_owned(), |g| g.to_string());
            format!(
                " {a:7} {b:10} {c2:10} {d:7} {euler:6} {voids:>6} {genus:>6} {:>11}",
                significant(*lowest)
            )
        });
        out(format!("{i:9} {volume:>21} {about:>10}{details}  {}", if self.kept { "yes" } else { "no" }));
    }
}

/// A number of any size, with five digits that matter.
fn significant(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x:.4}") } else { format!("{x:.3e}") }
}

/// A volume as far as it is known: `4.70..4.74`, `< 0.02`, or `?`. The ends are rounded outwards.
fn enclosed([lo, hi]: [f64; 2]) -> String {
    if !hi.is_finite() {
        return "?".to_owned();
    }
    // Both ends in units of one power of ten, if they are not of a handy size.
    let power = if hi > 0.0 { libm::floor(libm::log10(hi)) as i32 } else { 0 };
    let power = if (-3..6).contains(&power) { 0 } else { power };
    let unit = libm::pow(10.0, f64::from(power));
    let suffix = if power == 0 { String::new() } else { format!("e{power}") };
    // As many digits as tell the ends apart.
    let width = (hi - lo) / unit;
    let digits = if width > 0.0 { libm::ceil(-libm::log10(width)).clamp(0.0, 9.0) as usize + 1 } else { 4 };
    let step = libm::pow(10.0, digits as f64);
    let [lo, hi] = [libm::floor(lo / unit * step) / step, libm::ceil(hi / unit * step) / step];
    if lo <= 0.0 {
        format!("< {hi:.digits$}{suffix}")
    } else {
        format!("{lo:.digits$}..{hi:.digits$}{suffix}")
    }
}

impl Undecided {
    fn new(analysis: &Analysis) -> Undecided {
        let elsewhere = !analysis.is_whole;
        if analysis.proven().is_some() {
            return Undecided { elsewhere, ..Undecided::default() };
        }
        let flood = &analysis.flood;
        let mut undecided = Undecided {
            elsewhere,
            places_total: flood.undecided.len(),
            doubtful: flood.doubtful,
            ran_short: flood.ran_short && !flood.undecided.is_empty(),
            places: flood.undecided.iter().take(PLACES).copied().collect(),
            cut: analysis.parts.iter().filter(|part| part.cut).count(),
            ..Undecided::default()
        };
        // What is not known of critical points matters only where the flood does not know either.
        match &analysis.complex {
            Some(complex) if flood.is_certified() => {
                undecided.critical_places = complex.open.iter().take(PLACES).copied().collect();
                undecided.critical_places_total = complex.open.len();
            }
            Some(complex) => {
                undecided.level = complex.level.len();
                undecided.lost = complex.lost;
                undecided.beyond = complex.beyond;
            }
            None => {}
        }
        undecided
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_are_printed_as_far_as_they_are_known() {
        for (volume, text) in [
            ([4.7003, 4.7304], "4.700..4.731"),
            ([0.0, 0.0123], "< 0.013"),
            ([0.0, f64::INFINITY], "?"),
            ([3.912, 4.508], "3.91..4.51"),
            ([8.0, 8.0], "8.0000..8.0000"),
            ([4.113e36, 4.287e36], "4.11..4.29e36"),
            ([1.23e-9, 2.34e-9], "1.2..2.4e-9"),
        ] {
            assert_eq!(enclosed(volume), text);
        }
        assert_eq!(
            [0.0, -1.25, -1e-7, -1e12].map(significant),
            ["0.0000", "-1.2500", "-1.000e-7", "-1.000e12"]
        );
    }
}
