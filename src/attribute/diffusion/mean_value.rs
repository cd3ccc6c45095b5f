//! Mean-value coordinates of a place in a closed triangle mesh (Floater, Kós and Reimers, Mean value coordinates in 3D,
//! 2005; Ju, Schaefer and Warren, Mean value coordinates for closed triangular meshes, 2005).

use glam::DVec3;

/// A triangle whose plane holds the place, to this sine, adds nothing where the place is not on it.
const IN_PLANE: f64 = 1e-12;

/// How much each vertex counts at a place strictly inside: the sum is 1, and Σ wᵢ·pᵢ the place.
///
/// For a corner 1 of a triangle: (β₂₃ + β₁₂·n₁₂·n₂₃ + β₃₁·n₃₁·n₂₃) / (2·r₁·e₁·n₂₃), e the unit ways to the corners, r their
/// lengths, β the angles between them and n the unit normals of their planes.
pub fn weights(place: DVec3, positions: &[DVec3], triangles: &[[u32; 3]], weights: &mut Vec<f64>) {
    weights.clear();
    weights.resize(positions.len(), 0.0);
    for triangle in triangles {
        let ways = triangle.map(|vertex| positions[vertex as usize] - place);
        let lengths = ways.map(DVec3::length);
        let units: [DVec3; 3] = std::array::from_fn(|i| ways[i] / lengths[i]);
        // Opposite of each corner.
        let across: [DVec3; 3] = std::array::from_fn(|i| units[(i + 1) % 3].cross(units[(i + 2) % 3]));
        let volume = units[0].dot(across[0]);
        if volume.abs() < IN_PLANE {
            continue;
        }
        let sines = across.map(DVec3::length);
        let angles: [f64; 3] =
            std::array::from_fn(|i| libm::atan2(sines[i], units[(i + 1) % 3].dot(units[(i + 2) % 3])));
        let normals: [DVec3; 3] = std::array::from_fn(|i| across[i] / sines[i]);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let turned = angles[i] + angles[k] * normals[k].dot(normals[i]) + angles[j] * normals[j].dot(normals[i]);
            weights[triangle[i] as usize] += turned / (2.0 * lengths[i] * units[i].dot(normals[i]));
        }
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
}
