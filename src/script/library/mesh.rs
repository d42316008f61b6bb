//! Triangle meshes: what other programs made, as solids.

use super::{Call, Library};
use crate::exchange;
use crate::expr::NodeId;
use crate::script::fault::{Fault, Outcome};
use crate::script::host::Host;
use crate::script::options::describe;
use crate::script::value::{Field, Vec3};
use crate::shape::{Distance, Mesh, Shape, Unfit};
use glam::DVec3;
use rhai::{Array, Dynamic, INT};
use std::any::TypeId;
use std::sync::{Arc, OnceLock};

/// A mesh in scripts. What its solid needs is computed when it is first asked for.
#[derive(Clone, Debug)]
pub struct MeshValue(Arc<Solid>);

#[derive(Debug)]
struct Solid {
    mesh: Mesh,
    shape: OnceLock<Result<Arc<Shape>, Unfit>>,
}

impl MeshValue {
    fn new(mesh: Mesh) -> MeshValue {
        MeshValue(Arc::new(Solid { mesh, shape: OnceLock::new() }))
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.0.mesh
    }

    /// The signed distance from it at the point.
    pub fn lower(&self, host: &Host) -> Outcome<NodeId> {
        let made = self.0.shape.get_or_init(|| Distance::new(self.mesh()).map(|d| Arc::new(Shape::new(d))));
        let shape = made.clone().map_err(unfit)?;
        let p = host.point()?;
        Ok(host.graph.borrow_mut().shape(shape, p)?)
    }
}

fn unfit(unfit: Unfit) -> Fault {
    let fault = Fault::new(unfit.to_string());
    match unfit {
        Unfit::Empty => {
            fault.hint("a solid needs triangles whose corners are three different points, not in a line")
        }
        Unfit::Size => fault.hint("export it in larger or smaller units"),
        Unfit::Count(_) => fault.hint("simplify it in the program that made it"),
        Unfit::Flaw(_) => fault,
    }
}

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<MeshValue>("Mesh");
    let folder = lib.folder.clone();
    lib.def(
        "load_mesh(file)",
        "The triangle mesh in a file (`.obj`, `.ply`, `.stl`, `.glb` or `.gltf`) in the folder of the main script or below. Where a field is needed it is a solid: the distance from its surface, negative inside. Holes get lids; triangles that are turned against their neighbours, and parts that are inside out but no voids, are turned. Parts may overlap, but where they do the walls inside count for the distance.",
        "load_mesh(\"knot.obj\").fitted(2.0)",
        move |c| {
            let path = c.text(0)?;
            let (shown, bytes) = folder.bytes(&path)?;
            let mesh = exchange::mesh::read(&shown, &bytes)
                .map_err(|e| Fault::new(format!("{}{}: {}", e.file, e.place, e.what)).hint(e.remedy))?;
            Ok(Dynamic::from(MeshValue::new(mesh)))
        },
    );
    lib.def(
        "mesh_of(points, triangles)",
        "The mesh of some triangles: points, and for each triangle the numbers of its corners from 0, counter-clockwise as seen from outside.",
        "mesh_of([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])",
        mesh_of,
    );
    lib.def(
        "fitted(mesh, size)",
        "The mesh with its middle at the origin, and as large as that: the length of the longest edge of the box around it.",
        "load_mesh(\"knot.obj\").fitted(2.0)",
        fitted,
    );
    lib.bind_typed("field", [TypeId::of::<MeshValue>()], |c| {
        Ok(Dynamic::from(Field { node: mesh(c, 0)?.lower(c.host)?, color: None }))
    });
    lib.document(
        "field",
        "field(mesh)",
        "The mesh as a field, which it becomes by itself where one is needed.",
        "load_mesh(\"knot.obj\").field()",
    );
    lib.property::<MeshValue>("points", |_, m| Ok(Dynamic::from_int(m.mesh().points.len() as INT)));
    lib.property::<MeshValue>("triangles", |_, m| Ok(Dynamic::from_int(m.mesh().triangles.len() as INT)));
    lib.property::<MeshValue>("min", |_, m| Ok(corner(m.mesh().bounds().map(|b| b.0))));
    lib.property::<MeshValue>("max", |_, m| Ok(corner(m.mesh().bounds().map(|b| b.1))));
}

fn corner(p: Option<DVec3>) -> Dynamic {
    p.map_or(Dynamic::UNIT, |p| Dynamic::from(Vec3(p.to_array())))
}

/// The mesh that argument `i` is.
fn mesh(c: &Call<'_>, i: usize) -> Outcome<MeshValue> {
    let found = c.args[i].read_lock::<MeshValue>().map(|m| m.clone());
    found.ok_or_else(|| c.wrong(i, "a mesh").hint("load_mesh(\"file.obj\") reads one"))
}

fn mesh_of(c: &Call<'_>) -> Outcome<Dynamic> {
    let list = |i: usize, wanted| {
        c.args[i].read_lock::<Array>().map(|a| a.clone()).ok_or_else(|| c.wrong(i, wanted))
    };
    let wrong = |what: &str, i: usize, wanted: &str, given: &Dynamic| {
        Fault::new(format!("{what} {i} of `mesh_of` must be {wanted}, not {}", describe(given)))
    };
    let mut mesh = Mesh::default();
    for (i, given) in list(0, "an array of points")?.iter().enumerate() {
        let point = c.vec3_of(given)?.filter(|p| p.is_finite());
        mesh.points.push(point.ok_or_else(|| wrong("point", i, "a vector such as [0, 1, 0]", given))?);
    }
    let count = mesh.points.len();
    for (i, given) in list(1, "an array of triangles")?.iter().enumerate() {
        let corner = |v: &Dynamic| {
            v.as_int().ok().and_then(|v| u32::try_from(v).ok()).filter(|v| (*v as usize) < count)
        };
        let corners =
            given.read_lock::<Array>().and_then(|a| a.iter().map(corner).collect::<Option<Vec<u32>>>());
        let corners = corners.and_then(|corners| <[u32; 3]>::try_from(corners).ok());
        mesh.triangles.push(corners.ok_or_else(|| {
            let last = count.saturating_sub(1);
            Fault::new(format!(
                "triangle {i} of `mesh_of` must be three numbers of points, from 0 to {last}, not {given}"
            ))
        })?);
    }
    Ok(Dynamic::from(MeshValue::new(mesh)))
}

fn fitted(c: &Call<'_>) -> Outcome<Dynamic> {
    let (mesh, size) = (mesh(c, 0)?, c.number(1)?);
    if !(1e-9..=1e9).contains(&size) {
        return Err(Fault::new(format!("the size of `fitted` is out of range: {size}"))
            .label("from 1e-9 to 1e9 allowed"));
    }
    let bounds = mesh.mesh().bounds().map(|(lo, hi)| (0.5 * lo + 0.5 * hi, (hi - lo).max_element()));
    let Some((middle, extent)) = bounds.filter(|b| b.1 > 0.0 && b.1.is_finite()) else {
        return Err(Fault::new(
            "the mesh has no size that could be changed: its points are all in one place",
        ));
    };
    let mut fitted = mesh.mesh().clone();
    fitted.points.iter_mut().for_each(|p| *p = (*p - middle) * (size / extent));
    Ok(Dynamic::from(MeshValue::new(fitted)))
}
