//! Solids of many parts, closer together than blocks are wide, against exact answers.

use glam::{DAffine3, DQuat, DVec3, EulerRot};

use super::*;
use crate::{
    field::{Expression, Graph, Node, SetSystem},
    grid::VoxelSize,
};

/// Cubes that fill some cells of a grid: they touch at faces, edges and corners, and leave gaps.
struct Crowd {
    cells: i32,
    edge: f64,
    filled: Vec<bool>,
    to_world: DAffine3,
}

impl Crowd {
    fn new(cells: i32, edge: f64, share: f64) -> Self {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 0.5, 0.7);
        Self {
            cells,
            edge,
            filled: (0..cells.pow(3)).map(|_| random() < share).collect(),
            to_world: DAffine3::from_rotation_translation(turn, DVec3::new(0.31, -0.17, 0.23)),
        }
    }

    fn at(&self, number: usize) -> DVec3 {
        let (number, cells) = (number as i32, self.cells);
        IVec3::new(number / cells / cells, number / cells % cells, number % cells).as_dvec3() * self.edge
    }

    fn field(&self) -> Expression {
        let mut graph = Graph::new();
        let cubes: Vec<Node> = (0..self.filled.len())
            .filter(|&number| self.filled[number])
            .map(|number| {
                let (min, max) = (self.at(number), self.at(number) + self.edge);
                let mut sides = Vec::new();
                for axis in DVec3::AXES {
                    sides.push(graph.half_space(-axis, -min.dot(axis)));
                    sides.push(graph.half_space(axis, max.dot(axis)));
                }
                let cube = graph.intersection(SetSystem::MinMax, &sides);
                graph.bounded(cube, Aabb::new(min, max))
            })
            .collect();
        let union = graph.union(SetSystem::MinMax, &cubes);
        let placed = graph.transform(union, &self.to_world).unwrap();
        Expression::new(&graph, placed)
    }

    /// The exact signed distance: to the nearest filled cell outside, to the nearest empty one inside.
    fn distance(&self, position: DVec3) -> f64 {
        let p = self.to_world.inverse().transform_point3(position);
        let to_cell = |number: usize| {
            let least = self.at(number);
            (p - p.clamp(least, least + self.edge)).length()
        };
        let nearest = |filled: bool| {
            let cells = (0..self.filled.len()).filter(|&number| self.filled[number] == filled);
            cells.map(to_cell).fold(f64::INFINITY, f64::min)
        };
        let end = f64::from(self.cells) * self.edge;
        let to_end = p.min(DVec3::splat(end) - p).min_element();
        let outside = nearest(true);
        if outside > 0.0 { -outside } else { nearest(false).min(to_end) }
    }
}

/// Errors of all active voxels, in voxels, sorted.
fn errors(crowd: &Crowd) -> Vec<f64> {
    let field = crowd.field();
    let cancel = AtomicBool::new(false);
    let lattice = Lattice { voxel_size: VoxelSize::new(1.0).unwrap() };
    let region = field.bounding_box().unwrap().grown(4.0);
    let settings =
        Settings { lattice, half_width: 3.0, region, feet: Feet::Nearest, cancel: &cancel, progress: &|_| {} };
    let measured = measure(&field, &settings, || |_: &MeasuredBlock| ()).unwrap();
    let band = &measured.band;
    let mut errors = Vec::new();
    for ((&origin, distances), active) in band.origins.iter().zip(&band.distances).zip(&band.active) {
        let points = crate::field::Points::of_block(origin, &lattice);
        for i in (0..BLOCK_VOXELS).filter(|&i| crate::grid::is_active(active, i)) {
            let (found, exact) = (f64::from(distances[i]), crowd.distance(points.position(i)));
            assert!((found >= 0.0) == (exact >= 0.0) || exact.abs() < 1e-4, "sign of {found} for {exact}");
            errors.push((found - exact.clamp(-3.0, 3.0)).abs());
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

/// The mean and the greatest error, and the share of errors above the promised 0.05 voxel.
fn measured(edge: f64) -> (f64, f64, f64) {
    let errors = errors(&Crowd::new(8, edge, 0.4));
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let above = errors.iter().filter(|&&error| error > 0.05).count() as f64 / errors.len() as f64;
    eprintln!("cells of {edge} voxels: mean {mean}, {above} of {} above 0.05", errors.len());
    (mean, errors[errors.len() - 1], above)
}

#[test]
fn cubes_of_many_voxels() {
    let (mean, worst, _) = measured(6.0);
    assert!(mean <= 0.005 && worst <= 0.05, "mean {mean}, worst {worst}");
}

#[test]
fn cubes_of_a_few_voxels() {
    let (mean, worst, _) = measured(2.5);
    assert!(mean <= 0.005 && worst <= 0.05, "mean {mean}, worst {worst}");
}

/// Within reach of a voxel there are more faces here than are combined.
#[test]
fn cubes_of_one_voxel() {
    let (mean, worst, above) = measured(1.0);
    assert!(mean <= 0.005 && above <= 0.005 && worst <= 0.2, "mean {mean}, worst {worst}, {above} above 0.05");
}
