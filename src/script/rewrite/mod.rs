//! Texts that go back into scripts: new defaults of parameters, and cameras.

mod camera;
mod defaults;

pub use camera::camera;
pub use defaults::write_default;
