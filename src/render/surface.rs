//! Normals and colours of hits, a batch at a time.

use super::Prepared;
use crate::num::{Dual, Many};
use crate::tape::Evaluator;
use glam::DVec3;

/// Points evaluated together.
const LANES: usize = 16;

/// The colour of a solid that has none.
const GREY: DVec3 = DVec3::splat(0.6);

/// The colour of a point whose colour is not a number: meant to be seen.
const MAGENTA: DVec3 = DVec3::new(1.0, 0.0, 1.0);

/// The solid where a ray met it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// Where.
    pub position: DVec3,
    /// Unit normal, outwards.
    pub normal: DVec3,
    /// Share of the light that is reflected, by channel.
    pub albedo: DVec3,
    /// Whether the field's gradient or its colour was not a number there.
    pub undefined: bool,
}

/// Evaluates what the eye sees of a solid; one per thread.
pub(super) struct Surface {
    field: Evaluator<Many<Dual, LANES>>,
    color: Option<Evaluator<Many<f64, LANES>>>,
}

impl Surface {
    pub(super) fn new(scene: &Prepared) -> Self {
        Surface { field: Evaluator::new(scene.tape.clone()), color: scene.color.clone().map(Evaluator::new) }
    }

    /// Describes the solid at points, each seen along a direction.
    pub(super) fn patches(&mut self, seen: &[(DVec3, DVec3)], out: &mut Vec<Patch>) {
        for batch in seen.chunks(LANES) {
            // Idle lanes repeat the last point.
            let lane = |i: usize| batch[i.min(batch.len() - 1)].0;
            let point = |axis: usize| std::array::from_fn(|i| lane(i)[axis]);
            let p: [[f64; LANES]; 3] = std::array::from_fn(point);
            let duals = |axis: usize| Many(p[axis].map(|x| Dual::coordinate(x, axis)));
            let field = *self.field.eval(&std::array::from_fn(duals));
            let color = self.color.as_mut().map(|color| {
                color.eval(&p.map(Many));
                [0, 1, 2].map(|channel| color.output(channel).0)
            });
            for (i, &(position, direction)) in batch.iter().enumerate() {
                let normal = DVec3::from_array(field.0[i].grad).try_normalize();
                let given = color.map_or(GREY, |c| DVec3::new(c[0][i], c[1][i], c[2][i]));
                let undefined = normal.is_none() || given.is_nan();
                let albedo = if given.is_nan() { MAGENTA } else { given.clamp(DVec3::ZERO, DVec3::ONE) };
                out.push(Patch { position, normal: normal.unwrap_or(-direction), albedo, undefined });
            }
        }
    }
}
