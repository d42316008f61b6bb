//! Cellular noise: sums of the distances to the nearest of randomly scattered nodes (Worley 1996;
//! Gamito 2009, 4.5).
//!
//! Nodes are a homogeneous Poisson process with one node a unit of volume (`search.rs`). With
//! `F_1 <= F_2 <= ...` the distances from a point to its nearest nodes, in a norm of choice,
//!
//! ```text
//! N(x) = a_1 F_1 + a_2 F_2 + a_3 F_3 + a_4 F_4 - mean                               (4.18)
//! ```
//!
//! `F_1` makes pebbles, `F_2 - F_1` the walls between them, the Manhattan norm facets. The distances
//! may be squared, which rounds the cones at the nodes.
//!
//! **Mean.** Noises have mean zero, so the mean is taken off unless `centred` is false (the thesis'
//! pictures keep it). In a Poisson process the number of nodes within `r` is Poisson with mean
//! `V r^3`, `V` the volume of the unit ball, so `V F_l^3` has a Gamma law and
//!
//! ```text
//! E[F_l] = Gamma(l + 1/3) / Gamma(l) V^(-1/3)        E[F_l^2] = Gamma(l + 2/3) / Gamma(l) V^(-2/3)
//! V = (2 Gamma(1 + 1/p))^3 / Gamma(1 + 3/p)
//! ```
//!
//! **Bounds.** Space has empty regions of any size, somewhere. So that the noise is bounded all the
//! same, distances saturate at a *cap*, as if there were four further nodes at that distance from
//! everywhere. At the cap of 2 (of 3 for exponents below 2, where balls are smaller) the chance that
//! even `F_4` gets there is below 10^-10 a point; such a point is none the worse for it. Distances
//! are 1-Lipschitz in their own norm, and order statistics of Lipschitz functions are Lipschitz with
//! the same constant.
//!
//! **Class.** Only continuous: creased where two nodes are equally far, pointed at nodes. What is
//! known of the noise in a small ball, creases included, is worked out in `ball.rs`.

mod ball;
mod metric;
mod plots;
mod scout;
mod search;
#[cfg(test)]
mod tests;

use super::basis::Basis;
use super::bulk::{self, GRADIENT, HESSIAN, Lanes, VALUE};
use super::lattice::Lattice;
use super::parameter::{Allowed, Exact, Parameter, Settings};
use crate::num::{Bounds, Class, Jets, Local, Order, Point, ROUNDOFF};
use metric::{Chebyshev, Euclidean, Manhattan, Metric, Minkowski};
use plots::Memory;
use scout::Ground;
use search::{Cell, Found, Search, cells};
use std::sync::OnceLock;

/// How distance is measured.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Norm {
    Euclidean,
    Manhattan,
    Chebyshev,
    Minkowski(Exact),
}

/// Cellular noise with its parameters, and what follows from them.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Cellular {
    weights: [Exact; 4],
    norm: Norm,
    squared: bool,
    /// Taken off, unless zero.
    mean: Exact,
    range: Exact,
    lipschitz: Exact,
}

/// Something to do with the norm known.
trait Task {
    type Out;
    fn run<M: Metric>(self, search: Search<'_, M>) -> Self::Out;
}

impl Norm {
    fn new(settings: &Settings) -> Norm {
        match settings.name("norm") {
            "manhattan" => Norm::Manhattan,
            "chebyshev" => Norm::Chebyshev,
            "minkowski" => Norm::Minkowski(Exact(settings.number("power"))),
            _ => Norm::Euclidean,
        }
    }

    /// The exponent.
    fn power(self) -> f64 {
        match self {
            Norm::Euclidean => 2.0,
            Norm::Manhattan => 1.0,
            Norm::Chebyshev => f64::INFINITY,
            Norm::Minkowski(power) => power.0,
        }
    }

    /// Distances end here; a whole number.
    fn cap(self) -> f64 {
        if self.power() < 2.0 { 3.0 } else { 2.0 }
    }

    /// Largest Euclidean length of a distance's gradient.
    fn steepness(self) -> f64 {
        match self {
            Norm::Euclidean => Euclidean.steepness(),
            Norm::Manhattan => Manhattan.steepness(),
            Norm::Chebyshev => Chebyshev.steepness(),
            Norm::Minkowski(power) => Minkowski(power.0).steepness(),
        }
    }

    /// Mean of the `l`-th distance, or of its square.
    fn mean(self, l: usize, squared: bool) -> f64 {
        let (p, order) = (self.power(), l as f64);
        let volume = if p == f64::INFINITY {
            8.0
        } else {
            let half = libm::tgamma(1.0 + 1.0 / p);
            8.0 * half * half * half / libm::tgamma(1.0 + 3.0 / p)
        };
        let power = if squared { 2.0 / 3.0 } else { 1.0 / 3.0 };
        libm::tgamma(order + power) / libm::tgamma(order) * libm::pow(volume, -power)
    }

    #[inline(always)]
    fn run<T: Task>(self, lattice: &Lattice, task: T) -> T::Out {
        static TABLES: [OnceLock<Vec<Cell>>; 4] = [const { OnceLock::new() }; 4];
        #[inline(always)]
        fn with<M: Metric, T: Task>(metric: M, table: usize, cap: f64, lattice: &Lattice, task: T) -> T::Out {
            task.run(Search { metric, cells: TABLES[table].get_or_init(|| cells(metric, cap)), lattice, cap })
        }
        let cap = self.cap();
        match self {
            Norm::Euclidean => task.run(Norm::euclidean(lattice)),
            Norm::Manhattan => with(Manhattan, 0, cap, lattice, task),
            Norm::Chebyshev => with(Chebyshev, 1, cap, lattice, task),
            // The order of the cells does not depend on the exponent, how many there are does.
            Norm::Minkowski(p) => with(Minkowski(p.0), if cap < 3.0 { 2 } else { 3 }, cap, lattice, task),
        }
    }

    /// What a search in the usual norm needs to know.
    #[inline(always)]
    fn euclidean(lattice: &Lattice) -> Search<'_, Euclidean> {
        static CELLS: OnceLock<Vec<Cell>> = OnceLock::new();
        let cap = Norm::Euclidean.cap();
        Search { metric: Euclidean, cells: CELLS.get_or_init(|| cells(Euclidean, cap)), lattice, cap }
    }
}

impl Basis for Cellular {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            name: "weights",
            doc: "Weights of the distances to the nearest, second, third and fourth node.",
            allowed: Allowed::Numbers { most: 16.0, default: [1.0, 0.0, 0.0, 0.0] },
        },
        Parameter {
            name: "norm",
            doc: "How distance is measured: round, with octahedral, with cubic facets, or between.",
            allowed: Allowed::Choice(&["euclidean", "manhattan", "chebyshev", "minkowski"]),
        },
        Parameter {
            name: "power",
            doc: "Exponent of the minkowski norm: 1 is manhattan, 2 euclidean, large ones chebyshev.",
            allowed: Allowed::Number { least: 1.0, most: 64.0, default: 4.0 },
        },
        Parameter {
            name: "squared",
            doc: "Whether distances are squared.",
            allowed: Allowed::Flag { default: false },
        },
        Parameter {
            name: "centred",
            doc: "Whether the mean is taken off, so that the noise varies about zero.",
            allowed: Allowed::Flag { default: true },
        },
    ];

    fn new(settings: &Settings) -> Self {
        let (norm, squared, weights) =
            (Norm::new(settings), settings.flag("squared"), settings.numbers("weights"));
        let mean: f64 = (0..4).map(|l| weights[l] * norm.mean(l + 1, squared)).sum();
        let mean = if settings.flag("centred") { mean } else { 0.0 };
        // 0 <= F_1 <= ... <= F_4 <= cap is a simplex with the corners (0, .., 0, cap, .., cap).
        let cap = if squared { norm.cap() * norm.cap() } else { norm.cap() };
        let corners = [0, 1, 2, 3, 4].map(|l| cap * weights[l..].iter().sum::<f64>() - mean);
        let range = corners.iter().fold(0.0, |a: f64, b| if b.abs() > a { b.abs() } else { a });
        let size: f64 = weights.iter().map(|a| a.abs()).sum();
        let steepness = norm.steepness() * if squared { 2.0 * norm.cap() } else { 1.0 };
        let up = 1.0 + 64.0 * ROUNDOFF;
        Cellular {
            weights: weights.map(Exact),
            norm,
            squared,
            mean: Exact(mean),
            range: Exact((range + 64.0 * ROUNDOFF * cap * size) * up),
            lipschitz: Exact(size * steepness * up),
        }
    }

    fn class(&self) -> Class {
        Class::C0
    }

    fn bounds(&self) -> Bounds {
        Bounds {
            range: self.range.0,
            lipschitz: self.lipschitz.0,
            hessian: f64::INFINITY,
            third: f64::INFINITY,
        }
    }

    /// Measured in the Euclidean norm, relative to the level that the spectrum has near zero. Creases
    /// make it fall slowly: 30 dB further down takes twice as far. Differences of distances, which
    /// are walls, have less at low frequencies and reach as high again.
    fn band(&self) -> f64 {
        let signs =
            |positive: bool| self.weights.iter().any(|a| if positive { a.0 > 0.0 } else { a.0 < 0.0 });
        if signs(true) && signs(false) { 2.0 } else { 1.25 }
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        if self.norm == Norm::Euclidean && self.orders() == 1 && at[0].len() >= plots::LANES {
            let search = Norm::euclidean(lattice);
            let lanes = || {
                let (mut memory, mut ground) = (Memory::of(lattice), Ground::new(lattice));
                Nearest::new(
                    self,
                    search.metric,
                    #[inline(always)]
                    move |at: &_, found: &mut _| memory.nearest(&search, &mut ground, at, found),
                )
            };
            return bulk::jets(lanes, at, out);
        }
        self.norm.run(lattice, Bulk { noise: self, at, out });
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        self.norm.run(lattice, One { noise: self, order, at })
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, lattice: &Lattice, order: Order, at: [f64; 3], radius: f64) -> Local {
        let order = if order < Order::Gradient { Order::Gradient } else { order };
        self.norm.run(lattice, Ball { noise: self, order, at, radius })
    }

    fn locals(&self, lattice: &Lattice, order: Order, at: [&[f64]; 3], radius: &[f64], out: &mut [Local]) {
        self.norm.run(lattice, Balls { noise: self, order, at, radius, out });
    }

    /// Offsets are off by a few roundoffs of a cell, distances by as much again; powers of ratios by
    /// as many as their exponent, which is at most 64. Which node is the nearest is decided up to
    /// these errors: the gradient is that of a node that is nearest up to rounding.
    #[inline(always)]
    fn rounding(&self) -> [f64; 3] {
        let size: f64 = self.weights.iter().map(|a| a.0.abs()).sum();
        let cap = if self.squared { 9.0 } else { 3.0 };
        let value = 32.0 * ROUNDOFF * (size * cap + self.mean.0.abs());
        [value, 512.0 * ROUNDOFF * self.lipschitz.0, f64::INFINITY]
    }
}

impl Cellular {
    /// How many of the distances matter.
    #[inline(always)]
    fn orders(&self) -> usize {
        self.weights.iter().rposition(|a| a.0 != 0.0).map_or(1, |l| l + 1)
    }

    /// The jet from the nearest nodes of lane `i`.
    #[inline(always)]
    fn finish<M: Metric, const K: usize, const B: usize, const ORDER: u8>(
        &self,
        metric: M,
        found: &Found<K, B>,
        i: usize,
    ) -> Point {
        let mut out = Point { value: -self.mean.0 + found.nowhere[i], ..Point::default() };
        for l in 0..K {
            let a = self.weights[l].0;
            let f = metric.distance(found.measure[l][i]);
            out.value += a * if self.squared { f * f } else { f };
            if ORDER >= GRADIENT {
                let d = [found.offset[l][0][i], found.offset[l][1][i], found.offset[l][2][i]];
                let g = metric.slope(d, f);
                let k = a * if self.squared { 2.0 * f } else { 1.0 };
                for axis in 0..3 {
                    out.grad[axis] += k * g[axis];
                }
                if ORDER >= HESSIAN {
                    let h = metric.hessian(d, f);
                    let k2 = a * if self.squared { 2.0 } else { 0.0 };
                    for (pair, (r, c)) in PAIRS.into_iter().enumerate() {
                        out.hess[pair] += k * h[pair] + k2 * (g[r] * g[c]);
                    }
                }
            }
        }
        if ORDER >= GRADIENT {
            for g in &mut out.grad {
                *g += found.nowhere[i];
            }
        }
        out
    }
}

impl Cellular {
    /// The jet from the nearest nodes of a point.
    fn point<M: Metric, const K: usize>(&self, metric: M, order: Order, found: &Found<K, 1>) -> Point {
        match order {
            Order::Value => self.finish::<M, K, 1, VALUE>(metric, found, 0),
            Order::Gradient => self.finish::<M, K, 1, GRADIENT>(metric, found, 0),
            Order::Hessian => self.finish::<M, K, 1, HESSIAN>(metric, found, 0),
        }
    }
}

/// Row and column of the six second derivatives.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// The jet at one point.
struct One<'a> {
    noise: &'a Cellular,
    order: Order,
    at: [f64; 3],
}

impl Task for One<'_> {
    type Out = Point;

    #[inline(always)]
    fn run<M: Metric>(self, search: Search<'_, M>) -> Point {
        match self.noise.orders() {
            1 => self.nearest::<M, 1>(search),
            2 => self.nearest::<M, 2>(search),
            _ => self.nearest::<M, 4>(search),
        }
    }
}

impl One<'_> {
    #[inline(never)]
    fn nearest<M: Metric, const K: usize>(&self, search: Search<'_, M>) -> Point {
        let found: Found<K, 1> = search.nearest(self.at);
        self.noise.point(search.metric, self.order, &found)
    }
}

/// What is known of a ball.
struct Ball<'a> {
    noise: &'a Cellular,
    order: Order,
    at: [f64; 3],
    radius: f64,
}

impl Task for Ball<'_> {
    type Out = Local;

    fn run<M: Metric>(self, search: Search<'_, M>) -> Local {
        match self.noise.orders() {
            1 if !self.noise.squared => ball::nearest_alone(&self, search),
            1 => ball::local::<M, 1>(&self, search),
            2 => ball::local::<M, 2>(&self, search),
            _ => ball::local::<M, 4>(&self, search),
        }
    }
}

/// What is known of a batch of balls.
struct Balls<'a> {
    noise: &'a Cellular,
    order: Order,
    at: [&'a [f64]; 3],
    radius: &'a [f64],
    out: &'a mut [Local],
}

impl Task for Balls<'_> {
    type Out = ();

    fn run<M: Metric>(self, search: Search<'_, M>) {
        let Balls { noise, order, at, radius, out } = self;
        let order = if order < Order::Gradient { Order::Gradient } else { order };
        let ball = |i: usize| Ball { noise, order, at: at.map(|at| at[i]), radius: radius[i] };
        if noise.orders() == 1 && !noise.squared {
            ball::nearest_alone_of_all(&ball, search, out);
        } else {
            out.iter_mut().enumerate().for_each(|(i, out)| *out = ball(i).run(search));
        }
    }
}

/// A batch of jets.
struct Bulk<'a, 'b> {
    noise: &'a Cellular,
    at: [&'a [f64]; 3],
    out: Jets<'b>,
}

impl Task for Bulk<'_, '_> {
    type Out = ();

    #[inline(always)]
    fn run<M: Metric>(self, search: Search<'_, M>) {
        // More lanes share the work between branches, fewer wait less for one another.
        match self.noise.orders() {
            1 => self.nearest::<M, 1, 16>(search),
            2 => self.nearest::<M, 2, 8>(search),
            _ => self.nearest::<M, 4, 8>(search),
        }
    }
}

impl Bulk<'_, '_> {
    #[inline(always)]
    fn nearest<M: Metric, const K: usize, const GROUP: usize>(self, search: Search<'_, M>) {
        let lanes = || {
            let mut ground = Ground::<GROUP>::new(search.lattice);
            Nearest::new(
                self.noise,
                search.metric,
                #[inline(always)]
                move |at: &[[f64; GROUP]; 3], found: &mut Found<K, GROUP>| {
                    search.nearest_of_group(&mut ground, at, found);
                },
            )
        };
        bulk::jets(lanes, self.at, self.out);
    }
}

/// The noise of the `K` nearest nodes, in lanes, `GROUP` points at a time, for which these are sought.
struct Nearest<'a, M, S, const K: usize, const GROUP: usize> {
    noise: &'a Cellular,
    metric: M,
    seek: S,
}

impl<'a, M, S, const K: usize, const GROUP: usize> Nearest<'a, M, S, K, GROUP>
where
    M: Metric,
    S: FnMut(&[[f64; GROUP]; 3], &mut Found<K, GROUP>),
{
    fn new(noise: &'a Cellular, metric: M, seek: S) -> Self {
        Nearest { noise, metric, seek }
    }
}

impl<M, S, const K: usize, const GROUP: usize> Lanes for Nearest<'_, M, S, K, GROUP>
where
    M: Metric,
    S: FnMut(&[[f64; GROUP]; 3], &mut Found<K, GROUP>),
{
    #[inline(always)]
    fn block<const ORDER: u8, const PARTS: usize, const B: usize>(
        &mut self,
        from: &[[f64; B]; 3],
        to: &mut [[f64; B]; PARTS],
    ) {
        let mut found = Found::<K, GROUP>::new(0.0, [0.0; GROUP]);
        for start in (0..B).step_by(GROUP) {
            let mut at = [[0.0; GROUP]; 3];
            for (own, from) in at.iter_mut().zip(from) {
                own.copy_from_slice(&from[start..start + GROUP]);
            }
            (self.seek)(&at, &mut found);
            for i in 0..GROUP {
                let p = self.noise.finish::<M, K, GROUP, ORDER>(self.metric, &found, i);
                to[0][start + i] = p.value;
                if ORDER >= GRADIENT {
                    for k in 0..3 {
                        to[1 + k][start + i] = p.grad[k];
                    }
                }
                if ORDER >= HESSIAN {
                    for k in 0..6 {
                        to[4 + k][start + i] = p.hess[k];
                    }
                }
            }
        }
    }
}
