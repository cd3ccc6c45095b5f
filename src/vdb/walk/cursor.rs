//! Bytes read in order, each read checked against what is left.

/// Why a walk stopped.
#[derive(Debug)]
pub enum Failure {
    /// The file contradicts itself, or ends too early.
    Damage { offset: usize, problem: String },
    /// The file may be sound, and is not of a kind that is read here.
    Unsupported(String),
}

/// A failure at an offset.
pub fn damage<T>(offset: usize, problem: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::Damage { offset, problem: problem.into() })
}

/// A place in the bytes.
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The offset of the next byte.
    pub fn at(&self) -> usize {
        self.at
    }

    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Failure> {
        if count > self.remaining() {
            let problem = format!("it ends here: {count} bytes are needed, {} are there", self.remaining());
            return damage(self.at, problem);
        }
        let taken = &self.bytes[self.at..self.at + count];
        self.at += count;
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
            Ok(target) if (self.at..=self.bytes.len()).contains(&target) => {
                self.at = target;
                Ok(())
            }
            _ => {
                let problem = format!("{what} is said to be at byte {offset}, of {}", self.bytes.len());
                damage(self.at, problem)
            }
        }
    }
}
