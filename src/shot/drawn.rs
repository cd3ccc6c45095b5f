//! What slices draw beside a frame's band: F and the distance to its zero set, as far as a picture goes. Of a shape of the plane
//! that nothing but being baked made a solid of, both are those of the plane.

use std::sync::Arc;

use crate::distance::method::{Choice, Request};
use crate::distance::nearest::Watch;
use crate::distance::octree::{Report, Settings};
use crate::distance::step::Stepped;
use crate::distance::without::Keep;
use crate::field::{Aabb, Field};
use crate::node::extent::box_of;
use crate::node::id::Stage;
use crate::node::measured::{BESIDE_SURFACE, measured_in_plane, outlined, smallest_cell};
use crate::node::model::{Content, Morph};
use crate::shot::error::Error;
use crate::shot::prepared::{Prepared, Ready};

/// F of a shape of the plane, and its box, of no height.
pub type InPlane = (Arc<dyn Field>, Aabb);

/// A distance that answers everywhere.
#[derive(Clone)]
pub struct Drawn {
    /// The distance, world units, positive inside, with the smooth step that the scene asks for.
    pub distance: Arc<dyn Field>,
    /// The tree that restores it; `None` where closest points are sought anew for each place.
    pub report: Option<Report>,
}

impl Prepared {
    /// The shape of the plane that a frame shows extruded, where nothing else makes a solid of it.
    ///
    /// # Errors
    /// What is wrong with the shape.
    pub fn in_plane(&self, frame: i64) -> Result<Option<InPlane>, Error> {
        match (&self.model.content, &self.content) {
            (Content::Morph(morphs), Ready::Morph(planned)) => {
                let Morph { displace, fill, cut, keep, .. } = &morphs[0];
                let is_bare = displace.is_none() && fill.is_none() && cut.is_none() && *keep == Keep::ALL;
                let time = self.model.shot.range.share(frame as f64);
                let shown = &planned[self.shown(frame as f64)].morph;
                Ok(is_bare.then(|| shown.in_plane(time)).flatten())
            }
            (Content::Shape(id), _) => {
                let Some(flat) = self.model.shape(*id).lifts else { return Ok(None) };
                let mut solids = self.base.at(self.model.moment(frame as f64), &self.variation);
                solids.in_plane(flat, Stage::Placed).map_err(|problem| self.model.error(problem))
            }
            _ => Ok(None),
        }
    }

    /// The distance of a frame in the plane, by what measures what is written.
    ///
    /// # Errors
    /// Why it cannot be measured, and that it was cancelled.
    pub fn distance_in_plane(&self, frame: i64, (field, aabb): &InPlane) -> Result<Drawn, Error> {
        // As good at the outline as what is measured for a band.
        let (choice, voxel) = (self.model.written_distance(), self.lattice.voxel_size.get());
        let not_measured = |error| self.not_measured(frame, &error);
        if choice == Choice::USUAL {
            let outlined = outlined(field, *aabb, voxel, &self.cancel).map_err(not_measured)?;
            return Ok(self.stepped(outlined, None));
        }
        let measured = measured_in_plane(choice, field, *aabb, BESIDE_SURFACE, voxel, &self.cancel);
        let measured = measured.map_err(not_measured)?;
        Ok(self.stepped(measured.distance, Some(measured.report)))
    }

    /// The distance to a frame's surface, by what measures what is written. Building it takes at most so many bytes.
    ///
    /// # Errors
    /// The same.
    pub fn distance(&self, frame: i64, field: &Arc<dyn Field>, limit: u64) -> Result<Drawn, Error> {
        let solid = box_of(field.as_ref()).map_err(|error| self.not_measured(frame, &error))?;
        let (choice, cell) = (self.model.written_distance(), smallest_cell(self.lattice.voxel_size.get(), &solid));
        let settings =
            Settings { memory_limit: usize::try_from(limit).unwrap_or(usize::MAX), ..Settings::new(solid, cell) };
        let request = Request { field, solid, detail: cell, settings: choice.settings(settings) };
        let measured = choice.method().measure(&request, &Watch { cancel: &self.cancel, progress: &|_| {} });
        let measured = measured.map_err(|error| self.not_measured(frame, &error))?;
        Ok(self.stepped(measured.distance, Some(*measured.object.report())))
    }

    fn stepped(&self, distance: Arc<dyn Field>, report: Option<Report>) -> Drawn {
        let step = self.model.written_step().map(|s| s * self.lattice.voxel_size.get());
        let distance = match step {
            Some(s) => Arc::new(Stepped { distance, s }),
            None => distance,
        };
        Drawn { distance, report }
    }

    fn not_measured(&self, frame: i64, error: &dyn std::fmt::Display) -> Error {
        if self.cancel.load(std::sync::atomic::Ordering::Relaxed) {
            return Error::Cancelled;
        }
        self.distance_problem(format!("frame {frame}: {error}"))
    }
}
