//! How the expressions of children differ from those of their parents: in one number, one operation, or one subtree.

use super::breed::Breeding;
use crate::script::genes::{Form, Gene, Genes, Kin};
use serde::Serialize;

/// How often a child has something of its other parent, if their expressions differ.
const CROSSING: f64 = 0.5;

/// A text may become so many times as long as that of the script: what grows for ever is slow, and nobody reads it.
const LONGEST: usize = 2;

/// Where chances of expressions are among those of a child; parameters have small numbers.
const EXPRESSIONS: u64 = 1 << 32;

/// Characters of a subtree that a caption says.
const SHORT: usize = 24;

/// Characters of a line that is shown.
const LONG: usize = 400;

/// What was changed of an expression.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Change {
    /// Where, before it was.
    pub line: usize,
    /// In a few words: `min → max`.
    pub what: String,
    /// The line.
    pub before: String,
    /// What became of it.
    pub after: String,
}

/// What a child is made of: the genes of the parent that it takes after, and those of the other one.
#[derive(Clone, Copy)]
pub struct Pair<'a> {
    pub own: &'a Genes,
    pub other: &'a Genes,
    pub kin: &'a Kin,
    /// Length of the script.
    pub length: usize,
}

impl Breeding {
    /// Which of two parents the expressions of a child come from.
    pub fn takes_after(&self, child: u64) -> usize {
        usize::from(self.chance(child, EXPRESSIONS, 0) < 0.5)
    }

    /// What an attempt makes of the expressions of a child; `None` where it comes to nothing.
    pub fn mutate(&self, pair: &Pair<'_>, child: u64, attempt: u64) -> Option<(String, Change)> {
        let chance = |what: u64| self.chance(child, EXPRESSIONS + 1 + attempt, what);
        let differ = pair.own.text != pair.other.text;
        let crosses = differ && (self.reach == 0.0 || chance(0) < CROSSING);
        let (site, piece) = if crosses {
            exchanged(pair, &chance)?
        } else if self.reach == 0.0 {
            return None;
        } else {
            match (3.0 * chance(1)) as u64 {
                0 => moved(pair.own, self.reach, &chance)?,
                1 => renamed(pair, &chance)?,
                _ => exchanged(&Pair { other: pair.own, ..*pair }, &chance)?,
            }
        };
        let text = pair.own.with(site, &piece);
        let fits = text.len() <= (LONGEST * pair.length).max(pair.own.text.len());
        fits.then(|| (text, change(pair.own, site, &piece)))
    }
}

/// Numbers in `[0, 1)`, by purpose.
type Chance<'a> = &'a dyn Fn(u64) -> f64;

/// One of them.
fn one<T>(of: Vec<T>, chance: f64) -> Option<T> {
    let number = (chance * of.len() as f64) as usize;
    of.into_iter().nth(number)
}

/// A number that is a little larger or smaller.
fn moved<'a>(genes: &'a Genes, reach: f64, chance: Chance<'_>) -> Option<(&'a Gene, String)> {
    let is_number = |gene: &&Gene| gene.form == Form::Number;
    let site = one(genes.all.iter().filter(is_number).collect(), chance(2))?;
    // The sum of two is more often small than large; where it is 0, nothing would have changed.
    let step = reach * (chance(3) + chance(4) - 1.0);
    Some((site, near(genes.words(site), step)?))
}

/// A number times `1 + step`, as it is written: whole ones stay whole, and none becomes 0 or gets another sign.
fn near(text: &str, step: f64) -> Option<String> {
    let plain = text.replace('_', "");
    if let Ok(whole) = plain.parse::<u64>() {
        let next = (whole as f64 * (1.0 + step)).round() as u64;
        let next = if next != whole {
            next
        } else if step > 0.0 {
            whole.checked_add(1)?
        } else {
            whole.checked_sub(1)?
        };
        return (whole > 0 && next > 0).then(|| next.to_string());
    }
    let value = plain.parse::<f64>().ok().filter(|v| *v > 0.0)?;
    let next: f64 = format!("{:.2e}", value * (1.0 + step)).parse().ok()?;
    (next > 0.0 && next.is_finite() && next != value).then(|| format!("{next:?}"))
}

/// Another operation with the same arguments.
fn renamed<'a>(pair: &Pair<'a>, chance: Chance<'_>) -> Option<(&'a Gene, String)> {
    let kin = |gene: &Gene| match &gene.form {
        Form::Name { full, arity } => pair.kin.of(full, *arity).to_vec(),
        Form::Sign if pair.own.words(gene) == "+" => vec!["-".to_owned()],
        Form::Sign => vec!["+".to_owned()],
        _ => Vec::new(),
    };
    let all = pair.own.all.iter().map(|gene| (gene, kin(gene))).filter(|(_, kin)| !kin.is_empty());
    let (site, names) = one(all.collect(), chance(2))?;
    Some((site, one(names, chance(3))?))
}

/// Another subtree of the same sort; what the other parent has alone comes first.
fn exchanged<'a>(pair: &Pair<'a>, chance: Chance<'_>) -> Option<(&'a Gene, String)> {
    let Pair { own, other, .. } = pair;
    let site = one(own.all.iter().filter(|gene| gene.sort.is_some()).collect(), chance(2))?;
    let fits = |gene: &&Gene| gene.sort == site.sort && other.words(gene) != own.words(site);
    let donors: Vec<&Gene> = other.all.iter().filter(fits).collect();
    let is_new = |gene: &&&Gene| !own.text.contains(other.words(gene));
    let new: Vec<&Gene> = donors.iter().filter(is_new).copied().collect();
    let donor = one(if new.is_empty() { donors } else { new }, chance(3))?;
    Some((site, own.graft(site, other, donor)?))
}

/// What is said of a change.
fn change(genes: &Genes, site: &Gene, piece: &str) -> Change {
    let (text, range) = (&genes.text, &site.range);
    let start = text[..range.start].rfind('\n').map_or(0, |at| at + 1);
    let end = text[range.end..].find('\n').map_or(text.len(), |at| range.end + at);
    let (head, tail) = (&text[start..range.start], &text[range.end..end]);
    Change {
        line: 1 + text[..start].matches('\n').count(),
        what: format!("{} → {}", brief(genes.words(site), SHORT), brief(piece, SHORT)),
        before: brief(&text[start..end], LONG),
        after: brief(&format!("{head}{piece}{tail}"), LONG),
    }
}

/// A text in one line, cut short.
fn brief(text: &str, most: usize) -> String {
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match words.char_indices().nth(most) {
        Some((at, _)) => format!("{}…", words[..at].trim_end()),
        None => words,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_what_they_are() {
        for (text, step, next) in [
            ("4.0", 0.1, Some("4.4")),
            ("1_000.0", -0.5, Some("500.0")),
            ("1e-5", 0.5, Some("1.5e-5")),
            ("8", 0.3, Some("10")),
            ("2", 0.01, Some("3")),
            ("2", -0.01, Some("1")),
            ("1", -0.01, None),
            ("0", 0.5, None),
            ("0.0", 0.5, None),
            ("1.0", 1e-9, None),
            ("0xff", 0.5, None),
        ] {
            assert_eq!(near(text, step).as_deref(), next, "{text} {step}");
        }
    }

    #[test]
    fn changes_are_told_by_their_lines() {
        let genes = Genes::of("let a = 1;\nmin(x,\n    y) + a");
        let of = |words: &str| genes.all.iter().find(|g| genes.words(g) == words).unwrap();
        let told = change(&genes, of("min"), "max");
        assert_eq!((told.line, told.what.as_str()), (2, "min → max"));
        assert_eq!((told.before.as_str(), told.after.as_str()), ("min(x,", "max(x,"));
        let told = change(&genes, of("min(x,\n    y)"), "z");
        assert_eq!((told.before.as_str(), told.after.as_str()), ("min(x, y) + a", "z + a"));
        assert_eq!(brief("a  bc", 3), "a b…");
    }
}
