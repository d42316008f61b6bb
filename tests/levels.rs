//! Pictures are equal bit for bit with every instruction set of this machine, on any number of threads,
//! and what they cost is the same.
//!
//! The instruction set is that of the whole process, so this is one test in a program of its own.

mod common;

use common::Build;
use glam::DVec3;
use orogen::cast::{CastStats, Hit, Kind, Ray, Tolerance, caster};
use orogen::num::{Level, limit_simd};
use orogen::render::{Job, Picture, Stats};
use orogen::scene::{Aabb, Scene};
use orogen::script::{Request, Script, compile};
use orogen::session::{Order, render};
use orogen::world::Disk;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A ball with a little of every noise, and shadows.
const NOISES: &str = r#"
let rough = gradient(1).at(4.0 * p) + value(2).at(3.0 * p) + value_gradient(3).at(5.0 * p)
    + simplex(4).at(4.0 * p) + sparse(5).at(3.0 * p) + gabor(6).at(3.0 * p) + cellular(7).at(3.0 * p)
    + wavelet(8).at(4.0 * p) + waves(9).at(3.0 * p) + weierstrass(10).at(2.0 * p);
scene(#{ surface: sphere(1.0) + 0.03 * rough, sun: sun(#{ azimuth: 80.0, elevation: 30.0 }) })
"#;

/// A ball that cellular noise carries along, which is cast through cubes that all rays share.
const CARRIED: &str = r#"
scene(#{ surface: sphere(1.0).flow(0.2 * vector_noise(cellular(7).scaled(4.0)), #{ steps: 4 }),
    sun: sun(#{ azimuth: 80.0, elevation: 30.0 }) })
"#;

/// Scenes by name: shapes, octaves with and without a Lipschitz bound, a planet in its air, all noises, a flow.
fn scenes() -> Vec<(&'static str, Scene)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = ["tests/golden/shapes", "tests/golden/octaves", "tests/golden/ridges", "scripts/planet"];
    let file = |name: &'static str| {
        let path = root.join(name).with_extension("rhai");
        (name, Request::new(Script::File(path), Arc::new(Disk)))
    };
    let requests = files
        .into_iter()
        .map(file)
        .chain([("noises", NOISES), ("carried", CARRIED)].map(|(name, text)| (name, Request::text(text))));
    requests.map(|(name, request)| (name, compile(&request).scene.expect("a scene"))).collect()
}

/// Everything about a picture but the time that it took.
fn all_of(picture: Picture) -> (Vec<[u32; 12]>, Vec<u8>, Stats) {
    let pixels = picture.pixels.iter().map(|p| {
        let [r, g, b] = p.color;
        let ([x, y, z], [u, v, w]) = (p.position, p.normal);
        [r, g, b, p.alpha, p.depth, x, y, z, u, v, w, p.evaluations].map(f32::to_bits)
    });
    let pixels = pixels.collect();
    let bytes = (0..picture.height).flat_map(|y| picture.row_bytes(y)).collect();
    let mut stats = picture.stats;
    (stats.seconds, stats.threads) = Default::default();
    (pixels, bytes, stats)
}

/// First and any hits of neighbouring rays in double precision.
fn hits(kind: Kind) -> Vec<[u64; 2]> {
    let mut b = Build::default();
    let root = common::three_octaves(&mut b);
    let region = Aabb::cube(1.6);
    let eye = DVec3::new(1.0, 2.0, -3.0);
    let ray = |i: u32| {
        let [x, y] = [i % 16, i / 16].map(|k| f64::from(k) / 8.0 - 1.0);
        let direction = (DVec3::new(0.9 * x, y, 0.3 * x) - eye).normalize();
        let (near, far) = region.clip(eye, direction).unwrap_or((0.0, -1.0));
        Ray { origin: eye, direction, near, far, tolerance: Tolerance::fixed(1e-6) }
    };
    let rays: Vec<Ray> = (0..256).map(ray).collect();
    let mut made = caster(kind, &b.field(root), &region, &[rays[..64].to_vec()]).expect("a caster");
    let (mut first, mut any) = (vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]);
    let never = AtomicBool::new(false);
    made.first_hits(&rays, &mut first, &mut CastStats::default(), &never);
    made.any_hits(&rays, &mut any, &mut CastStats::default(), &never);
    first.iter().zip(&any).map(|(first, any)| [first.t.to_bits(), any.t.to_bits()]).collect()
}

#[test]
fn every_instruction_set_makes_the_same_pictures() {
    let scenes = scenes();
    // Bent rays are for flowed solids.
    for (kind, kind_name) in Kind::ALL.into_iter().filter(|k| k.0 != Kind::Bent) {
        let plain = {
            limit_simd(Level::Baseline);
            hits(kind)
        };
        for level in [Level::Avx2, Level::Avx512] {
            let level = limit_simd(level);
            assert!(plain == hits(kind), "{kind_name} with {level:?}");
        }
    }
    for (name, scene) in &scenes {
        let through_cubes = (*name == "carried").then_some(Kind::Octree);
        for caster in [Kind::Beam, Kind::Auto].into_iter().chain(through_cubes) {
            let shoot = |level: Level, threads: usize| {
                let threads = NonZeroUsize::new(threads);
                let order =
                    Order { size: Some((40, 24)), samples: Some(1), caster, threads, ..Order::default() };
                let level = limit_simd(level);
                let never = AtomicBool::new(false);
                let mut all = all_of(render(scene, &order, &Job::unwatched(&never)).expect("a picture"));
                if *name == "carried" && caster != Kind::Beam {
                    // Threads that ask about a cube at once both evaluate the noise there.
                    all.2.octaves = Default::default();
                }
                (level, all)
            };
            let (_, plain) = shoot(Level::Baseline, 1);
            assert!(plain.2.primary.hits > 40, "{name}: {:?}", plain.2);
            for (level, threads) in [(Level::Avx2, 2), (Level::Avx512, 3)] {
                let (level, picture) = shoot(level, threads);
                assert!(plain == picture, "{name}, {caster:?}, {level:?} on {threads} threads");
            }
        }
    }
    limit_simd(Level::Avx512);
}
