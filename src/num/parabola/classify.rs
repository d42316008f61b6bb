//! Where solids that are put together are inside and outside for certain.
//!
//! The minimum of fields is negative where one of them is, and their maximum where all are. So along a line what is known of
//! the signs of each is put together as sets of places (S. D. Roth, *Ray casting for modeling solids*, 1982), and nothing is
//! lost where one takes over from the other, as it is of values: along a line past the edge of a box one of its faces is above
//! it up to a place, and the next one from a place before that. Forms are needed of the *leaves* alone, what is put together.
//!
//! Most leaves are far away: where a field is on one side of zero all over the pieces of a batch the other one decides alone.

use super::band::Band;
use super::{Half, Parabola, Parabolas, choose};
use crate::num::simd::widest;
use crate::num::{Interval, Real};

/// What fields are put together, each after its arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A field, by a number of the caller's.
    Leaf(u32),
    /// The negative of the last one.
    Turned,
    /// Of the last one, and of the one before that, which is so many parts earlier: the maximum,
    All(u32),
    /// or the minimum.
    Any(u32),
}

impl Part {
    /// Which of two that are in these ranges decides of the sign of their maximum, or minimum, alone: it is on the side that
    /// decides, or the other one is on the side that leaves it to it.
    #[inline(always)]
    fn alone(self, [a, b]: [Interval; 2]) -> [bool; 2] {
        let is_all = matches!(self, Part::All(_));
        let decides = |x: Interval| if is_all { x.lo > 0.0 } else { x.hi < 0.0 };
        let yields = |x: Interval| if is_all { x.hi < 0.0 } else { x.lo > 0.0 };
        [decides(a) | yields(b), decides(b) | yields(a)]
    }
}

/// What there is to be put together, by names of the caller's.
pub enum Joint<N> {
    Leaf(u32),
    /// The same as another one, or its negative.
    Same(N),
    Turned(N),
    /// The maximum of two, or the minimum.
    All(N, N),
    Any(N, N),
}

/// The parts of something; `joint` knows what is put together, and is asked once about each.
pub fn parts_of<N>(root: N, mut joint: impl FnMut(N) -> Joint<N>) -> Vec<Part> {
    enum Step<N> {
        Visit(N),
        /// Tell a part where the one begins that is before its last argument.
        Before(usize),
    }
    // From the last part to the first.
    let (mut parts, mut left) = (Vec::new(), vec![Step::Visit(root)]);
    while let Some(step) = left.pop() {
        let name = match step {
            Step::Visit(name) => name,
            Step::Before(last) => {
                let before = (parts.len() - last) as u32;
                if let Part::All(first) | Part::Any(first) = &mut parts[last] {
                    *first = before;
                }
                continue;
            }
        };
        let (part, arguments) = match joint(name) {
            Joint::Leaf(number) => (Some(Part::Leaf(number)), [None, None]),
            Joint::Same(of) => (None, [Some(of), None]),
            Joint::Turned(of) => (Some(Part::Turned), [Some(of), None]),
            Joint::All(first, last) => (Some(Part::All(0)), [Some(last), Some(first)]),
            Joint::Any(first, last) => (Some(Part::Any(0)), [Some(last), Some(first)]),
        };
        let [last, first] = arguments;
        if let Some(first) = first {
            left.extend([Step::Visit(first), Step::Before(parts.len())]);
        }
        left.extend(last.map(Step::Visit));
        parts.extend(part);
    }
    parts.reverse();
    parts
}

/// The forms over a piece of what decides of the sign there.
#[derive(Clone, Debug)]
pub struct Mix<const K: usize> {
    /// Leaves are by their place in the list.
    pub parts: Vec<Part>,
    pub leaves: Vec<Parabola<K>>,
}

impl<const K: usize> Mix<K> {
    /// A leaf that decides alone.
    pub fn of(leaf: Parabola<K>) -> Self {
        Mix { parts: vec![Part::Leaf(0)], leaves: vec![leaf] }
    }
}

/// What is certain of one half of each piece of a batch: as of [`Half::above`], and where it would end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch<const B: usize> {
    pub(super) from: [f64; B],
    pub(super) to: [f64; B],
    pub(super) reach: [f64; B],
}

impl<const B: usize> Stretch<B> {
    pub(super) const NONE: Self = Stretch { from: [1.0; B], to: [1.0; B], reach: [1.0; B] };

    /// Sets a lane to a stretch and its reach; or to all of the half, if that is known.
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, [from, to, reach]: [f64; 3], all: bool) {
        (self.from[i], self.to[i]) = (choose(all, 0.0, from), choose(all, 1.0, to));
        self.reach[i] = choose(reach > 1.0, reach, 1.0);
    }

    /// Where either is certain, as far as that is one stretch: else the one nearer to the middle.
    #[inline(always)]
    fn or(&mut self, other: &Self, alone: &[[bool; 2]; B]) {
        for i in 0..B {
            let (a, b) = ([self.from[i], self.to[i]], [other.from[i], other.to[i]]);
            let first = a[0] <= b[0];
            let [from, end] = [choose(first, a[0], b[0]), choose(first, a[1], b[1])];
            let [start, to] = [choose(first, b[0], a[0]), choose(first, b[1], a[1])];
            self.from[i] = from;
            self.to[i] = choose((start <= end) & (to > end), to, end);
            self.go_on(other, i, alone[i], self.reach[i] > other.reach[i]);
        }
    }

    /// Where both are.
    #[inline(always)]
    fn and(&mut self, other: &Self, alone: &[[bool; 2]; B]) {
        for i in 0..B {
            let from = choose(self.from[i] > other.from[i], self.from[i], other.from[i]);
            let to = choose(self.to[i] < other.to[i], self.to[i], other.to[i]);
            let some = from < to;
            (self.from[i], self.to[i]) = (choose(some, from, 1.0), choose(some, to, 1.0));
            self.go_on(other, i, alone[i], self.reach[i] < other.reach[i]);
        }
    }

    /// Where a lane would end: as the one does that decides alone, or else as is best.
    #[inline(always)]
    fn go_on(&mut self, other: &Self, i: usize, [own, others]: [bool; 2], is_own: bool) {
        self.reach[i] = choose(own | (!others & is_own), self.reach[i], other.reach[i]);
    }
}

/// What is known of the signs of a field along the pieces of a batch.
#[derive(Clone, Copy, Debug)]
pub struct Signs<const B: usize> {
    /// Of the field, as far as it matters for its sign.
    range: Band<B>,
    /// Backwards, then forwards.
    pub(super) above: [Stretch<B>; 2],
    pub(super) below: [Stretch<B>; 2],
    /// Where it is expected to be negative, in halves of the piece from the middle: from a place to another.
    expected: [[f64; B]; 2],
    /// The leaf that begins there, and whether it is its negative that does.
    leaf: [u32; B],
    turned: [bool; B],
    /// Whether that one alone has the same sign as the field all over the piece.
    alone: [bool; B],
}

/// What is expected of pieces matters from here on: they reach back behind what is known already.
const BEHIND: f64 = -0.5;

impl<const B: usize> Signs<B> {
    pub(super) fn of_leaf<const K: usize>(x: &Parabolas<B, K>, leaf: u32) -> Signs<B> {
        widest(
            #[inline(always)]
            || Signs {
                range: x.range,
                above: [x.above(-1.0), x.above(1.0)],
                below: [x.below(-1.0), x.below(1.0)],
                expected: x.expected(),
                leaf: [leaf; B],
                turned: [false; B],
                alone: [true; B],
            },
        )
    }

    #[inline(always)]
    fn turn(&mut self) {
        std::mem::swap(&mut self.above, &mut self.below);
        for i in 0..B {
            let [from, to] = [self.expected[0][i], self.expected[1][i]];
            // Of what is on both sides, the one that is ahead.
            let ends = (from > f64::NEG_INFINITY) & ((to == f64::INFINITY) | (from > BEHIND));
            let some = from < to;
            self.expected[0][i] = choose(some & !ends, to, f64::NEG_INFINITY);
            self.expected[1][i] = choose(some & ends, from, f64::INFINITY);
            self.turned[i] = !self.turned[i];
        }
    }

    /// Those of the maximum, or of the minimum, which is one of these parts, of both.
    #[inline(always)]
    fn with(&mut self, other: &Self, part: Part, [a, b]: [&Band<B>; 2]) {
        let mut alone = [[false; 2]; B];
        for i in 0..B {
            alone[i] = part.alone([a.lane(i), b.lane(i)]);
        }
        let is_all = matches!(part, Part::All(_));
        for k in 0..2 {
            let [or, and] = if is_all {
                [&mut self.above[k], &mut self.below[k]]
            } else {
                [&mut self.below[k], &mut self.above[k]]
            };
            let [others, other_ands] =
                if is_all { [&other.above[k], &other.below[k]] } else { [&other.below[k], &other.above[k]] };
            or.or(others, &alone);
            and.and(other_ands, &alone);
        }
        for i in 0..B {
            let both = [self.fall(i), other.fall(i)];
            let (is_others, expected) = if is_all { later(both) } else { earlier(both) };
            self.join(other, i, alone[i], is_others, expected);
        }
    }

    /// Where a lane is expected to be negative.
    #[inline(always)]
    fn fall(&self, i: usize) -> [f64; 2] {
        [self.expected[0][i], self.expected[1][i]]
    }

    /// Takes from another one, in a lane, what is expected of it: of both, or of the one that decides alone.
    #[inline(always)]
    fn join(&mut self, other: &Self, i: usize, alone: [bool; 2], is_others: bool, both: [f64; 2]) {
        let is_same = self.leaf[i] == other.leaf[i] && self.turned[i] == other.turned[i];
        let (from_other, expected, alone) = match alone {
            [true, _] => (false, self.fall(i), self.alone[i]),
            [_, true] => (true, other.fall(i), other.alone[i]),
            _ => (is_others, both, is_same && self.alone[i] && other.alone[i]),
        };
        (self.expected[0][i], self.expected[1][i], self.alone[i]) = (expected[0], expected[1], alone);
        if from_other {
            (self.leaf[i], self.turned[i]) = (other.leaf[i], other.turned[i]);
        }
    }

    /// What is known of a piece.
    #[inline]
    pub fn lane(&self, i: usize) -> Sign {
        let half = |k: usize| Half {
            above: [self.above[k].from[i], self.above[k].to[i]],
            below: [self.below[k].from[i], self.below[k].to[i]],
            reach: self.above[k].reach[i],
        };
        let [from, to] = self.fall(i);
        Sign {
            halves: [half(0), half(1)],
            fall: Some(from).filter(|_| from < to),
            range: self.range.lane(i),
            leaf: self.leaf[i],
            is_turned: self.turned[i],
            is_alone: self.alone[i],
        }
    }
}

/// Where both are expected to be negative, and whether the second one decides where that begins.
#[inline(always)]
fn later([x, y]: [[f64; 2]; 2]) -> (bool, [f64; 2]) {
    let is_second = y[0] > x[0];
    (is_second, [choose(is_second, y[0], x[0]), choose(y[1] < x[1], y[1], x[1])])
}

/// Where either is, as far as that matters, and whether the second one decides where that begins.
#[inline(always)]
fn earlier([x, y]: [[f64; 2]; 2]) -> (bool, [f64; 2]) {
    let counts = [x, y].map(|[from, to]| from < to && to > BEHIND);
    let is_second = counts[1] && (!counts[0] || y[0] < x[0]);
    let all = match counts {
        [true, true] if x[0] <= y[1] && y[0] <= x[1] => {
            [choose(is_second, y[0], x[0]), choose(y[1] > x[1], y[1], x[1])]
        }
        _ if is_second => y,
        _ => x,
    };
    (is_second, all)
}

/// What is known of the sign of a field along a piece.
#[derive(Clone, Copy, Debug)]
pub struct Sign {
    /// Backwards, then forwards.
    pub halves: [Half; 2],
    /// Where it is expected to become negative, in halves of the piece from the middle, if it is.
    pub fall: Option<f64>,
    /// The leaf that does so, and whether it is its negative that does.
    pub leaf: u32,
    pub is_turned: bool,
    /// Whether that one alone has the same sign as the field all over the piece.
    pub is_alone: bool,
    /// Encloses the field, as far as it matters for its sign.
    pub range: Interval,
}

/// Puts together the signs of a batch, with memory of its own.
#[derive(Debug)]
pub struct Classifier<const B: usize> {
    ranges: Vec<Band<B>>,
    /// Whether it takes the signs of a part.
    takes: Vec<bool>,
    stack: Vec<Signs<B>>,
}

impl<const B: usize> Default for Classifier<B> {
    fn default() -> Self {
        Classifier { ranges: Vec::new(), takes: Vec::new(), stack: Vec::new() }
    }
}

impl<const B: usize> Classifier<B> {
    /// The signs of the last of the parts, of which there is one at least; `leaf` knows the forms of leaves.
    pub fn classify<'a, const K: usize>(
        &mut self,
        parts: &[Part],
        leaf: impl Fn(u32) -> &'a Parabolas<B, K>,
    ) -> Signs<B> {
        if let [Part::Leaf(number)] = *parts {
            return Signs::of_leaf(leaf(number), number);
        }
        self.enclose(parts, &leaf);
        self.decide(parts);
        self.stack.clear();
        for (i, part) in parts.iter().enumerate().filter(|(i, _)| self.takes[*i]) {
            match *part {
                Part::Leaf(number) => self.stack.push(Signs::of_leaf(leaf(number), number)),
                Part::Turned => self.stack.iter_mut().last().into_iter().for_each(|last| {
                    widest(
                        #[inline(always)]
                        || last.turn(),
                    );
                }),
                Part::All(before) | Part::Any(before) => {
                    let (Some(b), Some(a)) = (self.stack.pop(), self.stack.last_mut()) else { continue };
                    let bands = [&self.ranges[i - before as usize], &self.ranges[i - 1]];
                    widest(
                        #[inline(always)]
                        || a.with(&b, *part, bands),
                    );
                }
            }
        }
        let mut signs = self.stack[0];
        signs.range = self.ranges[parts.len() - 1];
        signs
    }

    /// What decides of the sign in a lane of the batch that was classified last; `None` if that is more than so many leaves.
    pub fn mix<'a, const K: usize>(
        &self,
        parts: &[Part],
        (lane, most): (usize, usize),
        leaf: impl Fn(u32) -> &'a Parabolas<B, K>,
    ) -> Option<Mix<K>> {
        if let [Part::Leaf(number)] = *parts {
            return Some(Mix::of(leaf(number).lane(lane)));
        }
        let mut leaves = Vec::new();
        let parts = parts_of(parts.len() - 1, |i| match parts[i] {
            // Of what is too much nothing more is needed.
            _ if leaves.len() > most => Joint::Leaf(0),
            Part::Leaf(number) => {
                leaves.push(leaf(number).lane(lane));
                Joint::Leaf(leaves.len() as u32 - 1)
            }
            Part::Turned => Joint::Turned(i - 1),
            part @ (Part::All(before) | Part::Any(before)) => {
                let (first, last) = (i - before as usize, i - 1);
                match part.alone([first, last].map(|i| self.ranges[i].lane(lane))) {
                    [true, _] => Joint::Same(first),
                    [_, true] => Joint::Same(last),
                    _ if matches!(part, Part::All(_)) => Joint::All(first, last),
                    _ => Joint::Any(first, last),
                }
            }
        });
        (leaves.len() <= most).then_some(Mix { parts, leaves })
    }

    /// The ranges of all parts.
    fn enclose<'a, const K: usize>(&mut self, parts: &[Part], leaf: &impl Fn(u32) -> &'a Parabolas<B, K>) {
        self.ranges.clear();
        for (i, part) in parts.iter().enumerate() {
            let band = match *part {
                Part::Leaf(number) => leaf(number).range,
                Part::Turned => self.ranges[i - 1].map(|x| -x),
                Part::All(before) | Part::Any(before) => {
                    let (a, b) = (self.ranges[i - before as usize], self.ranges[i - 1]);
                    let is_all = matches!(part, Part::All(_));
                    a.with(&b, |a, b| if is_all { a.max(b) } else { a.min(b) })
                }
            };
            self.ranges.push(band);
        }
    }

    /// Decides which parts are taken, from the last one back: not one of which an argument decides alone in all lanes.
    fn decide(&mut self, parts: &[Part]) {
        let Classifier { ranges, takes, .. } = self;
        takes.clear();
        takes.resize(parts.len(), false);
        takes[parts.len() - 1] = true;
        for i in (0..parts.len()).rev() {
            let (part, is_taken) = (parts[i], takes[i]);
            match part {
                Part::Leaf(_) => {}
                Part::Turned => takes[i - 1] = is_taken,
                Part::All(before) | Part::Any(before) => {
                    let (first, last) = (i - before as usize, i - 1);
                    let (a, b) = (&ranges[first], &ranges[last]);
                    let is_first = is_taken && a.every(b, |a, b| part.alone([a, b])[0]);
                    let is_last = is_taken && a.every(b, |a, b| part.alone([a, b]) == [false, true]);
                    takes[i] = is_taken && !is_first && !is_last;
                    (takes[first], takes[last]) = (is_taken && !is_last, is_taken && !is_first);
                }
            }
        }
    }
}
