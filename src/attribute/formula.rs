//! Colour by three formulas, scalars by one.

use std::hint::select_unpredictable;
use std::sync::Arc;

use super::colour_space::{LANES, Lanes, each};
use super::{Attribute, LinearRgb, Sampler, conversion};
use crate::field::lane_math::clamp01;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Interval, Points};

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
        self.convert(&numbers.map(|number| [number])).map(|[component]| component)
    }

    /// As [`Self::colour`]. Inlined, so that it is compiled for its caller's vector width.
    #[inline(always)]
    fn convert<const N: usize>(self, numbers: &Lanes<N>) -> Lanes<N> {
        // Elsewhere than the numbers, which may be kept: see `lane_math`.
        let mut colours = [[0.0; N]; 3];
        match self {
            Self::Linear => each!(numbers => colours, linear),
            Self::Srgb => each!(numbers => colours, srgb),
            Self::Hsv => each!(numbers => colours, hsv),
        }
        colours
    }
}

#[inline(always)]
fn linear(numbers: [f32; 3]) -> LinearRgb {
    let [a, b, c] = numbers;
    chosen(any_nan(numbers), numbers, [not_below_0(a), not_below_0(b), not_below_0(c)])
}

#[inline(always)]
fn srgb(numbers: [f32; 3]) -> LinearRgb {
    let [red, green, blue] = numbers;
    let colour = conversion::linear_of_srgb([clamp01(red), clamp01(green), clamp01(blue)]);
    chosen(any_nan(numbers), numbers, colour)
}

#[inline(always)]
fn hsv(numbers: [f32; 3]) -> LinearRgb {
    let [hue, saturation, value] = numbers;
    let colour = conversion::linear_of_hsv_up_to_1([hue, clamp01(saturation), clamp01(value)]);
    chosen(any_nan(numbers) | hue.is_infinite(), numbers, colour)
}

/// The first or else the second; see `lane_math` for why not by `if`.
#[inline(always)]
fn chosen(first: bool, [a, b, c]: [f32; 3], [d, e, f]: [f32; 3]) -> [f32; 3] {
    [select_unpredictable(first, a, d), select_unpredictable(first, b, e), select_unpredictable(first, c, f)]
}

#[inline(always)]
fn not_below_0(number: f32) -> f32 {
    select_unpredictable(number > 0.0, number, 0.0)
}

#[inline(always)]
fn any_nan([a, b, c]: [f32; 3]) -> bool {
    a.is_nan() | b.is_nan() | c.is_nan()
}

/// A colour whose components are fields.
pub struct ByFormula {
    /// One field a component.
    pub components: [Arc<dyn Field>; 3],
    /// What they are.
    pub meaning: Components,
}

impl Attribute<3> for ByFormula {
    fn sampler(&self) -> Box<dyn Sampler<3> + '_> {
        let evaluators = self.components.each_ref().map(|field| field.evaluator());
        Box::new(FormulaSampler { evaluators, meaning: self.meaning, values: [[0.0; BATCH]; 3] })
    }
}

struct FormulaSampler<'a> {
    evaluators: [Box<dyn Evaluator + 'a>; 3],
    meaning: Components,
    values: [[f32; BATCH]; 3],
}

impl Sampler<3> for FormulaSampler<'_> {
    // The fields enter no region: pruning keeps their zero sets, but here their values count.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        for (evaluator, values) in self.evaluators.iter_mut().zip(&mut self.values) {
            evaluator.values(points, values);
        }
        colours(self.meaning, &self.values, points.len, out);
    }
}

/// A scalar that is a field's value; one that keeps its values, so that its bounds are theirs.
pub struct FieldValue(pub Arc<dyn Field>);

impl Attribute<1> for FieldValue {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        Box::new(FieldSampler { evaluator: self.0.evaluator(), jumps: self.0.jumps(), values: [0.0; BATCH] })
    }
}

struct FieldSampler<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    jumps: bool,
    values: [f32; BATCH],
}

impl Sampler<1> for FieldSampler<'_> {
    // The field enters no region, as those of a colour.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        self.evaluator.values(points, &mut self.values);
        out.as_flattened_mut()[..points.len].copy_from_slice(&self.values[..points.len]);
    }

    fn gradients(&mut self, points: &Points, [out]: &mut [Gradients; 1]) -> bool {
        // Differences are steep across a jump: so a wall is found there.
        if !self.jumps {
            self.evaluator.gradients(points, out);
        }
        !self.jumps
    }

    fn bounds(&mut self, region: &Aabb) -> [Interval; 1] {
        self.evaluator.enter(region);
        let bounds = self.evaluator.bounds();
        self.evaluator.leave();
        [bounds]
    }
}

#[multiversion::multiversion(targets = "simd")]
fn colours(meaning: Components, numbers: &[[f32; BATCH]; 3], len: usize, out: &mut [LinearRgb; BATCH]) {
    for (at, out) in out.as_chunks_mut::<LANES>().0.iter_mut().enumerate().take(len.div_ceil(LANES)) {
        let mut lanes = [[0.0; LANES]; 3];
        for (lanes, numbers) in lanes.iter_mut().zip(numbers) {
            lanes.copy_from_slice(&numbers[at * LANES..][..LANES]);
        }
        let [red, green, blue] = meaning.convert(&lanes);
        for i in 0..LANES {
            out[i] = [red[i], green[i], blue[i]];
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::attribute::from_srgb;
    use crate::field::{Expression, Formula, Graph, Names};

    fn colour(texts: [&str; 3], meaning: Components, x: f32) -> LinearRgb {
        let components = texts.map(|text| -> Arc<dyn Field> {
            let mut graph = Graph::new();
            let names = Names::space(&mut graph);
            let node = Formula::parse(text).compile(&mut graph, &names).expect("a formula");
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
        let violet = colour(["x", "0", "1"], Components::Srgb, 0.5);
        assert!(violet.iter().zip(from_srgb([0.5, 0.0, 1.0])).all(|(a, b)| (a - b).abs() < 1e-6), "{violet:?}");
        let green = colour(["240*x", "1", "1"], Components::Hsv, 0.5);
        assert!(green[0] < 1e-6 && (green[1] - 1.0).abs() < 1e-6 && green[2] < 1e-6, "{green:?}");
    }

    /// The vector loops of this machine against one lane in the baseline's instructions: bit for bit.
    #[test]
    fn a_batch_is_converted_as_its_points() {
        for meaning in [Components::Linear, Components::Srgb, Components::Hsv] {
            let numbers: [[f32; BATCH]; 3] = [
                std::array::from_fn(|i| i as f32 * 3.7 - 400.0),
                std::array::from_fn(|i| (i * 7 % 512) as f32 / 500.0),
                std::array::from_fn(|i| (i * 5 % 512) as f32 / 490.0 - 0.02),
            ];
            let mut out = [[0.0; 3]; BATCH];
            colours(meaning, &numbers, BATCH, &mut out);
            for i in 0..BATCH {
                assert_eq!(out[i], meaning.colour(numbers.map(|numbers| numbers[i])), "{meaning:?} {i}");
            }
        }
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
