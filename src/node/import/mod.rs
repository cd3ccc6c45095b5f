//! Shapes from files.

pub(crate) mod mesh;
