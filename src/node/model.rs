//! The model: a scene that was checked, its names resolved, no text left but places for messages.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::attribute::{Choice, Components, Mixer, Outside, Overlap, Straight};
use crate::distance::without::Keep;
use crate::mesh::Conventions;

use crate::text::diagnostic::Diagnostics;
use crate::text::files::FileReference;
use crate::text::formula::Formula;
use crate::text::frames::{FrameRange, Shot};
use crate::text::moment::Moment;
use crate::text::number::{Number, NumberValue};
use crate::text::reader::Setting;
use crate::text::source::{Sources, Span};

/// A shape's place in [`Model::shapes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShapeId(pub usize);

/// Cells' place in [`Model::cells`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellsId(pub usize);

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
    pub(crate) canonical: String,
    pub(crate) sources: Arc<Sources>,
}

/// A number with a name.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: Number,
    /// What it is, in the scene's words.
    pub text: Option<String>,
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
    pub maker: Maker,
    /// What is done to it, in this order of fields.
    pub modifiers: Modifiers,
    /// The box, in its own space, outside of which it is cut off.
    pub bounds: Option<Bounds>,
    /// Its own colour.
    pub colour: Option<ShapeColour>,
    /// Its own scalars, by the names of their grids.
    pub scalars: BTreeMap<String, ShapeScalar>,
}

/// What a shape is. Lengths in scene units, directions of any length but 0.
#[derive(Clone, Debug)]
#[allow(missing_docs, reason = "each field is the key of its name, described in `keys`")]
pub enum Maker {
    /// A ball.
    Sphere { radius: Number },
    /// A box by its edge lengths.
    Box { edges: [Number; 3] },
    /// An ellipsoid by its half axes.
    Ellipsoid { half_axes: [Number; 3] },
    /// A cylinder along z; twice its radius high where nothing is said.
    Cylinder { radius: Number, height: Option<Number> },
    /// A ring around z, its tube a quarter of the radius where nothing is said.
    Torus { radius: Number, tube: Option<Number> },
    /// All near a straight line along z, twice the radius long where nothing is said.
    Capsule { radius: Number, length: Option<Number> },
    /// All behind a plane.
    HalfSpace { normal: [Number; 3], offset: Number },
    /// All between two planes.
    Slab { thickness: Number, normal: [Number; 3] },
    /// A heart by its width along x.
    Heart { width: Number },
    /// F itself.
    Formula { formula: Formula, span: Span },
    /// A mesh. `up_is_given`: whether its file's up axis is known, not only taken for the scene's.
    Mesh { file: FileReference, conventions: Conventions, up_is_given: bool },
    /// All that is in any.
    Union { operands: Vec<ShapeId>, seam: f64 },
    /// What is in all.
    Intersection(Vec<ShapeId>),
    /// The first without the others.
    Difference(Vec<ShapeId>),
    /// Shapes that flow together.
    Blend { operands: Vec<ShapeId>, radius: Number, within: Option<ShapeId> },
    /// A mesh cut by planes at random, cell by cell.
    Facet { of: ShapeId, cells: CellsId, tilt: f64, cut: f64, seed: u64 },
}

/// What is done to a shape after it is made.
#[derive(Clone, Debug)]
pub struct Modifiers {
    /// Copies in place of the one at the origin.
    pub at: Option<Copies>,
    /// The axis along which it is mirrored: 0 to 2.
    pub mirror: Option<usize>,
    /// How much it is grown.
    pub offset: Number,
    /// The thickness of the wall that stays.
    pub shell: Option<Number>,
    /// The scalar that its surface is moved by, along the normal.
    pub displace: Option<ScalarName>,
    /// How many times as large.
    pub scale: [Number; 3],
    /// Degrees about the fixed x, then y, then z axis.
    pub rotate: [Number; 3],
    /// Where to.
    pub translate: [Number; 3],
}

impl Shape {
    /// Whether its parts' attributes go over into one another.
    pub fn has_seam(&self) -> bool {
        let soft = |seam: f64| seam > 0.0;
        matches!(self.maker, Maker::Union { seam, .. } if soft(seam))
            || matches!(self.colour, Some(AttributeSource::Parts { seam, .. }) if soft(seam))
            || self.scalars.values().any(|source| matches!(source, AttributeSource::Parts { seam, .. } if soft(*seam)))
    }
}

impl Modifiers {
    /// Whether any of them moves the surface outward by a distance.
    pub fn may_grow(&self) -> bool {
        let shrinks = matches!(self.offset.value, NumberValue::Constant(by) if by <= 0.0);
        !shrinks || self.shell.is_some() || self.displace.is_some()
    }
}

/// The scalar that a key names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScalarName {
    /// Its name.
    pub name: String,
    /// Where the scene names it.
    pub span: Span,
}

/// Copies in cells.
#[derive(Clone, Debug)]
pub struct Copies {
    /// The cells.
    pub cells: CellsId,
    /// The share of them that gets one.
    pub pick: f64,
    /// What the choice starts from.
    pub seed: u64,
}

/// A box to cut off at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The box.
    pub aabb: crate::field::Aabb,
    /// Whether it is meant to cut the shape.
    pub cut: bool,
    /// Where the scene gives it.
    pub span: Span,
}

/// A shape's colour, scene-linear.
pub type ShapeColour = AttributeSource<3, Components, Mixer>;

/// A scalar of a shape.
pub type ShapeScalar = AttributeSource<1, (), Straight>;

/// Where an attribute of a shape comes from: `N` numbers, which formulas give as `K` says and which are mixed by `M`.
#[derive(Clone, Debug)]
pub enum AttributeSource<const N: usize, K, M> {
    /// One value.
    Solid([f32; N]),
    /// Numbers of space and time.
    Formula {
        /// The numbers.
        components: Box<[Component; N]>,
        /// What they are.
        meaning: K,
        /// Where they stand.
        span: Span,
    },
    /// One for each piece of space, at random.
    Random {
        /// What is chosen from.
        choice: Choice<N, M>,
        /// The pieces.
        by: Pieces,
        /// What the choice starts from.
        seed: u64,
    },
    /// One for each band of depth below the surface: where it begins, units, rising.
    Bands(Vec<(f64, [f32; N])>),
    /// Those of other shapes, which stand in this one's own space.
    Parts {
        /// The shapes, the later above the earlier.
        shapes: Vec<ShapeId>,
        /// The width of the transition where they meet, units.
        seam: f64,
    },
    /// A volume of voxels, which stand in the shape's own space.
    Voxels(VoxelSource),
}

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

impl Maker {
    /// The shapes whose attributes it takes where it has none of its own. What is cut shows the inside of what it is cut
    /// from.
    pub fn painters(&self) -> &[ShapeId] {
        match self {
            Self::Facet { of, .. } => std::slice::from_ref(of),
            Self::Union { operands, .. } | Self::Blend { operands, .. } | Self::Intersection(operands) => operands,
            Self::Difference(operands) => &operands[..1],
            _ => &[],
        }
    }
}

impl<const N: usize, K, M> AttributeSource<N, K, M> {
    /// The shapes whose values it takes.
    pub fn parts(&self) -> &[ShapeId] {
        match self {
            Self::Parts { shapes, .. } => shapes,
            _ => &[],
        }
    }

    /// The file that it comes from, if one.
    pub fn file(&self) -> Option<&FileReference> {
        if let Self::Voxels(source) = self { Some(&source.file) } else { None }
    }

    /// Where its formulas stand, if they are what it is.
    pub fn formula(&self) -> Option<Span> {
        if let Self::Formula { span, .. } = self { Some(*span) } else { None }
    }
}

/// One of an attribute's numbers.
#[derive(Clone, Debug)]
pub enum Component {
    /// The same everywhere.
    Number(Number),
    /// A formula of space and time.
    Formula(Formula),
}

/// Pieces of space that take a value each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pieces {
    /// The cells of a facet or of copies.
    Cells,
    /// Cubes of this edge, units.
    Cubes(f64),
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
    /// How the shape's way is found.
    pub mode: MorphMode,
    /// Whether t is re-timed so that every frame changes as much as the others.
    pub even_pace: bool,
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
    /// Operands of the two unions, each in one pair; the later pair above the earlier.
    pub pairs: Vec<[ShapeId; 2]>,
    /// What holds where several pairs are.
    pub overlap: Overlap,
    /// The place of the pair that holds where none is.
    pub master: Option<usize>,
}

/// How a morph's shape is found.
#[derive(Clone, Debug)]
pub enum MorphMode {
    /// a₀ from the volume, which runs evenly.
    Volume {
        /// How much separate shapes flow through one body.
        bridge: Number,
        /// The factor on the volume of the straight way.
        volume: Number,
        /// Which places start later.
        delay: Option<Box<MorphDelay>>,
    },
    /// (1 − t)·f₁ + t·f₂ of the two distances.
    Linear,
    /// Both objects at once on the way.
    Union,
    /// The first object all along.
    Still,
    /// The STB paper's numbers as given.
    Paper(Box<MorphPaper>),
    /// OpenVDB's morph of two level sets.
    OpenVdb,
}

/// How long places wait, as a share of the morph's progress.
#[derive(Clone, Debug)]
pub struct MorphDelay {
    /// Where it comes from.
    pub source: DelaySource,
    /// Where the scene says so.
    pub span: Span,
}

/// Where a delay comes from.
#[derive(Clone, Debug)]
pub enum DelaySource {
    /// A number, or a formula of x, y, z in the world.
    Space(Component),
    /// What a shape has at each place, as it stands when the shot begins.
    Shape {
        /// The shape.
        shape: ShapeId,
        /// A scalar of it; `None` for the luminance of its colour.
        attribute: Option<String>,
        /// The delay where that is 1.
        most: f64,
    },
}

/// The STB paper's numbers.
#[derive(Clone, Debug)]
pub struct MorphPaper {
    /// a₀ to a₃.
    pub a: [Number; 4],
    /// The time scale s.
    pub s: Number,
    /// The slab of time: its beginning and its end.
    pub slab: [Number; 2],
    /// How both objects are rounded against the planes that cut them in time.
    pub round: Option<MorphRound>,
}

/// The numbers of [`crate::morph::Round`].
#[derive(Clone, Debug)]
pub struct MorphRound {
    /// How much is added at the cut.
    pub a0: Number,
    /// How far it reaches.
    pub reach: Number,
    /// How far the bound reaches.
    pub a3: Number,
    /// How far behind the cut the bound stands.
    pub depth: Number,
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
    /// The greatest speed of `vel`, units a second; `None` for the longest side of the shot's box in one frame.
    pub max_speed: Option<f64>,
}

impl Output {
    /// Whether a grid is written where there is one of this name. `vel` has to be asked for.
    pub fn writes(&self, grid: &str) -> bool {
        self.grids.as_ref().map_or(grid != "vel", |grids| grids.iter().any(|name| name == grid))
    }
}

impl Model {
    /// The names of all scalars that any shape has, sorted.
    pub fn scalar_names(&self) -> BTreeSet<&str> {
        self.shapes.iter().flat_map(|shape| shape.scalars.keys()).map(String::as_str).collect()
    }

    /// The names of the grids that its frames may have.
    pub fn grid_names(&self) -> Vec<&str> {
        ["surface", &self.output.colour_name, "vel"].into_iter().chain(self.scalar_names()).collect()
    }

    /// The names that formulas know beside x, y, z, t, frame, time, with their values at a frame.
    pub fn moment(&self, frame: f64) -> Moment {
        let bare = self.shot.moment(frame, Arc::new([]));
        // Formulas of parameters know time only, so their values do not hang on one another.
        let values = self.parameters.iter().map(|parameter| parameter.value.at(&bare).unwrap_or(f64::NAN));
        Moment { parameters: values.collect(), ..bare }
    }

    /// The shape of an id.
    pub fn shape(&self, id: ShapeId) -> &Shape {
        &self.shapes[id.0]
    }
}
