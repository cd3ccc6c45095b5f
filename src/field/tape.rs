//! Programs compiled for batches: one instruction after another over a few registers of many lanes.

use glam::DVec3;

use super::leaf::Quadric;
use super::op::{Binary, Op, Unary};
use super::program::Program;

/// What an instruction computes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Code {
    /// An affine form of the position, by its row.
    Affine(u32),
    /// A sum of squares, by its place in the tape.
    Quadric(u32),
    /// What another field answered for the whole batch.
    Input(u32),
    Unary(Unary),
    Binary(Binary),
    /// The second argument where the first is not 0, else the third.
    Choose,
}

/// One instruction; `out` is never one of its arguments.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instruction {
    pub code: Code,
    pub out: u32,
    pub a: u32,
    pub b: u32,
    pub c: u32,
}

/// A sum of squares around an origin: `constant + Σ sign · (row · (x, y, z, 1))²`.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneQuadric {
    pub rows: [[f32; 4]; 3],
    pub signs: [f32; 3],
    pub constant: f32,
    pub shape: QuadricShape,
}

/// Which loop a sum of squares takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum QuadricShape {
    /// The squared distance from a point, or less it: terms of one sign, each along another axis, of slope 1.
    Ball,
    /// Terms of one sign, each along another axis, of which it is the axis' row; zeros where there is none.
    Aligned,
    /// Anything else.
    General,
}

/// A compiled program. Its memory is kept when it is compiled anew.
#[derive(Default)]
pub(super) struct Tape {
    pub code: Vec<Instruction>,
    /// Rows and sums around the origin last asked for.
    pub rows: Vec<[f32; 4]>,
    pub quadrics: Vec<LaneQuadric>,
    /// The register of each output.
    pub outputs: Vec<u32>,
    pub registers: usize,
    affine_leaves: Vec<u32>,
    quadric_leaves: Vec<u32>,
    origin: Option<DVec3>,
    last_use: Vec<u32>,
    places: Vec<u32>,
    free: Vec<u32>,
}

/// Never used again.
const DEAD: u32 = u32::MAX;

impl Tape {
    /// Compiles the operations that some outputs need.
    pub fn compile(&mut self, ops: &[Op], outputs: &[u32]) {
        self.code.clear();
        self.outputs.clear();
        self.affine_leaves.clear();
        self.quadric_leaves.clear();
        self.origin = None;
        self.find_last_uses(ops, outputs);
        self.places.clear();
        self.free.clear();
        let mut registers = 0;
        for (index, &op) in ops.iter().enumerate() {
            let index = index as u32;
            self.places.push(DEAD);
            if self.last_use[index as usize] == DEAD {
                continue;
            }
            // The output takes its register before the arguments give theirs back, so they never alias.
            let out = self.free.pop().unwrap_or_else(|| {
                registers += 1;
                registers - 1
            });
            self.places[index as usize] = out;
            self.emit(op, out);
            if !matches!(op, Op::External { .. }) {
                let (places, free, last_use) = (&self.places, &mut self.free, &mut self.last_use);
                op.arguments(|argument| {
                    if last_use[argument as usize] == index {
                        free.push(places[argument as usize]);
                        last_use[argument as usize] = DEAD;
                    }
                });
            }
        }
        self.outputs.extend(outputs.iter().map(|&output| self.places[output as usize]));
        self.registers = registers as usize;
    }

    /// The last operation that reads each needed one; outputs are read at the end.
    fn find_last_uses(&mut self, ops: &[Op], outputs: &[u32]) {
        self.last_use.clear();
        self.last_use.resize(ops.len(), DEAD);
        for &output in outputs {
            self.last_use[output as usize] = ops.len() as u32;
        }
        for (index, op) in ops.iter().enumerate().rev() {
            if self.last_use[index] == DEAD || matches!(op, Op::External { .. }) {
                continue;
            }
            let last_use = &mut self.last_use;
            op.arguments(|argument| {
                let slot = &mut last_use[argument as usize];
                if *slot == DEAD {
                    *slot = index as u32;
                }
            });
        }
    }

    fn emit(&mut self, op: Op, out: u32) {
        let place = |argument: u32| self.places[argument as usize];
        let (code, [a, b, c]) = match op {
            Op::Affine(leaf) => {
                self.affine_leaves.push(leaf);
                (Code::Affine(self.affine_leaves.len() as u32 - 1), [0; 3])
            }
            Op::Quadric(leaf) => {
                self.quadric_leaves.push(leaf);
                (Code::Quadric(self.quadric_leaves.len() as u32 - 1), [0; 3])
            }
            Op::External { leaf, .. } => (Code::Input(leaf), [0; 3]),
            Op::Unary(operation, a) => (Code::Unary(operation), [place(a), 0, 0]),
            Op::Binary(operation, a, b) => (Code::Binary(operation), [place(a), place(b), 0]),
            Op::Choose(arguments) => (Code::Choose, arguments.map(place)),
        };
        self.code.push(Instruction { code, out, a, b, c });
    }

    /// Rounds the leaves to `f32` around an origin, unless that is where they are.
    pub fn settle(&mut self, program: &Program, origin: DVec3) {
        if self.origin == Some(origin) {
            return;
        }
        self.origin = Some(origin);
        self.rows.clear();
        self.rows.extend(self.affine_leaves.iter().map(|&leaf| program.affines[leaf as usize].around(origin)));
        self.quadrics.clear();
        let lane_quadric = |&leaf: &u32| LaneQuadric::new(&program.quadrics[leaf as usize], origin);
        self.quadrics.extend(self.quadric_leaves.iter().map(lane_quadric));
    }
}

impl LaneQuadric {
    fn new(quadric: &Quadric, origin: DVec3) -> Self {
        let rows = quadric.terms.map(|(weight, form)| form.linear(weight.abs().sqrt(), 0.0).around(origin));
        let signs = quadric.terms.map(|(weight, _)| if weight < 0.0 { -1.0 } else { 1.0 });
        let used = quadric.terms.map(|(weight, _)| weight != 0.0);
        let constant = quadric.constant as f32;
        match Self::by_axis(rows, signs, used) {
            Some(rows) => {
                let is_ball = (0..3).all(|axis| rows[axis][axis] == 1.0);
                let shape = if is_ball { QuadricShape::Ball } else { QuadricShape::Aligned };
                Self { rows, signs: [signs[0]; 3], constant, shape }
            }
            None => Self { rows, signs, constant, shape: QuadricShape::General },
        }
    }

    /// The rows of the terms that are used by the axis that each is along; none where two are along one, one is along
    /// none, or their signs differ.
    fn by_axis(rows: [[f32; 4]; 3], signs: [f32; 3], used: [bool; 3]) -> Option<[[f32; 4]; 3]> {
        let mut by_axis = [[0.0; 4]; 3];
        let mut taken = [false; 3];
        for (term, row) in rows.into_iter().enumerate().filter(|&(term, _)| used[term]) {
            let axis = (0..3).find(|&axis| (0..3).all(|i| (row[i] != 0.0) == (i == axis)))?;
            if std::mem::replace(&mut taken[axis], true) || signs[term] != signs[0] {
                return None;
            }
            by_axis[axis] = row;
        }
        Some(by_axis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::leaf::Affine;

    #[test]
    fn squares_along_the_axes_take_the_short_way() {
        let sum = |terms: &[(f64, DVec3)]| {
            let square = |&(weight, slope): &(f64, DVec3)| Quadric::square(Affine::new(slope, 0.5)).linear(weight, 0.0);
            let sum = terms.iter().map(square).reduce(|a, b| a.plus(&b).unwrap()).unwrap();
            LaneQuadric::new(&sum, DVec3::new(1.0, 2.0, 3.0))
        };
        let [x, y, z] = DVec3::AXES;
        assert_eq!(sum(&[(-4.0, y)]).rows, [[0.0; 4], [0.0, 2.0, 0.0, 5.0], [0.0; 4]]);
        for ball in [[(1.0, x), (1.0, y), (1.0, z)], [(-1.0, z), (-1.0, x), (-1.0, y)]] {
            assert_eq!(sum(&ball).shape, QuadricShape::Ball);
        }
        for aligned in [&[(1.0, x), (1.0, y), (2.0, z)][..], &[(-1.0, z), (-2.0, x)], &[(1.0, x), (1.0, y)]] {
            assert_eq!(sum(aligned).shape, QuadricShape::Aligned);
        }
        for general in [&[(1.0, x), (-1.0, y)][..], &[(1.0, x), (2.0, x)], &[(1.0, x + y)]] {
            assert_eq!(sum(general).shape, QuadricShape::General);
        }
    }
}
