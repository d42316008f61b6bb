//! What is joined with a point of a solid, found out place by place: beside the whole complex, where there is one, and
//! on a planet, where there is not.

use glam::DVec3;
use orogen::field::{Field, Watch};
use orogen::scene::{Aabb, Scene};
use orogen::script::{Request, compile};
use orogen::session::topology::doubts;
use orogen::session::{self, Order};
use orogen::tape::Tape;
use orogen::topology::local::{Answer, Local, LocalStats, Seeker};
use orogen::topology::{Complex, Locator, Search, search};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn scene(script: &str) -> Scene {
    let compiled = compile(&Request::text(script));
    compiled.scene.unwrap_or_else(|| panic!("{script}: {:?}", compiled.diagnostics))
}

fn tape(scene: &Scene) -> Arc<Tape> {
    Arc::new(Tape::new(&scene.graph, &[scene.surface.field]))
}

fn local(script: &str, half: f64, core: DVec3, feature: f64) -> Arc<Local> {
    let tape = tape(&scene(script));
    Arc::new(Local::new(&tape, &Aabb::cube(half), core, feature).expect("the core is inside"))
}

fn answers(local: &Arc<Local>, points: &[DVec3]) -> Vec<Answer> {
    points
        .chunks(64)
        .flat_map(|some| Seeker::new(local.clone()).answers(some, &AtomicBool::new(false)))
        .collect()
}

/// Points inside, next to the surface, on random lines in a box.
fn surface_points(script: &str, region: &Aabb, count: usize) -> Vec<DVec3> {
    let scene = scene(script);
    let mut field = Field::new(&scene.graph, scene.surface.field);
    let mut rng = StdRng::seed_from_u64(5);
    let point = |rng: &mut StdRng| {
        let p = DVec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..1.0)));
        region.min + p * (region.max - region.min)
    };
    let mut found = Vec::with_capacity(count);
    while found.len() < count {
        let (mut inside, mut outside) = (point(&mut rng), point(&mut rng));
        if !(field.value(inside) < 0.0 && field.value(outside) > 0.0) {
            continue;
        }
        for _ in 0..14 {
            let middle = 0.5 * (inside + outside);
            if field.value(middle) < 0.0 { inside = middle } else { outside = middle }
        }
        found.push(inside);
    }
    found
}

/// Surface (8.10) with gradient noise.
fn hypertexture(octaves: u32) -> String {
    format!(
        r#"import "std/fractal" as fractal;
        sphere(1.0) + 0.8 * fractal::fbm(gradient(7), #{{ octaves: {octaves}, hurst: 0.8 }}).scaled(4.0)"#
    )
}

#[test]
fn local_and_global_agree() {
    for (octaves, feature, count) in [(1, 0.25, 100_000), (2, 0.125, 2000)] {
        let (script, region) = (hypertexture(octaves), Aabb::cube(2.0));
        let points = surface_points(&script, &region, count);
        let tape = tape(&scene(&script));
        let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
        let what = Search { region, solid: true };
        let found = search(&tape, &what, &watch).expect("nobody stops it");
        let complex = Complex::new(&tape, &what, found, &watch).expect("nobody stops it");
        assert!(complex.is_certified());
        let mut locator = Locator::new(&tape, &complex);
        let main = locator.component_inside(DVec3::ZERO);
        assert_eq!(main, Some(0), "the core is in the main component");
        let global = locator.components(&points, |_| None);
        let local = local(&script, 2.0, DVec3::ZERO, feature);
        let mut apart = 0;
        for ((p, global), answer) in points.iter().zip(global).zip(answers(&local, &points)) {
            assert!(global.is_some(), "{p}");
            assert_ne!(answer, Answer::Unknown, "{octaves} octaves, {p}");
            assert_eq!(answer == Answer::Joined, global == main, "{octaves} octaves, {p}");
            apart += u32::from(answer.is_apart());
        }
        assert!(apart as usize > count / 200, "{apart} of {count} are apart");
        println!("{octaves} octaves: {apart} of {count} are apart; {:?}", local.stats());
    }
}

/// Surface (8.11).
const PLANET: &str = "let place = sparse(3).scaled(1e4).on_sphere(); \
     sphere(1.0) + 2e-4 * gradient(7).scaled(4e4) * place * place";

#[test]
fn who_asks_when_makes_no_difference() {
    // Above sea level, where crumbs float.
    let region = Aabb { min: DVec3::new(-4e-4, 1.00005, -4e-4), max: DVec3::new(4e-4, 1.0004, 4e-4) };
    let mut points = surface_points(PLANET, &region, 400);
    let first = answers(&local(PLANET, 1.001, DVec3::ZERO, 2.5e-5), &points);
    let mut numbered: Vec<(DVec3, Answer)> = points.drain(..).zip(first).collect();
    numbered.shuffle(&mut StdRng::seed_from_u64(1));
    let points: Vec<DVec3> = numbered.iter().map(|(p, _)| *p).collect();
    // Others have asked about the same places before.
    let shared = local(PLANET, 1.001, DVec3::ZERO, 2.5e-5);
    let mut answers = Vec::new();
    std::thread::scope(|scope| {
        let threads: Vec<_> = points
            .chunks(100)
            .map(|chunk| {
                let shared = shared.clone();
                scope.spawn(move || Seeker::new(shared).answers(chunk, &AtomicBool::new(false)))
            })
            .collect();
        for thread in threads {
            answers.extend(thread.join().expect("no thread panics"));
        }
    });
    let mut counts = [0; 4];
    for ((p, alone), answer) in numbered.into_iter().zip(answers) {
        assert_eq!(alone, answer, "{p}");
        counts[answer as usize] += 1;
    }
    println!("{counts:?}; {:?}", shared.stats());
    assert!(counts[Answer::Joined as usize] > 100 && counts[Answer::Parted as usize] > 10, "{counts:?}");
    assert_eq!(counts[Answer::Unknown as usize], 0);
}

#[test]
fn islands_over_a_plain() {
    let plain = "y + 0.1 * sin(3.0 * x) * cos(2.0 * z)";
    let island = |height: f64| {
        format!(
            "-ln(exp(-20.0 * ({plain})) + exp(-20.0 * (sphere(0.3).translated([0, {height:?}, 0])))) / 20.0"
        )
    };
    let ball = |script: &str, height: f64| {
        let local = local(script, 4.0, DVec3::new(0.0, -3.0, 0.0), 0.5);
        answers(&local, &[DVec3::new(0.0, height, 0.0), DVec3::new(1.0, -0.3, 1.0)])
    };
    assert_eq!(ball(&island(1.0), 1.0), [Answer::Parted, Answer::Joined]);
    assert_eq!(ball(&island(0.3), 0.3), [Answer::Joined, Answer::Joined]);
}

/// A voxel that holds far more than one feature is given up, and that is said; so is a search through too many voxels.
#[test]
fn features_of_the_wrong_size_are_noticed() {
    let (script, region) = (hypertexture(1), Aabb::cube(2.0));
    let points = surface_points(&script, &region, 40);
    let large = local(&script, 2.0, DVec3::ZERO, 8.0);
    let found = answers(&large, &points);
    let stats = large.stats();
    assert!(stats.crowded > 0 && found.contains(&Answer::Unknown), "{stats:?}");
    assert!(!found.contains(&Answer::Apart), "nothing is apart of what was not looked through");
    let hints = |stats: &LocalStats| {
        doubts(stats).iter().flat_map(|d| d.hints.clone()).collect::<Vec<_>>().join("; ")
    };
    assert!(hints(&stats).contains("larger than the features"), "{}", hints(&stats));
    // Two bars that nothing joins, each far longer than thousands of voxels.
    let bars = "-ln(exp(-40.0 * (y * y + z * z - 0.04)) + exp(-40.0 * ((y - 2.0) ** 2 + z * z - 0.04))) / 40.0 \
                + 1e-3 * sin(30.0 * x)";
    let small = local(bars, 400.0, DVec3::ZERO, 0.05);
    assert_eq!(answers(&small, &[DVec3::new(0.05, 2.0, 0.0)]), [Answer::Unknown]);
    assert!(small.stats().impatient == 1 && small.stats().crowded == 0, "{:?}", small.stats());
    assert!(hints(&small.stats()).contains("too small"), "{}", hints(&small.stats()));
    let fit = local(&script, 2.0, DVec3::ZERO, 0.25);
    answers(&fit, &points);
    assert_eq!(doubts(&fit.stats()), []);
}

/// What was broken off is not remembered.
#[test]
fn questions_can_be_broken_off() {
    let (script, region) = (hypertexture(1), Aabb::cube(2.0));
    let points = surface_points(&script, &region, 200);
    let (fresh, stopped) = [0, 1].map(|_| local(&script, 2.0, DVec3::ZERO, 0.25)).into();
    let early = Seeker::new(stopped.clone()).answers(&points, &AtomicBool::new(true));
    assert!(early.contains(&Answer::Unknown));
    assert_eq!(answers(&stopped, &points), answers(&fresh, &points));
}

#[test]
fn what_is_not_inside_has_no_component() {
    let tape = tape(&scene("sphere(1.0)"));
    assert!(Local::new(&tape, &Aabb::cube(2.0), DVec3::new(1.5, 0.0, 0.0), 0.1).is_none());
}

/// What is undefined is empty: a slab without values parts a ball.
#[test]
fn nothing_is_joined_across_what_is_undefined() {
    let script = "sphere(1.0) + 1e-3 * ln(x * x - 1e-4)";
    let local = local(script, 2.0, DVec3::new(0.2, 0.0, 0.0), 0.3);
    let mut beside = surface_points(script, &Aabb::cube(1.2), 300);
    beside.extend([0.02, 0.05, 0.3, 0.7].map(|x| DVec3::new(x, 0.01, 0.02)));
    beside.iter_mut().for_each(|p| p.x = p.x.abs());
    let across: Vec<DVec3> = beside.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect();
    let answers = |points: &[DVec3]| answers(&local, points);
    assert!(!answers(&across).contains(&Answer::Joined));
    let joined = answers(&beside).iter().filter(|answer| **answer == Answer::Joined).count();
    assert!(joined > 290, "{joined} of {} are joined", beside.len());
    assert!(!answers(&across).contains(&Answer::Joined));
}

/// A ring is cut in four by the walls of its region.
#[test]
fn nothing_is_joined_beyond_the_region() {
    let script = "pow(x * x + y * y - 1.0, 2.0) + z * z + 0.05 * (x - y) - 0.1";
    let corner = |x: f64, y: f64| DVec3::new(0.707 * x, 0.707 * y, 0.01);
    let core = corner(-1.0, 1.0);
    let points = [corner(-1.0, -1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.05, 0.98)];
    for feature in [0.3, 0.04] {
        let joined = |half: f64| {
            let answers = answers(&local(script, half, core, feature), &points);
            answers.into_iter().map(|answer| answer == Answer::Joined).collect::<Vec<bool>>()
        };
        assert_eq!(joined(1.5), [true; 4], "{feature}");
        assert_eq!(joined(0.8), [false, false, false, true], "{feature}");
    }
}

#[test]
fn neither_specks_nor_their_shadows_are_seen() {
    // The same picture of a solid with a crumb over it, found out either way, and of one that never had it.
    let whole_picture = |surface: &str| {
        let script = format!(
            "let body = sphere(1.0); let crumb = sphere(0.2).translated([0.6, 1.3, 0.5]); \
             let both = -ln(exp(-30.0 * body) + exp(-30.0 * crumb)) / 30.0; \
             scene(#{{ surface: {surface}, bounds: 2.0, film: film(#{{ width: 48, height: 48, samples: 1 }}), \
             sun: sun(#{{ azimuth: 40.0, elevation: 60.0 }}) }})"
        );
        let order = Order::default();
        let cancel = AtomicBool::new(false);
        let picture = session::render(&scene(&script), &order, &orogen::render::Job::unwatched(&cancel));
        picture.expect("it can be rendered")
    };
    let picture = |surface: &str| whole_picture(surface).pixels;
    let whole = picture("both");
    let global = picture("component_of(both, [0, 0, 0])");
    let local = picture("component_of(both, [0, 0, 0], #{ feature: 0.3 })");
    assert_eq!(global, local);
    assert_ne!(whole, local);
    // The crumb's field is felt by the body only where it is next to nothing.
    let never = picture("body");
    let apart = |i: &usize| (0..3).any(|c| (local[*i].color[c] - never[*i].color[c]).abs() > 1e-3);
    let seen = (0..local.len()).filter(apart).count();
    assert_eq!(seen, 0);
    // That the crumb is apart is proven either way.
    let uncertified = |surface: &str| whole_picture(surface).stats.uncertified();
    assert_eq!(uncertified("component_of(both, [0, 0, 0])"), uncertified("both"));
    assert_eq!(uncertified("component_of(both, [0, 0, 0], #{ feature: 0.3 })"), uncertified("both"));
}
