//! Why there is no picture.

use super::PartError;
use crate::diag::{Diagnostic, Place};
use crate::expr::TooLarge;
use crate::scene::Film;

/// Why a picture cannot be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// A side is zero or beyond [`Film::MAX_SIDE`].
    #[error("a picture of {width} x {height} pixels; sides go from 1 to {}", Film::MAX_SIDE)]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
    },
    /// The pixels take more memory than allowed, or than there is.
    #[error("a picture of {width} x {height} pixels takes {:.1} GB of memory; {:.1} are allowed", gigabytes(*needed), gigabytes(*limit))]
    Memory {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Bytes that its pixels take.
        needed: u64,
        /// Bytes that they may take.
        limit: u64,
    },
    /// The part of the picture that is wanted is none.
    #[error(transparent)]
    Part(#[from] PartError),
    /// No samples, or more than [`Film::MAX_SAMPLES`].
    #[error("{0} samples per pixel; 1 to {max} are possible", max = Film::MAX_SAMPLES)]
    Samples(u32),
    /// A setting is not a number that makes sense.
    #[error("{name} is {value}; it must be {range}")]
    Setting {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// The camera sees nothing because of how it stands.
    #[error("{0}")]
    Camera(CameraError),
    /// The bounds hold no space.
    #[error("the bounds are empty or not finite")]
    Bounds,
    /// The field has no value anywhere.
    #[error("the field is undefined (NaN or infinite) at every point that was tried")]
    Undefined {
        /// Where the field was written.
        place: Option<Place>,
    },
    /// It was cancelled before there was anything of it.
    #[error("stopped before it was finished")]
    Stopped,
    /// Limiting detail to the pixels made the expression too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

/// What is wrong with a camera.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// No direction of view.
    #[error("the camera stands at its target, so it looks nowhere")]
    EyeIsTarget,
    /// Not a place.
    #[error("the camera's eye, target or up is not finite")]
    NotFinite,
    /// Not an angle of view.
    #[error("the camera's field of view is {0} degrees; it must lie between 0 and 180")]
    Fov(f64),
    /// Not a height of what is seen.
    #[error("the camera shows a height of {0}; it must be positive")]
    Height(f64),
    /// Not a lens.
    #[error("the camera's lens has a radius of {radius} and is focused at {focus}: no lens can be like that")]
    Lens {
        /// Its radius.
        radius: f64,
        /// Distance of the plane of focus.
        focus: f64,
    },
}

fn gigabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e9
}

impl RenderError {
    /// The error as a message for the script's author, with what to do about it.
    pub fn diagnostic(&self) -> Diagnostic {
        let message = Diagnostic::error(self.to_string());
        match self {
            RenderError::Size { .. } => {
                message.hint("set width and height in the film, or on the command line")
            }
            RenderError::Memory { .. } => {
                message.hint("render a smaller picture, or parts of it: --tile 1/N, and then orogen merge")
            }
            RenderError::Part(error) => message.hint(error.hint()),
            RenderError::Samples(_) => message.hint("4 samples are a good preview, 16 to 64 a final picture"),
            RenderError::Setting { name, .. } => message.hint(format!("change {name}")),
            RenderError::Camera(CameraError::Fov(_)) => message.hint("35 degrees suit most scenes"),
            RenderError::Camera(CameraError::Height(_)) => {
                message.hint("give the height of what the picture shows, in units of length")
            }
            RenderError::Camera(CameraError::Lens { .. }) => {
                message.hint("the radius is zero or more, the distance of what is sharp more than zero")
            }
            RenderError::Camera(CameraError::NotFinite | CameraError::EyeIsTarget) => {
                message.hint("move the camera's eye or its target")
            }
            RenderError::Bounds => message.hint("give bounds whose max exceeds their min on every axis"),
            RenderError::Undefined { place } => message
                .at(place.clone())
                .hint("look for a division by zero, or a square root or logarithm of a negative number"),
            RenderError::Stopped => message.hint("no file was written"),
            RenderError::TooLarge(_) => {
                message.hint("use fewer nodes, or fractals with octaves instead of loops")
            }
        }
    }
}
