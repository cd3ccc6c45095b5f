//! What identifies the solids whose distances are measured while shapes are made, so that these are kept in a cache.

use std::sync::Arc;

use sha2::{Digest, Sha256};

use crate::node::cache::Cache;
use crate::node::id::{ShapeId, Stage};
use crate::node::model::Model;

/// A solid whose distance is asked for, told from all others of the scene by how it is made.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Solid {
    /// A shape, made as far as a stage.
    Stage(ShapeId, Stage),
    /// A shape in its own space, with so many of its modifiers.
    Step(ShapeId, usize),
    /// What the making of a step asks for, the so many-th time that it asks.
    Asked {
        /// The shape.
        id: ShapeId,
        /// The step.
        step: usize,
        /// What of the step is made.
        making: &'static str,
        /// How often it asked before.
        before: usize,
    },
}

/// A cache, and what besides the solid decides the numbers of one moment of a scene.
#[derive(Clone)]
pub(crate) struct Keeping {
    cache: Arc<Cache>,
    model: Arc<Model>,
    frame: f64,
    resolution: f64,
}

impl Keeping {
    pub fn new(cache: Arc<Cache>, model: &Arc<Model>, frame: f64, resolution: f64) -> Self {
        Self { cache, model: Arc::clone(model), frame, resolution }
    }

    /// The same at another frame.
    pub fn at(self, frame: f64) -> Self {
        Self { frame, ..self }
    }

    pub fn cache(&self) -> &Cache {
        &self.cache
    }

    /// The key of the distance to a solid, or to one of its parts, that a method measures by these numbers. `None` where
    /// a file cannot be read by now, of which is told when its frame is made.
    ///
    /// Making a shape is deterministic: the text of all that decides it, the frame, the resolution, and which of the calls
    /// of its making this is, decide the solid.
    pub fn key(&self, solid: Solid, part: Option<usize>, method: &str, numbers: &[f64]) -> Option<[u8; 32]> {
        let (id, stage, how) = match solid {
            Solid::Stage(id, Stage::Bare) => (id, Stage::Own, "bare".to_owned()),
            Solid::Stage(id, stage) => (id, stage, String::new()),
            Solid::Step(id, step) => (id, Stage::Own, format!("step {step}")),
            Solid::Asked { id, step, making, before } => {
                (id, Stage::Own, format!("{making} of step {step}, {before} before"))
            }
        };
        let text = self.model.part_hash(id, stage).ok()?;
        let how = format!("{how}, part {part:?}, by {method}");
        let of = Sha256::new().chain_update(text).chain_update(how).finalize();
        let moment = [self.frame, self.resolution];
        Some(self.cache.key(&of, &[&moment, numbers].concat()))
    }
}
