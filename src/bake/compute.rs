//! One frame in memory: the band, and the colour at each voxel's closest surface point.

use std::fmt;

use crate::attribute::{Colour, ColourSampler, LinearRgb};
use crate::distance::band::{self, MeasuredBlock, Report, Settings};
use crate::distance::without::{Keep, measure_kept};
use crate::field::{BATCH, Field};
use crate::grid::{BLOCK_VOXELS, Band, Channel, is_active};

/// A frame's grids, and what to tell about them.
#[derive(Clone, Debug)]
pub struct Computed {
    /// The level set.
    pub band: Band,
    /// Scene-linear Rec.709 colours on the level set's active voxels, where the scene has colours.
    pub colour: Option<Channel<LinearRgb>>,
    /// Counts and warnings of the measurement.
    pub report: Report,
    /// Active voxels with a colour channel above 1.
    pub bright_voxels: u64,
}

/// Why a frame could not be computed.
#[derive(Clone, Debug, PartialEq)]
pub enum ComputeError {
    /// The distances.
    Distance(band::Error),
    /// A colour is negative, infinite or not a number at a world position.
    Colour {
        /// World units.
        position: [f64; 3],
        /// The colour.
        value: LinearRgb,
    },
}

impl fmt::Display for ComputeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Distance(error) => error.fmt(f),
            Self::Colour { position: [x, y, z], value: [r, g, b] } => write!(
                f,
                "the colour at ({x:.6}, {y:.6}, {z:.6}) is ({r}, {g}, {b}): a channel is negative, infinite or not a number"
            ),
        }
    }
}

impl std::error::Error for ComputeError {}

/// The colours of one block, and what was noticed in it.
struct BlockColours {
    values: [LinearRgb; BLOCK_VOXELS],
    sum: [f64; 3],
    bright_voxels: u64,
    wrong: Option<ComputeError>,
}

/// Measures what is kept of a field and samples a colour at the feet.
pub fn compute(
    field: &dyn Field,
    colour: Option<(&dyn Colour, &str)>,
    settings: &Settings,
    keep: Keep,
) -> Result<Computed, ComputeError> {
    let Some((colour, name)) = colour else {
        let measured =
            measure_kept(field, settings, keep, || |_: &MeasuredBlock| ()).map_err(ComputeError::Distance)?;
        return Ok(Computed { band: measured.band, colour: None, report: measured.report, bright_voxels: 0 });
    };
    let new_visitor = || {
        let mut sampler = colour.sampler();
        move |block: &MeasuredBlock| sample(&mut *sampler, block)
    };
    let measured = measure_kept(field, settings, keep, new_visitor).map_err(ComputeError::Distance)?;
    if let Some(wrong) = measured.visits.iter().find_map(|block| block.wrong.clone()) {
        return Err(wrong);
    }
    let background = mean(&measured.visits, measured.band.active_voxels());
    let bright_voxels = measured.visits.iter().map(|block| block.bright_voxels).sum();
    let mut values: Vec<_> = measured.visits.into_iter().map(|block| block.values).collect();
    for (values, active) in values.iter_mut().zip(&measured.band.active) {
        for (at, value) in values.iter_mut().enumerate() {
            if !is_active(active, at) {
                *value = background;
            }
        }
    }
    let channel = Channel { name: name.into(), values, background };
    Ok(Computed { band: measured.band, colour: Some(channel), report: measured.report, bright_voxels })
}

/// The colours at a block's feet: constant along the surface's normals, so that a mesh of the level set which samples
/// them trilinearly meets the surface's own colour.
fn sample(sampler: &mut dyn ColourSampler, block: &MeasuredBlock) -> BlockColours {
    let mut colours = BlockColours { values: [[0.0; 3]; BATCH], sum: [0.0; 3], bright_voxels: 0, wrong: None };
    let feet = block.feet();
    sampler.enter(&block.region);
    sampler.sample(&feet, &mut colours.values);
    sampler.leave();
    for (at, value) in colours.values.iter().enumerate() {
        if !is_active(block.active, at) {
            continue;
        }
        // A NaN fails this comparison too.
        if !value.iter().all(|&channel| channel >= 0.0 && channel.is_finite()) && colours.wrong.is_none() {
            let position = feet.position(at).to_array();
            colours.wrong = Some(ComputeError::Colour { position, value: *value });
        }
        colours.bright_voxels += u64::from(value.iter().any(|&channel| channel > 1.0));
        for (sum, &channel) in colours.sum.iter_mut().zip(value) {
            *sum += f64::from(channel);
        }
    }
    colours
}

/// The mean colour, summed block after block so that it does not depend on threads.
fn mean(blocks: &[BlockColours], active_voxels: u64) -> LinearRgb {
    let mut sum = [0.0; 3];
    for block in blocks {
        for (sum, part) in sum.iter_mut().zip(block.sum) {
            *sum += part;
        }
    }
    sum.map(|sum| (sum / active_voxels.max(1) as f64) as f32)
}
