//! The thread that draws.

use super::wish::{LARGEST, Message, Report, Stage, Wish};
use super::{Event, Finished, Running, Shared, State, Subject};
use crate::cast::Kind;
use crate::diag::{Diagnostic, Severity};
use crate::field::Watch;
use crate::render::{Fine, Job, Layer, Look, Picture, Progress, Rect, Rough, Steering, View};
use crate::scene::{Keep, Measure, Scene, Value};
use crate::script::rewrite;
use crate::session::topology::{self, Analysis, Purpose, Show};
use crate::session::{COARSENESS, Loaded, Order, Session, preview};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often people are told how far the picture is, at most.
const TELL_EVERY: Duration = Duration::from_millis(100);

/// Shortest time between two pictures while time passes.
const FRAME: Duration = Duration::from_millis(33);

/// Longest step of time between two pictures while it passes: a slow picture is not skipped over.
const LONGEST_STEP: f64 = 0.25;

/// What the studio keeps from picture to picture.
pub(super) struct Studio {
    shared: Arc<Shared>,
    session: Session,
    order: Order,
    loaded: Option<Arc<Loaded>>,
    /// What was on view last: while a script is wrong, people go on looking at what it was when it was right.
    view: Option<OnView>,
    /// The wishes that were answered.
    answered: u64,
    /// When the last picture of those that show how time passes was begun.
    frame: Option<Instant>,
    revision: u64,
    /// The components of the solid that was looked at last.
    analysis: Option<(Arc<Loaded>, Arc<Analysis>)>,
}

/// The last script that was right, and how its picture is seen.
struct OnView {
    loaded: Arc<Loaded>,
    /// Camera, caster, layer, size: all but what the script would have to be run for.
    wish: Wish,
    /// Whether a picture of it is on the canvas, of one sample at least,
    sketched: bool,
    /// and the picture, if it was finished.
    finished: Option<Finished>,
}

/// One picture to draw.
struct Task {
    wish: Wish,
    saved: bool,
    /// Counts the wishes that it answers.
    number: u64,
    cancel: Arc<AtomicBool>,
    steering: Arc<Steering>,
    start: Instant,
    /// Whether a picture of it is on the canvas.
    sketched: AtomicBool,
}

/// Sides of rough tiles in which one recognises what they show.
const RECOGNISABLE: u32 = 8;

impl Studio {
    pub fn new(shared: Arc<Shared>, session: Session, order: Order) -> Studio {
        let (loaded, view, frame, analysis) = (None, None, None, None);
        Studio { shared, session, order, loaded, view, answered: 0, frame, revision: 0, analysis }
    }

    /// Draws what is wished for, until the end.
    pub fn work(mut self) {
        while let Some(task) = self.next() {
            self.answer(&task);
            self.shared.state().running = None;
        }
    }

    /// Waits for something to draw; `None` at the end.
    fn next(&mut self) -> Option<Task> {
        let shared = self.shared.clone();
        let mut state = shared.state();
        while !(state.closing || state.saved || state.wishes > self.answered) {
            let pause = self.pause(&state);
            if pause.is_some_and(|pause| pause.is_zero()) {
                break;
            }
            // Without an end of the pause there is one by tomorrow.
            let pause = pause.unwrap_or(Duration::from_secs(86_400));
            let woken = shared.bell.wait_timeout(state, pause).unwrap_or_else(PoisonError::into_inner);
            state = woken.0;
        }
        if state.closing {
            return None;
        }
        self.pass_time(&mut state);
        self.answered = state.wishes;
        state.finished = None;
        let (cancel, start) = (Arc::new(AtomicBool::new(false)), Instant::now());
        let steering = Arc::new(Steering::default());
        steering.focus(state.wish.region);
        state.running = Some(Running {
            cancel: cancel.clone(),
            steering: steering.clone(),
            start,
            seen: false,
            timed: false,
        });
        let saved = std::mem::take(&mut state.saved);
        let (wish, number, sketched) = (state.wish.clone(), self.answered, AtomicBool::new(false));
        Some(Task { wish, saved, number, cancel, steering, start, sketched })
    }

    /// How long until the next picture while time passes; `None` where it stands still, or nothing can be drawn.
    fn pause(&self, state: &State) -> Option<Duration> {
        let is_due = state.wish.playing && state.report.stage != Stage::Failed;
        let since = self.frame.map_or(FRAME, |frame| frame.elapsed());
        is_due.then(|| FRAME.saturating_sub(since))
    }

    /// Moves the time on while it passes.
    fn pass_time(&mut self, state: &mut State) {
        let last = self.frame.take();
        if state.wish.playing {
            let now = Instant::now();
            let step = last.map_or(0.0, |last| (now - last).as_secs_f64().min(LONGEST_STEP));
            state.wish.time += step;
            self.frame = Some(now);
        }
    }

    /// Reads the script and draws it, or what it was when it was right.
    fn answer(&mut self, task: &Task) {
        let Some((loaded, again)) = self.read(task).and_then(|read| self.on_view(read, task)) else { return };
        let Some(scene) = &loaded.scene else { return };
        let mut scene = Scene::clone(scene);
        scene.camera = task.wish.camera.unwrap_or(scene.camera);
        let scene = Arc::new(scene);
        let drawn = self.draw(&scene, &loaded, task, again);
        if let Some(view) = &mut self.view {
            view.sketched |= task.sketched.load(Ordering::SeqCst);
        }
        if let Err(error) = drawn
            && !task.cancel.load(Ordering::SeqCst)
        {
            if self.loaded.as_ref().is_some_and(|read| read.scene.is_some()) {
                // What cannot be drawn is not gone on with.
                self.view = None;
            }
            let message = Message::new(&error, &loaded.sources);
            self.shared.report(|report| {
                report.messages.push(message);
                report.stage = Stage::Failed;
            });
        }
    }

    /// What is to be drawn after a script was read, and whether it is on the canvas already; `None` if that is nothing.
    fn on_view(&mut self, read: Arc<Loaded>, task: &Task) -> Option<(Arc<Loaded>, bool)> {
        let wish = task.wish.of_looks();
        if read.scene.is_some() {
            self.view = Some(OnView { loaded: read.clone(), wish, sketched: false, finished: None });
            return Some((read, false));
        }
        let view = self.view.as_mut()?;
        if view.wish != wish {
            (view.wish, view.sketched, view.finished) = (wish, false, None);
        }
        if view.finished.is_some() {
            self.shared.state().finished.clone_from(&view.finished);
            return None;
        }
        Some((view.loaded.clone(), view.sketched))
    }

    /// What the script comes to; `None` if a newer wish came in between.
    fn read(&mut self, task: &Task) -> Option<Arc<Loaded>> {
        let wish = &task.wish;
        let same = self.session.params == wish.params && self.session.time == wish.time;
        let loaded = match &self.loaded {
            Some(loaded) if same && !task.saved => loaded.clone(),
            _ => self.load(wish, &task.cancel),
        };
        if task.cancel.load(Ordering::SeqCst) {
            // It may have been stopped in the middle, and is to be read again.
            self.loaded = None;
            self.shared.state().saved |= task.saved;
            return None;
        }
        let new = !self.loaded.as_ref().is_some_and(|before| Arc::ptr_eq(before, &loaded));
        self.revision += u64::from(new && task.saved && loaded.scene.is_some());
        self.loaded = Some(loaded.clone());
        self.publish(&loaded, wish);
        if new && task.saved {
            (self.shared.tell)(Event::Read);
        }
        Some(loaded)
    }

    /// Runs the script. Parameters that it does not have, or that are out of range, are forgotten: in silence if they were
    /// right before it was changed, but not those that it is begun with.
    fn load(&mut self, wish: &Wish, cancel: &Arc<AtomicBool>) -> Arc<Loaded> {
        self.session.set(wish.params.clone(), wish.time);
        let loaded = self.session.load(cancel);
        if loaded.scene.is_some() || wish.params.is_empty() || cancel.load(Ordering::SeqCst) {
            return loaded;
        }
        self.session.set(BTreeMap::new(), wish.time);
        let plain = self.session.load(cancel);
        let Some(scene) = &plain.scene else {
            self.session.set(wish.params.clone(), wish.time);
            return plain;
        };
        let fits = |name: &String, value: &Value| {
            let param = scene.params.iter().find(|p| p.name == *name);
            param.is_some_and(|p| p.domain.admit(value).is_ok())
        };
        let mut params = wish.params.clone();
        params.retain(|name, value| fits(name, value));
        self.shared.state().wish.params.retain(|name, value| fits(name, value));
        self.session.set(params, wish.time);
        let fit = self.session.load(cancel);
        if self.loaded.is_some() {
            return fit;
        }
        let forgotten = loaded.diagnostics.iter().filter(|d| d.severity == Severity::Error);
        let forgotten = forgotten.map(|d| Diagnostic { severity: Severity::Warning, ..d.clone() });
        Arc::new(Loaded { diagnostics: forgotten.chain(fit.diagnostics.clone()).collect(), ..(*fit).clone() })
    }

    /// Says what the script came to.
    fn publish(&self, loaded: &Arc<Loaded>, wish: &Wish) {
        let mut state = self.shared.state();
        state.files = self.session.files();
        state.loaded = Some(loaded.clone());
        let shown = loaded.scene.as_ref().or_else(|| self.view.as_ref()?.loaded.scene.as_ref());
        if let Some(scene) = shown {
            // The camera may have moved on meanwhile.
            state.camera = Some(state.wish.camera.unwrap_or(scene.camera));
        }
        if let Some(scene) = &loaded.scene {
            state.params.clone_from(&scene.params);
        } else {
            // What the script failed with is what is to be seen, and what would be written.
            for param in &mut state.params {
                if let Some(wished) = wish.params.get(&param.name) {
                    param.value.clone_from(wished);
                }
            }
        }
        let messages = loaded.diagnostics.iter().map(|d| Message::new(d, &loaded.sources)).collect();
        let caster = Kind::ALL.iter().find(|(kind, _)| *kind == wish.caster).map_or("", |(_, name)| name);
        let before = state.report.clone();
        let camera = match shown {
            Some(scene) => rewrite::camera(&wish.camera.unwrap_or(scene.camera)),
            None => before.camera.clone(),
        };
        state.report = Arc::new(Report {
            script: self.session.script().display().to_string(),
            params: state.params.clone(),
            messages,
            output: loaded.output.clone(),
            camera,
            steered: wish.camera.is_some(),
            caster,
            layer: wish.layer,
            components: wish.components,
            parts: None,
            time: wish.time,
            playing: wish.playing,
            region: state.wish.region.map(|r| [r.x, r.y, r.width, r.height]),
            stage: if loaded.scene.is_some() { Stage::Drawing } else { Stage::Failed },
            progress: 0.0,
            revision: self.revision,
            ..*before
        });
        drop(state);
        (self.shared.tell)(Event::Changed);
    }

    /// Draws coarsely, and better, and as the script asks for it. What is drawn `again` takes the place of itself: nothing
    /// coarse covers it.
    fn draw(
        &mut self,
        scene: &Arc<Scene>,
        loaded: &Arc<Loaded>,
        task: &Task,
        again: bool,
    ) -> Result<(), Box<Diagnostic>> {
        let size = task.wish.size.or(self.order.size.map(|(w, h)| [w, h]));
        let size = size.unwrap_or([scene.film.width, scene.film.height]);
        if u64::from(size[0]) * u64::from(size[1]) > LARGEST {
            let error = format!("{} x {} pixels are too many to watch", size[0], size[1]);
            let hint =
                "choose a smaller size on the page, or with --size; orogen render makes pictures that large";
            return Err(Box::new(Diagnostic::error(error).hint(hint)));
        }
        let order = Order { size: Some((size[0], size[1])), caster: task.wish.caster, ..self.order };
        {
            let mut canvas = self.shared.canvas();
            canvas.resize(size);
            canvas.view = View::new(&scene.camera, size[0], size[1]).ok();
        }
        let gone = Arc::default();
        let subject = Subject { scene: scene.clone(), loaded: loaded.clone(), order, gone };
        if let Some(before) = self.shared.state().subject.replace(subject) {
            before.gone.store(true, Ordering::SeqCst);
        }
        self.shared.report(|report| report.size = size);
        let look = Look::of(scene);
        let layer = task.wish.layer;
        let told = Mutex::new(Instant::now());
        let shared = self.shared.clone();
        let progress = |p: Progress| shared.progress(p.done as f64 / p.total.max(1) as f64, &told);
        let rough = |tile: &Rough| {
            let look = Look { background: tile.background, ..look };
            shared.canvas().fill(&tile.rect, layer, &look, &tile.pixel);
            shared.is_seen(task, tile.side <= RECOGNISABLE, false);
        };
        let tile = |tile: &Fine<'_>| {
            let look = Look { background: tile.background, ..look };
            shared.canvas().paint(&tile.rect, layer, &look, |x, y| tile.pixel(x, y));
            shared.is_seen(task, true, true);
        };
        let rough: Option<&(dyn Fn(&Rough) + Sync)> = if again { None } else { Some(&rough) };
        let job = Job { cancel: &task.cancel, progress: &progress, tile: &tile, rough };
        if task.wish.components && !again {
            self.coarse(scene, &order, (layer, &look), task)?;
        }
        let picture = if task.wish.components {
            let analysis = self.analysis(scene, loaded, &task.cancel)?;
            let parts = Some((analysis.parts.len(), analysis.is_certified()));
            self.shared.report(|report| report.parts = parts);
            let keep = scene.surface.keep.unwrap_or(Keep::Most(Measure::Minima));
            topology::picture(scene, &order, &analysis, (Show::Components, &keep), &job)?
        } else {
            self.refined(scene, &order, &job, task)?
        };
        if picture.finished {
            self.finish(picture, scene, loaded, task);
        }
        Ok(())
    }

    /// Coarse pictures, where there are no rough tiles, and something has to be found out before the first ray.
    fn coarse(
        &self,
        scene: &Scene,
        order: &Order,
        (layer, look): (Layer, &Look),
        task: &Task,
    ) -> Result<(), Box<Diagnostic>> {
        for side in COARSENESS {
            let picture = preview(scene, order, side, &Job::unwatched(&task.cancel))?;
            let Some(picture) = picture.filter(|picture| picture.finished) else { break };
            {
                let mut canvas = self.shared.canvas();
                for y in (0..picture.height).step_by(side as usize) {
                    for x in (0..picture.width).step_by(side as usize) {
                        let rect = Rect { x, y, width: side, height: side };
                        canvas.fill(&rect, layer, look, picture.pixel(x, y));
                    }
                }
            }
            self.shared.is_seen(task, true, true);
        }
        task.sketched.store(true, Ordering::SeqCst);
        Ok(())
    }

    /// The picture as it is ordered. Where that takes many samples, a picture of one sample comes first: it takes a
    /// fraction of the time, and shows most of what there is to see; unless it is there already, as anything rough is.
    fn refined(
        &self,
        scene: &Arc<Scene>,
        order: &Order,
        job: &Job<'_>,
        task: &Task,
    ) -> Result<Picture, Box<Diagnostic>> {
        let refine = |samples: u32, job: &Job<'_>| {
            let order = Order { samples: Some(samples), ..*order };
            self.session.refine(scene, &order, job, (&task.steering, &task.cancel))
        };
        let samples = order.samples.unwrap_or(scene.film.samples);
        if job.rough.is_none() {
            return refine(samples, job);
        }
        let first = refine(1, job)?;
        if samples == 1 || !first.finished {
            return Ok(first);
        }
        task.sketched.store(true, Ordering::SeqCst);
        // What it showed is on the canvas; at 4K it holds nearly a gigabyte.
        drop(first);
        // Nothing rough takes the place of what is there.
        refine(samples, &Job { rough: None, ..*job })
    }

    /// The components of a solid, found once for each time that the script is read.
    fn analysis(
        &mut self,
        scene: &Scene,
        loaded: &Arc<Loaded>,
        cancel: &AtomicBool,
    ) -> Result<Arc<Analysis>, Box<Diagnostic>> {
        match &self.analysis {
            Some((of, analysis)) if Arc::ptr_eq(of, loaded) => Ok(analysis.clone()),
            _ => {
                let told = Mutex::new(Instant::now());
                let progress = |share: f64| self.shared.progress(share, &told);
                let watch = Watch { cancel, progress: &progress };
                let analysis = Arc::new(topology::analyse(scene, Purpose::default(), &watch)?);
                self.analysis = Some((loaded.clone(), analysis.clone()));
                self.shared.state().labels = Some((loaded.clone(), analysis.labels.clone()));
                Ok(analysis)
            }
        }
    }

    /// A full picture is there.
    fn finish(&mut self, picture: Picture, scene: &Arc<Scene>, loaded: &Arc<Loaded>, task: &Task) {
        let stats = &picture.stats;
        let evaluations = stats.primary.evaluations + stats.shadow.evaluations;
        let cost = evaluations as f64 / (f64::from(picture.width) * f64::from(picture.height));
        let warnings: Vec<_> = picture.warnings.iter().map(|d| Message::new(d, &loaded.sources)).collect();
        let finished = Finished { picture: Arc::new(picture), scene: scene.clone(), loaded: loaded.clone() };
        if let Some(view) = &mut self.view {
            view.finished = Some(finished.clone());
        }
        self.shared.state().finished = Some(finished);
        self.shared.report(|report| {
            if report.stage != Stage::Failed {
                report.messages.extend(warnings);
                report.stage = Stage::Done;
            }
            (report.progress, report.cost) = (1.0, cost);
            report.whole = task.start.elapsed().as_secs_f64();
        });
        (self.shared.tell)(Event::Finished);
    }
}

impl Shared {
    /// Changes what people are told.
    fn report(&self, change: impl FnOnce(&mut Report)) {
        change(Arc::make_mut(&mut self.state().report));
        (self.tell)(Event::Changed);
    }

    /// Tells them how far the picture is, unless they were `told` just now.
    fn progress(&self, share: f64, told: &Mutex<Instant>) {
        let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.elapsed() >= TELL_EVERY {
            *told = Instant::now();
            self.report(|report| report.progress = share);
        }
    }

    /// Notes that something is seen, whether one recognises what, and whether all that is rough is there. From what one
    /// recognises on a newer wish stops the picture; time that passes does so when the rough part is over.
    fn is_seen(&self, task: &Task, recognised: bool, past_rough: bool) {
        let mut state = self.state();
        let passes = state.wish.playing && state.report.stage != Stage::Failed;
        let newer = state.wishes > task.number || state.saved || (past_rough && passes);
        let first = recognised
            && state.running.as_mut().is_some_and(|running| !std::mem::replace(&mut running.seen, true));
        if first {
            Arc::make_mut(&mut state.report).first = task.start.elapsed().as_secs_f64();
        }
        drop(state);
        if recognised && newer {
            task.cancel.store(true, Ordering::SeqCst);
        }
        (self.tell)(Event::Changed);
    }
}
