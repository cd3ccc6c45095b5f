//! The smooth branches of a program: the operands below its set operations, each with its creases resolved.
//!
//! An operand may hold creases of its own, `|·|`, min or max under arithmetic. Each of them is replaced by one of
//! its two sides, every combination being a branch, as long as there are few; an operand with more is taken as
//! smooth. R₀ operations under arithmetic are smooth but at points, and so is the outside of a corner.

use super::op::{Binary, Op, Unary};

/// More creases than this in one operand, and it is taken as smooth: their number doubles with each.
const MOST_CREASES: usize = 4;

/// One smooth branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Branch {
    /// The operand.
    pub op: u32,
    /// What the value is multiplied by on the way to the root: negations and constant factors.
    pub factor: f64,
    /// Which branch of the operand.
    pub part: Part,
}

/// A branch within an operand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    /// The operand with its creases replaced by their first (bit 0) or second side; bits from the first crease.
    Sides(u32),
    /// A branch of another field.
    External(u32),
}

/// The branches of a program and the scratch memory to list them.
#[derive(Default)]
pub(super) struct Branches {
    pub list: Vec<Branch>,
    stack: Vec<(u32, f64)>,
    seen: Vec<bool>,
    creases: Vec<u32>,
    walk: Vec<u32>,
}

fn is_constant_zero(op: Op, zero: impl Fn(u32) -> bool) -> bool {
    matches!(op, Op::Affine(leaf) if zero(leaf))
}

impl Branches {
    /// Lists the branches of the last operation. `inner` counts those of an external field read
    /// at given values; `zero` tells whether
    /// an affine leaf is the constant zero.
    pub fn find(&mut self, ops: &[Op], inner: impl Fn(u32, [u32; 3]) -> usize, zero: impl Fn(u32) -> bool) {
        self.list.clear();
        self.seen.clear();
        self.seen.resize(ops.len(), false);
        self.stack.clear();
        self.stack.push((ops.len() as u32 - 1, 1.0));
        while let Some((index, factor)) = self.stack.pop() {
            match ops[index as usize] {
                Op::Unary(Unary::Linear { scale, offset: 0.0 }, a) => self.stack.push((a, factor * scale)),
                Op::Binary(operation, a, b) if operation.is_set_operation() => {
                    self.stack.push((b, factor));
                    self.stack.push((a, factor));
                }
                // An operand met twice has one zero set.
                _ if std::mem::replace(&mut self.seen[index as usize], true) => {}
                Op::External { leaf, at } => {
                    let parts = (0..inner(leaf, at) as u32).map(|part| Branch {
                        op: index,
                        factor,
                        part: Part::External(part),
                    });
                    self.list.extend(parts);
                }
                _ => {
                    self.find_creases(ops, index, &zero);
                    let creases = self.creases.len();
                    let sides = if creases > MOST_CREASES { 1 } else { 1 << creases };
                    self.list.extend((0..sides).map(|bits| Branch { op: index, factor, part: Part::Sides(bits) }));
                }
            }
        }
    }

    /// The creases of one operand, in order.
    fn find_creases(&mut self, ops: &[Op], operand: u32, zero: &impl Fn(u32) -> bool) {
        self.creases.clear();
        self.walk.clear();
        self.walk.push(operand);
        while let Some(index) = self.walk.pop() {
            let op = ops[index as usize];
            match op {
                Op::External { .. } => continue,
                Op::Unary(Unary::Abs, _) | Op::Binary(Binary::Min | Binary::Max, ..)
                    if !self.creases.contains(&index) =>
                {
                    self.creases.push(index);
                }
                _ => {}
            }
            match smooth_square_of_positive_part(ops, op, zero) {
                Some(inside) => self.walk.push(inside),
                None => op.arguments(|argument| self.walk.push(argument)),
            }
            if self.creases.len() > MOST_CREASES {
                return;
            }
        }
        self.creases.sort_unstable();
    }

    /// Writes the program with one operand's creases replaced by the sides of a branch.
    pub fn resolve(&mut self, ops: &[Op], branch: Branch, zero: impl Fn(u32) -> bool, out: &mut Vec<Op>) {
        out.clear();
        out.extend_from_slice(ops);
        let Part::Sides(bits) = branch.part else { return };
        self.find_creases(ops, branch.op, &zero);
        if self.creases.len() > MOST_CREASES {
            return;
        }
        for (bit, &crease) in self.creases.iter().enumerate() {
            let second = bits >> bit & 1 == 1;
            let (scale, side) = match ops[crease as usize] {
                Op::Binary(_, a, b) => (1.0, if second { b } else { a }),
                Op::Unary(_, a) => (if second { -1.0 } else { 1.0 }, a),
                _ => continue,
            };
            out[crease as usize] = Op::Unary(Unary::Linear { scale, offset: 0.0 }, side);
        }
    }
}

/// For `(k·max(v, 0))²`, which is smooth where `max` is not: the place of v.
fn smooth_square_of_positive_part(ops: &[Op], op: Op, zero: &impl Fn(u32) -> bool) -> Option<u32> {
    let Op::Unary(Unary::Square, mut inside) = op else { return None };
    while let Op::Unary(Unary::Linear { offset: 0.0, .. }, value) = ops[inside as usize] {
        inside = value;
    }
    let Op::Binary(Binary::Max, a, b) = ops[inside as usize] else { return None };
    if is_constant_zero(ops[b as usize], zero) { Some(a) } else { is_constant_zero(ops[a as usize], zero).then_some(b) }
}
