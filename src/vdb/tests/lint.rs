use super::support::*;
use crate::grid::*;
use crate::vdb::*;

/// What is wrong with a file of these grids: `error surface: …`.
fn findings(grids: Vec<Grid>) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file.vdb");
    write(&path, &Frame { grids, metadata: Metadata::new() }, &WriteOptions::default()).unwrap();
    let line = |finding: Finding| {
        let severity = if finding.severity == Severity::Error { "error" } else { "warning" };
        format!("{severity} {}: {}", finding.grid.unwrap_or_default(), finding.problem)
    };
    lint(&path).unwrap().findings.into_iter().map(line).collect()
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
}

#[test]
fn a_level_set_of_no_class() {
    let band = ball();
    let values = band.distances.iter().map(|block| block.map(|value| -value)).collect();
    let channel = Channel { name: "surface".into(), values, background: band.background() };
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
    let place = (0..BLOCK_VOXELS).find(|&place| is_active(&band.active[0], place)).unwrap();
    let file = |colour: &Channel<[f32; 3]>, wanted: &str| {
        only(vec![Grid::level_set("surface", &band), Grid::colour(&band, colour)], wanted);
    };
    file(&with(&|colour| colour.values[0][place] = [-0.1, 0.0, 0.0]), "error Cd: 1 colours have a negative channel");
    file(&with(&|colour| colour.values[0][place] = [0.1, 0.0, 9.0]), "warning Cd: 1 colours have a channel above 1");
    file(&with(&|colour| colour.background = [0.0; 3]), "warning Cd: its background is black");
    let mut fewer = band.clone();
    fewer.active[0] = [0; 8];
    let missing: u32 = band.active[0].iter().map(|word| word.count_ones()).sum();
    only(
        vec![Grid::level_set("surface", &band), Grid::colour(&fewer, &sound)],
        &format!("error Cd: {missing} active voxels of 'surface' have no active value here"),
    );
    let spaced = ball_colour(&band, "C d");
    only(
        vec![Grid::level_set("surface", &band), Grid::colour(&band, &spaced)],
        "warning C d: there is white space in its name",
    );
}
