//! Heights over the plane, from the pixels of a picture: even between the middles of four, level beyond the outermost.

use glam::{DVec2, DVec3};

use super::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};
use crate::raster::Raster;

/// The numbers of a picture over the plane, whatever z: the picture is one unit wide around the origin.
pub struct Heights {
    raster: Raster,
    /// Least and greatest number of 2ᵏ by 2ᵏ pixels, for each k up to that of all; so many in a row.
    levels: Vec<(usize, Vec<[f32; 2]>)>,
    steepest: f64,
}

impl Heights {
    /// The heights of a picture.
    pub fn new(raster: Raster) -> Self {
        let pixel = |x: usize, y: usize| raster.pixel(x, y);
        let (mut width, mut height) = (raster.width(), raster.height());
        let first = (0..width * height).map(|i| [pixel(i % width, i / width); 2]).collect();
        let mut levels: Vec<(usize, Vec<[f32; 2]>)> = vec![(width, first)];
        while width.max(height) > 1 {
            let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
            let finer = &levels[levels.len() - 1].1;
            let of = |i: usize| {
                let (x, y) = (2 * (i % half_width), 2 * (i / half_width));
                let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
                let there = four.into_iter().filter(|(x, y)| *x < width && *y < height);
                there.map(|(x, y)| finer[y * width + x]).fold([f32::INFINITY, f32::NEG_INFINITY], both)
            };
            let coarser = (0..half_width * half_height).map(of).collect();
            (width, height) = (half_width, half_height);
            levels.push((width, coarser));
        }
        let steepest = raster.steepest() * raster.width() as f64;
        Self { raster, levels, steepest }
    }

    /// Bytes that heights of so many pixels take.
    pub const fn bytes(pixels: u64) -> u64 {
        pixels * 15
    }

    /// Height over width.
    pub fn aspect(&self) -> f64 {
        self.raster.height() as f64 / self.raster.width() as f64
    }

    /// A place in pixels from the picture's lower left corner.
    fn pixels(&self, place: DVec2) -> DVec2 {
        (place + DVec2::new(0.5, 0.5 * self.aspect())) * self.raster.width() as f64
    }

    fn sample(&self, position: DVec3) -> (f64, DVec3) {
        let at = self.pixels(position.truncate());
        let (value, [right, up]) = self.raster.between(at.x, at.y);
        (value, DVec3::new(right, up, 0.0) * self.raster.width() as f64)
    }

    /// Least and greatest height over a region.
    fn over(&self, region: &Aabb) -> Interval {
        let (low, high) = (self.pixels(region.min.truncate()), self.pixels(region.max.truncate()));
        if !(low.is_finite() && high.is_finite()) {
            return Interval::new(0.0, 1.0);
        }
        // All pixels whose middles are around.
        let ends = |low: f64, high: f64, count: usize| {
            let last = count as f64 - 1.0;
            [(low - 0.5).floor().clamp(0.0, last) as usize, (high - 0.5).ceil().clamp(0.0, last) as usize]
        };
        let [left, right] = ends(low.x, high.x, self.raster.width());
        let [bottom, top] = ends(low.y, high.y, self.raster.height());
        let longest = (right - left).max(top - bottom);
        let level = (usize::BITS - longest.leading_zeros()) as usize;
        let level = level.min(self.levels.len() - 1);
        let (width, blocks) = &self.levels[level];
        let mut all = [f32::INFINITY, f32::NEG_INFINITY];
        for y in bottom >> level..=top >> level {
            for x in left >> level..=right >> level {
                all = both(all, blocks[y * width + x]);
            }
        }
        // Between pixels rounding goes a little beyond them.
        const SLACK: f64 = 1e-12;
        Interval::new(f64::from(all[0]) - SLACK, f64::from(all[1]) + SLACK)
    }
}

fn both(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

impl Field for Heights {
    fn bounding_box(&self) -> Option<Aabb> {
        None
    }

    fn slope(&self) -> Slope {
        Slope::Lipschitz(self.steepest)
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.sample(position).0
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(HeightsEvaluator { heights: self, regions: Vec::new() })
    }
}

struct HeightsEvaluator<'f> {
    heights: &'f Heights,
    regions: Vec<Interval>,
}

impl Evaluator for HeightsEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(self.heights.over(region));
    }

    fn bounds(&mut self) -> Interval {
        self.regions.last().copied().unwrap_or(Interval::ALL)
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints::NONE
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        for (i, value) in out.iter_mut().enumerate().take(points.len) {
            *value = self.heights.sample(points.position(i)).0 as f32;
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        for i in 0..points.len {
            out.set(i, self.heights.sample(points.position(i)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;

    #[test]
    fn bounds_hold_over_any_region() {
        let (width, height) = (37, 22);
        let values = (0..width * height).map(|i| (0.5 + 0.5 * libm::sin(i as f64 * 1.7)) as f32).collect();
        let heights = Heights::new(Raster::new(width, values));
        let mut samples = Samples::new(3);
        let world = Aabb::new(DVec3::splat(-0.7), DVec3::splat(0.7));
        for _ in 0..300 {
            let centre = samples.within(&world);
            let region = Aabb::new(centre, centre).grown(0.5 * samples.next().powi(4));
            let bounds = heights.over(&region);
            for _ in 0..30 {
                assert!(bounds.contains(heights.reference(samples.within(&region))), "{region:?}");
            }
        }
        assert_eq!(heights.levels.last().unwrap().1.len(), 1);
    }
}
