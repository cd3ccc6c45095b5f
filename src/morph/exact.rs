//! Exact distances for tests: balls, blocks, tori and what keeps them exact.

use std::sync::Arc;

use glam::DVec3;

use crate::distance::nearest::ClosestPoint;
use crate::distance::{Distance, Foot};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

/// A solid whose signed distance is known in closed form.
#[derive(Clone, Debug)]
pub enum Exact {
    Ball {
        centre: DVec3,
        radius: f64,
    },
    Block {
        centre: DVec3,
        half: DVec3,
    },
    /// Around the z axis.
    Torus {
        large: f64,
        small: f64,
    },
    /// Solids that do not meet: the greatest of their distances.
    Apart(Vec<Exact>),
    /// What is within some thickness of a surface.
    Shell {
        of: Box<Exact>,
        half: f64,
    },
}

impl Exact {
    pub fn ball(x: f64, radius: f64) -> Arc<Self> {
        Arc::new(Self::Ball { centre: DVec3::new(x, 0.0, 0.0), radius })
    }

    pub fn block(x: f64, half: DVec3) -> Arc<Self> {
        Arc::new(Self::Block { centre: DVec3::new(x, 0.0, 0.0), half })
    }

    pub fn cube(x: f64, half: f64) -> Arc<Self> {
        Self::block(x, DVec3::splat(half))
    }

    pub fn torus(large: f64, small: f64) -> Arc<Self> {
        Arc::new(Self::Torus { large, small })
    }

    /// Signed distance, positive inside, and its gradient.
    fn at(&self, p: DVec3) -> (f64, DVec3) {
        match self {
            Self::Ball { centre, radius } => {
                let from = p - *centre;
                (radius - from.length(), -from.normalize_or(DVec3::X))
            }
            Self::Block { centre, half } => {
                let from = p - *centre;
                let beyond = from.abs() - *half;
                let sign = DVec3::select(from.cmplt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE);
                let outside = beyond.max(DVec3::ZERO);
                if outside != DVec3::ZERO {
                    return (-outside.length(), -outside.normalize() * sign);
                }
                let axis = (0..3).max_by(|a, b| beyond[*a].total_cmp(&beyond[*b])).unwrap_or(0);
                (-beyond[axis], -DVec3::AXES[axis] * sign)
            }
            Self::Torus { large, small } => {
                let ring = p.with_z(0.0).normalize_or(DVec3::X) * *large;
                let from = p - ring;
                (small - from.length(), -from.normalize_or(DVec3::Z))
            }
            Self::Apart(solids) => {
                let all = solids.iter().map(|solid| solid.at(p));
                all.max_by(|a, b| a.0.total_cmp(&b.0)).expect("solids")
            }
            Self::Shell { of, half } => {
                let (distance, gradient) = of.at(p);
                (half - distance.abs(), -gradient * distance.signum())
            }
        }
    }

    fn own_box(&self) -> Aabb {
        match self {
            Self::Ball { centre, radius } => Aabb::new(*centre - *radius, *centre + *radius),
            Self::Block { centre, half } => Aabb::new(*centre - *half, *centre + *half),
            Self::Torus { large, small } => {
                let reach = DVec3::new(large + small, large + small, *small);
                Aabb::new(-reach, reach)
            }
            Self::Apart(solids) => solids.iter().map(Self::own_box).reduce(Aabb::union).expect("solids"),
            Self::Shell { of, half } => of.own_box().grown(*half),
        }
    }
}

impl Field for Exact {
    fn bounding_box(&self) -> Option<Aabb> {
        Some(self.own_box())
    }

    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: true }
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.at(position).0
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(ExactEvaluator { exact: self, regions: Vec::new() })
    }
}

impl Distance for Exact {
    fn closest_points(&self, positions: &[DVec3], closest: &mut [Foot]) -> bool {
        self.feet(positions, closest);
        true
    }
}

impl ClosestPoint for Exact {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        for (position, foot) in positions.iter().zip(feet) {
            let (distance, gradient) = self.at(*position);
            *foot = Foot { point: position - distance * gradient, distance, gradient, part: 0 };
        }
    }
}

struct ExactEvaluator<'a> {
    exact: &'a Exact,
    regions: Vec<Aabb>,
}

impl Evaluator for ExactEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        let (middle, reach) = (self.exact.at(region.centre()).0, region.size().length() * 0.5 + 1e-6);
        Interval::new(middle - reach, middle + reach)
    }

    fn leave(&mut self) {
        self.regions.pop().expect("a region was entered");
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        (0..points.len).for_each(|i| out[i] = self.exact.at(points.position(i)).0 as f32);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        for i in 0..points.len {
            out.set(i, self.exact.at(points.position(i)));
        }
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { steepest: Some(1.0), ..Hints::NONE }
    }
}
