//! Sessions: one script with the changes that its user makes to it, kept up to date.
//!
//! ```text
//! script + parameters + time --load--> Scene --render--> Picture
//!     ^                        |
//!     '--- is_stale? <-- files that were read
//! ```
//!
//! A scene also becomes a mesh ([`polygonise`]), samples of a volume ([`Lattice`]) or of a [`Plane`], or a map of
//! its [`heights`]. What its script costs, line by line, is told by a [`profile`], and what is at a pixel of its picture
//! by [`picking`]. Pictures that people watch and steer are [`live`]; those with other parameters beside one another are
//! for [`explore`].
//!
//! A session knows which files its scene came from, so [`Session::load`] does nothing as long as
//! none of them changed, and a watcher knows what to watch. Commands, previews and tests all make
//! their pictures through it.

mod doubts;
pub mod explore;
pub mod heights;
mod ledger;
pub mod live;
mod moments;
pub mod picking;
mod plane;
mod preview;
pub mod profile;
mod reads;
mod recipe;
mod samples;
mod solid;
mod stage;
pub mod topology;
mod whereabouts;

pub use doubts::{Doubts, doubts};
pub use ledger::Line;
pub use plane::{Plane, along};
pub use preview::{COARSENESS, preview};
pub use recipe::Digests;
pub use samples::{Lattice, Sampled};
pub use solid::{Solidified, polygonise};
pub use stage::{Order, on_threads, refine, render, settings, stopped};
pub use whereabouts::{Whereabouts, bounds, locate};

use crate::diag::{Diagnostic, Place, Sources};
use crate::scene::{Scene, Value};
use crate::script::{self, Request, Script};
use crate::world::World;
use reads::{Reads, Recorder};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a script came to.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene, unless there are errors.
    pub scene: Option<Arc<Scene>>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Texts of the files that the diagnostics are about.
    pub sources: Sources,
    /// What the script printed, line by line.
    pub output: Vec<String>,
    reads: Reads,
}

impl Loaded {
    /// The files that were read, or looked for.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.reads.files()
    }
}

/// A script with its parameters, and the scene that they make.
#[derive(Clone)]
pub struct Session {
    script: PathBuf,
    params: BTreeMap<String, Value>,
    /// Whether the script has to ask for all of them.
    strict: bool,
    time: f64,
    world: Arc<dyn World + Send + Sync>,
    loaded: Option<Arc<Loaded>>,
}

impl Session {
    /// A session on a script of a world, which is not read yet.
    pub fn new(script: impl Into<PathBuf>, world: Arc<dyn World + Send + Sync>) -> Session {
        Session {
            script: script.into(),
            params: BTreeMap::new(),
            strict: true,
            time: 0.0,
            world,
            loaded: None,
        }
    }

    /// The script.
    pub fn script(&self) -> &Path {
        &self.script
    }

    /// Sets parameters and time; the scene is made anew if that changes them.
    pub fn set(&mut self, params: BTreeMap<String, Value>, time: f64) {
        if params != self.params || time != self.time {
            self.loaded = None;
        }
        (self.params, self.time) = (params, time);
    }

    /// The script's result: made now if there is none, or if a file changed that it came from.
    /// Raise `cancel` to give up.
    pub fn load(&mut self, cancel: &Arc<AtomicBool>) -> Arc<Loaded> {
        match &self.loaded {
            Some(loaded) if !loaded.reads.changed_in(self.world.as_ref()) => loaded.clone(),
            _ => {
                let loaded = Arc::new(self.compile(self.time, cancel));
                // What was given up says nothing about the script.
                self.loaded = (!cancel.load(Ordering::SeqCst)).then(|| loaded.clone());
                loaded
            }
        }
    }

    /// Whether the result is missing, or a file changed that it came from.
    pub fn is_stale(&self) -> bool {
        self.loaded.as_ref().is_none_or(|loaded| loaded.reads.changed_in(self.world.as_ref()))
    }

    /// The files that the result depends on, also those that should be there and are not.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.script.clone()];
        if let Some(loaded) = &self.loaded {
            files.extend(loaded.files().map(Path::to_path_buf).filter(|file| *file != self.script));
        }
        files
    }

    fn compile(&self, time: f64, cancel: &Arc<AtomicBool>) -> Loaded {
        let world = Arc::new(Recorder::new(self.world.clone()));
        let request = self.request(world.clone(), time, cancel);
        let compiled = script::compile(&request);
        Loaded {
            scene: compiled.scene.map(Arc::new),
            diagnostics: compiled.diagnostics.into_iter().map(|d| self.placed(d)).collect(),
            sources: compiled.sources,
            output: compiled.output,
            reads: world.reads(),
        }
    }

    /// What is to be run, with the files of a world.
    fn request(&self, world: Arc<dyn World + Send + Sync>, time: f64, cancel: &Arc<AtomicBool>) -> Request {
        Request {
            params: self.params.clone(),
            strict: self.strict,
            time,
            cancel: Some(cancel.clone()),
            ..Request::new(Script::File(self.script.clone()), world)
        }
    }

    /// A diagnostic that at least names the script; for a script that is not there, with a hint.
    fn placed(&self, mut d: Diagnostic) -> Diagnostic {
        let name = self.script.to_string_lossy();
        if d.place.is_none() && !d.message.contains(&*name) {
            return d.at(Place { file: Arc::from(&*name), line: 0, column: 0, width: 1 });
        }
        let there = |path: &Path| self.world.read(path).is_ok();
        if d.place.is_none() && d.hints.is_empty() && !there(&self.script) {
            let ending = self.script.with_extension("rhai");
            d = d.hint(if there(&ending) {
                format!("did you mean {}?", ending.display())
            } else {
                "a script is a text file in UTF-8, such as rock.rhai; paths start in the current folder"
                    .into()
            });
        }
        d
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Memory;
    use std::io;
    use std::sync::Mutex;

    /// Files in memory that change.
    #[derive(Default)]
    struct Changing(Mutex<Memory>);

    impl Changing {
        fn write(&self, file: &str, text: &str) {
            self.0.lock().unwrap().0.insert(file.into(), text.into());
        }
    }

    impl World for Changing {
        fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
            self.0.lock().unwrap().bytes(path)
        }
    }

    #[test]
    fn a_scene_is_made_again_only_when_something_changed() {
        let world = Arc::new(Changing::default());
        world.write("a.rhai", "import \"b\" as b; sphere(b::r())");
        world.write("b.rhai", "fn r() { 1.0 }");
        let mut session = Session::new("a.rhai", world.clone());
        let cancel = Arc::default();
        assert!(session.is_stale());
        let first = session.load(&cancel);
        assert!(first.scene.is_some(), "{:?}", first.diagnostics);
        world.write("c.rhai", "not read");
        assert!(!session.is_stale() && Arc::ptr_eq(&first, &session.load(&cancel)));
        world.write("b.rhai", "fn r() { 2.0 }");
        assert!(session.is_stale());
        let second = session.load(&cancel);
        assert!(!Arc::ptr_eq(&first, &second));
        session.set([("x".to_owned(), 1.0.into())].into(), 0.0);
        assert!(session.load(&cancel).scene.is_none());
        assert!(session.files().iter().any(|file| file.ends_with("b.rhai")));
    }

    #[test]
    fn a_file_that_is_missing_is_waited_for() {
        let world = Arc::new(Changing::default());
        let mut session = Session::new("a.rhai", world.clone());
        assert!(session.load(&Arc::default()).scene.is_none());
        assert!(!session.is_stale());
        world.write("a.rhai", "sphere(1.0)");
        assert!(session.is_stale());
        assert!(session.load(&Arc::default()).scene.is_some());
    }
}
