//! orogen beside two programs of its kind, in one run and each on one thread.
//!
//! ```text
//! cd benches/peers && cargo run --release [-- FOLDER]
//! ```
//!
//! **Fidget** (crates `fidget-*`, Keeter) compiles an expression to machine code, in single precision, and
//! finds a height map with normals by intervals over tiles, each with the code pruned for it. Its models are
//! not ours to copy: `FOLDER/fidget` has them. Without a folder there are `scripts/nut.vm` and a planet, six
//! octaves of gradient noise on a ball, in each program's own operations. Both look along the z axis with the
//! same pixels, Fidget with as many voxels in depth as there are along an edge, orogen to 1e-4 of a unit. Models
//! are turned to where they are not seen from their ends.
//!
//! Meshes are made of the cube from -1 to 1 at 128, 256 and 512 cells along its edges; Fidget merges cells as it
//! goes, orogen proves that nothing is missed where it can, and both are manifold dual contouring.
//!
//! **POV-Ray** (`povray` where one is installed) traces surface (5.11) of the thesis from
//! `FOLDER/povray/oct3.pov`, 800 x 800, with its own noise and the largest gradient that the scene says and
//! the smallest that gives the same picture. Ours is the whole picture as well, from the same eye.
//!
//! Processor seconds, the least of several runs that take turns.

mod clock;
mod fidget;
mod ours;
mod povray;

use clock::race;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// A model and how it is looked at: turns about x and z in degrees, and the half width of the picture.
struct View {
    /// Of a file, or else of the planet.
    file: Option<&'static str>,
    turns: [f64; 2],
    half: f64,
    /// Width and height of the picture in pixels, and for Fidget its depth in voxels.
    size: usize,
}

impl View {
    fn name(&self) -> &'static str {
        self.file.unwrap_or("planet, 6 octaves")
    }
}

const VIEWS: [View; 5] = [
    View { file: Some("colonnade.vm"), turns: [-60.0, 30.0], half: 1.0 / 0.7, size: 1024 },
    View { file: Some("tanglecube.vm"), turns: [-30.0, 20.0], half: 3.0, size: 1024 },
    View { file: Some("hi.vm"), turns: [0.0, 0.0], half: 1.0, size: 1024 },
    View { file: Some("nut.vm"), turns: [-30.0, 20.0], half: 1.5, size: 1024 },
    View { file: None, turns: [0.0, 0.0], half: 1.0, size: 512 },
];

fn main() -> ExitCode {
    let folder = std::env::args().nth(1).map(PathBuf::from);
    if let Some(folder) = folder.as_ref().filter(|f| !f.is_dir()) {
        eprintln!("there is no folder {}", folder.display());
        return ExitCode::FAILURE;
    }
    println!("Height maps, one thread each, CPU seconds\n");
    println!(
        "| model | pixels | Fidget, JIT | orogen, hits | and normals | factor | pixels that both hit, one alone |"
    );
    println!("|---|---|---|---|---|---|---|");
    for view in &VIEWS {
        let path = view.file.map(|file| found(folder.as_deref(), file));
        let done = match &path {
            Some(None) => Err("not there".into()),
            Some(Some(path)) => beside_fidget(view, Some(path)),
            None => beside_fidget(view, None),
        };
        if let Err(why) = done {
            println!("| {} | {why} | | | | |", view.name());
        }
    }
    println!("\nMeshes, one thread each, CPU seconds\n");
    println!("| model | cells | Fidget, JIT | orogen | factor | triangles |");
    println!("|---|---|---|---|---|---|");
    for (file, depth) in MESHED.into_iter().flat_map(|file| [7, 8, 9].map(|depth| (file, depth))) {
        match found(folder.as_deref(), file).map(|path| meshes(file, &path, depth)) {
            Some(Ok(())) => {}
            Some(Err(why)) => println!("| {file} | {why} | | | | |"),
            None => println!("| {file} | not there | | | | |"),
        }
    }
    println!();
    match folder.map(|f| f.join("povray")).filter(|f| f.is_dir()) {
        Some(folder) => povray::table(&folder),
        None => println!("No folder with POV-Ray's scenes was given."),
    }
    ExitCode::SUCCESS
}

/// Models that meshes are made of.
const MESHED: [&str; 3] = ["colonnade.vm", "tanglecube.vm", "nut.vm"];

fn meshes(name: &str, path: &Path, depth: u8) -> Result<(), String> {
    let theirs = fidget::Model::read(Some(path))?;
    let ours = ours::Model::read(Some(path))?;
    let (mut a, mut b) = (0, 0);
    let [jit, own] = race(3, [&mut || a = theirs.triangles(depth), &mut || b = ours.triangles(depth)]);
    println!("| {name} | {} | {jit:.2} | {own:.2} | {:.2} | {a}, {b} |", 1 << depth, own / jit);
    Ok(())
}

/// Where a model is: in the folder, or among our scripts.
fn found(folder: Option<&Path>, file: &str) -> Option<PathBuf> {
    let ours = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts");
    [folder.map(|f| f.join("fidget")), Some(ours)]
        .into_iter()
        .flatten()
        .map(|f| f.join(file))
        .find(|path| path.is_file())
}

fn beside_fidget(view: &View, path: Option<&Path>) -> Result<(), String> {
    let theirs = fidget::Model::read(path)?;
    let ours = ours::Model::read(path)?;
    let mut pictures = [Vec::new(), Vec::new(), Vec::new()];
    let [a, b, c] = &mut pictures;
    let [jit, hits, normals] = race(
        3,
        [&mut || *a = theirs.depths(view), &mut || *b = ours.hits(view, false), &mut || {
            *c = ours.hits(view, true)
        }],
    );
    let size = view.size;
    let both = pictures[0].iter().zip(&pictures[1]).filter(|(a, b)| **a && **b).count();
    let alone = pictures[0].iter().zip(&pictures[1]).filter(|(a, b)| a != b).count();
    println!(
        "| {} | {size}^2 | {jit:.2} | {hits:.2} | {normals:.2} | {:.2} | {both}, {alone} |",
        view.name(),
        normals / jit
    );
    Ok(())
}
