//! Progress of long work: a bar with the time left, on a terminal only, or events for farms.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use super::events;
use super::options::Global;

/// Steps of the bar for one frame: fine enough to move on the longest frames.
const STEPS: u64 = 1000;
/// What is said to be done before the first frame.
pub const PREPARING: &str = "measuring the scene";
/// The least time between two events of progress: a farm's log is read by people, too.
const PAUSE: Duration = Duration::from_secs(1);

/// The progress of a number of frames.
pub struct Progress {
    bar: ProgressBar,
    quiet: bool,
    frames: usize,
    told_of_preparing: Mutex<Told>,
    told_of_frames: Mutex<Option<Told>>,
}

/// What the log of events was told of progress.
struct Told {
    /// When the work began.
    start: Instant,
    /// When it was told last.
    last: Instant,
    /// The greatest share told.
    share: f64,
}

impl Told {
    fn now() -> Self {
        let now = Instant::now();
        Self { start: now, last: now, share: 1e-4 }
    }

    /// The share, never less than before, and the seconds left, where it is time to tell them.
    fn due(&mut self, share: f64) -> Option<(f64, f64)> {
        self.share = self.share.max(share.min(1.0));
        let now = Instant::now();
        if now - self.last < PAUSE {
            return None;
        }
        self.last = now;
        Some((self.share, (now - self.start).as_secs_f64() * (1.0 - self.share) / self.share))
    }
}

fn rounded(value: f64, to: f64) -> f64 {
    (value * to).round() / to
}

impl Progress {
    /// A bar for work of `frames` frames; hidden where stderr is no terminal or nothing shall be said.
    pub fn new(frames: usize, global: &Global) -> Self {
        let target = if global.quiet || events::on() || !std::io::stderr().is_terminal() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(10)
        };
        let bar = ProgressBar::with_draw_target(Some(frames as u64 * STEPS), target);
        let style = ProgressStyle::with_template("{msg:24} {wide_bar} {percent:>3}%  {elapsed} gone, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.enable_steady_tick(Duration::from_millis(200));
        let told_of_preparing = Mutex::new(Told::now());
        Self { bar, quiet: global.quiet, frames, told_of_preparing, told_of_frames: Mutex::new(None) }
    }

    /// What is being done now.
    pub fn stage(&self, text: &str) {
        self.bar.set_message(text.to_owned());
    }

    /// What comes before the first frame is done by this share.
    pub fn of_preparing(&self, share: f64) {
        let mut told = self.told_of_preparing.lock().unwrap_or_else(PoisonError::into_inner);
        let due = told.due(share);
        if !events::on() {
            self.stage(&format!("{PREPARING} {:3.0}%", 100.0 * told.share));
        } else if let Some((share, left)) = due {
            let fields = json!({ "share": rounded(share, 1e4), "seconds_left": rounded(left, 10.0) });
            events::tell("preparing", &fields);
        }
    }

    /// `done` frames are finished, and `fraction` of the next one.
    pub fn at(&self, done: usize, fraction: f64) {
        let step = (done as f64 + fraction.clamp(0.0, 1.0)) * STEPS as f64;
        // Threads report out of order; the bar never runs back.
        if step as u64 > self.bar.position() {
            self.bar.set_position(step as u64);
        }
    }

    /// As [`Self::at`], with the frame's number, for the log of events.
    pub fn of_frame(&self, frame: i64, done: usize, fraction: f64) {
        self.at(done, fraction);
        if !events::on() {
            return;
        }
        let mut told = self.told_of_frames.lock().unwrap_or_else(PoisonError::into_inner);
        let share = (done as f64 + fraction) / self.frames.max(1) as f64;
        let Some((share, left)) = told.get_or_insert_with(Told::now).due(share) else { return };
        let fields = json!({
            "frame": frame,
            "frame_share": rounded(fraction, 1e3),
            "share": rounded(share, 1e4),
            "seconds_left": rounded(left, 10.0),
        });
        events::tell("progress", &fields);
    }

    /// A line for people above the bar, or an event.
    pub fn tell(&self, event: &str, fields: &Value, line: &str) {
        if !events::tell(event, fields) {
            self.say(line);
        }
    }

    /// A line for people, above the bar.
    pub fn say(&self, text: &str) {
        if !self.quiet {
            self.print(text);
        }
    }

    /// A line above the bar that is said in any case.
    pub fn print(&self, text: &str) {
        self.bar.suspend(|| super::say(text));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
