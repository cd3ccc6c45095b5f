//! The smooth branches of a program: the operands below its set operations, each with its creases resolved.
//!
//! An operand may hold creases of its own, `|·|`, min or max under arithmetic. Each of them is replaced by one of
//! its two sides, every combination that says something else being a branch, as long as these are few; an operand with
//! more is taken as smooth. R₀ operations under arithmetic are smooth but at points, and so is the outside of a corner.

use super::op::{Binary, Op, Unary};

/// An operand of more branches than this is taken as smooth: pairs and triples of them explode.
const MOST_SIDES: usize = 16;
/// As many bits as there are for sides.
const MOST_CREASES: usize = 32;
/// Choices of sides that are looked at, at most, for one operand.
const MOST_CHOICES: usize = 256;

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
    /// The operand as it is.
    Whole,
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
    visited: Vec<bool>,
    /// Sides chosen so far, and of which creases.
    choices: Vec<[u32; 2]>,
    /// What each choice says: see [`Self::say`].
    said: Vec<Vec<Said>>,
}

/// What an argument, by its operation, is once sides are chosen: an operation, or that negated.
type Said = (u32, u32, bool);

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
            // What is met twice has one zero set, and all below it is listed already: however often it is shared.
            if std::mem::replace(&mut self.seen[index as usize], true) {
                continue;
            }
            match ops[index as usize] {
                Op::Unary(Unary::Linear { scale, offset: 0.0 }, a) => self.stack.push((a, factor * scale)),
                Op::Binary(operation, a, b) if operation.nature().set.is_some() => {
                    self.stack.push((b, factor));
                    self.stack.push((a, factor));
                }
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
                    let found = self.find_sides(ops, index, &zero);
                    let parts = found.iter().flatten().map(|bits| Part::Sides(*bits));
                    let whole = found.is_none().then_some(Part::Whole);
                    self.list.extend(parts.chain(whole).map(|part| Branch { op: index, factor, part }));
                }
            }
        }
    }

    /// The creases of one operand, in order.
    fn find_creases(&mut self, ops: &[Op], operand: u32, zero: &impl Fn(u32) -> bool) {
        self.creases.clear();
        self.walk.clear();
        self.walk.push(operand);
        self.visited.clear();
        self.visited.resize(ops.len(), false);
        while let Some(index) = self.walk.pop() {
            if std::mem::replace(&mut self.visited[index as usize], true) {
                continue;
            }
            let op = ops[index as usize];
            match op {
                Op::External { .. } => continue,
                _ if op.nature().creases => self.creases.push(index),
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

    /// The choices of sides that make an operand something else each, in order; `None` where it has no creases, or too
    /// many. Below a min or max the creases of the side that is not chosen make no difference, nor do two that come to
    /// the same.
    fn find_sides(&mut self, ops: &[Op], operand: u32, zero: &impl Fn(u32) -> bool) -> Option<Vec<u32>> {
        if self.creases.is_empty() || self.creases.len() > MOST_CREASES {
            return None;
        }
        self.said.clear();
        self.choices.clear();
        self.choices.push([0, 0]);
        let (mut sides, mut looked_at) = (Vec::new(), 0);
        while let Some([bits, chosen]) = self.choices.pop() {
            looked_at += 1;
            let mut said = Vec::new();
            match self.say(ops, operand, [bits, chosen], zero, &mut said) {
                Some(open) => self.choices.extend([[bits | open, chosen | open], [bits, chosen | open]]),
                None if self.said.contains(&said) => {}
                None => {
                    self.said.push(said);
                    sides.push(bits);
                }
            }
            if sides.len() > MOST_SIDES || looked_at > MOST_CHOICES {
                return None;
            }
        }
        sides.sort_unstable();
        Some(sides)
    }

    /// What the arguments that are creases are by the sides chosen; or the bit of one that matters and has no side yet.
    fn say(
        &mut self,
        ops: &[Op],
        operand: u32,
        [bits, chosen]: [u32; 2],
        zero: &impl Fn(u32) -> bool,
        said: &mut Vec<Said>,
    ) -> Option<u32> {
        let Self { creases, walk, visited, .. } = self;
        visited.clear();
        visited.resize(ops.len(), false);
        walk.clear();
        walk.push(operand);
        while let Some(entry) = walk.pop() {
            if std::mem::replace(&mut visited[entry as usize], true) {
                continue;
            }
            let (mut index, mut negated) = (entry, false);
            while let Ok(place) = creases.binary_search(&index) {
                let bit = 1 << place;
                if chosen & bit == 0 {
                    return Some(bit);
                }
                let side;
                (side, index) = side_of(ops[index as usize], bits & bit != 0)?;
                negated ^= side < 0.0;
            }
            if index != entry {
                said.push((entry, index, negated));
            }
            let op = ops[index as usize];
            match smooth_square_of_positive_part(ops, op, zero) {
                Some(inside) => walk.push(inside),
                None if matches!(op, Op::External { .. }) => {}
                None => op.arguments(|argument| walk.push(argument)),
            }
        }
        said.sort_unstable();
        None
    }

    /// Writes the program with one operand's creases replaced by the sides of a branch.
    pub fn resolve(&mut self, ops: &[Op], branch: Branch, zero: impl Fn(u32) -> bool, out: &mut Vec<Op>) {
        out.clear();
        out.extend_from_slice(ops);
        let Part::Sides(bits) = branch.part else { return };
        self.find_creases(ops, branch.op, &zero);
        for (bit, &crease) in self.creases.iter().enumerate() {
            if let Some((scale, side)) = side_of(ops[crease as usize], bits >> bit & 1 == 1) {
                out[crease as usize] = Op::Unary(Unary::Linear { scale, offset: 0.0 }, side);
            }
        }
    }
}

/// What a crease is on one of its sides: a factor, and an operation.
fn side_of(crease: Op, second: bool) -> Option<(f64, u32)> {
    match crease {
        Op::Binary(_, a, b) => Some((1.0, if second { b } else { a })),
        Op::Unary(_, a) => Some((if second { -1.0 } else { 1.0 }, a)),
        _ => None,
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
