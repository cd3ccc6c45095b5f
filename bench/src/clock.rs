//! Seconds by the clock and of the processor, and rivals that run in turns.

use std::time::Instant;

use rustix::time::{ClockId, clock_gettime};

/// Seconds by the clock, and of the processor on all threads: on a busy machine the second says more.
pub type Seconds = [f64; 2];

/// The names of the two.
pub const CLOCKS: [&str; 2] = ["clock", "processor"];

/// Seconds that all threads of the process have run.
fn processor_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// What some work takes, and what it gives. The end of what it gives is not counted.
pub fn timed<T>(work: impl FnOnce() -> T) -> (Seconds, T) {
    let (start, processor) = (Instant::now(), processor_seconds());
    let result = work();
    ([start.elapsed().as_secs_f64(), processor_seconds() - processor], result)
}

/// Seconds that a sample of two threads against one takes at least, by one run after the other: threads that slept need
/// some milliseconds to spread over the cores, which are none of the work's.
const SAMPLE: f64 = 0.5;

/// Seconds a run, over many.
pub fn time_of_many(work: impl Fn() -> Seconds) -> Seconds {
    let (mut total, mut runs) = ([0.0; 2], 0.0);
    while total[0] < SAMPLE {
        let [clock, processor] = work();
        total = [total[0] + clock, total[1] + processor];
        runs += 1.0;
    }
    total.map(|seconds| seconds / runs)
}

/// Ours and theirs, run one after the other, the first of a pair in turns, so that both meet the same machine. One
/// pair before them warms memory and caches.
pub fn pairs(
    rounds: usize,
    mut ours: impl FnMut() -> Seconds,
    mut theirs: impl FnMut() -> Seconds,
) -> Vec<[Seconds; 2]> {
    ours();
    theirs();
    let pair = |round| match round % 2 {
        0 => {
            let first = ours();
            [first, theirs()]
        }
        _ => {
            let first = theirs();
            [ours(), first]
        }
    };
    (0..rounds).map(pair).collect()
}

/// The median, and the borders of the middle half.
pub fn quartiles(list: impl IntoIterator<Item = f64>) -> [f64; 3] {
    let mut list: Vec<f64> = list.into_iter().collect();
    list.sort_by(f64::total_cmp);
    [list[list.len() / 2], list[list.len() / 4], list[list.len() * 3 / 4]]
}
