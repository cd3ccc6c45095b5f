//! What must hold of every row of the tables, so that a new one is tested by being there.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use rayon::prelude::*;

use super::assets::Assets;
use super::id::{ShapeId, Stage};
use super::list::{COLOURS, MAKERS, MODIFIERS, PLACERS, SCALARS};
use super::solid::Solids;
use super::source::Source;
use super::{Source as From, keys, load, node_names, node_scene};
use crate::attribute::Attribute;
use crate::field::tests::{Samples, bits_by_width, slope_at};
use crate::field::{Aabb, BATCH, Evaluator, Expression, Field, Gradients, Graph, Node, Points, SetSystem, Slope};
use crate::node::attributes::{TheColour, TheScalar};
use crate::text::Overrides;
use crate::text::key::Key;

/// Steps of differences: greater than the rounding of scalars, which `displace` goes by.
const STEPS: [f64; 2] = [1e-5, 2e-4];
const WORLD: Aabb = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));

pub(super) fn solids(text: &str) -> (Solids, ShapeId) {
    let scene = From::Text {
        name: if text.starts_with('{') { "row.json" } else { "row.toml" }.into(),
        text: text.into(),
        folder: concat!(env!("CARGO_MANIFEST_DIR"), "/scenes").into(),
    };
    let model = Arc::new(load(&scene, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}\n{text}")));
    let all: Vec<ShapeId> = (0..model.shapes.len()).map(ShapeId).collect();
    let assets = Assets::load(&model, &all, None).unwrap_or_else(|problem| panic!("{problem:?}\n{text}"));
    let solids = Solids::new(&model, &Arc::new(assets), model.moment(1.0), 64.0, &Arc::new(AtomicBool::new(false)));
    (solids, ShapeId(0))
}

fn built(name: &str) -> Expression {
    let text = node_scene(name).unwrap();
    let (mut solids, id) = solids(&text);
    solids.values(id).unwrap_or_else(|problem| panic!("{problem:?}\n{text}"))
}

#[test]
fn every_vector_width_gives_the_reference() {
    for name in node_names() {
        let (field, mut samples) = (built(name), Samples::new(7));
        let points = samples.batch(&WORLD, 200);
        let answers = bits_by_width(&field, &points);
        assert!(answers.iter().all(|answer| *answer == answers[0]), "{name}: widths differ");
        for i in 0..points.len {
            let (value, exact) = (f64::from(f32::from_bits(answers[0][0][i])), field.reference(points.position(i)));
            assert!(
                (value - exact).abs() < 2e-5 * (1.0 + exact.abs()),
                "{name} at {}: {value}, {exact}",
                points.position(i)
            );
        }
    }
}

/// Bounds over boxes of all sizes down to a 64th of `largest`, within `aabb`, hold what lies in them.
pub(super) fn assert_bounds_hold(name: &str, field: &dyn Field, aabb: &Aabb, largest: f64, samples: &mut Samples) {
    let mut evaluator = field.evaluator();
    for _ in 0..60 {
        let size = largest * 0.5_f64.powf(6.0 * samples.next());
        let min = samples.within(&Aabb::new(aabb.min, aabb.max - size));
        let region = Aabb::new(min, min + size);
        evaluator.enter(&region);
        let bounds = evaluator.bounds();
        evaluator.leave();
        for _ in 0..50 {
            let at = samples.within(&region);
            let value = field.reference(at);
            assert!(bounds.contains(value), "{name} at {at}: {value} not in {bounds:?}");
        }
    }
}

#[test]
fn every_nodes_bounds_hold_all_samples() {
    for name in node_names() {
        assert_bounds_hold(name, &built(name), &WORLD, 2.0, &mut Samples::new(11));
    }
}

#[test]
fn every_nodes_gradient_is_that_of_differences() {
    for name in node_names() {
        let (field, mut samples) = (built(name), Samples::new(13));
        let points = samples.batch(&WORLD, 200);
        let mut gradients = Gradients::new();
        field.evaluator().gradients(&points, &mut gradients);
        let mut compared = 0;
        for i in 0..points.len {
            let p = points.position(i);
            if let Some(fine) = slope_at(&field, p, STEPS) {
                let found = gradients.gradient(i).as_dvec3();
                assert!((found - fine).length() < 2e-3 * (1.0 + fine.length()), "{name} at {p}: {found}, {fine}");
                compared += 1;
            }
        }
        assert!(compared > 20, "{name} is nowhere smooth");
    }
}

#[test]
fn what_every_node_declares_holds() {
    for name in node_names() {
        let (field, mut samples) = (built(name), Samples::new(17));
        let bounds = field.bounding_box();
        let mut inside = 0;
        for _ in 0..4000 {
            let (p, q) = (samples.within(&WORLD), samples.within(&WORLD));
            let q = p + (q - p) * samples.next().powi(4);
            let (first, second) = (field.reference(p), field.reference(q));
            inside += usize::from(first > 0.0);
            let bound = match field.slope() {
                Slope::Exact { .. } => 1.0,
                Slope::Lipschitz(bound) => bound,
                Slope::Unknown => f64::INFINITY,
            };
            let way = bound * p.distance(q) * (1.0 + 1e-6) + 1e-6;
            assert!(bound.is_infinite() || (first - second).abs() <= way, "{name} is steeper than {bound} at {p}");
            assert!(first < 0.0 || bounds.is_none_or(|bounds| bounds.contains(p)), "{name}: {p} is inside, {bounds:?}");
        }
        assert!(inside > 10, "only {inside} samples are inside the example of {name}");
    }
}

/// Where a node says that its value is the distance, that is the distance of the nearest point, of which nothing is asked but
/// on which side points are.
#[test]
fn every_exact_distance_is_that_of_the_nearest_point() {
    let names: Vec<&str> = node_names().collect();
    let failures: Vec<String> =
        names.into_par_iter().flat_map_iter(|name| wrong_distances(name, &built(name))).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A distance is found that is too short, too long, or right on one side only.
#[test]
fn wrong_distances_are_found() {
    let wrong = |build: &dyn Fn(&mut Graph) -> Node| {
        let mut graph = Graph::new();
        let node = build(&mut graph);
        let slope = Slope::Exact { outside: true, inside: true };
        let node = graph.sloped(node, slope, Some(Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0))));
        wrong_distances("it", &Expression::new(&graph, node)).len()
    };
    assert_eq!(wrong(&|graph| graph.sphere(0.8)), 0);
    assert!(wrong(&|graph| graph.ellipsoid(DVec3::new(1.0, 0.99, 1.0))) >= MOST_TOLD);
    // A mitred box is right inside, and at its faces.
    let mitred = |graph: &mut Graph| {
        let slabs = DVec3::AXES.map(|axis| graph.slab(axis, 1.6));
        graph.intersection(SetSystem::MinMax, &slabs)
    };
    assert!(wrong(&mitred) >= MOST_TOLD);
    let union = |graph: &mut Graph| {
        let ball = graph.sphere(0.6);
        let other = graph.translate(ball, DVec3::X * 0.3).unwrap();
        graph.union(SetSystem::MinMax, &[ball, other])
    };
    assert!(wrong(&union) >= MOST_TOLD);
    for scale in [1.0 + 1e-4, 1.0 - 1e-4] {
        let scaled = |graph: &mut Graph| {
            let ball = graph.sphere(0.8);
            graph.linear(ball, scale, 0.0)
        };
        assert!(wrong(&scaled) >= MOST_TOLD, "{scale}");
    }
}

/// So many wrong distances of one shape are told.
const MOST_TOLD: usize = 5;

/// The search is asked for so many: of a wrong distance these are all wrong.
const MOST_SEARCHED: usize = 20;

/// Points where the value is not the distance though the field says so, of 10 000 at random and at the surface.
///
/// A value is no more than the distance of any point of the surface: that is asked of points of the surface, found by
/// sides alone, and points straight before and behind them, for which it leaves nothing over. It is no less where the
/// side changes after that way, along the gradient, or beside its end; where it does not, as before a needle's tip, a search
/// has to find the nearest point.
pub(super) fn wrong_distances(name: &str, field: &Expression) -> Vec<String> {
    const COUNT: usize = 10_000;
    let Slope::Exact { outside, inside } = field.slope() else { return Vec::new() };
    let size = field.bounding_box().and_then(|own| own.intersection(WORLD)).unwrap_or(WORLD).longest_side();
    let tolerance = 1e-5 * size;
    let (mut samples, mut evaluator) = (Samples::new(23), field.evaluator());
    let evaluator = evaluator.as_mut();
    let surface = surface_points(evaluator, &mut samples);
    assert!(!surface.is_empty(), "no surface of {name} was found");
    let mut wrong = Vec::new();

    let mut points = Vec::new();
    let mut ways = Vec::new();
    for (at, (_, slope)) in surface.iter().zip(slopes(evaluator, &surface)) {
        let Some(direction) = slope.try_normalize() else { continue };
        for reach in [0.05, -0.05, 0.2, -0.2, 0.5, -0.5, 1.0, -1.0] {
            let p = exactly(*at + direction * reach * size * samples.next());
            ways.push(p.distance(*at));
            points.push(p);
        }
    }
    for ((p, way), value) in points.iter().zip(&ways).zip(values(evaluator, &points)) {
        if value.abs() > way + tolerance && wrong.len() < MOST_TOLD {
            wrong.push(format!("{name} at {p}: {value}, and the surface is {way} away or less"));
        }
    }

    points.truncate(COUNT / 2);
    points.extend((points.len()..COUNT).map(|_| exactly(samples.within(&WORLD))));
    let found = slopes(evaluator, &points);
    let ahead = |by: f64| -> Vec<DVec3> {
        let step = |(p, (value, slope)): (&DVec3, &(f64, DVec3))| {
            *p - slope.normalize_or_zero() * value.signum() * (value.abs() + by).max(0.0)
        };
        points.iter().zip(&found).map(step).collect()
    };
    let beyond = values(evaluator, &ahead(tolerance));
    let mut tested = [0; 2];
    let mut open = Vec::new();
    for (i, ((value, _), beyond)) in found.iter().zip(beyond).enumerate() {
        let side = usize::from(*value > 0.0);
        if [outside, inside][side] && value.abs() > tolerance {
            tested[side] += 1;
            open.extend(((beyond > 0.0) == (*value > 0.0)).then_some(i));
        }
    }
    // Beyond an edge sharper than a right angle the way may lead out again: some of the other side is beside its end.
    let ends = ahead(0.0);
    for count in [30, 200] {
        open.retain(|i| {
            let beside: Vec<DVec3> = directions(count).map(|way| exactly(ends[*i] + way * tolerance)).collect();
            values(evaluator, &beside).iter().all(|value| (*value > 0.0) == (found[*i].0 > 0.0))
        });
    }
    let mut search = Search { field, evaluator: field.evaluator(), samples: Samples::new(29) };
    for i in open.into_iter().take(MOST_SEARCHED) {
        let (p, (value, slope)) = (points[i], found[i]);
        let found = search.distance(p, value > 0.0, &surface, Some(-slope * value.signum()));
        if (value.abs() - found).abs() > tolerance && wrong.len() < MOST_TOLD {
            wrong.push(format!("{name} at {p}: {value}, and the surface is {found} away"));
        }
    }
    for (side, exact) in [outside, inside].into_iter().enumerate() {
        assert!(!exact || tested[side] > 300, "{name}: looked at {tested:?} points outside and inside");
    }
    wrong
}

/// Directions to all sides, evenly.
fn directions(count: i32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let (z, angle) = (1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count), 2.399963229728653 * f64::from(i));
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * libm::cos(angle), across * libm::sin(angle), z)
    })
}

/// A position as a batch holds it.
fn exactly(position: DVec3) -> DVec3 {
    position.as_vec3().as_dvec3()
}

fn batches(positions: &[DVec3]) -> impl Iterator<Item = Points> {
    positions.chunks(BATCH).map(|some| {
        let mut points = Points::new(DVec3::ZERO);
        some.iter().for_each(|position| points.push(position.as_vec3()));
        points
    })
}

fn values(evaluator: &mut dyn Evaluator, positions: &[DVec3]) -> Vec<f64> {
    let mut out = [0.0; BATCH];
    let of_batch = |points: Points| {
        evaluator.values(&points, &mut out);
        out[..points.len].iter().map(|value| f64::from(*value)).collect::<Vec<_>>()
    };
    batches(positions).flat_map(of_batch).collect()
}

fn slopes(evaluator: &mut dyn Evaluator, positions: &[DVec3]) -> Vec<(f64, DVec3)> {
    let mut out = Gradients::new();
    let of_batch = |points: Points| {
        evaluator.gradients(&points, &mut out);
        (0..points.len).map(|i| (f64::from(out.value[i]), out.gradient(i).as_dvec3())).collect::<Vec<_>>()
    };
    batches(positions).flat_map(of_batch).collect()
}

/// Points of the surface between points of both sides.
fn surface_points(evaluator: &mut dyn Evaluator, samples: &mut Samples) -> Vec<DVec3> {
    const COUNT: usize = 1250;
    let all: Vec<DVec3> = (0..6000).map(|_| exactly(samples.within(&WORLD))).collect();
    let sides = values(evaluator, &all);
    let of_side = |inside: bool| -> Vec<DVec3> {
        all.iter().zip(&sides).filter(|(_, value)| (**value > 0.0) == inside).map(|(p, _)| *p).collect()
    };
    let (inside, outside) = (of_side(true), of_side(false));
    if inside.is_empty() || outside.is_empty() {
        return Vec::new();
    }
    let mut within: Vec<DVec3> = (0..COUNT).map(|i| inside[i % inside.len()]).collect();
    let mut without: Vec<DVec3> = (0..COUNT).map(|i| outside[i % outside.len()]).collect();
    for _ in 0..25 {
        let middles: Vec<DVec3> = within.iter().zip(&without).map(|(a, b)| exactly((*a + *b) / 2.0)).collect();
        for (i, value) in values(evaluator, &middles).into_iter().enumerate() {
            *(if value > 0.0 { &mut within[i] } else { &mut without[i] }) = middles[i];
        }
    }
    without
}

/// Looks for the nearest point of the other side.
struct Search<'f> {
    field: &'f Expression,
    evaluator: Box<dyn Evaluator + 'f>,
    samples: Samples,
}

impl Search<'_> {
    fn distance(&mut self, p: DVec3, inside: bool, surface: &[DVec3], slope: Option<DVec3>) -> f64 {
        let mut near: Vec<DVec3> = surface.to_vec();
        near.sort_by(|a, b| a.distance(p).total_cmp(&b.distance(p)));
        let mut starts: Vec<(DVec3, f64)> = Vec::new();
        if let Some(direction) = slope.and_then(DVec3::try_normalize) {
            // Along the gradient, past where the surface should be; there may be none.
            let reach = self.field.reference(p).abs();
            let found = [1.0 + 1e-6, 1.001, 1.1, 2.0].map(|share| share * reach).into_iter();
            let other = |way: &f64| (self.field.reference(p + direction * *way) > 0.0) != inside;
            starts.extend(found.filter(other).take(1).map(|way| (direction, way)));
        }
        for at in near {
            let (direction, far) = ((at - p).normalize_or(DVec3::X), at.distance(p));
            let apart = |(other, _): &(DVec3, f64)| other.dot(direction) < 0.97;
            if starts.len() < 6 && starts.iter().skip(usize::from(slope.is_some())).all(apart) {
                starts.push((direction, far));
            }
        }
        starts.into_iter().map(|(direction, far)| self.refined(p, inside, direction, far)).fold(f64::INFINITY, f64::min)
    }

    /// A ball around the point shrinks as long as something of the other side lies in it, near where it touched.
    fn refined(&mut self, p: DVec3, inside: bool, mut direction: DVec3, mut far: f64) -> f64 {
        let unit = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        let mut spread = 0.4;
        far = self.crossing(p, inside, direction, far);
        let mut values = [0.0; BATCH];
        while spread > 2e-5 {
            let mut points = Points::new(p);
            let mut tried = Vec::new();
            for _ in 0..64 {
                let way = (direction + self.samples.within(&unit) * spread).normalize_or(direction);
                points.push((way * far).as_vec3());
                tried.push(way);
            }
            self.evaluator.values(&points, &mut values);
            let other = (0..tried.len()).find(|i| (values[*i] > 0.0) != inside);
            let nearer = other.map(|i| (tried[i], self.crossing(p, inside, tried[i], far)));
            match nearer {
                Some((way, nearer)) if nearer < far * (1.0 - 1e-9) => (direction, far) = (way, nearer),
                _ => spread *= 0.7,
            }
        }
        far
    }

    /// Where the side changes on the way; as far as it was where it does not.
    fn crossing(&self, p: DVec3, inside: bool, direction: DVec3, far: f64) -> f64 {
        let (mut near, mut beyond) = (0.0, far);
        for _ in 0..48 {
            let middle = (near + beyond) / 2.0;
            let same = (self.field.reference(p + direction * middle) > 0.0) == inside;
            *(if same { &mut near } else { &mut beyond }) = middle;
        }
        beyond
    }
}

#[test]
fn every_source_of_attributes_gives_numbers() {
    fn each<const N: usize>(
        sources: &'static [Source<N>],
        key: &str,
        sampled: impl Fn(&mut Solids) -> Arc<dyn Attribute<N>>,
    ) {
        // Files that have them are read in tests of their own.
        for source in sources.iter().filter(|source| !source.is_volume && source.key.name != "material") {
            let text = format!(
                "[output]\nshape = 's'\n[shape.s]\nsphere = 1\n{key} = {}\n[shape.a]\nbox = 1\n{key} = {1}\n[shape.b]\nsphere = 0.5\n{key} = {1}\n",
                source.example,
                if N == 3 { "'red'" } else { "0.5" },
            );
            let (mut solids, _) = solids(&text);
            let attribute = sampled(&mut solids);
            let mut samples = Samples::new(3);
            let points = samples.batch(&Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)), 200);
            let mut out = [[f32::NAN; N]; BATCH];
            let mut sampler = attribute.sampler();
            sampler.enter(&WORLD);
            sampler.sample(&points, &mut out);
            assert!(out[..points.len].iter().flatten().all(|number| number.is_finite()), "{}", source.key.name);
            let distinct = out[..points.len].iter().any(|value| *value != out[0]);
            assert!(distinct || matches!(source.key.name, "parts" | "conformal"), "{} is one value", source.key.name);
        }
    }
    each(COLOURS, "color", |solids| {
        solids.paint(TheColour, ShapeId(0), Stage::Own, 0.02).unwrap().expect("it has a colour").attribute
    });
    each(SCALARS, "attribute.n", |solids| {
        solids.paint(TheScalar("n"), ShapeId(0), Stage::Own, 0.02).unwrap().expect("it has a scalar").attribute
    });
}

/// One map carries field, attributes and motion: where a position comes from, and what is carried there and back.
#[test]
fn every_bend_is_one_map() {
    for spec in MODIFIERS.iter().chain(PLACERS).filter(|spec| spec.bend.is_some()) {
        let name = spec.key.name;
        let (mut solids, id) = solids(&super::example::scene(spec));
        let model = solids.model();
        let step = (1..=model.shape(id).modifiers.len()).find(|step| model.shape(id).spec_of(*step).key.name == name);
        let step = step.unwrap_or_else(|| panic!("{name} is not in its example"));
        let bend = solids.bend(id, step).unwrap().expect("it bends");
        let (inner, outer) = (solids.step_field(id, step - 1).unwrap(), solids.step_field(id, step).unwrap());
        let mut samples = Samples::new(23);
        let (mut inside, mut carried) = (0, 0);
        for _ in 0..2000 {
            let p = samples.within(&WORLD);
            let q = bend.back(p);
            // The field.
            let (there, here) = (inner.reference(q), outer.reference(p));
            inside += usize::from(here > 0.0);
            assert!((there > 0.0) == (here > 0.0) || here.abs() < 1e-9, "{name} at {p}: {here}, from {q}: {there}");
            // Back and forth.
            let branch = bend.branch(p);
            if let Some(again) = bend.forth(q, branch) {
                assert!(
                    (again - p).length() < 1e-8 * (1.0 + p.length()),
                    "{name} at {p}: back to {q}, and then {again}"
                );
            }
            // Regions.
            let size = 4.0 * 0.5_f64.powf(6.0 * samples.next());
            let region = Aabb::new(p - size * samples.next(), p + size * samples.next());
            assert!(
                bend.region(&region).grown(1e-9).contains(q),
                "{name}: {q} of {p} is not in {:?}",
                bend.region(&region)
            );
            // Vectors.
            const STEP: f64 = 1e-5;
            let way = samples.within(&WORLD);
            let moved = bend.carried(p, way);
            let along = |step: f64| bend.back(p + moved * step);
            let (fine, coarse) =
                ((along(STEP) - along(-STEP)) / (2.0 * STEP), (along(4.0 * STEP) - along(-4.0 * STEP)) / (8.0 * STEP));
            // Where several positions come from one place vectors cannot be told back.
            let column = |axis: DVec3| bend.back(p + axis * STEP) - bend.back(p - axis * STEP);
            let is_flat =
                glam::DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z)).determinant().abs()
                    < 1e-9 * STEP.powi(3);
            if (fine - coarse).length() < 1e-4 * (1.0 + fine.length()) && moved.is_finite() && !is_flat {
                assert!(
                    (fine - way).length() < 1e-3 * (1.0 + way.length()),
                    "{name} at {p}: {way} is carried to {moved}, which is {fine} there"
                );
                carried += 1;
            }
        }
        assert!(inside > 3 && carried > 500, "{name}: {inside} inside, {carried} carried");
    }
}

/// Node keys are one namespace: the same name never means two things in a shape.
#[test]
fn no_name_means_two_things() {
    let mut known: BTreeMap<&str, &Key> = BTreeMap::new();
    let mains = MAKERS.iter().chain(MODIFIERS).map(|spec| &spec.key).chain(keys::SHAPE);
    for key in mains {
        for name in [key.name].iter().chain(key.also) {
            assert!(known.insert(name, key).is_none(), "`{name}` is used twice");
        }
    }
    for spec in MAKERS.iter().chain(MODIFIERS) {
        for key in spec.parameters {
            for name in [key.name].iter().chain(key.also) {
                assert!(!known.contains_key(name), "`{name}` of `{}` is a node", spec.key.name);
            }
        }
    }
}

#[test]
fn every_row_says_what_it_is() {
    for spec in MAKERS.iter().chain(MODIFIERS) {
        assert!(!spec.key.text.is_empty() && !spec.example.is_empty(), "{}", spec.key.name);
        assert!(spec.parameters.iter().all(|key| !key.text.is_empty()), "{}", spec.key.name);
        assert!(spec.example.contains(spec.key.name), "{}", spec.key.name);
    }
}
