//! How much of the light from one direction a surface of facets mirrors in all, if it meets one of them:
//! `E(mu) = int f cos` of a [`Gloss`], and its mean `<E> = 2 int E(mu) mu dmu`.
//!
//! `E` has no closed form, and is a table over cosine and roughness, made for one [`Fresnel`]. It is off by no more
//! than 0.003.

use super::{Fresnel, Gloss, Reflectance};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Roughnesses of the table, whose roots are evenly spaced over [0, 1], as are those of the cosines: most change is on
/// smooth surfaces at grazing angles.
const ROWS: usize = 32;

/// Cosines of the table.
const COLUMNS: usize = 40;

/// Facets of the quadrature for an entry: slopes, and azimuths over half a turn.
const QUADRATURE: [u32; 2] = [24, 16];

/// `E` for all roughnesses.
#[derive(Clone, Debug)]
pub(super) struct Mirrored {
    /// For each roughness and cosine.
    albedo: Vec<[f64; COLUMNS]>,
    /// `<E>` for each roughness.
    mean: Vec<f64>,
}

impl Mirrored {
    /// The table of facets that mirror the same share in all channels. Takes some 60 ms on one core; `None` if that was
    /// cancelled.
    pub(super) fn new(fresnel: Fresnel, cancel: &AtomicBool) -> Option<Mirrored> {
        let row = |i: usize| {
            let gloss = Gloss::new(square(i, ROWS), fresnel);
            let entry = |j| mirrored(&gloss, square(j, COLUMNS));
            (!cancel.load(Ordering::Relaxed)).then(|| std::array::from_fn(entry))
        };
        let albedo = (0..ROWS).into_par_iter().map(row).collect::<Option<Vec<_>>>()?;
        let mean = albedo.iter().map(mean).collect();
        Some(Mirrored { albedo, mean })
    }

    /// `E` of a roughness from 0 to 1.
    pub(super) fn of(&self, roughness: f64) -> Row<'_> {
        let place = roughness.clamp(0.0, 1.0).sqrt() * (ROWS - 1) as f64;
        let row = (place as usize).min(ROWS - 2);
        let between = place - row as f64;
        let mean = self.mean[row] + between * (self.mean[row + 1] - self.mean[row]);
        Row { table: &self.albedo, row, between, mean }
    }
}

/// `E` of one roughness.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    table: &'a [[f64; COLUMNS]],
    /// The row of the table below the roughness, and how far it is to the next.
    row: usize,
    between: f64,
    mean: f64,
}

impl Row<'_> {
    /// `E` at a cosine from 0 to 1.
    pub(super) fn at(&self, cos: f64) -> f64 {
        let place = cos.sqrt() * (COLUMNS - 1) as f64;
        let column = (place as usize).min(COLUMNS - 2);
        let t = place - column as f64;
        let [low, high] = [0, 1].map(|i| {
            let row = &self.table[self.row + i];
            row[column] + t * (row[column + 1] - row[column])
        });
        low + self.between * (high - low)
    }

    /// `<E>`.
    pub(super) fn mean(&self) -> f64 {
        self.mean
    }
}

/// The root of a roughness or cosine, of so many.
fn root(i: usize, count: usize) -> f64 {
    i as f64 / (count - 1) as f64
}

/// A roughness or cosine, of so many.
fn square(i: usize, count: usize) -> f64 {
    root(i, count) * root(i, count)
}

/// `E`: the share of light that is mirrored at a cosine.
fn mirrored(gloss: &Gloss, cos: f64) -> f64 {
    // A level view mirrors as one that is nearly level, and has no facets to choose from.
    let cos = cos.max(1e-4);
    let eye = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let middle = |i: u32, count: u32| (f64::from(i) + 0.5) / f64::from(count);
    let [slopes, azimuths] = QUADRATURE;
    let mut sum = 0.0;
    for (i, j) in (0..slopes).flat_map(|i| (0..azimuths).map(move |j| (i, j))) {
        // Few facets are steep, but they are the ones that differ: `u = 1 - t^2`, so `du = 2 t dt`. The other half
        // turn is the mirror image.
        let t = middle(i, slopes);
        let bounce = gloss.sample([1.0 - t * t, 0.5 * middle(j, azimuths)], DVec3::Z, eye);
        sum += 2.0 * t * bounce.map_or(0.0, |bounce| bounce.weight.x);
    }
    sum / f64::from(slopes * azimuths)
}

/// `2 int E mu dmu` of a row, exactly for values that are interpolated in the root of the cosine.
fn mean(row: &[f64; COLUMNS]) -> f64 {
    let cell = |j: usize| {
        let [a, b] = [root(j, COLUMNS), root(j + 1, COLUMNS)];
        let [fourth_a, fourth_b] = [a * a * a * a, b * b * b * b];
        // int 4 s^3 E ds, with E linear between a and b.
        let slope = (row[j + 1] - row[j]) / (b - a);
        let level = row[j] - slope * a;
        level * (fourth_b - fourth_a) + slope * 0.8 * (b * fourth_b - a * fourth_a)
    };
    (0..COLUMNS - 1).map(cell).sum()
}

#[cfg(test)]
mod tests {
    use super::super::dielectric;
    use super::super::tests::{albedo, tilted};
    use super::*;

    #[test]
    fn the_table_holds_the_albedo_of_the_gloss() {
        let white = Fresnel::Metal { facing: DVec3::ONE };
        for fresnel in [Fresnel::Dielectric { ior: 1.333 }, white] {
            let table = Mirrored::new(fresnel, &AtomicBool::new(false)).unwrap();
            for roughness in [0.33, 0.57, 0.81] {
                for mu in [0.03, 0.21, 0.55, 0.93] {
                    let exact = albedo(&Gloss::new(roughness, fresnel), DVec3::Z, tilted(mu)).x;
                    let entry = table.of(roughness).at(mu);
                    assert!(
                        (entry - exact).abs() < 3e-3,
                        "{fresnel:?} {roughness} {mu}: {entry}, but {exact}"
                    );
                }
            }
        }
    }

    #[test]
    fn smooth_surfaces_mirror_as_one_facet_does() {
        let smooth = Mirrored::new(Fresnel::Dielectric { ior: 1.333 }, &AtomicBool::new(false)).unwrap();
        for mu in [0.05, 0.11, 0.4, 1.0] {
            assert!((smooth.of(0.0).at(mu) - dielectric(mu, 1.333)).abs() < 3e-3, "{mu}");
        }
    }
}
