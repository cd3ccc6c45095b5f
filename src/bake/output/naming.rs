//! The grids of a frame under the names and of the types by which a program finds them: vectors as three grids of numbers,
//! no level set where that would be taken for fog.

use std::collections::BTreeSet;

use crate::grid::Channel;
use crate::node::Model;
use crate::vdb::{Class, Content, Grid, Program, Three, Tiles, Values, VectorType};

/// A grid of vectors as three of numbers.
pub struct Split {
    channels: [Channel<f32>; 3],
    tiles: [Vec<f32>; 3],
}

/// What two grids of a scene would be called alike.
///
/// # Errors
/// In words.
pub fn check(model: &Model) -> Result<(), String> {
    let Some(program) = model.output.program else { return Ok(()) };
    let mut all = BTreeSet::new();
    for own in model.grid_names().into_iter().filter(|name| model.output.writes(name)) {
        for name in names(program, own, &model.output.colour_name) {
            if !all.insert(name) {
                let problem = format!("output.for = \"{}\": two grids would be called `{name}`", program.name);
                return Err(format!("{problem}; rename the attribute"));
            }
        }
    }
    Ok(())
}

/// Whether a grid of the scene is one of vectors, and stays one.
pub fn stays_vectors(model: &Model, own: &str) -> bool {
    let three = |program: &Program| match own {
        "vel" => program.velocity,
        _ => Some(program.colour),
    };
    (own == "vel" || own == model.output.colour_name)
        && !model.output.program.is_some_and(|program| matches!(three(program), Some(Three::Numbers(_))))
}

/// The names for a grid.
fn names<'a>(program: &Program, own: &'a str, colour: &str) -> Vec<&'a str> {
    let three = |three| match three {
        Three::Vectors(name) => vec![name],
        Three::Numbers(names) => names.to_vec(),
    };
    match own {
        "surface" => program.level_set.into_iter().collect(),
        "density" => vec![program.density],
        "vel" => program.velocity.map_or_else(Vec::new, three),
        _ if own == colour => match program.colour {
            Three::Vectors(_) => vec![own],
            numbers @ Three::Numbers(_) => three(numbers),
        },
        _ => vec![own],
    }
}

/// Those of the grids that a program takes as three each, so split, in their order.
pub fn splits(grids: &[Grid<'_>], program: &Program) -> Vec<Split> {
    grids.iter().filter_map(|grid| vectors(grid, program)).map(split).collect()
}

/// The values of a grid that is to be split.
fn vectors<'g, 'a>(grid: &'g Grid<'a>, program: &Program) -> Option<&'g Values<'a, [f32; 3]>> {
    let Content::Vectors { values, vector_type } = &grid.content else { return None };
    let three = if *vector_type == VectorType::Invariant { Some(program.colour) } else { program.velocity };
    matches!(three, Some(Three::Numbers(_))).then_some(values)
}

fn split(values: &Values<'_, [f32; 3]>) -> Split {
    let Values { channel, tiles, .. } = values;
    let part = |axis: usize| Channel {
        name: channel.name.clone(),
        values: channel.values.iter().map(|block| block.iter().map(|vector| vector[axis]).collect()).collect(),
        background: channel.background[axis],
    };
    let tiles = |axis: usize| tiles.values.iter().map(|vector| vector[axis]).collect();
    Split { channels: [0, 1, 2].map(part), tiles: [0, 1, 2].map(tiles) }
}

/// Grids as a program looks for them.
pub fn named<'a>(grids: Vec<Grid<'a>>, program: &Program, colour: &str, splits: &'a [Split]) -> Vec<Grid<'a>> {
    let mut splits = splits.iter();
    let mut all = Vec::new();
    for grid in grids {
        let names = names(program, grid.name, colour);
        let Some(Values { blocks, tiles, .. }) = vectors(&grid, program) else {
            all.extend(names.first().map(|name| Grid { name, ..grid }));
            continue;
        };
        let Some(Split { channels, tiles: parts }) = splits.next() else { continue };
        for ((name, channel), part) in names.into_iter().zip(channels).zip(parts) {
            let tiles = Tiles { places: tiles.places, values: part };
            let values = Values { blocks: *blocks, channel, tiles };
            let mut number = Grid::new(name, Content::Floats { values, class: Class::Unknown });
            number.half = grid.half;
            number.metadata = grid.metadata.clone();
            // It is about vectors.
            number.metadata.remove("is_local_space");
            all.push(number);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::bake::output::{Format, Frame, vdb::Vdb};
    use crate::bake::{Bytes, Existing, Identity, Interrupt, Output, Sampling, Sequence, compute_frame};
    use crate::node::{Source, load};
    use crate::shot::PrepareOptions;
    use crate::text::{FramePattern, Overrides};
    use crate::vdb::{Client, Compression, Severity, lint};

    fn model(program: &str, more: &str) -> Arc<Model> {
        let text = format!(
            "frames = '1-3'\n[shape.a]\nsphere = 0.8\nmove = ['0.5*t', 0, 0]\ncolor = [0.2, '0.5 + 0.3*x', 0.7]\n\
             attribute.wear = 'x'\n{more}\n[output]\nfor = '{program}'\ngrids = ['surface', 'Cd', 'wear', 'vel']\n"
        );
        let source = Source::Text { name: "scene.toml".into(), text, folder: ".".into() };
        Arc::new(load(&source, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}")))
    }

    /// Each program's file is sound by its own check, and by nobody's name for another.
    #[test]
    fn each_program_finds_its_grids() {
        let folder = tempfile::tempdir().unwrap();
        for client in Client::all() {
            let program = client.program();
            let model = model(program.name, "");
            let options = PrepareOptions { resolution: Some(24), ..PrepareOptions::default() };
            let prepared = model.prepare(&options).unwrap();
            let path = folder.path().join(format!("{}.0002.vdb", program.name));
            let output = Output {
                identity: Identity::new(String::new(), Sampling::Resolution(24), 3.0, vec![], Compression::default()),
                sequence: Sequence { pattern: FramePattern::new(&path, &["vdb"]).unwrap() },
                format: &Vdb,
                compression: Compression::default(),
                existing: Existing::Refuse,
                allow_empty: false,
                max_memory: Bytes(u64::MAX),
            };
            Vdb.check(&model, &output).unwrap();
            let interrupt = Interrupt::default();
            let computed = compute_frame(&prepared, 2, 1, Bytes(u64::MAX), &interrupt, &|_| {}).unwrap();
            let frame = Frame { prepared: &prepared, number: 2, computed: &computed, output: &output };
            std::fs::write(&path, Vdb.encode(&frame).unwrap().pieces.concat()).unwrap();
            let found = lint(Path::new(&path), &[client]).unwrap();
            let (notes, wrong): (Vec<_>, Vec<_>) =
                found.findings.iter().partition(|finding| finding.severity == Severity::Note);
            assert!(wrong.is_empty(), "{wrong:#?}");
            assert_eq!(notes.len(), usize::from(program.not_verified.is_some()), "{notes:#?}");
            let mut wanted: Vec<&str> = ["surface", if program.shows_fog { "density" } else { "wear" }, "vel", "wear"]
                .into_iter()
                .chain([model.output.colour_name.as_str()])
                .flat_map(|own| names(program, own, &model.output.colour_name))
                .collect();
            wanted.sort_unstable();
            wanted.dedup();
            let mut grids = found.grids.clone();
            grids.sort_unstable();
            assert_eq!(grids, wanted, "{}", program.name);
        }
        // Another program's file is told of.
        let path = folder.path().join("blender.0002.vdb");
        for (client, told) in [(Client::VRay, 3), (Client::Houdini, 2), (Client::RenderMan, 3), (Client::Usd, 0)] {
            let found = lint(&path, &[client]).unwrap().findings;
            let warnings = found.iter().filter(|finding| finding.severity == Severity::Warning);
            assert_eq!(warnings.count(), told, "{found:#?}");
        }
    }

    #[test]
    fn two_grids_of_one_name_are_refused() {
        let problem = check(&model("vray", "attribute.Red = 'y'"));
        assert!(problem.is_ok(), "it is not written");
        let text = "[shape.a]\nsphere = 1\ncolor = 'red'\nattribute.Red = 'x'\n[output]\nfor = 'vray'\n";
        let source = Source::Text { name: "scene.toml".into(), text: text.into(), folder: ".".into() };
        let problem = check(&load(&source, &Overrides::default()).unwrap()).unwrap_err();
        assert!(problem.contains("two grids would be called `Red`"), "{problem}");
    }
}
