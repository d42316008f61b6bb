//! A session as it was before an input, to go back to.
//!
//! A copy of the variables is not enough: a function without a name takes variables along by sharing them, and a copy
//! shares them too. So whatever is shared is noted together with what was in it, wherever it is: in a variable, an
//! array, an object map, a function.

use crate::scene::Param;
use crate::script::host::Host;
use rhai::{Array, Dynamic, FnPtr, Map, Scope};
use std::collections::BTreeSet;

/// Nesting of values up to which shared ones are looked for, far beyond what anyone writes.
const DEEP: usize = 100;

/// Variables and parameters of a moment.
pub struct Snapshot {
    scope: Scope<'static>,
    shared: Shared,
    params: Vec<Param>,
    presets: BTreeSet<String>,
}

/// Shared values, each with what was in it.
#[derive(Default)]
struct Shared {
    found: Vec<(Dynamic, Dynamic)>,
    /// Where they are in memory: a function may have taken along itself.
    places: BTreeSet<usize>,
}

impl Snapshot {
    /// The state now.
    pub fn of(scope: &Scope<'static>, host: &Host) -> Snapshot {
        let mut shared = Shared::default();
        scope.iter_raw().for_each(|(_, _, value)| shared.note(value, DEEP));
        Snapshot {
            scope: scope.clone(),
            shared,
            params: host.params.borrow().clone(),
            presets: host.presets.borrow().keys().cloned().collect(),
        }
    }

    /// Makes that the state again.
    pub fn restore(self, scope: &mut Scope<'static>, host: &Host) {
        *scope = self.scope;
        for (mut cell, content) in self.shared.found {
            if let Some(mut inside) = cell.write_lock::<Dynamic>() {
                *inside = content;
            }
        }
        host.params.replace(self.params);
        // The first preset of a name holds, so there are only new ones to forget.
        host.presets.borrow_mut().retain(|name, _| self.presets.contains(name));
    }
}

impl Shared {
    /// Notes what is shared in a value, up to a depth.
    fn note(&mut self, value: &Dynamic, depth: usize) {
        let Some(depth) = depth.checked_sub(1) else { return };
        if value.is_shared() {
            let inside = value.read_lock::<Dynamic>().map(|v| (std::ptr::from_ref(&*v).addr(), v.clone()));
            if let Some((place, content)) = inside
                && self.places.insert(place)
            {
                self.note(&content, depth);
                self.found.push((value.clone(), content));
            }
        } else if let Some(array) = value.read_lock::<Array>() {
            array.iter().for_each(|v| self.note(v, depth));
        } else if let Some(map) = value.read_lock::<Map>() {
            map.values().for_each(|v| self.note(v, depth));
        } else if let Some(function) = value.read_lock::<FnPtr>() {
            function.iter_curry().for_each(|v| self.note(v, depth));
        }
    }
}
