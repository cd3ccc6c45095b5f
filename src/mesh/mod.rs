//! Polygon files, exact closest triangle, inside test. A mesh is a distance object like any other.
//!
//! [`read`] takes an OBJ, PLY, STL, glTF or GLB file to a [`TriangleMesh`] with its [`Material`]s; [`MeshDistance`] answers the signed distance (positive
//! inside) and the closest triangle anywhere. Units and placement are the scene's; what a file does not say about itself,
//! its up axis and its colours' encoding, is given to the reader ([`Conventions`]), which turns the mesh and decodes its
//! colours to scene-linear once, and nowhere else.

mod batch;
mod closest;
mod cloud;
mod contact;
mod convex;
mod copies;
mod cut;
mod distance;
mod error;
mod evaluator;
mod exr_picture;
mod faces;
mod gltf;
mod hull;
mod material;
mod mtl;
mod obj;
mod pieces;
mod ply;
mod polygon;
mod pseudonormals;
mod read;
mod report;
mod solid;
mod stl;
mod texture;
mod topology;
mod triangles;
mod visit;
mod winding;

#[cfg(test)]
mod shapes;
#[cfg(test)]
mod solid_tests;
#[cfg(test)]
mod tests;

pub use cloud::{Cloud, read_cloud};
pub use distance::{Holes, MeshDistance, Nearest};
pub use error::{Element, MeshError, Problem};
pub use evaluator::MeshEvaluator;
pub use hull::hull;
pub use material::{Material, MaterialNumber, NumberOf, Picture, PicturePlace};
pub(crate) use pieces::Groups;
pub use read::{
    About, Conventions, Encoding, Imported, Place, Remark, Turn, companions, has_companions, is_gltf, is_mesh, read,
    read_obj, read_ply,
};
pub use report::{Report, report};
pub use texture::{Lookup, Texture, Wrap};
pub use topology::Topology;
pub use triangles::TriangleMesh;
