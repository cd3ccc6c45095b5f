//! Eigenvalues and eigenvectors of symmetric matrices.

use glam::{DMat3, DVec3};

/// Sweeps of Jacobi's rotations; a matrix of three is done after five.
const SWEEPS: usize = 6;

/// The eigenvalues of a symmetric matrix, greatest first, each with its unit eigenvector.
pub(crate) fn eigen_descending(matrix: DMat3) -> [(f64, DVec3); 3] {
    let (values, vectors) = eigen(matrix);
    let mut pairs = [0, 1, 2].map(|place| (values[place], vectors.col(place)));
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    pairs
}

/// The eigenvalues and unit eigenvectors (columns) of a symmetric matrix, in no order (Jacobi).
pub(crate) fn eigen(matrix: DMat3) -> (DVec3, DMat3) {
    let mut a = matrix.to_cols_array_2d();
    let mut vectors = [DVec3::X, DVec3::Y, DVec3::Z];
    for _ in 0..SWEEPS {
        for (p, q, rest) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let off = a[p][q];
            // Less than rounding beside the diagonal.
            if off.abs() <= 1e-17 * (a[p][p].abs() + a[q][q].abs()) {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * off);
            let tan = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cos = 1.0 / (tan * tan + 1.0).sqrt();
            let sin = tan * cos;
            a[p][p] -= tan * off;
            a[q][q] += tan * off;
            (a[p][q], a[q][p]) = (0.0, 0.0);
            let (of_p, of_q) = (a[rest][p], a[rest][q]);
            (a[rest][p], a[rest][q]) = (cos * of_p - sin * of_q, sin * of_p + cos * of_q);
            (a[p][rest], a[q][rest]) = (a[rest][p], a[rest][q]);
            (vectors[p], vectors[q]) = (vectors[p] * cos - vectors[q] * sin, vectors[p] * sin + vectors[q] * cos);
        }
    }
    (DVec3::new(a[0][0], a[1][1], a[2][2]), DMat3::from_cols(vectors[0], vectors[1], vectors[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_vectors_of_symmetric_matrices() {
        let turn = DMat3::from_axis_angle(DVec3::new(0.2, -0.5, 0.9).normalize(), 1.1);
        for values in [[3.0, 2.0, -1.0], [5.0, 5.0, 1e-9], [1e-30, 2e-30, 0.0], [1e30, -1e10, 1.0], [0.0; 3], [7.0; 3]]
        {
            for turn in [turn, DMat3::IDENTITY] {
                let matrix = turn * DMat3::from_diagonal(values.into()) * turn.transpose();
                let (found, vectors) = eigen((matrix + matrix.transpose()) * 0.5);
                let size = values.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
                let (mut sorted, mut expected) = (found.to_array(), values);
                [&mut sorted, &mut expected].into_iter().for_each(|three| three.sort_by(f64::total_cmp));
                for i in 0..3 {
                    assert!((sorted[i] - expected[i]).abs() <= 1e-14 * size, "{found} for {values:?}");
                    let apart = matrix * vectors.col(i) - vectors.col(i) * found[i];
                    assert!(apart.length() <= 1e-14 * size, "{apart} for {values:?}");
                }
                assert!((vectors.transpose() * vectors).abs_diff_eq(DMat3::IDENTITY, 1e-14));
            }
        }
    }
}
