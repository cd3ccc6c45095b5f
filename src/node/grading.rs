//! Structures whose cells go over from one size to another: `fill` and `fill_to` of one row, by a scalar of what they fill.
//!
//! Two foams of different cells have nothing to do with one another, so that a mean of their values is neither. Instead one is
//! made whose size is the mean, by ω, of both; what else there is of a cell, a wall or a radius, is that of ω at its middle.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::argument::ScalarName;
use super::id::{ShapeId, Stage};
use super::solid::Solids;
use super::spec::{Build, Grading};
use crate::field::{Aabb, Dart, DartError, Darts, Expression, Field, Graph, Node, Seeds, WIDEST, shares_at};
use crate::text::key::Absent;
use crate::text::problem::Problem;

/// The most cells of a lattice.
const MOST: usize = 1 << 22;

/// Largest cells around the box of what is filled: a cell within is made by those around it.
const AROUND: f64 = 3.0;

/// A number that goes over from one to another.
#[derive(Clone, Copy, Debug)]
pub struct Ends(pub [f64; 2]);

impl Ends {
    /// Whether it stays the same.
    pub fn is_same(self) -> bool {
        self.0[0] == self.0[1]
    }

    /// By a share from 0 to 1.
    pub fn at(self, share: f64) -> f64 {
        let Self([from, to]) = self;
        from + (to - from) * share
    }
}

impl Grading<'_> {
    /// The number of a key of both.
    pub fn ends(&self, build: &dyn Build, key: &str) -> Result<Ends, Problem> {
        Ok(Ends([build.number(key)?, build.number_of(self.to, key)?]))
    }

    /// What is wrong with the value of a key of the other one.
    pub fn wrong(&self, build: &dyn Build, key: &str, problem: impl Into<String>) -> Problem {
        let main = self.to.0.first().map_or("", |(name, _)| *name);
        let span = self.to.span(key).or_else(|| self.to.span(main));
        Problem::new(span.unwrap_or(build.span()), problem)
    }

    /// Middles of cells of a size: of one that is the same all over, one in each cube of a lattice; else as far apart as it says.
    /// Each with ω. The first one's `seed` holds.
    pub fn cells(&self, build: &dyn Build, key: &str, size: Ends) -> Result<Vec<Dart>, Problem> {
        let jitter = build.constant("jitter");
        let seed = *build.arguments().seed("seed").expect("it has a default");
        if *self.to.constant("jitter").expect("it has a default") != jitter {
            let problem = format!("`{key}` and what it goes over into have different `jitter`s");
            return Err(self.wrong(build, key, problem).help("the same for both"));
        }
        let Ends(sizes) = size;
        let (smallest, largest) = (sizes[0].min(sizes[1]), sizes[0].max(sizes[1]));
        let around = self.around.grown(AROUND * largest);
        let made = if smallest == largest {
            let points = Seeds { edge: largest, jitter, seed }.within(&around, MOST).ok_or(DartError::TooMany);
            points.and_then(|points| {
                let shares = shares_at(self.by.as_ref(), &points)?;
                Ok(points.into_iter().zip(shares).map(|(at, share)| Dart { at, share }).collect())
            })
        } else {
            self.are_within_reach(build, key, [smallest, largest])?;
            self.has_no_lattice(build, key)?;
            Darts { around, solid: self.solid.as_ref(), sizes, by: self.by.as_ref(), seed }.thrown()
        };
        made.map_err(|error| self.failed(build, key, size, error))
    }

    /// Why there are no cells of a size, or nothing is known of them.
    pub fn failed(&self, build: &dyn Build, key: &str, Ends(sizes): Ends, error: DartError) -> Problem {
        match error {
            DartError::TooMany => {
                let DVec3 { x, y, z } = self.around.size();
                let (smallest, largest) = (sizes[0].min(sizes[1]), sizes[0].max(sizes[1]));
                let problem = format!(
                    "`{key}` has too many cells to place them: of {smallest} to {largest} in a box of {x:.4} x {y:.4} x {z:.4}"
                );
                build.wrong(key, problem).help("larger cells, or fewer places where they are small")
            }
            DartError::NoNumber(DVec3 { x, y, z }) => {
                let problem = format!("`{}` is no number at ({x}, {y}, {z}), where `{key}` goes by it", self.name.name);
                Problem::new(self.name.span, problem).help("it must be one a few cells around the shape, too")
            }
        }
    }

    /// Refuses sizes that are too different to go over into one another.
    pub fn are_within_reach(&self, build: &dyn Build, key: &str, sizes: [f64; 2]) -> Result<(), Problem> {
        let [smallest, largest] = sizes;
        if largest <= WIDEST * smallest {
            return Ok(());
        }
        let problem = format!("cells of `{key}` from {smallest} to {largest} differ by more than {WIDEST} times");
        Err(self.wrong(build, key, problem).help("sizes that are nearer to one another"))
    }

    /// Refuses a number that is about cells of one size.
    fn has_no_lattice(&self, build: &dyn Build, key: &str) -> Result<(), Problem> {
        let jitter = build.constant("jitter");
        if matches!(build.key("jitter").default, Absent::Number(default) if default == jitter) {
            return Ok(());
        }
        let problem = format!("`jitter` has no meaning where the size of `{key}` changes: no lattice has such cells");
        Err(build.wrong("jitter", problem).help("leave it out, or give both the same size"))
    }
}

impl Solids {
    /// One structure that goes over into another by ω, as it stands; `None` of such that are mixed by their values: of
    /// different rows, that stand differently, or that something is done to.
    pub(super) fn graded(
        &mut self,
        [from, to]: [ShapeId; 2],
        (name, by): (&ScalarName, Arc<dyn Field>),
        (solid, around): (Node, Aabb),
    ) -> Result<Option<Node>, Problem> {
        let model = self.model();
        let shapes = [from, to].map(|id| model.shape(id));
        let [first, second] = shapes;
        let is_bare = shapes.iter().all(|shape| shape.modifiers.is_empty());
        let Some(graded) = first.spec.graded.filter(|_| is_bare && first.spec.key.name == second.spec.key.name) else {
            return Ok(None);
        };
        let map = self.placement(&first.placement, Stage::Placed)?;
        if map != self.placement(&second.placement, Stage::Placed)? {
            return Ok(None);
        }
        let own = map.inverse();
        if !own.is_finite() {
            // The structure itself says that its place flattens space.
            return Ok(None);
        }
        let corners = around.corners().map(|corner| own.transform_point3(corner));
        let around = corners.into_iter().map(|corner| Aabb::new(corner, corner)).reduce(Aabb::union).unwrap_or(around);
        let [by, solid] = [by, self.field_of(solid)].map(|field| read_through(field, &map));
        let grading = Grading { to: &second.arguments, by, solid, around, name };
        self.made_by(from, &map, |build| graded(build, &grading))
    }
}

/// A field whose value at a position is that of another one where a map has it.
fn read_through(field: Arc<dyn Field>, map: &DAffine3) -> Arc<dyn Field> {
    if *map == DAffine3::IDENTITY {
        return field;
    }
    let (rows, by) = (map.matrix3.transpose(), map.translation);
    let mut graph = Graph::new();
    let at = [(rows.x_axis, by.x), (rows.y_axis, by.y), (rows.z_axis, by.z)].map(|(row, by)| graph.affine(row, by));
    let node = graph.field_at(field, at);
    Arc::new(Expression::new(&graph, node).keeping_values())
}
