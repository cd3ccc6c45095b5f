//! NanoVDB's files: the grids of a `.vdb` in the layout that GPUs read, without metadata.

use std::path::Path;

use super::{Encoded, Format, Frame, naming, vdb};
use crate::bake::{Error, Output};
use crate::node::Model;
use crate::vdb::{encode_nano, read_back_nano};

/// The format of `.nvdb` files.
#[derive(Debug)]
pub struct Nvdb;

impl Format for Nvdb {
    fn extension(&self) -> &'static str {
        "nvdb"
    }

    fn check(&self, model: &Model, output: &Output) -> Result<(), String> {
        vdb::check_voxels(output)?;
        naming::check(model)?;
        match output.identity.half.iter().find(|grid| naming::stays_vectors(model, grid)) {
            Some(grid) => {
                Err(format!("--half: NanoVDB has no vectors of 16 bits such as `{grid}`; leave it out, or write .vdb"))
            }
            None => Ok(()),
        }
    }

    fn encode(&self, frame: &Frame<'_>) -> Result<Encoded, Error> {
        let encode = |grids: &crate::vdb::Frame<'_>| encode_nano(grids, frame.output.compression);
        let pieces = vdb::with_grids(frame, encode).map_err(|error| Error::Encode(error.to_string()))?;
        Ok(Encoded { pieces, polygons: None })
    }

    fn read_back(&self, pieces: &[Vec<u8>], path: &Path) -> Result<(), Error> {
        read_back_nano(pieces, path).map_err(|error| Error::Encode(error.to_string()))
    }
}
