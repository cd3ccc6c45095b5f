//! Noise: numbers from 0 to 1 that look like chance and are the same on every machine, for they come from whole numbers.
//!
//! Each kind is one file. It gives value and gradient at a position, in cells of edge 1, and how steep it is at most, from which
//! bounds over a box follow. Arithmetic is `+ − × ÷ √` in `f64`, point by point: the same bits at every vector width.

mod fractal;
mod gradient;
pub(super) mod hash;
mod simplex;
mod value;
mod worley;

use glam::{DVec3, I64Vec3};

use super::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

pub use fractal::{Fold, Fractal};
pub use gradient::GradientNoise;
pub use simplex::Simplex;
pub use value::ValueNoise;
pub use worley::{Near, Worley};

/// A kind of noise.
pub trait Noise: Send + Sync {
    /// Value, 0 to 1, and gradient at a position.
    fn at(&self, position: DVec3) -> (f64, DVec3);

    /// It is nowhere steeper.
    fn steepest(&self) -> f64;

    /// Bounds over a box.
    fn bounds(&self, region: &Aabb) -> Interval {
        near(self.at(region.centre()).0, self.steepest() * region.size().length() / 2.0)
    }
}

/// No farther from a value than this, nor out of 0 to 1.
fn near(value: f64, reach: f64) -> Interval {
    if reach.is_nan() || value.is_nan() {
        return Interval::ALL;
    }
    Interval::new((value - reach).max(0.0).next_down(), (value + reach).min(1.0).next_up())
}

/// Noise as a field: its cells have edge 1.
pub struct NoiseField<N>(pub N);

impl<N: Noise> Field for NoiseField<N> {
    fn bounding_box(&self) -> Option<Aabb> {
        None
    }

    fn slope(&self) -> Slope {
        Slope::Lipschitz(self.0.steepest())
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.0.at(position).0
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(NoiseEvaluator { noise: &self.0, regions: Vec::new() })
    }
}

struct NoiseEvaluator<'a, N> {
    noise: &'a N,
    regions: Vec<Aabb>,
}

impl<N: Noise> Evaluator for NoiseEvaluator<'_, N> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
    }

    fn bounds(&mut self) -> Interval {
        self.regions.last().map_or(Interval::ALL, |region| self.noise.bounds(region))
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            *out = self.noise.at(points.position(i)).0 as f32;
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        for i in 0..points.len {
            out.set(i, self.noise.at(points.position(i)));
        }
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { keeps_values: true, ..Hints::NONE }
    }
}

/// The cell of a position, and where in it the position is; `None` where it is nowhere.
fn cell_of(position: DVec3) -> Option<(I64Vec3, DVec3)> {
    let base = position.floor();
    base.is_finite().then(|| (numbered(base), position - base))
}

/// The number of a cell by its least corner. Beyond what can be numbered, where neighbours are one number, it is the last.
fn numbered(corner: DVec3) -> I64Vec3 {
    const MOST: DVec3 = DVec3::splat(4e18);
    corner.clamp(-MOST, MOST).as_i64vec3()
}

/// The corners of a cell, each with the weight of its number at a place within, and the gradient of that.
fn corners(within: DVec3) -> impl Iterator<Item = (I64Vec3, f64, DVec3)> {
    let [x, y, z] = within.to_array().map(fade);
    (0..8).map(move |corner| {
        let by = I64Vec3::new(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        let weight =
            |(share, slope): (f64, f64), far: i64| if far == 1 { (share, slope) } else { (1.0 - share, -slope) };
        let [(wx, sx), (wy, sy), (wz, sz)] = [weight(x, by.x), weight(y, by.y), weight(z, by.z)];
        (by, wx * wy * wz, DVec3::new(sx * wy * wz, wx * sy * wz, wx * wy * sz))
    })
}

/// 6t⁵ − 15t⁴ + 10t³, and its slope: at most 15/8.
fn fade(t: f64) -> (f64, f64) {
    let rest = t * (t - 1.0);
    (t * t * t * (t * (t * 6.0 - 15.0) + 10.0), 30.0 * rest * rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;

    fn each(mut visit: impl FnMut(&str, &dyn Noise)) {
        visit("value", &ValueNoise { seed: 1 });
        visit("gradient", &GradientNoise { seed: 2 });
        visit("simplex", &Simplex { seed: 3 });
        for near in [Near::First, Near::Second, Near::Edge] {
            visit("worley", &Worley { seed: 4, near });
        }
        for fold in [Fold::Plain, Fold::Ridged, Fold::Turbulence] {
            visit("fractal", &Fractal { seed: 5, octaves: 5, fold });
        }
    }

    #[test]
    fn values_gradients_and_bounds_agree() {
        each(|name, noise| {
            let mut samples = Samples::new(9);
            let world = Aabb::new(DVec3::splat(-40.0), DVec3::splat(40.0));
            let (mut least, mut most, mut compared) = (1.0_f64, 0.0_f64, 0);
            for _ in 0..20_000 {
                let p = samples.within(&world);
                let (value, slope) = noise.at(p);
                assert!((0.0..=1.0).contains(&value), "{name} at {p}: {value}");
                (least, most) = (least.min(value), most.max(value));
                assert!(slope.length() <= noise.steepest() * (1.0 + 1e-9), "{name}: {} at {p}", slope.length());
                let differences = |step: f64| {
                    let along = |axis| (noise.at(p + axis * step).0 - noise.at(p - axis * step).0) / (2.0 * step);
                    DVec3::from_array(DVec3::AXES.map(along))
                };
                let (fine, coarse) = (differences(1e-5), differences(5e-5));
                if (fine - coarse).length() < 1e-4 {
                    assert!((fine - slope).length() < 1e-3, "{name} at {p}: {slope}, {fine}");
                    compared += 1;
                }
            }
            assert!(compared > 15_000 && most - least > 0.4, "{name}: {compared}, {least} to {most}");
            for _ in 0..500 {
                let size = 2.0 * 0.5_f64.powf(8.0 * samples.next());
                let min = samples.within(&world);
                let region = Aabb::new(min, min + size);
                let bounds = noise.bounds(&region);
                for _ in 0..30 {
                    let value = noise.at(samples.within(&region)).0;
                    assert!(bounds.contains(value), "{name}: {value} is not in {bounds:?}");
                }
            }
        });
    }

    /// Walls between cells do not show.
    #[test]
    fn it_is_continuous_across_cells() {
        each(|name, noise| {
            let mut samples = Samples::new(2);
            for _ in 0..2000 {
                let mut p = samples.within(&Aabb::new(DVec3::splat(-5.0), DVec3::splat(5.0)));
                let axis = (samples.next() * 3.0) as usize;
                p[axis] = p[axis].round();
                let step = DVec3::AXES[axis] * 1e-9;
                let (before, after) = (noise.at(p - step).0, noise.at(p + step).0);
                assert!((before - after).abs() < 1e-7, "{name} at {p}: {before}, {after}");
            }
        });
    }

    /// Fixed for ever: frames of one shot come from machines of different kinds.
    #[test]
    fn it_is_the_same_on_every_machine() {
        let p = DVec3::new(1.25, -7.5, 1000.125);
        let bits = |noise: &dyn Noise| noise.at(p).0.to_bits();
        let found = [
            bits(&ValueNoise { seed: 1 }),
            bits(&GradientNoise { seed: 1 }),
            bits(&Simplex { seed: 1 }),
            bits(&Worley { seed: 1, near: Near::First }),
            bits(&Fractal { seed: 1, octaves: 4, fold: Fold::Plain }),
        ];
        assert_eq!(found, KNOWN);
        assert_ne!(ValueNoise { seed: 1 }.at(p), ValueNoise { seed: 2 }.at(p));
    }

    const KNOWN: [u64; 5] = [
        4_603_209_091_401_308_656,
        4_600_067_886_723_937_032,
        4_602_811_340_617_320_211,
        4_595_154_306_718_172_921,
        4_602_285_910_179_265_378,
    ];
}
