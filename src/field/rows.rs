//! Which pieces of an outline cross the level of a point, by rows: a ray towards +x asks those of one row alone.

/// Lists of pieces, a row of equal height each.
#[derive(Clone, Debug)]
pub struct Rows {
    least: f64,
    height: f64,
    /// Where the list of each row begins in `pieces`, and where the last ends.
    begins: Vec<u32>,
    pieces: Vec<u32>,
}

/// Entries of all rows for each piece. More: tall pieces take memory in every row; fewer: rows grow long.
const MOST_ENTRIES: usize = 8;

impl Rows {
    /// Of pieces by the least and greatest y of each.
    pub fn new(spans: &[(f64, f64)]) -> Self {
        let least = spans.iter().map(|span| span.0).fold(f64::INFINITY, f64::min);
        let greatest = spans.iter().map(|span| span.1).fold(f64::NEG_INFINITY, f64::max);
        let mut rows = spans.len().clamp(1, 1 << 16);
        loop {
            let height = (greatest - least) / rows as f64;
            let row = |y: f64| row_of(y, least, height, rows);
            let entries: usize = spans.iter().map(|span| row(span.1) - row(span.0) + 1).sum();
            if rows > 1 && (entries > MOST_ENTRIES * spans.len() || !(height > 0.0 && height.is_finite())) {
                rows /= 2;
                continue;
            }
            let mut begins = vec![0_u32; rows + 1];
            for span in spans {
                for row in row(span.0)..=row(span.1) {
                    begins[row + 1] += 1;
                }
            }
            for row in 0..rows {
                begins[row + 1] += begins[row];
            }
            let mut next = begins.clone();
            let mut pieces = vec![0; entries];
            for (piece, span) in spans.iter().enumerate() {
                for row in row(span.0)..=row(span.1) {
                    pieces[next[row] as usize] = piece as u32;
                    next[row] += 1;
                }
            }
            return Self { least, height, begins, pieces };
        }
    }

    /// The pieces that may cross a level.
    pub fn at(&self, y: f64) -> &[u32] {
        let row = row_of(y, self.least, self.height, self.begins.len() - 1);
        &self.pieces[self.begins[row] as usize..self.begins[row + 1] as usize]
    }
}

fn row_of(y: f64, least: f64, height: f64, rows: usize) -> usize {
    // What is below all rows, or not a number, is in the first.
    (((y - least) / height) as usize).min(rows - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_that_crosses_a_level_is_in_its_row() {
        let spans: Vec<(f64, f64)> = (0..500)
            .map(|i| {
                let low = libm::sin(f64::from(i) * 1.3);
                (low, low + if i % 7 == 0 { 1.5 } else { 0.01 })
            })
            .collect();
        let rows = Rows::new(&spans);
        assert!(rows.pieces.len() <= MOST_ENTRIES * spans.len());
        for step in 0..400 {
            let y = -1.2 + f64::from(step) * 0.01;
            let found = rows.at(y);
            for (i, (low, high)) in spans.iter().enumerate() {
                assert!(!(*low <= y && y <= *high) || found.contains(&(i as u32)), "{i} at {y}");
            }
        }
        assert_eq!(Rows::new(&[(1.0, 1.0)]).at(f64::NAN), [0]);
    }
}
