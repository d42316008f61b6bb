//! Where a field has no value.
//!
//! Enclosures speak of the values that there are. Where a root of what is negative is added to a field, there are none, and
//! an enclosure of all numbers excludes nothing. But whatever is computed from what is not a number is none either, so that one
//! instruction that has no value in a region takes it from the output, and where a field has no value there is nothing of the
//! solid. (Not so a power: that of 0 is 1, whatever it is of.)

use super::prune::Bounded;
use super::{Instr, Tape};
use crate::num::Interval;
use crate::op::Op;
use std::sync::Arc;

impl Tape {
    /// Whether it is known that the first output has no value anywhere in a region.
    pub fn is_nowhere(self: &Arc<Tape>, region: &[Interval; 3]) -> bool {
        self.is_partial() && self.bound(region).is_nowhere()
    }

    /// Whether there is an operation that may have no value in a whole region.
    pub fn is_partial(&self) -> bool {
        self.code.iter().any(|instr| {
            let Instr::Op(op, _) = instr else { return false };
            [-10.0, 10.0].iter().any(|beyond| op.is_undefined(|_| Interval::point(*beyond)))
        })
    }
}

impl Bounded {
    /// Whether it is known that the first output has no value anywhere in the region.
    pub fn is_nowhere(&self) -> bool {
        let (tape, ranges) = (self.tape(), self.ranges());
        let mut is_read = vec![false; tape.code.len()];
        is_read[tape.outputs[0] as usize] = true;
        for (slot, instr) in tape.code.iter().enumerate().rev().filter(|(_, instr)| passes_on(instr)) {
            if !is_read[slot] {
                continue;
            }
            if let Instr::Op(op, args) = instr
                && op.is_undefined(|k| *ranges.value(args[k]))
            {
                return true;
            }
            instr.each_arg(|a| is_read[a as usize] = true);
        }
        false
    }
}

/// Whether what is computed from something that is not a number is none.
fn passes_on(instr: &Instr) -> bool {
    match instr {
        Instr::Scale(..) | Instr::Shift(..) => true,
        Instr::Op(op, _) => matches!(
            op,
            Op::Add(_)
                | Op::Sub(_)
                | Op::Mul(_)
                | Op::Div(_)
                | Op::Neg(_)
                | Op::Abs(_)
                | Op::Square(_)
                | Op::Sqrt(_)
                | Op::Exp(_)
                | Op::Ln(_)
                | Op::Sin(_)
                | Op::Cos(_)
                | Op::Asin(_)
                | Op::Acos(_)
                | Op::Min(_)
                | Op::Max(_)
                | Op::Length(_)
        ),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Field;
    use crate::script::{Request, compile};
    use glam::DVec3;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    fn tape(text: &str) -> Arc<Tape> {
        let scene = compile(&Request::text(text)).scene.expect("a scene");
        Arc::new(Tape::new(&scene.graph, &[scene.surface.field]))
    }

    /// Where a tape is said to have no value it has none at any point, and there are such places.
    #[test]
    fn what_is_nowhere_has_no_value() {
        let mut rng = StdRng::seed_from_u64(11);
        for text in [
            "y - sqrt(1.0 - x*x - z*z)",
            "asin(length(p)) - 1.0",
            "min(sphere(1.0), max(ln(x + y), 0.3 - z))",
            "length(vec3(x, sqrt(y), z)) - 1.0",
            "abs(sqrt(x) - y ** 0.5) / exp(acos(z)) - 0.2",
            "sin(sqrt(x)) * cos(z) - sqrt(-y) * 2.0 + 0.1",
        ] {
            let tape = tape(text);
            let mut field = Field::of_tape(&tape);
            let mut found = 0;
            for _ in 0..400 {
                let middle = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-2.0..2.0)));
                let half = rng.random_range(0.01..1.0);
                if tape.is_nowhere(&middle.to_array().map(|c| Interval::around(c, half))) {
                    found += 1;
                    for _ in 0..20 {
                        let off = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-half..half)));
                        assert!(field.value(middle + off).is_nan(), "{text} at {}", middle + off);
                    }
                }
            }
            assert!(found > 20, "{text}: {found}");
        }
        assert!(!tape("sphere(1.0) + gradient(7)").is_partial());
    }

    /// Every operation that is said to pass on what is not a number does so, whichever of its arguments that is.
    #[test]
    fn what_is_not_a_number_is_passed_on() {
        for op in Op::ALL.iter().copied() {
            if passes_on(&Instr::Op(op, [0; 6])) {
                for bad in 0..op.arity() {
                    for other in [-0.5, 0.0, 0.5, 3.0] {
                        let value = op.value(|k| if k == bad { f64::NAN } else { other });
                        assert!(value.is_nan(), "{} of {other}, argument {bad}: {value}", op.name());
                    }
                }
            }
        }
    }
}
