//! OpenVDB's own morph of a scene's two objects: its level sets, run from frame to frame.
//!
//! It has a state that each frame is made from, so a frame by itself takes all frames before it; its steps always end at
//! whole frames, so that the frame is the same whichever others are asked for.

use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use crate::distance::band::{self, Feet, Settings, measure};
use crate::distance::method::Choice;
use crate::distance::{Distance, SampledLevelSet};
use crate::field::{Field, Interval};
use crate::grid::Lattice;
use crate::vdb::{self, LevelSet};

use crate::node::extent::box_of;
use crate::node::measured::measured;
use crate::node::model::{Model, Morph};
use crate::shot::morphing::Planned;
use crate::shot::stop::Stop;
use crate::text::frames::FrameRange;
use crate::text::problem::Problem;
use crate::text::source::Span;

/// The least half-width, in voxels, that OpenVDB's morph runs in: what its own tools make.
const LEAST_HALF_WIDTH: f32 = 3.0;
/// How near to the target the surface is to come to rest, in voxels.
const REST: f64 = 0.05;
/// How many states are kept: of two frames in flight, of the one before them, and of the frame before each of these.
const KEPT: usize = 6;
/// Level sets that there are at most at one time: the two objects', those kept, OpenVDB's three while it takes a step,
/// the fields of frames in flight and of the frame before, and what they are copied from.
const AT_ONCE: u64 = 2 + KEPT as u64 + 3 + 3 + 1;

/// The level sets of a morph by OpenVDB.
pub(crate) struct LevelSets {
    over: FrameRange,
    from: LevelSet,
    to: LevelSet,
    /// OpenVDB's time from one frame to the next.
    pub step: f64,
    cancel: Arc<AtomicBool>,
    /// By frame, the last one made first.
    kept: Mutex<VecDeque<(i64, LevelSet)>>,
    bytes: u64,
    span: Span,
}

impl LevelSets {
    /// Measures both objects on a lattice and finds how long OpenVDB's morph takes.
    pub fn new(
        model: &Model,
        morph: &Morph,
        planned: &Planned,
        lattice: Lattice,
        half_width: f32,
        cancel: Arc<AtomicBool>,
    ) -> Result<Self, Stop> {
        let half_width = half_width.max(LEAST_HALF_WIDTH);
        let voxel = lattice.voxel_size.get();
        let level_set = |frame: i64| -> Result<LevelSet, Stop> {
            let problem = |error: String| Stop::Problem(Problem::new(morph.span, format!("frame {frame}: {error}")));
            let field = planned.morph.field(model.shot.range.share(frame as f64));
            let solid = box_of(field.as_ref()).map_err(|error| problem(error.to_string()))?;
            let region = solid.grown((f64::from(half_width) + 2.0) * voxel);
            let settings =
                Settings { lattice, half_width, region, feet: Feet::Nearest, cancel: &cancel, progress: &|_| () };
            let measured = measure(field.as_ref(), &settings, || |_: &_| ()).map_err(|error| match error {
                band::Error::Cancelled => Stop::Cancelled,
                error => problem(error.to_string()),
            })?;
            LevelSet::new(&measured.band).map_err(|error| problem(error.to_string()))
        };
        let FrameRange { first, last } = morph.over;
        let (from, to) = (level_set(first)?, level_set(last)?);
        // No place is farther from the other object than that, and the surface moves by the half-width a unit of time
        // down to the last half-width, which it then closes by a share of e.
        let way = planned.morph.greatest_way();
        let duration = way / (f64::from(half_width) * voxel) + (f64::from(half_width) / REST).ln();
        let library = |error: vdb::Error| Stop::Problem(Problem::new(morph.span, error.to_string()));
        let bytes = from.bytes().map_err(library)?.max(to.bytes().map_err(library)?) * AT_ONCE;
        Ok(Self {
            over: morph.over,
            from,
            to,
            step: duration / (last - first) as f64,
            cancel,
            kept: Mutex::new(VecDeque::with_capacity(KEPT)),
            bytes,
            span: morph.span,
        })
    }

    /// Whether a frame is OpenVDB's: from the second of the morph to its last.
    pub fn show(&self, frame: i64) -> bool {
        self.over.first < frame && frame <= self.over.last
    }

    /// Memory that they take at most, in bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The field of a frame of the morph.
    pub fn field(&self, frame: i64) -> Result<Arc<dyn Field>, Stop> {
        let set = self.at(frame)?;
        let band = set.band().map_err(|error| self.problem(frame, &error))?;
        Ok(Arc::new(SampledLevelSet::new(band)))
    }

    /// The distance of a frame of the morph everywhere, in cells of that size; `None` where nothing is left.
    pub fn distance(&self, frame: i64, cell: f64) -> Result<Option<Arc<dyn Distance>>, Stop> {
        let field = self.field(frame)?;
        let Ok(solid) = box_of(field.as_ref()) else { return Ok(None) };
        let problem = |error: String| Problem::new(self.span, format!("frame {frame}: {error}"));
        let distance = measured(Choice::USUAL, &field, solid, Interval::ZERO, cell, None, &self.cancel);
        distance.map(Some).map_err(|error| Stop::of_measuring(&error, problem))
    }

    /// OpenVDB's level set at a frame. One thread at a time goes on; it waits for none of ours meanwhile.
    fn at(&self, frame: i64) -> Result<LevelSet, Stop> {
        let frame = frame.clamp(self.over.first, self.over.last);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let before = kept.iter().filter(|(known, _)| *known <= frame).max_by_key(|(known, _)| *known);
        let (mut now, mut set) = before.cloned().unwrap_or_else(|| (self.over.first, self.from.clone()));
        while now < frame {
            let next = set.morphed(&self.to, self.step, &self.cancel).map_err(|error| self.problem(now + 1, &error))?;
            let next = next.ok_or(Stop::Cancelled)?;
            (now, set) = (now + 1, next);
            // The frame and the one before it, which numbers on the way from there to here are taken from.
            if now + 1 >= frame {
                kept.truncate(KEPT - 1);
                kept.push_front((now, set.clone()));
            }
        }
        Ok(set)
    }

    fn problem(&self, frame: i64, error: &vdb::Error) -> Stop {
        Stop::Problem(Problem::new(self.span, format!("frame {frame}: {error}")))
    }
}
