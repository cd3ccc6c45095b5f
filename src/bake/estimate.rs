//! What frames will take, estimated before anything is allocated.

use super::asked::Attributes;
use super::{Bytes, Error, inside, velocity};
use crate::attribute::LinearRgb;
use crate::distance::descent::Scope;
use crate::distance::extent::{BandBoxes, Effort};
use crate::grid::BLOCK_VOXELS;
use crate::shot::{FrameContent, Prepared};

/// What a frame will take, estimated before anything is allocated.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Active voxels.
    pub voxels: f64,
    /// Leaf blocks.
    pub blocks: f64,
    /// Memory at the job's peak.
    pub memory: Bytes,
    /// Size of the file without compression.
    pub file: Bytes,
}

/// What the program takes whatever it bakes: itself, OpenVDB, stacks, a chunk of blocks in flight.
const BASE_BYTES: f64 = 120e6;

/// What a voxel of the band takes more while velocities are carried outward, and what one takes that they come to.
const VELOCITY_BYTES: f64 = 70.0;
const CARRIED_BYTES: f64 = 28.0;

/// How many of so many frames are in memory at once while they are baked: one is computed while one is written.
pub fn in_flight(frames: usize) -> usize {
    frames.clamp(1, 2)
}

/// Estimates one frame of a job that has so many in flight.
pub fn estimate(prepared: &Prepared, content: &FrameContent, in_flight: usize) -> Estimate {
    estimate_by(prepared, content, in_flight, Effort::Careful)
}

fn estimate_by(prepared: &Prepared, content: &FrameContent, in_flight: usize, effort: Effort) -> Estimate {
    let scope = Scope { lattice: prepared.lattice, half_width: prepared.half_width, region: content.region };
    let boxes = BandBoxes::find(&*content.field, &scope, effort);
    let found = boxes.estimate(&scope);
    let velocity = if content.movement.is_some() { 3 } else { 0 };
    let numbers = if content.colour.is_some() { 3 } else { 0 } + content.scalars.len() + velocity;
    let mut memory = BASE_BYTES + prepared.memory_estimate() as f64 + found.memory(numbers, in_flight);
    let mut file = found.file(numbers);
    if let Some(movement) = &content.movement {
        // Velocities reach further than the band, by as much as the surface moves.
        let faces = found.voxels / (2.0 * f64::from(scope.half_width));
        let carried = faces * velocity::carried_a_face(&*content.field, movement, &scope, &boxes);
        memory += found.voxels * VELOCITY_BYTES + carried * CARRIED_BYTES;
        file += carried * 12.0;
    }
    let model = prepared.model();
    // One frame at a time is measured.
    memory += found.blocks * BLOCK_VOXELS as f64 * model.written_distance().method().bytes_a_node() as f64;
    let output = &model.output;
    // Colours in other primaries are there twice while a frame is encoded.
    let is_converted = content.colour.is_some() && output.other_primaries().is_some();
    if is_converted {
        memory += found.voxels * size_of::<LinearRgb>() as f64 * in_flight as f64;
    }
    if output.fills_inside() {
        let colour = content.colour.as_deref().map(|colour| (output.colour_name.as_str(), colour));
        let attributes = Attributes { colour, scalars: &content.scalars, movement: None, interior: None };
        let inside = inside::estimate(&*content.field, content.region, &attributes, &scope.lattice);
        memory += inside * (1 + in_flight * if is_converted { 2 } else { 1 }) as f64;
        file += inside;
    }
    let bytes = |value: f64| Bytes(value.min(u64::MAX as f64) as u64);
    Estimate { voxels: found.voxels, blocks: found.blocks, memory: bytes(memory), file: bytes(file) }
}

/// Refuses frames whose estimate is over the limit. Of a frame that is far from it a quick one says enough.
pub fn check_memory(prepared: &Prepared, content: &FrameContent, in_flight: usize, limit: Bytes) -> Result<(), Error> {
    if estimate_by(prepared, content, in_flight, Effort::Quick).memory.0 <= limit.0 / 2 {
        return Ok(());
    }
    let estimate = estimate(prepared, content, in_flight);
    if estimate.memory > limit {
        return Err(Error::Memory { needed: estimate.memory, limit, voxels: estimate.voxels });
    }
    Ok(())
}
