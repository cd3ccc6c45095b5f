//! Frames opened in real Blender: meshed, played as a sequence, their colours compared with the exact ones at every vertex
//! of the mesh, and their motion blurred.
//!
//! `HFVDB_BLENDER_PYTHON` names a Python that has Blender as a module (`scripts/test.sh` sets it). Without it these
//! tests say that they were skipped.

mod support;

use std::env;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use glam::DVec3;
use hfvdb::attribute::{LinearRgb, Sampler};
use hfvdb::field::{BATCH, Evaluator, Gradients, Points};
use hfvdb::node::Source;
use hfvdb::shot::{FrameContent, PrepareOptions, Prepared};
use hfvdb::text::Overrides;
use rayon::prelude::*;
use support::{Run, Workplace};

const RESOLUTION: u32 = 128;
/// Colours that differ by no more are the same: a step of eight bits, of linear values.
const SAME: f32 = 1.0 / 255.0;

/// Python with Blender; none where there is none, and that is said past the test harness, which hides what tests say.
fn blender() -> Option<String> {
    let python = env::var("HFVDB_BLENDER_PYTHON").ok();
    if python.is_none() {
        let _ = writeln!(io::stderr(), "SKIPPED: a test in Blender; HFVDB_BLENDER_PYTHON names no Python with bpy");
    }
    python
}

/// Runs `scripts/check_blender.py` with the files of a folder of the workplace.
fn check_in_blender(python: &str, place: &Workplace, folder: &str, options: &[&str]) -> Run {
    let files = place.frames(folder).into_iter().map(|name| place.path(folder).join(name));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/check_blender.py");
    place.run(Command::new(python).arg(script).args(files).args(options))
}

fn prepare(scene: &str) -> Prepared {
    let model = hfvdb::node::load(&Source::Builtin(scene.into()), &Overrides::default()).expect("a built-in scene");
    let options = PrepareOptions {
        voxel_size: None,
        resolution: Some(RESOLUTION),
        half_width: None,
        memory_limit: None,
        cache: None,
        cancel: Arc::default(),
        progress: &|_, _| (),
    };
    Arc::new(model).prepare(&options).unwrap_or_else(|error| panic!("{error}"))
}

/// Threes of numbers that `--dump` wrote.
fn dumped(path: &Path) -> Vec<[f32; 3]> {
    let bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("four bytes"));
    bytes.chunks_exact(12).map(|three| [0, 4, 8].map(|at| number(&three[at..at + 4]))).collect()
}

/// What became of a vertex's colour.
enum Verdict {
    /// It is the exact one.
    Exact,
    /// It is between the exact colours within two voxels, which are no smooth change.
    Between,
    /// The same of those a little farther away.
    BetweenFar,
    Wrong(String),
}

/// The exact colours of one frame's surface: of the functions themselves, without voxels. Surface points are found here
/// by plain Newton steps and by trying, not by what bakes frames.
struct Judge<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    sampler: Box<dyn Sampler<3> + 'a>,
    voxel: f64,
}

impl<'a> Judge<'a> {
    fn new(content: &'a FrameContent, voxel: f64) -> Self {
        let colour = content.colour.as_deref().expect("a coloured scene");
        Self { evaluator: content.field.evaluator(), sampler: colour.sampler(), voxel }
    }

    /// Follows each position to F = 0; none where that does not lead there in a dozen steps.
    fn on_surface(&mut self, positions: &[DVec3]) -> Vec<Option<DVec3>> {
        let mut found = Vec::with_capacity(positions.len());
        let mut gradients = Gradients::new();
        for chunk in positions.chunks(BATCH) {
            let mut at = chunk.to_vec();
            let mut arrived = vec![false; at.len()];
            for _ in 0..12 {
                self.evaluator.gradients(&batch(&at), &mut gradients);
                for i in 0..at.len() {
                    let gradient = gradients.gradient(i).as_dvec3();
                    let step = gradient * (-f64::from(gradients.value[i]) / gradient.length_squared());
                    arrived[i] = step.length() < 1e-3 * self.voxel;
                    if !arrived[i] {
                        at[i] += step.clamp_length_max(self.voxel);
                    }
                }
                if arrived.iter().all(|arrived| *arrived) {
                    break;
                }
            }
            found.extend(at.into_iter().zip(arrived).map(|(at, arrived)| arrived.then_some(at)));
        }
        found
    }

    /// The surface's closest point to a position within about a voxel of it, by trying ever finer.
    fn closest(&mut self, to: DVec3) -> Option<DVec3> {
        let mut best: Option<DVec3> = None;
        for radius in [1.0, 0.3, 0.1, 0.03] {
            let tried = self.on_surface(&ball(best.unwrap_or(to), radius * self.voxel, 3));
            let nearer = |a: &DVec3, b: &DVec3| a.distance(to).total_cmp(&b.distance(to));
            best = tried.into_iter().flatten().chain(best).min_by(nearer);
        }
        best
    }

    fn colours(&mut self, positions: &[DVec3]) -> Vec<LinearRgb> {
        let mut colours = Vec::with_capacity(positions.len());
        let mut out = [[0.0; 3]; BATCH];
        for chunk in positions.chunks(BATCH) {
            self.sampler.sample(&batch(chunk), &mut out);
            colours.extend_from_slice(&out[..chunk.len()]);
        }
        colours
    }

    /// The colours of surface points around one, as far as there are any where they are sought: over a ball, listed from
    /// one end to the opposite one.
    fn colours_around(&mut self, middle: DVec3, radius: f64, steps: i32) -> Vec<Option<LinearRgb>> {
        let radius = radius * self.voxel;
        let mut found = self.on_surface(&ball(middle, radius, steps));
        found.iter_mut().for_each(|at| *at = at.filter(|at| at.distance(middle) <= radius));
        let there: Vec<DVec3> = found.iter().flatten().copied().collect();
        let mut colours = self.colours(&there).into_iter();
        found.iter().map(|at| at.and_then(|_| colours.next())).collect()
    }

    /// Judges what arrived at some vertices.
    fn judge(&mut self, vertices: &[(DVec3, LinearRgb)]) -> Vec<Verdict> {
        let positions: Vec<DVec3> = vertices.iter().map(|(position, _)| *position).collect();
        let feet: Vec<DVec3> =
            self.on_surface(&positions).into_iter().zip(&positions).map(|(foot, at)| foot.unwrap_or(*at)).collect();
        let exact = self.colours(&feet);
        let judge = |((vertex, foot), exact)| {
            let (position, got): &(DVec3, LinearRgb) = vertex;
            if difference(*got, exact) <= SAME { Verdict::Exact } else { self.judge_one(*position, *got, foot) }
        };
        vertices.iter().zip(feet).zip(exact).map(judge).collect()
    }

    /// A vertex whose colour is not that of the surface point which Newton steps lead to.
    fn judge_one(&mut self, position: DVec3, got: LinearRgb, foot: DVec3) -> Verdict {
        // At a crease the mesh cuts corners, and the steps lead to one of the sides.
        let at_crease = foot.distance(position) > 0.05 * self.voxel;
        let foot = if at_crease { self.closest(position).unwrap_or(foot) } else { foot };
        let exact = self.colours(&[foot])[0];
        if difference(got, exact) <= SAME {
            return Verdict::Exact;
        }
        // Blender mixes the colours of the eight voxels around, which are those of their closest surface points: these
        // are mostly within two voxels, and never farther than twice a voxel's diagonal. In between: slivers, some so thin
        // that they are met only where points are close together.
        let (mut bent, mut low, mut high) = (false, exact, exact);
        let far = 2.0 * 3f64.sqrt();
        for (radius, steps, verdict) in [
            (2.0, 3, Verdict::Between),
            (0.5, 6, Verdict::Between),
            (far, 12, Verdict::BetweenFar),
            (far, 30, Verdict::BetweenFar),
        ] {
            let around = self.colours_around(foot, radius, steps);
            // What voxels hold between them is what is linear. A jump of colour bends it, and so does a sharp kink.
            let mut opposite = around.iter().zip(around.iter().rev()).filter_map(|(a, b)| Some(((*a)?, (*b)?)));
            bent |= opposite.any(|(a, b)| difference(exact, [0, 1, 2].map(|i| (a[i] + b[i]) / 2.0)) > SAME);
            for colour in around.iter().flatten() {
                low = [0, 1, 2].map(|i| low[i].min(colour[i]));
                high = [0, 1, 2].map(|i| high[i].max(colour[i]));
            }
            if bent && (0..3).all(|i| (low[i] - SAME..=high[i] + SAME).contains(&got[i])) {
                return verdict;
            }
        }
        Verdict::Wrong(format!(
            "{got:?} at {position:.4} instead of {exact:?}, and the colours around do not explain it"
        ))
    }
}

fn batch(positions: &[DVec3]) -> Points {
    let mut points = Points::new(positions[0]);
    positions.iter().for_each(|position| points.push((*position - points.origin).as_vec3()));
    points
}

/// Positions evenly over a ball, `steps` from the middle to its border.
fn ball(middle: DVec3, radius: f64, steps: i32) -> Vec<DVec3> {
    let along = || (-steps..=steps).map(|step| f64::from(step) / f64::from(steps));
    let cube = along().flat_map(|x| along().flat_map(move |y| along().map(move |z| DVec3::new(x, y, z))));
    cube.filter(|step| step.length() < 1.001).map(|step| middle + step * radius).collect()
}

fn difference(a: LinearRgb, b: LinearRgb) -> f32 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f32::max)
}

/// Bakes frames of a scene, opens them in Blender as one sequence, and judges the colours of all vertices. At least the
/// share `exact` of them has to be exact by itself.
fn colours_arrive(scene: &str, frames: &str, exact: f64) {
    let Some(python) = blender() else { return };
    let place = Workplace::new();
    place.hfvdb(&format!("bake {scene} --resolution {RESOLUTION} --frames {frames} -o out/####.vdb")).ok();
    check_in_blender(&python, &place, "out", &["--sequence", "--dump", "dump"]).ok();

    let prepared = prepare(scene);
    let (mut vertices, mut exactly, mut far, mut wrong) = (0, 0, 0, Vec::new());
    for name in place.frames("out") {
        let number = name.trim_end_matches(".vdb");
        let content = prepared.frame(number.parse().expect("a frame")).unwrap_or_else(|error| panic!("{error}"));
        let array = |kind: &str| dumped(&place.path("dump").join(format!("{number}.{kind}.f32")));
        let positions = array("positions").into_iter().map(|position| DVec3::from(position.map(f64::from)));
        let pairs: Vec<(DVec3, LinearRgb)> = positions.zip(array("colours")).collect();
        let judge = |part: &[_]| Judge::new(&content, prepared.lattice.voxel_size.get()).judge(part);
        let verdicts: Vec<Verdict> = pairs.par_chunks(1024).flat_map_iter(judge).collect();
        vertices += verdicts.len();
        for verdict in verdicts {
            match verdict {
                Verdict::Exact => exactly += 1,
                Verdict::Between => {}
                Verdict::BetweenFar => far += 1,
                Verdict::Wrong(what) => wrong.push(format!("frame {number}: {what}")),
            }
        }
    }
    let share = f64::from(exactly) / vertices as f64;
    println!("{scene}: {vertices} vertices, {:.3} % exact, {far} by a jump beyond two voxels", 100.0 * share);
    assert!(wrong.is_empty(), "{} of {vertices} vertices:\n{}", wrong.len(), wrong[..wrong.len().min(10)].join("\n"));
    assert!(far * 1000 <= vertices, "{far} of {vertices} vertices have colours from beyond two voxels");
    assert!(share >= exact, "only {:.2} % of {vertices} vertices have their exact colour", 100.0 * share);
}

// Both ends, where an object is itself, and frames around the middle: frame 17 has to play file 17.

#[test]
fn colours_of_cubism_arrive_in_blender() {
    // A quarter of the vertices is less than two voxels from another cell.
    colours_arrive("cubism", "1,16-18,48", 0.6);
}

#[test]
fn colours_of_cube_to_heart_arrive_in_blender() {
    colours_arrive("cube-to-heart", "1,16-18,24", 0.9999);
}

/// Files with what is to be found, made by OpenVDB's own Python module: balls whose insides are not filled, a crumb
/// beside one; and a hollow ball, which is sound.
const MAKER: &str = "
import sys, numpy as np, pyopenvdb as vdb
place = np.indices((49, 49, 49)) - 24
def write(name, values, half_width):
    grid = vdb.FloatGrid(half_width)
    grid.copyFromArray(np.ascontiguousarray(values, np.float32), ijk=(-24, -24, -24))
    grid.name, grid.gridClass = 'surface', vdb.GridClass.LEVEL_SET
    grid.transform = vdb.createLinearTransform(0.1)
    vdb.write(sys.argv[1] + '/' + name + '.vdb', grids=[grid])
radius = np.sqrt((place ** 2).sum(0)) * 0.1
ball = radius - 1.5
for voxels in (2, 3):
    width = 0.1 * voxels
    write('unfilled%d' % voxels, np.where(abs(ball) < width, ball, width), width)
write('hollow', np.clip(np.maximum(ball, 0.8 - radius), -0.3, 0.3), 0.3)
crumb = np.sqrt(((place - 18) ** 2).sum(0)) * 0.1 - 0.25
write('crumb', np.clip(np.minimum(ball, crumb), -0.3, 0.3), 0.3)
";

#[test]
fn second_surfaces_and_crumbs_are_found() {
    let Some(python) = blender() else { return };
    let place = Workplace::new();
    fs::create_dir(place.path("out")).expect("a folder");
    place.run(Command::new("/usr/bin/python3").args(["-c", MAKER, "out"])).ok();
    let run = check_in_blender(&python, &place, "out", &["--colour", "none", "--pieces", "1"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).expect("a report");
    let problems = |name: &str| {
        let frames = report["frames"].as_array().expect("frames");
        let frame = frames.iter().find(|frame| frame["file"].as_str().is_some_and(|file| file.ends_with(name)));
        frame.unwrap_or_else(|| panic!("no {name}"))["problems"].to_string()
    };
    assert_eq!(problems("hollow.vdb"), "[]");
    assert!(problems("crumb.vdb").contains("2 pieces instead of 1"), "{}", problems("crumb.vdb"));
    for name in ["unfilled2.vdb", "unfilled3.vdb"] {
        assert!(problems(name).contains("a second surface"), "{name}: {}", problems(name));
    }
}

/// A ball of radius 0.5 that moves 0.375 units a frame is seen so much wider, and is so much narrower where nothing else
/// is seen, as the shutter is open.
#[test]
fn motion_is_blurred_in_blender_as_the_velocities_say() {
    let Some(python) = blender() else { return };
    let place = Workplace::new();
    let scene = "frames = '1-9'\n[shape.a]\nsphere = 0.5\nmove = ['3*t - 1.5', 0, 0]\n\
                 [output]\ngrids = ['surface', 'vel']\nvoxel_size = 0.03\n";
    place.write("moving.toml", scene);
    place.hfvdb("bake moving.toml --frames 5 -o moving.####.vdb").ok();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/motion_blur.py");
    let run = place.run(Command::new(python).arg(script).arg(place.path("moving.0005.vdb"))).ok();
    let lines =
        run.stdout.lines().map(|line| line.split(' ').filter_map(|number| number.parse::<f64>().ok()).collect());
    let lines: Vec<Vec<f64>> = lines.filter(|numbers: &Vec<f64>| numbers.len() == 3).collect();
    assert_eq!(lines.len(), 3, "{}", run.stdout);
    for line in &lines {
        let [shutter, seen, alone] = line[..] else { unreachable!("three numbers") };
        // Where less than 2 % is seen counts as nothing, at both ends; and a pixel is 0.005 units.
        let (wider, error) = (0.375 * shutter, 0.02 + 0.04 * 0.375 * shutter);
        assert!((seen - (1.0 + wider)).abs() < error, "{line:?}");
        assert!((alone - (1.0 - wider)).abs() < error, "{line:?}");
    }
}

/// What Pixar's library and Blender find in a layer.
fn read_layer(python: &str, place: &Workplace, layer: &str) -> serde_json::Value {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_layer.py");
    let run = place.run(Command::new(python).arg(script).arg(place.path(layer)));
    let run = run.ok();
    let found = run.stdout.lines().find_map(|line| line.strip_prefix("found "));
    support::json(found.unwrap_or_else(|| panic!("{}", run.stderr)))
}

#[test]
fn usd_layers_are_read() {
    let Some(python) = blender() else { return };
    let place = Workplace::new();
    place.hfvdb("bake cube-to-heart -o out/m.####.vdb --frames 10-12 --resolution 32 --set output.grids=[\"surface\",\"Cd\",\"vel\"] --set frames=\"10-12\"").ok();
    place.hfvdb("usd out/m.####.vdb -o m.usda").ok();
    let found = read_layer(&python, &place, "m.usda");
    assert_eq!(found["wrong"], serde_json::json!([]));
    assert_eq!((&found["up"], &found["metres"], &found["fps"]), (&"Z".into(), &1.0.into(), &24.0.into()));
    assert_eq!(found["shot"], serde_json::json!([10.0, 12.0]));
    assert_eq!(found["times"], serde_json::json!([10, 11, 12]));
    let fields = found["fields"].as_object().unwrap();
    assert_eq!(fields.keys().collect::<Vec<_>>(), ["Cd", "color", "surface", "vel", "velocity"]);
    for (name, grid, kind, class, role) in [
        ("surface", "surface", "float", "levelSet", serde_json::Value::Null),
        ("Cd", "Cd", "float3", "unknown", "Color".into()),
        ("color", "Cd", "float3", "unknown", "Color".into()),
        ("velocity", "vel", "float3", "unknown", "Vector".into()),
    ] {
        let field = &fields[name];
        assert_eq!(
            (&field["name"], &field["type"], &field["class"]),
            (&grid.into(), &kind.into(), &class.into()),
            "{name}"
        );
        assert!(field["role"] == role || role.is_null() && field["role"] == "None", "{field}");
        let files = (10..=12).map(|frame| place.path(&format!("out/m.{frame:04}.vdb")).canonicalize().unwrap());
        let files: Vec<String> = files.map(|file| file.display().to_string()).collect();
        assert_eq!(field["files"], serde_json::json!(files), "{name}");
    }
    // Around all voxels, half of one beyond their centres.
    let info = support::json(&place.hfvdb("info --json out/m.0012.vdb").ok().stdout);
    let grid = &info["files"][0]["grids"][0];
    let half = grid["voxel_size"][0].as_f64().unwrap() / 2.0;
    for (corner, way) in [(0, -half), (1, half)] {
        for axis in 0..3 {
            let centre = grid["world_box"][corner][axis].as_f64().unwrap();
            let edge = found["extent"][corner][axis].as_f64().unwrap();
            assert!((edge - centre - way).abs() < 1e-5, "{found:#}");
        }
    }
    let blender = &found["blender"];
    assert_eq!(
        (&blender["volumes"], &blender["sequence"], &blender["frames"]),
        (&1.into(), &true.into(), &serde_json::json!([10, 3]))
    );
    assert_eq!(blender["scene"], serde_json::json!([10, 12]));

    place.hfvdb("bake heart -o heart.vdb --resolution 32 --set unit=\"cm\" --set up=\"y\"").ok();
    place.hfvdb("usd heart.vdb -o out/heart.usda --fps 25").ok();
    let found = read_layer(&python, &place, "out/heart.usda");
    assert_eq!((&found["up"], &found["metres"], &found["fps"]), (&"Y".into(), &0.01.into(), &25.0.into()));
    assert_eq!((&found["wrong"], &found["times"]), (&serde_json::json!([]), &serde_json::json!([])));
    assert_eq!(found["blender"]["grids"], serde_json::json!(["Cd", "surface"]));
    assert_eq!(found["blender"]["sequence"], false);
}

/// What Pixar's library and Blender find in a file of polygons.
fn read_polygons(python: &str, place: &Workplace, file: &str) -> serde_json::Value {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_polygons.py");
    let run = place.run(Command::new(python).arg(script).arg(place.path(file))).ok();
    let found = run.stdout.lines().find_map(|line| line.strip_prefix("found "));
    support::json(found.unwrap_or_else(|| panic!("{}", run.stderr)))
}

/// A ball that moves, grows, and is as red as the frame says.
const MOVING: &str = "frames = '1-9'\nfps = 25\nunit = 'cm'\nup = 'y'\n[shape.a]\nsphere = '0.5 + 0.4*t'\nmove = ['3*t', 0, 0]\n\
                      color = ['0.2 + 0.5*t', 0.5, 0.1]\nattribute.wear = 't'\n\
                      [output]\ngrids = ['surface', 'Cd', 'wear', 'vel']\nvoxel_size = 0.05\n";

#[test]
fn polygons_as_usd_are_read() {
    let Some(python) = blender() else { return };
    let place = Workplace::new();
    place.write("moving.toml", MOVING);
    place.hfvdb("bake moving.toml -o moving.usda --frames 3-5").ok();
    let found = read_polygons(&python, &place, "moving.usda");
    assert_eq!((&found["wrong"], &found["times"]), (&serde_json::json!([]), &serde_json::json!([3, 4, 5])));
    assert_eq!((&found["up"], &found["metres"], &found["fps"]), (&"Y".into(), &0.01.into(), &25.0.into()));
    assert_eq!(found["shot"], serde_json::json!([3.0, 5.0]));
    let primvars = serde_json::json!({ "displayColor": ["color3f[]", "vertex"], "wear": ["float[]", "vertex"] });
    assert_eq!(found["primvars"], primvars);
    let linear = |value: f64| ((value + 0.055) / 1.055f64).powf(2.4);
    for (at, frame) in [3.0f64, 4.0, 5.0].into_iter().enumerate() {
        let (sample, blender, t) = (&found["samples"][at], &found["blender"][at], (frame - 1.0) / 8.0);
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        assert_eq!((&sample["open_edges"], &sample["extent_fits"]), (&0.into(), &true.into()), "{sample}");
        let exact = 4.0 / 3.0 * std::f64::consts::PI * (0.5 + 0.4 * t).powi(3);
        assert!((number(&sample["volume"]) / exact - 1.0).abs() < 0.01, "{sample}");
        for name in ["displayColor", "wear"] {
            assert_eq!(sample["sizes"][name], sample["points"]);
        }
        let colour = [linear(0.2 + 0.5 * t), linear(0.5), linear(0.1)];
        for (part, exact) in colour.into_iter().enumerate() {
            assert!((number(&sample["means"]["displayColor"][part]) - exact).abs() < 1e-4, "{sample}");
            assert!((number(&blender["colour"][part]) - exact).abs() < 4e-3, "{blender}");
        }
        // What it grows by cancels over the ball; 3 units are eight frames of a 25th of a second.
        for (part, exact) in [3.0 / 8.0 * 25.0, 0.0, 0.0].into_iter().enumerate() {
            assert!((number(&sample["velocity"][part]) - exact).abs() < 0.02, "{sample}");
        }
        assert_eq!((&blender["points"], &blender["faces"]), (&sample["points"], &sample["faces"]));
        let attributes = blender["attributes"].as_array().unwrap();
        assert!(attributes.contains(&"wear".into()) && attributes.contains(&"velocity".into()), "{attributes:?}");
    }
    place.hfvdb("bake heart -o heart.usda --resolution 24").ok();
    let found = read_polygons(&python, &place, "heart.usda");
    assert_eq!((&found["wrong"], &found["times"]), (&serde_json::json!([]), &serde_json::json!([])));
    assert!(found["blender"][0]["points"] == found["samples"][0]["points"] && found["samples"][0]["open_edges"] == 0);
}
