//! Level sets in OpenVDB's hands, and its own morph of one into another (`LevelSetMorphing`, with its defaults).

use std::sync::atomic::{AtomicBool, Ordering};

use glam::IVec3;

use super::bridge::{Cancel, ffi};
use super::frame::{Content, Grid};
use super::{Error, Metadata, flip_sign};
use crate::grid::{BLOCK_VOXELS, Band, BlockMask, InsideTile, Lattice};

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
        let values: Vec<f32> = band.distances.as_flattened().iter().map(|distance| flip_sign(*distance)).collect();
        Ok(Self { grid: grid.in_library(&values)?, lattice: band.lattice, half_width: band.half_width })
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
        let counts = ffi::count(&self.grid).map_err(library)?;
        let mut origins = vec![[0; 3]; counts.blocks];
        let mut distances = vec![[0.0; BLOCK_VOXELS]; counts.blocks];
        let mut active: Vec<BlockMask> = vec![[0; 8]; counts.blocks];
        let mut tiles = vec![[0; 4]; counts.tiles];
        let mut target = ffi::Target {
            origins: origins.as_flattened_mut(),
            masks: active.as_flattened_mut(),
            values: distances.as_flattened_mut(),
            tiles: tiles.as_flattened_mut(),
        };
        ffi::copy(&self.grid, &mut target).map_err(library)?;
        distances.as_flattened_mut().iter_mut().for_each(|value| *value = flip_sign(*value));
        Ok(Band {
            lattice: self.lattice,
            half_width: self.half_width,
            origins: origins.into_iter().map(IVec3::from_array).collect(),
            distances,
            active,
            inside_tiles: tiles
                .iter()
                .map(|&[x, y, z, edge]| InsideTile { origin: IVec3::new(x, y, z), edge })
                .collect(),
        })
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
