//! The scene format: text with places, checked into a model with names resolved.
