//! Casting through flows: what certificates cost beside the heuristic of the thesis, and where that errs.
//!
//! The cases are those of figures 9.8 and 9.9: a sphere carried along by three noises, or by the slope of one. Rays are
//! those of tiles of a picture of 800 x 800. Costs a ray count trajectories, those of a whole tile shared among its rays.
//! Pass `strong` for the strongest flows, which take long.

use glam::DVec3;
use orogen::cast::{CastStats, Hit, Kind, Ray, Tolerance, caster};
use orogen::field::Field;
use orogen::scene::Aabb;
use orogen::script::{Request, compile};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Tiles of 16 x 16 rays at places that are spread over the picture.
fn tiles(region: &Aabb) -> Vec<Vec<Ray>> {
    let eye = DVec3::new(0.0, 0.0, 5.2);
    let pixel = 2.0 * 0.2679 / 800.0;
    let ray = |i: usize, j: usize| {
        let direction = DVec3::new((i as f64 - 400.0) * pixel, (j as f64 - 400.0) * pixel, -1.0).normalize();
        let (near, far) = region.clip(eye, direction)?;
        Some(Ray { origin: eye, direction, near, far, tolerance: Tolerance { least: 1e-9, growth: 1e-4 } })
    };
    let tile = |k: usize| {
        let (left, top) = (16 * (11 + (7 * k) % 28), 16 * (11 + (11 * k) % 28));
        (0..256).filter_map(|i| ray(left + i % 16, top + i / 16)).collect()
    };
    (0..12).map(tile).collect()
}

fn main() {
    let strong = std::env::args().any(|a| a == "strong");
    let mut cases = vec![
        ("direct 0.1", "0.1 * vector_noise(gradient(1).scaled(4.0))"),
        ("direct 0.5", "0.5 * vector_noise(gradient(1).scaled(4.0))"),
        ("slope 0.01", "0.01 * slope(gradient(1).scaled(4.0))"),
        ("slope 0.025", "0.025 * slope(gradient(1).scaled(4.0))"),
        ("cellular 0.1", "0.1 * vector_noise(cellular(1).scaled(4.0))"),
    ];
    if strong {
        cases.push(("slope 0.04", "0.04 * slope(gradient(1).scaled(4.0))"));
        cases.push(("direct 1.0", "1.0 * vector_noise(gradient(1).scaled(4.0))"));
        cases.push(("cellular 0.5", "0.5 * vector_noise(cellular(1).scaled(4.0))"));
    }
    println!("| flow | steps | caster | evaluations/ray | us/ray | not certified | other hits |");
    println!("|---|---|---|---|---|---|---|");
    let region = Aabb::cube(2.4);
    for (name, velocity) in cases {
        let compiled = compile(&Request::text(format!("sphere(1.0).unflow({velocity})")));
        let Some(scene) = compiled.scene else { panic!("{:?}", compiled.diagnostics) };
        let field = Field::new(&scene.graph, scene.surface.field);
        let steps = field.tape().flowed().map_or(0, |flowed| flowed.steps());
        let mut found: Vec<Vec<Hit>> = Vec::new();
        for kind in [Kind::Beam, Kind::Bent] {
            let mut caster = caster(kind, &field, &region, &[]).expect("a caster");
            let (mut stats, mut hits) = (CastStats::default(), Vec::new());
            let start = Instant::now();
            for rays in tiles(&region) {
                let mut out = vec![Hit::MISS; rays.len()];
                caster.first_hits(&rays, &mut out, &mut stats, &AtomicBool::new(false));
                hits.extend(out);
            }
            let time = start.elapsed().as_secs_f64();
            found.push(hits);
            let differ = |(a, b): (&Hit, &Hit)| a.is_hit() != b.is_hit() || (a.t - b.t).abs() > 2e-3;
            let others = found[0].iter().zip(&found[found.len() - 1]).filter(|pair| differ(*pair)).count();
            let rays = stats.rays as f64;
            println!(
                "| {name} | {steps} | {} | {:.1} | {:.1} | {} | {others} |",
                if kind == Kind::Beam { "certified" } else { "bent" },
                stats.evaluations as f64 / rays,
                time * 1e6 / rays,
                stats.uncertified,
            );
        }
    }
}
