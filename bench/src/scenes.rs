//! The scenes in `bench/scenes`, read as any user's scene is.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use hfvdb::distance::accuracy::ball;
use hfvdb::distance::band::{Feet, Measured, MeasuredBlock, Settings, measure};
use hfvdb::field::{Aabb, Expression, Graph, Node, SetSystem};
use hfvdb::node::{Source, load};
use hfvdb::shot::{FrameContent, PrepareOptions, Prepared};
use hfvdb::text::Overrides;

/// The half width of all bands, in voxels.
pub const HALF_WIDTH: f64 = 3.0;

/// How fine.
#[derive(Clone, Copy)]
pub enum Sampling {
    /// So many voxels along the edge of the box [-1, 1]³.
    OfBox(u32),
    /// So many along the longest side of what the scene shows.
    OfSolid(u32),
}

/// A scene's text, from `bench/scenes`.
pub fn text(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A scene made ready: one of `bench/scenes`, or a built-in one.
pub fn prepare(name: &str, sampling: Sampling) -> Prepared {
    let source = match hfvdb::text::builtin_text(name) {
        Some(_) => Source::Builtin(name.into()),
        None => Source::Text { name: format!("{name}.toml"), text: text(name), folder: "bench/scenes".into() },
    };
    prepare_source(&source, sampling)
}

/// A scene of any kind made ready.
pub fn prepare_source(source: &Source, sampling: Sampling) -> Prepared {
    let model = load(source, &Overrides::default()).unwrap_or_else(|error| panic!("{error}"));
    let (voxel_size, resolution) = match sampling {
        Sampling::OfBox(resolution) => (Some(2.0 / f64::from(resolution)), None),
        Sampling::OfSolid(resolution) => (None, Some(resolution)),
    };
    let options = PrepareOptions {
        voxel_size,
        resolution,
        half_width: Some(HALF_WIDTH),
        memory_limit: None,
        cache: None,
        cancel: Arc::default(),
        progress: &|_, _| {},
    };
    Arc::new(model).prepare(&options).unwrap_or_else(|error| panic!("{error}"))
}

/// One frame's band, in memory, without colour.
pub fn band(prepared: &Prepared, content: &FrameContent) -> Measured<()> {
    let cancel = AtomicBool::new(false);
    let settings = Settings {
        lattice: prepared.lattice,
        half_width: prepared.half_width,
        region: content.region,
        feet: Feet::Nearest,
        cancel: &cancel,
        progress: &|_| {},
    };
    measure(&*content.field, &settings, || |_: &MeasuredBlock| ()).expect("the scenes have surfaces")
}

/// The box [-1, 1]³.
pub fn unit_box() -> Aabb {
    Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0))
}

/// A ball of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its middle.
    pub centre: DVec3,
    /// Its radius.
    pub radius: f64,
}

/// The balls of *two_hundred*.
pub struct Balls {
    /// Those of the solid.
    pub solid: Vec<Ball>,
    /// Those taken away.
    pub holes: Vec<Ball>,
}

/// The balls of *two_hundred* for rivals that read no scenes.
pub fn two_hundred() -> Balls {
    let text = text("two_hundred");
    let (holes, solid) = text.split_once("[shape.balls]").expect("the balls stand last");
    let balls = |text: &str| text.lines().filter_map(ball_of_line).collect();
    let balls = Balls { solid: balls(solid), holes: balls(holes) };
    assert_eq!((balls.solid.len(), balls.holes.len()), (200, 20));
    balls
}

/// A ball from `{ formula = "r^2 - …", move = [x, y, z] },`.
fn ball_of_line(line: &str) -> Option<Ball> {
    let radius = line.split_once("formula = \"")?.1.split_once("^2")?.0.parse().ok()?;
    let centre = line.split_once("move = [")?.1.split_once(']')?.0;
    let centre: Vec<f64> = centre.split(',').map(|number| number.trim().parse().expect("a number")).collect();
    Some(Ball { centre: DVec3::from_slice(&centre), radius })
}

impl Balls {
    /// Their field as an expression, for benches that choose how it is evaluated.
    pub fn expression(&self, system: SetSystem) -> Expression {
        let mut graph = Graph::new();
        let balls = |graph: &mut Graph, balls: &[Ball]| -> Vec<Node> {
            balls.iter().map(|one| ball(graph, one.centre, one.radius)).collect()
        };
        let (solid, holes) = (balls(&mut graph, &self.solid), balls(&mut graph, &self.holes));
        let solid = graph.union(system, &solid);
        let whole = graph.difference(system, solid, &holes);
        Expression::new(&graph, whole)
    }

    /// x, y, z and radius of each: first the solid's, then the holes'.
    pub fn numbers(&self) -> [Vec<f64>; 2] {
        [&self.solid, &self.holes].map(|balls| {
            balls.iter().flat_map(|ball| [ball.centre.x, ball.centre.y, ball.centre.z, ball.radius]).collect()
        })
    }
}
