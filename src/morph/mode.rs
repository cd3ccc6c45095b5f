//! How a morph's shape changes: one way, one file.

pub(crate) mod linear;
pub(crate) mod paper;
pub(crate) mod still;
pub(crate) mod union;
pub(crate) mod volume;

use std::fmt::Debug;
use std::sync::Arc;

use super::coarse::{CoarseGrid, Measured};
use super::error::Error;
use super::section::Section;
use crate::distance::Distance;
use crate::field::{Aabb, Expression, Field, Graph, Node};

/// How the shape changes between the objects at both ends.
pub trait Mode: Debug + Send + Sync {
    /// What is out of range at scene time τ, which lies at a share of the span of the shape's change.
    fn check(&self, _share: f64, _time: f64) -> Result<(), Error> {
        Ok(())
    }

    /// How t follows the morph's progress.
    fn pace(&self) -> Pace {
        Pace::Time
    }

    /// Whether it can carry its objects along a way.
    fn carries(&self) -> bool {
        true
    }

    /// Whether the shape is the first object's all along.
    fn stays(&self) -> bool {
        false
    }

    /// The mode whose a₀ follows from a volume. It alone can let places wait.
    fn volume(&self) -> Option<&volume::Volume> {
        None
    }

    /// What is between the objects at t in (0, 1) and scene time τ.
    fn between(&self, t: f64, time: f64) -> Between<'_>;
}

/// What is between the objects.
pub enum Between<'a> {
    /// A section of the blend.
    Section(Section),
    /// The section whose a₀ encloses the volume of the straight way.
    Enclosing(Section),
    /// What a formula makes of the two.
    Formula(Box<dyn Combine + 'a>),
}

/// A formula of the two objects' F.
pub trait Combine {
    /// The frame's field in world units.
    fn field(&self, pair: &Placed) -> Arc<dyn Field>;

    /// The fraction inside of each cell of the coarse grid; `unit` is D.
    fn fractions(&self, grid: &CoarseGrid, measured: &Measured, unit: f64) -> Vec<f32>;
}

/// The two objects where they stand at a scene time.
pub struct Placed {
    /// Their distances.
    pub distances: [Arc<dyn Distance>; 2],
    /// Their own fields.
    pub surfaces: [Arc<dyn Field>; 2],
}

/// How t follows the morph's progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// Equal steps change equal volumes.
    #[default]
    Even,
    /// t is the progress itself, as in the papers.
    Time,
}

/// The field of a node that is negative outside of the box around both.
fn expression(graph: &Graph, node: Node, boxes: [Option<Aabb>; 2]) -> Arc<dyn Field> {
    let field = Expression::new(graph, node);
    match boxes {
        [Some(first), Some(second)] => Arc::new(field.known_within(first.union(second))),
        _ => Arc::new(field),
    }
}
