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
pub(crate) fn eigen(mut matrix: DMat3) -> (DVec3, DMat3) {
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix.col(q)[p];
            if off == 0.0 {
                continue;
            }
            let theta = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * off);
            let tan = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cos = 1.0 / (tan * tan + 1.0).sqrt();
            let sin = tan * cos;
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cos;
            turn.col_mut(q)[q] = cos;
            turn.col_mut(q)[p] = sin;
            turn.col_mut(p)[q] = -sin;
            matrix = turn.transpose() * matrix * turn;
            vectors *= turn;
        }
    }
    (DVec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z), vectors)
}
