//! What is done to the surface of a shape.

pub(crate) mod bounds;
pub(crate) mod displace;
pub(crate) mod offset;
pub(crate) mod shell;
