//! Boxes around solids from interval bounds alone: what construction does not tell, half-spaces in which F is
//! negative throughout do.

use glam::DVec3;

use super::program::Program;
use super::{Aabb, interval::Intervals};

/// Steps of bisection for each face: a box is found to about a thousandth of its size.
const STEPS: usize = 12;

/// Rounds over the faces at most; a round that gains less than a hundredth ends them.
const ROUNDS: usize = 8;

/// The half-widths tried for a solid without a known box: from a hair to a solar system.
const REACHES: std::ops::RangeInclusive<i32> = -10..=40;

/// The known box, or one that bounds find, drawn in as far as bounds show the solid to be absent. Fields read
/// from elsewhere are not asked: a box that hangs on them stays as it is.
pub(super) fn narrowed(program: &Program, known: Option<Aabb>) -> Option<Aabb> {
    if !program.externals.is_empty() {
        return known;
    }
    let mut bounds = Intervals::default();
    let mut absent = |region: &Aabb| {
        program.bound(&program.ops, region, true, &mut [], &mut bounds);
        bounds.last().is_some_and(|bound| bound.hi < 0.0)
    };
    let everywhere = Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY);
    let mut found = match known {
        Some(known) => known,
        None => REACHES.map(|power| 2f64.powi(power)).find_map(|reach| {
            let outside_absent = (0..3).all(|axis| {
                let (mut above, mut below) = (everywhere, everywhere);
                above.min[axis] = reach;
                below.max[axis] = -reach;
                absent(&above) && absent(&below)
            });
            outside_absent.then_some(Aabb::new(DVec3::splat(-reach), DVec3::splat(reach)))
        })?,
    };
    for _ in 0..ROUNDS {
        let size = found.size();
        for axis in 0..3 {
            draw_in(&mut found, axis, &mut absent);
        }
        if found.size().cmpge(size * 0.99).all() {
            break;
        }
    }
    Some(found)
}

/// Moves both faces of a box along an axis inward, as long as the slab they pass holds nothing.
fn draw_in(found: &mut Aabb, axis: usize, absent: &mut impl FnMut(&Aabb) -> bool) {
    let (low, high) = (found.min[axis], found.max[axis]);
    let upper = bisected(high, low, |place| {
        let mut slab = *found;
        slab.min[axis] = place;
        absent(&slab)
    });
    let lower = bisected(low, upper, |place| {
        let mut slab = *found;
        slab.max[axis] = place;
        absent(&slab)
    });
    (found.min[axis], found.max[axis]) = (lower.min(upper), upper);
}

/// The place farthest from `from` towards `to` up to which `holds`; `from` where none is found.
fn bisected(from: f64, to: f64, mut holds: impl FnMut(f64) -> bool) -> f64 {
    let (mut good, mut bad) = (from, to);
    for _ in 0..STEPS {
        let middle = good + (bad - good) * 0.5;
        if holds(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}
