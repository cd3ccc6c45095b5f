//! Numbers on a morph's frames, measured on its coarse grid.

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::motion::{Moved, Similarity};
use super::plan::{Morph, Solved};
use super::surfels::Surfels;
use super::volume::{Enclosing, difference, object_fractions, total};
use crate::distance::Distance;
use crate::grid::measure::median_of_moving;

/// Numbers on one frame, volumes in cubic world units, measured on the coarse grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameReport {
    /// Scene time τ.
    pub time: f64,
    /// STB's time t, of places that do not wait.
    pub t: f64,
    /// The blend's amount, of places that do not wait.
    pub a0: f64,
    /// The volume that the frame is to have; `None` where it is not aimed at: in other modes, and where places wait.
    pub target: Option<f64>,
    /// The volume that it has.
    pub volume: f64,
    /// What lies in this frame or in the one before, but not in both, as the frame sees it that moves with both objects; 0
    /// in the first.
    pub change: f64,
    /// Connected pieces.
    pub pieces: usize,
}

/// Numbers on a sequence of frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// One entry a frame, in order.
    pub frames: Vec<FrameReport>,
    /// The median of the changes of frames that change at all.
    pub median_change: f64,
    /// The largest change over the median; a morph without pops stays under 2.
    pub largest_over_median: f64,
}

impl Morph {
    /// Numbers on the frames at some scene times, in order.
    pub fn report(&self, times: &[f64]) -> Report {
        let measured: Vec<(FrameReport, Arc<Solved>)> = times.par_iter().map(|time| self.frame_report(*time)).collect();
        let cell = self.plan().grid.cell_volume();
        let changes: Vec<f64> = measured
            .par_windows(2)
            .map(|two| {
                let [before, after] = [&two[0].1.enclosing, &two[1].1.enclosing];
                difference(&before.fractions, &after.fractions) * cell
            })
            .collect();
        let mut frames: Vec<FrameReport> = measured.into_iter().map(|(frame, _)| frame).collect();
        for (frame, change) in frames.iter_mut().skip(1).zip(&changes) {
            frame.change = *change;
        }
        let volume = frames.iter().map(|frame| frame.volume).fold(0.0, f64::max);
        let median_change = median_of_moving(&changes, volume).unwrap_or(0.0);
        let largest = changes.iter().copied().fold(0.0, f64::max);
        let largest_over_median = if median_change > 0.0 { largest / median_change } else { 0.0 };
        Report { frames, median_change, largest_over_median }
    }

    /// The farthest that the surface goes from one scene time to another, world units, to a part of a cell of the coarse
    /// grid; what appears or vanishes counts by how far it is from the rest.
    pub fn displacement(&self, from: f64, to: f64) -> f64 {
        let of = |time| self.surfels.at(time, || self.surfels_at(time));
        let [from, to] = [from, to].map(of);
        from.farthest(&to)
    }

    /// The surface at scene time τ, in the world.
    fn surfels_at(&self, time: f64) -> Surfels {
        let (grid, field, common) = (&self.plan().grid, self.profile(time), self.common.motion.at(time));
        if self.common.is_world() {
            return Surfels::new(grid, field.as_ref());
        }
        let seen = Similarity::IDENTITY.seen_from(&common);
        Surfels::new(grid, &Moved::new(field, seen)).carried(&common)
    }

    /// Numbers on a frame that was made elsewhere, at scene time τ, from its distance and that of the frame before, `None`
    /// where there is nothing; and the farthest that the surface goes between them, 0 to or from nothing.
    pub fn report_of(&self, time: f64, distances: [Option<&dyn Distance>; 2]) -> (FrameReport, f64) {
        let grid = &self.plan().grid;
        let fractions = distances.map(|distance| match distance {
            Some(distance) => object_fractions(grid, &grid.sampled(distance, self.plan.unit), self.plan.unit),
            None => vec![0.0; grid.cell_count()],
        });
        let cell = grid.cell_volume();
        let [before, now] = &fractions;
        let numbers = FrameReport {
            time,
            t: self.settings.share(time),
            a0: 0.0,
            target: None,
            volume: total(now) * cell,
            change: difference(before, now) * cell,
            pieces: grid.pieces(now),
        };
        let farthest = match distances {
            [Some(before), Some(now)] => Surfels::new(grid, before).farthest(&Surfels::new(grid, now)),
            _ => 0.0,
        };
        (numbers, farthest)
    }

    /// The greatest distance of a place in either object, as they stand at the first scene time, from the other.
    pub fn greatest_way(&self) -> f64 {
        let measured = self.measured_at(self.settings.over[0]);
        let farthest = measured.first.iter().zip(&measured.second).fold(0.0, |farthest: f32, (one, two)| {
            let outside = |inside: f32, other: f32| if inside >= 0.0 { -other } else { 0.0 };
            farthest.max(outside(*one, *two)).max(outside(*two, *one))
        });
        // No cell's middle is farther from a corner of its than that.
        f64::from(farthest) * self.plan.unit + 0.5 * 3f64.sqrt() * self.plan.grid.edge()
    }

    /// Whether there is a place in both objects, as they stand at the first scene time, on the coarse grid.
    pub fn objects_meet(&self) -> bool {
        let measured = self.measured_at(self.settings.over[0]);
        measured.first.iter().zip(&measured.second).any(|(one, two)| *one >= 0.0 && *two >= 0.0)
    }

    fn frame_report(&self, time: f64) -> (FrameReport, Arc<Solved>) {
        let solved = self.solved(time);
        let Enclosing { a0, fractions } = &solved.enclosing;
        let cell = self.plan().grid.cell_volume();
        let aims = self.delay.is_none() && self.settings.mode.volume().is_some();
        let target = aims.then(|| solved.target * cell);
        let volume = total(fractions) * cell;
        let pieces = self.plan().grid.pieces(fractions);
        let (t, a0) = (self.time_at(time), *a0);
        (FrameReport { time, t, a0, target, volume, change: 0.0, pieces }, solved)
    }
}
