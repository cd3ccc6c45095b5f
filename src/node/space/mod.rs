//! What bends the space of a shape.

pub(crate) mod mirror;
