//! Every row of the table of operations: every faster way against its plain value, and whatever it declares.

use glam::DVec3;

use super::Samples;
use crate::field::facts::Facts;
use crate::field::interval::Intervals;
use crate::field::kernel::{self, Run};
use crate::field::leaf::Affine;
use crate::field::op::{Binary, Op, Same, Set, Unary};
use crate::field::program::Program;
use crate::field::tape::Tape;
use crate::field::{Aabb, BATCH, Expression, Field, Gradients, Graph, Interval, Node, Points, Slope, VectorWidth};
use crate::field::{kernel_gradient, op};

/// Where arguments, the coordinates x and y, are looked at.
const WORLD: Aabb = Aabb::new(DVec3::splat(-3.0), DVec3::splat(3.0));

/// All operations on x and y, those on two values also on x twice.
fn all() -> impl Iterator<Item = Op> {
    let pairs = Binary::ALL.iter().flat_map(|&operation| [1, 0].map(|b| Op::Binary(operation, 0, b)));
    Unary::ALL.iter().map(|&operation| Op::Unary(operation, 0)).chain(pairs)
}

/// Where the arguments of an operation may lie: displacements are of squares.
fn world(op: Op) -> Aabb {
    let least = if matches!(op, Op::Binary(Binary::Displacement, ..)) { DVec3::ZERO } else { WORLD.min };
    Aabb::new(least, WORLD.max)
}

/// An operation as a program, without what building one simplifies.
fn program(op: Op) -> Program {
    let affines = [DVec3::X, DVec3::Y].map(|axis| Affine::new(axis, 0.0));
    let ops = vec![Op::Affine(0), Op::Affine(1), op];
    Program { ops, affines: affines.into(), quadrics: Vec::new(), externals: Vec::new() }
}

/// An operation of values that are not those of x and y.
fn value(op: Op, values: [f64; 2]) -> f64 {
    match op {
        Op::Unary(operation, a) => operation.value([values[a as usize]]),
        Op::Binary(operation, a, b) => operation.value([values[a as usize], values[b as usize]]),
        _ => unreachable!("operations on values only"),
    }
}

fn facts(op: Op, facts: [Facts; 2]) -> Facts {
    match op {
        Op::Unary(operation, a) => operation.facts([facts[a as usize]]),
        Op::Binary(operation, a, b) => operation.facts([facts[a as usize], facts[b as usize]]),
        _ => unreachable!("operations on values only"),
    }
}

fn same(op: Op, bounds: [Interval; 2]) -> Same {
    match op {
        Op::Unary(operation, a) => operation.same([bounds[a as usize]]),
        Op::Binary(operation, a, b) => operation.same([bounds[a as usize], bounds[b as usize]]),
        _ => unreachable!("operations on values only"),
    }
}

fn answers(program: &Program, points: &Points, width: VectorWidth) -> ([f32; BATCH], Gradients) {
    let mut tape = Tape::default();
    tape.compile(&program.ops, &[2]);
    tape.settle(program, points.origin);
    let run = Run { tape: &tape, points, inputs: &[] };
    let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
    kernel::run(width, &run, &mut Vec::new(), &mut [&mut values]);
    kernel_gradient::run(width, &run, &mut Vec::new(), &mut [&mut gradients]);
    (values, gradients)
}

/// The reference's gradient by differences; none where two steps do not agree, as at a crease.
fn slope(program: &Program, p: DVec3) -> Option<DVec3> {
    let at = |step: f64| {
        let along = |axis| (program.reference(p + axis * step) - program.reference(p - axis * step)) / (2.0 * step);
        DVec3::from(DVec3::AXES.map(along))
    };
    let (fine, coarse) = (at(1e-6), at(1e-5));
    ((fine - coarse).length() < 1e-4 * (1.0 + fine.length())).then_some(fine)
}

#[test]
fn lanes_are_the_reference_at_each_vector_width_and_gradients_its_differences() {
    let mut samples = Samples::new(3);
    for op in all() {
        let many = samples.batch(&world(op), 300);
        let few = Points { len: 5, ..many.clone() };
        let program = program(op);
        let (values, gradients) = answers(&program, &many, VectorWidth::Sse2);
        let mut smooth = 0;
        for i in 0..many.len {
            let p = many.position(i);
            let wanted = program.reference(p);
            if wanted.is_nan() {
                continue;
            }
            for value in [values[i], gradients.value[i]] {
                assert!((f64::from(value) - wanted).abs() < 1e-6 * (1.0 + wanted.abs()), "{op:?}: {value} at {p}");
            }
            if let Some(slope) = slope(&program, p) {
                let ours = gradients.gradient(i).as_dvec3();
                assert!((ours - slope).length() < 1e-3 * (1.0 + slope.length()), "{op:?}: {ours}, {slope} at {p}");
                smooth += 1;
            }
        }
        assert!(smooth > many.len / 4, "{op:?}: looked at {smooth} gradients");
        for width in VectorWidth::ALL {
            for points in [&many, &few] {
                let (other, duals) = answers(&program, points, width);
                let pairs = [
                    (&other, &values),
                    (&duals.value, &gradients.value),
                    (&duals.dx, &gradients.dx),
                    (&duals.dy, &gradients.dy),
                    (&duals.dz, &gradients.dz),
                ];
                for (one, other) in pairs {
                    let bits =
                        |lanes: &[f32; BATCH]| lanes[..points.len].iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                    assert!(bits(one) == bits(other), "{op:?} with {width:?} of {} points", points.len);
                }
            }
        }
    }
}

/// Boxes of all sizes, some with faces at whole numbers and some flat.
fn region(samples: &mut Samples, world: Aabb, round: u32) -> Aabb {
    let size = 3.0 * 0.5_f64.powf(10.0 * samples.next());
    let min = samples.within(&Aabb::new(world.min, world.max - size));
    match round % 4 {
        0 => Aabb::new(min.round(), min.round() + 1.0),
        1 => Aabb::new(min.with_x(min.x.round()), (min + size).with_x(min.x.round())),
        _ => Aabb::new(min, min + size),
    }
}

#[test]
fn bounds_contain_samples_and_what_pruning_is_told_holds() {
    let mut samples = Samples::new(5);
    for op in all() {
        let (program, nature) = (program(op), op.nature());
        let mut bounds = Intervals::default();
        for round in 0..2000 {
            let region = region(&mut samples, world(op), round);
            program.bound(&program.ops, &region, true, &mut [], &mut bounds);
            let (bound, arguments) = (bounds.at(2), [bounds.at(0), bounds.at(1)]);
            let same = same(op, arguments);
            let flat = region.size().min_element() == 0.0;
            assert!(
                nature.shortens || flat || same == Same::Itself && bound != Interval::ZERO,
                "{op:?} over {region:?}"
            );
            for _ in 0..10 {
                let p = samples.within(&region);
                let value = program.reference(p);
                // Zero over what may be zero is taken for zero.
                let undefined = bound == Interval::ALL || value.is_nan() && arguments.contains(&Interval::ZERO);
                assert!(bound.contains(value) || undefined, "{op:?}: {value} in {bound:?} at {p}");
                let of = match op {
                    Op::Binary(_, _, 0) | Op::Unary(..) => [p.x, p.x],
                    _ => [p.x, p.y],
                };
                match same {
                    Same::Itself => {}
                    Same::Argument(at) => assert_eq!(value, of[at], "{op:?} over {region:?}"),
                    Same::Negated(at) => assert_eq!(value, -of[at], "{op:?} over {region:?}"),
                }
                let sides = if let Op::Unary(..) = op { [p.x, -p.x] } else { of };
                assert!(!nature.creases || sides.contains(&value), "{op:?} at {p}");
                match nature.set {
                    None => {}
                    Some(Set::Union) => assert_eq!(value > 0.0, of[0] > 0.0 || of[1] > 0.0, "{op:?} at {p}"),
                    Some(Set::Intersection) => assert_eq!(value < 0.0, of[0] < 0.0 || of[1] < 0.0, "{op:?} at {p}"),
                }
            }
        }
    }
}

#[test]
fn declared_slopes_boxes_and_falls_hold() {
    let balls = [(DVec3::new(-0.4, 0.0, 0.3), 0.9), (DVec3::new(0.5, 0.2, 0.0), 0.7)];
    let around = balls.map(|(centre, radius)| Facts::distance(Some(Aabb::new(centre, centre).grown(radius))));
    let of_balls = |p: DVec3| balls.map(|(centre, radius)| radius - p.distance(centre));
    let of_planes = |p: DVec3| [p.x, p.y];
    let of_planes: (_, &dyn Fn(DVec3) -> [f64; 2]) = ([DVec3::X, DVec3::Y].map(Facts::affine), &of_planes);
    let mut samples = Samples::new(9);
    for (op, (of, arguments)) in all().flat_map(|op| [(op, (around, &of_balls as _)), (op, of_planes)]) {
        let Facts { bounds, slope, fall } = facts(op, of);
        let steepest = match slope {
            Slope::Exact { .. } => 1.0,
            Slope::Lipschitz(bound) => bound,
            Slope::Unknown => f64::INFINITY,
        };
        for _ in 0..2000 {
            let p = samples.within(&WORLD);
            let q = p + (samples.within(&WORLD) - p) * samples.next().powi(4);
            let (first, second) = (value(op, arguments(p)), value(op, arguments(q)));
            let most = steepest * p.distance(q) + 1e-12;
            assert!(
                steepest == f64::INFINITY || (first - second).abs() <= most,
                "{op:?}: {first}, {second} at {p}, {q}"
            );
            if let Some(bounds) = bounds {
                let away = p.distance(p.clamp(bounds.min, bounds.max));
                assert!(away == 0.0 || first < 0.0 && first <= 1e-12 - fall * away, "{op:?}: {first} at {p}");
            }
        }
        // A power has none.
        let power = matches!(op, Op::Binary(Binary::RmUnion { .. } | Binary::RmIntersection { .. }, ..));
        assert!(op.nature().set.is_none() || power != steepest.is_finite(), "{op:?} declares {slope:?}");
    }
}

#[test]
fn what_jumps_says_so() {
    let mut samples = Samples::new(13);
    for op in all() {
        let jumps = |p: DVec3, q: DVec3| {
            let [first, second] = [p, q].map(|p| value(op, [p.x, p.y]));
            (first - second).abs() > 0.1 * (1.0 + first.abs())
        };
        let step = DVec3::splat(1e-9);
        if !op.nature().jumps {
            let met = (0..2000).map(|_| samples.within(&WORLD)).find(|&p| jumps(p, p + step));
            assert!(met.is_none(), "{op:?} jumps at {met:?}");
        } else if !matches!(op, Op::Binary(_, _, 0)) {
            // The cut of angles is at y = 0 for x < 0, which comes second.
            let at_whole = |i: i32| DVec3::new(f64::from(i % 3), f64::from(i / 3 - 1), 0.0);
            // Equality of x and y ends where one of them changes.
            let met = |p: DVec3| jumps(p - step, p + step) || jumps(p, p - DVec3::X * step);
            assert!((0..9).map(at_whole).any(met), "{op:?} does not jump");
        }
    }
}

#[test]
fn building_keeps_values_and_keys_are_unlike() {
    let mut keys: Vec<_> = all().map(Op::key).collect();
    let count = keys.len();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), count);

    type Build = fn(&mut Graph) -> Node;
    let arguments: [Build; 8] = [
        |graph| graph.x(),
        |graph| graph.constant(2.0),
        |graph| graph.constant(-0.75),
        |graph| graph.constant(0.5),
        |graph| {
            let x = graph.x();
            graph.abs(x)
        },
        |graph| {
            let y = graph.y();
            graph.square(y)
        },
        |graph| {
            let (x, y) = (graph.x(), graph.y());
            graph.max(x, y)
        },
        |graph| {
            let y = graph.y();
            let power = graph.unary(Unary::Exp, y);
            graph.linear(power, -2.0, 1.0)
        },
    ];
    let mut samples = Samples::new(17);
    for op in all() {
        for (first, second) in arguments.iter().flat_map(|first| arguments.iter().map(move |second| (first, second))) {
            let mut graph = Graph::new();
            let nodes = [first(&mut graph), second(&mut graph)];
            let built = match op {
                Op::Unary(operation, a) => graph.unary(operation, nodes[a as usize]),
                Op::Binary(operation, a, b) => graph.binary(operation, nodes[a as usize], nodes[b as usize]),
                _ => unreachable!("operations on values only"),
            };
            let built = Expression::new(&graph, built);
            let of = nodes.map(|node| Expression::new(&graph, node));
            for _ in 0..5 {
                let p = samples.within(&WORLD);
                let (wanted, value) = (value(op, of.each_ref().map(|of| of.reference(p))), built.reference(p));
                // What is not a number as an operation may be one as another: x² / x² at a power of a half.
                assert!(wanted.is_nan() || (value - wanted).abs() <= 1e-9 * (1.0 + wanted.abs()), "{op:?}: {value}");
            }
        }
    }
}

#[test]
fn functions_of_formulas_have_names_of_their_own() {
    let mut names: Vec<_> = crate::field::functions().map(|(name, usage, _)| (name, usage)).collect();
    assert!(op::functions().count() > 0 && names.is_sorted());
    assert!(names.iter().all(|(name, usage)| usage.starts_with(&format!("{name}("))));
    names.dedup_by_key(|(name, _)| *name);
    assert_eq!(names.len(), crate::field::functions().count());
}
