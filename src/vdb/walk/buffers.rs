//! Values as they stand in a file: how inactive ones are kept, and the buffer of the others, compressed or not. Buffers are
//! checked from without; [`crate::vdb::decode`] looks into them.

use super::CompressionFlags;
use super::cursor::{Cursor, Failure, damage};
use super::topology::{LEAF_MASK_BYTES, ValueKind};
use crate::grid::BLOCK_VOXELS;
use crate::vdb::blosc;

/// The way to keep inactive values that leaves none out.
const ALL_VALUES: u8 = 6;

/// The values of a leaf, or of a node's tiles.
#[derive(Clone, Copy, Debug)]
pub struct StoredValues<'a> {
    /// What inactive values are where they are left out.
    pub inactive: [Inactive<'a>; 2],
    /// Which of them have the second of the two; empty where none has.
    pub selection: &'a [u8],
    /// Inactive values are left out of the buffer.
    pub active_only: bool,
    /// The other values.
    pub buffer: Buffer<'a>,
}

/// A value that a node keeps once for many of its inactive voxels.
#[derive(Clone, Copy, Debug)]
pub enum Inactive<'a> {
    Background,
    MinusBackground,
    Value(&'a [u8]),
}

/// Bytes of values.
#[derive(Clone, Copy, Debug)]
pub struct Buffer<'a> {
    /// Where it stands in the file.
    pub at: usize,
    pub packing: Packing,
    pub bytes: &'a [u8],
    /// How many bytes it is once decompressed.
    pub length: usize,
}

#[derive(Clone, Copy, Debug)]
pub enum Packing {
    Plain,
    Zip,
    Blosc,
}

/// Reads the values of a leaf whose mask in the topology was `mask`. A leaf of truth values is its origin and its bits.
pub fn read_leaf<'a>(
    cursor: &mut Cursor<'a>,
    kind: &ValueKind,
    compression: CompressionFlags,
    mask: &[u8],
) -> Result<StoredValues<'a>, Failure> {
    let at = cursor.at();
    if cursor.take(LEAF_MASK_BYTES)? != mask {
        return damage(at, "a leaf's mask is not the one the tree gave");
    }
    if kind.bits {
        cursor.take(12)?;
        let inactive = [Inactive::Background; 2];
        let buffer = read_plain(cursor, LEAF_MASK_BYTES)?;
        return Ok(StoredValues { inactive, selection: &[], active_only: false, buffer });
    }
    read_values(cursor, kind, compression, mask, BLOCK_VOXELS)
}

/// Reads a node's `count` values: a byte that says how inactive ones are kept, up to two inactive values, a mask that
/// chooses between them, and the stored values.
pub fn read_values<'a>(
    cursor: &mut Cursor<'a>,
    kind: &ValueKind,
    compression: CompressionFlags,
    value_mask: &[u8],
    count: usize,
) -> Result<StoredValues<'a>, Failure> {
    use Inactive::{Background, MinusBackground, Value};
    let at = cursor.at();
    let keeping = cursor.u8()?;
    let inactive = match keeping {
        0 | ALL_VALUES => [Background; 2],
        1 | 3 => [MinusBackground, Background],
        2 | 4 => [Value(cursor.take(kind.bytes)?), Background],
        5 => [Value(cursor.take(kind.bytes)?), Value(cursor.take(kind.bytes)?)],
        other => return damage(at, format!("{other} is no way to keep inactive values")),
    };
    let selection = if matches!(keeping, 3..=5) { cursor.take(count / 8)? } else { &[] };
    let active_only = compression.active_mask && keeping != ALL_VALUES;
    let stored = if active_only { value_mask.iter().map(|byte| byte.count_ones() as usize).sum() } else { count };
    // OpenVDB writes nothing at all for no half floats, and an empty frame for no floats.
    let buffer = if kind.half && stored == 0 {
        read_plain(cursor, 0)?
    } else {
        read_buffer(cursor, compression, stored * kind.stored_bytes)?
    };
    Ok(StoredValues { inactive, selection, active_only, buffer })
}

/// Reads stored values that take `length` bytes once they are decompressed.
fn read_buffer<'a>(
    cursor: &mut Cursor<'a>,
    compression: CompressionFlags,
    length: usize,
) -> Result<Buffer<'a>, Failure> {
    if !compression.blosc && !compression.zip {
        return read_plain(cursor, length);
    }
    let at = cursor.at();
    let size = cursor.i64()?;
    if size <= 0 {
        // Not worth compressing: stored as they are, the size negative.
        if size.unsigned_abs() != length as u64 {
            return damage(at, format!("a buffer has {} bytes, not {length}", size.unsigned_abs()));
        }
        return read_plain(cursor, length);
    }
    let bytes = cursor.take(usize::try_from(size).unwrap_or(usize::MAX))?;
    let packing = if compression.blosc {
        blosc::check(bytes, length).or_else(|problem| damage(at, problem))?;
        Packing::Blosc
    } else {
        Packing::Zip
    };
    Ok(Buffer { at, packing, bytes, length })
}

fn read_plain<'a>(cursor: &mut Cursor<'a>, length: usize) -> Result<Buffer<'a>, Failure> {
    let at = cursor.at();
    Ok(Buffer { at, packing: Packing::Plain, bytes: cursor.take(length)?, length })
}
