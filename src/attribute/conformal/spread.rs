//! The interior distance of a body's nodes from one feature (CONFORMAL, Algorithm 1), found by a wavefront.
//!
//! A node's way to the feature is straight to its root, and from there on the root's own. A root is the feature itself or a
//! node that was reached before. Nodes that see the feature are found first, all others start from those. A node is offered
//! the roots of its neighbours; whether it sees the root is looked up once, when it is the next to be settled (the paper
//! looks for every pair of neighbours). Where it does not, the best of its settled neighbours that it sees becomes its root.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;

use super::Error;
use super::envelope::Envelope;
use super::feature::FEATURE;
use super::nodes::{Body, NONE};
use super::sight::{Sight, Stop};
use crate::field::{BATCH, Evaluator, Field, Gradients, Points};

/// Nodes no deeper than this, in cells, stand for the surface.
const AT_SURFACE: f32 = 1.0;
/// How thick the layers are, in cells, that are looked for a feature at once. Thinner ones make more rounds, in thicker ones
/// ways are longer to where nodes nearer to the feature tell the rest.
const LAYER: f32 = 4.0;
/// So many nodes are settled between two looks at whether to stop.
const BETWEEN_LOOKS: usize = 4096;

/// A piece of a body that no way inside leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// How many nodes it has.
    pub nodes: usize,
    /// A position in it, units.
    pub at: DVec3,
}

/// Looks where a feature is, on one thread.
pub(super) struct Compass<'f> {
    body: &'f Body,
    evaluator: Box<dyn Evaluator + 'f>,
    point: Points,
    out: Box<Gradients>,
}

impl<'f> Compass<'f> {
    pub fn new(body: &'f Body, field: &'f dyn Field) -> Self {
        let mut point = Points::new(DVec3::ZERO);
        point.len = 1;
        Self { body, evaluator: field.evaluator(), point, out: Box::default() }
    }

    /// The nearest places of the feature to some nodes that are so far from it, in cells; at most a batch.
    fn feet(&mut self, nodes: impl Iterator<Item = (u32, f32)> + Clone) -> Vec<Vec3> {
        self.evaluator.gradients(&self.body.points(nodes.clone().map(|(node, _)| node)), &mut self.out);
        let foot = |(i, (node, reach)): (usize, (u32, f32))| {
            self.body.place(node) + self.out.gradient(i).normalize_or_zero() * reach
        };
        nodes.enumerate().map(foot).collect()
    }

    /// The nearest place of the feature; the place itself inside of it.
    pub fn nearest(&mut self, place: Vec3) -> Vec3 {
        self.point.origin = self.body.to_units(place);
        self.evaluator.gradients(&self.point, &mut self.out);
        let outside = (self.out.value[0] / self.body.edge() as f32).min(0.0);
        place - self.out.gradient(0).normalize_or_zero() * outside
    }
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum State {
    /// With a root, or none yet, that it may not see.
    Open,
    /// With a root that it sees.
    Seen,
    /// Done.
    Settled,
}

/// What is known of a node: side by side, since a front touches nodes all over memory.
#[derive(Clone, Copy)]
pub(super) struct Known {
    pub value: f32,
    pub root: u32,
    /// The last root that it was found not to see: its neighbours would offer that again.
    hidden: u32,
    pub state: State,
}

/// A wavefront on its way.
pub(super) struct Spread<'b> {
    pub body: &'b Body,
    field: &'b dyn Field,
    pub sight: Sight<'b>,
    pub compass: Compass<'b>,
    /// How far each node is from the feature, in cells, whatever lies between.
    reaches: Vec<f32>,
    /// What a cell takes at each node; empty where that is 1.
    pub slowness: &'b [f32],
    pub nodes: Vec<Known>,
    /// Values, which are not negative, as their bits, and nodes: a total order, so that ties do not hang on anything else.
    heap: BinaryHeap<Reverse<(u32, u32)>>,
}

impl<'b> Spread<'b> {
    pub fn new(body: &'b Body, field: &'b dyn Field, slowness: &'b [f32]) -> Result<Self, Error> {
        let count = body.len();
        Ok(Self {
            body,
            sight: Sight::new(body),
            field,
            compass: Compass::new(body, field),
            reaches: reaches(body, field)?,
            slowness,
            nodes: vec![Known { value: f32::INFINITY, root: NONE, hidden: NONE, state: State::Open }; count],
            heap: BinaryHeap::new(),
        })
    }

    fn set(&mut self, node: u32, value: f32, root: u32, state: State) {
        let known = &mut self.nodes[node as usize];
        *known = Known { value, root, state, ..*known };
        self.heap.push(Reverse((value.to_bits(), node)));
    }

    /// What a cell takes at a node.
    #[inline(always)]
    pub fn of_cell(&self, node: u32) -> f32 {
        self.slowness.get(node as usize).copied().unwrap_or(1.0)
    }

    /// Takes the value of a node as found, the node as its own root unless it sees the feature, and goes on from there.
    pub fn settle(&mut self, node: u32, value: f32) {
        let known = &mut self.nodes[node as usize];
        let root = if known.state == State::Seen { known.root } else { node };
        *known = Known { value, root, state: State::Settled, ..*known };
        self.offer(node);
    }

    /// Finds the nodes no more than so many cells from the feature that see it, itself included; whether there are any.
    pub fn seed(&mut self, beside: f32) -> bool {
        let near = (0u32..).zip(&self.reaches).filter(|(_, reach)| **reach <= beside);
        let mut nodes: Vec<(u32, u32)> = near.map(|(node, reach)| ((reach / LAYER) as u32, node)).collect();
        nodes.par_sort_unstable();
        let mut seen = vec![false; self.nodes.len()];
        for nodes in nodes.chunk_by(|one, two| one.0 == two.0) {
            let (body, reaches, within) = (self.body, &self.reaches, nodes[0].0 as f32 * LAYER);
            let look = |(sight, compass): &mut (Sight<'_>, Compass<'_>), nodes: &[(u32, u32)]| {
                let feet = compass.feet(nodes.iter().map(|(_, node)| (*node, reaches[*node as usize])));
                let sees = |(&(_, node), foot): (&(u32, u32), Vec3)| {
                    let by_nodes = |stop: Stop| stop.by_nodes(body, within, |node| seen[node as usize]);
                    (body.holds(foot) && sight.is_clear_or(body.place(node), foot, by_nodes)).then_some(node)
                };
                nodes.iter().zip(feet).filter_map(sees).collect::<Vec<u32>>()
            };
            let new = || (Sight::new(body), Compass::new(body, self.field));
            let found: Vec<Vec<u32>> = nodes.par_chunks(BATCH).map_init(new, look).collect();
            found.into_iter().flatten().for_each(|node| seen[node as usize] = true);
        }
        for node in (0..seen.len()).filter(|node| seen[*node]) {
            let value = self.reaches[node] * self.of_cell(node as u32);
            self.nodes[node] = Known { value, root: FEATURE, state: State::Seen, ..self.nodes[node] };
        }
        seen.contains(&true)
    }

    /// Goes on from the nodes that were seen, all of them at once: their ways are straight, and no others are shorter.
    pub fn settle_seen(&mut self) {
        let is_seen = |node: u32| self.nodes[node as usize].state == State::Seen;
        let all = (0..self.nodes.len() as u32).into_par_iter();
        let border = all.filter(|node| !is_seen(*node) && neighbours(self.body, *node).any(is_seen));
        let border: Vec<u32> = border.collect();
        self.nodes.iter_mut().filter(|known| known.state == State::Seen).for_each(|known| known.state = State::Settled);
        for node in border {
            self.nodes[node as usize].hidden = FEATURE;
            self.set(node, self.reaches[node as usize], FEATURE, State::Open);
        }
    }

    /// Goes on from the nodes that were seen, the nearest first.
    pub fn queue_seen(&mut self) {
        for (node, known) in (0u32..).zip(&self.nodes).filter(|(_, known)| known.state == State::Seen) {
            self.heap.push(Reverse((known.value.to_bits(), node)));
        }
    }

    /// The surface, each node straight from the feature.
    pub fn seed_through_air(&mut self) {
        for node in (0..self.body.len() as u32).filter(|node| self.body.depth(*node) <= AT_SURFACE) {
            self.set(node, self.reaches[node as usize], node, State::Seen);
        }
    }

    fn sees(&mut self, node: u32, root: u32) -> bool {
        let place = self.body.place(node);
        if root == FEATURE {
            let foot = self.compass.nearest(place);
            return self.sight.is_clear(place, foot);
        }
        let has_root = |node: u32| {
            let Known { root: its, state, .. } = self.nodes[node as usize];
            its == root && state == State::Settled
        };
        // Those that have another root may see this one too.
        let by_nodes = |stop: Stop| stop.by_nodes(self.body, f32::INFINITY, has_root).filter(|sees| *sees);
        self.sight.is_clear_or(place, self.body.place(root), by_nodes)
    }

    pub fn run(&mut self, cancel: &AtomicBool) -> Result<(), Error> {
        let mut settled = 0;
        while let Some(Reverse((bits, node))) = self.heap.pop() {
            let at = node as usize;
            let Known { value, root, state, hidden } = self.nodes[at];
            if state == State::Settled || value.to_bits() != bits {
                continue;
            }
            if state == State::Open && (hidden == root || !self.sees(node, root)) {
                self.nodes[at].hidden = root;
                if !self.turn(node, bits) {
                    continue;
                }
            }
            self.nodes[at].state = State::Settled;
            self.offer(node);
            settled += 1;
            if settled % BETWEEN_LOOKS == 0 && cancel.load(Ordering::Relaxed) {
                return Err(Error::Cancelled);
            }
        }
        Ok(())
    }

    /// Gives a node that does not see its root the best of its settled neighbours for one; whether it still is the next to
    /// be settled. Where it sees none of them it waits for another that settles.
    fn turn(&mut self, node: u32, before: u32) -> bool {
        let (mut known, mut count) = ([(0, 0); 26], 0);
        let place = self.body.place(node);
        for neighbour in neighbours(self.body, node) {
            let Known { value, state, .. } = self.nodes[neighbour as usize];
            if state == State::Settled {
                let value = value + place.distance(self.body.place(neighbour)) * self.of_cell(node);
                known[count] = (value.to_bits(), neighbour);
                count += 1;
            }
        }
        let known = &mut known[..count];
        known.sort_unstable();
        let seen = known.iter().copied().find(|(_, root)| self.sight.is_clear(place, self.body.place(*root)));
        let known = &mut self.nodes[node as usize];
        let Some((bits, root)) = seen else {
            *known = Known { value: f32::INFINITY, root: NONE, ..*known };
            return false;
        };
        // A root's way is never longer than over the neighbour that has it, but for rounding.
        let bits = bits.max(before);
        *known = Known { value: f32::from_bits(bits), root, state: State::Seen, ..*known };
        let is_next = self.heap.peek().is_none_or(|Reverse(next)| (bits, node) <= *next);
        if !is_next {
            self.heap.push(Reverse((bits, node)));
        }
        is_next
    }

    /// Offers a settled node's root to its neighbours, or itself where a way's speed is not the same all along.
    fn offer(&mut self, node: u32) {
        let Known { value, root, .. } = self.nodes[node as usize];
        let root = if self.slowness.is_empty() { root } else { node };
        let from_root =
            if root == FEATURE { None } else { Some((self.nodes[root as usize].value, self.body.place(root))) };
        for neighbour in neighbours(self.body, node) {
            let Known { value: known, hidden, state, .. } = self.nodes[neighbour as usize];
            if state == State::Settled || hidden == root {
                continue;
            }
            let offered = match from_root {
                None => self.reaches[neighbour as usize],
                Some((start, place)) => start + self.body.place(neighbour).distance(place) * self.of_cell(neighbour),
            };
            // Fronts never go back, whatever rounding says.
            let offered = offered.max(value);
            if offered < known {
                self.set(neighbour, offered, root, State::Open);
            }
        }
    }

    /// Gives what was not reached the way through the air from the surface that was; the pieces, largest first.
    pub fn bridge(&mut self) -> Vec<Piece> {
        let all = 0..self.body.len() as u32;
        let (reached, missed): (Vec<u32>, Vec<u32>) =
            all.partition(|node| self.nodes[*node as usize].state == State::Settled);
        if missed.is_empty() {
            return Vec::new();
        }
        let surface = reached.into_iter().filter(|node| self.body.depth(*node) <= AT_SURFACE);
        let items = surface.map(|node| (self.body.place(node), self.nodes[node as usize].value, node)).collect();
        let surface = Envelope::new(items);
        for node in &missed {
            if let Some((value, root)) = surface.at(self.body.place(*node)) {
                let known = &mut self.nodes[*node as usize];
                (known.value, known.root) = (value, root);
            }
        }
        self.pieces(&missed)
    }

    /// The pieces of what was not reached: its nodes as they touch.
    fn pieces(&mut self, missed: &[u32]) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let mut open = Vec::new();
        for &first in missed {
            if self.nodes[first as usize].state == State::Settled {
                continue;
            }
            let mut nodes = 0;
            let mut deepest = first;
            open.push(first);
            self.nodes[first as usize].state = State::Settled;
            while let Some(node) = open.pop() {
                nodes += 1;
                if self.body.depth(node) > self.body.depth(deepest) {
                    deepest = node;
                }
                for neighbour in neighbours(self.body, node) {
                    if self.nodes[neighbour as usize].state != State::Settled {
                        self.nodes[neighbour as usize].state = State::Settled;
                        open.push(neighbour);
                    }
                }
            }
            pieces.push(Piece { nodes, at: self.body.to_units(self.body.place(deepest)) });
        }
        pieces.sort_by_key(|piece| Reverse(piece.nodes));
        pieces
    }
}

/// How far each node is from a feature, in cells; 0 inside of it.
fn reaches(body: &Body, field: &dyn Field) -> Result<Vec<f32>, Error> {
    let scale = body.edge().recip() as f32;
    at_nodes(
        body,
        field,
        |at, value| {
            if value.is_nan() { Err(Error::NotANumber(at)) } else { Ok((-value * scale).max(0.0)) }
        },
    )
}

/// What a field is at each node, by its position, units, and value.
pub(super) fn at_nodes(
    body: &Body,
    field: &dyn Field,
    of: impl Fn(DVec3, f32) -> Result<f32, Error> + Sync,
) -> Result<Vec<f32>, Error> {
    let nodes: Vec<u32> = (0..body.len() as u32).collect();
    let of_batch = |evaluator: &mut Box<dyn Evaluator + '_>, batch: &[u32]| {
        let (points, mut out) = (body.points(batch.iter().copied()), [0.0; BATCH]);
        evaluator.values(&points, &mut out);
        (0..points.len).map(|i| of(points.position(i), out[i])).collect::<Result<Vec<f32>, Error>>()
    };
    let batches: Vec<_> = nodes.par_chunks(BATCH).map_init(|| field.evaluator(), of_batch).collect();
    let mut all = Vec::with_capacity(nodes.len());
    for batch in batches {
        all.extend(batch?);
    }
    Ok(all)
}

/// The nodes of the 26 cells around that of a node.
fn neighbours(body: &Body, node: u32) -> impl Iterator<Item = u32> + '_ {
    let cell = body.cell(node);
    let around = (0..27).filter(|i| *i != 13).map(|i: i32| IVec3::new(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1));
    around.map(move |way| body.node(cell + way)).filter(|node| *node != NONE)
}
