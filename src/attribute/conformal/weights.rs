//! How much each feature counts at a place, by its interior distances there (CONFORMAL, section 4.3).
//!
//! With h_kj = d_j − d_k (eq. 5) and b_kj = h_kj + s_kj (eq. 9), w_k = Π_{j≠k} max(b_kj, 0) (eq. 11 as the transfinite
//! interpolation that it stands for), over their sum (eq. 10). s_kj is a share of the interior distance between the two
//! features, so that a weight is 1 in its feature and goes over midway between two.

use super::feature::Feature;
use super::nodes::Body;

/// How weights go over in a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ease {
    /// In a straight line between two features, with an edge at the ends of the zone.
    Linear,
    /// From rest to rest.
    Smooth,
}

/// The zones in which features go over into one another.
pub struct Zones {
    count: usize,
    /// s_kj in cells, row by row, symmetric.
    widths: Vec<f64>,
    ease: Ease,
}

impl Zones {
    /// The zones between features. `spread`: the share of the way between two over which they go over, 0 to 1; none is
    /// narrower than a cell.
    pub fn new(body: &Body, features: &[&Feature], spread: f64, ease: Ease) -> Self {
        let count = features.len();
        let mut widths = vec![0.0; count * count];
        for k in 0..count {
            for j in 0..k {
                let (apart, cell) = features[k].apart_from(features[j], body);
                let width = (spread * f64::from(apart)).max(f64::from(cell));
                (widths[k * count + j], widths[j * count + k]) = (width, width);
            }
        }
        Self { count, widths, ease }
    }

    /// How many features there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// b_kj, of distances in cells.
    fn zone(&self, distances: &[f32], k: usize, j: usize) -> f64 {
        f64::from(distances[j]) - f64::from(distances[k]) + self.widths[k * self.count + j]
    }

    /// The weights of all features at a place from their distances there, in cells; they add up to 1. In a feature it alone
    /// counts, in several the last of them.
    pub(super) fn weigh(&self, distances: &[f32], weights: &mut [f64]) {
        weights.fill(0.0);
        if let Some(inside) = distances.iter().rposition(|distance| *distance <= 0.0) {
            weights[inside] = 1.0;
            return;
        }
        let nearest = nearest(distances);
        // Products of many stay in range where the greatest factor of all is 1.
        let mut scale = 0.0f64;
        for k in 0..self.count {
            for j in 0..self.count {
                scale = if j == k { scale } else { scale.max(self.zone(distances, k, j)) };
            }
        }
        let mut sum = 0.0;
        for k in 0..self.count {
            let mut product = 1.0;
            for j in (0..self.count).filter(|j| *j != k) {
                let zone = self.zone(distances, k, j).max(0.0);
                product *= match self.ease {
                    Ease::Linear => zone / scale,
                    Ease::Smooth => {
                        let share = (zone / (2.0 * self.widths[k * self.count + j])).min(1.0);
                        share * share * (3.0 - 2.0 * share)
                    }
                };
            }
            weights[k] = product;
            sum += product;
        }
        if sum > 0.0 {
            weights.iter_mut().for_each(|weight| *weight /= sum);
        } else {
            // Of so many features at very different distances that no product holds.
            weights[nearest] = 1.0;
        }
    }
}

/// The nearest feature, of several as near the last.
pub(super) fn nearest(distances: &[f32]) -> usize {
    let mut nearest = 0;
    for (k, distance) in distances.iter().enumerate() {
        if *distance <= distances[nearest] {
            nearest = k;
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zones(ease: Ease, apart: &[&[f64]]) -> Zones {
        Zones { count: apart.len(), widths: apart.concat(), ease }
    }

    fn weights(zones: &Zones, distances: &[f32]) -> Vec<f64> {
        let mut weights = vec![0.0; distances.len()];
        zones.weigh(distances, &mut weights);
        weights
    }

    #[test]
    fn two_features_are_a_straight_ramp() {
        let linear = zones(Ease::Linear, &[&[0.0, 10.0], &[10.0, 0.0]]);
        let smooth = zones(Ease::Smooth, &[&[0.0, 10.0], &[10.0, 0.0]]);
        for step in 1..10 {
            let (near, share) = (step as f32, f64::from(step) / 10.0);
            assert!((weights(&linear, &[near, 10.0 - near])[1] - share).abs() < 1e-12);
            let eased = share * share * (3.0 - 2.0 * share);
            assert!((weights(&smooth, &[near, 10.0 - near])[1] - eased).abs() < 1e-12);
        }
        // Half as wide: from a quarter to three quarters.
        let half = zones(Ease::Linear, &[&[0.0, 5.0], &[5.0, 0.0]]);
        for (near, wanted) in [(2.0, 0.0), (2.5, 0.0), (4.0, 0.3), (5.0, 0.5), (7.5, 1.0), (9.0, 1.0)] {
            assert!((weights(&half, &[near, 10.0 - near])[1] - wanted).abs() < 1e-12, "{near}");
        }
    }

    #[test]
    fn in_a_feature_it_alone_counts() {
        let three = zones(Ease::Linear, &[&[0.0, 4.0, 9.0], &[4.0, 0.0, 7.0], &[9.0, 7.0, 0.0]]);
        assert_eq!(weights(&three, &[4.0, 0.0, 7.0]), [0.0, 1.0, 0.0]);
        assert_eq!(weights(&three, &[0.0, 0.0, 7.0]), [0.0, 1.0, 0.0]);
        let sum: f64 = weights(&three, &[3.0, 2.5, 6.0]).iter().sum();
        assert!((sum - 1.0).abs() < 1e-15);
    }

    #[test]
    fn many_features_neither_overflow_nor_vanish() {
        let widths = vec![1000.0; 64 * 64];
        for scale in [1e-6f32, 1.0, 1e6] {
            let many =
                Zones { count: 64, widths: widths.iter().map(|w| w * f64::from(scale)).collect(), ease: Ease::Linear };
            let distances: Vec<f32> = (0..64).map(|i| (500.0 + i as f32) * scale).collect();
            let found = weights(&many, &distances);
            assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12 && found[0] > found[63], "{found:?}");
        }
        let mut narrow = Zones { count: 64, widths: vec![1e-9; 64 * 64], ease: Ease::Linear };
        narrow.widths[1] = 1e9;
        let distances: Vec<f32> = (1..65).map(|i| i as f32 * 1e-9).collect();
        assert_eq!(weights(&narrow, &distances).iter().sum::<f64>(), 1.0);
    }
}
