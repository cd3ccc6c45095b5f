//! From cells and samples to the jets at corners: mixed derivatives by differences between neighbours, hanging
//! corners from the coarser cell they lie on.
//!
//! A corner *hangs* when a leaf that it touches does not have it as a corner. It then takes its whole jet from
//! that leaf's patch, which makes the spline C¹ across the change of size: on the shared face both patches have
//! the same bicubic value and the same bicubic normal derivative (the space of PHT splines, Deng et al. 2008).

use std::cmp::Reverse;

use rayon::prelude::*;

use super::patch::{AXIS_BIT, Jet, Patch};
use super::refine::middles_of;
use super::samples::Samples;
use super::tree::{Cell, Tree};

const NONE: u32 = u32::MAX;

/// Leaves whose hanging corners are worked out at once: enough to share, few enough to hold.
const HANGING_AT_ONCE: usize = 1 << 14;

/// A corner's jet, rounded.
pub type Numbers = [f32; 8];

/// The leaves in Morton order with their corners.
pub struct Corners {
    /// Every leaf's corners.
    pub leaves: Vec<[u32; 8]>,
    /// The numbers of each corner.
    pub numbers: Vec<Numbers>,
    /// The part that each corner's foot lies on.
    pub parts: Vec<u32>,
}

/// What is known of each corner.
struct Known {
    /// The number of its sample.
    samples: Vec<u32>,
    places: Vec<[u32; 3]>,
    /// By axis: the nearest corners below and above.
    beside: [Vec<[u32; 2]>; 3],
    step: f64,
}

impl Known {
    /// The derivative along an axis of something known at corners, from three corners, or two at the border.
    fn along(&self, corner: u32, axis: usize, of: impl Fn(u32) -> f64) -> f64 {
        let [below, above] = self.beside[axis][corner as usize];
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
    let cells: Vec<Cell> = order.iter().map(|&node| tree.cells[node as usize]).collect();
    // Every corner has a sample, which tells corners that are the same.
    let sampled = |cell: &Cell| std::array::from_fn(|corner| samples.number(cell.corner(corner)).unwrap_or(NONE));
    let mut leaves: Vec<[u32; 8]> = cells.par_iter().map(sampled).collect();
    let mut numbers = vec![NONE; samples.len()];
    let mut known = Known { samples: Vec::new(), places: Vec::new(), beside: [const { Vec::new() }; 3], step };
    for (leaf, cell) in leaves.iter_mut().zip(&cells) {
        for (corner, sample) in leaf.iter_mut().enumerate() {
            let number = &mut numbers[*sample as usize];
            if *number == NONE {
                *number = known.samples.len() as u32;
                known.samples.push(*sample);
                known.places.push(cell.corner(corner));
            }
            *sample = *number;
        }
    }
    let mut coarse_first: Vec<u32> = (0..leaves.len() as u32).collect();
    coarse_first.par_sort_by_key(|&leaf| Reverse(cells[leaf as usize].size));
    known.beside = neighbours(&leaves, &coarse_first, known.places.len());
    let mut jets = free_jets(&known, samples);
    let at = |place: [u32; 3]| samples.number(place).map(|sample| numbers[sample as usize]).filter(|&it| it != NONE);
    hang(&leaves, &cells, &coarse_first, at, step, &mut jets);
    let parts = known.samples.par_iter().map(|&sample| samples.numbered(sample).part).collect();
    Corners { leaves, numbers: jets.into_par_iter().map(rounded).collect(), parts }
}

impl Corners {
    /// The patch of a leaf of the given edge.
    pub fn patch(&self, leaf: usize, edge: f64) -> Patch {
        Patch { corners: self.leaves[leaf].map(|corner| jet(&self.numbers[corner as usize])), edge }
    }
}

/// A corner's numbers in `f64`.
pub fn jet(numbers: &Numbers) -> Jet {
    numbers.map(f64::from)
}

fn rounded(jet: Jet) -> Numbers {
    jet.map(|number| number as f32)
}

fn neighbours(leaves: &[[u32; 8]], coarse_first: &[u32], corners: usize) -> [Vec<[u32; 2]>; 3] {
    let mut beside = [(); 3].map(|()| vec![[NONE; 2]; corners]);
    beside.par_iter_mut().zip(AXIS_BIT).for_each(|(beside, bit)| {
        // Finer leaves come later and replace what coarser ones said: the nearest neighbour stays.
        for &leaf in coarse_first {
            let corners = &leaves[leaf as usize];
            for low in (0..8).filter(|corner| corner & bit == 0) {
                let (a, b) = (corners[low], corners[low | bit]);
                beside[a as usize][1] = b;
                beside[b as usize][0] = a;
            }
        }
    });
    beside
}

/// Jets as if no corner hung: value and gradient from the foot, mixed derivatives from differences.
fn free_jets(known: &Known, samples: &Samples) -> Vec<Jet> {
    let from_foot = |sample: &u32| {
        let sample = samples.numbered(*sample);
        let [x, y, z] = sample.gradient;
        [sample.value, z, y, 0.0, x, 0.0, 0.0, 0.0]
    };
    let mut jets: Vec<Jet> = known.samples.par_iter().map(from_foot).collect();
    let twists: Vec<[f64; 3]> = (0..jets.len() as u32)
        .into_par_iter()
        .map(|corner| {
            [(1, 2), (0, 2), (0, 1)].map(|(a, b)| {
                let ab = known.along(corner, a, |other| jets[other as usize][AXIS_BIT[b]]);
                let ba = known.along(corner, b, |other| jets[other as usize][AXIS_BIT[a]]);
                0.5 * (ab + ba)
            })
        })
        .collect();
    jets.par_iter_mut().enumerate().for_each(|(corner, jet)| {
        let [yz, xz, xy] = twists[corner];
        let triple: f64 = (0..3).map(|axis| known.along(corner as u32, axis, |c| twists[c as usize][axis])).sum();
        (jet[3], jet[5], jet[6], jet[7]) = (yz, xz, xy, triple / 3.0);
        *jet = stored(*jet);
    });
    jets
}

/// Rounded as it will be stored, so that hanging corners follow what is stored.
fn stored(jet: Jet) -> Jet {
    jet.map(|number| f64::from(number as f32))
}

/// Gives every hanging corner the jet of the coarsest leaf it hangs on, of equally coarse ones the first. `at` tells
/// the corner at a point, if there is one.
fn hang(
    leaves: &[[u32; 8]],
    cells: &[Cell],
    coarse_first: &[u32],
    at: impl Fn([u32; 3]) -> Option<u32> + Sync,
    step: f64,
    jets: &mut [Jet],
) {
    let mut done = vec![false; jets.len()];
    // No corner of a leaf hangs on one of its own size, so those take their jets from what is final.
    for alike in coarse_first.chunk_by(|&a, &b| cells[a as usize].size == cells[b as usize].size) {
        for some in alike.chunks(HANGING_AT_ONCE) {
            let hanging: Vec<(u32, Jet)> = some
                .par_iter()
                .filter(|leaf| cells[**leaf as usize].size > 1)
                .flat_map_iter(|&leaf| {
                    let cell = &cells[leaf as usize];
                    let patch = Patch {
                        corners: leaves[leaf as usize].map(|corner| jets[corner as usize]),
                        edge: f64::from(cell.size) * step,
                    };
                    let (at, done) = (&at, &done);
                    middles_of(cell).filter_map(move |(halves, place)| {
                        let corner = at(place).filter(|&corner| !done[corner as usize])?;
                        Some((corner, stored(patch.jet(halves.map(|h| f64::from(h) * 0.5)))))
                    })
                })
                .collect();
            for (corner, jet) in hanging {
                if !std::mem::replace(&mut done[corner as usize], true) {
                    jets[corner as usize] = jet;
                }
            }
        }
    }
}
