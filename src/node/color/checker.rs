//! Two colours in turns, cube by cube.

use std::sync::Arc;

use crate::attribute::{Attribute, CubeLattice, LinearRgb, Sampler};
use crate::field::{Aabb, BATCH, Points};
use crate::node::painted::Paint;
use crate::node::source::{Source, TOLERANCE_VOXELS};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// Two colours in turns, cube by cube.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "checker",
        Kind::TwoColours,
        Required,
        "Two colours in turns, cube by cube, in the shape's own space.",
    ),
    parameters: &[Key::new(
        "cube",
        Kind::Constant,
        Number(0.25),
        "A cube's edge; the origin is the middle of one of the first colour.",
    )
    .limit(Limit::Positive)
    .unit("units")],
    example: "{ checker = [\"#222222\", \"white\"] }",
    build: |source| {
        let [first, second] = source.arguments().colours("checker").map_or(&[][..], |colours| colours)[..] else {
            unreachable!("a checker has two colours")
        };
        let edge = *source.arguments().constant("cube").expect("it has a default");
        let tolerance = TOLERANCE_VOXELS * source.voxel();
        let cubes = CubeLattice { edge, solid: source.solid()?, tolerance };
        Ok(Paint::shared(Arc::new(Checker { cubes, colours: [first, second] })))
    },
    goes_by_coordinates: true,
    ..Source::PLAIN
};

struct Checker {
    cubes: CubeLattice,
    colours: [LinearRgb; 2],
}

impl Attribute<3> for Checker {
    fn sampler(&self) -> Box<dyn Sampler<3> + '_> {
        Box::new(self)
    }
}

impl Sampler<3> for &Checker {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            let cube = self.cubes.cube_at(points.position(i) / self.cubes.edge);
            *out = self.colours[(cube.element_sum().rem_euclid(2.0)) as usize];
        }
    }
}
