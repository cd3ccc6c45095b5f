//! How wrong a node's series can be, and how much its voxels weigh at least.

use glam::DVec3;

use super::clusters::Cluster;
use super::series::DEGREE;

/// Points within a distance of a middle.
pub(super) struct Ball {
    pub middle: DVec3,
    pub radius: f64,
    pub power: u32,
}

impl Ball {
    /// E, no less than Σ |ŵⱼ − wⱼ| of a node at any point.
    pub fn error(&self, cluster: &Cluster) -> f64 {
        let [count, size, reach] = [cluster.count, cluster.size, cluster.radius].map(f64::from);
        let squared = self.middle.distance_squared(cluster.centroid);
        let distance = squared.sqrt();
        let (p, n) = (f64::from(self.power), (DEGREE + 1) as f64);
        // 1 − q.
        let gap = 1.0 - (self.radius + reach) / distance;
        if gap.is_nan() || gap <= 0.0 {
            return f64::INFINITY;
        }
        let relative = (self.radius + size) / distance;
        let first = (0..=DEGREE).fold(1.0, |first, i| first * relative * (p + i as f64) / (i as f64 + 1.0));
        let series = first * (inverse_power(gap * gap, self.power) + n / gap) / (n + 1.0);
        count * inverse_power(squared, self.power) * series
    }
}

/// r⁻ᵖ of r².
pub(super) fn inverse_power(squared: f64, power: u32) -> f64 {
    let inverse = 1.0 / squared;
    let even = (0..power / 2).fold(1.0, |product, _| product * inverse);
    if power % 2 == 1 { even * inverse.sqrt() } else { even }
}
