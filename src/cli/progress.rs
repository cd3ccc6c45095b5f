//! Progress of long work: a bar with the time left, on a terminal only.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::options::Global;

/// Steps of the bar for one frame: fine enough to move on the longest frames.
const STEPS: u64 = 1000;

/// The progress of a number of frames.
pub struct Progress {
    bar: ProgressBar,
    quiet: bool,
}

impl Progress {
    /// A bar for work of `frames` frames; hidden where stderr is no terminal or nothing shall be said.
    pub fn new(frames: usize, global: &Global) -> Self {
        let target = if global.quiet || !std::io::stderr().is_terminal() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(10)
        };
        let bar = ProgressBar::with_draw_target(Some(frames as u64 * STEPS), target);
        let style = ProgressStyle::with_template("{msg:24} {wide_bar} {percent:>3}%  {elapsed} gone, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, quiet: global.quiet }
    }

    /// What is being done now.
    pub fn stage(&self, text: &str) {
        self.bar.set_message(text.to_owned());
    }

    /// `done` frames are finished, and `fraction` of the next one.
    pub fn at(&self, done: usize, fraction: f64) {
        let step = (done as f64 + fraction.clamp(0.0, 1.0)) * STEPS as f64;
        // Threads report out of order; the bar never runs back.
        if step as u64 > self.bar.position() {
            self.bar.set_position(step as u64);
        }
    }

    /// A line for people, above the bar.
    pub fn say(&self, text: &str) {
        if !self.quiet {
            self.bar.suspend(|| eprintln!("{text}"));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
