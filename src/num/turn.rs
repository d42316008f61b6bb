//! Cosine and sine of angles in turns, alike on every machine and fit for vectors.
//!
//! A phase counted in turns is reduced exactly: the nearest whole number is subtracted without
//! rounding, where radians would first have to be divided by a rounded `2 pi`. What is left is
//! folded, again without rounding that matters, onto a quarter turn to either side of zero, where
//! one odd polynomial gives the sine:
//!
//! ```text
//! sin(2 pi r) = sine(r) or sine(+-1/2 - r)        cos(2 pi r) = sine(1/4 - |r|)        |r| <= 1/2
//! sine(a) = a P(a^2)                              |a| <= 1/4
//! ```
//!
//! `P` has degree 8 and interpolates `sin(2 pi a) / a` at the nine Chebyshev nodes of
//! `0 <= a^2 <= 1/16`; with coefficients rounded to `f64` it is off by less than `4e-17` after
//! multiplication by `a`. Rounding in between makes the error of a result less than
//! [`TURN_ERROR`]. There are no branches, no table and no fused operation, so a loop of these runs
//! in vectors and gives the same bits at every width.

use std::f64::consts::TAU;

/// Absolute error of [`cos_turns`] and [`sin_turns`].
pub const TURN_ERROR: f64 = 4e-16;

/// Coefficients of `P`, lowest first.
const P: [f64; 9] = [
    TAU,
    -41.341702240399755,
    81.60524927607362,
    -76.70585975282492,
    42.058693925428685,
    -15.0946416761179,
    3.8199280942271643,
    -0.7177337921413454,
    0.10089695501646812,
];

/// `cos(2 pi t)`, in `[-1, 1]` and exact at quarter turns; NaN for infinities.
#[inline(always)]
pub fn cos_turns(t: f64) -> f64 {
    sine(0.25 - rest(t).abs())
}

/// `sin(2 pi t)`, in `[-1, 1]` and exact at quarter turns; NaN for infinities.
#[inline(always)]
pub fn sin_turns(t: f64) -> f64 {
    let r = rest(t);
    let folded = f64::copysign(0.5, r) - r;
    sine(if r.abs() > 0.25 { folded } else { r })
}

/// `t` less the nearest whole number, exactly.
///
/// Adding 3/2 2^52 rounds to a whole number in one vector instruction on every machine. From 2^51
/// on, where neighbouring numbers are half a turn apart, an angle counts as none.
#[inline(always)]
fn rest(t: f64) -> f64 {
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let nearest = (t + MAGIC) - MAGIC;
    if t.abs() < 2_251_799_813_685_248.0 { t - nearest } else { t * 0.0 }
}

/// `sin(2 pi a)` for `|a| <= 1/4`.
#[inline(always)]
fn sine(a: f64) -> f64 {
    let z = a * a;
    let high = P[5] + z * (P[6] + z * (P[7] + z * P[8]));
    a * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * (P[4] + z * high)))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{Level, limit_simd, mix, uniform, widest};

    /// Sine and cosine with an error below 1e-20: Taylor series of the reduced angle in numbers of
    /// two parts.
    fn reference(t: f64) -> (f64, f64, f64, f64) {
        #[derive(Clone, Copy)]
        struct Two(f64, f64);
        fn add(a: Two, b: Two) -> Two {
            let s = a.0 + b.0;
            let v = s - a.0;
            let e = (a.0 - (s - v)) + (b.0 - v) + (a.1 + b.1);
            let h = s + e;
            Two(h, e - (h - s))
        }
        fn mul(a: Two, b: Two) -> Two {
            let p = a.0 * b.0;
            let e = a.0.mul_add(b.0, -p) + (a.0 * b.1 + a.1 * b.0);
            let h = p + e;
            Two(h, e - (h - p))
        }
        fn over(a: Two, n: f64) -> Two {
            let q = a.0 / n;
            let rest = (-q).mul_add(n, a.0) + a.1;
            Two(q, rest / n)
        }
        // 2 pi to 107 bits.
        let tau = Two(TAU, 2.4492935982947064e-16);
        let x = mul(tau, Two(t - t.round(), 0.0));
        let (mut sin, mut cos, mut term) = (Two(0.0, 0.0), Two(0.0, 0.0), Two(1.0, 0.0));
        for n in 0..40 {
            let signed = if n % 4 < 2 { term } else { Two(-term.0, -term.1) };
            if n % 2 == 0 {
                cos = add(cos, signed);
            } else {
                sin = add(sin, signed);
            }
            term = over(mul(term, x), f64::from(n + 1));
        }
        (cos.0, cos.1, sin.0, sin.1)
    }

    fn samples() -> impl Iterator<Item = f64> {
        (0..400_000_u64).map(|i| {
            let t = 2.0 * uniform(mix(i)) - 1.0;
            [t, 1e-3 * t, 100.0 * t, 1e9 * t, (8.0 * t).round() / 8.0 + 1e-9 * t][i as usize % 5]
        })
    }

    #[test]
    fn errors_are_as_stated() {
        let mut worst = 0.0_f64;
        for t in samples() {
            let (c, c_low, s, s_low) = reference(t);
            let off = ((cos_turns(t) - c) - c_low).abs().max(((sin_turns(t) - s) - s_low).abs());
            worst = worst.max(off);
            assert!(off < TURN_ERROR, "{t}: {off:e}");
            assert!(cos_turns(t).abs() <= 1.0 && sin_turns(t).abs() <= 1.0, "{t}");
        }
        assert!(worst > 0.5e-16, "the reference is no better than what it checks: {worst:e}");
    }

    #[test]
    fn quarter_turns_are_exact_and_all_else_is_total() {
        for n in -9_i32..=9 {
            let t = f64::from(n) / 4.0;
            let c = [1.0, 0.0, -1.0, 0.0];
            let at = n.rem_euclid(4) as usize;
            assert_eq!((cos_turns(t), sin_turns(t)), (c[at], c[(at + 3) % 4]), "{t}");
        }
        for t in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(cos_turns(t).is_nan() && sin_turns(t).is_nan());
        }
        assert_eq!((cos_turns(1e300), sin_turns(-1e300)), (1.0, 0.0));
        // Small angles keep their relative accuracy.
        assert_eq!(sin_turns(1e-200), 1e-200 * P[0]);
    }

    #[test]
    fn every_level_gives_the_same_bits() {
        let at: Vec<f64> = samples().take(5000).collect();
        let run = |level| {
            let mut out = vec![[0.0; 2]; at.len()];
            limit_simd(level);
            widest(|| {
                for (o, &t) in out.iter_mut().zip(&at) {
                    *o = [cos_turns(t), sin_turns(t)];
                }
            });
            limit_simd(Level::Avx512);
            out
        };
        let bits = |v: Vec<[f64; 2]>| v.into_iter().map(|x| x.map(f64::to_bits)).collect::<Vec<_>>();
        assert_eq!(bits(run(Level::Baseline)), bits(run(Level::Avx2)));
        assert_eq!(bits(run(Level::Baseline)), bits(run(Level::Avx512)));
    }
}
