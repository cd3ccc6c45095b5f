//! Numbers of cells, by whole numbers alone.

use glam::{DVec3, I64Vec3};

use crate::field::Aabb;

/// 64 bits of a cell: its place and the seed folded in one after another, each mixed by the finisher of SplitMix64 (Steele, Lea
/// and Flood, 2014).
pub(in crate::field) fn of_cell(cell: I64Vec3, seed: u64) -> u64 {
    [cell.x, cell.y, cell.z].into_iter().fold(mixed(seed), |hash, part| mixed(hash ^ part as u64))
}

/// The cells so many steps away along the axis along which they are the farthest; the own one where that is none.
pub(in crate::field) fn cells_around(ring: i64, mut each: impl FnMut(I64Vec3)) {
    for x in -ring..=ring {
        for y in -ring..=ring {
            let is_side = x.abs() == ring || y.abs() == ring;
            let step = if is_side || ring == 0 { 1 } else { 2 * ring };
            let mut z = -ring;
            while z <= ring {
                each(I64Vec3::new(x, y, z));
                z += step;
            }
        }
    }
}

/// The cubes of a lattice that meet a box.
#[derive(Clone, Copy)]
pub(in crate::field) struct Cubes {
    pub low: I64Vec3,
    /// Along each axis.
    pub count: I64Vec3,
}

impl Cubes {
    /// Those of an edge, at most so many and so many edges away; `None` of more.
    pub fn over(around: &Aabb, edge: f64, most: usize, farthest: f64) -> Option<Self> {
        let (low, high) = ((around.min / edge).floor(), (around.max / edge).floor());
        let count = high - low + 1.0;
        // Not a number is too many, too.
        let is_fine = count.element_product() <= most as f64 && low.abs().max(high.abs()).max_element() < farthest;
        is_fine.then(|| Self { low: low.as_i64vec3(), count: count.as_i64vec3() })
    }

    /// All, z the fastest.
    pub fn iter(self) -> impl Iterator<Item = I64Vec3> {
        let Self { low, count } = self;
        (0..count.element_product())
            .map(move |i| low + I64Vec3::new(i / (count.y * count.z), i / count.z % count.y, i % count.z))
    }
}

pub(in crate::field) fn mixed(bits: u64) -> u64 {
    let mut bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

/// A number from 0 to 1 of some bits.
pub(super) fn share(bits: u64) -> f64 {
    (bits >> 11) as f64 / ((1u64 << 53) - 1) as f64
}

/// Three numbers from 0 to 1 of some bits.
pub(in crate::field) fn shares(bits: u64) -> DVec3 {
    let part = |shift: u32| f64::from((bits >> shift) as u32 & 0x1f_ffff) / f64::from(0x1f_ffff_u32);
    DVec3::new(part(0), part(21), part(42))
}

/// A direction of length 1: one of the twelve to the middles of a cube's edges (Perlin, Improving noise, 2002), or of the eight
/// to its corners.
pub(super) fn direction(bits: u64) -> DVec3 {
    let [a, b, c] = [0, 1, 2].map(|bit| if bits >> (60 + bit) & 1 == 0 { 1.0 } else { -1.0 });
    const EDGE: f64 = std::f64::consts::FRAC_1_SQRT_2;
    const CORNER: f64 = 0.577_350_269_189_625_8;
    match (bits >> 32) % 5 {
        0 => DVec3::new(0.0, a, b) * EDGE,
        1 => DVec3::new(a, 0.0, b) * EDGE,
        2 => DVec3::new(a, b, 0.0) * EDGE,
        _ => DVec3::new(a, b, c) * CORNER,
    }
}
