use orogen::noise::certify::{Method, prove, search};
use std::time::Instant;
fn main() {
    for k in 0..6 { let t=Instant::now(); println!("{k}: {:?} {:?}", search(k, 400), t.elapsed()); }
    let args: Vec<f64> = std::env::args().skip(1).map(|a| a.parse().unwrap()).collect();
    for c in args.chunks(4) {
        let t = Instant::now();
        let m = if c[2] == 0.0 { Method::Interval } else if c[3] == 0.0 { Method::Next(c[2]) } else { Method::NextTwo(c[2], c[3]) };
        println!("M{} <= {}: {:?} {:?}", c[0], c[1], prove(c[0] as usize, c[1], m, 3_000_000_000), t.elapsed());
    }
}
