//! `--adaptivity`: fewer triangles, held against the exact surface, the attributes and the rules of a closed surface.

mod support;

use std::collections::HashSet;
use std::fs;

use glam::{DQuat, DVec3};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;
use support::{Workplace, json};

/// Triangles as a .ply has them.
struct Surface {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    colours: Vec<[u8; 3]>,
    /// Further numbers of each vertex.
    numbers: Vec<Vec<f32>>,
}

impl Surface {
    fn read(place: &Workplace, name: &str) -> Self {
        let bytes = fs::read(place.path(name)).expect("a file");
        let end = bytes.windows(11).position(|window| window == b"end_header\n").expect("a header") + 11;
        let head = std::str::from_utf8(&bytes[..end]).expect("text");
        let count = |element: &str| -> usize {
            let line = head.lines().find_map(|line| line.strip_prefix(element)).expect("a count");
            line.trim().parse().expect("a number")
        };
        let colours = if head.contains("uchar red") { 3 } else { 0 };
        let numbers = head.matches("property float").count() - 3;
        let mut rest = &bytes[end..];
        let mut take = |length: usize| {
            let (taken, left) = rest.split_at(length);
            rest = left;
            taken
        };
        let float = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("four bytes"));
        let mut surface = Self { positions: vec![], triangles: vec![], colours: vec![], numbers: vec![] };
        for _ in 0..count("element vertex") {
            surface.positions.push(DVec3::from_array(std::array::from_fn(|_| f64::from(float(take(4))))));
            surface.colours.push(take(colours).try_into().unwrap_or_default());
            surface.numbers.push((0..numbers).map(|_| float(take(4))).collect());
        }
        for _ in 0..count("element face") {
            assert_eq!(take(1), [3]);
            surface.triangles.push(std::array::from_fn(|_| float(take(4)).to_bits()));
        }
        surface
    }

    fn corners(&self, triangle: &[u32; 3]) -> [DVec3; 3] {
        triangle.map(|vertex| self.positions[vertex as usize])
    }

    /// Each edge is used once in either direction, all triangles have an area, and all vertices are used.
    fn is_closed(&self) {
        let sides = self.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        let edges: HashSet<[u32; 2]> = sides.collect();
        assert_eq!(edges.len(), 3 * self.triangles.len(), "an edge is there twice");
        assert!(edges.iter().all(|[a, b]| edges.contains(&[*b, *a])), "an edge is open");
        let used: HashSet<u32> = self.triangles.iter().flatten().copied().collect();
        assert_eq!(used.len(), self.positions.len());
        let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
        assert!(self.triangles.iter().all(|triangle| area(self.corners(triangle)) > 0.0), "a triangle has no area");
    }

    fn volume(&self) -> f64 {
        let six_times = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c));
        self.triangles.iter().map(|triangle| six_times(self.corners(triangle))).sum::<f64>() / 6.0
    }

    /// Points of the triangles, a quarter of a voxel apart and less.
    fn points(&self, voxel: f64) -> Vec<DVec3> {
        let mut points = Vec::new();
        for triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let steps = (4.0 * longest / voxel).ceil().clamp(4.0, 300.0) as u32;
            for i in 0..=steps {
                for j in 0..=steps - i {
                    let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(steps));
                    points.push(a + (b - a) * u + (c - a) * v);
                }
            }
        }
        points
    }

    fn mesh(&self) -> TriMesh {
        let places = self.positions.iter().map(|place| place.to_array().into()).collect();
        TriMesh::new(places, self.triangles.clone()).expect("triangles")
    }
}

/// The greatest distance of a point of the triangles from a surface of which the distances are known.
fn away(surface: &Surface, distance: impl Fn(DVec3) -> f64, voxel: f64) -> f64 {
    surface.points(voxel).into_iter().map(|point| distance(point).abs()).fold(0.0, f64::max) / voxel
}

/// The greatest distance of some points from the triangles.
fn away_back(surface: &Surface, points: impl Iterator<Item = DVec3>, voxel: f64) -> f64 {
    let mesh = surface.mesh();
    let distance = |point: DVec3| {
        let found = mesh.project_local_point(point.to_array().into(), false).point;
        point.distance(DVec3::from_array(found.to_array()))
    };
    points.map(distance).fold(0.0, f64::max) / voxel
}

/// Points spread over a sphere.
fn on_sphere(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count);
        let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
        DVec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z)
    })
}

fn of_box(half: DVec3) -> impl Fn(DVec3) -> f64 {
    move |p| {
        let q = p.abs() - half;
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    }
}

/// Points of a box, its edges and corners among them.
fn on_box(half: DVec3, steps: i32) -> impl Iterator<Item = DVec3> {
    let all = move || -steps..=steps;
    let places = all().flat_map(move |i| all().flat_map(move |j| [-1.0, 1.0].map(|side| (i, j, side))));
    places.flat_map(move |(i, j, side)| {
        let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(steps));
        [DVec3::new(u, v, side), DVec3::new(u, side, v), DVec3::new(side, u, v)].map(|p| p * half)
    })
}

/// Bakes a scene of one frame without and with adaptivity; gives both, the voxel, and what was said.
fn both(scene: &str, resolution: u32, adaptivity: f64) -> (Surface, Surface, f64, String) {
    let place = Workplace::new();
    place.write("s.toml", format!("hfvdb = 1\n{scene}"));
    let bake = |name: &str, more: &str| {
        place.hfvdb(&format!("bake s.toml -o {name} --resolution {resolution} --json {more}")).ok()
    };
    let voxel = json(&bake("dense.ply", "").stdout)["voxel_size"].as_f64().expect("a size");
    let run = bake("few.ply", &format!("--adaptivity {adaptivity}"));
    let (dense, few) = (Surface::read(&place, "dense.ply"), Surface::read(&place, "few.ply"));
    let polygons = &json(&run.stdout)["frames"][0]["polygons"];
    assert_eq!(polygons["triangles"], few.triangles.len());
    assert_eq!(polygons["unmerged"], dense.triangles.len());
    few.is_closed();
    (dense, few, voxel, run.stderr)
}

#[test]
fn a_sphere() {
    for error in [0.05, 0.1] {
        let (dense, few, voxel, told) = both("[shape.s]\nsphere = 1\n", 96, error);
        assert!(
            few.triangles.len() * 6 < dense.triangles.len(),
            "{} of {}",
            few.triangles.len(),
            dense.triangles.len()
        );
        let out = away(&few, |p| p.length() - 1.0, voxel);
        let back = away_back(&few, on_sphere(40_000), voxel);
        assert!(out < error && back < error, "{out} and {back} for {error}");
        assert!((few.volume() / dense.volume() - 1.0).abs() < 0.004);
        assert!(!told.contains("further"), "{told}");
    }
}

#[test]
fn a_torus() {
    let (dense, few, voxel, told) = both("[shape.s]\ntorus = 0.8\n", 96, 0.1);
    assert!(few.triangles.len() * 5 < dense.triangles.len());
    let distance = |p: DVec3| DVec3::new(p.truncate().length() - 0.8, 0.0, p.z).length() - 0.2;
    let out = away(&few, distance, voxel);
    // Of each direction the point of the tube around a point of the middle line.
    let points = (0..400).flat_map(|i| (0..100).map(move |j| (f64::from(i) / 400.0, f64::from(j) / 100.0)));
    let points = points.map(|turns: (f64, f64)| {
        let [(a, b), (c, d)] = [turns.0, turns.1].map(|turn| (turn * std::f64::consts::TAU).sin_cos());
        DVec3::new((0.8 + 0.2 * d) * b, (0.8 + 0.2 * d) * a, 0.2 * c)
    });
    let back = away_back(&few, points, voxel);
    assert!(out < 0.1 && back < 0.1 && !told.contains("further"), "{out} and {back}: {told}");
}

/// Where the axes lie along the box nothing is notched.
#[test]
fn a_box() {
    let half = DVec3::splat(0.8);
    let (dense, few, voxel, told) = both("[shape.s]\nbox = 1.6\nmove = [0.013, 0.007, -0.004]\n", 96, 0.1);
    assert!(few.triangles.len() * 100 < dense.triangles.len(), "{}", few.triangles.len());
    let moved = DVec3::new(0.013, 0.007, -0.004);
    let out = away(&few, |p| of_box(half)(p - moved), voxel);
    let back = away_back(&few, on_box(half, 40).map(|p| p + moved), voxel);
    assert!(out < 0.1 && back < 0.1 && !told.contains("further"), "{out} and {back}: {told}");
}

/// Dual contouring notches the edges of a box that is turned. They become no worse, and what is beyond the error is told.
#[test]
fn a_turned_box() {
    let half = DVec3::splat(0.8);
    let turn = DQuat::from_rotation_z(10_f64.to_radians())
        * DQuat::from_rotation_y(35_f64.to_radians())
        * DQuat::from_rotation_x(20_f64.to_radians());
    let (dense, few, voxel, told) = both("[shape.s]\nbox = 1.6\nrotate = [20, 35, 10]\n", 96, 0.1);
    assert!(few.triangles.len() * 20 < dense.triangles.len(), "{}", few.triangles.len());
    let distance = |p: DVec3| of_box(half)(turn.inverse() * p);
    let [of_dense, of_few] = [&dense, &few].map(|surface| away(surface, distance, voxel));
    let [dense_back, few_back] =
        [&dense, &few].map(|surface| away_back(surface, on_box(half, 60).map(|p| turn * p), voxel));
    assert!(of_few < of_dense.max(0.1) + 1e-4 && few_back < dense_back.max(0.1) + 1e-4);
    assert!(of_few < 0.1 || told.contains("triangles may be further than 0.1 voxels from the surface"), "{told}");
}

/// A ball through a plate that is not much thicker than a voxel: neither is lost, nor joined.
#[test]
fn a_thin_part() {
    let scene = "[shape.ball]\nsphere = 0.6\n[shape.plate]\nbox = [2.4, 1.2, 0.05]\n[shape.s]\n\
                 union = ['ball', 'plate']\n[output]\nshape = 's'\n";
    let (dense, few, voxel, told) = both(scene, 96, 0.1);
    assert!(few.triangles.len() * 5 < dense.triangles.len());
    let plate = of_box(DVec3::new(1.2, 0.6, 0.025));
    let distance = move |p: DVec3| (p.length() - 0.6).min(plate(p));
    let [of_dense, of_few] = [&dense, &few].map(|surface| away(surface, &distance, voxel));
    assert!(of_few < 0.1 || told.contains("further") && of_few < of_dense + 1e-4, "{of_few} and {of_dense}: {told}");
    let on_plate = || on_box(DVec3::new(1.2, 0.6, 0.025), 50).filter(|p| p.length() > 0.6);
    let on_ball = || on_sphere(20_000).map(|p| 0.6 * p).filter(|p| p.z.abs() > 0.025);
    let [dense_back, few_back] = [&dense, &few].map(|surface| away_back(surface, on_plate().chain(on_ball()), voxel));
    assert!(few_back < dense_back.max(0.1) + 1e-4, "{few_back} and {dense_back}");
}

/// How far a linear mix of the corners' attributes is from those of the place itself, at points of the triangles that
/// `counts` takes.
fn smeared(
    surface: &Surface,
    counts: impl Fn(DVec3) -> bool,
    differs: impl Fn([usize; 3], [f64; 3], DVec3) -> f64,
) -> f64 {
    let mut most = 0.0_f64;
    for triangle in &surface.triangles {
        let [a, b, c] = surface.corners(triangle);
        for i in 0..=8 {
            for j in 0..=8 - i {
                let weights = [8 - i - j, i, j].map(|share| f64::from(share) / 8.0);
                let place = a * weights[0] + b * weights[1] + c * weights[2];
                if counts(place) {
                    most = most.max(differs(triangle.map(|vertex| vertex as usize), weights, place));
                }
            }
        }
    }
    most
}

/// A border of colours stays where it is: beyond the voxel in which it is mixed without adaptivity, colours are pure.
#[test]
fn borders_of_colours() {
    // Of the shape's own x and y.
    let border = |p: DVec3| p.x - 0.013 + 0.3 * (p.y - 0.007) + 0.02;
    let share = |p: DVec3| (1000.0 * border(p)).clamp(0.0, 1.0);
    let mixed = "0.8*min(max(1000*(x + 0.3*y + 0.02), 0), 1)";
    let scene = format!(
        "[shape.s]\nbox = 1.6\nmove = [0.013, 0.007, -0.004]\ncolor = [\"0.1 + {mixed}\", 0.3, \"0.9 - {mixed}\"]\n"
    );
    let (dense, few, voxel, _) = both(&scene, 96, 0.1);
    assert!(few.triangles.len() * 5 < dense.triangles.len(), "{} of {}", few.triangles.len(), dense.triangles.len());
    let wanted = |p: DVec3| [0.1 + 0.8 * share(p), 0.3, 0.9 - 0.8 * share(p)].map(|part| part * 255.0);
    for (place, colour) in few.positions.iter().zip(&few.colours) {
        let far = wanted(*place).iter().zip(colour).map(|(a, b)| (a - f64::from(*b)).abs()).fold(0.0, f64::max);
        // The scene's numbers are single floats: next to the border its thousandfold slope shows that.
        assert!(far < 1.6, "{colour:?} at {place}");
    }
    let away = |p: DVec3| border(p).abs() / 1.09_f64.sqrt();
    let differs = |corners: [usize; 3], weights: [f64; 3], place: DVec3| {
        let part = |i: usize| (0..3).map(|k| weights[k] * f64::from(few.colours[corners[k]][i])).sum::<f64>();
        wanted(place).into_iter().enumerate().map(|(i, wanted)| (part(i) - wanted).abs()).fold(0.0, f64::max)
    };
    let most = smeared(&few, |p| away(p) > 1.8 * voxel, differs);
    assert!(most < 3.0, "{most} of 255");
}

/// A number of the scene's own goes with it, at vertices and between.
#[test]
fn attributes() {
    let scene = "[shape.s]\nsphere = 1\nattribute.wave = '3*sin(5*z)'\n[output]\ngrids = ['surface', 'wave']\n";
    let (dense, few, _, _) = both(scene, 96, 0.1);
    assert!(few.triangles.len() * 2 < dense.triangles.len());
    let wave = |p: DVec3| 3.0 * (5.0 * p.z).sin();
    assert!(few.positions.iter().zip(&few.numbers).all(|(p, own)| (wave(*p) - f64::from(own[0])).abs() < 1e-4));
    let differs = |corners: [usize; 3], weights: [f64; 3], place: DVec3| {
        let mixed: f64 = (0..3).map(|k| weights[k] * f64::from(few.numbers[corners[k]][0])).sum();
        // The triangle is beside the place where the vertices are that it was looked at by.
        (mixed - wave(place)).abs()
    };
    let most = smeared(&few, |_| true, differs);
    assert!(most < 2.0 * 6.0 / 255.0, "{most}");
}

#[test]
fn the_same_on_any_number_of_threads() {
    let place = Workplace::new();
    for scene in ["cubism", "heart"] {
        let bytes = ["1", "2", "3"].map(|threads| {
            let bake = format!("bake {scene} -o {threads}/m.####.glb --frames 7 --resolution 96 --adaptivity 0.07");
            fs::create_dir_all(place.path(threads)).expect("a folder");
            place.hfvdb(&format!("{bake} --threads {threads} --overwrite")).ok();
            fs::read(place.path(&format!("{threads}/m.0007.glb"))).expect("a file")
        });
        assert!(bytes[0] == bytes[1] && bytes[0] == bytes[2], "{scene}");
    }
}

#[test]
fn of_files_of_any_kind() {
    let place = Workplace::new();
    place.write("s.toml", "hfvdb = 1\n[shape.s]\nsphere = 1\ncolor = 'red'\n");
    place.hfvdb("bake s.toml -o s.vdb --resolution 48").ok();
    let told = place.hfvdb("mesh s.vdb -o of_voxels.ply --adaptivity 0.1").ok();
    assert!(told.stderr.contains(" triangles merged into "), "{}", told.stderr);
    Surface::read(&place, "of_voxels.ply").is_closed();
    let told = place.hfvdb("convert of_voxels.ply -o again.ply --adaptivity 0.2 --resolution 48").ok();
    assert!(told.stderr.contains(" triangles merged into "), "{}", told.stderr);
    let again = Surface::read(&place, "again.ply");
    again.is_closed();
    assert!(again.colours.iter().all(|colour| *colour == [255, 0, 0]));
    let text = |name: &str| fs::read_to_string(place.path(name)).expect("a file");
    place.write("ball.toml", support::BALL);
    place.hfvdb("bake ball.toml -o all.usda --frames 2-4 --resolution 32 --adaptivity 0.1").ok();
    assert!(text("all.usda").matches("int[] faceVertexIndices.timeSamples").count() == 1);
    // Of no surface there is none.
    place.write(
        "none.toml",
        "hfvdb = 1\nbounds = [[-1, -1, -1], [1, 1, 1]]\n[shape.s]\nsphere = 0.1\nmove = [9, 0, 0]\n",
    );
    place.hfvdb("bake none.toml -o none.ply --voxel-size 0.1 --allow-empty --adaptivity 0.1");
}

#[test]
fn it_is_part_of_what_a_frame_is() {
    let place = support::workplace();
    let bake = "bake ball.toml --resolution 24 -o out/m.####.ply --frames 2";
    place.hfvdb(bake).ok();
    let first = fs::read(place.path("out/m.0002.ply")).expect("a file");
    // None is what there was before, to the bit.
    let kept = place.hfvdb(&format!("{bake} --adaptivity 0 --resume")).ok();
    assert!(kept.stderr.contains("1 of 1 frames are done"), "{}", kept.stderr);
    let told = place.hfvdb(&format!("{bake} --adaptivity 0.1 --resume")).ok();
    assert!(told.stderr.contains("adaptivity 0 there, 0.1 here"), "{}", told.stderr);
    assert!(fs::read(place.path("out/m.0002.ply")).expect("a file") != first);
    for wrong in ["-0.1", "nan", "inf", "1.5", "x"] {
        place.hfvdb(&format!("{bake} --overwrite --adaptivity {wrong}")).fails(2, &["--adaptivity"]);
    }
    for voxels in ["vdb", "nvdb"] {
        let bake = bake.replace("ply", voxels);
        place.hfvdb(&format!("{bake} --adaptivity 0.1")).fails(2, &["--adaptivity", ".glb, .usda, .ply or .obj"]);
    }
}
