//! Progress of long work: a bar with the time left, on a terminal only, or events for farms.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use super::events;
use super::options::Global;
use crate::terminal;

/// Steps of the bar for one frame: fine enough to move on the longest frames.
const STEPS: u64 = 1000;
/// What is said to be done before the first frame.
pub const PREPARING: &str = "measuring the scene";
/// The least time between two events of progress: a farm's log is read by people, too.
const PAUSE: Duration = Duration::from_secs(1);
/// The share that must be done before a time left is told. Less: the first steps, of another kind than the rest, stand for
/// all, and tell of hours where there are minutes.
const TELLING: f64 = 0.05;

/// The progress of a number of frames, and of what comes before the first of them: a bar of its own each.
pub struct Progress {
    bar: ProgressBar,
    quiet: bool,
    frames: usize,
    preparing: Mutex<Told>,
    of_frames: Mutex<Option<Told>>,
}

/// What was told of progress.
struct Told {
    /// When the first share of the work was done: what comes before it takes a time of its own.
    start: Instant,
    /// When an event told of it last.
    last: Instant,
    /// The greatest share told.
    share: f64,
}

impl Told {
    fn now() -> Self {
        let now = Instant::now();
        Self { start: now, last: now, share: 0.0 }
    }

    /// Threads report out of order; a share is never less than before.
    fn reach(&mut self, share: f64) {
        if self.share == 0.0 && share > 0.0 {
            self.start = Instant::now();
        }
        self.share = self.share.max(share.clamp(0.0, 1.0));
    }

    /// Seconds left, where that can be said.
    fn left(&self) -> Option<f64> {
        left(self.start.elapsed(), self.share)
    }

    /// Whether it is time for another event.
    fn is_due(&mut self) -> bool {
        let now = Instant::now();
        let due = now - self.last >= PAUSE;
        if due {
            self.last = now;
        }
        due
    }
}

/// Seconds left of work of which a share was done in so long; `None` where too little is done to tell.
fn left(gone: Duration, share: f64) -> Option<f64> {
    let tells = gone >= PAUSE && share >= TELLING;
    tells.then(|| gone.as_secs_f64() * (1.0 - share) / share)
}

fn rounded(value: f64, to: f64) -> f64 {
    (value * to).round() / to
}

/// Seconds left for the log of events: null where nothing can be said.
fn seconds(left: Option<f64>) -> Value {
    left.map_or(Value::Null, |left| json!(rounded(left, 10.0)))
}

impl Progress {
    /// A bar for work of `frames` frames; hidden where stderr is no terminal or nothing shall be said.
    pub fn new(frames: usize, global: &Global) -> Self {
        let target = if global.quiet || events::on() || !terminal::obeys() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(10)
        };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        let style = ProgressStyle::with_template("{msg:24} {wide_bar} {percent:>3}%  {elapsed} gone{prefix}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, quiet: global.quiet, frames, preparing: Mutex::new(Told::now()), of_frames: Mutex::new(None) }
    }

    /// What is being done now.
    pub fn stage(&self, text: &str) {
        self.bar.set_message(text.to_owned());
    }

    /// What comes before the first frame is done by this share; `what` is being done.
    pub fn of_preparing(&self, share: f64, what: &str) {
        let mut told = self.preparing.lock().unwrap_or_else(PoisonError::into_inner);
        told.reach(share);
        if self.bar.message() != what {
            self.stage(what);
        }
        self.show(&told, 1, " of measuring");
        if events::on() && told.is_due() {
            let fields =
                json!({ "doing": what, "share": rounded(told.share, 1e4), "seconds_left": seconds(told.left()) });
            events::tell("preparing", &fields);
        }
    }

    /// `done` frames are finished, and `fraction` of the next one.
    pub fn at(&self, done: usize, fraction: f64) {
        self.reach(done, fraction, |_| ());
    }

    /// As [`Self::at`], with the frame's number, for the log of events.
    pub fn of_frame(&self, frame: i64, done: usize, fraction: f64) {
        self.reach(done, fraction, |told| {
            if events::on() && told.is_due() {
                let fields = json!({
                    "frame": frame,
                    "frame_share": rounded(fraction, 1e3),
                    "share": rounded(told.share, 1e4),
                    "seconds_left": seconds(told.left()),
                });
                events::tell("progress", &fields);
            }
        });
    }

    fn reach(&self, done: usize, fraction: f64, tell: impl FnOnce(&mut Told)) {
        let mut told = self.of_frames.lock().unwrap_or_else(PoisonError::into_inner);
        let told = told.get_or_insert_with(Told::now);
        told.reach((done as f64 + fraction.clamp(0.0, 1.0)) / self.frames.max(1) as f64);
        self.show(told, self.frames, "");
        tell(told);
    }

    /// Brings the bar to where the work is, `of` so many things, and the time left.
    fn show(&self, told: &Told, of: usize, what: &str) {
        let length = of.max(1) as u64 * STEPS;
        self.bar.set_length(length);
        self.bar.set_position((told.share * length as f64) as u64);
        let left = told.left().map(|left| HumanDuration(Duration::from_secs(left.round() as u64)));
        self.bar.set_prefix(left.map_or_else(String::new, |left| format!(", {left:#}{what} left")));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_time_is_left_before_it_means_something() {
        for (gone, share) in [(4.8, 1e-4), (60.0, 0.0), (0.3, 0.5), (30.0, 0.049)] {
            assert_eq!(left(Duration::from_secs_f64(gone), share), None, "{share} in {gone} s");
        }
        assert_eq!(left(Duration::from_secs(10), 0.25), Some(30.0));
        assert_eq!(left(Duration::from_secs(10), 1.0), Some(0.0));
        assert_eq!(seconds(None), Value::Null);
    }

    /// One bar after the other: what is measured is at 100 % when the frames begin at 0.
    #[test]
    fn the_bar_is_where_the_work_is() {
        let bar = ProgressBar::hidden();
        let progress = Progress {
            bar: bar.clone(),
            quiet: true,
            frames: 4,
            preparing: Mutex::new(Told::now()),
            of_frames: Mutex::new(None),
        };
        let share = || bar.position() as f64 / bar.length().unwrap_or(1) as f64;
        progress.of_preparing(0.14, "measuring a and b");
        assert_eq!(bar.message(), "measuring a and b");
        assert_eq!(share(), 0.14);
        // Told out of order.
        progress.of_preparing(0.1, "measuring a and b");
        assert_eq!(share(), 0.14);
        progress.of_preparing(1.0, "");
        assert_eq!(share(), 1.0);
        progress.at(0, 0.0);
        assert_eq!(share(), 0.0);
        progress.of_frame(7, 2, 0.5);
        assert_eq!(share(), 0.625);
    }
}
