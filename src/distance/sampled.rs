//! A level set's voxels as a field: trilinear between their centres, ± the background beyond the band.

use glam::{DVec3, IVec3, Vec3};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points};
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, Band, block_origin, voxel_offset};

/// The edges of tiles, in voxels.
const TILE_EDGES: [i32; 3] = [8, 128, 4096];
/// The most blocks whose voxels are looked at one by one for bounds.
const FEW_BLOCKS: i64 = 27;
/// The most blocks that are looked at for bounds at all: regions of more are to be halved.
const MANY_BLOCKS: i64 = 512;
/// How far sums of `f32` may be beyond their bounds, as a share of the background.
const SLACK: f64 = 1e-6;

/// A level set between whose voxels the distance is trilinear; its zero set is the surface.
pub struct SampledLevelSet {
    band: Band,
    /// Where each block is.
    places: FxHashMap<IVec3, u32>,
    /// The least corners of what is solid, by its edge.
    tiles: [FxHashSet<IVec3>; 3],
    /// The least and the greatest value of each block.
    ranges: Vec<[f32; 2]>,
    around: Option<Aabb>,
}

impl SampledLevelSet {
    /// The field of a band.
    pub fn new(band: Band) -> Self {
        let places = band.origins.iter().enumerate().map(|(block, origin)| (*origin, block as u32)).collect();
        let of_edge = |edge: i32| band.inside_tiles.iter().filter(move |tile| tile.edge == edge);
        let tiles = TILE_EDGES.map(|edge| of_edge(edge).map(|tile| tile.origin).collect());
        let range = |values: &[f32; BLOCK_VOXELS]| {
            values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], value| [lo.min(*value), hi.max(*value)])
        };
        let ranges: Vec<[f32; 2]> = band.distances.iter().map(range).collect();
        let inside = band.origins.iter().zip(&ranges).filter(|(_, [_, hi])| *hi >= 0.0);
        let cubes = inside.map(|(origin, _)| (*origin, BLOCK_EDGE));
        let cubes = cubes.chain(band.inside_tiles.iter().map(|tile| (tile.origin, tile.edge)));
        let voxel = band.lattice.voxel_size.get();
        let boxes = cubes.map(|(origin, edge)| {
            // A voxel further there is none inside, and between them the distance falls.
            Aabb::new((origin - 1).as_dvec3() * voxel, (origin + edge).as_dvec3() * voxel)
        });
        let around = boxes.reduce(Aabb::union);
        Self { places, tiles, ranges, around, band }
    }

    /// The block of a voxel, or the one value that is there.
    fn block(&self, origin: IVec3) -> Result<usize, f32> {
        match self.places.get(&origin) {
            Some(block) => Ok(*block as usize),
            None => Err(self.beyond(origin)),
        }
    }

    /// The value of a voxel that is in no block.
    fn beyond(&self, voxel: IVec3) -> f32 {
        let inside = TILE_EDGES.iter().zip(&self.tiles).any(|(edge, tiles)| tiles.contains(&(voxel & -*edge)));
        if inside { self.band.background() } else { -self.band.background() }
    }

    fn voxel(&self, voxel: IVec3) -> f32 {
        self.block(block_origin(voxel))
            .map_or_else(|value| value, |block| self.band.distances[block][voxel_offset(voxel)])
    }

    /// The cell that a position is in: the voxel at its least corner, and the share of the way to the next, each axis.
    fn cell(&self, position: DVec3) -> (IVec3, DVec3) {
        let at = position / self.band.lattice.voxel_size.get();
        let floor = at.floor();
        (floor.as_ivec3(), at - floor)
    }

    /// The values at a cell's corners: z fastest.
    fn corners(&self, least: IVec3, known: &mut Known) -> [f32; 8] {
        let origin = block_origin(least);
        if known.origin != Some(origin) {
            *known = Known { origin: Some(origin), block: self.block(origin) };
        }
        let step = |corner: usize| IVec3::new(corner as i32 >> 2, corner as i32 >> 1 & 1, corner as i32 & 1);
        if (least - origin).max_element() == BLOCK_EDGE - 1 {
            return std::array::from_fn(|corner| self.voxel(least.wrapping_add(step(corner))));
        }
        match known.block {
            Ok(block) => {
                let (values, first) = (&self.band.distances[block], voxel_offset(least));
                std::array::from_fn(|corner| {
                    let step = step(corner);
                    values[first + (step.x * 64 + step.y * 8 + step.z) as usize]
                })
            }
            Err(value) => [value; 8],
        }
    }

    /// The bounds of all voxels from one to another.
    fn range(&self, least: IVec3, most: IVec3) -> Interval {
        let background = f64::from(self.band.background());
        let all = Interval::new(-background, background);
        let (first, last) = (block_origin(least), block_origin(most));
        let count = ((last - first) / BLOCK_EDGE + 1).as_i64vec3();
        // Each by itself, so that the product stays a number.
        if count.max_element() > MANY_BLOCKS || count.element_product() > MANY_BLOCKS {
            return all;
        }
        let few = count.element_product() <= FEW_BLOCKS;
        let (mut lo, mut hi) = (f32::INFINITY, f32::NEG_INFINITY);
        let mut take = |[least, most]: [f32; 2]| (lo, hi) = (lo.min(least), hi.max(most));
        let along = |axis: usize| (first[axis]..=last[axis]).step_by(BLOCK_EDGE as usize);
        for x in along(0) {
            for y in along(1) {
                for z in along(2) {
                    let origin = IVec3::new(x, y, z);
                    match self.block(origin) {
                        Err(value) => take([value; 2]),
                        Ok(block) if !few => take(self.ranges[block]),
                        Ok(block) => {
                            let from = least.max(origin) - origin;
                            let to = most.min(origin + (BLOCK_EDGE - 1)) - origin;
                            take(range_within(&self.band.distances[block], from, to));
                        }
                    }
                }
            }
        }
        Interval::new(f64::from(lo) - SLACK * background, f64::from(hi) + SLACK * background)
    }
}

/// The least and the greatest of a block's voxels from one place to another.
fn range_within(values: &[f32; BLOCK_VOXELS], from: IVec3, to: IVec3) -> [f32; 2] {
    let (mut lo, mut hi) = (f32::INFINITY, f32::NEG_INFINITY);
    for x in from.x..=to.x {
        for y in from.y..=to.y {
            let row = (x * 64 + y * 8) as usize;
            for value in &values[row + from.z as usize..=row + to.z as usize] {
                (lo, hi) = (lo.min(*value), hi.max(*value));
            }
        }
    }
    [lo, hi]
}

/// The block that was looked up last.
struct Known {
    origin: Option<IVec3>,
    block: Result<usize, f32>,
}

impl Known {
    const NOTHING: Self = Self { origin: None, block: Err(0.0) };
}

/// Between two values.
fn mix(share: f32, low: f32, high: f32) -> f32 {
    low + share * (high - low)
}

impl Field for SampledLevelSet {
    fn bounding_box(&self) -> Option<Aabb> {
        self.around.or(Some(Aabb::new(DVec3::ZERO, DVec3::ZERO)))
    }

    fn reference(&self, position: DVec3) -> f64 {
        let (least, share) = self.cell(position);
        let corner = |corner: i32| {
            let step = IVec3::new(corner >> 2, corner >> 1 & 1, corner & 1);
            let weight = |axis: usize| if step[axis] == 1 { share[axis] } else { 1.0 - share[axis] };
            weight(0) * weight(1) * weight(2) * f64::from(self.voxel(least.wrapping_add(step)))
        };
        (0..8).map(corner).sum()
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(SampledEvaluator { field: self, known: Known::NOTHING, regions: Vec::new() })
    }
}

struct SampledEvaluator<'a> {
    field: &'a SampledLevelSet,
    known: Known,
    regions: Vec<Aabb>,
}

impl SampledEvaluator<'_> {
    /// The corners of a point's cell, and the shares of the way along it.
    fn around(&mut self, points: &Points, i: usize) -> ([f32; 8], Vec3) {
        let (least, share) = self.field.cell(points.position(i));
        (self.field.corners(least, &mut self.known), share.as_vec3())
    }
}

impl Evaluator for SampledEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        let ends = [region.min, region.max].map(|end| self.field.cell(end).0);
        self.field.range(ends[0], ends[1].wrapping_add(IVec3::ONE))
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints::NONE
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            let (corners, share) = self.around(points, i);
            *out = along_x(&corners, share, mix);
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        let per_voxel = (1.0 / self.field.band.lattice.voxel_size.get()) as f32;
        for i in 0..points.len {
            let (corners, share) = self.around(points, i);
            out.value[i] = along_x(&corners, share, mix);
            out.dx[i] = along_x(&corners, share, |_, low, high| high - low) * per_voxel;
            let along_y: [f32; 4] = std::array::from_fn(|at| {
                let (y, x) = (at >> 1, at & 1);
                mix(share.z, corners[4 * x + 2 * y], corners[4 * x + 2 * y + 1])
            });
            out.dy[i] = (mix(share.x, along_y[2], along_y[3]) - mix(share.x, along_y[0], along_y[1])) * per_voxel;
            let along_z: [f32; 4] = std::array::from_fn(|at| {
                let (z, x) = (at >> 1, at & 1);
                mix(share.y, corners[4 * x + z], corners[4 * x + 2 + z])
            });
            out.dz[i] = (mix(share.x, along_z[2], along_z[3]) - mix(share.x, along_z[0], along_z[1])) * per_voxel;
        }
    }
}

/// Corners mixed along z and y; along x as `last` says.
fn along_x(corners: &[f32; 8], share: Vec3, last: fn(f32, f32, f32) -> f32) -> f32 {
    let face = |x: usize| {
        let edge = |y: usize| mix(share.z, corners[4 * x + 2 * y], corners[4 * x + 2 * y + 1]);
        mix(share.y, edge(0), edge(1))
    };
    last(share.x, face(0), face(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{InsideTile, Lattice, VoxelSize};

    const EDGE: f64 = 0.125;

    /// A ball of 12.3 voxels around a place off the origin, in blocks where its band is.
    fn ball() -> SampledLevelSet {
        let centre = DVec3::new(3.1, -4.7, 9.4);
        let (radius, background) = (12.3, 3.0f32);
        let mut band = Band {
            lattice: Lattice { voxel_size: VoxelSize::new(EDGE).expect("a size") },
            half_width: background,
            origins: Vec::new(),
            distances: Vec::new(),
            active: Vec::new(),
            inside_tiles: Vec::new(),
        };
        for x in -3..4 {
            for y in -4..3 {
                for z in -2..5 {
                    let origin = IVec3::new(x, y, z) * BLOCK_EDGE;
                    let value = |place: usize| {
                        let local = IVec3::new(place as i32 >> 6, place as i32 >> 3 & 7, place as i32 & 7);
                        let distance = radius - (origin + local).as_dvec3().distance(centre);
                        (distance as f32).clamp(-background, background) * EDGE as f32
                    };
                    let values: [f32; BLOCK_VOXELS] = std::array::from_fn(value);
                    let limit = background * EDGE as f32;
                    if values.iter().all(|value| *value == limit) {
                        band.inside_tiles.push(InsideTile { origin, edge: BLOCK_EDGE });
                    } else if values.iter().any(|value| value.abs() < limit) {
                        band.origins.push(origin);
                        band.distances.push(values);
                        band.active.push([0; 8]);
                    }
                }
            }
        }
        assert!(!band.inside_tiles.is_empty());
        SampledLevelSet::new(band)
    }

    fn everywhere() -> Points {
        let mut points = Points::new(DVec3::new(0.3, -0.5, 1.1));
        for i in 0..BATCH {
            let share = |by: usize| (i * by % BATCH) as f32 / BATCH as f32 - 0.5;
            points.push(Vec3::new(share(37), share(151), share(263)) * 4.5);
        }
        points
    }

    #[test]
    fn values_are_those_of_the_reference_and_gradients_their_differences() {
        let field = ball();
        let (points, mut values, mut out) = (everywhere(), [0.0; BATCH], Gradients::new());
        let mut evaluator = field.evaluator();
        evaluator.values(&points, &mut values);
        evaluator.gradients(&points, &mut out);
        let step = 1e-5;
        for i in 0..BATCH {
            let at = points.position(i);
            assert!((f64::from(values[i]) - field.reference(at)).abs() < 1e-6, "{at}");
            assert_eq!(values[i], out.value[i]);
            let (_, share) = field.cell(at);
            if (share * EDGE).min_element() < step || ((1.0 - share) * EDGE).min_element() < step {
                continue;
            }
            let slope =
                |axis: DVec3| (field.reference(at + axis * step) - field.reference(at - axis * step)) / (2.0 * step);
            let exact = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            assert!((out.gradient(i).as_dvec3() - exact).length() < 1e-4, "{at}: {} {exact}", out.gradient(i));
        }
        // Voxels themselves, blocks' borders among them, and both sides beyond the band.
        let centre = DVec3::new(3.1, -4.7, 9.4) * EDGE;
        assert!((field.reference(centre) - 3.0 * EDGE).abs() < 1e-12);
        assert!((field.reference(DVec3::splat(9.0)) + 3.0 * EDGE).abs() < 1e-12);
        for x in -16..24 {
            let voxel = IVec3::new(x, -5, 9);
            let exact = 12.3 - voxel.as_dvec3().distance(centre / EDGE);
            assert!((field.reference(voxel.as_dvec3() * EDGE) - exact.clamp(-3.0, 3.0) * EDGE).abs() < 1e-6);
        }
    }

    #[test]
    fn bounds_contain_all_values_and_the_box_all_that_is_inside() {
        let field = ball();
        let around = field.bounding_box().expect("a box");
        let (points, mut values) = (everywhere(), [0.0; BATCH]);
        let mut evaluator = field.evaluator();
        evaluator.values(&points, &mut values);
        for half in [0.04, 0.3, 0.7, 2.5] {
            let mut with_sign = 0;
            for middle in (0..BATCH).step_by(5).map(|i| points.position(i)) {
                let region = Aabb::new(middle - half, middle + half);
                evaluator.enter(&region);
                let bounds = evaluator.bounds();
                evaluator.leave();
                with_sign += usize::from(!bounds.contains(0.0));
                for i in 0..BATCH {
                    let at = points.position(i);
                    if (at - middle).abs().max_element() <= half {
                        assert!(bounds.contains(f64::from(values[i])), "{at} {bounds:?} {}", values[i]);
                    }
                }
            }
            assert!(half > 1.0 || with_sign > 10, "{half}: {with_sign}");
        }
        for i in 0..BATCH {
            let at = points.position(i);
            let outside = at.cmplt(around.min).any() || at.cmpgt(around.max).any();
            assert!(!outside || values[i] < 0.0, "{at}");
        }
        assert!(evaluator.bounds() == Interval::ALL);
    }
}
