//! What is known of one feature at a body's nodes.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};

use super::Error;
use super::eikonal::{self, Solved};
use super::nodes::{Body, NONE};
use super::sight::Sight;
use super::spread::{Compass, Piece, Spread, at_nodes};
use crate::field::Field;

/// The root of a node whose way is straight to the feature.
pub(super) const FEATURE: u32 = NONE - 1;

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
            Self::Eikonal { speed: Some(_) } | Self::Sight => CELLS,
        }
    }
}

/// The interior distances of a body's nodes from one feature.
pub struct Feature {
    /// The distance to the feature, positive inside, units.
    field: Arc<dyn Field>,
    /// Of each node, in cells; with a speed times a second a unit.
    values: Vec<f32>,
    /// The next bend of each node's way: a node, or [`FEATURE`]; itself where the eikonal equation was solved.
    roots: Vec<u32>,
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
        let (values, roots, slopes, is_outside, apart) = {
            let mut spread = Spread::new(body, field.as_ref(), &slowness)?;
            spread.seed(method.seeded(body));
            let is_outside = spread.is_empty();
            if is_outside {
                spread.seed_through_air();
            }
            let slopes = match method {
                Method::Sight => None,
                Method::Eikonal { .. } => Some(eikonal::march(&mut spread, cancel)?),
            };
            spread.run(cancel)?;
            let apart = spread.bridge();
            let (values, roots): (Vec<f32>, Vec<u32>) =
                spread.nodes.iter().map(|known| (known.value, known.root)).unzip();
            (values, roots, slopes, is_outside, apart)
        };
        let solved = slopes.map(|slopes| Solved { slowness, slopes });
        Ok(Self { field, values, roots, solved, is_outside, apart })
    }

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..]) + size_of_val(&self.roots[..]) + self.solved.as_ref().map_or(0, Solved::bytes)
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
        let root = self.roots[node as usize];
        match &self.solved {
            Some(solved) if root == node => {
                let onward = solved.slope(node).dot(place - body.place(node));
                (self.value(node) + onward).max(0.0)
            }
            // Through the air lengths count, not times.
            _ if root == FEATURE => {
                if self.is_outside {
                    reach
                } else {
                    reach * self.of_cell(node)
                }
            }
            _ => self.value(root) + place.distance(body.place(root)) * self.of_cell(node),
        }
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
        let (start, from, to, end) = match (self.roots[node as usize], other.roots[node as usize]) {
            (FEATURE, FEATURE) => {
                let [from, to] = between(&mut one, &mut two, body.place(node));
                (0.0, from, to, 0.0)
            }
            (root, FEATURE) => (self.value(root), body.place(root), two.nearest(body.place(root)), 0.0),
            (FEATURE, root) => (0.0, one.nearest(body.place(root)), body.place(root), other.value(root)),
            (first, second) => (self.value(first), body.place(first), body.place(second), other.value(second)),
        };
        // The node may be the bend itself: what is drawn taut may leave the body.
        let taut = start + from.distance(to) + end;
        let is_shorter = taut < over_node && Sight::new(body).is_clear(from, to);
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
