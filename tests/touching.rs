//! All pairs of primitives, cut by and from one another, with a face or a point in common.
//!
//! The judge knows F in double precision alone: at a closest point both sides of the surface are found close by, and
//! nearer to the voxel there is nothing of the other side.

use std::sync::atomic::AtomicBool;

use glam::{DAffine3, DVec3, IVec3};
use hfvdb::distance::band::{Error, Feet, MeasuredBlock, Settings, measure};
use hfvdb::field::{Aabb, Expression, Field, Formula, Graph, Names, Node, SetSystem};
use hfvdb::grid::{BLOCK_VOXELS, Lattice, VoxelSize, is_active};
use rayon::prelude::*;

const VOXEL: f64 = 1.0 / 13.0;
/// How far a closest point may be off, in voxels.
const TOLERANCE: f64 = 0.05;

type Primitive = fn(&mut Graph) -> Node;

/// Primitives about the origin whose tops are at z = 1/2.
const PRIMITIVES: [(&str, Primitive); 8] = [
    ("sphere", |graph| graph.sphere(0.5)),
    ("box", |graph| graph.cuboid(DVec3::new(1.2, 0.8, 1.0))),
    ("cylinder", |graph| graph.cylinder(0.45, 1.0)),
    ("capsule", |graph| graph.capsule(0.3, 0.4)),
    ("ellipsoid", |graph| graph.ellipsoid(DVec3::new(0.7, 0.4, 0.5))),
    ("torus", |graph| {
        // A plane touches it along a circle.
        let ring = graph.torus(0.5, 0.15);
        graph.transform(ring, &DAffine3::from_translation(DVec3::Z * 0.35)).unwrap()
    }),
    ("half-space", |graph| graph.half_space(DVec3::Z, 0.5)),
    ("slab", |graph| graph.slab(DVec3::Z, 1.0)),
];

/// Directions to look in.
fn directions() -> impl Iterator<Item = DVec3> {
    (0..27)
        .filter(|&i| i != 13)
        .map(|i| DVec3::new(f64::from(i / 9 - 1), f64::from(i / 3 % 3 - 1), f64::from(i % 3 - 1)))
}

/// Whether F is of the other sign somewhere within so many voxels of a point.
fn other_side(field: &Expression, at: DVec3, normal: DVec3, inside: bool) -> bool {
    let is_other = |p: DVec3| {
        let value = field.reference(p);
        if inside { value < -1e-12 } else { value > 1e-12 }
    };
    let reach = TOLERANCE * VOXEL;
    let sign = if inside { -1.0 } else { 1.0 };
    let mut ways = directions().chain((0..40).map(random));
    let close = |way: DVec3, share: f64| at + way.normalize() * (share * reach);
    if ways.any(|way| [1.0, 0.4, 0.1].iter().any(|&share| is_other(close(way, share)))) {
        return true;
    }
    // A thin sheet: climbs to where F is greatest, in random steps, ever shorter ones.
    let (mut best, mut value) = (at, sign * field.reference(at));
    for i in 0..4000 {
        if i % 100 == 0 {
            (best, value) = (at, sign * field.reference(at));
        }
        let step = random(i) * (0.5 * reach * 0.5_f64.powf((i % 100) as f64 / 6.0));
        let next = best + if i % 3 == 0 { normal * step.x } else { step };
        let found = sign * field.reference(next);
        if found > value && next.distance(at) < reach {
            (best, value) = (next, found);
        }
        if is_other(best) {
            return true;
        }
    }
    false
}

/// What is wrong with a band, if anything; counts what it looks at.
fn fault(field: &Expression, voxel_size: f64, offset: usize) -> Result<usize, String> {
    let lattice = Lattice { voxel_size: VoxelSize::new(voxel_size).unwrap() };
    let cancel = AtomicBool::new(false);
    let region = Aabb::new(DVec3::splat(-0.9), DVec3::splat(0.9)).grown(4.0 * voxel_size);
    let settings =
        Settings { lattice, half_width: 3.0, region, feet: Feet::Nearest, cancel: &cancel, progress: &|_| {} };
    let measured = match measure(field, &settings, || |block: &MeasuredBlock| *block.normals) {
        Ok(measured) => measured,
        Err(Error::Empty { solid: false }) => {
            let inside = (0..20_000).map(random).find(|p| field.reference(*p) > 1e-4 * VOXEL);
            return inside.map_or(Ok(0), |p| Err(format!("empty, but inside at {p}")));
        }
        Err(error) => return Err(error.to_string()),
    };
    let band = &measured.band;
    let background = 3.0 * voxel_size;
    let mut looked = 0;
    for ((origin, distances), (active, normals)) in
        band.origins.iter().zip(&band.distances).zip(band.active.iter().zip(&measured.visits))
    {
        for i in (0..BLOCK_VOXELS).filter(|i| (i * 7 + offset).is_multiple_of(11)) {
            let place = IVec3::new(i as i32 >> 6, i as i32 >> 3 & 7, i as i32 & 7);
            let p = lattice.centre(*origin + place);
            let (distance, value) = (f64::from(distances[i]), field.reference(p));
            let (size, inside) = (distance.abs(), distance >= 0.0);
            looked += 1;
            let at = |what: &str| Err(format!("{what} at {p}: {:.4} voxels, F = {value:.3e}", distance / voxel_size));
            if size > TOLERANCE * voxel_size && (value > 1e-6) != inside && value.abs() > 1e-6 {
                return at("wrong sign");
            }
            let tolerance = TOLERANCE * voxel_size;
            let near = (size - tolerance).max(0.0);
            let is_other = |p: DVec3| {
                let value = field.reference(p);
                // A sheet thinner than the resolution is none.
                let least = 2e-4 * voxel_size;
                if inside { value < -least } else { value > least }
            };
            let mut ways = directions().chain((0..20).map(|k| random(i + 31 * k)));
            if near > 0.0
                && ways.any(|way| [1.0, 0.7].iter().any(|share| is_other(p + way.normalize() * (share * near))))
            {
                return at("something is nearer");
            }
            if is_active(active, i) && size < background {
                let normal = DVec3::new(normals[0][i].into(), normals[1][i].into(), normals[2][i].into());
                if !other_side(field, p - normal * distance, normal, inside) {
                    return at("no surface at the closest point");
                }
            }
        }
    }
    Ok(looked)
}

/// A place of the region, by number.
fn random(i: usize) -> DVec3 {
    let mix = |k: u64| {
        let mut v = (i as u64 * 3 + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        v = (v ^ v >> 31).wrapping_mul(0xd6e8_feb8_6659_fd93);
        ((v ^ v >> 32) >> 11) as f64 / (1u64 << 53) as f64
    };
    (DVec3::new(mix(0), mix(1), mix(2)) - 0.5) * 1.8
}

/// Both operations of two primitives, the second smaller and in one of three places.
fn pair(first: usize, second: usize, place: usize, difference: bool, shift: DVec3) -> Expression {
    let mut graph = Graph::new();
    let a = PRIMITIVES[first].1(&mut graph);
    let b = PRIMITIVES[second].1(&mut graph);
    let map = match place {
        // Its top flush with the first's, from within.
        0 => DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), glam::DQuat::IDENTITY, DVec3::Z * 0.25),
        // Its turned top against the first's, from without.
        1 => DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.5),
            glam::DQuat::from_rotation_x(std::f64::consts::PI),
            DVec3::Z * 0.75,
        ),
        // As large: two faces, or all, in common.
        _ => DAffine3::IDENTITY,
    };
    let map = DAffine3::from_translation(shift) * map;
    let a = graph.transform(a, &DAffine3::from_translation(shift)).unwrap();
    let b = graph.transform(b, &map).unwrap();
    let node =
        if difference { graph.difference(SetSystem::R0, a, &[b]) } else { graph.intersection(SetSystem::R0, &[a, b]) };
    let frame = graph.cuboid(DVec3::splat(1.7));
    let node = graph.intersection(SetSystem::R0, &[node, frame]);
    Expression::new(&graph, node)
}

#[test]
fn operands_that_share_faces_leave_no_skins() {
    let half = VOXEL / 2.0;
    // Along z: faces on voxels, between them, and in between. Along x and y off the primitives' planes of symmetry, where a
    // voxel as near to two sides may take the lesser of two ways.
    let shifts = [
        DVec3::new(0.0, 0.02, 0.0),
        DVec3::new(0.0, 0.02, -0.5),
        DVec3::new(half, 0.02, half - 0.5),
        DVec3::new(half, half - 0.02, 0.3 * VOXEL - 0.5),
        DVec3::new(0.0, half - 0.02, 1e-7),
        DVec3::new(0.1, -0.03, 0.77 * VOXEL),
        DVec3::new(VOXEL / 3.0, 0.013, 1.0 / 3.0),
        DVec3::new(0.01, 0.02, 0.1 + 0.2 - 0.5),
    ];
    let count = PRIMITIVES.len();
    // A third of all: each pair in some places, each place with some pairs.
    let cases: Vec<_> = (0..count * count * 3 * 2 * shifts.len()).step_by(3).collect();

    let found: Vec<_> = cases
        .into_par_iter()
        .map(|case| {
            let (pair_number, rest) = (case % (count * count), case / (count * count));
            let (place, difference, shift) = (rest % 3, rest / 3 % 2 == 0, rest / 6);
            let field = pair(pair_number / count, pair_number % count, place, difference, shifts[shift]);
            let name = |i: usize| PRIMITIVES[i].0;
            let (a, b) = (name(pair_number / count), name(pair_number % count));
            fault(&field, VOXEL, case).map_err(|fault| {
                format!("{a} {} {b}, {place}, {shift}: {fault}", if difference { "less" } else { "and" })
            })
        })
        .collect();
    let faults: Vec<&String> = found.iter().filter_map(|found| found.as_ref().err()).collect();
    for fault in faults.iter().take(40) {
        eprintln!("{fault}");
    }
    assert!(faults.is_empty(), "{} of {} cases", faults.len(), found.len());
    let looked: usize = found.iter().filter_map(|found| found.as_ref().ok()).sum();
    assert!(looked > 50_000, "{looked}");
}

/// Formulas that jump on planes of voxels: distances along x, from the jumps alone.
#[test]
fn jumps_on_planes_of_voxels_are_surfaces_there() {
    let voxel_size = 0.1;
    // Each with the places where its sign changes, between -1.7 and 1.7, and whether it is inside before the first.
    let cases: [(&str, &[f64], bool); 6] = [
        ("mod(x, 1) - 0.5", &[-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5], false),
        ("0.5 - mod(x, 1)", &[-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5], true),
        ("floor(x)", &[0.0], false),
        ("-floor(x) - 0.5", &[0.0], true),
        ("sign(x - 0.3)", &[0.3], false),
        ("step(0.2, x) - 0.5", &[0.2], false),
    ];
    for (text, jumps, inside_first) in cases {
        for offset in [0.0, 0.03, 0.05] {
            let mut graph = Graph::new();
            let names = Names::space(&mut graph);
            let node = Formula::parse(text).compile(&mut graph, &names).unwrap();
            let node = graph.transform(node, &DAffine3::from_translation(DVec3::X * offset)).unwrap();
            let frame = graph.cuboid(DVec3::new(8.0, 3.0, 3.0));
            let node = graph.intersection(SetSystem::R0, &[node, frame]);
            let lattice = Lattice { voxel_size: VoxelSize::new(voxel_size).unwrap() };
            let cancel = AtomicBool::new(false);
            let region = Aabb::new(DVec3::splat(-1.7), DVec3::splat(1.7));
            let settings =
                Settings { lattice, half_width: 3.0, region, feet: Feet::Nearest, cancel: &cancel, progress: &|_| {} };
            let band = measure(&Expression::new(&graph, node), &settings, || |_: &MeasuredBlock| ()).unwrap().band;
            let mut looked = 0;
            for (origin, distances) in band.origins.iter().zip(&band.distances) {
                for i in 0..BLOCK_VOXELS {
                    let place = IVec3::new(i as i32 >> 6, i as i32 >> 3 & 7, i as i32 & 7);
                    let p = lattice.centre(*origin + place);
                    if p.x.abs() > 1.2 || p.y.abs() > 0.9 || p.z.abs() > 0.9 {
                        continue;
                    }
                    let x = p.x - offset;
                    let nearest = jumps.iter().map(|jump| (x - jump).abs()).fold(3.0 * voxel_size, f64::min);
                    let inside = (jumps.iter().filter(|jump| **jump < x).count() % 2 == 0) == inside_first;
                    let truth = if inside { nearest } else { -nearest };
                    let found = f64::from(distances[i]);
                    let wrong = (found - truth).abs().min(if nearest < 1e-6 { (found + truth).abs() } else { 1.0 });
                    assert!(wrong < 0.02 * voxel_size, "{text} + {offset} at {p}: {found} for {truth}");
                    looked += 1;
                }
            }
            assert!(looked > 1000, "{text}: {looked}");
        }
    }
}
