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

impl Components {
    /// The colour that three numbers stand for. Encoded red, green and blue, saturation and value are held to 0…1,
    /// scene-linear numbers to 0 and above; a hue may be any number of degrees. Where one of them is not a number,
    /// or a hue is infinite, they come back as they are: no colour.
    pub fn colour(self, numbers: [f32; 3]) -> LinearRgb {
        let [hue, saturation, value] = numbers;
        if numbers.iter().any(|number| number.is_nan()) {
            return numbers;
        }
        match self {
            Self::Linear => numbers.map(|number| number.max(0.0)),
            Self::Srgb => from_srgb(numbers.map(|number| number.clamp(0.0, 1.0))),
            Self::Hsv if hue.is_finite() => {
                ColourSpace::Hsv.decode([hue, saturation.clamp(0.0, 1.0), value.clamp(0.0, 1.0)])
            }
            Self::Hsv => numbers,
        }
    }
}

/// A colour whose components are fields.
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
            *out = self.meaning.colour(self.values.each_ref().map(|values| values[i]));
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

    #[test]
    fn numbers_out_of_range_are_held_and_what_is_no_number_stays_none() {
        assert_eq!(Components::Linear.colour([-1.0, 0.5, 7.0]), [0.0, 0.5, 7.0]);
        assert_eq!(Components::Srgb.colour([-1.0, 2.0, f32::INFINITY]), [0.0, 1.0, 1.0]);
        assert_eq!(Components::Hsv.colour([-120.0, 2.0, 1.5]), Components::Hsv.colour([240.0, 1.0, 1.0]));
        for meaning in [Components::Linear, Components::Srgb, Components::Hsv] {
            for place in 0..3 {
                let mut numbers = [0.5; 3];
                numbers[place] = f32::NAN;
                assert!(meaning.colour(numbers)[place].is_nan(), "{meaning:?}");
            }
        }
        assert_eq!(Components::Hsv.colour([f32::INFINITY, 0.5, 0.5]), [f32::INFINITY, 0.5, 0.5]);
    }
}
