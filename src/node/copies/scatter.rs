//! Copies at random on a shape or in it.

use std::collections::HashMap;

use glam::{DMat3, DVec3, I64Vec3};

use crate::field::{Aabb, BATCH, CopyPlace, Expression, Field, Gradients, Graph, Points, rotation};
use crate::node::copied::{Chance, MOST_COPIES, cells_of, copies_of, facing};
use crate::node::keys::seed;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number, Required, Text};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// Tries for each copy, on average, before there is no more room. Fewer: what is thin or dense gets too few.
const TRIES: usize = 400;

/// The part of the host's size that points for its surface are taken from, on either side. Less: more tries; more: places
/// that the surface bends around get more than others.
const SHELL: f64 = 1.0 / 64.0;

/// Steps to the surface.
const STEPS: usize = 8;

/// Copies at random on a shape or in it.
pub const NODE: Spec = Spec {
    key: Key::new(
        "scatter",
        Kind::Whole,
        Nothing,
        "So many copies at random on the surface of a shape, or inside of it.",
    )
    .limit(Limit::Within(0.0, MOST_COPIES as f64)),
    parameters: &[
        Key::new("host", Kind::Shape, Required, "The shape that they are scattered on."),
        Key::new("over", Kind::Choice(&["surface", "inside"]), Text("surface"), "Where."),
        Key::new(
            "apart",
            Kind::Constant,
            Number(0.0),
            "The least distance of two copies' origins. Where no more find room there are fewer.",
        )
        .limit(Limit::NotNegative)
        .unit("units"),
        Key::new(
            "density",
            Kind::Formula,
            Nothing,
            "How likely a place is taken, from 0 to 1, in the host's space where it stands.",
        ),
        Key::new(
            "aligned",
            Kind::Choice(&["yes", "no"]),
            Text("yes"),
            "On a surface: whether a copy's z axis points outward.",
        ),
        Key::new(
            "turn_jitter",
            Kind::Constant,
            Number(180.0),
            "How far each is turned about its z axis at most, to either side.",
        )
        .limit(Limit::Within(0.0, 180.0))
        .unit("degrees"),
        Key::new("tilt_jitter", Kind::Constant, Number(0.0), "How far each is tilted at most.")
            .limit(Limit::Within(0.0, 180.0))
            .unit("degrees"),
        Key::new(
            "size_jitter",
            Kind::Constant,
            Number(0.0),
            "How much larger or smaller each is at most, as a share of its size.",
        )
        .limit(Limit::Within(0.0, 0.99)),
        seed("The number that the places start from."),
    ],
    example: "capsule = 0.05\nlength = 0.3\nscatter = 120\nhost = \"b\"\napart = 0.1",
    cells: Some(cells_of),
    bend: Some(|build| {
        let arguments = build.arguments().clone();
        let host = *arguments.shape("host").expect("it must be there");
        let count = arguments.whole("scatter").map_or(0, |count| (*count).max(0) as usize);
        let on_surface = arguments.choice("over") != Some(&"inside");
        let node = build.shape(host)?;
        let solid = build.solid_box(node)?;
        let field = Expression::new(build.graph(), node).keeping_values();
        let density = match arguments.formula("density") {
            None => None,
            Some(formula) => {
                let mut graph = Graph::new();
                let node = build.reading(formula)?.node(&mut graph);
                Some(Expression::new(&graph, node))
            }
        };
        let scattering = Scattering { field, solid, on_surface, density, apart: build.constant("apart"), count };
        let mut chance = Chance::new(*arguments.seed("seed").expect("it has a default"));
        let spots = scattering.spots(&mut chance);
        if spots.is_empty() && count > 0 {
            return Err(Problem::new(build.span(), format!("`scatter` of `{}` finds no place", build.name()))
                .help("its host may be too thin, or its `density` 0 everywhere"));
        }
        let [turn, tilt, size] = ["turn_jitter", "tilt_jitter", "size_jitter"].map(|key| build.constant(key));
        let aligned = on_surface && arguments.choice("aligned") != Some(&"no");
        let place = |(at, normal): (DVec3, DVec3)| {
            let base = if aligned { facing(normal, DVec3::Z) } else { DMat3::IDENTITY };
            let (about, towards, by) = (turn * chance.spread(), 360.0 * chance.next(), tilt * chance.next());
            let tilted = rotation(DVec3::Z * towards) * rotation(DVec3::X * by) * rotation(DVec3::Z * -towards);
            let scale = 1.0 + size * chance.spread();
            CopyPlace { at, turn: base * tilted * rotation(DVec3::Z * about), scale }
        };
        let places = spots.into_iter().map(place).collect();
        copies_of(build, places)
    }),
    ..Spec::PLAIN
};

struct Scattering {
    field: Expression,
    solid: Aabb,
    on_surface: bool,
    density: Option<Expression>,
    apart: f64,
    count: usize,
}

impl Scattering {
    /// Places and normals. Each batch of points is tried, in order, so that the same come on any machine.
    fn spots(&self, chance: &mut Chance) -> Vec<(DVec3, DVec3)> {
        let shell = SHELL * self.solid.size().max_element();
        let region = if self.on_surface { self.solid.grown(shell) } else { self.solid };
        let mut evaluator = self.field.evaluator();
        let mut found = Vec::with_capacity(self.count);
        let mut taken = Taken { apart: self.apart, cells: HashMap::new() };
        let (mut out, mut points) = (Gradients::new(), Points::new(region.centre()));
        let mut tries = 0;
        while found.len() < self.count && tries < TRIES * self.count.max(BATCH) {
            tries += BATCH;
            points.len = 0;
            for _ in 0..BATCH {
                points.push((chance.within(&region) - points.origin).as_vec3());
            }
            evaluator.gradients(&points, &mut out);
            for i in 0..points.len {
                let value = f64::from(out.value[i]);
                let spot = match self.on_surface {
                    true => self.on_surface(points.position(i), value, out.gradient(i).as_dvec3(), shell),
                    false => (value > 0.0).then_some((points.position(i), DVec3::Z)),
                };
                let Some((at, normal)) = spot else { continue };
                let likely = self.density.as_ref().map_or(1.0, |density| density.reference(at));
                if (likely >= 1.0 || chance.next() < likely) && found.len() < self.count && taken.takes(at) {
                    found.push((at, normal));
                }
            }
        }
        found
    }

    /// The surface point next to a point that is within a thin shell around the surface: the shell is as thick everywhere, so
    /// that every piece of the surface gets its share.
    fn on_surface(&self, from: DVec3, value: f64, slope: DVec3, shell: f64) -> Option<(DVec3, DVec3)> {
        // Far away by the first step already; F need not be a distance.
        let first = value / slope.length();
        if first.is_nan() || first.abs() > 4.0 * shell {
            return None;
        }
        let (mut at, mut value, mut slope) = (from, value, slope);
        for _ in 0..STEPS {
            let step = slope * (value / slope.length_squared());
            if !step.is_finite() {
                return None;
            }
            at -= step;
            if step.length() < 1e-7 * shell {
                break;
            }
            (value, slope) = self.value_and_slope(at);
        }
        let is_there = value.abs() <= 1e-3 * shell * slope.length() && at.distance(from) <= shell;
        is_there.then(|| (at, -slope.normalize_or(DVec3::NEG_Z)))
    }

    fn value_and_slope(&self, at: DVec3) -> (f64, DVec3) {
        let step = 1e-6 * self.solid.size().max_element();
        let value = |p: DVec3| self.field.reference(p);
        let along = |axis: DVec3| (value(at + axis * step) - value(at - axis * step)) / (2.0 * step);
        (value(at), DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z)))
    }
}

/// Places taken so far, by cubes of the least distance.
struct Taken {
    apart: f64,
    cells: HashMap<I64Vec3, Vec<DVec3>>,
}

impl Taken {
    fn takes(&mut self, at: DVec3) -> bool {
        if self.apart <= 0.0 {
            return true;
        }
        let cell = (at / self.apart).floor().as_i64vec3();
        let near = (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| I64Vec3::new(x, y, z))));
        let is_near = |other: &DVec3| other.distance_squared(at) < self.apart * self.apart;
        if near.into_iter().any(|by| self.cells.get(&(cell + by)).is_some_and(|others| others.iter().any(is_near))) {
            return false;
        }
        self.cells.entry(cell).or_default().push(at);
        true
    }
}
