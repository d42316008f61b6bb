//! Moving a camera by hand.
//!
//! Ways across the picture are counted in heights of it, so that a drag does the same in a small window and a large one.
//! The point that a drag holds on to stays under the pointer when one pans or zooms: from orbit down to a pebble by the
//! wheel alone.

use crate::scene::{Camera, Projection};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// One movement.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Move {
    /// Around the target: so far to the right and down, half a turn for a height of the picture.
    Orbit([f64; 2]),
    /// The same for the head.
    Look([f64; 2]),
    /// Sideways: what is held moves so far to the right and down.
    Pan {
        /// How far.
        by: [f64; 2],
        /// The place in the picture, as shares of its width and height, that is held; the middle if there is none.
        at: Option<[f64; 2]>,
    },
    /// Closer by a factor below 1, or away by one above.
    Zoom {
        /// What distances are multiplied with.
        by: f64,
        /// The place that is held.
        at: Option<[f64; 2]>,
    },
    /// Steps to the right, up and ahead; a step is a tenth of the way to what is in the middle of the picture.
    Walk([f64; 3]),
}

/// Closest that an eye comes to the line through its target along `up`: of half a turn.
const POLE: f64 = 0.001;

/// Smallest and largest factor of one movement.
const FACTORS: [f64; 2] = [0.01, 100.0];

impl Move {
    /// Where in the picture the movement holds on to something.
    pub fn place(&self) -> [f64; 2] {
        match self {
            Move::Pan { at: Some(at), .. } | Move::Zoom { at: Some(at), .. } => *at,
            _ => [0.5; 2],
        }
    }

    /// Whether all numbers are, and the place is in or near the picture.
    pub fn is_finite(&self) -> bool {
        let place = self.place().iter().all(|c| (-1.0..=2.0).contains(c));
        place
            && match self {
                Move::Orbit(by) | Move::Look(by) | Move::Pan { by, .. } => by.iter().all(|c| c.is_finite()),
                Move::Zoom { by, .. } => by.is_finite() && *by > 0.0,
                Move::Walk(steps) => steps.iter().all(|c| c.is_finite()),
            }
    }

    /// The camera after the movement, which holds on to the point `held`.
    pub fn of(&self, camera: &Camera, held: DVec3) -> Camera {
        let Camera { eye, target, .. } = *camera;
        let view = target - eye;
        match *self {
            Move::Orbit(by) => Camera { eye: target - turned(view, camera.up, by), ..*camera },
            // The head turns the other way than what it sees.
            Move::Look(by) => Camera { target: eye + turned(view, camera.up, by.map(|c| -c)), ..*camera },
            Move::Pan { by, .. } => {
                let [right, up] = axes(camera);
                let shift = height_at(camera, held) * (-by[0] * right + by[1] * up);
                Camera { eye: eye + shift, target: target + shift, ..*camera }
            }
            Move::Zoom { by, .. } => zoomed(camera, by.clamp(FACTORS[0], FACTORS[1]), held),
            Move::Walk([x, y, z]) => {
                let [right, up] = axes(camera);
                let step = 0.1 * (held - eye).length();
                let shift = step * (x * right + y * up + z * view.normalize_or_zero());
                Camera { eye: eye + shift, target: target + shift, ..*camera }
            }
        }
    }
}

/// Unit vectors to the right and upwards in the picture.
fn axes(camera: &Camera) -> [DVec3; 2] {
    let ahead = (camera.target - camera.eye).normalize_or_zero();
    let right = ahead.cross(camera.up).try_normalize().unwrap_or_else(|| ahead.any_orthonormal_vector());
    [right, right.cross(ahead)]
}

/// A view turned so far to the right and down, that stays clear of the poles.
fn turned(view: DVec3, up: DVec3, by: [f64; 2]) -> DVec3 {
    let Some(up) = up.try_normalize() else { return view };
    let angle = view.angle_between(up);
    let pole = POLE * PI;
    let tilt = (angle + PI * by[1]).clamp(pole, PI - pole) - angle;
    let side = view.cross(up).try_normalize().unwrap_or_else(|| up.any_orthonormal_vector());
    let tilted = rotate(view, side, -tilt);
    rotate(tilted, up, -PI * by[0])
}

/// A vector turned around a unit vector, in radians (Rodrigues).
fn rotate(v: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(angle);
    cos * v + sin * axis.cross(v) + (1.0 - cos) * axis.dot(v) * axis
}

/// Everything around the held point becomes larger by 1/by; parallel rays leave the eye where it is.
fn zoomed(camera: &Camera, by: f64, held: DVec3) -> Camera {
    let around = |p: DVec3| held + by * (p - held);
    match camera.projection {
        Projection::Orthographic { height } => {
            let [right, up] = axes(camera);
            let aside = held - camera.target;
            let shift = (1.0 - by) * (aside.dot(right) * right + aside.dot(up) * up);
            Camera { eye: camera.eye + shift, target: camera.target + shift, ..*camera }
                .with(Projection::Orthographic { height: by * height })
        }
        Projection::Perspective { fov, lens } => {
            let lens =
                lens.map(|lens| crate::scene::Lens { radius: by * lens.radius, focus: by * lens.focus });
            Camera { eye: around(camera.eye), target: around(camera.target), ..*camera }
                .with(Projection::Perspective { fov, lens })
        }
        Projection::Panorama | Projection::CubeMap => {
            Camera { eye: around(camera.eye), target: around(camera.target), ..*camera }
        }
    }
}

/// How much the height of the picture shows at a point.
fn height_at(camera: &Camera, p: DVec3) -> f64 {
    let depth = (p - camera.eye).dot((camera.target - camera.eye).normalize_or_zero()).abs();
    match camera.projection {
        Projection::Orthographic { height } => height,
        Projection::Perspective { fov, .. } => 2.0 * depth * libm::tan(0.5 * fov.to_radians()),
        Projection::Panorama | Projection::CubeMap => depth * PI,
    }
}

/// The point of the target's distance at a place of the picture, given as shares of width and height: held where nothing
/// is seen.
pub fn beyond(camera: &Camera, [x, y]: [f64; 2], shape: f64) -> DVec3 {
    let [right, up] = axes(camera);
    let from_middle = DVec2::new(shape * (x - 0.5), 0.5 - y) * height_at(camera, camera.target);
    camera.target + from_middle.x * right + from_middle.y * up
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::View;

    fn cameras() -> [Camera; 2] {
        let camera = Camera::orbit(DVec3::new(0.1, 0.2, 0.3), 4.0, 30.0, 20.0);
        [camera, camera.with(Projection::Orthographic { height: 3.0 })]
    }

    /// Where a point is in the picture, as shares.
    fn seen(camera: &Camera, p: DVec3) -> DVec2 {
        let [x, y] = View::new(camera, 200, 100).unwrap().project(p).unwrap();
        DVec2::new(x / 200.0, y / 100.0)
    }

    #[test]
    fn what_is_held_stays_under_the_pointer() {
        for camera in cameras() {
            let held = DVec3::new(0.4, 0.9, 0.2);
            let before = seen(&camera, held);
            for by in [0.5, 0.9, 3.0] {
                let at = Some(before.to_array());
                assert!(seen(&Move::Zoom { by, at }.of(&camera, held), held).distance(before) < 1e-12);
                let panned = Move::Pan { by: [0.2, -0.1], at }.of(&camera, held);
                let moved = seen(&panned, held) - before;
                assert!(moved.distance(DVec2::new(0.1, -0.1)) < 1e-12, "{moved}");
            }
        }
    }

    #[test]
    fn zooming_never_arrives() {
        let mut camera = cameras()[0];
        let held = DVec3::new(0.4, 0.9, 0.2);
        for _ in 0..60 {
            camera = Move::Zoom { by: 0.8, at: None }.of(&camera, held);
        }
        let left = camera.eye.distance(held);
        assert!(left > 0.0 && left < 1e-4);
    }

    #[test]
    fn orbits_keep_their_distance_and_stay_upright() {
        let camera = cameras()[0];
        let turned = Move::Orbit([0.3, 0.1]).of(&camera, camera.target);
        assert!((turned.eye.distance(turned.target) - 4.0).abs() < 1e-12 && turned.target == camera.target);
        // Dragging to the right brings what is on the left: the eye goes left.
        assert!((turned.eye - camera.eye).dot(axes(&camera)[0]) < 0.0);
        // Dragging down lifts the eye.
        let lifted = Move::Orbit([0.0, 0.1]).of(&camera, camera.target);
        assert!(lifted.eye.y > camera.eye.y);
        let above = Move::Orbit([0.0, 9.0]).of(&camera, camera.target);
        let view = (above.target - above.eye).normalize();
        assert!(view.y > -1.0 && view.y < -0.99999, "{view}");
        let looked = Move::Look([0.25, 0.0]).of(&camera, camera.target);
        assert!(looked.eye == camera.eye && looked.target.distance(camera.target) > 1.0);
    }

    #[test]
    fn steps_suit_what_is_ahead() {
        let camera = cameras()[0];
        let near = Move::Walk([0.0, 0.0, 1.0]).of(&camera, camera.eye + 0.01 * (camera.target - camera.eye));
        assert!((near.eye.distance(camera.eye) - 0.004).abs() < 1e-12);
    }

    #[test]
    fn where_nothing_is_seen_there_is_still_something_to_hold() {
        for camera in cameras() {
            let p = beyond(&camera, [0.9, 0.2], 2.0);
            assert!(seen(&camera, p).distance(DVec2::new(0.9, 0.2)) < 1e-12);
        }
    }
}
