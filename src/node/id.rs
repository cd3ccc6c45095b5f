//! Places of shapes and cells in a [`Model`](super::Model), and how far a shape is made.

/// A shape's place in [`Model::shapes`](super::Model::shapes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShapeId(pub usize);

/// Cells' place in [`Model::cells`](super::Model::cells).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellsId(pub usize);

/// How far a shape is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Stage {
    /// All but `displace`, scale, rotate and move.
    Bare,
    /// All but scale, rotate and move: the shape in its own space.
    Own,
    /// Scaled, but neither turned nor moved.
    Scaled,
    /// All of it.
    Placed,
}
