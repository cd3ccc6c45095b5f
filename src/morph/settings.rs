//! What an artist sets on a morph.

use glam::DVec3;

use super::course::FLOW_TIME_SCALE;
use super::delay::Delay;
use super::error::Error;
use super::over_time::OverTime;
use super::section::{Round, Section};
use crate::attribute::ColourSpace;

/// How a morph runs.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How the shape changes.
    pub mode: Mode,
    /// The way that the objects are carried along while the shape changes, by the eased progress.
    pub carry: Carry,
    /// The scene times τ at which the shape starts and ends to change, within or beyond \[0, 1\].
    pub over: [f64; 2],
    /// How fast it changes on the way.
    pub ease: Ease,
    /// The scene times at which colour starts and ends to change.
    pub colour_over: [f64; 2],
    /// Colour runs on past its end (STTI's octopus effect): the second object's creeps outward.
    pub octopus: bool,
    /// STTI's α, ≥ 0: near 0 the shapes drive the colour, from 3 on time alone.
    pub alpha: OverTime<f64>,
    /// STTI's β in \[0, 1\]: below 0.5 the second object's colour comes sooner, above it the first's holds on longer.
    pub beta: OverTime<f64>,
    /// Where the two colours are mixed.
    pub colour_space: ColourSpace,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: Mode::Flow(Flow::default()),
            carry: Carry::None,
            over: [0.0, 1.0],
            ease: Ease::Linear,
            colour_over: [0.0, 1.0],
            octopus: false,
            alpha: 0.3.into(),
            beta: 0.5.into(),
            colour_space: ColourSpace::Auto,
        }
    }
}

/// How the shape changes.
#[derive(Clone, Debug)]
pub enum Mode {
    /// The volume goes evenly from one object's to the other's; a₀ follows from it.
    Flow(Flow),
    /// (1 − t)·f₁ + t·f₂ of the two distances.
    Linear(Pace),
    /// Both objects at once between the ends, by max.
    Union,
    /// The first object's all along; attributes alone go over (STTI §6.3).
    Still,
    /// All of the blend's parameters by hand, t as it comes; frames may be empty.
    Paper(OverTime<Paper>),
}

/// How a morph carries its objects along. Modes that blend neither in time nor in space, `union` and `still`, carry none.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Carry {
    /// Not: both stay where they are.
    #[default]
    None,
    /// From centre of volume to centre of volume.
    Centroid,
    /// The same, and by the least turn that takes the principal axes of the first object onto those of the second.
    Inertia,
    /// From places of the first object to those of the second, in the world as the shape starts and ends to change: by
    /// their middles, with two by the least turn besides, and with more by the turn that fits them best.
    Anchors(Vec<[DVec3; 2]>),
}

/// A morph that keeps to a volume.
#[derive(Clone, Debug)]
pub struct Flow {
    /// 0.05: one shape shrinks while the other grows; 0.5: separate objects flow through one body; 1.5: more so.
    pub bridge: OverTime<f64>,
    /// How t follows the morph's progress.
    pub pace: Pace,
    /// A factor on the volume over scene time, whatever ease and pace do to t; 1 at both ends of the span.
    pub volume: OverTime<f64>,
    /// Places that start later. The volume is then what comes of it.
    pub delay: Option<Delay>,
}

impl Default for Flow {
    fn default() -> Self {
        Self { bridge: 0.5.into(), pace: Pace::Even, volume: 1.0.into(), delay: None }
    }
}

/// How t follows the morph's progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Equal steps change equal volumes.
    Even,
    /// t is the progress itself, as in the papers.
    Time,
}

/// The parameters of space-time blending by hand, in units of D and of t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paper {
    /// The bounding slab's ends on the time axis.
    pub slab: [f64; 2],
    /// Units of D a unit of t is worth.
    pub time_scale: f64,
    /// a₀ to a₃.
    pub a: [f64; 4],
    /// Rounds each half-cylinder against its cutting plane first (heterogeneous STB, eq. 6).
    pub round: Option<Round>,
}

impl Default for Paper {
    fn default() -> Self {
        Self { slab: [0.0, 1.0], time_scale: 1.0, a: [1.0; 4], round: None }
    }
}

/// How fast progress is made.
#[derive(Clone, Debug)]
pub enum Ease {
    /// Evenly.
    Linear,
    /// Slowly at both ends: 3u² − 2u³.
    Smooth,
    /// The progress itself, in \[0, 1\], at each scene time of the span; it may rest and go back.
    Keyed(OverTime<f64>),
}

/// At how many times of the span a keyed ease is looked at, to find when it first reaches a progress. Fewer miss what
/// comes and goes within a few frames.
const EASE_STEPS: usize = 960;

impl Settings {
    /// The eased progress of shape at scene time τ, in \[0, 1\].
    pub(super) fn eased(&self, time: f64) -> f64 {
        let u = self.share(time);
        match &self.ease {
            Ease::Linear => u,
            Ease::Smooth => smooth(u),
            Ease::Keyed(progress) => progress.at(self.time_of(u)).clamp(0.0, 1.0),
        }
    }

    /// Where a scene time lies in the span of the shape's change, in \[0, 1\].
    pub(super) fn share(&self, time: f64) -> f64 {
        let [start, end] = self.over;
        ((time - start) / (end - start)).clamp(0.0, 1.0)
    }

    /// The scene time at a share of the span.
    pub(super) fn time_of(&self, share: f64) -> f64 {
        let [start, end] = self.over;
        start + share * (end - start)
    }

    /// For each progress, rising from 0 to 1, the share of the span at which it is first reached; 1 where it never is.
    pub(super) fn shares_of(&self, progress: &[f64]) -> Vec<f64> {
        if let Ease::Linear = self.ease {
            return progress.to_vec();
        }
        let step = |i: usize| i as f64 / EASE_STEPS as f64;
        let eased: Vec<f64> = (0..=EASE_STEPS).map(|i| self.eased(self.time_of(step(i)))).collect();
        let first = |progress: &f64| match eased.iter().position(|eased| eased >= progress) {
            None => 1.0,
            Some(0) => 0.0,
            Some(after) => {
                let (mut low, mut high) = (step(after - 1), step(after));
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    if self.eased(self.time_of(middle)) >= *progress { high = middle } else { low = middle }
                }
                high
            }
        };
        progress.iter().map(first).collect()
    }
}

/// 3u² − 2u³.
fn smooth(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

/// The slab, time scale and reach that keep the first and last frames alive and whole.
const FLOW_SLAB: [f64; 2] = [-1.0, 2.0];
const FLOW_REACH: f64 = 2.5;
/// The bridge at both ends of every morph, where the blend must end soon: the least a bridge can be.
const LEAST_BRIDGE: f64 = 0.05;

impl Flow {
    /// Whether nothing but t changes it.
    pub(super) fn is_still(&self) -> bool {
        self.bridge.is_still() && self.volume.is_still()
    }

    /// The section at t and scene time τ, with an a₀ still to be found.
    pub(super) fn section(&self, t: f64, time: f64) -> Section {
        let sin = libm::sin(std::f64::consts::PI * t);
        Section {
            t,
            time_scale: FLOW_TIME_SCALE,
            slab: FLOW_SLAB,
            a0: 0.0,
            a1: FLOW_REACH,
            a2: FLOW_REACH,
            a3: LEAST_BRIDGE + (self.bridge.at(time) - LEAST_BRIDGE) * sin * sin,
            round: None,
        }
    }
}

impl Paper {
    pub(super) fn section(&self, t: f64) -> Section {
        let [a0, a1, a2, a3] = self.a;
        Section { t, time_scale: self.time_scale, slab: self.slab, a0, a1, a2, a3, round: self.round }
    }
}

impl Settings {
    /// What is out of range, if anything is; what changes over time is looked at on the way.
    pub fn check(&self) -> Result<(), Error> {
        for (name, over) in [("over", self.over), ("color_over", self.colour_over)] {
            let spans = over.iter().all(|time| time.is_finite()) && over[0] < over[1];
            if !spans {
                return Err(Error::Span { name, from: over[0], to: over[1] });
            }
        }
        for step in 0..=CHECKS {
            let share = step as f64 / CHECKS as f64;
            let time = self.time_of(share);
            within("alpha", self.alpha.at(time), 0.0, 1e6)?;
            within("beta", self.beta.at(time), 0.0, 1.0)?;
            match &self.mode {
                Mode::Flow(flow) => flow.check(share, time)?,
                Mode::Paper(paper) => paper.at(time).check()?,
                Mode::Linear(_) | Mode::Union | Mode::Still => {}
            }
            if let Ease::Keyed(progress) = &self.ease {
                within("ease", progress.at(time), 0.0, 1.0)?;
            }
        }
        Ok(())
    }
}

/// Steps at which settings that change over time are checked.
const CHECKS: usize = 64;

impl Flow {
    fn check(&self, share: f64, time: f64) -> Result<(), Error> {
        within("bridge", self.bridge.at(time), LEAST_BRIDGE, 100.0)?;
        if share == 0.0 || share == 1.0 {
            within("volume at the ends", self.volume.at(time), 1.0, 1.0)?;
        }
        within("volume", self.volume.at(time), 1e-3, 100.0)
    }
}

impl Paper {
    fn check(&self) -> Result<(), Error> {
        within("time_scale", self.time_scale, 1e-6, 1e6)?;
        within("a0", self.a[0], -1e6, 1e6)?;
        for (name, value) in ["a1", "a2", "a3"].into_iter().zip(&self.a[1..]) {
            within(name, *value, 1e-6, 1e6)?;
        }
        if self.slab[0].partial_cmp(&self.slab[1]) != Some(std::cmp::Ordering::Less) {
            return Err(Error::Span { name: "slab", from: self.slab[0], to: self.slab[1] });
        }
        let Some(round) = self.round else { return Ok(()) };
        within("round.a0", round.a0, -1e6, 1e6)?;
        within("round.reach", round.reach, 1e-6, 1e6)?;
        within("round.a3", round.a3, 1e-6, 1e6)?;
        within("round.depth", round.depth, 0.0, 1e6)
    }
}

fn within(name: &'static str, value: f64, least: f64, most: f64) -> Result<(), Error> {
    if (least..=most).contains(&value) { Ok(()) } else { Err(Error::Setting { name, value, least, most }) }
}
