//! Colour by three formulas.

use std::sync::Arc;

use super::{Colour, ColourSampler, ColourSpace, LinearRgb, from_srgb};
use crate::field::{Aabb, BATCH, Evaluator, Field, Points};

/// What a formula's three numbers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// Scene-linear red, green, blue.
    Linear,
    /// sRGB-encoded red, green, blue, 0…1.
    Srgb,
    /// Hue in degrees, saturation and value, 0…1, of the sRGB-encoded colour.
    Hsv,
}

/// A colour whose components are fields. Their values are taken as they come, negative or not a number included.
pub struct ByFormula {
    /// One field a component.
    pub components: [Arc<dyn Field>; 3],
    /// What they are.
    pub meaning: Components,
}

impl Colour for ByFormula {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        let evaluators = self.components.each_ref().map(|field| field.evaluator());
        Box::new(FormulaSampler { evaluators, meaning: self.meaning, values: [[0.0; BATCH]; 3] })
    }
}

struct FormulaSampler<'a> {
    evaluators: [Box<dyn Evaluator + 'a>; 3],
    meaning: Components,
    values: [[f32; BATCH]; 3],
}

impl ColourSampler for FormulaSampler<'_> {
    // The fields enter no region: pruning keeps their zero sets, but here their values count.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        for (evaluator, values) in self.evaluators.iter_mut().zip(&mut self.values) {
            evaluator.values(points, values);
        }
        for (i, out) in out[..points.len].iter_mut().enumerate() {
            let numbers = self.values.each_ref().map(|values| values[i]);
            *out = match self.meaning {
                Components::Linear => numbers,
                Components::Srgb => from_srgb(numbers),
                Components::Hsv => ColourSpace::Hsv.decode(numbers),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::field::{Expression, Formula, Graph, Names};

    fn colour(texts: [&str; 3], meaning: Components, x: f32) -> LinearRgb {
        let components = texts.map(|text| -> Arc<dyn Field> {
            let mut graph = Graph::new();
            let names = Names::space(&mut graph);
            let node = Formula::parse(text).and_then(|formula| formula.compile(&mut graph, &names)).expect("a formula");
            Arc::new(Expression::new(&graph, node))
        });
        let mut points = Points::new(DVec3::ZERO);
        points.push(Vec3::new(x, 0.25, 0.0));
        let mut out = [[0.0; 3]; BATCH];
        let colour = ByFormula { components, meaning };
        let mut sampler = colour.sampler();
        sampler.enter(&Aabb::new(DVec3::splat(-9.0), DVec3::splat(9.0)));
        sampler.sample(&points, &mut out);
        sampler.leave();
        out[0]
    }

    #[test]
    fn three_formulas_are_a_colour() {
        assert_eq!(colour(["x", "y", "2*x + y"], Components::Linear, 0.5), [0.5, 0.25, 1.25]);
        assert_eq!(colour(["x", "0", "1"], Components::Srgb, 0.5), from_srgb([0.5, 0.0, 1.0]));
        let green = colour(["240*x", "1", "1"], Components::Hsv, 0.5);
        assert!(green[0] < 1e-6 && (green[1] - 1.0).abs() < 1e-6 && green[2] < 1e-6, "{green:?}");
    }
}
