//! A skeleton of points, lines or arcs with soft flesh.

use glam::DVec3;

use crate::field::{Aabb, Graph, Node};
use crate::node::kernels::{from_point, softly};
use crate::node::spec::{Build, Spec};
use crate::text::key::Absent::{Number, Of, Required, Text};
use crate::text::key::{Key, Kind, LEAST};
use crate::text::problem::Problem;

/// A skeleton of points, lines or arcs with soft flesh.
pub const NODE: Spec = Spec {
    key: Key::new(
        "convolution",
        Kind::Rows(1, &[3]),
        Required,
        "Soft flesh around a skeleton, without bulges where its pieces meet: straight lines from each point to the next, or what \
         `skeleton` says.",
    )
    .unit("units"),
    parameters: &[
        Key::new(
            "skeleton",
            Kind::Choice(&["lines", "arcs", "points"]),
            Text("lines"),
            "`arcs`: of circles, each from a point over the next one to the one after that. `points`: the points alone.",
        ),
        Key::length("radius", Number(0.25), "The radius around a long straight line, or around a point alone."),
        Key::length(
            "kernel_width",
            Of("radius", 1.0),
            "How far a piece's effect reaches: wider, and corners become rounder.",
        ),
    ],
    formula: "Σ ∫ (1 + |p − q|²/w²)⁻² dq over the pieces, minus that of an endless line (of one point) at the radius, scaled",
    source: "McCormack and Sherstyuk, Creating and rendering convolution surfaces, 1998: the Cauchy kernel",
    example: "convolution = [[-0.9, 0, -0.8], [-0.6, 0, 0.6], [0.4, 0.6, 0.6], [0.8, -0.5, -0.2]]",
    build: |build| {
        let points = build.points("convolution");
        let (radius, width) = (build.number("radius")?, build.number("kernel_width")?);
        let skeleton = *build.arguments().choice("skeleton").unwrap_or(&"lines");
        check(build, &points, skeleton)?;
        let spread = 1.0 / width;
        let arcs = if skeleton == "arcs" { arcs(build, &points)? } else { Vec::new() };
        let graph = build.graph();
        let (parts, length): (Vec<Node>, f64) = match skeleton {
            "points" => (points.iter().map(|at| point(graph, *at, width)).collect(), points.len() as f64),
            "arcs" => (
                arcs.iter().map(|piece| piece.node(graph, spread)).collect(),
                arcs.iter().map(|arc| arc.length()).sum(),
            ),
            _ => {
                let lines = points.array_windows().map(|[a, b]| line(graph, *a, *b, spread)).collect();
                (lines, points.array_windows().map(|[a, b]| a.distance(*b)).sum())
            }
        };
        // Its own at the radius, and how steep that is, by which the value is a distance there: of a point 1/P⁴, of an endless
        // line π/(2s·P³).
        let solid = 1.0 + (spread * radius) * (spread * radius);
        let (threshold, power) = match skeleton {
            "points" => (1.0 / (solid * solid), 4.0),
            _ => (std::f64::consts::FRAC_PI_2 * width / (solid * solid.sqrt()), 3.0),
        };
        let steepness = power * threshold * spread * spread * radius / solid;
        // If all of it were as near as the nearest of it.
        let far = ((length / threshold).sqrt() - 1.0).max(0.0).sqrt() * width;
        let ends = points.iter().map(|p| Aabb::new(*p, *p)).chain(arcs.iter().map(Arc::bounding_box));
        let bounds = ends.reduce(Aabb::union).expect("there is one").grown(far);
        Ok(softly(graph, &parts, threshold, 1.0 / steepness, bounds))
    },
    ..Spec::PLAIN
};

/// More pieces than this take long at every point.
const MOST: usize = 200;

fn check(build: &dyn Build, points: &[DVec3], skeleton: &str) -> Result<(), Problem> {
    let wrong = |problem: String, help: &str| Err(build.wrong("convolution", problem).help(help));
    if points.len() > MOST {
        return wrong(format!("`convolution` takes at most {MOST} points"), "`polyline` takes any number");
    }
    if skeleton == "lines" && points.len() < 2 {
        return wrong("a line needs two points".into(), "one more, or `skeleton = \"points\"`");
    }
    if skeleton == "arcs" && (points.len() < 3 || points.len().is_multiple_of(2)) {
        let problem = format!("arcs need 3 points, or 5, 7, … for more than one, and these are {}", points.len());
        return wrong(problem, "each goes from a point over the next one to the one after that");
    }
    if points.array_windows().any(|[a, b]| a.distance(*b) < LEAST) {
        return wrong("two points that follow one another are the same".into(), "leave one of them out");
    }
    Ok(())
}

/// A piece of a circle.
struct Arc {
    centre: DVec3,
    /// From the centre to its beginning, and across that in the circle's plane, both of length 1.
    axes: [DVec3; 2],
    radius: f64,
    /// How far it goes round, radians.
    angle: f64,
}

/// The arcs through each three points.
fn arcs(build: &dyn Build, points: &[DVec3]) -> Result<Vec<Arc>, Problem> {
    let triples = (0..points.len() / 2).map(|i| [points[2 * i], points[2 * i + 1], points[2 * i + 2]]);
    triples
        .map(|[a, over, b]| {
            Arc::through(a, over, b).ok_or_else(|| {
                let shown = |p: DVec3| format!("[{}, {}, {}]", p.x, p.y, p.z);
                let problem = format!("{}, {} and {} lie on one line", shown(a), shown(over), shown(b));
                build
                    .wrong("convolution", problem)
                    .help("an arc bends: move the middle point aside, or take `skeleton = \"lines\"`")
            })
        })
        .collect()
}

impl Arc {
    /// `None` where the points lie on a line, as far as that can be told.
    fn through(a: DVec3, over: DVec3, b: DVec3) -> Option<Self> {
        let (u, v) = (over - a, b - a);
        let normal = u.cross(v);
        if normal.length() <= 1e-6 * u.length() * v.length() {
            return None;
        }
        let across = normal.cross(u) * v.length_squared() + v.cross(normal) * u.length_squared();
        let centre = a + across / (2.0 * normal.length_squared());
        let radius = centre.distance(a);
        let first = (a - centre) / radius;
        let second = normal.normalize().cross(first);
        let turn = |p: DVec3| {
            let angle = libm::atan2((p - centre).dot(second), (p - centre).dot(first));
            if angle <= 0.0 { angle + std::f64::consts::TAU } else { angle }
        };
        Some(Self { centre, axes: [first, second], radius, angle: turn(b) })
    }

    fn length(&self) -> f64 {
        self.radius * self.angle
    }

    /// Of the whole circle.
    fn bounding_box(&self) -> Aabb {
        let normal = self.axes[0].cross(self.axes[1]);
        let reach = (DVec3::ONE - normal * normal).max(DVec3::ZERO).map(f64::sqrt) * self.radius;
        Aabb::new(self.centre - reach, self.centre + reach)
    }

    /// The integral of the kernel along it. With A = 1 + s²(|p|² + ρ²) and (B·cos ψ, B·sin ψ) from the place of p in the plane
    /// of the circle, ρ·∫ dψ/(A − B·cos ψ)² = ρ/C²·(B·sin ψ/(A − B·cos ψ) + A/C·(ψ + 2·atan2(B·sin ψ, A + C − B·cos ψ))),
    /// C² = A² − B², between the ends: the angle in the last term has no jump.
    fn node(&self, graph: &mut Graph, spread: f64) -> Node {
        let (square, [first, second]) = (spread * spread, self.axes);
        let form = |graph: &mut Graph, way: DVec3| graph.affine(way, -way.dot(self.centre));
        let normal = first.cross(second);
        let coordinates = [first, second, normal].map(|axis| form(graph, axis * spread));
        let [x, y, height] = coordinates.map(|coordinate| graph.square(coordinate));
        let in_plane = graph.add(x, y);
        let from_centre = graph.add(in_plane, height);
        let a = graph.linear(from_centre, 1.0, 1.0 + square * self.radius * self.radius);
        // C² without cancellation: h² + 2h(r² + ρ²) + (r² − ρ²)², h = 1 + z², r the distance from the axis, all times s.
        let rim = square * self.radius * self.radius;
        let h = graph.linear(height, 1.0, 1.0);
        let [sum, difference] = [rim, -rim].map(|rim| graph.linear(in_plane, 1.0, rim));
        let (h_square, difference) = (graph.square(h), graph.square(difference));
        let mixed = graph.mul(h, sum);
        let mixed = graph.linear(mixed, 2.0, 0.0);
        let c_square = graph.add(h_square, mixed);
        let c_square = graph.add(c_square, difference);
        let c = graph.sqrt(c_square);
        let both = graph.add(a, c);
        let ends = [(0.0, -1.0), (self.angle, 1.0)].map(|(angle, sign)| {
            let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
            let scale = 2.0 * square * self.radius;
            // ψ is the angle from p's own direction to that of the end.
            let along = form(graph, (first * cosine + second * sine) * scale);
            let beside = form(graph, (first * sine - second * cosine) * scale);
            let below = graph.sub(a, along);
            let fraction = graph.div(beside, below);
            let rest = graph.sub(both, along);
            let turn = graph.atan2(beside, rest);
            (graph.linear(fraction, sign, 0.0), graph.linear(turn, 2.0 * sign, 0.0))
        });
        let fraction = graph.add(ends[0].0, ends[1].0);
        let turn = graph.add(ends[0].1, ends[1].1);
        let turn = graph.linear(turn, 1.0, self.angle);
        let share = graph.div(a, c);
        let turn = graph.mul(share, turn);
        let sum = graph.add(fraction, turn);
        let sum = graph.linear(sum, self.radius, 0.0);
        graph.div(sum, c_square)
    }
}

/// The kernel around a point.
fn point(graph: &mut Graph, at: DVec3, width: f64) -> Node {
    let square = from_point(graph, at, width);
    let square = graph.linear(square, 1.0, 1.0);
    let (one, fourth) = (graph.constant(1.0), graph.square(square));
    graph.div(one, fourth)
}

/// The integral of the kernel along a line: with u from one end's side to the other's,
/// ∫ du/(P² + s²u²)² = u/(2P²(P² + s²u²)) + atan(su/P)/(2sP³), P² = 1 + s²·(distance from the line)².
fn line(graph: &mut Graph, a: DVec3, b: DVec3, spread: f64) -> Node {
    let along = (b - a).normalize();
    let (e, f) = along.any_orthonormal_pair();
    let across = [e, f].map(|axis| {
        let form = graph.affine(axis * spread, -axis.dot(a) * spread);
        graph.square(form)
    });
    let square = graph.add(across[0], across[1]);
    let square = graph.linear(square, 1.0, 1.0);
    let root = graph.sqrt(square);
    let cube = graph.mul(square, root);
    let ends = [(along, along.dot(a)), (-along, -along.dot(b))].map(|(axis, from)| {
        let way = graph.affine(axis * spread, -from * spread);
        let far = graph.square(way);
        let sum = graph.add(square, far);
        let below = graph.mul(square, sum);
        let fraction = graph.div(way, below);
        let angle = graph.atan2(way, root);
        let angle = graph.div(angle, cube);
        graph.add(fraction, angle)
    });
    let both = graph.add(ends[0], ends[1]);
    graph.linear(both, 0.5 / spread, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Expression, Field};

    /// By the rule of midpoints, of many.
    fn summed(at: impl Fn(f64) -> DVec3, length: f64, spread: f64, p: DVec3) -> f64 {
        const STEPS: usize = 20_000;
        let kernel = |q: DVec3| (1.0 + spread * spread * p.distance_squared(q)).powi(-2);
        (0..STEPS).map(|i| kernel(at((i as f64 + 0.5) / STEPS as f64))).sum::<f64>() * length / STEPS as f64
    }

    #[test]
    fn integrals_are_those_of_a_sum() {
        let spread = 2.5;
        let places = [(0.3, 0.2, 0.1), (-1.2, 0.4, 0.6), (0.9, -0.8, -0.2), (0.1, 0.0, 0.0), (2.0, 1.0, -3.0)];
        let over = [(0.4, 0.9, 0.1), (-0.7, -0.2, 0.3), (1.2, 0.05, 0.0)].map(DVec3::from);
        let (a, b) = (DVec3::new(-0.8, 0.1, -0.2), DVec3::new(0.7, -0.1, 0.3));
        for p in places.map(DVec3::from) {
            for over in over {
                let arc = Arc::through(a, over, b).expect("it bends");
                let turned = |share: f64| {
                    let (sine, cosine) = (share * arc.angle).sin_cos();
                    arc.centre + (arc.axes[0] * cosine + arc.axes[1] * sine) * arc.radius
                };
                assert!(turned(0.0).distance(a) < 1e-12 && turned(1.0).distance(b) < 1e-12);
                assert!((0..=1000).any(|i| turned(f64::from(i) / 1000.0).distance(over) < 0.01), "over {over}");
                let mut graph = Graph::new();
                let node = arc.node(&mut graph, spread);
                let found = Expression::new(&graph, node).reference(p);
                let wanted = summed(turned, arc.length(), spread, p);
                assert!((found / wanted - 1.0).abs() < 1e-7, "{found}, {wanted} at {p} over {over}");
            }
            let mut graph = Graph::new();
            let node = line(&mut graph, a, b, spread);
            let found = Expression::new(&graph, node).reference(p);
            let wanted = summed(|share| a.lerp(b, share), a.distance(b), spread, p);
            assert!((found / wanted - 1.0).abs() < 1e-7, "{found}, {wanted} at {p}");
        }
    }

    /// A single point is a ball of the radius.
    #[test]
    fn a_point_alone_is_a_ball() {
        let mut graph = Graph::new();
        let node = point(&mut graph, DVec3::new(0.5, 0.0, 0.0), 0.4);
        let field = Expression::new(&graph, node);
        let wanted = (1.0_f64 + (0.3_f64 / 0.4).powi(2)).powi(-2);
        assert!((field.reference(DVec3::new(0.5, 0.3, 0.0)) - wanted).abs() < 1e-14);
    }
}
