//! Velocities: exact ones of known motions, and those of morphs against where the surface is in the next frame.

mod support;

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};
use hfvdb::bake::{Bytes, Computed, Interrupt, compute_frame, estimate};
use hfvdb::field::{Field, Gradients, Points};
use hfvdb::grid::{block_origin, is_active, voxel_offset};
use hfvdb::node::{Source, load};
use hfvdb::shot::{PrepareOptions, Prepared};
use hfvdb::text::Overrides;
use support::Workplace;

const VOXEL: f64 = 1.0 / 24.0;

fn prepared(text: &str) -> Prepared {
    let text = format!("{text}\n[output]\nvoxel_size = {VOXEL}\ngrids = ['surface', 'vel']\n");
    prepared_as_it_is(text)
}

fn prepared_as_it_is(text: String) -> Prepared {
    let source = Source::Text { name: "scene.toml".into(), text, folder: ".".into() };
    let model = load(&source, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"));
    let options = PrepareOptions {
        voxel_size: None,
        resolution: None,
        half_width: None,
        memory_limit: None,
        cache: None,
        cancel: Arc::default(),
        progress: &|_, _| (),
    };
    Arc::new(model).prepare(&options).unwrap_or_else(|error| panic!("{error}"))
}

fn computed(scene: &Prepared, frame: i64) -> Computed {
    compute_frame(scene, frame, 1, Bytes(u64::MAX), &Interrupt::default(), &|_| {})
        .unwrap_or_else(|error| panic!("{error}"))
}

/// A voxel of the band, its signed distance (positive inside) and its velocity.
struct Voxel {
    centre: DVec3,
    distance: f64,
    velocity: DVec3,
}

/// Those of the level set.
fn band(computed: &Computed) -> Vec<Voxel> {
    let velocities = computed.velocities.as_ref().expect("velocities");
    let band = &computed.band;
    let mut voxels = Vec::new();
    for ((origin, mask), distances) in band.origins.iter().zip(&band.active).zip(&band.distances) {
        let block = velocities.origins.iter().position(|other| other == origin).expect("the band's blocks");
        let centres = Points::of_block(*origin, &band.lattice);
        for at in (0..distances.len()).filter(|&at| is_active(mask, at)) {
            assert!(is_active(&velocities.active[block], at), "a voxel of the band has no velocity");
            let velocity = Vec3::from(velocities.channel.at(block, &velocities.active[block], at)).as_dvec3();
            voxels.push(Voxel { centre: centres.position(at), distance: f64::from(distances[at]), velocity });
        }
    }
    voxels
}

/// The greatest difference from exact velocities, units a second.
fn greatest_error(voxels: &[Voxel], exact: impl Fn(&Voxel) -> DVec3) -> f64 {
    voxels.iter().map(|voxel| (voxel.velocity - exact(voxel)).length()).fold(0.0, f64::max)
}

/// What moves the surface over time moves it as fast as it says.
#[test]
fn a_surface_moved_by_an_attribute_has_its_speed() {
    let ball = "frames = '1-5'\n[shape.a]\nsphere = 1\nattribute.grow = '0.3*time'\n";
    let morph = "[shape.b]\nsphere = 1\nattribute.grow = '0.3*time'\n[morph]\nfrom = 'a'\nto = 'b'\nmode = 'still'\n";
    for text in [format!("{ball}displace = 'grow'\n"), format!("{ball}{morph}displace = 'grow'\n")] {
        let voxels = band(&computed(&prepared(&text), 3));
        for Voxel { centre, velocity, .. } in &voxels {
            let wanted = centre.normalize() * 0.3;
            assert!((*velocity - wanted).length() < 0.003, "{velocity} at {centre}, not {wanted}");
        }
        assert!(voxels.len() > 10_000);
    }
}

#[test]
fn what_moves_rigidly_has_its_velocity_everywhere() {
    // 2 units in 8 frames of 1/24 s; a box has edges and corners.
    for shape in ["sphere = 1", "box = 1.5"] {
        let scene = prepared(&format!("frames = '1-9'\n[shape.a]\n{shape}\nmove = ['2*t', '-t', 0.25]"));
        for frame in [1, 4, 9] {
            let computed = computed(&scene, frame);
            let error = greatest_error(&band(&computed), |_| DVec3::new(6.0, -3.0, 0.0));
            assert!(error < 1e-3, "{shape}: off by {error} at frame {frame}");
            assert_eq!(computed.velocities.expect("velocities").held_voxels, 0);
        }
        // Outside the shot the ends hold.
        let outside = band(&computed(&scene, 12));
        assert_eq!(greatest_error(&outside, |_| DVec3::ZERO), 0.0);
    }
}

/// The speed of a turn lies in the surface wherever that is round: all of it must be there.
#[test]
fn a_turning_box_has_the_tangential_part_in_full() {
    let scene = prepared("frames = '1-9'\n[shape.a]\nbox = [1.5, 1, 1]\nrotate = [0, 0, '80*t']\nmove = [0.5, 0, 0]");
    let ball = prepared("frames = '1-9'\n[shape.a]\nsphere = 1\nrotate = [0, 0, '80*t']\nmove = [0.5, 0, 0]");
    let turn = 10.0f64.to_radians() * 24.0;
    for (name, scene) in [("box", &scene), ("ball", &ball)] {
        for frame in [1, 5, 9] {
            let voxels = band(&computed(scene, frame));
            let of = |foot: DVec3| DVec3::Z.cross(foot - DVec3::X * 0.5) * turn;
            let exact = |voxel: &Voxel| match name {
                "box" => {
                    let turned = DMat3::from_rotation_z((frame - 1) as f64 * 10.0f64.to_radians());
                    let own = turned.transpose() * (voxel.centre - DVec3::X * 0.5);
                    let half = DVec3::new(0.75, 0.5, 0.5);
                    let inside = own.abs().cmple(half).all();
                    let mut foot = own.clamp(-half, half);
                    if inside {
                        let room = half - own.abs();
                        let axis = (0..3).min_by(|a, b| room[*a].total_cmp(&room[*b])).expect("an axis");
                        foot[axis] = half[axis].copysign(own[axis]);
                    }
                    of(turned * foot + DVec3::X * 0.5)
                }
                _ => {
                    let from = voxel.centre - DVec3::X * 0.5;
                    of(DVec3::X * 0.5 + from.normalize())
                }
            };
            // Inside of a box two feet are equally near on its diagonals.
            let unique = |voxel: &&Voxel| name != "box" || voxel.distance < 0.0;
            let voxels: Vec<Voxel> = voxels.into_iter().filter(|voxel| unique(&voxel)).collect();
            let error = greatest_error(&voxels, exact);
            // Of speeds up to 5; the differences are right to second order of an eighth of a frame.
            assert!(error < 1.5e-3, "{name}: off by {error} at frame {frame}");
        }
    }
}

/// A shape bent along a curve begins where that does: moved along z before, it stands still. What turns about the curve does
/// not.
#[test]
fn what_is_bent_along_a_curve_moves_as_it_is_seen() {
    let scene = |first: &str| {
        prepared(&format!(
            "hfvdb = 1\nframes = '1-5'\n[shape.a]\nbox = [0.6, 0.4, 1]\ndo = [{first}, {{ bend_along = [[0, 0, 0], [0, 0, 1.5]] }}]"
        ))
    };
    let still = scene("{ move = [0, 0, 't'] }");
    let voxels = band(&computed(&still, 3));
    let fastest = voxels.iter().map(|voxel| voxel.velocity.length()).fold(0.0, f64::max);
    assert!(!voxels.is_empty() && fastest < 1e-3, "{fastest}");
    // 90° in 4 frames of 24 a second.
    let turning = scene("{ rotate = [0, 0, '90*t'] }");
    let voxels = band(&computed(&turning, 3));
    let rate = std::f64::consts::FRAC_PI_2 * 6.0;
    let sides: Vec<&Voxel> = voxels.iter().filter(|voxel| (0.3..1.2).contains(&voxel.centre.z)).collect();
    let off = |voxel: &&Voxel| (voxel.velocity.dot(DVec3::Z)).abs();
    assert!(sides.len() > 100 && sides.iter().map(off).fold(0.0, f64::max) < 0.05 * rate);
    let middle = sides.iter().map(|voxel| voxel.velocity.length()).sum::<f64>() / sides.len() as f64;
    assert!((0.5..3.0).contains(&middle), "{middle}");
}

#[test]
fn what_grows_moves_along_its_normals() {
    let scene = prepared("frames = '1-9'\n[shape.a]\nsphere = '1 + t/2'");
    let large = prepared("frames = '1-9'\n[shape.a]\nsphere = 1\nscale = '1 + t/2'");
    for scene in [&scene, &large] {
        for frame in [1, 5, 9] {
            let error = greatest_error(&band(&computed(scene, frame)), |voxel| voxel.centre.normalize() * 1.5);
            assert!(error < 5e-3, "off by {error} at frame {frame}");
        }
    }
}

#[test]
fn parts_that_move_have_their_own_motion() {
    let scene = prepared(
        "frames = '1-9'\n[shape.all]\nunion = ['a', 'b']\nmove = [0, 0, 't']\n[shape.a]\nsphere = 0.5\nmove = ['-1 - t', 0, 0]\n\
         [shape.b]\nsphere = 0.5\nmove = [1, 0, 0]\nrotate = [0, 0, '80*t']",
    );
    let turn = 10.0f64.to_radians() * 24.0;
    let voxels = band(&computed(&scene, 5));
    let exact = |voxel: &Voxel| {
        if voxel.centre.x < 0.0 {
            return DVec3::new(-3.0, 0.0, 3.0);
        }
        let from = voxel.centre - DVec3::new(1.0, 0.0, 0.5);
        DVec3::Z.cross(from.normalize() * 0.5) * turn + DVec3::Z * 3.0
    };
    let error = greatest_error(&voxels, exact);
    assert!(error < 2e-2, "off by {error}");
}

/// Where a field is 0 on the line through a point along its gradient, as a distance from the point.
fn off(field: &dyn Field, at: DVec3) -> f64 {
    let mut points = Points::new(at);
    let mut evaluator = field.evaluator();
    let mut gradients = Gradients::new();
    let mut position = at;
    for _ in 0..12 {
        points.origin = position;
        points.len = 0;
        points.push(Vec3::ZERO);
        evaluator.gradients(&points, &mut gradients);
        let gradient = gradients.gradient(0).as_dvec3();
        position -= gradient * f64::from(gradients.value[0]) / gradient.length_squared().max(1e-12);
    }
    position.distance(at)
}

/// Surface points moved by v·dt, against the surface dt later and earlier: what is left falls with dt². `dt` of a frame
/// is had by a shot of more frames.
#[test]
fn a_morphs_surface_moves_as_its_velocity_says() {
    let median_left = |frames: i64, still: bool| {
        let (left, right) = if still { ("-0.6", "0.6") } else { ("'-0.9 + 0.6*t^2'", "'0.9 - 0.3*t'") };
        let scene = prepared(&format!(
            "frames = '0-{frames}'\n[shape.a]\nsphere = 0.8\nmove = [{left}, 0, 0]\n[shape.b]\nbox = 1.2\n\
             move = [{right}, 0.2, 0]\n[morph]\nfrom = 'a'\nto = 'b'"
        ));
        let frame = frames / 2;
        let now = band(&computed(&scene, frame));
        let next = scene.frame(frame + 1).expect("a frame");
        let field = scene.frame(frame).expect("a frame").field;
        let mut evaluator = field.evaluator();
        let mut left: Vec<f64> = Vec::new();
        let mut moved: Vec<f64> = Vec::new();
        for voxel in now.iter().filter(|voxel| voxel.distance.abs() < 0.3 * VOXEL).step_by(7) {
            let mut points = Points::new(voxel.centre);
            points.push(Vec3::ZERO);
            let mut gradients = Gradients::new();
            evaluator.gradients(&points, &mut gradients);
            let foot = voxel.centre - gradients.gradient(0).as_dvec3().normalize() * voxel.distance;
            left.push(off(next.field.as_ref(), foot + voxel.velocity / 24.0));
            moved.push(off(next.field.as_ref(), foot));
        }
        left.sort_by(f64::total_cmp);
        moved.sort_by(f64::total_cmp);
        [left[left.len() / 2], moved[moved.len() / 2]]
    };
    for still in [true, false] {
        let [coarse, moved] = median_left(24, still);
        assert!(coarse < 0.25 * moved, "left {coarse} of {moved}");
        let [fine, ..] = median_left(96, still);
        // A quarter of dt: a sixteenth, but for the plan's own curve through 40 steps.
        assert!(fine < coarse / 8.0, "left {fine} after {coarse}");
    }
}

#[test]
fn velocities_reach_as_far_outside_as_the_surface_moves() {
    let scene = prepared("frames = '1-9'\n[shape.a]\nsphere = 0.5\nmove = ['3*t', 0, 0]");
    let computed = computed(&scene, 5);
    let velocities = computed.velocities.as_ref().expect("velocities");
    // 9 voxels a frame, along x; the ball stands at x = 1.5.
    let velocity = |position: DVec3| {
        let voxel = computed.band.lattice.nearest(position);
        let block = velocities.origins.iter().position(|origin| *origin == block_origin(voxel))?;
        let (active, at) = (&velocities.active[block], voxel_offset(voxel));
        is_active(active, at).then(|| Vec3::from(velocities.channel.at(block, active, at)))
    };
    let beyond = |direction: DVec3, voxels: f64| velocity(DVec3::X * 1.5 + direction * (0.5 + voxels * VOXEL));
    let diagonal = DVec3::ONE.normalize();
    let ways = [(DVec3::X, 8.5), (DVec3::NEG_X, 8.5), (DVec3::NEG_Y, 1.0), (diagonal, 4.0)];
    for (direction, farthest) in ways {
        for voxels in [1.0, 4.0, 8.5].into_iter().filter(|voxels| *voxels <= farthest) {
            let found = beyond(direction, voxels).unwrap_or_else(|| panic!("no velocity {voxels} along {direction}"));
            assert!(found.distance(Vec3::X * 9.0) < 1e-2, "{found}");
        }
    }
    // Where the surface does not come in the frame.
    for (direction, voxels) in [(DVec3::X, 12.0), (DVec3::NEG_Y, 5.5), (DVec3::Z, 8.5), (diagonal, 8.5)] {
        assert_eq!(beyond(direction, voxels), None, "{voxels} along {direction}");
    }
    // Not inside, where the band ends.
    assert_eq!(velocity(DVec3::X * 1.5), None);
    assert!(velocities.origins.is_sorted_by_key(|origin| hfvdb::grid::block_order(*origin)));
}

/// What is carried outward is estimated before it is: for a fast ball more than all else together.
#[test]
fn estimates_count_what_is_carried() {
    for text in [
        "frames = '1-6'\n[shape.a]\nsphere = 0.8\nmove = ['4*t', 0, 0]",
        "frames = '1-6'\n[shape.a]\nsphere = {1 = 0.2, 6 = 2}",
        "frames = '1-24'\n[shape.a]\nbox = 1\nrotate = [0, 0, '30*t']",
    ] {
        let scene = prepared(text);
        let estimate = estimate(&scene, &scene.frame(3).expect("a frame"), 1);
        let computed = computed(&scene, 3);
        let velocities = computed.velocities.as_ref().expect("velocities");
        let all: usize = velocities.channel.values.iter().map(|block| block.len()).sum();
        let bytes = (4 * computed.band.active_voxels() + 12 * all as u64) as f64;
        let ratio = estimate.file.0 as f64 / bytes;
        assert!((0.8..2.0).contains(&ratio), "{ratio} of {bytes} bytes of {text}");
    }
}

#[test]
fn what_is_too_fast_is_held_and_counted() {
    let text = "frames = '1-9'\n[shape.a]\nsphere = 0.5\nmove = ['3*t', 0, 0]\n[output]\nvoxel_size = 0.05\nmax_speed = 2\ngrids = ['surface', 'vel']\n";
    let computed = computed(&prepared_as_it_is(text.into()), 5);
    let velocities = computed.velocities.as_ref().expect("velocities");
    assert_eq!(velocities.held_voxels, computed.band.active_voxels());
    let error = greatest_error(&band(&computed), |_| DVec3::X * 2.0);
    assert!(error < 1e-3, "{error}");
}

/// A surface that crosses an eighth of the shot in a frame is one that meets, parts or vanishes; motion is not.
#[test]
fn changes_are_held_sooner_than_motion() {
    // It grows by 0.875 a frame, in a box some 6 wide, and moves by 1.
    let text = "frames = '1-3'\n[shape.a]\nsphere = {1 = 0.25, 3 = 2}\nmove = ['2*t', 0, 0]\n[output]\nvoxel_size = 0.05\ngrids = ['surface', 'vel']\n";
    let computed = computed(&prepared_as_it_is(text.into()), 2);
    let velocities = computed.velocities.as_ref().expect("velocities");
    assert_eq!(velocities.held_voxels, computed.band.active_voxels());
    let (most, change) = (velocities.max_speed, velocities.max_change);
    assert!((24.0 * 4.25..=24.0 * 6.5).contains(&most) && change == most / 8.0, "{most}, {change}");
    let error = greatest_error(&band(&computed), |voxel| {
        DVec3::new(24.0, 0.0, 0.0) + (voxel.centre - DVec3::X).normalize() * change
    });
    assert!(error < 0.01, "{error}");
}

#[test]
fn the_program_writes_them() {
    let place = Workplace::new();
    let text = "frames = '1-5'\n[shape.a]\nsphere = 1\ncolor = 'red'\nmove = [0, '2*t', 0]\n[output]\ngrids = ['surface', 'Cd', 'vel']\nmax_speed = 9\n";
    place.write("moving.toml", text);
    place.hfvdb("bake moving.toml --resolution 24 --half vel -o all/m.####.vdb").ok();
    let run = place.hfvdb("bake moving.toml --resolution 24 --half vel --frames 3 -o one/m.####.vdb").ok();
    let (_, told) = run.stderr.split_once("faster than 9").unwrap_or_else(|| panic!("{}", run.stderr));
    assert!(told.contains(" units a second at ") && told.contains(" voxels, and held to that"), "{}", run.stderr);
    let count = told.split_once(" second at ").and_then(|(_, told)| told.split_once(" voxels")).expect("a count").0;
    let record = std::fs::read_to_string(place.path("one/.m.0003.hfvdb-record.json")).expect("a record");
    assert!(record.contains(&format!("\"held_voxels\": {count}")), "{count} voxels, {record}");
    let bytes = |path: &str| {
        let mut bytes = std::fs::read(place.path(path)).expect("a frame");
        bytes[21..57].fill(0);
        bytes
    };
    assert!(bytes("all/m.0003.vdb") == bytes("one/m.0003.vdb"), "frame 3 depends on the frames beside it");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_frames.py");
    let mut command = std::process::Command::new("/usr/bin/python3");
    command.arg(script).args(place.frames("all").iter().map(|name| place.path("all").join(name)));
    place.run(&mut command).ok();
    place.hfvdb("check one/m.0003.vdb").ok();
}
