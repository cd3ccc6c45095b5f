//! Traps that other libraries fell into, and nodes against answers that are known by other means.

use glam::DVec3;

use super::row_tests::solids;
use crate::field::tests::Samples;
use crate::field::{Aabb, Expression, Field};

const WORLD: Aabb = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));

/// F of the first shape of a scene.
pub(super) fn field(text: &str) -> Expression {
    let (mut solids, id) = solids(text);
    solids.values(id).unwrap_or_else(|problem| panic!("{problem:?}\n{text}"))
}

fn shape(keys: &str) -> String {
    format!("[output]\nshape = 's'\n[shape.s]\n{keys}\n")
}

/// Whether the sides of a field are those of a distance that is known, but for a skin around its surface.
#[track_caller]
fn same_sides(text: &str, skin: f64, wanted: impl Fn(DVec3) -> f64) {
    let (field, mut samples) = (field(text), Samples::new(4));
    let mut inside = 0;
    for _ in 0..4000 {
        let p = samples.within(&WORLD);
        let (found, wanted) = (field.reference(p), wanted(p));
        inside += usize::from(wanted > 0.0);
        assert!(wanted.abs() < skin || (found > 0.0) == (wanted > 0.0), "at {p}: {found}, not {wanted}\n{text}");
    }
    assert!(inside > 8, "{inside} inside\n{text}");
}

#[track_caller]
fn same_values(text: &str, wanted: impl Fn(DVec3) -> f64) {
    let (field, mut samples) = (field(text), Samples::new(4));
    for _ in 0..2000 {
        let p = samples.within(&WORLD);
        let (found, wanted) = (field.reference(p), wanted(p));
        assert!((found - wanted).abs() < 1e-9, "at {p}: {found}, not {wanted}\n{text}");
    }
}

/// Two half-spaces that meet at a right angle: below z, and behind x.
fn corner(node: &str) -> String {
    shape(&format!("{node}\n[shape.a]\nhalf_space = [1, 0, 0]\n[shape.b]\nhalf_space = [0, 0, 1]"))
}

#[test]
fn a_smooth_union_grows_and_only_exponentials_forget_the_order() {
    let three = |kernel: &str, order: &str| {
        field(&shape(&format!(
            "smooth_union = [{order}]\nblend_radius = 0.6\nkernel = '{kernel}'\n[shape.a]\nsphere = 0.6\n[shape.b]\nbox = 1\nmove = [0.5, 0.2, 0]\n[shape.c]\nsphere = 0.5\nmove = [0, 0.4, 0.5]"
        )))
    };
    let plain = field(&shape(
        "union = ['a', 'b', 'c']\nsystem = 'minmax'\n[shape.a]\nsphere = 0.6\n[shape.b]\nbox = 1\nmove = [0.5, 0.2, 0]\n[shape.c]\nsphere = 0.5\nmove = [0, 0.4, 0.5]",
    ));
    let mut samples = Samples::new(2);
    for kernel in ["quadratic", "cubic", "circular", "exponential"] {
        let (one, other) = (three(kernel, "'a', 'b', 'c'"), three(kernel, "'c', 'a', 'b'"));
        let mut apart = 0.0_f64;
        for _ in 0..1000 {
            let p = samples.within(&WORLD);
            let (first, second, least) = (one.reference(p), other.reference(p), plain.reference(p));
            assert!(first >= least - 1e-12, "{kernel} at {p}: {first}, and without {least}");
            assert!(first <= least + 0.6, "{kernel} at {p}");
            apart = apart.max((first - second).abs());
        }
        assert_eq!(apart < 1e-9, kernel == "exponential", "{kernel}: {apart}");
    }
}

#[test]
fn joins_of_planes_are_what_their_names_say() {
    let (a, b) = (|p: DVec3| -p.x, |p: DVec3| -p.z);
    let union = |p: DVec3| a(p).max(b(p));
    // A fillet is a quarter of a circle that touches both planes.
    same_sides(&corner("round_union = ['a', 'b']\nblend_radius = 0.5"), 1e-9, |p| {
        let filled = p.x > 0.0 && p.z > 0.0 && p.x < 0.5 && p.z < 0.5;
        if filled { (p.x - 0.5).hypot(p.z - 0.5) - 0.5 } else { union(p) }
    });
    same_sides(&corner("round_difference = ['a', 'b']\nblend_radius = 0.5"), 1e-9, |p| {
        // Inside of x < 0, above z = 0.
        let (x, z) = (-p.x, p.z);
        if x < 0.5 && z < 0.5 && x > 0.0 && z > 0.0 { 0.5 - (x - 0.5).hypot(z - 0.5) } else { x.min(z) }
    });
    same_sides(&corner("chamfer_union = ['a', 'b']\nblend_radius = 0.5"), 1e-9, |p| {
        if p.x > 0.0 && p.z > 0.0 { 0.5 - p.x - p.z } else { union(p) }
    });
    same_sides(&corner("stairs_union = ['a', 'b']\nblend_radius = 0.6\nsteps = 3"), 1e-9, |p| {
        let is_step = (p.x < 0.2 && p.z < 0.4) || (p.x < 0.4 && p.z < 0.2);
        if is_step && p.x > 0.0 && p.z > 0.0 { 1.0 } else { union(p) }
    });
    same_values(&corner("seam_pipe = ['a', 'b']\npipe_radius = 0.3"), |p| 0.3 - p.x.hypot(p.z));
    same_sides(&corner("groove = ['a', 'b']\ngroove_depth = 0.3\ngroove_width = 0.2"), 1e-9, |p| {
        (-p.x).min((-p.x - 0.3).max(p.z.abs() - 0.1))
    });
    same_sides(&corner("tongue = ['a', 'b']\ntongue_height = 0.3\ntongue_width = 0.2"), 1e-9, |p| {
        (-p.x).max((0.3 - p.x).min(0.1 - p.z.abs()))
    });
    same_sides(&corner("engrave = ['a', 'b']\nengrave_depth = 0.3"), 1e-9, |p| (-p.x).min(-p.x + p.z.abs() - 0.3));
    same_sides(&corner("clearance = ['a', 'b']\ngap = 0.3"), 1e-9, |p| (-p.x).min(p.z - 0.3));
    same_sides(
        &corner("symmetric_difference = ['a', 'b']"),
        1e-9,
        |p| if (p.x < 0.0) != (p.z < 0.0) { 1.0 } else { -1.0 },
    );
}

#[test]
fn systems_differ_away_from_the_surface_alone() {
    let parts = "[shape.a]\nsphere = 0.8\n[shape.b]\nbox = 1\nmove = [0.6, 0, 0]";
    for node in ["union", "intersection", "difference", "symmetric_difference"] {
        let of = |system: &str| field(&shape(&format!("{node} = ['a', 'b']\nsystem = {system}\n{parts}")));
        let sharp = of("'minmax'");
        for system in ["'r0'", "'cn'", "'rm'", "'rm'\norder = 8"] {
            let (smooth, mut samples) = (of(system), Samples::new(6));
            let mut differ = 0;
            for _ in 0..500 {
                let p = samples.within(&WORLD);
                let (first, second) = (smooth.reference(p), sharp.reference(p));
                assert_eq!(first > 0.0, second > 0.0, "{node} by {system} at {p}");
                differ += usize::from((first - second).abs() > 1e-6);
            }
            // `cn` is the lesser or greater one where the operands' signs differ.
            assert!(differ > 10, "{node} by {system}: {differ}");
        }
    }
}

/// Of rounding by a maximum only one side is right, and mitred boxes differ as soon as they are moved.
#[test]
fn edges_are_rounded_by_balls() {
    let rounded = |p: DVec3, half: DVec3, radius: f64| {
        let q = p.abs() - (half - radius);
        radius - q.max(DVec3::ZERO).length() - q.max_element().min(0.0)
    };
    let half = DVec3::new(0.5, 0.7, 0.4);
    same_sides(&shape("box = [1, 1.4, 0.8]\nround = 0.2"), 5e-3, |p| rounded(p, half, 0.2));
    same_sides(&shape("box = [1, 1.4, 0.8]\noffset = 0.2"), 1e-9, |p| rounded(p, half + 0.2, 0.2));
    // The inner edge of a cross of two walls: a quarter of a circle that touches both.
    let cross = "union = ['a', 'b']\nfillet = 0.3\n[shape.a]\nbox = [0.4, 3, 3]\n[shape.b]\nbox = [3, 3, 0.4]";
    same_sides(&shape(cross), 2e-2, |p| {
        let (x, z) = (p.x.abs() - 0.2, p.z.abs() - 0.2);
        let in_box = p.abs().max_element() - 1.5;
        let ends = (p.y.abs() - 1.5).max(x.min(z).max(in_box)).max(if x > 1.0 || z > 1.0 { in_box } else { -1.0 });
        if x > 0.0 && z > 0.0 && x < 0.3 && z < 0.3 && p.y.abs() < 1.2 {
            (x - 0.3).hypot(z - 0.3) - 0.3
        } else if p.y.abs() > 1.2 && x < 0.3 && z < 0.3 {
            0.0
        } else {
            -ends
        }
    });
}

#[test]
fn walls_of_a_ball() {
    let ball = |p: DVec3| 1.0 - p.length();
    same_values(&shape("sphere = 1\nshell = 0.2\nwall = 'inner'"), |p| ball(p).min(0.2 - ball(p)));
    same_values(&shape("sphere = 1\nshell = 0.2\nwall = 'outer'"), |p| (-ball(p)).min(0.2 + ball(p)));
    same_values(&shape("sphere = 1\nshell = 0.2"), |p| 0.1 - ball(p).abs());
    same_sides(&shape("sphere = 1\nonion = 3\nlayer = 0.1\nlayer_gap = 0.15"), 1e-9, |p| {
        let depth = ball(p);
        if (0.0..=0.6).contains(&depth) { 0.1 - depth % 0.25 } else { -1.0 }
    });
    same_values(&shape("formula = '1/(0.1 + x^2 + y^2 + z^2)'\nisovalue = 1"), |p| {
        1.0 / (0.1 + p.length_squared()) - 1.0
    });
}

#[test]
fn bent_space_against_what_it_makes() {
    // A ball pulled apart is a capsule, whose distance is exact.
    same_values(&shape("sphere = 0.5\nelongate = [0, 0, 1.2]"), |p| {
        0.5 - (p - DVec3::Z * p.z.clamp(-0.6, 0.6)).length()
    });
    // A bar around a cylinder is a piece of a tube.
    same_sides(&shape("box = [2, 0.6, 0.4]\nwrap_cylinder = 0.8"), 1e-9, |p| {
        let angle = p.y.atan2(p.x);
        (0.2 - (p.x.hypot(p.y) - 0.8).abs()).min(0.3 - p.z.abs()).min(1.0 - 0.8 * angle.abs())
    });
    same_sides(&shape("box = [1.6, 1.2, 0.4]\nwrap_sphere = 1"), 1e-9, |p| {
        let (east, north) = (p.y.atan2(p.x), (p.z / p.length()).asin());
        (0.2 - (p.length() - 1.0).abs()).min(0.8 - east.abs()).min(0.6 - north.abs())
    });
    // Bent by a quarter about the y axis, one above the origin.
    same_sides(
        &shape(&format!("box = [{}, 0.6, 0.4]\nbend = {}", std::f64::consts::FRAC_PI_2, 1_f64.to_degrees())),
        1e-9,
        |p| {
            let (far, angle) = (p.x.hypot(1.0 - p.z), p.x.atan2(1.0 - p.z));
            (0.2 - (far - 1.0).abs()).min(0.3 - p.y.abs()).min(std::f64::consts::FRAC_PI_4 - angle.abs())
        },
    );
    same_sides(&shape("box = [2, 2, 2]\ntaper = 0.5\ntaper_from = -1\ntaper_to = 1"), 1e-9, |p| {
        let wide = 0.75 - 0.25 * p.z;
        (wide - p.x.abs()).min(wide - p.y.abs()).min(1.0 - p.z.abs())
    });
    same_sides(&shape("box = 1\nshear = [0, 0.5, 0]"), 1e-9, |p| {
        (0.5 - (p.x - 0.5 * p.z).abs()).min(0.5 - p.y.abs()).min(0.5 - p.z.abs())
    });
    same_values(&shape("sphere = 0.5\nmirror = [1, 1, 0]\nmirror_offset = 0.3"), |p| {
        let n = DVec3::new(1.0, 1.0, 0.0).normalize();
        let height = n.dot(p) - 0.3;
        0.5 - (p + n * (height.abs() - height)).length()
    });
    same_sides(&shape("cylinder = 0.3\nheight = 2\nlook_at = [1, 0, 0]"), 1e-9, |p| {
        (0.3 - p.y.hypot(p.z)).min(1.0 - p.x.abs())
    });
    same_sides(&shape("cylinder = 0.3\nheight = 2\nquaternion = [0, 0.70710678, 0, 0.70710678]"), 1e-6, |p| {
        (0.3 - p.y.hypot(p.z)).min(1.0 - p.x.abs())
    });
}

/// A finite repetition is the union of all copies, whole at its ends and right where copies reach into one another's cells.
#[test]
fn copies_are_the_union_of_what_is_copied() {
    let half = DVec3::new(0.45, 0.1, 0.2);
    let slant = |p: DVec3| {
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        let q = DVec3::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x, p.z).abs() - half;
        -(q.max(DVec3::ZERO).length() + q.max_element().min(0.0))
    };
    let text = "union = ['b']\narray = [4, 3, 1]\nspacing = [0.5, 0.35, 1]\n[shape.b]\nbox = [0.9, 0.2, 0.4]\nrotate = [0, 0, 30]";
    same_values(&shape(text), |p| {
        let mut all = f64::NEG_INFINITY;
        for x in [-0.75, -0.25, 0.25, 0.75] {
            for y in [-0.35, 0.0, 0.35] {
                all = all.max(slant(p - DVec3::new(x, y, 0.0)));
            }
        }
        all
    });
    same_values(&shape("sphere = 0.3\npolar = 5\npolar_radius = 1"), |p| {
        let at = |i: usize| {
            let angle = i as f64 * std::f64::consts::TAU / 5.0;
            0.3 - (p - DVec3::new(angle.cos(), angle.sin(), 0.0)).length()
        };
        (0..5).map(at).fold(f64::NEG_INFINITY, f64::max)
    });
    // Seven in a honeycomb.
    same_values(&shape("sphere = 0.3\nhexagonal = 1\npitch = 0.7"), |p| {
        let ring = |i: usize| {
            let angle = i as f64 * std::f64::consts::FRAC_PI_3;
            0.3 - (p - 0.7 * DVec3::new(angle.cos(), angle.sin(), 0.0)).length()
        };
        (0..6).map(ring).fold(0.3 - p.length(), f64::max)
    });
    same_values(&shape("sphere = 0.2\nalong = [[-1, 0, 0], [1, 0, 0]]\ncount = 3"), |p| {
        [-1.0, 0.0, 1.0].into_iter().map(|x| 0.2 - (p - DVec3::X * x).length()).fold(f64::NEG_INFINITY, f64::max)
    });
}

/// Copies on a ball lie on it, apart from one another, about as many in each octant, and always in the same places.
#[test]
fn scattered_copies_lie_where_they_should() {
    let text = shape("sphere = 0.01\nscatter = 400\nhost = 'h'\napart = 0.05\nseed = 3\n[shape.h]\nsphere = 1");
    let places = |text: &str| {
        let (mut solids, id) = solids(text);
        let bend = solids.bend(id, 1).unwrap().expect("copies");
        (0..400).filter_map(|copy| bend.forth(DVec3::ZERO, copy)).collect::<Vec<_>>()
    };
    let found = places(&text);
    assert_eq!(found, places(&text));
    assert_eq!(found.len(), 400);
    assert!(found.iter().all(|at| (at.length() - 1.0).abs() < 1e-4));
    for (i, a) in found.iter().enumerate() {
        assert!(found[..i].iter().all(|b| a.distance(*b) >= 0.05), "{a} is too near");
    }
    for octant in 0..8 {
        let is_in = |at: &&DVec3| (0..3).all(|axis| (at[axis] > 0.0) == (octant >> axis & 1 == 1));
        let count = found.iter().filter(is_in).count();
        assert!((25..80).contains(&count), "{count} in octant {octant}");
    }
    let inside = places(&shape(
        "sphere = 0.01\nscatter = 400\nhost = 'h'\nover = 'inside'\ndensity = 'step(0, x)'\n[shape.h]\nsphere = 1",
    ));
    assert!(inside.len() == 400 && inside.iter().all(|at| at.length() < 1.0 && at.x >= 0.0));
}

/// A number over space is the same written as a function and as a source, and moves a surface as it colours it.
#[test]
fn noise_is_one_number_however_it_is_written() {
    use crate::field::{BATCH, Points};
    use crate::node::attributes::TheScalar;
    use crate::node::id::{ShapeId, Stage};
    let sampled = |attribute: &str, at: DVec3| {
        let text = shape(&format!("sphere = 1\nattribute.n = {attribute}"));
        let (mut solids, _) = solids(&text);
        let paint = solids.paint(TheScalar("n"), ShapeId(0), Stage::Own, 0.02).unwrap().expect("it has one");
        let mut points = Points::new(at);
        points.push(glam::Vec3::ZERO);
        let mut out = [[0.0; 1]; BATCH];
        paint.attribute.sampler().sample(&points, &mut out);
        out[0][0]
    };
    let at = DVec3::new(0.31, -0.52, 0.77);
    for (source, formula) in [
        ("{ noise = 0.5, seed = 3 }", "noise(2*x, 2*y, 2*z, 3)"),
        ("{ gradient_noise = 0.5, seed = 3 }", "gradient_noise(2*x, 2*y, 2*z, 3)"),
        ("{ simplex = 0.5, seed = 0 }", "simplex(2*x, 2*y, 2*z)"),
        ("{ fbm = 0.5, octaves = 3, seed = 1 }", "fbm(2*x, 2*y, 2*z, 3, 1)"),
        ("{ ridged = 0.5, octaves = 3, seed = 1 }", "ridged(2*x, 2*y, 2*z, 3, 1)"),
        ("{ turbulence = 0.5, seed = 1 }", "turbulence(2*x, 2*y, 2*z, 4, 1)"),
        ("{ worley = 0.5, seed = 1 }", "worley_f1(2*x, 2*y, 2*z, 1)"),
        ("{ worley = 0.5, distance = 'second', seed = 1 }", "worley_f2(2*x, 2*y, 2*z, 1)"),
        ("{ worley = 0.5, distance = 'edge', seed = 1 }", "worley_edge(2*x, 2*y, 2*z, 1)"),
        ("{ radius = 2, from = 'axis' }", "length(x, y)/2"),
        ("{ angle = 'x' }", "angle(y, z)"),
        ("{ waves = 0.25, direction = [0, 0, 2], between = [1, 3] }", "1 + 2*wave(4*z)"),
        ("{ stripes = 0.2, numbers = [5, 6, 7] }", "5 + mod(floor(x/0.2 + 0.5), 3)"),
        ("{ ramp = [[0, 1], [1, 3]], by = '-y' }", "1 - 2*y"),
    ] {
        let (one, other) = (sampled(source, at), sampled(&format!("'{formula}'"), at));
        assert!((one - other).abs() < 1e-6, "{source}: {one}, {formula}: {other}");
    }
    // The seed of a place is none.
    assert!(sampled("'noise(x, y, z, x)'", at).is_nan());
}

#[test]
fn noise_moves_surfaces_within_its_bounds() {
    let text =
        shape("sphere = 1\nattribute.n = { fbm = 0.4, octaves = 3, between = [0, 0.2], seed = 2 }\ndisplace = 'n'");
    let bumpy = field(&text);
    let mut samples = Samples::new(3);
    let mut between = 0;
    for _ in 0..2000 {
        let p = samples.within(&WORLD);
        let value = bumpy.reference(p);
        assert!(p.length() > 1.0 || value > -1e-6, "{p} is inside: {value}");
        assert!(p.length() < 1.2 || value < 1e-6, "{p} is outside: {value}");
        between += usize::from(p.length() > 1.0 && value > 0.0);
    }
    assert!(between > 5);
}
