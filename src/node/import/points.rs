//! A cloud of points as balls.

use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use crate::attribute::{BallColours, Colour};
use crate::field::{Balls, Field, Joined};
use crate::mesh::read_cloud;
use crate::node::import::mesh::{VERTEX_COLORS, conventions};
use crate::node::keys::{FRAME_OFFSET, OUTSIDE_FRAMES, UNITS};
use crate::node::spec::{Carries, ColoursOf, Import, Imported, Spec};
use crate::text::key::Absent::{Required, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// A cloud of points as balls.
pub const NODE: Spec = Spec {
    key: Key::new(
        "points",
        Kind::Paths,
        Required,
        "Points of a file as balls, a million and more: PLY (x, y, z, and radius, red, green, blue where there are any), or text with one point a line: x y z, x y z radius, x y z r g b, or x y z radius r g b, or columns named by the first line. Their colours are its colour where `color` is left out. `points.csv`, where there is no such file beside the scene, is a built-in cloud. `spheres` has the same as a list in the scene.",
    ),
    parameters: &[
        Key::new(
            "radius",
            Kind::Constant,
            Words("that of the file"),
            "The radius of each ball, also where the file has others.",
        )
        .limit(Limit::Positive)
        .unit("units"),
        Key::new(
            "up",
            Kind::Choice(&["y", "z"]),
            Words("the scene's `up`"),
            "The axis that points up in the file. Where the scene's is another, the points are turned: (x, y, z) becomes (x, −z, y), or back.",
        ),
        VERTEX_COLORS,
        Key::new(
            "unit",
            Kind::Choice(UNITS),
            Words("the scene's `unit`"),
            "The file's unit of length: where the scene's is another, places and radii of the file are scaled.",
        ),
        FRAME_OFFSET,
        OUTSIDE_FRAMES,
    ],
    formula: "max(rᵢ − |p − cᵢ|): the signed distance outside",
    example: "points = \"points.csv\"\nradius = 0.09",
    carries: Carries::Import,
    import: Some(import),
    build: |build| build.imported_field(),
    ..Spec::PLAIN
};

fn import(import: &Import<'_>) -> Result<Imported, Problem> {
    const MOST_BYTES: u64 = 4 << 30;
    /// Centre, radius, place in the tree and colour.
    const BYTES_A_POINT: u64 = 120;
    let file = import.file("points");
    let content = file.read_at_most(MOST_BYTES)?;
    let cloud = read_cloud(Path::new(&file.name()), &content, &conventions(import, file)).map_err(|error| {
        Problem::new(file.span, error.to_string()).help("a PLY file, or text with x, y, z and more on each line")
    })?;
    let radius = import.arguments.constant("radius").copied();
    if radius.is_none() && cloud.radii.is_none() {
        let problem = file.problem("its points have no radius");
        return Err(
            problem.help("give `radius`, in units: about the distance from one point to the next closes a surface")
        );
    }
    let own = |i: usize| cloud.radii.as_ref().map_or(0.0, |radii| radii[i]);
    let all = cloud.positions.iter().enumerate().map(|(i, at)| (*at, radius.unwrap_or_else(|| own(i)))).collect();
    let balls = Arc::new(Joined::new(Balls::new(all)));
    let colours = cloud.colours.map(|colours| {
        let colours = Arc::new(BallColours::new(Arc::clone(&balls), colours));
        // The nearest ball's, however large voxels are.
        Box::new(move |_| Arc::clone(&colours) as Arc<Colour>) as ColoursOf
    });
    Ok(Imported {
        place: DAffine3::IDENTITY,
        solid: balls.bounding_box().expect("there are balls"),
        half_spaces: None,
        colours,
        materials: None,
        velocity: None,
        warnings: Vec::new(),
        bytes: cloud.positions.len() as u64 * BYTES_A_POINT,
        distance: balls as Arc<dyn Field>,
    })
}
