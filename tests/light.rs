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

/// Where nothing hides any of a sky, what bounces brings is what it gives straight, whatever the material.
#[test]
fn skylight_needs_no_bounces_on_a_lone_ball() {
    for material in [
        "matt: \"dust\"",
        "matt: \"rough\", grain: 1.0",
        "metal: 1.0, roughness: 1.0",
        "metal: 1.0, roughness: 0.4",
        "coat: 1.0, roughness: 0.3",
    ] {
        let mean = |bounces: u32| {
            let script = format!(
                "scene(#{{ surface: sphere(1.0).colored(vec3(0.8, 0.3, 0.05)), material: material(#{{ {material} }}), \
                 sun: sun(#{{ strength: 0.0 }}), sky: sky(#{{ zenith: 1.0, nadir: 1.0 }}), \
                 film: film(#{{ width: 24, height: 18, samples: 64, bounces: {bounces} }}) }})"
            );
            let picture = shoot(&script, &Order::default());
            let seen: Vec<&Pixel> = picture.pixels.iter().filter(|p| p.alpha == 1.0).collect();
            [0, 1, 2].map(|c| seen.iter().map(|p| f64::from(p.color[c])).sum::<f64>() / seen.len() as f64)
        };
        let (straight, followed) = (mean(0), mean(1));
        for (a, b) in straight.into_iter().zip(followed) {
            assert!((a / b - 1.0).abs() < 0.02, "{material}: {straight:?} {followed:?}");
        }
    }
}

/// A smooth mirror shows a wide lamp as an even disc.
#[test]
fn mirrors_show_wide_lamps_without_specks() {
    let script = "scene(#{ surface: sphere(1.0), material: material(#{ metal: 1.0, roughness: 0.1 }), \
        sun: sun(#{ strength: 0.0 }), lights: [lamp(#{ position: [0, 0, 4], radius: 1.0 })], \
        camera: look_at(#{ eye: [0, 0.5, 6], fov: 20.0 }), film: film(#{ width: 48, height: 48, samples: 16 }) })";
    let picture = shoot(script, &Order::default());
    let brightest = picture.pixels.iter().map(|p| p.direct[1]).fold(0.0, f32::max);
    let lit: Vec<f32> = picture.pixels.iter().map(|p| p.direct[1]).filter(|d| *d > 0.5 * brightest).collect();
    // The radiance of the lamp is its intensity over the area of its disc, and white metal mirrors 0.8 of it.
    let radiance = 20.0 / std::f32::consts::PI;
    assert!(lit.len() > 30, "{} of {brightest}", lit.len());
    assert!(brightest < 1.05 * radiance, "{brightest} {radiance}");
    let mean = lit.iter().sum::<f32>() / lit.len() as f32;
    let spread = lit.iter().map(|d| (d - mean).abs()).sum::<f32>() / lit.len() as f32;
    assert!(spread < 0.15 * mean, "{spread} {mean}");
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

/// Mean over all pixels of what comes from everywhere, green.
fn mean(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel.color[1])).sum::<f64>() / picture.pixels.len() as f64
}

/// A level ground, seen from above on all of the picture.
fn ground(options: &str, sky: &str, film: &str) -> String {
    format!(
        "scene(#{{ surface: box([3.0, 0.1, 3.0]).colored(\"#ffffff\"), {options}, \
         camera: look_at(#{{ eye: [1.0, 3.0, 0.5], target: [0, 0, 0], fov: 20.0 }}), \
         sun: sun(#{{ strength: 0.0 }}), sky: sky(#{{ {sky} }}), \
         film: film(#{{ width: 24, height: 24, {film} }}) }})"
    )
}

#[test]
fn small_bright_dots_keep_their_light_where_samples_are_spared() {
    // Some two dots in a pixel's area, which cover a hundredth of it.
    let glow = "material: material(#{ emission: smoothstep(0.985, 0.99, cos(90.0 * x) * cos(90.0 * z)) })";
    let shoot = |film: &str| {
        let film = format!("samples: 1024, {film}");
        shoot(&ground(glow, "zenith: vec3(0.0), nadir: vec3(0.0)", &film), &Order::default())
    };
    let (full, spared) = (shoot(""), shoot("noise: 0.01"));
    assert!(spared.stats.samples < full.stats.samples);
    let (light, all) = (mean(&spared), mean(&full));
    assert!((light / all - 1.0).abs() < 0.05, "{light} {all}");
}

#[test]
fn bumps_lose_no_light_and_hide_no_sky() {
    let white = "zenith: vec3(1.0), nadir: vec3(1.0)";
    let bump = "bump: 0.3 * gradient(3).scaled(4.0)";
    // Above a level ground there is nothing but sky, whatever faces it.
    for sky in [white, "zenith: vec3(1.0), nadir: vec3(0.0)"] {
        for film in ["samples: 4", "samples: 4, bounces: 1", "samples: 4, bounces: 1, irradiance: 3"] {
            let script = ground(&format!("material: material(#{{ {bump} }})"), sky, film);
            for pixel in shoot(&script, &Order::default()).pixels {
                assert!(pixel.color.iter().all(|c| (c - 1.0).abs() < 1e-5), "{sky}, {film}: {pixel:?}");
            }
        }
    }
    for material in ["metal: 1.0, roughness: 0.6", "coat: 1.0, roughness: 0.5", "matt: \"rough\""] {
        let script = ground(
            &format!("material: material(#{{ {material}, {bump} }})"),
            white,
            "samples: 256, bounces: 1",
        );
        let light = mean(&shoot(&script, &Order::default()));
        assert!((light - 1.0).abs() < 0.01, "{material}: {light}");
    }
}

#[test]
fn few_bumps_are_dark_where_the_sun_is_behind_the_eye() {
    // So flat a view that most bumps turn a side away, with the sun behind it.
    let script = ground("material: material(#{ bump: 0.5 * gradient(3).scaled(6.0) })", "", "samples: 1")
        .replace("[1.0, 3.0, 0.5]", "[2.5, 0.4, 0.0]")
        .replace("fov: 20.0", "projection: \"orthographic\", height: 0.3")
        .replace("strength: 0.0", "azimuth: 90.0, elevation: 9.0902769, size: 0.0");
    let flat = script.replace("0.5 * gradient(3).scaled(6.0)", "0.0 * x");
    let lights = |script: &str| -> Vec<f32> {
        let picture = shoot(script, &Order::default());
        picture.pixels.iter().filter(|pixel| pixel.alpha == 1.0).map(|pixel| pixel.direct[1]).collect()
    };
    let (bumpy, flat) = (lights(&script), lights(&flat));
    let level = flat[0];
    assert!(level > 0.0 && flat.iter().all(|light| (light / level - 1.0).abs() < 1e-3), "{flat:?}");
    let dark = bumpy.iter().filter(|light| **light < 0.1 * level).count();
    assert!(bumpy.len() > 100 && 8 * dark < bumpy.len(), "{dark} of {}", bumpy.len());
    assert!(bumpy.iter().all(|light| *light > 0.0));
}

#[test]
fn bumps_mirror_the_sky_above_them_whatever_way_it_is_found() {
    let sky = "zenith: vec3(1.0), nadir: vec3(0.0)";
    for material in ["metal: 1.0, roughness: 0.0", "metal: 1.0, roughness: 0.3", "coat: 1.0, roughness: 0.5"]
    {
        for film in ["samples: 4", "samples: 256, bounces: 1", "samples: 4, occlusion: 0.1"] {
            let bumpy = format!("material: material(#{{ {material}, bump: 0.3 * gradient(3).scaled(4.0) }})");
            let script = ground(&bumpy, sky, film)
                .replace("[1.0, 3.0, 0.5]", "[2.5, 0.7, 0.5]")
                .replace("fov: 20.0", "fov: 8.0");
            let light = mean(&shoot(&script, &Order::default()));
            assert!((light - 1.0).abs() < 0.02, "{material}, {film}: {light}");
        }
    }
}

#[test]
fn a_mirror_shows_highlights_as_sharp_as_they_are() {
    let script = "let ball = length(p - vec3(0.0, 0.6, 0.0)) - 0.4; \
        let floor = y + 0.0 * x; \
        let is_floor = smoothstep(0.02, 0.0, y); \
        scene(#{ surface: min(ball, floor).colored(\"#ffffff\"), bounds: 2.0, \
        material: material(#{ metal: 1.0, roughness: 0.3 * (1.0 - is_floor) }), \
        camera: look_at(#{ eye: [0.0, 1.0, 4.0], target: [0, 0.3, 0], fov: 30.0 }), \
        sun: sun(#{ azimuth: 17.0, elevation: 21.0, strength: 3.0, size: 0.0 }), \
        sky: sky(#{ zenith: vec3(0.0), nadir: vec3(0.0) }), \
        film: film(#{ width: 64, height: 64, samples: 16, bounces: 1 }) })";
    let picture = shoot(script, &Order::default());
    let most = |of: fn(&Pixel) -> f32| picture.pixels.iter().map(of).fold(0.0, f32::max);
    let (seen, mirrored) = (most(|pixel| pixel.direct[1]), most(|pixel| pixel.indirect[1]));
    assert!(seen > 1.0 && (mirrored / seen - 1.0).abs() < 0.3, "{seen} {mirrored}");
}

#[test]
fn every_sun_makes_shafts() {
    let shoot = |suns: &str, shafts: bool| {
        let script = format!(
            "let wall = box([0.04, 0.6, 1.2]).translate([0.0, 1.0, 0.0]); \
             scene(#{{ surface: min(sphere(1.0), wall), bounds: 1.5, {suns}, \
             camera: look_at(#{{ eye: [-0.25, 1.06, 0.6], target: [-0.15, 1.05, 0.0], fov: 40.0 }}), \
             sky: sky(#{{ air: air(#{{ radius: 1.0, height: 0.05, scattering: [3, 3, 3], shafts: {shafts} }}) }}), \
             film: film(#{{ width: 24, height: 24, samples: 4 }}) }})"
        );
        shoot(&script, &Order::default())
    };
    let low = "sun(#{ azimuth: 90.0, elevation: 15.0, size: 0.0, strength: 3.0 })";
    let first = format!("sun: {low}");
    let second = format!("sun: sun(#{{ strength: 0.0 }}), lights: [{low}]");
    let skies = |suns: &str, shafts: bool| -> Vec<_> {
        shoot(suns, shafts).pixels.into_iter().map(|pixel| pixel.sky).collect()
    };
    let (shafts, clear) = (skies(&first, true), skies(&first, false));
    assert_eq!(skies(&second, true), shafts);
    let darkest = shafts.iter().zip(&clear).map(|(a, b)| a[1] / b[1]).fold(1.0, f32::min);
    assert!(darkest < 0.7, "{darkest}");
}

#[test]
fn variance_falls_at_least_as_fast_as_samples_grow() {
    // Soft shadows of a ball, and light that bounces.
    let shoot = |samples: u32| {
        let script = format!(
            "let ball = length(p - vec3(0.0, 0.5, 0.0)) - 0.3; \
             scene(#{{ surface: min(box([3.0, 0.1, 3.0]), ball), \
             camera: look_at(#{{ eye: [1.0, 3.0, 0.5], target: [0, 0, 0], fov: 25.0 }}), \
             sun: sun(#{{ azimuth: 40.0, elevation: 40.0, size: 20.0 }}), \
             film: film(#{{ width: 32, height: 32, samples: {samples}, bounces: 1, filter: 2 }}) }})"
        );
        shoot(&script, &Order::default()).pixels
    };
    let exact = shoot(2048);
    // Mean square of how far pixels are off, and what they say of it themselves.
    let variance = |samples: u32| {
        let pixels = shoot(samples);
        let luminance = |p: &Pixel| 0.2126 * p.color[0] + 0.7152 * p.color[1] + 0.0722 * p.color[2];
        let off = pixels.iter().zip(&exact).map(|(a, b)| luminance(a) - luminance(b));
        let off: f32 = off.map(|off| off * off).sum();
        let said: f32 = pixels.iter().map(|pixel| pixel.variance).sum();
        [off, said].map(|sum| sum / exact.len() as f32)
    };
    let [few, some, many] = [4, 16, 64].map(variance);
    assert!(some[0] < few[0] / 4.0 && many[0] < some[0] / 4.0, "{few:?} {some:?} {many:?}");
    // Samples that are spread evenly are better than what chance alone would make of them, which is what pixels say.
    for [off, said] in [few, some, many] {
        assert!(off < said, "{few:?} {some:?} {many:?}");
    }
    assert!((12.0..24.0).contains(&(few[1] / many[1])), "{few:?} {many:?}");
}
