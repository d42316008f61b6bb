//! How much of a cell is solid.
//!
//! Cells that the surface runs through are cut up once more, but nothing is asked of their parts than how much of
//! each is solid, so that they need neither a place in the tree nor neighbours. An expansion over a ball around a
//! part ([`Taylor`]) says that the surface runs between two parallel planes there, and how much of a box is below a
//! plane is known. The planes come together with the square of the size of the parts.

use super::super::cell::Cell;
use super::super::search::{Balls, LANES};
use super::Component;
use super::tree::{State, Tree};
use crate::num::{Interval, Taylor};
use crate::scene::Aabb;
use crate::tape::Cells;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Leaves that one thread takes at a time.
const SHARE: usize = 256;

/// A part is not cut of which the share that is solid is known so well.
const ENOUGH: f64 = 0.02;

/// Leaves that are smaller than this share of their coordinates are not measured: rounding moves them.
const BLUR: f64 = 1e6 * f64::EPSILON;

/// How much of something is solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Volume {
    /// Encloses it.
    pub range: Interval,
    /// An estimate.
    pub about: f64,
}

impl Volume {
    pub const NOTHING: Volume = Volume { range: Interval { lo: 0.0, hi: 0.0 }, about: 0.0 };

    /// Of both together.
    fn with(self, o: Volume) -> Volume {
        Volume { range: self.range + o.range, about: self.about + o.about }
    }
}

/// What cells measure together.
pub(super) struct Measure {
    bounds: Aabb,
    /// Of what is solid in them.
    pub volume: Volume,
    /// The largest full one, by its level and number, and its middle.
    heart: Option<((u8, u32), DVec3)>,
    /// Whether any is at the end of the region.
    cut: bool,
}

impl Default for Measure {
    fn default() -> Measure {
        let bounds = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        Measure { bounds, volume: Volume::NOTHING, heart: None, cut: false }
    }
}

impl Measure {
    pub fn add(&mut self, tree: &Tree, n: u32, volumes: &[Volume]) {
        let (cell, node) = (tree.cell(n), &tree.nodes[n as usize]);
        let is_full = node.known.state == State::In;
        let heart = is_full.then(|| ((node.level, n), 0.5 * (cell.min + cell.max)));
        let cut = (0..3).any(|axis| node.ends(axis, -1) || node.ends(axis, 1));
        self.include(&Measure { bounds: cell, volume: volumes[n as usize], heart, cut });
    }

    pub fn include(&mut self, o: &Measure) {
        self.bounds = self.bounds.hull(&o.bounds);
        self.volume = self.volume.with(o.volume);
        self.heart = match (self.heart, o.heart) {
            (Some(own), Some(other)) => Some(if other.0 < own.0 { other } else { own }),
            (own, other) => own.or(other),
        };
        self.cut |= o.cut;
    }

    pub fn component(&self, certified: bool) -> Component {
        let Volume { range, about } = self.volume;
        let volume = Interval::new(range.lo.max(0.0), range.hi);
        let inside = self.heart.map_or(DVec3::NAN, |heart| heart.1);
        Component { inside, bounds: self.bounds, volume, about, certified, cut: self.cut }
    }
}

/// The volumes of what is solid in leaves, in their order. Parts of them are as small as if the region were cut `fine`
/// times.
pub(super) fn volumes(
    cells: &Cells,
    tree: &Tree,
    leaves: &[u32],
    fine: u8,
    cancel: &AtomicBool,
) -> Vec<Volume> {
    let field = Balls::within(cells.tape(), &tree.region);
    let volumes = |field: &mut Balls, some: &[u32]| {
        let mut leaves = Leaves::new(tree, some, fine);
        leaves.measure(cells, field, cancel);
        leaves.volumes()
    };
    leaves.par_chunks(SHARE).map_init(|| field.clone(), volumes).collect::<Vec<_>>().concat()
}

/// Some leaves.
struct Leaves {
    boxes: Vec<Aabb>,
    /// The shares of them that are solid, at least, at most, and about, as far as they are added up.
    shares: Vec<[f64; 3]>,
    /// What is left to be measured, of each leaf.
    parts: Vec<Option<Part>>,
}

/// A part of a leaf.
#[derive(Clone, Copy)]
struct Part {
    /// Which leaf, and what share of it.
    leaf: usize,
    share: f64,
    cell: Cell,
    /// How often it may be cut.
    cuts: u8,
}

impl Leaves {
    fn new(tree: &Tree, leaves: &[u32], fine: u8) -> Leaves {
        let mut out = Leaves { boxes: Vec::new(), shares: Vec::new(), parts: Vec::new() };
        for (leaf, &n) in leaves.iter().enumerate() {
            let (node, bounds) = (&tree.nodes[n as usize], tree.cell(n));
            let cell =
                Cell { centre: 0.5 * (bounds.min + bounds.max), half: 0.5 * (bounds.max - bounds.min) };
            let is_sharp =
                cell.half.min_element() > BLUR * bounds.min.abs().max(bounds.max.abs()).max_element();
            let is_measured = node.known.state == State::Mixed && node.level <= fine && is_sharp;
            let part = Part { leaf, share: 1.0, cell, cuts: fine.saturating_sub(node.level) };
            out.boxes.push(bounds);
            out.parts.push(is_measured.then_some(part));
            out.shares.push(match node.known.state {
                State::In => [1.0; 3],
                State::Mixed if !is_measured => [0.0, 1.0, 0.5],
                State::Mixed | State::Out => [0.0; 3],
            });
        }
        out
    }

    /// Measures what there is to be measured.
    fn measure(&mut self, cells: &Cells, field: &mut Balls, cancel: &AtomicBool) {
        let parts: Vec<Part> = self.parts.drain(..).flatten().collect();
        let place = |(i, part): (usize, &Part)| (i, part.cell.centre.to_array(), part.cell.radius());
        let order = cells.tapes_around(parts.iter().enumerate().map(place));
        for same in order.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            field.turn_to(same[0].0);
            self.add_up(field, same.iter().map(|&(_, i)| parts[i]).collect(), cancel);
        }
    }

    /// Adds up the shares of parts that have one tape.
    fn add_up(&mut self, field: &mut Balls, mut parts: Vec<Part>, cancel: &AtomicBool) {
        while !(parts.is_empty() || cancel.load(Ordering::Relaxed)) {
            let batch = parts.split_off(parts.len().saturating_sub(LANES));
            let values = *field.eval(batch.iter().map(|part| (part.cell.centre, part.cell.radius())));
            for (i, part) in batch.into_iter().enumerate() {
                let f = values.lane(i);
                let [lo, hi, about] = match f.range.lo > 0.0 {
                    true => [0.0; 3],
                    // What is undefined is empty, and nothing follows from what is beside it.
                    false if !field.is_defined_around(part.cell.centre, part.cell.radius()) => unknown(&f),
                    false => share(&f, part.cell.half / part.cell.radius()),
                };
                if part.cuts > 0 && hi - lo > ENOUGH {
                    let pieces: Vec<Cell> = part.cell.parts().collect();
                    let share = part.share / pieces.len() as f64;
                    parts.extend(pieces.into_iter().map(|cell| Part {
                        share,
                        cell,
                        cuts: part.cuts - 1,
                        ..part
                    }));
                } else {
                    let sum = &mut self.shares[part.leaf];
                    [lo, hi, about].iter().zip(sum).for_each(|(share, sum)| *sum += part.share * share);
                }
            }
        }
    }

    fn volumes(&self) -> Vec<Volume> {
        let volume = |(cell, &[lo, hi, about]): (&Aabb, &[f64; 3])| {
            let side = |axis: usize| Interval::point(cell.max[axis]) - Interval::point(cell.min[axis]);
            // What adding them up has rounded away is far less.
            let share = Interval::new(lo - 1e-12 * lo, (hi + 1e-12 * hi).min(1.0));
            let whole = side(0) * side(1) * side(2);
            Volume { range: whole * share, about: whole.mid() * about }
        };
        self.boxes.iter().zip(&self.shares).map(volume).collect()
    }
}

/// How much of a box is solid, at least, at most, and about, of the field's expansion over a ball around it. `half` are half its
/// extents in units of the ball.
///
/// With `g . u` in place of the field, what is below `t` is a sum over the corners of the box, `s` of signs and
/// `a = |g| half` axis by axis:
///
/// ```text
/// sum over s of  s_x s_y s_z (t + s . a)_+^3  /  48 a_x a_y a_z
/// ```
fn share(f: &Taylor, half: DVec3) -> [f64; 3] {
    if f.range.hi < 0.0 {
        return [1.0; 3];
    }
    let own = DVec3::from_array(f.grad).abs() * half;
    // Thinner ones would cancel.
    let a = own.max(DVec3::splat(0.02 * own.max_element()));
    let (sum, extra) = (a.element_sum(), (a - own).element_sum());
    let bow = (bow(f, half) + extra + sum) * (1.0 + 1e-12) - sum;
    if !(sum > 0.0 && sum + bow + f.value.abs() < f64::INFINITY) {
        return unknown(f);
    }
    let below = |t: f64| {
        let t = t.clamp(-sum, sum);
        let corner = |i: usize| {
            let s = DVec3::from_array([0, 1, 2].map(|axis| if i >> axis & 1 == 0 { 1.0 } else { -1.0 }));
            let depth = (t + s.dot(a)).max(0.0);
            s.element_product() * (depth * depth * depth)
        };
        (0..8).map(corner).sum::<f64>() / (48.0 * a.element_product())
    };
    let (lo, hi) = (below(-f.value - bow) - 1e-9, below(bow - f.value) + 1e-9);
    // What is no number knows nothing.
    if lo <= hi {
        let (lo, hi) = (lo.max(0.0), hi.min(1.0));
        [lo, hi, below(-f.value).max(lo).min(hi)]
    } else {
        unknown(f)
    }
}

/// What is known of a box of which nothing is: likely all of it is like its middle.
fn unknown(f: &Taylor) -> [f64; 3] {
    [0.0, 1.0, if f.value < 0.0 { 1.0 } else { 0.0 }]
}

/// How far the field may be from its expansion to first order in a box.
fn bow(f: &Taylor, half: DVec3) -> f64 {
    let [xx, yy, zz, xy, xz, yz] = f.hess.map(f64::abs);
    let square = xx * half.x * half.x + yy * half.y * half.y + zz * half.z * half.z;
    let mixed = xy * half.x * half.y + xz * half.x * half.z + yz * half.y * half.z;
    let second = 0.5 * square + mixed + f.bow[1];
    if second < f.bow[0] { second } else { f.bow[0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An expansion with these factors, of which nothing is known beside them.
    fn expansion(value: f64, grad: [f64; 3], hess: [f64; 6], bow: [f64; 2]) -> Taylor {
        let range = Interval::new(f64::NEG_INFINITY, f64::INFINITY);
        Taylor { value, grad, hess, bow, turn: [f64::INFINITY; 2], twist: f64::INFINITY, range }
    }

    /// The share of places in a box where the expansion is below `-off`.
    fn sampled(f: &Taylor, half: DVec3, off: f64) -> f64 {
        let n = 40;
        let place = |i: usize| {
            let at = [i % n, i / n % n, i / n / n].map(|k| (2 * k + 1) as f64 / n as f64 - 1.0);
            half * DVec3::from_array(at)
        };
        let value = |u: DVec3| {
            let [xx, yy, zz, xy, xz, yz] = f.hess;
            let square = xx * u.x * u.x + yy * u.y * u.y + zz * u.z * u.z;
            let mixed = xy * u.x * u.y + xz * u.x * u.z + yz * u.y * u.z;
            f.value + DVec3::from_array(f.grad).dot(u) + 0.5 * square + mixed
        };
        (0..n * n * n).filter(|&i| value(place(i)) < -off).count() as f64 / (n * n * n) as f64
    }

    #[test]
    fn shares_hold_those_of_samples() {
        let half = DVec3::new(0.6, 0.55, 0.5);
        let mut random = 1_u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            2.0 * f64::from(random >> 8) / f64::from(1 << 24) - 1.0
        };
        for i in 0..120 {
            let thin = [1.0, 0.1, 1e-3, 0.0][i % 4];
            let bend = [0.0, 0.05, 0.5][i % 3];
            let grad = [next(), next() * thin, next()];
            let hess = std::array::from_fn(|_| bend * next());
            let off = 0.1 * bend;
            let f = expansion(0.5 * next(), grad, hess, [f64::INFINITY, off]);
            let [lo, hi, about] = share(&f, half);
            assert!((lo..=hi).contains(&about), "{f:?}: {lo} {about} {hi}");
            assert!((0.0..=1.0).contains(&lo) && (lo..=1.0).contains(&hi), "{lo} {hi}");
            // Samples miss what is next to the surface.
            let slack = 0.03;
            let samples = [sampled(&f, half, off), sampled(&f, half, -off)];
            assert!(lo <= samples[0] + slack && samples[1] - slack <= hi, "{f:?}: {lo} {hi} {samples:?}");
            if bend == 0.0 && thin > 0.01 {
                let most = if thin == 1.0 { 0.1 } else { 0.2 };
                assert!(hi - lo < most, "{f:?}: {lo} {hi}");
            }
        }
        // A plane through the middle parts the box in halves.
        let [lo, hi, _] = share(&expansion(0.0, [1.0, 1.0, 1.0], [0.0; 6], [0.0; 2]), half);
        assert!((lo - 0.5).abs() < 1e-8 && (hi - 0.5).abs() < 1e-8, "{lo} {hi}");
    }

    #[test]
    fn what_is_no_number_knows_nothing() {
        for strange in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for f in [
                expansion(strange, [1.0; 3], [0.0; 6], [0.0; 2]),
                expansion(-1.0, [strange, 1.0, 0.0], [0.0; 6], [0.0; 2]),
                expansion(-1.0, [1.0; 3], [0.0; 6], [strange.abs(); 2]),
                expansion(-1.0, [0.0; 3], [0.0; 6], [0.0; 2]),
            ] {
                assert_eq!(share(&f, DVec3::splat(0.5))[..2], [0.0, 1.0], "{f:?}");
            }
        }
    }
}
