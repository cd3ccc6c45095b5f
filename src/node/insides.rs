//! Insides of shapes at one moment: their nodes and what was spread from features. Each is found once, and kept from frame
//! to frame where neither the shape nor the feature changes in the shape's own space.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::attribute::conformal::{Body, Feature};
use crate::node::id::ShapeId;
use crate::node::variation::Variation;
use crate::text::diagnostic::Diagnostic;

/// A shape with so many of its modifiers, and the cells along its longest side.
pub(crate) type BodyKey = (ShapeId, usize, u32);

/// What was found of insides.
#[derive(Clone, Default)]
pub(crate) struct Insides {
    /// Their nodes.
    pub bodies: BTreeMap<BodyKey, Arc<Body>>,
    /// What was spread in them.
    pub features: BTreeMap<(BodyKey, ShapeId), Arc<Feature>>,
    /// What was noticed.
    pub warnings: Vec<Diagnostic>,
}

impl Insides {
    /// Keeps what does not change over the shot.
    pub fn keep_still(&mut self, variation: &Variation) {
        let is_still = |(id, step, _): &BodyKey| !variation.step(*id, *step);
        self.bodies.retain(|body, _| is_still(body));
        self.features.retain(|(body, feature), _| is_still(body) && !variation.placed(*feature));
        self.warnings.clear();
    }

    /// The memory that they hold, bytes.
    pub fn bytes(&self) -> usize {
        let bodies = self.bodies.values().map(|body| body.bytes());
        bodies.chain(self.features.values().map(|feature| feature.bytes())).sum()
    }

    /// What was noticed since the last time.
    pub fn take_warnings(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.warnings)
    }
}
