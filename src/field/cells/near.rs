//! The nearest leaves of many points at a time.

use std::hint::select_unpredictable;

use super::{Aabb, CellId, Cells, DVec3, Node, Place, octant_bounds, octant_of};
use crate::field::{BATCH, Points};

/// Looking at so many leaves one after the other takes less time than a search of their tree.
const MOST_IN_TURN: usize = 48;

/// Points looked at together: few enough for what is known of them to stay in registers.
const LANES: usize = 8;

/// Stands for a leaf where several are as near: that is for the look-up of a single point to settle.
const TIED: u32 = u32::MAX;

/// A leaf's box as offsets from the points' origin.
struct Near {
    least: [f64; 3],
    greatest: [f64; 3],
    leaf: u32,
}

impl Cells {
    /// [`Cells::surface_leaf_at`] for each point, but for the rounding of an offset. `region` holds all points.
    pub fn surface_leaves_at(&self, points: &Points, region: &Aabb, out: &mut [u32; BATCH]) {
        let near = self.surface_leaves_near(region);
        if let [only] = near[..] {
            out[..points.len].fill(only.0);
            return;
        }
        if near.len() > MOST_IN_TURN {
            let mut last = self.surface()[0];
            for i in 0..points.len {
                last = self.surface_leaf_from(points.position(i), last);
                out[i] = last.0;
            }
            return;
        }
        let of_leaf = |&leaf: &CellId| {
            let bounds = self.cell(leaf).bounds;
            let offset = |corner: DVec3| (corner - points.origin).to_array();
            Near { least: offset(bounds.min), greatest: offset(bounds.max), leaf: leaf.0 }
        };
        nearest(points, &near.iter().map(of_leaf).collect::<Vec<_>>(), out);
        for (i, leaf) in out[..points.len].iter_mut().enumerate().filter(|(_, leaf)| **leaf == TIED) {
            *leaf = self.surface_leaf_at(points.position(i)).0;
        }
    }

    /// The leaves on the surface among which the nearest one of any position in a region is, in the order of
    /// [`Cells::cells`].
    pub fn surface_leaves_near(&self, region: &Aabb) -> Vec<CellId> {
        let (mut within, mut near) = (f64::INFINITY, Vec::new());
        self.collect_near(self.nodes[0], self.root, region, &mut within, &mut near);
        let mut near: Vec<CellId> =
            near.into_iter().filter(|(distance, _)| *distance <= within).map(|(_, id)| id).collect();
        near.sort_unstable();
        near
    }

    /// Collects leaves on the surface with their squared distances to a region. No position of the region is farther
    /// than `within`, squared, from some leaf, so that leaves beyond are nearest to none; it shrinks on the way.
    fn collect_near(&self, node: Node, bounds: Aabb, region: &Aabb, within: &mut f64, near: &mut Vec<(f64, CellId)>) {
        let distance = distance_squared(region, &bounds);
        if distance > *within {
            return;
        }
        match node {
            Node::Leaf(id) if self.cell(id).place == Place::Surface => {
                let away = (bounds.min - region.min).max(region.max - bounds.max).max(DVec3::ZERO);
                *within = within.min(away.length_squared());
                near.push((distance, id));
            }
            Node::Split { first, has_surface: true } => {
                let nearest = octant_of(region.centre(), bounds.centre());
                for octant in (0..8).map(|i| i ^ nearest) {
                    let child = self.nodes[first as usize + octant];
                    self.collect_near(child, octant_bounds(bounds, octant), region, within, near);
                }
            }
            _ => {}
        }
    }
}

/// The squared distance between two boxes.
fn distance_squared(a: &Aabb, b: &Aabb) -> f64 {
    (b.min - a.max).max(a.min - b.max).max(DVec3::ZERO).length_squared()
}

/// The leaf that each point is nearest to.
#[multiversion::multiversion(targets = "simd")]
fn nearest(points: &Points, near: &[Near], out: &mut [u32; BATCH]) {
    let [x, y, z] = [&points.x, &points.y, &points.z].map(|offsets| offsets.as_chunks::<LANES>().0);
    let out = out.as_chunks_mut::<LANES>().0;
    for at in 0..points.len.div_ceil(LANES) {
        let (mut least, mut leaf) = ([f64::INFINITY; LANES], [0; LANES]);
        for one in near {
            for i in 0..LANES {
                let distance = beyond(x[at][i].into(), one.least[0], one.greatest[0])
                    + beyond(y[at][i].into(), one.least[1], one.greatest[1])
                    + beyond(z[at][i].into(), one.least[2], one.greatest[2]);
                let other = select_unpredictable(distance == least[i], TIED, leaf[i]);
                leaf[i] = select_unpredictable(distance < least[i], one.leaf, other);
                least[i] = if distance < least[i] { distance } else { least[i] };
            }
        }
        out[at] = leaf;
    }
}

/// How far a number is outside of a range, squared.
#[inline(always)]
fn beyond(value: f64, least: f64, greatest: f64) -> f64 {
    let (below, above) = (least - value, value - greatest);
    let away = if below > above { below } else { above };
    let away = if away > 0.0 { away } else { 0.0 };
    away * away
}
