//! An attribute of a shape at one moment.

use std::sync::Arc;

use crate::attribute::{Attribute, Constant};
use crate::node::placed::{Placed, Way};

/// An attribute, and whether it has one value everywhere.
#[derive(Clone)]
pub struct Paint<const N: usize> {
    /// The attribute.
    pub attribute: Arc<dyn Attribute<N>>,
    /// That value.
    pub solid: Option<[f32; N]>,
}

impl<const N: usize> Paint<N> {
    /// One value everywhere.
    pub fn solid(value: [f32; N]) -> Self {
        Self { attribute: Arc::new(Constant::new(value)), solid: Some(value) }
    }

    pub fn of(attribute: impl Attribute<N> + 'static) -> Self {
        Self::shared(Arc::new(attribute))
    }

    pub fn shared(attribute: Arc<dyn Attribute<N>>) -> Self {
        Self { attribute, solid: None }
    }

    /// Seen through a way; one value stays itself.
    pub(crate) fn through(self, way: Way) -> Self {
        match self.solid {
            Some(_) => self,
            None => Self::of(Placed { inner: self.attribute, way }),
        }
    }
}
