//! The volume inside a section of a morph, and the a₀ that encloses a given volume.
//!
//! F_b ≥ 0 exactly where φ = −(g₁ ∨₀ g₂)/disp ≤ a₀, so a₀ is a quantile of φ. Cells at the surface count by the
//! fraction of them that is inside: of the segment through the cell's middle, along the surface's normal, as long as
//! a cell's edge. On it both distances are taken as linear, which they nearly are; F_b is not, so its zero is searched.

use std::hint::select_unpredictable;

use rayon::prelude::*;

use super::coarse::{CoarseGrid, Measured};
use super::course::Place;
use super::section::{Kernel, Section};

/// The sum of squares below which both slopes are taken as zero.
pub(super) const NO_SLOPE: f32 = 1e-20;
/// Cells whose zeros are searched side by side.
const LANES: usize = 16;
/// Steps of that search. Fewer leave visible noise in a₀ where F_b bends most, near both ends of a morph.
const ZERO_STEPS: usize = 7;
/// Halvings of the segment of a cell with a blend of its own: to a thousandth of a cell.
const PLACE_STEPS: usize = 10;

/// A section of a morph over the coarse grid.
pub(super) struct Volume<'a> {
    measured: &'a Measured,
    section: Section,
    /// Half a cell's edge in units of D.
    half_edge: f32,
}

/// A blend's amount and what it encloses.
pub(super) struct Enclosing {
    pub a0: f64,
    /// The fraction inside of each cell.
    pub fractions: Vec<f32>,
}

impl<'a> Volume<'a> {
    pub(super) fn new(grid: &CoarseGrid, measured: &'a Measured, unit: f64, section: Section) -> Self {
        Self { measured, section, half_edge: (0.5 * grid.edge() / unit) as f32 }
    }

    /// The a₀ whose section holds `target` cells, at a rising section whose own a₀ does not matter.
    pub(super) fn enclosing(&self, target: f64) -> Enclosing {
        let kernel = Kernel::<f32>::new(&Section { a0: 1.0, ..self.section });
        let mut ranges = Ranges::new(self.measured.first.len());
        level_ranges(&kernel, self.half_edge, self.measured, &mut ranges);
        let (low, high) = (around_rank(&ranges.least, target)[0], around_rank(&ranges.most, target)[1]);
        let mut fractions: Vec<f32> = ranges.most.iter().map(|level| f32::from(u8::from(*level <= low))).collect();
        let missing = target - total(&fractions);
        let crossed = (0..fractions.len()).filter(|&i| ranges.least[i] < high && ranges.most[i] > low);
        let mut crossed = Crossed::new(self, &ranges, crossed);
        let a0 = zero(f64::from(low), f64::from(high), target * 1e-7, |a0| {
            crossed.fill(&Kernel::new(&Section { a0, ..self.section }));
            crossed.total() - missing
        });
        crossed.fill(&Kernel::new(&Section { a0, ..self.section }));
        crossed.put_into(&mut fractions);
        Enclosing { a0, fractions }
    }

    /// What the section's own a₀ encloses.
    pub(super) fn as_it_is(&self) -> Enclosing {
        let kernel = Kernel::<f32>::new(&self.section);
        let mut ranges = Ranges::new(self.measured.first.len());
        value_ranges(&kernel, self.half_edge, self.measured, &mut ranges);
        let mut fractions: Vec<f32> = ranges.least.iter().map(|value| f32::from(u8::from(*value >= 0.0))).collect();
        let crossed = (0..fractions.len()).filter(|&i| ranges.least[i] < 0.0 && ranges.most[i] >= 0.0);
        let mut crossed = Crossed::new(self, &ranges, crossed);
        crossed.fill(&kernel);
        crossed.put_into(&mut fractions);
        Enclosing { a0: self.section.a0, fractions }
    }
}

/// The fraction inside of each cell of one object, from its distances in units of D.
pub(super) fn object_fractions(grid: &CoarseGrid, distances: &[f32], unit: f64) -> Vec<f32> {
    let per_edge = (unit / grid.edge()) as f32;
    distances.iter().map(|distance| fraction(distance * per_edge)).collect()
}

/// The fraction inside of each cell, where each has a blend of its own.
pub(super) fn place_fractions(
    grid: &CoarseGrid,
    measured: &Measured,
    unit: f64,
    place: impl Fn(usize) -> Place<f64> + Sync,
) -> Vec<f32> {
    let half_edge = 0.5 * grid.edge() / unit;
    let of_cell = |cell: usize| {
        let (place, middle) = (place(cell), [measured.first[cell], measured.second[cell]].map(f64::from));
        let slopes = place.slopes(middle[0], middle[1]);
        let along = along_normal(slopes.by_first as f32, slopes.by_second as f32, measured.cosine[cell]);
        let reach = along.map(|along| f64::from(along) * half_edge);
        // From one end of the segment, at −1, to the other.
        let inside = |at: f64| place.value(middle[0] + reach[0] * at, middle[1] + reach[1] * at) >= 0.0;
        let ends = [inside(-1.0), inside(1.0)];
        if ends[0] == ends[1] {
            return f32::from(u8::from(ends[0]));
        }
        let (mut low, mut high) = (-1.0, 1.0);
        for _ in 0..PLACE_STEPS {
            let middle = 0.5 * (low + high);
            if inside(middle) == ends[0] { low = middle } else { high = middle }
        }
        let crossed = 0.25 * (low + high) + 0.5;
        (if ends[1] { 1.0 - crossed } else { crossed }) as f32
    };
    (0..measured.first.len()).into_par_iter().map(of_cell).collect()
}

/// The volume of one object, in cells.
pub(super) fn object_cells(grid: &CoarseGrid, distances: &[f32], unit: f64) -> f64 {
    let per_edge = (unit / grid.edge()) as f32;
    distances.iter().map(|distance| f64::from(fraction(distance * per_edge))).sum()
}

/// The fraction of a cell behind a plane through it, from its middle's distance in cells.
pub(super) fn fraction(distance: f32) -> f32 {
    (0.5 + distance).clamp(0.0, 1.0)
}

/// The sum of the fractions, in cells.
pub(super) fn total(fractions: &[f32]) -> f64 {
    fractions.iter().map(|fraction| f64::from(*fraction)).sum()
}

/// The volume in one but not in the other, in cells.
pub(super) fn difference(one: &[f32], other: &[f32]) -> f64 {
    one.iter().zip(other).map(|(a, b)| f64::from((a - b).abs())).sum()
}

/// Two values, within 1 %, that have fewer and more than `rank` of the levels (≥ 0) below them.
fn around_rank(levels: &[f32], rank: f64) -> [f32; 2] {
    // The bits of floats ≥ 0 rise as they do: their upper half is a bin.
    let mut bins = vec![0u32; 1 << 15];
    levels.iter().for_each(|level| bins[(level.max(0.0).to_bits() >> 16) as usize] += 1);
    let mut below = 0.0;
    let holds_rank = |count: &u32| {
        below += f64::from(*count);
        below >= rank
    };
    let bin = bins.iter().position(holds_rank).unwrap_or(bins.len() - 1) as u32;
    [f32::from_bits(bin << 16), f32::from_bits((bin + 1) << 16).min(f32::MAX)]
}

/// φ, or F_b, over each cell's segment, and how both distances change along it per unit of D.
struct Ranges {
    least: Vec<f32>,
    most: Vec<f32>,
    first: Vec<f32>,
    second: Vec<f32>,
}

impl Ranges {
    fn new(cells: usize) -> Self {
        let zeros = || vec![0.0; cells];
        Self { least: zeros(), most: zeros(), first: zeros(), second: zeros() }
    }
}

/// Fills, for each cell, the range of φ and the distances' slopes.
#[multiversion::multiversion(targets = "simd")]
fn level_ranges(kernel: &Kernel<f32>, half_edge: f32, measured: &Measured, ranges: &mut Ranges) {
    let cells = measured.first.iter().zip(&measured.second).zip(&measured.cosine);
    let slopes = ranges.first.iter_mut().zip(&mut ranges.second);
    let out = ranges.least.iter_mut().zip(&mut ranges.most).zip(slopes);
    for (((&first, &second), &cosine), ((least, most), (along_first, along_second))) in cells.zip(out) {
        let slopes = kernel.level_slopes(first, second);
        [*along_first, *along_second] = along_normal(slopes.by_first, slopes.by_second, cosine);
        let (one, two) = (*along_first * half_edge, *along_second * half_edge);
        let (behind, ahead) = (kernel.level(first - one, second - two), kernel.level(first + one, second + two));
        *least = if ahead < behind { ahead } else { behind };
        *most = if ahead < behind { behind } else { ahead };
    }
}

/// As [`level_ranges`], of F_b.
#[multiversion::multiversion(targets = "simd")]
fn value_ranges(kernel: &Kernel<f32>, half_edge: f32, measured: &Measured, ranges: &mut Ranges) {
    let cells = measured.first.iter().zip(&measured.second).zip(&measured.cosine);
    let slopes = ranges.first.iter_mut().zip(&mut ranges.second);
    let out = ranges.least.iter_mut().zip(&mut ranges.most).zip(slopes);
    for (((&first, &second), &cosine), ((least, most), (along_first, along_second))) in cells.zip(out) {
        let slopes = kernel.slopes(first, second);
        [*along_first, *along_second] = along_normal(slopes.by_first, slopes.by_second, cosine);
        let (one, two) = (*along_first * half_edge, *along_second * half_edge);
        let (behind, ahead) = (kernel.value(first - one, second - two), kernel.value(first + one, second + two));
        *least = if ahead < behind { ahead } else { behind };
        *most = if ahead < behind { behind } else { ahead };
    }
}

/// The slopes of both distances along ∇F_b, whose two parts are the distances' gradients, of length one and at a known
/// angle.
#[inline(always)]
fn along_normal(by_first: f32, by_second: f32, cosine: f32) -> [f32; 2] {
    let square = by_first * by_first + by_second * by_second + 2.0 * by_first * by_second * cosine;
    let per_length = 1.0 / square.max(NO_SLOPE).sqrt();
    [(by_first + by_second * cosine) * per_length, (by_first * cosine + by_second) * per_length]
}

/// Sixteen cells' segments: both distances at one end, and what they gain to the other.
#[derive(Clone, Copy)]
struct Segments {
    first: [f32; LANES],
    first_gain: [f32; LANES],
    second: [f32; LANES],
    second_gain: [f32; LANES],
}

impl Segments {
    /// F_b at a share of the way along one lane's segment.
    #[inline(always)]
    fn value(&self, kernel: &Kernel<f32>, lane: usize, share: f32) -> f32 {
        let first = self.first[lane] + self.first_gain[lane] * share;
        kernel.value(first, self.second[lane] + self.second_gain[lane] * share)
    }
}

/// The cells that the surface may cross.
struct Crossed {
    cells: Vec<usize>,
    segments: Vec<Segments>,
    fractions: Vec<[f32; LANES]>,
}

impl Crossed {
    fn new(volume: &Volume<'_>, ranges: &Ranges, cells: impl Iterator<Item = usize>) -> Self {
        let cells: Vec<usize> = cells.collect();
        let segments = cells.chunks(LANES).map(|lanes| {
            let mut out = Segments {
                first: [0.0; LANES],
                first_gain: [0.0; LANES],
                second: [0.0; LANES],
                second_gain: [0.0; LANES],
            };
            for (lane, &cell) in lanes.iter().enumerate() {
                let reach = [ranges.first[cell] * volume.half_edge, ranges.second[cell] * volume.half_edge];
                out.first[lane] = volume.measured.first[cell] - reach[0];
                out.second[lane] = volume.measured.second[cell] - reach[1];
                out.first_gain[lane] = 2.0 * reach[0];
                out.second_gain[lane] = 2.0 * reach[1];
            }
            out
        });
        let segments: Vec<Segments> = segments.collect();
        Self { fractions: vec![[0.0; LANES]; segments.len()], cells, segments }
    }

    /// Finds how much of each segment lies inside.
    fn fill(&mut self, kernel: &Kernel<f32>) {
        fractions_inside(kernel, &self.segments, &mut self.fractions);
    }

    fn each(&self) -> impl Iterator<Item = (usize, f32)> {
        self.cells.iter().copied().zip(self.fractions.iter().flatten().copied())
    }

    fn total(&self) -> f64 {
        self.each().map(|(_, fraction)| f64::from(fraction)).sum()
    }

    fn put_into(&self, fractions: &mut [f32]) {
        self.each().for_each(|(cell, fraction)| fractions[cell] = fraction);
    }
}

/// How much of each segment lies where F_b ≥ 0: its zero by regula falsi (Illinois), the same number of steps in every
/// lane.
#[multiversion::multiversion(targets = "simd")]
fn fractions_inside(kernel: &Kernel<f32>, segments: &[Segments], fractions: &mut [[f32; LANES]]) {
    for (segment, fractions) in segments.iter().zip(fractions) {
        let (mut low, mut high) = ([0.0f32; LANES], [1.0f32; LANES]);
        let (mut at_low, mut at_high) = ([0.0f32; LANES], [0.0f32; LANES]);
        // −1 where the low end stayed in the last step, 1 where the high end did.
        let mut stayed = [0.0f32; LANES];
        for lane in 0..LANES {
            at_low[lane] = segment.value(kernel, lane, 0.0);
            at_high[lane] = segment.value(kernel, lane, 1.0);
        }
        let ends = (at_low, at_high);
        for _ in 0..ZERO_STEPS {
            for lane in 0..LANES {
                let middle = zero_of_line(low[lane], high[lane], at_low[lane], at_high[lane]);
                let at_middle = segment.value(kernel, lane, middle);
                let high_moves = (at_middle >= 0.0) == (at_high[lane] >= 0.0);
                let stays = select_unpredictable(high_moves, -1.0, 1.0);
                let halved = if stays == stayed[lane] { 0.5 } else { 1.0 };
                low[lane] = select_unpredictable(high_moves, low[lane], middle);
                high[lane] = select_unpredictable(high_moves, middle, high[lane]);
                at_low[lane] = select_unpredictable(high_moves, at_low[lane] * halved, at_middle);
                at_high[lane] = select_unpredictable(high_moves, at_middle, at_high[lane] * halved);
                stayed[lane] = stays;
            }
        }
        for lane in 0..LANES {
            let (inside_low, inside_high) = (ends.0[lane] >= 0.0, ends.1[lane] >= 0.0);
            let zero = zero_of_line(low[lane], high[lane], at_low[lane], at_high[lane]);
            let crossed = if inside_high { 1.0 - zero } else { zero };
            let whole = if inside_high { 1.0 } else { 0.0 };
            fractions[lane] = if inside_low == inside_high { whole } else { crossed.clamp(0.0, 1.0) };
        }
    }
}

/// Where the line through two values is zero; `low` where it is level.
#[inline(always)]
fn zero_of_line(low: f32, high: f32, at_low: f32, at_high: f32) -> f32 {
    let rise = at_high - at_low;
    if rise == 0.0 { low } else { low - at_low * ((high - low) / rise) }
}

/// The zero of a rising function between two ends, to `tolerance` in its value, or the end that is nearest to having
/// one: regula falsi (Illinois), and a bisection now and then.
fn zero(mut low: f64, mut high: f64, tolerance: f64, mut rising: impl FnMut(f64) -> f64) -> f64 {
    let (mut at_low, mut at_high) = (rising(low), rising(high));
    if at_low >= 0.0 {
        return low;
    }
    if at_high <= 0.0 {
        return high;
    }
    let mut high_stayed = None;
    for step in 1..=60 {
        let middle =
            if step % 5 == 0 { 0.5 * (low + high) } else { (low * at_high - high * at_low) / (at_high - at_low) };
        let value = rising(middle);
        if value.abs() <= tolerance || high - low <= 1e-12 * high {
            return middle;
        }
        if value < 0.0 {
            at_high *= if high_stayed == Some(true) { 0.5 } else { 1.0 };
            (low, at_low, high_stayed) = (middle, value, Some(true));
        } else {
            at_low *= if high_stayed == Some(false) { 0.5 } else { 1.0 };
            (high, at_high, high_stayed) = (middle, value, Some(false));
        }
    }
    0.5 * (low + high)
}
