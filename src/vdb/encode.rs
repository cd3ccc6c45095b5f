//! A file's bytes: values go from their blocks straight into the compressor, on all threads, and no tree holds them in
//! between. The bytes are those of OpenVDB's own writer.
//!
//! A leaf in a file is the mask of its active voxels, a byte that says how inactive ones are kept, for some a second
//! mask, and the active values, compressed (`io/Compression.h` of OpenVDB).

use std::ops::Range;

use rayon::prelude::*;

use super::blosc;
use super::bridge::ffi;
use super::frame::check_half;
use super::metadata::to_bridge;
use super::{Compression, Content, Error, Frame, Grid, flip_sign};
use crate::grid::{BLOCK_VOXELS, Band, BlockMask, mask};

/// Leaves encoded in one go: so few that they stay in the cache, with their values where those are gathered first.
const LEAVES_A_PIECE: usize = 32;
/// The most a leaf takes besides its values: two masks, the byte between them, and what compressors put before and
/// after.
const LEAF_OVERHEAD: usize = 64 + 1 + 64 + 64;

/// How a leaf keeps its inactive values: they are all the background,
const BACKGROUND: i8 = 0;
/// all its negative,
const MINUS_BACKGROUND: i8 = 1;
/// or both, with a mask of those that are the background.
const BOTH: i8 = 3;

/// Encodes a frame as the bytes of a file, in pieces, on all threads.
///
/// # Errors
/// [`Error::Grid`] for blocks, tiles or values that make no grid, also a value that is not finite; [`Error::Library`]
/// when OpenVDB fails.
pub fn encode(frame: &Frame<'_>, compression: Compression) -> Result<Vec<Vec<u8>>, Error> {
    frame.check()?;
    let library = |error: cxx::Exception| Error::Library { message: error.what().into() };
    let mut writer = ffi::new_writer(compression.codec()).map_err(library)?;
    let grids = i32::try_from(frame.grids.len()).unwrap_or(i32::MAX);
    let head = writer.pin_mut().file_head(&to_bridge(&frame.metadata), grids).map_err(library)?;
    let mut pieces = vec![head.as_bytes().to_vec()];
    let mut position = pieces[0].len();
    let grids: Vec<_> = frame.grids.par_iter().map(|grid| encode_grid(grid, compression, &writer)).collect();
    for grid in grids {
        let (nodes, leaves) = grid?;
        let bytes: usize = leaves.pieces.iter().map(Vec::len).sum();
        let sizes = ffi::LeafSizes { masks: &leaves.masks, sizes: &leaves.sizes, bytes: bytes as i64 };
        let head = writer.grid_head(&nodes, &sizes, position as i64).map_err(library)?;
        position += head.len() + bytes;
        pieces.push(head.as_bytes().to_vec());
        pieces.extend(leaves.pieces);
    }
    Ok(pieces)
}

/// Leaves of a grid, encoded.
#[derive(Default)]
struct EncodedLeaves {
    pieces: Vec<Vec<u8>>,
    /// How each leaf keeps its inactive values.
    masks: Vec<i8>,
    /// The bytes of each leaf's compressed values.
    sizes: Vec<i64>,
}

/// A grid without what depends on where in the file it stands.
fn encode_grid(
    grid: &Grid<'_>,
    compression: Compression,
    writer: &ffi::Writer,
) -> Result<(cxx::UniquePtr<ffi::Nodes>, EncodedLeaves), Error> {
    grid.check()?;
    let failed = |error: cxx::Exception| Error::grid(grid.name, error.what());
    let nodes = |topology: &ffi::Grid| writer.nodes(topology).map_err(failed);
    let (nodes, leaves) = if compression == Compression::Blosc && !grid.half {
        // Nothing here waits for the tree that OpenVDB makes of the nodes.
        let piece = |run: &mut Run, mut leaves: Range<usize>| leaves.try_for_each(|block| run.compress(grid, block));
        rayon::join(|| nodes(&*grid.in_library(&[])?), || encode_leaves(grid, piece))
    } else {
        let topology = grid.in_library(&[])?;
        let piece = |run: &mut Run, mut leaves: Range<usize>| {
            leaves.try_for_each(|block| run.gather(grid, block))?;
            run.compress_gathered(&topology, writer).map_err(failed)
        };
        rayon::join(|| nodes(&topology), || encode_leaves(grid, piece))
    };
    Ok((nodes?, leaves?))
}

/// All leaves of a grid; `piece` puts a range of them into an empty run.
fn encode_leaves(
    grid: &Grid<'_>,
    piece: impl Fn(&mut Run, Range<usize>) -> Result<(), Error> + Sync,
) -> Result<EncodedLeaves, Error> {
    let blocks = grid.blocks().origins.len();
    let starts: Vec<usize> = (0..blocks).step_by(LEAVES_A_PIECE).collect();
    let encoded: Vec<EncodedLeaves> = starts
        .into_par_iter()
        .map_init(Run::default, |run, start| {
            piece(run, start..blocks.min(start + LEAVES_A_PIECE))?;
            Ok(run.take())
        })
        .collect::<Result<_, Error>>()?;
    let mut all = EncodedLeaves::default();
    for run in encoded {
        all.pieces.extend(run.pieces);
        all.masks.extend(run.masks);
        all.sizes.extend(run.sizes);
    }
    Ok(all)
}

/// A run of leaves on its way into one piece.
#[derive(Default)]
struct Run {
    masks: Vec<i8>,
    leaf: Leaf,
    gathered: Gathered,
    piece: Piece,
}

impl Run {
    /// Adds a leaf, its values compressed by Blosc's rules.
    fn compress(&mut self, grid: &Grid<'_>, block: usize) -> Result<(), Error> {
        let (flag, head, values) = self.leaf.fill(grid, block)?;
        self.piece.compress(head, values);
        self.masks.push(flag);
        Ok(())
    }

    /// Adds a leaf that is yet to be compressed.
    fn gather(&mut self, grid: &Grid<'_>, block: usize) -> Result<(), Error> {
        let (flag, head, values) = self.leaf.fill(grid, block)?;
        self.gathered.push(head, values);
        self.masks.push(flag);
        Ok(())
    }

    /// Compresses what was gathered in any way that OpenVDB knows.
    fn compress_gathered(&mut self, grid: &ffi::Grid, writer: &ffi::Writer) -> Result<(), cxx::Exception> {
        self.piece.compress_by_library(&self.gathered, grid, writer)?;
        self.gathered.clear();
        Ok(())
    }

    /// The leaves, which leaves the run empty.
    fn take(&mut self) -> EncodedLeaves {
        let (piece, sizes) = self.piece.take();
        EncodedLeaves { pieces: vec![piece], masks: std::mem::take(&mut self.masks), sizes }
    }
}

/// Leaves for OpenVDB to compress.
#[derive(Default)]
struct Gathered {
    heads: Vec<u8>,
    head_ends: Vec<usize>,
    values: Vec<f32>,
    value_ends: Vec<usize>,
}

impl Gathered {
    fn push(&mut self, head: &[u8], values: &[f32]) {
        self.heads.extend_from_slice(head);
        self.head_ends.push(self.heads.len());
        self.values.extend_from_slice(values);
        self.value_ends.push(self.values.len());
    }

    fn clear(&mut self) {
        self.heads.clear();
        self.head_ends.clear();
        self.values.clear();
        self.value_ends.clear();
    }
}

/// Compressed leaves, one after the other.
#[derive(Default)]
struct Piece {
    /// With room for more after the `end`.
    bytes: Vec<u8>,
    end: usize,
    /// The bytes of each leaf's compressed values.
    sizes: Vec<i64>,
    compressor: blosc::Compressor,
}

impl Piece {
    /// Adds a leaf by Blosc's rules.
    fn compress(&mut self, head: &[u8], values: &[f32]) {
        let start = self.end + head.len();
        self.make_room(start + blosc::most_bytes(values.len()));
        self.bytes[self.end..start].copy_from_slice(head);
        let size = self.compressor.compress(values, &mut self.bytes[start..]);
        self.sizes.push(size as i64);
        self.end = start + size;
    }

    /// Fills an empty piece.
    fn compress_by_library(
        &mut self,
        Gathered { heads, head_ends, values, value_ends }: &Gathered,
        grid: &ffi::Grid,
        writer: &ffi::Writer,
    ) -> Result<(), cxx::Exception> {
        self.make_room(head_ends.len() * LEAF_OVERHEAD + size_of_val(values.as_slice()));
        self.sizes.resize(head_ends.len(), 0);
        let leaves = ffi::Leaves { heads, head_ends, values, value_ends };
        self.end = writer.leaves(grid, &leaves, &mut self.sizes, &mut self.bytes)?;
        Ok(())
    }

    fn make_room(&mut self, bytes: usize) {
        if self.bytes.len() < bytes {
            self.bytes.resize(bytes, 0);
        }
    }

    /// The leaves and their sizes, which leaves it empty.
    fn take(&mut self) -> (Vec<u8>, Vec<i64>) {
        (self.bytes[..std::mem::take(&mut self.end)].to_vec(), std::mem::take(&mut self.sizes))
    }
}

/// What a leaf takes in a file, before its values are compressed.
#[derive(Default)]
pub(super) struct Leaf {
    /// All that stands before the values.
    head: Vec<u8>,
    /// The values, where they are not those of the grid as they are, with room for a whole block's.
    values: Vec<f32>,
}

impl Leaf {
    /// Takes a block in and checks its values: how it keeps its inactive ones, what stands before the others, and these.
    pub(super) fn fill<'a>(&'a mut self, grid: &'a Grid<'_>, block: usize) -> Result<(i8, &'a [u8], &'a [f32]), Error> {
        let Self { head, values: own } = self;
        head.clear();
        head.extend(grid.blocks().active[block].iter().flat_map(|word| word.to_le_bytes()));
        let (components, flag, values): (_, _, &[f32]) = match &grid.content {
            Content::LevelSet(band) => {
                own.resize(BLOCK_VOXELS, 0.0);
                let (flag, count) = put_distances(band, block, head, own);
                (1, flag, &own[..count])
            }
            Content::Floats { values, .. } => (1, BACKGROUND, &values.channel.values[block]),
            Content::Vectors { values, .. } => (3, BACKGROUND, values.channel.values[block].as_flattened()),
        };
        if flag != BOTH {
            head.push(flag as u8);
        }
        check_values(grid, block, values, components)?;
        Ok((flag, head, values))
    }
}

/// A level set's values, negative inside.
/// How a leaf keeps its inactive ones, and how many active ones stand at the front of `out`.
fn put_distances(band: &Band, block: usize, head: &mut Vec<u8>, out: &mut [f32]) -> (i8, usize) {
    let active = &band.active[block];
    let (count, inside) = flip_active(&band.distances[block], active, band.background(), out);
    let outside: BlockMask = std::array::from_fn(|word| !inside[word] & !active[word]);
    let any_inside = (0..8).any(|word| inside[word] & !active[word] != 0);
    let flag = match (outside != [0; 8], any_inside) {
        (_, false) => BACKGROUND,
        (false, true) => MINUS_BACKGROUND,
        (true, true) => {
            head.push(BOTH as u8);
            head.extend(outside.iter().flat_map(|word| word.to_le_bytes()));
            BOTH
        }
    };
    (flag, count)
}

/// Puts the active ones of a block's distances, as the file has them, limited to ± the background, at the front of
/// `out`. Returns how many they are, and which voxels lie inside. A zero becomes +0.
#[multiversion::multiversion(targets = "simd")]
fn flip_active(
    distances: &[f32; BLOCK_VOXELS],
    active: &BlockMask,
    background: f32,
    out: &mut [f32],
) -> (usize, BlockMask) {
    const ROW: usize = 8;
    let (mut count, mut inside) = (0, [0; BLOCK_VOXELS]);
    for (at, row) in distances.as_chunks::<ROW>().0.iter().enumerate() {
        let mut flipped = [0.0; ROW];
        for z in 0..ROW {
            flipped[z] = flip_sign(row[z]).clamp(-background, background);
            inside[ROW * at + z] = u8::from(row[z] >= 0.0);
        }
        let flags = active[at / ROW] >> (ROW * (at % ROW)) & 0xFF;
        if flags == 0xFF {
            out[count..count + ROW].copy_from_slice(&flipped);
            count += ROW;
        } else if flags != 0 {
            // Each is written to the next place, which only an active one takes up: no branch to guess.
            for (z, value) in flipped.into_iter().enumerate() {
                out[count] = value;
                count += (flags >> z & 1) as usize;
            }
        }
    }
    (count, mask::pack(&inside))
}

/// Refuses a number that is not finite, or that 16 bits do not hold where the grid has them.
fn check_values(grid: &Grid<'_>, block: usize, values: &[f32], components: usize) -> Result<(), Error> {
    let largest = largest(values);
    if largest.is_finite() && (!grid.half || check_half(largest).is_ok()) {
        return Ok(());
    }
    let is_bad = |value: &f32| !value.is_finite() || grid.half && check_half(*value).is_err();
    let Some(bad) = values.iter().position(is_bad) else { return Ok(()) };
    if values[bad].is_finite() {
        return check_half(values[bad]).map_err(|problem| Error::grid(grid.name, problem));
    }
    let blocks = grid.blocks();
    let place = mask::places(&blocks.active[block]).nth(bad / components).unwrap_or(0) as i32;
    let voxel = blocks.origins[block] + glam::IVec3::new(place >> 6, place >> 3 & 7, place & 7);
    let [x, y, z] = voxel.to_array();
    Err(Error::grid(grid.name, format!("it has a value that is not a finite number at voxel ({x}, {y}, {z})")))
}

/// The largest size of a number; not a number or infinite where one is.
#[multiversion::multiversion(targets = "simd")]
fn largest(values: &[f32]) -> f32 {
    // Sizes are ordered as the bits of their floats are, and what is no number comes last.
    let bits = values.iter().map(|value| value.to_bits() & (u32::MAX >> 1));
    f32::from_bits(bits.fold(0, u32::max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vdb::tests::support::{ball, ball_colour};

    /// Leaves of all numbers of values: even ones, smooth ones, ones that hold few numbers, and such as no compressor
    /// makes smaller, each with these components.
    fn leaves(components: usize) -> Vec<(Vec<u8>, Vec<f32>)> {
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1664525).wrapping_add(1013904223);
            seed >> 8
        };
        let mut leaf = |count: usize, kind: usize| {
            let head = (0..random() % 100).map(|byte| byte as u8).collect();
            let value = |at: usize| match kind {
                0 => 0.125,
                1 => (at as f32 * 0.02).sin(),
                2 => [0.25, 0.5, 0.75][random() as usize % 3],
                3 => f32::from_bits(random() | 0x3f00_0000),
                _ => f32::from_bits(random() << 8 | random() & 0xff),
            };
            (head, (0..count * components).map(value).collect())
        };
        (0..=512)
            .flat_map(|count| (0..5).map(move |kind| (count, kind)))
            .map(|(count, kind)| leaf(count, kind))
            .collect()
    }

    #[test]
    fn leaves_are_those_of_the_library() {
        let band = ball();
        let channel = ball_colour(&band, "Cd");
        let writer = ffi::new_writer(Compression::Blosc.codec()).unwrap();
        for (components, grid) in [(1, Grid::level_set("surface", &band)), (3, Grid::colour(&band, &channel))] {
            let (mut ours, mut theirs, mut gathered) = (Piece::default(), Piece::default(), Gathered::default());
            for (head, values) in leaves(components) {
                ours.compress(&head, &values);
                gathered.push(&head, &values);
            }
            theirs.compress_by_library(&gathered, &grid.in_library(&[]).unwrap(), &writer).unwrap();
            let ((our_bytes, our_sizes), (their_bytes, their_sizes)) = (ours.take(), theirs.take());
            assert_eq!(our_sizes, their_sizes);
            assert!(our_bytes == their_bytes);
        }
    }

    #[test]
    fn the_largest_size_is_that_of_any_number() {
        assert_eq!(largest(&[]), 0.0);
        assert_eq!(largest(&[-3.0, 2.0]), 3.0);
        for odd in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for at in 0..20 {
                let mut values = [1.0; 20];
                values[at] = odd;
                assert!(!largest(&values).is_finite());
            }
        }
    }

    #[test]
    fn active_distances_change_their_sign_and_keep_their_order() {
        let distances: [f32; BLOCK_VOXELS] = std::array::from_fn(|at| at as f32 - 200.0);
        let background = 150.0;
        for step in [1, 2, 3, 7, 64, 511] {
            let flags = std::array::from_fn(|at| u8::from(at % step == 0 || at / 9 % step == 1));
            let active = mask::pack(&flags);
            let mut out = [f32::NAN; BLOCK_VOXELS];
            let (count, inside) = flip_active(&distances, &active, background, &mut out);
            let expected = mask::places(&active).map(|at| (200.0 - at as f32).clamp(-background, background));
            assert!(out[..count].iter().map(|value| value.to_bits()).eq(expected.map(f32::to_bits)));
            assert!(mask::places(&inside).eq(200..BLOCK_VOXELS));
        }
    }
}
