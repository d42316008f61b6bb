//! Snapshots: what a picture looked like on its way, put together afterwards.

use super::super::Picture;
use super::{Rough, locked};
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

    /// What was seen when all rough tiles of a side were there, and none that are smaller.
    pub fn at(&self, side: u32, picture: &Picture) -> Picture {
        let mut tiles: Vec<Rough> =
            locked(&self.tiles).iter().filter(|tile| tile.side >= side).copied().collect();
        tiles.sort_by_key(|tile| std::cmp::Reverse(tile.side));
        let mut snapshot = Picture { finished: false, denoised: None, ..picture.clone() };
        for Rough { rect, pixel, .. } in tiles {
            snapshot.put(&rect, &vec![pixel; rect.area() as usize]);
        }
        snapshot
    }
}
