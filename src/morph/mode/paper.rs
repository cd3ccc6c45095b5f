//! Space-time blending with the papers' numbers as they are given.

use super::{Between, Mode};
use crate::morph::error::{Error, within};
use crate::morph::over_time::OverTime;
use crate::morph::section::{Round, Section};

/// All of the blend's parameters by hand over scene time, t as it comes; frames may be empty.
#[derive(Clone, Debug)]
pub struct Paper(pub OverTime<Numbers>);

/// The parameters of space-time blending, in units of D and of t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// The bounding slab's ends on the time axis.
    pub slab: [f64; 2],
    /// Units of D a unit of t is worth.
    pub time_scale: f64,
    /// a₀ to a₃.
    pub a: [f64; 4],
    /// Rounds each half-cylinder against its cutting plane first (heterogeneous STB, eq. 6).
    pub round: Option<Round>,
}

impl Default for Numbers {
    fn default() -> Self {
        Self { slab: [0.0, 1.0], time_scale: 1.0, a: [1.0; 4], round: None }
    }
}

impl Numbers {
    /// The section at t.
    pub fn section(&self, t: f64) -> Section {
        let [a0, a1, a2, a3] = self.a;
        Section { t, time_scale: self.time_scale, slab: self.slab, a0, a1, a2, a3, round: self.round }
    }

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

impl Mode for Paper {
    fn check(&self, _share: f64, time: f64) -> Result<(), Error> {
        self.0.at(time).check()
    }

    fn between(&self, t: f64, time: f64) -> Between<'_> {
        Between::Section(self.0.at(time).section(t))
    }
}
