//! The header of the file, metadata, and the head of each grid.

use super::cursor::{Cursor, Failure, damage};
use super::topology::ValueKind;
use super::{CompressionFlags, GridLayout, buffers, topology, transform};
use crate::vdb::{Metadata, MetadataValue};

/// The first four bytes of a file; four zeros follow.
const MAGIC: i64 = 0x5644_4220;
/// The formats that are read: from the one that made compression a matter of each grid, to OpenVDB 13's.
const FORMATS: std::ops::RangeInclusive<u32> = 222..=225;
/// Half-precision grids have this behind their type.
const HALF_SUFFIX: &str = "_HalfFloat";
/// Stands between a grid's name and the number that makes it unique in the file.
const NAME_SEPARATOR: char = '\u{1e}';

pub struct Header {
    pub format: u32,
    pub library: (u32, u32),
    /// Grids say where they begin and end.
    pub has_offsets: bool,
}

pub fn read(cursor: &mut Cursor) -> Result<Header, Failure> {
    if cursor.remaining() == 0 {
        return damage(0, "it is empty");
    }
    if cursor.remaining() < 8 || cursor.i64()? != MAGIC {
        return damage(0, "it is no OpenVDB file");
    }
    let format = cursor.u32()?;
    if !FORMATS.contains(&format) {
        return Err(Failure::Unsupported(format!(
            "format {format} is not read, only {} to {}: save it again with a current OpenVDB",
            FORMATS.start(),
            FORMATS.end()
        )));
    }
    let library = (cursor.u32()?, cursor.u32()?);
    let has_offsets = flag(cursor, "the flag for offsets")?;
    let identifier_at = cursor.at();
    let identifier = cursor.take(36)?;
    if !identifier.iter().all(|byte| byte.is_ascii_hexdigit() || *byte == b'-') {
        return damage(identifier_at, "the file's identifier is none");
    }
    Ok(Header { format, library, has_offsets })
}

/// A byte that is 0 or 1.
pub fn flag(cursor: &mut Cursor, what: &str) -> Result<bool, Failure> {
    let at = cursor.at();
    match cursor.u8()? {
        0 => Ok(false),
        1 => Ok(true),
        other => damage(at, format!("{what} is {other}, neither 0 nor 1")),
    }
}

/// Metadata of a file or a grid. Where values stand that are read late is left out: here all are read.
pub fn read_metadata(cursor: &mut Cursor) -> Result<Metadata, Failure> {
    let count = cursor.u32()?;
    let mut metadata = Metadata::new();
    for _ in 0..count {
        let key = cursor.string()?;
        let kind = cursor.string()?;
        let size = cursor.u32()? as usize;
        let value_at = cursor.at();
        let bytes = cursor.take(size)?;
        if fixed_size(&kind).is_some_and(|fixed| fixed != size) {
            return damage(value_at, format!("metadata '{key}' of type {kind} takes {size} bytes"));
        }
        if kind != "__delayedload" {
            metadata.insert(key, value(&kind, bytes));
        }
    }
    Ok(metadata)
}

/// The size of a value of a type, in bytes.
fn fixed_size(kind: &str) -> Option<usize> {
    Some(match kind {
        "bool" => 1,
        "int32" | "float" => 4,
        "int64" | "double" => 8,
        "vec2i" | "vec2s" => 8,
        "vec3i" | "vec3s" => 12,
        "vec2d" | "vec4i" | "vec4s" => 16,
        "vec3d" => 24,
        "vec4d" => 32,
        "mat3s" => 36,
        "mat3d" => 72,
        "mat4s" => 64,
        "mat4d" => 128,
        _ => return None,
    })
}

/// A value; what has no type of its own here becomes text.
fn value(kind: &str, bytes: &[u8]) -> MetadataValue {
    let mut cursor = Cursor::new(bytes);
    let known = match kind {
        "string" => Some(MetadataValue::Text(String::from_utf8_lossy(bytes).into_owned())),
        "bool" => cursor.u8().ok().map(|byte| MetadataValue::Bool(byte != 0)),
        "int32" => cursor.i32().ok().map(MetadataValue::Int32),
        "int64" => cursor.i64().ok().map(MetadataValue::Int64),
        "float" => cursor.u32().ok().map(|bits| MetadataValue::Float(f32::from_bits(bits))),
        "double" => cursor.f64().ok().map(MetadataValue::Double),
        _ => None,
    };
    known.unwrap_or_else(|| {
        let components: Vec<String> = match kind.as_bytes() {
            [b'v', b'e', b'c', _, b'i'] => bytes.chunks_exact(4).map(|c| i32_of(c).to_string()).collect(),
            [b'v', b'e', b'c', _, b's'] => {
                bytes.chunks_exact(4).map(|c| f32::from_bits(i32_of(c) as u32).to_string()).collect()
            }
            [b'v', b'e', b'c', _, b'd'] => {
                bytes.chunks_exact(8).filter_map(|c| Cursor::new(c).f64().ok()).map(|c| c.to_string()).collect()
            }
            _ => return MetadataValue::Text(format!("<{} bytes of type {kind}>", bytes.len())),
        };
        MetadataValue::Text(format!("[{}]", components.join(", ")))
    })
}

fn i32_of(bytes: &[u8]) -> i32 {
    Cursor::new(bytes).i32().unwrap_or_default()
}

pub fn read_grid(cursor: &mut Cursor, has_offsets: bool) -> Result<GridLayout, Failure> {
    let descriptor = cursor.at();
    let unique_name = cursor.string()?;
    let name = unique_name.split(NAME_SEPARATOR).next().unwrap_or_default().to_string();
    let full_type = cursor.string()?;
    let (tree_type, half) = match full_type.strip_suffix(HALF_SUFFIX) {
        Some(plain) => (plain.to_string(), true),
        None => (full_type, false),
    };
    let shares_tree_of = Some(cursor.string()?).filter(|parent| !parent.is_empty());
    let offsets_at = cursor.at();
    let (start, blocks, end) = (cursor.i64()?, cursor.i64()?, cursor.i64()?);
    let expect = |cursor: &Cursor, offset: i64, what: &str| match has_offsets && offset != cursor.at() as i64 {
        true => {
            damage(offsets_at, format!("{what} of grid '{name}' is said to be at {offset}, and is at {}", cursor.at()))
        }
        false => Ok(()),
    };
    expect(cursor, start, "the start")?;
    let compression = read_compression(cursor)?;
    let metadata = read_metadata(cursor)?;
    let transform = transform::read(cursor)?;
    let topology = cursor.at();
    let tree = if shares_tree_of.is_some() {
        None
    } else if let Some(kind) = ValueKind::of(&tree_type, half) {
        let tree = topology::read(cursor, &kind, compression)?;
        expect(cursor, blocks, "the first block")?;
        for leaf in &tree.leaves {
            buffers::read_leaf(cursor, &kind, compression, leaf.mask)?;
        }
        Some(tree.layout())
    } else if has_offsets {
        cursor.skip_to(blocks, &format!("the first block of grid '{name}'"))?;
        cursor.skip_to(end, &format!("the end of grid '{name}'"))?;
        None
    } else {
        return Err(Failure::Unsupported(format!(
            "grid '{name}' of type {tree_type} is not supported, and the file has no offsets to step over it: \
             save it again without that grid"
        )));
    };
    expect(cursor, end, "the end")?;
    Ok(GridLayout {
        name,
        unique_name,
        tree_type,
        half,
        shares_tree_of,
        compression,
        metadata,
        transform,
        tree,
        descriptor,
        topology,
    })
}

fn read_compression(cursor: &mut Cursor) -> Result<CompressionFlags, Failure> {
    let at = cursor.at();
    let flags = cursor.u32()?;
    if flags & !7 != 0 {
        return damage(at, format!("compression {flags:#x} is unknown"));
    }
    Ok(CompressionFlags { zip: flags & 1 != 0, active_mask: flags & 2 != 0, blosc: flags & 4 != 0 })
}
