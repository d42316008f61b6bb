//! Something about each of many cells of a grid that are next to one another.
//!
//! Floods ask about a cell and all that touch it, again and again. So cells are kept in bricks of four along each axis, each
//! of which is one entry of a table; and the bricks that were used last are at hand.

use super::grid::Voxel;
use ahash::RandomState;
use std::collections::HashMap;

/// Cells along an edge of a brick, as a power of two.
const EDGE: u32 = 2;

/// Cells of a brick.
pub const COUNT: usize = 1 << (3 * EDGE);

/// Which brick.
pub type Name = [i64; 3];

/// The brick of a cell.
pub fn name(Voxel(at): Voxel) -> Name {
    at.map(|i| i >> EDGE)
}

/// A value for every cell of a grid, most of which have none yet: that of [`Default`]. Of each brick something more may be
/// known.
#[derive(Clone, Debug)]
pub struct Bricks<T, H = ()> {
    numbers: HashMap<Name, usize, RandomState>,
    bricks: Vec<Brick<T, H>>,
    /// The numbers of those that were used last.
    recent: [usize; COUNT],
}

#[derive(Clone, Debug)]
struct Brick<T, H> {
    name: Name,
    cells: [T; COUNT],
    head: H,
}

impl<T: Copy + Default, H: Default> Bricks<T, H> {
    /// Without any brick.
    pub fn new() -> Bricks<T, H> {
        Bricks { numbers: HashMap::default(), bricks: Vec::new(), recent: [0; COUNT] }
    }

    /// How many bricks there are.
    pub fn len(&self) -> usize {
        self.bricks.len()
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.numbers.clear();
        self.bricks.clear();
    }

    /// What is known of a cell, to be changed.
    pub fn at(&mut self, voxel: Voxel) -> &mut T {
        &mut self.brick(voxel).cells[place(voxel)]
    }

    /// What is known of the brick of a cell, to be changed.
    pub fn head(&mut self, voxel: Voxel) -> &mut H {
        &mut self.brick(voxel).head
    }

    fn brick(&mut self, voxel: Voxel) -> &mut Brick<T, H> {
        let name = name(voxel);
        let recent = &mut self.recent[place(Voxel(name))];
        if self.bricks.get(*recent).is_none_or(|brick| brick.name != name) {
            let bricks = &mut self.bricks;
            *recent = *self.numbers.entry(name).or_insert_with(|| {
                bricks.push(Brick { name, cells: [T::default(); COUNT], head: H::default() });
                bricks.len() - 1
            });
        }
        &mut self.bricks[*recent]
    }

    /// What is known of a cell.
    pub fn get(&self, voxel: Voxel) -> T {
        let name = name(voxel);
        let recent = self.bricks.get(self.recent[place(Voxel(name))]).filter(|brick| brick.name == name);
        let brick = recent.or_else(|| self.numbers.get(&name).map(|&number| &self.bricks[number]));
        brick.map_or_else(T::default, |brick| brick.cells[place(voxel)])
    }

    /// All cells of all bricks, those of one after those of another.
    pub fn all(&self) -> impl Iterator<Item = (Voxel, T)> + '_ {
        self.bricks.iter().flat_map(|Brick { name, cells, .. }| {
            cells.iter().enumerate().map(|(i, cell)| {
                let within = |axis: u32| (i >> (axis * EDGE)) as i64 & ((1 << EDGE) - 1);
                (Voxel([0, 1, 2].map(|axis| (name[axis as usize] << EDGE) + within(axis))), *cell)
            })
        })
    }
}

/// Where a cell is in its brick.
pub fn place(Voxel(at): Voxel) -> usize {
    let within = |i: i64| (i & ((1 << EDGE) - 1)) as usize;
    within(at[0]) + (within(at[1]) << EDGE) + (within(at[2]) << (2 * EDGE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_has_a_value_of_its_own() {
        let mut bricks = Bricks::<i64, u8>::new();
        let cells = || (0..1000_i64).map(|i| Voxel([i % 10 - 5, i / 10 % 10 - 3, i / 100 + (1 << 40)]));
        let number = |voxel: Voxel| 1 + voxel.0[0] + 100 * voxel.0[1] + 10_000 * voxel.0[2];
        cells().for_each(|voxel| *bricks.at(voxel) = number(voxel));
        assert!(cells().all(|voxel| bricks.get(voxel) == number(voxel)));
        cells().for_each(|voxel| *bricks.head(voxel) += 1);
        let heads: u32 = bricks.bricks.iter().map(|brick| u32::from(brick.head)).sum();
        assert_eq!((heads, *bricks.head(Voxel([0, 0, 1 << 40]))), (1000, 64));
        let told: Vec<(Voxel, i64)> = bricks.all().filter(|(_, n)| *n != 0).collect();
        assert_eq!(told.len(), 1000);
        assert!(told.into_iter().all(|(voxel, n)| n == number(voxel)));
        assert_eq!(bricks.get(Voxel([100, 0, 0])), 0);
        bricks.clear();
        assert_eq!((bricks.get(Voxel([0, 0, 1 << 40])), bricks.all().count()), (0, 0));
    }
}
