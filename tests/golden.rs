//! Golden pictures: small renders that must look as they did when a person last approved them.
//!
//! Tolerance: at most one pixel in two hundred may differ by more than 8 of 255 in a channel, and the
//! mean difference must stay under half a level. That admits a caster that places hits a little
//! differently within its tolerance, and nothing that an eye would notice. After a change that is
//! meant to be seen, look at the new pictures and store them with `ORO_GOLDEN=write cargo test golden`.

use orogen::render::{Job, Metadata, save};
use orogen::script::{Request, Script, compile};
use orogen::session::{Order, render};
use orogen::world::Disk;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn golden(script: &str, name: &str, size: Option<(u32, u32)>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let compiled = compile(&Request::new(Script::File(root.join(script)), Arc::new(Disk)));
    let scene = compiled.scene.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    let order = Order { size, samples: size.map(|_| 1), ..Order::default() };
    let picture = render(&scene, &order, &Job::unwatched(&AtomicBool::new(false))).unwrap();
    let reference = root.join("tests/golden").join(name).with_extension("png");
    if std::env::var_os("ORO_GOLDEN").is_some_and(|v| v == "write") {
        save(&reference, &picture, &Metadata::default()).unwrap();
    }
    let expected = image::open(&reference).unwrap().to_rgb8();
    assert_eq!(expected.dimensions(), (picture.width, picture.height), "{name}");
    let actual: Vec<u8> = (0..picture.height).flat_map(|y| picture.row_bytes(y)).collect();
    let differences: Vec<u8> = actual.iter().zip(expected.as_raw()).map(|(a, b)| a.abs_diff(*b)).collect();
    let far = differences.chunks(3).filter(|p| p.iter().any(|d| *d > 8)).count();
    let mean = differences.iter().map(|d| f64::from(*d)).sum::<f64>() / differences.len() as f64;
    if far * 200 > differences.len() / 3 || mean > 0.5 {
        let seen = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name).with_extension("png");
        save(&seen, &picture, &Metadata::default()).unwrap();
        panic!("{name}: {far} pixels differ, mean {mean:.2}; compare {seen:?} with {reference:?}");
    }
}

#[test]
fn shapes() {
    golden("tests/golden/shapes.rhai", "shapes", None);
}

#[test]
fn octaves() {
    golden("tests/golden/octaves.rhai", "octaves", None);
}

#[test]
fn ridges() {
    golden("tests/golden/ridges.rhai", "ridges", None);
}

#[test]
fn ground_from_two_metres_above() {
    golden("scripts/ground.rhai", "ground", Some((96, 72)));
}

#[test]
fn planet() {
    golden("scripts/planet.rhai", "planet", Some((120, 90)));
}

#[test]
fn light() {
    golden("tests/golden/light.rhai", "light", None);
}
