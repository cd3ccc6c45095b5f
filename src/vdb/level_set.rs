//! Level sets in OpenVDB's hands, and its own morph of one into another (`LevelSetMorphing`, with its defaults).

use std::sync::atomic::{AtomicBool, Ordering};

use glam::IVec3;

use super::bridge::{Cancel, ffi};
use super::frame::{Content, Grid};
use super::read::{band_of, blocks_of};
use super::{Error, Metadata};
use crate::grid::{BLOCK_VOXELS, Band, BlockMask, Lattice};

/// A level set that OpenVDB holds; it never changes.
#[derive(Clone)]
pub struct LevelSet {
    grid: cxx::SharedPtr<ffi::Grid>,
    lattice: Lattice,
    half_width: f32,
}

impl LevelSet {
    /// Gives a band to OpenVDB.
    ///
    /// # Errors
    /// [`Error::Grid`] where the band is none that OpenVDB's tree can hold; [`Error::Library`] from OpenVDB.
    pub fn new(band: &Band) -> Result<Self, Error> {
        let grid = Grid { name: "surface", content: Content::LevelSet(band), half: false, metadata: Metadata::new() };
        grid.check()?;
        let topology = grid.topology()?;
        let grid = ffi::with_distances(&topology, band.distances.as_flattened()).map_err(library)?;
        Ok(Self { grid, lattice: band.lattice, half_width: band.half_width })
    }

    /// What OpenVDB makes of it on the way to another one on the same voxels, `duration` later. Its surface moves along
    /// its normals by the target's distance there, world units a unit of time, which the target's band limits; so it
    /// comes to rest on the target, from everywhere where it touches the target's inside, and is gone elsewhere.
    /// `None` where `cancel` was set on the way.
    ///
    /// # Errors
    /// [`Error::Library`] from OpenVDB.
    pub fn morphed(&self, target: &Self, duration: f64, cancel: &AtomicBool) -> Result<Option<Self>, Error> {
        let grid = ffi::morphed(&self.grid, &target.grid, duration, &Cancel(cancel)).map_err(library)?;
        Ok((!cancel.load(Ordering::Relaxed)).then_some(Self { grid, ..*self }))
    }

    /// Its blocks, positive inside.
    ///
    /// # Errors
    /// [`Error::Library`] from OpenVDB.
    pub fn band(&self) -> Result<Band, Error> {
        let blocks = blocks_of(&self.grid, true).map_err(library)?;
        Ok(band_of(&blocks, IVec3::ZERO, self.lattice.voxel_size, self.half_width))
    }

    /// Memory that it takes, about, in bytes.
    ///
    /// # Errors
    /// [`Error::Library`] from OpenVDB.
    pub fn bytes(&self) -> Result<u64, Error> {
        let bytes_a_leaf = size_of::<[f32; BLOCK_VOXELS]>() + size_of::<BlockMask>() + 64;
        Ok(ffi::count(&self.grid).map_err(library)?.blocks as u64 * bytes_a_leaf as u64)
    }
}

fn library(error: cxx::Exception) -> Error {
    Error::Library { message: error.what().into() }
}
