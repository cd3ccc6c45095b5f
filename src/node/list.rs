//! All nodes: a line for each.

use super::color::{
    bands::BANDS, components::HSV, components::LINEAR, palette::PALETTE, parts::PARTS, range::RANGE, vdb::VDB,
};
use super::combine::{blend::BLEND, difference::DIFFERENCE, intersection::INTERSECTION, union::UNION};
use super::copies::at::AT;
use super::import::mesh::MESH;
use super::number::{self, values::VALUES};
use super::primitive::{
    capsule::CAPSULE, cuboid::BOX, cylinder::CYLINDER, ellipsoid::ELLIPSOID, formula::FORMULA, half_space::HALF_SPACE,
    heart::HEART, slab::SLAB, sphere::SPHERE, torus::TORUS,
};
use super::source::Source;
use super::space::mirror::MIRROR;
use super::spec::Spec;
use super::structure::facet::FACET;
use super::surface::{bounds::BOUNDS, displace::DISPLACE, offset::OFFSET, shell::SHELL};

use crate::text::key::Key;

/// What a shape can be: exactly one of these. In the order of the documentation.
pub static MAKERS: &[Spec] = &[
    SPHERE,
    BOX,
    ELLIPSOID,
    CYLINDER,
    TORUS,
    CAPSULE,
    HALF_SPACE,
    SLAB,
    HEART,
    FORMULA,
    MESH,
    UNION,
    INTERSECTION,
    DIFFERENCE,
    BLEND,
    FACET,
];

/// What can be done to a shape, in the order of work whatever the order of the text.
pub static MODIFIERS: &[Spec] = &[BOUNDS, AT, MIRROR, OFFSET, SHELL, DISPLACE];

/// Where a colour written as a table can come from.
pub static COLOURS: &[Source<3>] = &[LINEAR, HSV, PALETTE, RANGE, BANDS, PARTS, VDB];

/// Where a scalar written as a table can come from.
pub static SCALARS: &[Source<1>] =
    &[VALUES, number::range::RANGE, number::bands::BANDS, number::parts::PARTS, number::vdb::VDB];

/// What a shape can be, by one of the names of its key.
pub fn maker(name: &str) -> Option<&'static Spec> {
    MAKERS.iter().find(|spec| spec.key.is_called(name))
}

/// What a parameter of a shape goes with.
pub fn owner(name: &str) -> Option<&'static str> {
    let owns = |spec: &&'static Spec| spec.parameters.iter().any(|key| key.is_called(name));
    MAKERS.iter().chain(MODIFIERS).find(owns).map(|spec| spec.key.name)
}

/// The keys of everything that can be done to a shape.
pub fn modifier_keys() -> impl Iterator<Item = &'static Key> + Clone {
    MODIFIERS.iter().flat_map(Spec::keys)
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
