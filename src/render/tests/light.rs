//! Light whose right amount is known in closed form, or by another way of summing it up.

use super::*;
use crate::scene::{Finish, Lamp, Light, Material, Matt, Moon, Sea, Shutter};
use std::f64::consts::PI;

/// A scene with a camera that looks straight down on what is around the origin.
fn from_above(build: Build, field: NodeId) -> Scene {
    let mut scene = build.scene(field);
    scene.camera.eye = DVec3::new(0.0, 4.0, 0.001);
    scene.sun.irradiance = DVec3::ZERO;
    scene.sky = Sky { zenith: DVec3::ZERO, nadir: DVec3::ZERO, ..scene.sky };
    scene
}

/// The top of it at height 0.
fn floor(build: &mut Build) -> NodeId {
    build.cuboid(DVec3::new(0.0, -0.5, 0.0), DVec3::new(1.45, 0.5, 1.45))
}

fn white(scene: &mut Scene) {
    let mut graph = Graph::clone(&scene.graph);
    scene.surface.color = Some([graph.constant(1.0).unwrap(); 3]);
    scene.graph = Arc::new(graph);
}

/// Mean light of the pixels that show nothing but the solid.
fn mean(picture: &Picture) -> f64 {
    let seen: Vec<f64> =
        picture.pixels.iter().filter(|p| p.alpha == 1.0).map(|p| f64::from(p.color[1])).collect();
    seen.iter().sum::<f64>() / seen.len() as f64
}

/// A white ball on a white floor, below a white sky: light goes to and fro between them, and all of it gets out.
fn white_world() -> Scene {
    let mut build = Build::default();
    let (floor, ball) = (floor(&mut build), build.sphere(DVec3::new(0.3, 0.3, 0.0), 0.35));
    let field = build.op(Op::Min(op::Min), &[floor, ball]);
    let mut scene = from_above(build, field);
    white(&mut scene);
    scene.sky = Sky { zenith: DVec3::ONE, nadir: DVec3::ONE, ..scene.sky };
    scene.film = Film { bounces: 60, samples: 4, width: 16, height: 16, ..scene.film };
    scene
}

#[test]
fn a_white_solid_in_a_white_world_is_white() {
    let picture = shoot(&white_world());
    for pixel in picture.pixels.iter().filter(|p| p.alpha == 1.0) {
        assert!(pixel.color.iter().all(|c| (c - 1.0).abs() < 1e-5), "{pixel:?}");
        assert!(pixel.direct == [0.0; 3] && pixel.sky == [0.0; 3] && pixel.albedo == [1.0; 3]);
    }
    assert!(picture.stats.bounced.rays > 0);
}

#[test]
fn it_is_as_white_where_light_is_gathered() {
    let mut scene = white_world();
    scene.film.irradiance_spacing = 3;
    let picture = shoot(&scene);
    for pixel in picture.pixels.iter().filter(|p| p.alpha == 1.0) {
        assert!(pixel.color.iter().all(|c| (c - 1.0).abs() < 1e-5), "{pixel:?}");
    }
    scene.film.irradiance_spacing = 0;
    assert_ne!(picture.stats.bounced.rays, shoot(&scene).stats.bounced.rays, "it was gathered");
}

#[test]
fn following_light_and_its_closed_form_agree() {
    let mut scene = ball();
    scene.sky = Sky { zenith: DVec3::new(0.2, 0.9, 1.0), nadir: DVec3::new(0.1, 0.1, 0.0), ..scene.sky };
    scene.film = Film { samples: 64, width: 24, height: 20, ..scene.film };
    let closed = mean(&shoot(&scene));
    scene.film.bounces = 1;
    let followed = mean(&shoot(&scene));
    assert!((followed / closed - 1.0).abs() < 0.005, "{followed} {closed}");
}

#[test]
fn a_lamp_fades_with_the_square_of_its_distance() {
    for (height, radius) in [(1.0, 0.0), (2.0, 0.0), (2.0, 0.8)] {
        let mut build = Build::default();
        let field = floor(&mut build);
        let mut scene = from_above(build, field);
        scene.bounds = Some(Aabb::cube(5.0));
        scene.camera = scene.camera.with_fov(0.2);
        let position = DVec3::new(0.0, height, 0.0);
        let lamp = Lamp { position, radius, intensity: DVec3::splat(PI), shadows: true };
        scene.lights = vec![Light::Lamp(lamp)];
        // A point leaves nothing to chance.
        scene.film.samples = if radius > 0.0 { 256 } else { 16 };
        let seen = mean(&shoot(&scene));
        // A ball lights what faces it as its middle would.
        let expected = 0.6 / (height * height);
        assert!((seen / expected - 1.0).abs() < 0.003, "{height} {radius}: {seen} {expected}");
    }
}

#[test]
fn a_wide_sun_throws_a_soft_shadow_of_the_right_width() {
    let mut build = Build::default();
    let floor = floor(&mut build);
    let roof = build.cuboid(DVec3::new(-0.75, 0.5, 0.0), DVec3::new(0.75, 0.01, 1.45));
    let field = build.op(Op::Min(op::Min), &[floor, roof]);
    let mut scene = from_above(build, field);
    // From the side, to see below the roof, and so near that a pixel is narrow beside the shadow's edge.
    scene.camera.eye = DVec3::new(3.0, 2.0, 0.001);
    scene.camera.target = DVec3::ZERO;
    scene.camera = scene.camera.with_fov(8.0);
    scene.sun = Sun { direction: DVec3::Y, irradiance: DVec3::splat(PI), size: 20.0, shadows: true };
    scene.film = Film { width: 96, height: 96, samples: 64, ..scene.film };
    let picture = shoot(&scene);
    // The edge of the roof is 0.49 above the floor, over x = 0: half the sun is seen from there, and all of it from
    // where it is 10 degrees off.
    let seen = |x: f64| f64::from(pixel_of(&picture, &scene, DVec3::new(x, 0.0, 0.0)).color[1]) / 0.6;
    let reach = 0.49 * 10f64.to_radians().tan();
    assert!((seen(0.0) - 0.5).abs() < 0.06, "{}", seen(0.0));
    assert!(seen(1.3 * reach) > 0.95 && seen(-1.3 * reach) < 0.03);
    assert!((0.6..0.95).contains(&seen(0.5 * reach)) && (0.05..0.4).contains(&seen(-0.5 * reach)));
}

#[test]
fn walls_stand_in_the_way_of_the_sky() {
    let mut build = Build::default();
    let floor = floor(&mut build);
    let wall = build.cuboid(DVec3::new(-1.0, 0.5, 0.0), DVec3::new(0.2, 0.9, 1.45));
    let field = build.op(Op::Min(op::Min), &[floor, wall]);
    let mut scene = from_above(build, field);
    scene.sky = Sky { zenith: DVec3::ONE, nadir: DVec3::ONE, ..scene.sky };
    scene.film = Film { samples: 64, occlusion: 5.0, ..scene.film };
    let picture = shoot(&scene);
    let seen = |x: f64| f64::from(pixel_of(&picture, &scene, DVec3::new(x, 0.0, 0.0)).color[1]) / 0.6;
    // At its foot, a wall covers nearly half of the sky; farther off less.
    assert!((seen(-0.72) - 0.55).abs() < 0.06, "{}", seen(-0.72));
    assert!(seen(1.2) > 0.93 && seen(0.0) > seen(-0.5));
    scene.film.occlusion = 0.0;
    let open = shoot(&scene);
    assert!((pixel_of(&open, &scene, DVec3::new(-0.72, 0.0, 0.0)).color[1] - 0.6).abs() < 1e-6);
}

#[test]
fn what_shines_is_seen_and_lights_what_is_near() {
    let mut build = Build::default();
    let (floor, ball) = (floor(&mut build), build.sphere(DVec3::new(0.0, 0.4, 0.0), 0.3));
    let field = build.op(Op::Min(op::Min), &[floor, ball]);
    // Only the ball, above 0.05, gives off light.
    let y = build.0.point().unwrap()[1];
    let (least, high) = (build.number(0.05), build.number(1000.0));
    let above = build.op(Op::Sub(op::Sub), &[y, least]);
    let steep = build.op(Op::Mul(op::Mul), &[above, high]);
    let (zero, one) = (build.number(0.0), build.number(1.0));
    let steep = build.op(Op::Max(op::Max), &[steep, zero]);
    let glow = build.op(Op::Min(op::Min), &[steep, one]);
    let material = Material {
        matt: Matt::Lambert,
        finish: [zero; Finish::COUNT],
        ior: 1.5,
        emission: Some([glow; 3]),
        bump: None,
    };
    let mut scene = from_above(build, field);
    scene.surface.material = Some(material);
    scene.film = Film { samples: 256, bounces: 1, width: 48, height: 40, ..scene.film };
    let picture = shoot(&scene);
    let middle = pixel_of(&picture, &scene, DVec3::new(0.0, 0.7, 0.0));
    assert!((middle.direct[1] - 1.0).abs() < 1e-5 && middle.color[1] >= middle.direct[1]);
    // A ball lights the floor beside it as a point in its middle would: L pi r^2 cos / d^2 / pi, times the albedo.
    let (far, radius, height) = (0.9f64, 0.3f64, 0.4f64);
    let d2 = far * far + height * height;
    let expected = 0.6 * radius * radius * height / (d2 * d2.sqrt());
    // Places at the same distance from it, so that chance evens out.
    let around = (0..12).map(|i| {
        let (sine, cosine) = (f64::from(i) * PI / 6.0).sin_cos();
        f64::from(pixel_of(&picture, &scene, far * DVec3::new(cosine, 0.0, sine)).indirect[1])
    });
    let light = around.sum::<f64>() / 12.0;
    assert!((light / expected - 1.0).abs() < 0.1, "{light} {expected}");
}

#[test]
fn pixels_with_little_noise_take_few_samples() {
    let mut scene = ball();
    scene.film = Film { samples: 128, noise: 0.02, ..scene.film };
    let picture = shoot(&scene);
    let samples = |x: u32, y: u32| picture.pixel(x, y).samples;
    assert_eq!((samples(0, 0), samples(24, 20)), (8.0, 8.0));
    // At the edge of the ball it takes more of them to find out how much of a pixel is covered.
    let most = picture.pixels.iter().map(|p| p.samples).fold(0.0, f32::max);
    assert!(most > 8.0 && most <= 128.0, "{most}");
    let all: f64 = picture.pixels.iter().map(|p| f64::from(p.samples)).sum();
    assert_eq!(all, picture.stats.samples as f64);
    // The picture is what all samples make, but for the noise that is allowed.
    scene.film.noise = 0.0;
    let full = shoot(&scene);
    let apart = picture.pixels.iter().zip(&full.pixels).map(|(a, b)| (a.color[1] - b.color[1]).abs());
    assert!(apart.fold(0.0, f32::max) < 0.12);
}

#[test]
fn a_wide_filter_blurs_and_keeps_the_light() {
    let sharp = |order: u32| {
        let mut scene = ball();
        scene.film.filter.order = order;
        scene.film.samples = 64;
        let picture = shoot(&scene);
        let alphas: Vec<f64> = picture.pixels.iter().map(|p| f64::from(p.alpha)).collect();
        let between = alphas.iter().filter(|a| (0.02..0.98).contains(*a)).count();
        (alphas.iter().sum::<f64>(), between)
    };
    let (one, four) = (sharp(1), sharp(4));
    assert!((one.0 / four.0 - 1.0).abs() < 0.005 && four.1 > 2 * one.1, "{one:?} {four:?}");
}

/// What a ball that moves to the right looks like while the shutter is open.
#[test]
fn what_moves_is_a_mean_of_its_moments() {
    let places = [-0.4, -0.2, 0.0, 0.2, 0.4];
    let scenes: Vec<Scene> = places
        .iter()
        .map(|x| {
            let mut build = Build::default();
            let field = build.sphere(DVec3::new(*x, 0.0, 0.0), 0.5);
            let mut scene = build.scene(field);
            scene.film = Film { samples: 50, shutter: Shutter::Open(1.0), ..scene.film };
            scene
        })
        .collect();
    let prepared: Vec<Prepared> = scenes.iter().map(prepared).collect();
    let casters: Vec<March> = prepared.iter().map(|p| March::new(&p.tape)).collect();
    let shots: Vec<Shot<'_>> = prepared.iter().zip(&casters).map(|(p, c)| Shot::of(p, c)).collect();
    let cancel = AtomicBool::new(false);
    let picture = render_moments(&shots, &Job::unwatched(&cancel)).unwrap();
    // The balls are one over the other: the middle is always covered, the ends a fifth of the time.
    for (x, wanted) in [(0.0, 1.0), (0.85, 0.2), (-0.85, 0.2), (0.6, 0.4)] {
        let alpha = pixel_of(&picture, &scenes[0], DVec3::new(x, 0.0, 0.0)).alpha;
        assert!((alpha - wanted).abs() < 0.05, "{x}: {alpha}");
    }
}

/// The light of the middle of a picture from a height, of water that takes light away by these shares, above a floor half
/// a unit below, under a white sky.
fn through_water(height: f64, absorption: DVec3, bounces: u32) -> Pixel {
    let mut build = Build::default();
    let field = build.cuboid(DVec3::new(0.0, -1.0, 0.0), DVec3::new(1.45, 0.5, 1.45));
    let y = build.0.point().unwrap()[1];
    let (zero, rough) = (build.number(0.0), build.number(0.1));
    let mut finish = [zero; Finish::COUNT];
    finish[Finish::Roughness as usize] = rough;
    let material = Material { matt: Matt::Lambert, finish, ior: 1.333, emission: None, bump: None };
    let sea = Sea { field: y, material, absorption, color: DVec3::ZERO };
    let mut scene = from_above(build, field);
    scene.sky = Sky { zenith: DVec3::ONE, nadir: DVec3::ONE, ..scene.sky };
    scene.film.bounces = bounces;
    scene.camera.eye.y = height;
    scene.camera.target.y = height - 1.0;
    scene.camera = scene.camera.with_fov(2.0);
    let ground = prepared(&scene);
    let surface = prepared(&sea.scene(&scene));
    let with_sea = Prepared { sea: Some(sea), ..ground.clone() };
    let (caster, waves) = (March::new(&ground.tape), March::new(&surface.tape));
    let below = Shot::of(&surface, &waves);
    let shot = Shot { sea: Some(&below), ..Shot::of(&with_sea, &caster) };
    let cancel = AtomicBool::new(false);
    let picture = render_moments(&[shot], &Job::unwatched(&cancel)).unwrap();
    *picture.pixel(24, 20)
}

#[test]
fn water_mirrors_the_sky_and_dims_the_ground() {
    let absorption = DVec3::new(2.0, 0.5, 0.0);
    // Two per cent of the sky, and the ground, dimmed on the way down and up; the same if paths find the sky.
    let fresnel = (0.333f64 / 2.333).powi(2);
    for bounces in [0, 1, 3] {
        let seen = through_water(4.0, absorption, bounces);
        let diver = through_water(-0.1, absorption, bounces);
        for (channel, a) in absorption.to_array().into_iter().enumerate() {
            let expected = fresnel + (1.0 - fresnel) * 0.6 * (-2.0 * 0.5 * a).exp();
            let light = f64::from(seen.color[channel]);
            assert!((light - expected).abs() < 2e-3, "{bounces}, {channel}: {light} {expected}");
            let expected = 0.6 * (-(0.5 + 0.4) * a).exp();
            let light = f64::from(diver.color[channel]);
            assert!((light - expected).abs() < 2e-3, "{bounces}, {channel}: {light} {expected}");
        }
        assert!((seen.depth - 4.0).abs() < 0.01 && (diver.depth - 0.4).abs() < 0.01);
    }
}

#[test]
fn a_moon_stands_behind_everything() {
    let mut build = Build::default();
    let field = build.sphere(DVec3::new(0.5, 0.0, 0.0), 0.5);
    let own = build.sphere(DVec3::ZERO, 1.0);
    let mut scene = build.scene(field);
    scene.sun.direction = DVec3::Z;
    let surface = Surface { field: own, color: None, material: None, keep: None };
    // Half hidden by the ball, as large as that seems.
    let moon = Moon { surface, bounds: Aabb::cube(1.1), position: DVec3::new(0.0, 0.0, -36.0), radius: 4.0 };
    let (near, far) = (prepared(&scene), prepared(&moon.scene(&scene)));
    let (caster, far_caster) = (March::new(&near.tape), March::new(&far.tape));
    let behind = Shot::of(&far, &far_caster);
    let shot = Shot { moon: Some(&behind), ..Shot::of(&near, &caster) };
    let cancel = AtomicBool::new(false);
    let picture = render_moments(&[shot], &Job::unwatched(&cancel)).unwrap();
    let left = pixel_of(&picture, &scene, DVec3::new(-0.2, 0.0, 0.0));
    assert!(left.alpha == 1.0 && left.depth.is_infinite() && left.sky[0] > 0.3, "{left:?}");
    let right = pixel_of(&picture, &scene, DVec3::new(0.3, 0.0, 0.4));
    assert!(right.depth < 4.0 && right.direct[0] > 0.3);
    assert_eq!(pixel_of(&picture, &scene, DVec3::new(-1.0, 0.0, 0.0)).alpha, 0.0);
}
