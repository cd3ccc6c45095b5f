use glam::IVec3;

use super::support::*;
use crate::grid::*;
use crate::vdb::walk::{Layout, walk, walk_bytes};
use crate::vdb::*;

/// Small files of each kind of compression, with tiles of all sizes.
fn files() -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let mut band = ball();
    // Some blocks are enough, and smaller files are damaged more thoroughly.
    band.origins.truncate(4);
    band.distances.truncate(4);
    band.active.truncate(4);
    band.inside_tiles = vec![
        InsideTile { origin: IVec3::splat(256), edge: 128 },
        InsideTile { origin: IVec3::splat(4096), edge: 4096 },
    ];
    let channel = ball_colour(&band, "Cd");
    let mut files = vec![];
    for compression in [Compression::Blosc, Compression::Zip, Compression::None] {
        for half in [false, true] {
            let mut grids = vec![Grid::level_set("surface", &band), Grid::colour(&band, &channel)];
            grids.iter_mut().for_each(|grid| grid.half = half);
            let frame = Frame { grids, metadata: [("creator".into(), "test".into())].into() };
            let path = folder.path().join("small.vdb");
            write(&path, &frame, &WriteOptions { compression, overwrite: true }).unwrap();
            files.push((format!("{compression:?}, half: {half}"), std::fs::read(&path).unwrap()));
        }
    }
    files
}

fn walked(bytes: &[u8]) -> Result<Layout, Error> {
    walk_bytes(bytes, "test.vdb".as_ref())
}

#[test]
fn it_counts_what_the_band_holds() {
    let folder = tempfile::tempdir().unwrap();
    let (path, band) = (folder.path().join("ball.vdb"), ball());
    let frame = Frame { grids: vec![Grid::level_set("surface", &band)], ..Default::default() };
    write(&path, &frame, &WriteOptions::default()).unwrap();
    let layout = walk(&path).unwrap();
    assert_eq!((layout.format, layout.library), (224, (10, 0)));
    let grid = &layout.grids[0];
    assert_eq!((grid.name.as_str(), grid.tree_type.as_str(), grid.half), ("surface", "Tree_float_5_4_3", false));
    assert_eq!(grid.transform.uniform_voxel_size(), Some(VOXEL_SIZE));
    assert_eq!(grid.metadata["class"], "level set".into());
    let tree = grid.tree.as_ref().unwrap();
    let active: Vec<IVec3> = box_voxels().filter(|voxel| distance(*voxel).abs() < band.background()).collect();
    assert_eq!((tree.leaves, tree.active_voxels), (band.origins.len() as u64, active.len() as u64));
    let low = active.iter().fold(IVec3::MAX, |low, voxel| low.min(*voxel));
    let high = active.iter().fold(IVec3::MIN, |high, voxel| high.max(*voxel));
    assert_eq!(tree.active_box, Some((low, high)));
}

#[test]
fn a_cut_is_found_wherever_it_is() {
    for (name, bytes) in files() {
        walked(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        for length in (0..bytes.len()).step_by(7).chain(bytes.len() - 70..bytes.len()) {
            let cut = walked(&bytes[..length]);
            assert!(matches!(cut, Err(Error::Damaged { .. })), "{name}: cut at {length} of {}", bytes.len());
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(walked(&longer).is_err(), "{name}: a byte more");
    }
}

#[test]
fn the_walk_survives_any_damage() {
    let mut random = Random(1);
    for (_, bytes) in files() {
        for _ in 0..400 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + random.below(3) {
                let place = random.below(damaged.len());
                damaged[place] = match random.below(3) {
                    0 => 0,
                    1 => 255,
                    _ => damaged[place] ^ 1 << random.below(8),
                };
            }
            let _ = walked(&damaged); // any answer, and no panic
        }
    }
}

#[test]
fn a_damaged_length_or_mask_is_found_everywhere_outside_the_values() {
    // Uncompressed, all that is not a value, a name or a number of metadata has to fit the rest.
    let (_, bytes) = files().swap_remove(4);
    let mut found = 0;
    for place in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x81;
        found += usize::from(walked(&damaged).is_err());
    }
    // Two upper and lower nodes' masks a grid alone are more than half of this file.
    assert!(found * 2 > bytes.len(), "{found} of {}", bytes.len());
}
