//! Many frames of one script, each at its time: those that are there already are left alone.
//!
//! A frame counts as there if its file is whole and has the recipe that it would have now (see `session/recipe.rs`).
//! So the same command goes on after whatever ended it, and several processes, given the same command, share the work:
//! each frame is claimed by one of them.

use super::frames::{Frames, Pattern};
use super::interrupt::{Flag, Interrupt};
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err, in_quotes, out, plural, seconds};
use super::work::{self, Work};
use crate::diag::{self, Diagnostic};
use crate::render::{self, Job, OpenError, Picture, Saved};
use crate::scene::Value;
use crate::session::{Digests, Loaded};
use crate::world::claim::Claim;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Numbers of frames that a message says.
const LISTED: usize = 8;

/// How often a frame that another process makes is looked after.
const POLL: Duration = Duration::from_millis(100);

/// What an animation is of.
pub struct Animation<'a> {
    /// What each frame is made with.
    pub work: Work,
    /// Parameters of the script.
    pub params: BTreeMap<String, Value>,
    /// Which frames.
    pub frames: Frames,
    /// Frames a second.
    pub rate: f64,
    /// Time of frame 0, in seconds.
    pub offset: f64,
    /// Their files.
    pub pattern: Pattern,
    /// Whom to tell.
    pub terminal: &'a Terminal,
}

/// What became of a frame.
enum Fate {
    /// It was made.
    Made,
    /// It was there.
    There,
    /// Another process makes it.
    Elsewhere,
    /// It is not there, since the job was stopped.
    Stopped,
    /// It cannot be made, as was said.
    Failed,
}

/// What is known of a frame before it is made.
enum Finding {
    /// It is there.
    Finished,
    /// There is nothing, or something that will be replaced, and why.
    Wanted(Option<String>),
}

/// An animation being made.
struct Run<'a> {
    animation: Animation<'a>,
    progress: Progress,
    flag: Flag,
    /// What was said; a warning about every frame is said once.
    said: BTreeSet<String>,
    /// Frames to make, and how many of them are there by now.
    wanted: usize,
    done: usize,
    /// Those that cannot be made.
    failed: Vec<u32>,
}

/// Makes all frames.
pub fn run(animation: Animation<'_>) -> Outcome {
    let start = Instant::now();
    let progress = Progress::new(animation.terminal, "looking for finished frames");
    let bar = progress.clone();
    let interrupt =
        Interrupt::listen(move || bar.say("stopping; finished frames are kept (Ctrl-C again quits at once)"));
    let all = animation.frames.numbers().count();
    let (flag, said, failed) = (interrupt.flag(), BTreeSet::new(), Vec::new());
    let mut run = Run { animation, progress, flag, said, wanted: 0, done: 0, failed };
    let made = run.all();
    run.progress.finish();
    let made = made?;
    let there = all - (run.wanted - run.done);
    if !run.failed.is_empty() && !run.flag.load(Ordering::Relaxed) {
        return Err(run.failure(there, all));
    }
    if there < all {
        let message = format!("stopped; {there} of {} are finished", plural(all as u64, "frame"));
        return Err(Failure::error(message, "the same command goes on with the others"));
    }
    run.report(made, all - made, start.elapsed().as_secs_f64());
    Ok(())
}

impl Run<'_> {
    /// Makes the frames that are to be made, and counts them: first those that nobody makes, then what others began
    /// and may have left.
    fn all(&mut self) -> Result<usize, Failure> {
        let todo = self.todo()?;
        self.wanted = todo.len();
        let (mut made, mut elsewhere) = (0, Vec::new());
        for number in todo {
            match self.frame(number, false)? {
                Fate::Made => made += 1,
                Fate::Elsewhere => elsewhere.push(number),
                Fate::There | Fate::Stopped | Fate::Failed => {}
            }
        }
        for number in elsewhere {
            made += usize::from(matches!(self.frame(number, true)?, Fate::Made));
        }
        Ok(made)
    }

    /// The frames that are to be made. Says if some are there that are not these.
    fn todo(&mut self) -> Result<Vec<u32>, Failure> {
        let (mut todo, mut replaced, mut digests) = (Vec::new(), Vec::new(), Digests::new());
        for number in self.animation.frames.numbers() {
            if self.flag.load(Ordering::Relaxed) {
                return Err(Failure::error("stopped before a frame was made", "no file was written"));
            }
            match self.find(number, &mut digests)? {
                Finding::Finished => {
                    let tidied = Claim::tidy(&self.animation.pattern.path(number));
                    tidied.map_err(|e| Diagnostic::error(e.to_string()))?;
                }
                Finding::Wanted(reason) => {
                    todo.push(number);
                    replaced.extend(reason.map(|reason| (number, reason)));
                }
            }
        }
        if let Some((first, reason)) = replaced.first() {
            let name = self.animation.pattern.path(*first);
            let more = match replaced.len() - 1 {
                0 => String::new(),
                n => format!(" (and {n} more)"),
            };
            self.progress.say(&format!("{}{more} is made again: {reason}", name.display()));
        }
        Ok(todo)
    }

    /// Whether a frame is there.
    fn find(&mut self, number: u32, digests: &mut Digests) -> Result<Finding, Failure> {
        let (path, time) = (self.animation.pattern.path(number), self.animation.time(number));
        self.animation.work.session.set(self.animation.params.clone(), time);
        let work = &self.animation.work;
        let about = match Saved::open(&path) {
            Ok(saved) => saved.about,
            Err(OpenError::Unreadable { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
                return Ok(Finding::Wanted(None));
            }
            Err(OpenError::Foreign(_)) => return Ok(Finding::Wanted(Some("orogen did not make it".into()))),
            Err(OpenError::Damaged { .. }) => return Ok(Finding::Wanted(Some("it is damaged".into()))),
            Err(error) => return Err(Diagnostic::error(error.to_string()).into()),
        };
        work.keeps(&path, &about, digests)?;
        let reason = work.departure(&about, digests);
        Ok(reason.map_or(Finding::Finished, |reason| Finding::Wanted(Some(reason))))
    }

    /// Makes a frame; if another process does, waits for it or goes away.
    fn frame(&mut self, number: u32, waits: bool) -> Result<Fate, Failure> {
        let path = self.animation.pattern.path(number);
        self.progress.rename(&format!("{} ({} of {})", path.display(), self.tried() + 1, self.wanted));
        let _claim = loop {
            if self.flag.load(Ordering::Relaxed) {
                return Ok(Fate::Stopped);
            }
            match Claim::take(&path).map_err(|e| Diagnostic::error(e.to_string()))? {
                Some(claim) => break claim,
                None if waits => std::thread::sleep(POLL),
                None => return Ok(Fate::Elsewhere),
            }
        };
        let fate = match self.find(number, &mut Digests::new())? {
            Finding::Finished => Fate::There,
            Finding::Wanted(_) => self.make(number, &path)?,
        };
        match fate {
            Fate::Stopped => return Ok(fate),
            Fate::Failed => self.failed.push(number),
            _ => self.done += 1,
        }
        self.progress.set(self.tried() as f64 / self.wanted as f64);
        Ok(fate)
    }

    /// Makes a frame that is claimed.
    fn make(&mut self, number: u32, path: &Path) -> Result<Fate, Failure> {
        let loaded = self.animation.work.session.load(&self.flag);
        let stopped = |run: &Self| run.flag.load(Ordering::Relaxed);
        if stopped(self) {
            return Ok(Fate::Stopped);
        }
        self.say(number, &loaded, &loaded.diagnostics, &loaded.output);
        let Some(scene) = loaded.scene.clone() else { return Ok(Fate::Failed) };
        work::spare(&loaded, [path])?;
        let (progress, done, wanted) = (&self.progress, self.tried() as f64, self.wanted as f64);
        let step =
            |p: render::Progress| progress.set((done + p.done as f64 / p.total.max(1) as f64) / wanted);
        let job = Job { progress: &step, ..Job::unwatched(&self.flag) };
        let Work { session, order, .. } = &self.animation.work;
        match session.render(&scene, order, &job, &self.flag) {
            Ok(Picture { finished: false, .. }) => Ok(Fate::Stopped),
            Ok(picture) => {
                self.say(number, &loaded, &picture.warnings, &[]);
                self.animation.work.save_to(path, &loaded, &scene, &picture)?;
                Ok(Fate::Made)
            }
            Err(_) if stopped(self) => Ok(Fate::Stopped),
            Err(error) => {
                self.say(number, &loaded, &[*error], &[]);
                Ok(Fate::Failed)
            }
        }
    }

    /// Frames that are there by now, or cannot be made.
    fn tried(&self) -> usize {
        self.done + self.failed.len()
    }

    /// Says of a frame what was not said of another one.
    fn say(&mut self, number: u32, loaded: &Loaded, diagnostics: &[Diagnostic], output: &[String]) {
        let Run { progress, said, animation, .. } = self;
        progress.aside(|| {
            for line in output.iter().filter(|line| said.insert(format!("print {line}"))) {
                out(line);
            }
            let is_new = |d: &&Diagnostic| said.insert(diag::render(d, &loaded.sources, false));
            let new: Vec<&Diagnostic> = diagnostics.iter().filter(is_new).collect();
            if !new.is_empty() {
                err(format!("frame {number}, at {} s:", animation.time(number)));
            }
            for diagnostic in new {
                animation.terminal.diagnostic(diagnostic, &loaded.sources);
            }
        });
    }

    /// That frames cannot be made, whose diagnostics are out.
    fn failure(&self, there: usize, all: usize) -> Failure {
        let failed: BTreeSet<u32> = self.failed.iter().copied().collect();
        let mut numbers: Vec<String> = failed.iter().take(LISTED).map(u32::to_string).collect();
        if failed.len() > LISTED {
            numbers.push(format!("{} more", failed.len() - LISTED));
        }
        let frames = plural(all as u64, "frame");
        let message = format!("{} of {frames} cannot be made ({})", failed.len(), numbers.join(", "));
        Failure::error(
            message,
            format!("{there} of {frames} are finished; the same command tries the others again"),
        )
    }

    /// Says what there is now, and how to go on.
    fn report(&self, made: usize, there: usize, elapsed: f64) {
        let Animation { pattern, frames, rate, work, .. } = &self.animation;
        let first = pattern.path(frames.first());
        let last = frames.numbers().last().map(|n| pattern.path(n)).unwrap_or_default();
        let kept = if there > 0 { format!(", {there} were there") } else { String::new() };
        let made = plural(made as u64, "frame");
        err(format!("{} to {}: {made} in {}{kept}", first.display(), last.display(), seconds(elapsed)));
        let is_video = frames.are_consecutive() && work.order.part == render::Part::Whole;
        if is_video && first.extension().is_some_and(|e| e == "png") {
            let (frames, video) = (&work.output, &video_of(&work.output));
            let [frames, video] = [frames, video].map(|path| in_quotes(&path.to_string_lossy()));
            err(format!("\nTry:\n  orogen video {frames} -o {video} --fps {rate}"));
        }
    }
}

/// A place for the video of frames: named as they are without their numbers, or as their folder, and beside it, if they
/// have nothing but numbers.
fn video_of(frames: &Path) -> PathBuf {
    let stem = frames.file_stem().unwrap_or_default().to_string_lossy().replace('#', "");
    let name = stem.trim_end_matches(['.', '-', '_', ' ']);
    let folder = frames.parent().and_then(|folder| Some((folder, folder.file_name()?.to_string_lossy())));
    match folder {
        _ if !name.is_empty() => frames.with_file_name(format!("{name}.mp4")),
        Some((folder, name)) => folder.with_file_name(format!("{name}.mp4")),
        None => frames.with_file_name("video.mp4"),
    }
}

impl Animation<'_> {
    /// The time of a frame, in seconds.
    fn time(&self, number: u32) -> f64 {
        self.offset + f64::from(number) / self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn videos_are_named_after_their_frames() {
        for (frames, video) in [
            ("a.####.png", "a.mp4"),
            ("out/the rock-###.png", "out/the rock.mp4"),
            ("x/zoom/####.png", "x/zoom.mp4"),
            ("####.png", "video.mp4"),
            ("../####.png", "../video.mp4"),
        ] {
            assert_eq!(video_of(Path::new(frames)), Path::new(video));
        }
    }
}
