//! What the blocks of a chunk have for each other, and what earlier chunks left for them.

use glam::IVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::distance::{
    facing::{Face, Layer, Seed},
    staged::Staged,
};

/// The blocks of a chunk, where each is, and the layers of finished blocks that face them.
pub struct Neighbours<'a> {
    pub staged: &'a [Staged],
    pub places: &'a FxHashMap<IVec3, usize>,
    pub borders: &'a FxHashMap<(IVec3, Face), Layer<'static>>,
    pub voxel: f32,
    pub reach: f32,
}

/// What one block is offered through one of its faces.
struct Offered {
    place: usize,
    face: Face,
    seeds: Vec<Seed>,
}

impl Neighbours<'_> {
    /// What all blocks offer to each other: blocks that are offered something, in order, with it.
    pub fn compare(&self) -> Vec<(usize, Vec<Seed>)> {
        self.offers(&(0..self.staged.len()).collect::<Vec<_>>(), |place, offered| self.compare_around(place, offered))
    }

    /// The same of some blocks to their neighbours.
    pub fn offers_of(&self, places: &[usize]) -> Vec<(usize, Vec<Seed>)> {
        self.offers(places, |place, offered| self.offers_around(place, offered))
    }

    fn offers(&self, places: &[usize], list: impl Fn(usize, &mut Vec<Offered>) + Sync) -> Vec<(usize, Vec<Seed>)> {
        let of_place = |&place: &usize| {
            let mut offered = Vec::new();
            list(place, &mut offered);
            offered
        };
        let mut offered: Vec<Offered> = places.par_iter().with_min_len(32).flat_map_iter(of_place).collect();
        offered.sort_unstable_by_key(|offered| (offered.place, offered.face));
        let mut by_block: Vec<(usize, Vec<Seed>)> = Vec::new();
        for mut offered in offered {
            match by_block.last_mut() {
                Some((place, seeds)) if *place == offered.place => seeds.append(&mut offered.seeds),
                _ => by_block.push((offered.place, offered.seeds)),
            }
        }
        by_block
    }

    /// Compares a block with those behind its forward faces, each with each, and takes what borders have for it.
    fn compare_around(&self, place: usize, offered: &mut Vec<Offered>) {
        let block = &self.staged[place];
        for face in Face::ALL {
            let neighbour = block.origin + face.step();
            if let Some(&other) = self.places.get(&neighbour) {
                if Face::FORWARD.contains(&face) {
                    let here = Layer::new(block, face, self.voxel);
                    let there = Layer::new(&self.staged[other], face.facing(), self.voxel);
                    self.offer(place, face, &here, &there, offered);
                    self.offer(other, face.facing(), &there, &here, offered);
                }
            } else if let Some(there) = self.borders.get(&(neighbour, face.facing())) {
                self.offer(place, face, &Layer::new(block, face, self.voxel), there, offered);
            }
        }
    }

    fn offers_around(&self, place: usize, offered: &mut Vec<Offered>) {
        let block = &self.staged[place];
        for face in Face::ALL {
            if let Some(&other) = self.places.get(&(block.origin + face.step())) {
                let here = Layer::new(&self.staged[other], face.facing(), self.voxel);
                self.offer(other, face.facing(), &here, &Layer::new(block, face, self.voxel), offered);
            }
        }
    }

    /// Lists what the layer `there` has for the block at `place`, whose layer at `face` is `here`.
    fn offer(&self, place: usize, face: Face, here: &Layer, there: &Layer, offered: &mut Vec<Offered>) {
        let mut seeds = Vec::new();
        here.offers(there, self.reach, &mut seeds);
        if !seeds.is_empty() {
            offered.push(Offered { place, face, seeds });
        }
    }
}
