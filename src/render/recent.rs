//! What was made lately and can be used again: tables that take longer to make than a first rough picture may take,
//! and that depend on little of a scene.

use std::sync::{Mutex, PoisonError};

/// How many are kept: enough for a planet, its moon and its sea, seen in turns with those of another script.
const KEPT: usize = 6;

/// The last few things that were made, by what they were made from. Making the same again must give the same.
pub(super) struct Recent<K, V>(Mutex<Vec<(K, V)>>);

impl<K: PartialEq + Clone, V: Clone> Recent<K, V> {
    /// Nothing yet.
    pub const fn new() -> Self {
        Recent(Mutex::new(Vec::new()))
    }

    /// What is made from `key`: kept from before, or made now; `None` if the making was given up.
    pub fn get_or(&self, key: &K, make: impl FnOnce() -> Option<V>) -> Option<V> {
        if let Some(found) = self.find(key) {
            return Some(found);
        }
        // Others need not wait meanwhile; at worst they make the same.
        let made = make()?;
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.truncate(KEPT - 1);
        kept.insert(0, (key.clone(), made.clone()));
        Some(made)
    }

    /// What is kept, which becomes the newest.
    fn find(&self, key: &K) -> Option<V> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = kept.iter().position(|(known, _)| known == key)?;
        kept[..=at].rotate_right(1);
        Some(kept[0].1.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn the_last_few_are_made_once() {
        let recent = Recent::new();
        let made = RefCell::new(Vec::new());
        let get = |key: usize| {
            recent.get_or(&key, || {
                made.borrow_mut().push(key);
                Some(())
            });
        };
        assert_eq!(recent.get_or(&0, || None), None);
        (0..KEPT).for_each(get);
        // The first is used again, so the second is the one that goes.
        get(0);
        get(KEPT);
        get(0);
        get(1);
        assert_eq!(made.take(), (0..=KEPT).chain([1]).collect::<Vec<_>>());
    }
}
