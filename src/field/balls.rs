//! The union of balls, a million and more of them: the exact distance outside.

use glam::DVec3;

use super::part::{Parts, Sample};
use super::{Aabb, Slope};

/// Balls of any radii.
pub struct Balls(Vec<(DVec3, f64)>);

impl Balls {
    /// Balls by centre and radius, at least one.
    pub fn new(all: Vec<(DVec3, f64)>) -> Self {
        Self(all)
    }
}

impl Parts for Balls {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn part(&self, index: usize, position: DVec3) -> Sample {
        let (centre, radius) = self.0[index];
        let away = position - centre;
        let distance = away.length();
        let direction = if distance > 0.0 { away / distance } else { DVec3::X };
        (radius - distance, -direction)
    }

    fn core(&self, index: usize) -> Option<(Aabb, f64)> {
        let (centre, radius) = self.0[index];
        Some((Aabb::new(centre, centre), radius))
    }

    fn bounding_box(&self) -> Option<Aabb> {
        self.0.iter().map(|(centre, radius)| Aabb::new(*centre, *centre).grown(*radius)).reduce(Aabb::union)
    }

    /// Outside of a union the nearest ball is as far; inside, a wall that another ball covers does not count.
    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: self.0.len() == 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;
    use crate::field::{BATCH, Field, Joined, Points};

    /// The tree gives the bits of all balls, one by one: of equal and of very different radii, of balls in one place, in
    /// regions of any size and without any.
    #[test]
    fn the_tree_gives_what_all_balls_give() {
        let mut samples = Samples::new(5);
        let cube = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        for kind in 0..3 {
            let mut all: Vec<(DVec3, f64)> = (0..3000)
                .map(|i| {
                    let radius = [0.02, 0.5 * samples.next().powi(12) + 1e-3, 0.02][kind];
                    // Of the last kind, ten at each of 300 places.
                    let centre = if kind == 2 && i % 10 != 0 { None } else { Some(samples.within(&cube)) };
                    (centre.unwrap_or(DVec3::NAN), radius)
                })
                .collect();
            for i in 1..all.len() {
                if all[i].0.is_nan() {
                    all[i].0 = all[i - 1].0;
                }
            }
            let field = Joined::new(Balls::new(all));
            let mut evaluator = field.evaluator();
            for _ in 0..40 {
                let centre = samples.within(&cube);
                let outer = Aabb::new(centre, centre).grown(0.7 * samples.next());
                let inner = Aabb::new(centre, centre).grown(outer.size().x * 0.01);
                for region in [None, Some(outer), Some(inner)] {
                    if let Some(region) = region {
                        evaluator.enter(&region);
                    }
                    let mut points = Points::new(centre);
                    (0..8).for_each(|i| points.push((inner.corners()[i] - centre).as_vec3()));
                    let mut values = [0.0; BATCH];
                    evaluator.values(&points, &mut values);
                    for i in 0..8 {
                        let wanted = field.reference(points.position(i));
                        assert_eq!(values[i], wanted as f32, "{kind} at {centre}");
                        assert!(region.is_none() || evaluator.bounds().contains(wanted), "{kind} at {centre}");
                    }
                }
                evaluator.leave();
                evaluator.leave();
            }
        }
    }
}
