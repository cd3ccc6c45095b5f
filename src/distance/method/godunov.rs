//! Godunov's upwind update of |∇u| = 1/f at a node (Rouy and Tourin, 1992), with a step of its own for each axis.

/// The arrival time at a node. `nearest` is the lesser time of the two neighbours along each axis (∞ where there is none),
/// `steps` is how far away that neighbour is, `slowness` is 1/f. ∞ where nothing arrives.
///
/// With a₁ ≤ a₂ ≤ a₃, u solves Σ ((u − aᵢ)/hᵢ)² = 1/f² over the axes with aᵢ < u.
#[inline(always)]
pub fn arrival(nearest: [f64; 3], steps: [f64; 3], slowness: f64) -> f64 {
    let mut order = [0, 1, 2];
    for (a, b) in [(0, 1), (1, 2), (0, 1)] {
        if nearest[order[b]] < nearest[order[a]] {
            order.swap(a, b);
        }
    }
    let first = nearest[order[0]];
    if first == f64::INFINITY {
        return first;
    }
    // In times after the first: what is squared then stays small.
    let mut after = slowness * steps[order[0]];
    let mut weight = steps[order[0]].powi(-2);
    let (mut sum, mut squares) = (0.0, 0.0);
    for &axis in &order[1..] {
        let a = nearest[axis] - first;
        if a >= after {
            break;
        }
        let inverse = steps[axis].powi(-2);
        weight += inverse;
        sum += inverse * a;
        squares += inverse * a * a;
        let root = (sum * sum - weight * (squares - slowness * slowness)).max(0.0).sqrt();
        after = (sum + root) / weight;
    }
    first + after
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOTHING: f64 = f64::INFINITY;

    /// A plane wave is exact for any steps, in one, two and three dimensions.
    #[test]
    fn a_plane_wave_is_exact() {
        let slowness = 1.7;
        for (direction, steps) in [
            ([1.0, 0.0, 0.0], [0.5, 1.0, 1.0]),
            ([0.6, 0.8, 0.0], [0.25, 0.5, 2.0]),
            ([0.48, 0.6, 0.64], [0.5, 0.5, 0.5]),
            ([0.48, 0.6, 0.64], [0.3, 0.4, 0.55]),
        ] {
            let back = std::array::from_fn(|axis| {
                if direction[axis] > 0.0 { 5.0 - slowness * direction[axis] * steps[axis] } else { NOTHING }
            });
            assert!((arrival(back, steps, slowness) - 5.0).abs() < 1e-12, "{direction:?} {steps:?}");
        }
    }

    #[test]
    fn what_comes_later_does_not_count() {
        assert_eq!(arrival([NOTHING; 3], [1.0; 3], 1.0), NOTHING);
        assert_eq!(arrival([3.0, 1.0, 2.5], [1.0, 0.5, 1.0], 2.0), 2.0);
        assert!((arrival([1.0, 1.0, 1.0], [3.0; 3], 1.0) - 1.0 - 3.0 / 3f64.sqrt()).abs() < 1e-12);
    }
}
