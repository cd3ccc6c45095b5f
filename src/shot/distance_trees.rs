//! Random trees of set operations, offsets and walls against a brute-force distance: to points as near to one another
//! as a part of a voxel, on all of the boundary of the solid that the tree means.
//!
//! The solid is written down here a second time, by the definition: a set operation is one of signs, an offset asks how
//! far its operand's boundary is. A boundary is where the sign changes; a face that two operands share is none by itself.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use crate::distance::nearest::PointTree;
use crate::field::{Aabb, Points, rotation};
use crate::grid::{BLOCK_VOXELS, Band, is_active};
use crate::shot::displace_tests::band_of;
use crate::shot::scalar_tests::{Sampling, prepared_at};

/// Random trees.
const TREES: u64 = 2;
/// The share of operations whose operands share a face.
const SHARED_FACES: f64 = 0.3;
/// Voxels along the longest side.
const RESOLUTION: u32 = 20;
/// The spacing of points on a boundary, in voxels.
const SPACING: f64 = 0.2;
/// The same on the boundary of an operand: an offset of it is short beyond creases by as much.
const SPACING_OF_OPERANDS: f64 = 0.1;
/// How far distances may be from those to the points, in voxels, beside the spacing.
const TOLERANCE: f64 = 0.1;
/// The share of voxels that may be further from them: those beside creases and slivers, which measuring rounds.
const BESIDE_CREASES: f64 = 0.01;

/// Repeatable numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        // In hundredths: numbers that the scene's text holds exactly as they are here.
        (100.0 * (low + (high - low) * self.next())).round() / 100.0
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Ball,
    Cuboid,
    Ellipsoid,
    Cylinder,
    Torus,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operation {
    Union,
    Intersection,
    Difference,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Offset(f64),
    Shell(f64),
}

/// What a tree means.
enum Solid {
    Leaf { kind: Kind, size: DVec3, back: DAffine3 },
    Set(Operation, Vec<Solid>),
    Stepped { of: Box<Solid>, boundary: PointTree, step: Step },
}

impl Solid {
    /// Not negative inside, and never steeper than 1.
    fn value(&self, at: DVec3) -> f64 {
        match self {
            Self::Leaf { kind, size, back } => leaf(*kind, *size, back.transform_point3(at)),
            Self::Set(operation, operands) => {
                let rest = operands[1..].iter().map(|operand| operand.value(at));
                let first = operands[0].value(at);
                match operation {
                    Operation::Union => rest.fold(first, f64::max),
                    Operation::Intersection => rest.fold(first, f64::min),
                    Operation::Difference => rest.fold(first, |value, other| value.min(-other)),
                }
            }
            Self::Stepped { of, boundary, step } => {
                let away = boundary.nearest(at, None).map_or(f64::MAX, |(_, nearest)| nearest.distance(at));
                match step {
                    Step::Offset(by) if of.value(at) >= 0.0 => away + by,
                    Step::Offset(by) => by - away,
                    Step::Shell(thickness) => 0.5 * thickness - away,
                }
            }
        }
    }

    /// Points of the boundary, about `spacing` apart: where edges of a lattice cross it.
    fn boundary(&self, spacing: f64) -> Vec<DVec3> {
        const DEPTH: i32 = 6;
        let edge = spacing * 2.0_f64.powi(DEPTH);
        let reach = (4.0 / edge).ceil() as i32;
        let blocks: Vec<[i32; 3]> = (-reach..reach)
            .flat_map(|x| (-reach..reach).flat_map(move |y| (-reach..reach).map(move |z| [x, y, z])))
            .collect();
        let of_block = |block: &[i32; 3]| {
            let mut found = Vec::new();
            // No face of a tree lies on the lattice.
            let origin = DVec3::from(block.map(f64::from)) * edge + DVec3::new(0.001_234, 0.002_718, 0.003_141);
            self.cross(origin, edge, DEPTH, &mut found);
            found
        };
        blocks.par_iter().flat_map_iter(of_block).collect()
    }

    fn cross(&self, origin: DVec3, edge: f64, depth: i32, found: &mut Vec<DVec3>) {
        if self.value(origin + 0.5 * edge).abs() > 0.87 * edge {
            return;
        }
        if depth > 0 {
            for corner in Aabb::new(origin, origin + 0.5 * edge).corners() {
                self.cross(corner, 0.5 * edge, depth - 1, found);
            }
            return;
        }
        let inside = |at: DVec3| self.value(at) >= 0.0;
        for axis in DVec3::AXES {
            let [mut one, mut other] = [origin, origin + axis * edge];
            if inside(one) == inside(other) {
                continue;
            }
            for _ in 0..24 {
                let middle = 0.5 * (one + other);
                if inside(middle) == inside(one) { one = middle } else { other = middle }
            }
            // A jump of the sign within nothing is a sliver thinner than can be told.
            found.push(0.5 * (one + other));
        }
    }
}

fn leaf(kind: Kind, size: DVec3, at: DVec3) -> f64 {
    let corner = |x: f64, y: f64| x.max(y).min(0.0) + x.max(0.0).hypot(y.max(0.0));
    let across = at.x.hypot(at.y);
    match kind {
        Kind::Ball => size.x - at.length(),
        Kind::Cuboid => {
            let beyond = at.abs() - 0.5 * size;
            -(beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0))
        }
        Kind::Ellipsoid => (1.0 - (at / size).length()) * size.min_element(),
        Kind::Cylinder => -corner(across - size.x, at.z.abs() - 0.5 * size.y),
        Kind::Torus => size.y - (across - size.x).hypot(at.z),
    }
}

/// A tree under construction: the scene's text and the meaning, side by side.
struct Trees {
    random: Random,
    text: String,
    shapes: usize,
    spacing: f64,
}

impl Trees {
    fn name(&mut self) -> String {
        self.shapes += 1;
        format!("s{}", self.shapes)
    }

    fn leaf(&mut self, kind: Kind, size: DVec3, at: DVec3, degrees: DVec3) -> (String, Solid) {
        let name = self.name();
        let maker = match kind {
            Kind::Ball => format!("sphere = {}", size.x),
            Kind::Cuboid => format!("box = [{}, {}, {}]", size.x, size.y, size.z),
            Kind::Ellipsoid => format!("ellipsoid = [{}, {}, {}]", size.x, size.y, size.z),
            Kind::Cylinder => format!("cylinder = {}\nheight = {}", size.x, size.y),
            Kind::Torus => format!("torus = {}\ntube = {}", size.x, size.y),
        };
        self.text +=
            &format!("[shape.{name}]\n{maker}\nrotate = {:?}\nmove = {:?}\n", degrees.to_array(), at.to_array());
        let back = DAffine3::from_mat3_translation(rotation(degrees), at).inverse();
        (name, Solid::Leaf { kind, size, back })
    }

    fn random_leaf(&mut self) -> (String, Solid) {
        let kind = [Kind::Ball, Kind::Cuboid, Kind::Ellipsoid, Kind::Cylinder, Kind::Torus][self.random.below(5)];
        let mut three = |low: f64, high: f64| DVec3::from(std::array::from_fn(|_| self.random.between(low, high)));
        let size = match kind {
            Kind::Torus => DVec3::new(0.6, 0.25, 0.0),
            Kind::Cuboid => three(0.7, 1.4),
            _ => three(0.4, 0.8),
        };
        let (at, degrees) = (three(-0.4, 0.4), three(-90.0, 90.0));
        self.leaf(kind, size, at, degrees)
    }

    /// Two boxes along the axes with a face on the same plane.
    fn boxes_that_share_a_face(&mut self) -> [(String, Solid); 2] {
        let sizes: [DVec3; 2] =
            std::array::from_fn(|_| DVec3::from(std::array::from_fn(|_| self.random.between(0.4, 1.2))));
        let mut at: DVec3 = DVec3::from(std::array::from_fn(|_| self.random.between(-0.3, 0.3)));
        let (axis, sides) = (self.random.below(3), self.random.below(2));
        // The faces look the same way, or at one another.
        let way = if sides == 0 { 0.5 } else { -0.5 };
        at[axis] = 0.5 * sizes[0][axis] - way * sizes[1][axis];
        let first = self.leaf(Kind::Cuboid, sizes[0], DVec3::ZERO, DVec3::ZERO);
        [first, self.leaf(Kind::Cuboid, sizes[1], at, DVec3::ZERO)]
    }

    fn tree(&mut self, depth: usize) -> (String, Solid) {
        if depth == 0 {
            return self.random_leaf();
        }
        let operation = [Operation::Union, Operation::Intersection, Operation::Difference][self.random.below(3)];
        let operands = if self.random.next() < SHARED_FACES {
            self.boxes_that_share_a_face().into()
        } else {
            let second = self.random.below(depth);
            vec![self.tree(depth - 1), self.tree(second)]
        };
        let (names, operands): (Vec<String>, Vec<Solid>) = operands.into_iter().unzip();
        let name = self.name();
        let word = format!("{operation:?}").to_lowercase();
        self.text += &format!("[shape.{name}]\n{word} = {names:?}\n");
        let mut solid = Solid::Set(operation, operands);
        let step = match self.random.below(5) {
            0 => Some(Step::Offset(self.random.between(0.05, 0.2))),
            1 => Some(Step::Offset(-self.random.between(0.03, 0.1))),
            2 => Some(Step::Shell(self.random.between(0.15, 0.3))),
            _ => None,
        };
        if let Some(step) = step {
            self.text += &match step {
                Step::Offset(by) => format!("offset = {by}\n"),
                Step::Shell(thickness) => format!("shell = {thickness}\n"),
            };
            let boundary = PointTree::new(solid.boundary(self.spacing));
            solid = Solid::Stepped { of: Box::new(solid), boundary, step };
        }
        (name, solid)
    }
}

/// How many active voxels of a band there are, and how many of them are wrong.
fn judged(band: &Band, solid: &Solid, moved: DVec3) -> (usize, usize) {
    let voxel = band.lattice.voxel_size.get();
    let boundary = PointTree::new(solid.boundary(SPACING * voxel));
    let (near, slack) = (TOLERANCE * voxel, (SPACING + TOLERANCE) * voxel);
    let of_block = |block: usize| {
        let points = Points::of_block(band.origins[block], &band.lattice);
        let mut counts = (0, 0);
        for i in (0..BLOCK_VOXELS).filter(|&i| is_active(&band.active[block], i)) {
            let at = points.position(i) - moved;
            let (found, away) = (f64::from(band.distances[block][i]), boundary.nearest(at, None));
            let away = away.map_or(f64::MAX, |(_, nearest)| nearest.distance(at));
            let wrong_side = away > slack && (found >= 0.0) != (solid.value(at) >= 0.0);
            // Every point is one of the boundary; between them it may be nearer.
            let right = found.abs() <= away + near && found.abs() >= away - slack;
            counts.0 += 1;
            counts.1 += usize::from(wrong_side || !right);
        }
        counts
    };
    let sum = |a: (usize, usize), b: (usize, usize)| (a.0 + b.0, a.1 + b.1);
    (0..band.origins.len()).into_par_iter().map(of_block).reduce(|| (0, 0), sum)
}

#[test]
fn trees_with_offsets_and_walls_are_as_far_as_brute_force_says() {
    let mut baked = 0;
    for seed in 0..TREES {
        let spacing = SPACING_OF_OPERANDS * 2.5 / f64::from(RESOLUTION);
        let random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        let mut trees = Trees { random, text: String::new(), shapes: 0, spacing };
        (0..8).for_each(|_| _ = trees.random.next());
        let depth = 1 + trees.random.below(3);
        let (root, solid) = trees.tree(depth);
        // Another lattice for each.
        let moved = DVec3::from(std::array::from_fn(|_| trees.random.between(0.0, 0.07)));
        let text = format!(
            "[output]\nshape = 'root'\n[shape.root]\nunion = ['{root}']\nmove = {:?}\n{}",
            moved.to_array(),
            trees.text
        );
        let scene = match prepared_at(Sampling::Resolution(RESOLUTION), Default::default(), &text) {
            Ok(scene) => scene,
            Err(error) => {
                assert!(error.to_string().contains("nothing is inside"), "{error}\n{text}");
                assert_eq!(solid.boundary(spacing).len(), 0, "tree {seed}:\n{text}");
                continue;
            }
        };
        let (voxels, wrong) = judged(&band_of(&scene, 1), &solid, moved);
        assert!((wrong as f64) < BESIDE_CREASES * voxels as f64, "{wrong} of {voxels} voxels of tree {seed}:\n{text}");
        baked += 1;
    }
    assert!(baked > TREES / 2);
}
