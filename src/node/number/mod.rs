//! Where scalars come from.

pub(crate) mod bands;
pub(crate) mod parts;
pub(crate) mod range;
pub(crate) mod value;
pub(crate) mod values;
pub(crate) mod vdb;
