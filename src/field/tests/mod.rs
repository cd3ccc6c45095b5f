//! Random solids, built twice: as an expression, and as plain closures written down independently. Every
//! evaluator is held against the one slow reference, and that against the closures.

#![allow(clippy::needless_range_loop, reason = "points, values and gradients are walked side by side")]

mod boxes;
mod external;
mod formulas;
mod offsets;
mod operations;
mod properties;
mod recipe;

use glam::DVec3;

use super::{Aabb, BATCH, Evaluator, Expression, Field, Gradients, Points, VectorWidth};

/// A small generator of repeatable numbers in 0..1.
pub(crate) struct Samples(u64);

impl Samples {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2).wrapping_add(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn within(&mut self, region: &Aabb) -> DVec3 {
        let share = DVec3::new(self.next(), self.next(), self.next());
        region.min + share * region.size()
    }

    /// A batch of points in a box, around its middle.
    pub fn batch(&mut self, region: &Aabb, len: usize) -> Points {
        let mut points = Points::new(region.centre());
        for _ in 0..len {
            let offset = self.within(region) - region.centre();
            points.push(offset.as_vec3());
        }
        points
    }
}

/// A gradient by central differences of the reference over two steps, where both agree: elsewhere there is a crease.
pub(crate) fn slope_at(field: &Expression, p: DVec3, [fine, coarse]: [f64; 2]) -> Option<DVec3> {
    let at = |step: f64| {
        let along = |axis: DVec3| (field.reference(p + axis * step) - field.reference(p - axis * step)) / (2.0 * step);
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    };
    let (fine, coarse) = (at(fine), at(coarse));
    ((fine - coarse).length() < 1e-4 * (1.0 + fine.length())).then_some(fine)
}

/// The bits of values, and of values and gradients, at each point, by each vector width.
pub(crate) fn bits_by_width(field: &Expression, points: &Points) -> [[Vec<u32>; 5]; 3] {
    VectorWidth::ALL.map(|width| {
        let mut evaluator = field.evaluator_of_width(width);
        let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
        evaluator.values(points, &mut values);
        evaluator.gradients(points, &mut gradients);
        let bits = |array: &[f32; BATCH]| array[..points.len].iter().map(|v| v.to_bits()).collect();
        [bits(&values), bits(&gradients.value), bits(&gradients.dx), bits(&gradients.dy), bits(&gradients.dz)]
    })
}
