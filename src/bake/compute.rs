//! One frame in memory: the band, and the attributes at each voxel's closest surface point.

use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};

use super::Bytes;
use super::asked::{Attributes, ComputeError, Interior};
use super::inside::{self, Inside, Insides};
use super::range::Range;
use super::survey::{Survey, survey};
use super::velocity::{self, BlockVelocities, Velocities};
use crate::attribute::{Attribute, LinearRgb, Sampler};
use crate::distance::band::{MeasuredBlock, Report, Settings};
use crate::distance::method::{AsChosen, Choice, USUAL};
use crate::distance::nearest::Watch;
use crate::distance::step::soften;
use crate::distance::without::{Keep, measure_kept};
use crate::field::{Aabb, BATCH, Field, Points};
use crate::grid::{Band, Channel, mask};

/// A frame's grids, and what to tell about them.
#[derive(Clone, Debug)]
pub struct Computed {
    /// The level set.
    pub band: Band,
    /// Scene-linear Rec.709 colours on the level set's active voxels, where the scene has colours.
    pub colour: Option<Channel<LinearRgb>>,
    /// The scalars on the same voxels.
    pub scalars: Vec<Channel<f32>>,
    /// The velocities, where the scene asks for them.
    pub velocities: Option<Velocities>,
    /// Attributes and density through the inside, where the scene asks for them.
    pub insides: Option<Insides>,
    /// Counts and warnings of the measurement.
    pub report: Report,
    /// Active voxels with a colour channel above 1.
    pub bright_voxels: u64,
    /// The ranges of all but the velocities.
    pub ranges: Ranges,
}

/// The least and the greatest active values of a frame.
#[derive(Clone, Debug)]
pub struct Ranges {
    /// Of the distances, positive inside.
    pub distances: Range<1>,
    /// Of the colours.
    pub colours: Range<3>,
    /// Of each scalar.
    pub scalars: Vec<Range<1>>,
}

impl Ranges {
    /// Where nothing is active, and no scalar.
    pub(super) fn none() -> Self {
        Self { distances: Range::none(), colours: Range::none(), scalars: Vec::new() }
    }
}

/// What one block has of all attributes.
struct BlockAttributes {
    /// The range of the distances. Found here, while they are in the caches, as those of the attributes.
    distances: Range<1>,
    colour: Option<Sampled<3>>,
    scalars: Vec<Sampled<1>>,
    velocities: Option<BlockVelocities>,
}

/// What one block has of an attribute, and what was noticed in it.
struct Sampled<const N: usize> {
    /// Of the active voxels, in their order.
    active: Box<[[f32; N]]>,
    sum: [f64; N],
    range: Range<N>,
    bright_voxels: u64,
    /// Where a number is out of range, and what it is.
    wrong: Option<([f64; 3], [f32; N])>,
}

/// What the distances of a band are.
#[derive(Clone, Copy, Debug)]
pub struct Distances {
    /// What measures them.
    pub choice: Choice,
    /// s of the smooth step in the place of their sign, in voxels.
    pub step: Option<f64>,
    /// The most memory that building a tree for them may hold.
    pub limit: Bytes,
}

/// Measures what is kept of a field, and samples attributes at the closest points.
pub fn compute(
    field: &dyn Field,
    attributes: Attributes<'_>,
    settings: &Settings,
    keep: Keep,
    distances: Distances,
) -> Result<Computed, ComputeError> {
    let new_visitor = || {
        let mut colour = attributes.colour.map(|(_, colour)| Visitor::new(colour, 0.0));
        let all = attributes.scalars.iter();
        let mut scalars: Vec<Visitor<1>> = all.map(|(_, scalar)| Visitor::new(scalar.as_ref(), f32::MIN)).collect();
        let mut velocity =
            attributes.movement.map(|movement| velocity::Visitor::new(movement, settings.lattice.voxel_size.get()));
        let mut feet = Points::new(DVec3::ZERO);
        move |block: &MeasuredBlock| {
            let distances = Range::of_active(block.distances, block.active);
            if colour.is_none() && scalars.is_empty() && velocity.is_none() {
                return BlockAttributes { distances, colour: None, scalars: Vec::new(), velocities: None };
            }
            // An attribute taken at the feet is constant along the surface's normals, so that a mesh of the level set which
            // samples it trilinearly meets the surface's own.
            block.feet_into(&mut feet);
            let velocities = velocity.as_mut().map(|velocity| velocity.visit(block, &feet));
            if attributes.interior.is_some() {
                sink(&mut feet, block, settings.half_width);
            }
            let region = around(&feet, block);
            BlockAttributes {
                distances,
                colour: colour.as_mut().map(|colour| colour.sample(&feet, &region, block)),
                scalars: scalars.iter_mut().map(|scalar| scalar.sample(&feet, &region, block)).collect(),
                velocities,
            }
        }
    };
    let measured = measure_kept(field, settings, keep, new_visitor).map_err(ComputeError::Distance)?;
    let mut colours = Vec::new();
    let mut scalars: Vec<Vec<Sampled<1>>> = attributes.scalars.iter().map(|_| Vec::new()).collect();
    let mut velocities = Vec::new();
    let mut ranges = Ranges::none();
    for block in measured.visits {
        ranges.distances = ranges.distances.joined(block.distances);
        colours.extend(block.colour);
        velocities.extend(block.velocities);
        scalars.iter_mut().zip(block.scalars).for_each(|(all, one)| all.push(one));
    }
    let mut band = measured.band;
    let Distances { choice, step, limit } = distances;
    if choice.method != USUAL || step.is_some() {
        let watch = Watch { cancel: settings.cancel, progress: &|_| {} };
        let as_chosen = AsChosen { choice, memory_limit: usize::try_from(limit.0).unwrap_or(usize::MAX) };
        choice.method().measure_band(field, &mut band, as_chosen, &watch).map_err(ComputeError::of_method)?;
        if let Some(s) = step {
            soften(&mut band, s);
        }
        let of_block = |(distances, active)| Range::of_active(distances, active);
        ranges.distances = band.distances.iter().zip(&band.active).map(of_block).fold(Range::none(), Range::joined);
    }
    let bright_voxels = colours.iter().map(|block| block.bright_voxels).sum();
    let mut colour = None;
    if let Some((name, _)) = attributes.colour {
        if let Some((position, value)) = colours.iter().find_map(|block| block.wrong) {
            return Err(ComputeError::Colour { position, value });
        }
        ranges.colours = joined(&colours);
        colour = Some(channel(name, colours, &band));
    }
    let mut channels = Vec::with_capacity(scalars.len());
    for ((name, _), blocks) in attributes.scalars.iter().zip(scalars) {
        if let Some((position, [value])) = blocks.iter().find_map(|block| block.wrong) {
            return Err(ComputeError::Scalar { name: name.clone(), position, value });
        }
        ranges.scalars.push(joined(&blocks));
        channels.push(channel(name, blocks, &band));
    }
    let velocities = attributes.movement.map(|movement| velocity::grid(&band, velocities, movement));
    let mut insides = None;
    if let Some(interior) = attributes.interior {
        insides = Some(filled(&band, colour.as_ref(), &channels, attributes, interior, settings.cancel)?);
    }
    Ok(Computed {
        band,
        colour,
        scalars: channels.into_iter().map(Channel::from).collect(),
        velocities,
        insides,
        report: measured.report,
        bright_voxels,
        ranges,
    })
}

/// Moves the places where a block's attributes are taken from the surface, where the band's outer half has them, to the
/// voxels themselves as they lie deeper: at the band's inner end they are what the inside behind it has.
fn sink(feet: &mut Points, block: &MeasuredBlock, half_width: f32) {
    let voxel = block.lattice.voxel_size.get() as f32;
    let offsets = Points::offsets_in_block(&block.lattice);
    for (i, at) in mask::places(block.active).enumerate() {
        let depth = ((block.distances[at] / voxel - 1.0) / (half_width - 1.0)).clamp(0.0, 1.0);
        if depth > 0.0 {
            let place = Vec3::new(offsets[at >> 6], offsets[at >> 3 & 7], offsets[at & 7]);
            let between = feet.offset(i) + depth * depth * (3.0 - 2.0 * depth) * (place - feet.offset(i));
            [feet.x[i], feet.y[i], feet.z[i]] = between.to_array();
        }
    }
}

/// The inside of a band whose attributes are known.
fn filled(
    band: &Band,
    colour: Option<&Channel<LinearRgb>>,
    scalars: &[Channel<[f32; 1]>],
    attributes: Attributes<'_>,
    interior: Interior,
    cancel: &AtomicBool,
) -> Result<Insides, ComputeError> {
    let bounds = inside::Bounds { bytes: interior.limit.0, cancel };
    let mut all = Insides { colour: None, scalars: Vec::new(), density: None };
    if let (Some((_, attribute)), Some(channel)) = (attributes.colour, colour) {
        let found = inside::through(band, channel, attribute, 0.0, bounds);
        all.colour =
            Some(found.map_err(|trouble| trouble.told(|position, value| ComputeError::Colour { position, value }))?);
    }
    let mut of_density = None;
    for ((name, attribute), channel) in attributes.scalars.iter().zip(scalars) {
        let is_density = interior.density && name == inside::DENSITY;
        let found = inside::through(band, channel, attribute.as_ref(), f32::MIN, bounds);
        let found: Inside<f32> = found
            .map_err(|trouble| {
                trouble.told(|position, [value]| ComputeError::Scalar { name: name.clone(), position, value })
            })?
            .into();
        if is_density {
            of_density = Some(found);
        } else {
            all.scalars.push(found);
        }
    }
    if interior.density {
        all.density = Some(inside::density(band, of_density.as_ref())?);
    }
    Ok(all)
}

fn joined<const N: usize>(blocks: &[Sampled<N>]) -> Range<N> {
    blocks.iter().fold(Range::none(), |all, block| all.joined(block.range))
}

/// An attribute's channel over a band: its values on the active voxels, their mean everywhere else, so that samples
/// across the band's border are not drawn to any other value.
fn channel<const N: usize>(name: &str, blocks: Vec<Sampled<N>>, band: &Band) -> Channel<[f32; N]> {
    let background = mean(&blocks, band.active_voxels());
    Channel { name: name.into(), values: blocks.into_iter().map(|block| block.active).collect(), background }
}

/// A box around a block's feet. They lie on a piece of surface, which fills little of the block and the room around it: over
/// the box of that piece far less is left to choose between.
fn around(feet: &Points, block: &MeasuredBlock) -> Aabb {
    // Where a box is carried into another space, points on its faces may come out a rounding error outside.
    const MARGIN_VOXELS: f64 = 0.01;
    let margin = MARGIN_VOXELS * block.lattice.voxel_size.get();
    let around = feet.bounding_box().and_then(|aabb| aabb.grown(margin).intersection(block.region));
    around.unwrap_or(block.region)
}

/// Samples one attribute in one block after the other.
struct Visitor<'a, const N: usize> {
    sampler: Box<dyn Sampler<N> + 'a>,
    /// The region of the node entered last.
    node: Option<Aabb>,
    /// The least number that is right; the greatest is finite.
    least: f32,
    sampled: Box<[[f32; N]; BATCH]>,
}

impl<'a, const N: usize> Visitor<'a, N> {
    fn new(attribute: &'a dyn Attribute<N>, least: f32) -> Self {
        Self { sampler: attribute.sampler(), node: None, least, sampled: Box::new([[0.0; N]; BATCH]) }
    }

    /// Of all that a block's feet lie in, `region` is what they fill.
    fn sample(&mut self, feet: &Points, region: &Aabb, block: &MeasuredBlock) -> Sampled<N> {
        if self.node != Some(block.node_region) {
            if self.node.is_some() {
                self.sampler.leave();
            }
            self.node = Some(block.node_region);
            self.sampler.enter(&block.node_region);
        }
        self.sampler.enter(region);
        self.sampler.sample(feet, &mut self.sampled);
        self.sampler.leave();
        let active = &self.sampled[..feet.len];
        let survey = survey(active);
        let Survey { sum, range } = survey;
        let mut sampled = Sampled { active: active.into(), sum, range, bright_voxels: 0, wrong: None };
        if survey.is_bright() {
            sampled.bright_voxels = active.iter().filter(|value| value.iter().any(|&part| part > 1.0)).count() as u64;
        }
        let wrong = survey.first_wrong(active, self.least);
        sampled.wrong = wrong.map(|at| (feet.position(at).to_array(), active[at]));
        sampled
    }
}

/// The mean value, summed block after block so that it does not depend on threads.
fn mean<const N: usize>(blocks: &[Sampled<N>], active_voxels: u64) -> [f32; N] {
    let mut sum = [0.0; N];
    for block in blocks {
        for (sum, part) in sum.iter_mut().zip(block.sum) {
            *sum += part;
        }
    }
    sum.map(|sum| (sum / active_voxels.max(1) as f64) as f32)
}
