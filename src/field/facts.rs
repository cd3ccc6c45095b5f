//! What is known of a node without evaluating it: a box around the solid, and what the value says of distance.

use glam::{DAffine3, DVec3};

use super::op::{Binary, Unary};
use super::{Aabb, Side, Slope};

/// The share of the distance that R₀ unions keep of two equal distances outside: 2 − √2.
const KEPT: f64 = 2.0 - std::f64::consts::SQRT_2;

/// A box outside of which F < 0 (`None`: perhaps unbounded), the slope, and how F falls outside of the box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    pub bounds: Option<Aabb>,
    pub slope: Slope,
    /// Outside of the box F is no more than −`fall` times the distance to it; 0 where nothing is known.
    pub fall: f64,
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
    pub const NONE: Self = Self { bounds: None, slope: Slope::Unknown, fall: 0.0 };

    /// A box and a slope; of a distance outside it is known how that falls.
    pub fn new(bounds: Option<Aabb>, slope: Slope) -> Self {
        Self { bounds, slope, fall: if slope.is_exact(Side::Outside) { 1.0 } else { 0.0 } }
    }

    /// An exact signed distance with a box.
    pub fn distance(bounds: Option<Aabb>) -> Self {
        Self::new(bounds, Slope::Exact { outside: true, inside: true })
    }

    pub fn affine(slope: DVec3) -> Self {
        let length = slope.length();
        let unit = (length - 1.0).abs() < 1e-12;
        Self::new(None, if unit { exact(true, true) } else { lipschitz(Some(length)) })
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
        let bounds = intersection(self.bounds, other.bounds);
        let fall = if self.bounds == other.bounds { self.fall.max(other.fall) } else { self.fall_in_both(other) };
        Self { bounds, slope, fall: Self::new(bounds, slope).fall.max(fall) }
    }

    /// How the lesser of two falls outside of the box in both: one of the boxes is farther away than that over √2.
    fn fall_in_both(self, other: Self) -> f64 {
        match (self.bounds, other.bounds) {
            (Some(_), Some(_)) => self.fall.min(other.fall) / std::f64::consts::SQRT_2,
            (Some(_), None) => self.fall,
            (None, _) => other.fall,
        }
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
        Self::new(None, slope)
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
        if scale <= 0.0 {
            return Self::new(None, slope);
        }
        let fall = scale * self.fall;
        let bounds = match self.bounds {
            _ if offset <= 0.0 => self.bounds,
            // F ≥ −offset/scale lies within that over the fall.
            Some(bounds) if fall > 0.0 => Some(bounds.grown(offset / fall)),
            _ => None,
        };
        Self { bounds, slope, fall }
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
        let fall = match operation {
            Binary::Max => a.fall.min(b.fall),
            // Outside of both it is greatest where they are equal.
            Binary::Union => KEPT * a.fall.min(b.fall),
            Binary::Min | Binary::Intersection | Binary::Corner => a.fall_in_both(b),
            _ => 0.0,
        };
        Self { bounds, slope, fall }
    }

    /// The facts of F∘map⁻¹, for a map that stretches no direction by less than `least`.
    pub fn moved(self, map: &DAffine3, least: f64) -> Self {
        let slope = match self.slope {
            slope @ Slope::Exact { .. } if (least - 1.0).abs() < 1e-12 => slope,
            slope => lipschitz(steepness(slope).map(|bound| bound / least)),
        };
        let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(DVec3::length);
        let uniform = columns.into_iter().all(|length| (length / least - 1.0).abs() < 1e-12);
        let most = if uniform { least } else { DVec3::from(columns).length() };
        Self { bounds: self.bounds.map(|bounds| moved_box(&bounds, map)), slope, fall: self.fall / most }
    }
}

/// The axis-aligned box around a moved box.
pub(super) fn moved_box(bounds: &Aabb, map: &DAffine3) -> Aabb {
    let corners = bounds.corners().map(|corner| map.transform_point3(corner));
    corners.into_iter().fold(Aabb::new(corners[0], corners[0]), |all, corner| all.union(Aabb::new(corner, corner)))
}
