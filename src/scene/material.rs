//! Materials: how a solid reflects light, beside its colour.
//!
//! A solid is matt below, and may have a clear coat above, as a wet stone does, or be metal in places. What varies from
//! place to place is a field, so altitude, slope or any noise can decide it.

use crate::expr::NodeId;

/// How a solid reflects light, and shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// The law of the matt part.
    pub matt: Matt,
    /// What varies from place to place.
    pub finish: [NodeId; Finish::COUNT],
    /// Refractive index of the coat: 1.5 for varnish, 1.33 for water, 1.31 for ice.
    pub ior: f64,
    /// Light that it gives off by itself, as radiance per channel.
    pub emission: Option<[NodeId; 3]>,
    /// A height that is added to the solid where its normals are asked for, and nowhere else.
    pub bump: Option<NodeId>,
}

/// The law by which what is matt reflects.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Matt {
    /// Equally bright from everywhere (Lambert).
    #[default]
    Lambert,
    /// Facets that are matt themselves (Oren and Nayar): flatter, as plaster and sand are.
    Rough,
    /// Grains that light enters between (Lommel and Seeliger; Blinn 1982): a full moon is a flat disc.
    Dust,
}

impl Matt {
    /// All laws, with their names in scripts.
    pub const ALL: [(Matt, &'static str); 3] =
        [(Matt::Lambert, "lambert"), (Matt::Rough, "rough"), (Matt::Dust, "dust")];
}

/// A property that varies from place to place, from 0 to 1.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Finish {
    /// How steep the facets of a rough matt part are.
    Grain,
    /// Share of the surface that the coat covers.
    Coat,
    /// How blurred reflections are that the coat, or metal, makes.
    Roughness,
    /// Share of the surface that is metal, whose reflections have its colour.
    Metal,
}

impl Finish {
    /// How many there are.
    pub const COUNT: usize = 4;

    /// All of them, with their names in scripts and the values that they have unless told.
    pub const ALL: [(Finish, &'static str, f64); Finish::COUNT] = [
        (Finish::Grain, "grain", 0.5),
        (Finish::Coat, "coat", 0.0),
        (Finish::Roughness, "roughness", 0.3),
        (Finish::Metal, "metal", 0.0),
    ];
}

impl Material {
    /// The fields that it is made of: those of [`Finish`] in their order, then the light given off.
    pub fn looks(&self) -> Vec<NodeId> {
        self.finish.into_iter().chain(self.emission.into_iter().flatten()).collect()
    }

    /// The same material with its fields in other words.
    ///
    /// # Errors
    /// The first that `change` gives.
    pub fn changed<E>(&self, mut change: impl FnMut(NodeId) -> Result<NodeId, E>) -> Result<Material, E> {
        let mut all = *self;
        for node in all.finish.iter_mut().chain(all.emission.iter_mut().flatten()).chain(&mut all.bump) {
            *node = change(*node)?;
        }
        Ok(all)
    }
}
