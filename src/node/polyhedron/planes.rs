//! What lies behind all of several planes.

use glam::DVec3;

use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, LEAST};

/// What lies behind all of several planes.
pub const NODE: Spec = Spec {
    key: Key::new(
        "planes",
        Kind::Rows(4, &[4]),
        Required,
        "Convex polyhedron, what lies behind all of several planes: of each the direction that points out of it, of any length but 0, and how far along it the plane lies from the origin.",
    ),
    formula: "the signed distance to it",
    example: "planes = [[0, 0, -1, 0.5], [1, 0, 0.6, 0.6], [-1, 0, 0.6, 0.6], [0, 1, 0.6, 0.6], [0, -1, 0.6, 0.6], [0, 0, 1, 0.6]]",
    build: |build| {
        let rows = build.arguments().rows("planes").expect("it must be there").all.clone();
        let mut planes = Vec::with_capacity(rows.len());
        for row in rows {
            let normal = DVec3::new(row[0], row[1], row[2]);
            if normal.length() < LEAST {
                return Err(build
                    .wrong("planes", "a plane's direction needs a length other than 0")
                    .help("the first three numbers of a row point out of the plane"));
            }
            planes.push((normal.normalize(), row[3]));
        }
        if planes.len() > MOST {
            let problem = format!("`planes` takes at most {MOST}");
            return Err(build.wrong("planes", problem).help("`intersection` of several shapes of `planes`"));
        }
        let corners = corners(&planes).map_err(|problem| {
            build.wrong("planes", problem).help("planes all around: each row is [x, y, z, how far from the origin]")
        })?;
        convex(build, "planes", &corners)
    },
    ..Spec::PLAIN
};

/// Each three of them may meet in a corner: more take seconds.
const MOST: usize = 100;

/// The corners of what lies behind all planes.
fn corners(planes: &[(DVec3, f64)]) -> Result<Vec<DVec3>, &'static str> {
    let size = planes.iter().fold(0.0_f64, |size, (_, offset)| size.max(offset.abs())).max(LEAST);
    // A box so far away that a corner on it tells of a solid without end.
    let far = 1e6 * size;
    let walls = DVec3::AXES.into_iter().flat_map(|axis| [(axis, far), (-axis, far)]);
    let all: Vec<(DVec3, f64)> = planes.iter().copied().chain(walls).collect();
    let mut corners = Vec::new();
    for (i, (a, d)) in all.iter().enumerate() {
        for (j, (b, e)) in all.iter().enumerate().skip(i + 1) {
            let along = a.cross(*b);
            if along.length() < 1e-9 {
                continue;
            }
            for (c, f) in &all[j + 1..] {
                let volume = along.dot(*c);
                if volume.abs() < 1e-9 {
                    continue;
                }
                let corner = (b.cross(*c) * *d + c.cross(*a) * *e + along * *f) / volume;
                if all.iter().all(|(normal, offset)| normal.dot(corner) <= offset + 1e-9 * (size + corner.length())) {
                    if corner.abs().max_element() > 0.5 * far {
                        return Err("nothing ends what lies behind all of `planes`");
                    }
                    corners.push(corner);
                }
            }
        }
    }
    if corners.len() < 4 { Err("nothing lies behind all of `planes`") } else { Ok(corners) }
}
