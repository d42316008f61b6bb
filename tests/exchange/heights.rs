//! Maps of heights: what is in them, and that they take no more memory for being larger.

use crate::memory::peak;
use exr::prelude::read_first_flat_layer_from_file;
use glam::DVec3;
use orogen::exchange::image::{self as pictures, Sheet};
use orogen::field::Watch;
use orogen::scene::Scene;
use orogen::script::{Request, compile};
use orogen::session;
use orogen::session::heights::{Chart, Datum, Mapped, Mapping, Projection, map_heights};
use std::fs;
use std::io::{Cursor, Seek, SeekFrom, Write};
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Hills that are a matter of direction alone, and that [`hill`] knows.
const HILLS: &str = "let q = p / length(p); sphere(1.0) - 0.1 * (q.x * q.y + 0.5 * q.z)";

fn hill(u: DVec3) -> f64 {
    0.1 * (u.x * u.y + 0.5 * u.z)
}

/// A planet with octaves that are finer than any pixel here.
const PLANET: &str = "import \"std/fractal\" as fractal;
    sphere(1.0) - 0.1 * fractal::ridged(gradient(7), #{ octaves: 12 }).scaled(3.0).on_sphere()";

fn scene(text: &str) -> Arc<Scene> {
    let compiled = compile(&Request::text(text));
    Arc::new(compiled.scene.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics)))
}

fn mapping(projection: Projection, size: u32) -> Mapping {
    let datum = Datum::Globe { center: DVec3::ZERO, radius: 1.0 };
    Mapping { chart: Chart { projection, size }, datum, range: None }
}

#[track_caller]
fn mapped(text: &str, mapping: &Mapping, path: &Path) -> Mapped {
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    map_heights(&scene(text), mapping, path, &watch).unwrap()
}

/// The numbers of a picture, as other programs read them: greys of a PNG, and the only channel of an EXR.
fn numbers(path: &Path) -> Vec<f64> {
    if path.extension().unwrap() == "png" {
        let picture = ::image::open(path).unwrap();
        assert_eq!(picture.color(), ::image::ColorType::L16);
        return picture.into_luma16().into_raw().into_iter().map(f64::from).collect();
    }
    let picture = read_first_flat_layer_from_file(path).unwrap();
    let channels = &picture.layer_data.channel_data.list;
    assert_eq!((channels.len(), channels[0].name.to_string().as_str()), (1, "Y"));
    channels[0].sample_data.values_as_f32().map(f64::from).collect()
}

/// The heights of a map, all faces in a row.
fn heights(mapping: &Mapping, path: &Path, mapped: &Mapped) -> Vec<f64> {
    let numbers = mapping.chart.files(path).iter().flat_map(|file| numbers(file)).collect::<Vec<_>>();
    let Some((black, white)) = mapped.range else { return numbers };
    numbers.into_iter().map(|grey| black + grey / 65535.0 * (white - black)).collect()
}

/// Directions of all pixels, in the same order.
fn directions(chart: Chart) -> impl Iterator<Item = DVec3> {
    let (width, size) = (chart.width(), chart.size);
    (0..chart.faces()).flat_map(move |face| {
        (0..size).flat_map(move |y| {
            (0..width).map(move |x| chart.direction(face, f64::from(x) + 0.5, f64::from(y) + 0.5))
        })
    })
}

const PROJECTIONS: [Projection; 2] = [Projection::Equirectangular, Projection::Cube];

fn both_formats(mut check: impl FnMut(Projection, &Path)) {
    let folder = tempfile::tempdir().unwrap();
    for projection in PROJECTIONS {
        for name in ["map.png", "map.exr"] {
            check(projection, &folder.path().join(name));
        }
    }
}

#[test]
fn a_sphere_is_flat() {
    both_formats(|projection, path| {
        let mapping = mapping(projection, 40);
        let sphere = mapped("sphere(1.0)", &mapping, path);
        let found = heights(&mapping, path, &sphere);
        assert_eq!(found.len() as u64, mapping.chart.pixels());
        assert!(found.iter().all(|h| h.abs() < 1e-9), "{projection:?} {path:?}");
        assert_eq!((sphere.heights, sphere.tally.cast.uncertified), ((0.0, 0.0), 0));
    });
}

#[test]
fn hills_are_as_high_as_they_are() {
    both_formats(|projection, path| {
        let mapping = mapping(projection, 75);
        let hills = mapped(HILLS, &mapping, path);
        // Half a step of grey, or of 32 bits.
        let precision = hills.range.map_or(6e-9, |(black, white)| 0.501 / 65535.0 * (white - black));
        for (height, u) in heights(&mapping, path, &hills).into_iter().zip(directions(mapping.chart)) {
            assert!((height - hill(u)).abs() < precision, "{projection:?} {path:?}: {height} at {u}");
        }
        let (lowest, highest) = hills.heights;
        assert!(lowest <= hills.tally.lowest && hills.tally.highest <= highest);
        assert_eq!((hills.tally.missed, hills.tally.cut, hills.beyond), (0, 0, 0));
    });
}

#[test]
fn what_floats_above_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let mapping = mapping(Projection::Cube, 33);
    let map = |text: &str| mapped(text, &mapping, &path);
    let islands = "let f = min(sphere(1.0), sphere(0.3).translated([1.6, 0, 0]));";
    let kept = map(&format!("{islands} largest_component(f)"));
    assert!(heights(&mapping, &path, &kept).iter().all(|h| h.abs() < 1e-7));
    assert_eq!((kept.tally.cast.uncertified, kept.warnings.len()), (0, 0));
    assert!(map(&format!("{islands} f")).heights.1 > 0.89);
}

#[test]
fn another_sphere_and_another_centre() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let center = DVec3::new(3.0, -1.0, 0.5);
    let datum = Datum::Globe { center, radius: 4.0 };
    let mapping = Mapping { datum, ..mapping(Projection::Cube, 33) };
    let ball = mapped("sphere(5.0).translated([3, -1, 0.5])", &mapping, &path);
    assert!(heights(&mapping, &path, &ball).iter().all(|h| (h - 1.0).abs() < 1e-7));
}

/// Level land, as it is written and as it is worn again.
#[test]
fn land_is_mapped_from_above() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("land.exr");
    let land = "y - 0.3 - 0.1 * sin(2.0 * x) * cos(z)";
    let datum = Datum::Plane { center: DVec3::new(1.0, 0.25, -2.0), depth: 4.0 };
    let mapping = Mapping { datum, ..mapping(Projection::Plane { width: 48 }, 32) };
    let found = mapped(land, &mapping, &path);
    assert_eq!((found.tally.missed, found.tally.cut, found.tally.cast.uncertified), (0, 0, 0));
    for (i, height) in heights(&mapping, &path, &found).into_iter().enumerate() {
        let [x, z] =
            [-2.0 + (f64::from(i as u32 % 48) + 0.5) / 8.0, -4.0 + (f64::from(i as u32 / 48) + 0.5) / 8.0];
        let truth = 0.05 + 0.1 * libm::sin(2.0 * x) * libm::cos(z);
        assert!((height - truth).abs() < 1e-6, "{x} {z}: {height} {truth}");
    }
    // Overhangs are seen from above, and there is an end to land.
    let found = mapped("min(sphere(0.5), sphere(0.2).translated([0, 2, 0]))", &mapping, &path);
    assert!(found.tally.missed > 1000 && found.tally.missed < 1536);
    let at = |text: &str| {
        let datum = Datum::Plane { center: DVec3::ZERO, depth: 0.1 };
        let mapping = Mapping { datum, ..mapping };
        let all = heights(&mapping, &path, &mapped(text, &mapping, &path));
        all[16 * 48 + 24]
    };
    assert!((at("min(sphere(0.5), sphere(0.2).translated([0, 2, 0]))") - 2.2).abs() < 1e-4);
}

#[test]
fn the_outermost_surface_counts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let mapping = mapping(Projection::Equirectangular, 16);
    let shells = "union(shell(sphere(2.0), 0.001), shell(sphere(1.5), 0.001))";
    let shells = mapped(shells, &mapping, &path);
    assert!(heights(&mapping, &path, &shells).iter().all(|h| *h > 1.0 && *h < 1.01));
    assert_eq!(shells.tally.cast.uncertified, 0);
}

#[test]
fn faces_meet_at_their_edges() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let mapping = mapping(Projection::Cube, 128);
    let planet = mapped(PLANET, &mapping, &path);
    let heights = heights(&mapping, &path, &planet);
    let size = mapping.chart.size as usize;
    let at = |face: usize, x: usize, y: usize| heights[(face * size + y) * size + x];
    // How much neighbours in a face differ at most.
    let across = (0..6 * size * size).filter(|i| i % size > 0).map(|i| (heights[i] - heights[i - 1]).abs());
    let most = across.fold(0.0, f64::max);
    let end = size - 1;
    // px nx py ny pz nz are 0 to 5.
    let difference = (0..size).flat_map(|i| {
        [
            at(4, end, i) - at(0, 0, i),
            at(0, end, i) - at(5, 0, i),
            at(1, end, i) - at(4, 0, i),
            at(2, i, end) - at(4, i, 0),
            at(3, i, 0) - at(4, i, end),
            at(2, i, 0) - at(5, end - i, 0),
        ]
    });
    let worst = difference.map(f64::abs).fold(0.0, f64::max);
    assert!(worst <= most && worst > 0.0, "{worst} between faces, {most} within");
}

#[test]
fn the_last_column_is_followed_by_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let mapping = mapping(Projection::Equirectangular, 64);
    let planet = mapped(PLANET, &mapping, &path);
    let heights = heights(&mapping, &path, &planet);
    let within = heights.windows(2).enumerate().filter(|(i, _)| i % 128 != 127);
    let most = within.map(|(_, w)| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    for row in heights.chunks(128) {
        assert!((row[127] - row[0]).abs() <= most);
    }
}

#[test]
fn detail_finer_than_a_pixel_fades() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    // Of the second octave a half is left.
    let mapping = mapping(Projection::Equirectangular, 64);
    let numbers = |octaves: &str| {
        let fbm = "fractal::fbm(gradient(7), #{ octaves: OCTAVES })".replace("OCTAVES", octaves);
        let import = "import \"std/fractal\" as fractal;";
        let text = format!("{import} sphere(1.0) - 0.1 * {fbm}.scaled(3.0).on_sphere()");
        heights(&mapping, &path, &mapped(&text, &mapping, &path))
    };
    assert_eq!(numbers("12"), numbers("16"));
    assert_ne!(numbers("12"), numbers("1"));
}

#[test]
fn the_bytes_do_not_depend_on_threads() {
    let scene = scene(PLANET);
    both_formats(|projection, path| {
        let mapping = mapping(projection, 100);
        let bytes = |threads: usize| {
            let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
            let job = || map_heights(&scene, &mapping, path, &watch);
            session::on_threads(NonZeroUsize::new(threads), job).unwrap().unwrap();
            mapping.chart.files(path).iter().map(|file| fs::read(file).unwrap()).collect::<Vec<_>>()
        };
        let one = bytes(1);
        assert!(one == bytes(2) && one == bytes(5), "{projection:?} {path:?}");
    });
}

#[test]
fn what_is_beyond_the_range_is_cut_off_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    let mapping = Mapping { range: Some((-0.01, 0.03)), ..mapping(Projection::Equirectangular, 50) };
    let hills = mapped(HILLS, &mapping, &path);
    let mut beyond = 0;
    for (grey, u) in numbers(&path).into_iter().zip(directions(mapping.chart)) {
        let share = (hill(u) + 0.01) / 0.04;
        beyond += u64::from(!(0.0..=1.0).contains(&share));
        assert!((grey - 65535.0 * share.clamp(0.0, 1.0)).abs() < 0.501);
    }
    assert!(beyond > 100 && hills.beyond.abs_diff(beyond) <= 1, "{} {beyond}", hills.beyond);
    assert_eq!(hills.range, Some((-0.01, 0.03)));
    // What other programs are told.
    let reader =
        png::Decoder::new(std::io::BufReader::new(fs::File::open(&path).unwrap())).read_info().unwrap();
    let text = |name: &str| {
        let texts = &reader.info().uncompressed_latin1_text;
        texts.iter().find(|t| t.keyword == name).map(|t| t.text.clone())
    };
    assert_eq!(text("Range").as_deref(), Some("-0.01..0.03"));
    assert_eq!(text("Heights above").as_deref(), Some("a sphere of radius 1 around 0,0,0"));
    assert_eq!(text("Projection").as_deref(), Some("equirectangular"));
}

#[test]
fn where_there_is_nothing_maps_are_empty() {
    both_formats(|projection, path| {
        let mapping = mapping(projection, 40);
        let ring = mapped("torus(1.0, 0.3)", &mapping, path);
        let precision = ring.range.map_or(2e-8, |(black, white)| 0.501 / 65535.0 * (white - black));
        let numbers: Vec<f64> = mapping.chart.files(path).iter().flat_map(|file| numbers(file)).collect();
        let mut missed = 0;
        for ((u, height), number) in
            directions(mapping.chart).zip(heights(&mapping, path, &ring)).zip(numbers)
        {
            // Where the tube's circle, in the plane of the ray and the axis, is left for the last time.
            let depth = 0.09 - u.y * u.y;
            if depth > 0.0 {
                let known = (1.0 - u.y * u.y).sqrt() + depth.sqrt() - 1.0;
                assert!((height - known).abs() < precision, "{height} {known} at {u}");
            } else {
                missed += 1;
                assert!(
                    if ring.range.is_some() { number == 0.0 } else { number.is_nan() },
                    "{number} at {u}"
                );
            }
        }
        assert_eq!((ring.tally.missed, ring.tally.cast.uncertified), (missed, 0));
    });
}

#[test]
fn a_solid_that_is_cut_off_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let text = "scene(#{ surface: sphere(1.0), bounds: 0.9 })";
    let cut = mapped(text, &mapping(Projection::Cube, 32), &path);
    let pixels = mapping(Projection::Cube, 32).chart.pixels();
    assert!(cut.tally.cut > pixels / 10 && cut.tally.cut < pixels, "{} of {pixels}", cut.tally.cut);
}

#[test]
fn what_fails_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let names = || fs::read_dir(folder.path()).unwrap().count();
    both_formats(|projection, path| {
        let path = folder.path().join(path.file_name().unwrap());
        let mapping = mapping(projection, 200);
        let files = mapping.chart.files(&path);
        fs::write(&files[0], "earlier").unwrap();
        let fails = |text: &str, stop_at: f64| {
            let cancel = AtomicBool::new(false);
            let progress = |share: f64| {
                let _ = cancel.fetch_or(share >= stop_at, Ordering::Relaxed);
            };
            let watch = Watch { cancel: &cancel, progress: &progress };
            map_heights(&scene(text), &mapping, &path, &watch).unwrap_err().message
        };
        assert!(fails("sphere(1.0)", 0.3).contains("stopped"));
        assert!(fails("sphere(1.0) + 9.0", 2.0).contains("no ray met a solid"));
        assert!(
            fails("scene(#{ surface: sphere(1.0), bounds: [[1, 0, 0], [2, 1, 1]] })", 2.0)
                .contains("no ray met")
        );
        assert_eq!((fs::read(&files[0]).unwrap(), names()), (b"earlier".to_vec(), 1));
        fs::remove_file(&files[0]).unwrap();
    });
}

#[test]
fn maps_take_no_more_memory_for_being_higher() {
    /// Counts bytes and forgets them.
    #[derive(Default)]
    struct Sink(u64);
    impl Write for Sink {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0 += bytes.len() as u64;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    impl Seek for Sink {
        fn seek(&mut self, _: SeekFrom) -> std::io::Result<u64> {
            Ok(self.0)
        }
    }
    let rough = |band: &mut [f64]| {
        band.iter_mut().enumerate().for_each(|(i, v)| *v = (i * i % 977) as f64 / 977.0);
        Ok(())
    };
    let sheet = |height| Sheet { width: 256, height, notes: &[] };
    // On one thread, whose memory is counted.
    let memory = |height| {
        let png = || pictures::write_png(&sheet(height), Sink::default(), &mut { rough });
        let exr = || pictures::write_exr(&sheet(height), Sink::default(), &mut { rough });
        let both = || [peak(|| png().unwrap()).1, peak(|| exr().unwrap()).1];
        session::on_threads(NonZeroUsize::new(1), both).unwrap()
    };
    let (low, high) = (memory(128), memory(128 * 64));
    for (low, high) in low.into_iter().zip(high) {
        // A table of where each 16 rows are, of 8 bytes each, is all there is of the rest.
        assert!(high < low + 128 * 64, "{low} {high}");
    }

    let folder = tempfile::tempdir().unwrap();
    let scene = scene("sphere(1.0)");
    let whole = |name: &str, size: u32| {
        let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
        let path = folder.path().join(name);
        let job = || peak(|| map_heights(&scene, &mapping(Projection::Cube, size), &path, &watch).unwrap()).1;
        session::on_threads(NonZeroUsize::new(1), job).unwrap()
    };
    for name in ["map.png", "map.exr"] {
        let (small, large) = (whole(name, 128), whole(name, 512));
        // Four times as wide, sixteen times the pixels: a share that grows with them would show.
        assert!(large < 5 * small.max(1 << 18), "{name}: {small} {large}");
    }
}

#[test]
fn maps_can_be_worn() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.exr");
    mapped(HILLS, &mapping(Projection::Equirectangular, 128), &map);
    let script = folder.path().join("worn.rhai");
    let wears = "let map = load_heightfield(\"map.exr\", #{
            extent: 2.0 * PI, repeat: true, center: [PI / 256.0, 0.0, PI / 256.0],
        });
        let latitude = atan2(y, length(vec3(x, 0.0, z)));
        sphere(1.0) - map.at(vec3(atan2(x, z), 0.0, -latitude))";
    fs::write(&script, wears).unwrap();
    let mut session = session::Session::new(&script, Arc::new(orogen::world::Disk));
    let loaded = session.load(&Arc::default());
    let scene = loaded.scene.clone().unwrap_or_else(|| panic!("{:?}", loaded.diagnostics));
    let mut field = orogen::field::Field::new(&scene.graph, scene.surface.field);
    for u in directions(Chart { projection: Projection::Equirectangular, size: 37 }) {
        // Within a few pixels of a pole the other one shows through, since the map repeats.
        let near_a_pole = u.y.abs() > 0.99;
        let off = (field.value(u) + hill(u)).abs();
        assert!(off < if near_a_pole { 5e-3 } else { 1e-6 }, "{off} at {u}");
    }
}

#[test]
fn rows_that_fail_are_what_is_reported() {
    let sheet = Sheet { width: 8, height: 200, notes: &[] };
    let mut bands = 0;
    let mut broken = |_: &mut [f64]| {
        bands += 1;
        if bands < 3 { Ok(()) } else { Err(std::io::Error::other("a broken disk")) }
    };
    let error = pictures::write_exr(&sheet, Cursor::new(Vec::new()), &mut broken).unwrap_err();
    assert_eq!(error.to_string(), "a broken disk");
    let mut large = |band: &mut [f64]| {
        band.fill(1e39);
        Ok(())
    };
    let error = pictures::write_exr(&sheet, Cursor::new(Vec::new()), &mut large).unwrap_err();
    assert_eq!(error.kind(), std::io::ErrorKind::InvalidInput);
}
