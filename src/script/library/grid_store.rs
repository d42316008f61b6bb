//! Grids that take long are made once: who wants the same again, in another run as well, has their samples from the
//! [store](crate::world::store) of the world. A save in the editor, a frame of an animation and a moment of a blurred picture
//! cost no erosion of their own, unless what they change is what is eroded.

use super::Call;
use super::grid::done;
use crate::grid::{Frame, Samples};
use crate::num::Digest;
use crate::script::fault::Outcome;
use crate::world::store::{Shelf, Store};
use rhai::Dynamic;
use std::time::{Duration, Instant};

/// Where samples are kept. The revision is raised when a job gives others than it gave before, as
/// `what_is_kept_is_what_would_be_made` finds out.
const SHELF: Shelf = Shelf { name: "grids", kind: "samples", revision: 1, most: 512 << 20 };

/// What takes less is as soon made as read.
const LONG: Duration = Duration::from_millis(20);

/// The grid through the samples that a job makes in a frame. `job` says everything that they depend on, but for other grids
/// and fields, which `of` has the fingerprints of.
pub(super) fn remembered(
    c: &Call<'_>,
    frame: Frame,
    job: &str,
    of: &[Digest],
    make: impl FnOnce() -> Outcome<Samples>,
) -> Outcome<Dynamic> {
    let Some(store) = &c.host.store else { return done(Ok(make()?)) };
    let mut key = Digest::default();
    key.text(job);
    key.text(&format!("{frame:?}"));
    of.iter().for_each(|part| key.join(*part));
    done(Ok(found(store, key, frame, LONG, make)?))
}

/// The samples that a store has under a key; else they are made, and kept if that takes so long.
fn found(
    store: &Store,
    key: Digest,
    frame: Frame,
    long: Duration,
    make: impl FnOnce() -> Outcome<Samples>,
) -> Outcome<Samples> {
    let known = store.load(&SHELF, key).filter(|values: &Vec<f64>| values.len() == frame.count());
    if let Some(values) = known {
        return Ok(Samples { frame, values });
    }
    let start = Instant::now();
    let samples = make()?;
    if start.elapsed() >= long {
        store.save(&SHELF, key, &samples.values);
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Edge;
    use crate::script::engine::{self, Limits};
    use crate::script::fault::Fault;
    use crate::script::host::Host;
    use crate::script::library::GridValue;
    use crate::script::modules::Resolver;
    use crate::world::Memory;
    use std::collections::BTreeMap;
    use std::sync::Arc;

    #[test]
    fn what_took_long_is_made_once() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        let frame = Frame::over([4, 1, 2], [0.0; 3], [1.0; 3], Edge::Clamp).unwrap();
        let samples = Samples { frame, values: vec![0.5; 8] };
        let key = |x: u64| {
            let mut key = Digest::default();
            key.whole(x);
            key
        };
        let ask = |x: u64, long: Duration, made: Option<&Samples>| {
            let found =
                found(&store, key(x), frame, long, || made.cloned().ok_or_else(|| Fault::new("again")));
            found.ok()
        };
        assert_eq!(ask(1, Duration::MAX, Some(&samples)), Some(samples.clone()));
        assert_eq!(ask(1, Duration::ZERO, None), None, "it took no time, and was not kept");
        assert_eq!(ask(2, Duration::ZERO, Some(&samples)), Some(samples.clone()));
        assert_eq!(ask(2, Duration::ZERO, None), Some(samples.clone()));
        // Another frame has another key; if it had not, it would not have as many samples.
        let other = Frame::over([4, 1, 4], [0.0; 3], [1.0; 3], Edge::Clamp).unwrap();
        assert!(found(&store, key(2), other, LONG, || Err(Fault::new("again"))).is_err());
    }

    /// Samples that are no longer those of old: raise the revision of the shelf, and note the new ones here.
    #[test]
    fn what_is_kept_is_what_would_be_made() {
        let host = Host::new(&Limits::default(), BTreeMap::new(), 0.0);
        let resolver = |loaded| Resolver { world: Arc::new(Memory::default()), loaded };
        let setup = engine::setup(host, resolver, &Limits::default(), None).map_err(|_| "broken").unwrap();
        let digest = |call: &str| {
            let grid = setup.engine.eval::<GridValue>(call).unwrap();
            let mut digest = Digest::default();
            digest.numbers(grid.0.samples().values);
            digest.to_string()
        };
        let calls = [
            ("spectral(7, #{ size: 32 })", "3c4dbaf350bb1affbf425b6abb6b0afe"),
            (
                "spectral(7, #{ size: 8, volume: true, spectrum: \"markov\" })",
                "d8c54e73d640e8bbff6efd3c99d90ced",
            ),
            ("random_additions(7, #{ levels: 5 })", "d3d96d9f7b1aebfcb401d317d0e50317"),
            ("spot_noise(7, 1.0 - length(p), #{ size: 32 })", "500789891933144dcd8bb54d01a094d5"),
            ("bake(gradient(7).scaled(3.0), #{ size: 8, volume: true })", "f13dba15959f8fcd33931b56300ea360"),
            ("eroded(random_additions(7, #{ levels: 5 }))", "c71a8e1fe1745abfd70dedb14116d8fa"),
            ("weathered(random_additions(7, #{ levels: 5 }))", "5a32985e500b776114150934daf50206"),
        ];
        let now: Vec<_> = calls.iter().map(|(call, _)| (*call, digest(call))).collect();
        let then: Vec<_> = calls.iter().map(|(call, then)| (*call, (*then).to_owned())).collect();
        assert_eq!((SHELF.revision, now), (1, then));
    }
}
