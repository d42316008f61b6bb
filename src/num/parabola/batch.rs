//! Batches of parabolas, as a structure of arrays.

use super::{Parabola, ROUND_UP, Reach, ZERO, each, radius, silenced};
use crate::num::number::Jets;
use crate::num::simd::widest;
use crate::num::{Band, Function, Interval, Kernel, Local, Number, Order, Point, ROUNDOFF, Real};

/// The rounding of a kernel's jets, which grows with the size of the point like `a + b size`.
struct Growing {
    start: [f64; 3],
    growth: [f64; 3],
}

impl Growing {
    fn new<K: Kernel + ?Sized>(k: &K) -> Self {
        let (start, one) = (k.error(0.0), k.error(1.0));
        // What is unbounded at the origin is so everywhere.
        let grows = |i: usize| if start[i].is_finite() { (one[i] - start[i]) * ROUND_UP } else { 0.0 };
        Growing { start, growth: [grows(0), grows(1), grows(2)] }
    }

    #[inline(always)]
    fn at(&self, size: f64) -> [f64; 3] {
        let at = |i: usize| (self.start[i] + self.growth[i] * size) * ROUND_UP;
        [at(0), at(1), at(2)]
    }
}

/// Largest coordinate.
#[inline(always)]
fn size([x, y, z]: [f64; 3]) -> f64 {
    x.abs().max(y.abs()).max(z.abs())
}

/// `B` parabolas side by side, each along a piece of its own.
#[derive(Clone, Copy, Debug)]
pub struct Parabolas<const B: usize, const K: usize> {
    value: Band<B>,
    slope: Band<B>,
    bend: Band<B>,
    side: [[f64; B]; K],
    range: Band<B>,
}

impl<const B: usize, const K: usize> Parabolas<B, K> {
    /// The same number in every lane.
    pub fn all(x: Parabola<K>) -> Self {
        let mut side = [[0.0; B]; K];
        for k in 0..K {
            side[k] = [x.side[k]; B];
        }
        let [value, slope, bend] = [Band::all(x.value), Band::all(x.slope), Band::all(x.bend)];
        Parabolas { value, slope, bend, side, range: Band::all(x.range) }
    }

    /// A lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Parabola<K> {
        let mut side = [0.0; K];
        for k in 0..K {
            side[k] = self.side[k][i];
        }
        Parabola {
            value: self.value.lane(i),
            slope: self.slope.lane(i),
            bend: self.bend.lane(i),
            side,
            range: self.range.lane(i),
        }
    }

    /// Sets a lane.
    #[inline(always)]
    pub fn set(&mut self, i: usize, x: &Parabola<K>) {
        self.value.set(i, x.value);
        self.slope.set(i, x.slope);
        self.bend.set(i, x.bend);
        self.range.set(i, x.range);
        for k in 0..K {
            self.side[k][i] = x.side[k];
        }
    }

    /// The lanes one by one, as a plain loop.
    #[inline(always)]
    fn lanes(f: impl Fn(usize) -> Parabola<K>) -> Self {
        widest(
            #[inline(always)]
            || {
                let mut out = Self::all(Parabola::constant(ZERO));
                for i in 0..B {
                    out.set(i, &f(i));
                }
                out
            },
        )
    }

    /// A lane of each argument.
    #[inline(always)]
    fn gather<const N: usize>(x: &[&Self; N], i: usize) -> [Parabola<K>; N] {
        let mut out = [x[0].lane(i); N];
        for j in 1..N {
            out[j] = x[j].lane(i);
        }
        out
    }

    /// Expansion of a function to second order about the middle: a loop over the lanes for each
    /// quantity, since a loop that computes all of them is too much for the compiler to vectorise.
    #[inline(always)]
    fn curved<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N]) -> Self {
        let zero = Band::all(ZERO);
        let mut out = Self::all(Parabola::constant(ZERO));
        let (mut grad, mut hess, mut chord) = ([zero; N], [[zero; N]; N], [zero; N]);
        for l in 0..B {
            let mut at = [ZERO; N];
            for i in 0..N {
                at[i] = x[i].value.lane(l);
            }
            out.value.set(l, f.range(at));
        }
        for l in 0..B {
            let mut at = [ZERO; N];
            for i in 0..N {
                at[i] = x[i].range.lane(l);
            }
            out.range.set(l, f.range(at));
        }
        for l in 0..B {
            let mut at = [ZERO; N];
            for i in 0..N {
                at[i] = x[i].value.lane(l);
            }
            let g = f.grad(at);
            for i in 0..N {
                grad[i].set(l, g[i]);
            }
        }
        for l in 0..B {
            let mut at = [ZERO; N];
            for i in 0..N {
                at[i] = x[i].range.lane(l).hull(x[i].value.lane(l));
            }
            let h = f.hess(at);
            for i in 0..N {
                for j in 0..N {
                    if j <= i {
                        hess[i][j].set(l, h[i][j]);
                    }
                }
            }
        }
        for i in 0..N {
            for l in 0..B {
                let (g, t) = (grad[i].lane(l), x[i].slope.lane(l) + radius(x[i].bend.lane(l).mag()));
                chord[i].set(l, t);
                out.slope.set(l, out.slope.lane(l) + silenced(g, x[i].slope.lane(l)));
                let half = silenced(hess[i][i].lane(l), t.square() * 0.5);
                out.bend.set(l, out.bend.lane(l) + silenced(g, x[i].bend.lane(l)) + half);
            }
        }
        for i in 0..N {
            for j in 0..i {
                for l in 0..B {
                    let t = chord[i].lane(l) * chord[j].lane(l);
                    out.bend.set(l, out.bend.lane(l) + silenced(hess[i][j].lane(l), t));
                }
            }
        }
        if K > 0 {
            out.spread(&grad, &hess, x, &chord);
        }
        out
    }

    /// Adds what the side symbols of the arguments do to a second-order expansion.
    #[inline(always)]
    fn spread<const N: usize>(
        &mut self,
        grad: &[Band<B>; N],
        hess: &[[Band<B>; N]; N],
        x: &[&Self; N],
        chord: &[Band<B>; N],
    ) {
        let mut wide = [[0.0; B]; N];
        let mut size = [0.0; B];
        for i in 0..N {
            for k in 0..K {
                for l in 0..B {
                    wide[i][l] += x[i].side[k][l].abs();
                    let term = grad[i].lane(l).mid() * x[i].side[k][l];
                    self.side[k][l] += term;
                    size[l] += term.abs();
                }
            }
            for l in 0..B {
                wide[i][l] *= ROUND_UP;
                let (h, w) = (hess[i][i].lane(l), radius(wide[i][l]));
                // Only the middle of a partial derivative acts on a shared symbol.
                let own = silenced(h, w.square() * 0.5) + silenced(radius(grad[i].lane(l).rad()), w);
                self.value.set(l, self.value.lane(l) + own);
                self.slope.set(l, self.slope.lane(l) + silenced(h, chord[i].lane(l) * w));
            }
        }
        for i in 0..N {
            for j in 0..i {
                for l in 0..B {
                    let (h, v, w) = (hess[i][j].lane(l), radius(wide[i][l]), radius(wide[j][l]));
                    let both = chord[i].lane(l) * w + chord[j].lane(l) * v;
                    self.value.set(l, self.value.lane(l) + silenced(h, v * w));
                    self.slope.set(l, self.slope.lane(l) + silenced(h, both));
                }
            }
        }
        for l in 0..B {
            self.value.set(l, self.value.lane(l) + radius(8.0 * ROUNDOFF * size[l] + 1e-300));
        }
    }

    /// The image of a point under a kernel.
    fn image<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3]) -> Self {
        let bounds = k.bounds();
        let mut at = [[0.0; B]; 3];
        let mut reach = [[0.0; B]; 2];
        widest(
            #[inline(always)]
            || {
                for i in 0..B {
                    let p = Self::gather(&p, i);
                    for axis in 0..3 {
                        at[axis][i] = p[axis].value.mid();
                    }
                    let own = Reach::new(&p);
                    (reach[0][i], reach[1][i]) = (own.along, own.beside);
                }
            },
        );
        let reach = |i: usize| Reach { along: reach[0][i], beside: reach[1][i] };
        // Decided lane by lane, so that no lane depends on its neighbours.
        let blind = |i: usize| bounds.lipschitz * reach(i).whole() >= 2.0 * bounds.range;
        let nothing = Parabola::constant(radius(bounds.range));
        if (0..B).all(blind) {
            return Self::all(nothing);
        }
        let reaches = std::array::from_fn(reach);
        let mut out = if k.is_uniform() {
            Self::uniform(k, p, &at, &reaches)
        } else {
            Self::local(k, p, &at, &reaches)
        };
        for i in 0..B {
            if blind(i) {
                out.set(i, &nothing);
            }
        }
        out
    }

    /// The image under a kernel that knows more about a small ball than about all of space.
    fn local<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3], at: &[[f64; B]; 3], reach: &[Reach; B]) -> Self {
        let mut out = Self::all(Parabola::constant(ZERO));
        for i in 0..B {
            let c = [at[0][i], at[1][i], at[2][i]];
            let local = k.local(Order::Gradient, c, reach[i].whole());
            out.set(i, &Parabola::expand(&local, k.error(size(c)), reach[i], &Self::gather(&p, i)));
        }
        out
    }

    /// The image under a kernel of which the jets and the bounds are all there is to say.
    fn uniform<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3], at: &[[f64; B]; 3], reach: &[Reach; B]) -> Self {
        let bounds = k.bounds();
        let (mut value, mut grad) = ([0.0; B], [[0.0; B]; 3]);
        let [gx, gy, gz] = &mut grad;
        k.jets([&at[0], &at[1], &at[2]], Jets { value: &mut value, grad: Some([gx, gy, gz]), hess: None });
        let error = Growing::new(k);
        Self::lanes(
            #[inline(always)]
            |i| {
                let p = Self::gather(&p, i);
                let jet =
                    Point { value: value[i], grad: [grad[0][i], grad[1][i], grad[2][i]], hess: [0.0; 6] };
                Parabola::expand(
                    &Local::uniform(jet, bounds),
                    error.at(size([at[0][i], at[1][i], at[2][i]])),
                    reach[i],
                    &p,
                )
            },
        )
    }
}

impl<const B: usize, const K: usize> Number for Parabolas<B, K> {
    fn constant(c: f64) -> Self {
        Self::all(Parabola::constant(Interval::point(c)))
    }
    fn add(&self, other: &Self) -> Self {
        Self::lanes(
            #[inline(always)]
            |i| {
                let (a, b) = (self.lane(i), other.lane(i));
                let mut out = Parabola {
                    value: a.value + b.value,
                    slope: a.slope + b.slope,
                    bend: a.bend + b.bend,
                    side: a.side,
                    range: a.range + b.range,
                };
                let mut size = 0.0;
                for k in 0..K {
                    out.side[k] += b.side[k];
                    size += out.side[k].abs();
                }
                out.rounded(size).narrowed(out.range)
            },
        )
    }
    fn sub(&self, other: &Self) -> Self {
        self.add(&other.neg())
    }
    fn neg(&self) -> Self {
        Self::lanes(
            #[inline(always)]
            |i| {
                let x = self.lane(i);
                let mut out = Parabola {
                    value: -x.value,
                    slope: -x.slope,
                    bend: -x.bend,
                    side: x.side,
                    range: -x.range,
                };
                for k in 0..K {
                    out.side[k] = -x.side[k];
                }
                out
            },
        )
    }
    fn scale(&self, k: f64) -> Self {
        Self::lanes(
            #[inline(always)]
            |i| {
                let x = self.lane(i);
                let mut out = Parabola {
                    value: x.value * k,
                    slope: x.slope * k,
                    bend: x.bend * k,
                    side: x.side,
                    range: x.range * k,
                };
                let mut size = 0.0;
                for s in 0..K {
                    out.side[s] *= k;
                    size += out.side[s].abs();
                }
                out.rounded(size)
            },
        )
    }
    fn shift(&self, c: f64) -> Self {
        let c = Interval::point(c);
        Self::lanes(
            #[inline(always)]
            |i| {
                let x = self.lane(i);
                Parabola { value: x.value + c, range: x.range + c, ..x }
            },
        )
    }
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        let mut out = widest(
            #[inline(always)]
            || Self::curved(f, &x),
        );
        // Where second derivatives are unbounded, first ones may not be.
        for i in 0..B {
            if !out.lane(i).is_finite() {
                let x = Self::gather(&x, i);
                let value = f.range(each(&x, |x| x.value));
                let first = if f.selects() {
                    Parabola::selected(f, &x, value)
                } else {
                    Parabola::sloped(f, &x, value)
                };
                out.set(i, &Parabola { range: out.range.lane(i), ..first });
            }
        }
        Self::lanes(
            #[inline(always)]
            |i| {
                let x = out.lane(i);
                x.tightened(x.range)
            },
        )
    }
    fn kernel<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3]) -> Self {
        Self::image(k, p)
    }
    fn somewhere(range: Interval) -> Option<Self> {
        Some(Self::all(Parabola::constant(range)))
    }
    fn choose(by: &Self, test: impl Fn(Interval) -> bool, yes: &Self, no: &Self) -> Self {
        let mut out = *no;
        for i in 0..B {
            if test(by.range.lane(i)) {
                out.set(i, &yes.lane(i));
            }
        }
        out
    }
    fn range(&self) -> Interval {
        (1..B).fold(self.range.lane(0), |all, i| all.hull(self.range.lane(i)))
    }
}
