//! How much of the light from one direction a surface of facets mirrors in all, if it meets one of them:
//! `E(mu) = int f cos` of a [`Gloss`], and what it leaves, `1 - E`.
//!
//! `E` has no closed form, and is a table over cosine and roughness, made for one [`Fresnel`]. It is off by no more
//! than 0.003 for cosines from 0.02 on, and by no more than 0.008 below. With `s` the fourth root of the cosine, in
//! which it is interpolated, integrals over the cosine are polynomials:
//!
//! ```text
//! 2 int (1 - E) mu dmu  =  8 int (1 - E) s^7 ds
//! ```
//!
//! A row takes two milliseconds, and is made when it is first asked for: most scenes ask for two.

use super::gloss::SMOOTHEST;
use super::{Fresnel, Gloss, Reflectance, choose};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;
use std::sync::OnceLock;

/// Roughnesses of the table, whose roots are evenly spaced.
const ROWS: usize = 32;

/// Cosines of the table, whose fourth roots are evenly spaced over [0, 1]: most change is at grazing angles.
const COLUMNS: usize = 56;

/// Facets of the quadrature for an entry: slopes, and azimuths over half a turn.
const QUADRATURE: [u32; 2] = [24, 16];

/// Steps in which a cosine is found; each halves what it may be off by.
const BISECTIONS: usize = 50;

/// `E` for all roughnesses.
#[derive(Clone, Debug)]
pub(super) struct Mirrored {
    fresnel: Fresnel,
    rows: [OnceLock<Row>; ROWS],
}

/// `E` for one roughness.
#[derive(Clone, Debug)]
struct Row {
    /// For each cosine.
    mirrored: [f64; COLUMNS],
    /// `2 int (1 - E) mu dmu` up to each cosine.
    left: [f64; COLUMNS],
}

impl Mirrored {
    /// The table of facets that mirror the same share in all channels.
    pub(super) fn new(fresnel: Fresnel) -> Mirrored {
        Mirrored { fresnel, rows: [const { OnceLock::new() }; ROWS] }
    }

    /// `E` of a roughness from 0 to 1.
    pub(super) fn of(&self, roughness: f64) -> Share<'_> {
        let first = least_root();
        let place = (roughness.clamp(0.0, 1.0).sqrt() - first).max(0.0) / (1.0 - first) * (ROWS - 1) as f64;
        let row = (place as usize).min(ROWS - 2);
        Share { rows: [self.row(row), self.row(row + 1)], between: place - row as f64 }
    }

    fn row(&self, i: usize) -> &Row {
        self.rows[i].get_or_init(|| {
            let first = least_root();
            let root = first + (1.0 - first) * i as f64 / (ROWS - 1) as f64;
            Row::new(&Gloss::new(root * root, self.fresnel))
        })
    }
}

/// The root of the least roughness that differs from zero: that of `alpha = roughness^2`.
fn least_root() -> f64 {
    SMOOTHEST.sqrt().sqrt()
}

impl Row {
    fn new(gloss: &Gloss) -> Row {
        let entry = |i| {
            let square = root(i) * root(i);
            mirrored(gloss, square * square).min(1.0)
        };
        let mut row = Row { mirrored: std::array::from_fn(entry), left: [0.0; COLUMNS] };
        for i in 1..COLUMNS {
            row.left[i] = row.left[i - 1] + row.left_within(i - 1, root(i));
        }
        row
    }

    /// `E` at the fourth root of a cosine.
    fn at(&self, root: f64) -> f64 {
        let place = root * (COLUMNS - 1) as f64;
        let column = (place as usize).min(COLUMNS - 2);
        let [low, high] = [self.mirrored[column], self.mirrored[column + 1]];
        low + (place - column as f64) * (high - low)
    }

    /// `8 int (1 - E) s^7 ds` from a column to a place before the next.
    fn left_within(&self, column: usize, to: f64) -> f64 {
        let [a, b] = [root(column), root(column + 1)];
        let slope = (self.mirrored[column + 1] - self.mirrored[column]) / (b - a);
        // 1 - E = level - slope s
        let level = 1.0 - self.mirrored[column] + slope * a;
        let eighth = |s: f64| {
            let fourth = s * s * s * s;
            fourth * fourth
        };
        level * (eighth(to) - eighth(a)) - slope * (8.0 / 9.0) * (to * eighth(to) - a * eighth(a))
    }

    /// `1 - <E>`.
    fn left(&self) -> f64 {
        self.left[COLUMNS - 1]
    }

    /// The cosine up to which there is the share `u` of what is left.
    fn quantile(&self, u: f64) -> f64 {
        let wanted = u * self.left();
        let column = (self.left.partition_point(|left| *left <= wanted).max(1) - 1).min(COLUMNS - 2);
        let [mut low, mut high] = [root(column), root(column + 1)];
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let is_below = self.left[column] + self.left_within(column, middle) < wanted;
            *(if is_below { &mut low } else { &mut high }) = middle;
        }
        low * low * low * low
    }
}

/// `E` of a roughness between two rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share<'a> {
    rows: [&'a Row; 2],
    between: f64,
}

impl Share<'_> {
    /// `E` at a cosine from 0 to 1.
    pub(super) fn at(&self, cos: f64) -> f64 {
        let root = cos.sqrt().sqrt();
        let [low, high] = self.rows.map(|row| row.at(root));
        low + self.between * (high - low)
    }

    /// What is left of light from all around: `1 - <E>`, where `<E> = 2 int E(mu) mu dmu`.
    pub(super) fn left(&self) -> f64 {
        let [low, high] = self.rows.map(Row::left);
        low + self.between * (high - low)
    }

    /// The density `(1 - E) cos / (pi (1 - <E>))` of directions at a cosine, in 1/sr.
    pub(super) fn density(&self, cos: f64) -> f64 {
        (1.0 - self.at(cos)) * cos / self.left().max(f64::MIN_POSITIVE) * FRAC_1_PI
    }

    /// Cosines of that density, for `u` uniform in [0, 1).
    pub(super) fn sample(&self, u: f64) -> f64 {
        let [low, high] = self.rows;
        let of_low = (1.0 - self.between) * low.left();
        let (is_low, [u, _]) = choose([u, 0.0], of_low / self.left().max(f64::MIN_POSITIVE));
        if is_low { low.quantile(u) } else { high.quantile(u) }
    }
}

/// The fourth root of the cosine of a column.
fn root(column: usize) -> f64 {
    column as f64 / (COLUMNS - 1) as f64
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

#[cfg(test)]
mod tests {
    use super::super::dielectric;
    use super::super::tests::{albedo, tilted};
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn the_table_holds_the_albedo_of_the_gloss() {
        let white = Fresnel::Metal { facing: DVec3::ONE };
        for fresnel in [Fresnel::Dielectric { ior: 1.333 }, white] {
            let table = Mirrored::new(fresnel);
            for roughness in [0.33, 0.57, 0.81] {
                for mu in [0.02, 0.03, 0.21, 0.55, 0.93] {
                    let exact = albedo(&Gloss::new(roughness, fresnel), DVec3::Z, tilted(mu)).x;
                    let entry = table.of(roughness).at(mu);
                    assert!(
                        (entry - exact).abs() < 2e-3,
                        "{fresnel:?} {roughness} {mu}: {entry}, but {exact}"
                    );
                }
            }
        }
    }

    #[test]
    fn smooth_surfaces_mirror_as_one_facet_does() {
        let smooth = Mirrored::new(Fresnel::Dielectric { ior: 1.333 });
        for mu in [0.02, 0.11, 0.4, 1.0] {
            assert!((smooth.of(0.0).at(mu) - dielectric(mu, 1.333)).abs() < 3e-3, "{mu}");
        }
    }

    #[test]
    fn what_is_left_is_found_where_it_is() {
        let white = Fresnel::Metal { facing: DVec3::ONE };
        let table = Mirrored::new(white);
        for roughness in [0.0, 0.05, 0.1, 0.5, 1.0] {
            let share = table.of(roughness);
            // Below a cosine there is the integral of the density, and as many samples.
            for limit in [0.01, 0.1, 0.5, 0.9] {
                let steps = 20_000;
                let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
                let known: f64 = (0..steps)
                    .map(|i| middle(i) * middle(i) * limit)
                    .zip((0..steps).map(|i| 2.0 * middle(i) * limit / f64::from(steps)))
                    .map(|(cos, width)| TAU * share.density(cos) * width)
                    .sum();
                let found = (0..steps).filter(|i| share.sample(middle(*i)) < limit).count();
                let found = found as f64 / f64::from(steps);
                assert!((found - known).abs() < 1e-3, "{roughness} {limit}: {found}, but {known}");
            }
        }
    }
}
