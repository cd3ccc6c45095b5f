//! The cells while they are being made: positions on the lattice of smallest cells, splitting, looking up,
//! balancing.

/// A cell: its least corner and edge, in smallest cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// The least corner.
    pub origin: [u32; 3],
    /// The edge: a power of two.
    pub size: u32,
}

impl Cell {
    /// A point of the cell, in halves of its edge; the cell must not be a smallest one unless `halves` are even.
    pub fn point(&self, halves: [u32; 3]) -> [u32; 3] {
        std::array::from_fn(|axis| self.origin[axis] + halves[axis] * self.size / 2)
    }

    /// A corner, bit 4 for the greater x, 2 for y, 1 for z.
    pub fn corner(&self, corner: usize) -> [u32; 3] {
        std::array::from_fn(|axis| self.origin[axis] + if corner & (4 >> axis) != 0 { self.size } else { 0 })
    }

    fn child(&self, child: usize) -> Self {
        let size = self.size / 2;
        let origin = std::array::from_fn(|axis| self.origin[axis] + if child & (4 >> axis) != 0 { size } else { 0 });
        Self { origin, size }
    }
}

/// The number of what is not there, or not known yet.
pub const NONE: u32 = u32::MAX;

/// Numbers of the 27 points of a cell's corners and middles, by the place in halves of its edge, x slowest.
pub type CellPoints = [u32; 27];

/// Where among 27 points one is, given in halves of the edge.
pub const fn point_at([x, y, z]: [u32; 3]) -> usize {
    (x * 9 + y * 3 + z) as usize
}

/// Where the point with this place among 27 is, in halves of the edge.
pub const fn halves_of(at: usize) -> [u32; 3] {
    let at = at as u32;
    [at / 9, at / 3 % 3, at % 3]
}

/// Where among 27 points a corner is.
const fn corner_at(corner: usize) -> usize {
    let corner = corner as u32;
    point_at([(corner >> 2 & 1) * 2, (corner >> 1 & 1) * 2, (corner & 1) * 2])
}

/// An octree under construction. Node 0 is the root.
pub struct Tree {
    /// Every node's cell.
    pub cells: Vec<Cell>,
    /// The first of eight children, or 0 for a leaf.
    pub children: Vec<u32>,
    /// The numbers of the samples at every node's corners.
    pub corners: Vec<[u32; 8]>,
}

impl Tree {
    /// A root of the given edge.
    pub fn new(size: u32) -> Self {
        Self { cells: vec![Cell { origin: [0; 3], size }], children: vec![0], corners: vec![[NONE; 8]] }
    }

    /// Splits a leaf and returns its first child. The samples at the children's corners are told by [`Self::number`].
    pub fn split(&mut self, node: u32) -> u32 {
        let first = self.cells.len() as u32;
        let cell = self.cells[node as usize];
        self.children[node as usize] = first;
        self.cells.extend((0..8).map(|child| cell.child(child)));
        self.children.extend([0; 8]);
        self.corners.extend([[NONE; 8]; 8]);
        first
    }

    /// Tells the samples at the corners of a split node's children: those at its own points, of which its corners are known.
    pub fn number(&mut self, node: u32, points: &CellPoints) {
        let (own, first) = (self.corners[node as usize], self.children[node as usize] as usize);
        for child in 0..8 {
            self.corners[first + child] = std::array::from_fn(|corner| {
                if child == corner { own[corner] } else { points[(corner_at(child) + corner_at(corner)) / 2] }
            });
        }
    }

    /// The leaf that holds a smallest cell.
    pub fn locate(&self, place: [u32; 3]) -> u32 {
        let mut node = 0;
        let mut half = self.cells[0].size / 2;
        while self.children[node as usize] != 0 {
            let bit = |axis: usize| u32::from(place[axis] & half != 0);
            node = self.children[node as usize] + (bit(0) << 2 | bit(1) << 1 | bit(2));
            half /= 2;
        }
        node
    }

    /// Splits leaves until no two that touch, even at a corner, differ by more than one halving. Before the nodes in `split`
    /// were split, none did. Returns the nodes that were split for it, parents before their children.
    pub fn balance(&mut self, split: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let root = self.cells[0].size;
        let mut found = Vec::new();
        let mut by_size: Vec<Vec<u32>> = vec![Vec::new(); root.trailing_zeros() as usize + 1];
        for node in split {
            by_size[self.cells[node as usize].size.trailing_zeros() as usize].push(node);
        }
        // A split node asks for neighbours of its own size. Splitting for its sake makes split nodes of greater
        // size only, and those are asked later.
        for level in 0..by_size.len() {
            let mut index = 0;
            while index < by_size[level].len() {
                let cell = self.cells[by_size[level][index] as usize];
                index += 1;
                for place in neighbours(&cell, root) {
                    loop {
                        let leaf = self.locate(place);
                        let size = self.cells[leaf as usize].size;
                        if size <= cell.size {
                            break;
                        }
                        found.push(leaf);
                        self.split(leaf);
                        by_size[size.trailing_zeros() as usize].push(leaf);
                    }
                }
            }
        }
        found
    }
}

/// The least corners of the 26 cells of the same size around one, those in the root.
fn neighbours(cell: &Cell, root: u32) -> impl Iterator<Item = [u32; 3]> + use<> {
    let cell = *cell;
    (0..27).filter(|&at| at != 13).filter_map(move |at| {
        let step = halves_of(at);
        let mut place = [0; 3];
        for axis in 0..3 {
            place[axis] = (cell.origin[axis] + step[axis] * cell.size).checked_sub(cell.size)?;
            if place[axis] >= root {
                return None;
            }
        }
        Some(place)
    })
}
