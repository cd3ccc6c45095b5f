//! Several curves over one x, looked up together.

use multiversion::multiversion;

use super::pace::Curve;
use crate::field::{BATCH, Interval};

/// `N` curves, each as [`Curve`], through points at the same x.
pub(super) struct Curves<const N: usize> {
    /// x and y of the points.
    points: Vec<(f64, [f64; N])>,
    /// From a point to the next.
    pieces: Vec<Piece<f64, N>>,
    /// The same in `f32`.
    narrow: Vec<Piece<f32, N>>,
}

/// What the curves are between two points: c₀ + s(c₁ + s(c₂ + s·c₃)) each, at the share s of the way.
#[derive(Clone, Copy)]
struct Piece<T, const N: usize> {
    start: T,
    per_width: T,
    coefficients: [[T; 4]; N],
}

/// Values of curves over a batch, and their rates.
pub(super) struct Looked<const N: usize> {
    pub values: [[f32; BATCH]; N],
    pub rates: [[f32; BATCH]; N],
}

impl<const N: usize> Looked<N> {
    pub(super) fn new() -> Self {
        Self { values: [[0.0; BATCH]; N], rates: [[0.0; BATCH]; N] }
    }
}

impl<const N: usize> Curves<N> {
    /// The curves through points. `None` where there are none, x does not rise or a number is not finite.
    pub(super) fn through(points: Vec<(f64, [f64; N])>) -> Option<Self> {
        let piece = |pair: &[(f64, [f64; N])]| {
            let (start, width) = (pair[0].0, pair[1].0 - pair[0].0);
            Piece { start, per_width: 1.0 / width, coefficients: [[0.0; 4]; N] }
        };
        let mut pieces: Vec<_> = points.windows(2).map(piece).collect();
        for i in 0..N {
            let curve = Curve::through(points.iter().map(|(x, y)| [*x, y[i]]).collect())?;
            pieces.iter_mut().zip(curve.pieces()).for_each(|(piece, of_curve)| piece.coefficients[i] = of_curve);
        }
        let narrow = pieces.iter().map(Piece::narrowed).collect();
        Some(Self { points, pieces, narrow })
    }

    /// The x of the points.
    pub(super) fn xs(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|(x, _)| *x)
    }

    /// The values at x; beyond the ends, theirs.
    pub(super) fn at(&self, x: f64) -> [f64; N] {
        let after = self.points.partition_point(|(node, _)| *node <= x);
        match after.checked_sub(1).and_then(|left| self.pieces.get(left)) {
            Some(piece) => {
                let s = (x - piece.start) * piece.per_width;
                piece.coefficients.map(|[a, b, c, d]| a + s * (b + s * (c + s * d)))
            }
            None => self.points[after.min(self.points.len() - 1)].1,
        }
    }

    /// The values at each x, with their rates where `rates` is said; beyond the ends, those of the last pieces gone on.
    pub(super) fn look_up(&self, x: &[f32], rates: bool, out: &mut Looked<N>) {
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for x in x {
            least = if *x < least { *x } else { least };
            most = if *x > most { *x } else { most };
        }
        let piece = |x: f32| self.narrow.partition_point(|piece| piece.start <= x).saturating_sub(1);
        let (first, last) = (piece(least), piece(most));
        for (i, piece) in self.narrow[first..=last].iter().enumerate() {
            // Each takes all from its start on, of which the next takes its own.
            let start = if i == 0 { f32::NEG_INFINITY } else { piece.start };
            for n in 0..N {
                take_values(piece, n, start, x, &mut out.values[n]);
                if rates {
                    take_rates(piece, n, start, x, &mut out.rates[n]);
                }
            }
        }
    }

    /// The least and the greatest values at turns, between which the curves rise or fall, over a range of x: with the values
    /// at two places of it they bound those between.
    pub(super) fn turns(&self, x: Interval) -> [Interval; N] {
        let [from, to] = [x.lo, x.hi].map(|x| self.points.partition_point(|(node, _)| *node <= x));
        let turns = |at: &usize, i: usize| {
            let y = |at: usize| self.points.get(at).map(|(_, y)| y[i]);
            let [before, here, after] = [at.checked_sub(1).and_then(y), y(*at), y(at + 1)];
            match (before, here, after) {
                (Some(before), Some(here), Some(after)) => (here - before) * (after - here) <= 0.0,
                _ => false,
            }
        };
        std::array::from_fn(|i| {
            let between = (from..to).filter(|at| turns(at, i)).map(|at| self.points[at].1[i]);
            let none = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
            between.fold(none, |all, y| all.union(Interval::new(y, y)))
        })
    }
}

impl<const N: usize> Piece<f64, N> {
    fn narrowed(&self) -> Piece<f32, N> {
        Piece {
            start: self.start as f32,
            per_width: self.per_width as f32,
            coefficients: self.coefficients.map(|curve| curve.map(|number| number as f32)),
        }
    }
}

#[multiversion(targets = "simd")]
fn take_values<const N: usize>(piece: &Piece<f32, N>, curve: usize, start: f32, x: &[f32], out: &mut [f32; BATCH]) {
    let [a, b, c, d] = piece.coefficients[curve];
    for (out, x) in out.iter_mut().zip(x) {
        let s = (x - piece.start) * piece.per_width;
        let value = a + s * (b + s * (c + s * d));
        *out = if *x >= start { value } else { *out };
    }
}

#[multiversion(targets = "simd")]
fn take_rates<const N: usize>(piece: &Piece<f32, N>, curve: usize, start: f32, x: &[f32], out: &mut [f32; BATCH]) {
    let [_, b, c, d] = piece.coefficients[curve];
    for (out, x) in out.iter_mut().zip(x) {
        let s = (x - piece.start) * piece.per_width;
        let rate = (b + s * (2.0 * c + s * (3.0 * d))) * piece.per_width;
        *out = if *x >= start { rate } else { *out };
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
        let within: Vec<f64> = places().filter(|x| (0.0..=1.0).contains(x)).collect();
        let mut looked = Looked::new();
        // Of neighbours, and of some that are far apart.
        for some in [&within[..300], &within[137..290], &within.iter().copied().step_by(7).collect::<Vec<_>>()] {
            curves.look_up(&some.iter().map(|x| *x as f32).collect::<Vec<_>>(), true, &mut looked);
            for (n, x) in some.iter().enumerate() {
                let found = curves.at(*x);
                for i in 0..3 {
                    assert!((found[i] - each[i].at(*x)).abs() < 1e-12);
                    assert!((f64::from(looked.values[i][n]) - found[i]).abs() < 1e-6, "{} {x}", looked.values[i][n]);
                    let step = 1e-6;
                    let rate = (each[i].at(x + step) - each[i].at(x - step)) / (2.0 * step);
                    let at_end = x.abs() < 2.0 * step || (x - 1.0).abs() < 2.0 * step;
                    assert!((f64::from(looked.rates[i][n]) - rate).abs() < 1e-4 || at_end, "{rate} at {x}");
                }
            }
        }
        for (lo, hi) in [(-0.1, 0.2), (0.3, 0.31), (0.05, 1.1), (0.4, 0.4)] {
            let turns = curves.turns(Interval::new(lo, hi));
            let ends = [lo, hi].map(|x| curves.at(x));
            let within: Vec<_> = places().filter(|x| (lo..=hi).contains(x)).map(|x| curves.at(x)).collect();
            for i in 0..3 {
                let range = ends.iter().fold(turns[i], |all, y| all.union(Interval::new(y[i], y[i])));
                let of = within.iter().map(|y| y[i]);
                let (least, most) = (of.clone().fold(f64::INFINITY, f64::min), of.fold(f64::NEG_INFINITY, f64::max));
                assert!(range.lo <= least + 1e-12 && most <= range.hi + 1e-12);
                assert!(range.lo >= least - 0.05 && range.hi <= most + 0.05, "{range:?} {least} {most}");
            }
        }
        assert!([-0.1, 1.1].into_iter().all(|x| (0..3).all(|i| curves.at(x)[i] == each[i].at(x))));
        assert!(Curves::<1>::through(Vec::new()).is_none() && Curves::through(vec![(0.0, [f64::NAN])]).is_none());
    }
}
