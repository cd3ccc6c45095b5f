use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec2;

use super::*;
use crate::field::{Expression, Graph, Joined, Node, Procedure, SetSystem, Slope};

fn field(make: impl FnOnce(&mut Graph) -> Node) -> Arc<dyn Field> {
    let mut graph = Graph::new();
    let node = make(&mut graph);
    Arc::new(Expression::new(&graph, node).keeping_values())
}

fn balls(all: &[(DVec3, f64)]) -> Arc<dyn Field> {
    field(|graph| {
        let one = |graph: &mut Graph, (centre, radius): &(DVec3, f64)| {
            let node = crate::distance::accuracy::ball(graph, *centre, *radius);
            graph.bounded(node, Aabb::new(*centre - *radius, *centre + *radius))
        };
        let nodes: Vec<Node> = all.iter().map(|ball| one(graph, ball)).collect();
        graph.union(SetSystem::MinMax, &nodes)
    })
}

fn spread(solid: &dyn Field, source: DVec3, time: f64) -> Result<Diffusion, DiffusionError> {
    let aabb = solid.bounding_box().expect("it has one");
    Diffusion::new(&Spreading { solid, aabb, sources: &[source], time, cancel: &AtomicBool::new(false) })
}

/// On a ball the eigenfunctions are spherical harmonics: by their addition theorem
/// d² = Σₗ exp(−2·l(l + 1)·t)·(2l + 1)/4π·(2 − 2·Pₗ(cos γ)), and the middle, the mean of all, is 0 in each of them.
#[test]
fn on_a_ball_it_is_that_of_spherical_harmonics() {
    let solid = balls(&[(DVec3::splat(0.03), 1.0)]);
    for time in [0.25, 10.0] {
        let found = spread(&*solid, DVec3::splat(0.03) + DVec3::Z * 0.995, time).expect("distances");
        let sum = |of: &dyn Fn(usize, f64) -> f64| {
            let term = |l: usize| {
                let rate = (l * (l + 1)) as f64;
                libm::exp(-rate * time) * (2 * l + 1) as f64 * of(l, rate)
            };
            (1..40).map(term).sum::<f64>()
        };
        let legendre = |l: usize, x: f64| {
            let (mut before, mut now) = (1.0, x);
            for k in 1..l {
                (before, now) = (now, ((2 * k + 1) as f64 * x * now - k as f64 * before) / (k + 1) as f64);
            }
            now
        };
        let to = |cos: f64| sum(&|l, _| 2.0 - 2.0 * legendre(l, cos));
        for degrees in [20.0_f64, 50.0, 90.0, 130.0, 180.0] {
            let (sin, cos) = (libm::sin(degrees.to_radians()), libm::cos(degrees.to_radians()));
            let at = DVec3::splat(0.03) + DVec3::new(0.6 * sin, 0.8 * sin, cos);
            let (is, exact) = (f64::from(found.at(at)), (to(cos) / to(-1.0)).sqrt());
            assert!((is - exact).abs() < 0.02, "{time} {degrees}: {is} {exact}");
        }
        let (middle, exact) = (f64::from(found.at(DVec3::splat(0.03))), (sum(&|_, _| 1.0) / to(-1.0)).sqrt());
        assert!((middle - exact).abs() < 0.02, "{time}: {middle} {exact}");
    }
}

#[test]
fn mean_values_give_linear_functions_back() {
    let solid = balls(&[(DVec3::ZERO, 1.0), (DVec3::X * 1.2, 0.7)]);
    let grid = Grid::fitting(&*solid, solid.bounding_box().expect("it has one"));
    let surface = grid.surface(&*solid);
    assert!((1200..3200).contains(&surface.positions.len()), "{}", surface.positions.len());
    let mut weights = Vec::new();
    for at in [DVec3::ZERO, DVec3::new(0.5, 0.3, -0.6), DVec3::new(1.7, 0.1, 0.1), DVec3::new(0.0, 0.97, 0.0)] {
        mean_value::weights(at, &surface.positions, &surface.triangles, &mut weights);
        let sum: DVec3 = weights.iter().zip(&surface.positions).map(|(weight, position)| *position * *weight).sum();
        assert!(sum.distance(at) < 1e-9, "{at} {sum}");
        assert!(weights.iter().all(|weight| weight.is_finite()));
    }
}

/// Through the neck of a dumb-bell little heat goes: the way along either ball is short against that between them.
#[test]
fn a_neck_parts_two_balls() {
    let solid = balls(&[(DVec3::X * -1.0, 0.8), (DVec3::ZERO, 0.35), (DVec3::X, 0.8)]);
    let found = spread(&*solid, DVec3::new(-1.5, 0.0, 0.0), 0.5).expect("distances");
    let at = |x: f64| found.at(DVec3::new(x, 0.05, 0.0));
    let ends = [at(-1.5), at(-0.6), at(0.0), at(0.6), at(1.6)];
    assert!(ends.windows(2).all(|two| two[0] < two[1] + 1e-3), "{ends:?}");
    assert!(ends[0] < 0.05 && ends[1] < 0.3 && (0.35..0.65).contains(&ends[2]) && ends[4] > 0.8, "{ends:?}");
    // The greatest is beside the axis: there the modes that turn around it count too.
    assert!(found.at(DVec3::X * 1.8) > 0.8);
    // Outside as at the closest point.
    assert!((found.at(DVec3::X * 9.0) - found.at(DVec3::X * 1.8)).abs() < 0.03);
}

/// A disc, a box of the plane, or what is in one of some.
fn plane(shape: impl Fn(DVec3) -> f64 + Send + Sync + 'static, half: f64) -> Arc<dyn Field> {
    let at = move |p: DVec3| (shape(p), DVec3::ZERO);
    let bounds = Aabb::new(DVec3::splat(-half), DVec3::splat(half)).without_z();
    Joined::shared(Procedure { at, bounds: Some(bounds), slope: Slope::Unknown, is_flat: true })
}

/// Σₖ exp(−2k²·t)·(2 − 2·cos kα), the square between two places of a closed curve that are α of it apart.
fn around(angle: f64, time: f64) -> f64 {
    (1..30).map(f64::from).map(|k| libm::exp(-2.0 * k * k * time) * (2.0 - 2.0 * libm::cos(k * angle))).sum()
}

/// On an outline it is known by the share of the way around, inside by its mean over all directions, each weighted by how near
/// the outline is: by rays, without corners.
#[test]
fn on_the_plane_it_is_a_sum_of_cosines() {
    let disc = plane(|p| 1.0 - p.truncate().length(), 1.0);
    for time in [0.25, 1.0] {
        let found = spread(&*disc, DVec3::new(0.999, 0.0, 7.0), time).expect("distances");
        for degrees in [30.0_f64, 90.0, 150.0, 180.0] {
            let (sin, cos) = libm::sincos(degrees.to_radians());
            let is = f64::from(found.at(DVec3::new(cos, sin, -3.0)));
            let exact = (around(degrees.to_radians(), time) / around(PI, time)).sqrt();
            assert!((is - exact).abs() < 0.02, "{time} {degrees}: {is} {exact}");
        }
        for at in [DVec2::ZERO, DVec2::new(0.3, 0.4), DVec2::new(-0.6, 0.1), DVec2::new(0.1, -0.85)] {
            let (rays, mut sum) = (4000, [0.0; 61]);
            for i in 0..rays {
                let (sin, cos) = libm::sincos(TAU * f64::from(i) / f64::from(rays));
                let along = at.x * cos + at.y * sin;
                let far = -along + (along * along + 1.0 - at.length_squared()).sqrt();
                let angle = libm::atan2(at.y + far * sin, at.x + far * cos);
                sum[0] += 1.0 / far;
                for k in 1..=30 {
                    let (sin, cos) = libm::sincos(k as f64 * angle);
                    sum[2 * k - 1] += cos / far;
                    sum[2 * k] += sin / far;
                }
            }
            let of = |k: usize| {
                let [cos, sin] = [sum[2 * k - 1] / sum[0] - 1.0, sum[2 * k] / sum[0]];
                libm::exp(-2.0 * (k * k) as f64 * time) * (cos * cos + sin * sin)
            };
            let exact = ((1..=30).map(of).sum::<f64>() / around(PI, time)).sqrt();
            let is = f64::from(found.at(at.extend(0.0)));
            assert!((is - exact).abs() < 0.02, "{time} {at}: {is} {exact}");
        }
    }
    let square = plane(|p| 1.0 - p.x.abs().max(p.y.abs()), 1.0);
    let found = spread(&*square, DVec3::new(0.0, -0.999, 0.0), 0.5).expect("distances");
    for (x, y, way) in [(1.0, -1.0, 1.0), (1.0, 0.0, 2.0), (-1.0, 0.5, 2.5), (0.0, 1.0, 4.0)] {
        let exact = (around(TAU * way / 8.0, 0.5) / around(PI, 0.5)).sqrt();
        let is = f64::from(found.at(DVec3::new(x, y, 0.0)));
        assert!((is - exact).abs() < 0.02, "{x} {y}: {is} {exact}");
    }
}

/// What is scaled in space has another box that does not end along z.
#[test]
fn a_scaled_shape_of_the_plane_is_one() {
    let half = plane(|p| 0.5 - p.truncate().length(), 0.5);
    let aabb = Aabb::new(DVec3::new(-0.5, -0.5, -5e14), DVec3::new(0.5, 0.5, 5e14));
    let cancel = AtomicBool::new(false);
    let spreading = Spreading { solid: &*half, aabb, sources: &[DVec3::X * 0.4995], time: 0.5, cancel: &cancel };
    let found = Diffusion::new(&spreading).expect("distances");
    let (is, exact) = (f64::from(found.at(DVec3::Y * 0.5)), (around(PI / 2.0, 0.5) / around(PI, 0.5)).sqrt());
    assert!((is - exact).abs() < 0.02, "{is} {exact}");
}

#[test]
fn an_outline_is_one_piece() {
    let ring = plane(|p| 0.4 - (p.truncate().length() - 0.6).abs(), 1.0);
    let found = spread(&*ring, DVec3::X * 0.6, 0.5).err();
    assert!(matches!(found, Some(DiffusionError::Pieces(_))), "{found:?}");
    // Two that meet at a corner of the lattice's squares are one or two, never a curve without an end.
    for by in 0..20 {
        let by = 1e-3 * f64::from(by);
        let two = plane(move |p| ((p.x + by) * (p.y - by)).min(1.0 - p.x.abs().max(p.y.abs())), 1.0);
        let found = spread(&*two, DVec3::new(0.5, 0.5, 0.0), 0.5);
        assert!(matches!(found, Ok(_) | Err(DiffusionError::Pieces(_))));
    }
}

#[test]
fn threads_change_no_bit() {
    let solid = balls(&[(DVec3::ZERO, 1.0), (DVec3::X * 1.2, 0.7)]);
    let squares = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let found = pool.install(|| spread(&*solid, DVec3::ZERO, 1.0)).expect("distances");
        found.squares.iter().map(|square| square.to_bits()).collect::<Vec<_>>()
    };
    assert!(squares(1) == squares(2));
}

#[test]
fn what_has_no_distance_is_told() {
    let solid = balls(&[(DVec3::ZERO, 1.0)]);
    assert_eq!(spread(&*solid, DVec3::X * 1.1, 0.5).err(), Some(DiffusionError::Outside(DVec3::X * 1.1)));
    let two = balls(&[(DVec3::X * -2.0, 1.0), (DVec3::X * 2.0, 1.0)]);
    let found = spread(&*two, DVec3::X * 2.0, 0.5).err();
    assert!(matches!(found, Some(DiffusionError::Pieces([one, other])) if one.x * other.x < 0.0), "{found:?}");
    let cancelled = Spreading {
        solid: &*solid,
        aabb: Aabb::new(DVec3::NEG_ONE, DVec3::ONE),
        sources: &[DVec3::ZERO],
        time: 0.5,
        cancel: &AtomicBool::new(true),
    };
    assert_eq!(Diffusion::new(&cancelled).err(), Some(DiffusionError::Cancelled));
}
