//! The shortest vector between others.

use glam::DVec3;

/// Steps towards it.
const STEPS: usize = 24;

/// About the shortest vector in the hull of some (Gilbert, 1966). Of all directions it is the one along which the least of
/// them is greatest: if there is one in which all go up, then all go up by it. Zero of none.
pub fn shortest(vectors: &[DVec3]) -> DVec3 {
    let Some(mut shortest) = vectors.first().copied() else { return DVec3::ZERO };
    let least = |along: DVec3| {
        vectors.iter().copied().min_by(|a, b| a.dot(along).total_cmp(&b.dot(along))).unwrap_or(along)
    };
    for _ in 0..STEPS {
        let back = least(shortest) - shortest;
        let share = -shortest.dot(back) / back.length_squared();
        if share.is_nan() || share <= 0.0 {
            break;
        }
        shortest += share.min(1.0) * back;
    }
    shortest
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    #[test]
    fn no_direction_has_more_of_all() {
        let mut rng = StdRng::seed_from_u64(3);
        let mut any = || -> DVec3 { DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0))) };
        for _ in 0..200 {
            let tilt = any();
            let vectors: Vec<DVec3> = (0..12).map(|_| (any() + 2.0 * tilt).normalize()).collect();
            let least = |along: DVec3| vectors.iter().map(|v| v.dot(along)).fold(f64::INFINITY, f64::min);
            let best = shortest(&vectors);
            // Nothing in the hull is less than the least along any direction.
            (0..200).for_each(|_| assert!(least(any().normalize()) <= best.length() + 1e-12));
            let gap = best.length() - least(best.normalize_or_zero());
            assert!(best.length() < 0.5 || gap < 0.1, "{gap} of {best}");
        }
    }
}
