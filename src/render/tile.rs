//! Tiles: small squares of the picture, each rendered by one thread.

use super::Rect;

/// Side of a tile in pixels.
pub(super) const SIDE: u32 = 32;

/// The tiles of a picture, those in the middle first: that is where people look.
pub fn tiles(width: u32, height: u32) -> Vec<Rect> {
    let starts = |size: u32| (0..size).step_by(SIDE as usize);
    let tile = |x: u32, y: u32| Rect { x, y, width: SIDE.min(width - x), height: SIDE.min(height - y) };
    let mut tiles: Vec<Rect> = starts(height).flat_map(|y| starts(width).map(move |x| tile(x, y))).collect();
    let off = |at: u32, size: u32, whole: u32| i64::from(2 * at + size) - i64::from(whole);
    tiles.sort_by_key(|t| off(t.x, t.width, width).pow(2) + off(t.y, t.height, height).pow(2));
    tiles
}

/// Columns and rows of the pixels of one of the [`tiles`], counted from its corner: neighbours among them are neighbours
/// in the picture, so that the rays of a batch stay together.
pub fn places(rect: &Rect) -> impl Iterator<Item = (u32, u32)> + use<> {
    let Rect { width, height, .. } = *rect;
    (0..SIDE * SIDE).map(unravel).filter(move |&(x, y)| x < width && y < height)
}

/// Column and row of the `i`-th pixel of a tile, in Morton's order.
fn unravel(i: u32) -> (u32, u32) {
    let every_other = |i: u32| (0..SIDE.ilog2()).fold(0, |x, bit| x | (i >> (2 * bit) & 1) << bit);
    (every_other(i), every_other(i >> 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height) in [(1, 1), (16, 16), (17, 33), (100, 5)] {
            let mut seen = vec![0; (width * height) as usize];
            for t in tiles(width, height) {
                for (x, y) in (t.y..t.y + t.height).flat_map(|y| (t.x..t.x + t.width).map(move |x| (x, y))) {
                    seen[(y * width + x) as usize] += 1;
                }
            }
            assert!(seen.iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn the_order_within_a_tile_visits_every_pixel() {
        let whole = Rect { x: 0, y: 0, width: SIDE, height: SIDE };
        let mut seen: Vec<_> = places(&whole).collect();
        seen.sort();
        seen.dedup();
        assert_eq!(seen.len(), (SIDE * SIDE) as usize);
        assert_eq!(seen.last(), Some(&(SIDE - 1, SIDE - 1)));
    }
}
