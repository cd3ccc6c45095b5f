//! Lattices and minimal surfaces whose cells go over from one size to another, by halves.
//!
//! No map of space changes the size of cells by a number and keeps them cells. Instead there are the cells of the largest size, of
//! half of it, of a quarter and so on, of which those stand whose size is next to the wanted one. Lattices of halves share the
//! points of the larger one, so that struts meet. Where the wanted size passes √2 times an octave's, both octaves are there, each
//! thinner the farther it is on the other's side, and joined by a smooth union.

use super::grading::Ends;
use super::spec::{Build, Grading};
use crate::field::{Kernel, Node};
use crate::text::problem::Problem;

/// How far on the other's side an octave ends, of the size at the border: a quarter of an octave. Less: struts end bluntly;
/// more: there are both octaves in more of space.
const BEYOND: f64 = 0.189_207_115_002_721_07;

/// What an octave is made with.
#[derive(Clone, Copy, Debug)]
pub struct Octave {
    /// The edge of its cells.
    pub edge: f64,
    /// Where between both ends the wanted size is that; held to 0 … 1.
    pub share: f64,
    /// By what the length of another size at that share is to be multiplied: 1 unless it is smaller than all that are wanted.
    pub scale: f64,
}

/// The union of all octaves of a structure of some edge, each with its value at its middle. `None` where both ends have one
/// size.
pub fn octaves(
    build: &mut dyn Build,
    grading: &Grading<'_>,
    key: &str,
    make: impl Fn(&mut dyn Build, Octave) -> Result<(Node, f64), Problem>,
) -> Result<Option<Node>, Problem> {
    let size = grading.ends(build, key)?;
    let Ends([from, to]) = size;
    if size.is_same() {
        return Ok(None);
    }
    let (smallest, largest) = (from.min(to), from.max(to));
    grading.are_within_reach(build, key, [smallest, largest])?;
    let graph = build.graph();
    let by = graph.field(grading.by.clone());
    let [zero, one] = [0.0, 1.0].map(|value| graph.constant(value));
    let by = graph.max(by, zero);
    let by = graph.min(by, one);
    let wanted = graph.linear(by, to - from, from);
    let count = libm::log2(largest / smallest).round() as u32;
    let mut all: Option<(Node, f64)> = None;
    for octave in 0..=count {
        let edge = largest / f64::from(1 << octave);
        let share = ((edge - from) / (to - from)).clamp(0.0, 1.0);
        let (node, depth) = make(build, Octave { edge, share, scale: edge / size.at(share) })?;
        let graph = build.graph();
        // How far the wanted size is beyond the borders to the next larger and the next smaller octave, of that at the border.
        let border = |by: f64| 1.0 / (edge * by);
        let above = graph.linear(wanted, border(std::f64::consts::SQRT_2), -1.0);
        let below = graph.linear(wanted, -border(std::f64::consts::FRAC_1_SQRT_2), 1.0);
        let beyond = graph.max(above, below);
        let beyond = graph.max(beyond, zero);
        let thinner = graph.linear(beyond, depth / BEYOND, 0.0);
        let node = graph.sub(node, thinner);
        all = Some(match all {
            Some((before, thick)) => (graph.smooth_max(Kernel::Quadratic, thick.min(depth) / 2.0, before, node), depth),
            None => (node, depth),
        });
    }
    Ok(all.map(|(node, _)| node))
}
