//! Makes the pictures of the tutorial from the scripts on its page.
//!
//!     cargo run --release --example tutorial

use orogen::render::{Job, Metadata, save};
use orogen::script::{Request, compile};
use orogen::session::{Order, render};
use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new("docs");
    let page = std::fs::read_to_string(folder.join("tutorial.md"))?;
    let scripts = page.split("```rhai\n").skip(1).filter_map(|rest| rest.split("```").next());
    for (i, script) in scripts.enumerate() {
        let scene = compile(&Request::text(script)).scene.ok_or("a step has an error")?;
        let order = Order { size: Some((400, 300)), samples: Some(9), ..Order::default() };
        let picture = render(&scene, &order, &Job::unwatched(&AtomicBool::new(false)))
            .map_err(|diagnostic| diagnostic.message)?;
        let metadata = Metadata { script: script.to_owned(), ..Metadata::default() };
        save(&folder.join(format!("tutorial/{}.png", i + 1)), &picture, &metadata)?;
    }
    Ok(())
}
