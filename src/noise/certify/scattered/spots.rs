//! One spot of unit weight: the largest size `g_k` of its derivatives, and how fast that changes.

use std::f64::consts::{PI, TAU};

/// One node of unit weight in every cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spots {
    /// Name in tables.
    pub name: &'static str,
    /// Whether the kernel is Lewis' rather than the quintic.
    pub lewis: bool,
    /// Whether nodes keep a margin of their cells.
    pub margin: bool,
    /// Waves to a cell under the spots; 0 for none.
    pub frequency: f64,
}

/// A radial function with what derivatives along a vector are made of: `h`, `h'`, `h''`, `h'/r`,
/// `h'''`, `h''/r - h'/r^2`, and the slopes of the last two.
struct Radial {
    h: [f64; 4],
    over: f64,
    across: f64,
    fourth: f64,
    across_slope: f64,
}

impl Spots {
    fn radial(&self, r: f64) -> Radial {
        let q = 1.0 - r;
        if self.lewis {
            let (sin, cos) = (libm::sin(PI * r), libm::cos(PI * r));
            let over = if r < 1e-9 { -0.5 * PI * PI } else { -0.5 * PI * sin / r };
            let h = [0.5 + 0.5 * cos, -0.5 * PI * sin, -0.5 * PI * PI * cos, 0.5 * PI * PI * PI * sin];
            // Third derivatives are not asked for; |(h'/r)'| <= 6.8.
            Radial { h, over, across: 6.8, fourth: 0.0, across_slope: 0.0 }
        } else {
            Radial {
                h: [
                    q * q * q * (1.0 + r * (3.0 + 6.0 * r)),
                    -30.0 * r * r * q * q,
                    -60.0 * r * q * (1.0 - 2.0 * r),
                    -60.0 + 360.0 * r * q,
                ],
                over: -30.0 * r * q * q,
                across: 30.0 * q * (3.0 * r - 1.0),
                fourth: 360.0 * (1.0 - 2.0 * r),
                across_slope: 30.0 * (4.0 - 6.0 * r),
            }
        }
    }

    /// `g_k` at distance `r` and cosine `c`.
    pub(super) fn size(&self, k: usize, r: f64, c: f64) -> f64 {
        let f = self.radial(r);
        let h = [
            f.h[0],
            f.h[1] * c,
            f.over + (f.h[2] - f.over) * (c * c),
            c * (f.h[3] * (c * c) + 3.0 * f.across * (1.0 - c * c)),
        ];
        let most = TAU * self.frequency;
        let square = |s: f64| {
            let [re, im] = match k {
                0 => [h[0], 0.0],
                1 => [h[1], s * h[0]],
                2 => [h[2] - s * s * h[0], 2.0 * s * h[1]],
                _ => [h[3] - 3.0 * s * s * h[1], 3.0 * s * h[2] - s * s * s * h[0]],
            };
            re * re + im * im
        };
        let mut best = square(0.0).max(square(most));
        if k == 3 && self.frequency > 0.0 {
            let (a, b) = (3.0 * h[1] * h[1] - 2.0 * h[2] * h[0], 3.0 * h[2] * h[2] - 2.0 * h[3] * h[1]);
            // The square is h_3^2 + 3 b t + 3 a t^2 + h_0^2 t^3 for t = s^2.
            let inside = a * a - h[0] * h[0] * b;
            if inside > 0.0 && h[0] > 0.0 {
                let t = (-a - inside.sqrt()) / (h[0] * h[0]);
                best = best.max(square(t.clamp(0.0, most * most).sqrt()));
            }
        }
        best.sqrt()
    }

    /// Bounds on the slopes of `h_j` by distance, within `reach` of `r`, and by cosine there, for
    /// cosines up to `c` in size: values at `r` plus bounds on the next derivative.
    pub(super) fn slopes(&self, r: f64, c: f64, reach: f64) -> [[f64; 2]; 4] {
        let f = self.radial(r);
        // Largest second, third and fourth derivatives; slopes of h'' - h'/r.
        let [second, third, fourth, mixed] =
            if self.lewis { [4.935, 15.504, 48.71, 23.0] } else { [5.7736, 60.0, 360.0, 60.0] };
        // c - c^3 is at most 0.385.
        let along = (f.fourth.abs() * c * c * c + 1.155 * f.across_slope.abs()).min(360.0);
        let (p, m) = (3.0 * f.across, 3.0 * (f.h[3] - 3.0 * f.across));
        [
            [f.h[1].abs() + 0.5 * second * reach, 0.0],
            [f.h[2].abs() * c + 0.5 * third * reach, f.h[1].abs() + second * reach],
            [
                f.h[3].abs().max(f.across.abs()) + 0.5 * fourth * reach,
                2.0 * c * ((f.h[2] - f.over).abs() + mixed * reach),
            ],
            [along + 0.5 * 720.0 * reach, p.abs().max((p + m * c * c).abs()) + 720.0 * reach],
        ]
    }

    /// Suprema of `|h_j|`.
    pub(super) fn peaks(&self) -> [f64; 4] {
        if self.lewis { [1.0, 0.5 * PI, 0.5 * PI * PI, f64::INFINITY] } else { [1.0, 1.875, 5.773_51, 60.0] }
    }

    /// `g_k` of an offset.
    pub(super) fn at(&self, k: usize, d: [f64; 3], v: [f64; 3]) -> f64 {
        let r = dot(d, d).sqrt();
        match r {
            _ if r > 1.0 => 0.0,
            _ if r > 0.0 => self.size(k, r, (dot(d, v) / r).clamp(-1.0, 1.0)),
            _ => self.size(k, 0.0, 1.0),
        }
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
