//! How right a band is: its distances against exact answers.

pub mod in_plane;
mod planar;
pub mod table;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::{
    field::{Aabb, Expression, Graph, Node, Points, SetSystem},
    grid::{BLOCK_VOXELS, Band, BlockMask, is_active},
};

/// The errors of a band, over its active voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Accuracy {
    /// Active voxels judged.
    pub voxels: u64,
    /// Mean error of the distance, in voxels.
    pub mean: f64,
    /// Greatest error, in voxels.
    pub max: f64,
    /// Where that is, world units.
    pub worst_at: DVec3,
    /// Mean of | |∇d| − 1 | by central differences, over voxels whose neighbours are in the same block and active.
    pub slope: f64,
    /// Voxels of all blocks on the wrong side, but for those within a ten thousandth of a voxel of the surface,
    /// where F itself is rounded.
    pub wrong_signs: u64,
}

/// Sums over some blocks, added up in the blocks' order.
#[derive(Clone, Copy, Default)]
struct Sums {
    voxels: u64,
    errors: f64,
    max: f64,
    worst_at: DVec3,
    slopes: u64,
    slope_errors: f64,
    wrong_signs: u64,
}

/// Compares a band with the exact signed distance, positive inside.
pub fn compare(band: &Band, exact: impl Fn(DVec3) -> f64 + Sync) -> Accuracy {
    let blocks: Vec<Sums> =
        (0..band.origins.len()).into_par_iter().map(|block| of_block(band, block, &exact)).collect();
    let mut all = Sums::default();
    for sums in blocks {
        all.voxels += sums.voxels;
        all.errors += sums.errors;
        all.slopes += sums.slopes;
        all.slope_errors += sums.slope_errors;
        all.wrong_signs += sums.wrong_signs;
        if sums.max > all.max {
            (all.max, all.worst_at) = (sums.max, sums.worst_at);
        }
    }
    Accuracy {
        voxels: all.voxels,
        mean: all.errors / all.voxels.max(1) as f64,
        max: all.max,
        worst_at: all.worst_at,
        slope: all.slope_errors / all.slopes.max(1) as f64,
        wrong_signs: all.wrong_signs,
    }
}

fn of_block(band: &Band, block: usize, exact: &impl Fn(DVec3) -> f64) -> Sums {
    let (distances, active) = (&band.distances[block], &band.active[block]);
    let size = band.lattice.voxel_size.get();
    let background = f64::from(band.background());
    let points = Points::of_block(band.origins[block], &band.lattice);
    let mut sums = Sums::default();
    for i in 0..BLOCK_VOXELS {
        let truth = exact(points.position(i));
        let distance = f64::from(distances[i]);
        if truth.abs() > 1e-4 * size && (truth > 0.0) != (distance > 0.0) {
            sums.wrong_signs += 1;
        }
        // An inactive voxel claims to be beyond the band: wrong by as much as it is not.
        let error = (distance - truth.clamp(-background, background)).abs() / size;
        if error > sums.max {
            (sums.max, sums.worst_at) = (error, points.position(i));
        }
        if is_active(active, i) {
            sums.voxels += 1;
            sums.errors += error;
            if let Some(slope) = slope(distances, i, active) {
                sums.slopes += 1;
                sums.slope_errors += (slope / (2.0 * size) - 1.0).abs();
            }
        }
    }
    sums
}

/// The length of the gradient by central differences, times two voxels.
fn slope(distances: &[f32; BLOCK_VOXELS], i: usize, active: &BlockMask) -> Option<f64> {
    let inner = |c: usize| (1..7).contains(&c);
    if !(inner(i >> 6) && inner(i >> 3 & 7) && inner(i & 7)) {
        return None;
    }
    let mut square = 0.0;
    for stride in [64, 8, 1] {
        let (less, more) = (i - stride, i + stride);
        if !(is_active(active, less) && is_active(active, more)) {
            return None;
        }
        square += (f64::from(distances[more]) - f64::from(distances[less])).powi(2);
    }
    Some(square.sqrt())
}

/// A shape whose distance is known in closed form, written as a function that is no distance.
pub struct Case {
    /// What it is.
    pub name: &'static str,
    /// The function.
    pub field: Expression,
    /// The box of the solid.
    pub solid: Aabb,
    /// The exact signed distance, positive inside.
    pub exact: fn(DVec3) -> f64,
}

/// The shapes that the promise of exactness is held to: smooth ones, edges and corners, a concave crease.
pub fn cases() -> Vec<Case> {
    let case = |name, reach: DVec3, exact, build: &dyn Fn(&mut Graph) -> Node| {
        let mut graph = Graph::new();
        let node = build(&mut graph);
        Case { name, field: Expression::new(&graph, node), solid: Aabb::new(-reach, reach), exact }
    };
    vec![
        case("sphere, r² − |p|²", DVec3::splat(1.0), |p| exact::sphere(p, DVec3::ZERO, 1.0), &|graph| {
            ball(graph, DVec3::ZERO, 1.0)
        }),
        case(
            "torus, m² − (ρ − M)² − z²",
            DVec3::new(1.0, 1.0, TUBE),
            |p| exact::torus(p, 1.0 - TUBE, TUBE),
            &|graph| {
                let [x, y, z] = [graph.x(), graph.y(), graph.z()].map(|c| graph.square(c));
                let across = graph.add(x, y);
                let across = graph.sqrt(across);
                let from_ring = graph.linear(across, 1.0, TUBE - 1.0);
                let from_ring = graph.square(from_ring);
                let sum = graph.add(from_ring, z);
                graph.linear(sum, -1.0, TUBE * TUBE)
            },
        ),
        case("ellipsoid, 1 − Σ (p/a)²", RADII, |p| exact::ellipsoid(p, RADII), &|graph| {
            let scaled = [0, 1, 2].map(|axis| graph.affine(DVec3::AXES[axis] / RADII[axis], 0.0));
            let [x, y, z] = scaled.map(|c| graph.square(c));
            let sum = graph.add(x, y);
            let sum = graph.add(sum, z);
            graph.linear(sum, -1.0, 1.0)
        }),
        case(
            "turned box, six half-spaces under R₀",
            DVec3::splat(HALF.length()),
            |p| exact::oriented_box(p, turned(), HALF),
            &|graph| {
                let sides: Vec<Node> = (0..6)
                    .map(|side| {
                        let normal = turned().col(side / 2) * if side % 2 == 0 { 1.0 } else { -1.0 };
                        graph.half_space(normal, HALF[side / 2])
                    })
                    .collect();
                graph.intersection(SetSystem::R0, &sides)
            },
        ),
        case(
            "two overlapping spheres under R₀ union",
            DVec3::new(1.0, 1.0 - APART, 1.0 - APART),
            |p| exact::two_spheres(p, APART, 1.0 - APART),
            &|graph| {
                let x = DVec3::new(APART, 0.0, 0.0);
                let balls = [ball(graph, x, 1.0 - APART), ball(graph, -x, 1.0 - APART)];
                graph.union(SetSystem::R0, &balls)
            },
        ),
    ]
}

pub use planar::plane_cases;

/// What methods are compared on: the same and extruded outlines. The ellipsoid is left out, whose exact distance by
/// bisection is 0/0 at some nodes on its planes of symmetry.
pub fn all_cases() -> Vec<Case> {
    let known = cases().into_iter().filter(|case| !case.name.starts_with("ellipsoid"));
    known.chain(planar::cases()).collect()
}

const TUBE: f64 = 0.3;
const RADII: DVec3 = DVec3::new(1.0, 0.6, 0.4);
const HALF: DVec3 = DVec3::new(0.8, 0.5, 0.33);
const APART: f64 = 0.35;

/// A rotation by 40° about (1, 2, 3).
fn turned() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0) / 14f64.sqrt(), 40f64.to_radians())
}

/// r² − |p − c|².
pub fn ball(graph: &mut Graph, centre: DVec3, radius: f64) -> Node {
    let squares = [0, 1, 2].map(|axis| {
        let offset = graph.affine(DVec3::AXES[axis], -centre[axis]);
        graph.square(offset)
    });
    let sum = graph.add(squares[0], squares[1]);
    let sum = graph.add(sum, squares[2]);
    graph.linear(sum, -1.0, radius * radius)
}

/// Signed distances in closed form, positive inside.
pub mod exact {
    use glam::{DMat3, DVec3};

    /// A ball.
    pub fn sphere(p: DVec3, centre: DVec3, radius: f64) -> f64 {
        radius - (p - centre).length()
    }

    /// A torus about z; away from the tube's own axis.
    pub fn torus(p: DVec3, major: f64, minor: f64) -> f64 {
        minor - libm::hypot(libm::hypot(p.x, p.y) - major, p.z)
    }

    /// A box of half edges `half` whose axes are the columns of `axes`.
    pub fn oriented_box(p: DVec3, axes: DMat3, half: DVec3) -> f64 {
        let q = (axes.transpose() * p).abs() - half;
        -(q.max(DVec3::ZERO).length() + q.max_element().min(0.0))
    }

    /// Two overlapping spheres of one radius with centres at ± `apart` along x.
    pub fn two_spheres(p: DVec3, apart: f64, radius: f64) -> f64 {
        let p = DVec3::new(p.x.abs(), p.y, p.z);
        let centre = DVec3::new(apart, 0.0, 0.0);
        let from_centre = p - centre;
        let foot = centre + from_centre.normalize() * radius;
        if from_centre.length() > radius {
            return radius - from_centre.length();
        }
        // Inside: the sphere's foot counts where it lies outside the other sphere, else the circle is nearest.
        if foot.x >= 0.0 {
            return radius - from_centre.length();
        }
        let circle = (radius * radius - apart * apart).sqrt();
        libm::hypot(libm::hypot(p.y, p.z) - circle, p.x)
    }

    /// The closest point of an ellipsoid by bisection on the multiplier t of x_i = a_i² p_i / (a_i² + t).
    pub fn ellipsoid(p: DVec3, a: DVec3) -> f64 {
        let squares = a * a;
        let outside = |t: f64| (a * p / (squares + t)).length_squared() - 1.0;
        let (mut lo, mut hi) = (-squares.min_element(), a.max_element() * p.length());
        for _ in 0..200 {
            let middle = 0.5 * (lo + hi);
            if outside(middle) > 0.0 { lo = middle } else { hi = middle }
        }
        let foot = squares * p / (squares + 0.5 * (lo + hi));
        (p - foot).length() * if (p / a).length_squared() < 1.0 { 1.0 } else { -1.0 }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::{
        distance::band::{Feet, MeasuredBlock, Settings, measure},
        grid::{Lattice, VoxelSize},
    };

    #[test]
    fn the_promise_holds_for_every_case() {
        let size = 2.0 / 80.0;
        for case in cases() {
            let lattice = Lattice { voxel_size: VoxelSize::new(size).unwrap() };
            let cancel = AtomicBool::new(false);
            let region = case.solid.grown(4.0 * size);
            let settings =
                Settings { lattice, half_width: 3.0, region, feet: Feet::Nearest, cancel: &cancel, progress: &|_| {} };
            let measured = measure(&case.field, &settings, || |_: &MeasuredBlock| ()).unwrap();
            let accuracy = compare(&measured.band, case.exact);
            eprintln!("{}: {accuracy:?}", case.name);
            assert!(accuracy.voxels > 20_000, "{}: {accuracy:?}", case.name);
            assert!(accuracy.mean <= 0.005 && accuracy.max <= 0.05, "{}: {accuracy:?}", case.name);
            assert_eq!(accuracy.wrong_signs, 0, "{}", case.name);
        }
    }

    #[test]
    fn errors_are_seen() {
        let lattice = Lattice { voxel_size: VoxelSize::new(0.5).unwrap() };
        let mut band = Band {
            lattice,
            half_width: 3.0,
            origins: vec![glam::IVec3::ZERO],
            distances: vec![[0.0; BLOCK_VOXELS]],
            active: vec![[u64::MAX; 8]],
            inside_tiles: Vec::new(),
        };
        let exact = |p: DVec3| 0.3 - 0.5 * p.x;
        for i in 0..BLOCK_VOXELS {
            band.distances[0][i] = exact(Points::of_block(glam::IVec3::ZERO, &lattice).position(i)).max(-1.5) as f32;
        }
        band.distances[0][64 + 8 + 1] *= -1.0;
        let accuracy = compare(&band, exact);
        assert_eq!((accuracy.wrong_signs, accuracy.voxels), (1, 512));
        assert!((accuracy.max - 0.2).abs() < 1e-6 && accuracy.worst_at == DVec3::splat(0.5));
        assert!(accuracy.slope > 0.4);
    }
}
