//! Connected pieces of the solid.
//!
//! Voxels inside are joined across their faces. Two that touch along an edge only, with the two others around that
//! edge outside, are joined where the bilinear interpolation of the four joins them (the asymptotic decider: Nielson
//! and Hamann 1991), so that a thin slanted strut is one piece and two solids that come near each other are two.

use glam::IVec3;
use rayon::prelude::*;

use super::lookup::{Lookup, Place, local_of};
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, Band, BlockMask};

/// One step each way along each axis.
const FACES: [IVec3; 6] = [IVec3::X, IVec3::Y, IVec3::Z, IVec3::NEG_X, IVec3::NEG_Y, IVec3::NEG_Z];
/// The two steps of each diagonal of a voxel pair that shares an edge, each such pair once.
const DIAGONALS: [(IVec3, IVec3); 6] = [
    (IVec3::X, IVec3::Y),
    (IVec3::X, IVec3::NEG_Y),
    (IVec3::X, IVec3::Z),
    (IVec3::X, IVec3::NEG_Z),
    (IVec3::Y, IVec3::Z),
    (IVec3::Y, IVec3::NEG_Z),
];

/// The volumes of the solid's connected pieces, in cubic world units, the largest first; whole voxels are counted.
/// The number of pieces is the list's length.
pub fn pieces(band: &Band) -> Vec<f64> {
    Pieces::of(band).volumes(band)
}

/// The inside voxels of those pieces that `dropped` picks, block by block in the band's order, tiles after; `dropped` is
/// told a piece's rank (0 is the largest) and its volume in cubic world units.
pub fn voxels_of_pieces(band: &Band, dropped: impl Fn(usize, f64) -> bool) -> Vec<(IVec3, BlockMask)> {
    let pieces = Pieces::of(band);
    let volumes = pieces.volumes(band);
    let drops: Vec<bool> = volumes.iter().enumerate().map(|(rank, &volume)| dropped(rank, volume)).collect();
    if !drops.contains(&true) {
        return Vec::new();
    }
    let mut voxels = Vec::new();
    for (block, labels) in pieces.labels.iter().enumerate() {
        let mut mask = BlockMask::default();
        for (offset, label) in labels.local.iter().enumerate() {
            let drops = label.is_some_and(|label| drops[pieces.rank[pieces.first_node[block] + usize::from(label)]]);
            mask[offset >> 6] |= u64::from(drops) << (offset & 63);
        }
        if mask != BlockMask::default() {
            voxels.push((band.origins[block], mask));
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
struct Pieces {
    labels: Vec<Labels>,
    first_node: Vec<usize>,
    first_tile: usize,
    /// Of each node: the rank of its piece.
    rank: Vec<usize>,
    /// Of each piece: its voxels, the most first.
    sizes: Vec<u64>,
}

impl Pieces {
    fn volumes(&self, band: &Band) -> Vec<f64> {
        let cubed = band.lattice.voxel_size.get().powi(3);
        self.sizes.iter().map(|&size| size as f64 * cubed).collect()
    }

    fn of(band: &Band) -> Self {
        let labels: Vec<Labels> = band.distances.par_iter().map(Labels::of).collect();
        let mut first_node = Vec::with_capacity(labels.len() + 1);
        let mut sizes: Vec<u64> = Vec::new();
        for labels in &labels {
            first_node.push(sizes.len());
            sizes.resize(sizes.len() + labels.count, 0);
            let base = first_node[first_node.len() - 1];
            labels.local.iter().flatten().for_each(|&label| sizes[base + usize::from(label)] += 1);
        }
        let first_tile = sizes.len();
        sizes.extend(band.inside_tiles.iter().map(|tile| (tile.edge as u64).pow(3)));

        let lookup = Lookup::new(band);
        let node = |place: Place| match place {
            Place::Outside => None,
            Place::Tile(index) => Some(first_tile + index),
            Place::Voxel { block, offset } => {
                labels[block].local[offset].map(|label| first_node[block] + usize::from(label))
            }
        };
        let of_blocks: Vec<Vec<(usize, usize)>> = (0..band.origins.len())
            .into_par_iter()
            .map(|block| if labels[block].count == 0 { Vec::new() } else { block_links(band, &lookup, block, &node) })
            .collect();
        let mut forest = Forest::new(sizes.len());
        of_blocks.into_iter().flatten().for_each(|(a, b)| forest.join(a, b));
        for (index, tile) in band.inside_tiles.iter().enumerate() {
            for face in FACES {
                // One voxel beyond the face finds a tile of this size or larger; smaller ones find this tile.
                let step = if face.min_element() < 0 { face } else { face * tile.edge };
                if let Some(Place::Tile(other)) = tile.origin.checked_add(step).map(|voxel| lookup.at(voxel)) {
                    forest.join(first_tile + index, first_tile + other);
                }
            }
        }
        let (rank, sizes) = forest.ranks(&sizes);
        Self { labels, first_node, first_tile, rank, sizes }
    }
}

/// The joins of a block's pieces with those around it, and of its own along diagonals.
fn block_links(
    band: &Band,
    lookup: &Lookup<'_>,
    block: usize,
    node: &impl Fn(Place) -> Option<usize>,
) -> Vec<(usize, usize)> {
    let around = lookup.around(block);
    // Two voxels in, every neighbour of a distance's voxel is inside too.
    let deep = (2.0 * band.lattice.voxel_size.get()) as f32;
    let mut links = Vec::new();
    for (offset, &value) in band.distances[block].iter().enumerate() {
        let local = local_of(offset);
        let Some(own) = node(Place::Voxel { block, offset }) else { continue };
        for face in FACES {
            let beyond = local + face;
            let leaves = beyond.min_element() < 0 || beyond.max_element() >= BLOCK_EDGE;
            if leaves && let Some(other) = node(around.at(beyond)) {
                links.push((own, other));
            }
        }
        if value > deep {
            continue;
        }
        for (first, second) in DIAGONALS {
            let Some(other) = node(around.at(local + first + second)) else { continue };
            let (b, c) = (around.value(local + first), around.value(local + second));
            let saddle =
                f64::from(value) * f64::from(around.value(local + first + second)) - f64::from(b) * f64::from(c);
            if b < 0.0 && c < 0.0 && saddle > 0.0 {
                links.push((own, other));
            }
        }
    }
    links.sort_unstable();
    links.dedup();
    links
}

/// Which piece of its block each voxel inside belongs to, joined across faces.
struct Labels {
    /// At most 256 pieces, as in a chequered block.
    local: Box<[Option<u8>; BLOCK_VOXELS]>,
    count: usize,
}

impl Labels {
    fn of(block: &[f32; BLOCK_VOXELS]) -> Self {
        let mut local = Box::new([None; BLOCK_VOXELS]);
        let mut count = 0;
        let mut open = Vec::new();
        for seed in 0..BLOCK_VOXELS {
            if block[seed] >= 0.0 && local[seed].is_none() {
                let label = Some(count as u8);
                local[seed] = label;
                open.push(seed);
                while let Some(offset) = open.pop() {
                    for next in face_neighbours(offset) {
                        if block[next] >= 0.0 && local[next].is_none() {
                            local[next] = label;
                            open.push(next);
                        }
                    }
                }
                count += 1;
            }
        }
        Self { local, count }
    }
}

/// The offsets of a voxel's neighbours in its block.
fn face_neighbours(offset: usize) -> impl Iterator<Item = usize> {
    [64, 8, 1].into_iter().flat_map(move |stride| {
        let along = offset / stride % 8;
        let before = (along > 0).then(|| offset - stride);
        let after = (along < 7).then(|| offset + stride);
        before.into_iter().chain(after)
    })
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

    #[test]
    fn an_empty_band_has_no_pieces() {
        assert!(pieces(&sphere(DVec3::splat(0.05), 0.01, 0.1)).is_empty());
    }

    #[test]
    fn a_chequered_block_fits_its_labels() {
        let mut block = [-1.0; BLOCK_VOXELS];
        for offset in (0..BLOCK_VOXELS).filter(|&offset| local_of(offset).element_sum() % 2 == 0) {
            block[offset] = 1.0;
        }
        assert_eq!(Labels::of(&block).count, 256);
    }
}
