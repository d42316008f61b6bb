//! Speed of shapes: `cargo bench --bench shape [-- TRIANGLES]` prints markdown tables; at most so many
//! triangles, else a million.
//!
//! Signed distances to texts and springs, at points anywhere around them, and to a bumpy ball of triangles.
//! Building takes seconds of all threads, as the clock has it; a question takes nanoseconds of one thread,
//! the least of a few repeats, in batches of 64. Points are anywhere in the box around the mesh, along the
//! rows of a picture through it, or near its surface; or a million of them anywhere, asked for all at once.

#[allow(dead_code)] // of the view only the stopwatch is needed
mod view;

use glam::DVec3;
use orogen::num::{Jets, Kernel, Order};
use orogen::shape::curve::{self, Curve};
use orogen::shape::outline::{Align, Font, Layout, Outline};
use orogen::shape::{Distance, Mesh};
use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

const POINTS: usize = 1 << 17;
const MILLION: usize = 1 << 20;
const BATCH: usize = 64;
const REPEATS: usize = 3;

/// A ball with bumps of three sizes, of a cube's six faces with `n` by `n` squares each.
fn ball(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let turn = |face: u32, [u, v]: [f64; 2]| match face {
        0 => [1.0, u, v],
        1 => [-1.0, v, u],
        2 => [v, 1.0, u],
        3 => [u, -1.0, v],
        4 => [u, v, 1.0],
        _ => [v, u, -1.0],
    };
    for face in 0..6 {
        let start = mesh.points.len() as u32;
        for (i, j) in (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))) {
            let at = [i, j].map(|k| 2.0 * f64::from(k) / f64::from(n) - 1.0);
            let d = DVec3::from(turn(face, at)).normalize();
            let bump = |k: f64| libm::sin(k * d.x) * libm::cos(1.4 * k * d.y) + libm::sin(1.2 * k * d.z);
            mesh.points.push(d * (1.0 + 0.1 * bump(5.0) + 0.03 * bump(19.0) + 0.004 * bump(120.0)));
            if i < n && j < n {
                let a = start + j * (n + 1) + i;
                mesh.triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
            }
        }
    }
    mesh
}

/// Points of some kind.
struct Kind {
    name: &'static str,
    at: Vec<DVec3>,
    /// How many are asked for at once.
    batch: usize,
}

/// Random numbers from 0 to 1.
fn random() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Points of all kinds about a mesh.
fn kinds(mesh: &Mesh) -> [Kind; 4] {
    let (lo, hi) = mesh.bounds().expect("a mesh with points");
    let mut next = random();
    let at_once: Vec<_> = (0..MILLION).map(|_| lo + (hi - lo) * DVec3::new(next(), next(), next())).collect();
    let anywhere = at_once[..POINTS].to_vec();
    let row = |i: usize| DVec3::new((i % 512) as f64 / 512.0, (i / 512) as f64 / (POINTS / 512) as f64, 0.37);
    let rows = (0..POINTS).map(|i| lo + (hi - lo) * row(i)).collect();
    let near = |i: usize| mesh.points[i * 4 % mesh.points.len()];
    let near = (0..POINTS).map(|i| near(i) * (0.99 + 0.02 * next())).collect();
    [
        Kind { name: "anywhere", at: anywhere, batch: BATCH },
        Kind { name: "anywhere, at once", at: at_once, batch: MILLION },
        Kind { name: "in rows", at: rows, batch: BATCH },
        Kind { name: "near", at: near, batch: BATCH },
    ]
}

/// Nanoseconds a point, for jets up to an order.
fn time(field: &dyn Kernel, Kind { at, batch, .. }: &Kind, order: Order) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis| at.iter().map(|p| p[axis]).collect::<Vec<f64>>());
    let mut to: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; *batch]);
    let mut least = f64::INFINITY;
    for _ in 0..REPEATS {
        let watch = view::Stopwatch::start();
        for start in (0..at.len()).step_by(*batch) {
            let part = start..start + batch;
            let [value, gx, gy, gz] = &mut to;
            let grad = (order >= Order::Gradient).then_some([&mut gx[..], gy, gz]);
            field.jets([&x[part.clone()], &y[part.clone()], &z[part]], Jets { value, grad, hess: None });
            black_box(&to);
        }
        least = least.min(watch.seconds());
    }
    least * 1e9 / at.len() as f64
}

/// Nanoseconds for what is known of a ball around a point.
fn time_of_balls(field: &dyn Kernel, at: &[DVec3], radius: f64) -> f64 {
    let some = &at[..POINTS / 8];
    let watch = view::Stopwatch::start();
    for p in some {
        black_box(field.local(Order::Gradient, p.to_array(), radius));
    }
    watch.seconds() * 1e9 / some.len() as f64
}

/// A text of so many letters, in lines of thirty.
fn text(letters: usize) -> Outline {
    let text: String = "orogen makes solids of noise. ".chars().cycle().take(letters).collect();
    let lines: Vec<&str> =
        text.as_bytes().chunks(30).filter_map(|line| std::str::from_utf8(line).ok()).collect();
    let font = Font::new(dejavu::sans::regular()).expect("a font");
    let layout = Layout { size: 1.0, align: Align::Left, leading: 1.2 };
    Outline::new(font.write(&lines.join("\n"), &layout)).expect("letters")
}

/// A spring through so many points, ten to a turn.
fn spring(points: u32) -> Curve {
    let at = |i: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / 10.0);
        DVec3::new(cos, 0.05 * f64::from(i), sin)
    };
    let points: Vec<DVec3> = (0..points).map(at).collect();
    Curve::new(&points, &[0.1], curve::Kind::CatmullRom, false).expect("a curve")
}

/// A row of the table of shapes made of curves, at points all about the box that holds one.
fn row<K: Kernel>(name: &str, make: impl FnOnce() -> K, (lo, hi): (DVec3, DVec3)) {
    let start = Instant::now();
    let field = make();
    let made = start.elapsed().as_secs_f64();
    let mut next = random();
    let room = 0.5 * (hi - lo).max_element();
    let mut point = || lo - room + (hi - lo + 2.0 * room) * DVec3::new(next(), next(), next());
    let at: Vec<DVec3> = (0..POINTS).map(|_| point()).collect();
    let ball = time_of_balls(&field, &at, 0.01);
    let kind = Kind { name: "", at, batch: BATCH };
    let [value, gradient] = [Order::Value, Order::Gradient].map(|order| time(&field, &kind, order));
    println!("| {name} | {made:.4} | {value:.0} | {gradient:.0} | {ball:.0} |");
}

fn strands() {
    println!("| shape | made, s | value, ns | value and gradient, ns | a ball of 0.01, ns |");
    println!("|---|---|---|---|---|");
    for letters in [6_usize, 60, 600] {
        let (lines, width) = (letters.div_ceil(30) as f64, letters.min(30) as f64);
        let (lo, hi) = (DVec3::new(0.0, 1.0 - 1.2 * lines, 0.0), DVec3::new(0.6 * width, 0.8, 0.0));
        row(&format!("text, {letters} letters"), || text(letters), (lo, hi));
    }
    for points in [80, 800] {
        let top = DVec3::new(1.0, 0.05 * f64::from(points), 1.0);
        row(&format!("spring, {points} points"), || spring(points), (DVec3::new(-1.0, 0.0, -1.0), top));
    }
    println!();
}

fn main() -> ExitCode {
    let told = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let Ok(most) = told.as_ref().map_or(Ok(1_000_000), |m| m.parse::<u32>()) else {
        eprintln!("`{}` is no number of triangles", told.unwrap_or_default());
        return ExitCode::FAILURE;
    };
    strands();
    println!("| triangles | built, s | points | value, ns | value and gradient, ns | a ball of 0.01, ns |");
    println!("|---|---|---|---|---|---|");
    for triangles in [1000, 10_000, 100_000, 1_000_000, 10_000_000].into_iter().filter(|&t| t <= most) {
        let mesh = ball(f64::from(triangles / 12).sqrt() as u32);
        let start = Instant::now();
        let field = Distance::new(&mesh).expect("a mesh that can be measured");
        let built = start.elapsed().as_secs_f64();
        for kind in kinds(&mesh) {
            let [value, gradient] = [Order::Value, Order::Gradient].map(|order| time(&field, &kind, order));
            let ball = time_of_balls(&field, &kind.at, 0.01);
            println!(
                "| {} | {built:.3} | {} | {value:.0} | {gradient:.0} | {ball:.0} |",
                mesh.triangles.len(),
                kind.name
            );
        }
    }
    ExitCode::SUCCESS
}
