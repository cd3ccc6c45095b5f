//! Colours and scalars of shapes at one moment.

use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use glam::DAffine3;

use crate::attribute::{Attribute, CellIndex, FieldValue, Part, Parts, Rule, Scalar, ScalarField};
use crate::distance::octree::BuildError;
use crate::field::{Aabb, Expression, Field, Graph, Interval};
use crate::mesh::NumberOf;
use crate::node::argument::{Arguments, Component};
use crate::node::attributes::{Asked, TheScalar};
use crate::node::depth::Depth;
use crate::node::extent::{box_about, box_of, solid_box};
use crate::node::id::Stage;
use crate::node::keeping::Solid;
use crate::node::measured::Purpose;
use crate::node::model::{Model, Shape, ShapeId};
use crate::node::painted::Paint;
use crate::node::placed::Way;
use crate::node::solid::Solids;
use crate::node::source::{Inside, InsideRequest, Sourcing, TOLERANCE_VOXELS};
use crate::node::spec::Carries;
use crate::text::problem::Problem;

/// The shapes of a list without those that come again: a part is a part once.
pub(crate) fn last_of_each(shapes: &[ShapeId]) -> Vec<ShapeId> {
    let mut seen = BTreeSet::new();
    let mut last: Vec<ShapeId> = shapes.iter().rev().copied().filter(|id| seen.insert(*id)).collect();
    last.reverse();
    last
}

/// Whether a shape surely has an attribute, before anything of it is built: by its own source or a part's. (A mesh may
/// bring colours along.)
pub(crate) fn surely_has<const N: usize>(model: &Model, what: impl Asked<N>, id: ShapeId) -> bool {
    // Each shape once, however many are made from it.
    let (mut seen, mut open) = (BTreeSet::from([id]), vec![id]);
    while let Some(id) = open.pop() {
        let shape = model.shape(id);
        if what.source(shape).is_some() {
            return true;
        }
        open.extend(shape.painters().iter().filter(|part| seen.insert(**part)));
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
            Stage::Bare | Stage::Own => self.own_paint(what, id, shape.modifiers.len(), voxel)?,
            Stage::Scaled | Stage::Placed => match self.paint(what, id, Stage::Own, voxel)? {
                None => None,
                Some(own) => {
                    let map = self.placement(&shape.placement, stage)?;
                    Some(if map == DAffine3::IDENTITY { own } else { own.through(Way::Back(map.inverse())) })
                }
            },
        };
        W::known(&mut self.paints).insert(key, paint.clone());
        Ok(paint)
    }

    /// An attribute of a shape in its own space with so many of its modifiers.
    pub fn paint_before<const N: usize, W: Asked<N>>(
        &mut self,
        what: W,
        id: ShapeId,
        step: usize,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let last = shape.modifiers.len();
        if shape.before_bends(step, last) == last {
            return self.paint(what, id, Stage::Own, voxel);
        }
        self.own_paint(what, id, step, voxel)
    }

    fn own_paint<const N: usize>(
        &mut self,
        what: impl Asked<N>,
        id: ShapeId,
        step: usize,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let (paint, stands) = match what.source(shape) {
            Some(given) => {
                let (arguments, stands) = (&given.arguments, shape.painted_step());
                let mut painting = Painting { solids: self, what, id, shape, arguments, voxel, stands };
                let paint = (given.source.build)(&mut painting)?;
                (Some(paint), painting.stands)
            }
            None => {
                let paint = self.made_paint(what, id, shape, voxel)?;
                if shape.is_copied() && paint.as_ref().is_some_and(|paint| paint.solid.is_none()) {
                    return Err(what.several(shape));
                }
                (paint, shape.painted_step())
            }
        };
        let Some(mut paint) = paint else { return Ok(None) };
        for step in stands + 1..=step {
            if let Some(bend) = self.bend(id, step)? {
                paint = paint.through(Way::Bent(bend));
            }
        }
        Ok(Some(paint))
    }

    /// The attribute that comes with a maker.
    fn made_paint<const N: usize>(
        &mut self,
        what: impl Asked<N>,
        id: ShapeId,
        shape: &Shape,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        match shape.spec.carries {
            Carries::Import => Ok(what.of_import(&*self.imported(id)?, voxel).map(Paint::shared)),
            Carries::Union => self.parts_paint(what, shape.painters(), Rule::Union { seam: shape.seam() }, voxel),
            Carries::Blend if shape.arguments.number("mix").is_some() => self.transferred_paint(what, id, voxel),
            Carries::Blend => self.parts_paint(what, shape.painters(), Rule::Blend, voxel),
            Carries::Morph => self.morphed_paint(what, id, voxel),
            Carries::Nothing | Carries::Any | Carries::First => {
                for part in shape.painters() {
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
                let (span, choice, solid) = (shape.span, shape.distance, Solid::Stage(id, Stage::Placed));
                let purpose = Purpose { solid, shape, key: "seam", span, voxel: None, around: None, choice };
                self.distance_values(id, Interval::new(-seam / 2.0, seam / 2.0), &purpose)?
            }
            _ => plain,
        };
        Ok(Arc::new(field))
    }

    /// A number or formula as a field; `of`: the shape whose formula it is, if it may read others, and the box that it is asked
    /// for in, if there is one; `values`: further ones that it may name.
    pub fn component(
        &mut self,
        of: Option<(ShapeId, Option<Aabb>)>,
        component: &Component,
        values: Vec<(String, Arc<dyn Field>)>,
    ) -> Result<Arc<dyn Field>, Problem> {
        let mut graph = Graph::new();
        let node = match (component, of) {
            (Component::Number(number), _) => graph.constant(self.number(number)?),
            (Component::Formula(formula), Some((id, asked))) => {
                self.reading(id, formula, values, asked)?.node(&mut graph)
            }
            (Component::Formula(formula), None) => formula.node_of(&mut graph, self.moment(), &[]),
        };
        Ok(Arc::new(Expression::new(&graph, node).keeping_values()))
    }
}

/// An attribute of one shape while it is built.
struct Painting<'b, W> {
    solids: &'b mut Solids,
    what: W,
    id: ShapeId,
    shape: &'b Shape,
    arguments: &'b Arguments,
    voxel: f64,
    /// The step after which it stands in the shape's space.
    stands: usize,
}

impl<W> Painting<'_, W> {
    /// A scalar of the shape that a formula names.
    fn named(&mut self, name: &str) -> Result<Arc<dyn Field>, Problem> {
        let shape = self.shape;
        let given = &shape.scalars[name];
        let mut painting = Painting {
            solids: &mut *self.solids,
            what: TheScalar(name),
            id: self.id,
            shape,
            arguments: &given.arguments,
            voxel: self.voxel,
            stands: shape.painted_step(),
        };
        let paint = (given.source.build)(&mut painting)?;
        // A formula stands in the space before what bends it.
        let stands = painting.stands;
        if shape.before_bends(self.stands, stands) < stands {
            let problem = format!("`{name}` goes by the depth below a surface that is bent after this formula");
            return Err(Problem::new(self.shape.span, problem).help("bend another shape that has it as a part"));
        }
        Ok(Arc::new(ScalarField { scalar: paint.attribute, most: f64::INFINITY, step: self.voxel }))
    }
}

impl<const N: usize, W: Asked<N>> Sourcing<N> for Painting<'_, W> {
    fn arguments(&self) -> &Arguments {
        self.arguments
    }

    fn component(&mut self, component: &Component) -> Result<Arc<dyn Field>, Problem> {
        let mut values: Vec<(String, Arc<dyn Field>)> = Vec::new();
        let mut asked = None;
        if let Component::Formula(formula) = component {
            for name in formula.given() {
                values.push((name.to_owned(), self.named(name)?));
            }
            if formula.distances().next().is_some() {
                asked = box_about(self.solid()?.as_ref()).ok();
            }
        }
        self.solids.component(Some((self.id, asked)), component, values)
    }

    fn solid(&mut self) -> Result<Arc<dyn Field>, Problem> {
        let step = self.shape.before_bends(self.stands, self.shape.bare_steps().max(self.stands));
        self.solids.step_field(self.id, step)
    }

    fn voxel(&self) -> f64 {
        self.voxel
    }

    fn shape(&mut self, id: ShapeId) -> Result<Arc<dyn Field>, Problem> {
        self.solids.field(id, Stage::Placed)
    }

    fn cancel(&self) -> Arc<AtomicBool> {
        Arc::clone(self.solids.cancel())
    }

    fn cells(&mut self) -> Result<Arc<dyn CellIndex>, Problem> {
        let problem = || Problem::new(self.shape.span, format!("`{}` has no cells to take colours", self.shape.name));
        let (step, cells) = self.solids.cell_index(self.id)?.ok_or_else(problem)?;
        self.stands = step;
        Ok(cells)
    }

    fn parts(&mut self, shapes: &[ShapeId], rule: Rule) -> Result<Option<Paint<N>>, Problem> {
        self.solids.parts_paint(self.what, shapes, rule, self.voxel)
    }

    /// The shape is measured where nothing else tells its distance, once a point off its surface is asked for.
    fn depth(&mut self, levels: Interval) -> Result<Arc<Scalar>, Problem> {
        let (id, voxel) = (self.id, self.voxel);
        // The depth is that below the surface of the bent shape.
        self.stands = self.shape.bare_steps();
        if let Some(distance) = self.solids.distance_without_measuring(id, levels)? {
            return Ok(Arc::new(FieldValue(distance)));
        }
        let solid = self.solids.field(id, Stage::Bare)?;
        let aabb = solid_box(&self.solids.model(), id, solid.as_ref())?;
        let (failure, name, span) = (Arc::clone(self.solids.failure()), self.shape.name.clone(), self.shape.span);
        let failed = Box::new(move |error: BuildError| {
            // Which of several comes first does not matter.
            let _ = failure.set(Problem::new(span, format!("`{name}`: {error}")));
        });
        let cancel = Arc::clone(self.solids.cancel());
        let tolerance = TOLERANCE_VOXELS * voxel;
        let (choice, measured) = (self.shape.distance, OnceLock::new());
        let kept = self.solids.keeping().cloned().map(|keeping| (keeping, Solid::Stage(id, Stage::Bare)));
        Ok(Arc::new(Depth { solid, aabb, levels, voxel, tolerance, choice, kept, cancel, failed, measured }))
    }

    fn inside(&mut self, asked: &InsideRequest<'_>) -> Result<Inside, Problem> {
        let step = self.shape.before_bends(self.stands, self.shape.bare_steps().max(self.stands));
        self.solids.inside((self.id, step), asked)
    }

    fn of_shape(&mut self, shape: ShapeId) -> Result<Option<Paint<N>>, Problem> {
        self.solids.paint(self.what, shape, Stage::Placed, self.voxel)
    }

    fn volume(&self) -> Result<Arc<dyn Attribute<N>>, Problem> {
        self.what.of_voxels(self.solids.assets(), &self.solids.model(), self.id, self.solids.moment().frame)
    }

    fn of_material(&self, which: NumberOf) -> Result<Arc<Scalar>, Problem> {
        let (model, name) = (self.solids.model(), &self.shape.name);
        let problem = |message: String| Problem::new(self.shape.span, message);
        if self.shape.spec.import.is_none() {
            let problem = problem(format!("`{name}` has no materials: only a shape of a `mesh` has"));
            return Err(problem.help("shapes made of it carry the attribute"));
        }
        let import = self.solids.assets().imported(&model, self.id, self.solids.moment().frame)?;
        let found = import.materials.as_ref().and_then(|materials| materials(which, self.voxel));
        found.ok_or_else(|| {
            let which = if which == NumberOf::Roughness { "roughness" } else { "metallic" };
            problem(format!("no material in the file of `{name}` says its {which}"))
                .help("glTF says it, and MTL by `Pr`, `Pm`, `map_Pr` and `map_Pm`")
        })
    }

    fn absent(&self) -> [f32; N] {
        self.what.absent()
    }

    fn none_has(&self, shapes: &[ShapeId]) -> Problem {
        let model = self.solids.model();
        let names: Vec<String> = shapes.iter().map(|id| format!("`{}`", model.shape(*id).name)).collect();
        let what = match self.what.name() {
            "" => "a colour".into(),
            name => format!("`attribute.{name}`"),
        };
        let problem = format!("`{}` takes {what} from {}, and none of them has it", self.shape.name, names.join(", "));
        self.problem(&problem).help(format!("give {what} to one of them, or leave it out here"))
    }

    fn problem(&self, message: &str) -> Problem {
        Problem::new(self.shape.span, message)
    }
}
