//! A closed mesh.

use std::sync::Arc;

use crate::attribute::{Colour, VertexColours};
use crate::field::SetSystem;
use crate::mesh::{About, Conventions, Encoding, Holes, MeshDistance, Remark, Turn, read, read_obj};
use crate::node::argument::Arguments;
use crate::node::spec::{Carries, Import, Imported, Spec};
use crate::text::diagnostic::{Diagnostic, Severity};
use crate::text::files::{FilePlace, FileReference};
use crate::text::key::Absent::{Required, Text, Words};
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// A closed mesh.
pub const NODE: Spec = Spec {
    key: Key::new(
        "mesh",
        Kind::Path,
        Required,
        "A closed mesh: OBJ, PLY. Inside is where its winding number is not 0: pieces that overlap or cross \
         themselves are one solid, a piece wound inward is a hollow in the one around it, and apart from others it is \
         turned over. The colours of its vertices, or of its faces (PLY), are its colour where `color` is left out; materials are not read.",
    ),
    parameters: &[
        Key::new(
            "up",
            Kind::Choice(&["y", "z"]),
            Words("the scene's `up`"),
            "The axis that points up in the file: `\"y\"` for OBJ by Blender's default export. Where the scene's is another, the mesh is turned: (x, y, z) becomes (x, −z, y), or back.",
        ),
        Key::new(
            "vertex_colors",
            Kind::Choice(&["srgb", "linear"]),
            Text("srgb"),
            "How the file's colours are encoded. `linear`: scene-linear Rec.709, which may be above 1.",
        )
        .also(&["vertex_colours"]),
    ],
    formula: "the signed distance to the boundary of that solid",
    example: "mesh = \"cube.obj\"",
    carries: Carries::Import,
    import: Some(import),
    build: |build| {
        let mesh = build.imported();
        // An operand is asked for its sign and its creases far more often than for its exact distance.
        // What grows needs the distance: planes are none beside edges.
        let planes = mesh.half_spaces.as_ref().filter(|_| !build.needs_distance());
        let graph = build.graph();
        Ok(match planes {
            Some(planes) => {
                let faces: Vec<_> = planes.iter().map(|(normal, offset)| graph.half_space(*normal, *offset)).collect();
                let solid = graph.intersection(SetSystem::MinMax, &faces);
                graph.bounded(solid, mesh.solid)
            }
            None => graph.field(Arc::clone(&mesh.distance)),
        })
    },
    ..Spec::PLAIN
};

fn import(import: &Import<'_>) -> Result<Imported, Problem> {
    let file = import.arguments.file("mesh").expect("it must be there");
    let (mesh, remarks) = load(file, &conventions(import.arguments, import.up))?;
    let mut warnings: Vec<Diagnostic> =
        mesh.notes().iter().map(|note| Diagnostic::warning(file.span, format!("{}: {note}", file.name()))).collect();
    let up_is_given = import.arguments.choice("up").is_some() || import.up == "y";
    let counts = |remark: &Remark| match remark.about {
        About::Faces => true,
        About::Colours => import.shows_colours,
        About::Up => !up_is_given,
    };
    warnings.extend(remarks.into_iter().filter(counts).map(|remark| told(file, remark)));
    /// Corners, triangles, normals and tree, by triangle.
    const BYTES_A_TRIANGLE: u64 = 300;
    let mesh = Arc::new(mesh);
    Ok(Imported {
        solid: mesh.mesh().bounding_box(),
        half_spaces: mesh.half_spaces(),
        colours: VertexColours::new(Arc::clone(&mesh)).map(|colours| Arc::new(colours) as Arc<Colour>),
        warnings,
        bytes: mesh.mesh().triangles().len() as u64 * BYTES_A_TRIANGLE,
        distance: mesh,
    })
}

fn conventions(arguments: &Arguments, scene: &str) -> Conventions {
    let turn = match (arguments.choice("up").copied().unwrap_or(scene), scene) {
        ("y", "z") => Turn::YToZ,
        ("z", "y") => Turn::ZToY,
        _ => Turn::None,
    };
    let colours = match arguments.choice("vertex_colors") {
        Some(&"linear") => Encoding::Linear,
        _ => Encoding::Srgb,
    };
    Conventions { turn, colours }
}

fn load(file: &FileReference, conventions: &Conventions) -> Result<(MeshDistance, Vec<Remark>), Problem> {
    let imported = match &file.place {
        FilePlace::Disk(path) => read(path, conventions).map_err(|error| Problem::new(file.span, error.to_string()))?,
        FilePlace::BuiltIn(_) => {
            let bytes = file.read().unwrap_or_default();
            read_obj(&bytes, conventions)
                .map_err(|error| Problem::new(file.span, format!("{}: {error}", file.name())))?
        }
    };
    let mesh = MeshDistance::new(imported.mesh, Holes::Refuse)
        .map_err(|error| Problem::new(file.span, format!("{}: {error}", file.name())))?;
    Ok((mesh, imported.remarks))
}

fn told(file: &FileReference, Remark { about, place, text, help }: Remark) -> Diagnostic {
    let place = place.map_or_else(String::new, |place| format!(", {place}"));
    let mut warning = Diagnostic::warning(file.span, format!("{}{place}: {text}", file.name())).help(help);
    if about == About::Up {
        warning.severity = Severity::Note;
    }
    warning
}
