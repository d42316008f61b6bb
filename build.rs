//! Tells the program what it is made of: `OROGEN_SOURCES` is a fingerprint of all that is compiled into it. What was kept on
//! disk by a program made of anything else is not taken for what this one would find.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// What programs are made of, as far as it is there.
const SOURCES: [&str; 5] = ["src", "stdlib", "scripts/planet.rhai", "Cargo.toml", "Cargo.lock"];

/// How names of files end that are compiled: editors have others beside them.
const KINDS: [&str; 7] = ["rs", "rhai", "html", "css", "js", "toml", "lock"];

fn main() -> io::Result<()> {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut hasher = DefaultHasher::new();
    for source in SOURCES {
        let path = root.join(source);
        if path.exists() {
            take(&path, source, &mut hasher)?;
        }
    }
    println!("cargo::rustc-env=OROGEN_SOURCES={:016x}", hasher.finish());
    Ok(())
}

/// Takes in the name and the bytes of a file, or of all in a folder.
fn take(path: &Path, name: &str, hasher: &mut DefaultHasher) -> io::Result<()> {
    if !path.is_dir() {
        let is_compiled = path.extension().is_some_and(|kind| KINDS.iter().any(|own| kind == *own));
        if is_compiled && !name.contains("/.") {
            println!("cargo::rerun-if-changed={name}");
            (name, fs::read(path)?).hash(hasher);
        }
        return Ok(());
    }
    let mut names: Vec<_> =
        fs::read_dir(path)?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<_>>()?;
    names.sort();
    for own in names {
        take(&path.join(&own), &format!("{name}/{}", own.display()), hasher)?;
    }
    Ok(())
}
