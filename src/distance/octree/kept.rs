//! A distance object as bytes, and back: what was measured is kept, what follows from it is worked out anew.

use glam::DVec3;

use super::bricks::Bricks;
use super::{DistanceObject, LEAF, Report, Restore};

/// What the bytes begin with; its number rises whenever their form changes.
const MAGIC: [u8; 16] = *b"hfvdb distance 2";

impl DistanceObject {
    /// All that was measured.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Report { samples, hanging, depth, error_at_surface, error_relative, .. } = self.report;
        let mut bytes = MAGIC.to_vec();
        let mut put = |number: [u8; 8]| bytes.extend_from_slice(&number);
        for number in [self.origin.x, self.origin.y, self.origin.z, self.step, error_at_surface, error_relative] {
            put(number.to_le_bytes());
        }
        let counts = [self.nodes.len(), self.leaves.len(), self.numbers.len(), samples].map(|count| count as u64);
        let is_linear = u64::from(self.restore == Restore::Linear);
        let has_surface = u64::from(self.bounding_box.is_some());
        let flags = [u64::from(self.depth), u64::from(depth), has_surface, is_linear, hanging as u64];
        for number in counts.into_iter().chain(flags) {
            put(number.to_le_bytes());
        }
        bytes.reserve_exact(4 * self.nodes.len() + 32 * (self.leaves.len() + self.numbers.len()));
        bytes.extend(self.nodes.iter().flat_map(|node| node.to_le_bytes()));
        bytes.extend(self.leaves.as_flattened().iter().flat_map(|corner| corner.to_le_bytes()));
        bytes.extend(self.numbers.as_flattened().iter().flat_map(|number| number.to_le_bytes()));
        bytes
    }

    /// What such bytes hold, equal to what they were made from in every bit; `None` where they are none of ours.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut rest = bytes.strip_prefix(&MAGIC)?;
        let mut take = || -> Option<[u8; 8]> {
            let (number, left) = rest.split_first_chunk()?;
            rest = left;
            Some(*number)
        };
        let mut float = || take().map(f64::from_le_bytes);
        let (origin, step) = (DVec3::new(float()?, float()?, float()?), float()?);
        let (error_at_surface, error_relative) = (float()?, float()?);
        let mut count = || take().and_then(|bytes| usize::try_from(u64::from_le_bytes(bytes)).ok());
        let (nodes, cells, corners, samples) = (count()?, count()?, count()?, count()?);
        let (depth, smallest, has_surface) = (count()? as u32, count()? as u32, count()? == 1);
        let restore = if count()? == 1 { Restore::Linear } else { Restore::Spline };
        let hanging = count()?;
        let whole = cells.checked_add(corners)?.checked_mul(8)?.checked_add(nodes)?.checked_mul(4)?;
        if rest.len() != whole || !(step > 0.0 && step.is_finite() && origin.is_finite()) || depth >= 31 {
            return None;
        }
        let (words, _) = rest.as_chunks::<4>();
        let (nodes, words) = words.split_at(nodes);
        let (leaves, numbers) = words.split_at(8 * cells);
        let mut object = Self {
            origin,
            step,
            inverse_step: 1.0 / step,
            depth,
            nodes: nodes.iter().map(|word| u32::from_le_bytes(*word)).collect(),
            bounds: Vec::new(),
            slopes: Vec::new(),
            leaves: leaves.as_chunks().0.iter().map(|leaf| leaf.map(u32::from_le_bytes)).collect(),
            numbers: numbers.as_chunks().0.iter().map(|corner| corner.map(f32::from_le_bytes)).collect(),
            polynomials: Vec::new(),
            bricks: Bricks::default(),
            border: super::Border::default(),
            slope: 0.0,
            bounding_box: None,
            restore,
            report: Report {
                cells,
                corners,
                hanging,
                samples,
                depth: smallest,
                bytes: 0,
                error_at_surface,
                error_relative,
            },
        };
        if !object.is_a_tree() {
            return None;
        }
        object.finish(has_surface);
        Some(object)
    }

    /// Whether every number of a node, leaf and corner is one there is, and no way down is longer than the tree is deep.
    fn is_a_tree(&self) -> bool {
        let mut open = vec![(0, self.depth)];
        let mut leaves = 0;
        while let Some((node, levels)) = open.pop() {
            let Some(&what) = self.nodes.get(node as usize) else { return false };
            if what & LEAF != 0 {
                // They are numbered in the order of the walk.
                if (what & !LEAF) as usize != leaves {
                    return false;
                }
                leaves += 1;
            } else if levels == 0 || what <= node || open.len() > 8 * (self.depth as usize + 1) {
                return false;
            } else {
                open.extend((0..8).rev().map(|child| (what + child, levels - 1)));
            }
        }
        let corners = self.leaves.as_flattened();
        leaves == self.leaves.len() && corners.iter().all(|&corner| (corner as usize) < self.numbers.len())
    }
}
