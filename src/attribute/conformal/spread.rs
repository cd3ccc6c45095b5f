//! The interior distance of a body's nodes from one feature (CONFORMAL, Algorithm 1), found by a wavefront.
//!
//! A node's way to the feature is straight to its root, and from there on the root's own. A root is the feature itself or a
//! node that was reached before. A node is offered the roots of its neighbours; whether it sees the root is looked up
//! once, when it is the next to be settled (the paper looks for every pair of neighbours). Where it does not, the best of
//! its settled neighbours that it sees becomes its root.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, IVec3, Vec3};

use super::Error;
use super::envelope::Envelope;
use super::nodes::{Body, NONE};
use super::sight::Sight;
use crate::field::{BATCH, Evaluator, Field, Gradients, Points};

/// The root of a node whose way is straight to the feature.
pub(super) const FEATURE: u32 = NONE - 1;

/// Nodes that see the feature within so many cells are where the wavefront begins.
const SEEDED: f32 = 2.0;
/// Nodes no deeper than this, in cells, stand for the surface.
const AT_SURFACE: f32 = 1.0;
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

/// The interior distances of a body's nodes from one feature.
pub struct Feature {
    /// The distance to the feature, positive inside, units.
    field: Arc<dyn Field>,
    /// Of each node, in cells.
    values: Vec<f32>,
    /// The next bend of each node's way: a node, or [`FEATURE`].
    roots: Vec<u32>,
    /// Whether all of the feature is outside of the body: its ways go straight through the air to the surface first.
    pub is_outside: bool,
    /// Pieces of the body that hold nothing of the feature: their ways go through the air from the nearest surface.
    pub apart: Vec<Piece>,
}

impl Feature {
    /// Spreads from a feature, given by the distance to it, positive inside, in the body's space.
    ///
    /// # Errors
    /// [`Error::NotANumber`], [`Error::Cancelled`].
    pub fn new(body: &Body, field: Arc<dyn Field>, cancel: &AtomicBool) -> Result<Self, Error> {
        let (values, roots, is_outside, apart): (Vec<f32>, Vec<u32>, _, _) = {
            let mut spread = Spread::new(body, field.as_ref())?;
            spread.seed();
            let is_outside = spread.heap.is_empty();
            if is_outside {
                spread.seed_through_air();
            }
            spread.run(cancel)?;
            let apart = spread.bridge();
            let (values, roots) = spread.nodes.iter().map(|known| (known.value, known.root)).unzip();
            (values, roots, is_outside, apart)
        };
        Ok(Self { field, values, roots, is_outside, apart })
    }

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..]) + size_of_val(&self.roots[..])
    }

    /// The distance to the feature, positive inside, units.
    pub(super) fn field(&self) -> &dyn Field {
        self.field.as_ref()
    }

    /// The value of a node, in cells.
    #[inline(always)]
    pub(super) fn value(&self, node: u32) -> f32 {
        self.values[node as usize]
    }

    pub(super) fn root(&self, node: u32) -> u32 {
        self.roots[node as usize]
    }

    /// The value at a place that is `reach` from the feature, by the root of a node.
    #[inline(always)]
    pub(super) fn through(&self, body: &Body, node: u32, place: Vec3, reach: f32) -> f32 {
        match self.roots[node as usize] {
            FEATURE => reach,
            root => self.values[root as usize] + place.distance(body.place(root)),
        }
    }

    /// The greatest value of a node, in cells.
    pub(super) fn greatest(&self) -> f32 {
        self.values.iter().fold(0.0, |greatest, value| greatest.max(*value))
    }

    /// The interior distance between two features, in cells: the shortest way over any node, drawn taut there.
    pub(super) fn apart_from(&self, other: &Self, body: &Body) -> f32 {
        let both = self.values.iter().zip(&other.values).map(|(one, two)| one + two);
        let shortest = both.zip(0u32..).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((over_node, node)) = shortest else { return 0.0 };
        let (mut one, mut two) = (Compass::new(body, self.field()), Compass::new(body, other.field()));
        let taut = match (self.root(node), other.root(node)) {
            (FEATURE, FEATURE) => between(&mut one, &mut two, body.place(node)),
            (root, FEATURE) => self.value(root) + two.reach(body.place(root)),
            (FEATURE, root) => other.value(root) + one.reach(body.place(root)),
            (first, second) => self.value(first) + body.place(first).distance(body.place(second)) + other.value(second),
        };
        taut.min(over_node)
    }
}

/// The distance between two features that see each other, by going to and fro between them.
fn between(one: &mut Compass<'_>, two: &mut Compass<'_>, mut place: Vec3) -> f32 {
    /// Enough for all but features that nearly touch along much of their surfaces, where little is left.
    const ROUNDS: usize = 64;
    let mut apart = f32::INFINITY;
    for _ in 0..ROUNDS {
        let there = two.nearest(place);
        place = one.nearest(there);
        let now = place.distance(there);
        if now >= apart || now.is_nan() {
            break;
        }
        apart = now;
    }
    apart
}

/// Looks where a feature is, on one thread.
struct Compass<'f> {
    body: &'f Body,
    evaluator: Box<dyn Evaluator + 'f>,
    point: Points,
    out: Box<Gradients>,
}

impl<'f> Compass<'f> {
    fn new(body: &'f Body, field: &'f dyn Field) -> Self {
        let mut point = Points::new(DVec3::ZERO);
        point.len = 1;
        Self { body, evaluator: field.evaluator(), point, out: Box::default() }
    }

    /// The nearest place of the feature; the place itself inside of it.
    fn nearest(&mut self, place: Vec3) -> Vec3 {
        self.point.origin = self.body.to_units(place);
        self.evaluator.gradients(&self.point, &mut self.out);
        let outside = (self.out.value[0] / self.body.edge() as f32).min(0.0);
        place - self.out.gradient(0).normalize_or_zero() * outside
    }

    /// How far the feature is, in cells; 0 inside of it.
    fn reach(&mut self, place: Vec3) -> f32 {
        self.point.origin = self.body.to_units(place);
        self.evaluator.values(&self.point, &mut self.out.value);
        (-self.out.value[0] / self.body.edge() as f32).max(0.0)
    }
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    /// With a root, or none yet, that it may not see.
    Open,
    /// With a root that it sees.
    Seen,
    /// Done.
    Settled,
}

/// What is known of a node: side by side, since a front touches nodes all over memory.
#[derive(Clone, Copy)]
struct Known {
    value: f32,
    root: u32,
    /// The last root that it was found not to see: its neighbours would offer that again.
    hidden: u32,
    state: State,
}

/// A wavefront on its way.
struct Spread<'b> {
    body: &'b Body,
    sight: Sight<'b>,
    compass: Compass<'b>,
    /// How far each node is from the feature, in cells, whatever lies between.
    reaches: Vec<f32>,
    nodes: Vec<Known>,
    /// Values, which are not negative, as their bits, and nodes: a total order, so that ties do not hang on anything else.
    heap: BinaryHeap<Reverse<(u32, u32)>>,
}

impl<'b> Spread<'b> {
    fn new(body: &'b Body, field: &'b dyn Field) -> Result<Self, Error> {
        let count = body.len();
        Ok(Self {
            body,
            sight: Sight::new(body),
            compass: Compass::new(body, field),
            reaches: reaches(body, field)?,
            nodes: vec![Known { value: f32::INFINITY, root: NONE, hidden: NONE, state: State::Open }; count],
            heap: BinaryHeap::new(),
        })
    }

    fn set(&mut self, node: u32, value: f32, root: u32, state: State) {
        let known = &mut self.nodes[node as usize];
        *known = Known { value, root, state, ..*known };
        self.heap.push(Reverse((value.to_bits(), node)));
    }

    /// Nodes in the feature, and beside it in its sight.
    fn seed(&mut self) {
        for node in 0..self.body.len() as u32 {
            let reach = self.reaches[node as usize];
            if reach <= SEEDED && self.sees(node, FEATURE) {
                self.set(node, reach, FEATURE, State::Seen);
            }
        }
    }

    /// The surface, each node straight from the feature.
    fn seed_through_air(&mut self) {
        for node in (0..self.body.len() as u32).filter(|node| self.body.depth(*node) <= AT_SURFACE) {
            self.set(node, self.reaches[node as usize], node, State::Seen);
        }
    }

    fn sees(&mut self, node: u32, root: u32) -> bool {
        let place = self.body.place(node);
        let there = if root == FEATURE { self.compass.nearest(place) } else { self.body.place(root) };
        self.sight.is_clear(place, there)
    }

    fn run(&mut self, cancel: &AtomicBool) -> Result<(), Error> {
        let mut settled = 0;
        while let Some(Reverse((bits, node))) = self.heap.pop() {
            let at = node as usize;
            let Known { value, root, state, .. } = self.nodes[at];
            if state == State::Settled || value.to_bits() != bits {
                continue;
            }
            if state == State::Open && !self.sees(node, root) {
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
                let value = value + place.distance(self.body.place(neighbour));
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

    /// Offers a settled node's root to its neighbours.
    fn offer(&mut self, node: u32) {
        let Known { value, root, .. } = self.nodes[node as usize];
        let from_root =
            if root == FEATURE { None } else { Some((self.nodes[root as usize].value, self.body.place(root))) };
        for neighbour in neighbours(self.body, node) {
            let Known { value: known, hidden, state, .. } = self.nodes[neighbour as usize];
            if state == State::Settled || hidden == root {
                continue;
            }
            let offered = match from_root {
                None => self.reaches[neighbour as usize],
                Some((start, place)) => start + self.body.place(neighbour).distance(place),
            };
            // Fronts never go back, whatever rounding says.
            let offered = offered.max(value);
            if offered < known {
                self.set(neighbour, offered, root, State::Open);
            }
        }
    }

    /// Gives what was not reached the way through the air from the surface that was; the pieces, largest first.
    fn bridge(&mut self) -> Vec<Piece> {
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
    let mut evaluator = field.evaluator();
    let (mut points, mut out) = (Points::new(body.origin()), [0.0; BATCH]);
    let scale = body.edge().recip() as f32;
    let mut reaches = Vec::with_capacity(body.len());
    let nodes: Vec<u32> = (0..body.len() as u32).collect();
    for batch in nodes.chunks(BATCH) {
        points.len = 0;
        // Nodes of a batch are neighbours: offsets from the first are small.
        points.origin = body.to_units(body.place(batch[0]));
        let offset = |node: &u32| (body.place(*node) - body.place(batch[0])) * body.edge() as f32;
        batch.iter().for_each(|node| points.push(offset(node)));
        evaluator.values(&points, &mut out);
        if let Some(wrong) = (0..points.len).find(|i| out[*i].is_nan()) {
            return Err(Error::NotANumber(points.position(wrong)));
        }
        reaches.extend(out[..points.len].iter().map(|value| (-value * scale).max(0.0)));
    }
    Ok(reaches)
}

/// The nodes of the 26 cells around that of a node.
fn neighbours(body: &Body, node: u32) -> impl Iterator<Item = u32> + '_ {
    let cell = body.cell(node);
    let around = (0..27).filter(|i| *i != 13).map(|i: i32| IVec3::new(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1));
    around.map(move |way| body.node(cell + way)).filter(|node| *node != NONE)
}
