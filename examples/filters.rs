//! Filters of pictures as curves: `cargo run --release --example filters -- docs/figures` writes `6.05a.png`, B-splines of
//! several orders, `6.05b.png`, their spectra beside that of an ideal filter, `6.06.png`, where a hundred samples of a
//! pixel lie with the cubic one, and `6.10.png`, the steps that Newton's method takes to invert its distribution.

use orogen::analysis::plot::{Axis, Curves, Line};
use orogen::num::{BSpline, sequence};
use orogen::render::Filter;
use orogen::world::atomic;
use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;

const ORDERS: [u32; 4] = [1, 2, 4, 20];

fn axis(label: &str, range: (f64, f64)) -> Axis {
    Axis { label: label.to_owned(), range, logarithmic: false }
}

fn line(label: String, range: (f64, f64), f: impl Fn(f64) -> f64) -> Line {
    let points = (0..=800).map(|i| range.0 + (range.1 - range.0) * f64::from(i) / 800.0).map(|t| (t, f(t)));
    Line { label, points: points.collect(), guide: false }
}

fn guide(points: Vec<(f64, f64)>) -> Line {
    Line { label: String::new(), points, guide: true }
}

/// The B-spline of an order that there is.
fn spline(order: u32) -> Result<BSpline, Box<dyn Error>> {
    BSpline::new(order).ok_or_else(|| format!("there is no B-spline of order {order}").into())
}

/// The B-splines around their middles.
fn densities() -> Result<Curves, Box<dyn Error>> {
    let mut lines = Vec::new();
    for order in ORDERS {
        let spline = spline(order)?;
        let middle = 0.5 * f64::from(order);
        lines.push(line(format!("order {order}"), (-4.0, 4.0), |x| spline.density(x + middle)));
    }
    let (x, y) = (axis("pixels", (-4.0, 4.0)), axis("density", (0.0, 1.1)));
    Ok(Curves { title: "B-splines".to_owned(), x, y, lines })
}

/// The magnitudes of their spectra, `|sin(pi k) / (pi k)|^m`, and that of a filter that lets through what pixels can show.
fn spectra() -> Curves {
    let sinc = |k: f64| if k == 0.0 { 1.0 } else { (libm::sin(PI * k) / (PI * k)).abs() };
    let of =
        |order: u32| line(format!("order {order}"), (0.0, 3.0), move |k| libm::pow(sinc(k), order.into()));
    let ideal = guide(vec![(0.0, 1.0), (0.5, 1.0), (0.5, 0.0)]);
    let lines = ORDERS.into_iter().map(of).chain([ideal]).collect();
    let (x, y) = (axis("cycles a pixel", (0.0, 3.0)), axis("magnitude", (0.0, 1.1)));
    Curves { title: "Spectra of B-splines".to_owned(), x, y, lines }
}

/// Samples of one pixel among its neighbours, as small crosses.
fn pattern() -> Result<Curves, Box<dyn Error>> {
    let filter = Filter::new(4, false)?;
    let half = 0.03;
    let cross = |index: u32| {
        let [x, y] = filter.place(sequence::point(7, index, 0));
        let points = vec![(x - half, y), (x + half, y), (x, y), (x, y + half), (x, y - half)];
        Line { label: String::new(), points, guide: false }
    };
    let edges = (-2..=2).map(f64::from).flat_map(|c| {
        let (c, end) = (c + 0.5, 2.5);
        [vec![(c, -end), (c, end)], vec![(-end, c), (end, c)]].map(guide)
    });
    let lines = edges.chain((0..100).map(cross)).collect();
    let sides = || axis("pixels", (-2.5, 2.5));
    Ok(Curves { title: "100 samples of a pixel".to_owned(), x: sides(), y: sides(), lines })
}

/// Steps of Newton's method from the middle, as the thesis counts them.
fn steps() -> Result<Curves, Box<dyn Error>> {
    let cubic = spline(4)?;
    let count = |y: f64| {
        let (mut x, mut steps) = (2.0, 0.0);
        loop {
            let [distribution, density] = cubic.at(x);
            let step = (distribution - y) / density;
            (x, steps) = (x - step, steps + 1.0);
            if step.abs() < 1e-8 || steps > 100.0 {
                return steps;
            }
        }
    };
    let points: Vec<(f64, f64)> = (1..1000).map(|i| f64::from(i) / 1000.0).map(|y| (y, count(y))).collect();
    let mean = points.iter().map(|point| point.1).sum::<f64>() / points.len() as f64;
    let title = format!("Steps to invert the distribution, {mean:.2} on average");
    let lines = vec![Line { label: String::new(), points, guide: false }];
    Ok(Curves { title, x: axis("probability", (0.0, 1.0)), y: axis("steps", (0.0, 11.0)), lines })
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".to_owned());
    let figures = [("6.05a", densities()?), ("6.05b", spectra()), ("6.06", pattern()?), ("6.10", steps()?)];
    for (number, curves) in figures {
        let figure = curves.draw(560)?;
        atomic::write(&Path::new(&folder).join(format!("{number}.png")), |f| figure.write_png(f))?;
    }
    Ok(())
}
