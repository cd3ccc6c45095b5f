//! Bytes read in order, each read checked against what is left.

use std::path::Path;

use crate::vdb::Error;

/// Why a walk stopped.
#[derive(Debug)]
pub enum Failure {
    /// The file contradicts itself, or ends too early.
    Damage { offset: usize, problem: String },
    /// The file may be sound, and is not of a kind that is read here.
    Unsupported(String),
}

impl Failure {
    /// The same with the name of the grid where it was found.
    pub fn of_grid(self, name: &str) -> Self {
        match self {
            Self::Damage { offset, problem } => Self::Damage { offset, problem: format!("grid '{name}': {problem}") },
            Self::Unsupported(problem) => Self::Unsupported(format!("grid '{name}': {problem}")),
        }
    }

    /// The error of a file; `path` is for messages.
    pub fn in_file(self, path: &Path) -> Error {
        match self {
            Self::Damage { offset, problem } => Error::Damaged { path: path.into(), offset: offset as u64, problem },
            Self::Unsupported(problem) => Error::Unsupported { path: path.into(), problem },
        }
    }
}

/// A failure at an offset.
pub fn damage<T>(offset: usize, problem: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::Damage { offset, problem: problem.into() })
}

/// A place in the bytes, which may lie in pieces: then nothing that is read as one runs from one piece into the next.
pub struct Cursor<'a> {
    /// The piece that it is in, and where.
    piece: &'a [u8],
    place: usize,
    /// The bytes before that piece.
    before: usize,
    later: &'a [Vec<u8>],
    total: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { piece: bytes, place: 0, before: 0, later: &[], total: bytes.len() }
    }

    pub fn of_pieces(pieces: &'a [Vec<u8>]) -> Self {
        let total = pieces.iter().map(Vec::len).sum();
        Self { piece: &[], place: 0, before: 0, later: pieces, total }
    }

    /// The offset of the next byte.
    pub fn at(&self) -> usize {
        self.before + self.place
    }

    pub fn remaining(&self) -> usize {
        self.total - self.at()
    }

    /// Goes into the next piece at a piece's end.
    fn enter_piece(&mut self) {
        while let ([next, later @ ..], true) = (self.later, self.place == self.piece.len()) {
            self.before += self.piece.len();
            (self.piece, self.place, self.later) = (next, 0, later);
        }
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Failure> {
        if count > self.remaining() {
            let problem = format!("it ends here: {count} bytes are needed, {} are there", self.remaining());
            return damage(self.at(), problem);
        }
        if count == 0 {
            return Ok(&[]);
        }
        self.enter_piece();
        let Some(taken) = self.piece.get(self.place..self.place + count) else {
            return damage(self.at(), format!("{count} bytes are needed where a piece of the file ends"));
        };
        self.place += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Failure> {
        let taken = self.take(N)?;
        Ok(taken.try_into().expect("as many bytes as were taken"))
    }

    pub fn u8(&mut self) -> Result<u8, Failure> {
        Ok(self.array::<1>()?[0])
    }

    pub fn u32(&mut self) -> Result<u32, Failure> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn i32(&mut self) -> Result<i32, Failure> {
        self.array().map(i32::from_le_bytes)
    }

    pub fn i64(&mut self) -> Result<i64, Failure> {
        self.array().map(i64::from_le_bytes)
    }

    pub fn f64(&mut self) -> Result<f64, Failure> {
        self.array().map(f64::from_le_bytes)
    }

    /// A length and so many bytes of text. Text that is not UTF-8 is kept readable, not refused.
    pub fn string(&mut self) -> Result<String, Failure> {
        let length = self.u32()?;
        Ok(String::from_utf8_lossy(self.take(length as usize)?).into_owned())
    }

    /// Goes on at an absolute offset, not before this one.
    pub fn skip_to(&mut self, offset: i64, what: &str) -> Result<(), Failure> {
        match usize::try_from(offset) {
            Ok(target) if (self.at()..=self.total).contains(&target) => {
                while target > self.before + self.piece.len() {
                    self.place = self.piece.len();
                    self.enter_piece();
                }
                self.place = target - self.before;
                Ok(())
            }
            _ => {
                let problem = format!("{what} is said to be at byte {offset}, of {}", self.total);
                damage(self.at(), problem)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_read_as_one() {
        let pieces = [vec![], vec![1, 2, 3], vec![], vec![4, 5], vec![6]];
        let mut cursor = Cursor::of_pieces(&pieces);
        assert_eq!(cursor.remaining(), 6);
        assert_eq!((cursor.take(2).unwrap(), cursor.at()), (&[1, 2][..], 2));
        assert!(cursor.take(2).is_err());
        assert_eq!(cursor.take(1).unwrap(), [3]);
        assert_eq!((cursor.u8().unwrap(), cursor.at(), cursor.remaining()), (4, 4, 2));
        cursor.skip_to(6, "the end").unwrap();
        assert!(cursor.take(0).unwrap().is_empty() && cursor.u8().is_err());
        for target in 0..=6 {
            let mut cursor = Cursor::of_pieces(&pieces);
            cursor.skip_to(target, "a place").unwrap();
            assert_eq!((cursor.at(), cursor.u8().ok()), (target as usize, (1..=6).nth(target as usize)));
        }
        assert!(Cursor::of_pieces(&pieces).skip_to(7, "a place").is_err());
    }
}
