//! Files on the disk that are whole or not there, and locks that go with their process.
//!
//! * [`write_whole`] and [`write_new`] make a small file under a temporary name, syncs and renames it.
//! * [`stage`] does so for a large one, up to what waits for the disk: [`Staged::commit`]; [`stage_stream`] for one that
//!   is never whole in memory.
//! * [`FileLock`] is a lock of the operating system: however a process ends, its locks end with it.
//! * [`remove_registered`] takes away the temporaries and locks of this process, just before it ends by force.
//! * [`read()`], [`read_at_most`] and [`open`] read regular files, and nothing else.
//! * [`free_bytes`] is the room that is left.
//!
//! What files hold is not known here.

mod error;
mod lock;
mod read;
mod register;
mod space;
mod staged;
mod temporary;

pub use error::Error;
pub use lock::FileLock;
pub use read::{open, read, read_at_most};
pub use register::remove_registered;
pub use space::free_bytes;
pub use staged::{Staged, Written, check_target, stage, stage_stream};
pub use temporary::{Temporary, folder_of, temporary_target, write_new, write_whole};

#[cfg(test)]
mod tests;
