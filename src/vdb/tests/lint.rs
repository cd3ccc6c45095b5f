use super::support::*;
use crate::grid::*;
use crate::vdb::*;

/// What is wrong with a file of these grids: `error surface: …`.
fn findings(grids: Vec<Grid>) -> Vec<String> {
    findings_for(grids, "file.vdb", &[])
}

/// The same for a file of a name, and some programs: `error blender surface: …`.
fn findings_for(grids: Vec<Grid>, name: &str, clients: &[Client]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write(&path, &Frame { grids, metadata: Metadata::new() }, &WriteOptions::default()).unwrap();
    let line = |finding: Finding| {
        let severity = match finding.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        let client = finding.client.map(|client| format!("{client} ")).unwrap_or_default();
        format!("{severity} {client}{}: {}", finding.grid.unwrap_or_default(), finding.problem)
    };
    lint(&path, clients).unwrap().findings.into_iter().map(line).collect()
}

/// The one thing that is wrong begins so.
#[track_caller]
fn only(grids: Vec<Grid>, wanted: &str) {
    let found = findings(grids);
    assert!(found.len() == 1 && found[0].starts_with(wanted), "{found:#?}");
}

#[test]
fn a_sound_file() {
    let band = ball();
    let colour = ball_colour(&band, "Cd");
    let half = |mut grid: Grid<'static>| {
        grid.half = true;
        grid
    };
    assert_eq!(findings(vec![Grid::level_set("surface", &band), Grid::colour(&band, &colour)]), [""; 0]);
    let (band, colour) = (&*Box::leak(Box::new(band)), &*Box::leak(Box::new(colour)));
    let grids = vec![half(Grid::level_set("surface", band)), half(Grid::colour(band, colour))];
    assert_eq!(findings(grids), [""; 0]);
}

#[test]
fn distances_that_are_none() {
    let with = |change: &dyn Fn(&mut Band)| {
        let mut band = ball();
        change(&mut band);
        band
    };
    let level_set = |band: &Band, wanted: &str| only(vec![Grid::level_set("surface", band)], wanted);
    let scaled = |band: &mut Band, by: f32| band.distances.iter_mut().flatten().for_each(|value| *value *= by);
    level_set(&with(&|band| band.inside_tiles.clear()), "error surface: the sign changes at ");
    level_set(
        &with(&|band| {
            scaled(band, 1.0 / VOXEL_SIZE as f32);
            band.half_width /= VOXEL_SIZE as f32;
        }),
        "error surface: the slope of its values is 12.58 away from 1 in the mean: they are in voxels",
    );
    level_set(
        &with(&|band| {
            scaled(band, 2.0);
            band.half_width = 6.0;
        }),
        "error surface: the slope of its values is 0.99 away from 1 in the mean: they are no distances",
    );
    level_set(&with(&|band| band.half_width = 200.0), "error surface: its background, 14, is 200 voxels wide");
    level_set(
        &with(&|band| band.half_width = 2.5),
        "warning surface: its band is 2.50 voxels wide on each side; tools expect 3",
    );
    let empty = with(&|band| {
        band.origins.clear();
        band.distances.clear();
        band.active.clear();
        band.inside_tiles.clear();
    });
    level_set(&empty, "warning surface: it is empty");
    // A skin that rounding has made: hardly anything of it is inside.
    let skin = with(&|band| {
        band.inside_tiles.clear();
        for value in band.distances.iter_mut().flatten() {
            *value = 0.02 * VOXEL_SIZE as f32 - value.abs();
        }
    });
    level_set(&skin, "error surface: nothing is inside: of all voxels the deepest lies ");
}

#[test]
fn a_level_set_of_no_class() {
    let band = ball();
    let blocks = band.distances.iter().map(|block| block.map(|value| -value));
    let channel = Channel::of_blocks("surface", &band.active, blocks, band.background());
    let content = Content::Floats { values: Values::over(&band, &channel), class: Class::Unknown };
    only(
        vec![Grid::new("surface", content)],
        "error surface: its values are those of a level set and its class is unknown",
    );
}

#[test]
fn colours_that_go_wrong() {
    let band = ball();
    let sound = ball_colour(&band, "Cd");
    let with = |change: &dyn Fn(&mut Channel<[f32; 3]>)| {
        let mut colour = sound.clone();
        change(&mut colour);
        colour
    };
    let file = |colour: &Channel<[f32; 3]>, wanted: &str| {
        only(vec![Grid::level_set("surface", &band), Grid::colour(&band, colour)], wanted);
    };
    file(&with(&|colour| colour.values[0][0] = [-0.1, 0.0, 0.0]), "error Cd: 1 colours have a negative channel");
    file(&with(&|colour| colour.values[0][0] = [0.1, 0.0, 9.0]), "warning Cd: 1 colours have a channel above 1");
    file(&with(&|colour| colour.background = [0.0; 3]), "warning Cd: its background is black");
    let mut fewer = band.clone();
    fewer.active[0] = [0; 8];
    let missing: u32 = band.active[0].iter().map(|word| word.count_ones()).sum();
    only(
        vec![Grid::level_set("surface", &band), Grid::colour(&fewer, &with(&|colour| colour.values[0] = [].into()))],
        &format!("error Cd: {missing} active voxels of 'surface' have no active value here"),
    );
    let spaced = ball_colour(&band, "C d");
    only(
        vec![Grid::level_set("surface", &band), Grid::colour(&band, &spaced)],
        "warning C d: there is white space in its name",
    );
}

#[test]
fn a_sound_file_serves_the_programs_that_show_surfaces() {
    let band = ball();
    let colour = ball_colour(&band, "Cd");
    let grids = || vec![Grid::level_set("surface", &band), Grid::colour(&band, &colour)];
    assert_eq!(findings_for(grids(), "m.0001.vdb", &[Client::Blender, Client::Houdini, Client::Usd]), [""; 0]);
    let found = findings_for(grids(), "m.0001.vdb", &[Client::Unreal]);
    let parts = ["warning unreal : it has no density", "note unreal : not verified: "];
    assert!(found.len() == 2 && found.iter().zip(parts).all(|(line, part)| line.starts_with(part)), "{found:#?}");
    let found = findings_for(grids(), "still.vdb", &[Client::Unreal]);
    assert!(found.len() == 3 && found[1].contains("imported as a still"), "{found:#?}");
    let found = findings_for(grids(), "m_0001_v2.vdb", &[Client::Blender]);
    assert!(found.len() == 1 && found[0].contains("read as 2, not 0001"), "{found:#?}");
}

/// A fog volume: the inside of the ball with its tiles, under a name.
fn fog<'a>(band: &'a Band, channel: &'a Channel<f32>, tiles: &'a [InsideTile]) -> Grid<'a> {
    let tiles = Tiles { places: tiles, values: &[1.0; 8][..tiles.len()] };
    let values = Values { tiles, ..Values::over(band, channel) };
    Grid::new(&channel.name, Content::Floats { values, class: Class::FogVolume })
}

#[test]
fn smoke_in_blender() {
    let band = ball();
    let (density, haze) = (even(&band, "density", 0.5), even(&band, "haze", 0.5));
    let colour = ball_colour(&band, "Cd");
    let for_blender = |grids| findings_for(grids, "m.1.vdb", &[Client::Blender]);
    assert!(!band.inside_tiles.is_empty(), "the ball is large enough for a tile");
    assert_eq!(for_blender(vec![fog(&band, &density, &[]), Grid::colour(&band, &colour)]), [""; 0]);
    let found = for_blender(vec![fog(&band, &haze, &[])]);
    assert!(found.len() == 1 && found[0].starts_with("warning blender haze: the default material"), "{found:#?}");
    let found = for_blender(vec![fog(&band, &density, &band.inside_tiles), Grid::colour(&band, &colour)]);
    assert!(found.len() == 1 && found[0].starts_with("error blender Cd: "), "{found:#?}");
    let mut resting = ball_colour(&band, "vel");
    resting.values.iter_mut().flat_map(|block| block.iter_mut()).for_each(|velocity| *velocity = [0.0, -0.0009, 0.0]);
    let vector_type = VectorType::ContravariantRelative;
    let vel = || Grid::new("vel", Content::Vectors { values: Values::over(&band, &resting), vector_type });
    let found = for_blender(vec![fog(&band, &density, &[]), vel()]);
    assert!(found.len() == 1 && found[0].contains("render.clipping = 0"), "{found:#?}");
    let mut dark = colour.clone();
    dark.values.iter_mut().flat_map(|block| block.iter_mut()).for_each(|colour| colour[2] = 0.0);
    let found = for_blender(vec![fog(&band, &density, &[]), Grid::colour(&band, &dark)]);
    assert!(found.len() == 1 && found[0].contains("volume_biased"), "{found:#?}");
}

#[test]
fn velocities_names_and_channels() {
    let band = ball();
    let vectors = |name: &str| ball_colour(&band, name);
    let (motion, colour) = (vectors("motion"), vectors("tint"));
    let velocity = |channel, vector_type| {
        Grid::new("motion", Content::Vectors { values: Values::over(&band, channel), vector_type })
    };
    let moving = VectorType::ContravariantRelative;
    let surface = || Grid::level_set("surface", &band);
    let found = findings_for(vec![surface(), velocity(&motion, moving)], "m.1.vdb", &[Client::Blender]);
    assert!(found.len() == 1 && found[0].contains("found by the names velocity, vel, v"), "{found:#?}");
    let mut fewer = band.clone();
    fewer.active[0] = [0; 8];
    let mut short_motion = motion.clone();
    short_motion.values[0] = [].into();
    let short = Content::Vectors { values: Values::over(&fewer, &short_motion), vector_type: moving };
    let found = findings_for(vec![surface(), Grid::new("vel", short)], "m.1.vdb", &[Client::Blender]);
    assert!(found.len() == 1 && found[0].contains("ends before 'surface' does"), "{found:#?}");
    let turned = Content::Vectors { values: Values::over(&band, &motion), vector_type: VectorType::Invariant };
    let found = findings_for(vec![surface(), Grid::new("vel", turned)], "m.1.vdb", &[Client::Houdini]);
    assert!(found.len() == 1 && found[0].contains("contravariant relative"), "{found:#?}");

    let mut named = Grid::level_set("my-shape", &band);
    named.metadata.insert("Some Key".into(), 1.into());
    let grids = || vec![named.clone(), Grid::colour(&band, &colour)];
    let found = findings_for(grids(), "m.1.vdb", &[Client::Houdini]);
    let parts = ["'Some Key'", "called `surface`", "called `Cd`"];
    assert!(found.len() == 3 && found.iter().zip(parts).all(|(line, part)| line.contains(part)), "{found:#?}");
    let found = findings_for(grids(), "m.1.vdb", &[Client::Usd]);
    assert!(found.len() == 1 && found[0].starts_with("error usd my-shape: "), "{found:#?}");

    let names = ["a", "b", "c"].map(vectors);
    let many = names.iter().map(|channel| Grid::colour(&band, channel)).collect();
    let found = findings_for(many, "m.1.vdb", &[Client::Blender, Client::Unreal]);
    assert!(found[0].starts_with("error blender : it has no grid of numbers"), "{found:#?}");
    assert!(found[1].contains("9 channels"), "{found:#?}");
    let parts = ["Cd.x", "Cd.y", "Cd.z"].map(|name| even(&band, name, 0.5));
    let split = parts.iter().map(|part| {
        Grid::new(&part.name, Content::Floats { values: Values::over(&band, part), class: Class::Unknown })
    });
    let found = findings_for(split.collect(), "m.1.vdb", &[Client::Blender]);
    assert!(found.len() == 1 && found[0].contains("one vector in three grids"), "{found:#?}");
}
