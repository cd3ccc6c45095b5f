//! What a morph is told by scene time: numbers, whole sets of them, and where objects stand.

use std::fmt;
use std::sync::Arc;

/// A value at each scene time τ (0 at the shot's first frame, 1 at its last).
#[derive(Clone)]
pub struct OverTime<T>(Way<T>);

#[derive(Clone)]
enum Way<T> {
    Still(T),
    Moving(Arc<dyn Fn(f64) -> T + Send + Sync>),
}

impl<T: Copy> OverTime<T> {
    /// Always the same.
    pub fn still(value: T) -> Self {
        Self(Way::Still(value))
    }

    /// `value(τ)`, a pure function of scene time.
    pub fn moving(value: impl Fn(f64) -> T + Send + Sync + 'static) -> Self {
        Self(Way::Moving(Arc::new(value)))
    }

    /// The value at scene time τ.
    pub fn at(&self, time: f64) -> T {
        match &self.0 {
            Way::Still(value) => *value,
            Way::Moving(value) => value(time),
        }
    }

    /// Whether it never changes.
    pub fn is_still(&self) -> bool {
        matches!(self.0, Way::Still(_))
    }
}

impl<T: Copy> From<T> for OverTime<T> {
    fn from(value: T) -> Self {
        Self::still(value)
    }
}

impl<T: Copy + Default> Default for OverTime<T> {
    fn default() -> Self {
        Self::still(T::default())
    }
}

impl<T: fmt::Debug> fmt::Debug for OverTime<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Way::Still(value) => f.debug_tuple("Still").field(value).finish(),
            Way::Moving(_) => f.write_str("Moving"),
        }
    }
}
