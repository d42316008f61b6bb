//! A progress bar with the time left, on a terminal; nothing on a pipe.

use super::report::Terminal;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// Steps that the whole of a job is cut into.
const STEPS: u64 = 10_000;

/// The bar.
#[derive(Clone)]
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar, where somebody watches.
    pub fn new(terminal: &Terminal, message: &str) -> Progress {
        let target =
            if terminal.live { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        let template = "{msg} [{bar:32}] {percent:>3} %, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(message.to_owned());
        if terminal.live {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        Progress(bar)
    }

    /// Moves the bar to a share between 0 and 1.
    pub fn set(&self, share: f64) {
        self.0.set_position((share.clamp(0.0, 1.0) * STEPS as f64) as u64);
    }

    /// Writes a line above the bar.
    pub fn say(&self, line: &str) {
        self.0.suspend(|| super::report::err(line));
    }

    /// Does something that writes lines, with the bar out of the way.
    pub fn aside<T>(&self, work: impl FnOnce() -> T) -> T {
        self.0.suspend(work)
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
