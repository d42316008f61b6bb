//! Pictures of small scenes whose right answer is known, cast by plain marching.

mod light;

use super::*;
use crate::cast::{CastStats, Caster, Hit, Ray};
use crate::expr::{Graph, NodeId};
use crate::op::{self, Op};
use crate::scene::{Aabb, Air, Camera, Film, Scene, Sky, Sun, Surface};
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Many small steps, then bisection: slow, and blind to what is thinner than a step. Every ray is said
/// to cost 1.
struct March {
    field: Evaluator<f64>,
    steps: u32,
    costs: Vec<f64>,
}

impl March {
    fn new(tape: &Arc<Tape>) -> Self {
        March { field: Evaluator::new(tape.clone()), steps: 150, costs: Vec::new() }
    }

    fn inside(&mut self, ray: &Ray, t: f64) -> bool {
        *self.field.eval(&ray.at(t).to_array()) < 0.0
    }

    fn first_hit(&mut self, ray: &Ray) -> Hit {
        let steps = f64::from(self.steps);
        let at = |i: u32| ray.near + (ray.far - ray.near) * f64::from(i) / steps;
        let Some(i) = (0..=self.steps).find(|&i| self.inside(ray, at(i))) else { return Hit::MISS };
        let (mut before, mut behind) = (at(i.saturating_sub(1)), at(i));
        for _ in 0..60 {
            let mid = 0.5 * (before + behind);
            if self.inside(ray, mid) { behind = mid } else { before = mid }
        }
        Hit { t: before, certified: false }
    }
}

impl Caster for March {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, _: &AtomicBool) {
        self.costs = vec![1.0; rays.len()];
        for (ray, out) in rays.iter().zip(out) {
            *out = self.first_hit(ray);
            stats.rays += 1;
            stats.hits += u64::from(out.is_hit());
            stats.uncertified += u64::from(!out.certified);
        }
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(March { field: self.field.clone(), steps: self.steps, costs: Vec::new() })
    }
}

/// Builds fields without the ceremony of errors.
#[derive(Default)]
struct Build(Graph);

impl Build {
    fn op(&mut self, op: Op, args: &[NodeId]) -> NodeId {
        self.0.op(op, args).unwrap()
    }

    fn number(&mut self, c: f64) -> NodeId {
        self.0.constant(c).unwrap()
    }

    fn sphere(&mut self, center: DVec3, radius: f64) -> NodeId {
        let mut p = self.0.point().unwrap();
        for (axis, p) in p.iter_mut().enumerate() {
            let c = self.number(center[axis]);
            *p = self.op(Op::Sub(op::Sub), &[*p, c]);
        }
        let (length, radius) = (self.op(Op::Length(op::Length), &p), self.number(radius));
        self.op(Op::Sub(op::Sub), &[length, radius])
    }

    /// The part of space where `|p - center| < half` on every axis.
    fn cuboid(&mut self, center: DVec3, half: DVec3) -> NodeId {
        let p = self.0.point().unwrap();
        let sides: [NodeId; 3] = std::array::from_fn(|axis| {
            let (c, h) = (self.number(center[axis]), self.number(half[axis]));
            let d = self.op(Op::Sub(op::Sub), &[p[axis], c]);
            let d = self.op(Op::Abs(op::Abs), &[d]);
            self.op(Op::Sub(op::Sub), &[d, h])
        });
        let two = self.op(Op::Max(op::Max), &sides[..2]);
        self.op(Op::Max(op::Max), &[two, sides[2]])
    }

    fn scene(self, field: NodeId) -> Scene {
        Scene {
            graph: Arc::new(self.0),
            surface: Surface { field, color: None, material: None, keep: None },
            camera: Camera::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO),
            sun: Sun { direction: DVec3::X, ..Sun::default() },
            lights: Vec::new(),
            sky: Sky { background: DVec3::ZERO, ..Sky::default() },
            moon: None,
            sea: None,
            film: Film { width: 48, height: 40, samples: 4, ..Film::default() },
            bounds: Some(Aabb::cube(1.5)),
            params: Vec::new(),
        }
    }
}

fn ball() -> Scene {
    let mut build = Build::default();
    let field = build.sphere(DVec3::ZERO, 1.0);
    build.scene(field)
}

fn prepared(scene: &Scene) -> Prepared {
    prepare(scene, &Settings::of(scene, Aabb::cube(2.0)), &AtomicBool::new(false)).unwrap()
}

fn shoot(scene: &Scene) -> Picture {
    let prepared = prepared(scene);
    let cancel = AtomicBool::new(false);
    render(&prepared, &March::new(&prepared.tape), &Job::unwatched(&cancel)).unwrap()
}

/// The pixel in which a point appears.
fn pixel_of(picture: &Picture, scene: &Scene, p: DVec3) -> Pixel {
    let [x, y] = prepared(scene).view.project(p).unwrap();
    *picture.pixel(x as u32, y as u32)
}

#[test]
fn a_white_ball_in_uniform_light_is_uniform() {
    let mut scene = ball();
    let mut graph = Graph::clone(&scene.graph);
    let one = graph.constant(1.0).unwrap();
    scene.graph = Arc::new(graph);
    scene.surface.color = Some([one; 3]);
    scene.sun.irradiance = DVec3::ZERO;
    scene.sky = Sky { zenith: DVec3::ONE, nadir: DVec3::ONE, background: DVec3::ONE, ..scene.sky };
    let picture = shoot(&scene);
    assert!(picture.finished && !picture.empty && picture.warnings.is_empty());
    for p in &picture.pixels {
        assert!(p.over(picture.background).iter().all(|c| (c - 1.0).abs() < 1e-6));
    }
    let (left, right) = (picture.pixel(0, 0).alpha, picture.pixel(24, 20).alpha);
    assert_eq!((left, right), (0.0, 1.0));
}

#[test]
fn the_lit_side_faces_the_sun() {
    let mut scene = ball();
    scene.sky = Sky { zenith: DVec3::ZERO, nadir: DVec3::ZERO, ..scene.sky };
    let picture = shoot(&scene);
    for angle in [40.0f64, 70.0, 110.0, 140.0] {
        let a = angle.to_radians();
        let p = DVec3::new(a.cos(), 0.0, a.sin());
        let seen = pixel_of(&picture, &scene, p).color[0];
        let expected = 0.6 * scene.sun.irradiance.x / std::f64::consts::PI * a.cos().max(0.0);
        // A pixel covers some degrees.
        assert!((f64::from(seen) - expected).abs() < 0.03, "{angle}: {seen} for {expected}");
    }
    let front = picture.pixel(24, 20);
    assert!((front.depth - 3.0).abs() < 5e-3 && front.normal[2] > 0.99 && front.position[2] > 0.99);
    assert!(picture.stats.primary.hits > 0 && picture.stats.samples == 48 * 40 * 4);
}

#[test]
fn a_box_throws_its_shadow_on_the_floor() {
    let mut build = Build::default();
    let floor = build.cuboid(DVec3::new(0.0, -1.0, 0.0), DVec3::new(1.4, 0.5, 1.4));
    let cube = build.cuboid(DVec3::new(0.0, -0.3, 0.0), DVec3::splat(0.2));
    let field = build.op(Op::Min(op::Min), &[floor, cube]);
    let mut scene = build.scene(field);
    scene.camera.eye = DVec3::new(0.0, 4.0, 0.001);
    scene.sun.direction = DVec3::new(1.0, 1.0, 0.0).normalize();
    let picture = shoot(&scene);
    let seen = |x: f64, z: f64| pixel_of(&picture, &scene, DVec3::new(x, -0.5, z)).color[0];
    // The sun is at 45 degrees over +x: the shadow of a box 0.4 high reaches 0.4 beyond it.
    let (lit, dark) = (seen(0.8, 0.0), seen(-0.4, 0.0));
    assert!(lit > 2.0 * dark, "{lit} {dark}");
    assert!((seen(-0.5, 0.1) - dark).abs() < 1e-6);
    for (x, z) in [(-0.75, 0.0), (-0.4, 0.35), (0.35, 0.0), (-0.4, -0.35)] {
        assert!((seen(x, z) - lit).abs() < 1e-6, "{x} {z}");
    }
    scene.sun.shadows = false;
    let picture = shoot(&scene);
    let seen = pixel_of(&picture, &scene, DVec3::new(-0.4, -0.5, 0.0)).color[0];
    assert!((seen - lit).abs() < 1e-6 && picture.stats.shadow.rays == 0);
}

#[test]
fn where_the_bounds_cut_a_solid_it_has_a_face() {
    let mut build = Build::default();
    let field = build.sphere(DVec3::ZERO, 4.0);
    let mut scene = build.scene(field);
    scene.sun.direction = DVec3::new(0.3, 0.2, 1.0).normalize();
    let picture = shoot(&scene);
    let at = |x: f64, y: f64| pixel_of(&picture, &scene, DVec3::new(x, y, 1.5));
    for (x, y) in [(0.0, 0.0), (0.8, -0.6), (-0.8, 0.5), (0.4, 0.7)] {
        let pixel = at(x, y);
        assert_eq!((pixel.normal, pixel.color), ([0.0, 0.0, 1.0], at(0.1, 0.1).color), "{x} {y}");
    }
    let lit = 0.6 * scene.sun.irradiance.x / std::f64::consts::PI * scene.sun.direction.z;
    assert!(f64::from(at(0.1, 0.1).color[0]) >= lit - 1e-3);
}

fn planet() -> Scene {
    let mut scene = ball();
    let scattering = DVec3::new(5.8, 13.5, 33.1);
    scene.sky.air = Some(Air::clear(1.0, 0.01, scattering));
    scene.sky.up = None;
    scene.bounds = Some(Aabb::cube(1.01));
    scene
}

#[test]
fn air_has_a_blue_rim_by_day_and_none_by_night() {
    // Close to the limb, on the sunny and on the dark side; the line of sight passes at 2 heights.
    let rim = |x: f64| {
        let mut scene = planet();
        scene.camera.target = DVec3::new(x, 0.0, 0.25);
        scene.camera = scene.camera.with_fov(3.0);
        let picture = shoot(&scene);
        assert!(picture.pixels.iter().all(|p| p.color.iter().all(|c| c.is_finite() && *c >= 0.0)));
        let seen = pixel_of(&picture, &scene, scene.camera.target);
        assert!(seen.depth.is_infinite());
        seen.color
    };
    let (day, night) = (rim(0.99), rim(-0.99));
    assert!(day[2] > 1.5 * day[0] && day[2] > 0.05, "{day:?}");
    assert!(night.iter().all(|c| *c < 1e-3), "{night:?}");
}

#[test]
fn pixels_know_what_their_rays_cost() {
    let scene = ball();
    let picture = shoot(&scene);
    let all: f64 = picture.pixels.iter().map(|p| f64::from(p.evaluations)).sum();
    assert_eq!(all, (picture.stats.primary.rays + picture.stats.shadow.rays) as f64);
    // Four rays to the eye; where the sun shines, four to the sun besides.
    let cost = |x: f64, z: f64| pixel_of(&picture, &scene, DVec3::new(x, 0.0, z)).evaluations;
    assert_eq!((cost(0.6, 0.8), cost(-0.6, 0.8)), (8.0, 4.0));
}

#[test]
fn threads_do_not_matter() {
    let mut gathered = planet();
    gathered.film = Film { bounces: 1, irradiance_spacing: 3, samples: 2, ..gathered.film };
    for scene in [planet(), gathered] {
        is_the_same_on_any_threads(&scene);
    }
}

fn is_the_same_on_any_threads(scene: &Scene) {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let picture = pool.install(|| shoot(scene));
        let bytes: Vec<u8> = (0..picture.height).flat_map(|y| picture.row_bytes(y)).collect();
        let mut stats = picture.stats;
        (stats.seconds, stats.threads) = Default::default();
        (picture.pixels, bytes, stats)
    };
    let one = on(1);
    assert!(one == on(2) && one == on(3));
}

#[test]
fn a_cancelled_job_gives_what_there_is() {
    let scene = prepared(&ball());
    let caster = March::new(&scene.tape);
    let cancel = AtomicBool::new(false);
    let progress = |p: Progress| cancel.store(p.done >= 2, Ordering::Relaxed);
    let job = Job { progress: &progress, ..Job::unwatched(&cancel) };
    let picture = render(&scene, &caster, &job).unwrap();
    assert!(!picture.finished && (2..9).contains(&picture.tiles));
    let before = AtomicBool::new(true);
    let picture = render(&scene, &caster, &Job::unwatched(&before)).unwrap();
    assert_eq!((picture.finished, picture.tiles), (false, 0));
}

#[test]
fn tiles_arrive_with_their_pixels() {
    let scene = prepared(&ball());
    let film = std::sync::Mutex::new(vec![Pixel::EMPTY; 48 * 40]);
    let tile = |Fine { rect, pixels, .. }: &Fine<'_>| {
        let mut film = film.lock().unwrap();
        for (i, pixel) in pixels.iter().enumerate() {
            let (x, y) =
                (rect.x as usize + i % rect.width as usize, rect.y as usize + i / rect.width as usize);
            film[y * 48 + x] = *pixel;
        }
    };
    let cancel = AtomicBool::new(false);
    let job = Job { tile: &tile, ..Job::unwatched(&cancel) };
    let picture = render(&scene, &March::new(&scene.tape), &job).unwrap();
    assert!(*film.lock().unwrap() == picture.pixels);
}

#[test]
fn what_is_odd_is_said() {
    let warned = |scene: &Scene, words: &str| {
        let picture = shoot(scene);
        assert!(picture.warnings.iter().any(|w| w.message.contains(words)), "{:?}", picture.warnings);
        picture
    };
    let mut away = ball();
    away.camera.target = DVec3::new(0.0, 0.0, 10.0);
    assert!(warned(&away, "does not see").empty);

    let mut build = Build::default();
    let field = build.number(1.0);
    assert!(warned(&build.scene(field), "no solid").empty);

    let mut inside = ball();
    inside.camera.eye = DVec3::new(0.0, 0.0, 0.5);
    warned(&inside, "inside the solid");

    let mut build = Build::default();
    let field = build.sphere(DVec3::ZERO, 1.0);
    let x = build.0.point().unwrap()[0];
    let root = build.op(Op::Sqrt(op::Sqrt), &[x]);
    let mut scene = build.scene(field);
    scene.surface.color = Some([root; 3]);
    let picture = warned(&scene, "magenta");
    let half = picture.stats.undefined as f64 / picture.stats.primary.hits as f64;
    assert!((half - 0.5).abs() < 0.05, "{half}");

    scene.surface.field = root;
    warned(&scene, "undefined");

    // Level steps: a surface where the field jumps, beside which it is flat.
    let mut build = Build::default();
    let z = build.0.point().unwrap()[2];
    let floor = build.op(Op::Floor(op::Floor), &[z]);
    let scene = build.scene(floor);
    let picture = warned(&scene, "no normal");
    assert!(picture.stats.flat > 0 && picture.stats.undefined == 0);

    let air = |radius| Some(Air::clear(radius, 0.01 * radius, DVec3::new(3.0, 8.0, 20.0) / radius));
    for (radius, words) in [(0.5, "planet of radius 0.5"), (2.0, "planet of radius 2")] {
        let mut elsewhere = ball();
        elsewhere.sky.air = air(radius);
        warned(&elsewhere, words);
    }
    let mut around = ball();
    around.sky.air = air(1.0);
    assert!(shoot(&around).warnings.is_empty());
    around.camera.target = DVec3::new(0.0, 0.0, 10.0);
    assert!(!shoot(&around).warnings.iter().any(|w| w.message.contains("planet of radius")));
}

#[test]
fn a_field_without_values_is_an_error() {
    let mut build = Build::default();
    let minus = build.number(-1.0);
    let y = build.0.point().unwrap()[1];
    let y2 = build.op(Op::Square(op::Square), &[y]);
    let below = build.op(Op::Sub(op::Sub), &[minus, y2]);
    let field = build.op(Op::Sqrt(op::Sqrt), &[below]);
    let scene = build.scene(field);
    let error = prepare(&scene, &Settings::of(&scene, Aabb::cube(1.0)), &AtomicBool::new(false)).unwrap_err();
    assert!(matches!(error, RenderError::Undefined { .. }));
    assert!(!error.diagnostic().hints.is_empty());
}

fn metadata() -> Metadata {
    Metadata {
        script: "sphere(1.0) // Größe".to_owned(),
        params: vec![("relief".to_owned(), 0.25.into())],
        recipe: "by hand".to_owned(),
    }
}

#[test]
fn a_png_holds_the_picture_and_its_script() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.png");
    let picture = shoot(&ball());
    save(&path, &picture, &metadata()).unwrap();
    let decoder = ::png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let expected: Vec<u8> = (0..picture.height).flat_map(|y| picture.row_bytes(y)).collect();
    assert!(bytes == expected);
    let texts: Vec<_> =
        reader.info().utf8_text.iter().map(|t| (&t.keyword[..], t.get_text().unwrap())).collect();
    assert!(texts.contains(&("Script", metadata().script)));
    assert!(texts.contains(&("Parameters", "relief=0.25".to_owned())));
}

#[test]
fn an_exr_holds_light_geometry_and_script() {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.exr");
    let picture = shoot(&ball());
    save(&path, &picture, &metadata()).unwrap();
    let image = read_first_flat_layer_from_file(&path).unwrap();
    let channel = |name: &str| {
        let found = image.layer_data.channel_data.list.iter().find(|c| c.name.eq(name)).unwrap();
        found.sample_data.values_as_f32().collect::<Vec<_>>()
    };
    type Read = fn(&Pixel) -> f32;
    let reads: [(&str, Read); 4] = [
        ("R", |p| p.color[0]),
        ("Z", |p| p.depth),
        ("position.Y", |p| p.position[1]),
        ("normal.X", |p| p.normal[0]),
    ];
    for (name, read) in reads {
        assert!(channel(name) == picture.pixels.iter().map(read).collect::<Vec<_>>(), "{name}");
    }
    let Some(AttributeValue::Text(script)) = image.layer_data.attributes.other.get(&Text::from("script"))
    else {
        panic!("no script");
    };
    assert_eq!(script.as_slice(), metadata().script.as_bytes());
    let first = std::fs::read(&path).unwrap();
    save(&path, &picture, &metadata()).unwrap();
    assert!(first == std::fs::read(&path).unwrap(), "equal pictures make equal files");
}

#[test]
fn files_are_refused_before_rendering() {
    assert!(matches!(can_save(Path::new("x.jpeg")), Err(SaveError::Ending { .. })));
    assert!(matches!(can_save(Path::new("/nowhere/x.png")), Err(SaveError::Write(_))));
}
