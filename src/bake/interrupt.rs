//! The flag by which a caller ends long work.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The flag that long work looks at: once it is raised, the work ends with nothing half-written.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    flag: Arc<AtomicBool>,
}

impl Interrupt {
    /// The flag itself.
    pub fn flag(&self) -> &Arc<AtomicBool> {
        &self.flag
    }

    /// Raises the flag.
    pub fn raise(&self) {
        self.flag.store(true, Ordering::SeqCst);
    }

    /// Whether the flag is raised.
    pub fn is_raised(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }
}
