//! Diffusion distances inside a solid or a shape of the plane (HFRep, section 4.2: interior distance functions; Rustamov, Lipman and Funkhouser,
//! Interior distance using barycentric coordinates, 2009).
//!
//! Heat that starts at two places of the boundary spreads alike where many short ways along it join them. Each vertex of
//! the boundary gets the numbers p*ₖ = φₖ·exp(−λₖt) of the eigenfunctions of its Laplacian; inside they are mixed by
//! mean-value coordinates, outside they are those of the closest point. The distance of two places is that of their
//! numbers. It is smooth, knows no shortcuts through the air, and is 1 at the place of the boundary that is farthest from
//! the sources.
//!
//! **Guaranteed:** the same bits for any number of threads; between 0 and 1. **Not guaranteed:** more detail than the boundary
//! has on a lattice of some thousand cells; walls thinner than a cell may join there.

mod mean_value;
mod planar;
mod spectrum;
mod surface;

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use self::planar::Outline;
use self::spectrum::Spectrum;
use self::surface::{Grid, Surface};
use super::positional::{Positional, PositionalSampler};
use super::{Attribute, Sampler};
use crate::field::{Aabb, Field, Interval};
use crate::mesh::{Holes, MeshDistance, TriangleMesh};

/// Why there are no diffusion distances.
#[derive(Clone, Debug, PartialEq)]
pub enum DiffusionError {
    /// Set to stop.
    Cancelled,
    /// A source is not inside.
    Outside(DVec3),
    /// The boundary is of several closed pieces, each a space of its own; a place of one and of another.
    Pieces([DVec3; 2]),
    /// The boundary cannot be made of triangles there.
    Surface(String),
}

impl fmt::Display for DiffusionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |p: &DVec3| format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z);
        match self {
            Self::Cancelled => f.write_str("stopped"),
            Self::Outside(source) => write!(f, "the source {} of `diffusion` lies outside of the shape", place(source)),
            Self::Pieces([one, other]) => {
                write!(f, "`diffusion` needs a boundary in one piece: {} and {} are of two", place(one), place(other))
            }
            Self::Surface(problem) => write!(f, "`diffusion` finds no boundary: {problem}"),
        }
    }
}

impl std::error::Error for DiffusionError {}

/// What diffusion distances are found for.
pub struct Spreading<'a> {
    /// The solid, or the shape of the plane.
    pub solid: &'a dyn Field,
    /// Its box, that of a shape of the plane by [`Aabb::is_of_plane`].
    pub aabb: Aabb,
    /// Where it starts; of several, the least distance counts.
    pub sources: &'a [DVec3],
    /// t·λ₁: how long heat spreads, free of units. Smaller is sharper.
    pub time: f64,
    /// Set to stop.
    pub cancel: &'a AtomicBool,
}

/// Diffusion distances from some sources, on a lattice around the solid; beyond it those of the nearest place in it.
pub struct Diffusion {
    origin: DVec3,
    step: f64,
    size: IVec3,
    /// The square of the distance at each node, of which 1 is the greatest at the boundary: smooth at the source too.
    squares: Vec<f32>,
}

/// Nodes nearer to the boundary than this, in steps, have what the closest point has: mean-value coordinates are about to
/// divide by nothing there.
const AT_BOUNDARY: f64 = 0.02;

impl Diffusion {
    /// Finds the distances.
    ///
    /// # Errors
    /// A source outside, a boundary of several pieces, or none.
    pub fn new(spreading: &Spreading<'_>) -> Result<Self, DiffusionError> {
        let Spreading { solid, aabb, sources, time, cancel } = spreading;
        let is_inside = |source: &&DVec3| solid.reference(**source) >= 0.0;
        if let Some(source) = sources.iter().find(|source| !is_inside(source)) {
            return Err(DiffusionError::Outside(*source));
        }
        let stopped = || if cancel.load(Ordering::Relaxed) { Err(DiffusionError::Cancelled) } else { Ok(()) };
        stopped()?;
        // What knows no z has no end along it.
        let is_flat = aabb.is_of_plane();
        let (grid, boundary): (Grid, Box<dyn Boundary>) = if is_flat {
            let grid = planar::fitting(*solid, *aabb);
            let outline = Outline::new(&grid, *solid, *time)?;
            (grid, Box::new(outline))
        } else {
            let grid = Grid::fitting(*solid, *aabb);
            let shell = Shell::new(grid.surface(*solid), *time, cancel)?;
            (grid, Box::new(shell))
        };
        stopped()?;
        let of_place = |position: DVec3, is_inside: bool, weights: &mut Vec<f64>, out: &mut Vec<f64>| {
            let far = boundary.closest(position, out);
            if is_inside && far >= AT_BOUNDARY * grid.step {
                boundary.mixed(position, weights, out);
            }
        };
        let start = |source: &DVec3| {
            let source = if is_flat { source.with_z(0.0) } else { *source };
            let mut start = Vec::new();
            of_place(source, true, &mut Vec::new(), &mut start);
            start
        };
        let starts: Vec<Vec<f64>> = sources.iter().map(start).collect();
        let square = |numbers: &[f64]| {
            let to = |start: &Vec<f64>| start.iter().zip(numbers).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            starts.iter().map(to).fold(f64::INFINITY, f64::min)
        };
        let greatest = boundary.numbers().map(square).fold(f64::MIN_POSITIVE, f64::max);
        let of_node = |(weights, out): &mut (Vec<f64>, Vec<f64>), node: usize| {
            if cancel.load(Ordering::Relaxed) {
                return 0.0;
            }
            of_place(grid.position(node), grid.is_inside(node), weights, out);
            // In the inside of a ball or a bar the mean of what is around may be a little farther than any of it.
            (square(out) / greatest).min(1.0) as f32
        };
        let squares: Vec<f32> =
            (0..grid.nodes()).into_par_iter().map_init(<(Vec<f64>, Vec<f64>)>::default, of_node).collect();
        stopped()?;
        Ok(Self { origin: grid.origin, step: grid.step, size: grid.size, squares })
    }
}

/// A boundary, each vertex with its numbers φₖ·exp(−λₖt).
trait Boundary: Sync {
    /// Those of each vertex.
    fn numbers(&self) -> Box<dyn Iterator<Item = &[f64]> + '_>;

    /// Those of the closest point, and how far that is.
    fn closest(&self, position: DVec3, out: &mut Vec<f64>) -> f64;

    /// Those of a position inside, mixed by mean-value coordinates.
    fn mixed(&self, position: DVec3, weights: &mut Vec<f64>, out: &mut Vec<f64>);
}

/// The boundary of a solid.
struct Shell {
    closest: MeshDistance,
    spectrum: Spectrum,
    /// For each of the mesh's vertices, its place in the spectrum.
    order: Vec<u32>,
}

impl Shell {
    fn new(surface: Surface, time: f64, cancel: &AtomicBool) -> Result<Self, DiffusionError> {
        if let Some(pieces) = surface.two_pieces() {
            return Err(DiffusionError::Pieces(pieces));
        }
        let wrong = |problem: String| DiffusionError::Surface(problem);
        let mesh = TriangleMesh::new(surface.positions.clone(), surface.triangles.clone(), None)
            .map_err(|problem| wrong(problem.to_string()))?;
        let closest = MeshDistance::new(mesh, Holes::Parity).map_err(|problem| wrong(problem.to_string()))?;
        let spectrum = Spectrum::new(&surface, time, cancel).ok_or(DiffusionError::Cancelled)?;
        // By the mesh that is asked, whose vertices may be in another order.
        let order = surface
            .order_of(closest.mesh().positions())
            .ok_or_else(|| wrong("its triangles cross one another".into()))?;
        Ok(Self { closest, spectrum, order })
    }

    fn of_vertex(&self, vertex: u32) -> &[f64] {
        self.spectrum.of_vertex(self.order[vertex as usize] as usize)
    }
}

impl Boundary for Shell {
    fn numbers(&self) -> Box<dyn Iterator<Item = &[f64]> + '_> {
        Box::new((0..self.order.len() as u32).map(|vertex| self.of_vertex(vertex)))
    }

    fn closest(&self, position: DVec3, out: &mut Vec<f64>) -> f64 {
        let foot = self.closest.nearest(position);
        let corners = self.closest.mesh().triangles()[foot.triangle as usize];
        let ([a, b, c], [second, third]) = (corners.map(|vertex| self.of_vertex(vertex)), foot.weights);
        out.clear();
        out.extend((0..self.spectrum.modes()).map(|k| (1.0 - second - third) * a[k] + second * b[k] + third * c[k]));
        foot.distance_squared.sqrt()
    }

    fn mixed(&self, position: DVec3, weights: &mut Vec<f64>, out: &mut Vec<f64>) {
        let mesh = self.closest.mesh();
        mean_value::weights(position, mesh.positions(), mesh.triangles(), weights);
        out.clear();
        out.resize(self.spectrum.modes(), 0.0);
        for (vertex, weight) in (0..).zip(&*weights) {
            out.iter_mut().zip(self.of_vertex(vertex)).for_each(|(sum, number)| *sum += weight * number);
        }
    }
}

impl Positional for Diffusion {
    /// The distance at a position: the square is cubic between nodes (Catmull and Rom), so the distance has no creases.
    fn at(&self, position: DVec3) -> f32 {
        let place = (position - self.origin) / self.step;
        if place.is_nan() {
            return f32::NAN;
        }
        let place = place.clamp(DVec3::ZERO, (self.size - 1).as_dvec3());
        let least = place.floor().as_ivec3().min(self.size - 2).max(IVec3::ZERO);
        let share = place - least.as_dvec3();
        let weights = [catmull_rom(share.x), catmull_rom(share.y), catmull_rom(share.z)];
        let node = |x: i32, y: i32, z: i32| {
            let at = (least + IVec3::new(x, y, z) - 1).clamp(IVec3::ZERO, self.size - 1);
            f64::from(self.squares[((at.x * self.size.y + at.y) * self.size.z + at.z) as usize])
        };
        let mut sum = 0.0;
        for x in 0..4 {
            for y in 0..4 {
                let along: f64 = (0..4).map(|z| weights[2][z] * node(x, y, z as i32)).sum();
                sum += weights[0][x as usize] * weights[1][y as usize] * along;
            }
        }
        sum.clamp(0.0, 1.0).sqrt() as f32
    }

    fn range(&self) -> Interval {
        Interval::new(0.0, 1.0)
    }
}

/// The weights of four nodes for a place between the middle two.
fn catmull_rom(u: f64) -> [f64; 4] {
    let (uu, uuu) = (u * u, u * u * u);
    [
        0.5 * (-uuu + 2.0 * uu - u),
        0.5 * (3.0 * uuu - 5.0 * uu + 2.0),
        0.5 * (-3.0 * uuu + 4.0 * uu + u),
        0.5 * (uuu - uu),
    ]
}

impl Attribute<1> for Diffusion {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        Box::new(PositionalSampler(self))
    }
}

#[cfg(test)]
mod tests;
