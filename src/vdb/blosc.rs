//! Values as the buffers that OpenVDB has Blosc make of them, byte for byte: their bytes shuffled and compressed by LZ4.
//!
//! Blosc knows nothing of one buffer when it makes the next: for each leaf memory is asked for, and before each of a
//! leaf's four streams LZ4 clears a table of 16 KiB, which takes half the time of what follows. Here both stay.
//!
//! A buffer is its size and one of Blosc's chunks (`README_CHUNK_FORMAT.rst` of c-blosc 1.21): a head, where the only
//! block starts, then streams, each after its size. First come all values' first bytes, then all their second ones.

use lzzzz::lz4;

/// The bytes of a value.
const VALUE: usize = 4;
/// What Blosc does not split: streams of fewer bytes; and does not compress: fewer bytes in all.
const LEAST: usize = 128;
/// The size before a chunk, a chunk's head, and the start of its only block.
const SIZE: usize = 8;
const HEAD: usize = 16;
const START: usize = 4;
/// The version of chunks, and that of LZ4's streams in them.
const VERSIONS: [u8; 2] = [2, 1];
/// LZ4, shuffled.
const FORMAT: u8 = 1 << 5 | 1;
const COPIED: u8 = 1 << 1;
const NOT_SPLIT: u8 = 1 << 4;

/// The most bytes that so many values take.
pub fn most_bytes(values: usize) -> usize {
    SIZE + HEAD + values * VALUE
}

/// Values after values, with the memory that takes.
#[derive(Default)]
pub struct Compressor {
    shuffled: Vec<u8>,
}

impl Compressor {
    /// Compresses values into `target`, which must have room for [`most_bytes`]; returns how many it took.
    pub fn compress(&mut self, values: &[f32], target: &mut [u8]) -> usize {
        let bytes = values.len() * VALUE;
        let (size, chunk) = target[..most_bytes(values.len())].split_at_mut(SIZE);
        let streams = if values.len() < LEAST { 1 } else { VALUE };
        let mut flags = FORMAT | if streams == 1 { NOT_SPLIT } else { 0 };
        let packed = if bytes < LEAST { None } else { self.pack(values, streams, chunk) };
        let taken = packed.unwrap_or_else(|| {
            flags |= COPIED;
            for (to, value) in chunk[HEAD..].as_chunks_mut().0.iter_mut().zip(values) {
                *to = value.to_le_bytes();
            }
            HEAD + bytes
        });
        chunk[..2].copy_from_slice(&VERSIONS);
        chunk[2] = flags;
        chunk[3] = VALUE as u8;
        chunk[4..8].copy_from_slice(&(bytes as u32).to_le_bytes());
        // The size of a block, of which there is one, or none of a byte.
        chunk[8..12].copy_from_slice(&(bytes.max(1) as u32).to_le_bytes());
        chunk[12..16].copy_from_slice(&(taken as u32).to_le_bytes());
        size.copy_from_slice(&(taken as i64).to_le_bytes());
        SIZE + taken
    }

    /// Fills a chunk after its head; where it ends, or none where copies of the values take no more than that.
    fn pack(&mut self, values: &[f32], streams: usize, chunk: &mut [u8]) -> Option<usize> {
        let bytes = values.len() * VALUE;
        self.shuffled.resize(bytes, 0);
        shuffle(values, &mut self.shuffled);
        chunk[HEAD..HEAD + START].copy_from_slice(&((HEAD + START) as u32).to_le_bytes());
        let mut end = HEAD + START;
        for stream in self.shuffled.chunks_exact(bytes / streams) {
            end += 4;
            // As much room as Blosc gives, on which LZ4's giving up depends.
            let room = chunk.get_mut(end..)?;
            let limit = room.len().min(stream.len());
            let packed = match lz4::compress(stream, &mut room[..limit], lz4::ACC_LEVEL_DEFAULT) {
                Ok(packed) if packed < stream.len() => packed,
                _ => {
                    room.get_mut(..stream.len())?.copy_from_slice(stream);
                    stream.len()
                }
            };
            chunk[end - 4..end].copy_from_slice(&(packed as u32).to_le_bytes());
            end += packed;
        }
        Some(end)
    }
}

/// All values' first bytes, all their second ones, and so on.
#[multiversion::multiversion(targets = "simd")]
fn shuffle(values: &[f32], out: &mut [u8]) {
    let (first, rest) = out.split_at_mut(values.len());
    let (second, rest) = rest.split_at_mut(values.len());
    let (third, fourth) = rest.split_at_mut(values.len());
    for (i, value) in values.iter().enumerate() {
        [first[i], second[i], third[i], fourth[i]] = value.to_le_bytes();
    }
}
