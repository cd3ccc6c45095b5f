//! Files by frame: which frame shows which file, what knows of it, and the velocities that files bring.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, IVec3, Vec3};

use crate::field::{BATCH, Points};
use crate::grid::{Band, Channel, Lattice, VoxelSize, block_order};
use crate::vdb::{self, Class, Content, Frame, Grid, Values, VectorType, WriteOptions};

use super::*;
use crate::node::*;
use crate::text::*;

const VOXEL: f64 = 0.125;

fn loaded(folder: &Path, text: &str) -> Result<Arc<Model>, String> {
    let source = Source::Text { name: "scene.toml".into(), text: text.into(), folder: folder.into() };
    load(&source, &Overrides::default()).map(Arc::new).map_err(|problems| problems.to_string())
}

fn prepared(folder: &Path, text: &str) -> Result<Prepared, String> {
    let options = PrepareOptions { resolution: Some(32), ..PrepareOptions::default() };
    loaded(folder, text)?.prepare(&options).map_err(|error| error.to_string())
}

/// A cube of this half edge, each corner red as far as the cube is large.
fn write_cube(path: &Path, half: f64) {
    let mut text = String::new();
    for i in 0..8 {
        let side = |bit: i32| if i >> bit & 1 == 1 { half } else { -half };
        writeln!(text, "v {} {} {} {half} 0 0", side(2), side(1), side(0)).unwrap();
    }
    for [a, b, c, d] in [[1, 2, 4, 3], [5, 7, 8, 6], [1, 5, 6, 2], [3, 4, 8, 7], [1, 3, 7, 5], [2, 6, 8, 4]] {
        writeln!(text, "f {a} {b} {c} {d}").unwrap();
    }
    fs::write(path, text).unwrap();
}

/// Fog that is 1 − |p|, with a velocity that is the same everywhere.
fn write_fog(path: &Path, radius: f32, velocity: Option<[f32; 3]>) {
    let lattice = Lattice { voxel_size: VoxelSize::new(VOXEL).unwrap() };
    let mut origins: Vec<IVec3> = (0..8).map(|i| (IVec3::new(i >> 2, i >> 1 & 1, i & 1) - 1) * 8).collect();
    origins.sort_by_key(|origin| block_order(*origin));
    let (blocks, active) = (origins.len(), vec![[u64::MAX; 8]; origins.len()]);
    let place = |i: usize| IVec3::new(i as i32 >> 6, i as i32 >> 3 & 7, i as i32 & 7);
    let fog = |origin: &IVec3| {
        std::array::from_fn(|i| radius + 0.5 - ((*origin + place(i)).as_vec3() * VOXEL as f32).length())
    };
    let density = Channel::of_blocks("density", &active, origins.iter().map(fog), 0.0);
    let moves =
        Channel::of_blocks("vel", &active, origins.iter().map(|_| [velocity.unwrap_or_default(); 512]), [0.0; 3]);
    let distances = vec![[0.0; 512]; blocks];
    let band = Band { lattice, half_width: 3.0, origins, distances, active, inside_tiles: vec![] };
    let mut grids =
        vec![Grid::new("density", Content::Floats { values: Values::over(&band, &density), class: Class::FogVolume })];
    if velocity.is_some() {
        let vector_type = VectorType::ContravariantRelative;
        grids.push(Grid::new("vel", Content::Vectors { values: Values::over(&band, &moves), vector_type }));
    }
    vdb::write(path, &Frame { grids, metadata: [].into() }, &WriteOptions::default()).unwrap();
}

/// A frame is its file's alone; the box is that of all.
#[test]
fn each_frame_shows_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (number, half) in [(11, 0.5), (12, 0.75), (13, 1.0)] {
        write_cube(&folder.join(format!("m.{number:04}.obj")), half);
    }
    let text = "frames = '1-5'\n[shape.a]\nmesh = 'm.%04d.obj'\nframe_offset = 10\noutside_frames = 'hold'\n";
    let all = prepared(folder, text).unwrap();
    assert_eq!(all.extent.max, DVec3::ONE);
    for (frame, file, half) in [(1, 11, 0.5), (2, 12, 0.75), (3, 13, 1.0), (5, 13, 1.0)] {
        let alone = prepared(folder, &format!("[shape.a]\nmesh = 'm.{file:04}.obj'\n")).unwrap();
        let (content, alone) = (all.frame(frame).unwrap(), alone.frame(1).unwrap());
        for at in [DVec3::ZERO, DVec3::new(0.6, 0.1, -0.2), DVec3::new(0.9, 0.9, 0.9), DVec3::X * 3.0] {
            assert_eq!(content.field.reference(at).to_bits(), alone.field.reference(at).to_bits(), "{frame} at {at}");
        }
        assert!((content.field.reference(DVec3::ZERO) - half).abs() < 1e-6);
        let mut points = Points::new(DVec3::ZERO);
        points.push(Vec3::X);
        let mut found = [[0.0; 3]; BATCH];
        content.colour.expect("colours").sampler().sample(&points, &mut found);
        let linear = ((half + 0.055) / 1.055_f64).powf(2.4) as f32;
        assert!((found[0][0] - linear).abs() < 1e-5, "{} at frame {frame}", found[0][0]);
    }
}

#[test]
fn the_hash_knows_the_files_that_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for number in 1..=4 {
        write_cube(&folder.join(format!("m.{number}.obj")), 0.5 + 0.1 * f64::from(number));
    }
    let hash = |more: &str| {
        let text = format!("frames = '1-3'\n[shape.a]\nmesh = 'm.#.obj'\n{more}\n");
        loaded(folder, &text).unwrap().hash().unwrap()
    };
    let (before, later) = (hash(""), hash("frame_offset = 1"));
    assert_ne!(before, later);
    write_cube(&folder.join("m.4.obj"), 2.0);
    assert_eq!(hash(""), before);
    assert_ne!(hash("frame_offset = 1"), later);
    write_cube(&folder.join("m.2.obj"), 2.0);
    assert_ne!(hash(""), before);
}

#[test]
fn what_a_sequence_lacks_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for number in [1, 2, 4] {
        write_cube(&folder.join(format!("m.{number:04}.obj")), 0.5);
    }
    fs::write(folder.join("m.0005.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let shape = "[shape.a]\nmesh = 'm.####.obj'\n";
    for (text, wanted) in [
        (shape.to_owned(), "the scene has no `frames`"),
        ("frames = '1-2'\n[shape.a]\nmesh = 'n.####.obj'\n".to_owned(), "there is no frame of"),
        ("frames = '1-2'\n[shape.a]\nmesh = 'm.%4d.obj'\n".to_owned(), "fills the number with spaces"),
        ("[shape.a]\nmesh = 'm.0001.obj'\nframe_offset = 1\n".to_owned(), "`frame_offset` goes with files by frame"),
        ("[shape.a]\nmesh = 'm.0001.obj'\noutside_frames = 'hold'\n".to_owned(), "goes with files by frame"),
        (
            format!("frames = '1-2'\n{shape}[shape.b]\nbox = 1\n[morph]\nfrom = 'a'\nto = 'b'\n"),
            "`a` is a file by frame, and so cannot enter a morph",
        ),
        // Read before the first frame is baked.
        (format!("frames = '4-5'\n{shape}"), "m.0005.obj"),
    ] {
        let problem = prepared(folder, &text).err().unwrap_or_else(|| panic!("{text}"));
        assert!(problem.contains(wanted), "{problem}\n{text}");
    }
    // Frames need their own files alone.
    for (frames, wanted) in [("1-4", "frame 3 of"), ("1-9", "the shot needs frames 1-9")] {
        let model = loaded(folder, &format!("frames = '{frames}'\n{shape}")).unwrap();
        assert!(model.lacking(None).to_string().contains(wanted), "{}", model.lacking(None));
        assert!(model.lacking(Some(&[1, 2, 4])).is_empty());
        assert!(model.lacking(Some(&[2, 3])).to_string().contains("frame 3 shows"));
    }
    let with_gap = prepared(folder, &format!("frames = '1-4'\n{shape}")).unwrap();
    assert!(with_gap.frame(4).is_ok());
    let problem = with_gap.frame(3).err().unwrap().to_string();
    assert!(problem.contains("frame 3 shows files of"), "{problem}");
}

/// Velocities of a file turn with the shape; where files have none that is said.
#[test]
fn velocities_of_files_are_carried() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for number in 1..=3 {
        let radius = 0.5 + 0.1 * number as f32;
        write_fog(&folder.join(format!("v.{number}.vdb")), radius, Some([1.0, 2.0, 3.0 * number as f32]));
        write_fog(&folder.join(format!("w.{number}.vdb")), radius, None);
    }
    let scene = |name: &str| {
        let text = format!(
            "frames = '1-3'\n[shape.part]\nvdb = '{name}.#.vdb'\n[shape.a]\nunion = ['part']\nrotate = [0, 0, 90]\n\
             [output]\nshape = 'a'\ngrids = ['surface', 'vel']\n"
        );
        prepared(folder, &text).unwrap_or_else(|problem| panic!("{problem}"))
    };
    let with = scene("v");
    for frame in 1..=3 {
        let movement = with.frame(frame).unwrap().movement.expect("velocities");
        let mut points = Points::new(DVec3::ZERO);
        let outward = [Vec3::X, -Vec3::Y, Vec3::ONE.normalize()];
        outward.iter().for_each(|outward| points.push(*outward * (0.5 + 0.1 * frame as f32)));
        let (mut found, mut held) = ([[0.0; 3]; BATCH], [false; BATCH]);
        movement.meter(VOXEL).velocities(&points, &outward, &mut found, &mut held);
        for found in &found[..outward.len()] {
            let off = Vec3::from(*found).distance(Vec3::new(-2.0, 1.0, 3.0 * frame as f32));
            assert!(off < 1e-5, "{found:?} at frame {frame}");
        }
    }
    let unsaid = |prepared: &Prepared| prepared.warnings.to_string().matches("is not in `vel`").count();
    assert_eq!((unsaid(&with), unsaid(&scene("w"))), (0, 1));
}
