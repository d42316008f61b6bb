//! The exponential of several numbers at once, with the same bits on every machine.

/// `e^x` by lane, to a relative error of 1e-12, for `x` within [-700, 700]; beyond, that of the end.
///
/// `x = k ln 2 + r` with a whole `k` and `|r| <= ln(2) / 2`, for which the series up to the tenth power
/// does. Without branches or calls, and with short chains of sums (Estrin's scheme), so that the steps of
/// one lane go on while those of another wait: the air takes hundreds of these for each line of sight.
#[inline(always)]
pub(super) fn exp<const N: usize>(x: [f64; N]) -> [f64; N] {
    let mut out = [0.0; N];
    for (out, x) in out.iter_mut().zip(x) {
        *out = lane(x);
    }
    out
}

#[inline(always)]
fn lane(x: f64) -> f64 {
    /// Added to a small number this leaves the nearest whole number in its last bits.
    const WHOLE: f64 = 1.5 * (1_u64 << 52) as f64;
    /// ln 2 in two parts, the first with so few bits that `k` times it is exact (fdlibm).
    const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_588e-10];
    let x = x.clamp(-700.0, 700.0);
    let shifted = x * std::f64::consts::LOG2_E + WHOLE;
    let k = shifted - WHOLE;
    let r = (x - k * LN_2[0]) - k * LN_2[1];
    let (r2, pair) = (r * r, |i: usize| TERMS[i] + TERMS[i + 1] * r);
    let four = |i: usize| pair(i) + pair(i + 2) * r2;
    let r4 = r2 * r2;
    let series = four(0) + r4 * (four(4) + r4 * (pair(8) + TERMS[10] * r2));
    series * f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()))
}

/// `1 / n!`.
const TERMS: [f64; 11] = {
    let mut terms = [1.0; 11];
    let mut n = 1;
    while n < terms.len() {
        terms[n] = terms[n - 1] / n as f64;
        n += 1;
    }
    terms
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_library() {
        for i in -7_000..=7_000 {
            let x = f64::from(i) * 0.099_99;
            let [y] = exp([x]);
            assert!((y / libm::exp(x) - 1.0).abs() < 1e-12, "{x}: {y}");
        }
        assert_eq!(exp([0.0, -0.0]), [1.0, 1.0]);
        assert!(exp([f64::NEG_INFINITY])[0] < 1e-300 && exp([f64::NAN])[0].is_nan());
    }
}
