//! From a tree that was walked to blocks: buffers decompressed, inactive values put back, half floats widened; leaves on all
//! threads.
//!
//! Each buffer is decompressed into the bytes that its values take, no more and no fewer, so a file takes memory by its leaves
//! and nodes, which it has to have, and never by what its buffers say.

use std::ops::Neg;
use std::slice::ChunksExact;

use rayon::prelude::*;

use super::voxels::{SparseBlocks, Tile};
use super::walk::{Buffer, Failure, GridLayout, Inactive, Packing, RootTile, StoredValues, damage, is_set, read_tree};
use super::{blosc, flip_sign};
use crate::grid::{BLOCK_VOXELS, block_order};

/// The edge of the root's tiles in voxels.
const ROOT_TILE: i32 = 4096;
/// Leaves that a thread takes at least: fewer cost scheduling.
const LEAVES_A_TASK: usize = 32;

/// A number as a file has it.
pub trait Component: Copy + Default + PartialEq + Neg<Output = Self> + Send + Sync {
    const BYTES: usize;
    /// Of so many bytes.
    fn of_bytes(bytes: &[u8]) -> Self;
    fn of_f32(number: f32) -> Self;
    fn to_f32(self) -> f32;
}

macro_rules! component {
    ($number:ty) => {
        impl Component for $number {
            const BYTES: usize = size_of::<Self>();

            #[inline]
            fn of_bytes(bytes: &[u8]) -> Self {
                Self::from_le_bytes(bytes.try_into().expect("the bytes of a number"))
            }

            #[inline]
            fn of_f32(number: f32) -> Self {
                number.into()
            }

            #[inline]
            fn to_f32(self) -> f32 {
                self as f32
            }
        }
    };
}
component!(f32);
component!(f64);

/// A value as it is handed on.
pub trait Value<const N: usize>: Copy + Default + Send + Sync {
    fn of(components: [f32; N]) -> Self;
}

impl Value<1> for f32 {
    #[inline]
    fn of([number]: [f32; 1]) -> Self {
        number
    }
}

impl Value<3> for [f32; 3] {
    #[inline]
    fn of(components: [f32; 3]) -> Self {
        components
    }
}

/// The voxels of a grid that has a tree of its own, whose values are `N` numbers of that type; `flip` turns all signs.
pub fn decode<C: Component, T: Value<N>, const N: usize>(
    bytes: &[u8],
    grid: &GridLayout,
    flip: bool,
) -> Result<SparseBlocks<T>, Failure> {
    let (tree, stored) = read_tree(bytes, grid)?;
    let decoder = Decoder::<C, N> { half: grid.half, background: whole(tree.background) };
    let put = |value: [C; N]| {
        let mut numbers = [0.0; N];
        for at in 0..N {
            let number = value[at].to_f32();
            numbers[at] = if flip { flip_sign(number) } else { number };
        }
        T::of(numbers)
    };

    let mut tiles = Vec::new();
    let says_something = |value: [C; N], active| active || value != decoder.background;
    for &RootTile { origin, value, active } in &tree.tiles {
        if says_something(whole(value), active) {
            tiles.push(Tile { origin, edge: ROOT_TILE, value: put(whole(value)), active });
        }
    }
    let mut unpacker = Unpacker::default();
    let mut values = Vec::new();
    for node in &tree.nodes {
        values.resize(8 * node.value_mask.len(), decoder.background);
        decoder.fill(&node.values, node.value_mask, &mut unpacker, |value| value, &mut values)?;
        for place in node.tiles() {
            let (value, active) = (values[place], is_set(node.value_mask, place));
            if says_something(value, active) {
                tiles.push(Tile { origin: node.tile_origin(place), edge: node.tile_edge(), value: put(value), active });
            }
        }
    }
    tiles.sort_by_cached_key(|tile| block_order(tile.origin));

    let mut values = vec![[T::default(); BLOCK_VOXELS]; stored.len()];
    let leaves = values.par_iter_mut().zip(&stored).zip(&tree.leaves).with_min_len(LEAVES_A_TASK);
    let decoded = leaves.map_init(Unpacker::default, |unpacker, ((block, stored), leaf)| {
        decoder.fill(stored, leaf.mask, unpacker, put, block)
    });
    if let Some(failure) = decoded.find_map_first(Result::err) {
        return Err(failure);
    }
    let word = |bytes: &[u8; 8]| u64::from_le_bytes(*bytes);
    let mask = |mask: &[u8]| std::array::from_fn(|x| word(&mask.as_chunks().0[x]));
    Ok(SparseBlocks {
        origins: tree.leaves.iter().map(|leaf| leaf.origin).collect(),
        values,
        active: tree.leaves.iter().map(|leaf| mask(leaf.mask)).collect(),
        tiles,
        background: put(decoder.background),
    })
}

/// A value of its components' bytes.
#[inline]
fn whole<C: Component, const N: usize>(bytes: &[u8]) -> [C; N] {
    let mut value = [C::default(); N];
    for at in 0..N {
        value[at] = C::of_bytes(&bytes[at * C::BYTES..][..C::BYTES]);
    }
    value
}

/// A value of its components' halves.
#[inline]
fn of_halves<C: Component, const N: usize>(bytes: &[u8]) -> [C; N] {
    let mut value = [C::default(); N];
    for at in 0..N {
        value[at] = C::of_f32(widened(u16::from_le_bytes([bytes[2 * at], bytes[2 * at + 1]])));
    }
    value
}

/// What holds for all values of a grid.
struct Decoder<C, const N: usize> {
    half: bool,
    background: [C; N],
}

impl<C: Component, const N: usize> Decoder<C, N> {
    /// All values of a node whose active ones `mask` has, as `put` makes them.
    fn fill<V: Copy>(
        &self,
        stored: &StoredValues,
        mask: &[u8],
        unpacker: &mut Unpacker,
        put: impl Fn([C; N]) -> V,
        out: &mut [V],
    ) -> Result<(), Failure> {
        let bytes = unpacker.unpack(&stored.buffer)?;
        let inactive = stored.inactive.map(|inactive| match inactive {
            Inactive::Background => put(self.background),
            Inactive::MinusBackground => put(self.background.map(Neg::neg)),
            Inactive::Value(bytes) => put(whole(bytes)),
        });
        let spread = Spread { stored, mask, inactive };
        if self.half {
            spread.over(bytes.chunks_exact(2 * N), |bytes| put(of_halves(bytes)), out);
        } else {
            spread.over(bytes.chunks_exact(C::BYTES * N), |bytes| put(whole(bytes)), out);
        }
        Ok(())
    }
}

/// Where a node's values go.
struct Spread<'s, V> {
    stored: &'s StoredValues<'s>,
    mask: &'s [u8],
    inactive: [V; 2],
}

impl<V: Copy> Spread<'_, V> {
    /// Puts values in order where they belong, and inactive ones between them.
    fn over<'b>(&self, mut values: ChunksExact<'b, u8>, put: impl Fn(&'b [u8]) -> V, out: &mut [V]) {
        if !self.stored.active_only {
            out.iter_mut().zip(values).for_each(|(to, value)| *to = put(value));
            return;
        }
        for (row, (out, active)) in out.as_chunks_mut::<8>().0.iter_mut().zip(self.mask).enumerate() {
            let second = self.stored.selection.get(row).copied().unwrap_or(0);
            if *active == u8::MAX {
                out.iter_mut().zip(&mut values).for_each(|(to, value)| *to = put(value));
                continue;
            }
            for (bit, to) in out.iter_mut().enumerate() {
                *to = self.inactive[usize::from(second >> bit & 1)];
            }
            let mut left = *active;
            while left != 0 {
                let Some(value) = values.next() else { return };
                out[left.trailing_zeros() as usize] = put(value);
                left &= left - 1;
            }
        }
    }
}

/// A float of a half one. Numbers that are none keep their bits, as OpenVDB has them; processors change some.
#[inline]
fn widened(half: u16) -> f32 {
    let (sign, size) = (u32::from(half & 0x8000) << 16, u32::from(half & 0x7fff) << 13);
    let size = if size >= 0x7c00 << 13 {
        size | 0x7f80_0000
    } else {
        // The exponent is 112 less than a float's, also where it is 0 and the number is exact in either.
        (f32::from_bits(size) * f32::from_bits((127 + 112) << 23)).to_bits()
    };
    f32::from_bits(size | sign)
}

/// Memory for a buffer that is decompressed.
#[derive(Default)]
struct Unpacker {
    bytes: Vec<u8>,
    shuffled: Vec<u8>,
}

impl Unpacker {
    /// A buffer's bytes, as many as it must have.
    fn unpack<'o>(&'o mut self, buffer: &Buffer<'o>) -> Result<&'o [u8], Failure> {
        if matches!(buffer.packing, Packing::Plain) {
            return Ok(buffer.bytes);
        }
        self.bytes.resize(buffer.length, 0);
        match buffer.packing {
            Packing::Blosc => match blosc::decompress(buffer.bytes, &mut self.shuffled, &mut self.bytes) {
                Ok(()) => {}
                Err(blosc::Problem::Damage(problem)) => return damage(buffer.at, problem),
                Err(blosc::Problem::Unsupported(problem)) => return Err(Failure::Unsupported(problem)),
            },
            _ => {
                let zipped = std::iter::once(buffer.bytes);
                let length = miniz_oxide::inflate::decompress_slice_iter_to_slice(&mut self.bytes, zipped, true, false);
                if length != Ok(buffer.length) {
                    return damage(
                        buffer.at,
                        format!("a zipped buffer does not hold the {} bytes it must", buffer.length),
                    );
                }
            }
        }
        Ok(&self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_widened_exactly() {
        for bits in 0..=u16::MAX {
            let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
            let size = match exponent {
                0 => fraction * 2f64.powi(-14),
                31 if bits & 1023 == 0 => f64::INFINITY,
                31 => f64::NAN,
                _ => (1.0 + fraction) * 2f64.powi(exponent - 15),
            };
            let value = widened(bits);
            assert_eq!(value.is_sign_negative(), bits >> 15 == 1, "{bits:x}");
            if size.is_nan() {
                assert_eq!((value.is_nan(), value.to_bits() >> 13 & 1023), (true, u32::from(bits & 1023)), "{bits:x}");
            } else {
                assert_eq!(f64::from(value.abs()), size, "{bits:x}");
            }
        }
    }
}
