//! Shapes by their measures.

pub(crate) mod capsule;
pub(crate) mod cuboid;
pub(crate) mod cylinder;
pub(crate) mod ellipsoid;
pub(crate) mod formula;
pub(crate) mod half_space;
pub(crate) mod heart;
pub(crate) mod slab;
pub(crate) mod sphere;
pub(crate) mod torus;
