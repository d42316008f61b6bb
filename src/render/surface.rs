//! Normals and colours of hits, a batch at a time.

use super::{Painter, Prepared};
use crate::num::{Dual, Many};
use crate::tape::{Cells, Evaluator};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

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
    cells: Arc<Cells>,
    field: Evaluator<Many<Dual, LANES>>,
    color: Option<Evaluator<Many<f64, LANES>>>,
    painter: Option<Box<dyn Painter>>,
}

impl Surface {
    pub(super) fn new(scene: &Prepared) -> Self {
        Surface {
            cells: scene.cells.clone(),
            field: Evaluator::new(scene.tape.clone()),
            color: scene.color.clone().map(Evaluator::new),
            painter: scene.painter.clone(),
        }
    }

    /// Describes the solid at points, each seen along a direction; `out` gets a patch for each.
    pub(super) fn patches(&mut self, seen: &[(DVec3, DVec3)], out: &mut Vec<Patch>, cancel: &AtomicBool) {
        self.describe(seen, out);
        if let Some(painter) = &mut self.painter {
            let points: Vec<DVec3> = out.iter().map(|patch| patch.position).collect();
            let mut colors: Vec<DVec3> = out.iter().map(|patch| patch.albedo).collect();
            painter.paint(&points, &mut colors, cancel);
            out.iter_mut().zip(colors).for_each(|(patch, color)| patch.albedo = color);
        }
    }

    /// The same by the expressions alone.
    fn describe(&mut self, seen: &[(DVec3, DVec3)], out: &mut Vec<Patch>) {
        out.clear();
        if self.cells.is_uniform() {
            for batch in seen.chunks(LANES) {
                self.batch(batch.iter().copied(), |patch, _| out.push(patch));
            }
            return;
        }
        let none = Patch { position: DVec3::ZERO, normal: DVec3::Y, albedo: GREY, undefined: false };
        out.resize(seen.len(), none);
        let cells = self.cells.clone();
        let places = seen.iter().enumerate().map(|(i, (p, _))| (i, p.to_array(), 0.0));
        for same in cells.tapes_around(places).chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            self.field.turn_to(same[0].0);
            for batch in same.chunks(LANES) {
                self.batch(batch.iter().map(|(_, i)| seen[*i]), |patch, k| out[batch[k].1] = patch);
            }
        }
    }

    /// Describes the solid at no more points than there are lanes; `tell` gets each patch with its number.
    fn batch(
        &mut self,
        seen: impl ExactSizeIterator<Item = (DVec3, DVec3)> + Clone,
        mut tell: impl FnMut(Patch, usize),
    ) {
        let mut p = [[0.0; LANES]; 3];
        // Idle lanes repeat the last point.
        let mut last = DVec3::ZERO;
        let mut points = seen.clone();
        for lane in 0..LANES {
            last = points.next().map_or(last, |(position, _)| position);
            (p[0][lane], p[1][lane], p[2][lane]) = (last.x, last.y, last.z);
        }
        let duals = |axis: usize| Many(p[axis].map(|x| Dual::coordinate(x, axis)));
        let field = *self.field.eval(&std::array::from_fn(duals));
        let color = self.color.as_mut().map(|color| {
            color.eval(&p.map(Many));
            [0, 1, 2].map(|channel| color.output(channel).0)
        });
        for (i, (position, direction)) in seen.enumerate() {
            let normal = DVec3::from_array(field.0[i].grad).try_normalize();
            let given = color.map_or(GREY, |c| DVec3::new(c[0][i], c[1][i], c[2][i]));
            let undefined = normal.is_none() || given.is_nan();
            let albedo = if given.is_nan() { MAGENTA } else { given.clamp(DVec3::ZERO, DVec3::ONE) };
            tell(Patch { position, normal: normal.unwrap_or(-direction), albedo, undefined }, i);
        }
    }
}
