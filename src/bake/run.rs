//! The bake: frame after frame, the next one computed while the last one is written.

use std::collections::VecDeque;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use super::compute::Computed;
use super::done::{State, judge};
use super::estimate::in_flight;
use super::frame::{Staged, commit_frame, compute_frame, empty, stage_frame, warnings};
use super::identity::Identity;
use super::output::Format;
use super::record::{Record, RecordFile};
use super::sealed;
use super::sequence::Sequence;
use super::{Bytes, Error, Interrupt};
use crate::disk::{self, FileLock};
use crate::grid::measure;
use crate::shot::Prepared;
use crate::vdb;

/// What to do with files that exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Refuse to bake.
    Refuse,
    /// Keep frames that are done, replace others.
    Resume,
    /// Replace all.
    Overwrite,
}

impl Existing {
    /// Whether a file that exists may be replaced.
    pub fn replaces(self) -> bool {
        self != Self::Refuse
    }
}

/// What to write and how.
#[derive(Clone, Debug)]
pub struct Output {
    /// One file a frame, and what stands beside them.
    pub sequence: Sequence,
    /// What decides the voxels.
    pub identity: Identity,
    /// What the files are.
    pub format: &'static dyn Format,
    /// Compression of the voxels.
    pub compression: vdb::Compression,
    /// What to do with files that exist.
    pub existing: Existing,
    /// Write empty frames instead of failing.
    pub allow_empty: bool,
    /// The most memory that the job may take.
    pub max_memory: Bytes,
}

/// What happens while baking. `place` is a frame's place among the frames.
pub enum Event<'a> {
    /// Work on a frame begins.
    Started {
        /// Its place.
        place: usize,
        /// Its number.
        frame: i64,
    },
    /// A share (0 to 1) of a frame is done.
    Progress {
        /// Its place.
        place: usize,
        /// Its number.
        frame: i64,
        /// The share.
        share: f64,
    },
    /// Something to tell the user about a frame.
    Warning(i64, String),
    /// A frame is on the disk.
    Written(&'a Record),
    /// A frame was found done: another process has baked it meanwhile.
    Kept(&'a Record),
    /// A frame failed; others go on.
    Failed(i64, &'a Error),
}

/// What came of a bake.
#[derive(Debug, Default)]
pub struct Baked {
    /// The frames written by this call.
    pub written: Vec<Record>,
    /// The frames that another process has baked meanwhile.
    pub kept: Vec<Record>,
    /// The frames that failed by themselves.
    pub failed: Vec<(i64, Error)>,
    /// Why the rest was not tried.
    pub stopped: Option<Error>,
}

/// How long to wait before another look at frames that others bake.
const PAUSE: Duration = Duration::from_millis(100);

/// A frame on its way to the writer. It stays locked until its record stands.
struct Computing {
    frame: i64,
    computed: Computed,
    duration: Duration,
    lock: FileLock,
}

/// Bakes frames into files, in order.
///
/// Goes on after a frame that fails by itself; stops when no other could succeed. The files written until then are
/// whole and stay. Frames that another process bakes are waited for, and baked if it fails.
pub fn bake(
    prepared: &Prepared,
    frames: &[i64],
    output: &Output,
    interrupt: &Interrupt,
    events: &(dyn Fn(Event<'_>) + Sync),
) -> Baked {
    // Rendezvous: one frame is computed while one is written, never more; one that is staged waits for the disk, and
    // takes no memory.
    let (send, receive) = mpsc::sync_channel::<Computing>(0);
    let (send_staged, receive_staged) = mpsc::sync_channel::<Committing>(0);
    thread::scope(|scope| {
        let writer = scope.spawn(move || write_all(prepared, receive, output, events, &send_staged));
        let committer = scope.spawn(move || commit_all(receive_staged, output, events));
        let mut baked = compute_all(prepared, frames, output, interrupt, events, &send);
        drop(send);
        for later in [writer, committer] {
            let later = later.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            baked.written.extend(later.written);
            baked.failed.extend(later.failed);
            // What fails later on a frame's way is why what comes before has stopped.
            baked.stopped = later.stopped.or(baked.stopped);
        }
        baked.failed.sort_by_key(|(frame, _)| *frame);
        baked
    })
}

/// A frame that is staged, with its lock.
struct Committing {
    staged: Staged,
    lock: FileLock,
}

/// Writes what comes, until the disk takes no more.
fn write_all(
    prepared: &Prepared,
    receive: mpsc::Receiver<Computing>,
    output: &Output,
    events: &(dyn Fn(Event<'_>) + Sync),
    send: &mpsc::SyncSender<Committing>,
) -> Baked {
    let mut baked = Baked::default();
    for Computing { frame, computed, duration, lock } in receive {
        match stage_frame(prepared, frame, &computed, output, duration) {
            Ok(staged) => {
                drop(computed);
                staged.warning(output).into_iter().for_each(|warning| events(Event::Warning(frame, warning)));
                if send.send(Committing { staged, lock }).is_err() {
                    break;
                }
            }
            Err(error) if error.is_of_frame() => fail(&mut baked, frame, error, events),
            Err(error) => {
                baked.stopped = Some(error);
                break;
            }
        }
    }
    baked
}

/// Gives what is staged its name, until the disk takes no more.
fn commit_all(receive: mpsc::Receiver<Committing>, output: &Output, events: &(dyn Fn(Event<'_>) + Sync)) -> Baked {
    let mut baked = Baked::default();
    for Committing { staged, lock } in receive {
        let frame = staged.frame();
        let result = commit_frame(staged, output);
        drop(lock);
        match result {
            Ok(record) => {
                events(Event::Written(&record));
                baked.written.push(record);
            }
            Err(error) if error.is_of_frame() => fail(&mut baked, frame, error, events),
            Err(error) => {
                baked.stopped = Some(error);
                break;
            }
        }
    }
    baked
}

fn fail(baked: &mut Baked, frame: i64, error: Error, events: &(dyn Fn(Event<'_>) + Sync)) {
    events(Event::Failed(frame, &error));
    baked.failed.push((frame, error));
}

/// Computes the frames and hands them to the writer, until it is gone.
fn compute_all(
    prepared: &Prepared,
    frames: &[i64],
    output: &Output,
    interrupt: &Interrupt,
    events: &(dyn Fn(Event<'_>) + Sync),
    send: &mpsc::SyncSender<Computing>,
) -> Baked {
    let mut baked = Baked::default();
    let in_flight = in_flight(frames.len());
    let mut queue: VecDeque<usize> = (0..frames.len()).collect();
    let mut elsewhere = VecDeque::new();
    loop {
        if interrupt.is_raised() {
            baked.stopped = Some(Error::Interrupted);
            return baked;
        }
        let Some(place) = queue.pop_front() else {
            if elsewhere.is_empty() {
                return baked;
            }
            thread::sleep(PAUSE);
            queue.append(&mut elsewhere);
            continue;
        };
        let frame = frames[place];
        let lock = match FileLock::try_take(&output.sequence.frame_lock(frame)) {
            Ok(Some(lock)) => lock,
            Ok(None) => {
                elsewhere.push_back(place);
                continue;
            }
            Err(error) => {
                baked.stopped = Some(error.into());
                return baked;
            }
        };
        match meanwhile(frame, output, interrupt) {
            Ok(None) => {}
            Ok(Some(record)) => {
                events(Event::Kept(&record));
                baked.kept.push(record);
                continue;
            }
            Err(error) => {
                fail(&mut baked, frame, error, events);
                continue;
            }
        }
        events(Event::Started { place, frame });
        let start = Instant::now();
        match compute_one(prepared, place, frame, in_flight, output, interrupt, events) {
            Ok(computed) => {
                if send.send(Computing { frame, computed, duration: start.elapsed(), lock }).is_err() {
                    return baked;
                }
            }
            Err(error) if error.is_of_frame() => fail(&mut baked, frame, error, events),
            Err(error) => {
                baked.stopped = Some(error);
                return baked;
            }
        }
    }
}

/// The frame as another process has baked it since this one began; an error where something else stands there.
fn meanwhile(frame: i64, output: &Output, interrupt: &Interrupt) -> Result<Option<Record>, Error> {
    let path = output.sequence.pattern.file(frame);
    if output.existing == Existing::Overwrite || path.symlink_metadata().is_err() {
        return Ok(None);
    }
    let file = sealed::read::<RecordFile>(&output.sequence.record(frame)).ok().flatten();
    let known = file.map(|file| (file.identity, file.record));
    match judge(&path, frame, known.as_ref(), &output.identity, interrupt) {
        Some(State::Done(record)) => Ok(Some(*record)),
        _ if output.existing.replaces() || interrupt.is_raised() => Ok(None),
        _ => Err(disk::Error::Exists { path }.into()),
    }
}

/// Computes one frame, and tells what there is to say about it.
fn compute_one(
    prepared: &Prepared,
    place: usize,
    frame: i64,
    in_flight: usize,
    output: &Output,
    interrupt: &Interrupt,
    events: &(dyn Fn(Event<'_>) + Sync),
) -> Result<Computed, Error> {
    let progress = |share: f64| events(Event::Progress { place, frame, share });
    let computed = match compute_frame(prepared, frame, in_flight, output.max_memory, interrupt, &progress) {
        Err(error) if output.allow_empty && error.is_empty_frame() => {
            events(Event::Warning(frame, "it is empty".into()));
            empty(prepared)
        }
        computed => computed?,
    };
    let computed = match measure::has_inside(&computed.band) || computed.band.origins.is_empty() {
        true => computed,
        false if output.allow_empty => {
            events(Event::Warning(frame, "nothing is inside at this voxel size: it is empty".into()));
            empty(prepared)
        }
        false => {
            let thin = computed.report.thin.iter().map(|thin| thin.size).filter(|&size| size > 0.0);
            return Err(Error::Hollow { frame, enough: thin.reduce(f64::min) });
        }
    };
    for warning in warnings(&computed) {
        events(Event::Warning(frame, warning));
    }
    if interrupt.is_raised() { Err(Error::Interrupted) } else { Ok(computed) }
}
