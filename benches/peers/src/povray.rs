//! Surface (5.11) of the thesis by POV-Ray, and by orogen.

use crate::clock::race;
use glam::DVec3;
use orogen::render::Job;
use orogen::scene::{Camera, Film, Scene, Sun};
use orogen::script::{Request, compile};
use orogen::session::{Order, render};
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;

const SIZE: u32 = 800;

/// The surface with our noise.
const SURFACE: &str = "length(p) - 1 + 0.3 * gradient(1).scaled(4.0) + 0.15 * gradient(2).scaled(8.0) \
    + 0.05 * gradient(3).scaled(16.0)";

/// Largest gradients: as the scene says, and the smallest with which nothing is missing.
const GRADIENTS: [(&str, &str); 2] = [("as written", "9.8"), ("tuned", "6.72")];

pub fn table(folder: &Path) {
    if povray(folder, "9.8", false, 16).is_none() {
        println!(
            "There is no `povray` on the path, or it cannot trace {}.",
            folder.join("oct3.pov").display()
        );
        return;
    }
    println!("Surface (5.11), {SIZE} x {SIZE}, whole pictures, one thread each, CPU seconds\n");
    println!("| shadows | POV-Ray, as written | tuned | orogen | factor to tuned |\n|---|---|---|---|---|");
    for shadows in [false, true] {
        let scene = scene(shadows);
        let [written, tuned, ours] = race(
            2,
            [
                &mut || povray(folder, GRADIENTS[0].1, shadows, SIZE).unwrap_or_default(),
                &mut || povray(folder, GRADIENTS[1].1, shadows, SIZE).unwrap_or_default(),
                &mut || picture(&scene),
            ],
        );
        let with = if shadows { "with" } else { "without" };
        println!("| {with} | {written:.2} | {tuned:.2} | {ours:.2} | {:.2} |", ours / tuned);
    }
}

fn povray(folder: &Path, gradient: &str, shadows: bool, size: u32) -> Option<()> {
    let out = std::env::temp_dir().join("orogen-peers.png");
    let done = Command::new("povray")
        .current_dir(folder)
        .args([
            format!("+W{size}"),
            format!("+H{size}"),
            "-A".into(),
            "-D".into(),
            "-V".into(),
            "+WT1".into(),
        ])
        .args([format!("Declare=SHADOW={}", u8::from(shadows)), format!("Declare=MG={gradient}")])
        .args(["+Ioct3.pov".into(), format!("+O{}", out.display())])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let _ = std::fs::remove_file(out);
    done.ok()?.success().then_some(())
}

fn scene(shadows: bool) -> Scene {
    let compiled = compile(&Request::text(SURFACE));
    let scene = compiled.scene.expect("the script is right");
    // POV-Ray's axes are left-handed.
    let camera = Camera::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO).with_fov(48.0);
    let sun = Sun { direction: DVec3::new(5.0, 7.0, 9.0), shadows, ..Sun::default() };
    Scene { camera, sun, film: Film { width: SIZE, height: SIZE, samples: 1, ..Film::default() }, ..scene }
}

fn picture(scene: &Scene) {
    let order = Order { threads: NonZeroUsize::new(1), ..Order::default() };
    let picture = render(scene, &order, &Job::unwatched(&AtomicBool::new(false)));
    assert!(picture.is_ok(), "a picture of a scene that is right");
}
