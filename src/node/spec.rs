//! A row of the table of nodes: what a shape can be, or what can be done to it.
//!
//! A node is one file with one [`Spec`], and one line in [`super::list`]. The scene format, its documentation, links
//! between shapes, what changes over time, files and the scene's hash follow from the row.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use crate::attribute::{Attribute, CellIndex, Colour, Scalar};
use crate::field::cells::Cells;
use crate::field::facet::Pieces;
use crate::field::{Aabb, Field, Graph, Interval, Node};
use crate::mesh::NumberOf;
use crate::morph::Morph;
use crate::node::argument::{Arguments, ScalarName};
use crate::node::bend::Bend;
use crate::node::id::{CellsId, ShapeId};
use crate::node::reading::Reading;
use crate::text::diagnostic::Diagnostic;
use crate::text::files::FileReference;
use crate::text::key::{Absent, Key, LEAST};
use crate::text::moment::Moment;
use crate::text::number::Number;
use crate::text::number::formula::Formula;
use crate::text::problem::Problem;
use crate::text::source::Span;

/// The cells of a node.
pub type CellsOf = fn(&mut dyn Build) -> Result<Arc<dyn CellIndex>, Problem>;

/// How a node moves, bends or copies space.
pub type BendOf = fn(&mut dyn Build) -> Result<Arc<dyn Bend>, Problem>;

/// What a node reads from its file.
pub type ImportOf = fn(&Import<'_>) -> Result<Imported, Problem>;

/// The node of a row that goes over into another one of it, of which the first is built; `None` where a mean of both values is
/// what is meant.
pub type GradedOf = fn(&mut dyn Build, &Grading<'_>) -> Result<Option<Node>, Problem>;

/// What a shape can be, or what can be done to one.
#[derive(Clone, Copy)]
pub struct Spec {
    /// The key that names it; its value is the main argument.
    pub key: Key,
    /// The keys beside it.
    pub parameters: &'static [Key],
    /// Its function, positive inside, where one line says it.
    pub formula: &'static str,
    /// Where the formula comes from: paper and equation, or another work; empty for what everybody knows.
    pub source: &'static str,
    /// Keys of a shape that shows it, TOML. Names `a` and `b` are two shapes, `c` cells.
    pub example: &'static str,
    /// What its attributes and its motion come from.
    pub carries: Carries,
    /// Whether it is of the plane or of space.
    pub plane: Plane,
    /// Whether it reaches to infinity unless `bounds` cut it.
    pub is_endless: bool,
    /// Whether it takes the distance of what it is made of, outside of that.
    pub measures: fn(&Arguments) -> bool,
    /// Its cells, which can take colours each.
    pub cells: Option<CellsOf>,
    /// How it bends the space of the shape that it is done to.
    pub bend: Option<BendOf>,
    /// What it reads from its file.
    pub import: Option<ImportOf>,
    /// How it goes over into another one of its row, where that is not a mean of both values.
    pub graded: Option<GradedOf>,
    /// Its field at a moment.
    pub build: fn(&mut dyn Build) -> Result<Node, Problem>,
}

impl Spec {
    /// What most rows have nothing of.
    pub const PLAIN: Self = Self {
        key: Key::new("", crate::text::key::Kind::Table, Absent::Nothing, ""),
        parameters: &[],
        formula: "",
        source: "",
        example: "",
        carries: Carries::Nothing,
        plane: Plane::Solid,
        is_endless: false,
        measures: |_| false,
        cells: None,
        bend: None,
        import: None,
        graded: None,
        build: |build| build.inner(),
    };

    /// All its keys.
    pub fn keys(&'static self) -> impl Iterator<Item = &'static Key> + Clone {
        std::iter::once(&self.key).chain(self.parameters)
    }
}

impl std::fmt::Debug for Spec {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.key.name)
    }
}

/// Whether a node is of the plane or of space. Set operations and blends of shapes of the plane are such again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// A solid, made of solids.
    Solid,
    /// A shape of the xy plane: its field does not depend on z.
    Flat,
    /// A solid made of a shape of the plane.
    Lifts,
}

/// What a node's attributes and its motion come from, where the shape has none of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carries {
    /// It has none.
    Nothing,
    /// What its file holds.
    Import,
    /// Its operands', the later above the earlier, over `seam` where it has that.
    Union,
    /// Its operands', mixed by their distances.
    Blend,
    /// Its operands', as a morph from the first to the second mixes them.
    Morph,
    /// The first operand's that has one.
    Any,
    /// The first operand's.
    First,
}

/// The problem of a key whose map of space cannot be undone.
pub(crate) fn flat(build: &dyn Build, key: &str) -> Problem {
    let number = build.arguments().vector(key).map(|vector| vector[0].span);
    let problem = Problem::new(number.unwrap_or_default(), format!("`{key}` of `{}` flattens space", build.name()));
    problem.help("its numbers must be finite, and a scale other than 0")
}

/// What an import may know.
pub struct Import<'a> {
    /// The values of its keys.
    pub arguments: &'a Arguments,
    /// The frame that it is read for.
    pub frame: f64,
    /// The axis that points up in the scene: `y` or `z`.
    pub up: &'a str,
    /// The scene's unit of length.
    pub unit: &'a str,
    /// Whether a frame shows the file's own colours.
    pub shows_colours: bool,
    /// Whether a frame has velocities.
    pub shows_velocity: bool,
    /// The most memory that a volume of voxels may take, in bytes.
    pub memory_limit: Option<usize>,
}

impl Import<'_> {
    /// The file of a key that must be there.
    pub fn file(&self, key: &str) -> &FileReference {
        self.arguments.file_at(key, self.frame).expect("it must be there")
    }
}

/// What a structure goes over into, and by what.
pub struct Grading<'a> {
    /// The keys of the other one.
    pub to: &'a Arguments,
    /// ω, in the structure's own space.
    pub by: Arc<dyn Field>,
    /// What it fills, in the structure's own space.
    pub solid: Arc<dyn Field>,
    /// The box of that.
    pub around: Aabb,
    /// What the scene calls ω.
    pub name: &'a ScalarName,
}

/// A file's colours, for voxels with an edge.
pub type ColoursOf = Box<dyn Fn(f64) -> Arc<Colour> + Send + Sync>;

/// A number of a file's materials, averaged over voxels of an edge; `None` where no material says it.
pub type MaterialsOf = Box<dyn Fn(NumberOf, f64) -> Option<Arc<Scalar>> + Send + Sync>;

/// What a file holds.
pub struct Imported {
    /// The distance, positive inside.
    pub distance: Arc<dyn Field>,
    /// From the distance's own space to the shape's.
    pub place: DAffine3,
    /// The box of F ≥ 0.
    pub solid: Aabb,
    /// Half-spaces n · p ≤ o whose intersection has the same inside, where there are few: much faster where only the sign
    /// is asked for.
    pub half_spaces: Option<Vec<(DVec3, f64)>>,
    /// Its colours, for voxels with an edge in its space.
    pub colours: Option<ColoursOf>,
    /// A number of its materials, for voxels with an edge in its space.
    pub materials: Option<MaterialsOf>,
    /// Its velocities, world units a second in the shape's space, where they are asked for.
    pub velocity: Option<Arc<dyn Attribute<3>>>,
    /// What there is to know about the file.
    pub warnings: Vec<Diagnostic>,
    /// Memory that it takes, about, in bytes.
    pub bytes: u64,
}

/// What a row's function may ask for while its node is built, at one moment of the shot.
pub trait Build {
    /// The graph that the node goes into.
    fn graph(&mut self) -> &mut Graph;
    /// The values of the node's keys.
    fn arguments(&self) -> &Arguments;
    /// The row's own key.
    fn key(&self, name: &str) -> &'static Key;
    /// The moment.
    fn moment(&self) -> &Moment;
    /// What a number is over the whole shot.
    fn over_shot(&self, number: &Number) -> Result<Interval, Problem>;
    /// A formula of this shape at the moment.
    fn reading(&mut self, formula: &Formula) -> Result<Reading, Problem>;
    /// The shape so far, for what is done to one.
    fn inner(&mut self) -> Result<Node, Problem>;
    /// How this step bends space.
    fn bend(&mut self) -> Result<Arc<dyn Bend>, Problem>;
    /// A shape where it stands.
    fn shape(&mut self, id: ShapeId) -> Result<Node, Problem>;
    /// Two structures as one that goes over from the first to the second by ω in a solid with its box, where their row knows how.
    fn graded(
        &mut self,
        ends: [ShapeId; 2],
        by: (&ScalarName, Arc<dyn Field>),
        solid: (Node, Aabb),
    ) -> Result<Option<Node>, Problem>;
    /// The distance of a node wherever it is one of `levels`, positive inside: its own value where that is one.
    fn distance(&mut self, solid: Node, levels: Interval, key: &'static str) -> Result<Node, Problem>;
    /// The same of a shape where it stands. What moves without changing is measured once.
    fn shape_distance(&mut self, id: ShapeId, levels: Interval, key: &'static str) -> Result<Node, Problem>;
    /// The distance of a node as good as a band at its surface, and where `levels` are if that takes no measuring.
    fn moving_distance(&mut self, solid: Node, levels: Interval, key: &'static str) -> Result<Node, Problem>;
    /// A node that is another one grown by a distance, or lies within that: with its box, where its construction does not
    /// tell it.
    fn held(&mut self, grown: Node, solid: Node, by: f64) -> Node;
    /// The box of F ≥ 0 of a node of this shape.
    fn solid_box(&self, node: Node) -> Result<Aabb, Problem>;
    /// An attribute of this shape in the space of `solid`.
    fn scalar(&mut self, name: &str, solid: Aabb) -> Result<Option<Arc<Scalar>>, Problem>;
    /// The name of this shape.
    fn name(&self) -> &str;
    /// Where the scene has it.
    fn span(&self) -> Span;
    /// Cells.
    fn cells(&mut self, id: CellsId) -> Result<Arc<Cells>, Problem>;
    /// The field of the shape that cells stand around.
    fn host(&mut self, id: CellsId) -> Result<Arc<dyn Field>, Problem>;
    /// The morph of this shape's two operands.
    fn morph(&mut self) -> Result<Arc<Morph>, Problem>;
    /// The pieces that a `facet` was made of.
    fn pieces(&mut self) -> Result<Arc<Pieces>, Problem>;
    /// Keeps them.
    fn keep_pieces(&mut self, pieces: Pieces);
    /// What was read from the node's file.
    fn imported(&self) -> Result<Arc<Imported>, Problem>;
    /// Whether the values of the node count beside its surface, not only their sign.
    fn needs_distance(&self) -> bool;
}

impl dyn Build + '_ {
    /// What the node's file holds, where it stands in the shape's own space.
    pub fn imported_field(&mut self) -> Result<Node, Problem> {
        let file = self.imported()?;
        let (name, span) = (self.name().to_owned(), self.span());
        let graph = self.graph();
        let node = graph.field(Arc::clone(&file.distance));
        if file.place == DAffine3::IDENTITY {
            return Ok(node);
        }
        graph.transform(node, &file.place).map_err(|error| Problem::new(span, format!("`{name}`: {error}")))
    }

    /// The number of a key at the moment; where it is left out, its share of the key that its default refers to.
    pub fn number(&self, key: &str) -> Result<f64, Problem> {
        self.number_of(self.arguments(), key)
    }

    /// The same of other values of the row's keys.
    pub fn number_of(&self, arguments: &Arguments, key: &str) -> Result<f64, Problem> {
        match (arguments.number(key), self.key(key).default) {
            (Some(number), _) => Ok(number.at(self.moment())?),
            (None, Absent::Of(other, share)) => Ok(share * self.number_of(arguments, other)?),
            (None, default) => unreachable!("`{key}` has no value by itself, but {default:?}"),
        }
    }

    /// What the number of a key, which is there, is over the whole shot.
    pub fn ever(&self, key: &str) -> Result<Interval, Problem> {
        self.over_shot(self.arguments().number(key).expect("it must be there"))
    }

    /// The three numbers of a key at the moment.
    pub fn vector(&self, key: &str) -> Result<DVec3, Problem> {
        let [x, y, z] = self.arguments().vector(key).expect("it has a default");
        Ok(DVec3::new(x.at(self.moment())?, y.at(self.moment())?, z.at(self.moment())?))
    }

    /// The two numbers of a key at the moment.
    pub fn pair(&self, key: &str) -> Result<DVec2, Problem> {
        let [x, y] = self.arguments().pair(key).expect("it must be there");
        Ok(DVec2::new(x.at(self.moment())?, y.at(self.moment())?))
    }

    /// The whole number of a key.
    pub fn whole(&self, key: &str) -> i64 {
        *self.arguments().whole(key).expect("it has a default")
    }

    /// The lists of a key, each the coordinates of a point in the plane.
    pub fn plane_points(&self, key: &str) -> Vec<DVec2> {
        let rows = self.arguments().rows(key).expect("it must be there");
        rows.all.iter().map(|row| DVec2::new(row[0], row[1])).collect()
    }

    /// The lists of a key, each the coordinates of a point.
    pub fn points(&self, key: &str) -> Vec<DVec3> {
        let rows = self.arguments().rows(key).expect("it must be there");
        rows.all.iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect()
    }

    /// What is wrong with the value of a key.
    pub fn wrong(&self, key: &str, problem: impl Into<String>) -> Problem {
        let main = self.arguments().0.first().map_or("", |(name, _)| *name);
        let span = self.arguments().span(key).or_else(|| self.arguments().span(main));
        Problem::new(span.unwrap_or(self.span()), problem)
    }

    /// The direction of a key at the moment, of any length but 0.
    pub fn direction(&self, key: &str) -> Result<DVec3, Problem> {
        let direction = self.vector(key)?;
        if direction.length() >= LEAST {
            return Ok(direction);
        }
        let span = self.arguments().vector(key).map_or_else(Default::default, |vector| vector[0].span);
        Err(Problem::new(span, "a direction needs a length other than 0"))
    }

    /// The number of a key that stands still.
    pub fn constant(&self, key: &str) -> f64 {
        *self.arguments().constant(key).expect("it has a default")
    }

    /// The shapes of a key where they stand.
    pub fn shapes(&mut self, key: &str) -> Result<Vec<Node>, Problem> {
        let shapes = self.arguments().shapes(key).cloned().unwrap_or_default();
        shapes.into_iter().map(|id| self.shape(id)).collect()
    }

    /// The same without those that are met again. R₀ makes F of twice the same more than three times as steep inside: some
    /// levels of that leave the range of a float.
    pub fn different_shapes(&mut self, key: &str) -> Result<Vec<Node>, Problem> {
        let mut seen = std::collections::BTreeSet::new();
        Ok(self.shapes(key)?.into_iter().filter(|node| seen.insert(*node)).collect())
    }
}
