//! The script that is explored: drawn with any parameters, and written with them as its defaults.

use crate::diag::Diagnostic;
use crate::render::{self, Job, Metadata, Picture};
use crate::scene::{Param, Scene, Value};
use crate::script::{Request, rewrite};
use crate::session::reads::Recorder;
use crate::session::{Loaded, Order, Session};
use crate::world::World;
use crate::world::store::Store;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What one picture is made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Genome {
    /// What parameters have another value than the script gives them, by name.
    pub values: BTreeMap<String, Value>,
    /// The text, where its expressions differ from those of the script.
    pub text: Option<Arc<str>>,
}

/// A world in which one file holds something else.
struct Edited {
    world: Arc<dyn World + Send + Sync>,
    file: PathBuf,
    text: Arc<str>,
}

impl World for Edited {
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        if path == self.file { Ok(Arc::from(self.text.as_bytes())) } else { self.world.bytes(path) }
    }

    fn store(&self) -> Option<Store> {
        self.world.store()
    }
}

/// A script, and what it came to with the parameters that are fixed.
#[derive(Clone)]
pub struct Subject {
    session: Session,
    loaded: Arc<Loaded>,
    scene: Arc<Scene>,
}

/// Has a session see its files as they are when they are read first, so that all of a gallery is of the same script.
pub fn freeze(session: &mut Session) {
    session.world = Arc::new(Recorder::new(session.world.clone()));
}

impl Subject {
    /// Of a session and what it came to.
    pub fn new(session: Session, loaded: Arc<Loaded>, scene: Arc<Scene>) -> Subject {
        Subject { session, loaded, scene }
    }

    /// The parameters of the script.
    pub fn params(&self) -> &[Param] {
        &self.scene.params
    }

    /// The parameters that are the same for all.
    pub fn fixed(&self) -> BTreeMap<String, Value> {
        let set = self.params().iter().filter(|p| self.session.params.contains_key(&p.name));
        set.map(|p| (p.name.clone(), p.value.clone())).collect()
    }

    /// Width and height that a picture with a width has if it is shaped as the script wants it.
    pub fn size(&self, width: u32) -> (u32, u32) {
        let film = &self.scene.film;
        let height = f64::from(width) * f64::from(film.height) / f64::from(film.width);
        (width, (height.round() as u32).max(1))
    }

    /// Whether the script reads files of its author, next to which its copies have to stay.
    pub fn has_company(&self) -> bool {
        self.loaded
            .reads
            .contents()
            .filter(|(path, bytes)| bytes.is_some() && *path != self.session.script)
            .count()
            > 0
    }

    /// The session of one picture.
    pub(super) fn session(&self, genome: &Genome) -> Session {
        let mut session = self.session.clone();
        let mut params = session.params.clone();
        params.extend(genome.values.clone());
        session.set(params, session.time);
        // With some values there may be no others.
        session.strict = false;
        if let Some(text) = &genome.text {
            let (world, file) = (session.world.clone(), session.script.clone());
            session.world = Arc::new(Edited { world, file, text: text.clone() });
            session.loaded = None;
        }
        session
    }

    /// What is to be run to find out about a text.
    pub(super) fn request(&self, text: Option<&Arc<str>>, cancel: &Arc<AtomicBool>) -> Request {
        let session = self.session(&Genome { text: text.cloned(), ..Genome::default() });
        session.request(session.world.clone(), session.time, cancel)
    }

    /// One picture, as the bytes of a PNG; `None` if it was cancelled.
    ///
    /// # Errors
    /// What is wrong with the script, or with its picture, if they are like that.
    pub fn draw(
        &self,
        genome: &Genome,
        order: &Order,
        cancel: &Arc<AtomicBool>,
    ) -> Result<Option<Vec<u8>>, Box<Diagnostic>> {
        let (session, scene) = self.scene(genome, cancel)?;
        let picture = session.render(&scene, &order.at_once(), &Job::unwatched(cancel), cancel)?;
        picture.finished.then(|| self.encoded(genome, &scene, &picture)).transpose()
    }

    /// The scene of one picture.
    pub(super) fn scene(
        &self,
        genome: &Genome,
        cancel: &Arc<AtomicBool>,
    ) -> Result<(Session, Arc<Scene>), Box<Diagnostic>> {
        let mut session = self.session(genome);
        let loaded = session.load(cancel);
        let Some(scene) = &loaded.scene else {
            let error = loaded.diagnostics.iter().find(|d| d.severity == crate::diag::Severity::Error);
            let unknown = || Diagnostic::error("the script has an error with these values");
            return Err(Box::new(error.cloned().unwrap_or_else(unknown)));
        };
        Ok((session, scene.clone()))
    }

    /// The bytes of a PNG.
    pub(super) fn encoded(
        &self,
        genome: &Genome,
        scene: &Scene,
        picture: &Picture,
    ) -> Result<Vec<u8>, Box<Diagnostic>> {
        let metadata = Metadata {
            script: self.text(genome).unwrap_or_default().to_owned(),
            params: scene.params.iter().map(|p| (p.name.clone(), p.value.clone())).collect(),
            ..Metadata::default()
        };
        render::png_bytes(picture, &metadata)
            .map_err(|e| Box::new(Diagnostic::error(format!("the picture cannot be encoded ({e})"))))
    }

    /// The script of one picture, with its values as the defaults of its parameters; `None` if it has no text.
    pub fn export(&self, genome: &Genome) -> Option<String> {
        let text = self.text(genome)?.to_owned();
        let value = |p: &Param| genome.values.get(&p.name).unwrap_or(&p.value).clone();
        let params: Vec<_> = self.params().iter().map(|p| Param { value: value(p), ..p.clone() }).collect();
        if params.iter().all(|p| p.value == p.default) {
            return Some(text);
        }
        // All of them: a default may be computed from values that have changed.
        let mut texts = [text];
        let script = &self.session.script;
        let modules = self.loaded.reads.scripts(script).filter(|(path, _)| path != script);
        let modules: Vec<&str> = modules.map(|(_, text)| text).collect();
        // Whatever is new comes first, so the last of them is written first.
        params.iter().rev().for_each(|param| rewrite::write_default(&mut texts, &modules, param));
        let [text] = texts;
        Some(text)
    }

    /// The text of one picture.
    pub(super) fn text<'a>(&'a self, genome: &'a Genome) -> Option<&'a str> {
        genome.text.as_deref().or_else(|| self.own_text())
    }

    /// The text of the script.
    fn own_text(&self) -> Option<&str> {
        self.loaded.sources.get(&*self.session.script.to_string_lossy()).map(|text| &**text)
    }
}
