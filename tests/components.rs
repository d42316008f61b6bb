//! Components of solids whose components are known, or counted on a lattice.

use glam::DVec3;
use orogen::field::{Field, Stopped, Watch};
use orogen::num::Many;
use orogen::scene::Aabb;
use orogen::script::{Request, compile};
use orogen::tape::Evaluator;
use orogen::topology::flood::{Components, Label, Limits, components};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

fn field(script: &str) -> Field {
    let compiled = compile(&Request::text(script));
    let scene = compiled.scene.unwrap_or_else(|| panic!("{script}: {:?}", compiled.diagnostics));
    Field::new(&scene.graph, scene.surface.field)
}

fn within(script: &str, region: &Aabb, limits: Limits) -> Components {
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    components(field(script).tape(), region, limits, &watch).expect("nobody stops it")
}

fn found(script: &str, half: f64) -> Components {
    found_in(script, half, 1 << 20)
}

/// The same with no more cells than so many.
fn found_in(script: &str, half: f64, cells: usize) -> Components {
    let found = within(script, &Aabb::cube(half), Limits { cells, fine: 6, ..Limits::default() });
    println!(
        "{script}: {} components, {} undecided, {} cells, depth {}",
        found.list.len(),
        found.undecided.len(),
        found.cells,
        found.depth
    );
    found
}

/// The components of a solid of which all can be proven.
fn certified(script: &str, half: f64, count: usize) -> Components {
    let found = found(script, half);
    assert!(found.is_certified(), "{script}: {:?}", found.undecided.first());
    assert_eq!(found.list.len(), count, "{script}");
    found
}

fn unit(rng: &mut StdRng) -> DVec3 {
    loop {
        let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        if v.length() > 0.1 && v.length() < 1.0 {
            return v.normalize();
        }
    }
}

/// A solid sampled on a lattice over a box, and which samples are joined through their six neighbours.
struct Lattice {
    n: usize,
    min: DVec3,
    step: DVec3,
    /// What samples inside belong to; none of those outside.
    labels: Vec<Option<Label>>,
    sets: Vec<usize>,
}

impl Lattice {
    fn new(field: &Field, all: &Components, region: &Aabb, n: usize) -> Lattice {
        let step = (region.max - region.min) / n as f64;
        let mut lattice =
            Lattice { n, min: region.min, step, labels: Vec::new(), sets: (0..n * n * n).collect() };
        let plane = |field: &mut Evaluator<Many<f64, 32>>, z: usize| lattice.plane(field, all, z);
        let planes = (0..n).into_par_iter().map_init(|| Evaluator::new(field.tape().clone()), plane);
        lattice.labels = planes.collect::<Vec<_>>().concat();
        let Lattice { labels, sets, .. } = &mut lattice;
        pairs(labels, n).for_each(|(i, j)| join(sets, i, j));
        lattice
    }

    /// The labels of a plane of samples.
    fn plane(&self, field: &mut Evaluator<Many<f64, 32>>, all: &Components, z: usize) -> Vec<Option<Label>> {
        let size = self.n * self.n;
        let points: Vec<DVec3> = (z * size..(z + 1) * size).map(|i| self.point(i)).collect();
        let axis = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<f64>>();
        let mut values = vec![0.0; size];
        field.eval_all([&axis(0), &axis(1), &axis(2)], &mut values);
        points.iter().zip(values).map(|(p, value)| (value < 0.0).then(|| all.label(*p))).collect()
    }

    fn point(&self, i: usize) -> DVec3 {
        let n = self.n;
        let place = [i % n, i / n % n, i / n / n].map(|k| k as f64 + 0.5);
        self.min + self.step * DVec3::from_array(place)
    }

    /// The samples of components, by their numbers.
    fn members(&self, all: &Components) -> Vec<Vec<usize>> {
        let mut members = vec![Vec::new(); all.list.len()];
        for (i, label) in self.labels.iter().enumerate() {
            if let Some(Label::Component(number)) = label {
                members[*number].push(i);
            }
        }
        members
    }

    /// The parts that samples are in, the largest last.
    fn parts(&mut self, members: &[usize]) -> Vec<Vec<usize>> {
        let mut parts = BTreeMap::<usize, Vec<usize>>::new();
        members.iter().for_each(|&i| parts.entry(of(&mut self.sets, i)).or_default().push(i));
        let mut parts: Vec<_> = parts.into_values().collect();
        parts.sort_by_key(Vec::len);
        parts
    }

    /// Another part that a point is joined to by a path in the solid, which the lattice is too coarse to see:
    /// downhill first, then anywhere.
    fn escape(&mut self, f: &mut Field, start: usize) -> Option<usize> {
        let spacing = self.step.min_element();
        let (own, mut p) = (of(&mut self.sets, start), self.point(start));
        let mut rng = StdRng::seed_from_u64(start as u64);
        let solid = |f: &mut Field, a: DVec3, b: DVec3| {
            (0..=20).all(|t| f.value(a.lerp(b, f64::from(t) / 20.0)) < 0.0)
        };
        for k in 0..20_000 {
            let near = self.near(p);
            if let Some(&i) = near.iter().find(|&&i| self.root(i) != own && solid(f, p, self.point(i))) {
                return Some(i);
            }
            let length = [0.5, 0.1, 0.02, 0.004][k % 4] * spacing;
            let next = p + length * unit(&mut rng);
            if (k > 4000 || f.value(next) < f.value(p)) && solid(f, p, next) {
                p = next;
            }
        }
        None
    }

    /// The points inside that are closest to a place.
    fn near(&self, p: DVec3) -> Vec<usize> {
        let place = ((p - self.min) / self.step - 0.5).floor();
        let index = |k: i64| {
            let at = [k % 4, k / 4 % 4, k / 16].map(|k| k - 1);
            let at: [i64; 3] = std::array::from_fn(|axis| place[axis] as i64 + at[axis]);
            let n = self.n as i64;
            at.iter().all(|&i| (0..n).contains(&i)).then(|| ((at[2] * n + at[1]) * n + at[0]) as usize)
        };
        (0..64).filter_map(index).filter(|&i| self.labels[i].is_some()).collect()
    }

    /// The set of a point.
    fn root(&self, mut i: usize) -> usize {
        while self.sets[i] != i {
            i = self.sets[i];
        }
        i
    }

    /// Whether all points of a component are joined, by neighbours or by paths.
    fn is_one(&mut self, f: &mut Field, members: &[usize]) -> bool {
        let parts = self.parts(members);
        for part in &parts[..parts.len().saturating_sub(1)] {
            if let Some(i) = part.iter().take(5).find_map(|&start| self.escape(f, start)) {
                join(&mut self.sets, part[0], i);
            }
        }
        let left = self.parts(members);
        println!("    {} parts on a lattice, {} by paths", parts.len(), left.len());
        left.len() <= 1
    }
}

/// Neighbours that are both inside, of a lattice of so many samples along each axis.
fn pairs(labels: &[Option<Label>], n: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
    let beside = move |i: usize| {
        let steps = [1, n, n * n].into_iter().filter(move |step| i / step % n + 1 < n);
        steps.map(move |step| (i, i + step))
    };
    let is_inside = |i: usize| labels[i].is_some();
    (0..labels.len()).filter(move |i| is_inside(*i)).flat_map(beside).filter(move |(_, j)| is_inside(*j))
}

fn of(sets: &mut [usize], mut i: usize) -> usize {
    while sets[i] != i {
        sets[i] = sets[sets[i]];
        i = sets[i];
    }
    i
}

fn join(sets: &mut [usize], i: usize, j: usize) {
    let (a, b) = (of(sets, i), of(sets, j));
    sets[a.max(b)] = a.min(b);
}

/// Compares labels with a lattice. Where they differ, the lattice is shown to be too coarse.
fn compare(script: &str, half: f64, found: &Components, n: usize) {
    let mut f = field(script);
    let mut lattice = Lattice::new(&f, found, &Aabb::cube(half), n);
    for (i, label) in lattice.labels.iter().enumerate() {
        let p = lattice.point(i);
        assert!(*label != Some(Label::Outside), "{script}: {p} is solid");
        if let Some(Label::Component(k)) = *label {
            let Aabb { min, max } = found.list[k].bounds;
            assert!(p.cmpge(min).all() && p.cmple(max).all(), "{script}: {p} is beyond its component");
        }
    }
    // What are two components here must not be joined: there is a gap between the samples.
    for (i, j) in pairs(&lattice.labels, n) {
        if let (Some(Label::Component(k)), Some(Label::Component(l))) = (lattice.labels[i], lattice.labels[j])
            && k != l
        {
            let (a, b) = (lattice.point(i), lattice.point(j));
            let gap = (0..=5000).any(|t| f.value(a.lerp(b, f64::from(t) / 5000.0)) >= 0.0);
            assert!(
                gap || !found.list[k].certified && !found.list[l].certified,
                "{script}: {a} {b} are joined"
            );
        }
    }
    // What is one here must not be two: on a finer lattice it is one, but for crests too thin for any lattice.
    let members = lattice.members(found);
    for (k, component) in found.list.iter().enumerate().filter(|(_, c)| c.certified) {
        if lattice.parts(&members[k]).len() > 1 {
            let is_one = [48, 96, 220].into_iter().any(|m| {
                let mut fine = Lattice::new(&f, found, &component.bounds, m);
                let members = std::mem::take(&mut fine.members(found)[k]);
                fine.is_one(&mut f, &members)
            });
            assert!(is_one, "{script}: component {k} is in parts");
        }
    }
}

#[test]
fn shapes() {
    let ball = certified("sphere(1.0)", 1.5, 1);
    let volume = 4.0 / 3.0 * std::f64::consts::PI;
    assert!(ball.list[0].volume.contains(volume) && !ball.list[0].cut, "{:?}", ball.list[0]);
    assert!((ball.list[0].about - volume).abs() < 1e-3 * volume, "{:?}", ball.list[0]);
    for (script, half, count) in [
        ("torus(1.0, 0.4)", 1.6, 1),
        ("box([2, 1, 0.5]).rotate([1, 2, 3], 40)", 1.5, 1),
        ("union(sphere(1.0), sphere(0.5).translate([2, 0, 0]))", 3.0, 2),
        ("union(box(1.0), box(1.0).translate([0.9, 0.9, 0.9]))", 2.0, 1),
        ("difference(box(2.0), cylinder(0.5, 3.0))", 1.6, 1),
        ("difference(sphere(1.0), abs(y - 0.1) - 0.01)", 1.5, 2),
        ("max(box(2.0), -sphere(0.3))", 1.5, 1),
        ("union(torus(1.0, 0.2), torus(1.0, 0.2).rotate([1, 0, 0], 90).translate([1, 0, 0]))", 2.5, 2),
    ] {
        let found = certified(script, half, count);
        compare(script, half, &found, 40);
    }
}

/// Solids at whose rims all ways down lead up the side again, and on whose sides the way along an axis leads back.
#[test]
fn rims() {
    for (script, half) in [
        ("max(max(abs(x), abs(z)) + 0.7 * y - 0.5, -y - 0.4)", 1.5),
        ("max(sqrt(x * x + z * z) + 0.5 * y - 0.4, -y - 0.6)", 1.5),
        ("max(max(0.3 - x, -y), max(-z, x + y + z - 1.0))", 1.5),
        (
            "mesh_of([[0, 0, 0], [1.1, 0.1, 0.2], [0.2, 0.9, 0.1], [0.1, 0.2, 1.2]],
                     [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])",
            1.5,
        ),
        ("import \"std/shapes\" as shapes; shapes::pyramid(3, 1.0, 1.2)", 1.5),
    ] {
        let found = certified(script, half, 1);
        compare(script, half, &found, 40);
    }
}

/// Creases of cones: no axis leads down in all of a cell, but all gradients are within the noise's bound of one direction.
#[test]
fn cells_of_noise() {
    let script = "sphere(1.0) - 0.3 * cellular(3).scaled(3.0)";
    let found = certified(script, 1.5, 1);
    compare(script, 1.5, &found, 40);
}

/// A hollow shell with a ball in it.
#[test]
fn shells() {
    let script = "union(shell(sphere(1.0), 0.05), sphere(0.4).translate([0.2, 0, 0]))";
    let found = certified(script, 1.5, 2);
    assert_eq!(found.label(DVec3::new(0.2, 0.0, 0.0)), Label::Component(1));
    assert_eq!(found.label(DVec3::new(0.0, 1.0, 0.0)), Label::Component(0));
    assert_eq!(found.label(DVec3::new(0.0, 0.7, 0.0)), Label::Outside);
    assert_eq!(found.label(DVec3::new(1.6, 0.0, 0.0)), Label::Undecided);
    compare(script, 1.5, &found, 60);
}

/// Two blobs that come apart: the saddle between them is at the origin, where the field is `level - 2 exp(-1)`.
#[test]
fn necks() {
    let blobs = |level: f64| {
        format!(
            "{level:?} - exp(-((x - 1.0) * (x - 1.0) + y * y + z * z)) - exp(-((x + 1.0) * (x + 1.0) + y * y + z * z))"
        )
    };
    let saddle = 2.0 * libm::exp(-1.0);
    for off in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
        let joined = certified(&blobs(saddle - off), 3.0, 1);
        assert_eq!(joined.label(DVec3::ZERO), Label::Component(0));
        certified(&blobs(saddle + off), 3.0, 2);
    }
    // At the very saddle nothing can be known, and that is said, and where.
    let touching =
        within(&blobs(saddle), &Aabb::cube(3.0), Limits { cells: 1 << 18, depth: 12, least: 4, fine: 0 });
    assert!(touching.list.iter().all(|c| !c.certified) && !touching.undecided.is_empty());
    assert!(touching.undecided.iter().all(|cell| cell.max.length() < 0.1), "{:?}", touching.undecided[0]);
    assert_ne!(touching.label(DVec3::X), touching.label(-DVec3::Y * 2.0));
}

/// Where two parts touch in a point nothing helps, and that is known soon: there is one place, and not much work.
#[test]
fn contact_is_one_place() {
    let found =
        within("min(sphere(1.0), sphere(0.5).translate([1.5, 0, 0]))", &Aabb::cube(2.1), Limits::default());
    assert!(found.list.len() == 2 && found.list.iter().all(|c| !c.certified), "{:?}", found.list);
    assert!(found.cells < 200_000, "{} cells", found.cells);
    let contact = DVec3::X;
    let holds = |place: &Aabb| place.min.cmple(contact).all() && place.max.cmpge(contact).all();
    assert!(found.undecided.len() < 10 && found.undecided.iter().any(holds), "{:?}", found.undecided);
    assert!(found.undecided.iter().all(|place| place.diagonal() < 0.6), "{:?}", found.undecided);
}

#[test]
fn thin_bridges() {
    let bridge = |radius: f64, length: f64| {
        format!(
            "union(union(sphere(0.5).translate([-1, 0.1, 0]), sphere(0.5).translate([1, 0, 0.1])), \
             capsule([-{length:?}, 0.03, 0.02], [{length:?}, 0.03, 0.02], {radius:?}))"
        )
    };
    let found = certified(&bridge(5e-4, 0.8), 2.0, 1);
    assert_eq!(found.label(DVec3::new(0.0, 0.03, 0.02)), Label::Component(0));
    // One that does not get there.
    certified(&bridge(5e-4, 0.3), 2.0, 3);
}

/// The region may cut a solid open; then it says so, and what is joined beyond it counts as parted.
#[test]
fn regions_cut() {
    let torus = "torus(1.0, 0.2)";
    let half = Aabb { min: DVec3::new(0.3, -2.0, -2.0), max: DVec3::new(2.0, 2.0, 2.0) };
    let found = within(torus, &half, Limits::default());
    assert!(found.is_certified() && found.list.len() == 1 && found.list[0].cut, "{:?}", found.list);
    let slab = Aabb { min: DVec3::new(-2.0, -2.0, -0.5), max: DVec3::new(2.0, 2.0, 0.5) };
    let found = within(torus, &slab, Limits::default());
    assert!(found.is_certified() && found.list.len() == 2 && found.list.iter().all(|c| c.cut));
    // A solid that reaches over an edge and a corner, and one that only just does.
    let corner = "sphere(0.5).translate([1, 1, 1])";
    let found = within(corner, &Aabb::cube(0.9), Limits::default());
    assert!(found.is_certified() && found.list.len() == 1, "{:?}", found.list);
    let found = within(
        "sphere(1.0)",
        &Aabb { min: DVec3::new(0.999, -2.0, -2.0), max: DVec3::splat(2.0) },
        Limits::default(),
    );
    assert!(found.is_certified() && found.list.len() == 1, "{:?}", found.list);
    // One that ends right before it.
    let found = within("box(1.0)", &Aabb::cube(0.503), Limits::default());
    assert!(found.is_certified() && found.list.len() == 1 && !found.list[0].cut, "{:?}", found.list);
    let nothing =
        within("sphere(0.5)", &Aabb { min: DVec3::splat(1.0), max: DVec3::splat(2.0) }, Limits::default());
    assert!(nothing.is_certified() && nothing.list.is_empty());
    let all = within("x - 10", &Aabb::cube(1.0), Limits::default());
    assert!(all.is_certified() && all.list.len() == 1 && all.list[0].volume.contains(8.0));
}

#[test]
fn rough_solids() {
    let mut rng = StdRng::seed_from_u64(8);
    let mut script = |seed: u32| {
        let amplitude = rng.random_range(0.3..0.9);
        match seed % 5 {
            0 => format!("sphere(1.0) + {amplitude:.3} * (2.0 * abs(gradient({seed}).scaled(2.0)) - 0.5)"),
            1 => format!("sphere(1.0) + {amplitude:.3} * (0.5 - 2.0 * abs(gradient({seed}).scaled(2.0)))"),
            2 => format!("max(box(1.5), 0.3 - cellular({seed}).scaled(2.0))"),
            3 => format!("sphere(1.0) + {amplitude:.3} * (cellular({seed}).scaled(2.0) - 0.5)"),
            _ => format!("max(sphere(1.0), {amplitude:.3} * 0.4 - abs(gradient({seed}).scaled(2.0)))"),
        }
    };
    let scripts: Vec<(u32, String)> = (0..20).map(|seed| (seed, script(seed))).collect();
    let is_proven = |(seed, script): &&(u32, String)| {
        // Where faces of cells of space only just touch, no number of cells says whether they do.
        let cells = if seed % 5 == 2 { 1 << 17 } else { 1 << 19 };
        let found = found_in(script, 2.0, cells);
        compare(script, 2.0, &found, 64);
        found.is_certified()
    };
    let proven = scripts.par_iter().filter(is_proven).count();
    assert!(proven >= 10, "only {proven} of 20 are proven");
}

#[test]
fn the_same_on_any_number_of_threads() {
    let script = "sphere(1.0) + 0.8 * gradient(5).scaled(2.5)";
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| found(script, 2.0))
    };
    let (one, four) = (on(1), on(4));
    assert_eq!((&one.list, &one.undecided, one.cells), (&four.list, &four.undecided, four.cells));
}

#[test]
fn jobs_stop() {
    let watch = Watch { cancel: &AtomicBool::new(true), progress: &|_| () };
    let stopped = components(field("sphere(1.0)").tape(), &Aabb::cube(2.0), Limits::default(), &watch);
    assert_eq!(stopped.err(), Some(Stopped));
}

#[test]
fn it_is_said_if_cells_run_short() {
    // Two balls that are next to one another: to know that takes many small cells.
    let near = "min(sphere(1.0), sphere(1.0).translate([2.001, 0, 0]))";
    let with = |cells| within(near, &Aabb::cube(4.0), Limits { cells, fine: 0, ..Limits::default() });
    let (few, enough) = (with(2000), with(1 << 20));
    assert!(few.ran_short && !few.is_certified() && few.cells <= 2000, "{} cells", few.cells);
    assert!(!enough.ran_short && enough.is_certified(), "{} cells", enough.cells);
}

/// Detail that is a matter of direction alone leaves all of a solid in sight of its middle, however rough it is.
#[test]
fn planets_are_stars() {
    let ridged = "octave_sum(gradient(7), \"ridged\", #{ octaves: 9, lacunarity: 2.1, hurst: 0.9 })";
    let planets = [
        format!("sphere(1.0) - 0.02 * {ridged}.scaled(4.0).on_sphere()"),
        "sphere(1.0) - 0.1 * cellular(3).scaled(5.0).on_sphere()".to_owned(),
        "sphere(1.0) - 0.1 * octave_sum(gradient(5), \"turbulence\", #{}).scaled(2.0).on_sphere()".to_owned(),
        "union(sphere(1.0), sphere(0.99) - 0.05 * abs(gradient(2).scaled(6.0)).on_sphere())".to_owned(),
        "box([1.2, 0.9, 1.4]) + 0.02 * abs(gradient(4).scaled(3.0))".to_owned(),
    ];
    for script in &planets {
        let found = certified(script, 1.6, 1);
        assert_eq!(found.star, Some(DVec3::ZERO), "{script}");
        assert!(!found.list[0].cut && found.cells < 1 << 16, "{script}: {} cells", found.cells);
        compare(script, 1.6, &found, 48);
    }
    // Elsewhere than around the origin, and cut by the region.
    let region = Aabb { min: DVec3::new(1.5, 0.0, 0.0), max: DVec3::new(4.5, 2.5, 1.0) };
    let found = within("sphere(1.2).translate([3, 1, 0])", &region, Limits::default());
    assert_eq!(found.star, Some(DVec3::new(3.0, 1.25, 0.5)));
    assert!(found.is_certified() && found.list[0].cut);
}

#[test]
fn what_hides_something_is_no_star() {
    let others = [
        "torus(1.0, 0.2)",
        "max(sphere(1.0), -sphere(0.3))",
        "min(sphere(0.5), sphere(0.3).translate([1.2, 0, 0]))",
        "min(sphere(1.0), sphere(0.5).translate([1.5, 0, 0]))",
        // A mushroom, and a dent that is wider below.
        "min(sphere(0.5), min(capsule([0, 0, 0], [0, 1, 0], 0.1), box([1.2, 0.1, 1.2]).translate([0, 1, 0])))",
        "max(sphere(1.0), -min(capsule([0, 1.2, 0], [0, 0.7, 0], 0.08), sphere(0.2).translate([0, 0.6, 0])))",
        "length(p - vec3(1.0, 0.0, 0.0)) - 0.5",
    ];
    for script in others {
        let found = found(script, 2.0);
        assert!(found.star.is_none(), "{script}");
    }
}

/// Where a solid is said to be a star every ray from there leaves it once.
#[test]
fn rays_from_the_heart_of_a_star_leave_it_once() {
    let mut rng = StdRng::seed_from_u64(23);
    let script = |seed: u32| {
        let (amplitude, scale) = (rng.random_range(0.02..0.5), rng.random_range(1.0..4.0));
        let noise = ["gradient", "simplex", "cellular", "value"][seed as usize % 4];
        let fold = if seed.is_multiple_of(3) { "abs" } else { "" };
        format!("sphere(1.0) + {amplitude:.3} * {fold}({noise}({seed}).scaled({scale:.3}))")
    };
    let scripts: Vec<String> = (0..32).map(script).collect();
    let ways: Vec<DVec3> = (0..400).map(|_| unit(&mut rng)).collect();
    let is_star = |script: &&String| {
        let found = within(script, &Aabb::cube(2.0), Limits { cells: 1 << 18, fine: 0, ..Limits::default() });
        let Some(heart) = found.star else { return false };
        let field = field(script);
        let mut value = Evaluator::<f64>::new(field.tape().clone());
        for way in &ways {
            let solid: Vec<bool> = (0..300)
                .map(|i| *value.eval(&(heart + 0.007 * f64::from(i) * *way).to_array()) < 0.0)
                .collect();
            let leaves = solid.windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert!(solid[0] && leaves == 1, "{script}: {way}");
        }
        true
    };
    let stars = scripts.par_iter().filter(is_star).count();
    assert!((8..28).contains(&stars), "{stars} of 32 are stars");
}
