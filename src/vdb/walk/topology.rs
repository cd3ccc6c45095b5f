//! A tree without its voxels' values: root, two levels of internal nodes, masks of leaves.

use glam::IVec3;

use super::buffers::{self, StoredValues};
use super::cursor::{Cursor, Failure, damage};
use super::header::flag;
use super::{CompressionFlags, TreeLayout};

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

/// A tree as it stands in a file, without its leaves' values.
pub struct Tree<'a> {
    /// The value away from all else.
    pub background: &'a [u8],
    /// Tiles beside the uppermost nodes.
    pub tiles: Vec<RootTile<'a>>,
    /// Upper and lower nodes, each upper one before its lower ones.
    pub nodes: Vec<Node<'a>>,
    /// In the order in which their values follow.
    pub leaves: Vec<Leaf<'a>>,
}

/// A tile of the root.
pub struct RootTile<'a> {
    pub origin: IVec3,
    pub value: &'a [u8],
    pub active: bool,
}

/// An upper or a lower node.
pub struct Node<'a> {
    level: &'static Level,
    origin: IVec3,
    child_mask: &'a [u8],
    /// The places where its values are active.
    pub value_mask: &'a [u8],
    pub values: StoredValues<'a>,
}

/// A leaf: its origin and the mask of its active voxels.
pub struct Leaf<'a> {
    pub origin: IVec3,
    pub mask: &'a [u8],
}

/// Reads a tree up to its leaves' buffers.
pub fn read<'a>(cursor: &mut Cursor<'a>, kind: &ValueKind, compression: CompressionFlags) -> Result<Tree<'a>, Failure> {
    let at = cursor.at();
    if cursor.i32()? != 1 {
        return damage(at, "a tree has one buffer");
    }
    let background = cursor.take(kind.bytes)?;
    let counts_at = cursor.at();
    let (tiles, children) = (cursor.u32()? as usize, cursor.u32()? as usize);
    if tiles.saturating_mul(12).saturating_add(children.saturating_mul(12)) > cursor.remaining() {
        return damage(counts_at, format!("{tiles} tiles and {children} nodes do not fit into what follows"));
    }
    let tree = Tree { background, tiles: Vec::new(), nodes: Vec::new(), leaves: Vec::new() };
    let mut walk = Walk { cursor, kind, compression, tree };
    let mut places: Vec<[i32; 3]> = Vec::new();
    for _ in 0..tiles {
        let origin = walk.root_origin(&mut places)?;
        let value = walk.cursor.take(kind.bytes)?;
        let active = flag(walk.cursor, "the state of a tile")?;
        walk.tree.tiles.push(RootTile { origin, value, active });
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
    Ok(walk.tree)
}

struct Walk<'c, 'a, 'k> {
    cursor: &'c mut Cursor<'a>,
    kind: &'k ValueKind,
    compression: CompressionFlags,
    tree: Tree<'a>,
}

impl Walk<'_, '_, '_> {
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
            self.tree.leaves.push(Leaf { origin: LOWER.child_origin(origin, place), mask });
        }
        Ok(())
    }

    /// An internal node's masks and tiles; returns the places of its children.
    fn node(&mut self, level: &'static Level, origin: IVec3) -> Result<Vec<usize>, Failure> {
        let at = self.cursor.at();
        let child_mask = self.cursor.take(level.children() / 8)?;
        let value_mask = self.cursor.take(level.children() / 8)?;
        if child_mask.iter().zip(value_mask).any(|(child, value)| child & value != 0) {
            return damage(at, "a place is both a node and an active tile");
        }
        let values = buffers::read_values(self.cursor, self.kind, self.compression, value_mask, level.children())?;
        self.tree.nodes.push(Node { level, origin, child_mask, value_mask, values });
        Ok(set_bits(child_mask).collect())
    }
}

impl Node<'_> {
    /// The edge of its tiles in voxels.
    pub fn tile_edge(&self) -> i32 {
        self.level.child_edge
    }

    /// The places of its tiles among its values.
    pub fn tiles(&self) -> impl Iterator<Item = usize> {
        (0..self.level.children()).filter(|place| !is_set(self.child_mask, *place))
    }

    /// Where a tile stands.
    pub fn tile_origin(&self, place: usize) -> IVec3 {
        self.level.child_origin(self.origin, place)
    }
}

impl Tree<'_> {
    /// What it holds.
    pub fn layout(&self) -> TreeLayout {
        let mut layout = TreeLayout { leaves: self.leaves.len() as u64, ..TreeLayout::default() };
        self.tiles.iter().filter(|tile| tile.active).for_each(|tile| layout.add_active_tile(tile.origin, UPPER.edge));
        for node in &self.nodes {
            for place in set_bits(node.value_mask) {
                layout.add_active_tile(node.tile_origin(place), node.tile_edge());
            }
        }
        self.leaves.iter().for_each(|leaf| layout.add_leaf(leaf.origin, leaf.mask));
        layout
    }
}

impl TreeLayout {
    fn add_active_tile(&mut self, origin: IVec3, edge: i32) {
        self.active_tiles += 1;
        self.active_voxels += (edge as u64).pow(3);
        self.extend(origin, origin + IVec3::splat(edge - 1));
    }

    fn add_leaf(&mut self, origin: IVec3, mask: &[u8]) {
        let mut across = 0_u64; // which (y, z) are active at any x
        let (mut first, mut last) = (i32::MAX, i32::MIN);
        for (x, word) in (0..).zip(mask.chunks_exact(8)) {
            let word = u64::from_le_bytes(word.try_into().expect("chunks of eight"));
            self.active_voxels += u64::from(word.count_ones());
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
        let (least, greatest) = self.active_box.unwrap_or((low, high));
        self.active_box = Some((least.min(low), greatest.max(high)));
    }
}

/// Whether a mask's bit is set.
pub fn is_set(mask: &[u8], place: usize) -> bool {
    mask[place / 8] >> (place % 8) & 1 == 1
}

/// The places of the bits that are set, in order.
fn set_bits(mask: &[u8]) -> impl Iterator<Item = usize> {
    mask.iter().enumerate().filter(|(_, byte)| **byte != 0).flat_map(|(index, byte)| {
        let byte = *byte;
        (0..8).filter(move |bit| byte >> bit & 1 == 1).map(move |bit| index * 8 + bit)
    })
}
