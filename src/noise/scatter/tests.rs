//! What every noise made of scattered spots owes, for all placements, kernels and weights.

use super::*;
use crate::noise::tests::{Random, check_box, jets_of};
use crate::noise::{Fractal, Kind, Model, Noise, Recipe, Setting, Settings};
use crate::num::{Bounds, Class, Kernel, Level, Local, Order, limit_simd};

fn kind(name: &str, settings: &[(&'static str, Setting)]) -> Kind {
    let listing = Kind::ALL.iter().find(|l| l.name == name).unwrap();
    let mut all = Settings::new(listing.parameters);
    settings.iter().for_each(|(name, value)| all.set(name, *value).unwrap());
    (listing.build)(&all)
}

/// A kind with its variance.
fn kinds() -> Vec<(Kind, f64)> {
    let (n, word) = (Setting::Number, Setting::Name);
    let (nodes, place, kernel, weights) = ("nodes", "placement", "kernel", "weights");
    let along = ("direction", Setting::Direction(Some([1.0, 2.0, -2.0])));
    let (quintic, lewis) = (0.37313, 0.37713);
    vec![
        (kind("sparse", &[]), quintic),
        (kind("sparse", &[(nodes, n(3.0)), (weights, word("uniform"))]), 3.0 * quintic),
        (kind("sparse", &[(kernel, word("lewis")), (nodes, n(2.0))]), 2.0 * lewis),
        (kind("sparse", &[(place, word("poisson")), (nodes, n(2.0))]), 2.0 * quintic),
        (kind("sparse", &[(place, word("disc")), (nodes, n(5.0))]), quintic),
        (kind("sparse", &[(place, word("disc")), (kernel, word("lewis"))]), lewis),
        (kind("gabor", &[]), 0.5 * quintic),
        (kind("gabor", &[("frequency", n(0.5)), (place, word("poisson")), along]), 0.5 * quintic),
        (
            kind("gabor", &[("frequency", n(8.0)), (place, word("disc")), along, ("spread", n(20.0))]),
            0.5 * quintic,
        ),
    ]
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// `u^T H u`
fn bend(h: [f64; 6], u: [f64; 3]) -> f64 {
    let [x, y, z] = u;
    h[0] * x * x + h[1] * y * y + h[2] * z * z + 2.0 * (h[3] * x * y + h[4] * x * z + h[5] * y * z)
}

#[test]
fn derivatives_match_differences() {
    let mut random = Random::new(31);
    for (kind, _) in kinds() {
        let noise = Noise::new(kind, 5);
        let b = noise.bounds();
        for _ in 0..300 {
            let (p, step) = (random.point(50.0), 1e-5);
            let jet = noise.jet(Order::Hessian, p);
            for axis in 0..3 {
                let side = |h: f64| {
                    let mut q = p;
                    q[axis] += h;
                    noise.jet(Order::Gradient, q)
                };
                let (low, high) = (side(-step), side(step));
                let slope = (high.value - low.value) / (2.0 * step);
                let third = if b.third.is_finite() { b.third } else { 1e6 };
                assert!(
                    (slope - jet.grad[axis]).abs() < third * step * step + 1e-9 * b.range / step,
                    "{kind:?} {p:?}"
                );
                for other in 0..3 {
                    let pair = [[0, 3, 4], [3, 1, 5], [4, 5, 2]][axis][other];
                    let difference = (high.grad[other] - low.grad[other]) / (2.0 * step);
                    let off = (difference - jet.hess[pair]).abs();
                    // Two spots' rims within a step of a point are not seen in so many samples.
                    assert!(off < 10.0 * third * step, "{kind:?} {p:?} {off}");
                }
            }
        }
    }
}

#[test]
fn cells_and_rims_meet_as_smoothly_as_the_class_says() {
    let mut random = Random::new(32);
    for (kind, _) in kinds() {
        let noise = Noise::new(kind, 6);
        let b = noise.bounds();
        for i in 0..2000 {
            let mut p = random.point(30.0);
            p[i % 3] = p[i % 3].floor();
            let mut q = p;
            q[i % 3] -= 1e-13;
            let (a, c) = (noise.jet(Order::Hessian, p), noise.jet(Order::Hessian, q));
            assert!((a.value - c.value).abs() < 2e-13 * b.lipschitz);
            assert!((0..3).all(|k| (a.grad[k] - c.grad[k]).abs() < 2e-13 * b.hessian));
            if kind.class() == Class::C2 {
                assert!((0..6).all(|k| (a.hess[k] - c.hess[k]).abs() < 4e-13 * b.third), "{kind:?} {p:?}");
            }
        }
        // Along a line that crosses many rims.
        let step = 1e-5;
        let mut jump = 0.0_f64;
        let points: Vec<_> = (0..200_000).map(|i| [f64::from(i) * step, 0.37, 0.61]).collect();
        for pair in jets_of(&noise, Order::Hessian, &points).windows(2) {
            let u = [1.0, 0.0, 0.0];
            jump = jump.max((bend(pair[1].hess, u) - bend(pair[0].hess, u)).abs());
            assert!(
                norm([0, 1, 2].map(|k| pair[1].grad[k] - pair[0].grad[k])) <= b.hessian * step * 1.000001
            );
        }
        match kind.class() {
            Class::C2 => assert!(jump <= b.third * step * 1.000001, "{kind:?} {jump}"),
            _ => assert!(jump > 0.2, "{kind:?}: no jump of the Hessian in sight: {jump}"),
        }
    }
}

#[test]
fn every_level_and_grouping_gives_the_same_bits() {
    let mut random = Random::new(33);
    let points: Vec<[f64; 3]> = (0..101)
        .map(|i| random.point([1.0, 1e3, 1e9, 1e17, 1e-9][i % 5]))
        .chain((0..20).map(|i| [0.1 * f64::from(i), 0.5, 0.25]))
        .chain([[0.0, -0.0, -1e-300], [f64::NAN, 1.0, 2.0], [f64::INFINITY, 0.5, 0.5], [1.0, 2.0, -3.0]])
        .collect();
    let bits = |p: &Point| {
        let mut all = vec![p.value];
        all.extend(p.grad.iter().chain(&p.hess));
        all.into_iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect::<Vec<_>>()
    };
    for (kind, _) in kinds() {
        for period in [[0; 3], [3, 0, 5]] {
            let lattice = Lattice { seed: 20, period };
            let noise = Noise { lattice, ..Noise::new(kind, 20) };
            for order in [Order::Value, Order::Gradient, Order::Hessian] {
                let single: Vec<_> = points.iter().map(|p| bits(&noise.jet(order, *p))).collect();
                // No other test may mind the level, which changes no bits.
                for level in [Level::Baseline, Level::Avx2, Level::Avx512] {
                    limit_simd(level);
                    for group in [1, 7, 16, points.len()] {
                        for (part, single) in points.chunks(group).zip(single.chunks(group)) {
                            let jets = jets_of(&noise, order, part);
                            for (i, jet) in jets.iter().enumerate() {
                                assert_eq!(bits(jet), single[i], "{kind:?} {level:?} {group} {:?}", part[i]);
                            }
                        }
                    }
                }
            }
            // A ball's jet is the point's.
            for p in &points {
                let exact = bits(&noise.jet(Order::Hessian, *p));
                let local = noise.local(Order::Hessian, *p, 0.2);
                assert_eq!(bits(&local.jet), exact, "{kind:?} {p:?}");
            }
        }
    }
}

#[test]
fn mean_and_variance_are_as_stated() {
    for (kind, variance) in kinds() {
        let mut random = Random::new(34);
        let (mut sum, mut squares, rounds) = (0.0, 0.0, 400);
        for seed in 0..rounds {
            let noise = Noise::new(kind, seed);
            let points: Vec<_> = (0..1000).map(|_| random.point(1e3)).collect();
            for jet in jets_of(&noise, Order::Value, &points) {
                sum += jet.value;
                squares += jet.value * jet.value;
            }
        }
        let n = rounds as f64 * 1000.0;
        assert!((sum / n).abs() < 5.0 * (variance / n).sqrt(), "{kind:?}: mean {}", sum / n);
        let found = squares / n;
        assert!((found / variance - 1.0).abs() < 0.02, "{kind:?}: variance {found} for {variance}");
    }
}

#[test]
fn uniform_nodes_do_not_show_the_lattice() {
    // Variances at a corner, a face and the centre of cells.
    let places = [[0.0; 3], [0.5, 0.5, 0.0], [0.5; 3]];
    let at = |kind: Kind| {
        places.map(|place| {
            let mut random = Random::new(35);
            let noise = Noise::new(kind, 9);
            let n = 60_000;
            let points: Vec<_> = (0..n)
                .map(|_| {
                    let p = random.point(1e4);
                    [0, 1, 2].map(|i| p[i].floor() + place[i])
                })
                .collect();
            jets_of(&noise, Order::Value, &points).iter().map(|j| j.value * j.value).sum::<f64>()
                / f64::from(n)
        })
    };
    for kind in [kind("sparse", &[]), kind("gabor", &[])] {
        let v = at(kind);
        assert!((v[1] / v[0] - 1.0).abs() < 0.04 && (v[2] / v[0] - 1.0).abs() < 0.04, "{kind:?} {v:?}");
    }
    // Discs do: their nodes are nearer to the centre.
    let v = at(kind("sparse", &[("placement", Setting::Name("disc"))]));
    assert!(v[2] > 1.2 * v[0], "{v:?}");
}

#[test]
fn enclosures_contain_samples() {
    let mut random = Random::new(36);
    for (kind, _) in kinds() {
        let recipe = Recipe { octaves: 1, ..Recipe::new(Noise::new(kind, 3).at_frequency(1.5), Model::FBM) };
        let plain = Fractal::new(recipe.clone()).unwrap();
        let sum = Fractal::new(Recipe { octaves: 3, rotate: true, ..recipe }).unwrap();
        for _ in 0..600 {
            check_box(&plain, [false; 2], &mut random);
            check_box(&sum, [false; 2], &mut random);
        }
    }
}

/// A random vector of length up to 1.
fn ball(random: &mut Random) -> [f64; 3] {
    loop {
        let v = random.point(1.0);
        if norm(v) <= 1.0 {
            return v;
        }
    }
}

#[test]
fn balls_are_bounded_and_small_ones_tightly() {
    let mut random = Random::new(37);
    for (kind, _) in kinds() {
        let noise = Noise::new(kind, 4);
        let global = noise.bounds();
        let mut gains = [0.0; 3];
        for n in 0..800 {
            let mut c = random.point(1e3);
            if n % 4 == 0 {
                c = c.map(f64::round);
            }
            let radius = [1e-9, 1e-3, 0.02, 0.2, 0.49, 2.0][n % 6];
            let Local { bounds: b, .. } = noise.local(Order::Gradient, c, radius);
            if n % 6 == 2 {
                gains[0] += global.lipschitz / b.lipschitz / 134.0;
                gains[1] += global.hessian / b.hessian / 134.0;
                gains[2] += global.range / b.range / 134.0;
            }
            for _ in 0..30 {
                let (e, u) = (ball(&mut random), ball(&mut random));
                let u = u.map(|x| x / norm(u));
                let p = [0, 1, 2].map(|i| c[i] + radius * e[i]);
                let jet = noise.jet(Order::Hessian, p);
                assert!(jet.value.abs() <= b.range, "{kind:?} {c:?} {radius}");
                assert!(norm(jet.grad) <= b.lipschitz, "{kind:?} {c:?} {radius}");
                assert!(bend(jet.hess, u).abs() <= b.hessian, "{kind:?} {c:?} {radius}");
                if b.third.is_finite() {
                    let q = [0, 1, 2].map(|i| c[i] + radius * ((1.0 - 1e-4) * e[i]));
                    let step = norm([0, 1, 2].map(|i| p[i] - q[i]));
                    let change = bend(jet.hess, u) - bend(noise.jet(Order::Hessian, q).hess, u);
                    let rounding = 2.0 * 3.0 * noise.error(norm(c))[2];
                    assert!(
                        change.abs() <= b.third * step * (1.0 + 1e-6) + rounding,
                        "{kind:?} {c:?} {radius}"
                    );
                }
            }
        }
        assert!(gains.iter().all(|&gain| gain > 8.0), "{kind:?} {gains:?}");
    }
}

#[test]
fn samples_respect_the_bounds() {
    for (i, (kind, _)) in kinds().into_iter().enumerate() {
        let b: Bounds = kind.bounds();
        let mut random = Random::new(38 + i as u64);
        for seed in 0..120 {
            let noise = Noise::new(kind, seed);
            let points: Vec<_> =
                (0..1000).map(|_| random.point([10.0, 1e4, 1e7][seed as usize % 3])).collect();
            for jet in jets_of(&noise, Order::Hessian, &points) {
                assert!(jet.value.abs() <= b.range && norm(jet.grad) <= b.lipschitz);
                assert!(jet.hess.iter().all(|h| h.abs() <= b.hessian));
            }
        }
    }
}

#[test]
fn periods_repeat() {
    let mut random = Random::new(39);
    for (kind, _) in kinds() {
        for period in [[1, 2, 3], [8, 8, 8], [0, 5, 0]] {
            let noise = Noise { lattice: Lattice { seed: 7, period }, ..Noise::new(kind, 7) };
            for _ in 0..100 {
                // Coordinates whose fractions survive the shift.
                let p = random.point(20.0).map(|x| (x * 1024.0).round() / 1024.0);
                let q = [0, 1, 2].map(|i| p[i] + f64::from(period[i]) * (random.point(5.0)[i]).round());
                assert_eq!(noise.jet(Order::Hessian, p), noise.jet(Order::Hessian, q), "{kind:?} {period:?}");
            }
        }
    }
}

#[test]
fn total_for_any_coordinate() {
    let mut random = Random::new(40);
    for (kind, _) in kinds() {
        let noise = Noise::new(kind, 1);
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(noise.jet(Order::Value, [0.3, x, 0.4]).value.is_nan());
            assert_eq!(noise.local(Order::Value, [0.3, x, 0.4], 0.1).bounds, noise.bounds());
        }
        for radius in [f64::NAN, f64::INFINITY] {
            assert_eq!(noise.local(Order::Value, [0.3, 0.2, 0.4], radius).bounds, noise.bounds());
        }
        for _ in 0..1000 {
            let p = random.point(1.0).map(|x| x * 10_f64.powi((random.unit() * 300.0) as i32));
            assert!(noise.jet(Order::Value, p).value.abs() <= noise.bounds().range, "{p:?}");
        }
    }
}

fn scatter(placement: Placement, nodes: u8) -> Draw {
    Scatter { nodes, placement, bell: true }.draw(&Lattice::new(17))
}

#[test]
fn nodes_are_uniform_and_weights_are_bells() {
    let draw = scatter(Placement::Uniform, 1);
    let n = 1_000_000_u32;
    // Place along each axis, weight, and what comes next; their covariances are those of independent
    // variables, and pairs of places fill all squares alike.
    let (mut first, mut second) = ([0.0; 5], [[0.0; 5]; 5]);
    let mut squares = vec![[0_u32; 256]; 3];
    for i in 0..n {
        let word = i.wrapping_mul(STEP_OF_TEST[0]) ^ (i / 1000).wrapping_mul(STEP_OF_TEST[1]);
        let node = draw.node(word, (i % 4) as usize, [0.0; 3]);
        let p = node.d.map(|d| -d);
        let root = 12.0_f64.sqrt();
        let all = [
            (p[0] - 0.5) * root,
            (p[1] - 0.5) * root,
            (p[2] - 0.5) * root,
            node.weight,
            (uniform(node.word) - 0.5) * root,
        ];
        for a in 0..5 {
            first[a] += all[a];
            (0..5).for_each(|b| second[a][b] += all[a] * all[b]);
        }
        for (k, [a, b]) in [[0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
            squares[k][(p[a] * 16.0) as usize * 16 + (p[b] * 16.0) as usize] += 1;
        }
        assert!(p.iter().all(|p| (0.0..1.0).contains(p)) && node.weight.abs() <= 3.0);
    }
    let error = 5.0 / f64::from(n).sqrt();
    for a in 0..5 {
        assert!((first[a] / f64::from(n)).abs() < error, "{first:?}");
        for b in 0..5 {
            let expected = f64::from(u8::from(a == b));
            assert!((second[a][b] / f64::from(n) - expected).abs() < 2.0 * error, "{a} {b} {}", second[a][b]);
        }
    }
    for square in squares {
        let mean = f64::from(n) / 256.0;
        let chi: f64 = square.iter().map(|&c| (f64::from(c) - mean) * (f64::from(c) - mean) / mean).sum();
        // 255 degrees of freedom, deviation 22.6.
        assert!((140.0..370.0).contains(&chi), "{chi}");
    }
}

const STEP_OF_TEST: [u32; 2] = [0x9e37_79b1, 0x85eb_ca77];

#[test]
fn counts_are_poisson() {
    for mean in [1_u8, 2, 8] {
        let draw = scatter(Placement::Poisson, mean);
        let tail = draw.tail.unwrap();
        let (mut sum, mut squares, n) = (0.0, 0.0, 200_000);
        for i in 0..n {
            let count = draw.count(i * 7919);
            let nodes = tail[..draw.slots].iter().filter(|t| count < **t).count() as f64;
            sum += nodes;
            squares += nodes * nodes;
        }
        let (m, n) = (f64::from(mean), f64::from(n));
        assert!((sum / n / m - 1.0).abs() < 0.01, "{mean}: {}", sum / n);
        assert!(((squares / n - (sum / n) * (sum / n)) / m - 1.0).abs() < 0.02, "{mean}");
    }
}

#[test]
fn discs_keep_their_distance() {
    let draw = scatter(Placement::Disc, 1);
    let node = |cell: [i32; 3]| {
        let word = (0..3).fold(0, |w, i| w ^ (cell[i] as u32).wrapping_mul(super::super::lattice::STEP[i]));
        let d = draw.node(word, 0, [-draw.margin; 3]).d;
        [0, 1, 2].map(|i| f64::from(cell[i]) - d[i])
    };
    for i in 0..20_000 {
        let cell = [i % 30, i / 30 % 30, i / 900];
        let own = node(cell);
        assert!((0..3).all(|k| (0.3..=0.7).contains(&(own[k] - f64::from(cell[k])).clamp(0.0, 1.0))));
        for o in 0..27 {
            let other = [cell[0] + o % 3 - 1, cell[1] + o / 3 % 3 - 1, cell[2] + o / 9 - 1];
            if other != cell {
                let p = node(other);
                assert!(norm([0, 1, 2].map(|k| own[k] - p[k])) >= 0.6 - 1e-12);
            }
        }
    }
}
