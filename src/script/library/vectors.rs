//! Vectors and boxes.

use super::Library;
use crate::num::Interval;
use crate::script::apply::component;
use crate::script::fault::Fault;
use crate::script::value::{AffineVec3, Region, Scalar, Value, Vec3, VectorField, number};
use rhai::Dynamic;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Vec3>("Vec3");
    lib.name_type::<VectorField>("VectorField");
    lib.name_type::<Region>("Region");
    lib.name_type::<AffineVec3>("AffineVec3");
    lib.def(
        "vec3(x, y, z)",
        "A vector of numbers, fields, intervals or affine forms.",
        "vec3(0, 1, 0)",
        |c| {
            let part = |i: usize| match c.value(i)? {
                Value::Scalar(s, _) => Ok(s),
                Value::Vector(_) => Err(c.wrong(i, "a number or a field")),
            };
            Value::Vector([part(0)?, part(1)?, part(2)?]).into_dynamic(c.host)
        },
    );
    lib.def("vec3(a)", "A vector with three equal components.", "vec3(1.0)", |c| {
        let v = c.value(0)?;
        Value::Vector([component(&v, 0), component(&v, 1), component(&v, 2)]).into_dynamic(c.host)
    });
    lib.def(
        "region(min, max)",
        "The box between two corners, for f.range and f.lipschitz.",
        "region([-1, -1, -1], [1, 1, 1])",
        |c| {
            let (min, max) = (c.vec3(0)?, c.vec3(1)?);
            if !(min.cmple(max)).all() {
                return Err(Fault::new("the box is empty: a corner of `min` lies above `max`"));
            }
            Ok(Dynamic::from(Region(std::array::from_fn(|i| Interval::new(min[i], max[i])))))
        },
    );
    lib.def("region(half)", "The cube from -half to half on every axis.", "region(1.0)", |c| {
        let half = c.number(0)?;
        if half < 0.0 {
            return Err(c.wrong(0, "a number that is not negative"));
        }
        Ok(Dynamic::from(Region([Interval::radius(half); 3])))
    });
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        lib.property::<Vec3>(name, move |_, v| Ok(v.0[axis].into()));
        lib.property::<Region>(name, move |_, v| Ok(Dynamic::from(v.0[axis])));
        lib.property::<AffineVec3>(name, move |_, v| Ok(Dynamic::from(v.0[axis].clone())));
        lib.property::<VectorField>(name, move |host, v| {
            Value::Scalar(Scalar::Field(v.0[axis]), None).into_dynamic(host)
        });
    }
    lib.property::<Region>("min", |_, r| Ok(Dynamic::from(Vec3(r.0.map(|i| i.lo)))));
    lib.property::<Region>("max", |_, r| Ok(Dynamic::from(Vec3(r.0.map(|i| i.hi)))));
    lib.def("is_number(a)", "Whether a value is a plain number.", "is_number(1.5)", |c| {
        Ok(number(&c.args[0]).is_some().into())
    });
    lib.def(
        "is_field(a)",
        "Whether a value is an expression or a noise, which becomes one.",
        "is_field(x)",
        |c| Ok(matches!(Value::of(c.host, &c.args[0])?, Some(Value::Scalar(Scalar::Field(_), _))).into()),
    );
    lib.def(
        "is_vector(a)",
        "Whether a value is a vector of any kind, or an array of three numbers or fields.",
        "is_vector(p)",
        |c| Ok(matches!(Value::of(c.host, &c.args[0])?, Some(Value::Vector(_))).into()),
    );
}
