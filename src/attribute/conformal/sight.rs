//! Whether one place of a body sees another: whether the straight way between them stays inside.

use glam::{DVec3, Vec3};

use super::nodes::{Body, NONE};
use crate::field::{BATCH, Evaluator, Points};

/// How far outside a way may be, in cells, and still count as inside: places on the surface are a rounding error off to
/// either side, and measured distances are off by about as much.
const TOLERANCE: f32 = 0.02;
/// The shortest step along a way, in cells. Longer ones may step over what is between two parts of the body, shorter ones
/// take longer along walls.
const LEAST_STEP: f32 = 1.0 / 16.0;
/// What a node near the way must say at least, in cells, for the distance itself not to be asked.
const FAR: f32 = 0.25;

/// Looks along ways in one body, on one thread.
pub(super) struct Sight<'b> {
    body: &'b Body,
    evaluator: Box<dyn Evaluator + 'b>,
    point: Points,
    value: [f32; BATCH],
    scale: f32,
}

impl<'b> Sight<'b> {
    pub fn new(body: &'b Body) -> Self {
        let mut point = Points::new(DVec3::ZERO);
        point.len = 1;
        let scale = body.edge().recip() as f32;
        Self { body, evaluator: body.distance().evaluator(), point, value: [0.0; BATCH], scale }
    }

    /// The distance to the surface, in cells.
    fn distance(&mut self, place: Vec3) -> f32 {
        self.point.origin = self.body.to_units(place);
        self.evaluator.values(&self.point, &mut self.value);
        self.value[0] * self.scale
    }

    /// How far the surface is at least, by the nearest node.
    fn at_least(&self, place: Vec3) -> f32 {
        let node = self.body.node((place + 0.5).as_ivec3());
        if node == NONE { 0.0 } else { self.body.depth(node) - place.distance(self.body.place(node)) }
    }

    /// Whether the straight way from one place to another stays inside: by steps no longer than the surface is away.
    pub fn is_clear(&mut self, from: Vec3, to: Vec3) -> bool {
        let way = to - from;
        let length = way.length();
        if length == 0.0 {
            return true;
        }
        let (direction, mut gone) = (way / length, 0.0);
        loop {
            let place = if gone >= length { to } else { from + direction * gone };
            let mut free = self.at_least(place);
            if free < FAR {
                free = self.distance(place);
                if free < -TOLERANCE || free.is_nan() {
                    return false;
                }
            }
            if gone + free >= length {
                return true;
            }
            gone += free.max(LEAST_STEP);
        }
    }
}
