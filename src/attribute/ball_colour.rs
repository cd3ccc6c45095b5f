//! The colours of balls, everywhere in space: that of the ball whose surface is nearest, or whose inside is deepest.

use std::sync::Arc;

use super::{Attribute, LinearRgb};
use crate::field::{Aabb, BATCH, Balls, Joined, Points};

/// Colour of the nearest of some balls.
pub struct BallColours {
    balls: Arc<Joined<Balls>>,
    /// One each.
    colours: Vec<LinearRgb>,
}

impl BallColours {
    /// As many colours as there are balls.
    pub fn new(balls: Arc<Joined<Balls>>, colours: Vec<LinearRgb>) -> Self {
        Self { balls, colours }
    }
}

impl Attribute<3> for BallColours {
    fn sampler(&self) -> Box<dyn super::Sampler<3> + '_> {
        Box::new(Sampler(self))
    }
}

struct Sampler<'a>(&'a BallColours);

impl super::Sampler<3> for Sampler<'_> {
    fn enter(&mut self, _: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        for (i, colour) in out.iter_mut().enumerate().take(points.len) {
            *colour = self.0.colours[self.0.balls.best_part(points.position(i))];
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;

    /// Balls whose colours are their centres, few and many.
    #[test]
    fn the_colour_of_the_nearest_ball() {
        for count in [20, 2000] {
            let centre = |i: usize| {
                let i = i as f64;
                DVec3::new(libm::sin(i), libm::cos(1.7 * i), libm::sin(0.3 * i))
            };
            let balls = Arc::new(Joined::new(Balls::new((0..count).map(|i| (centre(i), 0.01)).collect())));
            let colours = (0..count).map(|i| centre(i).as_vec3().to_array()).collect();
            let source = BallColours::new(balls, colours);
            let mut points = Points::new(DVec3::ZERO);
            (0..512)
                .for_each(|i| points.push(Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32) * 0.3 - 1.0));
            let mut out = [[0.0; 3]; BATCH];
            source.sampler().sample(&points, &mut out);
            for i in 0..points.len {
                let p = points.position(i);
                let nearest = (0..count).min_by(|a, b| centre(*a).distance(p).total_cmp(&centre(*b).distance(p)));
                assert_eq!(out[i], centre(nearest.unwrap()).as_vec3().to_array());
            }
        }
    }
}
