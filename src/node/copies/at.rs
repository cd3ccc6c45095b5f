//! Copies in cells.

use std::sync::Arc;

use glam::DVec3;

use crate::attribute::CellIndex;
use crate::distance::nearest::PointTree;
use crate::field::cells::{CellId, Cells};
use crate::field::facet::{scatter, surface_points};
use crate::field::{BATCH, Field, Points};
use crate::node::spec::{Build, Spec};
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// Copies in cells, in place of the one at the origin.
pub const NODE: Spec = Spec {
    key: Key::new("at", Kind::Copies, Nothing, "Copies in cells, in place of the one at the origin."),
    example: "sphere = 0.3\nat = { cells = \"c\", pick = 0.5 }",
    cells: Some(|build| {
        let (host, cells, picked) = picked(build)?;
        Ok(Arc::new(NearestCopy::new(surface_points(host.as_ref(), &cells, &picked))))
    }),
    build: |build| {
        let (host, cells, picked) = picked(build)?;
        let shape = build.inner()?;
        Ok(scatter(build.graph(), shape, host.as_ref(), &cells, &picked))
    },
    ..Spec::PLAIN
};

/// What the cells stand around, the cells, and which of them get a copy.
type Picked = (Arc<dyn Field>, Arc<Cells>, Vec<CellId>);

fn picked(build: &mut dyn Build) -> Result<Picked, Problem> {
    let copies = build.arguments().copies("at").expect("it must be there").clone();
    let cells = build.cells(copies.cells)?;
    let picked = cells.pick(copies.pick, copies.seed);
    Ok((build.host(copies.cells)?, cells, picked))
}

/// Copies, by the middle that is nearest.
struct NearestCopy {
    middles: PointTree,
    /// The copy of each of the tree's points.
    copies: Vec<u32>,
}

impl NearestCopy {
    fn new(middles: Vec<DVec3>) -> Self {
        let tree = PointTree::new(middles.clone());
        let mut copies = vec![0; middles.len()];
        // Of points in one place the tree tells always the same; it stands for the first copy there.
        for (copy, middle) in middles.iter().enumerate().rev() {
            if let Some((number, _)) = tree.nearest(*middle, None) {
                copies[number] = copy as u32;
            }
        }
        Self { middles: tree, copies }
    }
}

impl CellIndex for NearestCopy {
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]) {
        let positions: Vec<DVec3> = (0..points.len).map(|i| points.position(i)).collect();
        let mut nearest = Vec::with_capacity(BATCH);
        self.middles.nearest_each(&positions, &mut nearest);
        // No number comes back where there are no copies.
        out[..points.len].fill(0);
        for (out, number) in out.iter_mut().zip(nearest) {
            *out = self.copies[number];
        }
    }
}
