//! What rows of one kind share: shapes of the plane by their outlines, solids of revolution, convex polyhedra.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::model::Shape;
use super::spec::{Build, Imported, Spec};
use super::table;
use crate::field::{Aabb, Field, Joined, Node, Outline, Parts, SetSystem};
use crate::mesh::{Holes, MeshDistance, hull};
use crate::text::problem::Problem;

/// What makes solids of shapes of the plane, for messages.
pub const LIFTING: &str = "`extrude`, `revolve` or `sweep`";

/// What to do with a shape of the plane where a solid is needed.
pub fn lift_it() -> String {
    format!("make it a solid with {LIFTING}")
}

/// What is wrong with a shape of the plane that is not turned about z alone.
pub fn leaves_the_plane(shape: &Shape) -> Problem {
    Problem::new(shape.span, format!("`{}`, a shape of the plane, leaves it", shape.name))
}

/// The row of `extrude`.
pub fn extrude() -> &'static Spec {
    table::maker("extrude").expect("it is in the table")
}

/// A shape of the plane by its outline: the exact distance.
pub fn flat(build: &mut dyn Build, outline: Outline) -> Node {
    build.graph().field(Joined::shared(outline))
}

/// A shape of the plane by the outline that its file gives.
pub fn flat_import(outline: Outline) -> Imported {
    /// An edge, its crossing, and their places in trees.
    const BYTES_A_PIECE: u64 = 250;
    Imported {
        place: DAffine3::IDENTITY,
        solid: outline.bounding_box().expect("an outline has one"),
        bytes: outline.count() as u64 * BYTES_A_PIECE,
        half_spaces: None,
        colours: None,
        materials: None,
        velocity: None,
        warnings: Vec::new(),
        distance: Joined::shared(outline),
    }
}

/// A solid of revolution about z by its outline over the distance from z and z: the exact distance.
pub fn revolved(build: &mut dyn Build, outline: Outline) -> Node {
    let outline = outline.around_axis();
    let [min, max] = outline.corners();
    let reach = max.x.max(-min.x);
    let graph = build.graph();
    let profile = graph.field(Joined::shared(outline));
    let (across, z) = (graph.radius_about_z(), graph.z());
    let zero = graph.constant(0.0);
    let solid = graph.warp(profile, [across, z, zero]);
    let bounds = Aabb::new(DVec3::new(-reach, -reach, min.y), DVec3::new(reach, reach, max.y));
    graph.exact(solid, bounds)
}

/// The shape of the plane that a key names, where it stands.
pub fn profile(build: &mut dyn Build, key: &str) -> Result<Node, Problem> {
    let id = *build.arguments().shape(key).expect("it must be there");
    let node = build.shape(id)?;
    if build.graph().is_flat(node) {
        return Ok(node);
    }
    let problem = format!("the shape of `{key}` leaves the plane");
    Err(build.wrong(key, problem).help("turn shapes of the plane about z alone, and twist the solid instead"))
}

/// The box of a shape of the plane.
pub fn plane_box(build: &mut dyn Build, shape: Node) -> Result<[DVec2; 2], Problem> {
    let bounds = match build.graph().known_box(shape) {
        Some(known) => known,
        None => {
            let caps = build.graph().slab(DVec3::Z, 1.0);
            let solid = build.graph().corner(shape, caps);
            build.solid_box(solid)?
        }
    };
    Ok([bounds.min.truncate(), bounds.max.truncate()])
}

/// Says where a polygon crosses itself or has no area.
pub fn check_polygon(build: &dyn Build, key: &str, corners: &[DVec2]) -> Result<(), Problem> {
    /// Every edge is compared with every other one: of more corners this takes a second.
    const MOST: usize = 5000;
    let count = corners.len();
    let edge = |i: usize| (corners[i], corners[(i + 1) % count]);
    let area: f64 = (0..count).map(|i| edge(i).0.perp_dot(edge(i).1)).sum();
    let size = corners.iter().fold(0.0_f64, |size, corner| size.max(corner.distance(corners[0])));
    let of = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    for i in 0..if count > MOST { 0 } else { count } {
        for j in i + 2..count {
            let ((a, b), (c, d)) = (edge(i), edge(j));
            let across = |a, b, c, d| of(a, b, c) * of(a, b, d) < 0.0;
            if (j + 1) % count != i && across(a, b, c, d) && across(c, d, a, b) {
                let shown = |from: DVec2, to: DVec2| format!("[{}, {}] to [{}, {}]", from.x, from.y, to.x, to.y);
                let problem = format!("two edges of `{key}` cross: {}, and {}", shown(a, b), shown(c, d));
                return Err(build
                    .wrong(key, problem)
                    .help("list the corners in the order in which the outline meets them"));
            }
        }
    }
    if area.abs() <= 1e-12 * size * size {
        return Err(build.wrong(key, format!("`{key}` has no area")).help("corners that do not lie on one line"));
    }
    Ok(())
}

/// The polygon of a key, its corners `[x, y]` or `[x, y, radius]`: those with a radius are rounded by an arc.
pub fn rounded_polygon(build: &dyn Build, key: &str) -> Result<Outline, Problem> {
    let corners = build.plane_points(key);
    check_polygon(build, key, &corners)?;
    let rows = &build.arguments().rows(key).expect("it must be there").all;
    let radii: Vec<f64> = rows.iter().map(|row| row.get(2).copied().unwrap_or(0.0)).collect();
    let count = corners.len();
    let shown = |i: usize| format!("[{}, {}, {}]", corners[i].x, corners[i].y, radii[i]);
    if let Some(i) = (0..count).find(|i| radii[*i] < 0.0) {
        return Err(build.wrong(key, format!("the radius of {} is less than 0", shown(i))).help("0 is a sharp corner"));
    }
    let is_doubled = |i: &usize| corners[*i] == corners[(i + 1) % count];
    if let Some(i) = (0..count).find(is_doubled).filter(|_| radii.iter().any(|radius| *radius > 0.0)) {
        return Err(build.wrong(key, format!("{} is there twice", shown(i))).help("leave one of them out"));
    }
    let ways = |i: usize| {
        let to = |other: usize| (corners[other] - corners[i]).normalize_or_zero();
        (to((i + count - 1) % count), to((i + 1) % count))
    };
    // How much of both edges the arc takes: the radius over the tangent of half of the angle between them.
    let taken = |i: usize| {
        let (back, on) = ways(i);
        let (cosine, sine) = (back.dot(on), back.perp_dot(on).abs());
        // Of a corner that is none nothing, of one that goes back the way it came no radius is small enough.
        if radii[i] == 0.0 { 0.0 } else { radii[i] * (1.0 + cosine).max(0.0) / sine.max(1e-12) }
    };
    for i in 0..count {
        let next = (i + 1) % count;
        let (edge, both) = (corners[i].distance(corners[next]), taken(i) + taken(next));
        if both > edge * (1.0 + 1e-9) {
            let problem = format!(
                "the arcs of {} and {} meet: they take {both:.4} of an edge of {edge:.4}",
                shown(i),
                shown(next)
            );
            return Err(build.wrong(key, problem).help("smaller radii, or corners that are farther apart"));
        }
    }
    let mut outline = Outline::new();
    for i in 0..count {
        let ((back, on), taken) = (ways(i), taken(i));
        let (from, to) = (corners[i] + back * taken, corners[i] + on * taken);
        outline.line(from);
        if from.distance(to) > 1e-12 * radii[i] {
            let inward = (back + on).normalize_or_zero();
            let centre = corners[i] + inward * taken.hypot(radii[i]);
            outline.arc(to, centre, on.perp_dot(back) > 0.0);
        }
    }
    outline.close();
    Ok(outline)
}

/// An egg over (x, y): two balls on the y axis, and an arc that touches both on the right.
pub struct Egg {
    /// The y of the centre of the thick end.
    pub thick: f64,
    /// The y of that of the tip.
    pub thin: f64,
    /// The centre of the arc.
    pub arc: DVec2,
    /// Where the arc touches the tip.
    pub touch: DVec2,
}

impl Egg {
    /// By the radius of its thick end, its height, and the radius of its tip.
    pub fn new(build: &dyn Build, [radius, height, tip]: [f64; 3]) -> Result<Self, Problem> {
        if tip >= radius {
            let problem = format!("`tip` must be less than the radius of the thick end, {radius}");
            return Err(build.wrong("tip", problem).help("a smaller tip, or a capsule"));
        }
        let (up, change) = (height - radius - tip, radius - tip);
        if up <= change {
            let problem = format!("`height` must be more than twice the radius of the thick end, {}", 2.0 * radius);
            return Err(build.wrong("height", problem).help("a greater height, or a smaller radius"));
        }
        // |(0, up) − (−aside, 0)| = radius + aside − tip: the arc around (−aside, 0) touches both.
        let aside = (up * up - change * change) / (2.0 * change);
        let thick = (radius - up - tip) / 2.0;
        let (thin, arc) = (thick + up, DVec2::new(-aside, thick));
        let touch = DVec2::Y * thin + (DVec2::Y * thin - arc).normalize() * tip;
        Ok(Self { thick, thin, arc, touch })
    }
}

/// A convex polyhedron by its corners, exact where its distance counts; an operand only needs its planes.
pub fn convex(build: &mut dyn Build, key: &str, corners: &[DVec3]) -> Result<Node, Problem> {
    let flat = |build: &dyn Build| build.wrong(key, format!("the corners of `{key}` lie in one plane"));
    let mesh = hull(corners).ok_or_else(|| flat(build).help("give it at least four that do not"))?;
    let mesh = MeshDistance::new(mesh, Holes::Refuse).map_err(|error| build.wrong(key, error.to_string()))?;
    let planes = mesh.half_spaces().filter(|_| !build.needs_distance());
    let bounds = mesh.mesh().bounding_box();
    let graph = build.graph();
    let Some(planes) = planes else { return Ok(graph.field(Arc::new(mesh) as Arc<dyn Field>)) };
    let faces: Vec<_> = planes.iter().map(|(normal, offset)| graph.half_space(*normal, *offset)).collect();
    let solid = graph.intersection(SetSystem::MinMax, &faces);
    Ok(graph.bounded(solid, bounds))
}

/// A point of the plane in polar coordinates, degrees.
pub fn polar(radius: f64, degrees: f64) -> DVec2 {
    let angle = degrees.to_radians();
    DVec2::new(libm::cos(angle), libm::sin(angle)) * radius
}

/// The corners of a regular polygon, the first on the y axis, counterclockwise.
pub fn regular(sides: i64, radius: f64) -> Vec<DVec2> {
    (0..sides).map(|i| polar(radius, 90.0 + 360.0 * i as f64 / sides as f64)).collect()
}
