//! From a tree that was walked to blocks: buffers decompressed, inactive values put back, half floats widened; leaves on all
//! threads.
//!
//! Each buffer is decompressed into the bytes that its values take, no more and no fewer, so a file takes memory by its leaves
//! and nodes, which it has to have, and never by what its buffers say.

use std::ops::Neg;

use rayon::prelude::*;

use super::read::{SparseBlocks, Tile};
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

            fn of_bytes(bytes: &[u8]) -> Self {
                Self::from_le_bytes(bytes.try_into().expect("the bytes of a number"))
            }

            fn of_f32(number: f32) -> Self {
                number.into()
            }

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
    fn of([number]: [f32; 1]) -> Self {
        number
    }
}

impl Value<3> for [f32; 3] {
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
    let decoder = Decoder::<C, N> { half: grid.half, background: alone(tree.background) };
    let put = |value: [C; N]| {
        let number = |component: C| if flip { flip_sign(component.to_f32()) } else { component.to_f32() };
        T::of(value.map(number))
    };

    let mut tiles = Vec::new();
    let says_something = |value: [C; N], active| active || value != decoder.background;
    for &RootTile { origin, value, active } in &tree.tiles {
        if says_something(alone(value), active) {
            tiles.push(Tile { origin, edge: ROOT_TILE, value: put(alone(value)), active });
        }
    }
    let mut memory = Memory::default();
    for node in &tree.nodes {
        let values = decoder.values(&node.values, node.value_mask, &mut memory)?;
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
    let decoded = leaves.map_init(Memory::default, |memory, ((block, stored), leaf)| {
        let values = decoder.values(stored, leaf.mask, memory)?;
        block.iter_mut().zip(values).for_each(|(to, value)| *to = put(*value));
        Ok(())
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

/// A value that stands alone, where it is never half a float.
fn alone<C: Component, const N: usize>(bytes: &[u8]) -> [C; N] {
    std::array::from_fn(|component| C::of_bytes(&bytes[component * C::BYTES..][..C::BYTES]))
}

/// What holds for all values of a grid.
struct Decoder<C, const N: usize> {
    half: bool,
    background: [C; N],
}

/// The memory of one node's values, and of what they are made of.
#[derive(Default)]
struct Memory<C, const N: usize> {
    values: Vec<[C; N]>,
    opened: Opened,
}

impl<C: Component, const N: usize> Decoder<C, N> {
    /// All values of a node whose active ones `mask` has.
    fn values<'m>(
        &self,
        stored: &StoredValues,
        mask: &[u8],
        memory: &'m mut Memory<C, N>,
    ) -> Result<&'m [[C; N]], Failure> {
        let Memory { values, opened } = memory;
        let bytes = opened.open(&stored.buffer)?;
        values.clear();
        values.resize(8 * mask.len(), self.background);
        let numbers = values.as_flattened_mut().iter_mut();
        if self.half {
            numbers.zip(bytes.as_chunks().0).for_each(|(to, half)| *to = C::of_f32(widened(u16::from_le_bytes(*half))));
        } else {
            numbers.zip(bytes.chunks_exact(C::BYTES)).for_each(|(to, bytes)| *to = C::of_bytes(bytes));
        }
        if stored.active_only {
            self.spread(stored, mask, values);
        }
        Ok(values)
    }

    /// Moves values from the front to where they are active, and puts the inactive ones between.
    fn spread(&self, stored: &StoredValues, mask: &[u8], values: &mut [[C; N]]) {
        let inactive = stored.inactive.map(|inactive| match inactive {
            Inactive::Background => self.background,
            Inactive::MinusBackground => self.background.map(Neg::neg),
            Inactive::Value(bytes) => alone(bytes),
        });
        let mut left: usize = mask.iter().map(|byte| byte.count_ones() as usize).sum();
        // From the end, so that none is overwritten before it was moved.
        for (row, active) in mask.iter().enumerate().rev() {
            let second = stored.selection.get(row).copied().unwrap_or(0);
            for bit in (0..8).rev() {
                values[8 * row + bit] = if active >> bit & 1 == 1 {
                    left -= 1;
                    values[left]
                } else {
                    inactive[usize::from(second >> bit & 1)]
                };
            }
        }
    }
}

/// A float of a half one. Numbers that are none keep their bits, as OpenVDB has them; processors change some.
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
struct Opened {
    bytes: Vec<u8>,
    shuffled: Vec<u8>,
}

impl Opened {
    /// A buffer's bytes, as many as it must have.
    fn open<'o>(&'o mut self, buffer: &Buffer<'o>) -> Result<&'o [u8], Failure> {
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
