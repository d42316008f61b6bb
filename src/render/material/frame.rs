//! Directions around a normal.

use crate::num::{cos_turns, sin_turns};
use glam::DVec3;

/// Three directions at right angles, the third of which is the normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    across: DVec3,
    along: DVec3,
    normal: DVec3,
}

impl Frame {
    /// A frame around a normal, which changes smoothly with it but for one place, without a branch
    /// (Duff et al. 2017, *Building an orthonormal basis, revisited*).
    #[inline]
    pub fn around(normal: DVec3) -> Frame {
        let sign = 1.0_f64.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Frame {
            across: DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            along: DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// A direction of the frame, whose z points along the normal, in the world.
    #[inline]
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        (local.x * self.across + local.y * self.along + local.z * self.normal).normalize()
    }

    /// A direction of the world in the frame.
    #[inline]
    pub fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::new(world.dot(self.across), world.dot(self.along), world.dot(self.normal))
    }
}

/// A direction with the density `cos / pi` over the hemisphere around z, for `u` uniform in [0, 1)^2.
#[inline]
pub fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let radius = u[0].sqrt();
    DVec3::new(radius * cos_turns(u[1]), radius * sin_turns(u[1]), (1.0 - u[0]).sqrt())
}

/// A direction with the density `1 / (2 pi)` over the hemisphere around z, for `u` uniform in [0, 1)^2.
#[inline]
pub fn uniform_hemisphere(u: [f64; 2]) -> DVec3 {
    // Never quite level, where it could not be told from below.
    around_z(1.0 - u[0], u[1])
}

/// The direction with a cosine to z, and an azimuth in turns.
#[inline]
pub(super) fn around_z(cos: f64, azimuth: f64) -> DVec3 {
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    DVec3::new(sin * cos_turns(azimuth), sin * sin_turns(azimuth), cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{mix, uniform};

    #[test]
    fn frames_are_orthonormal_and_turn_directions_there_and_back() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let random = (0..1000).map(|i| {
            let u = [mix(i), mix(i + 1000)].map(uniform);
            around_z(2.0 * u[0] - 1.0, u[1])
        });
        for normal in random.chain(axes).chain(axes.map(|axis| -axis)) {
            let frame = Frame::around(normal);
            let [a, b, c] = axes.map(|axis| frame.to_world(axis));
            assert!((c - normal).length() < 1e-15);
            assert!((a.cross(b) - c).length() < 1e-14, "{normal}");
            let direction = DVec3::new(0.6, -0.48, 0.64);
            assert!((frame.to_local(frame.to_world(direction)) - direction).length() < 1e-14);
        }
    }
}
