//! Rigid motions, scalings, mirrors and other changes of space, folded into the leaves.

use std::collections::BTreeMap;
use std::fmt;

use glam::{DAffine3, DMat3, DVec3};

use super::facts::{Facts, moved_box};
use super::graph::{Graph, Node};
use super::leaf::{Affine, Quadric};
use super::op::Op;
use super::{Slope, op::Unary};

/// A change of space that cannot be undone: a scale of zero, an infinite or undefined entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotInvertible {
    /// The factor by which the map changes volumes.
    pub determinant: f64,
}

impl fmt::Display for NotInvertible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the transformation flattens space (it changes volumes by a factor of {}): ", self.determinant)?;
        write!(f, "scale by numbers other than zero")
    }
}

impl std::error::Error for NotInvertible {}

/// The least factor by which a linear map stretches a direction: the square root of the least eigenvalue of MᵀM.
fn least_stretch(matrix: &DMat3) -> f64 {
    let product = matrix.transpose() * *matrix;
    let column = |i: usize| product.col(i);
    let mean = (column(0).x + column(1).y + column(2).z) / 3.0;
    let off = column(0).y.powi(2) + column(0).z.powi(2) + column(1).z.powi(2);
    let spread = (column(0).x - mean).powi(2) + (column(1).y - mean).powi(2) + (column(2).z - mean).powi(2) + 2.0 * off;
    let size = (spread / 6.0).sqrt();
    if size <= 1e-14 * mean {
        return mean.sqrt();
    }
    // The roots of the characteristic cubic in its trigonometric form.
    let shifted = (product - DMat3::from_diagonal(DVec3::splat(mean))) * (1.0 / size);
    let angle = libm::acos((shifted.determinant() / 2.0).clamp(-1.0, 1.0)) / 3.0;
    let least = mean + 2.0 * size * libm::cos(angle + 2.0 * std::f64::consts::FRAC_PI_3);
    least.max(0.0).sqrt()
}

impl Graph {
    /// The node with every leaf replaced; what is known of nodes inside it is not carried along.
    fn replaced(
        &mut self,
        node: Node,
        mut affine: impl FnMut(&mut Self, Affine) -> Node,
        mut quadric: impl FnMut(&mut Self, Quadric) -> Node,
    ) -> Node {
        let mut reached = vec![node.0];
        let mut made: BTreeMap<u32, Node> = BTreeMap::new();
        while let Some(next) = reached.pop() {
            if made.insert(next, Node(next)).is_none() {
                self.ops[next as usize].arguments(|argument| reached.push(argument));
            }
        }
        // Arguments come before their operation.
        let order: Vec<u32> = made.keys().copied().collect();
        for index in order {
            let fresh = match self.ops[index as usize] {
                Op::Affine(leaf) => affine(self, self.affines[leaf as usize]),
                Op::Quadric(leaf) => quadric(self, self.quadrics[leaf as usize]),
                Op::External { leaf, at } => self.external(leaf, at.map(|argument| made[&argument])),
                Op::Unary(operation, a) => self.unary(operation, made[&a]),
                Op::Binary(operation, a, b) => self.binary(operation, made[&a], made[&b]),
                Op::Choose(arguments) => {
                    let [condition, then, other] = arguments.map(|argument| made[&argument]);
                    self.choose(condition, then, other)
                }
            };
            made.insert(index, fresh);
        }
        made[&node.0]
    }

    /// The solid moved by an affine map, own space to world. The value is scaled by the map's least stretch, so
    /// that a uniform scale keeps exact distances and no other map makes the slope larger.
    pub fn transform(&mut self, solid: Node, map: &DAffine3) -> Result<Node, NotInvertible> {
        let determinant = map.matrix3.determinant();
        let inverse = map.inverse();
        if determinant == 0.0 || !map.is_finite() || !inverse.is_finite() {
            return Err(NotInvertible { determinant });
        }
        let facts = self.facts(solid);
        let moved = self.replaced(
            solid,
            |graph, form| graph.affine_leaf(form.after(&inverse)),
            |graph, quadric| graph.quadric_leaf(quadric.after(&inverse)),
        );
        let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
        let lengths = columns.map(DVec3::length);
        let crossed = [(0, 1), (0, 2), (1, 2)]
            .iter()
            .any(|&(i, j)| columns[i].dot(columns[j]).abs() > 1e-12 * lengths[i] * lengths[j]);
        let uniform = !crossed && lengths.iter().all(|length| (length / lengths[0] - 1.0).abs() < 1e-12);
        if uniform && (lengths[0] - 1.0).abs() < 1e-12 {
            return Ok(self.declare(moved, facts.moved(map, 1.0)));
        }
        let least = if crossed { least_stretch(&map.matrix3) } else { lengths[0].min(lengths[1]).min(lengths[2]) };
        self.declare(moved, facts.moved(map, least));
        let node = self.linear(moved, least, 0.0);
        let slope = if uniform { facts.slope } else { Slope::Unknown };
        Ok(self.declare(node, Facts::new(None, slope)))
    }

    /// The solid moved along a vector.
    pub fn translate(&mut self, solid: Node, by: DVec3) -> Result<Node, NotInvertible> {
        self.transform(solid, &DAffine3::from_translation(by))
    }

    /// The solid turned: degrees about the fixed x, then y, then z axis.
    pub fn rotate(&mut self, solid: Node, degrees: DVec3) -> Result<Node, NotInvertible> {
        self.transform(solid, &DAffine3::from_mat3(rotation(degrees)))
    }

    /// The solid scaled along the axes; a negative factor mirrors.
    pub fn scale(&mut self, solid: Node, factors: DVec3) -> Result<Node, NotInvertible> {
        self.transform(solid, &DAffine3::from_scale(factors))
    }

    /// The half of a solid in `normal · p ≥ offset`, and its mirror image on the other side.
    pub fn mirror(&mut self, solid: Node, normal: DVec3, offset: f64) -> Node {
        let unit = normal.normalize_or_zero();
        let facts = self.facts(solid);
        let height = self.affine(unit, -offset);
        let folded = self.abs(height);
        // p + (|h| − h)·n read through c·p + k.
        let form = move |graph: &mut Self, form: Affine| {
            let along = form.slope.dot(unit);
            let flat = graph.affine(form.slope - unit * along, form.constant + along * offset);
            let risen = graph.linear(folded, along, 0.0);
            graph.add(flat, risen)
        };
        let node = self.replaced(solid, form, |graph, quadric| graph.expanded(quadric, form));
        let reflection =
            DAffine3::from_mat3_translation(DMat3::IDENTITY - outer(unit, unit) * 2.0, unit * (2.0 * offset));
        let bounds = facts.bounds.map(|bounds| bounds.union(moved_box(&bounds, &reflection)));
        let slope = match facts.slope {
            Slope::Exact { .. } => Slope::Lipschitz(1.0),
            slope => slope,
        };
        self.declare(node, Facts { bounds, slope, fall: facts.fall })
    }

    /// The node read at other coordinates: every x, y, z replaced by the given nodes.
    pub fn warp(&mut self, node: Node, coordinates: [Node; 3]) -> Node {
        let form = move |graph: &mut Self, form: Affine| {
            let mut sum = graph.constant(form.constant);
            for (coordinate, slope) in coordinates.into_iter().zip(form.slope.to_array()) {
                let part = graph.linear(coordinate, slope, 0.0);
                sum = graph.add(sum, part);
            }
            sum
        };
        self.replaced(node, form, |graph, quadric| graph.expanded(quadric, form))
    }

    /// A sum of squares with its forms replaced.
    fn expanded(&mut self, quadric: Quadric, mut form: impl FnMut(&mut Self, Affine) -> Node) -> Node {
        let mut sum = self.constant(quadric.constant);
        for (weight, term) in quadric.terms.into_iter().filter(|(weight, _)| *weight != 0.0) {
            let replaced = form(self, term);
            let square = self.square(replaced);
            let part = self.unary(Unary::Linear { scale: weight, offset: 0.0 }, square);
            sum = self.add(sum, part);
        }
        sum
    }
}

/// A turn about an axis of length 1, counterclockwise seen from its tip, by an angle in radians (Rodrigues), by sine and cosine
/// that are the same on every machine.
pub fn rotation_about(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

/// Degrees about the fixed x, then y, then z axis, as a matrix.
pub fn rotation(degrees: DVec3) -> DMat3 {
    let turned = |degrees: f64| {
        // Quarter turns are exact, so that boxes stay axis-aligned.
        let quarters = degrees / 90.0;
        if quarters.fract() == 0.0 {
            return [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarters.rem_euclid(4.0) as usize];
        }
        let angle = degrees.to_radians();
        (libm::sin(angle), libm::cos(angle))
    };
    let [(sx, cx), (sy, cy), (sz, cz)] = degrees.to_array().map(turned);
    let about_x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cx, sx), DVec3::new(0.0, -sx, cx));
    let about_y = DMat3::from_cols(DVec3::new(cy, 0.0, -sy), DVec3::Y, DVec3::new(sy, 0.0, cy));
    let about_z = DMat3::from_cols(DVec3::new(cz, sz, 0.0), DVec3::new(-sz, cz, 0.0), DVec3::Z);
    about_z * about_y * about_x
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
