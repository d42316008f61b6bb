//! Maps: which direction of a sphere, or which place of a plane, a pixel stands for.
//!
//! Axes are those of scripts: right-handed, y up. Both maps of a sphere show the sphere as it is seen from outside, north
//! at the top, not mirrored, and pixel (0, 0) is at the top left.
//!
//! *Equirectangular*: columns are longitudes, rows are latitudes. The middle is +z, which a camera of azimuth
//! 0 looks at; +x is a quarter of the width to the right of it, and the left and the right edge are -z. The top
//! edge is the north pole, +y. Pixel centres lie half a pixel within the edges, so no pixel lies on a pole, and
//! the last column is followed by the first.
//!
//! *Cube*: six squares, the [faces](scene::FACES) of OpenGL's cube maps, named by the axis that pierces their middle.
//! Seen from outside in a row, `nx pz px nz` go around the equator; `py` is above `pz` and `ny` is below it.
//!
//! *Plane*: level land from above, x to the right and z down, as `load_heightfield` lays pictures out.

use crate::scene::{self, FACES};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// How the ground becomes a picture.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Projection {
    /// Longitude across, latitude down, in one picture twice as wide as high.
    Equirectangular,
    /// Six squares around the sphere.
    Cube,
    /// A rectangle of level land, so many pixels wide.
    Plane {
        /// Its width.
        width: u32,
    },
}

/// A map of some size.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Chart {
    /// How the ground becomes a picture.
    pub projection: Projection,
    /// Height of each picture in pixels.
    pub size: u32,
}

impl Chart {
    /// Number of pictures.
    pub fn faces(&self) -> usize {
        match self.projection {
            Projection::Equirectangular | Projection::Plane { .. } => 1,
            Projection::Cube => FACES.len(),
        }
    }

    /// Width of each picture in pixels.
    pub fn width(&self) -> u32 {
        match self.projection {
            Projection::Equirectangular => 2 * self.size,
            Projection::Cube => self.size,
            Projection::Plane { width } => width,
        }
    }

    /// Pixels in all pictures.
    pub fn pixels(&self) -> u64 {
        self.faces() as u64 * u64::from(self.width()) * u64::from(self.size)
    }

    /// The files of a map, one for each face: `moon.png`, or `moon.px.png` and so on.
    pub fn files(&self, path: &Path) -> Vec<PathBuf> {
        match self.projection {
            Projection::Equirectangular | Projection::Plane { .. } => vec![path.to_owned()],
            Projection::Cube => {
                let ending = path.extension().unwrap_or_default().to_string_lossy();
                FACES.map(|face| path.with_extension(format!("{}.{ending}", face.name))).into()
            }
        }
    }

    /// Unit vector from the centre of the sphere to a place in a picture, given in pixels from its top left
    /// corner; the centre of the first pixel is at (0.5, 0.5). Of a plane it is upwards everywhere.
    pub fn direction(&self, face: usize, x: f64, y: f64) -> DVec3 {
        let size = f64::from(self.size);
        match self.projection {
            Projection::Equirectangular => {
                scene::direction(180.0 * x / size - 180.0, 90.0 - 180.0 * y / size)
            }
            Projection::Cube => {
                let [across, along] = [x, y].map(|place| 2.0 * place / size - 1.0);
                FACES[face % FACES.len()].direction(across, along).normalize()
            }
            Projection::Plane { .. } => DVec3::Y,
        }
    }

    /// How far a place in the picture is from its middle, as shares of its height: to the right, and down.
    pub fn off(&self, x: f64, y: f64) -> [f64; 2] {
        let size = f64::from(self.size);
        [(x - 0.5 * f64::from(self.width())) / size, y / size - 0.5]
    }

    /// Side of a pixel one unit away, where pixels are largest: at the equator, or in the middle of a face; of a plane as a
    /// share of its height.
    pub fn pixel(&self) -> f64 {
        let whole = match self.projection {
            Projection::Equirectangular => std::f64::consts::PI,
            Projection::Cube => 2.0,
            Projection::Plane { .. } => 1.0,
        };
        whole / f64::from(self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: f64 = 8.0;

    fn chart(projection: Projection) -> Chart {
        Chart { projection, size: SIZE as u32 }
    }

    #[track_caller]
    fn close(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-15, "{a} {b}");
    }

    #[test]
    fn longitudes_and_latitudes_are_where_people_expect_them() {
        let at = |x: f64, y: f64| chart(Projection::Equirectangular).direction(0, x * SIZE, y * SIZE);
        close(at(1.0, 0.5), DVec3::Z);
        close(at(1.5, 0.5), DVec3::X);
        close(at(0.5, 0.5), DVec3::NEG_X);
        close(at(0.0, 0.5), DVec3::NEG_Z);
        close(at(2.0, 0.3), at(0.0, 0.3));
        close(at(0.7, 0.0), DVec3::Y);
        close(at(0.1, 1.0), DVec3::NEG_Y);
        assert!(at(1.0, 0.25).y > 0.7 && at(1.0, 0.25).z > 0.7);
    }

    #[test]
    fn faces_meet_at_their_edges_as_they_are_drawn() {
        let cube = chart(Projection::Cube);
        let at = |name: &str, x: f64, y: f64| {
            let face = FACES.iter().position(|face| face.name == name).unwrap();
            cube.direction(face, x * SIZE, y * SIZE)
        };
        for t in [0.0, 0.25, 0.8, 1.0] {
            for (left, right) in [("nx", "pz"), ("pz", "px"), ("px", "nz"), ("nz", "nx")] {
                close(at(left, 1.0, t), at(right, 0.0, t));
            }
            close(at("py", t, 1.0), at("pz", t, 0.0));
            close(at("ny", t, 0.0), at("pz", t, 1.0));
            close(at("py", t, 0.0), at("nz", 1.0 - t, 0.0));
            close(at("ny", t, 1.0), at("nz", 1.0 - t, 1.0));
            close(at("py", 1.0, t), at("px", 1.0 - t, 0.0));
            close(at("ny", 0.0, t), at("nx", 1.0 - t, 1.0));
        }
    }

    #[test]
    fn land_is_seen_from_above() {
        let land = Chart { projection: Projection::Plane { width: 12 }, size: 8 };
        assert_eq!((land.width(), land.faces(), land.pixels()), (12, 1, 96));
        assert_eq!(
            (land.off(6.0, 4.0), land.off(0.0, 0.0), land.off(12.0, 8.0)),
            ([0.0, 0.0], [-0.75, -0.5], [0.75, 0.5])
        );
        assert_eq!((land.direction(0, 3.0, 1.0), land.pixel()), (DVec3::Y, 0.125));
    }

    #[test]
    fn the_middles_of_both_maps_agree() {
        let (flat, cube) = (chart(Projection::Equirectangular), chart(Projection::Cube));
        for (number, face) in FACES.into_iter().enumerate() {
            close(cube.direction(number, 0.5 * SIZE, 0.5 * SIZE), face.middle);
        }
        close(cube.direction(4, 0.5 * SIZE, 0.5 * SIZE), flat.direction(0, SIZE, 0.5 * SIZE));
    }

    #[test]
    fn files_are_named_after_faces() {
        let names = chart(Projection::Cube).files(Path::new("a/b.c.png"));
        assert_eq!((names.len(), names[0].as_path()), (6, Path::new("a/b.c.px.png")));
        assert_eq!(chart(Projection::Equirectangular).files(Path::new("a.exr")), [Path::new("a.exr")]);
    }
}
