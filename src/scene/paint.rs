//! Colours of shapes at one moment.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DAffine3, DVec3};

use crate::attribute::{Bands, ByCell, ByFormula, CellIndex, Choice, Components, CubeLattice, Part, Parts, Rule};
use crate::attribute::{Colour, Constant, LinearRgb, VertexColours};
use crate::distance::nearest::Watch;
use crate::distance::octree::{self, DistanceObject};
use crate::field::cells::Cells;
use crate::field::facet::{self, surface_points};
use crate::field::{BATCH, Expression, Field, Graph, Points, Slope};

use super::colour::{GREY, css};
use super::error::Problem;
use super::model::{Component, Maker, Pieces, Shape, ShapeColour, ShapeId};
use super::morphing::smallest_cell;
use super::placed_colour::{PlacedColour, Way};
use super::prepare::solid_box;
use super::solid::{Solids, Stage};

/// How far outside of a part a surface point may be, in voxels, and still count as inside it: feet lie on the
/// surface to about a thousandth of a voxel. Less: specks of the parts behind; more: parts that end just below the
/// surface shine through.
const TOLERANCE_VOXELS: f64 = 0.05;

/// A colour, and whether it is one everywhere.
#[derive(Clone)]
pub(super) struct Paint {
    /// The colour.
    pub colour: Arc<dyn Colour>,
    solid: Option<LinearRgb>,
}

impl Paint {
    /// One colour everywhere.
    pub fn solid(colour: LinearRgb) -> Self {
        Self { colour: Arc::new(Constant::new(colour)), solid: Some(colour) }
    }

    /// Grey, for shapes without colour beside coloured ones.
    pub fn grey() -> Self {
        Self::solid(css(GREY).expect("it is a colour"))
    }

    fn of(colour: impl Colour + 'static) -> Self {
        Self { colour: Arc::new(colour), solid: None }
    }

    /// Seen through a way; one colour stays itself.
    fn through(self, way: Way) -> Self {
        match self.solid {
            Some(_) => self,
            None => Self::of(PlacedColour { inner: self.colour, way }),
        }
    }
}

impl Solids {
    /// A shape's colour; `None` where neither it nor a part of it has one. `voxel` is a voxel's edge.
    pub fn paint(&mut self, id: ShapeId, stage: Stage, voxel: f64) -> Result<Option<Paint>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        match stage {
            Stage::Own => self.own_paint(id, shape, voxel),
            Stage::Scaled | Stage::Placed => {
                let Some(own) = self.paint(id, Stage::Own, voxel)? else { return Ok(None) };
                let map = self.placement(&shape.modifiers, stage)?;
                Ok(Some(if map == DAffine3::IDENTITY { own } else { own.through(Way::Back(map.inverse())) }))
            }
        }
    }

    fn own_paint(&mut self, id: ShapeId, shape: &Shape, voxel: f64) -> Result<Option<Paint>, Problem> {
        let paint = match &shape.colour {
            Some(ShapeColour::Solid(colour)) => return Ok(Some(Paint::solid(*colour))),
            Some(ShapeColour::Formula { components, meaning, .. }) => Some(self.by_formula(components, *meaning)?),
            Some(ShapeColour::Random { choice, by, seed }) => {
                Some(self.at_random(id, choice.clone(), *by, *seed, voxel)?)
            }
            Some(ShapeColour::Bands(bands)) => Some(self.by_bands(id, bands.clone(), voxel)?),
            Some(ShapeColour::Parts { shapes, seam }) => {
                let paint = self.parts_paint(shapes, Rule::Union { seam: *seam }, voxel)?;
                Some(paint.unwrap_or_else(Paint::grey))
            }
            None => {
                let paint = self.made_paint(id, shape, voxel)?;
                if shape.modifiers.at.is_some() && paint.as_ref().is_some_and(|paint| paint.solid.is_none()) {
                    let problem = format!("the copies of `{}` cannot take its parts' several colours", shape.name);
                    return Err(Problem::new(shape.span, problem)
                        .help("give it a `color` of its own: one, or { palette = …, by = \"cell\" }"));
                }
                paint
            }
        };
        Ok(match shape.modifiers.mirror {
            Some(axis) => paint.map(|paint| paint.through(Way::Folded(axis))),
            None => paint,
        })
    }

    /// The colour that comes with a maker.
    fn made_paint(&mut self, id: ShapeId, shape: &Shape, voxel: f64) -> Result<Option<Paint>, Problem> {
        match &shape.maker {
            Maker::Mesh { .. } => Ok(VertexColours::new(Arc::clone(self.assets().mesh(id))).map(Paint::of)),
            Maker::Facet { of, .. } => self.paint(*of, Stage::Placed, voxel),
            Maker::Union { operands, seam } => self.parts_paint(operands, Rule::Union { seam: *seam }, voxel),
            Maker::Blend { operands, .. } => self.parts_paint(operands, Rule::Blend, voxel),
            // What is cut shows the inside of what it is cut from.
            Maker::Difference(operands) => self.paint(operands[0], Stage::Placed, voxel),
            Maker::Intersection(operands) => {
                for operand in operands {
                    if let Some(paint) = self.paint(*operand, Stage::Placed, voxel)? {
                        return Ok(Some(paint));
                    }
                }
                Ok(None)
            }
            _ => Ok(None),
        }
    }

    fn parts_paint(&mut self, operands: &[ShapeId], rule: Rule, voxel: f64) -> Result<Option<Paint>, Problem> {
        let paints: Vec<Option<Paint>> =
            operands.iter().map(|id| self.paint(*id, Stage::Placed, voxel)).collect::<Result<_, _>>()?;
        if paints.iter().all(Option::is_none) {
            return Ok(None);
        }
        let paints: Vec<Paint> = paints.into_iter().map(|paint| paint.unwrap_or_else(Paint::grey)).collect();
        if paints.iter().all(|paint| paint.solid.is_some() && paint.solid == paints[0].solid) {
            return Ok(paints.into_iter().next());
        }
        let mut parts: Vec<Part> = Vec::with_capacity(operands.len());
        for (id, paint) in operands.iter().zip(paints) {
            parts.push((self.values(*id)?, paint.colour));
        }
        Ok(Parts::new(parts, rule, TOLERANCE_VOXELS * voxel).map(Paint::of))
    }

    fn by_formula(&self, components: &[Component; 3], meaning: Components) -> Result<Paint, Problem> {
        let field = |component: &Component| -> Result<Arc<dyn Field>, Problem> {
            let mut graph = Graph::new();
            let node = match component {
                Component::Number(number) => graph.constant(self.number(number)?),
                Component::Formula(formula) => formula.node(&mut graph, self.moment()),
            };
            Ok(Arc::new(Expression::new(&graph, node).keeping_values()))
        };
        let [a, b, c] = components;
        Ok(Paint::of(ByFormula { components: [field(a)?, field(b)?, field(c)?], meaning }))
    }

    fn at_random(&mut self, id: ShapeId, choice: Choice, by: Pieces, seed: u64, voxel: f64) -> Result<Paint, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let cells: Arc<dyn CellIndex> = match (by, &shape.modifiers.at, &shape.maker) {
            (Pieces::Cubes(edge), ..) => {
                let solid = self.field(id, Stage::Own)?;
                Arc::new(CubeLattice { edge, solid, tolerance: TOLERANCE_VOXELS * voxel })
            }
            (Pieces::Cells, Some(copies), _) => {
                let (cells, picked) = self.picked(copies)?;
                let host = self.host(copies.cells)?;
                Arc::new(NearestCopy(surface_points(host.as_ref(), &cells, &picked)))
            }
            (Pieces::Cells, None, Maker::Facet { cells, .. }) => {
                Arc::new(FacetCells { pieces: self.pieces(id)?, cells: self.cells(*cells)? })
            }
            _ => return Err(Problem::new(shape.span, format!("`{}` has no cells to take colours", shape.name))),
        };
        Ok(Paint::of(ByCell { cells, choice, seed }))
    }

    /// Bands need a distance: the shape is measured where its field is none.
    fn by_bands(&mut self, id: ShapeId, bands: Vec<(f64, LinearRgb)>, voxel: f64) -> Result<Paint, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let field = self.field(id, Stage::Own)?;
        let distance: Arc<dyn Field> = match field.slope() {
            Slope::Exact { outside: true, inside: true } => field,
            _ => {
                let solid = solid_box(&model, id, field.as_ref())?;
                let settings = octree::Settings::new(solid, smallest_cell(voxel, &solid));
                let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| {} };
                let measured = DistanceObject::of_field(field.as_ref(), &settings, &watch);
                Arc::new(measured.map_err(|error| Problem::new(shape.span, format!("`{}`: {error}", shape.name)))?)
            }
        };
        let colour = Bands::new(distance, bands, TOLERANCE_VOXELS * voxel);
        colour.map(Paint::of).ok_or_else(|| Problem::new(shape.span, "bands begin one below the other"))
    }
}

/// The cells of a faceted shape, each as far as its material reaches.
struct FacetCells {
    pieces: Arc<facet::Pieces>,
    cells: Arc<Cells>,
}

impl CellIndex for FacetCells {
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]) {
        self.pieces.cells_at(&self.cells, points, out);
    }
}

/// Copies, by the middle that is nearest.
struct NearestCopy(Vec<DVec3>);

impl CellIndex for NearestCopy {
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]) {
        for (i, out) in out[..points.len].iter_mut().enumerate() {
            let position = points.position(i);
            let distances = self.0.iter().map(|middle| middle.distance_squared(position));
            *out = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i as u32);
        }
    }
}

/// A field with its colour.
#[derive(Clone)]
pub(super) struct Scenery {
    /// F, world units.
    pub field: Arc<dyn Field>,
    /// The colour; `None` where there is none.
    pub colour: Option<Arc<dyn Colour>>,
}
