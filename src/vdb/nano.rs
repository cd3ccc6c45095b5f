//! A file of NanoVDB: the same grids in the layout that GPUs read. OpenVDB's own tree is made of each grid, one at a time,
//! with the values that a `.vdb` would hold, and turned by NanoVDB's own converter.
//!
//! A file is a header, what each grid is called and how long it is, and the grids (`nanovdb/util/IO.h`, version 32).
//! NanoVDB holds no metadata beside a grid's name, class and transform.

use std::path::Path;

use rayon::prelude::*;

use super::bridge::ffi;
use super::encode::Leaf;
use super::{Compression, Content, Error, Frame, Grid};
use crate::grid::{BLOCK_VOXELS, mask};

/// What a file begins with: "NanoVDB0".
const MAGIC: u64 = 0x304244566f6e614e;
/// The bytes of a file's header.
const HEADER: usize = 16;
/// The bytes of what stands there of each grid, before its name.
const OF_GRID: usize = 176;
/// The longest name that a grid has by itself.
const LONGEST_NAME: usize = 255;

/// Encodes a frame as the bytes of a NanoVDB file, in pieces. Numbers of half precision become codes of 16 bits over the range
/// of each leaf (`Fp16`); compression is that of whole grids.
///
/// # Errors
/// Those of [`encode`]; [`Error::Grid`] for vectors of half precision, which NanoVDB does not have, for names of more than 255
/// bytes, and where its converter fails.
pub fn encode_nano(frame: &Frame<'_>, compression: Compression) -> Result<Vec<Vec<u8>>, Error> {
    frame.check()?;
    let library = |error: cxx::Exception| Error::Library { message: error.what().into() };
    let mut file = ffi::new_nano_file(compression.codec()).map_err(library)?;
    let mut pieces = vec![Vec::new()];
    for grid in &frame.grids {
        let failed = |error: cxx::Exception| Error::grid(grid.name, error.what());
        let nano = converted(grid)?;
        let bytes = file.pin_mut().add(&nano).map_err(failed)?;
        drop(nano);
        pieces.push(bytes.as_bytes().to_vec());
    }
    pieces[0] = file.head().map_err(library)?.as_bytes().to_vec();
    Ok(pieces)
}

/// One grid as NanoVDB has it.
fn converted(grid: &Grid<'_>) -> Result<cxx::UniquePtr<ffi::Nano>, Error> {
    if grid.half && matches!(grid.content, Content::Vectors { .. }) {
        return Err(Error::grid(grid.name, "NanoVDB has no vectors of 16 bits: keep it in 32 bits"));
    }
    if grid.name.len() > LONGEST_NAME {
        return Err(Error::grid(grid.name, format!("NanoVDB takes names of {LONGEST_NAME} bytes at most")));
    }
    let failed = |error: cxx::Exception| Error::grid(grid.name, error.what());
    // The codes are made of the values as they are.
    let exact = Grid { half: false, ..grid.clone() };
    exact.check()?;
    let tree = exact.in_library(&all_values(&exact)?)?;
    ffi::to_nano(&tree, grid.half).map_err(failed)
}

/// The values of all voxels of a grid's blocks, as a file has them.
fn all_values(grid: &Grid<'_>) -> Result<Vec<f32>, Error> {
    let active = grid.blocks().active;
    let components = if matches!(grid.content, Content::Vectors { .. }) { 3 } else { 1 };
    let mut values = vec![0.0; active.len() * BLOCK_VOXELS * components];
    let blocks = values.par_chunks_exact_mut(BLOCK_VOXELS * components).enumerate();
    blocks.try_for_each_init(Leaf::default, |leaf, (block, out)| {
        match &grid.content {
            Content::LevelSet(band) => {
                let (inside, outside) = (-band.background(), band.background());
                let inactive = |distance: &f32| if *distance >= 0.0 { inside } else { outside };
                out.iter_mut().zip(&band.distances[block]).for_each(|(to, distance)| *to = inactive(distance));
            }
            Content::Floats { values, .. } => out.fill(values.channel.background),
            Content::Vectors { values, .. } => out.as_chunks_mut().0.fill(values.channel.background),
        }
        let (_, _, values) = leaf.fill(grid, block)?;
        for (place, value) in mask::places(&active[block]).zip(values.chunks_exact(components)) {
            out[place * components..][..components].copy_from_slice(value);
        }
        Ok::<(), Error>(())
    })?;
    Ok(values)
}

/// Checks that the bytes are a file as long as it says; `path` is for messages.
///
/// # Errors
/// [`Error::Damaged`].
pub fn read_back_nano(pieces: &[Vec<u8>], path: &Path) -> Result<(), Error> {
    let whole: u64 = pieces.iter().map(|piece| piece.len() as u64).sum();
    let damaged = |offset: u64| {
        let problem = "it is not as long as its header says".into();
        Error::Damaged { path: path.into(), offset, problem }
    };
    let head = pieces.first().map_or(&[][..], Vec::as_slice);
    let number = |at: usize, bytes: usize| {
        let bytes = head.get(at..at + bytes).ok_or_else(|| damaged(at as u64))?;
        Ok::<u64, Error>(bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    };
    if number(0, 8)? != MAGIC {
        return Err(damaged(0));
    }
    let (mut at, mut bytes) = (HEADER, 0);
    for _ in 0..number(12, 2)? {
        bytes += number(at + 8, 8)?;
        // The name's length stands after four sizes, type and class, two boxes and the voxel's size.
        at += OF_GRID + number(at + 136, 4)? as usize;
    }
    if at == head.len() && at as u64 + bytes == whole { Ok(()) } else { Err(damaged(at as u64)) }
}
