//! The ellipse: its nearest point by iteration.
//!
//! Of a point (u, v) in the first quadrant the nearest one is (a²u/(t + a²), b²v/(t + b²)) with the greatest root t of
//! (au/(t + a²))² + (bv/(t + b²))² = 1 (Eberly, Distance from a Point to an Ellipse). Left of the root the sum is convex
//! and falls, so that Newton's steps from there rise to it and never pass it.

use glam::{DVec2, DVec3};

use super::part::{Parts, Sample};
use super::{Aabb, Slope};

/// An ellipse in the xy plane, whatever z.
pub struct Ellipse {
    half: DVec2,
}

impl Ellipse {
    /// By its half axes along x and y, greater than 0.
    pub fn new(half: DVec2) -> Self {
        Self { half }
    }

    /// The nearest point of it.
    fn nearest(&self, point: DVec2) -> DVec2 {
        let swapped = self.half.x < self.half.y;
        let swap = |v: DVec2| if swapped { DVec2::new(v.y, v.x) } else { v };
        let (half, at) = (swap(self.half), swap(point.abs()));
        let found = nearest_in_quadrant(half, at);
        swap(found) * DVec2::new(1.0_f64.copysign(point.x), 1.0_f64.copysign(point.y))
    }
}

/// With half.x ≥ half.y.
fn nearest_in_quadrant(half: DVec2, at: DVec2) -> DVec2 {
    /// Near the long axis a step only multiplies the way by 1.5: enough for 1e-16 of it.
    const STEPS: usize = 120;
    let ratio = (half.x / half.y) * (half.x / half.y);
    let share = at / half;
    if share.y <= 0.0 {
        let (along, spread) = (half.x * at.x, half.x * half.x - half.y * half.y);
        if along < spread {
            let part = along / spread;
            return half * DVec2::new(part, (1.0 - part * part).sqrt());
        }
        return DVec2::new(half.x, 0.0);
    }
    // In units of half.y²: the sum is at least 1 here.
    let mut t = share.y - 1.0;
    for _ in 0..STEPS {
        let (first, second) = (ratio * share.x / (t + ratio), share.y / (t + 1.0));
        let value = first * first + second * second - 1.0;
        let slope = -2.0 * (first * first / (t + ratio) + second * second / (t + 1.0));
        let next = t - value / slope;
        if next <= t || !next.is_finite() {
            break;
        }
        t = next;
    }
    DVec2::new(ratio * at.x / (t + ratio), at.y / (t + 1.0))
}

impl Parts for Ellipse {
    fn count(&self) -> usize {
        1
    }

    fn part(&self, _: usize, position: DVec3) -> Sample {
        let point = position.truncate();
        let share = point / self.half;
        let inside = share.length_squared() < 1.0;
        let away = point - self.nearest(point);
        let distance = away.length();
        let normal = (share / self.half).normalize_or(DVec2::X);
        // Next to the ellipse the way to it is all rounding.
        let out = if distance > 1e-9 * self.half.max_element() {
            if inside { -away / distance } else { away / distance }
        } else {
            normal
        };
        (if inside { distance } else { -distance }, -out.extend(0.0))
    }

    fn bounding_box(&self) -> Option<Aabb> {
        Some(Aabb::new(-self.half.extend(0.0), self.half.extend(0.0)).without_z())
    }

    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: true }
    }

    fn is_flat(&self) -> bool {
        true
    }
}
