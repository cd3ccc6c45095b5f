//! Which vector instructions the batch loops use. The results are the same bits with any.

use std::sync::OnceLock;

/// A set of vector instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum VectorWidth {
    /// Four lanes: what every x86-64 has. Also what other processors get, in their own baseline.
    Sse2,
    /// Eight lanes.
    Avx2,
    /// Sixteen lanes.
    Avx512,
}

impl VectorWidth {
    /// All widths, the narrowest first.
    pub const ALL: [Self; 3] = [Self::Sse2, Self::Avx2, Self::Avx512];

    /// The widest that this processor has, or what the environment variable `HFVDB_SIMD` (`sse2`, `avx2`,
    /// `avx512`) allows; a name it does not know is as good as none. Read once.
    pub fn chosen() -> Self {
        static CHOSEN: OnceLock<VectorWidth> = OnceLock::new();
        *CHOSEN.get_or_init(|| {
            let wanted = std::env::var("HFVDB_SIMD").ok().and_then(|name| Self::named(&name));
            wanted.unwrap_or(Self::Avx512).min(Self::widest())
        })
    }

    fn named(name: &str) -> Option<Self> {
        match name {
            "sse2" => Some(Self::Sse2),
            "avx2" => Some(Self::Avx2),
            "avx512" => Some(Self::Avx512),
            _ => None,
        }
    }

    /// The widest that this processor has.
    #[cfg(target_arch = "x86_64")]
    fn widest() -> Self {
        // The first processors with AVX-512 slow down on it; those with VBMI2 do not, and the dispatcher of the
        // loops draws the same line: short of it, it takes AVX2.
        if std::arch::is_x86_feature_detected!("avx512vbmi2") {
            Self::Avx512
        } else if std::arch::is_x86_feature_detected!("avx2") {
            Self::Avx2
        } else {
            Self::Sse2
        }
    }

    /// Other processors run the baseline loops.
    #[cfg(not(target_arch = "x86_64"))]
    fn widest() -> Self {
        Self::Sse2
    }
}
