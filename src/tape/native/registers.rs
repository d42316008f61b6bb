//! Which vector register holds which value, and when.
//!
//! One pass over the lines of a run, in their order, writes the instructions: a linear scan (M. Poletto
//! and V. Sarkar, Linear scan register allocation, 1999). A value that no line reads any more leaves its
//! register at once. Where all are taken, the value goes that is read next after all others, which for
//! straight code is the best choice as to loads (L. A. Belady, A study of replacement algorithms for
//! a virtual-storage computer, 1966). Numbers, coordinates and what has a home lie in memory anyway;
//! a value that does not is put aside once, and loaded from there. Registers that are left over
//! hold numbers throughout the loop.

use super::encode::{Assembler, Place, Source};
use super::trace::{Do, Line};

/// The line that reads a value that none does.
const NEVER: u32 = u32::MAX;

/// A run in machine code.
pub(super) struct Assembled {
    /// Where it begins.
    pub(super) entry: usize,
    /// How many vectors it puts aside at a time.
    pub(super) aside: usize,
}

/// Writes the instructions of a run. Numbers that they read are added to `numbers`.
pub(super) fn assemble(lines: &[Line], asm: &mut Assembler, numbers: &mut Vec<u64>) -> Assembled {
    let watches = lines.iter().any(Line::may_be_invalid);
    let entry = asm.begin(watches);
    let mut scan = Scan::new(lines, asm, numbers);
    scan.fix_numbers(lines);
    let start = scan.asm.begin_loop();
    for (i, line) in lines.iter().enumerate() {
        scan.vacant.append(&mut scan.left);
        match *line {
            Line::Compute(act, args) if scan.values[i].next != NEVER => scan.compute(i, act, args),
            Line::Store(value, home) => scan.keep(i, value, home),
            Line::Compute(..) | Line::Number(_) | Line::Coordinate(_) | Line::Home(_) => {}
        }
    }
    let aside = scan.aside as usize;
    asm.end(start, watches);
    Assembled { entry, aside }
}

/// For each line the lines that read its arguments next, and for each value the line that reads it first.
/// What is computed for nothing reads nothing.
fn uses(lines: &[Line]) -> (Vec<[u32; 2]>, Vec<u32>) {
    let mut next = vec![NEVER; lines.len()];
    let mut reads = vec![[NEVER; 2]; lines.len()];
    for (i, line) in lines.iter().enumerate().rev() {
        let args = match *line {
            Line::Compute(_, args) if next[i] != NEVER => args,
            Line::Store(value, _) => [value; 2],
            _ => continue,
        };
        reads[i] = args.map(|a| next[a as usize]);
        args.iter().for_each(|&a| next[a as usize] = i as u32);
    }
    (reads, next)
}

/// Where the value of a line lies in memory from the beginning.
fn place(line: &Line, next: u32, numbers: &mut Vec<u64>) -> Option<Place> {
    match *line {
        Line::Number(bits) if next != NEVER => {
            numbers.push(bits);
            Some(Place::Number(numbers.len() - 1))
        }
        Line::Coordinate(axis) => Some(Place::Coordinate(axis)),
        Line::Home(home) => Some(Place::Home(home)),
        Line::Number(_) | Line::Compute(..) | Line::Store(..) => None,
    }
}

#[derive(Clone, Copy)]
struct Value {
    /// The line that reads it next.
    next: u32,
    register: Option<u8>,
    place: Option<Place>,
}

/// The state of the scan.
struct Scan<'a> {
    asm: &'a mut Assembler,
    values: Vec<Value>,
    /// For each line the lines that read its arguments next.
    reads: Vec<[u32; 2]>,
    /// The value in each register that is not free.
    held: Vec<u32>,
    /// A bit for each free register, and for each that holds a number throughout the loop.
    free: u32,
    fixed: u32,
    /// Places aside that can be taken again, those that can be from the next line on, and how many there
    /// are.
    vacant: Vec<u32>,
    left: Vec<u32>,
    aside: u32,
}

impl<'a> Scan<'a> {
    fn new(lines: &[Line], asm: &'a mut Assembler, numbers: &mut Vec<u64>) -> Scan<'a> {
        let (reads, next) = uses(lines);
        let values = lines
            .iter()
            .zip(next)
            .map(|(line, next)| Value { next, register: None, place: place(line, next, numbers) })
            .collect();
        let count = asm.width.registers();
        Scan {
            asm,
            values,
            reads,
            held: vec![0; count as usize],
            free: ((1_u64 << count) - 1) as u32,
            fixed: 0,
            vacant: Vec::new(),
            left: Vec::new(),
            aside: 0,
        }
    }

    /// Most values but numbers that are needed at a time.
    fn most_alive(&self, lines: &[Line]) -> usize {
        let (mut alive, mut most) = (vec![false; lines.len()], 0);
        let mut count = 0_usize;
        let mut set = |value: u32, is: bool| {
            let was = std::mem::replace(&mut alive[value as usize], is);
            let is_number = matches!(lines[value as usize], Line::Number(_));
            count += usize::from(is && !was && !is_number);
            count -= usize::from(was && !is && !is_number);
            most = most.max(count);
        };
        for (i, line) in lines.iter().enumerate() {
            let args = match *line {
                Line::Compute(_, args) if self.values[i].next != NEVER => args,
                Line::Store(value, _) => [value; 2],
                _ => continue,
            };
            args.iter().for_each(|&a| set(a, true));
            args.iter().zip(self.reads[i]).for_each(|(&a, next)| set(a, next != NEVER));
            if matches!(line, Line::Compute(..)) {
                set(i as u32, true);
            }
        }
        most
    }

    /// Loads the first of the numbers before the loop, into registers that nothing else needs.
    fn fix_numbers(&mut self, lines: &[Line]) {
        // Two for numbers that are left.
        let room = self.held.len().saturating_sub(self.most_alive(lines) + 2);
        let mut all: Vec<(u64, u8)> = Vec::with_capacity(room);
        for (i, line) in lines.iter().enumerate() {
            let Value { next, place: Some(place), .. } = self.values[i] else { continue };
            let Line::Number(bits) = *line else { continue };
            let known = all.iter().find(|(other, _)| *other == bits).map(|(_, register)| *register);
            if next == NEVER || (known.is_none() && all.len() == room) {
                continue;
            }
            let register = known.unwrap_or_else(|| {
                let register = (self.held.len() - 1 - all.len()) as u8;
                self.asm.load(register, place);
                all.push((bits, register));
                register
            });
            self.fixed |= 1 << register;
            self.free &= !(1 << register);
            self.values[i].register = Some(register);
        }
    }

    fn compute(&mut self, line: usize, act: Do, [mut x, mut y]: [u32; 2]) {
        let mut reads = self.reads[line];
        let is_loaded = |value: u32| self.values[value as usize].register.is_some();
        if act.commutes() && !is_loaded(x) && is_loaded(y) {
            (x, y) = (y, x);
            reads.reverse();
        }
        let takes_one = matches!(act, Do::Sqrt | Do::Floor);
        let first = if takes_one { 0 } else { self.load(x, None) };
        let second = match self.values[y as usize] {
            Value { register: None, place: Some(place), .. }
                if self.asm.reads(place) && (reads[1] == NEVER || matches!(place, Place::Number(_))) =>
            {
                Source::Memory(place)
            }
            _ => Source::Register(self.load(y, (!takes_one).then_some(first))),
        };
        self.leave(x, reads[0]);
        self.leave(y, reads[1]);
        let to = self.vacate(None);
        self.asm.act(act, to, first, second);
        self.hold(line as u32, to);
    }

    /// Stores a value in its home.
    fn keep(&mut self, line: usize, value: u32, home: u32) {
        let from = self.load(value, None);
        self.asm.store(Place::Home(home), from);
        self.values[value as usize].place.get_or_insert(Place::Home(home));
        self.leave(value, self.reads[line][0]);
    }

    /// The register of a value that is needed now, other than the one given.
    fn load(&mut self, value: u32, other: Option<u8>) -> u8 {
        let Value { register, place, .. } = self.values[value as usize];
        register.unwrap_or_else(|| {
            let to = self.vacate(other);
            if let Some(place) = place {
                self.asm.load(to, place);
            }
            self.hold(value, to);
            to
        })
    }

    /// A register without a value in it, if need be by putting one aside, but not that of the one given.
    fn vacate(&mut self, other: Option<u8>) -> u8 {
        if self.free != 0 {
            return self.free.trailing_zeros() as u8;
        }
        let next = |r: u8| self.values[self.held[r as usize] as usize].next;
        let all = (0..self.held.len() as u8).filter(|r| Some(*r) != other && self.fixed >> r & 1 == 0);
        let register = all.max_by_key(|r| next(*r)).unwrap_or(0);
        let value = self.held[register as usize];
        if self.values[value as usize].place.is_none() {
            let place = Place::Aside(self.vacant.pop().unwrap_or_else(|| {
                self.aside += 1;
                self.aside - 1
            }));
            self.asm.store(place, register);
            self.values[value as usize].place = Some(place);
        }
        self.release(value);
        register
    }

    fn hold(&mut self, value: u32, register: u8) {
        self.free &= !(1 << register);
        self.held[register as usize] = value;
        self.values[value as usize].register = Some(register);
    }

    fn release(&mut self, value: u32) {
        if let Some(register) = self.values[value as usize].register.take() {
            self.free |= 1 << register & !self.fixed;
        }
    }

    /// A line has read the value; `next` is the one that does so next.
    fn leave(&mut self, value: u32, next: u32) {
        self.values[value as usize].next = next;
        if next == NEVER {
            self.release(value);
            if let Some(Place::Aside(place)) = self.values[value as usize].place.take() {
                self.left.push(place);
            }
        }
    }
}
