//! How far a job is: a bar with the time left on a terminal, and now and then a line elsewhere, so
//! that long jobs show signs of life in a log.

use super::report::{Terminal, err, seconds};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::Write;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Steps that the whole of a job is cut into.
const STEPS: u64 = 10_000;

/// Before this time no line is needed.
const PATIENCE: Duration = Duration::from_secs(5);

/// How often it is looked whether a line is due of a job that says nothing.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// The bar, or the lines.
#[derive(Clone)]
pub struct Progress {
    bar: ProgressBar,
    lines: Option<Arc<Mutex<Lines>>>,
}

/// What is told without a terminal.
struct Lines {
    message: String,
    start: Instant,
    /// When the next line is due.
    due: Duration,
    /// How far the job was last.
    share: f64,
}

impl Progress {
    /// A bar, where somebody watches.
    pub fn new(terminal: &Terminal, message: &str) -> Progress {
        let target =
            if terminal.live { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:32}] {percent:>3} %{left}") {
            bar.set_style(style.progress_chars("=> ").with_key("left", left));
        }
        if terminal.live {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        let lines = (!terminal.live).then(|| Arc::new(Mutex::new(Lines::new(message))));
        if let Some(lines) = &lines {
            let lines = Arc::downgrade(lines);
            std::thread::spawn(move || watch(&lines));
        }
        let progress = Progress { bar, lines };
        progress.restart(message);
        progress
    }

    /// Starts on another job.
    pub fn restart(&self, message: &str) {
        self.bar.reset();
        self.bar.set_message(message.to_owned());
        if let Some(lines) = &self.lines {
            let mut lines = lines.lock().unwrap_or_else(PoisonError::into_inner);
            *lines = Lines::new(message);
        }
    }

    /// Goes on with another piece of the same job.
    pub fn rename(&self, message: &str) {
        self.bar.set_message(message.to_owned());
        if let Some(lines) = &self.lines {
            lines.lock().unwrap_or_else(PoisonError::into_inner).message = message.to_owned();
        }
    }

    /// Moves the bar to a share between 0 and 1.
    pub fn set(&self, share: f64) {
        let share = share.clamp(0.0, 1.0);
        self.bar.set_position((share * STEPS as f64) as u64);
        if let Some(lines) = &self.lines {
            // Whoever is late says nothing new.
            let Ok(mut lines) = lines.try_lock() else { return };
            lines.share = share;
            if let Some(line) = lines.line() {
                err(line);
            }
        }
    }

    /// Writes a line above the bar.
    pub fn say(&self, line: &str) {
        self.bar.suspend(|| err(line));
    }

    /// Does something that writes lines, with the bar out of the way.
    pub fn aside<T>(&self, work: impl FnOnce() -> T) -> T {
        self.bar.suspend(work)
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
        if let Some(lines) = &self.lines {
            lines.lock().unwrap_or_else(PoisonError::into_inner).due = Duration::MAX;
        }
    }
}

/// Says how far a job is that says nothing for long, as long as there is somebody to say it for.
fn watch(lines: &Weak<Mutex<Lines>>) {
    while let Some(lines) = lines.upgrade() {
        let line = lines.lock().unwrap_or_else(PoisonError::into_inner).line();
        drop(lines);
        line.into_iter().for_each(err);
        std::thread::sleep(LOOK_EVERY);
    }
}

impl Lines {
    fn new(message: &str) -> Lines {
        Lines { message: message.to_owned(), start: Instant::now(), due: PATIENCE, share: 0.0 }
    }

    /// The line that is due, each half as late again as the one before.
    fn line(&mut self) -> Option<String> {
        let elapsed = self.start.elapsed();
        if elapsed < self.due {
            return None;
        }
        self.due = elapsed + elapsed / 2;
        let spent = seconds(elapsed.as_secs_f64());
        Some(format!("{}: {:.0} % after {spent}", self.message, (100.0 * self.share).floor()))
    }
}

/// The time left, once there is something to estimate it from.
fn left(state: &ProgressState, out: &mut dyn Write) {
    if state.pos() > 0 && state.per_sec() > 0.0 && state.elapsed() >= Duration::from_secs(1) {
        // There is nobody to tell that a text could not be written into memory.
        let _ = write!(out, ", {} left", seconds(state.eta().as_secs_f64()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_seldom_and_say_how_far_it_is() {
        let start = Instant::now().checked_sub(Duration::from_secs(20)).unwrap();
        let mut lines = Lines { start, share: 0.256, ..Lines::new("sphere") };
        assert_eq!(lines.line().unwrap(), "sphere: 25 % after 20.0 s");
        lines.share = 0.5;
        assert_eq!(lines.line(), None);
        assert!((29..31).contains(&lines.due.as_secs()));
    }
}
