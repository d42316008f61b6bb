//! A ray on its way through cubes.
//!
//! Values are cheap beside what is known of a ball. So where a cube is large enough for many rays to pass it, its middle is
//! asked for first, which all of them share: with a bound on the gradients, the ball of radius `value / steep` around it is
//! free. A cube that few rays pass is asked at the ray itself: it is free as far as the field, which falls no faster than
//! `rate`, stays above zero.
//!
//! Where that does not take the ray on, the field is expanded over the ball around the cube. Along the ray it is a line but
//! for `bow` then, with slopes that are no further than `turn` from that of the line. So the ray
//!
//! - is free up to where the line comes down to `bow`;
//! - is free all along where it rises for sure, if it begins outside;
//! - meets the surface once at most where it falls for sure: it does if the field is below zero where the ray leaves the
//!   cube, and then the root is found from values at points, each of which leaves a stretch for it that follows from its
//!   value and the least and the largest slope;
//! - else looks at the part of the cube that it is in, with better bounds on gradients.

use super::tree::{Cube, Fact, Tree};
use crate::cast::{Hit, Ray};
use crate::num::ROUNDOFF;
use glam::DVec3;

// All were chosen on figures 9.8 and 9.9 of the thesis; minima are flat.

/// Slopes along a ray are taken to be those of a fall where they vary by no more than this share.
const STEADY: f64 = 0.95;

/// A value at a ray takes it on if it is free for so much of its way through the cube.
const WORTH: f64 = 0.2;

/// The ball around a cube is asked about where the value in the middle is no more than what it may vary by in the ball
/// times this: else the surface is hardly in it.
const NEAR: f64 = 0.6;

/// Cubes whose balls are as large as this many tolerances are passed by many rays: a pixel in pictures.
const MANY: f64 = 500.0;

/// Steps after which a ray is given up.
const PATIENCE: u32 = 100_000;

/// What a ray wants to know next.
pub(super) enum Next {
    /// The value in the middle of a cube.
    Middle(Cube),
    /// What the field is like around a cube.
    Fact(Cube),
    /// Its value so far along the ray.
    Value(f64),
    /// Nothing any more.
    Done(Hit),
    /// Nothing, though it could not tell whether it meets anything from here on.
    GivenUp(f64),
}

/// A ray under way.
pub(super) struct Walk {
    /// Its number in the group.
    pub ray: usize,
    line: Ray,
    /// Whether any place inside will do.
    any: bool,
    /// All before is free.
    t: f64,
    /// Whether the field is known to be above zero there, or is by continuity.
    is_outside: bool,
    cube: Cube,
    /// Times that its cubes are cut at most.
    deepest: u32,
    steps: u32,
    /// What it asked for, whether that was known or not; and of that, what was about cubes.
    pub asked: [u64; 2],
    /// What is known in the cube, and in those around it, the largest first.
    bounds: Vec<Bounds>,
    doing: Doing,
}

/// Bounds on the field in a cube.
#[derive(Clone, Copy)]
struct Bounds {
    /// On the length of gradients.
    steep: f64,
    /// On how fast it falls along the ray.
    rate: f64,
    /// Where it is expected to be zero along the ray; no number if nothing is.
    root: f64,
}

/// What a ray is doing.
#[derive(Clone, Copy)]
enum Doing {
    /// Comes into a cube.
    Coming,
    /// Looks at all that there is to know of its cube.
    Looking,
    /// Asks how far it is free from here at least.
    Striding,
    /// Asks whether it begins inside.
    Beginning,
    /// Asks whether it is inside where it leaves a cube, in which it falls.
    Leaving(Fall, f64),
    /// Finds a root between two places, from the value at a third.
    Falling(Fall, [f64; 2], f64, Option<(f64, f64)>),
    Done(Hit),
    GivenUp,
}

/// How a field falls along a ray: as a line that has `value` where the ray is, with slopes no further than `turn` from its own.
#[derive(Clone, Copy)]
struct Fall {
    value: f64,
    slope: f64,
    turn: f64,
}

impl Walk {
    /// A ray through a field whose gradients are no longer than `steep`.
    pub fn new(number: usize, ray: &Ray, any: bool, (tree, steep): (&Tree, f64)) -> Walk {
        let nothing = Hit { certified: ray.near > ray.far, ..Hit::MISS };
        let doing = if ray.near <= ray.far { Doing::Coming } else { Doing::Done(nothing) };
        Walk {
            ray: number,
            line: *ray,
            any,
            t: ray.near,
            is_outside: false,
            cube: Cube::default(),
            deepest: tree.deepest(ray),
            steps: 0,
            asked: [0; 2],
            bounds: vec![Bounds { steep, rate: steep, root: f64::NAN }],
            doing,
        }
    }

    /// Goes on as far as it can with what the tree knows.
    pub fn next(&mut self, tree: &Tree) -> Next {
        loop {
            self.steps += 1;
            match self.doing {
                _ if self.steps > PATIENCE => return Next::GivenUp(self.t),
                Doing::Coming if !self.bounds().steep.is_finite() => self.doing = Doing::Looking,
                Doing::Coming if !self.is_among_many(tree) => self.go_on(tree),
                Doing::Coming => match tree.value(self.cube) {
                    Some(value) => self.come(tree, value),
                    None => return Next::Middle(self.cube),
                },
                Doing::Looking => match tree.fact(self.cube) {
                    Some(fact) => self.look(tree, fact),
                    None => return Next::Fact(self.cube),
                },
                Doing::Striding | Doing::Beginning => return Next::Value(self.t),
                Doing::Leaving(_, exit) => return Next::Value(exit),
                Doing::Falling(_, _, at, _) => return Next::Value(at),
                Doing::Done(hit) => return Next::Done(hit),
                Doing::GivenUp => return Next::GivenUp(self.t),
            }
        }
    }

    fn bounds(&self) -> Bounds {
        let level = self.cube.level as usize;
        self.bounds[level.min(self.bounds.len() - 1)]
    }

    /// What values may be off by along the ray up to `t` because places are rounded, for the bound on gradients here.
    fn slack(&self, tree: &Tree, t: f64) -> f64 {
        4.0 * self.bounds().steep * tree.rounding(&self.line, t.abs())
    }

    /// Counts a question.
    fn count(&mut self, is_of_cube: bool) {
        self.asked[0] += 1;
        self.asked[1] += u64::from(is_of_cube);
    }

    /// Whether many rays pass the cube.
    fn is_among_many(&self, tree: &Tree) -> bool {
        tree.ball(self.cube).1 > MANY * self.line.tolerance.at(self.t)
    }

    fn exit(&self, tree: &Tree) -> f64 {
        tree.exit(&self.line, self.t, self.cube).min(self.line.far)
    }

    /// Goes on with the value in the middle of its cube.
    pub fn come(&mut self, tree: &Tree, value: f64) {
        self.count(true);
        let ((middle, radius), Bounds { steep, .. }) = (tree.ball(self.cube), self.bounds());
        let exit = self.exit(tree);
        // A hair less, for what is rounded.
        let free = (1.0 - 1e-9) * (value - self.slack(tree, exit)) / steep;
        if free > radius {
            return self.pass(tree, exit);
        }
        if let Some(end) = end_in_ball(&self.line, self.t, middle, free) {
            if end >= exit {
                return self.pass(tree, exit);
            }
            (self.t, self.is_outside) = (self.t.max(end), true);
        }
        if free > NEAR * radius {
            self.go_deeper(tree);
        } else {
            self.doing = Doing::Looking;
        }
    }

    /// Goes on with what is known around its cube.
    pub fn look(&mut self, tree: &Tree, fact: &Fact) {
        self.count(true);
        let (middle, radius) = tree.ball(self.cube);
        let exit = self.exit(tree);
        let line = self.line;
        let at = |t: f64| fact.value + fact.grad.dot(line.at(t) - middle);
        // Places are rounded, and so is what is found from them.
        let bow = fact.bow + 4.0 * fact.steep * tree.rounding(&line, exit.abs().max(self.t.abs()));
        let (slope, turn) = (fact.grad.dot(line.direction), fact.turn + 8.0 * ROUNDOFF * fact.steep);
        let (here, there) = (at(self.t) - bow, at(exit) - bow);
        if fact.least > 0.0 || (here > 0.0 && there > 0.0) {
            return self.pass(tree, exit);
        }
        if here > 0.0 {
            self.is_outside = true;
            self.t += (1.0 - 1e-9) * (here / (here - there)) * (exit - self.t);
        }
        self.know(fact.steep, turn - slope, self.t - at(self.t) / slope);
        if turn < -STEADY * slope {
            let fall = Fall { value: at(self.t), slope, turn };
            if there + 2.0 * bow < 0.0 {
                self.cross(tree, fall, exit, None);
            } else {
                self.doing = Doing::Leaving(fall, exit);
            }
        } else if turn < slope {
            if self.is_outside {
                self.pass(tree, exit);
            } else {
                self.doing = Doing::Beginning;
            }
        } else if 2.0 * radius <= self.line.tolerance.at(self.t) {
            self.doing = Doing::Done(Hit { t: self.t, certified: fact.is_defined });
        } else {
            self.go_deeper(tree);
        }
    }

    /// Goes on with the value that it asked for.
    pub fn learn(&mut self, tree: &Tree, value: f64) {
        self.count(false);
        match self.doing {
            _ if value.is_nan() => self.doing = Doing::Done(Hit { t: self.t, certified: false }),
            Doing::Striding if value > 0.0 => self.stride(tree, value),
            Doing::Beginning if value > 0.0 => (self.is_outside, self.doing) = (true, Doing::Looking),
            Doing::Striding | Doing::Beginning => {
                self.doing = Doing::Done(Hit { t: self.t, certified: true });
            }
            Doing::Leaving(fall, exit) => self.leave(tree, fall, exit, value),
            Doing::Falling(fall, between, at, last) => self.fall(tree, fall, between, (at, value), last),
            Doing::Coming | Doing::Looking | Doing::Done(_) | Doing::GivenUp => {}
        }
    }

    /// Takes bounds in its cube into account.
    fn know(&mut self, steep: f64, rate: f64, root: f64) {
        let (before, level) = (self.bounds(), self.cube.level as usize);
        let least = |a: f64, b: f64| if a < b { a } else { b };
        self.bounds.resize(level + 1, before);
        self.bounds[level] =
            Bounds { steep: least(steep, before.steep), rate: least(rate, before.rate).max(0.0), root };
    }

    /// Strides, unless the surface is expected in the cube or not far behind it.
    fn go_on(&mut self, tree: &Tree) {
        let (root, ahead) = (self.bounds().root, self.exit(tree) - self.t);
        let is_near = root > self.t - ahead && root < self.t + WORTH * ahead;
        self.doing = if is_near { Doing::Looking } else { Doing::Striding };
    }

    /// Goes on with a value here, which is above zero.
    fn stride(&mut self, tree: &Tree, value: f64) {
        let (exit, Bounds { rate, .. }) = (self.exit(tree), self.bounds());
        let above = value - self.slack(tree, exit);
        if above <= 0.0 {
            self.doing = Doing::Looking;
            return;
        }
        let to = self.t + (1.0 - 1e-9) * above / rate;
        if to >= exit {
            return self.pass(tree, exit);
        }
        let is_worth = to - self.t > WORTH * (exit - self.t);
        (self.t, self.is_outside) = (to, true);
        if is_worth {
            self.go_on(tree);
        } else {
            self.doing = Doing::Looking;
        }
    }

    /// Looks at the part of its cube that it is in.
    fn go_deeper(&mut self, tree: &Tree) {
        if self.cube.level >= self.deepest {
            self.doing = Doing::GivenUp;
            return;
        }
        let bounds = self.bounds();
        self.bounds.resize(self.cube.level as usize + 1, bounds);
        self.cube = tree.part(self.cube, &self.line, self.t);
        self.doing = Doing::Coming;
    }

    /// Leaves a cube behind, and goes on in the largest one ahead.
    fn pass(&mut self, tree: &Tree, exit: f64) {
        let before = self.t;
        (self.t, self.is_outside, self.doing) = (exit, true, Doing::Coming);
        if exit >= self.line.far {
            self.doing = Doing::Done(Hit::MISS);
            return;
        }
        let ahead = tree.cube(&self.line, exit, self.cube.level);
        if ahead == self.cube && exit <= before {
            self.doing = Doing::GivenUp;
            return;
        }
        self.cube = self.cube.largest_around(ahead);
        self.bounds.truncate((self.cube.level as usize).max(1));
    }

    /// Leaves a cube in which it falls, with the value there: inside, or outside; or so close to the surface that nobody can
    /// tell, and then it meets it there, if it falls fast enough for that to be no further than the tolerance ahead.
    fn leave(&mut self, tree: &Tree, fall: Fall, exit: f64, value: f64) {
        let slack = self.slack(tree, exit);
        let early = exit - 2.0 * slack / (-fall.slope - fall.turn);
        if value > slack {
            self.pass(tree, exit);
        } else if value < -slack {
            self.cross(tree, fall, exit, Some((exit, value)));
        } else if exit - early <= self.line.tolerance.at(early) {
            self.doing = Doing::Done(Hit { t: early.max(self.t), certified: true });
        } else {
            self.go_deeper(tree);
        }
    }

    /// Meets the surface once before `exit`, where it is inside.
    fn cross(&mut self, tree: &Tree, fall: Fall, exit: f64, last: Option<(f64, f64)>) {
        if self.any {
            self.doing = Doing::Done(Hit { t: self.t, certified: true });
            return;
        }
        let guess = (self.t - fall.value / fall.slope).clamp(self.t, exit);
        match last {
            Some(last) => self.fall(tree, fall, [self.t, exit], last, None),
            None => self.doing = Doing::Falling(fall, [self.t, exit], guess, None),
        }
    }

    /// Closes in on a root with a value.
    fn fall(
        &mut self,
        tree: &Tree,
        fall: Fall,
        [from, to]: [f64; 2],
        (at, value): (f64, f64),
        last: Option<(f64, f64)>,
    ) {
        let (least, most) = (-fall.slope - fall.turn, -fall.slope + fall.turn);
        let slack = self.slack(tree, to);
        // What is above zero comes down to it no sooner than at the largest slope, what is below has at the least.
        let [low, high] = [value - slack, value + slack];
        let from = from.max(at + low / if low > 0.0 { most } else { least });
        let to = to.min(at + high / if high > 0.0 { least } else { most });
        // The slope between this place and the one before, if there is one that it can be.
        let secant = last.map_or(-fall.slope, |(t, v)| ((value - v) / (t - at)).clamp(least, most));
        let secant = if secant.is_nan() { -fall.slope } else { secant };
        let guess = (at + value / secant).max(from).min(to);
        // Half of the tolerance is left for what is rounded.
        let is_close = to - from <= 0.5 * self.line.tolerance.at(from);
        self.doing = if is_close {
            Doing::Done(Hit { t: from.max(self.t), certified: true })
        } else if guess == at || value.abs() <= slack {
            self.t = from.max(self.t);
            Doing::GivenUp
        } else {
            Doing::Falling(fall, [from, to], guess, Some((at, value)))
        };
    }
}

/// Where a ray that is in a ball at `t` leaves it; none where it is not.
fn end_in_ball(ray: &Ray, t: f64, middle: DVec3, radius: f64) -> Option<f64> {
    let from = ray.at(t) - middle;
    let (along, inside) = (from.dot(ray.direction), radius * radius - from.length_squared());
    (radius > 0.0 && inside > 0.0).then(|| t - along + (along * along + inside).sqrt())
}
