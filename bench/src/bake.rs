//! Frames computed and written as the program does it.

use std::path::Path;

use hfvdb::bake::{self, Bytes, Computed, Existing, Identity, Interrupt, Output, Record, Sampling, Sequence, output};
use hfvdb::shot::Prepared;
use hfvdb::vdb::{Compression, Frame, Grid};

/// Computes one frame with its colour.
pub fn compute(prepared: &Prepared, frame: i64) -> Computed {
    bake::compute_frame(prepared, frame, 1, Bytes(u64::MAX), &Interrupt::default(), &|_| {})
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The frame's grids.
pub fn grids(computed: &Computed) -> Frame<'_> {
    let mut grids = vec![Grid::level_set("surface", &computed.band)];
    grids.extend(computed.colour.iter().map(|colour| Grid::colour(&computed.band, colour)));
    grids.extend(computed.scalars.iter().map(|scalar| Grid::scalar(&computed.band, scalar)));
    Frame { grids, ..Default::default() }
}

/// Computes and writes frames into a folder, in flight as `hfvdb bake` has them.
pub fn write(prepared: &Prepared, frames: &[i64], folder: &Path) -> Vec<Record> {
    let voxel_size = Sampling::VoxelSize(prepared.lattice.voxel_size.get());
    let compression = Compression::Blosc;
    let output = Output {
        sequence: Sequence { pattern: output::pattern(&folder.join("ours.####.vdb")).expect("a pattern") },
        format: output::FORMATS[0],
        identity: Identity::new(String::new(), voxel_size, f64::from(prepared.half_width), Vec::new(), compression),
        compression,
        existing: Existing::Overwrite,
        allow_empty: false,
        max_memory: Bytes(u64::MAX),
    };
    let baked = bake::bake(prepared, frames, &output, &Interrupt::default(), &|_| {});
    if let Some(error) = baked.stopped.or(baked.failed.into_iter().next().map(|(_, error)| error)) {
        panic!("{error}");
    }
    baked.written
}
