//! What an artist sets on a morph.

use std::sync::Arc;

use glam::DVec3;

use super::error::{Error, within};
use super::mode::Mode;
use super::mode::volume::Volume;
use super::over_time::OverTime;
use super::plane::Plane;
use crate::attribute::ColourSpace;

/// How a morph runs.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How the shape changes.
    pub mode: Arc<dyn Mode>,
    /// The way that the objects are carried along while the shape changes.
    pub carry: Carry,
    /// How fast they go along that way; `None`: by the eased progress.
    pub carry_ease: Option<Ease>,
    /// How far the middle of that way lies off the straight one, world units.
    pub arc: DVec3,
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
    /// The plane that both objects are shapes of; `None` of solids.
    pub plane: Option<Plane>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: Arc::new(Volume::default()),
            carry: Carry::None,
            carry_ease: None,
            arc: DVec3::ZERO,
            over: [0.0, 1.0],
            ease: Ease::Linear,
            colour_over: [0.0, 1.0],
            octopus: false,
            alpha: 0.3.into(),
            beta: 0.5.into(),
            colour_space: ColourSpace::Auto,
            plane: None,
        }
    }
}

/// How a morph carries its objects along. Modes that blend neither in time nor in space carry none.
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
        self.eased_by(&self.ease, time)
    }

    /// The progress along the way that carries the objects, in \[0, 1\].
    pub(super) fn carried(&self, time: f64) -> f64 {
        self.eased_by(self.carry_ease.as_ref().unwrap_or(&self.ease), time)
    }

    fn eased_by(&self, ease: &Ease, time: f64) -> f64 {
        let u = self.share(time);
        match ease {
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
            self.mode.check(share, time)?;
            for (name, ease) in [("ease", Some(&self.ease)), ("carry_ease", self.carry_ease.as_ref())] {
                if let Some(Ease::Keyed(progress)) = ease {
                    within(name, progress.at(time), 0.0, 1.0)?;
                }
            }
        }
        Ok(())
    }
}

/// Steps at which settings that change over time are checked.
const CHECKS: usize = 64;
