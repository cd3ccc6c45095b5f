//! Numbers by keys: values at frames, and how one goes over into the next.

/// Values at frames with a rule for what lies between.
#[derive(Clone, Debug, PartialEq)]
pub struct Keys {
    /// At least one, frames rising.
    pub keys: Vec<Key>,
    /// What lies between.
    pub ease: Ease,
}

/// A value at a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The frame.
    pub frame: f64,
    /// The value there.
    pub value: f64,
    /// Bezier: the handle towards the key before, `[frames ≤ 0, value]` from here; `None` is found by itself.
    pub before: Option<[f64; 2]>,
    /// Bezier: the handle towards the next key, `[frames ≥ 0, value]` from here; `None` is found by itself.
    pub after: Option<[f64; 2]>,
}

/// How a value goes from one key to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ease {
    /// Straight.
    Linear,
    /// Starts and ends at rest: 3u² − 2u³.
    Smooth,
    /// Starts at rest: u².
    In,
    /// Ends at rest: 1 − (1 − u)².
    Out,
    /// Stays until the next key.
    Hold,
    /// A Bezier curve through all keys. Handles that are not given are a third of the way to the neighbour long and
    /// level at the first key, at the last and wherever the value turns; elsewhere they have the harmonic mean of the
    /// slopes on both sides, so that nothing overshoots (Fritsch and Butland 1984).
    Bezier,
}

impl Ease {
    /// The names in a scene, with what they stand for.
    pub const NAMES: [(&'static str, Self); 6] = [
        ("linear", Self::Linear),
        ("smooth", Self::Smooth),
        ("in", Self::In),
        ("out", Self::Out),
        ("hold", Self::Hold),
        ("bezier", Self::Bezier),
    ];
}

impl Keys {
    /// The value at a frame; before the first key and after the last one theirs.
    pub fn at(&self, frame: f64) -> f64 {
        let next = self.keys.partition_point(|key| key.frame <= frame);
        if next == 0 {
            return self.keys[0].value;
        }
        let from = self.keys[next - 1];
        let Some(to) = self.keys.get(next) else { return from.value };
        let u = (frame - from.frame) / (to.frame - from.frame);
        let share = match self.ease {
            Ease::Linear => u,
            Ease::Smooth => u * u * (3.0 - 2.0 * u),
            Ease::In => u * u,
            Ease::Out => u * (2.0 - u),
            Ease::Hold => 0.0,
            Ease::Bezier => return self.bezier(next, frame),
        };
        from.value + (to.value - from.value) * share
    }

    /// The Bezier curve between the key before `next` and `next` itself.
    fn bezier(&self, next: usize, frame: f64) -> f64 {
        let (from, to) = (self.keys[next - 1], self.keys[next]);
        let third = (to.frame - from.frame) / 3.0;
        let [out_frames, out_value] = from.after.unwrap_or_else(|| [third, self.slope(next - 1) * third]);
        let [in_frames, in_value] = to.before.unwrap_or_else(|| [-third, -self.slope(next) * third]);
        let frames = [from.frame, from.frame + out_frames, to.frame + in_frames, to.frame];
        let values = [from.value, from.value + out_value, to.value + in_value, to.value];
        // Handles stay between their keys, so frames rise along the curve.
        let (mut low, mut high) = (0.0, 1.0);
        if from.after.is_none() && to.before.is_none() {
            low = (frame - from.frame) / (to.frame - from.frame);
            high = low;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if cubic(frames, middle) <= frame { low = middle } else { high = middle }
        }
        cubic(values, 0.5 * (low + high))
    }

    /// The slope of a handle that is found by itself, value a frame.
    fn slope(&self, i: usize) -> f64 {
        let secant = |i: usize| {
            let (from, to) = (self.keys[i], self.keys[i + 1]);
            (to.value - from.value) / (to.frame - from.frame)
        };
        if i == 0 || i + 1 == self.keys.len() {
            return 0.0;
        }
        let (before, after) = (secant(i - 1), secant(i));
        if before * after <= 0.0 { 0.0 } else { 2.0 * before * after / (before + after) }
    }

    /// Whether the value is not the same at all frames.
    pub fn vary(&self) -> bool {
        let first = self.keys[0].value;
        let bulges = |handle: Option<[f64; 2]>| handle.is_some_and(|[_, value]| value != 0.0);
        self.keys.iter().any(|key| key.value != first || bulges(key.before) || bulges(key.after))
    }
}

/// A cubic Bezier curve's coordinate at s in \[0, 1\], from its four control points.
fn cubic([a, b, c, d]: [f64; 4], s: f64) -> f64 {
    let rest = 1.0 - s;
    a * rest * rest * rest + 3.0 * s * rest * (b * rest + c * s) + d * s * s * s
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(points: &[(f64, f64)]) -> Keys {
        let key = |&(frame, value): &(f64, f64)| Key { frame, value, before: None, after: None };
        Keys { keys: points.iter().map(key).collect(), ease: Ease::Bezier }
    }

    #[test]
    fn two_keys_are_smooth() {
        let keys = keys(&[(1.0, 2.0), (49.0, 6.0)]);
        for step in 0..=48 {
            let u = f64::from(step) / 48.0;
            let smooth = 2.0 + 4.0 * u * u * (3.0 - 2.0 * u);
            assert!((keys.at(1.0 + f64::from(step)) - smooth).abs() < 1e-12);
        }
    }

    /// Through every key, rising where they rise, never beyond two neighbours, without a corner.
    #[test]
    fn a_curve_does_not_overshoot() {
        let points = [(0.0, 0.0), (5.0, 0.1), (9.0, 0.9), (20.0, 1.0), (21.0, 0.3), (40.0, 0.3), (50.0, 0.0)];
        let keys = keys(&points);
        for pair in points.windows(2) {
            let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
            assert_eq!([keys.at(x0), keys.at(x1)], [y0, y1]);
            let mut last = y0;
            for step in 1..200 {
                let now = keys.at(x0 + (x1 - x0) * f64::from(step) / 200.0);
                assert!((now - last) * (y1 - y0) >= -1e-12 && (now - y0) * (now - y1) <= 1e-12, "{now} after {last}");
                last = now;
            }
        }
        for &(x, y) in &points[1..points.len() - 1] {
            let (before, after) = ((y - keys.at(x - 1e-5)) / 1e-5, (keys.at(x + 1e-5) - y) / 1e-5);
            assert!((before - after).abs() < 1e-4, "{before} and {after} at {x}");
        }
    }

    /// With control points (0, 0), (8, 0.2), (4, 0.9), (10, 1) the curve's middle, s = 1/2, is known in closed form.
    #[test]
    fn handles_bend_the_curve() {
        let mut keys = keys(&[(0.0, 0.0), (10.0, 1.0)]);
        keys.keys[0].after = Some([8.0, 0.2]);
        keys.keys[1].before = Some([-6.0, -0.1]);
        let (frame, value) = ((3.0 * 8.0 + 3.0 * 4.0 + 10.0) / 8.0, (3.0 * 0.2 + 3.0 * 0.9 + 1.0) / 8.0);
        assert!((keys.at(frame) - value).abs() < 1e-12, "{}", keys.at(frame));
        assert!(keys.at(0.0).abs() < 1e-12 && keys.at(10.0) == 1.0);
        let rising: Vec<f64> = (0..=100).map(|i| keys.at(f64::from(i) / 10.0)).collect();
        assert!(rising.windows(2).all(|pair| pair[0] <= pair[1]));
    }
}
