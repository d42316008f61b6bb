//! What of a drawing is its outline: where loops cross or cover one another, some of what was drawn lies
//! within.
//!
//! Pieces are cut where they cross. Each then has one side inside and the other outside, and is part of
//! the outline, or it has not.

use super::winding::Winding;
use crate::shape::boxes::{Boxes, Extent};
use crate::shape::strand::Piece;
use glam::{DVec2, Vec4Swizzles};

/// Pairs of parts of two pieces that are looked at in search of crossings; two that lie on one another
/// have no end of them.
const PATIENCE: usize = 1 << 20;

/// Parts that are this short by the size of the drawing cross where they are.
const SHORT: f64 = 1e-12;

/// The pieces, cut where they cross others.
pub(super) fn cut_at_crossings(pieces: &[(Piece, bool)]) -> Vec<(Piece, bool)> {
    let extents: Vec<Extent> = pieces.iter().map(|(p, _)| Extent::of(p.0.map(|p| p.xyz()), 0.0)).collect();
    let boxes = Boxes::new(&extents);
    let size = extents.iter().fold(0.0, |m: f64, e| m.max(e.lo.abs().max(e.hi.abs()).max_element()));
    let mut cuts: Vec<Vec<f64>> = vec![Vec::new(); pieces.len()];
    for (i, own) in extents.iter().enumerate() {
        let meets = |e: &Extent| e.lo.cmple(own.hi).all() && own.lo.cmple(e.hi).all();
        boxes.each(meets, |k| {
            if k > i {
                let mut search = Search { found: Vec::new(), short: SHORT * size, patience: PATIENCE };
                search.cross(&pieces[i].0, [0.0, 1.0], &pieces[k].0, [0.0, 1.0]);
                for [s, t] in search.found {
                    cuts[i].push(s);
                    cuts[k].push(t);
                }
            }
        });
    }
    let mut out = Vec::with_capacity(pieces.len());
    for ((piece, straight), mut cuts) in pieces.iter().zip(cuts) {
        cuts.sort_by(f64::total_cmp);
        out.extend(piece.cuts(&cuts).into_iter().map(|part| (part, *straight)));
    }
    out
}

/// Looks for crossings of two pieces.
struct Search {
    found: Vec<[f64; 2]>,
    short: f64,
    patience: usize,
}

impl Search {
    fn cross(&mut self, a: &Piece, s: [f64; 2], b: &Piece, t: [f64; 2]) {
        let [(alo, ahi), (blo, bhi)] = [a, b].map(hull);
        let apart = alo.cmpgt(bhi).any() || blo.cmpgt(ahi).any();
        if apart || self.patience == 0 {
            return;
        }
        self.patience -= 1;
        if bend(a) <= self.short && bend(b) <= self.short {
            let places = lines_meet(a, b, self.short).into_iter();
            self.found.extend(places.map(|[u, v]| [s[0] + u * (s[1] - s[0]), t[0] + v * (t[1] - t[0])]));
            return;
        }
        // The larger one is halved, so that boxes shrink alike.
        let halves = |[lo, hi]: [f64; 2]| [[lo, 0.5 * (lo + hi)], [0.5 * (lo + hi), hi]];
        if (ahi - alo).max_element() >= (bhi - blo).max_element() {
            a.halves().iter().zip(halves(s)).for_each(|(a, s)| self.cross(a, s, b, t));
        } else {
            b.halves().iter().zip(halves(t)).for_each(|(b, t)| self.cross(a, s, b, t));
        }
    }
}

fn hull(p: &Piece) -> (DVec2, DVec2) {
    let points = p.0.map(|p| p.xy());
    points.iter().fold((points[0], points[0]), |(lo, hi), p| (lo.min(*p), hi.max(*p)))
}

/// How far a piece is from straight and even.
fn bend(p: &Piece) -> f64 {
    let [a, b, c, d] = p.0.map(|p| p.xy());
    (c - b - (b - a)).length().max((d - c - (c - b)).length())
}

/// Where two lines cross, along each; where they lie on one another, the ends of both.
fn lines_meet(a: &Piece, b: &Piece, near: f64) -> Vec<[f64; 2]> {
    let [a, b] = [a, b].map(|p| [p.0[0].xy(), p.0[3].xy() - p.0[0].xy()]);
    let (apart, area) = (b[0] - a[0], a[1].perp_dot(b[1]));
    let [long, other] = [a[1].length(), b[1].length()];
    // The parts are nearly lines: what crosses where two parts of a piece join must be found by one of them.
    let within = |[u, v]: &[f64; 2]| (-0.01..=1.01).contains(u) && (-0.01..=1.01).contains(v);
    let places = if area.abs() > near * long.max(other) {
        vec![[apart.perp_dot(b[1]) / area, apart.perp_dot(a[1]) / area]]
    } else if apart.perp_dot(a[1]).abs() <= 4.0 * near * long {
        let along = |p: DVec2, [from, step]: [DVec2; 2]| (p - from).dot(step) / step.length_squared();
        let [start, end] = [a[0], a[0] + a[1]].map(|p| [along(p, a), along(p, b)]);
        let [from, to] = [b[0], b[0] + b[1]].map(|p| [along(p, a), along(p, b)]);
        vec![start, end, from, to]
    } else {
        Vec::new()
    };
    places.into_iter().filter(within).collect()
}

/// Which side of a piece is outside, as seen along it: 1 the left one, -1 the right one; none if both or
/// neither is.
pub(super) fn outer_side(piece: &Piece, winding: &Winding, size: f64) -> Option<f64> {
    let [place, tangent, _] = piece.at(0.5);
    let across = tangent.xy().perp().normalize_or_zero() * (1e-9 * size);
    match [across, -across].map(|d| !winding.covers(place.xy() + d)) {
        [true, false] => Some(1.0),
        [false, true] => Some(-1.0),
        _ => None,
    }
}
