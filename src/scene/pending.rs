//! Stand-ins until facets and coloured parts land in their own rooms.

use std::sync::Arc;

use glam::DVec3;

use crate::attribute::{Colour, ColourSampler, Constant, LinearRgb};
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

pub trait CellIndex: Send + Sync {
    fn index_at(&self, position: DVec3) -> u32;
}

pub enum Choice {
    Palette(Vec<LinearRgb>),
}

pub struct ByCell {
    pub cells: Arc<dyn CellIndex>,
    pub choice: Choice,
    pub seed: u64,
}

impl Colour for ByCell {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        let Choice::Palette(palette) = &self.choice;
        let at = self.cells.index_at(DVec3::ZERO) as usize + self.seed as usize % 7;
        Box::new(Constant::new(palette[at % palette.len()]))
    }
}

pub type Part = (Arc<dyn Field>, Arc<dyn Colour>);

pub enum Rule {
    Union { seam: f64 },
    Blend,
}

pub struct Parts(Arc<dyn Colour>);

impl Parts {
    pub fn new(parts: Vec<Part>, rule: Rule, _tolerance: f64) -> Option<Self> {
        matches!(rule, Rule::Blend | Rule::Union { seam: 0.0 }).then(|| Self(parts[0].1.clone()))
    }
}

impl Colour for Parts {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        self.0.sampler()
    }
}
