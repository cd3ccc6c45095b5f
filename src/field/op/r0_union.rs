//! The union of system R₀, `a + b + √(a² + b²)` (methods of FRep): smooth but where both are zero.

use super::*;

/// The share of the distance that unions keep of two equal distances outside: 2 − √2.
const KEPT: f64 = 2.0 - std::f64::consts::SQRT_2;

impl Operation<2> for Union {
    const NATURE: Nature = Nature::UNION;
    const FUNCTIONS: &'static [Function] = &[function(
        "union",
        2,
        "union(f, g)",
        "f + g + √(f² + g²): positive where either is (system R₀), smooth but where both are 0",
        |graph, a| graph.binary(Binary::Union, a[0], a[1]),
    )];

    /// Without cancellation: for the lesser and greater argument m < 0 and M the sum m + √(m² + M²) is
    /// M² / (√(m² + M²) − m).
    fn value(self, [a, b]: [f64; 2]) -> f64 {
        let (lesser, greater) = (a.min(b), a.max(b));
        // Bounds over endless boxes are infinite.
        if greater.is_infinite() {
            return greater;
        }
        let both = (lesser * lesser + greater * greater).sqrt() + lesser.abs();
        greater + if lesser < 0.0 { greater * greater / both } else { both }
    }

    /// By `1 + a/√(a² + b²)` and `1 + b/√(a² + b²)`; where both arguments are zero, the first one's side.
    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let (lesser, greater) = if a < b { (a, b) } else { (b, a) };
        let square = greater * greater;
        let root = (lesser * lesser + square).sqrt();
        let both = root + lesser.abs();
        let ratio = square / both;
        let value = greater + if lesser < 0.0 { ratio } else { both };
        let inverse = 1.0 / root;
        let (by_a, by_b) = (1.0 + a * inverse, 1.0 + b * inverse);
        let smooth = root > 0.0;
        (value, [if smooth { by_a } else { 1.0 }, if smooth { by_b } else { 0.0 }])
    }

    /// By monotony: the plain interval form is far looser.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        Interval::widened(self.value([a.lo, b.lo]), self.value([a.hi, b.hi]))
    }

    /// ∇ = (1 + a/s)∇a + (1 + b/s)∇b, whose weights are 1 + cos and 1 + sin of one angle. Outside of both F is greatest
    /// where they are equal.
    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        let steep = Facts::steep(a.steepness().zip(b.steepness()).map(|(a, b)| a + b + a.hypot(b)));
        Facts::union(a, b, steep.slope, KEPT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_formula_where_that_is_accurate() {
        for (a, b) in [(1.0, 2.0), (-1.0, 2.0), (-1.0, -2.0), (0.3, 0.3), (0.0, -4.0)] {
            let (a, b): (f64, f64) = (a, b);
            let root = (a * a + b * b).sqrt();
            assert!((Binary::Union.value([a, b]) - (a + b + root)).abs() < 1e-14);
            assert!((Binary::Intersection.value([a, b]) - (a + b - root)).abs() < 1e-14);
        }
        assert_eq!((Binary::Union.value([0.0, 0.0]), Union {}.slopes([0.0, 0.0]).0), (0.0, 0.0));
    }

    #[test]
    fn it_keeps_signs_that_the_formula_loses() {
        assert!(Binary::Union.value([-1.0, 1e-12]) > 0.0 && Binary::Intersection.value([1.0, -1e-12]) < 0.0);
        assert!(Union {}.slopes([-1.0, 1e-6]).0 > 0.0 && Union {}.slopes([1e-6, -1.0]).0 > 0.0);
        assert!(Union {}.slopes([-1.0, -1e-6]).0 < 0.0);
    }
}
