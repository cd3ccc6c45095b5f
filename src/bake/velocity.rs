//! The grid of velocities: on the band, and as far outside of it as the surface moves in a frame.
//!
//! A renderer that blurs motion asks for the velocity where the surface will have been or come to within the frame. So
//! each surface point's velocity is carried along the point's own way, forward and back as far as it moves in one frame,
//! over a width of the band's.

use std::cmp::Ordering;

use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::distance::band::MeasuredBlock;
use crate::distance::descent::Scope;
use crate::distance::extent::BandBoxes;
use crate::field::{BATCH, Field, Gradients, Points};
use crate::grid::{
    BLOCK_VOXELS, Band, BlockMask, Channel, FACES, block_order, block_origin, is_active, mask, voxel_offset,
};
use crate::morph::{Meter, Movement};

/// Velocities over blocks of their own.
#[derive(Clone, Debug)]
pub struct Velocities {
    /// The blocks' least corners, sorted as a band's.
    pub origins: Vec<IVec3>,
    /// Voxels that have a velocity: all active ones of the band, and more outside.
    pub active: Vec<BlockMask>,
    /// World units a second; 0 elsewhere.
    pub channel: Channel<[f32; 3]>,
    /// Voxels of the band whose velocity was held to a greatest speed.
    pub held_voxels: u64,
    /// That of the whole.
    pub max_speed: f64,
    /// That beside the objects' own motion.
    pub max_change: f64,
}

/// The velocities of one block's active voxels, in their order.
pub(super) struct BlockVelocities {
    velocities: Box<[[f32; 3]]>,
    /// From the block's middle to the voxels' closest surface points.
    feet: Box<[Vec3]>,
    held: u64,
}

/// Measures the velocities of one block after the other.
pub(super) struct Visitor<'a> {
    meter: Meter<'a>,
    outward: Vec<Vec3>,
    out: Box<[[f32; 3]; BATCH]>,
    held: Box<[bool; BATCH]>,
}

impl<'a> Visitor<'a> {
    pub(super) fn new(movement: &'a Movement, voxel: f64) -> Self {
        let (out, held) = (Box::new([[0.0; 3]; BATCH]), Box::new([false; BATCH]));
        Self { meter: movement.meter(voxel), outward: Vec::with_capacity(BATCH), out, held }
    }

    /// `feet` are those of the block's active voxels, one after the other.
    pub(super) fn visit(&mut self, block: &MeasuredBlock, feet: &Points) -> BlockVelocities {
        let [x, y, z] = block.normals;
        self.outward.clear();
        self.outward.extend(mask::places(block.active).map(|at| -Vec3::new(x[at], y[at], z[at])));
        self.meter.velocities(feet, &self.outward, &mut self.out, &mut self.held);
        BlockVelocities {
            velocities: self.out[..feet.len].into(),
            feet: (0..feet.len).map(|i| feet.offset(i)).collect(),
            held: self.held[..feet.len].iter().filter(|held| **held).count() as u64,
        }
    }
}

/// A surface point's velocity, on its way outward.
#[derive(Clone, Copy)]
struct Carried {
    voxel: IVec3,
    foot: DVec3,
    velocity: [f32; 3],
    /// From the foot to the voxel, world units.
    distance: f64,
}

impl Carried {
    /// By voxels; of one voxel, the nearest foot first.
    fn order(&self, other: &Self) -> Ordering {
        let by_voxel = self.voxel.to_array().cmp(&other.voxel.to_array());
        let (one, two) = (self.foot.to_array(), other.foot.to_array());
        let by_foot = || one.iter().zip(&two).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
        let feet = || by_foot().unwrap_or(Ordering::Equal);
        by_voxel.then_with(|| self.distance.total_cmp(&other.distance)).then_with(feet)
    }
}

type Block = (BlockMask, Box<[[f32; 3]; BLOCK_VOXELS]>);

/// The grid over a band, whose blocks' velocities these are.
pub(super) fn grid(band: &Band, blocks: Vec<BlockVelocities>, movement: &Movement) -> Velocities {
    let held_voxels = blocks.iter().map(|block| block.held).sum();
    let mut front = Vec::new();
    // Asked, and sorted in the end: its order cannot reach a result.
    let mut all: FxHashMap<IVec3, Block> = FxHashMap::with_capacity_and_hasher(blocks.len(), Default::default());
    for (i, block) in blocks.into_iter().enumerate() {
        let (origin, active) = (band.origins[i], band.active[i]);
        let middle = Points::middle_of_block(origin, &band.lattice);
        let centres = Points::of_block(origin, &band.lattice);
        let mut values = Box::new([[0.0; 3]; BLOCK_VOXELS]);
        for ((at, velocity), foot) in mask::places(&active).zip(&block.velocities).zip(&block.feet) {
            values[at] = *velocity;
            if band.distances[i][at] < 0.0 {
                let local = IVec3::new(at as i32 >> 6, at as i32 >> 3 & 7, at as i32 & 7);
                let foot = middle + foot.as_dvec3();
                let distance = foot.distance(centres.position(at));
                front.push(Carried { voxel: origin + local, foot, velocity: *velocity, distance });
            }
        }
        all.insert(origin, (active, values));
    }
    while !front.is_empty() {
        let mut next: Vec<Carried> =
            front.par_iter().flat_map_iter(|carried| outward(*carried, band, movement, &all)).collect();
        next.par_sort_unstable_by(Carried::order);
        next.dedup_by_key(|carried| carried.voxel);
        for carried in &next {
            let origin = block_origin(carried.voxel);
            let (active, values) = all.entry(origin).or_insert_with(|| ([0; 8], Box::new([[0.0; 3]; BLOCK_VOXELS])));
            let at = voxel_offset(carried.voxel);
            active[at >> 6] |= 1 << (at & 63);
            values[at] = carried.velocity;
        }
        front = next;
    }
    let mut sorted: Vec<(IVec3, Block)> = all.into_iter().collect();
    sorted.par_sort_unstable_by_key(|(origin, _)| block_order(*origin));
    let origins = sorted.iter().map(|(origin, _)| *origin).collect();
    let active: Vec<BlockMask> = sorted.iter().map(|(_, (active, _))| *active).collect();
    let channel = Channel::of_blocks("vel", &active, sorted.into_iter().map(|(_, (_, values))| *values), [0.0; 3]);
    Velocities { origins, active, channel, held_voxels, max_speed: movement.max_speed, max_change: movement.max_change }
}

/// How many voxels outside of the band the velocities are carried to for each voxel face of the surface, about, from the
/// places of the surface beside some of the band's boxes.
pub(super) fn carried_a_face(field: &dyn Field, movement: &Movement, scope: &Scope, boxes: &BandBoxes) -> f64 {
    let origin = scope.region.centre();
    let (mut points, mut at) = (Points::new(origin), Gradients::new());
    boxes.middles(BATCH).for_each(|middle| points.push((middle - origin).as_vec3()));
    field.evaluator().gradients(&points, &mut at);
    let (mut feet, mut outward) = (Points::new(origin), Vec::with_capacity(BATCH));
    for i in 0..points.len {
        let gradient = at.gradient(i);
        let step = gradient * (at.value[i] / gradient.length_squared());
        if step.is_finite() {
            feet.push(points.offset(i) - step);
            outward.push(-gradient.normalize());
        }
    }
    if outward.is_empty() {
        return 0.0;
    }
    let voxel = scope.lattice.voxel_size.get();
    let (mut velocities, mut held) = ([[0.0; 3]; BATCH], [false; BATCH]);
    movement.meter(voxel).velocities(&feet, &outward, &mut velocities, &mut held);
    let beyond = |(velocity, outward): (&[f32; 3], &Vec3)| {
        let across = f64::from(Vec3::from(*velocity).dot(*outward)).abs() * movement.frame_seconds / voxel;
        (across + 1.0 - f64::from(scope.half_width)).max(0.0)
    };
    velocities.iter().zip(&outward).map(beyond).sum::<f64>() / outward.len() as f64
}

/// The neighbours that a voxel hands its velocity on to: outside, without one, and no farther along the surface point's
/// way than that moves in a frame, nor beside it than the band is wide; and a voxel more for samples between voxels.
fn outward<'a>(
    carried: Carried,
    band: &'a Band,
    movement: &'a Movement,
    known: &'a FxHashMap<IVec3, Block>,
) -> impl Iterator<Item = Carried> + 'a {
    let velocity = Vec3::from(carried.velocity).as_dvec3();
    let (direction, reach) = (velocity.normalize_or_zero(), velocity.length() * movement.frame_seconds);
    let (voxel, width) = (band.lattice.voxel_size.get(), f64::from(band.background()));
    let away = band.lattice.centre(carried.voxel) - carried.foot;
    let neighbours: &[IVec3] = if reach > width { &FACES } else { &[] };
    neighbours.iter().filter_map(move |step| {
        let neighbour = carried.voxel + *step;
        let from_foot = band.lattice.centre(neighbour) - carried.foot;
        let along = from_foot.dot(direction);
        let beside = (from_foot - along * direction).length();
        let is_known = |(active, _): &Block| is_active(active, voxel_offset(neighbour));
        let taken = from_foot.dot(away) > 0.0
            && along.abs() <= reach + voxel
            && beside <= width + voxel
            && !known.get(&block_origin(neighbour)).is_some_and(is_known);
        taken.then_some(Carried { voxel: neighbour, distance: from_foot.length(), ..carried })
    })
}
