//! What follows the inside of a shape, in frames and morphs.

use glam::{DVec3, Vec3};

use crate::attribute::Scalar;
use crate::field::{BATCH, Points};
use crate::shot::scalar_tests::{prepared, refused};

fn sampled(scalar: &Scalar, at: DVec3) -> f64 {
    let (mut points, mut out) = (Points::new(at), [[f32::NAN]; BATCH]);
    points.push(Vec3::ZERO);
    scalar.sampler().sample(&points, &mut out);
    f64::from(out[0][0])
}

const TIP: &str = "[shape.tip]\nsphere = 0.1\nmove = [-0.9, 0, 0]\n";

/// A body that grows around a feature that moves: each frame its own ways.
#[test]
fn frames_of_a_body_that_changes() {
    let text = format!(
        "frames = '1-9'\n[output]\nshape = 's'\n[shape.s]\nbox = [2, '0.4 + t', 0.4]\nattribute.way = {{ interior = ['tip'], lattice = 24 }}\n{}",
        TIP.replace("[-0.9, 0, 0]", "['t - 0.9', 0, 0]")
    );
    let scene = prepared(&text);
    assert!(scene.warnings.is_empty(), "{}", scene.warnings);
    let at = DVec3::new(0.7, 0.1, 0.1);
    for (frame, x) in [(1, -0.9), (5, -0.4), (9, 0.1)] {
        let content = scene.frame(frame).expect("a frame");
        let [(name, way)] = &content.scalars[..] else { panic!("one scalar") };
        let wanted = at.distance(DVec3::X * x) - 0.1;
        assert!(name == "way" && (sampled(way.as_ref(), at) - wanted).abs() < 1e-5, "{frame}");
    }
}

#[test]
fn warnings_come_with_the_scene() {
    let text = format!(
        "[output]\nshape = 's'\n[shape.s]\nbox = [2, 0.4, 0.4]\nattribute.way = {{ interior = ['tip'], lattice = 24 }}\n{}",
        TIP.replace("[-0.9, 0, 0]", "[-0.9, 0.5, 0]")
    );
    let warnings = prepared(&text).warnings.to_string();
    assert!(warnings.contains("all of `tip` is outside of `s`") && warnings.contains("scene.toml:6:8"), "{warnings}");
}

/// A morph whose delay is the way inside: half-way the near end has changed, the far end has not.
#[test]
fn a_delay_crawls_along_the_body() {
    let text = format!(
        "frames = '1-9'\n[shape.thin]\nbox = [2, 0.3, 0.3]\nattribute.way = {{ interior = ['tip'], lattice = 24 }}\nattribute.wait = 'way/2'\n\
         [shape.thick]\nbox = [2, 0.7, 0.7]\n[morph]\nfrom = 'thin'\nto = 'thick'\ndelay = {{ shape = 'thin', attribute = 'wait', most = 0.8 }}\n{TIP}"
    );
    let scene = prepared(&text);
    let field = scene.frame(5).expect("a frame").field;
    let beside = |x: f64| field.reference(DVec3::new(x, 0.0, 0.22));
    assert!(beside(-0.7) > 0.0 && beside(0.7) < 0.0, "{}, {}", beside(-0.7), beside(0.7));
}

#[test]
fn the_inside_of_a_plane_shape_is_asked_for_as_a_solid() {
    let said = refused("[shape.r]\nrectangle = 1\nattribute.q = { interior = [{ circle = 0.5 }] }\n");
    assert!(said.contains("`interior` needs solids, and `r` is a shape of the plane"), "{said}");
    assert!(said.contains("make it a solid with `extrude`"), "{said}");
}
