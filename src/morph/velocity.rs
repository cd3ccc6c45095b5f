//! How fast the surface of a frame moves, and where to.
//!
//! A surface point q goes with the objects' own motion to q + u(dt), and from there the surface leaves it along q's outward
//! normal n: s(dt) is where the field of the instant dt away is 0 on the line q + u(dt) + n·s. The velocity is the
//! derivative of u + n·s, by differences. With v_o = du/dt, and to first order s = (F + dt·(∂F/∂t + ∇F·v_o))/|∇F|, it is
//!
//! v = v_o − (∂F/∂t + ∇F·v_o)/|∇F|² · ∇F
//!
//! with the whole change of F in scene time in ∂F/∂t. As differences of places rather than of values, it holds for any F,
//! whatever its scale at either instant; at creases, where F has no gradient and n is that of the distance; and where F
//! bends sharply beside its zero. What moves rigidly has s = 0: all of its own motion, the tangential part included.

use std::cmp::Ordering;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::motion::{Motion, Moved};
use super::object::MorphObject;
use super::plan::Morph;
use super::stti::{MorphAttribute, Transfer};
use crate::attribute::{AffineVector, Attribute, Sampler, Straight};
use crate::distance::Distance;
use crate::field::{BATCH, Evaluator, Field, Gradients, Points};

/// Steps along a normal at most. Three are enough where the field is smooth; a field that is flat inside its surface, as
/// a morph's is beside its ends, is first left by one long step and then met from outside.
const STEPS: usize = 8;
/// The least slope along a normal that counts, against the whole slope. Beside an edge F may fall along the other face's
/// normal, and the line along the foot's may miss the surface by a hair. Less: such a hair becomes a long way; more: many steps where a surface is met at an angle.
const LEAST_FALL: f32 = 0.7;
/// When the steps end, in voxels: a thousandth of a voxel a frame for instants a tenth of a frame away.
const TOLERANCE: f32 = 1e-4;

/// An instant near a frame. Their weights sum to 0, those times the seconds to 1: a derivative by differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Seconds from the frame.
    pub seconds: f64,
    /// The weight of what is there in the derivative at the frame, 1/seconds.
    pub weight: f64,
}

impl Instant {
    /// The derivative at a frame `step` seconds from the next instants: both before and after it, or on one side only.
    /// All are right to second order.
    pub fn around(step: f64, side: Option<Ordering>) -> Vec<Self> {
        let at = |place: f64, weight: f64| Self { seconds: place * step, weight: weight / step };
        match side {
            None | Some(Ordering::Equal) => vec![at(-1.0, -0.5), at(1.0, 0.5)],
            Some(Ordering::Greater) => vec![at(0.0, -1.5), at(1.0, 2.0), at(2.0, -0.5)],
            Some(Ordering::Less) => vec![at(0.0, 1.5), at(-1.0, -2.0), at(-2.0, 0.5)],
        }
    }
}

/// An instant near a frame, and what there is then.
#[derive(Clone)]
pub struct Around {
    /// When.
    pub instant: Instant,
    /// The field. Only its zero set counts.
    pub field: Arc<dyn Field>,
    /// The way from each point of the frame to where the objects' own motion has it then, world units; `None` where
    /// they are at rest.
    pub own: Option<Arc<dyn Attribute<3>>>,
}

/// How a frame's surface moves.
#[derive(Clone)]
pub struct Movement {
    /// What there is at instants around the frame.
    pub around: Vec<Around>,
    /// What files say of the velocity at points of the surface, world units a second: on top of all else.
    pub given: Option<Arc<dyn Attribute<3>>>,
    /// The greatest speed, world units a second: faster surfaces are held to it.
    pub max_speed: f64,
    /// The greatest speed along the normal beside the objects' own motion, world units a second. Where pieces meet, part
    /// or vanish that has no limit, and what is fast is carried far outward.
    pub max_change: f64,
    /// Seconds that a frame lasts.
    pub frame_seconds: f64,
}

impl Movement {
    /// A meter for one thread. `voxel` is a voxel's edge, world units.
    pub fn meter(&self, voxel: f64) -> Meter<'_> {
        Meter {
            around: self.around.iter().map(Then::new).collect(),
            given: self.given.as_ref().map(|given| given.sampler()),
            max_speed: self.max_speed,
            max_change: self.max_change,
            tolerance: TOLERANCE * voxel as f32,
            carried: Points::new(DVec3::ZERO),
            moved: Points::new(DVec3::ZERO),
            gradients: Gradients::new(),
            own: [[0.0; 3]; BATCH],
            along: [0.0; BATCH],
        }
    }
}

/// [`Around`] on one thread.
struct Then<'a> {
    instant: Instant,
    evaluator: Box<dyn Evaluator + 'a>,
    own: Option<Box<dyn Sampler<3> + 'a>>,
}

impl<'a> Then<'a> {
    fn new(around: &'a Around) -> Self {
        let own = around.own.as_ref().map(|own| own.sampler());
        Self { instant: around.instant, evaluator: around.field.evaluator(), own }
    }
}

/// Measures velocities on one thread.
pub struct Meter<'a> {
    around: Vec<Then<'a>>,
    given: Option<Box<dyn Sampler<3> + 'a>>,
    max_speed: f64,
    max_change: f64,
    tolerance: f32,
    carried: Points,
    moved: Points,
    gradients: Gradients,
    own: [[f32; 3]; BATCH],
    along: [f32; BATCH],
}

impl Meter<'_> {
    /// The velocities at surface points with these outward unit normals, world units a second, and whether each was
    /// held to a greatest speed.
    pub fn velocities(
        &mut self,
        feet: &Points,
        outward: &[Vec3],
        out: &mut [[f32; 3]; BATCH],
        held: &mut [bool; BATCH],
    ) {
        let len = feet.len;
        held[..len].fill(false);
        let (mut own, mut along) = ([DVec3::ZERO; BATCH], [0.0; BATCH]);
        for number in 0..self.around.len() {
            let Instant { seconds, weight } = self.around[number].instant;
            let limit = (self.max_change * seconds.abs()) as f32;
            self.find(number, limit, feet, outward);
            for i in 0..len {
                own[i] += DVec3::from_array(self.own[i].map(f64::from)) * weight;
                along[i] += f64::from(self.along[i]) * weight;
                held[i] |= limit > 0.0 && self.along[i].abs() >= limit;
            }
        }
        if let Some(given) = &mut self.given
            && let Some(region) = feet.bounding_box()
        {
            given.enter(&region);
            given.sample(feet, &mut self.own);
            given.leave();
            for (own, given) in own.iter_mut().zip(&self.own).take(len) {
                *own += DVec3::from_array(given.map(f64::from));
            }
        }
        for i in 0..len {
            let change = along[i].clamp(-self.max_change, self.max_change);
            let whole = own[i] + outward[i].as_dvec3() * change;
            let speed = whole.length();
            held[i] |= change != along[i] || speed > self.max_speed;
            let factor = if speed > self.max_speed { self.max_speed / speed } else { 1.0 };
            out[i] = (whole * factor).as_vec3().to_array();
        }
    }

    /// Where the surface of an instant lies on the normals through the feet as they are carried there.
    fn find(&mut self, number: usize, limit: f32, feet: &Points, outward: &[Vec3]) {
        let Then { evaluator, own, .. } = &mut self.around[number];
        self.carried.clone_from(feet);
        self.own[..feet.len].fill([0.0; 3]);
        if let Some(own) = own {
            own.sample(feet, &mut self.own);
            for i in 0..feet.len {
                self.carried.x[i] += self.own[i][0];
                self.carried.y[i] += self.own[i][1];
                self.carried.z[i] += self.own[i][2];
            }
        }
        self.along.fill(0.0);
        // At the frame itself no surface moves out of reach.
        let limit = if limit > 0.0 { limit } else { f32::INFINITY };
        for _ in 0..STEPS {
            self.moved.clone_from(&self.carried);
            for i in 0..feet.len {
                self.moved.x[i] += outward[i].x * self.along[i];
                self.moved.y[i] += outward[i].y * self.along[i];
                self.moved.z[i] += outward[i].z * self.along[i];
            }
            evaluator.gradients(&self.moved, &mut self.gradients);
            let mut longest = 0.0f32;
            for i in 0..feet.len {
                let (value, gradient) = (self.gradients.value[i], self.gradients.gradient(i));
                let slope = gradient.length();
                if value.abs() <= self.tolerance * slope {
                    continue;
                }
                let falls = (-gradient.dot(outward[i])).max(LEAST_FALL * slope);
                let next = (self.along[i] + value / falls).clamp(-limit, limit);
                if next.is_finite() {
                    longest = longest.max((next - self.along[i]).abs());
                    self.along[i] = next;
                }
            }
            if longest < self.tolerance {
                break;
            }
        }
    }
}

impl Morph {
    /// The field at scene time τ from the objects' distances also at the ends, where [`Morph::field`] has the objects
    /// themselves: fields of neighbouring times whose zero sets differ by the change alone.
    pub fn moving_field(&self, time: f64) -> Arc<dyn Field> {
        let placed = |object: &MorphObject| Arc::new(Moved::new(object.distance.clone(), object.motion.at(time)));
        let t = self.time_at(time);
        if t <= 0.0 {
            self.extruded(placed(&self.from), time)
        } else if t >= 1.0 {
            self.extruded(placed(&self.to), time)
        } else {
            self.field(time)
        }
    }

    /// The way from where points of the objects are at scene time τ to where their own motion has them `later`. `None`
    /// where both are at rest. In between both objects' ways are mixed by STTI's weights, as far as the shape is on its
    /// way.
    pub fn own_way(&self, time: f64, later: f64) -> Option<Arc<dyn Attribute<3>>> {
        if self.from.motion.is_still() && self.to.motion.is_still() {
            return None;
        }
        let of = |motion: &Motion| AffineVector::of_move(motion.at(time).to_affine(), motion.at(later).to_affine());
        let (from, to) = (of(&self.from.motion), of(&self.to.motion));
        let distance = |object: &MorphObject| -> Arc<dyn Distance> {
            Arc::new(Moved::new(object.distance.clone(), object.motion.at(time)))
        };
        let t = self.time_at(time);
        if t <= 0.0 {
            return Some(Arc::new(from));
        }
        if t >= 1.0 {
            return Some(Arc::new(to));
        }
        Some(Arc::new(MorphAttribute {
            first: distance(&self.from),
            second: distance(&self.to),
            from: Arc::new(from),
            to: Arc::new(to),
            unit: self.plan().unit,
            transfer: Transfer {
                time: self.settings.share(time),
                alpha: self.settings.alpha.at(time),
                beta: self.settings.beta.at(time),
            },
            delay: self.delay.clone(),
            mix: Straight,
        }))
    }
}
