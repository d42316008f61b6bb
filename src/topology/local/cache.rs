//! What was found out and may be asked again: tables that many threads share and that never grow beyond bounds.
//!
//! A table is in shards, each with a lock of its own, so that threads seldom wait for each other. What is stored follows
//! from its key, though more may be known of it later: that something was dropped, or found twice by two threads, costs
//! time and nothing else. A shard that is full drops the half that was not used for longest. What was not used for
//! [`AGE`] pictures is dropped when the next begins.

use ahash::RandomState;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Shards of a table.
const SHARDS: usize = 64;

/// Pictures for which something is kept that is not used.
pub const AGE: u64 = 8;

/// A table.
#[derive(Debug)]
pub struct Cache<K, V> {
    shards: Vec<Mutex<Shard<K, V>>>,
    hasher: RandomState,
    /// Entries of a shard at most.
    capacity: usize,
}

#[derive(Debug)]
struct Shard<K, V> {
    entries: HashMap<K, Entry<V>, RandomState>,
    /// Counts uses.
    clock: u64,
    picture: u64,
    /// Times that something was asked for, and that it was there.
    hits: [u64; 2],
}

#[derive(Debug)]
struct Entry<V> {
    value: V,
    /// When it was used last: by the clock, and in which picture.
    used: u64,
    picture: u64,
}

impl<K: Hash + Eq + Clone, V: Clone> Cache<K, V> {
    /// A table of so many entries at most.
    pub fn new(capacity: usize) -> Cache<K, V> {
        let shard = || Mutex::new(Shard { entries: HashMap::default(), clock: 0, picture: 0, hits: [0; 2] });
        Cache {
            shards: (0..SHARDS).map(|_| shard()).collect(),
            // The same in every run, so that what a full shard drops is not left to chance.
            hasher: RandomState::with_seeds(1, 2, 3, 4),
            capacity: capacity.div_ceil(SHARDS).max(2),
        }
    }

    /// What is known of a key.
    pub fn get(&self, key: &K) -> Option<V> {
        self.shard(key).get(key)
    }

    /// Stores what was found.
    pub fn insert(&self, key: K, value: V) {
        self.update(key, |_| value);
    }

    /// Stores, and returns, what is to be known from now on in the light of what is.
    pub fn update(&self, key: K, value: impl FnOnce(Option<&V>) -> V) -> V {
        let mut shard = self.shard(&key);
        shard.clock += 1;
        let (used, picture) = (shard.clock, shard.picture);
        if let Some(entry) = shard.entries.get_mut(&key) {
            *entry = Entry { value: value(Some(&entry.value)), used, picture };
            return entry.value.clone();
        }
        if shard.entries.len() >= self.capacity {
            shard.halve();
        }
        let value = value(None);
        shard.entries.insert(key, Entry { value: value.clone(), used, picture });
        value
    }

    /// Another picture begins: drops what is old, and counts anew.
    pub fn turn(&self) {
        for shard in &self.shards {
            let mut shard = lock(shard);
            shard.hits = [0; 2];
            shard.picture += 1;
            let now = shard.picture;
            shard.entries.retain(|_, entry| entry.picture + AGE >= now);
        }
    }

    /// Entries.
    pub fn len(&self) -> usize {
        self.shards.iter().map(|shard| lock(shard).entries.len()).sum()
    }

    /// Times that something was asked for, and of these, the ones that it was there.
    pub fn hits(&self) -> [u64; 2] {
        let hits = self.shards.iter().map(|shard| lock(shard).hits);
        hits.fold([0; 2], |[asked, known], [a, k]| [asked + a, known + k])
    }

    fn shard(&self, key: &K) -> MutexGuard<'_, Shard<K, V>> {
        lock(&self.shards[self.hasher.hash_one(key) as usize % SHARDS])
    }
}

fn lock<K, V>(shard: &Mutex<Shard<K, V>>) -> MutexGuard<'_, Shard<K, V>> {
    // A thread that panicked left a table that is whole.
    shard.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<K: Hash + Eq, V: Clone> Shard<K, V> {
    fn get(&mut self, key: &K) -> Option<V> {
        self.hits[0] += 1;
        let entry = self.entries.get_mut(key)?;
        self.clock += 1;
        self.hits[1] += 1;
        (entry.used, entry.picture) = (self.clock, self.picture);
        Some(entry.value.clone())
    }

    /// Drops what was not used for longest.
    fn halve(&mut self) {
        let mut used: Vec<u64> = self.entries.values().map(|entry| entry.used).collect();
        let middle = used.len() / 2;
        let median = *used.select_nth_unstable(middle).1;
        self.entries.retain(|_, entry| entry.used >= median);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_bounded_and_keep_what_is_used() {
        let cache: Cache<u32, u32> = Cache::new(6400);
        cache.insert(0, 7);
        for key in 1..100_000 {
            assert_eq!(cache.get(&0), Some(7), "it is used all the time: {key}");
            cache.insert(key, key);
            assert!(cache.len() <= 6400);
        }
        assert!(cache.len() > 2000);
        assert!(cache.get(&1).is_none());
    }

    #[test]
    fn what_is_there_already_needs_no_room() {
        let cache: Cache<u32, u32> = Cache::new(2 * SHARDS);
        let shard = |key: u32| cache.hasher.hash_one(key) as usize % SHARDS;
        let other = (1..).find(|key| shard(*key) == shard(0)).expect("a shard has many keys");
        cache.insert(0, 1);
        cache.insert(other, 1);
        cache.insert(other, 2);
        assert_eq!([0, other].map(|key| cache.get(&key)), [Some(1), Some(2)]);
    }

    #[test]
    fn nothing_is_lost_where_threads_add_to_one_value() {
        let cache: Cache<u32, u32> = Cache::new(1000);
        let start = std::sync::Barrier::new(4);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    start.wait();
                    for round in 0..40_000 {
                        cache.update(round % 4, |old| old.copied().unwrap_or_default() + 1);
                    }
                });
            }
        });
        assert_eq!([0, 1, 2, 3].map(|key| cache.get(&key)), [Some(40_000); 4]);
    }

    #[test]
    fn what_no_picture_uses_is_dropped() {
        let cache: Cache<u32, u32> = Cache::new(100);
        cache.insert(1, 1);
        cache.insert(2, 2);
        for _ in 0..AGE {
            cache.turn();
            assert_eq!(cache.get(&1), Some(1));
        }
        assert_eq!(cache.len(), 2);
        cache.turn();
        assert_eq!(cache.len(), 1);
        assert_eq!(cache.get(&1), Some(1));
    }

    #[test]
    fn threads_share_a_table() {
        let cache: Cache<u32, u32> = Cache::new(1000);
        std::thread::scope(|scope| {
            for start in 0..4 {
                let cache = &cache;
                scope.spawn(move || {
                    for key in start * 50..start * 50 + 100 {
                        match cache.get(&key) {
                            Some(value) => assert_eq!(value, 3 * key),
                            None => cache.insert(key, 3 * key),
                        }
                    }
                });
            }
        });
        assert_eq!((0..250).filter(|key| cache.get(key) == Some(3 * key)).count(), 250);
    }
}
