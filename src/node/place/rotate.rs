//! A shape turned about the axes.

use std::sync::Arc;

use glam::DAffine3;

use crate::field::rotation;
use crate::node::bend::Straight;
use crate::node::keys;
use crate::node::spec::{Spec, flat};

/// Turned about the fixed x, then y, then z axis.
pub const NODE: Spec = Spec {
    key: keys::ROTATE,
    example: "box = 1\ndo = [{ rotate = [0, 30, 45] }, { twist = 60 }]",
    bend: Some(|build| {
        let map = DAffine3::from_mat3(rotation(build.vector("rotate")?));
        Ok(Arc::new(Straight::new(map).ok_or_else(|| flat(build, "rotate"))?))
    }),
    ..Spec::PLAIN
};
