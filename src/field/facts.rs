//! What is known of a node without evaluating it: a box around the solid, and what the value says of distance.

use glam::{DAffine3, DVec3};

use super::{Aabb, Side, Slope};

/// A box outside of which F < 0 (`None`: perhaps unbounded), the slope, and how F falls outside of the box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    pub bounds: Option<Aabb>,
    pub slope: Slope,
    /// Outside of the box F is no more than −`fall` times the distance to it; 0 where nothing is known.
    pub fall: f64,
}

fn lipschitz(bound: Option<f64>) -> Slope {
    bound.filter(|bound| bound.is_finite()).map_or(Slope::Unknown, Slope::Lipschitz)
}

/// `Exact` on the sides given, or the Lipschitz bound that remains where neither is.
pub(super) fn exact(outside: bool, inside: bool) -> Slope {
    if outside || inside { Slope::Exact { outside, inside } } else { Slope::Lipschitz(1.0) }
}

/// The box in both, a single point where they do not meet: then there is no solid.
fn box_in_both(a: Option<Aabb>, b: Option<Aabb>) -> Option<Aabb> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.intersection(b).unwrap_or(Aabb::new(a.centre(), a.centre()))),
        (one, other) => one.or(other),
    }
}

impl Facts {
    pub const NONE: Self = Self { bounds: None, slope: Slope::Unknown, fall: 0.0 };

    /// A box and a slope; of a distance outside it is known how that falls.
    pub fn new(bounds: Option<Aabb>, slope: Slope) -> Self {
        Self { bounds, slope, fall: if slope.is_exact(Side::Outside) { 1.0 } else { 0.0 } }
    }

    /// A bound of |∇F|, where there is one.
    pub fn steep(bound: Option<f64>) -> Self {
        Self::new(None, lipschitz(bound))
    }

    /// The bound of |∇F| that the slope implies.
    pub fn steepness(&self) -> Option<f64> {
        match self.slope {
            Slope::Exact { .. } => Some(1.0),
            Slope::Lipschitz(bound) => Some(bound),
            Slope::Unknown => None,
        }
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
        let bounds = box_in_both(self.bounds, other.bounds);
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

    /// A union whose value falls as this share of the lesser fall.
    pub fn union(a: Self, b: Self, slope: Slope, kept: f64) -> Self {
        let bounds = a.bounds.zip(b.bounds).map(|(a, b)| a.union(b));
        Self { bounds, slope, fall: kept * a.fall.min(b.fall) }
    }

    /// An intersection.
    pub fn intersection(a: Self, b: Self, slope: Slope) -> Self {
        Self { bounds: box_in_both(a.bounds, b.bounds), slope, fall: a.fall_in_both(b) }
    }

    /// The facts of F∘map⁻¹, for a map that stretches no direction by less than `least`.
    pub fn moved(self, map: &DAffine3, least: f64) -> Self {
        let slope = match self.slope {
            slope @ Slope::Exact { .. } if (least - 1.0).abs() < 1e-12 => slope,
            _ => lipschitz(self.steepness().map(|bound| bound / least)),
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
