//! Runs a script from the command line's first argument and shows what it says and what is wrong.
use orogen::script::{Request, Script, compile};
use std::sync::Arc;

fn main() {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: diagnose SCRIPT");
        return;
    };
    let start = std::time::Instant::now();
    let compiled = compile(&Request::new(Script::File(path.into()), Arc::new(orogen::world::Disk)));
    for line in &compiled.output {
        println!("{line}");
    }
    for d in &compiled.diagnostics {
        print!("{}", orogen::diag::render(d, &compiled.sources, false));
    }
    if let Some(scene) = &compiled.scene {
        println!("a scene of {} nodes in {:.1?}", scene.graph.len(), start.elapsed());
    }
}
