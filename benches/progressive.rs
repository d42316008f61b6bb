//! Table 7.1 of Gamito, *Techniques for Stochastic Implicit Surface Modelling and Rendering* (2009), by our own
//! means; how soon pictures that refine show something, and when they are finished; and how soon they stop when they are to.
//!
//! The previewer of the thesis takes tiles forwards until they are a pixel wide, and goes on from there by rays. Here
//! that is done with either way to take tiles forwards, followed by speculative sphere tracing as in the source,
//! and by beams. Pictures that are refined by `render::refine` share nothing between rough and finished tiles: what
//! that costs is the second table.
//!
//! `cargo bench --bench progressive [-- SIZE] [ROW]...`, 400 pixels a side unless told otherwise; rows are figure-7.05 and so
//! on in the first table, and names of scenes in the others.

use orogen::cast::{Bundle, CastStats, Frame, Hit, Kind, Ray, Reach, caster, reach};
use orogen::field::Field;
use orogen::render::{Fine, Job, Prepared, Rect, Rough, Settings, Steering, prepare};
use orogen::scene::{Aabb, Scene};
use orogen::script::{Request, Script, compile};
use orogen::session::{self, Order, Session};
use orogen::world::Disk;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Figures, and what the source has for them: evaluations of the previewer over those of speculative and of plain
/// sphere tracing.
const PUBLISHED: [(&str, [f64; 2]); 3] =
    [("7.05", [0.87, 0.60]), ("7.06", [0.53, 0.36]), ("7.07", [0.59, 0.46])];

fn scene(path: &str) -> Scene {
    let compiled = compile(&Request::new(Script::File(path.into()), Arc::new(Disk)));
    compiled.scene.unwrap_or_else(|| panic!("{path}: {:?}", compiled.diagnostics))
}

fn main() {
    let told: Vec<String> = std::env::args().skip(1).filter(|told| !told.starts_with('-')).collect();
    let size = told.iter().find_map(|told| told.parse::<u32>().ok()).unwrap_or(400).clamp(16, 4096);
    let names: Vec<&String> = told.iter().filter(|told| told.parse::<u32>().is_err()).collect();
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| *wanted == name);
    println!("Evaluations of the field, {size}x{size} pixels, one ray each:\n");
    println!(
        "| figure | sphere | speculative | auto | balls, then speculative | of speculative (printed) | of sphere (printed) \
         | bands, then beams | of auto |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (figure, printed) in
        PUBLISHED.into_iter().filter(|(figure, _)| is_wanted(&format!("figure-{figure}")))
    {
        previewer(figure, printed, size);
    }
    println!("\nSeconds from the call, one sample a pixel, on {} threads:\n", rayon::current_num_threads());
    println!("| scene | first tile | 128 | 64 | 32 | 16 | 8 | all | at once | more |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for name in
        ["planet", "figures/7.05", "figures/7.07", "figures/5.10", "sea", "machine", "asteroid", "organ"]
            .into_iter()
            .filter(|name| is_wanted(name))
    {
        timeline(name);
    }
    println!(
        "\nMilliseconds until a picture that is cancelled stops, asked for every 10 ms of the first second:\n"
    );
    println!("| scene | mean | worst | asked for after |");
    println!("|---|---|---|---|");
    for name in ["planet", "canyon", "terrain", "blobs", "figures/7.06", "figures/9.09"]
        .into_iter()
        .filter(|name| is_wanted(name))
    {
        cancellations(name);
    }
}

/// A row of the first table.
fn previewer(figure: &str, [printed, of_sphere]: [f64; 2], size: u32) {
    let view = View::new(&scene(&format!("scripts/figures/{figure}.rhai")), size);
    let whole = |kind| view.cast(kind, &view.rays(|_, _| 0.0)).evaluations;
    let [sphere, speculative, auto] = [Kind::Sphere, Kind::Speculative, Kind::Auto].map(whole);
    let by_balls = view.refine(Kind::Speculative, Kind::Speculative);
    let by_bands = view.refine(Kind::Beam, Kind::Beam);
    let ratio = |a: u64, b: u64| a as f64 / b as f64;
    println!(
        "| {figure} | {sphere} | {speculative} | {auto} | {by_balls} | {:.2} ({printed}) | {:.2} ({of_sphere}) | {by_bands} | {:.2} |",
        ratio(by_balls, speculative),
        ratio(by_balls, sphere),
        ratio(by_bands, auto),
    );
}

/// A square picture of a scene.
struct View {
    scene: Prepared,
    bounds: Aabb,
    size: u32,
}

impl View {
    fn new(scene: &Scene, size: u32) -> View {
        let order = Order { size: Some((size, size)), samples: Some(1), ..Order::default() };
        let settings: Settings = session::settings(scene, &order).expect("settings");
        View {
            scene: prepare(scene, &settings, &AtomicBool::new(false)).expect("a scene"),
            bounds: settings.bounds,
            size,
        }
    }

    /// Where the line of sight through a place meets the plane one unit deep.
    fn place(&self, x: u32, y: u32) -> [f64; 2] {
        let view = &self.scene.view;
        let (_, d) = view.ray(f64::from(x), f64::from(y), [0.5; 2]);
        [view.right, view.up].map(|axis| d.dot(axis) / d.dot(view.forward))
    }

    /// Rays through the pixels, tile by tile, each from a depth on; there is nothing on those that miss the bounds.
    fn rays(&self, from: impl Fn(u32, u32) -> f64) -> Vec<Ray> {
        let (view, tolerance) = (&self.scene.view, self.scene.tolerance);
        let tiles = orogen::render::tiles(self.size, self.size).into_iter();
        let pixels =
            tiles.flat_map(|tile| orogen::render::places(&tile).map(move |(x, y)| (tile.x + x, tile.y + y)));
        let ray = |(x, y): (u32, u32)| {
            let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, [0.5; 2]);
            let (near, far) = self.bounds.clip(origin, direction).unwrap_or((0.0, -1.0));
            let near = near.max(from(x, y) / direction.dot(view.forward));
            Ray { origin, direction, near, far, tolerance }
        };
        pixels.map(ray).collect()
    }

    fn cast(&self, kind: Kind, rays: &[Ray]) -> CastStats {
        let field = Field::of_tape(&self.scene.tape);
        let mut caster = caster(kind, &field, &self.bounds, &self.scene.typical_rays()).expect("a caster");
        let mut stats = CastStats::default();
        for group in rays.chunks(1024) {
            caster.first_hits(group, &mut vec![Hit::MISS; group.len()], &mut stats, &AtomicBool::new(false));
        }
        stats
    }

    /// Evaluations of tiles down to a pixel, and of the rays that go on from there.
    fn refine(&self, way: Kind, kind: Kind) -> u64 {
        let field = Field::of_tape(&self.scene.tape);
        let way = caster(way, &field, &self.bounds, &self.scene.typical_rays()).expect("a caster");
        let mut way = reach(&*way, &self.bounds, &self.scene.cells);
        let whole = Rect::whole(self.size, self.size);
        let mut depths = vec![f64::INFINITY; (self.size * self.size) as usize];
        let mut stats = CastStats::default();
        let start = |square: Rect| square.intersection(&whole).map(|rect| (square, rect));
        let squares = (0..whole.height).step_by(128).flat_map(|y| {
            (0..whole.width).step_by(128).filter_map(move |x| start(Rect { x, y, width: 128, height: 128 }))
        });
        let bundle = |rect: &Rect| {
            let own = (rect.area() as usize, self.scene.tolerance);
            Bundle::new(&self.frame(), self.rectangle(rect), &self.bounds, own)
        };
        let mut tiles: Vec<(Rect, Bundle)> =
            squares.filter_map(|(square, rect)| Some((square, bundle(&rect)?))).collect();
        while !tiles.is_empty() {
            tiles = self.step((&mut *way, &mut stats), tiles, &mut depths);
        }
        let rays = self.rays(|x, y| depths[(y * self.size + x) as usize]);
        stats.evaluations + self.cast(kind, &rays).evaluations
    }

    /// Takes tiles forwards, and gives their quarters; of pixels it notes the depth.
    fn step(
        &self,
        (way, stats): (&mut dyn Reach, &mut CastStats),
        tiles: Vec<(Rect, Bundle)>,
        depths: &mut [f64],
    ) -> Vec<(Rect, Bundle)> {
        let (squares, mut bundles): (Vec<Rect>, Vec<Bundle>) = tiles.into_iter().unzip();
        way.advance(&mut bundles.iter_mut().collect::<Vec<_>>(), stats, &AtomicBool::new(false));
        let whole = Rect::whole(self.size, self.size);
        let mut parts = Vec::new();
        for (square, bundle) in squares.iter().zip(&bundles).filter(|(_, bundle)| !bundle.is_free()) {
            let side = square.width / 2;
            if side == 0 {
                depths[(square.y * self.size + square.x) as usize] = bundle.free();
                continue;
            }
            for (x, y) in [(0, 0), (side, 0), (0, side), (side, side)] {
                let square = Rect { x: square.x + x, y: square.y + y, width: side, height: side };
                let Some(rect) = square.intersection(&whole) else { continue };
                let part =
                    bundle.part(&self.frame(), self.rectangle(&rect), &self.bounds, rect.area() as usize);
                parts.extend(part.map(|part| (square, part)));
            }
        }
        parts
    }

    fn frame(&self) -> Frame {
        let view = &self.scene.view;
        Frame::from_point(view.eye, view.forward, [view.right, view.up])
    }

    fn rectangle(&self, rect: &Rect) -> [[f64; 2]; 2] {
        let [left, top] = self.place(rect.x, rect.y);
        let [right, bottom] = self.place(rect.right(), rect.bottom());
        [[left, right], [bottom, top]]
    }
}

/// Seconds that something takes: the least of three times where that is little, since then it is at the mercy of
/// whatever else the machine does. It may be `known` of one time already.
fn quickest(known: Option<Duration>, work: impl Fn()) -> f64 {
    const SHORT: Duration = Duration::from_secs(2);
    let timed = || {
        let start = Instant::now();
        work();
        start.elapsed()
    };
    let mut least = known.unwrap_or_else(timed);
    if least < SHORT {
        least = least.min(timed()).min(timed());
    }
    least.as_secs_f64()
}

/// A row of the second table.
fn timeline(name: &str) {
    let scene = scene(&format!("scripts/{name}.rhai"));
    let size = if name == "planet" { Some((640, 360)) } else { None };
    let order = Order { size, samples: Some(1), ..Order::default() };
    let (cancel, told) = (AtomicBool::new(false), Mutex::new(BTreeMap::<u32, Duration>::new()));
    let start = Instant::now();
    let first = Mutex::new(None);
    let rough = |tile: &Rough| {
        first.lock().expect("a time").get_or_insert_with(|| start.elapsed());
        told.lock().expect("times").insert(tile.side, start.elapsed());
    };
    let tile = |_: &Fine<'_>| {
        first.lock().expect("a time").get_or_insert_with(|| start.elapsed());
    };
    let job = Job { rough: Some(&rough), tile: &tile, ..Job::unwatched(&cancel) };
    session::refine(&scene, &order, &job, &Steering::default()).expect("a picture");
    let all = quickest(Some(start.elapsed()), || {
        let job = Job { rough: Some(&|_| ()), ..Job::unwatched(&cancel) };
        session::refine(&scene, &order, &job, &Steering::default()).expect("a picture");
    });
    let once = quickest(None, || {
        session::render(&scene, &order, &Job::unwatched(&cancel)).expect("a picture");
    });
    let told = told.into_inner().expect("times");
    let at = |side: u32| told.get(&side).map_or("-".to_owned(), |time| format!("{:.3}", time.as_secs_f64()));
    let first = first.into_inner().expect("a time").map_or(0.0, |time: Duration| time.as_secs_f64());
    let sides: Vec<String> = [128, 64, 32, 16, 8].map(at).to_vec();
    println!(
        "| {name} | {first:.3} | {} | {all:.2} | {once:.2} | {:.1} % |",
        sides.join(" | "),
        100.0 * (all / once - 1.0)
    );
}

/// A row of the third table.
fn cancellations(name: &str) {
    let path = format!("scripts/{name}.rhai");
    let taken: Vec<(Duration, Duration)> =
        (0..100).map(|i| Duration::from_millis(10 * i)).map(|wait| (cancelled(&path, wait), wait)).collect();
    let mean = taken.iter().map(|(time, _)| time).sum::<Duration>() / taken.len() as u32;
    let (worst, wait) = taken.into_iter().max().expect("a time");
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    println!("| {name} | {:.1} | {:.1} | {:.0} |", ms(mean), ms(worst), ms(wait));
}

/// How long a script and its picture go on after they are asked to stop.
fn cancelled(path: &str, wait: Duration) -> Duration {
    let cancel = Arc::new(AtomicBool::new(false));
    std::thread::scope(|threads| {
        let running = threads.spawn({
            let cancel = cancel.clone();
            move || {
                let mut session = Session::new(path, Arc::new(Disk));
                if let Some(scene) = &session.load(&cancel).scene {
                    let order = Order { size: Some((1280, 720)), ..Order::default() };
                    let job = Job { rough: Some(&|_| ()), ..Job::unwatched(&cancel) };
                    // A picture that was stopped before it began is none.
                    let _ = session.refine(scene, &order, &job, (&Steering::default(), &cancel));
                }
                Instant::now()
            }
        });
        std::thread::sleep(wait);
        let asked = Instant::now();
        cancel.store(true, Ordering::SeqCst);
        running.join().expect("a picture").saturating_duration_since(asked)
    })
}
