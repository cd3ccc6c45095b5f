//! Even pace: STB's time t over the morph's progress, such that equal steps change equal volumes.

use serde::{Deserialize, Serialize};

/// How often t is re-timed. One pass leaves steps several times the mean where the change is concentrated.
const PASSES: usize = 3;

/// A curve through points, rising wherever they rise and without overshoot (monotone cubic, harmonic mean slopes).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    points: Vec<[f64; 2]>,
}

impl Curve {
    /// The curve through points `[x, y]`. `None` where there are none, x does not rise or a number is not finite.
    pub fn through(points: Vec<[f64; 2]>) -> Option<Self> {
        let rising = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let finite = points.iter().flatten().all(|value| value.is_finite());
        (rising && finite && !points.is_empty()).then_some(Self { points })
    }

    /// y = x from 0 to 1.
    pub(super) fn line() -> Self {
        Self { points: vec![[0.0, 0.0], [1.0, 1.0]] }
    }

    /// The value at x; beyond the ends, theirs.
    pub fn at(&self, x: f64) -> f64 {
        let after = self.points.partition_point(|point| point[0] <= x);
        let (Some(left), Some(right)) = (after.checked_sub(1), self.points.get(after)) else {
            return self.points[after.min(self.points.len() - 1)][1];
        };
        let [x0, y0] = self.points[left];
        let [x1, y1] = *right;
        let width = x1 - x0;
        let s = (x - x0) / width;
        let (m0, m1) = (self.slope(left) * width, self.slope(after) * width);
        let rest = 1.0 - s;
        y0 * rest * rest * (1.0 + 2.0 * s) + y1 * s * s * (3.0 - 2.0 * s) + s * rest * (m0 * rest - m1 * s)
    }

    /// From each point to the next: the c of c₀ + s(c₁ + s(c₂ + s·c₃)) at the share s of the way.
    pub(super) fn pieces(&self) -> impl Iterator<Item = [f64; 4]> {
        self.points.windows(2).enumerate().map(|(i, pair)| {
            let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
            let [m0, m1] = [self.slope(i), self.slope(i + 1)].map(|slope| slope * (x1 - x0));
            cubic([y0, y1], [m0, m1])
        })
    }

    fn secant(&self, i: usize) -> f64 {
        let [[x0, y0], [x1, y1]] = [self.points[i], self.points[i + 1]];
        (y1 - y0) / (x1 - x0)
    }

    /// The harmonic mean of the secants on both sides, 0 at an extremum; at the ends, the one secant.
    fn slope(&self, i: usize) -> f64 {
        let last = self.points.len() - 1;
        if i == 0 || i == last {
            return if last == 0 { 0.0 } else { self.secant(i.min(last - 1)) };
        }
        let (before, after) = (self.secant(i - 1), self.secant(i));
        if before * after <= 0.0 { 0.0 } else { 2.0 * before * after / (before + after) }
    }
}

/// The c of c₀ + s(c₁ + s(c₂ + s·c₃)), s from 0 to 1, with these values and slopes by s at both ends.
pub(super) fn cubic([y0, y1]: [f64; 2], [m0, m1]: [f64; 2]) -> [f64; 4] {
    [y0, m0, 3.0 * (y1 - y0) - 2.0 * m0 - m1, 2.0 * (y0 - y1) + m0 + m1]
}

/// What re-timing came to.
pub(super) struct Even<T> {
    /// t at each sample.
    pub times: Vec<f64>,
    /// The change from each sample to the next.
    pub changes: Vec<f64>,
    /// What else was measured there.
    pub measured: T,
}

/// Re-times t so that the sum of changes runs as `progress` does (rising from 0 to 1, one entry a sample). `changes`
/// gives the change between neighbouring samples for t at each sample. The most even of all passes is kept.
pub(super) fn even<T>(progress: &[f64], changes: impl Fn(&[f64]) -> (Vec<f64>, T)) -> Even<T> {
    let measure = |times: Vec<f64>| {
        let (changes, measured) = changes(&times);
        Even { times, changes, measured }
    };
    let mut best = measure(progress.to_vec());
    let (mut last, mut last_changes) = (best.times.clone(), best.changes.clone());
    for _ in 0..PASSES {
        let Some(times) = retimed(progress, &last, &last_changes) else { break };
        let even = measure(times);
        (last, last_changes) = (even.times.clone(), even.changes.clone());
        if unevenness(progress, &even.changes) < unevenness(progress, &best.changes) {
            best = even;
        }
    }
    best
}

/// The times at which the sum of changes, linear between samples, reaches each share of the whole. `None` where
/// nothing changes.
fn retimed(progress: &[f64], times: &[f64], changes: &[f64]) -> Option<Vec<f64>> {
    let mut sums = vec![0.0];
    for change in changes {
        sums.push(sums[sums.len() - 1] + change);
    }
    let whole = sums[sums.len() - 1];
    if whole <= 0.0 {
        return None;
    }
    let mut out: Vec<f64> = progress.iter().map(|share| time_of(share * whole, &sums, times)).collect();
    let last = out.len() - 1;
    (out[0], out[last]) = (0.0, 1.0);
    Some(out)
}

fn time_of(sum: f64, sums: &[f64], times: &[f64]) -> f64 {
    let after = sums.partition_point(|s| *s <= sum).clamp(1, sums.len() - 1);
    let (s0, s1) = (sums[after - 1], sums[after]);
    let share = if s1 > s0 { ((sum - s0) / (s1 - s0)).clamp(0.0, 1.0) } else { 0.0 };
    times[after - 1] + (times[after] - times[after - 1]) * share
}

/// The largest change over what its share of the progress asks for.
fn unevenness(progress: &[f64], changes: &[f64]) -> f64 {
    let whole: f64 = changes.iter().sum();
    let share = |i: usize| (progress[i + 1] - progress[i]) * whole;
    (0..changes.len()).map(|i| if share(i) > 0.0 { changes[i] / share(i) } else { 0.0 }).fold(0.0, f64::max)
}
