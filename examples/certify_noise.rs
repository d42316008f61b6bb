//! Proves the constants of gradient noise: `cargo run --release --example certify_noise`.
//!
//! For each order of derivative it prints what a search found (a lower bound on the supremum), the
//! bound that was proven by branch and bound (which for orders 0 to 3 is the constant in the code),
//! and what that took. The method is told in `orogen::noise::certify`.

use orogen::noise::Gradient;
use orogen::noise::certify::{Method, prove, search};
use std::process::ExitCode;
use std::time::Instant;

/// Starting places of a search, and boxes a proof may visit in each of its parts.
const STARTS: u64 = 800;
const BUDGET: u64 = 1 << 32;

fn main() -> ExitCode {
    let b = Gradient::BOUNDS;
    // From the top: each order leans on those above it.
    let (fifth, fourth) = (15_000.0, 1400.0);
    let claims = [
        (5, "M5", fifth, Method::Interval),
        (4, "M4", fourth, Method::Next(fifth)),
        (3, "M3", b.third, Method::NextTwo(fourth, fifth)),
        (2, "M2", b.hessian, Method::NextTwo(b.third, fourth)),
        (1, "L", b.lipschitz, Method::NextTwo(b.hessian, b.third)),
        (0, "A", b.range, Method::NextTwo(b.lipschitz, b.hessian)),
    ];
    println!("| constant | found | proven | boxes | seconds |\n|---|---|---|---|---|");
    for (order, name, target, method) in claims {
        let found = search(order, STARTS);
        let start = Instant::now();
        let Some(boxes) = prove(order, target, method, BUDGET) else {
            eprintln!("{name} <= {target} is not proven; the search found {found:?}");
            return ExitCode::FAILURE;
        };
        println!(
            "| {name} | {:.6} | {target} | {boxes} | {:.1} |",
            found.value,
            start.elapsed().as_secs_f64()
        );
    }
    ExitCode::SUCCESS
}
