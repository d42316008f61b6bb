//! Normals and colours of hits, a batch at a time.

use super::{Painter, Prepared};
use crate::cast::Tolerance;
use crate::num::{Dual, Many};
use crate::scene::{Aabb, Finish};
use crate::tape::{Cells, Evaluator};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Points evaluated together.
const LANES: usize = 16;

/// Cosine between a bump and the eye, at least.
const GRAZING: f64 = 1e-3;

/// What is so many tolerances from the surface, as far as value and gradient tell, is close to it: hits are.
const CLOSE: f64 = 16.0;

/// The colour of a solid that has none.
const GREY: DVec3 = DVec3::splat(0.6);

/// The colour of a point whose colour is not a number: meant to be seen.
const MAGENTA: DVec3 = DVec3::new(1.0, 0.0, 1.0);

/// The solid where a ray met it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// Where.
    pub position: DVec3,
    /// Unit normal, outwards; where the bounds cut the solid, that of their face.
    pub normal: DVec3,
    /// Unit normal for the sake of light: the same but for bumps, of which the eye sees the sides that face it.
    pub shading: DVec3,
    /// Share of the light that is reflected, by channel.
    pub albedo: DVec3,
    /// What [`Finish`](crate::scene::Finish) says, in its order, from 0 to 1.
    pub finish: [f64; Finish::COUNT],
    /// Light that it gives off by itself.
    pub emission: DVec3,
    /// Whether its colour or finish was not a number there.
    pub undefined: bool,
    /// Whether the field has no gradient there.
    pub is_flat: bool,
}

impl Patch {
    /// A matt grey one.
    pub(super) const PLAIN: Patch = Patch {
        position: DVec3::ZERO,
        normal: DVec3::Y,
        shading: DVec3::Y,
        albedo: GREY,
        finish: [0.0; Finish::COUNT],
        emission: DVec3::ZERO,
        undefined: false,
        is_flat: false,
    };
}

/// Roughness that is enough for what is seen in light that is spread.
const BLURRED: f64 = 0.5;

impl Patch {
    /// The cosine at which light from a direction falls on it; zero if that is below it, or on the other side of its bump.
    pub fn facing(&self, from: DVec3) -> f64 {
        if self.normal.dot(from) > 0.0 { self.shading.dot(from).max(0.0) } else { 0.0 }
    }

    /// Makes reflections as blurred as they may be to a path on which images are so blurred by now: a sharp image of the sun
    /// would be met by one in thousands of the paths that come from a matt place, and shine as a speck (path space
    /// regularisation; Kaplanyan and Dachsbacher 2013). As much light is reflected as before, in more directions.
    pub fn blur(&mut self, least: f64) {
        let roughness = &mut self.finish[Finish::Roughness as usize];
        *roughness = roughness.max(least.min(BLURRED));
    }
}

/// Evaluates what the eye sees of a solid; one per thread.
pub(super) struct Surface {
    cells: Arc<Cells>,
    field: Evaluator<Many<Dual, LANES>>,
    color: Option<Evaluator<Many<f64, LANES>>>,
    /// What [`Material::looks`](crate::scene::Material::looks) says.
    looks: Option<Evaluator<Many<f64, LANES>>>,
    /// Whether it says of light that is given off.
    is_shining: bool,
    bump: Option<Evaluator<Many<Dual, LANES>>>,
    painter: Option<Box<dyn Painter>>,
    ends: Ends,
}

/// Where the solid ends with the bounds, and not by its field.
#[derive(Clone, Copy)]
struct Ends {
    bounds: Aabb,
    eye: DVec3,
    tolerance: Tolerance,
}

impl Ends {
    /// The normal of the face of the bounds that cuts the solid at a hit; none where the field ends it. Hits lie in front of
    /// a surface, so where one is inside of the solid, its ray began there.
    fn cut(&self, hit: DVec3, field: f64) -> Option<DVec3> {
        if field >= 0.0 {
            return None;
        }
        let Aabb { min, max } = self.bounds;
        let (below, above) = ((hit - min).abs(), (max - hit).abs());
        let nearest = below.min(above).min_element();
        let face = DVec3::AXES.into_iter().find(|axis| below.min(above).dot(*axis) == nearest)?;
        let rounding = 64.0 * f64::EPSILON * hit.abs().max(self.eye.abs()).max_element();
        let is_on_it = nearest <= 4.0 * self.tolerance.at(hit.distance(self.eye)) + rounding;
        let side = if above.dot(face) < below.dot(face) { 1.0 } else { -1.0 };
        is_on_it.then_some(side * face)
    }
}

impl Surface {
    pub(super) fn new(scene: &Prepared) -> Self {
        Surface {
            cells: scene.cells.clone(),
            field: Evaluator::new(scene.tape.clone()),
            color: scene.color.clone().map(Evaluator::new),
            looks: scene.looks.clone().map(Evaluator::new),
            is_shining: scene.is_shining,
            bump: scene.bump.clone().map(Evaluator::new),
            painter: scene.painter.clone(),
            ends: Ends { bounds: scene.settings.bounds, eye: scene.view.eye, tolerance: scene.tolerance },
        }
    }

    /// The same with the scene's own colours, whoever changes them.
    pub(super) fn unpainted(self) -> Surface {
        Surface { painter: None, ..self }
    }

    /// Describes the solid at points, each seen along a direction; `out` gets a patch for each. What it gets once `cancel`
    /// is set means nothing.
    pub(super) fn patches(&mut self, seen: &[(DVec3, DVec3)], out: &mut Vec<Patch>, cancel: &AtomicBool) {
        self.describe(seen, out, cancel);
        if let Some(painter) = &mut self.painter {
            let points: Vec<DVec3> = out.iter().map(|patch| patch.position).collect();
            let mut colors: Vec<DVec3> = out.iter().map(|patch| patch.albedo).collect();
            painter.paint(&points, &mut colors, cancel);
            out.iter_mut().zip(colors).for_each(|(patch, color)| patch.albedo = color);
        }
    }

    /// How deep points lie below the surface, along the gradient.
    pub(super) fn depths(&mut self, places: &[DVec3]) -> Vec<f64> {
        let mut depths = Vec::with_capacity(places.len());
        self.field.turn_to(self.cells.tape());
        for batch in places.chunks(LANES) {
            let at = |i: usize| batch[i.min(batch.len() - 1)];
            let dual = |axis: usize| Many(std::array::from_fn(|i| Dual::coordinate(at(i)[axis], axis)));
            let field = self.field.eval(&std::array::from_fn(dual));
            depths.extend(field.0[..batch.len()].iter().map(|dual| {
                let slope = DVec3::from_array(dual.grad).length();
                if slope > 0.0 { (-dual.value / slope).max(0.0) } else { 0.0 }
            }));
        }
        depths
    }

    /// The same by the expressions alone.
    fn describe(&mut self, seen: &[(DVec3, DVec3)], out: &mut Vec<Patch>, cancel: &AtomicBool) {
        let goes_on = || !cancel.load(Ordering::Relaxed);
        out.clear();
        if self.cells.is_uniform() {
            for batch in seen.chunks(LANES).take_while(|_| goes_on()) {
                self.batch(batch.iter().copied(), |patch, _, _| out.push(patch));
            }
            // Whoever asked has as many as they asked for.
            out.resize(seen.len(), Patch::PLAIN);
            return;
        }
        out.resize(seen.len(), Patch::PLAIN);
        let (cells, mut off) = (self.cells.clone(), Vec::new());
        let places = seen.iter().enumerate().map(|(i, (p, _))| (i, p.to_array(), 0.0));
        for same in cells.tapes_around(places).chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            self.field.turn_to(same[0].0);
            for batch in same.chunks(LANES).take_while(|_| goes_on()) {
                self.batch(batch.iter().map(|(_, i)| seen[*i]), |patch, is_near, k| {
                    out[batch[k].1] = patch;
                    off.extend((!is_near).then_some(batch[k].1));
                });
            }
        }
        // Away from the surface the cells' tapes have values of their own.
        self.field.turn_to(cells.tape());
        for batch in off.chunks(LANES).take_while(|_| goes_on()) {
            self.batch(batch.iter().map(|i| seen[*i]), |patch, _, k| out[batch[k]] = patch);
        }
    }

    /// Describes the solid at no more points than there are lanes; `tell` gets each patch, whether it is close to the
    /// surface, and its number.
    fn batch(
        &mut self,
        seen: impl ExactSizeIterator<Item = (DVec3, DVec3)> + Clone,
        mut tell: impl FnMut(Patch, bool, usize),
    ) {
        let mut p = [[0.0; LANES]; 3];
        // Idle lanes repeat the last point.
        let mut last = DVec3::ZERO;
        let mut points = seen.clone();
        for lane in 0..LANES {
            last = points.next().map_or(last, |(position, _)| position);
            (p[0][lane], p[1][lane], p[2][lane]) = (last.x, last.y, last.z);
        }
        let duals = std::array::from_fn(|axis| Many(p[axis].map(|x| Dual::coordinate(x, axis))));
        let points = p.map(Many);
        let field = *self.field.eval(&duals);
        let color = self.color.as_mut().map(|color| outputs::<3>(color, &points));
        let finish = self.looks.as_mut().map(|looks| outputs::<{ Finish::COUNT }>(looks, &points));
        let emission = self.looks.as_ref().filter(|_| self.is_shining);
        let emission = emission.map(|looks| [0, 1, 2].map(|c| looks.output(Finish::COUNT + c).0));
        let bump = self.bump.as_mut().map(|bump| *bump.eval(&duals));
        for (i, (position, direction)) in seen.enumerate() {
            let gradient = DVec3::from_array(field.0[i].grad);
            let normal = self.ends.cut(position, field.0[i].value).or_else(|| gradient.try_normalize());
            let rgb = |c: [[f64; LANES]; 3]| DVec3::new(c[0][i], c[1][i], c[2][i]);
            let (given, given_off) = (color.map_or(GREY, rgb), emission.map_or(DVec3::ZERO, rgb));
            let finish = finish.map_or(Patch::PLAIN.finish, |finish| finish.map(|lanes| lanes[i]));
            let undefined = given.is_nan() || given_off.is_nan() || finish.iter().any(|share| share.is_nan());
            let is_flat = normal.is_none();
            let near = CLOSE * self.ends.tolerance.at(position.distance(self.ends.eye));
            let is_near = field.0[i].value.abs() < near * gradient.length();
            let normal = normal.unwrap_or(-direction);
            let rise = bump.map_or(DVec3::ZERO, |bump| DVec3::from_array(bump.0[i].grad));
            let patch = Patch {
                position,
                normal,
                shading: bumped(normal, rise, -direction),
                albedo: if given.is_nan() { MAGENTA } else { given.clamp(DVec3::ZERO, DVec3::ONE) },
                finish: finish.map(|share| if share > 0.0 { share.min(1.0) } else { 0.0 }),
                emission: DVec3::from_array(given_off.to_array().map(|c| if c > 0.0 { c } else { 0.0 })),
                undefined,
                is_flat,
            };
            tell(patch, is_near, i);
        }
    }
}

/// The first outputs of some code.
fn outputs<const N: usize>(
    code: &mut Evaluator<Many<f64, LANES>>,
    at: &[Many<f64, LANES>; 3],
) -> [[f64; LANES]; N] {
    code.eval(at);
    std::array::from_fn(|i| code.output(i).0)
}

/// The normal of a surface raised by a height with a gradient: what the height does not say of the surface's own
/// tangent plane does not matter (Blinn 1978). Of a bump that faces away from the eye the other side is seen.
fn bumped(normal: DVec3, rise: DVec3, to_eye: DVec3) -> DVec3 {
    if rise == DVec3::ZERO {
        return normal;
    }
    let bumped = (normal - (rise - rise.dot(normal) * normal)).try_normalize().unwrap_or(normal);
    let bumped = bumped - 2.0 * bumped.dot(to_eye).min(0.0) * to_eye;
    let facing = bumped.dot(to_eye);
    if facing < GRAZING { (bumped + (GRAZING - facing) * to_eye).normalize() } else { bumped }
}
