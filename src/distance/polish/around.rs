//! Feet around points of the surface that are known already; the positions whose feet they are may be far away.
//!
//! A tape holds all branches of its region, and in a region of many cells most of them end up far from any one foot.
//! So points of the surface that lie close together are polished together, in a region around them alone: a smaller
//! one where it still holds more branches than can be combined.

use glam::DVec3;

use crate::field::{Aabb, BATCH, Evaluator, Points};

use super::{FEW, Polisher, Request, Resolution};

/// Points of the surface in one cube of this many units are polished in one call. Smaller makes calls of few points,
/// larger keeps more branches of the field.
const GROUP: f64 = 4.0;

/// The cubes that the field is shortened in on the way down to a group, in units. A field of many parts is bounded over
/// few large boxes in full, and over many small ones only in the few parts that are left.
const LARGEST_GROUP: f64 = 64.0;

/// How many times smaller the cubes on the way down get.
const SHRINK: f64 = 4.0;

/// How far stand-ins are from their points of the surface, and again how far these may move, in edges of the group.
/// Smaller stops short of corners, larger keeps more branches of the field.
const ROOM: f64 = 0.75;

/// The least group, in units: a region of four units.
const LEAST_GROUP: f64 = 1.0;

/// A foot this near to where its last approach tells it to be, in units, has been found. Smaller would meet the rounding
/// of positions, larger leaves feet along creases short of where they belong.
const SETTLED: f64 = 5e-4;

/// The same as a share of the distance to the position: what directions may be wrong by. Of distances that is a
/// hundred-thousandth. Larger, and cells far from the surface would be split for it.
const SETTLED_SHARE: f64 = 4e-3;

/// How often a foot is sought along its face or crease before it is sought from its position. More pays only for feet
/// far from their seeds.
const RELAXED: usize = 2;

/// A position on the way to its foot, and the point of the surface it has so far.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// The caller's number for it.
    pub query: usize,
    /// Whose foot is sought, world units.
    pub position: DVec3,
    /// Whether F ≥ 0 there.
    pub inside: bool,
    /// The nearest point of the surface found so far.
    pub foot: DVec3,
    /// That before the last approach.
    before: DVec3,
    /// The cube of the group it belongs to.
    cube: [i64; 3],
}

impl Approach {
    /// Starts from a point of the surface.
    pub fn new(query: usize, position: DVec3, inside: bool, foot: DVec3) -> Self {
        Self { query, position, inside, foot, before: foot, cube: [0; 3] }
    }

    /// Whether the last approach, from a stand-in `room` from the foot, tells that the foot is found. The foot of a
    /// stand-in has gone the stand-in's share of what is missing.
    fn is_settled(&self, room: f64, unit: f64) -> bool {
        let missing = self.foot.distance(self.before) * (self.before.distance(self.position) / room);
        missing <= (SETTLED * unit).max(SETTLED_SHARE * self.foot.distance(self.position))
    }
}

/// Whose feet are sought.
#[derive(Clone, Copy)]
enum Aim {
    /// The position's own.
    Position,
    /// Those of stand-ins nearer to the surface.
    StandIn {
        /// See [`stand_in`].
        relaxed: bool,
    },
}

/// Scratch memory of one thread.
pub struct Around {
    polisher: Polisher,
    /// See [`Resolution::least`].
    least: f32,
    queries: Points,
    feet: Points,
    distances: Box<[f32; BATCH]>,
    inside: Box<[bool; BATCH]>,
}

impl Around {
    /// Allocates the scratch memory.
    pub fn new() -> Self {
        Self {
            polisher: Polisher::new(),
            least: 0.0,
            queries: Points::new(DVec3::ZERO),
            feet: Points::new(DVec3::ZERO),
            distances: Box::new([0.0; BATCH]),
            inside: Box::new([false; BATCH]),
        }
    }

    /// Moves the feet of positions to nearer points of the surface around them. They come back in another order.
    pub fn closest(&mut self, evaluator: &mut dyn Evaluator, resolution: Resolution, open: &mut [Approach]) {
        self.least = resolution.least;
        self.closest_by_groups(evaluator, resolution.unit.into(), LARGEST_GROUP, open);
    }

    fn closest_by_groups(&mut self, evaluator: &mut dyn Evaluator, unit: f64, edge: f64, open: &mut [Approach]) {
        for open in open.iter_mut() {
            open.cube = (open.foot / (edge * unit)).floor().as_i64vec3().to_array();
        }
        open.sort_unstable_by_key(|open| (open.cube, open.query));
        let most = if edge > GROUP { usize::MAX } else { BATCH };
        for group in open.chunk_by_mut(|a, b| a.cube == b.cube).flat_map(|cube| cube.chunks_mut(most)) {
            let room = 2.0 * ROOM * edge.min(GROUP) * unit;
            let region = box_of(group.iter().map(|open| open.foot)).grown(room);
            evaluator.enter(&region);
            if edge > GROUP {
                self.closest_by_groups(evaluator, unit, edge / SHRINK, group);
            } else if evaluator.branches() > FEW && edge > LEAST_GROUP {
                self.closest_by_groups(evaluator, unit, 0.5 * edge, group);
            } else {
                self.polish(evaluator, unit, edge, region, group);
            }
            evaluator.leave();
        }
    }

    fn polish(&mut self, evaluator: &mut dyn Evaluator, unit: f64, edge: f64, region: Aabb, group: &mut [Approach]) {
        let mut open = group;
        if evaluator.branches() > 1 {
            // Creases and corners are sought from a stand-in near the surface, on the way to the position. What is
            // found so is on the right crease or face; the relaxed one finds how far along it, and the third approach
            // tells whether that was far enough: what is the foot of one point on the way is the foot of all of them.
            let room = ROOM * edge * unit;
            self.approach(evaluator, unit, edge, region, Aim::StandIn { relaxed: false }, open);
            // A position near the surface was its own stand-in.
            open = kept(open, |open| open.before.distance(open.position) > room && !open.is_settled(room, unit));
            for _ in 0..RELAXED {
                self.approach(evaluator, unit, edge, region, Aim::StandIn { relaxed: true }, open);
                self.approach(evaluator, unit, edge, region, Aim::StandIn { relaxed: false }, open);
                open = kept(open, |open| !open.is_settled(room, unit));
            }
        }
        self.approach(evaluator, unit, edge, region, Aim::Position, open);
    }

    /// Moves points of the surface towards being the feet of positions, where that brings them nearer to those.
    fn approach(
        &mut self,
        evaluator: &mut dyn Evaluator,
        unit: f64,
        edge: f64,
        region: Aabb,
        aim: Aim,
        group: &mut [Approach],
    ) {
        if group.is_empty() {
            return;
        }
        let origin = region.centre();
        (self.queries.origin, self.feet.origin) = (origin, origin);
        (self.queries.len, self.feet.len) = (0, 0);
        let mut reach = 0.0_f32;
        for (inside, open) in self.inside.iter_mut().zip(group.iter_mut()) {
            let query = match aim {
                Aim::Position => open.position,
                Aim::StandIn { relaxed } => stand_in(open, relaxed, unit, ROOM * edge),
            };
            open.before = open.foot;
            let (query, start) = ((query - origin).as_vec3(), (open.foot - origin).as_vec3());
            self.queries.push(query);
            self.feet.push(start);
            *inside = open.inside;
            reach = reach.max(query.distance(start));
        }
        let request = Request { unit: unit as f32, least: self.least, reach: reach * 1.01, region };
        let Self { polisher, queries, feet, distances, inside, .. } = self;
        polisher.closest(evaluator, &request, queries, inside, feet, distances);
        for (lane, open) in group.iter_mut().enumerate() {
            let foot = self.feet.position(lane);
            let found = self.distances[lane].is_finite() && region.contains(foot);
            if found && foot.distance_squared(open.position) < open.foot.distance_squared(open.position) {
                open.foot = foot;
            }
        }
    }
}

impl Default for Around {
    fn default() -> Self {
        Self::new()
    }
}

/// Brings those that pass to the front, and returns them.
fn kept(group: &mut [Approach], passes: impl Fn(&Approach) -> bool) -> &mut [Approach] {
    let mut count = 0;
    for i in 0..group.len() {
        if passes(&group[i]) {
            group.swap(count, i);
            count += 1;
        }
    }
    &mut group[..count]
}

/// The point towards a position, no farther than `room` units from the point of the surface. Along a straight face or
/// crease the foot of such a stand-in has gone a part of the way only, the stand-in's share of the distance: relaxed, it
/// starts as far along as the last approach would have gone in full.
fn stand_in(open: &Approach, relaxed: bool, unit: f64, room: f64) -> DVec3 {
    let room = room * unit;
    let distance = open.foot.distance(open.position);
    if distance <= room {
        return open.position;
    }
    let mut start = open.foot;
    if relaxed {
        let rest = (open.foot - open.before) * (distance / room - 1.0);
        start += rest.clamp_length_max(room);
    }
    start + (open.position - start).clamp_length_max(room)
}

/// The least box around points.
pub fn box_of(points: impl Iterator<Item = DVec3>) -> Aabb {
    let none = Aabb::new(DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.fold(none, |all, p| Aabb::new(all.min.min(p), all.max.max(p)))
}
