//! A shape turned by a quaternion.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat};

use crate::node::bend::Straight;
use crate::node::spec::{Spec, flat};
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// Turned by a quaternion.
pub const NODE: Spec = Spec {
    key: Key::new(
        "quaternion",
        Kind::Numbers,
        Nothing,
        "Turned by a quaternion, `[x, y, z, w]` with w its real part, of any length but 0.",
    ),
    formula: "f(q⁻¹·p·q)",
    example: "box = [0.6, 0.9, 1.2]\nquaternion = [0.2, 0.4, 0.1, 0.9]",
    bend: Some(|build| {
        let given = build.arguments().values("quaternion").cloned().unwrap_or_default();
        let numbers: Vec<f64> = given.into_iter().map(f64::from).collect();
        let wrong = |build: &dyn crate::node::spec::Build| {
            let problem = format!("`quaternion` of `{}` must be four numbers, not all of them 0", build.name());
            Problem::new(build.span(), problem).help("[x, y, z, w]")
        };
        let [x, y, z, w] = numbers[..] else { return Err(wrong(build)) };
        let quaternion = DQuat::from_xyzw(x, y, z, w);
        if quaternion.length() < 1e-9 {
            return Err(wrong(build));
        }
        let map = DAffine3::from_mat3(DMat3::from_quat(quaternion.normalize()));
        Ok(Arc::new(Straight::new(map).ok_or_else(|| flat(build, "quaternion"))?))
    }),
    ..Spec::PLAIN
};
