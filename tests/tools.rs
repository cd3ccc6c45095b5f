//! The tools around scenes: nodes searched, first scenes, values at a place, grids of parameters, slices of F.

mod support;

use std::fs;

use support::{Workplace, json};

#[test]
fn nodes_are_searched_and_shown() {
    let place = Workplace::new();
    let all = place.hfvdb("nodes").ok().stdout;
    assert!(all.contains("Solids\n  sphere ") && all.contains("\n  gyroid "), "{all}");
    let one = place.hfvdb("nodes torus_knot").ok().stdout;
    for part in
        ["Takes    ", "Formula  F = ", "Picture  docs/images/nodes/torus_knot.png", "Keys beside it", "torus_knot = "]
    {
        assert!(one.contains(part), "{part}\n{one}");
    }
    assert!(place.hfvdb("nodes involute").ok().stdout.contains("\n  gear "), "texts are searched");
    let both = json(&place.hfvdb("nodes noise --json").ok().stdout);
    assert_eq!(both["nodes"].as_array().map(Vec::len), Some(2), "of colours and of numbers");
    place.hfvdb("nodes gyroyd").fails(1, &["did you mean `gyroid`"]);
}

#[test]
fn first_scenes_are_written_once() {
    let place = Workplace::new();
    for kind in ["shape", "morph", "meshes"] {
        assert_eq!(place.hfvdb(&format!("new {kind}.toml --kind {kind}")).ok().stdout, format!("{kind}.toml\n"));
        place.hfvdb(&format!("check {kind}.toml --no-estimate")).ok();
    }
    let text = fs::read(place.path("shape.toml")).unwrap();
    place.hfvdb("new shape.toml --kind morph").fails(1, &["shape.toml is there already and stays as it is"]);
    assert_eq!(fs::read(place.path("shape.toml")).unwrap(), text);
    place.hfvdb("new shape.txt").fails(2, &["ends in .toml"]);
    place.hfvdb("new none/shape.toml").fails(1, &["shape.toml"]);
}

#[test]
fn scenes_are_formatted_in_place() {
    let place = Workplace::new();
    place.write("a.toml", "[shape.s]\nsphere=1   # units\n");
    place.write("b.toml", "hfvdb = 1\n");
    place.write("bad.toml", "[shape.s]\nsphere = 1\nbox == 2\n");
    place.hfvdb("fmt --check a.toml b.toml").fails(1, &["1 file is not formatted: hfvdb fmt FILE formats it"]);
    let told = place.hfvdb("fmt a.toml b.toml bad.toml");
    told.fails(1, &["--> bad.toml:3:6"]);
    assert_eq!(told.stdout, "a.toml\n");
    assert_eq!(fs::read_to_string(place.path("a.toml")).unwrap(), "[shape.s]\nsphere = 1 # units\n");
    assert_eq!(fs::read_to_string(place.path("bad.toml")).unwrap(), "[shape.s]\nsphere = 1\nbox == 2\n");
    assert_eq!(place.hfvdb("fmt --check a.toml b.toml").ok().stdout, "");
    // What a link leads to is formatted; what is write-protected is not.
    place.write("far.toml", "a=1");
    std::os::unix::fs::symlink("far.toml", place.path("link.toml")).unwrap();
    place.hfvdb("fmt link.toml").ok();
    assert!(place.path("link.toml").is_symlink());
    assert_eq!(fs::read_to_string(place.path("far.toml")).unwrap(), "a = 1\n");
    place.write("kept.toml", "a=1");
    let mut permissions = fs::metadata(place.path("kept.toml")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(place.path("kept.toml"), permissions).unwrap();
    place.hfvdb("fmt kept.toml").fails(1, &["kept.toml: it is write-protected"]);
    place.hfvdb("fmt cubism").fails(1, &["hfvdb scenes cubism > cubism.toml"]);
    place.hfvdb("fmt none.toml").fails(1, &["there is no scene `none.toml`"]);
}

#[test]
fn a_place_is_probed() {
    let place = Workplace::new();
    place.write("two.toml", "[output]\nshape = 'u'\n[shape.u]\nunion = ['a', 'b']\n[shape.a]\nsphere = 1\ncolor = 'red'\n[shape.b]\nbox = 1\nmove = [3, 0, 0]\n");
    let told = place.hfvdb("probe two.toml 2 0 0").ok().stdout;
    assert!(told.contains("u (union)") && told.contains("  b (box)") && told.contains("distance 0.500000"), "{told}");
    let document = json(&place.hfvdb("probe two.toml -2 0 0 --json").ok().stdout);
    let union = &document["shapes"][0];
    // R₀ of −1 and −4.5, which is no distance; that of the ball is one.
    let joined = -5.5 + (1.0_f64 + 4.5 * 4.5).sqrt();
    assert!(union["value"].as_f64().is_some_and(|value| (value - joined).abs() < 1e-6), "{union}");
    assert!(union["distance"].is_null() && union["made_of"][0]["distance"] == 1.0, "{union}");
    assert_eq!(union["made_of"][0]["colour"][0].as_f64(), Some(1.0));
    place.hfvdb("probe two.toml 1 2").fails(2, &["3"]);
    place.hfvdb("probe two.toml 1 2 inf").fails(2, &["three numbers"]);
    // The two ends of a morph, at any frame.
    let ends = json(&place.hfvdb("probe cube-to-heart 0 0 0 --frame 12 --json").ok().stdout);
    assert_eq!(ends["shapes"].as_array().map(Vec::len), Some(2));
}

#[test]
fn parameters_make_a_grid() {
    let place = Workplace::new();
    place.write(
        "ball.toml",
        "[param]\nr = 1\ngap = 3\n[shape.s]\nunion = [{ sphere = 'r' }, { sphere = 0.5, move = ['gap', 0, 0] }]\n",
    );
    let made = place.hfvdb(
        "preview ball.toml --vary r=0.5,1 --vary gap=0,2,3 -o grid.png --csv grid.csv --size 48 --resolution 48",
    );
    assert_eq!(made.ok().stdout, "grid.png\ngrid.csv\n");
    let table = fs::read_to_string(place.path("grid.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 7, "{table}");
    assert_eq!(rows[0], ["frame", "volume", "area", "pieces", "change", "change_of_shape"]);
    assert_eq!((rows[1][0], rows[1][3]), ("r=0.5 gap=0", "1"));
    assert_eq!((rows[6][0], rows[6][3]), ("r=1 gap=3", "2"));
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
    let exact = 4.0 * std::f64::consts::PI * (1.0 + 0.25);
    assert!((number(6, 2) / exact - 1.0).abs() < 0.02, "{}", number(6, 2));
    assert!((number(6, 1) / (4.0 / 3.0 * std::f64::consts::PI * 1.125) - 1.0).abs() < 0.02);
    place.hfvdb("preview ball.toml --vary r=1,0 -o grid.png").fails(1, &["r=0", "greater than 0"]);
    place.hfvdb("preview ball.toml --vary r -o grid.png").fails(2, &["NAME=VALUE"]);
    place.hfvdb("preview ball.toml --vary r=1,2 --vary none=1 -o grid.png").fails(1, &["none"]);
}

#[test]
fn slices_of_f_go_beyond_the_band() {
    let place = Workplace::new();
    place.write("ball.toml", "[shape.s]\nsphere = 1\n");
    for what in ["f", "gradient"] {
        place.hfvdb(&format!("preview ball.toml --slice z=0 --slice-of {what} -o {what}.png --size 96")).ok();
    }
    place.hfvdb("preview ball.toml --slice-of f -o f.png").fails(2, &["--slice"]);
    place.hfvdb("bake ball.toml -o ball.vdb --resolution 24").ok();
    place
        .hfvdb("preview ball.vdb --slice z=0 --slice-of f -o f.png")
        .fails(2, &["what a scene knows", "--slice-of band"]);
}

/// Of 4³ pores all are closed; where they meet and come to the surface none is.
#[test]
fn closed_hollows_are_counted() {
    let place = Workplace::new();
    let pores = |radius: f64| format!("[shape.s]\nbox = 2\nfill = {{ pores = 0.5, radius = {radius}, jitter = 0 }}\n");
    place.write("closed.toml", pores(0.15));
    place.write("open.toml", pores(0.3));
    let closed = place.hfvdb("check closed.toml -v --resolution 64").ok().stdout;
    assert!(closed.contains("\n64 closed hollows in frame 1, "), "{closed}");
    let open = place.hfvdb("check open.toml -v --resolution 64").ok().stdout;
    assert!(open.contains("\nno closed hollows in frame 1\n"), "{open}");
    let document = json(&place.hfvdb("check closed.toml -v --resolution 64 --json").ok().stdout);
    assert_eq!(document["hollows"]["count"], 64);
    let exact = 64.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.15_f64.powi(3);
    let volume = document["hollows"]["volume"].as_f64().unwrap();
    assert!((volume / exact - 1.0).abs() < 0.05, "{volume} for {exact}");
    // Without being asked, and where there are no structures, nothing is baked for it.
    assert!(!place.hfvdb("check closed.toml --resolution 64").ok().stdout.contains("hollow"));
    assert!(!place.hfvdb("check sphere -v --resolution 64").ok().stdout.contains("hollow"));
}

/// The papers' objects have as many operations as the papers say, and each is checked.
#[test]
fn set_operations_are_counted() {
    let place = Workplace::new();
    for (scene, count) in [("bat", 14), ("treble-clef", 15), ("robot", 39)] {
        let text = place.hfvdb(&format!("check {scene} --resolution 32")).ok().stdout;
        assert!(text.contains(&format!("\n{count} set operations\n")), "{scene}: {text}");
    }
    let both = json(&place.hfvdb("check bat-to-robot --resolution 32 --json").ok().stdout);
    assert_eq!(both["set_operations"], 14 + 39);
    let none = place.hfvdb("check sphere --resolution 32").ok().stdout;
    assert!(!none.contains("set operation"), "{none}");
}

#[test]
fn usd_layers_refuse_what_they_cannot_name() {
    let place = Workplace::new();
    place.hfvdb("bake sphere -o m.0001.vdb --resolution 16").ok();
    fs::copy(place.path("m.0001.vdb"), place.path("m.0004.vdb")).unwrap();
    fs::copy(place.path("m.0001.vdb"), place.path("other.vdb")).unwrap();
    let told = place.hfvdb("usd m.####.vdb -o m.usda").ok();
    assert!(told.stderr.contains("no file for frames 2 to 3"), "{}", told.stderr);
    let text = fs::read_to_string(place.path("m.usda")).unwrap();
    assert!(text.contains("            4: @./m.0004.vdb@,\n"), "{text}");
    place.hfvdb("usd m.####.vdb -o m.usda").fails(1, &["m.usda", "--overwrite"]);
    place.hfvdb("usd m.0001.vdb -o m.usda --overwrite").ok();
    let text = fs::read_to_string(place.path("m.usda")).unwrap();
    assert!(text.contains("asset filePath = @./m.0001.vdb@") && !text.contains("timeSamples"), "{text}");
    for (arguments, code, problem) in [
        ("m.0001.vdb other.vdb -o a.usda", 2, "differ by more than a number"),
        ("m.0001.vdb -o a.usd", 2, "ends in .usda"),
        ("m.glb -o a.usda", 2, "usd takes .vdb files"),
        ("none.vdb -o a.usda", 1, "none.vdb"),
        ("n.####.vdb -o a.usda", 1, "there is no frame with such a name"),
        ("m.0001.vdb -o a.usda --fps 0", 2, "greater than 0"),
    ] {
        place.hfvdb(&format!("usd {arguments}")).fails(code, &[problem]);
    }
    place.write("broken.vdb", &text);
    place.hfvdb("usd broken.vdb -o a.usda").fails(1, &["broken.vdb"]);
    assert!(!place.path("a.usda").exists());
}

#[test]
fn usd_layers_have_the_unit_of_the_files() {
    let place = Workplace::new();
    let unit = |path: &str| {
        place.hfvdb(&format!("usd {path} -o unit.usda --overwrite")).ok();
        let text = fs::read_to_string(place.path("unit.usda")).unwrap();
        text.lines().find_map(|line| line.strip_prefix("    metersPerUnit = ").map(str::to_owned)).unwrap()
    };
    for (name, metres) in [("m", "1"), ("cm", "0.01"), ("in", "0.0254")] {
        place.write("ball.toml", format!("hfvdb = 1\nunit = \"{name}\"\n[shape.a]\nsphere = 80\n"));
        place.hfvdb(&format!("bake ball.toml --resolution 16 -o {name}.vdb")).ok();
        assert_eq!(unit(&format!("{name}.vdb")), metres);
    }
    // One of another maker, without a voxel.
    let maker = "import pyopenvdb as vdb; vdb.write('other.vdb', grids=[vdb.FloatGrid()])";
    place.run(std::process::Command::new("/usr/bin/python3").args(["-c", maker])).ok();
    assert_eq!(unit("other.vdb"), "1");
}

/// What is thinner than a voxel may have a surface and nothing inside: no program shows anything of it.
#[test]
fn frames_with_nothing_inside_are_empty() {
    let place = Workplace::new();
    place.write("thin.toml", "hfvdb = 1\n[shape.a]\nbox = [2, 2, 0.004]\nmove = [0, 0, 0.015]\n");
    for end in ["vdb", "glb"] {
        let bake = format!("bake thin.toml -o thin.{end} --resolution 64");
        place.hfvdb(&bake).fails(1, &["frame 1 is empty: all of it is thinner than a voxel", "--allow-empty"]);
        assert!(!place.path(&format!("thin.{end}")).exists());
    }
    let told = place.hfvdb("bake thin.toml -o thin.vdb --resolution 64 --allow-empty").ok();
    assert!(told.stderr.contains("nothing is inside at this voxel size"), "{}", told.stderr);
}

#[test]
fn what_keep_leaves_out_is_said() {
    let place = Workplace::new();
    place.write(
        "letters.toml",
        "hfvdb = 1\nframes = '1-3'\n[morph]\nfrom = 'two'\nto = 'ball'\nkeep = 'largest'\n[shape.two]\nunion = [{ sphere = 0.5, move = [-1, 0, 0] }, { sphere = 0.4, move = [1, 0, 0] }]\n[shape.ball]\nsphere = 0.6\n",
    );
    let told = place.hfvdb("bake letters.toml -o l.####.vdb --resolution 32 --frames 1").ok();
    // 0.4³ of 0.4³ + 0.5³, about.
    assert!(told.stderr.contains("`keep` or `min_piece` leaves out 1 piece, 3"), "{}", told.stderr);
}

#[test]
fn no_file_is_written_over_by_what_is_made_of_it() {
    let place = Workplace::new();
    place.hfvdb("bake sphere -o m.0001.vdb --resolution 16").ok();
    let before = fs::read(place.path("m.0001.vdb")).unwrap();
    for command in ["convert m.0001.vdb -o m.0001.vdb", "convert m.####.vdb -o ./m.####.vdb"] {
        place.hfvdb(&format!("{command} --overwrite")).fails(2, &["would be written over by what is made of it"]);
        assert_eq!(fs::read(place.path("m.0001.vdb")).unwrap(), before);
    }
}

/// A cube of fog that is just as dense as the threshold is solid.
#[test]
fn fog_at_its_threshold_is_solid() {
    let place = Workplace::new();
    let maker = "import pyopenvdb as vdb, numpy
grid = vdb.FloatGrid()
grid.copyFromArray(numpy.full((21, 21, 21), 0.5, dtype='float32'))
grid.name, grid.gridClass = 'density', vdb.GridClass.FOG_VOLUME
grid.transform = vdb.createLinearTransform(voxelSize=0.1)
vdb.write('fog.vdb', grids=[grid])";
    place.run(std::process::Command::new("/usr/bin/python3").args(["-c", maker])).ok();
    let told = json(&place.hfvdb("convert fog.vdb -o solid.vdb --json").ok().stdout);
    let volume = told["frames"][0]["volume"].as_f64().unwrap();
    // From the first to the last of its voxels' centres.
    assert!((volume - 8.0).abs() < 0.3, "{volume}");
}

#[test]
fn frames_that_are_not_asked_for_may_be_missing() {
    let place = Workplace::new();
    place.hfvdb("bake cube-to-heart -o s.####.vdb --resolution 16 --frames 1-5").ok();
    fs::remove_file(place.path("s.0004.vdb")).unwrap();
    place.hfvdb("convert s.####.vdb -o t.####.vdb --frames 1-3").ok();
    assert_eq!(place.frames(".").iter().filter(|name| name.starts_with('t')).count(), 3);
    place.hfvdb("convert s.####.vdb -o u.####.vdb --frames 3-5").fails(1, &["4"]);
}

/// A box that is known of a solid may be larger than it; what is bent along a curve reaches the ends of that all the same.
#[test]
fn what_is_bent_reaches_the_ends_of_its_curve() {
    let place = Workplace::new();
    let bend = "bend_along = [[0, 0, 0], [0, 0, 3]]";
    for shape in ["sphere = 0.5", "difference = [{ box = [1, 1, 2] }, { box = [2, 2, 0.6], move = [0, 0, 0.8] }]"] {
        place.write(
            "bent.toml",
            format!("hfvdb = 1\n[shape.a]\n{shape}\ndo = [{{ rotate = [0, 180, 0] }}, {{ {bend} }}]\n"),
        );
        let value = |z: f64| {
            let told = json(&place.hfvdb(&format!("probe bent.toml 0 0 {z} --json")).ok().stdout);
            told["shapes"][0]["value"].as_f64().unwrap()
        };
        for (end, inward) in [(0.0, 0.03), (3.0, -0.03)] {
            assert!(value(end + inward) > 0.0 && value(end - inward) < 0.0, "{shape} at {end}");
        }
    }
}
