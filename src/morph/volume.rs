//! The volume inside a section of a morph, and the a₀ that encloses a given volume.
//!
//! F_b ≥ 0 exactly where φ = −(g₁ ∨₀ g₂)/disp ≤ a₀, so a₀ is a quantile of φ. Cells at the surface count by the
//! fraction of them that is inside: of the segment through the cell's middle, along the surface's normal, as long as
//! a cell's edge. On it both distances are taken as linear, which they nearly are; F_b is not, so its zero is searched.

use super::coarse::{CoarseGrid, Measured};
use super::section::{Kernel, Section};

/// The sum of squares below which both slopes are taken as zero.
const NO_SLOPE: f32 = 1e-20;

/// How both distances change along the surface's normal, per unit of D, at one cell.
#[derive(Clone, Copy, Debug, Default)]
struct Along {
    first: f32,
    second: f32,
}

/// A section of a morph over the coarse grid.
pub(super) struct Volume<'a> {
    measured: &'a Measured,
    section: Section,
    /// Half a cell's edge in units of D.
    half_edge: f64,
}

/// A blend's amount and what it encloses.
pub(super) struct Enclosing {
    pub a0: f64,
    /// The fraction inside of each cell.
    pub fractions: Vec<f32>,
}

/// A cell that the surface may cross.
struct Crossed {
    /// φ, or F_b, over the segment.
    range: [f64; 2],
    /// The distances at the segment's ends.
    first: [f64; 2],
    second: [f64; 2],
}

impl<'a> Volume<'a> {
    pub(super) fn new(grid: &CoarseGrid, measured: &'a Measured, unit: f64, section: Section) -> Self {
        Self { measured, section, half_edge: 0.5 * grid.edge() / unit }
    }

    /// The a₀ whose section holds `target` cells, at a rising section whose own a₀ does not matter, and the fraction
    /// inside of each cell.
    pub(super) fn enclosing(&self, target: f64) -> Enclosing {
        let kernel = Kernel::<f32>::new(&Section { a0: 1.0, ..self.section });
        let cells = self.measured.first.len();
        let (mut least, mut most) = (vec![0.0; cells], vec![0.0; cells]);
        let mut along = vec![Along::default(); cells];
        level_ranges(&kernel, self.half_edge as f32, self.measured, &mut least, &mut most, &mut along);
        let rank = |rank: f64| (rank.max(0.0) as usize).min(cells - 1);
        let low = nth(&least, rank(target.floor()));
        let high = nth(&most, rank(target.ceil() - 1.0)).max(low);
        let crossed = (0..cells).filter(|&i| least[i] < high && most[i] > low);
        let mut search = Search {
            volume: self,
            inside: most.iter().filter(|level| **level <= low).count() as f64 - target,
            crossed: crossed.map(|i| self.crossed(i, along[i], [least[i], most[i]])).collect(),
        };
        let a0 = search.run([f64::from(low), f64::from(high)], target * 1e-7);
        let kernel = Kernel::<f64>::new(&Section { a0, ..self.section });
        let fraction = |i: usize| match (f64::from(least[i]) >= a0, f64::from(most[i]) <= a0) {
            (_, true) => 1.0,
            (true, _) => 0.0,
            _ => fraction_inside(&kernel, &self.crossed(i, along[i], [least[i], most[i]])) as f32,
        };
        Enclosing { a0, fractions: (0..cells).map(fraction).collect() }
    }

    /// The fraction inside of each cell.
    pub(super) fn fractions(&self) -> Vec<f32> {
        let fast = Kernel::<f32>::new(&self.section);
        let exact = Kernel::<f64>::new(&self.section);
        let cells = self.measured.first.len();
        let (mut least, mut most) = (vec![0.0; cells], vec![0.0; cells]);
        let mut along = vec![Along::default(); cells];
        value_ranges(&fast, self.half_edge as f32, self.measured, &mut least, &mut most, &mut along);
        (0..cells)
            .map(|i| match (least[i] >= 0.0, most[i] < 0.0) {
                (true, _) => 1.0,
                (_, true) => 0.0,
                _ => fraction_inside(&exact, &self.crossed(i, along[i], [least[i], most[i]])) as f32,
            })
            .collect()
    }

    fn crossed(&self, cell: usize, along: Along, range: [f32; 2]) -> Crossed {
        let ends = |middle: f32, slope: f32| {
            let reach = f64::from(slope) * self.half_edge;
            [f64::from(middle) - reach, f64::from(middle) + reach]
        };
        Crossed {
            range: range.map(f64::from),
            first: ends(self.measured.first[cell], along.first),
            second: ends(self.measured.second[cell], along.second),
        }
    }
}

/// The fraction inside of each cell of one object, from its distances in units of D.
pub(super) fn object_fractions(grid: &CoarseGrid, distances: &[f32], unit: f64) -> Vec<f32> {
    let per_edge = (unit / grid.edge()) as f32;
    distances.iter().map(|distance| (0.5 + distance * per_edge).clamp(0.0, 1.0)).collect()
}

/// The sum of the fractions, in cells.
pub(super) fn total(fractions: &[f32]) -> f64 {
    fractions.iter().map(|fraction| f64::from(*fraction)).sum()
}

/// The volume in one but not in the other, in cells.
pub(super) fn difference(one: &[f32], other: &[f32]) -> f64 {
    one.iter().zip(other).map(|(a, b)| f64::from((a - b).abs())).sum()
}

fn nth(levels: &[f32], rank: usize) -> f32 {
    let mut levels = levels.to_vec();
    *levels.select_nth_unstable_by(rank, f32::total_cmp).1
}

/// Fills, for each cell, φ at both ends of its segment, sorted, and the distances' slopes on it.
#[multiversion::multiversion(targets = "simd")]
fn level_ranges(
    kernel: &Kernel<f32>,
    half_edge: f32,
    measured: &Measured,
    least: &mut [f32],
    most: &mut [f32],
    along: &mut [Along],
) {
    let cells = measured.first.iter().zip(&measured.second).zip(&measured.cosine);
    let out = least.iter_mut().zip(most).zip(along);
    for (((&first, &second), &cosine), ((least, most), along)) in cells.zip(out) {
        let slopes = kernel.level_slopes(first, second);
        *along = along_normal(slopes.by_first, slopes.by_second, cosine);
        let (one, two) = (along.first * half_edge, along.second * half_edge);
        let (behind, ahead) = (kernel.level(first - one, second - two), kernel.level(first + one, second + two));
        *least = if ahead < behind { ahead } else { behind };
        *most = if ahead < behind { behind } else { ahead };
    }
}

/// As [`level_ranges`], of F_b.
#[multiversion::multiversion(targets = "simd")]
fn value_ranges(
    kernel: &Kernel<f32>,
    half_edge: f32,
    measured: &Measured,
    least: &mut [f32],
    most: &mut [f32],
    along: &mut [Along],
) {
    let cells = measured.first.iter().zip(&measured.second).zip(&measured.cosine);
    let out = least.iter_mut().zip(most).zip(along);
    for (((&first, &second), &cosine), ((least, most), along)) in cells.zip(out) {
        let slopes = kernel.slopes(first, second);
        *along = along_normal(slopes.by_first, slopes.by_second, cosine);
        let (one, two) = (along.first * half_edge, along.second * half_edge);
        let (behind, ahead) = (kernel.value(first - one, second - two), kernel.value(first + one, second + two));
        *least = if ahead < behind { ahead } else { behind };
        *most = if ahead < behind { behind } else { ahead };
    }
}

/// The slopes of both distances along ∇F_b, whose two parts are the distances' gradients, of length one and at a known
/// angle.
#[inline(always)]
fn along_normal(by_first: f32, by_second: f32, cosine: f32) -> Along {
    let square = by_first * by_first + by_second * by_second + 2.0 * by_first * by_second * cosine;
    let per_length = 1.0 / square.max(NO_SLOPE).sqrt();
    Along { first: (by_first + by_second * cosine) * per_length, second: (by_first * cosine + by_second) * per_length }
}

/// How much of a cell's segment lies where F_b ≥ 0, by regula falsi (Illinois).
fn fraction_inside(kernel: &Kernel<f64>, cell: &Crossed) -> f64 {
    let at = |s: f64| {
        let along = |ends: [f64; 2]| ends[0] + (ends[1] - ends[0]) * s;
        kernel.value(along(cell.first), along(cell.second))
    };
    let (mut low, mut high) = (0.0, 1.0);
    let (mut at_low, mut at_high) = (at(low), at(high));
    if (at_low >= 0.0) == (at_high >= 0.0) {
        return if at_low >= 0.0 { 1.0 } else { 0.0 };
    }
    let rising = at_high >= 0.0;
    // Which end stayed in the last step: its value is halved when it stays again.
    let mut stayed = None;
    for _ in 0..24 {
        let middle = (low * at_high - high * at_low) / (at_high - at_low);
        let at_middle = at(middle);
        let step;
        if (at_middle >= 0.0) == rising {
            step = high - middle;
            (high, at_high) = (middle, at_middle);
            at_low *= if stayed == Some(false) { 0.5 } else { 1.0 };
            stayed = Some(false);
        } else {
            step = middle - low;
            (low, at_low) = (middle, at_middle);
            at_high *= if stayed == Some(true) { 0.5 } else { 1.0 };
            stayed = Some(true);
        }
        if step < 1e-5 {
            break;
        }
    }
    let root = if at_high == at_low { low } else { (low * at_high - high * at_low) / (at_high - at_low) };
    if rising { 1.0 - root } else { root }
}

/// The search for a₀ among the cells that it decides on.
struct Search<'a> {
    volume: &'a Volume<'a>,
    /// Cells inside whatever a₀ is, less those to be enclosed.
    inside: f64,
    crossed: Vec<Crossed>,
}

impl Search<'_> {
    /// Two steps of regula falsi, then one of bisection, in turn, until the volume is within `tolerance` cells.
    fn run(&mut self, [mut low, mut high]: [f64; 2], tolerance: f64) -> f64 {
        let (mut at_low, mut at_high) = (self.excess(low), self.excess(high));
        if at_low >= 0.0 {
            return low;
        }
        if at_high <= 0.0 {
            return high;
        }
        for step in 0..60 {
            let bisect = step % 3 == 2;
            let middle = if bisect { 0.5 * (low + high) } else { (low * at_high - high * at_low) / (at_high - at_low) };
            let value = self.excess(middle);
            if value.abs() <= tolerance || high - low <= 1e-12 * high {
                return middle;
            }
            if value < 0.0 {
                (low, at_low) = (middle, value);
            } else {
                (high, at_high) = (middle, value);
            }
            self.narrow(low, high);
        }
        0.5 * (low + high)
    }

    fn excess(&self, a0: f64) -> f64 {
        let kernel = Kernel::<f64>::new(&Section { a0, ..self.volume.section });
        self.inside + self.crossed.iter().map(|cell| fraction_inside(&kernel, cell)).sum::<f64>()
    }

    /// Drops the cells that are wholly in or out for every a₀ left.
    fn narrow(&mut self, low: f64, high: f64) {
        let mut inside = 0.0;
        self.crossed.retain(|cell| {
            let within = cell.range[1] <= low;
            inside += f64::from(u8::from(within));
            !within && cell.range[0] < high
        });
        self.inside += inside;
    }
}
