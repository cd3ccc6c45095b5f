//! Values as the buffers that OpenVDB has Blosc make of them, byte for byte: their bytes shuffled and compressed by LZ4; and
//! back, of any version of it.
//!
//! Blosc knows nothing of one buffer when it makes the next: for each leaf memory is asked for, and before each of a
//! leaf's four streams LZ4 clears a table of 16 KiB, which takes half the time of what follows. Here both stay.
//!
//! A buffer is its size and one of Blosc's chunks (`README_CHUNK_FORMAT.rst` of c-blosc 1.21): a head, where each block
//! starts, then the blocks' streams, each after its size. First come all values' first bytes, then all their second ones.
//! Current versions make one block, OpenVDB 3 made them of 256 bytes.

use lzzzz::lz4;

/// The bytes of a value.
const VALUE: usize = 4;
/// What Blosc does not split: streams of fewer bytes; and does not compress: fewer bytes in all.
const LEAST: usize = 128;
/// The size before a chunk, a chunk's head, and the start of one of its blocks.
const SIZE: usize = 8;
const HEAD: usize = 16;
const START: usize = 4;
/// The version of chunks, and that of LZ4's streams in them.
const VERSIONS: [u8; 2] = [2, 1];
const SHUFFLED: u8 = 1;
const COPIED: u8 = 1 << 1;
const BITS_SHUFFLED: u8 = 1 << 2;
const NOT_SPLIT: u8 = 1 << 4;
/// The place of the codec among the flags, and LZ4's.
const CODEC: u8 = 5;
const LZ4: u8 = 1;
/// The most bytes of a value that is split into streams.
const MOST_STREAMS: usize = 16;

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
        let mut flags = LZ4 << CODEC | SHUFFLED | if streams == 1 { NOT_SPLIT } else { 0 };
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

/// Why a chunk is not decompressed.
pub enum Problem {
    Damage(String),
    Unsupported(String),
}

/// Checks the head of a chunk that is to hold so many bytes.
pub fn check(chunk: &[u8], length: usize) -> Result<(), String> {
    if chunk.len() < HEAD {
        return Err(format!("a Blosc buffer of {} bytes has no head", chunk.len()));
    }
    let [whole, block, packed] = [4, 8, 12].map(|at| number(chunk, at).unwrap_or(0));
    if chunk[0] == 0 || chunk[0] > VERSIONS[0] {
        return Err(format!("a Blosc buffer of version {}", chunk[0]));
    }
    if whole != length {
        return Err(format!("a Blosc buffer holds {whole} bytes, not {length}"));
    }
    if packed != chunk.len() {
        return Err(format!("a Blosc buffer takes {packed} bytes, not {}", chunk.len()));
    }
    if block == 0 || block > whole.max(1) {
        return Err(format!("a Blosc buffer of {whole} bytes in blocks of {block}"));
    }
    Ok(())
}

/// Decompresses a chunk whose head was checked into as many bytes as it holds. `memory` is of use again.
pub fn decompress(chunk: &[u8], memory: &mut Vec<u8>, out: &mut [u8]) -> Result<(), Problem> {
    let (flags, value) = (chunk[2], usize::from(chunk[3]));
    if flags & COPIED != 0 {
        if chunk.len() != HEAD + out.len() {
            return Err(Problem::Damage(format!(
                "a Blosc buffer of {} copied bytes has {}",
                out.len(),
                chunk.len() - HEAD
            )));
        }
        out.copy_from_slice(&chunk[HEAD..]);
        return Ok(());
    }
    if flags >> CODEC != LZ4 {
        let codec = ["BloscLZ", "", "Snappy", "zlib", "Zstandard"]
            .get(usize::from(flags >> CODEC))
            .unwrap_or(&"an unknown codec");
        return Err(Problem::Unsupported(format!(
            "it is compressed by Blosc with {codec}, and OpenVDB's files are with LZ4: save it again with OpenVDB"
        )));
    }
    if flags & BITS_SHUFFLED != 0 {
        let problem =
            "its bits are shuffled by Blosc, and those of OpenVDB's files are not: save it again with OpenVDB";
        return Err(Problem::Unsupported(problem.into()));
    }
    let damaged = || Problem::Damage("a Blosc buffer does not decompress".into());
    let block_size = number(chunk, 8).ok_or_else(damaged)?;
    for (index, block) in out.chunks_mut(block_size).enumerate() {
        let whole = block.len() == block_size;
        let split =
            flags & NOT_SPLIT == 0 && whole && (1..=MOST_STREAMS).contains(&value) && block_size / value >= LEAST;
        let streams = number(chunk, HEAD + START * index).and_then(|start| chunk.get(start..)).ok_or_else(damaged)?;
        let shuffled = flags & SHUFFLED != 0 && value > 1;
        memory.resize(block.len(), 0);
        let target = if shuffled { &mut memory[..] } else { &mut *block };
        unpack(streams, if split { value } else { 1 }, target).ok_or_else(damaged)?;
        if shuffled {
            unshuffle(memory, value, block);
        }
    }
    Ok(())
}

/// Decompresses a block's streams, of which all hold as many bytes; `None` where they do not.
fn unpack(mut streams: &[u8], count: usize, out: &mut [u8]) -> Option<()> {
    if !out.len().is_multiple_of(count) {
        return None;
    }
    for out in out.chunks_exact_mut(out.len() / count) {
        let (stream, rest) = streams.get(4..)?.split_at_checked(number(streams, 0)?)?;
        // What LZ4 does not make smaller is copied.
        if stream.len() == out.len() {
            out.copy_from_slice(stream);
        } else if stream.len() > out.len() || lz4::decompress(stream, out).ok()? != out.len() {
            return None;
        }
        streams = rest;
    }
    Some(())
}

/// A number of a chunk, of four bytes.
fn number(chunk: &[u8], at: usize) -> Option<usize> {
    chunk.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes) as usize)
}

/// Puts the bytes of each value together again; those that make no whole value stand at the end.
fn unshuffle(bytes: &[u8], value: usize, out: &mut [u8]) {
    let count = out.len() / value;
    let (whole, rest) = bytes.split_at(count * value);
    if value == VALUE {
        gather(whole, out);
    } else {
        for (byte, plane) in whole.chunks_exact(count.max(1)).enumerate() {
            plane.iter().enumerate().for_each(|(at, from)| out[at * value + byte] = *from);
        }
    }
    out[count * value..].copy_from_slice(rest);
}

/// The same for values of four bytes.
#[multiversion::multiversion(targets = "simd")]
fn gather(planes: &[u8], out: &mut [u8]) {
    let count = planes.len() / VALUE;
    let [first, second, third, fourth] = std::array::from_fn(|plane| &planes[plane * count..][..count]);
    for (i, value) in out.as_chunks_mut().0[..count].iter_mut().enumerate() {
        *value = [first[i], second[i], third[i], fourth[i]];
    }
}
