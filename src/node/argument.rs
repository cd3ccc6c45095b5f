//! The values of a node's keys, and what can be asked of all of them alike: which numbers, shapes, cells and files they
//! name. Nothing that walks over a scene has to know what any node is.

use std::sync::Arc;

use crate::attribute::LinearRgb;
use crate::field::{Aabb, CopyPlace};
use crate::node::applied::Applied;
use crate::node::id::{CellsId, ShapeId};
use crate::text::files::FileReference;

use crate::text::number::Number;
use crate::text::number::formula::Formula;
use crate::text::sequence::FileSequence;
use crate::text::source::Span;

/// The value of one key.
#[derive(Clone, Debug)]
pub enum Argument {
    /// A number that may change over time.
    Number(Number),
    /// Three of them.
    Vector(Box<[Number; 3]>),
    /// Two of them.
    Pair(Box<[Number; 2]>),
    /// Lists of numbers that stand still, such as points.
    Rows(Rows),
    /// A number that stands still.
    Constant(f64),
    /// What choices at random start from.
    Seed(u64),
    /// One of the key's names.
    Choice(&'static str),
    /// F as a formula of space.
    Formula(Formula),
    /// A file.
    File(FileReference),
    /// A file for each frame.
    Files(Arc<FileSequence>),
    /// A shape.
    Shape(ShapeId),
    /// Shapes.
    Shapes(Vec<ShapeId>),
    /// Shapes; `None` is the shape's own surface.
    Goals(Vec<Option<ShapeId>>),
    /// Cells.
    Cells(CellsId),
    /// Copies in cells.
    Copies(Copies),
    /// How many along x, y and z.
    Counts([u32; 3]),
    /// Places.
    Places(Places),
    /// A box.
    Box(Bounds),
    /// The name of a scalar of the shape.
    Scalar(ScalarName),
    /// A whole number.
    Whole(i64),
    /// Text, and where it stands.
    Text(String, Span),
    /// A colour, scene-linear.
    Colour(LinearRgb),
    /// Colours.
    Colours(Vec<LinearRgb>),
    /// Numbers that stand still.
    Numbers(Vec<f32>),
    /// Colours with the depths at which they begin.
    Bands(Vec<(f64, LinearRgb)>),
    /// Numbers with the depths at which they begin.
    NumberBands(Vec<(f64, [f32; 1])>),
    /// Numbers or formulas of space: three of a colour, or one.
    Components(Vec<Component>),
    /// How a morph's objects are rounded against the planes that cut them in time: a₀, reach, a₃ and depth.
    Round(Box<[Number; 4]>),
    /// How long places of a morph wait.
    Delay(Box<MorphDelay>),
    /// An operation of the scene's own with its numbers.
    Applied(Applied),
}

/// A number that may be a formula of space.
#[derive(Clone, Debug)]
pub enum Component {
    /// The same everywhere.
    Number(Number),
    /// A formula of space and time.
    Formula(Formula),
}

impl Component {
    /// Where the scene gives it.
    pub fn span(&self) -> Span {
        match self {
            Self::Number(number) => number.span,
            Self::Formula(formula) => formula.span(),
        }
    }
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

/// The scalar that a key names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScalarName {
    /// Its name.
    pub name: String,
    /// Where the scene names it.
    pub span: Span,
}

/// Lists of numbers, and where they stand.
#[derive(Clone, Debug)]
pub struct Rows {
    /// The lists.
    pub all: Vec<Vec<f64>>,
    /// Where the scene has them.
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

/// Places that a scene or a file lists.
#[derive(Clone, Debug)]
pub struct Places {
    /// The places.
    pub rows: Vec<CopyPlace>,
    /// The file.
    pub file: Option<FileReference>,
    /// Where the scene gives them.
    pub span: Span,
}

/// A box to cut off at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The box.
    pub aabb: Aabb,
    /// Whether it is meant to cut the shape.
    pub cut: bool,
    /// Where the scene gives it.
    pub span: Span,
}

/// The values of the keys of one node. A key that is left out and has no default of its own is not among them.
#[derive(Clone, Debug, Default)]
pub struct Arguments(pub(crate) Vec<(&'static str, Argument)>);

/// A row's key is of the kind that its functions ask for: a test builds every row.
macro_rules! of_kind {
    ($($(#[$doc:meta])* $name:ident: $kind:ident => $type:ty,)*) => {$(
        $(#[$doc])*
        pub fn $name(&self, key: &str) -> Option<&$type> {
            match self.get(key)? {
                Argument::$kind(value) => Some(value),
                other => unreachable!("`{key}` is {other:?}"),
            }
        }
    )*};
}

impl Arguments {
    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&Argument> {
        self.0.iter().find(|(name, _)| *name == key).map(|(_, value)| value)
    }

    of_kind! {
        /// A number.
        number: Number => Number,
        /// Three numbers.
        vector: Vector => [Number; 3],
        /// Two numbers.
        pair: Pair => [Number; 2],
        /// The numbers of a morph's `round`.
        round: Round => [Number; 4],
        /// How long places wait.
        delay: Delay => MorphDelay,
        /// Lists of numbers.
        rows: Rows => Rows,
        /// A number that stands still.
        constant: Constant => f64,
        /// What choices at random start from.
        seed: Seed => u64,
        /// One of the key's names.
        choice: Choice => &'static str,
        /// A formula of space.
        formula: Formula => Formula,
        /// A file.
        file: File => FileReference,
        /// A shape.
        shape: Shape => ShapeId,
        /// Shapes.
        shapes: Shapes => Vec<ShapeId>,
        /// Shapes; `None` is the shape's own surface.
        goals: Goals => Vec<Option<ShapeId>>,
        /// Cells.
        cells: Cells => CellsId,
        /// Copies.
        copies: Copies => Copies,
        /// How many along each axis.
        counts: Counts => [u32; 3],
        /// Places.
        places: Places => Places,
        /// A box.
        bounds: Box => Bounds,
        /// The name of a scalar.
        scalar: Scalar => ScalarName,
        /// A whole number.
        whole: Whole => i64,
        /// Colours.
        colours: Colours => Vec<LinearRgb>,
        /// Numbers that stand still.
        values: Numbers => Vec<f32>,
        /// Colours by depth.
        bands: Bands => Vec<(f64, LinearRgb)>,
        /// Numbers by depth.
        number_bands: NumberBands => Vec<(f64, [f32; 1])>,
    }

    /// The first number or formula of a key, if it has such.
    pub fn component(&self, key: &str) -> Option<&Component> {
        match self.get(key)? {
            Argument::Components(components) => components.first(),
            _ => None,
        }
    }

    /// An operation of the scene's own, if it is what makes the shape.
    pub fn applied(&self) -> Option<&Applied> {
        self.0.iter().find_map(|(_, value)| if let Argument::Applied(applied) = value { Some(applied) } else { None })
    }

    /// Where the value of a key stands, of those that have a place of their own.
    pub fn span(&self, key: &str) -> Option<Span> {
        match self.get(key)? {
            Argument::Number(number) => Some(number.span),
            Argument::Vector(vector) => Some(vector[0].span),
            Argument::Pair(pair) => Some(pair[0].span),
            Argument::Rows(rows) => Some(rows.span),
            Argument::Scalar(name) => Some(name.span),
            _ => None,
        }
    }

    /// Text, and where it stands.
    pub fn text(&self, key: &str) -> Option<(&str, Span)> {
        match self.get(key)? {
            Argument::Text(text, span) => Some((text, *span)),
            other => unreachable!("`{key}` is {other:?}"),
        }
    }

    /// Whether any of them is a number or formula of space.
    pub fn has_components(&self) -> bool {
        self.0.iter().any(|(_, value)| matches!(value, Argument::Components(_)))
    }

    fn components(&self) -> impl Iterator<Item = &Component> {
        self.0.iter().flat_map(|(_, value)| match value {
            Argument::Components(components) => &components[..],
            _ => &[],
        })
    }

    /// All numbers that may change over time.
    pub fn numbers(&self) -> impl Iterator<Item = &Number> {
        let whole = self.0.iter().flat_map(|(_, value)| match value {
            Argument::Number(number) => std::slice::from_ref(number),
            Argument::Vector(vector) => &vector[..],
            Argument::Pair(pair) => &pair[..],
            Argument::Round(round) => &round[..],
            Argument::Applied(applied) => &applied.numbers,
            _ => &[],
        });
        let of_space = self.components().filter_map(|component| match component {
            Component::Number(number) => Some(number),
            Component::Formula(_) => None,
        });
        whole.chain(of_space)
    }

    /// All formulas of space.
    pub fn formulas(&self) -> impl Iterator<Item = &Formula> {
        let whole = self.0.iter().filter_map(|(_, value)| match value {
            Argument::Formula(formula) => Some(formula),
            Argument::Applied(applied) => Some(&applied.operation.formula),
            _ => None,
        });
        let of_space = self.components().filter_map(|component| match component {
            Component::Formula(formula) => Some(formula),
            Component::Number(_) => None,
        });
        whole.chain(of_space)
    }

    /// All shapes, in the order of the keys.
    pub fn all_shapes(&self) -> impl Iterator<Item = ShapeId> {
        self.0.iter().flat_map(|(_, value)| {
            let (shapes, goals): (&[ShapeId], &[Option<ShapeId>]) = match value {
                Argument::Shape(shape) => (std::slice::from_ref(shape), &[]),
                Argument::Shapes(shapes) => (shapes, &[]),
                Argument::Goals(goals) => (&[], goals),
                _ => (&[], &[]),
            };
            shapes.iter().copied().chain(goals.iter().copied().flatten())
        })
    }

    /// All cells.
    pub fn all_cells(&self) -> impl Iterator<Item = CellsId> {
        self.0.iter().filter_map(|(_, value)| match value {
            Argument::Cells(cells) => Some(*cells),
            Argument::Copies(copies) => Some(copies.cells),
            _ => None,
        })
    }

    /// All files.
    pub fn files(&self) -> impl Iterator<Item = &FileReference> {
        let alone = self.0.iter().filter_map(|(_, value)| match value {
            Argument::File(file) => Some(file),
            Argument::Places(places) => places.file.as_ref(),
            _ => None,
        });
        alone.chain(self.sequence().into_iter().flat_map(FileSequence::files))
    }

    /// The files by frame, of a node that has such.
    pub fn sequence(&self) -> Option<&FileSequence> {
        self.0.iter().find_map(|(_, value)| if let Argument::Files(files) = value { Some(&**files) } else { None })
    }

    /// The file of a key at a frame.
    pub fn file_at(&self, key: &str, frame: f64) -> Option<&FileReference> {
        match self.get(key)? {
            Argument::Files(files) => Some(&files.at(frame).1),
            Argument::File(file) => Some(file),
            other => unreachable!("`{key}` is {other:?}"),
        }
    }

    /// All scalars of the shape itself.
    pub fn scalars(&self) -> impl Iterator<Item = &ScalarName> {
        self.0.iter().filter_map(|(_, value)| if let Argument::Scalar(name) = value { Some(name) } else { None })
    }
}
