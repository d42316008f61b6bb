//! Ways down out of a cell.
//!
//! The directions in which a field is proven to fall everywhere in a cell are a convex cone: what falls along two
//! directions falls along all between. If they have parts of opposite sign along an axis, then one between them has no
//! part along it, leaves the cell by fewer faces, and serves better. So of each set of axes there need be but one choice of
//! signs, and none of a set that holds another with a choice: at most the three axes, or else what goes across them.

/// The signs of directions in which a field falls, one at most for each set of axes: four bits a set, of which the first
/// says that there is one, the others that it goes down the axes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Ways(u32);

impl Ways {
    /// No direction.
    pub const NONE: Ways = Ways(0);

    /// Sets of axes.
    pub const SETS: usize = 7;

    /// Adds a direction, with -1 and 1 along the axes that it goes down and up.
    pub fn add(&mut self, direction: [i8; 3]) {
        let mask =
            |is: fn(i8) -> bool| (0..3).map(|axis| u32::from(is(direction[axis])) << axis).sum::<u32>();
        let (axes, down) = (mask(|sign| sign != 0), mask(|sign| sign < 0));
        if axes != 0 {
            let place = 4 * (axes - 1);
            self.0 = self.0 & !(15 << place) | (1 | down << 1) << place;
        }
    }

    /// The direction across a set of axes, if there is one.
    pub fn of(self, set: usize) -> Option<[i8; 3]> {
        let bits = self.0 >> (4 * set);
        let axes = set + 1;
        let sign = |axis: usize| if bits >> (axis + 1) & 1 == 1 { -1 } else { 1 };
        (bits & 1 == 1)
            .then(|| std::array::from_fn(|axis| if axes >> axis & 1 == 1 { sign(axis) } else { 0 }))
    }

    /// All directions.
    pub fn all(self) -> impl Iterator<Item = [i8; 3]> {
        (0..Ways::SETS).filter_map(move |set| self.of(set))
    }

    /// Whether a direction along some of these axes alone is known.
    pub fn serve(self, axes: [bool; 3]) -> bool {
        self.all().any(|direction| (0..3).all(|axis| axes[axis] || direction[axis] == 0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_those_that_were_added() {
        let signs = [-1, 0, 1];
        for first in signs.iter().flat_map(|x| signs.iter().flat_map(|y| signs.map(|z| [*x, *y, z]))) {
            let mut ways = Ways::NONE;
            ways.add(first);
            assert_eq!(ways.all().collect::<Vec<_>>(), if first == [0; 3] { vec![] } else { vec![first] });
            // Another along the same axes takes its place, one along others stands beside it.
            ways.add(first.map(|sign| -sign));
            ways.add([1, 0, 0]);
            let is_x = first[0] != 0 && first[1..] == [0; 2];
            let mut both = vec![[1, 0, 0]];
            both.extend((first != [0; 3] && !is_x).then(|| first.map(|sign| -sign)));
            both.sort_unstable();
            let mut all: Vec<_> = ways.all().collect();
            all.sort_unstable();
            assert_eq!(all, both);
            assert!(ways.serve([true, false, false]) && !ways.serve([false; 3]));
        }
    }
}
