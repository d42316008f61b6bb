//! What samples of a filter cost, by the way in which its distribution is inverted: table 6.1 of the
//! thesis, which has 9 million samples of the cubic spline, 300 x 300 pixels with 10 x 10 each.
//!
//! `cargo bench --bench filters` prints a markdown table: nanoseconds for a sample of two coordinates,
//! seconds for 9 million, and how many times as fast as the thesis' way that is.

use orogen::num::{BSpline, Quantiles, Radial, cos_turns, mix, sin_turns, uniform};
use std::hint::black_box;
use std::time::Instant;

/// Samples along each axis of a pixel.
const STRATA: u32 = 10;

/// Pixels that are sampled.
const PIXELS: u64 = 64;

const REPEATS: usize = 20;

/// The distribution as the thesis computes it, by the definition; exponential in the order.
fn recursive(order: u32, x: f64) -> f64 {
    if order == 1 {
        return x.clamp(0.0, 1.0);
    }
    let share = x / f64::from(order);
    share * recursive(order - 1, x) + (1.0 - share) * recursive(order - 1, x - 1.0)
}

/// Newton's method from the middle to the end.
fn newton(order: u32, y: f64, at: impl Fn(f64) -> [f64; 2]) -> f64 {
    let mut x = 0.5 * f64::from(order);
    if y == 0.0 {
        return 0.0;
    }
    loop {
        let [distribution, density] = at(x);
        let step = (distribution - y) / density;
        x -= step;
        if step.abs() < 1e-8 {
            return x;
        }
    }
}

/// The strata of some pixels, jittered.
fn strata() -> Vec<[f64; 2]> {
    let jittered = |hash: u64, stratum: u32| (f64::from(stratum) + uniform(hash)) / f64::from(STRATA);
    let of_pixel = |pixel: u64| {
        (0..STRATA * STRATA).map(move |i| {
            let hash = mix(mix(pixel) ^ u64::from(i));
            [jittered(hash, i % STRATA), jittered(mix(hash), i / STRATA)]
        })
    };
    (0..PIXELS).flat_map(of_pixel).collect()
}

/// Least time of a sample, in nanoseconds.
fn time(at: &[[f64; 2]], place: impl Fn([f64; 2]) -> [f64; 2]) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..REPEATS {
        let start = Instant::now();
        for u in at {
            black_box(place(black_box(*u)));
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    best * 1e9 / at.len() as f64
}

fn main() {
    let at = strata();
    println!("| order | method | ns a sample | s for 9 million | times as fast |");
    println!("|---|---|---|---|---|");
    for spline in [4, 8].into_iter().filter_map(BSpline::new) {
        let order = spline.order();
        let naive = |x: f64| {
            let [p, q] = [recursive(order - 1, x), recursive(order - 1, x - 1.0)];
            let share = x / f64::from(order);
            [share * p + (1.0 - share) * q, p - q]
        };
        let by_naive = |u: [f64; 2]| u.map(|y| newton(order, y, naive));
        let by_triangle = |u: [f64; 2]| u.map(|y| newton(order, y, |x| spline.by_recurrence(x)));
        let by_pieces = |u: [f64; 2]| u.map(|y| newton(order, y, |x| spline.at(x)));
        let table = Quantiles::new(spline);
        let radial = Radial::new(spline);
        let turned = |u: [f64; 2]| {
            let distance = radial.at(u[0]);
            [distance * cos_turns(u[1]), distance * sin_turns(u[1])]
        };
        let thesis = time(&at, by_naive);
        let row = |method: &str, ns: f64| {
            println!("| {order} | {method} | {ns:.1} | {:.3} | {:.1} |", ns * 9e-3, thesis / ns);
        };
        row("recursion, Newton", thesis);
        row("triangular scheme, Newton", time(&at, by_triangle));
        if order <= 4 {
            row("closed form, Newton", time(&at, by_pieces));
        }
        row("closed tails, Newton", time(&at, |u| u.map(|y| spline.quantile(y))));
        row("table", time(&at, |u| u.map(|y| table.at(y))));
        row("isotropic, table", time(&at, turned));
    }
}
