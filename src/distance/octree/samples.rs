//! The feet found so far at points of the lattice of smallest cells.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::BuildError;
use crate::distance::Foot;
use crate::distance::nearest::{ClosestPoint, Watch};

/// Positions asked for in one call: those on either side of the same piece of surface, which share what is found out about
/// it, are far apart along the Morton curve. More shares hardly more, and leaves threads without work.
const BATCH: usize = 4096;

/// Cells whose points are listed together before they are sought among those of all.
const CELLS: usize = 256;

/// The order of points along a Morton curve: bits of x, y, z interleaved, x the highest.
fn morton(place: [u32; 3]) -> u64 {
    let spread = |v: u32| {
        let mut v = u64::from(v) & 0x1f_ffff;
        v = (v | v << 32) & 0x001f_0000_0000_ffff;
        v = (v | v << 16) & 0x001f_0000_ff00_00ff;
        v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
        v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
        (v | v << 2) & 0x1249_2492_4924_9249
    };
    spread(place[0]) << 2 | spread(place[1]) << 1 | spread(place[2])
}

fn unmorton(key: u64) -> [u32; 3] {
    let gather = |v: u64| {
        let mut v = v & 0x1249_2492_4924_9249;
        v = (v | v >> 2) & 0x10c3_0c30_c30c_30c3;
        v = (v | v >> 4) & 0x100f_00f0_0f00_f00f;
        v = (v | v >> 8) & 0x001f_0000_ff00_00ff;
        v = (v | v >> 16) & 0x001f_0000_0000_ffff;
        ((v | v >> 32) & 0x1f_ffff) as u32
    };
    [gather(key >> 2), gather(key >> 1), gather(key)]
}

/// Spreads Morton keys over a table; the keys are no one's choice, so nothing stronger is needed. Points that lie
/// together stay together, since they are looked up together: the lowest bits are the key's.
#[derive(Default)]
struct KeyHasher(u64);

/// Bits of a key that stay: 16 points are as many as a table compares at once.
const TOGETHER: u32 = 4;

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.write_u64(u64::from(*byte));
        }
    }

    fn write_u64(&mut self, key: u64) {
        let mix = |key: u64| {
            let mixed = key.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            mixed ^ mixed >> 32
        };
        // A table tells the points of one place apart by the highest bits.
        let (place, tag) = (mix(key >> TOGETHER) << TOGETHER, mix(key) & !(u64::MAX >> 8));
        self.0 = tag ^ place & (u64::MAX >> 8) ^ key & ((1 << TOGETHER) - 1);
    }
}

/// A table by Morton key.
type KeyMap = HashMap<u64, u32, BuildHasherDefault<KeyHasher>>;

/// Value and gradient at a point: what a foot leaves behind.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The signed distance.
    pub value: f64,
    /// The gradient.
    pub gradient: [f64; 3],
}

/// What a table takes for a key and a number, in bytes.
const BYTES_IN_TABLE: usize = 18;

/// What a sample takes, in bytes.
pub const BYTES_A_SAMPLE: usize = size_of::<Sample>() + 8 + BYTES_IN_TABLE;

/// Samples at lattice points, taken once each.
pub struct Samples<'a> {
    oracle: &'a dyn ClosestPoint,
    watch: &'a Watch<'a>,
    origin: DVec3,
    step: f64,
    index: KeyMap,
    taken: Vec<Sample>,
    /// The Morton key of each.
    keys: Vec<u64>,
}

impl<'a> Samples<'a> {
    /// No samples yet, on the lattice `origin + step·place`.
    pub fn new(oracle: &'a dyn ClosestPoint, watch: &'a Watch<'a>, origin: DVec3, step: f64) -> Self {
        Self { oracle, watch, origin, step, index: KeyMap::default(), taken: Vec::new(), keys: Vec::new() }
    }

    /// How many were taken.
    pub fn len(&self) -> usize {
        self.taken.len()
    }

    /// A place of the world on the lattice.
    pub fn in_smallest_cells(&self, position: DVec3) -> DVec3 {
        (position - self.origin) / self.step
    }

    /// Where a point of the lattice is in the world.
    pub fn position(&self, place: [u32; 3]) -> DVec3 {
        self.origin + DVec3::from(place.map(f64::from)) * self.step
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.taken.capacity() * size_of::<Sample>() + self.keys.capacity() * 8 + self.index.capacity() * BYTES_IN_TABLE
    }

    /// The sample at a point asked for before.
    pub fn get(&self, place: [u32; 3]) -> &Sample {
        // Points are requested before they are read, always.
        self.numbered(self.index[&morton(place)])
    }

    /// The number of the sample at a point, less than [`len`](Self::len), if it was asked for.
    pub fn number(&self, place: [u32; 3]) -> Option<u32> {
        self.index.get(&morton(place)).copied()
    }

    /// The sample of a number.
    pub fn numbered(&self, number: u32) -> &Sample {
        &self.taken[number as usize]
    }

    /// The place of the sample of a number.
    pub fn place(&self, number: u32) -> [u32; 3] {
        unmorton(self.keys[number as usize])
    }

    /// Every sample with its place; neighbours mostly follow one another.
    pub fn all(&self) -> impl IndexedParallelIterator<Item = ([u32; 3], &Sample)> {
        self.keys.par_iter().map(|key| unmorton(*key)).zip(&self.taken)
    }

    /// Takes the samples at the points that cells name, but those taken before. `progress` is told the share done.
    pub fn request<C: Sync, P: IntoIterator<Item = [u32; 3]>>(
        &mut self,
        cells: &[C],
        points: impl Fn(&C) -> P + Sync,
        progress: impl Fn(f64) + Sync,
    ) -> Result<(), BuildError> {
        let index = &self.index;
        let missing = |cells: &[C]| {
            let mut keys: Vec<u64> = cells.iter().flat_map(&points).map(morton).collect();
            // Cells that lie together share most of their points.
            keys.sort_unstable();
            keys.dedup();
            keys.retain(|key| !index.contains_key(key));
            keys
        };
        let mut keys = cells.par_chunks(CELLS).map(missing).collect::<Vec<_>>().concat();
        keys.par_sort_unstable();
        keys.dedup();
        let none = Sample { value: 0.0, gradient: [0.0; 3] };
        let start = self.taken.len();
        self.taken.resize(start + keys.len(), none);
        let (oracle, watch, origin, step) = (self.oracle, self.watch, self.origin, self.step);
        let (all, done) = (keys.len(), AtomicUsize::new(0));
        keys.par_chunks(BATCH).zip(self.taken[start..].par_chunks_mut(BATCH)).try_for_each(|(keys, samples)| {
            if watch.cancelled() {
                return Err(BuildError::Cancelled);
            }
            let position = |key: &u64| origin + DVec3::from(unmorton(*key).map(f64::from)) * step;
            let positions: Vec<DVec3> = keys.iter().map(position).collect();
            let empty = Foot { point: DVec3::ZERO, distance: 0.0, gradient: DVec3::ZERO, part: 0 };
            let mut feet = vec![empty; positions.len()];
            oracle.feet(&positions, &mut feet);
            for ((sample, foot), position) in samples.iter_mut().zip(&feet).zip(&positions) {
                if !(foot.distance.is_finite() && foot.gradient.is_finite()) {
                    return Err(BuildError::NotFinite { position: *position });
                }
                *sample = Sample { value: foot.distance, gradient: foot.gradient.to_array() };
            }
            let done = done.fetch_add(positions.len(), Ordering::Relaxed) + positions.len();
            progress(done as f64 / all as f64);
            Ok(())
        })?;
        self.keys.extend_from_slice(&keys);
        self.index.reserve(keys.len());
        for (i, key) in keys.iter().enumerate() {
            self.index.insert(*key, (start + i) as u32);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn morton_order_goes_both_ways() {
        for place in [[0, 0, 0], [1, 2, 3], [0x1f_ffff, 0, 0x10_0001], [77, 0x0f_0f0f, 5]] {
            assert_eq!(unmorton(morton(place)), place);
        }
        assert_eq!(morton([1, 0, 0]), 4);
    }
}
