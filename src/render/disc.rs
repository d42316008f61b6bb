//! From the unit square to the unit disc.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// The place on the unit disc of a place in the unit square: squares around the middle become circles, so that
/// areas keep their share and strata stay compact (Shirley and Chiu, *A low distortion map between disk and
/// square*, 1997).
pub(super) fn on_disc([u, v]: [f64; 2]) -> [f64; 2] {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let (radius, angle) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else if b != 0.0 {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    } else {
        (0.0, 0.0)
    };
    [radius * libm::cos(angle), radius * libm::sin(angle)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_and_the_edges_stay_what_they_are() {
        assert_eq!(on_disc([0.5, 0.5]), [0.0, 0.0]);
        for i in 0..=100 {
            let t = f64::from(i) / 100.0;
            for place in [[t, 0.0], [t, 1.0], [0.0, t], [1.0, t]] {
                let [x, y] = on_disc(place);
                assert!((libm::hypot(x, y) - 1.0).abs() < 1e-15);
            }
        }
        let [x, y] = on_disc([1.0, 0.5]);
        assert_eq!([x, y], [1.0, 0.0]);
    }

    #[test]
    fn areas_keep_their_share() {
        // A small triangle grows by the determinant of the map, which is that of the whole.
        let h = 1e-6;
        for i in 0..37 {
            for j in 0..37 {
                // None of the corners lies on a diagonal, where the map has creases.
                let (u, v) = ((f64::from(i) + 0.3) / 37.1, (f64::from(j) + 0.55) / 37.1);
                let (o, x, y) = (on_disc([u, v]), on_disc([u + h, v]), on_disc([u, v + h]));
                let area = (x[0] - o[0]) * (y[1] - o[1]) - (x[1] - o[1]) * (y[0] - o[0]);
                assert!((area / (h * h) - std::f64::consts::PI).abs() < 1e-3, "{u} {v}: {area}");
            }
        }
    }
}
