//! Light that bounces: gathered at a few places, it is what following every sample comes to.

use orogen::render::{Job, Part, Picture, Pixel, Rect};
use orogen::script::{Request, compile};
use orogen::session::{self, Order, Session};
use orogen::world::Memory;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Ridges on a ball, as of figure 3.17, in the light of a sun and of a bright sky.
fn ridges(film: &str) -> String {
    format!(
        "import \"std/fractal\" as fractal; \
         let ridges = fractal::ridged(gradient(7), #{{ octaves: 5, lacunarity: 2.0, hurst: 0.9, rotate: true }}); \
         scene(#{{ surface: (sphere(1.0) - 0.09 * ridges.scaled(2.0).on_sphere()).colored(\"#b0a090\"), \
         camera: orbit(#{{ distance: 6.0, azimuth: 20.0, elevation: 15.0, fov: 25.0 }}), \
         sun: sun(#{{ azimuth: 70.0, elevation: 30.0, strength: 3.4 }}), \
         sky: sky(#{{ zenith: vec3(0.5, 0.6, 0.8), nadir: vec3(0.3) }}), \
         film: film(#{{ width: 64, height: 64, bounces: 1, {film} }}) }})"
    )
}

fn shoot(script: &str, order: &Order) -> Picture {
    let compiled = compile(&Request::text(script));
    let scene = compiled.scene.unwrap_or_else(|| panic!("{script}: {:?}", compiled.diagnostics));
    session::render(&scene, order, &Job::unwatched(&AtomicBool::new(false))).expect("a picture")
}

fn light(pixel: &Pixel) -> [[f32; 3]; 3] {
    [pixel.direct, pixel.indirect, pixel.sky]
}

/// Mean indirect light of blocks of pixels that show nothing but the solid.
fn blocks(picture: &Picture, side: u32) -> Vec<f64> {
    let mut means = Vec::new();
    for block in 0..(picture.width / side) * (picture.height / side) {
        let (x, y) = (block % (picture.width / side) * side, block / (picture.width / side) * side);
        let pixels: Vec<_> = (0..side * side).map(|i| picture.pixel(x + i % side, y + i / side)).collect();
        if pixels.iter().all(|pixel| pixel.alpha == 1.0) {
            means.push(pixels.iter().map(|p| f64::from(p.indirect[1])).sum::<f64>() / pixels.len() as f64);
        }
    }
    means
}

#[test]
fn gathered_light_is_what_all_samples_come_to() {
    let shoot = |film: &str| shoot(&ridges(&format!("samples: 128, {film}")), &Order::default());
    let followed = shoot("");
    let exact = blocks(&followed, 4);
    assert!(exact.len() > 60);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    for (spacing, most) in [(1, [0.005, 0.02, 0.08]), (4, [0.02, 0.04, 0.15])] {
        let gathered = shoot(&format!("irradiance: {spacing}"));
        assert!(gathered.stats.bounced.rays < followed.stats.bounced.rays);
        for (a, b) in followed.pixels.iter().zip(&gathered.pixels) {
            assert_eq!((a.direct, a.sky, a.albedo, a.alpha), (b.direct, b.sky, b.albedo, b.alpha));
        }
        let found = blocks(&gathered, 4);
        let off: Vec<f64> = exact.iter().zip(&found).map(|(a, b)| (a - b).abs() / a).collect();
        let errors =
            [(mean(&found) / mean(&exact) - 1.0).abs(), mean(&off), off.iter().copied().fold(0.0, f64::max)];
        println!("every {spacing} pixels: in all, by block, at most {errors:.4?}");
        assert!(errors.iter().zip(most).all(|(error, most)| *error < most), "{errors:?}");
    }
}

#[test]
fn gathered_light_does_not_depend_on_the_part_of_the_picture() {
    let script = ridges("samples: 2, irradiance: 4");
    let whole = shoot(&script, &Order::default());
    let window = Rect { x: 21, y: 18, width: 17, height: 23 };
    let part = shoot(&script, &Order { part: Part::Region(window), ..Order::default() });
    for y in 0..window.height {
        for x in 0..window.width {
            assert_eq!(
                light(part.pixel(window.x + x, window.y + y)),
                light(whole.pixel(window.x + x, window.y + y)),
                "{x} {y}"
            );
        }
    }
}

/// What moves is as bright as when every sample follows its light, though each moment gathers little.
#[test]
fn moments_gather_light_together() {
    let turning = |film: &str| {
        let script = ridges(film).replace("azimuth: 20.0", "azimuth: 20.0 + 8.0 * time");
        let world = Memory([("a.rhai".into(), script)].into());
        let mut session = Session::new("a.rhai", Arc::new(world));
        let cancel = Arc::default();
        let scene = session.load(&cancel).scene.clone().expect("a scene");
        let picture = session.render(&scene, &Order::default(), &Job::unwatched(&cancel), &cancel);
        blocks(&picture.expect("a picture"), 8)
    };
    let film = "samples: 32, shutter: 1.0";
    let (exact, found) = (turning(film), turning(&format!("{film}, irradiance: 2")));
    assert!(exact.len() > 12);
    let [exact, found] = [exact, found].map(|all| all.iter().sum::<f64>());
    assert!((found / exact - 1.0).abs() < 0.02, "{found} instead of {exact}");
}

#[test]
fn what_is_not_matt_follows_its_light_by_itself() {
    let polished = |film: &str| {
        let script = ridges(film).replace("camera:", "material: material::metal(0.3), camera:");
        let script = format!("import \"std/material\" as material; {script}");
        let picture = shoot(&script, &Order::default());
        (picture.stats.bounced.rays, picture.pixels.iter().map(light).collect::<Vec<_>>())
    };
    assert_eq!(polished("samples: 2"), polished("samples: 2, irradiance: 4"));
}
