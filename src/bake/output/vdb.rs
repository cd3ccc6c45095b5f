//! OpenVDB's own files: a level set with its attributes as grids.

use std::path::Path;

use rayon::prelude::*;

use super::{Encoded, Format, Frame, naming};
use crate::attribute::{LinearRgb, Primaries};
use crate::bake::{Computed, Error, Inside, Output, Velocities};
use crate::grid::{Band, Channel, Lattice};
use crate::node::Model;
use crate::vdb;
use crate::vdb::INTEROP_ID;

/// The format of `.vdb` files.
#[derive(Debug)]
pub struct Vdb;

impl Format for Vdb {
    fn extension(&self) -> &'static str {
        "vdb"
    }

    /// It holds all that frames have.
    fn check(&self, model: &Model, output: &Output) -> Result<(), String> {
        check_voxels(output)?;
        naming::check(model)
    }

    fn encode(&self, frame: &Frame<'_>) -> Result<Encoded, Error> {
        let encode = |grids: &vdb::Frame<'_>| vdb::encode(grids, frame.output.compression);
        let pieces = with_grids(frame, encode).map_err(|error| Error::Encode(error.to_string()))?;
        Ok(Encoded { pieces, polygons: None })
    }

    fn read_back(&self, pieces: &[Vec<u8>], path: &Path) -> Result<(), Error> {
        vdb::read_back(pieces, path).map_err(|error| Error::Encode(error.to_string()))
    }
}

/// What is asked of polygons alone.
pub(super) fn check_voxels(output: &Output) -> Result<(), String> {
    if output.identity.adaptivity > 0.0 {
        return Err(
            "--adaptivity: it merges polygons, and these are voxels; leave it out, or write .glb, .usda, .ply or .obj"
                .into(),
        );
    }
    Ok(())
}

/// Does something with a frame's grids as they go into a file.
pub(super) fn with_grids<R>(frame: &Frame<'_>, act: impl FnOnce(&vdb::Frame<'_>) -> R) -> R {
    let output = &frame.prepared.model().output;
    let colours = output.other_primaries();
    let colours = colours.map_or(Colours::Same, |primaries| Colours::in_primaries(frame.computed, primaries));
    let mut grids = grids(frame, &colours);
    if let Some(primaries) = output.primaries {
        for grid in grids.iter_mut().filter(|grid| grid.name == output.colour_name) {
            grid.metadata.insert(INTEROP_ID.into(), primaries.name().into());
        }
    }
    let splits = output.program.map_or_else(Vec::new, |program| naming::splits(&grids, program));
    if let Some(program) = output.program {
        grids = naming::named(grids, program, &output.colour_name, &splits);
    }
    act(&vdb::Frame { grids, metadata: metadata(frame) })
}

/// A frame's colours in the primaries of its file.
enum Colours {
    /// As they are.
    Same,
    /// Those of the band.
    Band(Channel<LinearRgb>),
    /// Those through the inside.
    Inside(Inside<LinearRgb>),
}

impl Colours {
    fn in_primaries(computed: &Computed, primaries: Primaries) -> Self {
        let converted = |channel: &Channel<LinearRgb>| Channel {
            name: channel.name.clone(),
            values: channel
                .values
                .par_iter()
                .map(|block| block.iter().map(|colour| primaries.of_rec709(*colour)).collect())
                .collect(),
            background: primaries.of_rec709(channel.background),
        };
        if let Some(inside) = computed.insides.as_ref().and_then(|insides| insides.colour.as_ref()) {
            let tile_values = inside.tile_values.iter().map(|colour| primaries.of_rec709(*colour)).collect();
            return Self::Inside(Inside {
                origins: inside.origins.clone(),
                active: inside.active.clone(),
                channel: converted(&inside.channel),
                tiles: inside.tiles.clone(),
                tile_values,
            });
        }
        computed.colour.as_ref().map_or(Self::Same, |colour| Self::Band(converted(colour)))
    }
}

fn grids<'a>(Frame { computed, output, .. }: &Frame<'a>, colours: &'a Colours) -> Vec<vdb::Grid<'a>> {
    let mut grids = vec![vdb::Grid::level_set("surface", &computed.band)];
    if let Some(insides) = &computed.insides {
        let lattice = computed.band.lattice;
        let fog = insides.density.iter().map(|density| (density, vdb::Class::FogVolume));
        let numbers = fog.chain(insides.scalars.iter().map(|scalar| (scalar, vdb::Class::Unknown)));
        grids.extend(numbers.map(|(inside, class)| {
            vdb::Grid::new(&inside.channel.name, vdb::Content::Floats { values: values(inside, lattice), class })
        }));
        let colour = if let Colours::Inside(colour) = colours { Some(colour) } else { insides.colour.as_ref() };
        grids.extend(colour.map(|inside| {
            let vector_type = vdb::VectorType::Invariant;
            vdb::Grid::new(&inside.channel.name, vdb::Content::Vectors { values: values(inside, lattice), vector_type })
        }));
    } else {
        let colour = if let Colours::Band(colour) = colours { Some(colour) } else { computed.colour.as_ref() };
        grids.extend(colour.map(|colour| vdb::Grid::colour(&computed.band, colour)));
        grids.extend(computed.scalars.iter().map(|scalar| vdb::Grid::scalar(&computed.band, scalar)));
    }
    if let Some(velocities) = &computed.velocities {
        grids.push(velocity_grid(&computed.band, velocities));
    }
    for grid in &mut grids {
        grid.half = output.identity.half.iter().any(|name| name == grid.name);
    }
    grids
}

fn values<T>(inside: &Inside<T>, lattice: Lattice) -> vdb::Values<'_, T> {
    let blocks = vdb::Blocks { lattice, origins: &inside.origins, active: &inside.active };
    let tiles = vdb::Tiles { places: &inside.tiles, values: &inside.tile_values };
    vdb::Values { blocks, channel: &inside.channel, tiles }
}

/// Velocities as OpenVDB has them: they turn and stretch with the object, and are not of its own space.
fn velocity_grid<'a>(band: &Band, velocities: &'a Velocities) -> vdb::Grid<'a> {
    let Velocities { origins, active, channel, .. } = velocities;
    let blocks = vdb::Blocks { lattice: band.lattice, origins, active };
    let values = vdb::Values { blocks, channel, tiles: vdb::Tiles::default() };
    let content = vdb::Content::Vectors { values, vector_type: vdb::VectorType::ContravariantRelative };
    let mut grid = vdb::Grid::new(&channel.name, content);
    grid.metadata.insert("is_local_space".into(), false.into());
    grid
}

/// Metadata of a file: nothing that depends on time, host, threads, path or other frames.
fn metadata(frame: &Frame<'_>) -> vdb::Metadata {
    let Frame { prepared, number, output, .. } = frame;
    let model = prepared.model();
    let mut metadata = vdb::Metadata::new();
    metadata.insert("creator".into(), output.identity.program.as_str().into());
    metadata.insert("hfvdb_scene".into(), output.identity.scene.as_str().into());
    // Frame numbers beyond 32 bits are refused when a scene is read.
    metadata.insert("hfvdb_frame".into(), i32::try_from(*number).unwrap_or(i32::MAX).into());
    metadata.insert("hfvdb_fps".into(), model.shot.fps.into());
    metadata.insert("hfvdb_unit".into(), model.unit.into());
    metadata.insert("hfvdb_up".into(), model.up.into());
    metadata
}
