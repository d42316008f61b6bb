//! Polygon meshes as plain data.

use glam::DVec3;

/// Triangles that share points. What scripts load, what is made of solids, and what files hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Points.
    pub points: Vec<DVec3>,
    /// Corners of triangles as numbers of points, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals of the points; empty if there are none.
    pub normals: Vec<DVec3>,
    /// Linear colours of the points, red, green and blue; empty if there are none.
    pub colors: Vec<[f32; 3]>,
}

impl Mesh {
    /// The mesh turned a quarter about x, so that what was up along y is up along z.
    pub fn with_z_up(&self) -> Mesh {
        let turned = |all: &[DVec3]| all.iter().map(|p| DVec3::new(p.x, -p.z, p.y)).collect();
        let (triangles, colors) = (self.triangles.clone(), self.colors.clone());
        Mesh { points: turned(&self.points), normals: turned(&self.normals), triangles, colors }
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|i| self.points[i as usize])
    }

    /// The smallest box that holds all points, as its two extreme corners; none without points.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.points.first()?;
        Some(self.points.iter().fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p))))
    }

    /// What is wrong with the mesh, if anything: indices out of range, numbers that are not finite, or
    /// normals and colours that are not as many as the points.
    ///
    /// # Errors
    /// The first flaw.
    pub fn check(&self) -> Result<(), Flaw> {
        let count = self.points.len();
        for (what, given) in [("normals", self.normals.len()), ("colours", self.colors.len())] {
            if given != 0 && given != count {
                return Err(Flaw::Count { what, given, wanted: count });
            }
        }
        if let Some(at) = self.points.iter().position(|p| !p.is_finite()) {
            return Err(Flaw::Point(at));
        }
        let wrong = self.triangles.iter().position(|t| t.iter().any(|i| *i as usize >= count));
        wrong.map_or(Ok(()), |at| Err(Flaw::Index { triangle: at, count }))
    }
}

/// Why some data are no mesh.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Flaw {
    /// Not one for each point.
    #[error("there are {given} {what} for {wanted} points")]
    Count {
        /// Of what.
        what: &'static str,
        /// How many there are.
        given: usize,
        /// How many there should be.
        wanted: usize,
    },
    /// A point is nowhere.
    #[error("point {0} is not finite")]
    Point(usize),
    /// A corner is none of the points.
    #[error("triangle {triangle} has a corner beyond the {count} points")]
    Index {
        /// Which.
        triangle: usize,
        /// Number of points.
        count: usize,
    },
}
