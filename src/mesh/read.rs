//! From a path to a checked mesh.

use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::{Material, MeshError, Problem, TriangleMesh, gltf, mtl, obj, ply, stl};

/// What a file does not say about itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conventions {
    /// How its axes become the scene's.
    pub turn: Turn,
    /// How its colours are encoded.
    pub colours: Encoding,
    /// World units of one of its own.
    pub scale: f64,
}

impl Default for Conventions {
    fn default() -> Self {
        Self { turn: Turn::default(), colours: Encoding::default(), scale: 1.0 }
    }
}

/// A quarter turn about the x axis, or none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turn {
    /// Axes stay as they are.
    #[default]
    None,
    /// What points along y points along z: (x, y, z) becomes (x, −z, y).
    YToZ,
    /// What points along z points along y: (x, y, z) becomes (x, z, −y).
    ZToY,
}

impl Turn {
    pub(super) fn apply(self, p: DVec3) -> DVec3 {
        match self {
            Self::None => p,
            Self::YToZ => DVec3::new(p.x, -p.z, p.y),
            Self::ZToY => DVec3::new(p.x, p.z, -p.y),
        }
    }
}

/// How a file's colours are encoded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// sRGB (IEC 61966-2-1), 0 … 1.
    #[default]
    Srgb,
    /// Scene-linear Rec.709, 0 or greater.
    Linear,
}

impl Encoding {
    /// The scene-linear colour, or `None` where it cannot be one.
    pub(super) fn decode(self, encoded: [f64; 3]) -> Option<[f32; 3]> {
        let most = if self == Self::Srgb { 1.0 } else { f64::from(f32::MAX) };
        let linear = |c: f64| match self {
            Self::Srgb if c <= 0.04045 => c / 12.92,
            Self::Srgb => libm::pow((c + 0.055) / 1.055, 2.4),
            Self::Linear => c,
        };
        encoded.iter().all(|c| (0.0..=most).contains(c)).then(|| encoded.map(|c| linear(c) as f32))
    }
}

/// A mesh from a file, and what there is to know about it.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// What its vertices' places are in; none where they have none.
    pub materials: Vec<Material>,
    /// What the reader did about parts of the file, or what it leaves out.
    pub remarks: Vec<Remark>,
}

/// Something to know about a file that was read all the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// What it matters for.
    pub about: About,
    /// Where in the file.
    pub place: Option<Place>,
    /// What it is.
    pub text: String,
    /// What to do about it.
    pub help: String,
}

/// What a remark matters for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The surface.
    Faces,
    /// The mesh's colours.
    Colours,
    /// Which way is up.
    Up,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line, counted from 1.
    Line(usize),
    /// A face, counted from 0.
    Face(usize),
}

impl Display for Place {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Face(face) => write!(f, "face {face} (counted from 0)"),
        }
    }
}

/// A problem, and its place where that is known.
#[derive(Debug)]
pub(super) struct Located {
    pub place: Option<Place>,
    pub problem: Problem,
}

impl From<Problem> for Located {
    fn from(problem: Problem) -> Self {
        Self { place: None, problem }
    }
}

/// A reader of a format: of a file's content, with the folder that other files it names are sought from.
type Parse = fn(&[u8], &Conventions, Option<&Path>) -> Result<Imported, Located>;

/// The reader of files whose names end so.
fn parser(ending: &str) -> Option<Parse> {
    match ending {
        "obj" => Some(obj::parse),
        "ply" => Some(|content, conventions, _| ply::parse(content, conventions)),
        "stl" => Some(|content, conventions, _| stl::parse(content, conventions)),
        "gltf" | "glb" => Some(gltf::parse),
        _ => None,
    }
}

fn ending_of(file: &Path) -> String {
    file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// The folder of a file.
fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether files of such a name are in metres and have y up, whatever else is said: glTF is defined so.
pub fn is_gltf(file: &Path) -> bool {
    ["gltf", "glb"].contains(&ending_of(file).as_str())
}

/// Whether a file is a mesh, by its name.
pub fn is_mesh(file: &Path) -> bool {
    parser(&ending_of(file)).is_some()
}

/// Whether files of such a name can name others, which [`companions`] finds.
pub fn has_companions(file: &Path) -> bool {
    ["obj", "gltf", "glb"].contains(&ending_of(file).as_str())
}

/// The files that a mesh names, of those that are there: materials, pictures, data.
pub fn companions(file: &Path, content: &[u8]) -> Vec<PathBuf> {
    match ending_of(file).as_str() {
        "obj" => mtl::files(&obj::libraries(content), folder_of(file)),
        "gltf" | "glb" => gltf::files(content, folder_of(file)),
        _ => Vec::new(),
    }
}

/// Reads an OBJ, PLY, STL, glTF or GLB file, by the ending of its name. Colours come back scene-linear.
pub fn read(file: &Path, conventions: &Conventions) -> Result<Imported, MeshError> {
    let error = |located: Located| MeshError { file: file.into(), place: located.place, problem: located.problem };
    let ending = ending_of(file);
    let Some(parse) = parser(&ending) else { return Err(error(Problem::UnknownFormat(ending).into())) };
    let content = crate::disk::read(file).map_err(|e| error(Problem::Unreadable(e).into()))?;
    parse(&content, conventions, Some(folder_of(file))).map_err(error)
}

/// Reads the content of an OBJ file.
pub fn read_obj(content: &[u8], conventions: &Conventions) -> Result<Imported, Problem> {
    obj::parse(content, conventions, None).map_err(|located| located.problem)
}

/// Reads the content of a PLY file: text, or binary of either byte order.
pub fn read_ply(content: &[u8], conventions: &Conventions) -> Result<Imported, Problem> {
    ply::parse(content, conventions).map_err(|located| located.problem)
}

/// A file's content without the byte order mark of UTF-8. Refuses UTF-16, which some editors save.
pub(super) fn without_mark(content: &[u8]) -> Result<&[u8], Problem> {
    match content {
        [0xef, 0xbb, 0xbf, rest @ ..] => Ok(rest),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, _, ..] | [_, 0, ..] => {
            Err(Problem::malformed("is text in UTF-16, or no text; save it as UTF-8"))
        }
        _ => Ok(content),
    }
}

/// A file's word for messages: short, without control characters.
pub(super) fn shown(word: &str) -> String {
    const MOST_CHARACTERS: usize = 32;
    let mut shown: String = word.chars().take(MOST_CHARACTERS).flat_map(char::escape_debug).collect();
    if word.chars().nth(MOST_CHARACTERS).is_some() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::shapes::cube;
    use super::super::{Holes, MeshDistance};
    use super::*;
    use crate::field::Field;

    fn read_obj(content: &[u8]) -> Result<TriangleMesh, Problem> {
        super::read_obj(content, &Conventions::default()).map(|imported| imported.mesh)
    }

    fn read_ply(content: &[u8]) -> Result<TriangleMesh, Problem> {
        super::read_ply(content, &Conventions::default()).map(|imported| imported.mesh)
    }

    fn read(file: &Path) -> Result<TriangleMesh, MeshError> {
        super::read(file, &Conventions::default()).map(|imported| imported.mesh)
    }

    fn obj_of(mesh: &TriangleMesh) -> String {
        let vertices = mesh.positions().iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
        let faces = mesh.triangles().iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
        vertices.chain(faces).collect()
    }

    fn ply_header(format: &str, vertices: usize, faces: usize) -> String {
        format!(
            "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex {vertices}\nproperty double x\n\
             property double y\nproperty double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
             element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )
    }

    /// The mesh with red 188, green 0, blue 255 at each vertex.
    fn ply_of(mesh: &TriangleMesh, format: &str) -> Vec<u8> {
        let mut out = ply_header(format, mesh.positions().len(), mesh.triangles().len()).into_bytes();
        let big = format == "binary_big_endian";
        for p in mesh.positions() {
            match format {
                "ascii" => out.extend(format!("{} {} {} 188 0 255\n", p.x, p.y, p.z).bytes()),
                _ => {
                    out.extend(p.to_array().iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }));
                    out.extend([188, 0, 255]);
                }
            }
        }
        for t in mesh.triangles() {
            match format {
                "ascii" => out.extend(format!("3 {} {} {}\n", t[0], t[1], t[2]).bytes()),
                _ => {
                    out.push(3);
                    out.extend(t.iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }));
                }
            }
        }
        out
    }

    #[test]
    fn every_format_gives_the_mesh_back() {
        let mesh = cube(0.7, 3);
        let read = read_obj(obj_of(&mesh).as_bytes()).unwrap();
        assert_eq!((read.positions(), read.triangles()), (mesh.positions(), mesh.triangles()));
        assert_eq!(read.colours(), None);
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let read = read_ply(&ply_of(&mesh, format)).unwrap();
            assert_eq!((read.positions(), read.triangles()), (mesh.positions(), mesh.triangles()), "{format}");
            let [r, g, b] = read.colours().unwrap()[5];
            // 188 of 255 is the encoding of about one half (0.502886, by the table of IEC 61966-2-1).
            assert!((r - 0.502_886).abs() < 1e-5 && g == 0.0 && b == 1.0, "{format}: {r} {g} {b}");
        }
    }

    #[test]
    fn obj_dialects() {
        let text = "# a quad pyramid\r\nmtllib none.mtl\r\nv 0 0 0 1 0.5 0\r\nv 1 0 0 1 0.5 0\nv 1 1 0 1 .5 0\n\
                    v 0 1 0 1 0.5 0\nv 0.5 0.5 1 1 0.5 0\nvt 0 0\nvn 0 0 1\no thing\nusemtl x\ns 1\n\
                    f 1/1/1 4/1/1 3//1 2/1\nf 1 2 \\\n 5\nf -4 -3 -1 # behind\nf 3 4 5\nf 4 1 5\nl 1 2\n";
        let mesh = read_obj(text.as_bytes()).unwrap();
        assert_eq!((mesh.positions().len(), mesh.triangles().len()), (5, 6));
        assert!((mesh.volume() - 1.0 / 3.0).abs() < 1e-15 && mesh.topology().is_closed());
        let field = MeshDistance::new(mesh, Holes::Refuse).unwrap();
        let colour = field.colour(&field.nearest(DVec3::splat(3.0))).unwrap();
        assert!(colour[0] == 1.0 && (colour[1] - 0.214_041).abs() < 1e-5 && colour[2] == 0.0, "{colour:?}");
    }

    /// Ways to write one cube, and what there is to say about each.
    #[test]
    fn obj_is_written_in_many_ways() {
        let cube = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        let remarks = |text: &str| {
            let imported = super::read_obj(text.as_bytes(), &Conventions::default()).unwrap();
            assert_eq!(imported.mesh.volume(), 8.0, "{text}");
            assert!(imported.mesh.topology().is_closed(), "{text}");
            imported.remarks
        };
        let face = |other: &str| cube.replace("f 1 4 3 2", other);
        let (vertices, faces) = cube.split_at(cube.find('f').unwrap());
        for text in [
            cube.replace('\n', "\r"),
            cube.replace('\n', "\r\n"),
            cube.replace(' ', "\t"),
            cube.replace("f 1 4", "f 1\\\r\n 4"),
            format!("\u{feff}{cube}"),
            format!("# C:\\meshes\\\n{cube}"),
            format!("{cube}o a name\ng a b\ns off\np 1\nl 1 2 3\n# \\"),
            format!("{faces}{vertices}"),
            face("f 1 4 \\ \t\n3 2"),
            face("f 1 4 \\ # and so on \\\n# between\n3 2"),
            face("vn 0 0 1\nvt 0 0\nf 1//1 4//1 3//1 2//1"),
            face("vn 0 0 1\nvt 0 0\nf 1/1/1 4//1 3/1 2"),
            face("f -8 -5 -6 -7"),
            face("fo 1 4 3 2"),
            face("f 1 1 4 3 2 2 1"),
            face(&format!("f 1 4 3 2{}#{}", " ".repeat(1 << 17), "x".repeat(1 << 17))),
        ] {
            assert_eq!(remarks(&text), [], "{text}");
        }
        let says = |text: &str, place: Option<Place>, part: &str| {
            let remarks = remarks(text);
            let [remark] = remarks.as_slice() else { panic!("{remarks:?}") };
            assert!(remark.place == place && remark.text.contains(part), "{remark:?}");
        };
        let line = |number| Some(Place::Line(number));
        says(&format!("{cube}f 1 2\nf 3\nf\n"), line(15), "a face of 2 corners bounds nothing: it and 2 others");
        says(&face("f 1 4 3 2\nf 4 3 2 1"), line(10), "copy of that of line 9");
        // Written twice with vertices of its own.
        let own = "v -1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv 1 -1 -1\nf -4 -3 -2 -1\n";
        says(&format!("{cube}{own}"), line(19), "copy of that of line 9");
        says(&format!("{cube}{cube}"), line(23), "6 faces are there more than once, this one already as line 9");
        says(&format!("{cube}surf 0 1 0 1 1 2 3\n"), line(15), "'surf'");
        says(&format!("{cube}#MRGB ffff0000\n"), line(15), "polypaint");
        says(&format!("{cube}usemtl a\x1bb\nusemtl c\n"), line(15), "`usemtl a\\u{1b}b`");
        says(&format!("# Blender v2.93.1 OBJ File: ''\n{cube}"), None, "Blender");
        let bow = "v 5 0 0\nv 6 1 0\nv 6 0 0\nv 5 1 0\n";
        says(
            &format!("{cube}{bow}f -4 -3 -2 -1\nf -1 -2 -3 -4\n"),
            line(19),
            "2 faces of four corners cross themselves",
        );

        let fails = |text: &str, line: usize, part: &str| {
            let error = obj::parse(text.as_bytes(), &Conventions::default(), None).unwrap_err();
            assert!(error.place == Some(Place::Line(line)) && error.problem.to_string().contains(part), "{error:?}");
        };
        fails(&face("f 1 4\n3 2"), 10, "begins with a number");
        fails(&face("f 1 4 3 9"), 9, "a face names vertex 9, but there are 8, counted from 1");
        fails(&cube.replace("v 1 1 1", "v 1 1e35 1"), 7, "vertex 7 is at (1, 1000");
        fails(&cube.replace("v 1 1 1", "v 1 1 1\0"), 7, "'1\\0' is not a number");
        fails(&cube.replace("v 1 1 1", "v 1 \\\n1 \x1b[31m"), 7, "'\\u{1b}[31m' is not a number");
        fails(&format!("{cube}f 1 4 \\"), 15, "nothing follows");
    }

    #[test]
    fn files_are_turned() {
        let turned = |turn| {
            let conventions = Conventions { turn, ..Conventions::default() };
            let text = "v 1 2 3\nv 4 5 7\nv 7 9 11\nf 1 2 3\n";
            super::read_obj(text.as_bytes(), &conventions).unwrap().mesh.positions()[0].to_array()
        };
        assert_eq!(turned(Turn::None), [1.0, 2.0, 3.0]);
        assert_eq!(turned(Turn::YToZ), [1.0, -3.0, 2.0]);
        assert_eq!(turned(Turn::ZToY), [1.0, 3.0, -2.0]);
    }

    #[test]
    fn what_is_wrong_is_said() {
        let says = |content: &str, part: &str| {
            let error = read_obj(content.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        };
        says("", "no vertices");
        says("v 0 0 0\n", "no polygons");
        says("v 0 0 nan\nf 1 1 1\n", "no usable position");
        says("v 0 0 1e999\n", "no usable position");
        says("v 0 0\n", "cut short");
        says("v 0 0 0\nf 1 2 3\n", "names vertex 2, but there are 1");
        says("v 0 0 0\nf 0 1 1\n", "names vertex 0");
        says("v 0 0 0\nf -9223372036854775808 1 1\n", "names vertex");
        says("v 0 0 0\nf 1 1\n", "no triangle with an area");
        says("v 0 0 0\nv 1 1 1\nf 1 2 1\n", "no triangle with an area");
        says("v 0 0 0 1 0 0\nv 1 1 1\n", "others have none");
        says("v 0 0 0\nv 1 1 1 1 0 0\n", "others have none");
        says("v 0 0 0 255 0 0\n", "not within 0 … 1");
        says("v 0 x 0\n", "'x' is not a number");

        let says = |content: &[u8], part: &str| {
            let error = read_ply(content).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        };
        let whole = ply_of(&cube(1.0, 1), "binary_little_endian");
        says(&whole[..whole.len() - 1], "cut short");
        says(&[], "is empty: the file is cut short");
        says(b"solid thing\n", "is this a PLY file?");
        says(ply_header("ascii", 10_usize.pow(15), 1).as_bytes(), "more than its size can hold");
        says(b"ply\nformat binary_little_endian 1.0\nelement thing 99999999999\nend_header\n", "more than its size");
        let text = |last: &str| ply_header("ascii", 1, 1) + "0 0 0 1 1 1\n" + last;
        says(text("3 0 0 1\n").as_bytes(), "names vertex 1, but there are 1");
        says(text("3 0 0 -1\n").as_bytes(), "names vertex -1");
        says(text("2 0 0\n").as_bytes(), "no triangle with an area");
        says(text("300000000 0 0\n").as_bytes(), "'300000000 0 0' are not the numbers");
    }

    #[test]
    fn files_are_named() {
        let error = read(Path::new("nowhere/thing.obj")).unwrap_err().to_string();
        assert!(error.starts_with("nowhere/thing.obj: cannot be read"), "{error}");
        assert!(read(Path::new("thing.fbx")).unwrap_err().to_string().contains("not from 'fbx'"));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("bad.OBJ");
        std::fs::write(&file, "v 0 0 0\nf 1 2 3\n").unwrap();
        assert!(read(&file).unwrap_err().to_string().contains("bad.OBJ, line 2: "));
    }

    #[test]
    fn the_cube_of_the_scenes() {
        let mesh = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cube.obj")).unwrap();
        assert!(mesh.topology().is_closed() && (mesh.volume() - 1.6_f64.powi(3)).abs() < 1e-12);
    }

    /// Files cut anywhere, and with bytes changed, are read or refused, and what is read can be asked.
    #[test]
    fn damaged_files_never_panic() {
        let mesh = cube(0.7, 2);
        let obj = obj_of(&mesh).into_bytes();
        let files = ["ascii", "binary_little_endian", "binary_big_endian"].map(|format| ply_of(&mesh, format));
        let try_one = |content: &[u8]| {
            for read in [read_obj(content), read_ply(content)] {
                if let Ok(field) = read.and_then(|mesh| MeshDistance::new(mesh, Holes::Allow)) {
                    assert!(field.reference(DVec3::splat(0.1)).is_finite());
                }
            }
        };
        let mut state = 1_u64;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        for file in files.iter().chain([&obj]) {
            (0..file.len()).step_by(7).for_each(|end| try_one(&file[..end]));
            for _ in 0..600 {
                let mut damaged = file.clone();
                for _ in 0..=random(4) {
                    let at = random(damaged.len());
                    damaged[at] = if random(2) == 0 { random(256) as u8 } else { b"0123456789-./ \n"[random(15)] };
                }
                try_one(&damaged);
            }
        }
    }
}
