//! `hfvdb check` of mesh files: what they hold, and what is wrong with them.

use std::path::Path;

use serde_json::json;

use super::failure::Failure;
use super::options::Global;
use crate::mesh::{Report, is_mesh, report};
use crate::terminal;

/// Whether an input is a mesh file, by its name.
pub fn is_one(input: &String) -> bool {
    is_mesh(Path::new(input))
}

/// Says what there is to say of each; one that cannot be used as a solid is not sound.
pub fn run(inputs: &[String], global: &Global) -> Result<(), Failure> {
    let (mut documents, mut unsound) = (Vec::new(), 0);
    for input in inputs {
        match report(Path::new(input)) {
            Ok(found) => {
                let problem = open(&found);
                unsound += usize::from(problem.is_some());
                if global.json {
                    documents.push(json!({ "path": input, "mesh": found, "error": problem }));
                    continue;
                }
                super::print(&lines(input, &found))?;
                found
                    .notes
                    .iter()
                    .for_each(|note| global.warn(&format!("{}: {note}", terminal::path(Path::new(input)))));
                if let Some(problem) = problem {
                    super::say(&format!("error: {}: {problem}", terminal::path(Path::new(input))));
                }
            }
            Err(error) => {
                unsound += 1;
                super::say(&format!("error: {error}"));
                documents.push(json!({ "path": input, "mesh": null, "error": error.problem.to_string() }));
            }
        }
    }
    if global.json {
        super::print_json(&json!({ "files": documents, "unsound": unsound }))?;
    }
    match unsound {
        0 => Ok(()),
        _ => {
            Err(Failure::work(format!("{unsound} of {} meshes cannot be used as they are", inputs.len()))
                .with_results())
        }
    }
}

/// Why a mesh has no inside.
fn open(report: &Report) -> Option<String> {
    let Report { boundary_edges, inconsistent_edges, .. } = report;
    (boundary_edges + inconsistent_edges > 0).then(|| {
        format!(
            "the surface is not closed: {boundary_edges} edges at holes, {inconsistent_edges} edges whose faces face \
             opposite ways; `sign = \"winding\"` beside `mesh` closes it by sheets, `thickness` makes a sheet along it \
             (`hfvdb convert --sign winding`, `--thickness`)"
        )
    })
}

fn lines(input: &str, report: &Report) -> String {
    let [least, greatest] = report.extent;
    let size: [f64; 3] = std::array::from_fn(|i| greatest[i] - least[i]);
    let round = |value: f64| format!("{}", (value * 1e6).round() / 1e6);
    let three = |values: [f64; 3]| values.map(round).join(" x ");
    let corner = |values: [f64; 3]| format!("({})", values.map(round).join(", "));
    let colours = match (report.pictures.as_slice(), report.materials, report.vertex_colours) {
        ([], 0, false) => "none".to_owned(),
        ([], _, true) => "of its vertices".into(),
        ([], count, _) => format!("of {count} materials"),
        (pictures, ..) => {
            let sizes: Vec<String> = pictures.iter().map(|[width, height]| format!("{width} x {height}")).collect();
            format!("of pictures: {}", sizes.join(", "))
        }
    };
    let volume =
        report.volume.map_or_else(|| "not closed".into(), |volume| format!("closed, volume {}", round(volume)));
    format!(
        "{}\n  {} triangles, {} vertices, {} edges of more than two triangles\n  size {}, from {} to {}\n  {volume}\n  \
         colours: {colours}\n",
        terminal::path(Path::new(input)),
        report.triangles,
        report.vertices,
        report.non_manifold_edges,
        three(size),
        corner(least),
        corner(greatest),
    )
}
