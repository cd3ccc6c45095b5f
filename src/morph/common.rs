//! The frame that moves with both objects of a morph: seen from it, what a morph changes is shape, not place.
//!
//! It moves rigidly. From each instant to the next it moves as the first object does, as the second does, or in between,
//! by how far the morph's progress is; what both do, it does. The coarse grid goes with it: a pair that is carried across
//! the shot is measured on the cells that it would be measured on at rest, and so has the same D, the same pace, the same
//! a₀.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};

use super::carry::Way;
use super::error::Side;
use super::motion::{Motion, Similarity};
use super::object::MorphObject;
use super::settings::Settings;

/// Steps over the morph's span. Fewer: objects that spin turn by more than half in a step, and the mean of two such turns
/// is the wrong one.
const STEPS: usize = 160;

/// The frame, and whether both objects rest in it.
#[derive(Clone)]
pub(super) struct Common {
    /// Where it stands over scene time, from its own space to the world. At the start of the span they are one, or it stands
    /// where the plane does that both objects lie in: it goes with that.
    pub motion: Motion,
    /// Whether both objects rest in it.
    pub rests: bool,
}

impl Common {
    /// Whether it is the world, at all times.
    pub(super) fn is_world(&self) -> bool {
        self.motion.is_still() && self.motion.at(0.0) == Similarity::IDENTITY
    }

    /// That of two objects as they move, carried along a way or not.
    pub(super) fn new(from: &MorphObject, to: &MorphObject, settings: &Settings, way: Option<&Arc<Way>>) -> Self {
        let start = settings.plane.map_or(Similarity::IDENTITY, |plane| plane.placement);
        if let Some(way) = way.filter(|way| way.is_all()) {
            return Self { motion: way.carried(Side::From, &Motion::still(start)), rests: true };
        }
        let rests = from.motion.is_still() && to.motion.is_still();
        Self { motion: common_motion(start, from, to, settings), rests }
    }
}

fn common_motion(start: Similarity, from: &MorphObject, to: &MorphObject, settings: &Settings) -> Motion {
    if from.motion.is_still() && to.motion.is_still() {
        return Motion::still(start);
    }
    let pair = Pair { objects: [from, to].map(Carried::new), settings: settings.clone() };
    let mut placements = vec![start];
    for step in 0..STEPS {
        let next = pair.moved(placements[step], pair.time(step), pair.time(step + 1));
        placements.push(next);
    }
    Motion::moving(move |time| {
        let step = (pair.settings.share(time) * STEPS as f64).floor() as usize;
        pair.moved(placements[step.min(STEPS)], pair.time(step), time)
    })
}

/// What carries the frame along.
struct Carried {
    motion: Motion,
    /// The middle of its box, in its own space.
    centre: DVec3,
}

impl Carried {
    fn new(object: &MorphObject) -> Self {
        let centre = object.own_box().map_or(DVec3::ZERO, |aabb| aabb.centre());
        Self { motion: object.motion.clone(), centre }
    }
}

struct Pair {
    objects: [Carried; 2],
    settings: Settings,
}

impl Pair {
    fn time(&self, step: usize) -> f64 {
        self.settings.time_of(step.min(STEPS) as f64 / STEPS as f64)
    }

    /// The frame `later`, from where it is at a scene time.
    fn moved(&self, frame: Similarity, time: f64, later: f64) -> Similarity {
        let second = self.settings.eased(0.5 * (time + later));
        let weights = [1.0 - second, second];
        let before = self.objects.each_ref().map(|object| object.motion.at(time));
        let after = self.objects.each_ref().map(|object| object.motion.at(later));
        let middle = |placed: &[Similarity; 2]| -> DVec3 {
            (0..2).map(|i| placed[i].to_world(self.objects[i].centre) * weights[i]).sum()
        };
        let turns = [0, 1].map(|i| after[i].rotation() * before[i].rotation().transpose());
        frame.carried(mean_turn(turns, weights), middle(&before), middle(&after))
    }
}

/// The mean of two turns of less than half a turn.
fn mean_turn(turns: [DMat3; 2], weights: [f64; 2]) -> DMat3 {
    if turns[0] == turns[1] {
        return turns[0];
    }
    let [first, second] = turns.map(|turn| DQuat::from_mat3(&turn));
    let second = if first.dot(second) < 0.0 { -second } else { second };
    DMat3::from_quat((first * weights[0] + second * weights[1]).normalize())
}
