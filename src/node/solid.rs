//! Shapes as fields at one moment.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DVec3};

use crate::attribute::{CellIndex, Scalar};
use crate::distance::extent;
use crate::distance::method::Choice;
use crate::field::cells::{CellOptions, Cells};
use crate::field::facet::Pieces;
use crate::field::{Aabb, Expression, Field, Graph, Interval, Node, SetSystem, rotation};
use crate::morph::Morph;
use crate::node::argument::{Argument, Arguments, ScalarName};
use crate::node::assets::Assets;
use crate::node::attributes::{Paints, TheScalar};
use crate::node::bend::Bend;
use crate::node::cache::Cache;
use crate::node::displacement::{self, Displacement};
use crate::node::extent::{box_of, no_box, solid_box};
use crate::node::id::Stage;
use crate::node::insides::Insides;
use crate::node::keeping::{Keeping, Solid};
use crate::node::measured::{BESIDE_SURFACE, Distances, Purpose, SLACK, box_in_plane, told};
use crate::node::model::{CellsId, Fill, Model, Placement, Shape, ShapeId};
use crate::node::reading::Reading;
use crate::node::spec::{Build, Carries, Imported, Spec};
use crate::node::variation::Variation;
use crate::text::diagnostic::Diagnostic;
use crate::text::frames::{plain, sampled_frames};
use crate::text::key::Key;
use crate::text::moment::Moment;
use crate::text::number::Number;
use crate::text::number::formula::Formula;
use crate::text::problem::Problem;
use crate::text::source::Span;

/// Builds the fields of shapes at one moment, in one graph.
#[derive(Clone)]
pub(crate) struct Solids {
    model: Arc<Model>,
    assets: Arc<Assets>,
    moment: Moment,
    resolution: f64,
    /// Set to stop: what is being measured then ends as a problem, whose words do not matter.
    cancel: Arc<AtomicBool>,
    graph: Graph,
    made: BTreeMap<(ShapeId, Made), Node>,
    distances: Distances,
    /// Why something could not be measured that was asked for while a frame is made.
    failure: Arc<OnceLock<Problem>>,
    cells: BTreeMap<CellsId, Arc<Cells>>,
    /// Of shapes made by `facet`, as far as they are made.
    pieces: BTreeMap<ShapeId, Arc<Pieces>>,
    /// How steps of shapes bend space.
    bends: BTreeMap<(ShapeId, usize), Arc<dyn Bend>>,
    /// Of shapes made by `morph`, what is planned once.
    pub(crate) morphs: BTreeMap<ShapeId, Arc<Morph>>,
    /// The attributes found at this moment.
    pub(crate) paints: Paints,
    /// What follows the insides of shapes.
    pub(crate) insides: Insides,
}

/// Cells that can take colours, and the step of the shape that they are of.
type CellsOfStep = (usize, Arc<dyn CellIndex>);

/// A field and the box of what it is of.
type FieldInBox = (Arc<dyn Field>, Aabb);

/// What of a shape is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Made {
    /// With so many of its modifiers.
    Step(usize),
    Scaled,
    Placed,
}

impl Solids {
    /// Nothing built yet. `resolution` is about how many voxels go along the longest side of what is baked.
    pub fn new(
        model: &Arc<Model>,
        assets: &Arc<Assets>,
        moment: Moment,
        resolution: f64,
        cancel: &Arc<AtomicBool>,
    ) -> Self {
        let (model, assets) = (Arc::clone(model), Arc::clone(assets));
        Self {
            model,
            assets,
            moment,
            resolution,
            cancel: Arc::clone(cancel),
            graph: Graph::new(),
            made: BTreeMap::new(),
            distances: Distances::new(resolution, cancel),
            failure: Arc::default(),
            cells: BTreeMap::new(),
            pieces: BTreeMap::new(),
            bends: BTreeMap::new(),
            morphs: BTreeMap::new(),
            paints: Paints::default(),
            insides: Insides::default(),
        }
    }

    /// Keeps what is measured in a cache, and uses what is there.
    pub fn keep(&mut self, cache: &Arc<Cache>) {
        let keeping = Keeping::new(Arc::clone(cache), &self.model, self.moment.frame, self.resolution);
        self.distances.keep(keeping);
    }

    /// Where what is measured is kept.
    pub fn keeping(&self) -> Option<&Keeping> {
        self.distances.keeping()
    }

    /// The same at another moment: what does not change is kept.
    pub fn at(&self, moment: Moment, variation: &Variation) -> Self {
        let mut other = Self { moment, paints: Paints::default(), ..self.clone() };
        other.distances.go_to(other.moment.frame);
        other.made.retain(|(id, made), _| match made {
            Made::Step(step) => !variation.step(*id, *step),
            Made::Scaled | Made::Placed => !variation.placed(*id),
        });
        other.bends.retain(|(id, step), _| !variation.step(*id, *step));
        other.pieces.retain(|id, _| !variation.step(*id, 0));
        other.morphs.retain(|id, _| !variation.parts(&self.model, *id));
        other.cells.retain(|id, _| !variation.placed(self.model.cells[id.0].around));
        other.insides.keep_still(variation);
        other
    }

    /// A warning for each of the shapes that its `bounds` cut.
    pub fn cut_by_bounds(&mut self, shapes: &[ShapeId]) -> Result<Vec<(ShapeId, Diagnostic)>, Problem> {
        let model = self.model();
        let mut warnings = Vec::new();
        for &id in shapes {
            let shape = model.shape(id);
            let Some((step, bounds)) = shape.cuts().find(|(_, bounds)| !bounds.cut) else { continue };
            let node = self.step(id, step - 1)?;
            // Nothing inside at all is an error of the whole, said elsewhere.
            let field = Expression::new(&self.graph, node);
            // Most are not cut by far, which is told soon.
            let about = extent::about(&field, Some(bounds.aabb));
            if about.is_ok_and(|about| about.reaches_bounds == [false; 6]) {
                continue;
            }
            let Ok(found) = extent::extent(&field, Some(bounds.aabb)) else { continue };
            let sides = ["-x", "+x", "-y", "+y", "-z", "+z"];
            let cut: Vec<&str> =
                sides.into_iter().zip(found.reaches_bounds).filter(|(_, cut)| *cut).map(|(side, _)| side).collect();
            if !cut.is_empty() {
                let problem = format!("`bounds` cut `{}` off at {}{}", shape.name, cut.join(", "), self.at_frame());
                let warning = Diagnostic::warning(bounds.span, problem);
                let help = "widen them, or write `bounds = { box = …, cut = true }` where that is meant";
                warnings.push((id, warning.help(help)));
            }
        }
        Ok(warnings)
    }

    /// The frame in words, after what is said of it; nothing at the shot's first.
    fn at_frame(&self) -> String {
        let first = self.model.shot.range.first as f64;
        if self.moment.frame == first { String::new() } else { format!(" in frame {}", plain(self.moment.frame)) }
    }

    /// Builds now what does not change, so that [`Solids::at`] keeps it. What cannot be built is said when a frame
    /// needs it.
    pub fn build_still(&mut self, shapes: &[ShapeId], variation: &Variation) {
        let model = self.model();
        for &id in shapes {
            let shape = model.shape(id);
            if shape.spec.carries == Carries::Morph && !variation.parts(&model, id) {
                let _ = self.morphed(id);
            }
            // What is measured of parts that do not change is kept: operands of a blend that only move, and what changes
            // by its offset or its wall alone.
            let bare = shape.bare_steps();
            if let Some(step) = (0..=bare).find(|step| variation.step(id, *step)) {
                let (spec, arguments) = shape.step(step);
                if (spec.measures)(arguments) {
                    let _ = self.step(id, step);
                }
            }
            // Own before bare: what moves the surface now tells whether that is to be measured.
            let still = [(Stage::Own, variation.step(id, bare)), (Stage::Placed, variation.placed(id))];
            for (stage, _) in still.into_iter().filter(|(_, varies)| !varies) {
                let _ = self.node(id, stage);
            }
        }
    }

    /// A shape's field.
    pub fn field(&mut self, id: ShapeId, stage: Stage) -> Result<Arc<dyn Field>, Problem> {
        let node = self.node(id, stage)?;
        Ok(Arc::new(Expression::new(&self.graph, node)))
    }

    /// A node as a field of its own.
    pub(super) fn field_of(&self, node: Node) -> Arc<dyn Field> {
        Arc::new(Expression::new(&self.graph, node))
    }

    /// About how many voxels go along the longest side of what is baked.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Set to stop.
    pub fn cancel(&self) -> &Arc<AtomicBool> {
        &self.cancel
    }

    /// Told why something could not be measured that was asked for while a frame is made.
    pub fn failure(&self) -> &Arc<OnceLock<Problem>> {
        &self.failure
    }

    /// A shape before `displace` as a field that is the distance wherever that is one of `levels`, as far as it takes no
    /// measuring.
    pub fn distance_without_measuring(
        &mut self,
        id: ShapeId,
        levels: Interval,
    ) -> Result<Option<Arc<dyn Field>>, Problem> {
        let bare = self.node(id, Stage::Bare)?;
        let distance = told(&mut self.graph, bare, levels, self.model.shape(id).distance);
        Ok(distance.map(|distance| Arc::new(Expression::new(&self.graph, distance).keeping_values()) as Arc<dyn Field>))
    }

    /// The moment.
    pub fn moment(&self) -> &Moment {
        &self.moment
    }

    /// A number at the moment.
    pub fn number(&self, number: &Number) -> Result<f64, Problem> {
        Ok(number.at(&self.moment)?)
    }

    /// Three numbers at the moment.
    pub fn vector(&self, vector: &[Number; 3]) -> Result<DVec3, Problem> {
        Ok(DVec3::new(self.number(&vector[0])?, self.number(&vector[1])?, self.number(&vector[2])?))
    }

    /// Another field without a shape.
    pub fn without(&mut self, whole: Arc<dyn Field>, id: ShapeId) -> Result<Arc<dyn Field>, Problem> {
        let cut = self.node(id, Stage::Placed)?;
        let whole = self.graph.field(whole);
        // The values of both may be distances: the minimum keeps them so on one side.
        let node = self.graph.difference(SetSystem::MinMax, whole, &[cut]);
        Ok(Arc::new(Expression::new(&self.graph, node)))
    }

    /// A shape's surface moved; `None` where its field is no distance.
    pub fn moved(&mut self, id: ShapeId, displacement: &Displacement) -> Result<Option<Arc<dyn Field>>, Problem> {
        let whole = self.node(id, Stage::Placed)?;
        if !displacement.is_distance(self.graph.slope(whole)) {
            return Ok(None);
        }
        let node = displacement.apply(&mut self.graph, whole);
        Ok(Some(Arc::new(Expression::new(&self.graph, node))))
    }

    /// Another field, filled by a mixture of two shapes. `size` is about how large it is.
    pub fn filled(
        &mut self,
        whole: Arc<dyn Field>,
        fill: &Fill,
        omega: Arc<Scalar>,
        size: f64,
    ) -> Result<Arc<dyn Field>, Problem> {
        let [a, b] = fill.structures;
        let structures = [self.node(a, Stage::Placed)?, self.node(b, Stage::Placed)?];
        let whole = self.graph.field(whole);
        let node = displacement::filled(&mut self.graph, whole, structures, omega, size);
        Ok(Arc::new(Expression::new(&self.graph, node)))
    }

    /// A shape's field whose values hold everywhere, not only near the surface.
    pub fn values(&mut self, id: ShapeId) -> Result<Expression, Problem> {
        let node = self.node(id, Stage::Placed)?;
        Ok(Expression::new(&self.graph, node).keeping_values())
    }

    /// A shape of the plane, and its box there, of no height; `None` of one that leaves the plane.
    pub fn in_plane(&mut self, id: ShapeId, stage: Stage) -> Result<Option<FieldInBox>, Problem> {
        let node = self.node(id, stage)?;
        if !self.graph.is_flat(node) {
            return Ok(None);
        }
        let aabb = box_in_plane(&mut self.graph, node).map_err(|error| no_box(&self.model, id, error))?;
        let field = Expression::new(&self.graph, node).keeping_values();
        Ok(Some((Arc::new(field), aabb)))
    }

    /// A shape's distance where it stands, wherever that is one of `levels`, as a field whose values hold everywhere.
    pub fn distance_values(
        &mut self,
        id: ShapeId,
        levels: Interval,
        purpose: &Purpose<'_>,
    ) -> Result<Expression, Problem> {
        let node = self.placed_distance(id, levels, purpose)?;
        Ok(Expression::new(&self.graph, node).keeping_values())
    }

    /// The scene.
    pub fn model(&self) -> Arc<Model> {
        Arc::clone(&self.model)
    }

    /// What was read from its files.
    pub fn assets(&self) -> &Assets {
        &self.assets
    }

    /// What the file of a shape holds at the moment.
    pub fn imported(&self, id: ShapeId) -> Result<Arc<Imported>, Problem> {
        self.assets.imported(&self.model, id, self.moment.frame)
    }

    fn node(&mut self, id: ShapeId, stage: Stage) -> Result<Node, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let made = match stage {
            Stage::Bare => return self.step(id, shape.bare_steps()),
            Stage::Own => return self.step(id, shape.modifiers.len()),
            Stage::Scaled => Made::Scaled,
            Stage::Placed => Made::Placed,
        };
        if let Some(node) = self.made.get(&(id, made)) {
            return Ok(*node);
        }
        let own = self.node(id, Stage::Own)?;
        let map = self.placement(&shape.placement, stage)?;
        let node = self.transformed(own, &map, shape)?;
        self.made.insert((id, made), node);
        Ok(node)
    }

    /// A shape in its own space with so many of its modifiers.
    fn step(&mut self, id: ShapeId, step: usize) -> Result<Node, Problem> {
        let made = (id, Made::Step(step));
        if let Some(node) = self.made.get(&made) {
            return Ok(*node);
        }
        let model = self.model();
        let shape = model.shape(id);
        let mut build = Making::new(self, id, shape, step, "the field");
        let mut node = (build.spec.build)(&mut build)?;
        if let Some(bend) = self.bend(id, step)? {
            node = bend.node(&mut self.graph, node);
        }
        self.made.insert(made, node);
        Ok(node)
    }

    /// What is made of a shape's own keys in place of its field, where a map has it.
    pub(super) fn made_by(
        &mut self,
        id: ShapeId,
        map: &DAffine3,
        make: impl FnOnce(&mut dyn Build) -> Result<Option<Node>, Problem>,
    ) -> Result<Option<Node>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let made = make(&mut Making::new(self, id, shape, 0, "the field"))?;
        made.map(|node| self.transformed(node, map, shape)).transpose()
    }

    /// The cells of a shape that can take colours each, of its copies, else of what it is; and the step that they are of.
    pub fn cell_index(&mut self, id: ShapeId) -> Result<Option<CellsOfStep>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let of_step = |step: &usize| shape.spec_of(*step).cells.is_some();
        let Some(step) = (0..=shape.modifiers.len()).rev().find(of_step) else { return Ok(None) };
        let mut making = Making::new(self, id, shape, step, "the cells");
        let Some(cells) = making.spec.cells else { return Ok(None) };
        Ok(Some((step, cells(&mut making)?)))
    }

    /// How a step of a shape bends space.
    pub fn bend(&mut self, id: ShapeId, step: usize) -> Result<Option<Arc<dyn Bend>>, Problem> {
        if let Some(known) = self.bends.get(&(id, step)) {
            return Ok(Some(Arc::clone(known)));
        }
        let model = self.model();
        let mut making = Making::new(self, id, model.shape(id), step, "the bend");
        let Some(bend) = making.spec.bend else { return Ok(None) };
        let bend = bend(&mut making)?;
        self.bends.insert((id, step), Arc::clone(&bend));
        Ok(Some(bend))
    }

    /// The distance of a shape in its own space with so many of its modifiers, wherever that is one of `levels`, as a field
    /// whose values hold everywhere.
    pub fn step_distance(
        &mut self,
        (id, step): (ShapeId, usize),
        levels: Interval,
        purpose: &Purpose<'_>,
    ) -> Result<Expression, Problem> {
        let solid = self.step(id, step)?;
        let distance = self.distances.of(&mut self.graph, solid, levels, purpose)?;
        Ok(Expression::new(&self.graph, distance).keeping_values())
    }

    /// Whether that distance takes no measuring.
    pub fn is_told(&mut self, (id, step): (ShapeId, usize), levels: Interval, choice: Choice) -> Result<bool, Problem> {
        let solid = self.step(id, step)?;
        Ok(told(&mut self.graph, solid, levels, choice).is_some())
    }

    /// A shape in its own space with so many of its modifiers, as a field.
    pub fn step_field(&mut self, id: ShapeId, step: usize) -> Result<Arc<dyn Field>, Problem> {
        let node = self.step(id, step)?;
        Ok(Arc::new(Expression::new(&self.graph, node)))
    }

    /// Scale, then rotate, then move: from the shape's own space to where it stands.
    pub fn placement(&self, placement: &Placement, stage: Stage) -> Result<DAffine3, Problem> {
        let scale = self.vector(&placement.scale)?;
        if stage == Stage::Scaled {
            return Ok(DAffine3::from_scale(scale));
        }
        let degrees = self.vector(&placement.rotate)?;
        let by = self.vector(&placement.translate)?;
        let turn = DAffine3::from_mat3_translation(rotation(degrees), by);
        Ok(turn * DAffine3::from_scale(scale))
    }

    fn transformed(&mut self, node: Node, map: &DAffine3, shape: &Shape) -> Result<Node, Problem> {
        if *map == DAffine3::IDENTITY {
            return Ok(node);
        }
        self.graph.transform(node, map).map_err(|error| Problem::new(shape.span, format!("`{}`: {error}", shape.name)))
    }

    /// A solid that is another one grown by a distance, or lies within that: its box, where construction does not tell.
    fn held(&mut self, grown: Node, solid: Node, by: f64) -> Node {
        if self.graph.known_box(grown).is_some() {
            return grown;
        }
        match box_of(&Expression::new(&self.graph, solid)) {
            Ok(aabb) => self.graph.bounded(grown, aabb.grown(SLACK * by.max(0.0))),
            Err(_) => grown,
        }
    }

    /// What a number is over the shot.
    fn over_shot(&self, number: &Number) -> Result<Interval, Problem> {
        let now = self.number(number)?;
        let mut all = Interval::new(now, now);
        if self.model.varies(number) {
            for frame in sampled_frames(self.model.shot.range) {
                let then = number.at(&self.model.moment(frame))?;
                all = all.union(Interval::new(then, then));
            }
        }
        Ok(all)
    }

    /// The cells of an id.
    pub fn cells(&mut self, id: CellsId) -> Result<Arc<Cells>, Problem> {
        if let Some(cells) = self.cells.get(&id) {
            return Ok(Arc::clone(cells));
        }
        let model = self.model();
        let cells = &model.cells[id.0];
        let around = self.host(id)?;
        let options =
            CellOptions { depth: [cells.least_depth, cells.most_depth], chance: cells.chance, seed: cells.seed };
        let built = Cells::build(around.as_ref(), &options)
            .map_err(|error| Problem::new(cells.span, format!("`{}`: {error}", cells.name)))?;
        Ok(Arc::clone(self.cells.entry(id).or_insert(Arc::new(built))))
    }

    /// The pieces of a shape made by `facet`.
    pub fn pieces(&mut self, id: ShapeId) -> Result<Arc<Pieces>, Problem> {
        self.step(id, 0)?;
        Ok(Arc::clone(&self.pieces[&id]))
    }

    /// The field of the shape that cells stand around.
    pub fn host(&mut self, id: CellsId) -> Result<Arc<dyn Field>, Problem> {
        self.field(self.model.cells[id.0].around, Stage::Placed)
    }

    /// The distance of a shape where it stands wherever that is one of `levels`, positive inside. What moves without
    /// changing its shape is measured once.
    fn placed_distance(&mut self, id: ShapeId, levels: Interval, purpose: &Purpose<'_>) -> Result<Node, Problem> {
        let placed = self.node(id, Stage::Placed)?;
        let model = self.model();
        let shape = model.shape(id);
        let of = |stage| Solid::Stage(id, stage);
        let purpose = &Purpose { solid: of(Stage::Placed), choice: shape.distance, ..*purpose };
        if let Some(distance) = told(&mut self.graph, placed, levels, purpose.choice) {
            return Ok(distance);
        }
        let scale = self.vector(&shape.placement.scale)?;
        if scale != DVec3::splat(scale.x) {
            return self.distances.of(&mut self.graph, placed, levels, purpose);
        }
        let own = self.node(id, Stage::Own)?;
        let levels = Interval::new(levels.lo / scale.x, levels.hi / scale.x);
        let voxel = purpose.voxel.map(|voxel| voxel / scale.x);
        // The box of what is turned is another.
        let is_turned = self.vector(&shape.placement.rotate)? != DVec3::ZERO;
        let around = purpose.around.filter(|_| !is_turned).map(|around| around / scale.x);
        let purpose = Purpose { solid: of(Stage::Own), voxel, around, ..*purpose };
        let distance = self.distances.of(&mut self.graph, own, levels, &purpose)?;
        let map = self.placement(&shape.placement, Stage::Placed)?;
        self.transformed(distance, &map, shape)
    }
}

impl Solids {
    /// The distance of a shape where it stands, as far on both sides as the shape is large and around the box that it is asked
    /// for in, if there is one; beyond, the measured distance goes on. `key` needs it, at `span` of the scene.
    pub fn distance_around(
        &mut self,
        id: ShapeId,
        key: &str,
        span: Span,
        asked: Option<Aabb>,
    ) -> Result<Expression, Problem> {
        let model = self.model();
        // A shape of the plane has no end along z.
        let flat = if model.shape(id).is_flat { self.in_plane(id, Stage::Placed).ok().flatten() } else { None };
        let aabb = match flat {
            Some((_, aabb)) => Some(aabb),
            None => box_of(&self.values(id)?).ok(),
        };
        let size = aabb.map_or(1.0, |aabb| aabb.size().length().max(f64::MIN_POSITIVE));
        let shape = model.shape(id);
        let solid = Solid::Stage(id, Stage::Placed);
        let around = asked.zip(aabb).map(|(asked, aabb)| around(aabb, asked, size));
        let purpose = Purpose { solid, shape, key, span, voxel: None, around, choice: shape.distance };
        self.distance_values(id, Interval::new(-size, size), &purpose)
    }

    /// A formula of a shape at the moment, with further values that it reads by their names in it. `asked` is the box that it is
    /// asked for in, or a little beyond, if there is one.
    pub fn reading(
        &mut self,
        id: ShapeId,
        formula: &Formula,
        values: Vec<(String, Arc<dyn Field>)>,
        asked: Option<Aabb>,
    ) -> Result<Reading, Problem> {
        let model = self.model();
        let mut distances = values;
        for (name, shape) in formula.distances() {
            let other = model.shape(id).reads[shape];
            let distance = self.distance_around(other, "dist", formula.span(), asked)?;
            distances.push((name.to_owned(), Arc::new(distance)));
        }
        Ok(Reading::new(formula.clone(), self.moment().clone(), distances))
    }
}

/// How far around the box of a shape of some size its distance is measured where a box is asked for: the size or a part of it by
/// halves, so that many who ask share one. What is asked for a little beyond the box, as in a band, is within.
fn around(aabb: Aabb, asked: Aabb, size: f64) -> f64 {
    let beyond = (aabb.min - asked.min).max(asked.max - aabb.max).max_element().max(0.0) + size / 32.0;
    let mut around = size;
    while around / 2.0 >= beyond {
        around /= 2.0;
    }
    around
}

/// One step of a shape while it is built.
struct Making<'b> {
    solids: &'b mut Solids,
    id: ShapeId,
    shape: &'b Shape,
    step: usize,
    spec: &'static Spec,
    arguments: &'b Arguments,
    /// What of it is made.
    making: &'static str,
    /// How many distances it asked for.
    asked: usize,
}

impl<'b> Making<'b> {
    fn new(solids: &'b mut Solids, id: ShapeId, shape: &'b Shape, step: usize, making: &'static str) -> Self {
        let (spec, arguments) = shape.step(step);
        Self { solids, id, shape, step, spec, arguments, making, asked: 0 }
    }

    fn purpose(&mut self, key: &'static str) -> Purpose<'b> {
        let solid = Solid::Asked { id: self.id, step: self.step, making: self.making, before: self.asked };
        self.asked += 1;
        let span = match self.arguments.get(key) {
            Some(Argument::Number(number)) => number.span,
            Some(Argument::Scalar(name)) => name.span,
            _ => self.shape.span,
        };
        Purpose { solid, shape: self.shape, key, span, voxel: None, around: None, choice: self.shape.distance }
    }
}

impl Build for Making<'_> {
    fn graph(&mut self) -> &mut Graph {
        &mut self.solids.graph
    }

    fn arguments(&self) -> &Arguments {
        self.arguments
    }

    fn key(&self, name: &str) -> &'static Key {
        self.spec.keys().find(|key| key.name == name).expect("a row asks for its own keys")
    }

    fn moment(&self) -> &Moment {
        &self.solids.moment
    }

    fn over_shot(&self, number: &Number) -> Result<Interval, Problem> {
        self.solids.over_shot(number)
    }

    fn reading(&mut self, formula: &Formula) -> Result<Reading, Problem> {
        self.solids.reading(self.id, formula, Vec::new(), None)
    }

    fn inner(&mut self) -> Result<Node, Problem> {
        self.solids.step(self.id, self.step - 1)
    }

    fn bend(&mut self) -> Result<Arc<dyn Bend>, Problem> {
        let bend = self.solids.bend(self.id, self.step)?;
        Ok(bend.unwrap_or_else(|| unreachable!("a row asks for its own")))
    }

    fn shape(&mut self, id: ShapeId) -> Result<Node, Problem> {
        self.solids.node(id, Stage::Placed)
    }

    fn graded(
        &mut self,
        ends: [ShapeId; 2],
        by: (&ScalarName, Arc<dyn Field>),
        solid: (Node, Aabb),
    ) -> Result<Option<Node>, Problem> {
        self.solids.graded(ends, by, solid)
    }

    fn distance(&mut self, solid: Node, levels: Interval, key: &'static str) -> Result<Node, Problem> {
        let purpose = self.purpose(key);
        let Solids { graph, distances, .. } = &mut *self.solids;
        distances.of(graph, solid, levels, &purpose)
    }

    fn shape_distance(&mut self, id: ShapeId, levels: Interval, key: &'static str) -> Result<Node, Problem> {
        let purpose = self.purpose(key);
        self.solids.placed_distance(id, levels, &purpose)
    }

    fn moving_distance(&mut self, solid: Node, levels: Interval, key: &'static str) -> Result<Node, Problem> {
        match told(&mut self.solids.graph, solid, levels, self.shape.distance) {
            Some(distance) => Ok(distance),
            // The same in every frame, wherever a scalar moves the surface in each.
            None => self.distance(solid, BESIDE_SURFACE, key),
        }
    }

    fn held(&mut self, grown: Node, solid: Node, by: f64) -> Node {
        self.solids.held(grown, solid, by)
    }

    fn solid_box(&self, node: Node) -> Result<Aabb, Problem> {
        solid_box(&self.solids.model, self.id, &Expression::new(&self.solids.graph, node))
    }

    fn scalar(&mut self, name: &str, solid: Aabb) -> Result<Option<Arc<Scalar>>, Problem> {
        // The lattice follows from the shape's box; no shape has more voxels than the whole, but where it is scaled.
        let voxel = solid.size().max_element() / self.solids.resolution;
        let paint = self.solids.paint_before(TheScalar(name), self.id, self.step - 1, voxel)?;
        Ok(paint.map(|paint| paint.attribute))
    }

    fn name(&self) -> &str {
        &self.shape.name
    }

    fn span(&self) -> Span {
        self.shape.span
    }

    fn cells(&mut self, id: CellsId) -> Result<Arc<Cells>, Problem> {
        self.solids.cells(id)
    }

    fn host(&mut self, id: CellsId) -> Result<Arc<dyn Field>, Problem> {
        self.solids.host(id)
    }

    fn morph(&mut self) -> Result<Arc<Morph>, Problem> {
        self.solids.morphed(self.id)
    }

    fn pieces(&mut self) -> Result<Arc<Pieces>, Problem> {
        self.solids.pieces(self.id)
    }

    fn keep_pieces(&mut self, pieces: Pieces) {
        self.solids.pieces.insert(self.id, Arc::new(pieces));
    }

    fn imported(&self) -> Result<Arc<Imported>, Problem> {
        self.solids.imported(self.id)
    }

    fn needs_distance(&self) -> bool {
        self.solids.model.content.shows(self.id) || self.shape.is_measured()
    }
}
