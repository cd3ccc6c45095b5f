//! Where cells are split: near the surface until the patch is right; away from it until a cell is small beside its
//! distance, and smaller where it lies across the medial axis.

use glam::{DVec3, UVec3};
use rayon::prelude::*;

use super::patch::{AXIS_BIT, Patch};
use super::samples::{Sample, Samples};
use super::tree::{Cell, Tree};
use super::{BuildError, Settings};
use crate::distance::nearest::Watch;

/// Edges of a surface cell, in smallest cells, above which it is split unseen. Greater, and a bump can hide between
/// the points tried; smaller, and flat faces cost more cells than they need.
const LARGEST_AT_SURFACE: u32 = 8;

/// How far, in edges of the cell, an error of the gradient at a point tried is taken to go on and become one of the
/// value. Smaller, and a gradient that belongs to the other side of a crease goes unseen until a smaller cell takes it;
/// larger, and smooth cells are split for it.
const SLOPE_REACH: f64 = 0.0625;

/// The points of a cell in halves of its edge: its middle, then the middles of faces and edges.
fn middles() -> impl Iterator<Item = [u32; 3]> {
    let all = (0..27).map(|i| [i / 9, i / 3 % 3, i % 3]);
    all.filter(|p: &[u32; 3]| p.contains(&1))
}

fn corners(cell: &Cell) -> [[u32; 3]; 8] {
    std::array::from_fn(|corner| cell.corner(corner))
}

/// The patch of a cell by itself: mixed derivatives are differences of the gradients along its own edges.
pub fn lone_patch(corners: &[&Sample; 8], edge: f64) -> Patch {
    let gradient = |corner: usize, axis: usize| corners[corner].gradient[axis];
    // ∂/∂a of the gradient's component b at a corner.
    let along = |corner: usize, a: usize, b: usize| {
        let bit = AXIS_BIT[a];
        (gradient(corner | bit, b) - gradient(corner & !bit, b)) / edge
    };
    let twist = |corner: usize, a: usize, b: usize| 0.5 * (along(corner, a, b) + along(corner, b, a));
    // ∂³F/∂a∂b∂c, constant over the cell: the second difference of the component c.
    let second = |a: usize, b: usize, c: usize| {
        let (bit, bits) = (AXIS_BIT[b], AXIS_BIT[c]);
        let mut sum = 0.0;
        for side in [0, bits] {
            sum += 0.5 * (along(bit | side, a, c) - along(side, a, c)) / edge;
        }
        sum
    };
    let triple = (second(0, 1, 2) + second(1, 2, 0) + second(2, 0, 1)) / 3.0;
    let jet = |corner: usize| {
        let s = corners[corner];
        let g = s.gradient;
        let (xy, xz, yz) = (twist(corner, 0, 1), twist(corner, 0, 2), twist(corner, 1, 2));
        [s.value, g[2], g[1], yz, g[0], xz, xy, triple]
    };
    Patch { corners: std::array::from_fn(jet), edge }
}

/// How far a patch misses the truth at those middles of its cell that have samples, or may miss it beside them for
/// the error of its gradient there.
fn miss(patch: &Patch, cell: &Cell, samples: &Samples) -> f64 {
    let miss = |halves: [u32; 3]| Some(miss_at(patch, halves, samples.find(cell.point(halves))?));
    middles().filter_map(miss).fold(0.0, f64::max)
}

/// The same at one place, in halves of the cell's edge.
fn miss_at(patch: &Patch, halves: [u32; 3], sample: &Sample) -> f64 {
    let jet = patch.jet(halves.map(|h| f64::from(h) * 0.5));
    let turn = DVec3::new(jet[4], jet[2], jet[1]).distance(DVec3::from(sample.gradient));
    (jet[0] - sample.value).abs().max(turn * patch.edge * SLOPE_REACH)
}

/// Whether a cell is large beside the distance of its middle to the surface, so that its patch must be right.
fn is_near(cell: &Cell, middle: f64, settings: &Settings) -> bool {
    f64::from(cell.size) * settings.smallest_cell > settings.ratio * middle.abs()
}

/// What is to be done with a cell whose corners and middle have samples.
#[derive(Clone, Copy, PartialEq)]
enum Verdict {
    /// It stays.
    Small,
    /// It is near the surface, and tried at all its middles.
    Near,
    /// It lies across the medial axis: it is split.
    Across,
}

/// `around` is where cells across the medial axis are split.
fn judged(cell: &Cell, samples: &Samples, settings: &Settings, around: [DVec3; 2]) -> Verdict {
    let (edge, middle) = (f64::from(cell.size) * settings.smallest_cell, samples.get(cell.point([1; 3])));
    if is_near(cell, middle.value, settings) {
        Verdict::Near
    } else if edge > settings.ratio_across * middle.value.abs()
        && is_within(cell, around)
        && miss_at(&lone_patch_of(cell, samples, edge), [1; 3], middle) > settings.tolerance_across
    {
        // A smooth distance misses far less in cells so small beside it.
        Verdict::Across
    } else {
        Verdict::Small
    }
}

/// Whether some of a cell lies between two places, in smallest cells.
fn is_within(cell: &Cell, [least, greatest]: [DVec3; 2]) -> bool {
    let origin = UVec3::from(cell.origin).as_dvec3();
    origin.cmplt(greatest).all() && (origin + f64::from(cell.size)).cmpgt(least).all()
}

fn lone_patch_of(cell: &Cell, samples: &Samples, edge: f64) -> Patch {
    lone_patch(&corners(cell).map(|corner| samples.get(corner)), edge)
}

fn all_middles(cell: &Cell) -> impl Iterator<Item = [u32; 3]> + use<> {
    let cell = *cell;
    middles().map(move |halves| cell.point(halves))
}

/// Splits from the root down and balances.
pub fn refine(
    tree: &mut Tree,
    samples: &mut Samples,
    settings: &Settings,
    memory: impl Fn(&Tree, &Samples) -> Result<(), BuildError>,
    watch: &Watch,
) -> Result<(), BuildError> {
    // Not up to the root's border, from where the field goes on by what it is there.
    let reach = settings.region.size().max_element();
    let around = settings.region.grown(reach);
    let around = [around.min, around.max].map(|corner| samples.in_smallest_cells(corner));
    samples.request(&tree.cells[..1], corners, |_| {})?;
    let mut active = vec![0_u32];
    while !active.is_empty() {
        let cells: Vec<Cell> = active.iter().map(|&node| tree.cells[node as usize]).collect();
        let size = cells[0].size;
        if size == 1 {
            break;
        }
        samples.request(&cells, |cell| [cell.point([1; 3])], |_| {})?;
        let verdicts: Vec<Verdict> = cells.par_iter().map(|cell| judged(cell, samples, settings, around)).collect();
        let all = std::mem::take(&mut active).into_iter().zip(cells).zip(verdicts);
        let tried: Vec<((u32, Cell), Verdict)> = all.filter(|(_, verdict)| *verdict != Verdict::Small).collect();
        // Work grows about fourfold with each level.
        let share = |level: u32| super::REFINING * 0.25_f64.powi(level as i32);
        let (from, to) = (share(size.trailing_zeros()), share(size.trailing_zeros() - 1));
        let progress = |part| (watch.progress)(from + (to - from) * part);
        samples.request(&tried, |((_, cell), _)| all_middles(cell), progress)?;
        let edge = f64::from(size) * settings.smallest_cell;
        let split: Vec<bool> = tried
            .par_iter()
            .map(|((_, cell), verdict)| {
                // The surface may pass through a cell whose middle is nearer to it than a corner.
                let at_surface = samples.get(cell.point([1; 3])).value.abs() <= 0.87 * edge;
                *verdict == Verdict::Across
                    || (at_surface && size > LARGEST_AT_SURFACE)
                    || miss(&lone_patch_of(cell, samples, edge), cell, samples) > settings.tolerance
            })
            .collect();
        for (((node, _), _), _) in tried.iter().zip(&split).filter(|(_, split)| **split) {
            let first = tree.split(*node);
            active.extend(first..first + 8);
        }
        memory(tree, samples)?;
    }
    balance(tree, samples)?;
    memory(tree, samples)
}

fn balance(tree: &mut Tree, samples: &mut Samples) -> Result<(), BuildError> {
    let split = tree.balance();
    samples.request(&split, all_middles, |_| {})
}

/// Splits the leaves whose final patches are wrong: their mixed derivatives, and corners that hang, are not those
/// that [`refine`] tried. Returns whether there were any.
pub fn refine_again(
    tree: &mut Tree,
    order: &[u32],
    patch: impl Fn(usize, &Cell) -> Patch + Sync,
    samples: &mut Samples,
    settings: &Settings,
) -> Result<bool, BuildError> {
    let wrong: Vec<u32> = order
        .par_iter()
        .enumerate()
        .filter(|&(leaf, &node)| {
            let cell = &tree.cells[node as usize];
            let patch = patch(leaf, cell);
            cell.size > 1
                && is_near(cell, patch.jet([0.5; 3])[0], settings)
                && miss(&patch, cell, samples) > 2.0 * settings.tolerance
        })
        .map(|(_, &node)| node)
        .collect();
    for &node in &wrong {
        tree.split(node);
    }
    let split: Vec<Cell> = wrong.iter().map(|&node| tree.cells[node as usize]).collect();
    samples.request(&split, all_middles, |_| {})?;
    balance(tree, samples)?;
    Ok(!wrong.is_empty())
}

/// All middles of a cell in halves of its edge, for those who look for hanging corners.
pub fn middles_of(cell: &Cell) -> impl Iterator<Item = ([u32; 3], [u32; 3])> + use<> {
    let cell = *cell;
    middles().map(move |halves| (halves, cell.point(halves)))
}
