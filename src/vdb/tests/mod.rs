//! Tests of the border. The judges are OpenVDB itself, in C++ and Debian's Python, and a reader in pure Rust, not the code under test.

mod decode;
mod lint;
mod read;
pub(super) mod support;
mod walk;
mod write;
