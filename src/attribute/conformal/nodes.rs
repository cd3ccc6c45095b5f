//! The nodes of a body: one for each cell of a lattice that the body reaches into, in blocks of 8³.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;

use super::Error;
use super::eikonal::Middles;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Points};

/// No node.
pub(super) const NONE: u32 = u32::MAX;

/// The most cells in blocks that the body may reach into: some 22 bytes each, and 8 more for each feature.
const MOST_CELLS: usize = 1 << 24;
/// The most nodes of all features together, 8 bytes each.
const MOST_VALUES: usize = 1 << 26;

/// Half the diagonal of a cell: how far from its middle the body may be and still reach into it.
const CORNER: f32 = 0.866_025_4;
/// How deep the node of a cell whose middle is outside lies below the surface, in cells: the first that is deepest. Less
/// than the last is lost in rounding; more than the first moves bends away from the corners they go around.
const SUNK: [f32; 5] = [0.1, 0.05, 0.02, 0.005, 0.001];

/// The nodes of one block.
struct Block {
    /// Which cells have one: a word for each x, a bit for each y and z.
    mask: [u64; 8],
    /// The number of each word's first.
    first: [u32; 8],
}

/// A body with its nodes. Lengths are in cells of its lattice, positions in the lattice's own coordinates, in which
/// cells' middles are whole numbers, unless said otherwise.
pub struct Body {
    /// The distance to its surface, positive inside, units.
    distance: Arc<dyn Field>,
    /// F, which that is measured of.
    solid: Arc<dyn Field>,
    /// The middle of the first cell, units.
    origin: DVec3,
    /// A cell's edge, units.
    edge: f64,
    /// Cells along each axis.
    counts: IVec3,
    /// Blocks along each axis.
    blocks_along: IVec3,
    /// Which block stands where; [`NONE`] where there are no nodes.
    table: Vec<u32>,
    blocks: Vec<Block>,
    /// Each node's cell.
    cells: Vec<[u16; 3]>,
    /// Each node's position: its cell's middle, or just below the surface where that is outside.
    places: Vec<Vec3>,
    /// The distance of each node to the surface.
    depths: Vec<f32>,
    /// Its middles inside, once a solver asks for them.
    middles: OnceLock<Middles>,
}

/// What is found in one block.
struct Found {
    at: IVec3,
    mask: [u64; 8],
    places: Vec<Vec3>,
    depths: Vec<f32>,
}

impl Body {
    /// Finds the nodes of a body in its box, `along` cells on the longest side of that. `distance` is the distance to the
    /// surface of `solid`, positive inside, or a little short of it.
    ///
    /// # Errors
    /// [`Error::TooMany`], [`Error::Empty`], [`Error::Cancelled`].
    pub fn new(
        solid: Arc<dyn Field>,
        distance: Arc<dyn Field>,
        aabb: Aabb,
        along: u32,
        cancel: &AtomicBool,
    ) -> Result<Self, Error> {
        let edge = aabb.size().max_element() / f64::from(along);
        // One more on each side: a box may end a rounding error early.
        let counts = (aabb.size() / edge).ceil().as_ivec3() + 2;
        let blocks_along = (counts + 7) / 8;
        let count = blocks_along.as_i64vec3().element_product() as usize;
        let mut body = Self {
            distance,
            solid,
            origin: aabb.min - edge / 2.0,
            edge,
            counts,
            blocks_along,
            table: vec![NONE; count],
            blocks: Vec::new(),
            cells: Vec::new(),
            places: Vec::new(),
            depths: Vec::new(),
            middles: OnceLock::new(),
        };
        let stop = || cancel.load(Ordering::Relaxed);
        let open: Vec<IVec3> = (0..count)
            .into_par_iter()
            .map_init(|| Probe::new(&body), |probe, block| probe.reaches(block_at(block, blocks_along)))
            .flatten_iter()
            .collect();
        if open.len() * 512 > MOST_CELLS {
            return Err(Error::TooMany { nodes: open.len() * 512, most: MOST_CELLS });
        }
        let found: Vec<Found> = open
            .into_par_iter()
            .map_init(|| Probe::new(&body), |probe, at| if stop() { None } else { probe.nodes(at) })
            .flatten_iter()
            .collect();
        if stop() {
            return Err(Error::Cancelled);
        }
        let nodes: usize = found.iter().map(|found| found.places.len()).sum();
        if nodes == 0 {
            return Err(Error::Empty);
        }
        found.into_iter().for_each(|found| body.take(found));
        Ok(body)
    }

    /// Whether so many features may be spread from.
    ///
    /// # Errors
    /// [`Error::TooMany`].
    pub fn admit(&self, features: usize) -> Result<(), Error> {
        let most = MOST_VALUES / features.max(1);
        if self.len() > most { Err(Error::TooMany { nodes: self.len(), most }) } else { Ok(()) }
    }

    fn take(&mut self, found: Found) {
        let Found { at, mask, places, depths } = found;
        let mut first = [self.places.len() as u32; 8];
        for word in 1..8 {
            first[word] = first[word - 1] + mask[word - 1].count_ones();
        }
        let number = self.blocks.len() as u32;
        let place = block_number(at, self.blocks_along);
        self.table[place] = number;
        self.blocks.push(Block { mask, first });
        self.places.extend(places);
        self.depths.extend(depths);
        self.cells.extend(set_cells(&mask).map(|within| (at * 8 + within).to_array().map(|part| part as u16)));
    }

    /// How many nodes there are.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// A cell's edge, units.
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// The least cells of its blocks.
    pub(super) fn block_origins(&self) -> impl Iterator<Item = IVec3> {
        let numbers = self.table.iter().enumerate().filter(|(_, block)| **block != NONE);
        numbers.map(|(number, _)| block_at(number, self.blocks_along) * 8)
    }

    /// Whether a node is the middle of its cell.
    pub(super) fn is_middle(&self, node: u32) -> bool {
        self.place(node) == self.cell(node).as_vec3()
    }

    /// The middles inside, as a solver takes them.
    pub(super) fn middles(&self) -> &Middles {
        self.middles.get_or_init(|| Middles::new(self))
    }

    /// Cells along its longest side.
    pub(super) fn along(&self) -> f32 {
        (self.counts.max_element() - 2) as f32
    }

    /// The distance to the surface, positive inside, units, to keep.
    pub fn shared_distance(&self) -> Arc<dyn Field> {
        Arc::clone(&self.distance)
    }

    /// The distance to the surface, units.
    pub(super) fn distance(&self) -> &dyn Field {
        self.distance.as_ref()
    }

    /// F.
    pub(super) fn solid(&self) -> &dyn Field {
        self.solid.as_ref()
    }

    /// Where a node is.
    #[inline(always)]
    pub(super) fn place(&self, node: u32) -> Vec3 {
        self.places[node as usize]
    }

    /// How far a node is from the surface.
    #[inline(always)]
    pub(super) fn depth(&self, node: u32) -> f32 {
        self.depths[node as usize]
    }

    /// The cell of a node.
    pub(super) fn cell(&self, node: u32) -> IVec3 {
        IVec3::from(self.cells[node as usize].map(i32::from))
    }

    /// The node of a cell, or [`NONE`].
    #[inline(always)]
    pub(super) fn node(&self, cell: IVec3) -> u32 {
        if cell.cmplt(IVec3::ZERO).any() | cell.cmpge(self.counts).any() {
            return NONE;
        }
        let block = self.table[block_number(cell >> 3, self.blocks_along)];
        if block == NONE {
            return NONE;
        }
        let (block, within) = (&self.blocks[block as usize], cell & 7);
        let (mask, bit) = (block.mask[within.x as usize], within.y << 3 | within.z);
        if mask >> bit & 1 == 0 {
            return NONE;
        }
        block.first[within.x as usize] + (mask & ((1 << bit) - 1)).count_ones()
    }

    /// The nodes of a cell and of the seven after it, z before y before x.
    #[inline(always)]
    pub(super) fn corners(&self, cell: IVec3) -> [u32; 8] {
        let within = cell & 7;
        let is_apart = within.cmpeq(IVec3::splat(7)) | cell.cmplt(IVec3::ZERO) | cell.cmpge(self.counts);
        if is_apart.any() {
            return std::array::from_fn(|i| {
                self.node(cell + IVec3::new(i as i32 >> 2, i as i32 >> 1 & 1, i as i32 & 1))
            });
        }
        let mut corners = [NONE; 8];
        let block = self.table[block_number(cell >> 3, self.blocks_along)];
        if block != NONE {
            let (block, bit) = (&self.blocks[block as usize], within.y << 3 | within.z);
            for (row, pair) in corners.chunks_exact_mut(2).enumerate() {
                let (x, bit) = (within.x as usize + (row >> 1), bit + ((row as i32 & 1) << 3));
                let mask = block.mask[x];
                let first = block.first[x] + (mask & ((1 << bit) - 1)).count_ones();
                let [here, after] = [mask >> bit & 1, mask >> bit >> 1 & 1];
                pair[0] = if here == 1 { first } else { NONE };
                pair[1] = if after == 1 { first + here as u32 } else { NONE };
            }
        }
        corners
    }

    /// A position in units as one of the lattice.
    #[inline(always)]
    pub(super) fn on_lattice(&self, position: DVec3) -> Vec3 {
        ((position - self.origin) / self.edge).as_vec3()
    }

    /// A position of the lattice in units.
    pub(super) fn to_units(&self, place: Vec3) -> DVec3 {
        self.origin + place.as_dvec3() * self.edge
    }

    /// Some nodes as points of a batch. Offsets are from the first: small where they are neighbours.
    pub(super) fn points(&self, mut nodes: impl Iterator<Item = u32>) -> Points {
        let Some(first) = nodes.next().map(|node| self.place(node)) else { return Points::new(self.origin) };
        let mut points = Points::new(self.to_units(first));
        points.push(Vec3::ZERO);
        nodes.for_each(|node| points.push((self.place(node) - first) * self.edge as f32));
        points
    }

    /// Where the lattice begins, in units: an origin for batches of points in the body.
    pub(super) fn origin(&self) -> DVec3 {
        self.origin
    }

    /// A box around the lattice, units.
    pub fn aabb(&self) -> Aabb {
        Aabb::new(self.origin, self.to_units(self.counts.as_vec3()))
    }

    /// Whether a position of the lattice is on it.
    pub(super) fn holds(&self, place: Vec3) -> bool {
        place.cmpge(Vec3::NEG_ONE).all() && place.cmple(self.counts.as_vec3()).all()
    }

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        self.len() * (size_of::<Vec3>() + size_of::<[u16; 3]>() + size_of::<f32>())
            + self.table.len() * size_of::<u32>()
            + self.blocks.len() * size_of::<Block>()
            + self.middles.get().map_or(0, Middles::bytes)
    }
}

fn block_at(number: usize, along: IVec3) -> IVec3 {
    let (y, z) = (along.y as usize, along.z as usize);
    IVec3::new((number / (y * z)) as i32, (number / z % y) as i32, (number % z) as i32)
}

#[inline(always)]
fn block_number(at: IVec3, along: IVec3) -> usize {
    ((at.x * along.y + at.y) * along.z + at.z) as usize
}

/// The cells of a mask, in the order of their nodes.
fn set_cells(mask: &[u64; 8]) -> impl Iterator<Item = IVec3> {
    let bits = |(x, word): (i32, u64)| {
        (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit: i32| IVec3::new(x, bit >> 3, bit & 7))
    };
    (0..).zip(*mask).flat_map(bits)
}

/// Samples a body's distance block by block, on one thread.
struct Probe<'b> {
    body: &'b Body,
    evaluator: Box<dyn Evaluator + 'b>,
    points: Points,
    gradients: Box<Gradients>,
    values: [f32; BATCH],
}

impl<'b> Probe<'b> {
    fn new(body: &'b Body) -> Self {
        Self {
            body,
            evaluator: body.distance.evaluator(),
            points: Points::new(body.origin),
            gradients: Box::default(),
            values: [0.0; BATCH],
        }
    }

    /// Points of the lattice from now on, around a block's middle.
    fn begin(&mut self, block: IVec3) {
        self.points.origin = self.body.to_units((block * 8).as_vec3() + 3.5);
        self.points.len = 0;
    }

    fn push(&mut self, block: IVec3, place: Vec3) {
        let offset = (place - ((block * 8).as_vec3() + 3.5)).as_dvec3() * self.body.edge;
        self.points.push(offset.as_vec3());
    }

    /// Distances at the points, in cells.
    fn evaluate(&mut self) {
        self.evaluator.values(&self.points, &mut self.values);
        let scale = self.body.edge.recip() as f32;
        self.values[..self.points.len].iter_mut().for_each(|value| *value *= scale);
    }

    /// A block, where the body may reach into it.
    fn reaches(&mut self, block: IVec3) -> Option<IVec3> {
        self.begin(block);
        self.points.push(Vec3::ZERO);
        self.evaluate();
        (self.values[0] >= -8.0 * CORNER - 0.1).then_some(block)
    }

    fn nodes(&mut self, block: IVec3) -> Option<Found> {
        self.begin(block);
        let all = || (0..512).map(|i: i32| block * 8 + IVec3::new(i >> 6, i >> 3 & 7, i & 7));
        all().for_each(|cell| self.push(block, cell.as_vec3()));
        self.evaluate();
        let values = self.values;
        let mut nodes: [Option<(Vec3, f32)>; 512] =
            std::array::from_fn(|i| (values[i] >= 0.0).then(|| (self.middle(block, i), values[i])));
        let beside: Vec<usize> = (0..512).filter(|&i| values[i] < 0.0 && values[i] >= -CORNER).collect();
        if !beside.is_empty() {
            self.sink(block, &beside, &values, &mut nodes);
        }
        let inside = |cell: IVec3| cell.cmplt(self.body.counts).all();
        all().zip(&mut nodes).filter(|(cell, _)| !inside(*cell)).for_each(|(_, node)| *node = None);
        let mask = std::array::from_fn(|x| {
            (0..64).filter(|bit| nodes[x * 64 + bit].is_some()).fold(0, |word, bit| word | 1 << bit)
        });
        let (places, depths): (Vec<_>, Vec<_>) = nodes.into_iter().flatten().unzip();
        (!places.is_empty()).then_some(Found { at: block, mask, places, depths })
    }

    fn middle(&self, block: IVec3, i: usize) -> Vec3 {
        (block * 8 + IVec3::new((i >> 6) as i32, (i >> 3 & 7) as i32, (i & 7) as i32)).as_vec3()
    }

    /// Nodes of cells whose middles are outside: at the nearest of the surface, a little below it. What is thinner than a
    /// cell has nodes so, and what the lattice misses at walls and corners.
    fn sink(&mut self, block: IVec3, beside: &[usize], values: &[f32; 512], nodes: &mut [Option<(Vec3, f32)>; 512]) {
        self.begin(block);
        beside.iter().for_each(|&i| self.push(block, self.middle(block, i)));
        self.evaluator.gradients(&self.points, &mut self.gradients);
        let inward = |(j, &i): (usize, &usize)| (i, self.gradients.gradient(j).try_normalize().unwrap_or(Vec3::ZERO));
        let mut open: Vec<(usize, Vec3)> = beside.iter().enumerate().map(inward).collect();
        for sunk in SUNK {
            self.begin(block);
            let place = |(i, inward): (usize, Vec3)| self.middle(block, i) + inward * (sunk - values[i]);
            let places: Vec<Vec3> = open.iter().map(|cell| place(*cell)).collect();
            places.iter().for_each(|place| self.push(block, *place));
            self.evaluate();
            for ((&(i, _), place), depth) in open.iter().zip(places).zip(&self.values) {
                if *depth >= 0.0 && nodes[i].is_none_or(|(_, known)| known < *depth) {
                    nodes[i] = Some((place, *depth));
                }
            }
            // Where the body is as deep as asked for, no place nearer to the surface is deeper.
            open.retain(|(i, _)| nodes[*i].is_none_or(|(_, depth)| depth < 0.99 * sunk));
        }
    }
}
