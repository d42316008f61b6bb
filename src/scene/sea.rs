//! Seas: clear water that the solid stands in.

use super::{Material, Scene, Surface};
use crate::expr::NodeId;
use glam::DVec3;

/// Water, with a surface that reflects and a depth that takes light away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sea {
    /// Implicit function of the water: negative below its surface.
    pub field: NodeId,
    /// How its surface reflects: roughness, refractive index, and waves as a bump. The rest says nothing.
    pub material: Material,
    /// Share of light per unit of length that water takes away, per channel.
    pub absorption: DVec3,
    /// Colour of deep water: the share of light that it sends back.
    pub color: DVec3,
}

impl Sea {
    /// The water alone, as a solid.
    pub fn scene(&self, of: &Scene) -> Scene {
        let surface = Surface { field: self.field, color: None, material: Some(self.material), keep: None };
        Scene { surface, moon: None, sea: None, ..of.clone() }
    }
}
