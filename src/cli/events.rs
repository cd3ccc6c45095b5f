//! The log of events for farms: one JSON object a line on stderr, where `--progress json` asks for it.

use std::io::Write;
use std::sync::OnceLock;
use std::time::Instant;

use serde_json::{Value, json};

use crate::terminal;

/// Since when events are logged; never set where they are not.
static START: OnceLock<Instant> = OnceLock::new();

/// Logs events from now on.
pub fn start() {
    START.get_or_init(Instant::now);
}

/// Whether events are logged: then stderr holds nothing else.
pub fn on() -> bool {
    START.get().is_some()
}

/// Logs an event with its fields, an object; false where events are not logged.
pub fn tell(event: &str, fields: &Value) -> bool {
    let Some(start) = START.get() else { return false };
    let fields = fields.to_string();
    let fields = fields.trim_start_matches('{');
    let comma = if fields == "}" { "" } else { "," };
    let line = format!("{{\"event\":\"{event}\",\"seconds\":{:.3}{comma}{fields}\n", start.elapsed().as_secs_f64());
    // One write a line, so that lines of threads do not mix. Nothing is left to say when stderr is closed.
    let _ = std::io::stderr().lock().write_all(terminal::json(&line).as_bytes());
    true
}

/// The last words before an end by force.
pub fn interrupted(exit_code: u8) {
    const MESSAGE: &str = "interrupted; finished frames are whole, nothing half-written is left";
    if !tell("interrupted", &json!({ "exit_code": exit_code, "message": MESSAGE })) {
        // Nothing is left to say when stderr is closed.
        let _ = std::io::stderr().lock().write_all(format!("error: {MESSAGE}\n").as_bytes());
    }
}
