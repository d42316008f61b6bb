//! What there is of a picture after a moment: all of it where that is enough, and rough tiles where it is not.
//!
//! Somebody who is to choose among many pictures wants to see something of each before all of one. So a picture is
//! begun as one that [refines](crate::session::refine), and left as soon as its rough tiles are there. But a picture that
//! is nearly there is not left: most scripts need no more than a moment for one so small, and a rough one that is drawn
//! besides would only be in the way.

use super::Subject;
use crate::diag::Diagnostic;
use crate::render::{Fine, Job, Picture, Pixel, Rect, Rough, Steering};
use crate::scene::Scene;
use crate::session::{Order, Session};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Side of the smallest rough tiles: small pictures show little in larger ones.
const FINEST: u32 = 4;

/// Draws as much of a picture as comes of a moment; `None` if it was cancelled before there was anything. It raises `stop`
/// itself when it has enough.
///
/// # Errors
/// As for [`Subject::draw`].
pub(super) fn sketch(
    session: &Session,
    scene: &Arc<Scene>,
    order: &Order,
    (patience, stop): (Duration, &Arc<AtomicBool>),
) -> Result<Option<Picture>, Box<Diagnostic>> {
    let (width, height) = order.size.unwrap_or((scene.film.width, scene.film.height));
    let board = Board::new(Rect::whole(width, height), Instant::now() + patience, stop);
    let rough = |tile: &Rough| board.rough(tile);
    let tile = |tile: &Fine<'_>| board.finished(tile);
    let job = Job { tile: &tile, rough: Some(&rough), ..Job::unwatched(stop) };
    let picture = session.refine(scene, order, &job, (&Steering::down_to(FINEST), stop))?;
    Ok(if picture.finished { Some(picture) } else { board.picture(picture) })
}

/// Where tiles are put.
struct Board<'a> {
    whole: Rect,
    /// When rough tiles are enough.
    end: Instant,
    /// Raised then.
    stop: &'a AtomicBool,
    painted: Mutex<Painted>,
}

/// What is on a board.
struct Painted {
    pixels: Vec<Pixel>,
    /// Which of them do not get better before they are finished, and how many do.
    settled: Vec<bool>,
    left: usize,
}

impl<'a> Board<'a> {
    fn new(whole: Rect, end: Instant, stop: &'a AtomicBool) -> Board<'a> {
        let left = whole.area() as usize;
        let painted = Painted { pixels: vec![Pixel::EMPTY; left], settled: vec![false; left], left };
        Board { whole, end, stop, painted: Mutex::new(painted) }
    }

    fn painted(&self) -> MutexGuard<'_, Painted> {
        self.painted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A rough tile. What passes the solid by has no parts.
    fn rough(&self, tile: &Rough) {
        self.put(&tile.rect, tile.side <= FINEST || tile.pixel.depth.is_infinite(), |_, _| tile.pixel);
    }

    /// A finished one.
    fn finished(&self, tile: &Fine<'_>) {
        self.put(&tile.rect, true, |x, y| tile.pixel(x, y));
    }

    fn put(&self, rect: &Rect, is_settled: bool, pixel: impl Fn(u32, u32) -> Pixel) {
        let Some(rect) = rect.intersection(&self.whole) else { return };
        let mut painted = self.painted();
        for y in rect.y..rect.bottom() {
            for x in rect.x..rect.right() {
                let at = (y * self.whole.width + x) as usize;
                painted.pixels[at] = pixel(x, y);
                if is_settled && !std::mem::replace(&mut painted.settled[at], true) {
                    painted.left -= 1;
                }
            }
        }
        if painted.left == 0 && Instant::now() >= self.end {
            self.stop.store(true, Ordering::SeqCst);
        }
    }

    /// A picture that was left, with what is on the board; `None` where that has gaps.
    fn picture(self, left: Picture) -> Option<Picture> {
        let painted = self.painted.into_inner().unwrap_or_else(PoisonError::into_inner);
        let Painted { pixels, left: 0, .. } = painted else { return None };
        Some(Picture { window: self.whole, pixels, ..left })
    }
}

impl Subject {
    /// The bytes of a PNG of as much of a picture as comes of a moment, and whether that is all of it; `None` if it was
    /// cancelled before there was anything. It raises `stop` itself when it has enough.
    ///
    /// # Errors
    /// As for [`Subject::draw`].
    pub fn sketch(
        &self,
        genome: &super::Genome,
        order: &Order,
        (patience, stop): (Duration, &Arc<AtomicBool>),
    ) -> Result<Option<(Vec<u8>, bool)>, Box<Diagnostic>> {
        let (session, scene) = self.scene(genome, stop)?;
        let picture = sketch(&session, &scene, &order.at_once(), (patience, stop))?;
        let encoded = |picture: Picture| Ok((self.encoded(genome, &scene, &picture)?, picture.finished));
        picture.map(encoded).transpose()
    }
}
