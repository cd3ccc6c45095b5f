//! Whether triangles are as close to a field's surface as they are to be.
//!
//! A point is within a distance of the surface if F has different signs at the ends of a line of that length to both
//! sides of it: F is continuous, so the surface is between them. This needs no distance, and bounds the true one from
//! above. Triangles are looked at in points half a voxel apart and less.

use glam::DVec3;

use crate::field::{BATCH, Evaluator, Field, Gradients, Points};

/// How far apart the points are in which a triangle is looked at, of its longest side: with corners within the distance it is
/// tilted against the surface by about two distances to that side, so that points between are out by a sixteenth more.
const SPACING: f64 = 1.0 / 16.0;
/// The least and the most of it, in voxels. The surface is not known finer than to a voxel.
const SPACINGS: [f64; 2] = [0.125, 0.5];

/// The least height of a triangle, in voxels: of a flatter one rounding says where it faces.
const LEAST_HEIGHT: f64 = 0.01;

/// Looks for the surface of a field in a distance.
pub struct Within<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    /// World units.
    distance: f64,
    /// A voxel's edge, world units.
    voxel: f64,
}

/// A point of a triangle.
struct Sample {
    at: DVec3,
    /// The triangle's outward normal.
    normal: DVec3,
    triangle: usize,
}

impl<'a> Within<'a> {
    /// Distance and voxel in world units.
    pub fn new(field: &'a dyn Field, distance: f64, voxel: f64) -> Self {
        Self { evaluator: field.evaluator(), distance, voxel }
    }

    /// Of each triangle a point that is not within the distance, or where it does not face outward; `None` where all do.
    pub fn astray(&mut self, triangles: &[[DVec3; 3]]) -> Vec<Option<DVec3>> {
        let mut samples = Vec::new();
        let mut astray = vec![None; triangles.len()];
        for (number, corners) in triangles.iter().enumerate() {
            if !self.sample(number, *corners, &mut samples) {
                astray[number] = Some(corners[0]);
            }
        }
        // Points that are close to one another need little of F.
        samples.sort_by_cached_key(|sample| (sample.at / (8.0 * self.voxel)).floor().as_ivec3().to_array());
        for samples in samples.chunks(BATCH / 2) {
            let normals = samples.iter().map(|sample| (sample, sample.normal));
            let mut left = self.not_found(normals.collect());
            let places: Vec<DVec3> = left.iter().map(|(sample, _)| sample.at).collect();
            let outward = self.outward(&places);
            left = self.not_found(left.iter().zip(outward).map(|((sample, _), outward)| (*sample, outward)).collect());
            // Beside an edge, and twice beside a corner, F falls in the direction of another face a step below the triangle,
            // or above it where they are concave: the surface lies across the middle of both.
            for step in [-self.distance, self.distance] {
                left.iter_mut().for_each(|(sample, direction)| *direction = sample.normal);
                for _ in 0..2 {
                    let places: Vec<DVec3> = left.iter().map(|(sample, way)| sample.at + *way * step).collect();
                    let outward = self.outward(&places);
                    let middle = left
                        .iter()
                        .zip(outward)
                        .map(|((sample, way), out)| (*sample, (*way + out).normalize_or_zero()));
                    left = self.not_found(middle.collect());
                }
            }
            for (Sample { at, triangle, .. }, _) in left {
                astray[*triangle].get_or_insert(*at);
            }
        }
        astray
    }

    /// Those of some samples between whose sides in a direction the surface is not, or is the other way round.
    fn not_found<'s>(&mut self, samples: Vec<(&'s Sample, DVec3)>) -> Vec<(&'s Sample, DVec3)> {
        let (places, outward): (Vec<DVec3>, Vec<DVec3>) = samples.iter().map(|(sample, way)| (sample.at, *way)).unzip();
        let sides = self.both_sides(&places, &outward);
        let is_right =
            |((sample, way), sides): &((&Sample, DVec3), [f32; 2])| crosses(*sides) && way.dot(sample.normal) > 0.0;
        samples.into_iter().zip(sides).filter(|found| !is_right(found)).map(|(sample, _)| sample).collect()
    }

    /// The points of the surface that are next to some places in some directions, where it is within the distance.
    pub fn on_surface(&mut self, places: &[DVec3], outward: &[DVec3]) -> Vec<Option<DVec3>> {
        let mut found = vec![None; places.len()];
        for (first, (places, outward)) in
            (0..).step_by(BATCH / 2).zip(places.chunks(BATCH / 2).zip(outward.chunks(BATCH / 2)))
        {
            let sides = self.both_sides(places, outward);
            let crossed: Vec<usize> = (0..places.len()).filter(|i| crosses(sides[*i])).collect();
            let ends: Vec<([DVec3; 2], [f64; 2])> = crossed
                .iter()
                .map(|&i| {
                    let step = outward[i] * self.distance;
                    ([places[i] - step, places[i] + step], [sides[i][1], sides[i][0]].map(f64::from))
                })
                .collect();
            if !ends.is_empty() {
                let points = super::on_surface(&ends, self.evaluator.as_mut());
                crossed.into_iter().zip(points).for_each(|(i, (point, _))| found[first + i] = Some(point));
            }
        }
        found
    }

    /// F at the distance from some places, no more than half a batch, outward and inward.
    fn both_sides(&mut self, places: &[DVec3], outward: &[DVec3]) -> Vec<[f32; 2]> {
        if places.is_empty() {
            return Vec::new();
        }
        let both = places.iter().zip(outward).flat_map(|(place, outward)| {
            let step = *outward * self.distance;
            [*place + step, *place - step]
        });
        let points = Points::of_positions(&both.collect::<Vec<_>>());
        let mut values = Box::new([0.0; BATCH]);
        self.over(&points, |evaluator| evaluator.values(&points, &mut values));
        values[..points.len].as_chunks().0.to_vec()
    }

    /// Where F falls fastest at some places.
    fn outward(&mut self, places: &[DVec3]) -> Vec<DVec3> {
        if places.is_empty() {
            return Vec::new();
        }
        let points = Points::of_positions(places);
        let mut gradients = Box::new(Gradients::new());
        self.over(&points, |evaluator| evaluator.gradients(&points, &mut gradients));
        (0..points.len).map(|i| (-gradients.gradient(i).as_dvec3()).normalize_or_zero()).collect()
    }

    fn over(&mut self, points: &Points, act: impl FnOnce(&mut dyn Evaluator)) {
        let Some(region) = points.bounding_box() else { return };
        self.evaluator.enter(&region.grown(0.01 * self.voxel));
        act(self.evaluator.as_mut());
        self.evaluator.leave();
    }

    /// Points of a triangle in rows along its longest side; `false` where it is too flat to face anywhere.
    fn sample(&self, triangle: usize, [p, q, r]: [DVec3; 3], samples: &mut Vec<Sample>) -> bool {
        let lengths = [p.distance_squared(q), q.distance_squared(r), r.distance_squared(p)];
        let [a, b, c] = match lengths.iter().rposition(|length| lengths.iter().all(|other| length >= other)) {
            Some(1) => [q, r, p],
            Some(2) => [r, p, q],
            _ => [p, q, r],
        };
        let area = (b - a).cross(c - a);
        let (normal, longest) = (area.normalize_or_zero(), a.distance(b));
        if is_flat([a, b, c], self.voxel) {
            return false;
        }
        let [least, most] = SPACINGS.map(|spacing| spacing * self.voxel);
        let steps = |length: f64| (length / (SPACING * longest).clamp(least, most)).ceil().max(2.0);
        let rows = steps(area.length() / longest);
        samples.push(Sample { at: c, normal, triangle });
        for row in 0..rows as usize {
            let up = row as f64 / rows;
            let (from, to) = (a.lerp(c, up), b.lerp(c, up));
            let count = steps(from.distance(to)) as usize;
            samples.extend((0..=count).map(|i| Sample {
                at: from.lerp(to, i as f64 / count as f64),
                normal,
                triangle,
            }));
        }
        true
    }
}

/// Whether a triangle is too flat to face anywhere.
pub fn is_flat([a, b, c]: [DVec3; 3], voxel: f64) -> bool {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    (b - a).cross(c - a).length() <= LEAST_HEIGHT * voxel * longest
}

/// Whether the surface is between a place outside of it and one inside, of which these are the values.
fn crosses([outside, inside]: [f32; 2]) -> bool {
    outside < 0.0 && inside >= 0.0
}
