//! Proves the constants of noises: `cargo run --release --example certify_noise [NAME] [--starts N]`.
//!
//! For each order of derivative of each noise it prints what a search found (a lower bound on the
//! supremum), the bound that was proven (which for orders 0 to 3 is the constant in the code), their
//! ratio, and what the proof took. The methods are told in `orogen::noise::certify`. `NAME` picks the
//! noises whose names begin with it; `--quick` searches from a few hundred places and proves nothing.

use orogen::noise::certify::{ALL, Subject};
use std::process::ExitCode;
use std::time::Instant;

/// Boxes a proof may visit in each of its parts.
const BUDGET: u64 = 1 << 32;

fn certify(subject: &dyn Subject, starts: u64, quick: bool) -> Result<(), String> {
    let name = subject.name();
    for claim in subject.claims() {
        let start = Instant::now();
        let found = subject.search(claim.order, starts);
        let searched = start.elapsed().as_secs_f64();
        let bound = claim.bound;
        print!("| {name} | {} | {found:.6} | {bound} | {:.5} | {searched:.1} ", claim.name, found / bound);
        if quick {
            println!("| | |");
        } else {
            let start = Instant::now();
            let Some(boxes) = subject.prove(&claim, BUDGET) else {
                return Err(format!(
                    "{name}: {} <= {bound} is not proven; a search found {found}",
                    claim.name
                ));
            };
            println!("| {boxes} | {:.1} |", start.elapsed().as_secs_f64());
        }
        // A search rounds, too.
        if found > bound * (1.0 + 1e-12) {
            return Err(format!("{name}: a search found {found} above {} = {bound}", claim.name));
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let (mut name, mut starts, mut quick) = (String::new(), 1_000_000, false);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--quick" => (quick, starts) = (true, 300),
            "--starts" => match words.next().and_then(|n| n.parse().ok()) {
                Some(n) => starts = n,
                None => {
                    eprintln!("--starts needs a number");
                    return ExitCode::FAILURE;
                }
            },
            _ => name = word,
        }
    }
    println!("| noise | constant | found | proven | ratio | seconds | boxes | seconds |");
    println!("|---|---|---|---|---|---|---|---|");
    for subject in ALL.iter().copied().flatten().filter(|s| s.name().starts_with(&name)) {
        if let Err(reason) = certify(*subject, starts, quick) {
            eprintln!("{reason}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
