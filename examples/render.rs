//! orogen as a library: a script becomes a picture.
//!
//! `cargo run --release --example render -- scripts/planet.rhai planet.png`

use orogen::cast::{self, Kind};
use orogen::field::{Extent, Field, extent};
use orogen::render::{self, Job, Metadata, Settings};
use orogen::scene::Aabb;
use orogen::script::{Request, Script, compile};
use orogen::world::Disk;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let (Some(script), Some(out)) = (args.next(), args.next()) else {
        return Err("usage: render SCRIPT FILE [CASTER]".into());
    };

    // A script becomes a scene, or diagnostics that say why not.
    let compiled = compile(&Request::new(Script::File(PathBuf::from(&script)), Arc::new(Disk)));
    for diagnostic in &compiled.diagnostics {
        eprint!("{}", orogen::diag::render(diagnostic, &compiled.sources, false));
    }
    let scene = compiled.scene.ok_or("there is no scene")?;

    // Where is the solid? Enclosures know.
    let field = Field::new(&scene.graph, scene.surface.field);
    let bounds = match extent(&field, &Aabb::cube(64.0)) {
        Extent::Within(found) | Extent::Open(found) => found,
        Extent::Empty => return Err("there is nothing to see".into()),
    };

    // The picture fixes the detail, and with it the field that the caster sees.
    let cancel = AtomicBool::new(false);
    let prepared = render::prepare(&scene, &Settings::of(&scene, bounds), &cancel)?;
    let field = Field::new(&prepared.graph, prepared.field);
    let kind =
        args.next().map_or(Some(Kind::Auto), |name| Kind::ALL.iter().find(|k| k.1 == name).map(|k| k.0));
    let caster = cast::caster(
        kind.ok_or("no such caster")?,
        &field,
        &prepared.settings.bounds,
        &prepared.typical_rays(),
    )?;
    let start = std::time::Instant::now();
    let picture = render::render(&prepared, &*caster, &Job::unwatched(&cancel))?;
    eprintln!("{:.2} s, {}", start.elapsed().as_secs_f64(), serde_json::to_string(&picture.stats)?);
    render::save(&PathBuf::from(out), &picture, &Metadata::default())?;
    Ok(())
}
