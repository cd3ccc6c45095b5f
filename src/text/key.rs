//! What a table of a scene may hold: keys with their kinds, limits and defaults.

use crate::attribute::Components;

/// What a key takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number, a formula, or keys.
    Number,
    /// A number that stands still.
    Constant,
    /// A whole number.
    Whole,
    /// A whole number that choices at random start from.
    Seed,
    /// Three numbers, each as [`Kind::Number`].
    Vector,
    /// Three numbers, or one that stands for all three.
    Lengths,
    /// Two numbers, each as [`Kind::Number`], or one that stands for both.
    Pair,
    /// A list of at least so many lists of so many numbers that stand still, such as points.
    Rows(usize, &'static [usize]),
    /// True or false.
    Flag,
    /// Any text.
    Text,
    /// One of these names.
    Choice(&'static [&'static str]),
    /// A name of an easing, or the progress itself as [`Kind::Number`].
    Progress,
    /// A formula of space, or a table of [`DELAY`].
    Delay,
    /// Two numbers, each as [`Kind::Number`], the second greater.
    Span,
    /// Names of grids.
    Grids,
    /// Names that the table itself gives.
    Names,
    /// Whole frames, rising.
    KeyFrames,
    /// Frames, as `"1-48"` or `7`.
    Frames,
    /// A whole number, or a least and a greatest one.
    Depth,
    /// A file.
    Path,
    /// One of these names of what measures distances, or a table.
    Distance(&'static [&'static str]),
    /// A file, or one for each frame.
    Paths,
    /// F itself as a formula of x, y, z.
    Formula,
    /// A shape's name.
    Shape,
    /// The name of a scalar.
    Scalar,
    /// Two shapes and the scalar that mixes them.
    Fill,
    /// Names of shapes, at least so many; each may also be a shape written in place.
    Shapes(usize),
    /// Names of two shapes; each may also be a shape written in place.
    TwoShapes,
    /// The same, at least one; `"surface"` is the shape's own surface.
    Goals,
    /// Pairs of names of shapes, or `"auto"`.
    ShapePairs,
    /// Lists of places, each of one in every shape of a morph.
    PlacePairs,
    /// The name of cells, or cells written in place.
    Cells,
    /// A colour.
    Colour,
    /// A list of colours, or its name.
    Palette,
    /// Two colours.
    TwoColours,
    /// Three numbers of a colour, each also as a formula of space, and what they are.
    Components(Components),
    /// A list of at least one shape, or a word.
    ShapesOr(&'static str),
    /// A number as [`Kind::Number`], or a formula of space.
    OfSpace,
    /// Three numbers, each also as a formula of space.
    Formulas,
    /// Colours with the depths at which they begin.
    Bands,
    /// Numbers with the depths at which they begin.
    NumberBands,
    /// Colours at stops of a number.
    Stops,
    /// Numbers at stops of a number.
    NumberStops,
    /// A list of numbers.
    Numbers,
    /// Two numbers that stand still.
    TwoNumbers,
    /// Copies in cells.
    Copies,
    /// How many along x, y and z; one number stands for all three.
    Counts,
    /// Lists of numbers, a place each, or a CSV file of them.
    Places,
    /// A direction, or the name of an axis.
    Direction,
    /// Tables of one modifier each.
    Steps,
    /// An axis.
    Box,
    /// The table of a morph's `round`.
    Round,
    /// A table of its own, described elsewhere.
    Table,
}

impl Kind {
    /// In words.
    pub fn words(self) -> String {
        let choices = |names: &[&str]| names.iter().map(|name| format!("`\"{name}\"`")).collect::<Vec<_>>().join(", ");
        match self {
            Self::Number => "number".into(),
            Self::Constant => "number without time".into(),
            Self::Whole | Self::Seed => "whole number".into(),
            Self::Vector => "three numbers".into(),
            Self::Lengths => "one number or three".into(),
            Self::Pair => "one number or two".into(),
            Self::Rows(least, widths) => {
                let widths = widths.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ");
                format!("list of {least} or more lists of {widths} numbers")
            }
            Self::Flag => "true or false".into(),
            Self::Text => "text".into(),
            Self::Choice(names) => choices(names),
            Self::Distance(names) => format!("{}, or a table", choices(names)),
            Self::Progress => "`\"linear\"`, `\"smooth\"`, or the progress as a number".into(),
            Self::Delay => "number without time, formula of space, or table".into(),
            Self::Span => "two numbers, rising".into(),
            Self::Grids => "list of grids".into(),
            Self::Names => "list of names".into(),
            Self::KeyFrames => "list of whole frames, rising".into(),
            Self::Frames => "frames".into(),
            Self::Depth => "whole number or `[least, greatest]`".into(),
            Self::Path => "file".into(),
            Self::Paths => "file, or files by frame".into(),
            Self::Formula => "formula".into(),
            Self::Shape => "shape".into(),
            Self::Scalar => "name of an attribute".into(),
            Self::Fill => "`{ mix = [shape, shape], by = attribute }`".into(),
            Self::Shapes(_) => "list of shapes".into(),
            Self::TwoShapes => "two shapes".into(),
            Self::Goals => "list of shapes, `\"surface\"` among them".into(),
            Self::ShapesOr(word) => format!("list of shapes, or `\"{word}\"`"),
            Self::OfSpace => "number or formula of space".into(),
            Self::ShapePairs => "`\"auto\"`, or list of pairs of shapes".into(),
            Self::PlacePairs => "list of pairs of places `[x, y, z]`".into(),
            Self::Cells => "cells".into(),
            Self::Colour => "colour".into(),
            Self::Palette | Self::TwoColours => "list of colours".into(),
            Self::Components(_) | Self::Formulas => "three numbers or formulas of space".into(),
            Self::Bands => "list of `[depth, colour]`, depths rising".into(),
            Self::NumberBands => "list of `[depth, number]`, depths rising".into(),
            Self::Stops => "list of `[at, colour]`, rising".into(),
            Self::NumberStops => "list of `[at, number]`, rising".into(),
            Self::Numbers | Self::TwoNumbers => "list of numbers".into(),
            Self::Copies => "copies".into(),
            Self::Counts => "whole number or three".into(),
            Self::Places => "list of `[x, y, z, …]`, or a file".into(),
            Self::Direction => "`\"x\"`, `\"y\"`, `\"z\"`, or three numbers".into(),
            Self::Steps => "list of tables".into(),
            Self::Box => "box".into(),
            Self::Round | Self::Table => "table".into(),
        }
    }
}

/// What a number may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Any finite number.
    Any,
    /// Greater than zero.
    Positive,
    /// Zero or greater.
    NotNegative,
    /// Anything but zero.
    NotZero,
    /// From the first to the second, both included.
    Within(f64, f64),
}

/// The greatest size of a number. Past it a double's neighbours are a tenth apart and more, and squares and cubes of
/// lengths soon leave the range of a float of 32 bits, which frames are computed in.
pub const GREATEST: f64 = 1e15;
/// The least size of a number that must not be 0: divided by less, ordinary numbers pass [`GREATEST`].
pub const LEAST: f64 = 1e-15;

impl Limit {
    /// Whether a number may be used: within the limit, and of a size that can be computed with.
    pub fn allows(self, value: f64) -> bool {
        self.out_of_range(value).is_none()
    }

    /// What a number must be that may not be used, as it follows "must be".
    pub fn out_of_range(self, value: f64) -> Option<String> {
        let least = if matches!(self, Self::Positive | Self::NotZero) { LEAST } else { 0.0 };
        if !self.holds(value) {
            Some(self.words())
        } else if value.abs() > GREATEST {
            Some(format!("from {:e} to {GREATEST:e}", -GREATEST))
        } else if value.abs() < least {
            Some(format!("at least {LEAST:e} away from 0"))
        } else {
            None
        }
    }

    /// Whether a number is within the limit, whatever its size: whole numbers may be seeds.
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::NotZero => value != 0.0,
                Self::Within(lo, hi) => (lo..=hi).contains(&value),
            }
    }

    /// In words, as they follow "must be".
    pub fn words(self) -> String {
        match self {
            Self::Any => "finite".into(),
            Self::Positive => "greater than 0".into(),
            Self::NotNegative => "0 or greater".into(),
            Self::NotZero => "other than 0".into(),
            Self::Within(lo, GREATEST) => format!("at least {lo}"),
            Self::Within(lo, hi) if lo == -GREATEST => format!("at most {hi}"),
            Self::Within(lo, hi) => format!("from {lo} to {hi}"),
        }
    }
}

/// What holds where a key is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// The key must be there.
    Required,
    /// Nothing: what the key does is not done.
    Nothing,
    /// This number (all three where there are three).
    Number(f64),
    /// So many times the number of another key.
    Of(&'static str, f64),
    /// These three numbers.
    Vector([f64; 3]),
    /// This text or flag, as it is written.
    Text(&'static str),
    /// What the words say.
    Words(&'static str),
}

/// One key of a table.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// Other names that mean the same: the papers' symbols, other spellings.
    pub also: &'static [&'static str],
    /// What it takes.
    pub kind: Kind,
    /// What its numbers may be.
    pub limit: Limit,
    /// Their unit.
    pub unit: &'static str,
    /// What holds where it is left out.
    pub default: Absent,
    /// What it does.
    pub text: &'static str,
}

impl Key {
    /// A key without other names, limit and unit.
    pub const fn new(name: &'static str, kind: Kind, default: Absent, text: &'static str) -> Self {
        Self { name, also: &[], kind, limit: Limit::Any, unit: "", default, text }
    }

    /// With other names.
    pub const fn also(mut self, names: &'static [&'static str]) -> Self {
        self.also = names;
        self
    }

    /// With a limit of its numbers.
    pub const fn limit(mut self, limit: Limit) -> Self {
        self.limit = limit;
        self
    }

    /// With their unit.
    pub const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// A length in scene units that is greater than zero.
    pub const fn length(name: &'static str, default: Absent, text: &'static str) -> Self {
        Self::new(name, Kind::Number, default, text).limit(Limit::Positive).unit("units")
    }

    /// Whether a name means this key.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.also.contains(&name)
    }
}
