//! Hydraulic erosion: rain runs downhill, wears the ground away where it is fast and drops what it
//! carries where it slows down (after Musgrave, Kolb and Mace 1989, with drops as in Beyer 2015).
//!
//! A drop falls on a random place and follows the slope, with some inertia, one sample a step. Heights
//! are measured in units of the spacing. After a step down by `d`:
//!
//! ```text
//! it can carry   c = capacity max(d, least) v w                 with speed v and water w
//! s > c:  it drops  deposition (s - c)                          where it was
//! s < c:  it takes  min(erosion (c - s), d)                     from around where it was, as far as
//!                                                               that is higher than where it is
//! v^2  <-  drag v^2 + gravity d                                 w  <-  (1 - evaporation) w
//! ```
//!
//! Where its way leads up, it is in a pit, and fills that with what it has. Material only moves:
//! what is taken is carried, and what a drop still carries at its end stays there. So on a surface
//! that repeats mass is conserved up to rounding. Over the edge of one that does not, drops leave with
//! what they carry.
//!
//! Drops fall in showers. All drops of a shower see the ground as it was before, so they run on as
//! many threads as there are, each with its own changes alone before its eyes; those are applied to
//! the ground in the order of the drops' numbers.
//! The result is the same bit for bit however many threads took part.

use super::random::key;
use super::{Cancel, Edge, Failure, Frame, Samples};
use crate::num::{mix, uniform};
use rayon::prelude::*;

/// Rain, and what it does.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Rain {
    /// Names the drops.
    pub seed: u64,
    /// Drops a sample.
    pub drops: f64,
    /// Steps after which a drop has run its course.
    pub steps: u32,
    /// Share of the water that goes into the air at each step.
    pub evaporation: f64,
    /// How much a drop can carry.
    pub capacity: f64,
    /// Share of what it can still carry that it takes at each step.
    pub erosion: f64,
    /// Share of what it cannot carry that it drops.
    pub deposition: f64,
    /// How far it goes on in its old direction: 0 follows the slope, near 1 hardly turns.
    pub inertia: f64,
    /// Radius in samples around a drop from which it takes.
    pub brush: f64,
}

impl Default for Rain {
    fn default() -> Self {
        Rain {
            seed: 1,
            drops: 1.0,
            steps: 64,
            evaporation: 0.02,
            capacity: 4.0,
            erosion: 0.3,
            deposition: 0.3,
            inertia: 0.05,
            brush: 2.0,
        }
    }
}

/// Slope with which even a drop on a plain carries something.
const LEAST_SLOPE: f64 = 0.01;
/// Share of the square of its speed that a drop keeps.
const DRAG: f64 = 0.9;
/// What a fall by one spacing adds to the square of the speed: on a slope of 45 degrees a drop
/// reaches twice the speed of a walker's pace, 1, at which it starts.
const GRAVITY: f64 = 0.4;

/// Share of a pit that a drop fills at most: those of the same shower may be on their way to it.
const FILL: f64 = 0.5;

/// A change of one sample.
type Change = (usize, f64);

/// The ground that a shower falls on.
struct Ground<'a> {
    frame: Frame,
    /// In units of the spacing.
    heights: &'a [f64],
    /// What the drop that is on its way has changed; zero when none is.
    own: &'a mut [f64],
    /// Samples around a drop and the shares of what it takes that come from them.
    brush: &'a [(isize, isize, f64)],
}

/// A place between samples: the cell and the position in it.
#[derive(Clone, Copy)]
struct Place {
    corners: [usize; 4],
    weights: [f64; 4],
    s: f64,
    t: f64,
}

impl Ground<'_> {
    /// The cell at a place; `None` beyond the edge.
    fn place(&self, [x, z]: [f64; 2]) -> Option<Place> {
        let [nx, _, nz] = self.frame.size;
        if self.frame.edge == Edge::Clamp
            && !(x >= 0.0 && z >= 0.0 && x < (nx - 1) as f64 && z < (nz - 1) as f64)
        {
            return None;
        }
        let (i, j) = (x.floor(), z.floor());
        let (s, t) = (x - i, z - j);
        // `place` is only asked for coordinates within the surface.
        let (i, j) = ((i as usize).min(nx - 1), (j as usize).min(nz - 1));
        let (i1, j1) = (self.frame.neighbour(i, 1, nx), self.frame.neighbour(j, 1, nz));
        Some(Place {
            corners: [j * nx + i, j * nx + i1, j1 * nx + i, j1 * nx + i1],
            weights: [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t],
            s,
            t,
        })
    }

    #[inline]
    fn sample(&self, i: usize) -> f64 {
        self.heights[i] + self.own[i]
    }

    fn height(&self, p: &Place) -> f64 {
        (0..4).map(|k| p.weights[k] * self.sample(p.corners[k])).sum()
    }

    fn slope(&self, p: &Place) -> [f64; 2] {
        let [a, b, c, d] = p.corners.map(|i| self.sample(i));
        [(b - a) * (1.0 - p.t) + (d - c) * p.t, (c - a) * (1.0 - p.s) + (d - b) * p.s]
    }

    /// A place that has left one side of a surface that repeats, on its other side.
    fn wrapped(&self, at: [f64; 2]) -> [f64; 2] {
        let [nx, _, nz] = self.frame.size;
        if self.frame.edge == Edge::Clamp {
            return at;
        }
        let wrap = |v: f64, n: usize| {
            let size = n as f64;
            let v = v - size * (v / size).floor();
            if v < size { v } else { 0.0 }
        };
        [wrap(at[0], nx), wrap(at[1], nz)]
    }

    fn change(&mut self, i: usize, amount: f64, changes: &mut Vec<Change>) {
        self.own[i] += amount;
        changes.push((i, amount));
    }

    /// Spreads what is dropped over the corners of its cell.
    fn drop_at(&mut self, p: &Place, amount: f64, changes: &mut Vec<Change>) {
        for k in 0..4 {
            self.change(p.corners[k], amount * p.weights[k], changes);
        }
    }

    /// Takes from around a place, but nothing from below a floor. Returns how much.
    fn take_at(&mut self, p: &Place, amount: f64, floor: f64, changes: &mut Vec<Change>) -> f64 {
        let [nx, _, nz] = self.frame.size;
        let nearest = p.corners[usize::from(p.s >= 0.5) + 2 * usize::from(p.t >= 0.5)];
        let (x, z) = (nearest % nx, nearest / nx);
        let mut taken = 0.0;
        for &(dx, dz, share) in self.brush {
            let at = self.frame.neighbour(z, dz, nz) * nx + self.frame.neighbour(x, dx, nx);
            let part = (amount * share).min(self.sample(at) - floor);
            if part > 0.0 {
                self.change(at, -part, changes);
                taken += part;
            }
        }
        taken
    }

    /// The way of one drop, as what it changes.
    fn drop(&mut self, rain: &Rain, number: u64) -> Vec<Change> {
        let mut changes = Vec::new();
        self.run(rain, number, &mut changes);
        for (i, _) in &changes {
            self.own[*i] = 0.0;
        }
        changes
    }

    fn run(&mut self, rain: &Rain, number: u64, changes: &mut Vec<Change>) {
        let [nx, _, nz] = self.frame.size;
        let hash = key(rain.seed, [number as i64]);
        let gaps = |n: usize| if self.frame.edge == Edge::Repeat { n } else { n - 1 } as f64;
        let mut at = [uniform(mix(hash)) * gaps(nx), uniform(mix(hash ^ 1)) * gaps(nz)];
        let mut heading = [0.0; 2];
        let (mut square_speed, mut water, mut load) = (1.0_f64, 1.0, 0.0);
        let Some(mut here) = self.place(at) else { return };
        for _ in 0..rain.steps {
            let slope = self.slope(&here);
            let turned: [f64; 2] =
                std::array::from_fn(|k| heading[k] * rain.inertia - slope[k] * (1.0 - rain.inertia));
            let length = (turned[0] * turned[0] + turned[1] * turned[1]).sqrt();
            if length < 1e-12 {
                break;
            }
            heading = turned.map(|v| v / length);
            at = self.wrapped([at[0] + heading[0], at[1] + heading[1]]);
            let Some(next) = self.place(at) else { return };
            let floor = self.height(&next);
            let down = self.height(&here) - floor;
            let carries = rain.capacity * down.max(LEAST_SLOPE) * square_speed.sqrt() * water;
            if down < 0.0 || load > carries {
                // Up: as much as fills the pit. Down: a share of what is too much.
                let amount =
                    if down < 0.0 { load.min(-FILL * down) } else { (load - carries) * rain.deposition };
                load -= amount;
                self.drop_at(&here, amount, changes);
            } else {
                let amount = ((carries - load) * rain.erosion).min(down);
                load += self.take_at(&here, amount, floor, changes);
            }
            square_speed = DRAG * square_speed + GRAVITY * down.max(0.0);
            water *= 1.0 - rain.evaporation;
            here = next;
        }
        self.drop_at(&here, load, changes);
    }
}

impl Rain {
    /// The heights after the rain.
    ///
    /// # Errors
    /// For volumes, or when cancelled.
    pub fn erode(self, mut samples: Samples, cancel: Cancel<'_>) -> Result<Samples, Failure> {
        samples.heightfield("erosion")?;
        let frame = samples.frame;
        let count = frame.count();
        if frame.size[0] < 2 || frame.size[2] < 2 {
            return Ok(samples);
        }
        // Spacings of the axes differ little, if at all: a drop takes them for equal.
        let unit = (frame.spacing[0] * frame.spacing[2]).sqrt();
        samples.values.iter_mut().for_each(|h| *h /= unit);
        let brush = brush(self.brush);
        let drops = (self.drops * count as f64) as u64;
        // Few enough that the drops of a shower seldom meet, even in valleys: they do not see what the
        // others do, and would dig the same hole or fill the same pit twice.
        let shower = (count as u64 / 2048).max(1);
        let threads = rayon::current_num_threads().max(1);
        let mut own = vec![vec![0.0; count]; threads.min(shower as usize)];
        for first in (0..drops).step_by(shower as usize) {
            if cancel() {
                return Err(Failure::Cancelled);
            }
            let heights = &samples.values;
            let share = shower.div_ceil(own.len() as u64);
            let changes: Vec<Vec<Change>> = own
                .par_iter_mut()
                .enumerate()
                .flat_map_iter(|(thread, own)| {
                    let start = first + thread as u64 * share;
                    let end = (start + share).min(first + shower).min(drops);
                    let mut ground = Ground { frame, heights, own, brush: &brush };
                    (start..end).map(move |number| ground.drop(&self, number))
                })
                .collect();
            for (at, amount) in changes.into_iter().flatten() {
                samples.values[at] += amount;
            }
        }
        samples.values.iter_mut().for_each(|h| *h *= unit);
        Ok(samples)
    }
}

/// Samples within a radius and their shares, which fall off towards the rim and sum to 1.
fn brush(radius: f64) -> Vec<(isize, isize, f64)> {
    let reach = radius.max(0.0).floor() as isize;
    let mut found = Vec::new();
    for z in -reach..=reach {
        for x in -reach..=reach {
            let r = ((x * x + z * z) as f64).sqrt();
            if r < radius || (x, z) == (0, 0) {
                found.push((x, z, (1.0 - r / radius.max(1e-9)).max(1e-3)));
            }
        }
    }
    let sum: f64 = found.iter().map(|f| f.2).sum();
    found.iter_mut().for_each(|f| f.2 /= sum);
    found
}

#[cfg(test)]
mod tests {
    use super::super::spectrum::{Motion, fbm, synthesize};
    use super::super::{never, total};
    use super::*;

    fn hills(edge: Edge) -> Samples {
        let frame = Frame::over([64, 1, 64], [0.0; 3], [2.0, 1.0, 2.0], Edge::Repeat).unwrap();
        let s = synthesize(frame, 6, Motion::Still, fbm(0.8, 2, 2.0), &never).unwrap();
        let s = s.standardized("hills").unwrap();
        let values = s.values.iter().map(|v| 0.3 * v).collect();
        Samples { frame: Frame { edge, ..frame }, values }
    }

    #[test]
    fn mass_is_conserved() {
        let before = hills(Edge::Repeat);
        let after = Rain { drops: 3.0, ..Rain::default() }.erode(before.clone(), &never).unwrap();
        let size: f64 = before.values.iter().map(|v| v.abs()).sum();
        let (a, b) = (total(&before.values), total(&after.values));
        assert!((a - b).abs() < 1e-11 * size, "{a} {b}");
        let moved: f64 = before.values.iter().zip(&after.values).map(|(a, b)| (a - b).abs()).sum();
        assert!(moved > 0.01 * size, "{moved}");
        assert!(after.values.iter().all(|v| v.abs() < 3.0));
    }

    #[test]
    fn what_leaves_the_edge_is_lost_and_nothing_is_gained() {
        let before = hills(Edge::Clamp);
        let after = Rain::default().erode(before.clone(), &never).unwrap();
        assert!(total(&after.values) < total(&before.values));
    }

    #[test]
    fn nothing_is_dug_deeper_or_piled_higher_than_all_was() {
        let ramp = |edge: Edge| {
            let frame = Frame::over([64, 1, 64], [0.0; 3], [2.0, 1.0, 2.0], edge).unwrap();
            Samples::of(frame, |[x, _, _]| x, &never).unwrap()
        };
        for before in [hills(Edge::Repeat), hills(Edge::Clamp), ramp(Edge::Clamp), ramp(Edge::Repeat)] {
            for brush in [1.0, 2.0, 4.0] {
                let rain = Rain { drops: 5.0, brush, ..Rain::default() };
                let after = rain.erode(before.clone(), &never).unwrap();
                let range = |s: &Samples| {
                    s.values.iter().fold([f64::MAX, f64::MIN], |[a, b], v| [v.min(a), v.max(b)])
                };
                let ([low, high], [least, most]) = (range(&before), range(&after));
                let slack = 0.05 * (high - low);
                assert!(
                    least > low - slack && most < high + slack,
                    "{brush}: {low}..{high}, {least}..{most}"
                );
            }
        }
    }

    #[test]
    fn threads_change_nothing() {
        let rain = Rain { drops: 0.5, ..Rain::default() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| rain.erode(hills(Edge::Repeat), &never).unwrap())
        };
        assert_eq!(on(1), on(2));
    }

    #[test]
    fn drops_carve_valleys_and_fill_basins() {
        // A slope with a dip across: water fills the dip.
        let frame = Frame::over([64, 1, 64], [0.0; 3], [63.0, 1.0, 63.0], Edge::Clamp).unwrap();
        let dip = |[x, _, _]: [f64; 3]| 0.4 * x - 3.0 * libm::exp(-0.05 * (x - 30.0) * (x - 30.0));
        let before = Samples::of(frame, dip, &never).unwrap();
        let after = Rain { drops: 4.0, ..Rain::default() }.erode(before.clone(), &never).unwrap();
        let mean = |s: &Samples, x: usize| (10..54).map(|z| s.values[z * 64 + x]).sum::<f64>() / 44.0;
        let dip = |s: &Samples| mean(s, 29) - 0.5 * (mean(s, 20) + mean(s, 40));
        assert!(dip(&before) < -3.0 && dip(&after) > -1.0, "{} {}", dip(&before), dip(&after));
        assert!(mean(&after, 50) < mean(&before, 50) - 0.1);
    }

    #[test]
    fn rain_can_be_stopped() {
        assert_eq!(Rain::default().erode(hills(Edge::Repeat), &|| true), Err(Failure::Cancelled));
    }
}
