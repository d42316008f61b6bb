//! Strands: chains of cubics with a radius that varies along them, and the distance from their surface.
//!
//! ```text
//! f(x) = min over t of g_t(x),      g_t(x) = |x - C(t)| - R(t)
//! ```
//!
//! is the distance to the union of the balls about `C(t)` with radii `R(t)`, negative inside. Lines
//! along which the radius changes evenly (round cones) are solved by a formula. Cubics are searched: a
//! piece is left as soon as a lower bound for all of it is not below the best so far, that of a ball about it
//! ([`Hull::floor`]) or a better one ([`Piece::view`]). From most places the square of the distance is convex
//! over a piece ([`Hull::is_single`]), or `g` itself is, or goes one way only; then Newton's steps find where it is
//! least, and else the piece is halved. No nearest point is missed; ties are decided by the order of the search,
//! which depends on the point alone.
//!
//! **Around a point** `c`, with `t*` the nearest place, `u_t` the direction from `C(t)` to `c`,
//! `u = u_t*`, `D = |c - C(t*)|`: every `g_t` is convex in `x` with slope `u_t`, and `g_t*` is above its
//! tangent plane by what a cone of circles is, so for `|h| <= r`
//!
//! ```text
//! f(c + h) <= f(c) + u . h + r^2 / 2D        for r <= 2D
//! f(c + h) >= min over t of g_t(c) + u_t . h  >=  u . h + min over t of (g_t(c) - |u_t - u| r)
//! ```
//!
//! The last minimum is searched as the nearest point is, over what is within `2 r` of being nearest. Where
//! `g >= g_p + m (t - p)^2 / 2` and `u_t` turns by at most `tau |t - p|`, it is at least
//! `g_p - |u_p - u| r - (tau r)^2 / (2 m)`: the enclosure is quadratic in `r` where the strand is smooth,
//! and where two places are equally near it is as wide as the crease is sharp.

mod lean;
mod piece;
#[cfg(test)]
mod tests;

use piece::Hull;
pub(super) use piece::{Piece, Reading};

use super::Digest;
use super::boxes::{Boxes, Extent};
use crate::num::{Bounds, Interval, Order, PAIRS, Point, ROUNDOFF};
use glam::{DVec3, DVec4, Vec4Swizzles};

/// How far off a nearest distance may be, by the size of the coordinates: places that differ by less tie.
const SLACK: f64 = 1.0 / (1u64 << 40) as f64;

/// Beyond this, squares of coordinates are not numbers.
const FAR: f64 = 1e100;

/// Halvings of a piece: what is left is less than the slack.
const HALVINGS: u8 = 44;

/// Halvings of a piece in search of a bow, which need not be the tightest.
const COARSE: u8 = 16;

/// Parts that the search for a bow looks at; a bow that takes longer is not worth it.
const PATIENCE: u32 = 160;

/// Bounds of distances: they go up without end, and are creased.
pub(super) const BOUNDS: Bounds = Bounds {
    range: f64::INFINITY,
    lipschitz: 1.0 + 16.0 * ROUNDOFF,
    hessian: f64::INFINITY,
    third: f64::INFINITY,
};

/// Pieces, and the boxes around them.
#[derive(Debug)]
pub(super) struct Strand {
    pieces: Vec<Piece>,
    /// Whether each piece is straight and changes its radius evenly.
    straight: Vec<bool>,
    hulls: Vec<Hull>,
    /// The number of the piece that it was part of before it was cut.
    origins: Vec<usize>,
    boxes: Boxes,
    /// Largest coordinate, radii included.
    size: f64,
}

/// The nearest place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// On which piece.
    pub piece: usize,
    /// Where on it.
    pub t: f64,
    /// `f`.
    pub value: f64,
}

impl Foot {
    /// Whether it is at no end of the piece.
    pub fn is_within(&self) -> bool {
        self.t > 0.0 && self.t < 1.0
    }
}

/// A part of a piece that waits to be searched.
#[derive(Clone, Copy)]
struct Part {
    piece: Piece,
    /// Where it starts, and how long it is.
    from: f64,
    length: f64,
    halvings: u8,
}

impl Part {
    fn whole(piece: &Piece) -> Part {
        Part { piece: *piece, from: 0.0, length: 1.0, halvings: 0 }
    }

    #[inline(always)]
    fn halves(&self) -> [Part; 2] {
        let length = 0.5 * self.length;
        let [a, b] = self.piece.halves();
        let part = |piece, from| Part { piece, from, length, halvings: self.halvings + 1 };
        [part(a, self.from), part(b, self.from + length)]
    }
}

impl Strand {
    /// The strand of pieces; each is told with whether it is straight and changes its radius evenly.
    pub fn new(parts: impl IntoIterator<Item = (Piece, bool)>) -> Strand {
        let (mut pieces, mut straight, mut origins) = (Vec::new(), Vec::new(), Vec::new());
        for (origin, (piece, plain)) in parts.into_iter().enumerate() {
            gentle(piece, if plain { 0 } else { 6 }, &mut pieces);
            straight.resize(pieces.len(), plain);
            origins.resize(pieces.len(), origin);
        }
        let extents: Vec<Extent> = pieces.iter().map(Strand::extent).collect();
        let size = pieces.iter().flat_map(|p| p.0).fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
        let hulls = pieces.iter().map(Piece::hull).collect();
        Strand { boxes: Boxes::new(&extents), pieces, straight, hulls, origins, size }
    }

    fn extent(piece: &Piece) -> Extent {
        let girth = piece.0.iter().fold(f64::NEG_INFINITY, |m: f64, p| m.max(p.w));
        Extent::of(piece.0.map(|p| p.xyz()), girth)
    }

    /// Takes all pieces in.
    pub fn digest(&self, digest: &mut Digest) {
        digest.whole(self.pieces.len() as u64);
        for (piece, straight) in self.pieces.iter().zip(&self.straight) {
            digest.numbers(piece.0.iter().flat_map(DVec4::to_array));
            digest.whole(u64::from(*straight));
        }
    }

    /// The pieces.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The number of the piece that each was part of when it came.
    pub fn origins(&self) -> &[usize] {
        &self.origins
    }

    /// Largest coordinate or radius.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Whether a point is a point, and not too far away to square its coordinates.
    pub fn reaches(x: DVec3) -> bool {
        x.is_finite() && x.abs().max_element() <= FAR
    }

    /// How far off a value may be at a point whose largest coordinate is `size`.
    pub fn slack(&self, size: f64) -> f64 {
        SLACK * (size + self.size)
    }

    /// Visits all pieces that may be below a limit at a point, those in nearer boxes first. A visit tells the limit from
    /// then on.
    #[inline(always)]
    fn below(&self, x: DVec3, mut limit: f64, mut visit: impl FnMut(usize) -> f64) {
        self.boxes.below(x, limit, |i| {
            // What is not a number is not known to be above.
            let is_above = self.hulls[i].floor(x) >= limit;
            if !is_above {
                limit = visit(i);
            }
            limit
        });
    }

    /// The nearest place to a point that is not [too far](FAR).
    #[inline]
    fn foot(&self, x: DVec3) -> Foot {
        let slack = 0.5 * self.slack(x.abs().max_element());
        let mut best = Foot { piece: 0, t: 0.0, value: f64::INFINITY };
        let mut aside = Vec::new();
        self.below(x, f64::INFINITY, |i| {
            self.search(i, x, slack, &mut best, &mut aside);
            best.value - slack
        });
        best
    }

    /// Searches a piece for a place that is nearer than the best so far.
    #[inline]
    fn search(&self, number: usize, x: DVec3, slack: f64, best: &mut Foot, aside: &mut Vec<Part>) {
        let whole = &self.pieces[number];
        let mut limit = best.value - slack;
        let mut take = |t: f64| {
            let value = whole.read(x, t).value;
            if value < best.value {
                *best = Foot { piece: number, t, value };
            }
            best.value
        };
        if self.straight[number] {
            take(whole.straight_bottom(x));
            return;
        }
        if self.hulls[number].is_single(whole, x) {
            take(whole.bottom(x));
            return;
        }
        let mut next = Some(Part::whole(whole));
        while let Some(part) = next.take().or_else(|| aside.pop()) {
            let Some(view) = part.piece.view(x, limit) else { continue };
            if view.is_monotonic() {
                let end = if view.middle.slope > 0.0 { 0.0 } else { part.length };
                limit = take(part.from + end) - slack;
                continue;
            }
            if view.bend.lo > 0.0 {
                limit = take(part.from + part.length * part.piece.bottom(x)) - slack;
                continue;
            }
            if part.halvings == 0 {
                take(0.0);
                take(1.0);
            }
            limit = take(part.from + 0.5 * part.length) - slack;
            // Where the distance curves down, it is least at an end, and ends are taken already.
            if view.bend.hi > 0.0 && part.halvings < HALVINGS {
                aside.extend(part.halves());
            }
        }
    }

    /// What is at the nearest place.
    #[inline]
    pub fn reading(&self, x: DVec3) -> (Foot, Reading) {
        let foot = self.foot(x);
        (foot, self.pieces[foot.piece].read(x, foot.t))
    }

    /// The jet at a point.
    #[inline]
    pub fn jet(&self, order: Order, x: DVec3) -> Point {
        let far = x.abs().max_element();
        if !Strand::reaches(x) {
            // All of the strand is one point from there.
            let unit = x / far;
            return Point { value: far * unit.length(), grad: unit.normalize().into(), hess: [0.0; 6] };
        }
        let (foot, reading) = self.reading(x);
        self.jet_of(order, &foot, &reading)
    }

    /// The jet that a nearest place gives. Within the strand,
    /// `H = (I - u u^T) / D - w w^T / g''` with `w = (C' - (u . C') u) / D`: the place moves as `x` does.
    /// At an end it stays.
    fn jet_of(&self, order: Order, foot: &Foot, at: &Reading) -> Point {
        let (u, d) = (at.toward, at.distance);
        let mut jet = Point { value: at.value, grad: u.into(), hess: [0.0; 6] };
        if order == Order::Hessian && d > 0.0 {
            let moves = foot.is_within() && at.bend > 0.0;
            let w = if moves { (at.tangent - u.dot(at.tangent) * u) / d } else { DVec3::ZERO };
            let bend = if moves { at.bend } else { 1.0 };
            for (pair, (r, c)) in PAIRS.into_iter().enumerate() {
                let unit = if r == c { 1.0 } else { 0.0 };
                jet.hess[pair] = (unit - u[r] * u[c]) / d - w[r] * w[c] / bend;
            }
        }
        jet
    }

    /// The jet at a point, and the bow in the ball of a radius around it.
    pub fn around(&self, order: Order, x: DVec3, radius: f64) -> (Point, Interval) {
        if !Strand::reaches(x) || !Strand::reaches(DVec3::splat(radius)) {
            return (self.jet(order, x), Interval::ENTIRE);
        }
        let (foot, reading) = self.reading(x);
        (self.jet_of(order, &foot, &reading), self.bow(x, radius, &reading, reading.toward))
    }

    /// The bow in a ball around a point, from what is at its nearest place, if the gradient is said to be
    /// `u`: that of the distance, or nearly so, which is charged for.
    pub fn bow(&self, x: DVec3, radius: f64, at: &Reading, u: DVec3) -> Interval {
        let d = at.distance;
        // A ball that reaches the strand is bounded as well by how fast the distance changes, and cheaper.
        if radius >= d && radius > 0.0 {
            return Interval::ENTIRE;
        }
        let above = if radius > 0.0 { 0.5 * radius * radius / d } else { 0.0 };
        let above = above + (at.toward - u).length() * radius;
        // Nothing is lower than all that may be as steep the other way; nor need it be less than above.
        let least = at.value - above.min(2.0 * radius);
        let mut dip = Dip { x, radius, value: at.value, u, least, patience: PATIENCE };
        let mut aside = Vec::new();
        self.below(x, dip.limit(), |i| {
            dip.search(&self.pieces[i], &mut aside);
            dip.limit()
        });
        let slack = self.slack(x.abs().max_element() + radius);
        Interval { lo: dip.least - at.value - slack, hi: above + slack }
    }

    /// How far at most the strand gets from the plane through `p` with unit normal `n`, either way, within
    /// `reach` of `c`; nothing if that is more than `most`, or may be. Radii do not count.
    pub fn band(&self, (c, reach): (DVec3, f64), (p, n): (DVec3, DVec3), most: f64) -> Option<f64> {
        let mut widest = 0.0;
        let mut aside = Vec::new();
        self.below(c, reach, |i| {
            let mut next = Some(Part::whole(&self.pieces[i]));
            while let Some(part) = next.take().or_else(|| aside.pop()) {
                let ends = part.piece.0.map(|q| q.xyz());
                let beside = ends.map(|q| n.dot(q - p).abs());
                let wide = beside.iter().fold(widest, |m: f64, b| m.max(*b));
                if wide <= widest || Extent::of(ends, 0.0).floor(c) >= reach {
                    continue;
                }
                let within = ends.iter().all(|q| (q - c).length() <= reach);
                let touched = beside[0].max(beside[3]).max(widest);
                if part.halvings >= HALVINGS || within && (touched > most || wide <= 1.25 * touched) {
                    widest = wide;
                } else {
                    aside.extend(part.halves());
                }
            }
            if widest > most { f64::NEG_INFINITY } else { reach }
        });
        (widest <= most).then_some(widest)
    }
}

/// The search for how far the strand gets below a tangent plane in a ball.
struct Dip {
    x: DVec3,
    radius: f64,
    /// `f` at the centre.
    value: f64,
    /// Slope of the plane.
    u: DVec3,
    /// No more than `g_t - |u_t - u| r` on all pieces so far.
    least: f64,
    /// Parts that it may still look at.
    patience: u32,
}

impl Dip {
    /// Places whose distance is above are of no account.
    fn limit(&self) -> f64 {
        self.least + 2.0 * self.radius
    }

    /// `g_t - |u_t - u| r` at a place.
    fn turned(&self, at: &Reading) -> f64 {
        at.value - self.radius * (at.toward - self.u).length()
    }

    /// Takes a piece in.
    fn search(&mut self, piece: &Piece, aside: &mut Vec<Part>) {
        let (x, r) = (self.x, self.radius);
        let mut next = Some(Part::whole(piece));
        while let Some(part) = next.take().or_else(|| aside.pop()) {
            let Some(view) = part.piece.view(x, self.limit()) else { continue };
            // All that the Lipschitz constant says is said at once.
            self.patience = self.patience.saturating_sub(1);
            if self.patience == 0 {
                self.least = self.least.min(self.value - 2.0 * r);
            }
            let turn = (view.middle.toward - self.u).length() + view.turn;
            let mut floor = view.floor - r * turn.min(2.0);
            if floor >= self.least {
                continue;
            }
            // Good enough: close to what is there, or to the best that curvature allows.
            let found = self.turned(&view.middle);
            let mut settled = part.halvings >= COARSE || found - floor <= 0.25 * (self.value - found);
            if view.bend.lo > 0.0 {
                let bottom = part.piece.read(x, part.piece.bottom(x));
                let sag = r * r * view.swing * view.swing / (2.0 * view.bend.lo);
                floor = floor.max(self.turned(&bottom) - sag);
                let across = bottom.tangent - bottom.toward.dot(bottom.tangent) * bottom.toward;
                let swing = across.length() / bottom.distance;
                settled |= sag <= 1.5 * r * r * swing * swing / (2.0 * bottom.bend);
            }
            if floor >= self.least {
                continue;
            }
            if settled {
                self.least = floor;
            } else {
                aside.extend(part.halves());
            }
        }
    }
}

/// Halves a piece until it neither turns nor changes its speed much, so that from most places one of its
/// points is the nearest and known to be the only one.
fn gentle(piece: Piece, halvings: u8, out: &mut Vec<Piece>) {
    let [a, b, c, d] = piece.0.map(|p| p.xyz());
    let turn = (c - b - (b - a)).length().max((d - c - (c - b)).length());
    if halvings == 0 || turn <= 0.1 * (d - a).length() {
        out.push(piece);
    } else {
        piece.halves().into_iter().for_each(|half| gentle(half, halvings - 1, out));
    }
}
