//! The script that is explored: drawn with any parameters, and written with them as its defaults.

use crate::diag::Diagnostic;
use crate::render::{self, Job, Metadata};
use crate::scene::{Param, Scene, Value};
use crate::script::rewrite;
use crate::session::reads::Recorder;
use crate::session::{Loaded, Order, Session};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

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

    /// The picture with other parameters, as the bytes of a PNG; `None` if it was cancelled.
    ///
    /// # Errors
    /// What is wrong with the script, or with its picture, if they have these values.
    pub fn draw(
        &self,
        values: &BTreeMap<String, Value>,
        order: &Order,
        cancel: &Arc<AtomicBool>,
    ) -> Result<Option<Vec<u8>>, Box<Diagnostic>> {
        let mut session = self.session.clone();
        let mut params = session.params.clone();
        params.extend(values.clone());
        session.set(params, session.time);
        let loaded = session.load(cancel);
        let Some(scene) = &loaded.scene else {
            let error = loaded.diagnostics.iter().find(|d| d.severity == crate::diag::Severity::Error);
            let unknown = || Diagnostic::error("the script has an error with these values");
            return Err(Box::new(error.cloned().unwrap_or_else(unknown)));
        };
        let picture = session.render(scene, &order.at_once(), &Job::unwatched(cancel), cancel)?;
        if !picture.finished {
            return Ok(None);
        }
        let metadata = Metadata {
            script: self.text().unwrap_or_default().to_owned(),
            params: scene.params.iter().map(|p| (p.name.clone(), p.value.clone())).collect(),
            ..Metadata::default()
        };
        render::png_bytes(&picture, &metadata)
            .map(Some)
            .map_err(|e| Box::new(Diagnostic::error(format!("the picture cannot be encoded ({e})"))))
    }

    /// The script with other values as the defaults of its parameters.
    ///
    /// # Errors
    /// If one of them cannot be written into its text.
    pub fn export(&self, values: &BTreeMap<String, Value>) -> Result<String, Box<Diagnostic>> {
        let text = self.text().ok_or_else(|| Box::new(Diagnostic::error("the script has no text")))?;
        let value = |p: &Param| values.get(&p.name).unwrap_or(&p.value).clone();
        let changed = self.params().iter().map(|p| Param { value: value(p), ..p.clone() });
        changed
            .filter(|p| p.value != p.default)
            .try_fold(text.to_owned(), |text, param| rewrite::with_default(&text, &param))
    }

    /// The text of the script.
    fn text(&self) -> Option<&str> {
        self.loaded.sources.get(&*self.session.script.to_string_lossy()).map(|text| &**text)
    }
}
