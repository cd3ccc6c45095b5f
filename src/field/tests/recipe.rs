//! Random solids as data, and their meaning in plain closures.

use glam::{DAffine3, DVec3};
use proptest::prelude::*;

use crate::field::{Blend, BlendBounds, Graph, Node, SetSystem, rotation};

/// How to make a solid.
#[derive(Clone, Debug)]
pub enum Recipe {
    Sphere(f64),
    Cuboid(DVec3),
    Ellipsoid(DVec3),
    Cylinder(f64, f64),
    Torus(f64, f64),
    Capsule(f64, f64),
    HalfSpace(DVec3, f64),
    Slab(DVec3, f64),
    Heart(f64),
    Union(SetSystem, Vec<Recipe>),
    Intersection(SetSystem, Vec<Recipe>),
    Difference(SetSystem, Box<Recipe>, Box<Recipe>),
    Blended(bool, Box<Recipe>, Box<Recipe>, Option<Box<Recipe>>),
    Offset(Box<Recipe>, f64),
    Shell(Box<Recipe>, f64),
    Placed(Box<Recipe>, DAffine3),
    Mirrored(Box<Recipe>, DVec3, f64),
}

const BLEND: (f64, [f64; 2], f64) = (0.3, [0.4, 0.7], 0.9);

impl Recipe {
    pub fn build(&self, graph: &mut Graph) -> Node {
        match self {
            Self::Sphere(radius) => graph.sphere(*radius),
            Self::Cuboid(edges) => graph.cuboid(*edges),
            Self::Ellipsoid(radii) => graph.ellipsoid(*radii),
            Self::Cylinder(radius, height) => graph.cylinder(*radius, *height),
            Self::Torus(major, minor) => graph.torus(*major, *minor),
            Self::Capsule(radius, length) => graph.capsule(*radius, *length),
            Self::HalfSpace(normal, offset) => graph.half_space(*normal, *offset),
            Self::Slab(normal, thickness) => graph.slab(*normal, *thickness),
            Self::Heart(width) => graph.heart(*width),
            Self::Union(system, parts) => {
                let parts: Vec<Node> = parts.iter().map(|part| part.build(graph)).collect();
                graph.union(*system, &parts)
            }
            Self::Intersection(system, parts) => {
                let parts: Vec<Node> = parts.iter().map(|part| part.build(graph)).collect();
                graph.intersection(*system, &parts)
            }
            Self::Difference(system, from, other) => {
                let (from, other) = (from.build(graph), other.build(graph));
                graph.difference(*system, from, &[other])
            }
            Self::Blended(union, a, b, within) => {
                let (a, b) = (a.build(graph), b.build(graph));
                let bounds = within.as_ref().map(|solid| BlendBounds { solid: solid.build(graph), weight: BLEND.2 });
                let blend = Blend { amount: BLEND.0, reach: BLEND.1, bounds };
                if *union { graph.blend_union(a, b, &blend) } else { graph.blend_intersection(a, b, &blend) }
            }
            Self::Offset(solid, distance) => {
                let solid = solid.build(graph);
                graph.offset(solid, *distance)
            }
            Self::Shell(solid, thickness) => {
                let solid = solid.build(graph);
                graph.shell(solid, *thickness)
            }
            Self::Placed(solid, map) => {
                let solid = solid.build(graph);
                graph.transform(solid, map).expect("recipes use invertible maps")
            }
            Self::Mirrored(solid, normal, offset) => {
                let solid = solid.build(graph);
                graph.mirror(solid, *normal, *offset)
            }
        }
    }

    /// F by the textbook. Insets of boxes are not in it: an expression measures their corners better.
    pub fn value(&self, p: DVec3) -> f64 {
        let across = p.truncate().length();
        let solid_box = |q: DVec3| -(q.max(DVec3::ZERO).length() + q.max_element().min(0.0));
        match self {
            Self::Sphere(radius) => radius - p.length(),
            Self::Cuboid(edges) => solid_box(p.abs() - *edges / 2.0),
            Self::Ellipsoid(radii) => (1.0 - (p / *radii).length()) * radii.min_element(),
            Self::Cylinder(radius, height) => {
                let (side, cap) = (across - radius, p.z.abs() - height / 2.0);
                -(side.max(0.0).hypot(cap.max(0.0)) + side.max(cap).min(0.0))
            }
            Self::Torus(major, minor) => minor - (across - major).hypot(p.z),
            Self::Capsule(radius, length) => radius - (p - DVec3::Z * p.z.clamp(-length / 2.0, length / 2.0)).length(),
            Self::HalfSpace(normal, offset) => offset - normal.normalize().dot(p),
            Self::Slab(normal, thickness) => thickness / 2.0 - normal.normalize().dot(p).abs(),
            Self::Heart(width) => heart(p, *width),
            Self::Union(system, parts) => {
                balanced(&parts.iter().map(|part| part.value(p)).collect::<Vec<_>>(), &|a, b| union(*system, a, b))
            }
            Self::Intersection(system, parts) => {
                balanced(&parts.iter().map(|part| part.value(p)).collect::<Vec<_>>(), &|a, b| -union(*system, -a, -b))
            }
            Self::Difference(system, from, other) => -union(*system, -from.value(p), other.value(p)),
            Self::Blended(is_union, a, b, within) => {
                let (a, b) = (a.value(p), b.value(p));
                let base = if *is_union { a + b + a.hypot(b) } else { a + b - a.hypot(b) };
                base + BLEND.0 * displacement(a, b, within.as_ref().map(|solid| solid.value(p)))
            }
            Self::Offset(solid, distance) => solid.value(p) + distance,
            Self::Shell(solid, thickness) => thickness / 2.0 - solid.value(p).abs(),
            Self::Placed(solid, map) => {
                let m = map.matrix3;
                // Recipes turn, then scale: the columns of the inverse's rows are the scaled axes.
                let least =
                    [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length()).into_iter().fold(f64::MAX, f64::min);
                solid.value(map.inverse().transform_point3(p)) * least
            }
            Self::Mirrored(solid, normal, offset) => {
                let unit = normal.normalize();
                let height = unit.dot(p) - offset;
                solid.value(p + unit * (height.abs() - height))
            }
        }
    }

    /// Whether an inset reaches a corner somewhere below.
    pub fn has_inset(&self) -> bool {
        self.any(&|recipe| matches!(recipe, Self::Offset(_, distance) if *distance < 0.0))
    }

    /// Whether there is an operation of R_m somewhere below.
    pub fn has_power(&self) -> bool {
        self.any(&|recipe| {
            matches!(
                recipe,
                Self::Union(SetSystem::Rm { .. }, _)
                    | Self::Intersection(SetSystem::Rm { .. }, _)
                    | Self::Difference(SetSystem::Rm { .. }, ..)
            )
        })
    }

    /// Whether this is so of it or of something below.
    fn any(&self, is: &dyn Fn(&Self) -> bool) -> bool {
        is(self)
            || match self {
                Self::Union(_, parts) | Self::Intersection(_, parts) => parts.iter().any(|part| part.any(is)),
                Self::Difference(_, a, b) => a.any(is) || b.any(is),
                Self::Blended(_, a, b, within) => {
                    a.any(is) || b.any(is) || within.as_ref().is_some_and(|within| within.any(is))
                }
                Self::Offset(solid, _) | Self::Shell(solid, _) | Self::Placed(solid, _) | Self::Mirrored(solid, ..) => {
                    solid.any(is)
                }
                _ => false,
            }
    }
}

fn union(system: SetSystem, a: f64, b: f64) -> f64 {
    match system {
        SetSystem::R0 => a + b + a.hypot(b),
        SetSystem::Rm { order } => (a + b + a.hypot(b)) * a.hypot(b).powi(order as i32),
        SetSystem::MinMax => a.max(b),
        SetSystem::Cn { order } => {
            let norm = (a.abs().powi(order as i32) + b.abs().powi(order as i32)).powf(1.0 / f64::from(order));
            match (a > 0.0, b > 0.0) {
                (true, true) => norm,
                (false, false) => {
                    if norm > 0.0 {
                        -(a * b) / norm
                    } else {
                        0.0
                    }
                }
                _ => a.max(b),
            }
        }
    }
}

fn balanced(values: &[f64], operation: &dyn Fn(f64, f64) -> f64) -> f64 {
    match values {
        [one] => *one,
        _ => {
            let (first, second) = values.split_at(values.len().div_ceil(2));
            operation(balanced(first, operation), balanced(second, operation))
        }
    }
}

fn displacement(a: f64, b: f64, within: Option<f64>) -> f64 {
    let near = (a / BLEND.1[0]).powi(2) + (b / BLEND.1[1]).powi(2);
    let Some(within) = within else { return 1.0 / (1.0 + near) };
    if within <= 0.0 {
        return 0.0;
    }
    let r2 = near / (near + (within / BLEND.2).powi(2));
    (1.0 - r2).powi(3) / (1.0 + r2)
}

/// The sextic's cube-root form, scaled by its measured extents.
fn heart(p: DVec3, width: f64) -> f64 {
    let scale = width / 2.0 / 1.112232079605079;
    let q = p / scale + DVec3::Z * ((1.171216502998138 - 1.0) / 2.0);
    let root = (q.x * q.x + 9.0 / 80.0 * q.y * q.y + 1e-3).cbrt() - 0.1;
    (q.z * root - (q.x * q.x + 2.25 * q.y * q.y + q.z * q.z - 1.0)) * scale / 2.5
}

fn direction() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0, -1.0..1.0, 0.1..1.0f64].prop_map(DVec3::from)
}

fn sizes() -> impl Strategy<Value = DVec3> {
    [0.3..1.6, 0.3..1.6, 0.3..1.6f64].prop_map(DVec3::from)
}

fn map() -> impl Strategy<Value = DAffine3> {
    let angles = [-180.0..180.0, -180.0..180.0, -180.0..180.0f64].prop_map(DVec3::from);
    let shift = [-0.8..0.8, -0.8..0.8, -0.8..0.8f64].prop_map(DVec3::from);
    let scale = prop_oneof![Just(DVec3::ONE), (0.6..1.5f64).prop_map(DVec3::splat), sizes()];
    (angles, shift, scale).prop_map(|(angles, shift, scale)| {
        DAffine3::from_mat3_translation(rotation(angles) * glam::DMat3::from_diagonal(scale), shift)
    })
}

fn system() -> impl Strategy<Value = SetSystem> {
    prop_oneof![
        4 => Just(SetSystem::R0),
        4 => Just(SetSystem::MinMax),
        2 => (2..5u32).prop_map(|order| SetSystem::Cn { order }),
        1 => (1..3u32).prop_map(|order| SetSystem::Rm { order }),
    ]
}

fn primitive() -> impl Strategy<Value = Recipe> {
    prop_oneof![
        (0.3..1.2f64).prop_map(Recipe::Sphere),
        sizes().prop_map(Recipe::Cuboid),
        sizes().prop_map(Recipe::Ellipsoid),
        (0.2..0.9f64, 0.3..1.8f64).prop_map(|(radius, height)| Recipe::Cylinder(radius, height)),
        (0.5..0.9f64, 0.1..0.4f64).prop_map(|(major, minor)| Recipe::Torus(major, minor)),
        (0.2..0.5f64, 0.2..1.2f64).prop_map(|(radius, length)| Recipe::Capsule(radius, length)),
        (direction(), -0.5..0.5f64).prop_map(|(normal, offset)| Recipe::HalfSpace(normal, offset)),
        (direction(), 0.2..1.0f64).prop_map(|(normal, thickness)| Recipe::Slab(normal, thickness)),
        (0.6..2.0f64).prop_map(Recipe::Heart),
    ]
}

/// Solids of a few operations, about two units wide.
pub fn recipe() -> impl Strategy<Value = Recipe> {
    primitive().prop_recursive(4, 12, 3, |inner| {
        let boxed = || inner.clone().prop_map(Box::new);
        prop_oneof![
            3 => (boxed(), map()).prop_map(|(solid, map)| Recipe::Placed(solid, map)),
            2 => (system(), prop::collection::vec(inner.clone(), 1..4)).prop_map(|(s, parts)| Recipe::Union(s, parts)),
            2 => (system(), prop::collection::vec(inner.clone(), 1..4))
                .prop_map(|(s, parts)| Recipe::Intersection(s, parts)),
            2 => (system(), boxed(), boxed()).prop_map(|(s, a, b)| Recipe::Difference(s, a, b)),
            1 => (any::<bool>(), boxed(), boxed(), prop::option::of(boxed()))
                .prop_map(|(union, a, b, within)| Recipe::Blended(union, a, b, within)),
            1 => (boxed(), -0.15..0.3f64).prop_map(|(solid, distance)| Recipe::Offset(solid, distance)),
            1 => (boxed(), 0.05..0.3f64).prop_map(|(solid, thickness)| Recipe::Shell(solid, thickness)),
            1 => (boxed(), direction(), -0.3..0.3f64).prop_map(|(solid, n, d)| Recipe::Mirrored(solid, n, d)),
        ]
    })
}
