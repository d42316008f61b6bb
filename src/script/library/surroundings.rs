//! What else there is beside the solid: water that it stands in, and a moon.

use super::scene::bounds;
use super::{Call, Library};
use crate::scene::{Aabb, Finish, Material, Matt, direction};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::Options;
use crate::script::value::Field;
use glam::DVec3;
use rhai::Dynamic;

/// A sea before the graph is complete.
pub type SeaValue = crate::scene::Sea;

/// A moon before the graph is complete.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoonValue {
    /// Its solid.
    pub surface: Field,
    /// How it reflects.
    pub material: Option<Material>,
    /// The box that it is in.
    pub bounds: Aabb,
    /// Where its middle is.
    pub position: DVec3,
    /// Length in the scene of a unit of its own space.
    pub radius: f64,
}

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<SeaValue>("Sea");
    lib.name_type::<MoonValue>("Moon");
    let sentence = "Clear water that the solid stands in: it reflects, and takes light away with its depth. Options:\n\n- surface: a field that is negative below the surface of the water (sphere(1.0))\n- waves: a height that is added for the sake of reflections\n- roughness: how blurred reflections are (0 to 1; 0.1)\n- ior: refractive index (1 to 4; 1.333)\n- absorption: how much light is taken away, a vector: of every 1 / absorption of length only the share 1 / e is left (that of the clearest water on a planet like the Earth)\n- color: the share of light that deep water sends back (\"#04203a\")";
    lib.def("sea(options)", sentence, "sea(#{ surface: sphere(1.0), roughness: 0.05 })", sea);
    let sentence = "A solid that is seen far away in the sky, lit by the same suns. Options:\n\n- surface: the solid, of a radius of about 1 around an origin of its own (needed)\n- material: how it reflects\n- azimuth, elevation: where it stands, as for a sun (degrees)\n- size: the angle that a ball of radius 1 measures across, as seen from the origin (degrees; 0.52)\n- distance: from the origin (60)\n- bounds: the box that it is in (1.2)";
    lib.def(
        "moon(options)",
        sentence,
        "moon(#{ surface: sphere(1.0), azimuth: 30.0, elevation: 20.0 })",
        moon,
    );
}

fn sea(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let given = o.get("surface").is_some();
    let field = if given { o.field("surface")?.node } else { unit_sphere(c)? };
    let mut finish = [c.host.constant(0.0)?; Finish::COUNT];
    finish[Finish::Roughness as usize] = o.share("roughness", 0.1)?;
    let bump = match o.get("waves") {
        Some(_) => Some(o.field("waves")?.node),
        None => None,
    };
    let ior = o.number("ior", 1.0..=4.0, 1.333)?;
    // Per metre, of the clearest natural water (Smith and Baker 1981, at 650, 550 and 450 nm), on a planet of radius 1.
    let clearest = DVec3::new(0.35, 0.065, 0.015) * 6371e3;
    let absorption = o.channels("absorption", 0.0..=1e12, clearest)?;
    let color = o.color("color", DVec3::new(0.0012, 0.0144, 0.0423))?;
    if color.max_element() > 1.0 {
        return Err(Fault::new("water sends back no more light than it gets")
            .hint("`color` of `sea` is a share, up to 1"));
    }
    o.finish()?;
    let material = Material { matt: Matt::Lambert, finish, ior, emission: None, bump };
    Ok(Dynamic::from(SeaValue { field, material, absorption, color }))
}

fn unit_sphere(c: &Call<'_>) -> Outcome<crate::expr::NodeId> {
    use crate::op::{Length, Op, Sub};
    let mut graph = c.host.graph.borrow_mut();
    let p = graph.point()?;
    let (length, one) = (graph.op(Op::Length(Length), &p)?, graph.constant(1.0)?);
    Ok(graph.op(Op::Sub(Sub), &[length, one])?)
}

fn moon(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let surface = o.field("surface")?;
    let material = o.given("material", "material(#{ ... })")?;
    let azimuth = o.number("azimuth", -3600.0..=3600.0, 60.0)?;
    let elevation = o.number("elevation", -90.0..=90.0, 30.0)?;
    let size = o.number("size", 1e-6..=90.0, 0.52)?;
    let distance = o.number("distance", 1e-9..=1e12, 60.0)?;
    let given = bounds(c, &mut o)?;
    o.finish()?;
    Ok(Dynamic::from(MoonValue {
        surface,
        material,
        bounds: given.unwrap_or(Aabb::cube(1.2)),
        position: distance * direction(azimuth, elevation),
        radius: distance * libm::sin((0.5 * size).to_radians()),
    }))
}
