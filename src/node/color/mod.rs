//! Where colours come from.

pub(crate) mod bands;
pub(crate) mod components;
pub(crate) mod palette;
pub(crate) mod parts;
pub(crate) mod range;
pub(crate) mod vdb;
