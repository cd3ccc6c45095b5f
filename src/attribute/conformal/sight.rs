//! Whether one place of a body sees another: whether the straight way between them stays inside.

use glam::{DVec3, Vec3};

use super::nodes::{Body, NONE};
use crate::field::{BATCH, Evaluator, Gradients, Points};

/// How far outside a way may be, in cells, and still count as inside: places on the surface are a rounding error off to
/// either side, and measured distances are off by about as much.
const TOLERANCE: f32 = 0.02;
/// The shortest step along a way, in cells. Longer ones look for walls farther ahead, shorter ones take longer along walls.
const LEAST_STEP: f32 = 1.0 / 64.0;
/// How near to the surface F itself is asked, in cells: measured distances are off by up to a fraction of a cell beside
/// thin walls. Farther away, the node near the way tells enough.
const NEAR: f32 = 0.25;
/// How far behind a surface ahead one looks for its wall's other side, in cells. More steps over what is behind the wall,
/// less is lost in the errors of measured distances.
const BEHIND: f32 = 0.03;
/// How near to a surface ahead one looks where exactly it is, in cells.
const BEFORE: f32 = 0.02;
/// How often a way there is halved.
const MOST_HALVES: i32 = 6;
/// Normals of a wall's two sides have a product less than this. The two sides of an edge that is cut short do not.
const OPPOSITE: f32 = -0.5;
/// How far the two sides of a wall may seem to overlap, in cells, by the errors of measured distances.
const OVERLAP: f32 = 0.005;

/// A place sees all eight nodes around it where it is so far from the surface, in cells: the diagonal of a cell, and a little.
const AROUND: f32 = 1.75;

/// A place on a way that sees the eight nodes around it, and how far it is from the end.
pub(super) struct Stop {
    place: Vec3,
    left: f32,
}

impl Stop {
    /// Whether what is known of the nodes around, all at most so far from the end, tells it: those that see the end and those
    /// that do not, where they agree.
    pub fn by_nodes(&self, body: &Body, within: f32, sees: impl Fn(u32) -> bool) -> Option<bool> {
        if self.left + AROUND > within {
            return None;
        }
        let [first, others @ ..] = body.corners(self.place.floor().as_ivec3());
        let is_seen = sees(first);
        others.into_iter().all(|node| sees(node) == is_seen).then_some(is_seen)
    }
}

/// Looks along ways in one body, on one thread.
pub(super) struct Sight<'b> {
    body: &'b Body,
    evaluator: Box<dyn Evaluator + 'b>,
    solid: Box<dyn Evaluator + 'b>,
    point: Points,
    value: [f32; BATCH],
    gradient: Box<Gradients>,
    scale: f32,
}

impl<'b> Sight<'b> {
    pub fn new(body: &'b Body) -> Self {
        let mut point = Points::new(DVec3::ZERO);
        point.len = 1;
        let scale = body.edge().recip() as f32;
        Self {
            body,
            evaluator: body.distance().evaluator(),
            solid: body.solid().evaluator(),
            point,
            value: [0.0; BATCH],
            gradient: Box::default(),
            scale,
        }
    }

    /// The distance to the surface, in cells.
    fn distance(&mut self, place: Vec3) -> f32 {
        self.point.origin = self.body.to_units(place);
        self.evaluator.values(&self.point, &mut self.value);
        self.value[0] * self.scale
    }

    /// The distance to the surface, in cells, and the direction away from it.
    pub fn clearance(&mut self, place: Vec3) -> (f32, Vec3) {
        self.point.origin = self.body.to_units(place);
        self.evaluator.gradients(&self.point, &mut self.gradient);
        (self.gradient.value[0] * self.scale, self.gradient.gradient(0).normalize_or_zero())
    }

    /// F/|∇F|, in cells, and the direction of ∇F.
    fn surface(&mut self, place: Vec3) -> (f32, Vec3) {
        self.point.origin = self.body.to_units(place);
        self.solid.gradients(&self.point, &mut self.gradient);
        let (slope, rate) = self.gradient.gradient(0).normalize_and_length();
        (self.gradient.value[0] / rate * self.scale, slope)
    }

    /// Whether a step that is longer than the surface is away goes through a wall, however thin: by where the way meets
    /// the surface ahead, and where the surface that is behind that.
    fn meets_wall(&mut self, place: Vec3, direction: Vec3, step: f32) -> bool {
        let (mut gone, (mut free, inward)) = (0.0, self.surface(place));
        let mut nearing = -inward.dot(direction);
        // F is a distance only right beside the surface: go there first, and half as far where that is through it.
        let mut halves = 0;
        loop {
            if nearing <= 0.0 || gone + free / nearing > step {
                return false;
            }
            if free < 2.0 * BEFORE || halves == MOST_HALVES {
                break;
            }
            let on = (free - BEFORE) / nearing * 0.5f32.powi(halves);
            let (there, slope) = self.surface(place + direction * (gone + on));
            if there > 0.0 && slope.dot(inward) > OPPOSITE {
                (gone, free, nearing) = (gone + on, there, -slope.dot(direction));
            } else {
                halves += 1;
            }
        }
        let entered = gone + free / nearing;
        let beyond = (entered + BEHIND / nearing).min(step);
        let (after, out) = self.surface(place + direction * beyond);
        let leaving = out.dot(direction);
        let left = beyond - after / leaving;
        after < -TOLERANCE || (leaving > 0.0 && inward.dot(out) < OPPOSITE && left > entered - OVERLAP)
    }

    /// Where a straight way that is inside passes nearest to the surface between its ends, if it is nearer there than at both.
    pub fn narrows(&mut self, from: Vec3, to: Vec3) -> Option<Vec3> {
        /// Finer: places are found better than bends are moved; coarser: corners beside the ends are missed.
        const STEP: f32 = 1.0 / 64.0;
        let length = from.distance(to);
        let least = self.distance(from).min(self.distance(to));
        let (mut nearest, mut gone) = ((least, None), STEP);
        while gone < length {
            let place = from.lerp(to, gone / length);
            let free = self.distance(place);
            if free < nearest.0 {
                nearest = (free, Some(place));
            }
            // No place on the next part of the way is nearer than the nearest.
            gone += (free - nearest.0).max(STEP);
        }
        nearest.1
    }

    /// How far the surface is at least, by the nearest node.
    fn at_least(&self, place: Vec3) -> f32 {
        let node = self.body.node((place + 0.5).as_ivec3());
        if node == NONE { 0.0 } else { self.body.depth(node) - place.distance(self.body.place(node)) }
    }

    /// Whether the straight way from one place to another stays inside: by steps no longer than the surface is away.
    pub fn is_clear(&mut self, from: Vec3, to: Vec3) -> bool {
        self.is_clear_or(from, to, |_| None)
    }

    /// The same, where `known` may tell it of a stop on the way.
    pub fn is_clear_or(&mut self, from: Vec3, to: Vec3, known: impl Fn(Stop) -> Option<bool>) -> bool {
        let way = to - from;
        let length = way.length();
        if length == 0.0 {
            return true;
        }
        let (direction, mut gone) = (way / length, 0.0);
        loop {
            let (place, left) = if gone >= length { (to, 0.0) } else { (from + direction * gone, length - gone) };
            let mut free = self.at_least(place);
            if free < NEAR {
                free = self.distance(place);
                if free < -TOLERANCE || free.is_nan() {
                    return false;
                }
            }
            if left == 0.0 || free >= left.max(NEAR) {
                return true;
            }
            if free >= AROUND
                && let Some(is_clear) = known(Stop { place, left })
            {
                return is_clear;
            }
            let step = free.max(LEAST_STEP);
            if free < NEAR && self.meets_wall(place, direction, step.min(left)) {
                return false;
            }
            gone += step;
        }
    }
}
