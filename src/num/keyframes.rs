//! Curves through values at given times.
//!
//! Between two times the curve is the cubic of Hermite, which has the values and the slopes at its ends. So
//! it is C1 whatever the slopes are; what they are is what makes curves differ:
//!
//! | curve | slope at a time | the curve |
//! |---|---|---|
//! | [`Curve::Monotone`] | of each number the weighted harmonic mean of the slopes of the chords on either side; 0 where these differ in sign | never leaves the range of two neighbouring values |
//! | [`Curve::CatmullRom`] | that of the parabola through the value and its neighbours, at most 3 times as long as the shorter slope of the chords on either side | runs on through a value; the same in rotated coordinates; does not turn between two values on a line, unless the values turn there |
//!
//! (Fritsch and Butland, *A method for constructing local monotone piecewise cubic interpolants*, 1984, with
//! the weights of Brodlie; Catmull and Rom, *A class of local interpolating splines*, 1974, for times that
//! need not be evenly spaced. A cubic is monotone where its slopes at the ends are at most 3 times that of the chord:
//! Fritsch and Carlson, *Monotone piecewise cubic interpolation*, 1980. Without that, a parabola through a quick and a
//! slow chord shoots far beyond the slow one.) At the first and the last time the slope is 0, as the curve stays at these
//! values before and after.

/// What leads from one value to the next.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Curve {
    /// Straight lines.
    Linear,
    /// A smooth curve, each of whose numbers rises and falls only where the values do.
    Monotone,
    /// A smooth curve that runs on around corners.
    CatmullRom,
}

/// The value at time `t` of the curve through `values` at `times`, as many of them, which increase. NaN if there are
/// none.
pub fn interpolate<const N: usize>(curve: Curve, times: &[f64], values: &[[f64; N]], t: f64) -> [f64; N] {
    let after = times.partition_point(|&time| time <= t);
    let (Some(&first), Some(&last)) = (values.first(), values.last()) else { return [f64::NAN; N] };
    if after == 0 {
        return first;
    }
    if after == times.len() {
        return last;
    }
    let (i, step) = (after - 1, times[after] - times[after - 1]);
    let u = (t - times[i]) / step;
    let [a, b] = [values[i], values[after]];
    if curve == Curve::Linear {
        return std::array::from_fn(|axis| a[axis] + u * (b[axis] - a[axis]));
    }
    let [p, q] = [i, after].map(|k| slope(curve, times, values, k));
    let bend = step * u * (1.0 - u);
    std::array::from_fn(|axis| {
        a[axis] + u * u * (3.0 - 2.0 * u) * (b[axis] - a[axis]) + bend * ((1.0 - u) * p[axis] - u * q[axis])
    })
}

/// The slope of a smooth curve at the `k`-th time.
fn slope<const N: usize>(curve: Curve, times: &[f64], values: &[[f64; N]], k: usize) -> [f64; N] {
    if k == 0 || k + 1 == times.len() {
        return [0.0; N];
    }
    let steps = [times[k] - times[k - 1], times[k + 1] - times[k]];
    let chord = |i: usize| -> [f64; N] {
        std::array::from_fn(|axis| (values[k + i][axis] - values[k + i - 1][axis]) / steps[i])
    };
    let [before, after] = [chord(0), chord(1)];
    let whole = steps[0] + steps[1];
    if curve == Curve::Monotone {
        return std::array::from_fn(|axis| match (before[axis], after[axis]) {
            (a, b) if a * b <= 0.0 => 0.0,
            (a, b) => 3.0 * whole / ((whole + steps[1]) / a + (whole + steps[0]) / b),
        });
    }
    let parabola: [f64; N] =
        std::array::from_fn(|axis| (steps[1] * before[axis] + steps[0] * after[axis]) / whole);
    let length = |v: &[f64; N]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let most = 3.0 * length(&before).min(length(&after));
    let shorter = if length(&parabola) > most { most / length(&parabola) } else { 1.0 };
    parabola.map(|c| shorter * c)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: [f64; 5] = [0.0, 1.0, 1.5, 4.0, 6.0];
    const VALUES: [f64; 5] = [1.0, 3.0, 3.5, -2.0, -2.0];
    const ALL: [Curve; 3] = [Curve::Linear, Curve::Monotone, Curve::CatmullRom];

    fn interpolate(curve: Curve, times: &[f64], values: &[f64], t: f64) -> f64 {
        let values: Vec<[f64; 1]> = values.iter().map(|v| [*v]).collect();
        super::interpolate(curve, times, &values, t)[0]
    }

    #[test]
    fn values_are_met_and_kept_outside() {
        for curve in ALL {
            for (t, v) in TIMES.into_iter().zip(VALUES) {
                assert_eq!(interpolate(curve, &TIMES, &VALUES, t), v);
            }
            assert_eq!(interpolate(curve, &TIMES, &VALUES, -5.0), 1.0);
            assert_eq!(interpolate(curve, &TIMES, &VALUES, 60.0), -2.0);
            assert_eq!(interpolate(curve, &[2.0], &[7.0], 2.5), 7.0);
            assert!(interpolate(curve, &[], &[], 0.0).is_nan());
        }
        assert_eq!(interpolate(Curve::Linear, &TIMES, &VALUES, 0.25), 1.5);
    }

    #[test]
    fn smooth_curves_have_no_corners() {
        let h = 1e-7;
        for curve in [Curve::Monotone, Curve::CatmullRom] {
            for t in TIMES {
                let at = |t: f64| interpolate(curve, &TIMES, &VALUES, t);
                let (before, after) = ((at(t) - at(t - h)) / h, (at(t + h) - at(t)) / h);
                assert!((before - after).abs() < 1e-5, "{curve:?} at {t}: {before} {after}");
            }
        }
    }

    #[test]
    fn monotone_curves_stay_between_neighbours_and_the_others_need_not() {
        let steep = [0.0, 0.01, 0.02, 10.0, 10.0];
        for (values, pair) in [VALUES, steep].into_iter().flat_map(|v| (0..4).map(move |i| (v, i))) {
            let (low, high) = (values[pair].min(values[pair + 1]), values[pair].max(values[pair + 1]));
            for j in 0..=100 {
                let t = TIMES[pair] + (TIMES[pair + 1] - TIMES[pair]) * f64::from(j) / 100.0;
                let v = interpolate(Curve::Monotone, &TIMES, &values, t);
                assert!((low - 1e-12..=high + 1e-12).contains(&v));
            }
        }
        let over = (150..400).map(|i| interpolate(Curve::CatmullRom, &TIMES, &VALUES, f64::from(i) / 100.0));
        assert!(over.fold(0.0, f64::max) > 3.5);
    }

    #[test]
    fn both_reproduce_a_straight_line_in_the_middle_and_catmull_rom_a_parabola() {
        let line = TIMES.map(|t| 2.0 * t - 1.0);
        let parabola = TIMES.map(|t| t * t);
        for i in 0..=60 {
            // Between times whose slopes are not those of the ends.
            let t = 1.0 + 3.0 * f64::from(i) / 60.0;
            for curve in ALL {
                assert!((interpolate(curve, &TIMES, &line, t) - (2.0 * t - 1.0)).abs() < 1e-12);
            }
            assert!((interpolate(Curve::CatmullRom, &TIMES, &parabola, t) - t * t).abs() < 1e-12);
        }
    }

    #[test]
    fn what_slows_down_or_rests_does_not_run_on() {
        // Quick, slow, at rest, and quick again.
        let times = [0.0, 1.0, 11.0, 12.0, 13.0];
        let along = [0.0, 10.0, 11.0, 11.0, 30.0];
        let direction = [0.36, -0.48, 0.8];
        let values = along.map(|s| direction.map(|d| s * d));
        let mut last = 0.0;
        for i in 0..=1300 {
            let p = super::interpolate(Curve::CatmullRom, &times, &values, f64::from(i) / 100.0);
            let s: f64 = (0..3).map(|axis| p[axis] * direction[axis]).sum();
            assert!(s >= last - 1e-12, "{i}: {s} after {last}");
            assert!(!(1100..=1200).contains(&i) || (s - 11.0).abs() < 1e-12, "{i}: {s}");
            last = s;
        }
    }

    #[test]
    fn catmull_rom_is_the_same_in_rotated_coordinates() {
        let path = [[0.0, 0.0], [3.0, 1.0], [3.1, 1.0], [-2.0, 4.0], [0.0, 0.0]];
        let turned = path.map(|[x, y]| [0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y]);
        for i in 0..=600 {
            let at =
                |path: &[[f64; 2]]| super::interpolate(Curve::CatmullRom, &TIMES, path, f64::from(i) / 100.0);
            let ([x, y], [u, v]) = (at(&path), at(&turned));
            assert!((0.6 * x - 0.8 * y - u).abs() + (0.8 * x + 0.6 * y - v).abs() < 1e-12);
        }
    }
}
