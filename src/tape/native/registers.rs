//! Which vector register holds which value, and when.
//!
//! One pass over the lines of a run, in their order, writes the instructions: a linear scan (M. Poletto
//! and V. Sarkar, Linear scan register allocation, 1999). A value that no line reads any more leaves its
//! register at once. Where all are taken, the value goes that is read next after all others, which for
//! straight code is the best choice as to loads (L. A. Belady, A study of replacement algorithms for
//! a virtual-storage computer, 1966). Numbers, coordinates and what has a home lie in memory anyway;
//! a value that does not is put aside once, and loaded from there.

use super::encode::{Assembler, Place, Source};
use super::trace::{Do, Line};

/// The line that reads a value that none does.
const NEVER: u32 = u32::MAX;

/// Writes the instructions for the lines of a run, within its loop. Numbers that they read are added to
/// `numbers`. Returns how many vectors are put aside at a time.
pub(super) fn assemble(lines: &[Line], asm: &mut Assembler, numbers: &mut Vec<u64>) -> u32 {
    let (reads, next) = uses(lines);
    let values = lines
        .iter()
        .zip(next)
        .map(|(line, next)| Value { next, register: None, place: place(line, next, numbers) })
        .collect();
    let count = asm.width.registers();
    let free = ((1_u64 << count) - 1) as u32;
    let held = vec![0; count as usize];
    let mut scan = Scan { asm, values, held, free, vacant: Vec::new(), left: Vec::new(), aside: 0 };
    for (i, line) in lines.iter().enumerate() {
        scan.vacant.append(&mut scan.left);
        match *line {
            Line::Compute(act, args) if scan.values[i].next != NEVER => {
                scan.compute(i as u32, act, args, reads[i]);
            }
            Line::Store(value, home) => scan.keep(value, home, reads[i][0]),
            Line::Compute(..) | Line::Number(_) | Line::Coordinate(_) | Line::Home(_) => {}
        }
    }
    scan.aside
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
    /// The value in each register that is not free.
    held: Vec<u32>,
    /// A bit for each free register.
    free: u32,
    /// Places aside that can be taken again, those that can be from the next line on, and how many there
    /// are.
    vacant: Vec<u32>,
    left: Vec<u32>,
    aside: u32,
}

impl Scan<'_> {
    fn compute(&mut self, line: u32, act: Do, [mut x, mut y]: [u32; 2], mut reads: [u32; 2]) {
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
        self.hold(line, to);
    }

    /// Stores a value in its home.
    fn keep(&mut self, value: u32, home: u32, next: u32) {
        let from = self.load(value, None);
        self.asm.store(Place::Home(home), from);
        self.values[value as usize].place.get_or_insert(Place::Home(home));
        self.leave(value, next);
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
        let all = (0..self.held.len() as u8).filter(|r| Some(*r) != other);
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
            self.free |= 1 << register;
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
