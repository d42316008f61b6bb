//! Grids that take long are made once: who wants the same again, in another run as well, has their samples from the
//! [store](crate::world::store) of the world. A save in the editor, a frame of an animation and a moment of a blurred picture
//! cost no erosion of their own, unless what they change is what is eroded.

use super::Call;
use super::grid::done;
use crate::expr::{Input, NodeId};
use crate::grid::{Frame, Grid, Samples};
use crate::num::Digest;
use crate::script::fault::Outcome;
use crate::world::store::{Shelf, Store};
use rhai::Dynamic;
use std::time::{Duration, Instant};

/// Where samples are kept.
const SHELF: Shelf = Shelf { name: "grids", most: 512 << 20 };

/// What takes less is as soon made as read.
const LONG: Duration = Duration::from_millis(20);

/// What samples are made of, beside numbers.
pub(super) enum Of<'a> {
    Numbers,
    Grid(&'a Grid),
    Field(NodeId),
}

/// The grid through the samples that a job makes in a frame. `job` says all the numbers that they depend on.
pub(super) fn remembered(
    c: &Call<'_>,
    frame: Frame,
    job: &str,
    of: Of<'_>,
    make: impl FnOnce() -> Outcome<Samples>,
) -> Outcome<Dynamic> {
    // What depends on the time is another in every frame, and would drive out all that is not.
    let is_passing = matches!(of, Of::Field(node) if c.host.depends_on(node, &[Input::Time]));
    let Some(store) = c.host.store.as_ref().filter(|_| !is_passing) else { return done(Ok(make()?)) };
    let mut key = Digest::default();
    key.text(job);
    key.text(&format!("{frame:?}"));
    match of {
        Of::Numbers => {}
        Of::Grid(grid) => key.join(grid.fingerprint()),
        Of::Field(node) => key.join(c.host.graph.borrow().fingerprint(node)),
    }
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
    use crate::script::fault::Fault;

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
}
