//! `hfvdb accuracy`: how right the methods are that measure distances, on shapes whose distance is known exactly, through the
//! air and along their inside.

use std::sync::atomic::AtomicBool;

use clap::Args;

use super::failure::Failure;
use super::options::Global;
use crate::attribute::conformal::accuracy;
use crate::distance::accuracy::table::{markdown, table, table_in_plane};
use crate::distance::accuracy::{all_cases, plane_cases};
use crate::distance::nearest::Watch;
use crate::distance::octree::BuildError;

/// Arguments of `hfvdb accuracy`.
#[derive(Args)]
#[command(after_help = "\
Columns, one number a resolution each: mean and greatest error of the distance in voxels, mean
of | |∇d| − 1 |, the order of convergence that fits the mean errors, voxels on the wrong side,
seconds (of the first method the whole band, of the others what comes on top of that; in the
plane, of each, all of it).

A second table judges `interior` and `conformal`, at as many cells of their lattice (16 to 256):
errors of the way along the inside in cells, and of a weight.

At 128 it takes minutes, most of them for what is judged along the inside.

Examples:
  hfvdb accuracy                          at 32, 64 and 128 voxels along the longest side
  hfvdb accuracy --resolution 64,256      at these
  hfvdb --json accuracy                   for programs")]
pub struct Arguments {
    /// Voxels along the longest side of each shape, from 8 to 512, several with commas between them
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "32,64,128",
        value_parser = clap::value_parser!(u32).range(8..=512))]
    resolution: Vec<u32>,
}

/// The lattices that insides are judged on: no coarser ones are taken, and finer ones do not hold all of the bodies.
const CELLS: std::ops::RangeInclusive<u32> = 16..=256;

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let mut resolutions = arguments.resolution.clone();
    resolutions.sort_unstable();
    resolutions.dedup();
    let cancel = AtomicBool::new(false);
    let watch = Watch { cancel: &cancel, progress: &|_| {} };
    let told = |error: BuildError| Failure::work(error.to_string());
    let mut rows = table(&all_cases(), &resolutions, &watch).map_err(told)?;
    rows.extend(table_in_plane(&plane_cases(), &resolutions, &watch).map_err(told)?);
    let cells: Vec<u32> = resolutions.into_iter().filter(|cells| CELLS.contains(cells)).collect();
    let inside = accuracy::table(&cells, &cancel).map_err(|error| Failure::work(error.to_string()))?;
    if global.json {
        return super::print_json(&serde_json::json!({ "accuracy": rows, "inside": inside }));
    }
    super::print(&format!("{}\n{}", markdown(&rows, true), accuracy::markdown(&inside, true)))
}
