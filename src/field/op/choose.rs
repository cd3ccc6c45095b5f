//! One of two values, by a third: `if`. The only operation on three.

use super::Interval;

/// The second where the first is not 0, else the third. Where the first is not a number, neither is the value.
pub fn value([condition, then, other]: [f64; 3]) -> f64 {
    match condition {
        _ if condition.is_nan() => f64::NAN,
        0.0 => other,
        _ => then,
    }
}

/// The value in one lane of a batch.
#[inline(always)]
pub fn lane([condition, then, other]: [f32; 3]) -> f32 {
    let chosen = if condition == 0.0 { other } else { then };
    if condition.is_nan() { condition } else { chosen }
}

/// Which of the two it is throughout bounds of the condition: the first, the second, or sometimes one and sometimes the
/// other.
pub fn side(condition: Interval) -> Option<bool> {
    match condition {
        Interval { lo: 0.0, hi: 0.0 } => Some(false),
        _ if !condition.contains(0.0) => Some(true),
        _ => None,
    }
}

/// Bounds of the value.
pub fn bounds([condition, then, other]: [Interval; 3]) -> Interval {
    match side(condition) {
        Some(true) => then,
        Some(false) => other,
        None => then.union(other),
    }
}
