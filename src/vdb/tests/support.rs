//! A ball whose every voxel is known, and the independent reader.

use std::path::Path;
use std::process::Command;

use glam::{DVec3, IVec3};
use serde_json::Value;

use crate::grid::*;

/// A ball of radius 1 away from the world's origin, 0.07 units a voxel, half-width 3: some 60 blocks.
pub const CENTRE: DVec3 = DVec3::new(0.31, -0.2, 0.13);
pub const VOXEL_SIZE: f64 = 0.07;
/// The box of all its blocks, its last voxel included.
pub const LOW: i32 = -24;
pub const HIGH: i32 = 31;

/// F at a voxel: positive inside.
pub fn distance(voxel: IVec3) -> f32 {
    (1.0 - (voxel.as_dvec3() * VOXEL_SIZE).distance(CENTRE)) as f32
}

pub fn colour(voxel: IVec3) -> [f32; 3] {
    let position = voxel.as_vec3() * VOXEL_SIZE as f32;
    (position * 0.3 + 0.5).to_array()
}

pub fn voxels(origin: IVec3) -> impl Iterator<Item = IVec3> {
    (0..512).map(move |place| origin + IVec3::new(place >> 6, place >> 3 & 7, place & 7))
}

pub fn ball() -> Band {
    let lattice = Lattice { voxel_size: VoxelSize::new(VOXEL_SIZE).unwrap() };
    let mut band =
        Band { lattice, half_width: 3.0, origins: vec![], distances: vec![], active: vec![], inside_tiles: vec![] };
    let background = band.background();
    let mut corners: Vec<IVec3> = voxels(IVec3::ZERO).map(|step| step * 8 + IVec3::splat(LOW)).collect();
    corners.retain(|corner| corner.max_element() <= HIGH);
    corners.sort_by_key(|corner| block_order(*corner));
    for origin in corners {
        let mut values = [0.0; BLOCK_VOXELS];
        let mut mask: BlockMask = [0; 8];
        for (place, voxel) in voxels(origin).enumerate() {
            let exact = distance(voxel);
            values[place] = exact.clamp(-background, background);
            if exact.abs() < background {
                mask[place / 64] |= 1 << (place % 64);
            }
        }
        if mask != [0; 8] {
            band.origins.push(origin);
            band.distances.push(values);
            band.active.push(mask);
        } else if values[0] > 0.0 {
            band.inside_tiles.push(InsideTile { origin, edge: 8 });
        }
    }
    band
}

/// A channel of one value.
pub fn even(band: &Band, name: &str, value: f32) -> Channel<f32> {
    Channel::of_blocks(name, &band.active, band.origins.iter().map(|_| [value; BLOCK_VOXELS]), 0.0)
}

/// Colours over the ball's blocks.
pub fn ball_colour(band: &Band, name: &str) -> Channel<[f32; 3]> {
    let block = |(origin, mask): (&IVec3, &BlockMask)| {
        let mut values = [[7.0; 3]; BLOCK_VOXELS];
        for (place, voxel) in voxels(*origin).enumerate() {
            if mask[place / 64] >> (place % 64) & 1 == 1 {
                values[place] = colour(voxel);
            }
        }
        values
    };
    let blocks = band.origins.iter().zip(&band.active).map(block);
    Channel::of_blocks(name, &band.active, blocks, [0.25, 0.5, 0.75])
}

/// What Debian's Python OpenVDB says of a file; its voxels go to `folder`.
pub fn judge(path: &Path, folder: &Path) -> Value {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/dump_grids.py");
    let output = Command::new("/usr/bin/python3")
        .arg(script)
        .args([path, folder])
        .arg(format!("{LOW},{LOW},{LOW},{HIGH},{HIGH},{HIGH}"))
        .output()
        .expect("python3 starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("the script prints JSON")
}

/// The box's voxels in the order of the dumps.
pub fn box_voxels() -> impl Iterator<Item = IVec3> {
    let range = LOW..=HIGH;
    range.clone().flat_map(move |x| {
        let range = LOW..=HIGH;
        range.clone().flat_map(move |y| range.clone().map(move |z| IVec3::new(x, y, z)))
    })
}

pub fn dumped(folder: &Path, name: &str) -> (Vec<f32>, Vec<bool>) {
    let values = std::fs::read(folder.join(format!("{name}.values"))).unwrap();
    let active = std::fs::read(folder.join(format!("{name}.active"))).unwrap();
    let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
    (values.chunks_exact(4).map(number).collect(), active.iter().map(|byte| *byte != 0).collect())
}

/// Numbers that repeat: SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    pub fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}
