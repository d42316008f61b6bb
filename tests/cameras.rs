//! Cameras from end to end: their rays meet a ball where geometry says, pictures have the size of what they
//! show, and scripts put cameras where they should be.

mod common;

use common::Build;
use glam::DVec3;
use orogen::cast::{CastStats, Hit, Kind, Ray, Tolerance, caster};
use orogen::field::first_inside;
use orogen::render::{Job, Picture, View};
use orogen::scene::{Aabb, Camera, Lens, Projection, Scene};
use orogen::script::{Request, compile};
use orogen::session::{self, Order};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

const TOLERANCE: f64 = 1e-7;

/// A camera of every projection, three units from the middle of a ball of radius 1.
fn cameras() -> [Camera; 5] {
    let lens = Some(Lens { radius: 0.3, focus: 2.5 });
    [
        Projection::default(),
        Projection::Perspective { fov: 50.0, lens },
        Projection::Orthographic { height: 3.0 },
        Projection::Panorama,
        Projection::CubeMap,
    ]
    .map(|projection| Camera::orbit(DVec3::ZERO, 3.0, 25.0, 15.0).with(projection))
}

/// A ray through every pixel, tile by tile as renderers have them, within the bounds.
fn rays(camera: &Camera, bounds: &Aabb) -> Vec<Ray> {
    let (width, height) = (48, 32);
    let view = View::new(camera, width, height).unwrap();
    let mut rng = StdRng::seed_from_u64(5);
    let mut rays = Vec::new();
    for (x, y) in (0..height / 8).flat_map(|j| (0..width / 8).map(move |i| (8 * i, 8 * j))) {
        for k in 0..64 {
            let place = [x + k % 8, y + k / 8].map(|at| f64::from(at) + 0.5);
            let (origin, direction) = view.ray(place[0], place[1], [rng.random(), rng.random()]);
            if let Some((near, far)) = bounds.clip(origin, direction).filter(|(_, far)| *far > 0.0) {
                let tolerance = Tolerance::fixed(TOLERANCE);
                rays.push(Ray { origin, direction, near: near.max(0.0), far, tolerance });
            }
        }
    }
    rays
}

/// Where a ray first meets the unit sphere, and how far from its centre the line passes.
fn closed_form(ray: &Ray) -> (f64, f64) {
    let along = -ray.origin.dot(ray.direction);
    let passes = (ray.origin + along * ray.direction).length();
    (along - (1.0 - passes * passes).max(0.0).sqrt(), passes)
}

#[test]
fn rays_of_every_camera_meet_a_ball_where_they_should() {
    let mut build = Build::default();
    let root = build.sphere([0.0; 3], 1.0);
    let bounds = Aabb::cube(1.25);
    for camera in cameras() {
        let rays = rays(&camera, &bounds);
        for kind in [Kind::Beam, Kind::Auto, Kind::Speculative, Kind::Affine] {
            let typical: Vec<Vec<Ray>> = rays.chunks(64).map(<[Ray]>::to_vec).collect();
            let mut caster = caster(kind, &build.field(root), &bounds, &typical).unwrap();
            let mut hits = vec![Hit::MISS; rays.len()];
            let mut stats = CastStats::default();
            caster.first_hits(&rays, &mut hits, &mut stats, &AtomicBool::new(false));
            let mut met = 0;
            for (ray, hit) in rays.iter().zip(&hits) {
                let (t, passes) = closed_form(ray);
                if (passes - 1.0).abs() < 1e-5 {
                    continue;
                }
                assert_eq!(hit.is_hit(), passes < 1.0, "{kind:?} {ray:?}");
                if hit.is_hit() {
                    met += 1;
                    assert!((hit.t - t).abs() < 2.0 * TOLERANCE, "{kind:?}: {} for {t}", hit.t);
                }
            }
            assert!(met > 20 && met < rays.len() && stats.uncertified == 0, "{kind:?} {camera:?}: {met}");
        }
    }
}

fn scene(text: &str, time: f64) -> Scene {
    let mut request = Request::text(text.to_owned());
    request.time = time;
    let compiled = compile(&request);
    compiled.scene.unwrap_or_else(|| panic!("{text}: {:?}", compiled.diagnostics))
}

fn camera(text: &str, time: f64) -> Camera {
    scene(&format!("scene(#{{ surface: sphere(1.0), camera: {text} }})"), time).camera
}

fn picture(camera: &str, size: (u32, u32)) -> Picture {
    let scene = scene(&format!("scene(#{{ surface: sphere(1.0), camera: {camera} }})"), 0.0);
    let order = Order { size: Some(size), samples: Some(4), ..Order::default() };
    session::render(&scene, &order, &Job::unwatched(&AtomicBool::new(false))).unwrap()
}

/// What is covered of a picture, with a weight for each place in it, and all of the weights.
fn covered(picture: &Picture, weight: impl Fn(f64, f64) -> f64) -> (f64, f64) {
    let (mut sum, mut whole) = (0.0, 0.0);
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (i as u32 % picture.width, i as u32 / picture.width);
        let place =
            [(x, picture.width), (y, picture.height)].map(|(k, n)| (f64::from(k) + 0.5) / f64::from(n));
        let weight = weight(place[0], place[1]);
        sum += weight * f64::from(pixel.alpha);
        whole += weight;
    }
    (sum, whole)
}

#[test]
fn an_orthographic_ball_has_the_area_of_its_disc() {
    let seen = picture("orbit(#{ distance: 9.0, projection: \"orthographic\", height: 2.5 })", (120, 100));
    let (sum, whole) = covered(&seen, |_, _| 1.0);
    assert!((sum / whole * 2.5 * 3.0 - PI).abs() < 0.01, "{}", sum / whole * 7.5);
    // And it is as far away as it is.
    assert!((seen.pixel(60, 50).depth - 8.0).abs() < 1e-3);
}

#[test]
fn all_around_a_ball_fills_its_solid_angle() {
    // Of half angle 30 degrees, as seen from two radii.
    let want = 0.5 * (1.0 - libm::cos(PI / 6.0));
    let flat = picture("panorama(#{ eye: [0, 0, 2], target: [1, 0, 1.5] })", (200, 100));
    let (sum, whole) = covered(&flat, |_, y| libm::sin(PI * y));
    assert!((sum / whole - want).abs() < 1e-3, "{} for {want}", sum / whole);
    let cube = picture("cube_map(#{ eye: [0, 0, 2], target: [1, 0, 1.5] })", (150, 100));
    let (sum, whole) = covered(&cube, |x, y| {
        let place = [3.0 * x, 2.0 * y].map(|at| 2.0 * (at - at.floor()) - 1.0);
        libm::pow(1.0 + place[0] * place[0] + place[1] * place[1], -1.5)
    });
    assert!((sum / whole - want).abs() < 1e-3, "{} for {want}", sum / whole);
    assert!(flat.warnings.is_empty() && cube.warnings.is_empty());
    let square = picture("panorama(#{ eye: [0, 0, 2] })", (20, 20));
    assert!(square.warnings.iter().any(|w| w.message.contains("stretched")));
}

/// Who asks for no camera is told when the usual one does not show all, and which one does.
#[test]
fn the_usual_camera_says_what_it_does_not_show() {
    let warnings = |script: &str| {
        let compiled = compile(&Request::text(script));
        let scene = compiled.scene.unwrap_or_else(|| panic!("{script}: {:?}", compiled.diagnostics));
        let order = Order { size: Some((40, 30)), samples: Some(1), ..Order::default() };
        let job = AtomicBool::new(false);
        session::render(&scene, &order, &Job::unwatched(&job)).expect("a picture").warnings
    };
    let two = "union(sphere(1.0), sphere(0.5).translated([3, 0, 0]))";
    let mut framed = Vec::new();
    for (solid, message) in [
        (two, "does not show all"),
        ("union(sphere(1.0), sphere(1.0).translated([100, 0, 0]))", "does not show all"),
        ("sphere(0.01)", "very small"),
    ] {
        let found = warnings(solid);
        let odd = found.iter().find(|w| w.message.contains(message));
        let odd = odd.unwrap_or_else(|| panic!("{solid}: {found:?}"));
        let (_, camera) = odd.hints[0].split_once("camera: ").expect("a camera");
        framed.push(format!("scene(#{{ surface: {solid}, camera: {camera}"));
    }
    for script in framed.iter().map(String::as_str).chain([
        "sphere(1.0)",
        "sphere(1.0) + 0.2 * gradient(7).scaled(4.0)",
        "y - 0.1 * sin(x)",
    ]) {
        assert!(warnings(script).is_empty(), "{script}");
    }
    // Whoever chooses a camera chooses what it shows.
    let own = format!("scene(#{{ surface: {two}, camera: orbit(#{{ distance: 3.9 }}) }})");
    assert!(warnings(&own).is_empty());
}

#[test]
fn a_lens_blurs_what_is_out_of_focus_only() {
    // Pixels that the ball covers in part, at its edge about 2.8 units away.
    let soft = |options: &str| {
        let seen = picture(&format!("look_at(#{{ eye: [0, 0, 3], {options} }})"), (80, 60));
        seen.pixels.iter().filter(|p| p.alpha > 0.0 && p.alpha < 1.0).count()
    };
    let (sharp, focused) = (soft("fov: 60.0"), soft("fov: 60.0, aperture: 0.2, focus: [0, 0, 0.333]"));
    let blurred = soft("fov: 60.0, aperture: 0.2, focus: 1.0");
    assert!(focused < 2 * sharp && blurred > 3 * sharp, "{sharp} {focused} {blurred}");
}

#[track_caller]
fn close(a: DVec3, b: DVec3, within: f64) {
    assert!((a - b).length() < within, "{a} {b}");
}

/// A planet whose radius along a unit vector is 1 + 0.05 x y.
const PLANET: &str = "ground: sphere(1.0) - 0.05 * (x * y).on_sphere()";

#[test]
fn walkers_stand_on_a_planet() {
    for (latitude, longitude) in [(0.0, 0.0), (30.0, 100.0), (-75.0, -60.0), (90.0, 20.0)] {
        let text = format!("walk(#{{ {PLANET}, at: [{latitude}, {longitude}], height: 1e-6 }})");
        let stands = camera(&text, 0.0);
        let up = orogen::scene::direction(longitude, latitude);
        close(stands.eye, (1.0 + 0.05 * up.x * up.y + 1e-6) * up, 1e-11);
        close(stands.up, up, 1e-12);
        // Level, and along the meridian.
        let ahead = (stands.target - stands.eye).normalize();
        let north = orogen::scene::direction(longitude, latitude + 1e-5) - up;
        close(ahead, north.normalize(), 1e-6);
    }
    let at_point = camera(&format!("walk(#{{ {PLANET}, at: [3, 3, 0], height: 0.1 }})"), 0.0);
    close(at_point.eye, DVec3::new(1.0, 1.0, 0.0).normalize() * 1.125, 1e-6);
}

#[test]
fn walkers_stand_on_planets_of_all_sizes() {
    for radius in [0.001, 6371.0, 6_371_000.0, 3e8] {
        let height = 1e-3 * radius;
        let text = format!("walk(#{{ ground: sphere({radius:?}), at: [20, 30], height: {height:?} }})");
        let eye = camera(&text, 0.0).eye;
        assert!((eye.length() / radius - 1.001).abs() < 1e-8, "{radius}: {eye}");
    }
}

#[test]
fn walkers_look_where_they_are_headed() {
    let toward = |options: &str| {
        let stands = camera(&format!("walk(#{{ {options}, height: 0.1, fov: 50.0 }})"), 0.0);
        assert_eq!(stands.projection, Projection::Perspective { fov: 50.0, lens: None });
        ((stands.target - stands.eye).normalize(), stands.up)
    };
    let (east, up) = toward("ground: sphere(1.0), at: [0, 0], heading: 90.0");
    close(east, DVec3::X, 1e-14);
    close(up, DVec3::Z, 1e-14);
    let (down, up) = toward("ground: sphere(1.0), at: [0, 0], pitch: -90.0");
    close(down, DVec3::NEG_Z, 1e-14);
    close(up, DVec3::Y, 1e-14);
    let (half, _) = toward("ground: y + 1.0, up: [0, 1, 0], at: [5, 0, 2], heading: 180.0, pitch: 45.0");
    close(half, DVec3::new(0.0, 1.0, 1.0).normalize(), 1e-14);
}

#[test]
fn walkers_stand_on_the_roof_and_not_below_it() {
    let house = "union(y, box([4, 2, 4]).translated([0, 3, 0]))";
    let eye = |x: f64| {
        let text = format!("walk(#{{ ground: {house}, up: [0, 1, 0], at: [{x}, 1, 0], height: 0.5 }})");
        camera(&text, 0.0).eye
    };
    let (roof, ground) = (eye(0.0), eye(40.0));
    close(ground, DVec3::new(40.0, 0.5, 0.0), 1e-6);
    close(roof, DVec3::new(0.0, 4.5, 0.0), 1e-6);
}

#[test]
fn first_places_inside_are_the_first() {
    let mut build = Build::default();
    let root = common::three_octaves(&mut build);
    let mut field = build.field(root);
    let mut rng = StdRng::seed_from_u64(11);
    let mut met = 0;
    for _ in 0..40 {
        let mut somewhere = || DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let (origin, aim) = (4.0 * somewhere().normalize(), somewhere());
        let line = (origin, (aim - origin).normalize());
        let found = first_inside(&mut field, line, [0.0, 8.0], 1e-9, &|| false).unwrap();
        let end = found.unwrap_or(8.0);
        for i in 0..2000 {
            let t = end * f64::from(i) / 2000.0;
            assert!(field.value(line.0 + t * line.1) > 0.0, "inside at {t}, before {end}");
        }
        if let Some(t) = found {
            met += 1;
            assert!(field.value(line.0 + (t + 2e-9) * line.1) <= 1e-12);
        }
    }
    assert!(met > 10, "{met}");
    let inside = first_inside(&mut field, (DVec3::ZERO, DVec3::X), [0.0, 8.0], 1e-9, &|| false);
    assert_eq!(inside, Ok(Some(0.0)));
    assert!(first_inside(&mut field, (DVec3::splat(4.0), DVec3::X), [0.0, 8.0], 1e-9, &|| true).is_err());
}

#[test]
fn options_go_with_the_time() {
    let turned = camera("orbit(#{ distance: 3.0, azimuth: 10.0 * time, elevation: 0.0 })", 9.0);
    close(turned.eye, DVec3::new(3.0, 0.0, 0.0), 1e-14);
    for eye in ["[time, 2.0 * time, 1]", "vec3(time, 2.0 * time, 1)", "time * vec3(1, 2, 0) + [0, 0, 1]"] {
        let moved = camera(&format!("look_at(#{{ eye: {eye}, target: [0, 9, 0] }})"), 3.0);
        assert_eq!(moved.eye, DVec3::new(3.0, 6.0, 1.0), "{eye}");
    }
    let dim = scene(
        "scene(#{ surface: sphere(1.0), film: film(#{ samples: 1 + 2 * time, exposure: -time }) })",
        4.0,
    );
    assert_eq!((dim.film.samples, dim.film.exposure), (9, -4.0));
}

#[test]
fn keyframes_lead_a_camera() {
    let at = |value: &str, time: f64| {
        camera(&format!("look_at(#{{ eye: {value}, target: [0, 0, 100] }})"), time).eye
    };
    let path = "keyframes([[1.0, [0, 0, 0]], [3.0, [2, 0, 0]], [5.0, [2, 4, 0]]])";
    for (time, want) in
        [(-1.0, [0.0, 0.0, 0.0]), (1.0, [0.0; 3]), (3.0, [2.0, 0.0, 0.0]), (99.0, [2.0, 4.0, 0.0])]
    {
        assert_eq!(at(path, time), DVec3::from_array(want));
    }
    let straight = path.replace("]])", "]], #{ smooth: false })");
    assert_eq!(at(&straight, 2.0), DVec3::new(1.0, 0.0, 0.0));
    let distance = |options: &str, time: f64| {
        camera(&format!("orbit(#{{ distance: keyframes([[0, 1000], [4, 10], [6, 10]], {options}) }})"), time)
            .eye
            .length()
    };
    assert!((distance("#{ smooth: false, geometric: true }", 2.0) - 100.0).abs() < 1e-9);
    assert!((distance("#{ geometric: true }", 2.0) - 100.0).abs() < 1e-9);
    assert!((distance("#{ smooth: false }", 2.0) - 505.0).abs() < 1e-9);
    assert!((distance("#{}", 5.0) - 10.0).abs() < 1e-9);
}

/// Where numbers are wanted, functions of time are what they are at the time of the picture.
#[test]
fn functions_of_time_are_numbers_then() {
    let at = |value: &str, time: f64| {
        camera(&format!("look_at(#{{ eye: {value}, target: [0, 0, 100] }})"), time).eye
    };
    assert_eq!(at("[radians(90.0 * time), to_float(3.0 * time), 1.0]", 2.0), DVec3::new(PI, 6.0, 1.0));
    let shrunk = "{ let ball = sphere(1.0).scaled(1.0 + time); [ball.at([0, 0, 0]), 0.0, 0.0] }";
    assert_eq!(at(shrunk, 1.5), DVec3::new(-2.5, 0.0, 0.0));
    let turned = "{ let f = x.rotated([0, 1.0 - time, time], 90.0); [f.at([1, 2, 3]), 0.0, 0.0] }";
    assert!((at(turned, 0.0).x + 3.0).abs() < 1e-12 && (at(turned, 1.0).x - 2.0).abs() < 1e-12);
    let bounds = |time: f64| {
        let script = "scene(#{ surface: sphere(1.0), bounds: 2.0 + time })";
        let scene = compile(&Request { time, ..Request::text(script) }).scene.expect("a scene");
        scene.bounds.expect("bounds").max
    };
    assert_eq!([bounds(0.0), bounds(3.0)], [DVec3::splat(2.0), DVec3::splat(5.0)]);
}

#[test]
fn keyframes_of_pairs_and_colours() {
    let at = |value: &str, time: f64| {
        camera(&format!("{{ let v = {value}; look_at(#{{ eye: v, target: [0, 0, 100] }}) }}"), time).eye
    };
    let pair = "{ let p = keyframes([[0, [1, 2]], [2, [3, 6]]]); [p[0], p[1], 0.0] }";
    assert_eq!(at(pair, 1.0), DVec3::new(2.0, 4.0, 0.0));
    // Over and over, without a corner where they begin again.
    let round =
        "keyframes([[1, [0, 0, 1]], [2, [1, 0, 0]], [4, [0, 1, 1]], [5, [0, 0, 1]]], #{ repeat: true })";
    for time in [1.0, 2.3, 4.9] {
        assert!(at(round, time).distance(at(round, time + 4.0)) < 1e-12);
        assert!(at(round, time).distance(at(round, time - 8.0)) < 1e-12);
    }
    let h = 1e-6;
    let [before, after] = [-h, h].map(|h| (at(round, 5.0 + h) - at(round, 5.0)) / h);
    assert!(before.distance(after) < 1e-4 && after.length() > 0.1, "{before} {after}");
    // Of colours none is less than nothing, as texts and as vectors that say so.
    let [texts, vectors] = [
        r##"keyframes([[0, "#ff0000"], [1, "#00ff00"], [2, "#0000ff"]])"##,
        "keyframes([[0, [1, 0, 0]], [1, [0, 1, 0]], [2, [0, 0, 1]]], #{ overshoot: false })",
    ];
    let runs_on = vectors.replace("false", "true");
    let mut lowest = f64::INFINITY;
    for i in 0..=40 {
        let time = 0.05 * f64::from(i);
        assert_eq!(at(texts, time), at(vectors, time));
        assert!(at(vectors, time).min_element() >= 0.0);
        lowest = lowest.min(at(&runs_on, time).min_element());
    }
    assert!(lowest < 0.0);
}

#[test]
fn lenses_of_scripts_are_focused() {
    let lens =
        |options: &str| match camera(&format!("look_at(#{{ eye: [0, 0, 5], {options} }})"), 0.0).projection {
            Projection::Perspective { lens, .. } => lens,
            other => panic!("{other:?}"),
        };
    assert_eq!(lens("fov: 20.0"), None);
    assert_eq!(lens("aperture: 0.0, focus: 3.0"), None);
    assert_eq!(lens("aperture: 0.1"), Some(Lens { radius: 0.1, focus: 5.0 }));
    assert_eq!(lens("aperture: 0.1, focus: 3"), Some(Lens { radius: 0.1, focus: 3.0 }));
    assert_eq!(lens("aperture: 0.1, focus: [2, 7, 1]"), Some(Lens { radius: 0.1, focus: 4.0 }));
    let shown = camera("orbit(#{ distance: 2.0, projection: \"orthographic\" })", 0.0).projection;
    let Projection::Orthographic { height } = shown else { panic!("{shown:?}") };
    assert!((height - 4.0 * libm::tan(17.5f64.to_radians())).abs() < 1e-12);
    let properties = camera(
        "{ let c = look_at(#{ eye: [1, 2, 3] }); panorama(#{ eye: c.eye, target: c.target, up: c.up }) }",
        0.0,
    );
    assert_eq!((properties.eye, properties.projection), (DVec3::new(1.0, 2.0, 3.0), Projection::Panorama));
}
