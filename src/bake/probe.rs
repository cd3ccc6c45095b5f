//! One frame baked in memory, to tell what all of them will take.

use std::time::Instant;

use super::frame::compute_frame;
use super::output::Frame;
use super::{Bytes, Error, Estimate, Interrupt, Output};
use crate::shot::Prepared;

/// The most voxels of a frame that is baked for an estimate; above, a coarser one stands in for it. Some seconds' work.
const MOST_VOXELS: f64 = 6e6;

/// What one frame takes: measured, or scaled up from a coarser one.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// The frame.
    pub frame: i64,
    /// The edge of the voxels it was baked with, world units.
    pub voxel_size: f64,
    /// How many times coarser than asked for; 1 where it is the frame itself.
    pub coarser: f64,
    /// Active voxels of the level set.
    pub active_voxels: f64,
    /// Seconds to compute it.
    pub compute_seconds: f64,
    /// Seconds to make its grids and encode them; the disk comes on top.
    pub encode_seconds: f64,
    /// Size of the file.
    pub file: Bytes,
}

impl Probe {
    /// How many times coarser a frame of that estimate is to be baked.
    pub fn scale(estimate: &Estimate, limit: Bytes) -> f64 {
        let by_memory = (estimate.memory.0 as f64 / limit.0.max(1) as f64).sqrt();
        (estimate.voxels / MOST_VOXELS).sqrt().max(by_memory).max(1.0)
    }

    /// Seconds from frame to frame: one is computed while one is written.
    pub fn frame_seconds(&self) -> f64 {
        self.compute_seconds.max(self.encode_seconds)
    }
}

/// Bakes a frame in memory. `prepared` is the scene with voxels `coarser` times as large as asked for; time, voxels and
/// bytes grow with the surface, its square, and of an inside with its cube.
///
/// # Errors
/// Those of the frame.
pub fn probe(
    prepared: &Prepared,
    frame: i64,
    coarser: f64,
    output: &Output,
    interrupt: &Interrupt,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Probe, Error> {
    let start = Instant::now();
    let computed = compute_frame(prepared, frame, 1, output.max_memory, interrupt, progress)?;
    let compute_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let encoded = output.format.encode(&Frame { prepared, number: frame, computed: &computed, output })?;
    let bytes: usize = encoded.pieces.iter().map(Vec::len).sum();
    let encode_seconds = start.elapsed().as_secs_f64();
    // The surface grows with the square, what is behind it with the cube.
    let band = computed.band.active_voxels() as f64;
    let behind = computed.insides.as_ref().map_or(0, |insides| insides.behind(&computed.band)) as f64;
    let growth = coarser * coarser * (band + behind * coarser) / (band + behind).max(1.0);
    Ok(Probe {
        frame,
        voxel_size: prepared.lattice.voxel_size.get(),
        coarser,
        active_voxels: band * coarser * coarser,
        compute_seconds: compute_seconds * growth,
        encode_seconds: encode_seconds * growth,
        file: Bytes((bytes as f64 * growth) as u64),
    })
}
