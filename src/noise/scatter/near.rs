//! Sums of spots at one point, and bounds in a ball around it: the lanes are cells, then nodes.

use super::{BEYOND, Draw, Node, Scatter, Spot};
use crate::noise::bulk::{GRADIENT, HESSIAN, VALUE};
use crate::noise::lattice::{Lattice, STEP, split};
use crate::num::{Bounds, Local, Order, Point, widest};

/// Most cells that spots of nodes in reach of a ball can lie in: four along an axis.
const CELLS: usize = 64;

/// Largest radius of a ball whose nodes are looked at one by one.
pub(super) const LARGEST: f64 = 0.5;

/// The cells in reach of a ball, in the order of their numbers.
struct Cells {
    count: usize,
    words: [u32; CELLS],
    reach: [[f64; CELLS]; 3],
    /// Zero, or NaN where there is no place.
    start: f64,
}

/// What one axis knows of the cells along it.
#[derive(Clone, Copy, Default)]
struct Step {
    word: u32,
    reach: f64,
    /// Square of the distance along the axis.
    distance: f64,
}

impl Cells {
    #[inline(always)]
    fn around(draw: &Draw, lattice: &Lattice, at: [f64; 3], radius: f64) -> Cells {
        let places = at.map(split);
        let start = 0.0 * (places[0].1 * places[0].1 + places[1].1 * places[1].1 + places[2].1 * places[2].1);
        // Padding is out of reach.
        let mut cells = Cells { count: 0, words: [0; CELLS], reach: [[8.0; CELLS]; 3], start };
        let limit = (1.0 + radius) * (1.0 + radius) * BEYOND;
        let along = |axis: usize| {
            let (cell, t) = places[axis];
            let mut steps = [Step::default(); 5];
            for (i, step) in steps.iter_mut().enumerate() {
                let reach = t - (i as f64 - 2.0) - draw.margin;
                let word = lattice.wrap(axis, cell.wrapping_add(i as u32).wrapping_sub(2));
                *step = Step { word: word.wrapping_mul(STEP[axis]), reach, distance: draw.distance(reach) };
            }
            steps
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        for w in z.iter().filter(|w| w.distance < limit) {
            for v in y.iter().filter(|v| v.distance + w.distance < limit) {
                for u in &x {
                    if u.distance + (v.distance + w.distance) < limit && cells.count < CELLS {
                        let n = cells.count;
                        cells.words[n] = u.word ^ v.word ^ w.word;
                        cells.reach[0][n] = u.reach;
                        cells.reach[1][n] = v.reach;
                        cells.reach[2][n] = w.reach;
                        cells.count = n + 1;
                    }
                }
            }
        }
        cells
    }
}

/// Nodes a step of a single point, as lanes.
pub(super) const LANES: usize = 8;

/// The nodes in reach of a ball, of one number in all cells. Most cells in reach have theirs somewhere else.
struct Near {
    count: usize,
    d: [[f64; CELLS]; 3],
    weight: [f64; CELLS],
    word: [u32; CELLS],
}

impl Near {
    #[inline(always)]
    fn of(draw: &Draw, cells: &Cells, slot: usize, radius: f64) -> Near {
        // Padding is out of reach.
        let mut near = Near { count: 0, d: [[8.0; CELLS]; 3], weight: [0.0; CELLS], word: [0; CELLS] };
        let limit = (1.0 + radius) * (1.0 + radius) * BEYOND;
        for first in (0..cells.count).step_by(LANES) {
            let (mut d, mut weight, mut word) = ([[0.0; LANES]; 3], [0.0; LANES], [0; LANES]);
            let mut close = [false; LANES];
            for i in 0..LANES {
                let reach = [0, 1, 2].map(|axis| cells.reach[axis][first + i]);
                let node = draw.node(cells.words[first + i], slot, reach);
                let [x, y, z] = node.d;
                for axis in 0..3 {
                    d[axis][i] = node.d[axis];
                }
                weight[i] = node.weight;
                word[i] = node.word;
                close[i] = x * x + y * y + z * z < limit;
            }
            if let Some(tail) = draw.tail {
                for i in 0..LANES {
                    close[i] &= draw.count(cells.words[first + i]) < tail[slot];
                }
            }
            for i in 0..LANES.min(cells.count - first) {
                let n = near.count;
                for axis in 0..3 {
                    near.d[axis][n] = d[axis][i];
                }
                near.weight[n] = weight[i];
                near.word[n] = word[i];
                near.count = n + usize::from(close[i]);
            }
        }
        // The last that was stored may be out of reach.
        if near.count < CELLS {
            near.weight[near.count] = 0.0;
        }
        near
    }
}

/// Parts of what is summed up: value, gradient and Hessian, then bounds on the derivatives of order 0 to 3.
pub(super) const PARTS: usize = 14;

/// Sums over the nodes of some cells: the jet at the centre, and bounds on the derivatives of order 0
/// to 3 within `radius` of it if that is asked for.
#[inline(always)]
fn sums<const ORDER: u8, const SIZES: bool, S: Spot>(
    draw: &Draw,
    spot: &S,
    cells: &Cells,
    radius: f64,
) -> [f64; PARTS] {
    let mut sum = [0.0; PARTS];
    sum[..[1, 4, 10][usize::from(ORDER)]].fill(cells.start);
    for slot in 0..draw.slots {
        let near = Near::of(draw, cells, slot, radius);
        for first in (0..near.count).step_by(LANES) {
            let nodes = Nodes {
                d: near.d.each_ref().map(|d| part(d, first)),
                weight: part(&near.weight, first),
                word: part(&near.word, first),
            };
            add::<ORDER, SIZES, S>(spot, &nodes, near.count - first, radius, &mut sum);
        }
    }
    sum
}

/// A few of many.
#[inline(always)]
fn part<T: Copy + Default>(all: &[T; CELLS], first: usize) -> [T; LANES] {
    std::array::from_fn(|i| all[first + i])
}

/// Nodes as lanes.
pub(super) struct Nodes {
    pub d: [[f64; LANES]; 3],
    pub weight: [f64; LANES],
    pub word: [u32; LANES],
}

/// Adds what the first `count` of some nodes contribute, one after the other, so that nodes out of reach in between make
/// no difference.
#[inline(always)]
fn add<const ORDER: u8, const SIZES: bool, S: Spot>(
    spot: &S,
    nodes: &Nodes,
    count: usize,
    radius: f64,
    sum: &mut [f64; PARTS],
) {
    let terms = terms::<ORDER, SIZES, S>(spot, nodes, &[radius; LANES]);
    let parts = [1, 4, 10][usize::from(ORDER)];
    for i in 0..LANES.min(count) {
        for k in (0..parts).chain(if SIZES { 10..PARTS } else { 0..0 }) {
            sum[k] += terms[k][i];
        }
    }
}

/// What each node contributes, with a radius of its own. The compiler vectorises the loop.
#[inline(always)]
pub(super) fn terms<const ORDER: u8, const SIZES: bool, S: Spot>(
    spot: &S,
    nodes: &Nodes,
    radius: &[f64; LANES],
) -> [[f64; LANES]; PARTS] {
    let mut terms = [[0.0; LANES]; PARTS];
    for i in 0..LANES {
        let d = [nodes.d[0][i], nodes.d[1][i], nodes.d[2][i]];
        let node = Node { d, weight: nodes.weight[i], word: nodes.word[i] };
        let p = spot.jet::<ORDER>(&node);
        terms[0][i] = p.value;
        if ORDER >= GRADIENT {
            for k in 0..3 {
                terms[1 + k][i] = p.grad[k];
            }
        }
        if ORDER >= HESSIAN {
            for k in 0..6 {
                terms[4 + k][i] = p.hess[k];
            }
        }
        if SIZES {
            let [x, y, z] = d;
            let (r, radius) = ((x * x + y * y + z * z).sqrt(), radius[i]);
            let close = if r > radius { r - radius } else { 0.0 };
            let weight = node.weight.abs();
            let counts = close < 1.0 && weight > 0.0;
            let own = spot.sizes(if counts { close } else { 0.0 }, r + radius);
            for k in 0..4 {
                terms[10 + k][i] = if counts { weight * own[k] } else { 0.0 };
            }
        }
    }
    terms
}

/// The jet of sums.
#[inline(always)]
fn jet_of([value, x, y, z, xx, yy, zz, xy, xz, yz, ..]: [f64; PARTS]) -> Point {
    Point { value, grad: [x, y, z], hess: [xx, yy, zz, xy, xz, yz] }
}

/// [`Basis::jet`](crate::noise::Basis::jet) for spots.
pub(in crate::noise) fn jet<S: Spot>(
    scatter: &Scatter,
    spot: &S,
    lattice: &Lattice,
    order: Order,
    at: [f64; 3],
) -> Point {
    let draw = scatter.draw(lattice);
    widest(
        #[inline(always)]
        || {
            let cells = Cells::around(&draw, lattice, at, 0.0);
            match order {
                Order::Value => jet_of(sums::<VALUE, false, S>(&draw, spot, &cells, 0.0)),
                Order::Gradient => jet_of(sums::<GRADIENT, false, S>(&draw, spot, &cells, 0.0)),
                Order::Hessian => jet_of(sums::<HESSIAN, false, S>(&draw, spot, &cells, 0.0)),
            }
        },
    )
}

/// [`Basis::local`](crate::noise::Basis::local) for spots, from the global bounds and the rounding of jets.
pub(in crate::noise) fn local<S: Spot>(
    scatter: &Scatter,
    spot: &S,
    lattice: &Lattice,
    (order, at, radius): (Order, [f64; 3], f64),
    global: Bounds,
    rounding: [f64; 3],
) -> Local {
    let wide = widened(radius);
    if wide > LARGEST || wide.is_nan() {
        return Local::uniform(jet(scatter, spot, lattice, order, at), global);
    }
    let draw = scatter.draw(lattice);
    let sums = widest(
        #[inline(always)]
        || {
            let cells = Cells::around(&draw, lattice, at, wide);
            sums::<HESSIAN, true, S>(&draw, spot, &cells, wide)
        },
    );
    known(sums, limits(&sums, wide, global, rounding), global)
}

/// Rounding moves a node by less than 1e-14, and sums by less than a part in 1e12.
pub(super) fn widened(radius: f64) -> f64 {
    radius * (1.0 + 1e-12) + 1e-14
}

/// What the sums of a ball tell, and the bounds that follow from them.
pub(super) fn known(sums: [f64; PARTS], bounds: Bounds, global: Bounds) -> Local {
    let jet = jet_of(sums);
    Local::uniform(jet, if jet.value.is_finite() { bounds } else { global })
}

/// Covers the rounding of bounds.
#[inline(always)]
fn up(bound: f64) -> f64 {
    bound * (1.0 + 1e-9) + 1e-9
}

#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Bounds in a ball, from its sums.
#[inline(always)]
pub(super) fn limits(sums: &[f64; PARTS], wide: f64, global: Bounds, rounding: [f64; 3]) -> Bounds {
    let [value, x, y, z, xx, yy, zz, xy, xz, yz, sizes @ ..] = *sums;
    // The Frobenius norm of the Hessian at the centre, and what can be gained on the way.
    let squares = xx * xx + yy * yy + zz * zz + xy * xy + xy * xy + xz * xz + xz * xz + yz * yz + yz * yz;
    let third = least(up(sizes[3]), global.third);
    let bent = squares.sqrt() + 9.0 * rounding[2] + third * wide;
    let hessian = least(least(up(sizes[2]), up(bent)), global.hessian);
    let steep = (x * x + y * y + z * z).sqrt() + 3.0 * rounding[1] + hessian * wide;
    let lipschitz = least(least(up(sizes[1]), up(steep)), global.lipschitz);
    let far = value.abs() + rounding[0] + lipschitz * wide;
    let range = least(least(up(sizes[0]), up(far)), global.range);
    Bounds { range, lipschitz, hessian, third }
}

#[cfg(test)]
mod tests {
    use super::super::{Draw, Placement, Scatter};
    use crate::noise::lattice::{Lattice, STEP};
    use crate::noise::tests::Random;
    use crate::noise::{Kind, Noise, Setting, Settings};
    use crate::num::{Kernel, Order};

    /// A number of two parts, good to some 30 digits.
    #[derive(Clone, Copy)]
    struct Two(f64, f64);

    impl Two {
        fn plus(self, o: Two) -> Two {
            let s = self.0 + o.0;
            let v = s - self.0;
            let e = (self.0 - (s - v)) + (o.0 - v) + (self.1 + o.1);
            Two(s + e, e - ((s + e) - s))
        }

        fn times(self, o: Two) -> Two {
            let p = self.0 * o.0;
            let e = self.0.mul_add(o.0, -p) + (self.0 * o.1 + self.1 * o.0);
            Two(p + e, e - ((p + e) - p))
        }

        fn by(self, k: f64) -> Two {
            self.times(Two(k, 0.0))
        }

        fn root(self) -> Two {
            let y = self.0.sqrt();
            let rest = self.plus(Two(y, 0.0).times(Two(-y, 0.0)));
            Two(y, 0.0).plus(Two((rest.0 + rest.1) / (2.0 * y), 0.0))
        }
    }

    const ONE: Two = Two(1.0, 0.0);

    /// Value and derivative along x of the quintic's noise at a point, all nodes looked at.
    fn reference(draw: &Draw, nodes: usize, at: [f64; 3]) -> [Two; 2] {
        let mut sum = [Two(0.0, 0.0); 2];
        for c in 0..27 {
            let cell = [0, 1, 2].map(|i| at[i].floor() as i32 + [c % 3, c / 3 % 3, c / 9][i] - 1);
            let word = (0..3).fold(0, |w, i| w ^ (cell[i] as u32).wrapping_mul(STEP[i]));
            for slot in 0..nodes {
                // Seen from the corner of the cell the offset is exact.
                let node = draw.node(word, slot, [0.0; 3]);
                let d = [0, 1, 2]
                    .map(|i| Two(at[i], 0.0).plus(Two(-f64::from(cell[i]), 0.0)).plus(Two(node.d[i], 0.0)));
                let r = d.iter().fold(Two(0.0, 0.0), |r, d| r.plus(d.times(*d))).root();
                if r.0 < 1.0 {
                    let q = ONE.plus(r.by(-1.0));
                    let h = q.times(q).times(q).times(ONE.plus(r.times(r.by(6.0).plus(Two(3.0, 0.0)))));
                    sum[0] = sum[0].plus(h.by(node.weight));
                    sum[1] = sum[1].plus(r.times(q).times(q).times(d[0]).by(-30.0).by(node.weight));
                }
            }
        }
        sum
    }

    #[test]
    fn rounding_is_as_budgeted() {
        let listing = Kind::ALL.iter().find(|l| l.name == "sparse").unwrap();
        let mut settings = Settings::new(listing.parameters);
        settings.set("nodes", Setting::Number(3.0)).unwrap();
        let noise = Noise::new((listing.build)(&settings), 17);
        let draw = Scatter { nodes: 3, placement: Placement::Uniform, bell: true }.draw(&Lattice::new(17));
        let mut random = Random::new(41);
        let budget = noise.error(0.0);
        let mut worst = [0.0_f64; 2];
        for i in 0..20_000 {
            let p = random.point([1.0, 30.0, 1e6][i % 3]);
            let jet = noise.jet(Order::Gradient, p);
            for (k, (found, exact)) in
                [jet.value, jet.grad[0]].into_iter().zip(reference(&draw, 3, p)).enumerate()
            {
                worst[k] = worst[k].max(((found - exact.0) - exact.1).abs() / budget[k]);
            }
        }
        assert!(worst.iter().all(|w| (1e-4..0.5).contains(w)), "{worst:?}");
    }
}
