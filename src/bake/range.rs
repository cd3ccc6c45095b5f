//! The least and the greatest of many values.

use rayon::prelude::*;

use crate::grid::{BLOCK_VOXELS, BlockMask};

/// The least and the greatest of values, each component for itself; those that are no numbers do not count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<const N: usize> {
    /// +∞ of none.
    pub least: [f32; N],
    /// −∞ of none.
    pub greatest: [f32; N],
}

impl<const N: usize> Range<N> {
    /// Of no values.
    pub fn none() -> Self {
        Self { least: [f32::INFINITY; N], greatest: [f32::NEG_INFINITY; N] }
    }

    /// Of both.
    pub fn joined(self, other: Self) -> Self {
        Self {
            least: std::array::from_fn(|part| self.least[part].min(other.least[part])),
            greatest: std::array::from_fn(|part| self.greatest[part].max(other.greatest[part])),
        }
    }

    /// Of some values.
    pub(super) fn of(values: &[[f32; N]]) -> Self {
        range(values)
    }

    /// Of all values of some blocks.
    pub(super) fn of_blocks(blocks: &[impl AsRef<[[f32; N]]> + Sync]) -> Self {
        blocks.par_iter().map(|block| range(block.as_ref())).reduce(Self::none, Self::joined)
    }
}

impl Range<1> {
    /// Of the active values of a block.
    pub(super) fn of_active(block: &[f32; BLOCK_VOXELS], active: &BlockMask) -> Self {
        let [least, greatest] = active_range(block, active);
        Self { least: [least], greatest: [greatest] }
    }
}

/// The least and the greatest: of every eighth value, then of these, at any vector width.
#[multiversion::multiversion(targets = "simd")]
fn range<const N: usize>(values: &[[f32; N]]) -> Range<N> {
    let (mut least, mut greatest) = ([[f32::INFINITY; N]; 8], [[f32::NEG_INFINITY; N]; 8]);
    let (rows, rest) = values.as_chunks::<8>();
    for row in rows {
        for i in 0..8 {
            for part in 0..N {
                least[i][part] = if row[i][part] < least[i][part] { row[i][part] } else { least[i][part] };
                greatest[i][part] = if row[i][part] > greatest[i][part] { row[i][part] } else { greatest[i][part] };
            }
        }
    }
    let all = |start: &[[f32; N]; 8], choose: fn(f32, f32) -> f32| {
        let first = rest.iter().chain(start);
        std::array::from_fn(|part| first.clone().map(|value| value[part]).fold(start[0][part], choose))
    };
    Range { least: all(&least, f32::min), greatest: all(&greatest, f32::max) }
}

/// The least and the greatest of a block's active values.
#[multiversion::multiversion(targets = "simd")]
fn active_range(block: &[f32; BLOCK_VOXELS], active: &BlockMask) -> [f32; 2] {
    let (mut least, mut greatest) = ([f32::INFINITY; 64], [f32::NEG_INFINITY; 64]);
    for (values, word) in block.as_chunks::<64>().0.iter().zip(active) {
        for i in 0..64 {
            let on = word >> i & 1 == 1;
            least[i] = if on && values[i] < least[i] { values[i] } else { least[i] };
            greatest[i] = if on && values[i] > greatest[i] { values[i] } else { greatest[i] };
        }
    }
    [least.into_iter().fold(f32::INFINITY, f32::min), greatest.into_iter().fold(f32::NEG_INFINITY, f32::max)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::mask;

    #[test]
    fn ranges_are_those_of_the_active_values() {
        let block: [f32; BLOCK_VOXELS] = std::array::from_fn(|at| ((at * 37 + 11) % 512) as f32 - 200.0);
        for step in [1, 3, 7, 100, 511] {
            let active = mask::pack(&std::array::from_fn(|at| u8::from(at % step == step - 1)));
            let values: Vec<f32> = mask::places(&active).map(|at| block[at]).collect();
            let least = values.iter().copied().fold(f32::INFINITY, f32::min);
            let greatest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            assert_eq!(active_range(&block, &active), [least, greatest]);
            let triples: Vec<[f32; 3]> = values.iter().map(|&value| [value, -value, value + 1.0]).collect();
            let expected =
                Range { least: [least, -greatest, least + 1.0], greatest: [greatest, -least, greatest + 1.0] };
            assert_eq!(range(&triples), expected);
        }
        assert_eq!(range::<1>(&[]), Range::none());
    }
}
