//! Motion blur: the script is run again for every moment while the shutter is open.
//!
//! So whatever depends on time moves: cameras, lights, fields, flows. Moments lie at the middles of equal parts of the
//! shutter's density; each pixel takes its samples at them in an order of its own.

use super::{Order, Session, stage};
use crate::diag::{Diagnostic, Severity};
use crate::render::{self, Job, Picture, Steering};
use crate::scene::{Scene, Shutter};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Most moments of a picture: what moves by less than this many pixels while the shutter is open leaves no steps. For each
/// the script is run and its fields are made ready.
const MOST: u32 = 64;

impl Session {
    /// Renders a scene that the script came to, while the shutter is open.
    ///
    /// # Errors
    /// As for [`render`](super::render()); and what is wrong with the script at another moment.
    pub fn render(
        &self,
        scene: &Arc<Scene>,
        order: &Order,
        job: &Job<'_>,
        cancel: &Arc<AtomicBool>,
    ) -> Result<Picture, Box<Diagnostic>> {
        self.develop(scene, order, job, (None, cancel))
    }

    /// The same picture, with rough tiles before it; see [`refine`](super::refine()).
    ///
    /// # Errors
    /// As for [`Session::render`].
    pub fn refine(
        &self,
        scene: &Arc<Scene>,
        order: &Order,
        job: &Job<'_>,
        (steering, cancel): (&Steering, &Arc<AtomicBool>),
    ) -> Result<Picture, Box<Diagnostic>> {
        self.develop(scene, order, job, (Some(steering), cancel))
    }

    fn develop(
        &self,
        scene: &Arc<Scene>,
        order: &Order,
        job: &Job<'_>,
        (steering, cancel): (Option<&Steering>, &Arc<AtomicBool>),
    ) -> Result<Picture, Box<Diagnostic>> {
        let moments = self.moments(scene, order.samples.unwrap_or(scene.film.samples), cancel)?;
        let moments: Vec<&Scene> = moments.iter().map(Arc::as_ref).collect();
        stage::render_moments(&moments, order, job, steering)
    }

    /// The scene at the moments that make a picture of so many samples: one where the shutter is open for no time.
    fn moments(
        &self,
        scene: &Arc<Scene>,
        samples: u32,
        cancel: &Arc<AtomicBool>,
    ) -> Result<Vec<Arc<Scene>>, Box<Diagnostic>> {
        let count = samples.clamp(1, MOST);
        let middles = (0..count).map(|i| (f64::from(i) + 0.5) / f64::from(count));
        let times: Vec<f64> = match scene.film.shutter {
            Shutter::Still => return Ok(vec![scene.clone()]),
            Shutter::Open(open) => middles.map(|u| open * u).collect(),
            Shutter::Spline { order, spacing } => match render::Shutter::spline(order) {
                Ok(spline) => middles.map(|u| spacing * spline.place(u)).collect(),
                Err(_) => return Ok(vec![scene.clone()]),
            },
        };
        let at = |offset: f64| {
            let loaded = self.compile(self.time + offset, cancel);
            let is_error = |d: &Diagnostic| d.severity == Severity::Error;
            let error =
                || loaded.diagnostics.into_iter().find(is_error).map_or_else(stage::stopped, Box::new);
            loaded.scene.ok_or_else(error)
        };
        times.into_iter().map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Field;
    use crate::render::{Fine, Rough};
    use crate::world::Memory;

    fn moments(film: &str, samples: u32) -> Vec<f64> {
        let text = format!("scene(#{{ surface: sphere(1.0 + time), film: film(#{{ {film} }}) }})");
        let world = Arc::new(Memory([("a.rhai".into(), text)].into()));
        let mut session = Session::new("a.rhai", world);
        session.set(Default::default(), 3.0);
        let scene = session.load(&Arc::default()).scene.clone().unwrap();
        let moments = session.moments(&scene, samples, &Arc::default()).unwrap();
        let radius =
            |scene: &Arc<Scene>| -Field::new(&scene.graph, scene.surface.field).value([0.0; 3].into());
        moments.iter().map(|scene| radius(scene) - 4.0).collect()
    }

    #[test]
    fn an_open_shutter_sees_what_follows() {
        let seen = moments("shutter: 0.4", 4);
        for (seen, wanted) in seen.iter().zip([0.05, 0.15, 0.25, 0.35]) {
            assert!((seen - wanted).abs() < 1e-12, "{seen} {wanted}");
        }
        assert_eq!(moments("shutter: 0.4", 1000).len(), MOST as usize);
        assert_eq!(moments("samples: 4", 4), [0.0]);
    }

    #[test]
    fn behind_everything_is_the_mean_of_what_was_there() {
        let text = "scene(#{ surface: sphere(0.5), sky: sky(#{ background: vec3(time, 0.5, 1.0 - time) }),
            film: film(#{ shutter: 0.4, width: 16, height: 12 }) })";
        let world = Arc::new(Memory([("a.rhai".into(), text.into())].into()));
        let mut session = Session::new("a.rhai", world);
        session.set(Default::default(), 0.2);
        let cancel = Arc::default();
        let scene = session.load(&cancel).scene.clone().unwrap();
        let order = Order { samples: Some(4), ..Order::default() };
        let told = |background: [f32; 3]| assert_eq!(background, [0.4, 0.5, 0.6]);
        let (tile, rough) = (|fine: &Fine<'_>| told(fine.background), |rough: &Rough| told(rough.background));
        let job = Job { tile: &tile, rough: Some(&rough), ..Job::unwatched(&cancel) };
        let picture = session.refine(&scene, &order, &job, (&Steering::default(), &cancel)).unwrap();
        told(picture.background);
    }

    #[test]
    fn a_spline_sees_what_was_and_what_will_be() {
        let seen = moments("shutter: 0.1, shutter_order: 4", 16);
        let mean = seen.iter().sum::<f64>() / 16.0;
        let variance = seen.iter().map(|t| t * t).sum::<f64>() / 16.0;
        // That of the cubic B-spline is a third.
        assert!(mean.abs() < 1e-12 && (variance / 0.01 - 1.0 / 3.0).abs() < 0.03, "{mean} {variance}");
    }
}
