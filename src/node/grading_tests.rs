//! Structures that go over into others of their row.

use glam::DVec3;

use super::row_tests::{assert_bounds_hold, wrong_distances};
use super::shape_tests::{field, problem};
use crate::field::tests::{Samples, bits_by_width};
use crate::field::{Aabb, Field, Slope};

const CUBE: Aabb = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));

const FOAM: &str = "box = 2\nfill = { foam = 0.2, wall = 0.02 }\nfill_to = { foam = 0.6, wall = 0.12 }\nfill_by = 'w'\n\
                    attribute.w = '0.5 + 0.5*x'";
const PORES: &str = "box = 2\nfill = { pores = 0.2 }\nfill_to = { pores = 0.6, radius = 0.2 }\nfill_by = 'w'\n\
                     attribute.w = '0.5 + 0.5*x'";

/// What holds of every row's example holds of structures that go over.
#[test]
fn what_is_declared_of_them_holds() {
    for keys in [FOAM, PORES] {
        let (field, mut samples) = (field(keys), Samples::new(31));
        let points = samples.batch(&CUBE, 300);
        let answers = bits_by_width(&field, &points);
        assert!(answers.iter().all(|answer| *answer == answers[0]), "{keys}: widths differ");
        for i in 0..points.len {
            let (value, exact) = (f64::from(f32::from_bits(answers[0][0][i])), field.reference(points.position(i)));
            assert!((value - exact).abs() < 2e-5, "{keys}: {value}, {exact}");
        }
        assert_bounds_hold(keys, &field, &CUBE, 1.0, &mut samples);
        assert!(matches!(field.slope(), Slope::Exact { .. } | Slope::Lipschitz(1.0)), "{keys}: {:?}", field.slope());
        for _ in 0..5000 {
            let (p, q) = (samples.within(&CUBE), samples.within(&CUBE));
            let q = p + (q - p) * samples.next().powi(4);
            let (first, second) = (field.reference(p), field.reference(q));
            assert!((first - second).abs() <= p.distance(q) * (1.0 + 1e-6) + 1e-6, "{keys} is too steep at {p}");
        }
        let wrong = wrong_distances(keys, &field);
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}

/// Cells of one size stay on their lattice, and their pores are balls, each with the radius of its middle.
#[test]
fn pores_are_balls_of_the_radius_of_their_middle() {
    let keys = "box = 4\nfill = { pores = 0.5, radius = 0.08, jitter = 0 }\nfill_to = { pores = 0.5, radius = 0.2, jitter = 0 }\n\
                fill_by = 'w'\nattribute.w = '0.5 + x'";
    // The structure may stand elsewhere: the middles and the radius then are what they are where it stands.
    let moved = keys.replace("jitter = 0", "jitter = 0, move = [0.1, 0, 0]");
    let turned = keys.replace("jitter = 0", "jitter = 0, rotate = [0, 0, 90], scale = 0.8");
    for (keys, edge, by) in [(keys, 0.5, 0.0), (&moved, 0.5, 0.1), (&turned, 0.4, 0.0)] {
        let field = field(keys);
        for i in 0..64 {
            let cube = DVec3::new(f64::from(i / 16), f64::from(i / 4 % 4), f64::from(i % 4)) - 2.0;
            let centre = (cube + 0.5) * edge + DVec3::X * by;
            let radius = (0.08 + 0.12 * (0.5 + centre.x).clamp(0.0, 1.0)) * edge / 0.5;
            for way in [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.48, 0.6, 0.64)] {
                for change in [-0.01, 0.0, 0.02] {
                    let value = field.reference(centre + way * (radius + change));
                    assert!((value - change).abs() < 1e-6, "{keys}\nat {centre}: {value} for {change}");
                }
            }
        }
    }
}

/// The solid share is the same where cells of one shape are small and where they are large: of pores the exact sum, for no two
/// meet; of foam less than of cubes, and more than of Kelvin's cells, which have the least walls.
#[test]
fn cells_of_all_sizes_are_as_dense() {
    let pores = 1.0 - 4.0 / 3.0 * std::f64::consts::PI * 0.4_f64.powi(3);
    let cubes = 1.0 - 0.9_f64.powi(3);
    for (from, to, range) in [
        ("foam = 0.1, wall = 0.01", "foam = 0.3, wall = 0.03", [0.886 * cubes, cubes]),
        ("pores = 0.1", "pores = 0.3", [0.98 * pores, 1.02 * pores]),
    ] {
        for side in [-1.0, 1.0] {
            let found = share(from, to, side);
            assert!(range[0] < found && found < range[1], "{from} at {side}: {found} for {range:?}");
        }
    }
}

/// How much of a half of a filled cube is solid.
fn share(from: &str, to: &str, side: f64) -> f64 {
    const COUNT: usize = 40_000;
    let half = Aabb::new(CUBE.min.with_x(side.min(0.0)), CUBE.max.with_x(side.max(0.0)));
    let field = field(&format!(
        "box = 2\nfill = {{ {from} }}\nfill_to = {{ {to} }}\nfill_by = 'w'\nattribute.w = '0.5 + 0.5*x'"
    ));
    let mut samples = Samples::new(37);
    let inside = (0..COUNT).filter(|_| field.reference(samples.within(&half)) > 0.0).count();
    inside as f64 / COUNT as f64
}

/// The ends of a lattice or a surface that goes over are it at both sizes, and between them is that of every half, where its size
/// is the wanted one.
#[test]
fn lattices_go_over_by_halves() {
    for (row, of) in [
        ("octet", "radius = R"),
        ("bcc", "radius = R"),
        ("kelvin", "radius = R"),
        ("gyroid", "thickness = R"),
        ("schwarz_p", "fraction = 0.3"),
    ] {
        let keys = |edge: f64| format!("{row} = {edge}, {}", of.replace('R', &(0.08 * edge).to_string()));
        let graded = field(&format!(
            "box = 4\nfill = {{ {} }}\nfill_to = {{ {} }}\nfill_by = 'w'\nattribute.w = '0.5 + x'",
            keys(1.6),
            keys(0.4)
        ));
        // By halves of the size at the middle of the borders: 1.6 to 0.4 along x from −0.5 to 0.5.
        let x = |size: f64| (1.0 - size) / 1.2;
        for (edge, low, high) in [(1.6, -2.0, x(1.6)), (0.8, x(0.8), x(0.73)), (0.4, x(0.4), 2.0)] {
            let plain = field(&format!("box = 4\nfill = {{ {} }}", keys(edge)));
            let mut samples = Samples::new(43);
            let region = Aabb::new(DVec3::new(low, -2.0, -2.0), DVec3::new(high, 2.0, 2.0));
            let mut inside = 0;
            for _ in 0..4000 {
                let at = samples.within(&region);
                let (found, wanted) = (graded.reference(at), plain.reference(at));
                inside += usize::from(wanted > 0.0);
                assert!(wanted <= 0.0 || (found - wanted).abs() < 1e-6, "{row} of {edge} at {at}: {found}, {wanted}");
                assert!(wanted > 0.0 || found <= 1e-6, "{row} of {edge} at {at}: {found}, {wanted}");
            }
            assert!(inside > 100, "{row}: {inside}");
        }
    }
}

/// Where two sizes meet, both are there: no cut across the solid is free of material.
#[test]
fn octaves_overlap() {
    let graded = field(
        "box = 4\nfill = { cubic = 0.8, radius = 0.08 }\nfill_to = { cubic = 0.4, radius = 0.04 }\nfill_by = 'w'\n\
         attribute.w = '0.5 + 0.5*x'",
    );
    for i in 0..200 {
        let x = -1.0 + 0.01 * f64::from(i);
        // Along the lines of both lattices.
        assert!(graded.reference(DVec3::new(x, 0.0, 0.0)) > 0.01, "{x}");
    }
    assert_bounds_hold("cubic", &graded, &CUBE, 1.0, &mut Samples::new(47));
}

/// Others are mixed by their values, as ever.
#[test]
fn structures_of_different_rows_are_mixed() {
    let by = "fill_by = 'w'\nattribute.w = '0.25 + 0*x'";
    let one = field("box = 2\nfill = { foam = 0.5, seed = 1 }");
    for to in [
        "gyroid = 0.5, thickness = 0.1",
        "foam = 0.3, move = [0.1, 0, 0], seed = 2",
        "foam = 0.3, offset = 0.01, seed = 2",
    ] {
        let other = field(&format!("box = 2\nfill = {{ {to} }}"));
        let both = field(&format!("box = 2\nfill = {{ foam = 0.5, seed = 1 }}\nfill_to = {{ {to} }}\n{by}"));
        let mut samples = Samples::new(41);
        for _ in 0..100 {
            let at = samples.within(&CUBE) * 0.7;
            let wanted = 0.75 * one.reference(at) + 0.25 * other.reference(at);
            let deep = [&one, &other].iter().all(|field| field.reference(at) < 0.2);
            assert!(!deep || (both.reference(at) - wanted).abs() < 1e-6, "{to} at {at}");
        }
    }
}

#[test]
fn what_cannot_go_over_is_an_error_with_a_way_out() {
    let by = "fill_by = 'w'\nattribute.w = '0.5 + 0.5*x'";
    for (keys, words) in [
        (
            "fill = { foam = 0.1 }\nfill_to = { foam = 0.3, wall = 0.3 }",
            "`wall` must be less than the edge of the cubes, 0.3",
        ),
        (
            "fill = { foam = 0.1, wall = 0.1 }\nfill_to = { foam = 0.3 }",
            "`wall` must be less than the edge of the cubes, 0.1",
        ),
        ("fill = { foam = 0 }\nfill_to = { foam = 0.3 }", "must be greater than 0"),
        ("fill = { foam = 0.001 }\nfill_to = { foam = 0.3 }", "differ by more than 64 times"),
        ("fill = { pores = 0.002 }\nfill_to = { pores = 0.004 }", "`pores` has too many cells to place them"),
        ("fill = { pores = 0.001 }\nfill_to = { pores = 0.001, radius = 0.0001 }", "too many cells to place them"),
        ("fill = { pores = 0.1, jitter = 0 }\nfill_to = { pores = 0.2 }", "different `jitter`s"),
        ("fill = { pores = 0.1, jitter = 0 }\nfill_to = { pores = 0.2, jitter = 0 }", "`jitter` has no meaning"),
        ("fill = { octet = 0.001 }\nfill_to = { octet = 0.3 }", "differ by more than 64 times"),
        ("fill = { octet = 0.1, radius = '0.01 + x' }\nfill_to = { octet = 0.3 }", "`radius` is a formula"),
        (
            "fill = { gyroid = 0.1, thickness = 0.01 }\nfill_to = { gyroid = 0.3, fraction = 0.2 }",
            "and the other one a `fraction`",
        ),
        ("fill = { gyroid = 0.1, thickness = 0.01 }\nfill_to = { gyroid = 0.3 }", "neither `thickness` nor `fraction`"),
    ] {
        let found = problem(&format!("box = 2\n{keys}\n{by}"));
        assert!(found.contains(words), "{keys}\n{found}");
    }
    let found =
        problem("box = 2\nfill = { foam = 0.1 }\nfill_to = { foam = 0.3 }\nfill_by = 'w'\nattribute.w = 'sqrt(x)'");
    assert!(found.contains("`w` is no number at") && found.contains("`foam`"), "{found}");
}
