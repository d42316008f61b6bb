//! Snapshots: what a picture looked like on its way, put together afterwards.

use super::super::tile::tiles;
use super::super::{Picture, Rect};
use super::{Rough, locked};
use std::cmp::Reverse;
use std::sync::Mutex;

/// Keeps rough tiles.
#[derive(Debug, Default)]
pub struct Snapshots {
    tiles: Mutex<Vec<Rough>>,
}

impl Snapshots {
    /// Keeps a tile: what a [`Job`](super::super::Job) may do with it.
    pub fn keep(&self, tile: &Rough) {
        locked(&self.tiles).push(*tile);
    }

    /// What was seen when all rough tiles of a side were there, and none that are smaller; but in a region of interest,
    /// if there was one, the finished tiles.
    pub fn at(&self, side: u32, region: Option<Rect>, picture: &Picture) -> Picture {
        let kept = locked(&self.tiles);
        let mut tiles: Vec<&Rough> = kept.iter().filter(|tile| tile.side >= side).collect();
        tiles.sort_by_key(|tile| Reverse(tile.side));
        let mut snapshot = Picture { finished: false, denoised: None, components: None, ..picture.clone() };
        for Rough { rect, pixel, .. } in tiles {
            snapshot.put(rect, &vec![*pixel; rect.area() as usize]);
        }
        let is_finished = |tile: &Rect| region.is_some_and(|region| region.intersection(tile).is_some());
        for tile in tiles_of(picture).filter(is_finished) {
            let rows = tile.y..tile.bottom();
            let own = rows.flat_map(|y| (tile.x..tile.right()).map(move |x| *picture.pixel(x, y)));
            snapshot.put(&tile, &own.collect::<Vec<_>>());
        }
        snapshot
    }
}

/// The tiles of a picture, as far as they are in its window.
fn tiles_of(picture: &Picture) -> impl Iterator<Item = Rect> {
    let all = tiles(picture.width, picture.height).into_iter();
    all.filter_map(|tile| tile.intersection(&picture.window))
}
