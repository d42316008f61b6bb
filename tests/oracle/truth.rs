//! What is known of a ray without any caster: dense samples of the field.
//!
//! Wherever a sample is not positive the ray is inside the solid, so a first hit behind it is late for
//! sure. The reverse is not true: features thinner than the samples are apart can be missed. So a hit
//! in front of the first sample inside is no mistake by itself; it must be a place where the field is
//! so small that the surface may be within the tolerance ([`grazes`]).

use glam::DVec3;
use orogen::cast::Ray;
use orogen::field::Field;
use orogen::num::Many;
use orogen::tape::Evaluator;

/// What samples say of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// The first place found where the field is not positive, bisected to the last bit.
    pub first: Option<f64>,
    /// The place with the smallest value.
    pub closest: f64,
}

/// Where samples lie along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Spacing {
    pub samples: usize,
    /// Up to this share of the ray they are about evenly apart, and from there on farther and farther: for
    /// fields whose detail is as fine as an eye at the beginning can tell. Evenly all along if zero.
    pub beginning: f64,
}

impl Spacing {
    fn at(&self, ray: &Ray, i: usize) -> f64 {
        let share = i as f64 / (self.samples - 1) as f64;
        let share = if self.beginning > 0.0 {
            self.beginning * (libm::pow(1.0 + 1.0 / self.beginning, share) - 1.0)
        } else {
            share
        };
        ray.near + (ray.far - ray.near) * share
    }
}

/// Samples a field along rays.
pub struct Oracle {
    field: Field,
    many: Evaluator<Many<f64, 64>>,
    spacing: Spacing,
}

impl Oracle {
    pub fn new(field: &Field, spacing: Spacing) -> Oracle {
        Oracle { field: field.clone(), many: Evaluator::new(field.tape().clone()), spacing }
    }

    /// The field at a distance along a ray.
    pub fn value(&mut self, ray: &Ray, t: f64) -> f64 {
        self.field.value(ray.at(t))
    }

    /// Samples along a ray: where they are, and what the field is there.
    pub fn samples(&mut self, ray: &Ray) -> Vec<(f64, f64)> {
        let spacing = self.spacing;
        let places = (0..spacing.samples).map(|i| spacing.at(ray, i));
        places.map(|t| (t, self.value(ray, t))).collect()
    }

    /// The normal at a point.
    pub fn normal(&mut self, p: DVec3) -> Option<DVec3> {
        self.field.gradient(p).1.try_normalize()
    }

    /// What samples say. Minima that might reach zero between samples are looked at closely.
    pub fn ask(&mut self, ray: &Ray) -> Truth {
        let Spacing { samples, .. } = self.spacing;
        let spacing = self.spacing;
        let t = |i: usize| spacing.at(ray, i.min(samples - 1));
        let mut values: Vec<f64> = Vec::with_capacity(samples + 64);
        let inside = loop {
            let from = values.len();
            let points: [DVec3; 64] = std::array::from_fn(|lane| ray.at(t(from + lane)));
            let p = std::array::from_fn(|axis| Many(points.map(|p| p[axis])));
            values.extend(self.many.eval(&p).0);
            if let Some(i) = values[from..].iter().position(|v| *v <= 0.0) {
                break Some(from + i);
            }
            if values.len() >= samples {
                break None;
            }
        };
        if inside == Some(0) {
            return Truth { first: Some(ray.near), closest: ray.near };
        }
        let end = inside.unwrap_or(samples - 1).min(samples - 1);
        let mut closest = (f64::INFINITY, ray.near);
        for i in 0..end {
            let (before, here, after) = (values[i.max(1) - 1], values[i], values[i + 1]);
            if here < closest.0 {
                closest = (here, t(i));
            }
            // No steeper than 40 units to one, or it is too far down to matter.
            let step = t(i + 1) - t(i);
            if here <= before && here <= after && here < 40.0 * step {
                let (value, place) = self.dip(ray, t(i.max(1) - 1), t(i + 1));
                if value <= 0.0 {
                    return Truth { first: Some(self.bisect(ray, t(i.max(1) - 1), place)), closest: place };
                }
                if value < closest.0 {
                    closest = (value, place);
                }
            }
        }
        let first = inside.map(|i| self.bisect(ray, t(i - 1), t(i)));
        Truth { first, closest: first.unwrap_or(closest.1) }
    }

    fn bisect(&mut self, ray: &Ray, mut out: f64, mut inside: f64) -> f64 {
        for _ in 0..60 {
            let mid = 0.5 * (out + inside);
            if self.value(ray, mid) > 0.0 { out = mid } else { inside = mid }
        }
        inside
    }

    /// Golden section search for the smallest value between `a` and `b`, or any that is not positive:
    /// the value and where it is.
    fn dip(&mut self, ray: &Ray, mut a: f64, mut b: f64) -> (f64, f64) {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
        let (mut fc, mut fd) = (self.value(ray, c), self.value(ray, d));
        for _ in 0..32 {
            if fc <= 0.0 || fd <= 0.0 {
                break;
            }
            if fc < fd {
                (b, d, fd) = (d, c, fc);
                c = b - golden * (b - a);
                fc = self.value(ray, c);
            } else {
                (a, c, fc) = (c, d, fd);
                d = a + golden * (b - a);
                fd = self.value(ray, d);
            }
        }
        if fc < fd { (fc, c) } else { (fd, d) }
    }

    /// Whether the field is so small at `t` that, going by how fast it changes around there, the surface
    /// may be within the tolerance.
    pub fn grazes(&mut self, ray: &Ray, t: f64) -> bool {
        let (p, tolerance) = (ray.at(t), ray.tolerance.at(t));
        let here = self.field.value(p);
        let steepest = around(p, 2.0 * tolerance)
            .chain(around(p, 0.5 * tolerance))
            .map(|q| (self.field.value(q) - here).abs() / q.distance(p))
            .fold(0.0, f64::max);
        here <= tolerance * steepest
    }

    /// Whether a sample of a ray, or a place within the tolerance of one, has no finite value.
    pub fn meets_the_undefined(&mut self, ray: &Ray) -> bool {
        (0..self.spacing.samples).any(|i| {
            let t = self.spacing.at(ray, i);
            let p = ray.at(t);
            let mut finite = |q: DVec3| self.field.value(q).is_finite();
            !finite(p) || around(p, 2.0 * ray.tolerance.at(t)).any(|q| !finite(q))
        })
    }
}

/// Twenty-six points at a distance from a point.
fn around(p: DVec3, distance: f64) -> impl Iterator<Item = DVec3> {
    let sign = |i: i32| f64::from(i % 3 - 1);
    (0..27)
        .map(move |i| DVec3::new(sign(i), sign(i / 3), sign(i / 9)))
        .filter_map(DVec3::try_normalize)
        .map(move |d| p + distance * d)
}
