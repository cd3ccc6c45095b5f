//! What is to be baked, before anything is.

use super::Existing;
use super::frames::Frames;
use super::identity::Identity;
use super::manifest::Source;

/// What somebody wants to bake.
#[derive(Clone, Debug)]
pub struct Wish {
    /// What decides the voxels.
    pub identity: Identity,
    /// Where that came from.
    pub source: Source,
    /// The frames asked for.
    pub frames: Frames,
    /// What to do with files that exist.
    pub existing: Existing,
}
