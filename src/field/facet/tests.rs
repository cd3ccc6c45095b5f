//! Faceted shapes sampled as anyone would: one body, no hollows, cuts no deeper than asked.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};

use super::super::cells::{CellId, CellOptions, Cells, Purpose, Random};
use super::super::{BATCH, Expression, Field, Graph, Node, Points, SetSystem};
use super::cut::piece;
use super::{Options, facet, mend, scatter, surface_points};

const OPTIONS: Options = Options { tilt: 25.0, cut: 0.12, seed: 7 };

fn cells(graph: &Graph, shape: Node, depth: [u32; 2], seed: u64) -> Cells {
    Cells::build(&Expression::new(graph, shape), &CellOptions { depth, chance: 0.6, seed }).unwrap()
}

/// The numbers of connected parts of the solid and of the space around it, on a lattice of samples. Samples that touch
/// at a corner are connected: a sharp ridge slants through the lattice.
fn parts(field: &dyn Field, along: usize) -> [usize; 2] {
    let bounds = field.bounding_box().unwrap().grown(0.1);
    let spacing = bounds.size() / along as f64;
    let mut evaluator = field.evaluator();
    let mut values = [0.0; BATCH];
    let mut solid = Vec::new();
    for run in 0..along * along {
        let first = DVec3::new((run / along) as f64 + 0.37, (run % along) as f64 + 0.37, 0.37);
        let mut points = Points::new(bounds.min + first * spacing);
        (0..along).for_each(|i| points.push(Vec3::Z * (i as f64 * spacing.z) as f32));
        evaluator.values(&points, &mut values);
        solid.extend(values[..along].iter().map(|value| *value >= 0.0));
    }
    let mut unseen: BTreeSet<usize> = (0..solid.len()).collect();
    let mut parts = [0, 0];
    while let Some(start) = unseen.pop_first() {
        parts[usize::from(!solid[start])] += 1;
        let mut open = vec![start];
        while let Some(i) = open.pop() {
            let place = [i / along / along, i / along % along, i % along];
            for step in 0..27 {
                let beside = [step / 9, step / 3 % 3, step % 3];
                let [x, y, z] = std::array::from_fn(|axis| (place[axis] + beside[axis]).wrapping_sub(1));
                let next = x.wrapping_mul(along).wrapping_add(y).wrapping_mul(along).wrapping_add(z);
                if x.max(y).max(z) < along && solid[next] == solid[i] && unseen.remove(&next) {
                    open.push(next);
                }
            }
        }
    }
    parts
}

#[test]
fn a_cube_stays_one_body_cut_no_deeper_than_asked() {
    for seed in 0..3 {
        let mut graph = Graph::new();
        let cube = graph.cuboid(DVec3::splat(1.6));
        let cells = cells(&graph, cube, [1, 3], seed);
        let faceted = facet(&mut graph, cube, &cells, &Options { seed, ..OPTIONS });
        assert!(faceted.pieces.pieces.len() >= cells.surface().len());
        let field = Expression::new(&graph, faceted.node);
        assert_eq!(parts(&field, 45), [1, 1]);
        let whole = Expression::new(&graph, cube);
        let mut random = Random::new(seed, 1, Purpose::Pick);
        let [mut cut, mut grown] = [0, 0];
        for _ in 0..4000 {
            let out = random.direction();
            let p = out * (0.8 / out.abs().max_element() + random.range(-0.2, 0.1));
            let (before, after) = (whole.reference(p), field.reference(p));
            assert!(before < 0.12 || after >= 0.0, "cut too deep at {p}");
            assert!(before > -0.06 || after < 0.0, "grown too far at {p}");
            cut += usize::from(before > 0.0 && after < 0.0);
            grown += usize::from(before < 0.0 && after > 0.0);
        }
        assert!(cut > 400 && grown > 20, "{cut} samples cut off, {grown} added");
    }
}

#[test]
fn the_graph_holds_the_pieces() {
    let mut graph = Graph::new();
    let ball = graph.sphere(1.0);
    let cells = cells(&graph, ball, [2, 3], 1);
    let field = Expression::new(&graph, ball);
    let (pieces, _) = mend::sound_pieces(&field, &cells, &OPTIONS);
    let faceted = facet(&mut graph, ball, &cells, &OPTIONS);
    let faceted = Expression::new(&graph, faceted.node);
    let deepest = pieces.iter().map(|piece| piece.depth).fold(0.0, f64::max);
    let mut random = Random::new(1, 1, Purpose::Pick);
    for _ in 0..2000 {
        let p = random.direction() * random.range(0.0, 1.3);
        let value = field.reference(p);
        let expected = pieces.iter().map(|piece| piece.value(p, value)).fold(value - deepest, f64::max);
        assert!((faceted.reference(p) - expected).abs() < 1e-14);
    }
}

/// Curved surfaces run through cells at a slant: cutting those alone leaves crumbs, which are mended.
#[test]
fn crumbs_are_mended() {
    let mut mended = 0;
    for seed in 0..3 {
        let mut graph = Graph::new();
        let torus = graph.torus(1.0, 0.35);
        let cells = cells(&graph, torus, [3, 4], seed);
        let options = Options { tilt: 40.0, cut: 0.3, seed };
        let faceted = facet(&mut graph, torus, &cells, &options);
        mended += faceted.mended;
        assert_eq!(parts(&Expression::new(&graph, faceted.node), 64), [1, 1], "seed {seed}");
    }
    assert!(mended > 0, "the test has lost its point");
}

#[test]
fn bodies_and_hollows_of_the_shape_stay() {
    let mut graph = Graph::new();
    let [outer, inner, far] = [1.0, 0.5, 0.6].map(|radius| graph.sphere(radius));
    let hollow = graph.difference(SetSystem::MinMax, outer, &[inner]);
    let far = graph.translate(far, DVec3::X * 2.0).unwrap();
    let shape = graph.union(SetSystem::MinMax, &[hollow, far]);
    let cells = cells(&graph, shape, [3, 4], 5);
    let faceted = facet(&mut graph, shape, &cells, &OPTIONS);
    assert_eq!(parts(&Expression::new(&graph, faceted.node), 64), [2, 2]);
}

#[test]
fn the_same_seed_gives_the_same_pieces() {
    let mut graph = Graph::new();
    let cube = graph.cuboid(DVec3::ONE);
    let cells = cells(&graph, cube, [2, 3], 7);
    let field = Expression::new(&graph, cube).keeping_values();
    let mut evaluator = field.evaluator();
    let mut one =
        |id: CellId, seed| format!("{:?}", piece(evaluator.as_mut(), &cells, id, &Options { seed, ..OPTIONS }));
    let forward: Vec<String> = cells.surface().iter().map(|&id| one(id, 7)).collect();
    let mut backward: Vec<String> = cells.surface().iter().rev().map(|&id| one(id, 7)).collect();
    backward.reverse();
    assert_eq!(forward, backward);
    assert_ne!(forward[0], one(cells.surface()[0], 8));
}

#[test]
fn copies_stand_on_the_surface() {
    let mut graph = Graph::new();
    let ball = graph.sphere(1.0);
    let cells = cells(&graph, ball, [2, 3], 3);
    let host = Expression::new(&graph, ball);
    let picked = cells.pick(0.25, 3);
    let at = surface_points(&host, &cells, &picked);
    for (position, &id) in at.iter().zip(&picked) {
        assert!(host.reference(*position).abs() < 1e-6);
        // The closest point of a sphere is known.
        assert!(position.distance(cells.cell(id).bounds.centre().normalize()) < 1e-6);
    }
    let eye = graph.sphere(0.1);
    let eyes = scatter(&mut graph, eye, &host, &cells, &picked);
    let eyes = Expression::new(&graph, eyes);
    let nearest = |p: DVec3| at.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
    let mut random = Random::new(1, 1, Purpose::Pick);
    for _ in 0..500 {
        let p = random.direction() * random.range(0.8, 1.2);
        assert!((eyes.reference(p) - (0.1 - nearest(p))).abs() < 1e-12);
    }
    let none = scatter(&mut graph, eye, &host, &cells, &[]);
    assert!(Expression::new(&graph, none).reference(DVec3::ZERO) < 0.0);
}

#[test]
fn the_walls_of_steps_belong_to_the_cells_whose_material_they_are() {
    let mut graph = Graph::new();
    let cube = graph.cuboid(DVec3::splat(1.6));
    let cells = cells(&graph, cube, [1, 3], 1);
    let faceted = facet(&mut graph, cube, &cells, &OPTIONS);
    let solid = Expression::new(&graph, faceted.node);
    let shape = Expression::new(&graph, cube);
    // Surface points: where lines along x enter the solid, and those along y and z.
    let mut walls = 0;
    for line in 0..3 * 40 * 40 {
        let [u, v] = [line % 40, line / 40 % 40].map(|i| (f64::from(i) + 0.37) * 0.04 - 0.8);
        let at = |along: f64| DVec3::from_array([[along, u, v], [u, along, v], [u, v, along]][line as usize / 1600]);
        if solid.reference(at(0.0)) < 0.0 {
            continue; // a line through what was cut off
        }
        let (mut outside, mut inside) = (-1.0, 0.0);
        for _ in 0..60 {
            let middle = (outside + inside) / 2.0;
            *(if solid.reference(at(middle)) >= 0.0 { &mut inside } else { &mut outside }) = middle;
        }
        let position = at(inside);
        let holds = |cell: CellId| {
            let piece = faceted.pieces.pieces.iter().find(|piece| piece.cell == cell).expect("a piece");
            piece.value(position, shape.reference(position)) >= -0.003
        };
        let mut points = Points::new(position);
        points.push(Vec3::ZERO);
        let mut found = [0; BATCH];
        faceted.pieces.cells_at(&cells, &points, &mut found);
        assert!(holds(CellId(found[0])), "{position}");
        walls += u32::from(!holds(cells.surface_leaf_at(position)));
    }
    assert!(walls > 0, "no line met a wall");
}
