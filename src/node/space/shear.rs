//! A shape sheared.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::node::bend::Straight;
use crate::node::spec::{Spec, flat};
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};

/// Sheared.
pub const NODE: Spec = Spec {
    key: Key::new(
        "shear",
        Kind::Vector,
        Nothing,
        "Leans the shape over: how far x goes for each unit of y, x for each unit of z, and y for each unit of z.",
    ),
    formula: "f(S⁻¹·p)·σ, σ the least stretch of S",
    example: "box = 0.9\nshear = [0, 0.6, 0]",
    bend: Some(|build| {
        let [x_by_y, x_by_z, y_by_z] = build.vector("shear")?.to_array();
        let matrix = DMat3::from_cols(DVec3::X, DVec3::new(x_by_y, 1.0, 0.0), DVec3::new(x_by_z, y_by_z, 1.0));
        Ok(Arc::new(Straight::new(DAffine3::from_mat3(matrix)).ok_or_else(|| flat(build, "shear"))?))
    }),
    ..Spec::PLAIN
};
