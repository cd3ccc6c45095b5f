//! Where cells are split: near the surface until the patch is right; away from it until a cell is small beside its
//! distance, and smaller where it lies across the medial axis.

use glam::{DVec3, UVec3};
use rayon::prelude::*;

use super::patch::{AXIS_BIT, Patch};
use super::samples::{Sample, Samples};
use super::tree::{Cell, CellPoints, NONE, Tree, halves_of, point_at};
use super::{BuildError, Settings};
use crate::distance::nearest::Watch;
use crate::field::Aabb;

/// Edges of a surface cell, in smallest cells, above which it is split unseen. Greater, and a bump can hide between
/// the points tried; smaller, and flat faces cost more cells than they need.
pub const LARGEST_AT_SURFACE: u32 = 8;

/// How far, in edges of the cell, an error of the gradient at a point tried is taken to go on and become one of the
/// value. Smaller, and a gradient that belongs to the other side of a crease goes unseen until a smaller cell takes it;
/// larger, and smooth cells are split for it.
pub const SLOPE_REACH: f64 = 0.0625;

/// The points of a cell in halves of its edge: its middle, then the middles of faces and edges.
pub fn middles() -> impl Iterator<Item = [u32; 3]> {
    (0..27).map(halves_of).filter(|halves| halves.contains(&1))
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
fn miss(patch: &Patch, points: &CellPoints, samples: &Samples) -> f64 {
    let sampled = |halves: [u32; 3]| (points[point_at(halves)] != NONE).then_some((halves, points[point_at(halves)]));
    let miss = |(halves, number)| miss_at(patch, halves, samples.numbered(number));
    middles().filter_map(sampled).map(miss).fold(0.0, f64::max)
}

/// The numbers of the samples at a cell's middles; none at its corners, nor where there is none.
fn sampled_middles(cell: &Cell, samples: &Samples) -> CellPoints {
    let mut points = [NONE; 27];
    for halves in middles() {
        points[point_at(halves)] = samples.number(cell.point(halves)).unwrap_or(NONE);
    }
    points
}

/// The same at one place, in halves of the cell's edge.
fn miss_at(patch: &Patch, halves: [u32; 3], sample: &Sample) -> f64 {
    let jet = patch.jet(halves.map(|h| f64::from(h) * 0.5));
    let turn = DVec3::new(jet[4], jet[2], jet[1]).distance(DVec3::from(sample.gradient));
    (jet[0] - sample.value).abs().max(turn * patch.edge * SLOPE_REACH)
}

/// How far the middle of a cell, which has that distance, is from where distances are asked for: from the levels, or from the
/// region where that is further.
fn away(cell: &Cell, distance: f64, samples: &Samples, settings: &Settings) -> f64 {
    let middle = samples.position(cell.point([1; 3]));
    let Aabb { min, max } = settings.region;
    settings.beyond_levels(distance).max(middle.distance(middle.clamp(min, max)))
}

/// Whether a cell is large beside how far it is away, so that its patch must be right.
fn is_near(cell: &Cell, away: f64, settings: &Settings) -> bool {
    f64::from(cell.size) * settings.smallest_cell > settings.ratio * away
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

/// `middle` is the sample there and how far that is away; `around` is where cells across the medial axis are split.
fn judged(
    cell: &Cell,
    patch: impl Fn() -> Patch,
    (middle, away): (&Sample, f64),
    settings: &Settings,
    around: [DVec3; 2],
) -> Verdict {
    let edge = f64::from(cell.size) * settings.smallest_cell;
    if is_near(cell, away, settings) {
        Verdict::Near
    } else if edge > settings.ratio_across * away
        && is_within(cell, around)
        && miss_at(&patch(), [1; 3], middle) > settings.tolerance_across
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

fn lone_patch_of(tree: &Tree, node: u32, samples: &Samples, edge: f64) -> Patch {
    lone_patch(&tree.corners[node as usize].map(|corner| samples.numbered(corner)), edge)
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
    let root = tree.cells[0];
    tree.corners[0] = corners(&root).map(|corner| samples.number(corner).unwrap_or(NONE));
    let mut active = vec![0_u32];
    while let Some(&first) = active.first() {
        let size = tree.cells[first as usize].size;
        if size == 1 {
            break;
        }
        let cells: Vec<Cell> = active.iter().map(|&node| tree.cells[node as usize]).collect();
        samples.request(&cells, |cell| [cell.point([1; 3])], |_| {})?;
        let edge = f64::from(size) * settings.smallest_cell;
        let judge = |(&node, cell): (&u32, &Cell)| {
            let middle = samples.get(cell.point([1; 3]));
            let middle = (middle, away(cell, middle.value, samples, settings));
            let verdict = judged(cell, || lone_patch_of(tree, node, samples, edge), middle, settings, around);
            (verdict != Verdict::Small).then_some((node, *cell, verdict))
        };
        let tried: Vec<(u32, Cell, Verdict)> = active.par_iter().zip(&cells).filter_map(judge).collect();
        // Work grows about fourfold with each level.
        let share = |level: u32| super::REFINING * 0.25_f64.powi(level as i32);
        let (from, to) = (share(size.trailing_zeros()), share(size.trailing_zeros() - 1));
        let progress = |part| (watch.progress)(from + (to - from) * part);
        samples.request(&tried, |(_, cell, _)| all_middles(cell), progress)?;
        let try_out = |(node, cell, verdict): &(u32, Cell, Verdict)| {
            let points = sampled_middles(cell, samples);
            // The surface may pass through a cell whose middle is nearer to it than a corner.
            let middle = samples.numbered(points[point_at([1; 3])]);
            let at_surface = away(cell, middle.value, samples, settings) <= 0.87 * edge;
            let splits = *verdict == Verdict::Across
                || (at_surface && size > LARGEST_AT_SURFACE)
                || miss(&lone_patch_of(tree, *node, samples, edge), &points, samples) > settings.tolerance;
            splits.then_some((*node, points))
        };
        let split: Vec<(u32, CellPoints)> = tried.par_iter().filter_map(try_out).collect();
        active.clear();
        for (node, points) in split {
            let first = tree.split(node);
            tree.number(node, &points);
            active.extend(first..first + 8);
        }
        memory(tree, samples)?;
    }
    let all = 0..tree.cells.len() as u32;
    let split: Vec<u32> = all.filter(|&node| tree.children[node as usize] != 0).collect();
    balance(tree, split, samples)?;
    memory(tree, samples)
}

/// Balances a tree whose leaves were balanced before `split` were.
fn balance(tree: &mut Tree, split: Vec<u32>, samples: &mut Samples) -> Result<(), BuildError> {
    let split = tree.balance(split);
    sample_children(tree, &split, samples)
}

/// Takes the samples at the corners of the children of nodes, parents before their children.
fn sample_children(tree: &mut Tree, split: &[u32], samples: &mut Samples) -> Result<(), BuildError> {
    let cells: Vec<Cell> = split.iter().map(|&node| tree.cells[node as usize]).collect();
    samples.request(&cells, all_middles, |_| {})?;
    let points: Vec<CellPoints> = cells.par_iter().map(|cell| sampled_middles(cell, samples)).collect();
    split.iter().zip(&points).for_each(|(&node, points)| tree.number(node, points));
    Ok(())
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
            if cell.size == 1 {
                return false;
            }
            let patch = patch(leaf, cell);
            is_near(cell, away(cell, patch.jet([0.5; 3])[0], samples, settings), settings)
                && miss(&patch, &sampled_middles(cell, samples), samples) > 2.0 * settings.tolerance
        })
        .map(|(_, &node)| node)
        .collect();
    for &node in &wrong {
        tree.split(node);
    }
    sample_children(tree, &wrong, samples)?;
    let any = !wrong.is_empty();
    balance(tree, wrong, samples)?;
    Ok(any)
}
