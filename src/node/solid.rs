//! Shapes as fields at one moment.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DVec3};

use crate::attribute::Scalar;
use crate::field::cells::{CellId, CellOptions, Cells};
use crate::field::facet::{Options, Pieces, facet, scatter};
use crate::field::{Blend, BlendBounds, Expression, Field, Graph, Interval, Node, SetSystem, rotation};

use crate::distance::extent::extent;

use crate::node::assets::Assets;
use crate::node::displace::{self, Displacement};
use crate::node::extent::{box_of, solid_box};
use crate::node::measured::{BESIDE_SURFACE, Distances, Purpose, SLACK, told};
use crate::node::model::{CellsId, Copies, Fill, Maker, Model, Modifiers, ScalarName, Shape, ShapeId};
use crate::node::paint::{Paints, TheScalar};
use crate::node::variation::Variation;
use crate::text::diagnostic::Diagnostic;
use crate::text::frames::sampled_frames;
use crate::text::key::LEAST;
use crate::text::moment::Moment;
use crate::text::number::Number;
use crate::text::problem::Problem;

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
    made: BTreeMap<(ShapeId, Stage), Node>,
    distances: Distances,
    /// Why something could not be measured that was asked for while a frame is made.
    failure: Arc<OnceLock<Problem>>,
    cells: BTreeMap<CellsId, Arc<Cells>>,
    /// Of shapes made by `facet`, as far as they are made.
    pieces: BTreeMap<ShapeId, Arc<Pieces>>,
    /// The attributes found at this moment.
    pub(crate) paints: Paints,
}

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
            paints: Paints::default(),
        }
    }

    /// The same at another moment: what does not change is kept.
    pub fn at(&self, moment: Moment, variation: &Variation) -> Self {
        let mut other = Self { moment, paints: Paints::default(), ..self.clone() };
        other.made.retain(|(id, stage), _| match stage {
            Stage::Bare => !variation.bare(*id),
            Stage::Own => !variation.own(*id),
            Stage::Scaled | Stage::Placed => !variation.placed(*id),
        });
        other.pieces.retain(|id, _| !variation.bare(*id));
        other.cells.retain(|id, _| !variation.placed(self.model.cells[id.0].around));
        other
    }

    /// A warning for each of the shapes that its `bounds` cut.
    pub fn cut_by_bounds(&mut self, shapes: &[ShapeId]) -> Result<Vec<Diagnostic>, Problem> {
        let model = self.model();
        let mut warnings = Vec::new();
        for &id in shapes {
            let shape = model.shape(id);
            let Some(bounds) = shape.bounds.filter(|bounds| !bounds.cut) else { continue };
            let node = self.made_by(id, shape)?;
            // Nothing inside at all is an error of the whole, said elsewhere.
            let Ok(found) = extent(&Expression::new(&self.graph, node), Some(bounds.aabb)) else { continue };
            let sides = ["-x", "+x", "-y", "+y", "-z", "+z"];
            let cut: Vec<&str> =
                sides.into_iter().zip(found.reaches_bounds).filter(|(_, cut)| *cut).map(|(side, _)| side).collect();
            if !cut.is_empty() {
                let problem = format!("`bounds` cut `{}` off at {}", shape.name, cut.join(", "));
                warnings.push(
                    Diagnostic::warning(bounds.span, problem)
                        .help("widen them, or write `bounds = { box = …, cut = true }` where that is meant"),
                );
            }
        }
        Ok(warnings)
    }

    /// Builds now what does not change, so that [`Solids::at`] keeps it. What cannot be built is said when a frame
    /// needs it.
    pub fn build_still(&mut self, shapes: &[ShapeId], variation: &Variation) {
        let model = self.model();
        for &id in shapes {
            // Operands of a blend that move without changing are measured once.
            if variation.whole(id) && matches!(model.shape(id).maker, Maker::Blend { .. }) {
                let _ = self.made_by(id, model.shape(id));
            }
            // The distance of what changes by its offset or its wall alone is kept.
            if variation.bare(id) && !variation.grown(id) {
                let _ = self.bare(id, model.shape(id));
            } else if variation.grown(id) && !variation.whole(id) {
                let _ = self.grown(id, model.shape(id));
            }
            // Own before bare: what moves the surface now tells whether that is to be measured.
            let still = [(Stage::Own, variation.bare(id)), (Stage::Placed, variation.placed(id))];
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
        let distance = told(&mut self.graph, bare, levels);
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

    /// A number at the moment, or another where there is none.
    fn number_or(&self, number: &Option<Number>, otherwise: f64) -> Result<f64, Problem> {
        number.as_ref().map_or(Ok(otherwise), |number| self.number(number))
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
        let node = displace::filled(&mut self.graph, whole, structures, omega, size);
        Ok(Arc::new(Expression::new(&self.graph, node)))
    }

    /// A shape's field whose values hold everywhere, not only near the surface.
    pub fn values(&mut self, id: ShapeId) -> Result<Expression, Problem> {
        let node = self.node(id, Stage::Placed)?;
        Ok(Expression::new(&self.graph, node).keeping_values())
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

    /// Its meshes.
    pub fn assets(&self) -> &Assets {
        &self.assets
    }

    fn node(&mut self, id: ShapeId, stage: Stage) -> Result<Node, Problem> {
        if let Some(node) = self.made.get(&(id, stage)) {
            return Ok(*node);
        }
        let model = self.model();
        let shape = model.shape(id);
        let node = match stage {
            Stage::Bare => self.bare(id, shape)?,
            Stage::Own => match &shape.modifiers.displace {
                Some(by) => self.displaced(id, shape, by)?,
                None => self.node(id, Stage::Bare)?,
            },
            Stage::Scaled | Stage::Placed => {
                let own = self.node(id, Stage::Own)?;
                let map = self.placement(&shape.modifiers, stage)?;
                self.transformed(own, &map, shape)?
            }
        };
        self.made.insert((id, stage), node);
        Ok(node)
    }

    /// Scale, then rotate, then move: from the shape's own space to where it stands.
    pub fn placement(&self, modifiers: &Modifiers, stage: Stage) -> Result<DAffine3, Problem> {
        let scale = self.vector(&modifiers.scale)?;
        if stage == Stage::Scaled {
            return Ok(DAffine3::from_scale(scale));
        }
        let degrees = self.vector(&modifiers.rotate)?;
        let by = self.vector(&modifiers.translate)?;
        let turn = DAffine3::from_mat3_translation(rotation(degrees), by);
        Ok(turn * DAffine3::from_scale(scale))
    }

    fn transformed(&mut self, node: Node, map: &DAffine3, shape: &Shape) -> Result<Node, Problem> {
        if *map == DAffine3::IDENTITY {
            return Ok(node);
        }
        self.graph.transform(node, map).map_err(|error| Problem::new(shape.span, format!("`{}`: {error}", shape.name)))
    }

    /// All but `offset` and what comes after it.
    fn whole(&mut self, id: ShapeId, shape: &Shape) -> Result<Node, Problem> {
        let mut node = self.made_by(id, shape)?;
        let modifiers = &shape.modifiers;
        if let Some(bounds) = shape.bounds {
            let aabb = bounds.aabb;
            let cuboid = self.graph.cuboid(aabb.size());
            let placed = DAffine3::from_translation(aabb.centre());
            let cuboid = self.transformed(cuboid, &placed, shape)?;
            node = self.graph.intersection(SetSystem::R0, &[node, cuboid]);
        }
        if let Some(copies) = &modifiers.at {
            node = self.copies(node, copies)?;
        }
        if let Some(axis) = modifiers.mirror {
            node = self.graph.mirror(node, DVec3::AXES[axis], 0.0);
        }
        Ok(node)
    }

    /// All but `shell` and what comes after it.
    fn grown(&mut self, id: ShapeId, shape: &Shape) -> Result<Node, Problem> {
        let whole = self.whole(id, shape)?;
        let offset = &shape.modifiers.offset;
        let (now, ever) = (self.number(offset)?, self.over_shot(offset)?);
        let purpose = Purpose { shape, key: "offset", span: offset.span };
        let distance = self.distances.of(&mut self.graph, whole, Interval::new(-ever.hi, -ever.lo), &purpose)?;
        if now == 0.0 {
            return Ok(whole);
        }
        let grown = self.graph.offset(distance, now);
        Ok(self.held(grown, whole, now))
    }

    fn bare(&mut self, id: ShapeId, shape: &Shape) -> Result<Node, Problem> {
        let grown = self.grown(id, shape)?;
        let Some(shell) = &shape.modifiers.shell else { return Ok(grown) };
        let (thickness, ever) = (self.number(shell)?, self.over_shot(shell)?);
        let purpose = Purpose { shape, key: "shell", span: shell.span };
        let (least, most) = (ever.lo / 2.0, ever.hi / 2.0);
        let (outside, inside) = (Interval::new(-most, -least), Interval::new(least, most));
        let outside = self.distances.of(&mut self.graph, grown, outside, &purpose)?;
        let inside = self.distances.of(&mut self.graph, grown, inside, &purpose)?;
        let wall = self.graph.wall(outside, inside, thickness);
        Ok(self.held(wall, grown, thickness / 2.0))
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

    fn displaced(&mut self, id: ShapeId, shape: &Shape, by: &ScalarName) -> Result<Node, Problem> {
        let bare = self.node(id, Stage::Bare)?;
        let field = Expression::new(&self.graph, bare);
        let solid = solid_box(&self.model, id, &field)?;
        // The lattice follows from the shape's box; no shape has more voxels than the whole, but where it is scaled.
        let voxel = solid.size().max_element() / self.resolution;
        let Some(paint) = self.paint(TheScalar(&by.name), id, Stage::Own, voxel)? else { return Ok(bare) };
        let displacement = Displacement::new(paint.attribute, solid)
            .ok_or_else(|| displace::no_greatest(by.span, &by.name, &shape.name))?;
        let distance = match told(&mut self.graph, bare, displacement.levels()) {
            Some(distance) => distance,
            // The same in every frame, wherever the scalar moves the surface in each.
            None => {
                let purpose = Purpose { shape, key: "displace", span: by.span };
                self.distances.of(&mut self.graph, bare, BESIDE_SURFACE, &purpose)?
            }
        };
        Ok(displacement.apply(&mut self.graph, distance))
    }

    fn made_by(&mut self, id: ShapeId, shape: &Shape) -> Result<Node, Problem> {
        Ok(match &shape.maker {
            Maker::Sphere { radius } => {
                let radius = self.number(radius)?;
                self.graph.sphere(radius)
            }
            Maker::Box { edges } => {
                let edges = self.vector(edges)?;
                self.graph.cuboid(edges)
            }
            Maker::Ellipsoid { half_axes } => {
                let half_axes = self.vector(half_axes)?;
                self.graph.ellipsoid(half_axes)
            }
            Maker::Cylinder { radius, height } => {
                let radius = self.number(radius)?;
                let height = self.number_or(height, 2.0 * radius)?;
                self.graph.cylinder(radius, height)
            }
            Maker::Torus { radius, tube } => {
                let radius = self.number(radius)?;
                let tube = self.number_or(tube, 0.25 * radius)?;
                self.graph.torus(radius, tube)
            }
            Maker::Capsule { radius, length } => {
                let radius = self.number(radius)?;
                let length = self.number_or(length, 2.0 * radius)?;
                self.graph.capsule(radius, length)
            }
            Maker::HalfSpace { normal, offset } => {
                let (normal, offset) = (self.direction(normal)?, self.number(offset)?);
                self.graph.half_space(normal, offset)
            }
            Maker::Slab { thickness, normal } => {
                let (normal, thickness) = (self.direction(normal)?, self.number(thickness)?);
                self.graph.slab(normal, thickness)
            }
            Maker::Heart { width } => {
                let width = self.number(width)?;
                self.graph.heart(width)
            }
            Maker::Formula { formula, .. } => formula.node(&mut self.graph, &self.moment),
            Maker::Mesh { .. } => {
                let mesh = Arc::clone(self.assets.mesh(id));
                // An operand is asked for its sign and its creases far more often than for its exact distance.
                // What grows needs the distance: planes are none beside edges.
                let asked_for_sign = !self.model.content.shows(id) && !shape.modifiers.may_grow();
                match mesh.half_spaces().filter(|_| asked_for_sign) {
                    Some(planes) => {
                        let faces: Vec<Node> =
                            planes.into_iter().map(|(normal, offset)| self.graph.half_space(normal, offset)).collect();
                        let solid = self.graph.intersection(SetSystem::MinMax, &faces);
                        self.graph.bounded(solid, mesh.mesh().bounding_box())
                    }
                    None => self.graph.field(mesh),
                }
            }
            Maker::Facet { of, cells, tilt, cut, seed } => {
                let cells = self.cells(*cells)?;
                let whole = self.node(*of, Stage::Placed)?;
                let options = Options { tilt: *tilt, cut: *cut, seed: *seed };
                let made = facet(&mut self.graph, whole, &cells, &options);
                self.pieces.insert(id, Arc::new(made.pieces));
                made.node
            }
            Maker::Union { operands, .. } => {
                let nodes = self.different(operands)?;
                self.graph.union(SetSystem::R0, &nodes)
            }
            Maker::Intersection(operands) => {
                let nodes = self.different(operands)?;
                self.graph.intersection(SetSystem::R0, &nodes)
            }
            Maker::Difference(operands) => {
                let nodes = self.nodes(operands)?;
                self.graph.difference(SetSystem::R0, nodes[0], &nodes[1..])
            }
            Maker::Blend { operands, radius, within } => self.blend(operands, radius, *within, shape)?,
        })
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
        self.node(id, Stage::Bare)?;
        Ok(Arc::clone(&self.pieces[&id]))
    }

    /// The field of the shape that cells stand around.
    pub fn host(&mut self, id: CellsId) -> Result<Arc<dyn Field>, Problem> {
        self.field(self.model.cells[id.0].around, Stage::Placed)
    }

    /// The cells of copies, and which of them get one.
    pub fn picked(&mut self, copies: &Copies) -> Result<(Arc<Cells>, Vec<CellId>), Problem> {
        let cells = self.cells(copies.cells)?;
        let picked = cells.pick(copies.pick, copies.seed);
        Ok((cells, picked))
    }

    fn copies(&mut self, node: Node, copies: &Copies) -> Result<Node, Problem> {
        let (cells, picked) = self.picked(copies)?;
        let host = self.host(copies.cells)?;
        Ok(scatter(&mut self.graph, node, host.as_ref(), &cells, &picked))
    }

    /// A direction, which has no length to lose.
    fn direction(&self, vector: &[Number; 3]) -> Result<DVec3, Problem> {
        let direction = self.vector(vector)?;
        if direction.length() >= LEAST {
            return Ok(direction);
        }
        Err(Problem::new(vector[0].span, "a direction needs a length other than 0"))
    }

    fn nodes(&mut self, operands: &[ShapeId]) -> Result<Vec<Node>, Problem> {
        operands.iter().map(|id| self.node(*id, Stage::Placed)).collect()
    }

    /// Operands without those that are met again. R₀ makes F of twice the same more than three times as steep inside: some
    /// levels of that leave the range of a float.
    fn different(&mut self, operands: &[ShapeId]) -> Result<Vec<Node>, Problem> {
        let mut seen = BTreeSet::new();
        Ok(self.nodes(operands)?.into_iter().filter(|node| seen.insert(*node)).collect())
    }

    /// One after another: the first with the second, that with the third.
    fn blend(
        &mut self,
        operands: &[ShapeId],
        radius: &Number,
        within: Option<ShapeId>,
        shape: &Shape,
    ) -> Result<Node, Problem> {
        let (amount, most) = (self.number(radius)?, self.over_shot(radius)?.hi);
        let purpose = Purpose { shape, key: "blend_radius", span: radius.span };
        // The blend lies outside of both, and within its bounds.
        let outside = Interval::new(-most, 0.0);
        let nodes: Result<Vec<Node>, Problem> =
            operands.iter().map(|id| self.placed_distance(*id, outside, &purpose)).collect();
        let bounds = match within {
            Some(id) => {
                let solid = self.placed_distance(id, Interval::new(0.0, most), &purpose)?;
                Some(BlendBounds { solid, weight: amount })
            }
            None => None,
        };
        let blend = Blend { amount, reach: [amount; 2], bounds };
        let joined = nodes?.into_iter().reduce(|joined, next| self.graph.blend_union(joined, next, &blend));
        Ok(joined.unwrap_or_else(|| unreachable!("a blend has two operands")))
    }

    /// The distance of a shape where it stands wherever that is one of `levels`, positive inside. What moves without
    /// changing its shape is measured once.
    fn placed_distance(&mut self, id: ShapeId, levels: Interval, purpose: &Purpose<'_>) -> Result<Node, Problem> {
        let placed = self.node(id, Stage::Placed)?;
        if let Some(distance) = told(&mut self.graph, placed, levels) {
            return Ok(distance);
        }
        let model = self.model();
        let shape = model.shape(id);
        let scale = self.vector(&shape.modifiers.scale)?;
        if scale != DVec3::splat(scale.x) {
            return self.distances.of(&mut self.graph, placed, levels, purpose);
        }
        let own = self.node(id, Stage::Own)?;
        let levels = Interval::new(levels.lo / scale.x, levels.hi / scale.x);
        let distance = self.distances.of(&mut self.graph, own, levels, purpose)?;
        let map = self.placement(&shape.modifiers, Stage::Placed)?;
        self.transformed(distance, &map, shape)
    }
}
