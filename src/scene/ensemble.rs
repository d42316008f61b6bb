//! Random fields as plain data: what a script that describes a noise comes to.
//!
//! A noise is one function of space for every seed, and what is true of it as a *random* field
//! (its mean, its spectrum, whether it looks the same everywhere) is true of all of these together.
//! An ensemble holds some of them, each an expression of its own.

use crate::expr::{Graph, NodeId, TooLarge};
use crate::noise::Noise;
use std::sync::Arc;

/// One realisation of a random field: an expression of the coordinates.
#[derive(Clone, Debug)]
pub struct Member {
    /// The expressions of which it is one.
    pub graph: Arc<Graph>,
    /// The field.
    pub root: NodeId,
}

/// Realisations of a random field, with what is known of all of them.
#[derive(Clone, Debug)]
pub struct Ensemble {
    /// The realisations, each with its own seed.
    pub members: Vec<Member>,
    /// The first of them as it is in all of space: it does not repeat.
    pub plain: Member,
    /// The length after which all members repeat along every axis, if they do.
    pub period: Option<f64>,
    /// Length of a cell of the coarsest lattice.
    pub cell: f64,
    /// Frequencies of the coarsest and the finest octave, in lattice cells a unit of length; the same
    /// where there is one.
    pub octaves: (f64, f64),
}

impl Ensemble {
    /// `count` seeds of a noise from its own one on, repeating after `side` units of length where
    /// the noise can.
    ///
    /// # Errors
    /// If there are more than fit into an expression graph.
    pub fn of_noise(noise: Noise, count: usize, side: f64) -> Result<Ensemble, TooLarge> {
        let period = period(noise.frequency, side).filter(|&p| noise.kind.tiles([p; 3]).is_ok());
        let mut graph = Graph::default();
        let p = graph.point()?;
        let mut roots = Vec::new();
        for i in 0..count as u64 {
            let mut member = noise.seeded(noise.lattice.seed.wrapping_add(i));
            member.lattice.period = [period.unwrap_or(0); 3];
            roots.push(graph.noise(member, p)?);
        }
        let plain = graph.noise(noise, p)?;
        let graph = Arc::new(graph);
        let member = |root| Member { graph: graph.clone(), root };
        Ok(Ensemble {
            members: roots.into_iter().map(member).collect(),
            plain: member(plain),
            period: period.map(|_| side),
            cell: 1.0 / noise.frequency,
            octaves: (noise.frequency, noise.frequency),
        })
    }
}

/// The period in cells that makes a noise of this frequency repeat after `side` units of length, if
/// that is a whole number of cells.
pub fn period(frequency: f64, side: f64) -> Option<u32> {
    let cells = frequency * side;
    (cells.fract() == 0.0 && (1.0..=16_777_216.0).contains(&cells)).then_some(cells as u32)
}
