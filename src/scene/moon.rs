//! Moons: solids of their own, far behind everything else.

use super::{Aabb, Camera, Light, Scene, Sky, Surface};
use glam::DVec3;

/// A solid around the origin of its own space, seen far away in the sky.
#[derive(Clone, Debug)]
pub struct Moon {
    /// The solid, of a radius of about 1.
    pub surface: Surface,
    /// The box that it is in.
    pub bounds: Aabb,
    /// Where its middle is.
    pub position: DVec3,
    /// Length in the scene of a unit of its own space.
    pub radius: f64,
}

impl Moon {
    /// The moon alone, in its own space, as a scene's camera sees it by the light of the scene's suns.
    pub fn scene(&self, of: &Scene) -> Scene {
        let own = |p: DVec3| (p - self.position) / self.radius;
        let camera = Camera { eye: own(of.camera.eye), target: own(of.camera.target), ..of.camera };
        let is_sun = |light: &&Light| matches!(light, Light::Sun(_));
        Scene {
            graph: of.graph.clone(),
            surface: self.surface.clone(),
            camera,
            sun: of.sun,
            lights: of.lights.iter().filter(is_sun).copied().collect(),
            sky: Sky {
                zenith: DVec3::ZERO,
                nadir: DVec3::ZERO,
                up: None,
                background: DVec3::ZERO,
                stars: 0.0,
                air: None,
            },
            moon: None,
            sea: None,
            film: of.film,
            bounds: Some(self.bounds),
            params: Vec::new(),
        }
    }
}
