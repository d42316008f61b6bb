//! Analyses on disk, so that frames of an animation and renderings of a scene from other sides share one.
//!
//! They lie in a folder for such things: `OROGEN_CACHE` if it is set, else `orogen` in `XDG_CACHE_HOME` or in
//! `.cache` at home; nowhere if it is set to `off`. A file is named after the expression, the region, and what was found
//! of them. Its first line holds their hash, the version of the program, and a digest of the rest: a file that does not
//! match, or cannot be read, is as if it were not there. Files may be removed at any time; those that were not used for
//! longest are when there are too many.

use crate::expr::{Flow, Graph, Node, NodeId};
use crate::num::Digest;
use crate::scene::Aabb;
use crate::world::atomic;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::env::var_os;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What an analysis is of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Key(u64);

impl Key {
    /// An expression within a region. Equal expressions have equal keys whatever graphs they are nodes of.
    pub fn new(graph: &Graph, root: NodeId, region: &Aabb) -> Key {
        let mut hasher = DefaultHasher::new();
        let nodes = graph.reachable(&[root]);
        let place: HashMap<NodeId, u32> = nodes.iter().copied().zip(0..).collect();
        let number = |id: &NodeId| NodeId(place.get(id).copied().unwrap_or(u32::MAX));
        for id in &nodes {
            renumbered(graph.node(*id), number).hash(&mut hasher);
        }
        for corner in [region.min, region.max] {
            corner.to_array().map(f64::to_bits).hash(&mut hasher);
        }
        Key(hasher.finish())
    }

    /// Something else about the same, by what it is and how it was found.
    pub fn of(self, what: impl Hash) -> Key {
        let mut hasher = DefaultHasher::new();
        (self.0, what).hash(&mut hasher);
        Key(hasher.finish())
    }
}

/// A node whose arguments have other names.
fn renumbered(node: &Node, name: impl Fn(&NodeId) -> NodeId) -> Node {
    let point = |p: &[NodeId; 3]| p.each_ref().map(&name);
    match node {
        Node::Const(_) | Node::Input(_) => node.clone(),
        Node::Op(op, args) => Node::Op(*op, args.iter().map(&name).collect()),
        Node::Noise(noise, p) => Node::Noise(*noise, point(p)),
        Node::Fractal(f, p, footprint, hurst) => {
            Node::Fractal(f.clone(), point(p), name(footprint), hurst.as_ref().map(&name))
        }
        Node::Grid(grid, p) => Node::Grid(grid.clone(), point(p)),
        Node::Shape(shape, p) => Node::Shape(shape.clone(), point(p)),
        Node::Flow(flow, p) => {
            let carried = Flow { field: name(&flow.field), velocity: point(&flow.velocity), ..**flow };
            Node::Flow(carried.into(), point(p))
        }
    }
}

/// Raised when analyses of old must not be taken for those of now.
const REVISION: u32 = 8;

/// What is on the first line of a file; the analysis follows.
#[derive(Serialize, Deserialize, PartialEq)]
struct Head {
    revision: u32,
    version: String,
    key: u64,
    digest: String,
}

impl Head {
    fn new(key: Key, analysis: &[u8]) -> Head {
        let mut digest = Digest::default();
        digest.bytes(analysis);
        let version = env!("CARGO_PKG_VERSION").to_owned();
        Head { revision: REVISION, version, key: key.0, digest: digest.to_string() }
    }
}

/// The bytes of a file.
fn bytes(key: Key, analysis: &impl Serialize) -> Option<Vec<u8>> {
    let analysis = postcard::to_allocvec(analysis).ok()?;
    let mut bytes = serde_json::to_vec(&Head::new(key, &analysis)).ok()?;
    bytes.push(b'\n');
    bytes.extend(analysis);
    Some(bytes)
}

/// The analysis in the bytes of a file, if it is whole and of this.
fn read<T: DeserializeOwned>(key: Key, bytes: &[u8]) -> Option<T> {
    let (head, analysis) = bytes.split_at(bytes.iter().position(|byte| *byte == b'\n')?);
    let analysis = &analysis[1..];
    let is_whole = serde_json::from_slice::<Head>(head).ok()? == Head::new(key, analysis);
    if is_whole { postcard::from_bytes(analysis).ok() } else { None }
}

fn file(key: Key) -> Option<PathBuf> {
    let named = |name: &str| var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    if var_os("OROGEN_CACHE").is_some_and(|v| v == "off") {
        return None;
    }
    let folder = named("OROGEN_CACHE")
        .or_else(|| Some(named("XDG_CACHE_HOME")?.join("orogen")))
        .or_else(|| Some(named("HOME")?.join(".cache/orogen")))?;
    Some(folder.join("topology").join(format!("{:016x}.{KIND}", key.0)))
}

/// How names of files end.
const KIND: &str = "analysis";

/// An analysis that was saved before, unless it is wanted `fresh`, or else a new one, which is saved. Says as well whether
/// it was saved before.
///
/// # Errors
/// Those of finding it.
pub fn remembered<T: Serialize + DeserializeOwned, E>(
    key: Key,
    fresh: bool,
    find: impl FnOnce() -> Result<T, E>,
) -> Result<(T, bool), E> {
    if let Some(known) = load(key).filter(|_| !fresh) {
        return Ok((known, true));
    }
    let found = find()?;
    save(key, &found);
    Ok((found, false))
}

/// The analysis that was saved last, if there is one.
fn load<T: DeserializeOwned>(key: Key) -> Option<T> {
    let path = file(key)?;
    let found = read(key, &std::fs::read(&path).ok()?)?;
    touch(&path);
    Some(found)
}

/// Notes that a file is of use, so that others make room before it.
fn touch(path: &Path) {
    if let Ok(file) = File::options().write(true).open(path) {
        // Where that is not allowed it counts as old.
        let _ = file.set_modified(SystemTime::now());
    }
}

/// Saves an analysis where that is possible; that it could not be is no harm.
fn save(key: Key, analysis: &impl Serialize) {
    let Some(path) = file(key) else { return };
    let Some(bytes) = bytes(key, analysis) else { return };
    // One so large would drive out all others, and itself.
    if bytes.len() as u64 > MOST {
        return;
    }
    if let Some(folder) = path.parent()
        && std::fs::create_dir_all(folder).is_ok()
    {
        // Next time it is found anew.
        let _ = atomic::write(&path, |f| f.write_all(&bytes));
        trim(folder, MOST);
    }
}

/// Bytes that the analyses of a folder may take.
const MOST: u64 = 256 << 20;

/// Removes the analyses of a folder that were not used for longest until the others take no more than so many bytes.
fn trim(folder: &Path, most: u64) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    // Earlier versions wrote JSON.
    let analysis = |path: &Path| path.extension().is_some_and(|e| e == KIND || e == "json");
    let file = |entry: std::fs::DirEntry| {
        let about = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
        analysis(&entry.path()).then_some((about.modified().ok()?, about.len(), entry.path()))
    };
    let mut files: Vec<_> = entries.flatten().filter_map(file).collect();
    files.sort_by(|a, b| b.cmp(a));
    let mut total = 0;
    for (_, size, path) in files {
        total += size;
        if total > most {
            // One that another process has removed is gone as well.
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::{Complex, SearchStats};
    use std::time::Duration;

    #[test]
    fn a_file_with_a_byte_that_is_wrong_is_none() {
        let complex = Complex {
            region: Aabb::cube(1.0),
            points: Vec::new(),
            component: Vec::new(),
            arcs: Vec::new(),
            components: Vec::new(),
            basins: vec![(536, 0.25)],
            open: Vec::new(),
            level: Vec::new(),
            lost: 0,
            beyond: 0,
            cut: false,
            stats: SearchStats::default(),
        };
        let key = Key(7);
        let whole = |bytes: &[u8]| read::<Complex>(key, bytes);
        let bytes = bytes(key, &complex).unwrap();
        assert!(whole(&bytes).as_ref() == Some(&complex) && read::<Complex>(Key(8), &bytes).is_none());
        for i in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[i] ^= 1;
            assert!(whole(&damaged).is_none(), "{i}");
            assert!(whole(&bytes[..i]).is_none(), "{i}");
        }
    }

    #[test]
    fn what_was_not_used_for_longest_makes_room() {
        let folder = tempfile::tempdir().unwrap();
        for (i, name) in ["0.analysis", "1.json", "2.analysis", "3.txt"].into_iter().enumerate() {
            let path = folder.path().join(name);
            std::fs::write(&path, [0; 100]).unwrap();
            let age = Duration::from_secs(1000 * i as u64);
            let file = File::options().write(true).open(path).unwrap();
            file.set_modified(SystemTime::now() - age).unwrap();
        }
        let left = || {
            let names = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name());
            let mut names: Vec<_> = names.map(|name| name.into_string().unwrap()).collect();
            names.sort();
            names
        };
        trim(folder.path(), 300);
        assert_eq!(left().len(), 4);
        touch(&folder.path().join("2.analysis"));
        trim(folder.path(), 250);
        assert_eq!(left(), ["0.analysis", "2.analysis", "3.txt"]);
    }
}
