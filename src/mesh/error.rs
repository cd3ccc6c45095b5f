//! What can be wrong with a mesh, each with what to do about it.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

/// A mesh file that could not be used.
#[derive(Debug)]
pub struct MeshError {
    /// The file.
    pub file: PathBuf,
    /// The line in it, counted from 1, where one is known.
    pub line: Option<usize>,
    /// What is wrong.
    pub problem: Problem,
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
        /// The vertex, counted from 0.
        vertex: usize,
        /// What stands there.
        value: [f64; 3],
    },
    /// A polygon names a vertex that is not there.
    IndexOutOfRange {
        /// What the polygon says.
        index: i64,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A colour is outside of 0 … 1 or not a number.
    BadColour {
        /// The vertex, counted from 0.
        vertex: usize,
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
                write!(f, "meshes are read from .obj and .ply files, not from '{ending}'; export it as one of these")
            }
            Self::Malformed(what) => f.write_str(what),
            Self::CutShort(what) => write!(f, "{what}: the file is cut short; export or copy it again"),
            Self::NoVertices => f.write_str("holds no vertices; export it again with its geometry"),
            Self::NoFaces => {
                f.write_str("holds vertices but no polygons, so it has no surface; export it with its faces")
            }
            Self::BadCoordinate { vertex, value: [x, y, z] } => write!(
                f,
                "vertex {vertex} is at ({x}, {y}, {z}), which is no usable position; clean the mesh and export it again"
            ),
            Self::IndexOutOfRange { index, vertices } => write!(
                f,
                "a polygon names vertex {index}, but there are {vertices}; the file is damaged: export it again"
            ),
            Self::BadColour { vertex, value: [r, g, b] } => write!(
                f,
                "the colour ({r}, {g}, {b}) of vertex {vertex} is not within 0 … 1; rescale the colours and export again"
            ),
            Self::Flat => f.write_str("has no triangle with an area; check its scale and export it again"),
            Self::TooLarge => f.write_str("has more than 4,294,967,295 vertices or triangles; reduce it first"),
            Self::Open { boundary_edges, inconsistent_edges } => write!(
                f,
                "is not closed, so it has no inside: {boundary_edges} boundary edges, {inconsistent_edges} edges whose \
                 neighbours face opposite ways; fill the holes and unify the normals"
            ),
        }
    }
}

impl Display for MeshError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
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
