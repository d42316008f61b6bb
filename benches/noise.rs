//! Speed of noises: `cargo bench --bench noise` prints a markdown table of nanoseconds a point.
//!
//! Every figure is the least of many repeats on one core, over points in cache and scattered over
//! thousands of lattice cells. Bulk evaluation is at unit frequency; other libraries take one point a
//! call. A kind of noise that is added is measured by being in the list.

use orogen::noise::{Allowed, Fractal, Gradient, Kind, Model, Noise, Recipe, Setting, Settings, Signal};
use orogen::num::{Dual, Jets, Kernel, Level, Many, Number, Order, limit_simd, simd_level};
use std::hint::black_box;
use std::time::Instant;

const POINTS: usize = 4096;
const REPEATS: usize = 200;
const LANES: usize = 64;

/// Least time of `job`, in nanoseconds a point.
fn time(mut job: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..REPEATS {
        let start = Instant::now();
        job();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best * 1e9 / POINTS as f64
}

fn points() -> [Vec<f64>; 3] {
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 * 200.0 - 100.0
    };
    std::array::from_fn(|_| (0..POINTS).map(|_| next()).collect())
}

/// Bulk evaluation: value, gradient, Hessian.
fn bulk(noise: &Noise, at: &[Vec<f64>; 3]) -> [f64; 3] {
    let mut to: [Vec<f64>; 10] = std::array::from_fn(|_| vec![0.0; POINTS]);
    [Order::Value, Order::Gradient, Order::Hessian].map(|order| {
        time(|| {
            let [v, x, y, z, xx, yy, zz, xy, xz, yz] = &mut to;
            let out = Jets {
                value: v,
                grad: (order >= Order::Gradient).then_some([&mut x[..], y, z]),
                hess: (order >= Order::Hessian).then_some([&mut xx[..], yy, zz, xy, xz, yz]),
            };
            noise.kind.jets(&noise.lattice, [&at[0], &at[1], &at[2]], out);
            black_box(&to);
        })
    })
}

fn single(noise: &Noise, at: &[Vec<f64>; 3]) -> [f64; 3] {
    [Order::Value, Order::Gradient, Order::Hessian].map(|order| {
        time(|| {
            for i in 0..POINTS {
                black_box(noise.jet(order, black_box([at[0][i], at[1][i], at[2][i]])));
            }
        })
    })
}

/// Textbook gradient noise, one point at a time, to compare with.
fn textbook([x, y, z]: [f64; 3], seed: u64) -> f64 {
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let cell = [x.floor(), y.floor(), z.floor()];
    let d = [x - cell[0], y - cell[1], z - cell[2]];
    let corner = |c: usize| {
        let bit = [c & 1, c >> 1 & 1, c >> 2];
        let mut h = seed;
        for axis in 0..3 {
            h = (h ^ (cell[axis] as i64 + bit[axis] as i64) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            h ^= h >> 29;
        }
        let (u, v) = [(0, 1), (0, 2), (1, 2)][(h >> 8) as usize % 3];
        let sign = |bit: u64| if h >> bit & 1 == 0 { 1.0 } else { -1.0 };
        sign(0) * (d[u] - bit[u] as f64) + sign(1) * (d[v] - bit[v] as f64)
    };
    let lerp = |a: f64, b: f64, t: f64| a + t * (b - a);
    let [s, t, r] = d.map(fade);
    let along = |c: usize| lerp(corner(c), corner(c + 1), s);
    lerp(lerp(along(0), along(2), t), lerp(along(4), along(6), t), r)
}

/// A function of a point, one call a point.
fn calls(at: &[Vec<f64>; 3], f: impl Fn([f64; 3]) -> f64) -> f64 {
    time(|| {
        for i in 0..POINTS {
            black_box(f(black_box([at[0][i], at[1][i], at[2][i]])));
        }
    })
}

/// Other libraries, values only, and how they compare with a bulk evaluation here.
fn rivals(at: &[Vec<f64>; 3]) {
    use fastnoise_lite::{FastNoiseLite, NoiseType};
    use libnoise::{Generator, Source};
    use noise::NoiseFn;
    let [gradient, ..] = bulk(&Noise::new(Kind::Gradient(Gradient::EDGES), 7), at);
    let row = |name: &str, ns: f64| println!("| {name} | {ns:.1} | {:.1} |", ns / gradient);
    println!("| rivals, ns a point | value | to gradient noise in bulk |\n|---|---|---|");
    row("textbook gradient noise", calls(at, |p| textbook(p, 7)));
    let (perlin, value, simplex) = (noise::Perlin::new(7), noise::Value::new(7), noise::Simplex::new(7));
    row("noise 0.9, Perlin", calls(at, |p| perlin.get(p)));
    row("noise 0.9, Value", calls(at, |p| value.get(p)));
    row("noise 0.9, Simplex", calls(at, |p| simplex.get(p)));
    let (perlin, improved) = (Source::<3>::perlin(7), Source::<3>::improved_perlin(7));
    let (value, simplex) = (Source::<3>::value(7), Source::<3>::simplex(7));
    row("libnoise 1.2, perlin", calls(at, |p| perlin.sample(p)));
    row("libnoise 1.2, improved_perlin", calls(at, |p| improved.sample(p)));
    row("libnoise 1.2, value", calls(at, |p| value.sample(p)));
    row("libnoise 1.2, simplex", calls(at, |p| simplex.sample(p)));
    for (name, kind) in [
        ("Perlin", NoiseType::Perlin),
        ("Value", NoiseType::Value),
        ("OpenSimplex2", NoiseType::OpenSimplex2),
        ("Cellular", NoiseType::Cellular),
    ] {
        let mut rival = FastNoiseLite::with_seed(7);
        rival.set_frequency(Some(1.0));
        rival.set_noise_type(Some(kind));
        let single = |[x, y, z]: [f64; 3]| f64::from(rival.get_noise_3d(x as f32, y as f32, z as f32));
        row(&format!("fastnoise-lite 1.1 in f32, {name}"), calls(at, single));
    }
    println!();
}

/// A fractal over batches of some number.
fn fractal<T: Copy>(
    f: &Fractal,
    at: &[Vec<f64>; 3],
    footprint: Option<f64>,
    make: impl Fn(f64, usize) -> T,
) -> f64
where
    Many<T, LANES>: Number,
{
    let axis = |k: usize| -> Vec<Many<T, LANES>> {
        at[k].chunks_exact(LANES).map(|c| Many(std::array::from_fn(|i| make(c[i], k)))).collect()
    };
    let [x, y, z] = [0, 1, 2].map(axis);
    // From a pixel to twice its size.
    let prints: Option<Vec<_>> =
        footprint.map(|s| x.iter().map(|x| x.scale(s / 400.0).shift(1.5 * s)).collect());
    time(|| {
        for i in 0..x.len() {
            black_box(f.eval([&x[i], &y[i], &z[i]], prints.as_ref().map(|s| &s[i])));
        }
    })
}

/// Every kind of noise as it is unless told otherwise, and with each of its choices and flags.
fn settings() -> Vec<(String, Kind)> {
    let mut all = Vec::new();
    for listing in Kind::ALL {
        all.push((listing.name.to_string(), listing.plain()));
        for parameter in listing.parameters {
            let others: Vec<Setting> = match parameter.allowed {
                Allowed::Choice(names) => names[1..].iter().map(|name| Setting::Name(name)).collect(),
                Allowed::Flag { default } => vec![Setting::Flag(!default)],
                _ => Vec::new(),
            };
            for other in others {
                let mut settings = Settings::new(listing.parameters);
                settings.set(parameter.name, other).expect("a value from the table");
                let told = match other {
                    Setting::Name(name) => name.to_string(),
                    _ => parameter.name.to_string(),
                };
                all.push((format!("{}, {told}", listing.name), (listing.build)(&settings)));
            }
        }
    }
    all
}

fn kinds(at: &[Vec<f64>; 3], level: Level) {
    println!("| {level:?}, ns a point | value | gradient | Hessian | value, to gradient noise |");
    println!("|---|---|---|---|---|");
    let mut reference = None;
    for (name, kind) in settings() {
        let [v, g, h] = bulk(&Noise::new(kind, 7), at);
        let reference = *reference.get_or_insert(v);
        println!("| {name} | {v:.2} | {g:.2} | {h:.2} | {:.2} |", v / reference);
    }
    println!();
}

fn main() {
    let at = points();
    let machine = simd_level();
    for level in [Level::Avx512, Level::Avx2, Level::Baseline].into_iter().filter(|&l| l <= machine) {
        kinds(&at, limit_simd(level));
    }
    limit_simd(machine);

    println!("| one at a time, ns a point | value | gradient | Hessian |\n|---|---|---|---|");
    for (name, kind) in settings() {
        let [v, g, h] = single(&Noise::new(kind, 7), &at);
        println!("| {name} | {v:.1} | {g:.1} | {h:.1} |");
    }
    println!();
    rivals(&at);

    println!(
        "| 9 octaves, ns a point | value | over 9 of 1 octave | gradient | over 9 of 1 octave |\n|---|---|---|---|---|"
    );
    let noise = Noise::new(Kind::Gradient(Gradient::EDGES), 7);
    for (model, rotate) in Model::all().flat_map(|m| [(m, false), (m, true)]) {
        let sum = |octaves| {
            let recipe = Recipe { octaves, lacunarity: 2.07, rotate, ..Recipe::new(noise, model) };
            Fractal::new(recipe).expect("a valid recipe")
        };
        let turned = if rotate { ", rotated" } else { "" };
        let signal = if model.signal == Signal::Plain { "" } else { model.signal.name() };
        let (one, nine) = (sum(1), sum(9));
        for (print, fading) in [(None, ""), (Some(0.004), ", half of them fading")] {
            let [value, one_value] = [&nine, &one].map(|f| fractal(f, &at, print, |x, _| x));
            let [gradient, one_gradient] = [&nine, &one].map(|f| fractal(f, &at, print, Dual::coordinate));
            let (v, g) = (value / (9.0 * one_value), gradient / (9.0 * one_gradient));
            println!(
                "| {} {signal}{turned}{fading} | {value:.1} | {v:.2} | {gradient:.1} | {g:.2} |",
                model.name()
            );
        }
    }
}
