//! Shapes that are made of data: fields like any other, of which only the making differs.

mod convolution;
mod curve;
mod outline;
mod tetrahedra;

use super::{Call, Library};
use crate::expr::NodeId;
use crate::script::fault::{Fault, Outcome};
use crate::script::value::{Field, number};
use crate::shape::{Body, Shape};
use glam::DVec3;
use rhai::{Array, Dynamic};
use std::sync::Arc;

pub(super) fn register(lib: &mut Library<'_>) {
    curve::register(lib);
    outline::register(lib);
    convolution::register(lib);
    tetrahedra::register(lib);
}

/// The field of a body at the point.
fn field(c: &Call<'_>, body: impl Body + 'static) -> Outcome<Dynamic> {
    let p = c.host.point()?;
    field_at(c, body, p)
}

/// The field of a body that does not depend on z.
fn flat_field(c: &Call<'_>, body: impl Body + 'static) -> Outcome<Dynamic> {
    let [x, y, _] = c.host.point()?;
    let zero = c.host.graph.borrow_mut().constant(0.0)?;
    field_at(c, body, [x, y, zero])
}

fn field_at(c: &Call<'_>, body: impl Body + 'static, p: [NodeId; 3]) -> Outcome<Dynamic> {
    let node = c.host.graph.borrow_mut().shape(Arc::new(Shape::new(body)), p)?;
    Ok(Dynamic::from(Field { node, color: None }))
}

/// The entries of an array.
fn list(v: &Dynamic) -> Option<Array> {
    v.read_lock::<Array>().map(|a| a.clone())
}

/// Points, `wanted` being what to say if they are none.
fn points(c: &Call<'_>, list: &[Dynamic], wrong: impl Fn(usize) -> Fault) -> Outcome<Vec<DVec3>> {
    let point = |(i, v)| c.vec3_of(v)?.ok_or_else(|| wrong(i));
    list.iter().enumerate().map(point).collect()
}

/// Numbers, all of them.
fn numbers(list: &[Dynamic]) -> Option<Vec<f64>> {
    list.iter().map(number).collect()
}
