use std::process::Command;

use super::support::*;
use crate::vdb::*;

/// Compares what Blender made of the ball with what the ball is: prints the worst error of radius and colour.
const COMPARE: &str = "
import sys, numpy as np
mesh = np.load(sys.argv[1])
positions, colours = mesh['positions'], mesh['colours']
radius = np.linalg.norm(positions - np.array([0.31, -0.2, 0.13]), axis=1)
print(abs(radius - 1).max(), abs(colours - (0.3 * positions + 0.5)).max())
";

#[test]
#[ignore = "needs Blender as a Python module: HFVDB_BLENDER_PYTHON names the python that has bpy"]
fn blender_shows_the_ball_in_its_colours() {
    let python = std::env::var("HFVDB_BLENDER_PYTHON").expect("HFVDB_BLENDER_PYTHON names a python with bpy");
    let folder = tempfile::tempdir().unwrap();
    let band = ball();
    let channel = ball_colour(&band, "Cd");
    let frame =
        Frame { grids: vec![Grid::level_set("surface", &band), Grid::colour(&band, &channel)], ..Default::default() };
    let files: Vec<_> = (7..10).map(|number| folder.path().join(format!("ball.{number:04}.vdb"))).collect();
    for path in &files {
        write(path, &frame, &WriteOptions::default()).unwrap();
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/check_blender.py");
    let checked = Command::new(&python)
        .args([script, "--sequence", "--dump"])
        .arg(folder.path())
        .arg("--render")
        .arg(folder.path().join("sheet.png"))
        .args(&files)
        .output()
        .unwrap();
    let report: serde_json::Value = serde_json::from_slice(&checked.stdout).expect("a report");
    assert!(checked.status.success(), "{}", report["problems"]);
    let mesh = &report["frames"][2]["mesh"];
    assert_eq!((&mesh["closed"], &mesh["pieces"]), (&true.into(), &1.into()));
    let volume = mesh["signed_volume"].as_f64().unwrap();
    assert!((volume / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "volume {volume}");
    assert!(folder.path().join("sheet.png").exists());

    let compared =
        Command::new(&python).args(["-c", COMPARE]).arg(folder.path().join("ball.0008.npz")).output().unwrap();
    let text = String::from_utf8_lossy(&compared.stdout);
    let errors: Vec<f64> = text.split_whitespace().map(|number| number.parse().unwrap()).collect();
    // Surface nets put a vertex at the mean of crossings, inside of a ball: some 3 % of a voxel at this radius.
    assert!(errors[0] < 0.05 * VOXEL_SIZE, "radius off by {}", errors[0]);
    // A colour linear in space survives trilinear sampling: what is left is single precision.
    assert!(errors[1] < 1e-5, "colour off by {}", errors[1]);
}
