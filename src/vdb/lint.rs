//! What is wrong with a file of any maker, before another program shows it wrong without a word.
//!
//! Distances: sign, background, filled inside, slope; colours: range, and the same voxels as the level set's; names
//! and statistics. Numbers in messages are as the file has them, where level sets are negative inside.

use std::path::Path;

use glam::{DVec3, IVec3};
use serde::Serialize;

use super::active::{active_values, missing_voxels};
use super::clients::{self, Subject};
use super::finding::{Finding, Severity};
use super::programs::Client;
use super::read::{Opened, StoredClass, band_of};
use super::voxels::{SparseBlocks, Voxels};
use super::walk::{GridLayout, Layout, Transform};
use super::{Error, MetadataValue};
use crate::grid::{VoxelSize, measure};

/// The newest format that OpenVDB 10 to 12 read without a warning.
const FORMAT: u32 = 224;
/// The least half width, in voxels, that a level set is meshed and sampled from, and the one that tools expect.
const HALF_WIDTHS: [f64; 2] = [1.5, 3.0];
/// A background of more voxels than this is no band: its values are probably counted in voxels, not world units.
const WIDEST: f64 = 100.0;
/// How far values may pass the background, as a share of it: 16 bits round by half of this.
const ROUNDING: f32 = 1e-3;
/// The share of voxels with a wrong slope above which values are no distances. True distances have creases, where
/// the slope has a jump: half of the voxels of the most faceted object tried, at voxels as large as its facets.
const WRONG_SLOPES: f64 = 0.8;

/// What a file holds, and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lint {
    /// The grids' names, in the file's order.
    pub grids: Vec<String>,
    /// What is wrong, in the order of the grids.
    pub findings: Vec<Finding>,
}

/// Checks a file: by what all programs need, and by what some need.
///
/// # Errors
/// Those of [`super::read()`]: a file that cannot be read at all.
pub fn lint(path: impl AsRef<Path>, clients: &[Client]) -> Result<Lint, Error> {
    let path = path.as_ref();
    let opened = Opened::open(path)?;
    let layout = &opened.layout;
    let mut findings = Vec::new();
    check_file(layout, &mut findings);
    if let Some(problem) = clients::frame_number(path, &layout.metadata) {
        findings.push(Finding { severity: Severity::Warning, client: None, grid: None, problem });
    }
    let mut grids = Vec::with_capacity(layout.grids.len());
    for grid in &layout.grids {
        grids.push((grid, opened.voxels(grid)?));
    }
    let surface = grids.iter().find_map(|(grid, voxels)| match voxels {
        Some(Voxels::Floats(blocks)) if StoredClass::of(&grid.metadata) == StoredClass::LevelSet => {
            Some((*grid, blocks))
        }
        _ => None,
    });
    for (grid, voxels) in &grids {
        let mut notes = Notes { grid: &grid.name, findings: &mut findings };
        check_name(grid, &mut notes);
        match voxels {
            Some(Voxels::Floats(blocks)) => check_floats(grid, blocks, &mut notes),
            Some(Voxels::Vectors(blocks)) => check_vectors(grid, blocks, surface, &mut notes),
            None => notes.warn(format!("its type, {}, is not checked", grid.tree_type)),
        }
    }
    let subject = Subject { path, layout, grids: &grids };
    for &client in clients {
        let found = clients::check(client, &subject).into_iter();
        findings.extend(found.map(|(severity, grid, problem)| Finding {
            severity,
            client: Some(client),
            grid,
            problem,
        }));
    }
    Ok(Lint { grids: layout.grids.iter().map(|grid| grid.name.clone()).collect(), findings })
}

/// What is found of one grid.
struct Notes<'a> {
    grid: &'a str,
    findings: &'a mut Vec<Finding>,
}

impl Notes<'_> {
    fn add(&mut self, severity: Severity, problem: String) {
        self.findings.push(Finding { severity, client: None, grid: Some(self.grid.into()), problem });
    }

    fn error(&mut self, problem: impl Into<String>) {
        self.add(Severity::Error, problem.into());
    }

    fn warn(&mut self, problem: impl Into<String>) {
        self.add(Severity::Warning, problem.into());
    }
}

fn check_file(layout: &Layout, findings: &mut Vec<Finding>) {
    let mut add = |severity, problem| findings.push(Finding { severity, client: None, grid: None, problem });
    if layout.grids.is_empty() {
        add(Severity::Error, "it holds no grid; was it written to its end?".into());
    }
    if layout.format > FORMAT {
        let problem = format!("its format is {}; programs with OpenVDB 12 or older expect {FORMAT}", layout.format);
        add(Severity::Warning, problem);
    }
}

fn check_name(grid: &GridLayout, notes: &mut Notes) {
    // The second of two grids of one name, alone, has a number behind it in the file.
    // A grid without a name always has.
    if grid.unique_name != grid.name && !grid.name.is_empty() {
        notes.error("another grid has this name: programs reach only one of them; rename one");
    }
    if grid.name.is_empty() {
        notes.error("it has no name: programs ask for grids by name");
    } else if grid.name.contains(|c: char| c.is_whitespace() || c.is_control()) {
        notes.warn("there is white space in its name, which has to be typed exactly");
    }
    if !grid.metadata.contains_key("file_voxel_count") {
        notes.warn("it has no statistics (file_bbox_min …): renderers find bounds by them; write them with it");
    }
}

fn check_floats(grid: &GridLayout, blocks: &SparseBlocks<f32>, notes: &mut Notes) {
    let class = StoredClass::of(&grid.metadata);
    if !is_finite(blocks, |value| value.is_finite(), notes) {
        return;
    }
    if class == StoredClass::LevelSet {
        return check_level_set(grid, blocks, notes);
    }
    let (least, greatest) = active_values(blocks)
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(least, greatest), value| (least.min(value), greatest.max(value)));
    let outside = blocks.background;
    let like_a_band = |end: f32| (0.5..1.1).contains(&(end.abs() / outside.abs()));
    if outside != 0.0 && least < 0.0 && greatest > 0.0 && like_a_band(least) && like_a_band(greatest) {
        notes.error(format!("its values are those of a level set and its class is {class}: it is shown as smoke; set its class to level set"));
    } else if class == StoredClass::FogVolume && least < 0.0 {
        notes.warn(format!("a density of {least} is negative; clamp it to 0"));
    }
}

fn check_level_set(grid: &GridLayout, blocks: &SparseBlocks<f32>, notes: &mut Notes) {
    if blocks.active.is_empty() && blocks.tiles.is_empty() {
        return notes.warn("it is empty; delete the frame if that was not meant");
    }
    let Some(voxel_size) = cubic(&grid.transform) else {
        return notes.error("its voxels are no cubes, so its values are no distances; resample it");
    };
    let background = 0.0 - blocks.background;
    let half_width = f64::from(background) / voxel_size.get();
    if background == 0.0 {
        return notes.error(
            "its background is 0, so all that is far outside lies on the surface; make it the half width of the band",
        );
    }
    if background < 0.0 {
        return notes.error(format!(
            "its background is {background}; outside is positive in a level set: turn its signs round"
        ));
    }
    if half_width > WIDEST {
        return notes.error(format!(
            "its background, {background}, is {half_width:.0} voxels wide: distances are in world units, not in voxels"
        ));
    }
    let voxels = format!("its band is {half_width:.2} voxels wide on each side");
    if half_width < HALF_WIDTHS[0] - 1e-3 {
        notes.error(format!("{voxels}: too thin to mesh and to sample; write 3"));
    } else if half_width < HALF_WIDTHS[1] - 1e-3 {
        notes.warn(format!("{voxels}; tools expect {}", HALF_WIDTHS[1]));
    }
    let limit = background * (1.0 + ROUNDING);
    let beyond = active_values(blocks).filter(|value| value.abs() > limit).count();
    if beyond > 0 {
        notes.error(format!("{beyond} active values lie beyond its background, {background}; clamp them to it"));
    }
    let band = band_of(blocks, IVec3::ZERO, voxel_size, half_width as f32);
    let slope = measure::slope_error(&band);
    if slope.off as f64 > WRONG_SLOPES * slope.voxels as f64 {
        let in_voxels = ((1.0 + slope.mean) * voxel_size.get() - 1.0).abs() < 0.2;
        let why = if in_voxels { "in voxels and not in world units" } else { "no distances; renormalise it" };
        return notes
            .error(format!("the slope of its values is {:.2} away from 1 in the mean: they are {why}", slope.mean));
    }
    if !measure::has_inside(&band) {
        let deepest = measure::deepest(&band) / voxel_size.get();
        return notes.error(format!(
            "nothing is inside: of all voxels the deepest lies {deepest:.2} voxels below the surface (below 0 is outside); \
             its mesh is nothing, or crumbs; make it thicker, or the voxels smaller"
        ));
    }
    let torn = measure::tears(&band);
    if let Some(first) = torn.first {
        notes.error(format!(
            "the sign changes at {} places where no surface is, one near {}: the inside is not filled, or signs are \
             the wrong way round (negative is inside)",
            torn.pairs,
            place(&grid.transform, first)
        ));
    }
    let steep = measure::steep_steps(&band);
    if let Some(first) = steep.first {
        notes.warn(format!(
            "{} pairs of neighbours differ by more than the voxel between them, one near {}",
            steep.pairs,
            place(&grid.transform, first)
        ));
    }
}

fn check_vectors(
    grid: &GridLayout,
    blocks: &SparseBlocks<[f32; 3]>,
    surface: Option<(&GridLayout, &SparseBlocks<f32>)>,
    notes: &mut Notes,
) {
    let vector_type = match grid.metadata.get("vector_type") {
        Some(MetadataValue::Text(text)) => text.as_str(),
        _ => "invariant",
    };
    if !is_finite(blocks, |value| value.iter().all(|part| part.is_finite()), notes) {
        return;
    }
    if clients::is_velocity(grid) {
        return;
    }
    if vector_type != "invariant" {
        notes.warn(format!("its vectors are {vector_type}: a transform turns its colours; make it invariant"));
    }
    let count = |test: fn(&f32) -> bool| active_values(blocks).filter(|value| value.iter().any(test)).count();
    let (negative, bright) = (count(|part| *part < 0.0), count(|part| *part > 1.0));
    if negative > 0 {
        notes.error(format!("{negative} colours have a negative channel; clamp them to 0"));
    }
    if bright > 0 {
        notes.warn(format!("{bright} colours have a channel above 1: no surface reflects more than it gets; scale them unless they are meant so"));
    }
    let Some((other, surface)) = surface else { return };
    if other.transform != grid.transform {
        return notes.warn(format!("its voxels do not stand where those of '{}' stand", other.name));
    }
    let missing = missing_voxels(surface, blocks);
    if missing > 0 {
        notes.error(format!(
            "{missing} active voxels of '{}' have no active value here: its mesh takes the background's colour there; write it on the same voxels",
            other.name
        ));
    }
    if blocks.background == [0.0; 3] && !blocks.active.is_empty() {
        notes.warn("its background is black: edges of the band are darkened; make it the mean colour");
    }
}

/// Whether all values are finite numbers; says so where not.
fn is_finite<T: Copy>(blocks: &SparseBlocks<T>, test: impl Fn(T) -> bool, notes: &mut Notes) -> bool {
    let wrong = active_values(blocks).chain([blocks.background]).filter(|value| !test(*value)).count();
    if wrong > 0 {
        notes.error(format!("{wrong} values are not finite numbers; look for a division by 0 in what made them"));
    }
    wrong == 0
}

/// The edge of voxels that are cubes, turned or not.
fn cubic(transform: &Transform) -> Option<VoxelSize> {
    let Transform::Affine(matrix) = transform else { return None };
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate());
    let size = axes[0].length();
    let equal = axes.iter().all(|axis| (axis.length() - size).abs() <= 1e-6 * size);
    let square = (0..3).all(|i| axes[i].dot(axes[(i + 1) % 3]).abs() <= 1e-6 * size * size);
    if equal && square { VoxelSize::new(size) } else { None }
}

/// A voxel's place in words: in the world where there is one.
fn place(transform: &Transform, voxel: IVec3) -> String {
    match transform.world(voxel.as_dvec3()) {
        Some(DVec3 { x, y, z }) => format!("({x:.4}, {y:.4}, {z:.4})"),
        None => format!("voxel {voxel}"),
    }
}
