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

/// How something was spread from a feature of a body: the shape or, of `None`, the body's own surface, and the method.
pub(crate) type FeatureKey = (BodyKey, Option<ShapeId>, MethodKey);

/// The method: its speed by where the scene's text gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum MethodKey {
    /// Ways that are straight in between bends.
    Sight,
    /// The eikonal equation, with the text and the place of its speed.
    Eikonal(Option<(usize, usize)>),
}

/// What was found of insides.
#[derive(Clone, Default)]
pub(crate) struct Insides {
    /// Their nodes.
    pub bodies: BTreeMap<BodyKey, Arc<Body>>,
    /// What was spread in them.
    pub features: BTreeMap<FeatureKey, Arc<Feature>>,
    /// What was noticed.
    pub warnings: Vec<Diagnostic>,
}

impl Insides {
    /// Keeps what does not change over the shot.
    pub fn keep_still(&mut self, variation: &Variation) {
        let is_still = |(id, step, _): &BodyKey| !variation.step(*id, *step);
        self.bodies.retain(|body, _| is_still(body));
        // A speed that changes is one of what the body is painted by.
        let goes_alike = |(id, ..): &BodyKey, method: &MethodKey| match method {
            MethodKey::Sight | MethodKey::Eikonal(None) => true,
            MethodKey::Eikonal(Some(_)) => !variation.painted(*id),
        };
        self.features.retain(|(body, feature, method), _| {
            is_still(body) && feature.is_none_or(|feature| !variation.placed(feature)) && goes_alike(body, method)
        });
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
