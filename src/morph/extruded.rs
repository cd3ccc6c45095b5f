//! What is between shapes of the plane as a solid.

use std::sync::Arc;

use glam::DVec3;

use super::motion::{Moved, Similarity};
use super::object::MorphObject;
use super::plan::{Morph, Stage};
use super::plane::Plane;
use crate::field::{Aabb, Expression, Field, Graph, Slope};

impl Morph {
    /// Whether its objects are shapes of the plane.
    pub fn is_of_plane(&self) -> bool {
        self.settings.plane.is_some()
    }

    /// What it shows at scene time τ within its plane, and its box at z = 0, of no height; `None` of solids, and where the plane
    /// is turned against that.
    pub fn in_plane(&self, time: f64) -> Option<(Arc<dyn Field>, Aabb)> {
        let plane = self.settings.plane?;
        if self.common.motion.at(time).normal().abs() != DVec3::Z {
            return None;
        }
        let aabb = self.box_extruded(&plane, time)?;
        Some((self.profile(time), aabb.at_z(0.0)))
    }

    /// The box of what is extruded at scene time τ.
    fn box_extruded(&self, plane: &Plane, time: f64) -> Option<Aabb> {
        let own = |object: &MorphObject| {
            let aabb = object.motion.at(time).box_to_world(object.own_box()?);
            Some(plane.extruded(aabb, self.common.motion.at(time).normal()))
        };
        match self.stage(time) {
            Stage::From => own(&self.from),
            Stage::To => own(&self.to),
            // That of the coarse grid, to within a cell.
            Stage::Between(_) => Some(self.extent().grown(self.plan.grid.edge())),
        }
    }

    /// A field of the plane at scene time τ as a solid; the field itself where the objects are solids.
    pub(super) fn extruded(&self, profile: Arc<dyn Field>, time: f64) -> Arc<dyn Field> {
        let Some(plane) = self.settings.plane else { return profile };
        let stands = self.common.motion.at(time);
        let slope = match profile.slope() {
            // The corner with the caps keeps what is exact on each side.
            exact @ Slope::Exact { .. } => exact,
            _ => Slope::Unknown,
        };
        let mut graph = Graph::new();
        let mut caps = graph.slab(DVec3::Z, plane.height);
        if stands != Similarity::IDENTITY {
            let own: Arc<dyn Field> = Arc::new(Expression::new(&graph, caps).keeping_values());
            caps = graph.field(Arc::new(Moved::new(own, stands)));
        }
        let profile = graph.field(profile);
        let solid = graph.corner(profile, caps);
        let solid = graph.sloped(solid, slope, self.box_extruded(&plane, time));
        Arc::new(Expression::new(&graph, solid))
    }
}
