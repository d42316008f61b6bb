//! The faces of a cube around a point, as cube maps have them.
//!
//! Order and orientation are those of OpenGL and glTF, so that a face can be uploaded as it is: what
//! `texture(map, d)` finds is what lies in direction `d`. There faces are drawn as they are seen from *outside* the
//! cube, which is why what a camera in its middle sees is mirrored in them. The edges of faces meet like this:
//!
//! ```text
//!       +----+                    right  down
//!       | py |               px    -z     -y
//!  +----+----+----+----+     nx    +z     -y
//!  | nx | pz | px | nz |     py    +x     +z
//!  +----+----+----+----+     ny    +x     -z
//!       | ny |               pz    +x     -y
//!       +----+               nz    -x     -y
//! ```

use glam::DVec3;

/// A face of a cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// The axis that pierces its middle: `px` for +x, `nx` for -x.
    pub name: &'static str,
    /// That axis as a unit vector.
    pub middle: DVec3,
    /// Direction of its rows.
    pub right: DVec3,
    /// Direction of its columns.
    pub down: DVec3,
}

const fn face(name: &'static str, middle: DVec3, right: DVec3, down: DVec3) -> Face {
    Face { name, middle, right, down }
}

/// The faces, in the order of OpenGL.
pub const FACES: [Face; 6] = [
    face("px", DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y),
    face("nx", DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y),
    face("py", DVec3::Y, DVec3::X, DVec3::Z),
    face("ny", DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z),
    face("pz", DVec3::Z, DVec3::X, DVec3::NEG_Y),
    face("nz", DVec3::NEG_Z, DVec3::NEG_X, DVec3::NEG_Y),
];

impl Face {
    /// The direction of a place on the face, not of length one: `across` and `along` go from -1 to 1, to the
    /// right and down.
    pub fn direction(&self, across: f64, along: f64) -> DVec3 {
        self.middle + across * self.right + along * self.down
    }

    /// The face that a direction goes through, its number and the place on it; `None` for no direction.
    pub fn of(d: DVec3) -> Option<(usize, [f64; 2])> {
        let far = |face: &Face| d.dot(face.middle);
        let number = (0..FACES.len()).max_by(|&a, &b| far(&FACES[a]).total_cmp(&far(&FACES[b])))?;
        let face = &FACES[number];
        let depth = far(face);
        (depth > 0.0).then(|| (number, [d.dot(face.right) / depth, d.dot(face.down) / depth]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_not_mirrored_from_outside() {
        for face in FACES {
            assert_eq!(face.right.cross(-face.down), face.middle);
        }
    }

    #[test]
    fn directions_find_their_face() {
        for (number, face) in FACES.iter().enumerate() {
            for place in [[0.0, 0.0], [0.5, -0.25], [-0.75, 0.875]] {
                let found = Face::of(3.0 * face.direction(place[0], place[1])).unwrap();
                assert_eq!(found.0, number);
                assert!((0..2).all(|k| (found.1[k] - place[k]).abs() < 1e-15));
            }
        }
        assert_eq!(Face::of(DVec3::ZERO), None);
        assert_eq!(Face::of(DVec3::NAN), None);
    }
}
