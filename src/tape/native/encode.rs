//! The instructions of x86-64 that runs are made of, as bytes.
//!
//! All vector instructions here have one shape: a register gets a function of a second register and of
//! a third or what lies in memory. Only their prefix depends on the width of vectors: VEX for those of 256
//! bits (AVX2), EVEX for those of 512 (AVX-512), which names 32 registers and reads a single number as
//! a vector of it. (Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2, sections
//! 2.3 and 2.7.)

use super::trace::Do;

/// Width of vectors.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Width {
    /// 256 bits, four numbers.
    Ymm,
    /// 512 bits, eight numbers.
    Zmm,
}

impl Width {
    /// Bytes of a vector.
    pub(super) fn bytes(self) -> usize {
        match self {
            Width::Ymm => 32,
            Width::Zmm => 64,
        }
    }

    /// Vector registers.
    pub(super) fn registers(self) -> u32 {
        match self {
            Width::Ymm => 16,
            Width::Zmm => 32,
        }
    }
}

/// A place in memory that a run reads or writes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Place {
    /// The number with this place in the list of them.
    Number(usize),
    /// The vector at hand of a coordinate.
    Coordinate(usize),
    /// The vector at hand of a register of the evaluator.
    Home(u32),
    /// A vector that was put aside.
    Aside(u32),
}

/// Where the last operand of an instruction is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Source {
    Register(u8),
    Memory(Place),
}

/// What names an instruction besides its operands: prefix, map and number, as in the manual.
#[derive(Clone, Copy)]
struct Opcode {
    prefix: u8,
    map: u8,
    code: u8,
}

const fn packed(code: u8) -> Opcode {
    Opcode { prefix: 1, map: 1, code }
}

const LOAD: Opcode = packed(0x10); // vmovupd
const STORE: Opcode = packed(0x11); // vmovupd
const COMPARE: Opcode = packed(0xc2); // vcmppd
const BROADCAST: Opcode = Opcode { prefix: 1, map: 2, code: 0x19 }; // vbroadcastsd
const ROUND: Opcode = Opcode { prefix: 1, map: 3, code: 0x09 }; // vroundpd, vrndscalepd
const WIDEN: Opcode = Opcode { prefix: 2, map: 2, code: 0x38 }; // vpmovm2q

/// Compare for less, where a NaN is an invalid operation.
const LESS: u8 = 1;
/// Round down, whatever the mode, and say nothing of what is lost.
const DOWN: u8 = 9;

/// General registers by number.
const RAX: u8 = 0;
const NUMBERS: u8 = 1; // rcx
const STRIDE: u8 = 2; // rdx
const COORDINATES: [u8; 3] = [6, 10, 11]; // rsi, r10, r11
const HOMES: u8 = 7; // rdi
const ASIDE: u8 = 8; // r8

/// An operand in memory: base, index with the logarithm of its scale, displacement.
struct Address {
    base: u8,
    index: Option<(u8, u8)>,
    offset: i32,
}

/// Machine code in the making.
///
/// A run is a function of the System V convention: in `rdi` the evaluator's registers, in `rsi` where
/// to find the three coordinates, in `rdx` the bytes of a batch, in `rcx` the numbers, in `r8` room for
/// vectors that are put aside. It returns whether an operation was invalid, if it watches for that.
pub(super) struct Assembler {
    pub(super) width: Width,
    pub(super) code: Vec<u8>,
}

impl Assembler {
    pub(super) fn new(width: Width) -> Assembler {
        Assembler { width, code: Vec::new() }
    }

    /// Begins a run; returns where that is.
    pub(super) fn begin(&mut self, watches: bool) -> usize {
        let entry = self.code.len();
        self.code.extend([0x4c, 0x8d, 0x0c, 0x17]); // lea r9, [rdi + rdx]
        self.code.extend([0x4c, 0x8b, 0x56, 0x08]); // mov r10, [rsi + 8]
        self.code.extend([0x4c, 0x8b, 0x5e, 0x10]); // mov r11, [rsi + 16]
        self.code.extend([0x48, 0x8b, 0x36]); // mov rsi, [rsi]
        if watches {
            self.code.push(0x50); // push rax
            self.code.extend([0x0f, 0xae, 0x1c, 0x24]); // stmxcsr [rsp]
            self.code.extend([0xf6, 0x04, 0x24, 0x01]); // test byte [rsp], 1
            self.code.extend([0x74, 0x08]); // jz past the next two
            self.code.extend([0x83, 0x24, 0x24, 0xfe]); // and dword [rsp], ~1
            self.code.extend([0x0f, 0xae, 0x14, 0x24]); // ldmxcsr [rsp]
        }
        entry
    }

    /// Begins the loop over the vectors of a batch, with a cache line; returns where that is.
    pub(super) fn begin_loop(&mut self) -> usize {
        let gap = self.code.len().next_multiple_of(64) - self.code.len();
        for _ in 0..gap / 9 {
            self.code.extend([0x66, 0x0f, 0x1f, 0x84, 0, 0, 0, 0, 0]); // nop
        }
        self.code.resize(self.code.len() + gap % 9, 0x90); // nop
        self.code.len()
    }

    /// Goes on with the next vectors in the loop that begins at `start`, or ends the run.
    pub(super) fn end(&mut self, start: usize, watches: bool) {
        let step = self.width.bytes() as u8;
        self.code.extend([0x48, 0x83, 0xc6, step]); // add rsi, step
        self.code.extend([0x49, 0x83, 0xc2, step]); // add r10, step
        self.code.extend([0x49, 0x83, 0xc3, step]); // add r11, step
        self.code.extend([0x48, 0x83, 0xc7, step]); // add rdi, step
        self.code.extend([0x4c, 0x39, 0xcf]); // cmp rdi, r9
        let back = start as i64 - (self.code.len() + 6) as i64;
        self.code.extend([0x0f, 0x82]); // jb start
        self.code.extend((back as i32).to_le_bytes());
        self.code.extend([0xc5, 0xf8, 0x77]); // vzeroupper
        if watches {
            self.code.extend([0x0f, 0xae, 0x1c, 0x24]); // stmxcsr [rsp]
            self.code.push(0x58); // pop rax
            self.code.extend([0x83, 0xe0, 0x01]); // and eax, 1
        } else {
            self.code.extend([0x31, 0xc0]); // xor eax, eax
        }
        self.code.push(0xc3); // ret
    }

    /// Loads a vector, or a number into all lanes.
    pub(super) fn load(&mut self, to: u8, from: Place) {
        let opcode = if matches!(from, Place::Number(_)) { BROADCAST } else { LOAD };
        self.emit(opcode, to, 0, Source::Memory(from));
    }

    /// Stores a vector.
    pub(super) fn store(&mut self, to: Place, from: u8) {
        self.emit(STORE, from, 0, Source::Memory(to));
    }

    /// Whether a step reads this place itself, without a load before.
    pub(super) fn reads(&self, place: Place) -> bool {
        self.width == Width::Zmm || !matches!(place, Place::Number(_))
    }

    /// One step: `to` gets a function of `x` and `y`.
    pub(super) fn act(&mut self, act: Do, to: u8, x: u8, y: Source) {
        let code = match act {
            Do::Add => 0x58,
            Do::Mul => 0x59,
            Do::Sub => 0x5c,
            Do::Min => 0x5d,
            Do::Div => 0x5e,
            Do::Max => 0x5f,
            Do::And => 0x54,
            Do::AndNot => 0x55,
            Do::Or => 0x56,
            Do::Xor => 0x57,
            Do::Sqrt => return self.emit(packed(0x51), to, 0, y),
            Do::Floor => {
                self.emit(ROUND, to, 0, y);
                return self.code.push(DOWN);
            }
            Do::Less => return self.less(to, x, y),
        };
        self.emit(packed(code), to, x, y);
    }

    /// The narrow form writes the mask of bits itself, the wide one by way of the mask register k1.
    fn less(&mut self, to: u8, x: u8, y: Source) {
        let mask = if self.width == Width::Zmm { 1 } else { to };
        self.emit(COMPARE, mask, x, y);
        self.code.push(LESS);
        if self.width == Width::Zmm {
            self.emit(WIDEN, to, 0, Source::Register(1));
        }
    }

    fn emit(&mut self, opcode: Opcode, reg: u8, second: u8, third: Source) {
        match third {
            Source::Register(r) => {
                let single = false;
                self.prefix(opcode, [reg, second, r, r >> 1], single);
                self.code.push(0xc0 | (reg & 7) << 3 | r & 7);
            }
            Source::Memory(place) => {
                let single = matches!(place, Place::Number(_));
                let address = self.address(place);
                let index = address.index.map_or(0, |(index, _)| index);
                self.prefix(opcode, [reg, second, address.base, index], single && opcode.map == 1);
                let unit = match (self.width, single) {
                    (Width::Ymm, _) => 1,
                    (Width::Zmm, true) => 8,
                    (Width::Zmm, false) => 64,
                };
                self.operand(reg, &address, unit);
            }
        }
    }

    /// Prefix and opcode, from the numbers of the registers: first, second, third or base, index. Of the
    /// last two bit 3 counts. Most fields hold their bits inverted.
    fn prefix(&mut self, opcode: Opcode, [reg, second, base, index]: [u8; 4], broadcast: bool) {
        let not = |x: u8, bit: u8, to: u8| (!x >> bit & 1) << to;
        let ends = not(reg, 3, 7) | not(index, 3, 6) | not(base, 3, 5);
        let middle = (!second & 15) << 3;
        match self.width {
            Width::Ymm => {
                let long = 1 << 2;
                self.code.extend([0xc4, ends | opcode.map, middle | long | opcode.prefix, opcode.code]);
            }
            Width::Zmm => {
                let double = 1 << 7;
                let first = ends | not(reg, 4, 4) | opcode.map;
                let last = 2 << 5 | u8::from(broadcast) << 4 | not(second, 4, 3);
                self.code.extend([0x62, first, double | middle | 1 << 2 | opcode.prefix, last, opcode.code]);
            }
        }
    }

    /// ModRM, SIB and displacement, which short is in the given unit.
    fn operand(&mut self, reg: u8, address: &Address, unit: i32) {
        let offset = address.offset;
        let short = i8::try_from(offset / unit).ok().filter(|_| offset % unit == 0);
        let mode: u8 = match short {
            Some(0) => 0,
            Some(_) => 1 << 6,
            None => 2 << 6,
        };
        let low = address.base & 7;
        match address.index {
            None => self.code.push(mode | (reg & 7) << 3 | low),
            Some((index, scale)) => {
                self.code.extend([mode | (reg & 7) << 3 | 4, scale << 6 | (index & 7) << 3 | low]);
            }
        }
        match short {
            Some(0) => {}
            Some(short) => self.code.push(short as u8),
            None => self.code.extend(offset.to_le_bytes()),
        }
    }

    fn address(&mut self, place: Place) -> Address {
        let at = |base, offset: usize| Address { base, index: None, offset: offset as i32 };
        match place {
            Place::Number(k) => at(NUMBERS, 8 * k),
            Place::Aside(k) => at(ASIDE, self.width.bytes() * k as usize),
            Place::Coordinate(axis) => at(COORDINATES[axis], 0),
            Place::Home(home) => Address { base: HOMES, index: self.batches(home), offset: 0 },
        }
    }

    /// An index of so many batches; how long one is, is known only when the run is called.
    fn batches(&mut self, count: u32) -> Option<(u8, u8)> {
        match count {
            0 => None,
            1 | 2 | 4 | 8 => Some((STRIDE, count.trailing_zeros() as u8)),
            _ => {
                self.code.extend([0x48, 0x69, 0xc2]); // imul rax, rdx, count
                self.code.extend(count.to_le_bytes());
                Some((RAX, 0))
            }
        }
    }
}
