//! Frames computed and written as the program does it.

use std::path::Path;

use hfvdb::bake::{self, Bytes, Computed, FramePattern, Interrupt, Output, Record};
use hfvdb::scene::Prepared;
use hfvdb::vdb::{self, Compression, Frame, Grid};

/// Computes one frame with its colour.
pub fn compute(prepared: &Prepared, frame: i64) -> Computed {
    bake::compute_frame(prepared, frame, Bytes(u64::MAX), &Interrupt::default(), &|_| {})
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The frame's grids in OpenVDB's hands.
pub fn hand_over(computed: &Computed) -> vdb::Prepared {
    let mut grids = vec![Grid::level_set("surface", &computed.band)];
    grids.extend(computed.colour.iter().map(|colour| Grid::colour(&computed.band, colour)));
    vdb::prepare(&Frame { grids, ..Default::default() }).expect("a sound frame")
}

/// Computes and writes frames into a folder, in flight as `hfvdb bake` has them.
pub fn write(prepared: &Prepared, frames: &[i64], folder: &Path) -> Vec<Record> {
    let output = Output {
        pattern: FramePattern::new(&folder.join("ours.####.vdb"), "vdb").expect("a pattern"),
        half: Vec::new(),
        compression: Compression::Blosc,
        overwrite: true,
        allow_empty: false,
        max_memory: Bytes(u64::MAX),
        scene_hash: String::new(),
    };
    bake::bake(prepared, frames, &output, &Interrupt::default(), &|_| {}).unwrap_or_else(|error| panic!("{error}"))
}
