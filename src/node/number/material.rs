//! A number of the materials of a mesh's file.

use crate::mesh::NumberOf;
use crate::node::painted::Paint;
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A number of the materials of a mesh's file.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "material",
        Kind::Choice(&["roughness", "metallic"]),
        Required,
        "A number of the materials in the file of a `mesh`, at the closest place of the mesh: plain (`roughnessFactor` and `metallicFactor` of glTF, `Pr` and `Pm` of MTL), times its picture, which is taken for numbers and not for colours; looked up as the mesh's `lookup` says. 1 where a material says none.",
    ),
    example: "{ material = \"roughness\" }",
    build: |source| {
        let which = match source.arguments().choice("material") {
            Some(&"metallic") => NumberOf::Metallic,
            _ => NumberOf::Roughness,
        };
        source.of_material(which).map(Paint::shared)
    },
    ..Source::PLAIN
};
