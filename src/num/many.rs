//! Batches: one instruction of a tape works on many numbers, so that its dispatch disappears.
//!
//! A lane never sees another, so a batch equals its lanes computed one by one, bit for bit.
//! Functions map over the lanes in a loop that the compiler vectorises; kernels gather the centres
//! of all lanes, evaluate their jets in one go, and expand them lane by lane.

use super::number::{Centred, Jets, error};
use super::simd::widest;
use super::{Function, Interval, Jets4, Kernel, Local, Number, Order, Plain, Point, Point4, Pointwise};

/// Writes `f` of each lane. Like the next two a function with its arrays as plain arguments: so the
/// compiler knows that none of them is written, and vectorises the loop without asking.
#[inline(always)]
fn fill1<T, const B: usize>(out: &mut [T; B], a: &[T; B], f: impl Fn(&T) -> T) {
    for i in 0..B {
        out[i] = f(&a[i]);
    }
}

/// The same of two arguments.
#[inline(always)]
fn fill2<T, const B: usize>(out: &mut [T; B], a: &[T; B], b: &[T; B], f: impl Fn([&T; 2]) -> T) {
    for i in 0..B {
        out[i] = f([&a[i], &b[i]]);
    }
}

/// The same of three arguments.
#[inline(always)]
fn fill3<T, const B: usize>(out: &mut [T; B], a: &[T; B], b: &[T; B], c: &[T; B], f: impl Fn([&T; 3]) -> T) {
    for i in 0..B {
        out[i] = f([&a[i], &b[i], &c[i]]);
    }
}

/// `B` numbers side by side, from a cache line's start on: a vector across two lines is slow to store
/// and to load again.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Many<T, const B: usize>(pub [T; B]);

impl<T: Copy, const B: usize> Many<T, B> {
    /// The lanes one by one, as a plain loop: `array::from_fn` does not always inline its closure,
    /// and what is not inlined is not vectorised.
    #[inline(always)]
    fn lanes(&self, f: impl Fn(usize) -> T) -> Self {
        widest(
            #[inline(always)]
            || {
                let mut out = *self;
                for (i, lane) in out.0.iter_mut().enumerate() {
                    *lane = f(i);
                }
                out
            },
        )
    }

    #[inline(always)]
    fn map(&self, f: impl Fn(&T) -> T) -> Self {
        self.lanes(
            #[inline(always)]
            |i| f(&self.0[i]),
        )
    }

    #[inline(always)]
    fn zip(&self, o: &Self, f: impl Fn(&T, &T) -> T) -> Self {
        self.lanes(
            #[inline(always)]
            |i| f(&self.0[i], &o.0[i]),
        )
    }
}

/// The images of points under a kernel that knows more of small balls than of all of space: what lanes of which that
/// matters are about, side by side.
fn locals<T: Centred + Copy, K: Kernel + ?Sized, const B: usize>(k: &K, p: [[T; 3]; B]) -> [T; B] {
    let bounds = k.bounds();
    let (mut at, mut radius, mut own, mut count) = ([[0.0; B]; 3], [0.0; B], [None; B], 0);
    for i in 0..B {
        let lane = p[i].each_ref();
        if T::blind(&bounds, lane) {
            continue;
        }
        let c = T::centre(lane);
        for axis in 0..3 {
            at[axis][count] = c[axis];
        }
        (radius[count], own[i]) = (T::reach(lane), Some(count));
        count += 1;
    }
    let mut known = [Local::UNKNOWN; B];
    k.locals(T::ORDER, at.each_ref().map(|at| &at[..count]), &radius[..count], &mut known[..count]);
    let nothing = (Local::uniform(Point::default(), bounds), [0.0; 3]);
    std::array::from_fn(|i| {
        let (local, error) = own[i].map_or(nothing, |own| known[own]);
        T::expand(&local, error, p[i].each_ref())
    })
}

/// The images of points under a kernel, from what it says of balls around their centres.
#[inline]
fn around_centres<T: Centred + Copy, K: Kernel + ?Sized, const B: usize>(
    k: &K,
    p: [&Many<T, B>; 3],
) -> Many<T, B> {
    let bounds = k.bounds();
    if (0..B).all(|i| T::blind(&bounds, p.map(|p| &p.0[i]))) {
        let nothing = Local::uniform(Point::default(), bounds);
        return Many(std::array::from_fn(|i| T::expand(&nothing, [0.0; 3], p.map(|p| &p.0[i]))));
    }
    if !T::EXACT && !k.is_uniform() {
        return Many(locals(k, std::array::from_fn(|i| p.map(|p| p.0[i]))));
    }
    let mut at = [[0.0; B]; 3];
    for i in 0..B {
        let c = T::centre(p.map(|p| &p.0[i]));
        for axis in 0..3 {
            at[axis][i] = c[axis];
        }
    }
    // Which arrays there are is known when this is compiled; the others cost nothing.
    let mut value = [0.0; B];
    let (mut grad, mut hess);
    let (mut grads, mut hesses) = (None, None);
    if T::ORDER >= Order::Gradient {
        grad = [[0.0; B]; 3];
        grads = Some(&mut grad);
    }
    if T::ORDER >= Order::Hessian {
        hess = [[0.0; B]; 6];
        hesses = Some(&mut hess);
    }
    let out = Jets {
        value: &mut value,
        grad: grads.as_mut().map(|g| g.each_mut().map(|g| &mut g[..])),
        hess: hesses.as_mut().map(|h| h.each_mut().map(|h| &mut h[..])),
    };
    k.jets([&at[0][..], &at[1][..], &at[2][..]], out);
    p[0].lanes(
        #[inline(always)]
        |i| {
            let jet = Point {
                value: value[i],
                grad: grads.as_ref().map_or([0.0; 3], |g| [g[0][i], g[1][i], g[2][i]]),
                hess: hesses.as_ref().map_or([0.0; 6], |h| std::array::from_fn(|k| h[k][i])),
            };
            let error = error::<T, K>(k, [at[0][i], at[1][i], at[2][i]]);
            T::expand(&Local::uniform(jet, bounds), error, p.map(|p| &p.0[i]))
        },
    )
}

impl<T: Centred + Copy, const B: usize> Number for Many<T, B> {
    const EXACT: bool = T::EXACT;
    #[inline]
    fn plain() -> Option<Plain<Self>> {
        // Alignment may leave a gap at the end.
        let is_full = size_of::<Self>() == B * size_of::<T>();
        T::plain().filter(|_| is_full).map(|lane| lane.times(B))
    }
    #[inline]
    fn constant(c: f64) -> Self {
        Many([T::constant(c); B])
    }
    #[inline]
    fn add(&self, other: &Self) -> Self {
        self.zip(other, T::add)
    }
    #[inline]
    fn sub(&self, other: &Self) -> Self {
        self.zip(other, T::sub)
    }
    #[inline]
    fn neg(&self) -> Self {
        self.map(T::neg)
    }
    #[inline]
    fn scale(&self, k: f64) -> Self {
        self.map(|x| x.scale(k))
    }
    #[inline]
    fn shift(&self, c: f64) -> Self {
        self.map(|x| x.shift(c))
    }
    #[inline]
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        x[0].lanes(
            #[inline(always)]
            |i| {
                T::lift(
                    f,
                    x.map(
                        #[inline(always)]
                        |x| &x.0[i],
                    ),
                )
            },
        )
    }
    #[inline]
    fn scale_to(&self, k: f64, out: &mut Self) {
        widest(
            #[inline(always)]
            move || fill1(&mut out.0, &self.0, |x| x.scale(k)),
        );
    }
    #[inline]
    fn shift_to(&self, c: f64, out: &mut Self) {
        widest(
            #[inline(always)]
            move || fill1(&mut out.0, &self.0, |x| x.shift(c)),
        );
    }
    #[inline]
    fn apply_to<F: Function<N>, const N: usize>(f: &F, x: [&Self; N], out: &mut Self) {
        widest(
            #[inline(always)]
            move || match x[..] {
                [a] => fill1(&mut out.0, &a.0, |a| f.apply([a; N])),
                [a, b] => fill2(&mut out.0, &a.0, &b.0, |p| f.apply(std::array::from_fn(|k| p[k]))),
                [a, b, c] => fill3(&mut out.0, &a.0, &b.0, &c.0, |p| f.apply(std::array::from_fn(|k| p[k]))),
                _ => {
                    for i in 0..B {
                        out.0[i] = f.apply(x.map(|x| &x.0[i]));
                    }
                }
            },
        );
    }
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self {
        let found = around_centres(k, p);
        if !T::BOX {
            return found;
        }
        Many(std::array::from_fn(|i| found.0[i].met(k, p.map(|p| &p.0[i]))))
    }
    fn pointwise<K: Pointwise>(k: &K, p: [&Self; 3], with: Option<&Self>) -> Option<Self> {
        if !T::EXACT {
            return None;
        }
        let (mut at, mut further) = ([[0.0; B]; 3], [0.0; B]);
        for i in 0..B {
            let c = T::centre(p.map(|p| &p.0[i]));
            for axis in 0..3 {
                at[axis][i] = c[axis];
            }
            if let Some(s) = with {
                further[i] = T::centre([&s.0[i]; 3])[0];
            }
        }
        let mut value = [0.0; B];
        let (mut grad, mut hess);
        let (mut grads, mut hesses) = (None, None);
        if T::ORDER >= Order::Gradient {
            grad = [[0.0; B]; 4];
            grads = Some(&mut grad);
        }
        if T::ORDER >= Order::Hessian {
            hess = [[0.0; B]; 10];
            hesses = Some(&mut hess);
        }
        let grad_parts = grads.as_mut().map(|g| g.each_mut().map(|g| &mut g[..]));
        let hess_parts = hesses.as_mut().map(|h| h.each_mut().map(|h| &mut h[..]));
        let (grad, slope) = grad_parts.map(|[x, y, z, s]| ([x, y, z], s)).unzip();
        let (hess, bend) = hess_parts
            .map(|[a, b, c, d, e, f, xs, ys, zs, ss]| ([a, b, c, d, e, f], [xs, ys, zs, ss]))
            .unzip();
        let out = Jets4 { space: Jets { value: &mut value, grad, hess }, slope, bend };
        k.jets([&at[0][..], &at[1][..], &at[2][..]], with.map(|_| &further[..]), out);
        Some(p[0].lanes(
            #[inline(always)]
            |i| {
                let jet = Point4 {
                    value: value[i],
                    grad: grads.as_ref().map_or([0.0; 4], |g| [g[0][i], g[1][i], g[2][i], g[3][i]]),
                    hess: hesses.as_ref().map_or([0.0; 10], |h| std::array::from_fn(|k| h[k][i])),
                };
                let p = p.map(|p| &p.0[i]);
                // Every exact number knows the chain rule.
                T::compose(&jet, p, with.map(|s| &s.0[i])).unwrap_or(*p[0])
            },
        ))
    }
    #[inline(always)]
    fn somewhere(range: Interval) -> Option<Self> {
        T::somewhere(range).map(|x| Many([x; B]))
    }
    #[inline]
    fn choose(by: &Self, test: impl Fn(Interval) -> bool, yes: &Self, no: &Self) -> Self {
        by.lanes(
            #[inline(always)]
            |i| T::choose(&by.0[i], &test, &yes.0[i], &no.0[i]),
        )
    }
    fn range(&self) -> Interval {
        self.0.iter().map(T::range).reduce(Interval::hull).unwrap_or(Interval::ENTIRE)
    }
}
