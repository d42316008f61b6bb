//! Instructions as bytes, and what becomes of NaN and of too many values.

use super::encode::{Assembler, Place, Source, Width};
use super::trace::Do;
use super::*;
use crate::num::{Class, Many, widest};

/// The bytes that some instructions become.
fn bytes(width: Width, write: impl Fn(&mut Assembler)) -> Vec<u8> {
    let mut asm = Assembler::new(width);
    write(&mut asm);
    asm.code
}

/// As the GNU assembler writes them with `{vex3}`.
#[test]
fn narrow_instructions_are_as_the_manual_has_them() {
    use Source::{Memory, Register};
    let act = |act, to, x, y| bytes(Width::Ymm, |asm| asm.act(act, to, x, y));
    assert_eq!(act(Do::Add, 1, 2, Register(3)), [0xc4, 0xe1, 0x6d, 0x58, 0xcb]);
    assert_eq!(act(Do::Mul, 0, 15, Register(8)), [0xc4, 0xc1, 0x05, 0x59, 0xc0]);
    assert_eq!(act(Do::Sub, 15, 0, Memory(Place::Coordinate(0))), [0xc4, 0x61, 0x7d, 0x5c, 0x3e]);
    assert_eq!(act(Do::Min, 3, 4, Memory(Place::Coordinate(1))), [0xc4, 0xc1, 0x5d, 0x5d, 0x1a]);
    assert_eq!(act(Do::And, 3, 4, Register(5)), [0xc4, 0xe1, 0x5d, 0x54, 0xdd]);
    assert_eq!(act(Do::AndNot, 3, 4, Register(5)), [0xc4, 0xe1, 0x5d, 0x55, 0xdd]);
    assert_eq!(act(Do::Or, 3, 4, Register(5)), [0xc4, 0xe1, 0x5d, 0x56, 0xdd]);
    assert_eq!(act(Do::Xor, 3, 4, Register(5)), [0xc4, 0xe1, 0x5d, 0x57, 0xdd]);
    assert_eq!(act(Do::Sqrt, 7, 0, Memory(Place::Aside(3))), [0xc4, 0xc1, 0x7d, 0x51, 0x78, 0x60]);
    assert_eq!(act(Do::Floor, 2, 0, Register(13)), [0xc4, 0xc3, 0x7d, 0x09, 0xd5, 9]);
    assert_eq!(act(Do::Less, 8, 1, Register(12)), [0xc4, 0x41, 0x75, 0xc2, 0xc4, 1]);
    let load = |to, from| bytes(Width::Ymm, |asm| asm.load(to, from));
    assert_eq!(load(5, Place::Number(129)), [0xc4, 0xe2, 0x7d, 0x19, 0xa9, 8, 4, 0, 0]);
    assert_eq!(load(6, Place::Home(4)), [0xc4, 0xe1, 0x7d, 0x10, 0x34, 0x97]);
    let store = bytes(Width::Ymm, |asm| asm.store(Place::Home(300), 14));
    assert_eq!(store, [0x48, 0x69, 0xc2, 0x2c, 1, 0, 0, 0xc4, 0x61, 0x7d, 0x11, 0x34, 0x07]);
}

/// As the GNU assembler writes them.
#[test]
fn wide_instructions_are_as_the_manual_has_them() {
    use Source::{Memory, Register};
    let act = |act, to, x, y| bytes(Width::Zmm, |asm| asm.act(act, to, x, y));
    assert_eq!(act(Do::Add, 1, 2, Register(3)), [0x62, 0xf1, 0xed, 0x48, 0x58, 0xcb]);
    assert_eq!(act(Do::Mul, 17, 26, Register(31)), [0x62, 0x81, 0xad, 0x40, 0x59, 0xcf]);
    assert_eq!(act(Do::AndNot, 30, 9, Register(20)), [0x62, 0x21, 0xb5, 0x48, 0x55, 0xf4]);
    assert_eq!(act(Do::Sub, 15, 0, Memory(Place::Coordinate(0))), [0x62, 0x71, 0xfd, 0x48, 0x5c, 0x3e]);
    assert_eq!(act(Do::Max, 3, 24, Memory(Place::Coordinate(2))), [0x62, 0xd1, 0xbd, 0x40, 0x5f, 0x1b]);
    let third = Memory(Place::Number(3));
    assert_eq!(act(Do::Div, 3, 4, third), [0x62, 0xf1, 0xdd, 0x58, 0x5e, 0x59, 3]);
    let far = Memory(Place::Number(2048));
    assert_eq!(act(Do::Div, 3, 4, far), [0x62, 0xf1, 0xdd, 0x58, 0x5e, 0x99, 0, 0x40, 0, 0]);
    assert_eq!(act(Do::Sqrt, 27, 0, Memory(Place::Aside(1))), [0x62, 0x41, 0xfd, 0x48, 0x51, 0x58, 1]);
    assert_eq!(act(Do::Floor, 2, 0, Register(29)), [0x62, 0x93, 0xfd, 0x48, 0x09, 0xd5, 9]);
    let less = [0x62, 0xd1, 0xed, 0x40, 0xc2, 0xcc, 1, 0x62, 0x62, 0xfe, 0x48, 0x38, 0xe1];
    assert_eq!(act(Do::Less, 28, 18, Register(12)), less);
    let load = |to, from| bytes(Width::Zmm, |asm| asm.load(to, from));
    assert_eq!(load(25, Place::Number(129)), [0x62, 0x62, 0xfd, 0x48, 0x19, 0x89, 8, 4, 0, 0]);
    assert_eq!(load(25, Place::Number(127)), [0x62, 0x62, 0xfd, 0x48, 0x19, 0x49, 0x7f]);
    assert_eq!(load(6, Place::Home(8)), [0x62, 0xf1, 0xfd, 0x48, 0x10, 0x34, 0xd7]);
    let store = bytes(Width::Zmm, |asm| asm.store(Place::Home(300), 22));
    assert_eq!(store[7..], [0x62, 0xe1, 0xfd, 0x48, 0x11, 0x34, 0x07]);
}

/// `x`, `y`, and what `more` makes of them.
fn tape(more: impl IntoIterator<Item = Instr>) -> Tape {
    let code: Vec<Instr> = [Instr::Coordinate(0), Instr::Coordinate(1)].into_iter().chain(more).collect();
    let last = code.len() as u32 - 1;
    Tape::of(code, vec![last], Vec::new(), Class::C0)
}

fn two(op: Op, x: u32, y: u32) -> Instr {
    Instr::Op(op, [x, y, 0, 0, 0, 0])
}

/// What comes of a tape at `x` and one, with nothing to interpret.
fn outcome(tape: &Tape, x: f64) -> Outcome {
    let home: Vec<u32> = (0..tape.len() as u32).collect();
    let native = Native::default();
    native.translate((tape, &home));
    let at = [x, 1.0, 0.0].map(|c| Many::<f64, 8>([c; 8]));
    native.eval((tape, &home), &at, &mut Vec::new(), |_, _| unreachable!())
}

#[test]
fn nan_is_left_to_the_interpreter_where_machines_differ_about_it() {
    if simd_level() == Level::Baseline {
        return;
    }
    let sum = tape([two(Op::Add(op::Add), 0, 1)]);
    let comparisons =
        [Op::Min(op::Min), Op::Max(op::Max), Op::Step(op::Step)].map(|op| tape([two(op, 0, 1)]));
    // A flag that was raised before does not matter.
    assert!(!widest(|| std::hint::black_box(f64::NAN) < std::hint::black_box(0.0)));
    for tape in comparisons.iter().chain([&sum]) {
        assert!(matches!(outcome(tape, 0.5), Outcome::Done));
        assert!(matches!(outcome(tape, f64::INFINITY), Outcome::Done));
    }
    assert!(matches!(outcome(&sum, f64::NAN), Outcome::Done));
    for tape in &comparisons {
        assert!(matches!(outcome(tape, f64::NAN), Outcome::Invalid));
    }
}

#[test]
fn values_are_put_aside_only_where_registers_do_not_suffice() {
    if simd_level() == Level::Baseline {
        return;
    }
    for (width, room) in [(Width::Ymm, 16), (Width::Zmm, 32)] {
        for count in 2..60 {
            // So many products, all of which are needed at the end.
            let products = (0..count).map(|i| two(Op::Mul(op::Mul), i.min(1), (i + 1) & 1));
            let sums = (0..count).rev().scan(1 + count, |last, i| {
                *last += 1;
                Some(two(Op::Sub(op::Sub), 2 + i, *last - 1))
            });
            let tape = tape(products.chain(sums));
            let home: Vec<u32> = (0..tape.len() as u32).collect();
            let aside = Translated::new((&tape, &home), width).map_or(0, |t| t.aside / width.bytes());
            // The coordinates may have registers, too.
            let count = count as usize;
            let expected = count.saturating_sub(room)..=(count + 2).saturating_sub(room);
            assert!(expected.contains(&aside), "{count} in {room}: {aside} aside");
        }
    }
}
