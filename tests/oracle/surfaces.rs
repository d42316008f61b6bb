//! Surfaces on which casters have reason to fail, and from where to look at them.

use super::common::{self, Build};
use super::rays::unit;
use super::truth::Spacing;
use glam::DVec3;
use orogen::cast::Tolerance;
use orogen::expr::NodeId;
use orogen::noise::{Fractal, Gradient, Hurst, Kind, Model, Noise, Recipe, Settings};
use orogen::op::{self, Op};
use orogen::scene::Aabb;
use rand::{RngExt, rngs::StdRng};
use std::sync::Arc;

/// An eye and what it looks at.
pub type Aim = Box<dyn Fn(&mut StdRng) -> [DVec3; 2] + Sync>;

/// A surface with the rays that suit it.
pub struct Surface {
    pub name: &'static str,
    pub build: fn(&mut Build) -> NodeId,
    /// Where rays go.
    pub region: Aabb,
    pub tolerance: Tolerance,
    pub aim: Aim,
    pub spacing: Spacing,
    /// Whether the field has no finite value in places.
    pub undefined: bool,
    /// Whether some casters take very long.
    pub costly: bool,
}

fn surface(name: &'static str, build: fn(&mut Build) -> NodeId) -> Surface {
    Surface {
        name,
        build,
        region: Aabb::cube(1.6),
        tolerance: Tolerance::fixed(1e-4),
        aim: Box::new(all_around),
        spacing: Spacing { samples: 2048, beginning: 0.0 },
        undefined: false,
        costly: false,
    }
}

fn aimed(name: &'static str, build: fn(&mut Build) -> NodeId, aim: fn(&mut StdRng) -> [DVec3; 2]) -> Surface {
    Surface { aim: Box::new(aim), ..surface(name, build) }
}

pub fn all() -> Vec<Surface> {
    vec![
        surface("three octaves", common::three_octaves),
        surface("thin shell", common::thin_shell),
        surface("thin rings", common::thin_rings),
        surface("carved balls", common::balls),
        surface("ridges that are roots", common::square_root_ridges),
        surface("slopes of a noise", common::slopes_of_wavelets),
        aimed("hills", common::hills, along_the_ground),
        aimed("slabs thinner than the tolerance", thin_slabs, across_slabs),
        aimed("nested shells", nested_shells, past_the_edge),
        aimed("tangent balls", tangent_balls, at_the_tangency),
        aimed("lens thinner than the tolerance", thin_lens, across_slabs),
        aimed("box", |b| cuboid(b, [0.0; 3], [0.7; 3]), along_faces),
        aimed("torus", |b| b.torus(0.9, 0.2), edge_on),
        surface("cones that touch", double_cone),
        surface("cellular creases", cellular_creases),
        surface("turbulence", turbulence),
        surface("gyroid", gyroid),
        surface("root of the third order", cubed_ball),
        surface("root of the second order", squared_ball),
        surface("steep", |b| {
            let f = common::three_octaves(b);
            b.scaled(1e7, f)
        }),
        Surface {
            spacing: Spacing { samples: 256, beginning: 0.0 },
            costly: true,
            ..surface("a thousand parts", thousand_parts)
        },
        Surface { undefined: true, costly: true, ..surface("half of it undefined", half_undefined) },
        on_planet("planet from the ground", ground, near_the_horizon),
        on_planet("planet from orbit", orbit, towards_the_limb),
    ]
}

/// From all around; half of the eyes look past the edge of a ball of radius near 1.
fn all_around(rng: &mut StdRng) -> [DVec3; 2] {
    let eye = 4.0 * unit(rng);
    if rng.random() { past_the_edge_from(eye, rng) } else { [eye, rng.random_range(0.0..1.2) * unit(rng)] }
}

fn past_the_edge(rng: &mut StdRng) -> [DVec3; 2] {
    let eye = 4.0 * unit(rng);
    past_the_edge_from(eye, rng)
}

fn past_the_edge_from(eye: DVec3, rng: &mut StdRng) -> [DVec3; 2] {
    let side = eye.cross(unit(rng)).normalize_or(DVec3::X);
    // Lines of sight touch a ball on the near side of its widest circle.
    let touching = (side + 0.25 * eye.normalize()).normalize();
    [eye, touching * (1.0 + 0.05 * rng.random_range(-1.0..1.0))]
}

fn along_the_ground(rng: &mut StdRng) -> [DVec3; 2] {
    let u = unit(rng);
    [DVec3::new(4.0 * u.x, 0.03 + 0.02 * u.y, 4.0 * u.z), 0.02 * unit(rng)]
}

/// Steeply or nearly within the plane.
fn across_slabs(rng: &mut StdRng) -> [DVec3; 2] {
    let target = 0.8 * unit(rng);
    let slope = libm::exp10(rng.random_range(-5.0..0.5));
    [target + 3.0 * (unit(rng) * DVec3::new(1.0, slope, 1.0)).normalize_or(DVec3::X), target]
}

fn at_the_tangency(rng: &mut StdRng) -> [DVec3; 2] {
    let off = libm::exp10(rng.random_range(-7.0..-1.0));
    let touching = [DVec3::ZERO, DVec3::new(0.5, -0.5, 0.0)][rng.random_range(0..2)];
    [4.0 * unit(rng), touching + off * unit(rng)]
}

/// In the plane of a face or a hair beside it, or at an edge.
fn along_faces(rng: &mut StdRng) -> [DVec3; 2] {
    let off = [0.0, 1e-12, -1e-12, 1e-7, -1e-5, 1e-4][rng.random_range(0..6)];
    let [u, v] = [unit(rng), unit(rng)];
    if rng.random() {
        let level = 0.7 + off;
        [DVec3::new(3.0 * u.x, level, 3.0 * u.z), DVec3::new(0.7 * v.x, level, 0.7 * v.z)]
    } else {
        [4.0 * u, DVec3::new(0.7, 0.7 + off, 0.7 * v.z)]
    }
}

fn edge_on(rng: &mut StdRng) -> [DVec3; 2] {
    let height = libm::exp10(rng.random_range(-8.0..-0.3));
    let u = unit(rng);
    [
        DVec3::new(3.0 * u.x, height, 3.0 * u.z),
        DVec3::new(u.z, [height, 0.0, 0.2][rng.random_range(0..3)], -u.x),
    ]
}

/// Sheets of a hundred-thousandth, a tenth of the tolerance, in a ball.
fn thin_slabs(b: &mut Build) -> NodeId {
    let [_, y, _] = b.p();
    let mut f = None;
    for k in -4..=4 {
        let sheet = b.shifted(y, 0.21 * f64::from(k));
        let sheet = b.op(Op::Abs(op::Abs), &[sheet]);
        let sheet = b.shifted(sheet, -5e-6);
        f = Some(f.map_or(sheet, |f| b.min(f, sheet)));
    }
    let ball = b.sphere([0.0; 3], 1.0);
    b.max(f.expect("some sheets"), ball)
}

fn nested_shells(b: &mut Build) -> NodeId {
    let radius = b.sphere([0.0; 3], 0.0);
    let mut f = b.shifted(radius, -0.1);
    for k in 0..12 {
        let shell = b.shifted(radius, -1.05 + 0.07 * f64::from(k));
        let shell = b.op(Op::Abs(op::Abs), &[shell]);
        let shell = b.shifted(shell, -6e-4);
        f = b.min(f, shell);
    }
    // A bite, to see them all.
    let bite = b.sphere([0.6, 0.6, -0.6], 0.7);
    let bite = b.neg(bite);
    b.max(f, bite)
}

/// Two balls that touch each other at the origin, on a floor that one of them touches.
fn tangent_balls(b: &mut Build) -> NodeId {
    let [_, y, _] = b.p();
    let floor = b.shifted(y, 0.5);
    let left = b.sphere([-0.5, 0.0, 0.0], 0.5);
    let right = b.sphere([0.5, 0.0, 0.0], 0.5);
    let balls = b.min(left, right);
    b.min(balls, floor)
}

/// A lens 0.4 wide and 0.000_04 thick, in a ring.
fn thin_lens(b: &mut Build) -> NodeId {
    let above = b.sphere([0.0, -4000.0, 0.0], 4_000.000_02);
    let below = b.sphere([0.0, 4000.0, 0.0], 4_000.000_02);
    let lens = b.max(above, below);
    let ring = b.torus(1.0, 0.01);
    b.min(lens, ring)
}

fn cuboid(b: &mut Build, centre: [f64; 3], half: [f64; 3]) -> NodeId {
    let p = b.p();
    let mut f = None;
    for axis in 0..3 {
        let d = b.shifted(p[axis], -centre[axis]);
        let d = b.op(Op::Abs(op::Abs), &[d]);
        let d = b.shifted(d, -half[axis]);
        f = Some(f.map_or(d, |f| b.max(f, d)));
    }
    f.expect("three axes")
}

fn double_cone(b: &mut Build) -> NodeId {
    let [x, y, z] = b.p();
    let zero = b.num(0.0);
    let radius = b.op(Op::Length(op::Length), &[x, zero, z]);
    let height = b.op(Op::Abs(op::Abs), &[y]);
    let width = b.scaled(0.4, height);
    let cone = b.sub(radius, width);
    let ball = b.sphere([0.0; 3], 1.1);
    b.max(cone, ball)
}

/// A ball less the noise of a kind, with its standard settings.
fn rough_ball(b: &mut Build, kind: &str, frequency: f64, relief: f64) -> NodeId {
    let kind = Kind::ALL.iter().find(|k| k.name == kind).expect("a noise of that name");
    let noise = Noise::new((kind.build)(&Settings::new(kind.parameters)), 3).at_frequency(frequency);
    let ball = b.sphere([0.0; 3], 1.0);
    let p = b.p();
    let noise = b.0.noise(noise, p).expect("a small graph");
    let noise = b.scaled(relief, noise);
    b.add(ball, noise)
}

fn cellular_creases(b: &mut Build) -> NodeId {
    rough_ball(b, "cellular", 5.0, 0.2)
}

fn octaves(b: &mut Build, recipe: Recipe, p: [NodeId; 3], footprint: NodeId) -> NodeId {
    let fractal = Arc::new(Fractal::new(recipe).expect("a valid recipe"));
    b.0.fractal(fractal, p, footprint).expect("a small graph")
}

fn turbulence(b: &mut Build) -> NodeId {
    let noise = Noise::new(Kind::Gradient(Gradient::EDGES), 8).at_frequency(3.0);
    let recipe = Recipe { octaves: 5, ..Recipe::new(noise, Model::TURBULENCE) };
    let (p, zero) = (b.p(), b.num(0.0));
    let creases = octaves(b, recipe, p, zero);
    let creases = b.scaled(0.25, creases);
    let ball = b.sphere([0.0; 3], 0.9);
    b.add(ball, creases)
}

/// A thin gyroid in a ball.
fn gyroid(b: &mut Build) -> NodeId {
    let p = b.p().map(|x| b.scaled(9.0, x));
    let sines = p.map(|x| b.op(Op::Sin(op::Sin), &[x]));
    let cosines = p.map(|x| b.op(Op::Cos(op::Cos), &[x]));
    let [s, t, u] = [0, 1, 2].map(|i| b.op(Op::Mul(op::Mul), &[sines[i], cosines[(i + 1) % 3]]));
    let sum = b.add(s, t);
    let sum = b.add(sum, u);
    let sheet = b.op(Op::Abs(op::Abs), &[sum]);
    let sheet = b.shifted(sheet, -0.02);
    let ball = b.sphere([0.0; 3], 1.0);
    b.max(sheet, ball)
}

fn cubed_ball(b: &mut Build) -> NodeId {
    let ball = common::balls(b);
    b.op(Op::Powi(op::Powi { n: 3 }), &[ball])
}

/// No solid at all: the field touches zero on a sphere and is positive on both sides.
fn squared_ball(b: &mut Build) -> NodeId {
    let ball = b.sphere([0.0; 3], 1.0);
    b.op(Op::Square(op::Square), &[ball])
}

/// Balls and boxes, added and carved out in turns.
fn thousand_parts(b: &mut Build) -> NodeId {
    let mut f = b.sphere([0.0; 3], 0.5);
    for k in 0..1000u32 {
        let at = |axis: u32| 0.22 * (f64::from(k / 10u32.pow(axis) % 10) - 4.5);
        let centre = [at(0), at(1) + 0.03 * at(0), at(2) - 0.05 * at(1)];
        let part = if k % 2 == 0 { b.sphere(centre, 0.13) } else { cuboid(b, centre, [0.1, 0.08, 0.12]) };
        f = if k % 3 == 2 {
            let part = b.neg(part);
            b.max(f, part)
        } else {
            b.min(f, part)
        };
    }
    f
}

/// A ball over a field that is a root, and has no value below the ground.
fn half_undefined(b: &mut Build) -> NodeId {
    let [_, y, _] = b.p();
    let root = b.op(Op::Sqrt(op::Sqrt), &[y]);
    let root = b.scaled(0.3, root);
    let ball = b.sphere([0.0; 3], 1.0);
    b.add(ball, root)
}

/// Radius of the Earth in metres.
const EARTH: f64 = 6_371_000.0;

/// Side of a pixel one unit away.
const PIXEL: f64 = 0.002;

/// A planet of radius 1 with 26 octaves, from half of its radius down to two centimetres.
fn planet(b: &mut Build, footprint: NodeId) -> NodeId {
    let p = b.p();
    let radius = b.op(Op::Length(op::Length), &p);
    let on_sphere = p.map(|x| b.op(Op::Div(op::Div), &[x, radius]));
    let noise = Noise::new(Kind::Gradient(Gradient::EDGES), 7).at_frequency(2.2);
    let recipe = Recipe {
        octaves: 26,
        lacunarity: 2.1,
        hurst: Hurst::uniform(0.75),
        rotate: true,
        ..Recipe::new(noise, Model::FBM)
    };
    let relief = octaves(b, recipe, on_sphere, footprint);
    let relief = b.scaled(2500.0 / EARTH, relief);
    let ball = b.shifted(radius, -1.0);
    b.sub(ball, relief)
}

/// Two metres above the ground.
fn standing() -> DVec3 {
    let up = DVec3::new(0.3, 0.8, 0.5).normalize();
    let mut b = Build::default();
    let zero = b.num(0.0);
    let bare = planet(&mut b, zero);
    (1.0 + 2.0 / EARTH - b.field(bare).value(up)) * up
}

const ORBIT: DVec3 = DVec3::new(2.0, 1.0, 3.0);

fn seen_from(b: &mut Build, eye: DVec3) -> NodeId {
    let p = b.p();
    let offset: [NodeId; 3] = std::array::from_fn(|axis| b.shifted(p[axis], -eye[axis]));
    let distance = b.op(Op::Length(op::Length), &offset);
    let footprint = b.scaled(PIXEL, distance);
    planet(b, footprint)
}

fn ground(b: &mut Build) -> NodeId {
    seen_from(b, standing())
}

fn orbit(b: &mut Build) -> NodeId {
    seen_from(b, ORBIT)
}

/// From the horizon, over it and down to the feet.
fn near_the_horizon(rng: &mut StdRng, eye: DVec3) -> [DVec3; 2] {
    let up = eye.normalize();
    let ahead = up.cross(unit(rng)).normalize_or(DVec3::X);
    let slope = libm::exp10(rng.random_range(-4.0..0.5));
    [eye, eye + ahead + if rng.random_bool(0.2) { slope } else { -slope } * up]
}

fn towards_the_limb(rng: &mut StdRng, eye: DVec3) -> [DVec3; 2] {
    let centre = -eye.normalize();
    let aside = eye.cross(unit(rng)).normalize_or(DVec3::X);
    let limb = 1.0 / eye.length();
    let limb = limb / (1.0 - limb * limb).sqrt();
    let off = [1.0 + 1e-3 * rng.random_range(-1.0..1.0), rng.random_range(0.0..1.0)][rng.random_range(0..2)];
    [eye, eye + centre + off * limb * aside]
}

/// With tolerances as pictures have them.
fn on_planet(
    name: &'static str,
    build: fn(&mut Build) -> NodeId,
    aim: fn(&mut StdRng, DVec3) -> [DVec3; 2],
) -> Surface {
    let from_the_ground = name.contains("ground");
    let eye = if from_the_ground { standing() } else { ORBIT };
    Surface {
        region: Aabb::cube(1.002),
        tolerance: Tolerance { least: 1e-13 * eye.abs().max_element().max(1.0), growth: 0.002 * PIXEL },
        aim: Box::new(move |rng| aim(rng, eye)),
        spacing: Spacing { samples: 1536, beginning: if from_the_ground { 1e-8 } else { 0.0 } },
        costly: from_the_ground,
        ..surface(name, build)
    }
}
