//! Tapes: expressions lowered to straight-line code.
//!
//! A tape is a list of instructions in single assignment: instruction `i` writes slot `i` and reads
//! slots before it. One loop evaluates a tape for every kind of number; with batches
//! ([`Many`](crate::num::Many)) an instruction works on many points and its dispatch disappears.
//! Over a region, [`Tape::prune`] drops what cannot matter there; [`Cells`] do so for all parts of a
//! region as they are asked for. Who wants no more than signs has those of minima and maxima put together from signs
//! ([`Signer`]). Tapes that are evaluated often on batches of plain numbers become machine
//! code ([`native`]). What each instruction takes is told by the clock ([`seconds`]), and what all of them do ([`duration`]).

mod cells;
mod clock;
mod crown;
mod defined;
mod direction;
mod eval;
mod inner;
mod levels;
mod lower;
#[cfg_attr(not(target_arch = "x86_64"), path = "native/elsewhere.rs")]
mod native;
mod nowhere;
mod operands;
mod prune;

pub use cells::{Cells, Prunings};
pub use clock::{duration, seconds};
pub use crown::{Signed, Signer};
pub use defined::Defined;
pub use eval::Evaluator;
pub use inner::{Flowed, Inner};
pub use levels::Wanted;
pub use lower::{Census, Instr, Tape};
pub use prune::Bounded;
