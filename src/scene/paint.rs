//! Colours and scalars of shapes at one moment.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DVec3};

use crate::attribute::VertexColours;
use crate::attribute::{Attribute, Bands, ByCell, CellIndex, Choice, Colour, Constant, CubeLattice, LinearRgb};
use crate::attribute::{ByFormula, Components, FieldValue, Mix, Mixer, Part, Parts, Rule, Scalar, Straight};
use crate::distance::nearest::PointTree;
use crate::distance::octree::BuildError;
use crate::field::cells::Cells;
use crate::field::facet::{self, surface_points};
use crate::field::{BATCH, Expression, Field, Graph, Interval, Points};
use crate::mesh::MeshDistance;

use super::assets::Assets;
use super::colour::{GREY, css};
use super::depth::Depth;
use super::error::Problem;
use super::measured::Purpose;
use super::model::{AttributeSource, Component, Maker, Model, Pieces, Shape, ShapeColour, ShapeId, ShapeScalar};
use super::placed::{Placed, Way};
use super::prepare::{box_of, solid_box};
use super::solid::{Solids, Stage};

/// How far outside of a part a surface point may be, in voxels, and still count as inside it: feet lie on the
/// surface to about a thousandth of a voxel. Less: specks of the parts behind; more: parts that end just below the
/// surface shine through.
pub(super) const TOLERANCE_VOXELS: f64 = 0.05;

/// Which attribute of shapes is asked for.
pub(super) trait Asked<const N: usize>: Copy {
    /// What a formula's numbers are.
    type Meaning: Copy;
    /// How values are mixed.
    type Mix: Mix<N> + 'static;

    /// A shape's own.
    fn source(self, shape: &Shape) -> Option<&AttributeSource<N, Self::Meaning, Self::Mix>>;

    /// What a shape has that has none, beside others that have one.
    fn absent(self) -> [f32; N];

    /// By formulas.
    fn by_fields(self, fields: [Arc<dyn Field>; N], meaning: Self::Meaning) -> Arc<dyn Attribute<N>>;

    /// What comes with a mesh.
    fn of_mesh(self, mesh: &Arc<MeshDistance>) -> Option<Arc<dyn Attribute<N>>>;

    /// Its own name among those of its kind.
    fn name(&self) -> &str;

    /// What was found of its kind.
    fn known(paints: &mut Paints) -> &mut Known<N>;

    /// What comes from the volume of voxels that a shape has it from.
    fn of_voxels(self, assets: &Assets, id: ShapeId) -> Arc<dyn Attribute<N>>;

    /// The problem of copies whose parts have several values.
    fn several(self, shape: &Shape) -> Problem;
}

/// What was found of one kind of attribute, by its name, the shape, how far that is made, and the voxel's edge as bits.
pub(super) type Known<const N: usize> = BTreeMap<(String, ShapeId, Stage, u64), Option<Paint<N>>>;

/// The attributes found at one moment: a shape that many others are made from is looked at once.
#[derive(Clone, Default)]
pub(super) struct Paints {
    colours: Known<3>,
    scalars: Known<1>,
}

/// The colour.
#[derive(Clone, Copy)]
pub(super) struct TheColour;

impl Asked<3> for TheColour {
    type Meaning = Components;
    type Mix = Mixer;

    fn source(self, shape: &Shape) -> Option<&ShapeColour> {
        shape.colour.as_ref()
    }

    fn absent(self) -> LinearRgb {
        css(GREY).expect("it is a colour")
    }

    fn by_fields(self, components: [Arc<dyn Field>; 3], meaning: Components) -> Arc<Colour> {
        Arc::new(ByFormula { components, meaning })
    }

    fn of_mesh(self, mesh: &Arc<MeshDistance>) -> Option<Arc<Colour>> {
        Some(Arc::new(VertexColours::new(Arc::clone(mesh))?))
    }

    fn name(&self) -> &str {
        ""
    }

    fn known(paints: &mut Paints) -> &mut Known<3> {
        &mut paints.colours
    }

    fn of_voxels(self, assets: &Assets, id: ShapeId) -> Arc<Colour> {
        Arc::clone(assets.colours(id)) as Arc<Colour>
    }

    fn several(self, shape: &Shape) -> Problem {
        Problem::new(shape.span, format!("the copies of `{}` cannot take its parts' several colours", shape.name))
            .help("give it a `color` of its own: one, or { palette = …, by = \"cell\" }")
    }
}

/// The scalar of a name.
#[derive(Clone, Copy)]
pub(super) struct TheScalar<'n>(pub &'n str);

impl Asked<1> for TheScalar<'_> {
    type Meaning = ();
    type Mix = Straight;

    fn source(self, shape: &Shape) -> Option<&ShapeScalar> {
        shape.scalars.get(self.0)
    }

    fn absent(self) -> [f32; 1] {
        [0.0]
    }

    fn by_fields(self, [field]: [Arc<dyn Field>; 1], (): ()) -> Arc<Scalar> {
        Arc::new(FieldValue(field))
    }

    fn of_mesh(self, _mesh: &Arc<MeshDistance>) -> Option<Arc<Scalar>> {
        None
    }

    fn name(&self) -> &str {
        self.0
    }

    fn known(paints: &mut Paints) -> &mut Known<1> {
        &mut paints.scalars
    }

    fn of_voxels(self, assets: &Assets, id: ShapeId) -> Arc<Scalar> {
        Arc::clone(assets.scalar(id, self.0)) as Arc<Scalar>
    }

    fn several(self, shape: &Shape) -> Problem {
        let Shape { name, span, .. } = shape;
        let problem = format!("the copies of `{name}` cannot take the several values of its parts' `{}`", self.0);
        let help = format!("give it an `attribute.{}` of its own: one, or {{ range = …, by = \"cell\" }}", self.0);
        Problem::new(*span, problem).help(help)
    }
}

/// An attribute, and whether it has one value everywhere.
#[derive(Clone)]
pub(super) struct Paint<const N: usize> {
    /// The attribute.
    pub attribute: Arc<dyn Attribute<N>>,
    solid: Option<[f32; N]>,
}

impl<const N: usize> Paint<N> {
    /// One value everywhere.
    pub fn solid(value: [f32; N]) -> Self {
        Self { attribute: Arc::new(Constant::new(value)), solid: Some(value) }
    }

    fn of(attribute: impl Attribute<N> + 'static) -> Self {
        Self::shared(Arc::new(attribute))
    }

    fn shared(attribute: Arc<dyn Attribute<N>>) -> Self {
        Self { attribute, solid: None }
    }

    /// Seen through a way; one value stays itself.
    fn through(self, way: Way) -> Self {
        match self.solid {
            Some(_) => self,
            None => Self::of(Placed { inner: self.attribute, way }),
        }
    }
}

/// The shapes of a list without those that come again: a part is a part once.
pub(super) fn last_of_each(shapes: &[ShapeId]) -> Vec<ShapeId> {
    let mut seen = BTreeSet::new();
    let mut last: Vec<ShapeId> = shapes.iter().rev().copied().filter(|id| seen.insert(*id)).collect();
    last.reverse();
    last
}

/// Whether a shape surely has an attribute, before anything of it is built: by its own source or a part's. (A mesh may
/// bring colours along.)
pub(super) fn surely_has<const N: usize>(model: &Model, what: impl Asked<N>, id: ShapeId) -> bool {
    // Each shape once, however many are made from it.
    let (mut seen, mut open) = (BTreeSet::from([id]), vec![id]);
    while let Some(id) = open.pop() {
        let shape = model.shape(id);
        if what.source(shape).is_some() {
            return true;
        }
        open.extend(shape.maker.painters().iter().filter(|part| seen.insert(**part)));
    }
    false
}

impl Solids {
    /// An attribute of a shape; `None` where neither it nor a part of it has one. `voxel` is a voxel's edge.
    pub fn paint<const N: usize, W: Asked<N>>(
        &mut self,
        what: W,
        id: ShapeId,
        stage: Stage,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        let key = (what.name().to_owned(), id, stage, voxel.to_bits());
        if let Some(known) = W::known(&mut self.paints).get(&key) {
            return Ok(known.clone());
        }
        let model = self.model();
        let shape = model.shape(id);
        let paint = match stage {
            Stage::Bare | Stage::Own => self.own_paint(what, id, shape, voxel)?,
            Stage::Scaled | Stage::Placed => match self.paint(what, id, Stage::Own, voxel)? {
                None => None,
                Some(own) => {
                    let map = self.placement(&shape.modifiers, stage)?;
                    Some(if map == DAffine3::IDENTITY { own } else { own.through(Way::Back(map.inverse())) })
                }
            },
        };
        W::known(&mut self.paints).insert(key, paint.clone());
        Ok(paint)
    }

    fn own_paint<const N: usize>(
        &mut self,
        what: impl Asked<N>,
        id: ShapeId,
        shape: &Shape,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        let paint = match what.source(shape) {
            Some(AttributeSource::Solid(value)) => return Ok(Some(Paint::solid(*value))),
            Some(AttributeSource::Formula { components, meaning, .. }) => {
                let mut fields = Vec::with_capacity(N);
                for component in components.iter() {
                    fields.push(self.component(component)?);
                }
                let fields = fields.try_into().unwrap_or_else(|_| unreachable!("one field a component"));
                Some(Paint::shared(what.by_fields(fields, *meaning)))
            }
            Some(AttributeSource::Random { choice, by, seed }) => {
                Some(self.at_random(id, choice.clone(), *by, *seed, voxel)?)
            }
            Some(AttributeSource::Bands(bands)) => Some(self.by_bands(id, bands.clone(), voxel)?),
            Some(AttributeSource::Parts { shapes, seam }) => {
                let paint = self.parts_paint(what, shapes, Rule::Union { seam: *seam }, voxel)?;
                Some(paint.unwrap_or_else(|| Paint::solid(what.absent())))
            }
            Some(AttributeSource::Voxels(_)) => Some(Paint::shared(what.of_voxels(self.assets(), id))),
            None => {
                let paint = self.made_paint(what, id, shape, voxel)?;
                if shape.modifiers.at.is_some() && paint.as_ref().is_some_and(|paint| paint.solid.is_none()) {
                    return Err(what.several(shape));
                }
                paint
            }
        };
        Ok(match shape.modifiers.mirror {
            Some(axis) => paint.map(|paint| paint.through(Way::Folded(axis))),
            None => paint,
        })
    }

    /// The attribute that comes with a maker.
    fn made_paint<const N: usize>(
        &mut self,
        what: impl Asked<N>,
        id: ShapeId,
        shape: &Shape,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        match &shape.maker {
            Maker::Mesh { .. } => Ok(what.of_mesh(self.assets().mesh(id)).map(Paint::shared)),
            Maker::Union { operands, seam } => self.parts_paint(what, operands, Rule::Union { seam: *seam }, voxel),
            Maker::Blend { operands, .. } => self.parts_paint(what, operands, Rule::Blend, voxel),
            maker => {
                for part in maker.painters() {
                    if let Some(paint) = self.paint(what, *part, Stage::Placed, voxel)? {
                        return Ok(Some(paint));
                    }
                }
                Ok(None)
            }
        }
    }

    fn parts_paint<const N: usize>(
        &mut self,
        what: impl Asked<N>,
        operands: &[ShapeId],
        rule: Rule,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        let operands = last_of_each(operands);
        let paints: Vec<Option<Paint<N>>> =
            operands.iter().map(|id| self.paint(what, *id, Stage::Placed, voxel)).collect::<Result<_, _>>()?;
        if paints.iter().all(Option::is_none) {
            return Ok(None);
        }
        let absent = || Paint::solid(what.absent());
        let paints: Vec<Paint<N>> = paints.into_iter().map(|paint| paint.unwrap_or_else(absent)).collect();
        let is_first = |paint: &Paint<N>| match paint.solid {
            Some(value) => paints[0].solid == Some(value),
            None => Arc::ptr_eq(&paint.attribute, &paints[0].attribute),
        };
        if paints.iter().all(is_first) {
            return Ok(paints.into_iter().next());
        }
        let mut parts: Vec<Part<N>> = Vec::with_capacity(operands.len());
        for (id, paint) in operands.iter().zip(paints) {
            parts.push((self.decider(*id, rule)?, paint.attribute));
        }
        Ok(Parts::new(parts, rule, TOLERANCE_VOXELS * voxel).map(Paint::of))
    }

    /// The field whose values tell where a part is, and how far away it is where they go over a seam.
    pub fn decider(&mut self, id: ShapeId, rule: Rule) -> Result<Arc<dyn Field>, Problem> {
        let plain = self.values(id)?;
        // What is endless can colour a seam, but nothing can measure it.
        let field = match rule {
            Rule::Union { seam } if seam > 0.0 && box_of(&plain).is_ok() => {
                let model = self.model();
                let shape = model.shape(id);
                let purpose = Purpose { shape, key: "seam", span: shape.span };
                self.distance_values(id, Interval::new(-seam / 2.0, seam / 2.0), &purpose)?
            }
            _ => plain,
        };
        Ok(Arc::new(field.keeping_values()))
    }

    pub fn component(&self, component: &Component) -> Result<Arc<dyn Field>, Problem> {
        let mut graph = Graph::new();
        let node = match component {
            Component::Number(number) => graph.constant(self.number(number)?),
            Component::Formula(formula) => formula.node(&mut graph, self.moment()),
        };
        Ok(Arc::new(Expression::new(&graph, node).keeping_values()))
    }

    fn at_random<const N: usize>(
        &mut self,
        id: ShapeId,
        choice: Choice<N, impl Mix<N> + 'static>,
        by: Pieces,
        seed: u64,
        voxel: f64,
    ) -> Result<Paint<N>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let cells: Arc<dyn CellIndex> = match (by, &shape.modifiers.at, &shape.maker) {
            (Pieces::Cubes(edge), ..) => {
                let solid = self.field(id, Stage::Bare)?;
                Arc::new(CubeLattice { edge, solid, tolerance: TOLERANCE_VOXELS * voxel })
            }
            (Pieces::Cells, Some(copies), _) => {
                let (cells, picked) = self.picked(copies)?;
                let host = self.host(copies.cells)?;
                Arc::new(NearestCopy::new(surface_points(host.as_ref(), &cells, &picked)))
            }
            (Pieces::Cells, None, Maker::Facet { cells, .. }) => {
                Arc::new(FacetCells { pieces: self.pieces(id)?, cells: self.cells(*cells)? })
            }
            _ => return Err(Problem::new(shape.span, format!("`{}` has no cells to take colours", shape.name))),
        };
        Ok(Paint::of(ByCell { cells, choice, seed }))
    }

    /// Bands need a distance: the shape is measured where nothing else tells it, once a point off its surface is asked for.
    /// They stand as before `displace`, which they may be what it goes by.
    fn by_bands<const N: usize>(
        &mut self,
        id: ShapeId,
        bands: Vec<(f64, [f32; N])>,
        voxel: f64,
    ) -> Result<Paint<N>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        // What lies before the first has the first's: it begins nowhere.
        let levels = match &bands[..] {
            [] | [_] => return Ok(Paint::solid(bands.first().map_or([0.0; N], |(_, value)| *value))),
            [_, (first, _), .., (last, _)] | [_, (first @ last, _)] => Interval::new(*first, *last),
        };
        let tolerance = TOLERANCE_VOXELS * voxel;
        let depth: Arc<Scalar> = match self.distance_without_measuring(id, levels)? {
            Some(distance) => Arc::new(FieldValue(distance)),
            None => {
                let solid = self.field(id, Stage::Bare)?;
                let aabb = solid_box(&model, id, solid.as_ref())?;
                let (failure, name, span) = (Arc::clone(self.failure()), shape.name.clone(), shape.span);
                let failed = move |error: BuildError| {
                    // Which of several comes first does not matter.
                    let _ = failure.set(Problem::new(span, format!("`{name}`: {error}")));
                };
                let (cancel, failed) = (Arc::clone(self.cancel()), Box::new(failed));
                Arc::new(Depth { solid, aabb, levels, voxel, tolerance, cancel, failed, measured: OnceLock::new() })
            }
        };
        let bands = Bands::new(depth, bands, tolerance);
        bands.map(Paint::of).ok_or_else(|| Problem::new(shape.span, "bands begin one below the other"))
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
struct NearestCopy {
    middles: PointTree,
    /// The copy of each of the tree's points.
    copies: Vec<u32>,
}

impl NearestCopy {
    fn new(middles: Vec<DVec3>) -> Self {
        let tree = PointTree::new(middles.clone());
        let mut copies = vec![0; middles.len()];
        // Of points in one place the tree tells always the same; it stands for the first copy there.
        for (copy, middle) in middles.iter().enumerate().rev() {
            if let Some((number, _)) = tree.nearest(*middle, None) {
                copies[number] = copy as u32;
            }
        }
        Self { middles: tree, copies }
    }
}

impl CellIndex for NearestCopy {
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]) {
        let positions: Vec<DVec3> = (0..points.len).map(|i| points.position(i)).collect();
        let mut nearest = Vec::with_capacity(BATCH);
        self.middles.nearest_each(&positions, &mut nearest);
        // No number comes back where there are no copies.
        out[..points.len].fill(0);
        for (out, number) in out.iter_mut().zip(nearest) {
            *out = self.copies[number];
        }
    }
}

/// A field with its attributes.
#[derive(Clone)]
pub(super) struct Scenery {
    /// F, world units.
    pub field: Arc<dyn Field>,
    /// The colour; `None` where there is none.
    pub colour: Option<Arc<Colour>>,
    /// The scalars by the names of their grids, sorted.
    pub scalars: Vec<(String, Arc<Scalar>)>,
}
