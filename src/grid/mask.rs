//! Flags of a block's voxels as bits, 64 at a time.

use glam::IVec3;

use super::{BLOCK_VOXELS, BlockMask};

/// The first voxel of each row along z.
const FIRST: u64 = 0x0101_0101_0101_0101;
/// No z at either end of a row: what a shift by a voxel may not carry into the next row.
const NOT_FIRST: u64 = !FIRST;
const NOT_LAST: u64 = !0x8080_8080_8080_8080;

/// Packs flags of 0 or 1. Inlined, so that it is compiled for its caller's vector width.
#[inline(always)]
pub fn pack(flags: &[u8; BLOCK_VOXELS]) -> BlockMask {
    pack_first(flags, BLOCK_VOXELS)
}

/// Packs so many flags and those up to the next multiple of 64; the others count as 0.
#[inline(always)]
pub fn pack_first(flags: &[u8; BLOCK_VOXELS], count: usize) -> BlockMask {
    // Row by row into bytes side by side: word by word the compiler gathers.
    let mut bytes = [0; BLOCK_VOXELS / 8];
    for (byte, flags) in bytes.iter_mut().zip(flags.as_chunks::<8>().0).take(count.next_multiple_of(64) / 8) {
        // Flag j, at bit 8j, goes to bit 56 + j by the factor's bit 7(8 − j).
        *byte = (u64::from_le_bytes(*flags).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8;
    }
    let (words, _) = bytes.as_chunks::<8>();
    std::array::from_fn(|x| u64::from_le_bytes(words[x]))
}

/// The flagged voxels with their 26 neighbours in the block.
pub fn dilated(mask: &BlockMask) -> BlockMask {
    let rows = mask.map(|word| word | (word & NOT_LAST) << 1 | (word & NOT_FIRST) >> 1);
    let layers = rows.map(|word| word | word << 8 | word >> 8);
    std::array::from_fn(|x| {
        let at = |x: usize| layers.get(x).copied().unwrap_or(0);
        layers[x] | at(x.wrapping_sub(1)) | at(x + 1)
    })
}

/// The flagged voxels with the 6 across their faces, in the block.
pub fn spread(mask: &BlockMask) -> BlockMask {
    std::array::from_fn(|x| {
        let (word, at) = (mask[x], |x: usize| mask.get(x).copied().unwrap_or(0));
        let (after, before) = ((word & NOT_LAST) << 1, (word & NOT_FIRST) >> 1);
        word | after | before | word << 8 | word >> 8 | at(x.wrapping_sub(1)) | at(x + 1)
    })
}

/// The flags of the 64 voxels at a face, such as `IVec3::NEG_X`: those that touch across two blocks' faces in the same
/// bits.
pub fn side(mask: &BlockMask, face: IVec3) -> u64 {
    let column = |by: u32, of: u64, wide: u32| {
        (0u32..).zip(mask).fold(0, |side, (x, word)| side | (word >> by & of) << (wide * x))
    };
    match face.to_array() {
        [-1, ..] => mask[0],
        [1, ..] => mask[7],
        [_, -1, _] => column(0, 0xFF, 8),
        [_, 1, _] => column(56, 0xFF, 8),
        [_, _, -1] => column(0, FIRST, 1),
        _ => column(7, FIRST, 1),
    }
}

/// The flags of the first so many voxels; the others count as 0.
pub fn first(mask: &BlockMask, count: usize) -> BlockMask {
    std::array::from_fn(|x| match count.saturating_sub(x << 6) {
        left @ 0..64 => mask[x] & !(u64::MAX << left),
        _ => mask[x],
    })
}

/// The places of the flagged voxels, in order.
pub fn places(mask: &BlockMask) -> impl Iterator<Item = usize> + use<> {
    mask.map(|word| word).into_iter().enumerate().flat_map(|(x, mut word)| {
        std::iter::from_fn(move || {
            (word != 0).then(|| {
                let bit = word.trailing_zeros() as usize;
                word &= word - 1;
                x << 6 | bit
            })
        })
    })
}

/// How many voxels are flagged.
pub fn count(mask: &BlockMask) -> usize {
    mask.iter().map(|word| word.count_ones() as usize).sum()
}

/// How many flagged voxels come before a place.
pub fn rank(mask: &BlockMask, place: usize) -> usize {
    let (word, bit) = (place >> 6, place & 63);
    let before: u32 = mask[..word].iter().map(|word| word.count_ones()).sum();
    (before + (mask[word] & !(u64::MAX << bit)).count_ones()) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::is_active;

    #[test]
    fn spreading_is_by_faces() {
        for flags in patterns() {
            let mask = pack(&flags);
            let spread = spread(&mask);
            for i in 0..BLOCK_VOXELS {
                let at = [(i >> 6) as i32, (i >> 3 & 7) as i32, (i & 7) as i32];
                let any = (0..6).any(|face| {
                    let mut at = at;
                    at[face / 2] += if face % 2 == 0 { 1 } else { -1 };
                    at.iter().all(|place| (0..8).contains(place))
                        && flags[(at[0] << 6 | at[1] << 3 | at[2]) as usize] == 1
                });
                assert_eq!(is_active(&spread, i), flags[i] == 1 || any);
            }
        }
    }

    #[test]
    fn sides_are_the_voxels_at_a_face() {
        for flags in patterns() {
            let mask = pack(&flags);
            for axis in 0..3 {
                for (sign, end) in [(-1, 0), (1, 7)] {
                    let side = side(&mask, IVec3::AXES[axis] * sign);
                    let at_end = |i: &usize| [i >> 6, i >> 3 & 7, i & 7][axis] == end;
                    let flagged = (0..BLOCK_VOXELS).filter(at_end).filter(|&i| flags[i] == 1).count();
                    assert_eq!(side.count_ones() as usize, flagged);
                    for other in (0..BLOCK_VOXELS).filter(at_end) {
                        let mut beyond = [0; BLOCK_VOXELS];
                        let across = [64, 8, 1][axis] * 7;
                        beyond[if sign == 1 { other - across } else { other + across }] = 1;
                        let touches = side & super::side(&pack(&beyond), -IVec3::AXES[axis] * sign) != 0;
                        assert_eq!(touches, flags[other] == 1);
                    }
                }
            }
        }
    }

    /// Voxels of a few blocks' worth of patterns, by a multiplicative hash.
    fn patterns() -> impl Iterator<Item = [u8; BLOCK_VOXELS]> {
        (1..40u32).map(|seed| {
            std::array::from_fn(|i| {
                u8::from((i as u32 + 1).wrapping_mul(seed.wrapping_mul(0x9e37_79b1)).is_multiple_of(1 + seed / 4))
            })
        })
    }

    #[test]
    fn packed_flags_are_the_flags() {
        for flags in patterns() {
            let mask = pack(&flags);
            let expected: Vec<usize> = (0..BLOCK_VOXELS).filter(|&i| flags[i] == 1).collect();
            assert!(expected.iter().all(|&i| is_active(&mask, i)));
            for count in [0, 1, 64, 65, 512] {
                let packed = (0..8).map(|x| if 64 * x < count { mask[x] } else { 0 });
                assert!(pack_first(&flags, count).into_iter().eq(packed));
            }
            assert_eq!(places(&mask).collect::<Vec<_>>(), expected);
            assert_eq!(count(&mask), expected.len());
            for place in 0..BLOCK_VOXELS {
                assert_eq!(rank(&mask, place), expected.iter().filter(|&&flagged| flagged < place).count());
            }
        }
    }

    #[test]
    fn dilation_reaches_the_neighbours_in_the_block_and_no_others() {
        for flags in patterns() {
            let at = |i: usize| [i >> 6, i >> 3 & 7, i & 7];
            let near = |a: usize, b: usize| (0..3).all(|axis| at(a)[axis].abs_diff(at(b)[axis]) <= 1);
            let expected = |i: usize| (0..BLOCK_VOXELS).any(|j| flags[j] == 1 && near(i, j));
            let grown = dilated(&pack(&flags));
            assert!((0..BLOCK_VOXELS).all(|i| is_active(&grown, i) == expected(i)));
        }
    }
}
