//! Shapes made of another by cells.

pub(crate) mod facet;
