//! Cellular noise: how far the nearest of scattered points is, one in each cell.
//!
//! Worley, A cellular texture basis function, SIGGRAPH 1996. Points keep a tenth of the cell from its walls, so that the two
//! nearest are always among the cells that are looked at.

use glam::{DVec3, I64Vec3};

use super::hash::{cells_around, of_cell, shares};
use super::{Noise, numbered};

/// Which distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Near {
    /// That of the nearest point.
    First,
    /// That of the second nearest.
    Second,
    /// How much farther the second nearest is: 0 on the walls between points.
    Edge,
}

/// Cellular noise.
#[derive(Clone, Copy, Debug)]
pub struct Worley {
    /// What it starts from.
    pub seed: u64,
    /// Which distance.
    pub near: Near,
}

/// How far points are from the walls of their cells.
const MARGIN: f64 = 0.1;

/// The own cell's point is no farther: 0.9·√3.
const FIRST: f64 = 1.558_845_726_811_989_8;

/// That of the nearest face's other side is no farther: √(1.4² + 0.9² + 0.9²).
const SECOND: f64 = 1.892_088_792_841_193_7;

/// Cells to either side that are looked at: what lies beyond is 2.1 away at least.
const AROUND: i64 = 2;

impl Worley {
    /// The distances of the two nearest points and the directions away from them.
    fn two_nearest(&self, position: DVec3) -> [(f64, DVec3); 2] {
        let base = position.floor();
        let cell = numbered(base);
        let mut nearest = [(f64::INFINITY, DVec3::ZERO); 2];
        // The cells in the order of how near they may be: most are never hashed.
        for ring in 0..=AROUND {
            cells_around(ring, |by| self.look(position, base, cell, by, &mut nearest));
        }
        nearest
    }

    fn look(&self, position: DVec3, base: DVec3, cell: I64Vec3, by: I64Vec3, nearest: &mut [(f64, DVec3); 2]) {
        let corner = base + by.as_dvec3();
        let (least, most) = (corner + MARGIN, corner + (1.0 - MARGIN));
        let apart = (least - position).max(position - most).max(DVec3::ZERO).length_squared();
        if apart >= nearest[1].0 {
            return;
        }
        let point = least + shares(of_cell(cell + by, self.seed)) * (1.0 - 2.0 * MARGIN);
        let way = position - point;
        let far = way.length_squared();
        if far < nearest[0].0 {
            *nearest = [(far, way), nearest[0]];
        } else if far < nearest[1].0 {
            nearest[1] = (far, way);
        }
    }
}

impl Noise for Worley {
    fn at(&self, position: DVec3) -> (f64, DVec3) {
        if !position.is_finite() {
            return (f64::NAN, DVec3::NAN);
        }
        let [first, second] = self.two_nearest(position).map(|(square, way)| {
            let far = square.sqrt();
            (far, if far > 0.0 { way / far } else { DVec3::ZERO })
        });
        match self.near {
            Near::First => ((first.0 / FIRST).min(1.0), first.1 / FIRST),
            Near::Second => ((second.0 / SECOND).min(1.0), second.1 / SECOND),
            Near::Edge => (((second.0 - first.0) / SECOND).min(1.0), (second.1 - first.1) / SECOND),
        }
    }

    fn steepest(&self) -> f64 {
        match self.near {
            Near::First => 1.0 / FIRST,
            Near::Second => 1.0 / SECOND,
            Near::Edge => 2.0 / SECOND,
        }
    }
}
