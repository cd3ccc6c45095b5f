//! Space-time blending that keeps to a volume.

use super::{Between, Mode, Pace};
use crate::morph::course::FLOW_TIME_SCALE;
use crate::morph::delay::Delay;
use crate::morph::error::{Error, within};
use crate::morph::over_time::OverTime;
use crate::morph::section::Section;

/// The slab and reach that keep the first and last frames alive and whole.
const SLAB: [f64; 2] = [-1.0, 2.0];
const REACH: f64 = 2.5;
/// The bridge at both ends of every morph, where the blend must end soon: the least a bridge can be.
const LEAST_BRIDGE: f64 = 0.05;

/// The volume goes evenly from one object's to the other's; a₀ follows from it.
#[derive(Clone, Debug)]
pub struct Volume {
    /// 0.05: one shape shrinks while the other grows; 0.5: separate objects flow through one body; 1.5: more so.
    pub bridge: OverTime<f64>,
    /// How t follows the morph's progress.
    pub pace: Pace,
    /// A factor on the volume over scene time, whatever ease and pace do to t; 1 at both ends of the span.
    pub volume: OverTime<f64>,
    /// Places that start later. The volume is then what comes of it.
    pub delay: Option<Delay>,
}

impl Default for Volume {
    fn default() -> Self {
        Self { bridge: 0.5.into(), pace: Pace::Even, volume: 1.0.into(), delay: None }
    }
}

impl Volume {
    /// Whether nothing but t changes it.
    pub(in crate::morph) fn is_still(&self) -> bool {
        self.bridge.is_still() && self.volume.is_still()
    }

    /// The section at t and scene time τ, with an a₀ still to be found.
    pub(in crate::morph) fn section(&self, t: f64, time: f64) -> Section {
        let sin = libm::sin(std::f64::consts::PI * t);
        Section {
            t,
            time_scale: FLOW_TIME_SCALE,
            slab: SLAB,
            a0: 0.0,
            a1: REACH,
            a2: REACH,
            a3: LEAST_BRIDGE + (self.bridge.at(time) - LEAST_BRIDGE) * sin * sin,
            round: None,
        }
    }
}

impl Mode for Volume {
    fn check(&self, share: f64, time: f64) -> Result<(), Error> {
        within("bridge", self.bridge.at(time), LEAST_BRIDGE, 100.0)?;
        if share == 0.0 || share == 1.0 {
            within("volume at the ends", self.volume.at(time), 1.0, 1.0)?;
        }
        within("volume", self.volume.at(time), 1e-3, 100.0)
    }

    fn pace(&self) -> Pace {
        self.pace
    }

    fn volume(&self) -> Option<&Volume> {
        Some(self)
    }

    fn between(&self, t: f64, time: f64) -> Between<'_> {
        Between::Enclosing(self.section(t, time))
    }
}
