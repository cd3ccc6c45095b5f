//! How far heat has to spread.

use glam::DVec3;

use crate::attribute::{Diffusion, DiffusionError, Spreading};
use crate::node::extent::box_of;
use crate::node::painted::Paint;
use crate::node::source::{Source, Sourcing};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// Diffusion distance.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "diffusion",
        Kind::Rows(1, &[3]),
        Required,
        "How far heat has to spread from these places in the shape, `[[x, y, z], …]` in its own space: 0 there, about 1 at the \
         farthest place of the boundary, the least of several. Smoother than `interior`, which is in units and exact; as fine as some \
         two thousand triangles of the boundary, which must be one piece; of a shape of the plane, along its outline, whatever z. \
         Places outside have that of the closest point.",
    )
    .unit("units"),
    parameters: &[Key::new(
        "time",
        Kind::Constant,
        Number(0.5),
        "How long it spreads, free of units and sizes: 0.25 is sharper, 1 smoother.",
    )
    .limit(Limit::Within(0.25, 10.0))],
    formula: "‖p* − s*‖, p*ₖ = Σ ωᵢ(p)·φₖ(vᵢ)·exp(−λₖ·time/λ₁), ω mean-value coordinates",
    example: "{ diffusion = [[0, 0, 0.4]] }",
    build: diffusion,
    ..Source::PLAIN
};

fn diffusion(source: &mut dyn Sourcing<1>) -> Result<Paint<1>, Problem> {
    let solid = source.solid()?;
    let aabb = box_of(solid.as_ref()).map_err(|error| source.problem(&error.to_string()))?;
    let rows = &source.arguments().rows("diffusion").expect("it must be there").all;
    let sources: Vec<DVec3> = rows.iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect();
    let time = *source.arguments().constant("time").expect("it has a default");
    let cancel = source.cancel();
    let found = Diffusion::new(&Spreading { solid: solid.as_ref(), aabb, sources: &sources, time, cancel: &cancel });
    found.map(Paint::of).map_err(|error| {
        let problem = source.problem(&error.to_string());
        match error {
            DiffusionError::Outside(_) => {
                problem.help("places stand in the shape's own space, before scale, rotate and move")
            }
            DiffusionError::Pieces(_) if aabb.is_of_plane() => {
                problem.help("make a shape of each piece, with the attribute, and take it from them by `parts`")
            }
            DiffusionError::Pieces(_) => problem.help("`interior` takes several pieces, and hollows"),
            DiffusionError::Cancelled | DiffusionError::Surface(_) => problem,
        }
    })
}
