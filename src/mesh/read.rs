//! From a path to a checked mesh.

use std::path::Path;

use super::{MeshError, Problem, TriangleMesh, obj, ply};

/// A problem, and the line it is on where that is known.
#[derive(Debug)]
pub(super) struct Located {
    pub line: Option<usize>,
    pub problem: Problem,
}

impl From<Problem> for Located {
    fn from(problem: Problem) -> Self {
        Self { line: None, problem }
    }
}

/// Reads an OBJ or PLY file, by the ending of its name. Colours of vertices are taken as sRGB-encoded and come back
/// scene-linear.
pub fn read(file: &Path) -> Result<TriangleMesh, MeshError> {
    let error = |located: Located| MeshError { file: file.into(), line: located.line, problem: located.problem };
    let ending = file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let parse = match ending.as_str() {
        "obj" => obj::parse,
        "ply" => ply::parse,
        _ => return Err(error(Problem::UnknownFormat(ending).into())),
    };
    let content = content(file).map_err(|e| error(Problem::Unreadable(e).into()))?;
    parse(&content).map_err(error)
}

/// Reads the content of an OBJ file.
pub fn read_obj(content: &[u8]) -> Result<TriangleMesh, Problem> {
    obj::parse(content).map_err(|located| located.problem)
}

/// Reads the content of a PLY file: text, or binary of either byte order.
pub fn read_ply(content: &[u8]) -> Result<TriangleMesh, Problem> {
    ply::parse(content).map_err(|located| located.problem)
}

/// A whole regular file: a pipe or a device might never end.
fn content(file: &Path) -> std::io::Result<Vec<u8>> {
    if !std::fs::metadata(file)?.is_file() {
        return Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "it is not a regular file"));
    }
    crate::disk::read(file)
}

/// Scene-linear value of an sRGB-encoded one (IEC 61966-2-1), both 0 … 1.
pub(super) fn linear(encoded: f64) -> f32 {
    let value = if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) };
    value as f32
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::shapes::cube;
    use super::super::{Holes, MeshDistance};
    use super::*;
    use crate::field::Field;

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
        says("v 0 0 0\nf 1 1\n", "2 corners");
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
        says(&[], "cut short");
        says(b"solid thing\n", "no PLY file");
        says(ply_header("ascii", 10_usize.pow(15), 1).as_bytes(), "more than its size can hold");
        says(b"ply\nformat binary_little_endian 1.0\nelement thing 99999999999\nend_header\n", "more than its size");
        let text = |last: &str| ply_header("ascii", 1, 1) + "0 0 0 1 1 1\n" + last;
        says(text("3 0 0 1\n").as_bytes(), "names vertex 1, but there are 1");
        says(text("3 0 0 -1\n").as_bytes(), "names vertex -1");
        says(text("2 0 0\n").as_bytes(), "2 corners");
        says(text("300000000 0 0\n").as_bytes(), "no PLY file");
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
