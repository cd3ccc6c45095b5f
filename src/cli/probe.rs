//! `hfvdb probe`: F at one place, node by node.

use std::fmt::Write;

use clap::Args;
use glam::DVec3;
use serde_json::json;

use super::failure::Failure;
use super::job;
use super::options::{Global, SceneArguments};
use crate::node::{Content, Probe, Reading};
use crate::text::key::GREATEST;

/// Arguments of `hfvdb probe`.
#[derive(Args)]
#[command(after_help = "\
Each line has F of a node (positive inside), the length of its gradient, what is declared of its slope, and the distance
where F is that; else what it is at least. Shapes have their colour and attributes too. A shape is read where it stands,
what it is made of in its own space.
!! marks F and attributes that are no numbers, and gradients longer than declared.

Examples:
  hfvdb probe mine.toml 0 0 0.5               the values at a place
  hfvdb probe mine.toml 0 0 0.5 --frame 12    in a frame
  hfvdb probe gyroid 0.1 0 0 --json           for programs, with boxes, colours and attributes")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// The place, in the scene's units
    #[arg(num_args = 3, value_names = ["X", "Y", "Z"], required = true, allow_negative_numbers = true, value_parser = coordinate)]
    place: Vec<f64>,

    /// The frame [default: the first of the shot]
    #[arg(long, value_name = "FRAME", allow_negative_numbers = true)]
    frame: Option<i64>,
}

fn coordinate(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.abs() <= GREATEST);
    number.ok_or_else(|| format!("a place has three numbers of at most {GREATEST:e}"))
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let model = job::load(&arguments.scene, global)?;
    let [x, y, z] = [arguments.place[0], arguments.place[1], arguments.place[2]];
    let frame = arguments.frame.unwrap_or(model.shot.range.first);
    job::files_of(Some(&[frame]), &model)?;
    let (shapes, warnings) =
        model.probe(DVec3::new(x, y, z), frame as f64).map_err(|problem| Failure::from(model.error(problem)))?;
    job::warn(&warnings, global);
    if global.json {
        return super::print_json(&json!({ "at": [x, y, z], "frame": frame, "shapes": shapes }));
    }
    if matches!(model.content, Content::Morph(_)) {
        global.warn(
            "the shapes of the morph are read where they stand, and not what lies between them: \
                     `preview --slice` shows that",
        );
    }
    let mut out = format!("at {x} {y} {z}, frame {frame}\n");
    for shape in &shapes {
        tell(&mut out, shape, 0);
    }
    super::print(&out)
}

/// A node and all below it.
fn tell(out: &mut String, probe: &Probe, depth: usize) {
    let name = if probe.name == probe.node { probe.name.clone() } else { format!("{} ({})", probe.name, probe.node) };
    let name = format!("{}{name}", "  ".repeat(depth));
    let Reading { value, gradient, is_wrong, .. } = &probe.reading;
    let side = if *value > 0.0 { "inside" } else { "outside" };
    let _ = write!(
        out,
        "{name:32} F {}{}, {side}, |∇F| {gradient:.4}",
        if *value < 0.0 { "" } else { "+" },
        digits(*value)
    );
    if let Some(declared) = &probe.reading.declared {
        let _ = write!(out, ", {declared}");
    }
    match (probe.reading.distance, probe.reading.at_least) {
        (Some(distance), _) => _ = write!(out, ", distance {}", digits(distance)),
        (None, Some(least)) => _ = write!(out, ", distance ≥ {}", digits(least)),
        (None, None) => {}
    }
    if let Some([r, g, b]) = probe.colour {
        let _ = write!(out, ", colour {r:.3} {g:.3} {b:.3}");
    }
    for (name, number) in &probe.attributes {
        let _ = write!(out, ", {name} {}", digits(f64::from(*number)));
    }
    if let (0, Some([low, high])) = (depth, probe.reading.bounds) {
        let shown = |corner: [f64; 3]| corner.map(|part| format!("{part:.3}")).join(" ");
        let _ = write!(out, ", box {} to {}", shown(low), shown(high));
    }
    let is_wrong = *is_wrong || probe.attributes.iter().any(|(_, number)| !number.is_finite());
    out.push_str(if is_wrong { "  !!\n" } else { "\n" });
    for part in &probe.made_of {
        tell(out, part, depth + 1);
    }
}

/// A number with six digits after the point, or as many of a small one.
fn digits(number: f64) -> String {
    if number != 0.0 && number.abs() < 1e-3 { format!("{number:.5e}") } else { format!("{number:.6}") }
}
