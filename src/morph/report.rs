//! Numbers on a morph's frames, measured on its coarse grid.

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::plan::{Morph, Solved};
use super::settings::Mode;
use super::surfels::Surfels;
use super::volume::{Enclosing, difference, total};

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
    /// What lies in this frame or in the one before, but not in both; 0 in the first.
    pub change: f64,
    /// Connected pieces.
    pub pieces: usize,
}

/// Numbers on a sequence of frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// One entry a frame, in order.
    pub frames: Vec<FrameReport>,
    /// The median of the changes.
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
        let mut sorted = changes;
        sorted.sort_by(f64::total_cmp);
        let median_change = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let largest = sorted.last().copied().unwrap_or(0.0);
        let largest_over_median = if median_change > 0.0 { largest / median_change } else { 0.0 };
        Report { frames, median_change, largest_over_median }
    }

    /// The farthest that the surface goes from one scene time to another, world units, to a part of a cell of the coarse
    /// grid; what appears or vanishes counts by how far it is from the rest.
    pub fn displacement(&self, from: f64, to: f64) -> f64 {
        let of = |time| self.surfels.at(time, || Surfels::new(&self.plan().grid, self.field(time).as_ref()));
        let [from, to] = [from, to].map(of);
        from.farthest(&to)
    }

    fn frame_report(&self, time: f64) -> (FrameReport, Arc<Solved>) {
        let solved = self.solved(time);
        let Enclosing { a0, fractions } = &solved.enclosing;
        let cell = self.plan().grid.cell_volume();
        let aims = self.delay.is_none() && matches!(self.settings.mode, Mode::Flow(_));
        let target = aims.then(|| solved.target * cell);
        let volume = total(fractions) * cell;
        let pieces = self.plan().grid.pieces(fractions);
        let (t, a0) = (self.time_at(time), *a0);
        (FrameReport { time, t, a0, target, volume, change: 0.0, pieces }, solved)
    }
}
