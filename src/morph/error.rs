//! Why a morph cannot be made.

use std::fmt;

/// Why a morph cannot be made.
#[derive(Clone, Debug, PartialEq)]
pub enum Error {
    /// A setting is out of its range.
    Setting {
        /// Its name in a scene.
        name: &'static str,
        /// What was given.
        value: f64,
        /// The least it can be.
        least: f64,
        /// The most it can be.
        most: f64,
    },
    /// A span does not run forward.
    Span {
        /// Its name in a scene.
        name: &'static str,
        /// Where it was to start.
        from: f64,
        /// Where it was to end.
        to: f64,
    },
    /// An object reaches to infinity, or its box is not finite.
    Unbounded(Side),
    /// An anchor lies outside of its object.
    AnchorOutside {
        /// Which pair of anchors it is in, from 0.
        place: usize,
        /// Whose it is.
        side: Side,
    },
    /// All anchors of an object are at one place, and so tell no turn.
    AnchorsAlike,
    /// Three anchors or more lie on one line, or nearly, and so tell no turn about it.
    AnchorsInLine,
    /// Neither object holds any volume that the coarse grid can see.
    Empty,
    /// The grid over all of the objects' way is so coarse that it holds neither: so few cells are across the longer of them.
    Far(f64),
    /// The in-betweens reach too far outside both objects to be measured.
    Spreads {
        /// The scene time τ at which they first do.
        time: f64,
        /// STB's time there.
        t: f64,
    },
}

/// One of a morph's two objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The object at the start.
    From,
    /// The object at the end.
    To,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::From => "from",
            Self::To => "to",
        })
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Setting { name, value, least, most } if least == most => {
                write!(f, "the morph's {name} is {value}; it must be {least}")
            }
            Self::Setting { name, value, least, most } => {
                write!(f, "the morph's {name} is {value}; it must lie between {least} and {most}")
            }
            Self::Span { name, from, to } => {
                write!(f, "the morph's {name} runs from {from} to {to}; it must end after it starts")
            }
            Self::Unbounded(side) => {
                write!(f, "the object the morph goes {side} has no bounds; give the shape `bounds`")
            }
            Self::AnchorOutside { side, .. } => {
                write!(f, "an anchor lies outside of the object the morph goes {side}, as that stands then")
            }
            Self::AnchorsAlike => write!(f, "the anchors of an object are all at one place, and so tell no turn"),
            Self::AnchorsInLine => {
                write!(f, "the anchors lie on one line, and so tell no turn about it")
            }
            Self::Empty => {
                write!(f, "neither of the morph's objects holds any volume; check their formulas, sizes and places")
            }
            Self::Far(cells) => write!(
                f,
                "the objects go so far that only {cells:.1} cells of the grid over their way are across them, too few for their \
                 volumes; `carry = \"centroid\"` measures them one within the other"
            ),
            Self::Spreads { t, .. } => write!(
                f,
                "the in-betweens spread far outside both objects, first at t = {t:.3}; use a smaller \
                 `bridge`, `volume` or `a0` there"
            ),
        }
    }
}

impl std::error::Error for Error {}

/// Refuses a setting that is out of its range.
pub(super) fn within(name: &'static str, value: f64, least: f64, most: f64) -> Result<(), Error> {
    if (least..=most).contains(&value) { Ok(()) } else { Err(Error::Setting { name, value, least, most }) }
}
