//! placeholder
/// The space in which two colours are mixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourSpace {
    /// a
    Oklab,
}
