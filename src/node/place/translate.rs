//! A shape moved along the axes.

use std::sync::Arc;

use glam::DAffine3;

use crate::node::bend::Straight;
use crate::node::keys;
use crate::node::spec::{Spec, flat};

/// Moved along x, y and z.
pub const NODE: Spec = Spec {
    key: keys::MOVE,
    example: "box = 1\ndo = [{ move = [0.5, 0, 0] }, { twist = 60 }]",
    bend: Some(|build| {
        let map = DAffine3::from_translation(build.vector("move")?);
        Ok(Arc::new(Straight::new(map).ok_or_else(|| flat(build, "move"))?))
    }),
    ..Spec::PLAIN
};
