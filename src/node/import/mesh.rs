//! A closed mesh.

use std::sync::Arc;

use glam::DAffine3;

use crate::attribute::{Below, Colour, MeshColours, MeshNumbers, Scalar};
use crate::field::SetSystem;
use crate::mesh::{
    About, Conventions, Encoding, Holes, Lookup, Material, MeshDistance, Remark, Turn, is_gltf, read, read_obj,
};
use crate::node::argument::Argument;
use crate::node::keys::{FRAME_OFFSET, OUTSIDE_FRAMES, UNITS, metres};
use crate::node::spec::{Carries, ColoursOf, Import, Imported, MaterialsOf, Spec};
use crate::text::colour::{GREY, css};
use crate::text::diagnostic::{Diagnostic, Severity};
use crate::text::files::{FilePlace, FileReference};
use crate::text::key::Absent::{Nothing, Required, Text, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// A closed mesh.
pub const NODE: Spec = Spec {
    key: Key::new(
        "mesh",
        Kind::Paths,
        Required,
        "A closed mesh: OBJ, PLY, STL, glTF, GLB. Inside is where its winding number is not 0: pieces that overlap or cross \
         themselves are one solid, a piece wound inward is a hollow in the one around it, and apart from others it is \
         turned over. Where `color` is left out it has the file's own: pictures and plain colours of its materials (PNG, JPEG, also by UDIM), times the colours of its vertices, or of its faces (PLY). OBJ has one of them, pictures first.",
    ),
    parameters: &[
        Key::new(
            "up",
            Kind::Choice(&["y", "z"]),
            Words("the scene's `up`; of glTF `\"y\"`"),
            "The axis that points up in the file: `\"y\"` for OBJ by Blender's default export. Where the scene's is another, the mesh is turned: (x, y, z) becomes (x, −z, y), or back.",
        ),
        VERTEX_COLORS,
        Key::new(
            "sign",
            Kind::Choice(&["closed", "parity", "winding", "none"]),
            Text("closed"),
            "What is inside. `closed`, for most files: what the surface encloses, pieces that overlap as one solid, each way of winding put right where it can be told; one with holes is an error. `parity`, for pieces within pieces that are meant as hollows, whichever way they are wound (letters, pipes of CAD): what it goes round an odd number of times; where pieces overlap is outside. `winding`, for scans with holes: what it goes round by more than half, so that a hole is closed by a sheet across it (generalised winding number, Barill et al. 2018). `none`, for cloth and leaves: nothing; the surface is a sheet of `thickness`.",
        ),
        Key::new(
            "thickness",
            Kind::Number,
            Nothing,
            "A sheet of this thickness around the surface, half to either side, in place of what it encloses; for surfaces that enclose nothing.",
        )
        .limit(Limit::Positive)
        .unit("units"),
        Key::new(
            "unit",
            Kind::Choice(UNITS),
            Words("the scene's `unit`; of glTF `\"m\"`"),
            "The file's unit of length: where the scene's is another, the mesh is scaled.",
        ),
        Key::new(
            "lookup",
            Kind::Choice(&["filtered", "nearest", "majority"]),
            Text("filtered"),
            "How pictures are looked up: averaged over as much of them as a voxel covers, the one pixel there, or the colour that most pixels have of those that a voxel covers (for pictures of few plain colours, such as masks).",
        ),
        Key::new(
            "depth",
            Kind::Constant,
            Words("all of the inside"),
            "How far inward from the surface the file's colours reach, for `output.inside` and fog; deeper there is `below`.",
        )
        .limit(Limit::NotNegative)
        .unit("units"),
        Key::new("below", Kind::Colour, Words("`#cccccc`"), "With `depth`: the colour of what lies deeper."),
        FRAME_OFFSET,
        OUTSIDE_FRAMES,
    ],
    formula: "the signed distance to the boundary of that solid",
    example: "mesh = \"cube.obj\"",
    carries: Carries::Import,
    import: Some(import),
    build: |build| {
        let mesh = build.imported()?;
        // An operand is asked for its sign and its creases far more often than for its exact distance.
        // What grows needs the distance: planes are none beside edges.
        let planes = mesh.half_spaces.as_ref().filter(|_| !build.needs_distance());
        if build.arguments().get("thickness").is_some() {
            let (thickness, surface) = (build.number("thickness")?, build.imported_field()?);
            let graph = build.graph();
            let depth = graph.abs(surface);
            let sheet = graph.linear(depth, -1.0, thickness / 2.0);
            return Ok(graph.bounded(sheet, mesh.solid.grown(thickness / 2.0)));
        }
        let Some(planes) = planes else { return build.imported_field() };
        let graph = build.graph();
        let faces: Vec<_> = planes.iter().map(|(normal, offset)| graph.half_space(*normal, *offset)).collect();
        let solid = graph.intersection(SetSystem::MinMax, &faces);
        Ok(graph.bounded(solid, mesh.solid))
    },
    ..Spec::PLAIN
};

/// How colours of a file's vertices are to be read, as [`conventions`] takes it.
pub const VERTEX_COLORS: Key = Key::new(
    "vertex_colors",
    Kind::Choice(&["srgb", "linear"]),
    Text("srgb"),
    "How the file's colours are encoded. `linear`: scene-linear Rec.709, which may be above 1.",
)
.also(&["vertex_colours"]);

fn import(import: &Import<'_>) -> Result<Imported, Problem> {
    let file = import.file("mesh");
    let sign = import.arguments.choice("sign").copied().unwrap_or("closed");
    let is_sheet = import.arguments.get("thickness").is_some();
    if sign == "none" && !is_sheet {
        let problem = Problem::new(file.span, "with `sign = \"none\"` nothing is inside of the mesh");
        return Err(problem.help("give `thickness`, which makes a sheet of its surface, or another `sign`"));
    }
    if sign == "parity" && is_sheet {
        let problem = Problem::new(file.span, "`thickness` makes a sheet, of which `sign = \"parity\"` says nothing");
        return Err(problem.help("leave out one of them"));
    }
    let any_surface = is_sheet || sign == "winding";
    let holes = match sign {
        _ if any_surface => Holes::Allow,
        "parity" => Holes::Parity,
        _ => Holes::Refuse,
    };
    let (mesh, materials, remarks) = load(file, &conventions(import, file), holes)?;
    let mut warnings: Vec<Diagnostic> =
        mesh.notes().iter().map(|note| Diagnostic::warning(file.span, format!("{}: {note}", file.name()))).collect();
    let is_gltf = is_gltf_file(file);
    let up_is_given = is_gltf || import.arguments.choice("up").is_some() || import.up == "y";
    let counts = |remark: &Remark| match remark.about {
        About::Faces => true,
        About::Colours => import.shows_colours,
        About::Up => !up_is_given,
    };
    warnings.extend(remarks.into_iter().filter(counts).map(|remark| told(file, remark)));
    /// Corners, triangles, normals and tree, by triangle.
    const BYTES_A_TRIANGLE: u64 = 300;
    let mesh = Arc::new(mesh);
    let pictures: u64 = materials.iter().map(Material::bytes).sum();
    let lookup = match import.arguments.choice("lookup") {
        Some(&"nearest") => Lookup::Nearest,
        Some(&"majority") => Lookup::Majority,
        _ => Lookup::Filtered,
    };
    let below = match (import.arguments.constant("depth"), import.arguments.get("below")) {
        (Some(depth), Some(Argument::Colour(colour))) => Some(Below { depth: *depth, colour: *colour }),
        (Some(depth), _) => css(GREY).map(|colour| Below { depth: *depth, colour }),
        (None, Some(_)) => {
            return Err(Problem::new(file.span, "`below` goes with `depth`").help("give both, or neither"));
        }
        (None, None) => None,
    };
    let materials: Arc<[Material]> = materials.into();
    let (of_mesh, shared) = (Arc::clone(&mesh), Arc::clone(&materials));
    let colours = move |voxel: f64| {
        let colours = MeshColours::new(Arc::clone(&of_mesh), Arc::clone(&materials), lookup, voxel)?;
        Some(colours.with_below(below))
    };
    let has_any = colours(1.0).is_some();
    let of_mesh = Arc::clone(&mesh);
    let numbers: MaterialsOf = Box::new(move |which, voxel| {
        let numbers = MeshNumbers::new(Arc::clone(&of_mesh), Arc::clone(&shared), which, lookup, voxel)?;
        Some(Arc::new(numbers) as Arc<Scalar>)
    });
    let colours: ColoursOf =
        Box::new(move |voxel| Arc::new(colours(voxel).expect("it has colours, whatever the voxel")) as Arc<Colour>);
    Ok(Imported {
        place: DAffine3::IDENTITY,
        solid: mesh.mesh().bounding_box(),
        half_spaces: if holes != Holes::Refuse { None } else { mesh.half_spaces() },
        colours: has_any.then_some(colours),
        materials: Some(numbers),
        velocity: None,
        warnings,
        bytes: mesh.mesh().triangles().len() as u64 * BYTES_A_TRIANGLE + pictures,
        distance: mesh,
    })
}

fn is_gltf_file(file: &FileReference) -> bool {
    matches!(&file.place, FilePlace::Disk(path) if is_gltf(path))
}

/// What the keys say of the file.
pub fn conventions(import: &Import<'_>, file: &FileReference) -> Conventions {
    let (arguments, scene) = (import.arguments, import.up);
    let is_gltf = is_gltf_file(file);
    let own_up = if is_gltf { "y" } else { scene };
    let own_unit = if is_gltf { "m" } else { import.unit };
    let turn = match (arguments.choice("up").copied().unwrap_or(own_up), scene) {
        ("y", "z") => Turn::YToZ,
        ("z", "y") => Turn::ZToY,
        _ => Turn::None,
    };
    let colours = match arguments.choice("vertex_colors") {
        Some(&"linear") => Encoding::Linear,
        _ => Encoding::Srgb,
    };
    let unit = arguments.choice("unit").copied().unwrap_or(own_unit);
    Conventions { turn, colours, scale: if unit == import.unit { 1.0 } else { metres(unit) / metres(import.unit) } }
}

fn load(
    file: &FileReference,
    conventions: &Conventions,
    holes: Holes,
) -> Result<(MeshDistance, Vec<Material>, Vec<Remark>), Problem> {
    let imported = match &file.place {
        FilePlace::Disk(path) => read(path, conventions).map_err(|error| Problem::new(file.span, error.to_string()))?,
        FilePlace::BuiltIn(_) => {
            let bytes = file.read().unwrap_or_default();
            read_obj(&bytes, conventions).map_err(|error| file.problem(error))?
        }
    };
    let mesh = MeshDistance::new(imported.mesh, holes).map_err(|error| file.problem(error))?;
    Ok((mesh, imported.materials, imported.remarks))
}

fn told(file: &FileReference, Remark { about, place, text, help }: Remark) -> Diagnostic {
    let place = place.map_or_else(String::new, |place| format!(", {place}"));
    let mut warning = Diagnostic::warning(file.span, format!("{}{place}: {text}", file.name())).help(help);
    if about == About::Up {
        warning.severity = Severity::Note;
    }
    warning
}
