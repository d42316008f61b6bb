//! Along a line of sight: what gets through, and how much of the light at its points comes out.
//!
//! ```text
//! L = T(eye, end) L_end + int T(eye, p) sum over matter of beta rho (P T_sun V + Psi) E ds
//! ```
//!
//! The integral is cut into steps, in each of which light is taken to be scattered in proportion to what
//! is held back. So a step gives `T (1 - T_step)` times the light at one point of it, and no amount of air
//! scatters more light than it holds back, however coarse the steps are (Hillaire 2020).

use super::exp::exp;
use super::line::{Count, Line, Steps};
use super::medium::Medium;
use super::sunlight::through;
use glam::{DVec3, DVec4};

/// A step along a line of sight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// The point that stands for it.
    pub point: DVec3,
    /// Share of the light there that comes out at the eye, for gas, haze and fog: what they scatter, less
    /// what the air up to the eye holds back of that.
    pub yields: [DVec3; 3],
    /// Share of light that gets through the air up to the end of the step.
    pub through: DVec3,
}

/// The steps of a line, from the eye outwards. `jitter` in [0, 1) picks the point of each: evenly over what scatters there,
/// not over the length of the step, or the light of a sky that is lit from above alone, as it is at dusk, would come out too
/// bright.
pub(super) fn march(medium: &Medium, line: &Line, count: Count, jitter: f64) -> Vec<Step> {
    let steps = Steps::new(medium, line.b, line.ends, count);
    let mut before = DVec3::ONE;
    let step = |[from, to]: [f64; 2]| {
        let [near, far] = medium.nodes(line.b, [from, to]).map(|(_, amount)| amount);
        let amount = near + far;
        let [dense, thin] =
            [near, far].map(|part| medium.scattered(part).iter().map(|s| s.element_sum()).sum::<f64>());
        // By how much more there is at the near end than in the middle, and in the middle than at the far end: its
        // logarithm is half of that along the step, of which the nodes are the share 1 / sqrt(3) apart.
        let slope = 0.75_f64.sqrt() * libm::log(dense.max(f64::MIN_POSITIVE) / thin.max(f64::MIN_POSITIVE));
        // Thick air hides its far part: this is, to first order in the depth, where light comes from.
        let hidden = 0.5 * medium.depth(amount).element_sum() / 3.0;
        let [denser] = exp([slope.clamp(-4.0, 4.0)]);
        let bend = (1.0 + hidden) * denser - 1.0;
        let share = jitter / (1.0 + bend * (1.0 - jitter));
        Step::new(medium, line.point(from + share * (to - from)), amount, &mut before)
    };
    steps.iter().map(step).collect()
}

/// The same with two steps for each, at the nodes of Gauss's rule: for sums that are to be exact, as light at dusk grows
/// with height by a multiple within a step.
pub(super) fn march_evenly(medium: &Medium, line: &Line, count: Count) -> Vec<Step> {
    let mut before = DVec3::ONE;
    let steps = Steps::new(medium, line.b, line.ends, count);
    let nodes = steps.iter().flat_map(|ends| medium.nodes(line.b, ends));
    nodes.map(|(s, amount)| Step::new(medium, line.point(s), amount, &mut before)).collect()
}

impl Step {
    /// A step through an amount of matter, `before` which so much gets through.
    fn new(medium: &Medium, point: DVec3, amount: DVec4, before: &mut DVec3) -> Step {
        let depth = medium.depth(amount);
        let through = through(depth);
        let weight = *before * mean_through(depth, through);
        *before *= through;
        Step { point, yields: medium.scattered(amount).map(|scattered| scattered * weight), through: *before }
    }
}

/// Mean share of light that gets through the near part of a step, over all of its points:
/// `(1 - e^-t) / t`.
pub(super) fn mean_through(depth: DVec3, through: DVec3) -> DVec3 {
    let mean = |t: f64, e: f64| if t > 1e-5 { (1.0 - e) / t } else { 1.0 - 0.5 * t };
    DVec3::new(mean(depth.x, through.x), mean(depth.y, through.y), mean(depth.z, through.z))
}
