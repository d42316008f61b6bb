//! The table of what a picture cost: `orogen render --stats`.
//!
//! To report something else of the rays, add a line to [`ROWS`].

use super::report::{Terminal, count, out, plural, seconds};
use crate::cast::CastStats;
use crate::render::Stats;
use crate::tape::Prunings;

/// What is known of one kind of rays.
struct Column {
    name: &'static str,
    cast: CastStats,
    octaves: u64,
    seconds: f64,
}

/// A name, and what it says of a kind of rays; nothing where there is nothing to say.
type Row = (&'static str, fn(&Column) -> Option<String>);

/// The rows. Those of which no column says anything are left out.
const ROWS: &[Row] = &[
    ("rays", |c| number(c.cast.rays)),
    ("  hits", |c| number(c.cast.hits)),
    ("field evaluations", |c| number(c.cast.evaluations)),
    ("  per ray", |c| ratio(c.cast.evaluations, c.cast.rays)),
    ("  shared by beams", |c| number(c.cast.shared)),
    ("octaves of noise", |c| number(c.octaves)),
    ("  per ray", |c| ratio(c.octaves, c.cast.rays)),
    ("  per evaluation", |c| ratio(c.octaves, c.cast.evaluations)),
    ("beams culled", |c| number(c.cast.culled)),
    ("steps taken back", |c| number(c.cast.backtracks)),
    ("places judged", |c| number(c.cast.judged)),
    ("  rejected", |c| number(c.cast.rejected)),
    ("certified, %", |c| certified(c.cast.uncertified, c.cast.rays)),
    ("  given up", |c| number(c.cast.given_up)),
    ("  met jumps or no value", |c| number(c.cast.uncertified - c.cast.given_up)),
    ("rays/s, each thread", |c| (c.seconds > 0.0).then(|| rounded(c.cast.rays as f64 / c.seconds))),
];

/// Prints the table.
pub fn print(stats: &Stats, terminal: &Terminal) {
    for (i, line) in rays(stats).into_iter().chain([String::new()]).chain(times(stats)).enumerate() {
        out(if i == 0 { terminal.bold(line) } else { line });
    }
}

/// What the rays cost.
fn rays(stats: &Stats) -> Vec<String> {
    let Stats { primary, shadow, bounced, octaves, seconds, .. } = stats;
    let mut columns = vec![
        Column { name: "to the eye", cast: *primary, octaves: octaves.primary, seconds: seconds.primary },
        Column { name: "to lights", cast: *shadow, octaves: octaves.shadow, seconds: seconds.shadow },
    ];
    if bounced.rays > 0 {
        let (octaves, seconds) = (octaves.bounced, seconds.bounced);
        columns.push(Column { name: "onwards", cast: *bounced, octaves, seconds });
    }
    columns.push(all(&columns));
    let mut lines = vec![line("", columns.iter().map(|c| c.name.to_owned()))];
    for (name, cell) in ROWS {
        let cells: Vec<_> = columns.iter().map(cell).collect();
        if cells.iter().any(Option::is_some) {
            lines.push(line(name, cells.into_iter().map(|c| c.unwrap_or_else(|| "-".to_owned()))));
        }
    }
    lines
}

/// What kinds of rays come to together.
fn all(columns: &[Column]) -> Column {
    let mut all = Column { name: "all", cast: CastStats::default(), octaves: 0, seconds: 0.0 };
    for column in columns {
        all.cast += column.cast;
        all.octaves += column.octaves;
        all.seconds += column.seconds;
    }
    all
}

/// Where the time went.
fn times(stats: &Stats) -> Vec<String> {
    let s = &stats.seconds;
    let all = s.primary + s.surface + s.shadow + s.bounced + s.shading;
    let stages = [
        ("rays to the eye", s.primary, stats.octaves.primary),
        ("normals, colours", s.surface, stats.octaves.surface),
        ("rays to lights", s.shadow, stats.octaves.shadow),
        ("rays onwards", s.bounced, stats.octaves.bounced),
        ("light, air", s.shading, 0),
    ];
    let mut lines = vec![line("time, threads added up", ["time", "%", "octaves"].map(str::to_owned))];
    for (name, time, octaves) in stages.into_iter().filter(|stage| stage.1 > 0.0) {
        let share = if all > 0.0 { format!("{:.0}", 100.0 * time / all) } else { "-".to_owned() };
        lines.push(line(name, [seconds(time), share, number(octaves).unwrap_or_else(|| "-".to_owned())]));
    }
    let Prunings { tapes, instructions, whole } = stats.prunings;
    if instructions < tapes * whole {
        let mean = instructions as f64 / tapes as f64;
        lines.push(format!("{} of {mean:.0} instead of {whole} instructions", plural(tapes, "pruned tape")));
    }
    if stats.tiles > 0 {
        let (tiles, asked) =
            (plural(stats.tiles, "rough tile"), plural(stats.rough.evaluations, "evaluation"));
        lines.push(format!("{tiles} of {asked}"));
    }
    let rays = stats.primary.rays + stats.shadow.rays + stats.bounced.rays;
    let speed = if s.wall > 0.0 { rounded(rays as f64 / s.wall) } else { "0".to_owned() };
    lines.push(format!("{} on {}: {speed} rays/s", seconds(s.wall), plural(stats.threads, "thread")));
    lines
}

fn line(name: &str, cells: impl IntoIterator<Item = String>) -> String {
    // Room for nearly any count, and a space before it; together no wider than a terminal.
    let cells = cells.into_iter().map(|cell| format!(" {cell:>13}"));
    format!("{name:<24}{}", cells.collect::<String>())
}

/// A count, if there is anything to count.
fn number(n: u64) -> Option<String> {
    (n > 0).then(|| count(n))
}

fn ratio(n: u64, of: u64) -> Option<String> {
    (n > 0 && of > 0).then(|| format!("{:.2}", n as f64 / of as f64))
}

fn rounded(x: f64) -> String {
    count(x.round() as u64)
}

/// The certified share in percent, which is 100 only if it is.
fn certified(uncertified: u64, rays: u64) -> Option<String> {
    let share = |n: u64| (1e6 * (1.0 - n as f64 / rays as f64)).min(999_999.0).floor() * 1e-4;
    (rays > 0).then(|| if uncertified == 0 { "100".to_owned() } else { format!("{:.4}", share(uncertified)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_say_what_was_counted_and_no_more() {
        let primary = CastStats { rays: 4, hits: 1, evaluations: 10, ..CastStats::default() };
        let said = rays(&Stats { primary, ..Stats::default() }).join("\n");
        let row =
            |name: &str| said.lines().find(|l| l.starts_with(name)).map(|l| l.split_whitespace().collect());
        assert_eq!(row("rays"), Some(vec!["rays", "4", "-", "4"]), "{said}");
        assert_eq!(row("  per ray"), Some(vec!["per", "ray", "2.50", "-", "2.50"]), "{said}");
        assert_eq!(row("certified"), Some(vec!["certified,", "%", "100", "-", "100"]), "{said}");
        assert!(!said.contains("beams") && !said.contains("given up"), "{said}");
    }

    #[test]
    fn what_is_not_certain_has_a_reason() {
        let shadow = CastStats { rays: 1 << 40, uncertified: 3, given_up: 2, ..CastStats::default() };
        let said = rays(&Stats { shadow, ..Stats::default() }).join("\n");
        let row = |name: &str| {
            said.lines().find_map(|l| l.strip_prefix(name).map(|l| l.split_whitespace().collect()))
        };
        assert_eq!(row("certified, %"), Some(vec!["-", "99.9999", "99.9999"]), "{said}");
        assert_eq!(row("  given up"), Some(vec!["-", "2", "2"]), "{said}");
        assert_eq!(row("  met jumps or no value"), Some(vec!["-", "1", "1"]), "{said}");
        assert_eq!(certified(1, 3).unwrap(), "66.6666");
    }
}
