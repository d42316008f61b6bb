//! Functions of vectors, whose components are separate arguments.

use crate::num::{Bounds, Class, Combine, Form, Function, Interval, Local, Point, ROUNDOFF, Real};

/// `sqrt(x^2 + y^2 + z^2)`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Length;

impl Function<3> for Length {
    fn is_even(&self) -> bool {
        true
    }
    fn class(&self) -> Class {
        Class::C2 // everywhere but at the single point 0, as surfaces are asked about
    }
    /// Squares, their sum, a root and a quotient.
    #[inline(always)]
    fn roundoffs(&self) -> Option<f64> {
        Some(8.0)
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x, y, z]: [R; 3]) -> R {
        (x.square() + y.square() + z.square()).sqrt()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, y, z]: [R; 3]) -> [R; 3] {
        // Each component of a unit vector lies in [-1, 1]; at the origin they are zero.
        let shrink = R::of(1.0) / self.value([x, y, z]).max(R::of(1e-300));
        [unit(x, shrink), unit(y, shrink), unit(z, shrink)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x, y, z]: [R; 3]) -> [[R; 3]; 3] {
        let (one, r) = (R::of(1.0), R::of(1.0) / self.value([x, y, z]));
        let (x, y, z) = (x * r, y * r, z * r);
        let (xy, xz, yz) = (-(x * y) * r, -(x * z) * r, -(y * z) * r);
        let [xx, yy, zz] = [(one - x.square()) * r, (one - y.square()) * r, (one - z.square()) * r];
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }
    /// Nothing along the vector, and the reciprocal length across it.
    #[inline(always)]
    fn curvature(&self, x: &[Interval; 3]) -> Option<Interval> {
        let least = self.range(*x).lo;
        Some(Interval { lo: 0.0, hi: (Interval::point(1.0) / Interval::point(least)).hi })
    }
    /// With `n` the least length in the ball, second derivatives are at most `1 / n` and third ones, along a unit
    /// vector at an angle of cosine `c` to the point, `3 c (1 - c^2) / n^2`, which is at most `2 / sqrt(3) n^2`.
    #[inline(always)]
    fn around(&self, at: [f64; 3], radius: f64) -> Option<(Local, [f64; 3])> {
        let value = self.value(at);
        let nearest = value - radius - 8.0 * ROUNDOFF * (value + radius);
        let inverse = if nearest > 1e-140 { (1.0 + 4.0 * ROUNDOFF) / nearest } else { f64::INFINITY };
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = self.hess(at);
        let jet = Point { value, grad: self.grad(at), hess: [xx, yy, zz, xy, xz, yz] };
        let bounds = Bounds {
            range: (value + radius) * (1.0 + 16.0 * ROUNDOFF),
            lipschitz: 1.0,
            hessian: inverse,
            third: 1.154_701 * inverse * inverse,
        };
        let error = [8.0 * ROUNDOFF * value, 32.0 * ROUNDOFF, 64.0 * ROUNDOFF * inverse];
        Some((Local::uniform(jet, bounds), error))
    }
    /// The gradient is a unit vector.
    fn steepness(&self, _: &[Interval; 3], _: &[f64; 3], jacobian: f64) -> f64 {
        jacobian
    }
    /// With `n = c / |c|` the tangent `T = n . x` lies below `|x|`, and
    /// `|x| - T = |x_perp|^2 / (|x| + T)` where `x_perp` is the part of `x - c` across `n`. So the
    /// quadratic part is `d^T (I - n n^T) d` times a half of `[1 / max |x|, 1 / min T]`.
    #[inline(always)]
    fn form(&self, x: &[Interval; 3], combine: Combine<'_, 3>) -> Form<3> {
        let c = x.map(Interval::mid);
        let r = self.value(c);
        let n = c.map(|c| c / r);
        let tangent = combine(&n);
        let far = self.range(*x).hi;
        let error = 8.0 * ROUNDOFF * (x[0].mag() + x[1].mag() + x[2].mag());
        // Past the origin the tangent may be no more than the rounding of `n`; and squares of lengths
        // below 1e-140 are subnormal, so that `n` is no unit vector.
        let near = tangent.lo - error;
        if !(near > 0.0 && far.is_finite() && r > 1e-140) {
            return Form::constant(self.range(*x));
        }
        let one = Interval::point(1.0);
        let bend = Interval { lo: (one / Interval::point(far)).lo, hi: (one / Interval::point(near)).hi };
        // Entries of the matrix are off by 8 roundoffs, which a box that nearly meets the origin
        // (where the length bends most) magnifies.
        let reach: f64 = x.iter().map(|x| x.rad()).sum();
        let blur = 8.0 * ROUNDOFF * reach * reach * bend.hi;
        let matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { 1.0 - n[i] * n[j] } else { -n[i] * n[j] })
        });
        Form { slope: n, rest: Interval::around(r, error + blur), bend, matrix }
    }
}

/// A component of a unit vector, given the reciprocal of the vector's length.
#[inline(always)]
fn unit<R: Real>(x: R, shrink: R) -> R {
    (x * shrink).max(R::of(-1.0)).min(R::of(1.0))
}

/// Distance from where two half planes at a right angle meet, given the distances from both: the larger one inside of
/// both, `sqrt(a^2 + b^2)` outside of both.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Corner;

impl Function<2> for Corner {
    fn class(&self) -> Class {
        Class::C0
    }
    fn shares(&self) -> Option<Interval> {
        Some(Interval { lo: 1.0, hi: std::f64::consts::SQRT_2.next_up() })
    }
    #[inline(always)]
    fn value<R: Real>(&self, [a, b]: [R; 2]) -> R {
        let zero = R::of(0.0);
        (a.max(zero).square() + b.max(zero).square()).sqrt() + a.max(b).min(zero)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [a, b]: [R; 2]) -> [R; 2] {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let [ua, ub, _] = outward([a, b]);
        // At the corner itself the middle of all slopes around it is as good as any.
        let is_corner = ua + ub;
        let middle = R::of(std::f64::consts::FRAC_1_SQRT_2);
        let [ua, ub] = [ua, ub].map(|u| is_corner.if_less(R::of(0.5), middle, u));
        // Inside of the other, a half plane matters alone where it is outside, and where it is nearer.
        let nearer = a.if_less(b, zero, one);
        let inside = |a: R, nearer: R| a.if_less(zero, nearer, one);
        let outside = |a: R, unit: R| a.if_less(zero, zero, unit);
        let by_a = b.if_less(zero, inside(a, nearer), outside(a, ua));
        [by_a, a.if_less(zero, inside(b, one - nearer), outside(b, ub))]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [a, b]: [R; 2]) -> [[R; 2]; 2] {
        let zero = R::of(0.0);
        let [ua, ub, shrink] = outward([a, b]);
        // Round outside of both, a crease inside of both, flat elsewhere; no bound at the corner itself.
        let crease = (a - b).slope_of_jump();
        let tip = (a.abs() + b.abs()).slope_of_jump();
        let part =
            |round: R| a.if_less(zero, b.if_less(zero, crease, zero), b.if_less(zero, zero, round)) + tip;
        let mixed = part(-(ua * ub) * shrink);
        [[part(ub.square() * shrink), mixed], [mixed, part(ua.square() * shrink)]]
    }
    /// It rises with both.
    #[inline(always)]
    fn range(&self, [x, y]: [Interval; 2]) -> Interval {
        let low = self.value([Interval::point(x.lo), Interval::point(y.lo)]);
        low.hull(self.value([Interval::point(x.hi), Interval::point(y.hi)]))
    }
    fn steepness(&self, _: &[Interval; 2], _: &[f64; 2], jacobian: f64) -> f64 {
        // The partial derivatives are a unit vector.
        jacobian
    }
}

/// The unit vector from the corner outside of both half planes, zero at the corner itself, and the reciprocal of the
/// distance.
#[inline(always)]
fn outward<R: Real>([a, b]: [R; 2]) -> [R; 3] {
    let (a, b) = (a.max(R::of(0.0)), b.max(R::of(0.0)));
    let shrink = R::of(1.0) / (a.square() + b.square()).sqrt().max(R::of(1e-300));
    [unit(a, shrink), unit(b, shrink), shrink]
}

/// `a . b` of `(a1, a2, a3, b1, b2, b3)`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Dot;

impl Function<6> for Dot {
    #[inline(always)]
    fn value<R: Real>(&self, [a, b, c, d, e, f]: [R; 6]) -> R {
        a * d + b * e + c * f
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [a, b, c, d, e, f]: [R; 6]) -> [R; 6] {
        [d, e, f, a, b, c]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, _: [R; 6]) -> [[R; 6]; 6] {
        let entry = |i: usize, j: usize| R::of(if i.abs_diff(j) == 3 { 1.0 } else { 0.0 });
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }
    #[inline(always)]
    fn is_quadratic(&self) -> bool {
        true
    }
}
