//! Which terms of a field make it steep.
//!
//! A *term* is where slope begins: a noise, a grid, a shape, a flow, or an operation on coordinates that are at most
//! moved and turned, such as the `length` of a sphere. All that is made of terms only passes slope on. By the chain rule
//!
//! ```text
//! |grad f|  <=  sum |df/da_k| |grad a_k|        over the arguments a_k of the operation that f is
//! ```
//!
//! so the slope of an operation is shared out among its arguments in proportion to the addends on the right, and the
//! share of each argument likewise, down to the terms. Nothing is lost or added on the way: shares are never negative and
//! sum to one. Over a region the slopes and partial derivatives are bounds, and the shares say which terms force the
//! bound of the field up; at a point they are what they are, and say which term the slope there comes from. Of a minimum
//! that is decided, only the side that it is has a share.
//!
//! Shares cannot say what remains without a term, since slopes also cancel; [`Terms::bound_without`] computes that.

use crate::expr::NodeId;
use crate::num::{Dual, Interval, Slope};
use crate::op::Op;
use crate::tape::{Evaluator, Instr, Tape};
use std::sync::Arc;

/// A field as what its slope comes from.
#[derive(Clone, Debug)]
pub struct Terms {
    tape: Arc<Tape>,
    kinds: Vec<Kind>,
}

/// What an instruction is a function of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    /// Nothing.
    Constant,
    /// Coordinates, linearly.
    Linear,
    /// Slope begins here.
    Term,
    /// Terms, among others.
    Sum,
}

/// The bound of a field's slope over a region, and what it comes from.
#[derive(Clone, Debug)]
pub struct Steepness {
    /// `|grad f|` is nowhere larger.
    pub bound: f64,
    /// Instructions with their shares of the bound, which sum to one.
    pub shares: Vec<(u32, f64)>,
    slopes: Evaluator<Slope>,
}

impl Steepness {
    /// Bound of the slope of an instruction.
    pub fn bound_of(&self, slot: u32) -> f64 {
        self.slopes.value(slot).norm
    }
}

impl Terms {
    /// The terms of the first output of a tape.
    pub fn new(tape: Arc<Tape>) -> Terms {
        let mut kinds: Vec<Kind> = Vec::with_capacity(tape.len());
        for instr in tape.code() {
            kinds.push(kind(instr, &kinds));
        }
        Terms { tape, kinds }
    }

    /// The node that an instruction computes.
    pub fn node(&self, slot: u32) -> NodeId {
        self.tape.origins()[slot as usize]
    }

    /// The instruction that computes the field.
    pub fn root(&self) -> u32 {
        self.tape.output(0)
    }

    /// What the slope in a region comes from; a point is a region, too.
    pub fn steepness(&self, region: &[Interval; 3]) -> Steepness {
        let mut slopes = Evaluator::keeping_all(self.tape.clone());
        let bound = slopes.eval(&coordinates(region)).norm;
        let shares = self.shares(&slopes);
        Steepness { bound, shares, slopes }
    }

    /// The bound over a region if these instructions did not vary there.
    pub fn bound_without(&self, region: &[Interval; 3], still: impl Fn(NodeId) -> bool) -> f64 {
        let mut slopes = Evaluator::keeping_all(self.tape.clone());
        let origins = self.tape.origins();
        let freeze = |i: usize, slope: &mut Slope| {
            if still(origins[i]) {
                *slope = Slope { grad: [Interval::point(0.0); 3], norm: 0.0, ..*slope };
            }
        };
        slopes.eval_changed(&coordinates(region), freeze).norm
    }

    /// Slopes of all instructions at a point.
    pub fn slopes_at(&self, p: [f64; 3]) -> Vec<f64> {
        let mut duals = Evaluator::<Dual>::keeping_all(self.tape.clone());
        duals.eval(&std::array::from_fn(|axis| Dual::coordinate(p[axis], axis)));
        let slope = |i: usize| glam::DVec3::from_array(duals.value(i as u32).grad).length();
        (0..self.tape.len()).map(slope).collect()
    }

    fn shares(&self, slopes: &Evaluator<Slope>) -> Vec<(u32, f64)> {
        let mut mass = vec![0.0; self.tape.len()];
        if let Some(all) = mass.get_mut(self.root() as usize) {
            *all = 1.0;
        }
        let mut shares = Vec::new();
        for slot in (0..mass.len()).rev() {
            let own = mass[slot];
            if own == 0.0 {
                continue;
            }
            let parts = self.parts(slot, slopes);
            let is_coordinate = |arg: u32| matches!(self.tape.code()[arg as usize], Instr::Coordinate(_));
            let mut kept = if parts.is_empty() { own } else { 0.0 };
            for (arg, part) in parts {
                // A coordinate is nobody's: what is made of it is.
                if is_coordinate(arg) {
                    kept += own * part;
                } else {
                    mass[arg as usize] += own * part;
                }
            }
            if kept > 0.0 {
                shares.push((slot as u32, kept));
            }
        }
        shares
    }

    /// The arguments that the slope of an instruction comes from, with shares that sum to one; none where it begins.
    fn parts(&self, slot: usize, slopes: &Evaluator<Slope>) -> Vec<(u32, f64)> {
        match &self.tape.code()[slot] {
            Instr::Scale(a, _) | Instr::Shift(a, _) if self.kinds[slot] == Kind::Sum => vec![(*a, 1.0)],
            Instr::Op(op, args) if self.kinds[slot] == Kind::Sum => {
                let args = &args[..op.arity()];
                let norm = |k: usize| slopes.value(args[k]).norm;
                // Where an argument has no bound, that is why this has none.
                let boundless = args.iter().filter(|a| !slopes.value(**a).norm.is_finite()).count();
                if boundless > 0 {
                    let share = |a: &u32| f64::from(u8::from(!slopes.value(*a).norm.is_finite()));
                    return args.iter().map(|a| (*a, share(a) / boundless as f64)).collect();
                }
                let partials = op.grad(|k| slopes.value(args[k]).value);
                let addend = |k: usize| if norm(k) == 0.0 { 0.0 } else { partials[k].mag() * norm(k) };
                let addends: Vec<f64> = (0..args.len()).map(addend).collect();
                let sum: f64 = addends.iter().sum();
                let shared = sum > 0.0 && sum.is_finite();
                let parts = args.iter().zip(addends).map(|(a, addend)| (*a, addend / sum));
                if shared { parts.filter(|(_, share)| *share > 0.0).collect() } else { Vec::new() }
            }
            _ => Vec::new(),
        }
    }
}

fn coordinates(region: &[Interval; 3]) -> [Slope; 3] {
    std::array::from_fn(|axis| Slope::coordinate(region[axis], axis))
}

fn kind(instr: &Instr, kinds: &[Kind]) -> Kind {
    let of = |a: &u32| kinds[*a as usize];
    match instr {
        Instr::Const(_) => Kind::Constant,
        Instr::Coordinate(_) => Kind::Linear,
        Instr::Scale(a, _) | Instr::Shift(a, _) if of(a) == Kind::Term => Kind::Sum,
        Instr::Scale(a, _) | Instr::Shift(a, _) => of(a),
        Instr::Op(op, args) => {
            let args = &args[..op.arity()];
            let is_constant = |a: &u32| of(a) == Kind::Constant;
            let is_plain = |a: &u32| matches!(of(a), Kind::Constant | Kind::Linear);
            if args.iter().all(is_constant) {
                Kind::Constant
            } else if !args.iter().all(is_plain) {
                Kind::Sum
            } else if is_linear(op, args, is_constant) {
                Kind::Linear
            } else {
                Kind::Term
            }
        }
        _ => Kind::Term,
    }
}

/// Whether an operation on coordinates that are at most moved and turned does no more than that.
fn is_linear(op: &Op, args: &[u32], is_constant: impl Fn(&u32) -> bool) -> bool {
    match op {
        Op::Add(_) | Op::Sub(_) | Op::Neg(_) => true,
        Op::Div(_) => is_constant(&args[1]),
        Op::Dot(_) => (0..3).all(|k| is_constant(&args[k]) || is_constant(&args[k + 3])),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Field;
    use crate::script::{Request, compile};
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    const SCRIPTS: [&str; 5] = [
        "sphere(1.0) - 0.1 * gradient(7).scaled(4.0)",
        "min(sphere(1.0), box(0.7).translated([0.5, 0, 0]).rotated([0, 1, 0], 20)) + 0.2 * sin(3.0 * y)",
        "import \"std/fractal\" as f; let n = f::ridged(gradient(7), #{ octaves: 5 }); sphere(1.0) - 0.1 * n * abs(n)",
        "sqrt(x) + y",
        "x * y + gradient(3) / (1.0 + z ** 2)",
    ];

    fn terms(text: &str) -> (Field, Terms) {
        let scene = compile(&Request::text(text)).scene.unwrap();
        let field = Field::new(&scene.graph, scene.surface.field);
        let terms = Terms::new(field.tape().clone());
        (field, terms)
    }

    #[test]
    fn shares_are_of_the_fields_own_bound_and_sum_to_one() {
        let mut rng = StdRng::seed_from_u64(3);
        for (mut field, terms) in SCRIPTS.map(terms) {
            for _ in 0..100 {
                let size = [0.0, 1e-3, 0.5][rng.random_range(0..3)];
                let region = std::array::from_fn(|_| Interval::around(rng.random_range(-1.5..1.5), size));
                let found = terms.steepness(&region);
                assert_eq!(found.bound, field.lipschitz(&region));
                assert!(found.shares.iter().all(|(_, share)| *share > 0.0), "{found:?}");
                let sum: f64 = found.shares.iter().map(|(_, share)| share).sum();
                assert!((sum - 1.0).abs() < 1e-12, "{sum}");
            }
        }
    }

    #[test]
    fn a_sum_is_shared_out_by_the_slopes_of_its_terms() {
        let (_, terms) = terms("sphere(1.0) + sin(4.0 * y)");
        // At the pole both point up, and the sine is steepest at zero.
        let found = terms.steepness(&[0.0, 0.0, 0.5].map(Interval::point));
        let mut shares: Vec<f64> = found.shares.iter().map(|(_, share)| *share).collect();
        shares.sort_by(f64::total_cmp);
        assert!((shares[0] - 0.2).abs() < 1e-9 && (shares[1] - 0.8).abs() < 1e-9, "{shares:?}");
    }

    #[test]
    fn slope_begins_at_the_noise_and_not_at_what_is_made_of_it() {
        let (_, terms) = terms("0.5 * (gradient(7) - 0.2)");
        let found = terms.steepness(&[Interval::around(0.3, 0.1); 3]);
        let [(slot, _)] = found.shares[..] else { panic!("{found:?}") };
        assert!(matches!(terms.tape.code()[slot as usize], Instr::Noise(..)));
    }

    #[test]
    fn a_decided_minimum_is_its_side() {
        let (_, terms) = terms("min(sphere(1.0), 0.5 * sphere(0.5).translated([5, 0, 0]) + 9.0)");
        let found = terms.steepness(&[Interval::around(0.5, 0.1); 3]);
        assert_eq!(found.shares.len(), 1);
        assert!((found.bound - 1.0).abs() < 0.2, "{found:?}");
    }

    #[test]
    fn without_a_term_its_slope_is_gone() {
        let (mut field, terms) = terms(SCRIPTS[0]);
        let region = [Interval::around(0.6, 0.01); 3];
        let all = terms.bound_without(&region, |_| false);
        assert_eq!(all, field.lipschitz(&region));
        let noise =
            (0..terms.tape.len()).find(|i| matches!(terms.tape.code()[*i], Instr::Noise(..))).unwrap();
        let without = terms.bound_without(&region, |node| node == terms.node(noise as u32));
        assert!((without - 1.0).abs() < 0.1 && without < all, "{without} {all}");
    }

    #[test]
    fn what_has_no_bound_is_named() {
        let (_, terms) = terms(SCRIPTS[3]);
        let found = terms.steepness(&[Interval::new(0.0, 1.0); 3]);
        assert_eq!(found.bound, f64::INFINITY);
        let [(slot, share)] = found.shares[..] else { panic!("{found:?}") };
        assert_eq!(share, 1.0);
        assert!(matches!(&terms.tape.code()[slot as usize], Instr::Op(Op::Sqrt(_), _)));
    }
}
