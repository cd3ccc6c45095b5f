use std::fs;
use std::path::Path;
use std::process::Command;

use glam::IVec3;

use super::support::*;
use crate::disk;
use crate::grid::*;
use crate::vdb::read::Opened;
use crate::vdb::*;

fn ball_file(folder: &Path, half: bool) -> (std::path::PathBuf, Band, Channel<[f32; 3]>) {
    let (path, mut band) = (folder.join("ball.vdb"), ball());
    band.inside_tiles.push(InsideTile { origin: IVec3::splat(256), edge: 128 });
    band.inside_tiles.push(InsideTile { origin: IVec3::splat(4096), edge: 4096 });
    let colour = ball_colour(&band, "Cd");
    let mut grids = vec![Grid::level_set("surface", &band), Grid::colour(&band, &colour)];
    grids.iter_mut().for_each(|grid| grid.half = half);
    let frame = Frame { grids, metadata: [("creator".into(), "test".into())].into() };
    write(&path, &frame, &WriteOptions::default()).unwrap();
    (path, band, colour)
}

#[test]
fn a_band_comes_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let (path, band, colour) = ball_file(folder.path(), false);
    let contents = read(&path).unwrap();
    assert_eq!(contents.metadata["creator"], "test".into());
    assert!(contents.skipped.is_empty());
    let back = contents.grids[0].to_band().unwrap();
    assert_eq!(back.lattice, band.lattice);
    assert_eq!(back.half_width, band.half_width);
    assert_eq!(back.origins, band.origins);
    assert_eq!(back.active, band.active);
    assert_eq!(back.distances, band.distances);
    assert_eq!(back.inside_tiles, band.inside_tiles);
    let Voxels::Vectors(vectors) = &contents.grids[1].voxels else { panic!("Cd holds vectors") };
    assert_eq!(vectors.origins, band.origins);
    assert_eq!(vectors.background, colour.background);
    for (block, (values, mask)) in vectors.values.iter().zip(&vectors.active).enumerate() {
        for place in 0..512 {
            assert_eq!(values[place], colour.at(block, mask, place));
        }
    }
}

#[test]
fn a_file_is_described() {
    let folder = tempfile::tempdir().unwrap();
    let (path, band, _) = ball_file(folder.path(), true);
    let info = inspect(&path).unwrap();
    assert_eq!((info.format, info.library.as_str()), (224, "10.0"));
    assert_eq!(info.bytes, fs::metadata(&path).unwrap().len());
    let surface = &info.grids[0];
    assert_eq!((surface.value_type.as_str(), surface.class, surface.half), ("float", StoredClass::LevelSet, true));
    assert_eq!(surface.compression, "blosc + active values");
    assert_eq!(surface.active_voxels, Some(band.active_voxels()));
    assert_eq!(surface.leaves, Some(band.origins.len() as u64));
    assert_eq!(surface.voxel_size, Some([VOXEL_SIZE; 3]));
    // Half floats hold eleven bits.
    let background = surface.background.as_ref().unwrap()[0];
    assert!((background - band.background()).abs() <= band.background() / 2048.0);
    let range = surface.range.as_ref().unwrap();
    assert!(range.least[0] >= -background && range.least[0] < -0.9 * background);
    assert!(range.greatest[0] <= background && range.greatest[0] > 0.9 * background);
    let colour = &info.grids[1];
    assert_eq!((colour.value_type.as_str(), colour.class), ("vec3s", StoredClass::Unknown));
    assert_eq!(colour.vector_type.as_deref(), Some("invariant"));
    assert_eq!(colour.range.as_ref().unwrap().least.len(), 3);
    assert_eq!(colour.index_box, surface.index_box);
    let json = serde_json::to_value(&info).unwrap();
    assert_eq!(json["grids"][0]["class"], "level_set");
    assert_eq!(json["metadata"]["creator"], "test");
}

/// Files that OpenVDB's own library makes: its sphere, other types, shared trees, names twice, shifted grids, streams.
const MAKER: &str = "
import sys, pyopenvdb as vdb
folder = sys.argv[1]
ball = vdb.createLevelSetSphere(1.0, center=(0.5, 0, 0), voxelSize=0.1, halfWidth=2.0)
ball.name = 'ball'
moved = ball.deepCopy()
moved.name = 'moved'
moved.transform = vdb.createLinearTransform([[.1,0,0,0],[0,.1,0,0],[0,0,.1,0],[.8,0,-1.6,1]])
twin = ball.copy()
twin.name = 'twin'
flags = vdb.BoolGrid(); flags.name = 'flags'; flags.fill((0, 0, 0), (20, 9, 9), True)
vdb.write(folder + '/many.vdb', grids=[ball, moved, twin, ball.deepCopy(), flags], metadata={'a': 1})
empty = vdb.FloatGrid(0.3); empty.name = 'empty'
vdb.write(folder + '/empty.vdb', grids=[empty])
vdb.write(folder + '/none.vdb', grids=[])
";

#[test]
fn files_of_other_makers_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let made = Command::new("/usr/bin/python3").args(["-c", MAKER]).arg(folder.path()).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let many = read(folder.path().join("many.vdb")).unwrap();
    let names: Vec<&str> = many.grids.iter().map(|grid| grid.name.as_str()).collect();
    assert_eq!(names, ["ball", "moved", "twin", "ball"]);
    assert_eq!(many.skipped, [("flags".to_string(), "Tree_bool_5_4_3".to_string())]);
    assert_eq!(many.metadata["a"], MetadataValue::Int32(1));
    let shift = glam::DVec3::new(0.8, 0.0, -1.6); // 8 and 16 voxels: one block and two
    for (grid, centre) in [(0, glam::DVec3::X * 0.5), (1, glam::DVec3::X * 0.5 + shift), (2, glam::DVec3::X * 0.5)] {
        let band = many.grids[grid].to_band().unwrap();
        assert_eq!(band.half_width, 2.0);
        assert!(band.origins.is_sorted_by_key(|origin| block_order(*origin)));
        for (origin, values) in band.origins.iter().zip(&band.distances) {
            for (place, voxel) in voxels(*origin).enumerate() {
                let exact = 1.0 - (voxel.as_dvec3() * 0.1).distance(centre);
                assert!((f64::from(values[place]) - exact.clamp(-0.2, 0.2)).abs() < 1e-6, "{grid}: {voxel}");
            }
        }
    }

    let info = inspect(folder.path().join("many.vdb")).unwrap();
    assert_eq!(info.grids[2].shares_tree_of.as_deref(), Some("ball"));
    assert_eq!(info.grids[4].active_voxels, Some(21 * 10 * 10));
    let empty = inspect(folder.path().join("empty.vdb")).unwrap();
    assert_eq!((empty.grids[0].active_voxels, &empty.grids[0].range), (Some(0), &None));
    assert!(read(folder.path().join("none.vdb")).unwrap().grids.is_empty());
    // A picture frames the level set that it shows, not all that the file holds.
    let shown = level_set_box(folder.path().join("many.vdb")).unwrap();
    assert!(shown.is_some() && shown == info.grids[0].world_box && shown != info.grids[1].world_box, "{shown:?}");
    assert_eq!(level_set_box(folder.path().join("none.vdb")).unwrap(), None);
}

#[test]
fn what_is_no_vdb_is_said_to_be_none() {
    let folder = tempfile::tempdir().unwrap();
    for (content, part) in
        [(&b"hello"[..], "no OpenVDB file"), (b"", "empty"), (b" BDV\0\0\0\0\x64\0\0\0", "format 100")]
    {
        let path = folder.path().join("x.vdb");
        fs::write(&path, content).unwrap();
        let text = read(&path).expect_err("refused").to_string();
        assert!(text.contains("x.vdb") && text.contains(part), "{text}");
    }
    assert!(matches!(read(folder.path().join("missing.vdb")), Err(Error::Disk(disk::Error::System { .. }))));
}

#[test]
fn damage_that_the_walk_lets_pass_ends_in_words_or_values() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(7);
    let path = folder.path().join("ball.vdb");
    let band = ball();
    let colour = ball_colour(&band, "Cd");
    for (half, compression) in
        [(false, Compression::Blosc), (true, Compression::Blosc), (false, Compression::Zip), (true, Compression::None)]
    {
        let mut grids = vec![Grid::level_set("surface", &band), Grid::colour(&band, &colour)];
        grids.iter_mut().for_each(|grid| grid.half = half);
        let bytes = encode(&Frame { grids, ..Default::default() }, compression).unwrap().concat();
        let (mut passed, mut refused) = (0, 0);
        for _ in 0..400 {
            let mut damaged = bytes.clone();
            let place = random.below(damaged.len());
            damaged[place] ^= 1 << random.below(8);
            let Ok(opened) = Opened::from_bytes(damaged, &path) else { continue };
            passed += 1;
            for grid in &opened.layout.grids {
                match opened.voxels(grid) {
                    Ok(_) => {} // other values
                    Err(Error::Damaged { offset, problem, .. }) => {
                        assert!(offset > 0 && problem.starts_with("grid '"), "{problem}");
                        refused += 1;
                    }
                    Err(Error::Unsupported { problem, .. }) => assert!(problem.contains("Blosc"), "{problem}"),
                    Err(other) => panic!("{other}"),
                }
            }
        }
        assert!(passed > 10, "only {passed} passed the walk");
        assert!(refused > 0 || compression == Compression::None, "{compression:?}: none was refused");
    }
}
