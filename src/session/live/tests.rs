//! Pictures that follow wishes and saves.

use super::*;
use crate::render::Rect;
use crate::scene::Value;
use crate::world::World;
use std::collections::BTreeMap;
use std::io;
use std::sync::mpsc::{Receiver, channel};

/// Files in memory that change.
#[derive(Default)]
struct Changing(Mutex<BTreeMap<PathBuf, String>>);

impl World for Changing {
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        let files = self.0.lock().unwrap();
        files.get(path).map(|text| Arc::from(text.as_bytes())).ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}

const BALL: &str = "let r = param(\"radius\", 0.5, 0.1..1.5); let n = param(\"count\", 2, 1..9);
    scene(#{ surface: sphere(r * (1.0 + 0.0 * time)), film: film(#{ width: 64, height: 48, samples: 1 }) })";

/// A live picture and what is heard of it.
struct Bench {
    live: Live,
    world: Arc<Changing>,
    heard: Receiver<Event>,
}

impl Bench {
    fn new(script: &str) -> Bench {
        Bench::with(script, BTreeMap::new())
    }

    fn with(script: &str, set: BTreeMap<String, Value>) -> Bench {
        let world = Arc::new(Changing::default());
        world.0.lock().unwrap().insert("a.rhai".into(), script.into());
        let mut session = Session::new("a.rhai", world.clone());
        session.set(set, 0.0);
        let (sender, heard) = channel();
        let live = Live::new(session, Order::default(), move |event| sender.send(event).unwrap_or_default());
        let bench = Bench { live, world, heard };
        bench.wait(|report| matches!(report.stage, Stage::Done | Stage::Failed));
        bench
    }

    /// Waits for a report.
    fn wait(&self, wanted: impl Fn(&Report) -> bool) -> Arc<Report> {
        loop {
            let report = self.live.report();
            if wanted(&report) {
                return report;
            }
            self.heard.recv_timeout(Duration::from_secs(60)).expect("something happens");
        }
    }

    fn save(&self, script: &str) {
        self.world.0.lock().unwrap().insert("a.rhai".into(), script.into());
        self.live.saved();
    }

    fn command(&self, json: &str) {
        self.live.command(&serde_json::from_str(json).unwrap()).unwrap();
    }

    /// Waits for the full picture of the last wish, and gives the share of it that the ball takes.
    fn share(&self) -> f64 {
        let done = |live: &Live| {
            let state = live.shared.state();
            state.finished.is_some() && state.running.is_none() && !state.saved
        };
        while !done(&self.live) {
            // The end of the work is told before it is over.
            let _ = self.heard.recv_timeout(Duration::from_millis(20));
        }
        let picture = self.live.finished().unwrap().picture;
        let hits = picture.pixels.iter().filter(|p| p.depth.is_finite()).count();
        hits as f64 / picture.pixels.len() as f64
    }
}

#[test]
fn wishes_outlive_saves() {
    let bench = Bench::new(BALL);
    let small = bench.share();
    bench.command(r#"{"set":{"radius":1.0}}"#);
    bench.wait(|report| report.stage == Stage::Done && report.params[0].value == 1.0.into());
    let large = bench.share();
    assert!(large > 2.0 * small, "{small} {large}");
    bench.command(r#"{"move":{"zoom":{"by":0.5,"at":null}}}"#);
    let steered = bench.wait(|report| report.steered && report.stage == Stage::Done);
    bench.save(&BALL.replace("0.0 * time", "0.00 * time"));
    let after = bench.wait(|report| report.revision == 2 && report.stage == Stage::Done);
    assert_eq!(
        (after.camera.clone(), after.params.clone()),
        (steered.camera.clone(), steered.params.clone())
    );
    bench.command("\"snap_back\"");
    bench.command(r#"{"reset":null}"#);
    bench.wait(|report| {
        !report.steered && report.stage == Stage::Done && report.params[0].value == 0.5.into()
    });
    assert_eq!(bench.share(), small);
}

#[test]
fn values_are_written_where_their_parameters_are_made_or_preset() {
    let folder = tempfile::tempdir().unwrap();
    let [main, module] = ["a.rhai", "rock.rhai"].map(|name| folder.path().join(name));
    let text = "import \"rock\" as rock;\nlet r = param(\"r\", rock::size, 0.0..1.0);\n\
        scene(#{ surface: sphere(r), film: film(#{ width: 8, height: 6, samples: 1 }) })";
    let rock = "export let size = param(\"size\", 0.5, 0.0..1.0);\n";
    std::fs::write(&main, text).unwrap();
    std::fs::write(&module, rock).unwrap();
    let session = Session::new(&main, Arc::new(crate::world::Disk));
    let (sender, heard) = channel();
    let live = Live::new(session, Order::default(), move |event| sender.send(event).unwrap_or_default());
    let settled = |wanted: &dyn Fn(&Report) -> bool| {
        while !(live.report().stage == Stage::Done && wanted(&live.report())) {
            heard.recv_timeout(Duration::from_secs(60)).expect("something happens");
        }
    };
    settled(&|_| true);
    let read = || [&main, &module].map(|path| std::fs::read_to_string(path).unwrap());
    for (r, presets) in [(0.25, "preset(\"r\", 0.25);\n"), (0.75, "preset(\"r\", 0.75);\n")] {
        let size = r / 2.0;
        let command = format!("{{\"set\":{{\"r\":{r},\"size\":{size}}}}}");
        live.command(&serde_json::from_str(&command).unwrap()).unwrap();
        let values = || [size.into(), r.into()];
        settled(&|report| report.params.iter().map(|p| p.value.clone()).eq(values()));
        assert_eq!(live.write_defaults().unwrap().len(), 2);
        assert_eq!(read(), [format!("{presets}{text}"), rock.replace("0.5", &size.to_string())]);
        settled(&|report| report.params.iter().map(|p| p.default.clone()).eq(values()));
    }
}

#[test]
fn parameters_that_are_gone_are_forgotten() {
    let bench = Bench::new(BALL);
    bench.command(r#"{"set":{"radius":1.2,"count":7.4}}"#);
    let report = bench.wait(|report| report.params[0].value == 1.2.into());
    assert_eq!(report.params[1].value, 7.0.into());
    bench.save(&BALL.replace("0.1..1.5", "0.1..1.0").replace("count", "number"));
    let report = bench.wait(|report| report.revision == 2);
    assert!(report.messages.is_empty(), "{:?}", report.messages);
    assert_eq!(report.params.iter().map(|p| p.value.clone()).collect::<Vec<_>>(), [0.5.into(), 2.0.into()]);
}

/// What cannot be set is left out, and not in silence.
#[test]
fn what_is_set_in_vain_is_said() {
    for (name, value, message) in
        [("nope", 1.0, "no parameter `nope`"), ("radius", 9.0, "`radius` is set to 9")]
    {
        let set = [(name, value), ("count", 3.0)].map(|(name, value)| (name.to_owned(), value.into()));
        let bench = Bench::with(BALL, set.into());
        let report = bench.wait(|report| report.stage == Stage::Done);
        let said = serde_json::to_string(&report.messages).unwrap();
        assert!(said.contains(message), "{said}");
        let values: Vec<Value> = report.params.iter().map(|p| p.value.clone()).collect();
        assert_eq!(values, [0.5.into(), 3.0.into()]);
    }
}

/// A ball, or a smaller one, perhaps.
const PICKED: &str = "let size = param(\"size\", \"large\", [\"large\", \"small\", \"7\"]);
    let there = param(\"there\", true); let tint = param(\"tint\", \"#fff\");
    let r = switch size { \"large\" => 1.0, \"small\" => 0.5, _ => 0.7 };
    scene(#{ surface: sphere(if there { r } else { 0.1 }).colored(tint), film: film(#{ width: 64, height: 48, samples: 1 }) })";

#[test]
fn names_colors_and_switches_follow_wishes() {
    let bench = Bench::new(PICKED);
    let large = bench.share();
    let values = |report: &Report| report.params.iter().map(|p| p.value.to_string()).collect::<Vec<_>>();
    assert_eq!(values(&bench.live.report()), ["large", "true", "#ffffff"]);
    bench.command(r##"{"set":{"size":"small","tint":"#C98f5a"}}"##);
    let report = bench.wait(|report| report.stage == Stage::Done && values(report)[0] == "small");
    assert_eq!(values(&report), ["small", "true", "#c98f5a"]);
    let small = bench.share();
    bench.command(r#"{"set":{"there":false}}"#);
    bench.wait(|report| report.stage == Stage::Done && values(report)[1] == "false");
    let tiny = bench.share();
    assert!(tiny < 0.5 * small && small < 0.5 * large, "{tiny} {small} {large}");
    // What is set stays as long as it is one of the names.
    bench.command(r#"{"set":{"there":true,"size":"7"}}"#);
    bench.wait(|report| report.stage == Stage::Done && values(report)[0] == "7");
    bench.save(&PICKED.replace(", \"7\"", ", \"8\""));
    let report = bench.wait(|report| report.revision == 2 && report.stage == Stage::Done);
    assert_eq!(values(&report), ["large", "true", "#c98f5a"]);
    bench.command(r#"{"reset":["tint"]}"#);
    bench.wait(|report| values(report)[2] == "#ffffff");
    for (command, why) in [
        (r#"{"set":{"size":"smal"}}"#, "`size` is set to smal, which is none of its names"),
        (r#"{"set":{"there":"no"}}"#, "`there` is set to no, which is neither on nor off"),
        (r#"{"set":{"tint":0.5}}"#, "`tint` is set to 0.5, which is not a colour"),
    ] {
        let refused = bench.live.command(&serde_json::from_str(command).unwrap()).unwrap_err();
        assert_eq!(refused.to_string(), why);
    }
}

#[test]
fn errors_leave_the_picture_and_name_the_line() {
    let bench = Bench::new(BALL);
    let share = bench.share();
    bench.save("sphere(1.0)\n + nothing");
    let report = bench.wait(|report| report.stage == Stage::Failed);
    let message = serde_json::to_value(&report.messages[0]).unwrap();
    assert_eq!((&message["line"], &message["text"]), (&2.into(), &" + nothing".into()));
    assert!(bench.live.canvas().since(0).blocks.len() == 4);
    assert_eq!(bench.share(), share);
    // It can be looked at from elsewhere, and saved, and another mistake does not draw it anew.
    bench.command(r#"{"move":{"zoom":{"by":0.5,"at":null}}}"#);
    let report = bench.wait(|report| report.steered);
    assert_eq!((report.stage, report.messages.len()), (Stage::Failed, 1));
    let nearer = bench.share();
    assert!(nearer > 1.5 * share, "{share} {nearer}");
    let before = bench.live.finished().unwrap().picture;
    bench.save("sphere(1.0)\n + no");
    bench.wait(|report| serde_json::to_string(&report.messages).unwrap().contains("`no`"));
    assert_eq!(bench.share(), nearer);
    assert!(Arc::ptr_eq(&before, &bench.live.finished().unwrap().picture));
    // Time does not pass meanwhile, and stops no picture.
    bench.command(r#"{"play":true}"#);
    bench.command("\"snap_back\"");
    let report = bench.wait(|report| !report.steered && report.playing);
    assert_eq!((report.stage, bench.share()), (Stage::Failed, share));
    bench.command(r#"{"play":false}"#);
    bench.save(BALL);
    bench.wait(|report| report.stage == Stage::Done);
    assert_eq!(bench.share(), share);
}

#[test]
fn a_region_does_not_start_over() {
    let bench = Bench::new(BALL);
    let before = bench.share();
    bench.command(r#"{"region":[8,8,16,16]}"#);
    let report = bench.live.report();
    assert_eq!((report.region, report.stage), (Some([8, 8, 16, 16]), Stage::Done));
    bench.command(r#"{"layer":"normals"}"#);
    bench.wait(|report| report.stage == Stage::Done && report.layer == crate::render::Layer::Normals);
    assert_eq!(bench.share(), before);
    let canvas = bench.live.canvas();
    let mut bytes = Vec::new();
    canvas.pack(&Rect { x: 32, y: 24, width: 1, height: 1 }, &mut bytes);
    // The middle of the ball faces the camera, which stands to the right of and above it.
    assert!(bytes[10..].iter().all(|b| *b > 127), "{bytes:?}");
}

#[test]
fn time_passes_while_it_plays() {
    let bench = Bench::new(BALL);
    bench.command(r#"{"play":true}"#);
    let report = bench.wait(|report| report.time > 0.05);
    assert!(report.playing);
    bench.command(r#"{"play":false}"#);
    let report = bench.wait(|report| !report.playing && report.stage == Stage::Done);
    assert!(report.time >= 0.05);
}

#[test]
fn refusals_say_why() {
    let bench = Bench::new(BALL);
    for (command, why) in [
        (r#"{"set":{"radios":1.0}}"#, "there is no parameter `radios`"),
        (r#"{"caster":"net"}"#, "there is no caster `net`"),
        (r#"{"move":{"zoom":{"by":-1.0,"at":null}}}"#, "a movement is not a number that makes sense there"),
    ] {
        let refused = bench.live.command(&serde_json::from_str(command).unwrap()).unwrap_err();
        assert_eq!(refused.to_string(), why);
    }
}
