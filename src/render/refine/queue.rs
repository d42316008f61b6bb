//! The queue of tiles: rough ones level by level, then finished ones from the middle of the picture; and before all of
//! these, in the same order, those of the region of interest (thesis, 7.4).

use super::super::tile::tiles;
use super::super::{Picture, Rect};
use super::Steering;
use crate::cast::Bundle;
use std::collections::VecDeque;

/// Rough tiles that a thread takes at once: enough for full batches, few enough that others get some.
const AT_ONCE: usize = 64;

/// A tile that is to be painted in one colour.
pub(super) struct Tile {
    pub rect: Rect,
    /// Of [`Steering::SIDES`].
    pub level: usize,
    /// Its lines of sight to all there is, as far as they are not proven to meet nothing; `None` if they go too far apart
    /// for bundles.
    pub strands: Option<Vec<Strand>>,
}

/// Lines of sight through a tile to one solid.
pub(super) struct Strand {
    /// Which way to see it, of a [`Scout`](super::scout::Scout)'s.
    pub sight: usize,
    /// Which piece of the lines.
    pub piece: usize,
    pub bundle: Bundle,
}

/// What a thread does next.
pub(super) enum Work {
    /// Paints some tiles of one level.
    Rough(Vec<Tile>),
    /// Renders one.
    Finished(Rect),
}

/// Tiles in the order in which they are due.
#[derive(Default)]
struct Line {
    rough: [VecDeque<Tile>; Steering::SIDES.len()],
    finished: VecDeque<Rect>,
}

/// All tiles that are due.
pub(super) struct Queue {
    /// Those that meet the region of interest, and all others.
    lines: [Line; 2],
    region: Option<Rect>,
    /// How often the region had been changed when the tiles were last sorted.
    changes: usize,
    threads: usize,
}

impl Queue {
    /// The finished tiles of a picture.
    pub fn new(picture: &Picture, threads: usize) -> Queue {
        let mut finished = tiles(picture.width, picture.height);
        finished.retain(|tile| tile.intersection(&picture.window).is_some());
        let rest = Line { finished: finished.into(), ..Line::default() };
        Queue { lines: [Line::default(), rest], region: None, changes: 0, threads: threads.max(1) }
    }

    /// How many finished tiles are due.
    pub fn finished_tiles(&self) -> usize {
        self.lines.iter().map(|line| line.finished.len()).sum()
    }

    /// Takes what is due next.
    pub fn next(&mut self, steering: &Steering) -> Option<Work> {
        if let Some(region) = steering.changed_since(&mut self.changes) {
            self.sort(region);
        }
        let threads = self.threads;
        self.lines.iter_mut().find_map(|line| line.next(threads))
    }

    /// Adds rough tiles.
    pub fn extend(&mut self, tiles: Vec<Tile>) {
        for tile in tiles {
            let line = self.line(&tile.rect);
            self.lines[line].rough[tile.level].push_back(tile);
        }
    }

    /// Which line a tile stands in.
    fn line(&self, rect: &Rect) -> usize {
        let meets = |region: Rect| region.intersection(rect).is_some();
        usize::from(!self.region.is_some_and(meets))
    }

    /// Lines up again, around another region.
    fn sort(&mut self, region: Option<Rect>) {
        self.region = region;
        let [before, rest] = std::mem::take(&mut self.lines);
        for line in [before, rest] {
            line.rough.into_iter().for_each(|tiles| self.extend(tiles.into()));
            for rect in line.finished {
                let line = self.line(&rect);
                self.lines[line].finished.push_back(rect);
            }
        }
    }
}

impl Line {
    fn next(&mut self, threads: usize) -> Option<Work> {
        if let Some(tiles) = self.rough.iter_mut().find(|tiles| !tiles.is_empty()) {
            // The last ones of a level are shared out, so that nobody waits long.
            let count = tiles.len().div_ceil(threads).min(AT_ONCE);
            return Some(Work::Rough(tiles.drain(..count).collect()));
        }
        self.finished.pop_front().map(Work::Finished)
    }
}
