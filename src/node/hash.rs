//! What identifies a scene's content: for the files' metadata and for resuming.

use sha2::{Digest, Sha256};

use crate::node::argument::Arguments;
use crate::node::model::Model;
use crate::text::files::FileReference;

impl Model {
    /// SHA-256 of all that decides the voxels: the scene with its overrides, without spacing, comments, order of
    /// keys and unused variants, and the content of the files it names. Fails where such a file cannot be read.
    pub fn hash(&self) -> Result<[u8; 32], (FileReference, std::io::Error)> {
        let mut digest = Sha256::new();
        digest.update(self.canonical.as_bytes());
        for shape in &self.shapes {
            let named = shape.all_arguments().flat_map(Arguments::files);
            let voxels = shape.given_arguments().flat_map(Arguments::files);
            for file in named.chain(voxels) {
                let bytes = file.read().map_err(|error| (file.clone(), error))?;
                digest.update(shape.name.as_bytes());
                digest.update((bytes.len() as u64).to_le_bytes());
                digest.update(&bytes);
            }
        }
        Ok(digest.finalize().into())
    }
}
