//! Rays that end together.
//!
//! What is known of a beam over a piece is a form with two symbols for where in the beam a ray is. With the place of a ray
//! put in for these, it is what is known of that ray alone, as if it had been asked about the piece by itself. So where
//! the field is flat enough across a beam, one answer closes in on the roots of all its rays, and none of them needs
//! an evaluation of its own: the faces of a part, or a sphere looked at a few pixels at a time.

use super::Beam;
use super::frame::Line;
use super::gather::is_real;
use super::march::{Answer, March, Next, Piece};
use super::sketch::Fall;
use super::thin::Thin;
use crate::cast::{Hit, Ray};
use crate::num::{Half, Parabola, Parabolas};
use std::ops::ControlFlow;

/// Rays that are answered side by side.
const LANES: usize = 16;

/// Whether an answer about a piece brackets the roots of all rays of its beam so closely, as far as its middle says.
pub(super) fn closes(f: &Parabola<2>, piece: Piece, bracket: f64) -> bool {
    Fall::of(f).is_some_and(|fall| {
        let farthest = fall.at.abs() + (f.side[0].abs() + f.side[1].abs()) / fall.slope;
        farthest <= 1.0 && 2.0 * WIDER * fall.doubt(f, farthest) * piece.half <= bracket
    })
}

/// How far behind a root a place is looked for that is inside for certain, as a share of how far it may be.
const WIDER: f64 = 1.1;

impl Beam {
    /// Ends its rays by an answer about a piece, tells where they are inside, and says how many of them hit; those that it
    /// says too little of go on alone, from what it does say.
    pub(super) fn close(
        &self,
        (f, piece): (&Parabola<2>, Piece),
        (rays, lines): (&[Ray], &[Line]),
        thin: &mut Vec<Thin>,
        (out, insides): (&mut [Hit], &mut [f64]),
    ) -> u64 {
        let mut hits = 0;
        let own: Vec<usize> = self.rays.clone().filter(|&i| is_real(&rays[i])).collect();
        for own in own.chunks(LANES) {
            let mut forms = Parabolas::<LANES, 0>::all(f.at([0.0; 2], [1.0; 2]));
            for (lane, &i) in own.iter().enumerate() {
                let [at, blur] = self.bundle.section.known(&self.bundle.frame, &lines[i].place, piece.mid);
                forms.set(lane, &f.at(at, blur));
            }
            let halves = forms.halves();
            for (lane, &i) in own.iter().enumerate() {
                match self.ended((&rays[i], &lines[i]), piece, &forms.lane(lane), halves[lane]) {
                    ControlFlow::Break((hit, inside)) => {
                        hits += u64::from(hit.is_hit());
                        (out[i], insides[i]) = (hit, inside);
                    }
                    ControlFlow::Continue(onward) => {
                        thin.push(Thin::new(i, Ray { near: onward.free, ..rays[i] }, onward))
                    }
                }
            }
        }
        hits
    }

    /// How a ray ends by an answer, and where it is inside, or goes on. Its ends are rounded in depth: what is free is so as
    /// far as these may be, and what is inside counts where the ray is for certain.
    fn ended(
        &self,
        (ray, line): (&Ray, &Line),
        piece: Piece,
        form: &Parabola<0>,
        halves: [Half; 2],
    ) -> ControlFlow<(Hit, f64), March> {
        let answer = Answer::new(form, piece, halves);
        let (frame, all, stretch) = (&self.bundle.frame, &self.bundle.march, line.stretch);
        let hair = |depth: f64| frame.hair(depth);
        let distance = |depth: f64| line.distance(depth);
        let [near, far] = line.depth;
        let within = near + hair(near)..=far - hair(far);
        let mut march =
            March::new(all.free.max(near - hair(near)), far + hair(far), all.stretch, answer.root);
        // Halves tell of the nearest place inside to the middle, not of the first one.
        let behind = |fall: Fall| fall.at + WIDER * fall.doubt(form, fall.at.abs());
        if let Some(e) = Fall::of(form).map(behind).filter(|e| form.is_below_at(*e)) {
            let inside = piece.mid + e * piece.half;
            march.inside =
                if inside >= march.free && within.contains(&inside) { inside } else { f64::INFINITY };
        }
        let tolerance = ray.tolerance.at(distance(march.free));
        match march.tell(piece, &answer, tolerance / stretch) {
            Next::Free => return ControlFlow::Break((Hit::MISS, f64::INFINITY)),
            Next::Root(a, b) if within.contains(&b) => {
                let t = distance(answer.root.unwrap_or(a).clamp(a, b)).clamp(ray.near, ray.far);
                return ControlFlow::Break((Hit { t, certified: true }, distance(b).min(ray.far)));
            }
            Next::Root(..) | Next::Look | Next::Stuck(_) => {}
        }
        let near = distance(march.free - hair(march.free)).clamp(ray.near, ray.far);
        let mut onward = March::new(near, ray.far, march.stretch * stretch, march.root.map(distance));
        if within.contains(&march.inside) {
            onward.inside = distance(march.inside + hair(march.inside)).min(ray.far);
        }
        ControlFlow::Continue(onward)
    }
}
