//! What each operation means for one `f64` value: the judge of every faster way, and the end points of bounds.

use super::op::{Binary, Unary};

/// System R₀ union, `a + b + √(a² + b²)` (methods of FRep), without cancellation: for the lesser and greater
/// argument m < 0 and M the sum m + √(m² + M²) is M² / (√(m² + M²) − m).
pub(super) fn r0_union(a: f64, b: f64) -> f64 {
    let (lesser, greater) = (a.min(b), a.max(b));
    // Bounds over endless boxes are infinite.
    if greater.is_infinite() {
        return greater;
    }
    let both = (lesser * lesser + greater * greater).sqrt() + lesser.abs();
    greater + if lesser < 0.0 { greater * greater / both } else { both }
}

/// System R₀ intersection, `a + b − √(a² + b²)`, without cancellation.
pub(super) fn r0_intersection(a: f64, b: f64) -> f64 {
    -r0_union(-a, -b)
}

/// The signed distance to the intersection of two solids whose surfaces meet at right angles, from theirs.
pub(super) fn corner(a: f64, b: f64) -> f64 {
    if a.min(b) >= 0.0 {
        return a.min(b);
    }
    let (a, b) = (a.min(0.0), b.min(0.0));
    -(a * a + b * b).sqrt()
}

/// The bounded blend's disp(r) = (1 − r²)³ / (1 + r²) with r² = r₁² / (r₁² + r₂²), by the share u = 1 − r²: no
/// displacement where r₂² = 0.
pub(super) fn displacement(first: f64, second: f64) -> f64 {
    if second <= 0.0 {
        return 0.0;
    }
    let share = if second.is_infinite() && first.is_finite() { 1.0 } else { second / (first + second) };
    share * share * share / (2.0 - share)
}

/// `3v² − 2v³` of the value clamped to 0..1.
pub(super) fn smooth(value: f64) -> f64 {
    let value = value.clamp(0.0, 1.0);
    value * value * (3.0 - 2.0 * value)
}

/// A power by repeated squaring.
pub(super) fn powi(value: f64, exponent: u32) -> f64 {
    let (mut result, mut square, mut rest) = (1.0, value, exponent);
    while rest > 0 {
        if rest & 1 == 1 {
            result *= square;
        }
        square *= square;
        rest >>= 1;
    }
    result
}

pub(super) fn exp(value: f64) -> f64 {
    libm::exp(value)
}

pub(super) fn log(value: f64) -> f64 {
    libm::log(value)
}

/// 1, −1, or 0 at zero.
pub(super) fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}

pub(super) fn unary(operation: Unary, value: f64) -> f64 {
    match operation {
        Unary::Linear { scale, offset } => value * scale + offset,
        Unary::Abs => value.abs(),
        Unary::Square => value * value,
        Unary::Sqrt => value.sqrt(),
        Unary::Cbrt => libm::cbrt(value),
        Unary::Recip => 1.0 / value,
        Unary::Powi(exponent) => powi(value, exponent),
        Unary::Sin => libm::sin(value),
        Unary::Cos => libm::cos(value),
        Unary::Exp => exp(value),
        Unary::Log => log(value),
        Unary::Floor => value.floor(),
        Unary::Sign => sign(value),
        Unary::Smooth => smooth(value),
    }
}

pub(super) fn binary(operation: Binary, a: f64, b: f64) -> f64 {
    match operation {
        Binary::Add => a + b,
        Binary::Sub => a - b,
        Binary::Mul => a * b,
        Binary::Div => a / b,
        Binary::Min => a.min(b),
        Binary::Max => a.max(b),
        Binary::Union => r0_union(a, b),
        Binary::Intersection => r0_intersection(a, b),
        Binary::Corner => corner(a, b),
        Binary::Displacement => displacement(a, b),
        Binary::Pow => libm::pow(a, b),
        Binary::Atan2 => libm::atan2(a, b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn r0_is_the_formula_where_that_is_accurate() {
        for (a, b) in [(1.0, 2.0), (-1.0, 2.0), (-1.0, -2.0), (0.3, 0.3), (0.0, -4.0)] {
            let (a, b): (f64, f64) = (a, b);
            let root = (a * a + b * b).sqrt();
            assert!((r0_union(a, b) - (a + b + root)).abs() < 1e-14);
            assert!((r0_intersection(a, b) - (a + b - root)).abs() < 1e-14);
        }
        assert_eq!(r0_union(0.0, 0.0), 0.0);
    }

    #[test]
    fn r0_keeps_signs_that_the_formula_loses() {
        assert!(r0_union(-1.0, 1e-12) > 0.0);
        assert!(r0_intersection(1.0, -1e-12) < 0.0);
    }

    #[test]
    fn displacement_is_the_papers_formula() {
        for (first, second) in [(0.2, 0.7), (3.0, 0.1), (0.0, 1.0)] {
            let r2: f64 = first / (first + second);
            assert!((displacement(first, second) - (1.0 - r2).powi(3) / (1.0 + r2)).abs() < 1e-15);
        }
        assert_eq!(displacement(0.0, 0.0), 0.0);
        assert_eq!(displacement(1.0, 0.0), 0.0);
    }
}
