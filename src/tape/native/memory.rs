//! Machine code in memory.
//!
//! Code is written to fresh pages, which then are made executable and can be written no more.

use memmap2::{Mmap, MmapMut};
use std::sync::atomic::{AtomicUsize, Ordering};

/// So many pieces of code may be in memory at a time: a process may have but so many maps (65530 on
/// Linux), and others need some.
const MOST: usize = 8192;

/// How many there are.
static PIECES: AtomicUsize = AtomicUsize::new(0);

/// One of the pieces.
#[derive(Debug)]
struct Piece;

impl Piece {
    fn new() -> Option<Piece> {
        // Relaxed: only the count matters.
        let more = |n| (n < MOST).then_some(n + 1);
        PIECES.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).ok().map(|_| Piece)
    }
}

impl Drop for Piece {
    fn drop(&mut self) {
        PIECES.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The beginning of a run; see [`Assembler`](super::encode::Assembler).
type Run = unsafe extern "sysv64" fn(*mut f64, *const [*const f64; 3], usize, *const u64, *mut f64) -> u32;

/// What a run works on.
pub(super) struct Batches {
    /// The registers of the evaluator, one batch after the other.
    pub(super) homes: *mut f64,
    /// A batch of each coordinate.
    pub(super) coordinates: [*const f64; 3],
    /// Bytes of a batch.
    pub(super) bytes: usize,
    /// Room for what is put aside.
    pub(super) aside: *mut f64,
}

/// Machine code with the numbers that it reads.
#[derive(Debug)]
pub(super) struct Code {
    map: Mmap,
    numbers: Box<[u64]>,
    _piece: Piece,
}

impl Code {
    /// `None` where the machine has no executable memory for us.
    pub(super) fn new(code: &[u8], numbers: Vec<u64>) -> Option<Code> {
        let piece = Piece::new()?;
        let mut map = MmapMut::map_anon(code.len()).ok()?;
        map.copy_from_slice(code);
        Some(Code { map: map.make_exec().ok()?, numbers: numbers.into(), _piece: piece })
    }

    /// Calls the run that begins at `entry` and returns whether an operation was invalid.
    ///
    /// # Safety
    ///
    /// A run must begin there, for vectors that the machine has, and all that it reads and writes must be
    /// in the batches: every home and coordinate, `bytes` a multiple of a vector's, and aside as much
    /// as the run puts there.
    pub(super) unsafe fn call(&self, entry: usize, batches: &Batches) -> bool {
        let Batches { homes, ref coordinates, bytes, aside } = *batches;
        // Safety: a run of this signature begins here, as the caller warrants.
        let invalid = unsafe {
            let run = std::mem::transmute::<*const u8, Run>(self.map.as_ptr().add(entry));
            run(homes, coordinates, bytes, self.numbers.as_ptr(), aside)
        };
        invalid != 0
    }
}
