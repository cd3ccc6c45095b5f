//! Many of one shape.

pub(crate) mod at;
