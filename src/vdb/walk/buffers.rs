//! Buffers of values, compressed or not: the frames around them, not what is in them.

use super::CompressionFlags;
use super::cursor::{Cursor, Failure, damage};
use super::topology::{LEAF_MASK_BYTES, ValueKind};

/// Voxels in a leaf.
const LEAF_VOXELS: usize = 512;
/// The way to keep inactive values that leaves none out.
const ALL_VALUES: u8 = 6;
/// The head of a Blosc buffer, and the newest version of it that is known.
const BLOSC_HEAD: usize = 16;
const BLOSC_VERSION: u8 = 2;

/// Reads the buffers of all leaves, whose masks in the topology were `masks`.
pub fn read_leaves(
    cursor: &mut Cursor,
    kind: &ValueKind,
    compression: CompressionFlags,
    masks: &[&[u8]],
) -> Result<(), Failure> {
    for mask in masks {
        let at = cursor.at();
        if cursor.take(LEAF_MASK_BYTES)? != *mask {
            return damage(at, "a leaf's mask is not the one the tree gave");
        }
        if kind.bits {
            cursor.take(12 + LEAF_MASK_BYTES)?; // its origin and its bits
        } else {
            read_values(cursor, kind, compression, mask, LEAF_VOXELS)?;
        }
    }
    Ok(())
}

/// Reads a node's `count` values: a byte that says how inactive ones are kept, up to two inactive values, a mask that
/// chooses between them, and the stored values.
pub fn read_values(
    cursor: &mut Cursor,
    kind: &ValueKind,
    compression: CompressionFlags,
    value_mask: &[u8],
    count: usize,
) -> Result<(), Failure> {
    let at = cursor.at();
    let keeping = cursor.u8()?;
    let (inactive_values, selection) = match keeping {
        0 | 1 | ALL_VALUES => (0, false),
        2 => (1, false),
        3 => (0, true),
        4 => (1, true),
        5 => (2, true),
        other => return damage(at, format!("{other} is no way to keep inactive values")),
    };
    cursor.take(inactive_values * kind.bytes)?;
    if selection {
        cursor.take(count / 8)?;
    }
    let stored = if compression.active_mask && keeping != ALL_VALUES {
        value_mask.iter().map(|byte| byte.count_ones() as usize).sum()
    } else {
        count
    };
    // OpenVDB writes nothing at all for no half floats, and an empty frame for no floats.
    if kind.half && stored == 0 {
        return Ok(());
    }
    read_stored(cursor, compression, stored * kind.stored_bytes)
}

/// Reads stored values that take `length` bytes once they are decompressed.
fn read_stored(cursor: &mut Cursor, compression: CompressionFlags, length: usize) -> Result<(), Failure> {
    if !compression.blosc && !compression.zip {
        cursor.take(length)?;
        return Ok(());
    }
    let at = cursor.at();
    let size = cursor.i64()?;
    if size <= 0 {
        // Not worth compressing: stored as they are, the size negative.
        if size.unsigned_abs() != length as u64 {
            return damage(at, format!("a buffer has {} bytes, not {length}", size.unsigned_abs()));
        }
        cursor.take(length)?;
        return Ok(());
    }
    let frame = cursor.take(usize::try_from(size).unwrap_or(usize::MAX))?;
    if compression.blosc { check_blosc(frame, length, at) } else { Ok(()) }
}

fn check_blosc(frame: &[u8], length: usize, at: usize) -> Result<(), Failure> {
    if frame.len() < BLOSC_HEAD {
        return damage(at, format!("a Blosc buffer of {} bytes has no head", frame.len()));
    }
    let field = |place: usize| u32::from_le_bytes([frame[place], frame[place + 1], frame[place + 2], frame[place + 3]]);
    let (whole, block, packed) = (field(4) as usize, field(8) as usize, field(12) as usize);
    if frame[0] == 0 || frame[0] > BLOSC_VERSION {
        return damage(at, format!("a Blosc buffer of version {}", frame[0]));
    }
    if whole != length {
        return damage(at, format!("a Blosc buffer holds {whole} bytes, not {length}"));
    }
    if packed != frame.len() {
        return damage(at, format!("a Blosc buffer takes {packed} bytes, not {}", frame.len()));
    }
    if block == 0 || block > whole.max(1) {
        return damage(at, format!("a Blosc buffer of {whole} bytes in blocks of {block}"));
    }
    Ok(())
}
