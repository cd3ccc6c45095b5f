//! Periodic minimal surfaces, by the few waves that are near to them.
//!
//! A sheet is |g| ≤ t/2·|∇g|: to first order all that is within t/2 of g = 0, so that its thickness is a length, whatever g
//! is in. Where g is flat there is no sheet, and nothing is divided by its slope.

use super::argument::Arguments;
use super::grading::Ends;
use super::octaves::octaves;
use super::spec::{Build, Grading};
use crate::field::{Graph, Node, Slope};
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

use Wave::{Cos, Sin};

/// A wave along an axis: of 0 … 2 for x … z, and how many go into a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wave {
    /// The cosine.
    Cos(usize, i32),
    /// The sine.
    Sin(usize, i32),
}

/// A product of waves on different axes, with a factor.
#[derive(Clone, Copy, Debug)]
pub struct Term(pub f64, pub &'static [Wave]);

/// Points along a cell's edge at which the share of space and the mean slope are counted: the share is right to a
/// thousandth.
const GRID: usize = 32;

impl Wave {
    fn axis(self) -> (usize, f64) {
        match self {
            Cos(axis, times) | Sin(axis, times) => (axis, f64::from(times)),
        }
    }

    /// The wave at a point of the grid, or its derivative by its own coordinate.
    fn at(self, grid: &Grid, point: [usize; 3], derived: bool) -> f64 {
        let (axis, times) = self.axis();
        let turn = (2 * point[axis] + 1) * times as usize;
        match (self, derived) {
            (Cos(..), false) => grid.cos(turn),
            (Cos(..), true) => -times * grid.sin(turn),
            (Sin(..), false) => grid.sin(turn),
            (Sin(..), true) => times * grid.cos(turn),
        }
    }

    fn node(self, graph: &mut Graph, angles: [Node; 3], derived: bool) -> Node {
        let (axis, times) = self.axis();
        let angle = graph.linear(angles[axis], times, 0.0);
        let factor = match (self, derived) {
            (_, false) => 1.0,
            (Cos(..), true) => -times,
            (Sin(..), true) => times,
        };
        let wave = if matches!(self, Cos(..)) == derived { graph.sin(angle) } else { graph.cos(angle) };
        graph.linear(wave, factor, 0.0)
    }
}

impl Term {
    /// Whether its derivative by an axis is 0.
    fn is_without(&self, by: Option<usize>) -> bool {
        by.is_some_and(|by| self.1.iter().all(|wave| wave.axis().0 != by))
    }

    /// The term at a point of the grid, or its derivative by an axis.
    fn at(&self, grid: &Grid, point: [usize; 3], by: Option<usize>) -> f64 {
        if self.is_without(by) {
            return 0.0;
        }
        self.1.iter().fold(self.0, |product, wave| product * wave.at(grid, point, by == Some(wave.axis().0)))
    }

    fn node(&self, graph: &mut Graph, angles: [Node; 3], by: Option<usize>) -> Option<Node> {
        if self.is_without(by) {
            return None;
        }
        let factors = self.1.iter().map(|wave| wave.node(graph, angles, by == Some(wave.axis().0)));
        let factors: Vec<Node> = factors.collect();
        match factors.into_iter().reduce(|product, factor| graph.mul(product, factor)) {
            Some(product) => Some(graph.linear(product, self.0, 0.0)),
            None => Some(graph.constant(self.0)),
        }
    }

    /// A bound of the derivative by some axes, one after another.
    fn bound(&self, by: &[usize]) -> f64 {
        by.iter().fold(self.0.abs(), |bound, by| {
            let times = self.1.iter().find(|wave| wave.axis().0 == *by).map_or(0.0, |wave| wave.axis().1);
            bound * times
        })
    }
}

fn sum(graph: &mut Graph, terms: &[Term], angles: [Node; 3], by: Option<usize>) -> Node {
    let parts: Vec<Node> = terms.iter().filter_map(|term| term.node(graph, angles, by)).collect();
    let zero = graph.constant(0.0);
    parts.into_iter().fold(zero, |sum, part| graph.add(sum, part))
}

/// The keys beside the edge of a cell, of all of these surfaces.
pub const SHEET_OR_SOLID: &[Key] = &[
    Key::new(
        "thickness",
        Kind::Number,
        Nothing,
        "The thickness of a sheet along it, units, by the slope at its middle. Either this or `fraction`.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    Key::new(
        "fraction",
        Kind::Number,
        Nothing,
        "The share of space that is filled on one side of it. Either this or `thickness`.",
    )
    .limit(Limit::Within(0.01, 0.99)),
];

/// Which part of space is filled.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// A sheet of a thickness.
    Sheet(f64),
    /// The side that is so much of space.
    Solid(f64),
}

/// The row's node: a sheet of `thickness`, or the side that `fraction` fills.
pub fn surface(build: &mut dyn Build, key: &'static str, terms: &[Term]) -> Result<Node, Problem> {
    let part = part_of(build, build.arguments(), key, |at, problem| build.wrong(at, problem))?;
    let edge = build.number(key)?;
    Ok(sized(build.graph(), terms, edge, part).0)
}

/// The row's node that goes over into another one of it.
pub fn graded(
    build: &mut dyn Build,
    grading: &Grading<'_>,
    key: &'static str,
    terms: &[Term],
) -> Result<Option<Node>, Problem> {
    let from = part_of(build, build.arguments(), key, |at, problem| build.wrong(at, problem))?;
    let to = part_of(build, grading.to, key, |at, problem| grading.wrong(build, at, problem))?;
    octaves(build, grading, key, |build, octave| {
        let part = match (from, to) {
            (Part::Sheet(from), Part::Sheet(to)) => Part::Sheet(Ends([from, to]).at(octave.share) * octave.scale),
            (Part::Solid(from), Part::Solid(to)) => Part::Solid(Ends([from, to]).at(octave.share)),
            _ => {
                let problem = format!("one `{key}` has a `thickness` and the other one a `fraction`");
                return Err(grading.wrong(build, key, problem).help("the same of them for both"));
            }
        };
        Ok(sized(build.graph(), terms, octave.edge, part))
    })
}

/// The part of space that keys say.
fn part_of(
    build: &dyn Build,
    arguments: &Arguments,
    key: &'static str,
    wrong: impl Fn(&str, String) -> Problem,
) -> Result<Part, Problem> {
    let given = |name: &str| arguments.number(name).is_some();
    let (sheet, solid) = (given("thickness"), given("fraction"));
    if sheet == solid {
        let (at, problem) = if sheet {
            ("fraction", format!("`{key}` has both `thickness` and `fraction`"))
        } else {
            (key, format!("`{key}` has neither `thickness` nor `fraction`"))
        };
        return Err(wrong(at, problem).help(
            "exactly one of `thickness`, for a sheet in units, and `fraction`, for a solid that fills so much of space",
        ));
    }
    Ok(if sheet {
        Part::Sheet(build.number_of(arguments, "thickness")?)
    } else {
        Part::Solid(build.number_of(arguments, "fraction")?)
    })
}

/// The surface of cells of an edge, and its greatest value: half of a sheet's thickness.
fn sized(graph: &mut Graph, terms: &[Term], edge: f64, part: Part) -> (Node, f64) {
    let wave = std::f64::consts::TAU / edge;
    let (mut values, mean) = counted(terms);
    let scale = 1.0 / (wave * mean);
    // Bounds of |∇g| and of how fast that changes, in waves.
    let derived = |by: &[usize]| terms.iter().map(|term| term.bound(by)).sum::<f64>();
    let first = length((0..3).map(|i| derived(&[i])));
    let second = length((0..9).map(|i| derived(&[i / 3, i % 3])));
    let angles = glam::DVec3::AXES.map(|axis| graph.affine(axis * wave, 0.0));
    let value = sum(graph, terms, angles, None);
    let (node, steepest, depth) = match part {
        Part::Sheet(thickness) => {
            let half = thickness / 2.0 * wave;
            let by = [0, 1, 2].map(|axis| sum(graph, terms, angles, Some(axis)));
            let slope = graph.length(&by);
            let (slope, from) = (graph.linear(slope, half * scale, 0.0), graph.abs(value));
            let from = graph.linear(from, scale, 0.0);
            (graph.sub(slope, from), first + half * second, thickness / 2.0)
        }
        Part::Solid(fraction) => {
            let at = ((fraction * values.len() as f64) as usize).min(values.len() - 1);
            let (below, level, _) = values.select_nth_unstable_by(at, f64::total_cmp);
            let least = below.iter().fold(*level, |least, value| least.min(*value));
            (graph.linear(value, -scale, scale * *level), first, scale * (*level - least))
        }
    };
    (graph.sloped(node, Slope::Lipschitz(scale * wave * steepest * (1.0 + 1e-9)), None), depth)
}

/// The length of a vector, the same bits on every machine.
fn length(components: impl Iterator<Item = f64>) -> f64 {
    components.map(|component| component * component).sum::<f64>().sqrt()
}

/// The sines at the angles of the grid: of so many halves of a step.
struct Grid([f64; 2 * GRID]);

impl Grid {
    fn new() -> Self {
        Self(std::array::from_fn(|i| libm::sin(i as f64 / (2 * GRID) as f64 * std::f64::consts::TAU)))
    }

    fn sin(&self, turn: usize) -> f64 {
        self.0[turn % (2 * GRID)]
    }

    fn cos(&self, turn: usize) -> f64 {
        self.sin(turn + GRID / 2)
    }
}

/// g at points all over a cell, and the mean of |∇g|.
fn counted(terms: &[Term]) -> (Vec<f64>, f64) {
    let grid = Grid::new();
    let mut values = Vec::with_capacity(GRID * GRID * GRID);
    let mut slopes = 0.0;
    for i in 0..GRID * GRID * GRID {
        let point = [i / (GRID * GRID), i / GRID % GRID, i % GRID];
        let all = |by: Option<usize>| terms.iter().map(|term| term.at(&grid, point, by)).sum::<f64>();
        values.push(all(None));
        slopes += length([0, 1, 2].into_iter().map(|axis| all(Some(axis))));
    }
    let mean = slopes / values.len() as f64;
    (values, mean)
}
