//! orogen as a library: a script becomes a picture and a mesh.
//!
//! `cargo run --release --example render -- scripts/asteroid.rhai asteroid.png asteroid.ply`

use orogen::cast::Kind;
use orogen::diag;
use orogen::exchange::mesh::{Format, write};
use orogen::field::{Field, Watch};
use orogen::mesh::Fineness;
use orogen::render::{self, Job, Metadata};
use orogen::session::{self, Order, Session};
use orogen::world::{Disk, atomic};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let (Some(script), Some(picture)) = (args.next(), args.next()) else {
        return Err("usage: render SCRIPT PICTURE [MESH]".into());
    };
    // Whoever raises it stops what is under way.
    let cancel = Arc::new(AtomicBool::new(false));

    // A script becomes a scene, or diagnostics that say why not.
    let mut session = Session::new(&script, Arc::new(Disk));
    let loaded = session.load(&cancel);
    let show = |d: &diag::Diagnostic| eprint!("{}", diag::render(d, &loaded.sources, false));
    loaded.diagnostics.iter().for_each(show);
    let scene = loaded.scene.clone().ok_or("there is no scene")?;

    // Its solid is a field: negative inside, with bounds that are proofs.
    let mut solid = Field::new(&scene.graph, scene.surface.field);
    let place = session::locate(&scene, &solid);
    println!("the solid is within {:?}, and {} in the middle", place.region, solid.value([0.0; 3].into()));

    let order = Order { size: Some((400, 300)), caster: Kind::Auto, ..Order::default() };
    let percent = |p: render::Progress| eprint!("\r{} of {} tiles", p.done, p.total);
    let job = Job { progress: &percent, ..Job::unwatched(&cancel) };
    let made =
        session.render(&scene, &order, &job, &cancel).inspect_err(|d| show(d)).map_err(|d| d.message)?;
    made.warnings.iter().for_each(show);
    render::save(Path::new(&picture), &made, &Metadata::default())?;

    if let Some(file) = args.next() {
        let fineness = Fineness { resolution: Some(64), tolerance: None };
        let watch = Watch { cancel: &cancel, progress: &|_| () };
        let made =
            session::polygonise(&scene, &fineness, &watch).inspect_err(|d| show(d)).map_err(|d| d.message)?;
        println!("{} triangles", made.meshed.mesh.triangles.len());
        let format = Format::of(&file)?;
        atomic::write(Path::new(&file), |out| write(format, &made.meshed.mesh, out))?;
    }
    Ok(())
}
