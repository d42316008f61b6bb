//! What is taken from a space of parameters, and what is drawn of it.

use super::*;
use crate::scene::{Domain, Param, Value};
use crate::session::Session;
use crate::world::Memory;
use std::collections::BTreeMap;
use std::sync::Arc;

mod drawing;

fn param(name: &str, default: f64, (least, most): (f64, f64), whole: bool) -> Param {
    other(name, default, Domain::Number { least, most, whole })
}

fn other(name: &str, default: impl Into<Value>, domain: Domain) -> Param {
    let default = default.into();
    Param { name: name.into(), value: default.clone(), default, domain }
}

fn choice(names: &[&str]) -> Domain {
    Domain::Choice { names: names.iter().map(|name| name.to_string()).collect() }
}

/// A colour, a name and a switch.
fn pickers() -> Space {
    let params = [
        other("tint", "#c98f5a", Domain::Color),
        other("style", "ridged", choice(&["ridged", "billow", "7"])),
        other("moons", true, Domain::Switch),
        other("only", "this", choice(&["this"])),
    ];
    Space::new(&params, &BTreeMap::new())
}

fn number(value: &Value) -> f64 {
    value.number().unwrap()
}

fn is_whole(axis: &Axis) -> bool {
    matches!(axis.domain, Domain::Number { whole: true, .. })
}

/// A fraction, a whole number, and one that goes over nine decades.
fn space() -> Space {
    let params = [
        param("relief", 0.02, (-0.1, 0.1), false),
        param("towers", 7.0, (3.0, 12.0), true),
        param("height", 2.0, (0.5, 5e8), false),
        param("fixed", 1.0, (0.0, 2.0), false),
        param("alone", 1.0, (1.0, 1.0), false),
    ];
    Space::new(&params, &BTreeMap::from([("fixed".to_owned(), 0.5.into())]))
}

fn gallery(count: usize) -> Gallery {
    Gallery::new(space(), count, 7)
}

fn starred(count: usize, ids: &[usize]) -> Gallery {
    let mut gallery = gallery(count);
    for id in ids {
        gallery.obey(Command::Star { id: *id, on: true }, &()).unwrap();
    }
    gallery
}

#[test]
fn a_space_has_what_may_vary() {
    let names: Vec<_> = space().axes.into_iter().map(|axis| axis.name).collect();
    assert_eq!(names, ["relief", "towers", "height"]);
}

#[test]
fn the_first_generation_is_the_script_and_a_sample_of_everything() {
    let gallery = gallery(200);
    assert_eq!(gallery.specimens[0].values, [0.02, 7.0, 2.0].map(Value::from));
    assert_eq!(gallery.generations[0].members, (0..200).collect::<Vec<_>>());
    for (i, axis) in space().axes.iter().enumerate() {
        let mut tenths = [0; 10];
        for specimen in &gallery.specimens {
            let value = &specimen.values[i];
            assert_eq!(axis.domain.admit(value).as_ref(), Ok(value));
            tenths[((10.0 * axis.place(value, 0.5)) as usize).min(9)] += 1;
        }
        assert!(tenths.iter().all(|n| (13..=27).contains(n)), "{}: {tenths:?}", axis.name);
    }
    // Pairs fill the square, too.
    let at = |s: &Specimen, i: usize| (5.0 * space().axes[i].place(&s.values[i], 0.5)).min(4.0) as usize;
    let cells: std::collections::BTreeSet<_> =
        gallery.specimens.iter().map(|s| (at(s, 0), at(s, 2))).collect();
    assert_eq!(cells.len(), 25);
}

#[test]
fn the_same_choices_lead_to_the_same_specimens() {
    let run = |seed: u64| {
        let mut gallery = Gallery::new(space(), 12, seed);
        for command in [
            Command::Star { id: 3, on: true },
            Command::Star { id: 8, on: true },
            Command::Breed(0.3),
            Command::More(1),
            Command::Narrow,
        ] {
            gallery.obey(command, &()).unwrap();
        }
        gallery
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1).specimens[5], run(2).specimens[5]);
    assert_eq!(run(1).generations.iter().map(|g| g.members.len()).collect::<Vec<_>>(), [12, 24, 12]);
}

#[test]
fn narrow_stays_around_the_favourites() {
    let mut gallery = starred(50, &[4, 9, 30]);
    let axes = space().axes;
    let mut widths = Vec::new();
    for _ in 0..2 {
        gallery.obey(Command::Narrow, &()).unwrap();
        let made = gallery.generations.last().unwrap();
        let mut width = 0.0_f64;
        for (i, axis) in axes.iter().enumerate() {
            let places = |ids: &[usize], within: f64| -> Vec<f64> {
                ids.iter().map(|id| axis.place(&gallery.specimens[*id].values[i], within)).collect()
            };
            let low = places(&made.from, 0.0).into_iter().fold(1.0, f64::min);
            let high = places(&made.from, 1.0).into_iter().fold(0.0, f64::max);
            let margin = 0.1 + if is_whole(axis) { 0.1 } else { 0.001 };
            for place in places(&made.members, 0.5) {
                assert!((low - margin..=high + margin).contains(&place), "{}", axis.name);
                width = width.max((low - place).max(place - high));
            }
        }
        widths.push(width);
        // The next one is around one alone.
        let last = *made.members.last().unwrap();
        gallery.obey(Command::Clear, &()).unwrap();
        gallery.obey(Command::Star { id: last, on: true }, &()).unwrap();
    }
    assert!(widths[0] > 0.0 && widths[1] < widths[0], "{widths:?}");
}

#[test]
fn children_take_after_their_parents() {
    let favourites = [2, 5, 11];
    let distance = |strength: f64| {
        let mut gallery = starred(20, &favourites);
        gallery.obey(Command::Breed(strength), &()).unwrap();
        let mut farthest = 0.0_f64;
        for id in &gallery.generations[1].members {
            let child = &gallery.specimens[*id];
            assert!(child.parents.iter().all(|p| favourites.contains(p)) && child.generation == 1);
            for (i, axis) in space().axes.iter().enumerate() {
                let off = |p: &usize| {
                    let [a, b] = [child, &gallery.specimens[*p]].map(|s| axis.place(&s.values[i], 0.5));
                    (a - b).abs()
                };
                farthest = farthest.max(child.parents.iter().map(off).fold(1.0, f64::min));
                assert!(axis.domain.admit(&child.values[i]).is_ok());
            }
        }
        farthest
    };
    assert_eq!(distance(0.0), 0.0);
    let (weak, strong) = (distance(0.1), distance(1.0));
    assert!(weak > 0.0 && weak <= 0.1 + 0.1 && strong > 0.2, "{weak} {strong}");
}

#[test]
fn every_pair_of_favourites_has_children() {
    let mut gallery = starred(20, &[2, 5, 11]);
    gallery.obey(Command::Breed(0.5), &()).unwrap();
    gallery.obey(Command::More(1), &()).unwrap();
    let pairs: std::collections::BTreeSet<_> =
        gallery.specimens[20..].iter().map(|s| s.parents.clone()).collect();
    let all = [[2, 5], [2, 11], [5, 2], [5, 11], [11, 2], [11, 5]];
    assert_eq!(pairs.into_iter().collect::<Vec<_>>(), all);
}

#[test]
fn what_makes_no_sense_is_refused_and_changes_nothing() {
    let mut gallery = gallery(6);
    let before = gallery.clone();
    for (command, refused) in [
        (Command::Narrow, Refused::NoFavourites),
        (Command::Breed(0.5), Refused::NoFavourites),
        (Command::Breed(1.5), Refused::Strength),
        (Command::Breed(f64::NAN), Refused::Strength),
        (Command::Star { id: 6, on: true }, Refused::Unknown("picture", 6)),
        (Command::More(1), Refused::Unknown("generation", 1)),
    ] {
        assert_eq!(gallery.obey(command, &()), Err(refused));
        assert_eq!(gallery, before);
    }
    gallery.obey(Command::Star { id: 2, on: true }, &()).unwrap();
    assert_eq!(gallery.obey(Command::Breed(0.0), &()), Err(Refused::NothingNew));
    assert_eq!(gallery.generations.len(), 1);
}

#[test]
fn a_gallery_ends_where_everything_is_there() {
    let three = Space::new(&[param("noise", 1.0, (1.0, 3.0), true)], &BTreeMap::new());
    let mut gallery = Gallery::new(three, 24, 0);
    let mut values: Vec<f64> = gallery.specimens.iter().map(|s| number(&s.values[0])).collect();
    values.sort_by(f64::total_cmp);
    assert_eq!(values, [1.0, 2.0, 3.0]);
    assert_eq!(gallery.obey(Command::More(0), &()), Err(Refused::NothingNew));
    let mut full = Gallery::new(space(), MOST + 1, 0);
    assert_eq!(full.specimens.len(), MOST);
    assert_eq!(full.obey(Command::More(0), &()), Err(Refused::Full));
}

#[test]
fn values_read_well() {
    let axes = space().axes;
    assert_eq!([0.0, 0.123456, 1.0].map(|p| number(&axes[0].value(p))), [-0.1, -0.07531, 0.1]);
    assert_eq!([0.0, 0.123456, 1.0].map(|p| number(&axes[1].value(p))), [3.0, 4.0, 12.0]);
    assert_eq!(axes[2].value(0.5), 15810.0.into());
    let wide = Space::new(&[param("wide", 0.0, (-1e308, 1e308), false)], &BTreeMap::new());
    assert_eq!([0.0, 0.5, 1.0].map(|p| number(&wide.axes[0].value(p))), [-1e308, 0.0, 1e308]);
    assert_eq!(wide.axes[0].place(&0.0.into(), 0.5), 0.5);
}

#[test]
fn names_and_flags_have_equal_shares_and_colors_are_near_their_neighbours() {
    let axes = pickers().axes;
    assert_eq!(axes.len(), 3);
    assert_eq!(
        [0.0, 0.5, 0.9, 1.0].map(|p| axes[1].value(p)),
        ["ridged", "billow", "7", "7"].map(Value::from)
    );
    assert_eq!([0.0, 0.49, 0.51, 1.0].map(|p| axes[2].value(p)), [false, false, true, true].map(Value::from));
    for axis in &axes {
        for i in 0..1000 {
            let value = axis.value(f64::from(i) / 1000.0);
            assert_eq!(axis.value(axis.place(&value, 0.5)), value, "{}", axis.name);
        }
    }
    // A thousandth of the line lies in two cubes beside each other at most, each an eighth as wide as that of all colours.
    let place = axes[0].place(&"#c98f5a".into(), 0.5);
    let bytes = |at: f64| crate::num::srgb::from_hex(&axes[0].value(at).to_string()).unwrap();
    for i in 0..=100 {
        let near = bytes(place + 1e-5 * f64::from(i));
        let off = bytes(place).into_iter().zip(near).map(|(a, b)| a.abs_diff(b)).max().unwrap();
        assert!(off < 64, "{near:?}");
    }
}

#[test]
fn pickers_are_sampled_and_bred_like_numbers() {
    let mut gallery = Gallery::new(pickers(), 60, 3);
    assert_eq!(gallery.specimens[0].values, ["#c98f5a".into(), "ridged".into(), Value::from(true)]);
    let with = |i: usize, value: Value| gallery.specimens.iter().filter(|s| s.values[i] == value).count();
    assert!(["ridged", "billow", "7"].iter().all(|name| (16..=24).contains(&with(1, (*name).into()))));
    assert!((26..=34).contains(&with(2, true.into())));
    for id in [4, 9] {
        gallery.obey(Command::Star { id, on: true }, &()).unwrap();
    }
    gallery.obey(Command::Breed(0.2), &()).unwrap();
    gallery.obey(Command::Narrow, &()).unwrap();
    for specimen in &gallery.specimens {
        for (axis, value) in gallery.space().axes.iter().zip(&specimen.values) {
            assert_eq!(axis.domain.admit(value).as_ref(), Ok(value));
        }
    }
}

fn of(values: &BTreeMap<String, Value>) -> Genome {
    Genome { values: values.clone(), text: None }
}

fn session(script: &str) -> Session {
    let world = Memory(BTreeMap::from([("a.rhai".into(), script.to_owned())]));
    Session::new("a.rhai", Arc::new(world))
}

fn subject(script: &str) -> Subject {
    let mut session = session(script);
    freeze(&mut session);
    let loaded = session.load(&Arc::default());
    let scene = loaded.scene.clone().unwrap_or_else(|| panic!("{:?}", loaded.diagnostics));
    Subject::new(session, loaded, scene)
}

#[test]
fn scripts_are_exported_with_their_values() {
    let subject =
        subject("let r = param(\"r\", 0.5, 0.1..1.0);\nlet n = param(\"n\", 2, 0..1 + 8);\nsphere(r / n)");
    let values = BTreeMap::from([("r".to_owned(), 0.25.into()), ("n".to_owned(), 3.0.into())]);
    let text = subject.export(&of(&values)).unwrap();
    assert_eq!(
        text,
        "let r = param(\"r\", 0.25, 0.1..1.0);\nlet n = param(\"n\", 3, 0..1 + 8);\nsphere(r / n)"
    );
    let pickers = self::subject(
        "let s = param(\"s\", \"a\", [\"a\", \"b\"]); let on = param(\"on\", true); sphere(1.0).colored(param(\"c\", \"#fff\"))",
    );
    let picked = BTreeMap::from([
        ("s".to_owned(), "b".into()),
        ("on".to_owned(), false.into()),
        ("c".to_owned(), "#000001".into()),
    ]);
    assert_eq!(
        pickers.export(&of(&picked)).unwrap(),
        "let s = param(\"s\", \"b\", [\"a\", \"b\"]); let on = param(\"on\", false); sphere(1.0).colored(param(\"c\", \"#000001\"))",
    );
    // What is made of values that have changed keeps its own.
    let computed = self::subject("let a = param(\"a\", 0.5, 0.1..1.0);\nsphere(param(\"r\", a, 0.1..1.0))");
    let one = BTreeMap::from([("a".to_owned(), 1.0.into())]);
    assert_eq!(
        computed.export(&of(&one)).unwrap(),
        "preset(\"r\", 0.5);\nlet a = param(\"a\", 1.0, 0.1..1.0);\nsphere(param(\"r\", a, 0.1..1.0))"
    );
    let untouched = computed.export(&Genome::default()).unwrap();
    assert!(!untouched.contains("preset"), "{untouched}");
}

#[test]
fn parameters_of_modules_are_exported() {
    let main = "// A rock.\n\nimport \"rock\" as rock;\nrock::of(0.5)";
    let rock = "let bumps = param(\"bumps\", 3, 1..9); let style = param(\"style\", \"a\", [\"a\", \"b\"]);\n\
        export bumps; fn of(r) { for name in [\"x\", \"y\"] { param(name, r, 0.0..1.0); } sphere(r) }";
    let told = |main: &str| {
        let files = [("a.rhai".into(), main.to_owned()), ("rock.rhai".into(), rock.to_owned())];
        let mut session = Session::new("a.rhai", Arc::new(Memory(BTreeMap::from(files))));
        freeze(&mut session);
        let loaded = session.load(&Arc::default());
        assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
        Subject::new(session, loaded.clone(), loaded.scene.clone().unwrap())
    };
    let subject = told(main);
    let values: BTreeMap<String, Value> = [("bumps", 7.0.into()), ("style", "b".into()), ("y", 0.25.into())]
        .map(|(name, value): (&str, Value)| (name.to_owned(), value))
        .into();
    let text = subject.export(&of(&values)).unwrap();
    let presets =
        "preset(\"bumps\", 7);\npreset(\"style\", \"b\");\npreset(\"x\", 0.5);\npreset(\"y\", 0.25);\n";
    assert_eq!(text, main.replace("import", &format!("{presets}import")));
    let exported = told(&text);
    for param in exported.params() {
        assert_eq!(param.value, *values.get(&param.name).unwrap_or(&0.5.into()));
    }
    assert_eq!(exported.params().len(), 4);
    // Once more, they are written where they are.
    let again = BTreeMap::from([("bumps".to_owned(), 2.0.into())]);
    assert_eq!(exported.export(&of(&again)).unwrap(), text.replace("7);", "2);"));
}

/// A ball with a lump that is cut, and noise.
const ROCK: &str = "import \"std/fractal\" as fractal;
let r = param(\"r\", 0.8, 0.5..1.0);
let bumps = 0.1 * fractal::fbm(gradient(7), #{ octaves: 3 }).scaled(3.0);
let lump = max(sphere(r), box([1.0, 1.5, 1.0])); // max(x, 2.0)
lump + bumps";

/// Favourites of a script, and their children, whose expressions may change.
fn evolved(script: &str, strength: f64, seed: u64) -> (Subject, Gallery) {
    let subject = subject(script);
    let mut gallery = Gallery::new(Space::new(subject.params(), &subject.fixed()), 6, seed);
    let (nursery, cancel) = (Nursery::default(), Arc::default());
    let nurse = Nurse { subject: &subject, nursery: &nursery, cancel: &cancel };
    for id in [1, 3] {
        gallery.obey(Command::Star { id, on: true }, &nurse).unwrap();
    }
    gallery.obey(Command::Evolve(strength), &nurse).unwrap();
    for id in [7, 9] {
        gallery.obey(Command::Star { id, on: true }, &nurse).unwrap();
    }
    gallery.obey(Command::Evolve(strength), &nurse).unwrap();
    (subject, gallery)
}

#[test]
fn expressions_change_and_every_child_is_a_script() {
    let (subject, gallery) = evolved(ROCK, 0.5, 1);
    let changed: Vec<_> = gallery.specimens.iter().filter(|s| s.text.is_some()).collect();
    assert!(changed.len() >= 8, "{}", changed.len());
    let texts: std::collections::BTreeSet<_> = changed.iter().map(|s| s.text.clone()).collect();
    assert!(texts.len() >= 6, "{}", texts.len());
    for (id, specimen) in gallery.specimens.iter().enumerate() {
        let genome = gallery.genome(id).unwrap();
        let text = subject.export(&genome).unwrap();
        let loaded = self::session(&text).load(&Arc::default());
        let scene = loaded.scene.clone().unwrap_or_else(|| panic!("{text}\n{:?}", loaded.diagnostics));
        assert_eq!(scene.params.len(), 1);
        assert_eq!(Some(&scene.params[0].value), genome.values.get("r"), "{text}");
        assert_eq!(
            (&scene.params[0].name, &scene.params[0].domain),
            (&subject.params()[0].name, &subject.params()[0].domain)
        );
        assert_eq!(specimen.text.is_some(), !specimen.changes.is_empty());
        assert!(
            text.contains("// max(x, 2.0)") && text.contains("import \"std/fractal\" as fractal;"),
            "{text}"
        );
        for change in &specimen.changes {
            assert!(change.what.contains(" → ") && change.before != change.after, "{change:?}");
        }
        if let Some(change) = specimen.changes.last() {
            let own = genome.text.as_deref().unwrap();
            assert!(
                own.lines().nth(change.line - 1).is_some_and(|l| change.after.contains(l.trim())),
                "{change:?}"
            );
        }
    }
    let longest = gallery.specimens.iter().map(|s| s.changes.len()).max();
    assert_eq!(longest, Some(2));
}

#[test]
fn the_same_choices_lead_to_the_same_expressions() {
    let texts = |seed: u64| {
        let (_, gallery) = evolved(ROCK, 0.4, seed);
        gallery.specimens.into_iter().map(|s| (s.values, s.text)).collect::<Vec<_>>()
    };
    assert_eq!(texts(3), texts(3));
    assert_ne!(texts(3), texts(4));
}

#[test]
fn without_mutation_expressions_are_only_crossed() {
    let (subject, mut gallery) = evolved(ROCK, 0.5, 2);
    let (nursery, cancel) = (Nursery::default(), Arc::default());
    let nurse = Nurse { subject: &subject, nursery: &nursery, cancel: &cancel };
    let stars: Vec<usize> = gallery.stars.iter().copied().collect();
    let before = gallery.specimens.len();
    gallery.obey(Command::Evolve(0.0), &nurse).unwrap();
    for child in &gallery.specimens[before..] {
        for (i, value) in child.values.iter().enumerate() {
            assert!(stars.iter().any(|id| gallery.specimens[*id].values[i] == *value));
        }
    }
    // Of those with the expressions of the script there is nothing to cross.
    gallery.obey(Command::Clear, &nurse).unwrap();
    for id in [1, 3] {
        gallery.obey(Command::Star { id, on: true }, &nurse).unwrap();
    }
    assert_eq!(gallery.obey(Command::Evolve(0.0), &nurse), Err(Refused::NothingNew));
    assert_eq!(gallery.obey(Command::Evolve(f64::NAN), &nurse), Err(Refused::Strength));
}

#[test]
fn an_exported_child_has_the_picture_of_its_specimen() {
    let (subject, gallery) = evolved(ROCK, 0.5, 1);
    let id = gallery.specimens.iter().position(|s| s.changes.len() == 2).unwrap();
    let order = crate::session::Order { size: Some((24, 18)), samples: Some(1), ..Default::default() };
    let draw = |subject: &Subject, genome: &Genome| {
        let png = subject.draw(genome, &order, &Arc::default()).unwrap().unwrap();
        image::load_from_memory(&png).unwrap().into_rgba8()
    };
    let genome = gallery.genome(id).unwrap();
    let exported = self::subject(&subject.export(&genome).unwrap());
    assert_eq!(draw(&subject, &genome), draw(&exported, &Genome::default()));
    assert_ne!(draw(&subject, &genome), draw(&subject, &Genome { text: None, ..genome.clone() }));
}

#[test]
fn what_nobody_waits_for_is_not_raised() {
    let subject = subject(ROCK);
    let mut gallery = Gallery::new(Space::new(subject.params(), &subject.fixed()), 6, 0);
    gallery.obey(Command::Star { id: 1, on: true }, &()).unwrap();
    let before = gallery.clone();
    let (nursery, cancel) = (Nursery::default(), Arc::new(true.into()));
    let nurse = Nurse { subject: &subject, nursery: &nursery, cancel: &cancel };
    assert_eq!(gallery.obey(Command::Evolve(0.5), &nurse), Err(Refused::GivenUp));
    assert_eq!(gallery, before);
}

#[test]
fn narrower_boxes_have_the_expressions_of_their_favourites() {
    let (subject, mut gallery) = evolved(ROCK, 0.5, 1);
    let stars: Vec<_> = gallery.stars.iter().map(|id| gallery.specimens[*id].text.clone()).collect();
    let before = gallery.specimens.len();
    gallery.obey(Command::Narrow, &()).unwrap();
    let texts: Vec<_> = gallery.specimens[before..].iter().map(|s| s.text.clone()).collect();
    assert!(stars.iter().all(|text| texts.contains(text)) && texts.iter().all(|text| stars.contains(text)));
    assert!(subject.params().len() == 1);
}
