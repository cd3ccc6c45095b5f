//! Functions on one `f32` lane that compilers turn into vector code, the same bits at every vector width: only
//! `+ − × ÷ √`, comparisons and bit patterns, no fused multiply-add, no system library.
//!
//! The transcendental ones work in `f64` inside: the range reduction is then a plain subtraction, and the Taylor
//! polynomials below are accurate to far more than the `f32` that is returned.
//!
//! Where compilers make a branch of an `if`, and then a store under a mask of what follows, choices are spelt
//! `select_unpredictable`, here and in the loops that use these: without AVX-512 such stores cost some machines dozens of
//! cycles. A choice that may keep what stands there is written elsewhere, for that becomes one too.

use std::hint::select_unpredictable;

/// Adding and subtracting this rounds an `f64` under 2⁵¹ to the nearest whole number, and leaves that number in
/// the low bits in between.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// `3v² − 2v³` of the value clamped to 0..1.
#[inline(always)]
pub(crate) fn smooth(value: f32) -> f32 {
    let value = clamp01(value);
    value * value * (3.0 - 2.0 * value)
}

#[inline(always)]
pub(crate) fn clamp01(value: f32) -> f32 {
    let value = select_unpredictable(value > 0.0, value, 0.0);
    select_unpredictable(value < 1.0, value, 1.0)
}

/// The cube root by two of Halley's steps from a third of the exponent.
#[inline(always)]
pub(crate) fn cbrt(value: f32) -> f32 {
    /// Two thirds of the exponent's bias, and a little less for the mantissa's mean error.
    const BIAS: u32 = 709_960_000;
    let size = value.abs();
    let mut root = f32::from_bits(size.to_bits() / 3 + BIAS);
    for _ in 0..2 {
        let cube = root * root * root;
        root *= (cube + 2.0 * size) / (2.0 * cube + size);
    }
    // Below this the cube loses bits; no field is that small but at zero.
    let root = if size > 1e-30 { root } else { 0.0 };
    if value < 0.0 { -root } else { root }
}

#[inline(always)]
fn polynomial<const N: usize>(value: f64, coefficients: [f64; N]) -> f64 {
    let mut sum = 0.0;
    for coefficient in coefficients {
        sum = sum * value + coefficient;
    }
    sum
}

/// Sine and cosine of `value + quarters·π/2`.
#[inline(always)]
fn turned(value: f32, quarters: u64) -> f64 {
    use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
    let value = f64::from(value);
    let shifted = value * FRAC_2_PI + ROUND;
    let quadrant = shifted.to_bits().wrapping_add(quarters);
    let rest = value - (shifted - ROUND) * FRAC_PI_2;
    let square = rest * rest;
    let sine =
        rest * polynomial(square, [-1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5_040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0]);
    let cosine = polynomial(
        square,
        [1.0 / 479_001_600.0, -1.0 / 3_628_800.0, 1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0],
    );
    let value = if quadrant & 1 == 0 { sine } else { cosine };
    if quadrant & 2 == 0 { value } else { -value }
}

/// The sine, to `f32` accuracy for arguments up to 10⁷.
#[inline(always)]
pub(crate) fn sin(value: f32) -> f32 {
    turned(value, 0) as f32
}

/// The cosine, as [`sin`].
#[inline(always)]
pub(crate) fn cos(value: f32) -> f32 {
    turned(value, 1) as f32
}

/// 2 to the power, for powers in ±1000.
#[inline(always)]
fn exp2(power: f64) -> f64 {
    let power = if power > -1000.0 { power } else { -1000.0 };
    let power = if power < 1000.0 { power } else { 1000.0 };
    let shifted = power + ROUND;
    let scale = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
    let rest = (power - (shifted - ROUND)) * std::f64::consts::LN_2;
    let fraction = polynomial(
        rest,
        [
            1.0 / 362_880.0,
            1.0 / 40_320.0,
            1.0 / 5_040.0,
            1.0 / 720.0,
            1.0 / 120.0,
            1.0 / 24.0,
            1.0 / 6.0,
            0.5,
            1.0,
            1.0,
        ],
    );
    fraction * scale
}

/// The natural logarithm of a positive normal number.
#[inline(always)]
fn log_of_positive(value: f64) -> f64 {
    // The mantissa in √½..√2: with s = (m − 1)/(m + 1), ln m = 2·(s + s³/3 + s⁵/5 + …).
    const HALF_ROOT: u64 = 0x3FE6_A09E_667F_3BCD;
    const WHOLE: f64 = 4_503_599_627_370_496.0;
    let bits = value.to_bits().wrapping_sub(HALF_ROOT);
    let biased = (bits >> 52).wrapping_add(1024) & 0xFFF;
    // The exponent as a number, without a conversion that narrow vector units lack.
    let exponent = f64::from_bits(WHOLE.to_bits() | biased) - WHOLE - 1024.0;
    let exponent = if exponent > 2048.0 { exponent - 4096.0 } else { exponent };
    let mantissa = f64::from_bits((bits & 0x000F_FFFF_FFFF_FFFF).wrapping_add(HALF_ROOT));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let series =
        polynomial(s * s, [2.0 / 15.0, 2.0 / 13.0, 2.0 / 11.0, 2.0 / 9.0, 2.0 / 7.0, 2.0 / 5.0, 2.0 / 3.0, 2.0]);
    exponent * std::f64::consts::LN_2 + s * series
}

/// The exponential.
#[inline(always)]
pub(super) fn exp(value: f32) -> f32 {
    let result = exp2(f64::from(value) * std::f64::consts::LOG2_E) as f32;
    if value.is_nan() { f32::NAN } else { result }
}

/// The natural logarithm: −∞ of zero, not a number of less.
#[inline(always)]
pub(super) fn log(value: f32) -> f32 {
    let result = log_of_positive(f64::from(value)) as f32;
    let result = if value < f32::INFINITY { result } else { value };
    let result = if value == 0.0 { f32::NEG_INFINITY } else { result };
    if value >= 0.0 { result } else { f32::NAN }
}

/// A power of a base that is not negative; not a number otherwise.
#[inline(always)]
pub(super) fn pow(base: f32, exponent: f32) -> f32 {
    let power = f64::from(exponent) * log_of_positive(f64::from(base)) * std::f64::consts::LOG2_E;
    let result = exp2(power) as f32;
    let at_zero = if exponent > 0.0 { 0.0 } else { f32::INFINITY };
    let result = if base == 0.0 { at_zero } else { result };
    let result = if exponent == 0.0 { 1.0 } else { result };
    if base >= 0.0 && !exponent.is_nan() { result } else { f32::NAN }
}

/// A power of a positive number with a positive exponent, in `f32` throughout: several times as fast as [`pow`]. The
/// relative error is below 1.2·10⁻⁷ · (2 + |exponent · log₂ base|). Zero, infinity, what is less than zero and what is
/// no number come back as they are.
#[inline(always)]
pub(crate) fn short_pow(base: f32, exponent: f32) -> f32 {
    /// As `ROUND`, for an `f32` under 2²².
    const ROUND: f32 = 12_582_912.0;
    const HALF_ROOT: u32 = 0x3F35_04F3;
    let bits = base.to_bits().wrapping_sub(HALF_ROOT);
    let whole = (bits as i32 >> 23) as f32;
    let mantissa = f32::from_bits((bits & 0x007F_FFFF).wrapping_add(HALF_ROOT));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let square = s * s;
    // As in `log_of_positive`; the next term is under 2⁻²⁷ of the sum.
    let series = (((2.0 / 9.0 * square + 2.0 / 7.0) * square + 2.0 / 5.0) * square + 2.0 / 3.0) * square + 2.0;
    let power = exponent * (whole + s * series * std::f32::consts::LOG2_E);
    let power = if power > -127.0 { power } else { -127.0 };
    let power = if power < 128.0 { power } else { 128.0 };
    let shifted = power + ROUND;
    let scale = f32::from_bits((shifted.to_bits() << 23).wrapping_add(127 << 23));
    let rest = (power - (shifted - ROUND)) * std::f32::consts::LN_2;
    let upper = ((1.0 / 5_040.0 * rest + 1.0 / 720.0) * rest + 1.0 / 120.0) * rest + 1.0 / 24.0;
    let fraction = (((upper * rest + 1.0 / 6.0) * rest + 0.5) * rest + 1.0) * rest + 1.0;
    select_unpredictable((base > 0.0) & (base < f32::INFINITY), fraction * scale, base)
}

/// The angle of (x, y), in −π..π.
#[inline(always)]
pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    /// tan(π/8): above it the angle is measured from π/4.
    const EIGHTH: f64 = 0.414_213_562_373_095_03;
    let (y, x) = (f64::from(y), f64::from(x));
    let (height, width) = (y.abs(), x.abs());
    let steep = height > width;
    let (least, most) = if steep { (width, height) } else { (height, width) };
    let ratio = if most > 0.0 { least / most } else { 0.0 };
    let far = ratio > EIGHTH;
    let value = if far { (ratio - 1.0) / (ratio + 1.0) } else { ratio };
    let series = value
        * polynomial(
            value * value,
            [1.0 / 17.0, -1.0 / 15.0, 1.0 / 13.0, -1.0 / 11.0, 1.0 / 9.0, -1.0 / 7.0, 1.0 / 5.0, -1.0 / 3.0, 1.0],
        );
    let angle = series + if far { FRAC_PI_4 } else { 0.0 };
    let angle = if steep { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    let angle = if y < 0.0 { -angle } else { angle };
    (if x.is_nan() || y.is_nan() { f64::NAN } else { angle }) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The greatest error of `ours`, in units in the last place of the exact result (at least of `floor`).
    fn worst(points: impl Iterator<Item = f32>, ours: fn(f32) -> f32, exact: fn(f64) -> f64, floor: f64) -> f64 {
        points
            .map(|x| {
                let wanted = exact(f64::from(x));
                (f64::from(ours(x)) - wanted).abs() / (wanted.abs().max(floor) * f64::from(f32::EPSILON))
            })
            .fold(0.0, f64::max)
    }

    fn spread(from: f32, to: f32) -> impl Iterator<Item = f32> {
        (0..20_000).map(move |i| from + (to - from) * (i as f32 / 19_999.0))
    }

    #[test]
    fn functions_are_within_an_ulp_of_libm() {
        assert!(worst(spread(-1e4, 1e4), sin, libm::sin, 1e-3) < 0.6);
        assert!(worst(spread(-10.0, 10.0), cos, libm::cos, 1e-6) < 0.6);
        assert!(worst(spread(-80.0, 80.0), exp, libm::exp, 0.0) < 0.6);
        assert!(worst(spread(1e-6, 40.0), log, libm::log, 1e-6) < 0.6);
        assert!(worst(spread(1e30, 1e38), log, libm::log, 1e-6) < 0.6);
        assert!(worst(spread(-30.0, 30.0), cbrt, libm::cbrt, 0.0) < 3.0);
        assert!(worst(spread(0.0, 9.0), |v| pow(v, 2.5), |v| libm::pow(v, 2.5), 0.0) < 0.6);
        assert!(worst(spread(-4.0, 4.0), |v| atan2(v, -0.7), |v| libm::atan2(v, f64::from(-0.7f32)), 0.0) < 0.6);
        assert!(worst(spread(-4.0, 4.0), |v| atan2(0.3, v), |v| libm::atan2(f64::from(0.3f32), v), 0.0) < 0.6);
    }

    #[test]
    fn the_short_power_is_as_near_as_it_says() {
        for exponent in [2.4f32, 1.0 / 2.4] {
            for base in spread(1e-4, 1.5).chain(spread(1.5, 70_000.0)) {
                let wanted = libm::pow(f64::from(base), f64::from(exponent));
                let error = (f64::from(short_pow(base, exponent)) / wanted - 1.0).abs();
                let bound = 1.2e-7 * (2.0 + f64::from(exponent) * libm::log2(f64::from(base)).abs());
                assert!(error < bound, "{base} to the {exponent}: {error} of {bound}");
            }
            for kept in [0.0, 1.0, f32::INFINITY, -2.0] {
                assert_eq!(short_pow(kept, exponent), kept);
            }
            assert!(short_pow(f32::NAN, exponent).is_nan());
        }
        assert_eq!((short_pow(1e38, 2.4), short_pow(1e-30, 2.4)), (f32::INFINITY, 0.0));
    }

    #[test]
    fn functions_keep_their_limits() {
        assert_eq!(exp(-200.0), 0.0);
        assert_eq!(exp(200.0), f32::INFINITY);
        assert_eq!(log(0.0), f32::NEG_INFINITY);
        assert!(log(-1.0).is_nan() && pow(-1.0, 0.5).is_nan() && sin(f32::INFINITY).is_nan());
        assert_eq!((pow(0.0, 2.0), pow(3.0, 0.0), cbrt(0.0), atan2(0.0, 0.0)), (0.0, 1.0, 0.0, 0.0));
    }
}
