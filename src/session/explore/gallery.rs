//! What was taken from the space of parameters, generation by generation.

use super::breed::Breeding;
use super::mutate::Change;
use super::nursery::Raise;
use super::sample;
use super::space::Space;
use super::subject::Genome;
use crate::num::mix;
use crate::scene::Value;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Most specimens that a gallery holds.
pub const MOST: usize = 1000;

/// How much smaller reaches become from one generation to the next.
const SHRINKAGE: f64 = 0.7;

/// How far beyond its favourites a narrower box goes on either side at first, as a share of the range.
const MARGIN: f64 = 0.1;

/// How many points are tried for one that is not there yet, before a space counts as used up.
const TRIES: u64 = 64;

/// One set of parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Specimen {
    /// A value for every axis of the space.
    pub values: Vec<Value>,
    /// The generation that it belongs to.
    pub generation: usize,
    /// Those of which it was bred.
    pub parents: Vec<usize>,
    /// The text, where its expressions differ from those of the script.
    #[serde(skip)]
    pub text: Option<Arc<str>>,
    /// What was changed of its expressions, one after the other, from the script to this.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
}

impl Specimen {
    /// One of nobody, with the expressions of the script.
    fn new(values: Vec<Value>, generation: usize) -> Specimen {
        Specimen { values, generation, parents: Vec::new(), text: None, changes: Vec::new() }
    }
}

/// How a generation was taken from the space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// Evenly from all of it.
    Sample,
    /// Evenly from a box around favourites.
    Narrow,
    /// From favourites, mixed and mutated by this share of the ranges at most.
    Breed(f64),
    /// The same, with their expressions.
    Evolve(f64),
}

/// Specimens that were made together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Generation {
    /// How.
    pub way: Way,
    /// The favourites that they were made of.
    pub from: Vec<usize>,
    /// The specimens.
    pub members: Vec<usize>,
    /// How many generations there are from the first one to this: those of its favourites, and itself.
    pub depth: u32,
    /// What the next of them is made of.
    #[serde(skip)]
    next: u64,
}

/// What people ask for.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// A specimen becomes a favourite, or is none any longer.
    Star {
        /// Which.
        id: usize,
        /// Whether it is one.
        on: bool,
    },
    /// There are no favourites.
    Clear,
    /// A generation grows.
    More(usize),
    /// A generation from around the favourites.
    Narrow,
    /// A generation bred from the favourites, with this strength of mutation, from 0 to 1.
    Breed(f64),
    /// The same, with their expressions mutated and crossed, too.
    Evolve(f64),
}

/// Why a command is not obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// There is nothing to start from.
    #[error("there are no favourites yet; star one first")]
    NoFavourites,
    /// Everything is there already.
    #[error("nothing new comes of that; star others, or mutate more strongly")]
    NothingNew,
    /// The gallery is full.
    #[error("the gallery is full: it holds {MOST} pictures")]
    Full,
    /// There is no such thing.
    #[error("there is no {0} {1}")]
    Unknown(&'static str, usize),
    /// A number makes no sense.
    #[error("the strength of mutation is a number from 0 to 1")]
    Strength,
    /// Nobody waits for it.
    #[error("it was given up")]
    GivenUp,
}

/// Everything that was made so far.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gallery {
    #[serde(flatten)]
    space: Space,
    /// What decides about everything that is left to chance.
    pub seed: u64,
    #[serde(skip)]
    count: usize,
    /// All specimens, by number. The first is the script as it is.
    pub specimens: Vec<Specimen>,
    /// All generations. The first is a sample of the whole space.
    pub generations: Vec<Generation>,
    /// The favourites.
    pub stars: BTreeSet<usize>,
}

impl Gallery {
    /// A gallery with its first generation. Each has `count` specimens, or as many as there are.
    pub fn new(space: Space, count: usize, seed: u64) -> Gallery {
        let script = Specimen::new(space.defaults(), 0);
        let first = Generation { way: Way::Sample, from: Vec::new(), members: vec![0], depth: 1, next: 0 };
        let specimens = vec![script];
        let mut gallery =
            Gallery { space, seed, count, specimens, generations: vec![first], stars: BTreeSet::new() };
        // A space may be so small that the script as it is is all there is.
        let _ = gallery.grow(0, count.min(MOST).saturating_sub(1), &());
        gallery
    }

    /// The space.
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// What a specimen is made of.
    pub fn genome(&self, id: usize) -> Option<Genome> {
        let Specimen { values, text, .. } = self.specimens.get(id)?;
        Some(Genome { values: self.space.named(values), text: text.clone() })
    }

    /// Does what is asked for, with somebody to raise children whose expressions may change.
    ///
    /// # Errors
    /// Why it does not; then nothing has changed.
    pub fn obey(&mut self, command: Command, nurse: &impl Raise) -> Result<(), Refused> {
        match command {
            Command::Star { id, on } => {
                self.specimens.get(id).ok_or(Refused::Unknown("picture", id))?;
                if on {
                    self.stars.insert(id)
                } else {
                    self.stars.remove(&id)
                };
                Ok(())
            }
            Command::Clear => {
                self.stars.clear();
                Ok(())
            }
            Command::More(number) => self.grow(number, self.count, nurse),
            Command::Narrow => self.begin(Way::Narrow, nurse),
            Command::Breed(strength) | Command::Evolve(strength) if !(0.0..=1.0).contains(&strength) => {
                Err(Refused::Strength)
            }
            Command::Breed(strength) => self.begin(Way::Breed(strength), nurse),
            Command::Evolve(strength) => self.begin(Way::Evolve(strength), nurse),
        }
    }

    /// Makes a generation of the favourites.
    fn begin(&mut self, way: Way, nurse: &impl Raise) -> Result<(), Refused> {
        let from: Vec<usize> = self.stars.iter().copied().collect();
        let depths = from.iter().map(|id| self.generations[self.specimens[*id].generation].depth);
        let depth = 1 + depths.max().ok_or(Refused::NoFavourites)?;
        self.generations.push(Generation { way, from, members: Vec::new(), depth, next: 0 });
        let grown = self.grow(self.generations.len() - 1, self.count, nurse);
        if grown.is_err() {
            self.generations.pop();
        }
        grown
    }

    /// Adds specimens that are not there yet to a generation.
    fn grow(&mut self, number: usize, wanted: usize, nurse: &impl Raise) -> Result<(), Refused> {
        let generation = self.generations.get(number).ok_or(Refused::Unknown("generation", number))?;
        let wanted = wanted.min(MOST - self.specimens.len());
        if wanted == 0 {
            return Err(Refused::Full);
        }
        let (mut next, before) = (generation.next, self.specimens.len());
        let end = next + TRIES * wanted as u64;
        while next < end && self.specimens.len() < before + wanted {
            // As many as are missing: no more are made than one after the other would be.
            let missing = (before + wanted - self.specimens.len()) as u64;
            let batch = next..end.min(next + missing);
            next = batch.end;
            let made: Vec<Specimen> = batch.into_par_iter().map(|i| self.make(number, i, nurse)).collect();
            if nurse.is_over() {
                self.specimens.truncate(before);
                return Err(Refused::GivenUp);
            }
            for specimen in made {
                let is_same =
                    |known: &Specimen| (&known.values, &known.text) == (&specimen.values, &specimen.text);
                if !self.specimens.iter().any(is_same) {
                    self.specimens.push(specimen);
                }
            }
        }
        let new = before..self.specimens.len();
        if new.is_empty() {
            return Err(Refused::NothingNew);
        }
        self.generations[number].members.extend(new);
        self.generations[number].next = next;
        Ok(())
    }

    /// A specimen of a generation.
    fn make(&self, number: usize, index: u64, nurse: &impl Raise) -> Specimen {
        let Generation { way, from, depth, .. } = &self.generations[number];
        let seed = mix(self.seed ^ mix(number as u64));
        let shrinkage = libm::pow(SHRINKAGE, f64::from(*depth) - 2.0);
        let axes = &self.space.axes;
        match way {
            Way::Sample => {
                let values = self.space.values(&sample::point(axes.len(), index, seed));
                Specimen::new(values, number)
            }
            Way::Narrow => {
                let ends = self.hull(from, MARGIN * shrinkage);
                let point = sample::point(axes.len(), index, seed);
                let inner = ends.iter().zip(point).map(|([low, high], place)| low + (high - low) * place);
                // Their expressions have equal shares of the box.
                let Specimen { text, changes, .. } =
                    self.specimens[from[index as usize % from.len()]].clone();
                let values = self.space.values(&inner.collect::<Vec<_>>());
                Specimen { text, changes, ..Specimen::new(values, number) }
            }
            Way::Breed(strength) | Way::Evolve(strength) => {
                let breeding = Breeding { reach: strength * shrinkage, seed };
                let parents = breeding.parents(from.len(), index).map(|i| from[i]);
                let value = |i: usize| parents.map(|id| &self.specimens[id].values[i]);
                let child = axes.iter().enumerate().map(|(i, a)| breeding.inherit(a, i, value(i), index));
                let mut child = Specimen::new(child.collect(), number);
                let own = breeding.takes_after(index);
                let pair = [own, 1 - own].map(|i| &self.specimens[parents[i]]);
                (child.text, child.changes) = (pair[0].text.clone(), pair[0].changes.clone());
                if matches!(way, Way::Evolve(_)) {
                    let genome = |of: &Specimen| Genome {
                        values: self.space.named(&child.values),
                        text: of.text.clone(),
                    };
                    let raised = nurse.raise(&breeding, index, [&genome(pair[0]), &genome(pair[1])]);
                    if let Some((text, change)) = raised {
                        child.text = Some(text);
                        child.changes.push(change);
                    }
                }
                let [first, second] = parents;
                child.parents = if first == second { vec![first] } else { vec![first, second] };
                child
            }
        }
    }

    /// The smallest box around specimens, with a margin, in the unit cube.
    fn hull(&self, ids: &[usize], margin: f64) -> Vec<[f64; 2]> {
        let ends = |(i, axis): (usize, &super::Axis)| {
            let places =
                |within: f64| ids.iter().map(move |id| axis.place(&self.specimens[*id].values[i], within));
            let low = places(0.0).fold(1.0, f64::min) - margin;
            let high = places(1.0).fold(0.0, f64::max) + margin;
            [low.max(0.0), high.min(1.0)]
        };
        self.space.axes.iter().enumerate().map(ends).collect()
    }
}
