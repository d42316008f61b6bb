//! Convolution surfaces: skeletons of points, segments, arcs and triangles, by the hundred, whose flesh
//! melts together without seams.
//!
//! ```text
//! f(x) = scale (threshold - sum_i a_i F_i(x)),      F_i(x) = integral over primitive i of k(|x - u|) du
//! ```
//!
//! in closed form (`primitive.rs`), with the Cauchy kernel `k = 1 / (1 + s^2 r^2)^2`, which reaches
//! everywhere and is smooth, or the compact one `(1 - r^2 / R^2)^2`, which ends at `R` and is C1. The
//! integral is linear: a segment in two halves is the segment. Kernels are measured by the *width*, the
//! radius of a long thread at threshold 1/2, and `scale` is such that `f` has unit slope there.
//!
//! **Around a point.** Skeletons are cut into *bits*, no longer than the kernel is wide, with boxes around
//! them. If all of a box is at least `d` away, what is in it adds no more than its share times the most
//! that a derivative of the kernel can be at `d` and beyond. For the Cauchy kernel, with `p = s d`, of the
//! third derivatives
//!
//! ```text
//! |D^3 k[h, h, h]| = s^3 |72 a / (1 + p^2)^4 - 192 a^3 / (1 + p^2)^5|,  |a| <= p,     <= 120 s^3 p / (1 + p^2)^4
//! ```
//!
//! (largest at `p^2 = 1/7`), which with the Hessian at the centre bounds everything in a ball. The
//! compact kernel has second derivatives up to `max(4 / R^2, 8 / R^2)` where it is, that is within `R`.

mod primitive;
mod taylor;
#[cfg(test)]
mod tests;

pub use primitive::{Arc, Primitive};

use super::boxes::{Boxes, Extent, Group};
use super::{Body, Digest, lanes};
use crate::num::{Bounds, Class, Interval, Jets, Kernel, Local, Order, Point, ROUNDOFF};
use glam::DVec3;
use primitive::Falloff;

/// A kernel, by its width.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Density {
    /// Smooth, everywhere.
    Cauchy(f64),
    /// Nothing beyond about twice the width; for points and segments only.
    Compact(f64),
}

impl Density {
    /// The kernel, and the scale of unit slope. A thread of the Cauchy kernel is `(1 + s^2 r^2)^(-3/2)`,
    /// of the compact one `(1 - r^2 / R^2)^(5/2)`; both are 1/2 at the width.
    fn falloff(self) -> (Falloff, f64) {
        match self {
            Density::Cauchy(width) => {
                let square = libm::cbrt(4.0) - 1.0;
                (Falloff::Cauchy(square.sqrt() / width), width * libm::cbrt(4.0) / (1.5 * square))
            }
            Density::Compact(width) => {
                let rest = libm::pow(0.5, 0.4);
                (Falloff::Compact(width / (1.0 - rest).sqrt()), width * rest / (2.5 * (1.0 - rest)))
            }
        }
    }
}

/// Primitives that a skeleton may have.
pub const MOST_PRIMITIVES: usize = 100_000;

/// Bits that a primitive is cut into at most, along an edge.
const MOST_BITS: f64 = 64.0;

/// Why there is no such surface.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum Flaw {
    /// None, or too many.
    #[error("a skeleton has from 1 to {MOST_PRIMITIVES} parts, not {0}")]
    Count(usize),
    /// A number is not one, or too large.
    #[error("part {0} of the skeleton is not finite, or beyond 1e9 widths")]
    Lost(usize),
    /// The kernel has no closed form there.
    #[error("the compact kernel works on points and segments only, and part {0} is neither")]
    Kernel(usize),
}

/// A skeleton with flesh.
#[derive(Debug)]
pub struct Convolution {
    parts: Vec<(Primitive, f64)>,
    falloff: Falloff,
    threshold: f64,
    scale: f64,
    /// Boxes around the parts, which the compact kernel may be out of reach of.
    near: Boxes,
    bits: Bits,
    bounds: Bounds,
    /// Largest coordinate.
    size: f64,
    /// Sum of the most that each part can be.
    weight: f64,
    /// Whether some parts take away, and whether some are arcs.
    takes: bool,
    arcs: bool,
}

impl Convolution {
    /// The surface where the weighted sum of the primitives' densities is the threshold.
    ///
    /// # Errors
    /// When there are no primitives or too many, or one is lost or has no closed form.
    pub fn new(parts: &[(Primitive, f64)], density: Density, threshold: f64) -> Result<Convolution, Flaw> {
        if !(1..=MOST_PRIMITIVES).contains(&parts.len()) {
            return Err(Flaw::Count(parts.len()));
        }
        let (falloff, scale) = density.falloff();
        let reach = 1.0 / falloff.rate();
        let mut bits = Vec::new();
        let mut extents = Vec::with_capacity(parts.len());
        for (i, (primitive, weight)) in parts.iter().enumerate() {
            let own = bits.len();
            cut(primitive, reach, &mut bits);
            let share = falloff.unit(primitive) * scale * weight.abs();
            bits[own..].iter_mut().for_each(|bit| bit.share *= share);
            let extent = Extent::around(bits[own..].iter().map(|b| b.extent));
            if !(extent.lo.is_finite() && extent.hi.is_finite() && share.is_finite())
                || extent.lo.abs().max(extent.hi.abs()).max_element() > 1e9 * reach
            {
                return Err(Flaw::Lost(i));
            }
            let known = matches!(primitive, Primitive::Point(_) | Primitive::Segment(_));
            if matches!(falloff, Falloff::Compact(_)) && !known {
                return Err(Flaw::Kernel(i));
            }
            extents.push(extent);
        }
        let units = |(p, weight): &(Primitive, f64)| {
            // What has no length has no integral over it either.
            match p {
                Primitive::Segment([a, b]) if a == b => (Primitive::Point(*a), 0.0),
                _ => (*p, falloff.unit(p) * weight),
            }
        };
        let weight = parts.iter().map(|(p, w)| w.abs() * falloff.height(p)).sum::<f64>();
        let size = extents.iter().fold(0.0, |m: f64, e| m.max(e.lo.abs().max(e.hi.abs()).max_element()));
        let share = bits.iter().map(|b| b.share).sum::<f64>().max(f64::MIN_POSITIVE);
        let bounds = Bounds {
            range: scale * (threshold.abs() + weight) * (1.0 + 1e-9),
            ..most(falloff, 0.0).times(share * (1.0 + 1e-9))
        };
        let takes = parts.iter().any(|(_, weight)| *weight < 0.0);
        let arcs = parts.iter().any(|(primitive, _)| matches!(primitive, Primitive::Arc(_)));
        Ok(Convolution {
            takes,
            arcs,
            parts: parts.iter().map(units).collect(),
            falloff,
            threshold,
            scale,
            near: Boxes::new(&extents),
            bits: Bits::new(bits),
            bounds,
            size,
            weight,
        })
    }

    /// What a value may be off by, but for the rounding of places.
    fn rounding(&self) -> f64 {
        let rate = self.falloff.rate();
        let wide = 1.0 + (rate * self.size) * (rate * self.size);
        let terms = 512.0 * ROUNDOFF * self.scale * (self.weight + self.threshold.abs());
        if self.arcs { terms * wide } else { terms }
    }

    fn jet(&self, order: Order, x: DVec3) -> Point {
        if x.is_nan() {
            return Point { value: f64::NAN, ..Point::default() };
        }
        // Beyond this, powers of distances are not numbers, and the density is nothing.
        let x = x.clamp(DVec3::splat(-1e30), DVec3::splat(1e30));
        let mut out = Point { value: self.scale * self.threshold, ..Point::default() };
        let mut add = |(primitive, weight): &(Primitive, f64)| {
            let p = primitive.integral(self.falloff, order, x);
            let k = -self.scale * weight;
            out.value += k * p.value;
            (0..3).for_each(|i| out.grad[i] += k * p.grad[i]);
            (0..6).for_each(|i| out.hess[i] += k * p.hess[i]);
        };
        match self.falloff {
            Falloff::Cauchy(_) => self.parts.iter().for_each(&mut add),
            Falloff::Compact(r) => self.near.each(|e| e.floor(x) <= r, |i| add(&self.parts[i])),
        }
        out
    }
}

impl Kernel for Convolution {
    fn class(&self) -> Class {
        match self.falloff {
            Falloff::Cauchy(_) => Class::C2,
            Falloff::Compact(_) => Class::C1,
        }
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn jets(&self, at: [&[f64]; 3], out: Jets<'_>) {
        lanes::fill(at, out, |order, x| self.jet(order, x));
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let x = DVec3::from(at);
        if !x.is_finite() || x.abs().max_element().max(radius) > 1e60 {
            return Local::uniform(self.jet(order, x), self.bounds);
        }
        let near = self.bits.around(self.falloff, x, radius);
        let error = self.error(x.abs().max_element());
        match self.falloff {
            Falloff::Cauchy(_) => {
                let third = near.third.min(self.bounds.third);
                Local::smooth(self.jet(Order::Hessian, x), Bounds { third, ..self.bounds }, error, radius)
            }
            Falloff::Compact(_) => {
                let hessian = near.hessian.min(self.bounds.hessian);
                let lipschitz = near.lipschitz.min(self.bounds.lipschitz);
                Local::uniform(self.jet(order, x), Bounds { lipschitz, hessian, ..self.bounds })
            }
        }
    }

    /// Far from all of it there is the threshold and little else.
    fn over(&self, x: &[Interval; 3]) -> Option<Interval> {
        let lo = DVec3::from(x.map(|x| x.lo));
        let hi = DVec3::from(x.map(|x| x.hi));
        if !(lo.is_finite() && hi.is_finite()) {
            return None;
        }
        let most = self.bits.over(self.falloff, lo, hi);
        let least = if self.takes { -most } else { 0.0 };
        let sum = Interval { lo: least, hi: most } + Interval::radius(self.rounding());
        Some(Interval::point(self.scale * self.threshold) - sum)
    }

    /// Closed forms are sums of a few terms up to 1, of which some cancel; arcs much wider than the
    /// kernel lose digits by the square of the ratio, that of the squares in `A^2 - B^2`.
    fn error(&self, size: f64) -> [f64; 3] {
        let (rate, terms) = (self.falloff.rate(), self.rounding());
        let shift = 16.0 * ROUNDOFF * (size + self.size);
        let b = self.bounds;
        [
            terms + b.lipschitz * shift,
            8.0 * terms * rate + b.hessian * shift,
            64.0 * terms * rate * rate + if b.third.is_finite() { b.third * shift } else { 0.0 },
        ]
    }
}

impl Body for Convolution {
    fn name(&self) -> &'static str {
        "convolution"
    }

    fn digest(&self, digest: &mut Digest) {
        let (kind, s) = match self.falloff {
            Falloff::Cauchy(s) => (0, s),
            Falloff::Compact(r) => (1, r),
        };
        digest.whole(kind);
        digest.numbers([s, self.threshold]);
        for (primitive, weight) in &self.parts {
            digest.numbers([*weight]);
            let (kind, points) = match primitive {
                Primitive::Point(p) => (0, vec![*p]),
                Primitive::Segment(p) => (1, p.to_vec()),
                Primitive::Triangle(p) => (2, p.to_vec()),
                Primitive::Arc(arc) => (3, [0.0, 0.5, 1.0].map(|t| arc.at(t)).to_vec()),
            };
            digest.whole(kind);
            digest.numbers(points.iter().flat_map(DVec3::to_array));
        }
    }
}

/// The most that the kernel's derivatives are at a distance and beyond.
fn most(falloff: Falloff, distance: f64) -> Bounds {
    match falloff {
        Falloff::Cauchy(s) => {
            let past = |peak: f64| {
                let p = (s * distance).max(peak);
                (p, 1.0 / (1.0 + p * p))
            };
            let ((a, ka), (_, kb), (c, kc)) = (past(0.2f64.sqrt()), past(0.0), past((1.0f64 / 7.0).sqrt()));
            Bounds {
                range: kb * kb,
                lipschitz: 4.0 * s * a * ka * ka * ka,
                hessian: s * s * (20.0 * kb * kb * kb).min(4.0),
                third: 120.0 * s * s * s * c * kc * kc * kc * kc,
            }
        }
        // Slope 4 r / R^2 (1 - r^2 / R^2), at most 8 / (3 sqrt 3) / R; second derivatives from -4 / R^2 in
        // the middle to 8 / R^2 at the end.
        Falloff::Compact(r) => {
            let inside = if distance < r { 1.0 } else { 0.0 };
            let rest = (1.0 - (distance / r) * (distance / r)).max(0.0);
            Bounds {
                range: rest * rest,
                lipschitz: 1.54 / r * inside,
                hessian: 8.0 / (r * r) * inside,
                third: f64::INFINITY,
            }
        }
    }
}

/// A part of a primitive that is no longer than the kernel is wide.
#[derive(Clone, Copy, Debug)]
struct Bit {
    extent: Extent,
    /// Its measure: one of a point, length or area of others; and then its share in `f`.
    share: f64,
}

/// Cuts a primitive into bits of about a length.
fn cut(primitive: &Primitive, length: f64, out: &mut Vec<Bit>) {
    let pieces = |size: f64| (size / length).ceil().clamp(1.0, MOST_BITS);
    match primitive {
        Primitive::Point(p) => out.push(Bit { extent: Extent::of([*p], 0.0), share: 1.0 }),
        Primitive::Segment([a, b]) => {
            let n = pieces((b - a).length());
            let at = |k: f64| a.lerp(*b, k / n);
            let bit = |k: usize| Bit {
                extent: Extent::of([at(k as f64), at(k as f64 + 1.0)], 0.0),
                share: (b - a).length() / n,
            };
            out.extend((0..n as usize).map(bit));
        }
        Primitive::Arc(arc) => {
            let n = pieces(arc.length()).max(8.0);
            let bit = |k: usize| {
                let [a, b, c] = [0.0, 0.5, 1.0].map(|t| arc.at((k as f64 + t) / n));
                // Within the box of the chord and the middle, but for less than the chord's bulge.
                let bulge = (b - 0.5 * (a + c)).length();
                Bit { extent: Extent::of([a, b, c], bulge), share: arc.length() / n }
            };
            out.extend((0..n as usize).map(bit));
        }
        Primitive::Triangle([a, b, c]) => {
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let n = pieces(longest).min(16.0);
            let at = |i: usize, k: usize| a + (b - a) * (i as f64 / n) + (c - a) * (k as f64 / n);
            let share = 0.5 * (b - a).cross(c - a).length() / (n * n);
            let n = n as usize;
            for i in 0..n {
                for k in 0..n - i {
                    let corners = [at(i, k), at(i + 1, k), at(i, k + 1)];
                    out.push(Bit { extent: Extent::of(corners, 0.0), share });
                    if i + k + 1 < n {
                        let corners = [at(i + 1, k), at(i, k + 1), at(i + 1, k + 1)];
                        out.push(Bit { extent: Extent::of(corners, 0.0), share });
                    }
                }
            }
        }
    }
}

/// Bits, and the boxes around them with what is in each.
#[derive(Debug)]
struct Bits {
    bits: Vec<Bit>,
    boxes: Boxes,
    shares: Vec<f64>,
}

impl Bits {
    fn new(bits: Vec<Bit>) -> Bits {
        let boxes = Boxes::new(&bits.iter().map(|b| b.extent).collect::<Vec<_>>());
        let shares = boxes.sums(|i| bits[i].share);
        Bits { bits, boxes, shares }
    }

    /// The most that the sum of what weighs more than nothing is in a box, and of what weighs less.
    fn over(&self, falloff: Falloff, lo: DVec3, hi: DVec3) -> f64 {
        let mut sum = 0.0;
        // Differences of places are rounded by so much.
        let size = lo.abs().max(hi.abs()).max_element();
        let away = |e: &Extent| {
            let gap = (e.lo - hi).max(lo - e.hi).max(DVec3::ZERO).length() - e.girth;
            gap * (1.0 - 1e-12) - 1e-15 * size
        };
        self.seen(falloff, away, |share, away| sum += share * most(falloff, away).range);
        sum * (1.0 + 1e-9)
    }

    /// Bounds on the sum in a ball.
    fn around(&self, falloff: Falloff, x: DVec3, radius: f64) -> Bounds {
        let mut sum = [0.0; 3];
        let away = |e: &Extent| e.floor(x) - radius;
        self.seen(falloff, away, |share, away| {
            let b = most(falloff, away);
            let terms = [b.lipschitz, b.hessian, if b.third.is_finite() { b.third } else { 0.0 }];
            (0..3).for_each(|k| sum[k] += share * terms[k]);
        });
        let up = 1.0 + 1e-9;
        Bounds { range: f64::INFINITY, lipschitz: sum[0] * up, hessian: sum[1] * up, third: sum[2] * up }
    }

    /// Gives the shares of bits, and how far `away` they are at least. Boxes that are small as seen from there are taken whole.
    fn seen(&self, falloff: Falloff, away: impl Fn(&Extent) -> f64, mut take: impl FnMut(f64, f64)) {
        let rate = falloff.rate();
        self.boxes.walk(|group| {
            let (e, share, part) = match group {
                Group::Box(node, extent) => (extent, self.shares[node], false),
                Group::Part(i) => (&self.bits[i].extent, self.bits[i].share, true),
            };
            let away = away(e).max(0.0);
            let whole = part || (e.hi - e.lo).length() <= 0.5 * away.max(0.5 / rate);
            if whole {
                take(share, away);
            }
            !whole
        });
    }
}
