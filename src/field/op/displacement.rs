//! The bounded blend's disp(r) = (1 − r²)³ / (1 + r²) of (r₁², r₂²), with r² = r₁² / (r₁² + r₂²), by the share u = 1 − r²:
//! u³ / (2 − u), no displacement where r₂² = 0.

use super::*;

impl Operation<2> for Displacement {
    const NATURE: Nature = Nature { shortens: true, ..Nature::PLAIN };

    fn value(self, [first, second]: [f64; 2]) -> f64 {
        if second <= 0.0 {
            return 0.0;
        }
        let share = if second.is_infinite() && first.is_finite() { 1.0 } else { second / (first + second) };
        share * share * share / (2.0 - share)
    }

    #[inline(always)]
    fn slopes(self, [first, second]: [f32; 2]) -> (f32, [f32; 2]) {
        let sum = first + second;
        let share = second / sum;
        let rest = 2.0 - share;
        let value = share * share * share / rest;
        let by_share = share * share * (6.0 - 2.0 * share) / (rest * rest);
        let (by_first, by_second) = (-by_share * share / sum, by_share * (1.0 - share) / sum);
        let within = second > 0.0;
        let by = [if within { by_first } else { 0.0 }, if within { by_second } else { 0.0 }];
        (if within { value } else { 0.0 }, by)
    }

    /// It falls with r₁² and rises with r₂².
    fn bounds(self, [first, second]: [Interval; 2]) -> Interval {
        if second.hi <= 0.0 {
            return Interval::ZERO;
        }
        let end = |first: f64, second: f64| self.value([first.max(0.0), second.max(0.0)]);
        let bounds = Interval::widened(end(first.hi, second.lo), end(first.lo, second.hi));
        Interval::new(bounds.lo.max(0.0), bounds.hi.min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_papers_formula() {
        for (first, second) in [(0.2, 0.7), (3.0, 0.1), (0.0, 1.0)] {
            let r2: f64 = first / (first + second);
            assert!((Binary::Displacement.value([first, second]) - (1.0 - r2).powi(3) / (1.0 + r2)).abs() < 1e-15);
        }
        assert_eq!(Binary::Displacement.value([0.0, 0.0]), 0.0);
        assert_eq!(Binary::Displacement.value([1.0, 0.0]), 0.0);
    }
}
