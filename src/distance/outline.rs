//! Closest points in the plane on the zero set of a field that does not know z: the outline is found as short straight pieces,
//! the nearest of these is sought, and what is found is projected to the outline by one step of Newton's.
//!
//! Cells of a lattice are opened by interval bounds, so that no piece of the outline between them is stepped over, and where the
//! sign of F changes from corner to corner its root along the edge is found. Where the outline turns within a cell, the corner is
//! where its tangents meet, if F vanishes there; else the cell is split.
//!
//! **Guaranteed:** the side is that of F. **Within tolerance:** the distance, to a hundredth of a lattice cell. **Not guaranteed:**
//! what is thinner than a cell may be missed; corners that are not found are cut where they are a 32nd of a cell wide.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Foot;
use super::nearest::{ClosestPoint, Watch};
use super::octree::BuildError;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Joined, Points, Strut, Struts};

/// How often a cell is halved beyond the lattice where the outline is not simple in it.
const HALVINGS: u32 = 5;

/// Steps towards a root on an edge. Fewer leave places off the outline where F bends much; more gain nothing in 32 bits.
const ROOT_STEPS: usize = 12;

/// The cosine of the angle that the outline turns within a cell before its corner is sought: more, and smooth arcs are taken for
/// corners; less, and a chord misses its arc by more than Newton's step corrects.
const SMOOTH: f64 = 0.985;

/// How far from the outline, in lattice cells, a corner may be where tangents meet.
const AT_CORNER: f64 = 0.005;

/// How far beyond a last cell a corner may be, in its edges: points of 14° and more are found to their end.
const PAST_LAST: f64 = 5.0;

/// How far, in lattice cells, Newton's step may go: beyond, F tells nothing of the way.
const STEP: f64 = 0.1;

/// Nearer to the outline, in lattice cells, a point takes the gradient of F for its direction.
const TOO_NEAR: f64 = 1e-3;

/// A value of F that is a smaller share of the distance than this is 0 for rounding: operands meet there, and the side is
/// settled beside it.
const IS_ZERO: f64 = 1e-4;

/// Cells along the longest side of a region, at most: pieces miss by the square of a cell.
const FINEST: f64 = 2048.0;

/// An outline in short straight pieces.
#[derive(Clone)]
pub struct Pieces {
    pieces: Arc<Joined<Struts>>,
    /// The edge of a lattice cell.
    cell: f64,
}

/// Closest points on an outline.
pub struct OutlineFeet<'a> {
    field: &'a dyn Field,
    pieces: Arc<Joined<Struts>>,
    /// The edge of a lattice cell.
    cell: f64,
}

/// A square by its least corner and edge, and how often it was halved beyond the lattice.
#[derive(Clone, Copy)]
struct Cell {
    at: DVec2,
    edge: f64,
    halved: u32,
}

impl Cell {
    fn corners(&self) -> [DVec2; 4] {
        [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|corner| self.at + corner * self.edge)
    }

    fn middle(&self) -> DVec2 {
        self.at + 0.5 * self.edge
    }

    fn children(&self, halved: u32) -> [Self; 4] {
        let edge = 0.5 * self.edge;
        [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|corner| Self { at: self.at + corner * edge, edge, halved })
    }
}

/// Two places with values of either sign, between which the outline is crossed.
#[derive(Clone, Copy)]
struct Crossing {
    ends: [DVec2; 2],
    values: [f64; 2],
    /// Which of them was replaced last.
    last: usize,
}

/// A piece of outline in a cell, from crossing to crossing.
struct Passage {
    cell: Cell,
    ends: [DVec2; 2],
    /// Where the tangents at both meet, where the outline turns.
    corner: Option<DVec2>,
}

impl<'a> OutlineFeet<'a> {
    /// Finds the outline in a region, whose z is of no account, on a lattice of cells of an edge, of which no more than 2,048
    /// go along its longest side.
    ///
    /// # Errors
    /// [`BuildError::NoSurface`] where there is none, [`BuildError::Cancelled`].
    pub fn new(field: &'a dyn Field, region: &Aabb, cell: f64, watch: &Watch<'_>) -> Result<Self, BuildError> {
        let mut work = Work { evaluator: field.evaluator(), at: Gradients::new(), values: [0.0; BATCH] };
        let longest = region.size().truncate().max_element();
        let cell = cell.max(longest / FINEST);
        let size = (longest / cell).ceil() + 4.0;
        let edge = cell * f64::from((size as u32).next_power_of_two());
        // Off all round numbers, which edges of shapes have: there F is 0, and its sign is rounding.
        let at = region.centre().truncate() - 0.5 * edge + cell * DVec2::new(0.123_4, 0.271_8);
        let mut open = Vec::new();
        work.descend(Cell { at, edge, halved: 0 }, cell, &mut open);
        let mut pieces = Vec::new();
        while !open.is_empty() {
            if watch.cancelled() {
                return Err(BuildError::Cancelled);
            }
            open = work.pass(&open, cell, &mut pieces);
        }
        if pieces.is_empty() {
            return Err(BuildError::NoSurface);
        }
        let strut = |[from, to]: [DVec2; 2]| Strut::new(from.extend(0.0), to.extend(0.0), [0.0; 2]);
        let pieces = Joined::new(Struts::new(pieces.into_iter().map(strut).collect()).flattened());
        Ok(Self { field, pieces: Arc::new(pieces), cell })
    }

    /// On an outline of the same field that was found before.
    pub fn of(field: &'a dyn Field, Pieces { pieces, cell }: &Pieces) -> Self {
        Self { field, pieces: Arc::clone(pieces), cell: *cell }
    }

    /// What was found.
    pub fn into_pieces(self) -> Pieces {
        Pieces { pieces: self.pieces, cell: self.cell }
    }
}

struct Work<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    at: Gradients,
    values: [f32; BATCH],
}

impl Work<'_> {
    /// The cells of the lattice that the outline may pass through.
    fn descend(&mut self, cell: Cell, least: f64, found: &mut Vec<Cell>) {
        let [from, _, to, _] = cell.corners();
        self.evaluator.enter(&Aabb::new(from.extend(0.0), to.extend(0.0)));
        let bounds = self.evaluator.bounds();
        if bounds.lo <= 0.0 && bounds.hi >= 0.0 {
            if cell.edge < 1.5 * least {
                found.push(cell);
            } else {
                cell.children(0).into_iter().for_each(|child| self.descend(child, least, found));
            }
        }
        self.evaluator.leave();
    }

    fn values(&mut self, positions: &[DVec2]) -> Vec<f64> {
        let mut all = Vec::with_capacity(positions.len());
        for chunk in positions.chunks(BATCH) {
            self.evaluator.values(&in_space(chunk), &mut self.values);
            all.extend(self.values[..chunk.len()].iter().map(|value| f64::from(*value)));
        }
        all
    }

    fn gradients(&mut self, positions: &[DVec2]) -> Vec<(f64, DVec2)> {
        let mut all = Vec::with_capacity(positions.len());
        for chunk in positions.chunks(BATCH) {
            self.evaluator.gradients(&in_space(chunk), &mut self.at);
            let of = |i: usize| (f64::from(self.at.value[i]), self.at.gradient(i).as_dvec3().truncate());
            all.extend((0..chunk.len()).map(of));
        }
        all
    }

    /// Adds the pieces of outline in cells where it is simple, and returns parts of the others.
    fn pass(&mut self, cells: &[Cell], lattice: f64, pieces: &mut Vec<[DVec2; 2]>) -> Vec<Cell> {
        let corners: Vec<DVec2> = cells.iter().flat_map(Cell::corners).collect();
        let middles: Vec<DVec2> = cells.iter().map(Cell::middle).collect();
        let (values, centres) = (self.values(&corners), self.gradients(&middles));
        let mut split = Vec::new();
        let (mut passing, mut crossings) = (Vec::new(), Vec::new());
        for ((cell, values), (value, slope)) in cells.iter().zip(values.chunks_exact(4)).zip(centres) {
            let (places, may_split) = (cell.corners(), cell.halved < HALVINGS);
            let crossed: Vec<Crossing> = (0..4)
                .map(|side| [side, (side + 1) % 4])
                .filter(|[a, b]| (values[*a] >= 0.0) != (values[*b] >= 0.0))
                .map(|[a, b]| Crossing { ends: [places[a], places[b]], values: [values[a], values[b]], last: 2 })
                .collect();
            match crossed[..] {
                // To first order the outline comes no nearer than its corners.
                [] if value.abs() > 0.75 * cell.edge * slope.length() => {}
                _ if crossed.len() != 2 && may_split => split.extend(cell.children(cell.halved + 1)),
                // Of two ways to join four crossings either is as good, so near to one another.
                _ => {
                    passing.extend(crossed.chunks_exact(2).map(|_| *cell));
                    crossings.extend(crossed);
                }
            }
        }
        let ends = self.roots(&crossings);
        let slopes = self.gradients(&ends);
        let passages: Vec<Passage> = passing
            .into_iter()
            .zip(ends.chunks_exact(2).zip(slopes.chunks_exact(2)))
            .map(|(cell, (ends, slopes))| {
                let ends = [ends[0], ends[1]];
                Passage { cell, ends, corner: meet(ends, [slopes[0].1, slopes[1].1]) }
            })
            .collect();
        let turns: Vec<DVec2> = passages.iter().map(|passage| passage.corner.unwrap_or(passage.ends[0])).collect();
        let steepest = slopes.chunks_exact(2).map(|two| two[0].1.length().max(two[1].1.length()));
        for ((Passage { cell, ends: [from, to], corner }, at_corner), slope) in
            passages.iter().zip(self.values(&turns)).zip(steepest)
        {
            let is_corner = |corner: &DVec2| {
                // Past the last cell, too: the sides of a point are nearer to one another than its end is.
                let reach = if cell.halved < HALVINGS { 0.55 } else { PAST_LAST };
                let inside = (*corner - cell.middle()).abs().max_element() <= reach * cell.edge;
                inside && at_corner.abs() <= AT_CORNER * lattice * slope
            };
            match corner {
                Some(corner) if is_corner(corner) => pieces.extend([[*from, *corner], [*corner, *to]]),
                Some(_) if cell.halved < HALVINGS => split.extend(cell.children(cell.halved + 1)),
                _ => pieces.push([*from, *to]),
            }
        }
        split
    }

    /// Where the sign changes between the ends of crossings, by false position, the Illinois way.
    fn roots(&mut self, crossings: &[Crossing]) -> Vec<DVec2> {
        let mut open = crossings.to_vec();
        let guess = |crossing: &Crossing| {
            let Crossing { ends: [a, b], values: [f, g], .. } = *crossing;
            let share = f / (f - g);
            // Where a value is no number or infinite the middle is as good as any.
            a + (b - a) * if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }
        };
        for _ in 0..ROOT_STEPS {
            let places: Vec<DVec2> = open.iter().map(guess).collect();
            for ((crossing, place), value) in open.iter_mut().zip(&places).zip(self.values(&places)) {
                let side = usize::from((crossing.values[0] >= 0.0) != (value >= 0.0));
                (crossing.ends[side], crossing.values[side]) = (*place, value);
                if side == crossing.last {
                    crossing.values[1 - side] *= 0.5;
                }
                crossing.last = side;
            }
        }
        open.iter().map(guess).collect()
    }
}

/// Where the tangents at two places of the outline meet, where it turns between them.
fn meet([from, to]: [DVec2; 2], slopes: [DVec2; 2]) -> Option<DVec2> {
    let [a, b] = slopes.map(|slope| slope.normalize_or_zero());
    if a.dot(b) > SMOOTH {
        return None;
    }
    // a·(x − from) = 0 and b·(x − to) = 0. Parallel ones meet nowhere, which no cell holds.
    let across = a.perp_dot(b);
    let (on_a, on_b) = (a.dot(from), b.dot(to));
    Some(DVec2::new(on_a * b.y - on_b * a.y, on_b * a.x - on_a * b.x) / across)
}

fn in_space(positions: &[DVec2]) -> Points {
    let mut points = Points::new(positions[0].extend(0.0));
    positions.iter().for_each(|position| points.push((*position - positions[0]).extend(0.0).as_vec3()));
    points
}

impl ClosestPoint for OutlineFeet<'_> {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        let mut work = Work { evaluator: self.field.evaluator(), at: Gradients::new(), values: [0.0; BATCH] };
        let positions: Vec<DVec2> = positions.iter().map(|position| position.truncate()).collect();
        let own = work.gradients(&positions);
        let mut nearest = Work { evaluator: self.pieces.evaluator(), at: Gradients::new(), values: [0.0; BATCH] };
        let to_piece = |(at, (value, slope)): (&DVec2, (f64, DVec2))| *at - slope * value;
        let on_pieces: Vec<DVec2> = positions.iter().zip(nearest.gradients(&positions)).map(to_piece).collect();
        let there = work.gradients(&on_pieces);
        for (i, foot) in feet.iter_mut().enumerate() {
            let (at, (value, slope)) = (positions[i], own[i]);
            let (on_outline, steep) = there[i];
            let step = steep * (on_outline / steep.length_squared());
            let is_step = step.is_finite() && step.length() <= STEP * self.cell;
            let point = if is_step { on_pieces[i] - step } else { on_pieces[i] };
            let away = at - point;
            let length = away.length();
            let is_inside = if value.abs() < IS_ZERO * length && length > STEP * self.cell {
                self.is_inside_beside(&mut work, at)
            } else {
                value >= 0.0
            };
            let sign = if is_inside { 1.0 } else { -1.0 };
            let own = slope.normalize_or_zero();
            let direction = if length > TOO_NEAR * self.cell || own == DVec2::ZERO { away * sign } else { own };
            *foot = Foot {
                point: point.extend(0.0),
                distance: if value.is_nan() { f64::NAN } else { sign * length },
                gradient: direction.normalize_or(DVec2::X).extend(0.0),
                part: 0,
            };
        }
    }
}

impl OutlineFeet<'_> {
    /// The side of a point that is far from the outline though F is 0 there, by points around it.
    fn is_inside_beside(&self, work: &mut Work<'_>, at: DVec2) -> bool {
        let aside = 0.5 * STEP * self.cell;
        let around = [[1.0, 0.6], [-0.6, 1.0], [-1.0, -0.6], [0.6, -1.0]].map(|way| at + DVec2::from(way) * aside);
        work.values(&around).iter().filter(|value| **value >= 0.0).count() >= 2
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::field::{Expression, Graph, Node, SetSystem};

    fn watch(cancel: &AtomicBool) -> Watch<'_> {
        Watch { cancel, progress: &|_| {} }
    }

    /// The feet of places in a square of half the edge `reach`, on a lattice of 41 by 41, those on the axes among them.
    fn feet(field: &Expression, reach: f64, cell: f64) -> Vec<(DVec2, Foot)> {
        let cancel = AtomicBool::new(false);
        let region = Aabb::new(DVec3::splat(-reach), DVec3::splat(reach));
        let outline = OutlineFeet::new(field, &region, cell, &watch(&cancel)).expect("an outline");
        let at = |i: i32| DVec3::new(f64::from(i % 41 - 20), f64::from(i / 41 - 20), 0.0) * reach / 20.0;
        let places: Vec<DVec3> = (0..41 * 41).map(at).collect();
        let mut feet = vec![Foot { point: DVec3::ZERO, distance: 0.0, gradient: DVec3::ZERO, part: 0 }; places.len()];
        outline.feet(&places, &mut feet);
        places.iter().map(|place| place.truncate()).zip(feet).collect()
    }

    fn convex(graph: &mut Graph, sides: &[(DVec2, f64)]) -> Node {
        let sides: Vec<Node> =
            sides.iter().map(|(normal, offset)| graph.half_space(normal.extend(0.0), *offset)).collect();
        graph.intersection(SetSystem::R0, &sides)
    }

    /// Two rectangles that share an edge, on which F is 0 and inside on both sides: it is not outline, and is inside.
    #[test]
    fn what_operands_share_is_not_outline() {
        let mut graph = Graph::new();
        let halves = [-1.0, 1.0].map(|way| {
            let sides = [(DVec2::X * way, 0.9), (DVec2::X * -way, 0.0), (DVec2::Y, 0.3), (DVec2::NEG_Y, 0.3)];
            convex(&mut graph, &sides)
        });
        let node = graph.union(SetSystem::R0, &halves);
        for (p, foot) in feet(&Expression::new(&graph, node), 1.2, 0.02) {
            let beyond = p.abs() - DVec2::new(0.9, 0.3);
            let truth = -(beyond.max(DVec2::ZERO).length() + beyond.max_element().min(0.0));
            assert!((foot.distance - truth).abs() < 2e-4, "{p}: {} for {truth}", foot.distance);
            assert!((foot.gradient.length() - 1.0).abs() < 1e-9 && foot.gradient.z == 0.0);
        }
    }

    /// A point of 14°, much thinner than a cell at its end, and the point of a notch.
    #[test]
    fn points_are_found_to_their_ends() {
        let mut graph = Graph::new();
        let slant = DVec2::new(0.125, 1.0);
        let offset = 0.1 / slant.length();
        let (up, down) = (slant.normalize(), DVec2::new(slant.x, -slant.y).normalize());
        let sides = [(up, offset), (down, offset), (DVec2::NEG_X, 0.8)];
        let spike = convex(&mut graph, &sides);
        let all = graph.constant(1.0);
        let notch = graph.difference(SetSystem::R0, all, &[spike]);
        let corners = [DVec2::new(0.8, 0.0), DVec2::new(-0.8, 0.2), DVec2::new(-0.8, -0.2)];
        let exact = |p: DVec2| {
            let edge = |i: usize| {
                let (from, way) = (corners[i], corners[(i + 1) % 3] - corners[i]);
                p.distance(from + way * ((p - from).dot(way) / way.length_squared()).clamp(0.0, 1.0))
            };
            let inside = sides.iter().all(|(normal, offset)| normal.dot(p) <= *offset);
            edge(0).min(edge(1)).min(edge(2)) * if inside { 1.0 } else { -1.0 }
        };
        for (node, sign) in [(spike, 1.0), (notch, -1.0)] {
            for (p, foot) in feet(&Expression::new(&graph, node), 1.0, 0.03) {
                let truth = sign * exact(p);
                assert!((foot.distance - truth).abs() < 3e-4, "{p}: {} for {truth}", foot.distance);
            }
        }
    }

    #[test]
    fn nothing_and_cancelling_are_told() {
        let mut graph = Graph::new();
        let node = graph.constant(-1.0);
        let field = Expression::new(&graph, node);
        let cancel = AtomicBool::new(false);
        let region = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
        let new = |field: &Expression| OutlineFeet::new(field, &region, 0.1, &watch(&cancel)).err();
        assert_eq!(new(&field), Some(BuildError::NoSurface));
        let line = graph.half_space(DVec3::X, 0.0);
        let line = Expression::new(&graph, line);
        assert_eq!(new(&line), None);
        cancel.store(true, std::sync::atomic::Ordering::Relaxed);
        assert_eq!(new(&line), Some(BuildError::Cancelled));
    }
}
