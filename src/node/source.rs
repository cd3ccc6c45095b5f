//! A row of the tables of colours and scalars: where an attribute of a shape can come from.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::attribute::conformal::{Body, Feature, Method};
use crate::attribute::{Attribute, Bands, ByCell, CellIndex, Choice, CubeLattice, Mix, Rule, Scalar};
use crate::field::{Field, Interval};
use crate::mesh::NumberOf;
use crate::node::argument::{Arguments, Component};
use crate::node::id::ShapeId;
use crate::node::keys::seed;
use crate::node::painted::Paint;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::key::Absent::{Nothing, Number, Text};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;
use crate::text::reader::Fields;
use crate::text::source::Span;

/// How far outside of a part a surface point may be, in voxels, and still count as inside it: closest points lie on the
/// surface to about a thousandth of a voxel. Less: specks of the parts behind; more: parts that end just below the
/// surface shine through.
pub(crate) const TOLERANCE_VOXELS: f64 = 0.05;

/// Where an attribute of `N` numbers can come from.
pub struct Source<const N: usize> {
    /// The key that names it; its value is the main argument.
    pub key: Key,
    /// The keys beside it.
    pub parameters: &'static [Key],
    /// What its numbers are, where one line says it.
    pub formula: &'static str,
    /// What it is, TOML, for a shape `a` with cells.
    pub example: &'static str,
    /// What is wrong with its keys together. The flag: whether the shape has cells that can take a value each.
    pub check: fn(&Fields<'_, '_>, bool) -> Option<Diagnostic>,
    /// Whether it reads a grid of a `.vdb` file.
    pub is_volume: bool,
    /// Whether it follows the inside of the shape, so that it changes with that.
    pub is_conformal: bool,
    /// Whether it goes by coordinates in 32 bits, which are coarse far from the origin.
    pub goes_by_coordinates: bool,
    /// The attribute at a moment.
    pub build: fn(&mut dyn Sourcing<N>) -> Result<Paint<N>, Problem>,
}

impl<const N: usize> Source<N> {
    /// What most rows have nothing of.
    pub const PLAIN: Self = Self {
        key: Key::new("", Kind::Table, Nothing, ""),
        parameters: &[],
        formula: "",
        example: "",
        check: |_, _| None,
        is_volume: false,
        is_conformal: false,
        goes_by_coordinates: false,
        build: |source| Ok(Paint::solid(source.absent())),
    };

    /// All its keys.
    pub fn keys(&'static self) -> impl Iterator<Item = &'static Key> + Clone {
        std::iter::once(&self.key).chain(self.parameters)
    }
}

impl<const N: usize> std::fmt::Debug for Source<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.key.name)
    }
}

/// An attribute of a shape, as the scene gives it.
#[derive(Clone, Debug)]
pub struct Given<const N: usize> {
    /// Where it comes from.
    pub source: &'static Source<N>,
    /// The values of its keys.
    pub arguments: Arguments,
    /// Where it stands.
    pub span: Span,
}

impl<const N: usize> Given<N> {
    /// Where its formulas stand, if it has any.
    pub fn formula(&self) -> Option<Span> {
        self.arguments.has_components().then_some(self.span)
    }
}

/// The inside of a shape, and features in it.
pub type Inside = (Arc<Body>, Vec<Arc<Feature>>);

/// What is asked of the inside of a shape.
pub struct InsideRequest<'a> {
    /// The features; `None` is the shape's own surface.
    pub features: &'a [Option<ShapeId>],
    /// Cells along the shape's longest side.
    pub along: u32,
    /// How the length of ways is found.
    pub method: Method,
    /// Where its speed stands, if it has one.
    pub speed: Option<Span>,
    /// What asks for it.
    pub key: &'static str,
}

/// What a row's function may ask for while its attribute is built, at one moment of the shot.
pub trait Sourcing<const N: usize> {
    /// The values of its keys.
    fn arguments(&self) -> &Arguments;
    /// A number or formula as a field.
    fn component(&mut self, component: &Component) -> Result<Arc<dyn Field>, Problem>;
    /// The shape in its own space, before `displace`.
    fn solid(&mut self) -> Result<Arc<dyn Field>, Problem>;
    /// A voxel's edge in the shape's space.
    fn voxel(&self) -> f64;
    /// Another shape where it stands, in this one's own space.
    fn shape(&mut self, id: ShapeId) -> Result<Arc<dyn Field>, Problem>;
    /// Set to stop.
    fn cancel(&self) -> Arc<AtomicBool>;
    /// The cells of the shape, which can take a value each.
    fn cells(&mut self) -> Result<Arc<dyn CellIndex>, Problem>;
    /// What the attribute is on some shapes, together; `None` where none has it.
    fn parts(&mut self, shapes: &[ShapeId], rule: Rule) -> Result<Option<Paint<N>>, Problem>;
    /// The depth below the shape's surface, wherever that is one of `levels`.
    fn depth(&mut self, levels: Interval) -> Result<Arc<Scalar>, Problem>;
    /// The shape's inside, and what spreads in it from features.
    fn inside(&mut self, asked: &InsideRequest<'_>) -> Result<Inside, Problem>;
    /// What the attribute is on a shape, where that stands; `None` where it has none.
    fn of_shape(&mut self, shape: ShapeId) -> Result<Option<Paint<N>>, Problem>;
    /// What was read from its file.
    fn volume(&self) -> Result<Arc<dyn Attribute<N>>, Problem>;
    /// A number of the materials in its file.
    fn of_material(&self, which: NumberOf) -> Result<Arc<Scalar>, Problem>;
    /// What a shape has that has none, beside others that have one.
    fn absent(&self) -> [f32; N];
    /// The problem of shapes that should have it, and none of them has.
    fn none_has(&self, shapes: &[ShapeId]) -> Problem;
    /// A problem of the shape.
    fn problem(&self, message: &str) -> Problem;
}

/// How parts of several colours meet.
pub(crate) const SEAM: Key = Key::new(
    "seam",
    Kind::Constant,
    Number(0.0),
    "Over which width the colours of parts that meet go over into one another; 0 is a sharp edge.",
)
.limit(Limit::NotNegative)
.unit("units");

/// What takes a value at random.
pub(crate) const BY: Key = Key::new(
    "by",
    Kind::Choice(&["cell", "voxel"]),
    Text("cell"),
    "What takes one: each cell of `facet` or `at`, or each cube of a lattice.",
);

/// The cubes that take values at random.
pub(crate) const EDGE: Key = Key::new(
    "voxel_size",
    Kind::Constant,
    Nothing,
    "`by = \"voxel\"`: the cubes' edge, in the shape's own space. The origin is the middle of one.",
)
.limit(Limit::Positive)
.unit("units");

/// What choices at random start from.
pub(crate) const SEED: Key = seed("The number that the choice starts from.");

/// What takes the values that are chosen at random has to be there.
pub(crate) fn has_pieces(fields: &Fields<'_, '_>, has_cells: bool) -> Option<Diagnostic> {
    let by_voxel = fields.entry("by").is_some_and(|entry| entry.value.text() == Some("voxel"));
    let main = fields.main_span();
    match (by_voxel, fields.entry("voxel_size")) {
        (true, Some(_)) => None,
        (true, None) => Some(
            Diagnostic::error(main, format!("`{}` has no `voxel_size`", clip(&fields.path))).help("the cubes' edge"),
        ),
        (false, Some(entry)) => Some(Diagnostic::error(entry.key_span, "`voxel_size` is for `by = \"voxel\"` only")),
        (false, None) if has_cells => None,
        (false, None) => Some(
            Diagnostic::error(main, "only a shape with `facet` or `at` has cells")
                .help("by = \"voxel\" with a `voxel_size` takes the cubes of a lattice"),
        ),
    }
}

/// A value for each piece of space, at random.
pub(crate) fn at_random<const N: usize>(
    source: &mut dyn Sourcing<N>,
    choice: Choice<N, impl Mix<N> + 'static>,
) -> Result<Paint<N>, Problem> {
    let cells: Arc<dyn CellIndex> = match source.arguments().constant("voxel_size").copied() {
        Some(edge) => {
            let tolerance = TOLERANCE_VOXELS * source.voxel();
            Arc::new(CubeLattice { edge, solid: source.solid()?, tolerance })
        }
        None => source.cells()?,
    };
    let seed = *source.arguments().seed("seed").expect("it has a default");
    Ok(Paint::of(ByCell { cells, choice, seed }))
}

/// A value for each band of depth: where it begins, units, rising. They stand as before `displace`, which they may be what
/// it goes by.
pub(crate) fn by_depth<const N: usize>(
    source: &mut dyn Sourcing<N>,
    bands: Vec<(f64, [f32; N])>,
) -> Result<Paint<N>, Problem> {
    // What lies before the first has the first's: it begins nowhere.
    let levels = match &bands[..] {
        [] | [_] => return Ok(Paint::solid(bands.first().map_or([0.0; N], |(_, value)| *value))),
        [_, (first, _), .., (last, _)] | [_, (first @ last, _)] => Interval::new(*first, *last),
    };
    let depth = source.depth(levels)?;
    let bands = Bands::new(depth, bands, TOLERANCE_VOXELS * source.voxel());
    bands.map(Paint::of).ok_or_else(|| source.problem("bands begin one below the other"))
}

/// What other shapes have, which stand in this one's own space.
pub(crate) fn of_parts<const N: usize>(source: &mut dyn Sourcing<N>) -> Result<Paint<N>, Problem> {
    let shapes = source.arguments().shapes("parts").cloned().unwrap_or_default();
    let seam = source.arguments().constant("seam").copied().unwrap_or(0.0);
    let paint = source.parts(&shapes, Rule::Union { seam })?;
    paint.ok_or_else(|| source.none_has(&shapes))
}

/// How a volume's values go on outside.
pub(crate) const OUTSIDE: Key = Key::new(
    "outside",
    Kind::Choice(&["nearest", "potential"]),
    Text("nearest"),
    "How values go on outside of the active voxels: that of their nearest point, or the mean of all voxels weighted by a \
     power of the distance, which takes some seconds more at high resolutions.",
);

/// The power of the potential outside of a volume.
pub(crate) const POWER: Key = Key::new(
    "power",
    Kind::Whole,
    Number(4.0),
    "`outside = \"potential\"`: the power p. 2 is the paper's, and lets far voxels rule over near ones.",
)
.limit(Limit::Within(*crate::attribute::POWERS.start() as f64, *crate::attribute::POWERS.end() as f64));

/// `power` goes with one of the ways outside.
pub(crate) fn power_is_used(fields: &Fields<'_, '_>, _has_cells: bool) -> Option<Diagnostic> {
    let is_potential = fields.entry("outside").is_some_and(|entry| entry.value.text() == Some("potential"));
    let entry = fields.entry("power").filter(|_| !is_potential)?;
    Some(Diagnostic::error(entry.key_span, "`power` is for `outside = \"potential\"` only"))
}

/// A volume of voxels.
pub(crate) fn of_volume<const N: usize>(source: &mut dyn Sourcing<N>) -> Result<Paint<N>, Problem> {
    Ok(Paint::shared(source.volume()?))
}
