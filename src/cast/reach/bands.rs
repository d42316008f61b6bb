//! Bundles forwards by enclosures of their pieces.
//!
//! A piece of a bundle is what the thesis calls a cell: places across, and a stretch of depth, with a symbol for
//! each (7.15). Its enclosure is not only positive or not, but a band between parabolas along the depth, and so says
//! how far from the middle of the piece the bundle is free; the march is that of the beams of the caster
//! ([`beam`](super::super::beam)), and takes the place of the tree of cells and of its search in depth (7.12).

use super::Reach;
use crate::cast::CastStats;
use crate::cast::beam::{Batches, Bundle, march_bundles};
use crate::tape::Cells;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Goes forwards by enclosures; see the module text.
pub(super) struct Bands {
    cells: Arc<Cells>,
    wide: Batches<2>,
    active: Vec<usize>,
}

impl Bands {
    pub(super) fn new(cells: Arc<Cells>) -> Bands {
        Bands { wide: Batches::default(), cells, active: Vec::new() }
    }
}

impl Reach for Bands {
    fn advance(&mut self, bundles: &mut [&mut Bundle], stats: &mut CastStats, cancel: &AtomicBool) {
        let Bands { cells, wide, active } = self;
        march_bundles((cells, wide), (bundles, active), stats, cancel, |_| {});
    }

    fn clone_box(&self) -> Box<dyn Reach> {
        Box::new(Bands::new(self.cells.clone()))
    }
}
