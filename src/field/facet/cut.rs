//! What is cut in each cell.

use glam::{DVec3, Vec3};

use super::super::cells::{CellId, Cells, Place, Purpose, Random};
use super::super::{Aabb, Evaluator, Gradients, Points};
use super::Options;

/// Samples along an edge of a cell: 8³ fill one batch.
const SAMPLES: usize = 8;
/// How much neighbouring pieces overlap, of a cell's edge. It only has to outlast rounding; a larger overlap moves
/// steps away from the borders of cells, where colours change.
pub(super) const OVERLAP: f64 = 1.0 / 512.0;
/// The cosine up to which directions of the surface in a cell count as one face of it: 45°.
const SAME_FACE: f64 = 0.7;
/// A face with fewer of a cell's samples is only brushed by the cell, and not cut.
const FEWEST_SAMPLES: usize = 6;

/// A half-space `normal · p ≤ offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Unit, outward.
    pub normal: DVec3,
    pub offset: f64,
}

/// The piece of the shape in one cell: the shape grown by `lift`, within `bounds` and all half-spaces.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub cell: CellId,
    pub bounds: Aabb,
    /// In units of the shape's value.
    pub lift: f64,
    pub planes: Vec<Plane>,
    /// The value of the shape beyond which nothing is cut.
    pub depth: f64,
}

impl Piece {
    /// The piece's value at a position where the shape has some value.
    pub fn value(&self, position: DVec3, shape: f64) -> f64 {
        let walls = (position - self.bounds.min).min(self.bounds.max - position).min_element();
        let cut = |least: f64, plane: &Plane| least.min(plane.offset - plane.normal.dot(position));
        self.planes.iter().fold((shape + self.lift).min(walls), cut)
    }

    /// The cell's piece of the shape as it is.
    pub fn whole(cells: &Cells, cell: CellId) -> Self {
        let bounds = cells.cell(cell).bounds;
        Self { cell, bounds: bounds.grown(bounds.size().x * OVERLAP), lift: 0.0, planes: vec![], depth: 0.0 }
    }
}

/// What the part of the shape in a cell rests on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    /// How deep below the surface the shape gets in the cell.
    pub depth: f64,
    /// A place under the deepest one, half a cell further in.
    pub below: DVec3,
}

/// The values and gradients of the shape over a cell.
struct Samples {
    points: Points,
    out: Gradients,
}

impl Samples {
    fn of(evaluator: &mut dyn Evaluator, bounds: Aabb) -> Self {
        let mut points = Points::new(bounds.centre());
        let along = |i: usize| i as f64 / (SAMPLES - 1) as f64 - 0.5;
        for i in 0..SAMPLES.pow(3) {
            let at = [i / (SAMPLES * SAMPLES), i / SAMPLES % SAMPLES, i % SAMPLES].map(along);
            points.push((DVec3::from(at) * bounds.size()).as_vec3());
        }
        let mut out = Gradients::new();
        evaluator.enter(&bounds.grown(bounds.size().x * OVERLAP));
        evaluator.gradients(&points, &mut out);
        evaluator.leave();
        Self { points, out }
    }

    /// Value and gradient where there is a gradient.
    fn iter(&self) -> impl Iterator<Item = (DVec3, f64, DVec3)> {
        let one = |i| (self.points.position(i), f64::from(self.out.value[i]), self.out.gradient(i).as_dvec3());
        (0..self.points.len).map(one).filter(|(_, value, slope)| value.is_finite() && slope.length() > 1e-12)
    }

    fn support(&self, edge: f64, steepness: f64) -> Support {
        let mut deepest = (f64::NEG_INFINITY, self.points.origin);
        for (position, value, slope) in self.iter() {
            if value > deepest.0 {
                // From outside, the way to the surface comes first.
                let way = edge * 0.5 + (-value / slope.length()).max(0.0);
                deepest = (value, position + slope.normalize() * way);
            }
        }
        Support { depth: deepest.0.max(0.0) / steepness, below: deepest.1 }
    }

    /// Whether what is within `lift` of the surface stands on another cell's part of it, and would float.
    fn overhang(&self, bounds: Aabb, lift: f64) -> bool {
        let own = bounds.grown(0.02 * bounds.size().x);
        let foot = |position: DVec3, value: f64, slope: DVec3| position - slope * (value / slope.length_squared());
        self.iter().any(|(p, value, slope)| (-lift..0.0).contains(&value) && !own.contains(foot(p, value, slope)))
    }

    /// The outward directions of the surface's faces in the cell, at most three, the largest first; and the steepness
    /// of the value there.
    fn faces(&self, bounds: Aabb) -> (Vec<DVec3>, f64) {
        let spacing = bounds.size().x / (SAMPLES - 1) as f64;
        let mut faces: Vec<(DVec3, usize)> = Vec::new();
        let (mut steepness, mut count) = (0.0, 0.0);
        let own = bounds.grown(0.05 * spacing);
        for (position, value, slope) in self.iter() {
            let distance = value / slope.length();
            // Right on the surface a sample may stand on an edge, where the direction is anyone's guess.
            let near = (1e-6 * spacing..=1.2 * spacing).contains(&distance.abs());
            // A sample under another cell's part of the surface says nothing about this cell's own.
            if !near || !own.contains(position - slope * (value / slope.length_squared())) {
                continue;
            }
            steepness += slope.length();
            count += 1.0;
            let direction = -slope.normalize();
            match faces.iter_mut().find(|(sum, _)| sum.normalize().dot(direction) > SAME_FACE) {
                Some((sum, samples)) => {
                    *sum += direction;
                    *samples += 1;
                }
                None => faces.push((direction, 1)),
            }
        }
        faces.retain(|&(_, samples)| samples >= FEWEST_SAMPLES);
        faces.sort_by_key(|&(_, samples)| std::cmp::Reverse(samples));
        let directions = faces.into_iter().take(3).map(|(sum, _)| sum.normalize()).collect();
        (directions, if count > 0.0 { steepness / count } else { 1.0 })
    }
}

/// The piece of a cell on the surface, and what it rests on.
pub(super) fn piece(evaluator: &mut dyn Evaluator, cells: &Cells, cell: CellId, options: &Options) -> (Piece, Support) {
    let bounds = cells.cell(cell).bounds;
    let edge = bounds.size().x;
    let samples = Samples::of(evaluator, bounds);
    let (faces, steepness) = samples.faces(bounds);
    let support = samples.support(edge, steepness);
    let most = options.cut.min(edge * 0.5).min(support.depth * 0.5);
    let mut piece = Piece::whole(cells, cell);
    if faces.is_empty() || most <= 0.0 {
        return (piece, support);
    }
    let mut random = cells.random(cell, Purpose::Facet, options.seed);
    let lift = most * random.range(-0.5, 0.5).max(0.0);
    let lift = if samples.overhang(bounds, lift * steepness) { 0.0 } else { lift };
    piece.lift = lift * steepness;
    for face in faces {
        let depth = most * random.range(0.3, 1.0);
        let normal = tilted(face, options.tilt * random.range(0.4, 1.0), &mut random);
        // Everything deeper than the cut stays.
        let kept = samples.iter().filter(|(_, value, _)| *value >= depth * steepness);
        let offset = kept.map(|(position, ..)| normal.dot(position)).fold(f64::NEG_INFINITY, f64::max);
        if offset.is_finite() {
            piece.planes.push(Plane { normal, offset });
            piece.depth = piece.depth.max(depth * steepness);
        }
    }
    piece.bounds = opened(cells, piece.bounds, bounds, lift);
    (piece, support)
}

/// A direction turned by an angle in degrees about a random axis across it.
fn tilted(direction: DVec3, degrees: f64, random: &mut Random) -> DVec3 {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let across = direction.any_orthonormal_vector();
    let (turn_sin, turn_cos) = libm::sincos(random.range(0.0, std::f64::consts::TAU));
    let side = across * turn_cos + direction.cross(across) * turn_sin;
    (direction * cos + side * sin).normalize()
}

/// The walls of a piece moved out by `lift` on those sides of its cell where nothing of the shape follows.
fn opened(cells: &Cells, piece: Aabb, cell: Aabb, lift: f64) -> Aabb {
    let mut out = piece;
    for axis in 0..3 {
        if free(cells, cell, axis, false) {
            out.min[axis] -= lift;
        }
        if free(cells, cell, axis, true) {
            out.max[axis] += lift;
        }
    }
    out
}

/// Whether only cells outside of the shape, or none, adjoin a cell on one side.
fn free(cells: &Cells, cell: Aabb, axis: usize, above: bool) -> bool {
    // The finest cells are found too: as many probes along an edge as the deepest split can make cells, at most 16.
    const PROBES: usize = 16;
    let beyond =
        if above { cell.max[axis] + cell.size()[axis] * 1e-3 } else { cell.min[axis] - cell.size()[axis] * 1e-3 };
    let root = cells.root();
    if beyond < root.min[axis] || beyond > root.max[axis] {
        return true;
    }
    let outside = |i: usize| {
        let along = Vec3::new(0.5, (i / PROBES) as f32 + 0.5, (i % PROBES) as f32 + 0.5).as_dvec3() / PROBES as f64;
        let mut position = cell.min;
        position[(axis + 1) % 3] += along.y * cell.size()[(axis + 1) % 3];
        position[(axis + 2) % 3] += along.z * cell.size()[(axis + 2) % 3];
        position[axis] = beyond;
        cells.cell(cells.leaf_at(position)).place == Place::Outside
    };
    (0..PROBES * PROBES).all(outside)
}
