//! Functions that can stand for one another.

use super::Entry;
use crate::script::help::short;
use std::collections::{BTreeMap, BTreeSet};

/// Functions of one heading, or of one module, that the reference gives the same arguments.
#[derive(Clone, Debug, Default)]
pub struct Kin(BTreeMap<(String, usize), Vec<String>>);

impl Kin {
    /// Those of a reference.
    pub fn new(entries: &[Entry]) -> Kin {
        let mut families = BTreeMap::<_, BTreeSet<(&str, &str)>>::new();
        for entry in entries {
            if let Some(arguments) = arguments(entry) {
                families.entry((&entry.group, arguments)).or_default().insert((&entry.name, short(entry)));
            }
        }
        let mut kin = BTreeMap::<_, BTreeSet<String>>::new();
        for ((_, arguments), names) in &families {
            let arity = arguments.split(')').next().unwrap_or("").split(',').count();
            for (name, _) in names {
                let others = names.iter().filter(|(other, _)| other != name);
                let others = others.map(|(_, short)| (*short).to_owned());
                kin.entry(((*name).to_owned(), arity)).or_default().extend(others);
            }
        }
        Kin(kin.into_iter().map(|(key, names)| (key, names.into_iter().collect())).collect())
    }

    /// What may stand for a function, without its module.
    pub fn of(&self, full: &str, arity: usize) -> &[String] {
        self.0.get(&(full.to_owned(), arity)).map_or(&[], Vec::as_slice)
    }
}

/// What a function is called with, and gives: its signature without its name. Operators have none.
fn arguments(entry: &Entry) -> Option<&str> {
    entry.signature.strip_prefix(&entry.name)?.strip_prefix('(').filter(|rest| !rest.starts_with(')'))
}
