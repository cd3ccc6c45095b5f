//! Shapes made of several.

pub(crate) mod blend;
pub(crate) mod difference;
pub(crate) mod intersection;
pub(crate) mod union;
