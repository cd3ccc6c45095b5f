//! Values by depth: rings where a solid is cut.

use std::sync::Arc;

use super::{Attribute, Sampler, around};
use crate::field::{Aabb, BATCH, Evaluator, Field, Interval, Points};

/// Values in turn, each from one depth of a field to the next.
pub struct Bands<const N: usize> {
    field: Arc<dyn Field>,
    bands: Vec<(f64, [f32; N])>,
    tolerance: f64,
}

impl<const N: usize> Bands<N> {
    /// Values with the depths, values of the field (world units, positive inside), at which they begin, rising; before the
    /// first one, the first's. Points no further than `tolerance`, world units, before a band are in it: those on a
    /// surface are a rounding error off to either side. `None` where the values do not rise or there are none.
    pub fn new(field: Arc<dyn Field>, bands: Vec<(f64, [f32; N])>, tolerance: f64) -> Option<Self> {
        let rising = bands.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let sound = rising && !bands.is_empty() && bands.iter().all(|band| band.0.is_finite());
        sound.then_some(Self { field, bands, tolerance })
    }
}

impl<const N: usize> Attribute<N> for Bands<N> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(BandsSampler { bands: self, evaluator: self.field.evaluator(), values: [0.0; BATCH] })
    }
}

struct BandsSampler<'a, const N: usize> {
    bands: &'a Bands<N>,
    evaluator: Box<dyn Evaluator + 'a>,
    values: [f32; BATCH],
}

impl<const N: usize> Sampler<N> for BandsSampler<'_, N> {
    // No region is entered: pruning keeps a field's zero set, but here its values count.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        self.evaluator.values(points, &mut self.values);
        let Bands { bands, tolerance, .. } = self.bands;
        for (value, out) in self.values[..points.len].iter().zip(out) {
            let depth = f64::from(*value) + tolerance;
            let begun = bands.partition_point(|(begin, _)| *begin <= depth);
            *out = bands[begun.saturating_sub(1)].1;
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
    use crate::field::{Expression, Graph};

    #[test]
    fn each_band_from_its_depth_to_the_next() {
        let mut graph = Graph::new();
        let x = graph.x();
        let field: Arc<dyn Field> = Arc::new(Expression::new(&graph, x));
        let grey = |i: u8| [f32::from(i); 3];
        let bands = vec![(0.0, grey(0)), (0.5, grey(1)), (2.0, grey(2))];
        let colour = Bands::new(Arc::clone(&field), bands, 0.01).expect("bands");
        let mut points = Points::new(DVec3::ZERO);
        [-9.0, -0.001, 0.4, 0.495, 0.6, 1.9, 2.0, 99.0].iter().for_each(|x| points.push(Vec3::new(*x, 0.0, 0.0)));
        let mut out = [[0.0; 3]; BATCH];
        colour.sampler().sample(&points, &mut out);
        let found: Vec<f32> = out[..8].iter().map(|colour| colour[0]).collect();
        assert_eq!(found, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0]);
        for bad in [vec![], vec![(1.0, grey(0)), (1.0, grey(1))], vec![(f64::NAN, grey(0))]] {
            assert!(Bands::new(Arc::clone(&field), bad, 0.0).is_none());
        }
    }
}
