//! What can be wrong with a mesh, each with what to do about it.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use super::read::Place;

/// A mesh file that could not be used.
#[derive(Debug)]
pub struct MeshError {
    /// The file.
    pub file: PathBuf,
    /// The place in it, where one is known.
    pub place: Option<Place>,
    /// What is wrong.
    pub problem: Problem,
}

/// A vertex or a face by its number in the file, which counts from `first`: OBJ from 1, PLY from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "described above")]
pub enum Element {
    /// A vertex.
    Vertex { number: usize, first: usize },
    /// A face.
    Face { number: usize, first: usize },
}

impl Display for Element {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (kind, number, first) = match self {
            Self::Vertex { number, first } => ("vertex", number, first),
            Self::Face { number, first } => ("face", number, first),
        };
        write!(f, "{kind} {number}")?;
        if *first == 0 { f.write_str(" (counted from 0)") } else { Ok(()) }
    }
}

/// What is wrong with a mesh.
#[derive(Debug)]
pub enum Problem {
    /// The file could not be opened or read.
    Unreadable(std::io::Error),
    /// The name's ending is not one that is read.
    UnknownFormat(String),
    /// A line or an element does not follow the format.
    Malformed(String),
    /// The file ends before what it announces.
    CutShort(String),
    /// No vertices.
    NoVertices,
    /// Vertices, but no polygons.
    NoFaces,
    /// A coordinate is NaN, infinite or beyond [`super::triangles::LARGEST_COORDINATE`].
    BadCoordinate {
        /// The vertex.
        vertex: Element,
        /// What stands there.
        value: [f64; 3],
    },
    /// A polygon names a vertex that is not there.
    IndexOutOfRange {
        /// What the polygon says.
        index: i64,
        /// How many vertices there are.
        vertices: usize,
        /// The number of the first of them.
        first: usize,
    },
    /// A face crosses itself, or covers a part of its plane more than once, so that there is no one way to cut it.
    CrossingFace {
        /// How many corners it has.
        corners: usize,
        /// About where.
        near: [f64; 3],
    },
    /// A colour is outside of 0 … 1 or not a number.
    BadColour {
        /// What has it.
        of: Element,
        /// What stands there.
        value: [f64; 3],
    },
    /// All triangles have no area, or the mesh has no extent.
    Flat,
    /// More than 2³² − 1 vertices or triangles.
    TooLarge,
    /// The surface has holes, so it has no inside.
    Open {
        /// Edges that only one triangle uses (or that an odd number uses).
        boundary_edges: usize,
        /// Closed by count, but neighbours disagree about which side is out.
        inconsistent_edges: usize,
    },
    /// Closed, but with the same side before and behind everywhere.
    NoVolume,
    /// Triangles cross one another too often to be cut apart.
    Tangled,
}

impl Problem {
    pub(super) fn malformed(what: impl Into<String>) -> Self {
        Self::Malformed(what.into())
    }
}

impl Display for Problem {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(error) => write!(f, "cannot be read: {error}; check the path and its permissions"),
            Self::UnknownFormat(ending) => {
                write!(
                    f,
                    "meshes are read from .obj, .ply, .stl, .gltf and .glb files, not from '{ending}'; export it as one of these"
                )
            }
            Self::Malformed(what) => f.write_str(what),
            Self::CutShort(what) => write!(f, "{what}: the file is cut short; export or copy it again"),
            Self::NoVertices => f.write_str("holds no vertices; export it again with its geometry"),
            Self::NoFaces => {
                f.write_str("holds vertices but no polygons, so it has no surface; export it with its faces")
            }
            Self::BadCoordinate { vertex, value: [x, y, z] } => {
                write!(
                    f,
                    "{vertex} is at ({x}, {y}, {z}), which is no usable position; clean the mesh and export it again"
                )
            }
            Self::IndexOutOfRange { index, vertices, first } => write!(
                f,
                "a face names vertex {index}, but there are {vertices}, counted from {first}; the file is damaged: \
                 export it again"
            ),
            Self::CrossingFace { corners, near: [x, y, z] } => write!(
                f,
                "a face of {corners} corners crosses or overlaps itself near ({x}, {y}, {z}); mend it in the modeller, \
                 or export it in triangles"
            ),
            Self::BadColour { of, value: [r, g, b] } if [r, g, b].iter().all(|c| **c >= 0.0) => write!(
                f,
                "the colour ({r}, {g}, {b}) of {of} is not within 0 … 1; rescale the colours and export again, or say \
                 `vertex_colors = \"linear\"` beside `mesh` where they are linear"
            ),
            Self::BadColour { of, value: [r, g, b] } => write!(
                f,
                "the colour ({r}, {g}, {b}) of {of} is negative or no number; mend the colours and export again"
            ),
            Self::Flat => f.write_str("has no triangle with an area; check its scale and export it again"),
            Self::TooLarge => f.write_str("has more than 4,294,967,295 vertices or triangles; reduce it first"),
            Self::Open { boundary_edges, inconsistent_edges } => write!(
                f,
                "is not closed, so it has no inside: {boundary_edges} boundary edges, {inconsistent_edges} edges whose \
                 neighbours face opposite ways; fill the holes and unify the normals, or say `sign = \"winding\"` beside `mesh` \
                 to have them closed by sheets, or `thickness` for a sheet along the surface"
            ),
            Self::NoVolume => f.write_str(
                "encloses no volume: every face lies on one that faces the other way; delete the doubled faces, or \
                 give the surface a thickness",
            ),
            Self::Tangled => {
                f.write_str("crosses itself millions of times, too often to find the solid it encloses; remesh it")
            }
        }
    }
}

impl Display for MeshError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(place) = self.place {
            write!(f, ", {place}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for Problem {}

impl std::error::Error for MeshError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.problem {
            Problem::Unreadable(error) => Some(error),
            _ => None,
        }
    }
}
