//! Flow mapping: solids that a velocity field has carried along (Gamito 2009, chapter 9).
//!
//! A velocity `u` carries a point `x` for a unit of time, `y' = u(y)` with `y(0) = x`, to `d(x) = y(1)`. A field `f`
//! evaluated there, `F(x) = f(d(x))`, describes the solid that was carried the other way. As `d` is continuous,
//! and so is its inverse, the solid keeps its topology however strong the flow: no piece comes loose, no handle
//! closes, no surface meets itself.
//!
//! **The map** is not the solution of the differential equation but so many steps of the classical method of Runge
//! and Kutta, which come as close to it as is wanted ([`steps`]). That makes it a formula like any other:
//!
//! ```text
//! k1 = u(y)    k2 = u(y + h/2 k1)    k3 = u(y + h/2 k2)    k4 = u(y + h k3)
//! y  <-  y + h/6 (k1 + 2 k2 + 2 k3 + k4)
//! ```
//!
//! It is evaluated by putting whatever kind of number through it ([`advect`]), so that its derivatives
//! are exact, the second ones too. For enclosures over balls, where that would lose all correlation, `tube` follows
//! the ball around a trajectory instead, and bounds what it becomes. The bounds are those of the map as it is
//! computed, steps and roundings included, not of a solution that nobody knows.
//!
//! A [`Flowed`] field is a [`Kernel`](crate::num::Kernel): it enters expressions as a noise does, and whoever casts, meshes or
//! bounds expressions needs to know nothing of flows.

mod code;
mod cubes;
mod kernel;
mod matrix;
mod pack;
mod sight;
mod stage;
mod step;
pub mod steps;
mod tube;

pub use code::Code;
pub use kernel::Flowed;
pub use stage::Parts;
pub use step::advect;
pub use steps::Precision;
