//! The same pictures as orogen makes them.

use crate::View;
use glam::{DMat3, DVec3};
use orogen::cast::{CastStats, Hit, Kind, Ray, Tolerance, caster_in};
use orogen::expr::{Graph, NodeId, text};
use orogen::field::{Field, Watch};
use orogen::mesh::Fineness;
use orogen::num::{Dual, Many};
use orogen::scene::{Aabb, Scene};
use orogen::script::{Request, compile};
use orogen::session::{on_threads, polygonise};
use orogen::tape::{Cells, Evaluator};
use std::hint::black_box;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// How precisely hits are wanted.
const TOLERANCE: f64 = 1e-4;

/// Six octaves of gradient noise on a ball.
const PLANET: &str = "let f = length(p) - 0.75; \
    for i in 0..6 { f -= 0.15 / 2.0 ** i * gradient(7 + i).scaled(4.0 * 2.0 ** i); } f";

pub struct Model {
    field: Field,
    scene: Scene,
}

impl Model {
    /// The model of a file, or else a planet.
    pub fn read(path: Option<&Path>) -> Result<Model, String> {
        let Some(path) = path else {
            let compiled = compile(&Request::text(PLANET));
            let scene = compiled.scene.ok_or_else(|| format!("{:?}", compiled.diagnostics))?;
            return Ok(Model { field: Field::new(&scene.graph, scene.surface.field), scene });
        };
        let (graph, root) = expression(path)?;
        let field = Field::new(&graph, root);
        let mut scene =
            compile(&Request::text("scene(#{ surface: x, bounds: 1.0 })")).scene.expect("a scene");
        (scene.graph, scene.surface.field) = (Arc::new(graph), root);
        Ok(Model { field, scene })
    }

    /// How many triangles a mesh has, with so many halvings of the cube.
    pub fn triangles(&self, depth: u8) -> usize {
        let fineness = Fineness { resolution: Some(1 << depth), tolerance: None };
        let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
        let meshed = on_threads(NonZeroUsize::new(1), || polygonise(&self.scene, &fineness, &watch));
        meshed.expect("a thread").expect("a mesh that nobody cancels").meshed.mesh.triangles.len()
    }

    /// Which pixels the model covers, row by row from the top, from nothing to all hits, and normals if
    /// they are wanted.
    pub fn hits(&self, view: &View, normals: bool) -> Vec<bool> {
        let field = &self.field;
        let half = view.half * 3f64.sqrt();
        let region = Aabb::cube(half);
        let cells = Arc::new(Cells::of_sides(field.tape().clone(), &region.intervals()));
        let frame = Screen::new(view);
        let (mut rays, mut pixels) = (Vec::new(), Vec::new());
        let mut typical = Vec::new();
        for tile in (0..frame.tiles()).step_by((frame.tiles() / 10).max(1)) {
            frame.tile(tile, &mut rays, &mut pixels);
            typical.push(rays[..64].to_vec());
        }
        let (mut stats, never) = (CastStats::default(), AtomicBool::new(false));
        let mut caster =
            caster_in(Kind::Auto, field, &region, &cells, &typical, &never).expect("beams serve every field");
        let mut shading = Normals::new(&cells);
        let mut covered = vec![false; view.size * view.size];
        let mut hits = vec![Hit::MISS; GROUP];
        for tile in 0..frame.tiles() {
            frame.tile(tile, &mut rays, &mut pixels);
            caster.first_hits(&rays, &mut hits, &mut stats, &never);
            let met = || hits.iter().zip(&rays).filter(|(hit, _)| hit.is_hit());
            for (hit, &pixel) in hits.iter().zip(&pixels) {
                covered[pixel] = hit.is_hit();
            }
            if normals {
                shading.at(&met().map(|(hit, ray)| ray.at(hit.t)).collect::<Vec<_>>());
            }
        }
        covered
    }
}

/// Rays of a group: a tile of 64 by 64.
const GROUP: usize = 4096;

fn expression(path: &Path) -> Result<(Graph, NodeId), String> {
    let source = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
    let mut graph = Graph::default();
    let root = text::read(&mut graph, &path.to_string_lossy(), &source).map_err(|d| d.message.clone())?;
    Ok((graph, root))
}

/// Rays along the z axis through the middles of pixels.
struct Screen {
    turned: DMat3,
    half: f64,
    /// Pixels along an edge, a multiple of 64.
    size: usize,
}

impl Screen {
    fn new(view: &View) -> Screen {
        let [x, z] = view.turns.map(f64::to_radians);
        Screen {
            turned: DMat3::from_rotation_x(x) * DMat3::from_rotation_z(z) * view.half,
            half: view.half,
            size: view.size,
        }
    }

    fn tiles(&self) -> usize {
        self.size * self.size / GROUP
    }

    /// The rays of a tile, and where their pixels are.
    fn tile(&self, tile: usize, rays: &mut Vec<Ray>, pixels: &mut Vec<usize>) {
        let direction = (self.turned * DVec3::NEG_Z).normalize();
        let place = |i: usize| 2.0 * (i as f64 + 0.5) / self.size as f64 - 1.0;
        let across = self.size / 64;
        rays.clear();
        pixels.clear();
        for i in 0..GROUP {
            let (column, row) =
                (tile % across * 64 + every_other(i), tile / across * 64 + every_other(i >> 1));
            // A little behind where the picture begins: rays that begin at zero begin on a surface.
            let origin = self.turned * DVec3::new(place(column), -place(row), 2.0);
            let (near, far) = (self.half, 3.0 * self.half);
            rays.push(Ray { origin, direction, near, far, tolerance: Tolerance::fixed(TOLERANCE) });
            pixels.push(row * self.size + column);
        }
    }
}

/// Every other bit, from the lowest on: one axis of Morton's order.
fn every_other(i: usize) -> usize {
    (0..6).fold(0, |x, bit| x | (i >> (2 * bit) & 1) << bit)
}

/// Points whose normals are found together.
const LANES: usize = 16;

/// Finds normals.
struct Normals<'a> {
    cells: &'a Cells,
    duals: Evaluator<Many<Dual, LANES>>,
}

impl<'a> Normals<'a> {
    fn new(cells: &'a Cells) -> Self {
        Normals { cells, duals: Evaluator::new(cells.tape().clone()) }
    }

    fn at(&mut self, points: &[DVec3]) {
        let order = self.cells.tapes_around(points.iter().enumerate().map(|(i, p)| (i, p.to_array(), 0.0)));
        for same in order.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            self.duals.turn_to(same[0].0);
            for batch in same.chunks(LANES) {
                let at = |lane: usize| points[batch[lane.min(batch.len() - 1)].1];
                let p = [0, 1, 2]
                    .map(|axis| Many(std::array::from_fn(|lane| Dual::coordinate(at(lane)[axis], axis))));
                black_box(self.duals.eval(&p));
            }
        }
    }
}
