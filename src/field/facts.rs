//! What is known of a node without evaluating it: a box around the solid, and what the value says of distance.

use glam::{DAffine3, DVec3};

use super::op::{Binary, Unary};
use super::{Aabb, Slope};

/// A box outside of which F < 0 (`None`: perhaps unbounded), and the slope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    pub bounds: Option<Aabb>,
    pub slope: Slope,
}

/// The bound of |∇F| that a slope implies.
fn steepness(slope: Slope) -> Option<f64> {
    match slope {
        Slope::Exact { .. } => Some(1.0),
        Slope::Lipschitz(bound) => Some(bound),
        Slope::Unknown => None,
    }
}

fn lipschitz(bound: Option<f64>) -> Slope {
    bound.filter(|bound| bound.is_finite()).map_or(Slope::Unknown, Slope::Lipschitz)
}

/// `Exact` on the sides given, or the Lipschitz bound that remains where neither is.
fn exact(outside: bool, inside: bool) -> Slope {
    if outside || inside { Slope::Exact { outside, inside } } else { Slope::Lipschitz(1.0) }
}

/// The box in both, a single point where they do not meet: then there is no solid.
fn intersection(a: Option<Aabb>, b: Option<Aabb>) -> Option<Aabb> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.intersection(b).unwrap_or(Aabb::new(a.centre(), a.centre()))),
        (one, other) => one.or(other),
    }
}

fn union(a: Option<Aabb>, b: Option<Aabb>) -> Option<Aabb> {
    Some(a?.union(b?))
}

impl Facts {
    pub const NONE: Self = Self { bounds: None, slope: Slope::Unknown };

    /// An exact signed distance with a box.
    pub fn distance(bounds: Option<Aabb>) -> Self {
        Self { bounds, slope: Slope::Exact { outside: true, inside: true } }
    }

    pub fn affine(slope: DVec3) -> Self {
        let length = slope.length();
        let unit = (length - 1.0).abs() < 1e-12;
        Self { bounds: None, slope: if unit { exact(true, true) } else { lipschitz(Some(length)) } }
    }

    /// Two truths about one node.
    pub fn and(self, other: Self) -> Self {
        let slope = match (self.slope, other.slope) {
            (Slope::Exact { outside, inside }, Slope::Exact { outside: o, inside: i }) => {
                exact(outside || o, inside || i)
            }
            (exact @ Slope::Exact { .. }, _) | (_, exact @ Slope::Exact { .. }) => exact,
            (Slope::Lipschitz(a), Slope::Lipschitz(b)) => Slope::Lipschitz(a.min(b)),
            (known, Slope::Unknown) | (Slope::Unknown, known) => known,
        };
        Self { bounds: intersection(self.bounds, other.bounds), slope }
    }

    pub fn unary(operation: Unary, a: Self) -> Self {
        let steep = steepness(a.slope);
        let slope = match operation {
            Unary::Linear { scale, offset } => return a.linear(scale, offset),
            Unary::Abs | Unary::Sin | Unary::Cos => lipschitz(steep),
            // 6v(1 − v) is at most 1.5.
            Unary::Smooth => lipschitz(steep.map(|bound| 1.5 * bound)),
            _ => Slope::Unknown,
        };
        Self { bounds: None, slope }
    }

    fn linear(self, scale: f64, offset: f64) -> Self {
        let slope = match self.slope {
            Slope::Exact { outside, inside } if scale.abs() == 1.0 => {
                let (outside, inside) = if scale > 0.0 { (outside, inside) } else { (inside, outside) };
                // Growing an exact distance leaves it exact outside only, shrinking inside only: creases of the
                // other side turn round.
                exact(outside && offset >= 0.0, inside && offset <= 0.0)
            }
            slope => lipschitz(steepness(slope).map(|bound| bound * scale.abs())),
        };
        let bounds = match self.slope {
            _ if scale <= 0.0 => None,
            _ if offset <= 0.0 => self.bounds,
            // F ≥ −offset/scale lies within that distance of the solid where |F| is the distance outside.
            Slope::Exact { outside: true, .. } => self.bounds.map(|bounds| bounds.grown(offset / scale)),
            _ => None,
        };
        Self { bounds, slope }
    }

    pub fn binary(operation: Binary, a: Self, b: Self) -> Self {
        let both = steepness(a.slope).zip(steepness(b.slope));
        let slope = match operation {
            Binary::Min | Binary::Max => match (a.slope, b.slope) {
                (Slope::Exact { outside, inside }, Slope::Exact { outside: o, inside: i }) => {
                    let union = operation == Binary::Max;
                    exact(outside && o && union, inside && i && !union)
                }
                _ => lipschitz(both.map(|(a, b)| a.max(b))),
            },
            Binary::Add | Binary::Sub => lipschitz(both.map(|(a, b)| a + b)),
            // ∇ = (1 + a/s)∇a + (1 + b/s)∇b, whose weights are 1 + cos and 1 + sin of one angle.
            Binary::Union | Binary::Intersection => lipschitz(both.map(|(a, b)| a + b + a.hypot(b))),
            Binary::Corner => lipschitz(both.map(|(a, b)| a.hypot(b))),
            _ => Slope::Unknown,
        };
        let bounds = match operation {
            Binary::Max | Binary::Union => union(a.bounds, b.bounds),
            Binary::Min | Binary::Intersection | Binary::Corner => intersection(a.bounds, b.bounds),
            _ => None,
        };
        Self { bounds, slope }
    }

    /// The facts of F∘map⁻¹, for a map that stretches no direction by less than `least`.
    pub fn moved(self, map: &DAffine3, least: f64) -> Self {
        let slope = match self.slope {
            slope @ Slope::Exact { .. } if (least - 1.0).abs() < 1e-12 => slope,
            slope => lipschitz(steepness(slope).map(|bound| bound / least)),
        };
        Self { bounds: self.bounds.map(|bounds| moved_box(&bounds, map)), slope }
    }
}

/// The axis-aligned box around a moved box.
pub(super) fn moved_box(bounds: &Aabb, map: &DAffine3) -> Aabb {
    let corners = bounds.corners().map(|corner| map.transform_point3(corner));
    corners.into_iter().fold(Aabb::new(corners[0], corners[0]), |all, corner| all.union(Aabb::new(corner, corner)))
}
