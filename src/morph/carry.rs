//! The way that a morph carries its objects, so that two that lie apart meet: the first goes to where the second is, and
//! the second comes from where the first is, both on the one way.
//!
//! With c₁ and c₂ the centres of both at a scene time τ, s the progress along the way, b its arc and Q the turn that takes
//! the first object's frame to the second's, both are seen from one frame at
//!
//! c(τ) = (1 − s)·c₁ + s·c₂ + 4·s·(1 − s)·b, turned by Q^s (slerp: Shoemake, Animating rotation with quaternion curves,
//! 1985).
//!
//! In it the first object stands turned by Q^s about its centre, the second by Q^(s − 1). So at s = 0 the first is where it
//! is, and at s = 1 the second; between the two nothing changes but shape, and all of the blend is as if they lay one
//! within the other. Their own motion goes on, and moves the way itself.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::error::{Error, Side};
use super::inertia::{Axes, Inertia};
use super::motion::{Motion, Similarity};
use super::object::MorphObject;
use super::settings::{Carry, Settings};
use super::turn::{between, fit, is_half_turn, onto, turn, vector_near};

/// Steps over the span at which the turn between objects that turn is followed. Fewer: they turn by more than half in a
/// step, and the way jumps.
const STEPS: usize = 160;
/// How far an anchor may lie outside of its object, in halves of the diagonal of its box: what is meant to lie on the
/// surface misses it by a little.
const OUTSIDE: f64 = 0.01;

/// What a carry leaves out, as nothing decides it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Untold {
    /// The object is as long in every direction: there is no turn.
    Axes(Side),
    /// Only one axis of the object stands out: there is no turn about it.
    AboutAxis(Side),
    /// The anchors ask for half a turn, which goes about any axis across.
    HalfTurn,
}

/// The way of two objects.
pub(super) struct Way {
    ends: [End; 2],
    turning: Turning,
    settings: Settings,
    pub untold: Vec<Untold>,
}

/// An object, as the way knows it.
struct End {
    motion: Motion,
    /// What goes along the way, in the object's own space.
    centre: DVec3,
}

/// The turn from the first object's frame to the second's, by its rotation vector in the world.
enum Turning {
    /// The same at all times.
    Still(DVec3),
    /// That of objects that turn themselves.
    Moving {
        /// From the first object's own space to the second's.
        own: DMat3,
        /// The rotation vectors at steps over the span, each the nearest to the one before.
        steps: Vec<DVec3>,
    },
}

impl Way {
    /// `None` where nothing is carried.
    pub(super) fn new(from: &MorphObject, to: &MorphObject, settings: &Settings) -> Result<Option<Self>, Error> {
        if !settings.mode.carries() {
            return Ok(None);
        }
        let objects = [from, to];
        let [start, end] = settings.over;
        let placed = [from.motion.at(start), to.motion.at(start)];
        let mut untold = Vec::new();
        // The turn in the world as the span starts; `None` where there is none at any time.
        let (centres, first) = match &settings.carry {
            Carry::None => return Ok(None),
            Carry::Centroid => ([inertia(from, Side::From)?.centre, inertia(to, Side::To)?.centre], None),
            Carry::Inertia => {
                let both = [inertia(from, Side::From)?, inertia(to, Side::To)?];
                untold = untold_axes([both[0].axes, both[1].axes]);
                let axes = [0, 1].map(|i| both[i].axes.turned(placed[i].rotation()));
                (both.map(|own| own.centre), Some(onto(&axes[0], &axes[1])))
            }
            Carry::Anchors(pairs) => {
                let then = [from.motion.at(start), to.motion.at(end)];
                let within_own = |i: usize, place: DVec3| {
                    let own = then[i].to_object(place);
                    if settings.plane.is_some() { own.with_z(0.0) } else { own }
                };
                let own: Vec<[DVec3; 2]> = pairs.iter().map(|pair| [0, 1].map(|i| within_own(i, pair[i]))).collect();
                within(&own, objects)?;
                let count = own.len() as f64;
                let centres = [0, 1].map(|i| own.iter().map(|pair| pair[i]).sum::<DVec3>() / count);
                let about = |pair: &[DVec3; 2]| [0, 1].map(|i| placed[i].rotation() * (pair[i] - centres[i]));
                let about: Vec<[DVec3; 2]> = own.iter().map(about).collect();
                let turn = turn_of(&about, objects)?;
                if let [_, [from, to]] = about.as_slice()
                    && is_half_turn(*from, *to)
                {
                    untold.push(Untold::HalfTurn);
                }
                (centres, turn)
            }
        };
        let ends = [0, 1].map(|i| End { motion: objects[i].motion.clone(), centre: centres[i] });
        let turning = match first {
            None => Turning::Still(DVec3::ZERO),
            Some(first) if ends.iter().all(|end| end.motion.is_still()) => {
                Turning::Still(vector_near(&first, DVec3::ZERO))
            }
            Some(first) => {
                let own = placed[1].rotation().transpose() * first * placed[0].rotation();
                let mut steps = vec![vector_near(&first, DVec3::ZERO)];
                for step in 1..=STEPS {
                    let at = turn_between(&ends, &own, settings.time_of(step as f64 / STEPS as f64));
                    steps.push(vector_near(&at, steps[step - 1]));
                }
                Turning::Moving { own, steps }
            }
        };
        Ok(Some(Self { ends, turning, settings: settings.clone(), untold }))
    }

    /// Whether nothing but the way moves the objects.
    pub(super) fn is_all(&self) -> bool {
        self.ends.iter().all(|end| end.motion.is_still())
    }

    /// The motion of what goes with one of the objects, whose own it is, along the way.
    pub(super) fn carried(self: &Arc<Self>, side: Side, own: &Motion) -> Motion {
        let (way, own) = (Arc::clone(self), own.clone());
        Motion::moving(move |time| way.placed(side, own.at(time), time))
    }

    fn placed(&self, side: Side, own: Similarity, time: f64) -> Similarity {
        let progress = self.settings.carried(time);
        let (end, done) = match side {
            Side::From => (0, progress),
            Side::To => (1, progress - 1.0),
        };
        // Where it is, bit for bit.
        if done == 0.0 {
            return own;
        }
        let centres = self.ends.each_ref().map(|end| end.motion.at(time).to_world(end.centre));
        let arc = self.settings.arc * (4.0 * progress * (1.0 - progress));
        let place = centres[0] + (centres[1] - centres[0]) * progress + arc;
        own.carried(turn(self.vector(time) * done), centres[end], place)
    }

    fn vector(&self, time: f64) -> DVec3 {
        match &self.turning {
            Turning::Still(vector) => *vector,
            Turning::Moving { own, steps } => {
                let step = (self.settings.share(time) * STEPS as f64).floor() as usize;
                let time = self.settings.time_of(self.settings.share(time));
                vector_near(&turn_between(&self.ends, own, time), steps[step.min(STEPS)])
            }
        }
    }
}

/// The turn from the first object's frame to the second's in the world, from that in their own spaces.
fn turn_between(ends: &[End; 2], own: &DMat3, time: f64) -> DMat3 {
    let [from, to] = ends.each_ref().map(|end| end.motion.at(time).rotation());
    to * *own * from.transpose()
}

fn inertia(object: &MorphObject, side: Side) -> Result<Inertia, Error> {
    Inertia::of(object).ok_or(Error::Unbounded(side))
}

fn untold_axes(axes: [Axes; 2]) -> Vec<Untold> {
    let of = |(side, axes)| match axes {
        Axes::All(_) => None,
        Axes::One { .. } => Some(Untold::AboutAxis(side)),
        Axes::None => Some(Untold::Axes(side)),
    };
    let all: Vec<Untold> = [Side::From, Side::To].into_iter().zip(axes).filter_map(of).collect();
    // Where there is no turn, there is none about an axis.
    let none = |untold: &Untold| matches!(untold, Untold::Axes(_));
    if all.iter().any(none) { all.into_iter().filter(none).collect() } else { all }
}

/// Refuses anchors, in the objects' own spaces, that lie outside of them.
fn within(anchors: &[[DVec3; 2]], objects: [&MorphObject; 2]) -> Result<(), Error> {
    for (place, pair) in anchors.iter().enumerate() {
        for (i, side) in [Side::From, Side::To].into_iter().enumerate() {
            let own = objects[i].own_box().ok_or(Error::Unbounded(side))?;
            let outside = -objects[i].distance.reference(pair[i]);
            if outside.is_nan() || outside > OUTSIDE * 0.5 * own.size().length() {
                return Err(Error::AnchorOutside { place, side });
            }
        }
    }
    Ok(())
}

/// The turn that anchors ask for, from where they lie about their middles in the world; `None` of one.
fn turn_of(about: &[[DVec3; 2]], objects: [&MorphObject; 2]) -> Result<Option<DMat3>, Error> {
    let reach = |side: usize| about.iter().map(|pair| pair[side].length()).fold(0.0, f64::max);
    let size = |side: usize| objects[side].own_box().map_or(0.0, |own| own.size().length());
    match about {
        [] => Err(Error::Setting { name: "number of anchors", value: 0.0, least: 1.0, most: f64::INFINITY }),
        [_] => Ok(None),
        // One of the two says as much as the other: both lie about their middle.
        _ if (0..2).any(|side| reach(side) <= 1e-9 * size(side)) => Err(Error::AnchorsAlike),
        [_, [from, to]] => Ok(Some(between(*from, *to))),
        _ => fit(about).map(Some).ok_or(Error::AnchorsInLine),
    }
}
