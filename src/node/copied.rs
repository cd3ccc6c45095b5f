//! Copies of a shape, one map for all: field, colours, scalars and motion go with each copy.

use std::sync::Arc;

use glam::DVec3;

use crate::attribute::CellIndex;
use crate::field::{Aabb, BATCH, Copies, CopyPlace, Expression, Graph, Node, Points};
use crate::node::bend::Bend;
use crate::node::spec::Build;
use crate::text::problem::Problem;

/// The most copies of one node. More take gigabytes.
pub(crate) const MOST_COPIES: usize = 4_000_000;

/// Copies of the shape so far, in some places.
pub(crate) fn copies_of(build: &mut dyn Build, places: Vec<CopyPlace>) -> Result<Arc<dyn Bend>, Problem> {
    let inner = build.inner()?;
    let own = match build.graph().known_box(inner) {
        Some(own) => own,
        None => build.solid_box(inner)?,
    };
    let inner = Expression::new(build.graph(), inner);
    Ok(Arc::new(Copied(Arc::new(Copies::new(inner, own, places)))))
}

/// The cells of copies: each is one.
pub(crate) fn cells_of(build: &mut dyn Build) -> Result<Arc<dyn CellIndex>, Problem> {
    let bend = build.bend()?;
    Ok(bend.cells().unwrap_or_else(|| unreachable!("copies are cells")))
}

/// The map from a shape to its copies.
struct Copied(Arc<Copies>);

impl Copied {
    fn place(&self, position: DVec3) -> Option<&CopyPlace> {
        self.0.copy_at(position).map(|copy| &self.0.places()[copy])
    }
}

impl Bend for Copied {
    fn node(&self, graph: &mut Graph, _node: Node) -> Node {
        let node = graph.field(Arc::clone(&self.0) as _);
        // No copy's value is greater than minus the distance to its box.
        graph.falling(node, 1.0)
    }

    fn back(&self, position: DVec3) -> DVec3 {
        self.place(position).map_or(position, |place| place.back(position))
    }

    fn region(&self, region: &Aabb) -> Aabb {
        self.0.region_back(region)
    }

    fn carried(&self, position: DVec3, vector: DVec3) -> DVec3 {
        self.place(position).map_or(vector, |place| place.carried(vector))
    }

    fn branch(&self, position: DVec3) -> u32 {
        self.0.copy_at(position).map_or(0, |copy| copy as u32)
    }

    fn forth(&self, own: DVec3, branch: u32) -> Option<DVec3> {
        self.0.places().get(branch as usize).map(|place| place.forth(own))
    }

    fn cells(&self) -> Option<Arc<dyn CellIndex>> {
        Some(Arc::new(CopyIndex(Arc::clone(&self.0))))
    }
}

/// The copy that a point belongs to.
struct CopyIndex(Arc<Copies>);

impl CellIndex for CopyIndex {
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]) {
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            *out = self.0.copy_at(points.position(i)).map_or(0, |copy| copy as u32);
        }
    }
}

/// Numbers at random that are the same on every machine: SplitMix64 (Steele, Lea and Flood, Fast splittable pseudorandom
/// number generators, 2014) of a seed and a count.
pub(crate) struct Chance {
    state: u64,
}

impl Chance {
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// From 0 to below 1.
    pub fn next(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In a box.
    pub fn within(&mut self, region: &Aabb) -> DVec3 {
        let share = DVec3::new(self.next(), self.next(), self.next());
        region.min + share * region.size()
    }

    /// From −1 to below 1.
    pub fn spread(&mut self) -> f64 {
        2.0 * self.next() - 1.0
    }
}

/// The rotation that turns z to a direction, x to where that is across from `up`.
pub(crate) fn facing(direction: DVec3, up: DVec3) -> glam::DMat3 {
    let z = direction.normalize_or(DVec3::Z);
    let across = up.cross(z);
    let x = if across.length() > 1e-9 { across.normalize() } else { z.any_orthonormal_vector() };
    glam::DMat3::from_cols(x, z.cross(x), z)
}
