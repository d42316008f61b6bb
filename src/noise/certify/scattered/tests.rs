//! Searches stay below what is proven, and tables above what is sampled.

use super::*;
use crate::noise::tests::Random;

fn all() -> [Spots; 5] {
    [
        PLAIN,
        Spots { margin: true, ..PLAIN },
        Spots { lewis: true, ..PLAIN },
        Spots { frequency: 2.0, ..PLAIN },
        Spots { frequency: 0.5, margin: true, ..PLAIN },
    ]
}

#[test]
fn no_search_exceeds_the_constants() {
    for spots in all() {
        for claim in spots.claims() {
            let found = hunt(&spots, claim.order, 200);
            assert!(found <= claim.bound, "{spots:?} {claim:?} {found}");
            assert!(found >= 0.85 * claim.bound, "{spots:?} {claim:?} {found}: the search lost its way");
        }
    }
}

#[test]
fn known_extremes_are_reached() {
    for (k, value) in [(0, 8.0), (1, 23.65624), (2, 97.4386), (3, 952.14)] {
        let found = hunt(&PLAIN, k, 1000);
        assert!((found - value).abs() < 2e-3 * value, "{k} {found}");
    }
}

#[test]
fn coarse_proofs_succeed_and_false_claims_fail() {
    let prove = |order, bound, budget| PLAIN.prove(&Claim { order, name: "", bound }, budget);
    assert!(prove(0, 9.0, 10_000).is_some());
    assert!(prove(1, 28.0, 10_000).is_some());
    assert!(prove(1, 23.6, 100_000).is_none());
    assert!(prove(2, 97.0, 10_000).is_none());
}

#[test]
fn voxels_bound_what_is_in_them() {
    let mut random = Random::new(71);
    for spots in all() {
        for k in 0..if spots.lewis { 3 } else { 4 } {
            let profile = Profile::new(&spots, k);
            for _ in 0..3000 {
                let e = [0.05, 0.0125][random.unit().round() as usize];
                let low = random.point(1.0).map(|a| (a / e).round() * e);
                let v = unit(random.point(1.0));
                let bound = f64::from(profile.voxel(v, low, e));
                for _ in 0..8 {
                    let d = low.map(|a| a + e * random.unit());
                    let value = spots.at(k, d, v);
                    assert!(value <= bound * (1.0 + 1e-9), "{spots:?} {k} {low:?} {d:?} {value} {bound}");
                }
            }
        }
    }
}

#[test]
fn tables_bound_the_sums() {
    let mut random = Random::new(72);
    for spots in all() {
        let v = unit([1.0, 0.6, 0.2]);
        let upper = spots.upper(&Profile::new(&spots, 1), v, 20);
        let margin = if spots.margin { scatter::MARGIN } else { 0.0 };
        for _ in 0..300 {
            let x = random.point(0.5).map(|x| x + 0.5);
            let sum: f64 = (0..27)
                .map(|c| {
                    let corner = [c % 3, c / 3 % 3, c / 9].map(|o| f64::from(o) - 1.0);
                    (0..40).fold(0.0, |most, _| {
                        let p = [0; 3].map(|_| margin + (1.0 - 2.0 * margin) * random.unit());
                        f64::max(most, spots.at(1, [0, 1, 2].map(|i| x[i] - corner[i] - p[i]), v))
                    })
                })
                .sum();
            assert!(sum <= upper, "{spots:?} {x:?}");
        }
    }
}

#[test]
fn every_frequency_of_the_net_is_proven() {
    for (frequency, _) in gabor::NET {
        for margin in [false, true] {
            let row = |s: &&Spots| s.frequency == frequency && s.margin == margin && !s.lewis;
            assert!(SPOTS.iter().any(|s| row(&s)), "{frequency} {margin}");
        }
    }
}

/// A node by itself keeps to what is summed between two frequencies.
#[test]
fn nodes_between_two_frequencies_stay_below_chords() {
    let mut random = Random::new(73);
    for pair in gabor::NET.windows(2) {
        let [low, high] = [pair[0].0, pair[1].0];
        for _ in 0..20_000 {
            let (r, c) = (random.unit(), random.unit());
            let at = low + random.unit() * (high - low);
            for k in 1..4 {
                let size = |frequency| Spots { frequency, ..PLAIN }.size(k, r, c);
                let (ends, found) = ([size(low), size(high)], size(at));
                let envelope = [1, 2].map(|j| PLAIN.size(j, r, c));
                let bound = gabor::between(k, [low, at, high], ends, envelope);
                assert!(ends[0] <= found * (1.0 + 1e-12), "{k} {r} {c} {at}");
                assert!(found <= bound * (1.0 + 1e-12), "{k} {r} {c} {at}");
            }
        }
    }
}

#[test]
fn searches_between_frequencies_stay_below_the_bounds() {
    for (frequency, margin) in [(0.7, false), (1.8, true), (2.8, false), (7.0, true)] {
        let spots = Spots { name: "", lewis: false, margin, frequency };
        for claim in spots.claims() {
            let found = hunt(&spots, claim.order, 200);
            assert!(found <= claim.bound && found >= 0.8 * claim.bound, "{spots:?} {claim:?} {found}");
        }
    }
}
