//! The kernels of the noises as curves: `cargo run --release --example profiles -- docs/figures`
//! writes `4.04.png`, the quintic fade between two lattice nodes, and `4.09.png`, the kernels of sparse
//! convolution noise.

use orogen::analysis::plot::{Axis, Curves, Line};
use orogen::world::atomic;
use std::error::Error;
use std::path::Path;

/// The quintic fade, which falls from 1 to 0 with two derivatives that vanish at both ends.
fn quintic(t: f64) -> f64 {
    let t = t.abs().min(1.0);
    1.0 - t * t * t * (10.0 - t * (15.0 - 6.0 * t))
}

/// Lewis's raised cosine, whose second derivative jumps at 1.
fn lewis(t: f64) -> f64 {
    0.5 * (1.0 + libm::cos(std::f64::consts::PI * t.abs().min(1.0)))
}

fn line(label: &str, from: f64, f: fn(f64) -> f64) -> Line {
    let points = (0..=400).map(|i| from + (1.0 - from) * f64::from(i) / 400.0).map(|t| (t, f(t)));
    Line { label: label.to_owned(), points: points.collect(), guide: false }
}

fn axis(label: &str, range: (f64, f64)) -> Axis {
    Axis { label: label.to_owned(), range, logarithmic: false }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".to_owned());
    let figures = [
        ("4.04", "The fade of gradient noise", -1.0, vec![line("", -1.0, quintic)]),
        (
            "4.09",
            "Kernels of sparse convolution",
            0.0,
            vec![line("raised cosine (Lewis)", 0.0, lewis), line("quintic", 0.0, quintic)],
        ),
    ];
    for (number, title, from, lines) in figures {
        let x = axis("distance", (from, 1.0));
        let curves = Curves { title: title.to_owned(), x, y: axis("h", (0.0, 1.1)), lines };
        let figure = curves.draw(560)?;
        atomic::write(&Path::new(&folder).join(format!("{number}.png")), |f| figure.write_png(f))?;
    }
    Ok(())
}
