//! Connected pieces of the solid.
//!
//! Voxels inside are joined across their faces. Two that touch along an edge only, with the two others around that
//! edge outside, are joined where the bilinear interpolation of the four joins them (the asymptotic decider: Nielson
//! and Hamann 1991), so that a thin slanted strut is one piece and two solids that come near each other are two.

use glam::IVec3;
use rayon::prelude::*;

use super::edges::{DIAGONALS, InsideRows};
use super::lookup::{Lookup, Place, Surroundings, local_of};
use crate::grid::{BLOCK_VOXELS, Band, BlockMask, FACES, is_active, mask};

/// The volumes of the solid's connected pieces, in cubic world units, the largest first; whole voxels are counted.
/// The number of pieces is the list's length.
pub fn pieces(band: &Band) -> Vec<f64> {
    Pieces::of(band).volumes(band)
}

/// The inside voxels of those pieces that `dropped` picks, block by block in the band's order, tiles after; `dropped` is
/// told a piece's rank (0 is the largest) and its volume in cubic world units.
pub fn voxels_of_pieces(band: &Band, mut dropped: impl FnMut(usize, f64) -> bool) -> Vec<(IVec3, BlockMask)> {
    let pieces = Pieces::of(band);
    let volumes = pieces.volumes(band);
    let drops: Vec<bool> = volumes.iter().enumerate().map(|(rank, &volume)| dropped(rank, volume)).collect();
    if !drops.contains(&true) {
        return Vec::new();
    }
    let mut voxels = Vec::new();
    for ((&origin, of_block), &first) in band.origins.iter().zip(&pieces.of_blocks).zip(&pieces.first_node) {
        let dropped = of_block.iter().zip(&pieces.rank[first..]).filter(|(_, rank)| drops[**rank]);
        let mask = dropped.map(|(voxels, _)| voxels).fold(BlockMask::default(), joined);
        if mask != BlockMask::default() {
            voxels.push((origin, mask));
        }
    }
    for (index, tile) in band.inside_tiles.iter().enumerate() {
        if drops[pieces.rank[pieces.first_tile + index]] {
            voxels.extend(tile.blocks().map(|block| (block, [u64::MAX; 8])));
        }
    }
    voxels
}

/// Which piece everything inside belongs to. Nodes are the pieces of single blocks, then the tiles.
pub(super) struct Pieces {
    /// The voxels of each piece, by block.
    of_blocks: Vec<Vec<BlockMask>>,
    first_node: Vec<usize>,
    first_tile: usize,
    /// Of each node: the rank of its piece.
    rank: Vec<usize>,
    /// Of each piece: its voxels, the most first.
    sizes: Vec<u64>,
}

impl Pieces {
    /// The rank of the piece that a tile belongs to.
    pub fn of_tile(&self, index: usize) -> usize {
        self.rank[self.first_tile + index]
    }

    /// As [`pieces`].
    pub fn volumes(&self, band: &Band) -> Vec<f64> {
        let cubed = band.lattice.voxel_size.get().powi(3);
        self.sizes.iter().map(|&size| size as f64 * cubed).collect()
    }

    /// Those of a band.
    pub fn of(band: &Band) -> Self {
        let of_blocks: Vec<Vec<BlockMask>> = band.distances.par_iter().map(pieces_of_block).collect();
        let mut first_node = Vec::with_capacity(of_blocks.len());
        let mut sizes: Vec<u64> = Vec::new();
        for pieces in &of_blocks {
            first_node.push(sizes.len());
            sizes.extend(pieces.iter().map(|piece| mask::count(piece) as u64));
        }
        let first_tile = sizes.len();
        sizes.extend(band.inside_tiles.iter().map(|tile| (tile.edge as u64).pow(3)));

        let all = |pieces: &Vec<BlockMask>| pieces.iter().fold(BlockMask::default(), joined);
        let inside: Vec<BlockMask> = of_blocks.iter().map(all).collect();
        let lookup = Lookup::new(band);
        let nodes = Nodes { lookup, of_blocks: &of_blocks, inside: &inside, first_node: &first_node, first_tile };
        let links: Vec<Vec<(usize, usize)>> =
            (0..band.origins.len()).into_par_iter().map(|block| nodes.links(block)).collect();
        let mut forest = Forest::new(sizes.len());
        links.into_iter().flatten().for_each(|(a, b)| forest.join(a, b));
        for (index, tile) in band.inside_tiles.iter().enumerate() {
            for face in FACES {
                // One voxel beyond the face finds a tile of this size or larger; smaller ones find this tile.
                let step = if face.min_element() < 0 { face } else { face * tile.edge };
                if let Some(Place::Tile(other)) = tile.origin.checked_add(step).map(|voxel| nodes.lookup.at(voxel)) {
                    forest.join(first_tile + index, first_tile + other);
                }
            }
        }
        let (rank, sizes) = forest.ranks(&sizes);
        Self { of_blocks, first_node, first_tile, rank, sizes }
    }
}

/// What is joined.
struct Nodes<'a> {
    lookup: Lookup<'a>,
    of_blocks: &'a [Vec<BlockMask>],
    /// The voxels of all pieces, by block.
    inside: &'a [BlockMask],
    first_node: &'a [usize],
    first_tile: usize,
}

impl Nodes<'_> {
    /// The node that holds a voxel.
    fn at(&self, place: Place) -> Option<usize> {
        match place {
            Place::Outside => None,
            Place::Tile(index) => Some(self.first_tile + index),
            Place::Voxel { block, offset } => {
                let holds = |piece: &BlockMask| is_active(piece, offset);
                self.of_blocks[block].iter().position(holds).map(|piece| self.first_node[block] + piece)
            }
        }
    }

    /// The joins of a block's pieces with those around it, and of its own along diagonals.
    fn links(&self, block: usize) -> Vec<(usize, usize)> {
        let mut links = Vec::new();
        if !self.of_blocks[block].is_empty() {
            let around = self.lookup.around(block);
            self.across_faces(block, &around, &mut links);
            self.along_diagonals(block, &around, &mut links);
        }
        links
    }

    fn across_faces(&self, block: usize, around: &Surroundings, links: &mut Vec<(usize, usize)>) {
        let nodes = |block: usize| (self.first_node[block]..).zip(&self.of_blocks[block]);
        for face in FACES {
            match around.neighbour(face) {
                Place::Outside => {}
                Place::Tile(index) => {
                    let reaching = nodes(block).filter(|(_, voxels)| mask::side(voxels, face) != 0);
                    links.extend(reaching.map(|(node, _)| (node, self.first_tile + index)));
                }
                // Of two blocks one sees the other in this direction.
                Place::Voxel { .. } if face.min_element() < 0 => {}
                Place::Voxel { block: other, .. } => {
                    for (node, voxels) in nodes(block) {
                        let side = mask::side(voxels, face);
                        let touching = nodes(other).filter(|(_, voxels)| side & mask::side(voxels, -face) != 0);
                        links.extend(touching.map(|(beyond, _)| (node, beyond)));
                    }
                }
            }
        }
    }

    fn along_diagonals(&self, block: usize, around: &Surroundings, links: &mut Vec<(usize, usize)>) {
        let rows = InsideRows::of(around, self.inside);
        for (first, second) in DIAGONALS {
            for offset in mask::places(&rows.touching((first, second))) {
                let local = local_of(offset);
                let value = |step: IVec3| f64::from(around.value(local + step));
                let [along, aside] = [value(IVec3::ZERO) * value(first + second), value(first) * value(second)];
                if along > aside
                    && let Some(other) = self.at(around.at(local + first + second))
                    && let Some(own) = self.at(Place::Voxel { block, offset })
                {
                    links.push((own, other));
                }
            }
        }
    }
}

/// The voxels of either.
fn joined(one: BlockMask, two: &BlockMask) -> BlockMask {
    std::array::from_fn(|word| one[word] | two[word])
}

/// The voxels of a block's pieces, joined across faces: at most 256 of them, as in a chequered block.
fn pieces_of_block(distances: &[f32; BLOCK_VOXELS]) -> Vec<BlockMask> {
    let mut rest = inside(distances);
    let mut pieces = Vec::new();
    while let Some(word) = rest.iter().position(|word| *word != 0) {
        let mut piece = BlockMask::default();
        piece[word] = rest[word] & rest[word].wrapping_neg();
        loop {
            let spread = mask::spread(&piece);
            let grown = std::array::from_fn(|word| spread[word] & rest[word]);
            if grown == piece {
                break;
            }
            piece = grown;
        }
        rest = std::array::from_fn(|word| rest[word] & !piece[word]);
        pieces.push(piece);
    }
    pieces
}

/// The voxels that are not outside.
#[multiversion::multiversion(targets = "simd")]
fn inside(distances: &[f32; BLOCK_VOXELS]) -> BlockMask {
    mask::pack(&distances.map(|distance| u8::from(distance >= 0.0)))
}

/// Disjoint sets; each set's root is its least node, whatever the order of joins.
struct Forest(Vec<usize>);

impl Forest {
    fn new(nodes: usize) -> Self {
        Self((0..nodes).collect())
    }

    fn root(&mut self, mut node: usize) -> usize {
        while self.0[node] != node {
            self.0[node] = self.0[self.0[node]];
            node = self.0[node];
        }
        node
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }

    /// Each node's set, by rank, and the sums of each set's sizes, the largest first.
    fn ranks(mut self, sizes: &[u64]) -> (Vec<usize>, Vec<u64>) {
        let mut totals = vec![0; sizes.len()];
        for (node, size) in sizes.iter().enumerate() {
            totals[self.root(node)] += size;
        }
        let mut roots: Vec<usize> = (0..sizes.len()).filter(|&node| totals[node] > 0).collect();
        roots.sort_unstable_by_key(|&root| (std::cmp::Reverse(totals[root]), root));
        let mut rank = vec![0; sizes.len()];
        for (place, &root) in roots.iter().enumerate() {
            rank[root] = place;
        }
        let of_nodes = (0..sizes.len()).map(|node| rank[self.root(node)]).collect();
        (of_nodes, roots.into_iter().map(|root| totals[root]).collect())
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::grid::testing::{band_of, sphere};

    #[test]
    fn a_sphere_is_one_piece_and_two_are_two() {
        assert_eq!(pieces(&sphere(DVec3::splat(0.3), 1.0, 0.03)).len(), 1);
        let ball = |p: DVec3, x: f64, radius: f64| radius - (p - DVec3::new(x, 0.1, 0.0)).length();
        let band = band_of(|p| ball(p, -0.8, 0.7).max(ball(p, 0.8, 0.6)), 1.7, 0.04);
        let found = pieces(&band);
        assert_eq!(found.len(), 2);
        for (volume, radius) in found.into_iter().zip([0.7_f64, 0.6]) {
            let exact = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
            assert!((volume / exact - 1.0).abs() < 0.01, "{volume} for {exact}");
        }
        // Two voxels nearer and they touch.
        let touching = band_of(|p| ball(p, -0.6, 0.65).max(ball(p, 0.6, 0.6)), 1.5, 0.04);
        assert_eq!(pieces(&touching).len(), 1);
    }

    /// A hollow ball with a ball in it: tiles must not join what a shell keeps apart.
    #[test]
    fn nested_solids_stay_apart() {
        let shell = |p: DVec3| 10.0 - (p.length() - 60.0).abs();
        let band = band_of(|p| shell(p).max(40.0 - p.length()), 75.0, 1.0);
        assert!(!band.inside_tiles.is_empty());
        assert_eq!(pieces(&band).len(), 2);
    }

    /// A wire as thin as a lattice can hold, in every slant: one piece; and one crumb is a second piece.
    #[test]
    fn slanted_wires_are_whole_and_crumbs_are_found() {
        for direction in [DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, -1.0, 0.3), DVec3::new(0.2, 1.0, -1.0)] {
            let along = direction.normalize();
            let wire = |p: DVec3| {
                let reach = p.dot(along).clamp(-20.0, 20.0);
                0.75 - (p - along * reach).length()
            };
            assert_eq!(pieces(&band_of(wire, 25.0, 1.0)).len(), 1, "{direction}");
            let crumb = DVec3::new(0.0, 0.0, 9.0);
            let band = band_of(|p| wire(p).max(0.5 - (p - crumb).length()), 25.0, 1.0);
            assert_eq!(pieces(&band).last(), Some(&1.0), "{direction}");
        }
    }

    #[test]
    fn the_voxels_of_a_piece_are_all_of_it() {
        let ball = |p: DVec3, x: f64, radius: f64| radius - (p - DVec3::new(x, 0.0, 0.0)).length();
        let band = band_of(|p| ball(p, -25.0, 21.0).max(ball(p, 25.0, 22.0)), 50.0, 1.0);
        assert!(!band.inside_tiles.is_empty());
        let volumes = pieces(&band);
        let dropped = voxels_of_pieces(&band, |rank, volume| {
            assert_eq!(volume, volumes[rank]);
            rank > 0
        });
        let count: u32 = dropped.iter().flat_map(|(_, mask)| mask).map(|word| word.count_ones()).sum();
        assert_eq!(f64::from(count), volumes[1]);
        for (origin, mask) in &dropped {
            for offset in (0..BLOCK_VOXELS).filter(|&offset| mask[offset >> 6] >> (offset & 63) & 1 == 1) {
                let centre = (*origin + local_of(offset)).as_dvec3();
                assert!(ball(centre, -25.0, 21.0) >= 0.0, "{centre} is not in the smaller ball");
            }
        }
        assert!(voxels_of_pieces(&band, |_, _| false).is_empty());
    }

    /// Crumbs at random around a ball, against a flood from voxel to voxel.
    #[test]
    fn pieces_are_those_of_a_flood() {
        let noise = |p: DVec3| {
            let at = p.round().as_ivec3();
            let mixed =
                (at.x.wrapping_mul(73_856_093) ^ at.y.wrapping_mul(19_349_663) ^ at.z.wrapping_mul(83_492_791)) as u32;
            f64::from(mixed.wrapping_mul(0x9e37_79b1) >> 8) / f64::from(1 << 24) - 0.75
        };
        let field = |p: DVec3| (20.3 - p.length()).max(noise(p).min(27.6 - p.length()));
        let band = band_of(field, 30.0, 1.0);
        assert!(!band.inside_tiles.is_empty());
        let value = |at: IVec3| field(at.as_dvec3()).clamp(-3.0, 3.0) as f32;
        let mut rest: std::collections::BTreeSet<[i32; 3]> = std::collections::BTreeSet::new();
        for x in -32..32 {
            for y in -32..32 {
                rest.extend((-32..32).filter(|&z| value(IVec3::new(x, y, z)) >= 0.0).map(|z| [x, y, z]));
            }
        }
        let mut sizes = Vec::new();
        while let Some(seed) = rest.pop_first() {
            let mut open = vec![IVec3::from(seed)];
            let mut size = 0;
            while let Some(at) = open.pop() {
                size += 1;
                let mut take = |next: IVec3| {
                    if rest.remove(&next.to_array()) {
                        open.push(next);
                    }
                };
                FACES.into_iter().for_each(|face| take(at + face));
                for (first, second) in DIAGONALS.into_iter().flat_map(|(a, b)| [(a, b), (-a, -b)]) {
                    let [own, b, c, across] =
                        [IVec3::ZERO, first, second, first + second].map(|step| f64::from(value(at + step)));
                    if b < 0.0 && c < 0.0 && own * across > b * c {
                        take(at + first + second);
                    }
                }
            }
            sizes.push(f64::from(size));
        }
        sizes.sort_by(|a, b| b.total_cmp(a));
        assert!(sizes.len() > 500, "{}", sizes.len());
        assert_eq!(pieces(&band), sizes);
    }

    #[test]
    fn an_empty_band_has_no_pieces() {
        assert!(pieces(&sphere(DVec3::splat(0.05), 0.01, 0.1)).is_empty());
    }

    #[test]
    fn each_voxel_of_a_chequered_block_is_a_piece() {
        let mut block = [-1.0; BLOCK_VOXELS];
        for offset in (0..BLOCK_VOXELS).filter(|&offset| local_of(offset).element_sum() % 2 == 0) {
            block[offset] = 1.0;
        }
        assert_eq!(pieces_of_block(&block).len(), 256);
    }
}
