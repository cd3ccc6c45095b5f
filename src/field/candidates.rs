//! Which of many parts can be the best one in a cube, as a tree of cubes: what [`super::parts`] finds its few parts by.
//!
//! A part stays in a cube where its value at the middle is no more than twice the half diagonal below the best: parts have
//! slope 1 at most, so that nothing that is left out is the best anywhere in it.

use glam::DVec3;

use super::Aabb;
use super::part::{Parts, WITHIN};

/// So few parts are not told apart any further.
const FEW: usize = 4;

/// Levels of cubes. Fewer: more parts are looked at for every point; more: the tree of a lattice takes longer than a frame.
const DEPTH: usize = 5;

/// Cubes in all. Where very many parts are as near everywhere the tree ends early.
const MOST_CUBES: usize = 50_000;

/// The tree.
pub struct Candidates {
    cubes: Vec<Cube>,
    bounds: Aabb,
    /// Axes that are halved.
    axes: usize,
}

struct Cube {
    parts: Vec<u32>,
    /// The first of its halves, quarters or eighths.
    children: Option<u32>,
}

impl Candidates {
    /// Of all parts in a box; `None` where they are few, or the box is nowhere.
    pub fn new(parts: &impl Parts) -> Option<Self> {
        let bounds = match parts.period() {
            // All regions that are seen as one, around any point of the cube at the origin.
            Some(edge) => Aabb::new(DVec3::ZERO, DVec3::splat(edge)).grown(WITHIN * edge),
            None => {
                let bounds = parts.bounding_box()?;
                let bounds = if parts.is_flat() { flattened(bounds) } else { bounds };
                let size = bounds.size().max_element();
                if parts.is_flat() { flattened(bounds.grown(0.25 * size)) } else { bounds.grown(0.25 * size) }
            }
        };
        if parts.count() <= 2 * FEW || !bounds.size().is_finite() {
            return None;
        }
        let root = Cube { parts: (0..parts.count() as u32).collect(), children: None };
        let mut tree = Self { cubes: vec![root], bounds, axes: if parts.is_flat() { 2 } else { 3 } };
        let mut open = vec![(0, bounds, 0)];
        while let Some((index, bounds, depth)) = open.pop() {
            if depth == DEPTH || tree.cubes[index].parts.len() <= FEW || tree.cubes.len() > MOST_CUBES {
                continue;
            }
            let first = tree.cubes.len();
            for child in 0..1 << tree.axes {
                let bounds = tree.part_of(&bounds, child);
                let chosen = chosen(parts, &tree.cubes[index].parts, &bounds);
                tree.cubes.push(Cube { parts: chosen, children: None });
                open.push((first + child, bounds, depth + 1));
            }
            tree.cubes[index].children = Some(first as u32);
        }
        Some(tree)
    }

    fn part_of(&self, bounds: &Aabb, child: usize) -> Aabb {
        let (middle, mut part) = (bounds.centre(), *bounds);
        for axis in 0..self.axes {
            let side = if child >> axis & 1 == 0 { &mut part.max } else { &mut part.min };
            side[axis] = middle[axis];
        }
        part
    }

    /// Those that may be the best at a point: of the smallest cube that it is in.
    pub fn at(&self, point: DVec3) -> &[u32] {
        let (mut low, mut half) = (self.bounds.min, self.bounds.size() * 0.5);
        let mut cube = &self.cubes[0];
        let is_in = point.cmpge(low) & point.cmple(self.bounds.max);
        if !(is_in.test(0) && is_in.test(1) && (is_in.test(2) || self.axes == 2)) {
            return &cube.parts;
        }
        while let Some(first) = cube.children {
            let middle = low + half;
            let beyond = point.cmpge(middle);
            let child = if self.axes == 3 { beyond.bitmask() } else { beyond.bitmask() & 3 };
            low = DVec3::select(beyond, middle, low);
            half *= 0.5;
            cube = &self.cubes[(first + child) as usize];
        }
        &cube.parts
    }

    /// Those that may be the best somewhere in a region: of the smallest cube that holds it.
    pub fn of(&self, region: &Aabb) -> &[u32] {
        let (mut cube, mut bounds) = (&self.cubes[0], self.bounds);
        let inside = |bounds: &Aabb| {
            (0..self.axes).all(|axis| bounds.min[axis] <= region.min[axis] && region.max[axis] <= bounds.max[axis])
        };
        if !inside(&bounds) {
            return &cube.parts;
        }
        while let Some(first) = cube.children {
            let middle = bounds.centre();
            let child = (0..self.axes).filter(|axis| region.min[*axis] >= middle[*axis]).map(|axis| 1 << axis).sum();
            let part = self.part_of(&bounds, child);
            if !inside(&part) {
                break;
            }
            (cube, bounds) = (&self.cubes[first as usize + child], part);
        }
        &cube.parts
    }
}

fn flattened(bounds: Aabb) -> Aabb {
    Aabb::new(bounds.min.with_z(0.0), bounds.max.with_z(0.0))
}

/// Those of some parts that may be the best somewhere in a box.
fn chosen(parts: &impl Parts, among: &[u32], bounds: &Aabb) -> Vec<u32> {
    let (middle, reach) = (bounds.centre(), bounds.size().length() * 0.5);
    let values: Vec<f64> = among.iter().map(|index| parts.part(*index as usize, middle).0).collect();
    let best = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = best - 2.0 * reach - 1e-9 * (best.abs() + reach);
    among.iter().zip(values).filter(|(_, value)| *value >= least).map(|(index, _)| *index).collect()
}
