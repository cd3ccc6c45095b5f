//! Choices before roots: √a ∨ √b is √(a ∨ b), and r − √a ∨ r − √b is r − √(a ∧ b).
//!
//! The distance of a union of balls takes one root so, and each ball half of the operations to bound and to evaluate. Each
//! step keeps order as it is rounded too, so every value stays what it is to the last bit.

use super::op::{Binary, Op, Unary};
use super::program::Program;

/// The program with its choices among values that one operation was made of taken before that.
pub(super) fn chosen_first(program: &Program) -> Program {
    let mut rewritten = Rewritten::default();
    let mut places: Vec<u32> = Vec::with_capacity(program.ops.len());
    for op in &program.ops {
        let place = match op.renamed(|argument| places[argument as usize]) {
            Op::Binary(side @ (Binary::Min | Binary::Max), a, b) => rewritten.choose(program, side, a, b),
            op => rewritten.push(program, op),
        };
        places.push(place);
    }
    Program {
        ops: places.last().map(|root| needed_for(&rewritten.ops, *root)).unwrap_or_default(),
        affines: program.affines.clone(),
        quadrics: program.quadrics.clone(),
        externals: program.externals.clone(),
    }
}

#[derive(Default)]
struct Rewritten {
    ops: Vec<Op>,
    /// Which of them are sums and roots of squares, or chosen from such.
    is_root_of_squares: Vec<bool>,
}

impl Rewritten {
    fn push(&mut self, program: &Program, op: Op) -> u32 {
        let is = |argument: u32| self.is_root_of_squares[argument as usize];
        self.is_root_of_squares.push(match op {
            Op::Quadric(leaf) => program.quadrics[leaf as usize].root_slope().is_some(),
            Op::Unary(Unary::Sqrt, a) => is(a),
            Op::Binary(Binary::Min | Binary::Max, a, b) => is(a) && is(b),
            _ => false,
        });
        self.ops.push(op);
        self.ops.len() as u32 - 1
    }

    fn choose(&mut self, program: &Program, side: Binary, a: u32, b: u32) -> u32 {
        match (self.ops[a as usize], self.ops[b as usize]) {
            (Op::Unary(operation, a), Op::Unary(other, b)) if operation == other && self.keeps_order(operation, a, b) => {
                let falls = matches!(operation, Unary::Linear { scale, .. } if scale < 0.0);
                let side = match side {
                    Binary::Min if falls => Binary::Max,
                    Binary::Max if falls => Binary::Min,
                    _ => side,
                };
                let chosen = self.choose(program, side, a, b);
                self.push(program, Op::Unary(operation, chosen))
            }
            _ => self.push(program, Op::Binary(side, a, b)),
        }
    }

    /// Whether an operation rises, or falls, with its argument between two. The root of what may be negative does not: it
    /// may be no number.
    fn keeps_order(&self, operation: Unary, a: u32, b: u32) -> bool {
        match operation {
            Unary::Linear { .. } => true,
            Unary::Sqrt => [a, b].iter().all(|argument| self.is_root_of_squares[*argument as usize]),
            _ => false,
        }
    }
}

/// The operations that one depends on, which comes last.
fn needed_for(ops: &[Op], root: u32) -> Vec<Op> {
    let mut needed = vec![false; root as usize + 1];
    needed[root as usize] = true;
    for index in (0..needed.len()).rev() {
        if needed[index] {
            ops[index].arguments(|argument| needed[argument as usize] = true);
        }
    }
    let (mut kept, mut places) = (Vec::new(), vec![u32::MAX; needed.len()]);
    for (index, op) in ops[..needed.len()].iter().enumerate().filter(|(index, _)| needed[*index]) {
        places[index] = kept.len() as u32;
        kept.push(op.renamed(|argument| places[argument as usize]));
    }
    kept
}
