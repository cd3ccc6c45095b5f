//! A shape made larger or smaller.

use std::sync::Arc;

use glam::DAffine3;

use crate::node::bend::Straight;
use crate::node::keys;
use crate::node::spec::{Spec, flat};

/// Scaled about the origin.
pub const NODE: Spec = Spec {
    key: keys::SCALE,
    example: "box = 0.7\ndo = [{ scale = [1, 1, 2] }, { twist = 60 }]",
    bend: Some(|build| {
        let map = DAffine3::from_scale(build.vector("scale")?);
        Ok(Arc::new(Straight::new(map).ok_or_else(|| flat(build, "scale"))?))
    }),
    ..Spec::PLAIN
};
