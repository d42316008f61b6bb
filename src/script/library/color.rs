//! Colours: linear red, green and blue, from numbers, fields or texts.

use super::{Call, Library};
use crate::diag::Diagnostic;
use crate::expr::NodeId;
use crate::num::srgb;
use crate::script::apply::component;
use crate::script::fault::{Fault, Outcome};
use crate::script::value::{Field, Scalar, Value, VectorField};
use glam::DVec3;
use rhai::Dynamic;

/// Colour of a solid that has none.
pub const GREY: f64 = 0.5;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.def(
        "rgb(red, green, blue)",
        "A colour from its linear parts, 0 to 1: numbers or fields.",
        "rgb(1.0, 0.5, 0.0)",
        |c| {
            let part = |i: usize| match c.value(i)? {
                Value::Scalar(s, _) => Ok(s),
                Value::Vector(_) => Err(c.wrong(i, "a number or a field")),
            };
            Value::Vector([part(0)?, part(1)?, part(2)?]).into_dynamic(c.host)
        },
    );
    lib.def(
        "rgb(text)",
        "A colour as on the web, \"#rrggbb\" or \"#rgb\", made linear.",
        "rgb(\"#ff8800\")",
        |c| {
            let color = hex(&c.text(0)?)?;
            Value::Vector(color.to_array().map(Scalar::Number)).into_dynamic(c.host)
        },
    );
    let sentence = "The solid with a colour: a vector of numbers or fields, one number or field for grey, or a text such as \"#ff8800\". Where solids are combined sharply, one without a colour takes the other's.";
    for name in ["colored", "coloured"] {
        lib.def(&format!("{name}(f, color)"), sentence, "sphere(1.0).colored(\"#c08040\")", |c| {
            let f = c.field(0)?;
            let color = c.color_nodes(1)?;
            doubt_bytes(c, color);
            Ok(Dynamic::from(Field { node: f.node, color: Some(color) }))
        });
    }
    lib.def(
        "color_of(f)",
        "The colour of a solid as a vector of fields; grey if it has none.",
        "color_of(sphere(1.0))",
        |c| {
            let grey = || Ok::<_, Fault>([c.host.constant(GREY)?; 3]);
            Ok(Dynamic::from(VectorField(c.field(0)?.color.map_or_else(grey, Ok)?)))
        },
    );
    lib.def("is_colored(f)", "Whether a solid has a colour of its own.", "is_colored(sphere(1.0))", |c| {
        Ok(c.field(0)?.color.is_some().into())
    });
}

/// Doubts a colour whose parts look like bytes.
fn doubt_bytes(c: &Call<'_>, color: [NodeId; 3]) {
    /// More than any part of a colour that reflects light, or stands for something else.
    const MUCH: f64 = 16.0;
    let parts = color.map(|part| c.host.graph.borrow().as_const(part));
    let is_byte = |part: &f64| (0.0..=255.0).contains(part) && part.fract() == 0.0;
    let [Some(r), Some(g), Some(b)] = parts else { return };
    if [r, g, b].iter().all(is_byte) && r.max(g).max(b) > MUCH {
        let message = format!("the colour ({r}, {g}, {b}) sends back far more light than there is");
        let hint = format!(
            "parts go from 0 to 1; as on the web it is \"{}\"",
            srgb::to_hex([r, g, b].map(|part| part as u8))
        );
        c.host.doubt(Diagnostic::warning(message).at(c.place.clone()).hint(hint));
    }
}

impl Call<'_> {
    /// Argument `i` as a colour that may vary from point to point.
    pub fn color_nodes(&self, i: usize) -> Outcome<[NodeId; 3]> {
        let wanted = "a colour such as \"#ff8800\", rgb(1.0, 0.5, 0.0) or a field";
        self.varying_color(&self.args[i])?.ok_or_else(|| self.wrong(i, wanted))
    }

    /// The colour that a value is; it may vary from point to point.
    pub fn varying_color(&self, v: &Dynamic) -> Outcome<Option<[NodeId; 3]>> {
        if let Ok(text) = v.clone().into_string() {
            let c = hex(&text)?;
            return Ok(Some([self.host.constant(c.x)?, self.host.constant(c.y)?, self.host.constant(c.z)?]));
        }
        let Ok(Some(v)) = Value::of(self.host, v) else { return Ok(None) };
        let part = |axis| component(&v, axis).node(self.host);
        Ok(Some([part(0)?, part(1)?, part(2)?]))
    }

    /// The colour that a value is, if it is the same at every point.
    pub fn constant_color(&self, v: &Dynamic) -> Outcome<Option<DVec3>> {
        if let Ok(text) = v.clone().into_string() {
            return hex(&text).map(Some);
        }
        if let Some(grey) = crate::script::value::number(v) {
            return Ok(Some(DVec3::splat(grey)));
        }
        self.vec3_of(v)
    }
}

/// "#rrggbb" or "#rgb" in sRGB, made linear.
fn hex(text: &str) -> Outcome<DVec3> {
    let wrong = || {
        Fault::new(format!("{text:?} is not a colour"))
            .hint("write \"#rrggbb\" with hexadecimal digits, such as \"#ff8800\"")
    };
    let bytes = srgb::from_hex(text).ok_or_else(wrong)?;
    Ok(DVec3::from_array(bytes.map(|b| srgb::decode(f64::from(b) / 255.0))))
}
