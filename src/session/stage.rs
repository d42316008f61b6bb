//! From a scene to a picture of it: finds the bounds, chooses a caster, and renders.

use super::{topology, whereabouts};
use crate::cast::{self, Judge, Kind, Sifted};
use crate::diag::Diagnostic;
use crate::field::{Field, Halt, Watch};
use crate::render::{
    self, Job, Painter, Part, Picture, Precision, RenderError, Settings, Shot, Steering, View,
};
use crate::scene::{Camera, Scene};
use glam::DVec3;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a picture should be like, where it differs from what the script says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Order {
    /// Width and height in pixels.
    pub size: Option<(u32, u32)>,
    /// Which part of it.
    pub part: Part,
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// Which caster.
    pub caster: Kind,
    /// Whether its noise is smoothed.
    pub denoise: bool,
    /// Whether it is told which component of the solid each pixel shows.
    pub components: bool,
    /// How closely a file holds its light, where it is a file of floats.
    pub precision: Precision,
    /// Threads; as many as there are cores where `None`.
    pub threads: Option<NonZeroUsize>,
}

impl Order {
    /// The same with a caster that needs no trial of others before its first ray, for few rays: which one is best for a
    /// whole picture takes longer to find out than they do.
    pub(super) fn at_once(&self) -> Order {
        let caster = if self.caster == Kind::Auto { Kind::Beam } else { self.caster };
        Order { caster, ..*self }
    }
}

/// The settings that the script and an order together ask for.
///
/// Where the script gives no bounds, the solid is looked for: in the field as the picture shows it,
/// which has less detail than the field of the scene and may reach farther in places.
///
/// # Errors
/// A diagnostic where no picture can be made like that.
pub fn settings(scene: &Scene, order: &Order) -> Result<Settings, Box<Diagnostic>> {
    settings_until(scene, order, &|| false)
}

/// The same; when `halt` says so, no closer bounds are looked for.
fn settings_until(scene: &Scene, order: &Order, halt: Halt<'_>) -> Result<Settings, Box<Diagnostic>> {
    let mut settings = Settings::of(scene, whereabouts::in_sight(scene));
    if let Some((width, height)) = order.size {
        (settings.width, settings.height) = (width, height);
    }
    settings.samples = order.samples.unwrap_or(settings.samples);
    settings.part = order.part;
    if scene.bounds.is_none() {
        let shown = render::shown(scene, &settings).map_err(|e| Box::new(e.diagnostic()))?;
        settings.bounds = whereabouts::bounds_until(scene, &shown, halt);
    }
    Ok(settings)
}

/// Renders a scene; gives what is finished if the job is cancelled.
///
/// # Errors
/// A diagnostic where no picture can be made, or where the job is cancelled before any ray is cast.
pub fn render(scene: &Scene, order: &Order, job: &Job<'_>) -> Result<Picture, Box<Diagnostic>> {
    render_moments(&[scene], order, job, None)
}

/// The same picture, with rough tiles before it ([`render::refine`]), those first that `steering` asks for.
///
/// # Errors
/// As for [`render`](render()).
pub fn refine(
    scene: &Scene,
    order: &Order,
    job: &Job<'_>,
    steering: &Steering,
) -> Result<Picture, Box<Diagnostic>> {
    render_moments(&[scene], order, job, Some(steering))
}

/// Renders a scene that moves while the shutter is open, as [`Session::render`](super::Session::render) does; refines it
/// where there is somebody who steers.
///
/// # Errors
/// As for [`render`](render()).
pub(super) fn render_moments(
    moments: &[&Scene],
    order: &Order,
    job: &Job<'_>,
    steering: Option<&Steering>,
) -> Result<Picture, Box<Diagnostic>> {
    let watch = Watch { cancel: job.cancel, progress: &|_| () };
    let mut warnings = Vec::new();
    let mut shots = Vec::new();
    for scene in moments {
        let (mut taken, odd) = Taken::corrected(scene, order, &watch)?;
        if steering.is_some() && job.rough.is_some() {
            taken.look_ahead();
        }
        shots.push(taken);
        warnings = odd;
    }
    let labels = match moments.first() {
        Some(scene) if order.components => Some(topology::labels(scene, order.threads, &watch)?),
        _ => None,
    };
    warnings.extend(moments.first().zip(shots.first()).and_then(|(scene, shot)| cropped(scene, shot)));
    warnings.extend(labels.as_ref().filter(|_| moments.len() > 1).map(|_| parted()));
    let mut picture = picture(shots, order, job, steering)?;
    picture.warnings.extend(warnings);
    picture.components = labels.map(|labels| labels.seen(&picture));
    let is_smoothed = order.denoise && picture.tiles > 0;
    picture.denoised = is_smoothed.then(|| render::denoise(&picture));
    Ok(picture)
}

/// The distance from which a camera sees all of a solid, over that of the usual one: from here on that one certainly misses
/// some of it,
const TOO_NEAR: f64 = 3.0;

/// and below this it sees next to nothing.
const TOO_FAR: f64 = 0.05;

/// That the usual camera does not see all of a solid that was found, or next to nothing of it, and which one would.
fn cropped(scene: &Scene, shot: &Taken) -> Option<Diagnostic> {
    let bounds = shot.scene.settings.bounds;
    let is_found = scene.bounds.is_none() && bounds != whereabouts::in_sight(scene);
    if scene.camera != Camera::default() || !is_found {
        return None;
    }
    let Camera { eye, target, .. } = Camera::framing(&bounds);
    let nearer = eye.distance(target) / scene.camera.eye.distance(scene.camera.target);
    let message = match nearer {
        _ if shot.scene.probe.outside_picture > 0 || nearer > TOO_NEAR => {
            "the picture does not show all of the solid"
        }
        nearer if nearer < TOO_FAR => "the solid is very small in the picture",
        _ => return None,
    };
    let (DVec3 { x, y, z }, size) = (target, eye.distance(target));
    // Three digits of the distance, and as many decimals of the rest.
    let decimals = (2.0 - libm::floor(libm::log10(size))).clamp(0.0, 15.0) as usize;
    let hint = format!(
        "try scene(#{{ surface: ..., camera: orbit(#{{ target: [{x:.decimals$}, {y:.decimals$}, {z:.decimals$}], \
         distance: {size:.decimals$} }}) }})"
    );
    Some(Diagnostic::warning(message).hint(hint))
}

/// Components are not followed through time.
fn parted() -> Diagnostic {
    Diagnostic::warning("components are told from one another as they are when the shutter opens")
        .hint("what moves meanwhile may have the number of another, or none; close the shutter to be sure")
}

/// What a picture shows otherwise than the scene says.
#[derive(Default)]
pub(super) struct Touch {
    /// Which parts of the solid are there.
    pub judge: Option<Box<dyn Judge>>,
    /// What colours they have.
    pub painter: Option<Box<dyn Painter>>,
}

/// The same as [`render`] with such a touch, whatever the scene keeps; and how it is seen.
pub(super) fn render_touched(
    scene: &Scene,
    order: &Order,
    touch: Touch,
    job: &Job<'_>,
) -> Result<(Picture, View), Box<Diagnostic>> {
    let shot = Taken::new(scene, order, touch, job.cancel)?;
    let view = shot.scene.view;
    Ok((picture(vec![shot], order, job, None)?, view))
}

/// A scene at one moment with its caster, and the same of what is beside its solid.
pub(super) struct Taken {
    pub scene: render::Prepared,
    pub caster: Box<dyn cast::Caster>,
    /// How whole tiles of it are seen, if they are wanted.
    reach: Option<Box<dyn cast::Reach>>,
    moon: Option<Box<Taken>>,
    sea: Option<Box<Taken>>,
}

impl Taken {
    /// With those parts of the solid that the scene keeps, and what is odd about them.
    pub fn corrected(
        scene: &Scene,
        order: &Order,
        watch: &Watch<'_>,
    ) -> Result<(Taken, Vec<Diagnostic>), Box<Diagnostic>> {
        let Some(keep) = &scene.surface.keep else {
            return Ok((Taken::new(scene, order, Touch::default(), watch.cancel)?, Vec::new()));
        };
        let correction = topology::correction(scene, keep, order.threads, watch)?;
        let touch = Touch { judge: Some(correction.judge.clone_box()), painter: None };
        Ok((Taken::new(scene, order, touch, watch.cancel)?, correction.warnings()))
    }

    fn new(
        scene: &Scene,
        order: &Order,
        touch: Touch,
        cancel: &AtomicBool,
    ) -> Result<Taken, Box<Diagnostic>> {
        let halt = || cancel.load(Ordering::Relaxed);
        let settings = on_threads(order.threads, || settings_until(scene, order, &halt))??;
        if halt() {
            return Err(stopped());
        }
        let mut prepared = render::prepare(scene, &settings, cancel).map_err(|e| Box::new(e.diagnostic()))?;
        prepared.painter = touch.painter;
        let field = Field::of_tape(&prepared.tape);
        let Settings { bounds, .. } = prepared.settings;
        let typical = prepared.typical_rays();
        let mut caster: Box<dyn cast::Caster> = match order.caster {
            Kind::Auto => Box::new(cast::Later::new(field, bounds, prepared.cells.clone(), typical)),
            kind => cast::caster_in(kind, &field, &bounds, &prepared.cells, &typical, cancel)
                .map_err(no_caster)?,
        };
        if let Some(judge) = touch.judge {
            caster = Box::new(Sifted::new(caster, &prepared.cells, &bounds, judge));
        }
        let alone = |scene: Scene| Taken::new(&scene, order, Touch::default(), cancel).map(Box::new);
        let moon = scene.moon.as_ref().map(|moon| alone(moon.scene(scene))).transpose()?;
        let sea = scene.sea.as_ref().map(|sea| alone(sea.scene(scene))).transpose()?;
        if sea.as_ref().is_some_and(|sea| sea.scene.probe.camera_inside) {
            let warning = Diagnostic::warning("the camera is below the surface of the sea");
            let hint = "from below, the surface is not seen, nor what is above it: move the camera up";
            prepared.warnings.push(warning.hint(hint));
        }
        Ok(Taken { scene: prepared, caster, reach: None, moon, sea })
    }

    /// Finds a way to see whole tiles, of all that is there.
    fn look_ahead(&mut self) {
        self.reach = Some(cast::reach(&*self.caster, &self.scene.settings.bounds, &self.scene.cells));
        [&mut self.moon, &mut self.sea].into_iter().flatten().for_each(|beside| beside.look_ahead());
    }

    /// Its moon and its sea.
    fn beside(&self) -> [Option<Shot<'_>>; 2] {
        [&self.moon, &self.sea].map(|beside| beside.as_deref().map(Taken::shot))
    }

    /// What is rendered, without what is beside it.
    fn shot(&self) -> Shot<'_> {
        Shot { reach: self.reach.as_deref(), ..Shot::of(&self.scene, self.caster.as_ref()) }
    }
}

/// The picture of what was taken.
fn picture(
    taken: Vec<Taken>,
    order: &Order,
    job: &Job<'_>,
    steering: Option<&Steering>,
) -> Result<Picture, Box<Diagnostic>> {
    let work = move || {
        let beside: Vec<_> = taken.iter().map(Taken::beside).collect();
        let shots = taken.iter().zip(&beside);
        let shots = shots.map(|(t, [moon, sea])| Shot { moon: moon.as_ref(), sea: sea.as_ref(), ..t.shot() });
        let shots: Vec<Shot<'_>> = shots.collect();
        let picture = match steering {
            Some(steering) => render::refine(&shots, job, steering),
            None => render::render_moments(&shots, job),
        };
        // Freeing thousands of pruned tapes takes longer than whoever cancels a picture should wait.
        rayon::spawn(move || drop(taken));
        picture.map_err(|e| Box::new(e.diagnostic()))
    };
    on_threads(order.threads, work)?
}

/// Does something on so many threads; as many as there are cores where `None`.
///
/// # Errors
/// If so many threads cannot be started.
pub fn on_threads<T: Send>(
    threads: Option<NonZeroUsize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Box<Diagnostic>> {
    match threads {
        None => Ok(work()),
        Some(threads) => Ok(pool(threads)?.install(work)),
    }
}

fn no_caster(error: cast::CastError) -> Box<Diagnostic> {
    if error == cast::CastError::Stopped {
        return stopped();
    }
    Box::new(Diagnostic::error(error.to_string()).hint("choose another with --caster, or leave it to auto"))
}

/// A pool of so many threads, but not more than four a core: idle workers look for work in turns, and
/// hundreds of them on a few cores keep the busy ones from working. The picture does not depend on it.
fn pool(threads: NonZeroUsize) -> Result<rayon::ThreadPool, Box<Diagnostic>> {
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = threads.get().min(4 * cores);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| {
        let error = Diagnostic::error(format!("cannot start {threads} threads ({e})"));
        Box::new(error.hint("ask for fewer with --threads"))
    })
}

/// Why nothing came of a job that was stopped.
pub fn stopped() -> Box<Diagnostic> {
    Box::new(RenderError::Stopped.diagnostic())
}
