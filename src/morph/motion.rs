//! An object's own motion: similarities over scene time, and fields, distances and colours seen through one.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Mat3};

use super::over_time::OverTime;
use crate::attribute::{Attribute, MappedSampler, Sampler, SpaceMap};
use crate::distance::{Distance, Foot};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

/// A uniform scale, then a rotation, then a translation: from an object's space to the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    scale: f64,
    rotation: DMat3,
    translation: DVec3,
}

impl Similarity {
    /// Leaves everything where it is.
    pub const IDENTITY: Self = Self { scale: 1.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// Scales about the origin, rotates about the fixed x, then y, then z axis by `degrees`, then moves. `None` where
    /// the scale is not a finite positive number or another number is not finite.
    pub fn new(scale: f64, degrees: DVec3, translation: DVec3) -> Option<Self> {
        let sound = scale.is_finite() && scale > 0.0 && degrees.is_finite() && translation.is_finite();
        sound.then(|| Self { scale, rotation: rotation_xyz(degrees), translation })
    }

    /// The factor by which lengths grow.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// As an affine map.
    pub fn to_affine(&self) -> DAffine3 {
        DAffine3 { matrix3: self.rotation * self.scale, translation: self.translation }
    }

    /// A position of the object, in the world.
    pub fn to_world(&self, position: DVec3) -> DVec3 {
        self.rotation * (position * self.scale) + self.translation
    }

    /// A world position, in the object's space.
    pub fn to_object(&self, position: DVec3) -> DVec3 {
        self.rotation.transpose() * (position - self.translation) / self.scale
    }

    /// The same within the plane z = 0, whatever it is moved along z; `None` where it turns z.
    pub fn in_plane(&self) -> Option<Self> {
        let Self { translation, .. } = *self;
        (self.rotation.z_axis == DVec3::Z).then_some(Self { translation: translation.with_z(0.0), ..*self })
    }

    /// The same without its scale.
    pub(super) fn rigid(&self) -> Self {
        Self { scale: 1.0, ..*self }
    }

    /// Where it turns z to.
    pub fn normal(&self) -> DVec3 {
        self.rotation.z_axis
    }

    /// How it turns.
    pub(super) fn rotation(&self) -> DMat3 {
        self.rotation
    }

    /// The same where all of the world is moved so.
    pub fn moved(&self, world: &Self) -> Self {
        if *world == Self::IDENTITY {
            return *self;
        }
        Self {
            scale: world.scale * self.scale,
            rotation: world.rotation * self.rotation,
            translation: world.to_world(self.translation),
        }
    }

    /// The same as seen from a frame that stands elsewhere.
    pub(super) fn seen_from(&self, frame: &Self) -> Self {
        if *frame == Self::IDENTITY {
            return *self;
        }
        let back = frame.rotation.transpose();
        Self {
            scale: self.scale / frame.scale,
            rotation: back * self.rotation,
            translation: back * (self.translation - frame.translation) / frame.scale,
        }
    }

    /// Turned about a place of the world, which then stands at another.
    pub(super) fn carried(&self, turn: DMat3, place: DVec3, to: DVec3) -> Self {
        Self { scale: self.scale, rotation: turn * self.rotation, translation: turn * (self.translation - place) + to }
    }

    /// The box around a moved box.
    pub fn box_to_world(&self, aabb: Aabb) -> Aabb {
        around(self.to_world(aabb.centre()), absolute(self.rotation) * (aabb.size() * 0.5) * self.scale)
    }

    /// The box, in the object's space, around a box of the world.
    pub fn box_to_object(&self, aabb: Aabb) -> Aabb {
        let half = absolute(self.rotation.transpose()) * (aabb.size() * 0.5) / self.scale;
        around(self.to_object(aabb.centre()), half)
    }
}

impl Default for Similarity {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// From the world to the object's space.
impl SpaceMap for Similarity {
    /// The origin in `f64`, the offsets in `f32`.
    fn points(&self, points: &Points, out: &mut Points) {
        out.origin = self.to_object(points.origin);
        out.len = points.len;
        let turn = Mat3::from_cols_array(&(self.rotation.transpose() * (1.0 / self.scale)).to_cols_array().map(to_f32));
        let (from, to) = ([&points.x, &points.y, &points.z], [&mut out.x, &mut out.y, &mut out.z]);
        if turn == Mat3::IDENTITY {
            to.into_iter().zip(from).for_each(|(to, from)| to[..points.len].copy_from_slice(&from[..points.len]));
        } else {
            rotate(turn, from, to, points.len);
        }
    }

    fn gradients(&self, len: usize, out: &mut Gradients) -> bool {
        turn_gradients(self.rotation * (1.0 / self.scale), len, out);
        true
    }

    fn region(&self, region: &Aabb) -> Aabb {
        self.box_to_object(*region)
    }
}

fn to_f32(value: f64) -> f32 {
    value as f32
}

/// The box around a centre, a few rounding errors larger than asked.
fn around(centre: DVec3, half: DVec3) -> Aabb {
    let half = half + (centre.abs() + half) * (8.0 * f64::EPSILON);
    Aabb::new(centre - half, centre + half)
}

fn absolute(matrix: DMat3) -> DMat3 {
    DMat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs())
}

/// About the fixed x, then y, then z axis.
fn rotation_xyz(degrees: DVec3) -> DMat3 {
    let [(sx, cx), (sy, cy), (sz, cz)] = degrees.to_array().map(sin_cos_degrees);
    let x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cx, sx), DVec3::new(0.0, -sx, cx));
    let y = DMat3::from_cols(DVec3::new(cy, 0.0, -sy), DVec3::Y, DVec3::new(sy, 0.0, cy));
    let z = DMat3::from_cols(DVec3::new(cz, sz, 0.0), DVec3::new(-sz, cz, 0.0), DVec3::Z);
    z * y * x
}

/// Sine and cosine, exact at quarter turns.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turned = degrees % 360.0;
    let quarter = (turned / 90.0).round();
    let (sin, cos) = libm::sincos((turned - quarter * 90.0).to_radians());
    match (quarter as i32).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[multiversion::multiversion(targets = "simd")]
fn rotate(turn: Mat3, from: [&[f32; BATCH]; 3], to: [&mut [f32; BATCH]; 3], len: usize) {
    let [x, y, z] = from;
    let [out_x, out_y, out_z] = to;
    for i in 0..len.min(BATCH) {
        [out_x[i], out_y[i], out_z[i]] = rotated(&turn, [x[i], y[i], z[i]]);
    }
}

/// Turns so many gradients, in place.
fn turn_gradients(turn: DMat3, len: usize, out: &mut Gradients) {
    if turn == DMat3::IDENTITY {
        return;
    }
    let turn = Mat3::from_cols_array(&turn.to_cols_array().map(to_f32));
    let Gradients { dx, dy, dz, .. } = out;
    rotate_in_place(turn, [dx, dy, dz], len);
}

#[multiversion::multiversion(targets = "simd")]
fn rotate_in_place(turn: Mat3, [x, y, z]: [&mut [f32; BATCH]; 3], len: usize) {
    for i in 0..len.min(BATCH) {
        [x[i], y[i], z[i]] = rotated(&turn, [x[i], y[i], z[i]]);
    }
}

/// A turn of one of many vectors that stand side by side, number by number.
#[inline(always)]
fn rotated(turn: &Mat3, [x, y, z]: [f32; 3]) -> [f32; 3] {
    [
        turn.x_axis.x * x + turn.y_axis.x * y + turn.z_axis.x * z,
        turn.x_axis.y * x + turn.y_axis.y * y + turn.z_axis.y * z,
        turn.x_axis.z * x + turn.y_axis.z * y + turn.z_axis.z * z,
    ]
}

/// Where an object stands at each scene time τ (0 at the shot's first frame, 1 at its last).
pub type Motion = OverTime<Similarity>;

/// A field, distance or attribute of an object's space, standing in the world.
pub struct Moved<T: ?Sized> {
    inner: Arc<T>,
    placement: Similarity,
}

impl<T: ?Sized> Moved<T> {
    /// `inner`, placed.
    pub fn new(inner: Arc<T>, placement: Similarity) -> Self {
        Self { inner, placement }
    }
}

impl<T: Field + ?Sized> Field for Moved<T> {
    fn bounding_box(&self) -> Option<Aabb> {
        self.inner.bounding_box().map(|aabb| self.placement.box_to_world(aabb))
    }

    fn slope(&self) -> Slope {
        self.inner.slope()
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.inner.reference(self.placement.to_object(position)) * self.placement.scale
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        let points = Points::new(DVec3::ZERO);
        Box::new(MovedEvaluator { inner: self.inner.evaluator(), placement: self.placement, points })
    }
}

impl<T: Distance + ?Sized> Distance for Moved<T> {
    fn closest_points(&self, positions: &[DVec3], closest: &mut [Foot]) -> bool {
        let Similarity { rotation, scale, .. } = self.placement;
        let within: Vec<DVec3> = positions.iter().map(|position| self.placement.to_object(*position)).collect();
        if !self.inner.closest_points(&within, closest) {
            return false;
        }
        for Foot { point, distance, gradient, .. } in closest {
            *point = self.placement.to_world(*point);
            *distance *= scale;
            *gradient = rotation * *gradient;
        }
        true
    }
}

impl<const N: usize, T: Attribute<N> + ?Sized> Attribute<N> for Moved<T> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(MappedSampler::new(self.inner.sampler(), self.placement))
    }
}

struct MovedEvaluator<'a> {
    inner: Box<dyn Evaluator + 'a>,
    placement: Similarity,
    points: Points,
}

impl MovedEvaluator<'_> {
    fn gradients_to_world(&self, out: &mut Gradients) {
        self.values_to_world(&mut out.value);
        turn_gradients(self.placement.rotation, self.points.len, out);
    }

    fn values_to_world(&self, values: &mut [f32; BATCH]) {
        let scale = self.placement.scale as f32;
        if scale != 1.0 {
            values[..self.points.len].iter_mut().for_each(|value| *value *= scale);
        }
    }
}

impl Evaluator for MovedEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.inner.enter(&self.placement.box_to_object(*region));
    }

    fn bounds(&mut self) -> Interval {
        let bounds = self.inner.bounds();
        let scaled = Interval::new(bounds.lo * self.placement.scale, bounds.hi * self.placement.scale);
        if self.placement.scale == 1.0 { scaled } else { widened(scaled) }
    }

    /// Lengths grow as values do.
    fn hints(&mut self, asked: Hint) -> Hints {
        self.inner.hints(asked)
    }

    fn leave(&mut self) {
        self.inner.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.placement.points(points, &mut self.points);
        self.inner.values(&self.points, out);
        self.values_to_world(out);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.placement.points(points, &mut self.points);
        self.inner.gradients(&self.points, out);
        self.gradients_to_world(out);
    }

    fn branches(&self) -> usize {
        self.inner.branches()
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        self.placement.points(points, &mut self.points);
        self.inner.branch(branch, &self.points, out);
        self.gradients_to_world(out);
    }
}

fn widened(interval: Interval) -> Interval {
    let margin = |value: f64| value.abs() * (4.0 * f64::EPSILON);
    Interval::new(interval.lo - margin(interval.lo), interval.hi + margin(interval.hi))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::testing::{Hinted, assert_passes_hints_on};

    #[test]
    fn hints_are_passed_on() {
        let placement = Similarity::new(1.0, DVec3::new(0.0, 30.0, 90.0), DVec3::ZERO).expect("a similarity");
        assert_passes_hints_on(&mut *Moved::new(Arc::new(Hinted), placement).evaluator());
    }
}
