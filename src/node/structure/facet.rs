//! A shape cut by planes at random, cell by cell.

use std::sync::Arc;

use crate::attribute::CellIndex;
use crate::field::cells::Cells;
use crate::field::facet::{Options, Pieces, facet};
use crate::field::{BATCH, Points};
use crate::node::keys::seed;
use crate::node::spec::{Build, Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A shape cut by planes at random, cell by cell.
pub const NODE: Spec = Spec {
    key: Key::new("facet", Kind::Shape, Required, "A shape whose surface, cell by cell, is cut by a plane at random."),
    parameters: &[
        Key::new("cells", Kind::Cells, Required, "The cells that the surface is cut by."),
        Key::new("tilt", Kind::Constant, Number(20.0), "The most that a plane is tilted.")
            .limit(Limit::Within(0.0, 60.0))
            .unit("degrees"),
        Key::new("cut", Kind::Constant, Number(0.1), "The deepest that a plane cuts.")
            .limit(Limit::NotNegative)
            .unit("units"),
        seed("The number that its chances start from."),
    ],
    example: "facet = \"a\"\ncells = \"c\"",
    carries: Carries::Any,
    cells: Some(|build| {
        let pieces = build.pieces()?;
        Ok(Arc::new(FacetCells { pieces, cells: cells(build)? }))
    }),
    build: |build| {
        let cells = cells(build)?;
        let whole = *build.arguments().shape("facet").expect("it must be there");
        let whole = build.shape(whole)?;
        let seed = *build.arguments().seed("seed").expect("it has a default");
        let options = Options { tilt: build.constant("tilt"), cut: build.constant("cut"), seed };
        let made = facet(build.graph(), whole, &cells, &options);
        build.keep_pieces(made.pieces);
        Ok(made.node)
    },
    ..Spec::PLAIN
};

fn cells(build: &mut dyn Build) -> Result<Arc<Cells>, crate::text::problem::Problem> {
    let cells = *build.arguments().cells("cells").expect("it must be there");
    build.cells(cells)
}

/// The cells of a faceted shape, each as far as its material reaches.
struct FacetCells {
    pieces: Arc<Pieces>,
    cells: Arc<Cells>,
}

impl CellIndex for FacetCells {
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]) {
        self.pieces.cells_at(&self.cells, points, out);
    }
}
