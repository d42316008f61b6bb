//! What `render` and `watch` have in common: a session, an order, and the files that come of them; and how
//! scripts are loaded that become something else.

use super::interrupt::{Flag, Interrupt};
use super::options::{PictureOptions, ScriptOptions};
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, count, in_quotes, out, plural, seconds};
use crate::cast::CastStats;
use crate::diag::Diagnostic;
use crate::render::{self, About, Heatmap, Metadata, Part, Picture};
use crate::scene::{Scene, Value};
use crate::session::{Digests, Loaded, Order, Session};
use crate::world::{Disk, atomic};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Everything that makes one picture again and again.
pub struct Work {
    /// The script.
    pub session: Session,
    /// What its picture is to be like.
    pub order: Order,
    /// Where the picture goes.
    pub output: PathBuf,
    /// Where the statistics go, if anywhere.
    pub stats: Option<PathBuf>,
}

impl Work {
    /// Checks the options, and that what will be written can be written.
    pub fn new(
        mut session: Session,
        script: &ScriptOptions,
        picture: &PictureOptions,
        stats: Option<&Path>,
    ) -> Result<Work, Failure> {
        session.set(script.params()?, script.time);
        let output = picture.output(session.script(), "png")?;
        if stats.is_some_and(|stats| is_same(stats, &output)) {
            let hint = "for example: --stats statistics.json";
            return Err(Failure::usage("picture and statistics would be the same file", hint));
        }
        render::can_save(&output).map_err(|e| Diagnostic::error(e.to_string()))?;
        if let Some(stats) = stats {
            atomic::check(stats).map_err(|e| Diagnostic::error(e.to_string()))?;
        }
        let size = picture.size.map(|size| (size.width, size.height));
        let PictureOptions { samples, caster, threads, .. } = *picture;
        let order = Order { size, samples, caster, threads, ..Order::default() };
        Ok(Work { session, order, output, stats: stats.map(Path::to_path_buf) })
    }

    /// Refuses a file that holds another of the shares of the picture that one of is wanted: together they are the
    /// picture, and one would be lost.
    pub fn keeps(&self, path: &Path, about: &About, known: &mut Digests) -> Outcome {
        let Part::Tile { number, of } = self.order.part else { return Ok(()) };
        let is_beside = self.order.part.is_beside(about.window, about.width, about.height);
        if !is_beside || self.session.departure(&about.recipe, &self.order, known).is_some() {
            return Ok(());
        }
        // Of frames it is a pattern.
        let own = beside(&self.output, &format!("{number}of{of}"));
        let message = format!("{} holds another of the {of} parts", path.display());
        Err(Failure::error(
            message,
            format!("give each a file of its own: -o {}", in_quotes(&own.to_string_lossy())),
        ))
    }

    /// Refuses to write what the script reads.
    pub fn spare(&self, loaded: &Loaded) -> Outcome {
        spare(loaded, [&self.output].into_iter().chain(&self.stats).map(PathBuf::as_path))
    }

    /// How a picture that is there is not the one that is wanted, finished; nothing if it is.
    pub fn departure(&self, about: &About, known: &mut Digests) -> Option<String> {
        self.session.departure(&about.recipe, &self.order, known).or_else(|| {
            let window = self.order.part.window(about.width, about.height).ok();
            (window != Some(about.window)).then(|| "it is another part of the picture".to_owned())
        })
    }

    /// Saves what the pixels of a picture cost, in place of the picture. Returns the file that was
    /// written.
    pub fn save_heatmap(&self, picture: &Picture) -> Result<PathBuf, Failure> {
        let path = place(&self.output, picture);
        let figure = Heatmap::of(picture).draw().map_err(|e| Diagnostic::error(e.to_string()))?;
        atomic::write(&path, |f| figure.write_png(f)).map_err(|e| Diagnostic::error(e.to_string()))?;
        Ok(path)
    }

    /// Saves a picture. Returns the file that was written.
    pub fn save(&self, loaded: &Loaded, scene: &Scene, picture: &Picture) -> Result<PathBuf, Failure> {
        let path = place(&self.output, picture);
        self.save_to(&path, loaded, scene, picture)?;
        Ok(path)
    }

    /// Saves a picture to a file, unless the script reads it.
    pub fn save_to(
        &self,
        path: &Path,
        loaded: &Loaded,
        scene: &Scene,
        picture: &Picture,
    ) -> Result<(), Failure> {
        spare(loaded, [path])?;
        let script = loaded.sources.get(&*self.session.script().to_string_lossy());
        let metadata = Metadata {
            script: script.map(|text| text.to_string()).unwrap_or_default(),
            params: scene.params.iter().map(|p| (p.name.clone(), p.value.clone())).collect(),
            recipe: self.session.recipe(loaded, &self.order),
        };
        let saved = render::save_as(path, picture, &metadata, self.order.precision);
        Ok(saved.map_err(|e| Diagnostic::error(e.to_string()))?)
    }

    /// Writes the statistics, if they are wanted.
    pub fn save_stats(&self, file: &Path, scene: &Scene, picture: &Picture) -> Result<(), Failure> {
        let Some(path) = &self.stats else { return Ok(()) };
        let statistics = Statistics::new(self, file, scene, picture);
        let text = serde_json::to_string_pretty(&statistics)
            .map_err(|e| Diagnostic::error(format!("cannot write the statistics ({e})")))?;
        let path = place(path, picture);
        atomic::write(&path, |f| writeln!(f, "{text}")).map_err(|e| Diagnostic::error(e.to_string()))?;
        Ok(())
    }
}

/// Where something of a picture goes: what is of an unfinished one never takes the place of an earlier file, but that of
/// `NAME.partial.png`, or the first name with a number that is free.
pub fn place(path: &Path, picture: &Picture) -> PathBuf {
    if picture.finished || !path.exists() {
        return path.to_owned();
    }
    let named = |number: u32| match number {
        1 => beside(path, "partial"),
        _ => beside(path, &format!("partial{number}")),
    };
    (1..).map(named).find(|name| !name.exists()).unwrap_or_else(|| named(1))
}

/// `a.3.png` for `a.png` and 3.
pub fn beside(path: &Path, what: &str) -> PathBuf {
    let ending = path.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    path.with_extension(format!("{what}{ending}"))
}

/// A script that is to become something other than a picture, and what watches over that.
pub struct Conversion {
    /// What was loaded.
    pub loaded: Arc<Loaded>,
    /// Its scene.
    pub scene: Arc<Scene>,
    /// How far it is.
    pub progress: Progress,
    /// Raised when it is to stop.
    pub flag: Flag,
}

impl Conversion {
    /// Loads a script for the sake of a file, and says what is wrong with it.
    pub fn begin(
        script: &Path,
        scripting: &ScriptOptions,
        output: &Path,
        terminal: &Terminal,
    ) -> Result<Conversion, Failure> {
        let mut session = Session::new(script, Arc::new(Disk));
        session.set(scripting.params()?, scripting.time);
        let progress = Progress::new(terminal, &output.display().to_string());
        let flag = Interrupt::stopping(&progress).flag();
        let loaded = session.load(&flag);
        let scene = progress.aside(|| report(&loaded, terminal)).ok_or(Failure::Reported)?;
        Ok(Conversion { loaded, scene, progress, flag })
    }
}

/// Refuses to write files that a script reads: they would be lost.
pub fn spare<'a>(loaded: &Loaded, outputs: impl IntoIterator<Item = &'a Path>) -> Outcome {
    for output in outputs {
        if loaded.files().any(|file| is_same(file, output)) {
            let message = format!("the script reads {}, which would be lost", output.display());
            return Err(Failure::error(message, "give another name for what is made"));
        }
    }
    Ok(())
}

/// Whether two names are of one file: by where they lead if both are there, else as far as their texts tell.
pub fn is_same(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => matches!((std::path::absolute(a), std::path::absolute(b)), (Ok(a), Ok(b)) if a == b),
    }
}

/// Says what a script printed and what is wrong with it.
pub fn report(loaded: &Loaded, terminal: &Terminal) -> Option<Arc<Scene>> {
    loaded.output.iter().for_each(out);
    for diagnostic in &loaded.diagnostics {
        terminal.diagnostic(diagnostic, &loaded.sources);
    }
    loaded.scene.clone()
}

/// Says why no picture can be made.
pub fn failure(error: Box<Diagnostic>, loaded: &Loaded, terminal: &Terminal) -> Failure {
    terminal.diagnostic(&error, &loaded.sources);
    Failure::Reported
}

/// Says what is odd about a picture.
pub fn report_warnings(loaded: &Loaded, picture: &Picture, terminal: &Terminal) {
    for warning in &picture.warnings {
        terminal.diagnostic(warning, &loaded.sources);
    }
}

/// `rock.png: 800x600, 1.2 s, 1 234 567 rays`; of what it is a part, and how many of them are not certified, if any.
pub fn summary(file: &Path, picture: &Picture, elapsed: f64) -> String {
    let stats = &picture.stats;
    let rays = stats.primary.rays + stats.shadow.rays;
    let size = format!("{}x{}", picture.width, picture.height);
    let size = if picture.is_whole() { size } else { format!("{} of {size}", picture.window) };
    let mut line = format!("{}: {size}, {}, {}", file.display(), seconds(elapsed), plural(rays, "ray"));
    match stats.uncertified() {
        0 => {}
        n => line += &format!(", {} uncertified", count(n)),
    }
    line
}

/// What `--stats` writes.
#[derive(Serialize)]
struct Statistics<'a> {
    file: String,
    script: String,
    params: BTreeMap<&'a str, &'a Value>,
    width: u32,
    height: u32,
    samples: u32,
    caster: crate::cast::Kind,
    complete: bool,
    seconds: f64,
    cast: CastStats,
    render: &'a render::Stats,
}

impl<'a> Statistics<'a> {
    fn new(work: &Work, file: &Path, scene: &'a Scene, picture: &'a Picture) -> Self {
        let mut cast = picture.stats.primary;
        cast += picture.stats.shadow;
        Statistics {
            file: file.display().to_string(),
            script: work.session.script().display().to_string(),
            params: scene.params.iter().map(|p| (p.name.as_str(), &p.value)).collect(),
            width: picture.width,
            height: picture.height,
            samples: work.order.samples.unwrap_or(scene.film.samples),
            caster: work.order.caster,
            complete: picture.finished,
            seconds: picture.stats.seconds.wall,
            cast,
            render: &picture.stats,
        }
    }
}
