//! Morphs by OpenVDB: against the closed form, alone and in sequence, and what is refused.

use std::sync::atomic::Ordering;
use std::sync::{Arc, atomic::AtomicBool};

use glam::DVec3;

use super::{Error, FrameContent, Prepared};
use crate::field::Field;
use crate::shot::frame_tests::{prepared_with, refused};
use crate::shot::scalar_tests::{sampled, wrong};

/// A ball that becomes another around the same place, in 8 frames, on voxels of 1/20.
fn balls(from: f64, to: f64, more: &str) -> String {
    format!(
        "frames = '1-8'\n[shape.a]\nsphere = {from}\ncolor = {{ linear = [1, 0, 0] }}\n[shape.b]\nsphere = {to}\n\
         color = {{ linear = [0, 0, 1] }}\n[morph]\nfrom = 'a'\nto = 'b'\nmode = 'openvdb'\n{more}\n\
         [output]\nvoxel_size = 0.05\n"
    )
}

fn ready(text: &str) -> Prepared {
    prepared_with(text, None).unwrap_or_else(|error| panic!("{error}"))
}

/// How far along x the surface is.
fn radius(content: &FrameContent) -> f64 {
    let (mut inside, mut outside) = (0.0, 2.0);
    for _ in 0..40 {
        let middle = 0.5 * (inside + outside);
        let value = content.field.reference(DVec3::new(middle, 0.0, 0.0));
        if value >= 0.0 { inside = middle } else { outside = middle }
    }
    outside
}

/// dr/dt = R − r, no faster than the half-width a unit of time, in steps far finer than OpenVDB's.
fn exact_radius(from: f64, to: f64, duration: f64) -> f64 {
    const STEPS: usize = 100_000;
    (0..STEPS).fold(from, |radius, _| radius + (to - radius).clamp(-0.15, 0.15) * duration / STEPS as f64)
}

#[test]
fn a_ball_moves_by_the_distance_of_the_other_and_comes_to_rest_there() {
    for (from, to) in [(0.5, 1.0), (1.0, 0.6)] {
        let scene = ready(&balls(from, to, ""));
        let step = scene.level_sets.as_ref().expect("OpenVDB's").step;
        let mut before = from;
        for frame in 1..=8 {
            let content = scene.frame(frame).unwrap();
            let (found, exact) = (radius(&content), exact_radius(from, to, step * (frame - 1) as f64));
            // OpenVDB is up to a twentieth slower than that: it moves the surface a little as it makes distances anew.
            assert!((found - exact).abs() <= 0.06 * (exact - from).abs() + 1e-9, "frame {frame}: {found} {exact}");
            let report = scene.report(frame).unwrap().expect("a morph");
            let volume = 4.0 / 3.0 * std::f64::consts::PI * found.powi(3);
            assert!((report.numbers.volume / volume - 1.0).abs() < 0.02, "frame {frame}: {report:?} {volume}");
            assert!((report.displacement - (found - before).abs()).abs() < 0.01, "frame {frame}: {report:?} {before}");
            assert_eq!(report.numbers.pieces, 1);
            before = found;
        }
        assert!((radius(&scene.frame(8).unwrap()) - to).abs() < 0.005);
        // Before and after, the objects themselves.
        let beyond = scene.frame(9).unwrap();
        assert!((radius(&beyond) - to).abs() < 1e-9 && (radius(&scene.frame(1).unwrap()) - from).abs() < 1e-9);
    }
}

#[test]
fn a_frame_alone_is_that_of_the_sequence() {
    let text = balls(0.5, 0.9, "over = '2-7'");
    let values = |scene: &Prepared, frame: i64| -> Vec<f64> {
        let field: Arc<dyn Field> = scene.frame(frame).unwrap().field;
        (0..200).map(|i| field.reference(DVec3::new(0.011 * f64::from(i), 0.003 * f64::from(i), 0.21))).collect()
    };
    let scene = ready(&text);
    let all: Vec<Vec<f64>> = (1..=8).map(|frame| values(&scene, frame)).collect();
    for frame in [6, 3, 7, 1, 8, 2] {
        let index = frame as usize - 1;
        assert_eq!(values(&ready(&text), frame), all[index], "frame {frame}");
        assert_eq!(values(&scene, frame), all[index], "frame {frame} again");
    }
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    crate::vdb::set_threads(1).expect("fewer threads");
    let on_one_thread = one.install(|| values(&ready(&text), 5));
    crate::vdb::set_threads(rayon::current_num_threads()).expect("as many as before");
    assert_eq!(on_one_thread, all[4]);
    assert_eq!(all[0], all[1]);
    assert_ne!(all[1], all[2]);
    assert!((radius(&scene.frame(8).unwrap()) - 0.9).abs() < 1e-9);
}

#[test]
fn attributes_and_cuts_go_as_in_every_mode() {
    let scene = ready(
        &balls(0.5, 0.9, "cut = 'half'\nalpha = 3")
            .replace("[morph]", "[shape.half]\nbox = 4\nmove = [0, 0, 2.1]\n[morph]"),
    );
    let content = scene.frame(4).unwrap();
    assert!(content.field.reference(DVec3::new(0.1, 0.0, 0.2)) < 0.0);
    assert!(content.field.reference(DVec3::new(0.1, 0.0, 0.0)) > 0.0);
    let [red, green, blue] = sampled(content.colour.as_deref().expect("a colour"), DVec3::new(0.4, 0.1, 0.0));
    assert!(red > 0.1 && blue > 0.1 && green < 0.5, "{red} {green} {blue}");
}

#[test]
fn what_it_cannot_do_is_refused() {
    let vel = balls(0.5, 0.9, "").replace("[output]", "[output]\ngrids = ['surface', 'vel']");
    wrong(&vel, "8:2 `output.grids` has `vel`, which `mode = \"openvdb\"` does not give");
    let moving = balls(0.5, 0.9, "").replace("sphere = 0.9", "sphere = 0.9\nmove = ['0.1*t', 0, 0]");
    refused(&moving, "`b` moves, and in `mode = \"openvdb\"` both objects stand still");
    wrong(&balls(0.5, 0.9, "ease = 'smooth'"), "12:1 `ease` is not for `mode = \"openvdb\"`");
    let apart = balls(0.3, 0.3, "").replacen("sphere = 0.3", "sphere = 0.3\nmove = [1, 0, 0]", 1);
    let scene = ready(&apart);
    assert!(scene.warnings.to_string().contains("the objects do not overlap"), "{}", scene.warnings);
    // Nothing is left, and nothing breaks.
    assert!(scene.frame(8).unwrap().field.reference(DVec3::ZERO) < 0.0);
    assert_eq!(scene.report(8).unwrap().expect("a morph").numbers.volume, 0.0);
}

#[test]
fn it_stops_when_it_is_told() {
    let scene = ready(&balls(0.5, 0.9, ""));
    let cancel: &AtomicBool = &scene.cancel;
    cancel.store(true, Ordering::Relaxed);
    assert!(matches!(scene.frame(5), Err(Error::Cancelled)));
    // What was stopped is not taken for a frame.
    cancel.store(false, Ordering::Relaxed);
    assert_eq!(radius(&scene.frame(5).unwrap()), radius(&ready(&balls(0.5, 0.9, "")).frame(5).unwrap()));
}
