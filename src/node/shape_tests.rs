//! What shapes refuse, and what holds of more of them than their examples show.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::assets::Assets;
use super::id::{ShapeId, Stage};
use super::model::Content;
use super::row_tests::{solids, wrong_distances};
use super::solid::Solids;
use super::{Model, Source as From, load};
use crate::field::tests::{Samples, slope_at};
use crate::field::{Aabb, Expression, Field, Slope};
use crate::text::Overrides;
use crate::text::problem::Problem;

fn loaded(text: &str) -> Result<Model, String> {
    let scene = From::Text { name: "shapes.toml".into(), text: text.into(), folder: ".".into() };
    load(&scene, &Overrides::default()).map_err(|problems| problems.to_string())
}

/// What is wrong with a shape of some keys, when it is read or when it is built.
pub(super) fn problem(keys: &str) -> String {
    let model = match loaded(&format!("hfvdb = 1\n[shape.s]\n{keys}\n")) {
        Ok(model) => Arc::new(model),
        Err(problems) => return problems,
    };
    let told = |problem: &Problem| {
        assert!(problem.0.span.is_some_and(|span| span != Default::default()), "no place: {}", problem.0.message);
        assert!(!problem.0.help.is_empty(), "no way out: {}", problem.0.message);
        format!("{}; {}", problem.0.message, problem.0.help)
    };
    let assets = match Assets::load(&model, &[ShapeId(0)], None) {
        Ok(assets) => assets,
        Err(problem) => return told(&problem),
    };
    let cancel = Arc::new(AtomicBool::new(false));
    let mut solids = Solids::new(&model, &Arc::new(assets), model.moment(1.0), 64.0, &cancel);
    let Content::Shape(id) = model.content else { panic!("it is a shape") };
    match solids.values(id) {
        Ok(_) => panic!("nothing is wrong with\n{keys}"),
        Err(problem) => told(&problem),
    }
}

pub(super) fn field(keys: &str) -> Expression {
    let text = format!("hfvdb = 1\n[output]\nshape = \"s\"\n[shape.s]\n{keys}\n");
    let (mut solids, id) = solids(&text);
    solids.values(id).unwrap_or_else(|problem| panic!("{problem:?}\n{keys}"))
}

#[test]
fn parameters_that_make_no_shape_are_errors_with_a_way_out() {
    for (keys, words) in [
        ("sphere = -1", "must be greater than 0"),
        ("rounded_box = [1, 2, 0.3]\nedge_radius = 0.2", "`edge_radius` is more than half of the shortest edge"),
        ("chamfered_box = 1\nchamfer = 0.5", "`chamfer` must be less than half"),
        ("box_frame = 1\nbar = 0.6", "nothing is left between the bars"),
        ("hollow_box = 1\nwall = 0.5", "`wall` must be less than half"),
        ("hollow_sphere = 1\nwall = 1", "`wall` must be less than the radius"),
        ("cut_sphere = 1\ncut = 1.5", "must lie within the ball"),
        ("cut_hollow_sphere = 1\ncut = -0.99", "`cut` must lie between"),
        ("lens = 1\nthickness = 3", "more than twice the rim's radius"),
        ("egg = 1\ntip = 1", "`tip` must be less"),
        ("egg = 1\nheight = 2", "`height` must be more than twice"),
        ("dented_sphere = 1\ndent_height = 3", "the two balls must cross"),
        ("chain = 0.2\ntube = 0.15", "does not fit through the next"),
        ("torus_knot = 1\np = 2\nq = 4", "p = 1, q = 2"),
        ("rounded_cylinder = 1\nedge_radius = 1.2", "`edge_radius` must be at most"),
        ("pipe = 1\nwall = 1", "a thinner wall"),
        ("hull = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]", "lie in one plane"),
        ("hull = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]", "needs at least 4"),
        ("hull = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1]]", "lists of 3 numbers"),
        ("planes = [[1, 0, 0, 1], [-1, 0, 0, 1], [0, 1, 0, 1], [0, -1, 0, 1]]", "nothing ends"),
        (
            "planes = [[1, 0, 0, -1], [-1, 0, 0, -1], [0, 1, 0, 1], [0, -1, 0, 1], [0, 0, 1, 1], [0, 0, -1, 1]]",
            "nothing lies behind",
        ),
        ("polygon = [[0, 0], [1, 0]]", "needs at least 3"),
        ("polygon = [[0, 0], [1, 1], [1, 0], [0, 1]]", "cross: [0, 0] to [1, 1]"),
        ("polygon = [[0, 0], [1, 1], [2, 2]]", "has no area"),
        ("triangle = [[0, 0], [1, 0], [1, 1], [0, 1]]", "`polygon` has any number"),
        ("cross = 1\narm = 1", "`arm` must be less"),
        ("arc_2d = 1\nangle = 355", "the ends of the arc meet"),
        ("horseshoe = 1\nangle = 300\nlength = 3", "the ends of the horseshoe meet"),
        ("ring = 1\nwidth = 2", "`circle`"),
        ("vesica = 1\nwidth = 2", "`rotate`"),
        ("moon = 1\nbite_at = 5", "must cross"),
        ("tunnel = [4, 1]", "at least 2"),
        ("gear = 1\nhole = 1", "between the teeth"),
        ("stroke = [[0, 0, 1], [1, 0, -1]]", "a width must be greater than 0"),
        ("lathe = [[-1, 0], [1, 0], [1, 1]]", "beyond the axis"),
        ("extrude = { circle = 1 }\nheight = 0.2\nedge_radius = 0.2", "half of the height"),
        ("extrude = { superellipse = 1 }\nedge_radius = 0.1", "needs a shape whose F is its distance"),
        ("extrude = { circle = 1, rotate = [30, 0, 0] }", "leaves the plane"),
        ("revolve = { rectangle = 1, move = [0.5, 0, 0] }", "an edge on the axis"),
        ("revolve = { circle = 1, move = [-3, 0, 0] }", "nothing is left"),
        ("extrude = { sphere = 1 }", "`extrude` needs a shape of the plane, and"),
        ("sweep = { circle = 0.1 }\npath = { superellipse = 1 }", "`path` needs a shape whose F is its distance"),
        ("thread = 1\ndepth = 1", "a finer `pitch`"),
        ("union = [{ circle = 1 }, { sphere = 1 }]", "make it a solid with `extrude`, `revolve` or `sweep`"),
        ("facet = { circle = 1 }\ncells = { octree = { sphere = 1 } }", "`facet` needs solids"),
        ("circle = 0.1\nscatter = 5\nhost = { circle = 1 }", "a solid is needed here, and"),
        (
            "extrude = { union = [{ circle = 0.5 }, { rectangle = [0.9, 0.2] }], do = [{ rotate = [40, 0, 0] }, { shell = 0.1 }] }",
            "turn it about z alone, or make it a solid with `extrude`, `revolve` or `sweep` first",
        ),
        ("union = [{ sphere = 1 }, { box = 1 }]\norder = 2", "`order` says nothing here"),
        ("union = [{ sphere = 1 }, { box = 1 }]\nsystem = \"cn\"\norder = 1", "`order` of `cn` starts at 2"),
        ("union = [{ sphere = 1 }, { box = 1 }]\nsystem = \"rm\"\norder = 9", "`order` of `rm` ends at 8"),
        ("union = [{ sphere = 1 }, { box = 1 }]\nsystem = \"rm\"\norder = 17", "must be from 1 to 16"),
        ("gyroid = 1\nbounds = 2", "neither `thickness` nor `fraction`"),
        ("gyroid = 1\nthickness = 0.1\nfraction = 0.2\nbounds = 2", "both `thickness` and `fraction`"),
        ("honeycomb = 1\nwall = 1\nbounds = 2", "larger cells"),
        ("slabs = 1\nwall = 1\nbounds = 2", "farther apart"),
        ("slabs = 1\naxes = \"yx\"\nbounds = 2", "did you mean"),
        ("foam = 1\nwall = 1\nbounds = 2", "larger cells"),
        ("pores = 1\njitter = 2\nbounds = 2", "must be from 0 to 1"),
        ("threads = 1\nradius = 0.3\nwave = 0.3\nbounds = 2", "layers would meet"),
        ("sphere = 1\nfill = { circle = 1 }", "a shape of the plane"),
        ("sphere = 1\nfill = { gyroid = 0.5, thickness = 0.1 }\nskin = -1", "must be 0 or greater"),
        ("polyline = [[0, 0, 0, 0.1], [1, 0, 0, 0]]", "a radius must be greater than 0"),
        ("polyline = [[0, 0, 0]]", "needs at least 2"),
        ("box = [0.4, 0.1, 2]\nbend_along = [[0, 0, 0], [1, 0, 0], [0, 0, 0]]", "folds where the curve turns sharply"),
        ("box = [2, 2, 3]\nbend_along = [[0, 0, 0], [1, 0, 1], [0, 0, 2]]", "folds where the curve turns sharply"),
        ("circle = 0.2\nbend_along = [[0, 0, 0], [1, 0, 3]]", "bends solids, and"),
        ("sphere = 1\nbend_along = [[0, 0, 0], [0, 0, 0]]", "all points of the curve are the same"),
        (
            "sphere = 1\nbend_along = [[0, 0, 0], [0, 0, 9], [0, 1, 9]]\nbend_curve = \"b_spline\"",
            "`bend_along`: a B-spline needs at least four points, and has 3",
        ),
        (
            "sphere = 1\nbend_along = [[0, 0, 0]]",
            "`bend_along`: a smooth curve needs at least two points, and has 1; more",
        ),
        ("sphere = 1\nbend_along = [[0, 0, 0], [0, 0, 1, 2]]", "point 2 of `bend_along` has more than x, y and z"),
        ("sphere = 1\nbend_along = [[0, 0, 0], [0, 0]]", "a place has 3, 4, 6 or 7 numbers, not 2"),
        ("sphere = 1\nbend_along = 'none.csv'", "there is no file `none.csv`"),
        ("sphere = 1\nalong = [[0, 0, 0], [0, 0, 1, 2]]", "point 2 of `along` has more than x, y and z"),
        ("sweep = { circle = 0.1 }", "nothing says where `sweep` goes"),
        ("sweep = { circle = 0.1 }\npath = { circle = 1 }\nclosed_path = [[0, 0, 0]]", "both say where `sweep` goes"),
        ("sweep = { circle = 0.1 }\npath = { circle = 1 }\nturn = 90", "`turn` goes with `closed_path`"),
        (
            "sweep = { circle = 0.1 }\nclosed_path = [[0, 0, 0], [1, 0, 0], [0, 0, 0]]",
            "`closed_path`: a closed smooth curve needs at least three points, and has 2",
        ),
        (
            "sweep = { rectangle = [0.2, 0.1] }\nclosed_path = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]\nturn = 90",
            "turned by 90 degrees on its way, the shape of `sweep` does not meet itself; 0, or a multiple of 180",
        ),
        (
            "sweep = { regular_polygon = 0.1, sides = 5 }\nclosed_path = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]\nturn = 90",
            "0, or a multiple of 72",
        ),
        (
            "sweep = { circle = 0.9 }\nclosed_path = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]",
            "folds where the curve turns sharply",
        ),
        ("b_spline = [[0, 0, 0], [1, 0, 0], [1, 1, 0]]", "needs at least 4"),
        ("metaballs = [[0, 0, 0, -1]]", "the fourth number of a ball"),
        ("convolution = [[0, 0, 0], [0, 0, 0]]", "are the same"),
        ("convolution = [[0, 0, 0]]", "a line needs two points"),
        ("convolution = [[0, 0, 0], [1, 0, 0]]\nskeleton = \"arcs\"", "arcs need 3 points"),
        ("convolution = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]\nskeleton = \"arcs\"", "lie on one line"),
        ("polygon = [[0, 0, 0.6], [1, 0, 0.6], [0, 1]]", "the arcs of [0, 0, 0.6] and [1, 0, 0.6] meet"),
        ("lathe = [[0, 0], [1, 0, -1], [1, 1]]", "is less than 0"),
        ("lathe = [[0, 0], [1, 0, 0.1], [1, 1], [1, 1]]", "[1, 1, 0] is there twice"),
        ("cubic = 1\nradius = 0\nbounds = 2", "radius` must be greater than 0"),
        ("sphere = 1\nat = { cells = { octree = { circle = 1 } } }", "a shape of the plane"),
        ("text = \"\"", "draws nothing; give it letters"),
        ("text = \" \\n \"", "draws nothing"),
        ("text = 7", "must be text"),
        ("text = \"a\u{4e2d}\"", "no glyph for '\u{4e2d}' (U+4E2D); leave it out, or name a font"),
        ("text = \"a\"\nfont = \"none.ttf\"", "there is no file `none.ttf`"),
        ("text = \"a\"\nfont = \"Cargo.toml\"", "Cargo.toml: it is no font that can be read; a TrueType"),
        ("text = \"a\"\nfont = \"fonts\"", "is a folder"),
        ("text = \"a\"\nalign = \"middle\"", "`left`, `center` and `right`"),
        ("svg = \"none.svg\"", "there is no file `none.svg`"),
        ("svg = \"Cargo.toml\"", "Cargo.toml: it is no SVG drawing: "),
        ("svg = \"logo.svg\"\nwidth = 0", "must be greater than 0"),
        ("image = \"none.png\"", "there is no file `none.png`"),
        ("image = \"Cargo.toml\"", "Cargo.toml: it is no PNG picture"),
        ("image = \"leaf.png\"\nthreshold = 1", "nothing in it is above 1; another `threshold`"),
        ("image = \"leaf.png\"\nchannel = \"alpha\"", "no alpha channel"),
        ("height_field = \"Cargo.toml\"", "Cargo.toml: it is no PNG picture"),
        ("points = \"Cargo.toml\"\nradius = 1", "Cargo.toml"),
        ("points = \"points.csv\"", "have no radius; give `radius`"),
        ("spheres = [[0, 0, 0, 0]]", "a radius must be greater than 0, and is 0"),
        ("spheres = [[0, 0]]", "lists of 3 or 4 numbers"),
    ] {
        let said = problem(keys);
        assert!(said.contains(words), "{keys}\n{said}");
    }
}

/// Distances of what is made of shapes of the plane, and of parameters beside those of the examples.
#[test]
fn solids_of_the_plane_are_as_exact_as_they_say() {
    let both = Slope::Exact { outside: true, inside: true };
    for (keys, slope) in [
        ("extrude = { polygon = [[-1, -1], [1, -1], [1, 1], [0, 0], [-1, 1]] }\nheight = 0.7", both),
        ("extrude = { ellipse = [1.2, 0.4], rotate = [0, 0, 30], move = [0.2, 0.1, 5] }\nheight = 0.7", both),
        ("extrude = { gear = 1, teeth = 8, hole = 0.4, scale = 0.9 }\nheight = 1", both),
        ("extrude = { rectangle = [1.4, 0.8], offset = 0.2 }\nheight = 1", both),
        (
            "extrude = { triangle = [[0, 0], [1, 0], [0, 1]], offset = 0.2 }\nheight = 1",
            Slope::Exact { outside: true, inside: false },
        ),
        ("revolve = { rectangle = [0.4, 1] }\naxis_offset = 0.8", both),
        ("revolve = { star = 0.4, move = [1, 0, 0] }", both),
        // Half of the rectangle lies beyond the axis, which counts in its distance.
        ("revolve = { rectangle = [2, 1], move = [0.2, 0, 0] }", Slope::Lipschitz(1.0)),
        ("revolve = { circle = 0.4 }\naxis_offset = 1\nangle = 200", Slope::Lipschitz(1.0)),
        ("extrude = { star = 1 }\nheight = 0.8\nedge_radius = 0.1", Slope::Lipschitz(1.0)),
        ("sweep = { rectangle = 0.4 }\npath = { star = 1 }", Slope::Lipschitz(1.0)),
        ("lathe = [[0, -1], [1, -0.5], [0.3, 0], [1, 1], [0, 1]]", both),
        ("capped_torus = 1\nangle = 60", both),
        ("capped_torus = 1\nangle = 300", both),
        ("capped_torus = 1\nangle = 350", Slope::Exact { outside: true, inside: false }),
        ("cut_sphere = 1.2\ncut = -0.5", both),
        ("cap = 0.6\nheight = 1.6", both),
        ("cut_hollow_sphere = 1.2\ncut = -0.6\nwall = 0.3", both),
        ("solid_angle = 1.4\nangle = 140", both),
        ("infinite_cone = 70", both),
        ("elliptic_cylinder = [0.3, 1.4]\nheight = 0.8", both),
        ("elliptic_cylinder = [1, 1]\nheight = 0.8", both),
        ("frustum = 0.5\ntop = 1.2\nsides = 3", both),
        ("arc_2d = 1\nangle = 40\nwidth = 0.5", both),
        ("pie = 1.2\nangle = 60", both),
        ("torus_knot = 0.8", both),
        ("helix = 0.7\nturns = 3", both),
        // Windings that touch, and a knot whose strands do.
        ("helix = 0.7\npitch = 0.15\nwire = 0.08", Slope::Exact { outside: true, inside: false }),
        ("torus_knot = 0.8\ntube = 0.35", Slope::Exact { outside: true, inside: false }),
        ("hollow_sphere = 1.2\nwall = 0.4", both),
        ("hollow_box = [2, 1.5, 1.2]\nwall = 0.3", both),
    ] {
        let field = field(keys);
        assert_eq!(field.slope(), slope, "{keys}");
        let wrong = wrong_distances(keys, &field);
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}

#[test]
fn a_shape_of_the_plane_is_extruded_by_an_eighth_of_its_longer_side() {
    let model = loaded("hfvdb = 1\n[shape.plate]\nrectangle = [2, 1]\noffset = 0.3\n").unwrap();
    assert!(model.warnings.to_string().contains("`plate` is a shape of the plane"), "{}", model.warnings);
    let Content::Shape(id) = model.content else { panic!("it is a shape") };
    let model = Arc::new(model);
    let assets = Arc::new(Assets::load(&model, &[id], None).unwrap());
    let mut solids = Solids::new(&model, &assets, model.moment(1.0), 64.0, &Arc::new(AtomicBool::new(false)));
    let field = solids.field(id, Stage::Placed).unwrap();
    let size = field.bounding_box().unwrap().size();
    assert!((size - DVec3::new(2.6, 1.6, 2.6 / 8.0)).length() < 1e-9, "{size}");
    // Nobody extrudes what something else does.
    let named = loaded("hfvdb = 1\n[shape.a]\ncircle = 1\n[shape.b]\nextrude = \"a\"\nheight = 3\n").unwrap();
    assert!(!named.warnings.to_string().contains("plane"), "{}", named.warnings);
}

/// What would show along z alone is not dropped without a word.
#[test]
fn what_is_done_to_a_shape_of_the_plane_along_z_is_told() {
    let said = |done: &str| {
        let text = format!("hfvdb = 1\n[shape.a]\nextrude = \"b\"\n[shape.b]\ncircle = 0.3\n{done}\n");
        loaded(&text).unwrap().warnings.to_string()
    };
    for (done, key) in [
        ("move = [0, 1, 2]", "move"),
        ("do = [{ move = [0, 0, 1] }]", "move"),
        ("elongate = [0, 0.1, 0.2]", "elongate"),
        ("array = [2, 1, 3]", "array"),
        ("places = [[0, 0, 1], [1, 0, 0]]", "places"),
        ("scale = [1, 2, 3]", "scale"),
        ("do = [{ scale = [1, 1, 3] }]", "scale"),
        ("mirror = \"z\"", "mirror"),
        ("mirror = [0, 0, -1]", "mirror"),
    ] {
        assert!(said(done).contains(&format!("`{key}` along z does nothing to `b`")), "{done}: {}", said(done));
    }
    for done in [
        "move = [0, 1, 0]",
        "elongate = 0.2",
        "elongate = [0.1, 0, 0]",
        "array = 2",
        "array = [2, 3, 1]",
        "scale = 2",
        "scale = [2, 3, 1]",
        "do = [{ scale = 3 }]",
        "mirror = \"x\"",
        "mirror = [1, 0, 1]",
    ] {
        assert!(!said(done).contains("along z"), "{done}: {}", said(done));
    }
}

/// Set operations of shapes of the plane are such again.
#[test]
fn shapes_of_the_plane_are_joined_in_the_plane() {
    let field =
        field("extrude = \"both\"\nheight = 0.5\n[shape.both]\ndifference = [{ circle = 1 }, { circle = 0.5 }]");
    assert!(field.reference(DVec3::new(0.75, 0.0, 0.2)) > 0.0);
    assert!(field.reference(DVec3::ZERO) < 0.0 && field.reference(DVec3::new(0.75, 0.0, 0.3)) < 0.0);
    let size = field.bounding_box().unwrap().size();
    assert!((size - DVec3::new(2.0, 2.0, 0.5)).length() < 1e-6, "{size}");
}

const SURFACES: [&str; 9] =
    ["gyroid", "schwarz_p", "schwarz_d", "lidinoid", "neovius", "i_wp", "f_rd", "split_p", "fischer_koch_s"];

/// The share of a cell that is inside, counted at points at random.
fn share(field: &Expression, cell: f64) -> f64 {
    let mut samples = Samples::new(5);
    let cell = Aabb::new(DVec3::ZERO, DVec3::splat(cell));
    let count = 20_000;
    (0..count).filter(|_| field.reference(samples.within(&cell)) > 0.0).count() as f64 / f64::from(count)
}

#[test]
fn periodic_solids_fill_their_fraction_of_space() {
    for name in SURFACES {
        for fraction in [0.2, 0.5, 0.8] {
            let field = field(&format!("{name} = 0.7\nfraction = {fraction}\nbounds = 9"));
            let found = share(&field, 0.7);
            assert!((found - fraction).abs() < 0.015, "{name}: {found} of {fraction}");
        }
    }
}

/// A thickness is a length: from the middle of a thin sheet its surface is half of it away, whatever the cell.
#[test]
fn periodic_sheets_are_as_thick_as_they_say() {
    for name in SURFACES {
        for cell in [0.5, 3.0] {
            let thickness = 0.01 * cell;
            let field = field(&format!("{name} = {cell}\nthickness = {thickness}\nbounds = 99"));
            let mut samples = Samples::new(9);
            let within = Aabb::new(DVec3::ZERO, DVec3::splat(cell));
            let found: Vec<f64> = (0..200_000)
                .map(|_| samples.within(&within))
                .filter(|p| field.reference(*p) > 0.0)
                .take(300)
                .filter_map(|p| thickness_at(&field, p, thickness))
                .collect();
            assert!(found.len() > 100, "{name}");
            let mean = found.iter().sum::<f64>() / found.len() as f64;
            assert!((mean / thickness - 1.0).abs() < 0.05, "{name} of {cell}: {mean} for {thickness}");
        }
    }
}

/// The way through a wall along the gradient at its surface.
fn thickness_at(field: &Expression, p: DVec3, expected: f64) -> Option<f64> {
    let slope = slope_at(field, p, [1e-6, 1e-5])?.normalize();
    let way = |direction: DVec3| {
        let at = |i: i32| f64::from(i) * expected / 400.0;
        (1..4000).map(at).find(|far| field.reference(p + direction * *far) <= 0.0)
    };
    Some(way(slope)? + way(-slope)?)
}

#[test]
fn lattices_of_struts_repeat_and_reach_their_points() {
    for (name, on_strut, beside) in [
        ("cubic", [0.5, 0.0, 0.0], [0.5, 0.5, 0.5]),
        ("bcc", [0.25, 0.25, 0.25], [0.5, 0.0, 0.0]),
        ("fcc", [0.25, 0.25, 0.0], [0.5, 0.0, 0.0]),
        ("octet", [0.75, 0.75, 0.5], [0.5, 0.0, 0.0]),
        ("kelvin", [0.5, 0.75, 0.0], [0.5, 0.5, 0.5]),
        ("diamond", [0.125, 0.125, 0.125], [0.5, 0.5, 0.5]),
        ("rhombic", [0.25, 0.25, 0.25], [0.0, 0.0, 0.0]),
        ("fluorite", [0.125, 0.125, 0.125], [0.5, 0.5, 0.5]),
        ("isotruss", [0.5, 0.0, 0.0], [0.5, 0.25, 0.1]),
        ("honeycomb", [0.5, 0.1, 0.3], [0.0, 0.0, 0.0]),
    ] {
        let field = field(&format!("{name} = 2\nbounds = 99"));
        for cell in [DVec3::ZERO, DVec3::new(1.0, -2.0, 3.0), DVec3::new(-4.0, 5.0, 1.0)] {
            // Hexagons repeat along y by √3.
            let cell = if name == "honeycomb" { cell * DVec3::new(1.0, 3.0_f64.sqrt(), 1.0) } else { cell };
            let at = |point: [f64; 3]| field.reference((DVec3::from(point) + cell) * 2.0);
            assert!(at(on_strut) > 0.09, "{name}: {}", at(on_strut));
            assert!(at(beside) < 0.0, "{name}: {}", at(beside));
        }
    }
}

/// The share of a cell that is solid, by samples on a lattice: against the closed form.
#[test]
fn structures_fill_the_share_that_they_should() {
    use std::f64::consts::PI;
    const SIDE: i32 = 60;
    for (keys, wanted) in [
        ("slabs = 1\nwall = 0.2", 0.2),
        ("slabs = 1\nwall = 0.2\naxes = \"xy\"", 1.0 - 0.8 * 0.8),
        ("slabs = 1\nwall = 0.2\naxes = \"xyz\"", 1.0 - 0.8_f64.powi(3)),
        ("cubic = 1\nradius = 0.2", 3.0 * PI * 0.04 - 8.0 * 2.0_f64.sqrt() * 0.008),
        ("pores = 1\nradius = 0.4\njitter = 0", 1.0 - 4.0 / 3.0 * PI * 0.064),
        ("foam = 1\nwall = 0.2\njitter = 0", 1.0 - 0.8_f64.powi(3)),
        // Of four threads, each as long as its wave.
        ("threads = 1\nradius = 0.1\nwave = 0.12", 4.0 * PI * 0.01 * wave_length(0.12)),
    ] {
        let field = field(&format!("{keys}\nbounds = 99"));
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(SIDE) + 3.0;
        let inside = (0..SIDE.pow(3))
            .filter(|i| field.reference(DVec3::new(at(i % SIDE), at(i / SIDE % SIDE), at(i / SIDE / SIDE))) >= 0.0)
            .count();
        let share = inside as f64 / f64::from(SIDE.pow(3));
        assert!((share / wanted - 1.0).abs() < 0.01, "{keys}: {share} for {wanted}");
    }
}

/// The length of one wave of a height over a length of 1.
fn wave_length(height: f64) -> f64 {
    let steps = 10_000;
    let slope =
        |i: i32| std::f64::consts::TAU * height * libm::cos(std::f64::consts::TAU * f64::from(i) / f64::from(steps));
    (0..steps).map(|i| (1.0 + slope(i).powi(2)).sqrt()).sum::<f64>() / f64::from(steps)
}

/// Copies of a shape of the plane end where they do: what makes a solid of them is no larger.
#[test]
fn copies_of_the_plane_keep_their_box() {
    for (keys, wanted) in [
        ("polar = 4\npolar_radius = 1", [3.0, 3.0]),
        ("array = [3, 1, 1]\nspacing = [2, 2, 2]", [5.0, 0.4]),
        ("places = [[-1, 0, 0], [1, 1, 0]]", [3.0, 1.4]),
    ] {
        let keys = keys.replace('\n', ", ");
        let solid = field(&format!("extrude = {{ rectangle = [1, 0.4], {keys} }}\nheight = 0.2"));
        let size = solid.bounding_box().expect("it ends").size();
        assert!((size - DVec3::new(wanted[0], wanted[1], 0.2)).abs().max_element() < 1e-6, "{keys}: {size}");
    }
}

/// A ball filled with walls is whole in its skin, and walls alone within.
#[test]
fn a_filled_shape_has_skin_and_structure() {
    let filled = field("sphere = 1\nfill = { slabs = 0.5, wall = 0.1 }\nskin = 0.1");
    for (at, inside) in
        [(0.95, true), (0.92, true), (0.88, false), (0.54, true), (0.56, false), (0.3, false), (0.0, true)]
    {
        for axis in [DVec3::Z, DVec3::NEG_Z] {
            assert_eq!(filled.reference(axis * at) > 0.0, inside, "{at} along {axis}");
        }
    }
    assert!(filled.reference(DVec3::X * 0.5) > 0.0 && filled.reference(DVec3::new(0.3, 0.0, 0.2)) < 0.0);
    assert!(filled.reference(DVec3::Z * 1.01) < 0.0);
    let open = field("sphere = 1\nfill = { slabs = 0.5, wall = 0.1 }");
    assert!(open.reference(DVec3::Z * 0.9) < 0.0 && open.reference(DVec3::X * 0.99) > 0.0);
}

#[test]
fn curves_go_where_their_points_say() {
    let radius = |keys: &str, at: [f64; 3]| field(keys).reference(DVec3::from(at));
    let points = "[[-1, 0, 0, 0.2], [-1, 0, 2], [1, 0, -2], [1, 0, 0, 0.4]]";
    for (keys, at, wanted) in [
        (format!("bezier = {points}"), [-1.0, 0.0, 0.0], 0.2),
        (format!("bezier = {points}"), [1.0, 0.0, 0.0], 0.4),
        // The middle of a cubic: (a + 3b + 3c + d)/8.
        (format!("bezier = {points}"), [0.0, 0.0, 0.0], (0.2 + 0.3 + 0.3 + 0.4) / 8.0),
        (format!("b_spline = {points}"), [-1.0, 0.0, 0.0], 0.2),
        // A clamped cubic of four points is the Bézier curve of them.
        (format!("b_spline = {points}"), [0.0, 0.0, 0.0], (0.2 + 0.3 + 0.3 + 0.4) / 8.0),
        // A closed one passes at (a + 4b + c)/6.
        (format!("b_spline = {points}\nends = \"closed\""), [-2.0 / 3.0, 0.0, 1.0], (0.2 + 0.4 + 0.1) / 6.0),
        (format!("catmull_rom = {points}"), [-1.0, 0.0, 2.0], 0.1),
        (format!("catmull_rom = {points}\nends = \"closed\""), [1.0, 0.0, -2.0], 0.1),
        (format!("polyline = {points}\nends = \"closed\""), [0.0, 0.0, 0.0], 0.3),
    ] {
        assert!((radius(&keys, at) - wanted).abs() < 2e-3, "{keys}: {}", radius(&keys, at));
    }
}

/// The points of a closed curve as a scene lists them.
fn closed(count: i32, at: impl Fn(f64) -> DVec3) -> String {
    let angle = |i: i32| std::f64::consts::TAU * f64::from(i) / f64::from(count);
    let all: Vec<String> = (0..count).map(|i| format!("{:?}", at(angle(i)).to_array())).collect();
    format!("[{}]", all.join(", "))
}

#[test]
fn a_circle_along_a_circle_is_a_torus() {
    let ring = closed(48, |angle| DVec3::new(libm::cos(angle), libm::sin(angle), 0.0));
    let torus = field("torus = 1\ntube = 0.25");
    for turn in [0, 77, 360] {
        let swept = field(&format!("sweep = {{ circle = 0.25 }}\nclosed_path = {ring}\nturn = {turn}"));
        let size = swept.bounding_box().expect("it ends").size();
        // A cell of the section's outline, a sixteenth of its width, may be more on each side, and turned.
        let more = size - DVec3::new(2.5, 2.5, 0.5);
        assert!(more.min_element() > -1e-4 && more.max_element() < 0.5 / 16.0 * 2.0 * 1.5, "{size}");
        let mut samples = Samples::new(8);
        let mut near = 0;
        for _ in 0..2000 {
            let p = samples.within(&Aabb::new(DVec3::splat(-1.3), DVec3::splat(1.3)));
            let (found, wanted) = (swept.reference(p), torus.reference(p));
            if wanted.abs() < 0.06 {
                assert!((found - wanted).abs() < 1e-4, "{found}, {wanted} at {p}");
                near += 1;
            }
            assert!(wanted.abs() < 1e-4 || (found > 0.0) == (wanted > 0.0), "{found}, {wanted} at {p}");
        }
        assert!(near > 50, "{near}");
    }
}

/// A bar along a trefoil, turned by a quarter on its way: across the place where the list of points begins, nothing jumps.
#[test]
fn a_closed_sweep_has_no_seam() {
    let trefoil = |angle: f64| {
        let across = 1.0 + 0.4 * libm::cos(3.0 * angle);
        DVec3::new(across * libm::cos(2.0 * angle), across * libm::sin(2.0 * angle), 0.4 * libm::sin(3.0 * angle))
    };
    for curve in ["smooth", "b_spline"] {
        let swept = field(&format!(
            "sweep = {{ rectangle = 0.2 }}\npath_curve = '{curve}'\nturn = 90\nclosed_path = {}",
            closed(40, trefoil)
        ));
        let mut samples = Samples::new(5);
        let mut inside = 0;
        for _ in 0..20_000 {
            let p = trefoil(0.0) + samples.within(&Aabb::new(DVec3::splat(-0.2), DVec3::splat(0.2)));
            let q = p + samples.within(&Aabb::new(DVec3::splat(-2e-4), DVec3::splat(2e-4)));
            let (first, second) = (swept.reference(p), swept.reference(q));
            // Far from the bar F is level.
            assert!(first < -0.03 || (first - second).abs() <= 3.0 * p.distance(q), "{first}, {second} at {p}, {q}");
            inside += usize::from(first > 0.0);
        }
        assert!(inside > 1000, "{inside}");
    }
}

#[test]
fn a_curve_of_a_file_is_that_of_the_list() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("way.csv");
    std::fs::write(&path, "x,y,z\n-1,0,0\n0,0.4,0.1\n1,0,0\n").unwrap();
    let bent = |points: &str| field(&format!("box = [0.2, 0.1, 1]\nbend_along = {points}"));
    let (listed, read) = (bent("[[-1, 0, 0], [0, 0.4, 0.1], [1, 0, 0]]"), bent(&format!("'{}'", path.display())));
    let mut samples = Samples::new(5);
    for _ in 0..200 {
        let p = samples.within(&Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)));
        assert_eq!(listed.reference(p), read.reference(p));
    }
}

/// Of a long straight line the flesh is as thick as it says.
#[test]
fn soft_objects_have_their_radii() {
    let line = field("convolution = [[-20, 0, 0], [20, 0, 0]]\nradius = 0.3\nkernel_width = 0.5");
    assert!(line.reference(DVec3::new(0.0, 0.3, 0.0)).abs() < 1e-4);
    let slope = slope_at(&line, DVec3::new(0.0, 0.3, 0.0), [1e-5, 1e-4]).unwrap();
    assert!((slope - DVec3::NEG_Y).length() < 1e-2, "{slope}");
    // Cut into pieces it is the same.
    let cut =
        field("convolution = [[-20, 0, 0], [-1, 0, 0], [0.3, 0, 0], [20, 0, 0]]\nradius = 0.3\nkernel_width = 0.5");
    assert!((cut.reference(DVec3::new(0.3, 0.2, 0.1)) - line.reference(DVec3::new(0.3, 0.2, 0.1))).abs() < 1e-9);
    let blob = field("blobby = [[0, 0, 0, 0.6]]\nblobbiness = 2");
    assert!(blob.reference(DVec3::X * 0.6).abs() < 1e-12);
}
