//! SIGINT, SIGTERM, SIGHUP and SIGXCPU: an orderly end where the work allows it, an end within two seconds in any case,
//! and nothing half-written either way. SIGXFSZ: an error of the write that passed the limit.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXCPU, SIGXFSZ};
use signal_hook::iterator::Signals;

use super::failure::Failure;
use crate::bake::Interrupt;
use crate::disk;

/// How long the work may take to notice the flag; past it the process ends by force. Shorter would cut frames off
/// that are about to be whole, longer would break the promise of two seconds.
const PATIENCE: Duration = Duration::from_millis(1500);

/// The signal that came first; 0 before one did.
static SIGNAL: AtomicI32 = AtomicI32::new(0);

/// Starts to listen for signals, once in a process, and gives the flag that they raise. `last_words` is called with the
/// exit code before an end by force.
pub fn listen(last_words: fn(u8)) -> io::Result<Interrupt> {
    let interrupt = Interrupt::default();
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGXCPU])?;
    // Under nohup the work is to go on without its terminal.
    if !is_ignored(SIGHUP) {
        signals.add_signal(SIGHUP)?;
    }
    let shared = interrupt.clone();
    thread::Builder::new().name("signals".into()).spawn(move || {
        for signal in signals.forever() {
            if SIGNAL.compare_exchange(0, signal, Ordering::SeqCst, Ordering::SeqCst).is_err() {
                // The system repeats that one with each second of the processor: it is no second wish.
                if signal == SIGXCPU {
                    continue;
                }
                end_now(signal, last_words);
            }
            shared.raise();
            thread::spawn(move || {
                thread::sleep(PATIENCE);
                end_now(signal, last_words);
            });
        }
    })?;
    Ok(interrupt)
}

/// The failure that goes with the signal that came.
pub fn interrupted() -> Failure {
    Failure::interrupted(exit_code(SIGNAL.load(Ordering::SeqCst)))
}

fn exit_code(signal: i32) -> u8 {
    u8::try_from(signal).map_or(128, |number| 128 + number)
}

/// Lets writes past the limit on the size of files fail, as on a full disk: SIGXFSZ would end the process in the midst of
/// them. For the whole process, before it writes anything.
pub fn survive_file_size_limit() {
    // A handler is all that is needed, whatever it does. Without one the signal kills, as it did.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
}

/// Whether whoever started the process let it ignore a signal.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Removes what is half-written and ends the process without running destructors: other threads are at work still.
fn end_now(signal: i32, last_words: fn(u8)) -> ! {
    disk::remove_registered();
    // A reader of stderr that does not read must not hold the end up.
    let (said, wait) = std::sync::mpsc::channel();
    thread::spawn(move || {
        last_words(exit_code(signal));
        // The other end waits, or the process is gone.
        let _ = said.send(());
    });
    let _ = wait.recv_timeout(Duration::from_millis(100));
    signal_hook::low_level::exit(exit_code(signal).into())
}
