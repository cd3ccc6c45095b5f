//! How a surface passes through a cell of eight voxels, by the signs of these alone.
//!
//! A face whose corners are inside and outside in turns can be passed in two ways. Its inside corners are always parted
//! there, so that both cells at the face agree, and what is inside is never joined by less than a face.

use std::sync::LazyLock;

/// Edges of a cell: four along each axis, by the places of the other two axes in order.
pub const EDGES: usize = 12;
/// The piece of an edge that is not crossed.
pub const NO_PIECE: u8 = u8::MAX;

/// The pieces of the surface in a cell: which of them crosses each edge, and how many there are.
#[derive(Clone, Copy)]
pub struct Pieces {
    /// By edge.
    pub of_edge: [u8; EDGES],
    /// How many, at most four.
    pub count: u8,
}

/// By the eight corners' bits, 1 inside; a corner's bit is 4x + 2y + z.
static PIECES: LazyLock<[Pieces; 256]> = LazyLock::new(|| std::array::from_fn(|corners| pieces(corners as u8)));

/// The pieces in a cell with such corners.
pub fn pieces_of(corners: u8) -> &'static Pieces {
    &PIECES[usize::from(corners)]
}

/// The two axes beside one, in order.
pub const fn others(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

/// An edge's number, by its axis and the place of its least corner.
pub const fn edge(axis: usize, corner: [usize; 3]) -> usize {
    let [b, c] = others(axis);
    4 * axis + 2 * corner[b] + corner[c]
}

/// The place of an edge's least corner.
pub const fn least_corner(edge: usize) -> [usize; 3] {
    let axis = edge / 4;
    let [b, c] = others(axis);
    let mut corner = [0; 3];
    corner[b] = edge / 2 % 2;
    corner[c] = edge % 2;
    corner
}

fn is_inside(corners: u8, at: [usize; 3]) -> bool {
    corners >> (4 * at[0] + 2 * at[1] + at[2]) & 1 == 1
}

fn pieces(corners: u8) -> Pieces {
    let crossed = |edge: usize| {
        let low = least_corner(edge);
        let mut high = low;
        high[edge / 4] = 1;
        is_inside(corners, low) != is_inside(corners, high)
    };
    // The least edge that each hangs together with.
    let mut first: [usize; EDGES] = std::array::from_fn(|edge| edge);
    let mut join = |a: usize, b: usize| {
        let (low, high) = (first[a].min(first[b]), first[a].max(first[b]));
        first.iter_mut().filter(|first| **first == high).for_each(|first| *first = low);
    };
    for normal in 0..3 {
        let [p, q] = others(normal);
        for side in 0..2 {
            let corner = |i: usize, j: usize| {
                let mut at = [0; 3];
                (at[normal], at[p], at[q]) = (side, i, j);
                at
            };
            let along_p = |j: usize| edge(p, corner(0, j));
            let along_q = |i: usize| edge(q, corner(i, 0));
            let around = [along_p(0), along_p(1), along_q(0), along_q(1)];
            let here: Vec<usize> = around.into_iter().filter(|edge| crossed(*edge)).collect();
            match here.as_slice() {
                [a, b] => join(*a, *b),
                [_, _, _, _] => {
                    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        if is_inside(corners, corner(i, j)) {
                            join(along_p(j), along_q(i));
                        }
                    }
                }
                _ => {}
            }
        }
    }
    let mut of_edge = [NO_PIECE; EDGES];
    let mut count = 0;
    for edge in (0..EDGES).filter(|edge| crossed(*edge)) {
        if first[edge] == edge {
            of_edge[edge] = count;
            count += 1;
        } else {
            of_edge[edge] = of_edge[first[edge]];
        }
    }
    Pieces { of_edge, count }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_by_corners() {
        assert_eq!(pieces_of(0).count, 0);
        assert_eq!(pieces_of(0xFF).count, 0);
        // One corner, an edge of two, a side of four; two corners across a face, and across the cell.
        for (corners, count) in [(0b1, 1), (0b11, 1), (0b1111, 1), (0b1001, 2), (0b1000_0001, 2), (0b0110_1001, 4)] {
            assert_eq!(pieces_of(corners).count, count, "{corners:#b}");
        }
        for corners in 0..=255 {
            let pieces = pieces_of(corners);
            assert!(pieces.count <= 4);
            let crossed = pieces.of_edge.iter().filter(|piece| **piece != NO_PIECE).count();
            assert!(usize::from(pieces.count) * 3 <= crossed, "a piece has three edges at least");
        }
    }
}
