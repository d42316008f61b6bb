//! Critical points and components of solids whose topology is known, or counted on a grid.

use glam::{DMat3, DVec3};
use orogen::cast::Ruling;
use orogen::expr::NodeId;
use orogen::field::{Extent, Field, Watch, extent};
use orogen::num::{Interval, Jet, Many, Number, Taylor, Taylors};
use orogen::render::{Job, Picture};
use orogen::scene::{Aabb, Keep, Measure, Scene};
use orogen::script::{Request, compile};
use orogen::session::topology::{Analysis, Origin, Purpose, correction, kept, rivalled, unproven};
use orogen::session::{self, Order};
use orogen::tape::{Evaluator, Tape};
use orogen::topology::{Complex, CriticalPoint, Kind, Locator, Search, search, separatrices};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, LazyLock};

fn scene(script: &str) -> Scene {
    let compiled = compile(&Request::text(script));
    compiled.scene.unwrap_or_else(|| panic!("{script}: {:?}", compiled.diagnostics))
}

fn tape(script: &str) -> Arc<Tape> {
    let scene = scene(script);
    let root: NodeId = scene.surface.field;
    Arc::new(Tape::new(&scene.graph, &[root]))
}

fn analysed(tape: &Arc<Tape>, region: Aabb) -> Complex {
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let what = Search { region, solid: true };
    let found = search(tape, &what, &watch).expect("it is not cancelled");
    Complex::new(tape, &what, found, &watch).expect("it is not cancelled")
}

/// Nothing from disk, and volumes.
const FRESH: Purpose = Purpose { fresh: true, volumes: true, voids: false };

fn complex(script: &str, half: f64) -> Complex {
    analysed(&tape(script), Aabb::cube(half))
}

#[test]
fn expansions_hold_all_that_they_say() {
    let fields = [
        "length(p) - 1.0",
        "length(vec3(x, 2.0 * y, z)) * sin(3.0 * x) + exp(y)",
        "sqrt(2.0 + x * y) / (1.5 + z * z)",
        "powi(x, 3) - square(y) * cos(z) + atan(x * z)",
        "smooth_union(sphere(0.7), sphere(0.6).translate([0.8, 0, 0]), 0.3)",
        "0.6 * gradient(7).scaled(4.0) + sphere(1.0)",
        "0.3 * sparse(2).scaled(3.0) * simplex(4).scaled(2.0)",
        "gradient(3).scaled(2.0).at(vec3(x + 0.3 * sin(y), y * z, exp(x)))",
        "plus(1.0 - length(p), 3) + norm(x, y, 4) + mix(x, y * z, z)",
    ];
    let mut rng = StdRng::seed_from_u64(11);
    for script in fields {
        let tape = tape(script);
        let mut balls = Evaluator::<Taylors<16>>::new(tape.clone());
        let mut jets = Evaluator::<Jet>::new(tape);
        for round in 0..40 {
            let mut at: [Taylors<16>; 3] = std::array::from_fn(|_| Taylors::constant(0.0));
            let centres: Vec<DVec3> = (0..16)
                .map(|_| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.1..1.1))))
                .collect();
            let radii: Vec<f64> = (0..16).map(|i| 0.7 / f64::from(1 << (i / 2 + round % 3))).collect();
            (0..16).for_each(|i| Taylors::set_ball(&mut at, i, centres[i].to_array(), radii[i]));
            let found = *balls.eval(&at);
            for i in 0..16 {
                for _ in 0..12 {
                    let u = loop {
                        let u = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
                        if u.length() < 1.0 {
                            break u;
                        }
                    };
                    let p = (centres[i] + radii[i] * u).to_array();
                    let jet = *jets.eval(&std::array::from_fn(|axis| Jet::coordinate(p[axis], axis)));
                    holds(script, &found.lane(i), u, radii[i], &jet);
                }
            }
        }
    }
}

/// That an expansion over a ball of this radius holds a jet at the place `u` in it.
fn holds(script: &str, f: &Taylor, u: DVec3, radius: f64, jet: &Jet) {
    let matrix =
        |[xx, yy, zz, xy, xz, yz]: [f64; 6]| DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    let (g, h) = (DVec3::from_array(f.grad), matrix(f.hess));
    let slope = radius * DVec3::from_array(jet.grad);
    let bend = radius * radius * matrix(jet.hess);
    let size = 1.0 + jet.value.abs() + slope.length();
    // A bound that is no number bounds nothing.
    let within = |what: &str, off: f64, bound: f64| {
        assert!(
            bound.is_nan() || off <= bound * (1.0 + 1e-9) + 1e-11 * size,
            "{script}: {what} is off by {off}, not {bound}"
        );
    };
    assert!(
        f.range.lo <= jet.value + 1e-12 * size && jet.value <= f.range.hi + 1e-12 * size,
        "{script}: range"
    );
    within("the value", (jet.value - f.value - g.dot(u)).abs(), f.bow[0]);
    within(
        "the value to second order",
        (jet.value - f.value - g.dot(u) - 0.5 * u.dot(h * u)).abs(),
        f.bow[1],
    );
    within("the gradient", (slope - g).length(), f.turn[0]);
    within("the gradient to second order", (slope - g - h * u).length(), f.turn[1]);
    // The spectral norm is at least what any vector shows.
    for v in [DVec3::X, DVec3::Y, DVec3::Z, u.normalize()] {
        within("the Hessian", ((bend - h) * v).length(), f.twist);
    }
}

/// A solid on a grid of samples.
struct Grid {
    n: [usize; 3],
    inside: Vec<bool>,
}

/// What a sample adds to the Euler characteristics, by which corners of the cube above it are inside.
static ADDED: LazyLock<[[i64; 2]; 256]> = LazyLock::new(|| std::array::from_fn(added));

/// Of a cube whose corners are inside where a bit is set; nothing if the first is not.
fn added(corners: usize) -> [i64; 2] {
    let corner: [bool; 8] = std::array::from_fn(|c| corners >> c & 1 == 1);
    if !corner[0] {
        return [0; 2];
    }
    // Faces are whole if all corners are inside whose axes are among those of the face.
    let is_whole = |face: &usize| (0..8).filter(|c| c & !face == 0).all(|c| corner[c]);
    let sign = |face: usize| if face.count_ones().is_multiple_of(2) { 1 } else { -1 };
    [(0..8).filter(is_whole).map(sign).sum(), chains(&corner, 0)]
}

impl Grid {
    /// So many samples along each edge of a cube, without those beyond a box, where nothing of the solid is.
    fn new(tape: &Arc<Tape>, half: f64, n: usize, within: &Aabb) -> Grid {
        let at = |i: usize| half * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
        let line = |axis: usize| {
            let range = within.min[axis]..=within.max[axis];
            (0..n).map(at).filter(|x| range.contains(x)).collect::<Vec<f64>>()
        };
        let lines = [line(0), line(1), line(2)];
        let plane = |field: &mut Evaluator<Many<f64, 32>>, z: &f64| {
            let mut values = vec![0.0; lines[0].len()];
            let mut plane = Vec::with_capacity(lines[0].len() * lines[1].len());
            for y in &lines[1] {
                field.eval_all([&lines[0], &vec![*y; values.len()], &vec![*z; values.len()]], &mut values);
                plane.extend(values.iter().map(|value| *value < 0.0));
            }
            plane
        };
        let planes = lines[2].par_iter().map_init(|| Evaluator::new(tape.clone()), plane);
        Grid { n: lines.each_ref().map(Vec::len), inside: planes.collect::<Vec<_>>().concat() }
    }

    fn at(&self, x: usize, y: usize, z: usize) -> bool {
        let [nx, ny, nz] = self.n;
        x < nx && y < ny && z < nz && self.inside[(z * ny + y) * nx + x]
    }

    /// Euler characteristics when samples inside are joined to those beside them along the axes, and along the
    /// diagonals that cut cubes into tetrahedra (Kuhn): the simplices above a sample are chains of corners of
    /// its cube.
    fn euler(&self) -> [i64; 2] {
        let corners = |x: usize, y: usize, z: usize| {
            (0..8)
                .map(|c| usize::from(self.at(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2))) << c)
                .sum::<usize>()
        };
        let plane = |z: usize| {
            let places = (0..self.n[1]).flat_map(|y| (0..self.n[0]).map(move |x| (x, y)));
            let inside = places.filter(|&(x, y)| self.at(x, y, z));
            inside.fold([0; 2], |sum, (x, y)| plus(sum, ADDED[corners(x, y, z)]))
        };
        (0..self.n[2]).into_par_iter().map(plane).reduce(|| [0; 2], plus)
    }

    /// Components, with samples joined as in the second of these.
    fn components(&self) -> usize {
        let ([nx, ny, nz], mut label) = (self.n, vec![false; self.inside.len()]);
        let mut count = 0;
        for start in 0..nx * ny * nz {
            if label[start] || !self.inside[start] {
                continue;
            }
            count += 1;
            label[start] = true;
            let mut stack = vec![[start % nx, start / nx % ny, start / nx / ny]];
            while let Some([x, y, z]) = stack.pop() {
                for c in 1..8_usize {
                    let step = [c & 1, c >> 1 & 1, c >> 2];
                    let up = [x + step[0], y + step[1], z + step[2]];
                    let down = [x.wrapping_sub(step[0]), y.wrapping_sub(step[1]), z.wrapping_sub(step[2])];
                    for [x, y, z] in [up, down] {
                        if self.at(x, y, z) && !label[(z * ny + y) * nx + x] {
                            label[(z * ny + y) * nx + x] = true;
                            stack.push([x, y, z]);
                        }
                    }
                }
            }
        }
        count
    }
}

fn plus(a: [i64; 2], b: [i64; 2]) -> [i64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Chains of corners that begin with this one, even ones counted as 1, odd ones as -1.
fn chains(corner: &[bool; 8], first: usize) -> i64 {
    let longer = (first + 1..8).filter(|c| c & first == first && corner[*c]);
    1 - longer.map(|c| chains(corner, c)).sum::<i64>()
}

#[test]
fn known_solids() {
    // Script, counts by index, components, Euler characteristic.
    let known: [(&str, [usize; 4], usize, i64); 8] = [
        ("x * x + y * y + z * z - 1.0", [1, 0, 0, 0], 1, 1),
        // The tip of a cone, and flat minima.
        ("sphere(1.0) + 0.3 * x", [1, 0, 0, 0], 1, 1),
        ("(x * x + y * y + z * z) ** 2 - 0.1", [1, 0, 0, 0], 1, 1),
        ("(x * x + y * y + z * z) ** 4 - 0.1", [1, 0, 0, 0], 1, 1),
        ("(sqrt(x * x + y * y) - 1.0) ** 2 + z * z - 0.09 + 0.02 * x", [1, 1, 0, 0], 1, 0),
        ("(x * x + y * y + z * z - 1.0) ** 2 - 0.1 + 0.03 * x", [1, 0, 1, 0], 1, 2),
        (
            "0.5 - exp(-3.0 * ((x - 1.0) ** 2 + y * y + z * z)) - exp(-3.0 * ((x + 1.0) ** 2 + y * y + z * z))",
            [2, 0, 0, 0],
            2,
            2,
        ),
        (
            "0.05 - exp(-3.0 * ((x - 1.0) ** 2 + y * y + z * z)) - exp(-3.0 * ((x + 1.0) ** 2 + y * y + z * z))",
            [2, 1, 0, 0],
            1,
            1,
        ),
    ];
    for (script, counts, components, euler) in known {
        let found = complex(script, 2.0);
        assert!(found.is_certified(), "{script}: {found:?}");
        assert_eq!(
            (found.counts(), found.components.len(), found.euler()),
            (counts, components, euler),
            "{script}"
        );
    }
}

#[test]
fn what_is_found_is_there() {
    let tape = tape("sphere(1.0) + 0.5 * gradient(3).scaled(3.0) + 0.0");
    let found = analysed(&tape, Aabb::cube(1.9));
    let mut field = Evaluator::<Jet>::new(tape);
    assert!(found.is_certified() && found.points.len() > 50);
    for point in &found.points {
        let p = point.position.to_array();
        let jet = field.eval(&std::array::from_fn(|axis| Jet::coordinate(p[axis], axis)));
        let steepest = point.eigenvalues[2].abs().max(point.eigenvalues[0].abs());
        assert!(DVec3::from_array(jet.grad).length() <= 1e-9 + 2.0 * steepest * point.error, "{point:?}");
        assert!((jet.value - point.value).abs() <= point.value_error + 1e-12, "{point:?}");
        assert_eq!(point.eigenvalues.iter().filter(|l| **l < 0.0).count(), point.kind as usize);
        assert!(point.error < 1e-9 && point.alone > point.error);
    }
}

/// Samples along an edge of the finest grid.
const FINEST: usize = 440;

/// Sums of a sphere and one octave of some noise.
fn hypertexture(seed: u32) -> String {
    let mut rng = StdRng::seed_from_u64(u64::from(seed));
    let noise = ["gradient", "simplex", "sparse"][seed as usize % 3];
    let amplitude = rng.random_range(0.2..0.6) * if noise == "sparse" { 0.4 } else { 1.0 };
    let frequency = rng.random_range(2.0..3.2);
    format!("sphere(1.0) + {amplitude} * {noise}({seed}).scaled({frequency})")
}

#[test]
fn alternating_sums_are_euler_characteristics() {
    let decided = (0..30).into_par_iter().filter(|&seed| is_seen_on_a_grid(&hypertexture(seed))).count();
    assert!(decided >= 20, "{decided}");
}

/// Whether a grid shows what critical points say of a solid. If none does, there is something too fine for grids.
fn is_seen_on_a_grid(script: &str) -> bool {
    let (tape, half) = (tape(script), 2.4);
    let region = Aabb::cube(half);
    let found = analysed(&tape, region);
    assert!(
        found.is_certified(),
        "{script}: open {:?}, level {}, lost {}, beyond {}",
        found.open,
        found.level.len(),
        found.lost,
        found.beyond
    );
    let whole: usize = found.components.iter().map(|c| c.counts.iter().sum::<usize>()).sum();
    assert_eq!(whole, found.points.len());
    let solid = match extent(&Field::of_tape(&tape), &region) {
        Extent::Within(solid) | Extent::Open(solid) => solid,
        Extent::Empty => panic!("{script}: there is something"),
    };
    // A grid may be too coarse for a crumb or a neck; then a finer one decides.
    let agrees = |&n: &usize| {
        let grid = Grid::new(&tape, half, n, &solid);
        let [axes, kuhn] = grid.euler();
        axes == kuhn && (found.euler(), found.components.len()) == (kuhn, grid.components())
    };
    if [128, 256, FINEST].iter().any(agrees) {
        return true;
    }
    // What the finest cannot see is about as wide as its spacing: around a critical value so close to zero.
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let all = search(&tape, &Search { region, solid: false }, &watch).expect("points");
    let spacing = 2.0 * half / FINEST as f64;
    let is_fine = |p: &CriticalPoint| {
        let steepest = p.eigenvalues[0].abs().max(p.eigenvalues[2].abs());
        p.value.abs() < 0.5 * steepest * 3.0 * spacing * spacing
    };
    // Each of these changes the characteristic by one, and the number of components by one at most.
    let fine = all.points.iter().filter(|p| is_fine(p)).count();
    let grid = Grid::new(&tape, half, FINEST, &solid);
    let (own, joined) = (found.euler(), found.components.len());
    for seen in grid.euler() {
        assert!(own.abs_diff(seen) as usize <= fine, "{script}: {own} {seen} {fine}");
    }
    assert!(joined.abs_diff(grid.components()) <= fine, "{script}: {joined} {} {fine}", grid.components());
    false
}

#[test]
fn points_on_faces_count_once_and_places_do_not_matter() {
    let script = |shift: f64| {
        format!("(sphere(1.0) + 0.5 * gradient(7).scaled(3.0)).translate([{shift}, {shift}, {shift}])")
    };
    let here = complex(&script(0.0), 2.0);
    for shift in [0.1, 0.2718281828, 0.3141592653] {
        let there = complex(&script(shift), 2.6);
        assert_eq!(here.counts(), there.counts(), "{shift}");
        assert_eq!(here.components.len(), there.components.len());
    }
    // A minimum in the corner of eight cells, and on the faces of cells of many sizes.
    for offset in [0.0, 0.25, 0.5, 0.03125] {
        let found = complex(&format!("(x - {offset}) ** 2 + y * y + 2.0 * z * z - 0.1"), 1.0);
        assert_eq!(found.counts(), [1, 0, 0, 0], "{offset}");
    }
}

#[test]
fn degenerate_points_are_reported() {
    // Neither a minimum nor a saddle, and a circle of minima.
    let flat = complex("x ** 3 + y * y + z * z - 0.1", 1.0);
    assert!(!flat.is_certified() && !flat.open.is_empty());
    assert!(flat.open.iter().any(|b| b.min.abs().max_element() < 1e-3));
    let ring = complex("(sqrt(x * x + y * y) - 1.0) ** 2 + z * z - 0.09", 1.5);
    assert!(!ring.is_certified() && !ring.open.is_empty());
}

/// A circle of minima is given up soon, and the tip of a cone beside it is found all the same.
#[test]
fn a_crowd_costs_nothing_elsewhere() {
    let script =
        "0.5 - exp(-3.0 * ((x * x + y * y - 1.0) ** 2 + z * z)) - exp(-3.0 * length(vec3(x, y, z - 2.2)))";
    let found = complex(script, 3.0);
    let tip = DVec3::new(0.0, 0.0, 2.2);
    let is_tip = |p: &CriticalPoint| p.kind == Kind::Minimum && !p.smooth && p.position.distance(tip) < 1e-2;
    assert!(found.points.iter().any(is_tip), "{:?}", found.points);
    assert!(!found.open.is_empty() && found.open.iter().all(|place| place.max.z < 1.0), "{:?}", found.open);
}

/// What comes in through a face of the region may have its minimum beyond it: no critical point tells of it.
#[test]
fn what_goes_on_beyond_the_region_is_not_certified() {
    for script in [
        "smooth_union(sphere(0.5), sphere(1.0).translate([1.8, 0, 0]), 0.05)",
        "x * x + z * z + y",
        "y",
        "sphere(1.0).translate([0.3, -1.5, 0.2])",
        "sphere(1e12)",
        // A speck on an edge of the region, and a corner.
        "sphere(0.01).translate([1.005, 1.005, 0.123])",
        "sphere(0.01).translate([1.005, -1.005, 1.005])",
    ] {
        let found = complex(script, 1.0);
        assert!(found.cut && !found.is_certified(), "{script}");
        assert!(found.components.iter().all(|c| c.genus.is_none()), "{script}");
    }
    // What ends close to the border is not taken for what goes on.
    for script in ["sphere(0.999)", "sphere(0.5) + 0.45 * gradient(3).scaled(4.0) * (1.0 - x * x)"] {
        assert!(complex(script, 1.0).is_certified(), "{script}");
    }
}

#[test]
fn a_bridge_of_a_millionth_joins() {
    let blobs = |level: f64| {
        format!(
            "{level:?} - exp(-3.0 * ((x - 1.0) ** 2 + y * y + z * z)) - exp(-3.0 * ((x + 1.0) ** 2 + y * y + z * z))"
        )
    };
    // The saddle is in the middle, where the field of level 0 has this value.
    let wide = complex(&blobs(0.05), 2.0);
    let saddle = wide.points.iter().find(|p| p.kind == Kind::Saddle1).expect("a saddle");
    let level = 0.05 - saddle.value;
    // Half a millionth from the axis the field is higher by this.
    let rise = 0.5 * saddle.eigenvalues[2] * 0.25e-12;
    let (joined, apart) = (complex(&blobs(level - rise), 2.0), complex(&blobs(level + rise), 2.0));
    assert_eq!((joined.components.len(), apart.components.len()), (1, 2), "{rise:e}");
    assert!(joined.is_certified() && apart.is_certified());
}

/// The minima of each component, as numbers in a list of places.
fn parted(found: &Complex, places: &[DVec3]) -> BTreeSet<BTreeSet<usize>> {
    let mut parts: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for (point, component) in found.points.iter().zip(&found.component) {
        if point.kind == Kind::Minimum {
            let is_here = |place: &DVec3| place.distance(point.position) < 1e-7;
            let number = places.iter().position(is_here).expect("a minimum that was there before");
            parts.entry(component.expect("its component")).or_default().insert(number);
        }
    }
    parts.into_values().collect()
}

fn minima(found: &Complex) -> Vec<DVec3> {
    found.points.iter().filter(|p| p.kind == Kind::Minimum).map(|p| p.position).collect()
}

/// A rock at the levels between which the bridge at one of its saddles is closed, by half a millionth on both sides of the
/// saddle: two components are one then, and all others are what they were.
#[test]
fn bridges_of_a_millionth_join_what_they_lead_to_and_nothing_else() {
    for seed in [1, 2, 3] {
        let rock = format!("sphere(1.0) + 0.8 * gradient({seed}).scaled(4.0)");
        let all = complex(&rock, 2.2);
        let places = minima(&all);
        let joining: Vec<_> = all.arcs.iter().filter(|arc| arc.joins).collect();
        assert!(joining.len() > 100, "{}", joining.len());
        for arc in joining.iter().step_by(joining.len() / 12) {
            let saddle = &all.points[arc.saddle];
            let rise = 0.5 * saddle.eigenvalues[2] * 0.25e-12;
            let [joined, apart] = [saddle.value + rise, saddle.value - rise].map(|level| {
                let found = complex(&format!("{rock} - ({level:?})"), 2.2);
                assert!(found.is_certified(), "{rock}, {level}");
                parted(&found, &places)
            });
            let [lost, made] = [&apart - &joined, &joined - &apart];
            assert_eq!((lost.len(), made.len()), (2, 1), "{rock}, {}", saddle.position);
            let both: BTreeSet<usize> = lost.iter().flatten().copied().collect();
            assert_eq!(Some(&both), made.first());
            let ends = arc.minima.map(|end| all.points[end.expect("an end")].position);
            let holder = |end: DVec3| {
                let is_there = |part: &&BTreeSet<usize>| part.iter().any(|&i| places[i].distance(end) < 1e-7);
                lost.iter().position(|part| is_there(&part))
            };
            assert!(holder(ends[0]).is_some() && holder(ends[1]).is_some(), "{rock}");
            assert_ne!(holder(ends[0]), holder(ends[1]), "{rock}");
        }
    }
}

/// What floats beside a rock is one component more, and changes no other.
#[test]
fn an_island_is_a_component_of_its_own() {
    for seed in [5, 6, 7, 8] {
        let base = format!("sphere(0.8) + 0.4 * gradient({seed}).scaled(3.0)");
        let before = complex(&base, 2.0);
        let at = DVec3::new(2.3, 0.1, 0.2);
        let island =
            format!("({base}) - 4.0 * exp(-40.0 * ((x - 2.3) ** 2 + (y - 0.1) ** 2 + (z - 0.2) ** 2))");
        let after = complex(&island, 3.2);
        assert!(before.is_certified() && after.is_certified(), "{base}");
        assert_eq!(after.euler(), before.euler() + 1, "{base}");
        let mut places = minima(&before);
        places.extend(minima(&after).into_iter().filter(|place| place.distance(at) < 0.3));
        assert_eq!(places.len(), minima(&before).len() + 1, "{base}");
        let [before, joined] = [&before, &after].map(|found| parted(found, &places));
        let more: BTreeSet<_> = [BTreeSet::from([places.len() - 1])].into();
        assert_eq!((&joined - &before, &before - &joined), (more, BTreeSet::new()), "{base}");
        let mut locator = Locator::new(&tape(&island), &after);
        let alone = locator.component_inside(at).expect("inside");
        assert_eq!(after.components[alone].counts, [1, 0, 0, 0]);
    }
}

#[test]
fn rough_fields_have_no_complex_and_a_culprit() {
    let script = "let rock = sphere(1.0) + 0.3 * gradient(1);\nmin(rock, 1.0 + x)";
    let scene = scene(script);
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let analysis =
        session::topology::analyse(&scene, FRESH, &watch).unwrap_or_else(|e| panic!("{}", e.message));
    let rough = analysis.rough.as_ref().expect("a reason");
    assert!(analysis.complex.is_none() && rough.message.contains("`min`"), "{}", rough.message);
    assert_eq!(rough.place.as_ref().expect("a place").line, 2);
}

fn analysis(script: &str) -> Analysis {
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    session::topology::analyse(&scene(script), FRESH, &watch).unwrap_or_else(|e| panic!("{}", e.message))
}

/// Where critical points do not decide, the flood does: a circle of minima, and what reaches beyond the bounds.
#[test]
fn degenerate_solids_have_components_all_the_same() {
    let torus = "(length(vec3(x, 0, z)) - 1.0) ** 2 + y * y - 0.09";
    let two = "smooth_union(sphere(0.5), sphere(1.0).translate([1.8, 0, 0]), 0.05)";
    let own = analysis(torus);
    assert!(own.complex.as_ref().is_some_and(|c| !c.is_certified()) && own.proven().is_none());
    assert!(own.is_certified() && own.parts.len() == 1 && !own.parts[0].cut, "{:?}", own.parts);
    // pi^2 / 2 times the radii's product, doubled.
    let volume = 2.0 * std::f64::consts::PI * std::f64::consts::PI * 0.09;
    assert!(own.parts[0].volume.contains(volume), "{:?}", own.parts[0].volume);
    for (p, inside) in [(DVec3::X, true), (DVec3::ZERO, false)] {
        assert_eq!(kept(&own, &Keep::Holding(p)).is_ok(), inside, "{p}");
    }
    let cut = analysis(&format!("scene(#{{ surface: {two}, bounds: 1.0 }})"));
    assert!(cut.parts.len() == 2 && cut.parts.iter().any(|part| part.cut), "{:?}", cut.parts);
}

/// A solid without bounds is found as a whole, however far apart its parts are; or it is known that there may be more.
#[test]
fn far_parts_are_found_or_in_doubt() {
    let bounded = |solid: &str, half: f64| format!("scene(#{{ surface: {solid}, bounds: {half:?} }})");
    let beside = "union(sphere(1.0), sphere(0.5).translated([3, 0, 0]))";
    let ring = "union(sphere(1.0), torus(4.0, 0.3))";
    let far = "union(sphere(1.0), sphere(20.0).translated([500, 0, 0]))";
    let rough = "sphere(1.0) + 0.6 * gradient(7).scaled(4.0)";
    // Balls without end, one of which would fit between the first faces that are looked at.
    let lattice = "max(-(cos(x) + cos(y) + cos(z)) + 2.5, -1.0)";
    for (script, parts, is_whole) in [
        ("sphere(1.0)", Some(1), true),
        (beside, Some(2), true),
        (ring, Some(2), true),
        (far, Some(2), true),
        ("sphere(1e5)", Some(1), true),
        ("sphere(1.0).translated([2e4, 0, 0])", Some(1), true),
        (rough, None, true),
        (lattice, None, false),
        (&bounded(beside, 5.0), Some(2), true),
        (&bounded(beside, 2.0), Some(1), false),
        (&bounded(ring, 4.6), Some(2), true),
        (&bounded("sphere(1.0)", 1.2), Some(1), true),
        (&bounded("sphere(1.0)", 1.0), None, false),
    ] {
        let found = analysis(script);
        assert!(parts.is_none_or(|parts| parts == found.parts.len()), "{script}: {:?}", found.parts);
        assert_eq!(found.is_whole, is_whole, "{script}: {:?}", found.region);
        assert!(parts.is_none() || found.is_certified(), "{script}");
    }
    let large = "union(sphere(1.0), sphere(2.0).translated([8, 0, 0]))";
    let most = |script: &str| {
        let found = analysis(script);
        let kept = kept(&found, &Keep::Most(Measure::Volume)).expect("there is one");
        let holder = found.labels.clone().components(&[DVec3::new(8.0, 0.0, 0.0)])[0];
        let i = kept.iter().position(|ruling| ruling.kept).expect("there is one");
        (Some(i) == holder, kept[i].proven)
    };
    assert_eq!(most(large), (true, true));
    assert_eq!(most(&bounded(large, 5.0)), (false, false));
}

/// What is said of a flowed solid is what is proven of the one before, if that is proven of the flow.
#[test]
fn flows_keep_components_or_are_in_doubt() {
    let two = "union(sphere(1.0), sphere(1.0).translated([4, 0, 0]))";
    let push = "flow::push([0, 0.9, 0], [0.5, 0.3, 0], 0.7)";
    for (script, parts, doubts) in [
        (format!("{two}.flow(vec3(0, 0.1, 0))"), 2, 0),
        (format!("sphere(1.0).flow({push})"), 1, 0),
        (
            format!("{two}.flow(vec3(0, 0.1, 0)).translated([0.5, 0, 0]).rotated([0, 1, 0], 30).scaled(2.0)"),
            2,
            0,
        ),
        (format!("sphere(0.6).flow({push}) - 0.1"), 1, 0),
        (format!("union(sphere(0.4).flow({push}), sphere(0.4).translated([3, 0, 0]).flow({push}))"), 2, 0),
        (format!("(sphere(0.6).flow({push}).translated([0, 0.5, 0]) - 0.1).flow({push})"), 1, 0),
        ("sphere(1.0).flow(flow::by_noise(gradient(7).scaled(4.0), 1.0), #{ steps: 64 })".into(), 1, 0),
        ("sphere(1.0).flow(flow::by_noise(gradient(7).scaled(4.0), 1.0), #{ steps: 1 })".into(), 1, 1),
        ("sphere(1.0).flow(vec3(sqrt(x), 0, 0))".into(), 1, 1),
        ("sphere(1.0).flow(length_squared(p) * p)".into(), 1, 1),
        ("scene(#{ surface: sphere(1.0).flow(vec3(3, 0, 0)), bounds: 5.0 })".into(), 1, 0),
        ("scene(#{ surface: sphere(1.0).flow(vec3(3, 0, 0)), bounds: 2.0 })".into(), 1, 1),
        (format!("sphere(1.0).flow({push}, #{{ steps: 1 }}).flow({push})"), 1, 1),
    ] {
        let scene = scene(&format!("import \"std/flow\" as flow;\n{script}"));
        let origin = Origin::of(&scene).expect("it flows");
        assert_eq!(origin.doubts.len(), doubts, "{script}: {:?}", origin.doubts);
        let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
        let found = session::topology::analyse(&origin.scene, FRESH, &watch).expect("it is not cancelled");
        assert_eq!(found.parts.len(), parts, "{script}");
    }
}

/// Where paths along the axes end in saddles, as in sums of functions of one coordinate each, others lead on.
#[test]
fn sums_of_functions_of_one_coordinate_are_known_in_full() {
    let well = |axis: char| format!("({axis} * {axis} - 1.0) * ({axis} * {axis} - 1.0)");
    let wells = ['x', 'y', 'z'].map(well).join(" + ");
    for (level, counts, euler) in
        [(1.5, [8, 12, 0, 0], -4), (2.1, [8, 12, 6, 0], 2), (2.9, [8, 12, 6, 0], 2), (3.5, [8, 12, 6, 1], 1)]
    {
        let found = analysis(&format!("{wells} - {level}"));
        let complex = found.proven().unwrap_or_else(|| panic!("all of {level} is proven"));
        assert_eq!((complex.counts(), complex.euler()), (counts, euler), "{level}");
        assert_eq!(complex.components.len(), 1);
    }
}

/// What is neither flowed as a whole nor moved by a linear map is no flowed solid, and what is kept of one that is moved
/// afterwards is judged where it was.
#[test]
fn flowed_solids_may_be_moved_and_mixed() {
    let two = "union(sphere(1.0), sphere(1.0).translated([4, 0, 0])).flow(vec3(0, 0.1, 0))";
    for other in [
        "union(sphere(1.0).flow(vec3(0, 0.1, 0)), sphere(0.5))",
        "sphere(1.0).flow(vec3(0, 0.1, 0)).at(vec3(x + 0.1 * sin(y), y, z))",
        "sphere(1.0).flow(vec3(0, 0.1, 0)).at(vec3(x, y, 0.0))",
        "union(sphere(1.0).flow(vec3(0, 0.1, 0)), sphere(1.0).flow(vec3(0, 0.2, 0)))",
        "sphere(1.0)",
        // It is not known where to look for what goes on and on.
        "gradient(3).flow(vec3(0, 0.1, 0)).scaled(0.01)",
    ] {
        assert!(Origin::of(&scene(other)).is_none(), "{other}");
    }
    let moved = format!("(0.5 * {two} - 0.05).scaled(0.5).rotated([0, 0, 1], 90).translated([0, 0, 3])");
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    // Where the middles of the two are after all that.
    let middles = [DVec3::new(-0.05, 0.0, 3.0), DVec3::new(-0.05, 2.0, 3.0)];
    for kept in [0, 1] {
        let [x, y, z] = middles[kept].to_array();
        let scene = scene(&format!("component_of({moved}, [{x}, {y}, {z}])"));
        let keep = scene.surface.keep.expect("it keeps one");
        let mut judge = correction(&scene, &keep, None, &watch).expect("there is one").judge;
        let mut rulings = [Ruling { kept: false, proven: false }; 2];
        judge.judge(&middles, &mut rulings, watch.cancel);
        assert_eq!(rulings.map(|ruling| ruling.kept), [kept == 0, kept == 1]);
        assert!(rulings.iter().all(|ruling| ruling.proven));
    }
    // A flow that turns points by a radian is no different.
    let turned = scene("component_of(sphere(1.0).flow(vec3(-z, 0, x)), [0.5, 0, 0])");
    let keep = turned.surface.keep.expect("it keeps one");
    assert!(correction(&turned, &keep, None, &watch).is_ok());
    let outside = scene(&format!("component_of({moved}, [0, 0, 0])"));
    let keep = outside.surface.keep.expect("it keeps one");
    let error = correction(&outside, &keep, None, &watch).err().expect("there is none");
    assert!(error.message.contains("[0, 0, 0], the point of component_of"), "{error:?}");
}

/// Volumes of smooth solids are enclosed, and which is largest follows from them.
#[test]
fn volumes_hold_those_of_samples() {
    let script = "sphere(1.0) + 0.8 * gradient(1).scaled(4.0)";
    let found = analysis(script);
    let complex = found.proven().expect("all of it is proven");
    assert_eq!(complex.components.len(), 67);
    let mut labels = found.labels.clone();
    let mut field = Field::new(&scene(script).graph, scene(script).surface.field);
    let n = 80;
    let region = found.region;
    let place = |i: usize| {
        let share = [i % n, i / n % n, i / n / n].map(|k| (k as f64 + 0.5) / n as f64);
        region.min + (region.max - region.min) * DVec3::from_array(share)
    };
    let inside: Vec<DVec3> = (0..n * n * n).map(place).filter(|p| field.value(*p) < 0.0).collect();
    let cell = (region.max - region.min).element_product() / (n * n * n) as f64;
    let mut sampled = vec![0.0; found.parts.len()];
    labels.components(&inside).into_iter().for_each(|c| sampled[c.expect("all is proven")] += cell);
    for (i, (part, sampled)) in found.parts.iter().zip(&sampled).enumerate() {
        // Samples are no proof either.
        let slack = 0.02 * sampled + 8.0 * cell;
        let Interval { lo, hi } = part.volume;
        assert!(lo <= sampled + slack && sampled - slack <= hi, "{i}: {sampled} {:?}", part.volume);
        assert!((part.about.unwrap_or(0.0) - sampled).abs() < slack, "{i}: {sampled} {:?}", part.about);
    }
    let Interval { lo, hi } = found.parts[0].volume;
    assert!(hi - lo < 0.4 && hi < 1.1 * lo, "{lo} {hi}");
    let largest = (0..sampled.len()).max_by(|&a, &b| sampled[a].total_cmp(&sampled[b]));
    let kept = kept(&found, &Keep::Most(Measure::Volume)).expect("there is one");
    assert_eq!(kept.iter().position(|ruling| ruling.kept), largest);
}

/// A solid that is in its box as a whole is not cut by it, even where it touches the box's faces; in whichever way it was
/// analysed.
#[test]
fn a_solid_that_fits_its_box_closely_is_whole() {
    let smooth = "sphere(1.0) + 0.1052 * value(8).scaled(1.8251)";
    let flat = "box([1.0, 1.0, 1.0])";
    for (solid, bounds) in [(smooth, None), (smooth, Some(2.0)), (flat, None), (flat, Some(0.75))] {
        let bounds = bounds.map_or(String::new(), |half: f64| format!(", bounds: {half:?}"));
        let found = analysis(&format!("scene(#{{ surface: {solid}{bounds} }})"));
        assert!(found.is_whole && found.is_certified(), "{solid}{bounds}");
        assert!(found.parts.len() == 1 && !found.parts[0].cut, "{solid}{bounds}: {:?}", found.parts);
        assert_eq!(found.proven().is_some(), solid == smooth, "{bounds}");
        for keep in [Keep::Most(Measure::Minima), Keep::Most(Measure::Volume), Keep::Share(0.5)] {
            let rulings = kept(&found, &keep).expect("there is one");
            assert!(rulings.iter().all(|r| r.kept && r.proven), "{solid}{bounds} {keep:?}");
            assert!(unproven(&found, &rulings).is_none());
        }
    }
    // Half of it is cut.
    let half = analysis(&format!("scene(#{{ surface: {smooth}, bounds: [[0, -2, -2], [2, 2, 2]] }})"));
    assert!(!half.is_whole && half.parts.iter().all(|part| part.cut), "{:?}", half.parts);
}

/// Of components with as many minima the one of largest volume is the main one, however deep others are; and one that
/// is nearly as large is told of.
#[test]
fn a_deep_crumb_is_not_the_main_component() {
    let body = "0.4 - exp(-(x * x + y * y + z * z))";
    let crumb = "2.0 * exp(-60.0 * ((x - 0.9) ** 2 + (y - 1.1) ** 2 + (z - 0.9) ** 2))";
    let found = analysis(&format!("({body}) - {crumb}"));
    for (measure, rival) in [(Measure::Minima, true), (Measure::Volume, false)] {
        let rulings = kept(&found, &Keep::Most(measure)).expect("there is one");
        let main = rulings.iter().position(|ruling| ruling.kept).expect("one is kept");
        assert!(found.parts[main].volume.lo > 3.0, "{:?}", found.parts);
        assert!(rulings.iter().all(|ruling| ruling.proven), "{rulings:?}");
        let told = rivalled(&found, &Keep::Most(measure));
        assert_eq!(told.is_some_and(|told| told.message.contains("100 %")), rival);
    }
}

#[test]
fn rough_fields_have_components_all_the_same() {
    let script = "min(sphere(1.0), sphere(0.3).translate([1.8, 0, 0]))";
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let analysis = session::topology::analyse(&scene(script), FRESH, &watch).expect("components");
    let sizes: Vec<Interval> = analysis.parts.iter().map(|part| part.volume).collect();
    assert!(analysis.flood.is_certified() && sizes.len() == 2, "{sizes:?}");
    for (size, radius) in sizes.iter().zip([1.0, 0.3_f64]) {
        assert!(size.contains(4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius), "{sizes:?}");
    }
    let pixels = |script: &str| rendered(script).pixels.iter().filter(|p| p.depth.is_finite()).count();
    let [whole, large, ball] = [script, &format!("largest_component({script})"), "sphere(1.0)"]
        .map(|script| pixels(&format!("scene(#{{ surface: {script}, bounds: 2.5 }})")));
    assert!(whole > ball && large == ball, "{whole} {large} {ball}");
}

/// A cell of the flood speaks for what is solid in it, and not for points outside.
#[test]
fn a_point_outside_has_no_component() {
    let script = "min(sphere(1.0), sphere(0.3).translate([1.8, 0, 0]))";
    let found = analysis(script);
    let outside: Vec<DVec3> =
        (0..60).map(|i| DVec3::new(0.3, 0.9, 0.1).normalize() * (1.0 + 1e-3 * f64::from(i))).collect();
    let mut labels = found.labels.clone();
    assert!(labels.components(&outside).into_iter().flatten().count() > 2, "some share a cell with the ball");
    assert!(outside.iter().all(|&p| kept(&found, &Keep::Holding(p)).is_err()));
    let error = kept(&found, &Keep::Holding(DVec3::Y * 1.5)).expect_err("it is outside");
    assert!(error.message.contains("[0, 1.5, 0]") && error.hints[0].contains("0.5"), "{error:?}");
    assert!(error.place.is_some());
}

/// Rulings follow from intervals: where these overlap, and where components may be joined beyond the bounds, none is proven.
#[test]
fn rulings_are_proven_or_say_that_they_are_not() {
    let rulings = |script: &str, keep: Keep| {
        let found = analysis(script);
        let kept = kept(&found, &keep).expect("rulings");
        (kept.iter().map(|r| (r.kept, r.proven)).collect::<Vec<_>>(), unproven(&found, &kept))
    };
    let two = |radius: f64| format!("min(sphere(1.0), sphere({radius}).translate([2.3, 0.1, 0.2]))");
    let (clear, warning) = rulings(&two(0.5), Keep::Most(Measure::Volume));
    assert_eq!((clear, warning), (vec![(true, true), (false, true)], None));
    let (close, warning) = rulings(&two(0.9999), Keep::Most(Measure::Volume));
    assert!(close.iter().all(|(_, proven)| !proven) && warning.is_some(), "{close:?}");
    let cut = format!("scene(#{{ surface: {}, bounds: 2.0 }})", two(0.5));
    let (cut, warning) = rulings(&cut, Keep::Holding(DVec3::ZERO));
    assert_eq!(cut, [(true, true), (false, false)]);
    assert!(warning.is_some_and(|w| w.message.contains("beyond the bounds")));
    // The arcs of a ring may be one beyond the bounds, and larger than the ball between them; the crumb is not.
    let ring = "union(min(torus(1.0, 0.2), sphere(0.37)), sphere(0.1).translate([0, 1.2, 0]))";
    let ring = format!("scene(#{{ surface: {ring}, bounds: [[-2, -2, -0.5], [2, 2, 0.5]] }})");
    let (ring, warning) = rulings(&ring, Keep::Most(Measure::Volume));
    assert_eq!(ring, [(true, false), (false, false), (false, false), (false, true)]);
    assert!(warning.is_some_and(|w| w.message.contains("beyond the bounds")));
    let camera = "orbit(#{ target: [1.2, 0, 0], distance: 7.0 })";
    let surface = format!("largest_component({}, \"volume\")", two(0.9999));
    let picture = rendered(&format!("scene(#{{ surface: {surface}, camera: {camera} }})"));
    assert!(picture.stats.uncertified() > 0 && picture.warnings.len() == 1, "{:?}", picture.warnings);
}

fn rendered(script: &str) -> Picture {
    let order = Order { size: Some((96, 72)), samples: Some(1), ..Order::default() };
    session::render(&scene(script), &order, &Job::unwatched(&AtomicBool::new(false))).expect("a picture")
}

#[test]
fn corrected_pictures_have_neither_specks_nor_their_shadows() {
    // The crumb hangs between the sun and the ball, in sight of the camera.
    let ball = "0.4 - exp(-(x * x + y * y + z * z))";
    let crumb = "exp(-60.0 * ((x - 0.9) ** 2 + (y - 1.1) ** 2 + (z - 0.9) ** 2))";
    let show = |surface: &str| {
        format!(
            "scene(#{{ surface: {surface}, bounds: 2.5, sun: sun(#{{ azimuth: 45.0, elevation: 40.0 }}) }})"
        )
    };
    let alone = rendered(&show(ball));
    let both = rendered(&show(&format!("({ball}) - {crumb}")));
    let light = |p: &Picture, i: usize| p.pixels[i].color.map(f64::from);
    let differing = |p: &Picture| {
        let apart = |i: &usize| (0..3).any(|c| (light(p, *i)[c] - light(&alone, *i)[c]).abs() > 0.02);
        (0..p.pixels.len()).filter(apart).count()
    };
    assert!(differing(&both) > 100, "{}", differing(&both));
    for keep in ["largest_component(F, \"volume\")", "component_of(F, [0, 0, 0])"] {
        let surface = keep.replace('F', &format!("({ball}) - {crumb}"));
        let corrected = rendered(&show(&surface));
        assert_eq!(differing(&corrected), 0, "{keep}");
        assert!(corrected.stats.primary.rejected > 0 && corrected.stats.shadow.rejected > 0);
    }
}

/// Lines from saddles down to minima stay in the solid, however they bend.
#[test]
fn separatrices_stay_inside() {
    let rings = [
        "polynomial(\"(x^2 + 1.05 y^2 + z^2 + 0.91)^2 - 4 (x^2 + z^2)\") + 0.02*x + 0.013*z + 0.001*y",
        "polynomial(\"(x^2 (1 - x^2) - y^2)^2 + 0.5 z^2 - 0.01\") + 0.001*x + 0.0013*y + 0.0007*z",
        "sphere(1.0) + 0.8 * gradient(1).scaled(4.0)",
    ];
    for script in rings {
        let tape = tape(script);
        let complex = analysed(&tape, Aabb::cube(2.0));
        let lines = separatrices(&tape, &complex);
        assert_eq!(lines.len(), complex.arcs.len());
        let mut field = Evaluator::<f64>::new(tape.clone());
        let mut value = |p: DVec3| *field.eval(&p.to_array());
        for (line, arc) in lines.iter().zip(&complex.arcs) {
            for (end, minimum) in [line.first(), line.last()].into_iter().zip(arc.minima) {
                if let Some(minimum) = minimum {
                    assert_eq!(end, Some(&complex.points[minimum].position), "{script}");
                }
            }
            for pair in line.windows(2) {
                let middle = 0.5 * (pair[0] + pair[1]);
                assert!(value(middle) < 0.0, "{script}: {} to {}: {}", pair[0], pair[1], value(middle));
            }
        }
    }
}
