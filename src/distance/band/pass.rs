//! One pass over all blocks: chunk after chunk is measured, improved by its neighbours, finished and visited, while the
//! next one is measured already.
//!
//! Feet live only as long as a chunk. Of blocks whose neighbour comes in a later chunk the facing layer is kept; where
//! the later one turns out to offer nearer feet, the earlier block is measured again at the end. Which blocks make a
//! chunk depends on the field and the lattice only, so the result is the same for any number of threads.

use std::collections::BTreeMap;

use glam::IVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::grid::{BLOCK_EDGE, Band, InsideTile, block_order, place_of};

use super::{
    Error, Measured, MeasuredBlock, Report, Thin,
    chunk::{Chunk, Measuring},
    neighbours::Neighbours,
    pool::Pool,
};
use crate::distance::{
    descent::Scope,
    facing::{Face, Layer, Seed},
    staged::Staged,
};

/// How often blocks are measured again for what their neighbours offer. What one round brings in may be of use to the
/// blocks beyond, hardly ever farther than the second: a foot is within reach of blocks that touch.
const ROUNDS: usize = 4;

/// How many threads measuring one chunk keeps busy.
const THREADS_OF_CHUNK: usize = 2;

/// What became of a block.
enum Outcome<T> {
    /// It is in the band, with this visit.
    Band(T),
    Outside,
    Inside,
}

pub(super) struct Pass<'a, 'f, T, V, M> {
    measuring: &'a Measuring<'f>,
    scope: &'a Scope,
    visitor: &'a M,
    /// Those that were made: what they know of a node serves the next blocks too.
    visitors: Pool<V>,
    /// All blocks of the pass, in order.
    all: &'a [IVec3],
    measured: Measured<T>,
    /// How many of all blocks are done with.
    taken: usize,
    /// Layers that later blocks will face.
    borders: FxHashMap<(IVec3, Face), Layer<'static>>,
    /// What improved blocks were improved by, time after time, to go the same way when they are measured once more: a
    /// nearer foot in the place of one that neighbours would have taken can leave them worse off.
    imports: FxHashMap<IVec3, Vec<Vec<Seed>>>,
    /// What later blocks offer to finished ones, in the order of blocks.
    late: BTreeMap<u128, (IVec3, Vec<Seed>)>,
}

impl<'a, 'f, T, V, M> Pass<'a, 'f, T, V, M>
where
    T: Send + Sync,
    V: FnMut(&MeasuredBlock) -> T + Send,
    M: Fn() -> V + Sync,
{
    pub fn new(measuring: &'a Measuring<'f>, visitor: &'a M, all: &'a [IVec3]) -> Self {
        let scope = measuring.scope();
        let band = Band {
            lattice: scope.lattice,
            half_width: scope.half_width,
            origins: Vec::with_capacity(all.len()),
            distances: Vec::with_capacity(all.len()),
            active: Vec::with_capacity(all.len()),
            inside_tiles: Vec::new(),
        };
        Self {
            measuring,
            scope,
            visitor,
            visitors: Pool::new(),
            all,
            measured: Measured {
                band,
                visits: Vec::with_capacity(all.len()),
                report: Report { opened_blocks: all.len() as u64, ..Report::default() },
            },
            taken: 0,
            borders: FxHashMap::default(),
            imports: FxHashMap::default(),
            late: BTreeMap::new(),
        }
    }

    /// Takes all blocks into the band, in chunks. While one thread does what it must do alone for a chunk, the others
    /// measure the next: as many at a time as keep them busy.
    pub fn run(&mut self, chunk: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<(), Error> {
        let (all, measuring) = (self.all, self.measuring);
        let at_a_time = chunk * rayon::current_num_threads().div_ceil(THREADS_OF_CHUNK);
        let mut groups = all.chunks(at_a_time);
        let mut measured = measuring.stage(groups.next().unwrap_or(&[]), chunk, Vec::new())?;
        let mut left = Vec::new();
        loop {
            progress(self.taken as f64 / all.len() as f64);
            let next = groups.next().unwrap_or(&[]);
            let (taken, staged) = rayon::join(
                || measured.iter_mut().try_for_each(|chunk| self.take(chunk)),
                || measuring.stage(next, chunk, std::mem::take(&mut left)),
            );
            taken?;
            left = std::mem::replace(&mut measured, staged?);
            if next.is_empty() {
                return Ok(());
            }
        }
    }

    /// Takes the next blocks all the way into the band.
    fn take(&mut self, chunk: &mut Chunk) -> Result<(), Error> {
        let staged = &mut chunk.staged;
        if !self.measuring.by_itself() {
            let places = staged.iter().enumerate().map(|(place, block)| (block.origin, place)).collect();
            self.improve(staged, &places)?;
            self.keep_borders(staged, &places);
        }
        let outcomes = self.finish(staged);
        self.push(staged, outcomes, &chunk.order);
        self.taken += staged.len();
        Ok(())
    }

    /// Measures again those blocks whose neighbours have nearer feet for some of their voxels, until there are none.
    fn improve(&mut self, staged: &mut [Staged], places: &FxHashMap<IVec3, usize>) -> Result<(), Error> {
        let mut improved: Option<Vec<usize>> = None;
        for _ in 0..ROUNDS {
            let (voxel, reach) = (self.voxel(), self.scope.background());
            let neighbours = Neighbours { staged, places, borders: &self.borders, voxel, reach };
            let offers = improved.map_or_else(|| neighbours.compare(), |improved| neighbours.offers_of(&improved));
            self.measuring.stop_if_cancelled()?;
            if offers.is_empty() {
                break;
            }
            let again: Vec<Staged> = offers
                .par_iter()
                .map_init(
                    || self.measuring.meter(),
                    |meter, (place, seeds)| {
                        let mut block = staged[*place].clone();
                        meter.enter_nodes(block.origin);
                        meter.improve(seeds, &mut block);
                        block
                    },
                )
                .collect();
            improved = Some(offers.iter().map(|(place, _)| *place).collect());
            for ((place, seeds), block) in offers.into_iter().zip(again) {
                self.imports.entry(block.origin).or_default().push(seeds);
                staged[place] = block;
            }
        }
        Ok(())
    }

    fn voxel(&self) -> f32 {
        self.scope.lattice.voxel_size.get() as f32
    }

    /// Keeps the layers that face later chunks, and offers those that face earlier ones.
    fn keep_borders(&mut self, staged: &[Staged], places: &FxHashMap<IVec3, usize>) {
        let (voxel, reach) = (self.voxel(), self.scope.background());
        let (all, borders) = (self.all, &self.borders);
        let at_border = |block: &Staged| {
            let order = block_order(block.origin);
            let mut kept = Vec::new();
            let mut offered = Vec::new();
            for face in Face::ALL {
                let neighbour = block.origin + face.step();
                if places.contains_key(&neighbour) {
                    continue;
                }
                if block_order(neighbour) > order {
                    if place_of(all, neighbour).is_ok() {
                        kept.push((face, Layer::kept(block, face, voxel)));
                    }
                } else if let Some(layer) = borders.get(&(neighbour, face.facing())) {
                    let mut seeds = Vec::new();
                    layer.offers(&Layer::new(block, face, voxel), reach, &mut seeds);
                    offered.push((face, seeds));
                }
            }
            (kept, offered)
        };
        let found: Vec<_> = staged.par_iter().map(at_border).collect();
        for (block, (kept, offered)) in staged.iter().zip(found) {
            for (face, layer) in kept {
                self.borders.insert((block.origin, face), layer);
            }
            for (face, mut seeds) in offered {
                let neighbour = block.origin + face.step();
                self.borders.remove(&(neighbour, face.facing()));
                if !seeds.is_empty() {
                    let late = self.late.entry(block_order(neighbour)).or_insert((neighbour, Vec::new()));
                    late.1.append(&mut seeds);
                }
            }
        }
    }

    /// Masks and visits the staged blocks.
    fn finish(&mut self, staged: &[Staged]) -> Vec<Outcome<T>> {
        for block in staged {
            if let Some(at) = block.thin_at {
                self.measured.report.thin.push(Thin {
                    origin: block.origin,
                    voxels: block.thin,
                    at,
                    size: f64::from(block.thin_size),
                });
            }
        }
        let visitor = || self.visitors.take(self.visitor);
        staged.par_iter().map_init(visitor, |visitor, block| outcome(self.scope, &mut **visitor, block)).collect()
    }

    /// Takes the staged blocks, whose places in the chunk are `order`, into the band. One thread does, while others measure:
    /// where several touch new memory at once, each gets the same huge page ready, and all but one for nothing.
    fn push(&mut self, staged: &[Staged], outcomes: Vec<Outcome<T>>, order: &[usize]) {
        let mut in_order: Vec<_> = outcomes.iter().map(|_| None).collect();
        for ((block, outcome), &place) in staged.iter().zip(outcomes).zip(order) {
            in_order[place] = Some((block, outcome));
        }
        let background = self.scope.background();
        for (block, outcome) in in_order.into_iter().flatten() {
            match outcome {
                Outcome::Band(visit) => {
                    self.measured.band.origins.push(block.origin);
                    self.measured.band.distances.push(block.clamped(background));
                    self.measured.band.active.push(block.active);
                    self.measured.visits.push(visit);
                }
                Outcome::Inside => {
                    self.measured.band.inside_tiles.push(InsideTile { origin: block.origin, edge: BLOCK_EDGE })
                }
                Outcome::Outside => {}
            }
        }
    }

    /// Measures the blocks again to which later ones offered nearer feet, and then those to which these do.
    pub fn redo(&mut self) -> Result<(), Error> {
        for _ in 0..ROUNDS {
            let late = std::mem::take(&mut self.late);
            let origins: Vec<IVec3> = late.values().map(|(origin, _)| *origin).collect();
            for (origin, seeds) in late.into_values() {
                self.imports.entry(origin).or_default().push(seeds);
            }
            let worker = || (self.measuring.meter(), self.visitors.take(self.visitor));
            let again = origins
                .into_par_iter()
                .map_init(worker, |(meter, visitor), origin| {
                    let mut block = Staged::new();
                    meter.enter_nodes(origin);
                    meter.measure(origin, &mut block)?;
                    self.imports[&origin].iter().for_each(|seeds| meter.improve(seeds, &mut block));
                    Ok((outcome(self.scope, &mut **visitor, &block), block))
                })
                .collect::<Result<Vec<_>, Error>>()?;
            let mut redone = Vec::with_capacity(again.len());
            for (outcome, block) in again {
                self.replace(&block, outcome);
                redone.push(block);
            }
            for block in &redone {
                self.offer_to_finished(block);
            }
        }
        Ok(())
    }

    /// Offers a block's feet to its finished neighbours.
    fn offer_to_finished(&mut self, block: &Staged) {
        let (voxel, reach) = (self.voxel(), self.scope.background());
        for face in Face::ALL {
            let neighbour = block.origin + face.step();
            if place_of(self.all, neighbour).is_err() {
                continue;
            }
            // A finished block that is not in the band has no foot.
            let distances = match place_of(&self.measured.band.origins, neighbour) {
                Ok(place) => face.facing().layer(&self.measured.band.distances[place]),
                Err(_) => [reach; 64],
            };
            let mut seeds = Vec::new();
            Layer::new(block, face, voxel).offer_feet(&distances, reach, &mut seeds);
            if !seeds.is_empty() {
                self.late.entry(block_order(neighbour)).or_insert((neighbour, Vec::new())).1.append(&mut seeds);
            }
        }
    }

    /// Puts a block measured again in its place. It can only have gained: nearer feet, active voxels.
    fn replace(&mut self, block: &Staged, outcome: Outcome<T>) {
        let Outcome::Band(visit) = outcome else { return };
        if self.measured.put(block.origin, block.clamped(self.scope.background()), block.active, visit) {
            self.measured.band.inside_tiles.retain(|tile| tile.origin != block.origin);
        }
    }

    /// The band, the visits and the counts.
    pub fn done(mut self) -> Measured<T> {
        self.measured.report.band_blocks = self.measured.band.origins.len() as u64;
        self.measured
    }
}

fn outcome<T>(scope: &Scope, visitor: &mut impl FnMut(&MeasuredBlock) -> T, block: &Staged) -> Outcome<T> {
    if block.active == [0; 8] {
        return if block.distances[0] >= 0.0 { Outcome::Inside } else { Outcome::Outside };
    }
    let visit = visitor(&MeasuredBlock::new(scope, block));
    Outcome::Band(visit)
}
