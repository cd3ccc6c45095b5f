//! Where a solid's volume lies: its centre, and its principal axes of inertia.

use glam::{DMat3, DVec3};

use super::coarse::CoarseGrid;
use super::object::MorphObject;
use super::volume::object_fractions;
use crate::field::eigen_descending;

/// How many times as far a solid reaches along an axis as along the next, so that the two are told apart. Less: how cells
/// lie on a cube decides where it turns; more: what is plainly longer than wide is not turned lengthwise.
const CLEAR: f64 = 1.05;

/// The axes of a solid that are told apart by how far it reaches along them, as unit vectors without a sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Axes {
    /// All, longest first.
    All(DMat3),
    /// One: it stands out, and the other two are alike.
    One {
        /// It.
        axis: DVec3,
        /// 0 where it is the longest, 2 where it is the shortest.
        place: usize,
    },
    /// None, as of a ball or a cube.
    None,
}

impl Axes {
    /// The same of the solid turned.
    pub(super) fn turned(self, turn: DMat3) -> Self {
        match self {
            Self::All(axes) => Self::All(turn * axes),
            Self::One { axis, place } => Self::One { axis: turn * axis, place },
            Self::None => Self::None,
        }
    }
}

/// A solid's centre of volume and its axes, in its own space.
pub(super) struct Inertia {
    pub centre: DVec3,
    pub axes: Axes,
}

impl Inertia {
    /// From a distance on a coarse grid over its box, by the fraction inside of each cell; the middle of the box and no
    /// axes where no cell has any. `None` where the box is not known.
    pub(super) fn of(object: &MorphObject) -> Option<Self> {
        let own = object.own_box()?;
        let grid = CoarseGrid::over(own, (own.size().z == 0.0).then_some(1.0));
        let unit = grid.edge();
        let fractions = object_fractions(&grid, &grid.sampled(object.distance.as_ref(), unit), unit);
        let cells = || fractions.iter().enumerate().filter(|(_, inside)| **inside > 0.0);
        let from = |cell: usize| grid.centre(cell) - own.centre();
        let (mut volume, mut first) = (0.0, DVec3::ZERO);
        for (cell, inside) in cells() {
            volume += f64::from(*inside);
            first += from(cell) * f64::from(*inside);
        }
        if volume <= 0.0 {
            return Some(Self { centre: own.centre(), axes: Axes::None });
        }
        let middle = first / volume;
        let mut second = DMat3::ZERO;
        for (cell, inside) in cells() {
            let from = from(cell) - middle;
            let weighed = from * f64::from(*inside);
            second += DMat3::from_cols(from * weighed.x, from * weighed.y, from * weighed.z);
        }
        Some(Self { centre: own.centre() + middle, axes: axes(second * (1.0 / volume)) })
    }
}

/// The axes of a matrix of second moments.
fn axes(moments: DMat3) -> Axes {
    let [longest, middle, shortest] = eigen_descending(moments).map(|(square, axis)| (square.max(0.0).sqrt(), axis));
    let clear = |one: f64, other: f64| one > CLEAR * other;
    match (clear(longest.0, middle.0), clear(middle.0, shortest.0)) {
        (true, true) => Axes::All(DMat3::from_cols(longest.1, middle.1, shortest.1)),
        (true, false) => Axes::One { axis: longest.1, place: 0 },
        (false, true) => Axes::One { axis: shortest.1, place: 2 },
        (false, false) => Axes::None,
    }
}
