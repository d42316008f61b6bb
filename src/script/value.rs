//! The values that scripts compute with, and their passage through the script engine.
//!
//! Natively there are only two shapes, a [`Scalar`] and a vector of three. In scripts each has a
//! type by what it holds: `Field` and `VectorField` for expressions, `Interval` and `Region` for
//! enclosures, `Affine` and `AffineVec3` for affine forms, `float` and `Vec3` for plain numbers.

use super::fault::{Fault, Outcome};
use super::host::Host;
use super::library::{GridValue, MeshValue};
use super::noises::Source;
use crate::expr::NodeId;
use crate::num::{Affine, Interval};
use rhai::{Array, Dynamic, FLOAT, INT};

/// A scalar expression, with the colour of the solid that it describes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// The expression.
    pub node: NodeId,
    /// Linear red, green and blue.
    pub color: Option<[NodeId; 3]>,
}

/// Three expressions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VectorField(pub [NodeId; 3]);

/// Three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3(pub [f64; 3]);

/// Three intervals: a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region(pub [Interval; 3]);

/// Three affine forms.
#[derive(Clone, Debug, PartialEq)]
pub struct AffineVec3(pub [Affine; 3]);

/// One number of some kind.
#[derive(Clone, Debug)]
pub enum Scalar {
    /// A plain number.
    Number(f64),
    /// An enclosure.
    Interval(Interval),
    /// An affine form.
    Affine(Affine),
    /// An expression.
    Field(NodeId),
}

/// What an operation takes and gives.
#[derive(Clone, Debug)]
pub enum Value {
    /// A number of some kind, with a colour if it has one.
    Scalar(Scalar, Option<[NodeId; 3]>),
    /// Three of them.
    Vector([Scalar; 3]),
}

impl Scalar {
    /// The number that a script value is; noises, grids and meshes become expressions.
    fn of(host: &Host, v: &Dynamic) -> Outcome<Option<(Scalar, Option<[NodeId; 3]>)>> {
        Ok(Some(if let Some(number) = number(v) {
            (Scalar::Number(number), None)
        } else if let Some(f) = v.read_lock::<Field>() {
            (Scalar::Field(f.node), f.color)
        } else if let Some(source) = v.read_lock::<Source>() {
            (Scalar::Field(source.lower(host)?), None)
        } else if let Some(grid) = v.read_lock::<GridValue>() {
            (Scalar::Field(grid.lower(host)?), None)
        } else if let Some(mesh) = v.read_lock::<MeshValue>() {
            (Scalar::Field(mesh.lower(host)?), None)
        } else if let Some(i) = v.read_lock::<Interval>() {
            (Scalar::Interval(*i), None)
        } else if let Some(a) = v.read_lock::<Affine>() {
            (Scalar::Affine(a.clone()), None)
        } else {
            return Ok(None);
        }))
    }

    /// As a node.
    pub fn node(&self, host: &Host) -> Outcome<NodeId> {
        match self {
            Scalar::Number(c) => host.constant(*c),
            Scalar::Field(node) => Ok(*node),
            Scalar::Interval(_) | Scalar::Affine(_) => {
                Err(Fault::new("an interval cannot be part of an expression")
                    .hint("to enclose an expression over a box, write f.range(box)"))
            }
        }
    }

    /// How far it is from a plain number: kinds mix by moving up.
    pub fn rank(&self) -> u8 {
        match self {
            Scalar::Number(_) => 0,
            Scalar::Interval(_) => 1,
            Scalar::Affine(_) => 2,
            Scalar::Field(_) => 3,
        }
    }

    /// As an interval, unless it is an expression.
    pub fn interval(&self) -> Option<Interval> {
        match self {
            Scalar::Number(c) => Some(Interval::point(*c)),
            Scalar::Interval(i) => Some(*i),
            Scalar::Affine(a) => Some(a.range),
            Scalar::Field(_) => None,
        }
    }

    /// As an affine form, unless it is an expression.
    pub fn affine(&self) -> Option<Affine> {
        match self {
            Scalar::Number(c) => Some(<Affine as crate::num::Number>::constant(*c)),
            Scalar::Interval(i) => Some(Affine::over(*i)),
            Scalar::Affine(a) => Some(a.clone()),
            Scalar::Field(_) => None,
        }
    }

    /// As a plain number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Scalar::Number(c) => Some(*c),
            _ => None,
        }
    }
}

/// The number in an integer or a float.
pub fn number(v: &Dynamic) -> Option<f64> {
    v.as_float().ok().or_else(|| v.as_int().ok().map(|i| i as f64))
}

impl Value {
    /// The value that a script value is, if arithmetic knows it. An array of three numbers is a
    /// vector.
    pub fn of(host: &Host, v: &Dynamic) -> Outcome<Option<Value>> {
        if let Some((scalar, color)) = Scalar::of(host, v)? {
            return Ok(Some(Value::Scalar(scalar, color)));
        }
        Ok(Some(Value::Vector(if let Some(v) = v.read_lock::<Vec3>() {
            v.0.map(Scalar::Number)
        } else if let Some(v) = v.read_lock::<VectorField>() {
            v.0.map(Scalar::Field)
        } else if let Some(v) = v.read_lock::<Region>() {
            v.0.map(Scalar::Interval)
        } else if let Some(v) = v.read_lock::<AffineVec3>() {
            v.0.clone().map(Scalar::Affine)
        } else if let Some(v) = v.read_lock::<Array>() {
            let mut parts = Vec::new();
            for part in v.iter().take(4) {
                match Scalar::of(host, part)? {
                    Some((scalar, _)) => parts.push(scalar),
                    None => return Ok(None),
                }
            }
            match <[Scalar; 3]>::try_from(parts) {
                Ok(parts) => parts,
                Err(_) => return Ok(None),
            }
        } else {
            return Ok(None);
        })))
    }

    /// As a script value.
    pub fn into_dynamic(self, host: &Host) -> Outcome<Dynamic> {
        Ok(match self {
            Value::Scalar(Scalar::Number(c), _) => Dynamic::from_float(c),
            Value::Scalar(Scalar::Interval(i), _) => Dynamic::from(i),
            Value::Scalar(Scalar::Affine(a), _) => Dynamic::from(a),
            Value::Scalar(Scalar::Field(node), color) => Dynamic::from(Field { node, color }),
            Value::Vector(parts) => vector(host, &parts)?,
        })
    }
}

fn vector(host: &Host, parts: &[Scalar; 3]) -> Outcome<Dynamic> {
    let [a, b, c] = parts;
    let rank = parts.iter().map(Scalar::rank).max().unwrap_or(0);
    let numbers = (a.number(), b.number(), c.number());
    let intervals = (a.interval(), b.interval(), c.interval());
    Ok(match (rank, numbers, intervals) {
        (0, (Some(a), Some(b), Some(c)), _) => Dynamic::from(Vec3([a, b, c])),
        (1, _, (Some(a), Some(b), Some(c))) => Dynamic::from(Region([a, b, c])),
        (2, ..) => match (a.affine(), b.affine(), c.affine()) {
            (Some(a), Some(b), Some(c)) => Dynamic::from(AffineVec3([a, b, c])),
            _ => return Err(Fault::new("a vector cannot mix these kinds of number")),
        },
        _ => Dynamic::from(VectorField([a.node(host)?, b.node(host)?, c.node(host)?])),
    })
}

/// The name of a value's type, as scripts and messages have it.
pub fn type_name(v: &Dynamic) -> &'static str {
    macro_rules! names {
        ($($ty:ty => $name:literal),* $(,)?) => {
            $(if v.is::<$ty>() { return $name; })*
        };
    }
    names! {
        INT => "integer", FLOAT => "float", bool => "boolean", char => "character", () => "nothing",
        rhai::ImmutableString => "string", Array => "array", rhai::Map => "object map",
        rhai::FnPtr => "function", std::ops::Range<INT> => "range", std::ops::RangeInclusive<INT> => "range",
        Field => "Field", GridValue => "Grid", MeshValue => "Mesh", VectorField => "VectorField", Source => "Noise", Vec3 => "Vec3", Region => "Region",
        AffineVec3 => "AffineVec3", Interval => "Interval", Affine => "Affine",
        crate::scene::Camera => "Camera", crate::scene::Sun => "Sun", crate::scene::Sky => "Sky",
        crate::scene::Lamp => "Lamp", crate::scene::Material => "Material",
        super::library::MoonValue => "Moon",
        super::library::SeaValue => "Sea", crate::scene::Film => "Film", crate::scene::Air => "Air", super::library::SceneValue => "Scene",
        super::library::Corrected => "corrected solid",
        Fault => "error",
    }
    "value"
}
