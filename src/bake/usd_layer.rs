//! A USD layer of `.vdb` files: one Volume whose fields name the files by frame (`UsdVol`, `OpenVDBAsset`), as text.

use std::collections::BTreeSet;
use std::fmt::{self, Write};
use std::path::{Component, Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;

use crate::node::keys::{UNITS, metres};
use crate::vdb::walk::{GridLayout, Layout, walk};
use crate::vdb::{self, StoredClass, VELOCITIES, metadata_text};

/// Types of values, as OpenVDB spells them and as USD does. USD says nothing of a wrong word.
const TYPES: [(&str, &str); 9] = [
    ("float", "float"),
    ("double", "double"),
    ("vec3s", "float3"),
    ("vec3d", "double3"),
    ("vec3i", "int3"),
    ("int32", "int"),
    ("int64", "int64"),
    ("bool", "bool"),
    ("mask", "mask"),
];

/// A grid's name by convention, and the one that Hydra's renderers look for.
const ALIASES: [(&str, &str); 3] = [("Cd", "color"), ("vel", "velocity"), ("v", "velocity")];

/// A file, with the frame that it shows where it is one of several.
#[derive(Clone, Debug)]
pub struct FrameFile {
    /// Its time code.
    pub frame: i64,
    /// Where it is.
    pub path: PathBuf,
}

/// What the files do not say, or say otherwise.
#[derive(Clone, Debug, Default)]
pub struct LayerOptions {
    /// Frames a second; without it as the files say, else 24.
    pub fps: Option<f64>,
    /// The axis that points up, `"y"` or `"z"`; without it as the files say, else z.
    pub up: Option<&'static str>,
}

/// A layer, with what was noticed of its files.
#[derive(Debug)]
pub struct Layer {
    /// Its text.
    pub text: String,
    /// What may not be as meant, a sentence each.
    pub warnings: Vec<String>,
}

/// A grid that at least one file has.
#[derive(Clone, Debug, PartialEq)]
struct Field {
    name: String,
    /// Its type, class and role in the words of USD.
    kind: &'static str,
    class: &'static str,
    role: &'static str,
}

/// What is known of one file.
struct Look {
    fields: Vec<Field>,
    skipped: BTreeSet<String>,
    /// Names that several grids have.
    twice: BTreeSet<String>,
    extent: Option<[DVec3; 2]>,
    fps: Option<f64>,
    up: Option<&'static str>,
    metres: Option<f64>,
}

/// Looks into the files and makes the layer, whose paths are relative to `layer`, the file that it becomes. One file is
/// shown at any time, several by their frames, which have to rise. No voxel is decompressed.
///
/// # Errors
/// Those of [`walk`] for any of the files.
pub fn usd_layer(files: &[FrameFile], layer: &Path, options: &LayerOptions) -> Result<Layer, vdb::Error> {
    let looks: Vec<Look> =
        files.par_iter().map(|file| walk(&file.path).map(|layout| look(&layout))).collect::<Result<_, _>>()?;
    let mut warnings = Vec::new();
    let fields = common_fields(files, &looks, &mut warnings);
    let skipped: BTreeSet<&String> = looks.iter().flat_map(|look| &look.skipped).collect();
    for name in skipped {
        warnings.push(format!("{name}: left out; USD has no such type of volume"));
    }
    if fields.is_empty() {
        warnings.push("no file has a grid that USD knows: the Volume is empty".into());
    }
    if let Some(at) = looks.iter().position(|look| look.extent.is_none()) {
        warnings.push(format!(
            "{}: no voxel is active there, or it stands in a frustum, so that frame has no extent",
            files[at].path.display()
        ));
    }
    let says = [
        (
            "frames a second",
            options.fps.is_none(),
            looks.iter().filter_map(|look| look.fps.map(|fps| fps.to_string())).collect(),
        ),
        ("the unit", true, looks.iter().filter_map(|look| look.metres.map(|metres| format!("{metres} m"))).collect()),
        (
            "the axis that points up",
            options.up.is_none(),
            looks.iter().filter_map(|look| look.up.map(str::to_owned)).collect(),
        ),
    ];
    for (what, matters, values) in says {
        let values: Vec<String> = values;
        if let (true, Some(other)) = (matters, values.iter().find(|value| **value != values[0])) {
            warnings.push(format!("the files differ in {what}: {} is taken, and some say {other}", values[0]));
        }
    }
    let twice: BTreeSet<&String> = looks.iter().flat_map(|look| &look.twice).collect();
    for name in twice {
        warnings.push(format!("{name}: several grids have this name, of which USD finds the first"));
    }
    let gaps: Vec<String> = files
        .windows(2)
        .filter(|pair| pair[1].frame - pair[0].frame > 1)
        .map(|pair| format!("{} to {}", pair[0].frame + 1, pair[1].frame - 1))
        .collect();
    if !gaps.is_empty() {
        let shown = gaps[..gaps.len().min(4)].join(", ");
        warnings.push(format!("no file for frames {shown}: USD holds the one before, Blender shows nothing"));
    }
    Ok(Layer { text: text(files, &looks, &fields, layer, options), warnings })
}

fn look(layout: &Layout) -> Look {
    let text = |name: &str| metadata_text(&layout.metadata, name);
    let (mut fields, mut skipped, mut twice): (Vec<Field>, _, _) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
    let mut extent: Option<[DVec3; 2]> = None;
    for grid in &layout.grids {
        match field(grid) {
            None => _ = skipped.insert(grid.name.clone()),
            // By its name only the first of several is found.
            Some(field) if fields.iter().any(|known| known.name == field.name) => _ = twice.insert(field.name),
            Some(field) => fields.push(field),
        }
        let Some((low, high)) = layout.tree(grid).and_then(|tree| tree.active_box) else { continue };
        let Some(centres) = grid.transform.world_box(low, high) else { continue };
        // Voxels reach half an edge beyond their centres.
        let half = grid.transform.voxel_size().unwrap_or(DVec3::ZERO) / 2.0;
        let [low, high] = centres.map(DVec3::from_array);
        let own = [low - half, high + half];
        extent = Some(extent.map_or(own, |[least, greatest]| [least.min(own[0]), greatest.max(own[1])]));
    }
    let number = |name: &str| layout.metadata.get(name).and_then(|value| value.to_string().parse::<f64>().ok());
    Look {
        fields,
        skipped,
        twice,
        extent,
        fps: number("hfvdb_fps").filter(|fps| fps.is_finite() && *fps > 0.0),
        up: text("hfvdb_up").and_then(|up| ["y", "z"].into_iter().find(|known| *known == up)),
        metres: text("hfvdb_unit").filter(|unit| UNITS.contains(unit)).map(metres),
    }
}

fn field(grid: &GridLayout) -> Option<Field> {
    let kind = TYPES.iter().find(|(name, _)| *name == grid.value_type())?.1;
    let role = match metadata_text(&grid.metadata, "vector_type") {
        _ if !kind.ends_with('3') => "None",
        _ if VELOCITIES.contains(&grid.name.as_str()) => "Vector",
        Some(kind) => match kind {
            "contravariant relative" | "covariant" => "Vector",
            "contravariant absolute" => "Point",
            "covariant normalize" => "Normal",
            _ => "Color",
        },
        _ => "Color",
    };
    let class = match StoredClass::of(&grid.metadata) {
        StoredClass::LevelSet => "levelSet",
        StoredClass::FogVolume => "fogVolume",
        StoredClass::Staggered => "staggered",
        _ => "unknown",
    };
    Some(Field { name: grid.name.clone(), kind, class, role })
}

/// The grids of all files, in the order in which they first come.
fn common_fields(files: &[FrameFile], looks: &[Look], warnings: &mut Vec<String>) -> Vec<Field> {
    let mut fields: Vec<Field> = Vec::new();
    for (file, look) in files.iter().zip(looks) {
        for field in &look.fields {
            match fields.iter().find(|known| known.name == field.name) {
                None => fields.push(field.clone()),
                Some(known) if known == field => {}
                Some(known) => {
                    let (path, name) = (file.path.display(), &field.name);
                    let (here, before) =
                        (format!("{} {}", field.class, field.kind), format!("{} {}", known.class, known.kind));
                    warnings.push(format!("{path}: {name} is a {here} there, and a {before} in a file before"));
                }
            }
        }
    }
    for field in &fields {
        let without = looks.iter().filter(|look| !look.fields.iter().any(|own| own.name == field.name)).count();
        if without > 0 {
            warnings.push(format!("{}: {without} of {} files have no such grid", field.name, files.len()));
        }
    }
    fields
}

fn text(files: &[FrameFile], looks: &[Look], fields: &[Field], layer: &Path, options: &LayerOptions) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_text(&mut out, files, looks, fields, layer, options);
    out
}

fn write_text(
    out: &mut String,
    files: &[FrameFile],
    looks: &[Look],
    fields: &[Field],
    layer: &Path,
    options: &LayerOptions,
) -> fmt::Result {
    let said = |pick: fn(&Look) -> Option<f64>| looks.iter().find_map(pick);
    let up = options.up.or_else(|| looks.iter().find_map(|look| look.up)).unwrap_or("z").to_uppercase();
    let fps = options.fps.or_else(|| said(|look| look.fps)).unwrap_or(24.0);
    let metres = said(|look| look.metres).unwrap_or(1.0);
    let stem = layer.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let root = identifier(&stem);
    let moves = files.len() > 1;
    writeln!(out, "#usda 1.0\n(\n    defaultPrim = \"{root}\"\n    metersPerUnit = {metres}\n    upAxis = \"{up}\"")?;
    writeln!(out, "    timeCodesPerSecond = {fps}\n    framesPerSecond = {fps}")?;
    if let (true, [first, .., last]) = (moves, files) {
        writeln!(out, "    startTimeCode = {}\n    endTimeCode = {}", first.frame, last.frame)?;
    }
    writeln!(out, ")\n\ndef Xform \"{root}\" (\n    kind = \"component\"\n)\n{{\n    def Volume \"volume\"\n    {{")?;

    let extents =
        looks.iter().map(|look| look.extent.map(|[low, high]| format!("[{}, {}]", Triple(low), Triple(high))));
    sampled(out, 8, "float3[] extent", files, extents, moves)?;
    let prims = identifiers(fields.iter().map(|field| field.name.as_str()));
    for (name, prim) in relations(fields, &prims) {
        writeln!(out, "        rel field:{name} = </{root}/volume/{prim}>")?;
    }
    let from = folder_of(layer);
    let paths: Vec<String> = files.iter().map(|file| asset(&from, &file.path)).collect();
    for (field, prim) in fields.iter().zip(&prims) {
        writeln!(out, "\n        def OpenVDBAsset \"{prim}\"\n        {{")?;
        writeln!(out, "            token fieldClass = \"{}\"", field.class)?;
        writeln!(out, "            token fieldDataType = \"{}\"", field.kind)?;
        writeln!(out, "            int fieldIndex = 0")?;
        writeln!(out, "            token fieldName = {}", quoted(&field.name))?;
        sampled(out, 12, "asset filePath", files, paths.iter().cloned().map(Some), moves)?;
        if field.role != "None" {
            writeln!(out, "            token vectorDataRoleHint = \"{}\"", field.role)?;
        }
        writeln!(out, "        }}")?;
    }
    writeln!(out, "    }}\n}}")
}

/// A value, or one for each frame that has it.
fn sampled(
    out: &mut String,
    indent: usize,
    name: &str,
    files: &[FrameFile],
    values: impl Iterator<Item = Option<String>>,
    moves: bool,
) -> fmt::Result {
    let pairs: Vec<(i64, String)> =
        files.iter().zip(values).filter_map(|(file, value)| Some((file.frame, value?))).collect();
    match &pairs[..] {
        [] => Ok(()),
        [(_, value)] if !moves => writeln!(out, "{:indent$}{name} = {value}", ""),
        _ => {
            writeln!(out, "{:indent$}{name}.timeSamples = {{", "")?;
            for (frame, value) in &pairs {
                writeln!(out, "{:indent$}    {frame}: {value},", "")?;
            }
            writeln!(out, "{:indent$}}}", "")
        }
    }
}

/// Names by which shaders find the fields: their own, and those that Hydra's renderers look for.
fn relations<'a>(fields: &[Field], prims: &'a [String]) -> Vec<(String, &'a str)> {
    let mut all: Vec<(String, &str)> = prims.iter().map(|prim| (prim.clone(), prim.as_str())).collect();
    for (name, alias) in ALIASES {
        let known = all.iter().any(|(taken, _)| taken == alias);
        if let (false, Some(at)) = (known, fields.iter().position(|field| field.name == name)) {
            all.push((alias.into(), &prims[at]));
        }
    }
    all
}

/// A name of USD for each name, each another.
pub(super) fn identifiers<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for name in names {
        let plain = identifier(name);
        let name = (1..).map(|count| if count == 1 { plain.clone() } else { format!("{plain}_{count}") });
        all.extend(name.into_iter().find(|name| !all.contains(name)));
    }
    all
}

/// Letters, digits and underlines, no digit first.
pub(super) fn identifier(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.is_empty() || plain.starts_with(|first: char| first.is_ascii_digit()) {
        format!("_{plain}")
    } else {
        plain
    }
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            c => out.push(c),
        }
    }
    out + "\""
}

/// A file as seen from a folder.
fn asset(from: &Path, file: &Path) -> String {
    let file = std::path::absolute(file).unwrap_or_else(|_| file.into());
    let file = folder_of(&file).join(file.file_name().unwrap_or_default());
    let shared = from.components().zip(file.components()).take_while(|(ours, other)| ours == other).count();
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(file.components().skip(shared)).collect();
    let path = path.to_string_lossy();
    let path = if path.starts_with("..") { path.into_owned() } else { format!("./{path}") };
    // A path with `@` in it stands between three of them.
    if path.contains('@') { format!("@@@{path}@@@") } else { format!("@{path}@") }
}

/// The folder of a file, links followed, so that two paths into it begin alike.
fn folder_of(file: &Path) -> PathBuf {
    let absolute = std::path::absolute(file).unwrap_or_else(|_| file.into());
    let folder = absolute.parent().unwrap_or(Path::new("/"));
    folder.canonicalize().unwrap_or_else(|_| folder.into())
}

/// Three numbers, as single precision has them.
struct Triple(DVec3);

impl fmt::Display for Triple {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0.as_vec3().to_array();
        write!(f, "({x}, {y}, {z})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_those_of_usd() {
        for (name, other) in [("Cd", "Cd"), ("my-shape", "my_shape"), ("7up", "_7up"), ("", "_"), ("ä b", "__b")] {
            assert_eq!(identifier(name), other, "{name}");
        }
        let field = |name: &str| Field { name: name.into(), kind: "float", class: "unknown", role: "None" };
        let fields = [field("a-b"), field("a_b"), field("v"), field("Cd")];
        let prims = identifiers(fields.iter().map(|field| field.name.as_str()));
        assert_eq!(prims, ["a_b", "a_b_2", "v", "Cd"]);
        let relations: Vec<String> =
            relations(&fields, &prims).into_iter().map(|(name, to)| format!("{name}>{to}")).collect();
        assert_eq!(relations, ["a_b>a_b", "a_b_2>a_b_2", "v>v", "Cd>Cd", "color>Cd", "velocity>v"]);
    }

    #[test]
    fn paths_are_seen_from_the_layer() {
        let from = Path::new("/s/shots/010");
        for (file, seen) in [
            ("/s/shots/010/m.0001.vdb", "@./m.0001.vdb@"),
            ("/s/shots/010/out/m.0001.vdb", "@./out/m.0001.vdb@"),
            ("/s/caches/m.0001.vdb", "@../../caches/m.0001.vdb@"),
            ("/s/a@b/m.vdb", "@@@../../a@b/m.vdb@@@"),
        ] {
            assert_eq!(asset(from, Path::new(file)), seen);
        }
        assert_eq!(quoted("a \"b\" \\ c"), r#""a \"b\" \\ c""#);
    }
}
