//! Some of many queries, taken in whole rows of eight: a row is moved at once, a query here and a query there are not.

use crate::{
    field::BATCH,
    grid::{BlockMask, mask},
};

use super::{kernel::load_each, kernel::store, lanes::Lane};

/// Queries taken together: the voxels of a block along z.
pub(super) const ROW: usize = 8;

/// The rows that hold some queries, as lanes side by side.
pub(super) struct Rows {
    /// The first query of each.
    starts: [usize; BATCH / ROW],
    count: usize,
    /// Which lanes are of the queries meant.
    meant: BlockMask,
}

impl Rows {
    /// Those of the flagged queries, of the first `len`.
    pub fn of(flags: &BlockMask, len: usize) -> Self {
        let mut rows = Self { starts: [0; BATCH / ROW], count: 0, meant: [0; 8] };
        let mut lanes = [0; BATCH / ROW];
        let last = len.div_ceil(ROW);
        for (first, word) in (0..).step_by(8).zip(mask::first(flags, len)) {
            if word == 0 {
                continue;
            }
            for (row, flags) in (first..last).zip(word.to_le_bytes()) {
                // Each is written to the next place, which only a row with a flag takes up.
                (rows.starts[rows.count], lanes[rows.count]) = (ROW * row, flags);
                rows.count += usize::from(flags != 0);
            }
        }
        let (words, _) = lanes.as_chunks::<8>();
        rows.meant = mask::first(&std::array::from_fn(|word| u64::from_le_bytes(words[word])), rows.lanes());
        rows
    }

    /// The first queries of the rows.
    pub fn starts(&self) -> &[usize] {
        &self.starts[..self.count]
    }

    /// All lanes.
    pub fn lanes(&self) -> usize {
        ROW * self.count
    }

    /// The lanes of the queries that were meant.
    pub fn meant(&self) -> &BlockMask {
        &self.meant
    }

    /// The query of a lane.
    pub fn query(&self, lane: usize) -> usize {
        self.starts[lane / ROW] + lane % ROW
    }

    /// Brings the rows side by side.
    pub fn gather(&self, from: [&Lane; 3], to: [&mut Lane; 3]) {
        let [x, y, z] = to;
        for (lane, &start) in (0..).step_by(ROW).zip(self.starts()) {
            let row: [[f32; ROW]; 3] = load_each(from, start);
            store(row[0], x, lane);
            store(row[1], y, lane);
            store(row[2], z, lane);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_hold_the_flagged_queries() {
        let flags = std::array::from_fn(|i| u8::from(i % 37 == 5 || i / 8 == 11));
        let flags = mask::pack(&flags);
        for len in [0, 5, 6, 43, 90, 96, 500, BATCH] {
            let rows = Rows::of(&flags, len);
            let queries: Vec<usize> = mask::places(rows.meant()).map(|lane| rows.query(lane)).collect();
            assert!(queries.iter().copied().eq(mask::places(&flags).take_while(|&query| query < len)));
            assert!(rows.starts().iter().all(|start| queries.iter().any(|query| query / ROW == start / ROW)));
            let numbers: Lane = std::array::from_fn(|i| i as f32);
            let [mut x, mut y, mut z] = [[0.0; BATCH]; 3];
            rows.gather([&numbers; 3], [&mut x, &mut y, &mut z]);
            assert!((0..rows.lanes()).all(|lane| [x[lane], y[lane], z[lane]] == [rows.query(lane) as f32; 3]));
        }
    }
}
