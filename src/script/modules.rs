//! Imports: the standard library, embedded and shadowable, and files of the script's own folder.
//!
//! `import "rocks/basalt" as basalt` reads `rocks/basalt.rhai` in the folder of the main script;
//! `import "std/fractal"` reads `std/fractal.rhai` there if that exists, else the embedded one.
//! Nothing else can be read: no absolute paths, no `..`, no links that lead out of the folder.

use super::arguments;
use super::fault::Fault;
use super::marks::{Function, Marks};
use super::{lexer, slips};
use crate::diag::{self, Sources};
use crate::world::World;
use rhai::{Engine, EvalAltResult, Module, ModuleResolver, Position, Scope, Shared};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

type SharedModule = Shared<Module>;
type Result<T> = std::result::Result<T, Box<EvalAltResult>>;

/// The embedded standard library: name after `std/`, text.
pub const STD: &[(&str, &str)] = &[
    ("algebraic", include_str!("../../stdlib/algebraic.rhai")),
    ("arrange", include_str!("../../stdlib/arrange.rhai")),
    ("blend", include_str!("../../stdlib/blend.rhai")),
    ("blobs", include_str!("../../stdlib/blobs.rhai")),
    ("color", include_str!("../../stdlib/color.rhai")),
    ("convolution", include_str!("../../stdlib/convolution.rhai")),
    ("csg", include_str!("../../stdlib/csg.rhai")),
    ("deform", include_str!("../../stdlib/deform.rhai")),
    ("displace", include_str!("../../stdlib/displace.rhai")),
    ("flow", include_str!("../../stdlib/flow.rhai")),
    ("fractal", include_str!("../../stdlib/fractal.rhai")),
    ("material", include_str!("../../stdlib/material.rhai")),
    ("morph", include_str!("../../stdlib/morph.rhai")),
    ("options", include_str!("../../stdlib/options.rhai")),
    ("pattern", include_str!("../../stdlib/pattern.rhai")),
    ("planet", include_str!("../../stdlib/planet.rhai")),
    ("shapes", include_str!("../../stdlib/shapes.rhai")),
    ("terrain", include_str!("../../stdlib/terrain.rhai")),
    ("texture", include_str!("../../stdlib/texture.rhai")),
    ("warp", include_str!("../../stdlib/warp.rhai")),
];

/// Modules whose functions need no import.
pub const PRELUDE: &[&str] = &["shapes", "csg"];

/// What a run has read.
#[derive(Default)]
pub struct Loaded {
    /// The folder of the main script.
    pub root: RefCell<PathBuf>,
    /// Texts by the name that messages use.
    pub sources: RefCell<Sources>,
    /// Files touched, found or not.
    pub files: RefCell<Vec<PathBuf>>,
    /// Modules by path, and the names of their functions.
    modules: RefCell<HashMap<String, (SharedModule, Vec<lexer::Documented>)>>,
    /// Imports in progress, for cycles.
    chain: RefCell<Vec<String>>,
    /// Functions that need no import.
    prelude: RefCell<Marks>,
    /// Modules that were built.
    built: Cell<usize>,
}

impl Loaded {
    /// Notes a text.
    pub fn source(&self, file: &str, text: &Arc<str>) {
        self.sources.borrow_mut().insert(Arc::from(file), text.clone());
    }

    /// Notes a file.
    pub fn touched(&self, file: &Path) {
        let mut files = self.files.borrow_mut();
        if !files.iter().any(|f| f == file) {
            files.push(file.to_owned());
        }
    }

    /// The functions of all modules that were imported.
    pub fn functions(&self) -> Vec<lexer::Documented> {
        self.modules.borrow().values().flat_map(|(_, functions)| functions.clone()).collect()
    }

    /// The functions of a module that was imported by a path.
    pub fn functions_of(&self, path: &str) -> Vec<lexer::Documented> {
        let path = path.strip_suffix(".rhai").unwrap_or(path);
        self.modules.borrow().get(path).map_or(Vec::new(), |(_, functions)| functions.clone())
    }

    /// Takes in the native functions that are known by marked names as well.
    pub fn learn_native(&self, functions: impl IntoIterator<Item = Function>) {
        self.prelude.borrow_mut().learn_native(functions);
    }

    /// Runs a text as a module.
    pub fn build(&self, engine: &Engine, name: &str, text: &str) -> Result<Module> {
        let number = self.built.get() + 1;
        self.built.set(number);
        let own = STD.iter().find(|(_, own)| *own == text).map(|(name, _)| *name);
        let check =
            |function: &lexer::Definition| own.map_or(String::new(), |own| arguments::check(own, function));
        let marked = self.prelude.borrow().put(text, number, check);
        let mut ast = engine.compile(marked).map_err(Box::<EvalAltResult>::from)?;
        ast.set_source(name);
        Module::eval_ast_as_new(Scope::new(), &ast, engine)
    }

    /// Runs a text as a module whose functions need no import; it imports none itself.
    pub fn build_prelude(&self, engine: &Engine, name: &str, text: &str) -> Result<Module> {
        let module = self.build(engine, name, text)?;
        self.prelude.borrow_mut().learn(text, self.built.get());
        Ok(module)
    }

    /// Forgets all modules, so that changed files are read again.
    pub fn clear(&self) {
        self.modules.borrow_mut().clear();
        self.built.set(PRELUDE.len());
    }
}

/// Reads modules, and other files of the main script's folder, through a world.
#[derive(Clone)]
pub struct Resolver {
    /// Where bytes come from.
    pub world: Arc<dyn World + Send + Sync>,
    /// Where they are looked for, and what was read.
    pub loaded: Rc<Loaded>,
}

impl ModuleResolver for Resolver {
    fn resolve(&self, engine: &Engine, _: Option<&str>, path: &str, pos: Position) -> Result<SharedModule> {
        let path = path.strip_suffix(".rhai").unwrap_or(path);
        if let Some((module, _)) = self.loaded.modules.borrow().get(path) {
            return Ok(module.clone());
        }
        self.refuse_cycle(path).map_err(|f| at(f, pos))?;
        let (name, text) = self.read(path).map_err(|f| at(f, pos))?;
        self.loaded.source(&name, &text);
        self.loaded.chain.borrow_mut().push(path.to_owned());
        let is_closed = slips::refuse_open_comment(&name, &text).map_err(Box::<EvalAltResult>::from);
        let module = is_closed.and_then(|()| self.loaded.build(engine, &name, &text));
        self.loaded.chain.borrow_mut().pop();
        let module: SharedModule =
            module.map_err(|e| Box::new(EvalAltResult::ErrorInModule(name.clone(), e, pos)))?.into();
        let functions = lexer::functions(&text);
        self.loaded.modules.borrow_mut().insert(path.to_owned(), (module.clone(), functions));
        Ok(module)
    }
}

fn at(fault: Fault, pos: Position) -> Box<EvalAltResult> {
    let mut error: Box<EvalAltResult> = fault.into();
    error.set_position(pos);
    error
}

impl Resolver {
    fn refuse_cycle(&self, path: &str) -> std::result::Result<(), Fault> {
        let chain = self.loaded.chain.borrow();
        let Some(start) = chain.iter().position(|p| p == path) else { return Ok(()) };
        let mut round: Vec<&str> = chain[start..].iter().map(String::as_str).collect();
        round.push(path);
        Err(Fault::new(format!("imports go round in a circle: {}", round.join(" -> ")))
            .hint("move what both need into a third file"))
    }

    /// The text of a module and the name that messages give it.
    fn read(&self, path: &str) -> std::result::Result<(String, Arc<str>), Fault> {
        if !is_inside(path) {
            return Err(outside(path).hint("imports name files in the folder of the main script or below, such as \"rocks/basalt\", or \"std/...\""));
        }
        let file = self.loaded.root.borrow().join(format!("{path}.rhai"));
        let shown = file.to_string_lossy().into_owned();
        match self.open(&file, |world, file| world.read(file))? {
            Ok(text) => Ok((shown, text)),
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                embedded(path).ok_or_else(|| self.missing(path, &shown))
            }
            Err(e) => Err(unreadable(&shown, &e)),
        }
    }

    /// The text of a file that is no module, and the name that messages give it.
    pub fn file(&self, path: &str) -> std::result::Result<(String, Arc<str>), Fault> {
        let (shown, text) = self.below(path, |world, file| world.read(file))?;
        self.loaded.source(&shown, &text);
        Ok((shown, text))
    }

    /// The bytes of a file that is no text, and the name that messages give it.
    pub fn bytes(&self, path: &str) -> std::result::Result<(String, Arc<[u8]>), Fault> {
        self.below(path, |world, file| world.bytes(file))
    }

    /// What is read from a file in the folder or below, and the name that messages give it.
    fn below<T>(
        &self,
        path: &str,
        read: impl FnOnce(&dyn World, &Path) -> io::Result<T>,
    ) -> std::result::Result<(String, T), Fault> {
        if !is_inside(path) {
            return Err(
                outside(path).hint("put the file into the folder of the main script, or a folder there")
            );
        }
        let file = self.loaded.root.borrow().join(path);
        let shown = file.to_string_lossy().into_owned();
        let found = self.open(&file, read)?.map_err(|e| unreadable(&shown, &e))?;
        Ok((shown, found))
    }

    /// Reads a file, and notes that it was asked for.
    fn open<T>(
        &self,
        file: &Path,
        read: impl FnOnce(&dyn World, &Path) -> io::Result<T>,
    ) -> std::result::Result<io::Result<T>, Fault> {
        self.loaded.touched(file);
        let found = read(&*self.world, file);
        if found.is_ok() {
            self.refuse_links_out(file)?;
        }
        Ok(found)
    }

    /// A link that leaves the folder would let a script read what is not its own. Only real files
    /// can be links; a world without them resolves nothing here.
    fn refuse_links_out(&self, file: &Path) -> std::result::Result<(), Fault> {
        let root = self.loaded.root.borrow();
        let root = if root.as_os_str().is_empty() { Path::new(".") } else { &root };
        match (root.canonicalize(), file.canonicalize()) {
            (Ok(root), Ok(real)) if !real.starts_with(&root) => {
                Err(Fault::new(format!("{} is a link that leads out of the script's folder", file.display())))
            }
            _ => Ok(()),
        }
    }

    fn missing(&self, path: &str, shown: &str) -> Fault {
        let fault = Fault::new(format!("there is no module \"{path}\""));
        let std = STD.iter().map(|(name, _)| format!("std/{name}")).collect::<Vec<_>>();
        if let Some(near) = diag::nearest(path, std.iter().map(String::as_str)) {
            return fault.hint(format!("did you mean \"{near}\"?"));
        }
        if path.starts_with("std/") {
            return fault.hint(format!("the standard library has {}", std.join(", ")));
        }
        fault.hint(format!("it was looked for in {shown}"))
    }
}

fn embedded(path: &str) -> Option<(String, Arc<str>)> {
    let name = path.strip_prefix("std/")?;
    let (_, text) = STD.iter().find(|(n, _)| *n == name)?;
    Some((format!("std/{name}.rhai"), Arc::from(*text)))
}

/// Only names of files below the folder are let through.
fn is_inside(path: &str) -> bool {
    let plain =
        |part: &str| !part.is_empty() && part != "." && part != ".." && !part.contains(['\\', ':', '\0']);
    path.split('/').all(plain)
}

fn outside(path: &str) -> Fault {
    Fault::new(format!("\"{path}\" is outside the script's folder"))
}

/// A file that is not there, or cannot be read.
pub fn unreadable(file: &str, e: &io::Error) -> Fault {
    match e.kind() {
        io::ErrorKind::NotFound => Fault::new(format!("there is no file {file}"))
            .hint("files are looked for in the folder of the main script, and below it"),
        io::ErrorKind::InvalidData => Fault::new(format!("{file} is not a text (UTF-8)")),
        _ => Fault::new(format!("{file} cannot be read: {e}")),
    }
}
