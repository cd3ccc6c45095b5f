//! Diffusion distances of shapes of the plane. On a closed curve of length L the eigenfunctions are the cosines and sines of
//! 2πk·s/L by arc length s, with (2πk/L)² as eigenvalues: nothing is to be solved.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, IVec3};

use super::spectrum::LEAST;
use super::{Boundary, DiffusionError, Grid};
use crate::field::{Aabb, Field};

/// Corners aimed at: more cost time, fewer cut more off where the outline is bent.
const CORNERS: f64 = 800.0;
/// Cells along the longer side that are tried first, and at least and most.
const FIRST: f64 = 64.0;
const CELLS: [f64; 2] = [48.0, 256.0];

/// The boundary of a shape of the plane.
pub struct Outline {
    /// Counter-clockwise around the inside, the last one before the first.
    corners: Vec<DVec2>,
    /// φₖ·exp(−λₖt) of each corner, cosine and sine in turn.
    numbers: Vec<f64>,
    modes: usize,
}

/// A lattice over a shape of the plane: one layer, as fine as its outline asks for.
pub fn fitting(solid: &dyn Field, aabb: Aabb) -> Grid {
    let aabb = Aabb::new(aabb.min.with_z(0.0), aabb.max.with_z(0.0));
    let of = |cells: f64| Grid::new(solid, aabb, aabb.size().max_element() / cells, true);
    let first = of(FIRST);
    let crossed = (0..first.nodes()).map(|node| first.crossed_from(node).count()).sum::<usize>().max(1) as f64;
    of((FIRST * CORNERS / crossed).clamp(CELLS[0], CELLS[1]))
}

impl Outline {
    /// The outline of F = 0, t = `time`/λ₁.
    ///
    /// # Errors
    /// An outline in several pieces, or none.
    pub fn new(grid: &Grid, solid: &dyn Field, time: f64) -> Result<Self, DiffusionError> {
        let loops = loops(grid, solid);
        let corners = match &loops[..] {
            [] => return Err(DiffusionError::Surface("nothing of it is as large as a cell".into())),
            [one] => one.clone(),
            [one, other, ..] => return Err(DiffusionError::Pieces([one[0].extend(0.0), other[0].extend(0.0)])),
        };
        let count = corners.len();
        let mut along = 0.0;
        let places: Vec<f64> = (0..count)
            .map(|i| {
                let place = along;
                along += corners[i].distance(corners[(i + 1) % count]);
                place
            })
            .collect();
        // λₖ/λ₁ = k².
        let kept = |k: &usize| libm::exp(-((k * k) as f64) * time);
        let shares: Vec<f64> = (1..).take_while(|k| *k == 1 || kept(k) >= LEAST).map(|k| kept(&k)).collect();
        let of_place = |place: &f64| {
            let angle = TAU * place / along;
            let of = |(k, share): (usize, &f64)| {
                let (sin, cos) = libm::sincos((k + 1) as f64 * angle);
                [cos * share, sin * share]
            };
            shares.iter().enumerate().flat_map(of).collect::<Vec<f64>>()
        };
        let numbers = places.iter().flat_map(of_place).collect();
        Ok(Self { corners, numbers, modes: 2 * shares.len() })
    }

    fn next(&self, corner: usize) -> usize {
        if corner + 1 == self.corners.len() { 0 } else { corner + 1 }
    }
}

impl Boundary for Outline {
    fn numbers(&self) -> Box<dyn Iterator<Item = &[f64]> + '_> {
        Box::new(self.numbers.chunks_exact(self.modes))
    }

    fn closest(&self, position: DVec3, out: &mut Vec<f64>) -> f64 {
        let position = position.truncate();
        let foot = |corner: usize| {
            let (from, to) = (self.corners[corner], self.corners[self.next(corner)]);
            let way = to - from;
            let share = ((position - from).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (position.distance_squared(from + way * share), corner, share)
        };
        let nearest = (0..self.corners.len()).map(foot).min_by(|a, b| a.0.total_cmp(&b.0));
        let (square, corner, share) = nearest.expect("an outline has corners");
        let [from, to] = [corner, self.next(corner)].map(|corner| &self.numbers[corner * self.modes..][..self.modes]);
        out.clear();
        out.extend(from.iter().zip(to).map(|(a, b)| a + (b - a) * share));
        square.sqrt()
    }

    /// Mean-value coordinates (Hormann and Floater, Mean value coordinates for arbitrary planar polygons, 2006): corner i counts
    /// (tan αᵢ₋₁/2 + tan αᵢ/2)/rᵢ, α the angles between the ways to neighbouring corners, with their sign.
    fn mixed(&self, position: DVec3, _: &mut Vec<f64>, out: &mut Vec<f64>) {
        let position = position.truncate();
        let half_tangent = |from: DVec2, to: DVec2| {
            let (dot, cross) = (from.dot(to), from.perp_dot(to));
            // Of a way straight back, which is on the outline, it is as large as can be.
            cross / (from.length() * to.length() + dot).max(f64::MIN_POSITIVE)
        };
        let count = self.corners.len();
        let way = |corner: usize| self.corners[corner] - position;
        let mut before = half_tangent(way(count - 1), way(0));
        let mut sum = 0.0;
        out.clear();
        out.resize(self.modes, 0.0);
        for corner in 0..count {
            let after = half_tangent(way(corner), way(self.next(corner)));
            let weight = (before + after) / way(corner).length();
            before = after;
            sum += weight;
            let numbers = &self.numbers[corner * self.modes..][..self.modes];
            out.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += weight * number);
        }
        out.iter_mut().for_each(|number| *number /= sum);
    }
}

/// The closed curves of F = 0, by the squares of a lattice: a corner where an edge crosses it.
fn loops(grid: &Grid, solid: &dyn Field) -> Vec<Vec<DVec2>> {
    let crossings: Vec<[usize; 2]> =
        (0..grid.nodes()).flat_map(|node| grid.crossed_from(node).map(move |to| [node, to])).collect();
    let place_of: rustc_hash::FxHashMap<[usize; 2], usize> =
        crossings.iter().enumerate().map(|(place, edge)| (*edge, place)).collect();
    let mut next = vec![usize::MAX; crossings.len()];
    for node in 0..grid.nodes() {
        let Some(square) = grid.square(node) else { continue };
        let edge = |i: usize| {
            let (from, to) = (square[i], square[(i + 1) % 4]);
            place_of.get(&[from.min(to), from.max(to)]).copied()
        };
        let is_inside = |i: usize| grid.is_inside(square[i % 4]);
        let middle = || {
            let sum: DVec3 = square.iter().map(|node| grid.position(*node)).sum();
            solid.reference(sum / 4.0) >= 0.0
        };
        let crossed = (0..4).filter(|i| edge(*i).is_some()).count();
        let join = crossed == 4 && middle();
        for i in 0..4 {
            // With the inside to its left the outline comes into the square between a corner inside and the next one outside.
            let Some(from) = edge(i).filter(|_| is_inside(i) && !is_inside(i + 1)) else { continue };
            // Where two corners inside are joined it goes around the corner outside, else around the one inside.
            let others = if join { [1, 2, 3] } else { [3, 2, 1] };
            let to = others.into_iter().filter_map(|by| edge((i + by) % 4)).next();
            next[from] = to.expect("an outline that comes in goes out");
        }
    }
    let corner = |edge: &[usize; 2]| root(solid, edge.map(|node| grid.position(node))).truncate();
    let corners: Vec<DVec2> = crossings.iter().map(corner).collect();
    let mut is_done = vec![false; crossings.len()];
    let mut loops = Vec::new();
    for start in 0..crossings.len() {
        let mut one = Vec::new();
        let mut at = start;
        while at != usize::MAX && !is_done[at] {
            is_done[at] = true;
            one.push(corners[at]);
            at = next[at];
        }
        // Corners of one place have no way between them.
        one.dedup();
        if one.len() > 2 {
            loops.push(one);
        }
    }
    loops
}

/// Where F vanishes between two places of different sides.
fn root(solid: &dyn Field, ends: [DVec3; 2]) -> DVec3 {
    const HALVINGS: usize = 24;
    let [mut inside, mut outside] = ends;
    if solid.reference(inside) < 0.0 {
        std::mem::swap(&mut inside, &mut outside);
    }
    for _ in 0..HALVINGS {
        let middle = (inside + outside) / 2.0;
        *(if solid.reference(middle) >= 0.0 { &mut inside } else { &mut outside }) = middle;
    }
    (inside + outside) / 2.0
}

impl Grid {
    /// The nodes to which an edge of the plane from this one crosses the outline.
    fn crossed_from(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        let place = self.place(node);
        let ends = [IVec3::X, IVec3::Y].map(|by| place + by).into_iter().filter(|end| end.cmplt(self.size).all());
        ends.map(|end| self.node(end)).filter(move |end| self.is_inside(node) != self.is_inside(*end))
    }

    /// The corners of the square that begins at a node, counter-clockwise.
    fn square(&self, node: usize) -> Option<[usize; 4]> {
        let place = self.place(node);
        let corners = [IVec3::ZERO, IVec3::X, IVec3::X + IVec3::Y, IVec3::Y].map(|by| place + by);
        corners[2].cmplt(self.size).all().then(|| corners.map(|corner| self.node(corner)))
    }
}
