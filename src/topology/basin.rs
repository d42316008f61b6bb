//! Balls around minima that every path downhill ends in.
//!
//! Where the smallest eigenvalue of the Hessian in the middle of a ball exceeds `twist`, the field is convex in the
//! ball. If its minimum is there, the straight line to it from any point of the ball leads down: whoever enters the
//! ball has arrived. The largest such ball is found among sixteen, in one evaluation.

use super::matrix::eigen;
use super::point::CriticalPoint;
use super::search::{Balls, LANES};
use crate::num::mix;
use glam::DVec3;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A ball that holds a minimum.
#[derive(Clone, Copy, Debug)]
pub struct Basin {
    /// The middle.
    pub centre: DVec3,
    /// How far the basin is known to reach.
    pub radius: f64,
}

impl Basin {
    /// The largest ball around a minimum in which the field is proven to be convex.
    pub fn around(field: &mut Balls, point: &CriticalPoint, largest: f64) -> Basin {
        let is_convex = |h: [f64; 6], twist: f64| {
            let ([least, _, most], _) = eigen(h);
            least > twist + 1e-13 * most.abs()
        };
        let radius = widest(field, point.position, largest, is_convex);
        // The middle is off by no more than the error.
        Basin { centre: point.position, radius: (radius - 2.0 * point.error).max(0.0) }
    }
}

/// Batches of radii that are tried, each half as large as the one before: down to a millionth of a millionth.
const BATCHES: usize = 3;

/// The radius of the widest of many balls whose Hessian passes a test, given with its twist; 0 if none does.
pub fn widest(field: &mut Balls, at: DVec3, largest: f64, test: impl Fn([f64; 6], f64) -> bool) -> f64 {
    for first in (0..BATCHES).map(|batch| batch * LANES) {
        let radius = |i: usize| largest * libm::exp2(-((first + i) as f64));
        let balls = field.eval((0..LANES).map(|i| (at, radius(i))));
        let passes = |i: &usize| {
            let f = balls.lane(*i);
            test(f.hess, f.twist)
        };
        if let Some(i) = (0..LANES).find(passes) {
            return radius(i);
        }
    }
    0.0
}

/// Basins by where they are. Those of a size are in a grid of cells at least twice as wide, so that each is in eight
/// of them at most, and a point is in one cell of every size.
#[derive(Clone, Debug, Default)]
pub struct Basins {
    basins: Vec<Basin>,
    /// Sizes of cells that there are: one over their width.
    sizes: Vec<f64>,
    /// By hashes of cells. That two cells may have the same one is no harm: what is found is looked at.
    cells: HashMap<u64, Vec<u32>, BuildHasherDefault<Hashed>>,
    marks: Marks,
}

/// A bit for each of some hashes, by their last digits: that there is none like it can be told of most others from the
/// fastest memory.
#[derive(Clone, Debug, Default)]
struct Marks(Vec<u64>);

impl Marks {
    /// For the hashes of so many basins' cells, eight at most for each: a word for a basin, so that few others share their bits.
    fn new(basins: usize) -> Marks {
        Marks(vec![0; basins.next_power_of_two()])
    }

    fn place(&self, hash: u64) -> (usize, u64) {
        ((hash / 64) as usize & (self.0.len() - 1), 1 << (hash % 64))
    }

    fn set(&mut self, hash: u64) {
        let (word, bit) = self.place(hash);
        self.0[word] |= bit;
    }

    /// Whether one like this may be there.
    fn may_have(&self, hash: u64) -> bool {
        let (word, bit) = self.place(hash);
        self.0[word] & bit != 0
    }
}

/// Takes numbers that are hashes already.
#[derive(Clone, Copy, Debug, Default)]
struct Hashed(u64);

impl Hasher for Hashed {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.0 = mix(self.0 ^ u64::from(*b)));
    }
    fn write_u64(&mut self, hash: u64) {
        self.0 = hash;
    }
}

/// The largest whole number that is not above; the processor's own rounding is not to be had everywhere.
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(towards_zero as f64 > x)
}

/// The cell of a size that holds a point.
fn cell(inverse: f64, p: DVec3) -> [i64; 3] {
    (p * inverse).to_array().map(floor)
}

fn hash(inverse: f64, [x, y, z]: [i64; 3]) -> u64 {
    mix(mix(mix(inverse.to_bits() ^ x as u64) ^ y as u64) ^ z as u64)
}

impl Basins {
    /// From a list; their places in it are their names.
    pub fn new(basins: Vec<Basin>) -> Basins {
        let mut out = Basins { marks: Marks::new(basins.len()), ..Basins::default() };
        for (i, basin) in basins.iter().enumerate() {
            if basin.radius <= 0.0 {
                continue;
            }
            // Widths are powers of four.
            let inverse = libm::ldexp(1.0, -2 * (libm::ilogb(basin.radius).div_euclid(2) + 2));
            if !out.sizes.contains(&inverse) {
                out.sizes.push(inverse);
            }
            let [low, high] = [-basin.radius, basin.radius].map(|r| cell(inverse, basin.centre + r));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        let hash = hash(inverse, [x, y, z]);
                        out.marks.set(hash);
                        out.cells.entry(hash).or_default().push(i as u32);
                    }
                }
            }
        }
        out.basins = basins;
        out
    }

    /// The basin that holds a point.
    pub fn find(&self, p: DVec3) -> Option<usize> {
        let near = |&inverse: &f64| {
            let hash = hash(inverse, cell(inverse, p));
            if self.marks.may_have(hash) { self.cells.get(&hash) } else { None }
        };
        self.sizes.iter().filter_map(near).flatten().map(|&i| i as usize).find(|&i| {
            let Basin { centre, radius } = self.basins[i];
            p.distance_squared(centre) < radius * radius * (1.0 - 1e-12)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    #[test]
    fn a_basin_is_found_wherever_there_is_one() {
        let mut rng = StdRng::seed_from_u64(5);
        let mut point = || DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        // Of radii from a half down to a five hundredth, and one that is empty.
        let basins: Vec<Basin> = (0..300)
            .map(|i| Basin {
                centre: point(),
                radius: if i == 0 { 0.0 } else { 0.5 / f64::from(1 << (i % 9)) },
            })
            .collect();
        let all = Basins::new(basins.clone());
        let holds = |basin: &Basin, p: DVec3| p.distance(basin.centre) < basin.radius * (1.0 - 1e-9);
        let mut found = 0;
        for _ in 0..4000 {
            let p = point();
            match all.find(p) {
                Some(i) => assert!(p.distance(basins[i].centre) < basins[i].radius),
                None => assert!(!basins.iter().any(|basin| holds(basin, p)), "{p}"),
            }
            found += usize::from(all.find(p).is_some());
        }
        // Small ones are in the middle of themselves.
        for basin in basins.iter().filter(|basin| basin.radius > 0.0) {
            assert!(all.find(basin.centre).is_some());
        }
        assert!((400..3900).contains(&found), "{found}");
        assert!(Basins::new(Vec::new()).find(DVec3::ZERO).is_none());
    }
}
