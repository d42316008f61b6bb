//! Noises and fractal sums as script values: sources that are scaled, seeded and placed before
//! they become expressions.

use super::fault::{Fault, Outcome};
use super::host::{Host, is_better};
use crate::diag::Place;
use crate::expr::{Input, NodeId};
use crate::noise::{Fractal, Noise, Recipe};
use crate::num::{Bounds, Kernel, mix};
use crate::op::{self, Op};
use std::sync::Arc;

/// One noise or a sum of octaves.
#[derive(Clone, Debug)]
pub enum Kind {
    /// A noise.
    One(Noise),
    /// A sum of octaves.
    Sum(Sum),
}

/// A sum of octaves with what it takes from its surroundings.
#[derive(Clone, Debug)]
pub struct Sum {
    /// The octaves.
    pub recipe: Recipe,
    /// Whether the size of a pixel limits their detail.
    pub detail: bool,
    /// The exponent of their amplitudes, where that is an expression.
    pub hurst: Option<NodeId>,
}

/// Where a source is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// At the point.
    Space,
    /// At the point's direction from the origin.
    Sphere,
    /// At the point's foot on the plane y = 0.
    Plane,
}

/// A source of noise with its frequency and place; a `Noise` in scripts.
#[derive(Clone, Debug)]
pub struct Source {
    /// What is evaluated.
    pub kind: Kind,
    /// Where.
    pub domain: Domain,
    /// Coordinates, if not the point's own.
    pub at: Option<[NodeId; 3]>,
    /// Where in a script it was made.
    pub place: Option<Place>,
}

impl Source {
    /// A source at the point.
    pub fn new(kind: Kind) -> Self {
        Source { kind, domain: Domain::Space, at: None, place: None }
    }

    /// Whether it is asked at the point itself. What is asked elsewhere already is no longer a noise once it is moved again, but
    /// a field like any other.
    pub fn is_at_the_point(&self) -> bool {
        self.domain == Domain::Space && self.at.is_none()
    }

    /// Records where it was made, as for a [node](Host::set_place).
    pub fn set_place(&mut self, place: &Place) {
        if self.place.as_ref().is_none_or(|known| is_better(place, known)) {
            self.place = Some(place.clone());
        }
    }

    /// The noise, of which a sum adds octaves.
    pub fn noise(&self) -> &Noise {
        match &self.kind {
            Kind::One(noise) => noise,
            Kind::Sum(sum) => &sum.recipe.noise,
        }
    }

    fn noise_mut(&mut self) -> &mut Noise {
        match &mut self.kind {
            Kind::One(noise) => noise,
            Kind::Sum(sum) => &mut sum.recipe.noise,
        }
    }

    /// The same with its frequency times `k`.
    pub fn scaled(mut self, k: f64) -> Outcome<Source> {
        let frequency = self.noise().frequency * k;
        if !(1e-12..=1e12).contains(&frequency) {
            return Err(Fault::new(format!("a noise cannot be scaled by {k}")).hint(
                "the factor of its frequency is a positive number, and the frequency from 1e-12 to 1e12",
            ));
        }
        self.noise_mut().frequency = frequency;
        Ok(self)
    }

    /// The same with another seed.
    pub fn seeded(mut self, seed: u64) -> Source {
        self.noise_mut().lattice.seed = seed;
        self
    }

    /// The same, repeating after some cells along each axis.
    pub fn tiled(mut self, period: [u32; 3]) -> Outcome<Source> {
        if let Err(must) = self.noise().kind.tiles(period) {
            let name = self.noise().kind.name();
            return Err(Fault::new(format!("{name} noise cannot repeat after {period:?} cells")).hint(must));
        }
        self.noise_mut().lattice.period = period;
        if let Kind::Sum(sum) = &self.kind {
            sum.recipe
                .tiles()
                .map_err(|(_, must)| Fault::new("this sum of octaves cannot repeat").hint(must))?;
        }
        Ok(self)
    }

    /// Another noise of the same kind, of which this one's values tell nothing.
    pub fn unrelated(self, channel: u64) -> Source {
        // Octaves are numbered by small integers, which channels must not meet.
        let seed = self.noise().lattice.seed;
        self.seeded(mix(seed ^ mix((1 << 40) + channel)))
    }

    /// What is known of it over all of space.
    pub fn bounds(&self) -> Outcome<Bounds> {
        if self.domain != Domain::Space || self.at.is_some() {
            return Err(Fault::new(
                "the bounds of a noise hold at the point itself, not on a sphere or elsewhere",
            )
            .hint("a field has f.range(box) and f.lipschitz(box)"));
        }
        match &self.kind {
            Kind::One(noise) => Ok(noise.bounds()),
            Kind::Sum(sum) if sum.hurst.is_some() => {
                Err(Fault::new("a sum whose `hurst` is a field has no bounds over all of space")
                    .hint("a field has f.range(box) and f.lipschitz(box)"))
            }
            Kind::Sum(sum) => Ok(fractal(&sum.recipe)?.bounds()),
        }
    }

    /// The expression, made where the source was.
    pub fn lower(&self, host: &Host) -> Outcome<NodeId> {
        let before = host.graph.borrow().len();
        let node = self.expression(host)?;
        self.place.iter().for_each(|place| host.set_places(before, place));
        Ok(node)
    }

    fn expression(&self, host: &Host) -> Outcome<NodeId> {
        let p = match self.at {
            Some(p) => p,
            None => host.point()?,
        };
        let p = match self.domain {
            Domain::Plane => [p[0], host.constant(0.0)?, p[2]],
            Domain::Space | Domain::Sphere => p,
        };
        let (p, footprint) = match (self.domain, &self.kind) {
            (Domain::Sphere, _) => on_sphere(host, p, stretched(host, p)?)?,
            (_, Kind::Sum(sum)) if sum.detail => (p, stretched(host, p)?),
            _ => (p, host.constant(0.0)?),
        };
        match &self.kind {
            Kind::One(noise) => Ok(host.graph.borrow_mut().noise(*noise, p)?),
            Kind::Sum(sum) => {
                let fractal = Arc::new(fractal(&sum.recipe)?);
                let footprint = if sum.detail { footprint } else { host.constant(0.0)? };
                let mut graph = host.graph.borrow_mut();
                Ok(match sum.hurst {
                    None => graph.fractal(fractal, p, footprint)?,
                    Some(hurst) => graph.rough_fractal(fractal, p, footprint, hurst)?,
                })
            }
        }
    }
}

fn fractal(recipe: &Recipe) -> Outcome<Fractal> {
    Fractal::new(recipe.clone()).map_err(|e| Fault::new(e.to_string()))
}

/// The size of a pixel where a map of the point comes to.
pub fn stretched(host: &Host, map: [NodeId; 3]) -> Outcome<NodeId> {
    let stretch = host.graph.borrow().stretch(map);
    let here = host.input(Input::Footprint)?;
    // Turns are off by a few roundoffs.
    if (stretch - 1.0).abs() < 1e-9 {
        return Ok(here);
    }
    host.op(Op::Mul(op::Mul), &[here, host.constant(stretch)?])
}

/// What is added to lengths before anything is divided by them: it is lost in the rounding of all but the length zero, and
/// gives the point that has no direction a value, also as far as intervals know. Without one, no solid around it could be
/// proven to be whole.
pub const NEVER_ZERO: f64 = 1e-290;

/// `p / |p|`, or the origin there, and the size of a pixel there by that at `p`.
pub fn on_sphere(host: &Host, p: [NodeId; 3], footprint: NodeId) -> Outcome<([NodeId; 3], NodeId)> {
    let r = host.op(Op::Length(op::Length), &p)?;
    let r = host.op(Op::Add(op::Add), &[r, host.constant(NEVER_ZERO)?])?;
    let [x, y, z] = p;
    let unit = |c| host.op(Op::Div(op::Div), &[c, r]);
    Ok(([unit(x)?, unit(y)?, unit(z)?], unit(footprint)?))
}
