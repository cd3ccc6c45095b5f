//! What a scene says of how a distance is measured: by which method, and of an adaptive one how deep and how smooth it is.

use super::{Method, USUAL, named};
use crate::distance::octree::{Restore, Settings};
use crate::field::Aabb;

/// How often a root may be halved: once more than the region takes, and as the octree counts its cells.
pub const DEPTHS: (u32, u32) = (3, 20);

/// A method with its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Choice {
    /// The method's name.
    pub method: &'static str,
    /// How often the root of a tree is halved at most, within [`DEPTHS`]; `None`: until its cells are as small as the voxels
    /// ask for. The root is a cube, or in the plane a square, of four times the longest side of what is measured.
    pub depth: Option<u32>,
    /// What the cells of a tree are between their corners.
    pub restore: Restore,
}

impl Choice {
    /// The usual one.
    pub const USUAL: Self = Self::by(USUAL);

    /// A method with its usual settings.
    pub const fn by(method: &'static str) -> Self {
        Self { method, depth: None, restore: Restore::Spline }
    }

    /// The method.
    pub fn method(self) -> &'static dyn Method {
        named(self.method)
    }

    /// The settings of a tree that are usual for a region, as far as nothing else was chosen.
    pub fn settings(self, usual: Settings) -> Settings {
        let usual = Settings { restore: self.restore, ..usual };
        let Some(smallest_cell) = self.smallest_cell(usual.region) else { return usual };
        let Settings { levels, restore, memory_limit, .. } = usual;
        Settings { levels, restore, memory_limit, ..Settings::new(usual.region, smallest_cell) }
    }

    /// The edge of the smallest cells that a chosen depth has around a region.
    pub fn smallest_cell(self, region: Aabb) -> Option<f64> {
        self.depth.map(|depth| root(region) / f64::from(1_u32 << depth))
    }

    /// The depth whose cells around a region are no larger than voxels of an edge, as far as there is one.
    pub fn depth_for(self, region: Aabb, voxel: f64) -> u32 {
        let halvings = (root(region) / voxel).log2().ceil();
        (halvings as u32).clamp(DEPTHS.0, DEPTHS.1)
    }

    /// What tells it from all others.
    pub fn key(self) -> String {
        match self {
            Self { method, depth: None, restore: Restore::Spline } => method.to_owned(),
            Self { method, depth, restore } => format!("{method} {depth:?} {restore:?}"),
        }
    }
}

/// The edge of the root around a region.
fn root(region: Aabb) -> f64 {
    4.0 * region.size().max_element()
}

/// How a band is to be measured.
#[derive(Clone, Copy, Debug)]
pub struct AsChosen {
    /// By what.
    pub choice: Choice,
    /// The most memory, in bytes, that building a tree may hold.
    pub memory_limit: usize,
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// Halvings of the root, whatever the voxels.
    #[test]
    fn a_depth_is_that_of_the_root() {
        let region = Aabb::new(DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.8, 1.1, 0.7));
        for depth in DEPTHS.0..=DEPTHS.1 {
            let choice = Choice { depth: Some(depth), ..Choice::by("adf") };
            let settings = choice.settings(Settings::new(region, 0.01));
            assert_eq!(crate::distance::octree::root(&settings).map(|(_, found)| found), Ok(depth));
            let cell = choice.smallest_cell(region).expect("a depth");
            assert_eq!(choice.depth_for(region, 1.01 * cell), depth);
        }
    }

    #[test]
    fn keys_tell_choices_apart() {
        let adf = Choice::by("adf");
        let all = [
            Choice::USUAL,
            adf,
            Choice { depth: Some(7), ..adf },
            Choice { depth: Some(8), ..adf },
            Choice { restore: Restore::Linear, ..adf },
        ];
        let keys: std::collections::BTreeSet<String> = all.iter().map(|choice| choice.key()).collect();
        assert_eq!(keys.len(), all.len());
    }
}
