//! Tapes within tapes: what a flow carries is evaluated where it has come to, not at the point that the outer tape is
//! asked about.

use super::{Evaluator, Instr, Tape};
use crate::expr::{Flow, Graph, NodeId};
use crate::flow::{self, Code, Parts};
use crate::noise::{Noise, Part, Recipe};
use crate::num::{Class, Interval, Kernel, Number};
use crate::op::Op;
use std::collections::HashSet;
use std::sync::Arc;

/// A field that a flow carries, both of them tapes.
pub type Flowed = flow::Flowed<Inner<3>, Inner<1>>;

/// A tape with `N` outputs as a function of space.
#[derive(Clone, Debug)]
pub struct Inner<const N: usize> {
    tape: Arc<Tape>,
    is_gradient: bool,
    parts: Option<Simple>,
}

/// Noises that are all there is to a velocity, with factors: three, or one of which it is the slope.
#[derive(Clone, Debug)]
enum Simple {
    Three(Box<[(Noise, f64); 3]>),
    Slope(Noise, f64),
}

impl Simple {
    /// The noises of a tape of three outputs.
    fn of(tape: &Tape) -> Option<Simple> {
        let part = |output: &u32| {
            let (slot, k) = match &tape.code[*output as usize] {
                Instr::Scale(slot, k) => (*slot, *k),
                Instr::Op(Op::Neg(_), args) => (args[0], -1.0),
                _ => (*output, 1.0),
            };
            let Instr::Noise(noise, p) = &tape.code[slot as usize] else { return None };
            (tape.is_point(p) && noise.is_uniform()).then_some((**noise, k))
        };
        let [x, y, z] = tape.outputs[..] else { return None };
        let parts = [part(&x)?, part(&y)?, part(&z)?];
        let whole = |noise: &Noise| Noise { part: Part::Value, ..*noise };
        if tape.is_gradient() {
            let is_bounded = whole(&parts[0].0).bounds().third.is_finite();
            return is_bounded.then_some(Simple::Slope(whole(&parts[0].0), parts[0].1));
        }
        let are_bounded = parts.iter().all(|(n, _)| n.part == Part::Value && n.bounds().hessian.is_finite());
        are_bounded.then(|| Simple::Three(Box::new(parts)))
    }

    fn parts(&self) -> Parts<'_, Noise> {
        match self {
            Simple::Three(parts) => Parts::Kernels(parts.each_ref().map(|(noise, k)| (noise, *k))),
            Simple::Slope(noise, k) => Parts::Slope(noise, *k),
        }
    }
}

impl<const N: usize> Inner<N> {
    fn new(tape: Tape) -> Self {
        let (is_gradient, parts, tape) = (tape.is_gradient(), Simple::of(&tape), Arc::new(tape));
        Inner { is_gradient, parts, tape }
    }

    /// The tape.
    pub fn tape(&self) -> &Arc<Tape> {
        &self.tape
    }
}

impl Inner<1> {
    /// Lowers a flow.
    pub(super) fn flowed(graph: &Graph, flow: &Flow) -> Flowed {
        let velocity = Inner::new(Tape::new(graph, &flow.velocity));
        let field = Inner::new(Tape::new(graph, &[flow.field]));
        Flowed::new(velocity, field, flow.precision)
    }
}

impl<const N: usize> Code<N> for Inner<N> {
    type Part = Noise;

    fn class(&self) -> Class {
        self.tape.class()
    }

    fn parts(&self) -> Parts<'_, Noise> {
        self.parts.as_ref().map_or(Parts::Any, Simple::parts)
    }

    fn is_gradient(&self) -> bool {
        self.is_gradient
    }

    fn runner<T: Number>(&self) -> impl FnMut(&[T; 3]) -> [T; N] {
        let mut evaluator = Evaluator::<T>::new(self.tape.clone());
        move |p| {
            evaluator.eval(p);
            std::array::from_fn(|k| evaluator.output(k).clone())
        }
    }
}

/// Whether what a flow carries has a value wherever the flow may carry points of a region to: the region is put through
/// the steps as it is.
pub(super) fn is_defined(flowed: &Flowed, region: [Interval; 3]) -> bool {
    let (velocity, field) = (&flowed.velocity().tape, &flowed.field().tape);
    let (mut speeds, mut is_defined) = (flowed.velocity().runner::<Interval>(), true);
    let still = Interval::point(0.0);
    let speed = |at: &[Interval; 3]| {
        is_defined = is_defined && velocity.is_defined(at);
        // What does not matter any more takes no time either.
        if is_defined { speeds(at) } else { [still; 3] }
    };
    let end = flow::advect(speed, flowed.steps(), &region, |v| *v == still);
    is_defined && field.is_defined(&end)
}

/// Whether there may be regions where a flow carries nothing: its velocity may end somewhere.
pub(super) fn may_rest(flowed: &Flowed) -> bool {
    flowed.velocity().tape.has_choices()
}

/// What is left of the field that a flow carries, over a region in which that carries nothing. Points are not carried from
/// where the velocity is zero, so that it does not matter what is around the region.
pub(super) fn resting(flowed: &Flowed, region: &[Interval; 3]) -> Option<Tape> {
    let rests = may_rest(flowed) && flowed.velocity().tape.is_zero(region);
    rests.then(|| flowed.field().tape.prune(region))
}

impl Tape {
    /// Adds the instructions to others that compute the point, and gives the slot of the first output.
    pub(super) fn append_to(&self, code: &mut Vec<Instr>, origins: &mut Vec<NodeId>, point: [u32; 3]) -> u32 {
        let mut moved: Vec<u32> = Vec::with_capacity(self.code.len());
        for (slot, instr) in self.code.iter().enumerate() {
            if let Instr::Coordinate(axis) = instr {
                moved.push(point[*axis]);
                continue;
            }
            let mut instr = instr.clone();
            instr.map_args(|a| moved[a as usize]);
            code.push(instr);
            origins.extend(self.origins.get(slot));
            moved.push(code.len() as u32 - 1);
        }
        moved[self.outputs[0] as usize]
    }

    /// What the tape is, where it is nothing but a field carried by a flow, asked at the point itself.
    pub fn flowed(&self) -> Option<&Arc<Flowed>> {
        let Instr::Flow(flowed, p) = &self.code[*self.outputs.first()? as usize] else { return None };
        self.is_point(p).then_some(flowed)
    }

    /// In how many steps each flow carries that there is, also within what others carry or are carried by. (Each tape that has a
    /// flow has its own.)
    pub fn flow_steps(&self) -> Vec<u32> {
        let mut steps = Vec::new();
        for instr in &self.code {
            if let Instr::Flow(flowed, _) = instr {
                steps.extend(flowed.velocity().tape.flow_steps());
                steps.extend(flowed.field().tape.flow_steps());
                steps.push(flowed.steps());
            }
        }
        steps
    }

    /// Whether these are the coordinates themselves.
    fn is_point(&self, p: &[u32; 3]) -> bool {
        (0..3).all(|axis| matches!(self.code[p[axis] as usize], Instr::Coordinate(own) if own == axis))
    }

    /// Whether the three outputs are one and the same sum, with constant factors, of the slopes of noises along the three
    /// axes.
    fn is_gradient(&self) -> bool {
        let [x, y, z] = self.outputs[..] else { return false };
        let (mut waiting, mut seen) = (vec![[x, y, z]], HashSet::from([[x, y, z]]));
        while let Some(slots) = waiting.pop() {
            let Some(parts) = self.as_gradient(slots) else { return false };
            waiting.extend(parts.into_iter().filter(|part| seen.insert(*part)));
        }
        true
    }

    /// What three slots must be the gradient of for all of them together to be one: none where they are no gradient,
    /// nothing where they are that of a noise.
    fn as_gradient(&self, slots: [u32; 3]) -> Option<Vec<[u32; 3]>> {
        let are_slopes = |noises: [&Noise; 3], places: [&[u32; 3]; 3]| {
            let whole = noises.map(|n| Noise { part: Part::Value, ..*n });
            let along = |k: usize| noises[k].part == Part::Slope(k as u8);
            let same = whole[0] == whole[1] && whole[0] == whole[2];
            (same && (0..3).all(along) && places.into_iter().all(|p| self.is_point(p))).then(Vec::new)
        };
        match slots.map(|slot| &self.code[slot as usize]) {
            [Instr::Scale(x, a), Instr::Scale(y, b), Instr::Scale(z, c)] => {
                (a == b && a == c).then(|| vec![[*x, *y, *z]])
            }
            [Instr::Op(f, x), Instr::Op(g, y), Instr::Op(h, z)] => {
                let sums = f == g && f == h && matches!(f, Op::Add(_) | Op::Sub(_) | Op::Neg(_));
                sums.then(|| (0..f.arity()).map(|k| [x[k], y[k], z[k]]).collect())
            }
            [Instr::Noise(a, p), Instr::Noise(b, q), Instr::Noise(c, r)] => are_slopes([a, b, c], [p, q, r]),
            [
                Instr::Fractal(a, p, [None, None]),
                Instr::Fractal(b, q, [None, None]),
                Instr::Fractal(c, r, [None, None]),
            ] => {
                let [a, b, c] = [a, b, c].map(|f| f.recipe());
                let alike = |other: &Recipe| Recipe { noise: a.noise, ..other.clone() } == *a;
                let same = alike(b) && alike(c) && !a.rotate;
                same.then(|| are_slopes([&a.noise, &b.noise, &c.noise], [p, q, r]))?
            }
            _ => None,
        }
    }
}
