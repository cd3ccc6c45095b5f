//! A tree without its voxels' values: root, two levels of internal nodes, masks of leaves.

use glam::IVec3;

use super::cursor::{Cursor, Failure, damage};
use super::header::flag;
use super::{CompressionFlags, TreeLayout, buffers};

/// How one value is stored.
pub struct ValueKind {
    /// Bytes of a value where it stands alone: backgrounds, tiles, inactive values.
    pub bytes: usize,
    /// Bytes of a value in a buffer.
    pub stored_bytes: usize,
    /// Buffers hold half floats.
    pub half: bool,
    /// Leaves hold bits instead of values.
    pub bits: bool,
}

impl ValueKind {
    /// The values of a tree of the standard shape; `None` for others.
    pub fn of(tree_type: &str, half: bool) -> Option<Self> {
        let value = tree_type.strip_prefix("Tree_")?.strip_suffix("_5_4_3")?;
        let (bytes, half_bytes) = match value {
            "float" => (4, 2),
            "double" => (8, 2),
            "vec3s" => (12, 6),
            "vec3d" => (24, 6),
            "int32" => (4, 4),
            "int64" => (8, 8),
            "vec3i" => (12, 12),
            "bool" => (1, 1),
            _ => return None,
        };
        // Whole numbers know no half: the mark is kept, their size too.
        let half = half && half_bytes != bytes;
        Some(Self { bytes, stored_bytes: if half { half_bytes } else { bytes }, half, bits: value == "bool" })
    }
}

/// The levels of nodes: voxels along an edge, and along an edge of a child.
struct Level {
    edge: i32,
    child_edge: i32,
}

const UPPER: Level = Level { edge: 4096, child_edge: 128 };
const LOWER: Level = Level { edge: 128, child_edge: 8 };

impl Level {
    fn children_along(&self) -> i32 {
        self.edge / self.child_edge
    }

    fn children(&self) -> usize {
        (self.children_along() as usize).pow(3)
    }

    fn child_origin(&self, origin: IVec3, place: usize) -> IVec3 {
        let (along, place) = (self.children_along(), place as i32);
        origin + IVec3::new(place / (along * along), place / along % along, place % along) * self.child_edge
    }
}

/// A leaf's voxels, 64 to a word: word x, bit y·8 + z.
pub const LEAF_MASK_BYTES: usize = 64;

/// Reads a tree up to its leaves' buffers. Returns what it holds, and where each leaf's mask stands.
pub fn read<'a>(
    cursor: &mut Cursor<'a>,
    kind: &ValueKind,
    compression: CompressionFlags,
) -> Result<(TreeLayout, Vec<&'a [u8]>), Failure> {
    let at = cursor.at();
    if cursor.i32()? != 1 {
        return damage(at, "a tree has one buffer");
    }
    cursor.take(kind.bytes)?; // the background
    let counts_at = cursor.at();
    let (tiles, children) = (cursor.u32()? as usize, cursor.u32()? as usize);
    if tiles.saturating_mul(12).saturating_add(children.saturating_mul(12)) > cursor.remaining() {
        return damage(counts_at, format!("{tiles} tiles and {children} nodes do not fit into what follows"));
    }
    let mut walk = Walk { cursor, kind, compression, layout: TreeLayout::default(), leaves: Vec::new() };
    let mut places: Vec<[i32; 3]> = Vec::new();
    for _ in 0..tiles {
        let origin = walk.root_origin(&mut places)?;
        walk.cursor.take(kind.bytes)?;
        if flag(walk.cursor, "the state of a tile")? {
            walk.add_active_tile(origin, UPPER.edge);
        }
    }
    // Buffers follow in the order of the nodes' origins, and OpenVDB reads them in that order.
    let mut before: Option<[i32; 3]> = None;
    for _ in 0..children {
        let at = walk.cursor.at();
        let origin = walk.root_origin(&mut places)?;
        if before.is_some_and(|before| before >= origin.to_array()) {
            return damage(at, "nodes are out of order");
        }
        before = Some(origin.to_array());
        walk.upper(origin)?;
    }
    places.sort_unstable();
    if places.windows(2).any(|pair| pair[0] == pair[1]) {
        return damage(counts_at, "two nodes stand at one place");
    }
    Ok((walk.layout, walk.leaves))
}

struct Walk<'c, 'a, 'k> {
    cursor: &'c mut Cursor<'a>,
    kind: &'k ValueKind,
    compression: CompressionFlags,
    layout: TreeLayout,
    leaves: Vec<&'a [u8]>,
}

impl<'a> Walk<'_, 'a, '_> {
    fn root_origin(&mut self, places: &mut Vec<[i32; 3]>) -> Result<IVec3, Failure> {
        let at = self.cursor.at();
        let origin = IVec3::new(self.cursor.i32()?, self.cursor.i32()?, self.cursor.i32()?);
        if origin & IVec3::splat(UPPER.edge - 1) != IVec3::ZERO {
            return damage(at, format!("no node stands at {origin}"));
        }
        places.push(origin.to_array());
        Ok(origin)
    }

    fn upper(&mut self, origin: IVec3) -> Result<(), Failure> {
        for place in self.node(&UPPER, origin)? {
            self.lower(UPPER.child_origin(origin, place))?;
        }
        Ok(())
    }

    fn lower(&mut self, origin: IVec3) -> Result<(), Failure> {
        for place in self.node(&LOWER, origin)? {
            let mask = self.cursor.take(LEAF_MASK_BYTES)?;
            self.leaves.push(mask);
            self.layout.leaves += 1;
            self.add_leaf(LOWER.child_origin(origin, place), mask);
        }
        Ok(())
    }

    /// An internal node's masks and tiles; returns the places of its children.
    fn node(&mut self, level: &Level, origin: IVec3) -> Result<Vec<usize>, Failure> {
        let at = self.cursor.at();
        let child_mask = self.cursor.take(level.children() / 8)?;
        let value_mask = self.cursor.take(level.children() / 8)?;
        if child_mask.iter().zip(value_mask).any(|(child, value)| child & value != 0) {
            return damage(at, "a place is both a node and an active tile");
        }
        buffers::read_values(self.cursor, self.kind, self.compression, value_mask, level.children())?;
        for place in set_bits(value_mask) {
            self.add_active_tile(level.child_origin(origin, place), level.child_edge);
        }
        Ok(set_bits(child_mask).collect())
    }

    fn add_active_tile(&mut self, origin: IVec3, edge: i32) {
        self.layout.active_tiles += 1;
        self.layout.active_voxels += (edge as u64).pow(3);
        self.extend(origin, origin + IVec3::splat(edge - 1));
    }

    fn add_leaf(&mut self, origin: IVec3, mask: &[u8]) {
        let mut across = 0_u64; // which (y, z) are active at any x
        let (mut first, mut last) = (i32::MAX, i32::MIN);
        for (x, word) in (0..).zip(mask.chunks_exact(8)) {
            let word = u64::from_le_bytes(word.try_into().expect("chunks of eight"));
            self.layout.active_voxels += u64::from(word.count_ones());
            across |= word;
            if word != 0 {
                (first, last) = (first.min(x), x);
            }
        }
        if across == 0 {
            return;
        }
        let along_z = across.to_le_bytes().iter().fold(0_u8, |any, row| any | row);
        let low = IVec3::new(first, across.trailing_zeros() as i32 / 8, along_z.trailing_zeros() as i32);
        let high = IVec3::new(last, 7 - across.leading_zeros() as i32 / 8, 7 - along_z.leading_zeros() as i32);
        self.extend(origin + low, origin + high);
    }

    fn extend(&mut self, low: IVec3, high: IVec3) {
        let (least, greatest) = self.layout.active_box.unwrap_or((low, high));
        self.layout.active_box = Some((least.min(low), greatest.max(high)));
    }
}

/// The places of the bits that are set, in order.
fn set_bits(mask: &[u8]) -> impl Iterator<Item = usize> {
    mask.iter().enumerate().filter(|(_, byte)| **byte != 0).flat_map(|(index, byte)| {
        let byte = *byte;
        (0..8).filter(move |bit| byte >> bit & 1 == 1).map(move |bit| index * 8 + bit)
    })
}
