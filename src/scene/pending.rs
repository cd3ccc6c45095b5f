//! Stand-ins until facets and coloured parts land in their own rooms.

use glam::DVec3;

use crate::field::cells::{CellId, Cells};
use crate::field::{Field, Graph, Node};

pub struct Options {
    pub tilt: f64,
    pub cut: f64,
    pub seed: u64,
}

pub struct Facet {
    pub node: Node,
}

pub fn facet(_graph: &mut Graph, shape: Node, _cells: &Cells, _options: &Options) -> Facet {
    Facet { node: shape }
}

pub fn scatter(_graph: &mut Graph, shape: Node, _host: &dyn Field, _cells: &Cells, _picked: &[CellId]) -> Node {
    shape
}

pub fn surface_points(_host: &dyn Field, cells: &Cells, picked: &[CellId]) -> Vec<DVec3> {
    picked.iter().map(|id| cells.cell(*id).bounds.centre()).collect()
}
