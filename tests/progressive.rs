//! Pictures that refine: on the way they show all of the solid, in the end they are what they would have been at
//! once, bit for bit; what is asked for comes first, and what is to stop stops.

mod common;

use common::Build;
use glam::DVec3;
use orogen::cast::{Bundle, CastStats, Frame, Hit, Kind, Ray, Tolerance, caster, reach};
use orogen::expr::NodeId;
use orogen::render::{Fine, Job, Picture, Pixel, Rect, Rough, Snapshots, Steering, tiles};
use orogen::scene::{Aabb, Scene};
use orogen::script::{Request, compile};
use orogen::session::{self, Order, Session};
use orogen::tape::Cells;
use orogen::world::Memory;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A solid with thin parts, holes and pieces that float, and what of it makes scenes.
const ROCK: &str = "sphere(1.0) + 0.3 * gradient(1).scaled(4.0) + 0.15 * gradient(2).scaled(8.0)";
const RIDGES: &str = "sphere(1.0) + 0.3 * sqrt(abs(gradient(5).scaled(6.0)))";
const RINGS: &str = "union([torus(1.0, 0.02), sphere(0.4), box([0.05, 2.4, 0.05])])";
const GROUND: &str = "max(y - 0.2 * gradient(3).scaled(3.0), box([4.0, 1.6, 4.0]))";

/// How the solids are seen: from afar, closely, from within the bounds along the ground, and by parallel lines.
const CAMERAS: [&str; 4] = [
    "orbit(#{ distance: 5.0, azimuth: 20.0, elevation: 15.0, fov: 40.0 })",
    "orbit(#{ distance: 2.2, azimuth: 110.0, elevation: -10.0, fov: 75.0 })",
    "look_at(#{ eye: [1.4, 0.45, 1.3], target: [-1, 0, -1] })",
    "orbit(#{ distance: 5.0, azimuth: 20.0, elevation: 35.0, projection: \"orthographic\", height: 3.0 })",
];

fn scene(surface: &str, camera: &str, film: &str) -> Scene {
    let text = format!(
        "scene(#{{ surface: {surface}, camera: {camera}, bounds: [vec3(-2.0, -0.9, -2.0), vec3(2.0, 1.6, 2.0)],
                   film: film(#{{ width: 150, height: 101, {film} }}) }})"
    );
    let compiled = compile(&Request::text(text.clone()));
    compiled.scene.unwrap_or_else(|| panic!("{text}: {:?}", compiled.diagnostics))
}

fn batch(scene: &Scene, order: &Order) -> Picture {
    session::render(scene, order, &Job::unwatched(&AtomicBool::new(false))).unwrap()
}

/// The picture, with what it looked like on the way.
fn refined(scene: &Scene, order: &Order, steering: &Steering) -> (Picture, Snapshots) {
    let snapshots = Snapshots::default();
    let (keep, cancel) = (|tile: &Rough| snapshots.keep(tile), AtomicBool::new(false));
    let job = Job { rough: Some(&keep), ..Job::unwatched(&cancel) };
    let picture = session::refine(scene, order, &job, steering).unwrap();
    (picture, snapshots)
}

/// The numbers of a pixel, as they are stored.
fn bits(pixel: &Pixel) -> Vec<u32> {
    let Pixel { color, albedo, alpha, depth, position, normal, samples, variance, evaluations, .. } = *pixel;
    let single = [alpha, depth, samples, variance, evaluations];
    let all = [color, albedo, position, normal].concat().into_iter().chain(single);
    all.map(f32::to_bits).collect()
}

#[track_caller]
fn same(a: &Picture, b: &Picture) {
    assert!(a.finished && b.finished && a.pixels.len() == b.pixels.len());
    for (i, (a, b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        assert_eq!(bits(a), bits(b), "pixel {i}");
    }
}

fn is_solid(pixel: &&Pixel) -> bool {
    pixel.depth.is_finite()
}

fn order(caster: Kind) -> Order {
    Order { caster, ..Order::default() }
}

#[test]
fn every_picture_on_the_way_shows_all_of_the_solid() {
    // On one thread, since rough tiles are not shown where a finished one is already, and with several a slow thread's
    // may come so late: then fewer are seen than there would be.
    let alone = |way| Order { threads: NonZeroUsize::new(1), ..order(way) };
    for (surface, ways) in [
        (ROCK, &[Kind::Beam, Kind::Speculative][..]),
        (RIDGES, &[Kind::Beam]),
        (RINGS, &[Kind::Beam, Kind::Speculative]),
        (GROUND, &[Kind::Beam, Kind::Speculative]),
    ] {
        for (camera, film) in
            CAMERAS.into_iter().zip(["samples: 4, filter: 4", "samples: 1", "samples: 4", "samples: 1"])
        {
            let scene = scene(surface, camera, film);
            for &way in ways {
                let (last, snapshots) = refined(&scene, &alone(way), &Steering::down_to(1));
                let seen = last.pixels.iter().filter(is_solid).count();
                let mut before = usize::MAX;
                for side in Steering::SIDES {
                    let rough = snapshots.at(side, None, &last);
                    let lost =
                        rough.pixels.iter().zip(&last.pixels).filter(|(r, l)| !is_solid(r) && is_solid(l));
                    assert_eq!(lost.count(), 0, "{surface} {camera} {way:?}: lost at {side}");
                    let shown = rough.pixels.iter().filter(is_solid).count();
                    assert!(shown <= before, "{surface} {camera} {way:?}: more at {side}");
                    before = shown;
                }
                // And in the end little else, unless pixels are seen with all of their neighbours.
                let room = last.pixels.len() - seen;
                assert!(
                    film.contains("filter") || before - seen <= room / 3 + 200,
                    "{surface} {camera} {way:?}: {before} for {seen} of {}",
                    last.pixels.len()
                );
            }
        }
    }
}

/// What is beside the solid in a picture, and how it is seen: through lenses that are wider and narrower than what they
/// see, all around, with water, under water, with a moon.
const BESIDE: [(&str, &str, &str); 9] = [
    (ROCK, "orbit(#{ distance: 4.0, aperture: 0.05, focus: 3.2 })", ""),
    (RINGS, "orbit(#{ distance: 4.0, azimuth: 70.0, aperture: 0.01 })", ""),
    (RIDGES, "look_at(#{ eye: [0.5, 1.9, 2.6], target: [0, 0, 0], aperture: 0.02, focus: 2.0 })", ""),
    (ROCK, "panorama(#{ eye: [0.2, 0.5, 1.9], target: [0, 0.4, 0] })", ""),
    (GROUND, "panorama(#{ eye: [0.3, 0.6, 0.2], target: [1, 0.9, 0] })", ""),
    (RIDGES, "cube_map(#{ eye: [0.4, 0.6, 1.7] })", ""),
    (GROUND, CAMERAS[2], "sea: sea(#{ surface: y - 0.05 * sin(9.0 * x) })"),
    (GROUND, CAMERAS[2], "sea: sea(#{ surface: y - 1.2 })"),
    (ROCK, CAMERAS[0], "moon: moon(#{ surface: sphere(1.0), azimuth: 190.0, elevation: -12.0, size: 7.0 })"),
];

#[test]
fn every_picture_on_the_way_shows_all_there_is() {
    for (surface, camera, beside) in BESIDE {
        let camera = if beside.is_empty() { camera.to_owned() } else { format!("{camera}, {beside}") };
        let scene = scene(surface, &camera, "samples: 4");
        let (last, snapshots) = refined(&scene, &order(Kind::Beam), &Steering::down_to(1));
        assert!(last.stats.tiles > 0);
        // Of what is covered a moon leaves no depth.
        let is_there = |pixel: &Pixel| pixel.alpha > 0.0;
        let seen = last.pixels.iter().filter(|pixel| is_there(pixel)).count();
        assert!(seen > 500 && seen <= last.pixels.len(), "{camera}: {seen}");
        for side in Steering::SIDES {
            let rough = snapshots.at(side, None, &last);
            let lost = rough.pixels.iter().zip(&last.pixels).filter(|(r, l)| !is_there(r) && is_there(l));
            assert_eq!(lost.count(), 0, "{surface} {camera}: lost at {side}");
        }
        let shown = snapshots.at(1, None, &last).pixels.iter().filter(|pixel| is_there(pixel)).count();
        println!("{camera}: {shown} for {seen} of {}", last.pixels.len());
        assert!(shown - seen <= (last.pixels.len() - seen) / 2 + 300, "{camera}: {shown} for {seen}");
        same(&last, &batch(&scene, &order(Kind::Beam)));
    }
}

#[test]
fn pictures_of_what_moves_show_it_wherever_it_goes() {
    let text = "scene(#{ surface: sphere(0.5).at(p - vec3(4.0 * time, 0.0, 0.0)),
                         film: film(#{ width: 120, height: 80, samples: 16, shutter: 0.4 }) })";
    let world = Memory([("a.rhai".into(), text.to_owned())].into());
    let mut session = Session::new("a.rhai", Arc::new(world));
    let cancel = Arc::default();
    let scene = session.load(&cancel).scene.clone().unwrap();
    let snapshots = Snapshots::default();
    let keep = |tile: &Rough| snapshots.keep(tile);
    let job = Job { rough: Some(&keep), ..Job::unwatched(&cancel) };
    let order = Order::default();
    let last = session.refine(&scene, &order, &job, (&Steering::down_to(2), &cancel)).unwrap();
    same(&last, &session.render(&scene, &order, &Job::unwatched(&cancel), &cancel).unwrap());
    let [rough, seen] = [&snapshots.at(2, None, &last), &last]
        .map(|picture| picture.pixels.iter().map(|pixel| pixel.alpha > 0.0).collect::<Vec<_>>());
    assert!(seen.iter().zip(&rough).all(|(seen, rough)| *rough || !seen));
    let count = |all: &[bool]| all.iter().filter(|is| **is).count();
    let still =
        compile(&Request::text("scene(#{ surface: sphere(0.5), film: film(#{ width: 120, height: 80 }) })"));
    let still = batch(&still.scene.unwrap(), &order).pixels.iter().filter(is_solid).count();
    assert!(count(&seen) > 2 * still && count(&rough) < count(&seen) + 500, "{still}");
}

#[test]
fn a_refined_picture_is_the_picture_bit_for_bit() {
    let beside = "sky: sky(#{ air: air(#{ radius: 1.0 }) })";
    let scenes = [
        scene(ROCK, CAMERAS[0], "samples: 2"),
        scene(RIDGES, CAMERAS[3], "samples: 1"),
        scene(GROUND, CAMERAS[2], "samples: 5, filter: 4"),
        scene(RINGS, &format!("{}, {beside}", CAMERAS[1]), "samples: 2, bounces: 2"),
        scene(ROCK, &CAMERAS[0].replace("orbit(#{", "orbit(#{ aperture: 0.1, "), "samples: 2"),
        scene(ROCK, "panorama(#{ eye: [0, 0.5, 3] })", "samples: 1"),
    ];
    for scene in &scenes {
        let whole = batch(scene, &Order::default());
        for threads in 1..=4 {
            let order = Order { threads: NonZeroUsize::new(threads), ..Order::default() };
            let (last, _) = refined(scene, &order, &Steering::default());
            same(&last, &whole);
        }
        let (last, _) = refined(scene, &Order::default(), &Steering::down_to(1));
        same(&last, &whole);
        assert!(last.stats.tiles > 0);
    }
}

#[test]
fn a_part_of_a_picture_refines_as_well() {
    let scene = scene(ROCK, CAMERAS[0], "samples: 1");
    let window = Rect { x: 37, y: 20, width: 61, height: 50 };
    let order = Order { part: orogen::render::Part::Region(window), ..Order::default() };
    let (last, snapshots) = refined(&scene, &order, &Steering::default());
    same(&last, &batch(&scene, &order));
    assert_eq!(snapshots.at(8, None, &last).window, window);
}

#[test]
fn the_region_of_interest_is_finished_first() {
    let scene = scene(ROCK, CAMERAS[0], "samples: 1");
    let region = Rect { x: 100, y: 66, width: 10, height: 12 };
    let meets = |rect: &Rect| rect.intersection(&region).is_some();
    let steering = Steering::default();
    steering.focus(Some(region));
    let told = Mutex::new(Vec::new());
    let rough = |tile: &Rough| told.lock().unwrap().push((tile.rect, Some(tile.side)));
    let finished = |tile: &Fine<'_>| told.lock().unwrap().push((tile.rect, None));
    let cancel = AtomicBool::new(false);
    let job = Job { rough: Some(&rough), tile: &finished, ..Job::unwatched(&cancel) };
    let order = Order { threads: NonZeroUsize::new(1), ..Order::default() };
    let last = session::refine(&scene, &order, &job, &steering).unwrap();
    same(&last, &batch(&scene, &order));
    let told = told.into_inner().unwrap();
    // Nothing else is even roughly painted before, but for what is painted with a tile that meets the region.
    let wanted = tiles(150, 101).iter().filter(|tile| meets(tile)).count();
    let due = told.iter().filter(|(rect, side)| side.is_none() && meets(rect)).count();
    assert_eq!((wanted, due), (1, 1));
    let end = told.iter().position(|(rect, side)| side.is_none() && meets(rect)).unwrap();
    assert!(told[..end].iter().all(|(_, side)| side.is_some()));
    let beside = |&&(rect, side): &&(Rect, Option<u32>)| side.is_some_and(|side| side <= 32) && !meets(&rect);
    assert!(told[..end].iter().filter(beside).count() < told[end..].iter().filter(beside).count() / 4);
}

#[test]
fn the_region_can_be_moved_while_a_picture_refines() {
    let scene = scene(ROCK, CAMERAS[0], "samples: 1");
    let (steering, count) = (Steering::default(), AtomicUsize::new(0));
    let jump = |_: &Rough| {
        let i = count.fetch_add(1, Ordering::Relaxed) as u32;
        let region = Rect { x: i * 7 % 140, y: i * 5 % 90, width: 9, height: 9 };
        steering.focus((!i.is_multiple_of(3)).then_some(region));
    };
    let cancel = AtomicBool::new(false);
    let job = Job { rough: Some(&jump), ..Job::unwatched(&cancel) };
    let last = session::refine(&scene, &Order::default(), &job, &steering).unwrap();
    assert!(count.load(Ordering::Relaxed) > 20);
    same(&last, &batch(&scene, &Order::default()));
}

#[test]
fn no_tile_is_painted_over_by_a_worse_one() {
    let scene = scene(ROCK, CAMERAS[0], "samples: 1");
    let steering = Steering::default();
    let best: Mutex<Vec<u32>> = Mutex::new(vec![u32::MAX; 150 * 101]);
    let paint = |rect: &Rect, side: u32| {
        let mut best = best.lock().unwrap();
        for (x, y) in (rect.y..rect.bottom()).flat_map(|y| (rect.x..rect.right()).map(move |x| (x, y))) {
            let own = &mut best[(y * 150 + x) as usize];
            assert!(side <= *own, "{side} over {own}");
            *own = side;
        }
        steering.focus(Some(Rect { x: rect.x, y: rect.y, width: 1, height: 1 }));
    };
    let rough = |tile: &Rough| paint(&tile.rect, tile.side);
    let finished = |tile: &Fine<'_>| paint(&tile.rect, 0);
    let cancel = AtomicBool::new(false);
    let job = Job { rough: Some(&rough), tile: &finished, ..Job::unwatched(&cancel) };
    for threads in [1, 4] {
        best.lock().unwrap().fill(u32::MAX);
        let order = Order { threads: NonZeroUsize::new(threads), ..Order::default() };
        session::refine(&scene, &order, &job, &steering).unwrap();
        assert!(best.lock().unwrap().iter().all(|&side| side == 0));
    }
}

#[test]
fn a_cancelled_picture_stops_at_once() {
    let text = "scene(#{ surface: sphere(1.0) - 0.1 * gradient(7).scaled(6.0),
                         film: film(#{ width: 1600, height: 1200, samples: 64, bounces: 4 }) })";
    let scene = compile(&Request::text(text)).scene.unwrap();
    let stopped = |wait: u64| {
        let cancel = AtomicBool::new(false);
        std::thread::scope(|threads| {
            let job = Job { rough: Some(&|_| ()), ..Job::unwatched(&cancel) };
            let scene = &scene;
            let running = threads.spawn(move || {
                match session::refine(scene, &Order::default(), &job, &Steering::default()) {
                    Ok(picture) => assert!(!picture.finished),
                    // Before the first ray there is no picture to give.
                    Err(stopped) => assert_eq!(stopped.message, "stopped before it was finished"),
                }
                Instant::now()
            });
            std::thread::sleep(Duration::from_millis(wait));
            let asked = Instant::now();
            cancel.store(true, Ordering::SeqCst);
            running.join().unwrap().saturating_duration_since(asked)
        })
    };
    for wait in [30, 200, 400] {
        // Machines that run tests are busy: once in a while it has to be quick, and not by as much as is promised.
        let best = (0..5).map(|_| stopped(wait)).min().unwrap();
        assert!(best < Duration::from_millis(200), "{best:?} after {wait} ms");
    }
}

/// Bundles of lines through a surface, by both ways.
#[track_caller]
fn what_is_free_is_free(build: fn(&mut Build) -> NodeId, ways: &[Kind]) {
    let mut b = Build::default();
    let root = build(&mut b);
    let field = b.field(root);
    let region = Aabb::cube(1.6);
    let cells = Arc::new(Cells::new(field.tape().clone(), &region.intervals()));
    let mut rng = StdRng::seed_from_u64(9);
    let tolerance = Tolerance::fixed(1e-6);
    let (mut gained, mut free, mut met) = (0.0, 0, 0);
    for i in 0..60 {
        let mut number = |from: f64, to: f64| rng.random_range(from..to);
        let eye = DVec3::new(number(-3.0, 3.0), number(-1.0, 3.0), 4.0);
        let axis = (DVec3::new(number(-0.5, 0.5), number(-0.5, 0.5), 0.0) - eye).normalize();
        let across = axis.any_orthonormal_vector();
        let across = [across, axis.cross(across)];
        let is_parallel = i % 3 == 0;
        let frame = match is_parallel {
            true => Frame::parallel(eye, axis, across, 2.0),
            false => Frame::from_point(eye, axis, across),
        };
        let width = 0.4 / f64::from(1 << (i % 5));
        let corner = [number(-0.4, 0.4), number(-0.4, 0.4)];
        let rectangle = corner.map(|c| [c, c + width]);
        let rays: Vec<Ray> = (0..200)
            .filter_map(|_| {
                let [x, y] = corner.map(|c| c + width * number(0.0, 1.0));
                let aside = x * across[0] + y * across[1];
                let (origin, direction) =
                    if is_parallel { (eye + aside, axis) } else { (eye, (axis + aside).normalize()) };
                let (near, far) = region.clip(origin, direction).filter(|(_, far)| *far > 0.0)?;
                Some(Ray { origin, direction, near: near.max(0.0), far, tolerance })
            })
            .collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut cast = caster(Kind::Affine, &field, &region, &[]).unwrap();
        cast.first_hits(&rays, &mut hits, &mut CastStats::default(), &AtomicBool::new(false));
        for &way in ways {
            let made = caster(way, &field, &region, &[]).unwrap();
            let mut reach = reach(&*made, &region, &cells);
            let Some(mut bundle) = Bundle::new(&frame, rectangle, &region, (64, tolerance)) else {
                assert!(rays.is_empty(), "a bundle that is in the region");
                continue;
            };
            let begun = bundle.free();
            reach.advance(&mut [&mut bundle], &mut CastStats::default(), &AtomicBool::new(false));
            gained += bundle.free() - begun;
            free += u32::from(bundle.is_free());
            for (ray, hit) in rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
                met += 1;
                let depth = (ray.at(hit.t) - eye).dot(axis);
                assert!(!bundle.is_free(), "{way:?} {i}: met at {depth}");
                assert!(depth >= bundle.free() - 2e-6, "{way:?} {i}: {depth} before {}", bundle.free());
            }
        }
    }
    assert!(gained > 10.0 && free > 0 && met > 1000, "{gained} {free} {met}");
}

#[test]
fn bundles_of_lines_through_rock() {
    what_is_free_is_free(common::three_octaves, &[Kind::Beam, Kind::Speculative]);
}

#[test]
fn bundles_of_lines_through_carved_balls() {
    what_is_free_is_free(common::balls, &[Kind::Beam, Kind::Speculative]);
}

#[test]
fn bundles_of_lines_through_ridges_without_a_bound() {
    what_is_free_is_free(common::square_root_ridges, &[Kind::Beam]);
}
