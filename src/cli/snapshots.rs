//! `--snapshots`: pictures of a picture on its way.

use super::report::Failure;
use super::work::Work;
use crate::render::{Picture, Snapshots, Steering};
use crate::scene::Scene;
use crate::session::Loaded;
use std::path::{Path, PathBuf};
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

impl Sides {
    /// Steers towards them.
    pub fn steering(&self) -> Steering {
        self.0.last().map_or_else(Steering::default, |&finest| Steering::down_to(finest))
    }

    /// Saves a picture for each side, numbered.
    pub fn save(
        &self,
        snapshots: &Snapshots,
        (work, loaded, scene): (&Work, &Loaded, &Scene),
        picture: &Picture,
    ) -> Result<(), Failure> {
        for (number, &side) in (1..).zip(&self.0) {
            work.save_to(&numbered(&work.output, number), loaded, scene, &snapshots.at(side, picture))?;
        }
        Ok(())
    }
}

/// `a.3.png` for `a.png`.
fn numbered(output: &Path, number: usize) -> PathBuf {
    let ending = output.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    output.with_extension(format!("{number}{ending}"))
}
