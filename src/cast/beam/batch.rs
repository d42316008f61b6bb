//! Questions about many pieces, answered in batches by the tapes of the places where they lie.

use super::march::{Answer, Piece};
use crate::num::{Mix, Parabola, Parabolas};
use crate::tape::{Signer, Tape};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Lanes of a batch: where many pieces have one tape, and where few do. Where one does there are no lanes, so
/// that none is idle.
const MANY: usize = 16;
const FEW: usize = 4;

/// What decides of the sign over a piece is told if it is no more leaves than these.
const MIXED: usize = 8;

/// Evaluators for as many pieces at once.
#[derive(Default)]
pub(in crate::cast) struct Batches<const K: usize> {
    many: Signer<MANY, K>,
    few: Signer<FEW, K>,
    one: Signer<1, K>,
}

impl<const K: usize> Batches<K> {
    /// Asks about a piece of each of some entries of a list, each by its tape. `ask` is the piece and its coordinates, `tell`
    /// gets the answer, the form of what is expected to fall to zero there, and all forms that matter if it wants them.
    /// Returns the work. Once `cancel` is set, no more are answered.
    pub(super) fn answer<I>(
        &mut self,
        (items, mut asked): (&mut [I], Vec<(&Arc<Tape>, usize)>),
        ask: impl Fn(&I) -> (Piece, [Parabola<K>; 3]),
        mut tell: impl FnMut(&mut I, &Parabola<K>, Answer, &dyn Fn() -> Option<Mix<K>>),
        cancel: &AtomicBool,
    ) -> u64 {
        let mut work = 0;
        // No lane depends on its neighbours, so their order does not matter.
        asked.sort_unstable_by_key(|(tape, i)| (Arc::as_ptr(tape), *i));
        for same in asked.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            // So few that are left over fill lanes of few better, in about the same time.
            let (whole, rest) = same.split_at(same.len() - same.len() % MANY);
            let size = if rest.len() <= 2 * FEW { FEW } else { MANY };
            for batch in whole.chunks(MANY).chain(rest.chunks(size)) {
                if cancel.load(Ordering::Relaxed) {
                    return work;
                }
                work += self.answer_alike(items, batch, &ask, &mut tell);
            }
        }
        work
    }

    /// Asks about entries that have one tape, no more than [`MANY`], in no more lanes than they need, and returns the work.
    fn answer_alike<I>(
        &mut self,
        items: &mut [I],
        batch: &[(&Arc<Tape>, usize)],
        ask: &impl Fn(&I) -> (Piece, [Parabola<K>; 3]),
        tell: &mut impl FnMut(&mut I, &Parabola<K>, Answer, &dyn Fn() -> Option<Mix<K>>),
    ) -> u64 {
        let (tape, entries) = (batch[0].0, batch.iter().map(|(_, i)| *i));
        match batch.len() {
            1 => answer((&mut self.one, tape), items, entries, ask, tell),
            2..=FEW => answer((&mut self.few, tape), items, entries, ask, tell),
            _ => answer((&mut self.many, tape), items, entries, ask, tell),
        }
    }
}

/// Asks about at most `B` entries at once, and returns the work.
fn answer<I, const B: usize, const K: usize>(
    (signer, tape): (&mut Signer<B, K>, &Arc<Tape>),
    items: &mut [I],
    batch: impl Iterator<Item = usize> + Clone,
    ask: &impl Fn(&I) -> (Piece, [Parabola<K>; 3]),
    tell: &mut impl FnMut(&mut I, &Parabola<K>, Answer, &dyn Fn() -> Option<Mix<K>>),
) -> u64 {
    let mut places = batch.clone().map(|i| ask(&items[i]));
    let Some((piece, first)) = places.next() else { return 0 };
    // Lanes that are left over do what the first does: what all agree on is decided for all at once.
    let mut p = first.map(Parabolas::<B, K>::all);
    let mut pieces = [piece; B];
    for (lane, (piece, place)) in (1..).zip(places) {
        pieces[lane] = piece;
        for axis in 0..3 {
            p[axis].set(lane, &place[axis]);
        }
    }
    let signed = signer.eval(tape, &p);
    for (lane, i) in batch.enumerate() {
        let answer = Answer::new(&signed.lane(lane), pieces[lane]);
        tell(&mut items[i], &signed.form(lane), answer, &|| signed.mix(lane, MIXED));
    }
    tape.work() * B as u64
}
