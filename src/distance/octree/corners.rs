//! From cells and samples to the jets at corners: mixed derivatives by differences between neighbours, hanging
//! corners from the coarser cell they lie on.
//!
//! A corner *hangs* when a leaf that it touches does not have it as a corner. It then takes its whole jet from
//! that leaf's patch, which makes the spline C¹ across the change of size: on the shared face both patches have
//! the same bicubic value and the same bicubic normal derivative (the space of PHT splines, Deng et al. 2008).

use glam::Vec4;

use super::kernel::Numbers;
use super::patch::{AXIS_BIT, Jet, Patch};
use super::refine::middles_of;
use super::samples::{KeyMap, Samples, morton};
use super::tree::{Cell, Tree};

const NONE: u32 = u32::MAX;

/// The leaves in Morton order with their corners.
pub struct Corners {
    /// Every leaf's corners.
    pub leaves: Vec<[u32; 8]>,
    /// The jet of each corner, rounded.
    pub numbers: Vec<Numbers>,
    /// The part that each corner's foot lies on.
    pub parts: Vec<u32>,
}

struct Neighbours {
    /// By corner: the nearest one along −x, +x, −y, +y, −z, +z.
    beside: Vec<[u32; 6]>,
    places: Vec<[u32; 3]>,
    step: f64,
}

impl Neighbours {
    /// The derivative along an axis of something known at corners, from three corners, or two at the border.
    fn along(&self, corner: u32, axis: usize, of: impl Fn(u32) -> f64) -> f64 {
        let [below, above] = [self.beside[corner as usize][2 * axis], self.beside[corner as usize][2 * axis + 1]];
        let side = |other: u32| {
            (other != NONE).then(|| {
                let apart = self.places[corner as usize][axis].abs_diff(self.places[other as usize][axis]);
                let gap = f64::from(apart) * self.step;
                (gap, (of(other) - of(corner)) / gap)
            })
        };
        match (side(below), side(above)) {
            (Some((a, down)), Some((b, up))) => {
                // Exact on parabolas whatever the two gaps. Where a crease lies on one side the two differences are
                // far apart: then no more than twice the smaller, or the crease is felt in smooth cells beside it.
                let central = (up * a - down * b) / (a + b);
                let limit = if up * down < 0.0 { 2.0 * up.abs().min(down.abs()) } else { 0.0 };
                central.clamp(-limit, limit)
            }
            (Some((_, down)), None) => -down,
            (None, Some((_, up))) => up,
            (None, None) => 0.0,
        }
    }
}

/// Numbers the corners of the leaves and works out their jets. `step` is the smallest cell's edge.
pub fn corners(tree: &Tree, order: &[u32], samples: &Samples, step: f64) -> Corners {
    let mut index = KeyMap::default();
    let mut places = Vec::new();
    let mut leaves = Vec::with_capacity(order.len());
    for &node in order {
        let cell = &tree.cells[node as usize];
        leaves.push(std::array::from_fn(|corner| {
            let place = cell.corner(corner);
            *index.entry(morton(place)).or_insert_with(|| {
                places.push(place);
                places.len() as u32 - 1
            })
        }));
    }
    let cells: Vec<Cell> = order.iter().map(|&node| tree.cells[node as usize]).collect();
    let mut coarse_first: Vec<u32> = (0..leaves.len() as u32).collect();
    coarse_first.sort_by_key(|&leaf| std::cmp::Reverse(cells[leaf as usize].size));
    let neighbours = neighbours(&leaves, &coarse_first, places, step);
    let mut jets = free_jets(&neighbours, samples);
    hang(&leaves, &cells, &coarse_first, &index, step, &mut jets);
    let parts = neighbours.places.iter().map(|&place| samples.get(place).part).collect();
    Corners { leaves, numbers: jets.into_iter().map(rounded).collect(), parts }
}

impl Corners {
    /// The patch of a leaf of the given edge.
    pub fn patch(&self, leaf: usize, edge: f64) -> Patch {
        Patch { corners: self.leaves[leaf].map(|corner| jet(&self.numbers[corner as usize])), edge }
    }
}

/// A corner's numbers in `f64`.
pub fn jet(numbers: &Numbers) -> Jet {
    std::array::from_fn(|i| f64::from(numbers[i / 4][i % 4]))
}

fn rounded(jet: Jet) -> Numbers {
    let [a, b, c, d, e, f, g, h] = jet.map(|number| number as f32);
    [Vec4::new(a, b, c, d), Vec4::new(e, f, g, h)]
}

fn neighbours(leaves: &[[u32; 8]], coarse_first: &[u32], places: Vec<[u32; 3]>, step: f64) -> Neighbours {
    let mut beside = vec![[NONE; 6]; places.len()];
    // Finer leaves come later and replace what coarser ones said: the nearest neighbour stays.
    for &leaf in coarse_first {
        let corners = &leaves[leaf as usize];
        for axis in 0..3 {
            for low in (0..8).filter(|corner| corner & AXIS_BIT[axis] == 0) {
                let (a, b) = (corners[low], corners[low | AXIS_BIT[axis]]);
                beside[a as usize][2 * axis + 1] = b;
                beside[b as usize][2 * axis] = a;
            }
        }
    }
    Neighbours { beside, places, step }
}

/// Jets as if no corner hung: value and gradient from the foot, mixed derivatives from differences.
fn free_jets(neighbours: &Neighbours, samples: &Samples) -> Vec<Jet> {
    let mut jets: Vec<Jet> = neighbours
        .places
        .iter()
        .map(|&place| {
            let sample = samples.get(place);
            let [x, y, z] = sample.gradient;
            [sample.value, z, y, 0.0, x, 0.0, 0.0, 0.0]
        })
        .collect();
    let count = jets.len() as u32;
    let twists: Vec<[f64; 3]> = (0..count)
        .map(|corner| {
            [(1, 2), (0, 2), (0, 1)].map(|(a, b)| {
                let ab = neighbours.along(corner, a, |other| jets[other as usize][AXIS_BIT[b]]);
                let ba = neighbours.along(corner, b, |other| jets[other as usize][AXIS_BIT[a]]);
                0.5 * (ab + ba)
            })
        })
        .collect();
    for corner in 0..count {
        let [yz, xz, xy] = twists[corner as usize];
        let triple: f64 = (0..3).map(|axis| neighbours.along(corner, axis, |c| twists[c as usize][axis])).sum();
        let jet = &mut jets[corner as usize];
        (jet[3], jet[5], jet[6], jet[7]) = (yz, xz, xy, triple / 3.0);
    }
    // Rounded here, so that hanging corners follow what is stored.
    for number in jets.iter_mut().flatten() {
        *number = f64::from(*number as f32);
    }
    jets
}

/// Gives every hanging corner the jet of the coarsest leaf it hangs on. Leaves come coarse first, so a leaf's own
/// corners are final before it gives.
fn hang(leaves: &[[u32; 8]], cells: &[Cell], coarse_first: &[u32], index: &KeyMap, step: f64, jets: &mut [Jet]) {
    let mut done = vec![false; jets.len()];
    for &leaf in coarse_first {
        let cell = &cells[leaf as usize];
        if cell.size == 1 {
            break;
        }
        let patch = Patch {
            corners: leaves[leaf as usize].map(|corner| jets[corner as usize]),
            edge: f64::from(cell.size) * step,
        };
        for (halves, place) in middles_of(cell) {
            let Some(&corner) = index.get(&morton(place)) else { continue };
            if !std::mem::replace(&mut done[corner as usize], true) {
                let jet = patch.jet(halves.map(|h| f64::from(h) * 0.5));
                jets[corner as usize] = jet.map(|number| f64::from(number as f32));
            }
        }
    }
}
