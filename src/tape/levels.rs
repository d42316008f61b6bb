//! Which values matter where only the side of a surface does.
//!
//! Who casts rays at a solid wants to know on which side of zero its field is, and what it is close to zero. So of each
//! instruction only some values matter, its *levels*: those of the field are zero alone. Beyond them it is enough to be
//! beyond them, on the same side. With `[l, h]` the levels of
//!
//! ```text
//! min(a, b)    where b > h it is a, or both are above h: b goes
//! max(a, b)    where b < l likewise
//! ```
//!
//! so in a part of space all operands of a union go whose surfaces are elsewhere, also those that are nearer than the one
//! that stays; a minimum that keeps its values has them all. Levels of arguments are such that where one is beyond its
//! own, the outcome is beyond those of the instruction, or does not depend on it:
//!
//! | instruction | levels of `a` |
//! |---|---|
//! | `min(a, b)` | `[l, min(h, max b)]`, likewise for `max(a, b)` |
//! | a [`Melt`](crate::op::Melt) that reaches `r` | `[l, min(h, max b) + r]`; where `b > h` no more than `2 h + r - b` |
//! | `corner(a, b)` | `[min(l, 0), max(h, 0)]`: below zero the larger counts alone |
//! | `-a`, `a + c`, `k a` | those of the inverse |
//! | `abs(a)` | `[-h, h]` |
//! | `a + b`, `a - b` | what `a` has to be for the outcome to be one, whichever of its values `b` has |
//! | anything else | all numbers |
//!
//! What is above its levels, and is replaced, never gets below what encloses it, nor above that if it was below; so where both
//! arguments change, one is no worse than the least that it may have been.
//!
//! What several instructions read has levels around those of each. (What melts is concave, and is `h` where its arguments
//! are `h` and `h + r`; so it is at least `h` where both are, and have a sum of at least `2 h + r`.)

use super::prune::{Facts, Fate};
use super::{Instr, Tape};
use crate::num::{Interval, ROUNDOFF};
use crate::op::Op;

/// What is wanted of pruned code.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Wanted {
    /// All values, bit for bit but for the sign of a zero.
    Values,
    /// On which side of zero they are, and those at zero and next to it.
    Sides,
}

/// What becomes of instructions, given the levels of those that read them; see the module text. Asked from the last
/// instruction to the first, and of all that stay.
pub(super) struct Levels<'a> {
    facts: Facts<'a>,
    code: &'a [Instr],
    levels: Vec<Interval>,
}

/// Those of what nobody reads.
const NONE: Interval = Interval { lo: f64::INFINITY, hi: f64::NEG_INFINITY };

impl<'a> Levels<'a> {
    pub(super) fn new(tape: &'a Tape, facts: Facts<'a>, wanted: Wanted) -> Levels<'a> {
        let mut levels = vec![NONE; tape.code.len()];
        let of_outputs = if wanted == Wanted::Sides { Interval::point(0.0) } else { Interval::ENTIRE };
        tape.outputs.iter().for_each(|o| levels[*o as usize] = of_outputs);
        Levels { facts, code: &tape.code, levels }
    }

    pub(super) fn fate(&mut self, slot: usize) -> Fate {
        let own = self.levels[slot];
        let fate = match self.facts.fate(slot) {
            Fate::Stays => self.beyond(slot, own),
            fate => fate,
        };
        match &fate {
            Fate::Is(a) => widen(&mut self.levels, *a, own),
            Fate::Stays => self.pass_on(slot, own),
            Fate::Rests(_) => self.code[slot].each_arg(|a| widen(&mut self.levels, a, Interval::ENTIRE)),
            Fate::Goes | Fate::Number(_) => {}
        }
        fate
    }

    /// What becomes of an instruction that has values beyond its levels.
    fn beyond(&self, slot: usize, own: Interval) -> Fate {
        if !self.facts.is_whole(slot as u32) {
            return Fate::Stays;
        }
        let all = self.facts.range(slot as u32);
        if all.lo > own.hi {
            return Fate::Number(all.lo);
        }
        if all.hi < own.lo {
            return Fate::Number(all.hi);
        }
        let Instr::Op(op, [a, b, ..]) = &self.code[slot] else { return Fate::Stays };
        let range = |x: &u32| self.facts.range(*x);
        let is_out = |x: &u32| match op {
            Op::Min(_) => range(x).lo > own.hi,
            Op::Melt(melt) => range(x).lo > (own + Interval::point(melt.reach())).hi,
            Op::Max(_) => range(x).hi < own.lo,
            Op::Corner(_) => range(x).hi < own.lo.min(0.0),
            _ => false,
        };
        if is_out(b) {
            Fate::Is(*a)
        } else if is_out(a) {
            Fate::Is(*b)
        } else {
            Fate::Stays
        }
    }

    /// The levels of the arguments of an instruction that stays.
    fn pass_on(&mut self, slot: usize, own: Interval) {
        let Levels { facts, code, levels } = self;
        let instr = &code[slot];
        let range = |x: &u32| facts.range(*x);
        match instr {
            Instr::Scale(a, k) if *k != 0.0 => widen(levels, *a, own / Interval::point(*k)),
            Instr::Shift(a, c) => widen(levels, *a, own - Interval::point(*c)),
            Instr::Op(Op::Add(_), [a, b, ..]) => {
                widen(levels, *a, own - range(b));
                widen(levels, *b, own - range(a));
            }
            Instr::Op(Op::Sub(_), [a, b, ..]) => {
                widen(levels, *a, own + range(b));
                widen(levels, *b, range(a) - own);
            }
            Instr::Op(Op::Neg(_), [a, ..]) => widen(levels, *a, -own),
            Instr::Op(Op::Abs(_), [a, ..]) => widen(levels, *a, Interval { lo: -own.hi, hi: own.hi }),
            Instr::Op(op @ (Op::Min(_) | Op::Max(_) | Op::Melt(_) | Op::Corner(_)), [a, b, ..]) => {
                for [one, other] in [[a, b], [b, a]] {
                    widen(levels, *one, of_side(op, own, range(other)));
                }
            }
            _ => instr.each_arg(|a| widen(levels, a, Interval::ENTIRE)),
        }
    }
}

/// The levels of one side of a minimum and the like, given what encloses the other.
fn of_side(op: &Op, own: Interval, other: Interval) -> Interval {
    match op {
        Op::Min(_) => Interval { hi: highest(own.hi, other, 0.0), ..own },
        Op::Melt(melt) => Interval { hi: highest(own.hi, other, melt.reach()), ..own },
        Op::Max(_) => Interval { lo: -highest(-own.lo, -other, 0.0), ..own },
        // Its square and root are rounded.
        Op::Corner(_) => Interval { lo: own.lo.min(0.0), hi: own.hi.max(0.0) * (1.0 + 8.0 * ROUNDOFF) },
        _ => Interval::ENTIRE,
    }
}

/// The highest level of one side of what melts over a `reach`, if it has none above `most` itself.
fn highest(most: f64, other: Interval, reach: f64) -> f64 {
    let [top, reach] = [most, reach].map(Interval::point);
    if other.lo > most {
        (top + top - Interval::point(other.lo) + reach).hi.max(most)
    } else {
        (Interval::point(most.min(other.hi)) + reach).hi
    }
}

/// Adds levels to those of an instruction; all numbers where they are none.
fn widen(levels: &mut [Interval], slot: u32, by: Interval) {
    let own = &mut levels[slot as usize];
    *own = if by.lo <= by.hi { own.hull(by) } else { Interval::ENTIRE };
}

#[cfg(test)]
mod tests {
    use super::Wanted;
    use crate::num::{Dual, Interval};
    use crate::script::{Request, compile};
    use crate::tape::{Cells, Evaluator, Tape};
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use std::sync::Arc;

    fn tape(text: &str) -> Arc<Tape> {
        let compiled = compile(&Request::text(text));
        let scene = compiled.scene.unwrap_or_else(|| panic!("{text}: {:?}", compiled.diagnostics));
        Arc::new(Tape::new(&scene.graph, &[scene.surface.field]))
    }

    /// A solid of everything that has levels of its own, and of some that has not.
    fn solid(rng: &mut StdRng, depth: u32) -> String {
        let size = rng.random_range(0.1..0.5);
        if depth == 0 {
            let [x, y, z] = [0; 3].map(|_| rng.random_range(-1.0..1.0));
            let at = format!(".translated([{x:.3}, {y:.3}, {z:.3}])");
            return match rng.random_range(0..5) {
                0 => format!("sphere({size:.3}){at}"),
                // Without values beyond x = -0.9.
                1 => format!("(y + 0.5 - sqrt(x + 0.9)){at}"),
                2 => format!("box([{size:.3}, 0.3, 0.2]){at}"),
                3 => format!("(y + 0.1 * gradient({})){at}", rng.random_range(0..9)),
                _ => format!("cylinder({size:.3}, 0.6){at}"),
            };
        }
        let [a, b] = [0; 2].map(|_| solid(rng, depth - 1));
        match rng.random_range(0..16) {
            0..5 => format!("min({a}, {b})"),
            5..7 => format!("max({a}, {b})"),
            7 => format!("max({a}, -({b}))"),
            8 => format!("smooth_union({a}, {b}, {size:.3})"),
            9 => {
                let ramp = ["quadratic", "cubic", "exponential"][rng.random_range(0..3)];
                format!("melt({a}, {b}, \"{ramp}\", {:.4})", 0.1 * size)
            }
            10 => format!("corner({a}, {b})"),
            11 => format!("abs({a}) - 0.05"),
            12 => format!("0.7 * ({a}) - 0.1"),
            13 => format!("({a}) + 0.2 * ({b})"),
            14 => format!("({a}) - 0.3 * ({b})"),
            _ => format!("-0.5 * min({a}, {b})"),
        }
    }

    /// In cells of sides points are on the sides that they are on by the whole tape, and where that is next to zero the bits
    /// are the same; and there is less in them than in those of values.
    #[test]
    fn sides_and_what_is_next_to_zero_are_kept() {
        let mut rng = StdRng::seed_from_u64(17);
        let (mut of_values, mut of_sides, mut near, mut inside) = (0, 0, 0, 0);
        for _ in 0..60 {
            let text = solid(&mut rng, 5);
            let tape = tape(&text);
            let region = [Interval::radius(1.5); 3];
            let [values, sides] = [Cells::new(tape.clone(), &region), Cells::of_sides(tape.clone(), &region)];
            let (mut whole, mut part) =
                (Evaluator::<f64>::new(tape.clone()), Evaluator::<f64>::new(tape.clone()));
            let (mut slope, mut slope_of_part) =
                (Evaluator::<Dual>::new(tape.clone()), Evaluator::<Dual>::new(tape));
            for _ in 0..1000 {
                let at: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.5..1.5));
                let reach = 0.3 * libm::exp2(-rng.random_range(0.0..6.0));
                of_values += values.tape_around(at, reach).len();
                of_sides += sides.tape_around(at, reach).len();
                let part_tape = sides.tape_around(at, reach);
                part.turn_to(part_tape);
                let [mut low, mut high] = [0; 2].map(|_| at.map(|c| c + reach * rng.random_range(-1.0..1.0)));
                for p in [low, high] {
                    let [whole, part] = [*whole.eval(&p), *part.eval(&p)];
                    let same = whole == part || whole * part > 0.0 || whole.is_nan();
                    assert!(same, "{whole} {part} at {p:?}: {text}");
                    inside += u32::from(whole < 0.0);
                }
                if *whole.eval(&low) > 0.0 {
                    (low, high) = (high, low);
                }
                if !(*whole.eval(&low) < 0.0 && *whole.eval(&high) > 0.0) {
                    continue;
                }
                for _ in 0..60 {
                    let middle = std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis]));
                    *if *whole.eval(&middle) < 0.0 { &mut low } else { &mut high } = middle;
                }
                for p in [low, high] {
                    near += 1;
                    let [whole, part] = [*whole.eval(&p), *part.eval(&p)];
                    let same = whole == part || whole.is_nan();
                    assert!(same, "{whole} {part} at {p:?}: {text}");
                    let p = std::array::from_fn(|axis| Dual::coordinate(p[axis], axis));
                    let [whole, part] = [*slope.eval(&p), *slope_of_part.turn_to(part_tape).eval(&p)];
                    // Of an exponential ramp 1e-18 is left where it has ended.
                    let differs = |axis: usize| (whole.grad[axis] - part.grad[axis]).abs() > 1e-15;
                    let same = whole.value.abs() > 1e-9 || !(0..3).any(differs);
                    assert!(same, "{whole:?} {part:?} at {p:?}: {text}");
                }
            }
        }
        assert!(near > 1000 && inside > 20_000, "{near} roots, {inside} inside");
        assert!(of_sides * 3 < of_values * 2, "{of_sides} and {of_values} instructions");
    }

    /// What is nearest but on the other side of a cell does not matter to the one in it.
    #[test]
    fn only_what_has_its_surface_in_a_cell_is_left() {
        let tape = tape("min(min(sphere(1.0), y + 1.2), smooth_union(x + 1.5, z + 1.5, 0.1))");
        let region = [Interval::new(0.8, 1.2), Interval::radius(0.2), Interval::radius(0.2)];
        let left = |wanted| tape.bound(&region).pruned(wanted);
        let ball = super::tests::tape("sphere(1.0)").len();
        assert_eq!(left(Wanted::Sides).len(), ball);
        let region = [Interval::new(0.2, 1.4), Interval::new(-1.1, 0.2), Interval::radius(0.2)];
        assert!(tape.bound(&region).pruned(Wanted::Values).len() > ball);
        assert_eq!(tape.bound(&region).pruned(Wanted::Sides).len(), ball);
    }
}
