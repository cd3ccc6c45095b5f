//! Every method on every case at several resolutions: what `hfvdb accuracy` prints and `docs/accuracy.md` holds.

use std::fmt::Write;
use std::time::Instant;

use serde::Serialize;

use super::in_plane::{PlaneCase, judge};
use super::{Case, compare};
use crate::distance::band::{self, Feet, MeasuredBlock, Settings, measure};
use crate::distance::method::{AsChosen, Choice, METHODS};
use crate::distance::nearest::Watch;
use crate::distance::octree::BuildError;
use crate::grid::{Lattice, VoxelSize};

/// Half the width of the bands that are judged, in voxels: that of level sets.
pub const HALF_WIDTH: f32 = 3.0;

/// A method on a shape.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The shape, with its function.
    pub shape: &'static str,
    /// The method.
    pub method: &'static str,
    /// By resolution.
    pub levels: Vec<Level>,
    /// The order of convergence p that fits: the mean error in world units goes with the voxel's edge to the power p. `None`
    /// of a single resolution.
    pub order: Option<f64>,
}

/// A method on a shape at a resolution.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Level {
    /// Voxels along the shape's longest side.
    pub resolution: u32,
    /// Active voxels.
    pub voxels: u64,
    /// Mean error, in voxels.
    pub mean: f64,
    /// Greatest error, in voxels.
    pub max: f64,
    /// Mean of | |∇d| − 1 |.
    pub slope: f64,
    /// Voxels on the wrong side.
    pub wrong_signs: u64,
    /// What it took: of the first method the whole band, of the others what comes on top of that.
    pub seconds: f64,
}

/// Measures shapes of the plane by all methods that do.
pub fn table_in_plane(cases: &[PlaneCase], resolutions: &[u32], watch: &Watch<'_>) -> Result<Vec<Row>, BuildError> {
    let mut rows = Vec::new();
    for case in cases {
        for method in METHODS {
            let level = |&resolution: &u32| judge(case, method, resolution, watch);
            let levels: Vec<Level> = match resolutions.iter().map(level).collect() {
                Err(BuildError::SolidsOnly { .. }) => continue,
                levels => levels?,
            };
            let order = (levels.len() > 1).then(|| order(&levels));
            rows.push(Row { shape: case.name, method: method.name(), levels, order });
        }
    }
    Ok(rows)
}

/// Measures the bands of all cases by all methods. `done` is told the share done.
pub fn table(cases: &[Case], resolutions: &[u32], watch: &Watch<'_>) -> Result<Vec<Row>, BuildError> {
    let mut rows = Vec::new();
    for (number, case) in cases.iter().enumerate() {
        let mut of_case =
            METHODS.map(|method| Row { shape: case.name, method: method.name(), levels: Vec::new(), order: None });
        for &resolution in resolutions {
            let edge = case.solid.size().max_element() / f64::from(resolution);
            let lattice = Lattice { voxel_size: VoxelSize::new(edge).ok_or(BuildError::Settings)? };
            let region = case.solid.grown((f64::from(HALF_WIDTH) + 1.0) * edge);
            let Watch { cancel, .. } = *watch;
            let settings =
                Settings { lattice, half_width: HALF_WIDTH, region, feet: Feet::Nearest, cancel, progress: &|_| {} };
            let start = Instant::now();
            let band: Result<_, band::Error> = measure(&case.field, &settings, || |_: &MeasuredBlock| ());
            let band = band?.band;
            let first = start.elapsed();
            for (row, method) in of_case.iter_mut().zip(METHODS) {
                let mut own = band.clone();
                let start = Instant::now();
                let watch = Watch { cancel, progress: &|_| {} };
                let as_chosen = AsChosen { choice: Choice::by(method.name()), memory_limit: usize::MAX };
                method.measure_band(&case.field, &mut own, as_chosen, &watch)?;
                let took = if method.name() == METHODS[0].name() { first } else { start.elapsed() };
                let found = compare(&own, case.exact);
                row.levels.push(Level {
                    resolution,
                    voxels: found.voxels,
                    mean: found.mean,
                    max: found.max,
                    slope: found.slope,
                    wrong_signs: found.wrong_signs,
                    seconds: took.as_secs_f64(),
                });
            }
        }
        for mut row in of_case {
            row.order = (row.levels.len() > 1).then(|| order(&row.levels));
            rows.push(row);
        }
        (watch.progress)((number + 1) as f64 / cases.len() as f64);
    }
    Ok(rows)
}

/// The slope of the line that fits log(mean error) over log(voxel's edge) best, both in units of the shape.
fn order(levels: &[Level]) -> f64 {
    let places: Vec<[f64; 2]> = levels
        .iter()
        .map(|level| [-libm::log(f64::from(level.resolution)), libm::log(level.mean / f64::from(level.resolution))])
        .collect();
    let count = places.len() as f64;
    let [x, y] = [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / count);
    let (mut above, mut below) = (0.0, 0.0);
    for place in places {
        above += (place[0] - x) * (place[1] - y);
        below += (place[0] - x).powi(2);
    }
    above / below
}

/// A number with as many digits as are of use.
pub(crate) fn short(number: f64) -> String {
    if number != 0.0 && number < 0.001 { format!("{number:.0e}") } else { format!("{number:.3}") }
}

/// Such numbers, one after the other.
pub(crate) fn listed(numbers: impl Iterator<Item = f64>) -> String {
    numbers.map(short).collect::<Vec<_>>().join(", ")
}

/// An order of convergence, of which a single resolution has none.
pub(crate) fn shown(order: Option<f64>) -> String {
    order.map_or_else(|| "–".to_owned(), |order| format!("{order:.2}"))
}

/// Rows as a table in Markdown, an error of each resolution one after the other. `seconds`: whether times are among them,
/// which no two runs have alike.
pub fn markdown(rows: &[Row], seconds: bool) -> String {
    let resolutions: Vec<String> =
        rows.first().map_or(&[][..], |row| &row.levels).iter().map(|level| level.resolution.to_string()).collect();
    let resolutions = resolutions.join(", ");
    let mut out = format!(
        "| shape | method | mean error at {resolutions} | max error | slope − 1 | order | wrong signs |{}\n",
        if seconds { " seconds |" } else { "" }
    );
    out.push_str(if seconds { "|---|---|---|---|---|---|---|---|\n" } else { "|---|---|---|---|---|---|---|\n" });
    for row in rows {
        let each = |number: fn(&Level) -> f64| listed(row.levels.iter().map(number));
        let wrong: u64 = row.levels.iter().map(|level| level.wrong_signs).sum();
        let _ = write!(
            out,
            "| {} | `{}` | {} | {} | {} | {} | {wrong} |",
            row.shape.replace('|', "\\|"),
            row.method,
            each(|level| level.mean),
            each(|level| level.max),
            each(|level| level.slope),
            shown(row.order),
        );
        if seconds {
            let _ = write!(out, " {} |", each(|level| level.seconds));
        }
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::distance::accuracy::all_cases;

    fn rows(cases: &[Case], resolutions: &[u32]) -> Vec<Row> {
        let cancel = AtomicBool::new(false);
        table(cases, resolutions, &Watch { cancel: &cancel, progress: &|_| {} }).expect("all cases have a surface")
    }

    /// The bars of methods on a ball of ten voxels and more.
    #[test]
    fn methods_are_as_right_as_they_are_said_to_be() {
        for row in rows(&all_cases()[..1], &[24, 48]) {
            let what = format!("{} by {}: {row:?}", row.shape, row.method);
            assert!(row.method != "fim" || row.order >= Some(0.9), "{what}");
            let (mean, max) = match row.method {
                "vector-dt" => (0.1, 0.2),
                "fim" => (0.05, 0.15),
                _ => (0.005, 0.05),
            };
            assert!(row.levels.iter().all(|level| level.mean <= mean && level.max <= max), "{what}");
        }
    }

    #[test]
    fn an_order_is_that_of_the_errors() {
        let level = |resolution: u32, mean: f64| Level {
            resolution,
            voxels: 1,
            mean,
            max: mean,
            slope: 0.0,
            wrong_signs: 0,
            seconds: 0.0,
        };
        // Errors in voxels that stay are of first order, those that halve of second.
        assert!((order(&[level(32, 0.5), level(64, 0.5), level(128, 0.5)]) - 1.0).abs() < 1e-12);
        assert!((order(&[level(32, 0.4), level(64, 0.2)]) - 2.0).abs() < 1e-12);
    }
}
