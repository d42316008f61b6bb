//! What sits on the nodes of a lattice: a value, a direction, or both, drawn from a hash.

use super::parameter::{Allowed, Parameter, Settings};

/// Which directions nodes have. Either way they have mean zero and `E[g g^T] = 2/3 I`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Directions {
    /// The twelve `(+-1, +-1, 0)`, `(+-1, 0, +-1)`, `(0, +-1, +-1)`: centres of the edges of a cube.
    #[default]
    Edges,
    /// Uniform on the sphere of radius `sqrt(2)`: nothing prefers an axis, at some cost in time.
    Sphere,
}

impl Directions {
    /// As a parameter of a noise.
    pub(super) const PARAMETER: Parameter = Parameter {
        name: "directions",
        doc: "Directions of the slopes at nodes: the 12 edges of a cube, or uniform on the sphere.",
        allowed: Allowed::Choice(&["edges", "sphere"]),
    };

    pub(super) fn of(settings: &Settings) -> Directions {
        if settings.name("directions") == "sphere" { Directions::Sphere } else { Directions::Edges }
    }
}

/// A node's contribution to the interpolation: `value + g.d`, and the direction `g`.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub p: f64,
    pub g: [f64; 3],
}

/// What sits on a node, first as `W` words of 32 bits: twice as many of them fit into a vector as
/// of 64, so as much as possible is done with them.
pub(super) trait Node<const W: usize>: Copy {
    /// Whether nodes have directions; without, the parts that stem from them need no arithmetic.
    const SLOPED: bool = true;

    /// From the hash of the node.
    fn words(hash: u32) -> [u32; W];

    /// At an offset from the node.
    fn corner(words: [u32; W], d: [f64; 3]) -> Corner;
}

/// The words of a block of nodes.
#[inline(always)]
pub(super) fn words<const W: usize, N: Node<W>, const B: usize>(hashes: &[u32; B]) -> [[u32; B]; W] {
    let mut words = [[0; B]; W];
    for i in 0..B {
        let node = N::words(hashes[i]);
        for w in 0..W {
            words[w][i] = node[w];
        }
    }
    words
}

/// One of the twelve directions.
#[derive(Clone, Copy)]
pub(super) struct OnEdges;

impl Node<1> for OnEdges {
    #[inline(always)]
    fn words(hash: u32) -> [u32; 1] {
        [hash]
    }

    /// Two sign bits, and the axis without a component from the thirds of the range of the others.
    #[inline(always)]
    fn corner([h]: [u32; 1], d: [f64; 3]) -> Corner {
        const THIRD: u32 = u32::MAX / 3;
        let (first, last) = (h << 2 <= THIRD, h << 2 > 2 * THIRD);
        let sign = |x: f64, bit: u32| f64::from_bits(x.to_bits() ^ (u64::from(h << bit & 1 << 31) << 32));
        let u = sign(if first { d[1] } else { d[0] }, 0);
        let v = sign(if last { d[1] } else { d[2] }, 1);
        let (one_u, one_v) = (sign(1.0, 0), sign(1.0, 1));
        let y = if first { one_u } else { 0.0 };
        Corner {
            p: u + v,
            g: [
                if first { 0.0 } else { one_u },
                if last { one_v } else { y },
                if last { 0.0 } else { one_v },
            ],
        }
    }
}

/// A direction uniform on the sphere.
///
/// The area of a sphere between two parallel planes depends on their distance alone (Archimedes), so
/// a uniform height `z` and a uniform longitude give a uniform direction. The hash names one of 2^16
/// heights and one of 2^16 longitudes; all 2^32 patches have the same area, and the direction is the
/// centre of its patch. The longitude is within 45 degrees of one of the four horizontal half-axes,
/// where short Taylor polynomials give sine and cosine to `3e-7`. Everything happens in single
/// precision, of which a vector holds twice as many lanes and which is far finer than the patches;
/// a direction is exact by definition, being what it is computed to be. Its length is `sqrt(2)` to
/// within a millionth, for which the proven bounds have room ([`LENGTH`](OnSphere::LENGTH)).
#[derive(Clone, Copy)]
pub(super) struct OnSphere;

impl OnSphere {
    /// No direction is longer.
    pub(super) const LENGTH: f64 = std::f64::consts::SQRT_2 * (1.0 + 1e-6);
}

impl Node<3> for OnSphere {
    #[inline(always)]
    fn words(hash: u32) -> [u32; 3] {
        const STEP: f32 = std::f32::consts::FRAC_PI_2 / 16384.0;
        // The low bits of a product depend on few bits of its factors.
        let h = hash ^ (hash >> 16);
        let z = (32_767.5 - (h & 0xffff) as i32 as f32) * (1.0 / 32_768.0);
        let a = ((h >> 16 & 0x3fff) as i32 as f32 - 8191.5) * STEP;
        let r = std::f32::consts::SQRT_2 * ((1.0 - z) * (1.0 + z)).sqrt();
        let b = a * a;
        let sin = a * (1.0 - b * (1.0 / 6.0 - b * (1.0 / 120.0 - b * (1.0 / 5040.0))));
        let cos = 1.0 - b * (0.5 - b * (1.0 / 24.0 - b * (1.0 / 720.0 - b * (1.0 / 40_320.0))));
        let (along, across) = ((r * cos).to_bits() ^ (h & 1 << 31), (r * sin).to_bits());
        let swap = h & 1 << 30 != 0;
        let x = if swap { across } else { along };
        let y = if swap { along } else { across };
        [x, y, (std::f32::consts::SQRT_2 * z).to_bits()]
    }

    #[inline(always)]
    fn corner(words: [u32; 3], d: [f64; 3]) -> Corner {
        let g = words.map(|w| f64::from(f32::from_bits(w)));
        Corner { p: (g[0] * d[0] + g[1] * d[1]) + g[2] * d[2], g }
    }
}

/// A value uniform in `(-1, 1)`: the centres of 2^32 equal parts.
#[derive(Clone, Copy)]
pub(super) struct Level;

impl Node<1> for Level {
    const SLOPED: bool = false;

    #[inline(always)]
    fn words(hash: u32) -> [u32; 1] {
        [hash]
    }

    #[inline(always)]
    fn corner([h]: [u32; 1], _: [f64; 3]) -> Corner {
        Corner { p: (f64::from(h as i32) + 0.5) * (1.0 / 2_147_483_648.0), g: [0.0; 3] }
    }
}

/// A value beside a direction of kind `N`.
#[derive(Clone, Copy)]
pub(super) struct LevelAnd<N>(N);

/// One more round of the hash, for a word of its own.
#[inline(always)]
fn again(hash: u32) -> u32 {
    (hash ^ (hash >> 16)).wrapping_mul(0x21f0_aaad)
}

/// `value + g.d`
#[inline(always)]
fn raised(level: u32, corner: Corner) -> Corner {
    Corner { p: Level::corner([level], [0.0; 3]).p + corner.p, ..corner }
}

impl Node<2> for LevelAnd<OnEdges> {
    #[inline(always)]
    fn words(hash: u32) -> [u32; 2] {
        [hash, again(hash)]
    }

    #[inline(always)]
    fn corner([h, level]: [u32; 2], d: [f64; 3]) -> Corner {
        raised(level, OnEdges::corner([h], d))
    }
}

impl Node<4> for LevelAnd<OnSphere> {
    #[inline(always)]
    fn words(hash: u32) -> [u32; 4] {
        let [x, y, z] = OnSphere::words(hash);
        [x, y, z, again(hash)]
    }

    #[inline(always)]
    fn corner([x, y, z, level]: [u32; 4], d: [f64; 3]) -> Corner {
        raised(level, OnSphere::corner([x, y, z], d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::lattice::{Lattice, STEP, hash};

    /// Hashes of a cube of nodes.
    fn hashes() -> impl Iterator<Item = u32> {
        let key = Lattice::new(3).key();
        (0..1 << 18).map(move |i: u32| {
            let cell = [i & 63, i >> 6 & 63, i >> 12];
            hash(
                cell[0].wrapping_mul(STEP[0]) ^ cell[1].wrapping_mul(STEP[1]) ^ cell[2].wrapping_mul(STEP[2]),
                key,
            )
        })
    }

    /// Chi-square of counts that should be equal, in deviations from its mean.
    fn excess(counts: &[u32]) -> f64 {
        let (n, k) = (counts.iter().sum::<u32>() as f64, counts.len() as f64);
        let mean = n / k;
        let chi: f64 = counts.iter().map(|&c| (f64::from(c) - mean).powi(2) / mean).sum();
        (chi - (k - 1.0)) / (2.0 * (k - 1.0)).sqrt()
    }

    fn direction<const W: usize, N: Node<W>>(hash: u32) -> [f64; 3] {
        N::corner(N::words(hash), [0.0; 3]).g
    }

    #[test]
    fn all_edges_are_equally_likely() {
        let mut seen = std::collections::BTreeMap::new();
        for h in hashes() {
            let g = direction::<1, OnEdges>(h);
            assert!(g.iter().filter(|g| **g == 0.0).count() == 1);
            assert!(g.iter().all(|g| *g == 0.0 || g.abs() == 1.0));
            *seen.entry(g.map(|g| g as i32)).or_insert(0) += 1;
        }
        assert_eq!(seen.len(), 12);
        assert!(excess(&seen.into_values().collect::<Vec<_>>()).abs() < 4.0);
    }

    #[test]
    fn directions_are_uniform_on_the_sphere() {
        // Cells of equal area about each of the three axes in turn: 16 heights by 32 longitudes.
        for axis in 0..3 {
            let mut counts = [0; 512];
            for h in hashes() {
                let g = direction::<3, OnSphere>(h);
                let [x, y, z] = [1, 2, 3].map(|i| g[(axis + i) % 3]);
                let height = (z / OnSphere::LENGTH + 1.0) * 8.0;
                let turn = (libm::atan2(y, x) / std::f64::consts::TAU + 0.5) * 32.0;
                counts[(height as usize).min(15) * 32 + (turn as usize).min(31)] += 1;
            }
            assert!(excess(&counts).abs() < 4.0, "{axis} {}", excess(&counts));
        }
        // Second moments, by all 2^16 heights and all 2^16 longitudes.
        let mut moments = [0.0; 9];
        for i in 0..1_u32 << 16 {
            // What becomes of `hash` has its low half xored with the high one.
            for word in [(i << 16) | (i ^ 0x1234), i ^ 0x8000] {
                let g = direction::<3, OnSphere>(word);
                let length = (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).sqrt();
                assert!((length / 2_f64.sqrt() - 1.0).abs() < 9e-7 && length <= OnSphere::LENGTH);
            }
            let g = direction::<3, OnSphere>((i << 16) | (i ^ (i.wrapping_mul(40_503) & 0xffff)));
            (0..9).for_each(|k| moments[k] += g[k / 3] * g[k % 3] / 65_536.0);
        }
        for (k, m) in moments.into_iter().enumerate() {
            let expected = if k % 4 == 0 { 2.0 / 3.0 } else { 0.0 };
            assert!((m - expected).abs() < 0.01, "{k} {m}");
        }
    }

    #[test]
    fn values_are_uniform_and_independent_of_directions() {
        let (mut counts, mut mixed) = ([0; 256], [0.0; 3]);
        for h in hashes() {
            let value = Level::corner(Level::words(h), [0.0; 3]).p;
            assert!(value.abs() < 1.0);
            counts[((value + 1.0) * 128.0) as usize] += 1;
            let both = LevelAnd::<OnSphere>::corner(LevelAnd::<OnSphere>::words(h), [0.0; 3]);
            (0..3).for_each(|k| mixed[k] += both.p * both.g[k]);
        }
        assert!(excess(&counts).abs() < 4.0);
        // Means of products with deviation sqrt(1/3 2/3 / n).
        assert!(mixed.iter().all(|m| (m / 262_144.0).abs() < 4.0 * 0.4715 / 512.0), "{mixed:?}");
    }

    #[test]
    fn neighbouring_nodes_are_uncorrelated() {
        let all: Vec<[f64; 4]> = hashes()
            .map(|h| {
                let node = LevelAnd::<OnEdges>::corner(LevelAnd::<OnEdges>::words(h), [0.0; 3]);
                [node.p, node.g[0], node.g[1], node.g[2]]
            })
            .collect();
        for step in [1, 1 << 6, 1 << 12, 1 + (1 << 6), 2 + (3 << 6) + (1 << 12)] {
            let pairs = all.len() - step;
            for k in 0..16 {
                let mean =
                    (0..pairs).map(|i| all[i][k / 4] * all[i + step][k % 4]).sum::<f64>() / pairs as f64;
                assert!(mean.abs() < 5.0 * (2.0 / 3.0) / (pairs as f64).sqrt(), "{step} {k} {mean}");
            }
        }
    }
}
