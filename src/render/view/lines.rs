//! Lines of sight through parts of a picture, as bundles take them: planes across the lines, and a rectangle in these
//! planes that all of them go through.
//!
//! Those from a pinhole and parallel ones have the same planes all over the picture. Others have planes of their own for
//! each part, and may go through more of them than they fill:
//!
//! **Lens.** Lines through a rectangle of half sides `w` (one unit deep) and a lens of radius `r` are, at depth `z`, within
//! half sides of
//!
//! ```text
//! r (1 - z/F) + w z     up to the plane of focus, z = F
//! r (z/F - 1) + w z     from there on
//! ```
//!
//! around the line through the middle of both. Either is linear in `z`, and so a pyramid; its top is where the half side is
//! zero, at `F r / (r - w F)` and at `F r / (r + w F)`. So there are two pieces.
//!
//! **Panorama.** The planes stand across the line through the middle; how far longitudes and latitudes reach in them is
//! enclosed by intervals.
//!
//! **Cube map.** One piece for each face that the part of the picture lies on.

use super::super::Rect;
use super::{SHEET, Screen, View};
use crate::cast::Frame;
use crate::num::{Interval, Real};
use crate::scene::{FACES, Lens};
use glam::DVec3;
use std::f64::consts::PI;

/// A panorama's lines go too far apart where one of them leans more than by about 60 degrees against their middle.
const LEAST_DEPTH: f64 = 0.5;

/// Lines of sight through planes.
#[derive(Clone, Debug)]
pub(in super::super) struct Lines {
    /// Which piece of the lines it is. Pieces of parts of a part have the same numbers.
    pub piece: usize,
    /// The planes.
    pub frame: Frame,
    /// Places in a plane, one unit deep, from the least to the greatest along either axis.
    pub rectangle: [[f64; 2]; 2],
}

impl View {
    /// The lines of sight through a rectangle of pixels with so many more around it, in pieces; `None` where they go too
    /// far apart for planes across all of them, which those through a part may not.
    pub(in super::super) fn lines(&self, rect: &Rect, around: f64) -> Option<Vec<Lines>> {
        let View { eye, forward, right, up, .. } = *self;
        let pixels = [
            [f64::from(rect.x) - around, f64::from(rect.right()) + around],
            [f64::from(rect.y) - around, f64::from(rect.bottom()) + around],
        ];
        let one = |frame, rectangle| Some(vec![Lines { piece: 0, frame, rectangle }]);
        match self.screen {
            Screen::Perspective(half, Some(lens)) if lens.radius > 0.0 => {
                Some(self.through_lens(lens, self.on_screen(pixels, half)).into())
            }
            Screen::Perspective(half, _) => {
                one(Frame::from_point(eye, forward, [right, up]), self.on_screen(pixels, half))
            }
            Screen::Orthographic(half) => {
                let frame = Frame::parallel(eye, forward, [right, up], self.reach());
                one(frame, self.on_screen(pixels, half))
            }
            Screen::Panorama => Some(vec![self.on_globe(pixels)?]),
            Screen::CubeMap => Some(self.on_faces(pixels)),
        }
    }

    /// Where pixels are on a screen of half sides.
    fn on_screen(&self, [x, y]: [[f64; 2]; 2], half: [f64; 2]) -> [[f64; 2]; 2] {
        let across = |x: f64| (2.0 * x / self.size[0] - 1.0) * half[0];
        let upwards = |y: f64| (1.0 - 2.0 * y / self.size[1]) * half[1];
        [[across(x[0]), across(x[1])], [upwards(y[1]), upwards(y[0])]]
    }

    /// Those up to the plane of focus, and those from there on.
    fn through_lens(&self, Lens { radius, focus }: Lens, rectangle: [[f64; 2]; 2]) -> [Lines; 2] {
        let View { eye, forward, right, up, .. } = *self;
        let centre = rectangle.map(|[lo, hi]| 0.5 * (lo + hi));
        let half = rectangle.map(|[lo, hi]| 0.5 * (hi - lo));
        let sharp = half.map(|half| half * focus);
        let widest = sharp[0].max(sharp[1]);
        // No pyramid is as wide there as here.
        let lens = if (0.9..1.1).contains(&(radius / widest)) { 1.2 * widest } else { radius };
        let [before, beyond] = [focus * lens / (lens - widest), focus * radius / (radius + widest)];
        let middle = forward + centre[0] * right + centre[1] * up;
        let line = |piece: usize, top: f64, range: [f64; 2], extent: [f64; 2]| {
            let origin = eye + top * middle;
            let size = eye.abs().max_element() + top.abs() * middle.length();
            // Tops, and the places on the lens where lines start, are rounded.
            let rounding = 16.0 * f64::EPSILON * size / range[0].abs().min(range[1].abs());
            let rectangle = [0, 1].map(|k| {
                let extent = extent[k] * (1.0 + 1e-9) + rounding;
                [centre[k] - extent, centre[k] + extent]
            });
            let frame = Frame::from_point(origin, forward, [right, up]).between(range);
            Lines { piece, frame, rectangle }
        };
        let near = sharp.map(|sharp| (lens / before.abs()).max(sharp / (focus - before).abs()));
        let far = [0, 1].map(|k| (sharp[k] / (focus - beyond)).max(half[k] + radius / focus));
        [
            line(0, before, [-before, focus - before], near),
            line(1, beyond, [focus - beyond, f64::INFINITY], far),
        ]
    }

    /// Those through a part of a panorama, if they keep together.
    fn on_globe(&self, [x, y]: [[f64; 2]; 2]) -> Option<Lines> {
        let View { eye, forward, right, up, .. } = *self;
        let longitude = x.map(|x| PI * (2.0 * x / self.size[0] - 1.0));
        let latitude = y.map(|y| 0.5 * PI * (1.0 - 2.0 * y / self.size[1]));
        let [east, north] = [longitude, latitude].map(|[a, b]| 0.5 * (a + b));
        let level = libm::cos(east) * forward + libm::sin(east) * right;
        let axis = (libm::cos(north) * level + libm::sin(north) * up).normalize();
        let across = (libm::cos(east) * right - libm::sin(east) * forward).normalize();
        // A hair more, for the rounding of all this.
        let aside = Interval::radius(0.5 * (longitude[1] - longitude[0]) + 1e-14);
        let high = Interval::around(north, 0.5 * (latitude[0] - latitude[1]) + 1e-14);
        let [sine, cosine] = [libm::sin(north), libm::cos(north)].map(Interval::point);
        let depth = high.cos() * cosine * aside.cos() + high.sin() * sine;
        if depth.lo < LEAST_DEPTH {
            return None;
        }
        let places = [high.cos() * aside.sin(), high.sin() * cosine - high.cos() * sine * aside.cos()];
        let rectangle = places.map(|place| place / depth).map(|place| [place.lo, place.hi]);
        Some(Lines { piece: 0, frame: Frame::from_point(eye, axis, [across, across.cross(axis)]), rectangle })
    }

    /// Those through a part of a cube map, by faces.
    fn on_faces(&self, pixels: [[f64; 2]; 2]) -> Vec<Lines> {
        let View { eye, forward, right, up, .. } = *self;
        let sheet = [0, 1].map(|k| pixels[k].map(|at| at * SHEET[k] / self.size[k]));
        let world = |d: DVec3| d.x * right + d.y * up - d.z * forward;
        let on_face = |(piece, face): (usize, &crate::scene::Face)| {
            let rectangle = [0, 1].map(|k| {
                let corner = [piece % 3, piece / 3][k] as f64;
                // What is beyond the edge of the picture belongs to the face at the edge.
                let from = if corner == 0.0 { sheet[k][0] } else { sheet[k][0].max(corner) };
                let to = if corner == SHEET[k] - 1.0 { sheet[k][1] } else { sheet[k][1].min(corner + 1.0) };
                [from, to].map(|at| 2.0 * (at - corner) - 1.0)
            });
            let frame = Frame::from_point(eye, world(face.middle), [face.right, face.down].map(world));
            rectangle.iter().all(|[from, to]| from < to).then_some(Lines { piece, frame, rectangle })
        };
        FACES.iter().enumerate().filter_map(on_face).collect()
    }
}
