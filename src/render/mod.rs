//! Rendering: from a scene and a caster to a picture, and from a picture to a file.
//!
//! ```text
//! Scene + Settings --prepare--> Prepared --render (with a caster)--> Picture --save--> PNG, EXR
//! ```
//!
//! [`prepare`] checks what can be checked before any time is spent: sizes, the camera, whether the
//! field has values at all. It also ties the detail of fractals to the size of a pixel, and so
//! *fixes the field that the picture shows*: casters are made for [`Prepared::field`], not for the
//! field of the scene. [`render()`] then works through square tiles in parallel, each in stages that
//! handle many rays at once:
//!
//! ```text
//! rays through the pixels -> first hits -> normals, colours -> rays to the sun -> light, air -> pixels
//! ```
//!
//! [`refine()`] does the same for somebody who watches: rough tiles come first, and the picture is the same in the end.
//!
//! Where a picture depends on something like chance, that is a hash of the pixel and the sample.
//! Together with tiles that never see one another this makes pictures equal bit for bit, whatever
//! the number of threads.

mod about;
mod air;
mod denoise;
mod disc;
mod error;
mod filter;
mod gather;
mod heatmap;
mod irradiance;
mod job;
mod layer;
mod light;
pub mod material;
mod merge;
mod next_event;
mod openexr;
mod overlay;
mod painter;
mod path;
mod picture;
mod png;
mod prepare;
mod probe;
mod rays;
mod recent;
mod refine;
mod reflect;
mod sample;
mod save;
mod saved;
mod settings;
mod stars;
mod stats;
mod surface;
mod tile;
mod tone;
mod view;
mod water;
mod window;
mod worker;

#[cfg(test)]
mod tests;

pub use about::About;
pub use air::{Atmosphere, Seen};
pub use denoise::denoise;
pub use error::{CameraError, RenderError};
pub use filter::{Filter, OrderError, Shutter};
pub use heatmap::Heatmap;
pub use job::{Fine, Job, Progress, render, render_moments};
pub use layer::{Layer, Look};
pub use merge::{MergeError, merge};
pub use overlay::Overlay;
pub use painter::Painter;
pub use picture::{Picture, Pixel};
pub use prepare::{Prepared, prepare, shown};
pub use probe::Probe;
pub use refine::{Rough, Snapshots, Steering, refine};
pub use reflect::Reflecting;
pub use save::{Format, Metadata, Precision, SOFTWARE, SaveError, can_save, png_bytes, save, save_as};
pub use saved::{OpenError, Saved};
pub use settings::Settings;
pub use stats::{Octaves, Seconds, Stats};
pub use tile::{places, tiles};
pub use tone::tone_map;
pub use view::View;
pub use window::{Part, PartError, Rect};
pub use worker::Shot;
