//! Rays that end together.
//!
//! What is known of a beam over a piece is forms of all that matters there, with two symbols for where in the beam a ray is.
//! With the place of a ray put in for these, it is what is known of that ray alone, as if it had been asked about the piece
//! by itself. So where surfaces are flat enough across a beam, one answer closes in on the roots of all its rays, and none of
//! them needs an evaluation of its own: the faces and edges of a part, or a sphere looked at a few pixels at a time. Rays that
//! pass by an edge stay in the beam, from where they are known to be free.

use super::Beam;
use super::bundle::Bundle;
use super::frame::Line;
use super::march::{Answer, March, Next, Piece};
use super::sketch::Fall;
use super::thin::Thin;
use crate::cast::{Hit, Ray};
use crate::num::{Classifier, Mix, Parabola, Parabolas, Signs};

/// Rays that are answered side by side.
const LANES: usize = 16;

/// Whether an answer about a piece brackets the roots of all rays of its beam so closely, as far as its middle says.
pub(super) fn closes(f: &Parabola<2>, piece: Piece, bracket: f64) -> bool {
    Fall::of(f).is_some_and(|fall| {
        let farthest = fall.at.abs() + (f.side[0].abs() + f.side[1].abs()) / fall.slope;
        farthest <= 1.0 && is_close(f, fall, farthest, piece, bracket)
    })
}

/// Whether it tells of all rays what becomes of them where several surfaces meet: each of these is known to within the
/// bracket all over the piece, or goes along with the rays and hardly any of them is too close to tell.
pub(super) fn all_close(mix: &Mix<2>, piece: Piece, bracket: f64) -> bool {
    mix.leaves.iter().all(|f| {
        let across = f.side[0].abs() + f.side[1].abs();
        let goes_along = f.rest[0] + f.rest[1] + f.rest[2] <= HARDLY * across;
        let crossing = || Fall::of(f).or_else(|| Fall::of(&f.negated()));
        goes_along || crossing().is_some_and(|fall| is_close(f, fall, 1.0, piece, bracket))
    })
}

fn is_close(f: &Parabola<2>, fall: Fall, distance: f64, piece: Piece, bracket: f64) -> bool {
    2.0 * WIDER * fall.doubt(f, distance) * piece.half <= bracket
}

/// More than what is lost to rounding of a bracket.
const WIDER: f64 = 1.1;

/// The share of its rays that a beam may leave undecided.
const HARDLY: f64 = 1.0 / 64.0;

/// What an answer says of a ray.
enum Outcome {
    /// It ends: with a hit, or without, and where it is inside.
    Ends(Hit, f64),
    /// It is free up to this depth, and goes on with what is left of the beam.
    Passes(f64),
    /// It goes on alone, from what is known of it.
    Alone(March),
}

/// Ends rays of beams by answers, with memory of its own.
#[derive(Debug, Default)]
pub(super) struct Closing {
    classifier: Classifier<LANES>,
    forms: Vec<Parabolas<LANES, 0>>,
}

impl Closing {
    /// What is known of lines at places in the section of a bundle, in units of its extent, and how far these may be off.
    fn signs(&mut self, mix: &Mix<2>, place: impl Fn(usize) -> [[f64; 2]; 2]) -> Signs<LANES> {
        let Closing { classifier, forms } = self;
        let places: [_; LANES] = std::array::from_fn(place);
        forms.clear();
        forms.extend(mix.leaves.iter().map(|f| {
            let [at, blur] = places[0];
            let mut form = Parabolas::all(f.at(at, blur));
            for (lane, [at, blur]) in places.iter().enumerate().skip(1) {
                form.set(lane, &f.at(*at, *blur));
            }
            form
        }));
        classifier.classify(&mix.parts, |leaf| &forms[leaf as usize])
    }

    /// Ends rays of a beam by an answer about a piece, tells where they are inside, and says how many of them hit. Those that
    /// it says too little of go on alone, from what it does say, and those that it knows to be free so far are left of the
    /// beam.
    pub(super) fn end(
        &mut self,
        beam: &Beam,
        (mix, piece): (&Mix<2>, Piece),
        (rays, lines): (&[Ray], &mut [Line]),
        thin: &mut Vec<Thin>,
        (out, insides): (&mut [Hit], &mut [f64]),
    ) -> u64 {
        let mut hits = 0;
        let Bundle { frame, section, .. } = &beam.bundle;
        let all: Vec<usize> = beam.left(lines).collect();
        for own in all.chunks(LANES) {
            let line = |lane: usize| &lines[own[lane.min(own.len() - 1)]];
            let signs = self.signs(mix, |lane| section.known(frame, &line(lane).place, piece.mid));
            for (lane, &i) in own.iter().enumerate() {
                let answer = Answer::new(&signs.lane(lane), piece);
                match beam.ended((&rays[i], &lines[i]), piece, &answer) {
                    Outcome::Passes(depth) => {
                        let begin = &mut lines[i].depth[0];
                        *begin = begin.max(depth);
                        continue;
                    }
                    Outcome::Ends(hit, inside) => {
                        hits += u64::from(hit.is_hit());
                        (out[i], insides[i]) = (hit, inside);
                    }
                    Outcome::Alone(onward) => {
                        thin.push(Thin::new(i, Ray { near: onward.free, ..rays[i] }, onward));
                    }
                }
                lines[i] = Line::NOTHING;
            }
        }
        hits
    }
}

impl Beam {
    /// How a ray ends by an answer, or goes on. Its ends are rounded in depth: what is free is so as far as these may be, and
    /// what is inside counts where the ray is for certain.
    fn ended(&self, (ray, line): (&Ray, &Line), piece: Piece, answer: &Answer) -> Outcome {
        let (frame, all, stretch) = (&self.bundle.frame, &self.bundle.march, line.stretch);
        let hair = |depth: f64| frame.hair(depth);
        let distance = |depth: f64| line.distance(depth);
        let [near, far] = line.depth;
        let within = near + hair(near)..=far - hair(far);
        let mut march =
            March::new(all.free.max(near - hair(near)), far + hair(far), all.stretch, answer.root);
        let tolerance = ray.tolerance.at(distance(march.free));
        // Of more, parts of the beam look again.
        let takes_all = self.bundle.is_of_few();
        match march.tell(piece, answer, tolerance / stretch) {
            Next::Free => return Outcome::Ends(Hit::MISS, f64::INFINITY),
            // What is left is rounding.
            Next::Look if march.inside.is_infinite() && march.free > far => {
                return Outcome::Ends(Hit::MISS, f64::INFINITY);
            }
            Next::Root(a, b) if within.contains(&b) => {
                let t = distance(answer.root.unwrap_or(a).clamp(a, b));
                let t = answer.seen(t, tolerance).clamp(ray.near, ray.far);
                return Outcome::Ends(Hit { t, certified: true }, distance(b).min(ray.far));
            }
            Next::Look if march.inside.is_infinite() || !takes_all => return Outcome::Passes(march.free),
            Next::Root(..) | Next::Look | Next::Stuck(_) => {}
        }
        let near = distance(march.free - hair(march.free)).clamp(ray.near, ray.far);
        let mut onward = March::new(near, ray.far, march.stretch * stretch, march.root.map(distance));
        if within.contains(&march.inside) {
            onward.inside = distance(march.inside + hair(march.inside)).min(ray.far);
        }
        Outcome::Alone(onward)
    }
}
