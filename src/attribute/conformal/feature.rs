//! What is known of one feature at a body's nodes.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};

use super::Error;
use super::eikonal::{self, Solved};
use super::nodes::{Body, NONE};
use super::sight::Sight;
use super::spread::{Compass, Piece, Spread, at_nodes};
use super::taut::{Bend, tighten};
use crate::field::Field;

/// The root of a node whose way is straight to the feature.
pub(super) const FEATURE: u32 = NONE - 1;
/// The root of a node where the eikonal equation was solved.
const SOLVED: u32 = NONE - 2;

/// How the length of ways is found.
#[derive(Clone)]
pub enum Method {
    /// By ways that bend at nodes and are straight in between (CONFORMAL, Algorithm 1).
    Sight,
    /// By the eikonal equation, to first order.
    Eikonal {
        /// How fast ways are gone, units a second: lengths are times then.
        speed: Option<Arc<dyn Field>>,
    },
}

impl Method {
    /// Nodes that see the feature within so many cells are where ways begin.
    fn seeded(&self, body: &Body) -> f32 {
        /// Enough for features thinner than a cell.
        const CELLS: f32 = 2.0;
        /// The solver is off by the logarithm of how many cells it goes from a point: what it begins with is as large
        /// whatever the cells. More: less is solved, and more sight is looked up.
        const OF_BODY: f32 = 1.0 / 16.0;
        match self {
            Self::Eikonal { speed: None } => CELLS.max(OF_BODY * body.along()),
            // Straight ways are quickest only where the speed hardly changes.
            Self::Eikonal { speed: Some(_) } => CELLS,
            Self::Sight => f32::INFINITY,
        }
    }
}

/// The interior distances of a body's nodes from one feature.
pub struct Feature {
    /// The distance to the feature, positive inside, units.
    field: Arc<dyn Field>,
    /// Of each node, in cells; with a speed times a second a unit.
    values: Vec<f32>,
    /// The next bend of each node's way: its number, [`FEATURE`], or [`SOLVED`].
    roots: Vec<u32>,
    bends: Vec<Bend>,
    /// Of the eikonal equation.
    solved: Option<Solved>,
    /// Whether all of the feature is outside of the body: its ways go straight through the air to the surface first.
    pub is_outside: bool,
    /// Pieces of the body that hold nothing of the feature: their ways go through the air from the nearest surface.
    pub apart: Vec<Piece>,
}

impl Feature {
    /// Spreads from a feature, given by the distance to it, positive inside, in the body's space.
    ///
    /// # Errors
    /// [`Error::NotANumber`], [`Error::Speed`], [`Error::Cancelled`].
    pub fn new(body: &Body, field: Arc<dyn Field>, method: &Method, cancel: &AtomicBool) -> Result<Self, Error> {
        let slowness = match method {
            Method::Eikonal { speed: Some(speed) } => slowness(body, speed.as_ref())?,
            Method::Eikonal { speed: None } | Method::Sight => Vec::new(),
        };
        let mut spread = Spread::new(body, field.as_ref(), &slowness)?;
        let is_outside = !spread.seed(method.seeded(body));
        match method {
            _ if is_outside => spread.seed_through_air(),
            Method::Sight => spread.settle_seen(),
            Method::Eikonal { .. } => spread.queue_seen(),
        }
        let slopes = match method {
            Method::Sight => None,
            Method::Eikonal { .. } => Some(eikonal::march(&mut spread, cancel)?),
        };
        spread.run(cancel)?;
        let taut = if slopes.is_none() { tighten(&mut spread, cancel)? } else { BTreeMap::new() };
        let apart = spread.bridge();
        let (values, mut roots): (Vec<f32>, Vec<u32>) =
            spread.nodes.iter().map(|known| (known.value, known.root)).unzip();
        drop(spread);
        if slopes.is_some() {
            (0u32..).zip(&mut roots).filter(|(node, root)| node == *root).for_each(|(_, root)| *root = SOLVED);
        }
        let mut bends = Vec::new();
        let mut numbers = BTreeMap::new();
        for root in roots.iter_mut().filter(|root| **root < SOLVED) {
            let node = *root;
            *root = *numbers.entry(node).or_insert_with(|| {
                let at_node = || Bend { place: body.place(node), value: values[node as usize] };
                bends.push(taut.get(&node).copied().unwrap_or_else(at_node));
                bends.len() as u32 - 1
            });
        }
        let solved = slopes.map(|slopes| Solved { slowness, slopes });
        Ok(Self { field, values, roots, bends, solved, is_outside, apart })
    }

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
            + size_of_val(&self.roots[..])
            + size_of_val(&self.bends[..])
            + self.solved.as_ref().map_or(0, Solved::bytes)
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

    /// What a cell takes at a node: 1 without a speed.
    #[inline(always)]
    pub(super) fn of_cell(&self, node: u32) -> f32 {
        self.solved.as_ref().map_or(1.0, |solved| solved.slowness(node))
    }

    /// The value at a place that is `reach` from the feature, by the root of a node.
    #[inline(always)]
    pub(super) fn through(&self, body: &Body, node: u32, place: Vec3, reach: f32) -> f32 {
        match self.roots[node as usize] {
            // Through the air lengths count, not times.
            FEATURE if self.is_outside => reach,
            FEATURE => reach * self.of_cell(node),
            SOLVED => {
                let slope = self.solved.as_ref().map_or(Vec3::ZERO, |solved| solved.slope(node));
                (self.value(node) + slope.dot(place - body.place(node))).max(0.0)
            }
            root => {
                let Bend { place: bend, value } = self.bends[root as usize];
                value + place.distance(bend) * self.of_cell(node)
            }
        }
    }

    /// The next bend of the ways of some nodes, [`FEATURE`] for none, where it is the same for all and the way there is
    /// straight.
    #[inline(always)]
    pub(super) fn shared(&self, mut nodes: impl Iterator<Item = u32>) -> Option<u32> {
        let root = nodes.next().map(|node| self.roots[node as usize])?;
        let is_straight = root != SOLVED && self.solved.is_none();
        (is_straight && nodes.all(|node| self.roots[node as usize] == root)).then_some(root)
    }

    /// The value at a place that is `reach` from the feature and sees a bend that several nodes share.
    #[inline(always)]
    pub(super) fn over(&self, bend: u32, place: Vec3, reach: f32) -> f32 {
        if bend == FEATURE { reach } else { self.bends[bend as usize].from(place) }
    }

    /// Whether all ways to another feature are as long.
    pub fn is_where(&self, other: &Self) -> bool {
        // The rounding of values.
        const ALIKE: f32 = 1e-3;
        self.values.iter().zip(&other.values).all(|(one, two)| (one - two).abs() < ALIKE)
    }

    /// The greatest value of a node, and the greatest that so many cells take more.
    pub(super) fn greatest(&self, cells: f32) -> f32 {
        let cell = self.solved.as_ref().map_or(1.0, Solved::greatest);
        self.values.iter().fold(0.0, |greatest, value| value.max(greatest)) + cells * cell
    }

    /// The interior distance between two features, in cells: the shortest way over any node, drawn taut there where ways
    /// are straight; and what a cell takes there.
    pub(super) fn apart_from(&self, other: &Self, body: &Body) -> (f32, f32) {
        let both = self.values.iter().zip(&other.values).map(|(one, two)| one + two);
        let shortest = both.zip(0u32..).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((over_node, node)) = shortest else { return (0.0, 1.0) };
        if self.solved.is_some() {
            return (over_node, self.of_cell(node));
        }
        let (mut one, mut two) = (Compass::new(body, self.field()), Compass::new(body, other.field()));
        let mut ends = [Bend { place: body.place(node), value: 0.0 }; 2];
        for (end, feature) in ends.iter_mut().zip([self, other]) {
            if let Some(bend) = feature.bends.get(feature.roots[node as usize] as usize) {
                *end = *bend;
            }
        }
        let [start, end] = match (self.roots[node as usize], other.roots[node as usize]) {
            (FEATURE, FEATURE) => between(&mut one, &mut two, body.place(node)).map(|place| Bend { place, value: 0.0 }),
            (FEATURE, _) => [Bend { place: one.nearest(ends[1].place), value: 0.0 }, ends[1]],
            (_, FEATURE) => [ends[0], Bend { place: two.nearest(ends[0].place), value: 0.0 }],
            _ => ends,
        };
        // The node may be the bend itself: what is drawn taut may leave the body.
        let taut = start.from(end.place) + end.value;
        let is_shorter = taut < over_node && Sight::new(body).is_clear(start.place, end.place);
        (if is_shorter { taut } else { over_node }, 1.0)
    }
}

/// Places of two features that are near each other, by going to and fro between them.
fn between(one: &mut Compass<'_>, two: &mut Compass<'_>, place: Vec3) -> [Vec3; 2] {
    /// Enough for all but features that nearly touch along much of their surfaces, where little is left.
    const ROUNDS: usize = 64;
    let (mut ends, mut apart) = ([place; 2], f32::INFINITY);
    for _ in 0..ROUNDS {
        let there = two.nearest(ends[0]);
        let here = one.nearest(there);
        let now = here.distance(there);
        if now >= apart || now.is_nan() {
            break;
        }
        (ends, apart) = ([here, there], now);
    }
    ends
}

/// 1/f at each node.
fn slowness(body: &Body, speed: &dyn Field) -> Result<Vec<f32>, Error> {
    let of_speed = |at: DVec3, speed: f32| {
        let slowness = speed.recip();
        let is_one = speed > 0.0 && speed.is_finite() && slowness.is_finite();
        if is_one { Ok(slowness) } else { Err(Error::Speed { at, speed }) }
    };
    at_nodes(body, speed, of_speed)
}
