//! Polygon files, exact closest triangle, inside test. A mesh is a distance object like any other.
//!
//! [`read`] takes an OBJ or PLY file to a [`TriangleMesh`]; [`MeshDistance`] answers the signed distance (positive
//! inside) and the closest triangle anywhere. Up axis, units and placement are the scene's; colours of vertices are
//! decoded from sRGB to scene-linear here, once, by the reader, and nowhere else.

mod closest;
mod convex;
mod distance;
mod error;
mod evaluator;
mod obj;
mod ply;
mod polygon;
mod pseudonormals;
mod read;
mod topology;
mod triangles;
mod winding;

#[cfg(test)]
mod shapes;
#[cfg(test)]
mod tests;

pub use distance::{Holes, MeshDistance, Nearest};
pub use error::{MeshError, Problem};
pub use evaluator::MeshEvaluator;
pub use read::{read, read_obj, read_ply};
pub use topology::Topology;
pub use triangles::TriangleMesh;
