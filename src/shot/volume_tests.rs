//! Colours from a grid of a file: what is read, where it stands, and what is wrong with it.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use glam::{DVec3, IVec3, Vec3};

use crate::field::{BATCH, Points};
use crate::grid::{Band, Channel, InsideTile, Lattice, VoxelSize, block_order};
use crate::vdb::{self, Class, Content, Frame, Grid, Tiles, Values, VectorType, WriteOptions};

use super::*;
use crate::node::*;
use crate::text::*;

const VOXEL: f64 = 0.125;

const NAN_MAKER: &str = "
import sys, pyopenvdb as vdb
colour = vdb.Vec3SGrid(); colour.name = 'Cd'
colour.getAccessor().setValueOn((1, 2, 3), (0, float('nan'), 0))
vdb.write(sys.argv[1] + '/nan.vdb', grids=[colour])
";

/// All voxels of a cube of 16³ around the origin, coloured by where they are; its world half edge is 1.
fn cube() -> (Band, Channel<[f32; 3]>) {
    let lattice = Lattice { voxel_size: VoxelSize::new(VOXEL).unwrap() };
    let mut origins: Vec<IVec3> = (0..8).map(|i| IVec3::new(i >> 2, i >> 1 & 1, i & 1) * 8 - IVec3::splat(8)).collect();
    origins.sort_by_key(|origin| block_order(*origin));
    let colour = |origin: &IVec3| {
        std::array::from_fn(|i| {
            colour_at((*origin + IVec3::new(i as i32 >> 6, i as i32 >> 3 & 7, i as i32 & 7)).as_dvec3() * VOXEL)
        })
    };
    let blocks = origins.len();
    let active = vec![[u64::MAX; 8]; blocks];
    let colours = Channel::of_blocks("Cd", &active, origins.iter().map(colour), [0.0; 3]);
    let band =
        Band { lattice, half_width: 3.0, origins, distances: vec![[0.0; 512]; blocks], active, inside_tiles: vec![] };
    (band, colours)
}

fn colour_at(at: DVec3) -> [f32; 3] {
    (at * 0.25 + 0.5).as_vec3().to_array()
}

fn write_cube(path: &Path, half: bool) {
    let (band, colour) = cube();
    let mut grids = vec![Grid::level_set("surface", &band), Grid::colour(&band, &colour)];
    grids.iter_mut().for_each(|grid| grid.half = half);
    vdb::write(path, &Frame { grids, metadata: [].into() }, &WriteOptions::default()).unwrap();
}

fn loaded(folder: &Path, text: &str) -> Result<Model, Diagnostics> {
    load(&Source::Text { name: "scene.toml".into(), text: text.into(), folder: folder.into() }, &Overrides::default())
}

fn prepared(folder: &Path, text: &str, memory_limit: Option<usize>) -> Result<Prepared, Error> {
    let model = loaded(folder, text).unwrap_or_else(|problems| panic!("{problems}"));
    let options = PrepareOptions {
        voxel_size: None,
        resolution: Some(64),
        half_width: None,
        memory_limit,
        cache: None,
        cancel: Arc::default(),
        progress: &|_, _| (),
    };
    Arc::new(model).prepare(&options)
}

fn colour(prepared: &Prepared, at: [f64; 3]) -> [f32; 3] {
    let colour = prepared.frame(1).unwrap().colour.expect("there is a colour");
    let mut points = Points::new(at.into());
    points.push(Vec3::ZERO);
    let mut out = [[0.0; 3]; BATCH];
    colour.sampler().sample(&points, &mut out);
    out[0]
}

#[track_caller]
fn same(found: [f32; 3], wanted: [f32; 3], tolerance: f32) {
    assert!(Vec3::from(found).distance(Vec3::from(wanted)) < tolerance, "{found:?}, not {wanted:?}");
}

#[test]
fn a_grid_colours_a_shape_in_its_own_space() {
    let folder = tempfile::tempdir().unwrap();
    for (half, tolerance) in [(false, 1e-6), (true, 5e-4)] {
        write_cube(&folder.path().join("a.vdb"), half);
        let scene = "[shape.a]\nsphere = 0.9\nscale = 2\nmove = [5, 0, 0]\ncolor = { vdb = 'a.vdb' }\n";
        let ready = prepared(folder.path(), scene, None).unwrap();
        for at in [[5.0, 0.0, 0.0], [5.5, -0.3, 1.1], [3.7, 0.1, 0.2]] {
            same(colour(&ready, at), colour_at((DVec3::from(at) - DVec3::X * 5.0) / 2.0), tolerance);
        }
        assert!(ready.memory_estimate() > 8 * 512 * 12);
        fs::remove_file(folder.path().join("a.vdb")).unwrap();
    }
}

#[test]
fn outside_it_is_the_foot_or_the_mean_of_all() {
    let folder = tempfile::tempdir().unwrap();
    write_cube(&folder.path().join("a.vdb"), false);
    let scene = |rest: &str| format!("[shape.a]\nsphere = 2\ncolor = {{ vdb = 'a.vdb'{rest} }}\n");
    let at = [1.9, 0.2, -0.4];
    let foot = prepared(folder.path(), &scene(""), None).unwrap();
    same(colour(&foot, at), colour_at(DVec3::new(0.875, 0.2, -0.4)), 1e-6);
    for power in [2, 4] {
        let scene = scene(&format!(", outside = 'potential', power = {power}"));
        let ready = prepared(folder.path(), &scene, None).unwrap();
        // Eq. 4, term by term.
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for i in 0..4096 {
            let voxel = IVec3::new(i >> 8, i >> 4 & 15, i & 15) - IVec3::splat(8);
            let centre = voxel.as_dvec3() * VOXEL;
            let weight = centre.distance(at.into()).powi(-power);
            sum += weight * Vec3::from(colour_at(centre)).as_dvec3();
            total += weight;
        }
        same(colour(&ready, at), (sum / total).as_vec3().to_array(), 0.5 / 255.0);
    }
}

/// A scalar from a grid of numbers goes by the same ways, and may move the surface.
#[test]
fn a_grid_of_numbers_is_a_scalar() {
    let folder = tempfile::tempdir().unwrap();
    let (band, _) = cube();
    let number = |at: DVec3| (at.x * 0.1 + at.z * 0.05) as f32;
    let place = |i: usize| IVec3::new(i as i32 >> 6, i as i32 >> 3 & 7, i as i32 & 7);
    let block = |origin: &IVec3| std::array::from_fn(|i| number((*origin + place(i)).as_dvec3() * VOXEL));
    let channel = Channel::of_blocks("bump", &band.active, band.origins.iter().map(block), 0.0);
    let values = Values::over(&band, &channel);
    let grids = vec![Grid::new("bump", Content::Floats { values, class: Class::Unknown })];
    let path = folder.path().join("a.vdb");
    vdb::write(&path, &Frame { grids, metadata: [].into() }, &WriteOptions::default()).unwrap();
    let scene = |rest: &str| format!("[shape.a]\nsphere = 0.7\nscale = 2\n{rest}\n");
    let at = |ready: &Prepared, at: [f64; 3]| scalar_tests::scalar(&ready.frame(1).unwrap(), "bump", at);
    let ready = prepared(folder.path(), &scene("attribute.bump = { vdb = 'a.vdb' }"), None).unwrap();
    assert!((at(&ready, [0.5, -0.3, 1.1]) - number(DVec3::new(0.25, -0.15, 0.55))).abs() < 1e-6);
    assert!((at(&ready, [4.0, 0.0, 0.0]) - number(DVec3::X * 0.875)).abs() < 1e-6);
    let potential = "attribute.bump = { vdb = 'a.vdb', outside = 'potential' }";
    let ready = prepared(folder.path(), &scene(potential), None).unwrap();
    // By eq. 4, in the shape's own space.
    let (mut sum, mut total, own) = (0.0, 0.0, DVec3::new(1.5, 0.25, -0.5));
    for i in 0..4096 {
        let centre = (IVec3::new(i >> 8, i >> 4 & 15, i & 15) - IVec3::splat(8)).as_dvec3() * VOXEL;
        let weight = centre.distance(own).powi(-4);
        sum += weight * f64::from(number(centre));
        total += weight;
    }
    // To 1/255 of the range of 0.28.
    assert!((f64::from(at(&ready, (own * 2.0).to_array())) - sum / total).abs() < 0.6e-3);
    // Moved by it: 0.1 x + 0.05 z before the shape is scaled.
    let ready = prepared(folder.path(), &scene("displace = 'bump'\nattribute.bump = { vdb = 'a.vdb' }"), None).unwrap();
    let field = ready.frame(1).unwrap().field;
    for way in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::new(0.6, 0.0, 0.8)] {
        // r − s + s·n(way) = 0.
        let s = 0.7 / (1.0 - f64::from(number(way)));
        assert!(
            field.reference(way * (2.0 * s - 1e-4)) > 0.0 && field.reference(way * (2.0 * s + 1e-4)) < 0.0,
            "{way}"
        );
    }
    let problem = |rest: &str| prepared(folder.path(), &scene(rest), None).err().expect("it is wrong").to_string();
    let said = problem("attribute.heat = { vdb = 'a.vdb' }");
    assert!(said.contains("has no grid 'heat'") && said.contains("its grids of attributes: `bump`"), "{said}");
    write_cube(&folder.path().join("b.vdb"), false);
    let said = problem("attribute.heat = { vdb = 'b.vdb', grid = 'Cd' }");
    assert!(said.contains("is of type vec3s, and attributes are float"), "{said}");
    let hash = || loaded(folder.path(), &scene("attribute.bump = { vdb = 'a.vdb' }")).unwrap().hash().unwrap();
    let before = hash();
    fs::copy(folder.path().join("b.vdb"), &path).unwrap();
    assert_ne!(before, hash());
}

#[test]
fn tiles_are_voxels_too() {
    let folder = tempfile::tempdir().unwrap();
    let (band, channel) = cube();
    let tiles = [InsideTile { origin: IVec3::splat(128), edge: 128 }];
    let mut values = Values::over(&band, &channel);
    values.tiles = Tiles { places: &tiles, values: &[[0.25, 0.5, 0.75]] };
    let grid = Grid::new("Cd", Content::Vectors { values, vector_type: VectorType::Invariant });
    let frame = Frame { grids: vec![grid], metadata: [].into() };
    vdb::write(folder.path().join("a.vdb"), &frame, &WriteOptions::default()).unwrap();
    let scene = "[shape.a]\nsphere = 2\ncolor = { vdb = 'a.vdb' }\n";
    let ready = prepared(folder.path(), scene, None).unwrap();
    assert_eq!(colour(&ready, [20.0; 3]), [0.25, 0.5, 0.75]);
    assert_eq!(colour(&ready, [99.0; 3]), [0.25, 0.5, 0.75]);
    let error = prepared(folder.path(), scene, Some(20 << 20)).err().expect("over the limit").to_string();
    assert!(error.contains("MB of memory, and the limit is 20 MB") && error.contains("scene.toml:3:18"), "{error}");
}

#[test]
fn a_file_is_part_of_what_identifies_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let hash = |half| {
        write_cube(&folder.path().join("a.vdb"), half);
        let hash = loaded(folder.path(), "[shape.a]\nsphere = 2\ncolor = { vdb = 'a.vdb' }\n").unwrap().hash().unwrap();
        fs::remove_file(folder.path().join("a.vdb")).unwrap();
        hash
    };
    assert_ne!(hash(false), hash(true));
}

#[test]
fn what_is_wrong_has_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vdb");
    write_cube(&path, false);
    let check = |colour: &str, place: &str, parts: &[&str]| {
        let text = format!("[shape.a]\nsphere = 2\ncolor = {{ {colour} }}\n");
        let said = match loaded(folder.path(), &text) {
            Err(problems) => problems.to_string(),
            Ok(_) => prepared(folder.path(), &text, None).err().expect("the scene is wrong").to_string(),
        };
        for part in [&[place], parts].concat() {
            assert!(said.contains(part), "{part} is not in:\n{said}");
        }
    };
    check("vdb = 'b.vdb'", "scene.toml:3:18", &["no file `b.vdb`", "did you mean `a.vdb`"]);
    check("vdb = 3", "scene.toml:3:17", &["a file's name"]);
    check("vdb = 'a.vdb', grid = 'cd'", "scene.toml:3:34", &["has no grid 'cd'", "did you mean `Cd`"]);
    check("vdb = 'a.vdb', grid = 'velocity'", "scene.toml:3:34", &["its grids of colours: `Cd`"]);
    check("vdb = 'a.vdb', grid = 'surface'", "scene.toml:3:34", &["is of type float, and colours are vec3s"]);
    check("vdb = 'a.vdb', outside = 'far'", "scene.toml:3:37", &["potential"]);
    check("vdb = 'a.vdb', power = 4", "scene.toml:3:26", &["`power` is for `outside = \"potential\"` only"]);
    check("vdb = 'a.vdb', outside = 'potential', power = 1", "scene.toml:3:57", &["from 2 to 8"]);
    check("vdb = 'a.vdb', palette = ['red']", "scene.toml:3", &["both say what"]);
    check("vdb = '.'", "scene.toml:3:18", &["is a folder"]);
    check("vdb = 'cube.obj'", "scene.toml:3:18", &["cube.obj", "no OpenVDB file"]);

    let (band, colour) = cube();
    let write = |name: &str, band: &Band, colour: &Channel<[f32; 3]>| {
        let number = Channel::of_blocks("heat", &band.active, band.origins.iter().map(|_| [0.0; 512]), 0.0);
        let values = Values::over(band, &number);
        let mut grids = vec![Grid::new("heat", Content::Floats { values, class: Class::Unknown })];
        if name != "numbers.vdb" {
            grids.push(Grid::colour(band, colour));
        }
        vdb::write(folder.path().join(name), &Frame { grids, metadata: [].into() }, &WriteOptions::default()).unwrap();
    };
    write("numbers.vdb", &band, &colour);
    check("vdb = 'numbers.vdb'", "scene.toml:3:18", &["has no grid 'Cd'", "there is `heat` (float)"]);
    let mut none = band.clone();
    (none.origins, none.active, none.distances) = (vec![], vec![], vec![]);
    write("none.vdb", &none, &Channel { values: vec![], ..colour.clone() });
    check("vdb = 'none.vdb'", "scene.toml:3:18", &["grid 'Cd'", "has no active voxels"]);
    // The writer here refuses such values.
    let made = Command::new("/usr/bin/python3").args(["-c", NAN_MAKER]).arg(folder.path()).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    check("vdb = 'nan.vdb'", "scene.toml:3:18", &["without a finite value"]);

    let bytes = fs::read(&path).unwrap();
    fs::write(folder.path().join("cut.vdb"), &bytes[..bytes.len() / 2]).unwrap();
    check("vdb = 'cut.vdb'", "scene.toml:3:18", &["cut.vdb", "damaged at byte"]);
}
