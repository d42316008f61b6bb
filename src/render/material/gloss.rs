//! Gloss: a surface of tiny facets, each of which mirrors.
//!
//! With facets whose normals `h` are distributed as `D` (Trowbridge and Reitz 1975, as *GGX* Walter et
//! al. 2007), that hide one another (Smith 1967, with heights correlated: Heitz 2014, *Understanding the
//! masking-shadowing function*), and mirror the share `F`:
//!
//! ```text
//! f = D(h) V(v, l) F(v . h)                       h = (v + l) / |v + l|
//! D = alpha^2 / (pi (alpha^2 cos_h^2 + sin_h^2)^2)
//! V = G2 / (4 cos_v cos_l) = 1/2 / (cos_v s(l) + cos_l s(v))      s(d) = sqrt(alpha^2 + (1 - alpha^2) cos_d^2)
//! ```
//!
//! Samples choose among the facets that the eye sees, in proportion to how much it sees of them. On a
//! hemisphere (`alpha = 1`) the directions that are mirrored by them fill a spherical cap evenly; any
//! other distribution is one that is stretched (Dupuy and Benyoub 2023, *Sampling visible GGX normals
//! with spherical caps*). The density is `D / (2 (cos_v + s(v)))`, and what is left as a weight is at
//! most `F`.
//!
//! Light that meets several facets is left out: white facets lose two thirds of it at the highest
//! roughness, seen along the normal. [`Balanced`](super::Balanced) adds it.

use super::frame::around_z;
use super::{Bounce, Frame, Fresnel, Reflectance, cosines};
use glam::DVec3;
use std::f64::consts::PI;

/// Smoother than this, a highlight is smaller than the sun.
pub(super) const SMOOTHEST: f64 = 1e-3;

/// A surface of facets that mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    alpha: f64,
    fresnel: Fresnel,
}

impl Gloss {
    /// The gloss of a roughness from 0 to 1, which is the root of `alpha`, so that equal steps look
    /// alike. Other numbers count as the nearest.
    pub fn new(roughness: f64, fresnel: Fresnel) -> Gloss {
        Gloss { alpha: (roughness * roughness).clamp(SMOOTHEST, 1.0), fresnel }
    }

    /// `s`: from `alpha` at a cosine of 0 to 1 at 1.
    fn stretched(&self, cos: f64) -> f64 {
        let square = self.alpha * self.alpha;
        (square + (1.0 - square) * cos * cos).sqrt()
    }

    /// `D` of facets with a normal `h`.
    fn facets(&self, normal: DVec3, h: DVec3) -> f64 {
        let (cos, sin2) = (normal.dot(h), normal.cross(h).length_squared());
        let base = self.alpha * self.alpha * cos * cos + sin2;
        self.alpha * self.alpha / (PI * base * base)
    }

    /// The normal of a facet: one for each `u` in the unit square, as often as the eye sees such facets.
    pub fn facet(&self, u: [f64; 2], normal: DVec3, to_eye: DVec3) -> DVec3 {
        let frame = Frame::around(normal);
        frame.to_world(self.visible(u, frame.to_local(to_eye)))
    }

    /// The normal of a facet that is seen from a direction, both in the frame of the surface.
    fn visible(&self, u: [f64; 2], eye: DVec3) -> DVec3 {
        let stretch = DVec3::new(self.alpha, self.alpha, 1.0);
        let eye = (eye * stretch).normalize();
        let mirrored = around_z((1.0 - u[0]) * (1.0 + eye.z) - eye.z, u[1]);
        ((mirrored + eye) * stretch).normalize_or(DVec3::Z)
    }
}

impl Reflectance for Gloss {
    fn value(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        let Some([eye, light]) = cosines(normal, to_eye, to_light) else { return DVec3::ZERO };
        let h = (to_eye + to_light).normalize();
        let visible = 0.5 / (eye * self.stretched(light) + light * self.stretched(eye));
        self.fresnel.at(to_eye.dot(h)) * (self.facets(normal, h) * visible)
    }

    fn sample(&self, u: [f64; 2], normal: DVec3, to_eye: DVec3) -> Option<Bounce> {
        let frame = Frame::around(normal);
        let local = frame.to_local(to_eye);
        let h = self.visible(u, local);
        let cos_h = local.dot(h);
        let direction = frame.to_world(2.0 * cos_h * h - local);
        let [eye, light] = cosines(normal, to_eye, direction)?;
        // value * cos / pdf, without the density of facets, which is the same in both.
        let [from_eye, from_light] = [self.stretched(eye), self.stretched(light)];
        let unshadowed = light * (eye + from_eye) / (eye * from_light + light * from_eye);
        Some(Bounce { direction, weight: self.fresnel.at(cos_h) * unshadowed, is_spread: false })
    }

    fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
        let Some([eye, _]) = cosines(normal, to_eye, to_light) else { return 0.0 };
        let h = (to_eye + to_light).normalize();
        self.facets(normal, h) / (2.0 * (eye + self.stretched(eye)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{albedo, hemisphere, tilted};
    use super::*;

    fn white(roughness: f64) -> Gloss {
        Gloss::new(roughness, Fresnel::Metal { facing: DVec3::ONE })
    }

    #[test]
    fn facets_cover_the_surface() {
        for roughness in [0.4, 0.7, 1.0] {
            let covered: f64 =
                hemisphere(600).map(|(h, area)| white(roughness).facets(DVec3::Z, h) * h.z * area).sum();
            assert!((covered - 1.0).abs() < 1e-3, "{roughness}: {covered}");
        }
    }

    #[test]
    fn the_smoother_the_less_is_lost() {
        for mu in [0.5, 1.0] {
            let kept = [0.3, 0.6, 1.0].map(|roughness| albedo(&white(roughness), DVec3::Z, tilted(mu)).x);
            assert!(kept[0] > 0.97 && kept[0] > kept[1] && kept[1] > kept[2], "{mu}: {kept:?}");
        }
        let roughest = albedo(&white(1.0), DVec3::Z, DVec3::Z).x;
        assert!((roughest - 0.307).abs() < 1e-3, "{roughest}");
    }

    #[test]
    fn a_smooth_surface_is_a_mirror() {
        let ice = Gloss::new(0.0, Fresnel::Dielectric { ior: 1.31 });
        for mu in [0.1, 0.5, 0.9] {
            let eye = tilted(mu);
            let bounce = ice.sample([0.3, 0.6], DVec3::Z, eye).unwrap();
            let mirrored = DVec3::new(-eye.x, -eye.y, eye.z);
            assert!((bounce.direction - mirrored).length() < 1e-2);
            assert!((bounce.weight.x / super::super::dielectric(mu, 1.31) - 1.0).abs() < 0.05);
        }
    }

    #[test]
    fn roughness_has_limits() {
        let metal = Fresnel::Metal { facing: DVec3::ONE };
        assert_eq!(Gloss::new(-3.0, metal), Gloss::new(3.0, metal));
        assert_eq!(Gloss::new(0.0, metal).alpha, SMOOTHEST);
    }
}
