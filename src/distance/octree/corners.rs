//! From cells and samples to the jets at corners: mixed derivatives by differences between neighbours, hanging
//! corners from the coarser cell they lie on.
//!
//! A corner *hangs* when a leaf that it touches does not have it as a corner. It then takes its whole jet from
//! that leaf's patch, which makes the spline C¹ across the change of size: on the shared face both patches have
//! the same bicubic value and the same bicubic normal derivative (the space of PHT splines, Deng et al. 2008).

use rayon::prelude::*;

use super::hanging::{Hanging, hanging};
use super::patch::{AXIS_BIT, Jet, Patch};
use super::samples::Samples;
use super::tree::{Cell, NONE, Tree};

/// Hanging corners worked out at once: enough to share, few enough to hold.
const HANGING_AT_ONCE: usize = 1 << 16;

/// A corner's jet, rounded as it is kept.
pub type Numbers = [f32; 8];

/// The leaves in Morton order with their corners.
pub struct Corners {
    /// Every leaf's corners.
    pub leaves: Vec<[u32; 8]>,
    /// The numbers of each corner.
    pub numbers: Vec<Numbers>,
    /// How many corners hang.
    pub hanging: usize,
    /// The number of each corner's sample.
    samples: Vec<u32>,
}

/// The nearest corner along an axis to one side, and how often the way there doubles a smallest cell.
#[derive(Clone, Copy)]
struct Beside {
    corner: u32,
    level: u8,
}

const NOTHING: Beside = Beside { corner: NONE, level: u8::MAX };

/// What is known of each corner.
struct Known {
    /// The number of its sample.
    samples: Vec<u32>,
    /// By axis: what lies below and above.
    beside: [Vec<[Beside; 2]>; 3],
    step: f64,
}

impl Known {
    /// The derivative along an axis of something known at corners, from three corners, or two at the border.
    fn along(&self, corner: u32, axis: usize, of: impl Fn(u32) -> f64) -> f64 {
        let [below, above] = self.beside[axis][corner as usize];
        let side = |Beside { corner: other, level }: Beside| {
            (other != NONE).then(|| {
                let gap = f64::from(1_u32 << level) * self.step;
                (gap, (of(other) - of(corner)) / gap)
            })
        };
        between(side(below), side(above))
    }
}

/// The slope at a corner from what lies below and above it, each by how far that is and by the slope from there: that of the
/// parabola through all three, or the one there is at the border.
pub fn between(below: Option<(f64, f64)>, above: Option<(f64, f64)>) -> f64 {
    match (below, above) {
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

/// Numbers the corners of the leaves and works out their jets. `nodes` are those of the finished object, `order` the tree's
/// nodes that are leaves there; `step` is the smallest cell's edge.
pub fn corners(tree: &Tree, nodes: &[u32], order: &[u32], samples: &Samples, step: f64) -> Corners {
    let cells: Vec<Cell> = order.par_iter().map(|&node| tree.cells[node as usize]).collect();
    // Every corner has a sample, which tells corners that are the same.
    let mut leaves: Vec<[u32; 8]> = order.par_iter().map(|&node| tree.corners[node as usize]).collect();
    let mut numbers = vec![NONE; samples.len()];
    let mut of_corners = Vec::with_capacity(samples.len());
    for sample in leaves.as_flattened_mut() {
        let number = &mut numbers[*sample as usize];
        if *number == NONE {
            *number = of_corners.len() as u32;
            of_corners.push(*sample);
        }
        *sample = *number;
    }
    let known = Known { beside: beside(&leaves, &cells, of_corners.len()), samples: of_corners, step };
    let mut numbers = free_jets(&known, samples);
    let hanging = hang(&leaves, nodes, &cells, step, &mut numbers);
    Corners { leaves, numbers, hanging, samples: known.samples }
}

impl Corners {
    /// Gives corners that hang their own values back.
    pub fn forget_hanging(&mut self, samples: &Samples) {
        for (numbers, &sample) in self.numbers.iter_mut().zip(&self.samples) {
            numbers[0] = samples.numbered(sample).value as f32;
        }
    }

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

/// What lies beside each corner, by axis: below and above.
fn beside(leaves: &[[u32; 8]], cells: &[Cell], corners: usize) -> [Vec<[Beside; 2]>; 3] {
    let mut beside = [(); 3].map(|()| vec![[NOTHING; 2]; corners]);
    beside.par_iter_mut().zip(AXIS_BIT).for_each(|(beside, bit)| {
        // The nearest neighbour is that of the smallest leaf.
        let mut meet = |corner: u32, side: usize, other: u32, level: u8| {
            let known = &mut beside[corner as usize][side];
            if level < known.level {
                *known = Beside { corner: other, level };
            }
        };
        for (corners, cell) in leaves.iter().zip(cells) {
            let level = cell.size.trailing_zeros() as u8;
            for low in (0..8).filter(|corner| corner & bit == 0) {
                let (a, b) = (corners[low], corners[low | bit]);
                meet(a, 1, b, level);
                meet(b, 0, a, level);
            }
        }
    });
    beside
}

/// Jets as if no corner hung: value and gradient from the foot, mixed derivatives from differences.
fn free_jets(known: &Known, samples: &Samples) -> Vec<Numbers> {
    let gradients: Vec<[f64; 3]> = known.samples.par_iter().map(|&sample| samples.numbered(sample).gradient).collect();
    let corners = (0..gradients.len() as u32).into_par_iter();
    let twist = |corner: u32| {
        [(1, 2), (0, 2), (0, 1)].map(|(a, b)| {
            let ab = known.along(corner, a, |other| gradients[other as usize][b]);
            let ba = known.along(corner, b, |other| gradients[other as usize][a]);
            0.5 * (ab + ba)
        })
    };
    let twists: Vec<[f64; 3]> = corners.clone().map(twist).collect();
    let free = |corner: u32| {
        let value = samples.numbered(known.samples[corner as usize]).value;
        let ([x, y, z], [yz, xz, xy]) = (gradients[corner as usize], twists[corner as usize]);
        let triple: f64 = (0..3).map(|axis| known.along(corner, axis, |c| twists[c as usize][axis])).sum();
        rounded([value, z, y, yz, x, xz, xy, triple / 3.0])
    };
    corners.map(free).collect()
}

/// Gives every hanging corner the jet of the leaf it hangs on. Returns how many there are.
fn hang(leaves: &[[u32; 8]], nodes: &[u32], cells: &[Cell], step: f64, numbers: &mut [Numbers]) -> usize {
    let mut count = 0;
    // What is kept is followed, not what it was rounded from. Coarse leaves first: no corner of a leaf hangs on one of its
    // own size, so those take their jets from what is final.
    for alike in hanging(nodes, leaves) {
        count += alike.len();
        for some in alike.chunks(HANGING_AT_ONCE) {
            let followed = |hanging: &Hanging| {
                let leaf = hanging.leaf as usize;
                let corners = leaves[leaf].map(|corner| jet(&numbers[corner as usize]));
                let patch = Patch { corners, edge: f64::from(cells[leaf].size) * step };
                rounded(patch.jet(hanging.halves.map(|h| f64::from(h) * 0.5)))
            };
            let found: Vec<Numbers> = some.par_iter().map(followed).collect();
            for (hanging, found) in some.iter().zip(found) {
                numbers[hanging.corner as usize] = found;
            }
        }
    }
    count
}
