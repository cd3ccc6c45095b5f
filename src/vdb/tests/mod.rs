//! Tests of the border. The judges are Debian's Python OpenVDB and a reader in pure Rust, not the code under test.

mod lint;
mod read;
pub(super) mod support;
mod walk;
mod write;
