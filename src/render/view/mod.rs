//! The camera: from places in the picture to rays, and from points to places.
//!
//! **Lens.** What lies in the plane of focus, at depth `F`, is sharp: every ray through a place in the picture
//! meets the point of that plane which a pinhole would see there, wherever on the lens it starts (Cook, Porter and
//! Carpenter, *Distributed ray tracing*, 1984). A point at depth `z` is therefore seen in a disc of radius
//!
//! ```text
//! r |z - F| / (z F)        r: radius of the lens; in the picture one unit in front of the eye
//! ```

mod lines;

use super::disc::on_disc;
use super::{CameraError, Settings};
use crate::cast::Tolerance;
use crate::scene::{Camera, FACES, Face, Lens, Projection, Spacing};
use glam::DVec3;
pub(super) use lines::Lines;
use std::f64::consts::PI;

/// Faces of a cube map in a row of the picture, and rows.
const SHEET: [f64; 2] = [3.0, 2.0];

/// A camera made ready for a picture of some size. Pixel (0, 0) is at the top left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position.
    pub eye: DVec3,
    /// Unit vector in the direction of view.
    pub forward: DVec3,
    /// Unit vector to the right in the picture.
    pub right: DVec3,
    /// Unit vector up in the picture.
    pub up: DVec3,
    screen: Screen,
    size: [f64; 2],
}

/// What the picture is spread on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Screen {
    /// A rectangle one unit in front of the eye, of these half sides.
    Perspective([f64; 2], Option<Lens>),
    /// A rectangle around the eye.
    Orthographic([f64; 2]),
    /// A sphere.
    Panorama,
    /// A cube.
    CubeMap,
}

impl View {
    /// The view of a camera. Where its `up` is zero or along the line of sight, so that it does not
    /// say which way is up, the y axis stands in for it, and the z axis where that fails too: the
    /// picture is then turned about its middle, which is better than none.
    ///
    /// # Errors
    /// [`CameraError`] for an eye at its target, numbers that are not finite, and angles of view, heights
    /// and lenses that are none.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Result<View, CameraError> {
        let Camera { eye, target, up, projection } = *camera;
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        let forward = (target - eye).try_normalize().ok_or(CameraError::EyeIsTarget)?;
        let (upwards, right) = [up, DVec3::Y, DVec3::Z]
            .into_iter()
            .filter_map(DVec3::try_normalize)
            .map(|up| (up, forward.cross(up)))
            .find(|(_, right)| right.length() > 1e-6)
            .unwrap_or((DVec3::Y, DVec3::X));
        let (size, right) = ([f64::from(width), f64::from(height)], right.normalize());
        let screen = Screen::new(projection, size[0] / size[1])?;
        let (forward, up) = match screen {
            Screen::Perspective(..) | Screen::Orthographic(_) => (forward, right.cross(forward)),
            // Upright, so that the horizon is a straight line.
            Screen::Panorama | Screen::CubeMap => (upwards.cross(right), upwards),
        };
        Ok(View { eye, forward, right, up, screen, size })
    }

    /// Origin and direction, a unit vector, of the line of sight through a place in the picture, given in
    /// pixels. `lens` in the unit square is spread evenly over the lens, of which (0.5, 0.5) is the centre.
    pub fn ray(&self, x: f64, y: f64, lens: [f64; 2]) -> (DVec3, DVec3) {
        let View { eye, forward, right, up, .. } = *self;
        let across = 2.0 * x / self.size[0] - 1.0;
        let upwards = 1.0 - 2.0 * y / self.size[1];
        match self.screen {
            Screen::Perspective(half, given) => {
                let through = forward + across * half[0] * right + upwards * half[1] * up;
                let Some(Lens { radius, focus }) = given else { return (eye, through.normalize()) };
                let [a, b] = on_disc(lens);
                let aside = radius * (a * right + b * up);
                (eye + aside, (focus * through - aside).normalize())
            }
            Screen::Orthographic(half) => (eye + across * half[0] * right + upwards * half[1] * up, forward),
            Screen::Panorama => {
                let (longitude, latitude) = (PI * across, 0.5 * PI * upwards);
                let level = libm::cos(longitude) * forward + libm::sin(longitude) * right;
                (eye, (libm::cos(latitude) * level + libm::sin(latitude) * up).normalize())
            }
            Screen::CubeMap => {
                let (number, [across, along]) = self.cell([x, y]);
                let d = FACES[number].direction(across, along);
                (eye, (d.x * right + d.y * up - d.z * forward).normalize())
            }
        }
    }

    /// The place in the picture, in pixels, where a point appears, or the middle of its disc; `None`
    /// behind the camera.
    pub fn project(&self, p: DVec3) -> Option<[f64; 2]> {
        let d = p - self.eye;
        let [x, y, depth] = [self.right, self.up, self.forward].map(|axis| d.dot(axis));
        let on_screen = |x: f64, y: f64| [0.5 * (1.0 + x) * self.size[0], 0.5 * (1.0 - y) * self.size[1]];
        match self.screen {
            Screen::Perspective(half, _) => {
                (depth > 0.0).then(|| on_screen(x / (depth * half[0]), y / (depth * half[1])))
            }
            Screen::Orthographic(half) => (depth > 0.0).then(|| on_screen(x / half[0], y / half[1])),
            Screen::Panorama => (d != DVec3::ZERO).then(|| {
                let latitude = libm::atan2(y, libm::hypot(x, depth));
                on_screen(libm::atan2(x, depth) / PI, latitude / (0.5 * PI))
            }),
            Screen::CubeMap => Face::of(DVec3::new(x, y, -depth)).map(|(number, place)| {
                let corner = [number % 3, number / 3];
                std::array::from_fn(|k| (corner[k] as f64 + 0.5 * (1.0 + place[k])) * self.size[k] / SHEET[k])
            }),
        }
    }

    /// Whether a point is within the picture, if nothing is in front of it.
    pub fn shows(&self, p: DVec3) -> bool {
        self.project(p).is_some_and(|at| (0..2).all(|axis| (0.0..=self.size[axis]).contains(&at[axis])))
    }

    /// Where a short straight line appears; `None` where an end is not seen, or where the line runs over a
    /// seam of the picture.
    pub fn project_line(&self, ends: [DVec3; 2]) -> Option<[[f64; 2]; 2]> {
        let [a, b] = [self.project(ends[0])?, self.project(ends[1])?];
        let is_torn = match self.screen {
            Screen::Perspective(..) | Screen::Orthographic(_) => false,
            Screen::Panorama => (a[0] - b[0]).abs() > 0.5 * self.size[0],
            Screen::CubeMap => self.cell(a).0 != self.cell(b).0,
        };
        (!is_torn).then_some([a, b])
    }

    /// How far away a point is: along the view, or from the eye of a camera that sees all around.
    pub fn depth(&self, p: DVec3) -> f64 {
        match self.screen {
            Screen::Perspective(..) | Screen::Orthographic(_) => (p - self.eye).dot(self.forward),
            Screen::Panorama | Screen::CubeMap => p.distance(self.eye),
        }
    }

    /// Height of a pixel in the middle of the picture, or of a face: seen from one unit away, or in units of length in
    /// an orthographic picture.
    pub fn pixel(&self) -> f64 {
        let whole = match self.screen {
            Screen::Perspective(half, _) | Screen::Orthographic(half) => 2.0 * half[1],
            Screen::Panorama => PI,
            Screen::CubeMap => 2.0 * SHEET[1],
        };
        whole / self.size[1]
    }

    /// How far apart neighbouring samples are, with so many in a pixel.
    pub fn spacing(&self, samples: u32) -> Spacing {
        let apart = self.pixel() / f64::from(samples).sqrt();
        match self.screen {
            Screen::Orthographic(_) => Spacing::Even(apart),
            _ => Spacing::Angle { from: self.eye, angle: apart },
        }
    }

    /// How far apart neighbouring pixels are at a distance along a line of sight.
    pub fn footprint(&self, distance: f64) -> f64 {
        match self.screen {
            Screen::Orthographic(_) => self.pixel(),
            _ => self.pixel() * distance,
        }
    }

    /// Width over height of a picture with square pixels, if that of this one differs by more than a
    /// hundredth.
    pub fn wanted_shape(&self) -> Option<f64> {
        let wanted = match self.screen {
            Screen::Perspective(..) | Screen::Orthographic(_) => return None,
            Screen::Panorama => 2.0,
            Screen::CubeMap => SHEET[0] / SHEET[1],
        };
        let ratio = self.size[0] / (wanted * self.size[1]);
        (!(0.99..1.01).contains(&ratio)).then_some(wanted)
    }

    /// The face of a cube map at a place in the picture, and where on it, from (-1, -1) to (1, 1).
    fn cell(&self, place: [f64; 2]) -> (usize, [f64; 2]) {
        let at: [f64; 2] = std::array::from_fn(|k| SHEET[k] * place[k] / self.size[k]);
        let corner: [f64; 2] = std::array::from_fn(|k| at[k].floor().clamp(0.0, SHEET[k] - 1.0));
        let number = SHEET[0] * corner[1] + corner[0];
        (number as usize, std::array::from_fn(|k| 2.0 * (at[k] - corner[k]) - 1.0))
    }

    /// How far from the origin rays start, on any axis.
    fn reach(&self) -> f64 {
        let aside = match self.screen {
            Screen::Perspective(_, lens) => lens.map_or(0.0, |lens| lens.radius),
            Screen::Orthographic([x, y]) => x + y,
            Screen::Panorama | Screen::CubeMap => 0.0,
        };
        self.eye.abs().max_element() + aside
    }
}

impl Screen {
    /// The screen of a picture so many times as wide as high.
    fn new(projection: Projection, shape: f64) -> Result<Screen, CameraError> {
        Ok(match projection {
            Projection::Perspective { fov, .. } if !(fov > 0.0 && fov < 180.0) => {
                return Err(CameraError::Fov(fov));
            }
            Projection::Perspective { lens: Some(Lens { radius, focus }), .. }
                if !(radius >= 0.0 && radius.is_finite() && focus > 0.0 && focus.is_finite()) =>
            {
                return Err(CameraError::Lens { radius, focus });
            }
            Projection::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
                return Err(CameraError::Height(height));
            }
            Projection::Perspective { fov, lens } => {
                let half = libm::tan(0.5 * fov.to_radians());
                Screen::Perspective([half * shape, half], lens)
            }
            Projection::Orthographic { height } => Screen::Orthographic([0.5 * height * shape, 0.5 * height]),
            Projection::Panorama => Screen::Panorama,
            Projection::CubeMap => Screen::CubeMap,
        })
    }
}

/// Tolerance that suits a view: a five-hundredth of a pixel, wherever the ray is, down to what double
/// precision can give.
pub(super) fn tolerance(view: &View, settings: &Settings) -> Tolerance {
    /// Of a pixel.
    const SHARE: f64 = 0.002;
    let bounds = &settings.bounds;
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element().max(view.reach());
    let least = 1e-13 * reach;
    match view.spacing(1) {
        Spacing::Angle { angle, .. } => Tolerance { least, growth: SHARE * angle },
        Spacing::Even(side) => Tolerance::fixed(least.max(SHARE * side)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::rays::piece;
    use super::*;
    use crate::scene::Aabb;

    /// The centre of the lens.
    const CENTRE: [f64; 2] = [0.5, 0.5];

    fn front(fov: f64) -> Camera {
        Camera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO).with_fov(fov)
    }

    /// A camera askew, of every projection.
    fn everything() -> [Camera; 5] {
        let lens = Some(Lens { radius: 0.1, focus: 3.0 });
        [
            Projection::default(),
            Projection::Perspective { fov: 60.0, lens },
            Projection::Orthographic { height: 2.0 },
            Projection::Panorama,
            Projection::CubeMap,
        ]
        .map(|projection| Camera::default().with(projection))
    }

    fn view(camera: &Camera, width: u32, height: u32) -> View {
        View::new(camera, width, height).unwrap()
    }

    #[track_caller]
    fn close(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-14, "{a} {b}");
    }

    #[test]
    fn axes_are_where_people_expect_them() {
        let view = view(&front(90.0), 200, 100);
        let direction = |x: f64, y: f64| view.ray(x, y, CENTRE).1;
        assert_eq!(view.right, DVec3::X);
        assert_eq!(view.up, DVec3::Y);
        close(direction(100.0, 50.0), DVec3::NEG_Z);
        let corner = direction(0.0, 0.0);
        assert!(corner.x < 0.0 && corner.y > 0.0);
        // 90 degrees from the top edge to the bottom edge; square pixels.
        let (top, bottom) = (direction(100.0, 0.0), direction(100.0, 100.0));
        assert!(top.dot(bottom).abs() < 1e-15);
        let left = direction(0.0, 50.0);
        assert!((left.x / left.z - 2.0).abs() < 1e-12);
        assert!((view.pixel() - 0.02).abs() < 1e-15);
    }

    #[test]
    fn orthographic_rays_are_parallel() {
        let camera = front(35.0).with(Projection::Orthographic { height: 2.0 });
        let view = view(&camera, 200, 100);
        for (x, y, from) in [(100.0, 50.0, [0.0, 0.0]), (0.0, 0.0, [-2.0, 1.0]), (200.0, 75.0, [2.0, -0.5])] {
            let (origin, direction) = view.ray(x, y, CENTRE);
            assert_eq!((origin, direction), (DVec3::new(from[0], from[1], 5.0), DVec3::NEG_Z));
        }
        assert_eq!(view.spacing(4), Spacing::Even(0.01));
    }

    #[test]
    fn a_panorama_goes_around_from_behind_and_from_pole_to_pole() {
        let view = view(&front(35.0).with(Projection::Panorama), 400, 200);
        let direction = |x: f64, y: f64| view.ray(x, y, CENTRE).1;
        close(direction(200.0, 100.0), DVec3::NEG_Z);
        close(direction(300.0, 100.0), DVec3::X);
        close(direction(100.0, 100.0), DVec3::NEG_X);
        close(direction(0.0, 100.0), DVec3::Z);
        close(direction(400.0, 70.0), direction(0.0, 70.0));
        close(direction(123.0, 0.0), DVec3::Y);
        close(direction(321.0, 200.0), DVec3::NEG_Y);
        assert!((view.pixel() - PI / 200.0).abs() < 1e-15);
        // Neighbouring rays are a pixel apart.
        let apart = direction(200.0, 100.0).distance(direction(200.0, 101.0));
        assert!((apart / view.pixel() - 1.0).abs() < 1e-4);
    }

    #[test]
    fn all_around_means_upright() {
        for projection in [Projection::Panorama, Projection::CubeMap] {
            let camera = Camera::look_at(DVec3::ZERO, DVec3::new(1.0, 3.0, 0.0)).with(projection);
            let view = view(&camera, 30, 20);
            close(view.up, DVec3::Y);
            close(view.forward, DVec3::X);
        }
    }

    #[test]
    fn faces_of_a_cube_map_lie_in_opengls_order() {
        let view = view(&front(35.0).with(Projection::CubeMap), 300, 200);
        let direction = |x: f64, y: f64| view.ray(x, y, CENTRE).1;
        for (number, face) in FACES.into_iter().enumerate() {
            let corner = [100.0 * (number % 3) as f64, 100.0 * (number / 3) as f64];
            close(direction(corner[0] + 50.0, corner[1] + 50.0), face.middle);
            // The first texel is at the top left.
            let near = direction(corner[0] + 1e-9, corner[1] + 1e-9);
            let want = (face.middle - face.right - face.down).normalize();
            assert!((near - want).length() < 1e-9);
        }
        let apart = direction(50.0, 50.0).distance(direction(50.0, 51.0));
        assert!((apart / view.pixel() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn faces_of_a_cube_map_meet() {
        let view = view(&Camera::default().with(Projection::CubeMap), 300, 200);
        let inside = 1e-9;
        // Two ways to the same edge: face, and place on it.
        let at = |number: usize, u: f64, v: f64| {
            let clamp = |t: f64| (100.0 * t).clamp(inside, 100.0 - inside);
            let (column, row) = ((number % 3) as f64, (number / 3) as f64);
            view.ray(100.0 * column + clamp(u), 100.0 * row + clamp(v), CENTRE).1
        };
        let [px, nx, py, ny, pz, nz] = [0, 1, 2, 3, 4, 5];
        for t in [0.0, 0.25, 0.8, 1.0] {
            let pairs = [
                (at(nx, 1.0, t), at(pz, 0.0, t)),
                (at(pz, 1.0, t), at(px, 0.0, t)),
                (at(px, 1.0, t), at(nz, 0.0, t)),
                (at(nz, 1.0, t), at(nx, 0.0, t)),
                (at(py, t, 1.0), at(pz, t, 0.0)),
                (at(ny, t, 0.0), at(pz, t, 1.0)),
                (at(py, t, 0.0), at(nz, 1.0 - t, 0.0)),
                (at(ny, t, 1.0), at(nz, 1.0 - t, 1.0)),
                (at(py, 1.0, t), at(px, 1.0 - t, 0.0)),
                (at(py, 0.0, t), at(nx, t, 0.0)),
                (at(ny, 1.0, t), at(px, t, 1.0)),
                (at(ny, 0.0, t), at(nx, 1.0 - t, 1.0)),
            ];
            for (k, (a, b)) in pairs.into_iter().enumerate() {
                assert!((a - b).length() < 1e-9, "{k}: {a} {b}");
            }
        }
    }

    #[test]
    fn projection_inverts_rays() {
        for camera in everything() {
            let view = view(&camera, 320, 240);
            for (x, y) in [(0.5, 0.5), (17.3, 200.9), (160.0, 120.0), (319.0, 1.0), (107.0, 121.0)] {
                // Where a lens is sharp, and anywhere for the others.
                let (origin, direction) = view.ray(x, y, [0.1, 0.8]);
                let p = origin + 3.0 / direction.dot(view.forward).abs() * direction;
                let [u, v] = view.project(p).unwrap();
                assert!((u - x).abs() < 1e-9 && (v - y).abs() < 1e-9, "{camera:?}: {u} {v} for {x} {y}");
            }
        }
    }

    #[test]
    fn what_is_behind_is_seen_by_those_who_look_around() {
        let seen = everything().map(|camera| {
            let view = view(&camera, 30, 20);
            view.project(view.eye - view.forward).is_some()
        });
        assert_eq!(seen, [false, false, false, true, true]);
    }

    #[test]
    fn lines_over_a_seam_are_not_drawn() {
        let behind = [DVec3::new(-0.1, 0.0, 9.0), DVec3::new(0.1, 0.0, 9.0)];
        let ahead = [DVec3::new(-0.1, 0.0, -9.0), DVec3::new(0.1, 0.0, -9.0)];
        let across = [DVec3::new(-9.0, 0.0, -3.9), DVec3::new(-9.0, 0.0, -4.1)];
        let drawn = [Projection::Panorama, Projection::CubeMap].map(|projection| {
            let view = view(&front(35.0).with(projection), 30, 20);
            [behind, ahead, across].map(|line| view.project_line(line).is_some())
        });
        assert_eq!(drawn, [[false, true, true], [true, true, false]]);
    }

    #[test]
    fn rays_through_a_pixel_meet_in_the_plane_of_focus() {
        let view = view(&everything()[1], 320, 240);
        for (x, y) in [(160.0, 120.0), (3.0, 200.0)] {
            let meet = |lens: [f64; 2]| {
                let (origin, direction) = view.ray(x, y, lens);
                let depth = (origin - view.eye).dot(view.forward);
                assert!(depth.abs() < 1e-14 && (origin - view.eye).length() < 0.1 + 1e-14);
                origin + 3.0 / direction.dot(view.forward) * direction
            };
            let sharp = meet(CENTRE);
            assert!(((sharp - view.eye).dot(view.forward) - 3.0).abs() < 1e-14);
            for i in 0..100 {
                close(meet([f64::from(i % 10) / 9.0, f64::from(i / 10) / 9.0]), sharp);
            }
        }
    }

    #[test]
    fn circles_of_confusion_are_as_large_as_optics_says() {
        let (radius, focus) = (0.1, 3.0);
        let view = view(&everything()[1], 320, 240);
        for z in [0.7, 2.0, 3.0, 12.0] {
            let p = view.eye + z * view.forward;
            let pixels = radius * (focus - z) / (z * focus) / view.pixel();
            for i in 0..100 {
                // From a place on the edge of the lens the point is seen at one on the edge of the disc:
                // on the same side if it lies behind the plane of focus, else on the other.
                let lens = [f64::from(i) / 99.0, f64::from(i % 2)];
                let aside = (view.ray(160.0, 120.0, lens).0 - view.eye) / radius;
                assert!((aside.length() - 1.0).abs() < 1e-14);
                let place = [aside.dot(view.right), -aside.dot(view.up)].map(|along| -pixels * along);
                let (origin, direction) = view.ray(160.0 + place[0], 120.0 + place[1], lens);
                let missed = (p - origin).cross(direction).length();
                assert!(missed < 1e-13, "{z}: {missed}");
            }
        }
    }

    #[test]
    fn degenerate_cameras() {
        let at_target = Camera { target: front(35.0).eye, ..front(35.0) };
        assert_eq!(View::new(&at_target, 8, 8), Err(CameraError::EyeIsTarget));
        assert_eq!(View::new(&front(180.0), 8, 8), Err(CameraError::Fov(180.0)));
        assert!(View::new(&front(f64::NAN), 8, 8).is_err());
        let flat = front(35.0).with(Projection::Orthographic { height: 0.0 });
        assert_eq!(View::new(&flat, 8, 8), Err(CameraError::Height(0.0)));
        for (radius, focus) in [(-1.0, 1.0), (f64::NAN, 1.0), (0.1, 0.0), (0.1, f64::INFINITY)] {
            let lens = Some(Lens { radius, focus });
            let blind = front(35.0).with(Projection::Perspective { fov: 35.0, lens });
            assert!(matches!(View::new(&blind, 8, 8), Err(CameraError::Lens { .. })));
        }
        for up in [DVec3::Z, DVec3::ZERO, DVec3::NEG_Z * 1e-300] {
            let view = view(&Camera { up, ..front(35.0) }, 8, 8);
            assert_eq!((view.right, view.up), (DVec3::X, DVec3::Y));
        }
        let view = view(&Camera::look_at(DVec3::Y, DVec3::ZERO), 8, 8);
        assert!((view.up.length() - 1.0).abs() < 1e-15 && view.up.dot(view.forward) == 0.0);
    }

    #[test]
    fn shapes_that_stretch_pixels_are_known() {
        let wanted = |projection, width| view(&front(35.0).with(projection), width, 100).wanted_shape();
        assert_eq!(wanted(Projection::Panorama, 200), None);
        assert_eq!(wanted(Projection::Panorama, 150), Some(2.0));
        assert_eq!(wanted(Projection::CubeMap, 150), None);
        assert_eq!(wanted(Projection::CubeMap, 200), Some(1.5));
        assert_eq!(wanted(Projection::default(), 17), None);
    }

    #[test]
    fn rays_stay_in_the_bounds() {
        let (eye, tolerance) = (front(35.0).eye, Tolerance::fixed(1e-6));
        let ray = piece((eye, DVec3::NEG_Z), &Aabb::cube(1.0), tolerance).unwrap();
        assert_eq!((ray.near, ray.far), (4.0, 6.0));
        assert_eq!(piece((eye, DVec3::Z), &Aabb::cube(1.0), tolerance), None);
        let inside = piece((eye, DVec3::NEG_Z), &Aabb::cube(10.0), tolerance).unwrap();
        assert_eq!((inside.near, inside.far), (1e-6, 15.0));
    }
}
