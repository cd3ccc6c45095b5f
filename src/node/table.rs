//! Looking rows up in the tables of nodes.

use super::list::{COLOURS, MAKERS, MODIFIERS, SCALARS};
use super::source::Source;
use super::spec::Spec;
use crate::text::key::Key;

/// What a shape can be, by one of the names of its key.
pub fn maker(name: &str) -> Option<&'static Spec> {
    MAKERS.iter().find(|spec| spec.key.is_called(name))
}

/// The keys of everything that can be done to a shape.
pub fn modifier_keys() -> impl Iterator<Item = &'static Key> + Clone {
    MODIFIERS.iter().flat_map(Spec::keys)
}

/// What a parameter of a shape goes with.
pub fn shape_owner(name: &str) -> Option<&'static str> {
    let owns = |spec: &&'static Spec| spec.parameters.iter().any(|key| key.is_called(name));
    MAKERS.iter().chain(MODIFIERS).find(owns).map(|spec| spec.key.name)
}

/// What a parameter of a colour goes with.
pub fn colour_owner(name: &str) -> Option<&'static str> {
    owner_among(COLOURS, name)
}

/// What a parameter of a scalar goes with.
pub fn scalar_owner(name: &str) -> Option<&'static str> {
    owner_among(SCALARS, name)
}

fn owner_among<const N: usize>(sources: &'static [Source<N>], name: &str) -> Option<&'static str> {
    let owns = |source: &&'static Source<N>| source.parameters.iter().any(|key| key.is_called(name));
    sources.iter().find(owns).map(|source| source.key.name)
}
