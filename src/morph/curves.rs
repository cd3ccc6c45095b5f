//! Several curves over one x, looked up together.

use super::dual::Dual;
use super::pace::Curve;
use crate::field::Interval;

/// `N` curves, each as [`Curve`], through points at the same x.
pub(super) struct Curves<const N: usize> {
    /// x and y of the points.
    points: Vec<(f64, [f64; N])>,
    /// From a point to the next: c₀ + s(c₁ + s(c₂ + s·c₃)) at the share s of the way, for each curve.
    pieces: Vec<[[f64; 4]; N]>,
}

impl<const N: usize> Curves<N> {
    /// The curves through points. `None` where there are none, x does not rise or a number is not finite.
    pub(super) fn through(points: Vec<(f64, [f64; N])>) -> Option<Self> {
        let mut pieces = vec![[[0.0; 4]; N]; points.len().saturating_sub(1)];
        for i in 0..N {
            let curve = Curve::through(points.iter().map(|(x, y)| [*x, y[i]]).collect())?;
            pieces.iter_mut().zip(curve.pieces()).for_each(|(piece, of_curve)| piece[i] = of_curve);
        }
        Some(Self { points, pieces })
    }

    /// The piece that x is on, the share of the way along it, and its width; else the point beyond which there is none.
    fn place(&self, x: f64) -> Result<(usize, f64, f64), usize> {
        let after = self.points.partition_point(|(node, _)| *node <= x);
        match (after.checked_sub(1), self.points.get(after)) {
            (Some(left), Some((end, _))) => {
                let (start, _) = self.points[left];
                let width = end - start;
                Ok((left, (x - start) / width, width))
            }
            _ => Err(after.min(self.points.len() - 1)),
        }
    }

    /// The values at x; beyond the ends, theirs.
    pub(super) fn at(&self, x: f64) -> [f64; N] {
        match self.place(x) {
            Ok((piece, s, _)) => self.pieces[piece].map(|[a, b, c, d]| a + s * (b + s * (c + s * d))),
            Err(end) => self.points[end].1,
        }
    }

    /// The values with their rates at x; beyond the ends, theirs and 0.
    pub(super) fn at_with_rates(&self, x: f64) -> [Dual; N] {
        match self.place(x) {
            Ok((piece, s, width)) => self.pieces[piece].map(|[a, b, c, d]| {
                let rate = b + s * (2.0 * c + s * (3.0 * d));
                Dual::new(a + s * (b + s * (c + s * d)), rate / width)
            }),
            Err(end) => self.points[end].1.map(|value| Dual::new(value, 0.0)),
        }
    }

    /// The least and the greatest values over a range of x: between points the curves stay within theirs.
    pub(super) fn range(&self, x: Interval) -> [Interval; N] {
        let (lo, hi) = (self.at(x.lo), self.at(x.hi));
        let [from, to] = [x.lo, x.hi].map(|x| self.points.partition_point(|(node, _)| *node <= x));
        std::array::from_fn(|i| {
            let between = self.points[from..to].iter().map(|(_, y)| Interval::new(y[i], y[i]));
            between.fold(Interval::new(lo[i].min(hi[i]), lo[i].max(hi[i])), Interval::union)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_those_looked_up_one_by_one() {
        let y = |x: f64| [x * x - 0.3 * x, (5.0 * x).sin(), 1.0 / (x + 0.2)];
        let points: Vec<_> = (0..=9).map(|i| f64::from(i * i) / 81.0).map(|x| (x, y(x))).collect();
        let curves = Curves::through(points.clone()).expect("curves");
        let each: Vec<Curve> = (0..3)
            .map(|i| Curve::through(points.iter().map(|(x, y)| [*x, y[i]]).collect()).expect("a curve"))
            .collect();
        let places = || (-50..=550).map(|i| f64::from(i) / 500.0);
        for x in places() {
            let (found, with_rates) = (curves.at(x), curves.at_with_rates(x));
            for i in 0..3 {
                assert!((found[i] - each[i].at(x)).abs() < 1e-12 && found[i] == with_rates[i].value);
                let step = 1e-6;
                let rate = (each[i].at(x + step) - each[i].at(x - step)) / (2.0 * step);
                let at_end = x.abs() < 2.0 * step || (x - 1.0).abs() < 2.0 * step;
                assert!((with_rates[i].rate - rate).abs() < 1e-4 || at_end, "{} {rate} at {x}", with_rates[i].rate);
            }
        }
        for (lo, hi) in [(-0.1, 0.2), (0.3, 0.31), (0.05, 1.1), (0.4, 0.4)] {
            let ranges = curves.range(Interval::new(lo, hi));
            let within: Vec<_> = places().filter(|x| (lo..=hi).contains(x)).map(|x| curves.at(x)).collect();
            for i in 0..3 {
                let range = within.iter().map(|y| y[i]);
                let (least, most) =
                    (range.clone().fold(f64::INFINITY, f64::min), range.fold(f64::NEG_INFINITY, f64::max));
                assert!(ranges[i].lo <= least + 1e-12 && most <= ranges[i].hi + 1e-12);
                assert!(ranges[i].lo >= least - 0.05 && ranges[i].hi <= most + 0.05, "{:?} {least} {most}", ranges[i]);
            }
        }
        assert!(Curves::<1>::through(Vec::new()).is_none() && Curves::through(vec![(0.0, [f64::NAN])]).is_none());
    }
}
