//! Windows: the part of a picture that is rendered, for a close look or as one machine's share.
//!
//! A pixel has the same bits in every window that it is in. It owes that to the tiles: rays of a tile are cast
//! together, so the tiles that a window touches are rendered whole, and cut only when they are put into the picture.
//! Parts of a picture that are made [`Part::Tile`] by tile share no tile, so that together they cost what the whole does.

use super::tile::SIDE;
use std::fmt::{self, Display};
use std::str::FromStr;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// All of a picture of that size.
    pub fn whole(width: u32, height: u32) -> Rect {
        Rect { x: 0, y: 0, width, height }
    }

    /// The column to the right of the last.
    pub fn right(&self) -> u32 {
        self.x.saturating_add(self.width)
    }

    /// The row below the last.
    pub fn bottom(&self) -> u32 {
        self.y.saturating_add(self.height)
    }

    /// Number of pixels.
    pub fn area(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Whether all of another rectangle, which must not be empty, is in this one.
    pub fn holds(&self, other: &Rect) -> bool {
        other.area() > 0 && self.intersection(other) == Some(*other)
    }

    /// Puts what belongs to the pixels of this rectangle, row by row, into what belongs to those of `all`.
    pub(super) fn put<T: Copy>(&self, values: &[T], all: Rect, into: &mut [T]) {
        let columns = self.width as usize;
        for (row, line) in values.chunks_exact(columns).enumerate() {
            let start = ((self.y - all.y) as usize + row) * all.width as usize + (self.x - all.x) as usize;
            into[start..start + columns].copy_from_slice(line);
        }
    }

    /// The pixels that are in both; `None` if there are none.
    pub fn intersection(&self, other: &Rect) -> Option<Rect> {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let (right, bottom) = (self.right().min(other.right()), self.bottom().min(other.bottom()));
        (x < right && y < bottom).then(|| Rect { x, y, width: right - x, height: bottom - y })
    }
}

impl Display for Rect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{}x{}", self.x, self.y, self.width, self.height)
    }
}

impl FromStr for Rect {
    type Err = String;

    fn from_str(text: &str) -> Result<Rect, String> {
        let number = |s: &str| s.trim().parse::<u32>().ok();
        let rect = || {
            let (x, rest) = text.split_once(',')?;
            let (y, size) = rest.split_once(',')?;
            let (width, height) = size.split_once(['x', 'X', '×'])?;
            Some(Rect { x: number(x)?, y: number(y)?, width: number(width)?, height: number(height)? })
        };
        rect().filter(|rect| rect.area() > 0).ok_or_else(|| {
            "a region is its first column, its first row and its size in pixels; for example: 320,200,64x48".into()
        })
    }
}

/// Which part of a picture is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    #[default]
    Whole,
    /// These pixels.
    Region(Rect),
    /// One of so many shares of about the same area, which together are the picture.
    Tile {
        /// Which, from 1.
        number: u32,
        /// Of how many.
        of: u32,
    },
}

/// Why a picture has no such part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PartError {
    /// The region is not within the picture.
    #[error("the region {region} is not within the picture, which has {width} x {height} pixels")]
    Outside {
        /// The region.
        region: Rect,
        /// Width of the picture.
        width: u32,
        /// Height of the picture.
        height: u32,
    },
    /// There is no share of that number.
    #[error("there is no part {number} of {of}")]
    Number {
        /// Which was wanted.
        number: u32,
        /// Of how many.
        of: u32,
    },
    /// Shares are made of whole tiles, and there are not so many.
    #[error("a picture of {width} x {height} pixels is cut into {tiles} parts at most, not into {of}")]
    TooMany {
        /// How many were wanted.
        of: u32,
        /// How many there can be.
        tiles: u64,
        /// Width of the picture.
        width: u32,
        /// Height of the picture.
        height: u32,
    },
}

impl PartError {
    /// What to do about it.
    pub fn hint(&self) -> String {
        match self {
            PartError::Outside { width, height, .. } => {
                format!(
                    "all of it is {}; columns count from the left, rows from the top",
                    Rect::whole(*width, *height)
                )
            }
            PartError::Number { of, .. } => format!("parts go from 1 to {of}"),
            PartError::TooMany { tiles, .. } => format!("use 1 to {tiles} parts"),
        }
    }
}

impl Part {
    /// Whether these pixels of a picture of this size are another of the shares that this is one of.
    pub fn is_beside(self, window: Rect, width: u32, height: u32) -> bool {
        let Part::Tile { number, of } = self else { return false };
        let other = |n: u32| Part::Tile { number: n, of }.window(width, height);
        (1..=of).any(|n| n != number && other(n) == Ok(window))
    }

    /// The pixels that this part of a picture has.
    ///
    /// # Errors
    /// [`PartError`] where the picture has no such part.
    pub fn window(self, width: u32, height: u32) -> Result<Rect, PartError> {
        let whole = Rect::whole(width, height);
        match self {
            Part::Whole => Ok(whole),
            Part::Region(region) if whole.holds(&region) => Ok(region),
            Part::Region(region) => Err(PartError::Outside { region, width, height }),
            Part::Tile { number, of } if number == 0 || number > of => Err(PartError::Number { number, of }),
            Part::Tile { number, of } => {
                let cells = Rect::whole(width.div_ceil(SIDE), height.div_ceil(SIDE));
                if cells.area() < u64::from(of) {
                    return Err(PartError::TooMany { of, tiles: cells.area(), width, height });
                }
                let Rect { x, y, width, height } = share(cells, number - 1, of);
                let window = Rect { x: x * SIDE, y: y * SIDE, width: width * SIDE, height: height * SIDE };
                Ok(window.intersection(&whole).unwrap_or(whole))
            }
        }
    }
}

/// The share of that number, from 0, of a rectangle of at least `of` cells: the longer side is halved, and with it
/// the number of shares, until one is left. Shares have a cell at least, and are nearly square where they can be.
fn share(cells: Rect, number: u32, of: u32) -> Rect {
    if of <= 1 {
        return cells;
    }
    let Rect { x, y, width, height } = cells;
    let (long, short) = (width.max(height), width.min(height));
    let in_proportion = (2 * u64::from(long) * u64::from(of / 2) + u64::from(of)) / (2 * u64::from(of));
    let cut = (in_proportion as u32).clamp(1, long - 1);
    // No half may have more shares than cells.
    let fits = |length: u32| u64::from(length) * u64::from(short);
    let least = u64::from(of).saturating_sub(fits(long - cut)).max(1);
    let first = u64::from(of / 2).clamp(least, fits(cut).min(u64::from(of) - 1)) as u32;
    let (one, other) = if width >= height {
        (Rect { width: cut, ..cells }, Rect { x: x + cut, width: width - cut, ..cells })
    } else {
        (Rect { height: cut, ..cells }, Rect { y: y + cut, height: height - cut, ..cells })
    };
    if number < first { share(one, number, first) } else { share(other, number - first, of - first) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_whole_and_make_up_the_picture() {
        for (width, height) in [(1u32, 1u32), (64, 48), (33, 500), (1000, 40), (97, 97), (800, 600)] {
            let most = width.div_ceil(SIDE) * height.div_ceil(SIDE);
            for of in (1..=most.min(40)).chain([most]) {
                let parts: Vec<Rect> =
                    (1..=of).map(|number| Part::Tile { number, of }.window(width, height).unwrap()).collect();
                assert_eq!(parts.iter().map(Rect::area).sum::<u64>(), u64::from(width * height));
                for (i, a) in parts.iter().enumerate() {
                    assert!(a.area() > 0 && a.x % SIDE == 0 && a.y % SIDE == 0);
                    assert!(
                        parts[..i].iter().all(|b| a.intersection(b).is_none()),
                        "{width}x{height} by {of}"
                    );
                }
            }
        }
    }

    #[test]
    fn tiles_are_of_about_one_size() {
        for of in [2, 3, 5, 7, 8, 12, 30] {
            let areas = (1..=of).map(|number| Part::Tile { number, of }.window(3840, 2160).unwrap().area());
            let (least, most) = areas.fold((u64::MAX, 0), |(l, m), a| (l.min(a), m.max(a)));
            assert!(most as f64 / (least as f64) < 1.2, "{of}: {least} to {most}");
        }
    }

    #[test]
    fn parts_that_there_are_not() {
        let error = |part: Part| part.window(64, 48).unwrap_err();
        let region = |text: &str| Part::Region(text.parse().unwrap());
        assert_eq!(region("1,2,3x4").window(64, 48), Ok(Rect { x: 1, y: 2, width: 3, height: 4 }));
        assert!(matches!(error(region("60,0,5x5")), PartError::Outside { .. }));
        assert!(matches!(error(region("0,4294967295,5x5")), PartError::Outside { .. }));
        assert!(matches!(error(region("64,0,1x1")), PartError::Outside { .. }));
        assert!(matches!(error(Part::Tile { number: 0, of: 3 }), PartError::Number { .. }));
        assert!(matches!(error(Part::Tile { number: 1, of: 5 }), PartError::TooMany { tiles: 4, .. }));
        for bad in ["", "1,2,3", "1,2,3,4,5", "1,2,0x4", "-1,2,3x4", "a,b,cxd"] {
            assert!(bad.parse::<Rect>().unwrap_err().contains("320,200,64x48"), "{bad}");
        }
        let rect: Rect = "1,2,3x4".parse().unwrap();
        assert_eq!(rect.to_string().parse(), Ok(rect));
    }
}
