//! Components of solids whose components are known, or counted on a lattice.

use glam::DVec3;
use orogen::field::{Field, Stopped, Watch};
use orogen::scene::Aabb;
use orogen::script::{Request, compile};
use orogen::topology::flood::{Components, Label, Limits, components};
use rand::{RngExt, SeedableRng, rngs::StdRng};
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
    let found = within(script, &Aabb::cube(half), Limits { cells: 1 << 20, ..Limits::default() });
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
    points: Vec<DVec3>,
    inside: Vec<bool>,
    sets: Vec<usize>,
    n: usize,
    min: DVec3,
    step: DVec3,
}

impl Lattice {
    fn new(field: &mut Field, region: &Aabb, n: usize) -> Lattice {
        let place = |i: usize| {
            let share = [i % n, i / n % n, i / n / n].map(|k| (k as f64 + 0.5) / n as f64);
            region.min + (region.max - region.min) * DVec3::from_array(share)
        };
        let points: Vec<DVec3> = (0..n * n * n).map(place).collect();
        let inside: Vec<bool> = points.iter().map(|&p| field.value(p) < 0.0).collect();
        let mut lattice = Lattice {
            sets: (0..points.len()).collect(),
            points,
            inside,
            n,
            min: region.min,
            step: (region.max - region.min) / n as f64,
        };
        for (i, j) in lattice.pairs() {
            let (a, b) = (lattice.of(i), lattice.of(j));
            lattice.sets[a.max(b)] = a.min(b);
        }
        lattice
    }

    /// Neighbours that are both inside.
    fn pairs(&self) -> Vec<(usize, usize)> {
        let n = self.n;
        let steps = [(1, 1), (n, n), (n * n, n * n)];
        (0..n * n * n)
            .flat_map(|i| steps.map(|(step, stride)| (i, step, stride)))
            .filter(|&(i, step, stride)| i / stride % n + 1 < n && self.inside[i] && self.inside[i + step])
            .map(|(i, step, _)| (i, i + step))
            .collect()
    }

    fn of(&mut self, mut i: usize) -> usize {
        while self.sets[i] != i {
            self.sets[i] = self.sets[self.sets[i]];
            i = self.sets[i];
        }
        i
    }

    /// The parts in which the lattice has the points of a component, the largest last.
    fn parts(&mut self, all: &Components, number: usize) -> Vec<Vec<usize>> {
        let mut parts = std::collections::BTreeMap::<usize, Vec<usize>>::new();
        for i in 0..self.points.len() {
            if self.inside[i] && all.label(self.points[i]) == Label::Component(number) {
                parts.entry(self.of(i)).or_default().push(i);
            }
        }
        let mut parts: Vec<_> = parts.into_values().collect();
        parts.sort_by_key(Vec::len);
        parts
    }

    /// Another part that a point is joined to by a path in the solid, which the lattice is too coarse to see:
    /// downhill first, then anywhere.
    fn escape(&mut self, f: &mut Field, start: usize) -> Option<usize> {
        let spacing = self.step.min_element();
        let (own, mut p) = (self.of(start), self.points[start]);
        let mut rng = StdRng::seed_from_u64(start as u64);
        let solid = |f: &mut Field, a: DVec3, b: DVec3| {
            (0..=20).all(|t| f.value(a.lerp(b, f64::from(t) / 20.0)) < 0.0)
        };
        for k in 0..20_000 {
            let near = self.near(p);
            if let Some(&i) = near.iter().find(|&&i| self.root(i) != own && solid(f, p, self.points[i])) {
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
        (0..64).filter_map(index).filter(|&i| self.inside[i]).collect()
    }

    /// The set of a point.
    fn root(&self, mut i: usize) -> usize {
        while self.sets[i] != i {
            i = self.sets[i];
        }
        i
    }

    /// Whether all points of a component are joined, by neighbours or by paths.
    fn is_one(&mut self, f: &mut Field, all: &Components, number: usize) -> bool {
        let parts = self.parts(all, number);
        for part in &parts[..parts.len().saturating_sub(1)] {
            if let Some(i) = part.iter().take(5).find_map(|&start| self.escape(f, start)) {
                let (a, b) = (self.of(part[0]), self.of(i));
                self.sets[a.max(b)] = a.min(b);
            }
        }
        let left = self.parts(all, number);
        println!("    {} parts on a lattice, {} by paths", parts.len(), left.len());
        left.len() <= 1
    }
}

/// Compares labels with a lattice. Where they differ, the lattice is shown to be too coarse.
fn compare(script: &str, half: f64, found: &Components, n: usize) {
    let mut f = field(script);
    let mut lattice = Lattice::new(&mut f, &Aabb::cube(half), n);
    for (i, &p) in lattice.points.iter().enumerate() {
        let label = found.label(p);
        assert!(!lattice.inside[i] || label != Label::Outside, "{script}: {p} is solid");
        if let (Label::Component(k), true) = (label, lattice.inside[i]) {
            let Aabb { min, max } = found.list[k].bounds;
            assert!(p.cmpge(min).all() && p.cmple(max).all(), "{script}: {p} is beyond its component");
        }
    }
    // What are two components here must not be joined: there is a gap between the samples.
    for (i, j) in lattice.pairs() {
        let (a, b) = (lattice.points[i], lattice.points[j]);
        if let (Label::Component(k), Label::Component(l)) = (found.label(a), found.label(b))
            && k != l
        {
            let gap = (0..=5000).any(|t| f.value(a.lerp(b, f64::from(t) / 5000.0)) >= 0.0);
            assert!(
                gap || !found.list[k].certified && !found.list[l].certified,
                "{script}: {a} {b} are joined"
            );
        }
    }
    // What is one here must not be two: on a finer lattice it is one, but for crests too thin for any lattice.
    for (k, component) in found.list.iter().enumerate().filter(|(_, c)| c.certified) {
        if lattice.parts(found, k).len() > 1 {
            let Aabb { min, max } = component.bounds;
            let is_one = [48, 96, 220]
                .into_iter()
                .any(|m| Lattice::new(&mut f, &Aabb { min, max }, m).is_one(&mut f, found, k));
            assert!(is_one, "{script}: component {k} is in parts");
        }
    }
}

#[test]
fn shapes() {
    let ball = certified("sphere(1.0)", 1.5, 1);
    let volume = 4.0 / 3.0 * std::f64::consts::PI;
    assert!(ball.list[0].volume.contains(volume) && !ball.list[0].cut, "{:?}", ball.list[0]);
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
    let touching = within(&blobs(saddle), &Aabb::cube(3.0), Limits { cells: 1 << 18, depth: 12, least: 4 });
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
    let mut proven = 0;
    for seed in 0..30 {
        let amplitude = rng.random_range(0.3..0.9);
        let script = match seed % 5 {
            0 => format!("sphere(1.0) + {amplitude:.3} * (2.0 * abs(gradient({seed}).scaled(2.0)) - 0.5)"),
            1 => format!("sphere(1.0) + {amplitude:.3} * (0.5 - 2.0 * abs(gradient({seed}).scaled(2.0)))"),
            2 => format!("max(box(1.5), 0.3 - cellular({seed}).scaled(2.0))"),
            3 => format!("sphere(1.0) + {amplitude:.3} * (cellular({seed}).scaled(2.0) - 0.5)"),
            _ => format!("max(sphere(1.0), {amplitude:.3} * 0.4 - abs(gradient({seed}).scaled(2.0)))"),
        };
        let found = found(&script, 2.0);
        compare(&script, 2.0, &found, 64);
        proven += usize::from(found.is_certified());
    }
    assert!(proven >= 16, "only {proven} of 30 are proven");
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
