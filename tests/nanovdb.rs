//! Frames as NanoVDB, read by the layout of its version 32 (`NanoVDB.h`), against the `.vdb` of the same frame.

mod support;

use std::collections::BTreeMap;
use std::fs;

use hfvdb::vdb::{StoredClass, StoredGrid, Voxels, read};
use support::Workplace;

/// A grid in a file.
struct Nano {
    name: String,
    class: u32,
    kind: u32,
    bytes: Vec<u8>,
}

const FLOAT: u32 = 1;
const VEC3F: u32 = 6;
const FP16: u32 = 15;
const TREE: usize = 672;

fn number<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().unwrap()
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(number(bytes, at))
}

fn u64_at(bytes: &[u8], at: usize) -> usize {
    u64::from_le_bytes(number(bytes, at)) as usize
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(number(bytes, at))
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(number(bytes, at))
}

/// The grids of a file whose codec is none.
fn grids(file: &[u8]) -> Vec<Nano> {
    assert_eq!(&file[..8], b"NanoVDB0");
    assert_eq!(u32_at(file, 8) >> 21, 32, "the version of the layout");
    let count = u16::from_le_bytes(number(file, 12));
    assert_eq!(u16::from_le_bytes(number(file, 14)), 0, "the codec");
    let (mut at, mut heads) = (16, Vec::new());
    for _ in 0..count {
        let (size, on_disk, name) = (u64_at(file, at), u64_at(file, at + 8), u32_at(file, at + 136) as usize);
        assert_eq!(size, on_disk);
        heads.push((String::from_utf8(file[at + 176..at + 176 + name - 1].to_vec()).unwrap(), size));
        at += 176 + name;
    }
    let mut all = Vec::new();
    for (name, size) in heads {
        let bytes = file[at..at + size].to_vec();
        at += size;
        assert_eq!((&bytes[..8], u64_at(&bytes, 32)), (&b"NanoVDB0"[..], size));
        assert!(bytes[40..].starts_with(name.as_bytes()));
        all.push(Nano { name, class: u32_at(&bytes, 632), kind: u32_at(&bytes, 636), bytes });
    }
    assert_eq!(at, file.len());
    all
}

type Leaves = BTreeMap<[i32; 3], ([u64; 8], Vec<Vec<f32>>)>;

impl Nano {
    /// Each leaf with its mask and its values.
    fn leaves(&self) -> Leaves {
        let bytes = &self.bytes;
        let (first, count) = (TREE + u64_at(bytes, TREE), u32_at(bytes, TREE + 32) as usize);
        let size = match self.kind {
            FLOAT => 2144,
            VEC3F => 6272,
            FP16 => 1120,
            other => panic!("a grid of type {other}"),
        };
        let leaf = |number: usize| {
            let at = first + number * size;
            let origin = [0, 4, 8].map(|along| i32::from_le_bytes(self::number(bytes, at + along)) & !7);
            let mask = std::array::from_fn(|word| u64_at(bytes, at + 16 + 8 * word) as u64);
            let value = |voxel: usize| match self.kind {
                FLOAT => vec![f32_at(bytes, at + 96 + 4 * voxel)],
                VEC3F => (0..3).map(|axis| f32_at(bytes, at + 128 + 12 * voxel + 4 * axis)).collect(),
                _ => {
                    let code = u16::from_le_bytes(self::number(bytes, at + 96 + 2 * voxel));
                    vec![f32::from(code) * f32_at(bytes, at + 84) + f32_at(bytes, at + 80)]
                }
            };
            (origin, (mask, (0..512).map(value).collect()))
        };
        (0..count).map(leaf).collect()
    }

    /// How many active voxels lie in tiles of the lower nodes.
    fn active_in_tiles(&self) -> usize {
        let bytes = &self.bytes;
        let (first, count) = (TREE + u64_at(bytes, TREE + 8), u32_at(bytes, TREE + 36) as usize);
        let size = 1088 + 4096 * if self.kind == VEC3F { 16 } else { 8 };
        let of_node = |node: usize| {
            let words = (0..64).map(|word| first + node * size + 32 + 8 * word);
            words.map(|at| (u64_at(bytes, at) & !u64_at(bytes, at + 512)).count_ones() as usize).sum::<usize>() * 512
        };
        (0..count).map(of_node).sum()
    }
}

/// The same of a grid of a `.vdb`; distances negative inside, as in files.
fn leaves(grid: &StoredGrid) -> (Leaves, usize) {
    let sign = if grid.class == StoredClass::LevelSet { -1.0 } else { 1.0 };
    let floats = |value: &f32| vec![*value * sign];
    match &grid.voxels {
        Voxels::Floats(blocks) => {
            let all = blocks.origins.iter().zip(&blocks.active).zip(&blocks.values);
            let leaves =
                all.map(|((origin, mask), values)| (origin.to_array(), (*mask, values.iter().map(floats).collect())));
            let tiles = blocks.tiles.iter().filter(|tile| tile.active).map(|tile| (tile.edge as usize).pow(3)).sum();
            (leaves.collect(), tiles)
        }
        Voxels::Vectors(blocks) => {
            let all = blocks.origins.iter().zip(&blocks.active).zip(&blocks.values);
            let vectors = |values: &[[f32; 3]; 512]| values.iter().map(|value| value.to_vec()).collect();
            let leaves = all.map(|((origin, mask), values)| (origin.to_array(), (*mask, vectors(values))));
            let tiles = blocks.tiles.iter().filter(|tile| tile.active).map(|tile| (tile.edge as usize).pow(3)).sum();
            (leaves.collect(), tiles)
        }
    }
}

const SCENE: &str = "frames = '1-3'\n[shape.a]\nbox = [3, 2, 1]\nmove = ['t', 0, 0]\n\
                     color = [0.2, '0.5 + 0.1*x', 0.7]\nattribute.wear = 'x'\n[output]\nvoxel_size = 0.04\n\
                     grids = ['surface', 'density', 'Cd', 'wear', 'vel']\n";

#[test]
fn grids_are_those_of_the_vdb() {
    let place = Workplace::new();
    place.write("box.toml", SCENE);
    place.hfvdb("bake box.toml --frames 2 -o box.vdb").ok();
    place.hfvdb("bake box.toml --frames 2 -o box.nvdb --compression none").ok();
    place.hfvdb("bake box.toml --frames 2 -o half.nvdb --compression none --half surface,wear,density").ok();
    let stored = read(place.path("box.vdb")).unwrap().grids;
    for (file, halves) in [("box.nvdb", false), ("half.nvdb", true)] {
        let nano = grids(&fs::read(place.path(file)).unwrap());
        let names: Vec<&str> = nano.iter().map(|grid| grid.name.as_str()).collect();
        assert_eq!(names, stored.iter().map(|grid| grid.name.as_str()).collect::<Vec<_>>());
        for (nano, stored) in nano.iter().zip(&stored) {
            let name = &nano.name;
            let vectors = matches!(stored.voxels, Voxels::Vectors(_));
            let kind = if vectors {
                VEC3F
            } else if halves {
                FP16
            } else {
                FLOAT
            };
            let class = match stored.class {
                StoredClass::LevelSet => 1,
                StoredClass::FogVolume => 2,
                _ => 0,
            };
            assert_eq!((nano.kind, nano.class), (kind, class), "{file}: {name}");
            let edge = stored.transform.voxel_size().unwrap().x;
            assert!((f64_at(&nano.bytes, 608) - edge).abs() < 1e-12, "{name}");
            let ((ours, tiles), theirs) = (leaves(stored), nano.leaves());
            assert_eq!(ours.len(), theirs.len(), "{file}: {name}");
            for (origin, (mask, values)) in &ours {
                let (their_mask, their_values) = &theirs[origin];
                assert_eq!(mask, their_mask, "{file}: {name} at {origin:?}");
                let flat = || values.iter().flatten();
                let (least, most) =
                    (flat().copied().fold(f32::MAX, f32::min), flat().copied().fold(f32::MIN, f32::max));
                // Half a step of the leaf's codes, and rounding.
                let error = if kind == FP16 { (most - least) / 65535.0 * 0.51 + 1e-6 * most.abs() } else { 0.0 };
                let same = |(a, b): (&f32, &f32)| (a - b).abs() <= error;
                assert!(flat().zip(their_values.iter().flatten()).all(same), "{file}: {name} at {origin:?}");
            }
            assert_eq!(nano.active_in_tiles(), tiles, "{file}: {name}");
        }
        let inside = nano.iter().find(|grid| grid.name == "density").unwrap();
        assert!(inside.active_in_tiles() > 0, "the box is thick enough for tiles");
    }
}

#[test]
fn files_are_the_same_each_time_and_small_where_asked() {
    let place = Workplace::new();
    place.write("box.toml", SCENE.replace("0.04", "0.1"));
    let mut sizes = Vec::new();
    for codec in ["none", "blosc", "zip"] {
        let bake = format!("bake box.toml --frames 1-2 --compression {codec} -o");
        place.hfvdb(&format!("{bake} {codec}/a.####.nvdb")).ok();
        place.hfvdb(&format!("{bake} {codec}/b.####.nvdb --threads 1")).ok();
        let read = |name: &str| fs::read(place.path(&format!("{codec}/{name}"))).unwrap();
        assert!(read("a.0002.nvdb") == read("b.0002.nvdb"), "{codec}");
        assert!(read("a.0001.nvdb") != read("a.0002.nvdb"));
        sizes.push(read("a.0001.nvdb").len());
        place.hfvdb(&format!("verify {codec}")).ok();
    }
    assert!(sizes[1] * 2 < sizes[0] && sizes[2] * 2 < sizes[0], "{sizes:?}");
    place.hfvdb("bake box.toml --frames 1 -o c.nvdb --half Cd").fails(2, &["--half", "no vectors of 16 bits", "`Cd`"]);
    place.hfvdb("bake box.toml --frames 1 -o c.nvdb --half Cd --for vray").ok();
    place.hfvdb("convert box.vdb -o d.nvdb").fails(1, &["box.vdb"]);
    place.hfvdb("mesh blosc/a.####.nvdb -o d.nvdb").fails(2, &["mesh writes polygons"]);
    for command in ["info", "check", "preview -o d.png", "convert -o d.vdb", "mesh -o d.ply", "usd -o d.usda"] {
        place.hfvdb(&format!("{command} c.nvdb")).fails(2, &["c.nvdb", "does not read it"]);
    }
    place.hfvdb("bake box.toml --frames 1 -o e.vdb").ok();
    place.hfvdb("convert e.vdb -o e.nvdb --compression none").ok();
    let names: Vec<String> =
        grids(&fs::read(place.path("e.nvdb")).unwrap()).into_iter().map(|grid| grid.name).collect();
    assert_eq!(names, ["surface", "Cd", "wear", "vel"]);
}
