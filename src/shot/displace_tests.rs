//! Surfaces moved by a scalar and solids filled by two structures: against exact answers, over morphs, with bad input.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, IVec3};

use super::*;
use crate::distance::accuracy::{Accuracy, compare};
use crate::distance::band::{self, measure};
use crate::field::Points;
use crate::grid::{BLOCK_EDGE, Band, is_active, voxel_offset};
use crate::shot::scalar_tests::{Sampling, prepared, prepared_at, refused, scalar, wrong};

fn measured(scene: &Prepared, frame: i64) -> Result<Band, band::Error> {
    let content = scene.frame(frame).unwrap_or_else(|error| panic!("{error}"));
    let settings = band::Settings {
        lattice: scene.lattice,
        half_width: scene.half_width,
        region: content.region,
        feet: band::Feet::Nearest,
        cancel: &AtomicBool::new(false),
        progress: &|_| {},
    };
    measure(&*content.field, &settings, || |_: &band::MeasuredBlock| ()).map(|measured| measured.band)
}

pub(crate) fn band_of(scene: &Prepared, frame: i64) -> Band {
    measured(scene, frame).unwrap_or_else(|error| panic!("{error}"))
}

/// As far as every band is, and no side wrong.
#[track_caller]
fn assert_exact(scene: &Prepared, frame: i64, exact: impl Fn(DVec3) -> f64 + Sync) {
    let accuracy = assert_near(scene, frame, exact);
    assert_eq!(accuracy.wrong_signs, 0);
}

/// The same from a distance that was measured first: sides too are right but for a part of a voxel.
#[track_caller]
pub(crate) fn assert_near(scene: &Prepared, frame: i64, exact: impl Fn(DVec3) -> f64 + Sync) -> Accuracy {
    let accuracy = compare(&band_of(scene, frame), exact);
    assert!(accuracy.max <= 0.05 && accuracy.mean <= 0.005 && accuracy.voxels > 1000, "{accuracy:?}");
    accuracy
}

pub(crate) fn distance_to_box(at: DVec3, half: f64) -> f64 {
    let beyond = at.abs() - half;
    -(beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0))
}

fn moved(maker: &str, by: &str) -> Prepared {
    prepared(&format!("[shape.a]\n{maker}\ndisplace = 'bump'\nattribute.bump = {by}\n"))
}

#[test]
fn a_ball_moved_by_a_number_is_a_ball_of_another_radius() {
    // The last is no distance, and so is measured first.
    for (maker, measured) in [("sphere = 1", false), ("formula = '1 - x^2 - y^2 - z^2'\nbounds = 3", true)] {
        for by in [0.1, -0.2, 0.4] {
            let scene = moved(maker, &by.to_string());
            let accuracy = assert_near(&scene, 1, |at| 1.0 + by - at.length());
            assert!(measured || accuracy.wrong_signs == 0);
            let size = scene.extent.size();
            assert!((size - 2.0 * (1.0 + by)).abs().max_element() < 0.02, "{size}");
        }
    }
}

/// Outward a box grows round, inward its edges stay sharp.
#[test]
fn a_box_moved_by_a_number() {
    assert_exact(&moved("box = 2", "0.3"), 1, |at| distance_to_box(at, 1.0) + 0.3);
    assert_exact(&moved("box = 2", "-0.3"), 1, |at| distance_to_box(at, 0.7));
    let scene = moved("box = 2\nscale = 2\nmove = [5, 0, 0]", "-0.3");
    assert_exact(&scene, 1, |at| distance_to_box(at - DVec3::X * 5.0, 1.4));
}

/// Every voxel of the whole box against the formula itself, by itself.
#[test]
fn a_formula_moves_the_surface_where_it_says() {
    let scene = moved("sphere = 1", "'0.08*sin(9*x)*cos(7*y) + 0.05*z'");
    let moved = |at: DVec3| 1.0 - at.length() + 0.08 * (9.0 * at.x).sin() * (7.0 * at.y).cos() + 0.05 * at.z;
    let band = band_of(&scene, 1);
    let edge = scene.lattice.voxel_size.get();
    let reach = (1.3 / edge) as i32;
    let inside = |voxel: IVec3| moved(voxel.as_dvec3() * edge) >= 0.0;
    let mut judged = 0;
    for x in -reach..=reach {
        for y in -reach..=reach {
            for z in -reach..=reach {
                let voxel = IVec3::new(x, y, z);
                let near = moved(voxel.as_dvec3() * edge).abs() < 1e-5;
                let at_surface = IVec3::AXES.into_iter().any(|way| inside(voxel + way) != inside(voxel));
                let block = voxel.map(|i| i.div_euclid(BLOCK_EDGE) * BLOCK_EDGE);
                let Some(place) = band.origins.iter().position(|origin| *origin == block) else {
                    assert!(!at_surface, "no block at {voxel}");
                    continue;
                };
                let offset = voxel_offset(voxel);
                assert!(is_active(&band.active[place], offset) || !at_surface, "a hole at {voxel}");
                let found = band.distances[place][offset] >= 0.0;
                assert!(near || found == inside(voxel), "the wrong side at {voxel}");
                judged += 1;
            }
        }
    }
    assert!(judged > 30_000, "{judged}");
    // What was measured is the distance of the moved surface, not F: of slope 1, where F's goes from 0.6 to 1.5.
    let slope = crate::grid::measure::slope_error(&band);
    assert!(slope.mean < 0.01, "{slope:?}");
}

#[test]
fn what_moves_the_surface_may_change_and_come_from_parts() {
    for maker in ["sphere = 1", "formula = '1 - x^2 - y^2 - z^2'\nbounds = 3"] {
        let scene = prepared(&format!(
            "frames = '1-5'\n[shape.a]\n{maker}\ndisplace = 'grow'\nattribute.grow = {{ 1 = 0, 5 = 0.4 }}\n"
        ));
        for frame in [1, 2, 5] {
            assert_near(&scene, frame, |at| 1.0 + 0.1 * (frame - 1) as f64 - at.length());
        }
    }
    let scene = prepared(
        "[shape.all]\nunion = ['a', 'b']\ndisplace = 'grow'\n[shape.a]\nsphere = 1\nattribute.grow = 0.2\n\
         [shape.b]\nsphere = 1\nmove = [4, 0, 0]\nattribute.grow = -0.2\n",
    );
    let frame = scene.frame(1).unwrap();
    // Outside of both, the mean by the inverse of the distances.
    for i in 0..400 {
        let at = DVec3::new(-1.5 + 0.0178 * f64::from(i), 0.3, -0.2);
        let distance = (1.0 - at.length()).max(1.0 - at.distance(DVec3::X * 4.0));
        let wanted = distance + f64::from(scalar(&frame, "grow", at.to_array()));
        assert!(wanted.abs() < 1e-3 || (wanted > 0.0) == (frame.field.reference(at) > 0.0), "{at} {wanted}");
    }
    for (x, inside) in [(-1.17, true), (-1.2, false), (4.79, true), (4.82, false)] {
        assert_eq!(frame.field.reference(DVec3::X * x) > 0.0, inside, "{x}");
    }
}

const MORPH: &str = "frames = '1-9'\n[shape.a]\nsphere = 1\nattribute.bump = 0.1\n[shape.b]\nbox = 1.6\n\
                     attribute.bump = -0.15\n[morph]\nfrom = 'a'\nto = 'b'\ndisplace = 'bump'\n";

#[test]
fn a_morph_is_moved_by_what_it_mixes() {
    let scene = prepared(MORPH);
    assert_exact(&scene, 1, |at| 1.1 - at.length());
    assert_exact(&scene, 9, |at| distance_to_box(at, 0.65));
    assert!(scene.extent.min.cmple(DVec3::splat(-1.1)).all() && scene.extent.max.cmpge(DVec3::splat(1.1)).all());
    let bare = prepared(&MORPH.replace("displace = 'bump'\n", ""));
    let (moved, bare) = (scene.frame(5).unwrap(), bare.frame(5).unwrap());
    // Along a line outward: where the moved surface is, the bare one is as far away as the scalar says.
    let last_inside = |field: &dyn crate::field::Field, way: DVec3| {
        (0..20_000).map(|i| f64::from(i) * 1e-4).take_while(|s| field.reference(way * s) >= 0.0).last().unwrap()
    };
    for way in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
        let (there, before) = (last_inside(&*moved.field, way), last_inside(&*bare.field, way));
        let bump = f64::from(scalar(&moved, "bump", (way * there).to_array()));
        // Both objects are symmetric about each axis, so the normal is the axis.
        assert!((there - before - bump).abs() < 2e-3, "{there} {before} {bump} along {way}");
        assert!((-0.1..0.08).contains(&bump));
    }
}

#[test]
fn a_moved_frame_alone_is_that_of_the_sequence() {
    let text = MORPH.replace("= 0.1", "= '0.05*sin(20*z + 3*t)'").replace("box = 1.6", "box = 1.6\nmove = ['t', 0, 0]");
    let (alone, sequence) = (prepared(&text), prepared(&text));
    let [before, in_turn] = [5, 6].map(|frame| band_of(&sequence, frame));
    let one = band_of(&alone, 6);
    assert!(one.origins == in_turn.origins && one.distances == in_turn.distances && one.active == in_turn.active);
    assert_ne!(one.distances, before.distances);
}

/// At each point of a frame F has the sign of the plain formula, from the values of its terms.
#[test]
fn a_morph_is_filled_by_what_it_mixes() {
    let text = |fill: &str| {
        format!(
            "frames = '1-9'\n[shape.a]\nsphere = 1\nattribute.omega = 0\n[shape.b]\nbox = 1.6\nmove = [0.5, 0, 0]\n\
             attribute.omega = 1\n[shape.waves]\nformula = 'sin(9*x)*cos(9*y) + sin(9*y)*cos(9*z)'\n\
             [shape.rods]\nformula = '0.3 - cos(11*x)*cos(11*z)'\n[morph]\nfrom = 'a'\nto = 'b'\n{fill}\n"
        )
    };
    let filled = prepared(&text("fill = { mix = ['waves', 'rods'], by = 'omega' }"));
    let bare = prepared(&text(""));
    assert_eq!(filled.extent, bare.extent);
    for frame in [1, 4, 9] {
        let (filled, bare) = (filled.frame(frame).unwrap(), bare.frame(frame).unwrap());
        let mut signs = [0; 2];
        for i in 0..4000 {
            // Points by a rule that no period of the formulas has.
            let share = |k: f64| 3.0 * (f64::from(i) * k).fract() - 1.3;
            let at = DVec3::new(share(0.618_034), share(0.754_878), share(0.569_84));
            let omega = f64::from(scalar(&bare, "omega", at.to_array()));
            let DVec3 { x, y, z } = at * 9.0;
            let waves = x.sin() * y.cos() + y.sin() * z.cos();
            let rods = 0.3 - (11.0 * at.x).cos() * (11.0 * at.z).cos();
            let inner = (1.0 - omega) * waves + omega * rods;
            let wanted = inner.min(bare.field.reference(at));
            assert!(wanted.abs() < 1e-5 || (wanted > 0.0) == (filled.field.reference(at) > 0.0), "{at} {wanted}");
            signs[usize::from(wanted > 0.0)] += 1;
        }
        assert!(signs.iter().all(|count| *count > 100), "{signs:?}");
    }
    assert!(measured(&filled, 4).is_ok());
}

#[test]
fn what_cannot_move_a_surface_is_refused_with_its_place() {
    let shape = |lines: &str| format!("[shape.a]\nsphere = 1\n{lines}\n");
    wrong(&shape("displace = 'bumb'\nattribute.bump = 1"), "3:13 there is no `attribute.bumb` here");
    wrong(&shape("displace = 'bump'"), "3:13 there is no `attribute.bump` here");
    wrong(&shape("displace = 0.1\nattribute.bump = 1"), "3:12 `shape.a.displace` must be the name of an attribute");
    wrong(
        &shape("displace = 'bump'\nattribute.bump = 'sin(q)'"),
        "4:23 nothing here is called `q`; known are `frame`, `t`, `time`, `x`, `y`, `z`, `pi`",
    );
    let morph = |lines: &str| {
        format!(
            "frames = '1-9'\n[shape.a]\nsphere = 1\ndisplace = 'bump'\nattribute.bump = 0.1\n[shape.b]\nbox = 1\n\
             [shape.c]\nbox = 1\nattribute.other = 1\n[morph]\nfrom = 'a'\nto = 'b'\n{lines}\n"
        )
    };
    wrong(&morph("displace = 'other'"), "14:13 there is no `attribute.other` here");
    wrong(&morph("displace = 'bump'"), "14:13 `bump` moves the surface of `a` already");
    wrong(&morph("fill = { mix = ['a', 'c'], by = 'nothing' }"), "14:34 there is no `attribute.nothing` here");
    wrong(&morph("fill = { mix = ['a'], by = 'bump' }"), "14:16 `morph.fill.mix` must be a list of two shapes");
    wrong(&morph("fill = { mix = ['a', 'd'], by = 'bump' }"), "14:23 there is no `shape.d`");
}

#[test]
fn what_has_no_greatest_value_is_told() {
    let shape = |by: &str| format!("[shape.a]\nsphere = 1\ndisplace = 'bump'\nattribute.bump = '{by}'\n");
    // What may be no number has none either.
    for by in ["0.1*log(x)", "0.1/x", "x*(1 + x^2)", "0.1*sqrt(x)"] {
        let said = refused(&shape(by));
        assert!(said.contains("`bump` has no greatest value near `a`") && said.contains(":3:"), "{by}: {said}");
    }
    let said = refused(&format!(
        "frames = '1-3'\n{}[morph]\nfrom = 'a'\nto = 'a'\nfill = {{ mix = ['a', 'a'], by = 'bump' }}\ndisplace = 'bump'\n",
        shape("1/x").replace("displace = 'bump'\n", "")
    ));
    assert!(said.contains("no greatest value"), "{said}");
}

/// The 512 centres of a block are one batch: what is asked point by point is the same.
#[test]
fn a_batch_is_its_points() {
    let scene = prepared(MORPH);
    let content = scene.frame(5).unwrap();
    let points = Points::of_block(IVec3::new(32, 0, 0), &scene.lattice);
    let mut values = [0.0; 512];
    content.field.evaluator().values(&points, &mut values);
    for i in (0..512).step_by(37) {
        assert!((f64::from(values[i]) - content.field.reference(points.position(i))).abs() < 1e-5);
    }
}

/// Measuring these takes from seconds to minutes; whoever waits for the end of it has not heard.
#[test]
fn measuring_a_shape_stops_when_it_is_told() {
    let solid = "heart = 1";
    let displaced = format!("[shape.a]\n{solid}\ndisplace = 'bump'\nattribute.bump = 0.05\n");
    let walled = format!("[shape.a]\n{solid}\nshell = 0.05\n");
    let moving = displaced.replace(solid, "heart = 'mix(1, 1.2, t)'");
    let moving = format!("frames = '1-9'\n{moving}");
    for text in [displaced, walled, moving] {
        let cancel = Arc::<AtomicBool>::default();
        let heard = Arc::clone(&cancel);
        let stopper = std::thread::spawn(move || {
            std::thread::sleep(std::time::Duration::from_millis(300));
            cancel.store(true, Ordering::Relaxed);
        });
        let result = prepared_at(Sampling::Resolution(2000), heard, &text);
        assert!(matches!(result, Err(Error::Cancelled)), "{text}: {:?}", result.err());
        stopper.join().expect("it only waits");
    }
}

/// Sheets of one gyroid that go over into thicker ones are as thick as the mean by ω, where that is also by the depth.
#[test]
fn a_shape_is_filled_by_what_an_attribute_mixes() {
    let gyroid = |thickness: f64| format!("{{ gyroid = 0.6, thickness = {thickness} }}");
    let shape = |fill: &str| prepared(&format!("[shape.a]\nsphere = 1\n{fill}\n"));
    let mixed = |omega: &str| {
        let (thin, thick) = (gyroid(0.05), gyroid(0.15));
        shape(&format!("fill = {thin}\nfill_to = {thick}\nfill_by = 'omega'\nattribute.omega = {omega}"))
    };
    let at = |i: i32| {
        let i = f64::from(i);
        DVec3::new(libm::sin(1.3 * i), libm::sin(2.1 * i + 1.0), libm::sin(3.7 * i + 2.0)) * 0.45
    };
    for (omega, thickness) in [(0.0, 0.05), (0.5, 0.1), (1.0, 0.15)] {
        let (mixed, plain) = (mixed(&omega.to_string()), shape(&format!("fill = {}", gyroid(thickness))));
        assert_eq!(mixed.extent, plain.extent);
        let (mixed, plain) = (mixed.frame(1).unwrap().field, plain.frame(1).unwrap().field);
        for at in (0..500).map(at) {
            assert!((mixed.reference(at) - plain.reference(at)).abs() < 1e-6, "{omega} {at}");
        }
    }
    let (graded, outer, inner) = (mixed("'1 - length(x, y, z)'"), mixed("0"), mixed("1"));
    let [graded, outer, inner] = [graded, outer, inner].map(|scene| scene.frame(1).unwrap().field);
    for at in (0..500).map(at) {
        let omega = 1.0 - at.length();
        let wanted = (1.0 - omega) * outer.reference(at) + omega * inner.reference(at);
        assert!((graded.reference(at) - wanted).abs() < 1e-4, "{at}");
    }
    let said = |keys: &str| refused(&format!("[shape.a]\nsphere = 1\nfill = {}\n{keys}\n", gyroid(0.1)));
    let (alone, without) = (said("fill_to = { gyroid = 1 }"), said("fill_by = 'omega'\nattribute.omega = 1"));
    assert!(alone.contains("`fill_to` goes with `fill_by`"), "{alone}");
    assert!(without.contains("`fill_by` goes with `fill_to`") && without.contains(":4:"), "{without}");
}
