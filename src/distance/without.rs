//! A field without some of its pieces: crumbs that a morph leaves for a frame or two.
//!
//! What is to go is known as voxels inside. F′ = min(F, G) with G the distance to the nearest of their centres less
//! [`ROOM`]: negative around all of them, so that nothing of the piece that a voxel could see remains, and far from them
//! F′ = F to the last bit.

use glam::{DVec3, IVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::{
    field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope},
    grid::{
        BLOCK_EDGE, Band, BlockMask, InsideTile, Lattice, block_order, block_origin, is_active,
        measure::voxels_of_pieces, place_of, voxel_offset,
    },
};

use super::band::{
    CHUNK, Dropped, Error, Measured, MeasuredBlock, Opened, Settings, cut_voxels, measure_blocks, measure_opened,
};

/// How far around the centres of its voxels a piece is taken away, in voxels. Smaller leaves slivers of it in corners
/// between voxels; larger takes more of a piece beside it, of which no voxel is nearer than √2.
const ROOM: f64 = 1.2;

/// From where on G says nothing, in voxels from the nearest centre: centres are looked for among the voxels around a
/// point, which hold all up to here.
const FAR: f64 = 1.5;

/// Which of a solid's connected pieces stay. The largest always does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keep {
    /// No other piece does.
    pub largest_only: bool,
    /// The least volume of those that do, cubic world units.
    pub least_volume: f64,
}

impl Keep {
    /// All pieces.
    pub const ALL: Self = Self { largest_only: false, least_volume: 0.0 };

    fn drops(self, rank: usize, volume: f64) -> bool {
        rank > 0 && (self.largest_only || volume < self.least_volume)
    }
}

/// Measures the band of what is kept of a field, as [`measure`](super::band::measure) does. Where nothing is dropped
/// that is all it does; else the blocks around what is dropped are measured once more, and counted again.
pub fn measure_kept<T, V>(
    field: &dyn Field,
    settings: &Settings,
    keep: Keep,
    visitor: impl Fn() -> V + Sync,
) -> Result<Measured<T>, Error>
where
    T: Send + Sync,
    V: FnMut(&MeasuredBlock) -> T + Send,
{
    let Opened { mut measured, blocks } = measure_opened(field, settings, &visitor, CHUNK)?;
    if keep == Keep::ALL {
        return Ok(measured);
    }
    let (mut whole, mut left_out, mut pieces) = (0.0, 0.0, 0);
    let mut dropped = Vec::new();
    // Whether two voxels that touch along an edge are one piece hangs on the distances beside them, and so on what else is
    // there: without some pieces another may fall apart.
    loop {
        let mut all = 0.0;
        let found = voxels_of_pieces(&measured.band, |rank, volume| {
            let drops = keep.drops(rank, volume);
            all += volume;
            if drops {
                left_out += volume;
                pieces += 1;
            }
            drops
        });
        if found.is_empty() {
            return Ok(measured);
        }
        if dropped.is_empty() {
            whole = all;
        }
        dropped.extend_from_slice(&found);
        let without = Without::new(field, settings.lattice, &dropped);
        // A voxel is no farther than the half width from its foot, nor this from the voxels of the piece it is on than
        // `FAR`.
        let rings = ((f64::from(settings.half_width) + FAR) / f64::from(BLOCK_EDGE)).ceil() as i32;
        let near = blocks_around(found.iter().map(|(origin, _)| origin), rings);
        let changed: FxHashSet<IVec3> = blocks.iter().copied().filter(|origin| near.contains(origin)).collect();
        // The blocks beside those offer their feet.
        let seen = blocks_around(&changed, 1);
        let beside: Vec<IVec3> = blocks.iter().copied().filter(|origin| seen.contains(origin)).collect();
        let again = measure_blocks(&without, &Settings { progress: &|_| {}, ..*settings }, &visitor, &beside, CHUNK)?;
        // A tile is inside one piece.
        measured.replace(again, &changed, |tile| without.voxels.contains_key(&tile.origin));
        measured.report.cut_voxels = cut_voxels(&measured.band, &settings.scope());
        measured.report.dropped = Dropped { pieces, share: left_out / whole };
    }
}

/// The blocks no more than so many blocks away from some.
fn blocks_around<'a>(blocks: impl IntoIterator<Item = &'a IVec3>, rings: i32) -> FxHashSet<IVec3> {
    let mut around = FxHashSet::default();
    for block in blocks {
        let edge = 2 * rings + 1;
        around.extend((0..edge.pow(3)).map(|number| {
            let step = IVec3::new(number / edge / edge, number / edge % edge, number % edge) - rings;
            block + step * BLOCK_EDGE
        }));
    }
    around
}

impl<T> Measured<T> {
    /// Puts what was measured again of some of the opened blocks in the place of what was known of them, and leaves out
    /// the tiles that are inside no more.
    fn replace(&mut self, again: Self, blocks: &FxHashSet<IVec3>, outside: impl Fn(&InsideTile) -> bool) {
        let changed = |origin: &IVec3| blocks.contains(origin);
        let stays = |origin: &IVec3| !changed(origin) || place_of(&again.band.origins, *origin).is_ok();
        let stays: Vec<bool> = self.band.origins.iter().map(stays).collect();
        retain(&mut self.band.origins, &stays);
        retain(&mut self.band.distances, &stays);
        retain(&mut self.band.active, &stays);
        retain(&mut self.visits, &stays);
        let Band { origins, distances, active, inside_tiles, .. } = again.band;
        let of_again = origins.into_iter().zip(distances).zip(active).zip(again.visits);
        for (((origin, distances), active), visit) in of_again.filter(|(((origin, _), _), _)| changed(origin)) {
            self.put(origin, distances, active, visit);
        }
        let Self { band, report, .. } = self;
        let goes = |tile: &InsideTile| outside(tile) || tile.edge == BLOCK_EDGE && changed(&tile.origin);
        band.inside_tiles.retain(|tile| !goes(tile));
        band.inside_tiles.extend(inside_tiles.into_iter().filter(|tile| changed(&tile.origin)));
        // Two sorted lists in a row: those that stay, and those of what was measured again.
        band.inside_tiles.sort_by_key(|tile| block_order(tile.origin));
        report.thin.retain(|thin| !changed(&thin.origin));
        report.thin.extend(again.report.thin.into_iter().filter(|thin| changed(&thin.origin)));
        report.band_blocks = band.origins.len() as u64;
    }
}

fn retain<E>(all: &mut Vec<E>, stays: &[bool]) {
    let mut stays = stays.iter();
    all.retain(|_| *stays.next().unwrap_or(&true));
}

/// F without the pieces that some voxels belong to.
pub struct Without<'a> {
    field: &'a dyn Field,
    lattice: Lattice,
    voxels: FxHashMap<IVec3, BlockMask>,
}

impl<'a> Without<'a> {
    /// Takes the pieces away whose voxels are given block by block; see
    /// [`voxels_of_pieces`](crate::grid::measure::voxels_of_pieces).
    pub fn new(field: &'a dyn Field, lattice: Lattice, voxels: &[(IVec3, BlockMask)]) -> Self {
        let mut all: FxHashMap<IVec3, BlockMask> = FxHashMap::default();
        for (origin, mask) in voxels {
            let known = all.entry(*origin).or_default();
            known.iter_mut().zip(mask).for_each(|(known, word)| *known |= word);
        }
        Self { field, lattice, voxels: all }
    }

    fn taken(&self, voxel: IVec3) -> bool {
        self.voxels.get(&block_origin(voxel)).is_some_and(|mask| is_active(mask, voxel_offset(voxel)))
    }

    /// G and its gradient; infinity far from all centres.
    fn room(&self, position: DVec3) -> (f64, DVec3) {
        let edge = self.lattice.voxel_size.get();
        let middle = self.lattice.nearest(position);
        let mut nearest = f64::INFINITY;
        let mut gradient = DVec3::ZERO;
        for number in 0..27 {
            let voxel = middle + IVec3::new(number / 9, number / 3 % 3, number % 3) - 1;
            if self.taken(voxel) {
                let away = position - self.lattice.centre(voxel);
                if away.length() < nearest.min(FAR * edge) {
                    nearest = away.length();
                    gradient = away.normalize_or_zero();
                }
            }
        }
        (nearest - ROOM * edge, gradient)
    }

    /// Whether anything is taken away near a region.
    fn reaches(&self, region: &Aabb) -> bool {
        let least = block_origin(self.lattice.nearest(region.min) - 2);
        let greatest = block_origin(self.lattice.nearest(region.max) + 2);
        let blocks = (greatest - least) / 8 + 1;
        let count = blocks.as_dvec3().element_product();
        if count > self.voxels.len() as f64 {
            return self.voxels.keys().any(|origin| origin.cmpge(least).all() && origin.cmple(greatest).all());
        }
        (0..blocks.x).any(|x| {
            (0..blocks.y).any(|y| (0..blocks.z).any(|z| self.voxels.contains_key(&(least + IVec3::new(x, y, z) * 8))))
        })
    }
}

impl Field for Without<'_> {
    fn bounding_box(&self) -> Option<Aabb> {
        self.field.bounding_box()
    }

    fn slope(&self) -> Slope {
        match self.field.slope() {
            Slope::Exact { .. } => Slope::Lipschitz(1.0),
            Slope::Lipschitz(most) => Slope::Lipschitz(most.max(1.0)),
            Slope::Unknown => Slope::Unknown,
        }
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.field.reference(position).min(self.room(position).0)
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(WithoutEvaluator { without: self, inner: self.field.evaluator(), near: vec![true] })
    }
}

struct WithoutEvaluator<'a> {
    without: &'a Without<'a>,
    inner: Box<dyn Evaluator + 'a>,
    /// Whether anything is taken away near each region entered, the innermost last.
    near: Vec<bool>,
}

impl WithoutEvaluator<'_> {
    fn near(&self) -> bool {
        self.near.last().is_none_or(|&near| near)
    }
}

impl Evaluator for WithoutEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        let near = self.near() && self.without.reaches(region);
        self.near.push(near);
        self.inner.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        let bounds = self.inner.bounds();
        let least = -ROOM * self.without.lattice.voxel_size.get();
        if self.near() { Interval::new(bounds.lo.min(least), bounds.hi) } else { bounds }
    }

    /// Near what is taken away F′ may be G, whose regions prune nothing.
    fn hints(&mut self, asked: Hint) -> Hints {
        let (hints, near) = (self.inner.hints(asked), self.near());
        Hints {
            keeps_values: hints.keeps_values,
            has_many_parts: hints.has_many_parts,
            vanishes: hints.vanishes && !near,
            steepest: hints.steepest.filter(|_| !near),
        }
    }

    fn leave(&mut self) {
        self.near.pop();
        self.inner.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.inner.values(points, out);
        if self.near() {
            for (i, value) in out.iter_mut().enumerate().take(points.len) {
                let room = self.without.room(points.position(i)).0 as f32;
                // A value that is no number stays one.
                if room < *value {
                    *value = room;
                }
            }
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.inner.gradients(points, out);
        if self.near() {
            for i in 0..points.len {
                let (room, gradient) = self.without.room(points.position(i));
                if (room as f32) < out.value[i] {
                    out.set(i, (room, gradient));
                }
            }
        }
    }

    fn branches(&self) -> usize {
        self.inner.branches() + usize::from(self.near())
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        if branch < self.inner.branches() {
            self.inner.branch(branch, points, out);
            return;
        }
        for i in 0..points.len {
            out.set(i, self.without.room(points.position(i)));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::{
        distance::band::{Feet, measure},
        distance::{
            accuracy::exact,
            testing::{Joined, Leaf},
        },
        field::testing::{Hinted, assert_passes_hints_on},
        grid::{BLOCK_VOXELS, VoxelSize, measure::pieces},
    };

    fn around<'a>(field: &Joined, cancel: &'a AtomicBool) -> Settings<'a> {
        let lattice = Lattice { voxel_size: VoxelSize::new(1.0).unwrap() };
        let region = field.bounding_box().unwrap().grown(4.0);
        Settings { lattice, half_width: 3.0, region, feet: Feet::Nearest, cancel, progress: &|_| {} }
    }

    /// Two balls and a crumb of three voxels beside them: without the small ones the band is that of the large ball.
    #[test]
    fn only_the_largest_piece_remains() {
        let (large, radius) = (DVec3::new(-8.2, 0.3, 0.1), 13.0);
        let field = Joined::union(vec![
            Leaf::Sphere(large, radius),
            Leaf::Sphere(DVec3::new(14.1, 0.2, 0.4), 6.0),
            Leaf::Sphere(DVec3::new(-8.0, 0.0, 16.4), 1.1),
        ]);
        let cancel = AtomicBool::new(false);
        let settings = around(&field, &cancel);
        let kept = |largest_only: bool, least_volume: f64| {
            let keep = Keep { largest_only, least_volume };
            measure_kept(&field, &settings, keep, || |_: &MeasuredBlock| ()).unwrap().band
        };
        assert_eq!(pieces(&kept(false, 0.0)).len(), 3);
        assert_eq!(pieces(&kept(false, 100.0)).len(), 2);
        let band = kept(true, 0.0);
        assert_eq!(pieces(&band).len(), 1);
        for (origin, distances) in band.origins.iter().zip(&band.distances) {
            let points = Points::of_block(*origin, &settings.lattice);
            for i in 0..BLOCK_VOXELS {
                let truth = exact::sphere(points.position(i), large, radius).clamp(-3.0, 3.0);
                let found = f64::from(distances[i]);
                assert!((found - truth).abs() < 0.02, "{found} for {truth} at {}", points.position(i));
            }
        }
    }

    /// Where what is dropped is a ball with tiles inside, and a crumb.
    #[test]
    fn measuring_again_around_what_is_dropped_comes_to_measuring_all_again() {
        let field = Joined::union(vec![
            Leaf::Sphere(DVec3::new(-24.2, 0.3, 0.1), 21.0),
            Leaf::Sphere(DVec3::new(20.1, 0.2, 0.4), 17.0),
            Leaf::Sphere(DVec3::new(-8.0, 0.0, 24.4), 1.1),
        ]);
        let cancel = AtomicBool::new(false);
        let settings = around(&field, &cancel);
        let visitor = || |block: &MeasuredBlock| block.origin;
        let all = measure(&field, &settings, visitor).unwrap().band;
        let dropped = voxels_of_pieces(&all, |rank, _| rank > 0);
        let whole = measure(&Without::new(&field, settings.lattice, &dropped), &settings, visitor).unwrap();
        let keep = Keep { largest_only: true, least_volume: 0.0 };
        let part = measure_kept(&field, &settings, keep, visitor).unwrap();
        assert_eq!((&part.band.origins, &part.band.active), (&whole.band.origins, &whole.band.active));
        assert_eq!(part.visits, part.band.origins);
        assert_eq!(part.band.distances, whole.band.distances);
        let inside = |band: &Band| band.inside_tiles.iter().flat_map(InsideTile::blocks).collect::<FxHashSet<IVec3>>();
        assert!(inside(&part.band).len() < inside(&all).len());
        assert_eq!(inside(&part.band), inside(&whole.band));
        assert_eq!(part.report.cut_voxels, whole.report.cut_voxels);
        assert_eq!(part.report.band_blocks, whole.report.band_blocks);
        assert_eq!(part.report.thin, whole.report.thin);
    }

    /// Near what is taken away all but those of a region.
    #[test]
    fn hints_are_passed_on() {
        let lattice = Lattice { voxel_size: VoxelSize::new(1.0).unwrap() };
        let without = Without::new(&Hinted, lattice, &[(IVec3::ZERO, [1, 0, 0, 0, 0, 0, 0, 0])]);
        let mut evaluator = without.evaluator();
        let near = Hints { keeps_values: true, has_many_parts: true, ..Hints::NONE };
        assert_eq!(evaluator.hints(Hint::HasManyParts), near);
        evaluator.enter(&Aabb::new(DVec3::splat(40.0), DVec3::splat(41.0)));
        assert_passes_hints_on(&mut *evaluator);
    }

    #[test]
    fn far_away_nothing_changes_and_bounds_hold() {
        let field = Joined::one(Leaf::Sphere(DVec3::ZERO, 5.0));
        let lattice = Lattice { voxel_size: VoxelSize::new(1.0).unwrap() };
        let without = Without::new(&field, lattice, &[(IVec3::ZERO, [1, 0, 0, 0, 0, 0, 0, 0])]);
        assert_eq!(without.reference(DVec3::ZERO), -ROOM);
        assert_eq!(without.reference(DVec3::new(1.3, 0.0, 0.0)), 1.3 - ROOM);
        assert_eq!(without.reference(DVec3::splat(2.0)), field.reference(DVec3::splat(2.0)));
        let mut evaluator = without.evaluator();
        let region = Aabb::new(DVec3::splat(-0.5), DVec3::splat(0.5));
        evaluator.enter(&region);
        let bounds = evaluator.bounds();
        assert!(bounds.lo <= -ROOM && bounds.hi >= 0.0);
        evaluator.leave();
    }
}
