//! Scenes: plain data between the script that describes a picture and the renderer that makes it.
//!
//! Units: a planet's radius is 1 unless the script says otherwise. Right-handed axes, y up. Angles
//! in degrees, where scripts and people meet them. Colours are linear RGB with Rec. 709 primaries.

mod air;
mod camera;
mod cube;
mod detail;
mod ensemble;
mod film;
mod light;
mod material;
mod moon;
mod param;
mod sea;

pub use air::{Absorber, Air, Haze};
pub use camera::{Camera, Lens, Projection};
pub use cube::{FACES, Face};
pub use detail::Spacing;
pub use ensemble::{Ensemble, Member, period};
pub use film::{Film, Filter, Shutter, Tone};
pub use light::{Lamp, Light, Sun};
pub use material::{Finish, Material, Matt};
pub use moon::Moon;
pub use param::{Domain, Param, Unfit, Value};
pub use sea::Sea;

use crate::diag::Place;
use crate::expr::{Graph, NodeId};
use crate::num::Interval;
use glam::DVec3;
use std::sync::Arc;

/// Everything that a picture shows.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The expressions that the fields below are nodes of.
    pub graph: Arc<Graph>,
    /// The solid.
    pub surface: Surface,
    /// Where it is seen from.
    pub camera: Camera,
    /// Its main light.
    pub sun: Sun,
    /// Other lights.
    pub lights: Vec<Light>,
    /// Light from everywhere else, and what is behind the solid.
    pub sky: Sky,
    /// A moon.
    pub moon: Option<Moon>,
    /// Water that the solid stands in.
    pub sea: Option<Sea>,
    /// Picture size, sampling and exposure.
    pub film: Film,
    /// The box outside of which nothing is looked for; found from the field where it is `None`.
    pub bounds: Option<Aabb>,
    /// The parameters that the script asked for, in order, with their values.
    pub params: Vec<Param>,
}

impl Scene {
    /// Where the solid was written. A place in the library says nothing about what the user has written.
    pub fn place(&self) -> Option<Place> {
        self.graph.place(self.surface.field).filter(|place| !place.is_embedded()).cloned()
    }
}

/// A solid with its colour.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Implicit function: negative inside.
    pub field: NodeId,
    /// Linear red, green, blue in [0, 1] as fields; a neutral grey where `None`.
    pub color: Option<[NodeId; 3]>,
    /// How it reflects; matt where `None`.
    pub material: Option<Material>,
    /// Which of its components are there; all where `None`.
    pub keep: Option<Keep>,
}

/// Which components of a solid are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Keep {
    /// The largest.
    Most(Measure),
    /// Those that are at least this share of the one with the most minima, by minima.
    Share(f64),
    /// The one that holds a point.
    Holding(DVec3),
    /// The same, of a solid whose smallest features are of this size, with no more found out than rays ask for.
    Near {
        /// The point.
        core: DVec3,
        /// The size.
        feature: f64,
    },
}

/// What makes one component larger than another.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Measure {
    /// How many minima it has; its volume where not all of them are proven to be found.
    Minima,
    /// Its volume.
    Volume,
}

impl Surface {
    /// The field, and the three colours if it has any.
    pub fn roots(&self) -> Vec<NodeId> {
        [self.field].into_iter().chain(self.color.into_iter().flatten()).collect()
    }
}

/// An axis-parallel box.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: DVec3,
    /// Largest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// The cube from `-half` to `half` on all axes.
    pub fn cube(half: f64) -> Self {
        Aabb { min: DVec3::splat(-half), max: DVec3::splat(half) }
    }

    /// Whether it is a box: finite, and of some size along every axis.
    pub fn is_proper(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmplt(self.max).all()
    }

    /// The smallest box that holds both.
    pub fn hull(&self, other: &Aabb) -> Self {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether all of another box is in this one.
    pub fn holds(&self, other: &Aabb) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }

    /// The coordinates.
    pub fn intervals(&self) -> [Interval; 3] {
        std::array::from_fn(|axis| Interval::new(self.min[axis], self.max[axis]))
    }

    /// Parameters at which the line `origin + t direction` enters and leaves the box, if it meets it.
    pub fn clip(&self, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if origin[axis] < self.min[axis] || origin[axis] > self.max[axis] {
                    return None;
                }
                continue;
            }
            let a = (self.min[axis] - origin[axis]) / direction[axis];
            let b = (self.max[axis] - origin[axis]) / direction[axis];
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near <= far).then_some((near, far))
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }
}

/// Unit vector of an azimuth (0 is +z, 90 is +x) and an elevation above the xz plane, in degrees.
pub fn direction(azimuth: f64, elevation: f64) -> DVec3 {
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    DVec3::new(libm::cos(e) * libm::sin(a), libm::sin(e), libm::cos(e) * libm::cos(a))
}

/// Light from all around and the background: one radiance from the half of all directions that is above, one from the
/// other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Radiance of ambient light from above (as `up` has it).
    pub zenith: DVec3,
    /// Radiance of ambient light from below.
    pub nadir: DVec3,
    /// The direction that counts as above: `None` is away from the origin, as on a planet.
    pub up: Option<DVec3>,
    /// What is seen where nothing else is; transparent in pictures with alpha.
    pub background: DVec3,
    /// How bright the stars are; 1 is about what photographs of the night show, 0 none.
    pub stars: f64,
    /// Air around a planet, if it has any. Its light takes the place of `zenith` and `nadir`.
    pub air: Option<Air>,
}

impl Default for Sky {
    fn default() -> Self {
        Sky {
            zenith: DVec3::new(0.20, 0.24, 0.30),
            nadir: DVec3::new(0.07, 0.06, 0.05),
            up: Some(DVec3::Y),
            background: DVec3::new(0.012, 0.014, 0.02),
            stars: 0.0,
            air: None,
        }
    }
}
