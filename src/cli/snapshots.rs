//! `--snapshots`: pictures of a picture on its way.

use super::report::Failure;
use super::work::{self, Work};
use crate::render::{Picture, Rect, Rough, Snapshots, Steering};
use crate::scene::Scene;
use crate::session::Loaded;
use std::str::FromStr;

/// Sides of rough tiles at which pictures are wanted, largest first.
#[derive(Clone, Debug)]
pub struct Sides(Vec<u32>);

impl FromStr for Sides {
    type Err = String;

    fn from_str(text: &str) -> Result<Sides, String> {
        let side = |text: &str| {
            let side = text.trim().parse().ok().filter(|side| Steering::SIDES.contains(side));
            side.ok_or_else(|| {
                format!("`{text}` is no side of a rough tile: they are 128, 64, 32, 16, 8, 4, 2 and 1")
            })
        };
        let mut sides = text.split(',').map(side).collect::<Result<Vec<u32>, String>>()?;
        sides.sort_by(|a, b| b.cmp(a));
        sides.dedup();
        Ok(Sides(sides))
    }
}

/// A picture that is watched on its way.
pub struct Series {
    sides: Vec<u32>,
    /// What is asked for before the rest, from the first of these sides on.
    focus: Option<Rect>,
    pub steering: Steering,
    seen: Snapshots,
}

impl Series {
    pub fn new(Sides(sides): Sides, focus: Option<Rect>) -> Series {
        let steering = sides.last().map_or_else(Steering::default, |&finest| Steering::down_to(finest));
        Series { sides, focus, steering, seen: Snapshots::default() }
    }

    /// Sees a rough tile.
    pub fn see(&self, tile: &Rough) {
        self.seen.keep(tile);
        if self.focus.is_some() && self.sides.first() == Some(&tile.side) {
            self.steering.focus(self.focus);
        }
    }

    /// Saves a picture for each side, numbered.
    pub fn save(
        &self,
        (work, loaded, scene): (&Work, &Loaded, &Scene),
        picture: &Picture,
    ) -> Result<(), Failure> {
        for (number, &side) in (1..).zip(&self.sides) {
            let focus = self.focus.filter(|_| number > 1);
            let snapshot = self.seen.at(side, focus, picture);
            let file = work::place(&work::beside(&work.output, &number.to_string()), picture);
            work.save_to(&file, loaded, scene, &snapshot)?;
        }
        Ok(())
    }
}
