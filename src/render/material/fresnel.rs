//! Fresnel's equations: how much light a smooth surface mirrors, and where the rest goes.

use glam::DVec3;

/// Share of light that a facet mirrors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fresnel {
    /// Of a clear material, for light without polarisation.
    Dielectric {
        /// Index of refraction, relative to the side of the light: 1.31 for ice, 1.333 for water, 1.5 for
        /// many minerals.
        ior: f64,
    },
    /// Of a metal, by its colour.
    Metal {
        /// What is mirrored of light along the normal, from 0 to 1 by channel.
        facing: DVec3,
    },
}

impl Fresnel {
    /// The share for each channel at the cosine between light and normal.
    pub fn at(self, cos: f64) -> DVec3 {
        match self {
            Fresnel::Dielectric { ior } => DVec3::splat(dielectric(cos, ior)),
            Fresnel::Metal { facing } => schlick(cos, facing),
        }
    }
}

/// Share of unpolarised light that is mirrored where the index of refraction rises by the factor `ior`,
/// or falls for an `ior` below 1. `cos` is that of the angle between light and normal, from 0 to 1.
///
/// Snell's law gives `g = n cos'` behind the surface; what is mirrored of light that swings across and
/// along the plane of incidence are squares of `(c - g) / (c + g)` and `(n^2 c - g) / (n^2 c + g)`. Where
/// there is no `g`, all light is.
pub fn dielectric(cos: f64, ior: f64) -> f64 {
    let cos = cos.clamp(0.0, 1.0);
    let square = ior * ior - (1.0 - cos) * (1.0 + cos);
    if square <= 0.0 {
        return 1.0;
    }
    let g = square.sqrt();
    let across = (cos - g) / (cos + g);
    let along = (ior * ior * cos - g) / (ior * ior * cos + g);
    0.5 * (across * across + along * along)
}

/// Mean share that is mirrored of light from all around, by the rule of midpoints.
pub fn dielectric_mean(ior: f64) -> f64 {
    const STEPS: u32 = 1000;
    (0..STEPS)
        .map(|i| (f64::from(i) + 0.5) / f64::from(STEPS))
        .map(|cos| 2.0 * cos * dielectric(cos, ior) / f64::from(STEPS))
        .sum()
}

/// Schlick's approximation (1994) from what is mirrored along the normal, for `cos` from 0 to 1.
pub fn schlick(cos: f64, facing: DVec3) -> DVec3 {
    let rest = 1.0 - cos.clamp(0.0, 1.0);
    let square = rest * rest;
    facing + (DVec3::ONE - facing) * (square * square * rest)
}

/// Where a line of sight goes on behind a surface where the index of refraction rises by the factor
/// `ior`: Snell's law. `None` if all light is mirrored.
pub fn refract(normal: DVec3, to_eye: DVec3, ior: f64) -> Option<DVec3> {
    let cos = normal.dot(to_eye);
    let square = 1.0 - (1.0 - cos * cos) / (ior * ior);
    (square > 0.0).then(|| ((cos / ior - square.sqrt()) * normal - to_eye / ior).normalize())
}

#[cfg(test)]
mod tests {
    use super::super::tests::tilted;
    use super::*;

    #[test]
    fn all_is_mirrored_at_grazing_angles_and_a_known_share_along_the_normal() {
        for ior in [1.31, 1.333, 1.5, 2.4, 0.75] {
            let facing = (ior - 1.0) * (ior - 1.0) / ((ior + 1.0) * (ior + 1.0));
            assert!((dielectric(1.0, ior) - facing).abs() < 1e-15);
            assert!((dielectric(0.0, ior) - 1.0).abs() < 1e-15);
        }
        let gold = DVec3::new(1.0, 0.78, 0.34);
        let metal = Fresnel::Metal { facing: gold };
        assert_eq!([metal.at(1.0), metal.at(0.0)], [gold, DVec3::ONE]);
        assert!(dielectric(0.3, 1.0) < 1e-30);
    }

    #[test]
    fn at_brewsters_angle_only_one_polarisation_is_mirrored() {
        let ior = 1.5_f64;
        let cos = 1.0 / (1.0 + ior * ior).sqrt();
        let across = (1.0 - ior * ior) / (1.0 + ior * ior);
        assert!((dielectric(cos, ior) - 0.5 * across * across).abs() < 1e-15);
    }

    #[test]
    fn both_sides_mirror_alike() {
        for i in 1..100 {
            let cos = f64::from(i) / 100.0;
            let behind = (1.0 - (1.0 - cos * cos) / (1.4 * 1.4)).sqrt();
            assert!((dielectric(cos, 1.4) - dielectric(behind, 1.0 / 1.4)).abs() < 1e-12);
        }
    }

    #[test]
    fn refraction_is_snells() {
        for mu in [0.05, 0.3, 0.8, 1.0] {
            let (ior, eye) = (1.333, tilted(mu));
            let down = refract(DVec3::Z, eye, ior).unwrap();
            let sines = [eye, down].map(|d| libm::hypot(d.x, d.y));
            assert!((sines[0] - ior * sines[1]).abs() < 1e-14 && (down.length() - 1.0).abs() < 1e-14);
            assert!(down.z < 0.0 && down.x * eye.x + down.y * eye.y <= 0.0);
            // And back on the same way.
            let up = refract(-DVec3::Z, down, 1.0 / ior).unwrap();
            assert!((up - eye).length() < 1e-12);
        }
        // Beyond the critical angle, of which the sine is 1/ior.
        let critical = (1.0_f64 - 1.0 / (1.5 * 1.5)).sqrt();
        assert!(refract(DVec3::Z, tilted(critical - 1e-6), 1.0 / 1.5).is_none());
        assert!(refract(DVec3::Z, tilted(critical + 1e-6), 1.0 / 1.5).is_some());
        assert_eq!(dielectric(critical - 1e-6, 1.0 / 1.5), 1.0);
    }
}
