//! `3v² − 2v³` of a value clamped to 0..1.

use super::*;

impl Operation<1> for Smooth {
    const NATURE: Nature = Nature { shortens: true, ..Nature::PLAIN };

    fn value(self, [a]: [f64; 1]) -> f64 {
        let a = a.clamp(0.0, 1.0);
        a * a * (3.0 - 2.0 * a)
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        let clamped = math::clamp01(a);
        (math::smooth(a), [6.0 * clamped * (1.0 - clamped)])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        a.rising(|end| self.value([end]))
    }

    /// 6v(1 − v) is at most 1.5.
    fn facts(self, [a]: [Facts; 1]) -> Facts {
        Facts::steep(a.steepness().map(|bound| 1.5 * bound))
    }
}
