//! What there is to know about a block of values.

use super::range::Range;

/// Below the least, infinite or not a number.
#[inline(always)]
fn is_wrong(number: f32, least: f32) -> bool {
    !(least..f32::INFINITY).contains(&number)
}

/// What there is to know about a block's values.
pub(super) struct Survey<const N: usize> {
    pub sum: [f64; N],
    pub range: Range<N>,
}

impl<const N: usize> Survey<N> {
    /// Whether a number is above 1.
    pub fn is_bright(&self) -> bool {
        self.range.greatest.iter().any(|&part| part > 1.0)
    }

    /// Whether a number is below the least, infinite or not a number. A sum with one that is none is none.
    fn is_wrong(&self, least: f32) -> bool {
        let Range { least: lowest, greatest } = &self.range;
        (0..N).any(|part| self.sum[part].is_nan() || lowest[part] < least || greatest[part] == f32::INFINITY)
    }

    /// The first of the values with such a number.
    pub(super) fn first_wrong(&self, values: &[[f32; N]], least: f32) -> Option<usize> {
        let is_wrong = |value: &[f32; N]| value.iter().any(|&part| is_wrong(part, least));
        if self.is_wrong(least) { values.iter().position(is_wrong) } else { None }
    }
}

/// Looks at values.
pub(super) fn survey<const N: usize>(values: &[[f32; N]]) -> Survey<N> {
    Survey { sum: sum(values), range: Range::of(values) }
}

/// The sum: of every eighth value, then of these, at any vector width.
#[multiversion::multiversion(targets = "simd")]
fn sum<const N: usize>(values: &[[f32; N]]) -> [f64; N] {
    let mut sums = [[0.0; N]; 8];
    let (rows, rest) = values.as_chunks::<8>();
    for row in rows {
        for i in 0..8 {
            for part in 0..N {
                sums[i][part] += f64::from(row[i][part]);
            }
        }
    }
    for (i, value) in rest.iter().enumerate() {
        for part in 0..N {
            sums[i][part] += f64::from(value[part]);
        }
    }
    std::array::from_fn(|part| sums.iter().map(|sum| sum[part]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attribute::LinearRgb;
    use crate::field::BATCH;

    #[test]
    fn a_survey_sums_and_notices_in_every_place() {
        for len in [0, 1, 7, 8, 9, 100, BATCH] {
            let colours: Vec<LinearRgb> =
                (0..len).map(|i| [0.001, 0.002, 0.0005].map(|part| part * i as f32)).collect();
            let plain = survey(&colours);
            assert!(!plain.is_wrong(0.0) && plain.is_bright() == (len == BATCH));
            assert_eq!(plain.range, Range::of_blocks(&[&colours]));
            for channel in 0..3 {
                let exact: f64 = colours.iter().map(|colour| f64::from(colour[channel])).sum();
                assert!((plain.sum[channel] - exact).abs() <= 1e-12 * exact);
            }
            for place in 0..3 * len {
                for (value, wrong) in [(-1e-9, true), (f32::NAN, true), (f32::INFINITY, true), (1.5, false)] {
                    let mut changed = colours.clone();
                    changed.as_flattened_mut()[place] = value;
                    let noticed = survey(&changed);
                    assert_eq!(noticed.is_wrong(0.0), wrong, "{value} at {place} of {len}");
                    assert!(noticed.is_bright() || value <= 1.0 || value.is_nan());
                }
            }
        }
    }
}
