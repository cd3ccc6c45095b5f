//! Values by depth: rings where a solid is cut.

use std::sync::Arc;

use super::{Attribute, Sampler, Scalar, around};
use crate::field::{Aabb, BATCH, Interval, Points};

/// Values in turn, each from one depth of a field to the next.
pub struct Bands<const N: usize> {
    depth: Arc<Scalar>,
    bands: Vec<(f64, [f32; N])>,
    tolerance: f64,
}

impl<const N: usize> Bands<N> {
    /// Values with the depths, world units, positive inside, at which they begin, rising; before the first one, the first's.
    /// Where the depth is not a number they are none either. Points no further than `tolerance`, world units, before a band are in it: those on a
    /// surface are a rounding error off to either side. `None` where the values do not rise or there are none.
    pub fn new(depth: Arc<Scalar>, bands: Vec<(f64, [f32; N])>, tolerance: f64) -> Option<Self> {
        let rising = bands.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let sound = rising && !bands.is_empty() && bands.iter().all(|band| band.0.is_finite());
        sound.then_some(Self { depth, bands, tolerance })
    }
}

impl<const N: usize> Attribute<N> for Bands<N> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(BandsSampler { bands: self, depth: self.depth.sampler(), depths: [[0.0]; BATCH] })
    }
}

struct BandsSampler<'a, const N: usize> {
    bands: &'a Bands<N>,
    depth: Box<dyn Sampler<1> + 'a>,
    depths: [[f32; 1]; BATCH],
}

impl<const N: usize> Sampler<N> for BandsSampler<'_, N> {
    // No region is entered: pruning keeps a field's zero set, but here its values count.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        self.depth.sample(points, &mut self.depths);
        let Bands { bands, tolerance, .. } = self.bands;
        for ([depth], out) in self.depths[..points.len].iter().zip(out) {
            let depth = f64::from(*depth) + tolerance;
            let begun = bands.partition_point(|(begin, _)| *begin <= depth);
            *out = if depth.is_nan() { [f32::NAN; N] } else { bands[begun.saturating_sub(1)].1 };
        }
    }

    /// Of all bands: how deep a point lies is told by values away from the surface, which entering a region may change.
    fn bounds(&mut self, _region: &Aabb) -> [Interval; N] {
        around(self.bands.bands.iter().map(|(_, values)| *values))
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::attribute::FieldValue;
    use crate::field::{Expression, Graph};

    #[test]
    fn each_band_from_its_depth_to_the_next() {
        let mut graph = Graph::new();
        let x = graph.x();
        let depth: Arc<Scalar> = Arc::new(FieldValue(Arc::new(Expression::new(&graph, x))));
        let grey = |i: u8| [f32::from(i); 3];
        let bands = vec![(0.0, grey(0)), (0.5, grey(1)), (2.0, grey(2))];
        let colour = Bands::new(Arc::clone(&depth), bands, 0.01).expect("bands");
        let mut points = Points::new(DVec3::ZERO);
        [-9.0, -0.001, 0.4, 0.495, 0.6, 1.9, 2.0, 99.0].iter().for_each(|x| points.push(Vec3::new(*x, 0.0, 0.0)));
        let mut out = [[0.0; 3]; BATCH];
        colour.sampler().sample(&points, &mut out);
        let found: Vec<f32> = out[..8].iter().map(|colour| colour[0]).collect();
        assert_eq!(found, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0]);
        for bad in [vec![], vec![(1.0, grey(0)), (1.0, grey(1))], vec![(f64::NAN, grey(0))]] {
            assert!(Bands::new(Arc::clone(&depth), bad, 0.0).is_none());
        }
    }
}
