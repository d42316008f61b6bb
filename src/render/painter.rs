//! Colours that are no functions of space, such as which component of the solid a point belongs to.

use glam::DVec3;
use std::sync::atomic::AtomicBool;

/// Paints what rays have met.
pub trait Painter: std::fmt::Debug + Send + Sync {
    /// Changes the colours of points on the surface: shares of light that are reflected, by channel.
    /// Of no interest once the job is cancelled.
    fn paint(&mut self, points: &[DVec3], colors: &mut [DVec3], cancel: &AtomicBool);

    /// The same painter with memory of its own, for another thread.
    fn clone_box(&self) -> Box<dyn Painter>;
}

impl Clone for Box<dyn Painter> {
    fn clone(&self) -> Self {
        self.clone_box()
    }
}
