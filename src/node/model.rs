//! The model: a scene that was checked, its names resolved, no text left but places for messages.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use crate::attribute::{LinearRgb, Outside, Overlap, Power, Primaries};
use crate::distance::method::Choice;
use crate::distance::without::Keep;

use crate::node::argument::{Argument, Arguments, Bounds};
use crate::node::morph_mode::ModeSpec;
use crate::node::parameter::Parameter;
use crate::node::source::Given;
use crate::node::spec::{Carries, Spec};
use crate::text::diagnostic::Diagnostics;
use crate::text::files::FileReference;
use crate::text::frames::{FrameRange, Shot};
use crate::text::key::Kind;
use crate::text::moment::Moment;
use crate::text::number::Number;
use crate::text::reader::Setting;
use crate::text::sequence::FileSequence;
use crate::text::source::{Sources, Span};
use crate::text::value::Table;
use crate::vdb::Program;

pub use crate::node::argument::{Component, DelaySource, MorphDelay, ScalarName};
pub use crate::node::id::{CellsId, ShapeId};

/// A checked scene.
#[derive(Clone, Debug)]
pub struct Model {
    /// What messages call the scene: its path, or its built-in name.
    pub name: String,
    /// Its frames.
    pub shot: Shot,
    /// The length that 1 stands for: `m`, `cm`, `mm`, `km`, `in` or `ft`.
    pub unit: &'static str,
    /// The axis that points up: `y` or `z`.
    pub up: &'static str,
    /// What everything at random starts from.
    pub seed: u64,
    /// Numbers with names.
    pub parameters: Vec<Parameter>,
    /// All shapes, those written in place included.
    pub shapes: Vec<Shape>,
    /// All cells, those written in place included.
    pub cells: Vec<Cells>,
    /// What is baked.
    pub content: Content,
    /// How fine, and which grids.
    pub output: Output,
    /// Every value of the scene and who gave it.
    pub settings: Vec<Setting>,
    /// What is worth saying though the scene can be used.
    pub warnings: Diagnostics,
    /// The files on a disk that it imports.
    pub(crate) imports: Vec<PathBuf>,
    /// The scene as it was given, with its overrides and what it imports.
    pub(crate) document: Table,
    pub(crate) sources: Arc<Sources>,
}

/// What is baked.
#[derive(Clone, Debug)]
pub enum Content {
    /// One shape.
    Shape(ShapeId),
    /// One shape becoming another, and that one the next: at least one morph, each beginning at the frame and with the
    /// shape where the one before it ends.
    Morph(Vec<Morph>),
}

impl Content {
    /// Whether a shape is baked itself, not only as an operand of others.
    pub fn shows(&self, id: ShapeId) -> bool {
        match self {
            Self::Shape(shown) => *shown == id,
            Self::Morph(morphs) => morphs.iter().any(|morph| morph.from == id || morph.to == id),
        }
    }
}

/// One shape.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its name; for one written in place, where that is.
    pub name: String,
    /// Its name's place.
    pub span: Span,
    /// What it is before its modifiers.
    pub spec: &'static Spec,
    /// The values of its keys.
    pub arguments: Arguments,
    /// What is done to it, in order.
    pub modifiers: Vec<Modifier>,
    /// Where it stands.
    pub placement: Placement,
    /// Its own colour.
    pub colour: Option<ShapeColour>,
    /// Its own scalars, by the names of their grids.
    pub scalars: BTreeMap<String, ShapeScalar>,
    /// What its distances are measured by.
    pub distance: Choice,
    /// Where it says so, or else its name's place.
    pub distance_span: Span,
    /// s of the smooth step in the place of the sign, in voxels, of what is written of it.
    pub step: Option<f64>,
    /// The shapes whose distances its formulas read, by the names that they have there.
    pub reads: BTreeMap<String, ShapeId>,
    /// Whether it is a shape of the plane.
    pub is_flat: bool,
    /// The shape of the plane that it was extruded from because nothing else makes a solid of that.
    pub lifts: Option<ShapeId>,
}

/// Something that is done to a shape.
#[derive(Clone, Debug)]
pub struct Modifier {
    /// What.
    pub spec: &'static Spec,
    /// The values of its keys.
    pub arguments: Arguments,
}

/// Where a shape stands: scaled, then turned, then moved.
#[derive(Clone, Debug)]
pub struct Placement {
    /// How many times as large.
    pub scale: [Number; 3],
    /// Degrees about the fixed x, then y, then z axis.
    pub rotate: [Number; 3],
    /// Where to.
    pub translate: [Number; 3],
}

impl Shape {
    /// What makes it, or, from 1 on, is done to it.
    pub(crate) fn step(&self, step: usize) -> (&'static Spec, &Arguments) {
        match step.checked_sub(1).map(|done| &self.modifiers[done]) {
            None => (self.spec, &self.arguments),
            Some(modifier) => (modifier.spec, &modifier.arguments),
        }
    }

    /// The row of that.
    pub(crate) fn spec_of(&self, step: usize) -> &'static Spec {
        self.step(step).0
    }

    /// Whether it stands in many places: what is done to it gives it cells.
    pub(crate) fn is_copied(&self) -> bool {
        self.modifiers.iter().any(|modifier| modifier.spec.cells.is_some() && modifier.spec.bend.is_none())
    }

    /// The boxes that cut it off, each with the number of its step.
    pub(crate) fn cuts(&self) -> impl Iterator<Item = (usize, &Bounds)> {
        (1..).zip(&self.modifiers).filter_map(|(step, modifier)| Some((step, modifier.arguments.bounds("bounds")?)))
    }

    /// The first box that cuts it off.
    pub fn bounds(&self) -> Option<&Bounds> {
        self.cuts().next().map(|(_, bounds)| bounds)
    }

    /// The step after which its colours and scalars stand in its space: copies in cells are coloured as they stand, what
    /// bends space takes colours along.
    pub(crate) fn painted_step(&self) -> usize {
        let stands = |step: &usize| self.spec_of(*step).cells.is_some() && self.spec_of(*step).bend.is_none();
        (1..=self.modifiers.len()).rev().find(stands).unwrap_or(0)
    }

    /// The last step before space is bent again.
    pub(crate) fn before_bends(&self, from: usize, to: usize) -> usize {
        (from + 1..=to).find(|step| self.spec_of(*step).bend.is_some()).map_or(to, |step| step - 1)
    }

    /// How many of its modifiers come before those that go by a scalar of it.
    pub(crate) fn bare_steps(&self) -> usize {
        let by_scalar = |modifier: &Modifier| modifier.arguments.scalars().next().is_some();
        self.modifiers.iter().position(by_scalar).unwrap_or(self.modifiers.len())
    }

    /// Its own arguments and those of its modifiers.
    pub fn all_arguments(&self) -> impl Iterator<Item = &Arguments> {
        std::iter::once(&self.arguments).chain(self.modifiers.iter().map(|modifier| &modifier.arguments))
    }

    /// Its files by frame, those of its colour and scalars too.
    pub fn sequences(&self) -> impl Iterator<Item = &FileSequence> {
        self.all_arguments().chain(self.given_arguments()).filter_map(Arguments::sequence)
    }

    /// The arguments of its own colour and scalars.
    pub(crate) fn given_arguments(&self) -> impl Iterator<Item = &Arguments> {
        let scalars = self.scalars.values().map(|scalar| &scalar.arguments);
        self.colour.iter().map(|colour| &colour.arguments).chain(scalars)
    }

    /// Whether the values of its field count beside its surface, not only their sign.
    pub(crate) fn is_measured(&self) -> bool {
        self.modifiers.iter().any(|modifier| (modifier.spec.measures)(&modifier.arguments))
    }

    /// Whether a colour or scalar of it follows its inside.
    pub(crate) fn is_conformal(&self) -> bool {
        self.colour.as_ref().is_some_and(|colour| colour.source.is_conformal)
            || self.scalars.values().any(|scalar| scalar.source.is_conformal)
    }

    /// How its parts' attributes go over into one another, units.
    pub fn seam(&self) -> f64 {
        if self.spec.carries == Carries::Union { self.arguments.constant("seam").copied().unwrap_or(0.0) } else { 0.0 }
    }

    /// Whether its parts' attributes go over into one another.
    pub fn has_seam(&self) -> bool {
        let soft = |seam: f64| seam > 0.0;
        let given = |arguments: &Arguments| arguments.constant("seam").is_some_and(|seam| soft(*seam));
        soft(self.seam()) || self.given_arguments().any(given)
    }

    /// The shapes whose attributes it takes where it has none of its own. What is cut shows the inside of what it is cut
    /// from.
    pub fn painters(&self) -> &[ShapeId] {
        let main = match self.arguments.get(self.spec.key.name) {
            Some(Argument::Shape(shape)) => std::slice::from_ref(shape),
            Some(Argument::Shapes(shapes)) => shapes,
            _ => &[],
        };
        match self.spec.carries {
            Carries::Nothing | Carries::Import => &[],
            Carries::First => &main[..main.len().min(1)],
            Carries::Any | Carries::Union | Carries::Blend | Carries::Morph => main,
        }
    }
}

/// A shape's colour, scene-linear.
pub type ShapeColour = Given<3>;

/// A scalar of a shape.
pub type ShapeScalar = Given<1>;

/// A grid of colours or scalars in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VoxelSource {
    /// The `.vdb` file.
    pub file: FileReference,
    /// The grid's name.
    pub grid: String,
    /// Where the scene names the grid, or else the file.
    pub grid_span: Span,
    /// How its values go on outside of the volume.
    pub outside: Outside,
}

impl VoxelSource {
    /// The grid that a source reads at a frame, by this name where the scene gives none.
    pub(crate) fn of(arguments: &Arguments, usual: &str, frame: f64) -> Self {
        let file = arguments.file_at("vdb", frame).expect("it must be there").clone();
        let (grid, grid_span) = match arguments.get("grid") {
            Some(Argument::Text(grid, span)) => (grid.clone(), *span),
            _ => (usual.to_owned(), file.span),
        };
        let power = arguments.whole("power").and_then(|power| Power::new(u32::try_from(*power).ok()?));
        let outside = match (arguments.choice("outside"), power) {
            (Some(&"potential"), Some(power)) => Outside::Potential(power),
            _ => Outside::Foot,
        };
        Self { file, grid, grid_span, outside }
    }
}

/// Octree cells around a shape.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Their name; for cells written in place, where that is.
    pub name: String,
    /// Their name's place.
    pub span: Span,
    /// The shape they stand around.
    pub around: ShapeId,
    /// How often a cell is halved at least.
    pub least_depth: u32,
    /// How often at most.
    pub most_depth: u32,
    /// The chance of one more halving between the two.
    pub chance: f64,
    /// What the chances start from.
    pub seed: u64,
}

/// One shape becoming another.
#[derive(Clone, Debug)]
pub struct Morph {
    /// What it is first.
    pub from: ShapeId,
    /// What it is last.
    pub to: ShapeId,
    /// What is taken away from every frame.
    pub cut: Option<ShapeId>,
    /// Which pieces of each frame stay.
    pub keep: Keep,
    /// Whether both are shapes of the plane, which are blended in it and extruded then.
    pub in_plane: bool,
    /// How high they are extruded, where the scene says so.
    pub height: Option<f64>,
    /// How the shape's way is found.
    pub mode: MorphMode,
    /// Whether t is re-timed so that every frame changes as much as the others.
    pub even_pace: bool,
    /// The way that the objects are carried along.
    pub carry: MorphCarry,
    /// How fast they go along it; `None`: as the shape changes.
    pub carry_ease: Option<MorphEase>,
    /// How far the middle of that way lies off the straight one.
    pub arc: [f64; 3],
    /// Where the whole stands, scaled alike along x, y and z.
    pub placement: Placement,
    /// How fast the shape changes on the way.
    pub ease: MorphEase,
    /// Whether colours run on past their end.
    pub octopus: bool,
    /// `rgb`, `hsv`, `lab`, `lch` or `oklab`.
    pub colour_space: &'static str,
    /// STTI's α.
    pub alpha: Number,
    /// STTI's β.
    pub beta: Number,
    /// The frames of the shape's change.
    pub over: FrameRange,
    /// The frames of the colours' change.
    pub colour_over: FrameRange,
    /// The scalar that the surface of every frame is moved by, along the normal.
    pub displace: Option<ScalarName>,
    /// What every frame is filled with.
    pub fill: Option<Fill>,
    /// Which parts correspond; `None` where the objects' colours change as wholes.
    pub correspondence: Option<Correspondence>,
    /// Where the scene says so.
    pub span: Span,
}

/// The way that a morph's objects are carried along.
#[derive(Clone, Debug, PartialEq)]
pub enum MorphCarry {
    /// The scene does not say: from centre to centre where they lie apart, and the mode carries by itself.
    Left,
    /// None.
    None,
    /// From centre of volume to centre of volume.
    Centroid,
    /// The same, and from principal axes to principal axes.
    Inertia,
    /// From places to places.
    Anchors(Vec<[Anchor; 2]>),
}

/// A place of an object in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Where it is.
    pub at: [f64; 3],
    /// Where the scene says so.
    pub span: Span,
}

/// An inner structure: only where it is not negative, something stays.
#[derive(Clone, Debug, PartialEq)]
pub struct Fill {
    /// The structures at 0 and at 1.
    pub structures: [ShapeId; 2],
    /// The scalar that mixes them.
    pub by: ScalarName,
}

/// Which part of a morph's first object becomes which part of the second.
#[derive(Clone, Debug, PartialEq)]
pub struct Correspondence {
    /// Operands of the two unions; the later pair above the earlier.
    pub pairs: Pairs,
    /// What holds where several pairs are.
    pub overlap: Overlap,
    /// What holds where no pair is; `None`: the nearest.
    pub master: Option<Master>,
}

/// What holds where none of a morph's pairs is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Master {
    /// The pair of that place.
    Pair(usize),
    /// A colour.
    Colour(LinearRgb),
}

/// The pairs of a correspondence.
#[derive(Clone, Debug, PartialEq)]
pub enum Pairs {
    /// Those that the scene names, each part in one.
    Named(Vec<[ShapeId; 2]>),
    /// Those that lie nearest to one another, of these parts of each object.
    Nearest([Vec<ShapeId>; 2]),
}

/// How a morph's shape is found.
#[derive(Clone, Debug)]
pub struct MorphMode {
    /// The mode.
    pub spec: &'static ModeSpec,
    /// The values of its own keys.
    pub arguments: Arguments,
}

impl MorphMode {
    /// The places that wait.
    pub fn delay(&self) -> Option<&MorphDelay> {
        self.arguments.delay("delay")
    }
}

/// How fast a morph's shape changes on the way.
#[derive(Clone, Debug)]
pub enum MorphEase {
    /// Evenly.
    Linear,
    /// From rest to rest.
    Smooth,
    /// As far as this number says, 0 to 1.
    Progress(Number),
}

/// How fine, and which grids.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// A voxel's edge, where the scene gives one.
    pub voxel_size: Option<f64>,
    /// Voxels along the longest side, where no voxel size is given.
    pub resolution: u32,
    /// Half the band's width in voxels.
    pub half_width: f64,
    /// Which grids are written; `None` for all there are but `vel`.
    pub grids: Option<Vec<String>>,
    /// Which grids keep 16 bits.
    pub half: Vec<String>,
    /// `blosc`, `zip` or `none`.
    pub compression: &'static str,
    /// The colour grid's name.
    pub colour_name: String,
    /// The program that files are for, where the scene says one.
    pub program: Option<&'static Program>,
    /// The space of its colours, where the scene says one; Rec.709 else.
    pub primaries: Option<Primaries>,
    /// The greatest speed of `vel`, units a second; `None` for the longest side of the shot's box in one frame.
    pub max_speed: Option<f64>,
    /// What the distances that are written are measured by, where the scene says so, and where that is.
    pub distance: Option<(Choice, Span)>,
    /// s of the smooth step in the place of the sign, in voxels.
    pub step: Option<f64>,
    /// Whether attributes go through the inside.
    pub inside: bool,
    /// Whether there is a fog volume.
    pub density: bool,
}

impl Output {
    /// Whether attributes go through the inside: fog without them has none there.
    pub fn fills_inside(&self) -> bool {
        self.inside || self.density
    }

    /// The space of its colours where they have to be converted to it.
    pub fn other_primaries(&self) -> Option<Primaries> {
        self.primaries.filter(|primaries| *primaries != Primaries::Rec709)
    }

    /// Whether a grid is written where there is one of this name. `vel` has to be asked for.
    pub fn writes(&self, grid: &str) -> bool {
        self.grids.as_ref().map_or(grid != "vel", |grids| grids.iter().any(|name| name == grid))
    }
}

impl Model {
    /// What files by frame lack for some frames, or for all of the shot: an error for each sequence of files.
    pub fn lacking(&self, frames: Option<&[i64]>) -> Diagnostics {
        let of = |files: &FileSequence| match frames {
            Some(frames) => files.lacking(frames),
            None => files.lacking_of_shot(),
        };
        Diagnostics::new(self.shapes.iter().flat_map(Shape::sequences).filter_map(of).collect(), self.sources.clone())
    }

    /// Whether it has shapes that are made of cells, or filled: hollows that nobody would count by hand.
    pub fn has_structures(&self) -> bool {
        let is_filled = |shape: &Shape| shape.modifiers.iter().any(|modifier| modifier.spec.key.name == "fill");
        self.shapes.iter().any(|shape| shape.spec.graded.is_some() || is_filled(shape))
    }

    /// The operations that join, cut or blend shapes in all that is baked: of n operands n − 1, each shape as often as it is
    /// used, copies as one.
    pub fn set_operations(&self) -> u64 {
        let mut known = BTreeMap::new();
        match &self.content {
            Content::Shape(id) => self.operations_of(*id, &mut known),
            Content::Morph(morphs) => {
                let ends =
                    morphs.first().map(|morph| morph.from).into_iter().chain(morphs.iter().map(|morph| morph.to));
                ends.fold(0, |sum: u64, id| sum.saturating_add(self.operations_of(id, &mut known)))
            }
        }
    }

    /// Those of one shape. Shapes are made of shapes to a limited depth.
    fn operations_of(&self, id: ShapeId, known: &mut BTreeMap<ShapeId, u64>) -> u64 {
        if let Some(count) = known.get(&id) {
            return *count;
        }
        let shape = self.shape(id);
        let operands = match shape.spec.key.kind {
            Kind::Shapes(_) | Kind::TwoShapes => shape.arguments.shapes(shape.spec.key.name).map_or(0, Vec::len),
            _ if shape.arguments.applied().is_some() => shape.arguments.all_shapes().count(),
            _ => 0,
        };
        let below = shape.all_arguments().flat_map(Arguments::all_shapes);
        let count = below
            .fold(operands.saturating_sub(1) as u64, |sum, part| sum.saturating_add(self.operations_of(part, known)));
        known.insert(id, count);
        count
    }

    /// The names of all scalars that any shape has, sorted.
    pub fn scalar_names(&self) -> BTreeSet<&str> {
        self.shapes.iter().flat_map(|shape| shape.scalars.keys()).map(String::as_str).collect()
    }

    /// The names of the grids that its frames may have.
    pub fn grid_names(&self) -> Vec<&str> {
        let density = self.output.density.then_some("density");
        let own = ["surface", &self.output.colour_name, "vel"].into_iter().chain(density);
        own.chain(self.scalar_names().into_iter().filter(|name| Some(*name) != density)).collect()
    }

    /// The names that formulas know beside x, y, z, t, frame, time, with their values at a frame.
    pub fn moment(&self, frame: f64) -> Moment {
        let bare = self.shot.moment(frame, Arc::new([]));
        // Formulas of parameters know time only, so their values do not hang on one another.
        let values = self.parameters.iter().map(|parameter| parameter.value.at(&bare).unwrap_or(f64::NAN));
        Moment { parameters: values.collect(), ..bare }
    }

    /// What the distances that are written are measured by.
    pub fn written_distance(&self) -> Choice {
        let of_content = self.shown_shape().map_or(Choice::USUAL, |shape| shape.distance);
        self.output.distance.map_or(of_content, |(choice, _)| choice)
    }

    /// Where the scene says so.
    pub fn written_distance_span(&self) -> Option<Span> {
        let of_output = self.output.distance.map(|(_, span)| span);
        of_output.or_else(|| self.shown_shape().map(|shape| shape.distance_span))
    }

    /// s of the smooth step in the place of the sign of the distances that are written, in voxels.
    pub fn written_step(&self) -> Option<f64> {
        self.output.step.or_else(|| self.shown_shape().and_then(|shape| shape.step))
    }

    /// The shape that is baked, where it is one.
    fn shown_shape(&self) -> Option<&Shape> {
        match self.content {
            Content::Shape(id) => Some(self.shape(id)),
            Content::Morph(_) => None,
        }
    }

    /// The shape of an id.
    pub fn shape(&self, id: ShapeId) -> &Shape {
        &self.shapes[id.0]
    }
}
