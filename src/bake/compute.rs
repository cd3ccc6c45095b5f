//! One frame in memory: the band, and the colour at each voxel's closest surface point.

use std::fmt;

use rayon::prelude::*;

use crate::attribute::{Colour, ColourSampler, LinearRgb};
use crate::distance::band::{self, MeasuredBlock, Report, Settings};
use crate::distance::without::{Keep, measure_kept};
use crate::field::{BATCH, Field};
use crate::grid::{BLOCK_VOXELS, Band, BlockMask, Channel, mask};

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
    /// Of the active voxels, in their order.
    active: Box<[LinearRgb]>,
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
        let mut sampled = [[0.0; 3]; BATCH];
        move |block: &MeasuredBlock| sample(&mut *sampler, block, &mut sampled)
    };
    let measured = measure_kept(field, settings, keep, new_visitor).map_err(ComputeError::Distance)?;
    if let Some(wrong) = measured.visits.iter().find_map(|block| block.wrong.clone()) {
        return Err(wrong);
    }
    let background = mean(&measured.visits, measured.band.active_voxels());
    let bright_voxels = measured.visits.iter().map(|block| block.bright_voxels).sum();
    let blocks = measured.visits.into_par_iter().zip(&measured.band.active);
    let values = blocks.map(|(block, active)| spread(&block.active, active, background)).collect();
    let channel = Channel { name: name.into(), values, background };
    Ok(Computed { band: measured.band, colour: Some(channel), report: measured.report, bright_voxels })
}

/// The colours of a block's active voxels at their places, the background at all others.
fn spread(colours: &[LinearRgb], active: &BlockMask, background: LinearRgb) -> [LinearRgb; BLOCK_VOXELS] {
    let mut values = [background; BLOCK_VOXELS];
    for (at, colour) in mask::places(active).zip(colours) {
        values[at] = *colour;
    }
    values
}

/// The colours at a block's feet: constant along the surface's normals, so that a mesh of the level set which samples
/// them trilinearly meets the surface's own colour. Active voxels alone are sampled, one after the other: there is no
/// foot at others, and they are most of a block.
fn sample(sampler: &mut dyn ColourSampler, block: &MeasuredBlock, sampled: &mut [LinearRgb; BATCH]) -> BlockColours {
    let mut feet = block.feet();
    feet.len = 0;
    for at in mask::places(block.active) {
        feet.push(feet.offset(at));
    }
    sampler.enter(&block.region);
    sampler.sample(&feet, sampled);
    sampler.leave();
    let sampled = &sampled[..feet.len];
    let survey = survey(sampled.as_flattened());
    let mut colours = BlockColours { active: sampled.into(), sum: survey.sum, bright_voxels: 0, wrong: None };
    if survey.bright {
        let is_bright = |colour: &&LinearRgb| colour.iter().any(|&channel| channel > 1.0);
        colours.bright_voxels = sampled.iter().filter(is_bright).count() as u64;
    }
    if survey.wrong
        && let Some(at) = sampled.iter().position(|colour| colour.iter().any(|&channel| is_wrong(channel)))
    {
        colours.wrong = Some(ComputeError::Colour { position: feet.position(at).to_array(), value: sampled[at] });
    }
    colours
}

/// Negative, infinite or not a number.
#[inline(always)]
fn is_wrong(channel: f32) -> bool {
    !(0.0..f32::INFINITY).contains(&channel)
}

/// What there is to know about a block's colours.
struct Survey {
    sum: [f64; 3],
    /// Some channel is above 1.
    bright: bool,
    /// Some channel is wrong.
    wrong: bool,
}

/// Looks at red, green, blue, red, … The sums are of every eighth colour, then of these, at any vector width.
#[multiversion::multiversion(targets = "simd")]
fn survey(channels: &[f32]) -> Survey {
    const ROW: usize = 8 * 3;
    let (mut sums, mut bright, mut wrong) = ([0.0; ROW], [false; ROW], [false; ROW]);
    let (rows, rest) = channels.as_chunks::<ROW>();
    for row in rows {
        for i in 0..ROW {
            sums[i] += f64::from(row[i]);
            bright[i] |= row[i] > 1.0;
            wrong[i] |= is_wrong(row[i]);
        }
    }
    for (i, &channel) in rest.iter().enumerate() {
        sums[i] += f64::from(channel);
        bright[i] |= channel > 1.0;
        wrong[i] |= is_wrong(channel);
    }
    let sum = std::array::from_fn(|channel| sums.iter().skip(channel).step_by(3).sum());
    Survey { sum, bright: bright.contains(&true), wrong: wrong.contains(&true) }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_survey_sums_and_notices_in_every_place() {
        for len in [0, 1, 7, 8, 9, 100, BATCH] {
            let colours: Vec<LinearRgb> =
                (0..len).map(|i| [0.001, 0.002, 0.0005].map(|part| part * i as f32)).collect();
            let plain = survey(colours.as_flattened());
            assert!(!plain.wrong && plain.bright == (len == BATCH));
            for channel in 0..3 {
                let exact: f64 = colours.iter().map(|colour| f64::from(colour[channel])).sum();
                assert!((plain.sum[channel] - exact).abs() <= 1e-12 * exact);
            }
            for place in 0..3 * len {
                for (value, wrong) in [(-1e-9, true), (f32::NAN, true), (f32::INFINITY, true), (1.5, false)] {
                    let mut changed = colours.clone();
                    changed.as_flattened_mut()[place] = value;
                    let noticed = survey(changed.as_flattened());
                    assert_eq!(noticed.wrong, wrong, "{value} at {place} of {len}");
                    assert!(noticed.bright || value <= 1.0 || value.is_nan());
                }
            }
        }
    }
}
