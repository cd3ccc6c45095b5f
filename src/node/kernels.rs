//! Soft objects: sums of densities around points and lines, and the surface where the sum is a threshold.

use glam::DVec3;

use super::spec::Build;
use crate::field::{Aabb, Graph, Node};
use crate::text::problem::Problem;

/// The balls of a key: centres and radii.
pub fn balls(build: &dyn Build, key: &str) -> Result<Vec<(DVec3, f64)>, Problem> {
    /// Each is looked at for every voxel.
    const MOST: usize = 500;
    let rows = &build.arguments().rows(key).expect("it must be there").all;
    if rows.len() > MOST {
        return Err(build.wrong(key, format!("`{key}` takes at most {MOST}")).help("`union` of several shapes of it"));
    }
    if rows.iter().any(|row| row[3] <= 0.0) {
        return Err(build
            .wrong(key, "a radius must be greater than 0")
            .help("the fourth number of a ball is its radius"));
    }
    Ok(rows.iter().map(|row| (DVec3::new(row[0], row[1], row[2]), row[3])).collect())
}

/// |p − c|²/r².
pub fn from_point(graph: &mut Graph, centre: DVec3, radius: f64) -> Node {
    let squares = DVec3::AXES.map(|axis| {
        let share = graph.affine(axis / radius, -axis.dot(centre) / radius);
        graph.square(share)
    });
    let sum = graph.add(squares[0], squares[1]);
    graph.add(sum, squares[2])
}

/// (Σ parts − threshold)·scale, a solid in a box.
pub fn softly(graph: &mut Graph, parts: &[Node], threshold: f64, scale: f64, bounds: Aabb) -> Node {
    let zero = graph.constant(0.0);
    let sum = parts.iter().fold(zero, |sum, part| graph.add(sum, *part));
    let node = graph.linear(sum, scale, -threshold * scale);
    graph.bounded(node, bounds)
}
