//! Small JSON files that tell when a single bit of them has changed: each ends with the SHA-256 of the rest of itself.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::disk;
use crate::terminal;

/// What stands before the seal's digits, last in the file.
const BEFORE: &str = "\"seal\": \"";
/// Hexadecimal digits of a SHA-256.
const DIGITS: usize = 64;

/// Why a sealed file cannot be taken as it is.
#[derive(Debug)]
pub enum SealedError {
    /// The system refused.
    System(PathBuf, io::Error),
    /// It is not what was written.
    Damaged(PathBuf, String),
}

impl fmt::Display for SealedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(path, error) => write!(f, "{}: cannot read it: {error}", terminal::path(path)),
            Self::Damaged(path, problem) => {
                write!(f, "{}: this file is damaged: {problem}", terminal::path(path))
            }
        }
    }
}

impl std::error::Error for SealedError {}

/// A file's content with its seal. `content` must be a struct.
#[derive(Serialize)]
struct Sealed<'a, T> {
    #[serde(flatten)]
    content: &'a T,
    seal: &'a str,
}

/// Writes a file, whole or not at all.
///
/// # Errors
/// When the system refuses.
pub fn write<T: Serialize>(path: &Path, content: &T) -> Result<(), disk::Error> {
    disk::write_whole(path, text(content)?.as_bytes())
}

/// The text of a file.
fn text<T: Serialize>(content: &T) -> Result<String, disk::Error> {
    let unsealed = Sealed { content, seal: &"0".repeat(DIGITS) };
    let mut text = serde_json::to_string_pretty(&unsealed)
        .map_err(|error| disk::Error::system(Path::new("JSON"), "write it", error.into()))?;
    text.push('\n');
    let seal = hexadecimal(&digest(text.as_bytes()));
    let at = text.rfind(BEFORE).map_or(text.len(), |at| at + BEFORE.len());
    text.replace_range(at..at + DIGITS, &seal);
    Ok(text)
}

/// Reads a file; `None` where there is none.
///
/// # Errors
/// When the system refuses, or the file is not what was written.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, SealedError> {
    let bytes = match disk::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(SealedError::System(path.into(), error)),
    };
    let damaged = |problem: &str| SealedError::Damaged(path.into(), problem.into());
    let text = String::from_utf8(bytes).map_err(|_| damaged("it is no text"))?;
    let at =
        text.rfind(BEFORE).map(|at| at + BEFORE.len()).ok_or_else(|| damaged("its end with the seal is missing"))?;
    let seal = text.get(at..at + DIGITS).ok_or_else(|| damaged("its end with the seal is missing"))?;
    let mut unsealed = text.clone();
    unsealed.replace_range(at..at + DIGITS, &"0".repeat(DIGITS));
    if hexadecimal(&digest(unsealed.as_bytes())) != seal {
        return Err(damaged("it is not as it was written, its seal does not fit"));
    }
    // The seal fits, so it was written by a program like this one: perhaps by a newer one.
    serde_json::from_str(&text).map(Some).map_err(|error| damaged(&format!("{error}; another version wrote it")))
}

/// SHA-256.
pub fn digest(bytes: &[u8]) -> [u8; 32] {
    use sha2::Digest;
    sha2::Sha256::digest(bytes).into()
}

/// Bytes as two hexadecimal digits each.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, serde::Deserialize)]
    struct Thing {
        name: String,
        value: f64,
    }

    #[test]
    fn any_flipped_bit_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("thing.json");
        let thing = Thing { name: "\"seal\": \"".into(), value: 0.1 };
        write(&path, &thing).unwrap();
        assert_eq!(read::<Thing>(&path).unwrap(), Some(thing));
        let whole = std::fs::read(&path).unwrap();
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            std::fs::write(&path, bytes).unwrap();
            let error = read::<Thing>(&path).expect_err("a flipped bit").to_string();
            assert!(error.contains("thing.json: this file is damaged"), "{error}");
        }
        for cut in 0..whole.len() - 1 {
            std::fs::write(&path, &whole[..cut]).unwrap();
            read::<Thing>(&path).expect_err("a cut file");
        }
        std::fs::remove_file(&path).unwrap();
        assert_eq!(read::<Thing>(&path).unwrap(), None);
    }
}
