//! Looking rows up in the tables of nodes.

use super::list::{COLOURS, MAKERS, MODIFIERS, PLACERS, SCALARS};
use super::source::Source;
use super::spec::Spec;
use crate::text::key::Key;
use crate::text::reader::Owner;

/// What a shape can be, by one of the names of its key.
pub fn maker(name: &str) -> Option<&'static Spec> {
    MAKERS.iter().find(|spec| spec.key.is_called(name))
}

/// The keys of everything that can be done to a shape.
pub fn modifier_keys() -> impl Iterator<Item = &'static Key> + Clone {
    MODIFIERS.iter().flat_map(Spec::keys)
}

/// What can be done to a shape in a list of its own order, by one of the names of its key.
pub fn step(name: &str) -> Option<&'static Spec> {
    steps().find(|spec| spec.key.is_called(name))
}

/// All of that.
pub fn steps() -> impl Iterator<Item = &'static Spec> + Clone {
    MODIFIERS.iter().chain(PLACERS)
}

/// What a parameter of a shape goes with.
pub fn shape_owner(name: &str) -> Option<&'static str> {
    let owns = |spec: &&'static Spec| spec.parameters.iter().any(|key| key.is_called(name));
    MAKERS.iter().chain(MODIFIERS).find(owns).map(|spec| spec.key.name)
}

/// A table of attributes' sources.
pub struct Family<const N: usize> {
    /// Its rows.
    pub sources: &'static [Source<N>],
    /// What a parameter goes with.
    pub owner: Owner,
    /// What they give, for messages.
    pub noun: &'static str,
}

/// Colours.
pub static COLOUR: Family<3> = Family { sources: COLOURS, owner: |name| owner_among(COLOURS, name), noun: "colour" };

/// Scalars.
pub static SCALAR: Family<1> = Family { sources: SCALARS, owner: |name| owner_among(SCALARS, name), noun: "number" };

fn owner_among<const N: usize>(sources: &'static [Source<N>], name: &str) -> Option<&'static str> {
    let owns = |source: &&'static Source<N>| source.parameters.iter().any(|key| key.is_called(name));
    sources.iter().find(owns).map(|source| source.key.name)
}
