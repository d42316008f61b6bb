//! A clear film on something matt: wet rock, varnish, glazed snow.
//!
//! The film mirrors the share `E(v)` of what arrives from `v`, as [`Gloss`] of its roughness does. The
//! rest gets in, meets the matt ground of the albedo `rho`, and most of it the film from below, which
//! throws back the share `K`: that repeats, and is the reason why wet stones are dark. The sum of the
//! series is what leaves, spread by the film as what came in was:
//!
//! ```text
//! f = f_gloss + (1 - E(v)) (1 - E(l)) / (1 - <E>)  rho_wet / pi
//! rho_wet = rho (1 - K) / (1 - rho K)          <E> = 2 int E(mu) mu dmu
//! ```
//!
//! It is the same with both directions exchanged. For a white ground `rho_wet` is 1, and the integral of
//! all of it is `E + (1 - E) = 1`: no light is lost or won. (The form with tabulated albedos is that of
//! Kelemen and Szirmay-Kalos 2001, *A microfacet based coupled specular-matte BRDF model*; the series is
//! Saunderson's, 1942.) For a smooth film all of it follows from Fresnel's equations, and `1 - K` is
//! `(1 - <F>) / n^2`: light within is spread over a cone that is wider than the one that gets out.
//!
//! `E` has no closed form, and is a table over cosine and roughness, made for one index of refraction.

use super::Frame;
use super::{Bounce, Fresnel, Gloss, Reflectance, bounce, choose, cosine_hemisphere, cosines, dielectric};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_1_PI;
use std::sync::atomic::{AtomicBool, Ordering};

/// Roughnesses of the table, evenly spaced over [0, 1].
const ROWS: usize = 24;

/// Cosines of the table, whose roots are evenly spaced over [0, 1]: most change is at grazing angles.
const COLUMNS: usize = 40;

/// Directions along each axis of the quadrature for an entry.
const QUADRATURE: u32 = 20;

/// Steps of the mean of Fresnel's equation.
const STEPS: u32 = 1000;

/// Clear films of one index of refraction: what they mirror, for all roughnesses.
#[derive(Clone, Debug)]
pub struct Film {
    fresnel: Fresnel,
    /// `E` for each roughness and cosine.
    albedo: Vec<[f64; COLUMNS]>,
    /// `<E>` for each roughness.
    mean: Vec<f64>,
    /// `K`.
    inside: f64,
}

impl Film {
    /// Films of an index of refraction, at least 1; 1.333 for water. Making the table takes some 50 ms on one core; `None`
    /// if that was cancelled.
    pub fn new(ior: f64, cancel: &AtomicBool) -> Option<Film> {
        let ior = ior.max(1.0);
        let fresnel = Fresnel::Dielectric { ior };
        let row = |i: usize| {
            let gloss = Gloss::new(i as f64 / (ROWS - 1) as f64, fresnel);
            let entry = |j| mirrored(&gloss, root(j) * root(j));
            (!cancel.load(Ordering::Relaxed)).then(|| std::array::from_fn(entry))
        };
        let albedo = (0..ROWS).into_par_iter().map(row).collect::<Option<Vec<_>>>()?;
        let mean = albedo.iter().map(mean).collect();
        let outside = (0..STEPS)
            .map(|i| (f64::from(i) + 0.5) / f64::from(STEPS))
            .map(|cos| 2.0 * cos * dielectric(cos, ior) / f64::from(STEPS))
            .sum::<f64>();
        Some(Film { fresnel, albedo, mean, inside: 1.0 - (1.0 - outside) / (ior * ior) })
    }

    /// A film of a roughness from 0 to 1 on a matt ground, of which the albedo is that in the dry.
    pub fn on(&self, albedo: DVec3, roughness: f64) -> Coat<'_> {
        let place = roughness.clamp(0.0, 1.0) * (ROWS - 1) as f64;
        let row = (place as usize).min(ROWS - 2);
        let wet = albedo * (1.0 - self.inside) / (1.0 - albedo * self.inside);
        let between = place - row as f64;
        let mean = self.mean[row] + between * (self.mean[row + 1] - self.mean[row]);
        Coat { film: self, gloss: Gloss::new(roughness, self.fresnel), wet, row, between, mean }
    }
}

/// The root of the cosine of a column.
fn root(column: usize) -> f64 {
    column as f64 / (COLUMNS - 1) as f64
}

/// `E`: the share of light that is mirrored at a cosine.
fn mirrored(gloss: &Gloss, cos: f64) -> f64 {
    // A level view mirrors as one that is nearly level, and has no facets to choose from.
    let cos = cos.max(1e-4);
    let eye = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(QUADRATURE);
    // The other half turn is the mirror image.
    let places = (0..QUADRATURE).flat_map(|i| (0..QUADRATURE).map(move |j| [middle(i), 0.5 * middle(j)]));
    let sum: f64 = places.filter_map(|u| gloss.sample(u, DVec3::Z, eye)).map(|bounce| bounce.weight.x).sum();
    sum / f64::from(QUADRATURE * QUADRATURE)
}

/// `2 int E mu dmu` of a row, exactly for values that are interpolated in the root of the cosine.
fn mean(row: &[f64; COLUMNS]) -> f64 {
    let cell = |j: usize| {
        let [a, b] = [root(j), root(j + 1)];
        let [fourth_a, fourth_b] = [a * a * a * a, b * b * b * b];
        // int 4 s^3 E ds, with E linear between a and b.
        let slope = (row[j + 1] - row[j]) / (b - a);
        let level = row[j] - slope * a;
        level * (fourth_b - fourth_a) + slope * 0.8 * (b * fourth_b - a * fourth_a)
    };
    (0..COLUMNS - 1).map(cell).sum()
}

/// A clear film on a matt ground.
#[derive(Clone, Copy, Debug)]
pub struct Coat<'a> {
    film: &'a Film,
    gloss: Gloss,
    /// The albedo that the ground has for light that gets in and out again.
    wet: DVec3,
    /// The row of the table below the roughness, and how far it is to the next.
    row: usize,
    between: f64,
    mean: f64,
}

impl Coat<'_> {
    /// `E` at a cosine.
    fn mirrored(&self, cos: f64) -> f64 {
        let place = cos.sqrt() * (COLUMNS - 1) as f64;
        let column = (place as usize).min(COLUMNS - 2);
        let t = place - column as f64;
        let [low, high] = [0, 1].map(|i| {
            let row = &self.film.albedo[self.row + i];
            row[column] + t * (row[column + 1] - row[column])
        });
        low + self.between * (high - low)
    }

    /// Probability of a sample of the gloss: its share of what the eye sees of white light.
    fn gloss_share(&self, cos: f64) -> f64 {
        let gloss = self.mirrored(cos);
        gloss / (gloss + (1.0 - gloss) * self.wet.max_element()).max(f64::MIN_POSITIVE)
    }
}

impl Reflectance for Coat<'_> {
    fn value(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        let Some(both) = cosines(normal, to_eye, to_light) else { return DVec3::ZERO };
        let [eye, light] = both.map(|cos| 1.0 - self.mirrored(cos));
        let matt = self.wet * (eye * light / (1.0 - self.mean).max(f64::EPSILON) * FRAC_1_PI);
        self.gloss.value(normal, to_eye, to_light) + matt
    }

    fn sample(&self, u: [f64; 2], normal: DVec3, to_eye: DVec3) -> Option<Bounce> {
        let (gloss, u) = choose(u, self.gloss_share(normal.dot(to_eye).clamp(0.0, 1.0)));
        let direction = match gloss {
            true => self.gloss.sample(u, normal, to_eye)?.direction,
            false => Frame::around(normal).to_world(cosine_hemisphere(u)),
        };
        bounce(self, normal, to_eye, direction)
    }

    fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
        let Some([eye, light]) = cosines(normal, to_eye, to_light) else { return 0.0 };
        let share = self.gloss_share(eye);
        share * self.gloss.pdf(normal, to_eye, to_light) + (1.0 - share) * light * FRAC_1_PI
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{albedo, film, tilted};
    use super::*;

    #[test]
    fn a_film_on_white_loses_no_light() {
        let film = film(1.5);
        for roughness in [0.35, 0.5, 0.73, 1.0] {
            let coat = film.on(DVec3::ONE, roughness);
            for mu in [0.05, 0.1, 0.37, 0.7, 1.0] {
                let all = albedo(&coat, DVec3::Z, tilted(mu)).x;
                assert!((all - 1.0).abs() < 3e-3, "{roughness} {mu}: {all}");
            }
        }
    }

    #[test]
    fn the_table_holds_the_albedo_of_the_gloss() {
        let film = film(1.333);
        for roughness in [0.33, 0.57, 0.81] {
            let coat = film.on(DVec3::ZERO, roughness);
            for mu in [0.03, 0.21, 0.55, 0.93] {
                let exact = albedo(&coat.gloss, DVec3::Z, tilted(mu)).x;
                assert!((coat.mirrored(mu) - exact).abs() < 2e-3, "{roughness} {mu}: {exact}");
            }
        }
        // A smooth film mirrors as one facet does.
        let smooth = film.on(DVec3::ZERO, 0.0);
        for mu in [0.02, 0.11, 0.4, 1.0] {
            assert!((smooth.mirrored(mu) - dielectric(mu, 1.333)).abs() < 3e-3, "{mu}");
        }
    }

    #[test]
    fn light_inside_is_thrown_back_as_fresnel_says() {
        for ior in [1.0, 1.333, 1.5] {
            let steps = 100_000;
            let inside: f64 = (0..steps)
                .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
                .map(|cos| 2.0 * cos * dielectric(cos, 1.0 / ior) / f64::from(steps))
                .sum();
            assert!((film(ior).inside - inside).abs() < 1e-4, "{ior}: {inside}");
        }
    }

    #[test]
    fn wet_ground_is_darker() {
        let dry = DVec3::new(0.1, 0.3, 0.6);
        let wet = albedo(&film(1.333).on(dry, 0.4), DVec3::Z, DVec3::Z);
        assert!(wet.x > 0.05 && wet.x < 0.09 && wet.y < 0.22 && wet.z < 0.5, "{wet}");
        // A film of nothing leaves the ground as it is.
        let none = film(1.0);
        let value = none.on(dry, 0.4).value(DVec3::Z, tilted(0.3), tilted(0.8));
        assert!((value - dry * FRAC_1_PI).length() < 1e-12, "{value}");
    }
}
