//! One expression taken out of its graph: operations in the order of evaluation, with what they read.

use std::sync::Arc;

use glam::DVec3;

use super::graph::{Graph, Node};
use super::interval::Intervals;
use super::leaf::{Affine, Quadric};
use super::op::{Op, choose};
use super::{Aabb, Evaluator, Field, Interval};

/// Operations, arguments first, the root last.
pub(super) struct Program {
    pub ops: Vec<Op>,
    pub affines: Vec<Affine>,
    pub quadrics: Vec<Quadric>,
    /// The fields read, one for each external operation: `Op::External::leaf` is an index here.
    pub externals: Vec<Arc<dyn Field>>,
}

/// How many values wait at most while a node is computed, its heavier argument first (Sethi and Ullman's number).
fn registers_needed(graph: &Graph, reached: &[u32]) -> Vec<u32> {
    let mut needed = vec![0; graph.ops.len()];
    for &index in reached {
        needed[index as usize] = match graph.ops[index as usize] {
            Op::Affine(_) | Op::Quadric(_) => 1,
            Op::External { at, .. } | Op::Choose(at) => {
                2 + at.map(|a| needed[a as usize]).into_iter().max().unwrap_or(0)
            }
            Op::Unary(_, a) => needed[a as usize],
            Op::Binary(_, a, b) => {
                let (a, b) = (needed[a as usize], needed[b as usize]);
                if a == b { a + 1 } else { a.max(b) }
            }
        };
    }
    needed
}

impl Program {
    pub fn new(graph: &Graph, root: Node) -> Self {
        let mut seen = vec![false; graph.ops.len()];
        let mut stack = vec![root.0];
        let mut reached = Vec::new();
        while let Some(index) = stack.pop() {
            if !std::mem::replace(&mut seen[index as usize], true) {
                reached.push(index);
                graph.ops[index as usize].arguments(|argument| stack.push(argument));
            }
        }
        reached.sort_unstable();
        let needed = registers_needed(graph, &reached);

        let mut program = Self { ops: Vec::new(), affines: Vec::new(), quadrics: Vec::new(), externals: Vec::new() };
        let mut place = vec![u32::MAX; graph.ops.len()];
        // Depth first, the heavier argument first, so that few values wait.
        let mut stack = vec![(root.0, false)];
        while let Some((index, ready)) = stack.pop() {
            if place[index as usize] != u32::MAX {
                continue;
            }
            let op = graph.ops[index as usize];
            if ready {
                place[index as usize] = program.ops.len() as u32;
                program.push(op.renamed(|argument| place[argument as usize]), graph);
                continue;
            }
            stack.push((index, true));
            let first = stack.len();
            op.arguments(|argument| stack.push((argument, false)));
            stack[first..].sort_by_key(|(argument, _)| needed[*argument as usize]);
        }
        program
    }

    fn push(&mut self, op: Op, graph: &Graph) {
        self.ops.push(match op {
            Op::Affine(leaf) => {
                self.affines.push(graph.affines[leaf as usize]);
                Op::Affine(self.affines.len() as u32 - 1)
            }
            Op::Quadric(leaf) => {
                self.quadrics.push(graph.quadrics[leaf as usize]);
                Op::Quadric(self.quadrics.len() as u32 - 1)
            }
            Op::External { leaf, at } => {
                self.externals.push(graph.externals[leaf as usize].clone());
                Op::External { leaf: self.externals.len() as u32 - 1, at }
            }
            other => other,
        });
    }

    /// Whether values may jump.
    pub fn jumps(&self) -> bool {
        let jump = |op: &Op| {
            op.nature().jumps || matches!(op, Op::External { leaf, .. } if self.externals[*leaf as usize].jumps())
        };
        self.ops.iter().any(jump)
    }

    /// F in plain `f64` arithmetic.
    pub fn reference(&self, position: DVec3) -> f64 {
        let mut values = Vec::with_capacity(self.ops.len());
        for op in &self.ops {
            let value = match *op {
                Op::Affine(leaf) => self.affines[leaf as usize].at(position),
                Op::Quadric(leaf) => self.quadrics[leaf as usize].at(position),
                Op::External { leaf, at } => {
                    let [x, y, z] = at.map(|argument| values[argument as usize]);
                    self.externals[leaf as usize].reference(DVec3::new(x, y, z))
                }
                Op::Unary(operation, a) => operation.value([values[a as usize]]),
                Op::Binary(operation, a, b) => operation.value([values[a as usize], values[b as usize]]),
                Op::Choose(at) => choose::value(at.map(|argument| values[argument as usize])),
            };
            values.push(value);
        }
        values.last().copied().unwrap_or(f64::NAN)
    }

    /// Bounds of each of some operations over a box, into `bounds`. External fields enter the box they are read
    /// in, and stay there: leaving them is the caller's. They are `asked` for their bounds, or taken to have none.
    pub fn bound(
        &self,
        ops: &[Op],
        region: &Aabb,
        asked: bool,
        externals: &mut [Box<dyn Evaluator + '_>],
        bounds: &mut Intervals,
    ) {
        bounds.clear();
        for op in ops {
            let bound = match *op {
                Op::Affine(leaf) => self.affines[leaf as usize].bounds(region),
                Op::Quadric(leaf) => self.quadrics[leaf as usize].bounds(region),
                Op::External { leaf, at } => {
                    let [x, y, z] = at.map(|argument| bounds.at(argument));
                    let read = Aabb::new(DVec3::new(x.lo, y.lo, z.lo), DVec3::new(x.hi, y.hi, z.hi));
                    let external = &mut externals[leaf as usize];
                    external.enter(&read);
                    if asked { external.bounds() } else { Interval::ALL }
                }
                Op::Unary(operation, a) => operation.bounds([bounds.at(a)]),
                Op::Binary(operation, a, b) => operation.bounds([bounds.at(a), bounds.at(b)]),
                Op::Choose(at) => choose::bounds(at.map(|argument| bounds.at(argument))),
            };
            bounds.push(bound);
        }
    }
}
