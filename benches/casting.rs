//! Field evaluations and time per ray of every caster on surface (5.11) of the thesis, 800 x 800
//! pixels, over the rays that meet the bounding sphere of radius 1.55; then the whole picture, with
//! normals, shadows and shading, on all threads.
//!
//! `cargo bench --bench casting [-- CASTER]`

#[path = "../tests/common/mod.rs"]
mod common;
mod view;

use glam::DVec3;
use orogen::cast::{CastStats, Hit, Kind, Ray, caster};
use orogen::expr::NodeId;
use orogen::render::Job;
use orogen::scene::{Aabb, Camera, Film, Scene, Sky, Sun, Surface, direction};
use orogen::session::{Order, render};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

fn main() {
    let mut b = common::Build::default();
    let root = common::three_octaves(&mut b);
    let rays = view::rays(800, 1.55);
    let real: Vec<Ray> = rays.iter().copied().filter(|r| r.near < r.far).collect();
    let typical: Vec<Vec<Ray>> = rays.chunks(64).step_by(rays.len() / 640).map(<[Ray]>::to_vec).collect();
    println!("| caster | evaluations/ray | steps/ray | backtracks/ray | hits | CPU us/ray |");
    println!("|---|---|---|---|---|---|");
    let wanted = std::env::args().nth(1).filter(|a| !a.starts_with('-'));
    for (kind, name) in Kind::ALL.into_iter().filter(|k| wanted.as_ref().is_none_or(|w| w == k.1)) {
        let field = b.field(root);
        let Ok(mut caster) = caster(kind, &field, &Aabb::cube(1.55), &typical) else { continue };
        let mut stats = CastStats::default();
        let watch = view::Stopwatch::start();
        for group in rays.chunks(4096) {
            let mut hits = vec![Hit::MISS; group.len()];
            caster.first_hits(group, &mut hits, &mut stats, &AtomicBool::new(false));
        }
        let time = watch.seconds();
        let per_ray = |n: u64| n as f64 / real.len() as f64;
        println!(
            "| {name} | {:.2} | {:.2} | {:.2} | {} | {:.2} |",
            per_ray(stats.evaluations),
            per_ray(stats.steps),
            per_ray(stats.backtracks),
            stats.hits,
            1e6 * time / real.len() as f64
        );
    }
    if wanted.is_none() {
        whole_picture(root, b);
    }
}

fn whole_picture(root: NodeId, b: common::Build) {
    let camera = Camera::look_at(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO).with_fov(47.2);
    let scene = Scene {
        graph: Arc::new(b.0),
        surface: Surface { field: root, color: None, material: None, keep: None },
        camera,
        sun: Sun { direction: direction(140.0, 35.0), ..Sun::default() },
        lights: Vec::new(),
        sky: Sky::default(),
        moon: None,
        sea: None,
        film: Film { width: 800, height: 800, samples: 1, ..Film::default() },
        bounds: None,
        params: Vec::new(),
    };
    println!("\n| whole picture | seconds | evaluations/primary ray | evaluations/shadow ray | hits |");
    println!("|---|---|---|---|---|");
    for (caster, name) in Kind::ALL {
        let order = Order { caster, ..Order::default() };
        let start = Instant::now();
        let Ok(picture) = render(&scene, &order, &Job::unwatched(&AtomicBool::new(false))) else { continue };
        let (time, stats) = (start.elapsed().as_secs_f64(), picture.stats);
        let per_ray = |s: CastStats| s.evaluations as f64 / s.rays as f64;
        let (primary, shadow) = (per_ray(stats.primary), per_ray(stats.shadow));
        println!("| {name} | {time:.2} | {primary:.1} | {shadow:.1} | {} |", stats.primary.hits);
    }
}
