//! Analyses on disk, so that frames of an animation and renderings of a scene from other sides share one.

use crate::expr::{Graph, NodeId};
use crate::num::Digest;
use crate::scene::Aabb;
use crate::world::store::{Shelf, Store};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::hash::Hash;

/// Where they are kept.
const SHELF: Shelf = Shelf { name: "topology", most: 256 << 20 };

/// What an analysis is of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Key(Digest);

impl Key {
    /// An expression within a region. Equal expressions have equal keys whatever graphs they are nodes of.
    pub fn new(graph: &Graph, root: NodeId, region: &Aabb) -> Key {
        let mut key = graph.fingerprint(root);
        key.numbers([region.min, region.max].into_iter().flat_map(|corner| corner.to_array()));
        Key(key)
    }

    /// Something else about the same, by what it is and how it was found.
    pub fn of(self, what: impl Hash) -> Key {
        let Key(mut key) = self;
        what.hash(&mut key);
        Key(key)
    }
}

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
    let store = Store::of_user();
    let known = store.as_ref().filter(|_| !fresh).and_then(|store| store.load(&SHELF, key.0));
    if let Some(known) = known {
        return Ok((known, true));
    }
    let found = find()?;
    if let Some(store) = store {
        store.save(&SHELF, key.0, &found);
    }
    Ok((found, false))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::{Complex, SearchStats};

    #[test]
    fn an_analysis_is_kept_as_it_was_found() {
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
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        let [key, other] = ["this", "that"].map(|what| Key(Digest::default()).of(what));
        store.save(&SHELF, key.0, &complex);
        assert!(store.load(&SHELF, key.0).as_ref() == Some(&complex));
        assert!(store.load::<Complex>(&SHELF, other.0).is_none());
    }
}
