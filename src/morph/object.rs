//! What a morph starts from, and what it ends with.

use std::sync::Arc;

use super::motion::Motion;
use crate::attribute::Colour;
use crate::distance::Distance;
use crate::field::{Aabb, Field};

/// An object of a morph, in its own space, with its motion.
#[derive(Clone)]
pub struct MorphObject {
    /// Its own field, creases and all: what the first or last frame shows.
    pub surface: Arc<dyn Field>,
    /// Its signed distance everywhere, which the in-betweens are made of.
    pub distance: Arc<dyn Distance>,
    /// Its colour.
    pub colour: Arc<Colour>,
    /// Where it stands, over scene time.
    pub motion: Motion,
}

impl MorphObject {
    /// The box around it in its own space, that of a shape of the plane at z = 0; `None` where it has no end.
    pub(super) fn own_box(&self) -> Option<Aabb> {
        let own = self.distance.bounding_box()?;
        let own = if own.is_of_plane() { own.at_z(0.0) } else { own };
        (own.min.is_finite() && own.max.is_finite()).then_some(own)
    }
}
