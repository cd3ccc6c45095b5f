//! What the benches share: the scenes, the clocks, rivals run in turns, and how results are printed.

pub mod bake;
pub mod clock;
pub mod fill;
pub mod jit;
pub mod memory;
pub mod report;
pub mod rivals;
pub mod scenes;

/// As the program's, for both sides of a comparison.
#[global_allocator]
static ALLOCATOR: tikv_jemallocator::Jemalloc = tikv_jemallocator::Jemalloc;

/// The arguments of a bench but for the flags that cargo passes (`--bench`).
pub fn arguments() -> Vec<String> {
    std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect()
}

/// The numbers among the arguments, or these.
pub fn resolutions(otherwise: &[u32]) -> Vec<u32> {
    let given: Vec<u32> = arguments().iter().filter_map(|argument| argument.parse().ok()).collect();
    if given.is_empty() { otherwise.to_vec() } else { given }
}

/// A pool for so many threads, for the work of this crate and of OpenVDB.
pub fn threads(count: usize) -> rayon::ThreadPool {
    hfvdb::vdb::set_threads(count).expect("a thread limit");
    rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a pool of threads")
}
