//! How a field at the end of a trajectory looks from the start: the way back through the steps. See [`tube`](super::tube).

use super::matrix::{
    Symmetric, UP, Vector, congruent, largest, length, six, spread, transposed_times, vector,
};
use super::pack::{BALLS, Pack};
use super::stage::Roundings;
use super::tube::{Ball, Step};
use crate::num::{Bounds, Interval, Local, Point, ROUNDOFF, Taylors};

/// What is known of the field as it looks from a place on the way back.
struct Sight {
    /// Its gradient in the middle, and how much that varies over the ball.
    p: Vector,
    turn: Pack,
    /// Second derivatives by the start that have come together so far, and what the linear and the quadratic expansion
    /// leave out.
    hess: Symmetric,
    bow: Pack,
    rest: Pack,
    /// Bound on second derivatives by the start all over the ball, as far as they come from behind.
    bent: Pack,
    /// What the value in the middle may be off by.
    off: Pack,
}

/// For each stage, from the last to the first: the share of the step that its velocity has, and the share of the
/// step at which the next stage lies in its direction.
const STAGES: [(usize, f64, f64); 4] =
    [(3, 1.0 / 6.0, 0.0), (2, 1.0 / 3.0, 1.0), (1, 1.0 / 3.0, 0.5), (0, 1.0 / 6.0, 0.5)];

/// A field over the balls that those at the start have become; derivatives in units of space.
struct Ending {
    value: Pack,
    grad: Vector,
    hess: Symmetric,
    bow: [Pack; 2],
    turn: Pack,
    twist: Pack,
    steep: Pack,
    bent: Pack,
    /// How far it may be from the value in the middle.
    reach: Pack,
}

impl Ending {
    #[inline(always)]
    fn new(f: &Taylors<BALLS>, radius: Pack) -> Ending {
        let (scale, lanes) = (radius.inverse(), std::array::from_fn::<_, BALLS, _>(|i| f.lane(i)));
        let mut out = Ending {
            value: Pack::from_fn(|i| lanes[i].value),
            grad: [Pack::ZERO; 3],
            hess: [Pack::ZERO; 6],
            bow: [0, 1].map(|k| Pack::from_fn(|i| lanes[i].bow[k])),
            turn: scale * Pack::from_fn(|i| lanes[i].turn[0]),
            twist: scale * scale * Pack::from_fn(|i| lanes[i].twist),
            steep: scale * Pack::from_fn(|i| lanes[i].steepness()),
            bent: scale * scale * Pack::from_fn(|i| lanes[i].curvature()),
            reach: Pack::from_fn(|i| lanes[i].range.hi - lanes[i].value)
                .larger(Pack::from_fn(|i| lanes[i].value - lanes[i].range.lo))
                .least(f64::INFINITY * Pack::ONE),
        };
        for k in 0..3 {
            out.grad[k] = scale * Pack::from_fn(|i| lanes[i].grad[k]);
        }
        for k in 0..6 {
            out.hess[k] = scale * scale * Pack::from_fn(|i| lanes[i].hess[k]);
        }
        out
    }
}

impl Sight {
    #[inline(always)]
    fn new(f: &Ending, ball: &Ball, rounding: Roundings) -> Sight {
        let cross = 0.5 * ((2.0 * ball.radius + ball.rest) * ball.rest);
        Sight {
            p: f.grad,
            turn: f.turn,
            hess: congruent(&ball.linear, &f.hess),
            bow: f.bow[0],
            rest: f.bow[1] + spread(&f.hess) * cross,
            bent: f.bent * ball.steep * ball.steep,
            off: rounding.value,
        }
    }

    /// Back through a step of length `h`.
    #[inline(always)]
    fn pass(&mut self, step: &Step, h: f64) {
        let (p, turn, size) = (self.p, self.turn, length(&self.p));
        self.off += size * step.off;
        self.bow += size * step.rounding;
        self.rest += size * step.rounding;
        let (mut back, mut back_turn, mut turned) = ([Pack::ZERO; 3], Pack::ZERO, turn);
        for (stage, share, lead) in STAGES {
            let past = &step.stages[stage];
            let covector = vector(
                #[inline(always)]
                |k| h * share * p[k] + h * lead * back[k],
            );
            let (size, vary) = (length(&covector), h * share * turn + h * lead * back_turn);
            self.bow += size * (past.stage.bow + past.moved);
            self.rest += size * (past.stage.rest + past.moved);
            if let Some([x, y, z]) = &past.stage.hess {
                let hess = six(
                    #[inline(always)]
                    |k| covector[0] * x[k] + covector[1] * y[k] + covector[2] * z[k],
                );
                let (sum, seen) = (self.hess, congruent(&past.linear, &hess));
                self.hess = six(
                    #[inline(always)]
                    |k| sum[k] + seen[k],
                );
                self.rest += spread(&hess) * past.cross;
            }
            self.bent += (size + vary) * past.bent;
            back = transposed_times(&past.stage.slope, &covector);
            back_turn = past.stage.steep * vary + past.stage.turn * size;
            turned += back_turn;
            let p = self.p;
            self.p = vector(
                #[inline(always)]
                |k| p[k] + back[k],
            );
        }
        self.turn = UP * turned.least(step.steep * turn + step.turn * size);
    }
}

/// What a field at the end of trajectories looks like from the start.
pub(super) struct Seen {
    value: Pack,
    grad: Vector,
    /// How far below and above the tangent it may be, and by how much it sags for the square of the distance.
    bows: [Pack; 2],
    sag: Pack,
    lipschitz: Pack,
    hessian: Pack,
    /// How far gradients may be from the one in the middle as it is computed.
    turn: Pack,
    /// What the value and the gradient may be off by.
    off: [Pack; 2],
    /// How far it may be from the value in the middle; where that says more than the gradient, nothing else does.
    reach: Pack,
    is_near: [bool; BALLS],
}

#[inline(always)]
fn negated(s: &Symmetric) -> Symmetric {
    [-s[0], -s[1], -s[2], -s[3], -s[4], -s[5]]
}

/// A field at the ends of trajectories as it looks from the start, after steps of length `h`.
#[inline(always)]
pub(super) fn seen_back(
    f: &Taylors<BALLS>,
    ball: &Ball,
    (h, steps): (f64, &[Step]),
    rounding: Roundings,
) -> Seen {
    let f = Ending::new(f, ball.radius);
    let mut sight = Sight::new(&f, ball, rounding);
    for step in steps.iter().rev() {
        sight.pass(step, h);
    }
    let Sight { p, turn, hess, bow, rest, bent, off } = sight;
    let (r, own) = (ball.start, length(&p));
    let rounded_back = 512.0 * ROUNDOFF * (f.steep * ball.steep);
    let off_grad = (rounding.of_grad(f.steep) + (f.bent * ball.off).least(f.turn)) * ball.steep;
    let off_grad = UP * (f.steep * ball.blur + off_grad + rounded_back);
    // By sums over the stages, or by norms all the way.
    let bent = bent.least(f.steep * ball.bent + f.bent * ball.steep * ball.steep);
    let turned = (turn + rounded_back).least(bent * r + off_grad);
    let half = 0.5 * (1.0 + 256.0 * ROUNDOFF) * (r * r);
    let rounded = 8.0 * ROUNDOFF * (own * r);
    let bends = [largest(&negated(&hess)), largest(&hess)];
    let bows = [0, 1].map(|side| UP * (bow.least(half * bends[side].larger(Pack::ZERO) + rest) + rounded));
    // What the field itself leaves out shrinks with the square of the ball as its second derivatives say.
    let swerve = rest - f.bow[1] + 0.5 * (f.twist * ball.radius * ball.radius);
    let sag = bends[0].larger(bends[1]).larger(Pack::ZERO) + 2.0 * (swerve * (r * r).inverse()) + ball.loose;
    let whole = own * r + bows[0].larger(bows[1]);
    Seen {
        value: f.value,
        grad: p,
        bows,
        sag: UP * sag,
        lipschitz: UP * (f.steep * ball.steep).least(own + turned),
        hessian: UP * bent,
        turn: UP * turned,
        off: [UP * off, off_grad],
        reach: f.reach,
        is_near: std::array::from_fn(|i| whole.0[i] <= f.reach.0[i]),
    }
}

impl Seen {
    /// A lane, with what its jet in the middle may be off by.
    pub fn local(&self, i: usize) -> (Local, [f64; 3]) {
        let infinite = f64::INFINITY;
        // A bound that is no number bounds nothing.
        let bound = |bound: Pack| if bound.0[i].is_nan() { infinite } else { bound.0[i] };
        let (value, lipschitz, off) = (self.value.0[i], bound(self.lipschitz), bound(self.off[0]));
        let (off_grad, sag) = (bound(self.off[1]), bound(self.sag));
        let bounds = Bounds { range: infinite, lipschitz, hessian: infinite, third: infinite };
        // The range is that of the bow, which need not have zero in its middle.
        if !self.is_near[i] {
            let jet = Point { value, ..Point::default() };
            let bow = Interval::radius(self.reach.0[i]);
            return (Local { jet, bounds, bow, sag: infinite, turn: infinite }, [off, 0.0, 0.0]);
        }
        let jet = Point { value, grad: self.grad.map(|g| g.0[i]), hess: [0.0; 6] };
        let bow = Interval { lo: -self.bows[0].0[i], hi: self.bows[1].0[i] };
        // Without a bound on second derivatives the gradient serves the bow alone, which holds for it as it is computed.
        let is_bounded = self.hessian.0[i].is_finite() && off_grad.is_finite();
        let (hessian, off_grad) = if is_bounded { (self.hessian.0[i], off_grad) } else { (infinite, 0.0) };
        let turn = bound(self.turn);
        (Local { jet, bounds: Bounds { hessian, ..bounds }, bow, sag, turn }, [off, off_grad, 0.0])
    }
}
