//! One piece of a strand: a cubic in space whose fourth coordinate is the radius.

use crate::num::Interval;
use glam::{DVec3, DVec4, Vec4Swizzles};

/// The chord of an angle, up to a right one, is less than this for its sine.
pub(super) const CHORD: f64 = 1.4143;

/// A Bezier cubic, `t` from 0 to 1: positions, and radii as `w`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece(pub [DVec4; 4]);

/// What `g(t) = |x - C(t)| - R(t)` is at one `t`.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// `g`.
    pub value: f64,
    /// `|x - C|`.
    pub distance: f64,
    /// From `C` to `x`, of unit length; zero at `C` itself.
    pub toward: DVec3,
    /// `g'`.
    pub slope: f64,
    /// `g''`; not a number at `C` itself.
    pub bend: f64,
    /// `C'`.
    pub tangent: DVec3,
}

/// What `g` does over the whole piece, seen from one point.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// `g` in the middle.
    pub middle: Reading,
    /// `g >= floor`.
    pub floor: f64,
    /// `g''` lies herein.
    pub bend: Interval,
    /// How far `toward` gets from where it points in the middle.
    pub turn: f64,
    /// `|d toward / dt|` is no more.
    pub swing: f64,
}

/// What is known of a piece wherever it is seen from.
#[derive(Clone, Copy, Debug)]
pub struct Hull {
    middle: DVec3,
    /// The piece and its balls are within this of the middle.
    radius: f64,
    /// Coefficients of `C''`.
    bends: [DVec3; 2],
    /// `|C'|^2` is no less; zero if the radius varies.
    slow: f64,
}

impl Hull {
    /// `g` is no less.
    #[inline(always)]
    pub fn floor(&self, x: DVec3) -> f64 {
        (x - self.middle).length() - self.radius
    }

    /// Whether one place alone is nearest: the square of the distance is convex, since
    ///
    /// ```text
    /// d^2/dt^2 |x - C|^2 / 2  =  |C'|^2 - (x - C) . C''  >=  min |C'|^2 - max over i, j of (x - P_i) . C''_j  >  0
    /// ```
    #[inline(always)]
    pub fn is_single(&self, piece: &Piece, x: DVec3) -> bool {
        let pull = |p: &DVec4| self.bends.map(|bend| (x - p.xyz()).dot(bend));
        let most = piece.0.iter().flat_map(pull).fold(0.0, f64::max);
        self.slow > most * (1.0 + 1e-9)
    }
}

impl View {
    /// Whether `g` goes one way only, since `g'` differs by no more than half of `g''` from what it is in the middle.
    pub fn is_monotonic(&self) -> bool {
        self.middle.slope.abs() > 0.5 * self.bend.mag() * (1.0 + 1e-9)
    }
}

impl Piece {
    /// The straight piece between two ends.
    pub fn straight(a: DVec4, b: DVec4) -> Piece {
        Piece([a, a + (b - a) / 3.0, b - (b - a) / 3.0, b])
    }

    /// What is known of it wherever it is seen from.
    pub fn hull(&self) -> Hull {
        let [a, b, c, d] = self.0.map(|p| p.xyz());
        let tangents = [b - a, c - b, d - c].map(|v| 3.0 * v);
        let along = (d - a).normalize_or_zero();
        let slow = tangents.iter().map(|t| t.dot(along)).fold(f64::INFINITY, f64::min).max(0.0);
        let middle = self.at(0.5)[0].xyz();
        let radius = self.0.iter().map(|p| (p.xyz() - middle).length() + p.w).fold(0.0, f64::max);
        let is_even = self.0.iter().all(|p| p.w == self.0[0].w);
        Hull {
            middle,
            radius: radius * (1.0 + 1e-12),
            bends: [c - b - (b - a), d - c - (c - b)].map(|v| 6.0 * v),
            slow: if is_even { slow * slow } else { 0.0 },
        }
    }

    /// The two halves.
    #[inline]
    pub fn halves(&self) -> [Piece; 2] {
        self.cut(0.5)
    }

    /// The two parts before and after `t`.
    #[inline]
    pub fn cut(&self, t: f64) -> [Piece; 2] {
        let [a, b, c, d] = self.0;
        let between = |a: DVec4, b: DVec4| a + t * (b - a);
        let (ab, bc, cd) = (between(a, b), between(b, c), between(c, d));
        let (abc, bcd) = (between(ab, bc), between(bc, cd));
        let m = between(abc, bcd);
        [Piece([a, ab, abc, m]), Piece([m, bcd, cd, d])]
    }

    /// The parts between places in ascending order; those outside of the piece, or next to an end or to
    /// one another, do not count.
    pub fn cuts(&self, places: &[f64]) -> Vec<Piece> {
        let (mut parts, mut rest, mut from) = (Vec::new(), *self, 0.0);
        for t in places {
            if *t > from + 1e-9 && *t < 1.0 - 1e-9 {
                let [first, second] = rest.cut((t - from) / (1.0 - from));
                parts.push(first);
                (rest, from) = (second, *t);
            }
        }
        parts.push(rest);
        parts
    }

    /// Position and radius, and their first and second derivatives.
    #[inline]
    pub fn at(&self, t: f64) -> [DVec4; 3] {
        let [a, b, c, d] = self.0;
        let s = 1.0 - t;
        let (ab, bc, cd) = (s * a + t * b, s * b + t * c, s * c + t * d);
        let (abc, bcd) = (s * ab + t * bc, s * bc + t * cd);
        let (turn, next) = (c - b - (b - a), d - c - (c - b));
        [s * abc + t * bcd, 3.0 * (bcd - abc), 6.0 * (s * turn + t * next)]
    }

    /// `g` at `t` as seen from a point.
    #[inline]
    pub fn read(&self, x: DVec3, t: f64) -> Reading {
        let [place, first, second] = self.at(t);
        reading(x, place, first, second)
    }

    /// What `g` does over the whole piece. With `V_i = x - P_i` and `R_i` the control points, `u` the
    /// direction from the middle, and `w` the largest `|V_i - V(1/2)|`:
    ///
    /// - `|x - C| >= u . (x - C)`, and the hull of its coefficients bounds a cubic: `g >= min u . V_i - R_i`;
    /// - `x - C` stays within `w` of where it is in the middle, and so, for `w < |V(1/2)|`, within the
    ///   angle `asin(w / |V(1/2)|)`, whose chord is at most `sqrt 2` times its sine;
    /// - `g'' = |C' x u(t)|^2 / |x - C| - u(t) . C'' - R''`, where `C'`, `C''` and `R''` lie in the
    ///   hulls of their coefficients and `u(t)` is as near to `u` as that chord;
    /// - `g >= g(1/2) + g'(1/2) (t - 1/2) + min g'' (t - 1/2)^2 / 2`.
    ///
    /// Nothing if all of `g` is at or above a limit.
    #[inline]
    pub fn view(&self, x: DVec3, limit: f64) -> Option<View> {
        let [a, b, c, d] = self.0;
        let [place, first, second] =
            [0.125 * (a + d + 3.0 * (b + c)), 0.75 * (d - a + (c - b)), 3.0 * (a + d - (b + c))];
        let middle = reading(x, place, first, second);
        let (u, from) = (middle.toward, x - place.xyz());
        let away = self.0.map(|p| x - p.xyz());
        let most = |list: &[f64]| list.iter().fold(f64::NEG_INFINITY, |m: f64, v| m.max(*v));
        let least = |list: &[f64]| list.iter().fold(f64::INFINITY, |m: f64, v| m.min(*v));
        let spread = most(&away.map(|v| (v - from).length()));
        let near = middle.distance - spread;
        let plane = least(&[0, 1, 2, 3].map(|i| u.dot(away[i]) - self.0[i].w));
        let floor = plane.max(near - most(&self.0.map(|p| p.w)));
        if floor >= limit {
            return None;
        }
        if near <= 1e-9 * middle.distance {
            return Some(View { middle, floor, bend: Interval::ENTIRE, turn: 2.0, swing: f64::INFINITY });
        }
        let turn = CHORD * spread / middle.distance;
        let tangents = [b - a, c - b, d - c].map(|v| 3.0 * v.xyz());
        let bends = [c - b - (b - a), d - c - (c - b)].map(|v| 6.0 * v);
        let across = tangents.map(|v| v - u.dot(v) * u);
        let loose = turn * most(&tangents.map(DVec3::length));
        let side = (across[0] + 2.0 * across[1] + across[2]).normalize_or_zero();
        let slow = (least(&across.map(|v| side.dot(v))) - loose).max(0.0);
        let fast = most(&across.map(DVec3::length)) + loose;
        let far = most(&away.map(DVec3::length));
        let pull = bends.map(|v| u.dot(v.xyz()) + v.w);
        let slack = turn * most(&bends.map(|v| v.xyz().length()));
        let bend = Interval {
            lo: slow * slow / far - most(&pull) - slack,
            hi: fast * fast / near - least(&pull) + slack,
        };
        let tip = middle.slope.abs() / bend.lo;
        let sag = if bend.lo > 0.0 && tip < 0.5 {
            -0.5 * middle.slope.abs() * tip
        } else {
            0.125 * bend.lo - 0.5 * middle.slope.abs()
        };
        let floor = floor.max(middle.value + sag);
        (floor < limit).then_some(View { middle, floor, bend, turn, swing: fast / near })
    }

    /// Where `g` is least over a straight piece along which the radius changes evenly. With `l` its
    /// length, `k` the change of the radius over it, `y` and `q` the coordinates of `x` along and across,
    ///
    /// ```text
    /// g = sqrt(q^2 + (y - t l)^2) - R - t k       least where       t l = y + q k / sqrt(l^2 - k^2)
    /// ```
    ///
    /// and if `|k| >= l`, one end's ball holds all others.
    #[inline]
    pub fn straight_bottom(&self, x: DVec3) -> f64 {
        let [start, _, _, end] = self.0;
        let (step, from) = ((end - start).xyz(), x - start.xyz());
        let (square, k) = (step.length_squared(), end.w - start.w);
        let free = square - k * k;
        if free <= 0.0 {
            return if k > 0.0 { 1.0 } else { 0.0 };
        }
        let y = from.dot(step) / square;
        let across = (from - y * step).length();
        (y + across * k / (free * square).sqrt()).clamp(0.0, 1.0)
    }

    /// Where `g`, convex over the piece, is least: Newton's steps, halving where they leave what is known to hold the
    /// place. They look for where `k = |x - C| g'` is zero, which close to the curve does not bend as `g'` does.
    #[inline]
    pub fn bottom(&self, x: DVec3) -> f64 {
        let (mut lo, mut hi) = (0.0, 1.0);
        let ([start, _], [end, _]) = (self.pull(x, lo), self.pull(x, hi));
        if start >= 0.0 {
            return lo;
        }
        if end <= 0.0 {
            return hi;
        }
        let mut t = start / (start - end);
        for _ in 0..64 {
            let [k, rate] = self.pull(x, t);
            let step = k / rate;
            // The next step would be its square.
            if step.abs() <= 1e-9 {
                return (t - step).clamp(lo, hi);
            }
            if k > 0.0 {
                hi = t;
            } else {
                lo = t;
            }
            let newton = t - step;
            t = if newton > lo && newton < hi { newton } else { 0.5 * (lo + hi) };
            if hi - lo <= f64::EPSILON * hi {
                break;
            }
        }
        t
    }

    /// `k = |x - C| g' = (C - x) . C' - R' |x - C|` at `t`, and its derivative.
    #[inline(always)]
    fn pull(&self, x: DVec3, t: f64) -> [f64; 2] {
        let [place, first, second] = self.at(t);
        let away = x - place.xyz();
        let (distance, along) = (away.length(), -away.dot(first.xyz()));
        let grows = if distance > 0.0 { along / distance } else { 0.0 };
        let bend = first.xyz().length_squared() - away.dot(second.xyz());
        [along - first.w * distance, bend - second.w * distance - first.w * grows]
    }
}

#[inline(always)]
fn reading(x: DVec3, place: DVec4, first: DVec4, second: DVec4) -> Reading {
    let away = x - place.xyz();
    let distance = away.length();
    let toward = if distance > 0.0 { away / distance } else { DVec3::ZERO };
    let along = toward.dot(first.xyz());
    let across = first.xyz() - along * toward;
    Reading {
        value: distance - place.w,
        distance,
        toward,
        slope: -along - first.w,
        bend: across.length_squared() / distance - toward.dot(second.xyz()) - second.w,
        tangent: first.xyz(),
    }
}
