use std::sync::Arc;

use super::*;
use crate::field::{Expression, Graph, Node, SetSystem};

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
