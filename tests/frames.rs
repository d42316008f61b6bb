//! Parts of pictures, animations and videos: what is put together, resumed or shared is what would have been made in one
//! go, byte for byte.

mod support;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use std::collections::BTreeMap;
use std::fs;
use std::time::Duration;
use support::{Bench, has, stderr};

/// A solid that moves, with detail in every pixel and more than one way to see it.
const ROCK: &str = "
    let relief = param(\"relief\", 0.1, 0.0..0.5);
    scene(#{
        surface: sphere(1.0 + 0.1 * time) - relief * gradient(7).scaled(6.0),
        film: film(#{ width: 97, height: 70, samples: 2 }),
    })
";

/// The same with a file beside it, and small enough for many frames.
const IMPORTING: &str = "import \"shape\" as shape; shape::ball(1.0 + 0.5 * time)";
const SHAPE: &str = "fn ball(r) { sphere(r) - 0.1 * gradient(3).scaled(4.0) }";

fn rock() -> Bench {
    Bench::new(&[("rock.rhai", ROCK), ("a.rhai", IMPORTING), ("shape.rhai", SHAPE)])
}

/// All files of a folder that are frames, with what they hold.
fn frames(bench: &Bench) -> BTreeMap<String, Vec<u8>> {
    frames_of(bench, "png")
}

/// The same of those with an ending.
fn frames_of(bench: &Bench, ending: &str) -> BTreeMap<String, Vec<u8>> {
    let is_frame = |name: &String| name.ends_with(ending) && !name.starts_with('.');
    bench.names().into_iter().filter(is_frame).map(|name| (name.clone(), bench.read(&name))).collect()
}

// ---- parts --------------------------------------------------------------------------------------

#[test]
fn merged_tiles_are_the_whole_picture_byte_for_byte() {
    let bench = rock();
    for (size, counts) in [("97x70", &[2, 3, 5, 12][..]), ("64x48", &[4]), ("30x100", &[3])] {
        for (ending, options) in [("png", ""), ("exr", ""), ("exr", "--exr half")] {
            let render = format!("render rock.rhai --size {size} {options}");
            bench.run(&format!("{render} -o whole.{ending}")).success();
            for n in counts {
                // Backwards, since the order must not matter; on other numbers of threads.
                let parts: Vec<String> = (1..=*n).rev().map(|i| format!("{i}.{ending}")).collect();
                for (i, part) in (1..=*n).rev().zip(&parts) {
                    bench
                        .run(&format!("{render} --tile {i}/{n} --threads {} -o {part}", i % 2 + 1))
                        .success();
                }
                bench.run(&format!("merge {} -o merged.{ending}", parts.join(" "))).success();
                let same = bench.read(&format!("merged.{ending}")) == bench.read(&format!("whole.{ending}"));
                assert!(same, "{size} {ending} {options} in {n} parts");
            }
        }
    }
}

#[test]
fn regions_hold_the_pixels_of_the_whole() {
    let bench = rock();
    bench.run("render rock.rhai").success();
    let said = stderr(&bench.run("render rock.rhai --region 33,5,40x64").success());
    has(&said, &["rock.region.png", "33,5,40x64 of 97x70"]);
    let open = |name: &str| image::open(bench.path(name)).unwrap().to_rgb8();
    let (whole, region) = (open("rock.png"), open("rock.region.png"));
    assert_eq!(region.dimensions(), (40, 64));
    assert!(region.enumerate_pixels().all(|(x, y, pixel)| whole.get_pixel(x + 33, y + 5) == pixel));
    assert!(!region.pixels().all(|pixel| pixel == region.get_pixel(0, 0)));
}

#[test]
fn an_exr_has_its_region_as_data_window_and_light_in_halves() {
    use exr::prelude::*;
    let bench = rock();
    bench.run("render rock.rhai --exr float -o float.exr").success();
    bench.run("render rock.rhai --exr half --region 10,20,30x40 -o half.exr").success();
    let open = |name: &str| read_first_flat_layer_from_file(bench.path(name)).unwrap();
    let (float, half) = (open("float.exr"), open("half.exr"));
    assert_eq!(half.attributes.display_window, float.attributes.display_window);
    assert_eq!(half.attributes.display_window.size, Vec2(97, 70));
    let layer = &half.layer_data;
    assert_eq!((layer.attributes.layer_position, layer.size), (Vec2(10, 20), Vec2(30, 40)));
    for (small, large) in layer.channel_data.list.iter().zip(&float.layer_data.channel_data.list) {
        let name = small.name.to_string();
        let geometry = ["Z", "position", "normal", "footprint", "samples"];
        let light = !geometry.contains(&name.split('.').next().unwrap_or(&name));
        assert_eq!(matches!(small.sample_data, FlatSamples::F16(_)), light, "{}", small.name);
        let all: Vec<f32> = large.sample_data.values_as_f32().collect();
        for (i, value) in small.sample_data.values_as_f32().enumerate() {
            let expected = all[(20 + i / 30) * 97 + 10 + i % 30];
            let expected = if light { f16::from_f32(expected).to_f32() } else { expected };
            assert!(value == expected, "{} at {i}: {value} for {expected}", small.name);
        }
    }
}

#[test]
fn an_exr_says_which_component_is_seen() {
    use exr::prelude::*;
    let script = "scene(#{
        surface: union([sphere(1.0), sphere(0.4).translated([2.0, 0.0, 0.0]), sphere(0.3).translated([-2.0, 0.0, 0.0])]),
        camera: look_at(#{ eye: [0, 0, 10], target: [0, 0, 0] }),
        film: film(#{ width: 101, height: 41, samples: 2 }) })";
    let moving = script.replace("samples: 2", "samples: 2, shutter: 0.5");
    let bench = Bench::new(&[("balls.rhai", script), ("moving.rhai", &moving)]);
    let warns = |script: &str, file: &str| {
        let said = bench.run(&format!("render {script} --components -o {file}")).success();
        String::from_utf8_lossy(&said.get_output().stderr).contains("when the shutter opens")
    };
    assert!(warns("moving.rhai", "moving.exr"));
    assert!(!warns("balls.rhai", "balls.exr"));
    bench.run("render balls.rhai --exr float -o plain.exr").success();
    let channel = |file: &str, name: &str| -> Option<Vec<f32>> {
        let list = read_first_flat_layer_from_file(bench.path(file)).unwrap().layer_data.channel_data.list;
        let found = list.iter().find(|channel| channel.name.to_string() == name)?;
        Some(found.sample_data.values_as_f32().collect())
    };
    assert_eq!(channel("plain.exr", "component"), None);
    assert_eq!(channel("plain.exr", "R"), channel("balls.exr", "R"));
    let (seen, depth) = (channel("balls.exr", "component").unwrap(), channel("balls.exr", "Z").unwrap());
    let at = |x: usize| seen[20 * 101 + x];
    // The largest comes first in the report, and the others by size.
    assert_eq!(
        (at(50), at(50 + 13), at(50 - 13), at(0)),
        (0.0, 1.0, 2.0, -1.0),
        "{:?}",
        &seen[20 * 101..21 * 101]
    );
    assert!(seen.iter().zip(&depth).all(|(number, depth)| (*number >= 0.0) == depth.is_finite()));
    for tile in 1..=3 {
        bench.run(&format!("render balls.rhai --components --tile {tile}/3 -o {tile}.exr")).success();
    }
    bench.run("merge 1.exr 2.exr 3.exr -o whole.exr").success();
    assert_eq!(bench.read("whole.exr"), bench.read("balls.exr"));
}

#[test]
fn parts_that_do_not_belong_together_are_named() {
    let bench = rock();
    let render =
        |options: &str| bench.run(&format!("render a.rhai --size 64x48 --samples 1 {options}")).success();
    for (options, name) in [("--tile 1/2", "1"), ("--tile 2/2", "2"), ("--region 20,0,44x48", "wide")] {
        render(&format!("{options} -o {name}.png"));
    }
    render("--tile 2/2 -o 2.exr");
    render("--tile 2/2 --time 1 -o later.png");
    bench.run("render a.rhai --size 96x48 --samples 1 --tile 2/2 -o larger.png").success();
    bench.run("render a.rhai --size 64x48 --samples 2 --tile 2/2 -o finer.png").success();
    bench.run("render rock.rhai --size 64x48 --samples 1 --tile 2/2 -o rock.png").success();
    bench.run("render rock.rhai --size 64x48 --samples 1 --tile 1/2 --set relief=0.2 -o rough.png").success();
    bench.write("shape.rhai", format!("{SHAPE} // changed"));
    render("--tile 2/2 -o changed.png");
    let whole = bench.read("2.png");
    bench.write("cut.png", &whole[..whole.len() - 9]);
    let mut bad = whole.clone();
    let middle = bad.len() - 200;
    bad[middle] ^= 1;
    bench.write("bad.png", bad);
    image::RgbImage::new(64, 48).save(bench.path("foreign.png")).unwrap();
    for (parts, pieces) in [
        ("1.png", &["no part holds the pixels 32,0,32x48", "--region 32,0,32x48"][..]),
        ("1.png 1.png 2.png", &["1.png", "both hold the pixels 0,0,32x48"]),
        ("1.png wide.png", &["1.png", "wide.png", "20,0,12x48"]),
        ("1.png later.png", &["later.png", "`time 1`", "`time 0`"]),
        ("1.png finer.png", &["finer.png", "`samples 2`"]),
        ("1.png larger.png", &["larger.png", "64 x 48", "96 x 48"]),
        ("1.png rock.png", &["rock.png", "the script was another"]),
        ("rock.png rough.png", &["rough.png", "relief=0.2, not relief=0.1"]),
        ("1.png changed.png", &["changed.png", "shape.rhai"]),
        ("1.png 2.exr", &["2.exr", "one format"]),
        ("1.png cut.png", &["cut.png", "damaged", "render it again"]),
        ("1.png bad.png", &["bad.png", "damaged"]),
        ("1.png none.png", &["none.png", "cannot read"]),
        ("1.png a.rhai", &["a.rhai", ".png or .exr"]),
        ("1.png foreign.png", &["foreign.png", "is not a picture that orogen made"]),
    ] {
        has(&stderr(&bench.run(&format!("merge {parts} -o whole.png")).code(1)), pieces);
    }
    has(&stderr(&bench.run("merge 1.png 2.png -o whole.exr").code(1)), &["1.png", "whole.exr", "ending"]);
    assert!(!bench.names().iter().any(|name| name.starts_with("whole")));
    bench.run("merge 1.png 2.png -o whole.png").success();
}

#[test]
fn parts_and_frames_that_make_no_sense() {
    let bench = rock();
    for (arguments, pieces) in [
        ("render rock.rhai --tile 0/3", &["--tile", "parts count from 1", "--tile 2/4"][..]),
        ("render rock.rhai --tile 4/3", &["no part 4 of 3"]),
        ("render rock.rhai --region 1,2,3", &["--region", "320,200,64x48"]),
        ("render rock.rhai --region 0,0,0x5", &["320,200,64x48"]),
        ("render rock.rhai --region 0,0,9x9 --tile 1/2", &["cannot be used with"]),
        ("render rock.rhai --exr double", &["double"]),
        ("render rock.rhai --exr half -o rock.png", &["--exr", "-o rock.exr"]),
        ("render rock.rhai --components -o rock.png", &["--components", "-o rock.exr"]),
        ("render rock.rhai --frames 5-1", &["the first frame, 5, comes after the last, 1", "--frames 1-250"]),
        ("render rock.rhai --frames 1-5:0", &["a step of 0"]),
        ("render rock.rhai --frames all", &["--frames 1-250:5"]),
        ("render rock.rhai --frames 1-5 -o rock.png", &["number of a frame", "rock.####.png"]),
        ("render rock.rhai --frames 1-5 --fps 0", &["--fps 25"]),
        ("render rock.rhai --frames 1-5 --fps -5", &["--fps 25"]),
        ("render rock.rhai --fps --frames 1-5", &["a value is required for '--fps"]),
        ("render rock.rhai --frames 1-5 --stats", &["cannot be used with"]),
        ("merge -o a.png", &["PART"]),
        ("merge a.png", &["--output"]),
        ("merge a.png -o a.gif", &[".png or .exr"]),
        ("video rock.####.png -o rock.gif", &[".mp4, .mov or .mkv"]),
        ("video rock.####.exr -o rock.mp4", &["frames of a video are .png", "rock.####.png"]),
        ("video rock.png -o rock.mp4", &["number of a frame", "rock.####.png"]),
    ] {
        let said = stderr(&bench.run(arguments).code(2));
        has(&said, pieces);
    }
    // What depends on the size that the script says is known later.
    for (arguments, pieces) in [
        ("render rock.rhai --region 90,0,10x10", &["90,0,10x10", "97 x 70", "0,0,97x70"][..]),
        ("render rock.rhai --tile 1/13", &["12 parts at most", "1 to 12"]),
        ("render rock.rhai --frames 1-2 --tile 1/13", &["12 parts at most", "frame 1, at 0.04 s"]),
        ("render rock.rhai --frames 1-2 -o none/a.#.png", &["none", "does not exist"]),
    ] {
        has(&stderr(&bench.run(arguments).code(1)), pieces);
    }
    assert_eq!(bench.names(), ["a.rhai", "rock.rhai", "shape.rhai"]);
}

#[test]
fn parts_do_not_take_the_place_of_one_another() {
    let bench = rock();
    let render = "render rock.rhai --size 64x48 --samples 1 -o p.png";
    bench.run(&format!("{render} --tile 1/3")).success();
    let first = bench.read("p.png");
    let said = stderr(&bench.run(&format!("{render} --tile 2/3")).code(1));
    has(&said, &["p.png holds another of the 3 parts", "-o 'p.2of3.png'"]);
    assert!(bench.read("p.png") == first);
    bench.run(&format!("{render} --tile 1/3")).success();
    assert!(bench.read("p.png") == first);

    let render = "render a.rhai --frames 1-2 --size 64x48 --samples 1 -o b.#.png";
    bench.run(&format!("{render} --tile 1/2")).success();
    let first = frames(&bench);
    has(
        &stderr(&bench.run(&format!("{render} --tile 2/2")).code(1)),
        &["b.1.png holds another", "-o 'b.#.2of2.png'"],
    );
    assert_eq!(frames(&bench), first);
}

// ---- frames -------------------------------------------------------------------------------------

/// Twelve frames that take long enough to be killed in.
const MANY: &str = "render a.rhai --frames 1-12 --size 64x48 --samples 4";

#[test]
fn frames_are_pictures_at_their_times() {
    let bench = rock();
    let said = stderr(&bench.run("render a.rhai --frames 8-12:2 --fps 8 --time 1 --size 64x48").success());
    has(&said, &["a.0008.png to a.0012.png: 3 frames"]);
    // A video takes frames that follow one another.
    assert!(!said.contains("orogen video"), "{said}");
    assert_eq!(frames(&bench).keys().collect::<Vec<_>>(), ["a.0008.png", "a.0010.png", "a.0012.png"]);
    bench.run("render a.rhai --time 2.25 --size 64x48 -o alone.png").success();
    assert!(bench.read("a.0010.png") == bench.read("alone.png"));
    assert!(bench.read("a.0010.png") != bench.read("a.0012.png"));
    let said = stderr(&bench.run("render a.rhai --frames 8-9 --fps 8 --size 64x48 -o b.#.png").success());
    has(&said, &["b.8.png to b.9.png: 2 frames", "orogen video 'b.#.png' -o 'b.mp4' --fps 8"]);
}

#[test]
fn what_is_saved_meanwhile_is_for_the_next_time() {
    let bench = rock();
    bench.run(MANY).success();
    let expected = frames(&bench);
    expected.keys().for_each(|name| fs::remove_file(bench.path(name)).unwrap());
    let run = bench.start(MANY);
    run.wait_until("a frame is there", || bench.path("a.0001.png").exists());
    bench.write("shape.rhai", SHAPE.replace("0.1", "0.3"));
    bench.write("a.rhai", IMPORTING.replace("0.5", "0.9"));
    let (code, said) = run.end();
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(frames(&bench), expected);
    has(&stderr(&bench.run(MANY).success()), &["a.0001.png (and 11 more) is made again", "has changed"]);
}

#[test]
fn frames_that_are_there_are_left_alone() {
    let bench = rock();
    let render = "render a.rhai --frames 1-3 --size 64x48 --samples 1";
    bench.run(render).success();
    let first = frames(&bench);
    let time = |name: &str| fs::metadata(bench.path(name)).unwrap().modified().unwrap();
    let before = time("a.0001.png");
    fs::remove_file(bench.path("a.0002.png")).unwrap();
    has(&stderr(&bench.run(render).success()), &["1 frame in", "2 were there"]);
    assert_eq!(time("a.0001.png"), before);
    assert_eq!(frames(&bench), first);

    // Damaged, cut off, or somebody else's.
    for bytes in [&first["a.0002.png"][..60], b"", &first["a.0003.png"]] {
        bench.write("a.0002.png", bytes);
        has(&stderr(&bench.run(render).success()), &["a.0002.png is made again", "2 were there"]);
        assert_eq!(frames(&bench), first);
    }
}

#[test]
fn frames_that_would_come_out_otherwise_are_made_again() {
    let bench = rock();
    let render = "render a.rhai --frames 1-2";
    bench.run(&format!("{render} --samples 1 --size 64x48")).success();
    let again = |options: &str, reason: &str| {
        let said = stderr(&bench.run(&format!("{render} {options}")).success());
        has(&said, &["a.0001.png (and 1 more) is made again", reason, "2 frames in"]);
        let said = stderr(&bench.run(&format!("{render} {options}")).success());
        has(&said, &["0 frames in", "2 were there"]);
    };
    again("--samples 1 --size 32x48", "`size 64x48`");
    again("--samples 1 --size 64x48 --fps 50", "`size 32x48`");
    again("--samples 1 --size 64x48 --fps 25", "`time 0.02`");
    again("--size 64x48 --samples 2", "`samples 1`");
    bench.write("shape.rhai", format!("{SHAPE}\n// another day"));
    again("--size 64x48 --samples 2", "shape.rhai has changed");
    bench.write("a.rhai", format!("{IMPORTING} // another night"));
    again("--size 64x48 --samples 2", "a.rhai has changed");
    again("--size 64x48 --samples 2 --tile 1/2 -o a.####.png", "another part");
}

#[test]
fn tiles_of_frames_merge_to_the_frames() {
    let bench = rock();
    let render = "render a.rhai --frames 1-2 --size 64x48 --samples 1";
    bench.run(render).success();
    for tile in ["1/2", "2/2"] {
        bench.run(&format!("{render} --tile {tile}")).success();
    }
    for n in ["0001", "0002"] {
        bench.run(&format!("merge a.{n}.1of2.png a.{n}.2of2.png -o merged.png")).success();
        assert!(bench.read("merged.png") == bench.read(&format!("a.{n}.png")));
    }
}

#[test]
fn killed_at_ten_moments_and_resumed_the_frames_are_the_same() {
    for ending in ["png", "exr"] {
        let bench = rock();
        let render = format!("{MANY} -o a.####.{ending}");
        bench.run(&render).success();
        let expected = frames_of(&bench, ending);
        assert_eq!(expected.len(), 12);

        let mut random = StdRng::seed_from_u64(8);
        let mut unfinished = 0;
        for _ in 0..10 {
            // Some are there, and most are not.
            let mut names: Vec<_> = frames_of(&bench, ending).into_keys().collect();
            while names.len() > 2 {
                fs::remove_file(bench.path(&names.swap_remove(random.random_range(0..names.len())))).unwrap();
            }
            let run = bench.start(&render);
            let some = names.len() + random.random_range(0..6);
            run.wait_until("some frames are there", || frames_of(&bench, ending).len() >= some);
            std::thread::sleep(Duration::from_millis(random.random_range(0..40)));
            run.kill();
            // What there is has the bytes that it will have in the end.
            let there = frames_of(&bench, ending);
            assert!(there.iter().all(|(name, bytes)| expected[name] == *bytes));
            unfinished += usize::from(there.len() < 12);
        }
        assert!(unfinished >= 5, "{unfinished} of ten runs were killed before their end");
        bench.run(&render).success();
        assert_eq!(frames_of(&bench, ending), expected);
        let left = bench.names();
        assert!(left.iter().all(|name| !name.ends_with(".claim")), "{left:?}");
    }
}

#[test]
fn frames_that_cannot_be_made_do_not_stop_the_others() {
    let bench = rock();
    let script = |when: &str| {
        format!("let t = time.at([0, 0, 0]); if {when} {{ throw `late: ${{t}}` }} sphere(1.0 + 0.1 * time)")
    };
    bench.write("b.rhai", script("t > 0.25 && t < 0.45"));
    let render = "render b.rhai --frames 0-6 --fps 10 --size 32x24 --samples 1";
    let said = stderr(&bench.run(render).code(1));
    has(&said, &["frame 3, at 0.3 s:", "late: 0.3", "frame 4, at 0.4 s:", "late: 0.4"]);
    has(&said, &["2 of 7 frames cannot be made (3, 4)", "5 of 7 frames are finished"]);
    assert_eq!(frames(&bench).len(), 5);
    // Also those at the beginning, and behind others that are there.
    bench.write("b.rhai", script("t < 0.35"));
    let said = stderr(&bench.run(render).code(1));
    has(&said, &["4 of 7 frames cannot be made (0, 1, 2, 3)", "3 of 7 frames are finished"]);
    let said = stderr(&bench.run(&render.replace("0-6", "0-8")).code(1));
    has(&said, &["4 of 9 frames cannot be made", "5 of 9 frames are finished"]);
    bench.write("b.rhai", script("t > 9.0"));
    has(&stderr(&bench.run(render).success()), &["7 frames in"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_finished_frames_and_says_how_to_go_on() {
    let bench = rock();
    let run = bench.start("render a.rhai --frames 1-500 --size 64x48 --samples 4");
    run.wait_until("a frame is there", || bench.path("a.0002.png").exists());
    run.interrupt();
    let (code, said) = run.end();
    assert_eq!(code, Some(1), "{said}");
    has(&said, &["stopped;", "of 500 frames are finished", "the same command goes on"]);
    let names = bench.names();
    assert!(names.iter().all(|name| !name.starts_with('.')), "{names:?}");
    let there = frames(&bench).len();
    let all = format!("render a.rhai --frames 1-{} --size 64x48 --samples 4", there + 1);
    has(&stderr(&bench.run(&all).success()), &["1 frame in", &format!("{there} were there")]);
}

#[test]
fn processes_share_the_frames() {
    let bench = rock();
    bench.run(MANY).success();
    let expected = frames(&bench);
    expected.keys().for_each(|name| fs::remove_file(bench.path(name)).unwrap());
    let said: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..3).map(|_| scope.spawn(|| stderr(&bench.run(MANY).success()))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert_eq!(frames(&bench), expected);
    let made = |said: &String| {
        let (_, rest) = said.split_once(".png: ").unwrap();
        rest.split_once(' ').unwrap().0.parse::<usize>().unwrap()
    };
    // Claims are given back a moment after the file is there, so no frame is made twice.
    assert_eq!(said.iter().map(made).sum::<usize>(), 12, "{said:?}");
    assert!(bench.names().iter().all(|name| !name.starts_with('.')), "{:?}", bench.names());
}

#[test]
fn an_error_names_its_frame_and_a_warning_comes_once() {
    let script = "if time.at([0, 0, 0]) > 0.1 { throw \"too late\" } print(\"hello\"); sphere(1.0).translate([0, 0, 90])";
    let bench = Bench::new(&[("a.rhai", script)]);
    let run = bench.run("render a.rhai --frames 1-9 --size 32x32 --samples 1").code(1);
    let said = stderr(&run);
    has(&said, &["too late", "frame 3, at 0.12 s"]);
    assert_eq!(said.matches("does not see").count(), 1, "{said}");
    assert_eq!(support::stdout(&run), "hello\n");
    assert_eq!(frames(&bench).len(), 2);
}

// ---- video --------------------------------------------------------------------------------------

#[cfg(unix)]
mod video {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// A folder with three frames and an `ffmpeg` that does as the script says.
    fn with_ffmpeg(script: &str) -> Bench {
        let bench = rock();
        bench.run("render a.rhai --frames 7-9 --size 32x32 --samples 1").success();
        bench.write("bin/ffmpeg", format!("#!/bin/sh\n{script}\n"));
        fs::set_permissions(bench.path("bin/ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
        bench
    }

    fn run(bench: &Bench, arguments: &str, path: &str) -> assert_cmd::assert::Assert {
        bench.command(arguments).env("PATH", path).assert()
    }

    #[test]
    fn ffmpeg_is_told_what_to_do() {
        let bench = with_ffmpeg(
            "printf '%s\\n' \"$@\" >arguments; for last; do :; done; echo frame=2; echo frame=3; echo a video >\"$last\"",
        );
        let path = format!("{}:/usr/bin:/bin", bench.path("bin").display());
        let said = stderr(&run(&bench, "video a.####.png -o a.mp4 --fps 12.5", &path).success());
        has(&said, &["a.mp4: 3 frames at 12.5 a second"]);
        assert_eq!(bench.read("a.mp4"), b"a video\n");
        let text = String::from_utf8(bench.read("arguments")).unwrap();
        let words: Vec<&str> = text.lines().collect();
        let after = |option: &str| words[words.iter().position(|w| *w == option).expect(option) + 1];
        let input = words.iter().position(|w| *w == "-i").unwrap();
        for (option, value) in [
            ("-framerate", "12.5"),
            ("-start_number", "7"),
            ("-i", "a.%04d.png"),
            ("-frames:v", "3"),
            ("-c:v", "libx264"),
            ("-crf", "18"),
            ("-f", "mp4"),
        ] {
            assert_eq!(after(option), value, "{text}");
        }
        // Options of the input come before it.
        assert!(words[..input].contains(&"-framerate") && words[..input].contains(&"-start_number"));
        assert_eq!(frames(&bench).len(), 3, "the frames are kept");
        assert!(bench.names().iter().all(|name| !name.starts_with('.')), "{:?}", bench.names());
    }

    /// `ORO_FFMPEG=required` makes it an error that this machine has none.
    #[test]
    fn a_video_shows_its_frames() {
        let bench = rock();
        bench.run("render a.rhai --frames 7-9 --size 65x47 --samples 1").success();
        let made = bench.command("video a.####.png -o a.mp4 --fps 10 --quality 4").output().unwrap();
        if String::from_utf8_lossy(&made.stderr).contains("no ffmpeg on the PATH") {
            assert!(!std::env::var("ORO_FFMPEG").is_ok_and(|v| v == "required"), "there is no ffmpeg here");
            return;
        }
        assert!(made.status.success(), "{made:?}");
        let (video, back) = (bench.path("a.mp4"), bench.path("back.%d.png"));
        let mut player = std::process::Command::new("ffmpeg");
        player.args(["-v", "error", "-i"]).arg(video).arg(back);
        assert!(player.status().unwrap().success());
        for (number, frame) in ["a.0007.png", "a.0008.png", "a.0009.png"].into_iter().enumerate() {
            let read = |name: &str| image::open(bench.path(name)).unwrap().to_rgb8();
            let (shown, meant) = (read(&format!("back.{}.png", number + 1)), read(frame));
            // Its pixels go by twos.
            assert_eq!(shown.dimensions(), (66, 48));
            let apart = meant.enumerate_pixels().flat_map(|(x, y, pixel)| {
                let other = shown.get_pixel(x, y);
                (0..3).map(move |c| u64::from(pixel[c].abs_diff(other[c])))
            });
            let mean = apart.sum::<u64>() as f64 / (3 * 65 * 47) as f64;
            assert!(mean < 3.0, "{frame}: {mean}");
        }
        assert!(!bench.names().contains(&"back.4.png".into()));

        // Every fifth frame, as of a preview.
        bench.run("render a.rhai --frames 1-20:5 --size 16x16 --samples 1 -o b.##.png").success();
        let said = stderr(&bench.run("video b.##.png -o b.mkv").success());
        has(&said, &["b.mkv: 4 frames, one in 5, at 25 a second"]);
        let mut count = std::process::Command::new("ffprobe");
        count.args(
            "-v error -count_frames -show_entries stream=nb_read_frames,r_frame_rate -of csv".split(' '),
        );
        let counted = count.arg(bench.path("b.mkv")).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&counted.stdout).trim(), "stream,25/1,4");
        fs::remove_file(bench.path("b.11.png")).unwrap();
        has(&stderr(&bench.run("video b.##.png -o b.mkv").code(1)), &["frame 11 is missing"]);
    }

    #[test]
    fn an_ffmpeg_that_fails_leaves_the_earlier_video() {
        let bench = with_ffmpeg("for last; do :; done; echo half >\"$last\"; echo no such codec >&2; exit 3");
        bench.write("a.mp4", "earlier");
        let path = format!("{}:/usr/bin:/bin", bench.path("bin").display());
        let said = stderr(&run(&bench, "video a.####.png -o a.mp4", &path).code(1));
        has(&said, &["no such codec", "ffmpeg failed", "a.mp4", "untouched"]);
        assert_eq!(bench.read("a.mp4"), b"earlier");
    }

    #[test]
    fn every_frame_is_shown_as_it_is() {
        let bench = with_ffmpeg("for last; do :; done; echo frame=2; echo a video >\"$last\"");
        let path = format!("{}:/usr/bin:/bin", bench.path("bin").display());
        let fails = |pieces: &[&str]| {
            has(&stderr(&run(&bench, "video a.####.png -o a.mp4", &path).code(1)), pieces);
            assert!(!bench.names().contains(&"a.mp4".into()));
        };
        fails(&["ffmpeg took 2 of the 3 frames"]);
        let whole = bench.read("a.0008.png");
        for damaged in [&whole[..whole.len() - 20], b"", b"no picture"] {
            bench.write("a.0008.png", damaged);
            fails(&["a.0008.png is damaged, or no picture", "--frames"]);
        }
        bench.run("render a.rhai --time 0.32 --size 32x34 --samples 1 -o a.0008.png").success();
        fails(&["a.0008.png has 32 x 34 pixels", "32 x 32", "--size"]);
    }

    #[test]
    fn without_ffmpeg_there_is_a_sentence_with_the_command() {
        let bench = with_ffmpeg("exit 0");
        let said = stderr(&run(&bench, "video a.####.png -o a.mkv", "/nowhere").code(1));
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        has(
            &said,
            &["no ffmpeg on the PATH", "install it", "ffmpeg -hide_banner", "-start_number 7 -i a.%04d.png"],
        );
        has(&said, &["a.mkv"]);
        assert_eq!(frames(&bench).len(), 3);
        assert!(!bench.names().iter().any(|name| name.ends_with("mkv") || name.starts_with('.')));
    }

    #[test]
    fn a_frame_that_is_missing_is_named() {
        let bench = with_ffmpeg("exit 0");
        fs::remove_file(bench.path("a.0008.png")).unwrap();
        let said = stderr(&bench.run("video a.####.png -o a.mp4").code(1));
        has(&said, &["frame 8 is missing", "a.0008.png"]);
        has(
            &stderr(&bench.run("video b.####.png -o b.mp4").code(1)),
            &["no frames called b.####.png", "--frames"],
        );
    }

    #[test]
    fn ctrl_c_ends_ffmpeg_too() {
        // Whether it says how far it is, or nothing at all.
        for ffmpeg in ["while :; do echo frame=1; sleep 0.1; done", "sleep 60"] {
            let bench = with_ffmpeg(ffmpeg);
            let path = format!("{}:/usr/bin:/bin", bench.path("bin").display());
            let run = bench.start_with("video a.####.png -o a.mp4", &[("PATH", &path)]);
            std::thread::sleep(Duration::from_millis(1500));
            run.interrupt();
            let (code, said) = run.end();
            assert_eq!(code, Some(1), "{said}");
            has(&said, &["stopped before the video was finished"]);
            assert!(!bench.names().iter().any(|name| name.ends_with("mp4") || name.starts_with('.')));
        }
    }
}
